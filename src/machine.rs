//! A machine as data: `machines/*.toml` read once into a checked [`Machine`].

use crate::units::{Mm, MmPerMin, MmPerSec2, Rpm};

/// A 3-axis machine. Every figure is finite and above zero unless said otherwise. Arrays are X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// File name without `.toml`.
    pub name: String,
    /// What people call it.
    pub title: String,
    /// Controller family: `grbl`, `grblhal`, `fluidnc`, `linuxcnc`.
    pub controller: String,
    /// Default dialect: the name of a file in `posts/`.
    pub post: String,
    /// Travel of each axis.
    pub travel: [Mm; 3],
    /// Highest speed of each axis ($110..).
    pub max_rate: [MmPerMin; 3],
    /// Acceleration of each axis ($120..).
    pub acceleration: [MmPerSec2; 3],
    /// Steps per mm of each axis ($100..).
    pub steps_per_mm: [f64; 3],
    /// GRBL's cornering measure ($11).
    pub junction_deviation: Mm,
    /// GRBL's arc tolerance ($12).
    pub arc_tolerance: Mm,
    /// Blocks of look-ahead the planner can hold (GRBL: 15 usable).
    pub planner_blocks: usize,
    /// Bytes of receive buffer (GRBL: 128).
    pub rx_buffer: usize,
    /// Lowest and highest spindle speed; zero lowest is allowed.
    pub spindle: [Rpm; 2],
    /// Serial speed, baud.
    pub baud: u32,
}
