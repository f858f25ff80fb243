//! Arcs as CL files tell them: a circle, where the tool is, and where it goes.
//!
//! Crosses the border: places of the tool tip, mm, and directions in; [`Bow`]s out. The sense of an axis is the right hand's here: seen against
//! the axis the turn is counter-clockwise. Writers of the other sense turn their axis before they call.

use super::error::ClProblem;
use super::step::Bow;
use crate::geom::{Plane, Point, Vector};
use std::f64::consts::TAU;

/// How far a point may lie off its circle, mm. CAD systems write four decimals of mm or inch; controllers take 0.005 to 0.013 mm.
pub(super) const OFF_CIRCLE: f64 = 0.01;

/// An axis may lean by this much and still be one of the machine's (seven decimals are written).
const LEAN: f64 = 1e-6;

/// A circle in one of the machine's planes with a sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Circle {
    /// Centre, mm.
    pub center: Point,
    /// Its plane.
    pub plane: Plane,
    /// Seen from the plane's positive normal.
    pub clockwise: bool,
    /// As told, mm.
    pub radius: f64,
}

impl Circle {
    /// A circle about an axis (right hand). The axis need not be of unit length, but must be one of the machine's.
    pub fn new(center: Point, axis: Vector, radius: f64) -> Result<Circle, ClProblem> {
        let refuse = || ClProblem::ArcAxis {
            i: axis.x,
            j: axis.y,
            k: axis.z,
        };
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(ClProblem::Value {
                word: "the radius of an arc",
                value: radius,
                rule: "must be above zero",
            });
        }
        let unit = axis.try_normalize(1e-9).ok_or_else(refuse)?;
        let (k, plane) = [(2, Plane::Xy), (1, Plane::Zx), (0, Plane::Yz)]
            .into_iter()
            .find(|(k, _)| unit[*k].abs() >= 1.0 - LEAN)
            .ok_or_else(refuse)?;
        Ok(Circle {
            center,
            plane,
            clockwise: unit[k] < 0.0,
            radius,
        })
    }

    /// Distance of a place from the circle's axis.
    pub fn distance(&self, p: &Point) -> f64 {
        let [a, b, _] = self.plane.axes();
        (p[a] - self.center[a]).hypot(p[b] - self.center[b])
    }

    /// Checks that a place lies on the circle, whatever its height.
    pub fn check(&self, end: &'static str, p: &Point) -> Result<(), ClProblem> {
        let distance = self.distance(p);
        // Of a circle not much larger than that, a quarter of its radius.
        if (distance - self.radius).abs() <= OFF_CIRCLE.min(0.25 * self.radius) {
            return Ok(());
        }
        Err(ClProblem::ArcRadius {
            end,
            distance,
            radius: self.radius,
        })
    }

    /// True where the place lies on the circle.
    pub fn holds(&self, p: &Point) -> bool {
        self.check("end", p).is_ok()
    }

    /// Signed turn from one place to another in the circle's sense, rad: never zero, at most once round.
    pub fn turn(&self, from: &Point, to: &Point) -> f64 {
        turn(self.plane, &self.center, from, to, self.clockwise)
    }

    /// The bow of a turn that begins at `from`.
    pub fn bow(&self, from: &Point, sweep: f64) -> Bow {
        let [_, _, n] = self.plane.axes();
        let mut center = self.center;
        center[n] = from[n];
        Bow {
            plane: self.plane,
            center,
            sweep,
        }
    }
}

/// Signed turn about a centre, rad: negative clockwise, never zero, at most once round.
pub(super) fn turn(plane: Plane, center: &Point, from: &Point, to: &Point, clockwise: bool) -> f64 {
    let [i, j, _] = plane.axes();
    let (ax, ay) = (from[i] - center[i], from[j] - center[j]);
    let (bx, by) = (to[i] - center[i], to[j] - center[j]);
    let turn = (ax * by - ay * bx).atan2(ax * bx + ay * by);
    match clockwise {
        true if turn >= 0.0 => turn - TAU,
        false if turn <= 0.0 => turn + TAU,
        _ => turn,
    }
}

