//! The surface a ball can reach: the closing of the part by the ball, on a lattice.
//!
//! ```text
//!      ( c )  ( c )         every resting ball is admissible; the reachable height over q is the lowest underside of any
//!   \   '.'.__.'.'  /       of them. In a fold tighter than the ball it stays above the part: rest material, not ours.
//!    \_____________/        reach(q) = min over x, |q - x| <= R, of  c(x) - sqrt(R^2 - |q - x|^2)
//! ```
//! The minimum is not searched by brute force (a ball covers 11,000 cells at 0.05 mm): each cell starts from the node whose
//! contact falls nearest, hands its best node to its neighbours, and walks downhill over the nodes until nothing improves.
//! Then the lattice's own error is taken out: a quadratic through the nine nodes around the best one where the centre surface
//! is smooth, and balls found by bisection on the creases where it is not (the ball touches in two places).
//!
//! Error: where the ball touches once, the quadratic leaves a third-order remainder in the step (0.1 um at 0.05 mm);
//! in a crease the along-crease spacing of the bisected balls overestimates by at most step^2 / (8 R) * 4 normal to the
//! surface (0.4 um); at the single points where creases meet, by at most half a step times the crease's slope.

use crate::geom::{Box3, Point, Point2};
use crate::reach::{Contact, DropCutter, Hint};
use crate::sweep::Lattice;
use rayon::prelude::*;

/// What one ball can reach of a part. Work coordinates, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Reachable {
    /// Covers the part's shadow plus one radius all round.
    pub lattice: Lattice,
    /// Radius of the ball.
    pub radius: f64,
    /// Top of the part over each cell's centre; NaN off the part.
    pub part_z: Vec<f64>,
    /// Height of the centre of the resting ball over each cell; `-inf` where it touches nothing.
    pub center_z: Vec<f64>,
    /// Lowest underside of any resting ball over each cell; `+inf` where no resting ball covers it.
    pub reach_z: Vec<f64>,
    /// The lattice node whose ball reaches each cell best (on a crease: a node next to it); `u32::MAX` for none.
    pub by: Vec<u32>,
    /// Vertical component of the unit vector from each cell's reached point to the centre of that ball; 0 for none.
    pub normal_z: Vec<f32>,
}

impl Reachable {
    /// How far the reachable surface stands above the part, along its normal, to first order, mm: above zero is rest material.
    /// NaN off the part.
    pub fn rest(&self, cell: usize) -> f64 {
        match (
            self.reach_z.get(cell),
            self.part_z.get(cell),
            self.normal_z.get(cell),
        ) {
            (Some(r), Some(p), Some(n)) if r.is_finite() => (r - p) * f64::from(*n),
            _ => f64::NAN,
        }
    }
}

/// Bytes that [`reachable`] will take for a part of this size, so that a caller can announce or refuse it first.
pub fn reachable_bytes(bounds: &Box3, radius: f64, step: f64) -> u64 {
    // center, part, reach: 8 each; by 4; normal 4; working: offsets 4, contact normals 8, flags 2.
    lattice_for(bounds, radius, step).len() as u64 * 50
}

fn lattice_for(bounds: &Box3, radius: f64, step: f64) -> Lattice {
    Lattice::covering(
        Point2::new(bounds.min.x - radius, bounds.min.y - radius),
        Point2::new(bounds.max.x + radius, bounds.max.y + radius),
        step,
    )
}

/// Computes the surface that the drop cutter's ball can reach, on a lattice of this step (mm; at least radius / 30000, coarser
/// steps are used otherwise). An empty part gives an empty lattice. Same bits for any number of threads. Cost: one drop and one
/// line query a node, then some 40 evaluations a cell.
pub fn reachable(drop: &DropCutter, step: f64) -> Reachable {
    let radius = drop.radius();
    let step = step.max(radius / 30_000.0);
    let lattice = lattice_for(&drop.bounds(), radius, step);
    let n = if lattice.len() < u32::MAX as usize {
        lattice.len()
    } else {
        0
    };
    let lattice = if n == 0 {
        Lattice {
            nx: 0,
            ny: 0,
            ..lattice
        }
    } else {
        lattice
    };
    let nodes = sample(drop, &lattice);
    let mut search = Search::seeded(&lattice, radius, &nodes);
    search.spread_in_bands();
    search.descend();
    search.settle();
    let extras = creases(drop, &lattice, &nodes);
    let near = near_extras(&lattice, &extras);
    let (reach_z, by, normal_z) = search.refined(&nodes.part_z, &extras, &near);
    Reachable {
        lattice,
        radius,
        part_z: nodes.part_z,
        center_z: nodes.center_z,
        reach_z,
        by,
        normal_z,
    }
}

/// One resting ball per node.
struct Nodes {
    center_z: Vec<f64>,
    part_z: Vec<f64>,
    /// Plan part of the unit vector from contact to centre (f32: used to seed and to detect only).
    normal: Vec<[f32; 2]>,
}

