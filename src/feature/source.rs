//! Where the field of a grown feature begins. Its ground is fixed: grown from its seed up to its saddle. How it is cut is not: from the
//! seed, as the paper has it, or from a rim beside it, a side or a corner of it, or in plane sections, whichever gives the better passes.
//! A pit on the border that grew round a peak is a crescent: from its tip it is cut in a hundred short passes across, from the peak's
//! rim in a few long ones.

use super::region::{Feature, Regions, Window};
use super::whole::sources;
use crate::field::march::Access;
use crate::field::ruler::length_sq;
use crate::field::{Front, MarchOptions, Metric, march};
use crate::geom::Vector2;
use crate::reach::{NodeKind, ToolCentreGrid};

/// Where a field begins.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldSource {
    /// At the point the feature grew from.
    Seed,
    /// At the rim of the feature that grew from this critical point.
    Rim(usize),
    /// At what parts a face from others: the feet of walls and the edges above them.
    Feet,
    /// At all of a face's rim: what parts it, and the part's border.
    Around,
    /// At a side or a corner of the feature; the name of a [`Source`](super::whole::Source).
    Side(String),
    /// Plane sections; the angle of the passes from X, degrees.
    Planes(f64),
    /// At the seed, equal distance on the part.
    PickFeed,
}

impl FieldSource {
    /// A name for tables.
    pub fn name(&self) -> String {
        match self {
            FieldSource::Seed => "iso-scallop".to_string(),
            FieldSource::Rim(_) => "iso-scallop from a rim".to_string(),
            FieldSource::Feet => "iso-scallop from its walls".to_string(),
            FieldSource::Around => "iso-scallop from all round".to_string(),
            FieldSource::Side(s) => format!("iso-scallop from {s}"),
            FieldSource::Planes(angle) => format!("isoplanar at {angle:.0} deg"),
            FieldSource::PickFeed => "iso-pick-feed".to_string(),
        }
    }
}

/// The metrics a feature's field is made with.
#[derive(Clone, Copy)]
pub struct Metrics<'a> {
    /// Equal cusps.
    pub cusp: &'a Metric,
    /// Equal distance on the part; none where no feature asks for it.
    pub pick_feed: Option<&'a Metric>,
    /// Share of the ground that may get a cusp over the wanted one from a ruler other than iso-scallop, before filling.
    pub over_share: f64,
}

/// Whether a node is the feature's own ground, or the ring of nodes beyond the part's border that belongs to it.
fn own(grid: &ToolCentreGrid, f: &Feature, node: usize) -> bool {
    f.field.at(grid, node) <= f.rim && f.free.at(grid, node) >= 0.0
}

/// Nodes of a feature's window.
pub fn nodes<'a>(grid: &'a ToolCentreGrid, f: &'a Feature) -> impl Iterator<Item = usize> + 'a {
    f.field
        .spans()
        .flat_map(move |(y, columns)| columns.map(move |x| y * grid.nx + x))
}

