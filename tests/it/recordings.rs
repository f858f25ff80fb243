//! What the real firmware answered, replayed against the simulated controller; and every error and alarm of its tables.
#![allow(clippy::unwrap_used)]

use morsemill::controller::replay::{Json, compare, parse, replay, time_program};
use morsemill::controller::{Build, Controller, Memory, Pins, Profile, Quirks, Switches};
use serde_json::Value;
use std::collections::BTreeMap;

const LINES: &str = include_str!("../data/grbl/lines.jsonl");
const SEQUENCES: &str = include_str!("../data/grbl/sequences.jsonl");

fn replay_all(file: &str) {
    let mut differing = Vec::new();
    let mut count = 0;
    for line in file.lines().filter(|l| !l.trim().is_empty()) {
        let recorded = parse(line).unwrap();
        let answered = replay(&recorded).unwrap();
        count += 1;
        for difference in compare(&recorded, &answered).unwrap() {
            let name = recorded.get("name").or_else(|| recorded.get("id"));
            differing.push(format!("{name:?} {difference}"));
        }
    }
    assert!(count > 20);
    assert!(
        differing.is_empty(),
        "{} of {count} recordings:\n{}",
        differing.len(),
        differing.join("\n")
    );
}

#[test]
fn lines_are_answered_as_the_firmware_did() {
    replay_all(LINES);
}

#[test]
fn sequences_go_as_the_firmware_went() {
    replay_all(SEQUENCES);
}

/// Recordings of our own: what earlier versions answered otherwise than the firmware.
#[test]
fn our_own_recordings_go_as_the_firmware_went() {
    replay_all(include_str!("../data/grbl/own-lines.jsonl"));
    replay_all(include_str!("../data/grbl/own-sequences.jsonl"));
}

#[test]
fn a_wrong_answer_is_found_and_shown() {
    let mut recorded = parse(LINES.lines().next().unwrap()).unwrap();
    let answered = replay(&recorded).unwrap();
    recorded.set("recv", Json::texts(vec!["error:99".to_string()]));
    let found = compare(&recorded, &answered).unwrap();
    assert_eq!(
        found[0].to_string(),
        r#""\n": recorded error:99, answered ok"#
    );
}

