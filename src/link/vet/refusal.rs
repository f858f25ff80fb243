//! Why a program cannot be streamed, and what the operator should know of one that can.

use crate::gcode::Complaint;
use crate::wire::error_number;

/// Why a program cannot be streamed, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column} {why}")]
pub struct JobError {
    /// Line of the program, from 1; 0 for a line of the entry.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub why: Refusal,
}

/// What a job must not contain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The interpreter's complaint.
    #[error("{why} (the controller would answer error:{})", error_number(.why))]
    Word {
        /// What is wrong.
        why: Complaint,
    },
    /// M6 where it was not wanted.
    #[error(
        "a tool change: cut the program at M6 and send one part per tool, or send it with tool changes as stops"
    )]
    ToolChange,
    /// M6 with company.
    #[error(
        "M6 shares its line with other words: put it on a line of its own, with at most N and T"
    )]
    ToolChangeNotAlone,
    /// G10, G28.1, G30.1.
    #[error(
        "{0} writes the controller's memory, which loses bytes of a running stream: send it by itself before the job, or allow such \
         lines to be sent alone"
    )]
    WritesMemory(&'static str),
    /// A `$` line.
    #[error("a $ command does not belong into a job: send it by itself before the job")]
    Dollar,
    /// A line that begins with `/`.
    #[error(
        "GRBL ignores block delete and would run this line: remove the line or its slash, or say whether such lines are to be skipped \
         or kept"
    )]
    BlockDelete,
    /// A slash inside of a line.
    #[error("GRBL drops this slash and would run the line without it: remove it")]
    Slash,
    /// `?`, `!`, `~` or a character outside of ASCII.
    #[error(
        "{0:?} would act at once as a command to the machine wherever it stands in a line: remove it (in a comment it does no harm)"
    )]
    Realtime(char),
    /// Longer than the receive buffer.
    #[error(
        "the line has {bytes} bytes, but the controller's receive buffer takes {room}: shorten it"
    )]
    LongerThanBuffer {
        /// With the line end.
        bytes: usize,
        /// That fit.
        room: usize,
    },
    /// Longer than a reader keeps.
    #[error("the line is longer than a mebibyte: this is no program")]
    Endless,
    /// Outside of the travel.
    #[error(
        "{axis} would go to {at:.3} in machine coordinates, outside of {low:.3} to {high:.3}{}: move the work zero or the program",
        if *soft { " (the controller would answer ALARM:2)" } else { "" }
    )]
    Outside {
        /// `X`, `Y` or `Z`.
        axis: char,
        /// Where to, mm.
        at: f64,
        /// Lowest, mm.
        low: f64,
        /// Highest, mm.
        high: f64,
        /// The controller's own soft limits are on.
        soft: bool,
    },
    /// Larger than the travel.
    #[error(
        "with this line the program takes {reach:.3} mm along {axis}, but the machine has {travel:.3} ({}): make the part smaller, or \
         turn it",
        if *machine_file { "by the machine file" } else { "$130 to $132" }
    )]
    TooLarge {
        /// `X`, `Y` or `Z`.
        axis: char,
        /// From end to end, mm.
        reach: f64,
        /// There is, mm.
        travel: f64,
        /// Told by the machine file rather than the controller.
        machine_file: bool,
    },
    /// An arc by R whose ends lie above each other.
    #[error(
        "an arc by R that ends above its start has no centre (the firmware computes nonsense): give the centre by I J K"
    )]
    ArcUpright,
    /// Nothing to send.
    #[error("the program has no line to send")]
    Empty,
    /// It cannot be read.
    #[error("the program cannot be read: {0}")]
    Unreadable(String),
}

/// What the operator should know before the first byte.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// Line of the program, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What.
    pub what: Caution,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{} {}", self.line, self.column, self.what)
    }
}

/// Kinds of warnings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Caution {
    /// A mode the program relies on and never sets.
    #[error("the program moves without having set {words}: {default} is set for it before the job")]
    ModeNotSet {
        /// The choice, as `G20 or G21 (units)`.
        words: &'static str,
        /// What is set.
        default: &'static str,
    },
    /// Lines behind M2 or M30.
    #[error("the program goes on behind its end (M2 or M30), and the controller will run that too")]
    BehindTheEnd,
    /// A cut with the spindle off after a tool change.
    #[error(
        "after the tool change before it, this line cuts with the spindle off: put M3 S... before it"
    )]
    SpindleOffAfterChange,
    /// A block-delete line was left out.
    #[error("lines that begin with / are left out")]
    Skipped,
}
