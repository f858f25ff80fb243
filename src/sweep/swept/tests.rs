#![allow(clippy::unwrap_used)]
use super::*;
use crate::geom::{Point2, Vector};
use proptest::prelude::*;

/// The underside of one capsule over a place, by golden section over the (convex) parameter: no formula shared.
fn by_search(s: &Segment, x: f64, y: f64, r: f64) -> f64 {
    let f = |t: f64| {
        let c = s.from + (s.to - s.from) * t;
        let d = r * r - (x - c.x).powi(2) - (y - c.y).powi(2);
        if d < 0.0 { None } else { Some(c.z - d.sqrt()) }
    };
    // Parameters for which the place lies under the ball.
    let e = (s.to - s.from).xy();
    let p = Point2::new(x, y) - s.from.xy();
    let (a, b, c) = (e.norm_squared(), -p.dot(&e), p.norm_squared() - r * r);
    let (mut lo, mut hi) = (0.0, 1.0);
    if a > 0.0 {
        let disc = b * b - a * c;
        if disc < 0.0 {
            return f64::INFINITY;
        }
        lo = f64::max(0.0, (-b - disc.sqrt()) / a);
        hi = f64::min(1.0, (-b + disc.sqrt()) / a);
    }
    if lo > hi {
        return f64::INFINITY;
    }
    let g = |t| f(t).unwrap_or(f64::INFINITY);
    let mut best = g(lo).min(g(hi));
    for _ in 0..200 {
        let (m, n) = (lo + (hi - lo) * 0.382, lo + (hi - lo) * 0.618);
        best = best.min(g(m)).min(g(n));
        if g(m) < g(n) { hi = n } else { lo = m }
    }
    best
}

fn compare(segments: &[Segment], r: f64) {
    let lattice = Lattice::covering(Point2::new(-4.0, -4.0), Point2::new(4.0, 4.0), 0.17);
    let mut swept = Swept::new(lattice);
    swept.cut(segments, r);
    for i in 0..lattice.len() {
        let c = lattice.center_at(i);
        let want = segments
            .iter()
            .map(|s| by_search(s, c.x, c.y, r))
            .fold(f64::INFINITY, f64::min);
        let got = swept.z[i];
        // On the very rim of the ball (within 1e-9 mm) the place may count as under it or not.
        let rim = |v: f64| v.is_infinite();
        if rim(got) != rim(want) {
            let near = segments.iter().any(|s| {
                by_search(s, c.x, c.y, r + 1e-9).is_finite()
                    != by_search(s, c.x, c.y, r - 1e-9).is_finite()
            });
            assert!(near, "cell {c:?}: {got} against {want}");
        } else if got.is_finite() {
            assert!(
                (got - want).abs() < 1e-7,
                "cell {c:?}: {got} against {want}, segments {segments:?}"
            );
        }
    }
}

fn point() -> impl Strategy<Value = Point> {
    (-3.0..3.0f64, -3.0..3.0f64, -2.0..2.0f64).prop_map(|(x, y, z)| Point::new(x, y, z))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn chains_equal_the_searched_envelope(points in prop::collection::vec(point(), 2..6), r in 0.3..2.5f64) {
        let s: Vec<Segment> = points.windows(2).map(|w| Segment { from: w[0], to: w[1] }).collect();
        compare(&s, r);
    }

    #[test]
    fn fine_smooth_chains_equal_the_searched_envelope(start in point(), turn in -0.3..0.3f64, rise in -2.0..2.0f64, bend in -0.2..0.2f64) {
        let mut p = start;
        let (mut a, mut v) = (1.0f64, rise);
        let mut s = Vec::new();
        for _ in 0..12 {
            let q = p + Vector::new(a.cos(), a.sin(), v) * 0.1;
            s.push(Segment { from: p, to: q });
            p = q;
            a += turn;
            v += bend;
        }
        compare(&s, 1.5);
    }
}

