//! Lines of words that say something of the order of lines, or hold variables: program numbers, M97 M98 M99, G65, GOTO, IF, WHILE.
//!
//! Rules: Fanuc Series 30i/0i-F Operator's Manual (Subprogram; Custom Macro: Branch and Repetition, Macro Call); Haas Mill Operator's Manual
//! (M97, M98, M99, Macros); Mach3Mill G-code reference and Mach4 G-code reference (M98, M99); LinuxCNC O Codes (Fanuc-Style Programs). One
//! file is read: what these controllers look for in other files is refused by name.

use super::expand::{Expanded, expand};
use super::frame::Kind;
use super::front::{Front, front, program_number};
use super::okuma;
use super::{FlowComplaint, Interpreter, flow};
use crate::gcode::dialect::Dialect;
use crate::gcode::error::Fault;
use crate::gcode::event::Event;
use crate::gcode::expression::{Evaluator, fault, is_ngc};
use crate::gcode::interpret::carry_out;
use crate::gcode::parameter::Parameter;
use crate::gcode::source::LineStart;
use std::io::{BufRead, Seek};

/// Macro B: G65, IF, WHILE, GOTO.
pub(super) fn has_macros(dialect: Dialect) -> bool {
    use Dialect::{Centroid, Fanuc, Haas, Mach4, Mazak};
    matches!(dialect, Fanuc | Haas | Mazak | Mach4 | Centroid)
}

/// `#` and `[ ]`.
fn has_variables(dialect: Dialect) -> bool {
    has_macros(dialect) || is_ngc(dialect)
}

/// Numbered programs, M98, M99. Okuma calls otherwise (CALL, RTS), and so does EdingCNC (GOSUB): both are refused as unknown words.
fn has_programs(dialect: Dialect) -> bool {
    !matches!(dialect, Dialect::Okuma | Dialect::Eding)
}

/// `o100 sub`, `o100 if`.
pub(super) fn has_owords(dialect: Dialect) -> bool {
    matches!(dialect, Dialect::LinuxCnc | Dialect::Planet)
}

impl<R: BufRead + Seek> Interpreter<R> {
    /// Reads values of a line.
    pub(super) fn evaluator<'a>(&'a self, text: &'a str, at: usize) -> Evaluator<'a> {
        let mut e = Evaluator::new(text, &self.parameters, &self.state);
        e.at = at;
        e
    }

    /// A line of a word-address program.
    pub(super) fn words_line(
        &mut self,
        text: &str,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let dialect = self.state.dialect;
        let front = front(text);
        if front.slash && self.state.block_delete {
            return Ok(());
        }
        let rest = text.get(front.body..).unwrap_or_default();
        // Okuma OSP: the name of the file, before the program.
        if dialect == Dialect::Okuma
            && !self.begun
            && rest.starts_with('$')
            && rest.trim_end().ends_with('%')
        {
            return Ok(());
        }
        if dialect == Dialect::Okuma {
            if !self.begun && okuma::is_name(rest) {
                self.begun = true;
                return Ok(());
            }
            okuma::check(rest, front.body)?;
        }
        // Okuma's programs have numbers, too, but nothing here calls them.
        if rest.starts_with(['O', 'o', ':']) && dialect != Dialect::Eding {
            return self.program_line(text, front, here);
        }
        if has_macros(dialect) {
            let keyword = self.evaluator(text, front.body).letters();
            let behind = front.body + keyword.len();
            match &*keyword {
                "GOTO" => return self.goto(text, behind),
                "IF" => return self.condition(text, behind),
                "WHILE" => return self.while_line(text, behind, here),
                "DO" => return self.do_line(text, behind, None, here),
                "END" => return self.end_line(text, behind, here),
                _ => {}
            }
        }
        self.words(text, front, here, events)
    }

    /// Nothing but comments may follow.
    pub(super) fn alone(&self, text: &str, at: usize, statement: &str) -> Result<(), Fault> {
        let mut at = at;
        loop {
            let mut e = self.evaluator(text, at);
            match e.peek() {
                None | Some(b';') => return Ok(()),
                Some(b'(') => {
                    let rest = text.get(e.at..).unwrap_or_default();
                    let close = rest.find(')').ok_or_else(|| {
                        flow(
                            e.at,
                            FlowComplaint::StatementAlone {
                                statement: statement.into(),
                            },
                        )
                    })?;
                    at = e.at + close + 1;
                }
                Some(_) => {
                    let statement = statement.into();
                    return Err(flow(e.at, FlowComplaint::StatementAlone { statement }));
                }
            }
        }
    }

