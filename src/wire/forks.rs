//! Numbers that GRBL's relatives add or mean otherwise. Sources: grblHAL core, errors.h and alarms.h; FluidNC, Error.h and its
//! alarm list (Protocol). What is not here means the same as in GRBL 1.1 ([`super::meaning`]), or is not known.

use super::Firmware;
use super::meaning::{self, Meaning};

const LINE: &str = "Correct the line in the program, then start the job again.";
const SETTING: &str = "Correct the $ command and send it again.";
const MACHINE: &str =
    "Look at the machine and its wiring, clear the cause, then unlock or home it.";
const FILE: &str = "This is about the controller's own files, not about the job sent here.";
const HOME: &str = "Home the machine with $H before starting again.";

/// (code, what, advice)
type Errors = &'static [(u16, &'static str, &'static str)];
/// (code, what, advice, position kept)
type Alarms = &'static [(u16, &'static str, &'static str, bool)];

const HAL_ERRORS: Errors = &[
    (
        18,
        "a reset is under way",
        "Wait for the greeting, then start again.",
    ),
    (19, "a value must be above zero", LINE),
    (38, "the tool is not in the tool table", LINE),
    (39, "a value is out of its range", LINE),
    (
        40,
        "a tool change has not been finished",
        "Finish the tool change, then resume.",
    ),
    (41, "the spindle must turn for this command", LINE),
    (42, "this command does not work in the active plane", LINE),
    (43, "the feed is above the machine's highest", LINE),
    (
        44,
        "the spindle speed is out of range",
        "Choose a speed between $31 and $30.",
    ),
    (45, "a limit switch is held", MACHINE),
    (46, "the machine must be homed first", HOME),
    (47, "the tool is not set or not known", LINE),
    (48, "two words of the line contradict each other", LINE),
    (
        49,
        "the self test failed",
        "Switch the controller off and on; if it comes back, look at its power and firmware.",
    ),
    (
        50,
        "the emergency stop is active",
        "Release the emergency stop, reset, then home.",
    ),
    (51, "a motor driver reports a fault", MACHINE),
    (52, "the setting's value is out of range", SETTING),
    (53, "the setting is not available in this build", SETTING),
    (
        54,
        "a drilling cycle's retract level lies below its start",
        LINE,
    ),
    (55, "the homing settings contradict each other", SETTING),
    (56, "this work offset is locked against changes", LINE),
    (
        57,
        "a demarcation character stands where none belongs",
        LINE,
    ),
    (58, "an auxiliary port is not there", LINE),
    (60, "the SD card cannot be mounted", FILE),
    (61, "a file on the controller cannot be read", FILE),
    (62, "a directory on the controller cannot be opened", FILE),
    (63, "a directory on the controller is not there", FILE),
    (64, "no SD card is mounted", FILE),
    (65, "the controller's file system is not mounted", FILE),
    (66, "the controller's file system is read-only", FILE),
    (70, "Bluetooth did not start", FILE),
    (71, "an expression has an unknown operation", LINE),
    (72, "an expression divides by zero", LINE),
    (73, "an expression's argument is out of range", LINE),
    (74, "an expression's argument is not valid", LINE),
    (75, "an expression cannot be read", LINE),
    (76, "an expression has no valid result", LINE),
    (
        77,
        "the controller wants a password",
        "Log in, then start again.",
    ),
    (
        78,
        "the controller denies access",
        "Log in with more rights, then start again.",
    ),
    (
        79,
        "a critical event (emergency stop, limit, reset) is active",
        MACHINE,
    ),
    (80, "flow control works in macros only", LINE),
    (81, "flow control cannot be read", LINE),
    (82, "flow control is nested too deeply", LINE),
    (83, "flow control needs more memory than there is", LINE),
    (84, "a file on the controller cannot be opened", FILE),
    (253, "a macro raised an exception", LINE),
];

