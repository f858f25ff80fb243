//! Why a program cannot be said in another dialect.

/// A line whose meaning is not in the program alone, or that steps cannot say.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TranslateError {
    /// The reader refuses the line.
    #[error("{complaint} (in \"{text}\")")]
    Unreadable {
        /// Line, column and reason.
        complaint: String,
        /// The line.
        text: String,
    },
    /// A move that begins or ends where nobody can tell.
    #[error(
        "{line}:1 this move hangs on where the tool stands before, and the program has not said that for {axes}: name X, Y and Z in work coordinates (G90) first"
    )]
    UnknownPlace {
        /// Line of the program, from 1.
        line: usize,
        /// The axes that are not known.
        axes: String,
    },
    /// A return to a place that only the machine knows.
    #[error(
        "{line}:1 this line goes to a place stored in the machine (G28, G30), which the program does not tell: write the place itself, as G53 G0 with machine coordinates"
    )]
    StoredPlace {
        /// Line of the program, from 1.
        line: usize,
    },
    /// Offsets set by the program.
    #[error(
        "{line}:1 this line sets {what}: all coordinates behind it hang on what the machine holds, so they mean nothing in another program. Remove it and set the offset by hand on the machine"
    )]
    Offset {
        /// Line of the program, from 1.
        line: usize,
        /// What it sets.
        what: &'static str,
    },
    /// A tool length that is not the tool's own.
    #[error(
        "{line}:1 the length of tool {length} is used with tool {tool}: steps know a tool and its own length only. Use H{tool}"
    )]
    ToolLength {
        /// Line of the program, from 1.
        line: usize,
        /// The length's number.
        length: u32,
        /// The tool in the spindle.
        tool: u32,
    },
    /// Something that steps cannot say.
    #[error("{line}:1 {what} cannot be translated: {advice}")]
    Unsayable {
        /// Line of the program, from 1.
        line: usize,
        /// What it is.
        what: &'static str,
        /// What to do.
        advice: &'static str,
    },
}
