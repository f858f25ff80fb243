//! What a layout would take, from its field alone: which side of the part to begin at, and at what angle to lay a raster, are decided
//! on a coarse copy of the grid, without dropping a ball.

use super::Strategy;
use super::lay::PLAN_SHARES;
use super::layout::{Bench, flat_stepover};
use crate::feature::source::nodes;
use crate::feature::{Feature, FeatureKind, Regions, Source, sources};
use crate::field::{Metric, Ruler, level_curves};
use crate::geom::{Point2, Vector2};
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// Nodes of the coarse grid at most.
const NODES: usize = 80_000;
/// Angles of a raster that are tried.
const ANGLES: usize = 24;
/// What a branch costs: a way back to where the passes parted, s.
const BRANCH: f64 = 2.0;

/// The sources of the whole part, the one from which it is cut soonest first (ties in their own order), and about how long each takes, s.
pub(in crate::toolpath) fn best_sources(bench: &Bench) -> Vec<(Source, f64)> {
    let (grid, _) = coarser(&bench.ground.grid);
    let spaced_for = PLAN_SHARES[0] * bench.options.scallop;
    let metric = Metric::new(&grid, Ruler::IsoScallop, spaced_for);
    let mut all: Vec<(Source, f64)> = sources(&grid)
        .into_par_iter()
        .map(|s| {
            let how = crate::feature::GrowOptions {
                ruler: Ruler::IsoScallop,
                passes_min: 2.0,
                margin: 5.0,
                over_share: 0.005,
                persistence: 0.0,
            };
            let regions = crate::feature::whole(&grid, &metric, &metric, &s, &how);
            let time = time(bench, &grid, &metric, &regions);
            (s, time)
        })
        .collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    // The same sources on the fine grid, by name.
    let fine = sources(&bench.ground.grid);
    let mut out: Vec<(Source, f64)> = all
        .into_iter()
        .filter_map(|(s, t)| Some((fine.iter().find(|f| f.name == s.name)?.clone(), t)))
        .collect();
    if out.is_empty() {
        out.push((
            fine.into_iter().next().unwrap_or(Source {
                name: "nowhere".to_string(),
                nodes: Vec::new(),
                front: crate::field::Front::Round,
            }),
            f64::INFINITY,
        ));
    }
    out
}

/// The angle (degrees, 0 to 180) at which plane sections of the widest allowed step are shortest.
pub(in crate::toolpath) fn best_raster_angle(bench: &Bench) -> f64 {
    let (grid, _) = coarser(&bench.ground.grid);
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

/// About how long the passes of one feature take, trimmed to its ground, s; the turns between them weigh `turns` times what they take.
pub(in crate::toolpath) fn feature_time(
    turns: f64,
    bench: &Bench,
    grid: &ToolCentreGrid,
    metric: &Metric,
    f: &Feature,
) -> f64 {
    let stepover = flat_stepover(bench.options.scallop, grid.radius);
    let feed = bench.links.feed;
    let turn = turns * (1.6 * stepover / feed + 0.5 * feed / bench.links.acceleration);
    // A way back is about as long as the feature is wide.
    let branch = (0.5 * f.area_mm2.max(0.0).sqrt() / feed).min(BRANCH);
    let value = |n: usize| f.field.at(grid, n);
    let free = |n: usize| {
        let v = f.free.at(grid, n);
        if v.is_finite() { v } else { -1.0 }
    };
    let mut pieces = vec![0usize; f.levels.len()];
    let mut sum = 0.0;
    for c in level_curves(grid, &value, &f.levels) {
        let at: Vec<(Point2, f64, bool)> =
            c.at.iter()
                .map(|e| {
                    let ground = [e.a, e.b]
                        .iter()
                        .any(|n| grid.kind[*n as usize] == NodeKind::Ground);
                    let z = e.value(|n| grid.center_z[n]);
                    (e.xy(grid), z, ground && e.value(free) >= 0.0)
                })
                .collect();
        let n = at.len();
        let whole = c.closed && at.iter().all(|a| a.2);
        let steps = if c.closed { n } else { n.saturating_sub(1) };
        let mut length = 0.0;
        for i in 0..steps {
            let (p, q) = (&at[i], &at[(i + 1) % n]);
            if p.2 && q.2 {
                let rise = q.1 - p.1;
                let flat = (q.0 - p.0).norm();
                length += if rise.is_finite() {
                    flat.hypot(rise)
                } else {
                    flat
                };
            } else if p.2 != q.2 {
                length += 0.5 * (q.0 - p.0).norm();
            }
        }
        // A run begins wherever it is entered.
        let entered = (0..n)
            .filter(|&i| {
                at[i].2
                    && (if i > 0 {
                        !at[i - 1].2
                    } else {
                        !c.closed || !at[n - 1].2
                    })
            })
            .count();
        sum += length / feed;
        if whole {
            // A turn of a spiral.
            pieces[c.level] += 1;
        } else {
            pieces[c.level] += entered;
            sum += turn * entered as f64;
        }
    }
    let branches: usize = pieces.windows(2).map(|w| w[0].abs_diff(w[1])).sum();
    sum += branch * branches as f64;
    let meeting = nodes(grid, f)
        .filter(|&i| {
            grid.kind[i] == NodeKind::Ground
                && free(i) >= 0.0
                && value(i) <= f.rim
                && meets(grid, metric, &value, i)
        })
        .count();
    // A face is cut where its fronts meet in bits, each with a way to it.
    let bits = if f.kind == FeatureKind::Face {
        BITS
    } else {
        1.0
    };
    sum + bits * meeting as f64 / 3.0 * grid.step / feed
}

/// Where the fronts of a face meet, fills and the ways to them are so many times as long as the line they meet in.
const BITS: f64 = 3.0;

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

/// Every k-th node of a grid, so that few enough are left, and k. Border crossings are left out.
pub(in crate::toolpath) fn coarser(grid: &ToolCentreGrid) -> (ToolCentreGrid, usize) {
    let k = ((grid.len() as f64 / NODES as f64).sqrt().ceil() as usize).max(1);
    let (nx, ny) = (grid.nx.div_ceil(k), grid.ny.div_ceil(k));
    let fine = |i: usize| (i / nx) * k * grid.nx + (i % nx) * k;
    let coarse = ToolCentreGrid {
        origin: grid.origin,
        step: grid.step * k as f64,
        nx,
        ny,
        radius: grid.radius,
        kind: (0..nx * ny).map(|i| grid.kind[fine(i)]).collect(),
        center_z: (0..nx * ny).map(|i| grid.center_z[fine(i)]).collect(),
        point: (0..nx * ny).map(|i| grid.point[fine(i)]).collect(),
        crossings: Vec::new(),
    };
    (coarse, k)
}