const HAL_ALARMS: Alarms = &[
    (
        10,
        "the emergency stop was pressed",
        "Release it, reset, and home with $H before starting again.",
        false,
    ),
    (11, "the machine must be homed first", HOME, false),
    (
        12,
        "a limit switch is held",
        "Move the axis off the switch, reset, and home with $H.",
        false,
    ),
    (
        13,
        "the probe was touched outside of a probing",
        "Move the tool free by hand, reset, and home before starting again.",
        false,
    ),
    (
        14,
        "the spindle did not reach its speed or reports a fault",
        MACHINE,
        false,
    ),
    (
        15,
        "homing did not find the second switch of a squared axis",
        "Check the switch, then home again.",
        false,
    ),
    (
        16,
        "the self test failed",
        "Switch the controller off and on; if it comes back, look at its power and firmware.",
        false,
    ),
    (
        17,
        "a motor driver reports a fault",
        "Look at the drivers and the mechanics, then home.",
        false,
    ),
    (
        18,
        "homing failed by its settings",
        "Check $22 to $27 and $44 to $46, then home again.",
        false,
    ),
    (
        19,
        "the spindle's Modbus link gave an exception",
        MACHINE,
        false,
    ),
    (20, "the I/O expander does not answer", MACHINE, false),
    (
        21,
        "the stored settings cannot be read",
        "Check every $ setting before moving the machine.",
        false,
    ),
    (
        22,
        "a buffer overflowed: bytes of the job were lost",
        "Check cable and flow control; start again from a safe position.",
        false,
    ),
];

const FLUID_ERRORS: Errors = &[
    (5, "this setting is switched off", SETTING),
    (
        18,
        "no homing cycle is configured",
        "Configure homing in config.yaml, or zero the machine by hand.",
    ),
    (
        19,
        "single axes must not be homed here",
        "Home all axes with $H.",
    ),
    (38, "a value is above its highest", LINE),
    (39, "the P value is too large", LINE),
    (40, "a control pin is active", MACHINE),
    (60, "the SD card cannot be mounted", FILE),
    (61, "a file on the controller cannot be read", FILE),
    (62, "a directory on the controller cannot be opened", FILE),
    (63, "a directory on the controller is not there", FILE),
    (64, "a file on the controller is empty", FILE),
    (65, "a file on the controller is not there", FILE),
    (66, "a file on the controller cannot be opened", FILE),
    (67, "the controller's file system is busy", FILE),
    (68, "a directory on the controller cannot be deleted", FILE),
    (69, "a file on the controller cannot be deleted", FILE),
    (70, "a file on the controller cannot be renamed", FILE),
    (80, "the setting's number is out of range", SETTING),
    (81, "the setting's value is not valid", SETTING),
    (82, "a file on the controller cannot be created", FILE),
    (83, "the controller's file system cannot be formatted", FILE),
    (90, "a message could not be sent", FILE),
    (100, "a setting could not be stored", SETTING),
    (
        101,
        "the state of the stored settings is not known",
        SETTING,
    ),
    (
        110,
        "the controller wants a password",
        "Log in, then start again.",
    ),
    (111, "a line ended too early", LINE),
    (112, "the file ended", FILE),
    (
        113,
        "a reset is under way",
        "Wait for the greeting, then start again.",
    ),
    (114, "there was no data", LINE),
    (
        120,
        "another interface (web page, SD card, Bluetooth) drives the machine",
        "End the other job, then start again.",
    ),
    (
        130,
        "the jog was cancelled",
        "Nothing is wrong: jog again if you want.",
    ),
    (
        150,
        "a pin of the configuration is not valid",
        "Correct config.yaml.",
    ),
    (
        151,
        "a setting of the configuration cannot be changed while running",
        "Correct config.yaml and restart.",
    ),
    (
        152,
        "the configuration is not valid",
        "Read the messages at start-up and correct config.yaml.",
    ),
    (160, "an upload failed", FILE),
    (161, "a download failed", FILE),
    (162, "the setting is read-only", SETTING),
    (170, "an expression divides by zero", LINE),
    (171, "an expression's argument is not valid", LINE),
    (172, "an expression has no valid result", LINE),
    (173, "an expression has an unknown operation", LINE),
    (174, "an expression's argument is out of range", LINE),
    (175, "an expression cannot be read", LINE),
    (176, "flow control cannot be read", LINE),
    (177, "flow control works in macros only", LINE),
    (178, "flow control needs more memory than there is", LINE),
    (179, "flow control is nested too deeply", LINE),
];

