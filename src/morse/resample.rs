//! Even samples of a surface: what distances are marched over, whatever triangles the file has.
//!
//! ```text
//!   long edges are halved, triangles with them       so that the vertices are dense enough to choose from
//!   seeds: vertices no nearer to one another than a spacing, none farther from its seed
//!   net: one vertex a seed; a triangle where three seeds' grounds meet, an edge where two do (the Delaunay net of the seeds)
//! ```
//!
//! Skinny, obtuse and tiny triangles, duplicates and branches all vanish in this; thin walls keep their two sides apart, because
//! ground is shared out along edges and not through space. Border vertices are asked first, so that the border keeps its place.

use super::geodesic::{Item, Net};
use super::surface::edge_runs;
use crate::geom::{Point, Vector};
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;
use std::collections::BinaryHeap;

/// A connected piece of surface and its even samples.
#[derive(Clone, Debug)]
pub struct Samples {
    /// The seeds and the ways between them.
    pub net: Net,
    /// Area that each seed stands for, mm2.
    pub area: Vec<f64>,
    /// Mean distance of that area from its seed, mm.
    pub inner: Vec<f64>,
    /// Seed of each vertex of the piece.
    pub seed_of: Vec<u32>,
    /// Spacing, mm.
    pub spacing: f64,
}

/// Vertices that halving edges may add, at most this many times what was there and this many more.
const MORE: [usize; 2] = [2, 200_000];

/// Samples a connected piece by about `wanted` seeds. `area` of it must be above zero.
pub fn sampled(points: &[Point], triangles: &[[u32; 3]], area: f64, wanted: usize) -> Samples {
    // Each seed keeps about three quarters of its spacing squared to itself.
    let mut spacing = (area / (0.75 * wanted.max(1) as f64)).sqrt();
    let (points, triangles) = halved(points, triangles, 0.5 * spacing);
    let runs = edge_runs(&triangles);
    let mut first = vec![false; points.len()];
    for (e, _) in runs.iter().filter(|r| r.1 == 1) {
        first[e[0] as usize] = true;
        first[e[1] as usize] = true;
    }
    let edges: Vec<[u32; 2]> = runs.into_iter().map(|r| r.0).collect();
    let fine = Net::new(points, &edges, Vec::new());
    let (mut chosen, mut seed_of) = seeds(&fine, &first, spacing);
    // Needles have more length than their area tells.
    while chosen.len() > 3 * wanted.max(1) {
        spacing *= 1.5 * (chosen.len() as f64 / (3 * wanted.max(1)) as f64).sqrt();
        (chosen, seed_of) = seeds(&fine, &first, spacing);
    }

    let mut own = vec![0.0; chosen.len()];
    let mut inner = vec![0.0; chosen.len()];
    let mut joint: Vec<([u32; 3], u32)> = Vec::new();
    for (k, t) in triangles.iter().enumerate() {
        let [a, b, c] = t.map(|v| fine.points[v as usize]);
        let third = (b - a).cross(&(c - a)).norm() / 6.0;
        let mut s = t.map(|v| seed_of[v as usize]);
        for (p, &i) in [a, b, c].iter().zip(&s) {
            own[i as usize] += third;
            inner[i as usize] += third * (p - fine.points[chosen[i as usize] as usize]).norm();
        }
        s.sort_unstable();
        if s[0] != s[1] && s[1] != s[2] {
            joint.push((s, k as u32));
        }
    }
    for (sum, area) in inner.iter_mut().zip(&own) {
        *sum /= f64::max(*area, 1e-300);
    }
    joint.sort_unstable();
    joint.dedup_by_key(|j| j.0);
    let mut ways: Vec<[u32; 2]> = edges
        .iter()
        .map(|e| e.map(|v| seed_of[v as usize]))
        .filter(|e| e[0] != e[1])
        .map(|e| [e[0].min(e[1]), e[0].max(e[1])])
        .collect();
    ways.sort_unstable();
    ways.dedup();
    Samples {
        net: Net::new(
            chosen.iter().map(|&v| fine.points[v as usize]).collect(),
            &ways,
            joint.into_iter().map(|j| j.0).collect(),
        ),
        area: own,
        inner,
        seed_of,
        spacing,
    }
}

/// Halves edges longer than `longest`, and the triangles on them, until there are none or too many vertices. The given vertices keep
/// their numbers.
fn halved(points: &[Point], triangles: &[[u32; 3]], longest: f64) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut points = points.to_vec();
    let mut triangles = triangles.to_vec();
    let most = MORE[0] * points.len() + MORE[1];
    while points.len() < most {
        let long: Vec<[u32; 2]> = edge_runs(&triangles)
            .into_iter()
            .map(|r| r.0)
            .filter(|e| (points[e[0] as usize] - points[e[1] as usize]).norm() > longest)
            .collect();
        if long.is_empty() {
            break;
        }
        let base = points.len() as u32;
        for e in &long {
            points.push(nalgebra::center(
                &points[e[0] as usize],
                &points[e[1] as usize],
            ));
        }
        let middle = |a: u32, b: u32| {
            long.binary_search(&[a.min(b), a.max(b)])
                .ok()
                .map(|k| base + k as u32)
        };
        let mut out = Vec::with_capacity(triangles.len() + 3 * long.len());
        for t in &triangles {
            let m = [middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])];
            split(t, m, &points, &mut out);
        }
        triangles = out;
    }
    (points, triangles)
}

