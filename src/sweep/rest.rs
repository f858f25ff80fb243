//! Rest material: where on a part this ball cannot go, how much stands there, and the largest ball that could.
//!
//! ```text
//!    \      /      every admissible centre lies at or above the drop height c(x, y), so a point p of the part is left with
//!     \_()_/             depth(p) = min over (x, y) of |p - (x, y, max(c, p.z))| - R
//!      \p/         standing on it: zero where a ball touches it, more in folds tighter than the ball
//! ```
//!
//! The part's own surface is sampled, upright walls included, triangle by triangle; what faces down or lies hidden under other
//! ground is no ball's business and is left out.
//!
//! Crosses the border: a mesh and its cutter in, areas and spots out; work coordinates, mm. Knows nothing of passes.

use crate::geom::{Box3, Point, Point2, Vector, compass};
use crate::part::Mesh;
use crate::reach::{DropCutter, Hint};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// How rest material is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestOptions {
    /// Less than this, along the normal, is no rest material, mm: usually the cusp height asked for.
    pub tolerance: f64,
    /// Spots to describe at most, largest first.
    pub spots: usize,
    /// Balls smaller than this are not thought of: radius, mm.
    pub smallest: f64,
}

impl RestOptions {
    /// For a finish of `scallop` mm: what stands less than a cusp is a cusp.
    pub fn for_scallop(scallop: f64) -> RestOptions {
        RestOptions {
            tolerance: scallop,
            spots: 50,
            smallest: 0.1,
        }
    }
}

/// One connected place that the ball leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestSpot {
    /// Where most is left, on the part.
    pub place: Point,
    /// Area of the part's surface, mm^2.
    pub area: f64,
    /// The most that is left, mm.
    pub depth: f64,
    /// Radius of the largest ball that would leave no more than the tolerance on 99 % of it, mm; `None` for a corner too sharp for
    /// any.
    pub largest_ball: Option<f64>,
}

/// All that the ball leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rest {
    /// Area of the part's surface with rest material on it, upright walls included, mm^2.
    pub area: f64,
    /// The same seen from above, mm^2.
    pub plan: f64,
    /// Places, by falling area.
    pub spots: Vec<RestSpot>,
    /// How many places there are, described or not.
    pub count: usize,
}

/// A sampled piece of the part's surface that the ball leaves.
#[derive(Clone, Copy)]
struct Piece {
    at: Point,
    normal: Vector,
    area: f64,
    /// Seen from above.
    plan: f64,
    depth: f64,
}

/// Samples on a part at most, about.
const SAMPLES: f64 = 80_000.0;
/// Facets with a smaller vertical part of the normal are upright.
const UPRIGHT: f64 = 0.02;

/// Looks for what a ball leaves of a part. Cost: a drop for each of some 80,000 samples, and some sixty for each that is left.
/// Same result on any number of threads.
pub fn rest(part: &Mesh, cutter: &DropCutter, options: &RestOptions) -> Rest {
    let radius = cutter.radius();
    let total: f64 = part
        .triangles
        .par_iter()
        .map(|t| 0.5 * Mesh::doubled_area_vector(t).norm())
        .collect::<Vec<f64>>()
        .iter()
        .sum();
    let gap = (total / SAMPLES).sqrt().clamp(0.03 * radius, 0.1 * radius);
    let pieces: Vec<Piece> = part
        .triangles
        .par_chunks(256)
        .flat_map_iter(|chunk| {
            let mut out = Vec::new();
            let mut hint = Hint::default();
            for t in chunk {
                sample(t, cutter, gap, options.tolerance, &mut hint, &mut out);
            }
            out
        })
        .collect();
    let mut groups = connected(&pieces, 2.0 * gap);
    let area_of = |g: &[u32]| g.iter().map(|&i| pieces[i as usize].area).sum::<f64>();
    let mut with_area: Vec<(f64, Vec<u32>)> = groups.drain(..).map(|g| (area_of(&g), g)).collect();
    with_area.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let count = with_area.len();
    // An empty sum of floats is -0.
    let area = with_area.iter().map(|g| g.0).fold(0.0, |a, b| a + b);
    let spots = with_area
        .par_iter()
        .take(options.spots)
        .map(|(area, g)| spot(part, &pieces, g, *area, radius, options))
        .collect();
    Rest {
        area,
        plan: pieces.iter().map(|p| p.plan).fold(0.0, |a, b| a + b),
        spots,
        count,
    }
}

