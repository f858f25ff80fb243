//! For each cell the node whose ball reaches it best: seeded at contacts, handed on to neighbours, walked downhill.

use super::nodes::Nodes;
use crate::sweep::Lattice;
use rayon::prelude::*;

/// From a cell to the node that reaches it best, in steps; `NONE` in the first place for no candidate yet.
pub(super) type Offset = [i16; 2];
pub(super) const NONE: i16 = i16::MIN;
const AROUND: [[i16; 2]; 8] = [
    [-1, 0],
    [1, 0],
    [0, -1],
    [0, 1],
    [-1, -1],
    [1, -1],
    [-1, 1],
    [1, 1],
];
const BAND_ROWS: usize = 64;
/// Undersides nearer than this are the same height, mm.
const TIE: f64 = 1e-9;

pub(super) struct Search<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) center_z: &'a [f64],
    pub(super) radius_sq: f64,
    pub(super) step_sq: f64,
    pub(super) offset: Vec<Offset>,
    pub(super) value: Vec<f64>,
}

/// The underside over cell (ix, iy) of the ball resting on the node at this offset; `+inf` if there is none.
pub(super) struct Underside<'a> {
    pub(super) center_z: &'a [f64],
    pub(super) nx: i64,
    pub(super) ny: i64,
    pub(super) radius_sq: f64,
    pub(super) step_sq: f64,
}

impl Underside<'_> {
    #[inline(always)]
    pub(super) fn at(&self, ix: usize, iy: usize, o: Offset) -> f64 {
        let (dx, dy) = (i64::from(o[0]), i64::from(o[1]));
        let depth_sq = self.radius_sq - (dx * dx + dy * dy) as f64 * self.step_sq;
        let (x, y) = (ix as i64 + dx, iy as i64 + dy);
        if depth_sq < 0.0 || x < 0 || y < 0 || x >= self.nx || y >= self.ny {
            return f64::INFINITY;
        }
        let c = self.center_z[(y * self.nx + x) as usize];
        if c == f64::NEG_INFINITY {
            f64::INFINITY
        } else {
            c - depth_sq.sqrt()
        }
    }

    /// Walks downhill over the nodes until none of the eight around is better.
    #[inline]
    fn descend(&self, ix: usize, iy: usize, offset: &mut Offset, value: &mut f64) {
        loop {
            let from = *offset;
            for d in AROUND {
                let o = [from[0] + d[0], from[1] + d[1]];
                let v = self.at(ix, iy, o);
                if v < *value - TIE {
                    *value = v;
                    *offset = o;
                }
            }
            if *offset == from {
                return;
            }
        }
    }
}

