//! Which nodes of a grid stand on a wall, and between what heights walls run.

use super::{Uprights, WallOptions, rolls};
use crate::field::LevelCurve;
use crate::geom::{Point2, RING, Vector2};
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// Which nodes stand on a wall, and what heights of the ball's centre that takes.
#[derive(Clone, Debug)]
pub struct Steep {
    /// By node.
    pub node: Vec<bool>,
    /// By node: on a wall, or so near above or below one that passes at constant height go on there. The level passes of a feature end
    /// at the wall, each where it comes to it: without an overlap the two families leave a ragged seam between them, and a fill for
    /// every end.
    pub(super) near: Vec<bool>,
    /// By node: an upright wall goes down from the outline here.
    pub(super) outer: Vec<bool>,
    /// Lowest and highest centre on walls inside the outline.
    pub(super) sloping: [f64; 2],
    /// Heights of the passes on those, rising: the centre of the ball.
    pub(super) heights: Vec<f64>,
    /// The same of walls that may be upright: those around the outline of a closed solid among them.
    pub(super) upright: [f64; 2],
    /// The highest edge from which a wall goes down around the outline; -inf without.
    pub(super) edge: f64,
    pub(in crate::toolpath) options: WallOptions,
}

const OWN: [(i32, i32); 3] = [(1, 0), (1, 1), (0, 1)];

/// One edge of the grid that stands on a wall.
struct Found {
    nodes: [usize; 2],
    heights: [f64; 2],
    /// Top of the wall that goes down from the outline here.
    outer: Option<f64>,
    /// Height between passes here, mm.
    apart: f64,
}

/// Finds the walls of a grid. Linear in the nodes.
pub fn steep(grid: &ToolCentreGrid, part: &Uprights, options: &WallOptions) -> Steep {
    let slope = options.angle.tan();
    let bottom = options.floor + grid.radius;
    let outline = |inside: usize, air: usize| {
        part.outer(grid, inside).then(|| Found {
            nodes: [inside, air],
            heights: [bottom, grid.center_z[inside]],
            outer: Some(grid.point[inside].z),
            apart: options.stepover,
        })
    };
    let found: Vec<Found> = (0..grid.len())
        .into_par_iter()
        .flat_map_iter(|i| {
            OWN.into_iter().filter_map(move |d| {
                let j = grid.neighbour(i, d)?;
                match (grid.kind[i], grid.kind[j]) {
                    (NodeKind::Air, NodeKind::Air) => None,
                    (NodeKind::Air, _) => outline(j, i),
                    (_, NodeKind::Air) => outline(i, j),
                    // The ball rolls round the outline: there is nothing to cut.
                    (NodeKind::Rim, NodeKind::Rim) => None,
                    _ => {
                        let (a, b) = (grid.center(i), grid.center(j));
                        let c = b - a;
                        let contacts = [grid.point[i], grid.point[j]];
                        let steep = c.z.abs() > slope * c.xy().norm()
                            && !rolls([a, b], contacts, grid.radius);
                        steep.then(|| Found {
                            nodes: [i, j],
                            heights: [a.z.min(b.z), a.z.max(b.z)],
                            outer: None,
                            // The cusp of a step is dp dc / (8 R), and goes as the square of the step.
                            apart: c.z.abs() * options.stepover
                                / c.dot(&(contacts[1] - contacts[0])).max(0.0).sqrt(),
                        })
                    }
                }
            })
        })
        .collect();
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let mut out = Steep {
        node: vec![false; grid.len()],
        near: Vec::new(),
        outer: vec![false; grid.len()],
        sloping: none,
        heights: Vec::new(),
        upright: none,
        edge: f64::NEG_INFINITY,
        options: *options,
    };
    let widen = |range: &mut [f64; 2], [lo, hi]: [f64; 2]| {
        *range = [range[0].min(lo), range[1].max(hi)];
    };
    for f in &found {
        let [lo, hi] = f.heights;
        if lo >= hi {
            continue;
        }
        f.nodes.iter().for_each(|&n| out.node[n] = true);
        match f.outer {
            Some(top) => {
                out.edge = out.edge.max(top);
                f.nodes.iter().for_each(|&n| out.outer[n] = true);
            }
            None => widen(&mut out.sloping, f.heights),
        }
        if !part.is_empty() {
            widen(&mut out.upright, f.heights);
        }
    }
    let apart = Apart::of(
        found
            .iter()
            .filter(|f| f.outer.is_none())
            .map(|f| (f.heights, f.apart)),
        out.sloping,
        options.stepover,
    );
    out.near = around(grid, &out.node, OVERLAP * options.stepover);
    if out.sloping[0] < out.sloping[1] {
        let more = (0..grid.len())
            .filter(|&n| out.near[n] && !out.node[n] && grid.kind[n] == NodeKind::Ground)
            .map(|n| grid.center_z[n]);
        for z in more {
            widen(&mut out.sloping, [z, z]);
        }
    }
    out.heights = heights(out.sloping, &apart);
    out
}

