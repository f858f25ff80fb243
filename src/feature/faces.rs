//! Faces: the ground divided where the ball leaps, slides down a wall, or rolls over a sharp edge.
//!
//! ```text
//!      face    roll
//!    ________.--.            on a sharp edge the contact stands still while the ball rolls: nothing is cut there
//!             ( o )
//!            |     leap      beside a wall it falls, or runs down something steeper than the wall angle: walls have passes of their own
//!            |  face
//!            |_________
//! ```
//!
//! What hangs together between is a face: a plateau, the ground about a boss, the floor of a pocket, a terrace. Level curves of a field
//! over all of it would roll over each edge and end at each wall, on both sides; those of a face run in it, and what is rolled over costs
//! nothing.
//!
//! Crosses the border: the grid and the wall angle in; [`Faces`] out, and of them [`Regions`] without fields, which
//! [`refield`](super::source::refield) gives.

use super::region::{Feature, FeatureKind, Regions, Window};
use super::source::FieldSource;
use crate::geom::{RING, Vector};
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// What parts two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceOptions {
    /// Ground steeper than this is a wall, radians from the horizontal.
    pub wall_angle: f64,
    /// Flat stepover of the job, mm.
    pub stepover: f64,
}

/// The ground of a part, divided.
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    /// Face of each node, from 1; 0 = none: off the ground, on a wall, on an edge, or in a sliver.
    pub label: Vec<u16>,
    /// How many there are.
    pub count: usize,
    /// The grid's nodes as fields of faces see them: what is in no face is no ground.
    pub kind: Vec<NodeKind>,
}

/// The ball rolls where its contact moves less than this share of its centre's way: over an edge rounded by less than this share of
/// its own radius. (Of its whole way round such a right angle one pass would be missed at most.)
const ROLLS: f64 = 0.015;
/// An edge turns the ball's normal by more than this while it rolls over it (a difference of unit vectors): less lies between the facets of a
/// curve.
const SHARP: f64 = 0.4;
/// In a crease the ball's normal turns back by more than this from one node to the next.
const CREASE: f64 = 0.1;
/// A piece that is nowhere further than this many stepovers from its rim is a sliver: passes beside it and fills cut it ...
const SLIVER: f64 = 0.45;
/// ... as is one of fewer square stepovers than this.
const SMALL: f64 = 4.0;
/// More faces than this are no faces, but roughness.
const MOST: usize = 400;

/// Divides the ground of a grid; `None` where nothing parts it. Linear in the nodes; the result does not depend on the cores.
pub fn faces(grid: &ToolCentreGrid, options: &FaceOptions) -> Option<Faces> {
    let slope = options.wall_angle.tan();
    let ground = |n: usize| grid.kind[n] == NodeKind::Ground;
    // Is the way between two neighbours a wall, or a leap?
    let falls = |a: usize, b: usize| {
        let (c, p) = (
            grid.center(b) - grid.center(a),
            grid.point[b] - grid.point[a],
        );
        c.z.abs() > slope * c.xy().norm() && p.norm() > 0.3 * c.norm()
    };
    // Does the contact leap from one side of a crease to the other?
    let leaps = |a: usize, b: usize| {
        let c = grid.center(b) - grid.center(a);
        let turned = (c - (grid.point[b] - grid.point[a])) / grid.radius;
        turned.norm() > CREASE && turned.dot(&c) < 0.0
    };
    let apart = |a: usize, b: usize| falls(a, b) || leaps(a, b);
    let beside = |n: usize, d: (i32, i32)| grid.neighbour(n, d).filter(|&j| ground(j));
    let rolling: Vec<bool> = (0..grid.len())
        .into_par_iter()
        .map(|n| ground(n) && rolls(grid, n, &apart))
        .collect();
    let rolling = sharp_edges(grid, &rolling);
    // Of a fall the upper node parts.
    let parts: Vec<bool> = (0..grid.len())
        .into_par_iter()
        .map(|n| {
            ground(n)
                && (rolling[n]
                    || RING.iter().any(|d| {
                        beside(n, *d)
                            .is_some_and(|j| falls(n, j) && grid.center_z[n] > grid.center_z[j])
                    }))
        })
        .collect();
    if !parts.contains(&true) {
        return None;
    }
    let mut label = vec![0u16; grid.len()];
    let mut seen = vec![false; grid.len()];
    let mut depth = vec![u32::MAX; grid.len()];
    let mut count = 0;
    for first in 0..grid.len() {
        if seen[first] || parts[first] || !ground(first) {
            continue;
        }
        seen[first] = true;
        let mut piece = vec![first];
        let mut k = 0;
        while let Some(&n) = piece.get(k) {
            k += 1;
            for d in RING {
                if let Some(j) = beside(n, d)
                    && !seen[j]
                    && !parts[j]
                    && !falls(n, j)
                {
                    seen[j] = true;
                    piece.push(j);
                }
            }
        }
        let steps = deepest(grid, &piece, &mut depth);
        let area = piece.len() as f64 * grid.step * grid.step;
        if f64::from(steps) * grid.step < SLIVER * options.stepover
            || area < SMALL * options.stepover * options.stepover
        {
            continue;
        }
        count += 1;
        if count > MOST {
            return None;
        }
        piece.iter().for_each(|&n| label[n] = count as u16);
    }
    if count == 0 {
        return None;
    }
    // One node onto the edge: there the contact stands on the edge itself, and passes end when they have reached it.
    let onto: Vec<(usize, u16)> = (0..grid.len())
        .into_par_iter()
        .filter(|&n| label[n] == 0 && rolling[n])
        .filter_map(|n| {
            let near = RING
                .iter()
                .filter_map(|d| beside(n, *d))
                .filter(|&j| label[j] > 0 && !falls(n, j))
                .map(|j| label[j]);
            near.min().map(|l| (n, l))
        })
        .collect();
    onto.into_iter().for_each(|(n, l)| label[n] = l);
    let kind = (0..grid.len())
        .map(|n| match grid.kind[n] {
            NodeKind::Ground if label[n] == 0 => NodeKind::Rim,
            k => k,
        })
        .collect();
    Some(Faces { label, count, kind })
}

