//! Sinumerik 840D sl, in its own language: a block to what the machine is told.
//!
//! Crosses the border: a line of a part program in; events in work coordinates, mm and mm/min, out, with what the line asks of the order
//! of lines ([`Flow`]). Never knows files, or where a label stands.
//!
//! | read | refused by name |
//! |---|---|
//! | G0-G3 with I J K (AC, IC), CR, AR, TURN; G17-G19; X=AC() IC() | CIP, CT, splines, RND CHF, polar points, threads, rotary axes |
//! | G4 F, G9, G60, G64, G641-G645, ADIS, CTOL, COMPxx, CYCLE832; SOFT BRISK FFWON and their like | G4 S, RTLIOF |
//! | G40, G53, G153, SUPA, G500, G54-G57, G505-G599, TRANS, ATRANS, empty ROT SCALE MIRROR | G41 G42, G58 G59, G74 G75, G110-G112, ROT SCALE MIRROR |
//! | G70 G71 G700 G710, G90 G91, G93 G94 G95 | G96 G97, TRAORI, CYCLE800 (but empty) |
//! | T, T="..", D, M0-M9 M17 M30 M40-M45, S, S1= M1= | other spindles, SPOS, M19, other M |
//! | R parameters, DEF REAL INT BOOL, expressions | strings, arrays, system variables |
//! | labels, GOTO GOTOF GOTOB, IF ELSE ENDIF, REPEAT label P | WHILE FOR LOOP UNTIL CASE REPEATB |
//! | subprograms of the archive, PROC, M17, RET | parameters of subprograms, CALL EXTCALL |
//! | CYCLE81 CYCLE82 (six arguments), MCALL; MSG, WORKPIECE, GROUP_BEGIN, STOPRE | other cycles |
//!
//! After the programming manuals "Fundamentals" and "Job planning" (840D sl / 828D). Where they leave a choice:
//!
//! - Work coordinates are those of the settable frame (G54 ...). TRANS and ATRANS are added to what is programmed, so events stay in one
//!   system whatever the programmable frame. G505 to G599 are the fifth offset of [`State`] and
//!   those behind it.
//! - The basic system is metric: under G70 lengths are inches and F is mm/min, under G700 F is inch/min as well.
//! - Whether an incremental move right behind a change of frame or tool length takes that change along is a setting of the machine
//!   (FRAME_OFFSET_INCR_PROG, TOOL_OFFSET_INCR_PROG): such a move is refused until the axis was sent to an absolute place.
//! - Z is the tool's tip while D is not 0, in every plane (as with setting data TOOL_LENGTH_CONST); T with M6 selects D1.
//! - M6 changes the tool that T chose. Named tools get the numbers 1, 2, ... in the order of their first call; a name of digits is that
//!   number.
//! - M7 is mist, M8 flood.
//! - G641 ADIS, CTOL and CYCLE832 set [`super::state::PathMode::Blend`] with that tolerance, mm; compressors alone without one.
//! - A subprogram called by its name must stand in the same archive (`%_N_NAME_SPF`).

mod arc;
mod assign;
mod block;
mod codes;
pub mod complaint;
mod control;
mod cycle;
mod expression;
mod frame;
mod keyword;
mod path;
mod program;

use super::error::{Complaint, Fault};
use super::event::Event;
use super::flow::{Flow, Label, Said};
use super::state::State;
use super::tongue::desk::Desk;
use super::tongue::name::Name;
use super::tongue::scan::Scan;
use crate::geom::Vector;
use complaint::SiemensComplaint as Wrong;
use expression::Value;
use std::collections::BTreeMap;

/// What the language remembers beyond [`State`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Memory {
    modes: Modes,
    /// R parameters.
    r: BTreeMap<u32, f64>,
    /// Variables of the programs that run now.
    variables: Vec<Variable>,
    /// Tools called by name; the first is number 1.
    tools: Vec<Name>,
}

/// A variable of DEF.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Variable {
    name: Name,
    kind: Kind,
    value: Value,
    /// How deep in calls the program stands that defined it; others do not see it.
    depth: u32,
}

/// A variable's type.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Real,
    Int,
    Bool,
}

/// What F means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum FeedKind {
    /// G94.
    #[default]
    PerMinute,
    /// G95.
    PerRevolution,
    /// G93.
    Inverse,
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
    /// A block other than comments was read.
    began: bool,
    /// An end was reached.
    over: bool,
    /// Runs of subprograms that were asked for and have not returned yet.
    depth: u32,
    /// TRANS, mm.
    shift: Vector,
    /// G500: no settable frame.
    no_offset: bool,
    /// Axes whose frame or tool length changed since they were last sent to an absolute place.
    moved_frame: [bool; 3],
    /// D0.
    length_off: bool,
    /// T was programmed; M6 changes to this.
    chosen: Option<u32>,
    /// A tool was chosen by its number.
    numbered: bool,
    feed_kind: FeedKind,
    /// F in what [`FeedKind`] says: mm/min, mm/rev, 1/min; zero means not set.
    feed: f64,
    /// G700.
    inch_feed: bool,
    blending: Blending,
    /// MCALL.
    modal: Option<cycle::Drilling>,
    ifs: control::Ifs,
}

