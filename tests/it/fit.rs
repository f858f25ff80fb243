//! Laws of the proof: it is never kinder than brute force over all triangles, on any soup.
#![allow(clippy::unwrap_used)]

use super::common::{Brute, Chance, along, soup};
use morsemill::geom::{Point, Point2};
use morsemill::reach::{DropCutter, Hint};
use morsemill::toolpath::curve::Curve;
use morsemill::toolpath::fit::prove::examine;
use morsemill::toolpath::{FitOptions, Turn};

/// Budgets that are never kept: the proof goes as deep as it can.
fn unforgiving(radius: f64) -> FitOptions {
    FitOptions {
        gouge: 1e-6,
        stock: 1e-6,
        ..FitOptions::for_scallop(0.02, radius)
    }
}

#[test]
fn the_proof_is_never_kinder_than_brute_force() {
    let radius = 1.5;
    for seed in 1..=6 {
        let mesh = soup(seed, 120);
        let brute = Brute::new(&mesh);
        let cutter = DropCutter::new(&mesh, radius);
        let b = mesh.bounds();
        let mut chance = Chance(seed);
        let mut hint = Hint::default();
        for k in 0..60 {
            let mut end = |near: Option<Point>| loop {
                let (x, y) = match near {
                    Some(p) => (
                        p.x + chance.between(-2.0, 2.0),
                        p.y + chance.between(-2.0, 2.0),
                    ),
                    None => (
                        chance.between(b.min.x, b.max.x),
                        chance.between(b.min.y, b.max.y),
                    ),
                };
                if let Some(c) = cutter.drop(x, y) {
                    break c.center;
                }
            };
            let from = end(None);
            let to = end(Some(from));
            let arc = Turn {
                center: Point2::new(
                    0.5 * (from.x + to.x) + 0.4 * (to.y - from.y),
                    0.5 * (from.y + to.y) - 0.4 * (to.x - from.x),
                ),
                clockwise: k % 4 < 2,
            };
            let curve = if k % 2 == 0 {
                Curve::line(from, to)
            } else {
                Curve::arc(from, to, &arc, 0.0)
            };
            let p = examine(&cutter, &curve, &unforgiving(radius), true, true, &mut hint);
            let n = (curve.length() / 0.004).ceil() as usize;
            let deepest = (0..=n)
                .map(|i| brute.depth(&curve.at(curve.length() * i as f64 / n as f64), radius))
                .fold(0.0, f64::max);
            assert!(
                p.gouge >= deepest - 1e-6,
                "seed {seed}, {k}: {} proven, {deepest} there",
                p.gouge
            );
        }
        assert!(along(&Point::origin(), &Point::new(1.0, 0.0, 0.0), 0.5).count() == 3);
    }
}
