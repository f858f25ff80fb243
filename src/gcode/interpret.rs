//! The interpreter: a line of text and what the machine remembers, to events and what it remembers then.
//!
//! Crosses the border: program text in; [`Event`]s (absolute, mm, mm/min, s, work coordinates) and a new [`State`] out. Each line is
//! first checked whole (`block`, `check`), then carried out, which cannot fail: a refused line changes nothing. No I/O, no machine
//! limits, no time.

use super::block::{self, Block, Coolant, NonModal, Path, Stop, ToolLength};
use super::check::{self, Line, Move, Offsets, Plan};
use super::error::{Complaint, Fault, InterpretError};
use super::event::{Event, Motion, MotionKind, Plane};
use super::state::{Dialect, Distance, FeedMode, MotionMode, PathMode, State};
use crate::geom::{Point, Vector};

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

/// Reads one line (without its line end) and carries it out: `state` becomes what the machine remembers then, and what it is told
/// to do is appended to `events`. `line` counts from 1 and goes into events and errors.
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
    if state.block_delete
        && state.dialect == Dialect::LinuxCnc
        && text.trim_start().starts_with('/')
    {
        return Ok(());
    }
    let read = || -> Result<Option<(Block, Plan)>, Fault> {
        let Some(block) = block::gather(text, state.dialect)? else {
            return Ok(None);
        };
        let plan = check::check(state, &block, Line::Program)?;
        Ok(Some((block, plan)))
    };
    match read() {
        Ok(Some((block, plan))) => execute(state, &block, &plan, line, events),
        Ok(None) => {}
        Err(fault) => return Err(fault.locate(text, line)),
    }
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
        let Some(block) = block::gather(text, state.dialect)? else {
            return Err(Fault::at(0, Complaint::FeedMissing));
        };
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

/// Reads a whole program from the state of a machine just switched on. A byte order mark, any line ends, and lines of nothing
/// but `%` are understood in both dialects (a sender must not send `%` to GRBL). LinuxCNC: nothing behind M2, M30 or the second `%`
/// is read.
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
pub fn interpret_from(mut state: State, text: &str) -> Result<Program, Vec<InterpretError>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let linuxcnc = state.dialect == Dialect::LinuxCnc;
    let mut events = Vec::with_capacity(text.len() / 24);
    let mut errors: Vec<InterpretError> = Vec::new();
    let (mut line, mut marks, mut over) = (0, 0, false);
    for content in lines(text) {
        line += 1;
        if over || errors.len() >= MAX_ERRORS {
            continue;
        }
        if content.starts_with('%') && content.trim_end() == "%" {
            marks += 1;
            over = linuxcnc && marks == 2;
            continue;
        }
        let first = events.len();
        if let Err(e) = interpret_line(&mut state, content, line, &mut events) {
            let again = e.complaint == Complaint::FeedMissing
                && errors.last().is_some_and(|l| l.complaint == e.complaint);
            if !again {
                errors.push(e);
            }
        }
        over = linuxcnc
            && events
                .get(first..)
                .unwrap_or_default()
                .iter()
                .any(|e| matches!(e, Event::End { .. }));
    }
    if errors.is_empty() {
        Ok(Program {
            events,
            lines: line,
            end_state: state,
        })
    } else {
        Err(errors)
    }
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

/// Carries out a checked block. Cannot fail.
fn execute(state: &mut State, block: &Block, plan: &Plan, line: usize, events: &mut Vec<Event>) {
    state.feed_mode = plan.feed_mode;
    state.feed = plan.feed;
    let new_speed = plan.speed != state.speed;
    state.speed = plan.speed;
    state.tool = plan.tool;
    if block.tool_change {
        // The spindle stops for the change.
        state.spindle = 0;
        let tool = state.tool;
        events.push(Event::ToolChange { tool, line });
    }
    let direction = block.spindle.unwrap_or(state.spindle);
    if direction != state.spindle || (new_speed && direction != 0) {
        state.spindle = direction;
        let speed = state.speed;
        events.push(Event::Spindle {
            direction,
            speed,
            line,
        });
    }
    if let Some(coolant) = block.coolant {
        let (flood, mist) = match coolant {
            Coolant::Mist => (state.flood, true),
            Coolant::Flood => (true, state.mist),
            Coolant::Off => (false, false),
        };
        if (flood, mist) != (state.flood, state.mist) {
            (state.flood, state.mist) = (flood, mist);
            events.push(Event::Coolant { flood, mist, line });
        }
    }
    if let Some(time) = plan.dwell {
        events.push(Event::Dwell { time, line });
    }
    state.plane = plan.plane;
    state.units = plan.units;

    if block.work_offset.is_some() || block.tool_length.is_some() {
        frame(state, block, plan, line, events);
    }

    if let Some(distance) = block.distance {
        state.distance = distance;
    }
    if let Some(arc_distance) = block.arc_distance {
        state.arc_distance = arc_distance;
    }
    if let Some(path) = block.path {
        state.path = match path {
            Path::ExactPath => PathMode::ExactPath,
            Path::ExactStop => PathMode::ExactStop,
            Path::Blend => PathMode::Blend {
                tolerance: block.get(b'P').map(|p| p * state.units.mm()),
            },
        };
    }
    let mut shift = Vector::zeros();
    if block.non_modal.is_some() {
        shift = offsets(state, block, plan, line, events);
    }
    state.motion = plan.motion;
    travel(state, &plan.action, shift, line, events);
    match block.stop {
        None => {}
        Some(stop @ (Stop::Pause | Stop::OptionalPause)) => events.push(Event::Pause {
            optional: stop == Stop::OptionalPause,
            line,
        }),
        Some(Stop::End) => {
            events.push(Event::End { line });
            end(state);
        }
    }
}

