//! The Morse function of stage one: the height of the point the ball touches.
//!
//! Inside, centre and contact are level together (both have a horizontal tangent plane exactly where the normal is upright), so
//! this has the critical points of the centre height, the very thing the paper wants to keep calm. On the border it is the better
//! one: a border centre is `p.z + R n.z` high, and `n.z` changes along the border and jumps from facet to facet, which moves edge
//! pits by up to 0.8 mm on the test parts, loses one and invents four. The contact's height there is the part's own outline.

use super::cancel::{peaks, pits};
use super::critical::{CriticalKind, CriticalPoint, Link, Scalar, classify};
use crate::geom::{Point, Vector};
use crate::reach::{Crossing, NodeKind, ToolCentreGrid};
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
        let near = Nearby::new(grid);
        for (c, z) in grid.crossings.iter().zip(smooth) {
            let o = c.outside as usize;
            // Several crossings lead to the same node.
            if !active[o] {
                active[o] = true;
                value[o] = near.height_at(grid, o).unwrap_or(z);
            }
        }
        HeightField {
            value,
            active,
            roughness,
        }
    }
}

/// How far along the border its heights are evened out, in steps of the grid: about a stepover.
const BORDER_REACH: f64 = 5.0;

/// Border crossings by place of the ball's centre.
struct Nearby {
    reach: f64,
    places: Vec<(i64, i64, u32)>,
}

impl Nearby {
    fn new(grid: &ToolCentreGrid) -> Nearby {
        let reach = BORDER_REACH * grid.step;
        let cell = |v: f64| (v / reach).floor() as i64;
        let mut places: Vec<_> = (0u32..)
            .zip(&grid.crossings)
            .map(|(i, c)| (cell(c.contact.center.y), cell(c.contact.center.x), i))
            .collect();
        places.sort_unstable();
        Nearby { reach, places }
    }

    /// Height of the border at a node beyond it: that of a plane fitted to the contacts' heights over the places of the centres round
    /// about. The height of the nearest crossing alone would be a staircase, for the border crosses the grid's edges at uneven places,
    /// and each step of it a false pit as deep as the border falls in one step.
    fn height_at(&self, grid: &ToolCentreGrid, node: usize) -> Option<f64> {
        let q = grid.xy(node);
        let (cx, cy) = (
            (q.x / self.reach).floor() as i64,
            (q.y / self.reach).floor() as i64,
        );
        let mut near: Vec<[f64; 4]> = Vec::new();
        for y in cy - 1..=cy + 1 {
            let from = self.places.partition_point(|p| (p.0, p.1) < (y, cx - 1));
            let row = self.places[from..]
                .iter()
                .take_while(|p| p.0 == y && p.1 <= cx + 1);
            for &(_, _, i) in row {
                let c = &grid.crossings[i as usize].contact;
                let (u, v) = (
                    (c.center.x - q.x) / self.reach,
                    (c.center.y - q.y) / self.reach,
                );
                let w = 1.0 - u * u - v * v;
                if w > 0.0 {
                    near.push([u, v, c.point.z, w]);
                }
            }
        }
        let sum = |of: &dyn Fn(&[f64; 4]) -> f64| near.iter().map(|d| d[3] * of(d)).sum::<f64>();
        let n = sum(&|_| 1.0);
        if n <= 0.0 {
            return None;
        }
        let (mu, mv, mz) = (sum(&|d| d[0]) / n, sum(&|d| d[1]) / n, sum(&|d| d[2]) / n);
        let uu = sum(&|d| (d[0] - mu) * (d[0] - mu)) / n;
        let uv = sum(&|d| (d[0] - mu) * (d[1] - mv)) / n;
        let vv = sum(&|d| (d[1] - mv) * (d[1] - mv)) / n;
        // Along the border and across it.
        let turn = 0.5 * (2.0 * uv).atan2(uu - vv);
        let (c, s) = (turn.cos(), turn.sin());
        let mut z = mz;
        for (c, s, doubt) in [(c, s, 1e-6), (-s, c, ACROSS)] {
            let spread = c * c * uu + 2.0 * c * s * uv + s * s * vv;
            let lift = sum(&|d| (c * (d[0] - mu) + s * (d[1] - mv)) * (d[2] - mz)) / n;
            z -= lift / (spread + doubt) * (c * mu + s * mv);
        }
        Some(z)
    }
}

