//! Bridges: links at feed that keep off the surface where it is in the way, no higher than they must.
//!
//! ```text
//!                .-------.            the ball's centre over the way in plan: off the end of one pass along an arc, up a straight
//!             .'           '.         that clears what stands between by a hair, over it along an arc as wide, down the same way,
//!     ____--'    |part|      '--___   and onto the start of the next
//! ```
//!
//! A bridge that has nothing in its way is as straight as the way in plan, also where the ball would fall past the part. Nothing but
//! the allowance is cut on it: it is nowhere below the surface that is wanted, proven by dropping the ball along each of its chords.
//!
//! Crosses the border: a way in plan ([`Turn`]) and a part made ready for a ball in, places of the ball's centre out; work
//! coordinates, mm.

use super::LinkOptions;
use super::chain::{Ends, smooth_link};
use super::turn::{Slant, Turn, turn};
use crate::geom::{Point, Point2, Vector};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::fit::FitOptions;

/// An end of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// Place of the ball's centre, mm.
    pub at: Point,
    /// The way of the link there, unit length.
    pub heading: Vector,
}

impl End {
    /// Where a run ends.
    pub fn after(run: &[Point]) -> Option<End> {
        let [.., a, b] = run else { return None };
        End::of(*b, b - a)
    }

    /// Where a run begins.
    pub fn before(run: &[Point]) -> Option<End> {
        let [a, b, ..] = run else { return None };
        End::of(*a, b - a)
    }

    fn of(at: Point, way: Vector) -> Option<End> {
        let heading = way.try_normalize(1e-9)?;
        Some(End { at, heading })
    }

    /// How much it rises for each millimetre in plan.
    fn slope(&self) -> f64 {
        self.heading.z / self.heading.xy().norm().max(1e-9)
    }
}

/// Radius of the arcs up, over and down, mm.
const ARC: f64 = 1.0;
/// Steepest way up and down, as a slope: steeper is a plunge.
const STEEPEST: f64 = 1.4;
/// Room kept over what is in the way, mm.
const ROOM: f64 = 0.02;
/// Places looked at, mm apart.
const GAP: f64 = 0.1;
/// Chords are proven at places this far apart, mm.
const PROBE: f64 = 0.025;
/// Deepest that a chord may run below the surface along its normal, mm.
const TOUCH: f64 = 0.001;
/// Rounds of lifting what the proof found too low.
const ROUNDS: usize = 4;
/// Longest bridge: mm, or ball radii where that is more.
const LONGEST: (f64, f64) = (60.0, 20.0);
/// A link along the surface this much longer than its way in plan is compared with a bridge.
const DETOUR: f64 = 1.25;

/// The shorter of a link along the surface and a bridge, as proven runs of places; `None` where neither is free.
pub fn surface_or_bridge(
    cutter: &DropCutter,
    way: &Turn,
    ends: &Ends,
    links: &LinkOptions,
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    let (from, to) = (&End::after(ends.before)?, &End::before(ends.onto)?);
    let direct = way.length.hypot(to.at.z - from.at.z);
    let along = smooth_link(cutter, way.clone(), ends, links, fitting).filter(|run| !climbs(run));
    if along.as_ref().is_some_and(|a| length(a) <= DETOUR * direct) {
        return along;
    }
    let mut best = along;
    let mut offer = |other: Option<Vec<Point>>| {
        if let Some(o) = other
            && best.as_ref().is_none_or(|b| length(&o) < length(b))
        {
            best = Some(o);
        }
    };
    offer(half_circle(cutter, from, to, 0.5 * fitting.probe));
    offer(bridge(cutter, &way.points(GAP), from, to));
    if best.is_some() {
        return best;
    }
    // A longer way in plan is a gentler way up.
    let (start, end) = way.ends();
    WIDER.iter().find_map(|r| {
        let wide = turn(&Slant::default(), &start, &end, *r);
        bridge(cutter, &wide.points(GAP), from, to)
    })
}

fn length(run: &[Point]) -> f64 {
    run.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
}

/// A link steeper than this goes up a wall, which is as steep by default: its way in plan for each millimetre of height.
const WALL: f64 = 0.25;

