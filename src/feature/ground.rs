//! The state of growing: which ground is taken, and how far away its rims are.
//!
//! A feature is taken in one go: what a march found up to a rim becomes a window of the grid with its own field, the levels to cut, and
//! a picture of what was taken before; then the ground remembers how many passes away the new rim is.

use super::region::{Feature, FeatureKind, Regions, Window};
use super::source::FieldSource;
use super::whole::Source;
use crate::field::march::Access;
use crate::field::{Front, MarchOptions, Metric, Ruler, march};
use crate::geom::Vector2;
use crate::reach::{NodeKind, ToolCentreGrid};
use std::collections::BinaryHeap;

/// How to grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowOptions {
    /// How distance is measured.
    pub ruler: Ruler,
    /// Features narrower than this many passes are not grown; their ground goes to others.
    pub passes_min: f64,
    /// A field runs on this many passes beyond its rim, so that neighbours know how far away the rim is.
    pub margin: f64,
    /// Share of the ground that may get a cusp over the wanted one from a ruler other than iso-scallop, before filling.
    pub over_share: f64,
    /// Critical points that would be cancelled below this difference of values are passed over.
    pub persistence: f64,
}

/// The state of growing: what is taken, and by whom.
pub(super) struct Ground<'a> {
    pub grid: &'a ToolCentreGrid,
    /// The cusp metric, whatever the ruler: what passes are judged by.
    pub cusp: &'a Metric,
    /// The ruler's own metric.
    pub metric: &'a Metric,
    pub options: &'a GrowOptions,
    /// Passes to the nearest rim of a feature taken: negative inside one.
    pub free: Vec<f64>,
    pub regions: Regions,
    /// Scratch, +inf between uses.
    pub value: Vec<f64>,
}

/// "No rim near": a finite stand-in, so that values can be interpolated.
pub(super) const FAR: f64 = 16.0;

impl<'a> Ground<'a> {
    /// Nothing taken yet.
    pub fn new(
        grid: &'a ToolCentreGrid,
        cusp: &'a Metric,
        metric: &'a Metric,
        options: &'a GrowOptions,
    ) -> Ground<'a> {
        Ground {
            grid,
            cusp,
            metric,
            options,
            free: vec![FAR; grid.len()],
            regions: Regions {
                features: Vec::new(),
                label: vec![0; grid.len()],
            },
            value: vec![f64::INFINITY; grid.len()],
        }
    }

    /// Distance from all nodes of a source at once over everything.
    pub fn march_source(&mut self, source: &Source) -> Vec<u32> {
        let seeds: Vec<(usize, f64)> = source.nodes.iter().map(|&n| (n, 0.0)).collect();
        let how = MarchOptions {
            front: source.front,
            near_steps: 3,
        };
        march(
            self.grid,
            self.metric,
            &seeds,
            &|_| Access::Open,
            &how,
            &mut self.value,
            &mut |_, _| true,
        )
    }

    /// Distance from a node over ground not yet taken (and one node into what is), into `value`. Returns the nodes reached.
    pub fn march_from(
        &mut self,
        seed: usize,
        settle: &mut dyn FnMut(usize, f64) -> bool,
    ) -> Vec<u32> {
        let free = &self.free;
        let access = |node: usize| {
            if free[node] >= 0.0 {
                Access::Open
            } else {
                Access::Dead
            }
        };
        match self.options.ruler {
            Ruler::Isoplanar(across) => planes(
                self.grid,
                self.metric,
                seed,
                &across,
                &access,
                &mut self.value,
                settle,
            ),
            _ => {
                let how = MarchOptions {
                    front: Front::Round,
                    near_steps: 3,
                };
                march(
                    self.grid,
                    self.metric,
                    &[(seed, 0.0)],
                    &access,
                    &how,
                    &mut self.value,
                    settle,
                )
            }
        }
    }

    /// Drops what the last march found.
    pub fn forget(&mut self, touched: &[u32]) {
        for &n in touched {
            self.value[n as usize] = f64::INFINITY;
        }
    }

    /// Makes a feature of what the last march found up to `rim` (everything, if infinite), and clears the scratch.
    pub fn take(
        &mut self,
        kind: FeatureKind,
        seed: Option<usize>,
        saddle: Option<usize>,
        rim: f64,
        touched: &[u32],
    ) {
        let own: Vec<u32> = touched
            .iter()
            .copied()
            .filter(|&n| self.free[n as usize] >= 0.0 && self.value[n as usize] <= rim)
            .collect();
        let scale = self.scale(&own);
        let top = own
            .iter()
            .map(|&n| self.value[n as usize])
            .fold(0.0, f64::max);
        // In passes of this ruler from here on.
        let rim = if rim.is_finite() { rim } else { top } * scale;
        let rim_is_cut = saddle.is_some();
        for &n in touched {
            self.value[n as usize] *= scale;
        }
        let field = Window::around(self.grid, touched, &self.value);
        let free = Window::around(self.grid, touched, &self.free);
        let label = (self.regions.features.len() + 1).min(u16::MAX as usize) as u16;
        let mut area = 0.0;
        for &n in &own {
            let i = n as usize;
            // A saddle stands on the rims of both its neighbours: it stays with the first.
            if self.grid.kind[i] == NodeKind::Ground && self.regions.label[i] == 0 {
                self.regions.label[i] = label;
                area += self.area_of(i);
            }
        }
        for &n in touched {
            let i = n as usize;
            // A part without a saddle left takes all it reached: nothing of it stays free.
            let past = if rim_is_cut {
                self.value[i] - rim
            } else {
                -1.0
            };
            self.free[i] = self.free[i].min(past);
        }
        self.regions.features.push(Feature {
            kind,
            seed,
            saddle,
            source: FieldSource::Seed,
            levels: levels(rim, rim_is_cut),
            field,
            rim,
            free,
            area_mm2: area,
        });
        self.forget(touched);
    }

    /// Area of the surface that one node stands for, mm².
    pub fn area_of(&self, node: usize) -> f64 {
        let n = (self.grid.center(node) - self.grid.point[node]) / self.grid.radius;
        self.grid.step * self.grid.step / n.z.clamp(0.05, 1.0)
    }

    /// By how much a ruler's values must be stretched so that one unit leaves at most the wanted cusp, but for a small share of the
    /// ground. The a-priori cusp of any field is h / |grad|^2 in the cusp metric's dual norm. 1 for iso-scallop, by construction.
    fn scale(&self, own: &[u32]) -> f64 {
        if self.options.ruler == Ruler::IsoScallop {
            return 1.0;
        }
        let g = self.grid;
        let mut ratio: Vec<f64> = own
            .iter()
            .filter_map(|&n| {
                let i = n as usize;
                if g.kind[i] != NodeKind::Ground {
                    return None;
                }
                let v = |d| {
                    g.neighbour(i, d)
                        .map(|j| self.value[j])
                        .filter(|v| v.is_finite())
                };
                let grad = match self.options.ruler {
                    Ruler::Isoplanar(u) => {
                        u / (self.metric.tensor[i][0] + self.metric.tensor[i][2])
                            .sqrt()
                            .recip()
                    }
                    _ => {
                        Vector2::new(v((1, 0))? - v((-1, 0))?, v((0, 1))? - v((0, -1))?)
                            / (2.0 * g.step)
                    }
                };
                let m = &self.cusp.tensor[i];
                let det = m[0] * m[2] - m[1] * m[1];
                let dual = (m[2] * grad.x * grad.x - 2.0 * m[1] * grad.x * grad.y
                    + m[0] * grad.y * grad.y)
                    / det;
                (dual > 1e-6 && dual.is_finite()).then(|| 1.0 / dual)
            })
            .collect();
        if ratio.is_empty() {
            return 1.0;
        }
        ratio.sort_unstable_by(f64::total_cmp);
        let k =
            ((ratio.len() as f64 * (1.0 - self.options.over_share)) as usize).min(ratio.len() - 1);
        ratio[k].sqrt()
    }
}

