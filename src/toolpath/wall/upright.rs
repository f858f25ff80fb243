//! The upright triangles of a part, asked in plan: the drop cutter, which looks down, does not see them.

use super::TOUCH;
use crate::geom::{Point, Point2, nearest_on_segment};
use crate::part::Mesh;
use crate::reach::ToolCentreGrid;
use crate::sweep::buckets::Buckets;

/// Triangles with a smaller vertical part of the normal are upright.
const UPRIGHT: f64 = 0.02;

/// The upright triangles of a part, sorted in plan.
pub struct Uprights<'a> {
    mesh: &'a Mesh,
    index: Vec<u32>,
    buckets: Buckets,
    radius: f64,
}

impl<'a> Uprights<'a> {
    /// Sorts the upright triangles for a ball of this radius, mm.
    pub fn new(mesh: &'a Mesh, radius: f64) -> Uprights<'a> {
        let index: Vec<u32> = mesh
            .triangles
            .iter()
            .enumerate()
            .filter(|(_, t)| {
                let n = Mesh::doubled_area_vector(t);
                let l = n.norm();
                l > 0.0 && n.z.abs() < UPRIGHT * l
            })
            .map(|(i, _)| i as u32)
            .collect();
        let b = mesh.bounds();
        let (min, max) = (b.min.xy(), b.max.xy());
        let buckets = Buckets::of_triangles(min, max, 0.5 * radius, index.len(), |i| {
            &mesh.triangles[index[i] as usize]
        });
        Uprights {
            mesh,
            index,
            buckets,
            radius,
        }
    }

    /// True for a part without upright triangles.
    pub(super) fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// The nearest place on an upright wall to a place in plan, in the plane at this height, and how far it is; `None` beyond `within`
    /// mm or so.
    pub(super) fn nearest(&self, q: &Point2, z: f64, within: f64) -> Option<(f64, Point2)> {
        if self.index.is_empty() {
            return None;
        }
        let b = &self.buckets;
        let mut best: Option<(f64, Point2)> = None;
        for by in b.rows(q.y - within, q.y + within) {
            for bx in b.columns(q.x - within, q.x + within) {
                for &k in b.of(by * b.nx + bx) {
                    let t = &self.mesh.triangles[self.index[k as usize] as usize];
                    if let Some(found) = section_nearest(t, q, z)
                        && best.is_none_or(|b| found.0 < b.0)
                    {
                        best = Some(found);
                    }
                }
            }
        }
        best
    }

    /// Does the ball with its centre here touch an upright wall, and stand in none?
    pub(super) fn touches(&self, q: &Point2, z: f64) -> bool {
        self.nearest(q, z, 1.1 * self.radius)
            .is_some_and(|(d, _)| (d - self.radius).abs() < TOUCH)
    }

    /// Does a wall go down from the outline that this node's ball rolls round?
    pub(super) fn outer(&self, grid: &ToolCentreGrid, node: usize) -> bool {
        let p = grid.point[node];
        self.nearest(&p.xy(), p.z - 0.02 * self.radius, 0.1 * self.radius)
            .is_some_and(|(d, _)| d < 2.0 * TOUCH)
    }
}

/// The place on the cut of a triangle at height z that is nearest to q in plan, and how far it is; `None` when it is not cut there.
fn section_nearest(t: &[Point; 3], q: &Point2, z: f64) -> Option<(f64, Point2)> {
    let mut ends: [Option<Point2>; 2] = [None; 2];
    for k in 0..3 {
        let (a, b) = (&t[k], &t[(k + 1) % 3]);
        if (a.z > z) != (b.z > z) {
            let p = a.xy() + (b.xy() - a.xy()) * ((z - a.z) / (b.z - a.z));
            if ends[0].is_none() {
                ends[0] = Some(p);
            } else {
                ends[1] = Some(p);
            }
        }
    }
    let [Some(a), Some(b)] = ends else {
        return None;
    };
    let p = nearest_on_segment(q, &a, &b);
    Some(((p - q).norm(), p))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// The section of an upright triangle narrows towards its tip.
    #[test]
    fn a_section_is_as_wide_as_the_triangle_is_there() {
        let t = [
            Point::new(0.0, 0.0, 0.0),
            Point::new(4.0, 0.0, 0.0),
            Point::new(0.0, 0.0, 4.0),
        ];
        let (d, p) = section_nearest(&t, &Point2::new(3.0, 3.0), 1.0).unwrap();
        assert!((d - 3.0).abs() < 1e-12 && (p - Point2::new(3.0, 0.0)).norm() < 1e-12);
        let (d, _) = section_nearest(&t, &Point2::new(4.0, 0.0), 2.0).unwrap();
        assert!((d - 2.0).abs() < 1e-12);
        assert_eq!(section_nearest(&t, &Point2::origin(), 5.0), None);
    }
}
