//! Spirals: a family of closed loops, each inside the next, becomes one pass.
//!
//! ```text
//!   plain loop k  ---------------------.
//!                                       '-.  rises by one unit over the last stretch of the turn,
//!   loop k + 1    -----------------------  '---- seam: where loop k + 1 begins
//! ```
//!
//! The rise from loop k to loop k + 1 lies beside that from loop k - 1 to loop k, so that neighbouring turns are one unit apart there as
//! well as everywhere else. Spread over the whole turn it would cost half the outermost loop more (that one has to be closed); spread
//! over a few stepovers it costs half of those, bends no more than the machine takes, and nothing is cut twice on the way. Loops so short
//! that the stretch is half of them do spread it all round.
//!
//! Works in plan: the spiral is dropped and proven like any pass. Passes in and out, mm.

use crate::geom::{Point2, Vector2, nearest_on_segment};
use crate::toolpath::fit::{resample, smooth};

/// A level curve in plan, and which level it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Leveled {
    /// Index of its level in the feature.
    pub level: usize,
    /// Its points.
    pub points: Vec<Point2>,
    /// It returns to its first point (which is not repeated).
    pub closed: bool,
}

/// Shape of spirals, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpiralOptions {
    /// Flat stepover of the job.
    pub stepover: f64,
    /// Points along a spiral are this far apart.
    pub gap: f64,
}

/// A rise is spread over this many stepovers.
const RISE: f64 = 8.0;
/// ... but over no more than this share of its loop.
const SHARE: f64 = 0.5;
/// Loops further apart than this many stepovers anywhere are not joined.
const APART: f64 = 2.5;
/// So many of the innermost turns get points so many times closer.
const TIGHT: usize = 3;
const FINER: f64 = 3.0;
/// Points of a loop that are asked how far the other is.
const ASKED: usize = 96;
/// The seam lies where the outermost loop is straightest over this many stepovers to either side.
const STRAIGHT: f64 = 4.0;

/// Joins families of loops of one feature (levels rising) into spirals; everything else is handed on as it came, a spiral in the place of
/// its innermost loop. Cost: a hundred distances to each point of each loop.
pub fn spirals(curves: Vec<Leveled>, options: &SpiralOptions) -> Vec<Leveled> {
    let next = followers(&curves, options);
    let mut is_next = vec![false; curves.len()];
    for n in next.iter().flatten() {
        is_next[*n] = true;
    }
    let mut left: Vec<Option<Leveled>> = curves.into_iter().map(Some).collect();
    let mut out = Vec::with_capacity(left.len());
    for (i, _) in is_next.iter().enumerate().filter(|n| !n.1) {
        let mut family: Vec<Leveled> = Vec::new();
        let mut at = Some(i);
        while let Some(k) = at {
            family.extend(left[k].take());
            at = next[k];
        }
        if family.len() < 2 {
            out.append(&mut family);
            continue;
        }
        let level = family[0].level;
        let points = spiral(family.into_iter().map(|l| l.points).collect(), options);
        out.push(Leveled {
            level,
            points,
            closed: false,
        });
    }
    out
}

/// The loop of the next level that each loop goes on to: the only one that is near all round, and has no other before it.
fn followers(curves: &[Leveled], options: &SpiralOptions) -> Vec<Option<usize>> {
    let is_loop = |c: &Leveled| c.closed && c.points.len() > 7;
    let mut next: Vec<Option<usize>> = vec![None; curves.len()];
    let mut taken = vec![false; curves.len()];
    for i in 0..curves.len() {
        if !is_loop(&curves[i]) {
            continue;
        }
        let found = (0..curves.len()).find(|&j| {
            curves[j].level == curves[i].level + 1
                && !taken[j]
                && is_loop(&curves[j])
                && beside(
                    &curves[i].points,
                    &curves[j].points,
                    APART * options.stepover,
                )
        });
        if let Some(j) = found {
            taken[j] = true;
            next[i] = Some(j);
        }
    }
    next
}

