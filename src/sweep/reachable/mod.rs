//! The surface a ball can reach: the closing of the part by the ball, on a lattice.
//!
//! ```text
//!      ( c )  ( c )         every resting ball is admissible; the reachable height over q is the lowest underside of any
//!   \   '.'.__.'.'  /       of them. In a fold tighter than the ball it stays above the part: rest material, not ours.
//!    \_____________/        reach(q) = min over x, |q - x| <= R, of  c(x) - sqrt(R^2 - |q - x|^2)
//! ```
//! Nothing reaches below the part, so a cell is done when the ball that touches the part there (one radius along its facet's normal)
//! is admissible: most are. Any other cell walks downhill over the nodes, takes the lattice's own error out (a quadratic through the
//! nine nodes around the best one where the centre surface is smooth; balls found by bisection on the creases where it is not: there
//! the ball touches in two places), and is compared with every ball that could be lower.
//!
//! Each cell depends on the nodes within one radius and nothing else, so any window of the lattice can be had by itself, and tiles
//! of it give what the whole gives.
//!
//! Error: where the ball touches the part, 0.1 um; where it touches once, the quadratic leaves a third-order remainder in the step
//! (0.1 um at 0.05 mm); in a crease the along-crease spacing of the bisected balls overestimates by at most step^2 / (8 R) * 4 normal
//! to the surface (0.4 um); at the single points where creases meet, by at most half a step times the crease's slope.

mod blocks;
mod crease;
mod refine;
mod underside;

use crate::geom::{Box3, Point2};
use crate::reach::DropCutter;
use crate::sweep::Lattice;
use crate::sweep::tiles::{ReachTiles, tile_bytes};
use rayon::prelude::*;
use refine::Nodes;
pub use underside::{NONE, Offset};

/// What one ball can reach of a part, or of a window of it. Work coordinates, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Reachable {
    /// The cells; for a whole part it covers the part's shadow plus one radius all round.
    pub lattice: Lattice,
    /// Radius of the ball.
    pub radius: f64,
    /// Top of the part over each cell's centre; NaN off the part.
    pub part_z: Vec<f64>,
    /// Lowest underside of any resting ball over each cell of the part; `+inf` off the part or where no resting ball covers it.
    pub reach_z: Vec<f64>,
    /// The lattice node whose ball reaches each cell best (on a crease: a node next to it), in steps from the cell; [`NONE`] first
    /// for none.
    pub by: Vec<Offset>,
    /// Vertical component of the unit vector from each cell's reached point to the centre of that ball; 0 for none.
    pub normal_z: Vec<f32>,
}

impl Reachable {
    fn nothing(lattice: Lattice, radius: f64) -> Reachable {
        let n = lattice.len();
        Reachable {
            lattice,
            radius,
            part_z: vec![f64::NAN; n],
            reach_z: vec![f64::INFINITY; n],
            by: vec![[NONE; 2]; n],
            normal_z: vec![0.0; n],
        }
    }

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

    /// Where in plan the centre of the ball is that reaches a cell best, to within a step; the cell's own place for none.
    pub fn center_over(&self, cell: usize) -> Point2 {
        let q = self.lattice.center_at(cell);
        match self.by.get(cell) {
            Some(o) if o[0] != NONE => Point2::new(
                q.x + self.lattice.step * f64::from(o[0]),
                q.y + self.lattice.step * f64::from(o[1]),
            ),
            _ => q,
        }
    }
}

/// Bytes that judging a part of this size takes at its peak, so that a caller can announce or refuse it first: what is kept of a
/// small part, the tiles in work, and the map.
pub fn reachable_bytes(bounds: &Box3, radius: f64, step: f64) -> u64 {
    tile_bytes(&lattice_for(bounds, radius, step), radius)
}

/// Places of the lattice are whole multiples of this, mm: so they are exact, and the same in whatever window they are seen.
const GRAIN: f64 = 1.0 / (1 << 24) as f64;

/// The lattice that a part is judged on: its shadow and one radius all round. Steps below radius / 30000 are not taken. Empty for an
/// empty part or more than 2^32 cells.
pub(super) fn lattice_for(bounds: &Box3, radius: f64, step: f64) -> Lattice {
    let step = ((step.max(radius / 30_000.0) / GRAIN).floor() * GRAIN).max(GRAIN);
    let mut l = Lattice::covering(
        Point2::new(bounds.min.x - radius, bounds.min.y - radius),
        Point2::new(bounds.max.x + radius, bounds.max.y + radius),
        step,
    );
    l.origin = l.origin.map(|v| (v / GRAIN).floor() * GRAIN);
    if l.len() >= u32::MAX as usize {
        (l.nx, l.ny) = (0, 0);
    }
    l
}

/// Computes the surface that the drop cutter's ball can reach, on a lattice of this step (mm; rounded down to a multiple of
/// 2^-24; at least radius / 30000, coarser steps are used otherwise), all of it at once: 24 bytes a cell. An empty part gives an empty
/// lattice. Same bits for any number of threads.
pub fn reachable(drop: &DropCutter, step: f64) -> Reachable {
    let tiles = ReachTiles::new(drop, step, 1).bare();
    let whole = *tiles.lattice();
    let mut out = Reachable::nothing(whole, drop.radius());
    let parts: Vec<Reachable> = (0..tiles.len())
        .into_par_iter()
        .map(|k| tiles.compute(k))
        .collect();
    for (k, part) in parts.into_iter().enumerate() {
        let t = tiles.tile(k);
        for (row, iy) in t.rows.clone().enumerate() {
            let from = row * part.lattice.nx..(row + 1) * part.lattice.nx;
            let to = whole.index(t.columns.start, iy)..whole.index(t.columns.end, iy);
            out.part_z[to.clone()].copy_from_slice(&part.part_z[from.clone()]);
            out.reach_z[to.clone()].copy_from_slice(&part.reach_z[from.clone()]);
            out.by[to.clone()].copy_from_slice(&part.by[from.clone()]);
            out.normal_z[to].copy_from_slice(&part.normal_z[from]);
        }
    }
    out
}

/// The same for some columns and rows of a lattice made by [`lattice_for`]: the same bits as the whole has there, if they begin at
/// multiples of [`ALIGNED`]. On one thread.
pub(super) fn window(
    drop: &DropCutter,
    whole: &Lattice,
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
) -> Reachable {
    let radius = drop.radius();
    let cells = whole.window(columns.clone(), rows.clone());
    let mut out = Reachable::nothing(cells, radius);
    let top = drop.surface_all(&cells);
    if top.z.iter().all(|z| *z == f64::NEG_INFINITY) {
        return out;
    }
    let nodes = Nodes::around(drop, whole, &columns, &rows);
    nodes.reached(&top, [columns.start, rows.start], &mut out);
    for (z, top) in out.part_z.iter_mut().zip(&top.z) {
        if *top > f64::NEG_INFINITY {
            *z = *top;
        }
    }
    out
}

/// Windows that begin at multiples of this many cells repeat bit for bit.
pub(super) const ALIGNED: usize = 64;

#[cfg(test)]
mod tests;
