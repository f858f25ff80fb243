//! Why a program could not be written: the post, the place, and what to do.

use super::number;
use crate::cldata::Coolant;
use crate::geom::Plane;
use crate::toolpath::MoveKind;

/// Where in the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    /// The job as a whole.
    Job,
    /// A step, counted from 1 in the order they were given.
    Step(usize),
    /// Index into [`crate::toolpath::Toolpath::moves`].
    Move(usize),
}

/// A program that was not written. What a writer put out before is no program: throw it away.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct PostError {
    /// Name of the post.
    pub post: String,
    /// Where.
    pub spot: Spot,
    /// Why.
    pub refusal: Refusal,
}

impl Refusal {
    /// True for what a path of straight lines would not meet.
    pub fn is_of_arcs(&self) -> bool {
        matches!(
            self,
            Refusal::Arc { .. } | Refusal::ArcRounding { .. } | Refusal::TooManyLines { .. }
        )
    }
}

impl std::fmt::Display for PostError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "post {}: ", self.post)?;
        match self.spot {
            Spot::Job => {}
            Spot::Step(n) => write!(f, "step {n}: ")?,
            Spot::Move(i) => write!(f, "move {i}: ")?,
        }
        write!(f, "{}", self.refusal)
    }
}

/// Why.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Nothing to write.
    #[error("the toolpath has no moves: there is nothing to cut")]
    Empty,
    /// A toolpath that starts in the material.
    #[error("is a {0:?}: a program must begin with a Rapid to the safe height")]
    FirstMove(MoveKind),
    /// A coordinate that is no number.
    #[error("{axis} is {value}: the path is broken there, so no program was written")]
    NotFinite {
        /// X, Y or Z.
        axis: char,
        /// NaN or an infinity.
        value: f64,
    },
    /// A coordinate with more digits than controllers read.
    #[error(
        "{axis} = {value} mm has more than {} digits as this dialect writes it: controllers read no more",
        number::MOST_DIGITS
    )]
    TooLarge {
        /// X, Y or Z.
        axis: char,
        /// The coordinate, mm.
        value: f64,
    },
    /// A safe height that is no height.
    #[error("the safe height is {0} mm, which cannot be written: set a height above the part")]
    SafeHeight(f64),
    /// A figure that makes no sense, or that this dialect would write as zero.
    #[error("{what} is {value}: it must be {must}, and fit the decimals of this post")]
    Figure {
        /// The figure.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The rule.
        must: &'static str,
    },
    /// A rapid that names no axis.
    #[error("a rapid that names no axis goes nowhere: leave it out")]
    NoAxis,
    /// A feed move while it is not known where the tool is.
    #[error(
        "a feed move, but where {0} is at its start is not known: put a rapid that names {0} before it (a program's start, a tool change, a work offset and machine coordinates leave it unknown)"
    )]
    Unknown(char),
    /// A direction other than -1, 0, 1.
    #[error("the spindle's direction is {0}: it must be 1 (clockwise), -1 or 0 (stopped)")]
    Direction(i8),
    /// A direction the dialect has no words for.
    #[error(
        "this controller cannot turn its spindle {0}: write such lines into [spindle] if yours can"
    )]
    NoSpindle(&'static str),
    /// A coolant the dialect has no words for.
    #[error("this controller has no words for {}: choose another coolant, or none; where yours has them, write them into [coolant]", .0.words())]
    NoCoolant(Coolant),
    /// A second tool where there is no tool change.
    #[error(
        "tool {wanted} is wanted while tool {inside} is in, and this controller has no tool change: make one program for each tool"
    )]
    NoToolChange {
        /// The tool that is in.
        inside: u32,
        /// The tool that should be.
        wanted: u32,
    },
    /// A tool number that the controller does not have.
    #[error("tool {number}: this controller has tools 0 to {most}")]
    NoTool {
        /// The number.
        number: u32,
        /// The highest there is.
        most: u32,
    },
    /// A work offset that the controller does not have.
    #[error("work offset {number}: this controller has {most}, counted from 1 (1 is G54)")]
    NoWorkOffset {
        /// Counted from 1.
        number: u16,
        /// How many there are.
        most: u16,
    },
    /// Something the dialect has no words for.
    #[error("this controller has no {what}: {remedy}")]
    Cannot {
        /// What.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// An arc that the dialect cannot write.
    #[error("{what}, and this controller takes {takes}: {remedy}")]
    Arc {
        /// What the arc is.
        what: String,
        /// What could be written.
        takes: String,
        /// What to do.
        remedy: &'static str,
    },
    /// An arc that is no cut.
    #[error("is a {0:?} along an arc: only a Cut or a Link may turn")]
    ArcKind(MoveKind),
    /// An arc that is not one, or not one any more when its ends and centre are written with so few decimals.
    #[error("the arc about {} cannot be written with {decimals} decimals: {problem}", about(.plane, .center))]
    ArcRounding {
        /// Its plane.
        plane: Plane,
        /// Its centre along the plane's two axes, mm.
        center: [f64; 2],
        /// Decimals of a coordinate.
        decimals: u8,
        /// What goes wrong.
        problem: &'static str,
    },
    /// An arc that would become too many lines.
    #[error(
        "an arc of radius {radius} mm would become {lines:.0} lines within {tolerance} mm: give a coarser tolerance (--arcs-to-lines)"
    )]
    TooManyLines {
        /// Its radius, mm.
        radius: f64,
        /// How many.
        lines: f64,
        /// Within what, mm.
        tolerance: f64,
    },
    /// A comment that does not fit one line, where it may not be split.
    #[error(
        "a comment of {length} characters, and a line holds {longest}: shorten it, or let it be split"
    )]
    LongComment {
        /// Its length.
        length: usize,
        /// What a comment may have.
        longest: usize,
    },
    /// A line longer than the dialect allows.
    #[error("line {line} has {length} characters and this controller reads {longest}: {text}")]
    LineTooLong {
        /// Line of the program, from 1.
        line: usize,
        /// Its length.
        length: usize,
        /// What is allowed.
        longest: usize,
        /// The line.
        text: String,
    },
    /// Units that the dialect has no word for.
    #[error("this post has no programs in {0}: choose the other units")]
    NoUnits(&'static str),
    /// A program name the dialect cannot write.
    #[error(
        "the program name \"{0}\" cannot be written: letters, digits, - and _ only, 1 to 24 of them"
    )]
    Name(String),
    /// A program number the dialect does not have.
    #[error("program number {number}: this controller has {least} to {most}")]
    Number {
        /// The number.
        number: u32,
        /// The lowest.
        least: u32,
        /// The highest.
        most: u32,
    },
    /// A step after the end.
    #[error("comes after the end of the program: nothing may")]
    AfterEnd,
    /// A program without its end.
    #[error("the program has no End step: its spindle would keep turning")]
    NoEnd,
    /// A writer that refused a step before.
    #[error("a step was refused before: there is no program to go on with")]
    Broken,
    /// The output did not take the text.
    #[error("the program could not be put out: {0}")]
    Output(String),
}

fn about(plane: &Plane, center: &[f64; 2]) -> String {
    let [first, second, _] = plane.axes();
    let letter = |axis: usize| ['X', 'Y', 'Z'].get(axis).copied().unwrap_or('?');
    format!(
        "{}{} {}{}",
        letter(first),
        center[0],
        letter(second),
        center[1]
    )
}