/// Does a run go straight up or down somewhere?
fn climbs(run: &[Point]) -> bool {
    run.windows(2).any(|w| {
        let d = w[1] - w[0];
        d.z.abs() > 0.1 && d.xy().norm() < WALL * d.z.abs()
    })
}

/// Radii of the turns on wider ways, mm.
const WIDER: [f64; 3] = [1.0, 1.8, 3.0];

/// Ends further apart than this many millimetres are no neighbours.
const BESIDE: f64 = 3.0;
/// Pieces of a half circle: 15 degrees each.
const PIECES: usize = 12;

/// Back beside the way it came: a half circle in the plane of the two ways, which may be as steep as a wall, lifted onto the surface where
/// that bends. `None` where the ends do not lie side by side, or the ball is not free all along it.
pub fn half_circle(cutter: &DropCutter, from: &End, to: &End, probe: f64) -> Option<Vec<Point>> {
    let gap = to.at - from.at;
    if gap.norm() > BESIDE || from.heading.dot(&to.heading) > -0.7 {
        return None;
    }
    let onward = (from.heading - to.heading).try_normalize(1e-9)?;
    // The one that is behind goes straight on first, until they are side by side.
    let ahead = gap.dot(&onward);
    let (a, b) = (
        from.at + onward * ahead.max(0.0),
        to.at + onward * (-ahead).max(0.0),
    );
    let radius = 0.5 * (b - a).norm();
    if radius < 1e-3 {
        return None;
    }
    let mut wanted: Vec<Point> = Vec::with_capacity(PIECES + 20);
    let straight = |from: &Point, to: &Point, out: &mut Vec<Point>| {
        let n = ((to - from).norm() / GAP).ceil() as usize;
        out.extend((1..=n).map(|k| from + (to - from) * (k as f64 / n as f64)));
    };
    straight(&from.at, &a, &mut wanted);
    for k in 1..PIECES {
        let (sin, cos) = (std::f64::consts::PI * k as f64 / PIECES as f64).sin_cos();
        wanted.push(a + (b - a) * (0.5 * (1.0 - cos)) + onward * (radius * sin));
    }
    wanted.push(b);
    straight(&b, &to.at, &mut wanted);
    let last = wanted.len() - 1;
    wanted[last] = to.at;
    let mut hint = Hint::default();
    let mut out = vec![from.at];
    for (k, mut c) in wanted.into_iter().enumerate() {
        if k < last
            && let Some(rest) = cutter.drop_near(c.x, c.y, &mut hint)
        {
            // The wall bends by so much on the way; anything more is another.
            if rest.center.z - c.z > 0.5 * radius {
                return None;
            }
            c.z = c.z.max(rest.center.z);
        }
        let before = out[out.len() - 1];
        if !is_free(cutter, &before, &c, probe, &mut hint) {
            return None;
        }
        out.push(c);
    }
    Some(out)
}

/// A way back beside the end of a run, with what is left of both.
pub struct Back {
    /// Points of the first run that stay.
    pub keep: usize,
    /// From where that is left, round, to where the second is entered.
    pub points: Vec<Point>,
    /// What is left of the second run, behind that place.
    pub rest: Vec<Point>,
}

/// From the end of one run to the start of the next, which goes back beside it: a half circle beyond their ends where there is room, else
/// with both ends cut short for it.
pub fn turned_back(
    cutter: &DropCutter,
    first: &[Point],
    second: &[Point],
    probe: f64,
) -> Option<Back> {
    let back: Vec<Point> = first.iter().rev().copied().collect();
    let radius = 0.5 * (back.first()? - second.first()?).norm();
    if radius > 0.5 * BESIDE {
        return None;
    }
    [0.0, 0.5, 1.0, 1.6].iter().find_map(|short| {
        let (rest, after) = (
            shortened(&back, short * radius),
            shortened(second, short * radius),
        );
        let mut leaves = End::before(&rest)?;
        leaves.heading = -leaves.heading;
        let points = half_circle(cutter, &leaves, &End::before(&after)?, probe)?;
        Some(Back {
            // The place where the first was cut short stands first among the points.
            keep: rest.len() - 1,
            points,
            rest: after[1..].to_vec(),
        })
    })
}

