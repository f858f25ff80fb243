//! Linking: from the end of one pass to the start of the next, along the surface when that is proven and quicker, else through the
//! air, no higher than needed.

pub(in crate::toolpath) mod bridge;
mod calm;
pub mod chain;
pub(in crate::toolpath) mod errand;
mod lead;
mod onward;
pub mod order;
pub(in crate::toolpath) mod turn;

use super::ease::{EaseOptions, ease_path};
use super::fit::FitOptions;
use super::moves::{Move, MoveKind, Section, Toolpath};
use super::pass::{Pass, PassKind, slopes};
use crate::feature::Regions;
use crate::geom::{Point, Vector};
use crate::part::Mesh;
use crate::reach::{DropCutter, Hint};
use bridge::surface_or_bridge;
use calm::calm;
use chain::{Chain, Ends, exit, quickest_turn, smooth_link, start};
use lead::Lead;
use onward::onward;
use turn::Slant;

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
    /// Retracts go at least as high as this (a height of the ball's centre); -inf for no higher than is proven safe.
    pub retract_center_z: f64,
    /// Vertical acceleration that links keep to, and cuts to half of, by a lower feed where it takes one: the Z axis' own, mm/s²; +inf for none.
    pub vertical: f64,
    /// How much longer a link along the surface may take than a retract, s; -inf to retract after every pass.
    pub retract_worth: f64,
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

/// A good [`LinkOptions::retract_worth`], s: a retract leaves a mark, and the plunge behind it another.
pub const RETRACT_WORTH: f64 = 2.0;

/// Joins ordered chains into one toolpath: the ball's centre becomes the tool tip, one radius lower. Also says which feature each
/// section of it cuts.
///
/// A hop through the air: off the surface along an arc, up at feed until the ball is out of the stock, up at rapid speed, across, down
/// to the clearance above the stock, the plunge, and along an arc onto the surface.
pub fn link(
    cutter: &DropCutter,
    air: &Air,
    ordered: &[Chain],
    regions: &Regions,
    options: &LinkOptions,
    fitting: &FitOptions,
    easing: &EaseOptions,
) -> (Toolpath, Vec<Option<usize>>) {
    let down = Vector::new(0.0, 0.0, -cutter.radius());
    let mut path = Toolpath {
        safe_z: options.safe_center_z - cutter.radius(),
        ..Toolpath::default()
    };
    let mut last: Option<&Pass> = None;
    let mut section_features: Vec<Option<usize>> = Vec::new();
    let mut hint = Hint::default();
    let go = |moves: &mut Vec<Move>, kind: MoveKind, c: Point| {
        moves.push(Move::straight(kind, c + down))
    };
    for chain in ordered {
        let Some(first) = chain.first().filter(|p| !p.points.is_empty()) else {
            continue;
        };
        if section_features.last() != Some(&first.feature) {
            section_features.push(first.feature);
            let name = match first.feature {
                Some(k) => format!("feature {} {}", k + 1, regions.features[k].kind.name()),
                None => "border".to_string(),
            };
            path.sections.push(Section {
                name,
                first_move: path.moves.len(),
            });
        }
        let way = match last {
            None => Link::Hop(Hop::new(cutter, air, None, first, options, &mut hint)),
            Some(from) => between(cutter, air, from, first, options, fitting, &mut hint),
        };
        match way {
            Link::Down(points) => points
                .iter()
                .for_each(|p| go(&mut path.moves, MoveKind::Link, *p)),
            Link::Hop(hop) => hop
                .moves(options, last.is_none())
                .into_iter()
                .for_each(|(kind, p)| go(&mut path.moves, kind, p)),
        }
        for pass in chain {
            let kind = if pass.kind == PassKind::Turn {
                MoveKind::Link
            } else {
                MoveKind::Cut
            };
            pass.run()[1..]
                .iter()
                .for_each(|p| go(&mut path.moves, kind, *p));
            last = Some(pass);
        }
    }
    if let Some(from) = last {
        let out = lead::out(cutter, from, &mut hint);
        out.points
            .iter()
            .for_each(|p| go(&mut path.moves, MoveKind::Link, *p));
        let c = out.end;
        let free = air.from(c.x, c.y, &mut hint).max(c.z);
        go(&mut path.moves, MoveKind::Link, Point::new(c.x, c.y, free));
        go(
            &mut path.moves,
            MoveKind::Retract,
            Point::new(
                c.x,
                c.y,
                options.safe_center_z.max(free + options.clearance),
            ),
        );
    }
    ease_path(cutter, &mut path, easing);
    calm(&mut path.moves, options);
    (path, section_features)
}

/// How to get from one pass to the next.
enum Link {
    /// Along the surface through these centres.
    Down(Vec<Point>),
    /// Through the air.
    Hop(Hop),
}

/// A way through the air.
struct Hop {
    /// Off the surface; none before the first pass.
    off: Option<Lead>,
    /// Height at which the ball is out of the stock behind it.
    out_z: f64,
    /// Height of the way across.
    top_z: f64,
    /// Height above the stock from which it plunges.
    over_z: f64,
    /// Onto the surface: its points end on the first of the pass.
    onto: Lead,
}

