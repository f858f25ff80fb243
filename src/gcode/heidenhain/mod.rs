//! Heidenhain TNC, conversational: a block to what the machine is told.
//!
//! Crosses the border: a line of a `.H` file in; events in work coordinates, mm and mm/min, out, with what the line asks of the order of
//! lines ([`Flow`]). Never knows files, or where a label stands.
//!
//! | read | refused by name |
//! |---|---|
//! | BEGIN PGM, END PGM, BLK FORM, TOOL CALL, TOOL DEF, STOP, comments, structure lines | `/`, other tool axes, DL DR |
//! | L, CC, C, CR, CT, LP, CP (helices); I coordinates; R0; F, FMAX, F AUTO | RL RR, APPR DEP, RND CHF, CTP, C CR CT with Z and one of X Y, FL.., FU FZ, rotary axes |
//! | M0-M6 M8 M9 M13 M14 M30 M89 M91 M99 M126 M127 M129 | M92 M97 M109 M128 M140 and all others |
//! | CYCL DEF 7 (values), 9, 32, 200, 201, 247; CYCL CALL; TRANS DATUM AXIS, RESET | all other cycles, datum tables |
//! | FN 0-13, formulas, Q0-Q99 and Q200 up | QL QR QS, Q100-Q199, FN 14 up |
//! | LBL, CALL LBL, REP, GOTO LBL | CALL PGM |
//! | PLANE RESET STAY | PLANE, FUNCTION, LN |
//!
//! After the user's manuals of iTNC 530 and TNC 640 (conversational programming). Where they leave a choice:
//!
//! - Work coordinates are those of the active preset. A datum shift (cycle 7, TRANS DATUM) is added to what is programmed, so events
//!   stay in one system whatever the shift.
//! - F is mm/min; in INCH programs it is 0.1 inch/min (chapter "Feed rate F").
//! - Tool axis Z only, and Z is the tool's tip: TOOL CALL takes its length from the table, which is not known here.
//! - Tools called by name get the numbers 1, 2, ... in the order of their first call; a name of digits is that number.
//! - Presets (cycle 247) 1 to 99 are the work offsets of [`State`], in this order.

pub mod complaint;
mod cycle;
mod formula;
mod jump;
mod miscellany;
mod parameter;
mod path;
mod program;
mod tool;
mod words;

use super::error::{Complaint, Fault};
use super::event::Event;
use super::flow::{Flow, Label, Said};
use super::state::State;
use super::tongue::desk::Desk;
use super::tongue::name::Name;
use super::tongue::scan::Scan;
use crate::geom::Vector;
use complaint::HeidenhainComplaint as Wrong;
use cycle::Cycle;
use std::collections::BTreeMap;

/// What the language remembers beyond [`State`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Memory {
    modes: Modes,
    /// Q parameters.
    q: BTreeMap<u32, f64>,
    /// Tools called by name; the first is number 1.
    tools: Vec<Name>,
}

impl Memory {
    /// A call that this line counted came to nothing.
    pub fn not_called(&mut self, times: u32) {
        self.modes.depth = self.modes.depth.saturating_sub(times);
    }
}

/// The part that is copied for every line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Modes {
    /// Name and units, as BEGIN PGM gave them.
    program: Option<Name>,
    /// An end was reached: END PGM, M2 or M30.
    over: bool,
    /// CALL LBL without REP that were not left yet.
    depth: u32,
    /// The datum shift, mm.
    shift: Vector,
    /// CC, work coordinates, mm.
    pole: Option<[f64; 2]>,
    /// Direction in X and Y, of length 1, in which the last contour block ended.
    tangent: Option<[f64; 2]>,
    /// The F of the last TOOL CALL, mm/min.
    auto_feed: f64,
    /// The drilling cycle in force.
    cycle: Option<Cycle>,
    /// Its definition goes on with the next line.
    cycle_open: bool,
    /// M89: the cycle is called behind each positioning block.
    modal_call: bool,
    /// A tool was called by its number.
    numbered: bool,
}

