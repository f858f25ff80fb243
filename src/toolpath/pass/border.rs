//! Stretches of the part's border that need a pass of their own.
//!
//! Where passes cross the border they clean it between them. Where they run along it, the outermost may be up to a whole step away
//! (and leave four times the cusp): there the ball goes along the border itself, its contact on it. On a slope the centre then lies
//! outside the part's outline. On a steep wall the passes at constant height take the place of level passes.

use super::{Pass, PassKind, laid};
use crate::feature::Regions;
use crate::field::level_curves;
use crate::geom::{Point, Point2, Vector2};
use crate::reach::{DropCutter, Hint, NodeKind, ToolCentreGrid};
use crate::toolpath::fit::{FitOptions, resample, rest, smooth};
use crate::toolpath::wall::{BRIDGED, SHORTEST, Steep, bridge, laid_on_wall};

/// Ground up to this far (in passes) beyond the outermost pass is cut by it: half a pass, less what a field errs by at a border.
const CUT_BESIDE: f64 = 0.42;

/// What cuts the ground beside a border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    /// The level passes of a feature.
    Levels(usize),
    /// Passes at constant height on steep walls, level by level: 0, 1, 2 ... from below.
    Walls,
}

/// A place on the border.
struct Place {
    /// Centre of the ball.
    center: Point,
    /// Away from the part, unit length; zero on the flat.
    out: Vector2,
    /// What cuts here, and the value of its field.
    field: Option<(Family, f64)>,
}

/// Passes along the stretches of the border that no level pass cleans.
pub fn border(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    steep: &Steep,
    fitting: &FitOptions,
) -> Vec<Pass> {
    let walls: Vec<f64> = (0..steep.count()).map(|k| k as f64).collect();
    let levels = |family: Family| match family {
        Family::Levels(k) => regions.features[k].levels.as_slice(),
        Family::Walls => walls.as_slice(),
    };
    let ground = |n: usize| grid.kind[n] == NodeKind::Ground;
    let value = |n: usize| if ground(n) { 1.0 } else { 0.0 };
    let crossing = |a: u32, b: u32| -> Option<Place> {
        let inside = if ground(a as usize) { a } else { b };
        let outside = a ^ b ^ inside;
        let from = grid.crossings.partition_point(|c| c.inside < inside);
        let contact = grid.crossings[from..]
            .iter()
            .take_while(|c| c.inside == inside)
            .find(|c| c.outside == outside)
            .map(|c| c.contact)?;
        let center = contact.center;
        let at = center.xy();
        let out = (at - contact.point.xy())
            .try_normalize(1e-9)
            .unwrap_or_default();
        let label = regions.label[inside as usize];
        let wall = steep.node[inside as usize]
            .then(|| steep.passes_below(center.z))
            .flatten();
        if let Some(value) = wall {
            return Some(Place {
                center,
                out,
                field: Some((Family::Walls, value)),
            });
        }
        let field = (label > 0).then(|| {
            let k = label as usize - 1;
            let f = &regions.features[k].field;
            let (v, w) = (f.at(grid, inside as usize), f.at(grid, outside as usize));
            let (p, q) = (grid.xy(inside as usize), grid.xy(outside as usize));
            let t = ((at - p).norm() / (q - p).norm()).clamp(0.0, 1.0);
            let value = if w.is_finite() { v + (w - v) * t } else { v };
            (Family::Levels(k), value)
        });
        Some(Place {
            center,
            out,
            field: field.filter(|f| f.1.is_finite()),
        })
    };
    let mut out = Vec::new();
    for curve in level_curves(grid, &value, &[0.5]) {
        let places: Vec<Place> = curve.at.iter().filter_map(|e| crossing(e.a, e.b)).collect();
        let on_walls = wall_stretches(&places, curve.closed, steep.count(), steep);
        let others = stretches(&places, curve.closed, &levels);
        for (stretch, closed) in others.into_iter().chain(on_walls) {
            let feature = stretch.iter().find_map(|&i| match places[i].field {
                Some((Family::Levels(k), _)) => Some(k),
                _ => None,
            });
            let on_wall = |i: &usize| matches!(places[*i].field, Some((Family::Walls, _)));
            let runs = if stretch.iter().all(on_wall) {
                let at: Vec<(Point, Vector2)> = stretch
                    .iter()
                    .map(|&i| (places[i].center, places[i].out))
                    .collect();
                laid_on_wall(cutter, &at, closed, &steep.options, fitting)
            } else {
                let at: Vec<Point2> = stretch.iter().map(|&i| places[i].center.xy()).collect();
                let mut even = resample(&at, closed, 0.7 * grid.step);
                // Border centres jump from facet to facet with their normals; rolling a little round the outline costs nothing.
                smooth(&mut even, closed, 4);
                let mut hint = Hint::default();
                even.retain(|q| rest(cutter, q.x, q.y, &mut hint).is_some());
                laid(cutter, &even, closed, fitting)
            };
            for (points, closed) in runs {
                if points.len() > 1 {
                    out.push(Pass {
                        kind: PassKind::Border,
                        feature,
                        points,
                        closed,
                    });
                }
            }
        }
    }
    out
}

