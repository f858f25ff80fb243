//! Balls that touch in two places: found between the nodes, where the lattice of single balls does not see them.

use super::refine::Best;
use crate::geom::{Point, Point2};
use crate::reach::{Contact, DropCutter, Heights, Hint};
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
    let mut hint = Hint::default();
    // Normals that differ so little in plan, and lean no more than this, turn by less: most edges are done with that.
    let little = (0.1 * turn * turn) as f32;
    let leaning = |n: [f32; 2]| n[0] * n[0] + n[1] * n[1] <= 0.9;
    for iy in 0..ny {
        for ix in 0..nx {
            let a = lattice.index(ix, iy);
            let na = nodes.normal[a];
            for (jx, jy) in [(ix + 1, iy), (ix, iy + 1)] {
                if jx >= nx || jy >= ny {
                    continue;
                }
                let b = lattice.index(jx, jy);
                let nb = nodes.normal[b];
                let (ex, ey) = (nb[0] - na[0], nb[1] - na[1]);
                if ex * ex + ey * ey <= little && leaning(na) && leaning(nb) {
                    continue;
                }
                let (za, zb) = (nodes.z[a], nodes.z[b]);
                if za == f64::NEG_INFINITY || zb == f64::NEG_INFINITY {
                    continue;
                }
                let (ua, ub) = (
                    [f64::from(na[0]), f64::from(na[1]), z_of(na)],
                    [f64::from(nb[0]), f64::from(nb[1]), z_of(nb)],
                );
                let (dx, dy) = (lattice.x(jx) - lattice.x(ix), lattice.y(jy) - lattice.y(iy));
                let d = [ub[0] - ua[0], ub[1] - ua[1], ub[2] - ua[2]];
                let towards = d[0] * dx + d[1] * dy + d[2] * (zb - za) < 0.0;
                if apart(&ua, &ub) > turn * turn && towards {
                    let ends = [
                        Place {
                            t: 0.0,
                            z: za,
                            u: ua,
                        },
                        Place {
                            t: 1.0,
                            z: zb,
                            u: ub,
                        },
                    ];
                    between(drop, lattice, &mut hint, a, [dx, dy], ends, &mut out);
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

fn apart(u: &[f64; 3], v: &[f64; 3]) -> f64 {
    (0..3).map(|k| (u[k] - v[k]).powi(2)).sum()
}

/// A resting ball on a lattice edge: place along it, height, normal.
#[derive(Clone, Copy)]
struct Place {
    t: f64,
    z: f64,
    u: [f64; 3],
}

/// Where two tangents meet to within this, mm, the crease is.
const MET: f64 = 2e-7;

/// Finds the crease between two nodes: where the tangents from both sides meet, or else by bisection.
fn between(
    drop: &DropCutter,
    lattice: &Lattice,
    hint: &mut Hint,
    owner: usize,
    d: [f64; 2],
    [mut lo, mut hi]: [Place; 2],
    out: &mut Vec<Extra>,
) {
    let from = lattice.center_at(owner);
    let mut push = |t: f64, z: f64| {
        out.push(Extra {
            owner: owner as u32,
            center: Point::new(from.x + t * d[0], from.y + t * d[1], z),
        });
    };
    // Height per unit of t.
    let slope = |p: &Place| -(p.u[0] * d[0] + p.u[1] * d[1]) / p.u[2].max(1e-3);
    // 2^-10 of a step: below 0.1 um.
    for _ in 0..10 {
        let (s0, s1) = (slope(&lo), slope(&hi));
        let met = (hi.z - s1 * hi.t - lo.z + s0 * lo.t) / (s0 - s1);
        let width = hi.t - lo.t;
        let inside = met > lo.t + 0.02 * width && met < hi.t - 0.02 * width;
        let t = if inside { met } else { lo.t + 0.5 * width };
        let Some(c) = drop.drop_near(from.x + t * d[0], from.y + t * d[1], hint) else {
            return;
        };
        let mid = Place {
            t,
            z: c.center.z,
            u: unit(&c),
        };
        if inside && (mid.z - (lo.z + s0 * (t - lo.t))).abs() < MET {
            push(t, mid.z);
            return;
        }
        if apart(&lo.u, &mid.u) <= apart(&mid.u, &hi.u) {
            lo = mid;
        } else {
            hi = mid;
        }
        if hi.t - lo.t < 1.0 / 1024.0 {
            break;
        }
    }
    push(lo.t, lo.z);
    push(hi.t, hi.z);
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
