//! All that a ball touches where it stands: more than one place in a crease, in a corner, at the foot of a wall; and how much of a turn
//! of its way is the part's own.
//!
//! ```text
//!     \  a    b  /       the ball comes sliding along face a (its way is square to a's normal) and leaves along face b; where it turns
//!      \'--. .--'/       it touches both. Any way across the crease turns there: unfolded (b turned about the crease into the plane of
//!       \   v   /        a) or seen from above it may be straight. What turn is left then is the way's own
//! ```
//!
//! Crosses the border: a place of the ball's centre (work coordinates, mm) and ways (unit vectors) in; directions and angles out.

use super::drop::DropCutter;
use crate::geom::{Point, Vector, nearest_on_triangle};

/// Directions closer together than this (cosine) are one.
const SAME: f64 = 0.9998;
/// What comes this near to the ball where it turns is touched, mm: twice what a fit may stand off, and a rounding.
const TOUCH: f64 = 0.006;
/// A way slides along a face when it is square to its normal within this (sine): a chord is not quite a tangent.
const SLIDES: f64 = 0.2;
/// Faces that meet at less than this make no crease, rad; nor do two back to back.
const FOLD: std::ops::Range<f64> = 0.17..3.1;
/// Faces with a flatter normal are upright: seen from above they are lines.
const UPRIGHT: f64 = 0.1;

impl DropCutter {
    /// Unit vectors to the ball's centre from the places of the part that come within `slack` mm of the ball (or lie inside it), the
    /// nearest of each triangle; those that hardly differ only once, nearest first. One look at every triangle below the ball.
    pub fn touched(&self, center: &Point, slack: f64) -> Vec<Vector> {
        let r = self.radius() + slack;
        let triangles = self.within([center.x - r, center.y - r], [center.x + r, center.y + r]);
        let mut found: Vec<(f64, Vector)> = triangles
            .iter()
            .filter_map(|t| {
                let away = center - nearest_on_triangle(t, center);
                let d = away.norm();
                (d <= r && d > 0.0).then(|| (d, away / d))
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut out: Vec<Vector> = Vec::new();
        for (_, n) in found {
            if out.iter().all(|m| m.dot(&n) < SAME) {
                out.push(n);
            }
        }
        out
    }

    /// From the nearest place of the part within the ball's radius to the ball's centre.
    fn nearest(&self, center: &Point) -> Option<Vector> {
        let r = self.radius();
        let triangles = self.within([center.x - r, center.y - r], [center.x + r, center.y + r]);
        let clear = |t: &[Point; 3]| {
            t.iter().all(|p| p.z < center.z - r) || t.iter().all(|p| p.z > center.z + r)
        };
        triangles
            .iter()
            .filter(|t| !clear(t))
            .map(|t| center - nearest_on_triangle(t, center))
            .min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
            .filter(|away| away.norm() < r)
    }

    /// The ball moved out of what it is a little in, a hair further than it must; `None` where that takes more than `most` mm.
    pub fn pushed_out(&self, center: &Point, most: f64) -> Option<Point> {
        const HAIR: f64 = 3e-4;
        let mut at = *center;
        for _ in 0..12 {
            let Some(away) = self.nearest(&at) else {
                return Some(at);
            };
            let d = away.norm();
            let deep = self.radius() - d;
            if deep < HAIR {
                return Some(at);
            }
            at += away.try_normalize(1e-6)? * (deep + HAIR);
            if (at - center).norm() > most {
                return None;
            }
        }
        None
    }

    /// The turn from one way of the ball to the next (unit vectors) that is left when the part's crease at this place of its centre
    /// is taken out: never more than the turn itself. rad.
    pub fn own_turn(&self, center: &Point, before: &Vector, after: &Vector) -> f64 {
        let touched = self.touched(center, TOUCH);
        let along = |way: &Vector| {
            let way = *way;
            touched.iter().filter(move |n| n.dot(&way).abs() < SLIDES)
        };
        let mut own = angle(before, after);
        for a in along(before) {
            for b in along(after) {
                let axis = a.cross(b);
                let Some(crease) = axis.try_normalize(1e-9) else {
                    continue;
                };
                let fold = axis.norm().atan2(a.dot(b));
                if !FOLD.contains(&fold) {
                    continue;
                }
                let crease = nalgebra::Unit::new_unchecked(crease);
                let unfolded = nalgebra::Rotation3::from_axis_angle(&crease, fold) * before;
                own = own.min(angle(&unfolded, after));
                if b.z > UPRIGHT && before.xy().norm() > UPRIGHT {
                    // Straight on in plan, along face b.
                    let z = -(b.x * before.x + b.y * before.y) / b.z;
                    own = own.min(angle(&Vector::new(before.x, before.y, z), after));
                }
            }
        }
        own
    }
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;

    #[test]
    fn in_a_groove_two_walls_are_touched_and_on_a_floor_one() {
        // Walls at 45 degrees, and a floor from x = 10 on.
        let quad = |a: [f64; 3], b: [f64; 3]| {
            let (p, q) = (Point::new(a[0], -20.0, a[2]), Point::new(b[0], -20.0, b[2]));
            let (s, t) = (Point::new(a[0], 20.0, a[2]), Point::new(b[0], 20.0, b[2]));
            [[p, q, t], [p, t, s]]
        };
        let mut triangles = Vec::new();
        triangles.extend(quad([-10.0, 0.0, 10.0], [0.0, 0.0, 0.0]));
        triangles.extend(quad([0.0, 0.0, 0.0], [10.0, 0.0, 10.0]));
        triangles.extend(quad([10.0, 0.0, 10.0], [40.0, 0.0, 10.0]));
        let cutter = DropCutter::new(&Mesh { triangles }, 3.0);
        let s = 0.5f64.sqrt();
        let groove = cutter.touched(&Point::new(0.0, 0.0, 3.0 / s), 1e-3);
        assert_eq!(groove.len(), 2, "{groove:?}");
        assert!(
            groove
                .iter()
                .all(|n| (n.x.abs() - s).abs() < 1e-9 && (n.z - s).abs() < 1e-9)
        );
        let floor = cutter.touched(&Point::new(25.0, 0.0, 13.0), 1e-3);
        assert!(floor.iter().all(|n| n.z > 0.999), "{floor:?}");
        assert!(
            cutter
                .touched(&Point::new(25.0, 0.0, 14.0), 1e-3)
                .is_empty()
        );
    }

    #[test]
    fn a_ball_in_a_floor_is_pushed_up_out_of_it() {
        let p = |x: f64, y: f64| Point::new(x, y, 1.0);
        let triangles = vec![
            [p(-9.0, -9.0), p(9.0, -9.0), p(9.0, 9.0)],
            [p(-9.0, -9.0), p(9.0, 9.0), p(-9.0, 9.0)],
        ];
        let cutter = DropCutter::new(&Mesh { triangles }, 3.0);
        let low = Point::new(0.5, 0.2, 3.9);
        let out = cutter.pushed_out(&low, 0.2).unwrap();
        assert!((4.0..4.001).contains(&out.z) && (out.xy() - low.xy()).norm() < 1e-9);
        assert_eq!(cutter.pushed_out(&low, 0.05), None);
        let clear = Point::new(0.0, 0.0, 5.0);
        assert_eq!(cutter.pushed_out(&clear, 0.1), Some(clear));
    }
}
