//! A whole program, line by line, in the order in which the machine takes them: memory does not grow with its length.
//!
//! Crosses the border: program text that can be read and wound in; [`Event`]s, mistakes, and what the machine remembers out. What one line
//! means is `block`, `check`, `execute` and the tongues' business; here stand calls, jumps, loops, variables, and where a program ends.
//!
//! ```text
//! source -> line -> plain words? -> carried out                              events
//!                   else: expand (variables) -> carried out, then:           order of lines
//!                   words: M98 M99 G65 GOTO WHILE; oword: o100 sub if while; tongues: Flow
//! ```
//!
//! Controllers that are fed line by line (GRBL and its kin, Marlin, ...) have none of this: their lines go straight through.

mod calls;
mod complaint;
mod expand;
mod frame;
mod front;
mod labels;
mod macros;
mod okuma;
mod oword;
mod tongue;
mod words;

pub use complaint::FlowComplaint;

use super::dialect::Dialect;
use super::error::{Complaint, Fault, InterpretError};
use super::event::Event;
use super::interpret::{MAX_ERRORS, carry_out};
use super::parameter::Parameters;
use super::source::{LONGEST, LineStart, Source};
use super::state::State;
use super::{heidenhain, siemens};
use frame::{Frame, Watch};
use labels::Labels;
use std::io::{self, BufRead, Seek};

/// More than nearly any line has.
pub const LINE_BYTES: usize = 256;

/// How a program is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// So many lines may be read again (loops, calls) before a program is refused for not ending. Each [`LINE_BYTES`] of a long line
    /// count as one more.
    pub lines_again: u64,
    /// Comments are kept until taken with [`Interpreter::take_comments`].
    pub comments: bool,
}

impl Default for Reading {
    fn default() -> Reading {
        Reading {
            lines_again: 100_000_000,
            comments: false,
        }
    }
}

/// A comment of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Comment {
    /// Its line, from 1.
    pub line: usize,
    /// Without its marks.
    pub text: String,
}

/// Most comments that are kept untaken.
const MOST_COMMENTS: usize = 10_000;

/// Whose lines they are.
#[derive(Clone, Debug, PartialEq)]
enum Language {
    /// Every line by itself.
    Fed,
    /// Words, with variables and flow.
    Words,
    Siemens(siemens::Memory),
    Heidenhain(heidenhain::Memory),
}

impl Language {
    fn of(dialect: Dialect) -> Language {
        use Dialect as D;
        match dialect {
            D::Grbl
            | D::GrblHal
            | D::FluidNc
            | D::Marlin
            | D::Smoothie
            | D::RepRap
            | D::TinyG
            | D::Carbide => Language::Fed,
            D::Siemens => Language::Siemens(siemens::Memory::default()),
            D::Heidenhain => Language::Heidenhain(heidenhain::Memory::default()),
            _ => Language::Words,
        }
    }
}

/// Reads a program and says what it tells the machine, in order: an iterator of events and mistakes.
///
/// A refused line changes nothing, and reading goes on with the next one; behind [`MAX_ERRORS`] mistakes, and behind one that leaves no way on,
/// it ends. A program with any mistake is not to be run. The same mistake of the same line is said once, however often the line is read.
#[derive(Debug)]
pub struct Interpreter<R> {
    source: Source<R>,
    state: State,
    language: Language,
    reading: Reading,
    parameters: Parameters,
    /// The calls under way; the first is the main program, and there always is one.
    frames: Vec<Frame>,
    labels: Labels,
    watch: Watch,
    /// Events of lines read that were not handed out yet, from `handed` on.
    events: Vec<Event>,
    handed: usize,
    errors: Vec<InterpretError>,
    /// Behind the last line that was read.
    furthest: LineStart,
    again: u64,
    /// The first line of `%`.
    tape: Option<usize>,
    /// A line of words was carried out.
    begun: bool,
    over: bool,
    comments: Vec<Comment>,
    text: String,
}

impl<R: BufRead + Seek> Interpreter<R> {
    /// A program read by a machine just switched on.
    ///
    /// # Errors
    /// What reading answers.
    pub fn new(from: R, dialect: Dialect) -> io::Result<Interpreter<R>> {
        Interpreter::from_state(from, State::new(dialect), Reading::default())
    }

    /// A program read by a machine that remembers something.
    ///
    /// # Errors
    /// What reading answers.
    pub fn from_state(from: R, state: State, reading: Reading) -> io::Result<Interpreter<R>> {
        let source = Source::new(from)?;
        let top = source.place();
        Ok(Interpreter {
            source,
            language: Language::of(state.dialect),
            parameters: Parameters::new(state.dialect),
            state,
            reading,
            frames: vec![Frame::main(top)],
            labels: Labels::default(),
            watch: Watch::default(),
            events: Vec::new(),
            handed: 0,
            errors: Vec::new(),
            furthest: top,
            again: 0,
            tape: None,
            begun: false,
            over: false,
            comments: Vec::new(),
            text: String::new(),
        })
    }

