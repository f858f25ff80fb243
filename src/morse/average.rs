//! Average geodesic distance: from each point of a surface the mean of the distances to all of it.
//!
//! (M. Hilaga, Y. Shinagawa, T. Kohmura, T. L. Kunii, *Topology matching for fully automatic similarity estimation of 3D shapes*,
//! SIGGRAPH 2001: the integral of the distance over the surface; here divided by the area, so that it is a length.)
//!
//! ```text
//!   mu(x) = (1/A) * integral of d(x, y) dy  =  sum over cells of (A_i / A) * g(d(x, s_i), r_i)
//! ```
//!
//! Cells are the ground nearest to some evenly spread points s_i (farthest-point sampling, then moved to their cells' middles
//! a dozen times: off the middle the sum errs in the first order, and crowds of points on the border made it 2 percent).
//! The mean distance to a *disc* of the cell's area, `g`, stands for that to the cell: a sum of plain distances would have a dent at
//! each s_i. Each connected piece has its own mean. Distances are marched over an even resampling ([`super::resample`]), so neither
//! skinny triangles nor a million of them matter. Deterministic. Cost: about `samples * seeds` microseconds of one core, and n log n
//! for the resampling.

use super::geodesic::Net;
use super::resample::sampled;
use super::surface::Surface;
use crate::geom::{Point, Vector};
use rayon::prelude::*;

/// How finely to integrate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AverageOptions {
    /// Points that stand for the surface in the integral.
    pub samples: usize,
    /// Vertices that distances are marched over.
    pub seeds: usize,
}

impl Default for AverageOptions {
    /// Good to about one percent.
    fn default() -> Self {
        AverageOptions {
            samples: 64,
            seeds: 8000,
        }
    }
}

/// Seeds that all pieces together may have, and that a small piece has at least if there are not too many of them.
const SMALL: [usize; 2] = [100_000, 200];

/// The average geodesic distance at each vertex, mm. Zero on a piece without area.
pub fn average_distance(surface: &Surface, options: &AverageOptions) -> Vec<f64> {
    let (piece, count) = surface.pieces();
    // Vertices and triangles by piece.
    let mut local = vec![0u32; surface.len()];
    let mut vertices: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (v, &p) in piece.iter().enumerate() {
        local[v] = vertices[p as usize].len() as u32;
        vertices[p as usize].push(v as u32);
    }
    let mut triangles: Vec<Vec<[u32; 3]>> = vec![Vec::new(); count];
    for t in &surface.triangles {
        triangles[piece[t[0] as usize] as usize].push(t.map(|v| local[v as usize]));
    }
    let total: f64 = surface.area.iter().sum();
    let least = SMALL[1].min(SMALL[0] / count.max(1)).max(4);
    let values: Vec<Vec<f64>> = (0..count)
        .into_par_iter()
        .map(|p| {
            let points: Vec<Point> = vertices[p]
                .iter()
                .map(|&v| surface.points[v as usize])
                .collect();
            let area: f64 = vertices[p].iter().map(|&v| surface.area[v as usize]).sum();
            if !(area > 1e-12 * total && area > 0.0) {
                return vec![0.0; points.len()];
            }
            let seeds = ((options.seeds as f64 * area / total) as usize).max(least);
            of_piece(&points, &triangles[p], area, seeds, options.samples)
        })
        .collect();
    let mut out = vec![0.0; surface.len()];
    for (list, values) in vertices.iter().zip(values) {
        for (&v, x) in list.iter().zip(values) {
            out[v as usize] = x;
        }
    }
    out
}

fn of_piece(
    points: &[Point],
    triangles: &[[u32; 3]],
    area: f64,
    seeds: usize,
    samples: usize,
) -> Vec<f64> {
    let even = sampled(points, triangles, area, seeds);
    let spots = spots(&even.net, &even.area, samples);
    let (away, cell) = even.net.distances(&spots, f64::INFINITY);
    let mut own = vec![0.0; spots.len()];
    let mut sum = own.clone();
    for (k, &c) in cell.iter().enumerate() {
        if let Some(o) = own.get_mut(c as usize) {
            *o += even.area[k];
            sum[c as usize] += even.area[k] * away[k].hypot(even.inner[k]);
        }
    }
    let parts: Vec<Vec<f64>> = spots
        .par_iter()
        .zip(own.par_iter().zip(&sum))
        .map(|(&s, (&a, sum))| {
            // Of all flat shapes a disc is nearest to its middle: a cell that is nearer still is folded, and counts as what it is.
            let folded = if a > 0.0 { 1.5 * sum / a } else { 0.0 };
            let r = (a / std::f64::consts::PI).sqrt().min(folded);
            let (d, _) = even.net.distances(&[s], f64::INFINITY);
            d.into_iter()
                .map(|d| {
                    if d.is_finite() {
                        a * to_disc(d, r)
                    } else {
                        0.0
                    }
                })
                .collect()
        })
        .collect();
    let whole: f64 = own.iter().sum();
    let mut mean = vec![0.0; even.area.len()];
    for part in &parts {
        for (m, v) in mean.iter_mut().zip(part) {
            *m += v / whole;
        }
    }
    even.spread(&mean, points, &even.seed_of[..points.len()])
}

