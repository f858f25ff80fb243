//! Cusps, gouges and rest material cell by cell, for pictures.

use crate::geom::Point2;
use crate::sweep::Lattice;

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

/// Cells of a map at most, as far as coarser cells of up to 64 of the lattice's on a side allow.
pub const MAP_CELLS: usize = 4_000_000;

impl CuspMap {
    pub(super) fn blank(whole: &Lattice, factor: usize) -> CuspMap {
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

    pub(super) fn place(&mut self, part: &MapPart, first: [usize; 2]) {
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
pub(super) struct MapPart {
    pub(super) nx: usize,
    pub(super) cells: Vec<[f32; 4]>,
}