    /// What the machine remembers behind the last line read. Events not yet taken from the iterator are part of it.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The same, to take note of what the program cannot know. Events already read stay as they are.
    pub fn state_mut(&mut self) -> &mut State {
        &mut self.state
    }

    /// The text of a line, for messages; empty where there is none. Reads the program from its beginning.
    pub fn text_of(&mut self, line: usize) -> String {
        let here = self.source.place();
        let mut find = || -> io::Result<String> {
            self.source.rewind()?;
            while let Some((at, text)) = self.source.read()? {
                if at == line {
                    return Ok(text.to_string());
                }
            }
            Ok(String::new())
        };
        let found = find().unwrap_or_default();
        // Where even this fails, the next read says so.
        let _ = self.source.go(here);
        found
    }

    /// Lines of the text that were reached so far.
    pub fn lines(&self) -> usize {
        self.furthest.line.saturating_sub(1)
    }

    /// Mistakes found so far.
    pub fn errors(&self) -> &[InterpretError] {
        &self.errors
    }

    /// The comments of the lines read since this was last asked, in order; always empty unless [`Reading::comments`].
    pub fn take_comments(&mut self) -> Vec<Comment> {
        std::mem::take(&mut self.comments)
    }

    /// Reads to the end of the text without carrying anything out; how many lines it has.
    ///
    /// # Errors
    /// What reading answers.
    pub fn count_lines(&mut self) -> io::Result<usize> {
        self.over = true;
        self.source.go(self.furthest)?;
        while self.source.read()?.is_some() {}
        self.furthest = self.source.place();
        Ok(self.lines())
    }

    /// Reads on into `events` until the program is over: all its mistakes, none if it is sound.
    pub fn read_all(&mut self, events: &mut Vec<Event>) -> Vec<InterpretError> {
        let mut errors = Vec::new();
        while !self.over {
            if let Err(e) = self.line(events) {
                errors.extend(self.report(e));
            }
        }
        errors
    }

    /// Reads on until the program is over and tells each event as it comes: all its mistakes, none if it is sound. Events told before a
    /// mistake are those of a program that is not to be run.
    pub fn tell_all(&mut self, hear: &mut dyn FnMut(&Event)) -> Vec<InterpretError> {
        let mut errors = Vec::new();
        let mut events = std::mem::take(&mut self.events);
        events.drain(..self.handed);
        self.handed = 0;
        loop {
            events.iter().for_each(&mut *hear);
            events.clear();
            if self.over {
                return errors;
            }
            if let Err(e) = self.line(&mut events) {
                errors.extend(self.report(e));
            }
        }
    }

    /// Reads one line.
    fn line(&mut self, events: &mut Vec<Event>) -> Result<(), InterpretError> {
        let here = self.source.place();
        let (line, text) = match self.source.read() {
            Ok(Some(read)) => read,
            Ok(None) => {
                let ended = self.end_of_text();
                return ended.map_err(|f| f.locate("", here.line));
            }
            Err(e) => return Err(unreadable(&e).locate("", here.line)),
        };
        if line < self.furthest.line {
            // A line as long as a page is as much work as a page of lines.
            self.again += 1 + (text.len() / LINE_BYTES) as u64;
            if self.again > self.reading.lines_again {
                self.over = true;
                let lines = self.reading.lines_again;
                return Err(flow(0, FlowComplaint::TooLong { lines }).locate("", line));
            }
        }
        // What nearly every line is: words that say nothing of the order of lines.
        let plain = match self.language {
            Language::Fed => {
                !text.starts_with('%')
                    && (self.state.dialect == Dialect::Grbl || !text.contains('\0'))
            }
            Language::Words => plain(text.as_bytes()),
            _ => false,
        };
        if plain && !self.reading.comments {
            let done = match text.len() == LONGEST {
                true => Err(flow(0, FlowComplaint::LineLonger { limit: LONGEST })),
                false => carry_out(&mut self.state, text, line, events),
            };
            self.begun = self.begun || !text.trim().is_empty();
            let done = done.map_err(|f| f.locate(text, line));
            if line >= self.furthest.line {
                self.furthest = self.source.place();
            }
            return done;
        }
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        text.push_str(self.source.last());
        if line >= self.furthest.line {
            self.furthest = self.source.place();
        }
        let done = self.other_line(&text, here, events);
        let done = done.map_err(|f| f.locate(&text, line));
        self.text = text;
        done
    }

