//! Creases of the tool-centre surface: the lines along which the ball rests on two places of the part at once.
//!
//! ```text
//!    \   ( c )   /        the contact leaps from one wall to the other while the centre stands still:
//!     \_p'   'p_/         |dp| >> |dc|, and the normals turn towards each other (concave)
//!
//!    top ___   ( )        a cliff is the same with a leap in height: the ball falls off an upright wall;
//!           | ( c )       `center` is the ball at the foot, `rise` how far it would jump
//!           |__'p__
//! ```
//!
//! Found on the edges of the grid's triangulation, each place by bisection, joined through the triangles into ordered chains.
//! Crosses the border: a [`ToolCentreGrid`] and its cutter in, chains of resting balls out; work coordinates, mm. Knows nothing of
//! passes or cusps.

use super::drop::{Contact, DropCutter};
use super::grid::{NodeKind, ToolCentreGrid};
use crate::geom::{Point, Point2, Vector, Vector2};
use rayon::prelude::*;

/// What counts as a crease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreaseOptions {
    /// Least angle between the two contact normals, radians: below it lie the facets of curved ground.
    pub angle: f64,
    /// Shortest chain, mm.
    pub shortest: f64,
}

/// A ball that touches in two places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreasePoint {
    /// Its centre; at the foot of a cliff the lower of the two.
    pub center: Point,
    /// Unit vectors from the two contacts to the centre; the first belongs to `center`, the second to the ball a hair beside it.
    pub normals: [Vector; 2],
    /// How much higher the ball a hair beside it rests, mm: 0 in a crease, the height of the leap at a cliff.
    pub rise: f64,
    /// Unit vector in plan from the second ball to the first: at a cliff the way out, away from the wall.
    pub out: Vector2,
}

/// An ordered chain of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Crease {
    /// Along the crease, about a grid step apart.
    pub points: Vec<CreasePoint>,
    /// The last one is followed by the first.
    pub closed: bool,
}

impl Crease {
    /// Length in plan, mm.
    pub fn length(&self) -> f64 {
        let open: f64 = self
            .points
            .windows(2)
            .map(|w| (w[1].center.xy() - w[0].center.xy()).norm())
            .sum();
        let close = match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(a), Some(b)) => (a.center.xy() - b.center.xy()).norm(),
            _ => 0.0,
        };
        open + close
    }
}

/// A place is known to this share of a grid step: below 0.1 um.
const HALVINGS: usize = 13;
/// Heights further apart than this over so short a way are a cliff, mm.
const LEAP: f64 = 0.01;

/// Directions of the three edges a node owns: along X, the diagonal, along Y.
const OWN: [(i32, i32); 3] = [(1, 0), (1, 1), (0, 1)];

/// All creases of a grid. Two drops an edge where the normals turn sharply; linear in the nodes. Same result on any number of
/// threads.
pub fn creases(grid: &ToolCentreGrid, cutter: &DropCutter, options: &CreaseOptions) -> Vec<Crease> {
    let found: Vec<(u32, CreasePoint)> = (0..grid.ny)
        .into_par_iter()
        .flat_map_iter(|iy| {
            let mut out = Vec::new();
            for ix in 0..grid.nx {
                let i = iy * grid.nx + ix;
                for (k, d) in OWN.iter().enumerate() {
                    if let Some(j) = grid.neighbour(i, *d)
                        && suspect(grid, i, j, options.angle)
                        && let Some(p) = bisect(grid, cutter, i, j, options.angle)
                    {
                        out.push(((3 * i + k) as u32, p));
                    }
                }
            }
            out
        })
        .collect();
    let mut chains = chain(grid, &found);
    chains.iter_mut().for_each(|c| forward_only(c, grid.step));
    let mut chains = joined(chains, 2.0 * grid.step);
    chains
        .par_iter_mut()
        .for_each(|c| complete(cutter, c, grid.step, options.angle));
    chains.retain(|c| c.points.len() > 1 && c.length() >= options.shortest);
    chains
}

fn normal_at(grid: &ToolCentreGrid, i: usize) -> Vector {
    (grid.center(i) - grid.point[i]) / grid.radius
}

