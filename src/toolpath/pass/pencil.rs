//! Pencil passes: along the creases of the tool-centre surface, where the ball touches two walls at once.
//!
//! ```text
//!   \  o   o  /     passes on either side of a crease, a miss m away, leave a ridge of m sin(half the angle): linear in m,
//!    \_.'^'._/      up to ten times what the same miss leaves on the flat
//! ```
//!
//! A pass is laid where the others leave such a ridge, not where they cross the crease often enough. At the foot of an upright wall
//! it keeps a hair's breadth off, so that no chord runs under the wall's top.
//!
//! Crosses the border: chains of resting balls ([`Crease`]) in, [`Pass`]es of ball centres out; work coordinates, mm.

use super::{Pass, PassKind, laid};
use crate::geom::{Point, Point2, Vector, Vector2};
use crate::reach::{Crease, CreaseOptions, CreasePoint, DropCutter, Hint};
use crate::sweep::{Paths, Segment};
use crate::toolpath::fit::FitOptions;
use crate::toolpath::wall::moved_out;
use rayon::prelude::*;

/// Which creases get a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PencilOptions {
    /// What counts as a crease.
    pub crease: CreaseOptions,
    /// Room kept to an upright wall, mm.
    pub off_wall: f64,
}

impl PencilOptions {
    /// Creases of 8 degrees and more, longer than half a flat stepover.
    pub fn for_stepover(stepover: f64, fitting: &FitOptions) -> PencilOptions {
        PencilOptions {
            crease: CreaseOptions {
                angle: 8f64.to_radians(),
                shortest: 0.5 * stepover,
            },
            off_wall: 2.0 * fitting.gouge,
        }
    }
}

/// A pass along each of some creases, of no feature yet. All cores; the order does not depend on them.
pub fn pencil(
    cutter: &DropCutter,
    chains: &[Crease],
    options: &PencilOptions,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let fitted: Vec<Vec<Pass>> = chains
        .par_iter()
        .map(|c| along(cutter, c, options, fitting))
        .collect();
    fitted.into_iter().flatten().collect()
}

fn along(
    cutter: &DropCutter,
    crease: &Crease,
    options: &PencilOptions,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let curve = beside(cutter, crease, options.off_wall);
    let wall = crease.points.iter().any(by_wall);
    // Beside a wall no chord may stray as far as the room that is kept.
    let fitting = FitOptions {
        sideways: if wall {
            fitting.sideways.min(0.5 * options.off_wall)
        } else {
            fitting.sideways
        },
        // A crease is followed into its corners.
        bend: 0.0,
        ..*fitting
    };
    laid(cutter, &curve, crease.closed, &fitting)
        .into_iter()
        .filter(|(points, _)| points.len() > 1)
        .map(|(points, closed)| Pass {
            kind: PassKind::Pencil,
            feature: None,
            points,
            closed,
        })
        .collect()
}

/// Contacts with a smaller vertical part of the normal are kept off: a micrometre sideways is a micrometre of gouge there, and the
/// program rounds to one.
const STEEP: f64 = 0.35;

/// Does one of the two contacts lie on a wall?
fn by_wall(p: &CreasePoint) -> bool {
    p.rise > 0.0 || p.normals[0].z.min(p.normals[1].z) < STEEP
}

/// The crease in plan, moved out from under upright walls.
fn beside(cutter: &DropCutter, crease: &Crease, off_wall: f64) -> Vec<Point2> {
    let at: Vec<(Point2, Vector2)> = crease
        .points
        .iter()
        .map(|p| (p.center.xy(), p.out))
        .collect();
    moved_out(&at, crease.closed, off_wall)
        .into_iter()
        .zip(&crease.points)
        .map(|(q, p)| {
            if p.rise > 0.0 {
                free(cutter, p, q, off_wall)
            } else if by_wall(p) {
                q
            } else {
                p.center.xy()
            }
        })
        .collect()
}

/// A place beside a wall's foot at which the ball does rest at the foot: the one wanted, or another around the crease where a third
/// wall stands.
fn free(cutter: &DropCutter, p: &CreasePoint, wanted: Point2, off_wall: f64) -> Point2 {
    let height = |q: &Point2| cutter.drop(q.x, q.y).map_or(f64::INFINITY, |c| c.center.z);
    let mut best = (height(&wanted), wanted);
    if best.0 < p.center.z + 0.5 * p.rise {
        return wanted;
    }
    for k in 0..12 {
        let (s, c) = (f64::from(k) * std::f64::consts::FRAC_PI_6).sin_cos();
        let q = p.center.xy() + Vector2::new(c, s) * (1.5 * off_wall);
        let z = height(&q);
        if z < best.0 {
            best = (z, q);
        }
    }
    best.1
}