/// The pieces of one triangle that are left.
fn sample(
    t: &[Point; 3],
    cutter: &DropCutter,
    gap: f64,
    tolerance: f64,
    hint: &mut Hint,
    out: &mut Vec<Piece>,
) {
    let doubled = Mesh::doubled_area_vector(t);
    let length = doubled.norm();
    if !(length.is_finite() && length > 0.0) {
        return;
    }
    let mut n = doubled / length;
    if n.z < 0.0 {
        n = -n;
    }
    let edge = |k: usize| (t[(k + 1) % 3] - t[k]).norm();
    let cuts = |l: f64| (l / gap).ceil().clamp(1.0, 4096.0);
    // Strips along the longest edge keep needles from costing the square of their length.
    let long = (0..3).fold(0, |b, k| if edge(k) > edge(b) { k } else { b });
    let (a, b, c) = (t[long], t[(long + 1) % 3], t[(long + 2) % 3]);
    let height = length / edge(long).max(1e-300);
    let rows = cuts(height) as usize;
    let mut last: Option<Point2> = None;
    // One place in each even piece, not always its middle: borders of spots run along rows, and errors must not add up. The places
    // follow from the triangle alone.
    let mut scatter = Scatter::new(t);
    for row in 0..rows {
        let v = (row as f64 + scatter.next()) / rows as f64;
        let (from, to) = (a + (c - a) * v, b + (c - b) * v);
        let width = (to - from).norm();
        let columns = cuts(width) as usize;
        // Exact for the row, wherever in it the places lie.
        let middle = (row as f64 + 0.5) / rows as f64;
        let area = edge(long) * (1.0 - middle) * height / rows as f64 / columns as f64;
        for k in 0..columns {
            let p = from + (to - from) * ((k as f64 + scatter.next()) / columns as f64);
            if let Some((depth, normal)) = left(&p, &n, cutter, tolerance, hint, &mut last) {
                out.push(Piece {
                    at: p,
                    normal,
                    area,
                    plan: area * n.z,
                    depth,
                });
            }
        }
    }
}

/// Places between 0 and 1 that look random and are not.
struct Scatter(u64);

