//! How smoothly passes turn into one another near saddles, where features meet: the figure that says whether they are blended.

use super::link::turn::bend;
use super::moves::Toolpath;
use super::pass::{Pass, PassKind};
use super::sharp::{SHORTEST, each_turn};
use crate::geom::{Point, Point2, Vector, Vector2};
use crate::morse::{CriticalKind, CriticalPoint};
use crate::reach::DropCutter;

/// The sharpest turns near one saddle, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaddleTurns {
    /// Index of the saddle among the critical points.
    pub critical: usize,
    /// Where the ball's centre stands over it, mm.
    pub center: Point,
    /// Turns this near to it in plan are meant, mm.
    pub reach: f64,
    /// Passes joined by straight links would turn this sharply in plan; 0 where none are joined near it.
    pub before: f64,
    /// The path does turn this sharply, from one move along the surface to the next, but for corners of the part; 0 where it does not come
    /// near.
    pub after: f64,
}

/// The turns (ball centre, degrees in plan) that passes joined by straight links would make where they join. `passes` in cutting order.
pub fn straight_turns(passes: &[Pass]) -> Vec<(Point, f64)> {
    let mut out = Vec::new();
    for w in passes.windows(3) {
        if w[1].kind != PassKind::Turn {
            continue;
        }
        let (Some(a), Some(b)) = (w[1].points.first(), w[1].points.last()) else {
            continue;
        };
        let straight = b.xy() - a.xy();
        if let Some(h) = heading(w[0].points.iter().rev()) {
            out.push((*a, bend(&-h, &straight).to_degrees()));
        }
        if let Some(h) = heading(w[2].points.iter()) {
            out.push((*b, bend(&straight, &h).to_degrees()));
        }
    }
    out
}

/// Turns beyond this are looked at for a corner of the part, degrees.
const SHARP: f64 = 15.0;

/// The turns within `reach` (mm, in plan) of each saddle, but for corners of the part. `passes` in cutting order. Cost: moves times
/// saddles.
pub fn saddle_turns(
    critical: &[CriticalPoint],
    cutter: &DropCutter,
    passes: &[Pass],
    toolpath: &Toolpath,
    reach: f64,
) -> Vec<SaddleTurns> {
    let mut out: Vec<SaddleTurns> = critical
        .iter()
        .enumerate()
        .filter(|(_, c)| c.kind == CriticalKind::Saddle)
        .map(|(k, c)| SaddleTurns {
            critical: k,
            center: c.center,
            reach,
            before: 0.0,
            after: 0.0,
        })
        .collect();
    if out.is_empty() {
        return out;
    }
    for (at, turn) in straight_turns(passes) {
        for s in out.iter_mut().filter(|s| near(&s.center, &at, reach)) {
            s.before = s.before.max(turn);
        }
    }
    let up = Vector::new(0.0, 0.0, cutter.radius());
    each_turn(toolpath, |t| {
        let turn = t.degrees();
        let higher = |s: &SaddleTurns| turn > s.after && near(&s.center, &t.at, reach);
        if !out.iter().any(higher) {
            return;
        }
        let own = if turn > SHARP {
            cutter
                .own_turn(&(t.at + up), &t.before, &t.after)
                .to_degrees()
        } else {
            turn
        };
        for s in out.iter_mut().filter(|s| higher(s)) {
            s.after = s.after.max(own);
        }
    });
    out
}

fn near(center: &Point, p: &Point, reach: f64) -> bool {
    (center.xy() - p.xy()).norm() <= reach
}

/// The way a run sets out in plan: from its first point to the first other one.
fn heading<'a>(mut points: impl Iterator<Item = &'a Point>) -> Option<Vector2> {
    let first: Point2 = points.next()?.xy();
    points.map(|p| p.xy() - first).find(|d| d.norm() > SHORTEST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Mesh;
    use crate::toolpath::{Move, MoveKind};

    #[test]
    fn a_square_corner_near_the_saddle_is_told_and_one_far_away_is_not() {
        let saddle = CriticalPoint {
            kind: CriticalKind::Saddle,
            node: 0,
            boundary: false,
            center: Point::origin(),
            contact: Point::origin(),
            value: 0.0,
            persistence: 1.0,
        };
        let path = |x: f64| Toolpath {
            moves: [(x, 0.0), (x + 1.0, 0.0), (x + 1.0, 1.0), (x + 2.0, 2.0)]
                .into_iter()
                .map(|(x, y)| Move::straight(MoveKind::Cut, Point::new(x, y, 0.0)))
                .collect(),
            ..Toolpath::default()
        };
        let cutter = DropCutter::new(
            &Mesh {
                triangles: Vec::new(),
            },
            3.0,
        );
        let turn = |x: f64| saddle_turns(&[saddle], &cutter, &[], &path(x), 1.5)[0].after;
        assert!((turn(0.0) - 90.0).abs() < 1e-9);
        assert_eq!(turn(30.0), 0.0);
    }
}