fn sample(drop: &DropCutter, lattice: &Lattice) -> Nodes {
    let n = lattice.len();
    let mut nodes = Nodes {
        center_z: vec![f64::NEG_INFINITY; n],
        part_z: vec![f64::NAN; n],
        normal: vec![[0.0; 2]; n],
    };
    let nx = lattice.nx.max(1);
    nodes
        .center_z
        .par_chunks_mut(nx)
        .zip(nodes.part_z.par_chunks_mut(nx))
        .zip(nodes.normal.par_chunks_mut(nx))
        .enumerate()
        .for_each(|(iy, ((center_z, part_z), normal))| {
            let y = lattice.y(iy);
            let mut hint = Hint::default();
            for ix in 0..center_z.len() {
                let x = lattice.x(ix);
                if let Some(c) = drop.drop_near(x, y, &mut hint) {
                    center_z[ix] = c.center.z;
                    let u = unit(&c);
                    normal[ix] = [u[0] as f32, u[1] as f32];
                    if let Some(z) = drop.surface_z(x, y) {
                        part_z[ix] = z;
                    }
                }
            }
        });
    nodes
}

/// Unit vector from contact to centre.
fn unit(c: &Contact) -> [f64; 3] {
    let d = c.center - c.point;
    let n = d.norm();
    if n > 0.0 {
        [d.x / n, d.y / n, d.z / n]
    } else {
        [0.0, 0.0, 1.0]
    }
}

/// From a cell to the node that reaches it best, in steps; `NONE` in the first place for no candidate yet.
type Offset = [i16; 2];
const NONE: i16 = i16::MIN;
const AROUND: [[i16; 2]; 8] = [
    [-1, 0],
    [1, 0],
    [0, -1],
    [0, 1],
    [-1, -1],
    [1, -1],
    [-1, 1],
    [1, 1],
];
const BAND_ROWS: usize = 64;
/// Undersides nearer than this are the same height, mm.
const TIE: f64 = 1e-9;

struct Search<'a> {
    lattice: &'a Lattice,
    center_z: &'a [f64],
    radius_sq: f64,
    step_sq: f64,
    offset: Vec<Offset>,
    value: Vec<f64>,
}

/// The underside over cell (ix, iy) of the ball resting on the node at this offset; `+inf` if there is none.
struct Underside<'a> {
    center_z: &'a [f64],
    nx: i64,
    ny: i64,
    radius_sq: f64,
    step_sq: f64,
}

impl Underside<'_> {
    #[inline(always)]
    fn at(&self, ix: usize, iy: usize, o: Offset) -> f64 {
        let (dx, dy) = (i64::from(o[0]), i64::from(o[1]));
        let depth_sq = self.radius_sq - (dx * dx + dy * dy) as f64 * self.step_sq;
        let (x, y) = (ix as i64 + dx, iy as i64 + dy);
        if depth_sq < 0.0 || x < 0 || y < 0 || x >= self.nx || y >= self.ny {
            return f64::INFINITY;
        }
        let c = self.center_z[(y * self.nx + x) as usize];
        if c == f64::NEG_INFINITY {
            f64::INFINITY
        } else {
            c - depth_sq.sqrt()
        }
    }

    /// Walks downhill over the nodes until none of the eight around is better.
    #[inline]
    fn descend(&self, ix: usize, iy: usize, offset: &mut Offset, value: &mut f64) {
        loop {
            let from = *offset;
            for d in AROUND {
                let o = [from[0] + d[0], from[1] + d[1]];
                let v = self.at(ix, iy, o);
                if v < *value - TIE {
                    *value = v;
                    *offset = o;
                }
            }
            if *offset == from {
                return;
            }
        }
    }
}