/// Mean distance of a point to the points of a flat disc of radius `r`, from `d` away from its middle.
///
/// It is `2/3 r F(-1/2, -3/2; 1; (d/r)^2)` inside and `d F(-1/2, -1/2; 2; (r/d)^2)` outside, F being Gauss's series; four terms of each
/// meet at the rim within a thousandth.
pub fn to_disc(d: f64, r: f64) -> f64 {
    if d <= r {
        if r <= 0.0 {
            return d;
        }
        let q = (d / r).powi(2);
        r * (2.0 / 3.0 + q * (0.5 - q * (1.0 / 32.0 + q / 384.0)))
    } else {
        let q = (r / d).powi(2);
        d * (1.0 + q * (0.125 + q * (1.0 / 192.0 + q / 1024.0)))
    }
}

/// How often spots are moved to the middles of their cells (S. P. Lloyd, *Least squares quantization in PCM*, 1982).
const SETTLE: usize = 12;

/// Evenly spread vertices: the farthest from all before, each time, then again and again the vertex nearest to the middle of each one's
/// ground.
fn spots(net: &Net, area: &[f64], wanted: usize) -> Vec<u32> {
    let n = net.points.len();
    let mut away = vec![f64::INFINITY; n];
    let mut spots: Vec<u32> = Vec::new();
    let mut next = 0usize;
    while spots.len() < wanted.min(n) {
        let limit = away[next];
        if limit <= 0.0 {
            break;
        }
        spots.push(next as u32);
        let (d, _) = net.distances(&[next as u32], limit);
        for (a, d) in away.iter_mut().zip(d) {
            *a = a.min(d);
        }
        next = (0..n).fold(0, |best, k| if away[k] > away[best] { k } else { best });
    }
    for _ in 0..SETTLE {
        let (_, cell) = net.distances(&spots, f64::INFINITY);
        let mut middle = vec![(Vector::zeros(), 0.0); spots.len()];
        for (k, &c) in cell.iter().enumerate() {
            if let Some(m) = middle.get_mut(c as usize) {
                m.0 += net.points[k].coords * area[k];
                m.1 += area[k];
            }
        }
        let mut best = vec![(f64::INFINITY, 0u32); spots.len()];
        for (k, &c) in cell.iter().enumerate() {
            if let Some(b) = best.get_mut(c as usize) {
                let (sum, weight) = middle[c as usize];
                let d = (net.points[k].coords * weight - sum).norm_squared();
                if d < b.0 {
                    *b = (d, k as u32);
                }
            }
        }
        for (s, b) in spots.iter_mut().zip(best) {
            if b.0 < f64::INFINITY {
                *s = b.1;
            }
        }
    }
    spots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_distance_to_a_disc_is_that_of_its_points() {
        for d in [0.0, 0.3, 0.7, 1.0, 1.4, 3.0] {
            // Rings of equal area, points round each.
            let (rings, round) = (400, 400);
            let mut sum = 0.0;
            for i in 0..rings {
                let r = ((i as f64 + 0.5) / rings as f64).sqrt();
                for j in 0..round {
                    let (s, c) =
                        ((j as f64 + 0.5) / round as f64 * std::f64::consts::TAU).sin_cos();
                    sum += (d - r * c).hypot(r * s);
                }
            }
            let want = sum / (rings * round) as f64;
            assert!(
                (to_disc(d, 1.0) - want).abs() < 2e-3,
                "{d}: {} must be {want}",
                to_disc(d, 1.0)
            );
            assert!((to_disc(2.0 * d, 2.0) - 2.0 * to_disc(d, 1.0)).abs() < 1e-12);
        }
    }
}
