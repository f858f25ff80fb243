//! A dialect as data: `posts/*.toml` read once into a checked [`Post`].

mod arcs;
mod file;
mod format;
mod laws;
mod read;

pub use arcs::{Arcs, Fit, Form, Shape};
pub use format::{Decimals, Modal, Numbered, Numbers, Spelling, Units};

use super::built_in::BUILT_IN;
use super::comment::Comments;
use super::template::Template;
use crate::machine::data::{self, DataError};
use crate::units::{Mm, MmPerMin};

/// A dialect, checked: every figure is in its bounds and every template can be written. Empty lists of lines say that the
/// controller cannot do it.
#[derive(Clone, Debug, PartialEq)]
pub struct Post {
    /// File name without `.toml`.
    pub name: String,
    /// What people call it.
    pub title: String,
    /// The interpreter that reads such programs back: one of [`super::READERS`].
    pub reader: String,
    /// The language.
    pub spelling: Spelling,
    /// Units of the program; the caller may change them.
    pub units: Units,
    /// The words that choose millimetres and inches; `None` where there are no such programs.
    pub unit_words: [Option<String>; 2],
    /// Which arcs may be written.
    pub arcs: Arcs,
    /// Decimals of each class of word.
    pub decimals: Decimals,
    /// How numbers look.
    pub numbers: Numbers,
    /// `"\n"` or `"\r\n"`.
    pub line_end: &'static str,
    /// Most characters in a line, without its end.
    pub longest: usize,
    /// What stands between words: a space or nothing.
    pub separator: String,
    /// Step of line numbers; zero for none.
    pub number_step: u32,
    /// The first line number; `None` for the step.
    pub number_start: Option<u32>,
    /// The highest line number; counting starts over after it.
    pub number_highest: u32,
    /// What stands before a line number: `N` or nothing.
    pub number_prefix: String,
    /// Which lines are numbered.
    pub numbered: Numbered,
    /// How comments are written.
    pub comments: Comments,
    /// Most characters of a comment, marks included.
    pub longest_comment: usize,
    /// What may be left out.
    pub modal: Modal,
    /// The F that rapids are to have, where G0 goes no faster than F says.
    pub rapid_feed: Option<MmPerMin>,
    /// A rapid in machine coordinates.
    pub machine_rapid: Vec<Template>,
    /// How tools are changed.
    pub tool: Tools,
    /// Which work coordinate systems there are.
    pub work_offsets: WorkOffsets,
    /// The spindle.
    pub spindle: Spindle,
    /// Coolant.
    pub coolant: CoolantLines,
    /// Standing still.
    pub dwell: Vec<Template>,
    /// Stopping for the operator.
    pub pause: Vec<Template>,
    /// Stopping for the operator when the switch says so.
    pub optional_pause: Vec<Template>,
    /// A pause stops spindle and coolant, so that both are said anew after it.
    pub pause_stops_spindle: bool,
    /// What stands around it all.
    pub program: Program,
    /// Path tolerance when the job names none.
    pub path_tolerance: Option<Mm>,
}

/// How tools are changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Tools {
    /// The change; empty where the operator's first tool is the only one.
    pub change: Vec<Template>,
    /// Length compensation. With `{axes}` it is written in place of the next rapid that names Z, otherwise on a line of its own
    /// after the change.
    pub length: Option<Template>,
    /// The highest tool number.
    pub most: u32,
    /// Machine Z to go to before a change; `None` where the controller sees to it.
    pub retract_z: Option<Mm>,
}

/// Which work coordinate systems there are.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkOffsets {
    /// The words of the first.
    pub words: Vec<Template>,
    /// The others; `{offset}` counts from 1 after the first.
    pub further: Option<Template>,
    /// How many there are in all.
    pub most: u16,
}

/// How the spindle is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Spindle {
    /// Clockwise.
    pub cw: Vec<Template>,
    /// Counter-clockwise.
    pub ccw: Vec<Template>,
    /// Stopped.
    pub off: Vec<Template>,
    /// The controller waits by itself until the speed is reached.
    pub waits: bool,
}

/// How coolant is told.
#[derive(Clone, Debug, PartialEq)]
pub struct CoolantLines {
    /// Flood on.
    pub flood: Vec<Template>,
    /// Mist on.
    pub mist: Vec<Template>,
    /// Both on.
    pub both: Vec<Template>,
    /// All off.
    pub off: Vec<Template>,
}

/// What stands around the steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The very first lines, never numbered: `%`, `O1001`.
    pub first: Vec<Template>,
    /// First lines: modes, path tolerance.
    pub start: Vec<Template>,
    /// Last lines: everything off, end of program.
    pub end: Vec<Template>,
    /// The very last lines, never numbered: `%`.
    pub last: Vec<Template>,
    /// A word ends the program; without one the text just ends.
    pub ends: bool,
    /// The lowest and highest program number.
    pub number: [u32; 2],
    /// Machine Z to go to at the end; `None` to stay.
    pub retract_z: Option<Mm>,
}

impl Post {
    /// Reads and checks a dialect called `name`. Unknown keys, missing keys, unknown placeholders and figures out of bounds are
    /// refused with line and column; all wrong values are reported, not only the first.
    pub fn from_toml(name: &str, text: &str) -> Result<Post, DataError> {
        Post::named(name, &format!("posts/{name}.toml"), text)
    }

    /// The same, from a file that complaints call `file`.
    pub fn named(name: &str, file: &str, text: &str) -> Result<Post, DataError> {
        read::post(name, file, text)
    }

    /// A built-in dialect by name, or a dialect file by path (anything with a `/`, or ending in `.toml`).
    pub fn load(name_or_path: &str) -> Result<Post, DataError> {
        let (name, file, text) = data::find("post", "posts", &BUILT_IN, name_or_path)?;
        Post::named(&name, &file, &text)
    }

    /// Decimals of X, Y and Z in the post's units.
    pub fn coordinate_decimals(&self) -> u8 {
        self.decimals.coordinate(self.units)
    }

    /// Decimals of F in the post's units.
    pub fn feed_decimals(&self) -> u8 {
        self.decimals.feed(self.units)
    }

    /// The word that chooses some units; `None` where there are no such programs.
    pub fn unit_word(&self, units: Units) -> Option<&str> {
        let [mm, inch] = &self.unit_words;
        match units {
            Units::Mm => mm.as_deref(),
            Units::Inch => inch.as_deref(),
        }
    }

    /// The worst error of a written coordinate, mm: half a unit of its last decimal.
    pub fn rounding(&self) -> Mm {
        Mm(0.5 * self.units.mm() * 0.1_f64.powi(i32::from(self.coordinate_decimals())))
    }
}

#[cfg(test)]
mod tests;
