//! A square lattice of places in the plane of the table.

use crate::geom::Point2;

/// A square lattice: cell `(ix, iy)` has its centre at `origin + step * (ix, iy)`. Row-major: index `iy * nx + ix`.
/// Work coordinates, mm. A lattice with `nx` or `ny` zero is empty and holds no place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Centre of cell (0, 0).
    pub origin: Point2,
    /// Distance between neighbouring centres, mm; above zero.
    pub step: f64,
    /// Cells along X.
    pub nx: usize,
    /// Cells along Y.
    pub ny: usize,
}

impl Lattice {
    /// The smallest lattice of this step whose centres reach from `min` to `max` or just beyond, the surplus shared evenly
    /// between both sides. Empty when `min > max` on an axis or a number is not finite. Cost: none; announce
    /// [`Lattice::len`] before allocating for it.
    pub fn covering(min: Point2, max: Point2, step: f64) -> Lattice {
        let empty = Lattice {
            origin: Point2::origin(),
            step: 1.0,
            nx: 0,
            ny: 0,
        };
        let (wx, wy) = (max.x - min.x, max.y - min.y);
        if !(step.is_finite() && step > 0.0 && wx.is_finite() && wy.is_finite())
            || wx < 0.0
            || wy < 0.0
        {
            return empty;
        }
        // A width that is a whole number of steps but for rounding needs no extra cell.
        let cells = |w: f64| ((w / step - 1e-9).ceil().max(0.0)) as usize;
        let (cx, cy) = (cells(wx), cells(wy));
        Lattice {
            origin: Point2::new(
                0.5 * (min.x + max.x - cx as f64 * step),
                0.5 * (min.y + max.y - cy as f64 * step),
            ),
            step,
            nx: cx.saturating_add(1),
            ny: cy.saturating_add(1),
        }
    }

    /// The cells of some columns and rows as a lattice of their own; what lies beyond the rim is left out.
    pub fn window(&self, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> Lattice {
        let (x0, x1) = (columns.start.min(self.nx), columns.end.min(self.nx));
        let (y0, y1) = (rows.start.min(self.ny), rows.end.min(self.ny));
        Lattice {
            origin: self.center(x0, y0),
            step: self.step,
            nx: x1.saturating_sub(x0),
            ny: y1.saturating_sub(y0),
        }
    }

    /// Number of cells.
    #[inline]
    pub fn len(&self) -> usize {
        self.nx.saturating_mul(self.ny)
    }

    /// True when there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// X of a column of centres.
    #[inline]
    pub fn x(&self, ix: usize) -> f64 {
        self.origin.x + self.step * ix as f64
    }

    /// Y of a row of centres.
    #[inline]
    pub fn y(&self, iy: usize) -> f64 {
        self.origin.y + self.step * iy as f64
    }

    /// Centre of a cell by its column and row.
    #[inline]
    pub fn center(&self, ix: usize, iy: usize) -> Point2 {
        Point2::new(self.x(ix), self.y(iy))
    }

    /// Centre of a cell by its index.
    #[inline]
    pub fn center_at(&self, index: usize) -> Point2 {
        let (ix, iy) = self.cell(index);
        self.center(ix, iy)
    }

    /// Column and row of an index. (0, 0) for an empty lattice.
    #[inline]
    pub fn cell(&self, index: usize) -> (usize, usize) {
        if self.nx == 0 {
            (0, 0)
        } else {
            (index % self.nx, index / self.nx)
        }
    }

    /// Index of a cell.
    #[inline]
    pub fn index(&self, ix: usize, iy: usize) -> usize {
        iy * self.nx + ix
    }

    /// Index of the cell so many columns and rows beside another; `None` beyond the rim.
    #[inline]
    pub fn beside(&self, index: usize, columns: i64, rows: i64) -> Option<usize> {
        let (ix, iy) = self.cell(index);
        let (x, y) = (ix as i64 + columns, iy as i64 + rows);
        let inside = x >= 0 && y >= 0 && x < self.nx as i64 && y < self.ny as i64;
        inside.then(|| self.index(x as usize, y as usize))
    }

    /// The cell whose square holds this place; `None` outside all squares (a border belongs to the higher cell).
    pub fn nearest(&self, x: f64, y: f64) -> Option<(usize, usize)> {
        let fx = ((x - self.origin.x) / self.step + 0.5).floor();
        let fy = ((y - self.origin.y) / self.step + 0.5).floor();
        // NaN fails every comparison.
        if fx >= 0.0 && fy >= 0.0 && fx < self.nx as f64 && fy < self.ny as f64 {
            Some((fx as usize, fy as usize))
        } else {
            None
        }
    }

    /// Area of one cell, mm².
    pub fn cell_area(&self) -> f64 {
        self.step * self.step
    }

    /// Columns whose centres lie in the closed interval `[lo, hi]` of X; empty range when none.
    #[inline]
    pub(crate) fn columns(&self, lo: f64, hi: f64) -> std::ops::Range<usize> {
        span(self.origin.x, self.step, self.nx, lo, hi)
    }

    /// Rows whose centres lie in the closed interval `[lo, hi]` of Y; empty range when none.
    #[inline]
    pub(crate) fn rows(&self, lo: f64, hi: f64) -> std::ops::Range<usize> {
        span(self.origin.y, self.step, self.ny, lo, hi)
    }
}

#[inline]
fn span(origin: f64, step: f64, n: usize, lo: f64, hi: f64) -> std::ops::Range<usize> {
    // Truncating casts instead of floor and ceil, which are calls on plain x86-64: this is asked for every row of every sweep.
    let (a, b) = ((lo - origin) / step, (hi - origin) / step);
    let last = n as f64 - 1.0;
    if b < 0.0 || a > last || n == 0 {
        return 0..0;
    }
    let first = a.max(0.0) as usize;
    let first = first + usize::from((first as f64) < a);
    let end = b.min(last) as usize + 1;
    first..end.max(first)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn covers_and_finds_its_cells() {
        let l = Lattice::covering(Point2::new(-1.0, 2.0), Point2::new(1.0, 2.55), 0.1);
        assert_eq!((l.nx, l.ny), (21, 7));
        assert!(l.y(0) <= 2.0 && l.y(6) >= 2.55);
        assert!((l.x(0) + 1.0).abs() < 1e-12 && (l.x(20) - 1.0).abs() < 1e-12);
        for i in [0, 5, 21, l.len() - 1] {
            let c = l.center_at(i);
            let (ix, iy) = l.nearest(c.x, c.y).unwrap();
            assert_eq!(l.index(ix, iy), i);
        }
        assert_eq!(l.nearest(1.051, 2.2), None);
        assert_eq!(l.nearest(f64::NAN, 2.2), None);
        assert_eq!(l.columns(-0.95, -0.65).len(), 3);
        assert_eq!(l.columns(5.0, 9.0).len(), 0);
    }

    #[test]
    fn nonsense_gives_the_empty_lattice() {
        let p = Point2::new(0.0, 0.0);
        for (max, step) in [
            (Point2::new(-1.0, 0.0), 0.1),
            (Point2::new(f64::NAN, 0.0), 0.1),
            (Point2::new(f64::INFINITY, 0.0), 0.1),
            (p, 0.0),
            (p, -1.0),
        ] {
            assert!(Lattice::covering(p, max, step).is_empty());
        }
        assert_eq!(Lattice::covering(p, p, 0.1).len(), 1);
    }
}