/// The runs of passes along which the ball that lies in the crease has not been there yet: where what `cut` (moves of the ball's
/// centre) left stands more than `over` (mm) above it, and half a stepover to either side.
pub fn needed(
    passes: Vec<Pass>,
    cutter: &DropCutter,
    cut: &[Segment],
    over: f64,
    stepover: f64,
) -> Vec<Pass> {
    if passes.is_empty() {
        return passes;
    }
    let b = cutter.bounds();
    let paths = Paths::new(cut, 0.25 * cutter.radius(), (b.min.xy(), b.max.xy()));
    let kept: Vec<Vec<Pass>> = passes
        .into_par_iter()
        .map(|p| runs_needed(p, cutter, &paths, over, stepover))
        .collect();
    kept.into_iter().flatten().collect()
}

fn runs_needed(
    pass: Pass,
    cutter: &DropCutter,
    paths: &Paths,
    over: f64,
    stepover: f64,
) -> Vec<Pass> {
    let (gap, shortest) = (stepover / 7.0, 0.5 * stepover);
    // Even places along the pass, the corners among them.
    let mut at: Vec<Point> = Vec::new();
    for w in pass.run().windows(2) {
        let n = ((w[1] - w[0]).norm() / gap).ceil().max(1.0) as usize;
        at.extend((0..n).map(|k| w[0] + (w[1] - w[0]) * (k as f64 / n as f64)));
    }
    at.extend(pass.run().last().copied());
    let n = at.len();
    if n < 2 {
        return Vec::new();
    }
    let along: Vec<f64> = std::iter::once(0.0)
        .chain(at.windows(2).scan(0.0, |s, w| {
            *s += (w[1] - w[0]).norm();
            Some(*s)
        }))
        .collect();
    let mut hint = Hint::default();
    let asks: Vec<bool> = at
        .iter()
        .map(|c| stands(c, cutter, paths, over, &mut hint))
        .collect();
    let total = along[n - 1];
    let asking = asks.iter().filter(|a| **a).count() as f64 / n as f64;
    if asking == 0.0 {
        return Vec::new();
    }
    // Mostly needed: whole, and no joints.
    if asking > 0.4 {
        return vec![pass];
    }
    let mut spans: Vec<[f64; 2]> = Vec::new();
    for (k, _) in asks.iter().enumerate().filter(|(_, a)| **a) {
        let (lo, hi) = (along[k] - shortest, along[k] + shortest);
        match spans.last_mut() {
            Some(s) if lo - s[1] <= 2.0 * shortest => s[1] = hi,
            _ => spans.push([lo, hi]),
        }
    }
    spans
        .into_iter()
        .filter_map(|[lo, hi]| {
            let (lo, hi) = (lo.max(0.0), hi.min(total));
            let points = cut_out(&pass.run(), lo, hi);
            (points.len() > 1).then(|| Pass {
                points,
                closed: false,
                ..pass.clone()
            })
        })
        .collect()
}

/// Does the ground stand more than `over` (mm) above the ball at this place of a crease, between the walls it touches?
fn stands(c: &Point, cutter: &DropCutter, paths: &Paths, over: f64, hint: &mut Hint) -> bool {
    const H: f64 = 0.866_025_403_784_438_6;
    const RING: [(f64, f64); 6] = [
        (1.0, 0.0),
        (0.5, H),
        (-0.5, H),
        (-1.0, 0.0),
        (-0.5, -H),
        (0.5, -H),
    ];
    let r = cutter.radius();
    // Far enough to be on one wall, near enough to be the same wall.
    let side = 0.02 * r;
    let mut normals: Vec<Vector> = Vec::with_capacity(RING.len());
    for (u, v) in RING {
        if let Some(t) = cutter.drop_near(c.x + side * u, c.y + side * v, hint) {
            let n = (t.center - t.point) / r;
            if normals.iter().all(|m| (m - n).norm() > 0.05) {
                normals.push(n);
            }
        }
    }
    let above = |m: Vector| -> bool {
        let q = c - m * (r / m.norm().max(1e-9));
        cutter.surface_z(q.x, q.y).is_some()
            && paths.distance(&q, r + 2.0 * over, &c.xy()) > r + over
    };
    above(normals.iter().sum())
        || normals.iter().enumerate().any(|(k, u)| {
            normals[k + 1..].iter().any(|v| {
                [0.25, 0.5, 0.75]
                    .iter()
                    .any(|t| above(u * (1.0 - t) + v * *t))
            })
        })
}

/// The part of a run between two lengths along it.
fn cut_out(run: &[Point], lo: f64, hi: f64) -> Vec<Point> {
    let mut out = Vec::new();
    let mut s = 0.0;
    for w in run.windows(2) {
        let l = (w[1] - w[0]).norm();
        let (a, b) = ((lo - s).max(0.0), (hi - s).min(l));
        if a < b {
            let at = |v: f64| w[0] + (w[1] - w[0]) * (v / l);
            if out.is_empty() {
                out.push(at(a));
            }
            out.push(at(b));
        }
        s += l;
    }
    out
}
