#![allow(clippy::unwrap_used)]
use super::super::error::Complaint;
use super::super::interpret::interpret_line;
use super::super::state::State;
use super::super::{Dialect, Event};
use super::*;

fn plain() -> impl Iterator<Item = Dialect> {
    let elsewhere = [Dialect::Siemens, Dialect::Heidenhain];
    Dialect::ALL
        .into_iter()
        .filter(move |d| !elsewhere.contains(d))
}

/// What the last of the lines comes to: how many events, or the complaint.
fn say(dialect: Dialect, lines: &str) -> Result<usize, String> {
    let mut state = State::new(dialect);
    let mut events: Vec<Event> = vec![];
    let mut answer = Ok(0);
    for line in lines.split('|') {
        events.clear();
        answer = interpret_line(&mut state, line, 1, &mut events)
            .map(|()| events.len())
            .map_err(|e| e.to_string());
    }
    answer
}

#[test]
fn every_table_has_a_title_a_source_and_codes() {
    for d in plain() {
        let r = d.rules();
        assert!(!r.title.is_empty() && !r.source.is_empty(), "{d:?}");
        assert!(r.m(300).is_some(), "{d:?}");
        for code in [0, 100, 200, 300] {
            assert_eq!(r.g(code), find(r.g, code), "{d:?}");
            assert!(r.g(code).is_some(), "{d:?}");
        }
    }
}

#[test]
fn every_dialect_cuts_a_line_and_an_arc() {
    for d in plain() {
        assert_eq!(say(d, "G1 X1. Y2. F300."), Ok(1), "{d:?}");
        assert_eq!(say(d, "G1 F300.|G2 X2. Y0. I1. J0."), Ok(1), "{d:?}");
        assert_eq!(say(d, "G21|G90|G94|G17|G0 Z5.0"), Ok(1), "{d:?}");
    }
}

#[test]
fn no_dialect_ignores_a_code() {
    for d in plain() {
        for code in ["G41 D1", "G42", "G68", "G51", "G16", "G777", "M777", "G5.7"] {
            let e = say(d, code).unwrap_err();
            assert!(
                e.starts_with("1:1 G") || e.starts_with("1:1 M"),
                "{d:?} {code}: {e}"
            );
        }
        let e = say(d, "G1 X1. F100. A5.").unwrap_err();
        assert!(e.contains("A is not a word"), "{d:?}: {e}");
    }
}

#[test]
fn languages_read_elsewhere_are_not_read_here() {
    for d in [Dialect::Siemens, Dialect::Heidenhain] {
        let e = say(d, "G1 X1").unwrap_err();
        assert!(e.contains("not read here"), "{e}");
    }
}

#[test]
fn what_is_refused_says_why_and_ends_without_a_stop() {
    for d in Dialect::ALL {
        for row in table(d).codes.iter().filter(|r| !r.understood) {
            assert!(
                row.text.len() > 15 && !row.text.ends_with('.'),
                "{d:?} {row:?}"
            );
        }
    }
}

#[test]
fn the_table_is_what_the_reader_does() {
    for d in plain() {
        for row in table(d).codes {
            let code = row.code.split(' ').next().unwrap();
            let mut state = State::new(d);
            let answer = interpret_line(&mut state, code, 1, &mut vec![]);
            let complaint = answer.err().map(|e| e.complaint);
            let refused = matches!(
                complaint,
                Some(Complaint::Rule(RuleComplaint::Refused { .. }))
            );
            assert_eq!(refused, !row.understood, "{d:?} {row:?}: {complaint:?}");
            let unknown = matches!(
                complaint,
                Some(Complaint::UnsupportedCode { .. } | Complaint::Fraction { .. })
            );
            assert!(!unknown, "{d:?} {row:?}: {complaint:?}");
        }
    }
}