/// The runs of a border on steep walls that need a pass, as indices into it, and whether a run is the whole closed curve. The passes at
/// constant height lie above the border, and end where they come to it: a place is clean beside the next one above, or beside such an end.
fn wall_stretches(
    places: &[Place],
    closed: bool,
    passes: usize,
    steep: &Steep,
) -> Vec<(Vec<usize>, bool)> {
    let n = places.len();
    let value: Vec<Option<f64>> = places
        .iter()
        .map(|p| match p.field {
            Some((Family::Walls, v)) => Some(v),
            _ => None,
        })
        .collect();
    if n < 2 || value.iter().all(Option::is_none) {
        return Vec::new();
    }
    let last = if closed { n } else { n - 1 };
    let gap = |i: usize| (places[(i + 1) % n].center - places[i].center).norm();
    // Passes to the next one above, and whether one ends between a place and the one after it.
    let mut above: Vec<Option<f64>> = value
        .iter()
        .map(|v| {
            v.map(|v| v.ceil() - v)
                .filter(|_| v.is_none_or(|v| v <= passes as f64 - 1.0))
        })
        .collect();
    let mut ends: Vec<bool> = (0..last)
        .map(|i| match (value[i], value[(i + 1) % n]) {
            (Some(u), Some(v)) => u.floor() != v.floor(),
            (a, b) => a.is_some() != b.is_some(),
        })
        .collect();
    ends.resize(n, false);
    // Where the border dips below a pass for less than that pass is worth, there is none.
    for i in 0..last {
        let (Some(u), Some(v)) = (value[i], value[(i + 1) % n]) else {
            continue;
        };
        if u.floor() <= v.floor() {
            continue;
        }
        let level = u.floor();
        let (mut length, mut k) = (0.0, i + 1);
        while k < i + n && (closed || k < n) && length < SHORTEST * steep.options.stepover {
            match value[k % n] {
                Some(w) if w < level => {}
                Some(_) => {
                    for j in i + 1..k {
                        above[j % n] = value[j % n].map(|v| level + 1.0 - v);
                        ends[j % n] = false;
                    }
                    ends[i] = false;
                    break;
                }
                None => break,
            }
            length += gap(k % n);
            k += 1;
        }
    }
    // Way along the border to the nearest end of a pass.
    let mut way = vec![f64::INFINITY; n];
    let rounds = if closed { 2 * n } else { n };
    let mut so_far = f64::INFINITY;
    for k in 0..rounds {
        let i = k % n;
        way[i] = way[i].min(so_far);
        so_far = if ends[i] { 0.0 } else { so_far + gap(i) };
    }
    so_far = f64::INFINITY;
    for k in (0..rounds).rev() {
        let i = k % n;
        if ends[i] {
            so_far = 0.0;
        }
        way[i] = way[i].min(so_far);
        so_far += gap((i + n - 1) % n);
    }
    let mut needed: Vec<bool> = (0..n)
        .map(|i| {
            above[i].is_some_and(|a| a > CUT_BESIDE) && way[i] > CUT_BESIDE * steep.options.stepover
        })
        .collect();
    // To go on costs less than to come again.
    let at: Vec<Option<Point2>> = places
        .iter()
        .zip(&value)
        .map(|(p, v)| v.map(|_| p.center.xy()))
        .collect();
    bridge(&mut needed, &at, closed, BRIDGED * steep.options.stepover);
    if needed.iter().all(|n| *n) {
        return vec![((0..n).collect(), closed)];
    }
    let start = if closed {
        needed.iter().position(|n| !n).unwrap_or(0)
    } else {
        0
    };
    let mut out: Vec<(Vec<usize>, bool)> = Vec::new();
    let mut run: Vec<usize> = Vec::new();
    for k in 0..=n {
        let i = (start + k) % n;
        if k < n && needed[i] {
            run.push(i);
        } else if !run.is_empty() {
            out.push((std::mem::take(&mut run), false));
        }
    }
    out
}

