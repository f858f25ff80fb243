//! A program line by line as the session sends it, and what the machine remembers between lines.

use super::refusal::Refusal;
use super::text::ProgramText;
use crate::gcode::source::{Source, TextReader};
use crate::gcode::{
    Complaint, Dialect, Event, FlowComplaint, InterpretError, Motion, State, interpret_line,
};
use crate::geom::{Point, Vector};
use crate::link::journal::{Begin, History, Offsets, Start, ToolChange};
use crate::units::Rpm;
use std::io;

/// A program as one job sends it.
#[derive(Clone)]
pub struct Program<'a> {
    /// Its text.
    pub text: &'a dyn ProgramText,
    /// What the machine remembers before line 1.
    pub start: State,
    /// Tool changes that were made: one that changed offsets did so behind its line.
    pub changes: &'a [ToolChange],
    /// Lines that begin with `/` are left out.
    pub skips_slashed: bool,
}

impl<'a> Program<'a> {
    /// The program of a journal.
    pub fn of(text: &'a dyn ProgramText, history: &'a History, begin: &Begin) -> Program<'a> {
        Program {
            text,
            start: begin.start_state(),
            changes: &history.tool_changes,
            skips_slashed: begin.skips_slashed,
        }
    }

    /// From line 1.
    pub fn walk(&self) -> Walk<'a> {
        Walk {
            lines: self.text.open_text().and_then(Source::new),
            changes: self.changes,
            skips_slashed: self.skips_slashed,
            state: self.start.clone(),
            events: Vec::new(),
            content: String::new(),
            line: 0,
            tool: None,
            changed_tool: false,
        }
    }
}

/// Walks through a program from its first line. Constant memory.
pub struct Walk<'a> {
    lines: io::Result<Source<Box<dyn TextReader + 'a>>>,
    changes: &'a [ToolChange],
    skips_slashed: bool,
    state: State,
    events: Vec<Event>,
    content: String,
    line: usize,
    tool: Option<u32>,
    changed_tool: bool,
}

impl<'a> Walk<'a> {
    /// Reads the next line; its number, from 1.
    ///
    /// # Errors
    /// The interpreter's complaint: the line changed nothing. Or that the text cannot be read on.
    pub fn step(&mut self) -> Option<Result<usize, InterpretError>> {
        let read = match &mut self.lines {
            Ok(lines) => lines.read().map_err(|e| e.kind()),
            Err(e) => Err(e.kind()),
        };
        self.line += 1;
        let text = match read {
            Ok(Some((_, text))) => text,
            Ok(None) => return None,
            Err(kind) => {
                return Some(Err(unreadable(self.line, kind)));
            }
        };
        self.events.clear();
        self.changed_tool = false;
        let Sent { content, change } = sent(text, self.skips_slashed);
        self.content = content;
        if self.content.is_empty() && !change {
            return Some(Ok(self.line));
        }
        if let Err(e) = interpret_line(&mut self.state, &self.content, self.line, &mut self.events)
        {
            return Some(Err(e));
        }
        if self.state.tool != 0 {
            self.tool = Some(self.state.tool);
        }
        self.changed_tool = change;
        if change {
            // The session stops the spindle for it.
            self.state.spindle = 0;
        }
        let set = |c: &&ToolChange| c.line == self.line;
        if let Some(offsets) = self.changes.iter().rev().find(set).and_then(|c| c.offsets) {
            measured(&mut self.state, &offsets);
        }
        Some(Ok(self.line))
    }

    /// What the machine remembers behind the line read last.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What the line read last told the machine.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// What of the line read last is sent.
    pub fn content(&self) -> &str {
        &self.content
    }

    /// The line read last, as it stands in the program.
    pub fn text(&self) -> &str {
        self.lines.as_ref().map_or("", |lines| lines.last())
    }

    /// The last tool number told so far.
    pub fn tool(&self) -> Option<u32> {
        self.tool
    }

    /// The line read last wants a tool change.
    pub fn changed_tool(&self) -> bool {
        self.changed_tool
    }

