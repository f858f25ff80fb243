//! What the real firmware answered, replayed against the simulated controller.
#![allow(clippy::unwrap_used)]

use morsemill::controller::{Controller, Memory};
use serde_json::Value;

const LINES: &str = include_str!("../data/grbl/lines.jsonl");
const SEQUENCES: &str = include_str!("../data/grbl/sequences.jsonl");

/// The recordings' machine: GRBL's defaults, but quicker axes.
fn machine() -> Controller {
    let mut memory = Memory::default();
    for axis in 0..3 {
        memory.set(110 + axis, 3000.0);
        memory.set(120 + axis, 500.0);
    }
    Controller::new(memory)
}

fn replies(c: &mut Controller) -> Vec<String> {
    String::from_utf8(c.output())
        .unwrap()
        .lines()
        .filter(|l| !l.is_empty())
        .map(String::from)
        .collect()
}

/// The recordings hold bytes as Latin-1 characters.
fn bytes(text: &str) -> Vec<u8> {
    text.chars().map(|c| c as u32 as u8).collect()
}

fn strings(v: &Value) -> Vec<String> {
    v.as_array()
        .map(|a| a.iter().map(|s| s.as_str().unwrap().to_string()).collect())
        .unwrap_or_default()
}

fn settle(c: &mut Controller) {
    c.advance(60.0);
}

fn set_up(c: &mut Controller, setup: &Value) {
    for line in strings(setup) {
        if line == "<power cycle>" {
            c.power_cycle();
        } else {
            c.feed(format!("{line}\n").as_bytes());
        }
        settle(c);
    }
    c.output();
}

/// Replays one probe of a line; what differs, if anything.
fn replay_line(probe: &Value) -> Result<(), String> {
    let mut c = machine();
    settle(&mut c);
    set_up(&mut c, &probe["setup"]);
    c.feed(&bytes(probe["send"].as_str().unwrap()));
    settle(&mut c);
    let (got, want) = (replies(&mut c), strings(&probe["recv"]));
    if got != want {
        return Err(format!("said {got:?} instead of {want:?}"));
    }
    if let Some(after) = probe["after"].as_object() {
        // The recordings asked in this order; a prime marks a question asked again.
        for (question, want) in after {
            let asked = question.trim_end_matches('\'');
            c.feed(
                if asked == "?" {
                    b"?".to_vec()
                } else {
                    format!("{asked}\n").into_bytes()
                }
                .as_slice(),
            );
            c.advance(0.1);
            let (got, want) = (replies(&mut c), strings(want));
            if got != want {
                return Err(format!(
                    "then to {question} said {got:?} instead of {want:?}"
                ));
            }
        }
    }
    Ok(())
}

#[test]
fn lines_are_answered_as_the_firmware_did() {
    let mut failed = Vec::new();
    let mut count = 0;
    for line in LINES.lines().filter(|l| !l.trim().is_empty()) {
        let probe: Value = serde_json::from_str(line).unwrap();
        count += 1;
        if let Err(why) = replay_line(&probe) {
            failed.push(format!(
                "{} {} {:?} {}: {why}",
                probe["id"],
                probe["group"],
                probe["send"].as_str(),
                probe["setup"]
            ));
        }
    }
    eprintln!("{} of {count} agree", count - failed.len());
    assert!(
        failed.is_empty(),
        "{} of {count} differ:\n{}",
        failed.len(),
        failed.join("\n")
    );
}

/// Two replies agree when they are the same but for what may change in the few milliseconds that the real firmware takes to read a
/// line: positions in motion, and one block more or less.
fn alike(got: &str, want: &str) -> bool {
    if got == want {
        return true;
    }
    let fields = |s: &str| {
        s.trim_matches(['<', '>'])
            .split('|')
            .map(String::from)
            .collect::<Vec<_>>()
    };
    let (g, w) = (fields(got), fields(want));
    g.len() == w.len()
        && g.iter().zip(&w).all(|(g, w)| {
            let list = |name: &str, s: &str| -> Option<Vec<f64>> {
                s.strip_prefix(name)?
                    .split(',')
                    .map(|v| v.parse().ok())
                    .collect()
            };
            let near = |name: &str, by: f64| match (list(name, g), list(name, w)) {
                (Some(g), Some(w)) => g.iter().zip(&w).all(|(a, b)| (a - b).abs() <= by),
                _ => false,
            };
            g == w || near("MPos:", 0.15) || near("Bf:", 1.0)
        })
}

