//! How near the swept ball comes to a point: exact distances to the curtain above a path.
//!
//! ```text
//!      |  |  |  |       the tool is the ball and the shank above it: what it removes along a segment is everything within
//!      |__|__|__|       one radius of the vertical curtain above the segment of centres
//!     c0        c1
//! ```

use crate::geom::{Point, Point2};
use crate::sweep::Segment;

/// Segments of ball centres sorted into square buckets in plan. Work coordinates, mm.
#[derive(Clone, Debug)]
pub struct Paths {
    segments: Vec<Segment>,
    origin: Point2,
    size: f64,
    nx: usize,
    ny: usize,
    /// Where each bucket's list begins in `members`; one more entry than buckets.
    starts: Vec<u32>,
    members: Vec<u32>,
    /// Lowest centre of each bucket's segments.
    low: Vec<f64>,
}

impl Paths {
    /// Sorts segments; non-finite ones are left out. `size` is the side of a bucket, mm: a few times the spacing of passes.
    pub fn new(segments: &[Segment], size: f64) -> Paths {
        let segments: Vec<Segment> = segments
            .iter()
            .filter(|s| s.from.iter().chain(s.to.iter()).all(|v| v.is_finite()))
            .copied()
            .collect();
        let mut min = Point2::new(f64::INFINITY, f64::INFINITY);
        let mut max = Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
        for p in segments.iter().flat_map(|s| [s.from, s.to]) {
            min = min.inf(&p.xy());
            max = max.sup(&p.xy());
        }
        let wide = if segments.is_empty() {
            0.0
        } else {
            (max.x - min.x).max(max.y - min.y)
        };
        // At most some 4 million buckets.
        let size = size.max(wide / 2000.0).max(1e-6);
        let (nx, ny) = if segments.is_empty() {
            min = Point2::origin();
            (1, 1)
        } else {
            (
                ((max.x - min.x) / size) as usize + 1,
                ((max.y - min.y) / size) as usize + 1,
            )
        };
        let mut paths = Paths {
            segments,
            origin: min,
            size,
            nx,
            ny,
            starts: vec![0; nx * ny + 1],
            members: Vec::new(),
            low: vec![f64::INFINITY; nx * ny],
        };
        let mut count = vec![0u32; nx * ny];
        for s in &paths.segments {
            paths.buckets_of(s, |b| count[b] += 1);
        }
        let mut sum = 0u32;
        for (b, c) in count.iter().enumerate() {
            sum += c;
            paths.starts[b + 1] = sum;
        }
        let mut members = vec![0u32; sum as usize];
        let mut at = paths.starts.clone();
        for (i, s) in paths.segments.iter().enumerate() {
            paths.buckets_of(s, |b| {
                members[at[b] as usize] = i as u32;
                at[b] += 1;
            });
        }
        let mut low = vec![f64::INFINITY; nx * ny];
        for (b, low) in low.iter_mut().enumerate() {
            for &i in &members[paths.starts[b] as usize..paths.starts[b + 1] as usize] {
                let s = &paths.segments[i as usize];
                *low = low.min(s.from.z).min(s.to.z);
            }
        }
        paths.low = low;
        paths.members = members;
        paths
    }

