//! The closed loop: sweep the passes, find where the cusp stands over, add passes along its crests, again until clean.
//!
//! Cusps are judged against what this ball *can* reach ([`crate::sweep::Reachable`]), not against the ideal surface: facets, noise and tight
//! corners are the part's, not ours.

mod crests;
mod settle;
pub(in crate::toolpath) mod skeleton;
mod stroke;

use super::fit::{FitOptions, resample, smooth};
use super::pass::{Pass, PassKind, laid};
use super::wall::{WallOptions, laid_on_wall};
use crate::feature::Regions;
use crate::geom::{Point, Point2, Vector2};
use crate::reach::ToolCentreGrid;
use crate::sweep::reachable::NONE;
use crate::sweep::{ReachTiles, Reachable, Segment, Swept};
use crests::Crests;
use rayon::prelude::*;
use settle::settled;
use skeleton::middle_lines;
use stroke::strokes;

/// When and how far to fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillOptions {
    /// Height wanted, mm.
    pub scallop: f64,
    /// Fill where a cusp is over this share of it ...
    pub start: f64,
    /// ... along its crest for as long as it is over this share.
    pub keep: f64,
    /// Give up after this many rounds.
    pub rounds: usize,
}

/// What filling did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FillReport {
    /// Rounds gone through.
    pub rounds: usize,
    /// Passes added.
    pub added: usize,
    /// Their length, mm.
    pub length_mm: f64,
    /// Cells that still stand over when the last round was done.
    pub cells_left: usize,
}

/// Normals flatter than this (upright walls) are not judged in plan.
const UPRIGHT: f32 = 0.02;

/// Rounds in which rows of spots are looked for.
const STROKE_ROUNDS: usize = 2;
/// Rounds in which spots on steep walls are filled as walls are cut; what that leaves is filled like any other ground.
const WALL_ROUNDS: usize = 4;

/// Adds fill passes to `passes` until no cusp stands over, or the rounds are used up. All tiles are swept and looked at once; what stands
/// over, and the crest near it, is all that a later round can change, so only those cells are kept (40 bytes each) and swept again.
pub fn fill(
    grid: &ToolCentreGrid,
    regions: &Regions,
    reach: &ReachTiles,
    passes: &mut Vec<Pass>,
    options: &FillOptions,
    walls: &WallOptions,
    fitting: &FitOptions,
) -> FillReport {
    let cutter = reach.drop_cutter();
    let mut report = FillReport::default();
    let mut crests = Crests::new(reach, &segments(passes), options);
    let step = reach.lattice().step;
    loop {
        let (cells, over) = crests.standing(options);
        report.cells_left = over.len();
        if over.is_empty() || report.rounds == options.rounds {
            return report;
        }
        report.rounds += 1;
        // Rows of spots first; what they leave is looked at again. Specks that happen to lie in a row must not keep the rest waiting
        // until the rounds are used up.
        let rows = if report.rounds <= STROKE_ROUNDS {
            strokes(&over, crests.stepover / step)
        } else {
            Vec::new()
        };
        let steepest = walls.angle.cos();
        let mut strips: Vec<Vec<(Point, Vector2)>> = Vec::new();
        let curves: Vec<Vec<Point2>> = if rows.is_empty() {
            // Branches shorter than half a stepover are cut by the line they leave.
            middle_lines(&cells, ((0.5 * crests.stepover / step) as usize).max(3))
                .iter()
                .filter(|line| {
                    let at: Vec<(Point, Vector2)> = line
                        .iter()
                        .filter_map(|&(x, y)| crests.on_wall(x, y, steepest))
                        .collect();
                    let steep = report.rounds <= WALL_ROUNDS && 2 * at.len() > line.len();
                    if steep {
                        strips.push(along_wall(at, 0.3 * crests.stepover));
                    }
                    !steep
                })
                .map(|line| {
                    let curve: Vec<Point2> = line
                        .iter()
                        .filter_map(|&(x, y)| crests.center_over(x, y))
                        .collect();
                    let mut even = resample(&curve, false, 2.0 * step);
                    smooth(&mut even, false, 6);
                    drawn_out(even, 0.3 * crests.stepover)
                })
                .collect()
        } else {
            rows.iter().map(|row| crests.along(row)).collect()
        };
        let mut runs: Vec<Vec<(Vec<Point>, bool)>> = curves
            .par_iter()
            .map(|even| {
                settled(cutter, even, step)
                    .iter()
                    .flat_map(|piece| laid(cutter, piece, false, fitting))
                    .collect()
            })
            .collect();
        runs.par_extend(
            strips
                .par_iter()
                .map(|strip| laid_on_wall(cutter, strip, false, walls, fitting)),
        );
        let new = runs
            .into_iter()
            .flatten()
            .filter(|(points, _)| points.len() > 1)
            .map(|(points, closed)| Pass {
                kind: PassKind::Fill,
                feature: regions.feature_at(grid, &points[0].xy()),
                points,
                closed,
            });
        // Where a fill has been already, another does no more.
        let new: Vec<Pass> = new
            .filter(|p| !passes.iter().any(|q| again(p, q)))
            .collect();
        if new.is_empty() {
            // Nothing more from rows: next come the spots themselves. Nothing on walls: then as on other ground (over the outline of the
            // part the ball rolls as if on a wall).
            let tried = if !rows.is_empty() {
                STROKE_ROUNDS
            } else if !strips.is_empty() {
                WALL_ROUNDS
            } else {
                return report;
            };
            report.rounds = report.rounds.max(tried);
            continue;
        }
        crests.cut(&segments(&new));
        report.added += new.len();
        report.length_mm += new.iter().map(Pass::length).sum::<f64>();
        passes.extend(new);
    }
}

