//! The tool-centre surface on a regular grid: for each (x, y) the lowest centre of the ball, and the point it touches there.
//!
//! ```text
//!    air . . . . . . . . .      air     the ball meets nothing
//!    . rim rim rim rim . .      rim     the ball rolls round the outline of the part
//!    . rim G   G   G  rim .     ground  the ball rests on the part itself: what there is to cut
//!    . rim G   G   G  rim .     x       border crossings, found on the grid's edges by bisection
//! ```
//!
//! On a slope the ball that touches the part's edge has its centre outside the outline, so the grid reaches one radius
//! beyond it.

use super::drop::{Contact, DropCutter, Hint};
use crate::geom::{Point, Point2};
use rayon::prelude::*;

/// What a node of the grid is to the cutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// The ball falls past the part.
    Air,
    /// The ball rolls round the outline, from where it leaves the part's surface to where it falls off.
    Rim,
    /// The ball rests on the part.
    Ground,
}

/// Where the border of the ground crosses an edge of the grid's triangulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Node on the ground.
    pub inside: u32,
    /// Neighbouring node off it.
    pub outside: u32,
    /// The last place on the ground along that edge.
    pub contact: Contact,
}

/// How to lay the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// Distance of neighbouring nodes, mm.
    pub step: f64,
    /// Refuse a grid that would take more memory than this.
    pub memory_limit_bytes: u64,
}

/// Why no grid was laid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// More memory than allowed.
    #[error(
        "the tool-centre grid would have {nx} x {ny} nodes at a step of {step:.4} mm and take {need_mib} MiB, more than the {limit_mib} MiB allowed: \
         set a coarser --grid, check --units, or mill the part in pieces"
    )]
    TooLarge {
        /// Nodes along X.
        nx: u64,
        /// Nodes along Y.
        ny: u64,
        /// Step, mm.
        step: f64,
        /// What it would take.
        need_mib: u64,
        /// What is allowed.
        limit_mib: u64,
    },
    /// Nothing to stand on.
    #[error("the ball rests nowhere on the part: is it upright or empty? Check --up and --units")]
    NoGround,
}

/// What a grid will be, before memory is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlan {
    /// Place of node (0, 0).
    pub origin: Point2,
    /// Distance of neighbouring nodes, mm.
    pub step: f64,
    /// Nodes along X and Y.
    pub size: [usize; 2],
    /// Memory the grid and the fields over it will take.
    pub bytes: u64,
}

/// Bytes a node costs through the whole of planning (centre, contact, kind, metric, fields).
const BYTES_PER_NODE: u64 = 120;

/// Steps along X and Y from a node to its six neighbours in the triangulation, counter-clockwise. Cells are split along the
/// diagonal from (0, 0) to (1, 1).
pub const LINK: [(i32, i32); 6] = [(1, 0), (1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1)];

/// The tool-centre surface. Row-major: node (ix, iy) is at index `iy * nx + ix`. Work coordinates, mm.
#[derive(Clone, Debug)]
pub struct ToolCentreGrid {
    /// Place of node (0, 0).
    pub origin: Point2,
    /// Distance of neighbouring nodes, mm.
    pub step: f64,
    /// Nodes along X.
    pub nx: usize,
    /// Nodes along Y.
    pub ny: usize,
    /// Radius of the ball, mm.
    pub radius: f64,
    /// Height of the ball's centre; -inf over air.
    pub center_z: Vec<f64>,
    /// The point touched; NaN over air.
    pub point: Vec<Point>,
    /// What each node is.
    pub kind: Vec<NodeKind>,
    /// Every place where the ground's border crosses an edge of the triangulation, by rising inside node.
    pub crossings: Vec<Crossing>,
}

impl GridPlan {
    /// Lays out a grid over the part with one radius and two steps to spare all round.
    pub fn new(cutter: &DropCutter, options: &GridOptions) -> Result<GridPlan, GridError> {
        let b = cutter.bounds();
        if b.is_empty() {
            return Err(GridError::NoGround);
        }
        let s = options.step;
        let room = cutter.radius() + 2.0 * s;
        let count = |lo: f64, hi: f64| ((hi - lo + 2.0 * room) / s).ceil() + 1.0;
        let (nx, ny) = (count(b.min.x, b.max.x), count(b.min.y, b.max.y));
        let need = nx * ny * BYTES_PER_NODE as f64;
        if need > options.memory_limit_bytes as f64 || nx * ny > (u32::MAX / 8) as f64 {
            return Err(GridError::TooLarge {
                nx: nx as u64,
                ny: ny as u64,
                step: s,
                need_mib: (need / 1048576.0) as u64,
                limit_mib: options.memory_limit_bytes / 1048576,
            });
        }
        // Centred, so that a part and its mirror image are treated alike.
        let c = b.center();
        Ok(GridPlan {
            origin: Point2::new(c.x - (nx - 1.0) * s / 2.0, c.y - (ny - 1.0) * s / 2.0),
            step: s,
            size: [nx as usize, ny as usize],
            bytes: need as u64,
        })
    }
}

