//! Ridges: the lines in a face where fronts meet.
//!
//! ```text
//!     \ \ \ | / / /        passes that meet at an angle, or run towards each other and stop short of one more between them, leave a ridge
//!      \ \ \|/ / /         along the line where their fronts meet: one pass along that line takes it, where bits of fill would each want a
//!       \ \ | / /          way to them
//! ```
//!
//! Crosses the border: fields of faces in, [`Pass`]es along the lines out, wanted or not: [`needed`](super::pencil::needed) tells.

use super::{Pass, PassKind, laid};
use crate::feature::{Feature, FeatureKind, FieldSource, Regions, source::nodes};
use crate::field::Metric;
use crate::geom::{Point2, Vector2};
use crate::reach::{DropCutter, NodeKind, ToolCentreGrid};
use crate::toolpath::fill::skeleton::middle_lines;
use crate::toolpath::fit::{FitOptions, resample, smooth};
use rayon::prelude::*;

/// Where a field rises by less than this a pass, fronts meet: at 25 degrees from straight on, where they leave a sixth more than the cusp.
const MEET: f64 = 0.91;
/// Nodes to either side that tell how a field rises.
const ACROSS: i32 = 2;

/// A pass along each line in which fronts of a face meet. All cores; the order does not depend on them.
pub(in crate::toolpath) fn ridges(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    metric: &Metric,
    stepover: f64,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let shortest = ((stepover / grid.step) as usize).max(3);
    let lines: Vec<(usize, Vec<Point2>)> = regions
        .features
        .par_iter()
        .enumerate()
        .filter(|(_, f)| f.kind == FeatureKind::Face && !matches!(f.source, FieldSource::Planes(_)))
        .flat_map_iter(|(k, f)| {
            let cells: Vec<(i64, i64)> = nodes(grid, f)
                .filter(|&n| meets(grid, regions, metric, k, f, n))
                .map(|n| ((n % grid.nx) as i64, (n / grid.nx) as i64))
                .collect();
            middle_lines(&cells, shortest)
                .into_iter()
                .filter(move |line| line.len() > shortest)
                .map(move |line| {
                    let at: Vec<Point2> = line
                        .iter()
                        .map(|&(x, y)| grid.xy(y as usize * grid.nx + x as usize))
                        .collect();
                    let mut even = resample(&at, false, 2.0 * grid.step);
                    smooth(&mut even, false, 4);
                    drawn_out(grid, regions, k, &mut even);
                    even.reverse();
                    drawn_out(grid, regions, k, &mut even);
                    (k, even)
                })
        })
        .collect();
    let passes: Vec<Vec<Pass>> = lines
        .par_iter()
        .map(|(k, line)| {
            laid(cutter, line, false, fitting)
                .into_iter()
                .filter(|(points, _)| points.len() > 1)
                .map(|(points, closed)| Pass {
                    kind: PassKind::Level,
                    feature: Some(*k),
                    points,
                    closed,
                })
                .collect()
        })
        .collect();
    passes.into_iter().flatten().collect()
}

/// A line is drawn out by so many steps of the grid at either end: fronts are not seen to meet right beside a rim.
const DRAWN_OUT: usize = 4;

/// Draws a line out straight at its end, for as long as that stays on its face: into the corner from which the fronts came.
fn drawn_out(grid: &ToolCentreGrid, regions: &Regions, index: usize, line: &mut Vec<Point2>) {
    let [.., a, b] = line[..] else { return };
    let Some(way) = (b - a).try_normalize(1e-9) else {
        return;
    };
    let end = (1..=DRAWN_OUT)
        .map(|k| b + way * (k as f64 * grid.step))
        .take_while(|q| regions.feature_at(grid, q) == Some(index))
        .last();
    line.extend(end);
}

/// Does the field of a face rise by much less than its metric says at a node well inside it?
fn meets(
    grid: &ToolCentreGrid,
    regions: &Regions,
    metric: &Metric,
    index: usize,
    f: &Feature,
    n: usize,
) -> bool {
    let mine = |d| {
        grid.neighbour(n, d)
            .filter(|&j| grid.kind[j] == NodeKind::Ground && regions.label[j] as usize == index + 1)
            .map(|j| f.field.at(grid, j))
            .filter(|v| v.is_finite())
    };
    let a = ACROSS;
    let (Some(_), Some(e), Some(w), Some(u), Some(d)) = (
        mine((0, 0)),
        mine((a, 0)),
        mine((-a, 0)),
        mine((0, a)),
        mine((0, -a)),
    ) else {
        return false;
    };
    let g = Vector2::new(e - w, u - d) / (f64::from(2 * a) * grid.step);
    let m = &metric.tensor[n];
    let det = m[0] * m[2] - m[1] * m[1];
    let dual = (m[2] * g.x * g.x - 2.0 * m[1] * g.x * g.y + m[0] * g.y * g.y) / det;
    dual < MEET * MEET
}
