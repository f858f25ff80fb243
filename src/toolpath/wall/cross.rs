//! Where a height is crossed along a wall: on the edges of the grid, closed in on by bisection.

use super::steep::bridge;
use super::{LEAP, ROLLING, Steep, TooDeep, Uprights, rolls};
use crate::field::LevelCurve;
use crate::geom::{Point, Point2, Vector2};
use crate::reach::{Contact, DropCutter, Hint, NodeKind, ToolCentreGrid};

/// A height at which walls are cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Of the ball's centre, mm.
    pub z: f64,
    /// For upright walls, by the flutes; else for those that cusps stand on.
    pub uprights: bool,
    /// The next lower height of upright walls; -inf below the lowest.
    pub next: f64,
    /// Height of upright wall that stays standing above this level where the flutes do not reach down to it, mm.
    pub strip: f64,
}

/// A place where a height is crossed: on the low side of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cross {
    pub at: Point2,
    /// Towards lower ground, unit length.
    pub out: Vector2,
    pub z: f64,
    /// The wall is upright here.
    pub leap: bool,
}

/// The runs of one curve.
#[derive(Clone, Debug, Default)]
pub(super) struct Runs {
    /// Each with whether it is closed.
    pub runs: Vec<(Vec<Cross>, bool)>,
    /// The deepest place of what the flutes do not reach down to.
    pub too_deep: Option<TooDeep>,
    /// Length along the wall of that, mm.
    pub refused: f64,
}

/// Gaps in a wall shorter than this many stepovers are cut with it.
pub(in crate::toolpath) const BRIDGED: f64 = 4.0;

/// What is known of one edge of a curve.
enum Asked {
    Nothing,
    /// The place, and whether the wall is as steep as asked; a little less will do between two such places.
    Wall(Cross, bool),
    /// An upright wall that the flutes do not reach down: where on it.
    Refused(Point2),
}

/// The runs of a level curve that lie on a wall, each crossing closed in on. At `level`, or (with `None`) at the upper rim of a leap.
pub(super) fn crossings(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    part: &Uprights,
    steep: &Steep,
    curve: &LevelCurve,
    level: Option<&Level>,
) -> Runs {
    let o = &steep.options;
    let on_wall: Vec<bool> = curve
        .at
        .iter()
        .map(|e| {
            let nodes = [e.a as usize, e.b as usize];
            // Below the edge of an upright wall around the outline there is nothing that cusps stand on.
            let below = nodes.iter().any(|&n| grid.kind[n] == NodeKind::Air)
                && nodes.iter().any(|&n| steep.outer[n]);
            let sloping = level.is_some_and(|l| !l.uprights);
            let on = if sloping { &steep.near } else { &steep.node };
            !(sloping && below) && nodes.iter().any(|&n| on[n])
        })
        .collect();
    if !on_wall.contains(&true) {
        return Runs::default();
    }
    // Only what may be bridged is asked beside what is on a wall.
    let rough: Vec<Option<Point2>> = curve.at.iter().map(|e| Some(e.xy(grid))).collect();
    let mut wanted = on_wall.clone();
    bridge(
        &mut wanted,
        &rough,
        curve.closed,
        1.5 * BRIDGED * o.stepover,
    );
    let mut hint = Hint::default();
    let mut too_deep: Option<TooDeep> = None;
    let asked: Vec<Asked> = curve
        .at
        .iter()
        .enumerate()
        .map(|(k, e)| {
            if !wanted[k] {
                return Asked::Nothing;
            }
            let edge = (e.a as usize, e.b as usize);
            let found = ask(grid, cutter, part, steep, edge, level, &mut hint);
            match found {
                Found::Nothing => Asked::Nothing,
                Found::Wall(c) => Asked::Wall(c, on_wall[k]),
                Found::Refused(t) => {
                    if too_deep.is_none_or(|d| t.needs > d.needs) {
                        too_deep = Some(t);
                    }
                    Asked::Refused(t.place.xy())
                }
            }
        })
        .collect();
    let cross = |a: &Asked| match a {
        Asked::Wall(c, _) => Some(*c),
        _ => None,
    };
    let at: Vec<Option<Point2>> = asked.iter().map(|a| cross(a).map(|c| c.at)).collect();
    let mut kept: Vec<bool> = asked
        .iter()
        .map(|a| matches!(a, Asked::Wall(_, true)))
        .collect();
    bridge(&mut kept, &at, curve.closed, BRIDGED * o.stepover);
    let found: Vec<Option<Cross>> = asked
        .iter()
        .zip(kept)
        .map(|(a, k)| cross(a).filter(|_| k))
        .collect();
    let mut runs = split(&found, curve.closed);
    // At the heights of upright walls the others have no passes.
    if level.is_some_and(|l| l.uprights) {
        runs.retain(|(run, _)| run.iter().any(|c| c.leap));
    }
    Runs {
        runs,
        too_deep,
        refused: refused(&asked, curve.closed),
    }
}

