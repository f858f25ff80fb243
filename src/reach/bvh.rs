//! A tree over triangles, four branches to a node, with for each branch an upper bound on how high it can hold a ball: what the drop
//! cutter prunes by.
//!
//! Lower a ball along its axis at x until it rests on the plane: its centre stands at C = (x, H), it touches at p. A point s inside
//! a box and below that plane lies outside the ball by
//!
//! ```text
//!            |s - C|^2 - R^2  =  |s - p|^2 - 2 R n.(s - p)  >=  |s - p|^2  >=  e^2     e = distance from p to the box, in space
//!
//!      .--.          a ball that rests on s instead is lower by
//!     ( C  )             sqrt(w^2 + e^2) - w  =  e^2 / (w + sqrt(w^2 + e^2))    at least,
//!  ____'p_' ____       where w = sqrt(R^2 - d^2) and d = distance in plan from x to the box; the smaller d, the less
//!            \_s_
//!
//!   plane    H - e^2 / (w + sqrt(w^2 + e^2))
//!   box      top + w
//! ```
//!
//! The lesser of the two bounds the branch. On a smooth surface, gentle or steep, few triangles are touched at all.
//!
//! Bounds are single precision, four at a time, about the middle of the part; all are widened outwards by more than what rounding
//! can do (see [`Room`]), so that pruning by them never loses a triangle.

use crate::geom::{Box3, Point, Vector};
use rayon::prelude::*;

/// Branches of a node, and triangles of the lowest ones.
pub const WIDTH: usize = 4;
/// Below this many triangles a subtree is built on one thread.
const FORK: usize = 8192;
/// Planes steeper than this (n.z) are not used as bounds: they are ill-conditioned as heights over (x, y).
const STEEP: f64 = 0.02;
/// Marks a branch that is a triangle, not a node.
const TRIANGLE: u32 = 1 << 31;
/// Room for rounding, relative: eight roundings of single precision (2^-24 each).
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;

/// One figure of each branch.
pub type Four = [f32; WIDTH];

/// A node: the bounds of its branches side by side. Lengths in mm, about the tree's middle.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Node {
    /// The box: lowest and highest x, y, z. A branch that is not there begins at +inf and ends at -inf.
    x0: Four,
    x1: Four,
    y0: Four,
    y1: Four,
    z0: Four,
    z1: Four,
    /// Height of a ball's centre on the covering plane: `a x + b y + k`; k = +inf without a plane.
    a: Four,
    b: Four,
    k: Four,
    /// Height of that centre above the point it touches: R n.z.
    rise: Four,
    /// What the branch is; see [`Node::child`].
    child: [u32; WIDTH],
}

/// What a branch is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Another node, by its place.
    Node(u32),
    /// A triangle, by its place in [`Bvh::order`].
    Triangle(u32),
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    // Not f32::max: this is one instruction, and NaN (only without a plane) may go either way.
    if a > b { a } else { b }
}

impl Node {
    const NONE: Node = Node {
        x0: [f32::INFINITY; WIDTH],
        x1: [f32::NEG_INFINITY; WIDTH],
        y0: [f32::INFINITY; WIDTH],
        y1: [f32::NEG_INFINITY; WIDTH],
        z0: [f32::INFINITY; WIDTH],
        z1: [f32::NEG_INFINITY; WIDTH],
        a: [0.0; WIDTH],
        b: [0.0; WIDTH],
        k: [f32::INFINITY; WIDTH],
        rise: [0.0; WIDTH],
        child: [0; WIDTH],
    };

    /// For each branch: no ball on the axis (x, y) is held higher by anything inside; -inf when the ball passes by. `x`, `y` and the
    /// result are about the tree's middle; `r2` is [`Bvh::radius_sq`].
    #[inline(always)]
    pub fn heights(&self, x: f32, y: f32, r2: f32) -> Four {
        let mut out = [0.0; WIDTH];
        for (i, out) in out.iter_mut().enumerate() {
            let dx = greater(greater(self.x0[i] - x, x - self.x1[i]), 0.0);
            let dy = greater(greater(self.y0[i] - y, y - self.y1[i]), 0.0);
            let room = r2 - dx * dx - dy * dy;
            let w2 = greater(room, 0.0);
            let w = w2.sqrt();
            let h = self.a[i] * x + self.b[i] * y + self.k[i];
            // The normal's plan part is -n.z times the slope.
            let (px, py) = (x + self.a[i] * self.rise[i], y + self.b[i] * self.rise[i]);
            let pz = h - self.rise[i];
            let ex = greater(greater(self.x0[i] - px, px - self.x1[i]), 0.0);
            let ey = greater(greater(self.y0[i] - py, py - self.y1[i]), 0.0);
            let ez = greater(greater(self.z0[i] - pz, pz - self.z1[i]), 0.0);
            let e2 = ex * ex + ey * ey + ez * ez;
            let by_plane = h - e2 / (w + (w2 + e2).sqrt());
            let by_box = self.z1[i] + w;
            // Not a number without a plane, and then not less.
            let least = if by_plane < by_box { by_plane } else { by_box };
            *out = if room < 0.0 { f32::NEG_INFINITY } else { least };
        }
        out
    }

