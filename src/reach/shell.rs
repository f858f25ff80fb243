//! The resting heights of a ball over a whole rectangle of places at once: each feature of the part is scattered over the places
//! that it can hold, instead of each place asking the part.
//!
//! ```text
//!   facet    holds the ball over the facet itself, moved by R n.xy
//!   edge     over a strip: the ball's centre lies within the normals that its facets leave free; at a hollow edge there are none
//!   vertex   over a patch: the normals square to or away from all edges that leave it
//! ```
//! On a smooth part those regions tile the plane (each place is held by one facet, edge or vertex), so the cost is a few
//! evaluations a place. A ball that touches a feature outside these normals stands in a neighbouring facet, which therefore holds
//! it higher: leaving them out changes nothing. Corners are joined where their coordinates are equal; an edge without a partner,
//! and any soup of triangles, only costs more.

use super::drop::DropCutter;
use crate::geom::{Point, Vector};
use crate::sweep::Lattice;

/// Heights over a lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// mm; `-inf` where nothing is below.
    pub z: Vec<f64>,
    /// Plan part of the unit vector from the contact up (f32: 1e-7).
    pub normal: Vec<[f32; 2]>,
}

/// Regions are padded by this share of the radius, so that rounding leaves no gap between them: what is evaluated beside its
/// region is wrong by the square of it.
const PAD: f64 = 1e-10;
/// Edges at one vertex, above which its patch is not bounded first.
const MANY: usize = 16;

impl DropCutter {
    /// Heights of the ball's centre over every place of a lattice: as [`DropCutter::drop`] finds them, to 1e-9 mm. Cost: a few
    /// evaluations a place and about a microsecond a triangle; on one thread.
    pub fn drop_all(&self, lattice: &Lattice) -> Heights {
        let mut out = Heights::new(lattice);
        if lattice.is_empty() {
            return out;
        }
        let r = self.radius();
        let triangles = self.triangles_near(lattice, r);
        for t in &triangles {
            out.facet(lattice, t, r);
        }
        let seams = Seams::new(&triangles);
        seams.edges(&triangles, |a, b, lo, hi| {
            out.edge(lattice, a, b, lo, hi, r);
        });
        seams.vertices(|at, leaving| out.vertex(lattice, at, leaving, r));
        out
    }

    /// Heights of the part's surface over every place of a lattice, as [`DropCutter::surface_z`] finds them, and the normals of the
    /// facets there.
    pub fn surface_all(&self, lattice: &Lattice) -> Heights {
        let mut out = Heights::new(lattice);
        if !lattice.is_empty() {
            for t in &self.triangles_near(lattice, 0.0) {
                out.facet(lattice, t, 0.0);
            }
        }
        out
    }

    fn triangles_near(&self, lattice: &Lattice, reach: f64) -> Vec<[Point; 3]> {
        let reach = reach * (1.0 + 1e-9) + 1e-9;
        let (a, b) = (
            lattice.center(0, 0),
            lattice.center(lattice.nx - 1, lattice.ny - 1),
        );
        self.within([a.x - reach, a.y - reach], [b.x + reach, b.y + reach])
    }
}

impl Heights {
    fn new(lattice: &Lattice) -> Heights {
        Heights {
            z: vec![f64::NEG_INFINITY; lattice.len()],
            normal: vec![[0.0; 2]; lattice.len()],
        }
    }

    fn facet(&mut self, lattice: &Lattice, t: &[Point; 3], radius: f64) {
        let mut n = (t[1] - t[0]).cross(&(t[2] - t[0]));
        if n.z < 0.0 {
            n = -n;
        }
        let len = n.norm();
        // Upright or without area: its edges do the work.
        if n.z <= 1e-12 * len || len <= 0.0 {
            return;
        }
        let n = n / len;
        let (sx, sy) = (radius * n.x, radius * n.y);
        let pad = PAD * radius.max(1.0) * n.z;
        let low = t[0].y.min(t[1].y).min(t[2].y);
        let high = t[0].y.max(t[1].y).max(t[2].y);
        let (floor, top) = (
            t[0].z.min(t[1].z).min(t[2].z),
            t[0].z.max(t[1].z).max(t[2].z),
        );
        let (gx, gy, lift) = (n.x / n.z, n.y / n.z, radius * n.z);
        let plan = [n.x as f32, n.y as f32];
        for iy in lattice.rows(low + sy - pad, high + sy + pad) {
            let py = (lattice.y(iy) - sy).clamp(low, high);
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..3 {
                let (mut a, mut b) = (&t[k], &t[(k + 1) % 3]);
                // The same order from either side, so that neighbours cut at the same place.
                if (b.y, b.x) < (a.y, a.x) {
                    (a, b) = (b, a);
                }
                if py < a.y || py > b.y {
                    continue;
                }
                if b.y > a.y {
                    let x = a.x + (b.x - a.x) * ((py - a.y) / (b.y - a.y));
                    lo = lo.min(x);
                    hi = hi.max(x);
                } else {
                    lo = lo.min(a.x);
                    hi = hi.max(b.x);
                }
            }
            let columns = lattice.columns(lo + sx - pad, hi + sx + pad);
            let base = t[0].z - (py - t[0].y) * gy;
            let row = lattice.index(0, iy);
            let cells = row + columns.start..row + columns.end;
            for ((ix, z), normal) in columns
                .zip(&mut self.z[cells.clone()])
                .zip(&mut self.normal[cells])
            {
                let h = (base - (lattice.x(ix) - sx - t[0].x) * gx).clamp(floor, top) + lift;
                if h > *z {
                    *z = h;
                    *normal = plan;
                }
            }
        }
    }