impl<'a> Search<'a> {
    fn underside(&self) -> Underside<'a> {
        Underside {
            center_z: self.center_z,
            nx: self.lattice.nx as i64,
            ny: self.lattice.ny as i64,
            radius_sq: self.radius_sq,
            step_sq: self.step_sq,
        }
    }

    /// Each node offers itself to its own cell and to the cell its contact falls in.
    fn seeded(lattice: &'a Lattice, radius: f64, nodes: &'a Nodes) -> Search<'a> {
        let mut s = Search {
            lattice,
            center_z: &nodes.center_z,
            radius_sq: radius * radius,
            step_sq: lattice.step * lattice.step,
            offset: vec![[NONE; 2]; lattice.len()],
            value: vec![f64::INFINITY; lattice.len()],
        };
        let f = s.underside();
        for iy in 0..lattice.ny {
            for ix in 0..lattice.nx {
                let i = lattice.index(ix, iy);
                let v = f.at(ix, iy, [0, 0]);
                if v < f64::INFINITY {
                    s.value[i] = v;
                    s.offset[i] = [0, 0];
                }
            }
        }
        for iy in 0..lattice.ny {
            for ix in 0..lattice.nx {
                let i = lattice.index(ix, iy);
                if s.center_z[i] == f64::NEG_INFINITY {
                    continue;
                }
                let n = nodes.normal[i];
                let px = lattice.x(ix) - radius * f64::from(n[0]);
                let py = lattice.y(iy) - radius * f64::from(n[1]);
                if let Some((jx, jy)) = lattice.nearest(px, py) {
                    let o = [
                        (ix as i64 - jx as i64) as i16,
                        (iy as i64 - jy as i64) as i16,
                    ];
                    let v = f.at(jx, jy, o);
                    let j = lattice.index(jx, jy);
                    // On a sharp edge many balls touch the same cell: the one straight above it stays, not by rounding.
                    if v < s.value[j] - TIE {
                        s.value[j] = v;
                        s.offset[j] = o;
                    }
                }
            }
        }
        s
    }

    /// A forward and a backward raster in each band of rows. Bands are of fixed height: their number of threads is no input.
    fn spread_in_bands(&mut self) {
        let f = self.underside();
        let nx = self.lattice.nx;
        if nx == 0 {
            return;
        }
        self.offset
            .par_chunks_mut(BAND_ROWS * nx)
            .zip(self.value.par_chunks_mut(BAND_ROWS * nx))
            .enumerate()
            .for_each(|(band, (offset, value))| {
                let rows = offset.len() / nx;
                let mut pull = |ix: usize, row: usize, d: [i16; 2]| {
                    let (jx, jrow) = (ix as i64 + i64::from(d[0]), row as i64 + i64::from(d[1]));
                    if jx < 0 || jrow < 0 || jx >= nx as i64 || jrow >= rows as i64 {
                        return;
                    }
                    let from = offset[jrow as usize * nx + jx as usize];
                    if from[0] == NONE {
                        return;
                    }
                    let o = [from[0] + d[0], from[1] + d[1]];
                    let v = f.at(ix, band * BAND_ROWS + row, o);
                    let i = row * nx + ix;
                    if v < value[i] - TIE {
                        value[i] = v;
                        offset[i] = o;
                    }
                };
                for row in 0..rows {
                    for ix in 0..nx {
                        for d in [[-1, 0], [-1, -1], [0, -1], [1, -1]] {
                            pull(ix, row, d);
                        }
                    }
                }
                for row in (0..rows).rev() {
                    for ix in (0..nx).rev() {
                        for d in [[1, 0], [1, 1], [0, 1], [-1, 1]] {
                            pull(ix, row, d);
                        }
                    }
                }
            });
    }

    fn descend(&mut self) {
        let f = self.underside();
        let nx = self.lattice.nx.max(1);
        self.offset
            .par_chunks_mut(nx)
            .zip(self.value.par_chunks_mut(nx))
            .enumerate()
            .for_each(|(iy, (offset, value))| {
                for ix in 0..offset.len() {
                    if offset[ix][0] != NONE {
                        f.descend(ix, iy, &mut offset[ix], &mut value[ix]);
                    }
                }
            });
    }

    /// Rounds of asking the eight neighbours, each from the state before the round, until nothing improves.
    fn settle(&mut self) {
        let f = self.underside();
        let lattice = self.lattice;
        let (nx, ny) = (lattice.nx, lattice.ny);
        let mut active = vec![true; lattice.len()];
        // A candidate travels at most one radius from its node; the bound is for safety, not for speed.
        let rounds = 4 * (nx + ny) + 16;
        for _ in 0..rounds {
            let updates: Vec<Vec<(u32, Offset, f64)>> = (0..ny)
                .into_par_iter()
                .map(|iy| {
                    let mut out = Vec::new();
                    for ix in 0..nx {
                        let i = lattice.index(ix, iy);
                        if !active[i] {
                            continue;
                        }
                        let (mut o, mut v) = (self.offset[i], self.value[i]);
                        for d in AROUND {
                            let (jx, jy) =
                                (ix as i64 + i64::from(d[0]), iy as i64 + i64::from(d[1]));
                            if jx < 0 || jy < 0 || jx >= nx as i64 || jy >= ny as i64 {
                                continue;
                            }
                            let from = self.offset[jy as usize * nx + jx as usize];
                            if from[0] == NONE {
                                continue;
                            }
                            let c = [from[0] + d[0], from[1] + d[1]];
                            if c == o {
                                continue;
                            }
                            let w = f.at(ix, iy, c);
                            if w < v - TIE {
                                v = w;
                                o = c;
                            }
                        }
                        if v < self.value[i] {
                            f.descend(ix, iy, &mut o, &mut v);
                            out.push((i as u32, o, v));
                        }
                    }
                    out
                })
                .collect();
            active.fill(false);
            let mut any = false;
            for (i, o, v) in updates.into_iter().flatten() {
                any = true;
                let i = i as usize;
                self.offset[i] = o;
                self.value[i] = v;
                let (ix, iy) = lattice.cell(i);
                for jy in iy.saturating_sub(1)..(iy + 2).min(ny) {
                    active[jy * nx + ix.saturating_sub(1)..jy * nx + (ix + 2).min(nx)].fill(true);
                }
            }
            if !any {
                return;
            }
        }
    }

    /// Takes the lattice's own error out, and proves the answer: nothing reaches below the part, so a cell whose underside lies
    /// on the part is done; any other is compared with every ball that could be lower, by blocks. Returns heights, nodes and
    /// vertical components of the normals.
    fn refined(
        self,
        part_z: &[f64],
        extras: &[Extra],
        near: &[bool],
    ) -> (Vec<f64>, Vec<u32>, Vec<f32>) {
        let f = self.underside();
        let lattice = self.lattice;
        let n = lattice.len();
        let mut value = self.value;
        let offset = self.offset;
        let mut by = vec![u32::MAX; n];
        let mut normal_z = vec![0.0f32; n];
        let nx = lattice.nx.max(1);
        let radius_sq = self.radius_sq;
        let radius = radius_sq.sqrt();
        let blocks = Blocks::new(lattice, self.center_z, extras);
        let step = lattice.step;
        value
            .par_chunks_mut(nx)
            .zip(by.par_chunks_mut(nx))
            .zip(normal_z.par_chunks_mut(nx))
            .enumerate()
            .for_each(|(iy, ((value, by), normal_z))| {
                for ix in 0..value.len() {
                    let o = offset[iy * nx + ix];
                    if o[0] == NONE {
                        continue;
                    }
                    let q = lattice.center(ix, iy);
                    let node =
                        (ix as i64 + i64::from(o[0])) + (iy as i64 + i64::from(o[1])) * nx as i64;
                    let refine = |best: Best| -> Best {
                        let mut best = best;
                        if near[best.node] {
                            while let Some(b) =
                                best_extra(extras, near, lattice, best.node, &q, radius_sq)
                            {
                                if b.value >= best.value {
                                    break;
                                }
                                best = b;
                            }
                            return best;
                        }
                        let (jx, jy) = lattice.cell(best.node);
                        let o = [
                            (jx as i64 - ix as i64) as i16,
                            (jy as i64 - iy as i64) as i16,
                        ];
                        if let Some((less, sx, sy)) = quadratic(&f, ix, iy, o, best.value) {
                            best.value -= less;
                            best.plan_sq = ((f64::from(o[0]) + sx).powi(2)
                                + (f64::from(o[1]) + sy).powi(2))
                                * step
                                * step;
                        }
                        best
                    };
                    let normal = |b: &Best| (radius_sq - b.plan_sq).max(0.0).sqrt() / radius;
                    let plan = |o: Offset| f64::from(o[0]).powi(2) + f64::from(o[1]).powi(2);
                    let mut best = refine(Best {
                        node: node as usize,
                        value: value[ix],
                        plan_sq: plan(o) * step * step,
                    });
                    let above = best.value - part_z[iy * nx + ix];
                    if above * normal(&best) > PROVEN
                        && let Some(better) =
                            blocks.below(lattice, self.center_z, extras, &q, radius_sq, best.value)
                    {
                        let better = refine(better);
                        if better.value < best.value {
                            best = better;
                        }
                    }
                    value[ix] = best.value;
                    by[ix] = best.node as u32;
                    normal_z[ix] = normal(&best) as f32;
                }
            });
        (value, by, normal_z)
    }
}

