//! The stock as it is cut, in program order: what the ball sweeps, and where a rapid meets what still stands.

use super::dry_run::{PartContext, Stock};
use crate::reach::Hint;
use crate::sweep::{Encounter, Lattice, Reachable, Segment, Swept};

/// A straight piece of the way of the ball's centre, work coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    pub segment: Segment,
    pub rapid: bool,
    pub line: usize,
}

/// A rapid that met standing stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    pub line: usize,
    pub encounter: Encounter,
}

/// Height of the stock over each cell of a tile before the first move; `-inf` where there is none.
pub fn stock(part: &PartContext, r: &Reachable, stock: &Stock) -> Vec<f64> {
    let b = part.drop.bounds();
    let around = match *stock {
        Stock::Allowance(mm) => Some(Around::new(part, r, mm)),
        Stock::Block { .. } => None,
    };
    let near = around.as_ref().map_or(Vec::new(), Around::highest);
    (0..r.lattice.len())
        .map(|i| match *stock {
            Stock::Allowance(mm) => {
                if r.part_z[i].is_nan() || !r.reach_z[i].is_finite() {
                    f64::NEG_INFINITY
                } else {
                    // Measured along the normal, so more on slopes; five times as much at most, and nowhere more than this much over
                    // what stands near: the ball's normal on the edge of a wall is not the stock's.
                    let normal_z = f64::from(r.normal_z[i]);
                    let most = (r.reach_z[i] + mm / normal_z.max(0.2)).min(near[i] + mm);
                    // Steep ground mostly bends away: there every place near is asked.
                    match around.as_ref().filter(|_| normal_z < STEEP) {
                        Some(a) => most.min(a.grown(i)),
                        None => most,
                    }
                }
            }
            Stock::Block { top_z } => {
                let c = r.lattice.center_at(i);
                let over = c.x >= b.min.x && c.x <= b.max.x && c.y >= b.min.y && c.y <= b.max.y;
                if over { top_z } else { f64::NEG_INFINITY }
            }
        })
        .collect()
}

/// Where the vertical part of the normal is less, the thickness of an allowance along Z is looked up rather than reckoned from it.
const STEEP: f64 = 0.7;
/// Places asked on either side of one, at most.
const ASKED: usize = 12;

/// What stands over a tile and around it. Beyond the tile, where an allowance is wider than its rim, the lower end of the ball over a
/// place stands for what it leaves there: it is nowhere lower.
struct Around {
    z: Vec<f64>,
    /// Of every so many cells one is asked, for the highest of those around it.
    stride: usize,
    asked: Option<Vec<f64>>,
    /// Columns and rows.
    size: [usize; 2],
    /// Columns and rows of the tile.
    tile: [usize; 2],
    /// Cells before the tile's first.
    more: usize,
    /// Cells that the allowance reaches.
    reach: usize,
    step: f64,
    mm: f64,
}

impl Around {
    fn new(part: &PartContext, r: &Reachable, mm: f64) -> Around {
        let (l, rim) = (&r.lattice, part.reachable.rim());
        let reach = (mm / l.step).ceil().max(0.0) as usize;
        // Cells of the rim itself are another tile's to judge.
        let more = reach.saturating_sub(rim);
        let known = |v: f64| if v.is_finite() { v } else { f64::NEG_INFINITY };
        let (nx, ny) = (l.nx + 2 * more, l.ny + 2 * more);
        let mut hint = Hint::default();
        let radius = part.drop.radius();
        let c = l.center(0, 0);
        let at = |k: usize| (k as f64 - more as f64) * l.step;
        let mut z = Vec::with_capacity(nx * ny);
        for y in 0..ny {
            for x in 0..nx {
                let inside = (more..more + l.nx).contains(&x) && (more..more + l.ny).contains(&y);
                z.push(if inside {
                    known(r.reach_z[(y - more) * l.nx + x - more])
                } else {
                    part.drop
                        .drop_near(c.x + at(x), c.y + at(y), &mut hint)
                        .map_or(f64::NEG_INFINITY, |c| c.center.z - radius)
                });
            }
        }
        let stride = reach.div_ceil(ASKED).max(1);
        Around {
            asked: (stride > 1).then(|| highest_within(nx, ny, &z, stride - 1)),
            stride,
            z,
            size: [nx, ny],
            tile: [l.nx, l.ny],
            more,
            reach,
            step: l.step,
            mm,
        }
    }

    /// The highest within the allowance of each cell of the tile along X and Y.
    fn highest(&self) -> Vec<f64> {
        let ([nx, ny], [tx, ty]) = (self.size, self.tile);
        let wide = highest_within(nx, ny, &self.z, self.reach);
        (0..tx * ty)
            .map(|i| wide[(i / tx + self.more) * nx + i % tx + self.more])
            .collect()
    }

    /// Upper end over a cell of the tile of everything that lies within the allowance of what stands: balls as thick around every place.
    /// A little more where not all places are asked, never less.
    fn grown(&self, i: usize) -> f64 {
        let ([nx, ny], tx) = (self.size, self.tile[0]);
        let (x, y) = (i % tx + self.more, i / tx + self.more);
        let (stride, z) = (self.stride, self.asked.as_ref().unwrap_or(&self.z));
        let slack = std::f64::consts::SQRT_2 * (stride - 1) as f64 * self.step;
        let range = |k: usize, n: usize| {
            let first = k - (k.min(self.reach) / stride) * stride;
            (first..=(k + self.reach).min(n - 1)).step_by(stride)
        };
        let mut top = f64::NEG_INFINITY;
        for v in range(y, ny) {
            for u in range(x, nx) {
                let d = self.step * (u.abs_diff(x) as f64).hypot(v.abs_diff(y) as f64);
                let d = (d - slack).max(0.0);
                if d < self.mm {
                    top = top.max(z[v * nx + u] + (self.mm * self.mm - d * d).sqrt());
                }
            }
        }
        top
    }
}

