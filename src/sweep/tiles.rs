//! The judging lattice of a part, tile by tile: a large part is never held whole.
//!
//! ```text
//!   +-------+-------+----+     each tile has a rim of cells around it that belong to its neighbours: what is asked of a cell's
//!   |       |.......|    |     surroundings is asked inside the tile
//!   |      .|       |.   |
//!   +------.+-------+.---+     what is said of a cell does not depend on the tiles
//! ```

use crate::geom::Point2;
use crate::reach::DropCutter;
use crate::sweep::reachable::{ALIGNED, Reachable, lattice_for, window};
use crate::sweep::{Lattice, Segment};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;

/// Cells that belong to a tile: columns and rows of the whole lattice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Columns.
    pub columns: Range<usize>,
    /// Rows.
    pub rows: Range<usize>,
}

/// What one ball can reach of a part, in tiles. Those of a small part are kept once they have been asked for.
#[derive(Debug)]
pub struct ReachTiles<'a> {
    drop: &'a DropCutter,
    lattice: Lattice,
    side: usize,
    rim: usize,
    /// A place for each tile of a small part; empty for a large one.
    kept: Vec<OnceLock<Reachable>>,
}

/// Cells on a side of a tile at least.
const SIDE: usize = 512;
/// Parts of up to this many cells (24 bytes each) are kept.
const KEPT: usize = 1 << 24;
/// Tiles reckoned to be in work at once.
const WORKERS: u64 = 4;
/// Bytes of a tile in work, for each of its cells and those around it that matter.
const WORKING: u64 = 100;

/// Cells on a side of a tile: so many that the radius of the ball around it does not cost more than the tile.
fn side(lattice: &Lattice, radius: f64) -> usize {
    let radius = radius / lattice.step;
    ((2.0 * radius) as usize).max(SIDE).div_ceil(ALIGNED) * ALIGNED
}

/// Bytes that judging on this lattice takes: what is kept of a small part, the tiles in work, and the map of the worst.
pub(super) fn tile_bytes(lattice: &Lattice, radius: f64) -> u64 {
    let cells = lattice.len() as u64;
    let kept = if lattice.len() <= KEPT { 24 * cells } else { 0 };
    let wide = side(lattice, radius) as u64 + 2 * (radius / lattice.step) as u64 + 128;
    let tile = (wide * wide).min(cells) * WORKING;
    // Not the threads there are: the figure is part of a report that is the same on any machine.
    kept + tile * WORKERS + 20 * cells.min(crate::sweep::finish::MAP_CELLS as u64)
}

impl<'a> ReachTiles<'a> {
    /// Lays a lattice of this step (as [`reachable`](crate::sweep::reachable()) does) over a part. Each tile will carry at least `rim`
    /// cells of its neighbours.
    pub fn new(drop: &'a DropCutter, step: f64, rim: usize) -> ReachTiles<'a> {
        let lattice = lattice_for(&drop.bounds(), drop.radius(), step);
        let mut t = ReachTiles {
            drop,
            lattice,
            side: side(&lattice, drop.radius()),
            rim: rim.max(1).div_ceil(8) * 8,
            kept: Vec::new(),
        };
        if lattice.len() <= KEPT {
            t.kept = (0..t.len()).map(|_| OnceLock::new()).collect();
        }
        t
    }

    /// Without rims.
    pub(super) fn bare(mut self) -> ReachTiles<'a> {
        self.rim = 0;
        self
    }