    /// An edge from a to b that holds the ball where the centre is `lo` to `hi` radii to the right of it in plan.
    fn edge(&mut self, lattice: &Lattice, a: &Point, b: &Point, lo: f64, hi: f64, radius: f64) {
        let (ex, ey) = (b.x - a.x, b.y - a.y);
        let len = (ex * ex + ey * ey).sqrt();
        if len <= 0.0 {
            return; // upright or a point: its ends hold the ball
        }
        let (ux, uy) = (ex / len, ey / len);
        let m = (b.z - a.z) / len;
        let slant = (1.0 + m * m).sqrt();
        let up = m / slant;
        let pad = PAD * radius.max(1.0);
        let (lo, hi) = (
            (lo * radius - pad).max(-radius),
            (hi * radius + pad).min(radius),
        );
        if lo > hi {
            return;
        }
        // Where the foot of the centre may fall along the edge.
        let nearest = if lo <= 0.0 && hi >= 0.0 {
            0.0
        } else {
            lo.abs().min(hi.abs())
        };
        let farthest = lo.abs().max(hi.abs());
        let half = |d: f64| (radius * radius - d * d).max(0.0).sqrt() * up;
        let (f0, f1) = (half(nearest), half(farthest));
        let first = -f0.max(f1) - pad;
        let last = len - f0.min(f1) + pad;
        let ys = [(first, lo), (first, hi), (last, lo), (last, hi)]
            .map(|(foot, c)| a.y + foot * uy - c * ux);
        let low = ys.iter().copied().fold(f64::INFINITY, f64::min);
        let high = ys.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let end = pad / slant;
        for iy in lattice.rows(low - pad, high + pad) {
            let dy = lattice.y(iy) - a.y;
            let (mut x0, mut x1) = (f64::NEG_INFINITY, f64::INFINITY);
            for (per_x, at, from, to) in [(ux, dy * uy, first, last), (uy, -dy * ux, lo, hi)] {
                if per_x.abs() > 1e-9 {
                    let (p, q) = ((from - at) / per_x, (to - at) / per_x);
                    x0 = x0.max(p.min(q));
                    x1 = x1.min(p.max(q));
                }
            }
            let slack = 1e-9 * radius.max(1.0);
            let columns = lattice.columns(a.x + x0 - slack, a.x + x1 + slack);
            for ix in columns {
                let dx = lattice.x(ix) - a.x;
                let across = dx * uy - dy * ux;
                let depth_sq = radius * radius - across * across;
                if across < lo || across > hi || depth_sq < 0.0 {
                    continue;
                }
                let foot = dx * ux + dy * uy;
                let depth = depth_sq.sqrt();
                let s = foot + depth * up;
                if s < -end || s > len + end {
                    continue;
                }
                let z = a.z + m * foot + depth * slant;
                let i = lattice.index(ix, iy);
                if z > self.z[i] {
                    self.z[i] = z;
                    self.normal[i] = [
                        ((dx - s * ux) / radius) as f32,
                        ((dy - s * uy) / radius) as f32,
                    ];
                }
            }
        }
    }

