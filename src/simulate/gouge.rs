//! Every centre the program commands, against the part itself: not through any height map, so as exact as the triangles.

use super::depth::Depth;
use super::dry_run::PartContext;
use super::material::Move;
use super::moves::Moves;
use crate::geom::{Box3, Point, Vector};
use crate::reach::Hint;
use rayon::prelude::*;

/// Centres are tried this close together along a move, mm: between two of them a chord over ground as sharp as an edge (the
/// centre then turns on the ball's own radius) hides at most step^2 / (8 R), 0.4 um for a 6 mm ball.
const STEP: f64 = 0.1;
/// Vertical shortfalls below this are not looked into, mm: no gouge is deeper than its vertical shortfall.
const IGNORED: f64 = 2e-4;

/// The deepest gouge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gouge {
    /// Along the normal, mm.
    pub depth: f64,
    /// The ball's centre there.
    pub center: Point,
    /// Line of the program.
    pub line: usize,
}

/// A centre below its resting height.
#[derive(Clone, Copy)]
struct Suspect {
    /// By how much, vertically: an upper bound of the depth.
    low: f64,
    /// The same along the normal of the resting contact: a guess at the depth.
    guess: f64,
    center: Point,
    line: usize,
}

/// Those of the places 0 to n along a move (from `a`, by `d` in all) where the ball may be over the part: a program may wander
/// kilometres beside it.
fn over(bounds: &Box3, radius: f64, a: &Point, d: &Vector, n: usize) -> std::ops::Range<usize> {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for k in 0..2 {
        let (lo, hi) = (bounds.min[k] - radius - a[k], bounds.max[k] + radius - a[k]);
        if d[k] == 0.0 {
            if lo > 0.0 || hi < 0.0 {
                to = -1.0;
            }
        } else {
            let (p, q) = (lo / d[k], hi / d[k]);
            from = from.max(p.min(q));
            to = to.min(p.max(q));
        }
    }
    if from > to {
        return 0..0;
    }
    let n = n as f64;
    // One more at each end for rounding.
    ((from * n).floor() - 1.0).max(0.0) as usize..((to * n).ceil() + 1.0).min(n) as usize + 1
}

/// Moves looked at together where they are not all in memory.
const PIECE: usize = 1 << 18;

/// The deepest gouge of all moves; `None` when no centre lies lower than the ball can rest.
pub fn deepest(moves: &Moves, part: &PartContext) -> Option<Gouge> {
    let mut depth = None;
    let mut best = None;
    moves.pieces(PIECE, &mut |piece| {
        let suspects = suspects(piece, part);
        if !suspects.is_empty() {
            let depth = depth.get_or_insert_with(|| Depth::new(part.mesh, part.drop.radius()));
            best = deeper(best, suspects, depth);
        }
    });
    best
}

/// The centres of some moves that lie lower than the ball can rest: of each move the likeliest and the lowest.
fn suspects(moves: &[Move], part: &PartContext) -> Vec<Suspect> {
    let radius = part.drop.radius();
    let ceiling = part.drop.bounds().max.z + radius;
    moves
        .par_chunks(128)
        .flat_map_iter(|chunk| {
            let mut hint = Hint::default();
            let mut out = Vec::new();
            for m in chunk {
                let (a, b) = (m.segment.from, m.segment.to);
                if a.z >= ceiling && b.z >= ceiling {
                    continue;
                }
                let d = b - a;
                let n = (d.norm() / STEP).ceil().clamp(1.0, 1e7) as usize;
                let mut kept: Option<(Suspect, Suspect)> = None;
                for k in over(&part.drop.bounds(), radius, &a, &d, n) {
                    let c = if k == n {
                        b
                    } else {
                        a + d * (k as f64 / n as f64)
                    };
                    if c.z >= ceiling {
                        continue;
                    }
                    let Some(rest) = part.drop.drop_near(c.x, c.y, &mut hint) else {
                        continue;
                    };
                    let low = rest.center.z - c.z;
                    if low <= IGNORED {
                        continue;
                    }
                    let s = Suspect {
                        low,
                        guess: low * rest.normal_z(),
                        center: c,
                        line: m.line,
                    };
                    // The likeliest and the lowest of each move are looked into.
                    kept = Some(kept.map_or((s, s), |(g, l)| {
                        (
                            if s.guess > g.guess { s } else { g },
                            if s.low > l.low { s } else { l },
                        )
                    }));
                }
                if let Some((g, l)) = kept {
                    out.push(g);
                    if l.center != g.center {
                        out.push(l);
                    }
                }
            }
            out
        })
        .collect()
}

/// The deepest of some suspects and of what was found before.
fn deeper(before: Option<Gouge>, mut suspects: Vec<Suspect>, depth: &Depth) -> Option<Gouge> {
    // Likeliest first; a stable sort keeps program order among equals.
    suspects.sort_by(|a, b| b.guess.total_cmp(&a.guess));
    let mut best = before;
    for chunk in suspects.chunks(256) {
        let floor = best.map_or(0.0, |b| b.depth);
        let found: Vec<Option<Gouge>> = chunk
            .par_iter()
            .map(|s| {
                (s.low > floor).then(|| Gouge {
                    depth: depth.at(&s.center),
                    center: s.center,
                    line: s.line,
                })
            })
            .collect();
        for g in found.into_iter().flatten() {
            if g.depth > best.map_or(0.0, |b| b.depth) {
                best = Some(g);
            }
        }
    }
    best
}
