//! Which nodes of a grid stand on a wall, and between what heights walls run.

use super::{Uprights, WallOptions, rolls};
use crate::field::LevelCurve;
use crate::geom::{Point2, Vector2};
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// Which nodes stand on a wall, and what heights of the ball's centre that takes.
#[derive(Clone, Debug)]
pub struct Steep {
    /// By node.
    pub node: Vec<bool>,
    /// By node: an upright wall goes down from the outline here.
    pub(super) outer: Vec<bool>,
    /// Lowest and highest centre on walls inside the outline.
    pub(super) sloping: [f64; 2],
    /// The same of walls that may be upright: those around the outline of a closed solid among them.
    pub(super) upright: [f64; 2],
    /// The highest edge from which a wall goes down around the outline; -inf without.
    pub(super) edge: f64,
    pub(super) options: WallOptions,
}

const OWN: [(i32, i32); 3] = [(1, 0), (1, 1), (0, 1)];

/// One edge of the grid that stands on a wall.
struct Found {
    nodes: [usize; 2],
    heights: [f64; 2],
    /// Top of the wall that goes down from the outline here.
    outer: Option<f64>,
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
                        let steep = c.z.abs() > slope * c.xy().norm()
                            && !rolls([a, b], [grid.point[i], grid.point[j]], grid.radius);
                        steep.then(|| Found {
                            nodes: [i, j],
                            heights: [a.z.min(b.z), a.z.max(b.z)],
                            outer: None,
                        })
                    }
                }
            })
        })
        .collect();
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let mut out = Steep {
        node: vec![false; grid.len()],
        outer: vec![false; grid.len()],
        sloping: none,
        upright: none,
        edge: f64::NEG_INFINITY,
        options: *options,
    };
    let widen = |range: &mut [f64; 2], [lo, hi]: [f64; 2]| {
        *range = [range[0].min(lo), range[1].max(hi)];
    };
    for f in found {
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
    out
}

impl Steep {
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
                if length < 2.0 * stepover {
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
pub(super) fn bridge(kept: &mut [bool], at: &[Option<Point2>], closed: bool, longest: f64) {
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
