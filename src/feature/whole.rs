//! The whole part as one feature: a field from one side or corner of it, whatever its critical points.

use super::ground::{Ground, GrowOptions};
use super::leftover::leftovers;
use super::region::{FeatureKind, Regions};
use crate::field::{Front, Metric, Ruler};
use crate::geom::{RING, Vector2};
use crate::reach::{NodeKind, ToolCentreGrid};

/// Where the field of a whole part begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// A name for tables: `side +x`, `corner -x+y`.
    pub name: String,
    /// Nodes it begins at.
    pub nodes: Vec<usize>,
    /// Shape of its first front.
    pub front: Front,
}

/// Sides (border facing an axis to within about 45 degrees) and corners (the farthest ground along a diagonal) of the ground.
pub fn sources(grid: &ToolCentreGrid) -> Vec<Source> {
    let mut out = Vec::new();
    for (name, along_x, up) in [
        ("side -x", true, false),
        ("side +x", true, true),
        ("side -y", false, false),
        ("side +y", false, true),
    ] {
        let nodes = side(grid, along_x, up);
        if nodes.len() > 1 {
            out.push(Source {
                name: name.to_string(),
                nodes,
                front: Front::Straight,
            });
        }
    }
    for (name, d) in [
        ("corner -x-y", Vector2::new(-1.0, -1.0)),
        ("corner +x-y", Vector2::new(1.0, -1.0)),
        ("corner -x+y", Vector2::new(-1.0, 1.0)),
        ("corner +x+y", Vector2::new(1.0, 1.0)),
    ] {
        out.extend(farthest(grid, &d).map(|node| Source {
            name: name.to_string(),
            nodes: vec![node],
            front: Front::Round,
        }));
    }
    let rim = rim(grid);
    // Fronts from a rim meet along lines that need strokes of their own. Where the part falls away steeply all round that is worth it:
    // its flanks are then cut in loops, from a corner of it in short pieces.
    let steep = rim
        .iter()
        .filter(|&&n| grid.center_z[n] - grid.point[n].z < STEEP_RIM * grid.radius)
        .count();
    if rim.len() > 1 && 2 * steep > rim.len() {
        out.push(Source {
            name: "rim".to_string(),
            nodes: rim,
            front: Front::Straight,
        });
    }
    out
}

/// A rim is steep where the normal leans this far: 60 degrees.
const STEEP_RIM: f64 = 0.5;

/// Ground beside what is none.
fn rim(grid: &ToolCentreGrid) -> Vec<usize> {
    let beside = |n: usize| {
        RING.into_iter().any(|d| {
            grid.neighbour(n, d)
                .is_none_or(|j| grid.kind[j] != NodeKind::Ground)
        })
    };
    (0..grid.len())
        .filter(|&n| grid.kind[n] == NodeKind::Ground && beside(n))
        .collect()
}

/// The ground node farthest along a direction (the lowest index on a tie).
pub fn farthest(grid: &ToolCentreGrid, d: &Vector2) -> Option<usize> {
    (0..grid.len())
        .filter(|&i| grid.kind[i] == NodeKind::Ground)
        .map(|i| (grid.xy(i).coords.dot(d), i))
        .reduce(|a, b| if b.0 > a.0 + 1e-9 { b } else { a })
        .map(|a| a.1)
}

/// The outermost ground of each row (or column), where the border does not run more than 45 degrees off across some steps.
fn side(grid: &ToolCentreGrid, along_x: bool, up: bool) -> Vec<usize> {
    let (lines, length) = if along_x {
        (grid.ny, grid.nx)
    } else {
        (grid.nx, grid.ny)
    };
    let node = |line: usize, k: usize| {
        if along_x {
            line * grid.nx + k
        } else {
            k * grid.nx + line
        }
    };
    let outermost: Vec<Option<usize>> = (0..lines)
        .map(|l| {
            let is = |k: &usize| grid.kind[node(l, *k)] == NodeKind::Ground;
            if up {
                (0..length).rev().find(is)
            } else {
                (0..length).find(is)
            }
        })
        .collect();
    // The outermost of all, and from there along the border both ways while it does not turn away.
    let best = (0..lines)
        .filter_map(|l| outermost[l].map(|k| (if up { k as i64 } else { -(k as i64) }, l)))
        .reduce(|a, b| if b.0 > a.0 { b } else { a });
    let Some((_, start)) = best else {
        return Vec::new();
    };
    let run = 4;
    let goes_on = |l: usize, from: usize| -> bool {
        let (Some(a), Some(b)) = (outermost[l], outermost[from]) else {
            return false;
        };
        a.abs_diff(b) <= l.abs_diff(from)
    };
    let mut kept = vec![start];
    for l in start + 1..lines {
        if !goes_on(l, l.saturating_sub(run).max(start)) {
            break;
        }
        kept.push(l);
    }
    for l in (0..start).rev() {
        if !goes_on(l, (l + run).min(start)) {
            break;
        }
        kept.push(l);
    }
    kept.sort_unstable();
    kept.into_iter()
        .filter_map(|l| outermost[l].map(|k| node(l, k)))
        .collect()
}

/// One feature from a source over all ground it hangs together with; other ground is left over, and cut as such. `cusp` and `metric` as
/// for [`grow`](super::grow::grow).
pub fn whole(
    grid: &ToolCentreGrid,
    cusp: &Metric,
    metric: &Metric,
    source: &Source,
    options: &GrowOptions,
) -> Regions {
    let mut g = Ground::new(grid, cusp, metric, options);
    let touched = match (options.ruler, source.nodes.first()) {
        (Ruler::Isoplanar(_), Some(&seed)) => g.march_from(seed, &mut |_, _| true),
        _ => g.march_source(source),
    };
    g.take(FeatureKind::Whole, None, None, f64::INFINITY, &touched);
    leftovers(&mut g);
    g.regions
}
