//! `cargo bench --bench sweep`: what a raster leaves standing - the sweep, the reachable surface and the judging - per cell.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "a bench is a program; what each measures stands in its name"
)]

mod common;

use common::{RADIUS, SIDE, gentle, measure, relief, table};
use divan::Bencher;
use morsemill::geom::Point;
use morsemill::reach::{DropCutter, Hint};
use morsemill::sweep::{FinishOptions, Segment, Swept, finish, reachable};

/// Cells, about.
const CELLS: [usize; 3] = [100_000, 400_000, 1_600_000];
const SCALLOP: f64 = 0.02;

fn main() {
    divan::main();
    table("sweep, 100k triangles, raster 0.6 mm apart", "cells");
}

fn step(cells: usize) -> f64 {
    (SIDE + 2.0 * RADIUS) / (cells as f64).sqrt()
}

/// A raster of exact drops, a point every 0.5 mm.
fn raster(cutter: &DropCutter) -> Vec<Segment> {
    let mut out = Vec::new();
    for row in 0..(SIDE / 0.6) as usize {
        let mut hint = Hint::default();
        let mut last: Option<Point> = None;
        for k in 0..=(SIDE / 0.5) as usize {
            let next = cutter
                .drop_near(0.5 * k as f64, 0.6 * row as f64, &mut hint)
                .map(|c| c.center);
            if let (Some(from), Some(to)) = (last, next) {
                out.push(Segment { from, to });
            }
            last = next;
        }
    }
    out
}

fn cutter() -> DropCutter {
    DropCutter::new(&relief(100_000, gentle), RADIUS)
}

#[divan::bench(args = CELLS, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn reachable_surface(b: Bencher, cells: usize) {
    let cutter = cutter();
    measure(b, "reachable surface", cells, cells, || {
        reachable(&cutter, step(cells))
    });
}

#[divan::bench(args = CELLS, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn cutting(b: Bencher, cells: usize) {
    let cutter = cutter();
    let segments = raster(&cutter);
    let lattice = reachable(&cutter, step(cells)).lattice;
    measure(b, "sweeping the ball", cells, lattice.len(), || {
        let mut swept = Swept::new(lattice);
        swept.cut(&segments, RADIUS);
        swept
    });
}

#[divan::bench(args = CELLS, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn judging(b: Bencher, cells: usize) {
    let cutter = cutter();
    let segments = raster(&cutter);
    let reach = reachable(&cutter, step(cells));
    let mut swept = Swept::new(reach.lattice);
    swept.cut(&segments, RADIUS);
    let options = FinishOptions::for_scallop(SCALLOP);
    measure(b, "judging cusps", cells, swept.z.len(), || {
        finish(&reach, &swept, &segments, &options).unwrap()
    });
}
