//! Calls under way, loops under way, and when they go round for ever.
//!
//! Crosses the border: nothing but places of lines and counts. A program is a machine without chance: if a jump leads to a line where everything
//! is as it was when it was there before, it will lead there again for ever.

use super::labels::Found;
use super::{FlowComplaint, Interpreter, Language, flow, unreadable};
use crate::gcode::dialect::Dialect;
use crate::gcode::error::Fault;
use crate::gcode::parameter::Parameters;
use crate::gcode::source::LineStart;
use crate::gcode::state::State;
use crate::gcode::{heidenhain, siemens};
use std::io::{BufRead, Seek};

/// What called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Nothing: the main program.
    Main,
    /// M98, M97, a tongue's call: the caller's variables.
    Program,
    /// G65: its own variables.
    Macro,
    /// `o100 call`.
    Subroutine,
}

/// A call under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    pub kind: Kind,
    /// Who was called: `O1234`, `N100`.
    pub label: Box<str>,
    /// Where each round begins.
    pub entry: LineStart,
    /// Behind the call.
    pub back: LineStart,
    /// Rounds still to come.
    pub left: u32,
    /// Where line numbers are looked for from.
    pub scope: LineStart,
    pub loops: Vec<Loop>,
    /// Repeats under way: their line and the rounds still to come.
    pub repeats: Vec<(usize, u32)>,
    /// What a macro was handed.
    pub arguments: Vec<(u32, f64)>,
}

impl Frame {
    /// The main program.
    pub fn main(top: LineStart) -> Frame {
        Frame {
            kind: Kind::Main,
            label: "".into(),
            entry: top,
            back: top,
            left: 0,
            scope: top,
            loops: Vec::new(),
            repeats: Vec::new(),
            arguments: Vec::new(),
        }
    }

    /// A call.
    pub fn call(kind: Kind, label: Box<str>, entry: LineStart, times: u32) -> Frame {
        Frame {
            kind,
            label,
            left: times.saturating_sub(1),
            ..Frame::main(entry)
        }
    }
}

/// What a loop or condition is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LoopKind {
    /// The condition was not met yet (true), or was.
    If(bool),
    While,
    Do,
    /// Rounds still to come.
    Repeat(u32),
}

/// A loop or condition under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loop {
    pub kind: LoopKind,
    /// `O100`, `1`.
    pub label: Box<str>,
    /// Its first line.
    pub head: LineStart,
    /// Behind that.
    pub inside: LineStart,
    /// Its last line's number.
    pub end: usize,
}

/// What is remembered to see that nothing has changed: at jumps 1, 2, 4, 8 ... (Brent, BIT 20, 1980).
#[derive(Debug, Default)]
pub(super) struct Watch {
    seen: Option<Box<Moment>>,
    steps: u64,
    next: u64,
}

#[derive(Debug, PartialEq)]
struct Moment {
    place: LineStart,
    state: State,
    language: Language,
    frames: Vec<Frame>,
    parameters: Parameters,
}

/// Loops inside loops and conditions of one call.
const MOST_LOOPS: usize = 100;

impl<R: BufRead + Seek> Interpreter<R> {
    /// Deepest calls inside calls.
    fn deepest(&self) -> usize {
        match self.state.dialect {
            // Sinumerik Programming Manual: sixteen levels; Heidenhain TNC, User's Manual: nineteen.
            Dialect::Siemens => 16,
            Dialect::Heidenhain => 19,
            // LinuxCNC, O Codes; Fanuc 30i and 0i-F: ten.
            _ => 10,
        }
    }

    /// Goes on at a line. Where that leads round for ever, the program is over.
    pub(super) fn jump(&mut self, to: LineStart) -> Result<(), Fault> {
        self.source.go(to).map_err(|e| unreadable(&e))?;
        let same = self.watch.seen.as_ref().is_some_and(|m| {
            m.place == to
                && m.state == self.state
                && m.frames == self.frames
                && m.language == self.language
                && m.parameters == self.parameters
        });
        if same {
            self.over = true;
            return Err(flow(0, FlowComplaint::Endless));
        }
        self.watch.steps += 1;
        if self.watch.steps > self.watch.next {
            self.watch.next = self.watch.steps * 2;
            self.watch.seen = Some(Box::new(Moment {
                place: to,
                state: self.state.clone(),
                language: self.language.clone(),
                frames: self.frames.clone(),
                parameters: self.parameters.clone(),
            }));
        }
        Ok(())
    }

