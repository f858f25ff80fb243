//! How deep a ball with its shank stands in the part: the exact measure behind every suspected gouge.
//!
//! ```text
//!      | ray |      the tool is everything within R of the vertical ray that begins at the ball's centre:
//!      |  |  |      depth = R - distance(ray, part); the ray runs into the part: R + distance(centre, part)
//!      '._c_.'
//! ```

use crate::geom::{Point, Point2, Vector, nearest_on_segment, nearest_on_triangle};
use crate::part::Mesh;
use crate::sweep::buckets::Buckets;

/// A part's triangles sorted into square buckets in plan.
pub struct Depth<'a> {
    mesh: &'a Mesh,
    radius: f64,
    buckets: Buckets,
}

impl<'a> Depth<'a> {
    /// Sorts the part for a ball of this radius, mm.
    pub fn new(mesh: &'a Mesh, radius: f64) -> Depth<'a> {
        let b = mesh.bounds();
        let triangles = &mesh.triangles;
        let (min, max) = (b.min.xy(), b.max.xy());
        let buckets =
            Buckets::of_triangles(min, max, 0.25 * radius, triangles.len(), |i| &triangles[i]);
        Depth {
            mesh,
            radius,
            buckets,
        }
    }

    /// How deep the tool with its ball's centre at `c` stands in the part, mm; zero or less when it only touches or not even that.
    pub fn at(&self, c: &Point) -> f64 {
        let r = self.radius;
        let mut ray = f64::INFINITY;
        let mut ball = f64::INFINITY;
        let mut pierced = false;
        let buckets = &self.buckets;
        for by in buckets.rows(c.y - r, c.y + r) {
            for bx in buckets.columns(c.x - r, c.x + r) {
                for &i in buckets.of(by * buckets.nx + bx) {
                    let t = &self.mesh.triangles[i as usize];
                    if t.iter().all(|p| p.z < c.z - r) {
                        continue;
                    }
                    let near = nearest_on_triangle(t, c);
                    let d = (near - c).norm();
                    ball = ball.min(d);
                    if near.z <= c.z {
                        ray = ray.min(d);
                    }
                    let above = beside(t, c);
                    pierced |= above == 0.0;
                    ray = ray.min(above);
                }
            }
        }
        if pierced { r + ball } else { r - ray }
    }
}

/// Distance in plan from c to the part of a triangle at or above c; `+inf` if there is none.
fn beside(t: &[Point; 3], c: &Point) -> f64 {
    // Cut off what is below: at most four corners stay.
    let mut kept = [Vector::zeros(); 4];
    let mut n = 0;
    for k in 0..3 {
        let (a, b) = (t[k] - c, t[(k + 1) % 3] - c);
        if a.z >= 0.0 && n < 4 {
            kept[n] = a;
            n += 1;
        }
        if (a.z >= 0.0) != (b.z >= 0.0) && n < 4 {
            kept[n] = a + (b - a) * (a.z / (a.z - b.z));
            n += 1;
        }
    }
    let corners = &kept[..n];
    let mut best = f64::INFINITY;
    let (mut left, mut right) = (true, true);
    let mut area = 0.0;
    for (k, a) in corners.iter().enumerate() {
        let b = &corners[(k + 1) % n];
        let cross = a.x * b.y - a.y * b.x;
        area += cross;
        left &= cross >= 0.0;
        right &= cross <= 0.0;
        let near = nearest_on_segment(&Point2::origin(), &a.xy().into(), &b.xy().into());
        best = best.min(near.coords.norm());
    }
    // The origin lies inside when it is on the same side of all edges of a polygon that has an area.
    if n >= 3 && area != 0.0 && (left || right) {
        0.0
    } else {
        best
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        /// Points scattered over the triangle find nothing deeper, and something nearly as deep.
        #[test]
        fn one_triangle_by_sampling(v in prop::collection::vec(-2.0..2.0f64, 12)) {
            let p = |k: usize| Point::new(v[k], v[k + 1], v[k + 2]);
            let t = [p(0), p(3), p(6)];
            let c = p(9);
            let r = 1.5;
            let mesh = Mesh { triangles: vec![t] };
            let depth = Depth::new(&mesh, r).at(&c);
            let mut ray = f64::INFINITY;
            for i in 0..=150 {
                for j in 0..=150 - i {
                    let (a, b) = (f64::from(i) / 150.0, f64::from(j) / 150.0);
                    let q = t[0] + (t[1] - t[0]) * a + (t[2] - t[0]) * b;
                    let below = (c.z - q.z).max(0.0);
                    ray = ray.min(((q.x - c.x).powi(2) + (q.y - c.y).powi(2) + below * below).sqrt());
                }
            }
            // Where the ray meets the triangle the depth counts from the other side; far triangles may be left out.
            if depth < r && r - ray > 0.0 {
                prop_assert!(r - ray <= depth + 1e-9 && depth < r - ray + 0.05, "{depth} {}", r - ray);
            } else if depth < r {
                prop_assert!(depth < 0.05);
            } else {
                prop_assert!(ray < 0.05);
            }
        }
    }

    #[test]
    fn floors_walls_and_depths() {
        let p = Point::new;
        let mesh = Mesh {
            triangles: vec![
                [p(-9.0, -9.0, 0.0), p(9.0, -9.0, 0.0), p(0.0, 9.0, 0.0)],
                // An upright wall at x = 4, from the floor to z = 10.
                [p(4.0, -9.0, 0.0), p(4.0, 9.0, 0.0), p(4.0, 0.0, 10.0)],
            ],
        };
        let d = Depth::new(&mesh, 3.0);
        let near = |c: Point, want: f64| {
            let got = d.at(&c);
            assert!((got - want).abs() < 1e-12, "{c}: {got} for {want}");
        };
        near(p(0.0, 0.0, 3.0), 0.0);
        near(p(0.0, 0.0, 2.9), 0.1);
        near(p(0.0, 0.0, -1.0), 4.0);
        // Beside the wall one micrometre too near, with the wall's top far above: one micrometre, not the wall's height.
        near(p(1.001, 0.0, 3.0), 0.001);
        // The shank counts as well: the ball below the wall's foot would pass, its shank does not.
        assert!(d.at(&p(1.5, 0.0, 9.0)) > 0.49);
        assert!(d.at(&p(0.0, 0.0, 20.0)) <= 0.0);
    }
}
