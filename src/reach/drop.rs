//! The drop cutter: a ball lowered along a vertical line until it touches the part.

use super::bvh::{Bvh, Child, WIDTH};
use super::contact::{inside_in_plan, normal, touch, touch_above};
use crate::geom::{Box3, Point, Point2, Vector, compass};
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

/// A part made ready for one ball. Memory: about 190 bytes a triangle.
#[derive(Debug)]
pub struct DropCutter {
    radius: f64,
    bvh: Bvh,
    /// Corners and upward normal, in the tree's order.
    triangles: Vec<([Point; 3], Vector)>,
    bounds: Box3,
    /// Rounding room in exact comparisons, mm.
    slack: f64,
}

/// Nodes that wait at most: three for each level, and a branch holds a quarter of its node's triangles (and up to four more).
const WAITING: usize = 64;

/// The best so far.
#[derive(Clone, Copy)]
struct Best {
    z: f64,
    /// Number in the mesh, and place in the tree.
    id: u32,
    place: u32,
}

impl Best {
    const NONE: Best = Best {
        z: f64::NEG_INFINITY,
        id: u32::MAX,
        place: u32::MAX,
    };
}

impl DropCutter {
    /// Sorts the part for queries with a ball of this radius (mm). O(n log n).
    pub fn new(mesh: &Mesh, radius: f64) -> DropCutter {
        let bvh = Bvh::new(&mesh.triangles, radius);
        let triangles = bvh
            .order
            .iter()
            .map(|&i| mesh.triangles[i as usize])
            .map(|t| (t, normal(&t)))
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

    /// True unless (x, y) lies off the part's box in plan by more than `by`.
    fn near(&self, x: f64, y: f64, by: f64) -> bool {
        let b = &self.bounds;
        x >= b.min.x - by && x <= b.max.x + by && y >= b.min.y - by && y <= b.max.y + by
    }

    /// The ball lowered along (x, y): first touch from above, `None` over empty air. One tree query.
    pub fn drop(&self, x: f64, y: f64) -> Option<Contact> {
        self.drop_near(x, y, &mut Hint::default())
    }

    /// As [`DropCutter::drop`], starting from where the last ball rested.
    pub fn drop_near(&self, x: f64, y: f64, hint: &mut Hint) -> Option<Contact> {
        if self.bvh.nodes.is_empty() || !self.near(x, y, self.radius) {
            return None;
        }
        let mut best = Best::NONE;
        // A hint from another part is as good as none.
        if let Some(place) = hint.0.filter(|p| (*p as usize) < self.triangles.len()) {
            self.offer(place, x, y, &mut best);
        }
        let (lx, ly) = self.bvh.local(x, y);
        let r2 = self.bvh.radius_sq;
        // The bounds are wide enough for the rounding of this one too.
        let floor_of = |best: &Best| (best.z - self.bvh.middle.z) as f32;
        let mut floor = floor_of(&best);
        let mut waiting = [(f32::NEG_INFINITY, 0u32); WAITING];
        waiting[0] = (f32::INFINITY, 0);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (bound, index) = waiting[count];
            if bound < floor {
                continue;
            }
            let node = &self.bvh.nodes[index as usize];
            let heights = node.heights(lx, ly, r2);
            let begin = count;
            for (i, &bound) in heights.iter().enumerate() {
                if bound < floor || bound == f32::NEG_INFINITY {
                    continue;
                }
                match node.child(i) {
                    Child::Triangle(place) => {
                        if self.offer(place, x, y, &mut best) {
                            floor = floor_of(&best);
                        }
                    }
                    // The highest bound on top: it raises the floor for the others.
                    Child::Node(index) => {
                        let mut k = count;
                        while k > begin && waiting[k - 1].0 > bound {
                            waiting[k] = waiting[k - 1];
                            k -= 1;
                        }
                        waiting[k] = (bound, index);
                        count += 1;
                    }
                }
            }
        }
        if best.place == u32::MAX {
            return None;
        }
        hint.0 = Some(best.place);
        let (z, point) = touch(&self.triangles[best.place as usize].0, self.radius, x, y)?;
        Some(Contact {
            center: Point::new(x, y, z),
            point,
            triangle: best.id,
        })
    }

