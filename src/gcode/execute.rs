//! Carrying out a block that `check` has proven sound: the new state, and what the machine is told. Cannot fail.
//!
//! The order inside a block is the firmware's: feed, speed, tool, spindle, coolant, dwell, plane, units, tool length, work offset,
//! distance, offsets, motion, stop. Events that wait for standstill are made only where the firmware waits: mostly on a change.

use super::block::Block;
use super::check::{Move, Offsets, Plan};
use super::codes::{Coolant, Group, Path, Stop, ToolLength};
use super::cycle;
use super::event::{Event, Motion, MotionKind, Plane};
use super::state::{Distance, FeedMode, MotionMode, PathMode, State};
use crate::geom::{Point, Vector};

/// Carries out a checked block. Cannot fail.
pub(super) fn execute(
    state: &mut State,
    block: &Block,
    plan: &Plan,
    line: usize,
    events: &mut Vec<Event>,
) {
    state.feed_mode = plan.feed_mode;
    state.feed = plan.feed;
    state.rapid_feed = plan.rapid_feed;
    let new_speed = plan.speed != state.speed;
    state.speed = plan.speed;
    state.tool = plan.tool;
    if plan.change {
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
    if block.wait {
        events.push(Event::Sync { line });
    }
    if let Some(time) = plan.dwell {
        events.push(Event::Dwell { time, line });
    }
    state.plane = plan.plane;
    state.units = plan.units;

    if block.seen(Group::WorkOffset) || block.tool_length.is_some() {
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
            Path::Exact => PathMode::ExactPath,
            Path::Stop => PathMode::ExactStop,
            Path::Blend => PathMode::Blend {
                tolerance: block.get(b'P').map(|p| p * state.units.mm()),
            },
        };
    }
    if let Some(retract) = block.retract {
        state.retract = retract;
    }
    state.motion = plan.motion;
    state.series = plan.series;
    let mut shift = Vector::zeros();
    if block.non_modal.is_some() {
        shift = offsets(state, plan, line, events);
    }
    travel(state, plan, shift, line, events);
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
fn offsets(state: &mut State, plan: &Plan, line: usize, events: &mut Vec<Event>) -> Vector {
    let mut shift = Vector::zeros();
    let machine = state.machine_position();
    match plan.offsets {
        Offsets::Keep => return shift,
        Offsets::Work { index, origin } => {
            state.set_origin(index, origin);
            state.set_machine_position(&machine);
        }
        Offsets::Shift {
            g92,
            position,
            local,
        } => {
            (state.g92, state.g92_kept, state.local) = (g92, g92, local);
            state.position = position;
        }
        Offsets::ClearShift => {
            shift = state.g92;
            (state.g92, state.g92_kept) = (Vector::zeros(), Vector::zeros());
            state.local = false;
            state.position += shift;
        }
        Offsets::SwitchShift { g92 } => {
            shift = state.g92 - g92;
            state.g92 = g92;
            state.position += shift;
        }
        Offsets::StoreHome => state.g28 = machine,
        Offsets::StoreSecondHome => state.g30 = machine,
    }
    // The levels of a series of cycles were told in other coordinates.
    state.series = None;
    events.push(Event::Sync { line });
    shift
}

/// The block's motion.
fn travel(state: &mut State, plan: &Plan, shift: Vector, line: usize, events: &mut Vec<Event>) {
    let motion = |state: &mut State, kind: MotionKind, to: Point| {
        let from = std::mem::replace(&mut state.position, to);
        Motion {
            kind,
            from,
            to,
            arc: None,
            feed: match kind {
                MotionKind::Rapid => plan.rapid_feed,
                MotionKind::Feed => plan.rate,
            },
            inverse_time: state.feed_mode == FeedMode::InverseTime,
            machine_coordinates: false,
            line,
        }
    };
    match plan.action {
        Move::Holes(ref holes) => cycle::drill(holes, state, shift, line, events),
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
    state.series = None;
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
