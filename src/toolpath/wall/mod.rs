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
//! tip no lower than that. The wall above a ball that goes deep is touched by the flutes: what lies deeper than they are long stays
//! standing, and is named and measured.
//!
//! ```text
//! steep:   which nodes stand on a wall        upright:  the upright triangles, asked in plan
//! cross:   where a height is crossed          stack:    runs of crossings, joined from height to height
//! ```
//!
//! Crosses the border: the grid and the part's triangles in, [`Pass`]es of ball centres (of no feature yet) and refusals out; work
//! coordinates, mm.

mod cross;
mod stack;
mod steep;
mod upright;

pub use steep::{Steep, steep};
pub use upright::Uprights;

pub(in crate::toolpath) use cross::BRIDGED;
pub(in crate::toolpath) use stack::{laid_on_wall, moved_out};
pub(in crate::toolpath) use steep::bridge;

use super::fit::FitOptions;
use super::pass::{Pass, PassKind};
use crate::field::level_curves;
use crate::geom::Point;
use crate::reach::{Crease, DropCutter, NodeKind, ToolCentreGrid};
use cross::{Cross, Level, Runs, crossings};
use rayon::prelude::*;
use stack::{Joining, laid_at_height, stacked};

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

impl WallOptions {
    /// Upright walls are looked at in steps of this height, mm.
    fn step(&self) -> f64 {
        // Twice along the flutes, so that a wall under a sloping top is cut with most of their length.
        if self.at_once() {
            0.5 * self.flute
        } else {
            let passes = (self.deepest / self.stepover).floor().max(1.0);
            passes * self.stepover
        }
    }

    /// Whether an upright wall is cut by the deepest pass that the flutes allow, and no other.
    fn at_once(&self) -> bool {
        self.deepest >= self.flute
    }
}

/// A wall that the flutes do not reach down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooDeep {
    /// On the wall, at the foot of what would have to be cut.
    pub place: Point,
    /// Flutes it would take, mm.
    pub needs: f64,
}

/// What becomes of the walls of a part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walls {
    /// Passes, of no feature.
    pub passes: Vec<Pass>,
    /// Walls left standing because the flutes are too short for them: the deepest place of each.
    pub too_deep: Vec<TooDeep>,
    /// Area of upright wall between the lowest pass on it and where the lowest would be with flutes as long as it takes, mm2.
    pub uncut: f64,
}

/// The ball rolls over an edge where its contact moves less than this share of its centre's way; and the edge is sharp, and none between
/// the facets of a curve, where it turns by more than this meanwhile, rad.
const ROLLING: (f64, f64) = (0.3, 0.12);
/// A ball touches an upright wall when it is this near, mm.
const TOUCH: f64 = 0.005;
/// A longer fall over a bisected edge is a leap, mm.
const LEAP: f64 = 0.01;
/// Centre height of air, for comparing: below everything.
const AIR: f64 = -1e9;
/// Runs at constant height that make one pass fewer than this many stepovers long cost more to reach than they cut.
pub(in crate::toolpath) const SHORTEST: f64 = 4.0;

/// Does the ball roll over a sharp edge from one of two centres to the other, with these contacts?
fn rolls(centers: [Point; 2], contacts: [Point; 2], radius: f64) -> bool {
    let [a, b] = centers;
    let [p, q] = contacts;
    let turned = ((b - q) - (a - p)).norm() / radius;
    (q - p).norm() < ROLLING.0 * (b - a).norm() && turned > ROLLING.1
}