    /// Many places at once, in any order: as [`DropCutter::drop`] of each, but taken in an order in which neighbours follow one
    /// another, which is several times quicker than places at random. The answers are in the order of the places.
    pub fn drop_many(&self, places: &[Point2]) -> Vec<Option<Contact>> {
        let b = &self.bounds;
        // Interleaved bits of the cell, 2^16 cells a side: neighbours along this curve are neighbours in plan.
        let cell = |v: f64, lo: f64, hi: f64| {
            let share = (v - lo + self.radius) / (hi - lo + 2.0 * self.radius);
            spread((65535.0 * share) as u16)
        };
        let mut order: Vec<(u32, u32)> = places
            .iter()
            .enumerate()
            .map(|(i, p)| {
                let code = cell(p.x, b.min.x, b.max.x) | cell(p.y, b.min.y, b.max.y) << 1;
                (code, i as u32)
            })
            .collect();
        order.sort_unstable();
        let mut hint = Hint::default();
        let mut out = vec![None; places.len()];
        for (_, i) in order {
            let p = &places[i as usize];
            out[i as usize] = self.drop_near(p.x, p.y, &mut hint);
        }
        out
    }

    /// Lets a triangle hold the ball. True if it holds it higher than any before.
    #[inline]
    fn offer(&self, place: u32, x: f64, y: f64, best: &mut Best) -> bool {
        let (t, n) = &self.triangles[place as usize];
        let Some(z) = touch_above(t, n, self.radius, x, y, best.z - self.slack) else {
            return false;
        };
        let higher = z > best.z;
        if higher || z == best.z {
            let id = self.bvh.order[place as usize];
            if higher || id < best.id {
                *best = Best { z, id, place };
            }
        }
        higher
    }

