//! Linking: from the end of one pass to the start of the next, along the surface when that is proven and quicker, else through the
//! air, no higher than needed.

use super::fit::{FitOptions, fit_between};
use super::moves::{Move, MoveKind, Section, Toolpath};
use super::pass::Pass;
use crate::feature::Regions;
use crate::geom::{Point, Point2, Vector};
use crate::part::Mesh;
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
    /// Stock that may stand on the surface, along its normal, mm.
    pub allowance: f64,
    /// Air between the ball and that stock in rapid moves, mm.
    pub clearance: f64,
    /// The top of a block of stock, as a height of the ball's centre, which rapids stay above; -inf when the stock follows the part.
    pub block_center_z: f64,
    /// Height of the ball's centre at which everything is clear, mm.
    pub safe_center_z: f64,
}

/// Where the air begins: a ball thicker by the stock allowance, dropped onto the part.
#[derive(Debug)]
pub struct Air {
    thick: DropCutter,
    block: f64,
}

impl Air {
    /// Over the part that a cutter was made for.
    pub fn new(part: &Mesh, cutter: &DropCutter, options: &LinkOptions) -> Air {
        Air {
            thick: DropCutter::new(part, cutter.radius() + options.allowance),
            block: options.block_center_z,
        }
    }

    /// Lowest height of the ball's centre over a place at which it touches no stock.
    fn from(&self, x: f64, y: f64, hint: &mut Hint) -> f64 {
        let stock = self
            .thick
            .drop_near(x, y, hint)
            .map_or(f64::NEG_INFINITY, |c| c.center.z);
        stock.max(self.block)
    }

