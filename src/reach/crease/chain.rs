//! Places on the edges of a grid, joined through its triangles into ordered chains.

use super::{Crease, CreasePoint};
use crate::geom::{Point2, Vector2};
use crate::reach::grid::ToolCentreGrid;

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
pub(super) fn chain(grid: &ToolCentreGrid, found: &[(u32, CreasePoint)]) -> Vec<Crease> {
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
pub(super) fn forward_only(c: &mut Crease, step: f64) {
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

/// Joins open chains whose ends lie within `gap` and run on into each other, nearest ends first.
pub(super) fn joined(chains: Vec<Crease>, gap: f64) -> Vec<Crease> {
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