    /// A vertex with the unit vectors along the edges that leave it.
    fn vertex(&mut self, lattice: &Lattice, at: &Point, leaving: &[Vector], radius: f64) {
        if lattice.columns(at.x - radius, at.x + radius).is_empty()
            || lattice.rows(at.y - radius, at.y + radius).is_empty()
        {
            return;
        }
        let Some((mid, chord)) = cap(leaving) else {
            return;
        };
        let pad = 1e-9 * radius.max(1.0);
        let reach = radius * chord + pad;
        let (cx, cy) = (at.x + radius * mid.x, at.y + radius * mid.y);
        let limit = PAD * 10.0 * radius;
        let columns = lattice.columns(cx - reach, cx + reach);
        for iy in lattice.rows(cy - reach, cy + reach) {
            let dy = lattice.y(iy) - at.y;
            for ix in columns.clone() {
                let dx = lattice.x(ix) - at.x;
                let depth_sq = radius * radius - dx * dx - dy * dy;
                if depth_sq < 0.0 {
                    continue;
                }
                let depth = depth_sq.sqrt();
                let z = at.z + depth;
                let i = lattice.index(ix, iy);
                if z > self.z[i]
                    && leaving
                        .iter()
                        .all(|e| e.x * dx + e.y * dy + e.z * depth <= limit)
                {
                    self.z[i] = z;
                    self.normal[i] = [(dx / radius) as f32, (dy / radius) as f32];
                }
            }
        }
    }
}

/// A cap of directions that holds all upward ones square to or away from these edges: its middle and how far from
/// it in plan its rim may be, both for a unit sphere. `None`: there is no such direction.
fn cap(leaving: &[Vector]) -> Option<(Vector, f64)> {
    let all = Some((Vector::zeros(), 1.0));
    let k = leaving.len();
    if k > MANY {
        return all;
    }
    let horizon = Vector::new(0.0, 0.0, -1.0);
    let wall = |i: usize| if i < k { &leaving[i] } else { &horizon };
    // The cone's extreme rays lie in two of its walls.
    let mut rays = [Vector::zeros(); MANY * (MANY + 1)];
    let mut n = 0;
    for i in 0..=k {
        for j in i + 1..=k {
            let ray = wall(i).cross(wall(j));
            let len = ray.norm();
            if len < 1e-9 {
                // Two walls in one plane bound nothing sharply.
                continue;
            }
            for ray in [ray / len, -ray / len] {
                if (0..=k).all(|w| wall(w).dot(&ray) <= 1e-9) && n < rays.len() {
                    rays[n] = ray;
                    n += 1;
                }
            }
        }
    }
    if n == 0 {
        return None;
    }
    let sum: Vector = rays[..n].iter().sum();
    let len = sum.norm();
    if len < 0.3 * n as f64 {
        return all;
    }
    let mid = sum / len;
    let cosine = rays[..n].iter().map(|r| r.dot(&mid)).fold(1.0, f64::min);
    if cosine < 0.2 {
        return all;
    }
    // No two points of a cap's half are farther apart than this chord, in plan neither.
    Some((mid, (2.0 - 2.0 * cosine).max(0.0).sqrt() + 1e-9))
}

/// How triangles hang together: corners with equal coordinates are one vertex.
struct Seams {
    /// Place of each vertex.
    at: Vec<Point>,
    /// (vertex, vertex, triangle), the lower vertex first, sorted.
    sides: Vec<(u32, u32, u32)>,
}

