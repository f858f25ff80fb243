//! `cargo bench --bench drop_cutter`: points a second and core, row by row and at random, against the number of triangles.
#![allow(
    missing_docs,
    reason = "a bench is a program; what each measures stands in its name"
)]

mod common;

use common::{Height, RADIUS, SIDE, gentle, measure, places, relief, steep, table};
use divan::{Bencher, black_box};
use morsemill::geom::Point2;
use morsemill::reach::{DropCutter, Hint};

const TRIANGLES: [usize; 3] = [10_000, 100_000, 1_000_000];
/// Points a side.
const ROWS: usize = 500;

fn main() {
    divan::main();
    table("drop cutter, ball 6 mm, 65 x 65 mm", "triangles");
}

fn rows(bencher: Bencher, name: &'static str, triangles: usize, height: Height) {
    let cutter = DropCutter::new(&relief(triangles, height), RADIUS);
    let at = |i: usize| SIDE * (i as f64 + 0.5) / ROWS as f64;
    let work = || {
        let mut sum = 0.0;
        for y in 0..ROWS {
            let mut hint = Hint::default();
            for x in 0..ROWS {
                sum += cutter
                    .drop_near(at(x), at(y), &mut hint)
                    .map_or(0.0, |c| c.center.z);
            }
        }
        black_box(sum)
    };
    bencher.bench_local(|| measure(name, triangles, ROWS * ROWS, work));
}

fn at_random(bencher: Bencher, name: &'static str, triangles: usize, height: Height) {
    let cutter = DropCutter::new(&relief(triangles, height), RADIUS);
    let places = places(ROWS * ROWS / 2);
    let work = || {
        let sum: f64 = places
            .iter()
            .filter_map(|(x, y)| cutter.drop(*x, *y))
            .map(|c| c.center.z)
            .sum();
        black_box(sum)
    };
    bencher.bench_local(|| measure(name, triangles, places.len(), work));
}

fn all_at_once(bencher: Bencher, name: &'static str, triangles: usize, height: Height) {
    let cutter = DropCutter::new(&relief(triangles, height), RADIUS);
    let places: Vec<Point2> = places(ROWS * ROWS)
        .iter()
        .map(|(x, y)| Point2::new(*x, *y))
        .collect();
    let work = || black_box(cutter.drop_all(&places)).len();
    bencher.bench_local(|| measure(name, triangles, places.len(), work));
}

#[divan::bench(args = TRIANGLES, sample_count = 3, sample_size = 1)]
fn gentle_rows(b: Bencher, triangles: usize) {
    rows(b, "gentle, row by row", triangles, gentle);
}

#[divan::bench(args = TRIANGLES, sample_count = 3, sample_size = 1)]
fn gentle_at_random(b: Bencher, triangles: usize) {
    at_random(b, "gentle, at random, one by one", triangles, gentle);
}

#[divan::bench(args = TRIANGLES, sample_count = 3, sample_size = 1)]
fn gentle_all_at_once(b: Bencher, triangles: usize) {
    all_at_once(b, "gentle, at random, all at once", triangles, gentle);
}

#[divan::bench(args = TRIANGLES, sample_count = 3, sample_size = 1)]
fn steep_rows(b: Bencher, triangles: usize) {
    rows(b, "steep, row by row", triangles, steep);
}

#[divan::bench(args = TRIANGLES, sample_count = 3, sample_size = 1)]
fn steep_at_random(b: Bencher, triangles: usize) {
    at_random(b, "steep, at random, one by one", triangles, steep);
}

#[divan::bench(args = TRIANGLES, sample_count = 3, sample_size = 1)]
fn steep_all_at_once(b: Bencher, triangles: usize) {
    all_at_once(b, "steep, at random, all at once", triangles, steep);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1)]
fn gentle_building_the_tree(b: Bencher, triangles: usize) {
    let mesh = relief(triangles, gentle);
    let n = mesh.triangles.len();
    b.bench_local(|| {
        measure("gentle, building the tree", triangles, n, || {
            DropCutter::new(&mesh, RADIUS)
        })
    });
}
