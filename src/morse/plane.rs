//! The plane that fits a surface best: least squares of the distance, every square millimetre counting alike.

use super::surface::Surface;
use crate::geom::{Point, Vector};
use nalgebra::{Matrix3, SymmetricEigen};

/// A plane: a point of it and its unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The surface's centroid.
    pub point: Point,
    /// Unit normal, on the side of +Z (of +X, +Y when it lies level).
    pub normal: Vector,
}

/// Spreads that differ by less than this share of the largest are one: then the directions between them are a matter of rounding.
const EQUAL: f64 = 1e-6;

impl Plane {
    /// Signed distance, mm.
    pub fn distance(&self, p: &Point) -> f64 {
        (p - self.point).dot(&self.normal)
    }

    /// Fits a surface. Where several planes fit alike (a ball, a cube) the one most nearly level is taken. A surface without area gives
    /// the level plane through its first vertex.
    pub fn fitted(surface: &Surface) -> Plane {
        let base = surface.points.first().copied().unwrap_or_default();
        let mut area = 0.0;
        let mut sum = Vector::zeros();
        let mut second = Matrix3::zeros();
        for t in &surface.triangles {
            let w = surface.doubled_area(t).norm();
            let c = t.map(|v| surface.points[v as usize] - base);
            let s = c[0] + c[1] + c[2];
            area += w;
            sum += s * (w / 3.0);
            // Exact over a triangle: (sum of c c' + s s') / 12.
            let m = c[0] * c[0].transpose() + c[1] * c[1].transpose() + c[2] * c[2].transpose();
            second += (m + s * s.transpose()) * (w / 12.0);
        }
        let level = Plane {
            point: base,
            normal: Vector::z(),
        };
        if !(area > 0.0 && area.is_finite()) {
            return level;
        }
        let mean = sum / area;
        let spread = second / area - mean * mean.transpose();
        let e = SymmetricEigen::new(spread);
        let least = e.eigenvalues.min();
        let largest = e.eigenvalues.max();
        // +Z, +X, +Y in turn, projected on all directions of the least spread.
        let mut normal = None;
        for axis in [Vector::z(), Vector::x(), Vector::y()] {
            let mut n = Vector::zeros();
            for k in 0..3 {
                if e.eigenvalues[k] - least <= EQUAL * largest {
                    let v: Vector = e.eigenvectors.column(k).into_owned();
                    n += v * v.dot(&axis);
                }
            }
            if n.norm() > 1e-6 {
                normal = Some(n.normalize());
                break;
            }
        }
        Plane {
            point: base + mean,
            normal: normal.unwrap_or(Vector::z()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilted_sheet_lies_in_its_plane_and_a_ball_has_a_level_one() {
        let n = Vector::new(0.3, -0.2, 0.9).normalize();
        let e1 = n.cross(&Vector::x()).normalize();
        let e2 = n.cross(&e1);
        let at = |u: f64, v: f64| Point::new(5.0, 6.0, 7.0) + e1 * u + e2 * v;
        // Two rectangles of very different density.
        let points = vec![
            at(0.0, 0.0),
            at(1.0, 0.0),
            at(1.0, 40.0),
            at(0.0, 40.0),
            at(9.0, 0.0),
            at(9.0, 40.0),
        ];
        let s = Surface::new(&points, &[[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]);
        let plane = Plane::fitted(&s);
        assert!((plane.normal - n).norm() < 1e-9, "{plane:?}");
        assert!((plane.point - at(4.5, 20.0)).norm() < 1e-9);
        // An octahedron: all planes alike.
        let p: Vec<Point> = [
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ]
        .iter()
        .map(|c| Point::new(c[0], c[1], c[2]))
        .collect();
        let mut t = Vec::new();
        for x in [0u32, 1] {
            for y in [2u32, 3] {
                for z in [4u32, 5] {
                    t.push([x, y, z]);
                }
            }
        }
        let plane = Plane::fitted(&Surface::new(&p, &t));
        assert!((plane.normal - Vector::z()).norm() < 1e-9);
    }
}
