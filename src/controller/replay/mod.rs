//! Recordings of a real controller, replayed in virtual time: a record in, the same record with our answers out, and what differs.
//!
//! Crosses the border: one JSON object a record, in either of two kinds (a *probe* of one line, a *sequence* of steps), or a program
//! with its settings and the time it took. No files, no clock. Each record starts from a fresh power-up on the factory settings, but
//! for the quicker axes that all recordings share: `$110`-`$112` = 3000 mm/min, `$120`-`$122` = 500 mm/s².

mod compare;
mod json;
mod record;
mod timing;

pub use compare::{Difference, compare};
pub use json::Json;
pub use record::{Pin, Probe, Record, RecordError, Sequence, Step};
pub use timing::{Timed, TimingError, time_program};

use super::{Build, Controller, Memory, Pins, Switches};

/// How long a recording waits for standstill after a line, machine time, s.
const PATIENCE: f64 = 120.0;
/// Pause behind each line that prepares, s.
const PAUSE: f64 = 0.15;
/// Pause behind each question asked afterwards, s.
const ANSWER: f64 = 0.1;
/// Bytes a second on the cable of the recordings.
pub(super) const BAUD: u32 = 115_200;

/// Replays one record. The result is the same object with `recv`, `after` and `boot` as this controller answers.
///
/// # Errors
/// What is wrong with the record.
pub fn replay(json: &Json) -> Result<Json, RecordError> {
    let mut answered = json.clone();
    match Record::read(json)? {
        Record::Probe(probe) => {
            let (recv, after) = replay_probe(&probe);
            answered.set("recv", Json::texts(recv));
            if !after.is_empty() {
                let pairs = after.into_iter().map(|(q, a)| (q, Json::texts(a)));
                answered.set("after", Json::Object(pairs.collect()));
            }
        }
        Record::Sequence(sequence) => {
            let (boot, recv) = replay_sequence(&sequence);
            if let Some(boot) = boot {
                answered.set("boot", Json::texts(boot));
            }
            if let Json::Object(pairs) = &mut answered
                && let Some((_, Json::List(steps))) = pairs.iter_mut().find(|(k, _)| k == "steps")
            {
                for (step, said) in steps.iter_mut().zip(recv) {
                    step.set("recv", Json::texts(said));
                }
            }
        }
    }
    Ok(answered)
}

/// Reads a line of a file of recordings.
///
/// # Errors
/// Text that is not JSON.
pub fn parse(line: &str) -> Result<Json, RecordError> {
    serde_json::from_str(line).map_err(|e| RecordError::NotJson(e.to_string()))
}

/// The recordings' machine, just switched on.
fn machine() -> Controller {
    let mut memory = Memory::default();
    for axis in 0..3 {
        memory.set(110 + axis, 3000.0);
        memory.set(120 + axis, 500.0);
    }
    let build = Build {
        baud: Some(BAUD),
        ..Build::default()
    };
    Controller::with_build(memory, build)
}

/// What it said, line by line, without empty lines.
fn said(controller: &mut Controller) -> Vec<String> {
    // A byte that is no ASCII shows as its Latin-1 character, as in the recordings.
    let text: String = controller.output().iter().map(|&b| char::from(b)).collect();
    text.split(['\r', '\n'])
        .filter(|l| !l.is_empty())
        .map(String::from)
        .collect()
}

/// Lets time pass until nothing changes by itself any more.
fn settle(controller: &mut Controller) {
    let end = controller.now() + PATIENCE;
    while let Some(at) = controller.next_change()
        && controller.now() < end
    {
        controller.advance((at - controller.now()).max(1e-4));
    }
    controller.advance(PAUSE);
}

/// Sends the lines that prepare; says what the last power-up among them said.
fn set_up(controller: &mut Controller, lines: &[String]) {
    settle(controller);
    for line in lines {
        match line.as_str() {
            "<power cycle>" => controller.power_cycle(),
            _ => {
                let mut bytes: Vec<u8> = line.chars().map(|c| c as u32 as u8).collect();
                bytes.push(b'\n');
                controller.feed(&bytes);
            }
        }
        settle(controller);
    }
    controller.output();
}

type Answers = Vec<(String, Vec<String>)>;

fn replay_probe(probe: &Probe) -> (Vec<String>, Answers) {
    let mut c = machine();
    set_up(&mut c, &probe.setup);
    c.feed(&probe.send);
    settle(&mut c);
    let recv = said(&mut c);
    let mut after = Vec::with_capacity(probe.after.len());
    for (question, _) in &probe.after {
        let asked = question.trim_end_matches('\'');
        match asked {
            "?" => c.feed(b"?"),
            _ => c.feed(format!("{asked}\n").as_bytes()),
        }
        c.advance(ANSWER);
        after.push((question.clone(), said(&mut c)));
    }
    (recv, after)
}

fn replay_sequence(sequence: &Sequence) -> (Option<Vec<String>>, Vec<Vec<String>>) {
    let mut c = machine();
    c.set_switches(Switches {
        limits: sequence.limits,
        probe_z: sequence.probe_z,
    });
    set_up(&mut c, &sequence.setup);
    let boot = sequence.power_cycled.then(|| {
        c.power_cycle();
        settle(&mut c);
        said(&mut c)
    });
    let mut recv = Vec::with_capacity(sequence.steps.len());
    for step in &sequence.steps {
        if !step.pins.is_empty() {
            let mut pins = c.pins();
            for (pin, active) in &step.pins {
                set_pin(&mut pins, *pin, *active);
            }
            c.set_pins(pins);
        }
        if let Some(bytes) = &step.send {
            c.feed(bytes);
        }
        c.advance(step.run);
        recv.push(said(&mut c));
    }
    (boot, recv)
}

fn set_pin(pins: &mut Pins, pin: Pin, active: bool) {
    match pin {
        Pin::Limit(axis) => {
            if let Some(limit) = pins.limit.get_mut(axis) {
                *limit = active;
            }
        }
        Pin::Probe => pins.probe = active,
        Pin::Door => pins.door = active,
        Pin::Hold => pins.hold = active,
        Pin::Reset => pins.reset = active,
        Pin::CycleStart => pins.cycle_start = active,
    }
}
