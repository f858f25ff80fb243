//! Evening out: what a first layout of the passes leaves is measured, and the metric is stretched where its cusps came out higher (or
//! lower) than it said. Facets, noise, and curvature that changes within a stepover are then in the metric, and few spots are left to
//! fill.
//!
//! Twice: first by the mean of what is found around a place, then by what hardly any cusp around it exceeds, so that passes come closer
//! only where the ground is rough. (Measured on a part of large facets: with closer passes everywhere, 298 s; so, 291 s.)

use crate::feature::Regions;
use crate::field::Metric;
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// How the measured cusps become a correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvenOptions {
    /// Cusp height the passes were spaced for, mm.
    pub spaced_for: f64,
    /// Nodes in half a flat stepover.
    pub reach: usize,
    /// Least and largest correction of a squared length.
    pub bounds: [f64; 2],
    /// What hardly any cusp exceeds counts, rather than their mean.
    pub above: Option<Above>,
}

/// The mean of what is found around a place, and so many times what it strays from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Above {
    /// Standard deviations over the mean.
    pub deviations: f32,
    /// They are told over so many nodes to either side.
    pub within: usize,
}

/// Ratios beyond this are no error of the metric: corners of passes, borders, creases.
const STRUCTURE: f64 = 1.3;
/// Where the field rises by less than this a pass, fronts meet, and what stands there is a corner.
const FRONT: f64 = 0.9;

/// Factor on the squared length at each node, from the highest cusp (mm, 0 = none seen) found at each node.
pub fn correction(
    grid: &ToolCentreGrid,
    metric: &Metric,
    regions: &Regions,
    cusps: Vec<f32>,
    options: &EvenOptions,
) -> Vec<f32> {
    let (nx, ny) = (grid.nx, grid.ny);
    let mut cusps = cusps;
    if options.above.is_some() {
        without_structure(grid, metric, regions, &mut cusps, options);
    }
    let top = widest(&cusps, nx, ny, options.reach);
    // On a large part each of these is tens of megabytes: none stays longer than it must.
    drop(cusps);
    let [least, most] = options.bounds;
    let mut ratio: Vec<f32> = (0..grid.len())
        .into_par_iter()
        .map(|i| {
            let r = f64::from(top[i]) / options.spaced_for;
            if r <= 0.0 || r > STRUCTURE || !slopes_evenly(grid, metric, regions, i) {
                f32::NAN
            } else {
                r.clamp(least, most) as f32
            }
        })
        .collect();
    drop(top);
    if let Some(above) = options.above {
        let middle = mean(&ratio, nx, ny, above.within);
        ratio.par_iter_mut().for_each(|r| *r *= *r);
        let squares = mean(&ratio, nx, ny, above.within);
        ratio
            .par_iter_mut()
            .zip(middle.par_iter().zip(&squares))
            .for_each(|(r, (m, s))| {
                let strays = (s - m * m).max(0.0).sqrt();
                *r = (m + above.deviations * strays).min(most as f32);
            });
    }
    // Twice a box: close to a Gauss bell; nodes without a figure take their neighbours'.
    let once = mean(&ratio, nx, ny, options.reach);
    drop(ratio);
    let twice = mean(&once, nx, ny, options.reach);
    twice
        .into_iter()
        .map(|r| if r.is_nan() { 1.0 } else { r })
        .collect()
}

/// Forgets cusps where fronts meet or end, and beside them: they say nothing of the ground around.
fn without_structure(
    grid: &ToolCentreGrid,
    metric: &Metric,
    regions: &Regions,
    cusps: &mut [f32],
    options: &EvenOptions,
) {
    let is: Vec<f32> = (0..grid.len())
        .into_par_iter()
        .map(|i| {
            let over = f64::from(cusps[i]) > STRUCTURE * options.spaced_for;
            f32::from(u8::from(over || !slopes_evenly(grid, metric, regions, i)))
        })
        .collect();
    let is = widest(&is, grid.nx, grid.ny, options.reach);
    cusps.par_iter_mut().zip(&is).for_each(|(c, s)| {
        if *s > 0.0 {
            *c = 0.0;
        }
    });
}

/// Whether a node lies well inside its feature where the field is a distance, one unit a pass.
fn slopes_evenly(grid: &ToolCentreGrid, metric: &Metric, regions: &Regions, i: usize) -> bool {
    let label = regions.label[i];
    if grid.kind[i] != NodeKind::Ground || label == 0 {
        return false;
    }
    let f = &regions.features[label as usize - 1];
    let here = f.field.at(grid, i);
    if here < 1.0 || (f.saddle.is_some() && here > f.rim - 1.0) {
        return false;
    }
    let at = |d| {
        grid.neighbour(i, d)
            .map(|j| f.field.at(grid, j))
            .filter(|v| v.is_finite())
    };
    let (Some(e), Some(w), Some(n), Some(s)) = (at((2, 0)), at((-2, 0)), at((0, 2)), at((0, -2)))
    else {
        return false;
    };
    let (gx, gy) = ((e - w) / (4.0 * grid.step), (n - s) / (4.0 * grid.step));
    let m = &metric.tensor[i];
    let det = m[0] * m[2] - m[1] * m[1];
    let dual = (m[2] * gx * gx - 2.0 * m[1] * gx * gy + m[0] * gy * gy) / det;
    dual > FRONT * FRONT
}

