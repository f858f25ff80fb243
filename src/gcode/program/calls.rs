//! Calls of subprograms and macros, and the way back: M97, M98, M99, G65; where programs and numbered lines are.

use super::expand::{Expanded, Spot};
use super::frame::{Frame, Kind};
use super::front::{LARGEST, front, program_name, whole};
use super::labels::{STOP, Start};
use super::words::{has_macros, has_owords};
use super::{FlowComplaint, Interpreter, flow, oword, unreadable};
use crate::gcode::dialect::Dialect;
use crate::gcode::error::{Complaint, Fault};
use crate::gcode::event::Event;
use crate::gcode::source::LineStart;
use std::io::{BufRead, Seek};

/// Most repetitions of a call.
const MOST_TIMES: u32 = 9999;

impl<R: BufRead + Seek> Interpreter<R> {
    /// A whole number out of a word.
    fn whole(&self, spot: Spot, what: &'static str, least: u32, most: u32) -> Result<u32, Fault> {
        whole(spot.value, spot.at, what, least, most)
    }

    /// The word's value, its letter removed; the default without it.
    fn repetitions(&self, line: &mut Expanded, letter: u8, least: u32) -> Result<u32, Fault> {
        let Some(spot) = line.letter(letter) else {
            return Ok(1);
        };
        line.strike(spot);
        self.whole(spot, "the number of repetitions", least, MOST_TIMES)
    }

    /// M98.
    pub(super) fn call(
        &mut self,
        mut line: Expanded,
        m98: Spot,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let dialect = self.state.dialect;
        let Some(p) = line.letter(b'P') else {
            let (command, word) = ("M98", "P (the program's number)");
            return Err(Fault::at(
                m98.at as u32,
                Complaint::ValueMissing { command, word },
            ));
        };
        let mut number = self.whole(p, "the program's number (P)", 0, LARGEST)?;
        line.strike(m98);
        line.strike(p);
        let counted = line.letter(b'L').is_some();
        let least = u32::from(dialect != Dialect::LinuxCnc);
        let mut times = self.repetitions(&mut line, b'L', least)?;
        // Fanuc: the last four digits name the program, those before them say how often.
        if dialect == Dialect::Fanuc && number > 9999 {
            if counted {
                return Err(flow(
                    p.at,
                    FlowComplaint::Range {
                        what: "beside L, the program's number (P)",
                        least: 1,
                        most: 9999,
                        value: p.value,
                    },
                ));
            }
            (times, number) = (number / 10_000, number % 10_000);
        }
        let start = self.program_start(number, p.at)?;
        if dialect == Dialect::LinuxCnc && start.line <= here.line {
            let (label, line) = (format!("O{number}").into(), start.line);
            return Err(flow(p.at, FlowComplaint::DefinedAbove { label, line }));
        }
        self.may_call(m98.at)?;
        self.expanded_words(&line, here.line, events)?;
        if times == 0 {
            return Ok(());
        }
        let label = format!("O{number}").into();
        self.enter(Frame::call(Kind::Program, label, start, times))
    }

    /// Where a numbered program begins.
    fn program_start(&mut self, number: u32, at: usize) -> Result<LineStart, Fault> {
        let label: Box<str> = format!("O{number}").into();
        let start = self.start_of(&label)?;
        let Some(start) = start else {
            return Err(flow(at, FlowComplaint::ProgramMissing { label }));
        };
        match start.second {
            None => Ok(start.found.line),
            Some(second) => {
                let first = start.found.line.line;
                Err(flow(
                    at,
                    FlowComplaint::ProgramTwice {
                        label,
                        first,
                        second,
                    },
                ))
            }
        }
    }

    /// The first line of a program or subroutine.
    pub(super) fn start_of(&mut self, label: &str) -> Result<Option<Start>, Fault> {
        let owords = has_owords(self.state.dialect);
        let name = |text: &str| {
            let sub = if owords {
                oword::subroutine_name(text)
            } else {
                None
            };
            sub.or_else(|| program_name(text))
        };
        let found = self.labels.program(&mut self.source, label, name);
        found.map_err(|e| unreadable(&e))
    }

    /// M99.
    pub(super) fn back(
        &mut self,
        mut line: Expanded,
        m99: Spot,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        line.strike(m99);
        let to = line.letter(b'P').filter(|_| has_macros(self.state.dialect));
        let to = to.map(|p| {
            line.strike(p);
            self.whole(p, "the line number (P)", 1, LARGEST)
                .map(|n| (n, p.at))
        });
        let to = to.transpose()?;
        let (kind, left) = (self.frame().kind, self.frame().left);
        if kind == Kind::Subroutine {
            let (closing, opening) = ("M99".into(), "M98".into());
            return Err(flow(m99.at, FlowComplaint::NotOpened { closing, opening }));
        }
        let start = m99.at as u32;
        let to = match (kind, to) {
            (Kind::Main, Some((n, at))) => Some(self.line_number(n, at)?),
            // To a line of the program that called, looked for from behind its call.
            (_, Some((n, at))) if left == 0 => Some(self.callers_line_number(n, at)?),
            _ => None,
        };
        self.expanded_words(&line, here.line, events)?;
        if kind != Kind::Main {
            self.give_back()?;
        } else if to.is_none() {
            let frame = self.frame();
            frame.loops.clear();
            let top = frame.scope;
            return self.jump(top).map_err(|f| Fault { offset: start, ..f });
        }
        let Some(to) = to else {
            return Ok(());
        };
        self.leave_loops(to.line);
        self.jump(to).map_err(|f| Fault { offset: start, ..f })
    }

