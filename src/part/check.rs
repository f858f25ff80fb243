//! Is the triangle soup sound? Nothing found here stops a job: the reach of a ball over a soup needs no topology.
//!
//! Corners are [welded](super::weld) when exactly equal, then edges are counted. All by sorting integers with unique keys: the result
//! depends neither on threads nor on hash order.
//!
//! ```text
//! edge used   once          open: the rim of a sheet, or a hole
//!             twice         a proper joint; both facets must run through it in opposite directions, else one is flipped
//!             3 and more    crowded: bodies that touch, or facets inside others
//! ```

use rayon::prelude::*;
use serde::Serialize;

use super::mesh::Mesh;
use super::weld::{distinct, weld};
use crate::geom::{Point, Vector};

/// What the soup is like. Counts, mm.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Soundness {
    /// Triangles in the file.
    pub triangles: usize,
    /// Sum of their areas, duplicates counted once, mm2.
    pub area_mm2: f64,
    /// Enclosed volume, mm3, above zero; only for a closed part.
    pub volume_mm3: Option<f64>,
    /// Pieces that hang together by proper joints.
    pub shells: usize,
    /// Edges of one triangle only.
    pub open_edges: usize,
    /// Edges of more than two triangles.
    pub crowded_edges: usize,
    /// Triangles wound against the majority of their shell. [`Soundness::flipped`] lists them.
    pub flipped_facets: usize,
    /// Triangles whose three corners some earlier triangle has.
    pub duplicate_triangles: usize,
    /// Triangles without area: two corners equal, or a height below a millionth of the longest edge.
    pub degenerate_triangles: usize,
    /// No open edge, and every crowded edge has an even number of triangles.
    pub closed: bool,
    /// Closed, but most facets face inwards.
    pub inside_out: bool,
    /// Positions (from 0) in the mesh of the flipped facets, rising.
    #[serde(skip)]
    pub flipped: Vec<u32>,
}

impl Soundness {
    /// True when there is nothing to tell.
    pub fn is_clean(&self) -> bool {
        self.crowded_edges == 0
            && self.flipped_facets == 0
            && self.duplicate_triangles == 0
            && self.degenerate_triangles == 0
            && !self.inside_out
    }
}

/// Sets of triangles, each knowing whether it is wound like its set's root.
struct Shells {
    parent: Vec<u32>,
    against: Vec<bool>,
}

impl Shells {
    fn new(n: usize) -> Self {
        Shells {
            parent: (0..n as u32).collect(),
            against: vec![false; n],
        }
    }

    /// The root of a triangle's set, and whether the triangle is wound against it.
    fn find(&mut self, mut i: u32) -> (u32, bool) {
        let mut turned = false;
        loop {
            let p = self.parent[i as usize];
            if p == i {
                return (i, turned);
            }
            // Halve the way for the next caller.
            let g = self.parent[p as usize];
            let step = self.against[i as usize] ^ self.against[p as usize];
            if g != p {
                self.parent[i as usize] = g;
                self.against[i as usize] = step;
                turned ^= step;
                i = g;
            } else {
                turned ^= self.against[i as usize];
                i = p;
            }
        }
    }

    /// Joins two sets; a Moebius band's last joint says nothing new and is let be.
    fn join(&mut self, a: u32, b: u32, against: bool) {
        let ((ra, ta), (rb, tb)) = (self.find(a), self.find(b));
        if ra != rb {
            let (root, leaf) = (ra.min(rb), ra.max(rb));
            self.parent[leaf as usize] = root;
            self.against[leaf as usize] = ta ^ tb ^ against;
        }
    }
}

/// True for a triangle without area: a height below a millionth of its longest edge, or all corners in one place.
pub fn is_degenerate(t: &[Point; 3]) -> bool {
    let longest2 = (t[1] - t[0])
        .norm_squared()
        .max((t[2] - t[1]).norm_squared())
        .max((t[0] - t[2]).norm_squared());
    // height = |cross| / longest
    Mesh::doubled_area_vector(t).norm() <= 1e-6 * longest2
}