    /// The same over the whole straight way between two places.
    fn along(&self, from: &Point, to: &Point) -> f64 {
        let flat = (to.xy() - from.xy()).norm();
        // A ball of radius R passes over a needle within R of it: between two probes R/8 apart the needle lifts it by less than
        // R/500 more than at the nearer probe. The clearance is far above that.
        let n = (flat / (self.thick.radius() / 8.0)).ceil().max(1.0) as usize;
        let mut hint = Hint::default();
        (0..=n)
            .map(|k| {
                let q = from.xy() + (to.xy() - from.xy()) * (k as f64 / n as f64);
                self.from(q.x, q.y, &mut hint)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Joins ordered passes into one toolpath: the ball's centre becomes the tool tip, one radius lower. Also says which feature each
/// section of it cuts.
///
/// A hop through the air: up at feed until the ball is out of the stock, up at rapid speed, across, down to the clearance above the
/// stock, and the plunge.
pub fn link(
    cutter: &DropCutter,
    air: &Air,
    ordered: &[Pass],
    regions: &Regions,
    options: &LinkOptions,
    fitting: &FitOptions,
) -> (Toolpath, Vec<Option<usize>>) {
    let down = Vector::new(0.0, 0.0, -cutter.radius());
    let mut path = Toolpath {
        safe_z: options.safe_center_z - cutter.radius(),
        ..Toolpath::default()
    };
    let mut at: Option<Point> = None;
    let mut section_features: Vec<Option<usize>> = Vec::new();
    let mut hint = Hint::default();
    let go = |moves: &mut Vec<Move>, kind: MoveKind, c: Point| {
        moves.push(Move::straight(kind, c + down))
    };
    for pass in ordered {
        let run = pass.run();
        let Some(&start) = run.first() else { continue };
        if section_features.last() != Some(&pass.feature) {
            section_features.push(pass.feature);
            let name = match pass.feature {
                Some(k) => format!("feature {} {}", k + 1, regions.features[k].kind.name()),
                None => "border".to_string(),
            };
            path.sections.push(Section {
                name,
                first_move: path.moves.len(),
            });
        }
        let over_z = air.from(start.x, start.y, &mut hint).max(start.z) + options.clearance;
        let over = Point::new(start.x, start.y, over_z);
        match at {
            None => {
                go(
                    &mut path.moves,
                    MoveKind::Rapid,
                    Point::new(start.x, start.y, options.safe_center_z.max(over_z)),
                );
                go(&mut path.moves, MoveKind::Rapid, over);
                go(&mut path.moves, MoveKind::Plunge, start);
            }
            Some(from) => match stay_down(cutter, air, &from, &start, over_z, options, fitting) {
                Link::Down(points) => points
                    .iter()
                    .for_each(|p| go(&mut path.moves, MoveKind::Link, *p)),
                Link::Hop { out_z, top_z } => {
                    go(
                        &mut path.moves,
                        MoveKind::Link,
                        Point::new(from.x, from.y, out_z),
                    );
                    go(
                        &mut path.moves,
                        MoveKind::Retract,
                        Point::new(from.x, from.y, top_z),
                    );
                    go(
                        &mut path.moves,
                        MoveKind::Rapid,
                        Point::new(start.x, start.y, top_z),
                    );
                    if top_z > over_z {
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
        let out = air.from(c.x, c.y, &mut hint).max(c.z);
        go(&mut path.moves, MoveKind::Link, Point::new(c.x, c.y, out));
        go(
            &mut path.moves,
            MoveKind::Retract,
            Point::new(c.x, c.y, options.safe_center_z.max(out + options.clearance)),
        );
    }
    (path, section_features)
}

/// How to get from one pass to the next.
enum Link {
    /// Along the surface through these centres.
    Down(Vec<Point>),
    /// Out of the stock at `out_z`, across at `top_z`.
    Hop { out_z: f64, top_z: f64 },
}

/// A link along the surface, straight in plan, dropped and proven like a pass; a hop when that is quicker or the ball would fall
/// past the part.
fn stay_down(
    cutter: &DropCutter,
    air: &Air,
    from: &Point,
    to: &Point,
    over_z: f64,
    options: &LinkOptions,
    fitting: &FitOptions,
) -> Link {
    let out_z = air.from(from.x, from.y, &mut Hint::default()).max(from.z);
    let top_z = (air.along(from, to).max(out_z) + options.clearance).max(over_z);
    let hop = Link::Hop { out_z, top_z };
    let flat = (to.xy() - from.xy()).norm();
    if flat < 1e-6 && (from.z - to.z).abs() < 1e-6 {
        return Link::Down(Vec::new());
    }
    let limit = hop_time(from, to, out_z, top_z, over_z, options);
    // The least it can take: bail out before the work of dropping it.
    if flat / options.feed > limit {
        return hop;
    }
    let n = (flat / fitting.probe).ceil().max(1.0) as usize;
    let curve: Vec<Point2> = (0..=n)
        .map(|k| from.xy() + (to.xy() - from.xy()) * (k as f64 / n as f64))
        .collect();
    let mut runs = fit_between(cutter, &curve, from, to, fitting);
    if runs.len() != 1 {
        return hop;
    }
    let run = runs.swap_remove(0);
    // The ends must be the passes' own, not a ball that found another footing at the same place in plan.
    let ends_meet = run.first().is_some_and(|p| (p - from).norm() < 0.01)
        && run.last().is_some_and(|p| (p - to).norm() < 0.01);
    let length: f64 = run.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    // One stop, about, at either end.
    let stop = options.feed / options.acceleration;
    if !ends_meet || length / options.feed + stop > limit {
        return hop;
    }
    let mut points = run[1..].to_vec();
    if let Some(end) = points.last_mut() {
        *end = *to;
    }
    Link::Down(points)
}

/// Time of a hop, each leg from rest to rest.
fn hop_time(
    from: &Point,
    to: &Point,
    out_z: f64,
    top_z: f64,
    over_z: f64,
    options: &LinkOptions,
) -> f64 {
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
    leg(out_z - from.z, options.feed)
        + leg(top_z - out_z, options.rapid_z)
        + leg((to.xy() - from.xy()).norm(), options.rapid_xy)
        + leg(top_z - over_z, options.rapid_z)
        + leg(over_z - to.z, options.plunge)
}

impl Toolpath {
    /// About how long this takes, s: lengths over speeds, and a stop for each link. To compare plans of one part with, not to promise.
    pub fn rough_time(&self, options: &LinkOptions) -> f64 {
        let stop = options.feed / options.acceleration;
        self.moves
            .windows(2)
            .map(|w| {
                let length = w[1].length(&w[0].to);
                let turn = if w[0].kind == w[1].kind { 0.0 } else { stop };
                turn + match w[1].kind {
                    MoveKind::Cut | MoveKind::Link => length / options.feed,
                    MoveKind::Plunge => length / options.plunge,
                    MoveKind::Rapid | MoveKind::Retract => {
                        length / options.rapid_xy.min(options.rapid_z)
                    }
                }
            })
            .sum()
    }
}