    /// True when there is no segment.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    fn bucket(&self, v: f64, origin: f64, n: usize) -> usize {
        (((v - origin) / self.size).max(0.0) as usize).min(n - 1)
    }

    fn buckets_of(&self, s: &Segment, mut f: impl FnMut(usize)) {
        let (a, b) = if s.from.y <= s.to.y {
            (s.from, s.to)
        } else {
            (s.to, s.from)
        };
        for by in
            self.bucket(a.y, self.origin.y, self.ny)..=self.bucket(b.y, self.origin.y, self.ny)
        {
            // The part of the segment in this row of buckets, a little more for rounding.
            let pad = 1e-6 * self.size;
            let lo = self.origin.y + by as f64 * self.size - pad;
            let hi = lo + self.size + 2.0 * pad;
            let at = |y: f64| {
                if b.y > a.y {
                    a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0)
                } else {
                    a.x
                }
            };
            let (mut p, mut q) = (at(lo), at(hi));
            if b.y <= a.y {
                q = b.x;
            }
            if p > q {
                std::mem::swap(&mut p, &mut q);
            }
            for bx in self.bucket(p - pad, self.origin.x, self.nx)
                ..=self.bucket(q + pad, self.origin.x, self.nx)
            {
                f(by * self.nx + bx);
            }
        }
    }

    /// Distance from a point to the nearest curtain, mm; `+inf` when none comes as near as `limit`. Below one radius: the point
    /// is cut away.
    pub fn distance(&self, p: &Point, limit: f64) -> f64 {
        let mut best = limit;
        let mut found = false;
        if self.is_empty() {
            return f64::INFINITY;
        }
        let (cx, cy) = (
            ((p.x - self.origin.x) / self.size).floor(),
            ((p.y - self.origin.y) / self.size).floor(),
        );
        // Rings of buckets around the point's own (which may lie outside the sorted area).
        let mut ring = 0.0f64;
        loop {
            // All of ring k is at least (k - 1) sizes away, plus what is left of the own bucket: be modest.
            if (ring - 1.0) * self.size > best {
                break;
            }
            let y0 = (cy - ring).max(0.0);
            let y1 = (cy + ring).min(self.ny as f64 - 1.0);
            let mut y = y0;
            while y <= y1 {
                let edge = (y - cy).abs() == ring;
                let mut look = |x: f64| {
                    if x < 0.0 || x >= self.nx as f64 {
                        return;
                    }
                    let b = y as usize * self.nx + x as usize;
                    // Nothing in this bucket is nearer than its box, which begins at its lowest centre.
                    let gap = |v: f64, first: f64| {
                        (first - v).max(v - first - self.size).max(0.0) - 1e-5 * self.size
                    };
                    let dx = gap(p.x, self.origin.x + x * self.size).max(0.0);
                    let dy = gap(p.y, self.origin.y + y * self.size).max(0.0);
                    let dz = (self.low[b] - p.z).max(0.0);
                    if dx * dx + dy * dy + dz * dz > best * best {
                        return;
                    }
                    for &i in &self.members[self.starts[b] as usize..self.starts[b + 1] as usize] {
                        let d = curtain_distance(&self.segments[i as usize], p);
                        if d <= best {
                            best = d;
                            found = true;
                        }
                    }
                };
                if edge {
                    let mut x = (cx - ring).max(0.0);
                    while x <= (cx + ring).min(self.nx as f64 - 1.0) {
                        look(x);
                        x += 1.0;
                    }
                } else {
                    look(cx - ring);
                    look(cx + ring);
                }
                y += 1.0;
            }
            ring += 1.0;
        }
        if found { best } else { f64::INFINITY }
    }
}

/// Distance from a point to the vertical curtain above one segment, mm.
pub fn curtain_distance(s: &Segment, p: &Point) -> f64 {
    let d = s.to - s.from;
    let plan = d.x.hypot(d.y);
    let r = p - s.from;
    if plan < 1e-12 {
        let below = (s.from.z.min(s.to.z) - p.z).max(0.0);
        return (r.x * r.x + r.y * r.y + below * below).sqrt();
    }
    let (ux, uy) = (d.x / plan, d.y / plan);
    let a = ux * r.x + uy * r.y;
    let b = ux * r.y - uy * r.x;
    let slope = d.z / plan;
    let inside = (0.0..=plan).contains(&a) && r.z >= slope * a;
    if inside {
        return b.abs();
    }
    // In the plane of the curtain: the lower edge, or one of the upright edges.
    let t = ((a * plan + r.z * d.z) / (plan * plan + d.z * d.z)).clamp(0.0, 1.0);
    let edge = (a - t * plan).powi(2) + (r.z - t * d.z).powi(2);
    let first = a * a + (-r.z).max(0.0).powi(2);
    let last = (a - plan).powi(2) + (d.z - r.z).max(0.0).powi(2);
    (b * b + edge.min(first).min(last)).sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

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
        fn sorted_equals_plain(points in prop::collection::vec(point(6.0), 2..30), p in point(9.0), size in 0.2..3.0f64, limit in 0.1..6.0f64) {
            let s: Vec<Segment> = points.windows(2).map(|w| Segment { from: w[0], to: w[1] }).collect();
            let want = s.iter().map(|s| curtain_distance(s, &p)).fold(f64::INFINITY, f64::min);
            let got = Paths::new(&s, size).distance(&p, limit);
            if want <= limit { prop_assert_eq!(got, want) } else { prop_assert_eq!(got, f64::INFINITY) }
        }
    }

    #[test]
    fn no_paths_no_distance() {
        let p = Point::new(0.0, 0.0, 0.0);
        assert_eq!(Paths::new(&[], 1.0).distance(&p, 5.0), f64::INFINITY);
        let broken = Segment {
            from: p,
            to: Point::new(f64::NAN, 0.0, 0.0),
        };
        assert!(Paths::new(&[broken], 1.0).is_empty());
    }
}