/// Does the ball roll over an edge at a node: in all directions in which it neither falls nor leaps, is there one in which the contact stands still?
fn rolls(grid: &ToolCentreGrid, n: usize, apart: &dyn Fn(usize, usize) -> bool) -> bool {
    let mut any = false;
    for (dx, dy) in [(1, 1), (-1, 1), (-1, -1), (1, -1)] {
        let (Some(a), Some(b)) = (grid.neighbour(n, (dx, 0)), grid.neighbour(n, (0, dy))) else {
            continue;
        };
        let all = [a, b].iter().all(|&j| grid.kind[j] == NodeKind::Ground);
        if !all || apart(n, a) || apart(n, b) || apart(a, b) {
            continue;
        }
        if least_share(grid, n, a, b) > ROLLS {
            return false;
        }
        any = true;
    }
    any
}

/// The least share of the centre's way that the contact goes, over all directions in the triangle of three nodes.
fn least_share(grid: &ToolCentreGrid, n: usize, a: usize, b: usize) -> f64 {
    let (c, p) = (grid.center(n), grid.point[n]);
    let (ca, cb) = (grid.center(a) - c, grid.center(b) - c);
    let (pa, pb) = (grid.point[a] - p, grid.point[b] - p);
    let gram = |u: &Vector, v: &Vector| [u.dot(u), u.dot(v), v.dot(v)];
    let (m, q) = (gram(&ca, &cb), gram(&pa, &pb));
    // The smaller root of det(q - l m) = 0.
    let det = m[0] * m[2] - m[1] * m[1];
    let (half, rest) = (
        0.5 * (q[0] * m[2] + q[2] * m[0] - 2.0 * q[1] * m[1]) / det,
        (q[0] * q[2] - q[1] * q[1]) / det,
    );
    let root = (half * half - rest).max(0.0).sqrt();
    // half - root would cancel to nothing but rounding.
    let least = if half + root > 0.0 {
        rest / (half + root)
    } else {
        0.0
    };
    least.max(0.0).sqrt()
}

/// Of nodes where the ball rolls, those of edges that turn it by enough.
fn sharp_edges(grid: &ToolCentreGrid, rolling: &[bool]) -> Vec<bool> {
    let mut out = vec![false; rolling.len()];
    let mut seen = vec![false; rolling.len()];
    for first in 0..rolling.len() {
        if seen[first] || !rolling[first] {
            continue;
        }
        seen[first] = true;
        let mut piece = vec![first];
        let (mut lo, mut hi) = (Vector::repeat(1.0), Vector::repeat(-1.0));
        let mut k = 0;
        while let Some(&n) = piece.get(k) {
            k += 1;
            let normal = (grid.center(n) - grid.point[n]) / grid.radius;
            (lo, hi) = (lo.inf(&normal), hi.sup(&normal));
            for d in RING {
                if let Some(j) = grid.neighbour(n, d)
                    && rolling[j]
                    && !seen[j]
                {
                    seen[j] = true;
                    piece.push(j);
                }
            }
        }
        if (hi - lo).norm() > SHARP {
            piece.iter().for_each(|&n| out[n] = true);
        }
    }
    out
}

