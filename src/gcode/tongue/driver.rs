//! Runs whole programs of the two languages for their tests and writes events as `tests/gcode` has them. The programs there are read by
//! `tests/it/programs.rs`; here they are only what mutations begin from.
#![allow(clippy::unwrap_used)]

use super::super::dialect::Dialect;
use super::super::error::InterpretError;
use super::super::event::{Event, MotionKind, Plane};
use super::super::program::{Interpreter, Reading};
use super::super::state::State;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// So many lines are read again at most: loops in these programs are short.
const LINES_AGAIN: u64 = 20_000;

/// A program's events and the state at its end, or what is wrong with it.
pub(in crate::gcode) fn run(
    text: &str,
    dialect: Dialect,
) -> Result<(Vec<Event>, State), Vec<InterpretError>> {
    let reading = Reading {
        lines_again: LINES_AGAIN,
        ..Reading::default()
    };
    let from = Cursor::new(text.as_bytes());
    let mut program = Interpreter::from_state(from, State::new(dialect), reading).unwrap();
    let mut events = vec![];
    let errors = program.read_all(&mut events);
    match errors.is_empty() {
        true => Ok((events, program.state().clone())),
        false => Err(errors),
    }
}

/// At most four decimals, trailing zeros cut, no negative zero.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_string()
}

/// One event as `tests/gcode` writes it.
fn show(event: &Event) -> String {
    match event {
        Event::Motion(m) => {
            let machine = if m.machine_coordinates {
                "machine "
            } else {
                ""
            };
            let [x, y, z] = [0, 1, 2].map(|i| number(m.to[i]));
            let (place, feed) = (format!("X{x} Y{y} Z{z}"), number(m.feed.0));
            let inverse = m.inverse_time.then_some("inverse");
            match (m.kind, m.arc) {
                (MotionKind::Rapid, _) => format!("{machine}rapid {place}"),
                (_, None) => format!("{machine}{} {place} F{feed}", inverse.unwrap_or("feed")),
                (_, Some(arc)) => {
                    let plane = match arc.plane {
                        Plane::Xy => "XY",
                        Plane::Zx => "ZX",
                        Plane::Yz => "YZ",
                    };
                    let way = if arc.clockwise { "cw" } else { "ccw" };
                    let [a, b, _] = arc.plane.axes();
                    let [p, q] =
                        [a, b].map(|i| format!("{}{}", ["X", "Y", "Z"][i], number(arc.center[i])));
                    let turn = number(arc.sweep.to_degrees());
                    let kind = inverse.unwrap_or("arc");
                    format!(
                        "{machine}{kind} {plane} {way} {place} about {p} {q} turn {turn} F{feed}"
                    )
                }
            }
        }
        Event::Dwell { time, .. } => format!("dwell {}", number(time.0)),
        Event::Spindle { direction: 0, .. } => "spindle off".into(),
        Event::Spindle {
            direction, speed, ..
        } => {
            let way = if *direction > 0 { "cw" } else { "ccw" };
            format!("spindle {way} {}", number(speed.0))
        }
        Event::Coolant { flood, mist, .. } => match (flood, mist) {
            (true, true) => "coolant flood mist".into(),
            (true, false) => "coolant flood".into(),
            (false, true) => "coolant mist".into(),
            (false, false) => "coolant off".into(),
        },
        Event::ToolChange { tool, .. } => format!("tool {tool}"),
        Event::Pause { optional: true, .. } => "optional pause".into(),
        Event::Pause { .. } => "pause".into(),
        Event::Sync { .. } => "sync".into(),
        Event::End { .. } => "end".into(),
        Event::Probe { .. } => "probe".into(),
    }
}

/// What a program comes to: events, or errors behind the word `error`.
pub(in crate::gcode) fn told(text: &str, dialect: Dialect) -> Vec<String> {
    match run(text, dialect) {
        Ok((events, _)) => events.iter().map(show).collect(),
        Err(errors) => errors.iter().map(|e| format!("error {e}")).collect(),
    }
}

/// The programs under `tests/gcode`, of one kind and dialect.
fn programs(kind: &str, dialect: Dialect) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gcode");
    let folder = root.join(kind).join(dialect.name());
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    all.retain(|p| p.extension().is_some_and(|e| e == "nc"));
    all.sort();
    all
}

mod mutations {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        /// Good programs with pieces cut out, doubled, or overwritten: read or refused, without a panic.
        #[test]
        fn no_mutation_makes_it_panic(
            which in any::<prop::sample::Index>(),
            siemens: bool,
            changes in proptest::collection::vec((any::<prop::sample::Index>(), 0usize..12, 0u8..4, any::<u8>()), 1..8),
        ) {
            let dialect = if siemens { Dialect::Siemens } else { Dialect::Heidenhain };
            let files = programs("ok", dialect);
            let mut bytes = std::fs::read(which.get(&files)).unwrap();
            for (place, length, kind, byte) in changes {
                let at = place.index(bytes.len().max(1));
                let end = (at + length).min(bytes.len());
                match kind {
                    0 => drop(bytes.drain(at..end)),
                    1 => {
                        let piece = bytes[at..end].to_vec();
                        let to = (at * 7 + usize::from(byte)) % (bytes.len() + 1);
                        bytes.splice(to..to, piece);
                    }
                    2 => bytes.insert(at, byte),
                    _ => bytes[at..end].iter_mut().for_each(|b| *b = byte),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            let text: String = match std::str::from_utf8(&bytes) {
                Ok(text) => text.to_string(),
                Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
            };
            for e in run(&text, dialect).err().unwrap_or_default() {
                prop_assert!(e.line >= 1 && e.column >= 1 && !e.to_string().is_empty());
            }
        }
    }
}