/// The innermost pass round a seed lies so far from it, in passes: what is inside is cut, and it bends no tighter than it must.
const INNERMOST: f64 = 0.45;

/// Levels to cut up to a rim, at most one pass apart, rising: from half a pass off the seed; or, when the rim is to be cut, from the rim
/// downwards, with what is left about the seed in the innermost. (Stretching all gaps evenly to fit would cost half a pass round the whole
/// of the feature.)
fn levels(rim: f64, rim_is_cut: bool) -> Vec<f64> {
    if rim_is_cut {
        let n = (rim - INNERMOST).floor().max(0.0) as usize;
        let mut out = Vec::with_capacity(n + 2);
        if rim - n as f64 > INNERMOST {
            out.push(INNERMOST);
        }
        out.extend((0..=n).rev().map(|k| rim - k as f64));
        out
    } else {
        let n = (rim + 0.5).ceil() as usize;
        (0..n)
            .map(|k| k as f64 + 0.5)
            .filter(|&l| l < rim)
            .collect()
    }
}

/// Distance in one coordinate from a seed, over the ground connected to it, settled in order of distance.
fn planes(
    grid: &ToolCentreGrid,
    metric: &Metric,
    seed: usize,
    across: &Vector2,
    access: &dyn Fn(usize) -> Access,
    value: &mut [f64],
    settle: &mut dyn FnMut(usize, f64) -> bool,
) -> Vec<u32> {
    let from = grid.xy(seed);
    let unit = |n: usize| (metric.tensor[n][0] + metric.tensor[n][2]).sqrt();
    let distance = |n: usize| (grid.xy(n) - from).dot(across).abs() * unit(n);
    let key = |v: f64, n: usize| std::cmp::Reverse((v.to_bits(), n)); // bits of a positive number rise with it
    let mut heap = BinaryHeap::new();
    let mut touched = vec![seed as u32];
    value[seed] = 0.0;
    heap.push(key(0.0, seed));
    while let Some(std::cmp::Reverse((bits, node))) = heap.pop() {
        if !settle(node, f64::from_bits(bits)) {
            break;
        }
        if access(node) != Access::Open {
            continue;
        }
        for dy in -1..=1 {
            for dx in -1..=1 {
                if let Some(j) = grid.neighbour(node, (dx, dy))
                    && value[j] == f64::INFINITY
                    && metric.is_set(j)
                    && access(j) != Access::Closed
                {
                    value[j] = distance(j);
                    touched.push(j as u32);
                    heap.push(key(value[j], j));
                }
            }
        }
    }
    touched
}

#[cfg(test)]
mod tests {
    use super::levels;

    #[test]
    fn no_gap_is_wider_than_a_pass_and_the_rim_is_cut() {
        for rim in [0.2, 0.5, 0.51, 1.0, 1.4, 3.7, 40.0] {
            let l = levels(rim, true);
            assert!((l[l.len() - 1] - rim).abs() < 1e-12);
            assert!(
                l[0] <= 0.5 + 1e-12 && l.windows(2).all(|w| w[1] - w[0] <= 1.0 + 1e-12),
                "{l:?}"
            );
        }
        assert_eq!(levels(2.4, false), vec![0.5, 1.5]);
    }
}