/// A straight border says nothing of the slope across it, and its centres stray by some tenths of the reach with the facets' normals: a
/// spread (of squares, in reaches) below this is doubted. At a corner it is far larger.
const ACROSS: f64 = 0.05;

/// Heights of the border crossings, evened out: at each the value of a plane fitted to the crossings nearby. A ball rolling over a
/// scanned edge hops from bump to bump; a plane keeps slopes and corners as they are.
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
        let mut ata = SMatrix::<f64, 3, 3>::zeros();
        let mut atb = SVector::<f64, 3>::zeros();
        for y in cy - 1..=cy + 1 {
            for j in bucket(y, cx - 1, cx + 1) {
                let p = &grid.crossings[j].contact.point;
                let (u, v) = ((p.x - at.x) / reach, (p.y - at.y) / reach);
                let w = 1.0 - u * u - v * v;
                if w > 0.0 {
                    let row = SVector::<f64, 3>::from([1.0, u, v]);
                    ata += row * row.transpose() * w;
                    atb += row * (w * (p.z - at.z));
                }
            }
        }
        // A straight border says nothing of the slope across it: keep that small rather than wild.
        let ridge = 1e-6 * ata[(0, 0)];
        ata[(1, 1)] += ridge;
        ata[(2, 2)] += ridge;
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
            if p.persistence < limit {
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
            // The ring beyond the border is no place of its own: an extreme beside it is one of the border.
            let boundary = boundary || beside_border(grid, p.extreme);
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

fn beside_border(grid: &ToolCentreGrid, node: usize) -> bool {
    (-1..=1).any(|dy| {
        (-1..=1).any(|dx| {
            grid.neighbour(node, (dx, dy))
                .is_some_and(|j| grid.kind[j] != NodeKind::Ground)
        })
    })
}

/// Half widths, in steps, of the windows a quadratic is fitted over, the best first: wide enough to see past the facets of the mesh, and
/// a smaller one where the border is near.
const WINDOWS: [i32; 2] = [8, 4];

/// Places a critical node below the grid's step: inside by a least-squares quadratic of the centre heights round about (smoother than the
/// contacts, and level at the same place), on the border
/// by the best of the border crossings nearby.
fn refined(
    grid: &ToolCentreGrid,
    kind: CriticalKind,
    node: usize,
    boundary: bool,
    persistence: f64,
) -> CriticalPoint {
    let (center, contact) = if boundary {
        on_border(grid, kind, node)
    } else {
        WINDOWS
            .iter()
            .find_map(|w| inside(grid, node, *w))
            .unwrap_or((grid.center(node), grid.point[node]))
    };
    CriticalPoint {
        kind,
        node,
        boundary,
        center,
        contact,
        persistence,
    }
}

fn inside(grid: &ToolCentreGrid, node: usize, window: i32) -> Option<(Point, Point)> {
    let here = grid.center(node);
    let mut ata = SMatrix::<f64, 6, 6>::zeros();
    let mut atb = SVector::<f64, 6>::zeros();
    let w = window as f64;
    for dy in -window..=window {
        for dx in -window..=window {
            let j = grid
                .neighbour(node, (dx, dy))
                .filter(|&j| grid.kind[j] == NodeKind::Ground)?;
            let (u, v) = (dx as f64 / w, dy as f64 / w);
            let row = SVector::<f64, 6>::from([1.0, u, v, u * u, u * v, v * v]);
            ata += row * row.transpose();
            atb += row * (grid.center_z[j] - here.z);
        }
    }
    let q = ata.cholesky()?.solve(&atb);
    let det = 4.0 * q[3] * q[5] - q[4] * q[4];
    if det.abs() < 1e-18 {
        return None;
    }
    let u = (-2.0 * q[5] * q[1] + q[4] * q[2]) / det;
    let v = (-2.0 * q[3] * q[2] + q[4] * q[1]) / det;
    if !(u.abs() <= 0.75 && v.abs() <= 0.75) {
        return None; // the fit sees another place than the link does
    }
    let rise = q[0] + q[1] * u + q[2] * v + q[3] * u * u + q[4] * u * v + q[5] * v * v;
    let scale = w * grid.step;
    let c = Point::new(here.x + u * scale, here.y + v * scale, here.z + rise);
    // Level ground: the ball stands right above the point it touches.
    Some((c, Point::new(c.x, c.y, c.z - grid.radius)))
}

fn on_border(grid: &ToolCentreGrid, kind: CriticalKind, node: usize) -> (Point, Point) {
    let q = grid.xy(node);
    // The node is where the evened heights are extreme, which may be some steps beside the contacts' own extreme.
    let near = 6.0 * grid.step;
    let best = grid
        .crossings
        .iter()
        .filter(|c| (c.contact.center.x - q.x).hypot(c.contact.center.y - q.y) <= near)
        .reduce(|a, b| {
            let (za, zb) = (a.contact.point.z, b.contact.point.z);
            let better = if kind == CriticalKind::Maximum {
                zb > za
            } else {
                zb < za
            };
            if better { b } else { a }
        });
    match best {
        Some(c) => along_border(grid, kind, c).unwrap_or((c.contact.center, c.contact.point)),
        None => (grid.center(node), grid.point[node]),
    }
}

/// How far to either side of a border extreme its place is sought, in steps: several facets of a usual mesh, whose own extreme is at
/// one of their corners.
const ALONG: f64 = 12.0;

/// The extreme of a parabola fitted to the contacts along a straight piece of border; `None` at corners and bends, where the crossing
/// itself is the better answer.
fn along_border(
    grid: &ToolCentreGrid,
    kind: CriticalKind,
    best: &Crossing,
) -> Option<(Point, Point)> {
    let at = best.contact.point;
    let reach = ALONG * grid.step;
    let near: Vec<(f64, f64, f64)> = grid
        .crossings
        .iter()
        .map(|c| c.contact.point - at)
        .map(|d| (d.x / reach, d.y / reach, d.z))
        .filter(|d| d.0 * d.0 + d.1 * d.1 <= 1.0)
        .collect();
    let n = near.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64, f64)) -> f64| near.iter().map(of).sum::<f64>() / n;
    let (mx, my) = (mean(&|d| d.0), mean(&|d| d.1));
    let xx = mean(&|d| (d.0 - mx) * (d.0 - mx));
    let xy = mean(&|d| (d.0 - mx) * (d.1 - my));
    let yy = mean(&|d| (d.1 - my) * (d.1 - my));
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (c, s) = (turn.cos(), turn.sin());
    let (mut ata, mut atb) = (SMatrix::<f64, 3, 3>::zeros(), SVector::<f64, 3>::zeros());
    let (mut lo, mut hi) = (0.0f64, 0.0f64);
    for &(x, y, z) in &near {
        let (along, off) = (c * x + s * y, c * y - s * x);
        if off.abs() > 0.05 {
            return None;
        }
        (lo, hi) = (lo.min(along), hi.max(along));
        let row = SVector::<f64, 3>::from([1.0, along, along * along]);
        ata += row * row.transpose();
        atb += row * z;
    }
    if lo > -0.8 || hi < 0.8 {
        return None; // the border ends or turns here
    }
    let q = ata.cholesky()?.solve(&atb);
    let bends = if kind == CriticalKind::Maximum {
        -q[2]
    } else {
        q[2]
    };
    let t = -q[1] / (2.0 * q[2]);
    if !(bends > 0.0 && t.abs() <= 0.75) {
        return None;
    }
    let move_by = Vector::new(c * t * reach, s * t * reach, q[0] + q[1] * t + q[2] * t * t);
    Some((best.contact.center + move_by, at + move_by))
}
