//! Programs read by the interpreter, dialect by dialect: those under `tests/gcode/err` are refused with exactly the errors they name, those
//! under `tests/gcode/ok` come to exactly the events beside them. `tests/gcode/README.md` says how both are written.

use morsemill::gcode::{
    Dialect, Event, InterpretError, Interpreter, Motion, Plane, Reading, State,
};
use std::fmt::Write;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// The folders of a kind of programs, each with its dialect.
fn folders(kind: &str) -> Vec<(PathBuf, Dialect)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/gcode")
        .join(kind);
    let inside = sorted(&root).into_iter().filter(|p| p.is_dir());
    inside
        .map(|folder| {
            let name = name(&folder);
            let dialect = Dialect::from_name(&name);
            let dialect =
                dialect.unwrap_or_else(|| panic!("tests/gcode/{kind}/{name}: no such dialect"));
            (folder, dialect)
        })
        .collect()
}

fn sorted(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all: Vec<PathBuf> = entries.map(|f| f.unwrap().path()).collect();
    all.sort();
    all
}

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// The programs of a folder; beside each there may be a file of the same name that ends in `beside`, and nothing else.
fn programs(folder: &Path, beside: &str) -> Vec<PathBuf> {
    let (programs, others): (Vec<_>, Vec<_>) = sorted(folder)
        .into_iter()
        .partition(|f| f.extension().is_some_and(|e| e == "nc"));
    for other in others {
        let at = other.display();
        assert!(
            other.extension().is_some_and(|e| e == beside),
            "{at}: what is this file for?"
        );
        assert!(
            other.with_extension("nc").exists(),
            "{at}: its program is missing"
        );
    }
    assert!(!programs.is_empty(), "{}: no programs", folder.display());
    programs
}

/// So many lines may be read again: the loops in these programs are short.
const LINES_AGAIN: u64 = 10_000;

fn read(file: &Path, dialect: Dialect) -> Result<Vec<Event>, Vec<InterpretError>> {
    let from = BufReader::new(File::open(file).unwrap());
    let reading = Reading {
        lines_again: LINES_AGAIN,
        ..Reading::default()
    };
    let mut program = Interpreter::from_state(from, State::new(dialect), reading).unwrap();
    let mut events = vec![];
    let errors = program.read_all(&mut events);
    if errors.is_empty() {
        Ok(events)
    } else {
        Err(errors)
    }
}

/// Two texts line by line, where they differ.
fn differ(file: &Path, want: &[String], got: &[String]) -> Option<String> {
    if want == got {
        return None;
    }
    let mut out = format!("{}\n", file.display());
    for i in 0..want.len().max(got.len()) {
        let (want, got) = (want.get(i), got.get(i));
        if want != got {
            let show = |line: Option<&String>| line.map_or("(nothing)".into(), Clone::clone);
            writeln!(
                out,
                "  {}: want {}\n  {}:  got {}",
                i + 1,
                show(want),
                i + 1,
                show(got)
            )
            .unwrap();
        }
    }
    Some(out)
}

/// The errors that a program must raise: in `NAME.err`, or in its own first comments.
fn expected_errors(file: &Path) -> Vec<String> {
    let beside = file.with_extension("err");
    if beside.exists() {
        let text = std::fs::read_to_string(beside).unwrap();
        return text.lines().map(String::from).collect();
    }
    let bytes = std::fs::read(file).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let front = text.split(['\n', '\r']).filter(|l| !l.is_empty());
    front
        .map_while(|l| l.strip_prefix("; "))
        .map(String::from)
        .collect()
}

#[test]
fn broken_programs_are_refused_with_the_errors_they_name() {
    let mut wrong = vec![];
    for (folder, dialect) in folders("err") {
        for file in programs(&folder, "err") {
            let want = expected_errors(&file);
            assert!(!want.is_empty(), "{}: names no error", file.display());
            let got = match read(&file, dialect) {
                Ok(_) => vec![],
                Err(errors) => errors.iter().map(ToString::to_string).collect(),
            };
            wrong.extend(differ(&file, &want, &got));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn good_programs_come_to_the_events_beside_them() {
    let mut wrong = vec![];
    for (folder, dialect) in folders("ok") {
        for file in programs(&folder, "events") {
            let beside = file.with_extension("events");
            let want = std::fs::read_to_string(&beside)
                .unwrap_or_else(|e| panic!("{}: {e}", beside.display()));
            let want: Vec<String> = want.lines().map(String::from).collect();
            let got: Vec<String> = match read(&file, dialect) {
                Ok(events) => events.iter().map(line).collect(),
                Err(errors) => errors.iter().map(|e| format!("error {e}")).collect(),
            };
            wrong.extend(differ(&file, &want, &got));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// At most four decimals, trailing zeros cut, no negative zero.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

fn place(motion: &Motion) -> String {
    let [x, y, z] = [0, 1, 2].map(|i| number(motion.to[i]));
    format!("X{x} Y{y} Z{z}")
}

fn motion(m: &Motion) -> String {
    use morsemill::gcode::MotionKind::{Feed, Rapid};
    let machine = if m.machine_coordinates {
        "machine "
    } else {
        ""
    };
    let feed = number(m.feed.0);
    let place = place(m);
    match (m.kind, m.arc) {
        (Rapid, _) => format!("{machine}rapid {place}"),
        (Feed, None) => {
            let kind = if m.inverse_time { "inverse" } else { "feed" };
            format!("{machine}{kind} {place} F{feed}")
        }
        (Feed, Some(arc)) => {
            let kind = if m.inverse_time { "inverse" } else { "arc" };
            let plane = match arc.plane {
                Plane::Xy => "XY",
                Plane::Zx => "ZX",
                Plane::Yz => "YZ",
            };
            let way = if arc.clockwise { "cw" } else { "ccw" };
            let [a, b, _] = arc.plane.axes();
            let [about_a, about_b] =
                [a, b].map(|i| format!("{}{}", ['X', 'Y', 'Z'][i], number(arc.center[i])));
            let turn = number(arc.sweep.to_degrees());
            format!(
                "{machine}{kind} {plane} {way} {place} about {about_a} {about_b} turn {turn} F{feed}"
            )
        }
    }
}

/// One event as the files write it.
fn line(event: &Event) -> String {
    match event {
        Event::Motion(m) => motion(m),
        Event::Probe {
            motion,
            away,
            strict,
        } => {
            let away = if *away { " away" } else { "" };
            let lenient = if *strict { "" } else { " lenient" };
            format!(
                "probe {} F{}{away}{lenient}",
                place(motion),
                number(motion.feed.0)
            )
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
        Event::Pause {
            optional: false, ..
        } => "pause".into(),
        Event::Sync { .. } => "sync".into(),
        Event::End { .. } => "end".into(),
    }
}
