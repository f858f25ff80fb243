//! The lower envelope of a ball moved along straight segments.
//!
//! ```text
//!        centre path       d  unit direction of travel, q  a cell, c(s)  centre at s
//!   o----s*------o         over q the ball's underside is  f(s) = c_z(s) - sqrt(R^2 - |q - c(s)|^2),  convex in s
//!     \  |  cylinder side  df/ds = 0 where the touching radius stands square on d: the cylinder's side
//!      '-q_                before the start or past the end: the sphere there, if q lies under it at all
//! ```
//! Along a chain of segments the lowest f over q is therefore found either in the *strip* of one segment (between the two half
//! great circles square on its ends) or in the *lune* of one joint (past the segment before, before the segment after). Strips
//! and lunes tile the chain's shadow, so each cell is visited a few times instead of once per segment within a radius of it.

use crate::geom::{Point, Vector};
use crate::sweep::Lattice;
use rayon::prelude::*;

/// A straight move of the ball's *centre*, work coordinates, mm. Segments that follow each other without a gap (`to` of one
/// equal to `from` of the next) are treated as one chain, which is quicker; the result is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Centre at the start.
    pub from: Point,
    /// Centre at the end.
    pub to: Point,
}

/// Heights left by a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept {
    /// Where the heights stand.
    pub lattice: Lattice,
    /// Lowest point of the swept ball on the vertical line through each cell's centre, mm; `+inf`: never passed over.
    pub z: Vec<f64>,
}

/// Where a ball met what was still standing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// How far, vertically, the standing material reached into the swept ball, mm.
    pub depth: f64,
    /// Where that was deepest, on the material: work coordinates.
    pub place: Point,
}

impl Swept {
    /// Nothing cut yet. Memory: 8 bytes a cell.
    pub fn new(lattice: Lattice) -> Swept {
        Swept {
            z: vec![f64::INFINITY; lattice.len()],
            lattice,
        }
    }

    /// Lowers the map by the ball of this radius moved along the segments. The value at each cell is the exact lower envelope
    /// at its centre (rounding apart, about 1e-12 mm; segments shorter than 1e-9 mm in plan count as vertical). Segments with
    /// non-finite ends are ignored, as is a radius that is not a finite number above zero. Same bits for any number of threads:
    /// a minimum does not care about order. Cost: about length / step x 2R / step evaluations for smooth chains.
    pub fn cut(&mut self, segments: &[Segment], radius: f64) {
        if self.lattice.is_empty() || !(radius.is_finite() && radius > 0.0) {
            return;
        }
        let lattice = self.lattice;
        let pieces = pieces(segments);
        let bands = lattice.ny.div_ceil(BAND_ROWS);
        let mut bins: Vec<Vec<u32>> = vec![Vec::new(); bands];
        for (i, piece) in pieces.iter().enumerate() {
            let rows = piece.rows(&lattice, radius);
            if rows.is_empty() {
                continue;
            }
            for bin in &mut bins[rows.start / BAND_ROWS..=(rows.end - 1) / BAND_ROWS] {
                bin.push(i as u32);
            }
        }
        self.z
            .par_chunks_mut(BAND_ROWS * lattice.nx)
            .zip(bins.par_iter())
            .enumerate()
            .for_each(|(band, (z, bin))| {
                let first = band * BAND_ROWS;
                let last = (first + BAND_ROWS).min(lattice.ny);
                for &i in bin {
                    let piece = &pieces[i as usize];
                    let rows = piece.rows(&lattice, radius);
                    for iy in rows.start.max(first)..rows.end.min(last) {
                        let row = &mut z[(iy - first) * lattice.nx..(iy - first + 1) * lattice.nx];
                        piece.for_row(&lattice, iy, radius, |columns, shape| {
                            shape.lower(&lattice, columns.start, &mut row[columns]);
                        });
                    }
                }
            });
    }