/// Work offset and tool length: the machine stays, the work position changes.
fn frame(state: &mut State, block: &Block, plan: &Plan, line: usize, events: &mut Vec<Event>) {
    let table = match block.tool_length {
        Some(ToolLength::Table) => Some(block.get(b'H').map_or(state.tool, |h| h as u32)),
        Some(_) => None,
        None => state.tool_length,
    };
    let moved = plan.work_offset != state.work_offset || plan.tlo != state.tlo;
    if moved {
        let machine = state.machine_position();
        (state.work_offset, state.tlo) = (plan.work_offset, plan.tlo);
        state.set_machine_position(&machine);
    }
    if moved || table != state.tool_length {
        state.tool_length = table;
        events.push(Event::Sync { line });
    }
}

/// G10, G28.1, G30.1, G92, G92.1. Returns what the work coordinates of the block's motion gain by it.
fn offsets(
    state: &mut State,
    block: &Block,
    plan: &Plan,
    line: usize,
    events: &mut Vec<Event>,
) -> Vector {
    let mut shift = Vector::zeros();
    let machine = state.machine_position();
    match plan.offsets {
        Offsets::Keep => return shift,
        Offsets::Work { index, origin } => {
            if let Some(g5x) = state.g5x.get_mut(index) {
                *g5x = origin;
            }
            state.set_machine_position(&machine);
        }
        Offsets::Shift { g92, position } => {
            state.g92 = g92;
            state.position = position;
        }
        Offsets::ClearShift => {
            shift = state.g92;
            state.g92 = Vector::zeros();
            state.position += shift;
        }
        Offsets::StoreHome => state.g28 = machine,
        Offsets::StoreSecondHome => state.g30 = machine,
    }
    debug_assert!(block.non_modal != Some(NonModal::Dwell));
    events.push(Event::Sync { line });
    shift
}

/// The block's motion.
fn travel(state: &mut State, action: &Move, shift: Vector, line: usize, events: &mut Vec<Event>) {
    let motion = |state: &mut State, kind: MotionKind, to: Point| {
        let from = std::mem::replace(&mut state.position, to);
        Motion {
            kind,
            from,
            to,
            arc: None,
            feed: state.feed,
            inverse_time: state.feed_mode == FeedMode::InverseTime,
            machine_coordinates: false,
            line,
        }
    };
    match *action {
        Move::None => {}
        Move::Straight { kind, to, machine } => {
            let m = motion(state, kind, to + shift);
            events.push(Event::Motion(Motion {
                machine_coordinates: machine,
                ..m
            }));
        }
        Move::Arc { to, mut arc } => {
            arc.center += shift;
            let m = motion(state, MotionKind::Feed, to + shift);
            events.push(Event::Motion(Motion {
                arc: Some(arc),
                ..m
            }));
        }
        Move::Probe { to, probe } => {
            let motion = motion(state, MotionKind::Feed, to + shift);
            events.push(Event::Probe {
                motion,
                away: probe.away,
                strict: probe.strict,
            });
        }
        Move::Home { through, to } => {
            if let Some(through) = through {
                let m = motion(state, MotionKind::Rapid, through);
                events.push(Event::Motion(m));
            }
            let m = motion(state, MotionKind::Rapid, to);
            events.push(Event::Motion(Motion {
                machine_coordinates: true,
                ..m
            }));
        }
    }
}

