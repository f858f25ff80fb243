//! What a program says, one event at a time, with what the machine remembers then.

use super::error::InterpretError;
use super::event::Event;
use super::interpret::{interpret_line, lines};
use super::state::State;
use std::collections::VecDeque;

/// A program being read.
pub trait Said {
    /// The next event; `None` when the program is over.
    fn next_event(&mut self) -> Option<Result<Event, InterpretError>>;
    /// What the machine remembers behind the line of that event.
    fn state(&self) -> &State;
    /// The same, to take note of what the program cannot know. Events already made stay as they are.
    fn state_mut(&mut self) -> &mut State;
    /// A line's text, for messages.
    fn text_of(&mut self, line: usize) -> String;
    /// Comments met since this was last asked, with their lines.
    fn comments(&mut self) -> Vec<(usize, String)>;
}

/// A program in memory.
pub struct Spoken<'a> {
    text: &'a str,
    lines: Box<dyn Iterator<Item = &'a str> + 'a>,
    line: usize,
    state: State,
    waiting: VecDeque<Event>,
    fresh: Vec<Event>,
}

impl<'a> Spoken<'a> {
    /// From the state the machine is in.
    pub fn new(text: &'a str, state: State) -> Spoken<'a> {
        Spoken {
            text,
            lines: Box::new(lines(text)),
            line: 0,
            state,
            waiting: VecDeque::new(),
            fresh: Vec::new(),
        }
    }
}

impl Said for Spoken<'_> {
    fn next_event(&mut self) -> Option<Result<Event, InterpretError>> {
        loop {
            if let Some(e) = self.waiting.pop_front() {
                return Some(Ok(e));
            }
            let text = self.lines.next()?;
            self.line += 1;
            if let Err(e) = interpret_line(&mut self.state, text, self.line, &mut self.fresh) {
                return Some(Err(e));
            }
            self.waiting.extend(self.fresh.drain(..));
        }
    }

    fn state(&self) -> &State {
        &self.state
    }

    fn state_mut(&mut self) -> &mut State {
        &mut self.state
    }

    fn comments(&mut self) -> Vec<(usize, String)> {
        Vec::new()
    }

    fn text_of(&mut self, line: usize) -> String {
        let found = lines(self.text).nth(line.saturating_sub(1));
        found.unwrap_or_default().to_string()
    }
}
