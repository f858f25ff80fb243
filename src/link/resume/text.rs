//! The program's text as resuming reads it: several times from its beginning, never held.

use crate::gcode::source::{Source, TextReader};
use crate::link::job::JobSource;
use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

/// A program that can be read from its beginning as often as needed: a text in memory, or anything a job is read from.
pub trait ProgramText: Sync {
    /// From its beginning.
    ///
    /// # Errors
    /// What opening it answers.
    fn open_text(&self) -> io::Result<Box<dyn TextReader + '_>>;

    /// How many lines it has.
    ///
    /// # Errors
    /// What reading it answers.
    fn count_lines(&self) -> io::Result<usize> {
        let mut lines = Source::new(self.open_text()?)?;
        while lines.read()?.is_some() {}
        Ok(lines.place().line - 1)
    }
}

impl ProgramText for str {
    fn open_text(&self) -> io::Result<Box<dyn TextReader + '_>> {
        Ok(Box::new(Cursor::new(self.as_bytes())))
    }
}

impl ProgramText for String {
    fn open_text(&self) -> io::Result<Box<dyn TextReader + '_>> {
        Ok(Box::new(Cursor::new(self.as_bytes())))
    }
}

impl ProgramText for dyn JobSource {
    fn open_text(&self) -> io::Result<Box<dyn TextReader + '_>> {
        self.open().map(|text| text as Box<dyn TextReader>)
    }
}

impl<T: ProgramText + ?Sized> ProgramText for &T {
    fn open_text(&self) -> io::Result<Box<dyn TextReader + '_>> {
        (**self).open_text()
    }
}

/// Some lines, and behind them a program from one of its lines on.
pub(super) struct Joined<'a> {
    head: Cursor<Vec<u8>>,
    tail: Box<dyn TextReader + 'a>,
    /// Where in the program the tail begins, bytes.
    from: u64,
}

impl<'a> Joined<'a> {
    /// `head`, then `text` from `line` on.
    pub fn new(head: &[String], text: &'a dyn ProgramText, line: usize) -> io::Result<Joined<'a>> {
        let mut lines = Source::new(text.open_text()?)?;
        while lines.place().line < line && lines.read()?.is_some() {}
        let from = lines.place().offset;
        let mut tail = text.open_text()?;
        tail.seek(SeekFrom::Start(from))?;
        let mut front = head.join("\n").into_bytes();
        if !front.is_empty() {
            front.push(b'\n');
        }
        let head = Cursor::new(front);
        Ok(Joined { head, tail, from })
    }

    fn head_len(&self) -> u64 {
        self.head.get_ref().len() as u64
    }

    fn in_head(&self) -> bool {
        self.head.position() < self.head_len()
    }
}

impl Read for Joined<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.in_head() {
            true => self.head.read(bytes),
            false => self.tail.read(bytes),
        }
    }
}

impl BufRead for Joined<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self.in_head() {
            true => self.head.fill_buf(),
            false => self.tail.fill_buf(),
        }
    }

    fn consume(&mut self, n: usize) {
        match self.in_head() {
            true => self.head.consume(n),
            false => self.tail.consume(n),
        }
    }
}

impl Seek for Joined<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let head = self.head_len();
        let here = match self.in_head() {
            true => self.head.position(),
            false => head + self.tail.stream_position()?.saturating_sub(self.from),
        };
        let (base, by) = match to {
            SeekFrom::Start(at) => (at, 0),
            SeekFrom::Current(by) => (here, by),
            SeekFrom::End(by) => {
                let end = self.tail.seek(SeekFrom::End(0))?;
                (head + end.saturating_sub(self.from), by)
            }
        };
        let before = || io::Error::new(io::ErrorKind::InvalidInput, "a place before the beginning");
        let at = base.checked_add_signed(by).ok_or_else(before)?;
        self.head.set_position(at.min(head));
        let tail = self.from.saturating_add(at.saturating_sub(head));
        self.tail.seek(SeekFrom::Start(tail))?;
        Ok(at)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_head_and_the_program_behind_it_read_as_one() {
        let text = "\u{feff}one\r\ntwo\nthree";
        let joined = || Joined::new(&["a".into(), "b".into()], &text, 2).unwrap();
        let mut all = String::new();
        joined().read_to_string(&mut all).unwrap();
        assert_eq!(all, "a\nb\ntwo\nthree");
        let mut lines = Source::new(io::BufReader::with_capacity(3, joined())).unwrap();
        let start = lines.place();
        let mut places = vec![start];
        let mut read = vec![];
        while let Some((_, line)) = lines.read().unwrap() {
            read.push(line.to_string());
            places.push(lines.place());
        }
        assert_eq!(read, ["a", "b", "two", "three"]);
        for (place, text) in places.into_iter().zip(&read).rev() {
            lines.go(place).unwrap();
            assert_eq!(lines.read().unwrap().map(|l| l.1), Some(text.as_str()));
        }
        assert_eq!(joined().seek(SeekFrom::End(-5)).unwrap(), 8);
        assert_eq!(text.count_lines().unwrap(), 3);
        // From the first line the mark is behind the head, where it would be no mark.
        let mut all = String::new();
        Joined::new(&["a".into()], &text, 1)
            .unwrap()
            .read_to_string(&mut all)
            .unwrap();
        assert_eq!(all, "a\none\r\ntwo\nthree");
    }
}
