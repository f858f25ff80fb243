//! What a layout would take, from its field alone: which side of the part to begin at, and at what angle to lay a raster, are decided
//! on a coarse copy of the grid, without dropping a ball.

use super::layout::{Bench, PLAN_SHARES, flat_stepover};
use super::plan::Strategy;
use crate::feature::{Regions, Source, sources};
use crate::field::{Metric, Ruler, level_curves};
use crate::geom::Vector2;
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// Nodes of the coarse grid at most.
const NODES: usize = 300_000;
/// Angles of a raster that are tried.
const ANGLES: usize = 24;
/// What a branch costs: a way back to where the passes parted, s.
const BRANCH: f64 = 2.0;

/// The source from which the whole part is cut soonest (the first on a tie).
pub(super) fn best_source(bench: &Bench) -> Source {
    let grid = coarser(&bench.ground.grid);
    let spaced_for = PLAN_SHARES[0] * bench.options.scallop;
    let metric = Metric::new(&grid, Ruler::IsoScallop, spaced_for);
    let all = sources(&grid);
    let times: Vec<f64> = all
        .par_iter()
        .map(|s| {
            let how = crate::feature::GrowOptions {
                ruler: Ruler::IsoScallop,
                passes_min: 2.0,
                margin: 5.0,
                over_share: 0.005,
            };
            let regions = crate::feature::whole(&grid, &metric, &metric, s, &how);
            time(bench, &grid, &metric, &regions)
        })
        .collect();
    let best = (0..all.len()).reduce(|a, b| if times[b] < times[a] { b } else { a });
    // The same source on the fine grid, by name.
    let fine = sources(&bench.ground.grid);
    best.and_then(|k| fine.iter().find(|s| s.name == all[k].name))
        .or(fine.first())
        .cloned()
        .unwrap_or(Source {
            name: "nowhere".to_string(),
            nodes: Vec::new(),
            front: crate::field::Front::Round,
        })
}

/// The angle (degrees, 0 to 180) at which plane sections of the widest allowed step are shortest.
pub(super) fn best_raster_angle(bench: &Bench) -> f64 {
    let grid = coarser(&bench.ground.grid);
    let metric = Metric::new(&grid, Ruler::IsoScallop, bench.options.scallop);
    let angles: Vec<f64> = (0..ANGLES)
        .map(|k| 180.0 * k as f64 / ANGLES as f64)
        .collect();
    let length: Vec<f64> = angles
        .par_iter()
        .map(|&a| raster_length(&grid, &metric, a))
        .collect();
    (0..ANGLES)
        .reduce(|a, b| if length[b] < length[a] { b } else { a })
        .map_or(0.0, |k| angles[k])
}

/// Length of a raster, mm: area over step, stretched by the climb along the passes; the step is the widest that leaves no cusp over
/// the wanted one but at a thousandth of the nodes.
fn raster_length(grid: &ToolCentreGrid, metric: &Metric, angle: f64) -> f64 {
    let Ruler::Isoplanar(across) = Strategy::Raster(Some(angle)).ruler() else {
        return f64::INFINITY;
    };
    let along = Vector2::new(across.y, -across.x);
    let mut steps: Vec<f64> = Vec::new();
    let mut climb = 0.0;
    for i in (0..grid.len()).filter(|&i| grid.kind[i] == NodeKind::Ground) {
        let m = &metric.tensor[i];
        let det = m[0] * m[2] - m[1] * m[1];
        let dual = (m[2] * across.x * across.x - 2.0 * m[1] * across.x * across.y
            + m[0] * across.y * across.y)
            / det;
        if dual.is_finite() && dual > 0.0 {
            steps.push(dual.sqrt());
            let s = slope(grid, i).dot(&along);
            climb += (1.0 + s * s).sqrt();
        }
    }
    if steps.is_empty() {
        return f64::INFINITY;
    }
    let k = steps.len() / 1000;
    let (_, step, _) = steps.select_nth_unstable_by(k, f64::total_cmp);
    climb * grid.step * grid.step / *step
}

/// About how long the passes of some regions take, s.
fn time(bench: &Bench, grid: &ToolCentreGrid, metric: &Metric, regions: &Regions) -> f64 {
    let stepover = flat_stepover(bench.options.scallop, grid.radius);
    let feed = bench.links.feed;
    let turn = 1.6 * stepover / feed + 0.5 * feed / bench.links.acceleration;
    let mut sum = 0.0;
    for f in &regions.features {
        let value = |n: usize| f.field.at(grid, n);
        let mut pieces = vec![0usize; f.levels.len()];
        for c in level_curves(grid, &value, &f.levels) {
            pieces[c.level] += 1;
            let z = |n: usize| grid.center_z[n];
            let at: Vec<_> = c.at.iter().map(|e| (e.xy(grid), e.value(z))).collect();
            let length: f64 = at
                .windows(2)
                .map(|w| {
                    let flat = (w[1].0 - w[0].0).norm();
                    let rise = w[1].1 - w[0].1;
                    if rise.is_finite() {
                        flat.hypot(rise)
                    } else {
                        flat
                    }
                })
                .sum();
            sum += length / feed + turn;
        }
        let branches: usize = pieces.windows(2).map(|w| w[0].abs_diff(w[1])).sum();
        sum += BRANCH * branches as f64;
        // Where fronts meet, a stroke is needed.
        let meets = (0..grid.len())
            .filter(|&i| grid.kind[i] == NodeKind::Ground && meets(grid, metric, &value, i))
            .count();
        sum += meets as f64 / 3.0 * grid.step / feed;
    }
    sum
}

/// Whether the field rises by much less than its metric says.
fn meets(grid: &ToolCentreGrid, metric: &Metric, value: &dyn Fn(usize) -> f64, i: usize) -> bool {
    let v = |d| grid.neighbour(i, d).map(value).filter(|v| v.is_finite());
    let (Some(e), Some(w), Some(n), Some(s)) = (v((1, 0)), v((-1, 0)), v((0, 1)), v((0, -1)))
    else {
        return false;
    };
    let (gx, gy) = ((e - w) / (2.0 * grid.step), (n - s) / (2.0 * grid.step));
    let m = &metric.tensor[i];
    let det = m[0] * m[2] - m[1] * m[1];
    value(i) > 2.0 && (m[2] * gx * gx - 2.0 * m[1] * gx * gy + m[0] * gy * gy) / det < 0.64
}

/// Slope of the centre surface; zero where it is not known.
fn slope(grid: &ToolCentreGrid, i: usize) -> Vector2 {
    let n = grid.center(i) - grid.point[i];
    if n.z > 0.05 * grid.radius {
        Vector2::new(-n.x / n.z, -n.y / n.z)
    } else {
        Vector2::zeros()
    }
}

/// Every k-th node of a grid, so that few enough are left. Border crossings are left out.
fn coarser(grid: &ToolCentreGrid) -> ToolCentreGrid {
    let k = ((grid.len() as f64 / NODES as f64).sqrt().ceil() as usize).max(1);
    let (nx, ny) = (grid.nx.div_ceil(k), grid.ny.div_ceil(k));
    let fine = |i: usize| (i / nx) * k * grid.nx + (i % nx) * k;
    ToolCentreGrid {
        origin: grid.origin,
        step: grid.step * k as f64,
        nx,
        ny,
        radius: grid.radius,
        kind: (0..nx * ny).map(|i| grid.kind[fine(i)]).collect(),
        center_z: (0..nx * ny).map(|i| grid.center_z[fine(i)]).collect(),
        point: (0..nx * ny).map(|i| grid.point[fine(i)]).collect(),
        crossings: Vec::new(),
    }
}
