//! Linking: from the end of one pass to the start of the next, along the surface when that is proven and quicker, else through the
//! air, no higher than needed.

use super::fit::{FitOptions, fit, rest};
use super::moves::{Move, MoveKind, Section, Toolpath};
use super::pass::Pass;
use crate::feature::Regions;
use crate::geom::{Point, Point2, Vector};
use crate::reach::{DropCutter, Hint};

/// The few speeds that decide between two links, and how much air is safe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkOptions {
    /// Cutting feed, mm/s.
    pub feed: f64,
    /// Plunge feed, mm/s.
    pub plunge: f64,
    /// Rapid speed in the plane, mm/s.
    pub rapid_xy: f64,
    /// Rapid speed along Z, mm/s.
    pub rapid_z: f64,
    /// Acceleration, mm/s² (the slowest axis).
    pub acceleration: f64,
    /// Stock that may stand above the surface, measured upright, mm.
    pub allowance: f64,
    /// Air between the ball and that stock in rapid moves, mm.
    pub clearance: f64,
    /// Height of the ball's centre at which everything is clear, mm.
    pub safe_center_z: f64,
}

/// Joins ordered passes into one toolpath: the ball's centre becomes the tool tip, one radius lower.
pub fn link(
    cutter: &DropCutter,
    ordered: &[Pass],
    regions: &Regions,
    options: &LinkOptions,
    fitting: &FitOptions,
) -> Toolpath {
    let down = Vector::new(0.0, 0.0, -cutter.radius());
    let mut path = Toolpath {
        safe_z: options.safe_center_z - cutter.radius(),
        ..Toolpath::default()
    };
    let mut at: Option<Point> = None;
    let mut feature: Option<Option<usize>> = None;
    let go =
        |moves: &mut Vec<Move>, kind: MoveKind, c: Point| moves.push(Move { kind, to: c + down });
    for pass in ordered {
        let run = pass.run();
        let Some(&start) = run.first() else { continue };
        if feature != Some(pass.feature) {
            feature = Some(pass.feature);
            let name = match pass.feature {
                Some(k) => format!("feature {} {}", k + 1, regions.features[k].kind.name()),
                None => "border".to_string(),
            };
            path.sections.push(Section {
                name,
                first_move: path.moves.len(),
            });
        }
        let over = start + Vector::new(0.0, 0.0, options.allowance + options.clearance);
        match at {
            None => {
                go(
                    &mut path.moves,
                    MoveKind::Rapid,
                    Point::new(start.x, start.y, options.safe_center_z.max(over.z)),
                );
                go(&mut path.moves, MoveKind::Rapid, over);
                go(&mut path.moves, MoveKind::Plunge, start);
            }
            Some(from) => match stay_down(cutter, &from, &start, options, fitting) {
                Some(points) => points
                    .iter()
                    .for_each(|p| go(&mut path.moves, MoveKind::Link, *p)),
                None => {
                    let top = hop_height(cutter, &from, &start, options).max(over.z);
                    go(
                        &mut path.moves,
                        MoveKind::Retract,
                        Point::new(from.x, from.y, top),
                    );
                    go(
                        &mut path.moves,
                        MoveKind::Rapid,
                        Point::new(start.x, start.y, top),
                    );
                    if top > over.z {
                        go(&mut path.moves, MoveKind::Rapid, over);
                    }
                    go(&mut path.moves, MoveKind::Plunge, start);
                }
            },
        }
        run[1..]
            .iter()
            .for_each(|p| go(&mut path.moves, MoveKind::Cut, *p));
        at = run.last().copied();
    }
    if let Some(c) = at {
        let top = options
            .safe_center_z
            .max(c.z + options.allowance + options.clearance);
        go(
            &mut path.moves,
            MoveKind::Retract,
            Point::new(c.x, c.y, top),
        );
    }
    path
}

/// A link along the surface, straight in plan: dropped and proven like a pass. `None` when the way through the air is quicker or
/// the ball would fall past the part.
fn stay_down(
    cutter: &DropCutter,
    from: &Point,
    to: &Point,
    options: &LinkOptions,
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    let flat = (to.xy() - from.xy()).norm();
    let hop_z = hop_height(cutter, from, to, options);
    let air = air_time(from, to, hop_z, options);
    let stop = options.feed / options.acceleration;
    // The least it can take: bail out before the work of dropping it.
    if flat / options.feed > air {
        return None;
    }
    if flat < 1e-6 && (from.z - to.z).abs() < 1e-6 {
        return Some(Vec::new());
    }
    let n = (flat / fitting.probe).ceil().max(1.0) as usize;
    let curve: Vec<Point2> = (0..=n)
        .map(|k| from.xy() + (to.xy() - from.xy()) * (k as f64 / n as f64))
        .collect();
    let mut runs = fit(cutter, &curve, fitting);
    if runs.len() != 1 {
        return None;
    }
    let run = runs.swap_remove(0);
    let (first, last) = (run.first()?, run.last()?);
    // The ends must be the passes' own, not a ball that found another footing at the same place in plan.
    if (first - from).norm() > 0.01 || (last - to).norm() > 0.01 {
        return None;
    }
    let length: f64 = run.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    if length / options.feed + stop > air {
        return None;
    }
    let mut points = run[1..].to_vec();
    if let Some(end) = points.last_mut() {
        *end = *to;
    }
    Some(points)
}

/// Height of the ball's centre that clears the part and its stock on the straight way between two places.
fn hop_height(cutter: &DropCutter, from: &Point, to: &Point, options: &LinkOptions) -> f64 {
    let flat = (to.xy() - from.xy()).norm();
    // The centre surface may rise between two probes by no more than the ball lets it: a step of the ball's radius / 8 hides less
    // than radius / 100 of a point's rise, and the clearance stands above that.
    let gap = (cutter.radius() / 8.0).min(options.clearance);
    let n = (flat / gap).ceil().max(1.0) as usize;
    let mut hint = Hint::default();
    let mut top = from.z.max(to.z);
    for k in 0..=n {
        let q = from.xy() + (to.xy() - from.xy()) * (k as f64 / n as f64);
        if let Some(r) = rest(cutter, q.x, q.y, &mut hint) {
            top = top.max(r.center.z);
        }
    }
    (top + options.allowance + options.clearance)
        .min(options.safe_center_z.max(top + options.allowance))
}

/// Time of a hop: up, across, down at rapid speed, then the plunge; each leg from rest to rest.
fn air_time(from: &Point, to: &Point, hop_z: f64, options: &LinkOptions) -> f64 {
    let leg = |length: f64, speed: f64| {
        if length <= 0.0 {
            return 0.0;
        }
        let a = options.acceleration;
        if length * a >= speed * speed {
            length / speed + speed / a
        } else {
            2.0 * (length / a).sqrt()
        }
    };
    let plunge = options.allowance + options.clearance;
    leg(hop_z - from.z, options.rapid_z)
        + leg((to.xy() - from.xy()).norm(), options.rapid_xy)
        + leg((hop_z - to.z - plunge).max(0.0), options.rapid_z)
        + leg(plunge, options.plunge)
}
