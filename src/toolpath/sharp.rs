//! Sharp turns of a toolpath, and whose they are: the part's (a crease or an edge under the ball that any path across it must follow) or
//! the path's own.
//!
//! Crosses the border: moves of the tool tip and the part made ready for a ball in; angles and counts out, degrees.

use super::moves::{MoveKind, Toolpath};
use crate::geom::{Point, Vector};
use crate::reach::DropCutter;

/// The turns of a path from one cutting move to the next, links along the surface among them, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SharpTurns {
    /// Largest turn that is not a corner of the part.
    pub largest_deg: f64,
    /// Where that is (tool tip, mm).
    pub largest_at: Option<Point>,
    /// Turns over [`SHARP`] that are not corners of the part.
    pub sharp: usize,
    /// Turns over [`SHARP`] at corners of the part.
    pub part_corners: usize,
    /// The largest of them.
    pub largest_part_corner_deg: f64,
}

/// Turns beyond this are judged, degrees.
pub const SHARP: f64 = 30.0;
/// Moves shorter than this are turned any way by the last decimal of a program and are taken together with the next, mm.
pub const SHORTEST: f64 = 0.005;
/// Where a path turns at feed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnAt {
    /// Tool tip, mm.
    pub at: Point,
    /// Unit vectors of the way before and behind it.
    pub before: Vector,
    /// Behind.
    pub after: Vector,
    /// Index of the move that begins with it.
    pub index: usize,
}

impl TurnAt {
    /// Degrees, 0 straight on.
    pub fn degrees(&self) -> f64 {
        angle(&self.before, &self.after).to_degrees()
    }
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Calls `f` at every place where the path goes on from one move along the surface to the next.
pub fn each_turn(path: &Toolpath, mut f: impl FnMut(&TurnAt)) {
    let mut from: Option<Point> = None;
    let mut way: Option<Vector> = None;
    for (index, m) in path.moves.iter().enumerate() {
        let surface = match (m.kind, from) {
            (MoveKind::Cut, Some(_)) => true,
            // Straight up off the surface at feed and on through the air, not along it.
            (MoveKind::Link, Some(at)) => {
                let next = path.moves.get(index + 1);
                next.is_none_or(|n| n.kind != MoveKind::Retract)
                    || (m.to.xy() - at.xy()).norm() >= 1e-6
            }
            _ => false,
        };
        let Some(at) = from.filter(|_| surface) else {
            (from, way) = (Some(m.to), None);
            continue;
        };
        let d = m.to - at;
        let l = d.norm();
        if l < SHORTEST {
            continue;
        }
        let after = d / l;
        if let Some(before) = way {
            f(&TurnAt {
                at,
                before,
                after,
                index,
            });
        }
        (from, way) = (Some(m.to), Some(after));
    }
}

/// All turns of a path, those of the part told apart. A look at the triangles under the ball for each sharp one.
pub fn sharp_turns(cutter: &DropCutter, path: &Toolpath) -> SharpTurns {
    let up = Vector::new(0.0, 0.0, cutter.radius());
    let mut out = SharpTurns::default();
    each_turn(path, |t| {
        let turn = t.degrees();
        if turn > SHARP {
            if cutter
                .own_turn(&(t.at + up), &t.before, &t.after)
                .to_degrees()
                <= SHARP
            {
                out.part_corners += 1;
                out.largest_part_corner_deg = out.largest_part_corner_deg.max(turn);
                return;
            }
            out.sharp += 1;
        }
        if turn > out.largest_deg || out.largest_at.is_none() {
            (out.largest_deg, out.largest_at) = (turn, Some(t.at));
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Mesh;
    use crate::toolpath::Move;

    /// A groove along Y with walls at 45 degrees, 20 mm wide on either side.
    fn groove() -> DropCutter {
        let at = |x: f64, y: f64| Point::new(x, y, x.abs());
        let mut triangles = Vec::new();
        for (a, b) in [(-20.0, 0.0), (0.0, 20.0)] {
            let (p, q, s, t) = (at(a, -20.0), at(b, -20.0), at(b, 20.0), at(a, 20.0));
            triangles.push([p, q, s]);
            triangles.push([p, s, t]);
        }
        DropCutter::new(&Mesh { triangles }, 3.0)
    }

    fn path(tips: &[Point]) -> Toolpath {
        Toolpath {
            moves: tips
                .iter()
                .map(|p| Move::straight(MoveKind::Cut, *p))
                .collect(),
            ..Toolpath::default()
        }
    }

    /// A tip on the surface of the groove.
    fn on(x: f64, y: f64) -> Point {
        Point::new(x, y, x.abs() + 3.0 * (2f64.sqrt() - 1.0))
    }

    #[test]
    fn straight_across_a_crease_is_the_parts_corner_and_back_from_it_is_the_paths() {
        let cutter = groove();
        let across = sharp_turns(&cutter, &path(&[on(-2.0, 0.0), on(0.0, 0.0), on(2.0, 0.0)]));
        assert_eq!((across.part_corners, across.sharp), (1, 0));
        assert!((across.largest_part_corner_deg - 90.0).abs() < 1e-9);
        // Slanting across: unfolded it is straight.
        let slant = sharp_turns(
            &cutter,
            &path(&[on(-2.0, -2.0), on(0.0, 0.0), on(2.0, 2.0)]),
        );
        assert_eq!((slant.part_corners, slant.sharp), (1, 0));
        // Down one wall and up the same again beside it.
        let back = sharp_turns(
            &cutter,
            &path(&[on(-2.0, 0.0), on(0.0, 0.0), on(-2.0, 0.5)]),
        );
        assert_eq!((back.part_corners, back.sharp), (0, 1));
        assert!(back.largest_deg > 150.0);
    }

    #[test]
    fn a_corner_on_a_plain_face_is_the_paths_own() {
        let cutter = groove();
        let t = sharp_turns(
            &cutter,
            &path(&[on(-9.0, 0.0), on(-8.0, 0.0), on(-8.0, 1.0)]),
        );
        assert_eq!((t.part_corners, t.sharp), (0, 1));
        assert!((t.largest_deg - 90.0).abs() < 1e-9);
        assert_eq!(t.largest_at, Some(on(-8.0, 0.0)));
    }
}