/// A run without its first `s` mm: it begins at the place where they end.
fn shortened(run: &[Point], s: f64) -> Vec<Point> {
    let mut along = 0.0;
    for (k, w) in run.windows(2).enumerate() {
        let l = (w[1] - w[0]).norm();
        if along + l > s {
            let mut out = vec![w[0] + (w[1] - w[0]) * ((s - along) / l).max(0.0)];
            out.extend(&run[k + 1..]);
            return out;
        }
        along += l;
    }
    Vec::new()
}

/// Does the ball enter the part nowhere along a chord? Asked `probe` mm apart.
pub fn is_free(cutter: &DropCutter, a: &Point, b: &Point, probe: f64, hint: &mut Hint) -> bool {
    let n = ((b - a).norm() / probe).ceil().max(1.0) as usize;
    (0..=n).all(|k| {
        let q = a + (b - a) * (k as f64 / n as f64);
        cutter.is_clear(&q, TOUCH, hint)
    })
}

/// A bridge over a way in plan; `None` where it would have to be steeper than a ball likes.
pub fn bridge(cutter: &DropCutter, way: &[Point2], from: &End, to: &End) -> Option<Vec<Point>> {
    let mut plan: Vec<Point2> = Vec::with_capacity(way.len());
    for q in way {
        if plan.last().is_none_or(|l: &Point2| (q - l).norm() > 1e-6) {
            plan.push(*q);
        }
    }
    let n = plan.len();
    if n < 2 {
        return None;
    }
    plan[0] = from.at.xy();
    plan[n - 1] = to.at.xy();
    let mut along = vec![0.0];
    for w in plan.windows(2) {
        along.push(along[along.len() - 1] + (w[1] - w[0]).norm());
    }
    let long = along[n - 1];
    if long > LONGEST.0.max(LONGEST.1 * cutter.radius())
        || from.slope().abs() > STEEPEST
        || to.slope().abs() > STEEPEST
    {
        return None;
    }
    let mut hint = Hint::default();
    let rest = |q: &Point2, hint: &mut Hint| {
        cutter
            .drop_near(q.x, q.y, hint)
            .map_or(f64::NEG_INFINITY, |c| c.center.z)
    };
    // What must be cleared at each place.
    let mut over: Vec<f64> = plan
        .iter()
        .zip(&along)
        .map(|(q, s)| {
            let end = s.min(long - s);
            rest(q, &mut hint) + ROOM.min(0.25 * end * end / ARC)
        })
        .collect();
    for _ in 0..ROUNDS {
        let z = profile(&along, &over, from, to)?;
        let run: Vec<Point> = plan
            .iter()
            .zip(&z)
            .map(|(q, z)| Point::new(q.x, q.y, *z))
            .collect();
        if !lift(cutter, &run, &mut over, &mut hint) {
            return Some(thinned(&run));
        }
    }
    None
}

/// Raises what must be cleared beside places where a chord runs below the surface; false when none does.
fn lift(cutter: &DropCutter, run: &[Point], over: &mut [f64], hint: &mut Hint) -> bool {
    let mut lifted = false;
    for (k, w) in run.windows(2).enumerate() {
        let pieces = ((w[1] - w[0]).norm() / PROBE).ceil().max(1.0) as usize;
        for i in 0..=pieces {
            let q = w[0] + (w[1] - w[0]) * (i as f64 / pieces as f64);
            if cutter.is_clear(&q, TOUCH, hint) {
                continue;
            }
            if let Some(c) = cutter.drop_near(q.x, q.y, hint) {
                lifted = true;
                over[k] = over[k].max(c.center.z + ROOM);
                over[k + 1] = over[k + 1].max(c.center.z + ROOM);
            }
        }
    }
    lifted
}

