//! The values behind a statement's slash, one after the other.

use super::super::error::{ClProblem, Fault};
use super::super::token::{Placed, Token, first_char};
use crate::geom::{Point, Vector};
use crate::machine::data::nearest;

/// A value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    Number(f64),
    /// As written.
    Word(&'a [u8]),
    /// Between apostrophes.
    Text,
}

/// A reader of values: a cursor over tokens.
#[derive(Clone, Debug)]
pub(super) struct Args<'a> {
    /// The statement's word, for complaints.
    pub word: &'static str,
    text: &'a [u8],
    tokens: &'a [Placed],
}

const COMMA: &str = "a comma and another value, or the statement's end,";

impl<'a> Args<'a> {
    pub fn new(word: &'static str, text: &'a [u8], tokens: &'a [Placed]) -> Args<'a> {
        Args { word, text, tokens }
    }

    /// True when nothing is left.
    pub fn is_empty(&self) -> bool {
        self.tokens.is_empty()
    }

    /// Where the next token stands; the statement's end when there is none.
    pub fn at(&self) -> usize {
        self.tokens.first().map_or(self.text.len(), |t| t.at)
    }

    /// The complaint that something else should stand here.
    pub fn unexpected(&self, wanted: &'static str) -> Fault {
        match self.tokens.first() {
            None => (self.text.len(), ClProblem::Ends { wanted }),
            Some(t) => {
                let found = first_char(self.text.get(t.at..).unwrap_or_default());
                (t.at, ClProblem::Unexpected { found, wanted })
            }
        }
    }

    fn step(&mut self) {
        self.tokens = self.tokens.get(1..).unwrap_or_default();
    }

    /// Takes a mark, if it stands here.
    pub fn take(&mut self, mark: Token) -> bool {
        let here = self.tokens.first().is_some_and(|t| t.token == mark);
        if here {
            self.step();
        }
        here
    }

    /// Takes a mark that must stand here.
    pub fn must(&mut self, mark: Token, wanted: &'static str) -> Result<(), Fault> {
        match self.take(mark) {
            true => Ok(()),
            false => Err(self.unexpected(wanted)),
        }
    }

    /// The value here, and nothing of what follows it.
    fn one(&mut self) -> Result<(usize, Value<'a>), Fault> {
        let Some(t) = self.tokens.first() else {
            return Err(self.unexpected("a value"));
        };
        let value = match t.token {
            Token::Number(v) => Value::Number(v),
            Token::Word(end) => Value::Word(self.text.get(t.at..end).unwrap_or_default()),
            Token::Text(_) => Value::Text,
            _ => return Err(self.unexpected("a value")),
        };
        let at = t.at;
        self.step();
        Ok((at, value))
    }

    /// A word and the slash behind it, taken if both stand here.
    pub fn word_before_slash(&mut self) -> Option<&'a [u8]> {
        match self.tokens {
            [
                Placed {
                    at,
                    token: Token::Word(end),
                },
                Placed {
                    token: Token::Slash,
                    ..
                },
                rest @ ..,
            ] => {
                let word = self.text.get(*at..*end);
                self.tokens = rest;
                word
            }
            _ => None,
        }
    }

    /// The next value and the comma behind it; `None` at the end.
    pub fn next(&mut self) -> Result<Option<(usize, Value<'a>)>, Fault> {
        if self.is_empty() {
            return Ok(None);
        }
        let value = self.one()?;
        if !self.is_empty() {
            self.must(Token::Comma, COMMA)?;
            if self.is_empty() {
                return Err(self.unexpected("a value behind the last comma"));
            }
        }
        Ok(Some(value))
    }

    /// Numbers and the commas between them, as long as there are any; how many. The comma before something else is taken too.
    pub fn numbers<const N: usize>(
        &mut self,
        takes: &'static str,
    ) -> Result<([f64; N], usize), Fault> {
        let mut out = [0.0; N];
        let mut count = 0;
        while let Some(&Placed {
            at,
            token: Token::Number(v),
        }) = self.tokens.first()
        {
            match out.get_mut(count) {
                Some(place) => *place = v,
                None => {
                    let found = count + 1;
                    let word = self.word;
                    return Err((at, ClProblem::Count { word, found, takes }));
                }
            }
            count += 1;
            self.step();
            if self.is_empty() || self.tokens.first().is_some_and(|t| t.token == Token::Close) {
                break;
            }
            self.must(Token::Comma, COMMA)?;
            if self.is_empty() {
                return Err(self.unexpected("a value behind the last comma"));
            }
        }
        Ok((out, count))
    }

    /// One number and nothing behind it.
    pub fn number(&mut self, takes: &'static str) -> Result<f64, Fault> {
        let ([v], count) = self.numbers::<1>(takes)?;
        if count == 0 {
            return Err(self.unexpected("a number"));
        }
        self.end()?;
        Ok(v)
    }

    /// Complains when anything is left.
    pub fn end(&self) -> Result<(), Fault> {
        match self.is_empty() {
            true => Ok(()),
            false => Err(self.unexpected("the statement's end")),
        }
    }

    /// The complaint that a word stands here which this statement does not take.
    pub fn minor(&self, at: usize, found: &[u8], takes: &'static str) -> Fault {
        let minor = upper(found);
        let near = nearest(&minor, takes.split([',', ' ']).filter(|w| is_word(w)));
        (
            at,
            ClProblem::Minor {
                word: self.word,
                minor,
                nearest: near,
                takes,
            },
        )
    }

    /// The complaint about a number.
    pub fn value(&self, at: usize, value: f64, rule: &'static str) -> Fault {
        let word = self.word;
        (at, ClProblem::Value { word, value, rule })
    }
}

/// True for words in capitals as they stand in lists of what a statement takes.
fn is_word(w: &str) -> bool {
    w.len() > 1 && w.bytes().all(|b| b.is_ascii_uppercase())
}

/// A word in capitals, as complaints show it; the front of a long one.
pub(super) fn upper(word: &[u8]) -> String {
    let front = word.get(..word.len().min(40)).unwrap_or_default();
    String::from_utf8_lossy(front).to_ascii_uppercase()
}

/// The first three of some numbers as a place.
pub(super) fn point(v: &[f64; 3], scale: f64) -> Point {
    Point::new(v[0] * scale, v[1] * scale, v[2] * scale)
}

/// Three numbers as a direction.
pub(super) fn vector(v: &[f64; 3]) -> Vector {
    Vector::new(v[0], v[1], v[2])
}
