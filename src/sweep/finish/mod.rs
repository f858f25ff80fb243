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

mod judge;
mod map;
mod tally;
#[cfg(test)]
mod tests;

pub use map::{CuspMap, MAP_CELLS};
pub use tally::{FinishStats, Percentiles};

use crate::sweep::nearest::Paths;
use crate::sweep::reachable::ALIGNED;
use crate::sweep::tiles::{ReachTiles, Tile, area};
use crate::sweep::{Reachable, Segment, Swept};
use judge::Judge;
use map::MapPart;
use rayon::prelude::*;
use tally::Tally;

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

/// Judges all tiles: [`Judging`] with all moves at once.
pub fn finish_tiles<X: Send>(
    tiles: &ReachTiles,
    paths: &Paths,
    options: &FinishOptions,
    sweep: impl Fn(usize, &Reachable) -> (Swept, X) + Sync,
) -> (Result<Finish, FinishError>, Vec<X>) {
    let mut judging = Judging::new(tiles, options);
    let found = judging.look(0..tiles.len(), paths, sweep);
    (judging.finish(), found)
}

/// Judges tile by tile, some at a time: the moves of a few tiles are enough to judge them. Same figures for any number of threads, any
/// size of tile, and any grouping of tiles; the map is coarser where it would be larger than [`MAP_CELLS`].
pub struct Judging<'a> {
    tiles: &'a ReachTiles<'a>,
    options: FinishOptions,
    /// Cells of the lattice on a side of one of the map's.
    factor: usize,
    tally: Tally,
    map: CuspMap,
}

impl<'a> Judging<'a> {
    /// Nothing judged yet.
    pub fn new(tiles: &'a ReachTiles<'a>, options: &FinishOptions) -> Judging<'a> {
        let whole = *tiles.lattice();
        let cells = |factor: usize| whole.nx.div_ceil(factor) * whole.ny.div_ceil(factor);
        let mut factor = 1;
        while cells(factor) > MAP_CELLS && factor < ALIGNED {
            factor *= 2;
        }
        Judging {
            tiles,
            options: *options,
            factor,
            tally: Tally::default(),
            map: CuspMap::blank(&whole, factor),
        }
    }

    /// How far from a tile's cells, mm in plan, a move can matter to them.
    pub fn room(&self) -> f64 {
        let step = self.tiles.lattice().step;
        let rim = self.tiles.rim() as f64 * step;
        let beside = self.options.uncut_above.max(self.options.scallop).max(rim);
        self.tiles.drop_cutter().radius() + beside + 4.0 * step
    }

    /// Judges some tiles, each once. `sweep` makes the map of what is left of one tile (and its rim), and whatever else it finds out, which
    /// comes back in the order of the tiles. `paths` are the moves that it sweeps, at least those within [`Judging::room`].
    pub fn look<X: Send>(
        &mut self,
        which: std::ops::Range<usize>,
        paths: &Paths,
        sweep: impl Fn(usize, &Reachable) -> (Swept, X) + Sync,
    ) -> Vec<X> {
        let tiles = self.tiles;
        let judge = Judge {
            part: Some(tiles.drop_cutter()),
            paths,
            options: &self.options,
            whole: *tiles.lattice(),
            factor: self.factor,
        };
        type Found<X> = (Tally, Vec<(usize, MapPart, X)>);
        let start = || -> Found<X> { (Tally::default(), Vec::new()) };
        let (tally, mut parts) = which
            .into_par_iter()
            .fold(start, |(mut tally, mut parts), k| {
                let reach = tiles.reach(k);
                let (swept, found) = sweep(k, &reach);
                let (own, wide) = (tiles.tile(k), tiles.wide(k));
                let part = judge.look(&reach, &swept.z, &own, &wide, &mut tally);
                parts.push((k, part, found));
                (tally, parts)
            })
            .reduce(start, |mut a, b| {
                a.0.add(&b.0);
                a.1.extend(b.1);
                a
            });
        self.tally.add(&tally);
        parts.sort_by_key(|p| p.0);
        let mut found = Vec::with_capacity(parts.len());
        for (k, part, x) in parts {
            let t = tiles.tile(k);
            let at = [t.columns.start / self.factor, t.rows.start / self.factor];
            self.map.place(&part, at);
            found.push(x);
        }
        found
    }

    /// All of it together.
    ///
    /// # Errors
    /// There was nothing to judge.
    pub fn finish(self) -> Result<Finish, FinishError> {
        let stats = self.tally.stats(self.tiles.lattice())?;
        let map = self.map;
        Ok(Finish { map, stats })
    }
}
