//! What a journal can say. Lengths mm, machine coordinates; times s since the job began.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

/// The version of the format that this program writes, and the only one it reads.
pub const FORMAT: u32 = 1;

/// Offsets and stored places, as `$#` tells them: X, Y, Z in mm, machine coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Offsets {
    /// Origins of G54 to G59.
    pub g5x: [[f64; 3]; 6],
    /// The place of G28.
    pub g28: [f64; 3],
    /// The place of G30.
    pub g30: [f64; 3],
    /// The G92 offset; a reset clears it.
    pub g92: [f64; 3],
    /// Tool length offset (G43.1); a reset clears it.
    pub tlo: f64,
}

/// What the machine remembered when line 1 of the program was carried out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Machine position.
    pub position: [f64; 3],
    /// Offsets.
    pub offsets: Offsets,
    /// `$G`, between its brackets: `GC:G0 G54 G17 ...`, or empty for what a reset leaves.
    pub modes: String,
}

/// A job that takes up another one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resumed {
    /// The first line of the program that is sent again; all before it were cut by the earlier job.
    pub entry: usize,
    /// The last line that the earlier job may have begun.
    pub maybe_to: usize,
}

/// The first record: which job, on which machine, from which state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// [`FORMAT`].
    pub format: u32,
    /// Path of the program as it was given.
    pub program: String,
    /// SHA-256 of its bytes, hexadecimal ([`fingerprint`]).
    pub sha256: String,
    /// Lines of its text.
    pub lines: usize,
    /// Name of the machine.
    pub machine: String,
    /// What the controller says it is.
    pub firmware: String,
    /// Name of the dialect it reads ([`crate::gcode::Dialect::name`]).
    pub dialect: String,
    /// `$$`: number and value.
    pub settings: Vec<(u16, f64)>,
    /// What the machine remembered at line 1. A resumed job hands on that of the first, as [`crate::link::resume::Plan::start`] has it.
    pub start: Start,
    /// Receive buffer of the controller, bytes.
    pub rx_bytes: usize,
    /// Blocks of look-ahead.
    pub planner_blocks: usize,
    /// Bytes per second that the link carries at most.
    pub bytes_per_s: f64,
    /// Something that is different after each start of this computer, where it can be had.
    pub boot: Option<String>,
    /// Lines that begin with `/` were left out; otherwise they were sent, as GRBL takes them.
    pub skips_slashed: bool,
    /// The job takes up an earlier one.
    pub resumed: Option<Resumed>,
}

/// A finished tool change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolChange {
    /// Line of the program.
    pub line: usize,
    /// Tool number, if the program names one.
    pub tool: Option<u32>,
    /// The offsets behind it, where the new tool was measured; `None` when they were left as they were.
    pub offsets: Option<Offsets>,
}

/// One thing that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Record {
    /// The job begins. Always the first, never again.
    Begin(Box<Begin>),
    /// Lines up to this one may be sent from now on.
    Allow {
        /// Line of the program.
        line: usize,
    },
    /// Lines up to this one were sent.
    Sent {
        /// Line of the program.
        line: usize,
    },
    /// Lines up to this one were answered with `ok`.
    Acknowledged {
        /// Line of the program.
        line: usize,
    },
    /// A status report.
    Report {
        /// State as the controller spells it.
        state: String,
        /// Machine position, mm.
        machine: [f64; 3],
        /// Work coordinate offset (G5x + G92 + TLO), mm.
        work_offset: Option<[f64; 3]>,
    },
    /// Feed hold or door.
    Hold {
        /// Who or what wanted it.
        why: String,
    },
    /// Going on behind a hold.
    Resume,
    /// Overrides in percent.
    Override {
        /// Feed.
        feed: u16,
        /// Rapids.
        rapid: u16,
        /// Spindle.
        spindle: u16,
    },
    /// A tool change is over.
    ToolChange(ToolChange),
    /// `ALARM:N`.
    Alarm {
        /// N.
        code: u16,
    },
    /// `error:N`: the line was dropped.
    Error {
        /// Line of the program.
        line: usize,
        /// N.
        code: u16,
    },
    /// The controller greeted unasked: it was reset.
    Reset,
    /// The stop procedure has begun.
    Stopping {
        /// Why.
        why: String,
    },
    /// The job is over, well or badly; nothing more is written.
    End {
        /// How, for people.
        how: String,
        /// Every line was carried out.
        done: bool,
        /// False when steps may have been lost or nobody can tell.
        position_kept: bool,
        /// The machine was seen at rest; otherwise it ran on until it had done all it was sent.
        at_rest: bool,
        /// False when bytes were damaged on the cable: lines may have been carried out as others, and answers may be made up. (Journals
        /// from before this was told have none.)
        #[serde(default = "sound")]
        cable_sound: bool,
    },
}

fn sound() -> bool {
    true
}

impl Record {
    /// True when every figure is a number that can be written down.
    pub fn is_sound(&self) -> bool {
        let all = |v: &[f64]| v.iter().all(|x| x.is_finite());
        let offsets = |o: &Offsets| {
            o.g5x.iter().all(|v| all(v))
                && all(&o.g28)
                && all(&o.g30)
                && all(&o.g92)
                && all(&[o.tlo])
        };
        match self {
            Record::Begin(b) => {
                b.settings.iter().all(|(_, v)| v.is_finite())
                    && all(&b.start.position)
                    && offsets(&b.start.offsets)
                    && all(&[b.bytes_per_s])
            }
            Record::Report {
                machine,
                work_offset,
                ..
            } => all(machine) && work_offset.as_ref().is_none_or(|o| all(o)),
            Record::ToolChange(change) => change.offsets.as_ref().is_none_or(offsets),
            _ => true,
        }
    }
}

/// A record and its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stamped {
    /// Seconds since the job began.
    pub t: f64,
    /// What happened.
    #[serde(flatten)]
    pub record: Record,
}

/// SHA-256 of a program's bytes, hexadecimal.
pub fn fingerprint(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}
