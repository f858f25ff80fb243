//! The lines of a program, in order, and from an earlier or later place again: constant memory, whatever the program's length.
//!
//! Crosses the border: bytes of anything that can be read and wound (a file, a text in memory) in; lines out, without their ends, with their
//! places. Line ends are LF, CR LF or CR. A byte order mark at the front is dropped. Bytes that are no UTF-8 are read as Latin-1, as old
//! editors write comments. Lines of more than [`LONGEST`] bytes are not kept whole: their front is given, and they are marked.

use std::io::{self, BufRead, Seek, SeekFrom};

/// Bytes of a line that are kept.
pub const LONGEST: usize = 1 << 20;

/// Where a line begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineStart {
    /// Bytes before it.
    pub offset: u64,
    /// Its number, from 1; zero before the first.
    pub line: usize,
}

/// A program's lines.
#[derive(Debug)]
pub struct Source<R> {
    from: R,
    /// Where the next line begins; `line` is the number it will have.
    next: LineStart,
    bytes: Vec<u8>,
    text: String,
    cut: bool,
}

impl<R: BufRead + Seek> Source<R> {
    /// The lines of what can be read, from its beginning.
    ///
    /// # Errors
    /// What reading it answers.
    pub fn new(mut from: R) -> io::Result<Source<R>> {
        from.seek(SeekFrom::Start(0))?;
        let mark = "\u{feff}".as_bytes();
        let offset = if from.fill_buf()?.starts_with(mark) {
            from.consume(mark.len());
            mark.len() as u64
        } else {
            0
        };
        Ok(Source {
            from,
            next: LineStart { offset, line: 1 },
            bytes: Vec::new(),
            text: String::new(),
            cut: false,
        })
    }

    /// Where the next line begins.
    pub fn place(&self) -> LineStart {
        self.next
    }

    /// Goes on reading at a line found earlier.
    ///
    /// # Errors
    /// What reading answers.
    pub fn go(&mut self, to: LineStart) -> io::Result<()> {
        self.from.seek(SeekFrom::Start(to.offset))?;
        self.next = to;
        Ok(())
    }

    /// The next line with its number, `None` behind the last. A line end at the very end opens no further line. The text holds until the
    /// next call.
    ///
    /// # Errors
    /// What reading answers.
    pub fn read(&mut self) -> io::Result<Option<(usize, &str)>> {
        self.bytes.clear();
        self.cut = false;
        let mut any = false;
        loop {
            let buffer = self.from.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            any = true;
            let end = buffer.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let part = &buffer[..end.unwrap_or(buffer.len())];
            let room = LONGEST - self.bytes.len();
            self.cut |= part.len() > room;
            self.bytes.extend_from_slice(&part[..part.len().min(room)]);
            let mut used = part.len();
            let carriage = end.is_some_and(|e| buffer[e] == b'\r');
            used += usize::from(end.is_some());
            self.from.consume(used);
            self.next.offset += used as u64;
            if end.is_some() {
                if carriage && self.from.fill_buf()?.first() == Some(&b'\n') {
                    self.from.consume(1);
                    self.next.offset += 1;
                }
                break;
            }
        }
        if !any {
            return Ok(None);
        }
        let line = self.next.line;
        self.next.line += 1;
        match std::str::from_utf8(&self.bytes) {
            // Borrowed twice to please the checker: it is read anew only where it is sound.
            Ok(_) => Ok(std::str::from_utf8(&self.bytes).ok().map(|t| (line, t))),
            Err(_) => {
                self.text.clear();
                self.text.extend(self.bytes.iter().map(|b| char::from(*b)));
                Ok(Some((line, &self.text)))
            }
        }
    }

    /// True when the line read last was longer than [`LONGEST`].
    pub fn was_cut(&self) -> bool {
        self.cut
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::io::Cursor;

    fn all(bytes: &[u8]) -> Vec<(usize, String)> {
        // A buffer of two bytes: line ends fall across it.
        let mut s = Source::new(io::BufReader::with_capacity(4, Cursor::new(bytes))).unwrap();
        let mut out = vec![];
        while let Some((n, t)) = s.read().unwrap() {
            out.push((n, t.to_string()));
        }
        out
    }

    #[test]
    fn lines_end_in_every_way_people_end_them() {
        for text in ["G0\nX1\n\nY2", "G0\r\nX1\r\n\r\nY2\r\n", "G0\rX1\r\rY2\r"] {
            let lines: Vec<String> = all(text.as_bytes()).into_iter().map(|l| l.1).collect();
            assert_eq!(lines, ["G0", "X1", "", "Y2"], "{text:?}");
        }
        assert!(all(b"").is_empty());
        assert_eq!(all(b"\n"), [(1, String::new())]);
        assert_eq!(all("\u{feff}G0".as_bytes()), [(1, "G0".into())]);
    }

    #[test]
    fn what_is_no_utf8_is_latin_1() {
        assert_eq!(all(b"(Fr\xe4ser \xf8 6)")[0].1, "(Fr\u{e4}ser \u{f8} 6)");
        assert_eq!(all("(\u{e4})".as_bytes())[0].1, "(\u{e4})");
    }

    #[test]
    fn winds_back_to_a_line() {
        let mut s = Source::new(Cursor::new(b"one\r\ntwo\rthree\nfour".as_slice())).unwrap();
        s.read().unwrap();
        let two = s.place();
        s.read().unwrap();
        s.read().unwrap();
        s.go(two).unwrap();
        assert_eq!(s.read().unwrap(), Some((2, "two")));
        assert_eq!(s.read().unwrap(), Some((3, "three")));
    }

    #[test]
    fn a_line_without_end_takes_no_memory() {
        let bytes = vec![b'X'; LONGEST + 10];
        let mut s = Source::new(Cursor::new(&bytes)).unwrap();
        assert_eq!(s.read().unwrap().unwrap().1.len(), LONGEST);
        assert!(s.was_cut());
        assert!(s.read().unwrap().is_none());
    }
}
