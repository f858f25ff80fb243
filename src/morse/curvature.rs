//! Mean curvature H = (k1 + k2) / 2, positive where the part bulges out, averaged over about a stepover so that facets do not speak.
//!
//! On the *grid* the ball tells the outward normal n at each contact p; over a small disc of nodes the normals are a linear function
//! of the contacts, and half its trace is H (half the divergence of n):
//!
//! ```text
//!   n - n_mean = S (p - p_mean)   by least squares in the tangent plane      H = trace S / 2
//! ```
//!
//! On a *mesh* the gradient of the area with respect to a vertex is the integral of 2 H n about it. Summed triangle by triangle it is
//! half the opposite side turned by a right angle, the cotangent formula without its cotangents, so skinny triangles do no harm
//! (M. Meyer, M. Desbrun, P. Schroeder, A. H. Barr, *Discrete differential-geometry operators for triangulated 2-manifolds*, 2003).
//! Those integrals are added up over the vertices within a radius and divided by their area. Border vertices have no full ring and take
//! the mean of what is near.

use super::surface::Surface;
use crate::geom::{Point, Vector};
use crate::reach::{NodeKind, ToolCentreGrid};
use nalgebra::{Matrix2, Matrix3};
use rayon::prelude::*;

/// Share of the window's own size below which the spread of contacts is not believed: over a sharp edge the ball turns on the spot,
/// and the curvature is that of the window rather than infinite.
const RIDGE: f64 = 1e-3;

/// Mean curvature of the part about a place of the grid, 1/mm: normals against contacts over the ground nodes within `radius` mm (in
/// plan). Zero where fewer than three nodes are near.
pub fn at_place(grid: &ToolCentreGrid, x: f64, y: f64, radius: f64) -> f64 {
    let (h, share) = in_window(grid, x, y, radius);
    if share < 0.95 {
        // Beside a border part of the window is missing: as much again is taken from farther inside.
        return in_window(
            grid,
            x,
            y,
            radius * (1.0 / share.max(1e-9)).sqrt().min(WIDER),
        )
        .0;
    }
    h
}

/// The same for exactly that radius, and how much of the window is ground, 0 to 1.
fn in_window(grid: &ToolCentreGrid, x: f64, y: f64, radius: f64) -> (f64, f64) {
    let Some(near) = grid.nearest(x, y) else {
        return (0.0, 1.0);
    };
    let at = grid.xy(near);
    let reach = (radius / grid.step).ceil() as i32 + 1;
    let mut sums: Vec<(f64, Vector, Vector)> = Vec::with_capacity(128);
    let mut whole = 0.0;
    let (mut weight, mut p_mean, mut n_mean) = (0.0, Vector::zeros(), Vector::zeros());
    let mut base: Option<Point> = None;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let (u, v) = (
                at.x + dx as f64 * grid.step - x,
                at.y + dy as f64 * grid.step - y,
            );
            let w = 1.0 - (u * u + v * v) / (radius * radius);
            if w <= 0.0 {
                continue;
            }
            whole += w;
            let Some(j) = grid
                .neighbour(near, (dx, dy))
                .filter(|&j| grid.kind[j] == NodeKind::Ground)
            else {
                continue;
            };
            let p = grid.point[j] - *base.get_or_insert(grid.point[j]);
            let n = (grid.center(j) - grid.point[j]) / grid.radius;
            weight += w;
            p_mean += p * w;
            n_mean += n * w;
            sums.push((w, p, n));
        }
    }
    let share = weight / whole;
    if sums.len() < 3 {
        return (0.0, share);
    }
    p_mean /= weight;
    n_mean /= weight;
    let (mut pp, mut np) = (Matrix3::zeros(), Matrix3::zeros());
    for (w, p, n) in &sums {
        let (p, n) = (p - p_mean, n - n_mean);
        pp += p * p.transpose() * *w;
        np += n * p.transpose() * *w;
    }
    let Some(up) = n_mean.try_normalize(1e-9) else {
        return (0.0, share);
    };
    // Two directions across the mean normal.
    let any = if up.x.abs() < 0.6 {
        Vector::x()
    } else {
        Vector::y()
    };
    let e1 = up.cross(&any).normalize();
    let e2 = up.cross(&e1);
    let across = |m: &Matrix3<f64>| {
        Matrix2::new(
            e1.dot(&(m * e1)),
            e1.dot(&(m * e2)),
            e2.dot(&(m * e1)),
            e2.dot(&(m * e2)),
        )
    };
    let ridge = RIDGE * weight * radius * radius;
    let spread = across(&pp) + Matrix2::identity() * ridge;
    let h = spread
        .try_inverse()
        .map_or(0.0, |inverse| 0.5 * (across(&np) * inverse).trace());
    (h, share)
}

/// Vertices looked at about one, at most: where a mesh is far finer than the radius its nearest rings are enough.
const MOST: usize = 400;
/// How much wider a window may get beside a border.
const WIDER: f64 = 2.0;
/// One vertex, or node, in so many is asked twice for the roughness.
const ONE_IN: usize = 16;

/// What a mesh bends by, added up vertex by vertex.
struct Bends<'a> {
    surface: &'a Surface,
    /// Integral of H about each vertex, mm.
    bent: Vec<f64>,
}