    /// Height of the highest point of the part on the vertical line through (x, y); `None` where the part casts no shadow.
    pub fn surface_z(&self, x: f64, y: f64) -> Option<f64> {
        let mut best = f64::NEG_INFINITY;
        self.over(x, y, |t| {
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
        self.over(x, y, |t| {
            any |= inside_in_plan(t, x, y);
            if any {
                f64::INFINITY
            } else {
                f64::NEG_INFINITY
            }
        });
        any
    }

    /// Calls `f` with each triangle whose box in plan holds (x, y) and reaches up to the floor; `f` answers the new floor.
    fn over(&self, x: f64, y: f64, mut f: impl FnMut(&[Point; 3]) -> f64) {
        if self.bvh.nodes.is_empty() || !self.near(x, y, 0.0) {
            return;
        }
        let (lx, ly) = self.bvh.local(x, y);
        let mut floor = f32::NEG_INFINITY;
        let mut waiting = [0u32; WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = &self.bvh.nodes[waiting[count] as usize];
            let over = node.over(lx, ly, floor);
            for (i, _) in over.iter().enumerate().filter(|(_, over)| **over) {
                match node.child(i) {
                    Child::Triangle(place) => {
                        let new = f(&self.triangles[place as usize].0);
                        floor = floor.max((new - self.bvh.middle.z) as f32);
                    }
                    Child::Node(index) => {
                        waiting[count] = index;
                        count += 1;
                    }
                }
            }
        }
    }

    /// The triangles whose boxes in plan overlap a rectangle (and perhaps some that end within rounding of it), in the order of the
    /// tree.
    pub(super) fn within(&self, min: [f64; 2], max: [f64; 2]) -> Vec<[Point; 3]> {
        let mut out = Vec::new();
        if self.bvh.nodes.is_empty() {
            return out;
        }
        // Within the part's own box, where single precision is as good as the boxes are wide.
        let b = &self.bounds;
        let (lx, ly) = self.bvh.local(min[0].max(b.min.x), min[1].max(b.min.y));
        let (hx, hy) = self.bvh.local(max[0].min(b.max.x), max[1].min(b.max.y));
        let mut waiting = vec![Child::Node(0)];
        while let Some(next) = waiting.pop() {
            match next {
                Child::Triangle(place) => out.push(self.triangles[place as usize].0),
                Child::Node(index) => {
                    let node = &self.bvh.nodes[index as usize];
                    let over = node.overlap([lx, ly], [hx, hy]);
                    let branches = (0..WIDTH).rev().filter(|i| over[*i]);
                    waiting.extend(branches.map(|i| node.child(i)));
                }
            }
        }
        out
    }

    /// True when the contact sits on the outline of the part's shadow: some point `reach` mm beside it is over empty air.
    /// A ball there rolls off the part's edge rather than over its surface.
    pub fn on_outline(&self, contact: &Contact, reach: f64) -> bool {
        let p = &contact.point;
        compass()
            .iter()
            .any(|d| !self.shades(p.x + reach * d.x, p.y + reach * d.y))
    }
}

/// Puts a zero before each bit.
fn spread(v: u16) -> u32 {
    let mut v = u32::from(v);
    v = (v | v << 8) & 0x00ff_00ff;
    v = (v | v << 4) & 0x0f0f_0f0f;
    v = (v | v << 2) & 0x3333_3333;
    (v | v << 1) & 0x5555_5555
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

        /// Slivers, walls, flat and steep ground, near zero and far from it; every query, every hint.
        #[test]
        fn equals_brute_force_on_what_cad_makes(
            mesh in soup(), r in 0.2..3.0f64, thin in 1e-6..1.0f64, tall in 0.0..30.0f64, far in 0..3usize,
            places in proptest::collection::vec((-12.0..12.0f64, -12.0..12.0f64), 60),
        ) {
            let off = [0.0, 300.0, 1e5][far];
            let moved = |p: &Point, q: &Point| {
                let d = p - q;
                Point::new(q.x + d.x + off, q.y + d.y * thin - off, q.z + d.z * tall)
            };
            let mesh = Mesh {
                triangles: mesh.triangles.iter().map(|t| [moved(&t[0], &t[0]), moved(&t[1], &t[0]), moved(&t[2], &t[0])]).collect(),
            };
            let cutter = DropCutter::new(&mesh, r);
            let places: Vec<Point2> = places.iter().map(|(x, y)| Point2::new(x + off, y - off)).collect();
            let mut hint = Hint::default();
            for (p, of_all) in places.iter().zip(cutter.drop_many(&places)) {
                let got = cutter.drop(p.x, p.y);
                prop_assert_eq!(brute(&mesh, r, p.x, p.y), got.map(|c| c.center.z));
                prop_assert_eq!(got, cutter.drop_near(p.x, p.y, &mut hint));
                prop_assert_eq!(got, of_all);
            }
        }

        /// A smooth relief of many small triangles, where the bounds decide nearly everything.
        #[test]
        fn equals_brute_force_on_a_relief(r in 0.5..4.0f64, a in 0.0..2.0f64, k in 0.2..1.5f64, places in proptest::collection::vec((-1.0..11.0f64, -1.0..11.0f64), 40)) {
            let n = 40;
            let p = |i: usize, j: usize| {
                let (x, y) = (0.25 * i as f64, 0.25 * j as f64);
                Point::new(x, y, a * (k * x).sin() * (k * y).cos())
            };
            let mut mesh = Mesh::default();
            for j in 0..n {
                for i in 0..n {
                    mesh.triangles.push([p(i, j), p(i + 1, j), p(i + 1, j + 1)]);
                    mesh.triangles.push([p(i, j), p(i + 1, j + 1), p(i, j + 1)]);
                }
            }
            let cutter = DropCutter::new(&mesh, r);
            let mut hint = Hint::default();
            for (x, y) in places {
                let got = cutter.drop(x, y);
                prop_assert_eq!(brute(&mesh, r, x, y), got.map(|c| c.center.z));
                prop_assert_eq!(got, cutter.drop_near(x, y, &mut hint));
            }
        }
    }

    #[test]
    fn the_empty_part_holds_nothing() {
        let cutter = DropCutter::new(&Mesh::default(), 3.0);
        assert_eq!(cutter.drop(0.0, 0.0), None);
        assert_eq!(cutter.surface_z(0.0, 0.0), None);
        let one = Mesh {
            triangles: vec![[Point::new(0.0, 0.0, 1.0); 3]],
        };
        let cutter = DropCutter::new(&one, 3.0);
        assert_eq!(cutter.drop(0.0, 0.0).map(|c| c.center.z), Some(4.0));
        for far in [4.0, 1e300, f64::INFINITY, f64::NAN] {
            assert_eq!(cutter.drop(far, 0.0), None);
            assert_eq!(cutter.drop_many(&[Point2::new(0.0, far)]), [None]);
        }
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