/// Whether two loops are within `far` of one another all round.
fn beside(a: &[Point2], b: &[Point2], far: f64) -> bool {
    let near = |a: &[Point2], b: &[Point2]| {
        let step = a.len().div_ceil(ASKED).max(1);
        a.iter()
            .step_by(step)
            .all(|p| b.iter().any(|q| (q - p).norm_squared() <= far * far))
    };
    // The first says no soonest for loops that lie elsewhere.
    near(a, b) && near(b, a)
}

/// One open curve through loops of rising level.
fn spiral(mut loops: Vec<Vec<Point2>>, options: &SpiralOptions) -> Vec<Point2> {
    for l in &mut loops {
        if area(l) < 0.0 {
            l.reverse();
        }
    }
    // Towards the seed the nearest point is down the field, and never on a corner: the seam runs inwards.
    let mut seam = loops.last().map_or(Point2::origin(), |l| {
        straightest(l, STRAIGHT * options.stepover)
    });
    for l in loops.iter_mut().rev() {
        seam = begin_at(l, &seam);
    }
    let mut out: Vec<Point2> = Vec::new();
    // Points of the innermost turns.
    let mut tight = 0;
    for k in 0..loops.len() {
        if k == TIGHT {
            tight = out.len();
        }
        let here = &loops[k];
        let along = lengths(here);
        let total = along[along.len() - 1];
        let rise = (RISE * options.stepover).min(SHARE * total);
        let from = along.partition_point(|s| *s < total - rise);
        if k == 0 {
            // What the first rise leaves inside of it.
            out.extend(here.iter().skip(from));
        }
        let Some(above) = loops.get(k + 1) else {
            out.extend(here);
            out.extend(here.first());
            break;
        };
        out.extend(here.iter().take(from));
        for (p, s) in here.iter().zip(&along).skip(from) {
            let u = 1.0 - (total - s) / rise;
            let q = nearest(above, p).0;
            out.push(p + (q - p) * (u * u * (3.0 - 2.0 * u)));
        }
    }
    // The innermost turns are as tight as the grid they were found on: more points there, and rounder.
    let (inner, outer) = out.split_at(tight.min(out.len()));
    let mut even = resample(inner, false, options.gap / FINER);
    smooth(&mut even, false, 8);
    even.extend(resample(outer, false, options.gap));
    smooth(&mut even, false, 2);
    even
}

/// Twice the signed area.
fn area(l: &[Point2]) -> f64 {
    let n = l.len();
    (0..n)
        .map(|i| {
            let (a, b) = (l[i], l[(i + 1) % n]);
            a.x * b.y - a.y * b.x
        })
        .sum()
}

/// Distance along a loop of each of its points, and its whole length behind them.
fn lengths(l: &[Point2]) -> Vec<f64> {
    let mut out = Vec::with_capacity(l.len() + 1);
    let mut sum = 0.0;
    for i in 0..l.len() {
        out.push(sum);
        sum += (l[(i + 1) % l.len()] - l[i]).norm();
    }
    out.push(sum);
    out
}

/// The place of a loop that bends least within `reach` to either side of it (the first on a tie).
fn straightest(l: &[Point2], reach: f64) -> Point2 {
    let n = l.len();
    let gap = lengths(l)[n] / n as f64;
    let k = ((reach / gap).round() as usize).clamp(1, (n / 4).max(1));
    let bend = |i: usize| {
        let (p, q, r) = (l[(i + n - k) % n], l[i], l[(i + k) % n]);
        let (u, v): (Vector2, Vector2) = (q - p, r - q);
        (u.x * v.y - u.y * v.x).atan2(u.dot(&v)).abs()
    };
    // What lies in the middle of the stretch counts too: a corner hides between two far points.
    let worst = |i: usize| {
        let near = (1..k)
            .step_by((k / 4).max(1))
            .flat_map(|d| [i + d, i + n - d]);
        near.map(|j| {
            let j = j % n;
            let (u, v): (Vector2, Vector2) = (l[j] - l[(j + n - 1) % n], l[(j + 1) % n] - l[j]);
            (u.x * v.y - u.y * v.x).atan2(u.dot(&v)).abs() * 0.5 * k as f64
        })
        .fold(bend(i), f64::max)
    };
    (0..n)
        .map(|i| (worst(i), i))
        .reduce(|a, b| if b.0 < a.0 { b } else { a })
        .map_or(l[0], |(_, i)| l[i])
}

