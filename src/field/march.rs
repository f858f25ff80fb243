//! Fast marching: distance from a seed in a ruler's metric.
//!
//! Each node is updated from the triangles it forms with neighbouring pairs (a, b) that have a value:
//!
//! ```text
//!        x            the triangle is laid flat with the lengths its metric gives;
//!       / \           a *virtual source* s is placed below a-b at the distances phi(a) and phi(b);
//!      /   \          if the straight line s-x crosses a-b, phi(x) = |s x|
//!     a-----b         (exact for a point seed in a constant metric: C. Novotni, R. Klein, WSCG 2002)
//!       \ /
//!        s            otherwise the front reaches x along an edge, or through another triangle
//! ```
//!
//! On slopes the metric stretches triangles until they are obtuse, and then one pass in order of value is not enough: nodes are
//! corrected whenever a better value turns up (label correcting), which ends at the same solution whatever the order
//! (F. Bornemann, C. Rasch, *Finite-element discretization of static Hamilton-Jacobi equations*, 2006).

use super::ruler::{Metric, Tensor, length_sq};
use crate::geom::{RING, Vector2};
use crate::reach::ToolCentreGrid;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What may happen at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Takes a value and hands it on.
    Open,
    /// Takes a value, and hands nothing on: just beyond a border, so that level curves can be cut there.
    Dead,
    /// Takes nothing.
    Closed,
}

/// What the march says of each node it settles; the answer tells it to go on or stop.
pub type OnSettle<'a> = &'a mut dyn FnMut(usize, f64) -> bool;

/// How to march.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Front {
    /// The seeds are one point: values are distances from it.
    Round,
    /// The seeds are a curve: fronts are straight at the scale of a cell.
    Straight,
}

/// How to march.
#[derive(Clone, Copy, Debug)]
pub struct MarchOptions {
    /// Shape of the front.
    pub front: Front,
    /// Nodes this many steps about a point seed are set directly, along the straight line.
    pub near_steps: i32,
}

#[derive(PartialEq)]
struct Item {
    value: f64,
    node: u32,
}

impl Eq for Item {}

impl Ord for Item {
    fn cmp(&self, o: &Self) -> Ordering {
        // A heap pops its greatest: turn it round; ties by node.
        o.value.total_cmp(&self.value).then(o.node.cmp(&self.node))
    }
}

impl PartialOrd for Item {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}

/// Marches from `seeds` (node, value) over the nodes that `access` opens, writing into `value` (which must come in as +inf
/// wherever the march may go). `on_settle` sees nodes in the order they are settled (a node may come again with a slightly smaller
/// value) and stops the march by saying false. Cost: about 8 triangle updates a node, n log n. Returns the nodes that got a value.
pub fn march(
    grid: &ToolCentreGrid,
    metric: &Metric,
    seeds: &[(usize, f64)],
    access: &dyn Fn(usize) -> Access,
    options: &MarchOptions,
    value: &mut [f64],
    on_settle: OnSettle,
) -> Vec<u32> {
    let mut heap = BinaryHeap::new();
    let mut touched: Vec<u32> = Vec::new();
    let mut set = |value: &mut [f64], heap: &mut BinaryHeap<Item>, node: usize, v: f64| {
        if value[node] == f64::INFINITY {
            touched.push(node as u32);
        }
        value[node] = v;
        heap.push(Item {
            value: v,
            node: node as u32,
        });
    };
    for &(seed, v) in seeds {
        if !metric.is_set(seed) {
            continue;
        }
        if v < value[seed] {
            set(value, &mut heap, seed, v);
        }
        if options.front == Front::Straight {
            continue;
        }
        // Fronts are most curved at their source, where a grid errs most: go straight there.
        let near = options.near_steps;
        for dy in -near..=near {
            for dx in -near..=near {
                if dx * dx + dy * dy > near * near {
                    continue;
                }
                if let Some(j) = grid.neighbour(seed, (dx, dy))
                    && metric.is_set(j)
                    && access(j) != Access::Closed
                    && let Some(d) = straight(grid, metric, seed, dx, dy, access)
                    && v + d < value[j]
                {
                    set(value, &mut heap, j, v + d);
                }
            }
        }
    }
    while let Some(Item { value: v, node }) = heap.pop() {
        let node = node as usize;
        if v > value[node] {
            continue; // superseded
        }
        if !on_settle(node, v) {
            break;
        }
        if access(node) != Access::Open {
            continue;
        }
        for (k, &d) in RING.iter().enumerate() {
            let Some(x) = grid.neighbour(node, d) else {
                continue;
            };
            if value[x] <= v || !metric.is_set(x) || access(x) == Access::Closed {
                continue;
            }
            // The node is in direction `back` of x; its partners are the neighbours of x on either side of it.
            let back = (k + 4) % 8;
            let a = Vector2::new(-d.0 as f64, -d.1 as f64) * grid.step;
            let mut best =
                v + length_sq(&mean2(&metric.tensor[x], &metric.tensor[node]), &a).sqrt();
            for turn in [1, 7] {
                let e = RING[(back + turn) % 8];
                let Some(j) = grid.neighbour(x, e) else {
                    continue;
                };
                if value[j] == f64::INFINITY || access(j) != Access::Open {
                    continue;
                }
                let b = Vector2::new(e.0 as f64, e.1 as f64) * grid.step;
                let m = mean3(&metric.tensor[x], &metric.tensor[node], &metric.tensor[j]);
                if let Some(u) = update(&m, &a, v, &b, value[j], options.front) {
                    best = best.min(u);
                }
            }
            // Improvements below rounding would only go round in circles.
            if best < value[x] * (1.0 - 1e-10) || value[x] == f64::INFINITY {
                set(value, &mut heap, x, best);
            }
        }
    }
    touched
}

