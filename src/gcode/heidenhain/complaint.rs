//! What can be wrong with a conversational block. Each text says what is wrong and what to do next.

use super::super::tongue::name::Name;

/// What is wrong with a block of a Heidenhain program.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum HeidenhainComplaint {
    /// A word that the block cannot hold, or no word at all.
    #[error("{name:?} is not understood here: correct it, or post the program again")]
    NotUnderstood {
        /// What stands there.
        name: Name,
    },
    /// Something the TNC knows and this reader does not carry out.
    #[error("{name} is not supported: {why}")]
    Refused {
        /// The function.
        name: Name,
        /// What it would do, and what to write instead.
        why: &'static str,
    },
    /// A word without its number.
    #[error("{name} has no number: write sign and digits, or a Q parameter, behind it")]
    NumberMissing {
        /// The word.
        name: Name,
    },
    /// A word stands twice.
    #[error("{name} stands twice in this block: keep one")]
    Repeated {
        /// The word.
        name: Name,
    },
    /// A number outside what the word takes.
    #[error("{name} takes {range}: correct it")]
    Range {
        /// The word.
        name: Name,
        /// What it takes.
        range: &'static str,
    },
    /// Something that the block needs is not there.
    #[error("{command} needs {what}: add it")]
    Missing {
        /// The block's first word.
        command: &'static str,
        /// What it needs.
        what: &'static str,
    },
    /// A block before BEGIN PGM.
    #[error(
        "the program does not open with BEGIN PGM, name and MM (or INCH): its units are unknown, add that block"
    )]
    BeginMissing,
    /// A second BEGIN PGM.
    #[error("a second BEGIN PGM: keep one program in a file")]
    BeginTwice,
    /// END PGM with another name or other units.
    #[error(
        "END PGM does not name the program that BEGIN PGM opened ({name}): the file may be two pieces, correct it"
    )]
    EndDiffers {
        /// The program's name and units as BEGIN PGM gave them.
        name: Name,
    },
    /// The text is over, the program is not.
    #[error(
        "the program has no END PGM and no M30 or M2 was reached: the file may be cut off, transfer it again"
    )]
    EndMissing,
    /// END PGM inside a subprogram.
    #[error("the program ends inside a called subprogram: close it with LBL 0")]
    LabelOpen,
    /// C, CP, LP without CC.
    #[error("{command} turns about the pole, and none is set: put a CC block before it")]
    PoleMissing {
        /// The block's first word.
        command: &'static str,
    },
    /// The distances of start and end from the centre differ.
    #[error(
        "the arc starts {start:.4} mm from CC but ends {end:.4} mm from it: correct CC or the end point"
    )]
    RadiiDiffer {
        /// Distance of the start, mm.
        start: f64,
        /// Distance of the end, mm.
        end: f64,
    },
    /// No circle of the radius joins the points.
    #[error(
        "no circle of radius {radius:.4} mm joins points {distance:.4} mm apart: correct R or the end point (full circles are written with CC and C)"
    )]
    Radius {
        /// The radius, mm.
        radius: f64,
        /// Distance from start to end, mm.
        distance: f64,
    },
    /// CT where no tangent is known, or straight ahead.
    #[error(
        "CT needs a contour block in X and Y right before it, and an end point off its tangent: write L or CR instead"
    )]
    NoTangent,
    /// A Q parameter is read that has no value.
    #[error("Q{number} is used before it has a value: assign it first, as in FN 0: Q{number} = +0")]
    Unset {
        /// The parameter.
        number: u32,
    },
    /// A result that is no number.
    #[error("{what} gives no number here: correct the values")]
    NoNumber {
        /// The operation.
        what: &'static str,
    },
    /// Something else was expected in a formula.
    #[error("{what} is expected here: correct the formula")]
    Expected {
        /// What.
        what: &'static str,
    },
    /// Parentheses or signs inside each other without end.
    #[error("the formula is nested too deeply: split it over several Q parameters")]
    TooDeep,
    /// A cycle's parameter is missing.
    #[error("cycle {cycle} needs Q{parameter}: add it to the CYCL DEF")]
    CycleParameter {
        /// The cycle.
        cycle: u32,
        /// The parameter.
        parameter: u32,
    },
    /// Not a line of the cycle definition that is open.
    #[error(
        "the CYCL DEF before this line is not finished (its line ends with ~): go on with its Q parameters"
    )]
    CycleOpen,
    /// A cycle call, and no cycle.
    #[error("no cycle is defined that could be called: put a CYCL DEF before it")]
    CycleMissing,
    /// Named and numbered tools in one program.
    #[error(
        "the program calls tools by name and by number: which is which cannot be known, keep to one of them"
    )]
    ToolsMixed,
}
