//! Runs at constant height, moved off their wall and proven, then joined from height to height.
//!
//! ```text
//!   closed, sloping     once round, then down to the next loop along a ramp that leaves the one and meets the other as a tangent
//!   closed, upright     down along a helix
//!   open                back along the wall: a half circle on it, from the end of one run to the start of the next
//! ```

use super::WallOptions;
use super::cross::{Cross, between, split};
use crate::geom::{Point, Point2, Vector2, nearest_on_segment};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::fit::{FitOptions, smooth};
use crate::toolpath::link::bridge::{is_free as free, turned_back};

/// Rounds in which the heights along a wall's edge are evened out, and those in which its places in plan are.
const EVENED: (usize, usize) = (40, 8);
/// A place on a wall is looked for this far to either side, mm.
const ASIDE: f64 = 0.2;

/// A run along a wall, up and down, through about these centres of the ball (each with the way off the wall). The steeper the wall, the
/// less a place in plan tells the height, so heights are evened out first, and then met exactly. Proven like a run at constant height.
pub(in crate::toolpath) fn laid_on_wall(
    cutter: &DropCutter,
    at: &[(Point, Vector2)],
    closed: bool,
    o: &WallOptions,
    fitting: &FitOptions,
) -> Vec<(Vec<Point>, bool)> {
    let mut plan: Vec<Point2> = at.iter().map(|p| p.0.xy()).collect();
    let mut height: Vec<Point2> = at.iter().map(|p| Point2::new(p.0.z, 0.0)).collect();
    smooth(&mut height, closed, EVENED.0);
    smooth(&mut plan, closed, EVENED.1);
    let mut hint = Hint::default();
    let found: Vec<Option<Cross>> = plan
        .iter()
        .zip(&height)
        .zip(at)
        .map(|((q, z), (_, out))| {
            let (low, high) = (q + out * ASIDE, q - out * ASIDE);
            let (at, ..) = between(cutter, &low, &high, z.x, &mut hint)?;
            Some(Cross {
                at,
                out: *out,
                z: z.x,
                leap: false,
            })
        })
        .collect();
    split(&found, closed)
        .into_iter()
        .flat_map(|(run, closed)| laid_at_height(cutter, &run, closed, o, fitting))
        .collect()
}

/// A run moved off its wall and thinned out to what the tolerance needs; proven free along every chord, split where it is not.
pub(super) fn laid_at_height(
    cutter: &DropCutter,
    run: &[Cross],
    closed: bool,
    o: &WallOptions,
    fitting: &FitOptions,
) -> Vec<(Vec<Point>, bool)> {
    let at: Vec<(Point2, Vector2)> = run.iter().map(|c| (c.at, c.out)).collect();
    let mut dense: Vec<Point> = moved_out(&at, closed, o.off_wall)
        .into_iter()
        .zip(run)
        .map(|(q, c)| Point::new(q.x, q.y, c.z))
        .collect();
    dense.dedup_by(|a, b| (*a - *b).norm() < 1e-4);
    if closed && let Some(first) = dense.first().copied() {
        dense.push(first);
    }
    let length: f64 = dense.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    if length < 0.5 * o.stepover || dense.len() < 2 {
        return Vec::new();
    }
    let mut hint = Hint::default();
    let mut runs: Vec<Vec<Point>> = vec![vec![dense[0]]];
    let mut i = 0;
    while i + 1 < dense.len() {
        let mut j = i + 1;
        while j + 1 < dense.len() && holds(&dense[i..=j + 1], 0.5 * o.off_wall, fitting.longest) {
            j += 1;
        }
        while j > i + 1 && !free(cutter, &dense[i], &dense[j], fitting.probe, &mut hint) {
            j = i + (j - i) / 2;
        }
        if !free(cutter, &dense[i], &dense[j], fitting.probe, &mut hint) {
            runs.push(Vec::new());
        }
        if let Some(last) = runs.last_mut() {
            last.push(dense[j]);
        }
        i = j;
    }
    let whole = closed && runs.len() == 1 && runs[0].len() > 3;
    if whole {
        runs[0].pop();
    }
    runs.retain(|r| r.len() > 1);
    runs.into_iter().map(|r| (r, whole)).collect()
}

