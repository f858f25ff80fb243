//! A piece of path as a curve: straight or a helix, told by the distance along it.
//!
//! Crosses the border: ends and centre in any one frame, mm; places out. Knows nothing of parts or machines.

use super::moves::{Move, Turn};
use crate::geom::{Point, Point2, Vector, Vector2};

/// A straight line or a helix about a vertical axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    from: Point,
    to: Point,
    length: f64,
    arc: Option<Helix>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Helix {
    center: Point2,
    radius: f64,
    /// From the centre to the start.
    spoke: Vector2,
    sweep: f64,
    /// How far inwards a controller's chords leave it, mm.
    sagitta: f64,
}

/// Runs no longer than this in plan are hops over a cliff or plunges, not slopes, mm.
const UPRIGHT: f64 = 0.0055;

impl Curve {
    /// Straight.
    pub fn line(from: Point, to: Point) -> Curve {
        Curve {
            from,
            to,
            length: (to - from).norm(),
            arc: None,
        }
    }

    /// Along an arc in plan, Z even with the angle. `chord_tolerance`: a controller cuts chords of the arc that stay within so much of it,
    /// mm; zero for one that does not.
    pub fn arc(from: Point, to: Point, turn: &Turn, chord_tolerance: f64) -> Curve {
        let spoke = from.xy() - turn.center;
        let sweep = turn.sweep(&from, &to);
        let radius = spoke.norm();
        Curve {
            from,
            to,
            length: turn.length(&from, &to),
            arc: Some(Helix {
                center: turn.center,
                radius,
                spoke,
                sweep,
                sagitta: sagitta(radius, sweep, chord_tolerance),
            }),
        }
    }

    /// A move from where the last one ended, all shifted by `up` (from tool tips to centres of the ball).
    pub fn of_move(from: Point, m: &Move, up: Vector, chord_tolerance: f64) -> Curve {
        match &m.turn {
            None => Curve::line(from, m.to + up),
            Some(t) => Curve::arc(from, m.to + up, t, chord_tolerance),
        }
    }

    /// Length, mm.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The place `t` mm along.
    pub fn at(&self, t: f64) -> Point {
        let s = if self.length > 0.0 {
            (t / self.length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        match &self.arc {
            None => self.from + (self.to - self.from) * s,
            // The last point is exact; radii of start and end may differ by a rounding.
            Some(_) if s >= 1.0 => self.to,
            Some(h) => {
                let (sin, cos) = (h.sweep * s).sin_cos();
                Point::new(
                    h.center.x + h.spoke.x * cos - h.spoke.y * sin,
                    h.center.y + h.spoke.x * sin + h.spoke.y * cos,
                    self.from.z + (self.to.z - self.from.z) * s,
                )
            }
        }
    }

    /// Curvature in plan, 1/mm; zero for a straight line.
    pub fn bend(&self) -> f64 {
        self.arc.map_or(0.0, |h| 1.0 / h.radius.max(1e-9))
    }

    /// The way from a place on an arc to the controller's chord, at most; `None` on a straight line.
    pub fn slack(&self, at: &Point) -> Option<Vector> {
        let h = self.arc?;
        let inward = h.center - at.xy();
        let l = inward.norm();
        (l > 0.0).then(|| Vector::new(inward.x / l, inward.y / l, 0.0) * h.sagitta)
    }

    /// Goes up or down on the spot, or over less ground than a slope needs.
    pub fn is_upright(&self) -> bool {
        self.arc.is_none() && (self.to.xy() - self.from.xy()).norm() <= UPRIGHT
    }
}

/// How far the chords of a controller leave an arc that they may leave by about `tolerance`. GRBL cuts
/// `floor(half the arc / sqrt(t (2 r - t)))` chords, so a short arc's chords leave it by more than that.
fn sagitta(radius: f64, sweep: f64, tolerance: f64) -> f64 {
    if tolerance <= 0.0 {
        return 0.0;
    }
    let half = (tolerance * (2.0 * radius - tolerance)).max(0.0).sqrt();
    let count = if half > 0.0 {
        (0.5 * sweep.abs() * radius / half).floor().max(1.0)
    } else {
        1.0
    };
    radius * (1.0 - (0.5 * sweep / count).cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_quarter_helix_by_hand() {
        let turn = Turn {
            center: Point2::new(1.0, 0.0),
            clockwise: false,
        };
        let (a, b) = (Point::new(6.0, 0.0, 0.0), Point::new(1.0, 5.0, 2.0));
        let c = Curve::arc(a, b, &turn, 0.002);
        assert!((c.length() - (2.5 * PI).hypot(2.0)).abs() < 1e-12);
        let half = c.at(0.5 * c.length());
        let d = 5.0 / 2f64.sqrt();
        assert!((half - Point::new(1.0 + d, d, 1.0)).norm() < 1e-12);
        assert_eq!((c.at(0.0), c.at(c.length())), (a, b));
        assert!((c.bend() - 0.2).abs() < 1e-12);
        // 0.5 * pi/2 * 5 / sqrt(0.002 * 9.998) = 27.77: 27 chords of 3.33 degrees leave it by 5 (1 - cos 1.667 deg) = 2.1 um.
        let s = c.slack(&half).map(|v| v.norm()).unwrap_or(0.0);
        assert!((s - 0.002_115).abs() < 2e-6, "{s}");
        assert!(c.slack(&half).is_some_and(|v| v.x < 0.0 && v.y < 0.0));
        // Without tolerance the controller cuts the arc itself.
        assert_eq!(
            Curve::arc(a, b, &turn, 0.0).slack(&half).map(|v| v.norm()),
            Some(0.0)
        );
    }

    #[test]
    fn a_line_is_a_line() {
        let (a, b) = (Point::new(0.0, 0.0, 0.0), Point::new(3.0, 4.0, 0.0));
        let c = Curve::line(a, b);
        assert_eq!((c.length(), c.bend(), c.slack(&a)), (5.0, 0.0, None));
        assert_eq!(c.at(2.5), Point::new(1.5, 2.0, 0.0));
        assert!(!c.is_upright() && Curve::line(a, Point::new(0.001, 0.0, 5.0)).is_upright());
    }
}