/// A cell is on the part when its reachable height is within this much of it, along the normal, mm.
const PROVEN: f64 = 2e-4;

/// The ball that is best for a cell so far.
#[derive(Clone, Copy)]
struct Best {
    node: usize,
    value: f64,
    /// Squared distance of the ball's centre from the cell in plan.
    plan_sq: f64,
}

/// Lowest centres of squares of nodes, extra balls included: what a whole square could do for a cell at best.
struct Blocks {
    nx: usize,
    low: Vec<f64>,
    has_extras: Vec<bool>,
    coarse_nx: usize,
    coarse_ny: usize,
    coarse_low: Vec<f64>,
}

const BLOCK: usize = 8;

impl Blocks {
    fn new(lattice: &Lattice, center_z: &[f64], extras: &[Extra]) -> Blocks {
        let (nx, ny) = (lattice.nx.div_ceil(BLOCK), lattice.ny.div_ceil(BLOCK));
        let (coarse_nx, coarse_ny) = (nx.div_ceil(BLOCK), ny.div_ceil(BLOCK));
        let mut b = Blocks {
            nx,
            low: vec![f64::INFINITY; nx * ny],
            has_extras: vec![false; nx * ny],
            coarse_nx,
            coarse_ny,
            coarse_low: vec![f64::INFINITY; coarse_nx * coarse_ny],
        };
        for (i, &c) in center_z.iter().enumerate() {
            if c > f64::NEG_INFINITY {
                let (ix, iy) = lattice.cell(i);
                let low = &mut b.low[iy / BLOCK * nx + ix / BLOCK];
                *low = low.min(c);
            }
        }
        for e in extras {
            let (ix, iy) = lattice.cell(e.owner as usize);
            let i = iy / BLOCK * nx + ix / BLOCK;
            b.low[i] = b.low[i].min(e.center.z);
            b.has_extras[i] = true;
        }
        for (i, &low) in b.low.iter().enumerate() {
            let c = &mut b.coarse_low[i / nx / BLOCK * coarse_nx + i % nx / BLOCK];
            *c = c.min(low);
        }
        b
    }