    /// M97 (Haas): a subprogram of the same program, by line number.
    pub(super) fn local_call(
        &mut self,
        mut line: Expanded,
        m97: Spot,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let Some(p) = line.letter(b'P') else {
            let (command, word) = ("M97", "P (the line number)");
            return Err(Fault::at(
                m97.at as u32,
                Complaint::ValueMissing { command, word },
            ));
        };
        let number = self.whole(p, "the line number (P)", 1, LARGEST)?;
        line.strike(m97);
        line.strike(p);
        let times = self.repetitions(&mut line, b'L', 1)?;
        let place = self.line_number(number, p.at)?;
        self.may_call(m97.at)?;
        let scope = self.frame().scope;
        self.expanded_words(&line, here.line, events)?;
        let label = format!("N{number}").into();
        let frame = Frame::call(Kind::Program, label, place, times);
        self.enter(Frame { scope, ..frame })
    }

    /// G65.
    pub(super) fn macro_call(&mut self, mut line: Expanded, g65: Spot) -> Result<(), Fault> {
        let Some(p) = line.letter(b'P') else {
            let (command, word) = ("G65", "P (the macro's number)");
            return Err(Fault::at(
                g65.at as u32,
                Complaint::ValueMissing { command, word },
            ));
        };
        let number = self.whole(p, "the macro's number (P)", 1, LARGEST)?;
        line.strike(g65);
        line.strike(p);
        let times = self.repetitions(&mut line, b'L', 1)?;
        let mut arguments = Vec::new();
        for word in line.words.iter().filter(|w| w.letter != b'N') {
            let letter = char::from(word.letter);
            let at = word.at;
            let Some(number) = argument(word.letter).filter(|_| word.at > g65.at) else {
                return Err(flow(at, FlowComplaint::ArgumentLetter { letter }));
            };
            if !word.value.is_finite() {
                return Err(Fault::at(at as u32, Complaint::BadNumber { letter }));
            }
            if arguments.iter().any(|(n, _)| *n == number) {
                return Err(Fault::at(at as u32, Complaint::Repeated { letter }));
            }
            // Without a point the scale depends on the letter and on settings (Fanuc, Custom Macro, Argument Specification).
            let counts = matches!(word.letter, b'D' | b'H' | b'M' | b'S' | b'T');
            if !word.point && !counts && word.value != 0.0 {
                return Err(flow(at, FlowComplaint::ArgumentPoint { letter }));
            }
            arguments.push((number, word.value));
        }
        let start = self.program_start(number, p.at)?;
        self.may_call(g65.at)?;
        self.begun = true;
        self.parameters.enter_macro(&arguments);
        let label = format!("O{number}").into();
        let frame = Frame::call(Kind::Macro, label, start, times);
        self.enter(Frame { arguments, ..frame })
    }

    /// The line of this program that carries a number: the next below, else from the program's beginning.
    pub(super) fn line_number(&mut self, number: u32, at: usize) -> Result<LineStart, Fault> {
        let (start, scope) = (self.source.place(), self.frame().scope);
        self.numbered_line(number, start, scope, at)
    }

    /// The same in the program that called this one.
    fn callers_line_number(&mut self, number: u32, at: usize) -> Result<LineStart, Fault> {
        let start = self.frame().back;
        let caller = self.frames.len().saturating_sub(2);
        let scope = self.frames.get(caller).map_or(start, |f| f.scope);
        let here = self.source.place();
        self.source.go(start).map_err(|e| unreadable(&e))?;
        let found = self.numbered_line(number, start, scope, at);
        self.source.go(here).map_err(|e| unreadable(&e))?;
        found
    }

    /// The line with a number, from `start` (where the source stands) down, else from `scope` down to `start`.
    fn numbered_line(
        &mut self,
        number: u32,
        start: LineStart,
        scope: LineStart,
        at: usize,
    ) -> Result<LineStart, Fault> {
        let is = |text: &str| {
            let first = text.trim_start().bytes().next();
            match first {
                Some(b'N' | b'n' | b'/') if front(text).number == Some(number) => Some(0),
                Some(b'O' | b'o' | b':') => Some(STOP),
                _ => None,
            }
        };
        let label: Box<str> = format!("N{number}").into();
        let mut found = self.ahead(start.line, &format!("{label} below"), is)?;
        if found.is_none() {
            let scan = self.source.go(scope).and_then(|()| {
                let what = (start.line, &*format!("{label} above"));
                self.labels.ahead(&mut self.source, what, start.line, is)
            });
            found = scan.map_err(|e| unreadable(&e))?;
            self.source.go(start).map_err(|e| unreadable(&e))?;
        }
        match found {
            Some(found) => Ok(found.line),
            None => Err(flow(at, FlowComplaint::LabelMissing { label })),
        }
    }
}

/// Which variable a letter becomes (Fanuc, Custom Macro, Argument Specification I).
fn argument(letter: u8) -> Option<u32> {
    Some(match letter {
        b'A' => 1,
        b'B' => 2,
        b'C' => 3,
        b'I' => 4,
        b'J' => 5,
        b'K' => 6,
        b'D' => 7,
        b'E' => 8,
        b'F' => 9,
        b'H' => 11,
        b'M' => 13,
        b'Q'..=b'Z' => u32::from(letter - b'Q') + 17,
        _ => return None,
    })
}