impl Scatter {
    fn new(t: &[Point; 3]) -> Scatter {
        Scatter(t.iter().flat_map(|p| [p.x, p.y, p.z]).fold(0, |h: u64, v| {
            (h.rotate_left(7) ^ v.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        }))
    }

    /// Splitmix64 (G. L. Steele et al., 2014).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    }
}

/// What is left on a point of the part with this facet normal, and the normal on its free side; `None` when within the tolerance, or
/// hidden.
fn left(
    p: &Point,
    n: &Vector,
    cutter: &DropCutter,
    tolerance: f64,
    hint: &mut Hint,
    last: &mut Option<Point2>,
) -> Option<(f64, Vector)> {
    let r = cutter.radius();
    let upright = n.z < UPRIGHT;
    let sides: &[f64] = if upright { &[1.0, -1.0] } else { &[1.0] };
    let mut best: Option<(f64, Vector)> = None;
    for s in sides {
        let side = n * *s;
        let beside = p + side * 1e-4;
        let top = cutter.surface_z(beside.x, beside.y);
        if top.is_some_and(|z| z > p.z + 1e-3) {
            continue;
        }
        let d = distance(p, &side, cutter, tolerance, hint, last) - r;
        if best.is_none_or(|b| d < b.0) {
            best = Some((d, side));
        }
    }
    best.filter(|b| b.0 > tolerance)
}

/// Distance from a point to the nearest admissible centre; anything within the tolerance of the radius is not searched further.
fn distance(
    p: &Point,
    n: &Vector,
    cutter: &DropCutter,
    tolerance: f64,
    hint: &mut Hint,
    last: &mut Option<Point2>,
) -> f64 {
    let r = cutter.radius();
    let mut at = |q: &Point2| -> f64 {
        let plan = (q - p.xy()).norm_squared();
        let up = cutter
            .drop_near(q.x, q.y, hint)
            .map_or(0.0, |c| (c.center.z - p.z).max(0.0));
        (plan + up * up).sqrt()
    };
    // A hair off an upright wall, or the ball would stand on it.
    let mut best = p.xy() + n.xy() * (r + 0.25 * tolerance);
    let mut d = at(&best);
    if d <= r + tolerance {
        return d;
    }
    // Or the ball of the neighbour, or the one straight above.
    let neighbour = *last;
    for q in neighbour.into_iter().chain([p.xy()]) {
        let e = at(&q);
        if e < d {
            (best, d) = (q, e);
        }
    }
    let mut step = if neighbour == Some(best) {
        0.05 * r
    } else {
        0.2 * r
    };
    while step > 0.2 * tolerance {
        let mut moved = false;
        for way in compass() {
            let q = best + way * step;
            let e = at(&q);
            if e < d - 1e-9 {
                (best, d) = (q, e);
                moved = true;
            }
        }
        if d <= r + tolerance {
            break;
        }
        if !moved {
            step *= 0.4;
        }
    }
    *last = Some(best);
    d
}

/// Pieces that lie in touching cells of this size hang together. Deterministic.
fn connected(pieces: &[Piece], cell: f64) -> Vec<Vec<u32>> {
    let key = |p: &Point| {
        let f = |v: f64| (v / cell).floor() as i64;
        (f(p.x), f(p.y), f(p.z))
    };
    let mut cells: BTreeMap<(i64, i64, i64), Vec<u32>> = BTreeMap::new();
    for (i, p) in pieces.iter().enumerate() {
        cells.entry(key(&p.at)).or_default().push(i as u32);
    }
    let mut out = Vec::new();
    while let Some((&first, _)) = cells.iter().next() {
        let mut group = Vec::new();
        let mut queue = vec![first];
        while let Some(k) = queue.pop() {
            let Some(members) = cells.remove(&k) else {
                continue;
            };
            group.extend(members);
            for dx in -1..=1 {
                for dy in -1..=1 {
                    for dz in -1..=1 {
                        let near = (k.0 + dx, k.1 + dy, k.2 + dz);
                        if cells.contains_key(&near) {
                            queue.push(near);
                        }
                    }
                }
            }
        }
        group.sort_unstable();
        out.push(group);
    }
    out
}

/// Points of a spot that a smaller ball is tried on, about.
const TRIED: usize = 200;

fn spot(
    part: &Mesh,
    pieces: &[Piece],
    group: &[u32],
    area: f64,
    radius: f64,
    options: &RestOptions,
) -> RestSpot {
    let of = |i: &u32| &pieces[*i as usize];
    let deepest = group
        .iter()
        .map(of)
        .fold(None, |b: Option<&Piece>, p| match b {
            Some(b) if b.depth >= p.depth => Some(b),
            _ => Some(p),
        });
    let (place, depth) = deepest.map_or((Point::origin(), 0.0), |p| (p.at, p.depth));
    let stride = group.len().div_ceil(TRIED).max(1);
    let tried: Vec<&Piece> = group.iter().step_by(stride).map(of).collect();
    // Only what lies near the spot can keep a ball off it.
    let around = Box3::of(tried.iter().map(|p| &p.at));
    let near: Vec<[Point; 3]> = part
        .triangles
        .iter()
        .filter(|t| {
            let b = Box3::of(t.iter());
            (0..2).all(|k| {
                b.min[k] <= around.max[k] + 2.0 * radius && b.max[k] >= around.min[k] - 2.0 * radius
            })
        })
        .copied()
        .collect();
    let near = Mesh { triangles: near };
    let whole: f64 = tried.iter().map(|p| p.area).sum();
    let reaches = |r: f64| -> bool {
        let cutter = DropCutter::new(&near, r);
        let mut hint = Hint::default();
        let mut last = None;
        let mut missed = 0.0;
        for p in &tried {
            let d = distance(
                &p.at,
                &p.normal,
                &cutter,
                options.tolerance,
                &mut hint,
                &mut last,
            );
            if d - r > options.tolerance {
                missed += p.area;
                if missed > 0.01 * whole {
                    return false;
                }
            }
        }
        true
    };
    let smallest = options.smallest.min(radius);
    let largest_ball = reaches(smallest).then(|| {
        let (mut lo, mut hi) = (smallest, radius);
        for _ in 0..7 {
            let m = (lo * hi).sqrt();
            if reaches(m) {
                lo = m;
            } else {
                hi = m;
            }
        }
        lo
    });
    RestSpot {
        place,
        area,
        depth,
        largest_ball,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn quad(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> [[Point; 3]; 2] {
        let p = |v: [f64; 3]| Point::new(v[0], v[1], v[2]);
        [[p(a), p(b), p(c)], [p(a), p(c), p(d)]]
    }

    fn found(mesh: &Mesh, r: f64, tolerance: f64) -> Rest {
        let options = RestOptions {
            tolerance,
            spots: 50,
            smallest: 0.1,
        };
        rest(mesh, &DropCutter::new(mesh, r), &options)
    }

    /// A groove of flanks at 45 degrees: along each flank the ball of radius R touches at R tan(45 degrees) from the bottom; nearer
    /// than that s from the touching point sqrt(R^2 + s^2) - R stands.
    #[test]
    fn a_groove_keeps_what_the_ball_cannot_reach() {
        let (r, tolerance, long) = (3.0f64, 0.02f64, 40.0);
        let mesh = Mesh {
            triangles: [
                quad(
                    [0.0, -8.0, 8.0],
                    [long, -8.0, 8.0],
                    [long, 0.0, 0.0],
                    [0.0, 0.0, 0.0],
                ),
                quad(
                    [0.0, 0.0, 0.0],
                    [long, 0.0, 0.0],
                    [long, 8.0, 8.0],
                    [0.0, 8.0, 8.0],
                ),
            ]
            .concat(),
        };
        let rest = found(&mesh, r, tolerance);
        let s = ((r + tolerance).powi(2) - r * r).sqrt();
        // The ends are reached from outside a little: within a few percent.
        let want = 2.0 * (r - s) * long;
        assert!(
            (rest.area / want - 1.0).abs() < 0.04,
            "{} {want}",
            rest.area
        );
        // Flanks at 45 degrees, seen from above.
        assert!((rest.plan * 2f64.sqrt() / rest.area - 1.0).abs() < 1e-9);
        assert_eq!(rest.count, 1);
        let spot = rest.spots[0];
        assert!(
            (spot.depth - r * (2f64.sqrt() - 1.0)).abs() < 0.06,
            "{spot:?}"
        );
        // Ten of a hundred micrometres of ball: 0.41 of its radius stand in the corner of any.
        assert!(spot.largest_ball.is_none_or(|b| b < 0.2), "{spot:?}");
    }

    /// A slot with a round bottom of radius 1.5: nothing larger fits, and that one does.
    #[test]
    fn the_largest_ball_is_named() {
        let (r, long) = (1.5f64, 20.0);
        let n = 90;
        let at = |k: i32| {
            let a = std::f64::consts::PI * f64::from(k) / f64::from(n);
            [-r * a.cos(), 3.0 - r * a.sin()]
        };
        let mut triangles = Vec::new();
        for k in 0..n {
            let ([y0, z0], [y1, z1]) = (at(k), at(k + 1));
            triangles.extend(quad(
                [0.0, y0, z0],
                [long, y0, z0],
                [long, y1, z1],
                [0.0, y1, z1],
            ));
        }
        for s in [-1.0, 1.0] {
            triangles.extend(quad(
                [0.0, s * r, 3.0],
                [long, s * r, 3.0],
                [long, s * 9.0, 3.0],
                [0.0, s * 9.0, 3.0],
            ));
        }
        let rest = found(&Mesh { triangles }, 3.0, 0.02);
        assert_eq!(rest.count, 1, "{rest:?}");
        let ball = rest.spots[0].largest_ball.unwrap();
        assert!((1.35..=1.53).contains(&ball), "{rest:?}");
        // All of the half pipe but where the lip is rolled over.
        let pipe = std::f64::consts::PI * r * long;
        assert!(
            rest.area > 0.85 * pipe && rest.area < 1.01 * pipe,
            "{}",
            rest.area / pipe
        );
    }

    #[test]
    fn the_foot_of_an_upright_wall_is_rest_and_a_plain_is_not() {
        let floor = quad(
            [0.0, -9.0, 0.0],
            [30.0, -9.0, 0.0],
            [30.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
        );
        let wall = quad(
            [0.0, 0.0, 0.0],
            [30.0, 0.0, 0.0],
            [30.0, 0.0, 8.0],
            [0.0, 0.0, 8.0],
        );
        let top = quad(
            [0.0, 0.0, 8.0],
            [30.0, 0.0, 8.0],
            [30.0, 9.0, 8.0],
            [0.0, 9.0, 8.0],
        );
        let (r, tolerance) = (3.0f64, 0.02f64);
        let step = Mesh {
            triangles: [floor, wall, top].concat(),
        };
        let rest = found(&step, r, tolerance);
        let s = ((r + tolerance).powi(2) - r * r).sqrt();
        let want = 2.0 * (r - s) * 30.0;
        assert!(
            (rest.area / want - 1.0).abs() < 0.05,
            "{} {want}",
            rest.area
        );
        let plain = Mesh {
            triangles: floor.to_vec(),
        };
        assert_eq!(found(&plain, r, tolerance), Rest::default());
    }
}
