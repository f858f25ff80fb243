//! Creases of the tool-centre surface: the lines along which the ball rests on two places of the part at once.
//!
//! ```text
//!    \   ( c )   /        the contact leaps from one wall to the other while the centre stands still:
//!     \_p'   'p_/         |dp| >> |dc|, and the normals turn towards each other (concave)
//!
//!    top ___   ( )        a cliff is the same with a leap in height: the ball falls off an upright wall;
//!           | ( c )       `center` is the ball at the foot, `rise` how far it would jump
//!           |__'p__
//! ```
//!
//! Found on the edges of the grid's triangulation, each place by bisection (here), joined through the triangles into ordered chains
//! (`chain`), corners and ends put in (`ends`).
//! Crosses the border: a [`ToolCentreGrid`] and its cutter in, chains of resting balls out; work coordinates, mm. Knows nothing of
//! passes or cusps.

mod chain;
mod ends;

use super::drop::{Contact, DropCutter};
use super::grid::{NodeKind, ToolCentreGrid};
use crate::geom::{Point, Point2, Vector, Vector2};
use chain::{chain, forward_only, joined};
use ends::complete;
use rayon::prelude::*;

/// What counts as a crease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreaseOptions {
    /// Least angle between the two contact normals, radians: below it lie the facets of curved ground.
    pub angle: f64,
    /// Shortest chain, mm.
    pub shortest: f64,
}

/// A ball that touches in two places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreasePoint {
    /// Its centre; at the foot of a cliff the lower of the two.
    pub center: Point,
    /// Unit vectors from the two contacts to the centre; the first belongs to `center`, the second to the ball a hair beside it.
    pub normals: [Vector; 2],
    /// How much higher the ball a hair beside it rests, mm: 0 in a crease, the height of the leap at a cliff.
    pub rise: f64,
    /// Unit vector in plan from the second ball to the first: at a cliff the way out, away from the wall.
    pub out: Vector2,
}

/// An ordered chain of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Crease {
    /// Along the crease, about a grid step apart.
    pub points: Vec<CreasePoint>,
    /// The last one is followed by the first.
    pub closed: bool,
}

impl Crease {
    /// Length in plan, mm.
    pub fn length(&self) -> f64 {
        let open: f64 = self
            .points
            .windows(2)
            .map(|w| (w[1].center.xy() - w[0].center.xy()).norm())
            .sum();
        let close = match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(a), Some(b)) => (a.center.xy() - b.center.xy()).norm(),
            _ => 0.0,
        };
        open + close
    }
}

/// A place is known to this share of a grid step: below 0.1 um.
const HALVINGS: usize = 13;
/// Heights further apart than this over so short a way are a cliff, mm.
const LEAP: f64 = 0.01;

/// Directions of the three edges a node owns: along X, the diagonal, along Y.
const OWN: [(i32, i32); 3] = [(1, 0), (1, 1), (0, 1)];

/// All creases of a grid. Two drops an edge where the normals turn sharply; linear in the nodes. Same result on any number of
/// threads.
pub fn creases(grid: &ToolCentreGrid, cutter: &DropCutter, options: &CreaseOptions) -> Vec<Crease> {
    let found: Vec<(u32, CreasePoint)> = (0..grid.ny)
        .into_par_iter()
        .flat_map_iter(|iy| {
            let mut out = Vec::new();
            for ix in 0..grid.nx {
                let i = iy * grid.nx + ix;
                for (k, d) in OWN.iter().enumerate() {
                    if let Some(j) = grid.neighbour(i, *d)
                        && suspect(grid, i, j, options.angle)
                        && let Some(p) = bisect(grid, cutter, i, j, options.angle)
                    {
                        out.push(((3 * i + k) as u32, p));
                    }
                }
            }
            out
        })
        .collect();
    let mut chains = chain(grid, &found);
    chains.iter_mut().for_each(|c| forward_only(c, grid.step));
    let mut chains = joined(chains, 2.0 * grid.step);
    chains
        .par_iter_mut()
        .for_each(|c| complete(cutter, c, grid.step, options.angle));
    chains.retain(|c| c.points.len() > 1 && c.length() >= options.shortest);
    chains
}

fn normal_at(grid: &ToolCentreGrid, i: usize) -> Vector {
    (grid.center(i) - grid.point[i]) / grid.radius
}

/// Do the normals turn towards each other by so much that a crease may lie between?
fn suspect(grid: &ToolCentreGrid, i: usize, j: usize, angle: f64) -> bool {
    if grid.kind[i] == NodeKind::Air || grid.kind[j] == NodeKind::Air {
        return false;
    }
    let (u, v) = (normal_at(grid, i), normal_at(grid, j));
    let turned = v - u;
    turned.norm() > 1.6 * (0.5 * angle).sin()
        && turned.dot(&(grid.center(j) - grid.center(i))) < 0.0
}

fn unit(c: &Contact) -> Vector {
    let d = c.center - c.point;
    let l = d.norm();
    if l > 0.0 { d / l } else { Vector::z() }
}

/// The sharpest turn on an edge, closed in on from both sides; `None` when it is a curve and not a crease.
fn bisect(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    i: usize,
    j: usize,
    angle: f64,
) -> Option<CreasePoint> {
    let (a, b) = (grid.xy(i), grid.xy(j));
    between(cutter, &a, &b, angle)
}

/// The sharpest concave turn on the way from a to b in plan: the pair of resting balls on either side of it, a share of
/// 2^-13 of the way apart. `None` when the turn there is less than `angle` (radians) or the ball falls past the part.
pub fn between(cutter: &DropCutter, a: &Point2, b: &Point2, angle: f64) -> Option<CreasePoint> {
    let d = b - a;
    let r = cutter.radius();
    let (mut lo, mut hi) = (cutter.drop(a.x, a.y)?, cutter.drop(b.x, b.y)?);
    let (mut t_lo, mut t_hi) = (0.0, 1.0);
    let apart = |p: &Contact, q: &Contact| {
        (unit(q) - unit(p)).norm_squared() + ((q.center.z - p.center.z) / r).powi(2)
    };
    for _ in 0..HALVINGS {
        let t = 0.5 * (t_lo + t_hi);
        let q = a + d * t;
        let mid = cutter.drop(q.x, q.y)?;
        if apart(&lo, &mid) <= apart(&mid, &hi) {
            (lo, t_lo) = (mid, t);
        } else {
            (hi, t_hi) = (mid, t);
        }
    }
    let (u, v) = (unit(&lo), unit(&hi));
    let turned = v - u;
    if turned.norm() < 2.0 * (0.5 * angle).sin() || turned.dot(&(hi.center - lo.center)) > 0.0 {
        return None;
    }
    let along = d / d.norm().max(1e-300);
    let leap = hi.center.z - lo.center.z;
    Some(if leap >= 0.0 {
        CreasePoint {
            center: lo.center,
            normals: [u, v],
            rise: if leap > LEAP { leap } else { 0.0 },
            out: -along,
        }
    } else {
        CreasePoint {
            center: hi.center,
            normals: [v, u],
            rise: if -leap > LEAP { -leap } else { 0.0 },
            out: along,
        }
    })
}

#[cfg(test)]
mod tests;