/// Heights along the way: arcs at both ends, between them the string drawn tight over what must be cleared, made round.
fn profile(along: &[f64], over: &[f64], from: &End, to: &End) -> Option<Vec<f64>> {
    let n = along.len();
    let long = along[n - 1];
    let leaving = |s: f64| from.at.z + from.slope() * s + 0.5 * s * s / ARC;
    let arriving = |s: f64| to.at.z - to.slope() * (long - s) + 0.5 * (long - s).powi(2) / ARC;
    // Round tops: a disc rolled over what is there, but no higher than the arcs at the ends allow.
    let goal: Vec<f64> = (0..n)
        .map(|i| {
            let mut z = over[i];
            let mut disc = |j: usize| {
                let d = along[j] - along[i];
                z = z.max(over[j] - 0.5 * d * d / ARC);
            };
            (0..i)
                .rev()
                .take_while(|&j| along[i] - along[j] < 2.0 * ARC)
                .for_each(&mut disc);
            (i + 1..n)
                .take_while(|&j| along[j] - along[i] < 2.0 * ARC)
                .for_each(&mut disc);
            z.min(leaving(along[i]).min(arriving(along[i])))
                .max(over[i])
        })
        .collect();
    // How far the arc goes until a straight from it clears everything up to the other end.
    let (a, b) = (
        tangent(along, &goal, &leaving, from.slope(), arriving(long))?,
        {
            let back: Vec<f64> = along.iter().rev().map(|s| long - s).collect();
            let goal: Vec<f64> = goal.iter().rev().copied().collect();
            n - 1
                - tangent(
                    &back,
                    &goal,
                    &|s| arriving(long - s),
                    -to.slope(),
                    leaving(0.0),
                )?
        },
    );
    if a >= b {
        return None;
    }
    let mut z: Vec<f64> = (0..n)
        .map(|i| {
            if i <= a {
                leaving(along[i])
            } else if i >= b {
                arriving(along[i])
            } else {
                goal[i]
            }
        })
        .collect();
    string(along, &mut z, a, b);
    let steep =
        (1..n).any(|i| (z[i] - z[i - 1]).abs() > STEEPEST * (along[i] - along[i - 1]) + 1e-9);
    (!steep).then_some(z)
}

/// The first place of an arc from which a straight on along it passes over everything there is to clear; `None` when the arc itself
/// does not clear it, or would have to be too steep.
fn tangent(
    along: &[f64],
    goal: &[f64],
    arc: &dyn Fn(f64) -> f64,
    slope: f64,
    end: f64,
) -> Option<usize> {
    let n = along.len();
    for a in 0..n - 1 {
        let (s, z) = (along[a], arc(along[a]));
        if a > 0 && z < goal[a] - 1e-9 {
            return None;
        }
        let own = slope + s / ARC;
        if own > STEEPEST + 0.1 {
            return None;
        }
        let needed = (a + 1..n)
            .map(|i| {
                let top = if i == n - 1 { end } else { goal[i] };
                (top - z) / (along[i] - s)
            })
            .fold(f64::NEG_INFINITY, f64::max);
        // Along the chord to the next place of the arc.
        if needed <= own + 0.5 * (along[a + 1] - s) / ARC + 1e-9 {
            return Some(a);
        }
    }
    None
}

/// Between places a and b: the least concave line over what is there.
fn string(along: &[f64], z: &mut [f64], a: usize, b: usize) {
    let mut hull: Vec<usize> = vec![a];
    for i in a + 1..=b {
        while let [.., p, q] = hull[..] {
            let cross =
                (along[q] - along[p]) * (z[i] - z[p]) - (along[i] - along[p]) * (z[q] - z[p]);
            if cross >= 0.0 {
                hull.pop();
            } else {
                break;
            }
        }
        hull.push(i);
    }
    for w in hull.windows(2) {
        let (p, q) = (w[0], w[1]);
        for i in p + 1..q {
            z[i] = z[p] + (z[q] - z[p]) * (along[i] - along[p]) / (along[q] - along[p]);
        }
    }
}