/// A feature with the same ground and a field from somewhere else; none if there is no such place. `grown` are the features as
/// they grew; `rim_is_cut` tells whether the last pass of the feature whose rim it begins at runs on that rim.
pub fn refield(
    grid: &ToolCentreGrid,
    metrics: &Metrics,
    grown: &Regions,
    index: usize,
    source: &FieldSource,
    rim_is_cut: bool,
) -> Option<Feature> {
    let f = grown.features.get(index)?;
    if *source == FieldSource::Seed {
        return Some(f.clone());
    }
    let mine: Vec<usize> = nodes(grid, f).filter(|&n| own(grid, f, n)).collect();
    let ground = |n: usize| grid.kind[n] == NodeKind::Ground;
    let mut value = vec![f64::INFINITY; grid.len()];
    let mut is_mine = vec![false; grid.len()];
    mine.iter().for_each(|&n| is_mine[n] = true);
    let access = |n: usize| {
        if is_mine[n] {
            Access::Open
        } else {
            Access::Dead
        }
    };
    let mut first = 0.5;
    let mut from = |metric: &Metric, seeds: &[(usize, f64)], front: Front| -> Vec<u32> {
        let how = MarchOptions {
            front,
            near_steps: 3,
        };
        march(
            grid,
            metric,
            seeds,
            &access,
            &how,
            &mut value,
            &mut |_, _| true,
        )
    };
    let touched: Vec<u32> = match source {
        FieldSource::Seed => return None,
        FieldSource::Rim(seed) => {
            let j = grown.features.iter().position(|g| g.seed == Some(*seed))?;
            let rim = &grown.features[j];
            let seeds: Vec<(usize, f64)> = mine
                .iter()
                .filter(|&&n| touches(grid, grown, n, j))
                .map(|&n| (n, (rim.field.at(grid, n) - rim.rim).max(0.0)))
                .filter(|s| s.1.is_finite())
                .collect();
            if seeds.len() < 2 {
                return None;
            }
            if rim_is_cut {
                first = 1.0;
            }
            from(metrics.cusp, &seeds, Front::Straight)
        }
        FieldSource::Feet | FieldSource::Around => {
            let seeds = rim_seeds(
                grid,
                metrics.cusp,
                &mine,
                &is_mine,
                *source == FieldSource::Around,
            );
            if seeds.len() < 2 {
                return None;
            }
            first = 1.0;
            from(metrics.cusp, &seeds, Front::Straight)
        }
        FieldSource::Side(name) => {
            let mut alone = grid.clone();
            for (n, k) in alone.kind.iter_mut().enumerate() {
                if !is_mine[n] {
                    *k = NodeKind::Air;
                }
            }
            let s = sources(&alone).into_iter().find(|s| s.name == *name)?;
            if s.front == Front::Straight {
                first = BESIDE_BORDER;
            }
            let seeds: Vec<(usize, f64)> = s
                .nodes
                .iter()
                .map(|&n| match s.front {
                    Front::Straight => (n, to_border(grid, metrics.cusp, n)),
                    Front::Round => (n, 0.0),
                })
                .collect();
            from(metrics.cusp, &seeds, s.front)
        }
        FieldSource::PickFeed => {
            let seed = nodes(grid, f)
                .filter(|&n| is_mine[n])
                .map(|n| (f.field.at(grid, n), n))
                .reduce(|a, b| if b.0 < a.0 { b } else { a })?
                .1;
            let touched = from(metrics.pick_feed?, &[(seed, 0.0)], Front::Round);
            let duals = mine.iter().filter(|&&n| ground(n)).filter_map(|&n| {
                let v = |d| {
                    grid.neighbour(n, d)
                        .map(|j| value[j])
                        .filter(|v| v.is_finite())
                };
                let g = Vector2::new(v((1, 0))? - v((-1, 0))?, v((0, 1))? - v((0, -1))?)
                    / (2.0 * grid.step);
                let d = dual(metrics.cusp, n, &g);
                (d > 1e-6).then(|| 1.0 / d)
            });
            let scale = quantile(duals.collect(), 1.0 - metrics.over_share)?.sqrt();
            touched.iter().for_each(|&n| value[n as usize] *= scale);
            touched
        }
        FieldSource::Planes(angle) => {
            let (s, c) = angle.to_radians().sin_cos();
            let across = Vector2::new(-s, c);
            let step = widest_step(
                metrics.cusp,
                mine.iter().copied().filter(|&n| ground(n)),
                &across,
                metrics.over_share,
            )?;
            let at = |n: usize| grid.xy(n).coords.dot(&across);
            let low = mine
                .iter()
                .filter(|&&n| ground(n))
                .map(|&n| at(n))
                .fold(f64::INFINITY, f64::min);
            let mut touched: Vec<u32> = Vec::with_capacity(mine.len());
            for &n in &mine {
                for dy in -1..=1 {
                    for dx in -1..=1 {
                        if let Some(j) = grid.neighbour(n, (dx, dy))
                            && value[j] == f64::INFINITY
                            && metrics.cusp.is_set(j)
                        {
                            value[j] = (at(j) - low) / step;
                            touched.push(j as u32);
                        }
                    }
                }
            }
            touched
        }
    };
    let top = mine
        .iter()
        .filter(|&&n| ground(n) && value[n].is_finite())
        .map(|&n| value[n])
        .fold(0.0, f64::max);
    // Passes end where earlier features begin, and on the rim this one grew to.
    let mut free = vec![0.0; grid.len()];
    for &n in &touched {
        let i = n as usize;
        let before = f.free.at(grid, i);
        let mut inside = if before.is_finite() { before } else { -1.0 };
        if f.saddle.is_some() {
            let own = f.field.at(grid, i);
            inside = inside.min(if own.is_finite() { f.rim - own } else { -1.0 });
        }
        free[i] = inside;
    }
    Some(Feature {
        field: Window::around(grid, &touched, &value),
        free: Window::around(grid, &touched, &free),
        levels: (0..)
            .map(|k| f64::from(k) + first)
            .take_while(|l| *l < top)
            .collect(),
        rim: top,
        source: source.clone(),
        ..f.clone()
    })
}

