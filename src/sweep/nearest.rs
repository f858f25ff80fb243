//! How near the swept ball comes to a point: exact distances to the curtain above a path.
//!
//! ```text
//!      |  |  |  |       the tool is the ball and the shank above it: what it removes along a segment is everything within
//!      |__|__|__|       one radius of the vertical curtain above the segment of centres
//!     c0        c1
//! ```

use crate::geom::{Point, Point2, Vector2};
use crate::sweep::Segment;
use crate::sweep::buckets::Buckets;
use std::borrow::Borrow;

/// Sides of a bucket from the area asked about to the buckets at the rim. Buckets are a quarter of the ball's radius wide, and what is
/// farther from a place than a radius and some allowance is seldom asked for.
const MARGIN: f64 = 8.0;

/// Segments of ball centres sorted into square buckets in plan. Work coordinates, mm.
#[derive(Clone, Debug)]
pub struct Paths {
    curtains: Vec<Curtain>,
    buckets: Buckets,
    /// Lowest centre of each bucket's segments.
    low: Vec<f64>,
}

impl Paths {
    /// Sorts segments; non-finite ones are left out. `size` is the side of a bucket, mm: a few times the spacing of passes.
    /// `asked` is the area (two corners) that holds all places that will be asked about: buckets are spent on it alone, however
    /// far a program wanders.
    pub fn new<S: Borrow<Segment>>(
        segments: impl IntoIterator<Item = S>,
        size: f64,
        asked: (Point2, Point2),
    ) -> Paths {
        let segments: Vec<Segment> = segments
            .into_iter()
            .map(|s| *s.borrow())
            .filter(|s| s.from.iter().chain(s.to.iter()).all(|v| v.is_finite()))
            .collect();
        let mut min = Point2::new(f64::INFINITY, f64::INFINITY);
        let mut max = Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
        for p in segments.iter().flat_map(|s| [s.from, s.to]) {
            min = min.inf(&p.xy());
            max = max.sup(&p.xy());
        }
        // What lies beyond goes into the buckets at the rim: they are nearer to any place asked about than it is.
        // Those are kept so far away that hardly any place looks into them: a program cut beside the part (a wrong zero) crowds them.
        let margin = Vector2::repeat(MARGIN * size);
        let (first, last) = (asked.0 - margin, asked.1 + margin);
        let min = min.sup(&first).inf(&last);
        let max = max.inf(&last).sup(&min);
        let buckets = Buckets::new(min, max, size, segments.len(), |b, i, put| {
            touched(b, &segments[i], put);
        });
        let low = (0..buckets.len())
            .map(|b| {
                let lowest = |i: &u32| {
                    let s = &segments[*i as usize];
                    s.from.z.min(s.to.z)
                };
                buckets
                    .of(b)
                    .iter()
                    .map(lowest)
                    .fold(f64::INFINITY, f64::min)
            })
            .collect();
        Paths {
            curtains: segments.iter().map(Curtain::above).collect(),
            buckets,
            low,
        }
    }

    /// True when there is no segment.
    pub fn is_empty(&self) -> bool {
        self.curtains.is_empty()
    }

    /// Puts into `out` all curtains that come within this distance (mm) of a point, for asking about many points near it.
    pub(super) fn around(&self, p: &Point, within: f64, out: &mut Vec<Curtain>) {
        out.clear();
        if self.is_empty() {
            return;
        }
        let buckets = &self.buckets;
        let within_sq = within * within;
        let gap_sq = |v: f64, first: f64| self.gap(v, first).powi(2);
        let wide = within + 1e-4 * buckets.size;
        let columns = buckets.columns(p.x - wide, p.x + wide);
        for by in buckets.rows(p.y - wide, p.y + wide) {
            let dy_sq = gap_sq(p.y, buckets.origin.y + by as f64 * buckets.size);
            for bx in columns.clone() {
                let b = by * buckets.nx + bx;
                let dz = (self.low[b] - p.z).max(0.0);
                let dx_sq = gap_sq(p.x, buckets.origin.x + bx as f64 * buckets.size);
                if dx_sq + dy_sq + dz * dz > within_sq {
                    continue;
                }
                let near = buckets.of(b).iter().map(|&i| &self.curtains[i as usize]);
                out.extend(near.filter(|c| c.distance_sq(p) <= within_sq));
            }
        }
    }