    /// Where the ball moved along one segment reaches deepest into what still stands: at each cell the lower of `stock` (same
    /// lattice; `-inf` where there is none) and of what was cut so far. `None` when it enters nothing by more than `tolerance`.
    /// A `stock` of another length than the lattice is taken as empty.
    pub fn encounter(
        &self,
        stock: &[f64],
        segment: Segment,
        radius: f64,
        tolerance: f64,
    ) -> Option<Encounter> {
        if stock.len() != self.z.len() || !(radius.is_finite() && radius > 0.0) {
            return None;
        }
        let mut worst: Option<(f64, usize, f64)> = None;
        for piece in pieces(&[segment]) {
            for iy in piece.rows(&self.lattice, radius) {
                piece.for_row(&self.lattice, iy, radius, |columns, shape| {
                    for ix in columns {
                        let i = self.lattice.index(ix, iy);
                        let standing = stock[i].min(self.z[i]);
                        let depth = standing - shape.height(self.lattice.x(ix));
                        if depth > tolerance && worst.is_none_or(|w| depth > w.0) {
                            worst = Some((depth, i, standing));
                        }
                    }
                });
            }
        }
        worst.map(|(depth, i, z)| {
            let c = self.lattice.center_at(i);
            Encounter {
                depth,
                place: Point::new(c.x, c.y, z),
            }
        })
    }
}

/// Rows handed to one thread at a time.
const BAND_ROWS: usize = 16;
/// A segment shorter than this in plan is vertical, mm.
const VERTICAL: f64 = 1e-9;

/// A part of a chain's underside.
enum Piece {
    /// The cylinder's side along a segment that does not fall (a falling one is turned round: same sweep).
    Side {
        from: Point,
        to: Point,
        dir: Vector,
        plan: f64,
    },
    /// The sphere at a vertex, as far as it is past `before` and short of `after` (unit vectors; `None`: no bound).
    Cap {
        at: Point,
        before: Option<Vector>,
        after: Option<Vector>,
    },
}

