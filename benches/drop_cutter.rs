//! `cargo bench --bench drop_cutter`: points a second and core, row by row and at random, against the number of triangles.
#![allow(
    missing_docs,
    reason = "a bench is a program; what each measures stands in its name"
)]

mod common;

use common::{Height, RADIUS, SIDE, gentle, measure, places, relief, steep, table};
use divan::Bencher;
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
        sum
    };
    measure(bencher, name, triangles, ROWS * ROWS, work);
}

fn at_random(bencher: Bencher, name: &'static str, triangles: usize, height: Height) {
    let cutter = DropCutter::new(&relief(triangles, height), RADIUS);
    let places = places(ROWS * ROWS / 2);
    let work = || {
        let dropped = places.iter().filter_map(|(x, y)| cutter.drop(*x, *y));
        dropped.map(|c| c.center.z).sum::<f64>()
    };
    measure(bencher, name, triangles, places.len(), work);
}

fn all_at_once(bencher: Bencher, name: &'static str, triangles: usize, height: Height) {
    let cutter = DropCutter::new(&relief(triangles, height), RADIUS);
    let places: Vec<Point2> = places(ROWS * ROWS)
        .iter()
        .map(|(x, y)| Point2::new(*x, *y))
        .collect();
    measure(bencher, name, triangles, places.len(), || {
        cutter.drop_many(&places)
    });
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn gentle_rows(b: Bencher, triangles: usize) {
    rows(b, "gentle, row by row", triangles, gentle);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn gentle_at_random(b: Bencher, triangles: usize) {
    at_random(b, "gentle, at random, one by one", triangles, gentle);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn gentle_all_at_once(b: Bencher, triangles: usize) {
    all_at_once(b, "gentle, at random, all at once", triangles, gentle);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn steep_rows(b: Bencher, triangles: usize) {
    rows(b, "steep, row by row", triangles, steep);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn steep_at_random(b: Bencher, triangles: usize) {
    at_random(b, "steep, at random, one by one", triangles, steep);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn steep_all_at_once(b: Bencher, triangles: usize) {
    all_at_once(b, "steep, at random, all at once", triangles, steep);
}

#[divan::bench(args = TRIANGLES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn gentle_building_the_tree(b: Bencher, triangles: usize) {
    let mesh = relief(triangles, gentle);
    let n = mesh.triangles.len();
    measure(b, "gentle, building the tree", triangles, n, || {
        DropCutter::new(&mesh, RADIUS)
    });
}
