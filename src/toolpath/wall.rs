//! Steep walls: passes at constant height, from the top of a wall to its foot.
//!
//! ```text
//!      ___        o            the ball's side touches the wall at the height of its centre; one vertical stepover apart,
//!         |   ( o )            sqrt(8 h R - 4 h^2), the cusps on an upright wall are h high
//!         |  ( o )
//!    _____|_( o )___           c(x, y) >= z on the wall's side of the path, < z on the other: found by bisection on the grid's
//!                              edges, also where the height leaps
//! ```
//!
//! Walls of closed solids reach below the outline, where the drop cutter finds only air: there the ball goes down to a floor, its
//! tip no lower than that. The wall above a ball that goes deep is touched by the flutes: deeper than they are long is refused.
//!
//! Crosses the border: the grid and the part's triangles in, [`Pass`]es of ball centres and refusals out; work coordinates, mm.

use super::fit::FitOptions;
use super::pass::{Pass, PassKind};
use crate::feature::Regions;
use crate::field::{LevelCurve, level_curves};
use crate::geom::{Point, Point2, Vector2};
use crate::part::Mesh;
use crate::reach::{Contact, Crease, DropCutter, Hint, NodeKind, ToolCentreGrid};
use crate::sweep::buckets::Buckets;
use rayon::prelude::*;

/// How walls are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallOptions {
    /// Ground steeper than this is a wall, radians from the horizontal.
    pub angle: f64,
    /// Distance of passes along an upright wall, mm.
    pub stepover: f64,
    /// The tip of the ball goes no lower than this beside a closed solid, mm.
    pub floor: f64,
    /// Length of the flutes from the tip, mm.
    pub flute: f64,
    /// An upright wall is cut this deep at once at most, mm; the whole length of the flutes where only an allowance stands on it.
    pub deepest: f64,
    /// Room kept to the wall, mm: chords stay within half of it.
    pub off_wall: f64,
}

/// A wall that the flutes do not reach down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooDeep {
    /// On the wall, at the foot of what would have to be cut.
    pub place: Point,
    /// Flutes it would take, mm.
    pub needs: f64,
}

/// Which nodes stand on a wall, and what heights of the ball's centre that takes.
#[derive(Clone, Debug)]
pub struct Steep {
    /// By node.
    pub node: Vec<bool>,
    range: [f64; 2],
    options: WallOptions,
}

/// Centre height of air, for comparing: below everything.
const AIR: f64 = -1e9;
/// The ball rolls over a sharp edge where its contact moves less than this share of its centre's way.
const ROLLING: f64 = 0.3;
/// Triangles with a smaller vertical part of the normal are upright.
const UPRIGHT: f64 = 0.02;
/// A ball touches an upright wall when it is this near, mm.
const TOUCH: f64 = 0.005;
/// A longer fall over a bisected edge is a leap, mm.
const LEAP: f64 = 0.01;
const OWN: [(i32, i32); 3] = [(1, 0), (1, 1), (0, 1)];

/// Finds the walls of a grid. Linear in the nodes.
pub fn steep(grid: &ToolCentreGrid, part: &Uprights, options: &WallOptions) -> Steep {
    let slope = options.angle.tan();
    let bottom = options.floor + grid.radius;
    let found: Vec<(usize, usize, f64, f64)> = (0..grid.len())
        .into_par_iter()
        .flat_map_iter(|i| {
            OWN.into_iter().filter_map(move |d| {
                let j = grid.neighbour(i, d)?;
                let (a, b) = (grid.center(i), grid.center(j));
                match (grid.kind[i], grid.kind[j]) {
                    (NodeKind::Air, NodeKind::Air) => None,
                    (NodeKind::Air, _) => part.outer(grid, j).then_some((i, j, bottom, b.z)),
                    (_, NodeKind::Air) => part.outer(grid, i).then_some((i, j, bottom, a.z)),
                    _ => {
                        let c = b - a;
                        let rolls = (grid.point[j] - grid.point[i]).norm() < ROLLING * c.norm();
                        (c.z.abs() > slope * c.xy().norm() && !rolls).then_some((
                            i,
                            j,
                            a.z.min(b.z),
                            a.z.max(b.z),
                        ))
                    }
                }
            })
        })
        .collect();
    let mut out = Steep {
        node: vec![false; grid.len()],
        range: [f64::INFINITY, f64::NEG_INFINITY],
        options: *options,
    };
    for (i, j, lo, hi) in found {
        if lo < hi {
            out.node[i] = true;
            out.node[j] = true;
            out.range = [out.range[0].min(lo), out.range[1].max(hi)];
        }
    }
    out
}

