//! Takes the lattice's own error out of a searched surface and proves the rest: between the nodes by a quadratic, on creases by
//! the balls found there, away from the part by comparing with every ball that could be lower.

use super::blocks::Blocks;
use super::crease::{Extra, best_extra};
use super::search::{NONE, Offset, Search, Underside};
use rayon::prelude::*;

impl Search<'_> {
    /// Takes the lattice's own error out, and proves the answer: nothing reaches below the part, so a cell whose underside lies
    /// on the part is done; any other is compared with every ball that could be lower, by blocks. Returns heights, nodes and
    /// vertical components of the normals.
    pub(super) fn refined(
        self,
        part_z: &[f64],
        extras: &[Extra],
        near: &[bool],
    ) -> (Vec<f64>, Vec<u32>, Vec<f32>) {
        let f = self.underside();
        let lattice = self.lattice;
        let n = lattice.len();
        let mut value = self.value;
        let offset = self.offset;
        let mut by = vec![u32::MAX; n];
        let mut normal_z = vec![0.0f32; n];
        let nx = lattice.nx.max(1);
        let radius_sq = self.radius_sq;
        let radius = radius_sq.sqrt();
        let blocks = Blocks::new(lattice, self.center_z, extras);
        let step = lattice.step;
        value
            .par_chunks_mut(nx)
            .zip(by.par_chunks_mut(nx))
            .zip(normal_z.par_chunks_mut(nx))
            .enumerate()
            .for_each(|(iy, ((value, by), normal_z))| {
                for ix in 0..value.len() {
                    let o = offset[iy * nx + ix];
                    if o[0] == NONE {
                        continue;
                    }
                    let q = lattice.center(ix, iy);
                    let node =
                        (ix as i64 + i64::from(o[0])) + (iy as i64 + i64::from(o[1])) * nx as i64;
                    let refine = |best: Best| -> Best {
                        let mut best = best;
                        if near[best.node] {
                            while let Some(b) =
                                best_extra(extras, near, lattice, best.node, &q, radius_sq)
                            {
                                if b.value >= best.value {
                                    break;
                                }
                                best = b;
                            }
                            return best;
                        }
                        let (jx, jy) = lattice.cell(best.node);
                        let o = [
                            (jx as i64 - ix as i64) as i16,
                            (jy as i64 - iy as i64) as i16,
                        ];
                        if let Some((less, sx, sy)) = quadratic(&f, ix, iy, o, best.value) {
                            best.value -= less;
                            best.plan_sq = ((f64::from(o[0]) + sx).powi(2)
                                + (f64::from(o[1]) + sy).powi(2))
                                * step
                                * step;
                        }
                        best
                    };
                    let normal = |b: &Best| (radius_sq - b.plan_sq).max(0.0).sqrt() / radius;
                    let plan = |o: Offset| f64::from(o[0]).powi(2) + f64::from(o[1]).powi(2);
                    let mut best = refine(Best {
                        node: node as usize,
                        value: value[ix],
                        plan_sq: plan(o) * step * step,
                    });
                    let above = best.value - part_z[iy * nx + ix];
                    if above * normal(&best) > PROVEN
                        && let Some(better) =
                            blocks.below(lattice, self.center_z, extras, &q, radius_sq, best.value)
                    {
                        let better = refine(better);
                        if better.value < best.value {
                            best = better;
                        }
                    }
                    value[ix] = best.value;
                    by[ix] = best.node as u32;
                    normal_z[ix] = normal(&best) as f32;
                }
            });
        (value, by, normal_z)
    }
}

/// A cell is on the part when its reachable height is within this much of it, along the normal, mm.
const PROVEN: f64 = 2e-4;

/// The ball that is best for a cell so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) node: usize,
    pub(super) value: f64,
    /// Squared distance of the ball's centre from the cell in plan.
    pub(super) plan_sq: f64,
}
/// The quadratic through the nine undersides around a node that is the lowest of them: how much lower its minimum is, and where
/// (in steps). `None` where a neighbour is missing or the fit has no minimum within half a step or so.
fn quadratic(f: &Underside, ix: usize, iy: usize, o: Offset, v: f64) -> Option<(f64, f64, f64)> {
    let at = |dx: i16, dy: i16| f.at(ix, iy, [o[0] + dx, o[1] + dy]);
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