/// Places on a wall in the order of a line along it, drawn out like a dab where it is one.
fn along_wall(mut at: Vec<(Point, Vector2)>, shortest: f64) -> Vec<(Point, Vector2)> {
    let length: f64 = at.windows(2).map(|w| (w[1].0 - w[0].0).xy().norm()).sum();
    if length < shortest
        && let (Some(first), Some(last)) = (at.first().copied(), at.last().copied())
    {
        let across = Vector2::new(-first.1.y, first.1.x);
        let way = (last.0 - first.0).xy();
        let side = if way.dot(&across) < 0.0 {
            -across
        } else {
            across
        };
        let aside = |(p, out): (Point, Vector2), by: f64| {
            (Point::new(p.x + side.x * by, p.y + side.y * by, p.z), out)
        };
        let by = 0.5 * (shortest - length);
        at.insert(0, aside(first, -by));
        at.push(aside(last, by));
    }
    at
}

/// Is a fill as good as the same as another pass?
fn again(p: &Pass, q: &Pass) -> bool {
    const SAME: f64 = 1e-3;
    let near =
        |a: Option<&Point>, b: Option<&Point>| a.zip(b).is_some_and(|(a, b)| (a - b).norm() < SAME);
    q.kind == PassKind::Fill
        && near(p.points.first(), q.points.first())
        && near(p.points.last(), q.points.last())
        && (p.length() - q.length()).abs() < SAME
}

/// A dab becomes a stroke of at least this length, mm, the way it lies: a tool that only touches leaves a mark, and a pass of one point
/// cannot be entered along its way.
fn drawn_out(curve: Vec<Point2>, shortest: f64) -> Vec<Point2> {
    let (Some(&a), Some(&b)) = (curve.first(), curve.last()) else {
        return curve;
    };
    let length: f64 = curve.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    if length >= shortest {
        return curve;
    }
    let way = (b - a).try_normalize(1e-9).unwrap_or_else(Vector2::x);
    let middle = nalgebra::center(&a, &b);
    vec![
        middle - way * (0.5 * shortest),
        middle,
        middle + way * (0.5 * shortest),
    ]
}

/// Every straight piece of some passes; a pass of one point is a piece without length.
pub(super) fn segments(passes: &[Pass]) -> Vec<Segment> {
    let mut out = Vec::new();
    for p in passes {
        let run = p.run();
        match run.as_slice() {
            [one] => out.push(Segment {
                from: *one,
                to: *one,
            }),
            many => out.extend(many.windows(2).map(|w| Segment {
                from: w[0],
                to: w[1],
            })),
        }
    }
    out
}

/// The highest cusp (mm) that some passes leave at each node of the grid, by the place of the ball that could reach it; 0 where none was
/// judged. One sweep of every tile.
pub fn cusps_at_nodes(grid: &ToolCentreGrid, reach: &ReachTiles, passes: &[Pass]) -> Vec<f32> {
    let radius = reach.drop_cutter().radius();
    let segments = segments(passes);
    let touched = reach.touched(segments.iter());
    let found: Vec<Vec<(u32, f32)>> = (0..reach.len())
        .into_par_iter()
        .map(|k| {
            let r = reach.reach(k);
            let mine: Vec<Segment> = touched[k].iter().map(|&i| segments[i as usize]).collect();
            let mut swept = Swept::new(r.lattice);
            swept.cut_alone(&mine, radius);
            let mut out: Vec<(u32, f32)> = (0..r.lattice.len())
                .filter_map(|i| {
                    let cusp = cusp(&r, &swept, i, r.reach_z[i]);
                    let c = r.center_over(i);
                    (cusp > 0.0).then_some(())?;
                    Some((grid.nearest(c.x, c.y)? as u32, cusp as f32))
                })
                .collect();
            out.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
            out.dedup_by_key(|e| e.0);
            // There are several cells to a node: the room that they took would be as much as all else together.
            out.shrink_to_fit();
            out
        })
        .collect();
    let mut out = vec![0.0f32; grid.len()];
    for (n, cusp) in found.into_iter().flatten() {
        let v = &mut out[n as usize];
        *v = v.max(cusp);
    }
    out
}

/// What stands over a height at a cell, mm along the normal, to first order; -inf where it is not judged.
pub(super) fn cusp(r: &Reachable, swept: &Swept, i: usize, over: f64) -> f64 {
    if r.part_z[i].is_finite() && r.by[i][0] != NONE && r.normal_z[i] > UPRIGHT {
        (swept.z[i] - over) * f64::from(r.normal_z[i])
    } else {
        f64::NEG_INFINITY
    }
}

/// Cells that a crest is followed past the place that stands over: about a stepover.
pub fn far(stepover: f64, step: f64) -> i64 {
    (0.75 * stepover / step).ceil() as i64
}
