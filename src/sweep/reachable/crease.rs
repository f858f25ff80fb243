//! Balls that touch in two places: found between the nodes, where the lattice of single balls does not see them.

use super::refine::Best;
use crate::geom::{Point, Point2};
use crate::reach::{Contact, DropCutter, Heights};
use crate::sweep::Lattice;

/// A resting ball off the lattice, on a crease; `owner` is the node at one end of the lattice edge it was found on.
pub(super) struct Extra {
    pub(super) owner: u32,
    pub(super) center: Point,
}

/// Where a lattice edge crosses a crease, the two resting balls on either side of it.
pub(super) fn creases(drop: &DropCutter, lattice: &Lattice, nodes: &Heights) -> Vec<Extra> {
    // A turn of the normal by this much within a step, towards itself, leaves step * turn / 4 (0.6 um) unseen by the lattice.
    let turn = (0.0025 / lattice.step).clamp(0.01, 0.5);
    let (nx, ny) = (lattice.nx, lattice.ny);
    let z_of = |n: [f32; 2]| f64::from((1.0 - n[0] * n[0] - n[1] * n[1]).max(0.0)).sqrt();
    let mut out = Vec::new();
    for iy in 0..ny {
        for ix in 0..nx {
            let a = lattice.index(ix, iy);
            for (jx, jy) in [(ix + 1, iy), (ix, iy + 1)] {
                if jx >= nx || jy >= ny {
                    continue;
                }
                let b = lattice.index(jx, jy);
                let (za, zb) = (nodes.z[a], nodes.z[b]);
                if za == f64::NEG_INFINITY || zb == f64::NEG_INFINITY {
                    continue;
                }
                let (na, nb) = (nodes.normal[a], nodes.normal[b]);
                let d = [
                    f64::from(nb[0] - na[0]),
                    f64::from(nb[1] - na[1]),
                    z_of(nb) - z_of(na),
                ];
                let turned_sq = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let (dx, dy) = (lattice.x(jx) - lattice.x(ix), lattice.y(jy) - lattice.y(iy));
                let towards = d[0] * dx + d[1] * dy + d[2] * (zb - za) < 0.0;
                if turned_sq > turn * turn && towards {
                    bisect(drop, lattice, a, [dx, dy], &mut out);
                }
            }
        }
    }
    out
}

/// Unit vector from contact to centre.
fn unit(c: &Contact) -> [f64; 3] {
    let d = c.center - c.point;
    let n = d.norm();
    if n > 0.0 {
        [d.x / n, d.y / n, d.z / n]
    } else {
        [0.0, 0.0, 1.0]
    }
}

fn bisect(drop: &DropCutter, lattice: &Lattice, a: usize, d: [f64; 2], out: &mut Vec<Extra>) {
    let from = lattice.center_at(a);
    let at = |t: f64| drop.drop(from.x + t * d[0], from.y + t * d[1]);
    let (Some(mut lo), Some(mut hi)) = (at(0.0), at(1.0)) else {
        return;
    };
    let (mut t_lo, mut t_hi) = (0.0, 1.0);
    let apart = |p: &Contact, q: &Contact| {
        let (u, v) = (unit(p), unit(q));
        (0..3).map(|k| (u[k] - v[k]).powi(2)).sum::<f64>()
    };
    // 2^-10 of a step: below 0.1 um.
    for _ in 0..10 {
        let t = 0.5 * (t_lo + t_hi);
        let Some(mid) = at(t) else { return };
        if apart(&lo, &mid) <= apart(&mid, &hi) {
            (lo, t_lo) = (mid, t);
        } else {
            (hi, t_hi) = (mid, t);
        }
    }
    for c in [lo, hi] {
        out.push(Extra {
            owner: a as u32,
            center: c.center,
        });
    }
}

/// The balls found on edges that begin at a run of nodes. `creases` lists them by owner.
pub(super) fn owned(extras: &[Extra], owners: std::ops::Range<usize>) -> &[Extra] {
    let first = extras.partition_point(|e| (e.owner as usize) < owners.start);
    let rest = &extras[first..];
    &rest[..rest
        .iter()
        .take_while(|e| (e.owner as usize) < owners.end)
        .count()]
}

/// Marks the nodes with an extra ball on an edge of theirs or of one of the eight around.
pub(super) fn near_extras(lattice: &Lattice, extras: &[Extra]) -> Vec<bool> {
    let mut near = vec![false; lattice.len()];
    for e in extras {
        let (ix, iy) = lattice.cell(e.owner as usize);
        for jy in iy.saturating_sub(1)..(iy + 2).min(lattice.ny) {
            for jx in ix.saturating_sub(1)..(ix + 2).min(lattice.nx) {
                near[lattice.index(jx, jy)] = true;
            }
        }
    }
    near
}

/// The best of the extra balls on edges of a node and of the eight around.
pub(super) fn best_extra(
    extras: &[Extra],
    near: &[bool],
    lattice: &Lattice,
    node: usize,
    q: &Point2,
    radius_sq: f64,
) -> Option<Best> {
    if !near[node] {
        return None;
    }
    let (ix, iy) = lattice.cell(node);
    let mut best: Option<Best> = None;
    for jy in iy.saturating_sub(1)..(iy + 2).min(lattice.ny) {
        let first = lattice.index(ix.saturating_sub(1), jy);
        let last = lattice.index((ix + 1).min(lattice.nx - 1), jy);
        for e in owned(extras, first..last + 1) {
            let plan_sq = (e.center.x - q.x).powi(2) + (e.center.y - q.y).powi(2);
            if plan_sq <= radius_sq {
                let value = e.center.z - (radius_sq - plan_sq).sqrt();
                if best.is_none_or(|b| value < b.value) {
                    best = Some(Best {
                        node: e.owner as usize,
                        value,
                        plan_sq,
                    });
                }
            }
        }
    }
    best
}