/// Do the normals turn towards each other by so much that a crease may lie between?
fn suspect(grid: &ToolCentreGrid, i: usize, j: usize, angle: f64) -> bool {
    if grid.kind[i] == NodeKind::Air || grid.kind[j] == NodeKind::Air {
        return false;
    }
    let (u, v) = (normal_at(grid, i), normal_at(grid, j));
    let turned = v - u;
    turned.norm() > 1.6 * (0.5 * angle).sin()
        && turned.dot(&(grid.center(j) - grid.center(i))) < 0.0
}

fn unit(c: &Contact) -> Vector {
    let d = c.center - c.point;
    let l = d.norm();
    if l > 0.0 { d / l } else { Vector::z() }
}

/// The sharpest turn on an edge, closed in on from both sides; `None` when it is a curve and not a crease.
fn bisect(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    i: usize,
    j: usize,
    angle: f64,
) -> Option<CreasePoint> {
    let (a, b) = (grid.xy(i), grid.xy(j));
    between(cutter, &a, &b, angle)
}

/// The sharpest concave turn on the way from a to b in plan: the pair of resting balls on either side of it, a share of
/// 2^-13 of the way apart. `None` when the turn there is less than `angle` (radians) or the ball falls past the part.
pub fn between(cutter: &DropCutter, a: &Point2, b: &Point2, angle: f64) -> Option<CreasePoint> {
    let d = b - a;
    let r = cutter.radius();
    let (mut lo, mut hi) = (cutter.drop(a.x, a.y)?, cutter.drop(b.x, b.y)?);
    let (mut t_lo, mut t_hi) = (0.0, 1.0);
    let apart = |p: &Contact, q: &Contact| {
        (unit(q) - unit(p)).norm_squared() + ((q.center.z - p.center.z) / r).powi(2)
    };
    for _ in 0..HALVINGS {
        let t = 0.5 * (t_lo + t_hi);
        let q = a + d * t;
        let mid = cutter.drop(q.x, q.y)?;
        if apart(&lo, &mid) <= apart(&mid, &hi) {
            (lo, t_lo) = (mid, t);
        } else {
            (hi, t_hi) = (mid, t);
        }
    }
    let (u, v) = (unit(&lo), unit(&hi));
    let turned = v - u;
    if turned.norm() < 2.0 * (0.5 * angle).sin() || turned.dot(&(hi.center - lo.center)) > 0.0 {
        return None;
    }
    let along = d / d.norm().max(1e-300);
    let leap = hi.center.z - lo.center.z;
    Some(if leap >= 0.0 {
        CreasePoint {
            center: lo.center,
            normals: [u, v],
            rise: if leap > LEAP { leap } else { 0.0 },
            out: -along,
        }
    } else {
        CreasePoint {
            center: hi.center,
            normals: [v, u],
            rise: if -leap > LEAP { -leap } else { 0.0 },
            out: along,
        }
    })
}

/// The three edges (ids `3 * node + direction`) of the triangles of a cell.
fn triangles_of(grid: &ToolCentreGrid, i: usize) -> Option<[[u32; 3]; 2]> {
    let right = grid.neighbour(i, (1, 0))?;
    let up = grid.neighbour(i, (0, 1))?;
    let e = |n: usize, k: usize| (3 * n + k) as u32;
    Some([
        [e(i, 0), e(right, 2), e(i, 1)],
        [e(i, 2), e(up, 0), e(i, 1)],
    ])
}

