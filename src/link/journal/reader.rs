//! Bytes of a journal to what they tell. Memory does not grow with its length.
//!
//! A record counts only if it is whole, proves itself by its checksum, bears the next number, and was not preceded by one that does not.

use super::history::History;
use super::line::{LONGEST, decode, format_of};
use super::record::FORMAT;
use std::io::{self, BufRead, Read as _};

/// What is wrong with a journal's bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Damage {
    /// Nothing.
    #[default]
    None,
    /// The last record was being written when the sender was killed: so many bytes are not whole. Nothing depends on them: what a record
    /// allows is done only after it is whole, and one that lacks only its line end is believed.
    Torn {
        /// Bytes of it.
        bytes: u64,
    },
    /// Behind the last record stand only zero bytes, as a file system leaves them when the computer lost its power.
    Zeros {
        /// How many.
        bytes: u64,
    },
    /// A line in the middle, or a whole line at the end, is not what was written. It and everything behind it is not believed.
    Broken {
        /// Line of the journal, from 1.
        line: u64,
        /// Lines behind it that look whole.
        behind: u64,
    },
}

/// Reads a journal.
///
/// # Errors
/// What reading answers. A journal that is damaged is no error: [`History::damage`] tells.
pub fn read(mut from: impl BufRead) -> io::Result<History> {
    let mut history = History::default();
    let mut line = Vec::new();
    let mut number = 0;
    while next(&mut from, &mut line)? {
        let ended = line.strip_suffix(b"\n");
        if let Some((n, record)) = ended.and_then(decode)
            && n == number
            && history.take(&record)
        {
            number += 1;
            continue;
        }
        if number == 0 {
            history.foreign = ended.and_then(format_of).filter(|f| *f != FORMAT);
        }
        let bad = std::mem::take(&mut line);
        history.damage = assess(&mut from, &bad, number)?;
        // The last record may lack nothing but its end, or that alone is spoilt: what it allows may have been done.
        let last = [bad.as_slice(), bad.get(..bad.len() - 1).unwrap_or_default()];
        if matches!(history.damage, Damage::Torn { .. })
            && let Some((n, record)) = last.iter().find_map(|l| decode(l))
            && n == number
        {
            history.take(&record);
        }
        break;
    }
    Ok(history)
}

/// The next line with its end, if there is any; over-long ones in pieces.
fn next(from: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<bool> {
    line.clear();
    from.take(LONGEST as u64).read_until(b'\n', line)?;
    Ok(!line.is_empty())
}

/// What a bad line means depends on what follows it.
fn assess(from: &mut impl BufRead, bad: &[u8], number: u64) -> io::Result<Damage> {
    let mut line = Vec::new();
    let mut bytes = bad.len() as u64;
    let (mut zeros, mut behind, mut lines) = (bad.iter().all(|b| *b == 0), 0, 0u64);
    while next(from, &mut line)? {
        lines += 1;
        bytes += line.len() as u64;
        zeros &= line.iter().all(|b| *b == 0);
        behind += u64::from(line.strip_suffix(b"\n").and_then(decode).is_some());
    }
    Ok(if zeros {
        Damage::Zeros { bytes }
    } else if lines == 0 && !bad.ends_with(b"\n") && bad.len() < LONGEST {
        Damage::Torn { bytes }
    } else {
        Damage::Broken {
            line: number + 1,
            behind,
        }
    })
}
