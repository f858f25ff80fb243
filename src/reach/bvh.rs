//! A binary tree over triangles with, for each set of them, an upper bound on how high it can hold a ball: what the drop cutter
//! prunes by.
//!
//! A set of points inside a box and below a plane holds a ball on the axis x no higher than
//!
//! ```text
//!   box      top + sqrt(R^2 - d^2)             d = distance in plan from x to the box
//!   plane    plane shifted up by R n, at x     the ball would rest at q0 = x - R n.xy in plan;
//!            - dist(q0, box)^2 / (2 R)         if q0 is off the box it rests lower: the height at which a point q of the
//!                                              plane holds the ball, z(q) + sqrt(R^2 - |q - x|^2), is concave in q with
//!                                              a second derivative of -1/R or less, and its maximum is at q0
//! ```
//!
//! On a smooth surface the plane is the sharper of the two by far: few triangles are touched at all.

use crate::geom::{Box3, Point, Vector};
use rayon::prelude::*;

/// Triangles in one leaf at most.
const LEAF: usize = 4;
/// Below this many triangles a subtree is built on one thread.
const FORK: usize = 8192;
/// Planes steeper than this (n.z) are not used as bounds: they are ill-conditioned as heights over (x, y).
const STEEP: f64 = 0.02;

/// Shadow on the table, top, and covering plane of a set of triangles, mm.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    x: [f64; 2],
    y: [f64; 2],
    top: f64,
    /// Height of a ball's centre on the covering plane: `a x + b y + k`; k = +inf without a plane.
    a: f64,
    b: f64,
    k: f64,
    /// Where on the plane that ball rests, seen from its axis: -R n.xy.
    off: [f64; 2],
}

impl Bound {
    /// No ball of this radius on the axis (x, y) is held higher by anything inside; -inf when the ball passes by.
    #[inline]
    pub fn height(&self, x: f64, y: f64, radius: f64) -> f64 {
        let dx = (self.x[0] - x).max(x - self.x[1]).max(0.0);
        let dy = (self.y[0] - y).max(y - self.y[1]).max(0.0);
        let room = radius * radius - dx * dx - dy * dy;
        if room < 0.0 {
            return f64::NEG_INFINITY;
        }
        let by_box = self.top + room.sqrt();
        let (qx, qy) = (x + self.off[0], y + self.off[1]);
        let ex = (self.x[0] - qx).max(qx - self.x[1]).max(0.0);
        let ey = (self.y[0] - qy).max(qy - self.y[1]).max(0.0);
        let by_plane = self.a * x + self.b * y + self.k - (ex * ex + ey * ey) / (2.0 * radius);
        by_box.min(by_plane)
    }

    /// True when (x, y) lies in the box in plan.
    #[inline]
    pub fn holds(&self, x: f64, y: f64) -> bool {
        x >= self.x[0] && x <= self.x[1] && y >= self.y[0] && y <= self.y[1]
    }

    /// True when the box overlaps a rectangle in plan, borders included.
    #[inline]
    pub fn overlaps(&self, min: [f64; 2], max: [f64; 2]) -> bool {
        self.x[0] <= max[0] && self.x[1] >= min[0] && self.y[0] <= max[1] && self.y[1] >= min[1]
    }

    /// Highest point inside.
    #[inline]
    pub fn top(&self) -> f64 {
        self.top
    }
}

/// A node: inner when `count` is zero (children at `first` and `first + 1`), else a leaf of `count` triangles from `first`.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub bound: Bound,
    pub first: u32,
    pub count: u32,
}

/// The tree; triangles are referred to by their place in `order`.
#[derive(Debug)]
pub struct Bvh {
    pub nodes: Vec<Node>,
    /// Leaf position -> index of the triangle in the mesh.
    pub order: Vec<u32>,
    /// Bound of each triangle, by leaf position.
    pub bounds: Vec<Bound>,
}

struct Item {
    mid: [f64; 3],
    id: u32,
}

struct Builder<'a> {
    triangles: &'a [[Point; 3]],
    radius: f64,
}

impl Bvh {
    /// Builds the tree; O(n log n), the same tree on any number of threads.
    pub fn new(triangles: &[[Point; 3]], radius: f64) -> Bvh {
        let mut items: Vec<Item> = triangles
            .par_iter()
            .enumerate()
            .map(|(i, t)| {
                let c = Box3::of(t).center();
                Item {
                    mid: [c.x, c.y, c.z],
                    id: i as u32,
                }
            })
            .collect();
        let builder = Builder { triangles, radius };
        let nodes = if items.is_empty() {
            Vec::new()
        } else {
            builder.build(&mut items, 0)
        };
        Bvh {
            nodes,
            bounds: items
                .par_iter()
                .map(|i| builder.bound(std::slice::from_ref(i)))
                .collect(),
            order: items.iter().map(|i| i.id).collect(),
        }
    }
}

impl Builder<'_> {
    fn bound(&self, items: &[Item]) -> Bound {
        let mut b = Box3::empty();
        let mut sum = Vector::zeros();
        for i in items {
            let t = &self.triangles[i.id as usize];
            t.iter().for_each(|p| b.grow(p));
            let n = (t[1] - t[0]).cross(&(t[2] - t[0]));
            sum += if n.z < 0.0 { -n } else { n };
        }
        let mut bound = Bound {
            x: [b.min.x, b.max.x],
            y: [b.min.y, b.max.y],
            top: b.max.z,
            a: 0.0,
            b: 0.0,
            k: f64::INFINITY,
            off: [0.0; 2],
        };
        let len = sum.norm();
        if len > 0.0 && sum.z > STEEP * len {
            let n = sum / len;
            (bound.a, bound.b) = (-n.x / n.z, -n.y / n.z);
            let above = items
                .iter()
                .flat_map(|i| &self.triangles[i.id as usize])
                .map(|p| p.z - bound.a * p.x - bound.b * p.y)
                .fold(f64::NEG_INFINITY, f64::max);
            bound.k = above + self.radius / n.z;
            bound.off = [-self.radius * n.x, -self.radius * n.y];
        }
        bound
    }

    /// A subtree with its root at index 0 and children at relative indices; `base` is the leaf position of the first item.
    fn build(&self, items: &mut [Item], base: usize) -> Vec<Node> {
        let bound = self.bound(items);
        if items.len() <= LEAF {
            return vec![Node {
                bound,
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
        // Height splits too: the floor of a solid must not drag its top along.
        let spans = [span(0), span(1), span(2)];
        let axis = if spans[2] > spans[0].max(spans[1]) {
            2
        } else if spans[0] >= spans[1] {
            0
        } else {
            1
        };
        let half = items.len() / 2;
        // Ties by triangle number: the same halves whatever the order of arrival.
        items.select_nth_unstable_by(half, |a, b| {
            a.mid[axis].total_cmp(&b.mid[axis]).then(a.id.cmp(&b.id))
        });
        let (left, right) = items.split_at_mut(half);
        let (l, r) = if left.len() + right.len() > FORK {
            rayon::join(|| self.build(left, base), || self.build(right, base + half))
        } else {
            (self.build(left, base), self.build(right, base + half))
        };
        // Children stand side by side: root, left root, right root, rest of left, rest of right.
        let mut nodes = Vec::with_capacity(1 + l.len() + r.len());
        nodes.push(Node {
            bound,
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
}