/// Joins places through the triangles. Where three meet in one triangle, the two that run on straightest are joined and the third
/// ends there.
fn chain(grid: &ToolCentreGrid, found: &[(u32, CreasePoint)]) -> Vec<Crease> {
    let index = |edge: u32| found.binary_search_by_key(&edge, |f| f.0).ok();
    // Each place has at most two triangles beside it, so at most two links.
    let mut links: Vec<[Option<u32>; 2]> = vec![[None; 2]; found.len()];
    let mut forks: Vec<[u32; 3]> = Vec::new();
    let mut cells: Vec<usize> = Vec::new();
    for (edge, _) in found {
        let (n, k) = ((*edge / 3) as usize, *edge % 3);
        cells.push(n);
        let other = match k {
            0 => grid.neighbour(n, (0, -1)),
            2 => grid.neighbour(n, (-1, 0)),
            _ => None,
        };
        cells.extend(other);
    }
    cells.sort_unstable();
    cells.dedup();
    for &cell in &cells {
        let Some(triangles) = triangles_of(grid, cell) else {
            continue;
        };
        for t in triangles {
            let here: Vec<u32> = t
                .iter()
                .filter_map(|&e| index(e))
                .map(|k| k as u32)
                .collect();
            match here[..] {
                [a, b] => link_up(&mut links, a, b),
                [a, b, c] => forks.push([a, b, c]),
                _ => {}
            }
        }
    }
    // Straightest pair through a fork: the third chain ends there.
    let headings: Vec<[Option<Vector2>; 3]> = forks
        .iter()
        .map(|f| f.map(|k| heading(found, &links, k)))
        .collect();
    for (f, dirs) in forks.iter().zip(&headings) {
        let score = |a: usize, b: usize| match (dirs[a], dirs[b]) {
            (Some(u), Some(v)) => u.dot(&v),
            _ => 0.0,
        };
        let best = [(0, 1), (1, 2), (0, 2)].into_iter().reduce(|p, q| {
            if score(q.0, q.1) < score(p.0, p.1) {
                q
            } else {
                p
            }
        });
        if let Some((a, b)) = best {
            link_up(&mut links, f[a], f[b]);
        }
    }
    walk(found, &links)
}

/// Links two places both ways, where either has a link to spare.
fn link_up(links: &mut [[Option<u32>; 2]], a: u32, b: u32) {
    for (p, q) in [(a, b), (b, a)] {
        let l = &mut links[p as usize];
        if l[0].is_none() {
            l[0] = Some(q);
        } else if l[1].is_none() {
            l[1] = Some(q);
        }
    }
}

/// The way a chain comes from, seen from one of its ends: unit vector from a few places back to the end.
fn heading(found: &[(u32, CreasePoint)], links: &[[Option<u32>; 2]], end: u32) -> Option<Vector2> {
    let mut last = end;
    let mut here = links[end as usize][0]?;
    for _ in 0..3 {
        let l = links[here as usize];
        let next = if l[0] == Some(last) { l[1] } else { l[0] };
        let Some(n) = next else { break };
        (last, here) = (here, n);
    }
    let d = found[end as usize].1.center.xy() - found[here as usize].1.center.xy();
    let l = d.norm();
    (l > 0.0).then(|| d / l)
}

/// Follows the links: open chains from their ends, lowest place first, then the closed ones.
fn walk(found: &[(u32, CreasePoint)], links: &[[Option<u32>; 2]]) -> Vec<Crease> {
    let mut used = vec![false; found.len()];
    let mut out = Vec::new();
    for closed in [false, true] {
        for start in 0..found.len() {
            let ends = links[start].iter().flatten().count();
            if used[start] || (!closed && ends == 2) {
                continue;
            }
            let mut ids = vec![start as u32];
            used[start] = true;
            let mut here = start as u32;
            let mut back = false;
            while let Some(n) = links[here as usize]
                .iter()
                .flatten()
                .copied()
                .find(|n| !used[*n as usize])
            {
                used[n as usize] = true;
                ids.push(n);
                here = n;
            }
            if closed {
                back = ids.len() > 2 && links[here as usize].contains(&Some(start as u32));
            }
            let points = ids.iter().map(|k| found[*k as usize].1).collect();
            out.push(Crease {
                points,
                closed: back,
            });
        }
    }
    out
}

/// Drops places that lie back along the chain (where the crease runs along an edge of the grid, the place on that edge is any).
fn forward_only(c: &mut Crease, step: f64) {
    let mut out: Vec<CreasePoint> = Vec::with_capacity(c.points.len());
    for p in &c.points {
        while let [.., a, b] = out[..] {
            let (u, v) = (b.center.xy() - a.center.xy(), p.center.xy() - b.center.xy());
            if u.dot(&v) < 0.0 && u.norm().min(v.norm()) < step {
                out.pop();
            } else {
                break;
            }
        }
        if out
            .last()
            .is_none_or(|l| (p.center.xy() - l.center.xy()).norm() > 0.1 * step)
        {
            out.push(*p);
        }
    }
    c.points = out;
}

/// Turns sharper than this between two places are corners, radians.
const CORNER: f64 = 0.25;
/// Places looked back over for the way a chain runs.
const BASE: usize = 4;