    /// `O1234`, `:1234`, `o100 sub`.
    fn program_line(&mut self, text: &str, front: Front, here: LineStart) -> Result<(), Fault> {
        if has_owords(self.state.dialect)
            && !text.get(front.body..).unwrap_or_default().starts_with(':')
        {
            return self.oword_line(text, front.body, here);
        }
        self.numbered_program(text, front.body, here)
    }

    /// The first line of a numbered program.
    pub(super) fn numbered_program(
        &mut self,
        text: &str,
        at: usize,
        here: LineStart,
    ) -> Result<(), Fault> {
        let Some((number, behind)) = program_number(text) else {
            let (statement, what) = ("O".into(), "a number");
            return Err(flow(at, FlowComplaint::Incomplete { statement, what }));
        };
        let label: Box<str> = format!("O{number}").into();
        self.alone(text, behind, &label)?;
        let next = self.source.place();
        let begun = std::mem::replace(&mut self.begun, true);
        let frame = self.frame();
        if frame.kind == Kind::Main && !begun {
            frame.scope = next;
            return Ok(());
        }
        if frame.kind != Kind::Main && frame.entry == here {
            frame.scope = next;
            return Ok(());
        }
        self.over = true;
        Err(flow(at, FlowComplaint::RunsInto { label }))
    }

    /// Words, settings, calls.
    fn words(
        &mut self,
        text: &str,
        front: Front,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let dialect = self.state.dialect;
        let computed = text.contains(['#', '[']);
        if computed && !has_variables(dialect) {
            return self.plain_words(text, here.line, events);
        }
        let line = expand(text, front.words, &self.parameters, &self.state)?;
        self.may_set(&line)?;
        // Macro B: a setting is a statement, and a statement has its line for itself.
        let lone = has_macros(dialect) && !line.settings.is_empty();
        if lone && let Some(other) = line.words.iter().find(|w| !matches!(w.letter, 0 | b'N')) {
            let statement = "a setting of variables".into();
            return Err(flow(other.at, FlowComplaint::StatementAlone { statement }));
        }
        self.begun |= !(line.words.is_empty() && line.settings.is_empty());
        if let Some(call) = line.find(b'M', 98.0).filter(|_| has_programs(dialect)) {
            return self.call(line, call, here, events);
        }
        if let Some(back) = line.find(b'M', 99.0).filter(|_| has_programs(dialect)) {
            return self.back(line, back, here, events);
        }
        if let Some(call) = line.find(b'M', 97.0).filter(|_| dialect == Dialect::Haas) {
            return self.local_call(line, call, here, events);
        }
        if let Some(call) = line.find(b'G', 65.0).filter(|_| has_macros(dialect)) {
            return self.macro_call(line, call);
        }
        if computed {
            self.expanded_words(&line, here.line, events)
        } else {
            self.plain_words(text, here.line, events)
        }
    }

    /// A line of words and nothing else.
    fn plain_words(
        &mut self,
        text: &str,
        line: usize,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let first = events.len();
        carry_out(&mut self.state, text, line, events)?;
        let new = events.get(first..).unwrap_or_default();
        self.over |= new.iter().any(|e| matches!(e, Event::End { .. }));
        Ok(())
    }

    /// A line whose variables have been replaced; sets what it sets.
    pub(super) fn expanded_words(
        &mut self,
        line: &Expanded,
        number: usize,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let done = self.plain_words(&line.text, number, events);
        done.map_err(|f| line.blame(f))?;
        for (which, value) in &line.settings {
            self.parameters.set(which, *value);
        }
        Ok(())
    }

    /// Checks that a line's variables can be set. Setting #3000 of Macro B stops the machine with an alarm.
    pub(super) fn may_set(&mut self, line: &Expanded) -> Result<(), Fault> {
        for (which, value) in &line.settings {
            let alarm = *which == Parameter::Number(3000) && has_macros(self.state.dialect);
            if let (true, Some(number)) = (alarm, *value) {
                self.over = true;
                return Err(flow(line.setting_at, FlowComplaint::Alarm { number }));
            }
            let may = self.parameters.may_set(which);
            may.map_err(|c| fault(line.setting_at, c))?;
        }
        Ok(())
    }
}
