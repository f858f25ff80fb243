//! Lines on their way out: numbers, separators, lengths, ends. Holds one line at a time.

use crate::post::definition::{Numbered, Numbers, Post};
use crate::post::error::Refusal;
use crate::post::number;
use std::io::Write;

/// What a line is, for its number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `%` and the like.
    Bare,
    Words,
    Comment,
    /// The first line of a tool change.
    Tool,
}

/// The text so far, but for the line that is being written.
pub(super) struct Page<'a, W> {
    post: &'a Post,
    out: W,
    line: String,
    /// Where the words of the line begin, after its number.
    start: usize,
    /// Lines ended so far.
    pub lines: usize,
    number: u32,
}

impl<'a, W: Write> Page<'a, W> {
    pub fn new(post: &'a Post, out: W) -> Self {
        Page {
            post,
            out,
            line: String::with_capacity(128),
            start: 0,
            lines: 0,
            number: post.number_start.unwrap_or(post.number_step),
        }
    }

    /// Starts a line with its number, if it has one.
    pub fn begin(&mut self, kind: Kind) {
        self.line.clear();
        let post = self.post;
        let numbered = post.number_step > 0
            && match post.numbered {
                Numbered::All => kind != Kind::Bare,
                Numbered::Words => matches!(kind, Kind::Words | Kind::Tool),
                Numbered::Tools => kind == Kind::Tool,
            };
        if numbered {
            self.line.push_str(&post.number_prefix);
            number::push(&mut self.line, i64::from(self.number), 0);
            self.line.push(' ');
            self.number = self.number.saturating_add(post.number_step);
            // Controllers refuse higher numbers; starting over is legal where they are only labels.
            if self.number > post.number_highest {
                self.number = post.number_start.unwrap_or(post.number_step);
            }
        }
        self.start = self.line.len();
    }

    /// Text as it stands.
    pub fn text(&mut self, text: &str) {
        self.line.push_str(text);
    }

    /// A word as it stands, apart from the one before.
    pub fn word(&mut self, word: &str) {
        self.gap();
        self.line.push_str(word);
    }

    /// A word with a number.
    pub fn figure(&mut self, letter: &str, count: i64, decimals: u8, manner: Numbers) {
        self.gap();
        self.line.push_str(letter);
        number::push_as(&mut self.line, count, decimals, manner);
    }

    /// A number without its letter, as text.
    pub fn number(&mut self, count: i64, decimals: u8, manner: Numbers) {
        number::push_as(&mut self.line, count, decimals, manner);
    }

    fn gap(&mut self) {
        let inside = self.line.len() > self.start && !self.line.ends_with(' ');
        if inside {
            self.line.push_str(&self.post.separator);
        }
    }

    /// Ends the line.
    pub fn end(&mut self) -> Result<(), Refusal> {
        self.lines += 1;
        if self.line.len() > self.post.longest {
            return Err(Refusal::LineTooLong {
                line: self.lines,
                length: self.line.len(),
                longest: self.post.longest,
                text: self.line.clone(),
            });
        }
        self.line.push_str(self.post.line_end);
        self.out
            .write_all(self.line.as_bytes())
            .map_err(|e| Refusal::Output(e.to_string()))
    }

    /// The output back, everything in it.
    pub fn finish(mut self) -> Result<W, Refusal> {
        self.out
            .flush()
            .map_err(|e| Refusal::Output(e.to_string()))?;
        Ok(self.out)
    }
}
