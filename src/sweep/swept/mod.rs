//! The lower envelope of a ball moved along straight segments.
//!
//! ```text
//!        centre path       d  unit direction of travel, q  a cell, c(s)  centre at s
//!   o----s*------o         over q the ball's underside is  f(s) = c_z(s) - sqrt(R^2 - |q - c(s)|^2),  convex in s
//!     \  |  cylinder side  df/ds = 0 where the touching radius stands square on d: the cylinder's side
//!      '-q_                before the start or past the end: the sphere there, if q lies under it at all
//! ```
//! Along a chain of segments the lowest f over q is therefore found either in the *strip* of one segment (between the two half
//! great circles square on its ends) or in the *lune* of one joint (past the segment before, before the segment after). Strips
//! and lunes tile the chain's shadow, so each cell is visited a few times instead of once per segment within a radius of it.

mod interval;
mod piece;
mod shape;

use crate::geom::Point;
use crate::sweep::Lattice;
use piece::{Piece, pieces};
use rayon::prelude::*;

/// A straight move of the ball's *centre*, work coordinates, mm. Segments that follow each other without a gap (`to` of one
/// equal to `from` of the next) are treated as one chain, which is quicker; the result is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Centre at the start.
    pub from: Point,
    /// Centre at the end.
    pub to: Point,
}

/// Heights left by a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept {
    /// Where the heights stand.
    pub lattice: Lattice,
    /// Lowest point of the swept ball on the vertical line through each cell's centre, mm; `+inf`: never passed over.
    pub z: Vec<f64>,
}

/// Where a ball met what was still standing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// How far, vertically, the standing material reached into the swept ball, mm.
    pub depth: f64,
    /// Where that was deepest, on the material: work coordinates.
    pub place: Point,
}

impl Swept {
    /// Nothing cut yet. Memory: 8 bytes a cell.
    pub fn new(lattice: Lattice) -> Swept {
        Swept {
            z: vec![f64::INFINITY; lattice.len()],
            lattice,
        }
    }

    /// Lowers the map by the ball of this radius moved along the segments. The value at each cell is the exact lower envelope
    /// at its centre (rounding apart, about 1e-12 mm; segments shorter than 1e-9 mm in plan count as vertical). Segments with
    /// non-finite ends are ignored, as is a radius that is not a finite number above zero. Same bits for any number of threads:
    /// a minimum does not care about order. Cost: about length / step x 2R / step evaluations for smooth chains.
    pub fn cut(&mut self, segments: &[Segment], radius: f64) {
        if self.lattice.is_empty() || !(radius.is_finite() && radius > 0.0) {
            return;
        }
        let lattice = self.lattice;
        let pieces = pieces(segments);
        let bands = lattice.ny.div_ceil(BAND_ROWS);
        let mut bins: Vec<Vec<u32>> = vec![Vec::new(); bands];
        for (i, piece) in pieces.iter().enumerate() {
            let rows = piece.rows(&lattice, radius);
            if rows.is_empty() {
                continue;
            }
            for bin in &mut bins[rows.start / BAND_ROWS..=(rows.end - 1) / BAND_ROWS] {
                bin.push(i as u32);
            }
        }
        self.z
            .par_chunks_mut(BAND_ROWS * lattice.nx)
            .zip(bins.par_iter())
            .enumerate()
            .for_each(|(band, (z, bin))| {
                let first = band * BAND_ROWS;
                for &i in bin {
                    lower(&lattice, first, z, &pieces[i as usize], radius);
                }
            });
    }

    /// As [`Swept::cut`], on the calling thread alone: for a small map among many.
    pub fn cut_alone(&mut self, segments: &[Segment], radius: f64) {
        if self.lattice.is_empty() || !(radius.is_finite() && radius > 0.0) {
            return;
        }
        for piece in &pieces(segments) {
            lower(&self.lattice, 0, &mut self.z, piece, radius);
        }
    }

    /// Where the ball moved along one segment reaches deepest into what still stands: at each cell the lower of `stock` (same
    /// lattice; `-inf` where there is none) and of what was cut so far. `None` when it enters nothing by more than `tolerance`.
    /// A `stock` of another length than the lattice is taken as empty.
    pub fn encounter(
        &self,
        stock: &[f64],
        segment: Segment,
        radius: f64,
        tolerance: f64,
    ) -> Option<Encounter> {
        if stock.len() != self.z.len() || !(radius.is_finite() && radius > 0.0) {
            return None;
        }
        let mut worst: Option<(f64, usize, f64)> = None;
        for piece in pieces(&[segment]) {
            for iy in piece.rows(&self.lattice, radius) {
                piece.for_row(&self.lattice, iy, radius, |columns, shape| {
                    for ix in columns {
                        let i = self.lattice.index(ix, iy);
                        let standing = stock[i].min(self.z[i]);
                        let depth = standing - shape.height(self.lattice.x(ix));
                        if depth > tolerance && worst.is_none_or(|w| depth > w.0) {
                            worst = Some((depth, i, standing));
                        }
                    }
                });
            }
        }
        worst.map(|(depth, i, z)| {
            let c = self.lattice.center_at(i);
            Encounter {
                depth,
                place: Point::new(c.x, c.y, z),
            }
        })
    }
}

/// Lowers whole rows of a map, the first of them being row `first`.
fn lower(lattice: &Lattice, first: usize, z: &mut [f64], piece: &Piece, radius: f64) {
    let last = first + z.len() / lattice.nx;
    let rows = piece.rows(lattice, radius);
    for iy in rows.start.max(first)..rows.end.min(last) {
        let row = &mut z[(iy - first) * lattice.nx..(iy - first + 1) * lattice.nx];
        piece.for_row(lattice, iy, radius, |columns, shape| {
            shape.lower(lattice, columns.start, &mut row[columns]);
        });
    }
}

/// Rows handed to one thread at a time.
const BAND_ROWS: usize = 16;

#[cfg(test)]
mod tests;
