//! `cargo bench --bench mill`: the whole way from an STL to a proven program, by the program itself, against the number of
//! triangles and against the cusp height, which sets the grid's size.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "a bench is a program; what each measures stands in its name"
)]

mod common;

use common::{gentle, measure, relief, stl, table};
use divan::Bencher;
use std::process::{Command, Stdio};

const TRIANGLES: [usize; 3] = [10_000, 100_000, 1_000_000];
/// In um.
const SCALLOPS: [usize; 3] = [40, 20, 10];

fn main() {
    divan::main();
    table(
        "mill, ball 6 mm, 65 x 65 mm",
        "triangles at 0.02 mm; or cusps, um, of 100k triangles",
    );
}

fn mill(b: Bencher, row: &'static str, size: usize, triangles: usize, scallop: f64) {
    let dir = tempfile::tempdir().unwrap();
    let part = dir.path().join("part.stl");
    std::fs::write(&part, stl(&relief(triangles, gentle))).unwrap();
    measure(b, row, size, 1, || {
        // Whether it may be milled is not asked here, only how long the answer takes.
        let done = Command::new(env!("CARGO_BIN_EXE_morsemill"))
            .arg("mill")
            .arg(&part)
            .arg("-o")
            .arg(dir.path().join("part.nc"))
            .args(["--up", "+z", "--tool", "ball:6"])
            .args(["--scallop", &scallop.to_string()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .unwrap();
        assert!(matches!(done.code(), Some(0 | 1)), "{done}");
    });
}

#[divan::bench(args = TRIANGLES, sample_count = 1, sample_size = 1)]
fn gentle_by_triangles(b: Bencher, triangles: usize) {
    mill(b, "gentle, by triangles", triangles, triangles, 0.02);
}

#[divan::bench(args = SCALLOPS, sample_count = 1, sample_size = 1)]
fn gentle_by_cusp(b: Bencher, um: usize) {
    mill(b, "gentle, by cusp height", um, 100_000, 1e-3 * um as f64);
}
