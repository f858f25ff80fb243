//! What can be wrong with a line by one dialect's rules and not by another's.

use crate::gcode::error::Code;

/// A mistake that only some dialects know. Each text says what is wrong and what to do next.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RuleComplaint {
    /// A code that is known and refused.
    #[error("{code} is refused: {why}")]
    Refused {
        /// The code.
        code: Code,
        /// Why, and what to do.
        why: &'static str,
    },
    /// A letter that is known and refused.
    #[error("{letter} is refused: {why}")]
    RefusedWord {
        /// The letter.
        letter: char,
        /// Why, and what to do.
        why: &'static str,
    },
    /// `,C` `,R` `,A`: corners and angles that the control computes.
    #[error(
        ",{letter} is refused: the control works out the corner or the point by itself; post it as G1, G2 or G3 with its coordinates"
    )]
    CommaWord {
        /// The letter.
        letter: char,
    },
    /// A number without a point where the control would count its smallest steps.
    #[error(
        "{letter} has no decimal point: by a parameter this control takes such a number for whole units or for its smallest steps; write the point"
    )]
    PointMissing {
        /// The letter.
        letter: char,
    },
    /// A point where the control allows none.
    #[error("{letter} must be written without a decimal point on this control")]
    PointForbidden {
        /// The letter.
        letter: char,
    },
    /// A dwell with two words for its time.
    #[error("the dwell has two times: keep one of them")]
    TwoDwells,
    /// One word that two commands of the line want.
    #[error("two commands of this line would use {letter}: put them on two lines")]
    WantedTwice {
        /// The letter.
        letter: char,
    },
    /// A number outside of what the word can name.
    #[error("{letter} must be a whole number from {least} to {most} here")]
    Range {
        /// The letter.
        letter: char,
        /// The least.
        least: u32,
        /// The most.
        most: u32,
    },
    /// G53 with G1 on a control where it always moves at rapid.
    #[error("G53 moves at rapid on this control whatever stands beside it: put G0 on this line")]
    MachineIsRapid,
    /// G53 in G91 on a control that ignores it then.
    #[error("G53 does not work in G91 on this control: put G90 on this line")]
    MachineIncremental,
    /// G52 and G92 both in force, where the control keeps them apart.
    #[error("G52 and G92 at once are not supported: cancel the earlier one first")]
    TwoShifts,
    /// G92.1 and its relatives beside axis words.
    #[error(
        "the axis words of this line would be read before or after the shift: put them on two lines"
    )]
    ShiftBesideMotion,
    /// A cycle without a word it needs.
    #[error("the drilling cycle needs {word}: add it")]
    CycleWord {
        /// What is missing.
        word: &'static str,
    },
    /// X or Y beside a repetition of zero: whether the tool goes there differs.
    #[error(
        "whether a cycle that is not repeated (zero times) goes to its X and Y differs: name the first hole on the next line"
    )]
    CycleNoHole,
    /// A cycle in another plane than G17.
    #[error("drilling cycles are understood in G17 only: put G17 before them")]
    CyclePlane,
    /// A cycle in G93.
    #[error("drilling cycles do not work in G93: put G94 before them")]
    CycleInverseTime,
    /// R below Z.
    #[error(
        "the bottom of the hole, Z {bottom:.4} mm, is above the R level, {r:.4} mm: correct Z or R"
    )]
    CycleUpward {
        /// Bottom, mm.
        bottom: f64,
        /// R level, mm.
        r: f64,
    },
    /// R above the level the cycle starts from.
    #[error(
        "the R level, {r:.4} mm, is above the level that the cycle starts from, {level:.4} mm: rapid higher first"
    )]
    CycleLevel {
        /// R level, mm.
        r: f64,
        /// Where the tool is, mm.
        level: f64,
    },
    /// Q so small that the hole takes forever.
    #[error("this cycle would make {pecks:.0} pecks: correct Q, Z or the number of repeats")]
    Pecks {
        /// How many.
        pecks: f64,
    },
    /// Spindle not turning in a cycle that stops and restarts it.
    #[error(
        "this cycle stops the spindle and starts it again, but it does not turn: put M3 and S before it"
    )]
    CycleSpindle,
    /// Feed per turn while nothing turns.
    #[error(
        "the feed is per turn (G95) but the spindle has no speed: put S and M3 before this move, or use G94"
    )]
    FeedPerTurn,
    /// A checksum that does not fit.
    #[error("the checksum is {found}, the line's own is {due}: send the line anew")]
    Checksum {
        /// As written.
        found: f64,
        /// As it should be.
        due: u8,
    },
    /// Words behind a comment where nothing is read any more.
    #[error("this control reads nothing behind a comment: put the comment at the end of the line")]
    BehindComment,
    /// `(` where it opens no comment.
    #[error(
        "parentheses are no comment on this control: write ; in front of a comment, or remove it"
    )]
    NoParentheses,
    /// Words behind `;` where it ends the block.
    #[error(
        "; ends the block on this control, and what follows would be read as the next: write ( ) around a comment"
    )]
    BehindEndOfBlock,
    /// Okuma: variables, jumps and calls.
    #[error(
        "{name} is refused: user tasks (variables, jumps, calls, named lines) are not read; write the moves out with their numbers"
    )]
    UserTask {
        /// The statement or the variable.
        name: Box<str>,
    },
    /// A language of its own.
    #[error("this control's language is not made of plain words, and is not read here")]
    OtherLanguage,
}
