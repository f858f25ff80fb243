//! What can be wrong with the order of lines.

use std::io::ErrorKind;

/// What is wrong with the order of a program's lines: calls, jumps, loops, ends, and lines that cannot be read at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlowComplaint {
    /// The file cannot be read any further.
    #[error("the program cannot be read from here on ({kind}): check the file and its disk")]
    Unreadable {
        /// What reading answered.
        kind: ErrorKind,
    },
    /// A line longer than is kept.
    #[error(
        "the line has more than {limit} bytes: this is no program text, or its line ends are lost"
    )]
    LineLonger {
        /// Bytes of a line that are kept.
        limit: usize,
    },
    /// A NUL byte.
    #[error("a NUL byte: the file is damaged, or no plain text (UTF-16?): save it as plain text")]
    Nul,
    /// Jump to a line that is not there.
    #[error("no line of this program begins with {label}: correct the number, or add the line")]
    LabelMissing {
        /// `N50`.
        label: Box<str>,
    },
    /// Siemens: a word by itself is the call of a subprogram, if it is nothing else.
    #[error(
        "{name} is no command that is read here, and no subprogram of this file (%_N_{name}_SPF): correct it, remove it, or append the subprogram"
    )]
    NoCommand {
        /// The word.
        name: Box<str>,
    },
    /// Call of a program that is not in this file.
    #[error(
        "{label} is not in this file, and programs in other files are not read: append it to this file"
    )]
    ProgramMissing {
        /// `O1234`.
        label: Box<str>,
    },
    /// Two subprograms of one name.
    #[error(
        "{label} begins on line {first} and again on line {second}: which one is meant? rename one of them"
    )]
    ProgramTwice {
        /// `O1234`.
        label: Box<str>,
        /// Line of the first.
        first: usize,
        /// Line of the second.
        second: usize,
    },
    /// LinuxCNC: a call of a subroutine that is defined below.
    #[error(
        "{label} is defined on line {line}, below its call: this controller wants subroutines above it"
    )]
    DefinedBelow {
        /// `O100`.
        label: Box<str>,
        /// Where it is.
        line: usize,
    },
    /// LinuxCNC: M98 to a program that stands above.
    #[error(
        "{label} begins on line {line}, above its M98: this controller wants numbered programs below it"
    )]
    DefinedAbove {
        /// `O100`.
        label: Box<str>,
        /// Where it is.
        line: usize,
    },
    /// Calls inside calls.
    #[error(
        "calls inside calls, {limit} deep, are all that this controller does: does a subprogram call itself?"
    )]
    TooDeep {
        /// The controller's limit.
        limit: usize,
    },
    /// A loop proven endless.
    #[error("from here the program goes round for ever: after a whole round nothing has changed")]
    Endless,
    /// A loop that did not end in time.
    #[error("{lines} lines were read again and the program has not ended: a loop without end?")]
    TooLong {
        /// The limit.
        lines: u64,
    },
    /// A main program that does not end before the next program begins.
    #[error("the program runs on into {label}: put M30 (in a subprogram M99) before it")]
    RunsInto {
        /// `O1234`.
        label: Box<str>,
    },
    /// A loop or condition without its end.
    #[error("{opening} is never closed: {closing} is missing")]
    NotClosed {
        /// `WHILE ... DO1`, `O100 if`.
        opening: Box<str>,
        /// `END1`, `O100 endif`.
        closing: Box<str>,
    },
    /// The end of a loop or condition without its beginning.
    #[error("{closing} closes nothing: {opening} is missing, or was jumped over")]
    NotOpened {
        /// `END1`, `O100 else`.
        closing: Box<str>,
        /// `DO1`, `O100 if`.
        opening: Box<str>,
    },
    /// The text ends inside a subprogram.
    #[error("the text ends inside {label}: put {end} at its end")]
    NoReturn {
        /// `O1234`.
        label: Box<str>,
        /// `M99`, `O100 endsub`.
        end: Box<str>,
    },
    /// More on the line than its statement takes.
    #[error("{statement} stands alone on its line: move the rest of it to another line")]
    StatementAlone {
        /// `GOTO`, `O1234`.
        statement: Box<str>,
    },
    /// A keyword that is none.
    #[error("{found} is no keyword of this controller: {known}")]
    Keyword {
        /// What stands there.
        found: Box<str>,
        /// What could.
        known: &'static str,
    },
    /// Something must follow.
    #[error("{statement} needs {what}: add it")]
    Incomplete {
        /// The statement.
        statement: Box<str>,
        /// What is missing.
        what: &'static str,
    },
    /// A number out of range for a loop, label or count.
    #[error("{what} must be a whole number from {least} to {most}, here it is {value}")]
    Range {
        /// What it counts or names.
        what: &'static str,
        /// Least.
        least: u32,
        /// Most.
        most: u32,
        /// What it is.
        value: f64,
    },
    /// A macro argument without a decimal point.
    #[error(
        "{letter} is handed to a macro without a decimal point, so its scale depends on the machine's settings: write one"
    )]
    ArgumentPoint {
        /// The letter.
        letter: char,
    },
    /// A word that G65 does not hand over.
    #[error("{letter} cannot be handed to a macro: use A to F, H to K, M or Q to Z")]
    ArgumentLetter {
        /// The letter.
        letter: char,
    },
    /// The program stops itself.
    #[error(
        "here the program stops with an alarm of its own (#3000={number}): find out what it found wrong"
    )]
    Alarm {
        /// The alarm's number.
        number: f64,
    },
}
