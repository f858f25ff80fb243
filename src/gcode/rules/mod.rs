//! What each controller makes of letters and numbers: one table of constants a dialect, read by `block` and `check`.
//!
//! Crosses the border: a [`Dialect`] in; its [`Rules`] out. Lengths in mm, times in s. Nothing here reads a line or moves anything; what the
//! command line prints about a dialect ([`table`]) is made of the same constants that the reader goes by.
//!
//! Where a maker leaves a figure to a parameter or a setting, the rules say what is assumed ([`Rules::assumed`]); where a wrong guess would
//! move the tool elsewhere, the word is refused instead.

mod centroid;
mod common;
mod complaint;
mod desktop;
mod fanuc;
mod grbl;
mod linuxcnc;
mod mach;
mod masso;
mod okuma;
mod printer;
mod table;
mod tinyg;

pub(in crate::gcode) use common::TOOL_TABLE;
pub use complaint::RuleComplaint;
pub use table::{Row, Table, table};

use super::codes::{Coolant, Group, Letters, NonModal, Path, Stop, ToolLength};
use super::cycle::CycleRules;
use super::dialect::Dialect;
use super::event::Plane;
use super::state::{Distance, FeedMode, MotionMode, Retract, Units};

/// What a G or M code does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    Motion(MotionMode),
    /// G80, where it stands in a group of its own and G0 may stand beside it.
    CycleOff,
    NonModal(NonModal),
    Plane(Plane),
    Distance(Distance),
    ArcDistance(Distance),
    FeedMode(FeedMode),
    Units(Units),
    Retract(Retract),
    ToolLength(ToolLength),
    /// The n-th work offset, from 0.
    WorkOffset(usize),
    /// The work offset that a word names: 1 is number `base`.
    WorkOffsetBy {
        letter: u8,
        base: usize,
        most: u32,
    },
    Path(Path),
    Stop(Stop),
    Spindle(i8),
    Coolant(Coolant),
    ToolChange,
    /// Waits for standstill, nothing else.
    Wait,
    /// Accepted, since it leaves the path as it is. The letters are its own words.
    Nothing(Group, Letters, &'static str),
    /// Refused by name. The text says why, and what to do.
    Refused(&'static str),
}

/// A code in hundredths (G38.2 is 3820) and what it does.
pub(super) type Entry = (u32, Meaning);

/// What the number of a dwell word counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Seconds,
    Milliseconds,
    /// Milliseconds when written without a point, seconds with one.
    ByPoint,
    /// Seconds, and a point must be written.
    Pointed,
    /// Whole seconds.
    WholeSeconds,
}

/// How long a line may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineLength {
    Any,
    /// So many characters without blanks and comments.
    Significant(usize),
    /// So many characters, all counted.
    All(usize),
    /// So many characters in front of a `;`.
    BeforeComment(usize),
}

/// What `( ... )` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parentheses {
    /// A comment; may stay open to the end of the line (GRBL).
    Loose,
    /// A comment; must be closed, must not be nested.
    Strict,
    /// A comment, behind which nothing of the line is read.
    Last,
    /// No comment.
    No,
}

/// What `;` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Semicolon {
    /// Opens a comment up to the end of the line.
    Comment,
    /// Ends the block; nothing may stand behind it.
    EndOfBlock,
}

/// What a `/` in front of a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlockDelete {
    /// Nothing that belongs there.
    No,
    /// Dropped wherever it stands (GRBL).
    Ignored,
    /// The operator's switch skips the line.
    Switch,
    /// Nine switches, `/1` to `/9`.
    Levels,
}

/// How far the two radii of an arc by its centre may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ArcMiss {
    /// Half a millimetre, and 0.005 mm or a thousandth of the radius.
    Grbl,
    /// 0.127 mm, and 0.00127 mm or a thousandth of the radius.
    LinuxCnc,
}

/// When a T word puts the tool in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ToolWord {
    /// It selects; M6 changes.
    Select,
    /// At once.
    AtOnce,
}

/// What `G10 L20` sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OffsetTwenty {
    /// The offset by what the tool's place shall be called.
    Measured,
    /// The further work offsets (G54.1 Pn), so many of them, as L2 does for G54 to G59.
    Further(u32),
    /// Not there.
    No,
}

