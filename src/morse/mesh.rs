//! Critical points and Morse cells of a function on a raw mesh, open or closed.
//!
//! Banchoff's rule on each vertex's link, read off counts: 1 - Euler number of the lower part of the link is 1 at a pit, 0 where
//! nothing happens, -1 at a saddle, -2 at a monkey saddle, whatever the link looks like. On the border the paper's rule holds, as on the
//! grid: only vertices above or below *every* neighbour are critical there, and never saddles. Ties are decided by index.
//!
//! Cells: from each vertex down the steepest edge to a pit (its *basin*), or up to a peak (its *hill*); those of cancelled
//! extremes go to the one they were merged into. (H. Edelsbrunner, J. Harer, A. Zomorodian, *Hierarchical Morse-Smale complexes for
//! piecewise linear 2-manifolds*, 2003.)

use super::average::{AverageOptions, average_distance};
use super::cancel::{Graph, Pair, peaks, pits};
use super::critical::{CriticalKind, CriticalPoint};
use super::curvature;
use super::euler::{Euler, indices};
use super::function::{MorseFunction, noise};
use super::plane::Plane;
use super::select::{Saddle, select};
use super::surface::Surface;

/// How to work functions out on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// Curvature is averaged over this radius along the mesh, mm.
    pub radius: f64,
    /// How finely average distance is integrated.
    pub average: AverageOptions,
}

/// A function's value at each vertex of a mesh: height is its z.
pub fn values(surface: &Surface, function: MorseFunction, options: &MeshOptions) -> Vec<f64> {
    match function {
        MorseFunction::Height => surface.points.iter().map(|p| p.z).collect(),
        MorseFunction::Projection => {
            let plane = Plane::fitted(surface);
            surface.points.iter().map(|p| plane.distance(p)).collect()
        }
        MorseFunction::MeanCurvature => curvature::of_surface(surface, options.radius),
        MorseFunction::Geodesic => average_distance(surface, &options.average),
    }
}

/// Differences of a function on a mesh that mean nothing, in its unit: see [`noise`].
pub fn noise_of(
    surface: &Surface,
    function: MorseFunction,
    value: &[f64],
    options: &MeshOptions,
) -> f64 {
    let roughness = match function {
        MorseFunction::MeanCurvature => curvature::roughness_of_surface(surface, options.radius),
        _ => roughness(surface, value),
    };
    noise(function, value.iter().copied(), roughness)
}

/// How rough a function is from vertex to vertex, in its unit, as a standard deviation: a smooth one next to nothing, a scanned mesh's
/// height its noise.
///
/// It is the median of what a vertex differs from the mean of its neighbours, less the same of the neighbours: curvature drops
/// out of it, noise stays.
fn roughness(surface: &Surface, value: &[f64]) -> f64 {
    let off = |of: &[f64]| -> Vec<f64> {
        (0..surface.len())
            .map(|v| {
                let n = surface.neighbours(v);
                if surface.border[v] || n.is_empty() {
                    return 0.0;
                }
                of[v] - n.iter().map(|&u| of[u as usize]).sum::<f64>() / n.len() as f64
            })
            .collect()
    };
    let mut r: Vec<f64> = off(&off(value))
        .into_iter()
        .zip(&surface.border)
        .filter(|(_, b)| !**b)
        .map(|(r, _)| r.abs())
        .collect();
    if r.is_empty() {
        return 0.0;
    }
    let middle = r.len() / 2;
    let (_, m, _) = r.select_nth_unstable_by(middle, f64::total_cmp);
    // A normal distribution's median of |x|, and what two differences add to it.
    *m / (0.6745 * 1.25)
}

/// What belongs to an extreme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Index of the extreme in the list of critical points.
    pub extreme: usize,
    /// Area from which one climbs to this peak, or falls into this pit, mm2. The hills together make up the mesh, and the basins too.
    pub area_mm2: f64,
    /// Triangles with their highest corner on the hill, or their lowest one in the basin.
    pub triangles: usize,
}

/// A function's critical points on a mesh at every threshold.
#[derive(Debug)]
pub struct MeshMorse<'a> {
    surface: &'a Surface,
    value: &'a [f64],
    peaks: Vec<Pair>,
    pits: Vec<Pair>,
    saddles: Vec<Saddle>,
    /// Peaks less saddles plus pits before anything is cancelled, against Euler's number.
    pub euler: Euler,
}

struct Values<'a>(&'a Surface, &'a [f64]);

impl Graph for Values<'_> {
    fn len(&self) -> usize {
        self.1.len()
    }

    fn is_active(&self, _: usize) -> bool {
        true
    }

    fn value(&self, node: usize) -> f64 {
        self.1[node]
    }

    #[inline]
    fn each_neighbour(&self, node: usize, see: &mut dyn FnMut(usize)) {
        for &j in self.0.neighbours(node) {
            see(j as usize);
        }
    }
}