impl<'a> Search<'a> {
    pub(super) fn underside(&self) -> Underside<'a> {
        Underside {
            center_z: self.center_z,
            nx: self.lattice.nx as i64,
            ny: self.lattice.ny as i64,
            radius_sq: self.radius_sq,
            step_sq: self.step_sq,
        }
    }

    /// Each node offers itself to its own cell and to the cell its contact falls in.
    pub(super) fn seeded(lattice: &'a Lattice, radius: f64, nodes: &'a Nodes) -> Search<'a> {
        let mut s = Search {
            lattice,
            center_z: &nodes.center_z,
            radius_sq: radius * radius,
            step_sq: lattice.step * lattice.step,
            offset: vec![[NONE; 2]; lattice.len()],
            value: vec![f64::INFINITY; lattice.len()],
        };
        let f = s.underside();
        for iy in 0..lattice.ny {
            for ix in 0..lattice.nx {
                let i = lattice.index(ix, iy);
                let v = f.at(ix, iy, [0, 0]);
                if v < f64::INFINITY {
                    s.value[i] = v;
                    s.offset[i] = [0, 0];
                }
            }
        }
        for iy in 0..lattice.ny {
            for ix in 0..lattice.nx {
                let i = lattice.index(ix, iy);
                if s.center_z[i] == f64::NEG_INFINITY {
                    continue;
                }
                let n = nodes.normal[i];
                let px = lattice.x(ix) - radius * f64::from(n[0]);
                let py = lattice.y(iy) - radius * f64::from(n[1]);
                if let Some((jx, jy)) = lattice.nearest(px, py) {
                    let o = [
                        (ix as i64 - jx as i64) as i16,
                        (iy as i64 - jy as i64) as i16,
                    ];
                    let v = f.at(jx, jy, o);
                    let j = lattice.index(jx, jy);
                    // On a sharp edge many balls touch the same cell: the one straight above it stays, not by rounding.
                    if v < s.value[j] - TIE {
                        s.value[j] = v;
                        s.offset[j] = o;
                    }
                }
            }
        }
        s
    }

    /// A forward and a backward raster in each band of rows. Bands are of fixed height: their number of threads is no input.
    pub(super) fn spread_in_bands(&mut self) {
        let f = self.underside();
        let nx = self.lattice.nx;
        if nx == 0 {
            return;
        }
        self.offset
            .par_chunks_mut(BAND_ROWS * nx)
            .zip(self.value.par_chunks_mut(BAND_ROWS * nx))
            .enumerate()
            .for_each(|(band, (offset, value))| {
                let rows = offset.len() / nx;
                let mut pull = |ix: usize, row: usize, d: [i16; 2]| {
                    let (jx, jrow) = (ix as i64 + i64::from(d[0]), row as i64 + i64::from(d[1]));
                    if jx < 0 || jrow < 0 || jx >= nx as i64 || jrow >= rows as i64 {
                        return;
                    }
                    let from = offset[jrow as usize * nx + jx as usize];
                    if from[0] == NONE {
                        return;
                    }
                    let o = [from[0] + d[0], from[1] + d[1]];
                    let v = f.at(ix, band * BAND_ROWS + row, o);
                    let i = row * nx + ix;
                    if v < value[i] - TIE {
                        value[i] = v;
                        offset[i] = o;
                    }
                };
                for row in 0..rows {
                    for ix in 0..nx {
                        for d in [[-1, 0], [-1, -1], [0, -1], [1, -1]] {
                            pull(ix, row, d);
                        }
                    }
                }
                for row in (0..rows).rev() {
                    for ix in (0..nx).rev() {
                        for d in [[1, 0], [1, 1], [0, 1], [-1, 1]] {
                            pull(ix, row, d);
                        }
                    }
                }
            });
    }

    pub(super) fn descend(&mut self) {
        let f = self.underside();
        let nx = self.lattice.nx.max(1);
        self.offset
            .par_chunks_mut(nx)
            .zip(self.value.par_chunks_mut(nx))
            .enumerate()
            .for_each(|(iy, (offset, value))| {
                for ix in 0..offset.len() {
                    if offset[ix][0] != NONE {
                        f.descend(ix, iy, &mut offset[ix], &mut value[ix]);
                    }
                }
            });
    }

    /// Rounds of asking the eight neighbours, each from the state before the round, until nothing improves.
    pub(super) fn settle(&mut self) {
        let f = self.underside();
        let lattice = self.lattice;
        let (nx, ny) = (lattice.nx, lattice.ny);
        let mut active = vec![true; lattice.len()];
        let mut active_rows = vec![true; ny];
        // A candidate travels at most one radius from its node; the bound is for safety, not for speed.
        let rounds = 4 * (nx + ny) + 16;
        for _ in 0..rounds {
            let updates: Vec<Vec<(u32, Offset, f64)>> = (0..ny)
                .into_par_iter()
                .map(|iy| {
                    let mut out = Vec::new();
                    if !active_rows[iy] {
                        return out;
                    }
                    for ix in 0..nx {
                        let i = lattice.index(ix, iy);
                        if !active[i] {
                            continue;
                        }
                        let (mut o, mut v) = (self.offset[i], self.value[i]);
                        for d in AROUND {
                            let (jx, jy) =
                                (ix as i64 + i64::from(d[0]), iy as i64 + i64::from(d[1]));
                            if jx < 0 || jy < 0 || jx >= nx as i64 || jy >= ny as i64 {
                                continue;
                            }
                            let from = self.offset[jy as usize * nx + jx as usize];
                            if from[0] == NONE {
                                continue;
                            }
                            let c = [from[0] + d[0], from[1] + d[1]];
                            if c == o {
                                continue;
                            }
                            let w = f.at(ix, iy, c);
                            if w < v - TIE {
                                v = w;
                                o = c;
                            }
                        }
                        if v < self.value[i] {
                            f.descend(ix, iy, &mut o, &mut v);
                            out.push((i as u32, o, v));
                        }
                    }
                    out
                })
                .collect();
            for (iy, row) in active_rows.iter_mut().enumerate() {
                if std::mem::take(row) {
                    active[iy * nx..(iy + 1) * nx].fill(false);
                }
            }
            let mut any = false;
            for (i, o, v) in updates.into_iter().flatten() {
                any = true;
                let i = i as usize;
                self.offset[i] = o;
                self.value[i] = v;
                let (ix, iy) = lattice.cell(i);
                for jy in iy.saturating_sub(1)..(iy + 2).min(ny) {
                    active_rows[jy] = true;
                    active[jy * nx + ix.saturating_sub(1)..jy * nx + (ix + 2).min(nx)].fill(true);
                }
            }
            if !any {
                return;
            }
        }
    }
}
