//! Errands: short chains (fills above all) are cut on the way past them, not on a trip of their own.
//!
//! ```text
//!   --------.  .------->      a pass is left, and taken up again, at the place from which there and back is quickest
//!            ''
//!           errand
//! ```
//!
//! A fill is a millimetre or two long and lies beside passes that come by anyway; a trip to it at the end of a feature crosses the
//! feature. Chains in and out, ball centres, mm.

use super::chain::{Chain, exit, quickest_turn, start, surface_link};
use super::fit::FitOptions;
use super::link::LinkOptions;
use super::pass::{Pass, PassKind};
use super::turn::{Pose, Turn};
use crate::geom::{Point, Point2};
use crate::reach::DropCutter;

/// What is an errand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrandOptions {
    /// Chains no longer than this are, mm.
    pub longest: f64,
    /// Passes further away than this are not asked, mm.
    pub reach: f64,
}

/// Ways tried for one errand before it is left a trip of its own.
const TRIES: usize = 4;

/// Works short chains into long ones. What finds no way on the surface is handed on as it came. Cost: each errand looks at the points of
/// passes in reach.
pub fn errands(
    cutter: &DropCutter,
    chains: Vec<Chain>,
    options: &ErrandOptions,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Vec<Chain> {
    let length = |c: &Chain| c.iter().map(Pass::length).sum::<f64>();
    let is_errand =
        |c: &Chain| c.iter().all(|p| p.points.len() > 1) && length(c) <= options.longest;
    let (short, mut hosts): (Vec<Chain>, Vec<Chain>) = chains.into_iter().partition(is_errand);
    if hosts.is_empty() {
        return short;
    }
    let mut boxes: Vec<Vec<Box2>> = hosts
        .iter()
        .map(|c| c.iter().map(Box2::of).collect())
        .collect();
    let mut left = Vec::new();
    for errand in short {
        let Some(errand) = opened(errand) else {
            continue;
        };
        let mut ways = ways(&hosts, &boxes, &errand, options, links);
        ways.truncate(TRIES);
        let laid = ways
            .iter()
            .find_map(|w| Some((w, w.lay(cutter, &hosts[w.host], &errand, links, fitting)?)));
        match laid {
            Some((w, chain)) => {
                boxes[w.host] = chain.iter().map(Box2::of).collect();
                hosts[w.host] = chain;
            }
            None => left.push(errand),
        }
    }
    hosts.extend(left);
    hosts
}

/// A chain whose loops are open runs that end where they began; none if there is nothing in it.
fn opened(mut c: Chain) -> Option<Chain> {
    for p in &mut c {
        if p.closed {
            p.points = p.run();
            p.closed = false;
        }
    }
    (!c.is_empty()).then_some(c)
}

fn reversed(c: &Chain) -> Chain {
    let mut c = c.clone();
    c.reverse();
    c.iter_mut().for_each(|p| p.points.reverse());
    c
}

/// Corners of a pass in plan.
struct Box2 {
    low: Point2,
    high: Point2,
}

impl Box2 {
    fn of(p: &Pass) -> Box2 {
        let mut b = Box2 {
            low: Point2::new(f64::INFINITY, f64::INFINITY),
            high: Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
        };
        for q in &p.points {
            b.low = Point2::new(b.low.x.min(q.x), b.low.y.min(q.y));
            b.high = Point2::new(b.high.x.max(q.x), b.high.y.max(q.y));
        }
        b
    }

    fn gap(&self, at: &Point2) -> f64 {
        let dx = (self.low.x - at.x).max(at.x - self.high.x).max(0.0);
        let dy = (self.low.y - at.y).max(at.y - self.high.y).max(0.0);
        dx.hypot(dy)
    }
}

/// Where a host is left for an errand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Site {
    /// At a point of a pass, and back to it.
    Within { pass: usize, point: usize },
    /// Where the turn at this place of the chain begins, and back to it. (The turn itself stays: it has cut its ground.)
    Before { turn: usize },
    /// A loop of its own is gone round from this point, and then left for good.
    Loop { point: usize },
    /// Behind the last pass.
    End,
    /// Before the first.
    Start,
}

struct Way {
    host: usize,
    site: Site,
    backwards: bool,
    out: Option<Turn>,
    back: Option<Turn>,
    time: f64,
}

/// The ways to do an errand, the quickest first.
fn ways(
    hosts: &[Chain],
    boxes: &[Vec<Box2>],
    errand: &Chain,
    options: &ErrandOptions,
    links: &LinkOptions,
) -> Vec<Way> {
    // (least time, host, site): sorted before any turn is worked out.
    let ends = ends_of(errand);
    let Some((a, b)) = ends else {
        return Vec::new();
    };
    let mut sites: Vec<(f64, usize, Site, bool)> = Vec::new();
    for (h, host) in hosts.iter().enumerate() {
        for (k, pass) in host.iter().enumerate() {
            if boxes[h][k].gap(&a) > options.reach && boxes[h][k].gap(&b) > options.reach {
                continue;
            }
            let mut offer = |site: Site, from: Option<Point>, to: Option<Point>| {
                for backwards in [false, true] {
                    let (a, b) = if backwards { (b, a) } else { (a, b) };
                    let there = from.map_or(0.0, |p| (p.xy() - a).norm());
                    let back = to.map_or(0.0, |p| (p.xy() - b).norm());
                    if there <= options.reach && back <= 2.0 * options.reach {
                        sites.push(((there + back) / links.feed, h, site, backwards));
                    }
                }
            };
            let n = pass.points.len();
            let single = host.len() == 1 && pass.closed;
            if pass.kind == PassKind::Turn {
                let p = pass.points.first().copied();
                if k > 0 {
                    offer(Site::Before { turn: k }, p, p);
                }
            } else if single {
                for (i, p) in pass.points.iter().enumerate() {
                    offer(Site::Loop { point: i }, Some(*p), None);
                }
            } else {
                for i in 1..n.saturating_sub(1) {
                    let p = Some(pass.points[i]);
                    offer(Site::Within { pass: k, point: i }, p, p);
                }
                if k + 1 == host.len() {
                    offer(Site::End, pass.points.last().copied(), None);
                }
                if k == 0 {
                    offer(Site::Start, None, pass.points.first().copied());
                }
            }
        }
    }
    sites.sort_by(|x, y| x.0.total_cmp(&y.0));
    let turned = reversed(errand);
    let mut out: Vec<Way> = Vec::new();
    for (least, host, site, backwards) in sites {
        if out.len() >= TRIES && out[TRIES - 1].time <= least {
            break;
        }
        let e = if backwards { &turned } else { errand };
        if let Some(way) = way(&hosts[host], host, site, backwards, e, links) {
            let at = out.partition_point(|w| w.time <= way.time);
            if at < TRIES {
                out.insert(at, way);
                out.truncate(TRIES);
            }
        }
    }
    out
}