/// Distance along the straight line from a seed, its metric sampled on the way; `None` if the line leaves the open nodes.
fn straight(
    grid: &ToolCentreGrid,
    metric: &Metric,
    seed: usize,
    dx: i32,
    dy: i32,
    access: &dyn Fn(usize) -> Access,
) -> Option<f64> {
    let n = dx.abs().max(dy.abs());
    if n == 0 {
        return Some(0.0);
    }
    let d = Vector2::new(dx as f64, dy as f64) * (grid.step / n as f64);
    let at = |k: i32| {
        let r = |v: i32| (v as f64 * k as f64 / n as f64).round() as i32;
        grid.neighbour(seed, (r(dx), r(dy)))
    };
    let mut sum = 0.0;
    for k in 0..n {
        let (a, b) = (at(k)?, at(k + 1)?);
        if !metric.is_set(a) || !metric.is_set(b) || (k > 0 && access(a) != Access::Open) {
            return None;
        }
        sum += length_sq(&mean2(&metric.tensor[a], &metric.tensor[b]), &d).sqrt();
    }
    Some(sum)
}

fn mean2(a: &Tensor, b: &Tensor) -> Tensor {
    [
        0.5 * (a[0] + b[0]),
        0.5 * (a[1] + b[1]),
        0.5 * (a[2] + b[2]),
    ]
}

fn mean3(a: &Tensor, b: &Tensor, c: &Tensor) -> Tensor {
    let t = 1.0 / 3.0;
    [
        (a[0] + b[0] + c[0]) * t,
        (a[1] + b[1] + c[1]) * t,
        (a[2] + b[2] + c[2]) * t,
    ]
}

/// Value at the origin of a triangle whose other corners a, b (seen from it) have the values va, vb; `None` when the front does not
/// come through a-b.
fn update(m: &Tensor, a: &Vector2, va: f64, b: &Vector2, vb: f64, front: Front) -> Option<f64> {
    let ab = b - a;
    let (la2, lb2, l2) = (length_sq(m, a), length_sq(m, b), length_sq(m, &ab));
    if l2 <= 0.0 {
        return None;
    }
    let l = l2.sqrt();
    // Laid flat: a at 0, b at l on the axis, x above it at (ux, uy).
    let ux = (la2 - lb2 + l2) / (2.0 * l);
    let uy = (la2 - ux * ux).max(0.0).sqrt();
    match front {
        Front::Round => {
            let sx = (va * va - vb * vb + l2) / (2.0 * l);
            let sy2 = va * va - sx * sx;
            if sy2 < 0.0 {
                return None;
            }
            let sy = sy2.sqrt();
            if sy + uy <= 0.0 {
                return None;
            }
            let cross = sx + (ux - sx) * sy / (sy + uy);
            (cross >= 0.0 && cross <= l).then(|| (ux - sx).hypot(uy + sy))
        }
        Front::Straight => {
            let g = (vb - va) / l;
            if g.abs() >= 1.0 {
                return None;
            }
            let up = (1.0 - g * g).sqrt();
            let cross = ux - uy * g / up;
            (cross >= 0.0 && cross <= l).then_some(va + g * ux + up * uy)
        }
    }
}
