//! Arcs as the straight lines that the firmware cuts instead.
//!
//! Crosses the border: an arc and a tolerance in, points out, all mm, in whatever coordinates the arc has.

use crate::gcode::Arc;
use crate::geom::Point;
use crate::units::Mm;

/// The end points of an arc's chords, in order; the last one is exactly the arc's end.
#[derive(Clone, Debug)]
pub struct Chords {
    from: Point,
    to: Point,
    arc: Arc,
    count: u32,
    next: u32,
}

/// The firmware counts chords in 16 bits.
const MOST: f64 = 65_535.0;

/// Splits an arc into chords that stay within `tolerance` of it, by GRBL's rule:
///
/// ```text
/// chord of half angle b on radius r:  sagitta t = r (1 - cos b),  half chord = sqrt(t (2 r - t))
/// count = floor(half the arc's length / half chord)
/// ```
///
/// Rounding down makes the sagitta a little larger than the tolerance on short arcs. A tolerance above the diameter, or an arc
/// shorter than two chords, gives one straight line.
pub fn chords(from: &Point, to: &Point, arc: &Arc, tolerance: Mm) -> Chords {
    let [a, b, _] = arc.plane.axes();
    let radius = (from[a] - arc.center[a]).hypot(from[b] - arc.center[b]);
    let half = (tolerance.0 * (2.0 * radius - tolerance.0)).max(0.0).sqrt();
    let count = (0.5 * arc.sweep * radius).abs() / half;
    let count = if count.is_finite() {
        count.min(MOST) as u32
    } else {
        0
    };
    Chords {
        from: *from,
        to: *to,
        arc: *arc,
        count: count.max(1),
        next: 1,
    }
}

impl Chords {
    /// How many chords there are, from first to last: what inverse-time feeds are multiplied by.
    pub fn chord_count(&self) -> u32 {
        self.count
    }
}

impl Iterator for Chords {
    type Item = Point;

    fn next(&mut self) -> Option<Point> {
        let i = self.next;
        if i > self.count {
            return None;
        }
        self.next += 1;
        if i == self.count {
            return Some(self.to);
        }
        let share = f64::from(i) / f64::from(self.count);
        let (sin, cos) = (self.arc.sweep * share).sin_cos();
        let [a, b, n] = self.arc.plane.axes();
        let c = &self.arc.center;
        let (x, y) = (self.from[a] - c[a], self.from[b] - c[b]);
        let mut p = self.from;
        p[a] = c[a] + x * cos - y * sin;
        p[b] = c[b] + x * sin + y * cos;
        p[n] = self.from[n] + (self.to[n] - self.from[n]) * share;
        Some(p)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gcode::{Dialect, Event, interpret};

    fn arc(text: &str) -> (Point, Point, Arc) {
        let program = interpret(text, Dialect::Grbl).unwrap();
        match program.events.last() {
            Some(Event::Motion(m)) => (m.from, m.to, m.arc.unwrap()),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn chords_keep_to_the_arc_and_end_on_it() {
        for text in [
            "G2X10Y0I5F100",
            "G3X0Y0I-7F100",
            "G18G2X10Z0Y4I5F100",
            "G19G3Y5Z5K5F100",
            "G2X3Y3R-40F100",
        ] {
            let (from, to, arc) = arc(text);
            let r = (from - arc.center).norm();
            let points: Vec<Point> = chords(&from, &to, &arc, Mm(0.002)).collect();
            assert_eq!(points.last(), Some(&to));
            assert!(points.len() > 10);
            let [a, b, n] = arc.plane.axes();
            let flat = |p: &Point| (p[a] - arc.center[a]).hypot(p[b] - arc.center[b]);
            let mut last = from;
            for p in &points {
                assert!((flat(p) - r).abs() < 1e-9);
                let sagitta = r - flat(&nalgebra::center(&last, p));
                assert!(sagitta < 0.002 * 1.3, "{text}: {sagitta}");
                assert!(n == 2 || (p[n] - last[n]).abs() <= (to[n] - from[n]).abs());
                last = *p;
            }
        }
    }

    #[test]
    fn the_count_is_the_firmwares() {
        // Half circle, r = 5: floor(0.5 * pi * 5 / sqrt(0.002 * 9.998)) = floor(55.54) = 55.
        let (from, to, a) = arc("G2X10Y0I5F100");
        assert_eq!(chords(&from, &to, &a, Mm(0.002)).chord_count(), 55);
        assert_eq!(chords(&from, &to, &a, Mm(100.0)).chord_count(), 1);
        assert_eq!(chords(&from, &to, &a, Mm(0.0)).chord_count(), 1);
    }
}
