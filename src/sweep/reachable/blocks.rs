//! What squares of nodes could do for a cell at best, so that most need not be looked at.

use super::crease::owned;
use super::refine::{Best, Nodes};
use crate::geom::Point2;
use crate::sweep::Lattice;

/// Planes below the centres of squares of nodes, extra balls included: what a whole square could do for a cell at best.
pub(super) struct Blocks {
    small: Level,
    large: Level,
}

struct Level {
    /// Nodes on a side.
    side: usize,
    nx: usize,
    ny: usize,
    /// Made when first asked for: smooth ground asks for few.
    floor: Vec<Option<(Plane, bool)>>,
}

const SMALL: usize = 4;
const LARGE: usize = 16;

/// A plane below all centres of a square of nodes: its height in the square's middle and its slopes; +inf for no centre.
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

    /// True when no ball within `half` of the middle of a square of nodes reaches below the plane `over` for any cell within
    /// `cells` of its middle; the former middle is (rx, ry) from the latter.
    ///
    /// With u the ball's place and q the cell's, both from their middles: plane(u) - sqrt(R^2 - |r + u - q|^2) - over(q) is convex in
    /// u - q for a given q, so it is nowhere below its tangent plane.
    #[inline]
    fn clear_of(&self, over: &Plane, r: [f64; 2], half: f64, cells: f64, radius_sq: f64) -> bool {
        if self.z == f64::INFINITY {
            return true;
        }
        let apart = |v: f64| (v.abs() - half - cells).max(0.0);
        let near_sq = apart(r[0]).powi(2) + apart(r[1]).powi(2);
        if near_sq > radius_sq {
            return true;
        }
        let depth_sq = radius_sq - r[0] * r[0] - r[1] * r[1];
        if depth_sq <= 0.0 {
            let low = self.z - (self.gx.abs() + self.gy.abs()) * half;
            let high = over.z + (over.gx.abs() + over.gy.abs()) * cells;
            return low - (radius_sq - near_sq).sqrt() >= high + ROUNDING;
        }
        let depth = depth_sq.sqrt();
        let along = (self.gx - over.gx).abs() + (self.gy - over.gy).abs();
        let fall = (self.gx + r[0] / depth).abs() + (self.gy + r[1] / depth).abs();
        self.z - over.z - depth - along * cells - fall * (half + cells) >= ROUNDING
    }
}

impl Level {
    fn new(lattice: &Lattice, side: usize) -> Level {
        let (nx, ny) = (lattice.nx.div_ceil(side), lattice.ny.div_ceil(side));
        Level {
            side,
            nx,
            ny,
            floor: vec![None; nx * ny],
        }
    }

    /// The plane below a square, and whether there are extra balls in it.
    #[inline]
    fn floor(&mut self, nodes: &Nodes, bx: usize, by: usize) -> (Plane, bool) {
        let block = by * self.nx + bx;
        if let Some(p) = self.floor[block] {
            return p;
        }
        let made = self.make(nodes, bx, by);
        self.floor[block] = Some(made);
        made
    }

    fn make(&self, nodes: &Nodes, bx: usize, by: usize) -> (Plane, bool) {
        let (lattice, side) = (&nodes.lattice, self.side);
        let half = self.half(lattice);
        let (x0, y0) = (bx * side, by * side);
        let (cx, cy) = (lattice.x(x0) + half, lattice.y(y0) + half);
        let mut balls = Vec::with_capacity(side * side);
        let mut has_extras = false;
        for iy in y0..(y0 + side).min(lattice.ny) {
            let row = lattice.index(x0, iy)..lattice.index((x0 + side).min(lattice.nx), iy);
            for (ix, &c) in (x0..).zip(&nodes.balls.z[row.clone()]) {
                if c > f64::NEG_INFINITY {
                    balls.push((lattice.x(ix) - cx, lattice.y(iy) - cy, c));
                }
            }
            for e in owned(&nodes.extras, row) {
                has_extras = true;
                balls.push((e.center.x - cx, e.center.y - cy, e.center.z));
            }
        }
        (Plane::below(&balls), has_extras)
    }

    fn half(&self, lattice: &Lattice) -> f64 {
        0.5 * self.side as f64 * lattice.step
    }

    /// From a place to the middle of a square.
    #[inline]
    fn from(&self, lattice: &Lattice, q: &Point2, bx: usize, by: usize) -> [f64; 2] {
        let half = self.half(lattice);
        [
            lattice.x(bx * self.side) + half - q.x,
            lattice.y(by * self.side) + half - q.y,
        ]
    }

