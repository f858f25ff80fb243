//! Level curves of a scalar on the triangulated grid, joined into chains.
//!
//! Marching triangles; each curve point lies on an edge of the triangulation. A node exactly on a level counts as above it, always:
//! an edge is crossed where `lo < level <= hi`. So no curve passes through a node, and each triangle holds one piece of each
//! level or none. Pieces are joined by the edge they share, in linear time after one sort.

use crate::geom::Point2;
use crate::reach::ToolCentreGrid;
use rayon::prelude::*;

/// One connected level curve in plan, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelCurve {
    /// Index into the levels asked for.
    pub level: usize,
    /// Where it runs, from edge to edge.
    pub at: Vec<EdgePoint>,
    /// It returns to its first point (which is not repeated).
    pub closed: bool,
}

/// A point on an edge of the triangulation: `t` of the way from node `a` to node `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// Lower node.
    pub a: u32,
    /// Higher node (by index).
    pub b: u32,
    /// Share of the way.
    pub t: f64,
}

impl EdgePoint {
    /// Place in plan.
    #[inline]
    pub fn xy(&self, grid: &ToolCentreGrid) -> Point2 {
        let (a, b) = (grid.xy(self.a as usize), grid.xy(self.b as usize));
        a + (b - a) * self.t
    }

    /// Another scalar at the same place, linear along the edge.
    #[inline]
    pub fn value(&self, of: impl Fn(usize) -> f64) -> f64 {
        let (a, b) = (of(self.a as usize), of(self.b as usize));
        a + (b - a) * self.t
    }
}

#[derive(Clone, Copy)]
struct Piece {
    level: u32,
    /// Edges as (node, direction 0 = +x, 1 = diagonal, 2 = +y), packed.
    ends: [u64; 2],
}

/// Curves of `value` at rising `levels`. Triangles with a corner without a finite value are left out. Ordered by level, then by their
/// first edge.
pub fn level_curves(
    grid: &ToolCentreGrid,
    value: &(dyn Fn(usize) -> f64 + Sync),
    levels: &[f64],
) -> Vec<LevelCurve> {
    if levels.is_empty() || grid.ny < 2 {
        return Vec::new();
    }
    let nx = grid.nx;
    let mut pieces: Vec<Piece> = (0..grid.ny - 1)
        .into_par_iter()
        .flat_map_iter(|iy| {
            let mut row = Vec::new();
            for ix in 0..nx - 1 {
                let o = iy * nx + ix;
                let (e, d, n) = (o + 1, o + nx + 1, o + nx);
                let edge = |node: usize, dir: u64| (node as u64) * 3 + dir;
                // Two triangles a cell; the edge opposite to corner k is sides[k].
                for (corners, sides) in [
                    ([o, e, d], [edge(e, 2), edge(o, 1), edge(o, 0)]),
                    ([o, d, n], [edge(n, 0), edge(o, 2), edge(o, 1)]),
                ] {
                    let v = corners.map(value);
                    if !v.iter().all(|x| x.is_finite()) {
                        continue;
                    }
                    let lo = v[0].min(v[1]).min(v[2]);
                    let hi = v[0].max(v[1]).max(v[2]);
                    // First level above lo.
                    let first = levels.partition_point(|&c| c <= lo);
                    for (k, &c) in levels.iter().enumerate().skip(first) {
                        if c > hi {
                            break;
                        }
                        let above = v.map(|x| x >= c);
                        // The corner that stands alone: the curve crosses the two sides it lies on.
                        let alone = if above[1] == above[2] {
                            0
                        } else if above[0] == above[2] {
                            1
                        } else {
                            2
                        };
                        row.push(Piece {
                            level: k as u32,
                            ends: [sides[(alone + 1) % 3], sides[(alone + 2) % 3]],
                        });
                    }
                }
            }
            row
        })
        .collect();
    pieces.sort_unstable_by_key(|p| (p.level, p.ends));
    join(grid, value, levels, &pieces)
}

fn join(
    grid: &ToolCentreGrid,
    value: &(dyn Fn(usize) -> f64 + Sync),
    levels: &[f64],
    pieces: &[Piece],
) -> Vec<LevelCurve> {
    // Each (level, edge) belongs to one piece at a border, to two elsewhere.
    let mut ends: Vec<(u32, u64, u32)> = pieces
        .iter()
        .enumerate()
        .flat_map(|(i, p)| p.ends.map(|e| (p.level, e, i as u32)))
        .collect();
    ends.sort_unstable();
    let at = |level: u32, edge: u64| {
        let from = ends.partition_point(|&(l, e, _)| (l, e) < (level, edge));
        ends[from..]
            .iter()
            .take_while(move |&&(l, e, _)| (l, e) == (level, edge))
            .map(|&(_, _, i)| i)
    };
    let mut used = vec![false; pieces.len()];
    let mut curves = Vec::new();
    let mut walk = |start: usize, from: u64, used: &mut Vec<bool>, closed: bool| {
        let level = pieces[start].level;
        let mut edges = vec![from];
        let mut piece = start;
        let mut end = from;
        loop {
            used[piece] = true;
            let p = &pieces[piece];
            end = if p.ends[0] == end {
                p.ends[1]
            } else {
                p.ends[0]
            };
            if closed && end == from {
                break;
            }
            edges.push(end);
            match at(level, end).find(|&i| !used[i as usize]) {
                Some(i) => piece = i as usize,
                None => break,
            }
        }
        let c = levels[level as usize];
        let points = edges
            .into_iter()
            .map(|e| {
                let a = (e / 3) as usize;
                let b = a + [1, grid.nx + 1, grid.nx][(e % 3) as usize];
                let (va, vb) = (value(a), value(b));
                EdgePoint {
                    a: a as u32,
                    b: b as u32,
                    t: ((c - va) / (vb - va)).clamp(0.0, 1.0),
                }
            })
            .collect();
        curves.push(LevelCurve {
            level: level as usize,
            at: points,
            closed,
        });
    };
    for i in 0..pieces.len() {
        for e in pieces[i].ends {
            if !used[i] && at(pieces[i].level, e).count() == 1 {
                walk(i, e, &mut used, false);
            }
        }
    }
    for i in 0..pieces.len() {
        if !used[i] {
            walk(i, pieces[i].ends[0], &mut used, true);
        }
    }
    curves.sort_by_key(|c| (c.level, c.at[0].a, c.at[0].b));
    curves
}
