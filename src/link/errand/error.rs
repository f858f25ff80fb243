//! Why an errand ended without its result: what happened, and what to do next.

use crate::link::introduction::Unknown;
use crate::wire::{Meaning, State, alarm_meaning, error_meaning};

/// Why an errand failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ErrandError {
    /// The controller did not introduce itself.
    #[error("{0}")]
    Unknown(Unknown),
    /// It is locked.
    #[error(
        "the controller is locked by an alarm: home it (`morsemill home`), or unlock it (`morsemill unlock`) if you know that its position is right"
    )]
    Locked,
    /// It is in no state for this.
    #[error("the controller says {}, and {doing} needs it Idle: wait, or resume or reset it", .state.text())]
    NotIdle {
        /// What was wanted.
        doing: &'static str,
        /// Its state.
        state: State,
    },
    /// A line was refused.
    #[error("the controller refused `{text}` with error:{code}{}", error_words(*.code))]
    Refused {
        /// As sent.
        text: String,
        /// N.
        code: u16,
    },
    /// An alarm ended it.
    #[error("ALARM:{code} during {doing}{}", alarm_words(*.code, .more))]
    Alarm {
        /// N.
        code: u16,
        /// What was under way.
        doing: String,
        /// More about it in this errand.
        more: &'static str,
    },
    /// An unasked greeting.
    #[error(
        "the controller restarted in the middle of it (power dip, interference or its reset button): home it or set the zero again before going on"
    )]
    ControllerReset,
    /// No answer.
    #[error(
        "no answer from the controller to `{text}`: look at the machine, then check cable, power and port{}", if *.moving { "; it may still be moving" } else { "" }
    )]
    Silent {
        /// The line that waits.
        text: String,
        /// Motion may be under way.
        moving: bool,
    },
    /// Idle, but the answer never came.
    #[error(
        "the machine is idle, but `{0}` was never answered: a reply was lost on the cable. Check the cable and its shielding"
    )]
    LostReply(String),
    /// The operator stopped it.
    #[error("stopped by the operator{}", if *.position_kept { ": the machine is at rest, its position is kept" } else { ": the position is lost, home it before going on" })]
    Cancelled {
        /// False when a reset met motion.
        position_kept: bool,
    },
    /// The port broke.
    #[error("{why}{}", if *.moving { ". The machine finishes the move it has received: stop it at the machine if it must not" } else { "" })]
    Broken {
        /// The port's words.
        why: String,
        /// Motion may be under way.
        moving: bool,
    },
    /// The task's own reason, before or after something was sent.
    #[error("{0}")]
    NotPossible(String),
    /// What was written does not read back.
    #[error(
        "{what} reads back as {found} instead of {wanted}: bytes were damaged on the way, or the memory is worn. Nothing may be cut until it is right"
    )]
    ReadBack {
        /// What was written.
        what: String,
        /// Written.
        wanted: String,
        /// Read.
        found: String,
    },
}

fn error_words(code: u16) -> String {
    match error_meaning(code) {
        Some(Meaning { what, advice, .. }) => format!(": {what}. {advice}"),
        None => ", a number this table does not know: look it up in your firmware's documentation"
            .to_string(),
    }
}

fn alarm_words(code: u16, more: &str) -> String {
    let words = match alarm_meaning(code) {
        Some(Meaning { what, advice, .. }) => format!(": {what}. {advice}"),
        None => ", a number this table does not know: look it up in your firmware's documentation and home before going on".to_string(),
    };
    if more.is_empty() {
        words
    } else {
        format!("{words} {more}")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn texts_say_what_happened_and_what_to_do() {
        let e = ErrandError::Refused {
            text: "$H".into(),
            code: 5,
        };
        assert_eq!(
            e.to_string(),
            "the controller refused `$H` with error:5: homing is switched off ($22=0). Set $22=1 if the machine has limit switches, or \
             zero it by hand."
        );
        let e = ErrandError::Alarm {
            code: 99,
            doing: "homing".into(),
            more: "",
        };
        assert!(
            e.to_string()
                .starts_with("ALARM:99 during homing, a number this table does not know")
        );
        let e = ErrandError::Cancelled {
            position_kept: true,
        };
        assert_eq!(
            e.to_string(),
            "stopped by the operator: the machine is at rest, its position is kept"
        );
        assert!(
            ErrandError::Broken {
                why: "gone".into(),
                moving: true
            }
            .to_string()
            .contains("stop it at the machine")
        );
        assert!(ErrandError::Locked.to_string().contains("morsemill unlock"));
    }
}
