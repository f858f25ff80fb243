//! How smoothly passes turn into one another near saddles, where features meet: the figure that says whether they are blended.

use super::moves::{MoveKind, Toolpath};
use super::pass::{Pass, PassKind};
use super::turn::bend;
use crate::geom::{Point, Point2, Vector2};
use crate::morse::{CriticalKind, CriticalPoint};

/// The sharpest turns near one saddle, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaddleTurns {
    /// Index of the saddle among the critical points.
    pub critical: usize,
    /// Where the ball's centre stands over it, mm.
    pub center: Point,
    /// Passes joined by straight links would turn this sharply in plan; 0 where none are joined near it.
    pub before: f64,
    /// The path does turn this sharply, from one move along the surface to the next; 0 where it does not come near.
    pub after: f64,
}

/// Moves shorter than this are turned any way by the last decimal of a program, mm.
const SHORTEST: f64 = 0.005;

/// The turns within `reach` (mm, in plan) of each saddle. `passes` in cutting order. Cost: moves times saddles.
pub fn saddle_turns(
    critical: &[CriticalPoint],
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
            before: 0.0,
            after: 0.0,
        })
        .collect();
    if out.is_empty() {
        return out;
    }
    for w in passes.windows(3) {
        if w[1].kind != PassKind::Turn {
            continue;
        }
        let (Some(a), Some(b)) = (w[1].points.first(), w[1].points.last()) else {
            continue;
        };
        let straight = b.xy() - a.xy();
        let leaves = heading(w[0].points.iter().rev()).map(|h| bend(&-h, &straight));
        let enters = heading(w[2].points.iter()).map(|h| bend(&straight, &h));
        let sharpest = leaves
            .unwrap_or(0.0)
            .max(enters.unwrap_or(0.0))
            .to_degrees();
        for s in &mut out {
            if near(&s.center, a, reach) || near(&s.center, b, reach) {
                s.before = s.before.max(sharpest);
            }
        }
    }
    // The last two places far enough apart to have a direction; none after a move through the air.
    let mut last: Vec<Point> = Vec::with_capacity(2);
    for m in &toolpath.moves {
        if !matches!(m.kind, MoveKind::Cut | MoveKind::Link) {
            last.clear();
            last.push(m.to);
            continue;
        }
        let Some(&at) = last.last() else {
            last.push(m.to);
            continue;
        };
        if (m.to - at).norm() < SHORTEST {
            continue;
        }
        if let [before, _] = last[..] {
            let turn = (at - before).angle(&(m.to - at)).to_degrees();
            for s in &mut out {
                if turn > s.after && near(&s.center, &at, reach) {
                    s.after = turn;
                }
            }
            last.remove(0);
        }
        last.push(m.to);
    }
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
    use crate::toolpath::Move;

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
        let turn = |x: f64| saddle_turns(&[saddle], &[], &path(x), 1.5)[0].after;
        assert!((turn(0.0) - 90.0).abs() < 1e-9);
        assert_eq!(turn(30.0), 0.0);
    }
}
