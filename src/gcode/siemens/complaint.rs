//! What can be wrong with a Sinumerik block. Each text says what is wrong and what to do next.

use super::super::tongue::name::Name;

/// What is wrong with a block of a Sinumerik program.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SiemensComplaint {
    /// Something that no block can hold.
    #[error("{name:?} is not understood here: correct it, or post the program again")]
    NotUnderstood {
        /// What stands there.
        name: Name,
    },
    /// Something the control knows and this reader does not carry out.
    #[error("{name} is not supported: {why}")]
    Refused {
        /// The function.
        name: Name,
        /// What it would do, and what to write instead.
        why: &'static str,
    },
    /// A word without its number.
    #[error("{name} has no number: write sign and digits, or = and an expression, behind it")]
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
    /// Two words of one group.
    #[error("{second} and {first} belong to the same group ({group}): keep one of them")]
    SameGroup {
        /// The one that stands first.
        first: Name,
        /// The other.
        second: Name,
        /// What they set.
        group: &'static str,
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
    #[error("{name} needs {what}: add it")]
    Missing {
        /// The command.
        name: Name,
        /// What it needs.
        what: &'static str,
    },
    /// A command that shares its block with other words.
    #[error("{name} must stand in a block of its own: put the rest on another line")]
    Alone {
        /// The command.
        name: Name,
    },
    /// A word that nothing uses.
    #[error("nothing in this block uses {name}: remove it, or add the command it belongs to")]
    Unused {
        /// The word.
        name: Name,
    },
    /// No arc joins the points.
    #[error(
        "no circle of radius {radius:.4} mm joins points {distance:.4} mm apart: correct CR or the end point (full circles are written with I J K)"
    )]
    Radius {
        /// CR, mm.
        radius: f64,
        /// Distance from start to end in the plane, mm.
        distance: f64,
    },
    /// The distances of start and end from the centre differ.
    #[error(
        "the arc starts {start:.4} mm from its centre but ends {end:.4} mm from it: correct I J K or the end point"
    )]
    RadiiDiffer {
        /// Distance of the start, mm.
        start: f64,
        /// Distance of the end, mm.
        end: f64,
    },
    /// A variable or R parameter without value.
    #[error("{name} is used before it has a value: assign it first")]
    Unset {
        /// The variable.
        name: Name,
    },
    /// A name that was not defined.
    #[error(
        "{name} is not a known variable, function or address: define it with DEF, or correct it"
    )]
    Undefined {
        /// The name.
        name: Name,
    },
    /// A result that is no number.
    #[error("{name} gives no number here: correct the values")]
    NoNumber {
        /// The operation.
        name: Name,
    },
    /// Something else was expected in an expression.
    #[error("{what} is expected here: correct the expression")]
    Expected {
        /// What.
        what: &'static str,
    },
    /// A truth value where a number should be, or the other way round.
    #[error("{name} works on {what}: put comparisons in parentheses, as in (R1>0) AND (R2>0)")]
    Kind {
        /// The operator.
        name: Name,
        /// What it works on.
        what: &'static str,
    },
    /// Parentheses inside each other without end.
    #[error("the expression is nested too deeply: split it over several variables")]
    TooDeep,
    /// A control structure that does not close.
    #[error("the IF of line {line} has no ENDIF: add it")]
    IfOpen {
        /// The line of IF or ELSE.
        line: usize,
    },
    /// ELSE or ENDIF without IF.
    #[error("{name} without an IF before it: remove it, or add the IF")]
    IfMissing {
        /// ELSE or ENDIF.
        name: Name,
    },
    /// A subprogram is over, but does not say so.
    #[error("the subprogram ends without M17 or RET: add it as the last block")]
    ReturnMissing,
    /// An archive whose first program is no main program.
    #[error("the archive begins with a subprogram: put the main program (%_N_..._MPF) first")]
    MainFirst,
    /// Named and numbered tools in one program.
    #[error(
        "the program calls tools by name and by number: which is which cannot be known, keep to one of them"
    )]
    ToolsMixed,
    /// An incremental move behind a change of frame or tool length.
    #[error(
        "this incremental move follows a new frame or tool length, and machines differ in whether it takes that along: send {name} to an absolute place first"
    )]
    FrameMoved {
        /// The axis.
        name: Name,
    },
    /// Z in the part's system while the tool length is off.
    #[error(
        "the tool length is off (D0), so Z is not the tool's tip: program D1, or retract with SUPA or G53"
    )]
    LengthOff,
}
