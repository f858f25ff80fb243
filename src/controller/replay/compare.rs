//! What differs between a recording and its replay, in words for people.

use super::json::Json;
use super::record::{Record, RecordError, Sequence};
use crate::wire::{Position, State, Status};

/// Machine time by which a position in motion may be off, s.
const IN_MOTION: f64 = 0.005;
/// Slowest speed taken for an axis in motion, mm/min: a ramp reports less than it does.
const LEAST_SPEED: f64 = 600.0;

/// One answer that is not the recorded one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// At which point of the record.
    pub at: String,
    /// What was recorded.
    pub recorded: Vec<String>,
    /// What this controller said.
    pub answered: Vec<String>,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let lines = |l: &[String]| match l.is_empty() {
            true => "(nothing)".to_string(),
            false => l.join(" | "),
        };
        write!(
            f,
            "{}: recorded {}, answered {}",
            self.at,
            lines(&self.recorded),
            lines(&self.answered)
        )
    }
}

/// Everything in which a replay differs from its recording. Replies must be the same to the letter; positions in motion may be off by
/// what the machine moves in 5 ms.
///
/// # Errors
/// What is wrong with either.
pub fn compare(recorded: &Json, answered: &Json) -> Result<Vec<Difference>, RecordError> {
    let mut found = Vec::new();
    let mut note = |at: String, want: &[String], got: &[String], same: bool| {
        if !same {
            found.push(Difference {
                at,
                recorded: want.to_vec(),
                answered: got.to_vec(),
            });
        }
    };
    match (Record::read(recorded)?, Record::read(answered)?) {
        (Record::Probe(want), Record::Probe(got)) => {
            let sent = shown(&want.send);
            note(sent, &want.recv, &got.recv, want.recv == got.recv);
            for ((question, w), (_, g)) in want.after.iter().zip(&got.after) {
                note(format!("then {question}"), w, g, w == g);
            }
        }
        (Record::Sequence(want), Record::Sequence(got)) => {
            if let (Some(w), Some(g)) = (&want.boot, &got.boot) {
                note("at power-up".to_string(), w, g, w == g);
            }
            let speed = top_speed(&want);
            for (i, (w, g)) in want.steps.iter().zip(&got.steps).enumerate() {
                let what = match (&w.send, w.pins.first()) {
                    (Some(bytes), _) => shown(bytes),
                    (None, Some((pin, active))) => format!("{pin:?} {active}"),
                    (None, None) => "time".to_string(),
                };
                let same = w.recv.len() == g.recv.len()
                    && w.recv.iter().zip(&g.recv).all(|(w, g)| alike(w, g, speed));
                note(format!("step {} ({what})", i + 1), &w.recv, &g.recv, same);
            }
        }
        _ => return Err(RecordError::NotJson("records of two kinds".to_string())),
    }
    Ok(found)
}

fn shown(bytes: &[u8]) -> String {
    let text: String = bytes.iter().map(|&b| char::from(b)).collect();
    format!("{text:?}")
}

/// The highest speed any report of a sequence shows, mm/min (or inch/min, with positions in inch).
fn top_speed(sequence: &Sequence) -> f64 {
    sequence
        .steps
        .iter()
        .flat_map(|s| &s.recv)
        .filter_map(|line| Status::parse(line)?.feed)
        .fold(LEAST_SPEED, f64::max)
}

/// The same, but for positions in motion.
fn alike(want: &str, got: &str, speed: f64) -> bool {
    if want == got {
        return true;
    }
    let (Some(mut w), Some(mut g)) = (Status::parse(want), Status::parse(got)) else {
        return false;
    };
    let moving = matches!(
        w.state,
        // An alarm may have cut a motion off.
        State::Run
            | State::Jog
            | State::Home
            | State::Alarm
            | State::Hold { at_rest: false }
            | State::Door(_)
    );
    let by = speed / 60.0 * IN_MOTION + 1e-3;
    let near = match (w.position, g.position) {
        (Some(Position::Machine(a)), Some(Position::Machine(b)))
        | (Some(Position::Work(a)), Some(Position::Work(b))) => {
            a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= by)
        }
        _ => false,
    };
    (w.position, g.position) = (None, None);
    moving && near && w == g
}
