//! What we want the machine to do, before any dialect.

use crate::geom::{Point, Point2};
use crate::units::MmPerMin;

/// Why the tool moves; decides rapid or feed, and which feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveKind {
    /// In the air, as fast as the machine goes.
    Rapid,
    /// Down into the material, at the plunge feed.
    Plunge,
    /// Along the finished surface, at the cutting feed.
    Cut,
    /// From one pass to the next along the surface, without a retract, at the cutting feed.
    Link,
    /// Up and away from the surface: in the air once the ball has left it, so at rapid speed.
    Retract,
}

/// The curved part of a move: a circular arc in the XY plane of less than a full turn, while Z changes evenly with the angle (a
/// helix).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Centre of the circle, work coordinates, mm.
    pub center: Point2,
    /// Clockwise (G2) or counter-clockwise (G3), seen from above.
    pub clockwise: bool,
}

impl Turn {
    /// Signed angle from `from` to `to` about the centre, rad: negative clockwise, never zero.
    pub fn sweep(&self, from: &Point, to: &Point) -> f64 {
        let (a, b) = (from.xy() - self.center, to.xy() - self.center);
        let turn = (a.x * b.y - a.y * b.x).atan2(a.dot(&b));
        match self.clockwise {
            true if turn >= 0.0 => turn - std::f64::consts::TAU,
            false if turn <= 0.0 => turn + std::f64::consts::TAU,
            _ => turn,
        }
    }

    /// Length of the helix from `from` to `to`, mm.
    pub fn length(&self, from: &Point, to: &Point) -> f64 {
        let flat = self.sweep(from, to) * (from.xy() - self.center).norm();
        flat.hypot(to.z - from.z)
    }
}

/// A move of the tool tip to `to`, from wherever the last move ended: straight, or along an arc. Work coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Why it moves.
    pub kind: MoveKind,
    /// Where the tool tip goes.
    pub to: Point,
    /// `None` for a straight line. Only [`MoveKind::Cut`] and [`MoveKind::Link`] may turn.
    pub turn: Option<Turn>,
    /// A feed of its own, lower than the job's for this kind; `None` for the job's. Only [`MoveKind::Cut`] and [`MoveKind::Link`]
    /// have one.
    pub feed: Option<MmPerMin>,
}

impl Move {
    /// Straight to `to`.
    pub fn straight(kind: MoveKind, to: Point) -> Move {
        Move {
            kind,
            to,
            turn: None,
            feed: None,
        }
    }

    /// The feed of a cut or link in a job of the feed `job`: never above it.
    pub fn feed_within(&self, job: MmPerMin) -> MmPerMin {
        self.feed.map_or(job, |own| MmPerMin(own.0.min(job.0)))
    }

    /// Length of this move when it begins at `from`, mm.
    pub fn length(&self, from: &Point) -> f64 {
        match &self.turn {
            None => (self.to - from).norm(),
            Some(t) => t.length(from, &self.to),
        }
    }
}

/// A run of moves that belong together, e.g. one feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// A name for the program's comment: ASCII, no parentheses.
    pub name: String,
    /// Index of the first move of this section in [`Toolpath::moves`].
    pub first_move: usize,
}

/// A whole job's moves. The first move is a [`MoveKind::Rapid`] to the safe height above the first plunge: the post raises Z
/// first, then goes to X and Y.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolpath {
    /// All moves in order.
    pub moves: Vec<Move>,
    /// Where features begin, by rising `first_move`.
    pub sections: Vec<Section>,
    /// Height of the tool tip at which any XY rapid is clear of everything, work coordinates, mm.
    pub safe_z: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn turns_by_hand() {
        let (a, b) = (Point::new(5.0, 0.0, 0.0), Point::new(0.0, 5.0, 3.0));
        let turn = |clockwise| Turn {
            center: Point2::origin(),
            clockwise,
        };
        assert!((turn(false).sweep(&a, &b) - PI / 2.0).abs() < 1e-12);
        assert!((turn(true).sweep(&a, &b) + 1.5 * PI).abs() < 1e-12);
        // Back to the start is once round.
        assert!((turn(false).sweep(&a, &a) - 2.0 * PI).abs() < 1e-12);
        assert!((turn(true).sweep(&a, &a) + 2.0 * PI).abs() < 1e-12);
        let m = Move {
            kind: MoveKind::Cut,
            to: b,
            turn: Some(turn(false)),
            feed: None,
        };
        assert!((m.length(&a) - (2.5 * PI).hypot(3.0)).abs() < 1e-12);
        assert!((Move::straight(MoveKind::Cut, b).length(&a) - 59f64.sqrt()).abs() < 1e-12);
    }
}
