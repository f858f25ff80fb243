//! A ball lowered onto one triangle: facet, edges and vertices.
//!
//! All of it is closed form. With the ball's axis at (x, y) and its radius R:
//!
//! ```text
//! vertex v   d = |xy - v.xy|           centre z = v.z + sqrt(R^2 - d^2)
//! edge       d = distance of xy to the edge's line in plan, r = sqrt(R^2 - d^2) the radius of the ball's
//!            cut by the edge's vertical plane; a circle of radius r resting on a line of slope m has its
//!            centre r sqrt(1 + m^2) above the line and touches r m / sqrt(1 + m^2) uphill of its axis
//! facet      the contact is c - R n, so it lies at xy - R n.xy in plan whatever the height
//! ```
//!
//! Classical drop cutter algebra; see e.g. H.-T. Yau et al., *Numerical control machining simulation*, IJPR 2004, for the split
//! into facet, edge and vertex contact.

use crate::geom::{Point, Vector};

/// What of a triangle the ball rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rest {
    /// Its inside.
    Facet,
    /// An edge, from corner `.0` to the next, at the share `.1` of it.
    Edge(usize, f64),
    /// A corner.
    Corner(usize),
}

/// Height of the ball's centre when lowered along (x, y) onto one triangle, and the point it touches. `None` when the ball
/// passes the triangle by. A triangle without area still has edges and vertices.
pub fn touch(t: &[Point; 3], radius: f64, x: f64, y: f64) -> Option<(f64, Point)> {
    let n = normal(t);
    let (z, rest) = lower(t, &n, radius, x, y, f64::NEG_INFINITY)?;
    let point = match rest {
        Rest::Facet => Point::new(x - radius * n.x, y - radius * n.y, z - radius * n.z),
        Rest::Corner(i) => t[i],
        Rest::Edge(i, f) => t[i] + (t[(i + 1) % 3] - t[i]) * f,
    };
    Some((z, point))
}

/// As [`touch`], the height alone.
#[inline]
pub fn touch_height(t: &[Point; 3], radius: f64, x: f64, y: f64) -> Option<f64> {
    touch_above(t, &normal(t), radius, x, y, f64::NEG_INFINITY)
}

/// As [`touch_height`], for a triangle with its [`normal`]. May answer `None` if it can tell that the height is below `floor`.
#[inline]
pub fn touch_above(
    t: &[Point; 3],
    n: &Vector,
    radius: f64,
    x: f64,
    y: f64,
    floor: f64,
) -> Option<f64> {
    lower(t, n, radius, x, y, floor).map(|(z, _)| z)
}

/// Unit normal of a triangle, upwards; zero if it is upright or without area: then its edges do the work.
pub fn normal(t: &[Point; 3]) -> Vector {
    let n = (t[1] - t[0]).cross(&(t[2] - t[0]));
    let len = n.norm();
    if n.z.abs() <= 1e-12 * len || len <= 0.0 {
        Vector::zeros()
    } else {
        n / if n.z < 0.0 { -len } else { len }
    }
}

/// Planes steeper than this (n.z) are too ill-conditioned as heights over (x, y) to refuse a triangle by.
const STEEP: f64 = 0.01;

#[inline(always)]
fn lower(
    t: &[Point; 3],
    n: &Vector,
    radius: f64,
    x: f64,
    y: f64,
    floor: f64,
) -> Option<(f64, Rest)> {
    if n.z > 0.0 {
        // The contact, seen from the first corner.
        let (px, py) = (x - t[0].x - radius * n.x, y - t[0].y - radius * n.y);
        let z = t[0].z - (px * n.x + py * n.y) / n.z + radius * n.z;
        let (ux, uy) = (t[1].x - t[0].x, t[1].y - t[0].y);
        let (vx, vy) = (t[2].x - t[0].x, t[2].y - t[0].y);
        let (wx, wy) = (vx - ux, vy - uy);
        // On which side of each edge, in plan; positive inside.
        let turn = if ux * vy - uy * vx < 0.0 { -1.0 } else { 1.0 };
        let sides = [
            turn * (ux * py - uy * px),
            turn * (wx * (py - uy) - wy * (px - ux)),
            turn * (vy * px - vx * py),
        ];
        if sides.iter().all(|s| *s >= 0.0) {
            // A ball that touches the inside of a facet cannot be held higher by the same facet's rim.
            return Some((z, Rest::Facet));
        }
        if n.z > STEEP {
            // The rim is at least so far from the contact; what that costs in height is derived in `bvh`.
            let mut e2 = 0.0;
            for (s, len2) in
                sides
                    .iter()
                    .zip([ux * ux + uy * uy, wx * wx + wy * wy, vx * vx + vy * vy])
            {
                let d2 = s * s / len2;
                if *s < 0.0 && d2 > e2 {
                    e2 = d2;
                }
            }
            if z - e2 / (radius + (radius * radius + e2).sqrt()) < floor {
                return None;
            }
        }
    }
    let mut best: Option<(f64, Rest)> = None;
    let mut offer = |z: f64, rest: Rest| {
        if best.is_none_or(|(b, _)| z > b) {
            best = Some((z, rest));
        }
    };
    let r2 = radius * radius;
    for i in 0..3 {
        let (a, b) = (&t[i], &t[(i + 1) % 3]);
        let (dx, dy) = (x - a.x, y - a.y);
        let d2 = dx * dx + dy * dy;
        if d2 <= r2 {
            offer(a.z + (r2 - d2).sqrt(), Rest::Corner(i));
        }
        let (ex, ey, ez) = (b.x - a.x, b.y - a.y, b.z - a.z);
        let len2 = ex * ex + ey * ey;
        if len2 <= 0.0 {
            continue; // upright or a point: its ends hold the ball
        }
        let per_len2 = 1.0 / len2;
        let cross = dx * ey - dy * ex;
        let d2 = cross * cross * per_len2;
        if d2 > r2 {
            continue;
        }
        // r / sqrt(1 + m^2): height of the centre above the contact. Uphill of the axis it lies by m times as much.
        let up = ((r2 - d2) / (1.0 + ez * ez * per_len2)).sqrt();
        let f = (dx * ex + dy * ey + up * ez) * per_len2;
        if (0.0..=1.0).contains(&f) {
            offer(a.z + ez * f + up, Rest::Edge(i, f));
        }
    }
    best
}