/// Puts in what the edges of the grid do not meet: corners, where the ball touches in three places, and the ends.
fn complete(cutter: &DropCutter, c: &mut Crease, step: f64, angle: f64) {
    let n = c.points.len();
    if n < 3 {
        return;
    }
    let at = |k: isize| -> Option<&CreasePoint> {
        if c.closed {
            c.points.get(k.rem_euclid(n as isize) as usize)
        } else {
            usize::try_from(k).ok().and_then(|k| c.points.get(k))
        }
    };
    // The way the chain runs into place k, looking back (`sign` -1) or from its other side (+1).
    let way = |k: isize, sign: isize| -> Option<Vector2> {
        let here = at(k)?.center.xy();
        let mut d = None;
        for b in 1..=BASE as isize {
            let Some(p) = at(k + sign * b) else { break };
            let v = here - p.center.xy();
            let l = v.norm();
            // As far back as it runs straight.
            match d {
                Some(u) if l > 0.0 && (v / l).dot(&u) < (0.5 * CORNER).cos() => break,
                _ if l > 0.0 => d = Some(v / l),
                _ => {}
            }
        }
        d
    };
    let reach = 2.0 * step;
    // With each place, whether it was put in.
    let mut out: Vec<(CreasePoint, bool)> = Vec::with_capacity(n + 8);
    if !c.closed
        && let (Some(p), Some(d)) = (at(0), way(0, 1))
    {
        out.extend(led_on(cutter, p, &d, reach, step, angle).map(|p| (p, true)));
    }
    for k in 0..n as isize {
        let Some(p) = at(k) else { break };
        out.push((*p, false));
        let (Some(q), Some(u), Some(v)) = (at(k + 1), way(k, -1), way(k + 1, 1)) else {
            continue;
        };
        let gap = (q.center.xy() - p.center.xy()).norm();
        if -u.dot(&v) > CORNER.cos() || gap > reach {
            continue;
        }
        let first = led_on(cutter, p, &u, reach, step, angle);
        let second = led_on(cutter, q, &v, reach, step, angle);
        out.extend(first.map(|p| (p, true)));
        if let Some(s) = second
            && first.is_none_or(|f| (f.center.xy() - s.center.xy()).norm() > 2e-3)
        {
            out.push((s, true));
        }
    }
    if !c.closed
        && let (Some(p), Some(d)) = (at(n as isize - 1), way(n as isize - 1, -1))
    {
        out.extend(led_on(cutter, p, &d, reach, step, angle).map(|p| (p, true)));
    }
    // A place of the grid right beside a corner only makes the path stutter.
    let n = out.len();
    let near = |k: usize, l: usize| {
        out[l].1 && (out[l].0.center.xy() - out[k].0.center.xy()).norm() < 0.3 * step
    };
    c.points = (0..n)
        .filter(|&k| {
            let beside = [k.checked_sub(1), (k + 1 < n).then_some(k + 1)];
            out[k].1 || !beside.into_iter().flatten().any(|l| near(k, l))
        })
        .map(|k| out[k].0)
        .collect();
}

/// The last place on the way on from `p` along `d` at which the ball still touches the same two walls; `None` when it does not even
/// a little way on.
fn led_on(
    cutter: &DropCutter,
    p: &CreasePoint,
    d: &Vector2,
    reach: f64,
    step: f64,
    angle: f64,
) -> Option<CreasePoint> {
    let across = Vector2::new(-d.y, d.x);
    let across = if across.dot(&p.out) < 0.0 {
        -across
    } else {
        across
    };
    let same = |t: f64| -> Option<CreasePoint> {
        let q = p.center.xy() + d * t;
        let w = across * (0.02 * step + 0.1 * t);
        let found = between(cutter, &(q + w), &(q - w), angle)?;
        let alike = |u: &Vector, v: &Vector| u.dot(v) > (0.4 * angle).cos();
        let [a, b] = found.normals;
        let [u, v] = p.normals;
        let cliffs = (found.rise > 0.0) == (p.rise > 0.0);
        (cliffs && (alike(&a, &u) && alike(&b, &v) || alike(&a, &v) && alike(&b, &u)))
            .then_some(found)
    };
    let mut best = None;
    let (mut lo, mut hi) = (0.0, reach);
    if let Some(f) = same(reach) {
        return Some(f);
    }
    while hi - lo > 1e-3 * step {
        let t = 0.5 * (lo + hi);
        match same(t) {
            Some(f) => {
                best = Some(f);
                lo = t;
            }
            None => hi = t,
        }
    }
    best
}

