//! Cusp and gouge at one cell, and between the centres of cells.

use super::FinishOptions;
use super::map::MapPart;
use super::tally::{AREA_GRAIN, Tally};
use crate::geom::Point;
use crate::reach::DropCutter;
use crate::sweep::nearest::Paths;
use crate::sweep::peak::{self, Look};
use crate::sweep::tiles::Tile;
use crate::sweep::{Lattice, Reachable};

/// Gouges shallower than this (first order, mm) are not looked into cell by cell: rounding to a micrometre makes them everywhere.
const GOUGE_SEEN: f64 = 1e-3;

/// What judging a cell needs beside the cell.
pub(super) struct Judge<'a> {
    /// For a look between the centres of cells.
    pub(super) part: Option<&'a DropCutter>,
    pub(super) paths: &'a Paths,
    pub(super) options: &'a FinishOptions,
    pub(super) whole: Lattice,
    /// Cells of the lattice on a side of one of the map's.
    pub(super) factor: usize,
}

impl Judge<'_> {
    /// Judges the cells of `core`; `reach` and `swept_z` cover those of `wide`.
    pub(super) fn look(
        &self,
        reach: &Reachable,
        swept_z: &[f64],
        core: &Tile,
        wide: &Tile,
        tally: &mut Tally,
    ) -> MapPart {
        let lattice = &reach.lattice;
        let (x0, y0) = (
            core.columns.start / self.factor,
            core.rows.start / self.factor,
        );
        let nx = core.columns.end.div_ceil(self.factor) - x0;
        let ny = core.rows.end.div_ceil(self.factor) - y0;
        let mut part = MapPart {
            nx,
            cells: vec![[f32::NAN; 4]; nx * ny],
        };
        for iy in core.rows.clone() {
            for ix in core.columns.clone() {
                let i = lattice.index(ix - wide.columns.start, iy - wide.rows.start);
                let at = (iy / self.factor - y0) * nx + ix / self.factor - x0;
                let [worst_cusp, worst_gouge, highest, rest] = &mut part.cells[at];
                // Of several the highest; max takes a number rather than NaN.
                *highest = highest.max(reach.part_z[i] as f32);
                if reach.part_z[i].is_nan() || !reach.reach_z[i].is_finite() {
                    continue;
                }
                let stretch = stretch(reach, i);
                let (cusp, gouge) = self.cell(reach, i, swept_z[i], stretch);
                let top = self
                    .top(reach, i, swept_z)
                    .map_or(cusp, |top| cusp.max(top));
                let area = (stretch * AREA_GRAIN).round() as u64;
                tally.cell(
                    self,
                    reach,
                    i,
                    self.whole.index(ix, iy),
                    area,
                    [cusp, top, gouge],
                );
                *worst_cusp = worst_cusp.max(top);
                *worst_gouge = worst_gouge.max(gouge);
                *rest = rest.max(reach.rest(i) as f32);
            }
        }
        part
    }

    /// Cusp and gouge at a cell, mm.
    fn cell(&self, reach: &Reachable, i: usize, z: f64, stretch: f64) -> (f32, f32) {
        let (options, radius) = (self.options, reach.radius);
        let q = reach.lattice.center_at(i);
        // Over a sharp edge many balls touch: the part's own slope keeps the normal from being any of theirs.
        let mut n = f64::from(reach.normal_z[i]);
        if reach.reach_z[i] - reach.part_z[i] < 1e-3 {
            n = n.max(1.0 / stretch);
        }
        // The ball that reaches the cell best has its centre where a pass should have put one.
        let expected = || reach.center_over(i);
        let mut cusp = (z - reach.reach_z[i]) * n;
        if z == f64::INFINITY {
            cusp = f64::INFINITY;
        }
        if cusp > 0.8 * options.scallop {
            let p = Point::new(q.x, q.y, reach.reach_z[i]);
            let limit = radius + options.uncut_above;
            cusp = self.paths.distance(&p, limit, &expected()) - radius;
        }
        let mut gouge = 0.0;
        if (reach.part_z[i] - z) * n > GOUGE_SEEN {
            let p = Point::new(q.x, q.y, reach.part_z[i]);
            gouge = (radius - self.paths.distance(&p, radius, &expected())).max(0.0);
        }
        (cusp.max(0.0) as f32, gouge as f32)
    }
}

/// Cusps are looked at between the centres of cells where they may be higher than this share of what is asked for.
const LOOKED_AT: f64 = 1.0;
/// ... and where the ball reaches the part but for this share: elsewhere only the cells' centres are known well enough.
const REACHED: f64 = 0.3;

impl Judge<'_> {
    /// The highest cusp anywhere in a cell, mm, if one near the limit may pass through it beside its centre.
    fn top(&self, reach: &Reachable, i: usize, swept_z: &[f64]) -> Option<f32> {
        let part = self.part?;
        let (l, h, radius) = (&reach.lattice, self.options.scallop, reach.radius);
        let height = |i: usize| (swept_z[i] - reach.reach_z[i]) * f64::from(reach.normal_z[i]);
        let own = height(i);
        let missed = (2.0 * h / radius).sqrt() * 0.71 * l.step;
        let enough = (LOOKED_AT - peak::SLACK) * h;
        // What is not a number is not looked at.
        if !(own > enough - missed && own < self.options.uncut_above) {
            return None;
        }
        let beside = |dx: i64, dy: i64| l.beside(i, dx, dy).map_or(f64::NEG_INFINITY, height);
        let crest = peak::crest(beside, l.step * l.step / (2.0 * radius));
        if crest <= enough || !peak::reached(reach, i, REACHED * h) {
            return None;
        }
        let look = Look::at(reach, i, reach.part_z[i]);
        // What facets hold back is the part's, not a cusp.
        let rest = reach.rest(i).max(0.0);
        let enough = radius + rest + LOOKED_AT * h;
        Some((peak::highest(&look, part, self.paths, enough) - radius - rest) as f32)
    }
}

/// Area of the part's surface over a cell, in cells, 1 to 10. On each axis the gentler of the two one-sided slopes counts.
fn stretch(reach: &Reachable, i: usize) -> f64 {
    let lattice = &reach.lattice;
    let (ix, iy) = lattice.cell(i);
    let z = reach.part_z[i];
    let slope_sq = |before: Option<usize>, after: Option<usize>| {
        [before, after]
            .into_iter()
            .flatten()
            .map(|j| ((reach.part_z[j] - z) / lattice.step).powi(2))
            .filter(|s| s.is_finite())
            .fold(f64::INFINITY, f64::min)
    };
    let gx = slope_sq(
        (ix > 0).then(|| i - 1),
        (ix + 1 < lattice.nx).then_some(i + 1),
    );
    let gy = slope_sq(
        (iy > 0).then(|| i - lattice.nx),
        (iy + 1 < lattice.ny).then_some(i + lattice.nx),
    );
    let flat = |g: f64| if g.is_finite() { g } else { 0.0 };
    (1.0 + flat(gx) + flat(gy)).sqrt().min(10.0)
}