/// The first pass beside a border lies this many passes from it: half a one, less what a field errs by there.
const BESIDE_BORDER: f64 = 0.42;

/// A pencil cuts this far from the foot of a wall, in passes: less what is not known of where it runs.
const FROM_FOOT: f64 = 0.05;
/// The first pass beside an edge lies this many passes from it: half a one, less what a field errs by there.
const FROM_EDGE: f64 = 0.4;
/// Along an edge the contact goes at most this share of the centre's way from a node to one of its eight neighbours further out.
const ALONG_EDGE: f64 = 0.85;
/// Nodes to either side of one that tell how far away a rim is.
const NEAR_RIM: i32 = 2;

/// What parts a face at one of its outermost nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rim {
    /// A wall goes up.
    Foot,
    /// The ball rolls over an edge, and touches it here already.
    Edge,
    /// The part ends.
    Border,
}

/// Nodes of a face beside what parts it (and, if asked, beside the part's border), with passes already cut there: a pencil runs along the
/// foot of a wall; on an edge, as on the border, a pass half a step off cuts up to it. How far away a wall or an edge is, the contacts beside
/// it tell: closer than the grid, whose steps would be waves in each pass.
fn rim_seeds(
    grid: &ToolCentreGrid,
    metric: &Metric,
    mine: &[usize],
    is_mine: &[bool],
    border: bool,
) -> Vec<(usize, f64)> {
    let ground = |n: usize| grid.kind[n] == NodeKind::Ground;
    let around = |n: usize, reach: i32| {
        (-reach..=reach)
            .flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)))
            .filter(|d| *d != (0, 0))
            .filter_map(move |d| grid.neighbour(n, d))
    };
    let rises = |n: usize, j: usize| {
        let (c, p) = (
            grid.center(j) - grid.center(n),
            grid.point[j] - grid.point[n],
        );
        c.z > 0.0 && p.norm() > ALONG_EDGE * c.norm()
    };
    let rim = |n: usize| -> Option<Rim> {
        let mut found = None;
        for j in around(n, 1) {
            match (ground(j), is_mine[j]) {
                (true, false) if rises(n, j) => return Some(Rim::Foot),
                (true, false) => found = Some(Rim::Edge),
                (false, _) if border && found.is_none() => found = Some(Rim::Border),
                _ => {}
            }
        }
        found
    };
    let rims: Vec<(usize, Rim)> = mine
        .iter()
        .filter(|&&n| ground(n))
        .filter_map(|&n| rim(n).map(|r| (n, r)))
        .collect();
    let mut out: Vec<(usize, f64)> = Vec::with_capacity(3 * rims.len());
    for &(n, r) in &rims {
        match r {
            Rim::Foot => {
                let far = around(n, NEAR_RIM)
                    .filter(|&j| ground(j) && !is_mine[j] && rises(n, j))
                    .map(|j| to_foot(grid, n, j))
                    .fold(f64::INFINITY, f64::min);
                let far = far.clamp(0.0, grid.step);
                out.push((n, FROM_FOOT + passes(metric, n, far)));
            }
            Rim::Edge => {
                out.push((n, 1.0 - FROM_EDGE));
                for j in around(n, NEAR_RIM).filter(|&j| is_mine[j] && ground(j)) {
                    let d = grid.point[j] - grid.point[n];
                    let v = length_sq(&metric.tensor[j], &d.xy()).sqrt();
                    out.push((j, 1.0 - FROM_EDGE + v));
                }
            }
            Rim::Border => out.push((n, 1.0 - BESIDE_BORDER + to_border(grid, metric, n))),
        }
    }
    out.retain(|s| s.1.is_finite());
    out
}

