//! How good the surface left by a swept ball is, measured against what this ball can reach.
//!
//! ```text
//!        .-'-.     .-'-.      swept: what the ball left           cusp  = distance from the reachable surface to the
//!   ____/_____\___/_____\_    reachable: what it could have left          nearest ball (or shank) that passed, less R
//!  ///////// part //////////  part                                gouge = how deep a ball went into the part's own points
//! ```
//! What is judged: every cell whose vertical line hits the part, right to the border. Upright walls have no area in plan and are
//! not judged here. Areas are those of the surface, rest material apart, which is in plan: cell area times sqrt(1 + slope^2) of the part, at most ten times the cell's;
//! next to a step the slope is that of the cell's own side.

use crate::geom::{Point, Point2};
use crate::reach::DropCutter;
use crate::sweep::nearest::Paths;
use crate::sweep::peak::{self, Look};
use crate::sweep::reachable::ALIGNED;
use crate::sweep::tiles::{ReachTiles, Tile, area};
use crate::sweep::{Lattice, Reachable, Segment, Swept};
use rayon::prelude::*;
use serde::Serialize;

/// What counts as what. All mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishOptions {
    /// The cusp height asked for.
    pub scallop: f64,
    /// A cusp higher than this is not a cusp but ground left uncut: it is out of the percentiles and in the uncut area.
    pub uncut_above: f64,
    /// Where the reachable surface stands more than this above the part, along the normal, the part keeps rest material: what stands
    /// less than a cusp is a cusp.
    pub rest_above: f64,
}

impl FinishOptions {
    /// The usual limits for a cusp height: uncut from ten times as high (0.2 mm at least), rest from the height itself.
    pub fn for_scallop(scallop: f64) -> FinishOptions {
        FinishOptions {
            scallop,
            uncut_above: (10.0 * scallop).max(0.2),
            rest_above: scallop,
        }
    }
}

/// Gouges shallower than this (first order, mm) are not looked into cell by cell: rounding to a micrometre makes them everywhere.
const GOUGE_SEEN: f64 = 1e-3;

/// What is left or missing at each cell, along the normal. On a large part a cell of the map stands for a square of those that were
/// judged, and holds the worst of them.
#[derive(Clone, Debug, PartialEq)]
pub struct CuspMap {
    /// Where.
    pub lattice: Lattice,
    /// Height left above the reachable surface, mm, the highest in the cell where it is near the height asked for; NaN where not judged, `+inf` where nothing came within the uncut limit.
    pub cusp_mm: Vec<f32>,
    /// Depth cut into the part at the cell's own point, mm; 0 for none or less than a micrometre, NaN where not judged.
    pub gouge_mm: Vec<f32>,
    /// Top of the part, work coordinates, mm; NaN off the part.
    pub part_mm: Vec<f32>,
    /// Height of the reachable surface above the part, along the normal, to first order, mm; NaN where not judged.
    pub rest_mm: Vec<f32>,
}

/// Cusp heights in micrometres by share of the judged, cut area: `p99` = 99 % of it is at or below.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Half of the area.
    pub p50: f64,
    /// 95 %.
    pub p95: f64,
    /// 99 %.
    pub p99: f64,
    /// 99.9 %.
    pub p999: f64,
    /// The highest found: at a cell's centre, or between the centres where it may be near the height asked for.
    pub max: f64,
}

/// The finish in figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FinishStats {
    /// Cusp heights, um.
    pub scallop_um: Percentiles,
    /// Share of the judged area (uncut ground included) above the cusp height asked for, %.
    pub over_scallop_area_percent: f64,
    /// Deepest cut into the part, um.
    pub gouge_um_max: f64,
    /// Area left uncut, mm².
    pub uncut_area_mm2: f64,
    /// Rest material in plan (seen from above), mm²: where more than the limit for it, usually the cusp height asked for, stays on the
    /// part, along the normal, wherever this ball goes. Upright walls have no area in plan; [`crate::sweep::rest()`] has the area on the
    /// surface, walls included.
    pub rest_area_mm2: f64,
    /// Area judged, mm².
    pub judged_area_mm2: f64,
    /// Highest cusp that still counts as one: x, y, z, mm.
    pub max_at: Option<[f64; 3]>,
    /// Deepest gouge: x, y, z, mm.
    pub gouge_at: Option<[f64; 3]>,
    /// Middle of some uncut cell: x, y, z, mm.
    pub uncut_at: Option<[f64; 3]>,
}

