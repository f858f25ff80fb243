//! One thing that the tool is to do.

use super::job::Coolant;
use crate::geom::{Plane, Point};
use crate::units::{MmPerMin, Rpm, Seconds};

/// A place of which not every axis need be told: X, Y, Z; work coordinates, mm. What is `None` stays where it is.
pub type Place = [Option<f64>; 3];

/// The curved part of a feed move. Its helix runs from where the tool is to the end of the move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bow {
    /// Plane of the circle.
    pub plane: Plane,
    /// Centre, work coordinates, mm; its coordinate out of the plane means nothing.
    pub center: Point,
    /// Signed turn, rad, seen from the plane's positive normal: negative clockwise, never zero; 2 pi is once round, more are further
    /// turns of a helix.
    pub sweep: f64,
}

/// A step of a job. Steps come in order; what a step sets holds until another sets it anew.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A note for people; changes nothing.
    Comment(String),
    /// A tool is put in. The spindle is off then, whatever it was.
    Tool {
        /// Its number.
        number: u32,
    },
    /// The spindle turns, or stops.
    Spindle {
        /// 1 clockwise seen from above, -1 counter-clockwise, 0 stopped.
        direction: i8,
        /// Speed; means nothing when stopped.
        speed: Rpm,
        /// How long it takes to reach its speed, for controllers that do not wait by themselves; zero when nothing need wait.
        spin_up: Seconds,
    },
    /// Coolant on or off.
    Coolant(Coolant),
    /// Stand still.
    Dwell(Seconds),
    /// Stop until the operator goes on.
    Pause {
        /// Only when the operator's switch says so.
        optional: bool,
    },
    /// Which work coordinate system holds from here on: 1 is G54, 6 is G59, 7 on are the dialect's further ones.
    WorkOffset(u16),
    /// As fast as the machine goes. Controllers differ in the way between: only the ends are sure.
    Rapid {
        /// Where to; at least one axis.
        to: Place,
    },
    /// The same, to a place in machine coordinates (a tool change height, a parking place).
    MachineRapid {
        /// Where to, machine coordinates, mm; at least one axis.
        to: Place,
    },
    /// At feed, straight or along an arc. Where the tool is must be known.
    Feed {
        /// Where to.
        to: Point,
        /// `None` for a straight line.
        bow: Option<Bow>,
        /// Feed along the path, above zero.
        feed: MmPerMin,
    },
    /// The program is over: spindle and coolant off.
    End,
}