    /// The best ball of all whose underside over q is below `value`.
    fn below(
        &self,
        lattice: &Lattice,
        center_z: &[f64],
        extras: &[Extra],
        q: &Point2,
        radius_sq: f64,
        value: f64,
    ) -> Option<Best> {
        let step = lattice.step;
        let radius = radius_sq.sqrt();
        let mut best: Option<Best> = None;
        let mut limit = value;
        // The least underside a square of `side` nodes (and the extra balls up to one step beyond) could have.
        let bound = |bx: usize, by: usize, side: usize, low: f64| {
            let gap =
                |v: f64, first: f64| (first - v).max(v - (first + side as f64 * step)).max(0.0);
            let dx = gap(q.x, lattice.x(bx * side));
            let dy = gap(q.y, lattice.y(by * side));
            let depth_sq = radius_sq - dx * dx - dy * dy;
            if depth_sq < 0.0 {
                f64::INFINITY
            } else {
                low - depth_sq.sqrt()
            }
        };
        let range = |v: f64, origin: f64, n: usize, side: usize| {
            let at = |w: f64| ((w - origin) / step / side as f64).floor();
            let lo = at(v - radius - step).max(0.0) as usize;
            let hi = at(v + radius).max(0.0) as usize;
            lo..(hi + 1).min(n)
        };
        let side = BLOCK * BLOCK;
        for cy in range(q.y, lattice.origin.y, self.coarse_ny, side) {
            for cx in range(q.x, lattice.origin.x, self.coarse_nx, side) {
                if bound(cx, cy, side, self.coarse_low[cy * self.coarse_nx + cx]) >= limit {
                    continue;
                }
                for by in cy * BLOCK..((cy + 1) * BLOCK).min(self.low.len() / self.nx) {
                    for bx in cx * BLOCK..((cx + 1) * BLOCK).min(self.nx) {
                        let block = by * self.nx + bx;
                        if bound(bx, by, BLOCK, self.low[block]) >= limit {
                            continue;
                        }
                        let xs = bx * BLOCK..((bx + 1) * BLOCK).min(lattice.nx);
                        for iy in by * BLOCK..((by + 1) * BLOCK).min(lattice.ny) {
                            let mut offer = |node: usize, x: f64, y: f64, c: f64| {
                                let plan_sq = (x - q.x).powi(2) + (y - q.y).powi(2);
                                if plan_sq > radius_sq || c == f64::NEG_INFINITY {
                                    return;
                                }
                                let v = c - (radius_sq - plan_sq).sqrt();
                                if v < limit {
                                    limit = v;
                                    best = Some(Best {
                                        node,
                                        value: v,
                                        plan_sq,
                                    });
                                }
                            };
                            for ix in xs.clone() {
                                let i = lattice.index(ix, iy);
                                offer(i, lattice.x(ix), lattice.y(iy), center_z[i]);
                            }
                            if self.has_extras[block] {
                                let (first, last) = (
                                    lattice.index(xs.start, iy) as u32,
                                    lattice.index(xs.end, iy) as u32,
                                );
                                let start = extras.partition_point(|e| e.owner < first);
                                for e in extras[start..].iter().take_while(|e| e.owner < last) {
                                    offer(e.owner as usize, e.center.x, e.center.y, e.center.z);
                                }
                            }
                        }
                    }
                }
            }
        }
        best
    }
}

/// The quadratic through the nine undersides around a node that is the lowest of them: how much lower its minimum is, and where
/// (in steps). `None` where a neighbour is missing or the fit has no minimum within half a step or so.
fn quadratic(f: &Underside, ix: usize, iy: usize, o: Offset, v: f64) -> Option<(f64, f64, f64)> {
    let at = |dx: i16, dy: i16| f.at(ix, iy, [o[0] + dx, o[1] + dy]);
    let (l, r, d, u) = (at(-1, 0), at(1, 0), at(0, -1), at(0, 1));
    let (ld, rd, lu, ru) = (at(-1, -1), at(1, -1), at(-1, 1), at(1, 1));
    if ![l, r, d, u, ld, rd, lu, ru].iter().all(|w| w.is_finite()) {
        return None;
    }
    let (gx, gy) = (0.5 * (r - l), 0.5 * (u - d));
    let (xx, yy, xy) = (r - 2.0 * v + l, u - 2.0 * v + d, 0.25 * (ru - rd - lu + ld));
    let det = xx * yy - xy * xy;
    if !(xx > 0.0 && yy > 0.0 && det > 1e-3 * xx * yy) {
        return None;
    }
    let sx = -(yy * gx - xy * gy) / det;
    let sy = -(xx * gy - xy * gx) / det;
    if sx.abs() > 0.75 || sy.abs() > 0.75 {
        return None;
    }
    Some(((-0.5 * (gx * sx + gy * sy)).max(0.0), sx, sy))
}

