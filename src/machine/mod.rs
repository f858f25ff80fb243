//! A machine as data: `machines/*.toml` read once into a checked [`Machine`].
//!
//! Crosses the border: the text of a machine file in; travels in mm, rates in mm/min, accelerations in mm/s², all checked, out.
//! Never knows parts, paths or dialects (a machine names its dialect, it does not open it).

pub mod advice;
mod built_in;
pub mod data;
pub mod family;
mod file;
mod plain;
pub mod proofread;
mod row;
pub mod search;
pub mod settings_file;

pub use built_in::BUILT_IN;
pub use data::{DataError, Place};
pub use family::{CONTROLLERS, Family};
pub use settings_file::SettingsFile;

use crate::units::{Mm, MmPerMin, MmPerSec2, Rpm, Seconds};

/// A 3-axis machine. Every figure is finite and above zero unless said otherwise. Arrays are X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// File name without `.toml`.
    pub name: String,
    /// What people call it.
    pub title: String,
    /// Controller family: one of [`CONTROLLERS`].
    pub controller: String,
    /// Default dialect: the name of a file in `posts/`.
    pub post: String,
    /// Travel of each axis.
    pub travel: [Mm; 3],
    /// Highest speed of each axis ($110..): its rapid traverse.
    pub max_rate: [MmPerMin; 3],
    /// Highest feed while cutting, where the maker names one below the rapid traverse.
    pub max_feed: Option<MmPerMin>,
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
    /// How long the motors are held after each standstill before anything else happens ($1); [`IDLE_DELAY`] in every machine file.
    pub idle_delay: Seconds,
    /// Bytes of receive buffer (GRBL: 128).
    pub rx_buffer: usize,
    /// Lowest and highest spindle speed; zero lowest is allowed.
    pub spindle: [Rpm; 2],
    /// Serial speed, baud; zero for a controller that is not fed over a serial line (LinuxCNC).
    pub baud: u32,
    /// Keys that the file leaves out: their figures are [`family::STAND_IN`], in the order of [`family::OPTIONAL_KEYS`].
    pub stand_ins: Vec<&'static str>,
}

/// GRBL's `$1` as shipped.
pub const IDLE_DELAY: Seconds = Seconds(0.025);

/// The machine used when none is named: a mid-size router whose maker publishes every figure.
pub const DEFAULT_MACHINE: &str = "longmill-30x30";

impl Machine {
    /// Reads and checks a machine file called `name`. Unknown keys, missing keys and figures no machine has are refused, each with
    /// its line and column; every wrong figure is reported, not only the first.
    pub fn from_toml(name: &str, text: &str) -> Result<Machine, DataError> {
        Machine::named(name, &format!("machines/{name}.toml"), text)
    }

    /// A machine by name (the user's own before the built-in ones), or a machine file by path (anything with a `/`, or ending in
    /// `.toml`).
    pub fn load(name_or_path: &str) -> Result<Machine, DataError> {
        let (name, file, text) = data::find("machine", "machines", &BUILT_IN, name_or_path)?;
        Machine::named(&name, &file, &text)
    }

    /// [`Machine::from_toml`] of a text that complaints call `file`.
    pub fn named(name: &str, file: &str, text: &str) -> Result<Machine, DataError> {
        file::read(name, file, text)
    }

    /// Its controller family.
    pub fn family(&self) -> Option<&'static Family> {
        Family::of(&self.controller)
    }

    /// True when it can be talked to in GRBL's protocol.
    pub fn speaks_grbl(&self) -> bool {
        self.family().is_some_and(Family::speaks_grbl)
    }
}

#[cfg(test)]
mod tests;