    /// Which branches have (x, y) in their box in plan and reach up to `floor` or above.
    #[inline(always)]
    pub fn over(&self, x: f32, y: f32, floor: f32) -> [bool; WIDTH] {
        let mut out = [false; WIDTH];
        for (i, out) in out.iter_mut().enumerate() {
            *out = (self.x0[i] <= x)
                & (x <= self.x1[i])
                & (self.y0[i] <= y)
                & (y <= self.y1[i])
                & (self.z1[i] >= floor);
        }
        out
    }

    /// Which branches have a box in plan that overlaps a rectangle, borders included; all about the tree's middle.
    #[inline(always)]
    pub fn overlap(&self, [x0, y0]: [f32; 2], [x1, y1]: [f32; 2]) -> [bool; WIDTH] {
        let mut out = [false; WIDTH];
        for (i, out) in out.iter_mut().enumerate() {
            *out =
                (self.x0[i] <= x1) & (self.x1[i] >= x0) & (self.y0[i] <= y1) & (self.y1[i] >= y0);
        }
        out
    }

    /// What a branch is. Only for branches that are there.
    #[inline(always)]
    pub fn child(&self, i: usize) -> Child {
        let c = self.child[i];
        if c & TRIANGLE == 0 {
            Child::Node(c)
        } else {
            Child::Triangle(c & !TRIANGLE)
        }
    }
}

/// The tree; triangles are referred to by their place in `order`. Node 0 is its root; no nodes, no triangles.
#[derive(Debug)]
pub struct Bvh {
    pub nodes: Vec<Node>,
    /// Place in the tree -> index of the triangle in the mesh.
    pub order: Vec<u32>,
    /// What bounds are measured from, mm.
    pub middle: Point,
    /// The radius squared and a little more, mm².
    pub radius_sq: f32,
}

struct Item {
    mid: [f64; 3],
    id: u32,
}

/// How far bounds are widened so that single precision cannot lose anything. Places in plan are at most P from the middle (half the
/// part and the ball), heights at most Z (the same in z). In units of 2^-24:
///
/// ```text
/// x, px         one rounding of P to tell it, one to add to it, one of the ball's radius:    3 P           given 8 P
/// a x + b y     x is told to 1 P; products and first sum round once each:                    3 (|a|+|b|) P
///  + k          k and the sum are at most Z + (|a|+|b|+1) P, and round once each:            2 (Z + (|a|+|b|+1) P)
///  - e2 / ..    at most P + Z; relative error below 8 in e2, half of it taken by the roots:  <= 2 (P + Z)
///               together at most                                                             5 (|a|+|b|) P + 4 (P + Z)
///                                                                                            given 8 of each
/// ```
struct Room {
    plan: f64,
    height: f64,
}

impl Room {
    fn plan(&self) -> f64 {
        ROUNDING * self.plan
    }

    fn height(&self, a: f64, b: f64) -> f64 {
        ROUNDING * (self.height + self.plan * (1.0 + a.abs() + b.abs()))
    }
}

struct Builder<'a> {
    triangles: &'a [[Point; 3]],
    radius: f64,
    middle: Point,
    room: Room,
}

impl Bvh {
    /// Builds the tree; O(n log n), the same tree on any number of threads. Below 2^31 triangles.
    pub fn new(triangles: &[[Point; 3]], radius: f64) -> Bvh {
        let bounds = Box3::of(triangles.iter().flatten());
        let middle = if bounds.is_empty() {
            Point::origin()
        } else {
            bounds.center()
        };
        let half = 0.5 * bounds.size();
        let builder = Builder {
            triangles,
            radius,
            middle,
            room: Room {
                plan: half.x.max(half.y) + radius,
                height: half.z + radius,
            },
        };
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
        let nodes = if items.is_empty() {
            Vec::new()
        } else {
            builder.build(&mut items, 0)
        };
        Bvh {
            nodes,
            order: items.iter().map(|i| i.id).collect(),
            middle,
            radius_sq: (radius * radius * (1.0 + ROUNDING)) as f32,
        }
    }

    /// A place or height about the middle in single precision; 2^-24 of it off.
    #[inline(always)]
    pub fn local(&self, x: f64, y: f64) -> (f32, f32) {
        ((x - self.middle.x) as f32, (y - self.middle.y) as f32)
    }
}