/// Constant-height passes down all walls; upright ones by the flutes, with one along the top of each where that takes more than one.
/// Neighbours are joined where the way from one to the next is free. All cores; the order does not depend on them.
pub fn walls(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    part: &Uprights,
    steep: &Steep,
    leaps: &[Crease],
    fitting: &FitOptions,
) -> Walls {
    let o = &steep.options;
    let mut out = Walls::default();
    let mut lay = |levels: &[Level], first: Vec<Runs>, joining: &Joining| {
        let zs: Vec<f64> = levels.iter().map(|l| l.z).collect();
        let value = |n: usize| grid.center_z[n].max(AIR);
        let curves = level_curves(grid, &value, &zs);
        let found: Vec<(usize, Runs)> = curves
            .par_iter()
            .map(|c| {
                (
                    c.level,
                    crossings(grid, cutter, part, steep, c, Some(&levels[c.level])),
                )
            })
            .collect();
        // From above down.
        let mut by_level: Vec<Vec<(Vec<Cross>, bool)>> = vec![Vec::new(); levels.len() + 1];
        for runs in first {
            by_level[0].extend(runs.runs);
        }
        for (level, runs) in found {
            out.too_deep.extend(runs.too_deep);
            out.uncut += runs.refused * levels[level].strip;
            by_level[levels.len() - level].extend(runs.runs);
        }
        let fitted: Vec<Vec<(Vec<Point>, bool)>> = by_level
            .into_par_iter()
            .map(|runs| {
                runs.into_iter()
                    .flat_map(|(run, closed)| laid_at_height(cutter, &run, closed, o, fitting))
                    .collect()
            })
            .collect();
        let stacks = stacked(cutter, fitted, joining, fitting);
        out.passes.extend(stacks.into_iter().map(|points| Pass {
            kind: PassKind::Wall,
            feature: None,
            points,
            closed: false,
        }));
    };
    lay(
        &sloping_levels(steep),
        Vec::new(),
        &Joining {
            stepover: o.stepover,
            fall: 1.5 * o.stepover,
            rims: false,
        },
    );
    let deep = upright_levels(steep, grid.radius);
    if !deep.is_empty() {
        let first = tops(grid, cutter, part, steep, leaps);
        lay(
            &deep,
            first,
            &Joining {
                stepover: o.stepover,
                fall: 1.5 * o.step().max(o.stepover),
                rims: true,
            },
        );
    }
    out.passes.retain(|p| p.length() > SHORTEST * o.stepover);
    out
}

/// The heights at which walls that cusps stand on are cut.
fn sloping_levels(steep: &Steep) -> Vec<Level> {
    steep
        .heights
        .iter()
        .map(|&z| Level {
            z,
            uprights: false,
            next: f64::NEG_INFINITY,
            strip: 0.0,
        })
        .collect()
}

/// Heights at which upright walls are cut, rising: from the floor of a closed solid in steps; where the flutes cut at once, from as deep
/// as they reach below the highest edge, so that one pass goes all round.
fn upright_levels(steep: &Steep, radius: f64) -> Vec<Level> {
    let o = &steep.options;
    let ([lo, hi], step) = (steep.upright, o.step());
    if lo >= hi || step <= 0.0 {
        return Vec::new();
    }
    let base = o.floor + radius;
    let from = if o.at_once() {
        base.max(steep.edge - o.flute + radius + 1e-6)
    } else {
        base
    };
    let lowest = lo.max(base);
    let mut z = from - ((from - lowest) / step).floor().max(0.0) * step;
    let mut heights = Vec::new();
    // A last one on the floor, where the steps do not end there.
    if z - base > 1e-6 && lo <= base {
        heights.push(base);
    }
    while z < hi {
        heights.push(z);
        z += step;
    }
    (0..heights.len())
        .map(|k| Level {
            z: heights[k],
            uprights: true,
            next: k.checked_sub(1).map_or(f64::NEG_INFINITY, |b| heights[b]),
            strip: heights.get(k + 1).copied().unwrap_or(hi) - heights[k],
        })
        .collect()
}

/// The upper rims of upright walls: of leaps inside the ground, and of the outline of closed solids.
fn tops(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    part: &Uprights,
    steep: &Steep,
    leaps: &[Crease],
) -> Vec<Runs> {
    let value = |n: usize| f64::from(u8::from(grid.kind[n] != NodeKind::Air));
    // Around the outline the passes over the top run on beyond it.
    let outline = if steep.options.at_once() {
        Vec::new()
    } else {
        level_curves(grid, &value, &[0.5])
    };
    let mut out: Vec<Runs> = outline
        .par_iter()
        .map(|c| crossings(grid, cutter, part, steep, c, None))
        .collect();
    for c in leaps {
        let found: Vec<Option<Cross>> = c
            .points
            .iter()
            .map(|p| {
                let z = p.center.z + p.rise - 2.0 * LEAP;
                let tall = p.rise > 0.5 * steep.options.stepover;
                (tall && part.touches(&p.center.xy(), z)).then_some(Cross {
                    at: p.center.xy(),
                    out: p.out,
                    z,
                    leap: true,
                })
            })
            .collect();
        out.push(Runs {
            runs: cross::split(&found, c.closed),
            ..Runs::default()
        });
    }
    out
}

#[cfg(test)]
mod tests;