/// A resting ball off the lattice, on a crease; `owner` is the node at one end of the lattice edge it was found on.
struct Extra {
    owner: u32,
    center: Point,
}

/// Where a lattice edge crosses a crease, the two resting balls on either side of it.
fn creases(drop: &DropCutter, lattice: &Lattice, nodes: &Nodes) -> Vec<Extra> {
    // A turn of the normal by this much within a step, towards itself, leaves step * turn / 4 (0.6 um) unseen by the lattice.
    let turn = (0.0025 / lattice.step).clamp(0.01, 0.5);
    let (nx, ny) = (lattice.nx, lattice.ny);
    let z_of = |n: [f32; 2]| f64::from((1.0 - n[0] * n[0] - n[1] * n[1]).max(0.0)).sqrt();
    let rows: Vec<Vec<Extra>> = (0..ny)
        .into_par_iter()
        .map(|iy| {
            let mut out = Vec::new();
            for ix in 0..nx {
                let a = lattice.index(ix, iy);
                for (jx, jy) in [(ix + 1, iy), (ix, iy + 1)] {
                    if jx >= nx || jy >= ny {
                        continue;
                    }
                    let b = lattice.index(jx, jy);
                    let (za, zb) = (nodes.center_z[a], nodes.center_z[b]);
                    if za == f64::NEG_INFINITY || zb == f64::NEG_INFINITY {
                        continue;
                    }
                    let (na, nb) = (nodes.normal[a], nodes.normal[b]);
                    let d = [
                        f64::from(nb[0] - na[0]),
                        f64::from(nb[1] - na[1]),
                        z_of(nb) - z_of(na),
                    ];
                    let turned_sq = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                    let (dx, dy) = (lattice.x(jx) - lattice.x(ix), lattice.y(jy) - lattice.y(iy));
                    let towards = d[0] * dx + d[1] * dy + d[2] * (zb - za) < 0.0;
                    if turned_sq > turn * turn && towards {
                        bisect(drop, lattice, a, [dx, dy], &mut out);
                    }
                }
            }
            out
        })
        .collect();
    rows.into_iter().flatten().collect()
}

fn bisect(drop: &DropCutter, lattice: &Lattice, a: usize, d: [f64; 2], out: &mut Vec<Extra>) {
    let from = lattice.center_at(a);
    let at = |t: f64| drop.drop(from.x + t * d[0], from.y + t * d[1]);
    let (Some(mut lo), Some(mut hi)) = (at(0.0), at(1.0)) else {
        return;
    };
    let (mut t_lo, mut t_hi) = (0.0, 1.0);
    let apart = |p: &Contact, q: &Contact| {
        let (u, v) = (unit(p), unit(q));
        (0..3).map(|k| (u[k] - v[k]).powi(2)).sum::<f64>()
    };
    // 2^-10 of a step: below 0.1 um.
    for _ in 0..10 {
        let t = 0.5 * (t_lo + t_hi);
        let Some(mid) = at(t) else { return };
        if apart(&lo, &mid) <= apart(&mid, &hi) {
            (lo, t_lo) = (mid, t);
        } else {
            (hi, t_hi) = (mid, t);
        }
    }
    for c in [lo, hi] {
        out.push(Extra {
            owner: a as u32,
            center: c.center,
        });
    }
}

/// Marks the nodes with an extra ball on an edge of theirs or of one of the eight around.
fn near_extras(lattice: &Lattice, extras: &[Extra]) -> Vec<bool> {
    let mut near = vec![false; lattice.len()];
    for e in extras {
        let (ix, iy) = lattice.cell(e.owner as usize);
        for jy in iy.saturating_sub(1)..(iy + 2).min(lattice.ny) {
            for jx in ix.saturating_sub(1)..(ix + 2).min(lattice.nx) {
                near[lattice.index(jx, jy)] = true;
            }
        }
    }
    near
}