/// A dialect's rules.
#[derive(Debug)]
pub(super) struct Rules {
    pub title: &'static str,
    /// Where the rules come from.
    pub source: &'static str,
    /// What is taken for granted where the controller goes by a setting.
    pub assumed: &'static [&'static str],
    /// G codes; the first table that has a code counts.
    pub g: &'static [&'static [Entry]],
    /// M codes, likewise.
    pub m: &'static [&'static [Entry]],
    /// Why M codes that are not in the tables are refused, where builders and users add their own.
    pub other_m: Option<&'static str>,
    /// Letters of value words.
    pub letters: Letters,
    /// Letters refused by name.
    pub refused: &'static [(u8, &'static str)],
    /// Letters that must not be negative.
    pub positive: Letters,
    /// Letters whose number needs a decimal point, since without one it counts the control's smallest steps.
    pub pointed: Letters,
    /// Letters whose number must not have a decimal point.
    pub pointless: Letters,
    pub tool_limit: u32,
    pub tool_word: ToolWord,
    /// M6 needs a T, in its line or before.
    pub tool_named: bool,
    pub length: LineLength,
    /// Digits of a number that are read.
    pub digits: u32,
    pub parentheses: Parentheses,
    pub semicolon: Semicolon,
    pub block_delete: BlockDelete,
    /// `*nn` at the end of a line is a checksum.
    pub checksum: bool,
    /// GRBL's own order of complaints, and its way with numbers (they wrap at 256).
    pub firmware: bool,
    pub dwell: &'static [(u8, Unit)],
    /// The dwell's words, for messages.
    pub dwell_words: &'static str,
    pub arc_miss: ArcMiss,
    /// An arc by its centre needs no end point: it is a full circle then.
    pub whole_circle: bool,
    /// Words of G64.
    pub blend_words: Letters,
    /// P of an arc is its number of turns.
    pub turns: bool,
    /// G53 moves at rapid whatever the motion mode, and only in G90.
    pub machine_rapid: bool,
    /// G0 or G1 beside G28 sets the mode, while the axis words belong to G28.
    pub home_beside_motion: bool,
    /// G28 without axis words does not move.
    pub home_needs_axes: bool,
    /// G43 needs its H.
    pub length_needs_h: bool,
    pub twenty: OffsetTwenty,
    /// G10 L2 adds in G91.
    pub offsets_add: bool,
    /// Work offsets that G10 L2 can set: G54 on, in order.
    pub offsets: usize,
    /// P behind G54 (0) or G59 (5): first offset it names, how many.
    pub offset_p: Option<(usize, usize, u32)>,
    /// P beside M3, M4, M5 names the spindle; only the first, P0, is there.
    pub spindle_p: bool,
    /// F of a G0 line does not touch the feed of G1.
    pub rapid_feed_apart: bool,
    pub cycles: Option<&'static CycleRules>,
}

impl Rules {
    /// What a G code does, by its number in hundredths. G0 to G3 mean the same everywhere (a test holds the tables to it) and are not
    /// looked for: most lines have no other.
    #[inline]
    pub fn g(&self, code: u32) -> Option<Meaning> {
        match code {
            0 => Some(Meaning::Motion(MotionMode::Rapid)),
            100 => Some(Meaning::Motion(MotionMode::Linear)),
            200 => Some(Meaning::Motion(MotionMode::ArcClockwise)),
            300 => Some(Meaning::Motion(MotionMode::ArcCounterclockwise)),
            _ => find(self.g, code),
        }
    }

    /// What an M code does, by its number in hundredths.
    pub fn m(&self, code: u32) -> Option<Meaning> {
        find(self.m, code)
    }
}

fn find(tables: &[&[Entry]], code: u32) -> Option<Meaning> {
    tables
        .iter()
        .flat_map(|t| t.iter())
        .find(|(c, _)| *c == code)
        .map(|(_, m)| *m)
}

impl Dialect {
    /// The rules that its lines are read by. Siemens' and Heidenhain's own languages are read elsewhere: their tables here are empty, so
    /// that every word would be refused.
    #[inline]
    pub(super) fn rules(self) -> &'static Rules {
        match self {
            Dialect::Grbl => &grbl::GRBL,
            Dialect::GrblHal => &grbl::GRBLHAL,
            Dialect::FluidNc => &grbl::FLUIDNC,
            Dialect::LinuxCnc => &linuxcnc::LINUXCNC,
            Dialect::Mach3 => &mach::MACH3,
            Dialect::Mach4 => &mach::MACH4,
            Dialect::UccNc => &mach::UCCNC,
            Dialect::Eding => &desktop::EDING,
            Dialect::Planet => &desktop::PLANET,
            Dialect::Fanuc => &fanuc::FANUC,
            Dialect::Haas => &fanuc::HAAS,
            Dialect::Siemens => &common::SIEMENS,
            Dialect::Heidenhain => &common::HEIDENHAIN,
            Dialect::Mazak => &fanuc::MAZAK,
            Dialect::Okuma => &okuma::OKUMA,
            Dialect::Centroid => &centroid::CENTROID,
            Dialect::Marlin => &printer::MARLIN,
            Dialect::Smoothie => &printer::SMOOTHIE,
            Dialect::RepRap => &printer::REPRAP,
            Dialect::TinyG => &tinyg::TINYG,
            Dialect::Masso => &masso::MASSO,
            Dialect::Carbide => &grbl::CARBIDE,
        }
    }
}

#[cfg(test)]
mod tests;
