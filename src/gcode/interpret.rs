//! The interpreter: a line of text and what the machine remembers, to events and what it remembers then.
//!
//! Crosses the border: program text in; [`Event`]s (absolute, mm, mm/min, s, work coordinates) and a new [`State`] out. Each line is
//! first checked whole (`block`, `check`), then carried out, which cannot fail: a refused line changes nothing. No I/O, no machine
//! limits, no time.

use super::block;
use super::check::{self, Line, Move};
use super::dialect::Dialect;
use super::error::{Complaint, Fault, InterpretError};
use super::event::{Event, Motion, MotionKind};
use super::execute::execute;
use super::program::{FlowComplaint, Interpreter, Reading};
use super::rules::BlockDelete;
use super::state::State;
use std::io::Cursor;

/// A whole program, understood.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// What the machine is told, in order.
    pub events: Vec<Event>,
    /// Lines of the text.
    pub lines: usize,
    /// What the machine remembers at the end.
    pub end_state: State,
}

/// So many mistakes are reported in one run.
pub const MAX_ERRORS: usize = 20;

/// Lines read again that a program in memory may have: its events are all kept.
const LINES_AGAIN: u64 = 1_000_000;

/// Reads one line (without its line end) and carries it out: `state` becomes what the machine remembers then, and what it is told
/// to do is appended to `events`. `line` counts from 1 and goes into events and errors.
///
/// A line by itself has no variables, calls or loops: those are a program's ([`super::program`]).
///
/// GRBL: the line is taken exactly as the firmware takes it, so a lone `%` is refused (senders leave such lines out) and `/` is
/// ignored.
///
/// # Errors
/// The first mistake in the line, in the order in which the firmware looks. `state` and `events` are then unchanged.
pub fn interpret_line(
    state: &mut State,
    text: &str,
    line: usize,
    events: &mut Vec<Event>,
) -> Result<(), InterpretError> {
    carry_out(state, text, line, events).map_err(|fault| fault.locate(text, line))
}

/// [`interpret_line`], the place of a mistake as a byte of the line.
pub(super) fn carry_out(
    state: &mut State,
    text: &str,
    line: usize,
    events: &mut Vec<Event>,
) -> Result<(), Fault> {
    if state.block_delete
        && matches!(
            state.dialect.rules().block_delete,
            BlockDelete::Switch | BlockDelete::Levels
        )
        && text.trim_start().starts_with('/')
    {
        return Ok(());
    }
    let Some(mut block) = block::gather(text, state.dialect)? else {
        return Ok(());
    };
    if state.single {
        block.take_single(text);
    }
    let plan = check::check(state, &block, Line::Program)?;
    execute(state, &block, &plan, line, events);
    Ok(())
}

/// Reads what follows `$J=` on a GRBL jog line: axis words, F, and G20 G21 G90 G91 G53 for this line only. The modes stay as they
/// are; only the position moves on. Without axis words the firmware drives to machine zero, and so does the motion returned.
///
/// # Errors
/// The first mistake, in the firmware's order; soft limits are the caller's to check. `state` is then unchanged. No words at all
/// count as a missing feed.
pub fn interpret_jog(state: &mut State, text: &str, line: usize) -> Result<Motion, InterpretError> {
    let read = || {
        let Some(mut block) = block::gather(text, state.dialect)? else {
            return Err(Fault::at(0, Complaint::FeedMissing));
        };
        if state.single {
            block.take_single(text);
        }
        check::check(state, &block, Line::Jog)
    };
    let plan = read().map_err(|fault: Fault| fault.locate(text, line))?;
    let (to, machine) = match plan.action {
        Move::Straight { to, machine, .. } => (to, machine),
        _ => (state.position, false),
    };
    let motion = Motion {
        kind: MotionKind::Feed,
        from: state.position,
        to,
        arc: None,
        feed: plan.feed,
        inverse_time: false,
        machine_coordinates: machine,
        line,
    };
    state.position = to;
    Ok(motion)
}

/// Reads a whole program from the state of a machine just switched on, into memory ([`super::Interpreter`] reads the same without keeping
/// it). A byte order mark, any line ends, and lines of nothing but `%` are understood in all dialects (a sender must not send `%` to GRBL).
/// Controllers that run files read nothing behind M2, M30 or the second `%`.
///
/// # Errors
/// Every mistake of the program, up to [`MAX_ERRORS`], by line. A refused line changes nothing, so one mistake can cause others;
/// of a run of missing feeds only the first is reported.
pub fn interpret(text: &str, dialect: Dialect) -> Result<Program, Vec<InterpretError>> {
    interpret_from(State::new(dialect), text)
}

/// [`interpret`], from a given state.
///
/// # Errors
/// As [`interpret`].
pub fn interpret_from(state: State, text: &str) -> Result<Program, Vec<InterpretError>> {
    let reading = Reading {
        lines_again: LINES_AGAIN,
        ..Reading::default()
    };
    let unreadable = |e: std::io::Error| {
        let kind = e.kind();
        let complaint = Complaint::Flow(FlowComplaint::Unreadable { kind });
        vec![Fault::at(0, complaint).locate("", 1)]
    };
    let from = Cursor::new(text.as_bytes());
    let mut program = Interpreter::from_state(from, state, reading).map_err(unreadable)?;
    let mut events = Vec::with_capacity(text.len() / 24);
    let errors = program.read_all(&mut events);
    if !errors.is_empty() {
        return Err(errors);
    }
    Ok(Program {
        events,
        lines: program.count_lines().map_err(unreadable)?,
        end_state: program.state().clone(),
    })
}

/// The lines of a text, ended by LF, CR LF or CR. A line end at the very end opens no further line.
pub fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = rest.bytes().position(|b| b == b'\n' || b == b'\r');
        let (line, after) = rest.split_at(end.unwrap_or(rest.len()));
        rest = after
            .strip_prefix("\r\n")
            .or_else(|| after.strip_prefix(['\r', '\n']))
            .unwrap_or_default();
        Some(line)
    })
}

#[cfg(test)]
#[path = "interpret_tests.rs"]
mod tests;