    /// A line that may say more than words.
    fn other_line(
        &mut self,
        text: &str,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        if self.source.was_cut() {
            return Err(flow(0, FlowComplaint::LineLonger { limit: LONGEST }));
        }
        if self.state.dialect != Dialect::Grbl
            && let Some(at) = text.bytes().position(|b| b == 0)
        {
            return Err(flow(at, FlowComplaint::Nul));
        }
        if self.reading.comments {
            self.keep_comments(text, here.line);
        }
        let mark = match self.language {
            Language::Fed => text.trim_end(),
            _ => text.trim(),
        };
        if mark == "%" {
            // The mark behind the program: nothing behind it is read (LinuxCNC, Overview; ISO 6983).
            if self.is_end_mark(here.line) && self.language != Language::Fed {
                return self.end_of_text();
            }
            return Ok(());
        }
        match self.language {
            Language::Fed => carry_out(&mut self.state, text, here.line, events),
            Language::Words => self.words_line(text, here, events),
            _ => self.tongue_line(text, here, events),
        }
    }

    /// A line of `%`: true for the one behind the program.
    fn is_end_mark(&mut self, line: usize) -> bool {
        let first = *self.tape.get_or_insert(line);
        line > first
    }

    /// What is to be said of a mistake, if anything.
    fn report(&mut self, e: InterpretError) -> Option<InterpretError> {
        if matches!(
            e.complaint,
            Complaint::Flow(FlowComplaint::Unreadable { .. })
        ) {
            self.over = true;
        }
        let again = e.complaint == Complaint::FeedMissing
            && self
                .errors
                .last()
                .is_some_and(|l| l.complaint == e.complaint);
        if again || self.errors.contains(&e) {
            return None;
        }
        self.errors.push(e.clone());
        self.over |= self.errors.len() >= MAX_ERRORS;
        Some(e)
    }

    fn keep_comments(&mut self, text: &str, line: usize) {
        let round = !matches!(
            self.language,
            Language::Siemens(_) | Language::Heidenhain(_)
        );
        for text in comments(text, round) {
            if self.comments.len() < MOST_COMMENTS {
                let text = text.trim().to_string();
                self.comments.push(Comment { line, text });
            }
        }
    }
}

impl<R: BufRead + Seek> Iterator for Interpreter<R> {
    type Item = Result<Event, InterpretError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(event) = self.events.get(self.handed) {
                self.handed += 1;
                return Some(Ok(event.clone()));
            }
            if self.over {
                return None;
            }
            let mut events = std::mem::take(&mut self.events);
            events.clear();
            let done = self.line(&mut events);
            (self.events, self.handed) = (events, 0);
            if let Err(e) = done
                && let Some(e) = self.report(e)
            {
                return Some(Err(e));
            }
        }
    }
}

/// What stands in comments: behind `;`, and in `( )` where these are comments.
fn comments(text: &str, round: bool) -> Vec<&str> {
    let mut out = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(|c| c == ';' || (round && c == '(')) {
        let (mark, behind) = rest.split_at(at).1.split_at(1);
        if mark == ";" {
            out.push(behind);
            break;
        }
        let (inside, after) = behind.split_once(')').unwrap_or((behind, ""));
        out.push(inside);
        rest = after;
    }
    out
}

/// Letters, digits and signs that say nothing of the order of lines, and no more than a line may hold. `G6` may be G65, a macro call.
fn plain(line: &[u8]) -> bool {
    let mut before = 0;
    for b in line {
        let kind = KIND[usize::from(*b)];
        if kind == 0 || (kind == SIX && before == GEE) {
            return false;
        }
        before = kind;
    }
    true
}

const OTHER: u8 = 1;
const GEE: u8 = 2;
const SIX: u8 = 3;

/// What each byte can mean to the order of lines: 0: more than [`plain`] knows.
const KIND: [u8; 256] = {
    let mut kind = [0; 256];
    let harmless = b"0123456789.+- \tDFGHIJKLNPQRSTXYZdfghijklnpqrstxyz";
    let mut i = 0;
    while i < harmless.len() {
        kind[harmless[i] as usize] = OTHER;
        i += 1;
    }
    kind[b'G' as usize] = GEE;
    kind[b'g' as usize] = GEE;
    kind[b'6' as usize] = SIX;
    kind
};

/// A mistake in the order of lines, at a byte of its line.
fn flow(at: usize, complaint: FlowComplaint) -> Fault {
    Fault::at(
        at.min(super::word::MAX_COLUMN) as u32,
        Complaint::Flow(complaint),
    )
}

/// A mistake that is the file's.
fn unreadable(e: &io::Error) -> Fault {
    flow(0, FlowComplaint::Unreadable { kind: e.kind() })
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