/// Each point moved away from the wall, corners to where the two lines moved out meet.
pub(in crate::toolpath) fn moved_out(
    at: &[(Point2, Vector2)],
    closed: bool,
    off: f64,
) -> Vec<Point2> {
    let n = at.len();
    // Across each piece from one place to the next, away from the wall.
    let across = |k: usize| -> Option<Vector2> {
        let l = (k + 1) % n;
        let d = at[l].0 - at[k].0;
        let length = d.norm();
        if length <= 0.0 {
            return None;
        }
        let side = Vector2::new(-d.y, d.x) / length;
        let out = at[k].1 + at[l].1;
        Some(if side.dot(&out) < 0.0 { -side } else { side })
    };
    (0..n)
        .map(|k| {
            let before = (closed || k > 0).then(|| across((k + n - 1) % n)).flatten();
            let after = (closed || k + 1 < n).then(|| across(k)).flatten();
            let way = match (before, after) {
                (Some(u), Some(v)) => (u + v) / (1.0 + u.dot(&v)).max(0.3),
                (Some(u), None) | (None, Some(u)) => u,
                (None, None) => at[k].1,
            };
            at[k].0 + way * off
        })
        .collect()
}

/// Do the points between stay this near to the chord?
fn holds(points: &[Point], tolerance: f64, longest: f64) -> bool {
    let (a, b) = (points[0], points[points.len() - 1]);
    (b - a).norm_squared() <= longest * longest
        && points[1..points.len() - 1]
            .iter()
            .all(|p| (nearest_on_segment(p, &a, &b) - p).norm() <= tolerance)
}

/// The places between the end of one run and the start of the next, a step apart; `None` when the ball cannot go there straight. Over a
/// bulging wall it goes in four pieces, each end lifted onto the wall.
fn step_down(
    cutter: &DropCutter,
    from: &Point,
    to: &Point,
    fitting: &FitOptions,
    hint: &mut Hint,
) -> Option<Vec<Point>> {
    let probe = 0.5 * fitting.probe;
    if free(cutter, from, to, probe, hint) {
        return Some(Vec::new());
    }
    let mut way = Vec::with_capacity(3);
    for k in 1..4 {
        let mut q = from + (to - from) * (f64::from(k) / 4.0);
        let rest = cutter.drop_near(q.x, q.y, hint)?.center.z;
        // A wall bulges by micrometres; anything more is in the way.
        if rest - q.z > 0.25 * (to - from).norm() {
            return None;
        }
        q.z = q.z.max(rest);
        way.push(q);
    }
    let mut last = *from;
    for q in way.iter().chain([to]) {
        if !free(cutter, &last, q, probe, hint) {
            return None;
        }
        last = *q;
    }
    Some(way)
}

/// How runs are joined from height to height, mm.
pub(super) struct Joining {
    /// Distance of passes along an upright wall.
    pub stepover: f64,
    /// A run this far straight below another may be reached along a helix.
    pub fall: f64,
    /// The first level is of rims, each at its own height.
    pub rims: bool,
}

/// One wall on its way down.
struct Stack {
    points: Vec<Point>,
    /// Level of the last run.
    level: usize,
    /// Points at its end that go once round at the last height: not needed when a helix goes on down.
    flat: usize,
    /// Where its last run begins, and whether that is closed.
    last: (usize, bool),
}

/// The same run, but for its height, which falls evenly from `from` to its own.
fn helix(from: f64, run: &[Point]) -> Vec<Point> {
    let total: f64 = run.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let mut along = 0.0;
    let mut out = Vec::with_capacity(run.len());
    for (k, p) in run.iter().enumerate() {
        if k > 0 {
            along += (p - run[k - 1]).norm();
        }
        let share = if total > 0.0 { along / total } else { 1.0 };
        out.push(Point::new(p.x, p.y, from + (p.z - from) * share));
    }
    out
}

