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

use super::fit::FitOptions;
use super::pass::{Pass, PassKind, laid, on_ground};
use crate::feature::Regions;
use crate::geom::{Point, Point2, Vector, Vector2};
use crate::reach::{Crease, CreaseOptions, CreasePoint, DropCutter, Hint, ToolCentreGrid, creases};
use crate::sweep::{Lattice, Swept};
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

/// A pass along every crease of a grid. All cores; the order does not depend on them.
pub fn pencil(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    options: &PencilOptions,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let chains = creases(grid, cutter, &options.crease);
    let fitted: Vec<Vec<Pass>> = chains
        .par_iter()
        .map(|c| along(grid, cutter, regions, c, options, fitting))
        .collect();
    fitted.into_iter().flatten().collect()
}

fn along(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    crease: &Crease,
    options: &PencilOptions,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let curve = beside(crease, options.off_wall);
    let curve = cornered(cutter, &curve, crease.closed, grid.step);
    let wall = crease.points.iter().any(|p| p.rise > 0.0);
    // Beside a wall no chord may stray as far as the room that is kept.
    let fitting = if wall {
        FitOptions {
            sideways: fitting.sideways.min(0.5 * options.off_wall),
            ..*fitting
        }
    } else {
        *fitting
    };
    on_ground(grid, cutter, &curve, crease.closed)
        .into_iter()
        .flat_map(|(piece, closed)| laid(cutter, &piece, closed, &fitting))
        .filter(|(points, _)| points.len() > 1)
        .map(|(points, closed)| {
            let feature = grid
                .nearest(points[0].x, points[0].y)
                .map(|n| regions.label[n])
                .filter(|l| *l > 0)
                .map(|l| l as usize - 1);
            Pass {
                kind: PassKind::Pencil,
                feature,
                points,
                closed,
            }
        })
        .collect()
}

/// The crease in plan, moved out from under upright walls.
fn beside(crease: &Crease, off_wall: f64) -> Vec<Point2> {
    let p = &crease.points;
    let n = p.len();
    let at = |k: usize| p[k].center.xy();
    (0..n)
        .map(|k| {
            if p[k].rise <= 0.0 {
                return at(k);
            }
            let (before, after) = if crease.closed {
                ((k + n - 1) % n, (k + 1) % n)
            } else {
                (k.saturating_sub(1), (k + 1).min(n - 1))
            };
            at(k) + outward(&p[k], &(at(after) - at(before))) * off_wall
        })
        .collect()
}

/// Unit vector across a chain that runs along `tangent`, on the side away from the wall.
fn outward(p: &CreasePoint, tangent: &Vector2) -> Vector2 {
    let l = tangent.norm();
    if l <= 0.0 {
        return p.out;
    }
    let across = Vector2::new(-tangent.y, tangent.x) / l;
    if across.dot(&p.out) < 0.0 {
        -across
    } else {
        across
    }
}

/// Where a curve turns sharply between two of its places, the corner itself put in: the places lie on edges of the grid, and the
/// corner does not.
fn cornered(cutter: &DropCutter, curve: &[Point2], closed: bool, step: f64) -> Vec<Point2> {
    let n = curve.len();
    if n < 4 {
        return curve.to_vec();
    }
    let at = |k: usize| curve[k % n];
    let mut hint = Hint::default();
    let mut out = Vec::with_capacity(n + 4);
    for k in 0..n {
        out.push(curve[k]);
        let inner = k >= 1 && k + 2 < n;
        if !closed && !inner {
            continue;
        }
        let (a, b, c, d) = (at(k + n - 1), at(k), at(k + 1), at(k + 2));
        let (u, v) = (b - a, d - c);
        let (lu, lv) = (u.norm(), v.norm());
        if lu <= 0.0 || lv <= 0.0 {
            continue;
        }
        let sine = (u.x * v.y - u.y * v.x) / (lu * lv);
        if sine.abs() < 0.3 {
            continue;
        }
        // Where the lines a-b and d-c meet.
        let w = c - b;
        let s = (w.x * v.y - w.y * v.x) / (u.x * v.y - u.y * v.x);
        let corner = b + u * s;
        let low =
            |q: &Point2, hint: &mut Hint| cutter.drop_near(q.x, q.y, hint).map(|r| r.center.z);
        let (Some(zb), Some(zc), Some(z)) = (
            low(&b, &mut hint),
            low(&c, &mut hint),
            low(&corner, &mut hint),
        ) else {
            continue;
        };
        let fair = s > 0.0 && (corner - b).norm() < 1.5 * step && (corner - c).norm() < 1.5 * step;
        if fair && z < zb.max(zc) + 2.0 * step {
            out.push(corner);
        }
    }
    out
}

/// The runs of passes along which the ball that lies in the crease has not been there yet: where what `swept` left stands more
/// than `over` (mm) above it, and a stepover to either side. Bits shorter than `shortest` (mm) are dropped, gaps as short are kept.
pub fn needed(
    passes: Vec<Pass>,
    cutter: &DropCutter,
    lattice: &Lattice,
    swept: &Swept,
    over: f64,
    shortest: f64,
) -> Vec<Pass> {
    let kept: Vec<Vec<Pass>> = passes
        .into_par_iter()
        .map(|p| runs_needed(p, cutter, lattice, swept, over, shortest))
        .collect();
    kept.into_iter().flatten().collect()
}

fn runs_needed(
    pass: Pass,
    cutter: &DropCutter,
    lattice: &Lattice,
    swept: &Swept,
    over: f64,
    shortest: f64,
) -> Vec<Pass> {
    let gap = 2.0 * lattice.step;
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
    let asks: Vec<bool> = (0..n)
        .map(|k| {
            let t = at[(k + 1).min(n - 1)] - at[k.saturating_sub(1)];
            stands(&at[k], &t.xy(), cutter, lattice, swept, &mut hint) > over
        })
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

/// How high the ground stands above the ball at this place of a crease, along the middle of the two normals and a little to either
/// side of it, mm.
fn stands(
    c: &Point,
    tangent: &Vector2,
    cutter: &DropCutter,
    lattice: &Lattice,
    swept: &Swept,
    hint: &mut Hint,
) -> f64 {
    let l = tangent.norm();
    if l <= 0.0 {
        return 0.0;
    }
    let across = Vector2::new(-tangent.y, tangent.x) / l;
    // Far enough to be on one wall, near enough to be the same wall.
    let side = 0.02 * cutter.radius();
    let mut normal = |s: f64| -> Option<Vector> {
        let q = c.xy() + across * s;
        let r = cutter.drop_near(q.x, q.y, hint)?;
        let d = r.center - r.point;
        (d.norm() > 0.0).then(|| d / d.norm())
    };
    let (Some(u), Some(v)) = (normal(-side), normal(side)) else {
        return 0.0;
    };
    let r = cutter.radius();
    [0.25, 0.5, 0.75]
        .into_iter()
        .filter_map(|t| {
            let m = u * (1.0 - t) + v * t;
            let m = m / m.norm().max(1e-9);
            let q = c - m * r;
            let (ix, iy) = lattice.nearest(q.x, q.y)?;
            let cell = lattice.center(ix, iy);
            let d_sq = (cell - c.xy()).norm_squared();
            let under = c.z - (r * r - d_sq).max(0.0).sqrt();
            Some((swept.z[lattice.index(ix, iy)] - under) * m.z.max(0.0))
        })
        .fold(0.0, f64::max)
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
