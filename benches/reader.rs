//! `cargo bench --bench reader`: lines a second and core of plain `G1 X.. Y.. Z..` programs, streamed from memory and from a file, against
//! the number of lines. The bar: 2,000,000 lines a second on one idle core.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "a bench is a program; what each measures stands in its name"
)]

mod common;

use common::{measure, places, table};
use divan::Bencher;
use morsemill::gcode::{Dialect, Event, Interpreter};
use std::fmt::Write;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Seek};

const LINES: [usize; 2] = [100_000, 1_000_000];

fn main() {
    divan::main();
    table("reader, G1 X.. Y.. Z.., a line", "lines");
}

/// A program of so many moves, as a post for relief work writes them.
fn program(lines: usize) -> String {
    let mut text = String::from("G21 G90 G94 F1000\n");
    for (i, (x, y)) in places(lines).into_iter().enumerate() {
        let z = -((i % 5000) as f64) / 1000.0;
        writeln!(text, "G1 X{x:.3} Y{y:.3} Z{z:.3}").unwrap();
    }
    text
}

/// Reads everything; the sum keeps the work from being thought away.
fn read<R: BufRead + Seek>(from: R, dialect: Dialect) -> f64 {
    let events = Interpreter::new(from, dialect).unwrap();
    let ends = events.map(|e| match e.unwrap() {
        Event::Motion(m) => m.to.x,
        _ => 0.0,
    });
    ends.sum()
}

fn memory(b: Bencher, name: &'static str, lines: usize, dialect: Dialect) {
    let text = program(lines);
    measure(b, name, lines, lines, || {
        read(Cursor::new(text.as_bytes()), dialect)
    });
}

fn file(b: Bencher, name: &'static str, lines: usize, dialect: Dialect) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("program.nc");
    std::fs::write(&path, program(lines)).unwrap();
    measure(b, name, lines, lines, || {
        read(BufReader::new(File::open(&path).unwrap()), dialect)
    });
}

#[divan::bench(args = LINES, sample_count = 3, sample_size = 1, min_time = 0.3)]
fn grbl_memory(b: Bencher, lines: usize) {
    memory(b, "grbl, memory", lines, Dialect::Grbl);
}

#[divan::bench(args = LINES, sample_count = 3, sample_size = 1, min_time = 0.3)]
fn linuxcnc_memory(b: Bencher, lines: usize) {
    memory(b, "linuxcnc, memory", lines, Dialect::LinuxCnc);
}

#[divan::bench(args = LINES, sample_count = 3, sample_size = 1, min_time = 0.3)]
fn fanuc_memory(b: Bencher, lines: usize) {
    memory(b, "fanuc, memory", lines, Dialect::Fanuc);
}

#[divan::bench(args = LINES, sample_count = 3, sample_size = 1, min_time = 0.3)]
fn linuxcnc_file(b: Bencher, lines: usize) {
    file(b, "linuxcnc, file", lines, Dialect::LinuxCnc);
}