/// How corners are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Blending {
    /// 60, 64, 641 ...; zero before the first.
    code: u32,
    /// ADIS, mm.
    adis: f64,
    /// CTOL or CYCLE832, mm.
    tolerance: Option<f64>,
    /// COMPON and its like.
    compressor: bool,
}

/// A line at work: everything is a copy until the whole line was sound.
struct Job<'a> {
    scan: Scan<'a>,
    desk: Desk<'a>,
    modes: Modes,
    r: &'a BTreeMap<u32, f64>,
    variables: &'a [Variable],
    /// R parameters that this line sets.
    set_r: Vec<(u32, f64)>,
    /// Variables that this line defines or sets.
    set: Vec<Variable>,
    tools: &'a [Name],
    /// A tool that this line chooses by name for the first time.
    tool: Option<Name>,
}

/// A fault at a place.
#[cold]
fn wrong<T>(at: u32, complaint: Wrong) -> Result<T, Fault> {
    Err(Fault::at(at, Complaint::Siemens(complaint)))
}

/// A fault of something that is known and not carried out.
#[cold]
fn refuse<T>(at: u32, name: &str, why: &'static str) -> Result<T, Fault> {
    let name = Name::of(name);
    wrong(at, Wrong::Refused { name, why })
}

/// A fault of a number outside its range.
#[cold]
fn range<T>(at: u32, name: &str, range: &'static str) -> Result<T, Fault> {
    let name = Name::of(name);
    wrong(at, Wrong::Range { name, range })
}

/// A fault of something missing.
#[cold]
fn missing<T>(at: u32, name: &str, what: &'static str) -> Result<T, Fault> {
    let name = Name::of(name);
    wrong(at, Wrong::Missing { name, what })
}

impl Job<'_> {
    /// Millimetres in one unit of the program.
    fn mm(&self) -> f64 {
        self.desk.state.units.mm()
    }

    /// What stands here, as a complaint.
    fn not_understood<T>(&self) -> Result<T, Fault> {
        let rest = self.scan.rest();
        let end = rest.find([' ', '\t', ';']).unwrap_or(rest.len()).max(1);
        let name = Name::of(rest.get(..end).unwrap_or(rest));
        let mut comma = rest.bytes().take(2);
        if comma.next() == Some(b',') && comma.next().is_some_and(|b| b.is_ascii_digit()) {
            return Err(Fault::at(self.scan.at(), Complaint::DecimalComma));
        }
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
        r: &memory.r,
        variables: &memory.variables,
        set_r: Vec::new(),
        set: Vec::new(),
        tools: &memory.tools,
        tool: None,
    };
    match program::line(&mut job) {
        Ok(flow) => {
            let Job {
                desk,
                modes,
                set_r,
                set,
                tool,
                ..
            } = job;
            (*state, memory.modes) = (desk.state, modes);
            memory.r.extend(set_r);
            memory.tools.extend(tool);
            for v in set {
                let same = |o: &&mut Variable| (o.name, o.depth) == (v.name, v.depth);
                match memory.variables.iter_mut().find(same) {
                    Some(old) => *old = v,
                    None => memory.variables.push(v),
                }
            }
            memory.variables.retain(|v| v.depth <= modes.depth);
            Ok(flow)
        }
        Err(fault) => {
            job.desk.events.truncate(before);
            Err(fault)
        }
    }
}

/// The label that a line carries, if it does: the jump label (`AGAIN` of `N10 AGAIN: X5`), or else the block number (`N10`, `:10`), or the
/// header of a program (`%_N_NAME_SPF`), all in upper case.
pub(super) fn label(text: &str) -> Option<Label> {
    program::label(text)
}

/// What is wrong when the text is over here.
pub(super) fn finish(memory: &Memory) -> Result<(), Fault> {
    let Modes {
        over, depth, ifs, ..
    } = &memory.modes;
    match (over, ifs.skips(), depth) {
        (true, _, _) | (_, false, 0) => Ok(()),
        (_, true, _) => wrong(0, Wrong::IfOpen { line: ifs.since() }),
        _ => wrong(0, Wrong::ReturnMissing),
    }
}

#[cfg(test)]
mod tests;