    /// From a coordinate to a bucket's span that begins at `first`, a hair less.
    #[inline]
    fn gap(&self, v: f64, first: f64) -> f64 {
        let size = self.buckets.size;
        ((first - v).max(v - first - size) - 1e-5 * size).max(0.0)
    }

    /// Distance from a point to the nearest curtain, mm; `+inf` when none comes as near as `limit`. Below one radius: the point
    /// is cut away. `expected` is where in plan the nearest centre may be: a good guess is quick, a bad one is only slower.
    pub fn distance(&self, p: &Point, limit: f64, expected: &Point2) -> f64 {
        if self.is_empty() {
            return f64::INFINITY;
        }
        let mut near = Near {
            best_sq: limit * limit,
            found: false,
        };
        let buckets = &self.buckets;
        let size = buckets.size;
        // Nothing in a bucket is nearer than its box, which begins at its lowest centre.
        let gap_sq = |v: f64, first: f64| self.gap(v, first).powi(2);
        let (gx, gy) = (buckets.column(expected.x), buckets.row(expected.y));
        let guess = gy * buckets.nx + gx;
        // Where all of a program lies beside the part the guess is a bucket at the rim, full and far away.
        if gap_sq(p.x, buckets.origin.x + gx as f64 * size)
            + gap_sq(p.y, buckets.origin.y + gy as f64 * size)
            <= near.best_sq
        {
            self.look(guess, p, &mut near);
        }
        let within = near.best_sq.sqrt() + 1e-4 * size;
        let columns = buckets.columns(p.x - within, p.x + within);
        for by in buckets.rows(p.y - within, p.y + within) {
            let dy_sq = gap_sq(p.y, buckets.origin.y + by as f64 * size);
            if dy_sq > near.best_sq {
                continue;
            }
            for bx in columns.clone() {
                let b = by * buckets.nx + bx;
                let dz = (self.low[b] - p.z).max(0.0);
                let dx_sq = gap_sq(p.x, buckets.origin.x + bx as f64 * size);
                if b != guess && dx_sq + dy_sq + dz * dz <= near.best_sq {
                    self.look(b, p, &mut near);
                }
            }
        }
        if near.found {
            near.best_sq.sqrt()
        } else {
            f64::INFINITY
        }
    }

    #[inline]
    fn look(&self, bucket: usize, p: &Point, near: &mut Near) {
        for &i in self.buckets.of(bucket) {
            let d_sq = self.curtains[i as usize].distance_sq(p);
            if d_sq <= near.best_sq {
                near.best_sq = d_sq;
                near.found = true;
            }
        }
    }
}

/// The buckets that a segment passes through in plan, and perhaps a neighbour.
fn touched(buckets: &Buckets, s: &Segment, put: &mut dyn FnMut(usize)) {
    let (a, b) = if s.from.y <= s.to.y {
        (s.from, s.to)
    } else {
        (s.to, s.from)
    };
    let pad = 1e-6 * buckets.size;
    for by in buckets.rows(a.y, b.y) {
        // The part of the segment in this row of buckets, a little more for rounding; the rim's rows reach on outwards.
        let mut lo = buckets.origin.y + by as f64 * buckets.size - pad;
        let mut hi = lo + buckets.size + 2.0 * pad;
        if by == 0 {
            lo = f64::NEG_INFINITY;
        }
        if by + 1 == buckets.ny {
            hi = f64::INFINITY;
        }
        let (p, q) = if b.y > a.y {
            let at = |y: f64| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0);
            (at(lo), at(hi))
        } else {
            (a.x, b.x)
        };
        for bx in buckets.columns(p.min(q) - pad, p.max(q) + pad) {
            put(by * buckets.nx + bx);
        }
    }
}

/// The nearest so far.
struct Near {
    best_sq: f64,
    found: bool,
}

/// The vertical strip above one segment, with what every distance to it needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curtain {
    from: Point,
    /// Direction in plan; zero for an upright segment.
    ux: f64,
    uy: f64,
    /// Length in plan, and rise.
    plan: f64,
    rise: f64,
    slope: f64,
    length_sq: f64,
}

impl Curtain {
    fn above(s: &Segment) -> Curtain {
        let d = s.to - s.from;
        let plan = (d.x * d.x + d.y * d.y).sqrt();
        let upright = plan < 1e-12;
        let per_plan = |v: f64| if upright { 0.0 } else { v / plan };
        Curtain {
            from: s.from,
            ux: per_plan(d.x),
            uy: per_plan(d.y),
            plan: if upright { 0.0 } else { plan },
            rise: d.z,
            slope: per_plan(d.z),
            length_sq: plan * plan + d.z * d.z,
        }
    }