/// Makes a loop begin at its place nearest to a point, and returns that.
fn begin_at(l: &mut Vec<Point2>, at: &Point2) -> Point2 {
    let (place, i) = nearest(l, at);
    let n = l.len();
    l.rotate_left((i + 1) % n);
    // Two points on one spot would be a corner of nothing.
    if let Some(first) = l.first_mut()
        && (*first - place).norm() < 1e-6
    {
        *first = place;
    } else {
        l.insert(0, place);
    }
    if l.len() > 3 && l.last().is_some_and(|p| (p - place).norm() < 1e-6) {
        l.pop();
    }
    place
}

/// The nearest place on a loop, and the point behind which it lies.
fn nearest(l: &[Point2], at: &Point2) -> (Point2, usize) {
    let n = l.len();
    let mut best = (f64::INFINITY, l[0], 0);
    for i in 0..n {
        let (a, b) = (l[i], l[(i + 1) % n]);
        let q = nearest_on_segment(at, &a, &b);
        let d = (at - q).norm_squared();
        if d < best.0 {
            best = (d, q, i);
        }
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn circle(level: usize, r: f64) -> Leveled {
        let n = (r * TAU / 0.1).ceil() as usize;
        Leveled {
            level,
            points: (0..n)
                .map(|k| {
                    let a = TAU * k as f64 / n as f64;
                    Point2::new(r * a.cos(), r * a.sin())
                })
                .collect(),
            closed: true,
        }
    }

    const HOW: SpiralOptions = SpiralOptions {
        stepover: 0.7,
        gap: 0.1,
    };

    fn length(p: &[Point2]) -> f64 {
        p.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
    }

    #[test]
    fn circles_become_one_pass_that_leaves_no_gap_wider_than_theirs() {
        let radii: Vec<f64> = (0..20).map(|k| 0.7 * (k as f64 + 0.5)).collect();
        let loops: Vec<Leveled> = radii
            .iter()
            .enumerate()
            .map(|(k, r)| circle(k, *r))
            .collect();
        let out = spirals(loops, &HOW);
        assert_eq!(out.len(), 1);
        let path = &out[0].points;
        assert!(!out[0].closed);
        // No place inside is further from the path than half a stepover and a little.
        for i in 0..2000 {
            let (r, a) = (13.6 * (i as f64 / 2000.0).sqrt(), 2.4 * i as f64);
            let p = Point2::new(r * a.cos(), r * a.sin());
            let d = path
                .iter()
                .map(|q| (q - p).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(d < 0.35 * 1.04 + 0.01, "{d} at {r}");
        }
        // Longer than the loops by a stretch at either end, and by the little that the rises of small loops lie closer.
        let sum: f64 = radii.iter().map(|r| TAU * r).sum();
        let l = length(path);
        assert!(l > sum && l < 1.02 * sum, "{l} {sum}");
        // It nowhere bends tighter than the innermost loop but for the rounding of the rise.
        let worst = path
            .windows(3)
            .map(|w| crate::toolpath::link::turn::bend(&(w[1] - w[0]), &(w[2] - w[1])))
            .skip(30)
            .fold(0.0, f64::max);
        assert!(worst < 0.1 / 0.3, "{worst}");
    }

    #[test]
    fn loops_that_part_are_two_families_and_open_curves_stay() {
        let shifted = |mut l: Leveled, x: f64| {
            l.points.iter_mut().for_each(|p| p.x += x);
            l
        };
        let open = Leveled {
            level: 2,
            points: vec![Point2::new(0.0, 50.0), Point2::new(9.0, 50.0)],
            closed: false,
        };
        let curves = vec![
            circle(0, 3.0),
            shifted(circle(0, 3.0), 20.0),
            circle(1, 3.7),
            shifted(circle(1, 3.7), 20.0),
            open.clone(),
        ];
        let out = spirals(curves, &HOW);
        assert_eq!(out.len(), 3);
        assert_eq!(out[2], open);
        // A loop far outside is none of the family.
        let out = spirals(vec![circle(0, 3.0), circle(1, 6.0)], &HOW);
        assert!(out.len() == 2 && out.iter().all(|l| l.closed));
    }
}