#[test]
fn dwells_count_as_the_maker_counts() {
    use Dialect::*;
    for (dialect, line, seconds) in [
        (Grbl, "G4 P1.5", 1.5),
        (LinuxCnc, "G4 P2", 2.0),
        (Fanuc, "G4 P1500", 1.5),
        (Fanuc, "G4 X1.5", 1.5),
        (Fanuc, "G4 U2.", 2.0),
        (Mazak, "G4 P250", 0.25),
        (Haas, "G4 P500", 0.5),
        (Haas, "G4 P2.", 2.0),
        (Marlin, "G4 P500", 0.5),
        (Marlin, "G4 S2", 2.0),
        (RepRap, "G4 P500", 0.5),
        (Smoothie, "G4 S3", 3.0),
        (Okuma, "G4 F1.5", 1.5),
        (Centroid, "G4 P1", 1.0),
        (Mach3, "G4 P1", 1.0),
        (TinyG, "G4 P1", 1.0),
    ] {
        let mut state = State::new(dialect);
        let mut events = vec![];
        interpret_line(&mut state, line, 1, &mut events).unwrap();
        let [Event::Dwell { time, .. }] = events[..] else {
            panic!("{dialect:?} {line}: {events:?}")
        };
        assert_eq!(time.0, seconds, "{dialect:?} {line}");
        assert_eq!(
            (state.feed.0, state.speed.0),
            (0.0, 0.0),
            "{dialect:?} {line}"
        );
        assert_eq!(state.position, crate::geom::Point::origin());
    }
    for (dialect, line) in [
        (Fanuc, "G4 X1"),
        (Fanuc, "G4 P1.5"),
        (Okuma, "G4 F2"),
        (Smoothie, "G4 P1"),
        (Smoothie, "G4 S1.5"),
        (Marlin, "G4 P1 S1"),
        (Haas, "G4"),
        (Fanuc, "G4 X-1."),
    ] {
        assert!(say(dialect, line).is_err(), "{dialect:?} {line}");
    }
}

#[test]
fn further_work_offsets_are_apart_from_each_other() {
    use Dialect::*;
    for (dialect, line, index) in [
        (LinuxCnc, "G59.3", 8),
        (GrblHal, "G59.1", 6),
        (Fanuc, "G54.1 P1", 6),
        (Fanuc, "G54 P48", 53),
        (Haas, "G154 P99", 104),
        (Haas, "G110", 6),
        (Haas, "G129", 25),
        (Mach3, "G59 P254", 253),
        (Mach4, "G54.1 P2", 7),
        (Okuma, "G15 H3", 2),
        (RepRap, "G59.2", 7),
    ] {
        let mut state = State::new(dialect);
        interpret_line(&mut state, line, 1, &mut vec![]).unwrap();
        assert_eq!(state.work_offset, index, "{dialect:?} {line}");
    }
    // G10 L20 measures here, and names the further offsets there.
    let mut state = State::new(Fanuc);
    interpret_line(&mut state, "G10 L20 P2 X5. Y-3.", 1, &mut vec![]).unwrap();
    interpret_line(&mut state, "G54.1 P2", 1, &mut vec![]).unwrap();
    assert_eq!(state.position, crate::geom::Point::new(-5.0, 3.0, 0.0));
    interpret_line(&mut state, "G91 G10 L2 P1 X5.", 1, &mut vec![]).unwrap();
    interpret_line(&mut state, "G10 L2 P1 X5.", 1, &mut vec![]).unwrap();
    assert_eq!(state.g5x[0].x, 10.0);
    state.reset();
    assert_eq!(state.origin_of(7).x, 5.0);
}

use proptest::prelude::*;