impl Builder<'_> {
    /// Sets the bounds of branch `i`.
    fn bound(&self, node: &mut Node, i: usize, items: &[Item]) {
        let mut box3 = Box3::empty();
        let mut sum = Vector::zeros();
        for item in items {
            let t = &self.triangles[item.id as usize];
            t.iter().for_each(|p| box3.grow(p));
            let n = (t[1] - t[0]).cross(&(t[2] - t[0]));
            sum += if n.z < 0.0 { -n } else { n };
        }
        let (mut a, mut b, mut k, mut rise) = (0.0, 0.0, f64::INFINITY, 0.0);
        let len = sum.norm();
        if len > 0.0 && sum.z > STEEP * len {
            let n = sum / len;
            // As single precision has them: the height must fit.
            let slope = |v: f64| f64::from((-v / n.z) as f32);
            (a, b) = (slope(n.x), slope(n.y));
            let above = items
                .iter()
                .flat_map(|i| &self.triangles[i.id as usize])
                .map(|p| p - self.middle)
                .map(|p| p.z - a * p.x - b * p.y)
                .fold(f64::NEG_INFINITY, f64::max);
            k = above + self.radius / n.z;
            rise = self.radius * n.z;
        }
        let (plan, height) = (self.room.plan(), self.room.height(a, b));
        let (lo, hi) = (box3.min - self.middle, box3.max - self.middle);
        node.x0[i] = (lo.x - plan) as f32;
        node.x1[i] = (hi.x + plan) as f32;
        node.y0[i] = (lo.y - plan) as f32;
        node.y1[i] = (hi.y + plan) as f32;
        // Twice: the plane's own widening must not lift the point it is touched at out of the box.
        node.z0[i] = (lo.z - 2.0 * height) as f32;
        node.z1[i] = (hi.z + 2.0 * height) as f32;
        node.a[i] = a as f32;
        node.b[i] = b as f32;
        node.k[i] = (k + height) as f32;
        node.rise[i] = rise as f32;
    }

    /// A subtree with its root at index 0, each node before its children; `base` is the place of the first item. At least one item.
    fn build(&self, items: &mut [Item], base: usize) -> Vec<Node> {
        let all = items.len();
        let mut groups: Vec<&mut [Item]> = vec![items];
        // The largest group is halved until there are four; the halves stand where it stood.
        while groups.len() < WIDTH {
            let Some((i, n)) = groups
                .iter()
                .map(|g| g.len())
                .enumerate()
                .max_by_key(|&(i, n)| (n, usize::MAX - i))
                .filter(|&(_, n)| n > if all > WIDTH { WIDTH } else { 1 })
            else {
                break;
            };
            let (left, right) = halve(groups.remove(i), n);
            groups.insert(i, right);
            groups.insert(i, left);
        }
        let mut node = Node::NONE;
        let mut first = base;
        let mut starts = [0; WIDTH];
        for (i, g) in groups.iter().enumerate() {
            self.bound(&mut node, i, g);
            starts[i] = first;
            first += g.len();
        }
        let subtrees: Vec<Vec<Node>> = if all > FORK {
            groups
                .into_par_iter()
                .zip(starts)
                .map(|(g, start)| self.subtree(g, start))
                .collect()
        } else {
            groups
                .into_iter()
                .zip(starts)
                .map(|(g, start)| self.subtree(g, start))
                .collect()
        };
        let mut nodes = Vec::with_capacity(1 + subtrees.iter().map(Vec::len).sum::<usize>());
        nodes.push(node);
        for (i, (mut sub, start)) in subtrees.into_iter().zip(starts).enumerate() {
            let here = nodes.len() as u32;
            nodes[0].child[i] = if sub.is_empty() {
                TRIANGLE | start as u32
            } else {
                here
            };
            for c in sub.iter_mut().flat_map(|n| &mut n.child) {
                if *c & TRIANGLE == 0 {
                    *c += here;
                }
            }
            nodes.append(&mut sub);
        }
        nodes
    }

    /// Nothing for a single triangle.
    fn subtree(&self, items: &mut [Item], base: usize) -> Vec<Node> {
        if items.len() == 1 {
            Vec::new()
        } else {
            self.build(items, base)
        }
    }
}

/// Two halves along the longest side. Whole fours as far as possible: the lowest nodes should be full.
fn halve(items: &mut [Item], n: usize) -> (&mut [Item], &mut [Item]) {
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
    let half = if n > WIDTH {
        (n / 2).next_multiple_of(WIDTH)
    } else {
        n / 2
    };
    let half = if half >= n { n / 2 } else { half };
    // Ties by triangle number: the same halves whatever the order of arrival.
    items.select_nth_unstable_by(half, |a, b| {
        a.mid[axis].total_cmp(&b.mid[axis]).then(a.id.cmp(&b.id))
    });
    items.split_at_mut(half)
}
