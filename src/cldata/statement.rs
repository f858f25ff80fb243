//! Statements: lines joined where `$` carries them on, comments and labels taken out.
//!
//! Crosses the border: bytes in; one [`Statement`] at a time out, which knows where each of its bytes stood. What stands here is from the
//! common rules of ANSI X3.37 and ISO 4343 (4.2): `$` carries a statement on and what follows it on its line is remark, `$$` ends it; a label
//! stands in front, with `)` or as `N10`; cards have 72 columns and a sequence number behind them. A text statement (`PPRINT` and the like)
//! is its line, `$` and all. Lines that begin with `**` are remarks too, and what
//! a remark of Creo's (`$$->`) carries on by `$`.

use super::error::{ClError, ClProblem, Fault};
use super::lines::{LONGEST, Lines};
use super::note::{NoteKind, Notes};
use std::collections::VecDeque;
use std::io::BufRead;

/// Where a piece of a statement's text came from.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// First byte in the text.
    at: usize,
    /// The line it stood on.
    line: usize,
    /// Characters before it on that line.
    before: usize,
}

/// A statement.
#[derive(Debug, Default)]
pub(super) struct Statement {
    /// Its text, from the first letter on.
    pub text: Vec<u8>,
    pieces: Vec<Piece>,
}

impl Statement {
    /// The line it begins on.
    pub fn line(&self) -> usize {
        self.pieces.first().map_or(1, |p| p.line)
    }

    /// The fault with its line and column.
    pub fn error(&self, (at, problem): Fault) -> ClError {
        let piece = (self.pieces.iter())
            .rev()
            .find(|p| p.at <= at)
            .copied()
            .unwrap_or(Piece {
                at: 0,
                line: 1,
                before: 0,
            });
        let text = self.text.get(piece.at..at.min(self.text.len()));
        ClError {
            line: piece.line,
            column: piece.before + characters(text.unwrap_or_default()) + 1,
            problem,
        }
    }

    fn push(&mut self, line: usize, before: usize, bytes: &[u8]) {
        // Lines that hold nothing but the $ take no memory, however many there are.
        if bytes.is_empty() && !self.pieces.is_empty() {
            return;
        }
        if !self.text.is_empty() {
            self.text.push(b' ');
        }
        let at = self.text.len();
        self.pieces.push(Piece { at, line, before });
        self.text.extend_from_slice(bytes);
    }
}

/// Characters of a text: of UTF-8 where it is, else each byte is one (Latin-1).
pub(super) fn characters(bytes: &[u8]) -> usize {
    std::str::from_utf8(bytes).map_or(bytes.len(), |t| t.chars().count())
}

/// Words whose line is text to its end.
pub(super) const TEXT_WORDS: [&str; 8] = [
    "PARTNO",
    "PPRINT",
    "REMARK",
    "INSERT",
    "TPRINT",
    "TOOL PATH",
    "LETTER",
    "TITLE",
];

/// The text word at the front, if there is one, and the bytes it takes.
pub(super) fn text_word(text: &[u8]) -> Option<(&'static str, usize)> {
    TEXT_WORDS
        .into_iter()
        .find(|w| {
            text.get(..w.len())
                .is_some_and(|t| t.eq_ignore_ascii_case(w.as_bytes()))
        })
        .map(|w| (w, w.len()))
}

/// Whether lines are cards.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cards {
    /// Not looked at yet.
    Unknown,
    No,
    /// Yes; the last sequence number.
    Yes(u64),
}

/// A file's statements.
#[derive(Debug)]
pub(super) struct Statements<R> {
    lines: Lines<R>,
    /// Lines that were looked at to tell cards from free lines, with their numbers.
    ahead: VecDeque<(usize, Vec<u8>, bool)>,
    cards: Cards,
    /// The line before was a remark of Creo's that goes on.
    remark_open: bool,
    /// The statement read last.
    pub now: Statement,
}

/// What one physical line adds.
enum Next {
    /// The statement goes on behind this line.
    On,
    /// It is whole.
    Whole,
    /// Nothing stands on the line.
    Nothing,
}

impl<R: BufRead> Statements<R> {
    pub fn new(from: R) -> Statements<R> {
        Statements {
            lines: Lines::new(from),
            ahead: VecDeque::new(),
            cards: Cards::Unknown,
            remark_open: false,
            now: Statement::default(),
        }
    }

    /// The number of the line read last.
    pub fn line(&self) -> usize {
        self.lines.number
    }

    /// Reads the next statement into `now`; false behind the last.
    pub fn read(&mut self, notes: &mut Notes) -> Result<bool, ClError> {
        self.now.text.clear();
        self.now.pieces.clear();
        if self.cards == Cards::Unknown {
            self.look_at_cards()?;
        }
        let mut open = false;
        loop {
            // Lines looked at before come first.
            let number = match self.ahead.pop_front() {
                Some((number, bytes, cut)) => {
                    (self.lines.bytes, self.lines.cut) = (bytes, cut);
                    number
                }
                None if self.read_line()? => self.lines.number,
                None if open => {
                    let end = self.now.text.len();
                    return Err(self.now.error((end, ClProblem::Unfinished)));
                }
                None => return Ok(false),
            };
            match self.add(number, open, notes)? {
                Next::On => open = true,
                Next::Whole => return Ok(true),
                Next::Nothing => {}
            }
        }
    }