/// True when (x, y) lies in the triangle's shadow on the table, rim included. False for upright triangles.
#[inline]
pub fn inside_in_plan(t: &[Point; 3], x: f64, y: f64) -> bool {
    let side = |a: &Point, b: &Point| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    let (u, v, w) = (side(&t[0], &t[1]), side(&t[1], &t[2]), side(&t[2], &t[0]));
    let area = u + v + w;
    if area == 0.0 {
        return false;
    }
    (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    /// Distance from a point to a triangle, by brute algebra of its own: projection on the plane, else on the edges.
    pub fn distance(t: &[Point; 3], c: &Point) -> f64 {
        let on_segment = |a: &Point, b: &Point| {
            let e = b - a;
            let l = e.norm_squared();
            let s = if l > 0.0 {
                ((c - a).dot(&e) / l).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (c - (a + e * s)).norm()
        };
        let mut d = on_segment(&t[0], &t[1])
            .min(on_segment(&t[1], &t[2]))
            .min(on_segment(&t[2], &t[0]));
        let n = (t[1] - t[0]).cross(&(t[2] - t[0]));
        if n.norm() > 1e-12 {
            let n = n.normalize();
            let h = (c - t[0]).dot(&n);
            let q = c - n * h;
            let inside = (0..3).all(|i| (t[(i + 1) % 3] - t[i]).cross(&(q - t[i])).dot(&n) >= 0.0);
            if inside {
                d = d.min(h.abs());
            }
        }
        d
    }

    fn coordinate() -> impl Strategy<Value = f64> {
        -5.0..5.0f64
    }

    fn triangle() -> impl Strategy<Value = [Point; 3]> {
        proptest::array::uniform9(coordinate()).prop_map(|v| {
            [
                Point::new(v[0], v[1], v[2]),
                Point::new(v[3], v[4], v[5]),
                Point::new(v[6], v[7], v[8]),
            ]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

        /// By brute algebra of the test's own.
        #[test]
        fn the_closest_point_is_on_it_and_no_other_is_closer(t in triangle(), c in proptest::array::uniform3(coordinate())) {
            let c = Point::from(c);
            let q = crate::geom::nearest_on_triangle(&t, &c);
            prop_assert!(distance(&t, &q) < 1e-7);
            prop_assert!(((c - q).norm() - distance(&t, &c)).abs() < 1e-7);
        }

        /// The ball rests: it touches the triangle, the contact is at R, and any lower it would enter it.
        #[test]
        fn the_ball_rests_on_the_triangle(t in triangle(), x in coordinate(), y in coordinate(), r in 0.3..4.0f64) {
            if let Some((z, p)) = touch(&t, r, x, y) {
                let c = Point::new(x, y, z);
                prop_assert!((distance(&t, &c) - r).abs() < 1e-7);
                prop_assert!(((p - c).norm() - r).abs() < 1e-7);
                prop_assert!(distance(&t, &p) < 1e-7);
                prop_assert!(p.z <= z + 1e-9, "touched from above");
                for k in 1..40 {
                    let above = Point::new(x, y, z + 0.25 * k as f64);
                    prop_assert!(distance(&t, &above) > r - 1e-7, "free above");
                }
            } else {
                for k in -60..60 {
                    prop_assert!(distance(&t, &Point::new(x, y, 0.25 * k as f64)) > r - 1e-7);
                }
            }
        }
    }
}