/// Length along the wall of what was refused, mm.
fn refused(asked: &[Asked], closed: bool) -> f64 {
    let n = asked.len();
    let pairs = if closed { n } else { n.saturating_sub(1) };
    (0..pairs)
        .map(|k| match (&asked[k], &asked[(k + 1) % n]) {
            (Asked::Refused(a), Asked::Refused(b)) => (b - a).norm(),
            _ => 0.0,
        })
        .sum()
}

enum Found {
    Nothing,
    Wall(Cross),
    Refused(TooDeep),
}

/// What stands on one edge of the grid at a height.
fn ask(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    part: &Uprights,
    steep: &Steep,
    (a, b): (usize, usize),
    level: Option<&Level>,
    hint: &mut Hint,
) -> Found {
    let o = &steep.options;
    let (low, high) = if grid.center_z[a] < grid.center_z[b] {
        (a, b)
    } else {
        (b, a)
    };
    let z = match level {
        Some(l) => l.z,
        // Half way up the leap.
        None => 0.5 * (grid.center_z[low].max(o.floor) + grid.center_z[high]),
    };
    let Some((at, below, above)) = between(cutter, &grid.xy(low), &grid.xy(high), z, hint) else {
        return Found::Nothing;
    };
    let way = grid.xy(low) - grid.xy(high);
    let out = way / way.norm().max(1e-300);
    let leap = below.is_none_or(|c| c.center.z < z - LEAP);
    let z = match level {
        Some(l) if leap && !l.uprights => return Found::Nothing,
        Some(l) => l.z,
        None if leap => above.center.z - 2.0 * LEAP,
        None => return Found::Nothing,
    };
    if !leap {
        return if is_wall(grid, cutter, &at, &out, steep, hint) {
            Found::Wall(Cross { at, out, z, leap })
        } else {
            Found::Nothing
        };
    }
    let r = grid.radius;
    let touched = part
        .nearest(&at, z, 1.1 * r)
        .filter(|(d, _)| (d - r).abs() <= super::TOUCH);
    let Some((_, wall)) = touched else {
        return Found::Nothing;
    };
    // What the flutes touch of the wall when the ball's centre is at a height.
    let needs = |center: f64| above.point.z - (center - r);
    if needs(z) > o.flute {
        return Found::Refused(TooDeep {
            place: Point::new(wall.x, wall.y, z),
            needs: needs(z),
        });
    }
    if let Some(l) = level
        && o.at_once()
    {
        // A deeper pass cuts here too: the next lower height, or the pencil pass along the foot.
        let foot = below.map_or(f64::NEG_INFINITY, |c| c.center.z);
        let deeper = l.next.max(foot);
        if deeper.is_finite() && needs(deeper) <= o.flute {
            return Found::Nothing;
        }
    }
    Found::Wall(Cross { at, out, z, leap })
}

/// Is the ground the ball touches here steep, and not merely an edge it rolls over?
fn is_wall(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    at: &Point2,
    out: &Vector2,
    steep: &Steep,
    hint: &mut Hint,
) -> bool {
    let Some(a) = cutter.drop_near(at.x, at.y, hint) else {
        return false;
    };
    // Uphill: downhill the next thing may be a leap. So far that rolling over a sharp edge shows.
    let side = 1.5 * ROLLING.1 * cutter.radius() * a.normal_z().max(0.02);
    let q = at - out * side;
    let Some(b) = cutter.drop_near(q.x, q.y, hint) else {
        return false;
    };
    !rolls([a.center, b.center], [a.point, b.point], cutter.radius())
        && a.normal_z() < (0.8 * steep.options.angle).cos()
        && !cutter.on_outline(&b, grid.outline_reach())
}

/// Closes in on the height z between a low and a high place: where on the low side, and the balls on either side. `None` unless z
/// lies between.
pub(super) fn between(
    cutter: &DropCutter,
    low: &Point2,
    high: &Point2,
    z: f64,
    hint: &mut Hint,
) -> Option<(Point2, Option<Contact>, Contact)> {
    let mut above = cutter
        .drop_near(high.x, high.y, hint)
        .filter(|c| c.center.z >= z)?;
    let mut below = cutter.drop_near(low.x, low.y, hint);
    if below.is_some_and(|c| c.center.z >= z) {
        return None;
    }
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..16 {
        let t = 0.5 * (lo + hi);
        let q = low + (high - low) * t;
        match cutter.drop_near(q.x, q.y, hint) {
            Some(c) if c.center.z >= z => {
                above = c;
                hi = t;
            }
            c => {
                below = c;
                lo = t;
            }
        }
    }
    Some((low + (high - low) * lo, below, above))
}

/// Unbroken runs of what was found.
pub(super) fn split(found: &[Option<Cross>], closed: bool) -> Vec<(Vec<Cross>, bool)> {
    let n = found.len();
    if found.iter().all(Option::is_some) {
        return vec![(found.iter().flatten().copied().collect(), closed)];
    }
    let start = if closed {
        found.iter().position(Option::is_none).unwrap_or(0)
    } else {
        0
    };
    let mut out = Vec::new();
    let mut run = Vec::new();
    for k in 0..n {
        match found[(start + k) % n] {
            Some(c) => run.push(c),
            None => out.push((std::mem::take(&mut run), false)),
        }
    }
    out.push((run, false));
    out.retain(|r| r.0.len() > 1);
    out
}
