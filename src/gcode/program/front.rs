//! The front of a line of words: block delete, line number, program number.
//!
//! Crosses the border: text in; numbers and places in it out.

use super::{FlowComplaint, flow};
use crate::gcode::error::Fault;

/// Largest line and program number.
pub(super) const LARGEST: u32 = 99_999_999;

/// The front of a line: block delete, line number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Front {
    /// It begins with a slash.
    pub slash: bool,
    /// Behind the slash (and Fanuc's switch number).
    pub words: usize,
    /// Behind the line number.
    pub body: usize,
    /// The line number.
    pub number: Option<u32>,
}

/// Takes a line's front apart.
pub(super) fn front(text: &str) -> Front {
    let bytes = text.as_bytes();
    let blanks = |mut at: usize| {
        while bytes.get(at).is_some_and(|b| *b <= b' ') {
            at += 1;
        }
        at
    };
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let mut words = blanks(0);
    let slash = bytes.get(words) == Some(&b'/');
    if slash {
        words = blanks(digits(words + 1));
    }
    let (mut body, mut number) = (words, None);
    if let Some(b'N' | b'n') = bytes.get(words) {
        let from = blanks(words + 1);
        let to = digits(from);
        if to > from && bytes.get(to) != Some(&b'.') {
            number = text.get(from..to).and_then(|d| d.parse().ok());
            body = blanks(to);
        }
    }
    Front {
        slash,
        words,
        body,
        number,
    }
}

/// The number behind `O` or `:` where a line begins a numbered program; what follows it.
pub(super) fn program_number(text: &str) -> Option<(u32, usize)> {
    let body = front(text).body;
    let rest = text.get(body..)?;
    let digits = rest.strip_prefix(['O', 'o', ':'])?.trim_start();
    let at = text.len() - digits.len();
    let count = digits.bytes().take_while(u8::is_ascii_digit).count();
    let number = digits.get(..count)?.parse().ok()?;
    Some((number, at + count))
}

/// The name under which a line's numbered program is called.
pub(super) fn program_name(text: &str) -> Option<Box<str>> {
    let first = text.trim_start().bytes().next()?;
    if !matches!(first, b'O' | b'o' | b':' | b'N' | b'n' | b'/') {
        return None;
    }
    let (number, behind) = program_number(text)?;
    let keyword = text
        .get(behind..)?
        .trim_start()
        .starts_with(|c: char| c.is_ascii_alphabetic());
    (!keyword).then(|| format!("O{number}").into())
}
/// A value that counts or names something.
pub(super) fn whole(
    value: f64,
    at: usize,
    what: &'static str,
    least: u32,
    most: u32,
) -> Result<u32, Fault> {
    let near = value.round();
    let fits = (value - near).abs() < 1e-4 && (f64::from(least)..=f64::from(most)).contains(&near);
    match fits {
        true => Ok(near as u32),
        false => Err(flow(
            at,
            FlowComplaint::Range {
                what,
                least,
                most,
                value,
            },
        )),
    }
}