/// Steps from the rim of a piece to its middle. `depth` is scratch, all `u32::MAX` between uses.
fn deepest(grid: &ToolCentreGrid, piece: &[usize], depth: &mut [u32]) -> u32 {
    // Inside: not yet known.
    piece.iter().for_each(|&n| depth[n] = u32::MAX - 1);
    let outside = |n: usize, depth: &[u32]| {
        RING.iter().any(|d| {
            grid.neighbour(n, *d)
                .is_none_or(|j| depth[j] == u32::MAX && grid.kind[j] == NodeKind::Ground)
        })
    };
    let mut front: Vec<usize> = piece
        .iter()
        .copied()
        .filter(|&n| outside(n, depth))
        .collect();
    // All of it round the part's own border only: as deep as it is.
    let mut steps = if front.is_empty() { u32::MAX - 1 } else { 0 };
    front.iter().for_each(|&n| depth[n] = 1);
    while !front.is_empty() {
        steps += 1;
        let mut next = Vec::new();
        for n in front {
            for d in RING {
                if let Some(j) = grid.neighbour(n, d)
                    && depth[j] == u32::MAX - 1
                {
                    depth[j] = steps + 1;
                    next.push(j);
                }
            }
        }
        front = next;
    }
    piece.iter().for_each(|&n| depth[n] = u32::MAX);
    steps
}

/// Passes end this far before what parts faces, in units of what [`Feature::free`] counts: on the last node of the face.
const PARTED: f64 = -1000.0;

impl Faces {
    /// The grid as fields of faces see it.
    pub fn parted(&self, grid: &ToolCentreGrid) -> ToolCentreGrid {
        ToolCentreGrid {
            kind: self.kind.clone(),
            ..grid.clone()
        }
    }