/// Without the places that lie on a straight between others.
fn thinned(run: &[Point]) -> Vec<Point> {
    const STRAIGHT: f64 = 2e-4;
    const LONG: f64 = 2.0;
    let mut out: Vec<Point> = run.first().copied().into_iter().collect();
    let mut i = 0;
    while i + 1 < run.len() {
        let mut j = i + 1;
        while j + 1 < run.len() {
            let (a, e) = (run[i], run[j + 1] - run[i]);
            let l = e.norm();
            let straight = l < LONG
                && run[i + 1..=j]
                    .iter()
                    .all(|p| (p - a).cross(&e).norm() <= STRAIGHT * l);
            if !straight {
                break;
            }
            j += 1;
        }
        out.push(run[j]);
        i = j;
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;

    fn quad(p: [[f64; 3]; 4]) -> [[Point; 3]; 2] {
        let [a, b, c, d] = p.map(|v| Point::new(v[0], v[1], v[2]));
        [[a, b, c], [a, c, d]]
    }

    /// A plain with a rib of this height across the way.
    fn rib(height: f64) -> DropCutter {
        let mut triangles = quad([
            [-20.0, -20.0, 0.0],
            [20.0, -20.0, 0.0],
            [20.0, 20.0, 0.0],
            [-20.0, 20.0, 0.0],
        ])
        .to_vec();
        triangles.extend(quad([
            [-0.5, -20.0, height],
            [0.5, -20.0, height],
            [0.5, 20.0, height],
            [-0.5, 20.0, height],
        ]));
        DropCutter::new(&Mesh { triangles }, 3.0)
    }

    fn straight(from: f64, to: f64) -> Vec<Point2> {
        let n = 200;
        (0..=n)
            .map(|k| Point2::new(from + (to - from) * f64::from(k) / f64::from(n), 0.0))
            .collect()
    }

    fn end(x: f64, z: f64) -> End {
        End {
            at: Point::new(x, 0.0, z),
            heading: Vector::x(),
        }
    }

    /// Over a rib, never through it, no higher than it must, without a corner.
    #[test]
    fn over_a_rib() {
        let cutter = rib(1.0);
        let run = bridge(
            &cutter,
            &straight(-9.0, 9.0),
            &end(-9.0, 3.0),
            &end(9.0, 3.0),
        )
        .unwrap();
        let top = run.iter().map(|p| p.z).fold(0.0, f64::max);
        assert!((4.0..4.1).contains(&top), "{top}");
        for w in run.windows(2) {
            for k in 0..=50 {
                let q = w[0] + (w[1] - w[0]) * (f64::from(k) / 50.0);
                let c = cutter.drop(q.x, q.y).unwrap();
                assert!((c.center.z - q.z) * c.normal_z() < 0.0015, "{q}");
            }
        }
        for w in run.windows(3) {
            let turn = (w[1] - w[0]).angle(&(w[2] - w[1])).to_degrees();
            assert!(turn < 15.0, "{turn} at {}", w[1]);
        }
    }

    /// With nothing in the way it is straight, also beyond the part.
    #[test]
    fn straight_over_nothing() {
        let cutter = rib(1.0);
        let way: Vec<Point2> = (0..=60)
            .map(|k| Point2::new(10.0 + 0.2 * f64::from(k), 22.9))
            .collect();
        let at = |x: f64| End {
            at: Point::new(x, 22.9, 3.0),
            heading: Vector::x(),
        };
        let run = bridge(&cutter, &way, &at(10.0), &at(22.0)).unwrap();
        assert!(run.iter().all(|p| (p.z - 3.0).abs() < 0.03), "{run:?}");
    }

    /// Beside a wall's foot, back the way it came: half a circle on the plain, of the gap's own radius.
    #[test]
    fn back_beside_the_way() {
        let cutter = rib(1.0);
        let at = |y: f64, way: f64| End {
            at: Point::new(-9.0, y, 3.0),
            heading: Vector::new(0.0, way, 0.0),
        };
        let (from, mut to) = (at(0.0, 1.0), at(0.0, -1.0));
        to.at.x += 0.7;
        let run = half_circle(&cutter, &from, &to, 0.02).unwrap();
        let length: f64 = run.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        assert!((length / (0.35 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        // The end that lies further back is reached straight.
        to.at.y -= 1.0;
        let run = half_circle(&cutter, &from, &to, 0.02).unwrap();
        let length: f64 = run.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        assert!((length / (1.0 + 0.35 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        assert_eq!(half_circle(&cutter, &from, &at(1.0, 1.0), 0.02), None);
    }

    #[test]
    fn a_shortened_run_begins_further_on() {
        let run =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[x, y]| Point::new(x, y, 0.0));
        assert_eq!(
            shortened(&run, 5.0),
            [Point::new(4.0, 1.0, 0.0), run[2], run[3]]
        );
        assert!(shortened(&run, 13.0).is_empty());
    }

    /// A wall too high for so short a way is not climbed.
    #[test]
    fn no_way_up_a_high_wall() {
        let cutter = rib(9.0);
        assert_eq!(
            bridge(
                &cutter,
                &straight(-4.0, 4.0),
                &end(-4.0, 3.0),
                &end(4.0, 3.0)
            ),
            None
        );
    }
}