/// Joins the runs of each level to those of the level above where the way down is free.
pub(super) fn stacked(
    cutter: &DropCutter,
    levels: Vec<Vec<(Vec<Point>, bool)>>,
    how: &Joining,
    fitting: &FitOptions,
) -> Vec<Vec<Point>> {
    let mut stacks: Vec<Stack> = Vec::new();
    let mut hint = Hint::default();
    for (level, runs) in levels.into_iter().enumerate() {
        for (mut run, closed) in runs {
            let best = nearest_end(&stacks, &run, closed, level, how);
            if let Some((_, s, k)) = best {
                enter(&mut run, closed, k);
                if joined(
                    cutter,
                    &mut stacks[s],
                    &run,
                    closed,
                    how,
                    fitting,
                    &mut hint,
                ) {
                    stacks[s].level = level;
                    continue;
                }
            }
            if closed {
                run.push(run[0]);
            }
            stacks.push(Stack {
                points: run,
                level,
                flat: 0,
                last: (0, closed),
            });
        }
    }
    stacks.into_iter().map(|s| s.points).collect()
}

/// The stack whose end is nearest to a place at which a run of this level can be entered: how far, which, and the place.
fn nearest_end(
    stacks: &[Stack],
    run: &[Point],
    closed: bool,
    level: usize,
    how: &Joining,
) -> Option<(f64, usize, usize)> {
    let n = run.len();
    let mut best: Option<(f64, usize, usize)> = None;
    for (s, stack) in stacks.iter().enumerate() {
        let Some(end) = stack.points.last() else {
            continue;
        };
        // The first level may be a rim of any height.
        if stack.level + 1 < level && !(how.rims && stack.level == 0) || stack.level == level {
            continue;
        }
        let entries: &mut dyn Iterator<Item = usize> = if closed {
            &mut (0..n)
        } else {
            &mut [0, n - 1].into_iter()
        };
        for k in entries {
            let d = (run[k] - end).norm();
            let below = closed
                && (run[k].xy() - end.xy()).norm() < 0.5 * how.stepover
                && end.z - run[k].z < how.fall;
            if (d < NEAR * how.stepover || below) && best.is_none_or(|b| d < b.0) {
                best = Some((d, s, k));
            }
        }
    }
    best
}

/// Ends further apart than this many stepovers are not joined on the wall.
const NEAR: f64 = 1.6;

/// Turns a run so that it begins at its point `k`.
fn enter(run: &mut [Point], closed: bool, k: usize) {
    if closed {
        run.rotate_left(k);
    } else if k > 0 {
        run.reverse();
    }
}

/// Goes on from the end of a stack down to a run that is entered at its first point; false when no way is free.
fn joined(
    cutter: &DropCutter,
    stack: &mut Stack,
    run: &[Point],
    closed: bool,
    how: &Joining,
    fitting: &FitOptions,
    hint: &mut Hint,
) -> bool {
    let (Some(end), Some(first)) = (stack.points.last().copied(), run.first().copied()) else {
        return false;
    };
    let mut round = run.to_vec();
    if closed {
        round.push(first);
    }
    if closed && stack.last.1 && how.rims {
        // Down an upright wall along a helix, and once round at its foot. Where the ball is free at a height it is free above it.
        let keep = stack.points.len() - stack.flat;
        stack.points.truncate(keep);
        if let Some(from) = stack.points.last().copied() {
            stack.points.extend(helix(from.z, &round));
        }
        stack.flat = round.len() - 1;
        stack.last = (stack.points.len() - 1, true);
        stack.points.extend(round.drain(1..));
        return true;
    }
    let probe = 0.5 * fitting.probe;
    if closed && stack.last.1 {
        let above = &stack.points[stack.last.0..];
        if let Some(way) = ramp(cutter, above, &round, how.stepover, probe, hint) {
            stack.points.extend(way.points);
            stack.last = (stack.points.len() - 1, true);
            stack.points.extend(way.rest);
            stack.flat = 0;
            return true;
        }
    }
    if !closed
        && !stack.last.1
        && let Some(back) = turned_back(cutter, &stack.points, &round, probe)
    {
        stack.points.truncate(back.keep);
        stack.points.extend(back.points);
        stack.last = (stack.points.len() - 1, false);
        stack.points.extend(back.rest);
        stack.flat = 0;
        return true;
    }
    if let Some(way) = step_down(cutter, &end, &first, fitting, hint) {
        stack.points.extend(way);
        stack.last = (stack.points.len(), closed);
        stack.points.extend(round);
        stack.flat = 0;
        return true;
    }
    false
}