    fn read_line(&mut self) -> Result<bool, ClError> {
        self.lines.read().map_err(|e| ClError {
            line: self.lines.number + 1,
            column: 1,
            problem: ClProblem::Unreadable(e.to_string()),
        })
    }

    /// Cards have 80 columns, and digits that rise in the last eight: two of them in a row at the front are no chance.
    fn look_at_cards(&mut self) -> Result<(), ClError> {
        self.cards = Cards::No;
        let mut numbers = vec![];
        while numbers.len() < 2 && self.ahead.len() < 100 && self.read_line()? {
            let l = &mut self.lines;
            let bytes = std::mem::take(&mut l.bytes);
            if bytes.iter().any(|b| !b.is_ascii_whitespace()) {
                numbers.push(sequence(&bytes));
            }
            self.ahead.push_back((l.number, bytes, l.cut));
        }
        if let [Some(a), Some(b)] = numbers.as_slice()
            && a < b
        {
            self.cards = Cards::Yes(a.saturating_sub(1));
        }
        Ok(())
    }

    /// Adds what stands on the line in `lines.bytes`.
    fn add(&mut self, number: usize, open: bool, notes: &mut Notes) -> Result<Next, ClError> {
        let fail = |column: usize, problem| {
            Err(ClError {
                line: number,
                column,
                problem,
            })
        };
        let bytes = &self.lines.bytes;
        if self.lines.cut || self.now.text.len() + bytes.len() > LONGEST {
            return fail(1, ClProblem::TooLong);
        }
        let mut line = bytes.as_slice();
        if let Cards::Yes(last) = self.cards {
            match sequence(line) {
                Some(n) if n > last => self.cards = Cards::Yes(n),
                None if line.iter().all(u8::is_ascii_whitespace) => return Ok(Next::Nothing),
                _ => return fail(73, ClProblem::Card),
            }
            line = line.get(..72).unwrap_or(line);
        }
        let front = |l: &[u8]| l.iter().position(|b| !is_blank(*b)).unwrap_or(l.len());
        let mut start = front(line);
        let rest = |s: usize| line.get(s..).unwrap_or_default();
        if rest(start).starts_with(b"$$") || rest(start).starts_with(b"**") {
            if says_center(rest(start)) {
                let before = line.get(..start).unwrap_or_default();
                return fail(characters(before) + 1, ClProblem::ToolCenter);
            }
            // Creo carries its own remarks on: `$$-> CSYS / 1.0, 0.0, $`.
            self.remark_open =
                rest(start).starts_with(b"$$->") && line.trim_ascii_end().ends_with(b"$");
            return Ok(Next::Nothing);
        }
        if std::mem::take(&mut self.remark_open) {
            self.remark_open = line.trim_ascii_end().ends_with(b"$");
            return Ok(Next::Nothing);
        }
        if !open {
            let label = label(rest(start));
            start += label + front(rest(start + label));
        }
        if rest(start).is_empty() {
            return Ok(Next::Nothing);
        }
        let before = characters(line.get(..start).unwrap_or_default());
        if !open && text_word(rest(start)).is_some() {
            self.now.push(number, before, rest(start).trim_ascii_end());
            return Ok(Next::Whole);
        }
        let (end, on) = match dollar(rest(start)) {
            None => (rest(start).len(), false),
            Some(d) => {
                let behind = rest(start + d + 1);
                let comment = behind.first() == Some(&b'$');
                if comment && says_center(behind) {
                    return fail(before + d + 1, ClProblem::ToolCenter);
                }
                if !comment && !behind.iter().all(|b| is_blank(*b)) {
                    notes.add(number, NoteKind::BehindDollar);
                }
                (d, !comment)
            }
        };
        let text = rest(start).get(..end).unwrap_or_default();
        self.now.push(number, before, text.trim_ascii_end());
        Ok(match (on, self.now.text.is_empty()) {
            (true, _) => Next::On,
            (false, true) => Next::Nothing,
            (false, false) => Next::Whole,
        })
    }
}

fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0c | 0x1a)
}

/// The first `$` that is not between apostrophes.
fn dollar(text: &[u8]) -> Option<usize> {
    let first = text.iter().position(|b| *b == b'$')?;
    let before = text.get(..first).unwrap_or_default();
    if !before.contains(&b'\'') {
        return Some(first);
    }
    let mut quoted = false;
    text.iter().position(|b| {
        quoted ^= *b == b'\'';
        *b == b'$' && !quoted
    })
}