fn line() -> impl Strategy<Value = String> {
    let word = (0usize..26, -30i32..100, 0usize..4).prop_map(|(letter, n, kind)| match kind {
        0 => {
            let codes = [
                0, 1, 2, 3, 4, 10, 15, 28, 30, 43, 49, 52, 53, 54, 59, 73, 80, 81, 82, 83, 85, 86,
                89, 90, 91, 92, 93, 95, 98, 99,
            ];
            format!("G{}", codes[(n + 30) as usize % codes.len()])
        }
        1 => format!(
            "{}{:.2}",
            ["X", "Y", "Z", "I", "J", "R", "F", "P", "Q"][letter % 9],
            f64::from(n) / 4.0
        ),
        2 => [
            "G43 H1", "G92.1", "G92.2", "G92.3", "M30", "G20", "G21", "L2", "L20", "P1", "F100.",
            "G18", "G54.1", "M3", "S500", "G99", "K3", "T1",
        ][letter % 18]
            .to_string(),
        _ => format!("{}{n}", (b'A' + letter as u8) as char),
    });
    proptest::collection::vec(word, 0..6).prop_map(|w| w.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]
    /// In every dialect: a refused line changes nothing, and the machine goes from where it was to where it is by motions alone.
    #[test]
    fn the_machine_moves_by_motions_only(lines in proptest::collection::vec(line(), 1..25), d in 0usize..22) {
        let dialect = Dialect::ALL[d];
        let mut state = State::new(dialect);
        let mut events = vec![];
        for (i, text) in lines.iter().enumerate() {
            let before = state.clone();
            events.clear();
            if interpret_line(&mut state, text, i + 1, &mut events).is_err() {
                prop_assert_eq!(&before, &state);
                prop_assert!(events.is_empty());
                continue;
            }
            let motions: Vec<_> = events.iter().filter_map(|e| match e {
                Event::Motion(m) => Some(*m),
                Event::Probe { motion, .. } => Some(*motion),
                _ => None,
            }).collect();
            if motions.is_empty() {
                let moved = (before.machine_position() - state.machine_position()).norm();
                prop_assert!(moved < 1e-9, "{:?} {}: {}", dialect, text, moved);
            }
            for pair in motions.windows(2) {
                prop_assert_eq!(pair[0].to, pair[1].from);
            }
            if let (Some(m), false) = (motions.last(), events.iter().any(|e| matches!(e, Event::End { .. }))) {
                prop_assert_eq!(m.to, state.position);
                let start = motions[0].from + state.offset();
                prop_assert!((start - before.machine_position()).norm() < 1e-9, "{:?} {}", dialect, text);
            }
        }
    }

    #[test]
    fn no_text_makes_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..120), d in 0usize..22) {
        let text = String::from_utf8_lossy(&bytes);
        let _ = super::super::interpret(&text, Dialect::ALL[d]);
    }

    /// Whatever the peck: cutting goes down to Z and never below, begins at R or under it, and the tool ends where G98 or G99 says, above
    /// the hole.
    #[test]
    fn a_cycle_drills_to_its_bottom_and_comes_back(
        d in 0usize..22, code in 0usize..5, q in 0.05..7.0f64, r in -2.0..2.0f64, depth in 0.1..20.0f64, up in 0.0..9.0f64, initial: bool,
    ) {
        let dialect = Dialect::ALL[d];
        prop_assume!(dialect.rules().cycles.is_some());
        let (r, z, start) = ((r * 1e3).round() / 1e3, ((r - depth) * 1e3).round() / 1e3, ((r + up) * 1e3).round() / 1e3);
        let code = [73, 81, 83, 85, 89][code];
        prop_assume!(matches!(dialect.rules().g(code * 100), Some(Meaning::Motion(_))));
        let extra = match code {
            73 | 83 => format!("Q{q:.3}"),
            89 => "P1".to_string(),
            _ => String::new(),
        };
        let back = if initial { 98 } else { 99 };
        let mut state = State::new(dialect);
        let mut events = vec![];
        interpret_line(&mut state, &format!("G90 G0 Z{start:.3}"), 1, &mut events).unwrap();
        events.clear();
        let line = format!("G{back} G{code} X3.000 Y4.000 Z{z:.3} R{r:.3} {extra} F100.0");
        interpret_line(&mut state, &line, 2, &mut events).unwrap();
        let motions: Vec<_> = events.iter().filter_map(|e| match e {
            Event::Motion(m) => Some(*m),
            _ => None,
        }).collect();
        let lowest = motions.iter().map(|m| m.to.z).fold(f64::INFINITY, f64::min);
        prop_assert!((lowest - z).abs() < 1e-12, "{dialect:?} {line}: {lowest}");
        let top = if initial { start } else { r };
        prop_assert_eq!(state.position, crate::geom::Point::new(3.0, 4.0, top));
        // What rapids down stays above what has been cut.
        let mut cut = r;
        for m in &motions {
            match m.kind {
                super::super::MotionKind::Rapid => prop_assert!(m.to.z >= cut - 1e-9, "{dialect:?} {line}: {m:?}"),
                super::super::MotionKind::Feed => cut = cut.min(m.to.z),
            }
        }
    }
}
