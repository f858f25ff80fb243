//! Errors and alarms that the firmware as shipped cannot raise, and other builds can.
//!
//! | code | build |
//! |---|---|
//! | error 12 | a highest step rate (`MAX_STEP_RATE_HZ`) |
//! | error 13 | a pin for the safety door |
//! | error 14 | lines longer than the places that keep them |
//! | error 17 | no speed control of the spindle |
//! | alarm 10 | two motors on Y, each with a switch |
#![allow(clippy::unwrap_used)]

use morsemill::controller::{Build, Controller, Memory, Options, Pins, Quirks, Switches};

fn built(options: Options, memory: Memory) -> Controller {
    let build = Build {
        options,
        ..Build::default()
    };
    let mut c = Controller::with_build(memory, build);
    c.output();
    c
}

fn after(c: &mut Controller, line: &str, seconds: f64) -> String {
    c.feed(line.as_bytes());
    c.advance(seconds);
    String::from_utf8(c.output()).unwrap()
}

#[test]
fn a_step_rate_that_the_build_cannot_make_is_error_12() {
    let options = Options {
        most_steps_per_second: Some(30_000),
        ..Options::default()
    };
    for (fits, too_fast) in [("$100=3000", "$100=4000"), ("$111=7000", "$111=7300")] {
        let mut c = built(options, Memory::default());
        assert_eq!(after(&mut c, &format!("{fits}\n"), 0.1), "ok\r\n");
        assert_eq!(after(&mut c, &format!("{too_fast}\n"), 0.1), "error:12\r\n");
        // What was refused is not kept.
        assert!(after(&mut c, "$$\n", 0.1).contains(&format!("{fits}.000\r\n")));
    }
}

#[test]
fn an_open_door_is_error_13() {
    let mut memory = Memory::default();
    memory.set(22, 1.0);
    for line in ["$X\n", "$H\n"] {
        let build = Build {
            quirks: Quirks {
                door_pin: true,
                ..Quirks::default()
            },
            ..Build::default()
        };
        let mut c = Controller::with_build(memory.clone(), build);
        c.set_pins(Pins {
            door: true,
            ..Pins::default()
        });
        c.output();
        assert_eq!(after(&mut c, line, 0.1), "error:13\r\n", "{line}");
    }
}

#[test]
fn a_line_too_long_to_be_kept_is_error_14() {
    let options = Options {
        line_chars: 255,
        ..Options::default()
    };
    for head in ["$I=", "$N0="] {
        let mut c = built(options, Memory::default());
        let line = format!("{head}{}\n", "G4P0".repeat(30));
        assert_eq!(after(&mut c, &line, 0.1), "error:14\r\n", "{head}");
        let line = format!("{head}G4P0\n");
        assert_eq!(after(&mut c, &line, 0.1), "ok\r\n", "{head}");
    }
}

#[test]
fn laser_mode_without_a_spindle_speed_is_error_17() {
    let options = Options {
        variable_spindle: false,
        ..Options::default()
    };
    for value in ["1", "2.5"] {
        let mut c = built(options, Memory::default());
        assert_eq!(
            after(&mut c, &format!("$32={value}\n"), 0.1),
            "error:17\r\n"
        );
        assert_eq!(after(&mut c, "$32=0\n", 0.1), "ok\r\n");
        assert!(after(&mut c, "?", 0.1).contains("|F:0|"));
        assert!(after(&mut c, "$I\n", 0.1).contains("[OPT:,15,128]"));
    }
}

#[test]
fn a_gantry_askew_is_alarm_10() {
    let ends = [None, Some(500), None, Some(500), None, Some(500)];
    let unlock = "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n";
    // Travel 200 mm: 5 % of it is allowed, 10 mm.
    for (um, alarm) in [(11_000, true), (25_000, true), (9_000, false)] {
        let mut memory = Memory::default();
        for (number, value) in [(22, 1.0), (24, 100.0), (25, 2000.0), (26, 50.0)] {
            memory.set(number, value);
        }
        let options = Options {
            second_y_switch_um: Some(um),
            ..Options::default()
        };
        let mut c = built(options, memory);
        c.set_switches(Switches {
            limits: ends,
            probe_z: None,
        });
        let said = after(&mut c, "$H\n", 60.0);
        let wanted = match alarm {
            true => format!("ALARM:10\r\nok\r\n{unlock}"),
            false => "ok\r\n".to_string(),
        };
        assert_eq!(said, wanted, "{um}");
        assert!(after(&mut c, "$I\n", 0.1).contains("[OPT:V2,15,128]"));
    }
}
