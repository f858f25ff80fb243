//! What squares of nodes could do for a cell at best, so that most need not be looked at.

use super::crease::{Extra, owned};
use super::refine::Best;
use crate::geom::Point2;
use crate::sweep::Lattice;
use rayon::prelude::*;

/// Lowest centres of squares of nodes, extra balls included: what a whole square could do for a cell at best.
pub(super) struct Blocks {
    nx: usize,
    low: Vec<f64>,
    floor: Vec<Plane>,
    has_extras: Vec<bool>,
    coarse_nx: usize,
    coarse_ny: usize,
    coarse_low: Vec<f64>,
}

const BLOCK: usize = 8;

/// A plane below all centres of a square of nodes: its height in the square's middle and its slopes.
#[derive(Clone, Copy)]
struct Plane {
    z: f64,
    gx: f64,
    gy: f64,
}

/// Bounds that differ by less than this are the same, mm: rounding must not decide which square is looked at.
const ROUNDING: f64 = 1e-9;

impl Plane {
    /// Any slopes would do, as the plane is lowered until it is below all; those of least squares keep it near.
    fn below(balls: &[(f64, f64, f64)]) -> Plane {
        let n = balls.len().max(1) as f64;
        let mean = balls.iter().map(|b| b.2).sum::<f64>() / n;
        let (mut xx, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0);
        for (x, y, z) in balls {
            xx += x * x;
            yy += y * y;
            xz += x * (z - mean);
            yz += y * (z - mean);
        }
        let gx = if xx > 0.0 { xz / xx } else { 0.0 };
        let gy = if yy > 0.0 { yz / yy } else { 0.0 };
        let z = balls
            .iter()
            .map(|(x, y, z)| z - gx * x - gy * y)
            .fold(f64::INFINITY, f64::min);
        Plane { z, gx, gy }
    }

    /// No ball within `half` of the square's middle on both axes reaches below this over a cell that is (rx, ry) before the
    /// middle: plane minus sphere is convex, so it is nowhere below its tangent plane in the middle.
    fn underside(&self, rx: f64, ry: f64, half: f64, radius_sq: f64) -> f64 {
        let depth_sq = radius_sq - rx * rx - ry * ry;
        if depth_sq <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let depth = depth_sq.sqrt();
        let fall = (self.gx + rx / depth).abs() + (self.gy + ry / depth).abs();
        self.z - depth - fall * half
    }
}

impl Blocks {
    pub(super) fn new(lattice: &Lattice, center_z: &[f64], extras: &[Extra]) -> Blocks {
        let (nx, ny) = (lattice.nx.div_ceil(BLOCK), lattice.ny.div_ceil(BLOCK));
        let (coarse_nx, coarse_ny) = (nx.div_ceil(BLOCK), ny.div_ceil(BLOCK));
        let blocks: Vec<(f64, Plane, bool)> = (0..nx * ny)
            .into_par_iter()
            .map(|block| {
                let (x0, y0) = (block % nx * BLOCK, block / nx * BLOCK);
                let half = 0.5 * BLOCK as f64 * lattice.step;
                let (cx, cy) = (lattice.x(x0) + half, lattice.y(y0) + half);
                let mut balls = Vec::with_capacity(BLOCK * BLOCK);
                let mut has_extras = false;
                for iy in y0..(y0 + BLOCK).min(lattice.ny) {
                    let row =
                        lattice.index(x0, iy)..lattice.index((x0 + BLOCK).min(lattice.nx), iy);
                    for (ix, &c) in (x0..).zip(&center_z[row.clone()]) {
                        if c > f64::NEG_INFINITY {
                            balls.push((lattice.x(ix) - cx, lattice.y(iy) - cy, c));
                        }
                    }
                    for e in owned(extras, row) {
                        has_extras = true;
                        balls.push((e.center.x - cx, e.center.y - cy, e.center.z));
                    }
                }
                let low = balls.iter().map(|b| b.2).fold(f64::INFINITY, f64::min);
                (low, Plane::below(&balls), has_extras)
            })
            .collect();
        let mut b = Blocks {
            nx,
            low: blocks.iter().map(|b| b.0).collect(),
            floor: blocks.iter().map(|b| b.1).collect(),
            has_extras: blocks.iter().map(|b| b.2).collect(),
            coarse_nx,
            coarse_ny,
            coarse_low: vec![f64::INFINITY; coarse_nx * coarse_ny],
        };
        for (i, &low) in b.low.iter().enumerate() {
            let c = &mut b.coarse_low[i / nx / BLOCK * coarse_nx + i % nx / BLOCK];
            *c = c.min(low);
        }
        b
    }

