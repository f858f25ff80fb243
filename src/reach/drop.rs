//! The drop cutter: a ball lowered along a vertical line until it touches the part.

use super::bvh::Bvh;
use super::contact::{inside_in_plan, touch};
use crate::geom::{Box3, Point};
use crate::part::Mesh;

/// Where a lowered ball comes to rest. Work coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Centre of the ball.
    pub center: Point,
    /// The point of the part it touches; one radius from the centre.
    pub point: Point,
    /// Number of the triangle touched, in the mesh; the lowest one on a tie.
    pub triangle: u32,
}

impl Contact {
    /// Vertical component of the unit vector from the contact to the centre: 1 on the flat, 0 on an upright wall.
    pub fn normal_z(&self) -> f64 {
        let d = self.center - self.point;
        let n = d.norm();
        if n > 0.0 { (d.z / n).max(0.0) } else { 1.0 }
    }
}

/// Where the last ball rested: a good first guess for the next one nearby. It changes the cost, never the answer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hint(Option<u32>);

/// A part made ready for one ball. Memory: about 200 bytes a triangle.
#[derive(Debug)]
pub struct DropCutter {
    radius: f64,
    bvh: Bvh,
    triangles: Vec<[Point; 3]>,
    bounds: Box3,
    /// Rounding room in the pruning bounds, mm.
    slack: f64,
}

impl DropCutter {
    /// Sorts the part for queries with a ball of this radius (mm). O(n log n).
    pub fn new(mesh: &Mesh, radius: f64) -> DropCutter {
        let bvh = Bvh::new(&mesh.triangles, radius);
        let triangles: Vec<[Point; 3]> = bvh
            .order
            .iter()
            .map(|&i| mesh.triangles[i as usize])
            .collect();
        let bounds = mesh.bounds();
        let extent = bounds.size().norm() + radius + bounds.min.coords.norm().min(1e12);
        DropCutter {
            radius,
            bvh,
            triangles,
            bounds,
            slack: 1e-12 * extent,
        }
    }

    /// Radius of the ball, mm.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The part's bounding box.
    pub fn bounds(&self) -> Box3 {
        self.bounds
    }

    /// The ball lowered along (x, y): first touch from above, `None` over empty air. One tree query.
    pub fn drop(&self, x: f64, y: f64) -> Option<Contact> {
        self.drop_near(x, y, &mut Hint::default())
    }

    /// As [`DropCutter::drop`], starting from where the last ball rested.
    pub fn drop_near(&self, x: f64, y: f64, hint: &mut Hint) -> Option<Contact> {
        let r = self.radius;
        // (height, mesh triangle, leaf position) of the best so far.
        let mut best: Option<(f64, u32, u32)> = None;
        if let Some(k) = hint.0 {
            self.offer(k, x, y, &mut best);
        }
        let floor_of =
            |best: &Option<(f64, u32, u32)>| best.map_or(f64::NEG_INFINITY, |b| b.0 - self.slack);
        if !self.bvh.nodes.is_empty() {
            // The tree is balanced: its depth is the logarithm of the triangles, so 64 places never fill.
            let mut stack = [(0u32, 0.0f64); 64];
            let mut depth = 1;
            stack[0] = (0, f64::INFINITY);
            while depth > 0 {
                depth -= 1;
                let (index, bound) = stack[depth];
                if bound < floor_of(&best) {
                    continue;
                }
                let node = &self.bvh.nodes[index as usize];
                if node.count > 0 {
                    for k in node.first..node.first + node.count {
                        let bound = self.bvh.bounds[k as usize].height(x, y, r);
                        if bound > f64::NEG_INFINITY && bound >= floor_of(&best) {
                            self.offer(k, x, y, &mut best);
                        }
                    }
                    continue;
                }
                let left = self.bvh.nodes[node.first as usize].bound.height(x, y, r);
                let right = self.bvh.nodes[node.first as usize + 1]
                    .bound
                    .height(x, y, r);
                // The higher bound first: it raises the floor for the other.
                let ((near, nb), (far, fb)) = if left >= right {
                    ((node.first, left), (node.first + 1, right))
                } else {
                    ((node.first + 1, right), (node.first, left))
                };
                let floor = floor_of(&best);
                for (child, bound) in [(far, fb), (near, nb)] {
                    if bound > f64::NEG_INFINITY && bound >= floor && depth < stack.len() {
                        stack[depth] = (child, bound);
                        depth += 1;
                    }
                }
            }
        }
        let (_, triangle, leaf) = best?;
        hint.0 = Some(leaf);
        let (z, point) = touch(&self.triangles[leaf as usize], self.radius, x, y)?;
        Some(Contact {
            center: Point::new(x, y, z),
            point,
            triangle,
        })
    }

