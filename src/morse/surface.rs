//! A triangulated surface with its neighbourhoods: a welded mesh, or the ground of a tool-centre grid.
//!
//! ```text
//!   soup of triangles  --corners in exactly one place are one vertex-->  vertices, triangles, edges
//!   edge used once: border      twice: inside      3 and more: crowded (reported; everything below still works)
//! ```
//!
//! No tolerance: corners that are nearly in one place stay two, as [`crate::part::weld()`] has them.

use crate::geom::{Point, Vector};
use crate::part::weld::distinct;
use crate::part::{Mesh, Soundness, weld};
use crate::reach::{LINK, ToolCentreGrid};
use rayon::prelude::*;

/// Vertices, triangles and edges of a surface; mm. Every vertex has a triangle.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Places of the vertices.
    pub points: Vec<Point>,
    /// Corners of each triangle, three different ones, no two triangles with the same three.
    pub triangles: Vec<[u32; 3]>,
    /// Every edge once, smaller vertex first, rising.
    pub edges: Vec<[u32; 2]>,
    /// Vertices on an edge that has one triangle only.
    pub border: Vec<bool>,
    /// Edges of more than two triangles: the surface branches there.
    pub crowded_edges: usize,
    /// Area that each vertex stands for: a third of its triangles', mm2.
    pub area: Vec<f64>,
    /// Neighbours of vertex i: `neighbour[start[i]..start[i + 1]]`, rising.
    start: Vec<u32>,
    neighbour: Vec<u32>,
}

impl Surface {
    /// Takes triangles over given vertices. Triangles with a corner twice and repeated ones are dropped, and so are vertices without a
    /// triangle; the rest keep their order.
    pub fn new(points: &[Point], triangles: &[[u32; 3]]) -> Surface {
        let (live, _) = distinct(triangles);
        let mut id = vec![u32::MAX; points.len()];
        for &t in &live {
            for c in triangles[t as usize] {
                id[c as usize] = 0;
            }
        }
        let mut kept = Vec::new();
        for (k, i) in id.iter_mut().enumerate().filter(|(_, i)| **i == 0) {
            *i = kept.len() as u32;
            kept.push(points[k]);
        }
        let triangles: Vec<[u32; 3]> = live
            .iter()
            .map(|&t| triangles[t as usize].map(|c| id[c as usize]))
            .collect();
        Surface::linked(kept, triangles)
    }

