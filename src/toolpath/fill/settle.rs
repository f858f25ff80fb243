//! Fills beside a leap: none runs up and down an upright wall.
//!
//! ```text
//!    ___|  .  .           a place wanted on the foot of a wall is known to a cell of the sweep map: some lie under the wall's edge,
//!       |. .  . .         and the ball there stands on top: those are left out
//! ```
//!
//! Crosses the border: a curve in plan and a part made ready for a ball in, pieces of it out; mm.

use crate::geom::{Point2, Vector2};
use crate::reach::{DropCutter, Hint};

/// A fall over so short a way that it is a leap, mm.
const LEAP: f64 = 0.1;
/// Halvings of the way between two places until what falls is a leap: a thousandth of a cell.
const HALVINGS: usize = 8;

/// The pieces of a curve between leaps, without its places on top of one within a cell and a half (mm) of its edge: what stands there is
/// the wall below, and the passes down walls are for that.
pub(in crate::toolpath) fn settled(
    cutter: &DropCutter,
    curve: &[Point2],
    cell: f64,
) -> Vec<Vec<Point2>> {
    let mut over = Over {
        cutter,
        hint: Hint::default(),
    };
    let placed: Vec<Place> = curve
        .iter()
        .map(|q| over.at(*q))
        .filter(|here| !over_an_edge(cutter, *here, cell))
        .collect();
    let mut out: Vec<Vec<Point2>> = Vec::new();
    let mut last: Option<Place> = None;
    for here in placed {
        match out.last_mut() {
            Some(run) if !last.is_some_and(|l| over.leaps(l, here)) => run.push(here.at),
            _ => out.push(vec![here.at]),
        }
        last = Some(here);
    }
    if out.iter().any(|run| run.len() > 1) {
        out.retain(|run| run.len() > 1);
    }
    out
}

/// Does the ball fall, not down a slope, a cell and a half or less beside a place?
fn over_an_edge(cutter: &DropCutter, here: Place, cell: f64) -> bool {
    let mut over = Over {
        cutter,
        hint: Hint::default(),
    };
    [0.6, 1.1, 1.6].iter().any(|r| {
        (0..8).any(|k| {
            let (s, c) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
            let p = over.at(here.at + Vector2::new(c, s) * (r * cell));
            p.z.is_finite() && p.z < here.z - LEAP && over.leaps(here, p)
        })
    })
}

#[derive(Clone, Copy)]
struct Place {
    at: Point2,
    /// Height of the ball's centre; -inf where it falls past the part.
    z: f64,
}

struct Over<'a> {
    cutter: &'a DropCutter,
    hint: Hint,
}

impl Over<'_> {
    fn at(&mut self, at: Point2) -> Place {
        let c = self.cutter.drop_near(at.x, at.y, &mut self.hint);
        Place {
            at,
            z: c.map_or(f64::NEG_INFINITY, |c| c.center.z),
        }
    }

    /// Does the ball fall at one place between two, rather than down a slope?
    fn leaps(&mut self, a: Place, b: Place) -> bool {
        let (mut a, mut b) = (a, b);
        let falls = |a: &Place, b: &Place| {
            let d = (a.z - b.z).abs();
            if d.is_finite() { d } else { 0.0 }
        };
        for _ in 0..HALVINGS {
            if falls(&a, &b) < LEAP {
                return false;
            }
            let m = self.at(nalgebra::center(&a.at, &b.at));
            if falls(&a, &m) >= falls(&m, &b) {
                b = m;
            } else {
                a = m;
            }
        }
        falls(&a, &b) >= LEAP
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point;
    use crate::part::Mesh;

    /// Along the foot of a wall, a third of the places under its edge: only those at the foot stay.
    #[test]
    fn a_line_that_staggers_across_a_leap_stays_below() {
        let p = Point::new;
        let quad = |a: Point, b: Point, c: Point, d: Point| [[a, b, c], [a, c, d]];
        let mut triangles = quad(
            p(-9.0, -9.0, 0.0),
            p(9.0, -9.0, 0.0),
            p(9.0, 9.0, 0.0),
            p(-9.0, 9.0, 0.0),
        )
        .to_vec();
        triangles.extend(quad(
            p(0.0, -9.0, 6.0),
            p(9.0, -9.0, 6.0),
            p(9.0, 9.0, 6.0),
            p(0.0, 9.0, 6.0),
        ));
        let cutter = DropCutter::new(&Mesh { triangles }, 2.0);
        let curve: Vec<Point2> = (0..40)
            .map(|k| {
                let aside = if k % 3 == 0 { 0.02 } else { -0.02 };
                Point2::new(-2.0 + aside, -2.0 + 0.1 * f64::from(k))
            })
            .collect();
        let out = settled(&cutter, &curve, 0.05);
        assert_eq!(out.len(), 1);
        assert_eq!(out[0].len(), 26);
        assert!(out[0].iter().all(|q| q.x < -2.0));
        // Straight across the wall it is two pieces.
        let across: Vec<Point2> = (0..40)
            .map(|k| Point2::new(-4.0 + 0.1 * f64::from(k), 0.3))
            .collect();
        assert_eq!(settled(&cutter, &across, 0.05).len(), 2);
    }
}