    /// The best ball of all whose underside over q is below `value`.
    pub(super) fn below(
        &self,
        lattice: &Lattice,
        center_z: &[f64],
        extras: &[Extra],
        q: &Point2,
        radius_sq: f64,
        value: f64,
    ) -> Option<Best> {
        let step = lattice.step;
        let radius = radius_sq.sqrt();
        let mut best: Option<Best> = None;
        let mut limit = value;
        // The least underside a square of `side` nodes (and the extra balls up to one step beyond) could have.
        let bound = |bx: usize, by: usize, side: usize, low: f64| {
            let gap =
                |v: f64, first: f64| (first - v).max(v - (first + side as f64 * step)).max(0.0);
            let dx = gap(q.x, lattice.x(bx * side));
            let dy = gap(q.y, lattice.y(by * side));
            let depth_sq = radius_sq - dx * dx - dy * dy;
            if depth_sq < 0.0 {
                f64::INFINITY
            } else {
                low - depth_sq.sqrt()
            }
        };
        let range = |v: f64, origin: f64, n: usize, side: usize| {
            let at = |w: f64| ((w - origin) / step / side as f64).floor();
            let lo = at(v - radius - step).max(0.0) as usize;
            let hi = at(v + radius).max(0.0) as usize;
            lo..(hi + 1).min(n)
        };
        let side = BLOCK * BLOCK;
        let half = 0.5 * BLOCK as f64 * step;
        let rows = range(q.y, lattice.origin.y, self.low.len() / self.nx, BLOCK);
        let columns = range(q.x, lattice.origin.x, self.nx, BLOCK);
        for cy in range(q.y, lattice.origin.y, self.coarse_ny, side) {
            for cx in range(q.x, lattice.origin.x, self.coarse_nx, side) {
                if bound(cx, cy, side, self.coarse_low[cy * self.coarse_nx + cx]) >= limit {
                    continue;
                }
                for by in rows.start.max(cy * BLOCK)..rows.end.min((cy + 1) * BLOCK) {
                    for bx in columns.start.max(cx * BLOCK)..columns.end.min((cx + 1) * BLOCK) {
                        let block = by * self.nx + bx;
                        if bound(bx, by, BLOCK, self.low[block]) >= limit {
                            continue;
                        }
                        let (rx, ry) = (
                            lattice.x(bx * BLOCK) + half - q.x,
                            lattice.y(by * BLOCK) + half - q.y,
                        );
                        if self.floor[block].underside(rx, ry, half, radius_sq) >= limit + ROUNDING
                        {
                            continue;
                        }
                        let xs = bx * BLOCK..((bx + 1) * BLOCK).min(lattice.nx);
                        for iy in by * BLOCK..((by + 1) * BLOCK).min(lattice.ny) {
                            let mut offer = |node: usize, x: f64, y: f64, c: f64| {
                                let plan_sq = (x - q.x).powi(2) + (y - q.y).powi(2);
                                if plan_sq > radius_sq || c == f64::NEG_INFINITY {
                                    return;
                                }
                                let v = c - (radius_sq - plan_sq).sqrt();
                                if v < limit {
                                    limit = v;
                                    best = Some(Best {
                                        node,
                                        value: v,
                                        plan_sq,
                                    });
                                }
                            };
                            for ix in xs.clone() {
                                let i = lattice.index(ix, iy);
                                offer(i, lattice.x(ix), lattice.y(iy), center_z[i]);
                            }
                            if self.has_extras[block] {
                                let row = lattice.index(xs.start, iy)..lattice.index(xs.end, iy);
                                for e in owned(extras, row) {
                                    offer(e.owner as usize, e.center.x, e.center.y, e.center.z);
                                }
                            }
                        }
                    }
                }
            }
        }
        best
    }
}