    #[inline]
    fn offer(&self, leaf: u32, x: f64, y: f64, best: &mut Option<(f64, u32, u32)>) {
        if let Some((z, _)) = touch(&self.triangles[leaf as usize], self.radius, x, y) {
            let id = self.bvh.order[leaf as usize];
            if best.is_none_or(|(bz, bid, _)| z > bz || (z == bz && id < bid)) {
                *best = Some((z, id, leaf));
            }
        }
    }

    /// Height of the highest point of the part on the vertical line through (x, y); `None` where the part casts no shadow.
    pub fn surface_z(&self, x: f64, y: f64) -> Option<f64> {
        let mut best = f64::NEG_INFINITY;
        self.over(x, y, f64::NEG_INFINITY, |i| {
            let t = &self.triangles[i];
            if inside_in_plan(t, x, y) {
                best = best.max(height_in_plan(t, x, y));
            }
            best
        });
        (best > f64::NEG_INFINITY).then_some(best)
    }

    /// True when the part casts a shadow on (x, y).
    pub fn shades(&self, x: f64, y: f64) -> bool {
        let mut any = false;
        self.over(x, y, f64::NEG_INFINITY, |i| {
            any |= inside_in_plan(&self.triangles[i], x, y);
            if any {
                f64::INFINITY
            } else {
                f64::NEG_INFINITY
            }
        });
        any
    }

    /// Calls `f` with the leaf position of each triangle whose box in plan holds (x, y) and reaches above `floor`; `f` answers the
    /// new floor.
    fn over(&self, x: f64, y: f64, mut floor: f64, mut f: impl FnMut(usize) -> f64) {
        if self.bvh.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.bvh.nodes[stack[depth] as usize];
            if node.bound.top() <= floor || !node.bound.holds(x, y) {
                continue;
            }
            if node.count > 0 {
                for k in node.first..node.first + node.count {
                    let b = &self.bvh.bounds[k as usize];
                    if b.top() > floor && b.holds(x, y) {
                        floor = floor.max(f(k as usize));
                    }
                }
            } else if depth + 1 < stack.len() {
                stack[depth] = node.first;
                stack[depth + 1] = node.first + 1;
                depth += 2;
            }
        }
    }

    /// The triangles whose boxes in plan overlap a rectangle, in the order of the tree.
    pub(super) fn within(&self, min: [f64; 2], max: [f64; 2]) -> Vec<[Point; 3]> {
        let mut out = Vec::new();
        let mut stack = vec![0u32];
        if self.bvh.nodes.is_empty() {
            return out;
        }
        while let Some(index) = stack.pop() {
            let node = &self.bvh.nodes[index as usize];
            if !node.bound.overlaps(min, max) {
                continue;
            }
            if node.count > 0 {
                for k in node.first as usize..(node.first + node.count) as usize {
                    if self.bvh.bounds[k].overlaps(min, max) {
                        out.push(self.triangles[k]);
                    }
                }
            } else {
                stack.push(node.first + 1);
                stack.push(node.first);
            }
        }
        out
    }

    /// True when the contact sits on the outline of the part's shadow: some point `reach` mm beside it is over empty air.
    /// A ball there rolls off the part's edge rather than over its surface.
    pub fn on_outline(&self, contact: &Contact, reach: f64) -> bool {
        const D: f64 = std::f64::consts::FRAC_1_SQRT_2;
        const RING: [(f64, f64); 8] = [
            (1.0, 0.0),
            (D, D),
            (0.0, 1.0),
            (-D, D),
            (-1.0, 0.0),
            (-D, -D),
            (0.0, -1.0),
            (D, -D),
        ];
        let p = &contact.point;
        RING.iter()
            .any(|(u, v)| !self.shades(p.x + reach * u, p.y + reach * v))
    }
}