    fn linked(points: Vec<Point>, triangles: Vec<[u32; 3]>) -> Surface {
        let n = points.len();
        let runs = edge_runs(&triangles);
        let mut border = vec![false; n];
        let mut crowded_edges = 0;
        for &(e, count) in &runs {
            if count == 1 {
                border[e[0] as usize] = true;
                border[e[1] as usize] = true;
            }
            crowded_edges += usize::from(count > 2);
        }
        let mut start = vec![0u32; n + 1];
        for (e, _) in &runs {
            start[e[0] as usize + 1] += 1;
            start[e[1] as usize + 1] += 1;
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut neighbour = vec![0u32; 2 * runs.len()];
        // Edges come by rising first vertex, so that each list rises: smaller neighbours first, then larger ones.
        for (e, _) in &runs {
            let f = &mut fill[e[1] as usize];
            neighbour[*f as usize] = e[0];
            *f += 1;
        }
        for (e, _) in &runs {
            let f = &mut fill[e[0] as usize];
            neighbour[*f as usize] = e[1];
            *f += 1;
        }
        let mut area = vec![0.0; n];
        for t in &triangles {
            let third = doubled(&points, t).norm() / 6.0;
            for &c in t {
                area[c as usize] += third;
            }
        }
        Surface {
            points,
            triangles,
            edges: runs.into_iter().map(|r| r.0).collect(),
            border,
            crowded_edges,
            area,
            start,
            neighbour,
        }
    }

    /// Welds a mesh, its flipped facets turned round. An open sheet is looked at from above.
    pub fn of_mesh(mesh: &Mesh, soundness: &Soundness) -> Surface {
        let welded = weld(mesh);
        let (points, mut triangles) = (welded.points(mesh), welded.triangles);
        for &f in &soundness.flipped {
            if let Some(t) = triangles.get_mut(f as usize) {
                t.swap(1, 2);
            }
        }
        let turn = if soundness.closed {
            soundness.inside_out
        } else {
            let up: f64 = triangles.iter().map(|t| doubled(&points, t).z).sum();
            up < 0.0
        };
        if turn {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Surface::new(&points, &triangles)
    }

    /// The ground of a grid as the ball touches it: the contacts of the active nodes, joined as the grid is. `place` gives each active
    /// node's point. Also hands back the node of each vertex.
    pub fn of_grid(
        grid: &ToolCentreGrid,
        active: &[bool],
        place: &dyn Fn(usize) -> Point,
    ) -> (Surface, Vec<u32>) {
        let mut id = vec![u32::MAX; grid.len()];
        let mut triangles = Vec::new();
        let mut nodes: Vec<[u32; 3]> = Vec::new();
        let there = |i: Option<usize>| i.filter(|&i| active[i]);
        for i in (0..grid.len()).filter(|&i| active[i]) {
            // The two triangles whose lowest corner is this node: see LINK.
            for pair in [[LINK[0], LINK[1]], [LINK[1], LINK[2]]] {
                let [a, b] = pair.map(|d| there(grid.neighbour(i, d)));
                if let (Some(a), Some(b)) = (a, b) {
                    nodes.push([i as u32, a as u32, b as u32]);
                    for k in [i, a, b] {
                        id[k] = 0;
                    }
                }
            }
        }
        let mut of = Vec::new();
        let mut points = Vec::new();
        for (k, i) in id.iter_mut().enumerate().filter(|(_, i)| **i == 0) {
            *i = of.len() as u32;
            of.push(k as u32);
            points.push(place(k));
        }
        triangles.extend(nodes.iter().map(|t| t.map(|c| id[c as usize])));
        (Surface::linked(points, triangles), of)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True for a surface without vertices.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Neighbours of a vertex, rising.
    #[inline]
    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        &self.neighbour[self.start[vertex] as usize..self.start[vertex + 1] as usize]
    }

    /// Twice the area of a triangle along its normal, mm2.
    #[inline]
    pub fn doubled_area(&self, triangle: &[u32; 3]) -> Vector {
        doubled(&self.points, triangle)
    }

    /// Vertices - edges + triangles.
    pub fn euler(&self) -> i64 {
        self.points.len() as i64 - self.edges.len() as i64 + self.triangles.len() as i64
    }

    /// Which connected piece each vertex belongs to, numbered by their first vertices, and how many there are.
    pub fn pieces(&self) -> (Vec<u32>, usize) {
        let mut piece = vec![u32::MAX; self.len()];
        let mut count = 0;
        let mut stack = Vec::new();
        for i in 0..self.len() {
            if piece[i] != u32::MAX {
                continue;
            }
            piece[i] = count;
            stack.push(i as u32);
            while let Some(v) = stack.pop() {
                for &u in self.neighbours(v as usize) {
                    if piece[u as usize] == u32::MAX {
                        piece[u as usize] = count;
                        stack.push(u);
                    }
                }
            }
            count += 1;
        }
        (piece, count as usize)
    }

    /// Mean length of the edges, mm; zero without edges.
    pub fn mean_edge(&self) -> f64 {
        let sum: f64 = self
            .edges
            .iter()
            .map(|e| (self.points[e[0] as usize] - self.points[e[1] as usize]).norm())
            .sum();
        sum / self.edges.len().max(1) as f64
    }
}

/// Every edge of some triangles once, rising, with the number of triangles it has.
pub(super) fn edge_runs(triangles: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let mut keys: Vec<u64> = triangles
        .par_iter()
        .flat_map_iter(|t| {
            [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]
                .map(|(a, b)| u64::from(a.min(b)) << 32 | u64::from(a.max(b)))
        })
        .collect();
    keys.par_sort_unstable();
    keys.chunk_by(|a, b| a == b)
        .map(|run| ([(run[0] >> 32) as u32, run[0] as u32], run.len() as u32))
        .collect()
}

#[inline]
fn doubled(points: &[Point], t: &[u32; 3]) -> Vector {
    let [a, b, c] = t.map(|k| points[k as usize]);
    (b - a).cross(&(c - a))
}
