//! Circles in a plane: from what programs say to centre and turn.
//!
//! Crosses the border: points in mm, work coordinates; an [`Arc`] out, or a number that says why there is none.

use super::super::event::{Arc, Plane};
use crate::geom::Point;
use std::f64::consts::{PI, TAU};

/// Turns smaller than this are full circles, rad.
const FULL_CIRCLE_BELOW: f64 = 5e-7;

/// The signed turn from start to end about the centre. Start equal to end is a full circle.
pub(in crate::gcode) fn turn(
    plane: Plane,
    from: &Point,
    to: &Point,
    center: &Point,
    clockwise: bool,
) -> f64 {
    let [a, b, _] = plane.axes();
    let (ax, ay) = (from[a] - center[a], from[b] - center[b]);
    let (bx, by) = (to[a] - center[a], to[b] - center[b]);
    let turn = (ax * by - ay * bx).atan2(ax * bx + ay * by);
    match clockwise {
        true if turn >= -FULL_CIRCLE_BELOW => turn - TAU,
        false if turn <= FULL_CIRCLE_BELOW => turn + TAU,
        _ => turn,
    }
}

/// Distance in the plane.
pub(in crate::gcode) fn distance(plane: Plane, p: &Point, q: &Point) -> f64 {
    let [a, b, _] = plane.axes();
    (p[a] - q[a]).hypot(p[b] - q[b])
}

/// The arc about a centre.
///
/// # Errors
/// The distances of start and end from the centre, mm, when they differ by more than `slack` (mm) or the centre is the start.
pub(in crate::gcode) fn about(
    plane: Plane,
    from: &Point,
    to: &Point,
    center: &Point,
    clockwise: bool,
    slack: f64,
) -> Result<Arc, (f64, f64)> {
    let (start, end) = (distance(plane, from, center), distance(plane, to, center));
    // Written so that NaN is refused as well.
    if !(start > 0.0 && (start - end).abs() <= slack) {
        return Err((start, end));
    }
    let mut center = *center;
    let [_, _, n] = plane.axes();
    center[n] = from[n];
    let sweep = turn(plane, from, to, &center, clockwise);
    Ok(Arc {
        plane,
        center,
        clockwise,
        sweep,
    })
}

/// The arc of a radius (mm, positive); `long` for more than half a turn. Chords longer than the diameter by no more than `slack` (mm)
/// count as half circles.
///
/// # Errors
/// The distance from start to end in the plane, mm: it is zero, or no circle of this radius joins them.
pub(in crate::gcode) fn of_radius(
    plane: Plane,
    from: &Point,
    to: &Point,
    radius: f64,
    long: bool,
    clockwise: bool,
    slack: f64,
) -> Result<Arc, f64> {
    let [a, b, _] = plane.axes();
    let (dx, dy) = (to[a] - from[a], to[b] - from[b]);
    let chord = dx.hypot(dy);
    if !(chord > 0.0 && radius > 0.0 && chord <= 2.0 * radius + slack) {
        return Err(chord);
    }
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    // The centre of a clockwise arc of less than half a turn lies to the right of the chord, seen along the way.
    let right = if clockwise != long { height } else { -height };
    let mut center = *from;
    center[a] = from[a] + dx / 2.0 + right * dy / chord;
    center[b] = from[b] + dy / 2.0 - right * dx / chord;
    let sweep = turn(plane, from, to, &center, clockwise);
    Ok(Arc {
        plane,
        center,
        clockwise,
        sweep,
    })
}

/// The point turned about a centre by an angle (rad), its third coordinate kept.
pub(in crate::gcode) fn turned(plane: Plane, p: &Point, center: &Point, angle: f64) -> Point {
    let [a, b, _] = plane.axes();
    let (sin, cos) = sine_cosine(angle);
    let (x, y) = (p[a] - center[a], p[b] - center[b]);
    let mut out = *p;
    out[a] = center[a] + x * cos - y * sin;
    out[b] = center[b] + x * sin + y * cos;
    out
}

/// Sine and cosine, exact at quarter turns, so that polar programs come back to where they began.
pub(in crate::gcode) fn sine_cosine(angle: f64) -> (f64, f64) {
    let quarters = angle / (PI / 2.0);
    let near = quarters.round();
    if (quarters - near).abs() < 1e-12 {
        return match near.rem_euclid(4.0) as u8 {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        };
    }
    angle.sin_cos()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quarter_turns_are_exact() {
        let p = Point::new(10.0, 0.0, 3.0);
        let o = Point::origin();
        assert_eq!(
            turned(Plane::Xy, &p, &o, PI / 2.0),
            Point::new(0.0, 10.0, 3.0)
        );
        assert_eq!(turned(Plane::Xy, &p, &o, -PI), Point::new(-10.0, 0.0, 3.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        /// Turning the start about the centre by the sweep gives the end, whatever the plane and the way round.
        #[test]
        fn arcs_end_where_they_should(
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
            let arc = of_radius(plane, &s, &e, r, long, clockwise, 0.0).unwrap();
            prop_assert_eq!(arc.sweep < 0.0, clockwise);
            prop_assert_eq!(arc.sweep.abs() > PI, long);
            prop_assert!((distance(plane, &s, &arc.center) - r).abs() < 1e-9 * r);
            prop_assert!((turned(plane, &s, &arc.center, arc.sweep) - e).norm() < 1e-8 * r);
            let again = about(plane, &s, &e, &arc.center, clockwise, 1e-6).unwrap();
            prop_assert!((again.sweep - arc.sweep).abs() < 1e-9);
        }
    }
}
