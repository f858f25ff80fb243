//! Branches and loops of Macro B: GOTO, IF, WHILE, DO, END (Fanuc, Custom Macro, Branch and Repetition; Haas, Macros).

use super::expand::expand;
use super::frame::{Loop, LoopKind};
use super::front::{LARGEST, front, whole};
use super::labels::STOP;
use super::{FlowComplaint, Interpreter, flow};
use crate::gcode::error::Fault;
use crate::gcode::source::LineStart;
use std::io::{BufRead, Seek};

impl<R: BufRead + Seek> Interpreter<R> {
    /// `GOTO n`
    pub(super) fn goto(&mut self, text: &str, at: usize) -> Result<(), Fault> {
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
    pub(super) fn condition(&mut self, text: &str, at: usize) -> Result<(), Fault> {
        let mut e = self.evaluator(text, at);
        e.peek();
        let met = e.bracket()?.number()? != 0.0;
        let keyword = e.letters();
        let (place, behind) = (e.at, e.at + keyword.len());
        match &*keyword {
            "GOTO" if met => self.goto(text, behind),
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
                self.may_set(&line)?;
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
    pub(super) fn while_line(
        &mut self,
        text: &str,
        at: usize,
        here: LineStart,
    ) -> Result<(), Fault> {
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
    pub(super) fn do_line(
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
    pub(super) fn end_line(&mut self, text: &str, at: usize, here: LineStart) -> Result<(), Fault> {
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
}