/// Heights at which walls that cusps stand on are cut, rising from almost a pass above the foot of the lowest: along the foot run a
/// pencil pass or one on the border, and a height that is nearly theirs would be met in bits.
fn heights([lo, hi]: [f64; 2], apart: &Apart) -> Vec<f64> {
    let mut out = Vec::new();
    if lo < hi && apart.flat > 0.0 {
        let mut z = lo + ABOVE_FOOT * apart.above(lo);
        while z <= hi {
            out.push(z);
            z += apart.above(z);
        }
    }
    out
}

/// How far apart in height the passes on a wall may be: by its slope and its curvature from above down. A wall at 75 degrees takes
/// passes 3 per cent closer than an upright one, one that bulges with a radius of seven balls another 7.
#[derive(Clone, Debug, Default)]
struct Apart {
    lowest: f64,
    /// Height of a band, mm.
    band: f64,
    /// By band, mm.
    step: Vec<f64>,
    /// Where nothing is known, mm.
    flat: f64,
}

/// Passes are no closer than this share of the stepover; what bulges more is filled.
const CLOSEST: f64 = 0.6;
/// Steps are told apart so finely, between [`CLOSEST`] and 1.
const GRADES: usize = 32;
/// Share of a band that may take closer passes than the band gets.
const LEFT_OUT: f64 = 0.01;
/// Bands are this share of a stepover high, unless there would be more than so many.
const BAND: f64 = 0.25;
const BANDS: f64 = 1e5;

impl Apart {
    fn of(
        edges: impl Iterator<Item = ([f64; 2], f64)>,
        [lo, hi]: [f64; 2],
        stepover: f64,
    ) -> Apart {
        let mut out = Apart {
            lowest: lo,
            band: (BAND * stepover).max((hi - lo) / BANDS),
            step: Vec::new(),
            flat: stepover,
        };
        if !(lo < hi && out.band > 0.0) {
            return out;
        }
        let bands = ((hi - lo) / out.band) as usize + 1;
        let mut counts = vec![[0u32; GRADES]; bands];
        for (heights, apart) in edges {
            let share = (apart / stepover - CLOSEST) / (1.0 - CLOSEST);
            let grade = ((share * GRADES as f64).max(0.0) as usize).min(GRADES - 1);
            let [a, b] = heights.map(|z| (((z - lo) / out.band).max(0.0) as usize).min(bands - 1));
            counts[a..=b].iter_mut().for_each(|c| c[grade] += 1);
        }
        out.step = counts
            .iter()
            .map(|c| {
                let allowed = (LEFT_OUT * f64::from(c.iter().sum::<u32>())) as u32;
                let mut sum = 0;
                let grade = c.iter().position(|n| {
                    sum += n;
                    sum > allowed
                });
                let share = grade.unwrap_or(GRADES) as f64 / GRADES as f64;
                stepover * (CLOSEST + (1.0 - CLOSEST) * share)
            })
            .collect();
        out
    }

    /// Height from a pass to the next one above, mm.
    fn above(&self, z: f64) -> f64 {
        let band = |z: f64| ((z - self.lowest) / self.band).max(0.0) as usize;
        if self.step.is_empty() {
            return self.flat;
        }
        let last = self.step.len() - 1;
        let (from, to) = (band(z).min(last), band(z + self.flat).min(last));
        self.step[from..=to]
            .iter()
            .copied()
            .fold(self.flat, f64::min)
    }
}

/// The lowest pass is so many passes above the foot.
const ABOVE_FOOT: f64 = 0.9;

/// Passes at constant height go on for so many stepovers beyond a wall.
const OVERLAP: f64 = 1.0;