    /// The motions of the line read last, with what leads from their work coordinates to the machine's.
    pub fn motions(&self) -> (impl Iterator<Item = &Motion>, Vector) {
        // No motion of a line sees a change of offsets in it, so one difference serves them all.
        let last = self.events.iter().rev().find_map(|e| match e {
            Event::Motion(m) => Some(m.to),
            _ => None,
        });
        let shift = last.map_or_else(Vector::zeros, |to| self.state.machine_position() - to);
        let motions = self.events.iter().filter_map(|e| match e {
            Event::Motion(m) => Some(m),
            _ => None,
        });
        (motions, shift)
    }
}

/// A text that cannot be read on.
pub(super) fn unreadable(line: usize, kind: io::ErrorKind) -> InterpretError {
    InterpretError {
        line,
        column: 1,
        complaint: Complaint::Flow(FlowComplaint::Unreadable { kind }),
    }
}

/// How many lines a text has.
pub(super) fn lines(text: &dyn ProgramText) -> Result<usize, Refusal> {
    text.count_lines()
        .map_err(|e| Refusal::Unreadable(unreadable(1, e.kind())))
}

/// What of a line goes to the controller.
pub(super) struct Sent {
    /// Nothing of comments, `%`, blanks, `$` lines, and no M6, which the session keeps for itself.
    pub content: String,
    /// There was an M6.
    pub change: bool,
}

pub(super) fn sent(text: &str, skips_slashed: bool) -> Sent {
    let mut out = String::new();
    let mut parenthesis = false;
    for c in text.chars() {
        match c {
            ')' if parenthesis => parenthesis = false,
            _ if parenthesis => {}
            '(' => parenthesis = true,
            ';' => break,
            c if c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    // A `$` line sets what no mode knows of.
    if out == "%" || out.starts_with('$') || (skips_slashed && out.starts_with('/')) {
        out.clear();
    }
    let change = tool_change(&out);
    if let Some((from, to)) = change {
        out.replace_range(from..to, "");
    }
    Sent {
        content: out,
        change: change.is_some(),
    }
}

/// Where M6 stands in a line without blanks.
fn tool_change(line: &str) -> Option<(usize, usize)> {
    let bytes = line.as_bytes();
    let at = |i: usize| bytes.get(i).copied().unwrap_or(0);
    let mut i = 0;
    while i < bytes.len() {
        if at(i) == b'M' {
            let mut end = i + 1;
            while at(end) == b'0' {
                end += 1;
            }
            if at(end) == b'6' && !at(end + 1).is_ascii_digit() && at(end + 1) != b'.' {
                return Some((i, end + 1));
            }
        }
        i += 1;
    }
    None
}

impl Begin {
    /// What the machine remembered at line 1.
    pub fn start_state(&self) -> State {
        let dialect = Dialect::from_name(&self.dialect).unwrap_or(Dialect::Grbl);
        self.start.state(dialect)
    }
}

impl Start {
    /// What the machine remembers: the modes of a job's start with these offsets and this position. Spindle and coolant that ran already
    /// run on.
    pub fn state(&self, dialect: Dialect) -> State {
        let mut state = fresh(dialect, &self.offsets, &self.position);
        for word in self.modes.split_whitespace() {
            match word {
                "M3" => state.spindle = 1,
                "M4" => state.spindle = -1,
                "M7" => state.mist = true,
                "M8" => state.flood = true,
                _ => {
                    let speed = word.strip_prefix('S').and_then(|s| s.parse::<f64>().ok());
                    if let Some(speed) = speed.filter(|s| s.is_finite() && *s >= 0.0) {
                        state.speed = Rpm(speed);
                    }
                }
            }
        }
        state
    }
}

/// The offsets behind a tool change. Nothing moves.
pub(super) fn measured(state: &mut State, offsets: &Offsets) {
    let here = state.machine_position();
    state.g5x = offsets.g5x.map(Vector::from);
    state.g92 = Vector::from(offsets.g92);
    state.tlo = offsets.tlo;
    state.set_machine_position(&here);
}

/// A machine with the modes of a reset, these offsets, standing there.
pub(super) fn fresh(dialect: Dialect, offsets: &Offsets, machine: &[f64; 3]) -> State {
    let mut state = State::new(dialect);
    state.g5x = offsets.g5x.map(Vector::from);
    (state.g28, state.g30) = (Point::from(offsets.g28), Point::from(offsets.g30));
    state.g92 = Vector::from(offsets.g92);
    state.tlo = offsets.tlo;
    state.set_machine_position(&Point::from(*machine));
    state
}
