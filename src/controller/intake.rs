//! Bytes to lines, as GRBL takes them in: real-time bytes are picked out on arrival, the rest waits in a ring of fixed size.
//!
//! The ring drops what does not fit *without a sign*: a sender that miscounts gets two lines fused into one. [`Intake::lost`] tells
//! a test, never the sender.

use crate::wire::{LINE_CHARS, Realtime};
use std::collections::VecDeque;

/// One complete line, or the news that it was too long.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// Upper case, without blanks, slashes and comments.
    Text(String),
    /// 80 or more characters: error 11.
    TooLong,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Comment {
    #[default]
    None,
    Parenthesis,
    Semicolon,
}

/// How lines are cut, by firmware and quirk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cutting {
    /// CR LF is two line ends.
    pub crlf_twice: bool,
    /// Most significant characters of a line.
    pub most: usize,
    /// What is longer is cut short without a sign, rather than refused.
    pub truncates: bool,
    /// `/` is passed over; otherwise a line that begins with it counts as empty.
    pub slash_passes: bool,
}

impl Default for Cutting {
    fn default() -> Cutting {
        Cutting {
            crlf_twice: true,
            most: LINE_CHARS,
            truncates: false,
            slash_passes: true,
        }
    }
}

/// Receive ring and line buffer.
#[derive(Clone, Debug)]
pub struct Intake {
    ring: VecDeque<u8>,
    capacity: usize,
    lost: usize,
    line: String,
    too_long: bool,
    comment: Comment,
    cutting: Cutting,
    after_cr: bool,
    deleted: bool,
}

impl Intake {
    /// An empty ring of `capacity` bytes.
    pub fn new(capacity: usize) -> Intake {
        Intake {
            ring: VecDeque::with_capacity(capacity),
            capacity,
            lost: 0,
            line: String::with_capacity(LINE_CHARS),
            too_long: false,
            comment: Comment::None,
            cutting: Cutting::default(),
            after_cr: false,
            deleted: false,
        }
    }

    /// The same, cutting lines another way.
    pub fn cutting(self, cutting: Cutting) -> Intake {
        Intake { cutting, ..self }
    }

    /// One byte from the cable. A real-time byte comes back; any other is stored, or lost when the ring is full.
    pub fn arrive(&mut self, byte: u8) -> Option<Realtime> {
        self.arrive_as(byte, Realtime::from_byte(byte))
    }

    /// The same, where another firmware has said what it makes of the byte.
    pub fn arrive_as(&mut self, byte: u8, command: Option<Realtime>) -> Option<Realtime> {
        if command.is_none() {
            if self.ring.len() < self.capacity {
                self.ring.push_back(byte);
            } else {
                self.lost += 1;
            }
        }
        command
    }

    /// Reads stored bytes until a line is complete. `None`: the ring is dry (what was read of a line is kept).
    pub fn line(&mut self) -> Option<Line> {
        while let Some(byte) = self.ring.pop_front() {
            let after_cr = std::mem::replace(&mut self.after_cr, byte == b'\r');
            if byte == b'\n' && after_cr && !self.cutting.crlf_twice {
                continue;
            }
            if byte == b'\n' || byte == b'\r' {
                self.deleted = false;
                let text = std::mem::take(&mut self.line);
                self.comment = Comment::None;
                return Some(if std::mem::take(&mut self.too_long) {
                    Line::TooLong
                } else {
                    Line::Text(text)
                });
            }
            match (self.comment, byte) {
                (Comment::Parenthesis, b')') => self.comment = Comment::None,
                (Comment::Parenthesis | Comment::Semicolon, _) => {}
                (Comment::None, b'(') => self.comment = Comment::Parenthesis,
                (Comment::None, b';') => self.comment = Comment::Semicolon,
                // Blanks and control characters vanish; so does `/`, which makes a "deleted" block run.
                (Comment::None, b'/') if !self.cutting.slash_passes && self.line.is_empty() => {
                    self.deleted = true;
                }
                (Comment::None, 0..=b' ' | b'/') => {}
                (Comment::None, _) if self.deleted => {}
                (Comment::None, _)
                    if self.line.len() >= self.cutting.most && self.cutting.truncates => {}
                (Comment::None, _) if self.line.len() >= self.cutting.most => self.too_long = true,
                (Comment::None, _) => self.line.push(char::from(byte.to_ascii_uppercase())),
            }
        }
        None
    }

    /// No byte waits (a half-read line may).
    pub fn is_dry(&self) -> bool {
        self.ring.is_empty()
    }

    /// Bytes of room.
    pub fn free(&self) -> usize {
        self.capacity - self.ring.len()
    }

    /// Bytes dropped since the start because the ring was full.
    pub fn lost(&self) -> usize {
        self.lost
    }

    /// Forgets everything waiting (a reset).
    pub fn clear(&mut self) {
        self.ring.clear();
        self.line.clear();
        self.too_long = false;
        self.comment = Comment::None;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<Line> {
        let mut intake = Intake::new(1000);
        for b in bytes {
            intake.arrive(*b);
        }
        std::iter::from_fn(|| intake.line()).collect()
    }

    fn text(s: &str) -> Line {
        Line::Text(s.to_string())
    }

    #[test]
    fn blanks_comments_and_slashes_vanish() {
        assert_eq!(lines(b"/g0 x1 (a;b) y2 ; end\n"), [text("G0X1Y2")]);
        assert_eq!(lines(b"(a(b)c)\n"), [text("C)")]);
        assert_eq!(lines(b"G0(open\nX1\n"), [text("G0"), text("X1")]);
        // CR LF is two line ends.
        assert_eq!(lines(b"X1\r\n"), [text("X1"), text("")]);
    }

    #[test]
    fn seventy_nine_characters_are_the_limit() {
        let mut line = vec![b'0'; 79];
        line.push(b'\n');
        assert_eq!(lines(&line), [text(&"0".repeat(79))]);
        line.insert(0, b'0');
        assert_eq!(lines(&line), [Line::TooLong]);
    }

    #[test]
    fn a_full_ring_drops_silently_and_lines_fuse() {
        let mut intake = Intake::new(8);
        for b in b"G0X1\nG0X2\nG0X3\n" {
            intake.arrive(*b);
        }
        assert_eq!(intake.lost(), 7);
        assert_eq!(intake.line(), Some(text("G0X1")));
        assert_eq!(intake.line(), None);
        intake.arrive(b'\n');
        assert_eq!(intake.line(), Some(text("G0X")));
    }

    #[test]
    fn real_time_bytes_take_no_room_even_in_comments() {
        let mut intake = Intake::new(4);
        assert_eq!(intake.arrive(b'('), None);
        assert_eq!(intake.arrive(b'?'), Some(Realtime::Status));
        assert_eq!(intake.arrive(0xC3), Some(Realtime::Nothing));
        assert_eq!(intake.free(), 3);
    }
}