    /// The call under way.
    pub(super) fn frame(&mut self) -> &mut Frame {
        if self.frames.is_empty() {
            self.frames.push(Frame::main(LineStart::default()));
        }
        let last = self.frames.len() - 1;
        &mut self.frames[last]
    }

    /// Checks that one more call may be made.
    pub(super) fn may_call(&self, at: usize) -> Result<(), Fault> {
        let limit = self.deepest();
        match self.frames.len() > limit {
            true => Err(flow(at, FlowComplaint::TooDeep { limit })),
            false => Ok(()),
        }
    }

    /// Enters a call.
    pub(super) fn enter(&mut self, frame: Frame) -> Result<(), Fault> {
        let (entry, back) = (frame.entry, self.source.place());
        self.frames.push(Frame { back, ..frame });
        self.jump(entry)
    }

    /// The call under way has come to its end: once more, or behind it. Of the main program: nothing.
    pub(super) fn give_back(&mut self) -> Result<(), Fault> {
        let frame = self.frame();
        if frame.kind == Kind::Main {
            return Ok(());
        }
        frame.loops.clear();
        frame.repeats.clear();
        let (entry, back, kind) = (frame.entry, frame.back, frame.kind);
        let (left, arguments) = (frame.left, frame.arguments.clone());
        if kind != Kind::Program {
            self.parameters.leave();
        }
        if left > 0 {
            self.frame().left -= 1;
            if kind == Kind::Macro {
                self.parameters.enter_macro(&arguments);
            }
            return self.jump(entry);
        }
        self.frames.pop();
        self.jump(back)
    }

    /// Opens a loop or condition.
    pub(super) fn open(&mut self, one: Loop, at: usize) -> Result<(), Fault> {
        let loops = &mut self.frame().loops;
        if loops.len() >= MOST_LOOPS {
            let limit = MOST_LOOPS;
            return Err(flow(at, FlowComplaint::TooDeep { limit }));
        }
        loops.push(one);
        Ok(())
    }

    /// Leaves the loops that a line is not in.
    pub(super) fn leave_loops(&mut self, line: usize) {
        self.frame()
            .loops
            .retain(|l| (l.head.line..=l.end).contains(&line));
    }

    /// The first line behind this one that is looked for; `from` is this line's number and `what` names the search.
    pub(super) fn ahead(
        &mut self,
        from: usize,
        what: &str,
        kind: impl FnMut(&str) -> Option<u8>,
    ) -> Result<Option<Found>, Fault> {
        let found = self
            .labels
            .ahead(&mut self.source, (from, what), usize::MAX, kind);
        found.map_err(|e| unreadable(&e))
    }

    /// The text is over, or a `%` says so.
    pub(super) fn end_of_text(&mut self) -> Result<(), Fault> {
        let ended = match &self.language {
            Language::Siemens(memory) => Some(siemens::finish(memory)),
            Language::Heidenhain(memory) => Some(heidenhain::finish(memory)),
            Language::Words | Language::Fed => None,
        };
        if let Some(ended) = ended {
            self.over = true;
            // Behind a mistake, what is missing may be its doing.
            return if self.errors.is_empty() {
                ended
            } else {
                Ok(())
            };
        }
        let frame = self.frame();
        if frame.kind == Kind::Main {
            let open = frame.loops.first().map(|l| (l.label.clone(), l.kind));
            self.over = true;
            return match open {
                Some((label, LoopKind::If(_))) => {
                    let (opening, closing) = (
                        format!("{label} if").into(),
                        format!("{label} endif").into(),
                    );
                    Err(flow(0, FlowComplaint::NotClosed { opening, closing }))
                }
                _ => Ok(()),
            };
        }
        let label = frame.label.clone();
        let end = match frame.kind {
            Kind::Subroutine => format!("{label} endsub").into(),
            _ => "M99".into(),
        };
        self.over = true;
        Err(flow(0, FlowComplaint::NoReturn { label, end }))
    }
}