impl Bends<'_> {
    fn new(surface: &Surface) -> Bends<'_> {
        let n = surface.len();
        // Area gradient: half the opposite side, turned in the triangle's plane.
        let mut gradient = vec![Vector::zeros(); n];
        let mut normal = vec![Vector::zeros(); n];
        for t in &surface.triangles {
            let d = surface.doubled_area(t);
            let Some(unit) = d.try_normalize(0.0).filter(|u| u.x.is_finite()) else {
                continue;
            };
            for k in 0..3 {
                let (a, b) = (t[(k + 1) % 3] as usize, t[(k + 2) % 3] as usize);
                let v = t[k] as usize;
                gradient[v] += 0.5 * unit.cross(&(surface.points[b] - surface.points[a]));
                normal[v] += d;
            }
        }
        let bent = gradient
            .iter()
            .zip(&normal)
            .map(|(g, n)| n.try_normalize(0.0).map_or(0.0, |n| 0.5 * g.dot(&n)))
            .map(|h| if h.is_finite() { h } else { 0.0 })
            .collect();
        Bends { surface, bent }
    }

    /// The mean within a radius, each vertex counting less the farther it is; `None` where only border is near. `seen` is all false, and
    /// is so again afterwards.
    fn about(
        &self,
        v: usize,
        radius: f64,
        most: usize,
        found: &mut Vec<u32>,
        seen: &mut [bool],
    ) -> Option<f64> {
        let (bend, area, border) = self.sums(v, radius, most, found, seen);
        // Beside a border half of the window is missing: as much again is taken from farther inside.
        let whole = 0.5 * std::f64::consts::PI * radius * radius;
        if border && area < whole {
            let wider = radius * (whole / area.max(1e-300)).sqrt().min(WIDER);
            let (bend, area, _) = self.sums(v, wider, most, found, seen);
            return (area > 0.0).then(|| bend / area);
        }
        (area > 0.0).then(|| bend / area)
    }

    /// Weighted integral of H, weighted area, and whether a border is near.
    fn sums(
        &self,
        v: usize,
        radius: f64,
        most: usize,
        found: &mut Vec<u32>,
        seen: &mut [bool],
    ) -> (f64, f64, bool) {
        let s = self.surface;
        let mut border = false;
        found.clear();
        found.push(v as u32);
        seen[v] = true;
        let (mut bend, mut area) = (0.0, 0.0);
        let (mut next, mut asked) = (0, 0);
        while let Some(&u) = found.get(next) {
            next += 1;
            let u = u as usize;
            let away = |x: usize| (s.points[x] - s.points[v]).norm_squared() / (radius * radius);
            border |= s.border[u];
            if !s.border[u] {
                let w = (1.0 - away(u)).max(if u == v { 1.0 } else { 0.0 });
                bend += w * self.bent[u];
                area += w * s.area[u];
            }
            for &x in s.neighbours(u) {
                // A spine that thousands of triangles share must not be walked along for each of them.
                asked += 1;
                if found.len() >= most || asked > 16 * most {
                    break;
                }
                if !seen[x as usize] && away(x as usize) < 1.0 {
                    seen[x as usize] = true;
                    found.push(x);
                }
            }
        }
        for &u in found.iter() {
            seen[u as usize] = false;
        }
        (bend, area, border)
    }

    /// The same at every `step`-th vertex, on all cores.
    fn at_each(&self, step: usize, radius: f64, most: usize) -> Vec<Option<f64>> {
        let n = self.surface.len();
        (0..n.div_ceil(step))
            .into_par_iter()
            .with_min_len(4096 / step)
            .map_init(
                || (Vec::new(), vec![false; n]),
                |(found, seen), k| self.about(k * step, radius, most, found, seen),
            )
            .collect()
    }
}

/// Mean curvature at each vertex of a mesh, 1/mm, averaged over `radius` mm along the mesh (or the nearest few hundred vertices).
/// Zero on pieces that are all border.
pub fn of_surface(surface: &Surface, radius: f64) -> Vec<f64> {
    let known = Bends::new(surface).at_each(1, radius, MOST);
    spread_to_border(surface, known)
}

/// How rough that is, 1/mm, as a standard deviation: what it differs by from the mean over twice the radius, by the median.
pub fn roughness_of_surface(surface: &Surface, radius: f64) -> f64 {
    let bends = Bends::new(surface);
    let fine = bends.at_each(ONE_IN, radius, MOST);
    let wide = bends.at_each(ONE_IN, 2.0 * radius, 4 * MOST);
    spread(
        fine.into_iter()
            .zip(wide)
            .filter_map(|(a, b)| Some(a? - b?)),
    )
}

/// The same on a grid.
pub fn roughness_of_grid(grid: &ToolCentreGrid, value: &[f64], radius: f64) -> f64 {
    let off: Vec<f64> = (0..grid.len())
        .into_par_iter()
        .filter(|&i| grid.kind[i] == NodeKind::Ground && i % (ONE_IN + 1) == 0)
        .map(|i| {
            let q = grid.xy(i);
            value[i] - at_place(grid, q.x, q.y, 2.0 * radius)
        })
        .collect();
    spread(off.into_iter())
}

/// Standard deviation by the median of the size; zero of nothing.
fn spread(off: impl Iterator<Item = f64>) -> f64 {
    let mut size: Vec<f64> = off.map(f64::abs).collect();
    size.sort_unstable_by(f64::total_cmp);
    size.get(size.len() / 2).map_or(0.0, |m| m / 0.6745)
}

/// Ring by ring, the mean of the neighbours that have a value.
fn spread_to_border(surface: &Surface, mut known: Vec<Option<f64>>) -> Vec<f64> {
    loop {
        let more: Vec<(usize, f64)> = (0..known.len())
            .filter(|&v| known[v].is_none())
            .filter_map(|v| {
                let (mut sum, mut count) = (0.0, 0.0);
                for &u in surface.neighbours(v) {
                    if let Some(h) = known[u as usize] {
                        sum += h;
                        count += 1.0;
                    }
                }
                (count > 0.0).then(|| (v, sum / count))
            })
            .collect();
        if more.is_empty() {
            return known.into_iter().map(|h| h.unwrap_or(0.0)).collect();
        }
        for (v, h) in more {
            known[v] = Some(h);
        }
    }
}
