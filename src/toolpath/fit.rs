//! Fitting: a curve in plan, dropped onto the part, as few straight segments as its tolerances allow.
//!
//! A chord over convex ground cuts into the part, over concave ground it leaves stock; so the error of a chord has a sign, measured
//! along the contact normal, and the two sides have budgets of their own:
//!
//! ```text
//!      c1 ----------- c2      convex ground: the chord is below the tool-centre surface (gouge, small budget)
//!        '-._______.-'
//!      c1 ___________ c2      concave ground: the chord is above it (stock)
//! ```
//!
//! Every segment that comes out has been dropped along its whole length, not only at its ends; between the probes lie at most
//! [`FitOptions::probe`] mm.

use crate::geom::{Point, Point2, Vector};
use crate::reach::{DropCutter, Hint};

/// Tolerances of the fit, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// How deep a chord may cut, along the normal.
    pub gouge: f64,
    /// How much stock a chord may leave, along the normal.
    pub stock: f64,
    /// How far a chord may stray sideways from its curve.
    pub sideways: f64,
    /// Distance between two probes of a segment.
    pub probe: f64,
    /// Longest segment.
    pub longest: f64,
}

impl FitOptions {
    /// Tolerances that keep a finish of `scallop` mm what it is: small beside the cusp, large beside the program's last decimal.
    pub fn for_scallop(scallop: f64, radius: f64) -> FitOptions {
        // Probes, rounding and the judge's own grain add up to 1.5 um more, and 3 um is what a finish is allowed in all.
        let g = (0.06 * scallop).clamp(0.0006, 0.0015);
        FitOptions {
            gouge: g,
            stock: 1.25 * g,
            sideways: 3.0 * g,
            probe: (8.0 * radius * 2.0 * g).sqrt() * 0.5,
            longest: radius,
        }
    }
}

/// A place of the ball on the part, with the contact normal.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    /// Centre of the ball, work coordinates, mm.
    pub center: Point,
    /// Unit vector from the contact to the centre.
    pub normal: Vector,
}

/// Lowers the ball at a place in plan.
pub fn rest(cutter: &DropCutter, x: f64, y: f64, hint: &mut Hint) -> Option<Rest> {
    let c = cutter.drop_near(x, y, hint)?;
    let n = c.center - c.point;
    let l = n.norm();
    let normal = if l > 0.0 { n / l } else { Vector::z() };
    Some(Rest {
        center: c.center,
        normal,
    })
}

/// Below this length a height difference is a cliff, not a slope: the tool goes up (or down) there on the spot.
const CLIFF_RUN: f64 = 0.004;

/// Drops a curve onto the part and fits it: runs of ball centres, split where the ball would fall past the part.
pub fn fit(cutter: &DropCutter, curve: &[Point2], options: &FitOptions) -> Vec<Vec<Point>> {
    let mut hint = Hint::default();
    let mut runs: Vec<Vec<Rest>> = Vec::new();
    let mut run: Vec<Rest> = Vec::new();
    for q in curve {
        match rest(cutter, q.x, q.y, &mut hint) {
            Some(r) => {
                if let Some(last) = run.last().copied()
                    && !densify(cutter, &last, &r, options, &mut hint, &mut run)
                {
                    runs.push(std::mem::take(&mut run));
                }
                run.push(r);
            }
            None => {
                runs.push(std::mem::take(&mut run));
            }
        }
    }
    runs.push(run);
    runs.into_iter()
        .filter(|r| !r.is_empty())
        .map(|r| prove(cutter, &simplify(&r, options), options))
        .collect()
}

/// Adds what is needed between two rests so that a chord nowhere misses the surface by more than the tolerances; false when the ball
/// falls past the part on the way.
fn densify(
    cutter: &DropCutter,
    a: &Rest,
    b: &Rest,
    options: &FitOptions,
    hint: &mut Hint,
    out: &mut Vec<Rest>,
) -> bool {
    // Depth first, nearer half first: the rests come out in order. Length halves each time, so the stack stays short.
    let mut stack = vec![(*a, *b)];
    while let Some((a, b)) = stack.pop() {
        let run = (b.center.xy() - a.center.xy()).norm();
        let mid = nalgebra::center(&a.center, &b.center);
        let Some(m) = rest(cutter, mid.x, mid.y, hint) else {
            return false;
        };
        let miss = m.normal.dot(&(mid - m.center));
        let good =
            miss >= -0.5 * options.gouge && miss <= 0.5 * options.stock && run <= options.probe;
        if !good && run > CLIFF_RUN {
            stack.push((m, b));
            stack.push((a, m));
            continue;
        }
        let rise = b.center.z - a.center.z;
        if !good && rise.abs() > CLIFF_RUN {
            // Up on the spot, then across; or across, then down.
            let from = if rise > 0.0 { &a } else { &b };
            let top = a.center.z.max(b.center.z).max(m.center.z);
            out.push(Rest {
                center: Point::new(from.center.x, from.center.y, top),
                normal: from.normal,
            });
        } else if run > 0.5 * options.probe || !good {
            out.push(m);
        }
        if !stack.is_empty() {
            out.push(b);
        }
    }
    true
}

