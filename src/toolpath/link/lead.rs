//! Leads: off the surface, and onto it, along an arc that is tangent to the pass, so that no mark is left where it begins or ends.
//!
//! The arc stands upright over the pass's heading. It is taken only where the ball stays out of the part all along it (proven by
//! dropping the ball at every point of it); where no arc fits the lead is none, and the tool goes straight up or down.

use crate::geom::{Point, Vector};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::fit::rest;
use crate::toolpath::pass::Pass;

/// A lead: where it is free of the surface, and the way between there and the pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Lead {
    /// Ball centres in the order they are gone through. Off the surface they begin behind the pass's last point and end at `end`;
    /// onto it they begin behind `end` and end on the pass's first point. Empty when `end` is on the pass.
    pub points: Vec<Point>,
    /// Where the ball is free of the surface.
    pub end: Point,
    /// Length of the arc, mm.
    pub length: f64,
}

/// Radii tried, mm, the widest first.
const RADII: [f64; 3] = [1.5, 0.75, 0.35];
/// The arc goes round until it heads up but for this, rad: the straight way up or down that follows then turns by no more.
const LEAN: f64 = 0.05;
/// Turn of each piece of the arc, rad.
const PIECE: f64 = 0.1;

/// Off the end of a pass.
pub fn out(cutter: &DropCutter, pass: &Pass, hint: &mut Hint) -> Lead {
    let run = pass.run();
    let n = run.len();
    let end = run.last().copied().unwrap_or_else(Point::origin);
    let heading = if n > 1 {
        end - run[n - 2]
    } else {
        Vector::zeros()
    };
    match arc(cutter, end, heading, hint) {
        Some((points, length)) => Lead {
            end: points[points.len() - 1],
            points,
            length,
        },
        None => none(end),
    }
}

/// Onto the start of a pass.
pub fn onto(cutter: &DropCutter, pass: &Pass, hint: &mut Hint) -> Lead {
    let begin = pass.points.first().copied().unwrap_or_else(Point::origin);
    let heading = pass.points.get(1).map_or(Vector::zeros(), |p| begin - p);
    match arc(cutter, begin, heading, hint) {
        Some((mut points, length)) => {
            points.reverse();
            let end = points.remove(0);
            points.push(begin);
            Lead {
                points,
                end,
                length,
            }
        }
        None => none(begin),
    }
}

fn none(end: Point) -> Lead {
    Lead {
        points: Vec::new(),
        end,
        length: 0.0,
    }
}

/// Points of the arc that leaves `at` along `heading` and bends upwards, without `at` itself.
fn arc(
    cutter: &DropCutter,
    at: Point,
    heading: Vector,
    hint: &mut Hint,
) -> Option<(Vec<Point>, f64)> {
    let t = heading.try_normalize(1e-12)?;
    let flat = Vector::new(t.x, t.y, 0.0).try_normalize(1e-12)?;
    // Upwards across the heading, in the upright plane through it.
    let up = (Vector::z() - t * t.z).try_normalize(1e-12)?;
    if up.dot(&flat).abs() > 0.95 {
        return None; // nearly upright already
    }
    let sweep = std::f64::consts::FRAC_PI_2 - t.z.clamp(-1.0, 1.0).asin() - LEAN;
    let pieces = (sweep / PIECE).ceil().max(1.0) as usize;
    RADII.iter().find_map(|&r| {
        let points: Vec<Point> = (1..=pieces)
            .map(|k| {
                let a = sweep * k as f64 / pieces as f64;
                at + (t * a.sin() + up * (1.0 - a.cos())) * r
            })
            .collect();
        let clear = points
            .iter()
            .all(|p| rest(cutter, p.x, p.y, hint).is_none_or(|s| p.z >= s.center.z - 1e-6));
        clear.then_some((points, r * sweep))
    })
}