fn pieces(segments: &[Segment]) -> Vec<Piece> {
    let mut out = Vec::with_capacity(2 * segments.len() + 1);
    // The open end of the chain: its last centre and direction.
    let mut open: Option<(Point, Option<Vector>)> = None;
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
            }
        }
        let d = s.to - s.from;
        let plan = d.x.hypot(d.y);
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
        out.push(Piece::Cap {
            at: s.from,
            before,
            after: Some(dir),
        });
        if plan > VERTICAL {
            out.push(if d.z >= 0.0 {
                Piece::Side {
                    from: s.from,
                    to: s.to,
                    dir,
                    plan,
                }
            } else {
                Piece::Side {
                    from: s.to,
                    to: s.from,
                    dir: -dir,
                    plan,
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

impl Piece {
    fn rows(&self, lattice: &Lattice, radius: f64) -> std::ops::Range<usize> {
        match self {
            Piece::Side { from, to, .. } => {
                lattice.rows(from.y.min(to.y) - radius, from.y.max(to.y) + radius)
            }
            Piece::Cap { at, before, after } => {
                if let (Some(b), Some(a)) = (before, after) {
                    // Straight on: the strips' own padding covers the joint.
                    if (a - b).norm_squared() < 1e-18 {
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
    fn for_row(
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
            } => {
                let (ux, uy) = ((to.x - from.x) / plan, (to.y - from.y) / plan);
                let dy = y - from.y;
                let ends = Interval {
                    lo: (from.x.min(to.x) - from.x) - radius,
                    hi: (from.x.max(to.x) - from.x) + radius,
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
                let start = short_of(dir, dy, radius, clip);
                let offset = to.x - from.x;
                let end = short_of(dir, y - to.y, radius, clip.moved(-offset)).moved(offset);
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

/// What to evaluate along a row.
enum Shape {
    /// Side of a cylinder: along = a0 + ax x, across = b0 + bx x, with x from x0.
    Side {
        x0: f64,
        ax: f64,
        a0: f64,
        bx: f64,
        b0: f64,
        z0: f64,
        sine: f64,
        plan: f64,
        slope: f64,
        radius_sq: f64,
    },
    /// Sphere cut by the row: half chord squared.
    Ball { x0: f64, z0: f64, half_sq: f64 },
}

impl Shape {
    /// Height of the underside over x; `+inf` beside it.
    #[inline(always)]
    fn height(&self, x: f64) -> f64 {
        match *self {
            Shape::Side {
                x0,
                ax,
                a0,
                bx,
                b0,
                z0,
                sine,
                plan,
                slope,
                radius_sq,
            } => {
                let px = x - x0;
                let a = a0 + ax * px;
                let b = b0 + bx * px;
                let w_sq = radius_sq - b * b;
                // Stationary place along the plan, then clamped to the segment: f is convex.
                let s = (a - sine * w_sq.max(0.0).sqrt()).clamp(0.0, plan);
                let e = a - s;
                let depth_sq = w_sq - e * e;
                if depth_sq >= 0.0 {
                    z0 + slope * s - depth_sq.sqrt()
                } else {
                    f64::INFINITY
                }
            }
            Shape::Ball { x0, z0, half_sq } => {
                let px = x - x0;
                let depth_sq = half_sq - px * px;
                if depth_sq >= 0.0 {
                    z0 - depth_sq.sqrt()
                } else {
                    f64::INFINITY
                }
            }
        }
    }

    /// Lowers a run of cells of one row that begins at column `first`.
    #[inline]
    fn lower(&self, lattice: &Lattice, first: usize, cells: &mut [f64]) {
        for (k, z) in cells.iter_mut().enumerate() {
            let h = self.height(lattice.x(first + k));
            *z = if h < *z { h } else { *z };
        }
    }
}

/// A closed interval; empty when `lo > hi`.
#[derive(Clone, Copy, Debug)]
struct Interval {
    lo: f64,
    hi: f64,
}

impl Interval {
    const EMPTY: Interval = Interval {
        lo: f64::INFINITY,
        hi: f64::NEG_INFINITY,
    };

    #[inline]
    fn is_empty(self) -> bool {
        self.lo > self.hi
    }
    #[inline]
    fn meet(self, o: Interval) -> Interval {
        Interval {
            lo: self.lo.max(o.lo),
            hi: self.hi.min(o.hi),
        }
    }
    #[inline]
    fn hull(self, o: Interval) -> Interval {
        if self.is_empty() {
            o
        } else if o.is_empty() {
            self
        } else {
            Interval {
                lo: self.lo.min(o.lo),
                hi: self.hi.max(o.hi),
            }
        }
    }
    #[inline]
    fn moved(self, by: f64) -> Interval {
        Interval {
            lo: self.lo + by,
            hi: self.hi + by,
        }
    }
    /// Larger by `by` at both ends (smaller when negative); the empty interval stays empty.
    #[inline]
    fn padded(self, by: f64) -> Interval {
        if self.is_empty() {
            return Interval::EMPTY;
        }
        Interval {
            lo: self.lo - by,
            hi: self.hi + by,
        }
    }
    /// What is left of `self` without the inside of `o`: the part below and the part above.
    #[inline]
    fn minus(self, o: Interval) -> [Interval; 2] {
        if o.is_empty() {
            return [self, Interval::EMPTY];
        }
        [
            Interval {
                lo: self.lo,
                hi: self.hi.min(o.lo),
            },
            Interval {
                lo: self.lo.max(o.hi),
                hi: self.hi,
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point2;
    use proptest::prelude::*;

    /// The underside of one capsule over a place, by golden section over the (convex) parameter: no formula shared.
    fn by_search(s: &Segment, x: f64, y: f64, r: f64) -> f64 {
        let f = |t: f64| {
            let c = s.from + (s.to - s.from) * t;
            let d = r * r - (x - c.x).powi(2) - (y - c.y).powi(2);
            if d < 0.0 { None } else { Some(c.z - d.sqrt()) }
        };
        // Parameters for which the place lies under the ball.
        let e = (s.to - s.from).xy();
        let p = Point2::new(x, y) - s.from.xy();
        let (a, b, c) = (e.norm_squared(), -p.dot(&e), p.norm_squared() - r * r);
        let (mut lo, mut hi) = (0.0, 1.0);
        if a > 0.0 {
            let disc = b * b - a * c;
            if disc < 0.0 {
                return f64::INFINITY;
            }
            lo = f64::max(0.0, (-b - disc.sqrt()) / a);
            hi = f64::min(1.0, (-b + disc.sqrt()) / a);
        }
        if lo > hi {
            return f64::INFINITY;
        }
        let g = |t| f(t).unwrap_or(f64::INFINITY);
        let mut best = g(lo).min(g(hi));
        for _ in 0..200 {
            let (m, n) = (lo + (hi - lo) * 0.382, lo + (hi - lo) * 0.618);
            best = best.min(g(m)).min(g(n));
            if g(m) < g(n) { hi = n } else { lo = m }
        }
        best
    }

    fn compare(segments: &[Segment], r: f64) {
        let lattice = Lattice::covering(Point2::new(-4.0, -4.0), Point2::new(4.0, 4.0), 0.17);
        let mut swept = Swept::new(lattice);
        swept.cut(segments, r);
        for i in 0..lattice.len() {
            let c = lattice.center_at(i);
            let want = segments
                .iter()
                .map(|s| by_search(s, c.x, c.y, r))
                .fold(f64::INFINITY, f64::min);
            let got = swept.z[i];
            // On the very rim of the ball (within 1e-9 mm) the place may count as under it or not.
            let rim = |v: f64| v.is_infinite();
            if rim(got) != rim(want) {
                let near = segments.iter().any(|s| {
                    by_search(s, c.x, c.y, r + 1e-9).is_finite()
                        != by_search(s, c.x, c.y, r - 1e-9).is_finite()
                });
                assert!(near, "cell {c:?}: {got} against {want}");
            } else if got.is_finite() {
                assert!(
                    (got - want).abs() < 1e-7,
                    "cell {c:?}: {got} against {want}, segments {segments:?}"
                );
            }
        }
    }

    fn point() -> impl Strategy<Value = Point> {
        (-3.0..3.0f64, -3.0..3.0f64, -2.0..2.0f64).prop_map(|(x, y, z)| Point::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn chains_equal_the_searched_envelope(points in prop::collection::vec(point(), 2..6), r in 0.3..2.5f64) {
            let s: Vec<Segment> = points.windows(2).map(|w| Segment { from: w[0], to: w[1] }).collect();
            compare(&s, r);
        }

        #[test]
        fn fine_smooth_chains_equal_the_searched_envelope(start in point(), turn in -0.3..0.3f64, rise in -2.0..2.0f64, bend in -0.2..0.2f64) {
            let mut p = start;
            let (mut a, mut v) = (1.0f64, rise);
            let mut s = Vec::new();
            for _ in 0..12 {
                let q = p + Vector::new(a.cos(), a.sin(), v) * 0.1;
                s.push(Segment { from: p, to: q });
                p = q;
                a += turn;
                v += bend;
            }
            compare(&s, 1.5);
        }
    }

    #[test]
    fn upright_standing_and_broken_segments() {
        let p = Point::new(0.3, -0.2, 1.0);
        let q = Point::new(0.3, -0.2, -1.0);
        let e = Point::new(1.3, 0.4, -1.0);
        compare(&[Segment { from: p, to: q }], 1.0);
        compare(&[Segment { from: q, to: p }], 1.0);
        compare(&[Segment { from: p, to: p }], 1.0);
        compare(
            &[
                Segment { from: p, to: p },
                Segment { from: p, to: q },
                Segment { from: q, to: q },
                Segment { from: q, to: e },
                Segment { from: e, to: q },
                Segment { from: p, to: e },
            ],
            1.0,
        );
        let near = Point::new(0.3 + 1e-7, -0.2, -1.0);
        compare(&[Segment { from: p, to: near }], 1.0);
        let mut swept = Swept::new(Lattice::covering(
            Point2::new(0.0, 0.0),
            Point2::new(1.0, 1.0),
            0.1,
        ));
        let nan = Point::new(f64::NAN, 0.0, 0.0);
        swept.cut(&[Segment { from: p, to: nan }], 1.0);
        swept.cut(&[Segment { from: p, to: q }], f64::NAN);
        assert!(swept.z.iter().all(|z| *z == f64::INFINITY));
    }

    /// Two parallel passes at stepover w leave R - sqrt(R^2 - w^2/4) half way, and nothing on the passes.
    #[test]
    fn cusp_of_two_parallel_passes() {
        let (r, w): (f64, f64) = (3.0, 0.7);
        let lattice = Lattice::covering(Point2::new(-1.0, 0.0), Point2::new(1.0, w), w / 2.0);
        let pass = |y: f64| Segment {
            from: Point::new(-5.0, y, r),
            to: Point::new(5.0, y, r),
        };
        let mut swept = Swept::new(lattice);
        swept.cut(&[pass(0.0), pass(w)], r);
        let cusp = r - (r * r - w * w / 4.0).sqrt();
        for i in 0..lattice.len() {
            let (_, iy) = lattice.cell(i);
            let want = if iy == 1 { cusp } else { 0.0 };
            assert!((swept.z[i] - want).abs() < 1e-12);
        }
    }

    #[test]
    fn encounter_names_the_deepest_place() {
        let lattice = Lattice::covering(Point2::new(-5.0, -5.0), Point2::new(5.0, 5.0), 0.1);
        let swept = Swept::new(lattice);
        let stock = vec![2.0; lattice.len()];
        let s = |z: f64| Segment {
            from: Point::new(-3.0, 0.0, z),
            to: Point::new(3.0, 0.0, z),
        };
        assert_eq!(swept.encounter(&stock, s(5.001), 3.0, 1e-6), None);
        let e = swept.encounter(&stock, s(4.75), 3.0, 1e-6).unwrap();
        assert!((e.depth - 0.25).abs() < 1e-9 && e.place.y.abs() < 1e-9 && e.place.z == 2.0);
        // Once cut, the same move meets nothing.
        let mut swept = swept;
        swept.cut(&[s(4.75)], 3.0);
        assert_eq!(swept.encounter(&stock, s(4.75), 3.0, 1e-6), None);
        assert!(swept.encounter(&stock, s(4.70), 3.0, 1e-6).is_some());
    }

    fn spiral(n: usize, step: f64) -> Vec<Segment> {
        let at = |k: usize| {
            let k = k as f64;
            let theta = (4.0 * std::f64::consts::PI * k * step / 0.7).sqrt();
            let rho = 0.7 * theta / std::f64::consts::TAU;
            let (x, y) = (rho * theta.cos(), rho * theta.sin());
            Point::new(x, y, 4.0 * (x * 0.15).sin() * (y * 0.13).cos())
        };
        (0..n)
            .map(|k| Segment {
                from: at(k),
                to: at(k + 1),
            })
            .collect()
    }

    #[test]
    fn same_bits_for_any_number_of_threads() {
        let lattice = Lattice::covering(Point2::new(-20.0, -20.0), Point2::new(20.0, 20.0), 0.2);
        let s = spiral(3000, 0.25);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let mut w = Swept::new(lattice);
            pool.install(|| w.cut(&s, 3.0));
            w.z.iter().map(|z| z.to_bits()).collect::<Vec<_>>()
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    #[ignore = "a measurement: run with --ignored --nocapture"]
    fn speed() {
        let lattice = Lattice::covering(Point2::new(-37.5, -37.5), Point2::new(37.5, 37.5), 0.05);
        let s = spiral(40_000, 0.25);
        let mut w = Swept::new(lattice);
        let t = std::time::Instant::now();
        w.cut(&s, 3.0);
        eprintln!(
            "{} segments, {} cells: {:?}",
            s.len(),
            lattice.len(),
            t.elapsed()
        );
    }
}