impl Steep {
    /// Where a level curve of a feature runs along a wall for more than two stepovers: the wall has passes of its own.
    pub fn along(&self, grid: &ToolCentreGrid, curve: &LevelCurve) -> Vec<bool> {
        let n = curve.at.len();
        let mut out: Vec<bool> = curve
            .at
            .iter()
            .map(|e| self.node[e.a as usize] && self.node[e.b as usize])
            .collect();
        if !out.contains(&true) {
            return out;
        }
        let at: Vec<Option<Point2>> = curve.at.iter().map(|e| Some(e.xy(grid))).collect();
        bridge(&mut out, &at, curve.closed, self.options.stepover);
        let start = if curve.closed {
            out.iter().position(|w| !w).unwrap_or(0)
        } else {
            0
        };
        let mut run: Vec<usize> = Vec::new();
        let mut length = 0.0;
        for k in 0..=n {
            let i = (start + k) % n;
            if k < n && out[i] {
                if let Some(&last) = run.last() {
                    length += (curve.at[i].xy(grid) - curve.at[last].xy(grid)).norm();
                }
                run.push(i);
            } else {
                if length < 2.0 * self.options.stepover {
                    run.iter().for_each(|&i| out[i] = false);
                }
                run.clear();
                length = 0.0;
            }
        }
        out
    }
}

/// The upright triangles of a part, sorted in plan.
pub struct Uprights<'a> {
    mesh: &'a Mesh,
    index: Vec<u32>,
    buckets: Buckets,
    radius: f64,
}

impl WallOptions {
    /// Upright walls are looked at in steps of this height, mm.
    fn step(&self) -> f64 {
        // Twice along the flutes, so that a wall under a sloping top is cut with most of their length.
        if self.at_once() {
            0.5 * self.flute
        } else {
            self.deepest
        }
    }

    /// Whether an upright wall is cut by the deepest pass that the flutes allow, and no other.
    fn at_once(&self) -> bool {
        self.deepest >= self.flute
    }
}

