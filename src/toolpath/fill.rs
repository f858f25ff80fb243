//! The closed loop: sweep the passes, find where the cusp stands over, add passes along its crests, again until clean.
//!
//! Cusps are judged against what this ball *can* reach ([`Reachable`]), not against the ideal surface: facets, noise and tight
//! corners are the part's, not ours.

use super::fit::{FitOptions, resample, smooth};
use super::pass::{Pass, PassKind, laid};
use super::skeleton::middle_lines;
use crate::feature::Regions;
use crate::geom::Point2;
use crate::reach::{DropCutter, ToolCentreGrid};
use crate::sweep::{Reachable, Segment, Swept};
use rayon::prelude::*;

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

/// Adds fill passes to `passes` until no cusp stands over, or the rounds are used up. Each round costs a sweep of what it added and a
/// look at every cell.
pub fn fill(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    reach: &Reachable,
    passes: &mut Vec<Pass>,
    options: &FillOptions,
    fitting: &FitOptions,
) -> FillReport {
    let mut report = FillReport::default();
    let mut swept = Swept::new(reach.lattice);
    swept.cut(&segments(passes), cutter.radius());
    loop {
        let (cells, left) = standing(reach, &swept, options);
        report.cells_left = left;
        if left == 0 || report.rounds == options.rounds {
            return report;
        }
        report.rounds += 1;
        let lattice = &reach.lattice;
        // Branches shorter than half a stepover are cut by the line they leave.
        let stepover = (8.0 * options.scallop * cutter.radius()).sqrt();
        let lines = middle_lines(&cells, ((0.5 * stepover / lattice.step) as usize).max(3));
        let new: Vec<Vec<Pass>> = lines
            .par_iter()
            .map(|line| {
                let curve: Vec<Point2> = line
                    .iter()
                    .map(|&(x, y)| {
                        let by = reach.by[lattice.index(x as usize, y as usize)];
                        lattice.center_at(by as usize)
                    })
                    .collect();
                let mut even = resample(&curve, false, 2.0 * lattice.step);
                smooth(&mut even, false, 6);
                laid(cutter, &even, false, fitting)
                    .into_iter()
                    .map(|(points, closed)| {
                        let feature = grid
                            .nearest(points[0].x, points[0].y)
                            .map(|n| regions.label[n])
                            .filter(|l| *l > 0)
                            .map(|l| l as usize - 1);
                        Pass {
                            kind: PassKind::Fill,
                            feature,
                            points,
                            closed,
                        }
                    })
                    .collect()
            })
            .collect();
        let new: Vec<Pass> = new.into_iter().flatten().collect();
        if new.is_empty() {
            return report;
        }
        swept.cut(&segments(&new), cutter.radius());
        report.added += new.len();
        report.length_mm += new.iter().map(Pass::length).sum::<f64>();
        passes.extend(new);
    }
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

/// The cells to fill along (standing over `keep`, near one standing over `start`), and how many stand over `start`.
fn standing(reach: &Reachable, swept: &Swept, options: &FillOptions) -> (Vec<(i64, i64)>, usize) {
    let lattice = &reach.lattice;
    let (nx, ny) = (lattice.nx, lattice.ny);
    let cusp = |i: usize| -> f64 {
        let judged =
            reach.part_z[i].is_finite() && reach.by[i] != u32::MAX && reach.normal_z[i] > UPRIGHT;
        if judged {
            (swept.z[i] - reach.reach_z[i]) * f64::from(reach.normal_z[i])
        } else {
            f64::NEG_INFINITY
        }
    };
    let (start, keep) = (
        options.start * options.scallop,
        options.keep * options.scallop,
    );
    let seeds: Vec<usize> = (0..lattice.len())
        .into_par_iter()
        .filter(|&i| cusp(i) > start)
        .collect();
    // A crest is followed about one stepover past the place that stands over.
    let stepover = (8.0 * options.scallop * reach.radius).sqrt();
    let far = (0.75 * stepover / lattice.step).ceil() as i64;
    let mut near = vec![false; lattice.len()];
    for &i in &seeds {
        let (x, y) = lattice.cell(i);
        for v in -far..=far {
            let yy = y as i64 + v;
            if yy < 0 || yy >= ny as i64 {
                continue;
            }
            let half = ((far * far - v * v) as f64).sqrt() as i64;
            let lo = (x as i64 - half).max(0) as usize;
            let hi = ((x as i64 + half).min(nx as i64 - 1)) as usize;
            near[yy as usize * nx + lo..=yy as usize * nx + hi].fill(true);
        }
    }
    let mask: Vec<bool> = near
        .par_iter()
        .enumerate()
        .map(|(i, n)| *n && cusp(i) > keep)
        .collect();
    // Only what hangs together with a place that stands over.
    let mut seen = vec![false; lattice.len()];
    let mut queue = seeds.clone();
    queue.iter().for_each(|&i| seen[i] = true);
    let mut k = 0;
    while k < queue.len() {
        let (x, y) = lattice.cell(queue[k]);
        k += 1;
        for v in -1..=1i64 {
            for u in -1..=1i64 {
                let (a, b) = (x as i64 + u, y as i64 + v);
                if a < 0 || b < 0 || a >= nx as i64 || b >= ny as i64 {
                    continue;
                }
                let j = b as usize * nx + a as usize;
                if mask[j] && !seen[j] {
                    seen[j] = true;
                    queue.push(j);
                }
            }
        }
    }
    queue.sort_unstable();
    let cells = queue
        .into_iter()
        .map(|i| ((i % nx) as i64, (i / nx) as i64))
        .collect();
    (cells, seeds.len())
}
