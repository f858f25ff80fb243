//! Words: a letter and a number, with the place where they stand.
//!
//! Crosses the border: the bytes of one line in; [`Word`]s out, in order, until the line ends or a word cannot be read. Blanks
//! may stand anywhere, even inside a number; a comment counts as a blank: `( ... )` ends at the first `)`, `;` runs to the end
//! of the line. Numbers are a sign, digits and one dot, nothing else: `1e3` is 1 and a word `E3`, never a thousand.

use super::dialect::Dialect;
use super::error::{Complaint, Fault};
use super::rules::{BlockDelete, RuleComplaint};
use nom::bytes::complete::{take_till, take_while};
use nom::{IResult, Parser};

/// Columns are counted up to here; beyond, they are reported as this.
pub(super) const MAX_COLUMN: usize = 1 << 20;

/// A letter and a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// `A` to `Z`.
    pub letter: u8,
    /// The number, as written.
    pub value: f64,
    /// Byte offset of the letter in its line.
    pub start: u32,
    /// Byte offset behind the last digit.
    pub end: u32,
    /// The number was written with a decimal point.
    pub point: bool,
}

/// The words of one line, read on demand: an early complaint about a word's meaning comes before a late one about spelling,
/// as it does in the firmware.
#[derive(Clone, Debug)]
pub struct Words<'a> {
    line: &'a [u8],
    rest: &'a [u8],
    dialect: Dialect,
}

/// Powers of ten that are exact in f64.
const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// GRBL reads eight digits, leading zeros among them, and takes the rest for zeros. LinuxCNC: all that f64 can hold.
fn digits_read(dialect: Dialect) -> u32 {
    dialect.rules().digits
}

/// `( ... )` up to the first `)` or the end of the line; `;` to the end of the line.
fn comment(i: &[u8]) -> IResult<&[u8], ()> {
    match i.first() {
        Some(b'(') => {
            let (rest, _) = take_till(|b| b == b')').parse(i)?;
            Ok((rest.get(1..).unwrap_or_default(), ()))
        }
        Some(b';') => Ok((&[], ())),
        _ => Err(nom::Err::Error(nom::error::Error::new(
            i,
            nom::error::ErrorKind::Char,
        ))),
    }
}

/// Blanks, control characters and comments. GRBL also drops every `/`: it has no block delete.
#[inline]
fn gap(dialect: Dialect) -> impl Fn(&[u8]) -> IResult<&[u8], ()> {
    move |mut i| {
        loop {
            match i.first() {
                Some(&b) if b <= b' ' => i = take_while(|b| b <= b' ').parse(i)?.0,
                Some(b'(' | b';') => i = comment(i)?.0,
                Some(b'/') if dialect == Dialect::Grbl => i = &i[1..],
                _ => return Ok((i, ())),
            }
        }
    }
}

/// Sign, digits, at most one dot; blanks between any of them.
#[inline]
fn number(dialect: Dialect) -> impl Fn(&[u8]) -> IResult<&[u8], (f64, bool)> {
    move |i| {
        let most = digits_read(dialect);
        let gap = gap(dialect);
        let (mut i, ()) = gap(i)?;
        let negative = i.first() == Some(&b'-');
        if let Some(b'-' | b'+') = i.first() {
            i = gap(&i[1..])?.0;
        }
        let (mut mantissa, mut count, mut exponent, mut dot) = (0u64, 0u32, 0i32, false);
        loop {
            let (rest, digits) = take_while(|b: u8| b.is_ascii_digit()).parse(i)?;
            for &d in digits {
                if count < most {
                    mantissa = mantissa * 10 + u64::from(d - b'0');
                    exponent -= i32::from(dot);
                } else if !dot {
                    exponent = exponent.saturating_add(1);
                }
                count = count.saturating_add(1);
            }
            i = rest;
            match i.first() {
                Some(b'.') if !dot => {
                    dot = true;
                    i = &i[1..];
                }
                Some(&b) if b <= b' ' || matches!(b, b'(' | b';' | b'/') => {
                    let (rest, ()) = gap(i)?;
                    match rest.first() {
                        Some(b) if b.is_ascii_digit() || (*b == b'.' && !dot) => i = rest,
                        _ => break,
                    }
                }
                _ => break,
            }
        }
        if count == 0 {
            return Err(nom::Err::Error(nom::error::Error::new(
                i,
                nom::error::ErrorKind::Digit,
            )));
        }
        let mut value = mantissa as f64;
        if exponent < 0 {
            value /= POW10.get(exponent.unsigned_abs() as usize).unwrap_or(&1e22);
        } else if exponent > 0 {
            // Only an absurdly long number comes here; it may become infinite, which the words' own checks refuse.
            value *= 10f64.powi(exponent);
        }
        Ok((i, (if negative { -value } else { value }, dot)))
    }
}

