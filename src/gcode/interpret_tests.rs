#![allow(clippy::unwrap_used)]
use super::super::event::Plane;
use super::super::state::{Distance, FeedMode, MotionMode};
use super::*;
use crate::geom::{Point, Vector};

/// GRBL's number for a complaint; the table that counts is `wire`'s.
fn number(c: &Complaint) -> u8 {
    use Complaint::*;
    match c {
        ExpectedLetter { .. } | DecimalComma => 1,
        BadNumber { .. } => 2,
        Negative { .. } => 4,
        LineTooLong { .. } => 11,
        JogWord => 16,
        UnsupportedCode { .. } | UnsupportedWord { .. } | OffsetKind | OffsetRotation => 20,
        SameGroup { .. } => 21,
        FeedMissing => 22,
        Fraction { .. } => 23,
        TwoAxisCommands { .. } => 24,
        Repeated { .. } => 25,
        AxisWordsMissing { .. } => 26,
        LineNumber => 27,
        ValueMissing { .. } => 28,
        WorkOffset { .. } => 29,
        MachineNeedsStraight => 30,
        AxisWordsWithoutMotion => 31,
        ArcAxisMissing { .. } => 32,
        ArcNowhere | ArcRadiiDiffer { .. } | ProbeNowhere => 33,
        ArcRadius { .. } => 34,
        ArcCenterMissing { .. } => 35,
        Unused { .. } => 36,
        ToolLengthAxis => 37,
        ToolNumber { .. } => 38,
        ArcRadiusZero | CommentOpen | CommentNested | WholeNumber { .. } | Rule(_) => 20,
        Flow(_) | Expression(_) => 20,
    }
}

/// The state as GRBL's `$G` writes it.
fn modes(s: &State) -> String {
    let motion = match s.motion {
        MotionMode::Rapid => "G0",
        MotionMode::Linear => "G1",
        MotionMode::ArcClockwise => "G2",
        MotionMode::ArcCounterclockwise => "G3",
        MotionMode::Probe(p) => match (p.away, p.strict) {
            (false, true) => "G38.2",
            (false, false) => "G38.3",
            (true, true) => "G38.4",
            (true, false) => "G38.5",
        },
        MotionMode::None | MotionMode::Cycle(_) => "G80",
    };
    let plane = match s.plane {
        Plane::Xy => 17,
        Plane::Zx => 18,
        Plane::Yz => 19,
    };
    let units = if s.units == super::super::Units::Inch {
        20
    } else {
        21
    };
    let distance = if s.distance == Distance::Absolute {
        90
    } else {
        91
    };
    let feed = if s.feed_mode == FeedMode::PerMinute {
        94
    } else {
        93
    };
    let spindle = ["M4", "M5", "M3"][(s.spindle + 1) as usize];
    let coolant = if s.flood { "M8" } else { "M9" };
    format!(
        "[GC:{motion} G{} G{plane} G{units} G{distance} G{feed} {spindle} {coolant} T{} F{:.0} S{:.0}]",
        54 + s.work_offset,
        s.tool,
        s.feed.0,
        s.speed.0
    )
}