/// Map and figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// Cell by cell.
    pub map: CuspMap,
    /// In sum.
    pub stats: FinishStats,
}

/// Why nothing could be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FinishError {
    /// The two maps do not lie on the same cells.
    #[error(
        "the swept map and the reachable surface lie on different lattices: sweep on the lattice of the reachable surface"
    )]
    Lattice,
    /// The part casts no shadow on any cell.
    #[error(
        "no cell of the lattice lies over the part: nothing to judge; check the units and the lattice step"
    )]
    NothingToJudge,
}

/// Judges a swept map that covers all of what is reachable. `segments` are the moves of the ball's centre that made it: wherever the
/// vertical difference of the maps hints at a cusp near the limit or at a gouge, the distance to them decides, exactly, also beside
/// walls, where a vertical difference overstates without bound. The peak of a cusp is seen as near as a cell centre comes to it:
/// half a step times the slope of its flank, sqrt(2 h / R), at most.
pub fn finish(
    reach: &Reachable,
    swept: &Swept,
    segments: &[Segment],
    options: &FinishOptions,
) -> Result<Finish, FinishError> {
    let lattice = reach.lattice;
    let n = lattice.len();
    if swept.lattice != lattice
        || swept.z.len() != n
        || [
            reach.reach_z.len(),
            reach.part_z.len(),
            reach.by.len(),
            reach.normal_z.len(),
        ] != [n; 4]
    {
        return Err(FinishError::Lattice);
    }
    let judge = Judge {
        part: None,
        paths: &Paths::new(segments, 0.25 * reach.radius, area(&lattice)),
        options,
        whole: lattice,
        factor: 1,
    };
    let all = Tile {
        columns: 0..lattice.nx,
        rows: 0..lattice.ny,
    };
    let mut tally = Tally::default();
    let mut map = CuspMap::blank(&lattice, 1);
    let part = judge.look(reach, &swept.z, &all, &all, &mut tally);
    map.place(&part, [0, 0]);
    let stats = tally.stats(&lattice)?;
    Ok(Finish { map, stats })
}

/// Judges tile by tile: `sweep` makes the map of what is left of one tile (and its rim), and whatever else it finds out, which comes
/// back in the order of the tiles. `paths` are the moves that it sweeps. Same figures for any number of threads and any size of tile;
/// the map is coarser where it would be larger than [`MAP_CELLS`].
pub fn finish_tiles<X: Send>(
    tiles: &ReachTiles,
    paths: &Paths,
    options: &FinishOptions,
    sweep: impl Fn(usize, &Reachable) -> (Swept, X) + Sync,
) -> (Result<Finish, FinishError>, Vec<X>) {
    let whole = *tiles.lattice();
    let mut factor = 1;
    while whole.nx.div_ceil(factor) * whole.ny.div_ceil(factor) > MAP_CELLS && factor < ALIGNED {
        factor *= 2;
    }
    let judge = Judge {
        part: Some(tiles.drop_cutter()),
        paths,
        options,
        whole,
        factor,
    };
    type Found<X> = (Tally, Vec<(usize, MapPart, X)>);
    let start = || -> Found<X> { (Tally::default(), Vec::new()) };
    let (tally, mut parts) = (0..tiles.len())
        .into_par_iter()
        .fold(start, |(mut tally, mut parts), k| {
            let reach = tiles.reach(k);
            let (swept, found) = sweep(k, &reach);
            let part = judge.look(&reach, &swept.z, &tiles.tile(k), &tiles.wide(k), &mut tally);
            parts.push((k, part, found));
            (tally, parts)
        })
        .reduce(start, |mut a, b| {
            a.0.add(&b.0);
            a.1.extend(b.1);
            a
        });
    parts.sort_by_key(|p| p.0);
    let mut map = CuspMap::blank(&whole, factor);
    let mut found = Vec::with_capacity(parts.len());
    for (k, part, x) in parts {
        let t = tiles.tile(k);
        map.place(&part, [t.columns.start / factor, t.rows.start / factor]);
        found.push(x);
    }
    let stats = tally.stats(&whole);
    (stats.map(|stats| Finish { map, stats }), found)
}

/// Cells of a map at most, as far as coarser cells of up to 64 of the lattice's on a side allow.
pub const MAP_CELLS: usize = 4_000_000;

