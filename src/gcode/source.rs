//! The lines of a program, in order, and from an earlier or later place again: constant memory, whatever the program's length.
//!
//! Crosses the border: bytes of anything that can be read and wound (a file, a text in memory) in; lines out, without their ends, with their
//! places. Line ends are LF, CR LF or CR. A byte order mark at the front is dropped. Bytes that are no UTF-8 are read as Latin-1, as old
//! editors write comments. Lines of more than [`LONGEST`] bytes are not kept whole: their front is given, and they are marked.

use std::io::{self, BufRead, Seek, SeekFrom};

/// Bytes of a line that are kept.
pub const LONGEST: usize = 1 << 20;

/// Anything that can be read by lines and wound back.
pub trait TextReader: BufRead + Seek + Send {}
impl<T: BufRead + Seek + Send> TextReader for T {}

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
    /// Where the first line begins: behind a byte order mark.
    first: u64,
    /// Where the next line begins; `line` is the number it will have.
    next: LineStart,
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
        // A buffer may hold fewer bytes than the mark has: it is counted byte by byte.
        let mut seen = 0;
        while let Some(expected) = mark.get(seen)
            && from.fill_buf()?.first() == Some(expected)
        {
            from.consume(1);
            seen += 1;
        }
        let first = if seen == mark.len() { seen as u64 } else { 0 };
        if seen > 0 && first == 0 {
            from.seek(SeekFrom::Start(0))?;
        }
        Ok(Source {
            from,
            first,
            next: LineStart {
                offset: first,
                line: 1,
            },
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
        // From where it stands: a jump within what is already in memory then costs nothing.
        let way = i128::from(to.offset) - i128::from(self.next.offset);
        match i64::try_from(way) {
            Ok(way) => self.from.seek_relative(way)?,
            Err(_) => {
                self.from.seek(SeekFrom::Start(to.offset))?;
            }
        }
        self.next = to;
        Ok(())
    }

    /// Goes back to the first line.
    ///
    /// # Errors
    /// What reading answers.
    pub fn rewind(&mut self) -> io::Result<()> {
        self.go(LineStart {
            offset: self.first,
            line: 1,
        })
    }

    /// The line read last.
    pub fn last(&self) -> &str {
        &self.text
    }

    /// The next line with its number, `None` behind the last. A line end at the very end opens no further line. The text holds until the
    /// next call.
    ///
    /// # Errors
    /// What reading answers.
    pub fn read(&mut self) -> io::Result<Option<(usize, &str)>> {
        let mut bytes = std::mem::take(&mut self.text).into_bytes();
        bytes.clear();
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
            let room = LONGEST - bytes.len();
            self.cut |= part.len() > room;
            bytes.extend_from_slice(&part[..part.len().min(room)]);
            let mut used = part.len();
            // CR LF in one piece, as nearly always.
            let carriage = end.is_some_and(|e| buffer[e] == b'\r');
            let feed = carriage && end.is_some_and(|e| buffer.get(e + 1) == Some(&b'\n'));
            used += usize::from(end.is_some()) + usize::from(feed);
            self.from.consume(used);
            self.next.offset += used as u64;
            if end.is_some() {
                if carriage && !feed && self.from.fill_buf()?.first() == Some(&b'\n') {
                    self.from.consume(1);
                    self.next.offset += 1;
                }
                break;
            }
        }
        self.text = match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(other) => other.as_bytes().iter().map(|b| char::from(*b)).collect(),
        };
        if !any {
            return Ok(None);
        }
        let line = self.next.line;
        self.next.line += 1;
        Ok(Some((line, &self.text)))
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
        let mut s = Source::new(io::BufReader::with_capacity(2, Cursor::new(bytes))).unwrap();
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
