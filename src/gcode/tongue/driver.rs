//! Runs whole programs of the two languages for their tests, without the streaming that `program` does, and writes events as
//! `tests/gcode` has them.
#![allow(clippy::unwrap_used)]

use super::super::dialect::Dialect;
use super::super::error::InterpretError;
use super::super::event::{Event, MotionKind, Plane};
use super::super::flow::Flow;
use super::super::interpret::lines;
use super::super::state::State;
use super::super::{heidenhain, siemens};
use std::path::{Path, PathBuf};

/// So many lines are carried out at most.
const LONGEST: usize = 20_000;

/// A language's memory.
enum Memory {
    Heidenhain(heidenhain::Memory),
    Siemens(siemens::Memory),
}

/// A program's events and the state at its end, or what is wrong with it. Labels that are missing end it.
pub(in crate::gcode) fn run(
    text: &str,
    dialect: Dialect,
) -> Result<(Vec<Event>, State), Vec<InterpretError>> {
    let mut state = State::new(dialect);
    let mut memory = match dialect {
        Dialect::Heidenhain => Memory::Heidenhain(Default::default()),
        _ => Memory::Siemens(Default::default()),
    };
    let label = match dialect {
        Dialect::Heidenhain => heidenhain::label,
        _ => siemens::label,
    };
    let all: Vec<&str> = lines(text).collect();
    let (mut events, mut errors) = (vec![], vec![]);
    let mut calls: Vec<(usize, usize, u32)> = vec![];
    let mut repeats: Vec<(usize, u32)> = vec![];
    let (mut at, mut steps) = (0, 0);
    while let Some(line) = all.get(at) {
        steps += 1;
        if steps > LONGEST {
            break;
        }
        // A repetition under way is counted, not begun anew.
        if let Some((_, left)) = repeats.last_mut().filter(|r| r.0 == at)
            && *left == 0
        {
            repeats.pop();
            at += 1;
            continue;
        }
        let said = match &mut memory {
            Memory::Heidenhain(m) => heidenhain::line(&mut state, m, line, at + 1, &mut events),
            Memory::Siemens(m) => siemens::line(&mut state, m, line, at + 1, &mut events),
        };
        let flow = match said {
            Ok(flow) => flow,
            Err(fault) => {
                errors.push(fault.locate(line, at + 1));
                Flow::Next
            }
        };
        let find = |l: &str| all.iter().position(|t| label(t).as_deref() == Some(l));
        let next = at + 1;
        match flow {
            Flow::Next => at = next,
            Flow::End => break,
            Flow::Call { label, times } => match find(&label) {
                Some(place) => {
                    calls.push((next, place, times - 1));
                    at = place + 1;
                }
                None => break,
            },
            Flow::Return => match calls.pop() {
                Some((back, place, left)) if left > 0 => {
                    calls.push((back, place, left - 1));
                    at = place + 1;
                }
                Some((back, _, _)) => at = back,
                None => break,
            },
            Flow::Repeat { label, times } => match find(&label) {
                Some(place) => {
                    match repeats.last_mut().filter(|r| r.0 == at) {
                        Some(r) => r.1 -= 1,
                        None => repeats.push((at, times - 1)),
                    }
                    at = place;
                }
                None => break,
            },
            Flow::Goto { label: l, forward } => {
                let is = |t: &&str| label(t).as_deref() == Some(&*l);
                let ahead = all.iter().skip(next).position(is).map(|p| p + next);
                let before = all.iter().take(at).rposition(is);
                let place = match forward {
                    Some(true) => ahead,
                    Some(false) => before,
                    None => ahead.or(before),
                };
                match place {
                    Some(place) => at = place,
                    None => break,
                }
            }
        }
    }
    if errors.is_empty() {
        let end = match &memory {
            Memory::Heidenhain(m) => heidenhain::finish(m),
            Memory::Siemens(m) => siemens::finish(m),
        };
        errors.extend(end.err().map(|fault| fault.locate("", all.len() + 1)));
    }
    if errors.is_empty() {
        Ok((events, state))
    } else {
        Err(errors)
    }
}

/// At most four decimals, trailing zeros cut, no negative zero.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_string()
}

/// One event as `tests/gcode` writes it.
pub(in crate::gcode) fn show(event: &Event) -> String {
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
pub(in crate::gcode) fn programs(kind: &str, dialect: Dialect) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gcode");
    let folder = root.join(kind).join(dialect.name());
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    all.retain(|p| p.extension().is_some_and(|e| e == "nc"));
    all.sort();
    all
}

/// The text of a file, as far as it is UTF-8.
fn text(file: &Path) -> String {
    String::from_utf8_lossy(&std::fs::read(file).unwrap()).into_owned()
}

#[test]
fn the_good_programs_come_to_their_events() {
    let mut wrong = vec![];
    for dialect in [Dialect::Heidenhain, Dialect::Siemens] {
        for file in programs("ok", dialect) {
            let want = text(&file.with_extension("events"));
            let got = told(&text(&file), dialect);
            if want.lines().ne(got.iter().map(String::as_str)) {
                wrong.push(format!("{}:\n{}", file.display(), got.join("\n")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_broken_programs_are_refused_as_they_say() {
    let mut wrong = vec![];
    for dialect in [Dialect::Heidenhain, Dialect::Siemens] {
        for file in programs("err", dialect) {
            let program = text(&file);
            let want = program.lines().map_while(|l| l.strip_prefix("; "));
            let got: Vec<String> = match run(&program, dialect) {
                Ok(_) => vec!["no error".into()],
                Err(errors) => errors.iter().map(ToString::to_string).collect(),
            };
            if want.ne(got.iter().map(String::as_str)) {
                wrong.push(format!("{}:\n{}", file.display(), got.join("\n")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
