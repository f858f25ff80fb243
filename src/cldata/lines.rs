//! Physical lines of a file, one at a time.
//!
//! Crosses the border: bytes in; lines without their ends out, numbered from 1. Line ends are LF, CR LF or CR; a byte order mark at the front
//! is dropped. At most [`LONGEST`] bytes of a line are kept, whatever stands in the file.

use std::io::{self, BufRead};

/// Bytes of a line that are kept, and of a whole statement.
pub(super) const LONGEST: usize = 1 << 20;

/// A file's lines.
#[derive(Debug)]
pub(super) struct Lines<R> {
    from: R,
    /// Number of the line read last; zero before the first.
    pub number: usize,
    /// The line read last.
    pub bytes: Vec<u8>,
    /// True when it was longer than [`LONGEST`].
    pub cut: bool,
    after_return: bool,
}

impl<R: BufRead> Lines<R> {
    /// The lines of what can be read, from where it stands.
    pub fn new(from: R) -> Lines<R> {
        Lines {
            from,
            number: 0,
            bytes: Vec::new(),
            cut: false,
            after_return: false,
        }
    }

    /// Reads the next line into `bytes`; false behind the last. A line end at the very end opens no further line.
    pub fn read(&mut self) -> io::Result<bool> {
        self.bytes.clear();
        self.cut = false;
        let mut any = false;
        loop {
            let buffer = match self.from.fill_buf() {
                Ok(b) => b,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(e),
            };
            if buffer.is_empty() {
                break;
            }
            if self.after_return {
                self.after_return = false;
                if buffer.first() == Some(&b'\n') {
                    self.from.consume(1);
                    continue;
                }
            }
            any = true;
            let end = buffer.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let part = buffer.get(..end.unwrap_or(buffer.len())).unwrap_or(buffer);
            let room = LONGEST - self.bytes.len().min(LONGEST);
            self.cut |= part.len() > room;
            self.bytes.extend(part.iter().take(room));
            let used = part.len() + usize::from(end.is_some());
            self.after_return = end.is_some_and(|e| buffer.get(e) == Some(&b'\r'));
            self.from.consume(used);
            if end.is_some() {
                break;
            }
        }
        if !any {
            return Ok(false);
        }
        self.number += 1;
        let mark = "\u{feff}".as_bytes();
        if self.number == 1 && self.bytes.starts_with(mark) {
            self.bytes.drain(..mark.len());
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn all(bytes: &[u8]) -> Vec<(usize, String)> {
        // A buffer of three bytes: line ends fall across it.
        let mut lines = Lines::new(io::BufReader::with_capacity(3, bytes));
        let mut out = vec![];
        while lines.read().unwrap() {
            out.push((
                lines.number,
                String::from_utf8_lossy(&lines.bytes).into_owned(),
            ));
        }
        out
    }

    #[test]
    fn lines_end_in_every_way() {
        for text in [
            "END\nA\n\nFINI",
            "END\r\nA\r\n\r\nFINI\r\n",
            "END\rA\r\rFINI\r",
        ] {
            let lines: Vec<String> = all(text.as_bytes()).into_iter().map(|l| l.1).collect();
            assert_eq!(lines, ["END", "A", "", "FINI"], "{text:?}");
        }
        assert!(all(b"").is_empty());
        assert_eq!(all(b"\r\n"), [(1, String::new())]);
        assert_eq!(all("\u{feff}END".as_bytes()), [(1, "END".into())]);
    }

    #[test]
    fn a_line_without_end_takes_no_memory() {
        let bytes = vec![b'X'; LONGEST + 10];
        let mut lines = Lines::new(bytes.as_slice());
        assert!(lines.read().unwrap() && lines.cut);
        assert_eq!(lines.bytes.len(), LONGEST);
        assert!(!lines.read().unwrap());
    }
}