#[test]
fn recordings_that_are_none_are_refused() {
    for (text, complaint) in [
        (
            "nonsense",
            "this is not a JSON object (expected ident at line 1 column 2): recordings have one a line",
        ),
        (
            r#"{"sent": "?"}"#,
            r#"no recording has the key "sent": did you mean "send"?"#,
        ),
        (r#"{"setup": []}"#, r#"the key "send" is missing"#),
        (r#"{"send": 5}"#, r#""send" must be a text"#),
        (
            r#"{"name": "a", "steps": [{"pin": "Q", "active": true, "then_run_ms": 1}]}"#,
            r#"there is no pin "Q": name X_LIMIT, Y_LIMIT, Z_LIMIT, PROBE, RESET, FEED_HOLD, CYCLE_START or SAFETY_DOOR"#,
        ),
        (
            r#"{"name": "a", "steps": [{"send": "?", "then_run_ms": -1}]}"#,
            r#""then_run_ms" must be milliseconds, at most a day"#,
        ),
        (
            r#"{"name": "a", "steps": [], "limit_switch_steps": [1]}"#,
            r#""limit_switch_steps" must be six whole numbers, x-, x+, y-, y+, z-, z+"#,
        ),
    ] {
        let refused = parse(text).and_then(|json| replay(&json)).unwrap_err();
        assert_eq!(refused.to_string(), complaint, "{text}");
    }
}

#[test]
fn programs_take_the_time_the_firmware_took() {
    let times: Value = serde_json::from_str(include_str!("../data/grbl/times.json")).unwrap();
    let mut off = Vec::new();
    for run in times["runs"].as_array().unwrap() {
        let mut memory = Memory::default();
        let settings = &times["settings"][run["settings"].as_str().unwrap()];
        for (name, value) in settings.as_object().unwrap() {
            memory.set(name[1..].parse().unwrap(), value.as_f64().unwrap());
        }
        let name = run["program"].as_str().unwrap();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gcode/ok");
        let program = std::fs::read_to_string(format!("{folder}/{name}")).unwrap();
        let build = Build {
            baud: Some(115_200),
            ..Build::default()
        };
        let timed = time_program(memory, build, &program).unwrap();
        let want = run["motion_s"].as_f64().unwrap();
        let error = timed.motion_s / want - 1.0;
        let case = format!("{name} {}", run["settings"]);
        assert_eq!(timed.errors, 0, "{case}");
        assert_eq!(timed.end_mpos, run["end_mpos"].as_str().unwrap(), "{case}");
        if error.abs() > 0.002 {
            off.push(format!(
                "{case}: {:.3} s, the firmware {want:.3} s, {:+.3} %",
                timed.motion_s,
                100.0 * error
            ));
        }
    }
    assert!(off.is_empty(), "off by more than 0.2 %: {off:?}");
}

/// What a fresh controller says to a line after others.
fn answers(before: &[&str], line: &str) -> String {
    let mut c = Controller::new(Memory::default());
    for text in before {
        match *text {
            "power" => c.power_cycle(),
            _ => c.feed(format!("{text}\n").as_bytes()),
        }
        c.advance(30.0);
    }
    c.output();
    c.feed(format!("{line}\n").as_bytes());
    c.advance(0.01);
    String::from_utf8(c.output()).unwrap()
}

#[test]
fn every_error_of_the_table_is_reached_twice() {
    let long = "X".repeat(80);
    let longer = format!("$I={}", "A".repeat(90));
    let locked: &[&str] = &["$22=1", "power"];
    let soft: &[&str] = &["$22=1", "$20=1"];
    let cases: Vec<(&[&str], &str, u16)> = vec![
        (&[], "=", 1),
        (&[], "%", 1),
        (&[], "X", 2),
        (&[], "G0X--1", 2),
        (&[], "$J", 3),
        (&[], "$140=1", 3),
        (&[], "F-1", 4),
        (&[], "$1=-1", 4),
        (&[], "$H", 5),
        (locked_off(), "$H", 5),
        (&[], "$0=2", 6),
        (&[], "$0=258", 6),
        (&["$C"], "$#", 8),
        (locked, "$J=X1F10", 8),
        (locked, "G0X1", 9),
        (&["$J=X100F10"], "G0X1", 9),
        (&[], "$20=1", 10),
        (&["$22=1", "$22=0"], "$20=1", 10),
        (&[], &long, 11),
        (&[], &longer, 11),
        (soft, "$J=X1F10", 15),
        (soft, "$J=Z-500F10", 15),
        (&[], "$J=G0X1F10", 16),
        (&[], "$J=M3X1F10", 16),
        (&[], "G5", 20),
        (&[], "M6", 20),
        (&[], "G17G18", 21),
        (&[], "M3M4", 21),
        (&[], "G1X1", 22),
        (&[], "$J=X1", 22),
        (&[], "G59.1", 23),
        (&[], "M3.5", 23),
        (&[], "G0G1X1", 24),
        (&[], "G28G92X0", 24),
        (&[], "X1X2", 25),
        (&[], "N1N2", 25),
        (&[], "G92", 26),
        (&[], "G2I1F10", 26),
        (&[], "N10000001", 27),
        (&[], "$J=N10000001X1F10", 27),
        (&[], "G4", 28),
        (&[], "G10X1", 28),
        (&[], "G10L2P7X1", 29),
        (&[], "G10L20P9X1", 29),
        (&[], "G53G2X1I1F10", 30),
        (&["G80"], "G53", 30),
        (&[], "G80X1", 31),
        (&["G80"], "G92X1", 31),
        (&[], "G2Z1F10", 32),
        (&[], "G18G2Y1I1F10", 32),
        (&[], "G2X10Y0I4F10", 33),
        (&[], "G38.2Z0F10", 33),
        (&[], "G2X10R4F10", 34),
        (&[], "G3X10R1F10", 34),
        (&[], "G2X10F10", 35),
        (&[], "G19G2Y5I1F10", 35),
        (&[], "G1X1I1F10", 36),
        (&[], "P1", 36),
        (&[], "G43.1X1", 37),
        (&[], "G43.1", 37),
        (&[], "T256", 38),
        (&[], "T999", 38),
    ];
    let mut reached: BTreeMap<u16, u32> = BTreeMap::new();
    for (before, line, number) in &cases {
        let said = answers(before, line);
        assert_eq!(said, format!("error:{number}\r\n"), "{before:?} {line}");
        *reached.entry(*number).or_default() += 1;
    }
    // 7 needs a damaged memory, 12, 13, 14 and 17 another build (`builds.rs`); 18 and 19 are not the firmware's.
    let expected = (1..=38).filter(|n| ![7, 12, 13, 14, 17, 18, 19].contains(n));
    for number in expected {
        assert!(
            reached.get(&number).is_some_and(|n| *n >= 2),
            "error {number}"
        );
    }
}

/// Nothing but the default: homing is off.
fn locked_off() -> &'static [&'static str] {
    &["$22=1", "$22=0"]
}

#[test]
fn a_damaged_memory_is_error_7_and_the_defaults() {
    for startup in ["", "G20"] {
        let mut memory = Memory::default();
        memory.set(100, 80.0);
        memory.startup[0] = startup.to_string();
        memory.damaged = true;
        let mut c = Controller::new(memory);
        let said = String::from_utf8(c.output()).unwrap();
        assert!(said.starts_with("error:7\r\n$0=10\r\n"), "{said}");
        assert!(said.contains("$100=250.000\r\n"), "{said}");
        assert!(said.contains("Grbl 1.1h ['$' for help]"), "{said}");
    }
}

fn homing_machine(switches: [Option<i64>; 6]) -> Controller {
    let mut memory = Memory::default();
    for (number, value) in [(22, 1.0), (24, 100.0), (25, 2000.0), (26, 50.0)] {
        memory.set(number, value);
    }
    for axis in 0..3 {
        memory.set(110 + axis, 3000.0);
        memory.set(120 + axis, 500.0);
    }
    let mut c = Controller::new(memory);
    c.set_switches(Switches {
        limits: switches,
        probe_z: None,
    });
    c.output();
    c
}

/// Says something after each deed.
fn after(c: &mut Controller, bytes: &[u8], seconds: f64) -> String {
    c.feed(bytes);
    c.advance(seconds);
    String::from_utf8(c.output()).unwrap()
}

#[test]
fn every_alarm_of_the_table_is_reached_twice() {
    let ends = [
        Some(-2000),
        Some(2000),
        Some(-2000),
        Some(2000),
        Some(-2000),
        Some(2000),
    ];
    // 1: a limit pin, and a switch on the way.
    let mut memory = Memory::default();
    memory.set(21, 1.0);
    let mut c = Controller::new(memory.clone());
    c.output();
    after(&mut c, b"G1X20F600\n", 0.3);
    c.set_pins(Pins {
        limit: [false, true, false],
        ..Pins::default()
    });
    assert_eq!(
        after(&mut c, b"?", 0.6),
        "ALARM:1\r\n[MSG:Reset to continue]\r\n"
    );
    let mut c = Controller::new(memory);
    c.set_switches(Switches {
        limits: [None, Some(1000), None, None, None, None],
        probe_z: None,
    });
    c.output();
    assert!(after(&mut c, b"G1X20F500\n", 3.0).contains("ALARM:1"));
    assert!((c.position().x - 4.0).abs() < 0.02, "{}", c.position());
    // 2: at rest and in check mode.
    for check in ["", "$C\n"] {
        let mut memory = Memory::default();
        memory.set(22, 1.0);
        memory.set(20, 1.0);
        let mut c = Controller::new(memory);
        let said = after(&mut c, format!("$X\n{check}G0X5\n").as_bytes(), 1.0);
        assert!(
            said.ends_with("ALARM:2\r\n[MSG:Reset to continue]\r\n"),
            "{said}"
        );
    }
    // 3: a reset while moving.
    for line in ["G1X20F600\n", "$J=X20F600\n"] {
        let mut c = Controller::new(Memory::default());
        after(&mut c, line.as_bytes(), 0.3);
        assert!(after(&mut c, b"\x18", 1.0).starts_with("ALARM:3\r\n"));
    }
    // 4 and 5: probes.
    for code in ["G38.2", "G38.4"] {
        let mut c = Controller::new(Memory::default());
        let away = code == "G38.4";
        c.output();
        c.set_pins(Pins {
            probe: !away,
            ..Pins::default()
        });
        let line = format!("{code}Z-1F300\n");
        assert_eq!(
            after(&mut c, line.as_bytes(), 2.0),
            "ALARM:4\r\nok\r\n",
            "{code}"
        );
        c.set_pins(Pins {
            probe: away,
            ..Pins::default()
        });
        let line = format!("$X\n{code}Z-1F300\n");
        let said = after(&mut c, line.as_bytes(), 20.0);
        let end = "ALARM:5\r\n[PRB:0.000,0.000,0.000:0]\r\nok\r\n";
        assert!(said.ends_with(end), "{said}");
    }
    // 6, 7: reset or door while homing; 9: no switch; 8: a switch that does not open.
    let unlock = "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n";
    for seconds in [0.3, 2.0] {
        for (byte, number) in [(b"\x18", 6), (b"\x84", 7)] {
            let mut c = homing_machine([None; 6]);
            after(&mut c, b"$H\n", seconds);
            let said = after(&mut c, byte, 1.0);
            assert_eq!(said, format!("ALARM:{number}\r\nok\r\n{unlock}"));
        }
    }
    for switches in [[None; 6], [None, None, None, None, None, Some(2000)]] {
        let mut c = homing_machine(switches);
        let said = after(&mut c, b"$H\n", 40.0);
        assert_eq!(said, format!("ALARM:9\r\nok\r\n{unlock}"));
    }
    for axis in [0, 2] {
        let mut c = homing_machine(ends);
        let mut pins = Pins::default();
        pins.limit[axis] = true;
        c.set_pins(pins);
        let said = after(&mut c, b"$H\n", 40.0);
        assert_eq!(said, format!("ALARM:8\r\nok\r\n{unlock}"));
    }
}

#[test]
fn homing_finds_its_switches_and_says_where_it_is() {
    let ends = [
        Some(-2000),
        Some(2000),
        Some(-2000),
        Some(2000),
        Some(-2000),
        Some(2000),
    ];
    for (mask, place) in [(0.0, [-1.0, -1.0, -1.0]), (3.0, [-199.0, -199.0, -1.0])] {
        let mut c = homing_machine(ends);
        c.feed(format!("$23={mask}\n").as_bytes());
        assert_eq!(after(&mut c, b"$H\n", 30.0), "ok\r\nok\r\n");
        let p = c.position();
        assert_eq!([p.x, p.y, p.z], place);
        // The switches stay where they were: nothing is closed now.
        assert!(!after(&mut c, b"?", 0.1).contains("Pn:"));
    }
}

#[test]
fn a_probe_touches_on_the_step_and_stops_behind_it() {
    let mut c = Controller::new(Memory::default());
    c.set_switches(Switches {
        limits: [None; 6],
        probe_z: Some(-500),
    });
    c.output();
    let said = after(&mut c, b"G38.2Z-5F200\n", 10.0);
    assert_eq!(said, "[PRB:0.000,0.000,-2.000:1]\r\nok\r\n");
    assert!(c.position().z < -2.0 && c.position().z > -2.9);
}

#[test]
fn other_firmwares_show_what_a_sender_must_notice() {
    let talk = |profile: Profile, bytes: &[u8]| {
        let mut c = Controller::with_build(Memory::default(), Build::of_profile(profile));
        let greeting = String::from_utf8(c.output()).unwrap();
        (greeting, after(&mut c, bytes, 0.2))
    };
    for (profile, greeting, options) in [
        (
            Profile::Grbl11h,
            "\r\nGrbl 1.1h ['$' for help]\r\n",
            "[OPT:V,15,128]",
        ),
        (
            Profile::Grbl11f,
            "\r\nGrbl 1.1f ['$' for help]\r\n",
            "[OPT:V,15,128]",
        ),
        (
            Profile::GrblHal,
            "\r\nGrblHAL 1.1f ['$' or '$HELP' for help]\r\n",
            ",15,1024,3,0]",
        ),
        (Profile::FluidNc, "\r\nGrbl 3.9 [FluidNC", "[OPT:PHS]"),
    ] {
        let (said, info) = talk(profile, b"$I\n");
        assert!(said.starts_with(greeting), "{said}");
        assert!(info.contains(options), "{info}");
        // CR LF: two answers from GRBL, one from the others.
        let stock = matches!(profile, Profile::Grbl11h | Profile::Grbl11f);
        let (_, oks) = talk(profile, b"G0\r\n");
        assert_eq!(oks, if stock { "ok\r\nok\r\n" } else { "ok\r\n" });
        // Eighty characters are too many for GRBL only.
        let long = format!("G4P{}\n", "0".repeat(90));
        let (_, answer) = talk(profile, long.as_bytes());
        assert_eq!(answer, if stock { "error:11\r\n" } else { "ok\r\n" });
    }
    // grblHAL answers all that follows an error with it, until it is spoken to otherwise.
    let (_, wall) = talk(Profile::GrblHal, b"G0X1X2\nG0X1\nG0X2\n\nG0\n");
    assert_eq!(wall, "error:25\r\nerror:25\r\nerror:25\r\nok\r\nok\r\n");
    let (_, none) = talk(Profile::Grbl11h, b"G0X1X2\nG0\n");
    assert_eq!(none, "error:25\r\nok\r\n");
    // Its second question mark.
    assert!(talk(Profile::GrblHal, b"\x80").1.starts_with("<Idle|"));
    assert_eq!(talk(Profile::Grbl11h, b"\x80").1, "");
}

#[test]
fn each_quirk_can_be_switched_off() {
    let tame = |change: fn(&mut Quirks), bytes: &[u8]| {
        let mut build = Build::default();
        change(&mut build.quirks);
        let mut c = Controller::with_build(Memory::default(), build);
        c.output();
        let said = after(&mut c, bytes, 3.0);
        (said, c)
    };
    assert_eq!(tame(|q| q.crlf_twice = false, b"G0\r\n").0, "ok\r\n");
    assert_eq!(tame(|q| q.slash_passes = false, b"/G5\n").0, "ok\r\n");
    assert_eq!(
        tame(|q| q.jog_to_zero = false, b"$J=F100\n").0,
        "error:26\r\n"
    );
    let (said, _) = tame(|q| q.tool_falls = false, b"T3\nG0\n$G\n");
    assert!(said.contains(" T3 "), "{said}");
    let (_, c) = tame(|q| q.byte_wrap = false, b"$1=300\n");
    assert_eq!(c.memory().get(1), 255.0);
    let (_, c) = tame(|q| q.check_writes = false, b"$C\nG10L2P1X5\n");
    assert_eq!(c.memory().places[0], [0.0; 3]);
    let (_, c) = tame(|_| (), b"$C\nG10L2P1X5\n");
    assert_eq!(c.memory().places[0], [5.0, 0.0, 0.0]);
    let (said, _) = tame(|q| q.stray_ok = false, b"M0\n\x18");
    assert!(!said.contains("ok\r\n"), "{said}");
    let (_, mut c) = tame(|q| q.door_pin = true, b"");
    c.set_pins(Pins {
        door: true,
        ..Pins::default()
    });
    let said = after(&mut c, b"?", 0.1);
    assert!(said.contains("<Door:1|") && said.contains("Pn:D"), "{said}");
}