/// The turn of an arc whose angle is told, rad; `None` when it turns by nothing. The points say exactly how far, the angle says how often
/// round and must agree with them.
pub(super) fn turn_of_angle(
    circle: &Circle,
    from: &Point,
    to: &Point,
    degrees: f64,
) -> Result<Option<f64>, ClProblem> {
    if !(-3.6e6..=3.6e6).contains(&degrees) {
        return Err(ClProblem::Value {
            word: "ANGLE",
            value: degrees,
            rule: "is more than 10000 times round: correct it",
        });
    }
    let mut circle = *circle;
    circle.clockwise ^= degrees < 0.0;
    let once = circle.turn(from, to);
    let told = degrees.abs().to_radians();
    let more = ((told - once.abs()) / TAU).round();
    let whole = once.abs() + more * TAU;
    // Off by this much the end would be off the told one by more than a point may be; small arcs have coarse angles.
    let allowed = (3.0 * OFF_CIRCLE / circle.radius).max(2e-4);
    if (told - whole).abs() > allowed {
        return Err(ClProblem::ArcAngle {
            told: degrees,
            found: once.abs().to_degrees(),
        });
    }
    if more < 0.0 {
        return Ok(None);
    }
    Ok(Some(once + more * TAU.copysign(once)))
}

/// Where an arc from `from` ends that is to stop where it crosses a line for the `nth` time. A start on the line does not count.
///
/// The way of APT's `TLON,GOFWD/(circle),ON,n,INTOF,(line)`: tool on the circle, forward until on the line.
pub(super) fn crossing(
    circle: &Circle,
    from: &Point,
    line: [&Point; 2],
    nth: u32,
) -> Result<Point, ClProblem> {
    let [i, j, _] = circle.plane.axes();
    let c = &circle.center;
    let (px, py) = (line[0][i] - c[i], line[0][j] - c[j]);
    let (dx, dy) = (line[1][i] - line[0][i], line[1][j] - line[0][j]);
    let length = dx.hypot(dy);
    if !(1e-9..f64::INFINITY).contains(&length) {
        return Err(ClProblem::ArcLine);
    }
    let (dx, dy) = (dx / length, dy / length);
    let middle = -(px * dx + py * dy);
    let aside = px * dy - py * dx;
    let r = circle.distance(from);
    let half = r * r - aside * aside;
    if half < -2.0 * r * OFF_CIRCLE {
        return Err(ClProblem::ArcLine);
    }
    let half = half.max(0.0).sqrt();
    // Both crossings with how far round they are; one that the start is on comes last.
    let near = OFF_CIRCLE / r.max(OFF_CIRCLE);
    let mut ends = [middle - half, middle + half].map(|s| {
        let mut p = *from;
        (p[i], p[j]) = (c[i] + px + s * dx, c[j] + py + s * dy);
        let t = circle.turn(from, &p).abs();
        (if t < near { TAU } else { t }, p)
    });
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (_, mut end) = match nth {
        1 => ends[0],
        2 => ends[1],
        _ => {
            return Err(ClProblem::Value {
                word: "INTOF",
                value: f64::from(nth),
                rule: "is neither 1 nor 2: an arc crosses a line twice before it is once round",
            });
        }
    };
    // As written where the crossing is the line's own end: no digit is lost.
    let apart = |q: &Point| (q[i] - end[i]).hypot(q[j] - end[j]);
    if let Some(q) = line.into_iter().find(|q| apart(q) <= OFF_CIRCLE) {
        (end[i], end[j]) = (q[i], q[j]);
    }
    Ok(end)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn p(x: f64, y: f64, z: f64) -> Point {
        Point::new(x, y, z)
    }

    fn circle(k: f64) -> Circle {
        Circle::new(Point::origin(), Vector::new(0.0, 0.0, k), 5.0).unwrap()
    }

    #[test]
    fn senses_by_hand() {
        let (a, b) = (p(5.0, 0.0, 1.0), p(0.0, 5.0, 1.0));
        assert!((circle(1.0).turn(&a, &b) - PI / 2.0).abs() < 1e-12);
        assert!((circle(-1.0).turn(&a, &b) + 1.5 * PI).abs() < 1e-12);
        assert!((circle(1.0).turn(&a, &a) - TAU).abs() < 1e-12);
        let zx = Circle::new(p(1.0, 2.0, 3.0), Vector::new(0.0, 2.0, 0.0), 5.0).unwrap();
        // Right hand about +Y: from Z to X.
        let (a, b) = (p(1.0, 9.0, 8.0), p(6.0, 9.0, 3.0));
        assert_eq!(zx.plane, Plane::Zx);
        assert!((zx.turn(&a, &b) - PI / 2.0).abs() < 1e-12);
        assert_eq!(zx.bow(&a, 1.0).center, p(1.0, 9.0, 3.0));
        let lean = Circle::new(Point::origin(), Vector::new(0.0, 0.1, 1.0), 5.0);
        assert!(matches!(lean, Err(ClProblem::ArcAxis { .. })));
        assert!(Circle::new(Point::origin(), Vector::z(), 0.0).is_err());
    }

    #[test]
    fn angles_say_how_often_and_points_how_far() {
        let (a, b) = (p(5.0, 0.0, 1.0), p(0.0, 5.0, 0.0));
        let of = |k, d| turn_of_angle(&circle(k), &a, &b, d);
        assert_eq!(of(1.0, 90.0), Ok(Some(PI / 2.0)));
        assert_eq!(of(1.0, 450.001), Ok(Some(PI / 2.0 + TAU)));
        assert_eq!(of(-1.0, 270.0), Ok(Some(PI / 2.0 - TAU)));
        assert_eq!(of(1.0, -270.0), of(-1.0, 270.0));
        assert_eq!(
            of(1.0, 270.0),
            Err(ClProblem::ArcAngle {
                told: 270.0,
                found: 90.0
            })
        );
        let near = p(5.0, -1e-9, 1.0);
        assert_eq!(turn_of_angle(&circle(1.0), &a, &near, 0.0), Ok(None));
        assert!(
            turn_of_angle(&circle(1.0), &a, &a, 360.0)
                .unwrap()
                .is_some()
        );
        assert!(of(1.0, f64::NAN).is_err());
    }

    #[test]
    fn crossings_are_counted_from_behind_the_start() {
        let c = circle(1.0);
        let start = p(5.0, 0.0, 2.0);
        let line = [&p(0.0, 0.0, 2.0), &p(-5.0, 0.0, 2.0)];
        let end = |nth| crossing(&c, &start, line, nth);
        assert_eq!(end(1).unwrap(), p(-5.0, 0.0, 2.0));
        assert!((end(2).unwrap() - start).norm() < 1e-12, "once round");
        assert!(end(3).is_err());
        let up = [&p(0.0, -9.0, 0.0), &p(0.0, 9.0, 0.0)];
        assert!((crossing(&c, &start, up, 1).unwrap() - p(0.0, 5.0, 2.0)).norm() < 1e-12);
        assert!((crossing(&c, &start, up, 2).unwrap() - p(0.0, -5.0, 2.0)).norm() < 1e-12);
        let far = [&p(9.0, 0.0, 0.0), &p(9.0, 1.0, 0.0)];
        assert_eq!(crossing(&c, &start, far, 1), Err(ClProblem::ArcLine));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]
        /// A turn brings its start to its end, in its sense, at most once round.
        #[test]
        fn a_turn_leads_from_start_to_end(
            a in 0.0..6.2f64, b in 0.0..6.2f64, r in 0.5..50.0f64, clockwise: bool,
        ) {
            let at = |t: f64| p(1.0 + r * t.cos(), 2.0 + r * t.sin(), 0.0);
            let s = turn(Plane::Xy, &p(1.0, 2.0, 0.0), &at(a), &at(b), clockwise);
            prop_assert!(s != 0.0 && s.abs() <= TAU && (s < 0.0) == clockwise);
            prop_assert!((at(a + s) - at(b)).norm() < 1e-9 * r);
        }
    }
}
