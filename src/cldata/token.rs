//! The words, numbers and marks of one statement.
//!
//! Crosses the border: a statement's text (continuation lines joined, comments gone) in; tokens with the bytes they stand at out. Blanks may
//! stand between any two tokens, and between a sign and its number, nowhere within a number. Knows nothing of what words mean.

use super::error::{ClProblem, Fault};
use nom::IResult;
use nom::bytes::complete::{take_till, take_while};
use nom::error::{Error, ErrorKind};

/// What stands in a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token {
    /// As read, finite.
    Number(f64),
    /// Letters, digits, `_` and `-`, from a letter on; up to this byte.
    Word(usize),
    /// Between apostrophes; up to this byte, the closing one not with it.
    Text(usize),
    /// `,`
    Comma,
    /// `/`
    Slash,
    /// `(`
    Open,
    /// `)`
    Close,
    /// `=`
    Equals,
}

/// A token and the byte at which it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// Byte in the statement's text.
    pub at: usize,
    /// What stands there.
    pub token: Token,
}

/// Brackets within brackets; CATIA writes one deep.
const DEEPEST: usize = 8;

/// Powers of ten that are exact in f64.
const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

fn fail<T>(i: &[u8]) -> IResult<&[u8], T> {
    Err(nom::Err::Error(Error::new(i, ErrorKind::Float)))
}

fn digits(i: &[u8]) -> IResult<&[u8], &[u8]> {
    take_while(|b: u8| b.is_ascii_digit())(i)
}

/// Everything up to and with blanks and control characters that count as such.
pub(super) fn blanks(i: &[u8]) -> IResult<&[u8], &[u8]> {
    take_while(|b| matches!(b, b' ' | b'\t' | 0x0c))(i)
}

/// A sign, digits, a dot, digits, an exponent (`E` or, as Fortran writes it, `D`). Read to the last bit.
fn number(start: &[u8]) -> IResult<&[u8], f64> {
    let (negative, mut i) = match start.split_first() {
        Some((b'-', rest)) => (true, blanks(rest)?.0),
        Some((b'+', rest)) => (false, blanks(rest)?.0),
        _ => (false, start),
    };
    let (rest, whole) = digits(i)?;
    i = rest;
    let mut part: &[u8] = &[];
    if let Some((b'.', rest)) = i.split_first() {
        (i, part) = digits(rest)?;
    }
    if whole.is_empty() && part.is_empty() {
        return fail(start);
    }
    let mut exponent = 0i64;
    if let Some((b'e' | b'E' | b'd' | b'D', rest)) = i.split_first() {
        let (minus, rest) = match rest.split_first() {
            Some((b'-', rest)) => (true, rest),
            Some((b'+', rest)) => (false, rest),
            _ => (false, rest),
        };
        let (rest, e) = digits(rest)?;
        if e.is_empty() {
            return fail(start);
        }
        let e = (e.iter()).fold(0i64, |n, d| {
            (10 * n + i64::from(d - b'0')).min(i64::from(u16::MAX))
        });
        exponent = if minus { -e } else { e };
        i = rest;
    }
    // A letter or a second dot at its end makes it something else.
    if i.first()
        .is_some_and(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | 0x80..))
    {
        return fail(start);
    }
    let value = if whole.len() + part.len() <= 18 {
        let mantissa = (whole.iter().chain(part)).fold(0u64, |n, d| 10 * n + u64::from(d - b'0'));
        let power = exponent - part.len() as i64;
        match usize::try_from(power.unsigned_abs())
            .ok()
            .and_then(|p| POW10.get(p))
        {
            // Both exact: one rounding, the right one.
            Some(p) if mantissa < 1 << 53 && power < 0 => mantissa as f64 / p,
            Some(p) if mantissa < 1 << 53 => mantissa as f64 * p,
            _ => slowly(whole, part, exponent),
        }
    } else {
        slowly(whole, part, exponent)
    };
    if !value.is_finite() {
        return fail(start);
    }
    Ok((i, if negative { -value } else { value }))
}

/// Any number, by the standard library.
#[cold]
fn slowly(whole: &[u8], part: &[u8], exponent: i64) -> f64 {
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    format!("{}.{}e{exponent}", text(whole), text(part))
        .parse()
        .or_else(|_| format!("0{}.{}0e{exponent}", text(whole), text(part)).parse())
        .unwrap_or(f64::NAN)
}

/// A word: from a letter on. A `-` belongs to it only before a letter (`END-OF-PATH`).
pub(super) fn word(i: &[u8]) -> IResult<&[u8], &[u8]> {
    if !i.first().is_some_and(u8::is_ascii_alphabetic) {
        return fail(i);
    }
    let mut rest = i;
    loop {
        (rest, _) = take_while(|b: u8| b.is_ascii_alphanumeric() || b == b'_')(rest)?;
        match rest {
            [b'-', b, ..] if b.is_ascii_alphabetic() => rest = rest.get(1..).unwrap_or_default(),
            _ => break,
        }
    }
    Ok((rest, i.get(..i.len() - rest.len()).unwrap_or_default()))
}