impl Seams {
    fn new(triangles: &[[Point; 3]]) -> Seams {
        // Adding zero makes one of both zeros.
        let key = |p: &Point| [p.x + 0.0, p.y + 0.0, p.z + 0.0];
        let mut corners: Vec<([f64; 3], u32)> = triangles
            .iter()
            .flatten()
            .zip(0u32..)
            .map(|(p, i)| (key(p), i))
            .collect();
        corners.sort_unstable_by(|a, b| {
            a.0[0]
                .total_cmp(&b.0[0])
                .then(a.0[1].total_cmp(&b.0[1]))
                .then(a.0[2].total_cmp(&b.0[2]))
        });
        let mut vertex = vec![0u32; corners.len()];
        let mut at: Vec<Point> = Vec::new();
        let mut last: Option<[f64; 3]> = None;
        for (k, i) in &corners {
            if last != Some(*k) {
                at.push(Point::new(k[0], k[1], k[2]));
                last = Some(*k);
            }
            vertex[*i as usize] = at.len() as u32 - 1;
        }
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, v) in vertex.chunks_exact(3).enumerate() {
            for k in 0..3 {
                let (a, b) = (v[k], v[(k + 1) % 3]);
                if a != b {
                    sides.push((a.min(b), a.max(b), t as u32));
                }
            }
        }
        sides.sort_unstable();
        Seams { at, sides }
    }

    /// Visits every edge that can hold a ball: its ends, and how many radii to its right in plan the centre may be.
    fn edges(&self, triangles: &[[Point; 3]], mut visit: impl FnMut(&Point, &Point, f64, f64)) {
        for group in self.sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (a, b) = (&self.at[group[0].0 as usize], &self.at[group[0].1 as usize]);
            let e = b - a;
            let plan = e.xy().norm();
            if plan <= 0.0 {
                continue;
            }
            let long = e.norm();
            let along = e / long;
            let right = Vector::new(e.y / plan, -e.x / plan, 0.0);
            // Upright in the plane square to the edge.
            let up = right.cross(&along);
            let up = if up.z < 0.0 { -up } else { up };
            let (mut lo, mut hi) = (-1.0f64, 1.0f64);
            for side in group {
                // Into the facet, square to the edge: no normal of the edge may lean that way.
                let t = &triangles[side.2 as usize];
                let inward = t
                    .iter()
                    .map(|p| {
                        let v = p - a;
                        v - along * v.dot(&along)
                    })
                    .max_by(|p, q| p.norm_squared().total_cmp(&q.norm_squared()));
                let Some(inward) = inward else { continue };
                let width = inward.norm();
                let n = (t[1] - t[0]).cross(&(t[2] - t[0]));
                if width <= 1e-12 * long || n.norm_squared() <= 0.0 {
                    continue;
                }
                let (right, up) = (inward.dot(&right) / width, inward.dot(&up) / width);
                if right > 0.0 {
                    hi = hi.min(-up);
                } else if right < 0.0 {
                    lo = lo.max(up);
                } else if up > 0.0 {
                    (lo, hi) = (1.0, -1.0);
                }
            }
            // Nearly nothing is nothing: the facets on both sides are padded by as much.
            if hi >= lo {
                visit(a, b, lo, hi);
            }
        }
    }

    /// Visits every vertex with the unit vectors along its edges.
    fn vertices(&self, mut visit: impl FnMut(&Point, &[Vector])) {
        let mut first = vec![0u32; self.at.len() + 1];
        let pairs = || {
            self.sides
                .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
                .map(|g| (g[0].0, g[0].1))
        };
        for (a, b) in pairs() {
            first[a as usize + 1] += 1;
            first[b as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut other = vec![0u32; first.last().map_or(0, |n| *n as usize)];
        for (a, b) in pairs() {
            for (a, b) in [(a, b), (b, a)] {
                let k = &mut next[a as usize];
                other[*k as usize] = b;
                *k += 1;
            }
        }
        let mut leaving: Vec<Vector> = Vec::new();
        for (v, at) in self.at.iter().enumerate() {
            leaving.clear();
            leaving.extend(
                other[first[v] as usize..first[v + 1] as usize]
                    .iter()
                    .map(|&o| {
                        let e = self.at[o as usize] - at;
                        e / e.norm()
                    }),
            );
            visit(at, &leaving);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point2;
    use crate::part::Mesh;
    use proptest::prelude::*;

    fn compare(mesh: &Mesh, radius: f64, step: f64, shift: f64) {
        let cutter = DropCutter::new(mesh, radius);
        let needle = DropCutter::new(mesh, 1e-9);
        let b = cutter.bounds();
        let room = radius + step;
        let lattice = Lattice::covering(
            Point2::new(b.min.x - room + shift, b.min.y - room),
            Point2::new(b.max.x + room + shift, b.max.y + room),
            step,
        );
        let (balls, surface) = (cutter.drop_all(&lattice), cutter.surface_all(&lattice));
        for i in 0..lattice.len() {
            let q = lattice.center_at(i);
            match cutter.drop(q.x, q.y) {
                Some(c) => {
                    let error = balls.z[i] - c.center.z;
                    // Where only the ball's rim touches, rounding of the plan distance counts by its root.
                    let rim = (c.center.z - c.point.z).abs() < 1e-4;
                    assert!(error.abs() < 1e-9 || rim, "{q}: {error:e} {c:?}");
                }
                None => assert_eq!(balls.z[i], f64::NEG_INFINITY, "{q}"),
            }
            // On an outline, within rounding, a place is over the triangle or not.
            let want = cutter.surface_z(q.x, q.y).unwrap_or(f64::NEG_INFINITY);
            let near = needle
                .drop(q.x, q.y)
                .is_some_and(|c| (c.point.z - surface.z[i]).abs() < 1e-6);
            let same = surface.z[i] == want || (surface.z[i] - want).abs() < 1e-9;
            assert!(same || near, "{q}: {} {want}", surface.z[i]);
        }
    }

    fn grid_mesh(n: usize, size: f64, z: impl Fn(usize, usize) -> f64) -> Mesh {
        let at = |i: usize, j: usize| {
            Point::new(
                size * i as f64 / n as f64,
                size * j as f64 / n as f64,
                z(i, j),
            )
        };
        let mut mesh = Mesh::default();
        for j in 0..n {
            for i in 0..n {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                mesh.triangles.push([a, b, c]);
                mesh.triangles.push([a, c, d]);
            }
        }
        mesh
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

        /// Loose triangles in any position.
        #[test]
        fn equals_the_drop_cutter_on_soups(v in prop::collection::vec((0.0..8.0f64, 0.0..8.0f64, 0.0..4.0f64, -3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64), 1..40), r in 0.3..2.5f64) {
            let mut mesh = Mesh::default();
            for (x, y, z, a, b, c, d) in v {
                mesh.triangles.push([Point::new(x, y, z), Point::new(x + a, y + b, z + c), Point::new(x + c, y + d, z + a)]);
            }
            compare(&mesh, r, 0.173, 0.0);
        }

        /// Triangles that share corners and edges: smooth, rough, and terraces with upright walls; nodes on edges and corners too.
        #[test]
        fn equals_the_drop_cutter_on_meshes(h in prop::collection::vec(0.0..1.0f64, 81), scale in 0.0..6.0f64, terraces in any::<bool>(), r in 0.3..2.5f64, shift in prop::sample::select(vec![0.0, 0.013])) {
            let z = |i: usize, j: usize| {
                let v = h[j * 9 + i] * scale;
                if terraces { v.floor() } else { v }
            };
            compare(&grid_mesh(8, 6.0, z), r, 0.125, shift);
        }
    }

    /// A closed box with upright walls, a needle, slivers, a fan of many edges, triangles of no area.
    #[test]
    fn equals_the_drop_cutter_on_awkward_parts() {
        let p = Point::new;
        let quad = |a, b, c, d| vec![[a, b, c], [a, c, d]];
        let mut mesh = Mesh::default();
        let (l, h) = (
            [
                p(0.0, 0.0, 0.0),
                p(4.0, 0.0, 0.0),
                p(4.0, 4.0, 0.0),
                p(0.0, 4.0, 0.0),
            ],
            [
                p(0.0, 0.0, 3.0),
                p(4.0, 0.0, 3.0),
                p(4.0, 4.0, 3.0),
                p(0.0, 4.0, 3.0),
            ],
        );
        mesh.triangles.extend(quad(l[0], l[1], l[2], l[3]));
        mesh.triangles.extend(quad(h[0], h[1], h[2], h[3]));
        for k in 0..4 {
            let n = (k + 1) % 4;
            mesh.triangles.extend(quad(l[k], l[n], h[n], h[k]));
        }
        let top = p(8.0, 2.0, 5.0);
        let rim = |k: usize| {
            let a = k as f64 * 0.25;
            p(
                8.0 + 2.0 * a.cos(),
                2.0 + 2.0 * a.sin(),
                0.1 * (k % 3) as f64,
            )
        };
        for k in 0..25 {
            mesh.triangles.push([top, rim(k), rim(k + 1)]);
        }
        mesh.triangles
            .push([p(2.0, 2.0, 3.0), p(2.0, 2.0, 9.0), p(2.001, 2.0, 3.0)]);
        mesh.triangles
            .push([p(-3.0, 1.0, 1.0), p(9.0, 1.0, 2.0), p(9.0, 1.0 + 1e-7, 2.0)]);
        mesh.triangles
            .push([p(1.0, 6.0, 1.0), p(1.0, 6.0, 1.0), p(3.0, 6.0, 2.0)]);
        mesh.triangles
            .push([p(1.0, 7.0, 1.0), p(2.0, 7.0, 1.5), p(3.0, 7.0, 2.0)]);
        for r in [0.4, 1.5, 3.0] {
            compare(&mesh, r, 0.1, 0.0);
            compare(&mesh, r, 0.1, 0.037);
        }
    }

    #[test]
    fn nothing_over_nothing() {
        let cutter = DropCutter::new(&Mesh::default(), 1.0);
        let lattice = Lattice::covering(Point2::new(0.0, 0.0), Point2::new(1.0, 1.0), 0.1);
        assert!(
            cutter
                .drop_all(&lattice)
                .z
                .iter()
                .all(|z| *z == f64::NEG_INFINITY)
        );
    }
}
