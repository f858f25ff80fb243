//! `cargo bench --bench field`: the tool-centre grid, the cusp metric, the march and its level curves, per node of the grid.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "a bench is a program; what each measures stands in its name"
)]

mod common;

use common::{RADIUS, SIDE, gentle, measure, relief, table};
use divan::Bencher;
use morsemill::field::march::Access;
use morsemill::field::{Front, MarchOptions, Metric, Ruler, level_curves, march};
use morsemill::reach::{DropCutter, GridOptions, GridPlan, ToolCentreGrid};

/// Nodes, about.
const NODES: [usize; 3] = [50_000, 200_000, 800_000];
const SCALLOP: f64 = 0.02;

fn main() {
    divan::main();
    table("field, 100k triangles, scallop 0.02 mm", "nodes");
}

fn plan(cutter: &DropCutter, nodes: usize) -> GridPlan {
    let how = GridOptions {
        step: (SIDE + 2.0 * RADIUS) / (nodes as f64).sqrt(),
        memory_limit_bytes: 4 << 30,
    };
    GridPlan::new(cutter, &how).unwrap()
}

fn cutter() -> DropCutter {
    DropCutter::new(&relief(100_000, gentle), RADIUS)
}

fn grid(nodes: usize) -> ToolCentreGrid {
    let cutter = cutter();
    ToolCentreGrid::new(&cutter, &plan(&cutter, nodes)).unwrap()
}

/// Distances from the middle of the part, in passes.
fn field(grid: &ToolCentreGrid, metric: &Metric) -> Vec<f64> {
    let mut value = vec![f64::INFINITY; grid.len()];
    let seed = grid.nearest(0.5 * SIDE, 0.5 * SIDE).unwrap();
    march(
        grid,
        metric,
        &[(seed, 0.0)],
        &|node| {
            if metric.is_set(node) {
                Access::Open
            } else {
                Access::Closed
            }
        },
        &MarchOptions {
            front: Front::Round,
            near_steps: 4,
        },
        &mut value,
        &mut |_, _| true,
    );
    value
}

#[divan::bench(args = NODES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn tool_centre_grid(b: Bencher, nodes: usize) {
    let cutter = cutter();
    let plan = plan(&cutter, nodes);
    measure(b, "tool-centre grid", nodes, nodes, || {
        ToolCentreGrid::new(&cutter, &plan).unwrap()
    });
}

#[divan::bench(args = NODES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn cusp_metric(b: Bencher, nodes: usize) {
    let grid = grid(nodes);
    measure(b, "cusp metric", nodes, grid.len(), || {
        Metric::new(&grid, Ruler::IsoScallop, SCALLOP)
    });
}

#[divan::bench(args = NODES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn marching(b: Bencher, nodes: usize) {
    let grid = grid(nodes);
    let metric = Metric::new(&grid, Ruler::IsoScallop, SCALLOP);
    measure(b, "march", nodes, grid.len(), || field(&grid, &metric));
}

#[divan::bench(args = NODES, sample_count = 2, sample_size = 1, min_time = 0.4)]
fn contours(b: Bencher, nodes: usize) {
    let grid = grid(nodes);
    let metric = Metric::new(&grid, Ruler::IsoScallop, SCALLOP);
    let value = field(&grid, &metric);
    let top = value
        .iter()
        .filter(|v| v.is_finite())
        .fold(0.0, |a: f64, b| a.max(*b));
    let levels: Vec<f64> = (0..top as usize).map(|k| k as f64 + 0.5).collect();
    measure(b, "level curves", nodes, grid.len(), || {
        level_curves(&grid, &|i| value[i], &levels)
    });
}