impl<'a> Words<'a> {
    /// The words of one line, without its line end.
    pub fn new(line: &'a str, dialect: Dialect) -> Words<'a> {
        let line = line.as_bytes();
        // Block delete: one slash at the very front; whether the line is skipped is the caller's business.
        let front = line.iter().position(|&b| b > b' ').unwrap_or(line.len());
        let rest = match (dialect.rules().block_delete, line.get(front)) {
            (BlockDelete::Switch, Some(b'/')) => line.get(front + 1..).unwrap_or_default(),
            (BlockDelete::Levels, Some(b'/')) => match line.get(front + 1) {
                Some(b'1'..=b'9') => line.get(front + 2..).unwrap_or_default(),
                _ => line.get(front + 1..).unwrap_or_default(),
            },
            _ => line,
        };
        Words {
            line,
            rest,
            dialect,
        }
    }

    fn offset(&self, rest: &[u8]) -> u32 {
        (self.line.len() - rest.len()).min(MAX_COLUMN) as u32
    }

    /// The next word; `None` at the end of the line.
    #[inline]
    pub(super) fn read(&mut self) -> Option<Result<Word, Fault>> {
        let at = match gap(self.dialect)(self.rest) {
            Ok((rest, ())) => rest,
            Err(_) => return None,
        };
        let (&first, behind) = at.split_first()?;
        let start = self.offset(at);
        let letter = first.to_ascii_uppercase();
        if !letter.is_ascii_uppercase() {
            self.rest = &[];
            let place = self.line.len() - at.len();
            let before = place.checked_sub(1).and_then(|i| self.line.get(i));
            let digits = [before, behind.first()].map(|b| b.is_some_and(u8::is_ascii_digit));
            if first == b',' && digits == [true, true] {
                return Some(Err(Fault::at(start, Complaint::DecimalComma)));
            }
            // Fanuc's optional corners; GRBL answers such a line as it answers any stray character.
            let corner = behind.first().map(u8::to_ascii_uppercase);
            if first == b','
                && !self.dialect.rules().firmware
                && let Some(letter @ (b'C' | b'R' | b'A')) = corner
            {
                let letter = char::from(letter);
                return Some(Err(Fault::at(
                    start,
                    RuleComplaint::CommaWord { letter }.into(),
                )));
            }
            let found = String::from_utf8_lossy(&at[..at.len().min(4)])
                .chars()
                .next()
                .unwrap_or('?');
            return Some(Err(Fault::at(start, Complaint::ExpectedLetter { found })));
        }
        match number(self.dialect)(behind) {
            Ok((rest, (value, point))) if value.is_finite() => {
                self.rest = rest;
                Some(Ok(Word {
                    letter,
                    value,
                    start,
                    end: self.offset(rest),
                    point,
                }))
            }
            _ => {
                self.rest = &[];
                let letter = letter as char;
                Some(Err(Fault::at(start, Complaint::BadNumber { letter })))
            }
        }
    }
}

/// Characters of a line that reach GRBL's parser: all but blanks, `/` and comments.
pub(super) fn significant(line: &str) -> usize {
    let mut count = 0;
    let mut i = line.as_bytes();
    while let Ok((rest, ())) = gap(Dialect::Grbl)(i) {
        let Some((_, behind)) = rest.split_first() else {
            break;
        };
        count += 1;
        i = behind;
    }
    count
}

/// LinuxCNC refuses open and nested comments, where GRBL reads on. Called for lines with a `(` only.
pub(super) fn check_comments(line: &str) -> Result<(), Fault> {
    let mut open = None;
    for (i, b) in line.bytes().enumerate() {
        let at = i.min(MAX_COLUMN) as u32;
        match (b, open) {
            (b';', None) => return Ok(()),
            (b'(', None) => open = Some(at),
            (b'(', Some(_)) => return Err(Fault::at(at, Complaint::CommentNested)),
            (b')', Some(_)) => open = None,
            _ => {}
        }
    }
    match open {
        Some(at) => Err(Fault::at(at, Complaint::CommentOpen)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn all(line: &str, dialect: Dialect) -> Result<Vec<(char, f64)>, Complaint> {
        let mut words = Words::new(line, dialect);
        let mut out = vec![];
        while let Some(w) = words.read() {
            let w = w.map_err(|f| f.complaint)?;
            out.push((w.letter as char, w.value));
        }
        Ok(out)
    }

    #[test]
    fn reads_words_as_people_write_them() {
        let both = [
            ("G0X1", vec![('G', 0.0), ('X', 1.0)]),
            (
                "g1 x.5y5.z-0.25",
                vec![('G', 1.0), ('X', 0.5), ('Y', 5.0), ('Z', -0.25)],
            ),
            ("X + 1 . 5 Y 1 2", vec![('X', 1.5), ('Y', 12.0)]),
            ("(a;b)G0(c)X1;Y2", vec![('G', 0.0), ('X', 1.0)]),
            ("X1(c)2\t Y3\r\n", vec![('X', 12.0), ('Y', 3.0)]),
            ("X1e3", vec![('X', 1.0), ('E', 3.0)]),
            ("", vec![]),
            ("( only a comment )", vec![]),
            ("G38.2Z-5", vec![('G', 38.2), ('Z', -5.0)]),
        ];
        for dialect in [Dialect::Grbl, Dialect::LinuxCnc] {
            for (line, words) in &both {
                assert_eq!(all(line, dialect).as_ref(), Ok(words), "{line}");
            }
        }
        assert_eq!(
            all("/G0X1/0", Dialect::Grbl).unwrap(),
            [('G', 0.0), ('X', 10.0)]
        );
        assert!(all("G0/X1", Dialect::LinuxCnc).is_err());
    }

    #[test]
    fn refuses_what_is_no_word() {
        for line in [
            "X", "X.", "X-", "X--1", "X+-1", "X#1", "X[1]", "Xinf", "G", "(a(b)c)",
        ] {
            let c = all(line, Dialect::Grbl).unwrap_err();
            assert!(matches!(c, Complaint::BadNumber { .. }), "{line}: {c:?}");
        }
        for line in ["%", "=", "1", "X1.2.3", "\\", ")", "\u{e9}", "\u{7f}"] {
            let c = all(line, Dialect::Grbl).unwrap_err();
            assert!(
                matches!(c, Complaint::ExpectedLetter { .. }),
                "{line}: {c:?}"
            );
        }
    }

    #[test]
    fn a_decimal_comma_is_called_by_its_name() {
        for dialect in [Dialect::Grbl, Dialect::LinuxCnc] {
            assert_eq!(all("G1 X1,5", dialect), Err(Complaint::DecimalComma));
            for other in ["X1,", "X1,S2", "X1.,5", ",5"] {
                let found = ',';
                let other = all(other, dialect);
                assert_eq!(other, Err(Complaint::ExpectedLetter { found }));
            }
        }
        // GRBL answers by number, and this one it does not know.
        let (found, letter) = (',', 'R');
        let stray = Err(Complaint::ExpectedLetter { found });
        assert_eq!(all("X1,R2", Dialect::Grbl), stray);
        let corner = RuleComplaint::CommaWord { letter };
        assert_eq!(all("X1,r2", Dialect::Fanuc), Err(corner.into()));
    }

    #[test]
    fn grbl_reads_eight_digits() {
        assert_eq!(
            all("X12.3456789", Dialect::Grbl).unwrap(),
            [('X', 12.345678)]
        );
        assert_eq!(
            all("X123456789", Dialect::Grbl).unwrap(),
            [('X', 123456780.0)]
        );
        assert_eq!(all("X0000000012", Dialect::Grbl).unwrap(), [('X', 0.0)]);
        assert_eq!(
            all("X0000000012", Dialect::LinuxCnc).unwrap(),
            [('X', 12.0)]
        );
    }

    #[test]
    fn words_know_their_place() {
        let mut w = Words::new(" G1  x 2.5(c)Y3", Dialect::Grbl);
        let spans: Vec<_> = std::iter::from_fn(|| w.read())
            .map(|w| w.map(|w| (w.start, w.end)).unwrap())
            .collect();
        assert_eq!(spans, [(1, 3), (5, 10), (13, 15)]);
    }

    #[test]
    fn significant_characters_are_those_the_parser_sees() {
        assert_eq!(significant("G0 X1 (comment) /Y2 ;end"), 6);
        assert_eq!(significant(""), 0);
        assert_eq!(significant("(open"), 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
            let text = String::from_utf8_lossy(&bytes);
            let _ = all(&text, Dialect::Grbl);
            let _ = all(&text, Dialect::LinuxCnc);
            let _ = significant(&text);
        }

        #[test]
        fn decimal_numbers_are_read_to_the_last_bit(n in -9_999_999i64..9_999_999, k in 0usize..7) {
            let digits = format!("{:0width$}", n.abs(), width = k + 1);
            let (a, b) = digits.split_at(digits.len() - k);
            let text = format!("{}{a}.{b}", if n < 0 { "-" } else { "" });
            if a.len() + b.len() <= 8 {
                let want: f64 = text.parse().unwrap();
                prop_assert_eq!(all(&format!("X{text}"), Dialect::Grbl).unwrap(), vec![('X', want)]);
            }
        }
    }
}
