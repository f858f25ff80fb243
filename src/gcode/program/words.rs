//! Lines of words that say something of the order of lines, or hold variables: program numbers, M97 M98 M99, G65, GOTO, IF, WHILE.
//!
//! Rules: Fanuc Series 30i/0i-F Operator's Manual (Subprogram; Custom Macro: Branch and Repetition, Macro Call); Haas Mill Operator's Manual
//! (M97, M98, M99, Macros); Mach3Mill G-code reference and Mach4 G-code reference (M98, M99); LinuxCNC O Codes (Fanuc-Style Programs). One
//! file is read: what these controllers look for in other files is refused by name.

use super::expand::{Expanded, Spot, expand};
use super::frame::{Frame, Kind, Loop, LoopKind};
use super::labels::STOP;
use super::{FlowComplaint, Interpreter, flow, unreadable};
use crate::gcode::dialect::Dialect;
use crate::gcode::error::{Complaint, Fault};
use crate::gcode::event::Event;
use crate::gcode::expression::{Evaluator, fault, is_ngc};
use crate::gcode::interpret::carry_out;
use crate::gcode::source::LineStart;
use std::io::{BufRead, Seek};

/// Macro B: G65, IF, WHILE, GOTO.
fn has_macros(dialect: Dialect) -> bool {
    use Dialect::{Centroid, Fanuc, Haas, Mach4, Mazak};
    matches!(dialect, Fanuc | Haas | Mazak | Mach4 | Centroid)
}

/// `#` and `[ ]`.
fn has_variables(dialect: Dialect) -> bool {
    has_macros(dialect) || is_ngc(dialect)
}

/// `o100 sub`, `o100 if`.
pub(super) fn has_owords(dialect: Dialect) -> bool {
    matches!(dialect, Dialect::LinuxCnc | Dialect::Planet)
}

/// Largest line and program number.
const LARGEST: u32 = 99_999_999;
/// Most repetitions of a call.
const MOST_TIMES: u32 = 9999;

/// The front of a line: block delete, line number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Front {
    /// It begins with a slash.
    pub slash: bool,
    /// Behind the slash (and Fanuc's switch number).
    pub words: usize,
    /// Behind the line number.
    pub body: usize,
    /// The line number.
    pub number: Option<u32>,
}

/// Takes a line's front apart.
pub(super) fn front(text: &str) -> Front {
    let bytes = text.as_bytes();
    let blanks = |mut at: usize| {
        while bytes.get(at).is_some_and(|b| *b <= b' ') {
            at += 1;
        }
        at
    };
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let mut words = blanks(0);
    let slash = bytes.get(words) == Some(&b'/');
    if slash {
        words = blanks(digits(words + 1));
    }
    let (mut body, mut number) = (words, None);
    if let Some(b'N' | b'n') = bytes.get(words) {
        let from = blanks(words + 1);
        let to = digits(from);
        if to > from && bytes.get(to) != Some(&b'.') {
            number = text.get(from..to).and_then(|d| d.parse().ok());
            body = blanks(to);
        }
    }
    Front {
        slash,
        words,
        body,
        number,
    }
}

/// The number behind `O` or `:` where a line begins a numbered program; what follows it.
fn program_number(text: &str) -> Option<(u32, usize)> {
    let body = front(text).body;
    let rest = text.get(body..)?;
    let digits = rest.strip_prefix(['O', 'o', ':'])?.trim_start();
    let at = text.len() - digits.len();
    let count = digits.bytes().take_while(u8::is_ascii_digit).count();
    let number = digits.get(..count)?.parse().ok()?;
    Some((number, at + count))
}

