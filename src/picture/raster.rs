//! Values on a regular grid over the table.

use crate::geom::Point2;

/// Values at nodes `origin + step (i, j)`, rows of rising y, x running fastest. In height rasters NaN means "nothing here".
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    /// Place of node (0, 0), work coordinates, mm.
    pub origin: Point2,
    /// Distance of neighbouring nodes, mm.
    pub step: f64,
    /// Nodes along x.
    pub nx: usize,
    /// Nodes along y.
    pub ny: usize,
    /// `nx * ny` values.
    pub values: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// True when the values fill the grid.
    pub fn is_consistent(&self) -> bool {
        self.step > 0.0
            && self.step.is_finite()
            && self.origin.coords.iter().all(|v| v.is_finite())
            && self.nx.checked_mul(self.ny) == Some(self.values.len())
    }

    /// The value at a node; none outside the grid.
    pub fn get(&self, i: i64, j: i64) -> Option<T> {
        if i < 0 || j < 0 || i >= self.nx as i64 || j >= self.ny as i64 {
            return None;
        }
        self.values.get(j as usize * self.nx + i as usize).copied()
    }

    /// Place in grid units: 0 at the first node.
    pub fn grid_place(&self, p: Point2) -> (f64, f64) {
        (
            (p.x - self.origin.x) / self.step,
            (p.y - self.origin.y) / self.step,
        )
    }

    /// The same values at wider nodes, so that no side has more than about `most`: every k-th node.
    pub fn thinned(&self, most: usize) -> Raster<T> {
        let k = self.nx.max(self.ny).div_ceil(most.max(1)).max(1);
        let pick = |n: usize| (0..n).step_by(k);
        Raster {
            origin: self.origin,
            step: self.step * k as f64,
            nx: pick(self.nx).len(),
            ny: pick(self.ny).len(),
            values: pick(self.ny)
                .flat_map(|j| pick(self.nx).map(move |i| (i, j)))
                .filter_map(|(i, j)| self.get(i as i64, j as i64))
                .collect(),
        }
    }
}

impl Raster<f32> {
    /// Between the four nodes around a place; NaN where one of them is missing.
    pub fn bilinear(&self, p: Point2) -> f32 {
        let (x, y) = self.grid_place(p);
        // A place on the last line belongs to the cell before it.
        let cell = |t: f64, n: usize| (t.floor() as i64).clamp(0, (n as i64 - 2).max(0));
        if !(x >= -1e-6
            && y >= -1e-6
            && x <= self.nx as f64 - 1.0 + 1e-6
            && y <= self.ny as f64 - 1.0 + 1e-6)
        {
            return f32::NAN;
        }
        let (i, j) = (cell(x, self.nx), cell(y, self.ny));
        let (u, v) = ((x - i as f64) as f32, (y - j as f64) as f32);
        let at = |a: i64, b: i64| self.get(i + a, j + b).unwrap_or(f32::NAN);
        (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v)
            + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v
    }

    /// Smallest and largest value; none if all are NaN or infinite.
    pub fn range(&self) -> Option<(f32, f32)> {
        self.values
            .iter()
            .filter(|v| v.is_finite())
            .fold(None, |r, &v| match r {
                None => Some((v, v)),
                Some((a, b)) => Some((a.min(v), b.max(v))),
            })
    }

    /// Mean over the window of `2 r + 1` nodes squared, NaN left out.
    pub fn blurred(&self, r: usize) -> Raster<f32> {
        let pass =
            |values: &[(f64, f64)], n: usize, stride: usize, rows: usize, row_stride: usize| {
                let mut out = vec![(0.0, 0.0); values.len()];
                for row in 0..rows {
                    let at = |k: usize| row * row_stride + k * stride;
                    let (mut sum, mut weight) = (0.0, 0.0);
                    for k in 0..n + r {
                        if k < n {
                            let (s, w) = values[at(k)];
                            sum += s;
                            weight += w;
                        }
                        if k > 2 * r {
                            let (s, w) = values[at(k - 2 * r - 1)];
                            sum -= s;
                            weight -= w;
                        }
                        if k >= r {
                            out[at(k - r)] = (sum, weight);
                        }
                    }
                }
                out
            };
        let start: Vec<(f64, f64)> = self
            .values
            .iter()
            .map(|v| {
                if v.is_finite() {
                    (f64::from(*v), 1.0)
                } else {
                    (0.0, 0.0)
                }
            })
            .collect();
        let along_x = pass(&start, self.nx, 1, self.ny, self.nx);
        let both = pass(&along_x, self.ny, self.nx, self.nx, 1);
        Raster {
            values: both
                .into_iter()
                .map(|(s, w)| if w > 0.5 { (s / w) as f32 } else { f32::NAN })
                .collect(),
            ..self.clone()
        }
    }
}

impl Raster<u16> {
    /// The label with the largest bilinear weight at a place: smooth borders instead of stairs. 0 outside.
    pub fn label_at(&self, p: Point2) -> u16 {
        let (x, y) = self.grid_place(p);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (u, v) = (x - x.floor(), y - y.floor());
        let corners = [
            (self.get(i, j), (1.0 - u) * (1.0 - v)),
            (self.get(i + 1, j), u * (1.0 - v)),
            (self.get(i, j + 1), (1.0 - u) * v),
            (self.get(i + 1, j + 1), u * v),
        ];
        let mut best = (0, 0.0);
        for (label, _) in corners {
            let Some(label) = label else { continue };
            let weight: f64 = corners
                .iter()
                .filter(|c| c.0 == Some(label))
                .map(|c| c.1)
                .sum();
            if weight > best.1 {
                best = (label, weight);
            }
        }
        best.0
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn ramp() -> Raster<f32> {
        Raster {
            origin: Point2::new(1.0, 2.0),
            step: 0.5,
            nx: 5,
            ny: 4,
            values: (0..20)
                .map(|k| (k % 5) as f32 * 0.5 + (k / 5) as f32)
                .collect(),
        }
    }

    #[test]
    fn bilinear_is_exact_on_planes_and_nan_outside() {
        let r = ramp();
        // z = (x - 1) + 2 (y - 2)
        for (x, y) in [(1.0, 2.0), (3.0, 3.5), (1.7, 2.9), (2.25, 3.0)] {
            let want = (x - 1.0) + 2.0 * (y - 2.0);
            assert!((f64::from(r.bilinear(Point2::new(x, y))) - want).abs() < 1e-6);
        }
        for (x, y) in [(0.9, 2.5), (3.1, 2.5), (2.0, 3.6), (f64::NAN, 3.0)] {
            assert!(r.bilinear(Point2::new(x, y)).is_nan());
        }
    }

    #[test]
    fn blur_keeps_planes_inside_and_thinning_keeps_places() {
        let r = ramp();
        let b = r.blurred(1);
        assert!((b.get(2, 2).unwrap() - r.get(2, 2).unwrap()).abs() < 1e-6);
        assert_eq!(b.values.len(), 20);
        let t = r.thinned(3);
        assert!(t.is_consistent());
        assert_eq!((t.nx, t.ny, t.get(1, 1)), (3, 2, r.get(2, 2)));
    }

    #[test]
    fn labels_follow_the_majority() {
        let r = Raster {
            origin: Point2::new(0.0, 0.0),
            step: 1.0,
            nx: 2,
            ny: 2,
            values: vec![1u16, 2, 2, 2],
        };
        assert_eq!(r.label_at(Point2::new(0.1, 0.1)), 1);
        assert_eq!(r.label_at(Point2::new(0.5, 0.5)), 2);
        assert_eq!(r.label_at(Point2::new(-5.0, 0.5)), 0);
    }
}