    /// A feature for each face, its field and levels to come.
    pub fn regions(&self, grid: &ToolCentreGrid) -> Regions {
        let mut nodes: Vec<Vec<u32>> = vec![Vec::new(); self.count];
        let mut area = vec![0.0; self.count];
        for (n, &l) in self.label.iter().enumerate() {
            if let Some(k) = (l as usize).checked_sub(1) {
                nodes[k].push(n as u32);
                let up = (grid.center_z[n] - grid.point[n].z) / grid.radius;
                area[k] += grid.step * grid.step / up.clamp(0.05, 1.0);
            }
        }
        let mut free = vec![f64::INFINITY; grid.len()];
        let features = nodes
            .into_iter()
            .zip(area)
            .map(|(own, area_mm2)| {
                let mut all = own.clone();
                own.iter().for_each(|&n| free[n as usize] = 0.0);
                // Two rings more: over the part's border passes run on, elsewhere they end.
                let mut from = 0;
                for _ in 0..2 {
                    let to = all.len();
                    for k in from..to {
                        for d in RING {
                            if let Some(j) = grid.neighbour(all[k] as usize, d)
                                && free[j] == f64::INFINITY
                            {
                                free[j] = if grid.kind[j] == NodeKind::Ground {
                                    PARTED
                                } else {
                                    0.0
                                };
                                all.push(j as u32);
                            }
                        }
                    }
                    from = to;
                }
                let window = Window::around(grid, &all, &free);
                all.iter().for_each(|&n| free[n as usize] = f64::INFINITY);
                let mut field = window.clone();
                field
                    .value
                    .iter_mut()
                    .filter(|v| v.is_finite())
                    .for_each(|v| *v = 0.0);
                Feature {
                    kind: FeatureKind::Face,
                    seed: None,
                    saddle: None,
                    source: FieldSource::Seed,
                    field,
                    rim: 0.0,
                    levels: Vec::new(),
                    free: window,
                    area_mm2,
                }
            })
            .collect();
        Regions {
            features,
            label: self.label.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point;
    use crate::part::Mesh;
    use crate::reach::{DropCutter, GridOptions, GridPlan};

    /// A plate of 30 mm with a boss of 12 mm, `height` high, in its middle, turned by `angle`; and its grid.
    fn boss(height: f64, angle: f64) -> ToolCentreGrid {
        let (s, c) = angle.sin_cos();
        let at = |x: f64, y: f64, z: f64| {
            let (x, y) = (x * c - y * s, x * s + y * c);
            Point::new(x, y, z)
        };
        let mut triangles = Vec::new();
        let mut quad = |p: [Point; 4]| {
            triangles.push([p[0], p[1], p[2]]);
            triangles.push([p[0], p[2], p[3]]);
        };
        let flat = |lo: [f64; 2], hi: [f64; 2], z: f64| {
            [
                at(lo[0], lo[1], z),
                at(hi[0], lo[1], z),
                at(hi[0], hi[1], z),
                at(lo[0], hi[1], z),
            ]
        };
        quad(flat([-15.0, -15.0], [15.0, -6.0], 0.0));
        quad(flat([-15.0, 6.0], [15.0, 15.0], 0.0));
        quad(flat([-15.0, -6.0], [-6.0, 6.0], 0.0));
        quad(flat([6.0, -6.0], [15.0, 6.0], 0.0));
        quad(flat([-6.0, -6.0], [6.0, 6.0], height));
        let corners = [[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [-6.0, 6.0]];
        for k in 0..4 {
            let ([a, b], [d, e]) = (corners[k], corners[(k + 1) % 4]);
            quad([
                at(a, b, 0.0),
                at(d, e, 0.0),
                at(d, e, height),
                at(a, b, height),
            ]);
        }
        let cutter = DropCutter::new(&Mesh { triangles }, 3.0);
        let how = GridOptions {
            step: 0.14,
            memory_limit_bytes: 1 << 30,
        };
        ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap()
    }

    const HOW: FaceOptions = FaceOptions {
        wall_angle: 1.309,
        stepover: 0.69,
    };

    /// The plateau and the ground about it, and nothing else: as large as they are, up to two diagonals of a cell at their rims.
    #[test]
    fn a_boss_on_a_plate_is_two_faces() {
        for angle in [0.0, 0.3, 0.646] {
            let grid = boss(5.0, angle);
            let f = faces(&grid, &HOW).unwrap();
            assert_eq!(f.count, 2, "{angle}");
            let mut area: Vec<f64> = f
                .regions(&grid)
                .features
                .iter()
                .map(|f| f.area_mm2)
                .collect();
            area.sort_by(f64::total_cmp);
            assert!((area[0] - 144.0).abs() < 48.0 * 0.4, "{area:?}");
            // The ball's centre keeps a radius off the boss.
            let around = 900.0 - 144.0 - 48.0 * 3.0 - 9.0 * std::f64::consts::PI;
            assert!((area[1] - around).abs() < 67.0 * 0.4, "{area:?}");
        }
    }

    /// No face holds both sides of a leap, and a node of the ground that is in no face stands on a wall or on an edge.
    #[test]
    fn no_face_holds_both_sides_of_a_leap() {
        let grid = boss(5.0, 0.3);
        let f = faces(&grid, &HOW).unwrap();
        let slope = HOW.wall_angle.tan();
        for n in 0..grid.len() {
            for d in RING {
                let Some(j) = grid.neighbour(n, d) else {
                    continue;
                };
                let c = grid.center(j) - grid.center(n);
                let p = grid.point[j] - grid.point[n];
                let ground = [n, j].iter().all(|&i| grid.kind[i] == NodeKind::Ground);
                if ground && c.z.abs() > slope * c.xy().norm() && p.norm() > 0.3 * c.norm() {
                    assert!(f.label[n] == 0 || f.label[n] != f.label[j]);
                }
            }
            if grid.kind[n] == NodeKind::Ground && f.label[n] == 0 {
                // On the edge of the plateau, or the last place up beside its wall.
                assert!(grid.point[n].z > 4.9, "{}", grid.point[n]);
            }
        }
    }

    #[test]
    fn what_nothing_parts_has_no_faces() {
        let p = |x: f64, y: f64| Point::new(x, y, 0.01 * x * y);
        let mesh = Mesh {
            triangles: vec![
                [p(0.0, 0.0), p(20.0, 0.0), p(20.0, 20.0)],
                [p(0.0, 0.0), p(20.0, 20.0), p(0.0, 20.0)],
            ],
        };
        let cutter = DropCutter::new(&mesh, 3.0);
        let how = GridOptions {
            step: 0.14,
            memory_limit_bytes: 1 << 30,
        };
        let grid = ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap();
        assert_eq!(faces(&grid, &HOW), None);
    }
}