    pub(super) fn distance_sq(&self, p: &Point) -> f64 {
        let r = p - self.from;
        if self.plan == 0.0 {
            let below = (self.rise.min(0.0) - r.z).max(0.0);
            return r.x * r.x + r.y * r.y + below * below;
        }
        let a = self.ux * r.x + self.uy * r.y;
        let b = self.ux * r.y - self.uy * r.x;
        if a >= 0.0 && a <= self.plan && r.z >= self.slope * a {
            return b * b;
        }
        // In the plane of the curtain: the lower edge, or one of the upright edges.
        let t = ((a * self.plan + r.z * self.rise) / self.length_sq).clamp(0.0, 1.0);
        let edge = (a - t * self.plan).powi(2) + (r.z - t * self.rise).powi(2);
        let first = a * a + (-r.z).max(0.0).powi(2);
        let last = (a - self.plan).powi(2) + (self.rise - r.z).max(0.0).powi(2);
        b * b + edge.min(first).min(last)
    }
}

/// Distance from a point to the vertical curtain above one segment, mm.
pub fn curtain_distance(s: &Segment, p: &Point) -> f64 {
    Curtain::above(s).distance_sq(p).sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn corner(v: f64) -> Point2 {
        Point2::new(v, v)
    }

    fn point(s: f64) -> impl Strategy<Value = Point> {
        (-s..s, -s..s, -s..s).prop_map(|(x, y, z)| Point::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        /// Sampling the curtain finds nothing nearer, and something as near.
        #[test]
        fn curtain_by_sampling(from in point(3.0), to in point(3.0), p in point(4.0)) {
            let s = Segment { from, to };
            let d = curtain_distance(&s, &p);
            let mut best = f64::INFINITY;
            for i in 0..=4000 {
                let c = from + (to - from) * (f64::from(i) / 4000.0);
                let below = (c.z - p.z).max(0.0);
                best = best.min(((c.x - p.x).powi(2) + (c.y - p.y).powi(2) + below * below).sqrt());
            }
            prop_assert!(d <= best + 1e-12 && best < d + 2e-3, "{d} {best}");
        }

        #[test]
        fn sorted_equals_plain(points in prop::collection::vec(point(6.0), 2..30), p in point(9.0), size in 0.2..3.0f64, limit in 0.1..6.0f64, guess in point(12.0)) {
            let s: Vec<Segment> = points.windows(2).map(|w| Segment { from: w[0], to: w[1] }).collect();
            let want = s.iter().map(|s| curtain_distance(s, &p)).fold(f64::INFINITY, f64::min);
            let got = Paths::new(&s, size, (corner(-9.0), corner(9.0))).distance(&p, limit, &guess.xy());
            if want <= limit { prop_assert_eq!(got, want) } else { prop_assert_eq!(got, f64::INFINITY) }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        /// Buckets on a small area, segments far beyond it: the answers inside the area are the same.
        #[test]
        fn segments_beyond_the_area(points in prop::collection::vec(point(60.0), 2..30), p in point(2.0), size in 0.2..3.0f64, limit in 0.1..40.0f64) {
            let s: Vec<Segment> = points.windows(2).map(|w| Segment { from: w[0], to: w[1] }).collect();
            let want = s.iter().map(|s| curtain_distance(s, &p)).fold(f64::INFINITY, f64::min);
            let got = Paths::new(&s, size, (corner(-2.0), corner(2.0))).distance(&p, limit, &p.xy());
            if want <= limit { prop_assert_eq!(got, want) } else { prop_assert_eq!(got, f64::INFINITY) }
        }
    }

    #[test]
    fn no_paths_no_distance() {
        let p = Point::new(0.0, 0.0, 0.0);
        assert_eq!(
            Paths::new([] as [Segment; 0], 1.0, (corner(0.0), corner(1.0))).distance(
                &p,
                5.0,
                &p.xy()
            ),
            f64::INFINITY
        );
        let broken = Segment {
            from: p,
            to: Point::new(f64::NAN, 0.0, 0.0),
        };
        assert!(Paths::new([broken], 1.0, (corner(0.0), corner(1.0))).is_empty());
    }
}