fn height_in_plan(t: &[Point; 3], x: f64, y: f64) -> f64 {
    let n = Mesh::doubled_area_vector(t);
    let z = t[0].z - ((x - t[0].x) * n.x + (y - t[0].y) * n.y) / n.z;
    let (lo, hi) = (
        t[0].z.min(t[1].z).min(t[2].z),
        t[0].z.max(t[1].z).max(t[2].z),
    );
    z.clamp(lo, hi)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn soup() -> impl Strategy<Value = Mesh> {
        let c = || -10.0..10.0f64;
        proptest::collection::vec(
            (
                c(),
                c(),
                -3.0..3.0f64,
                proptest::array::uniform9(-2.0..2.0f64),
            )
                .prop_map(|(x, y, z, d)| {
                    let p = |i: usize| Point::new(x + d[i], y + d[i + 1], z + d[i + 2]);
                    [p(0), p(3), p(6)]
                }),
            1..200,
        )
        .prop_map(|triangles| Mesh { triangles })
    }

    fn brute(mesh: &Mesh, r: f64, x: f64, y: f64) -> Option<f64> {
        mesh.triangles
            .iter()
            .filter_map(|t| super::super::touch_height(t, r, x, y))
            .fold(None, |b: Option<f64>, z| Some(b.map_or(z, |b| b.max(z))))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn equals_brute_force_with_and_without_hints(mesh in soup(), r in 0.2..3.0f64, seed in 0u64..1000) {
            let cutter = DropCutter::new(&mesh, r);
            let mut hint = Hint::default();
            for k in 0..60u64 {
                let q = (k * 7919 + seed * 104729) % 10007;
                let (x, y) = ((q % 100) as f64 * 0.25 - 12.5, (q / 100) as f64 * 0.25 - 12.5);
                let (want, got) = (brute(&mesh, r, x, y), cutter.drop(x, y));
                prop_assert_eq!(want, got.map(|c| c.center.z));
                prop_assert_eq!(got, cutter.drop_near(x, y, &mut hint));
            }
        }
    }

    #[test]
    fn the_empty_part_holds_nothing() {
        let cutter = DropCutter::new(&Mesh::default(), 3.0);
        assert_eq!(cutter.drop(0.0, 0.0), None);
        assert_eq!(cutter.surface_z(0.0, 0.0), None);
    }

    #[test]
    fn the_surface_is_the_highest_point_and_the_outline_is_found() {
        let square = |z: f64| {
            let p = |x, y| Point::new(x, y, z);
            [
                [p(0.0, 0.0), p(4.0, 0.0), p(4.0, 4.0)],
                [p(0.0, 0.0), p(4.0, 4.0), p(0.0, 4.0)],
            ]
        };
        let mesh = Mesh {
            triangles: [square(1.0), square(2.0)].concat(),
        };
        let cutter = DropCutter::new(&mesh, 1.0);
        assert_eq!(cutter.surface_z(1.0, 1.0), Some(2.0));
        assert_eq!(cutter.surface_z(2.0, 2.0), Some(2.0), "on the diagonal");
        assert_eq!(cutter.surface_z(5.0, 1.0), None);
        assert!(!cutter.on_outline(&cutter.drop(2.0, 2.0).unwrap(), 1e-3));
        assert!(
            cutter.on_outline(&cutter.drop(4.5, 2.0).unwrap(), 1e-3),
            "rolling off the edge"
        );
        assert_eq!(cutter.drop(4.5, 2.0).unwrap().triangle, 2);
    }
}
