//! The height of a ball's or a cylinder's underside along a row of cells.

use crate::sweep::Lattice;

/// What to evaluate along a row.
pub(super) enum Shape {
    /// Side of a cylinder: along = a0 + ax x, across = b0 + bx x, with x from x0.
    Side {
        x0: f64,
        ax: f64,
        a0: f64,
        bx: f64,
        b0: f64,
        z0: f64,
        sine: f64,
        plan: f64,
        slope: f64,
        radius_sq: f64,
    },
    /// Sphere cut by the row: half chord squared.
    Ball { x0: f64, z0: f64, half_sq: f64 },
}

impl Shape {
    /// Height of the underside over x; `+inf` beside it.
    #[inline(always)]
    pub(super) fn height(&self, x: f64) -> f64 {
        match *self {
            Shape::Side {
                x0,
                ax,
                a0,
                bx,
                b0,
                z0,
                sine,
                plan,
                slope,
                radius_sq,
            } => {
                let px = x - x0;
                let a = a0 + ax * px;
                let b = b0 + bx * px;
                let w_sq = radius_sq - b * b;
                // Stationary place along the plan, then clamped to the segment: f is convex.
                let s = (a - sine * w_sq.max(0.0).sqrt()).clamp(0.0, plan);
                let e = a - s;
                let depth_sq = w_sq - e * e;
                if depth_sq >= 0.0 {
                    z0 + slope * s - depth_sq.sqrt()
                } else {
                    f64::INFINITY
                }
            }
            Shape::Ball { x0, z0, half_sq } => {
                let px = x - x0;
                let depth_sq = half_sq - px * px;
                if depth_sq >= 0.0 {
                    z0 - depth_sq.sqrt()
                } else {
                    f64::INFINITY
                }
            }
        }
    }

    /// Lowers a run of cells of one row that begins at column `first`.
    #[inline]
    pub(super) fn lower(&self, lattice: &Lattice, first: usize, cells: &mut [f64]) {
        for (k, z) in cells.iter_mut().enumerate() {
            let h = self.height(lattice.x(first + k));
            *z = if h < *z { h } else { *z };
        }
    }
}
