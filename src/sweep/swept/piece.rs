//! A chain of segments taken apart into strips and lunes, each with the cells it decides.

use super::Segment;
use super::interval::Interval;
use super::shape::Shape;
use crate::geom::{Point, Vector};
use crate::sweep::Lattice;

/// A segment shorter than this in plan is vertical, mm.
const VERTICAL: f64 = 1e-9;

/// A part of a chain's underside.
pub(super) enum Piece {
    /// The cylinder's side along a segment that does not fall (a falling one is turned round: same sweep).
    Side {
        from: Point,
        to: Point,
        dir: Vector,
        plan: f64,
        /// Turn of the chain (chord of the unit vectors) at `from` and at `to`; infinite at a corner or an end of it.
        turn: [f64; 2],
    },
    /// The sphere at a vertex, as far as it is past `before` and short of `after` (unit vectors; `None`: no bound).
    Cap {
        at: Point,
        before: Option<Vector>,
        after: Option<Vector>,
    },
}

pub(super) fn pieces(segments: &[Segment]) -> Vec<Piece> {
    let mut out = Vec::with_capacity(2 * segments.len() + 1);
    // The open end of the chain: its last centre and direction.
    let mut open: Option<(Point, Option<Vector>)> = None;
    // Which end of the side pushed last is the open end of the chain.
    let mut before_end: Option<usize> = None;
    for s in segments {
        if !s.from.iter().chain(s.to.iter()).all(|v| v.is_finite()) {
            continue;
        }
        let mut before = None;
        if let Some((end, dir)) = open {
            if end == s.from {
                before = dir;
            } else {
                out.push(Piece::Cap {
                    at: end,
                    before: dir,
                    after: None,
                });
                before_end = None;
            }
        }
        let d = s.to - s.from;
        let plan = (d.x * d.x + d.y * d.y).sqrt();
        let length = d.norm();
        let dir = if plan > VERTICAL {
            Some(d / length)
        } else if d.z != 0.0 {
            Some(Vector::new(0.0, 0.0, d.z.signum()))
        } else {
            None
        };
        let Some(dir) = dir else {
            // Standing still: the chain's end waits for a move that has a direction.
            open = Some((s.to, before));
            continue;
        };
        let bend = before.map_or(f64::INFINITY, |b| turn(&b, &dir));
        if let (Some(Piece::Side { turn, .. }), Some(end)) = (out.last_mut(), before_end) {
            turn[end] = bend;
        }
        out.push(Piece::Cap {
            at: s.from,
            before,
            after: Some(dir),
        });
        before_end = None;
        if plan > VERTICAL {
            before_end = Some(usize::from(d.z >= 0.0));
            out.push(if d.z >= 0.0 {
                Piece::Side {
                    from: s.from,
                    to: s.to,
                    dir,
                    plan,
                    turn: [bend, f64::INFINITY],
                }
            } else {
                Piece::Side {
                    from: s.to,
                    to: s.from,
                    dir: -dir,
                    plan,
                    turn: [f64::INFINITY, bend],
                }
            });
        }
        open = Some((s.to, Some(dir)));
    }
    if let Some((at, before)) = open {
        out.push(Piece::Cap {
            at,
            before,
            after: None,
        });
    }
    out
}

/// Chord between two unit vectors; infinite near the vertical.
fn turn(a: &Vector, b: &Vector) -> f64 {
    if a.z.abs().max(b.z.abs()) < 0.9 {
        (a - b).norm()
    } else {
        f64::INFINITY
    }
}

/// Strips reach this far past a gentle bend, mm, and so cover its lune, which is no wider than radius times turn: a few more cells
/// cost less than a piece of their own. Zero at a sharper bend.
fn past(turn: f64, radius: f64, lattice: &Lattice) -> f64 {
    if turn < 0.05 && radius * turn < 4.0 * lattice.step {
        1.2 * radius * turn
    } else {
        0.0
    }
}

impl Piece {
    pub(super) fn rows(&self, lattice: &Lattice, radius: f64) -> std::ops::Range<usize> {
        match self {
            Piece::Side { from, to, .. } => {
                lattice.rows(from.y.min(to.y) - radius, from.y.max(to.y) + radius)
            }
            Piece::Cap { at, before, after } => {
                if let (Some(b), Some(a)) = (before, after) {
                    // Straight on: the strips' own padding covers the joint.
                    if (a - b).norm_squared() < 1e-18 || past(turn(a, b), radius, lattice) > 0.0 {
                        return 0..0;
                    }
                }
                lattice.rows(at.y - radius, at.y + radius)
            }
        }
    }