/// The name under which a line's numbered program is called.
fn program_name(text: &str) -> Option<Box<str>> {
    let first = text.trim_start().bytes().next()?;
    if !matches!(first, b'O' | b'o' | b':' | b'N' | b'n' | b'/') {
        return None;
    }
    let (number, behind) = program_number(text)?;
    let keyword = text
        .get(behind..)?
        .trim_start()
        .starts_with(|c: char| c.is_ascii_alphabetic());
    (!keyword).then(|| format!("O{number}").into())
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
        if rest.starts_with(['O', 'o', ':']) && dialect != Dialect::Eding {
            return self.program_line(text, front, here);
        }
        if has_macros(dialect) {
            let keyword = self.evaluator(text, front.body).letters();
            let behind = front.body + keyword.len();
            match &*keyword {
                "GOTO" => return self.goto(text, behind, here),
                "IF" => return self.condition(text, behind, here),
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
        for (which, value) in &line.settings {
            if let (crate::gcode::parameter::Parameter::Number(3000), Some(number), false) =
                (which, value, is_ngc(dialect))
            {
                self.over = true;
                return Err(flow(
                    line.setting_at,
                    FlowComplaint::Alarm { number: *number },
                ));
            }
            self.parameters
                .may_set(which)
                .map_err(|c| fault(line.setting_at, c))?;
        }
        // Macro B: a setting is a statement, and a statement has its line for itself.
        let lone = has_macros(dialect) && !line.settings.is_empty();
        if lone && let Some(other) = line.words.iter().find(|w| !matches!(w.letter, 0 | b'N')) {
            let statement = "a setting of variables".into();
            return Err(flow(other.at, FlowComplaint::StatementAlone { statement }));
        }
        self.begun |= !(line.words.is_empty() && line.settings.is_empty());
        if let Some(call) = line.find(b'M', 98.0) {
            return self.call(line, call, here, events);
        }
        if let Some(back) = line.find(b'M', 99.0) {
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
    fn expanded_words(
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
    fn call(
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
    pub(super) fn start_of(&mut self, label: &str) -> Result<Option<super::labels::Start>, Fault> {
        let owords = has_owords(self.state.dialect);
        let name = |text: &str| {
            let sub = if owords {
                super::oword::subroutine_name(text)
            } else {
                None
            };
            sub.or_else(|| program_name(text))
        };
        let found = self.labels.program(&mut self.source, label, name);
        found.map_err(|e| unreadable(&e))
    }

    /// M99.
    fn back(
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
    fn local_call(
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
    fn macro_call(&mut self, mut line: Expanded, g65: Spot) -> Result<(), Fault> {
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
    fn line_number(&mut self, number: u32, at: usize) -> Result<LineStart, Fault> {
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

    /// `GOTO n`
    fn goto(&mut self, text: &str, at: usize, here: LineStart) -> Result<(), Fault> {
        let mut e = self.evaluator(text, at);
        e.peek();
        let place = e.at;
        let value = e.value()?.number()?;
        let behind = e.at;
        let number = whole(value, place, "the line number of GOTO", 1, LARGEST)?;
        self.alone(text, behind, "GOTO")?;
        self.begun = true;
        let to = self.line_number(number, place)?;
        self.leave_loops(to.line);
        let start = at.saturating_sub("GOTO".len()) as u32;
        self.jump(to).map_err(|f| Fault { offset: start, ..f })
    }

    /// `IF [..] GOTO n`, `IF [..] THEN #1=..`
    fn condition(&mut self, text: &str, at: usize, here: LineStart) -> Result<(), Fault> {
        let mut e = self.evaluator(text, at);
        e.peek();
        let met = e.bracket()?.number()? != 0.0;
        let keyword = e.letters();
        let (place, behind) = (e.at, e.at + keyword.len());
        match &*keyword {
            "GOTO" if met => self.goto(text, behind, here),
            "THEN" if met => {
                let line = expand(text, behind, &self.parameters, &self.state)?;
                if let Some(word) = line.words.first() {
                    let (statement, at) = ("THEN".into(), word.at);
                    return Err(flow(at, FlowComplaint::StatementAlone { statement }));
                }
                if line.settings.is_empty() {
                    let (statement, what) = ("THEN".into(), "a setting of a variable (#1= ...)");
                    return Err(flow(place, FlowComplaint::Incomplete { statement, what }));
                }
                for (which, value) in &line.settings {
                    let alarm = *which == crate::gcode::parameter::Parameter::Number(3000);
                    if let (true, Some(number)) = (alarm, value) {
                        self.over = true;
                        return Err(flow(
                            line.setting_at,
                            FlowComplaint::Alarm { number: *number },
                        ));
                    }
                    self.parameters
                        .may_set(which)
                        .map_err(|c| fault(line.setting_at, c))?;
                }
                self.begun = true;
                for (which, value) in &line.settings {
                    self.parameters.set(which, *value);
                }
                Ok(())
            }
            "GOTO" | "THEN" => {
                self.begun = true;
                Ok(())
            }
            _ => {
                let (statement, what) = (
                    "IF [ ... ]".into(),
                    "GOTO and a line number, or THEN and a setting",
                );
                Err(flow(place, FlowComplaint::Incomplete { statement, what }))
            }
        }
    }

    /// `WHILE [..] DO n`
    fn while_line(&mut self, text: &str, at: usize, here: LineStart) -> Result<(), Fault> {
        let mut e = self.evaluator(text, at);
        e.peek();
        let met = e.bracket()?.number()? != 0.0;
        let keyword = e.letters();
        let place = e.at;
        if &*keyword != "DO" {
            let (statement, what) = ("WHILE [ ... ]".into(), "DO and a number");
            return Err(flow(place, FlowComplaint::Incomplete { statement, what }));
        }
        self.do_line(text, place + 2, Some(met), here)
    }

    /// `DO n`, with or without a condition before it.
    fn do_line(
        &mut self,
        text: &str,
        at: usize,
        met: Option<bool>,
        here: LineStart,
    ) -> Result<(), Fault> {
        let (number, behind) = self.loop_number(text, at)?;
        self.alone(text, behind, "DO")?;
        let label: Box<str> = format!("{number}").into();
        let end = self.ahead(here.line, &format!("END{number}"), |text| {
            let body = front(text).body;
            let rest = text.get(body..).unwrap_or_default();
            if rest.starts_with(['O', 'o', ':']) {
                return Some(STOP);
            }
            let word = rest.get(..3).filter(|w| w.eq_ignore_ascii_case("END"))?;
            let digits = rest.get(word.len()..)?.trim_start();
            let count = digits.bytes().take_while(u8::is_ascii_digit).count();
            (digits.get(..count)?.parse() == Ok(number)).then_some(0)
        })?;
        let Some(end) = end else {
            let (opening, closing) = (format!("DO{number}").into(), format!("END{number}").into());
            return Err(flow(
                at.saturating_sub(2),
                FlowComplaint::NotClosed { opening, closing },
            ));
        };
        self.begun = true;
        self.leave_loops(here.line);
        self.frame().loops.retain(|l| l.label != label);
        if met == Some(false) {
            return self.jump(end.behind);
        }
        let (head, inside, end) = (here, self.source.place(), end.line.line);
        let kind = LoopKind::While;
        self.open(
            Loop {
                kind,
                label,
                head,
                inside,
                end,
            },
            0,
        )
    }

    /// `END n`
    fn end_line(&mut self, text: &str, at: usize, here: LineStart) -> Result<(), Fault> {
        let (number, behind) = self.loop_number(text, at)?;
        self.alone(text, behind, "END")?;
        let label = format!("{number}");
        let found = self.frame().loops.iter().find(|l| *l.label == *label);
        let start = at.saturating_sub("END".len());
        match found.map(|l| (l.head, l.end)) {
            Some((head, end)) if end == here.line => self.jump(head).map_err(|f| Fault {
                offset: start as u32,
                ..f
            }),
            _ => {
                let (closing, opening) =
                    (format!("END{number}").into(), format!("DO{number}").into());
                Err(flow(start, FlowComplaint::NotOpened { closing, opening }))
            }
        }
    }

    /// The number of a loop: 1 to 3.
    fn loop_number(&self, text: &str, at: usize) -> Result<(u32, usize), Fault> {
        let mut e = self.evaluator(text, at);
        e.peek();
        let place = e.at;
        let value = e.value()?.number()?;
        let number = whole(value, place, "the number of a loop (DO, END)", 1, 3)?;
        Ok((number, e.at))
    }

    /// The text is over, or a `%` says so.
    pub(super) fn end_of_text(&mut self) -> Result<(), Fault> {
        let tongue = !matches!(self.language, super::Language::Words | super::Language::Fed);
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
        // Siemens, Heidenhain: the program's end is the subprogram's.
        if tongue {
            return self.give_back();
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

/// A value that counts or names something.
pub(super) fn whole(
    value: f64,
    at: usize,
    what: &'static str,
    least: u32,
    most: u32,
) -> Result<u32, Fault> {
    let near = value.round();
    let fits = (value - near).abs() < 1e-4 && (f64::from(least)..=f64::from(most)).contains(&near);
    match fits {
        true => Ok(near as u32),
        false => Err(flow(
            at,
            FlowComplaint::Range {
                what,
                least,
                most,
                value,
            },
        )),
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
