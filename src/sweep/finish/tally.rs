//! Figures over all cells, the same in whatever order they are added up.

use super::FinishError;
use super::judge::Judge;
use crate::sweep::{Lattice, Reachable};
use serde::Serialize;

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

/// Areas are summed as whole multiples of this share of a cell: sums that do not depend on their order.
pub(super) const AREA_GRAIN: f64 = (1 << 20) as f64;
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
pub(super) struct Tally {
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
    pub(super) fn cell(
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

    pub(super) fn add(&mut self, b: &Tally) {
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

    pub(super) fn stats(&self, lattice: &Lattice) -> Result<FinishStats, FinishError> {
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