impl ToolCentreGrid {
    /// Drops the ball on every node, on all cores, and finds the border of the ground.
    pub fn new(cutter: &DropCutter, plan: &GridPlan) -> Result<ToolCentreGrid, GridError> {
        let [nx, ny] = plan.size;
        let at = |i: usize| {
            (
                plan.origin.x + (i % nx) as f64 * plan.step,
                plan.origin.y + (i / nx) as f64 * plan.step,
            )
        };
        let mut center_z = vec![f64::NEG_INFINITY; nx * ny];
        let mut point = vec![Point::new(f64::NAN, f64::NAN, f64::NAN); nx * ny];
        center_z
            .par_chunks_mut(nx)
            .zip(point.par_chunks_mut(nx))
            .enumerate()
            .for_each(|(iy, (zs, ps))| {
                let mut hint = Hint::default();
                for ix in 0..nx {
                    let (x, y) = at(iy * nx + ix);
                    if let Some(c) = cutter.drop_near(x, y, &mut hint) {
                        zs[ix] = c.center.z;
                        ps[ix] = c.point;
                    }
                }
            });
        let mut grid = ToolCentreGrid {
            origin: plan.origin,
            step: plan.step,
            nx,
            ny,
            radius: cutter.radius(),
            kind: vec![NodeKind::Air; nx * ny],
            center_z,
            point,
            crossings: Vec::new(),
        };
        grid.classify(cutter);
        if !grid.kind.contains(&NodeKind::Ground) {
            return Err(GridError::NoGround);
        }
        grid.find_crossings(cutter);
        Ok(grid)
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.center_z.len()
    }

    /// True for a grid without nodes.
    pub fn is_empty(&self) -> bool {
        self.center_z.is_empty()
    }

    /// Place of a node in plan.
    #[inline]
    pub fn xy(&self, node: usize) -> Point2 {
        Point2::new(
            self.origin.x + (node % self.nx) as f64 * self.step,
            self.origin.y + (node / self.nx) as f64 * self.step,
        )
    }

    /// Centre of the ball over a node; its height is -inf over air.
    #[inline]
    pub fn center(&self, node: usize) -> Point {
        let q = self.xy(node);
        Point::new(q.x, q.y, self.center_z[node])
    }

    /// The node `(dx, dy)` steps away, if it is on the grid.
    #[inline]
    pub fn neighbour(&self, node: usize, d: (i32, i32)) -> Option<usize> {
        let x = (node % self.nx) as i64 + d.0 as i64;
        let y = (node / self.nx) as i64 + d.1 as i64;
        (x >= 0 && y >= 0 && (x as usize) < self.nx && (y as usize) < self.ny)
            .then(|| y as usize * self.nx + x as usize)
    }

    /// The node nearest a place; `None` off the grid.
    pub fn nearest(&self, x: f64, y: f64) -> Option<usize> {
        let ix = ((x - self.origin.x) / self.step).round();
        let iy = ((y - self.origin.y) / self.step).round();
        (ix >= 0.0 && iy >= 0.0 && ix < self.nx as f64 && iy < self.ny as f64)
            .then(|| iy as usize * self.nx + ix as usize)
    }

    /// How near to a contact the part must end for it to count as lying on the outline, mm.
    pub fn outline_reach(&self) -> f64 {
        2e-4 * self.step
    }

    /// Rim: nodes that roll round the outline and hang together with the air. A hole that the ball bridges is ground.
    fn classify(&mut self, cutter: &DropCutter) {
        let n = self.len();
        let reach = self.outline_reach();
        let mut front: Vec<usize> = Vec::new();
        for i in 0..n {
            if self.center_z[i] > f64::NEG_INFINITY {
                self.kind[i] = NodeKind::Ground;
            } else {
                front.push(i);
            }
        }
        let mut asked = vec![false; n];
        while !front.is_empty() {
            let mut next: Vec<usize> = Vec::new();
            for &i in &front {
                for dy in -1..=1 {
                    for dx in -1..=1 {
                        if let Some(j) = self.neighbour(i, (dx, dy))
                            && self.kind[j] == NodeKind::Ground
                            && !asked[j]
                        {
                            asked[j] = true;
                            next.push(j);
                        }
                    }
                }
            }
            let rolls: Vec<bool> = next
                .par_iter()
                .map(|&j| {
                    let c = Contact {
                        center: self.center(j),
                        point: self.point[j],
                        triangle: 0,
                    };
                    cutter.on_outline(&c, reach)
                })
                .collect();
            front.clear();
            for (&j, &rim) in next.iter().zip(&rolls) {
                if rim {
                    self.kind[j] = NodeKind::Rim;
                    front.push(j);
                }
            }
        }
    }

    fn find_crossings(&mut self, cutter: &DropCutter) {
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for i in 0..self.len() {
            if self.kind[i] != NodeKind::Ground {
                continue;
            }
            for d in LINK {
                if let Some(j) = self.neighbour(i, d)
                    && self.kind[j] != NodeKind::Ground
                {
                    edges.push((i as u32, j as u32));
                }
            }
        }
        let reach = self.outline_reach();
        self.crossings = edges
            .par_iter()
            .map(|&(inside, outside)| {
                let (a, b) = (self.xy(inside as usize), self.xy(outside as usize));
                let mut last = Contact {
                    center: self.center(inside as usize),
                    point: self.point[inside as usize],
                    triangle: 0,
                };
                let (mut lo, mut hi) = (0.0, 1.0);
                // The border loop is laid through these places. Round a solid the part is upright there: a ball that is 0.2 um beside the
                // outline of a sphere of 50 mm still hangs 0.1 mm above its equator.
                while hi - lo > 1e-4 {
                    let m = 0.5 * (lo + hi);
                    let q = a + (b - a) * m;
                    match cutter
                        .drop(q.x, q.y)
                        .filter(|c| !cutter.on_outline(c, reach))
                    {
                        Some(c) => {
                            lo = m;
                            last = c;
                        }
                        None => hi = m,
                    }
                }
                Crossing {
                    inside,
                    outside,
                    contact: last,
                }
            })
            .collect();
    }
}
