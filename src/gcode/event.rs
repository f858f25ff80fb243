//! What a program tells the machine, in order: absolute, mm, mm/min, s. Only `gcode` makes motions.

pub use crate::geom::Plane;
use crate::geom::Point;
use crate::units::{MmPerMin, Rpm, Seconds};

/// Rapid or feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// G0: as fast as the machine goes, in a straight line.
    Rapid,
    /// G1, G2, G3: at the programmed feed.
    Feed,
}

/// The curved part of a motion. The helix runs from `from` to `to` about `center` in `plane`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Plane of the circle.
    pub plane: Plane,
    /// Centre, same coordinates as the motion; its out-of-plane coordinate is that of the start.
    pub center: Point,
    /// G2 (true) or G3, seen from the plane's positive normal.
    pub clockwise: bool,
    /// Signed total turn, rad: negative clockwise; a full circle is ±2π.
    pub sweep: f64,
}

/// One motion of the control point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Rapid or feed.
    pub kind: MotionKind,
    /// Start, in the active work coordinate system, mm.
    pub from: Point,
    /// End, in the active work coordinate system, mm.
    pub to: Point,
    /// `None` for a straight line.
    pub arc: Option<Arc>,
    /// Programmed feed (meaningless for rapids): mm/min, or 1/min when `inverse_time`.
    pub feed: MmPerMin,
    /// G93: `feed` is the reciprocal of the minutes this motion takes.
    pub inverse_time: bool,
    /// The end point in machine coordinates was named by G53, G28 or G30 rather than by the work system.
    pub machine_coordinates: bool,
    /// Line of the program, from 1.
    pub line: usize,
}

/// One thing a program makes the machine do. Commands that wait for standstill are [`Event::Dwell`], [`Event::Spindle`],
/// [`Event::Coolant`], [`Event::ToolChange`], [`Event::Probe`], [`Event::Sync`], [`Event::End`] and a [`Event::Pause`] that is not optional.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Move.
    Motion(Motion),
    /// Move in a straight line at feed until the probe says stop (G38.2 to G38.5); `motion.to` is as far as it may go.
    Probe {
        /// The longest motion there can be.
        motion: Motion,
        /// Move until contact is lost, rather than until it is made (G38.4, G38.5).
        away: bool,
        /// A miss is an alarm (G38.2, G38.4).
        strict: bool,
    },
    /// Stand still (G4).
    Dwell {
        /// How long.
        time: Seconds,
        /// Line of the program, from 1.
        line: usize,
    },
    /// M3, M4, M5 or a new speed while turning.
    Spindle {
        /// 1 clockwise, -1 counter-clockwise, 0 stopped.
        direction: i8,
        /// Programmed speed.
        speed: Rpm,
        /// Line of the program, from 1.
        line: usize,
    },
    /// M7, M8, M9.
    Coolant {
        /// Flood on.
        flood: bool,
        /// Mist on.
        mist: bool,
        /// Line of the program, from 1.
        line: usize,
    },
    /// M6. The spindle stands still behind it, whether or not it was told to.
    ToolChange {
        /// Tool number.
        tool: u32,
        /// Line of the program, from 1.
        line: usize,
    },
    /// M0 or M1.
    Pause {
        /// M1: only when the operator's switch is on.
        optional: bool,
        /// Line of the program, from 1.
        line: usize,
    },
    /// Any other command that waits for standstill without moving (a change of work offset and the like).
    Sync {
        /// Line of the program, from 1.
        line: usize,
    },
    /// M2 or M30.
    End {
        /// Line of the program, from 1.
        line: usize,
    },
}

impl Event {
    /// Line of the program this event comes from, from 1.
    pub fn line(&self) -> usize {
        match *self {
            Event::Motion(m) => m.line,
            Event::Probe { motion, .. } => motion.line,
            Event::Dwell { line, .. }
            | Event::Spindle { line, .. }
            | Event::Coolant { line, .. }
            | Event::ToolChange { line, .. }
            | Event::Pause { line, .. }
            | Event::Sync { line }
            | Event::End { line } => line,
        }
    }
}