/// The highest value within `reach` nodes along either axis.
fn widest(of: &[f32], nx: usize, ny: usize, reach: usize) -> Vec<f32> {
    let mut rows = vec![0.0f32; nx * ny];
    rows.par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
        for (x, v) in row.iter_mut().enumerate() {
            let (a, b) = (x.saturating_sub(reach), (x + reach).min(nx - 1));
            *v = of[y * nx + a..=y * nx + b]
                .iter()
                .copied()
                .fold(0.0, f32::max);
        }
    });
    let mut out = vec![0.0f32; nx * ny];
    out.par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
        let (a, b) = (y.saturating_sub(reach), (y + reach).min(ny - 1));
        for (x, v) in row.iter_mut().enumerate() {
            *v = (a..=b).map(|k| rows[k * nx + x]).fold(0.0, f32::max);
        }
    });
    out
}

/// Mean of what is there within `reach` nodes along either axis; NaN where nothing is.
fn mean(of: &[f32], nx: usize, ny: usize, reach: usize) -> Vec<f32> {
    let mut rows = vec![(0.0f32, 0u32); nx * ny];
    rows.par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
        for (x, v) in row.iter_mut().enumerate() {
            let (a, b) = (x.saturating_sub(reach), (x + reach).min(nx - 1));
            for r in &of[y * nx + a..=y * nx + b] {
                if !r.is_nan() {
                    v.0 += r;
                    v.1 += 1;
                }
            }
        }
    });
    let mut out = vec![f32::NAN; nx * ny];
    out.par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
        let (a, b) = (y.saturating_sub(reach), (y + reach).min(ny - 1));
        for (x, v) in row.iter_mut().enumerate() {
            let (sum, n) = (a..=b).fold((0.0, 0), |s, k| {
                let r = rows[k * nx + x];
                (s.0 + r.0, s.1 + r.1)
            });
            if n > 0 {
                *v = sum / n as f32;
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::feature::{GrowOptions, Source, farthest, whole};
    use crate::field::{Front, Ruler};
    use crate::geom::{Point, Vector2};
    use crate::part::Mesh;
    use crate::reach::{DropCutter, GridOptions, GridPlan};

    const WANTED: f64 = 0.02;

    /// A plain of 30 mm as one feature, in passes from one side to the other.
    fn plain() -> (ToolCentreGrid, Metric, Regions) {
        let p = |x, y| Point::new(x, y, 0.0);
        let (a, b, c, d) = (p(0.0, 0.0), p(30.0, 0.0), p(30.0, 30.0), p(0.0, 30.0));
        let part = Mesh {
            triangles: vec![[a, b, c], [a, c, d]],
        };
        let cutter = DropCutter::new(&part, 3.0);
        let how = GridOptions {
            step: 0.2,
            memory_limit_bytes: 1 << 30,
        };
        let plan = GridPlan::new(&cutter, &how).unwrap();
        let grid = ToolCentreGrid::new(&cutter, &plan).unwrap();
        let metric = Metric::new(&grid, Ruler::IsoScallop, WANTED);
        let source = Source {
            name: "side".to_string(),
            nodes: farthest(&grid, &Vector2::new(-1.0, 0.0))
                .into_iter()
                .collect(),
            front: Front::Straight,
        };
        let how = GrowOptions {
            ruler: Ruler::IsoScallop,
            passes_min: 2.0,
            margin: 5.0,
            over_share: 0.0,
            persistence: 0.0,
        };
        let regions = whole(&grid, &metric, &metric, &source, &how);
        (grid, metric, regions)
    }

    /// The correction at a place, where this was measured at each.
    fn corrected(cusp: impl Fn(f64, f64) -> f64, above: Option<Above>, at: (f64, f64)) -> f64 {
        let (grid, metric, regions) = plain();
        let cusps = (0..grid.len())
            .map(|i| {
                let q = grid.xy(i);
                cusp(q.x, q.y) as f32
            })
            .collect();
        let how = EvenOptions {
            spaced_for: WANTED,
            reach: 2,
            bounds: [0.9, 1.25],
            above,
        };
        let factor = correction(&grid, &metric, &regions, cusps, &how);
        f64::from(factor[grid.nearest(at.0, at.1).unwrap()])
    }

    /// What came out a tenth too high is laid a tenth closer (in squares), what came out far too low no wider than the bounds, and a
    /// corner says nothing.
    #[test]
    fn what_was_measured_is_the_correction() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-3, "{a}, not {b}");
        near(corrected(|_, _| 1.1 * WANTED, None, (15.0, 15.0)), 1.1);
        near(corrected(|_, _| 0.5 * WANTED, None, (15.0, 15.0)), 0.9);
        near(corrected(|_, _| 3.0 * WANTED, None, (15.0, 15.0)), 1.0);
        near(corrected(|_, _| 0.0, None, (15.0, 15.0)), 1.0);
    }

    /// Where cusps differ from place to place passes come closer than their mean asks for; where they do not, they stay.
    #[test]
    fn rough_ground_gets_closer_passes_and_even_ground_does_not() {
        let above = Above {
            deviations: 2.5,
            within: 10,
        };
        // Patches wider than what is told apart, one tenth higher and lower by turns, on one half of the plain.
        let patchy = |x: f64, y: f64| {
            let odd = ((x / 1.4).floor() + (y / 1.4).floor()).rem_euclid(2.0) > 0.5;
            let by = if y > 15.0 && odd { 1.1 } else { 1.0 };
            0.95 * by * WANTED
        };
        let rough = corrected(patchy, Some(above), (15.0, 22.0));
        let even = corrected(patchy, Some(above), (15.0, 6.0));
        let mean = corrected(patchy, None, (15.0, 22.0));
        assert!((even - 0.95).abs() < 1e-3, "{even}");
        assert!(rough > mean + 0.02 && rough <= 1.25, "{rough}, mean {mean}");
    }
}
