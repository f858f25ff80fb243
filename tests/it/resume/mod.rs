//! Taking up broken jobs. Here what the tests share: one machine, journals made by hand, and what a controller says of itself. The random
//! programs are those of the campaign.
#![allow(clippy::unwrap_used)]

mod breaks;
mod cli;
mod entry;
mod process;
mod sender;
mod trust;
mod zoned;

use super::campaign::bench;
use super::campaign::faults::Class;
use super::campaign::jobs::{self, Holds, START};
use crate::chance::Chance;
use morsemill::controller::Controller;
use morsemill::gcode::{State, interpret_line};
use morsemill::geom::Point;
use morsemill::link::journal::{Begin, History, Record, Writer, read};
use morsemill::link::resume::{Now, ResumeOptions, Trust};
use std::time::Duration;

const RX: usize = 128;
/// Planner blocks and prepared slices: what a GRBL holds of answered lines.
const HELD: usize = 15 + 6;

/// A program of random lines, of which the interpreter takes every one.
fn program(seed: u64, lines: usize) -> String {
    jobs::program(
        &mut Chance(seed),
        lines,
        &reset_state(START),
        Holds::Motions,
    )
}

/// A machine just reset, with the offsets of these tests, at machine `place`.
fn reset_state(place: [f64; 3]) -> State {
    let mut s = bench::machine(Class::Sound).1.start();
    s.set_machine_position(&Point::from(place));
    s
}

/// A controller standing at [`START`].
fn controller() -> Controller {
    bench::machine(Class::Sound).0.clone()
}

fn begin(text: &str) -> Begin {
    bench::begin(text, &bench::machine(Class::Sound).1)
}

/// What the controller says of itself when it stands there.
fn here(place: [f64; 3]) -> Now {
    Now {
        position: Some(place),
        ..Now::of(&bench::machine(Class::Sound).1, "test", Some("boot".into()))
    }
}

/// What of a line is sent: as any sender does it.
fn significant(line: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for c in line.chars() {
        match c {
            '(' => inside = true,
            ')' => inside = false,
            ';' => break,
            c if inside || c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    if out == "%" { String::new() } else { out }
}

fn taken(history: &History) -> &Begin {
    history.begin.as_ref().unwrap()
}

/// A history of a job of which so much was answered and sent, ended in order.
fn broken_at(text: &str, acknowledged: usize, sent: usize) -> History {
    history_of(
        text,
        &[
            Record::Allow { line: sent },
            Record::Sent { line: sent },
            Record::Acknowledged { line: acknowledged },
            Record::End {
                how: "stopped".into(),
                done: false,
                position_kept: true,
                at_rest: true,
                cable_sound: true,
            },
        ],
    )
}

fn history_of(text: &str, records: &[Record]) -> History {
    let mut w = Writer::new();
    w.note(Record::Begin(Box::new(begin(text))), Duration::ZERO);
    for r in records {
        w.note(r.clone(), Duration::ZERO);
    }
    read(&w.take()[..]).unwrap()
}

fn operator() -> ResumeOptions {
    ResumeOptions {
        trust: Trust::Operator,
        ..ResumeOptions::default()
    }
}

/// Runs text from a state, and gives the state before each line.
fn states(text: &str, start: State) -> Vec<State> {
    let mut state = start;
    let mut all = vec![state.clone()];
    for (i, line) in text.lines().enumerate() {
        let mut events = Vec::new();
        interpret_line(&mut state, &significant(line), i + 1, &mut events).unwrap();
        all.push(state.clone());
    }
    all
}

const SQUARE: &str =
    "G21 G90\nM3 S8000\nG0 Z10\nG0 X0 Y0\nG1 Z-1 F200\nG1 X20 F800\nY20\nX0\nY0\nG0 Z10\nM5\nM30\n";

/// On the path of SQUARE: machine coordinates of work X10 Y0 Z-1.
const ON_PATH: [f64; 3] = [-90.0, -90.0, -61.0];
