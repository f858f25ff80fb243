//! A binary tree of boxes over triangles in plan, each with the height of its highest point: what the drop cutter prunes by.

use crate::geom::{Box3, Point};
use rayon::prelude::*;

/// Triangles in one leaf at most.
const LEAF: usize = 4;
/// Below this many triangles a subtree is built on one thread.
const FORK: usize = 8192;

/// Shadow on the table and top of a set of triangles, mm.
#[derive(Clone, Copy, Debug)]
pub struct Slab {
    pub x: [f64; 2],
    pub y: [f64; 2],
    pub top: f64,
}

impl Slab {
    fn of(t: &[Point; 3]) -> Slab {
        let b = Box3::of(t);
        Slab {
            x: [b.min.x, b.max.x],
            y: [b.min.y, b.max.y],
            top: b.max.z,
        }
    }

    fn union(&self, o: &Slab) -> Slab {
        Slab {
            x: [self.x[0].min(o.x[0]), self.x[1].max(o.x[1])],
            y: [self.y[0].min(o.y[0]), self.y[1].max(o.y[1])],
            top: self.top.max(o.top),
        }
    }

    /// No ball of squared radius `r2` on the axis (x, y) can be held higher than this by anything inside;
    /// -inf when the ball passes by.
    #[inline]
    pub fn bound(&self, x: f64, y: f64, r2: f64) -> f64 {
        let dx = (self.x[0] - x).max(x - self.x[1]).max(0.0);
        let dy = (self.y[0] - y).max(y - self.y[1]).max(0.0);
        let d2 = dx * dx + dy * dy;
        if d2 > r2 {
            f64::NEG_INFINITY
        } else {
            self.top + (r2 - d2).sqrt()
        }
    }

    #[inline]
    pub fn holds(&self, x: f64, y: f64) -> bool {
        x >= self.x[0] && x <= self.x[1] && y >= self.y[0] && y <= self.y[1]
    }
}

/// A node: inner when `count` is zero (children at `first` and `first + 1`), else a leaf of `count` triangles from `first`.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub slab: Slab,
    pub first: u32,
    pub count: u32,
}

/// The tree; triangles are referred to by their place in `order`.
#[derive(Debug)]
pub struct Bvh {
    pub nodes: Vec<Node>,
    /// Leaf position -> index of the triangle in the mesh.
    pub order: Vec<u32>,
    /// Slab of each triangle, by leaf position.
    pub slabs: Vec<Slab>,
}

struct Item {
    slab: Slab,
    mid: [f64; 2],
    id: u32,
}

impl Bvh {
    /// Builds the tree; O(n log n), the same tree on any number of threads.
    pub fn new(triangles: &[[Point; 3]]) -> Bvh {
        let mut items: Vec<Item> = triangles
            .par_iter()
            .enumerate()
            .map(|(i, t)| {
                let slab = Slab::of(t);
                Item {
                    slab,
                    mid: [slab.x[0] + slab.x[1], slab.y[0] + slab.y[1]],
                    id: i as u32,
                }
            })
            .collect();
        let nodes = if items.is_empty() {
            Vec::new()
        } else {
            build(&mut items, 0)
        };
        Bvh {
            nodes,
            order: items.iter().map(|i| i.id).collect(),
            slabs: items.iter().map(|i| i.slab).collect(),
        }
    }
}

/// A subtree with its root at index 0 and children at relative indices; `base` is the leaf position of the first item.
fn build(items: &mut [Item], base: usize) -> Vec<Node> {
    let slab = items
        .iter()
        .skip(1)
        .fold(items[0].slab, |s, i| s.union(&i.slab));
    if items.len() <= LEAF {
        return vec![Node {
            slab,
            first: base as u32,
            count: items.len() as u32,
        }];
    }
    let span = |axis: usize| {
        let (lo, hi) = items
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), i| {
                (lo.min(i.mid[axis]), hi.max(i.mid[axis]))
            });
        hi - lo
    };
    let axis = if span(0) >= span(1) { 0 } else { 1 };
    let half = items.len() / 2;
    // Ties by triangle number: the same halves whatever the order of arrival.
    items.select_nth_unstable_by(half, |a, b| {
        a.mid[axis].total_cmp(&b.mid[axis]).then(a.id.cmp(&b.id))
    });
    let (left, right) = items.split_at_mut(half);
    let (l, r) = if left.len() + right.len() > FORK {
        rayon::join(|| build(left, base), || build(right, base + half))
    } else {
        (build(left, base), build(right, base + half))
    };
    // Children stand side by side: root, left root, right root, rest of left, rest of right.
    let mut nodes = Vec::with_capacity(1 + l.len() + r.len());
    nodes.push(Node {
        slab,
        first: 1,
        count: 0,
    });
    let left_rest = 3u32;
    let right_rest = 3 + l.len() as u32 - 1;
    let moved = |mut n: Node, rest: u32| {
        if n.count == 0 {
            n.first += rest - 1;
        }
        n
    };
    nodes.push(moved(l[0], left_rest));
    nodes.push(moved(r[0], right_rest));
    nodes.extend(l[1..].iter().map(|&n| moved(n, left_rest)));
    nodes.extend(r[1..].iter().map(|&n| moved(n, right_rest)));
    nodes
}
