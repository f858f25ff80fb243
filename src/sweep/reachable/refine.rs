//! The reachable height of each cell of a window, from the resting balls on the nodes around.

use super::blocks::Blocks;
use super::crease::{Extra, best_extra, creases, near_extras};
use super::underside::{NONE, Offset, Underside};
use super::{ALIGNED, Reachable};
use crate::geom::Point2;
use crate::reach::{DropCutter, Heights};
use crate::sweep::Lattice;
use std::ops::Range;

/// One resting ball per node, over a window and one radius around it; and those between the nodes on creases.
pub(super) struct Nodes {
    /// The nodes.
    pub(super) lattice: Lattice,
    /// Column and row of the first node in the whole lattice.
    pub(super) first: [usize; 2],
    pub(super) radius: f64,
    pub(super) balls: Heights,
    pub(super) extras: Vec<Extra>,
    near: Vec<bool>,
}

/// A cell is on the part when its reachable height is within this much of it, along the normal, mm.
const PROVEN: f64 = 2e-4;
/// The ball that touches the part at a cell is admissible when the centre surface, taken straight between the nodes, is this little
/// above its centre, along the normal, mm. (Straight is too low over ground that falls away as sharply as an edge, by
/// step^2 / (4 R), 0.1 um.)
const ADMISSIBLE: f64 = 1e-4;
/// Cells of a square that is proven together.
const SQUARE: usize = 8;

/// The ball that is best for a cell so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) node: usize,
    pub(super) value: f64,
    /// Squared distance of the ball's centre from the cell in plan.
    pub(super) plan_sq: f64,
}

/// A cell whose own ball is not admissible.
struct Hard {
    /// In the window.
    cell: usize,
    /// Column and row among the nodes.
    at: [usize; 2],
    best: Best,
}

impl Nodes {
    /// Drops the ball on every node that can matter for some columns and rows of a lattice.
    pub(super) fn around(
        drop: &DropCutter,
        whole: &Lattice,
        columns: &Range<usize>,
        rows: &Range<usize>,
    ) -> Nodes {
        let radius = drop.radius();
        let far = (radius / whole.step).ceil() as usize + 3;
        let wider = |r: &Range<usize>, n: usize| {
            r.start.saturating_sub(far) / ALIGNED * ALIGNED..(r.end + far).min(n)
        };
        let (columns, rows) = (wider(columns, whole.nx), wider(rows, whole.ny));
        let lattice = whole.window(columns.clone(), rows.clone());
        let balls = drop.drop_all(&lattice);
        let extras = creases(drop, &lattice, &balls);
        let near = near_extras(&lattice, &extras);
        Nodes {
            lattice,
            first: [columns.start, rows.start],
            radius,
            balls,
            extras,
            near,
        }
    }

    /// Fills in heights, nodes and normals of the cells of `out`, whose first cell has this column and row in the whole lattice.
    /// `top`: the part over them.
    pub(super) fn reached(&self, top: &Heights, first: [usize; 2], out: &mut Reachable) {
        let mut blocks = Blocks::new(&self.lattice);
        let f = Underside::new(&self.lattice, &self.balls.z, self.radius);
        let (nx, ny) = (out.lattice.nx, out.lattice.ny);
        let shift = [first[0] - self.first[0], first[1] - self.first[1]];
        let mut hard: Vec<Hard> = Vec::new();
        // Squares of cells, at whole multiples of their size in the whole lattice.
        let squares = |first: usize, n: usize| {
            (first / SQUARE..(first + n).div_ceil(SQUARE)).map(move |k| {
                (k * SQUARE).max(first) - first..((k + 1) * SQUARE).min(first + n) - first
            })
        };
        for rows in squares(first[1], ny) {
            for columns in squares(first[0], nx) {
                hard.clear();
                let mut last: Option<([usize; 2], usize)> = None;
                for iy in rows.clone() {
                    for ix in columns.clone() {
                        let cell = iy * nx + ix;
                        if top.z[cell] == f64::NEG_INFINITY {
                            continue;
                        }
                        let at = [ix + shift[0], iy + shift[1]];
                        if self.easy(top, cell, at, out) {
                            continue;
                        }
                        if let Some(h) = self.walked(&f, top, cell, at, last) {
                            last = Some((at, h.best.node));
                            hard.push(h);
                        }
                    }
                }
                if !hard.is_empty() {
                    self.proven(&f, &mut blocks, top, &mut hard);
                    for h in &hard {
                        out.reach_z[h.cell] = h.best.value;
                        out.by[h.cell] = self.offset(h.at, h.best.node);
                        out.normal_z[h.cell] = self.normal(&h.best) as f32;
                    }
                }
            }
        }
    }

    /// Where the ball that touches the part at a cell has its centre, in plan and along Z.
    fn own(&self, top: &Heights, cell: usize, at: [usize; 2]) -> (Point2, f64, f64) {
        let n = top.normal[cell].map(f64::from);
        let nz = (1.0 - n[0] * n[0] - n[1] * n[1]).max(0.0).sqrt();
        let q = self.lattice.center(at[0], at[1]);
        (
            Point2::new(q.x + self.radius * n[0], q.y + self.radius * n[1]),
            top.z[cell] + self.radius * nz,
            nz,
        )
    }