#[test]
fn upright_standing_and_broken_segments() {
    let p = Point::new(0.3, -0.2, 1.0);
    let q = Point::new(0.3, -0.2, -1.0);
    let e = Point::new(1.3, 0.4, -1.0);
    compare(&[Segment { from: p, to: q }], 1.0);
    compare(&[Segment { from: q, to: p }], 1.0);
    compare(&[Segment { from: p, to: p }], 1.0);
    compare(
        &[
            Segment { from: p, to: p },
            Segment { from: p, to: q },
            Segment { from: q, to: q },
            Segment { from: q, to: e },
            Segment { from: e, to: q },
            Segment { from: p, to: e },
        ],
        1.0,
    );
    let near = Point::new(0.3 + 1e-7, -0.2, -1.0);
    compare(&[Segment { from: p, to: near }], 1.0);
    let mut swept = Swept::new(Lattice::covering(
        Point2::new(0.0, 0.0),
        Point2::new(1.0, 1.0),
        0.1,
    ));
    let nan = Point::new(f64::NAN, 0.0, 0.0);
    swept.cut(&[Segment { from: p, to: nan }], 1.0);
    swept.cut(&[Segment { from: p, to: q }], f64::NAN);
    assert!(swept.z.iter().all(|z| *z == f64::INFINITY));
}

/// Two parallel passes at stepover w leave R - sqrt(R^2 - w^2/4) half way, and nothing on the passes.
#[test]
fn cusp_of_two_parallel_passes() {
    let (r, w): (f64, f64) = (3.0, 0.7);
    let lattice = Lattice::covering(Point2::new(-1.0, 0.0), Point2::new(1.0, w), w / 2.0);
    let pass = |y: f64| Segment {
        from: Point::new(-5.0, y, r),
        to: Point::new(5.0, y, r),
    };
    let mut swept = Swept::new(lattice);
    swept.cut(&[pass(0.0), pass(w)], r);
    let cusp = r - (r * r - w * w / 4.0).sqrt();
    for i in 0..lattice.len() {
        let (_, iy) = lattice.cell(i);
        let want = if iy == 1 { cusp } else { 0.0 };
        assert!((swept.z[i] - want).abs() < 1e-12);
    }
}

#[test]
fn encounter_names_the_deepest_place() {
    let lattice = Lattice::covering(Point2::new(-5.0, -5.0), Point2::new(5.0, 5.0), 0.1);
    let swept = Swept::new(lattice);
    let stock = vec![2.0; lattice.len()];
    let s = |z: f64| Segment {
        from: Point::new(-3.0, 0.0, z),
        to: Point::new(3.0, 0.0, z),
    };
    assert_eq!(swept.encounter(&stock, s(5.001), 3.0, 1e-6), None);
    let e = swept.encounter(&stock, s(4.75), 3.0, 1e-6).unwrap();
    assert!((e.depth - 0.25).abs() < 1e-9 && e.place.y.abs() < 1e-9 && e.place.z == 2.0);
    // Once cut, the same move meets nothing.
    let mut swept = swept;
    swept.cut(&[s(4.75)], 3.0);
    assert_eq!(swept.encounter(&stock, s(4.75), 3.0, 1e-6), None);
    assert!(swept.encounter(&stock, s(4.70), 3.0, 1e-6).is_some());
}

fn spiral(n: usize, step: f64) -> Vec<Segment> {
    let at = |k: usize| {
        let k = k as f64;
        let theta = (4.0 * std::f64::consts::PI * k * step / 0.7).sqrt();
        let rho = 0.7 * theta / std::f64::consts::TAU;
        let (x, y) = (rho * theta.cos(), rho * theta.sin());
        Point::new(x, y, 4.0 * (x * 0.15).sin() * (y * 0.13).cos())
    };
    (0..n)
        .map(|k| Segment {
            from: at(k),
            to: at(k + 1),
        })
        .collect()
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let lattice = Lattice::covering(Point2::new(-20.0, -20.0), Point2::new(20.0, 20.0), 0.2);
    let s = spiral(3000, 0.25);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut w = Swept::new(lattice);
        pool.install(|| w.cut(&s, 3.0));
        w.z.iter().map(|z| z.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(3));
}