/// How far a ball at node `n` may go towards a wall before it touches what the ball at `j` touches, mm.
fn to_foot(grid: &ToolCentreGrid, n: usize, j: usize) -> f64 {
    let r = grid.radius;
    let p = grid.point[j];
    let height = (p.z - grid.point[n].z).clamp(0.0, r);
    (grid.xy(n) - p.xy()).norm() - (height * (2.0 * r - height)).sqrt()
}

/// A way of so many mm at a node, in passes, whichever way it goes.
fn passes(metric: &Metric, node: usize, mm: f64) -> f64 {
    let m = &metric.tensor[node];
    mm * (0.5 * (m[0] + m[2])).sqrt()
}

/// Passes from a node to the part's border beside it; 0 where there is none.
fn to_border(grid: &ToolCentreGrid, metric: &Metric, node: usize) -> f64 {
    let from = grid
        .crossings
        .partition_point(|c| (c.inside as usize) < node);
    grid.crossings[from..]
        .iter()
        .take_while(|c| c.inside as usize == node)
        .map(|c| {
            length_sq(
                &metric.tensor[node],
                &(c.contact.center.xy() - grid.xy(node)),
            )
            .sqrt()
        })
        .filter(|v| v.is_finite())
        .reduce(f64::min)
        .unwrap_or(0.0)
}

/// Whether a node has ground of another feature beside it.
fn touches(grid: &ToolCentreGrid, regions: &Regions, node: usize, feature: usize) -> bool {
    (-1..=1).any(|dy| {
        (-1..=1).any(|dx| {
            grid.neighbour(node, (dx, dy))
                .is_some_and(|j| regions.label[j] as usize == feature + 1)
        })
    })
}

/// Length of the border that a feature shares with each of the others, mm, to within the grid.
pub fn shared(grid: &ToolCentreGrid, regions: &Regions, index: usize) -> Vec<f64> {
    let mut out = vec![0.0; regions.features.len()];
    let Some(f) = regions.features.get(index) else {
        return out;
    };
    for n in nodes(grid, f) {
        if regions.label[n] as usize != index + 1 {
            continue;
        }
        for d in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            if let Some(j) = grid.neighbour(n, d)
                && let Some(k) = (regions.label[j] as usize).checked_sub(1)
                && k != index
            {
                // A border at 45 degrees has two such pairs for every 1.4 steps of its length.
                out[k] += 0.8 * grid.step;
            }
        }
    }
    out
}

/// The widest step of plane sections, mm, that leaves no cusp over the wanted one but on a small share of some nodes.
pub fn widest_step(
    cusp: &Metric,
    nodes: impl Iterator<Item = usize>,
    across: &Vector2,
    over_share: f64,
) -> Option<f64> {
    let steps = nodes
        .map(|n| dual(cusp, n, across).sqrt())
        .filter(|s| s.is_finite() && *s > 0.0);
    quantile(steps.collect(), over_share)
}

/// Squared length of a slope in a metric's dual norm.
fn dual(metric: &Metric, node: usize, g: &Vector2) -> f64 {
    let m = &metric.tensor[node];
    let det = m[0] * m[2] - m[1] * m[1];
    (m[2] * g.x * g.x - 2.0 * m[1] * g.x * g.y + m[0] * g.y * g.y) / det
}

fn quantile(mut of: Vec<f64>, share: f64) -> Option<f64> {
    if of.is_empty() {
        return None;
    }
    let k = ((of.len() as f64 * share) as usize).min(of.len() - 1);
    let (_, v, _) = of.select_nth_unstable_by(k, f64::total_cmp);
    Some(*v)
}
