//! Corners in exactly one place become one vertex.
//!
//! No tolerance: it would be one more thing to be wrong about. By sorting integers with unique keys: the result depends neither on
//! threads nor on hash order.

use super::mesh::Mesh;
use crate::geom::Point;
use rayon::prelude::*;

/// A mesh whose triangles know which corners they share.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Welded {
    /// For each vertex, by first appearance, its first corner: three times the triangle's position in the mesh, and which of its three.
    pub corners: Vec<u32>,
    /// The vertices of each triangle of the mesh.
    pub triangles: Vec<[u32; 3]>,
}

impl Welded {
    /// Where the vertices are, mm, as the mesh has them.
    pub fn points(&self, mesh: &Mesh) -> Vec<Point> {
        self.corners.iter().map(|&c| *corner(mesh, c)).collect()
    }
}

fn corner(mesh: &Mesh, i: u32) -> &Point {
    &mesh.triangles[i as usize / 3][i as usize % 3]
}

/// The positions, rising, of the triangles that have three different corners; of several over the same corners the first. Also how many
/// were left out because another has their corners. Cost: n log n.
pub fn distinct(triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets: Vec<([u32; 3], u32)> = triangles
        .par_iter()
        .enumerate()
        .filter(|(_, c)| c[0] != c[1] && c[1] != c[2] && c[2] != c[0])
        .map(|(i, c)| {
            let mut c = *c;
            c.sort_unstable();
            (c, i as u32)
        })
        .collect();
    sets.par_sort_unstable();
    let all = sets.len();
    sets.dedup_by_key(|s| s.0);
    let mut kept: Vec<u32> = sets.iter().map(|s| s.1).collect();
    kept.par_sort_unstable();
    (kept, all - sets.len())
}

/// Welds the corners of a mesh of finite coordinates. Cost: n log n.
pub fn weld(mesh: &Mesh) -> Welded {
    // Adding zero turns -0 into +0: the same place. Distinct places with one hash are told apart below.
    let bits = |p: &Point| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits);
    let hash = |b: [u64; 3]| {
        b.into_iter().fold(0x9e37_79b9_7f4a_7c15u64, |h, v| {
            let h = (h ^ v).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            (h ^ (h >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb) ^ (h >> 32)
        })
    };
    let mut order: Vec<(u64, u32)> = (0..3 * mesh.triangles.len() as u32)
        .into_par_iter()
        .map(|i| (hash(bits(corner(mesh, i))), i))
        .collect();
    order.par_sort_unstable();
    // Each corner's first fellow: corners rise within a run.
    let mut first = vec![0u32; order.len()];
    // One place per run, save for a hash collision.
    let mut places: Vec<([u64; 3], u32)> = Vec::new();
    for run in order.chunk_by(|a, b| a.0 == b.0) {
        places.clear();
        for &(_, i) in run {
            let b = bits(corner(mesh, i));
            first[i as usize] = match places.iter().find(|(place, _)| *place == b) {
                Some(&(_, fellow)) => fellow,
                None => {
                    places.push((b, i));
                    i
                }
            };
        }
    }
    drop(order);
    // From corners to vertices, in place: a fellow comes before those that name it.
    let mut corners = Vec::new();
    for i in 0..first.len() {
        let fellow = first[i] as usize;
        first[i] = if fellow == i {
            corners.push(i as u32);
            corners.len() as u32 - 1
        } else {
            first[fellow]
        };
    }
    Welded {
        corners,
        triangles: first.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_are_one_vertex_and_near_ones_are_not() {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let mesh = Mesh {
            triangles: vec![
                [p(0.0, 0.0), p(1.0, 0.0), p(0.0, 1.0)],
                [p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)],
                [p(-0.0, 0.0), p(1e-12, 0.0), p(1.0, 1.0)],
            ],
        };
        let w = weld(&mesh);
        assert_eq!(w.triangles, [[0, 1, 2], [1, 3, 2], [0, 4, 3]]);
        assert_eq!(w.corners, [0, 1, 2, 4, 7]);
        assert_eq!(w.points(&mesh)[3], p(1.0, 1.0));
        assert_eq!(weld(&Mesh::default()), Welded::default());
    }
}
