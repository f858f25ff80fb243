//! One line of a job, with all that its sending depends on.

use crate::link::progress::Prompt;

/// One line as it will be sent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobLine {
    /// Its characters, upper case, without comments, blanks and line end.
    pub text: String,
    /// Line of the program, from 1; 0 for a line of the session's own.
    pub source: usize,
    /// What its answer waits for.
    pub standstill: Standstill,
    /// What it costs if it is lost.
    pub weight: Weight,
    /// It writes the controller's memory, which loses bytes that arrive meanwhile: nothing else may be under way.
    pub writes_memory: bool,
    /// The machine waits for the operator here.
    pub prompt: Option<Prompt>,
}

/// Whether a line is answered at once or only when the motion before it has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Standstill {
    /// Answered when it has been read and queued.
    #[default]
    No,
    /// Answered after standstill and so many seconds more, in which the controller may already say Idle (a dwell). Probing and
    /// homing, whose time nobody knows, count as motion.
    Yes {
        /// Seconds.
        dwell: f64,
    },
}

/// What a line does to the lines behind it if it is refused: the controller drops it whole and runs on with the old modes and
/// place until the host can stop it. See [`crate::link::stream`] for the rule that follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Weight {
    /// A rapid, a plunge or retract, a probe, or a change of spindle or coolant.
    pub dangerous: bool,
    /// It changes what coordinates or feeds mean: plane, distance, units, feed mode, work offset, G92, tool length.
    pub changes_frame: bool,
    /// It changes the modal motion (G0, G1, G2, G3, G80).
    pub changes_motion: bool,
    /// It has a motion word of its own, or no axis words: a lost change of the modal motion does it no harm.
    pub restates_motion: bool,
}

impl JobLine {
    /// A line that the session adds, harmless in itself.
    pub fn own(text: &str) -> JobLine {
        JobLine {
            text: text.to_string(),
            weight: Weight {
                restates_motion: true,
                ..Weight::default()
            },
            ..JobLine::default()
        }
    }

    /// The line that is answered only when all motion has ended.
    pub fn settle() -> JobLine {
        JobLine {
            standstill: Standstill::Yes { dwell: 0.0 },
            ..JobLine::own("G4P0")
        }
    }

    /// Bytes it takes in the controller's receive buffer, line end included.
    pub fn bytes(&self) -> usize {
        self.text.len() + 1
    }
}