impl<'a> Uprights<'a> {
    /// Sorts the upright triangles for a ball of this radius, mm.
    pub fn new(mesh: &'a Mesh, radius: f64) -> Uprights<'a> {
        let index: Vec<u32> = mesh
            .triangles
            .iter()
            .enumerate()
            .filter(|(_, t)| {
                let n = Mesh::doubled_area_vector(t);
                let l = n.norm();
                l > 0.0 && n.z.abs() < UPRIGHT * l
            })
            .map(|(i, _)| i as u32)
            .collect();
        let b = mesh.bounds();
        let buckets = Buckets::new(
            b.min.xy(),
            b.max.xy(),
            0.5 * radius,
            index.len(),
            |b, i, put| {
                let t = &mesh.triangles[index[i] as usize];
                let (lo, hi) = (t[0].inf(&t[1]).inf(&t[2]), t[0].sup(&t[1]).sup(&t[2]));
                for by in b.rows(lo.y, hi.y) {
                    for bx in b.columns(lo.x, hi.x) {
                        put(by * b.nx + bx);
                    }
                }
            },
        );
        Uprights {
            mesh,
            index,
            buckets,
            radius,
        }
    }

    /// Nearest upright wall to a place, in the plane at this height; `+inf` beyond a radius or so.
    fn distance(&self, q: &Point2, z: f64, within: f64) -> f64 {
        let mut best = f64::INFINITY;
        if self.index.is_empty() {
            return best;
        }
        let b = &self.buckets;
        for by in b.rows(q.y - within, q.y + within) {
            for bx in b.columns(q.x - within, q.x + within) {
                for &k in b.of(by * b.nx + bx) {
                    let t = &self.mesh.triangles[self.index[k as usize] as usize];
                    best = best.min(section_distance(t, q, z));
                }
            }
        }
        best
    }

    /// Does a wall go down from the outline that this node's ball rolls round?
    fn outer(&self, grid: &ToolCentreGrid, node: usize) -> bool {
        let p = grid.point[node];
        self.distance(&p.xy(), p.z - 0.02 * self.radius, 0.1 * self.radius) < 2.0 * TOUCH
    }
}

/// Distance in plan from q to the cut of a triangle at height z; `+inf` when it is not cut there.
fn section_distance(t: &[Point; 3], q: &Point2, z: f64) -> f64 {
    let mut ends: [Option<Point2>; 2] = [None; 2];
    for k in 0..3 {
        let (a, b) = (&t[k], &t[(k + 1) % 3]);
        if (a.z > z) != (b.z > z) {
            let p = a.xy() + (b.xy() - a.xy()) * ((z - a.z) / (b.z - a.z));
            if ends[0].is_none() {
                ends[0] = Some(p);
            } else {
                ends[1] = Some(p);
            }
        }
    }
    let [Some(a), Some(b)] = ends else {
        return f64::INFINITY;
    };
    let e = b - a;
    let l = e.norm_squared();
    let s = if l > 0.0 {
        ((q - a).dot(&e) / l).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + e * s - q).norm()
}

/// A height at which walls are cut.
#[derive(Clone, Copy)]
struct Level {
    /// Of the ball's centre, mm.
    z: f64,
    /// Upright walls too, not only those that cusps stand on.
    uprights: bool,
    /// No upright wall is cut below it.
    lowest: bool,
}

/// A place where a height is crossed: on the low side of it.
#[derive(Clone, Copy)]
struct Cross {
    at: Point2,
    /// Towards lower ground, unit length.
    out: Vector2,
    z: f64,
}

/// Constant-height passes down all walls, and one along the top of each upright one. Neighbours are joined where a straight step
/// from one to the next is free. All cores; the order does not depend on them.
pub fn walls(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    part: &Uprights,
    steep: &Steep,
    leaps: &[Crease],
    fitting: &FitOptions,
) -> (Vec<Pass>, Vec<TooDeep>) {
    let o = &steep.options;
    let [lo, hi] = steep.range;
    if lo >= hi {
        return (Vec::new(), Vec::new());
    }
    // From the floor of a closed solid up; elsewhere the foot of a wall has a pass of its own.
    let base = o.floor + grid.radius;
    let first = ((lo - base) / o.stepover).ceil() as i64;
    let last = ((hi - base) / o.stepover).floor() as i64;
    let levels: Vec<f64> = (first..=last)
        .map(|k| base + k as f64 * o.stepover)
        .collect();
    // The flutes cut an upright wall as high as they are long: it takes steps for the load, not for cusps.
    let every = ((o.step() / o.stepover).floor() as i64).max(1);
    let value = |n: usize| grid.center_z[n].max(AIR);
    let mut too_deep = Vec::new();
    let mut by_level: Vec<Vec<(Vec<Cross>, bool)>> = vec![Vec::new(); levels.len() + 1];
    let curves = level_curves(grid, &value, &levels);
    let found: Vec<(usize, Runs)> = curves
        .par_iter()
        .map(|c| {
            let edges: Vec<(u32, u32)> = c.at.iter().map(|e| (e.a, e.b)).collect();
            let runs = crossings(
                grid,
                cutter,
                part,
                steep,
                &edges,
                c.closed,
                Some(Level {
                    z: levels[c.level],
                    uprights: (first + c.level as i64).rem_euclid(every) == 0,
                    lowest: first + (c.level as i64) < every,
                }),
            );
            (c.level, runs)
        })
        .collect();
    for (level, runs) in found {
        too_deep.extend(runs.too_deep);
        by_level[levels.len() - 1 - level + 1].extend(runs.runs);
    }
    // The tops of upright walls, as one more level above all others.
    for runs in tops(grid, cutter, part, steep, leaps) {
        by_level[0].extend(runs.runs);
    }
    let fitted: Vec<Vec<(Vec<Point>, bool)>> = by_level
        .into_par_iter()
        .map(|runs| {
            runs.into_iter()
                .flat_map(|(run, closed)| laid_at_height(cutter, &run, closed, o, fitting))
                .collect()
        })
        .collect();
    (
        stacked(cutter, grid, regions, fitted, every as usize, o, fitting),
        too_deep,
    )
}

#[derive(Default)]
struct Runs {
    runs: Vec<(Vec<Cross>, bool)>,
    too_deep: Option<TooDeep>,
}

/// The runs of a curve, given by the edges it crosses, that lie on a wall, each crossing closed in on. At `level`, or (with `None`)
/// at the upper rim of a leap.
fn crossings(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    part: &Uprights,
    steep: &Steep,
    edges: &[(u32, u32)],
    closed: bool,
    level: Option<Level>,
) -> Runs {
    let mut too_deep: Option<TooDeep> = None;
    let mut hint = Hint::default();
    let masked = |&(a, b): &(u32, u32)| steep.node[a as usize] || steep.node[b as usize];
    if !edges.iter().any(masked) {
        return Runs::default();
    }
    // With each crossing, whether the wall is as steep as asked; a little less will do between two such places.
    let found: Vec<Option<(Cross, bool)>> = edges
        .iter()
        .map(|&(a, b)| {
            let on_wall = masked(&(a, b));
            let (a, b) = (a as usize, b as usize);
            let (low, high) = if grid.center_z[a] < grid.center_z[b] {
                (a, b)
            } else {
                (b, a)
            };
            let z = match level {
                Some(l) => l.z,
                // Half way up the leap.
                None => 0.5 * (grid.center_z[low].max(steep.options.floor) + grid.center_z[high]),
            };
            let (at, below, above) = between(cutter, &grid.xy(low), &grid.xy(high), z, &mut hint)?;
            let way = grid.xy(low) - grid.xy(high);
            let out = way / way.norm().max(1e-300);
            let leap = below.is_none_or(|c| c.center.z < z - LEAP);
            let z = match level {
                Some(l) if leap && !l.uprights => return None,
                Some(l) => l.z,
                None if leap => above.center.z - 2.0 * LEAP,
                None => return None,
            };
            if leap {
                if (part.distance(&at, z, 1.1 * grid.radius) - grid.radius).abs() > TOUCH {
                    return None;
                }
                let needs = above.point.z - (z - grid.radius);
                if needs > steep.options.flute {
                    if too_deep.is_none_or(|t| needs > t.needs) {
                        let p = at - out * grid.radius;
                        too_deep = Some(TooDeep {
                            place: Point::new(p.x, p.y, z),
                            needs,
                        });
                    }
                    return None;
                }
                // A deeper pass cuts here too.
                let deeper = level.is_some_and(|l| !l.lowest);
                if deeper
                    && steep.options.at_once()
                    && needs + steep.options.step() <= steep.options.flute
                {
                    return None;
                }
            }
            if !leap && !is_wall(cutter, &at, &out, steep, &mut hint) {
                return None;
            }
            Some((Cross { at, out, z }, on_wall))
        })
        .collect();
    let at: Vec<Option<Point2>> = found.iter().map(|f| f.map(|f| f.0.at)).collect();
    let mut kept: Vec<bool> = found.iter().map(|f| f.is_some_and(|f| f.1)).collect();
    bridge(&mut kept, &at, closed, BRIDGED * steep.options.stepover);
    let found: Vec<Option<Cross>> = found
        .iter()
        .zip(kept)
        .map(|(f, k)| f.filter(|_| k).map(|f| f.0))
        .collect();
    Runs {
        runs: split(&found, closed),
        too_deep,
    }
}

/// Gaps in a wall shorter than this many stepovers are cut with it.
const BRIDGED: f64 = 4.0;

/// Keeps what lies in short gaps (mm) between two kept places of a curve, unless there is no place at all in the gap.
fn bridge(kept: &mut [bool], at: &[Option<Point2>], closed: bool, longest: f64) {
    let n = kept.len();
    let Some(start) = kept.iter().position(|k| *k) else {
        return;
    };
    let steps = if closed { n } else { n - 1 - start };
    let mut gap: Vec<usize> = Vec::new();
    let (mut length, mut whole) = (0.0, true);
    let mut last = at[start];
    for k in 1..=steps {
        let i = (start + k) % n;
        match (last, at[i]) {
            (Some(p), Some(q)) => length += (q - p).norm(),
            _ => whole = false,
        }
        last = at[i];
        if kept[i] {
            if whole && length <= longest {
                gap.iter().for_each(|&g| kept[g] = true);
            }
            gap.clear();
            (length, whole) = (0.0, true);
        } else {
            gap.push(i);
        }
    }
}

/// Is the ground the ball touches here steep, and not merely an edge it rolls over?
fn is_wall(
    cutter: &DropCutter,
    at: &Point2,
    out: &Vector2,
    steep: &Steep,
    hint: &mut Hint,
) -> bool {
    let side = 0.01 * cutter.radius();
    // Uphill: downhill the next thing may be a leap.
    let q = at - out * side;
    let (Some(a), Some(b)) = (
        cutter.drop_near(at.x, at.y, hint),
        cutter.drop_near(q.x, q.y, hint),
    ) else {
        return false;
    };
    let rolls = (b.point - a.point).norm() < ROLLING * (b.center - a.center).norm();
    !rolls && a.normal_z() < (0.8 * steep.options.angle).cos()
}

/// Closes in on the height z between a low and a high place: where on the low side, and the balls on either side. `None` unless z
/// lies between.
fn between(
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
fn split(found: &[Option<Cross>], closed: bool) -> Vec<(Vec<Cross>, bool)> {
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

/// The upper rims of upright walls: of leaps inside the ground, and of the outline of closed solids.
fn tops(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    part: &Uprights,
    steep: &Steep,
    leaps: &[Crease],
) -> Vec<Runs> {
    let value = |n: usize| {
        if grid.kind[n] == NodeKind::Air {
            0.0
        } else {
            1.0
        }
    };
    // Around the outline the passes over the top run on beyond it.
    let outline = if steep.options.at_once() {
        Vec::new()
    } else {
        level_curves(grid, &value, &[0.5])
    };
    let mut out: Vec<Runs> = outline
        .par_iter()
        .map(|c| {
            let edges: Vec<(u32, u32)> = c.at.iter().map(|e| (e.a, e.b)).collect();
            crossings(grid, cutter, part, steep, &edges, c.closed, None)
        })
        .collect();
    for c in leaps {
        let found: Vec<Option<Cross>> = c
            .points
            .iter()
            .map(|p| {
                let z = p.center.z + p.rise - 2.0 * LEAP;
                let tall = p.rise > 0.5 * steep.options.stepover;
                let touches = || {
                    (part.distance(&p.center.xy(), z, 1.1 * grid.radius) - grid.radius).abs()
                        < TOUCH
                };
                (tall && touches()).then_some(Cross {
                    at: p.center.xy(),
                    out: p.out,
                    z,
                })
            })
            .collect();
        out.push(Runs {
            runs: split(&found, c.closed),
            too_deep: None,
        });
    }
    out
}

/// A run moved off its wall and thinned out to what the tolerance needs; proven free along every chord, split where it is not.
fn laid_at_height(
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
pub(super) fn moved_out(at: &[(Point2, Vector2)], closed: bool, off: f64) -> Vec<Point2> {
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
    let e = b - a;
    let l2 = e.norm_squared();
    if l2 > longest * longest {
        return false;
    }
    points[1..points.len() - 1].iter().all(|p| {
        let s = if l2 > 0.0 {
            ((p - a).dot(&e) / l2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a + e * s - p).norm() <= tolerance
    })
}

/// Does the ball enter the part nowhere along a chord? Asked `probe` mm apart.
fn free(cutter: &DropCutter, a: &Point, b: &Point, probe: f64, hint: &mut Hint) -> bool {
    let n = ((b - a).norm() / probe).ceil().max(1.0) as usize;
    (0..=n).all(|k| {
        let q = a + (b - a) * (k as f64 / n as f64);
        cutter
            .drop_near(q.x, q.y, hint)
            .is_none_or(|c| (c.center.z - q.z) * c.normal_z() <= 1e-3)
    })
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

/// One wall on its way down.
struct Stack {
    points: Vec<Point>,
    /// Level of the last run.
    level: usize,
    /// Points at its end that go once round at the last height: not needed when a helix goes on down.
    flat: usize,
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

/// Joins the runs of each level to those of the level above where the step down is free.
fn stacked(
    cutter: &DropCutter,
    grid: &ToolCentreGrid,
    regions: &Regions,
    levels: Vec<Vec<(Vec<Point>, bool)>>,
    every: usize,
    o: &WallOptions,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let mut stacks: Vec<Stack> = Vec::new();
    let mut hint = Hint::default();
    for (level, runs) in levels.into_iter().enumerate() {
        for (mut run, closed) in runs {
            // The nearest end of a wall that came down to here.
            let mut best: Option<(f64, usize, usize)> = None;
            for (s, stack) in stacks.iter().enumerate() {
                let Some(end) = stack.points.last() else {
                    continue;
                };
                // The first level is a rim of any height.
                if stack.level + every < level && stack.level > 0 {
                    continue;
                }
                let n = run.len();
                let entries: &mut dyn Iterator<Item = usize> = if closed {
                    &mut (0..n)
                } else {
                    &mut [0, n - 1].into_iter()
                };
                for k in entries {
                    let d = (run[k] - end).norm();
                    let below = closed
                        && (run[k].xy() - end.xy()).norm() < 0.5 * o.stepover
                        && (end.z - run[k].z) < (every as f64 + 1.0) * o.stepover;
                    if (d < 1.6 * o.stepover || below) && best.is_none_or(|b| d < b.0) {
                        best = Some((d, s, k));
                    }
                }
            }
            if let Some((d, s, k)) = best {
                if closed {
                    run.rotate_left(k);
                } else if k > 0 {
                    run.reverse();
                }
                if closed && d >= 1.6 * o.stepover {
                    // Down an upright wall along a helix, and once round at its foot. Where the ball is free at a height it is free
                    // above it.
                    run.push(run[0]);
                    let stack = &mut stacks[s];
                    let keep = stack.points.len() - stack.flat;
                    stack.points.truncate(keep);
                    if let Some(from) = stack.points.last().copied() {
                        stack.points.extend(helix(from.z, &run));
                    }
                    stack.flat = run.len() - 1;
                    stack.points.extend(run.drain(1..));
                    stack.level = level;
                    continue;
                }
                let way = stacks[s]
                    .points
                    .last()
                    .and_then(|end| step_down(cutter, end, &run[0], fitting, &mut hint));
                if let Some(way) = way {
                    stacks[s].points.extend(way);
                    if closed {
                        run.push(run[0]);
                    }
                    stacks[s].points.extend(run);
                    stacks[s].level = level;
                    stacks[s].flat = 0;
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
            });
        }
    }
    stacks
        .into_iter()
        .map(|s| Pass {
            kind: PassKind::Wall,
            feature: s
                .points
                .first()
                .and_then(|p| regions.feature_at(grid, &p.xy())),
            points: s.points,
            closed: false,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::reach::{GridOptions, GridPlan};

    /// A closed box of this size, its top at zero.
    fn block(x: f64, y: f64, z: f64) -> Mesh {
        let p = |i: usize| Point::new([0.0, x][i & 1], [0.0, y][(i >> 1) & 1], [-z, 0.0][i >> 2]);
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [1, 3, 7, 5],
            [3, 2, 6, 7],
            [2, 0, 4, 6],
        ];
        Mesh {
            triangles: faces
                .iter()
                .flat_map(|f| [[p(f[0]), p(f[1]), p(f[2])], [p(f[0]), p(f[2]), p(f[3])]])
                .collect(),
        }
    }

    fn cut(mesh: &Mesh, flute: f64) -> (Vec<Pass>, Vec<TooDeep>) {
        let cutter = DropCutter::new(mesh, 2.0);
        let how = GridOptions {
            step: 0.13,
            memory_limit_bytes: 1 << 30,
        };
        let grid = ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap();
        let uprights = Uprights::new(mesh, 2.0);
        let options = WallOptions {
            angle: 75f64.to_radians(),
            stepover: 0.6,
            floor: cutter.bounds().min.z,
            flute,
            deepest: 0.6,
            off_wall: 0.0024,
        };
        let steep = steep(&grid, &uprights, &options);
        let regions = Regions {
            features: Vec::new(),
            label: vec![0; grid.len()],
        };
        let fitting = FitOptions::for_scallop(0.02, 2.0);
        walls(&grid, &cutter, &regions, &uprights, &steep, &[], &fitting)
    }

    /// One pass goes round and down: from the top edge to the floor, a stepover at a time, one radius off.
    #[test]
    fn a_block_is_gone_round_down_to_the_floor() {
        let (passes, too_deep) = cut(&block(12.0, 9.0, 7.0), 18.0);
        assert_eq!((passes.len(), too_deep.len()), (1, 0));
        let mut heights: Vec<f64> = Vec::new();
        for p in &passes[0].points {
            let beside = Vector2::new(
                (-p.x).max(p.x - 12.0).max(0.0),
                (-p.y).max(p.y - 9.0).max(0.0),
            );
            assert!((beside.norm() - 2.0024).abs() < 0.0025, "{p}");
            heights.push(p.z);
        }
        heights.sort_by(f64::total_cmp);
        assert!(
            (heights[0] + 5.0).abs() < 1e-9,
            "the tip stands on the floor"
        );
        assert!(
            heights[heights.len() - 1] > -0.03,
            "and it begins at the top edge"
        );
        assert!(heights.windows(2).all(|w| w[1] - w[0] < 0.6 + 1e-9));
        let round = 2.0 * (12.0 + 9.0) + 2.0 * std::f64::consts::PI * 2.0;
        let levels = (5.0f64 / 0.6).floor() + 1.0 + 1.0;
        assert!((passes[0].length() / (round * levels) - 1.0).abs() < 0.02);
    }

    /// Flutes of 4 mm cut 4 mm deep; what stays is named, with what it would take.
    #[test]
    fn short_flutes_stop_and_say_so() {
        let (passes, too_deep) = cut(&block(12.0, 9.0, 7.0), 4.0);
        let lowest = passes
            .iter()
            .flat_map(|p| &p.points)
            .map(|p| p.z)
            .fold(f64::INFINITY, f64::min);
        assert!((-2.0 - 1e-9..-1.3).contains(&lowest), "{lowest}");
        let most = too_deep.iter().map(|t| t.needs).fold(0.0, f64::max);
        assert!((most - 7.0).abs() < 0.02, "{too_deep:?}");
    }

    #[test]
    fn an_open_sheet_has_no_walls() {
        let p = Point::new;
        let sheet = Mesh {
            triangles: vec![
                [p(0.0, 0.0, 0.0), p(9.0, 0.0, 2.0), p(9.0, 9.0, 2.0)],
                [p(0.0, 0.0, 0.0), p(9.0, 9.0, 2.0), p(0.0, 9.0, 0.0)],
            ],
        };
        assert_eq!(cut(&sheet, 18.0), (Vec::new(), Vec::new()));
    }
}