/// Fewest points by the greedy rule: each chord as long as every rest it skips stays within the tolerances.
fn simplify(rests: &[Rest], options: &FitOptions) -> Vec<Rest> {
    let mut out = vec![rests[0]];
    let mut i = 0;
    while i + 1 < rests.len() {
        let mut j = i + 1;
        // Gallop out, then step back: chords hold a few to a few dozen rests.
        let mut stride = 1;
        while j + stride < rests.len() && chord_holds(&rests[i..=j + stride], options) {
            j += stride;
            stride *= 2;
        }
        while stride > 1 {
            stride /= 2;
            if j + stride < rests.len() && chord_holds(&rests[i..=j + stride], options) {
                j += stride;
            }
        }
        out.push(rests[j]);
        i = j;
    }
    out
}

fn chord_holds(rests: &[Rest], options: &FitOptions) -> bool {
    let (a, b) = (rests[0].center, rests[rests.len() - 1].center);
    let e = b - a;
    let l2 = e.norm_squared();
    if l2 > options.longest * options.longest {
        return false;
    }
    rests[1..rests.len() - 1].iter().all(|r| {
        let s = if l2 > 0.0 {
            ((r.center - a).dot(&e) / l2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let d = a + e * s - r.center;
        let up = d.dot(&r.normal);
        up >= -options.gouge
            && up <= options.stock
            && (d - r.normal * up).norm() <= options.sideways
    })
}

/// Probes each segment along its own line and splits it where it cuts deeper, or stays higher, than allowed.
fn prove(cutter: &DropCutter, rests: &[Rest], options: &FitOptions) -> Vec<Point> {
    let mut hint = Hint::default();
    let mut out = vec![rests[0].center];
    for w in rests.windows(2) {
        prove_segment(
            cutter,
            w[0].center,
            w[1].center,
            options,
            &mut hint,
            &mut out,
            0,
        );
    }
    out
}

fn prove_segment(
    cutter: &DropCutter,
    a: Point,
    b: Point,
    options: &FitOptions,
    hint: &mut Hint,
    out: &mut Vec<Point>,
    depth: usize,
) {
    let run = (b.xy() - a.xy()).norm();
    let n = (run / options.probe).ceil() as usize;
    // The worst place, in tolerances: too deep anywhere, or too high where it is a slope and not a cliff.
    let mut worst: Option<(f64, Point)> = None;
    for k in 1..n {
        let q = a + (b - a) * (k as f64 / n as f64);
        if let Some(r) = rest(cutter, q.x, q.y, hint) {
            let high = (q.z - r.center.z) * r.normal.z;
            let off = if high < 0.0 {
                -high / options.gouge
            } else {
                high / options.stock
            };
            if off > 1.0 && worst.is_none_or(|(w, _)| off > w) {
                worst = Some((off, r.center));
            }
        }
    }
    match worst {
        Some((_, at)) if depth < 12 => {
            prove_segment(cutter, a, at, options, hint, out, depth + 1);
            prove_segment(cutter, at, b, options, hint, out, depth + 1);
        }
        _ => out.push(b),
    }
}

/// Evenly spaced points along a curve, `gap` mm or a little less apart; ends kept. A closed curve comes back without its first point
/// repeated.
pub fn resample(curve: &[Point2], closed: bool, gap: f64) -> Vec<Point2> {
    let mut at: Vec<Point2> = curve.to_vec();
    if closed && let Some(first) = curve.first() {
        at.push(*first);
    }
    let mut along = vec![0.0];
    for w in at.windows(2) {
        along.push(along[along.len() - 1] + (w[1] - w[0]).norm());
    }
    let total = along[along.len() - 1];
    if at.len() < 2 || total <= 0.0 {
        return at.first().copied().into_iter().collect();
    }
    let n = (total / gap).ceil().max(if closed { 3.0 } else { 1.0 }) as usize;
    let mut out = Vec::with_capacity(n + 1);
    let mut k = 0;
    for i in 0..=n {
        if closed && i == n {
            break;
        }
        let s = total * i as f64 / n as f64;
        while k + 2 < along.len() && along[k + 1] < s {
            k += 1;
        }
        let l = along[k + 1] - along[k];
        let f = if l > 0.0 {
            ((s - along[k]) / l).clamp(0.0, 1.0)
        } else {
            0.0
        };
        out.push(at[k] + (at[k + 1] - at[k]) * f);
    }
    out
}

/// Evens out a curve: each round moves every point to (1, 2, 1) / 4 of itself and its neighbours; ends stay.
pub fn smooth(curve: &mut [Point2], closed: bool, rounds: usize) {
    let n = curve.len();
    if n < 3 {
        return;
    }
    for _ in 0..rounds {
        let old = curve.to_vec();
        for i in 0..n {
            if !closed && (i == 0 || i + 1 == n) {
                continue;
            }
            let (p, q, r) = (&old[(i + n - 1) % n], &old[i], &old[(i + 1) % n]);
            curve[i] = Point2::from((p.coords + q.coords * 2.0 + r.coords) * 0.25);
        }
    }
}
