//! Stretches of the part's border that need a pass of their own.
//!
//! Where passes cross the border they clean it between them. Where they run along it, the outermost may be up to a whole step away
//! (and leave four times the cusp): there the ball goes along the border itself, its contact on it. On a slope the centre then lies
//! outside the part's outline. On a steep wall the passes at constant height take the place of level passes.

use super::fit::{FitOptions, resample, rest, smooth};
use super::pass::{Pass, PassKind, laid};
use super::wall::{SHORTEST, Steep, laid_on_wall};
use crate::feature::Regions;
use crate::field::level_curves;
use crate::geom::{Point, Point2, Vector2};
use crate::reach::{DropCutter, Hint, NodeKind, ToolCentreGrid};

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
    let shortest = SHORTEST * steep.options.stepover;
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
        for (stretch, closed) in stretches(&places, curve.closed, &levels, shortest) {
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

/// Takes out the pairs of cuts between which the border dips below a pass on a wall for less than that pass is worth: there is none then.
fn unpassed(cuts: &mut Vec<usize>, places: &[Place], closed: bool, shortest: f64) {
    let n = places.len();
    loop {
        let count = cuts.len();
        let pairs = if closed && count > 2 {
            count
        } else {
            count.saturating_sub(1)
        };
        let dip = |k: &usize| {
            let (from, to) = (cuts[*k], cuts[(*k + 1) % count]);
            let steps = (to + n - from) % n;
            let inside = (1..=steps).map(|i| &places[(from + i) % n]);
            let value = |p: &Place| match p.field {
                Some((Family::Walls, v)) => Some(v),
                _ => None,
            };
            let (Some(before), Some(first), Some(end), Some(after)) = (
                value(&places[from]),
                value(&places[(from + 1) % n]),
                value(&places[to]),
                value(&places[(to + 1) % n]),
            ) else {
                return false;
            };
            // Down through a level and up again through the same.
            let through = before.max(first).floor();
            let length: f64 = inside
                .clone()
                .zip(inside.skip(1))
                .map(|(p, q)| (q.center - p.center).norm())
                .sum();
            first < before && end < after && through == after.max(end).floor() && length < shortest
        };
        let Some(k) = (0..pairs).find(dip) else {
            return;
        };
        let (a, b) = (k, (k + 1) % count);
        cuts.remove(a.max(b));
        cuts.remove(a.min(b));
    }
}

/// The runs of a border curve that need a pass, as indices into it, and whether a run is the whole closed curve.
fn stretches<'l>(
    places: &[Place],
    closed: bool,
    levels: &impl Fn(Family) -> &'l [f64],
    shortest: f64,
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
    let mut cuts: Vec<usize> = (0..last).filter(|&i| cut_between(i, (i + 1) % n)).collect();
    unpassed(&mut cuts, places, closed, shortest);
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
