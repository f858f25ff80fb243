//! Error and alarm numbers in plain words, and what to do next. GRBL 1.1h's tables; forks add numbers and sometimes other
//! meanings, so an unknown number is said to be unknown rather than guessed.

/// What a number means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// The number behind `error:` or `ALARM:`.
    pub code: u16,
    /// What happened.
    pub what: &'static str,
    /// What to do next.
    pub advice: &'static str,
    /// The controller still knows where it is (always true for errors).
    pub position_kept: bool,
}

const PROGRAM: &str =
    "Correct the line in the program (or choose a post for GRBL), then start the job again.";
const SETTINGS: &str = "Correct the $ command and send it again.";

/// (code, what, advice)
const ERRORS: [(u16, &str, &str); 36] = [
    (1, "a word must begin with a letter", PROGRAM),
    (2, "a number is missing or not readable", PROGRAM),
    (3, "the $ command is not known", SETTINGS),
    (4, "a value is negative that must not be", PROGRAM),
    (
        5,
        "homing is switched off ($22=0)",
        "Set $22=1 if the machine has limit switches, or zero it by hand.",
    ),
    (
        6,
        "the step pulse must be at least 3 microseconds",
        SETTINGS,
    ),
    (
        7,
        "the stored settings could not be read; defaults are in force",
        "Check every $ setting before moving the machine.",
    ),
    (
        8,
        "this $ command is accepted only when the machine is Idle",
        "Wait until the machine is Idle.",
    ),
    (
        9,
        "G-code is locked during an alarm or a jog",
        "Clear the alarm first: home with $H, or unlock with $X if the position is known.",
    ),
    (10, "soft limits need homing", "Set $22=1 before $20=1."),
    (
        11,
        "the line is longer than the controller can hold",
        "Shorten the line or remove its comment.",
    ),
    (
        12,
        "the step rate would be too high",
        "Lower $110-$112 or the steps per mm.",
    ),
    (13, "the safety door is open", "Close the door and resume."),
    (
        14,
        "the startup line or build text is too long to store",
        SETTINGS,
    ),
    (
        15,
        "the jog would leave the travel of the machine",
        "Jog less far.",
    ),
    (
        16,
        "the jog command is not valid",
        "A jog is $J= with axis words and a feed, nothing else.",
    ),
    (
        17,
        "laser mode needs a variable-speed spindle output",
        "Set $32=0.",
    ),
    (
        20,
        "a command or word this controller does not know",
        PROGRAM,
    ),
    (21, "two commands of one modal group in one line", PROGRAM),
    (
        22,
        "no feed rate is set",
        "Put an F word at or before the first cutting move.",
    ),
    (23, "a G or M number must be whole here", PROGRAM),
    (
        24,
        "two commands in one line both need the axis words",
        PROGRAM,
    ),
    (25, "a word is repeated in the line", PROGRAM),
    (26, "axis words are missing", PROGRAM),
    (27, "the line number is out of range", PROGRAM),
    (28, "a P or L word is missing", PROGRAM),
    (
        29,
        "that work coordinate system does not exist (G54 to G59 do)",
        PROGRAM,
    ),
    (30, "G53 needs G0 or G1", PROGRAM),
    (31, "axis words without a motion (G80 is active)", PROGRAM),
    (32, "the arc has no axis word in its plane", PROGRAM),
    (
        33,
        "the target is not valid (an arc whose ends do not lie on one circle)",
        PROGRAM,
    ),
    (
        34,
        "the arc's radius is too small to reach its end",
        PROGRAM,
    ),
    (35, "the arc has no centre word in its plane", PROGRAM),
    (36, "the line has words nobody uses", PROGRAM),
    (37, "G43.1 takes exactly a Z word", PROGRAM),
    (38, "the tool number is above 255", PROGRAM),
];

/// (code, what, advice, position kept)
const ALARMS: [(u16, &str, &str, bool); 10] = [
    (
        1,
        "a limit switch was hit; the axes stopped without braking",
        "Move the axis off the switch by hand, reset, home with $H, and check the work zero before starting again.",
        false,
    ),
    (
        2,
        "the target lies outside the machine's travel (soft limit)",
        "The position is kept. Check the work zero and the size of the job, unlock with $X, then start again.",
        true,
    ),
    (
        3,
        "the controller was reset while moving; steps may be lost",
        "Home with $H (or set the zero again by hand) before starting again.",
        false,
    ),
    (
        4,
        "the probe was already touching when probing began",
        "Check the probe's wiring, unlock with $X, retract and probe again.",
        true,
    ),
    (
        5,
        "the probe touched nothing on its way",
        "Unlock with $X, check the probe's wiring and distance, probe again.",
        true,
    ),
    (
        6,
        "homing was cut short by a reset",
        "Home again with $H.",
        false,
    ),
    (
        7,
        "homing was cut short by the safety door",
        "Close the door and home again with $H.",
        false,
    ),
    (
        8,
        "homing could not pull off the switch",
        "Check the switches' wiring and the pull-off distance $27, then home again.",
        false,
    ),
    (
        9,
        "homing found no switch",
        "Check the switches' wiring, $23 and the travels $130-$132, then home again.",
        false,
    ),
    (
        10,
        "homing found only one of an axis' two switches",
        "Check the second switch, then home again.",
        false,
    ),
];

/// The meaning of `error:code`, if GRBL 1.1h has one.
pub fn error_meaning(code: u16) -> Option<Meaning> {
    ERRORS
        .iter()
        .find(|e| e.0 == code)
        .map(|&(code, what, advice)| Meaning {
            code,
            what,
            advice,
            position_kept: true,
        })
}

/// The meaning of `ALARM:code`, if GRBL 1.1h has one.
pub fn alarm_meaning(code: u16) -> Option<Meaning> {
    ALARMS
        .iter()
        .find(|e| e.0 == code)
        .map(|&(code, what, advice, position_kept)| Meaning {
            code,
            what,
            advice,
            position_kept,
        })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_number_of_the_firmware_has_words() {
        for code in (1..=17).chain(20..=38) {
            let m = error_meaning(code).unwrap();
            assert_eq!(m.code, code);
            assert!(!m.what.is_empty() && m.advice.ends_with('.'));
        }
        for code in 1..=10 {
            assert!(alarm_meaning(code).unwrap().advice.ends_with('.'));
        }
        assert_eq!(error_meaning(18), None);
        assert_eq!(error_meaning(0), None);
        assert_eq!(alarm_meaning(11), None);
    }

    #[test]
    fn lost_positions_are_said_to_be_lost() {
        for (code, kept) in [
            (1, false),
            (2, true),
            (3, false),
            (4, true),
            (5, true),
            (6, false),
            (9, false),
        ] {
            assert_eq!(alarm_meaning(code).unwrap().position_kept, kept);
        }
    }
}