/// The runs of a border curve that need a pass, as indices into it, and whether a run is the whole closed curve.
fn stretches<'l>(
    places: &[Place],
    closed: bool,
    levels: &impl Fn(Family) -> &'l [f64],
) -> Vec<(Vec<usize>, bool)> {
    let n = places.len();
    if n == 0 {
        return Vec::new();
    }
    // Where a pass comes to the border: between two places on either side of a level, or of two features' rims.
    let cut_between = |i: usize, j: usize| -> bool {
        match (places[i].field, places[j].field) {
            (Some((a, u)), Some((b, v))) if a == b => {
                let levels = levels(a);
                let (lo, hi) = (u.min(v), u.max(v));
                let k = levels.partition_point(|l| *l <= lo);
                levels.get(k).is_some_and(|l| *l <= hi)
            }
            (a, b) => a.is_some() != b.is_some() || a.map(|f| f.0) != b.map(|f| f.0),
        }
    };
    let last = if closed { n } else { n - 1 };
    let cuts: Vec<usize> = (0..last).filter(|&i| cut_between(i, (i + 1) % n)).collect();
    let mut runs: Vec<(Vec<usize>, bool)> = Vec::new();
    if cuts.is_empty() {
        runs.push(((0..n).collect(), closed));
    } else {
        for w in cuts.windows(2) {
            runs.push(((w[0] + 1..=w[1]).collect(), false));
        }
        let (first, end) = (cuts[0], cuts[cuts.len() - 1]);
        if closed {
            runs.push(((end + 1..n).chain(0..=first).collect(), false));
        } else {
            runs.push(((0..=first).collect(), false));
            runs.push(((end + 1..n).collect(), false));
        }
    }
    let mut needed: Vec<(Vec<usize>, bool)> = Vec::new();
    for (run, whole) in runs {
        let (Some(&a), Some(&b)) = (run.first(), run.last()) else {
            continue;
        };
        let (Some((family, u)), Some((_, v))) = (places[a].field, places[b].field) else {
            // Ground without a field: nothing else cuts it.
            needed.push((run, whole));
            continue;
        };
        if family == Family::Walls {
            continue;
        }
        let levels = levels(family);
        let values = run.iter().filter_map(|&i| places[i].field.map(|f| f.1));
        let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |r, v| {
            (r.0.min(v), r.1.max(v))
        });
        let beyond = if cuts.is_empty() {
            // No pass comes to this border at all: how far is the nearest one?
            let nearest = |v: f64| {
                levels
                    .iter()
                    .map(|l| (l - v).abs())
                    .fold(f64::INFINITY, f64::min)
            };
            nearest(lo).max(nearest(hi))
        } else {
            (hi - u.max(v)).max(u.min(v) - lo)
        };
        if beyond > CUT_BESIDE {
            needed.push((run, whole));
        }
    }
    needed
}