/// Bytes of a label at the front: `N10`, `10` or `NAME` with `)`; `N10` or `10` with a blank behind it.
fn label(text: &[u8]) -> usize {
    let name = (text.iter())
        .position(|b| !b.is_ascii_alphanumeric())
        .unwrap_or(text.len());
    let digits = match text.split_first() {
        Some((b'n' | b'N', rest)) => rest.get(..name.saturating_sub(1)),
        _ => text.get(..name),
    };
    let numbered = digits.is_some_and(|d| !d.is_empty() && d.iter().all(u8::is_ascii_digit));
    match text.get(name) {
        _ if name == 0 => 0,
        Some(b')') => name + 1,
        Some(b) if numbered && is_blank(*b) => name,
        _ => 0,
    }
}

/// The sequence number of a card: columns 73 to 80, digits with blanks around them.
fn sequence(line: &[u8]) -> Option<u64> {
    let line = line.trim_ascii_end();
    let field = line.get(72..)?.trim_ascii();
    if line.len() > 80 || field.is_empty() || !field.iter().all(u8::is_ascii_digit) {
        return None;
    }
    std::str::from_utf8(field).ok()?.parse().ok()
}

/// True for remarks which say that the points are the ball's centre.
pub(super) fn says_center(remark: &[u8]) -> bool {
    let upper = remark.to_ascii_uppercase();
    let has =
        |words: &[&str]| (words.iter()).any(|w| upper.windows(w.len()).any(|u| u == w.as_bytes()));
    has(&[
        "TOOL CENTER",
        "TOOL CENTRE",
        "BALL CENTER",
        "BALL CENTRE",
        "CUTTER CENTER",
        "CUTTER CENTRE",
    ]) && has(&["OUTPUT", "POINTS ", "COORDINATES", "POSITIONS"])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn all(text: &str) -> Result<Vec<(usize, String)>, ClError> {
        let mut s = Statements::new(text.as_bytes());
        let mut notes = Notes::default();
        let mut out = vec![];
        while s.read(&mut notes)? {
            out.push((
                s.now.line(),
                String::from_utf8_lossy(&s.now.text).into_owned(),
            ));
        }
        Ok(out)
    }

    fn texts(text: &str) -> Vec<String> {
        all(text).unwrap().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn lines_are_joined_and_remarks_dropped() {
        let t = "$$ head\n\n** more\nGOTO/1,$\n$$ within\n  2,$ $$ said\n\t3\nRAPID $$ fast\nEND";
        assert_eq!(
            all(t).unwrap(),
            [
                (4, "GOTO/1, 2, 3".to_string()),
                (8, "RAPID".to_string()),
                (9, "END".to_string())
            ]
        );
        let e = all("GOTO/1,$\n").unwrap_err();
        assert_eq!(
            e.to_string(),
            "1:8 the file ends inside a statement that $ carries on: it is not whole, write it out again"
        );
    }

    #[test]
    fn texts_keep_their_dollars() {
        assert_eq!(
            texts("PPRINT costs 5$\npartno/A $$ B\nLOADTL/1,'5$ each',$\n2"),
            ["PPRINT costs 5$", "partno/A $$ B", "LOADTL/1,'5$ each', 2"]
        );
    }

    #[test]
    fn labels_go() {
        let t = "N10 GOTO/1\nn20)RAPID\n30 END\nAB1) STOP\n0040)FINI\nN\nNOPOST";
        assert_eq!(
            texts(t),
            ["GOTO/1", "RAPID", "END", "STOP", "FINI", "N", "NOPOST"]
        );
    }

    #[test]
    fn cards_lose_their_numbers_and_free_lines_do_not() {
        let card = |text: &str, n: usize| format!("{text:<72}{n:08}\n");
        let deck = card("PARTNO X", 10) + &card("GOTO/1.0,2.0,$", 20) + &card("3.0", 30);
        assert_eq!(texts(&deck), ["PARTNO X", "GOTO/1.0,2.0, 3.0"]);
        let broken = deck.clone() + "END\n";
        let e = all(&broken).unwrap_err();
        assert_eq!((e.line, e.column, e.problem), (4, 73, ClProblem::Card));
        assert!(all(&(deck + &card("END", 30))).is_err());
        // A long line of numbers is no card.
        let long = format!("GOTO/{}1,2,12345678\n", " ".repeat(63));
        assert!(texts(&format!("RAPID\n{long}"))[1].ends_with("12345678"));
    }

    #[test]
    fn places_are_counted_in_characters() {
        let mut s = Statements::new("LOADTL/1,'\u{e4}',$\n   X".as_bytes());
        s.read(&mut Notes::default()).unwrap();
        let at = |b: usize| {
            let e = s.now.error((b, ClProblem::BadNumber));
            (e.line, e.column)
        };
        assert_eq!((at(0), at(13)), ((1, 1), (1, 13)));
        assert_eq!(at(s.now.text.len() - 1), (2, 4));
    }

    #[test]
    fn centre_points_are_refused_wherever_they_are_said() {
        for t in [
            "$$ OUTPUT: tool center",
            "  RAPID $$ coordinates of the ball centre",
        ] {
            assert_eq!(all(t).unwrap_err().problem, ClProblem::ToolCenter);
        }
        assert!(all("$$ centerline data").unwrap().is_empty());
    }
}
