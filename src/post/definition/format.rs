//! How numbers and lines look.

/// The units of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// Millimetres.
    Mm,
    /// Inches.
    Inch,
}

impl Units {
    /// Millimetres in one unit.
    pub fn mm(self) -> f64 {
        match self {
            Units::Mm => 1.0,
            Units::Inch => 25.4,
        }
    }
}

/// Decimals of each class of word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals {
    /// X, Y, Z, I, J, K, R in mm.
    pub mm: u8,
    /// X, Y, Z, I, J, K, R in inches.
    pub inch: u8,
    /// F in mm/min.
    pub feed_mm: u8,
    /// F in inch/min.
    pub feed_inch: u8,
    /// S in rpm.
    pub speed: u8,
    /// Durations in s.
    pub seconds: u8,
    /// Angles in degrees.
    pub angle: u8,
}

impl Decimals {
    /// Of coordinates.
    pub fn coordinate(&self, units: Units) -> u8 {
        match units {
            Units::Mm => self.mm,
            Units::Inch => self.inch,
        }
    }

    /// Of feeds.
    pub fn feed(&self, units: Units) -> u8 {
        match units {
            Units::Mm => self.feed_mm,
            Units::Inch => self.feed_inch,
        }
    }
}

/// How a number is written that need not be whole: coordinates, feeds, seconds, tolerances. Counted things (S, T, H) are plain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Numbers {
    /// Always with a point: `X10.` Without one a Fanuc takes `X10` for 10 micrometres.
    pub point: bool,
    /// All decimals: `X10.000`.
    pub trailing_zeros: bool,
    /// `X+10`; coordinates only.
    pub plus: bool,
}

/// What may be left out when it has not changed since the last line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modal {
    /// The G0, G1, G2 or G3 of a line.
    pub motion: bool,
    /// An axis that does not move.
    pub axes: bool,
    /// F.
    pub feed: bool,
}

/// Which lines are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbered {
    /// All that are no comment.
    Words,
    /// Comments too.
    All,
    /// Only the first of each tool change, for the operator to start from.
    Tools,
}

/// A language for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spelling {
    /// Letters and numbers: ISO 6983, and Siemens' own language.
    Words,
    /// Heidenhain's conversational language.
    Heidenhain,
}
