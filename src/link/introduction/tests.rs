#![allow(clippy::unwrap_used)]
use super::*;
use crate::gcode::{Dialect, Distance, MotionMode, Units};
use crate::geom::Point;
use crate::units::MmPerMin;

fn at(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Plays a far side that answers each question by the given lines; what became known.
fn play(
    answers: &[(&str, &str)],
    greeting: &str,
    options: IntroductionOptions,
) -> Result<Known, Unknown> {
    let mut intro = Introduction::new(options, Duration::ZERO);
    let say = |intro: &mut Introduction, text: &str, now| {
        for line in text.lines() {
            intro.receive(&Reply::parse(line), now);
        }
    };
    for ms in (0..60_000).step_by(50) {
        if ms == 100 {
            say(&mut intro, greeting, at(ms));
        }
        intro.tick(at(ms));
        let asked = String::from_utf8_lossy(&intro.output()).to_string();
        for (question, answer) in answers {
            if asked.contains(question) {
                say(&mut intro, answer, at(ms));
            }
        }
        if let Some(result) = intro.result() {
            return result.cloned().map_err(Clone::clone);
        }
    }
    panic!("it never ends");
}

const GRBL: [(&str, &str); 5] = [
    ("?", "<Idle|MPos:1.000,2.000,3.000|FS:0,0>"),
    ("$I", "[VER:1.1h.20190830:mill]\n[OPT:VZ,15,128]\nok"),
    ("$$", "$13=0\n$22=1\n$130=200.000\nok"),
    (
        "$#",
        "[G54:0.500,0.000,0.000]\n[G55:9.000,0.000,0.000]\n[G28:1.000,1.000,1.000]\n[G92:0.000,0.000,0.250]\n[TLO:1.000]\n[PRB:0.000,0.000,-4.000:1]\nok",
    ),
    ("$G", "[GC:G1 G54 G17 G20 G91 G94 M3 M8 T2 F254 S1000]\nok"),
];

const WELCOME: &str = "\nGrbl 1.1h ['$' for help]\n";

#[test]
fn everything_asked_is_known_and_the_offset_follows_from_the_answers() {
    let known = play(&GRBL, WELCOME, IntroductionOptions::default()).unwrap();
    assert_eq!(
        (known.version.as_str(), known.firmware),
        ("1.1h.20190830:mill", Firmware::Grbl11)
    );
    assert_eq!(
        (known.rx_bytes, known.blocks, known.letters.as_str()),
        (128, Some(15), "VZ")
    );
    assert_eq!(known.setting(130), Some(200.0));
    assert_eq!(known.machine_position, Some([1.0, 2.0, 3.0]));
    assert_eq!(known.work_offset, Some([0.5, 0.0, 1.25]));
    assert_eq!(known.work_position(), Some([0.5, 2.0, 1.75]));
    assert_eq!(known.offsets.probe, Some(([0.0, 0.0, -4.0], true)));
    let parser = known.parser();
    assert_eq!(
        (parser.units, parser.distance, parser.spindle),
        (Units::Inch, Distance::Incremental, 1)
    );
    assert_eq!(
        (parser.motion, parser.feed, parser.flood),
        (MotionMode::Linear, MmPerMin(254.0), true)
    );
    assert_eq!(parser.position, Point::new(0.5, 2.0, 1.75));
    // A job starts from the start-up modes, but with these offsets and at this place.
    let start = known.start();
    assert_eq!(
        (start.units, start.distance, start.spindle),
        (Units::Mm, Distance::Absolute, 0)
    );
    assert_eq!(start.machine_position(), Point::new(1.0, 2.0, 3.0));
}

#[test]
fn inches_become_millimetres_but_for_the_settings() {
    let mut answers = GRBL;
    answers[2].1 = "$13=1\n$130=200.000\nok";
    let known = play(&answers, WELCOME, IntroductionOptions::default()).unwrap();
    assert_eq!(
        known.machine_position,
        Some([1.0, 2.0, 3.0].map(|inch| inch * 25.4))
    );
    assert_eq!(known.offsets.g5x[0], Some([12.7, 0.0, 0.0]));
    assert_eq!(known.setting(130), Some(200.0));
    assert_eq!(known.parser().feed, MmPerMin(254.0 * 25.4));
}

#[test]
fn the_relatives_are_told_apart_and_their_gaps_filled() {
    let mut hal = GRBL;
    hal[0].1 = "<Idle|MPos:1.000,2.000,3.000|FS:0,0|H:1,7>";
    hal[1].1 = "[VER:1.1f.20260817:]\n[OPT:VNM,100,1024,3,0]\n[AXS:3:XYZ]\n[FIRMWARE:grblHAL]\nok";
    let known = play(
        &hal,
        "Grbl 1.1f ['$' or '$HELP' for help]",
        IntroductionOptions::default(),
    )
    .unwrap();
    assert_eq!(
        (known.firmware, known.rx_bytes, known.homed),
        (Firmware::GrblHal, 1024, Some(true))
    );
    assert_eq!(known.dialect(), Dialect::GrblHal);
    let mut fluid = GRBL;
    fluid[1].1 = "[VER:3.7 FluidNC v3.7.8:]\n[OPT:PHSW]\nok";
    let known = play(
        &fluid,
        "Grbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]",
        IntroductionOptions::default(),
    )
    .unwrap();
    assert_eq!(
        (known.firmware, known.rx_bytes, known.blocks),
        (Firmware::FluidNc, 128, None)
    );
    // A figure that cannot be is not believed.
    let mut odd = GRBL;
    odd[1].1 = "[OPT:V,15,3]\nok";
    assert_eq!(
        play(&odd, WELCOME, IntroductionOptions::default())
            .unwrap()
            .rx_bytes,
        128
    );
}

#[test]
fn a_locked_machine_is_known_and_a_busy_one_is_left_alone() {
    let mut locked = GRBL;
    locked[0].1 = "<Alarm|MPos:0.000,0.000,0.000|FS:0,0>";
    let known = play(&locked, WELCOME, IntroductionOptions::default()).unwrap();
    assert_eq!((known.state, known.homed), (State::Alarm, Some(false)));
    for (state, says) in [
        ("Run", "says Run: wait until it is, or reset it"),
        ("Hold:0", "says Hold:0"),
        ("Tool", "says Tool"),
        ("Check", "send $C to leave it"),
        ("Sleep", "asleep: reset it"),
    ] {
        let report = format!("<{state}|MPos:0.000,0.000,0.000|FS:0,0>");
        let why = play(&[("?", &report)], WELCOME, IntroductionOptions::default()).unwrap_err();
        assert!(why.to_string().contains(says), "{why}");
    }
}

#[test]
fn silence_is_told_and_answered_by_a_reset_only_when_wanted() {
    let why = play(&[], "", IntroductionOptions::default()).unwrap_err();
    assert!(
        why.to_string()
            .starts_with("no answer from the controller while waiting for its status: check cable"),
        "{why}"
    );
    let why = play(
        &[],
        "ALARM:1\n[MSG:Reset to continue]",
        IntroductionOptions::default(),
    )
    .unwrap_err();
    assert!(
        why.to_string()
            .starts_with("the controller says ALARM:1 and then nothing: a limit switch was hit"),
        "{why}"
    );
    let mut deaf = vec![("\u{18}", WELCOME)];
    deaf.extend(GRBL);
    // It listens to nothing but a reset: the questions before it stay unanswered.
    let options = IntroductionOptions {
        when_silent: WhenSilent::ResetOnce,
        ..IntroductionOptions::default()
    };
    let known = play(&[deaf[0]], "", options);
    assert!(matches!(known, Err(Unknown::Silent { .. })));
    let mut intro = Introduction::new(options, Duration::ZERO);
    let mut resets = 0;
    for ms in (0..60_000).step_by(50) {
        intro.tick(at(ms));
        resets += intro.output().iter().filter(|b| **b == 0x18).count();
    }
    assert_eq!(resets, 1);
}

#[test]
fn a_late_greeting_voids_the_answers_before_it() {
    let mut intro = Introduction::again(IntroductionOptions::default(), Duration::ZERO);
    intro.tick(at(0));
    assert_eq!(intro.output(), b"?");
    intro.receive(&Reply::parse("<Idle|MPos:0,0,0>"), at(1));
    assert_eq!(intro.output(), b"$I\n");
    intro.receive(&Reply::parse("ok"), at(2));
    assert_eq!(intro.output(), b"$$\n");
    intro.receive(&Reply::parse("$13=1"), at(3));
    assert!(intro.known().inches);
    intro.receive(&Reply::parse("Grbl 1.1h ['$' for help]"), at(4));
    assert!(!intro.known().inches && intro.known().settings.is_empty());
    intro.tick(at(5));
    assert_eq!(intro.output(), b"?");
}