impl CuspMap {
    fn blank(whole: &Lattice, factor: usize) -> CuspMap {
        let shift = 0.5 * (factor as f64 - 1.0) * whole.step;
        let lattice = Lattice {
            origin: Point2::new(whole.origin.x + shift, whole.origin.y + shift),
            step: whole.step * factor as f64,
            nx: whole.nx.div_ceil(factor),
            ny: whole.ny.div_ceil(factor),
        };
        CuspMap {
            lattice,
            cusp_mm: vec![f32::NAN; lattice.len()],
            gouge_mm: vec![f32::NAN; lattice.len()],
            part_mm: vec![f32::NAN; lattice.len()],
            rest_mm: vec![f32::NAN; lattice.len()],
        }
    }

    fn place(&mut self, part: &MapPart, first: [usize; 2]) {
        for (row, cells) in part.cells.chunks_exact(part.nx.max(1)).enumerate() {
            let at = self.lattice.index(first[0], first[1] + row);
            for (k, [cusp, gouge, top, rest]) in cells.iter().enumerate() {
                self.cusp_mm[at + k] = *cusp;
                self.gouge_mm[at + k] = *gouge;
                self.part_mm[at + k] = *top;
                self.rest_mm[at + k] = *rest;
            }
        }
    }
}

/// A tile of the map: cusp, gouge, height of the part, rest material.
struct MapPart {
    nx: usize,
    cells: Vec<[f32; 4]>,
}

/// What judging a cell needs beside the cell.
struct Judge<'a> {
    /// For a look between the centres of cells.
    part: Option<&'a DropCutter>,
    paths: &'a Paths,
    options: &'a FinishOptions,
    whole: Lattice,
    /// Cells of the lattice on a side of one of the map's.
    factor: usize,
}

impl Judge<'_> {
    /// Judges the cells of `core`; `reach` and `swept_z` cover those of `wide`.
    fn look(
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
        let (x, y) = l.cell(i);
        let beside = |dx: i64, dy: i64| {
            let (x, y) = (x as i64 + dx, y as i64 + dy);
            if x < 0 || y < 0 || x >= l.nx as i64 || y >= l.ny as i64 {
                f64::NEG_INFINITY
            } else {
                height(l.index(x as usize, y as usize))
            }
        };
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

/// Areas are summed as whole multiples of this share of a cell: sums that do not depend on their order.
const AREA_GRAIN: f64 = (1 << 20) as f64;
/// Cusps below this are all the same, mm.
const NO_CUSP: f32 = 1.0 / (1 << 20) as f32;
/// Cusps are sorted into bins of 1/2048 of their height.
const BIN_BITS: u32 = 12;

/// Some cell that stands out, by its number in the whole lattice, so that the first of equals is found in any order.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    value: f32,
    cell: usize,
    at: [f64; 3],
}

/// What was seen so far. Adding up is exact: any order of cells gives the same.
#[derive(Clone, Debug, Default)]
struct Tally {
    judged: u64,
    over: u64,
    uncut: u64,
    rest: u64,
    highest: Option<Spot>,
    deepest: Option<Spot>,
    first_uncut: Option<Spot>,
    bins: Vec<u64>,
}

fn keep(best: &mut Option<Spot>, s: Spot) {
    let better = best.is_none_or(|b| s.value > b.value || (s.value == b.value && s.cell < b.cell));
    if better {
        *best = Some(s);
    }
}

fn bin(cusp: f32) -> usize {
    ((cusp.max(NO_CUSP).to_bits() - NO_CUSP.to_bits()) >> BIN_BITS) as usize
}

/// The highest cusp of a bin, mm.
fn bin_top(bin: usize) -> f32 {
    f32::from_bits(NO_CUSP.to_bits() + ((bin as u32 + 1) << BIN_BITS) - 1)
}

impl Tally {
    /// Cell `i` of a window, number `cell` of the whole.
    fn cell(
        &mut self,
        j: &Judge,
        reach: &Reachable,
        i: usize,
        cell: usize,
        area: u64,
        [cusp, top, gouge]: [f32; 3],
    ) {
        let o = j.options;
        let spot = |value: f32, z: f64| {
            let c = j.whole.center_at(cell);
            Spot {
                value,
                cell,
                at: [c.x, c.y, z],
            }
        };
        self.judged += area;
        if f64::from(cusp) > o.scallop * (1.0 + 1e-6) {
            self.over += area;
        }
        if f64::from(cusp) > o.uncut_above {
            self.uncut += area;
            keep(&mut self.first_uncut, spot(0.0, reach.reach_z[i]));
        } else {
            let b = bin(cusp);
            if b >= self.bins.len() {
                self.bins.resize(b + 1, 0);
            }
            self.bins[b] += area;
            let top = top.min(o.uncut_above as f32);
            if self.highest.is_none_or(|h| top >= h.value) {
                keep(&mut self.highest, spot(top, reach.reach_z[i]));
            }
        }
        if gouge > 0.0 {
            keep(&mut self.deepest, spot(gouge, reach.part_z[i]));
        }
        if reach.rest(i) > o.rest_above {
            self.rest += AREA_GRAIN as u64;
        }
    }