/// M2, M30: G1 G17 G90 G94 G54 M5 M9; units, F, S, G92 and tool length stay, and so does the machine.
fn end(state: &mut State) {
    state.motion = MotionMode::Linear;
    state.plane = Plane::Xy;
    state.distance = Distance::Absolute;
    if state.feed_mode == FeedMode::InverseTime {
        state.feed_mode = FeedMode::PerMinute;
    }
    state.spindle = 0;
    (state.flood, state.mist) = (false, false);
    if state.work_offset != 0 {
        let machine = state.machine_position();
        state.work_offset = 0;
        state.set_machine_position(&machine);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// GRBL's number for a complaint; the table that counts is `wire`'s.
    fn number(c: &Complaint) -> u8 {
        use Complaint::*;
        match c {
            ExpectedLetter { .. } => 1,
            BadNumber { .. } => 2,
            Negative { .. } => 4,
            LineTooLong { .. } => 11,
            JogWord => 16,
            UnsupportedCode { .. } | UnsupportedWord { .. } | OffsetKind | OffsetRotation => 20,
            SameGroup { .. } => 21,
            FeedMissing => 22,
            Fraction { .. } => 23,
            TwoAxisCommands { .. } => 24,
            Repeated { .. } => 25,
            AxisWordsMissing { .. } => 26,
            LineNumber => 27,
            ValueMissing { .. } => 28,
            WorkOffset { .. } => 29,
            MachineNeedsStraight => 30,
            AxisWordsWithoutMotion => 31,
            ArcAxisMissing { .. } => 32,
            ArcNowhere | ArcRadiiDiffer { .. } | ProbeNowhere => 33,
            ArcRadius { .. } => 34,
            ArcCenterMissing { .. } => 35,
            Unused { .. } => 36,
            ToolLengthAxis => 37,
            ToolNumber { .. } => 38,
            CommentOpen | CommentNested | WholeNumber { .. } => 20,
        }
    }

    /// The state as GRBL's `$G` writes it.
    fn modes(s: &State) -> String {
        let motion = match s.motion {
            MotionMode::Rapid => "G0",
            MotionMode::Linear => "G1",
            MotionMode::ArcClockwise => "G2",
            MotionMode::ArcCounterclockwise => "G3",
            MotionMode::Probe(p) => match (p.away, p.strict) {
                (false, true) => "G38.2",
                (false, false) => "G38.3",
                (true, true) => "G38.4",
                (true, false) => "G38.5",
            },
            MotionMode::None => "G80",
        };
        let plane = match s.plane {
            Plane::Xy => 17,
            Plane::Zx => 18,
            Plane::Yz => 19,
        };
        let units = if s.units == super::super::Units::Inch {
            20
        } else {
            21
        };
        let distance = if s.distance == Distance::Absolute {
            90
        } else {
            91
        };
        let feed = if s.feed_mode == FeedMode::PerMinute {
            94
        } else {
            93
        };
        let spindle = ["M4", "M5", "M3"][(s.spindle + 1) as usize];
        let coolant = if s.flood { "M8" } else { "M9" };
        format!(
            "[GC:{motion} G{} G{plane} G{units} G{distance} G{feed} {spindle} {coolant} T{} F{:.0} S{:.0}]",
            54 + s.work_offset,
            s.tool,
            s.feed.0,
            s.speed.0
        )
    }

    #[test]
    fn answers_as_the_firmware_did() {
        let mut wrong = vec![];
        for row in include_str!("../../tests/gcode/grbl-answers.tsv").lines() {
            if row.starts_with('#') {
                continue;
            }
            let cells: Vec<&str> = row.split('\t').collect();
            let mut state = State::new(Dialect::Grbl);
            let mut events = vec![];
            for line in cells[0].split('|') {
                let _ = interpret_line(&mut state, line, 1, &mut events);
            }
            let answer = match interpret_line(&mut state, cells[1], 1, &mut events) {
                Ok(()) => "ok".to_string(),
                Err(e) => format!("error:{}", number(&e.complaint)),
            };
            if answer != cells[2] && cells[2] != "-" {
                wrong.push(format!("{row}: {answer}"));
            }
            let xyz = |p: Vector| format!("{:.3},{:.3},{:.3}", p.x + 0.0, p.y + 0.0, p.z + 0.0);
            let got = [
                modes(&state),
                xyz(state.machine_position().coords),
                xyz(state.offset()),
            ];
            for (got, want) in got.iter().zip(&cells[3..]) {
                if got != want && !want.is_empty() {
                    wrong.push(format!("{row}: {got}"));
                }
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