const FLUID_ALARMS: Alarms = &[
    (10, "the spindle cannot be controlled", MACHINE, false),
    (
        11,
        "a control or limit pin was active at start-up",
        MACHINE,
        false,
    ),
    (
        12,
        "a limit switch is held and nobody can tell which end it is",
        "Move the axis off the switch by hand, then home.",
        false,
    ),
    (13, "a hard stop was requested", MACHINE, false),
    (14, "the machine is not homed", HOME, false),
    (15, "the controller has just started", HOME, false),
    (16, "the I/O expander was reset", MACHINE, false),
    (
        17,
        "a G-code error stopped the job, as configured",
        "Correct the line in the program; home or check the zero before starting again.",
        false,
    ),
    (
        18,
        "a limit switch was hit while probing",
        "Move the axis off the switch by hand, then home.",
        false,
    ),
];

/// The meaning of `error:code` on this firmware, if it has one.
pub(super) fn error(firmware: Firmware, code: u16) -> Option<Meaning> {
    let own = match firmware {
        Firmware::GrblHal => HAL_ERRORS,
        Firmware::FluidNc => FLUID_ERRORS,
        Firmware::Grbl11 | Firmware::Unknown => &[],
    };
    let found = own.iter().find(|e| e.0 == code);
    found
        .map(|&(code, what, advice)| Meaning {
            code,
            what,
            advice,
            position_kept: true,
        })
        .or_else(|| meaning::error_meaning(code))
}

/// The meaning of `ALARM:code` on this firmware, if it has one. Above 9 the firmwares do not agree, so an unknown one's are not known.
pub(super) fn alarm(firmware: Firmware, code: u16) -> Option<Meaning> {
    let own = match firmware {
        Firmware::GrblHal => HAL_ALARMS,
        Firmware::FluidNc => FLUID_ALARMS,
        Firmware::Grbl11 => return meaning::alarm_meaning(code),
        Firmware::Unknown => &[],
    };
    let found = own.iter().find(|e| e.0 == code);
    found
        .map(|&(code, what, advice, position_kept)| Meaning {
            code,
            what,
            advice,
            position_kept,
        })
        .or_else(|| meaning::alarm_meaning(code).filter(|m| m.code < 10))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_firmwares_mean_different_things_by_one_number() {
        let what = |f: Firmware, code| f.alarm(code).map(|m| m.what);
        assert!(what(Firmware::Grbl11, 10).unwrap().contains("two switches"));
        assert!(
            what(Firmware::GrblHal, 10)
                .unwrap()
                .contains("emergency stop")
        );
        assert!(what(Firmware::FluidNc, 10).unwrap().contains("spindle"));
        assert_eq!(what(Firmware::Unknown, 10), None);
        for firmware in [
            Firmware::Grbl11,
            Firmware::GrblHal,
            Firmware::FluidNc,
            Firmware::Unknown,
        ] {
            assert!(what(firmware, 2).unwrap().contains("soft limit"));
            assert!(!firmware.alarm(1).unwrap().position_kept);
            assert!(firmware.error(22).unwrap().what.contains("feed rate"));
            assert_eq!(firmware.error(999), None);
        }
        assert!(Firmware::GrblHal.error(39).unwrap().what.contains("range"));
        assert!(
            Firmware::FluidNc
                .error(39)
                .unwrap()
                .what
                .contains("P value")
        );
        assert_eq!(Firmware::Grbl11.error(39), None);
        assert_eq!(Firmware::Unknown.error(60), None);
    }

    #[test]
    fn tables_are_in_order_and_say_what_to_do() {
        for table in [HAL_ERRORS, FLUID_ERRORS] {
            assert!(table.windows(2).all(|w| w[0].0 < w[1].0));
            assert!(table.iter().all(|e| e.2.ends_with('.') && !e.1.is_empty()));
        }
        for table in [HAL_ALARMS, FLUID_ALARMS] {
            assert!(table.windows(2).all(|w| w[0].0 < w[1].0));
            assert!(table.iter().all(|e| e.2.ends_with('.') && !e.1.is_empty()));
        }
    }
}