    fn add(&mut self, b: &Tally) {
        self.judged += b.judged;
        self.over += b.over;
        self.uncut += b.uncut;
        self.rest += b.rest;
        for (mine, theirs) in [
            (&mut self.highest, b.highest),
            (&mut self.deepest, b.deepest),
            (&mut self.first_uncut, b.first_uncut),
        ] {
            if let Some(s) = theirs {
                keep(mine, s);
            }
        }
        if b.bins.len() > self.bins.len() {
            self.bins.resize(b.bins.len(), 0);
        }
        for (mine, theirs) in self.bins.iter_mut().zip(&b.bins) {
            *mine += theirs;
        }
    }

    fn stats(&self, lattice: &Lattice) -> Result<FinishStats, FinishError> {
        if self.judged == 0 {
            return Err(FinishError::NothingToJudge);
        }
        let area = |sum: u64| sum as f64 / AREA_GRAIN * lattice.cell_area();
        Ok(FinishStats {
            scallop_um: self.percentiles(),
            over_scallop_area_percent: 100.0 * self.over as f64 / self.judged as f64,
            gouge_um_max: 1e3 * self.deepest.map_or(0.0, |s| f64::from(s.value)),
            uncut_area_mm2: area(self.uncut),
            rest_area_mm2: area(self.rest),
            judged_area_mm2: area(self.judged),
            max_at: self.highest.map(|s| s.at),
            gouge_at: self.deepest.map(|s| s.at),
            uncut_at: self.first_uncut.map(|s| s.at),
        })
    }