/// The triangles that one becomes when the middles of some of its sides (01, 12, 20) are taken in.
fn split(t: &[u32; 3], m: [Option<u32>; 3], points: &[Point], out: &mut Vec<[u32; 3]>) {
    let [a, b, c] = *t;
    match m {
        [None, None, None] => out.push(*t),
        [Some(p), Some(q), Some(r)] => {
            out.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
        }
        _ => {
            // Turn it until side 01 is the only whole one, or the only halved one.
            let halves = m.iter().flatten().count();
            let odd = (0..3)
                .find(|&k| m[k].is_some() == (halves == 1))
                .unwrap_or(0);
            let [a, b, c] = [t[odd], t[(odd + 1) % 3], t[(odd + 2) % 3]];
            let [p, q, r] = [m[odd], m[(odd + 1) % 3], m[(odd + 2) % 3]];
            match (p, q, r) {
                (Some(p), _, _) => out.extend([[a, p, c], [p, b, c]]),
                (_, Some(q), Some(r)) => {
                    // The corner c with both middles, and a quadrilateral a b q r, cut along its shorter diagonal.
                    out.push([c, r, q]);
                    let d = |i: u32, j: u32| (points[i as usize] - points[j as usize]).norm();
                    if d(a, q) <= d(b, r) {
                        out.extend([[a, b, q], [a, q, r]]);
                    } else {
                        out.extend([[a, b, r], [b, q, r]]);
                    }
                }
                _ => out.push(*t),
            }
        }
    }
}

/// Vertices no nearer than `spacing` to one another (unless no way of edges within it joins them), and the nearest of them for every vertex; those marked come first.
fn seeds(fine: &Net, first: &[bool], spacing: f64) -> (Vec<u32>, Vec<u32>) {
    let n = fine.points.len();
    let mut away = vec![f64::INFINITY; n];
    let mut seed_of = vec![0u32; n];
    let mut seeds: Vec<u32> = Vec::new();
    let mut heap = BinaryHeap::new();
    for turn in [true, false] {
        for v in 0..n {
            if first[v] != turn || away[v] <= spacing {
                continue;
            }
            let label = seeds.len() as u32;
            seeds.push(v as u32);
            away[v] = 0.0;
            seed_of[v] = label;
            heap.push(Item(0.0, v as u32));
            while let Some(Item(d, u)) = heap.pop() {
                if d > away[u as usize] {
                    continue;
                }
                // The way goes along edges, its length is that of the chord: cells as round as the vertices allow.
                for &x in fine.neighbours(u) {
                    let e = (fine.points[v] - fine.points[x as usize]).norm();
                    if e <= spacing && e < away[x as usize] {
                        away[x as usize] = e;
                        seed_of[x as usize] = label;
                        heap.push(Item(e, x));
                    }
                }
            }
        }
    }
    (seeds, seed_of)
}

impl Samples {
    /// Carries values at the seeds over to places near them (`seed[k]` is the seed of `places[k]`): a plane fitted to the seeds about
    /// each place, those near by counting more. Exact for what is linear; smooth from place to place.
    pub fn spread(&self, at_seed: &[f64], places: &[Point], seed: &[u32]) -> Vec<f64> {
        let reach = 2.0 * self.spacing;
        let about: Vec<Vec<u32>> = (0..at_seed.len() as u32)
            .into_par_iter()
            .map(|s| {
                let mut list = vec![s];
                for &a in self.net.neighbours(s) {
                    list.push(a);
                    list.extend_from_slice(self.net.neighbours(a));
                }
                list.sort_unstable();
                list.dedup();
                list
            })
            .collect();
        places
            .par_iter()
            .zip(seed)
            .map(|(p, &s)| {
                let mut ata = SMatrix::<f64, 4, 4>::zeros();
                let mut atb = SVector::<f64, 4>::zeros();
                let base = at_seed[s as usize];
                for &k in &about[s as usize] {
                    let d: Vector = (self.net.points[k as usize] - p) / reach;
                    let w = (1.0 - d.norm_squared()).max(0.0).powi(2);
                    if w > 0.0 {
                        let row = SVector::<f64, 4>::from([1.0, d.x, d.y, d.z]);
                        ata += row * row.transpose() * w;
                        atb += row * (w * (at_seed[k as usize] - base));
                    }
                }
                // The surface says nothing of the direction across it: keep that small rather than wild.
                let ridge = 1e-4 * ata[(0, 0)];
                for k in 1..4 {
                    ata[(k, k)] += ridge;
                }
                base + ata.cholesky().map_or(0.0, |c| c.solve(&atb)[0])
            })
            .collect()
    }
}