#[test]
fn answers_as_the_firmware_did() {
    let mut wrong = vec![];
    for row in include_str!("../../tests/gcode/grbl-answers.tsv").lines() {
        if row.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = row.split('\t').collect();
        let mut state = State::new(Dialect::Grbl);
        let mut events = vec![];
        for line in cells[0].split('|') {
            let _ = interpret_line(&mut state, line, 1, &mut events);
        }
        let answer = match interpret_line(&mut state, cells[1], 1, &mut events) {
            Ok(()) => "ok".to_string(),
            Err(e) => format!("error:{}", number(&e.complaint)),
        };
        if answer != cells[2] && cells[2] != "-" {
            wrong.push(format!("{row}: {answer}"));
        }
        let xyz = |p: Vector| format!("{:.3},{:.3},{:.3}", p.x + 0.0, p.y + 0.0, p.z + 0.0);
        let got = [
            modes(&state),
            xyz(state.machine_position().coords),
            xyz(state.offset()),
        ];
        for (got, want) in got.iter().zip(&cells[3..]) {
            if got != want && !want.is_empty() {
                wrong.push(format!("{row}: {got}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn run(lines: &[&str], dialect: Dialect) -> (State, Vec<Event>) {
    let mut state = State::new(dialect);
    let mut events = vec![];
    for (i, line) in lines.iter().enumerate() {
        interpret_line(&mut state, line, i + 1, &mut events).unwrap();
    }
    (state, events)
}

fn last_motion(events: &[Event]) -> Motion {
    match events.last().unwrap() {
        Event::Motion(m) => *m,
        other => panic!("{other:?}"),
    }
}

#[test]
fn jogs_as_the_firmware_does() {
    for (text, want) in [
        ("G91X1F100", Ok([1.0, 0.0, 0.0])),
        ("G20X0.1F10", Ok([2.54, 0.0, 0.0])),
        (" X1 F100", Ok([1.0, 0.0, 0.0])),
        ("G91G53X1F100", Ok([1.0, 0.0, 0.0])),
        ("G0X1F100", Err(16)),
        ("G55X1F100", Err(16)),
        ("M3X1F100", Err(16)),
        ("X1F100S5", Err(36)),
        ("X1", Err(22)),
        ("X1F0", Err(22)),
        ("", Err(22)),
        ("G4X1F100", Err(28)),
        ("$", Err(1)),
    ] {
        let mut state = State::new(Dialect::Grbl);
        let before = state.clone();
        let got = interpret_jog(&mut state, text, 1);
        match (got, want) {
            (Ok(m), Ok(to)) => {
                assert!((m.to - Point::from(to)).norm() < 1e-12, "{text}");
                assert_eq!(state.position, m.to);
                assert_eq!(modes(&state), modes(&before), "modes stay");
            }
            (Err(e), Err(n)) => {
                assert_eq!(number(&e.complaint), n, "{text}");
                assert_eq!(state, before);
            }
            (got, _) => panic!("{text}: {got:?}"),
        }
    }
    let (mut state, _) = run(&["G92X5", "G0X9"], Dialect::Grbl);
    interpret_jog(&mut state, "F600", 1).unwrap();
    assert_eq!(state.machine_position(), Point::origin());
}

#[test]
fn offsets_move_the_numbers_not_the_machine() {
    let (s, _) = run(&["G0X10Y20Z5", "G92X0Y0", "G43.1Z2"], Dialect::Grbl);
    assert_eq!(s.machine_position(), Point::new(10.0, 20.0, 5.0));
    assert_eq!(s.position, Point::new(0.0, 0.0, 3.0));
    let (s, _) = run(&["G10L2P2X100", "G0X10", "G55", "G0X1"], Dialect::Grbl);
    assert_eq!(s.machine_position().x, 101.0);
    let (s, _) = run(&["G0X7Y3", "G10L20P0X1", "M30"], Dialect::Grbl);
    assert_eq!((s.position.x, s.g5x[0].x), (1.0, 6.0));
    let (s, events) = run(&["G92X5", "G53G0X2", "G92.1X3"], Dialect::Grbl);
    // The target of the last line was taken in the coordinates before the shift was cleared.
    assert_eq!(s.machine_position().x, -2.0);
    assert_eq!(last_motion(&events).to.x, -2.0);
}

#[test]
fn going_home_passes_the_named_point_and_moves_only_the_named_axes() {
    let (s, events) = run(
        &["G54", "G92X1", "G0X1Y1", "G30.1", "G0X3Z4", "G91", "G30Z1"],
        Dialect::Grbl,
    );
    let Event::Motion(first) = events[events.len() - 2] else {
        panic!()
    };
    let second = last_motion(&events);
    assert_eq!(first.to, Point::new(3.0, 1.0, 5.0));
    assert_eq!(second.to, Point::new(3.0, 1.0, 0.0));
    assert_eq!(
        (first.machine_coordinates, second.machine_coordinates),
        (false, true)
    );
    assert_eq!(s.motion, MotionMode::Rapid);
    let (s, _) = run(
        &["G0X1Y1", "G28.1", "G92X0", "G0X9Y9Z9", "G28"],
        Dialect::Grbl,
    );
    assert_eq!(s.machine_position(), Point::new(1.0, 1.0, 0.0));
}

#[test]
fn commands_that_stop_the_machine_are_events_and_the_rest_are_not() {
    let count = |lines: &[&str]| run(lines, Dialect::Grbl).1.len();
    for silent in [
        "G17", "G21", "G90", "G94", "G40", "G61", "G80", "F100", "S500", "T3", "G54", "G49", "M5",
        "M9", "G0", "",
    ] {
        assert_eq!(count(&[silent]), 0, "{silent}");
    }
    for stops in [
        "G4P0",
        "G55",
        "G92.1",
        "G28.1",
        "M3",
        "M8",
        "M0",
        "M2",
        "G10L2P1X0",
        "G43.1Z1",
    ] {
        assert_eq!(count(&[stops]), 1, "{stops}");
    }
    assert_eq!(
        count(&["M3S100", "M3", "S100", "S200", "M3S300", "M5", "S9"]),
        4
    );
}

#[test]
fn a_linuxcnc_mill_program_is_understood() {
    let text = "%\r\n(part)\rG17 G20 G40 G49 G80 G90 G94 G54 G64 P0.001\nT2 M6\nG43 H2\nS8000 M3\nM8\n\
                G0 X1 Y0\nZ.1\nG1 Z-.02 F10\nG2 I-1\nG3 X0 Y1 R1 P2\nG53 G0 Z0\nM9\nM5\nG28 X0\nM30\n%\nG0 X99\n";
    let program = interpret(text, Dialect::LinuxCnc).unwrap();
    assert_eq!(program.lines, 19);
    let turns: Vec<f64> = program
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Motion(m) => m.arc.map(|a| a.sweep / std::f64::consts::TAU),
            _ => None,
        })
        .collect();
    assert!((turns[0] + 1.0).abs() < 1e-12 && (turns[1] - 1.25).abs() < 1e-12);
    assert_eq!(program.events[0], Event::ToolChange { tool: 2, line: 4 });
    assert_eq!(program.events.last(), Some(&Event::End { line: 17 }));
    assert_eq!(program.end_state.tool_length, Some(2));
    assert_eq!(program.end_state.feed, crate::units::MmPerMin(254.0));
    let errors = interpret(text, Dialect::Grbl).unwrap_err();
    let lines: Vec<usize> = errors.iter().map(|e| e.line).collect();
    assert_eq!(lines, [3, 4, 5, 11, 12]);
}

#[test]
fn slashes_do_what_each_controller_makes_of_them() {
    let (s, _) = run(&["/G0X1"], Dialect::Grbl);
    assert_eq!(s.position.x, 1.0);
    let (mut s, _) = run(&["/G0X1"], Dialect::LinuxCnc);
    assert_eq!(s.position.x, 1.0);
    s.block_delete = true;
    interpret_line(&mut s, " / G0 X2", 2, &mut vec![]).unwrap();
    assert_eq!(s.position.x, 1.0);
}

#[test]
fn lines_end_in_three_ways() {
    assert_eq!(
        lines("a\r\nb\rc\n\nd").collect::<Vec<_>>(),
        ["a", "b", "c", "", "d"]
    );
    assert_eq!(lines("").count(), 0);
    assert_eq!(lines("\n").count(), 1);
    let program = interpret("\u{feff}G0 X1\r\nX2\r\n", Dialect::Grbl).unwrap();
    assert_eq!((program.lines, program.events.len()), (2, 2));
}

#[test]
fn columns_count_characters() {
    let e = interpret("(\u{e4}\u{f6}) G0 Q1", Dialect::Grbl).unwrap_err();
    assert_eq!((e[0].line, e[0].column), (1, 9));
}

#[test]
fn at_most_twenty_errors_are_reported() {
    let e = interpret(&"G5\n".repeat(100), Dialect::Grbl).unwrap_err();
    assert_eq!(e.len(), MAX_ERRORS);
    let e = interpret(&"G1 X1\n".repeat(100), Dialect::Grbl).unwrap_err();
    assert_eq!(e.len(), 1);
}

use proptest::prelude::*;

fn line() -> impl Strategy<Value = String> {
    let word = (0usize..26, -30i32..100, 0usize..4).prop_map(|(letter, n, kind)| match kind {
        0 => format!(
            "G{}",
            [0, 1, 2, 3, 10, 28, 30, 53, 54, 55, 80, 90, 91, 92, 93, 94][(n + 30) as usize % 16]
        ),
        1 => format!(
            "{}{}",
            ["X", "Y", "Z", "I", "J", "R", "F", "P"][letter % 8],
            f64::from(n) / 4.0
        ),
        2 => [
            "G43.1", "G49", "G92.1", "M30", "G20", "G21", "L2", "L20", "P1", "F100", "G18",
            "G28.1", "G38.2",
        ][letter % 13]
            .to_string(),
        _ => format!("{}{n}", (b'A' + letter as u8) as char),
    });
    proptest::collection::vec(word, 0..5).prop_map(|w| w.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    /// Whatever is sent: a refused line changes nothing; without a motion the machine does not move; with motions it goes in
    /// an unbroken line from where it was to where it is.
    #[test]
    fn the_machine_moves_by_motions_only(lines in proptest::collection::vec(line(), 1..40), grbl: bool) {
        let dialect = if grbl { Dialect::Grbl } else { Dialect::LinuxCnc };
        let mut state = State::new(dialect);
        let mut events = vec![];
        for (i, text) in lines.iter().enumerate() {
            let before = state.clone();
            events.clear();
            let done = interpret_line(&mut state, text, i + 1, &mut events);
            if done.is_err() {
                prop_assert_eq!(&before, &state);
                prop_assert!(events.is_empty());
                continue;
            }
            let motions: Vec<Motion> = events.iter().filter_map(|e| match e {
                Event::Motion(m) => Some(*m),
                Event::Probe { motion, .. } => Some(*motion),
                _ => None,
            }).collect();
            if motions.is_empty() {
                let moved = (before.machine_position() - state.machine_position()).norm();
                prop_assert!(moved < 1e-9, "{}: {}", text, moved);
            }
            for pair in motions.windows(2) {
                prop_assert_eq!(pair[0].to, pair[1].from);
            }
            // M30 may change the work offset behind the motion.
            if let (Some(m), false) = (motions.last(), events.iter().any(|e| matches!(e, Event::End { .. }))) {
                prop_assert_eq!(m.to, state.position);
                let start = motions[0].from + state.offset();
                prop_assert!((start - before.machine_position()).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn no_text_makes_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let text = String::from_utf8_lossy(&bytes);
        let _ = interpret(&text, Dialect::Grbl);
        let _ = interpret(&text, Dialect::LinuxCnc);
    }
}
