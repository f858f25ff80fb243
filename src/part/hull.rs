//! The convex hull of a shadow and the smallest rectangle around it. Plan coordinates, any one unit; angles in radians.

use crate::geom::{Point2, RING};
use std::f64::consts::{FRAC_PI_2, PI};

/// Cross product of the two displacements from `o`.
fn cross(o: &Point2, a: &Point2, b: &Point2) -> f64 {
    (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x)
}

/// The convex hull, counter-clockwise, no three corners in line. Two passes over the points, then a sort of those outside the
/// polygon of the extremes in eight directions: for a rectangular part that leaves a handful.
pub fn convex_hull(points: impl Iterator<Item = Point2> + Clone) -> Vec<Point2> {
    let directions = RING.map(|(x, y)| (f64::from(x), f64::from(y)));
    let mut extremes: [Option<(f64, Point2)>; 8] = [None; 8];
    for p in points.clone() {
        for (e, (x, y)) in extremes.iter_mut().zip(directions) {
            let d = p.x * x + p.y * y;
            if e.is_none_or(|(best, _)| d > best) {
                *e = Some((d, p));
            }
        }
    }
    let octagon: Vec<Point2> = extremes.iter().flatten().map(|(_, p)| *p).collect();
    let inside = |p: &Point2| {
        (0..octagon.len()).all(|i| {
            let (a, b) = (&octagon[i], &octagon[(i + 1) % octagon.len()]);
            a == b || cross(a, b, p) > 0.0
        })
    };
    let mut left: Vec<Point2> = points.filter(|p| !inside(p)).collect();
    left.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    left.dedup();
    if left.len() < 3 {
        return left;
    }
    // Lower chain, then upper chain.
    let mut hull: Vec<Point2> = Vec::new();
    for pass in 0..2 {
        let start = hull.len();
        let mut step = |p: Point2| {
            while hull.len() >= start + 2
                && cross(&hull[hull.len() - 2], &hull[hull.len() - 1], &p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        };
        if pass == 0 {
            left.iter().for_each(|p| step(*p));
        } else {
            left.iter().rev().for_each(|p| step(*p));
        }
        hull.pop();
    }
    hull
}

/// Rotating calipers: a smallest rectangle has a side along a hull edge. Long side, short side, direction of the long side in
/// (-pi/2, pi/2]. Among rectangles equal within a millionth the one nearest to the axes wins.
pub fn smallest_rectangle(hull: &[Point2]) -> (f64, f64, f64) {
    let n = hull.len();
    if n < 3 {
        // A shadow that is a line, or a point.
        return match hull {
            [a, b] => ((b - a).norm(), 0.0, ((b.y - a.y) / (b.x - a.x)).atan()),
            _ => (0.0, 0.0, 0.0),
        };
    }
    let at = |i: usize| hull[i % n].coords;
    let mut all = Vec::with_capacity(n);
    let (mut far, mut top, mut near) = (1, 1, 1);
    for i in 0..n {
        let u = (at(i + 1) - at(i)).normalize();
        let v = nalgebra::Vector2::new(-u.y, u.x);
        let along = |k: usize, d: &nalgebra::Vector2<f64>| at(k).dot(d);
        // Each pointer only moves on, and at most once round.
        far = far.max(i + 1);
        while far < i + n && along(far + 1, &u) > along(far, &u) {
            far += 1;
        }
        top = top.max(far);
        while top < i + n && along(top + 1, &v) > along(top, &v) {
            top += 1;
        }
        near = near.max(top);
        while near < i + n && along(near + 1, &u) < along(near, &u) {
            near += 1;
        }
        let (w, h) = (
            along(far, &u) - along(near, &u),
            along(top, &v) - along(i, &v),
        );
        let direction = if h > w { v } else { u };
        let mut angle = direction.y.atan2(direction.x);
        if angle <= -FRAC_PI_2 {
            angle += PI;
        } else if angle > FRAC_PI_2 {
            angle -= PI;
        }
        all.push((w.max(h), w.min(h), angle));
    }
    let least = all.iter().map(|r| r.0 * r.1).fold(f64::INFINITY, f64::min);
    let off_axis = |angle: f64| (angle - FRAC_PI_2 * (angle / FRAC_PI_2).round()).abs();
    all.into_iter()
        .filter(|r| r.0 * r.1 <= least * (1.0 + 1e-6) + f64::MIN_POSITIVE)
        .min_by(|a, b| {
            off_axis(a.2)
                .total_cmp(&off_axis(b.2))
                .then(a.2.abs().total_cmp(&b.2.abs()))
        })
        .unwrap_or((0.0, 0.0, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rectangle_of_known_hulls() {
        let p = |x: f64, y: f64| Point2::new(x, y);
        let tilted: Vec<Point2> = [(0.0, 0.0), (4.0, 3.0), (2.5, 5.0), (-1.5, 2.0), (1.0, 2.0)]
            .iter()
            .map(|q| p(q.0, q.1))
            .collect();
        let hull = convex_hull(tilted.iter().copied());
        assert_eq!(hull.len(), 4);
        let (l, s, a) = smallest_rectangle(&hull);
        assert!(
            (l - 5.0).abs() < 1e-12
                && (s - 2.5).abs() < 1e-12
                && (a - 0.75f64.atan()).abs() < 1e-12
        );
        assert_eq!(smallest_rectangle(&[p(1.0, 1.0)]), (0.0, 0.0, 0.0));
        assert_eq!(
            smallest_rectangle(&convex_hull([p(0.0, 0.0), p(0.0, 2.0)].into_iter())),
            (2.0, 0.0, FRAC_PI_2)
        );
    }

    proptest! {
        /// Every point is inside the hull; the rectangle is no larger than the axis-aligned box and no smaller than the hull.
        #[test]
        fn hull_and_rectangle_hold(points in proptest::collection::vec((-9i8..9, -9i8..9), 1..60)) {
            let points: Vec<Point2> = points.iter().map(|q| Point2::new(q.0.into(), q.1.into())).collect();
            let hull = convex_hull(points.iter().copied());
            let n = hull.len();
            let mut area2 = 0.0;
            if n >= 3 {
                for i in 0..n {
                    let (a, b) = (&hull[i], &hull[(i + 1) % n]);
                    prop_assert!(points.iter().all(|p| cross(a, b, p) >= 0.0));
                    prop_assert!(cross(a, b, &hull[(i + 2) % n]) > 0.0);
                    area2 += a.x * b.y - a.y * b.x;
                }
            }
            let (l, s, angle) = smallest_rectangle(&hull);
            let fold = |f: fn(&Point2) -> f64| {
                let v: Vec<f64> = points.iter().map(f).collect();
                v.iter().copied().fold(f64::MIN, f64::max) - v.iter().copied().fold(f64::MAX, f64::min)
            };
            prop_assert!(l >= s && s >= 0.0 && angle.abs() <= FRAC_PI_2);
            prop_assert!(l * s <= fold(|p| p.x) * fold(|p| p.y) + 1e-9);
            prop_assert!(l * s >= area2 / 2.0 - 1e-9);
            // The brute-force minimum over all hull edges.
            if n >= 3 {
                let best = (0..n).map(|i| {
                    let u = (hull[(i + 1) % n] - hull[i]).normalize();
                    let v = nalgebra::Vector2::new(-u.y, u.x);
                    let span = |d: &nalgebra::Vector2<f64>| {
                        let t: Vec<f64> = hull.iter().map(|p| p.coords.dot(d)).collect();
                        t.iter().copied().fold(f64::MIN, f64::max) - t.iter().copied().fold(f64::MAX, f64::min)
                    };
                    span(&u) * span(&v)
                }).fold(f64::MAX, f64::min);
                prop_assert!((l * s - best).abs() <= 2e-6 * best + 1e-9, "{} {}", l * s, best);
            }
        }
    }
}
