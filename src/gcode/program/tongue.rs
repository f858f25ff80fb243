//! Lines of the languages that are not plain words: carried out by their own readers, whose [`Flow`] is followed here.

use super::frame::{Frame, Kind};
use super::{FlowComplaint, Interpreter, Language, flow, unreadable};
use crate::gcode::error::Fault;
use crate::gcode::event::Event;
use crate::gcode::flow::{Flow, Label};
use crate::gcode::source::LineStart;
use crate::gcode::{heidenhain, siemens};
use std::io::{BufRead, Seek};

/// The label that a line of the language carries.
fn label_of(language: &Language) -> fn(&str) -> Option<Label> {
    match language {
        Language::Siemens(_) => siemens::label,
        Language::Heidenhain(_) => heidenhain::label,
        _ => |_| None,
    }
}

impl<R: BufRead + Seek> Interpreter<R> {
    /// A line of Siemens or Heidenhain.
    pub(super) fn tongue_line(
        &mut self,
        text: &str,
        here: LineStart,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let said = match &mut self.language {
            Language::Siemens(memory) => {
                siemens::line(&mut self.state, memory, text, here.line, events)
            }
            Language::Heidenhain(memory) => {
                heidenhain::line(&mut self.state, memory, text, here.line, events)
            }
            _ => Ok(Flow::Next),
        };
        match said? {
            Flow::Next => Ok(()),
            Flow::End => {
                self.over = true;
                Ok(())
            }
            Flow::Return if self.frames.len() > 1 => self.give_back(),
            Flow::Return => {
                self.over = true;
                Ok(())
            }
            Flow::Call { label, times } => {
                let called = self.call_label(label, times);
                if called.is_err() {
                    // The language has counted it: it must not wait for its return.
                    match &mut self.language {
                        Language::Siemens(memory) => memory.not_called(times),
                        Language::Heidenhain(memory) => memory.not_called(times),
                        _ => {}
                    }
                }
                called
            }
            Flow::Repeat { label, times } => {
                let (at, _) = self.anywhere(&label)?;
                self.repeat(at, here.line, times)
            }
            Flow::Goto { label, forward } => self.go_to(&label, forward, here),
        }
    }

    /// Into a subprogram.
    fn call_label(&mut self, label: Label, times: u32) -> Result<(), Fault> {
        self.may_call(0)?;
        let (_, behind) = self.anywhere(&label)?;
        self.enter(Frame::call(Kind::Program, label, behind, times))
    }

    /// A label, wherever it stands: its line, and where the next one begins.
    fn anywhere(&mut self, label: &Label) -> Result<(LineStart, LineStart), Fault> {
        let name = label_of(&self.language);
        let start = self.labels.program(&mut self.source, label, name);
        let Some(start) = start.map_err(|e| unreadable(&e))? else {
            let name = label
                .strip_prefix("%_N_")
                .and_then(|l| l.strip_suffix("_SPF"));
            return Err(flow(
                0,
                match name {
                    Some(name) => FlowComplaint::NoCommand { name: name.into() },
                    None => FlowComplaint::LabelMissing {
                        label: label.clone(),
                    },
                },
            ));
        };
        if let Some(second) = start.second {
            let (label, first) = (label.clone(), start.found.line.line);
            return Err(flow(
                0,
                FlowComplaint::ProgramTwice {
                    label,
                    first,
                    second,
                },
            ));
        }
        Ok((start.found.line, start.found.behind))
    }

    /// Once more from a line to the one that asks, so many times in all.
    fn repeat(&mut self, from: LineStart, line: usize, times: u32) -> Result<(), Fault> {
        let repeats = &mut self.frame().repeats;
        let known = repeats.iter().position(|(l, _)| *l == line);
        let left = match known {
            Some(i) => repeats.remove(i).1,
            None => times,
        };
        if left == 0 {
            return Ok(());
        }
        repeats.push((line, left - 1));
        self.jump(from)
    }

    fn go_to(
        &mut self,
        label: &Label,
        forward: Option<bool>,
        here: LineStart,
    ) -> Result<(), Fault> {
        let name = label_of(&self.language);
        let mut is = |text: &str| (name(text).as_ref() == Some(label)).then_some(0);
        let mut found = None;
        if forward != Some(false) {
            found = self.ahead(here.line, &format!("{label} below"), &mut is)?;
        }
        if found.is_none() && forward != Some(true) {
            let back = self.source.place();
            let scan = self.source.rewind().and_then(|()| {
                let what = format!("{label} above");
                self.labels
                    .ahead(&mut self.source, (here.line, &what), here.line, is)
            });
            found = scan.map_err(|e| unreadable(&e))?;
            self.source.go(back).map_err(|e| unreadable(&e))?;
        }
        match found {
            Some(found) => self.jump(found.line),
            None => {
                let label = label.clone();
                Err(flow(0, FlowComplaint::LabelMissing { label }))
            }
        }
    }
}
