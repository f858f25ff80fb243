//! Chains: passes of one feature joined end to end by smooth turns on the surface, so that the tool goes on cutting without a stop.
//!
//! ```text
//!   ------------------.          neighbouring passes in turn: a half circle where their ends lie side by side,
//!   .-----------------'          a change of lane between closed loops, and wherever the next pass is too far
//!   '------------------          the chain ends; `order` and `link` take over
//! ```

use super::LinkOptions;
use super::bridge::{surface_or_bridge, turned_back};
use super::onward::onward;
use super::turn::{Pose, Slant, Turn, turn};
use crate::geom::{Point, Point2, Vector, Vector2};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::fit::{FitOptions, fit_between};
use crate::toolpath::pass::{Pass, PassKind, slopes};
use rayon::prelude::*;

/// How far the next pass may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainOptions {
    /// Flat stepover of the job, mm.
    pub stepover: f64,
    /// Passes whose ends are further apart than this many stepovers are not joined.
    pub reach: f64,
}

/// A run of passes, each beginning where the one before it ended; [`PassKind::Turn`] between cutting passes.
pub type Chain = Vec<Pass>;

/// Joins the passes of each feature into chains. Features keep the order in which they first come.
pub fn chains(
    cutter: &DropCutter,
    passes: Vec<Pass>,
    options: &ChainOptions,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Vec<Chain> {
    let mut groups: Vec<(Option<usize>, Vec<Pass>)> = Vec::new();
    let mut alone: Vec<Chain> = Vec::new();
    for p in passes {
        if p.points.len() < 2 {
            // A touch has no heading to be joined by.
            alone.push(vec![p]);
            continue;
        }
        match groups.iter_mut().find(|g| g.0 == p.feature) {
            Some(g) => g.1.push(p),
            None => groups.push((p.feature, vec![p])),
        }
    }
    let mut out: Vec<Chain> = groups
        .into_par_iter()
        .flat_map_iter(|(_, left)| joined(cutter, left, options, links, fitting))
        .collect();
    out.extend(alone);
    out
}

/// Greedy: from the end of the chain always to the pass that can be entered soonest; a new chain begins at the pass with the lowest
/// level left (an end of a family, never its middle).
fn joined(
    cutter: &DropCutter,
    passes: Vec<Pass>,
    options: &ChainOptions,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Vec<Chain> {
    let reach = Reach {
        plan: options.reach * options.stepover,
        rise: 2.0 * options.stepover,
    };
    let mut left: Vec<Option<Pass>> = passes.into_iter().map(Some).collect();
    let mut ends: Vec<Entries> = left.iter().flatten().map(Entries::of).collect();
    let mut alive: Vec<usize> = (0..left.len()).collect();
    // What is joined to what, before any link is laid: (pass, turn that leads to it).
    let mut plans: Vec<Vec<(Pass, Option<Turn>)>> = Vec::new();
    let mut slope = slopes(cutter);
    while let Some(&first) = alive.first() {
        alive.remove(0);
        let Some(start) = left[first].take() else {
            continue;
        };
        let mut chain = vec![(start, None)];
        let mut turned = false;
        while let Some((from, z)) = chain.last().and_then(|(p, _)| leaving(p)) {
            match next(&from, z, &alive, &ends, &reach, links, &mut slope) {
                Some((k, way, entry)) => {
                    let i = alive.remove(k);
                    if let Some(mut p) = left[i].take() {
                        entry.apply(&mut p);
                        chain.push((p, Some(way)));
                    }
                }
                // An open chain may go on from its other end, once.
                None if !turned && !chain[0].0.closed && chain.len() > 1 => {
                    let from = leaving(&reversed(&chain[0].0));
                    let more = from.is_some_and(|(f, z)| {
                        next(&f, z, &alive, &ends, &reach, links, &mut slope).is_some()
                    });
                    if !more {
                        break;
                    }
                    turned = true;
                    chain = backwards(chain);
                }
                None => break,
            }
        }
        plans.push(chain);
    }
    ends.clear();
    plans
        .into_par_iter()
        .flat_map_iter(|chain| lay(cutter, chain, links, fitting))
        .collect()
}

/// How far the next pass may be, mm.
struct Reach {
    plan: f64,
    /// Up or down, more than the way in plan is long: what is further is another ground, above or below a wall.
    rise: f64,
}

/// Where a pass ends in plan, and how high.
fn leaving(p: &Pass) -> Option<(Pose, f64)> {
    let end = if p.closed {
        p.points.first()?
    } else {
        p.points.last()?
    };
    Some((exit(p)?, end.z))
}

fn reversed(p: &Pass) -> Pass {
    let mut p = p.clone();
    if p.closed {
        // A loop is entered and left at its first point, whichever way round.
        p.points[1..].reverse();
    } else {
        p.points.reverse();
    }
    p
}

/// The same chain from its end: turns are symmetrical.
fn backwards(chain: Vec<(Pass, Option<Turn>)>) -> Vec<(Pass, Option<Turn>)> {
    let mut turns: Vec<Option<Turn>> = chain
        .iter()
        .skip(1)
        .map(|(_, t)| t.as_ref().map(Turn::reversed))
        .collect();
    turns.push(None);
    let mut out: Vec<(Pass, Option<Turn>)> = chain
        .into_iter()
        .map(|(p, _)| reversed(&p))
        .zip(turns)
        .collect();
    out.reverse();
    // After the reversal each turn leads to the pass behind it: the first has none.
    out
}

/// Lays the turns of a chain on the surface; where one cannot be laid the chain is cut in two.
fn lay(
    cutter: &DropCutter,
    chain: Vec<(Pass, Option<Turn>)>,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Vec<Chain> {
    let mut out: Vec<Chain> = Vec::new();
    let mut run: Chain = Vec::new();
    let joined = chain.len() > 1;
    // The last pass was a loop.
    let mut whole = false;
    for (mut p, way) in chain {
        let loops = p.closed;
        if joined && p.closed {
            if let Some(&first) = p.points.first() {
                p.points.push(first);
            }
            p.closed = false;
        }
        if let (Some(way), Some(last)) = (way, run.last_mut()) {
            let turn = joint(cutter, &way, last, &mut p, loops || whole, links, fitting);
            match turn {
                Some(points) => run.push(Pass {
                    kind: PassKind::Turn,
                    feature: p.feature,
                    points,
                    closed: false,
                }),
                None => out.push(std::mem::take(&mut run)),
            }
        }
        run.push(p);
        whole = loops;
    }
    out.push(run);
    out
}

/// What a link joins.
#[derive(Clone, Copy, Debug)]
pub struct Ends<'a> {
    /// Where it begins.
    pub from: &'a Point,
    /// The pass before it, which ends there.
    pub before: &'a [Point],
    /// The pass behind it.
    pub onto: &'a [Point],
}

/// A link that turns by more than this from one segment to the next, rad, is laid again in other ways.
const SHARP: f64 = 0.25;
/// Radii tried then, in shares of the first one.
const WIDER: [f64; 3] = [1.0, 1.6, 2.5];

/// A way in plan as a proven run on the surface, as [`surface_link`]. Where the slope changes along it, it may turn more sharply there than
/// it was drawn: then it is drawn for the slope at its middle, and wider, and the smoothest is taken.
pub fn smooth_link(
    cutter: &DropCutter,
    way: Turn,
    ends: &Ends,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    let to = ends.onto.first()?;
    let first = surface_link(cutter, &way, ends.from, to, links, fitting);
    let sharpest = |points: &Option<Vec<Point>>| {
        points
            .as_ref()
            .map_or(f64::INFINITY, |p| sharpest_turn(cutter, ends, p))
    };
    let mut best = (sharpest(&first), first);
    if best.0 <= SHARP {
        return best.1;
    }
    let behind = ends
        .before
        .iter()
        .rev()
        .find(|p| (*p - ends.from).norm() > 1e-9);
    let ahead = ends.onto.iter().find(|p| (*p - to).norm() > 1e-9);
    let (Some(from), Some(onto)) = (
        behind.and_then(|b| Pose::new(ends.from.xy(), (ends.from - b).xy())),
        ahead.and_then(|a| Pose::new(to.xy(), (a - to).xy())),
    ) else {
        return best.1;
    };
    let mut slope = slopes(cutter);
    let drawn = way.points(fitting.probe);
    let middle = drawn.get(drawn.len() / 2).copied().unwrap_or(from.at);
    let slants = [middle, from.at, onto.at].map(|p| Slant::of(&slope(&p)));
    for wider in WIDER {
        for slant in &slants {
            let radius = way.radius() * wider;
            let again = turn(slant, &from, &onto, radius);
            // Going round and round is no smoother way.
            if again.length > 2.0 * way.length + radius {
                continue;
            }
            let points = surface_link(cutter, &again, ends.from, to, links, fitting);
            let sharp = sharpest(&points);
            if sharp < best.0 {
                best = (sharp, points);
            }
            if best.0 <= SHARP {
                return best.1;
            }
        }
    }
    best.1
}

/// The sharpest turn on a link and where it joins its passes, but for corners of the part, rad.
fn sharpest_turn(cutter: &DropCutter, ends: &Ends, link: &[Point]) -> f64 {
    let long = |d: &Vector| d.norm() > SHORT;
    // Ways, each with the place where it begins.
    let mut ways: Vec<(Point, Vector)> = Vec::with_capacity(link.len() + 1);
    let behind = ends.before.iter().rev().map(|p| (*p, ends.from - p));
    ways.extend(behind.into_iter().find(|w| long(&w.1)));
    let own = link.windows(2).map(|w| (w[0], w[1] - w[0]));
    ways.extend(own.filter(|w| long(&w.1)));
    if let Some(to) = ends.onto.first() {
        ways.extend(ends.onto.iter().map(|p| (*to, p - to)).find(|w| long(&w.1)));
    }
    ways.windows(2)
        .map(|w| {
            let turn = w[0].1.angle(&w[1].1);
            if turn <= SHARP {
                return turn;
            }
            cutter.own_turn(&w[1].0, &w[0].1.normalize(), &w[1].1.normalize())
        })
        .fold(0.0, f64::max)
}

/// Segments shorter than this have no direction to speak of, mm.
const SHORT: f64 = 0.005;

/// The turn from the end of one pass to the start of the next: along the way that was planned, or over what is in it; where neither is
/// free (both end at the foot of a wall), back beside it with both cut a little short, unless one of them is a loop.
fn joint(
    cutter: &DropCutter,
    way: &Turn,
    last: &mut Pass,
    next: &mut Pass,
    loops: bool,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    let ends = Ends {
        from: last.points.last()?,
        before: &last.points,
        onto: &next.points,
    };
    if let Some(points) = surface_or_bridge(cutter, way, &ends, links, fitting)
        .or_else(|| onward(cutter, ends.before, ends.onto, fitting))
    {
        return Some(points);
    }
    let back = (!loops)
        .then(|| turned_back(cutter, &last.points, &next.points, 0.5 * fitting.probe))
        .flatten();
    let Some(back) = back else {
        // Up or down a wall along it.
        return smooth_link(cutter, way.clone(), &ends, links, fitting);
    };
    last.points.truncate(back.keep);
    last.points.extend(back.points.first());
    next.points = back
        .points
        .last()
        .copied()
        .into_iter()
        .chain(back.rest)
        .collect();
    Some(back.points)
}

/// A way in plan as a proven run on the surface between two places of it; `None` where the ball would fall, or climb something steep
/// for it.
fn surface_link(
    cutter: &DropCutter,
    way: &Turn,
    from: &Point,
    to: &Point,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    // Turns are tight: a chord that strays as far as a pass may would be a corner.
    let fitting = &FitOptions {
        sideways: fitting.sideways.min(1.5 * fitting.gouge),
        ..*fitting
    };
    let mut runs = fit_between(cutter, &way.points(fitting.probe), from, to, fitting);
    if runs.len() != 1 {
        return None;
    }
    let mut points = runs.pop()?;
    // The ends must be the passes' own, not a ball that found another footing at the same place in plan.
    let close = 3.0 * (fitting.gouge + fitting.stock);
    if (points.first()? - from).norm() > close || (points.last()? - to).norm() > close {
        return None;
    }
    let rise = points
        .windows(2)
        .map(|w| (w[1].z - w[0].z).abs())
        .sum::<f64>();
    if rise > 2.0 * (way.length + (from.z - to.z).abs()) + links.clearance {
        return None;
    }
    if points.len() == 1 {
        points.push(*to);
    }
    // Where a wall stands on plain ground, a hair of the wall's own tolerance is much of the ground's.
    let mut hint = Hint::default();
    for p in &mut points {
        if let Some(rest) = cutter.drop_near(p.x, p.y, &mut hint)
            && rest.normal_z() < BY_WALL
        {
            p.z = p.z.max(rest.center.z);
        }
    }
    let last = points.len() - 1;
    points[0] = *from;
    points[last] = *to;
    Some(points)
}

/// A ball whose normal rises by less than this touches a wall: 75 degrees.
const BY_WALL: f64 = 0.26;

/// Where a pass can be entered.
struct Entries {
    closed: bool,
    points: Vec<Point>,
    /// The corners of its box, to pass over what is far.
    low: Point2,
    high: Point2,
}

/// How a pass is entered.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    from: usize,
    backwards: bool,
}

impl Entry {
    fn apply(&self, p: &mut Pass) {
        if p.closed {
            p.points.rotate_left(self.from);
            if self.backwards {
                // The entry stays first.
                p.points[1..].reverse();
            }
        } else if self.backwards {
            p.points.reverse();
        }
    }
}

impl Entries {
    fn of(p: &Pass) -> Entries {
        let points = p.points.clone();
        let mut low = Point2::new(f64::INFINITY, f64::INFINITY);
        let mut high = Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
        for q in &points {
            low = Point2::new(low.x.min(q.x), low.y.min(q.y));
            high = Point2::new(high.x.max(q.x), high.y.max(q.y));
        }
        Entries {
            closed: p.closed,
            points,
            low,
            high,
        }
    }

    fn gap(&self, at: &Point2) -> f64 {
        let dx = (self.low.x - at.x).max(at.x - self.high.x).max(0.0);
        let dy = (self.low.y - at.y).max(at.y - self.high.y).max(0.0);
        dx.hypot(dy)
    }

    /// Poses at which it can be entered within `reach` of a place at height z.
    fn near(&self, at: &Point2, z: f64, reach: &Reach) -> Vec<(Pose, Entry)> {
        let n = self.points.len();
        let mut out = Vec::new();
        if n < 2 {
            return out;
        }
        let mut offer = |i: usize, j: usize, backwards: bool| {
            let here = &self.points[i];
            let d = self.points[j].xy() - here.xy();
            let l = d.norm();
            let far = (here.xy() - at).norm();
            if l > 0.0 && far <= reach.plan && (here.z - z).abs() <= reach.rise + far {
                out.push((
                    Pose {
                        at: here.xy(),
                        heading: d / l,
                    },
                    Entry { from: i, backwards },
                ));
            }
        };
        if self.closed {
            for i in 0..n {
                offer(i, (i + 1) % n, false);
                offer(i, (i + n - 1) % n, true);
            }
        } else {
            offer(0, 1, false);
            offer(n - 1, n - 2, true);
        }
        out
    }
}

/// Where a pass ends and the way it is heading there.
pub fn exit(p: &Pass) -> Option<Pose> {
    let n = p.points.len();
    let (a, b) = if p.closed {
        (p.points.last()?, p.points.first()?)
    } else {
        (p.points.get(n.checked_sub(2)?)?, p.points.last()?)
    };
    Pose::new(b.xy(), (b - a).xy())
}

/// Where a pass begins and the way it is heading there.
pub fn start(p: &Pass) -> Option<Pose> {
    let (a, b) = (p.points.first()?, p.points.get(1)?);
    Pose::new(a.xy(), (b - a).xy())
}

/// The pass (as an index into `alive`) that can be entered soonest from a pose at height z.
fn next(
    from: &Pose,
    z: f64,
    alive: &[usize],
    ends: &[Entries],
    reach: &Reach,
    links: &LinkOptions,
    slope: &mut dyn FnMut(&Point2) -> Vector2,
) -> Option<(usize, Turn, Entry)> {
    let slant = Slant::of(&slope(&from.at));
    let mut best: Option<(f64, usize, Turn, Entry)> = None;
    for (k, &i) in alive.iter().enumerate() {
        if ends[i].gap(&from.at) > reach.plan {
            continue;
        }
        for (to, entry) in ends[i].near(&from.at, z, reach) {
            let straight = (to.at - from.at).norm() / links.feed;
            if best.as_ref().is_some_and(|b| straight >= b.0) {
                continue;
            }
            let (way, time) = quickest_turn(&slant, from, &to, links);
            if best.as_ref().is_none_or(|b| time < b.0) {
                best = Some((time, k, way, entry));
            }
        }
    }
    best.map(|(_, k, way, entry)| (k, way, entry))
}

/// Radii tried for a turn, in shares of the one that the machine takes at full feed.
const RADII: [f64; 4] = [1.0, 0.6, 0.36, TIGHTEST];
/// Tighter turns, in the same shares, would be corners again to the last decimal of a program.
const TIGHTEST: f64 = 0.22;

/// The turn between two poses (in plan, on a slope) that takes least time, s: a wide one is long, a tight one slow.
pub fn quickest_turn(slant: &Slant, from: &Pose, to: &Pose, links: &LinkOptions) -> (Turn, f64) {
    let full = links.feed * links.feed / (TAKES * links.acceleration);
    // Half the gap between two poses side by side is the U-turn's own radius.
    let side = {
        let (from, to) = (slant.pose(from), slant.pose(to));
        let d = to.at - from.at;
        0.5 * (d.x * from.heading.y - d.y * from.heading.x).abs()
    };
    let own = (side > TIGHTEST * full && side < full).then_some(side);
    let mut best = (turn(slant, from, to, full), f64::INFINITY);
    best.1 = turn_time(&best.0, links);
    for r in RADII[1..].iter().map(|r| r * full).chain(own) {
        let t = turn(slant, from, to, r);
        let time = turn_time(&t, links);
        if time < best.1 - 1e-9 {
            best = (t, time);
        }
    }
    best
}

/// Controllers blend the chords of an arc within their junction tolerance, which lets them take it faster than its centripetal
/// acceleration alone would: by this factor on the acceleration.
const TAKES: f64 = 1.5;

fn turn_time(t: &Turn, links: &LinkOptions) -> f64 {
    let v = links.feed;
    let slow = (TAKES * links.acceleration * t.tightest()).sqrt().min(v);
    t.curved / slow + (t.length - t.curved) / v + (v - slow) * (v - slow) / (links.acceleration * v)
}
