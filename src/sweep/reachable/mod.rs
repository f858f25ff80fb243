//! The surface a ball can reach: the closing of the part by the ball, on a lattice.
//!
//! ```text
//!      ( c )  ( c )         every resting ball is admissible; the reachable height over q is the lowest underside of any
//!   \   '.'.__.'.'  /       of them. In a fold tighter than the ball it stays above the part: rest material, not ours.
//!    \_____________/        reach(q) = min over x, |q - x| <= R, of  c(x) - sqrt(R^2 - |q - x|^2)
//! ```
//! The minimum is not searched by brute force (a ball covers 11,000 cells at 0.05 mm): each cell starts from the node whose
//! contact falls nearest, hands its best node to its neighbours, and walks downhill over the nodes until nothing improves.
//! Then the lattice's own error is taken out: a quadratic through the nine nodes around the best one where the centre surface
//! is smooth, and balls found by bisection on the creases where it is not (the ball touches in two places).
//!
//! Error: where the ball touches once, the quadratic leaves a third-order remainder in the step (0.1 um at 0.05 mm);
//! in a crease the along-crease spacing of the bisected balls overestimates by at most step^2 / (8 R) * 4 normal to the
//! surface (0.4 um); at the single points where creases meet, by at most half a step times the crease's slope.

mod blocks;
mod crease;
mod nodes;
mod refine;
mod search;

use crate::geom::{Box3, Point2};
use crate::reach::DropCutter;
use crate::sweep::Lattice;
use crease::{creases, near_extras};
use nodes::sample;
use search::Search;

/// What one ball can reach of a part. Work coordinates, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Reachable {
    /// Covers the part's shadow plus one radius all round.
    pub lattice: Lattice,
    /// Radius of the ball.
    pub radius: f64,
    /// Top of the part over each cell's centre; NaN off the part.
    pub part_z: Vec<f64>,
    /// Height of the centre of the resting ball over each cell; `-inf` where it touches nothing.
    pub center_z: Vec<f64>,
    /// Lowest underside of any resting ball over each cell; `+inf` where no resting ball covers it.
    pub reach_z: Vec<f64>,
    /// The lattice node whose ball reaches each cell best (on a crease: a node next to it); `u32::MAX` for none.
    pub by: Vec<u32>,
    /// Vertical component of the unit vector from each cell's reached point to the centre of that ball; 0 for none.
    pub normal_z: Vec<f32>,
}

impl Reachable {
    /// How far the reachable surface stands above the part, along its normal, to first order, mm: above zero is rest material.
    /// NaN off the part.
    pub fn rest(&self, cell: usize) -> f64 {
        match (
            self.reach_z.get(cell),
            self.part_z.get(cell),
            self.normal_z.get(cell),
        ) {
            (Some(r), Some(p), Some(n)) if r.is_finite() => (r - p) * f64::from(*n),
            _ => f64::NAN,
        }
    }
}

/// Bytes that [`reachable`] will take for a part of this size, so that a caller can announce or refuse it first.
pub fn reachable_bytes(bounds: &Box3, radius: f64, step: f64) -> u64 {
    // center, part, reach: 8 each; by 4; normal 4; working: offsets 4, contact normals 8, flags 2.
    lattice_for(bounds, radius, step).len() as u64 * 50
}

fn lattice_for(bounds: &Box3, radius: f64, step: f64) -> Lattice {
    Lattice::covering(
        Point2::new(bounds.min.x - radius, bounds.min.y - radius),
        Point2::new(bounds.max.x + radius, bounds.max.y + radius),
        step,
    )
}

/// Computes the surface that the drop cutter's ball can reach, on a lattice of this step (mm; at least radius / 30000, coarser
/// steps are used otherwise). An empty part gives an empty lattice. Same bits for any number of threads. Cost: one drop and one
/// line query a node, then some 40 evaluations a cell.
pub fn reachable(drop: &DropCutter, step: f64) -> Reachable {
    let radius = drop.radius();
    let step = step.max(radius / 30_000.0);
    let lattice = lattice_for(&drop.bounds(), radius, step);
    let n = if lattice.len() < u32::MAX as usize {
        lattice.len()
    } else {
        0
    };
    let lattice = if n == 0 {
        Lattice {
            nx: 0,
            ny: 0,
            ..lattice
        }
    } else {
        lattice
    };
    let nodes = sample(drop, &lattice);
    let mut search = Search::seeded(&lattice, radius, &nodes);
    search.spread_in_bands();
    search.descend();
    search.settle();
    let extras = creases(drop, &lattice, &nodes);
    let near = near_extras(&lattice, &extras);
    let (reach_z, by, normal_z) = search.refined(&nodes.part_z, &extras, &near);
    Reachable {
        lattice,
        radius,
        part_z: nodes.part_z,
        center_z: nodes.center_z,
        reach_z,
        by,
        normal_z,
    }
}

#[cfg(test)]
mod tests;
