//! What the planner must know of a machine: the part of a machine's data, or of a controller's `$` settings, that decides on time.

use crate::machine::Machine;
use crate::units::{Mm, MmPerMin, MmPerSec2, Seconds};

/// What the planner must know of a machine. Arrays are X, Y, Z; every figure is above zero unless said otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Steps per mm ($100..): targets are rounded to whole steps.
    pub steps_per_mm: [f64; 3],
    /// Highest speed of each axis ($110..).
    pub max_rate: [MmPerMin; 3],
    /// Acceleration of each axis ($120..).
    pub acceleration: [MmPerSec2; 3],
    /// Junction deviation ($11); zero is a stop at each corner.
    pub junction_deviation: Mm,
    /// Arc tolerance ($12).
    pub arc_tolerance: Mm,
    /// Blocks the window holds (15 in GRBL); at least 1.
    pub blocks: usize,
    /// How long the motors are held after each standstill before anything else happens ($1); zero is allowed.
    pub idle_delay: Seconds,
}

impl From<&Machine> for Settings {
    fn from(m: &Machine) -> Settings {
        Settings {
            steps_per_mm: m.steps_per_mm,
            max_rate: m.max_rate,
            acceleration: m.acceleration,
            junction_deviation: m.junction_deviation,
            arc_tolerance: m.arc_tolerance,
            blocks: m.planner_blocks,
            idle_delay: m.idle_delay,
        }
    }
}
