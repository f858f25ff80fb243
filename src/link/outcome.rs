//! How a session ended.

use super::job::Unreadable;
use super::stream::StreamError;
use super::watch::OffPath;
use crate::wire::Firmware;
use std::fmt;

/// How a session ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// Every line answered, the machine at rest where the program ends.
    Done,
    /// The operator stopped it.
    Stopped,
    /// The operator had it reset while it may have been moving.
    Aborted,
    /// The controller refused a line.
    Refused {
        /// Line of the program, from 1; 0 for one of our own.
        line: usize,
        /// As sent.
        text: String,
        /// The N of `error:N`.
        code: u16,
        /// Whose number it is.
        firmware: Firmware,
    },
    /// An alarm.
    Alarm {
        /// The N of `ALARM:N`.
        code: u16,
        /// Oldest line of the program not answered then.
        line: Option<usize>,
        /// Whose number it is.
        firmware: Firmware,
    },
    /// The controller was not ready for a job; nothing was sent.
    NotReady(String),
    /// No answer: cable, power, wrong port.
    Silent {
        /// What was waited for.
        waiting_for: &'static str,
    },
    /// The machine is Idle, yet lines stay unanswered: a reply was lost on the way.
    LostReply {
        /// Oldest unanswered line of the program.
        line: usize,
    },
    /// The controller restarted by itself in the middle of the job.
    ControllerReset,
    /// All answered, but the machine stands elsewhere than the program ends.
    Elsewhere {
        /// Where the program ends, mm.
        expected: [f64; 3],
        /// Where the controller says it is, mm.
        reported: [f64; 3],
    },
    /// Reports place the machine beside the way of the lines it was sent.
    OffPath(OffPath),
    /// Something came back that no controller says: bytes are damaged on the cable.
    Damaged {
        /// What came.
        text: String,
    },
    /// The controller is in a state that the job did not bring about.
    StateLost {
        /// As reported.
        state: String,
    },
    /// The program changed after it was vetted, or cannot be read on.
    Unreadable(Unreadable),
    /// A line that can never be sent safely.
    Unstreamable(StreamError),
    /// The port broke.
    Broken(String),
}

impl Ending {
    /// A short stable word for machines: `done`, `stopped` or `error ...`.
    pub fn key(&self) -> String {
        match self {
            Ending::Done => "done".to_string(),
            Ending::Stopped | Ending::Aborted => "stopped".to_string(),
            Ending::Refused { line, code, .. } => format!("error:{code} at line {line}"),
            Ending::Alarm { code, .. } => format!("error alarm:{code}"),
            Ending::NotReady(_) => "error not ready".to_string(),
            Ending::Silent { .. } => "error no answer".to_string(),
            Ending::LostReply { .. } => "error reply lost".to_string(),
            Ending::ControllerReset => "error controller reset".to_string(),
            Ending::Elsewhere { .. } => "error wrong end position".to_string(),
            Ending::OffPath(_) => "error off path".to_string(),
            Ending::Damaged { .. } => "error damaged reply".to_string(),
            Ending::StateLost { .. } => "error state".to_string(),
            Ending::Unreadable(_) => "error program changed".to_string(),
            Ending::Unstreamable(_) => "error line too long".to_string(),
            Ending::Broken(_) => "error port".to_string(),
        }
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ending::Done => f.write_str("done"),
            Ending::Stopped => f.write_str("stopped by the operator"),
            Ending::Aborted => f.write_str(
                "reset by the operator in motion: steps may be lost. Home or set the zero again before starting over",
            ),
            Ending::Refused { line, text, code, firmware } => {
                match line {
                    0 => write!(f, "the controller refused `{text}` with error:{code}")?,
                    _ => write!(f, "line {line} (`{text}`): the controller refused it with error:{code}")?,
                }
                match firmware.error(*code) {
                    Some(m) => write!(f, ": {}. {}", m.what, m.advice),
                    None => f.write_str(", a number this table does not know: look it up in your firmware's documentation"),
                }
            }
            Ending::Alarm { code, line, firmware } => {
                write!(f, "ALARM:{code}")?;
                if let Some(line) = line {
                    write!(f, " while line {line} was waiting")?;
                }
                match firmware.alarm(*code) {
                    Some(m) => write!(f, ": {}. {}", m.what, m.advice),
                    None => f.write_str(
                        ", a number this table does not know: look it up in your firmware's documentation and home before going on",
                    ),
                }
            }
            Ending::NotReady(why) => f.write_str(why),
            Ending::Silent { waiting_for } => write!(
                f,
                "no answer from the controller while waiting for {waiting_for}: check cable, power, port and serial speed"
            ),
            Ending::LostReply { line } => write!(
                f,
                "the machine is idle, but line {line} was never answered: a reply was lost on the cable. Check the cable and \
                 its shielding; start again from a safe position"
            ),
            Ending::ControllerReset => f.write_str(
                "the controller restarted in the middle of the job (power dip, interference or its reset button): home or set \
                 the zero again before starting over",
            ),
            Ending::Elsewhere { expected: e, reported: r } => write!(
                f,
                "every line was answered, but the machine stands at {:.3} {:.3} {:.3} and the program ends at {:.3} {:.3} {:.3}: \
                 bytes were damaged on the way, or the work zero changed. Check the part before going on",
                r[0], r[1], r[2], e[0], e[1], e[2]
            ),
            Ending::OffPath(off) => off.fmt(f),
            Ending::Damaged { text } => write!(
                f,
                "the controller's replies are damaged ({text:?}), so nobody can tell what it received: check the cable and its \
                 shielding; start again from a safe position"
            ),
            Ending::StateLost { state } => write!(
                f,
                "the controller says {state}, which the job did not bring about: an alarm's message was lost, or somebody else uses the \
                 cable. Look at the machine, home or unlock it, then start again"
            ),
            Ending::Unreadable(e) => e.fmt(f),
            Ending::Unstreamable(e) => e.fmt(f),
            Ending::Broken(why) => f.write_str(why),
        }
    }
}

/// The result of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// Lines of the job that were sent.
    pub sent: usize,
    /// Lines of the job that were answered.
    pub acknowledged: usize,
    /// Lines of the job.
    pub total: usize,
    /// Work position at the end as the controller reports it, mm.
    pub position: Option<[f64; 3]>,
    /// False when steps may have been lost, or nobody can tell.
    pub position_kept: bool,
    /// Oldest and newest line of the program that were under way when the job was interrupted: each may have been carried out or not.
    pub maybe: Option<(usize, usize)>,
    /// Seconds of host time from the first report of motion to the end; 0 if none was seen.
    pub running_s: f64,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn endings_say_where_what_and_what_next() {
        let e = Ending::Refused {
            line: 12,
            text: "G1X1".into(),
            code: 22,
            firmware: Firmware::Grbl11,
        };
        assert_eq!(
            e.to_string(),
            "line 12 (`G1X1`): the controller refused it with error:22: no feed rate is set. Put an F word at or before the \
             first cutting move."
        );
        assert_eq!(e.key(), "error:22 at line 12");
        let e = Ending::Alarm {
            code: 2,
            line: Some(3),
            firmware: Firmware::Grbl11,
        };
        assert!(
            e.to_string()
                .starts_with("ALARM:2 while line 3 was waiting: the target lies outside")
        );
        assert!(
            Ending::Alarm {
                code: 77,
                line: None,
                firmware: Firmware::Grbl11,
            }
            .to_string()
            .contains("does not know")
        );
    }
}
