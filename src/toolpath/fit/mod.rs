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
//! ```text
//! curve -> dropped densely (here) -> fewest points, evenly spread (spread) -> written to the last decimal, and every segment proven
//! over its whole length (prove)
//! ```
//!
//! Crosses the border: a curve in plan and a part made ready for a ball in; runs of ball *centres* out, work coordinates, mm. Knows
//! nothing of passes, links or dialects (but that a program has a last decimal).

mod ease;
pub mod prove;
mod spread;

pub use prove::{FitReport, proof, prove_run};

use crate::geom::{Point, Point2, Vector};
use crate::reach::{DropCutter, Hint};

/// Tolerances of the fit, mm and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// How deep a chord may cut, along the normal.
    pub gouge: f64,
    /// How much stock a chord may leave, along the normal.
    pub stock: f64,
    /// How far a chord may stray sideways from its curve.
    pub sideways: f64,
    /// Distance between two looks at the curve while it is fitted. (The proof looks as closely as it must.)
    pub probe: f64,
    /// Longest segment.
    pub longest: f64,
    /// Largest turn from one segment to the next, rad, where the curve itself has no corner.
    pub turn: f64,
    /// A pass shall nowhere bend tighter than this on the surface, mm: a bend of it still takes segments that are long beside the last
    /// decimal. Zero: passes are laid as they come.
    pub bend: f64,
    /// The last decimal of the program: points are placed on whole ones (of the tool tip), and proven there. Zero: anywhere.
    pub decimal: f64,
}

impl FitOptions {
    /// Tolerances that keep a finish of `scallop` mm what it is: small beside the cusp, large beside the program's last decimal.
    pub fn for_scallop(scallop: f64, radius: f64) -> FitOptions {
        // 2 um is what a finish is allowed in all, and proven at the places the program names: rounding is inside.
        let g = (0.075 * scallop).clamp(0.0008, 0.0016);
        // A pass this share of a stepover beside its place makes cusps 2 % higher.
        let stepover = (8.0 * scallop * radius).max(0.0).sqrt();
        FitOptions {
            gouge: g,
            stock: 1.25 * g,
            sideways: (0.01 * stepover).max(1.5 * g),
            probe: (8.0 * radius * 2.0 * g).sqrt() * 0.5,
            longest: radius,
            turn: 12.0_f64.to_radians(),
            bend: (0.2 * stepover).max(0.05),
            decimal: 0.001,
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

/// Drops a curve onto the part and fits it: runs of ball centres, split where the ball would fall past the part. Every segment is
/// proven to keep its budgets ([`prove`]). About three drops per [`FitOptions::probe`] of curve.
pub fn fit(cutter: &DropCutter, curve: &[Point2], options: &FitOptions) -> Vec<Vec<Point>> {
    fit_ends(cutter, curve, None, options)
}

/// As [`fit`], for a link between two places that are there already: where the ends of the curve rest within 0.01 mm of `from` and `to`,
/// the run begins and ends there exactly, and its segments are proven so.
pub fn fit_between(
    cutter: &DropCutter,
    curve: &[Point2],
    from: &Point,
    to: &Point,
    options: &FitOptions,
) -> Vec<Vec<Point>> {
    fit_ends(cutter, curve, Some(&(*from, *to)), options)
}

fn fit_ends(
    cutter: &DropCutter,
    curve: &[Point2],
    ends: Option<&(Point, Point)>,
    options: &FitOptions,
) -> Vec<Vec<Point>> {
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
    let whole = runs.len() == 1;
    runs.into_iter()
        .filter(|r| !r.is_empty())
        .map(|r| {
            let vertices = spread::spread(&r, options);
            let mut proven =
                prove::place_and_prove(cutter, &vertices, ends.filter(|_| whole), options);
            // Many are kept: the room they grew in must not be.
            proven.shrink_to_fit();
            proven
        })
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

#[cfg(test)]
mod tests;
