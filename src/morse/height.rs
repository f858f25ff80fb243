//! The Morse function of stage one: the height of the point the ball touches.
//!
//! Inside, centre and contact are level together (both have a horizontal tangent plane exactly where the normal is upright), so
//! this has the critical points of the centre height, the very thing the paper wants to keep calm. On the border it is the better
//! one: a border centre is `p.z + R n.z` high, and `n.z` changes along the border and jumps from facet to facet, which moves edge
//! pits by up to 0.8 mm on the test parts, loses one and invents four. The contact's height there is the part's own outline.

use super::cancel::{peaks, pits};
use super::critical::{CriticalKind, CriticalPoint, Link, Scalar, classify};
use super::refine::refined;
use crate::reach::{LINK, NodeKind, ToolCentreGrid};
use nalgebra::{SMatrix, SVector};

/// What counts as a critical point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MorseOptions {
    /// Pairs of critical points whose heights differ by less than this are noise, mm.
    pub persistence_mm: f64,
}

/// The heights that the link rule is applied to: the ground, and one ring of nodes beyond its border that carry the contact's
/// height *on* the border.
///
/// Without that ring the border would be the staircase of the grid, and each step of it a false pit on a slope.
#[derive(Clone, Debug)]
pub struct HeightField {
    /// Height per node, mm.
    pub value: Vec<f64>,
    /// Ground and the ring beyond it.
    pub active: Vec<bool>,
    /// Roughness of the border, mm: the standard deviation of its heights about planes fitted along it, by their median. A few
    /// micrometres on a clean mesh, the noise of the scanner on a scanned one.
    pub roughness: f64,
}

impl HeightField {
    /// Reads the field off the grid.
    pub fn new(grid: &ToolCentreGrid) -> HeightField {
        let mut value: Vec<f64> = grid.point.iter().map(|p| p.z).collect();
        let mut active: Vec<bool> = grid.kind.iter().map(|k| *k == NodeKind::Ground).collect();
        let smooth = evened(grid);
        let mut off: Vec<f64> = grid
            .crossings
            .iter()
            .zip(&smooth)
            .map(|(c, z)| (c.contact.point.z - z).abs())
            .collect();
        off.sort_unstable_by(f64::total_cmp);
        // The median of |x| of a normal distribution is 0.6745 standard deviations.
        let roughness = off.get(off.len() / 2).map_or(0.0, |m| m / 0.6745);
        let mut nearest: Vec<f64> = vec![f64::INFINITY; grid.len()];
        for (c, z) in grid.crossings.iter().zip(smooth) {
            let o = c.outside as usize;
            let q = grid.xy(o);
            let d = (c.contact.center.x - q.x).hypot(c.contact.center.y - q.y);
            active[o] = true;
            if d < nearest[o] {
                nearest[o] = d;
                value[o] = z;
            }
        }
        HeightField {
            value,
            active,
            roughness,
        }
    }
}

/// What the height of an extreme beside the border is good for, mm: the border is known to a share of a step, and on a slope that is
/// height. Zero inside.
fn border_doubt(grid: &ToolCentreGrid, node: usize) -> f64 {
    let around = || {
        std::iter::once(Some(node))
            .chain(LINK.iter().map(|d| grid.neighbour(node, *d)))
            .flatten()
    };
    if around().all(|j| grid.kind[j] == NodeKind::Ground) {
        return 0.0;
    }
    around()
        .filter(|&j| grid.kind[j] == NodeKind::Ground)
        .map(|j| {
            let n = (grid.center(j) - grid.point[j]) / grid.radius;
            (n.x.hypot(n.y) / n.z.max(0.2)) * grid.step
        })
        .fold(0.0, f64::max)
}

/// How far along the border its heights are evened out, in steps of the grid: about a stepover.
const BORDER_REACH: f64 = 5.0;