impl Hop {
    fn new(
        cutter: &DropCutter,
        air: &Air,
        from: Option<&Pass>,
        to: &Pass,
        options: &LinkOptions,
        hint: &mut Hint,
    ) -> Hop {
        let onto = lead::onto(cutter, to, hint);
        let p = onto.end;
        let over_z = air.from(p.x, p.y, hint).max(p.z) + options.clearance;
        match from {
            None => Hop {
                off: None,
                out_z: over_z,
                top_z: options.safe_center_z.max(over_z),
                over_z,
                onto,
            },
            Some(from) => {
                let off = lead::out(cutter, from, hint);
                let out_z = air.from(off.end.x, off.end.y, hint).max(off.end.z);
                let top_z = (air.along(&off.end, &p).max(out_z) + options.clearance)
                    .max(over_z)
                    .max(options.retract_center_z);
                Hop {
                    off: Some(off),
                    out_z,
                    top_z,
                    over_z,
                    onto,
                }
            }
        }
    }

    fn moves(&self, options: &LinkOptions, first: bool) -> Vec<(MoveKind, Point)> {
        let mut out = Vec::new();
        let to = self.onto.end;
        if let Some(off) = &self.off {
            let e = off.end;
            out.extend(off.points.iter().map(|p| (MoveKind::Link, *p)));
            out.push((MoveKind::Link, Point::new(e.x, e.y, self.out_z)));
            out.push((MoveKind::Retract, Point::new(e.x, e.y, self.top_z)));
        }
        let top = if first {
            options.safe_center_z.max(self.top_z)
        } else {
            self.top_z
        };
        out.push((MoveKind::Rapid, Point::new(to.x, to.y, top)));
        if top > self.over_z || first {
            out.push((MoveKind::Rapid, Point::new(to.x, to.y, self.over_z)));
        }
        out.push((MoveKind::Plunge, to));
        out.extend(self.onto.points.iter().map(|p| (MoveKind::Link, *p)));
        out
    }

    /// Each leg from rest to rest, s.
    fn time(&self, options: &LinkOptions) -> f64 {
        let Some(off) = &self.off else { return 0.0 };
        let (from, to) = (off.end, self.onto.end);
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
        leg(self.out_z - from.z, options.feed)
            + leg(self.top_z - self.out_z, options.rapid_z)
            + leg((to.xy() - from.xy()).norm(), options.rapid_xy)
            + leg(self.top_z - self.over_z, options.rapid_z)
            + leg(self.over_z - to.z, options.plunge)
            + (off.length + self.onto.length) / options.feed
    }
}

/// A smooth link along the surface, dropped and proven like a pass; a hop when that is quicker or the ball would fall past the part.
fn between(
    cutter: &DropCutter,
    air: &Air,
    from: &Pass,
    to: &Pass,
    options: &LinkOptions,
    fitting: &FitOptions,
    hint: &mut Hint,
) -> Link {
    let hop = Hop::new(cutter, air, Some(from), to, options, hint);
    let (Some(a), Some(b)) = (from.run().last().copied(), to.points.first().copied()) else {
        return Link::Hop(hop);
    };
    if (a.xy() - b.xy()).norm() < 1e-6 && (a.z - b.z).abs() < 1e-6 {
        return Link::Down(Vec::new());
    }
    let limit = hop.time(options) + options.retract_worth;
    let (Some(p), Some(q)) = (exit(from), start(to)) else {
        return Link::Hop(hop);
    };
    // The least it can take: bail out before the work of dropping it.
    let middle = nalgebra::center(&p.at, &q.at);
    let slant = Slant::of(&slopes(cutter)(&middle));
    let (way, time) = quickest_turn(&slant, &p, &q, options);
    if time > limit {
        return Link::Hop(hop);
    }
    let run = from.run();
    let onto = to.run();
    let ends = Ends {
        from: &a,
        before: &run,
        onto: &onto,
    };
    let points = surface_or_bridge(cutter, &way, &ends, options, fitting)
        .or_else(|| onward(cutter, ends.before, ends.onto, fitting))
        // Up or down a wall along it, where that is quicker than through the air.
        .or_else(|| smooth_link(cutter, way, &ends, options, fitting));
    let Some(points) = points else {
        return Link::Hop(hop);
    };
    let length: f64 = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    if length / options.feed > limit {
        return Link::Hop(hop);
    }
    Link::Down(points[1..].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Those of some small mill.
    pub const SOME: LinkOptions = LinkOptions {
        feed: 25.0,
        plunge: 8.0,
        rapid_xy: 60.0,
        rapid_z: 40.0,
        acceleration: 500.0,
        allowance: 0.5,
        clearance: 0.5,
        block_center_z: f64::NEG_INFINITY,
        safe_center_z: 10.0,
        retract_center_z: f64::NEG_INFINITY,
        vertical: f64::INFINITY,
        retract_worth: 2.0,
    };
}
