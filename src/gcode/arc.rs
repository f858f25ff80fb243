//! Arcs: from end point and centre (I J K) or radius (R) to centre and turn.
//!
//! Crosses the border: points and words in mm, work coordinates; an [`Arc`] or a [`Complaint`] out.

use super::error::Complaint;
use super::event::{Arc, Plane};
use super::rules::{ArcMiss, Rules};
use crate::geom::Point;
use std::f64::consts::TAU;

/// A plane's axis letters and its offset words, for messages.
pub(super) fn names(plane: Plane) -> (&'static str, &'static str) {
    match plane {
        Plane::Xy => ("X Y", "I or J"),
        Plane::Zx => ("X Z", "I or K"),
        Plane::Yz => ("Y Z", "J or K"),
    }
}

/// Turns smaller than this are full circles, rad (GRBL's figure).
const FULL_CIRCLE_BELOW: f64 = 5e-7;

/// Signed turn from start to end about the centre. Start equal to end is a full circle.
pub(super) fn sweep(start: [f64; 2], end: [f64; 2], center: [f64; 2], clockwise: bool) -> f64 {
    let (ax, ay) = (start[0] - center[0], start[1] - center[1]);
    let (bx, by) = (end[0] - center[0], end[1] - center[1]);
    let turn = (ax * by - ay * bx).atan2(ax * bx + ay * by);
    if clockwise {
        if turn >= -FULL_CIRCLE_BELOW {
            turn - TAU
        } else {
            turn
        }
    } else if turn <= FULL_CIRCLE_BELOW {
        turn + TAU
    } else {
        turn
    }
}

/// An arc whose centre is known. Checks the two radii by the dialect's rule.
pub(super) fn by_center(
    rules: &Rules,
    plane: Plane,
    from: &Point,
    to: &Point,
    center: &Point,
    clockwise: bool,
) -> Result<Arc, Complaint> {
    let [a, b, n] = plane.axes();
    let flat = |p: &Point| [p[a], p[b]];
    let (s, e, c) = (flat(from), flat(to), flat(center));
    let start = (s[0] - c[0]).hypot(s[1] - c[1]);
    let end = (e[0] - c[0]).hypot(e[1] - c[1]);
    let differ = (start - end).abs();
    if start == 0.0 && !rules.firmware {
        return Err(Complaint::ArcRadiusZero);
    }
    // Small misses come from rounding in the post and are spread along the arc; large ones mean that the program is wrong.
    let bad = match rules.arc_miss {
        ArcMiss::Grbl => differ > 0.5 || (differ > 0.005 && differ > 0.001 * start),
        ArcMiss::LinuxCnc => {
            differ > 0.127 || (differ > 0.00127 && differ > 0.001 * start.max(end))
        }
    };
    if bad {
        return Err(Complaint::ArcRadiiDiffer { start, end });
    }
    let mut center = *center;
    center[n] = from[n];
    Ok(Arc {
        plane,
        center,
        clockwise,
        sweep: sweep(s, e, c, clockwise),
    })
}

