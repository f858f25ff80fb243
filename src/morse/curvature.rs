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
    let Some(near) = grid.nearest(x, y) else {
        return 0.0;
    };
    let reach = (radius / grid.step).ceil() as i32;
    let mut sums: Vec<(f64, Vector, Vector)> = Vec::with_capacity(128);
    let (mut weight, mut p_mean, mut n_mean) = (0.0, Vector::zeros(), Vector::zeros());
    let mut base: Option<Point> = None;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let Some(j) = grid
                .neighbour(near, (dx, dy))
                .filter(|&j| grid.kind[j] == NodeKind::Ground)
            else {
                continue;
            };
            let q = grid.xy(j);
            let d2 = ((q.x - x).powi(2) + (q.y - y).powi(2)) / (radius * radius);
            if d2 >= 1.0 {
                continue;
            }
            let w = 1.0 - d2;
            let p = grid.point[j] - *base.get_or_insert(grid.point[j]);
            let n = (grid.center(j) - grid.point[j]) / grid.radius;
            weight += w;
            p_mean += p * w;
            n_mean += n * w;
            sums.push((w, p, n));
        }
    }
    if sums.len() < 3 {
        return 0.0;
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
        return 0.0;
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
    spread
        .try_inverse()
        .map_or(0.0, |inverse| 0.5 * (across(&np) * inverse).trace())
}

/// Vertices looked at about one, at most: where a mesh is far finer than the radius its nearest rings are enough.
const MOST: usize = 400;

/// Mean curvature at each vertex of a mesh, 1/mm, averaged over `radius` mm along the mesh. Zero on pieces that are all border.
pub fn of_surface(surface: &Surface, radius: f64) -> Vec<f64> {
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
    let bent: Vec<f64> = gradient
        .iter()
        .zip(&normal)
        .map(|(g, n)| n.try_normalize(0.0).map_or(0.0, |n| 0.5 * g.dot(&n)))
        .map(|h| if h.is_finite() { h } else { 0.0 })
        .collect();
    let full = |v: usize| !surface.border[v];
    // (sum of integrals, sum of areas) within the radius; no area where only border is near.
    let sums: Vec<(f64, f64)> = (0..n)
        .into_par_iter()
        .with_min_len(4096)
        .map_init(
            || (Vec::<u32>::new(), Vec::<bool>::new()),
            |(found, seen), v| {
                if seen.is_empty() {
                    seen.resize(n, false);
                }
                found.clear();
                found.push(v as u32);
                seen[v] = true;
                let (mut bend, mut area) = (0.0, 0.0);
                let mut next = 0;
                while let Some(&u) = found.get(next) {
                    next += 1;
                    let u = u as usize;
                    let d2 =
                        (surface.points[u] - surface.points[v]).norm_squared() / (radius * radius);
                    if full(u) {
                        let w = (1.0 - d2).max(if u == v { 1.0 } else { 0.0 });
                        bend += w * bent[u];
                        area += w * surface.area[u];
                    }
                    for &x in surface.neighbours(u) {
                        let near = (surface.points[x as usize] - surface.points[v]).norm_squared()
                            < radius * radius;
                        if near && !seen[x as usize] && found.len() < MOST {
                            seen[x as usize] = true;
                            found.push(x);
                        }
                    }
                }
                for &u in found.iter() {
                    seen[u as usize] = false;
                }
                (bend, area)
            },
        )
        .collect();
    let known: Vec<Option<f64>> = sums
        .iter()
        .map(|&(bend, area)| (area > 0.0).then(|| bend / area))
        .collect();
    spread_to_border(surface, known)
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