/// Joins open chains whose ends lie within `gap` and run on into each other, nearest ends first.
fn joined(chains: Vec<Crease>, gap: f64) -> Vec<Crease> {
    // End 2 i is the first point of chain i, end 2 i + 1 its last; with the way each chain leaves it.
    let mut ends: Vec<(Point2, Vector2, usize)> = Vec::new();
    for (i, c) in chains.iter().enumerate() {
        let n = c.points.len();
        if c.closed || n < 2 {
            continue;
        }
        let at = |k: usize| c.points[k].center.xy();
        for (k, from, to) in [(0, 3.min(n - 1), 0), (1, n.saturating_sub(4), n - 1)] {
            let d = at(to) - at(from);
            if d.norm() > 0.0 {
                ends.push((at(to), d / d.norm(), 2 * i + k));
            }
        }
    }
    ends.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.2.cmp(&b.2)));
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (s, (p, u, i)) in ends.iter().enumerate() {
        for (q, v, j) in &ends[s + 1..] {
            if q.x - p.x > gap {
                break;
            }
            let d = (q - p).norm();
            if d < gap && i / 2 != j / 2 && u.dot(v) < -0.8 {
                pairs.push((d, *i.min(j), *i.max(j)));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut mate: Vec<Option<usize>> = vec![None; 2 * chains.len()];
    for (_, i, j) in pairs {
        if mate[i].is_none() && mate[j].is_none() {
            mate[i] = Some(j);
            mate[j] = Some(i);
        }
    }
    let mut used = vec![false; chains.len()];
    let mut out = Vec::new();
    // Free ends first, then the rings that joining closed.
    for rings in [false, true] {
        for start in 0..2 * chains.len() {
            if used[start / 2] || (!rings && mate[start].is_some()) {
                continue;
            }
            let mut whole = Crease {
                points: Vec::new(),
                closed: chains[start / 2].closed || rings && mate[start].is_some(),
            };
            let mut entered = start;
            loop {
                used[entered / 2] = true;
                let c = &chains[entered / 2];
                if entered.is_multiple_of(2) {
                    whole.points.extend(c.points.iter().copied());
                } else {
                    whole.points.extend(c.points.iter().rev().copied());
                }
                match mate[entered ^ 1] {
                    Some(next) if !used[next / 2] => entered = next,
                    _ => break,
                }
            }
            out.push(whole);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use crate::reach::{GridOptions, GridPlan};

    fn surveyed(triangles: Vec<[Point; 3]>, radius: f64) -> (ToolCentreGrid, DropCutter) {
        let cutter = DropCutter::new(&Mesh { triangles }, radius);
        let how = GridOptions {
            step: 0.13,
            memory_limit_bytes: 1 << 30,
        };
        let plan = GridPlan::new(&cutter, &how).unwrap();
        (ToolCentreGrid::new(&cutter, &plan).unwrap(), cutter)
    }

    fn quad(p: [[f64; 3]; 4]) -> [[Point; 3]; 2] {
        let [a, b, c, d] = p.map(|v| Point::new(v[0], v[1], v[2]));
        [[a, b, c], [a, c, d]]
    }

    const OPTIONS: CreaseOptions = CreaseOptions {
        angle: 0.14,
        shortest: 0.3,
    };

    /// A groove at an angle to the grid: one chain, straight above its bottom, R / cos(45 degrees) high, both flanks' normals.
    #[test]
    fn a_groove_is_one_chain_in_its_place() {
        let (r, turn) = (2.0f64, 0.4f64);
        let at = |u: f64, v: f64, z: f64| {
            [
                u * turn.cos() - v * turn.sin(),
                u * turn.sin() + v * turn.cos(),
                z,
            ]
        };
        let (grid, cutter) = surveyed(
            [
                quad([
                    at(0.0, -5.0, 5.0),
                    at(15.0, -5.0, 5.0),
                    at(15.0, 0.0, 0.0),
                    at(0.0, 0.0, 0.0),
                ]),
                quad([
                    at(0.0, 0.0, 0.0),
                    at(15.0, 0.0, 0.0),
                    at(15.0, 5.0, 5.0),
                    at(0.0, 5.0, 5.0),
                ]),
            ]
            .concat(),
            r,
        );
        let found = creases(&grid, &cutter, &OPTIONS);
        assert_eq!(found.len(), 1, "{found:?}");
        let inner: Vec<&CreasePoint> = found[0]
            .points
            .iter()
            .filter(|p| {
                let u = p.center.x * turn.cos() + p.center.y * turn.sin();
                u > 0.1 && u < 14.9
            })
            .collect();
        assert!(inner.len() > 90);
        for p in inner {
            let v = p.center.y * turn.cos() - p.center.x * turn.sin();
            assert!(v.abs() < 1e-4, "{p:?}");
            assert!((p.center.z - r * 2f64.sqrt()).abs() < 1e-4);
            assert!(p.normals[0].dot(&p.normals[1]).abs() < 1e-3 && p.rise == 0.0);
        }
        // No stutter: it only goes forward.
        let d = found[0].points.last().unwrap().center - found[0].points[0].center;
        assert!(
            found[0]
                .points
                .windows(2)
                .all(|w| (w[1].center - w[0].center).dot(&d) > 0.0)
        );
    }

    /// The floor of a square pocket with upright walls: a leap one radius off each wall, corners found to a micrometre.
    #[test]
    fn the_foot_of_walls_and_its_corners() {
        let (r, h, s) = (2.0f64, 5.0f64, 6.0f64);
        let mut t = quad([[-s, -s, 0.0], [s, -s, 0.0], [s, s, 0.0], [-s, s, 0.0]]).to_vec();
        for k in 0..4 {
            let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_2).sin_cos();
            let at = |x: f64, y: f64, z: f64| {
                [(x * cos - y * sin).round(), (x * sin + y * cos).round(), z]
            };
            t.extend(quad([
                at(s, -s, 0.0),
                at(s, s, 0.0),
                at(s, s, h),
                at(s, -s, h),
            ]));
            t.extend(quad([
                at(s, -s, h),
                at(9.0, -9.0, h),
                at(9.0, 9.0, h),
                at(s, s, h),
            ]));
        }
        let (grid, cutter) = surveyed(t, r);
        let found = creases(&grid, &cutter, &OPTIONS);
        let inside = s - r;
        let leaps: Vec<&CreasePoint> = found
            .iter()
            .flat_map(|c| &c.points)
            .filter(|p| p.rise > 0.0)
            .collect();
        assert!(leaps.len() > 100);
        for p in &leaps {
            let off = p.center.x.abs().max(p.center.y.abs());
            assert!((off - inside).abs() < 1e-3, "{p:?}");
            assert!(
                (p.center.z - r).abs() < 1e-6 && (p.rise - (h - r)).abs() < 0.05,
                "{p:?}"
            );
        }
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let miss = leaps
                .iter()
                .map(|p| (p.center.xy() - Point2::new(x * inside, y * inside)).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(miss < 3e-3, "corner {x} {y} missed by {miss}");
        }
    }

    #[test]
    fn plains_and_ridges_have_none() {
        let flat = quad([
            [0.0, 0.0, 0.0],
            [9.0, 0.0, 0.0],
            [9.0, 9.0, 0.0],
            [0.0, 9.0, 0.0],
        ]);
        let (grid, cutter) = surveyed(flat.to_vec(), 2.0);
        assert_eq!(creases(&grid, &cutter, &OPTIONS), Vec::new());
        let ridge = [
            quad([
                [0.0, -5.0, -5.0],
                [9.0, -5.0, -5.0],
                [9.0, 0.0, 0.0],
                [0.0, 0.0, 0.0],
            ]),
            quad([
                [0.0, 0.0, 0.0],
                [9.0, 0.0, 0.0],
                [9.0, 5.0, -5.0],
                [0.0, 5.0, -5.0],
            ]),
        ]
        .concat();
        let (grid, cutter) = surveyed(ridge, 2.0);
        assert_eq!(creases(&grid, &cutter, &OPTIONS), Vec::new());
    }
}