/// A line at work: everything is a copy until the whole line was sound.
struct Job<'a> {
    scan: Scan<'a>,
    desk: Desk<'a>,
    modes: Modes,
    q: &'a BTreeMap<u32, f64>,
    /// What this line assigns.
    set: Vec<(u32, f64)>,
    tools: &'a [Name],
    /// A tool that this line calls by name for the first time.
    tool: Option<Name>,
}

/// A fault at a place.
#[cold]
fn wrong<T>(at: u32, complaint: Wrong) -> Result<T, Fault> {
    Err(Fault::at(at, Complaint::Heidenhain(complaint)))
}

/// A fault of something that is known and not carried out.
#[cold]
fn refuse<T>(at: u32, name: &str, why: &'static str) -> Result<T, Fault> {
    let name = Name::of(name);
    wrong(at, Wrong::Refused { name, why })
}

impl Job<'_> {
    /// Millimetres in one unit of the program.
    fn mm(&self) -> f64 {
        self.desk.state.units.mm()
    }

    /// The value of a Q parameter.
    fn q(&self, number: u32, at: u32) -> Result<f64, Fault> {
        let set = self.set.iter().rev().find(|(n, _)| *n == number);
        match set.map(|s| s.1).or_else(|| self.q.get(&number).copied()) {
            Some(value) => Ok(value),
            None => wrong(at, Wrong::Unset { number }),
        }
    }

    /// What stands here, as a complaint.
    fn not_understood<T>(&self) -> Result<T, Fault> {
        let rest = self.scan.rest();
        let end = rest.find([' ', '\t', ';']).unwrap_or(rest.len()).max(1);
        let name = Name::of(rest.get(..end).unwrap_or(rest));
        wrong(self.scan.at(), Wrong::NotUnderstood { name })
    }

    /// Nothing but a comment may follow.
    fn end_of_block(&mut self) -> Result<(), Fault> {
        match self.scan.blanks().peek() {
            None | Some(b';') => Ok(()),
            _ => self.not_understood(),
        }
    }
}

/// Past blanks and the block number.
fn front(scan: &mut Scan) {
    scan.blanks().run(|b| b.is_ascii_digit());
    scan.blanks();
}

/// Carries out one line. On an error nothing has changed.
pub(super) fn line(
    state: &mut State,
    memory: &mut Memory,
    text: &str,
    line: usize,
    events: &mut Vec<Event>,
) -> Said {
    let before = events.len();
    let mut job = Job {
        scan: Scan::new(text),
        desk: Desk {
            state: state.clone(),
            events,
            line,
        },
        modes: memory.modes,
        q: &memory.q,
        set: Vec::new(),
        tools: &memory.tools,
        tool: None,
    };
    match program::block(&mut job) {
        Ok(flow) => {
            let Job {
                desk,
                modes,
                set,
                tool,
                ..
            } = job;
            (*state, memory.modes) = (desk.state, modes);
            memory.q.extend(set);
            memory.tools.extend(tool);
            Ok(flow)
        }
        Err(fault) => {
            job.desk.events.truncate(before);
            Err(fault)
        }
    }
}

/// The label that a line carries, if it does: `LBL5`, `LBL"NAME"`. LBL 0 ends a subprogram and can not be called.
pub(super) fn label(text: &str) -> Option<Label> {
    let mut scan = Scan::new(text);
    front(&mut scan);
    if !scan.take_text("LBL") {
        return None;
    }
    jump::name(&mut scan).filter(|label| **label != *"LBL0")
}

/// What is wrong when the text is over here.
pub(super) fn finish(memory: &Memory) -> Result<(), Fault> {
    match memory.modes.over {
        true => Ok(()),
        false => wrong(0, Wrong::EndMissing),
    }
}

#[cfg(test)]
mod tests;