fn replay_sequence(sequence: &Value) -> Result<(), String> {
    let mut c = machine();
    settle(&mut c);
    set_up(&mut c, &sequence["settings_or_setup"]);
    if sequence["power_cycled"].as_bool() == Some(true) {
        c.power_cycle();
        let (got, want) = (replies(&mut c), strings(&sequence["boot"]));
        if got != want {
            return Err(format!("at power-up said {got:?} instead of {want:?}"));
        }
    }
    for (i, step) in sequence["steps"].as_array().unwrap().iter().enumerate() {
        if let Some(send) = step["send"].as_str() {
            c.feed(&bytes(send));
        }
        c.advance(step["then_run_ms"].as_f64().unwrap() / 1000.0);
        let (got, want) = (replies(&mut c), strings(&step["recv"]));
        if got.len() != want.len() || !got.iter().zip(&want).all(|(g, w)| alike(g, w)) {
            return Err(format!(
                "step {i} {:?}: said {got:?} instead of {want:?}",
                step["send"].as_str()
            ));
        }
    }
    Ok(())
}

/// Sequences that need what the simulator leaves out (switches, the reset pin) or the firmware's byte timing.
const LEFT_OUT: [&str; 8] = [
    "hard_limit",
    "reset_pin_running",
    "homing_not_found",
    "homing_reset_wait",
    "probe_ok",
    "probe_already_38_3",
    "probe_already_wait",
    "probe_hold",
];

#[test]
fn sequences_go_as_the_firmware_went() {
    let mut failed = Vec::new();
    let mut count = 0;
    for line in SEQUENCES.lines().filter(|l| !l.trim().is_empty()) {
        let sequence: Value = serde_json::from_str(line).unwrap();
        let name = sequence["name"].as_str().unwrap();
        if LEFT_OUT.contains(&name) {
            continue;
        }
        count += 1;
        if let Err(why) = replay_sequence(&sequence) {
            failed.push(format!("{name}: {why}"));
        }
    }
    eprintln!("{} of {count} agree", count - failed.len());
    assert!(
        failed.is_empty(),
        "{} of {count} differ:\n{}",
        failed.len(),
        failed.join("\n")
    );
}

/// A program streamed by character counting, without any delay on the host's side; the controller's own time from first motion to
/// standstill.
fn stream_through(c: &mut Controller, program: &str) -> f64 {
    let mut waiting: std::collections::VecDeque<usize> = Default::default();
    let mut said = Vec::new();
    let mut answered = |c: &mut Controller, waiting: &mut std::collections::VecDeque<usize>| {
        said.extend(c.output());
        while let Some(end) = said.iter().position(|b| *b == b'\n') {
            let line: Vec<u8> = said.drain(..=end).collect();
            let line = String::from_utf8(line).unwrap();
            assert!(
                !line.starts_with("error") && !line.starts_with("ALARM"),
                "{line}"
            );
            if line.trim() == "ok" {
                waiting.pop_front();
            }
        }
    };
    for line in program.lines() {
        while waiting.iter().sum::<usize>() + line.len() + 1 > 128 {
            c.advance(0.002);
            answered(c, &mut waiting);
        }
        c.feed(format!("{line}\n").as_bytes());
        waiting.push_back(line.len() + 1);
        answered(c, &mut waiting);
    }
    c.advance(600.0);
    answered(c, &mut waiting);
    assert!(waiting.is_empty());
    assert_eq!(c.bytes_lost(), 0);
    c.elapsed()
}

#[test]
fn programs_take_the_time_the_firmware_took() {
    let times: Value = serde_json::from_str(include_str!("../data/grbl/times.json")).unwrap();
    let mut worst: f64 = 0.0;
    for run in times["runs"].as_array().unwrap() {
        let mut memory = Memory::default();
        for (name, value) in times["settings"][run["settings"].as_str().unwrap()]
            .as_object()
            .unwrap()
        {
            memory.set(name[1..].parse().unwrap(), value.as_f64().unwrap());
        }
        let name = run["program"].as_str().unwrap();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gcode/ok");
        let program = std::fs::read_to_string(format!("{folder}/{name}")).unwrap();
        let mut c = Controller::new(memory);
        let got = stream_through(&mut c, &program);
        let want = run["motion_s"].as_f64().unwrap();
        let off = got / want - 1.0;
        worst = worst.max(off.abs());
        eprintln!(
            "{name} {}: {got:.3} s, firmware {want:.3} s, {:+.2} %",
            run["settings"],
            100.0 * off
        );
        assert!(
            off.abs() < 0.01,
            "{name} {}: {got} s, the firmware took {want} s",
            run["settings"]
        );
        c.output();
        c.feed(b"?");
        let said = String::from_utf8(c.output()).unwrap();
        let place = format!("MPos:{}|", run["end_mpos"].as_str().unwrap());
        assert!(
            said.contains(&place),
            "{name} {}: ends at {said} instead of {place}",
            run["settings"]
        );
    }
    eprintln!("worst {:.2} %", 100.0 * worst);
}
