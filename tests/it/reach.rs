//! Laws of the tool-centre surface: no ball enters the part, and the cusp metric is never negative.
#![allow(clippy::unwrap_used)]

use super::common::{Brute, Chance, PARTS, Shipped, noisy, sheet, soup};
use morsemill::part::Mesh;
use morsemill::reach::{DropCutter, GridOptions, GridPlan, NodeKind, ToolCentreGrid};
use rayon::prelude::*;

fn grid(mesh: &Mesh, radius: f64, step: f64) -> ToolCentreGrid {
    let cutter = DropCutter::new(mesh, radius);
    let how = GridOptions {
        step,
        memory_limit_bytes: 1 << 30,
    };
    ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap()
}

/// The deepest any ball of the grid enters the part, every `stride`-th node; also that each touches it.
fn deepest(mesh: &Mesh, grid: &ToolCentreGrid, stride: usize) -> f64 {
    let brute = Brute::new(mesh);
    (0..grid.len())
        .into_par_iter()
        .filter(|i| i % stride == 0 && grid.kind[*i] != NodeKind::Air)
        .map(|i| {
            let c = grid.center(i);
            let d = brute.depth(&c, grid.radius);
            // It rests: a ball a micrometre thicker would enter.
            assert!(
                brute.depth(&c, grid.radius + 1e-3) > 0.5e-3,
                "the ball at {c} touches nothing"
            );
            d
        })
        .reduce(|| 0.0, f64::max)
}

#[test]
fn no_ball_of_the_grid_enters_a_random_soup() {
    for seed in 0..24u64 {
        let mesh = soup(seed, 20 + 15 * seed as usize);
        let radius = [0.4, 1.0, 2.5][seed as usize % 3];
        let d = deepest(&mesh, &grid(&mesh, radius, 0.31), 1);
        assert!(
            d < 1e-7,
            "soup {seed}, ball radius {radius}: {} um deep",
            1e3 * d
        );
    }
}

#[test]
fn no_ball_of_the_grid_enters_a_sheet() {
    type Height = fn(f64, f64) -> f64;
    let shapes: [(&str, Height); 4] = [
        ("egg box, tighter than the ball", |x, y| {
            1.2 * (1.7 * x).sin() * (1.3 * y).cos()
        }),
        ("roof", |x, y| 3.0 - (x - 5.0).abs() - 0.3 * y),
        ("steps", |x, y| (x * 0.8).floor() + (y * 0.5).floor()),
        ("noise", |x, y| {
            0.4 * Chance(x.to_bits() ^ y.to_bits().rotate_left(31)).between(-1.0, 1.0)
        }),
    ];
    for (name, f) in shapes {
        let mesh = sheet([0.0, 0.0], [10.0, 9.0], [60, 54], f);
        for radius in [0.5, 3.0] {
            let d = deepest(&mesh, &grid(&mesh, radius, 0.19), 1);
            assert!(
                d < 1e-7,
                "{name}, ball radius {radius}: {} um deep",
                1e3 * d
            );
        }
    }
}

#[test]
fn no_ball_of_the_grid_enters_a_shipped_part() {
    for part in PARTS {
        let mesh = part.mesh();
        let d = deepest(&mesh, &grid(&mesh, 3.0, 0.3), 1);
        assert!(d < 1e-7, "{}: {} um deep", part.file, 1e3 * d);
    }
}

/// The identity and the sign, for any two contacts; the lowest product found, relative to R^2.
fn products(mesh: &Mesh, radius: f64, seed: u64, pairs: usize) -> f64 {
    let cutter = DropCutter::new(mesh, radius);
    let b = mesh.bounds();
    let mut chance = Chance(seed);
    let mut lowest = f64::INFINITY;
    for k in 0..pairs {
        let x = chance.between(b.min.x - radius, b.max.x + radius);
        let y = chance.between(b.min.y - radius, b.max.y + radius);
        // Half of the pairs are neighbours, as in the metric; the others are anywhere.
        let far = if k % 2 == 0 { 0.1 * radius } else { 20.0 };
        let (u, v) = (x + chance.between(-far, far), y + chance.between(-far, far));
        let (Some(a), Some(b)) = (cutter.drop(x, y), cutter.drop(u, v)) else {
            continue;
        };
        let twice = 2.0 * (b.point - a.point).dot(&(b.center - a.center));
        let by_distances = (a.center - b.point).norm_squared()
            + (b.center - a.point).norm_squared()
            - 2.0 * radius * radius;
        let scale = radius * radius + (b.center - a.center).norm_squared();
        assert!(
            (twice - by_distances).abs() < 1e-9 * scale,
            "seed {seed}: {twice} is not {by_distances}"
        );
        assert!(
            twice > -1e-9 * scale,
            "seed {seed}: dp.dc = {} between ({x}, {y}) and ({u}, {v})",
            twice / 2.0
        );
        lowest = lowest.min(twice / (radius * radius));
    }
    lowest
}

#[test]
fn the_cusp_metric_is_never_negative() {
    for seed in 0..40u64 {
        let mesh = soup(1000 + seed, 10 + 12 * seed as usize);
        products(&mesh, [0.3, 1.0, 3.0][seed as usize % 3], seed, 2000);
    }
    for (k, part) in PARTS.iter().enumerate() {
        products(&part.mesh(), 3.0, 77 + k as u64, 8000);
    }
    // A scan with bumps far smaller than the ball, where contacts hop most.
    let rough = noisy(&Shipped::mesh(&PARTS[0]), 0.02, 5);
    products(&rough, 3.0, 99, 8000);
}
