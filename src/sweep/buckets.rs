//! Things sorted into square buckets in plan, so that only those near a place are looked at.

use crate::geom::{Point, Point2};
use std::ops::RangeInclusive;

/// Which things touch which square. Plan coordinates, mm. What lies beyond the area goes into the buckets at its rim.
#[derive(Clone, Debug)]
pub(crate) struct Buckets {
    /// Corner of bucket (0, 0).
    pub origin: Point2,
    /// Side of a bucket, mm.
    pub size: f64,
    /// Buckets along X.
    pub nx: usize,
    /// Buckets along Y.
    pub ny: usize,
    /// Where each bucket's list begins in `members`; one more entry than buckets.
    starts: Vec<usize>,
    members: Vec<u32>,
}

/// Entries of all lists together, at most: beyond it the buckets are made larger.
const MOST_ENTRIES: usize = 1 << 26;

impl Buckets {
    /// Sorts `count` things over the area from `min` to `max`. `visit(buckets, i, put)` calls `put` with each bucket that thing i
    /// touches. `size` is the side wanted; larger ones are used where there would be more than 2000 on a side, or too many
    /// entries. An area that is empty or not finite is one bucket.
    pub fn new(
        min: Point2,
        max: Point2,
        size: f64,
        count: usize,
        visit: impl Fn(&Buckets, usize, &mut dyn FnMut(usize)),
    ) -> Buckets {
        let sound = min.x <= max.x && min.y <= max.y && (max - min).iter().all(|w| w.is_finite());
        let (w, h) = if sound {
            (max.x - min.x, max.y - min.y)
        } else {
            (0.0, 0.0)
        };
        let mut size = size.max(w.max(h) / 2000.0).max(1e-6);
        loop {
            let (nx, ny) = ((w / size) as usize + 1, (h / size) as usize + 1);
            let mut b = Buckets {
                origin: if sound { min } else { Point2::origin() },
                size,
                nx,
                ny,
                starts: vec![0; nx * ny + 1],
                members: Vec::new(),
            };
            let mut counts = vec![0usize; nx * ny];
            for i in 0..count {
                visit(&b, i, &mut |k| counts[k] += 1);
            }
            let mut sum = 0;
            for (k, c) in counts.iter().enumerate() {
                sum += c;
                b.starts[k + 1] = sum;
            }
            if sum > MOST_ENTRIES && nx * ny > 1 {
                size *= 2.0;
                continue;
            }
            let mut at = b.starts.clone();
            let mut members = vec![0u32; sum];
            for i in 0..count {
                visit(&b, i, &mut |k| {
                    members[at[k]] = i as u32;
                    at[k] += 1;
                });
            }
            b.members = members;
            return b;
        }
    }

    /// Sorts triangles into the buckets that the boxes about them touch; the area and the side as for [`Buckets::new`].
    pub fn of_triangles<'t>(
        min: Point2,
        max: Point2,
        size: f64,
        count: usize,
        triangle: impl Fn(usize) -> &'t [Point; 3],
    ) -> Buckets {
        Buckets::new(min, max, size, count, |b, i, put| {
            let t = triangle(i);
            let (lo, hi) = (t[0].inf(&t[1]).inf(&t[2]), t[0].sup(&t[1]).sup(&t[2]));
            for by in b.rows(lo.y, hi.y) {
                for bx in b.columns(lo.x, hi.x) {
                    put(by * b.nx + bx);
                }
            }
        })
    }

    /// Column of an X; the nearest one beyond the area.
    #[inline]
    pub fn column(&self, x: f64) -> usize {
        self.along(x - self.origin.x, self.nx)
    }

    /// Row of a Y; the nearest one beyond the area.
    #[inline]
    pub fn row(&self, y: f64) -> usize {
        self.along(y - self.origin.y, self.ny)
    }

    #[inline]
    fn along(&self, from_origin: f64, n: usize) -> usize {
        ((from_origin / self.size).max(0.0) as usize).min(n - 1)
    }

    /// Columns of an interval of X.
    #[inline]
    pub fn columns(&self, lo: f64, hi: f64) -> RangeInclusive<usize> {
        self.column(lo)..=self.column(hi)
    }

    /// Rows of an interval of Y.
    #[inline]
    pub fn rows(&self, lo: f64, hi: f64) -> RangeInclusive<usize> {
        self.row(lo)..=self.row(hi)
    }

    /// How many buckets there are.
    pub fn len(&self) -> usize {
        self.nx * self.ny
    }

    /// The things in a bucket, in order.
    #[inline]
    pub fn of(&self, bucket: usize) -> &[u32] {
        &self.members[self.starts[bucket]..self.starts[bucket + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(at: &[(f64, f64)], size: f64) -> Buckets {
        let corner = |v: f64| Point2::new(v, v);
        Buckets::new(corner(0.0), corner(10.0), size, at.len(), |b, i, put| {
            put(b.row(at[i].1) * b.nx + b.column(at[i].0));
        })
    }

    #[test]
    fn each_thing_is_where_it_lies_or_at_the_rim() {
        let b = points(&[(0.5, 0.5), (9.5, 0.5), (-40.0, 1e9), (0.7, 0.2)], 1.0);
        assert_eq!((b.nx, b.ny, b.len()), (11, 11, 121));
        assert_eq!(b.of(0), [0, 3]);
        assert_eq!(b.of(9), [1]);
        assert_eq!(b.of(10 * 11), [2]);
        assert_eq!((0..b.len()).map(|k| b.of(k).len()).sum::<usize>(), 4);
        assert_eq!(b.columns(-5.0, 2.5), 0..=2);
        assert_eq!(b.rows(9.0, 99.0), 9..=10);
    }

    #[test]
    fn never_more_than_two_thousand_on_a_side_and_nonsense_is_one_bucket() {
        let b = points(&[], 1e-9);
        assert_eq!((b.nx, b.ny), (2001, 2001));
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            let b = Buckets::new(
                Point2::new(0.0, 0.0),
                Point2::new(bad, 1.0),
                1.0,
                1,
                |_, _, put| put(0),
            );
            assert_eq!((b.len(), b.of(0)), (1, [0u32].as_slice()));
        }
    }
}