/// The highest value within `reach` cells along both axes of each cell of a map of nx columns and ny rows.
fn highest_within(nx: usize, ny: usize, z: &[f64], reach: usize) -> Vec<f64> {
    let most = |n: usize, at: &dyn Fn(usize) -> f64, out: &mut dyn FnMut(usize, f64)| {
        // Falling candidates of a sliding window, the highest in front.
        let mut queue: std::collections::VecDeque<(usize, f64)> = std::collections::VecDeque::new();
        for k in 0..n + reach {
            if k < n {
                let v = at(k);
                while queue.back().is_some_and(|b| b.1 <= v) {
                    queue.pop_back();
                }
                queue.push_back((k, v));
            }
            if k >= reach {
                let middle = k - reach;
                while queue.front().is_some_and(|f| f.0 + reach < middle) {
                    queue.pop_front();
                }
                out(middle, queue.front().map_or(f64::NEG_INFINITY, |f| f.1));
            }
        }
    };
    let mut rows = vec![f64::NEG_INFINITY; z.len()];
    for y in 0..ny {
        most(nx, &|x| z[y * nx + x], &mut |x, v| rows[y * nx + x] = v);
    }
    let mut out = vec![f64::NEG_INFINITY; z.len()];
    for x in 0..nx {
        most(ny, &|y| rows[y * nx + x], &mut |y, v| out[y * nx + x] = v);
    }
    out
}

/// Cuts the moves numbered in `which` in order over one tile: what is left, and the rapids that met stock, one for each line at
/// most, in program order. `tolerance`: a rapid may touch the stock this deep, mm.
pub fn cut(
    moves: &[Move],
    which: &[u32],
    lattice: Lattice,
    radius: f64,
    stock: &[f64],
    tolerance: f64,
) -> (Swept, Vec<Collision>) {
    let top = stock.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut swept = Swept::new(lattice);
    let mut collisions = Vec::new();
    let mut waiting: Vec<Segment> = Vec::with_capacity(which.len());
    for m in which.iter().filter_map(|&k| moves.get(k as usize)) {
        if !m.rapid {
            waiting.push(m.segment);
            continue;
        }
        if m.segment.from.z.min(m.segment.to.z) - radius >= top {
            continue;
        }
        swept.cut_alone(&waiting, radius);
        waiting.clear();
        if let Some(encounter) = swept.encounter(stock, m.segment, radius, tolerance) {
            collisions.push(Collision {
                line: m.line,
                encounter,
            });
        }
    }
    swept.cut_alone(&waiting, radius);
    (swept, collisions)
}

/// The deepest collision of each line, in program order; of equals the one nearest the lower left.
pub fn deepest_per_line(mut found: Vec<Collision>) -> Vec<Collision> {
    let key = |c: &Collision| (c.encounter.place.y, c.encounter.place.x);
    found.sort_by(|a, b| {
        let (p, q) = (key(a), key(b));
        a.line
            .cmp(&b.line)
            .then(b.encounter.depth.total_cmp(&a.encounter.depth))
            .then(p.0.total_cmp(&q.0))
            .then(p.1.total_cmp(&q.1))
    });
    found.dedup_by_key(|c| c.line);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point;
    use crate::part::Mesh;
    use crate::reach::DropCutter;
    use crate::sweep::ReachTiles;

    /// What stands on a cell does not depend on where the tiles end, also for an allowance far wider than their rim: beside a tower
    /// the stock on the plain is as high as the tower's own.
    #[test]
    fn stock_beside_a_tower_in_another_tile() {
        let p = Point::new;
        let quad = |a: Point, b: Point, c: Point, d: Point| [[a, b, c], [a, c, d]];
        let mut triangles = quad(
            p(-10.0, -10.0, 0.0),
            p(10.0, -10.0, 0.0),
            p(10.0, 10.0, 0.0),
            p(-10.0, 10.0, 0.0),
        )
        .to_vec();
        triangles.extend(quad(
            p(1.0, -2.0, 6.0),
            p(4.0, -2.0, 6.0),
            p(4.0, 2.0, 6.0),
            p(1.0, 2.0, 6.0),
        ));
        let mesh = Mesh { triangles };
        let drop = DropCutter::new(&mesh, 2.0);
        let one = ReachTiles::new(&drop, 0.1, 2);
        let many = ReachTiles::new(&drop, 0.1, 2).with_side(64);
        assert_eq!(one.len(), 1);
        assert!(many.len() > 4);
        let of = |tiles: &ReachTiles, k: usize| {
            let part = PartContext {
                mesh: &mesh,
                drop: &drop,
                reachable: tiles,
            };
            stock(&part, &tiles.reach(k), &Stock::Allowance(4.0))
        };
        let whole = of(&one, 0);
        let nx = one.lattice().nx;
        let mut beside = 0;
        for k in 0..many.len() {
            let (own, wide, found) = (many.tile(k), many.wide(k), of(&many, k));
            for y in own.rows.clone() {
                for x in own.columns.clone() {
                    let w = wide.columns.len();
                    let v = found[(y - wide.rows.start) * w + x - wide.columns.start];
                    let u = whole[y * nx + x];
                    // The end of the ball beyond the tile's rim may be a little higher than what it leaves.
                    assert!(v >= u - 1e-9 && (v <= u + 2.0 || !u.is_finite()), "{v} {u}");
                    beside += usize::from(u > 5.0);
                }
            }
        }
        assert!(beside > 0);
    }
}