    /// Squares along an axis that come within `reach` of a place.
    fn span(&self, v: f64, origin: f64, step: f64, reach: f64, n: usize) -> std::ops::Range<usize> {
        let at = |w: f64| ((w - origin) / step / self.side as f64).floor();
        let lo = at(v - reach - step).max(0.0) as usize;
        let hi = at(v + reach + step).max(-1.0) + 1.0;
        lo..(hi as usize).min(n)
    }
}

impl Blocks {
    pub(super) fn new(lattice: &Lattice) -> Blocks {
        Blocks {
            small: Level::new(lattice, SMALL),
            large: Level::new(lattice, LARGE),
        }
    }

    /// The small squares that may hold a ball which is better for one of some cells than the value it has.
    pub(super) fn likely(&mut self, nodes: &Nodes, asked: &[(Point2, f64)]) -> Vec<u32> {
        let lattice = &nodes.lattice;
        let radius_sq = nodes.radius * nodes.radius;
        let mut out = Vec::new();
        let (mut lo, mut hi) = (
            Point2::new(f64::INFINITY, f64::INFINITY),
            Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
        );
        for (q, _) in asked {
            lo = lo.inf(q);
            hi = hi.sup(q);
        }
        let mid = nalgebra::center(&lo, &hi);
        let cells = 0.5 * (hi - lo).max();
        // A plane above all values is the mirror image of one below.
        let mirrored: Vec<(f64, f64, f64)> = asked
            .iter()
            .map(|(q, v)| (q.x - mid.x, q.y - mid.y, -v))
            .collect();
        let p = Plane::below(&mirrored);
        let over = Plane {
            z: -p.z,
            gx: -p.gx,
            gy: -p.gy,
        };
        let reach = radius_sq.sqrt() + cells;
        let (large, small) = (&mut self.large, &mut self.small);
        let (origin, step) = (lattice.origin, lattice.step);
        let ratio = LARGE / SMALL;
        for by in large.span(mid.y, origin.y, step, reach, large.ny) {
            for bx in large.span(mid.x, origin.x, step, reach, large.nx) {
                let r = large.from(lattice, &mid, bx, by);
                let (floor, _) = large.floor(nodes, bx, by);
                if floor.clear_of(&over, r, large.half(lattice), cells, radius_sq) {
                    continue;
                }
                for sy in by * ratio..((by + 1) * ratio).min(small.ny) {
                    for sx in bx * ratio..((bx + 1) * ratio).min(small.nx) {
                        let r = small.from(lattice, &mid, sx, sy);
                        let (floor, _) = small.floor(nodes, sx, sy);
                        if !floor.clear_of(&over, r, small.half(lattice), cells, radius_sq) {
                            out.push((sy * small.nx + sx) as u32);
                        }
                    }
                }
            }
        }
        out
    }

    /// The best ball of all in these squares whose underside over q is below `value`.
    pub(super) fn below(
        &self,
        likely: &[u32],
        nodes: &Nodes,
        q: &Point2,
        value: f64,
    ) -> Option<Best> {
        let (lattice, small) = (&nodes.lattice, &self.small);
        let radius_sq = nodes.radius * nodes.radius;
        let half = small.half(lattice);
        let mut best: Option<Best> = None;
        let mut limit = value;
        for &k in likely {
            let k = k as usize;
            let (bx, by) = (k % small.nx, k / small.nx);
            let over = Plane {
                z: limit,
                gx: 0.0,
                gy: 0.0,
            };
            let r = small.from(lattice, q, bx, by);
            let Some((floor, has_extras)) = small.floor[k] else {
                continue; // all that are likely have been made
            };
            if floor.clear_of(&over, r, half, 0.0, radius_sq) {
                continue;
            }
            let xs = bx * SMALL..((bx + 1) * SMALL).min(lattice.nx);
            for iy in by * SMALL..((by + 1) * SMALL).min(lattice.ny) {
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
                    offer(i, lattice.x(ix), lattice.y(iy), nodes.balls.z[i]);
                }
                if has_extras {
                    let row = lattice.index(xs.start, iy)..lattice.index(xs.end, iy);
                    for e in owned(&nodes.extras, row) {
                        offer(e.owner as usize, e.center.x, e.center.y, e.center.z);
                    }
                }
            }
        }
        best
    }
}
