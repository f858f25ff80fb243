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

use super::LinkOptions;
use super::chain::{Chain, Ends, exit, quickest_turn, smooth_link, start};
use super::turn::{Pose, Slant, Turn};
use crate::geom::{Point, Point2};
use crate::reach::DropCutter;
use crate::toolpath::fit::FitOptions;
use crate::toolpath::pass::{Pass, PassKind, slopes};

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
    let mut slope = slopes(cutter);
    let mut left = Vec::new();
    for errand in short {
        let Some(errand) = opened(errand) else {
            continue;
        };
        // Passes in reach lie on much the same slope.
        let slant = ends_of(&errand).map_or(Slant::default(), |(a, _)| Slant::of(&slope(&a)));
        let mut ways = ways(&hosts, &boxes, &errand, &slant, options, links);
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
    slant: &Slant,
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
        if let Some(way) = way(&hosts[host], host, site, backwards, e, slant, links) {
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

/// At one place, heading for another.
fn pose(at: &Point, to: &Point) -> Option<Pose> {
    Pose::new(at.xy(), (to - at).xy())
}

fn way(
    host: &Chain,
    h: usize,
    site: Site,
    backwards: bool,
    errand: &Chain,
    slant: &Slant,
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
            let (t, s) = quickest_turn(slant, &a, &b, links);
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
            let (before, onto) = (&from.last()?.points, &to.first()?.points);
            let ends = Ends {
                from: before.last()?,
                before,
                onto,
            };
            Some(Pass {
                kind: PassKind::Turn,
                feature,
                points: smooth_link(cutter, way.clone(), &ends, links, fitting)?,
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use crate::toolpath::link::tests::SOME;

    const R: f64 = 3.0;

    fn plate() -> DropCutter {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let triangles = vec![
            [p(0.0, 0.0), p(40.0, 0.0), p(40.0, 40.0)],
            [p(0.0, 0.0), p(40.0, 40.0), p(0.0, 40.0)],
        ];
        DropCutter::new(&Mesh { triangles }, R)
    }

    fn pass(kind: PassKind, from: (f64, f64), to: (f64, f64), n: usize) -> Pass {
        let at = |k: usize| k as f64 / (n - 1) as f64;
        Pass {
            kind,
            feature: Some(0),
            points: (0..n)
                .map(|k| {
                    let x = from.0 + (to.0 - from.0) * at(k);
                    Point::new(x, from.1 + (to.1 - from.1) * at(k), R)
                })
                .collect(),
            closed: false,
        }
    }

    const HOW: ErrandOptions = ErrandOptions {
        longest: 5.0,
        reach: 4.0,
    };

    /// A long pass, a fill at this height beside its middle, and what becomes of them.
    fn with_fill_at(y: f64) -> ([Chain; 2], Vec<Chain>) {
        let cutter = plate();
        let fitting = FitOptions::for_scallop(0.02, R);
        let host = vec![pass(PassKind::Level, (5.0, 20.0), (35.0, 20.0), 61)];
        let fill = vec![pass(PassKind::Fill, (18.0, y), (20.0, y), 5)];
        let both = [host, fill];
        let out = errands(&cutter, both.to_vec(), &HOW, &SOME, &fitting);
        (both, out)
    }

    /// Everything that was cut is cut, the chain hangs together, and the way there and back is short.
    #[test]
    fn a_fill_is_cut_on_the_way_past_it() {
        let ([host, fill], out) = with_fill_at(20.35);
        assert_eq!(out.len(), 1);
        let chain = &out[0];
        for w in chain.windows(2) {
            let gap = w[1].points[0] - w[0].points.last().unwrap();
            assert!(gap.norm() < 1e-9, "{gap}");
        }
        let all: Vec<&Point> = chain.iter().flat_map(|p| &p.points).collect();
        for p in host[0].points.iter().chain(&fill[0].points) {
            assert!(all.iter().any(|q| (**q - p).norm() < 1e-9), "{p}");
        }
        let turns: f64 = chain
            .iter()
            .filter(|p| p.kind == PassKind::Turn)
            .map(Pass::length)
            .sum();
        assert!(turns < 9.0, "{turns}");
    }

    #[test]
    fn what_is_far_keeps_its_own_trip() {
        let (both, out) = with_fill_at(30.0);
        assert_eq!(out, both);
    }
}