impl<'a> MeshMorse<'a> {
    /// Reads every link and floods the mesh from below and above. `value` holds a number for each vertex. O(n log n).
    pub fn new(surface: &'a Surface, value: &'a [f64]) -> MeshMorse<'a> {
        let (low, _) = indices(surface, value);
        let saddles = low
            .iter()
            .enumerate()
            .filter(|&(v, i)| *i < 0 && !surface.border[v])
            .map(|(node, i)| Saddle {
                node,
                arms: i.unsigned_abs(),
            })
            .collect();
        let graph = Values(surface, value);
        MeshMorse {
            surface,
            value,
            peaks: peaks(&graph),
            pits: pits(&graph),
            saddles,
            euler: Euler::of_surface(surface, value),
        }
    }

    /// Extremes and where they end.
    pub fn pairs(&self) -> impl Iterator<Item = (CriticalKind, &Pair)> {
        let kinds = [CriticalKind::Maximum, CriticalKind::Minimum];
        [&self.peaks, &self.pits]
            .into_iter()
            .zip(kinds)
            .flat_map(|(list, kind)| list.iter().map(move |p| (kind, p)))
    }

    /// The critical points that are left when pairs below `limit` are cancelled: peaks by falling value, pits by rising value, saddles by
    /// falling value. A saddle of several arms is listed once per arm too many.
    pub fn critical_points(&self, limit: f64) -> Vec<CriticalPoint> {
        let mut out: Vec<CriticalPoint> = select(&self.peaks, &self.pits, &self.saddles, limit)
            .into_iter()
            .map(|c| CriticalPoint {
                kind: c.kind,
                node: c.node,
                boundary: self.surface.border[c.node],
                center: self.surface.points[c.node],
                contact: self.surface.points[c.node],
                value: self.value[c.node],
                persistence: c.persistence,
            })
            .collect();
        out.sort_by(|a, b| {
            let rise = if a.kind == CriticalKind::Minimum {
                1.0
            } else {
                -1.0
            };
            a.kind
                .cmp(&b.kind)
                .then((rise * a.value).total_cmp(&(rise * b.value)))
                .then(a.node.cmp(&b.node))
        });
        out
    }

    /// Hills and basins of the extremes that [`MeshMorse::critical_points`] lists at the same limit, in its order.
    pub fn cells(&self, critical: &[CriticalPoint], limit: f64) -> Vec<Cell> {
        let hill = self.owners(&self.peaks, true, limit);
        let basin = self.owners(&self.pits, false, limit);
        let mut area = [vec![0.0; self.value.len()], vec![0.0; self.value.len()]];
        let mut triangles = [vec![0usize; self.value.len()], vec![0; self.value.len()]];
        for (v, a) in self.surface.area.iter().enumerate() {
            area[0][hill[v] as usize] += a;
            area[1][basin[v] as usize] += a;
        }
        let lower = |a: u32, b: u32| (self.value[a as usize], a) < (self.value[b as usize], b);
        for t in &self.surface.triangles {
            let (mut top, mut bottom) = (t[0], t[0]);
            for &v in &t[1..] {
                top = if lower(top, v) { v } else { top };
                bottom = if lower(v, bottom) { v } else { bottom };
            }
            triangles[0][hill[top as usize] as usize] += 1;
            triangles[1][basin[bottom as usize] as usize] += 1;
        }
        critical
            .iter()
            .enumerate()
            .filter(|(_, c)| c.kind != CriticalKind::Saddle)
            .map(|(k, c)| {
                let side = usize::from(c.kind == CriticalKind::Minimum);
                Cell {
                    extreme: k,
                    area_mm2: area[side][c.node],
                    triangles: triangles[side][c.node],
                }
            })
            .collect()
    }

    /// For each vertex the extreme it belongs to, among those left at a limit.
    fn owners(&self, pairs: &[Pair], up: bool, limit: f64) -> Vec<u32> {
        let n = self.value.len();
        let before = |a: usize, b: usize| {
            let o = self.value[a].total_cmp(&self.value[b]).then(a.cmp(&b));
            if up { o.is_gt() } else { o.is_lt() }
        };
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_unstable_by(|&a, &b| {
            let o = self.value[a as usize]
                .total_cmp(&self.value[b as usize])
                .then(a.cmp(&b));
            if up { o.reverse() } else { o }
        });
        // From the extremes on: whoever a vertex leads to has its owner already.
        let mut owner = vec![u32::MAX; n];
        for &v in &order {
            let v = v as usize;
            let mut best: Option<(f64, usize)> = None;
            for &u in self.surface.neighbours(v) {
                let u = u as usize;
                if !before(u, v) {
                    continue;
                }
                let length = (self.surface.points[u] - self.surface.points[v]).norm();
                let steep = (self.value[u] - self.value[v]).abs() / length.max(1e-300);
                if best.is_none_or(|b| steep > b.0) {
                    best = Some((steep, u));
                }
            }
            owner[v] = best.map_or(v as u32, |b| owner[b.1]);
        }
        // Older extremes outlive younger ones: settle them in order of the flood, and every chain is one step long.
        let mut heir: Vec<u32> = (0..n as u32).collect();
        let mut gone: Vec<&Pair> = pairs.iter().filter(|p| p.persistence < limit).collect();
        gone.sort_unstable_by(|a, b| {
            if before(a.extreme, b.extreme) {
                std::cmp::Ordering::Less
            } else {
                std::cmp::Ordering::Greater
            }
        });
        for p in gone {
            if let Some(into) = p.into {
                heir[p.extreme] = heir[into];
            }
        }
        owner.iter().map(|&o| heir[o as usize]).collect()
    }
}