/// Heights of the border crossings, evened out: at each the value of a quadratic fitted to the crossings nearby. A ball rolling over a
/// scanned edge hops from bump to bump; a quadratic keeps slopes, bends and corners as they are.
fn evened(grid: &ToolCentreGrid) -> Vec<f64> {
    let reach = BORDER_REACH * grid.step;
    let places: Vec<(i64, i64, u32)> = {
        let cell = |v: f64| (v / reach).floor() as i64;
        let mut p: Vec<_> = grid
            .crossings
            .iter()
            .enumerate()
            .map(|(i, c)| (cell(c.contact.point.y), cell(c.contact.point.x), i as u32))
            .collect();
        p.sort_unstable();
        p
    };
    let bucket = |y: i64, x0: i64, x1: i64| {
        let from = places.partition_point(|p| (p.0, p.1) < (y, x0));
        places[from..]
            .iter()
            .take_while(move |p| p.0 == y && p.1 <= x1)
            .map(|p| p.2 as usize)
    };
    let mut out = vec![0.0; grid.crossings.len()];
    for &(cy, cx, i) in &places {
        let at = &grid.crossings[i as usize].contact.point;
        let mut ata = SMatrix::<f64, 6, 6>::zeros();
        let mut atb = SVector::<f64, 6>::zeros();
        for y in cy - 1..=cy + 1 {
            for j in bucket(y, cx - 1, cx + 1) {
                let p = &grid.crossings[j].contact.point;
                let (u, v) = ((p.x - at.x) / reach, (p.y - at.y) / reach);
                let w = 1.0 - u * u - v * v;
                if w > 0.0 {
                    let row = SVector::<f64, 6>::from([1.0, u, v, u * u, u * v, v * v]);
                    ata += row * row.transpose() * w;
                    atb += row * (w * (p.z - at.z));
                }
            }
        }
        // A straight border says nothing of the surface across it: keep that small rather than wild.
        let ridge = 1e-5 * ata[(0, 0)];
        for k in 1..6 {
            ata[(k, k)] += ridge;
        }
        out[i as usize] = at.z + ata.cholesky().map_or(0.0, |c| c.solve(&atb)[0]);
    }
    out
}

/// Critical points of the contact height: peaks by falling height, pits by rising height, saddles by falling height.
/// A saddle of several arms is listed once per arm too many.
pub fn critical_points(
    grid: &ToolCentreGrid,
    field: &HeightField,
    options: &MorseOptions,
) -> Vec<CriticalPoint> {
    let s = Scalar {
        nx: grid.nx,
        value: &field.value,
        active: &field.active,
    };
    let limit = options.persistence_mm;
    let mut out: Vec<CriticalPoint> = Vec::new();
    // How many arms of each saddle node are noise, and the smallest persistence of the pairs that stay.
    let mut cancelled = vec![0u32; grid.len()];
    let mut smallest = vec![f64::INFINITY; grid.len()];
    for (kind, pairs) in [
        (CriticalKind::Maximum, peaks(&s)),
        (CriticalKind::Minimum, pits(&s)),
    ] {
        for p in pairs {
            if p.persistence < limit.max(border_doubt(grid, p.extreme)) {
                if let Some(m) = p.merge {
                    cancelled[m] += 1;
                }
                continue;
            }
            if let Some(m) = p.merge {
                smallest[m] = smallest[m].min(p.persistence);
            }
            let (link, boundary) = classify(&s, p.extreme);
            if link == Link::Regular {
                continue;
            }
            out.push(refined(grid, kind, p.extreme, boundary, p.persistence));
        }
    }
    for node in 0..grid.len() {
        if !field.active[node] {
            continue;
        }
        if let (Link::Saddle(arms), _) = classify(&s, node) {
            for _ in cancelled[node].min(arms)..arms {
                out.push(refined(
                    grid,
                    CriticalKind::Saddle,
                    node,
                    false,
                    smallest[node],
                ));
            }
        }
    }
    out.sort_by(|a, b| {
        let rise = if a.kind == CriticalKind::Minimum {
            1.0
        } else {
            -1.0
        };
        a.kind
            .cmp(&b.kind)
            .then((rise * a.center.z).total_cmp(&(rise * b.center.z)))
            .then(a.node.cmp(&b.node))
    });
    out
}
