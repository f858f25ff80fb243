//! News of a running session, for people, for scripts and for the journal. Positions mm, feeds mm/min.

use super::introduction::Known;
use crate::wire::{Buffer, Overrides, Realtime, State};
use std::fmt;
use std::ops::Range;

/// News. `Connected` comes first, then notes, then `Started`, then any mix of the others.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// The controller has introduced itself (told also when the session was given what an introduction found).
    Connected(Box<Known>),
    /// Something to tell the operator; the job goes on.
    Note(String),
    /// The first line goes out.
    Started {
        /// Lines of the job.
        total: usize,
    },
    /// The first bytes of these lines were handed to the port: from here on they may be executed.
    Sent(Span),
    /// These lines were answered by `ok`: read and queued.
    Acknowledged(Span),
    /// A line was answered by `error:N`: dropped whole. Several may follow each other; the first one stops the job.
    Refused {
        /// Index among the job's lines, from 0; `None` for a line of the session's own.
        index: Option<usize>,
        /// Line of the program, from 1; 0 for a line of the session's own.
        source: usize,
        /// As sent.
        text: String,
        /// The N of `error:N`.
        code: u16,
    },
    /// A status report came in.
    Report(Box<Report>),
    /// An override or coolant byte did what it should (`Ov:` or `A:` changed), or its time was up without a change.
    Adjusted {
        /// What was sent.
        what: Realtime,
        /// The reports show it.
        confirmed: bool,
    },
    /// The program waits for the operator: resume when ready.
    Prompt(Prompt),
    /// A button, the door or noise holds the machine: resume when ready.
    Paused(String),
    /// The machine goes on after a hold, a door or a prompt.
    Resumed,
    /// Nothing was answered for a while, and why; `None` once lines are answered again.
    Stall(Option<Stall>),
    /// `ALARM:N`.
    Alarm {
        /// N.
        code: u16,
    },
    /// The stop procedure has begun, and why.
    Stopping(String),
    /// The computer's clock jumped, or the computer slept: seconds of wall time less seconds of running time.
    ClockJump {
        /// Above zero: forward.
        by_s: f64,
    },
    /// The port broke. The controller goes on with what it holds: these lines of the program may still be carried out.
    Unplugged {
        /// Oldest and newest line of the program that may be, if any.
        source: Option<(usize, usize)>,
    },
}

/// Lines of the job: their indices, from 0, and the program's line (from 1) of the last of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    /// Indices among the job's lines.
    pub lines: Range<usize>,
    /// Line of the program of the last one.
    pub source: usize,
}

/// What a status report told, and how far the job is.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Lines of the job whose bytes began to go out.
    pub sent: usize,
    /// Lines of the job answered.
    pub acknowledged: usize,
    /// Lines of the job.
    pub total: usize,
    /// Line of the program of the oldest unanswered line, else of the last one answered.
    pub source: usize,
    /// State of the machine.
    pub state: State,
    /// Work position, mm, once it is known.
    pub position: Option<[f64; 3]>,
    /// Machine position, mm, once it is known.
    pub machine_position: Option<[f64; 3]>,
    /// Speed along the path, mm/min.
    pub feed: Option<f64>,
    /// Spindle, rpm.
    pub speed: Option<f64>,
    /// Overrides last reported, percent.
    pub overrides: Option<Overrides>,
    /// What is switched on, as last reported: letters of `SCFM`.
    pub accessories: String,
    /// Active pins.
    pub pins: String,
    /// Free buffers, if the controller reports them.
    pub buffer: Option<Buffer>,
    /// Bytes of unanswered lines: what the controller's receive buffer holds at most.
    pub in_flight: usize,
}

/// What the program wants of the operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prompt {
    /// Line of the program, from 1.
    pub source: usize,
    /// What stopped.
    pub kind: PromptKind,
    /// The comment beside it, or on the line before.
    pub text: Option<String>,
}

/// What kind of stop a prompt is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PromptKind {
    /// M0, or M1 with optional stops honoured: the controller holds and reads no lines.
    Pause,
    /// M6, taken out of the program: spindle off, everything answered, the machine Idle. The controller takes other commands
    /// meanwhile (jog, probe, set zero); the session restores the program's modes on resume.
    ToolChange {
        /// The T word.
        tool: u32,
    },
}

impl fmt::Display for Prompt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            PromptKind::Pause => write!(f, "the program pauses at line {}", self.source)?,
            PromptKind::ToolChange { tool } => {
                write!(f, "line {}: change to tool {tool}", self.source)?;
            }
        }
        match &self.text {
            Some(text) => write!(f, " ({text}): resume when ready"),
            None => f.write_str(": resume when ready"),
        }
    }
}

/// Why nothing is answered. Lines are lines of the program, from 1 (0: one of the session's own).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stall {
    /// Feed hold.
    Hold,
    /// Safety door.
    Door,
    /// M0 or a tool change waits for the operator.
    Prompt,
    /// The planner is full: the line is read once the motion before it has gone on. Slow feeds and big arcs take minutes.
    PlannerFull {
        /// Oldest unanswered line.
        line: usize,
    },
    /// A command that waits for standstill (dwell, spindle, probe, homing, the end).
    Waiting {
        /// Oldest unanswered line.
        line: usize,
    },
    /// The journal has not allowed more lines yet.
    Permission,
    /// The machine says Run, but neither stands nor reads: position and buffers have not changed for long.
    Stuck {
        /// Oldest unanswered line.
        line: usize,
    },
    /// Idle with an unanswered line: a reply was lost. The session stops.
    LostAcknowledgement {
        /// Oldest unanswered line.
        line: usize,
    },
    /// The controller restarted. The session stops.
    ControllerReset,
    /// No byte comes back. The session stops.
    LinkDead,
}

impl fmt::Display for Stall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stall::Hold => f.write_str("waiting: the machine is on hold"),
            Stall::Door => f.write_str("waiting: the safety door is open"),
            Stall::Prompt => f.write_str("waiting for the operator"),
            Stall::PlannerFull { line } => {
                write!(
                    f,
                    "line {line} waits for the motion before it: the planner is full"
                )
            }
            Stall::Waiting { line } => {
                write!(f, "line {line} waits for standstill or for its time")
            }
            Stall::Permission => f.write_str("waiting for the journal to reach the disk"),
            Stall::Stuck { line } => write!(
                f,
                "the controller says it runs, but nothing moves and line {line} is not answered: look at the machine, hold or stop"
            ),
            Stall::LostAcknowledgement { line } => {
                write!(
                    f,
                    "line {line} was never answered: a reply was lost on the cable"
                )
            }
            Stall::ControllerReset => f.write_str("the controller restarted"),
            Stall::LinkDead => f.write_str("nothing comes back from the controller"),
        }
    }
}