    /// With tiles of another size (rounded up to 64 cells), for tests of what must not depend on it.
    #[cfg(test)]
    pub(crate) fn with_side(mut self, side: usize) -> ReachTiles<'a> {
        self.side = side.div_ceil(ALIGNED) * ALIGNED;
        self.kept = Vec::new();
        self
    }

    /// All cells.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The ball.
    pub fn drop_cutter(&self) -> &'a DropCutter {
        self.drop
    }

    /// Cells of its neighbours that each tile carries on each side.
    pub fn rim(&self) -> usize {
        self.rim
    }

    fn across(&self) -> usize {
        self.lattice.nx.div_ceil(self.side)
    }

    /// How many tiles there are.
    pub fn len(&self) -> usize {
        self.across() * self.lattice.ny.div_ceil(self.side)
    }

    /// True for an empty part.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cells of a tile.
    pub fn tile(&self, k: usize) -> Tile {
        let across = self.across().max(1);
        let range = |k: usize, n: usize| (k * self.side).min(n)..((k + 1) * self.side).min(n);
        Tile {
            columns: range(k % across, self.lattice.nx),
            rows: range(k / across, self.lattice.ny),
        }
    }

    /// The cells of a tile with its rim.
    pub fn wide(&self, k: usize) -> Tile {
        let t = self.tile(k);
        let wider = |r: &Range<usize>, n: usize| {
            r.start.saturating_sub(self.rim)..(r.end + self.rim).min(n)
        };
        Tile {
            columns: wider(&t.columns, self.lattice.nx),
            rows: wider(&t.rows, self.lattice.ny),
        }
    }

    /// What the ball can reach of a tile and its rim: its lattice is that of [`ReachTiles::wide`].
    pub fn reach(&self, k: usize) -> Cow<'_, Reachable> {
        match self.kept.get(k) {
            Some(place) => Cow::Borrowed(place.get_or_init(|| self.compute(k))),
            None => Cow::Owned(self.compute(k)),
        }
    }

    pub(super) fn compute(&self, k: usize) -> Reachable {
        let t = self.wide(k);
        window(self.drop, &self.lattice, t.columns, t.rows)
    }

    /// For each tile the segments that pass within one radius of its cells or its rim, by number, rising; and one more before and
    /// after each run of them, so that chains stay what they are.
    pub fn touched<'s>(
        &self,
        segments: impl ExactSizeIterator<Item = &'s Segment>,
    ) -> Vec<Vec<u32>> {
        let room = self.drop.radius() + self.rim as f64 * self.lattice.step;
        touched(&self.lattice, self.side, room, segments)
    }

    /// Names each tile that a segment passes within `room` mm of.
    pub fn near(&self, segment: &Segment, room: f64, name: impl FnMut(usize)) {
        Squares::new(&self.lattice, self.side, room).near(segment, name);
    }
}

/// For each square of `side` cells, row by row, the segments that pass within `room` mm of its cells, by number, rising; and one more
/// before and after each run of them, so that chains stay what they are.
pub fn touched<'s>(
    l: &Lattice,
    side: usize,
    room: f64,
    segments: impl ExactSizeIterator<Item = &'s Segment>,
) -> Vec<Vec<u32>> {
    let squares = Squares::new(l, side, room);
    let mut out: Vec<Vec<u32>> = vec![Vec::new(); squares.across * squares.down];
    let count = segments.len();
    for (i, s) in segments.enumerate() {
        squares.near(s, |square| {
            let list = &mut out[square];
            let from = list.last().map_or(0, |k| *k as usize + 1);
            for k in from.max(i.saturating_sub(1))..(i + 2).min(count) {
                list.push(k as u32);
            }
        });
    }
    out
}

/// The squares that a lattice is cut into, and how far around each of them counts.
struct Squares {
    origin: Point2,
    /// Side of a square, mm.
    size: f64,
    room: f64,
    across: usize,
    down: usize,
}

impl Squares {
    fn new(l: &Lattice, side: usize, room: f64) -> Squares {
        Squares {
            origin: l.origin,
            size: l.step * side as f64,
            room: room + l.step,
            across: l.nx.div_ceil(side),
            down: l.ny.div_ceil(side),
        }
    }

    /// Names each square that a segment passes near, row by row.
    fn near(&self, s: &Segment, mut name: impl FnMut(usize)) {
        for ty in self.span(s.from.y, s.to.y, self.origin.y, self.down) {
            for tx in self.span(s.from.x, s.to.x, self.origin.x, self.across) {
                name(ty * self.across + tx);
            }
        }
    }

    fn span(&self, a: f64, b: f64, origin: f64, n: usize) -> Range<usize> {
        let at = |v: f64| (v - origin) / self.size;
        let (lo, hi) = (at(a.min(b) - self.room), at(a.max(b) + self.room));
        // NaN touches nothing.
        if hi >= 0.0 && lo < n as f64 {
            lo.max(0.0) as usize..(hi as usize).saturating_add(1).min(n)
        } else {
            0..0
        }
    }
}

/// Corners of the area that a lattice's cells lie in.
pub(crate) fn area(lattice: &Lattice) -> (Point2, Point2) {
    (
        lattice.center(0, 0),
        lattice.center(lattice.nx.max(1) - 1, lattice.ny.max(1) - 1),
    )
}