    /// A cell whose own ball is admissible is reached; false when that is not sure.
    fn easy(&self, top: &Heights, cell: usize, at: [usize; 2], out: &mut Reachable) -> bool {
        let l = &self.lattice;
        let (c, z, nz) = self.own(top, cell, at);
        let (fx, fy) = ((c.x - l.origin.x) / l.step, (c.y - l.origin.y) / l.step);
        if !(fx >= 0.0 && fy >= 0.0) {
            return false;
        }
        let (ix, iy) = (fx as usize, fy as usize);
        if ix + 1 >= l.nx || iy + 1 >= l.ny {
            return false;
        }
        let (u, v) = (fx - ix as f64, fy - iy as f64);
        let i = l.index(ix, iy);
        let b = &self.balls.z;
        let low = b[i] * (1.0 - u) + b[i + 1] * u;
        let high = b[i + l.nx] * (1.0 - u) + b[i + l.nx + 1] * u;
        let over = low * (1.0 - v) + high * v - z;
        // Over air the centre surface is -inf (or NaN): not sure.
        let sure = over.abs() < 1.0 && over * nz <= ADMISSIBLE;
        if sure {
            out.reach_z[cell] = top.z[cell];
            out.normal_z[cell] = nz as f32;
            out.by[cell] = [
                (ix + usize::from(u > 0.5)) as i16 - at[0] as i16,
                (iy + usize::from(v > 0.5)) as i16 - at[1] as i16,
            ];
        }
        sure
    }

    /// The lowest of some good guesses, walked downhill; `None` where no ball covers the cell at all.
    fn walked(
        &self,
        f: &Underside,
        top: &Heights,
        cell: usize,
        at: [usize; 2],
        last: Option<([usize; 2], usize)>,
    ) -> Option<Hard> {
        let [ix, iy] = at;
        let (c, _, _) = self.own(top, cell, at);
        let own = self
            .lattice
            .nearest(c.x, c.y)
            .map(|(x, y)| [(x as i64 - ix as i64) as i16, (y as i64 - iy as i64) as i16]);
        let last = last.map(|(_, node)| self.offset(at, node));
        let (mut o, mut value): (Offset, f64) = ([NONE; 2], f64::INFINITY);
        for guess in [own, last, Some([0, 0])].into_iter().flatten() {
            let v = f.at(ix, iy, guess);
            if v < value {
                (o, value) = (guess, v);
            }
        }
        if value == f64::INFINITY {
            // Only a ball beside the cell may cover it: any is a beginning.
            (o, value) = self.any(f, at)?;
        }
        f.descend(ix, iy, &mut o, &mut value);
        let plan = f64::from(o[0]).powi(2) + f64::from(o[1]).powi(2);
        let node = self.lattice.index(
            (ix as i64 + i64::from(o[0])) as usize,
            (iy as i64 + i64::from(o[1])) as usize,
        );
        let best = Best {
            node,
            value,
            plan_sq: plan * f.step_sq,
        };
        Some(Hard {
            cell,
            at,
            best: self.refined(f, at, best),
        })
    }

    /// Some node that covers a cell, when the likely ones do not.
    fn any(&self, f: &Underside, at: [usize; 2]) -> Option<(Offset, f64)> {
        let k = (self.radius / self.lattice.step).ceil() as i16;
        (-k..=k)
            .flat_map(|dy| (-k..=k).map(move |dx| [dx, dy]))
            .map(|o| (o, f.at(at[0], at[1], o)))
            .filter(|(_, v)| v.is_finite())
            .reduce(|a, b| if b.1 < a.1 { b } else { a })
    }

    fn offset(&self, at: [usize; 2], node: usize) -> Offset {
        let (jx, jy) = self.lattice.cell(node);
        [
            (jx as i64 - at[0] as i64) as i16,
            (jy as i64 - at[1] as i64) as i16,
        ]
    }

    fn normal(&self, b: &Best) -> f64 {
        (self.radius * self.radius - b.plan_sq).max(0.0).sqrt() / self.radius
    }

    /// Takes the lattice's own error out.
    fn refined(&self, f: &Underside, at: [usize; 2], mut best: Best) -> Best {
        if self.near[best.node] {
            let q = self.lattice.center(at[0], at[1]);
            while let Some(b) = best_extra(
                &self.extras,
                &self.near,
                &self.lattice,
                best.node,
                &q,
                f.radius_sq,
            ) {
                if b.value >= best.value {
                    break;
                }
                best = b;
            }
            return best;
        }
        let o = self.offset(at, best.node);
        if let Some((less, sx, sy)) = f.quadratic(at[0], at[1], o, best.value) {
            best.value -= less;
            best.plan_sq =
                ((f64::from(o[0]) + sx).powi(2) + (f64::from(o[1]) + sy).powi(2)) * f.step_sq;
        }
        best
    }

    /// Nothing reaches below the part, so a cell whose underside lies on the part is done; any other of a square's hard cells is
    /// compared with every ball that could be lower.
    fn proven(&self, f: &Underside, blocks: &mut Blocks, top: &Heights, hard: &mut [Hard]) {
        let open = |h: &Hard| (h.best.value - top.z[h.cell]) * self.normal(&h.best) > PROVEN;
        let asked: Vec<(Point2, f64)> = hard
            .iter()
            .filter(|h| open(h))
            .map(|h| (self.lattice.center(h.at[0], h.at[1]), h.best.value))
            .collect();
        if asked.is_empty() {
            return;
        }
        let likely = blocks.likely(self, &asked);
        for h in hard.iter_mut().filter(|h| open(h)) {
            let q = self.lattice.center(h.at[0], h.at[1]);
            let found = blocks.below(&likely, self, &q, h.best.value);
            if let Some(better) = found {
                let better = self.refined(f, h.at, better);
                if better.value < h.best.value {
                    h.best = better;
                }
            }
        }
    }
}
