//! A line with variables and expressions, as the line of plain words that it stands for.
//!
//! Crosses the border: one line, the variables and the machine's state in; the same words with plain numbers out, which places they came from,
//! and the settings (`#1=...`) that take effect behind the line. Nothing is changed here.

use crate::gcode::error::Fault;
use crate::gcode::expression::{Evaluator, ExpressionComplaint, Value, fault, is_ngc};
use crate::gcode::parameter::{Parameter, Parameters};
use crate::gcode::state::State;
use crate::gcode::word::check_comments;

/// A word of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// `A` to `Z`.
    pub letter: u8,
    /// Its number; NaN where it has none that can be read (whoever reads the line then says so).
    pub value: f64,
    /// A decimal point was written, or the value was computed.
    pub point: bool,
    /// Bytes of the new line.
    pub start: usize,
    /// Behind its last byte.
    pub end: usize,
    /// Byte of the line as written.
    pub at: usize,
}

/// A line of plain words.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Expanded {
    /// Without comments and settings, numbers in place of expressions.
    pub text: String,
    /// Its words.
    pub words: Vec<Spot>,
    /// Variables to be set behind the line.
    pub settings: Vec<(Parameter, Option<f64>)>,
    /// Where the first setting stands.
    pub setting_at: usize,
}

impl Expanded {
    /// Removes a word.
    pub fn strike(&mut self, spot: Spot) {
        let blanks = " ".repeat(spot.end - spot.start);
        self.text.replace_range(spot.start..spot.end, &blanks);
        self.words.retain(|w| w.start != spot.start);
    }

    /// The word with this letter and value.
    pub fn find(&self, letter: u8, value: f64) -> Option<Spot> {
        let mut words = self.words.iter();
        words
            .find(|w| w.letter == letter && w.value == value)
            .copied()
    }

    /// The only word with this letter.
    pub fn letter(&self, letter: u8) -> Option<Spot> {
        self.words.iter().find(|w| w.letter == letter).copied()
    }

    /// A complaint about the new line, at the place of the old one that is to blame.
    pub fn blame(&self, fault: Fault) -> Fault {
        let offset = fault.offset as usize;
        let word = self.words.iter().rev().find(|w| w.start <= offset);
        let at = word.map_or(offset, |w| w.at);
        Fault {
            offset: at as u32,
            ..fault
        }
    }
}

/// A plain number for a value, to 1e-10.
fn literal(value: f64) -> String {
    let text = format!("{value:.10}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" | "" | "-" => "0".into(),
        text => text.into(),
    }
}

/// Expands a line from the byte `from` on; what stands before it is dropped.
pub(super) fn expand(
    line: &str,
    from: usize,
    parameters: &Parameters,
    state: &State,
) -> Result<Expanded, Fault> {
    let ngc = is_ngc(state.dialect);
    if ngc {
        check_comments(line)?;
    }
    let bytes = line.as_bytes();
    let mut e = Evaluator::new(line, parameters, state);
    e.at = from;
    let mut out = Expanded::default();
    while let Some(b) = e.peek() {
        match b {
            b';' => break,
            b'(' => {
                let rest = bytes.get(e.at..).unwrap_or_default();
                let close = rest.iter().position(|b| *b == b')');
                e.at = close.map_or(bytes.len(), |c| e.at + c + 1);
            }
            b'#' => setting(&mut e, ngc, &mut out)?,
            b if b.is_ascii_alphabetic() => word(bytes, &mut e, b.to_ascii_uppercase(), &mut out)?,
            _ => {
                // Nothing that begins a word: left for whoever reads the line to refuse, at this place.
                let at = e.at;
                let rest = line.get(at..).unwrap_or("?");
                let other = rest.chars().next().unwrap_or('?');
                out.words.push(Spot {
                    letter: 0,
                    value: f64::NAN,
                    point: false,
                    start: out.text.len(),
                    end: out.text.len() + other.len_utf8(),
                    at,
                });
                out.text.push(other);
                e.at = at + other.len_utf8();
            }
        }
    }
    Ok(out)
}

/// `#1=...`
fn setting(e: &mut Evaluator, ngc: bool, out: &mut Expanded) -> Result<(), Fault> {
    let at = e.at;
    let which = e.parameter()?;
    if !e.take(b'=') {
        let name = which.to_string().into_boxed_str();
        return Err(fault(at, ExpressionComplaint::NoEquals { name }));
    }
    let value = if ngc { e.value()? } else { e.expression(0)? };
    let value = match value {
        // #1=#0 empties.
        Value::Vacant { name, .. } if &*name == "#0" => None,
        value => Some(value.number()?),
    };
    if out.settings.is_empty() {
        out.setting_at = at;
    }
    out.settings.push((which, value));
    Ok(())
}

/// A letter and its value.
fn word(bytes: &[u8], e: &mut Evaluator, letter: u8, out: &mut Expanded) -> Result<(), Fault> {
    let (at, start) = (e.at, out.text.len());
    e.at += 1;
    out.text.push(char::from(letter));
    let before = e.at;
    let sign = e.peek().filter(|b| matches!(b, b'+' | b'-'));
    e.at += usize::from(sign.is_some());
    let computed = matches!(e.peek(), Some(b'[' | b'#'))
        || e.peek().is_some_and(|b| b.is_ascii_alphabetic())
            && e.letters().len() > 1
            && function_follows(bytes, e);
    e.at = before;
    let (value, point) = if computed {
        let value = e.value()?.number()?;
        let number = literal(value);
        out.text.push_str(&number);
        // A computed value has its full scale, as one written with a point has; letters that count take none.
        let counts = b"DGHLMNOPST".contains(&letter);
        if !counts && !number.contains('.') {
            out.text.push('.');
        }
        (value, true)
    } else {
        // As whoever reads the line takes it: sign, digits, a dot, with blanks and comments between them.
        while let Some(b) = e.peek() {
            match b {
                b'0'..=b'9' | b'.' | b'+' | b'-' | b',' => {
                    out.text.push(char::from(b));
                    e.at += 1;
                }
                b'(' => {
                    let rest = bytes.get(e.at..).unwrap_or_default();
                    let close = rest.iter().position(|b| *b == b')');
                    e.at = close.map_or(bytes.len(), |c| e.at + c + 1);
                }
                _ => break,
            }
        }
        let text = out.text.get(start + 1..).unwrap_or_default();
        (text.parse().unwrap_or(f64::NAN), text.contains('.'))
    };
    out.words.push(Spot {
        letter,
        value,
        point,
        start,
        end: out.text.len(),
        at,
    });
    Ok(())
}

/// Letters and a bracket: a function, not the next words.
fn function_follows(bytes: &[u8], e: &mut Evaluator) -> bool {
    let length = e.letters().len();
    let rest = bytes.get(e.at + length..).unwrap_or_default();
    rest.iter().find(|b| **b > b' ') == Some(&b'[')
}