/// One token. The byte tells its kind, so that nothing is tried twice.
fn token<'a>(text: &'a [u8], i: &'a [u8]) -> IResult<&'a [u8], Token> {
    let mark = |t: Token| Ok((i.get(1..).unwrap_or_default(), t));
    match i.first() {
        Some(b',') => mark(Token::Comma),
        Some(b'/') => mark(Token::Slash),
        Some(b'(') => mark(Token::Open),
        Some(b')') => mark(Token::Close),
        Some(b'=') => mark(Token::Equals),
        Some(b'\'' | b'"') => {
            let quote = i.first().copied().unwrap_or_default();
            let (rest, _) = take_till(|b| b == quote)(i.get(1..).unwrap_or_default())?;
            let end = text.len() - rest.len();
            if rest.is_empty() {
                return fail(i);
            }
            Ok((rest.get(1..).unwrap_or_default(), Token::Text(end)))
        }
        Some(b) if b.is_ascii_alphabetic() => {
            let (rest, _) = word(i)?;
            Ok((rest, Token::Word(text.len() - rest.len())))
        }
        _ => number(i).map(|(rest, v)| (rest, Token::Number(v))),
    }
}

/// The tokens of `text` from byte `from` on, put behind those in `out`.
pub(super) fn tokens(text: &[u8], from: usize, out: &mut Vec<Placed>) -> Result<(), Fault> {
    let mut i = text.get(from..).unwrap_or_default();
    let mut depth = 0usize;
    loop {
        // Blanks are never refused.
        i = blanks(i).map_or(i, |(rest, _)| rest);
        if i.is_empty() {
            break;
        }
        let at = text.len() - i.len();
        match token(text, i) {
            Ok((rest, token)) => {
                match token {
                    Token::Open => depth += 1,
                    Token::Close if depth == 0 => {
                        let wanted = "no closing bracket";
                        return Err((at, ClProblem::Unexpected { found: ')', wanted }));
                    }
                    Token::Close => depth -= 1,
                    _ => {}
                }
                if depth > DEEPEST {
                    return Err((at, ClProblem::TooDeep));
                }
                out.push(Placed { at, token });
                i = rest;
            }
            Err(_) => return Err((at, wrong(i))),
        }
    }
    if depth > 0 {
        let wanted = "a closing bracket";
        return Err((text.len(), ClProblem::Ends { wanted }));
    }
    Ok(())
}

/// What is wrong with something that is no token.
fn wrong(i: &[u8]) -> ClProblem {
    match i.first() {
        Some(b) if b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.') => ClProblem::BadNumber,
        Some(b'\'' | b'"') => ClProblem::Ends {
            wanted: "the closing apostrophe",
        },
        _ => ClProblem::Unexpected {
            found: first_char(i),
            wanted: "a word, a number or a comma",
        },
    }
}

/// The character at the front; a byte that is no UTF-8 counts as Latin-1.
pub(super) fn first_char(i: &[u8]) -> char {
    let front = i.get(..i.len().min(4)).unwrap_or_default();
    let valid = match std::str::from_utf8(front) {
        Ok(t) => t,
        Err(e) => front
            .get(..e.valid_up_to())
            .and_then(|b| std::str::from_utf8(b).ok())
            .unwrap_or_default(),
    };
    (valid.chars().next()).unwrap_or_else(|| char::from(front.first().copied().unwrap_or(b'?')))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn of(text: &str) -> Result<Vec<Token>, Fault> {
        let mut out = vec![];
        tokens(text.as_bytes(), 0, &mut out)?;
        Ok(out.into_iter().map(|p| p.token).collect())
    }

    #[test]
    fn numbers_as_systems_write_them() {
        for (text, want) in [
            ("1", 1.0),
            ("-1.", -1.0),
            ("+.5", 0.5),
            ("- 12.25", -12.25),
            ("1.5E-03", 0.0015),
            ("1.5e3", 1500.0),
            (".1107982E+01", 1.107982),
            ("2.D0", 2.0),
            ("0.1000000000000000055511151231257827", 0.1),
            ("123456789012345678901234567890", 1.2345678901234568e29),
            ("1e-400", 0.0),
        ] {
            assert_eq!(of(text).unwrap(), [Token::Number(want)], "{text}");
        }
        for bad in [
            ".", "-", "1.2.3", "1e", "1E+", "1e999", "10MM", "--1", "+-1", "1_0",
        ] {
            assert_eq!(of(bad).unwrap_err(), (0, ClProblem::BadNumber), "{bad}");
        }
    }

    #[test]
    fn words_and_marks() {
        let t = of("TLON,GOFWD/ (CIRCLE/1),ON,'a, b',END-OF-PATH=N1-2").unwrap();
        use Token::*;
        assert_eq!(
            t,
            [
                Word(4),
                Comma,
                Word(10),
                Slash,
                Open,
                Word(19),
                Slash,
                Number(1.0),
                Close,
                Comma,
                Word(25),
                Comma,
                Text(31),
                Comma,
                Word(44),
                Equals,
                Word(47),
                Number(-2.0)
            ]
        );
        assert_eq!(of("((((((((9))))))))").unwrap().len(), 17);
        assert_eq!(of("(((((((((9)))))))))").unwrap_err().1, ClProblem::TooDeep);
        assert_eq!(of("(1").unwrap_err().0, 2);
        assert!(of("1)").is_err() && of("'open").is_err() && of("A;B").is_err());
        assert_eq!(
            of("A, \u{e9}").unwrap_err(),
            (
                3,
                ClProblem::Unexpected {
                    found: '\u{e9}',
                    wanted: "a word, a number or a comma"
                }
            )
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
            let _ = tokens(&bytes, 0, &mut vec![]);
        }

        #[test]
        fn numbers_are_read_to_the_last_bit(v in any::<f64>(), places in 0usize..20) {
            prop_assume!(v.is_finite());
            let shortest = format!("{v:?}");
            prop_assert_eq!(of(&shortest).unwrap(), vec![Token::Number(v)]);
            let fixed = format!("{:.places$}", v % 1e6);
            prop_assert_eq!(of(&fixed).unwrap(), vec![Token::Number(fixed.parse().unwrap())]);
        }
    }
}