/// An arc of given radius; negative for the way round of more than half a turn. `None`: start and end coincide in the plane
/// though not in space, a case without a centre.
///
/// ```text
///            c          h = height of the centre over the chord
///          / | \        h^2 = r^2 - (d/2)^2
///       r /  |h \       The centre of a clockwise arc of less than half a turn lies to the
///        /___|___\      right of the chord, seen along the way.
///       s   d/2   e
/// ```
pub(super) fn by_radius(
    plane: Plane,
    from: &Point,
    to: &Point,
    radius: f64,
    clockwise: bool,
) -> Result<Option<Arc>, Complaint> {
    let [a, b, n] = plane.axes();
    let (dx, dy) = (to[a] - from[a], to[b] - from[b]);
    let distance = dx.hypot(dy);
    if distance == 0.0 {
        return if to[n] == from[n] {
            Err(Complaint::ArcNowhere)
        } else {
            Ok(None)
        };
    }
    let h_sq = radius * radius - distance * distance / 4.0;
    if h_sq < 0.0 {
        return Err(Complaint::ArcRadius { radius, distance });
    }
    let right = clockwise == (radius > 0.0);
    let h = h_sq.sqrt() * if right { 1.0 } else { -1.0 };
    let mut center = *from;
    center[a] = from[a] + dx / 2.0 + h * dy / distance;
    center[b] = from[b] + dy / 2.0 - h * dx / distance;
    let flat = |p: &Point| [p[a], p[b]];
    let sweep = sweep(flat(from), flat(to), flat(&center), clockwise);
    Ok(Some(Arc {
        plane,
        center,
        clockwise,
        sweep,
    }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::dialect::Dialect;
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn quarter_turns_by_radius() {
        let (o, e) = (Point::origin(), Point::new(10.0, 10.0, 0.0));
        // From (0,0) to (10,10), counter-clockwise, radius 10: centre (0,10); clockwise: centre (10,0).
        for (r, clockwise, center, turn) in [
            (10.0, false, Point::new(0.0, 10.0, 0.0), PI / 2.0),
            (10.0, true, Point::new(10.0, 0.0, 0.0), -PI / 2.0),
            (-10.0, false, Point::new(10.0, 0.0, 0.0), 1.5 * PI),
            (-10.0, true, Point::new(0.0, 10.0, 0.0), -1.5 * PI),
        ] {
            let arc = by_radius(Plane::Xy, &o, &e, r, clockwise).unwrap().unwrap();
            assert!((arc.center - center).norm() < 1e-12, "{r} {clockwise}");
            assert!((arc.sweep - turn).abs() < 1e-12);
        }
    }

    #[test]
    fn start_equal_to_end_is_a_full_circle_by_centre_and_nothing_by_radius() {
        let (p, c) = (Point::new(1.0, 2.0, 3.0), Point::new(2.0, 2.0, 9.0));
        for (clockwise, turn) in [(true, -TAU), (false, TAU)] {
            let arc = by_center(Dialect::Grbl.rules(), Plane::Xy, &p, &p, &c, clockwise).unwrap();
            assert_eq!((arc.sweep, arc.center.z), (turn, 3.0));
        }
        assert_eq!(
            by_radius(Plane::Xy, &p, &p, 5.0, true),
            Err(Complaint::ArcNowhere)
        );
        assert_eq!(
            by_radius(Plane::Xy, &p, &Point::new(1.0, 2.0, 4.0), 5.0, true),
            Ok(None)
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        /// Whatever the plane and the way round: the centre is r from both ends, and turning the start about it by the sweep
        /// gives the end.
        #[test]
        fn radius_arcs_end_where_they_should(
            x in -50.0..50.0f64, y in -50.0..50.0f64, u in -50.0..50.0f64, v in -50.0..50.0f64,
            k in 1.001..20.0f64, clockwise: bool, long: bool, p in 0usize..3,
        ) {
            let plane = [Plane::Xy, Plane::Zx, Plane::Yz][p];
            let [a, b, _] = plane.axes();
            let (mut s, mut e) = (Point::origin(), Point::origin());
            (s[a], s[b], e[a], e[b]) = (x, y, u, v);
            let d = (e - s).norm();
            prop_assume!(d > 0.01);
            let r = d / 2.0 * k;
            let arc = by_radius(plane, &s, &e, if long { -r } else { r }, clockwise).unwrap().unwrap();
            prop_assert!(((s - arc.center).norm() - r).abs() < 1e-9 * r);
            prop_assert_eq!(arc.sweep < 0.0, clockwise);
            prop_assert_eq!(arc.sweep.abs() > PI, long);
            let (sin, cos) = arc.sweep.sin_cos();
            let w = s - arc.center;
            let end = [arc.center[a] + w[a] * cos - w[b] * sin, arc.center[b] + w[a] * sin + w[b] * cos];
            prop_assert!((end[0] - e[a]).hypot(end[1] - e[b]) < 1e-8 * r);
        }
    }
}