/// Examines a mesh of finite coordinates, mm. Cost: n log n, under a second for a million triangles on one core.
pub fn check(mesh: &Mesh) -> Soundness {
    let n = mesh.triangles.len();
    let mut s = Soundness {
        triangles: n,
        ..Default::default()
    };
    let ids = weld(mesh).triangles;
    s.degenerate_triangles = mesh.triangles.iter().filter(|t| is_degenerate(t)).count();

    let live;
    (live, s.duplicate_triangles) = distinct(&ids);

    // Edges as (corners in rising order, triangle and direction).
    let mut edges: Vec<(u64, u32, bool)> = live
        .iter()
        .flat_map(|&i| {
            let c = ids[i as usize];
            [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])].map(|(a, b)| {
                let key = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
                (key, i, a < b)
            })
        })
        .collect();
    edges.par_sort_unstable();
    let mut shells = Shells::new(n);
    let mut odd = false;
    for uses in edges.chunk_by(|a, b| a.0 == b.0) {
        match uses {
            [_] => s.open_edges += 1,
            [a, b] => shells.join(a.1, b.1, a.2 == b.2),
            more => {
                s.crowded_edges += 1;
                odd |= more.len() % 2 == 1;
            }
        }
    }
    drop(edges);
    s.closed = !live.is_empty() && s.open_edges == 0 && !odd;

    // The majority of each shell is taken to be right; on a tie its first triangle is.
    let mut votes = vec![[0u32; 2]; n];
    let found: Vec<(u32, bool)> = live.iter().map(|&i| shells.find(i)).collect();
    for &(root, against) in &found {
        votes[root as usize][usize::from(against)] += 1;
    }
    s.shells = votes.iter().filter(|v| v[0] + v[1] > 0).count();
    let origin = mesh.bounds().center();
    let mut six_volumes = 0.0;
    for (&i, &(root, against)) in live.iter().zip(&found) {
        let v = votes[root as usize];
        let flipped = against != (v[1] > v[0]);
        if flipped {
            s.flipped.push(i);
        }
        let t = &mesh.triangles[i as usize];
        let doubled = Mesh::doubled_area_vector(t);
        s.area_mm2 += 0.5 * doubled.norm();
        let outward: Vector = if flipped { -doubled } else { doubled };
        six_volumes += (t[0] - origin).dot(&outward);
    }
    s.flipped_facets = s.flipped.len();
    if s.closed {
        s.volume_mm3 = Some(six_volumes.abs() / 6.0);
        s.inside_out = six_volumes < 0.0;
    }
    s
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    /// A cube of edge 2 about (5, 0, 0), facets outward.
    pub(crate) fn cube() -> Mesh {
        let p = |i: usize| {
            let s = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            Point::new(5.0 + s(0), s(1), s(2))
        };
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|q| [[p(q[0]), p(q[1]), p(q[2])], [p(q[0]), p(q[2]), p(q[3])]])
            .collect();
        Mesh { triangles }
    }

    #[test]
    fn a_cube_is_closed_and_has_its_volume() {
        let s = check(&cube());
        assert!(s.closed && !s.inside_out && s.is_clean());
        assert_eq!((s.triangles, s.shells, s.open_edges), (12, 1, 0));
        assert!((s.area_mm2 - 24.0).abs() < 1e-12);
        assert!((s.volume_mm3.unwrap() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn an_inside_out_cube_says_so_and_keeps_its_volume() {
        let mut m = cube();
        m.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let s = check(&m);
        assert!(s.inside_out && s.flipped_facets == 0);
        assert!((s.volume_mm3.unwrap() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn each_fault_is_counted() {
        let mut m = cube();
        m.triangles[3].swap(1, 2); // flipped
        m.triangles.push(m.triangles[0]); // duplicate
        let t = m.triangles[5];
        m.triangles.push([t[1], t[0], t[2]]); // duplicate, wound the other way
        m.triangles.push([t[0], t[1], t[1]]); // degenerate
        m.triangles
            .push([t[0], t[1], nalgebra::center(&t[0], &t[1])]); // degenerate, three places
        let s = check(&m);
        assert_eq!(
            (
                s.flipped.as_slice(),
                s.duplicate_triangles,
                s.degenerate_triangles
            ),
            (&[3u32][..], 2, 2)
        );
        assert!((s.area_mm2 - 24.0).abs() < 1e-12);

        let mut m = cube();
        m.triangles.remove(7);
        let s = check(&m);
        assert_eq!((s.open_edges, s.closed, s.volume_mm3), (3, false, None));

        // Two cubes that share an edge: four facets there, still closed.
        let mut m = cube();
        let other: Vec<_> = m
            .triangles
            .iter()
            .map(|t| t.map(|p| p + Vector::new(2.0, 2.0, 0.0)))
            .collect();
        m.triangles.extend(other);
        let s = check(&m);
        assert_eq!((s.crowded_edges, s.shells, s.closed), (1, 2, true));
        assert!((s.volume_mm3.unwrap() - 16.0).abs() < 1e-12);
    }

    #[test]
    fn minus_zero_is_zero() {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let m = Mesh {
            triangles: vec![
                [p(0.0, 0.0), p(1.0, 0.0), p(0.0, 1.0)],
                [p(-0.0, -0.0), p(0.0, 1.0), p(-1.0, 0.0)],
            ],
        };
        assert_eq!(check(&m).open_edges, 4);
        assert_eq!(check(&Mesh::default()).triangles, 0);
    }

    proptest! {
        /// Whichever facets of a closed body are flipped, fewer than half are all found; the volume does not care.
        #[test]
        fn flips_are_found(flips in proptest::collection::btree_set(0usize..12, 0..6), shuffle in any::<u64>()) {
            let mut m = cube();
            for &i in &flips {
                m.triangles[i].swap(0, 2);
            }
            let k = (shuffle % 12) as usize;
            m.triangles.rotate_left(k);
            let s = check(&m);
            let mut want: Vec<u32> = flips.iter().map(|i| ((i + 12 - k) % 12) as u32).collect();
            want.sort_unstable();
            prop_assert_eq!(s.flipped, want);
            prop_assert!((s.volume_mm3.unwrap() - 8.0).abs() < 1e-12);
        }

        /// A soup of any corners from a small lattice, faults of all kinds: counts are consistent, and order does not matter.
        #[test]
        fn order_of_triangles_does_not_matter(
            soup in proptest::collection::vec(proptest::array::uniform3(proptest::array::uniform3(0u8..3)), 1..40),
        ) {
            let triangles: Vec<[Point; 3]> = soup
                .iter()
                .map(|t| t.map(|p| Point::new(p[0].into(), p[1].into(), p[2].into())))
                .collect();
            let a = check(&Mesh { triangles: triangles.clone() });
            let b = check(&Mesh { triangles: triangles.into_iter().rev().collect() });
            prop_assert_eq!((a.open_edges, a.crowded_edges, a.duplicate_triangles), (b.open_edges, b.crowded_edges, b.duplicate_triangles));
            prop_assert_eq!((a.degenerate_triangles, a.closed), (b.degenerate_triangles, b.closed));
            prop_assert!((a.area_mm2 - b.area_mm2).abs() < 1e-9);
        }
    }
}