fn ends_of(errand: &Chain) -> Option<(Point2, Point2)> {
    Some((
        errand.first()?.points.first()?.xy(),
        errand.last()?.points.last()?.xy(),
    ))
}

fn pose(at: &Point, to: &Point) -> Option<Pose> {
    let d = to.xy() - at.xy();
    let l = d.norm();
    (l > 0.0).then(|| Pose {
        at: at.xy(),
        heading: d / l,
    })
}

fn way(
    host: &Chain,
    h: usize,
    site: Site,
    backwards: bool,
    errand: &Chain,
    links: &LinkOptions,
) -> Option<Way> {
    let (enter, leave) = (start(errand.first()?)?, exit(errand.last()?)?);
    let heading_in = |p: &Pass, i: usize| -> Option<Pose> {
        let mut q = pose(p.points.get(i.checked_sub(1)?)?, p.points.get(i)?)?;
        q.at = p.points[i].xy();
        Some(q)
    };
    let (from, to) = match site {
        Site::Within { pass, point } => {
            let p = host.get(pass)?;
            (
                Some(heading_in(p, point)?),
                Some(pose(p.points.get(point)?, p.points.get(point + 1)?)?),
            )
        }
        Site::Before { turn } => (
            Some(exit(host.get(turn.checked_sub(1)?)?)?),
            Some(start(host.get(turn)?)?),
        ),
        Site::Loop { point } => {
            let p = host.first()?;
            let n = p.points.len();
            let mut q = pose(p.points.get((point + n - 1) % n)?, p.points.get(point)?)?;
            q.at = p.points[point].xy();
            (Some(q), None)
        }
        Site::End => (Some(exit(host.last()?)?), None),
        Site::Start => (None, Some(start(host.first()?)?)),
    };
    let mut time = 0.0;
    let mut turn_to = |a: Option<Pose>, b: Pose| {
        a.map(|a| {
            let (t, s) = quickest_turn(&a, &b, links);
            time += s;
            t
        })
    };
    let out = turn_to(from, enter);
    let back = match to {
        Some(to) => turn_to(Some(leave), to),
        None => None,
    };
    Some(Way {
        host: h,
        site,
        backwards,
        out,
        back,
        time,
    })
}

impl Way {
    /// The host with the errand in it; none where a turn cannot be laid on the surface.
    fn lay(
        &self,
        cutter: &DropCutter,
        host: &Chain,
        errand: &Chain,
        links: &LinkOptions,
        fitting: &FitOptions,
    ) -> Option<Chain> {
        let feature = host.first()?.feature;
        let mut middle: Chain = if self.backwards {
            reversed(errand)
        } else {
            errand.clone()
        };
        middle.iter_mut().for_each(|p| p.feature = feature);
        let (mut before, after): (Chain, Chain) = match self.site {
            Site::Within { pass, point } => {
                let p = host.get(pass)?;
                let part = |points: &[Point]| Pass {
                    points: points.to_vec(),
                    ..p.clone()
                };
                let mut before = host[..pass].to_vec();
                before.push(part(&p.points[..=point]));
                let mut after = vec![part(&p.points[point..])];
                after.extend_from_slice(&host[pass + 1..]);
                (before, after)
            }
            Site::Before { turn } => (host[..turn].to_vec(), host[turn..].to_vec()),
            Site::Loop { point } => {
                let mut p = host.first()?.clone();
                p.points.rotate_left(point);
                p.points = p.run();
                p.closed = false;
                (vec![p], Chain::new())
            }
            Site::End => (host.clone(), Chain::new()),
            Site::Start => (Chain::new(), host.clone()),
        };
        let laid = |way: &Turn, from: &Chain, to: &Chain| -> Option<Pass> {
            let (a, b) = (from.last()?.points.last()?, to.first()?.points.first()?);
            Some(Pass {
                kind: PassKind::Turn,
                feature,
                points: surface_link(cutter, way, a, b, links, fitting)?,
                closed: false,
            })
        };
        let there = match &self.out {
            Some(way) => Some(laid(way, &before, &middle)?),
            None => None,
        };
        let back = match &self.back {
            Some(way) => Some(laid(way, &middle, &after)?),
            None => None,
        };
        before.extend(there);
        before.append(&mut middle);
        before.extend(back);
        before.extend(after);
        Some(before)
    }
}