/// The best of the extra balls on edges of a node and of the eight around.
fn best_extra(
    extras: &[Extra],
    near: &[bool],
    lattice: &Lattice,
    node: usize,
    q: &Point2,
    radius_sq: f64,
) -> Option<Best> {
    if !near[node] {
        return None;
    }
    let (ix, iy) = lattice.cell(node);
    let mut best: Option<Best> = None;
    for jy in iy.saturating_sub(1)..(iy + 2).min(lattice.ny) {
        let first = lattice.index(ix.saturating_sub(1), jy) as u32;
        let last = lattice.index((ix + 1).min(lattice.nx - 1), jy) as u32;
        let start = extras.partition_point(|e| e.owner < first);
        for e in extras[start..].iter().take_while(|e| e.owner <= last) {
            let plan_sq = (e.center.x - q.x).powi(2) + (e.center.y - q.y).powi(2);
            if plan_sq <= radius_sq {
                let value = e.center.z - (radius_sq - plan_sq).sqrt();
                if best.is_none_or(|b| value < b.value) {
                    best = Some(Best {
                        node: e.owner as usize,
                        value,
                        plan_sq,
                    });
                }
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use proptest::prelude::*;

    fn grid_mesh(n: usize, size: f64, z: impl Fn(f64, f64) -> f64) -> Mesh {
        let at = |i: usize, j: usize| {
            let (x, y) = (size * i as f64 / n as f64, size * j as f64 / n as f64);
            Point::new(x, y, z(x, y))
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

    /// Against brute force over all nodes, along the normal: how much too high at worst (must be nothing but what the
    /// proof leaves open), and how many cells have any such excess over 0.01 um.
    fn excess(mesh: &Mesh, radius: f64, step: f64) -> (f64, usize, usize) {
        let drop = DropCutter::new(mesh, radius);
        let r = reachable(&drop, step);
        let nodes = sample(&drop, &r.lattice);
        let s = Search::seeded(&r.lattice, radius, &nodes);
        let f = s.underside();
        let k = (radius / step).ceil() as i16;
        let over: Vec<f64> = (0..r.lattice.len())
            .into_par_iter()
            .filter(|&i| !r.part_z[i].is_nan())
            .map(|i| {
                let (ix, iy) = r.lattice.cell(i);
                let mut best = f64::INFINITY;
                for dy in -k..=k {
                    for dx in -k..=k {
                        best = best.min(f.at(ix, iy, [dx, dy]));
                    }
                }
                assert!(r.reach_z[i] >= r.part_z[i] - 0.02, "never into the part");
                (r.reach_z[i] - best) * f64::from(r.normal_z[i])
            })
            .collect();
        (
            over.iter().copied().fold(0.0, f64::max),
            over.iter().filter(|v| **v > 1e-5).count(),
            over.len(),
        )
    }

    fn rough(seed: u64) -> Mesh {
        let h = |i: u64, j: u64| {
            let mut v = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (i * 7919 + j * 104_729);
            v ^= v >> 31;
            v = v.wrapping_mul(0xbf58_476d_1ce4_e5b9);
            v ^= v >> 29;
            (v % 1000) as f64 / 1000.0
        };
        match seed % 3 {
            0 => grid_mesh(24, 12.0, |x, y| {
                (4.0 * h((x / 2.5) as u64, (y / 2.5) as u64)).floor()
            }),
            1 => grid_mesh(16, 10.0, |x, y| {
                if h((x * 8.0) as u64, (y * 8.0) as u64) > 0.93 {
                    4.0
                } else {
                    0.0
                }
            }),
            _ => grid_mesh(20, 12.0, |x, y| {
                (x * 0.9 + h(0, 0)).sin() * (y * 0.8).cos() * 3.0 * h(1, 1)
            }),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn search_equals_brute_force_on_rough_ground(seed in 0u64..1_000_000) {
            // Steps, spikes and bumps by turns.
            let (worst, _, _) = excess(&rough(seed), 2.0, 0.1);
            prop_assert!(worst < 2.1e-4, "{worst}");
        }

        #[test]
        fn search_equals_brute_force_on_soups(corners in prop::collection::vec((0.0..8.0f64, 0.0..8.0f64, 0.0..4.0f64, -2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64), 1..30)) {
            let mut mesh = Mesh::default();
            for (x, y, z, a, b, c, d) in corners {
                mesh.triangles.push([Point::new(x, y, z), Point::new(x + a, y + b, z + c), Point::new(x + c, y + d, z + a)]);
            }
            let (worst, _, _) = excess(&mesh, 1.5, 0.1);
            prop_assert!(worst < 2.1e-4, "{worst}");
        }
    }

    #[test]
    #[ignore = "a measurement: run with --ignored --nocapture"]
    fn quality() {
        for seed in 0..12u64 {
            let (max, over, of) = excess(&rough(seed), 2.0, 0.1);
            eprintln!(
                "seed {seed}: at most {:.3} um over brute force, {over} of {of} over 0.01 um",
                max * 1e3
            );
        }
    }

    /// Where the ball fits, the reachable surface is the part, to a fraction of a micrometre, flat or sloping.
    #[test]
    fn slopes_are_reached() {
        for slope in [0.0, 0.3, 1.0, 2.0] {
            let mesh = grid_mesh(1, 12.0, |x, y| slope * (0.8 * x + 0.6 * y));
            let r = reachable(&DropCutter::new(&mesh, 3.0), 0.05);
            let n = 1.0 / (1.0f64 + slope * slope).sqrt();
            let mut judged = 0;
            for i in 0..r.lattice.len() {
                if r.part_z[i].is_nan() {
                    continue;
                }
                judged += 1;
                let rest = r.rest(i);
                assert!((-2e-4..1e-4).contains(&rest), "slope {slope}: {rest}");
                let c = r.lattice.center_at(i);
                if c.x.min(c.y) > 0.3 && c.x.max(c.y) < 11.7 {
                    assert!((f64::from(r.normal_z[i]) - n).abs() < 2e-3);
                }
            }
            assert!(judged > 200 * 200);
        }
    }

    /// A bowl of radius 5 is reached by a ball of 3; one of radius 2 is not: there the ball rests on the rim.
    #[test]
    fn bowls() {
        let bowl = |b: f64| {
            grid_mesh(300, 12.0, move |x, y| {
                let d = (x - 6.0).powi(2) + (y - 6.0).powi(2);
                if d < b * b * 0.75 {
                    b * 0.5 - (b * b - d).sqrt()
                } else {
                    0.0
                }
            })
        };
        let r = reachable(&DropCutter::new(&bowl(4.5), 3.0), 0.05);
        let (ix, iy) = r.lattice.nearest(6.0, 6.0).unwrap();
        assert!(r.rest(r.lattice.index(ix, iy)).abs() < 2e-3);
        let r = reachable(&DropCutter::new(&bowl(2.0), 3.0), 0.05);
        // Rim radius sqrt(3), ball 3: the ball hangs 3 - sqrt(9 - 3) below the plane.
        let depth = 3.0 - 6.0f64.sqrt();
        let z = r.reach_z[r.lattice.index(ix, iy)];
        assert!((z + depth).abs() < 0.02, "{z}");
        assert!((r.part_z[r.lattice.index(ix, iy)] + 1.0).abs() < 1e-3);
    }

    /// In a right-angled valley the ball stands R sqrt(2) above the line; over the line it leaves R (sqrt(2) - 1), at any place
    /// and direction of the lattice: the crease is found between the nodes.
    #[test]
    fn valley_is_exact_between_the_nodes() {
        let (r, step) = (3.0, 0.1);
        for turn in [0.0f64, 0.4, 0.79, 1.3] {
            for shift in [0.0, 0.013, 0.049] {
                let (c, s) = (turn.cos(), turn.sin());
                let p = |along: f64, across: f64| {
                    Point::new(
                        c * along - s * across + shift,
                        s * along + c * across,
                        across.abs(),
                    )
                };
                let (a, b, d, e) = (p(-9.0, 0.0), p(9.0, 0.0), p(9.0, 8.0), p(-9.0, 8.0));
                let (f, g) = (p(9.0, -8.0), p(-9.0, -8.0));
                let mesh = Mesh {
                    triangles: vec![[a, b, d], [a, d, e], [a, g, f], [a, f, b]],
                };
                let m = reachable(&DropCutter::new(&mesh, r), step);
                for i in 0..m.lattice.len() {
                    let q = m.lattice.center_at(i);
                    let (x, y) = (q.x - shift, q.y);
                    let (along, across) = (c * x + s * y, c * y - s * x);
                    if along.abs() > 4.0 || across.abs() > 4.0 {
                        continue;
                    }
                    let want = if across.abs() < r / 2f64.sqrt() {
                        r * 2f64.sqrt() - (r * r - across * across).sqrt()
                    } else {
                        across.abs()
                    };
                    let error = (m.reach_z[i] - want) * f64::from(m.normal_z[i]);
                    assert!(
                        (-1e-4..1.2e-3).contains(&error),
                        "{turn} {shift} {q:?}: {error}"
                    );
                }
            }
        }
    }

    #[test]
    fn same_bits_for_any_number_of_threads_and_empty_parts() {
        let mesh = grid_mesh(40, 15.0, |x, y| (x * 0.8).sin() * 2.0 + (x - y).abs() * 0.3);
        let drop = DropCutter::new(&mesh, 2.0);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let r = pool.install(|| reachable(&drop, 0.1));
            (
                r.reach_z.iter().map(|z| z.to_bits()).collect::<Vec<_>>(),
                r.by,
                r.normal_z,
            )
        };
        assert_eq!(run(1), run(3));
        let none = reachable(&DropCutter::new(&Mesh::default(), 2.0), 0.1);
        assert!(none.lattice.is_empty() && none.reach_z.is_empty());
    }

    #[test]
    #[ignore = "a measurement: run with --ignored --nocapture"]
    fn speed() {
        let mesh = grid_mesh(120, 65.0, |x, y| {
            6.0 * (x * 0.12).sin() * (y * 0.1).cos() + 0.4 * (x - y).abs()
        });
        let drop = DropCutter::new(&mesh, 3.0);
        let lattice = lattice_for(&drop.bounds(), 3.0, 0.05);
        let t = std::time::Instant::now();
        let nodes = sample(&drop, &lattice);
        eprintln!(
            "{} x {} nodes, drops {:?}",
            lattice.nx,
            lattice.ny,
            t.elapsed()
        );
        let t = std::time::Instant::now();
        let mut s = Search::seeded(&lattice, 3.0, &nodes);
        eprintln!("seeded {:?}", t.elapsed());
        s.spread_in_bands();
        eprintln!("spread {:?}", t.elapsed());
        s.descend();
        eprintln!("descended {:?}", t.elapsed());
        s.settle();
        eprintln!("settled {:?}", t.elapsed());
        let extras = creases(&drop, &lattice, &nodes);
        let near = near_extras(&lattice, &extras);
        eprintln!("{} extras {:?}", extras.len(), t.elapsed());
        let _ = s.refined(&nodes.part_z, &extras, &near);
        eprintln!("refined {:?}", t.elapsed());
    }
}