/// Some nodes, and those no further from them than this over the surface, mm.
fn around(grid: &ToolCentreGrid, nodes: &[bool], reach: f64) -> Vec<bool> {
    let mut near = nodes.to_vec();
    let mut left = vec![0.0f32; grid.len()];
    let mut front: Vec<usize> = (0..nodes.len()).filter(|&n| nodes[n]).collect();
    front.iter().for_each(|&n| left[n] = reach as f32);
    // What is left of the way only rises; a front after so many rounds has no way left.
    while !front.is_empty() {
        let mut next = Vec::new();
        for &i in &front {
            for d in RING {
                let Some(j) = grid.neighbour(i, d) else {
                    continue;
                };
                let length = (grid.center(j) - grid.center(i)).norm();
                let rest = left[i] - length as f32;
                if grid.kind[j] == NodeKind::Ground && rest > 0.0 && rest > left[j] + 1e-4 {
                    left[j] = rest;
                    near[j] = true;
                    next.push(j);
                }
            }
        }
        front = next;
    }
    near
}

impl Steep {
    /// A height of the ball's centre counted in passes on walls: 2.5 is half way between the third and the fourth from below. `None`
    /// where there are none.
    pub fn passes_below(&self, z: f64) -> Option<f64> {
        let h = &self.heights;
        let (first, last) = (h.first()?, h.last()?);
        let k = h.partition_point(|l| *l <= z);
        Some(if k == 0 {
            (z - first) / self.options.stepover
        } else if k == h.len() {
            (k - 1) as f64 + (z - last) / self.options.stepover
        } else {
            (k - 1) as f64 + (z - h[k - 1]) / (h[k] - h[k - 1])
        })
    }

    /// How many passes at constant height there are.
    pub fn count(&self) -> usize {
        self.heights.len()
    }

    /// Where a level curve of a feature runs along a wall for more than two stepovers, up or down or along: the wall has passes of its
    /// own.
    pub fn along(&self, grid: &ToolCentreGrid, curve: &LevelCurve) -> Vec<bool> {
        let n = curve.at.len();
        // A wall that ends at the outline goes as far as the curve does.
        let on =
            |node: u32| self.node[node as usize] || grid.kind[node as usize] != NodeKind::Ground;
        let mut out: Vec<bool> = curve
            .at
            .iter()
            .map(|e| (self.node[e.a as usize] || self.node[e.b as usize]) && on(e.a) && on(e.b))
            .collect();
        if !out.contains(&true) {
            return out;
        }
        let stepover = self.options.stepover;
        let at: Vec<Option<Point2>> = curve.at.iter().map(|e| Some(e.xy(grid))).collect();
        bridge(&mut out, &at, curve.closed, stepover);
        let height = |k: usize| curve.at[k].value(|n| grid.center_z[n].max(self.options.floor));
        // A leap is no way along a wall, however high.
        let gap = |a: usize, b: usize| {
            let d: Vector2 = curve.at[b].xy(grid) - curve.at[a].xy(grid);
            d.norm()
                .hypot((height(b) - height(a)).abs().min(LEAP_COUNTS * stepover))
        };
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
                    length += gap(last, i);
                }
                run.push(i);
            } else {
                // At the end of a curve there is nothing beyond the wall to go on to, however short the way.
                let ends = !curve.closed && (run.contains(&0) || run.contains(&(n - 1)));
                if length < 2.0 * stepover && !ends {
                    run.iter().for_each(|&i| out[i] = false);
                }
                run.clear();
                length = 0.0;
            }
        }
        out
    }
}

/// A step of a curve from one edge of the grid to the next counts as no higher than this many stepovers.
const LEAP_COUNTS: f64 = 0.7;

/// Keeps what lies in short gaps (mm) between two kept places of a curve, unless there is no place at all in the gap.
pub(in crate::toolpath) fn bridge(
    kept: &mut [bool],
    at: &[Option<Point2>],
    closed: bool,
    longest: f64,
) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_gaps_are_bridged_and_long_ones_are_not() {
        let at: Vec<Option<Point2>> = (0..8)
            .map(|k| Some(Point2::new(f64::from(k), 0.0)))
            .collect();
        let mut kept = [true, false, true, false, false, false, true, false];
        bridge(&mut kept, &at, false, 2.5);
        assert_eq!(kept, [true, true, true, false, false, false, true, false]);
        let mut holed = at.clone();
        holed[1] = None;
        let mut kept = [true, false, true, false, false, false, true, false];
        bridge(&mut kept, &holed, false, 2.5);
        assert!(!kept[1]);
    }
}
