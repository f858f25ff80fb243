//! Why a job is not taken up, and what to do about it.

use crate::gcode::InterpretError;
use crate::link::journal::Doubt;

/// Why not.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Nothing usable in the journal.
    #[error(
        "the journal does not even tell which job it is of: begin the job afresh with --discard-journal"
    )]
    Empty,
    /// A journal of another version of this program.
    #[error(
        "the journal is written in format {0}, and this program reads format {format}: resume with the version of morsemill that began the job, or \
         begin it afresh with --discard-journal", format = crate::link::journal::FORMAT
    )]
    OtherFormat(u32),
    /// The job was finished.
    #[error("the job was carried out to its end: there is nothing to resume")]
    Finished,
    /// The job broke before its first line.
    #[error(
        "nothing of the program was sent before the job broke: begin it afresh with --discard-journal"
    )]
    NothingSent,
    /// Another text.
    #[error(
        "the program is not the one that was sent ({what}): put back the file as it was, or begin afresh with --discard-journal"
    )]
    ProgramChanged {
        /// What differs.
        what: String,
    },
    /// The program does not read.
    #[error("the program does not read as it did when it was sent: line {0}")]
    Unreadable(InterpretError),
    /// Another machine.
    #[error(
        "the journal is of machine `{journal}`, and this is `{now}`: resume on the machine that began the job"
    )]
    OtherMachine {
        /// In the journal.
        journal: String,
        /// Given now.
        now: String,
    },
    /// A setting that places depend on.
    #[error(
        "${number} was {journal} when the job began and is {now} now, so the same line leads to another place: set ${number}={journal} again"
    )]
    Setting {
        /// Its number.
        number: u16,
        /// In the journal.
        journal: f64,
        /// Now.
        now: f64,
    },
    /// Not Idle.
    #[error("the controller is in state {state}: {advice}")]
    NotIdle {
        /// As it spells it.
        state: String,
        /// What to do.
        advice: &'static str,
    },
    /// It does not say where it is.
    #[error("the controller does not tell where the machine stands: ask again, or check $10")]
    NoPosition,
    /// Position or part are not to be trusted.
    #[error("{doubt}. {advice}")]
    NotTrusted {
        /// Why.
        doubt: Doubt,
        /// What to do.
        advice: &'static str,
    },
    /// It stands elsewhere, and nobody knows why.
    #[error(
        "the machine says it stands at X{:.3} Y{:.3} Z{:.3} (machine coordinates), {distance:.3} mm from any place where this job can have stopped: \
         its controller was switched off, or it was moved since. Home it (`morsemill home`); on a machine without switches set the zero on the part \
         again. If you only jogged it and it never lost power, say --trust-position", place[0], place[1], place[2]
    )]
    Elsewhere {
        /// Where it says it is, mm.
        place: [f64; 3],
        /// From the nearest place of the path, mm.
        distance: f64,
    },
    /// It stands where a controller believes to stand that was just switched on.
    #[error(
        "the machine says it stands at machine zero. The job can have stopped there, but a controller that was switched off since would say so wherever \
         the tool is: home it (`morsemill home`), or, if you know that it never lost power, say --trust-position"
    )]
    PowerOn,
    /// Work offsets differ.
    #[error(
        "{name} was X{:.3} Y{:.3} Z{:.3} when the job broke and is X{:.3} Y{:.3} Z{:.3} now: set it back, or, if you set the zero on the part \
         again because the position was lost, say --trust-position", journal[0], journal[1], journal[2], now[0], now[1], now[2]
    )]
    Offset {
        /// `G54` to `G59`, `G28`, `G30`.
        name: String,
        /// By the journal, mm.
        journal: [f64; 3],
        /// Now, mm.
        now: [f64; 3],
    },
    /// An offset is written in the zone that is not certain.
    #[error(
        "lines {first} to {last} may have been carried out, and one of them writes a stored offset: nobody can tell whether it did. Set the offsets by \
         hand and use --from-line"
    )]
    OffsetWritten {
        /// First line of the zone.
        first: usize,
        /// Last line.
        last: usize,
    },
    /// A probe decides what comes later.
    #[error(
        "line {line} probes, and what it found is not in the program: begin behind it with --from-line, with the zero set by hand"
    )]
    Probes {
        /// The line.
        line: usize,
    },
    /// No way in.
    #[error(
        "no motion to enter at before the program ends, from line {line} on: what is left needs no cutting"
    )]
    NoEntry {
        /// First line looked at.
        line: usize,
    },
    /// There is no such line.
    #[error("there is no line {line} in this program of {lines} lines")]
    NoSuchLine {
        /// Asked for.
        line: usize,
        /// There are.
        lines: usize,
    },
    /// The place of a line hangs on where the machine stood at line 1.
    #[error(
        "where line {line} begins depends on where the machine stood when the program began, and without a journal nobody knows: begin at an earlier \
         or later line, behind absolute X, Y and Z words"
    )]
    StartUnknown {
        /// The line.
        line: usize,
    },
    /// The lift does not fit the machine.
    #[error(
        "{axis} {value:.3} mm (machine coordinates) lies outside of the travel from {low:.3} to {high:.3}: give another --safe-z"
    )]
    OutsideTravel {
        /// Axis letter.
        axis: char,
        /// Where the way in would lead.
        value: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Too low to travel at.
    #[error(
        "--safe-z {given:.3} is below the highest place that the program goes to, {needed:.3} (machine coordinates): the way in could cross the part"
    )]
    SafeTooLow {
        /// Given, mm.
        given: f64,
        /// At least, mm.
        needed: f64,
    },
    /// The resumed program is not the same. A mistake of ours, caught.
    #[error(
        "the resumed program would not cut what the straight run cuts ({what}, line {line}): not sent. Please report this"
    )]
    Unproven {
        /// Line of the program.
        line: usize,
        /// What differs.
        what: String,
    },
}
