//! What squares of nodes could do for a cell at best, so that most need not be looked at.

use super::crease::Extra;
use super::refine::Best;
use crate::geom::Point2;
use crate::sweep::Lattice;

/// Lowest centres of squares of nodes, extra balls included: what a whole square could do for a cell at best.
pub(super) struct Blocks {
    nx: usize,
    low: Vec<f64>,
    has_extras: Vec<bool>,
    coarse_nx: usize,
    coarse_ny: usize,
    coarse_low: Vec<f64>,
}

const BLOCK: usize = 8;

impl Blocks {
    pub(super) fn new(lattice: &Lattice, center_z: &[f64], extras: &[Extra]) -> Blocks {
        let (nx, ny) = (lattice.nx.div_ceil(BLOCK), lattice.ny.div_ceil(BLOCK));
        let (coarse_nx, coarse_ny) = (nx.div_ceil(BLOCK), ny.div_ceil(BLOCK));
        let mut b = Blocks {
            nx,
            low: vec![f64::INFINITY; nx * ny],
            has_extras: vec![false; nx * ny],
            coarse_nx,
            coarse_ny,
            coarse_low: vec![f64::INFINITY; coarse_nx * coarse_ny],
        };
        for (i, &c) in center_z.iter().enumerate() {
            if c > f64::NEG_INFINITY {
                let (ix, iy) = lattice.cell(i);
                let low = &mut b.low[iy / BLOCK * nx + ix / BLOCK];
                *low = low.min(c);
            }
        }
        for e in extras {
            let (ix, iy) = lattice.cell(e.owner as usize);
            let i = iy / BLOCK * nx + ix / BLOCK;
            b.low[i] = b.low[i].min(e.center.z);
            b.has_extras[i] = true;
        }
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
        for cy in range(q.y, lattice.origin.y, self.coarse_ny, side) {
            for cx in range(q.x, lattice.origin.x, self.coarse_nx, side) {
                if bound(cx, cy, side, self.coarse_low[cy * self.coarse_nx + cx]) >= limit {
                    continue;
                }
                for by in cy * BLOCK..((cy + 1) * BLOCK).min(self.low.len() / self.nx) {
                    for bx in cx * BLOCK..((cx + 1) * BLOCK).min(self.nx) {
                        let block = by * self.nx + bx;
                        if bound(bx, by, BLOCK, self.low[block]) >= limit {
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
                                let (first, last) = (
                                    lattice.index(xs.start, iy) as u32,
                                    lattice.index(xs.end, iy) as u32,
                                );
                                let start = extras.partition_point(|e| e.owner < first);
                                for e in extras[start..].iter().take_while(|e| e.owner < last) {
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