    /// Percentiles by area, to 1/2048 of their height, rounded up.
    fn percentiles(&self) -> Percentiles {
        let total: u64 = self.bins.iter().sum();
        let max = self.highest.map_or(0.0, |s| s.value);
        let mut out = [0.0; 4];
        let mut next = 0;
        let mut sum = 0;
        let shares = [0.5, 0.95, 0.99, 0.999];
        for (b, area) in self.bins.iter().enumerate() {
            sum += area;
            while next < shares.len() && *area > 0 && sum as f64 >= shares[next] * total as f64 {
                out[next] = 1e3 * f64::from(bin_top(b).min(max));
                next += 1;
            }
        }
        let [p50, p95, p99, p999] = out;
        Percentiles {
            p50,
            p95,
            p99,
            p999,
            max: 1e3 * f64::from(max),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use crate::reach::DropCutter;
    use crate::sweep::reachable;

    fn plane(size: f64, slope: f64) -> Mesh {
        let p = |x: f64, y: f64| Point::new(x, y, slope * y);
        Mesh {
            triangles: vec![
                [p(0.0, 0.0), p(size, 0.0), p(size, size)],
                [p(0.0, 0.0), p(size, size), p(0.0, size)],
            ],
        }
    }

    /// Passes along X at spacing w on the slope, `lift` above the exact height.
    fn passes(slope: f64, r: f64, w: f64, size: f64, lift: f64) -> Vec<Segment> {
        let c = 1.0 / (1.0f64 + slope * slope).sqrt();
        let count = (size / c / w).round() as i32;
        let w = size / c / f64::from(count);
        (0..=count)
            .map(|k| {
                // Contact at (y, slope y); the centre one radius along the normal.
                let y = (f64::from(k) * w * c).min(size);
                let (cy, cz) = (y - r * slope * c, slope * y + r * c + lift);
                Segment {
                    from: Point::new(-1.0, cy, cz),
                    to: Point::new(size + 1.0, cy, cz),
                }
            })
            .collect()
    }

    fn judge(mesh: &Mesh, segments: &[Segment], r: f64, step: f64, h: f64) -> Finish {
        let reach = reachable(&DropCutter::new(mesh, r), step);
        let mut swept = Swept::new(reach.lattice);
        swept.cut(segments, r);
        finish(&reach, &swept, segments, &FinishOptions::for_scallop(h)).unwrap()
    }

    /// Passes at w leave R - sqrt(R^2 - w^2/4), on the flat and on a slope alike; all is cut and nothing gouged.
    #[test]
    fn cusp_of_parallel_passes_on_flat_and_slope() {
        let (r, w) = (3.0, 0.6);
        for slope in [0.0f64, 0.5, 1.0, 2.0] {
            // The width across the slope, divided evenly.
            let across = 12.0 * (1.0 + slope * slope).sqrt();
            let w = across / (across / w).round();
            let cusp = 1e3 * (r - f64::sqrt(r * r - w * w / 4.0));
            let f = judge(
                &plane(12.0, slope),
                &passes(slope, r, w, 12.0, 0.0),
                r,
                // No share of the stepover, so that cells lie at all distances from a pass.
                0.0317,
                0.02,
            );
            let s = f.stats;
            // The nearest centre to the crest misses it by half a step at most.
            let miss = 1e3 * 0.016 * (w / 2.0 / r);
            assert!(s.scallop_um.max <= cusp + 0.15, "{slope}: {s:?}");
            assert!(s.scallop_um.max >= cusp - miss - 0.2, "{slope}: {s:?}");
            // Height goes as the square of the distance from the pass: median at a quarter of the cusp.
            assert!(
                (s.scallop_um.p50 - cusp / 4.0).abs() < 0.3,
                "{slope}: {s:?}"
            );
            assert_eq!(s.uncut_area_mm2, 0.0, "{slope}: {s:?}");
            assert!(s.gouge_um_max < 0.1 && s.over_scallop_area_percent == 0.0);
            assert!(s.rest_area_mm2 < 1e-9);
            let area = 144.0 * (1.0f64 + slope * slope).sqrt();
            assert!(
                (s.judged_area_mm2 / area - 1.0).abs() < 0.01,
                "{slope}: {s:?}"
            );
        }
    }

    /// Lowering all passes by 50 um gouges by 50 um on the flat and 50 um times the cosine on a slope.
    #[test]
    fn known_gouge() {
        for slope in [0.0, 1.0] {
            let f = judge(
                &plane(10.0, slope),
                &passes(slope, 3.0, 0.5, 10.0, -0.05),
                3.0,
                0.1,
                0.02,
            );
            let want = 50.0 / (1.0f64 + slope * slope).sqrt();
            assert!(
                (f.stats.gouge_um_max - want).abs() < 1.0,
                "{slope}: {:?}",
                f.stats
            );
        }
    }

    /// One pass left out in the middle: ground higher than the limit is uncut and no cusp; nothing cut at all is all uncut.
    #[test]
    fn uncut_is_not_a_cusp() {
        let mesh = plane(12.0, 0.0);
        let reach = reachable(&DropCutter::new(&mesh, 3.0), 0.1);
        let none = Swept::new(reach.lattice);
        let options = FinishOptions::for_scallop(0.02);
        let s = finish(&reach, &none, &[], &options).unwrap().stats;
        assert!((s.uncut_area_mm2 - s.judged_area_mm2).abs() < 1e-6);
        assert_eq!(s.over_scallop_area_percent, 100.0);
        assert_eq!(s.scallop_um.max, 0.0);
        // Passes at y = 0..4 and 8..12: between them a hill whose top is 3 - sqrt(9 - 4) = 0.76 mm.
        let all = passes(0.0, 3.0, 0.5, 12.0, 0.0);
        let some: Vec<Segment> = all
            .into_iter()
            .filter(|s| s.from.y <= 4.0 || s.from.y >= 8.0)
            .collect();
        let s = judge(&mesh, &some, 3.0, 0.1, 0.02).stats;
        // Above 0.2 mm: distance from the pass over sqrt(9 - 2.8^2) = 1.077 mm in plan by the vertical measure.
        let want = 12.0 * (4.0 - 2.0 * (3.2f64 * 3.2 - 9.0).sqrt());
        assert!((s.uncut_area_mm2 - want).abs() < 4.0, "{s:?} {want}");
        assert!(s.scallop_um.max <= 200.0 + 1e-3);
    }

    /// A slot narrower than the ball is rest, not uncut.
    #[test]
    fn slot_is_rest() {
        // 2 mm wide, 3 mm deep, upright walls, along X in the middle of a 12 mm plate.
        let z = |a: [f64; 2], b: [f64; 2], h: f64| {
            let p = |x: f64, y: f64| Point::new(x, y, h);
            vec![
                [p(a[0], a[1]), p(b[0], a[1]), p(b[0], b[1])],
                [p(a[0], a[1]), p(b[0], b[1]), p(a[0], b[1])],
            ]
        };
        let mut mesh = Mesh::default();
        // The plates go on beyond the slot, so that no ball enters it by its ends.
        mesh.triangles.extend(z([-4.0, 0.0], [16.0, 5.0], 0.0));
        mesh.triangles.extend(z([0.0, 5.0], [12.0, 7.0], -3.0));
        mesh.triangles.extend(z([-4.0, 7.0], [16.0, 12.0], 0.0));
        let drop = DropCutter::new(&mesh, 3.0);
        let reach = reachable(&drop, 0.05);
        // Follow the resting ball over every other node.
        let l = reach.lattice;
        let balls = drop.drop_all(&l);
        let mut segments = Vec::new();
        for iy in 0..l.ny {
            for ix in (2..l.nx).filter(|&ix| l.x(ix - 2) > -4.5 && l.x(ix) < 16.5) {
                let at = |ix: usize| {
                    let c = l.center(ix, iy);
                    Point::new(c.x, c.y, balls.z[l.index(ix, iy)])
                };
                segments.push(Segment {
                    from: at(ix - 2),
                    to: at(ix),
                });
            }
        }
        let mut swept = Swept::new(l);
        swept.cut(&segments, 3.0);
        let s = finish(&reach, &swept, &segments, &FinishOptions::for_scallop(0.02))
            .unwrap()
            .stats;
        assert!((s.rest_area_mm2 - 24.0).abs() < 1.5, "{s:?}");
        assert_eq!(s.uncut_area_mm2, 0.0, "{s:?}");
        assert!(s.gouge_um_max < 1.0, "{s:?}");
    }

    /// A ball that runs 5 um beside an upright wall leaves 5 um there, not the wall's height.
    #[test]
    fn beside_a_wall_the_normal_counts() {
        let (r, off) = (3.0, 0.005);
        let q = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        let mut mesh = Mesh::default();
        let mut quad = |a, b, c, d| {
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([a, c, d]);
        };
        // Floor for y < 6.0005, plateau 8 mm above from there on.
        let w = 6.0005;
        quad(
            q(0.0, 0.0, 0.0),
            q(12.0, 0.0, 0.0),
            q(12.0, w, 0.0),
            q(0.0, w, 0.0),
        );
        // The wall goes on beyond the floor, so that no ball comes to its foot round the end.
        quad(
            q(-8.0, w, 0.0),
            q(20.0, w, 0.0),
            q(20.0, w, 8.0),
            q(-8.0, w, 8.0),
        );
        quad(
            q(-8.0, w, 8.0),
            q(20.0, w, 8.0),
            q(20.0, 12.0, 8.0),
            q(-8.0, 12.0, 8.0),
        );
        let mut segments = Vec::new();
        let mut y = -1.0;
        while y < w - r - off {
            segments.push((y, r));
            y += 0.4;
        }
        segments.push((w - r - off, r));
        let mut y = w;
        while y < 12.5 {
            segments.push((y, 8.0 + r));
            y += 0.4;
        }
        let segments: Vec<Segment> = segments
            .into_iter()
            .map(|(y, z)| Segment {
                from: q(-9.0, y, z),
                to: q(21.0, y, z),
            })
            .collect();
        let f = judge(&mesh, &segments, r, 0.05, 0.02);
        let s = f.stats;
        assert_eq!(s.uncut_area_mm2, 0.0, "{s:?}");
        // Away from the floor's ends, where a ball from outside sinks a little deeper.
        for (i, cusp) in f.map.cusp_mm.iter().enumerate() {
            let c = f.map.lattice.center_at(i);
            assert!(
                !(3.2..8.8).contains(&c.x) || cusp.is_nan() || *cusp < 8e-3,
                "{c}: {cusp}"
            );
        }
        assert!(s.gouge_um_max < 0.5, "{s:?}");
        assert!(s.rest_area_mm2 > 10.0);
    }

    #[test]
    fn different_lattices_are_refused() {
        let reach = reachable(&DropCutter::new(&plane(5.0, 0.0), 1.0), 0.1);
        let other = Swept::new(Lattice {
            step: 0.2,
            ..reach.lattice
        });
        let e = finish(&reach, &other, &[], &FinishOptions::for_scallop(0.02)).unwrap_err();
        assert_eq!(e, FinishError::Lattice);
        assert!(e.to_string().contains("sweep on the lattice"));
    }
}