    /// Calls `visit` with ranges of columns of one row that hold all cells for which this piece decides (and perhaps a few
    /// more, where the height given is right all the same) and with the shape to evaluate there.
    #[inline]
    pub(super) fn for_row(
        &self,
        lattice: &Lattice,
        iy: usize,
        radius: f64,
        mut visit: impl FnMut(std::ops::Range<usize>, &Shape),
    ) {
        let y = lattice.y(iy);
        // Rounding of the ends of intervals; a double root of the quadratic costs half the digits.
        let pad = 1e-6 * radius;
        match self {
            Piece::Side {
                from,
                to,
                dir,
                plan,
                turn,
            } => {
                let [early, late] = turn.map(|t| past(t, radius, lattice));
                let (ux, uy) = ((to.x - from.x) / plan, (to.y - from.y) / plan);
                let dy = y - from.y;
                let ends = Interval {
                    lo: (from.x.min(to.x) - from.x) - radius - early.max(late),
                    hi: (from.x.max(to.x) - from.x) + radius + early.max(late),
                };
                // |distance from the line in plan| <= R
                let clip = if uy.abs() > 1e-12 {
                    let (p, q) = ((ux * dy - radius) / uy, (ux * dy + radius) / uy);
                    ends.meet(Interval {
                        lo: p.min(q),
                        hi: p.max(q),
                    })
                } else {
                    ends
                };
                if clip.is_empty() {
                    return;
                }
                let back = -early * dir.x;
                let start =
                    short_of(dir, dy + early * dir.y, radius, clip.moved(-back)).moved(back);
                let offset = to.x + late * dir.x - from.x;
                let dy_end = y - to.y - late * dir.y;
                let end = short_of(dir, dy_end, radius, clip.moved(-offset)).moved(offset);
                let shape = Shape::Side {
                    x0: from.x,
                    ax: ux,
                    a0: uy * dy,
                    bx: -uy,
                    b0: ux * dy,
                    z0: from.z,
                    sine: dir.z,
                    plan: *plan,
                    slope: (to.z - from.z) / plan,
                    radius_sq: radius * radius,
                };
                let inside = clip.meet(end.padded(pad));
                for part in inside.minus(start.padded(-pad)) {
                    if !part.is_empty() {
                        let columns = lattice.columns(from.x + part.lo, from.x + part.hi);
                        if !columns.is_empty() {
                            visit(columns, &shape);
                        }
                    }
                }
            }
            Piece::Cap { at, before, after } => {
                let dy = y - at.y;
                let half_sq = radius * radius - dy * dy;
                if half_sq < 0.0 {
                    return;
                }
                let half = half_sq.sqrt();
                let mut parts = [
                    Interval {
                        lo: -half,
                        hi: half,
                    },
                    Interval::EMPTY,
                    Interval::EMPTY,
                ];
                let disc = parts[0];
                // Past the move before, short of the move after; each a convex set or the complement of one.
                for (dir, past) in [(before, true), (after, false)] {
                    let Some(dir) = dir else { continue };
                    let (convex, keep) = if dir.z >= 0.0 {
                        (short_of(dir, dy, radius, disc), !past)
                    } else {
                        (short_of(&-dir, dy, radius, disc), past)
                    };
                    let mut next = [Interval::EMPTY; 3];
                    let mut n = 0;
                    for p in parts {
                        let cut = if keep {
                            [p.meet(convex.padded(pad)), Interval::EMPTY]
                        } else {
                            p.minus(convex.padded(-pad))
                        };
                        for c in cut {
                            if !c.is_empty() && n < 3 {
                                next[n] = c;
                                n += 1;
                            }
                        }
                    }
                    parts = next;
                }
                let shape = Shape::Ball {
                    x0: at.x,
                    z0: at.z,
                    half_sq,
                };
                for part in parts {
                    if !part.is_empty() {
                        let columns = lattice.columns(at.x + part.lo, at.x + part.hi);
                        if !columns.is_empty() {
                            visit(columns, &shape);
                        }
                    }
                }
            }
        }
    }
}

/// The part of `clip` (x from a vertex, on the row `dy` from it) that is short of the vertex along `dir` (unit, not falling).
///
/// With h the plan part and v >= 0 the rise of `dir`, a place r from the vertex touches the underside there or earlier when
/// h.r <= v sqrt(R^2 - r^2): the half plane h.r <= 0 and the ellipse (h.r)^2 <= v^2 (R^2 - r^2). Within |distance from the
/// line| <= R their union is convex, so on a row it is one interval.
#[inline]
fn short_of(dir: &Vector, dy: f64, radius: f64, clip: Interval) -> Interval {
    let (hx, hy, v) = (dir.x, dir.y, dir.z);
    let mut half = clip;
    if hx > 0.0 {
        half.hi = half.hi.min(-hy * dy / hx);
    } else if hx < 0.0 {
        half.lo = half.lo.max(-hy * dy / hx);
    } else if hy * dy > 0.0 {
        half = Interval::EMPTY;
    }
    let a = hx * hx + v * v;
    let b = hx * hy * dy;
    let c = (hy * hy + v * v) * dy * dy - v * v * radius * radius;
    let disc = b * b - a * c;
    if v > 0.0 && disc >= 0.0 && a > 0.0 {
        let root = disc.sqrt();
        let ellipse = Interval {
            lo: (-b - root) / a,
            hi: (-b + root) / a,
        }
        .meet(clip);
        half.hull(ellipse)
    } else {
        half
    }
}
