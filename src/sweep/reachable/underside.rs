//! The underside of the ball on a node, over a cell; and the walk downhill over the nodes.

use crate::sweep::Lattice;

/// From a cell to the node that reaches it best, in steps; [`NONE`] in the first place for no candidate.
pub type Offset = [i16; 2];
/// No node.
pub const NONE: i16 = i16::MIN;
const AROUND: [[i16; 2]; 8] = [
    [-1, 0],
    [1, 0],
    [0, -1],
    [0, 1],
    [-1, -1],
    [1, -1],
    [-1, 1],
    [1, 1],
];
/// Undersides nearer than this are the same height, mm.
const TIE: f64 = 1e-9;

/// The underside over cell (ix, iy) of the ball resting on the node at this offset; `+inf` if there is none. Cells and nodes share
/// one numbering.
pub(super) struct Underside<'a> {
    pub(super) center_z: &'a [f64],
    pub(super) nx: i64,
    pub(super) ny: i64,
    pub(super) radius_sq: f64,
    pub(super) step_sq: f64,
}

impl<'a> Underside<'a> {
    pub(super) fn new(lattice: &Lattice, center_z: &'a [f64], radius: f64) -> Underside<'a> {
        Underside {
            center_z,
            nx: lattice.nx as i64,
            ny: lattice.ny as i64,
            radius_sq: radius * radius,
            step_sq: lattice.step * lattice.step,
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, ix: usize, iy: usize, o: Offset) -> f64 {
        let (dx, dy) = (i64::from(o[0]), i64::from(o[1]));
        let depth_sq = self.radius_sq - (dx * dx + dy * dy) as f64 * self.step_sq;
        let (x, y) = (ix as i64 + dx, iy as i64 + dy);
        if depth_sq < 0.0 || x < 0 || y < 0 || x >= self.nx || y >= self.ny {
            return f64::INFINITY;
        }
        let c = self.center_z[(y * self.nx + x) as usize];
        if c == f64::NEG_INFINITY {
            f64::INFINITY
        } else {
            c - depth_sq.sqrt()
        }
    }

    /// Walks downhill over the nodes until none of the eight around is better.
    #[inline]
    pub(super) fn descend(&self, ix: usize, iy: usize, offset: &mut Offset, value: &mut f64) {
        loop {
            let from = *offset;
            for d in AROUND {
                let o = [from[0] + d[0], from[1] + d[1]];
                let v = self.at(ix, iy, o);
                if v < *value - TIE {
                    *value = v;
                    *offset = o;
                }
            }
            if *offset == from {
                return;
            }
        }
    }

    /// The quadratic through the nine undersides around a node that is the lowest of them: how much lower its minimum is, and where
    /// (in steps). `None` where a neighbour is missing or the fit has no minimum within half a step or so.
    pub(super) fn quadratic(
        &self,
        ix: usize,
        iy: usize,
        o: Offset,
        v: f64,
    ) -> Option<(f64, f64, f64)> {
        let at = |dx: i16, dy: i16| self.at(ix, iy, [o[0] + dx, o[1] + dy]);
        let (l, r, d, u) = (at(-1, 0), at(1, 0), at(0, -1), at(0, 1));
        let (ld, rd, lu, ru) = (at(-1, -1), at(1, -1), at(-1, 1), at(1, 1));
        if ![l, r, d, u, ld, rd, lu, ru].iter().all(|w| w.is_finite()) {
            return None;
        }
        let (gx, gy) = (0.5 * (r - l), 0.5 * (u - d));
        let (xx, yy, xy) = (r - 2.0 * v + l, u - 2.0 * v + d, 0.25 * (ru - rd - lu + ld));
        let det = xx * yy - xy * xy;
        if !(xx > 0.0 && yy > 0.0 && det > 1e-3 * xx * yy) {
            return None;
        }
        let sx = -(yy * gx - xy * gy) / det;
        let sy = -(xx * gy - xy * gx) / det;
        if sx.abs() > 0.75 || sy.abs() > 0.75 {
            return None;
        }
        Some(((-0.5 * (gx * sx + gy * sy)).max(0.0), sx, sy))
    }
}