/// A way down between two loops.
struct Ramp {
    /// From behind the end of the upper loop onto the lower one.
    points: Vec<Point>,
    /// Once round the lower loop from there.
    rest: Vec<Point>,
}

/// A ramp is this many stepovers long, and no longer than this share of the shorter loop.
const RAMP: (f64, f64) = (8.0, 0.5);
/// Places along a ramp.
const RAMP_PLACES: usize = 40;

/// On along the upper loop, which ends where it began, and over to the lower one, whose first point is the nearest to that place.
fn ramp(
    cutter: &DropCutter,
    above: &[Point],
    below: &[Point],
    stepover: f64,
    probe: f64,
    hint: &mut Hint,
) -> Option<Ramp> {
    let mut below = below.to_vec();
    if heading(above)?.dot(&heading(&below)?) < 0.0 {
        below.reverse();
    }
    let length = |run: &[Point]| run.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>();
    let shorter = length(above).min(length(&below));
    let long = (RAMP.0 * stepover).min(RAMP.1 * shorter);
    // By the share of each loop's length, so that both go round corners at once.
    let (a, b) = (length(above), length(&below));
    let mut last = *above.first()?;
    let mut points = Vec::with_capacity(RAMP_PLACES);
    for k in 1..=RAMP_PLACES {
        let t = k as f64 / RAMP_PLACES as f64;
        let w = t * t * (3.0 - 2.0 * t);
        let (p, q) = (
            at_length(above, t * long * a / shorter)?,
            at_length(&below, t * long * b / shorter)?,
        );
        let mut c = p + (q - p) * w;
        if let Some(rest) = cutter.drop_near(c.x, c.y, hint) {
            c.z = c.z.max(rest.center.z);
        }
        if !free(cutter, &last, &c, probe, hint) {
            return None;
        }
        points.push(c);
        last = c;
    }
    // Once round from where it arrived.
    let rest = begun_at(&below, long * b / shorter)?;
    Some(Ramp { points, rest })
}

/// Where a run that ends where it begins is after `s` mm, and on all round, back to there; without the first point.
fn begun_at(round: &[Point], s: f64) -> Option<Vec<Point>> {
    let mut along = 0.0;
    let n = round.len();
    let place = at_length(round, s)?;
    for k in 0..n.checked_sub(1)? {
        let l = (round[k + 1] - round[k]).norm();
        if along + l >= s {
            let mut out: Vec<Point> = round[k + 1..].to_vec();
            out.extend(&round[1..=k]);
            out.push(place);
            out.dedup_by(|a, b| (*a - *b).norm() < 1e-4);
            if out.first().is_some_and(|p| (p - place).norm() < 1e-4) {
                out.remove(0);
            }
            return Some(out);
        }
        along += l;
    }
    None
}

/// The place `s` mm along a run.
fn at_length(run: &[Point], s: f64) -> Option<Point> {
    let mut along = 0.0;
    for w in run.windows(2) {
        let l = (w[1] - w[0]).norm();
        if along + l >= s && l > 0.0 {
            return Some(w[0] + (w[1] - w[0]) * ((s - along) / l).clamp(0.0, 1.0));
        }
        along += l;
    }
    run.last().copied()
}

/// The way a run begins in plan, unit length.
fn heading(run: &[Point]) -> Option<Vector2> {
    let first = run.first()?;
    run.iter()
        .map(|p| p.xy() - first.xy())
        .find(|d| d.norm() > 0.02)
        .map(|d| d / d.norm())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn square(side: f64, z: f64) -> Vec<Point> {
        [
            [0.0, 0.0],
            [side, 0.0],
            [side, side],
            [0.0, side],
            [0.0, 0.0],
        ]
        .map(|[x, y]| Point::new(x, y, z))
        .to_vec()
    }

    #[test]
    fn a_run_is_begun_anywhere_and_goes_all_round() {
        let round = square(4.0, 1.0);
        let out = begun_at(&round, 6.0).unwrap();
        let place = Point::new(4.0, 2.0, 1.0);
        assert_eq!(out.last(), Some(&place));
        let length: f64 = std::iter::once(place)
            .chain(out.iter().copied())
            .collect::<Vec<_>>()
            .windows(2)
            .map(|w| (w[1] - w[0]).norm())
            .sum();
        assert!((length - 16.0).abs() < 1e-9);
    }
}
