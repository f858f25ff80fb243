//! Ground that no critical point claimed: slivers join a neighbour, strips are cut along their borders, wide pieces from one tip.

use super::ground::{FAR, Ground};
use super::region::{Feature, FeatureKind, Window};
use super::source::FieldSource;
use crate::reach::NodeKind;

/// Pieces no wider than this many passes from rim to middle are slivers: the passes on their rims, and a fill where a cusp stands
/// over, finish them.
const SLIVER: f64 = 1.25;
/// Pieces no wider than this from rim to middle are strips.
const STRIP: f64 = 4.0;

pub(super) fn leftovers(g: &mut Ground) {
    for piece in pieces(g) {
        let width = piece
            .iter()
            .map(|&n| g.free[n as usize])
            .fold(0.0, f64::max);
        if width <= SLIVER {
            join(g, &piece);
        } else if width <= STRIP.min(FAR - 1.0) {
            strip(g, &piece, width);
        } else {
            remainder(g, &piece);
        }
    }
}

/// Connected pieces of ground not taken, each by rising node, in order of their first node.
fn pieces(g: &Ground) -> Vec<Vec<u32>> {
    let open = |n: usize, g: &Ground| {
        g.grid.kind[n] == NodeKind::Ground && g.free[n] >= 0.0 && g.regions.label[n] == 0
    };
    let mut seen = vec![false; g.grid.len()];
    let mut out = Vec::new();
    for i in 0..g.grid.len() {
        if seen[i] || !open(i, g) {
            continue;
        }
        seen[i] = true;
        let mut piece = vec![i as u32];
        let mut k = 0;
        while k < piece.len() {
            let n = piece[k] as usize;
            k += 1;
            for dy in -1..=1 {
                for dx in -1..=1 {
                    if let Some(j) = g.grid.neighbour(n, (dx, dy))
                        && !seen[j]
                        && open(j, g)
                    {
                        seen[j] = true;
                        piece.push(j as u32);
                    }
                }
            }
        }
        piece.sort_unstable();
        out.push(piece);
    }
    out
}

/// Gives a sliver to the feature it shares most border with (the lower number on a tie).
fn join(g: &mut Ground, piece: &[u32]) {
    let mut shared = vec![0usize; g.regions.features.len() + 1];
    for &n in piece {
        for dy in -1..=1 {
            for dx in -1..=1 {
                if let Some(j) = g.grid.neighbour(n as usize, (dx, dy)) {
                    shared[g.regions.label[j] as usize] += 1;
                }
            }
        }
    }
    shared[0] = 0;
    let owner = (1..shared.len()).max_by_key(|&k| (shared[k], std::cmp::Reverse(k)));
    for &n in piece {
        let i = n as usize;
        let area = g.area_of(i);
        if let Some(k) = owner.filter(|&k| shared[k] > 0) {
            g.regions.label[i] = k as u16;
            g.regions.features[k - 1].area_mm2 += area;
        }
        g.free[i] = -0.5;
    }
}

/// Cuts a strip along the rims beside it: its field is the distance to the nearest rim.
fn strip(g: &mut Ground, piece: &[u32], width: f64) {
    // One ring more, so that the passes reach the strip's ends.
    let mut nodes: Vec<u32> = piece.to_vec();
    for &n in piece {
        for dy in -1..=1 {
            for dx in -1..=1 {
                if let Some(j) = g.grid.neighbour(n as usize, (dx, dy))
                    && g.metric.is_set(j)
                {
                    nodes.push(j as u32);
                }
            }
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    let field = Window::around(g.grid, &nodes, &g.free);
    let n = (width - 0.5).ceil().max(1.0);
    let gap = width / (n + 0.5);
    let label = (g.regions.features.len() + 1).min(u16::MAX as usize) as u16;
    let mut area = 0.0;
    for &n in piece {
        g.regions.label[n as usize] = label;
        area += g.area_of(n as usize);
    }
    g.regions.features.push(Feature {
        kind: FeatureKind::Strip,
        seed: None,
        saddle: None,
        source: FieldSource::Seed,
        free: field.clone(),
        field,
        rim: width,
        levels: (1..=n as usize).map(|k| k as f64 * gap).collect(),
        area_mm2: area,
    });
    for &n in piece {
        g.free[n as usize] = -0.5;
    }
}

/// A wide piece: a field from the node farthest from an arbitrary one, which is a tip of it.
fn remainder(g: &mut Ground, piece: &[u32]) {
    let mut far = (0.0, piece[0] as usize);
    for _ in 0..2 {
        let start = far.1;
        far = (0.0, start);
        let touched = g.march_from(start, &mut |node, v| {
            // A tip is in the piece itself, not in the taken ground beside it.
            if v > far.0 && piece.binary_search(&(node as u32)).is_ok() {
                far = (v, node);
            }
            true
        });
        g.forget(&touched);
    }
    let touched = g.march_from(far.1, &mut |_, _| true);
    g.take(FeatureKind::Remainder, None, None, f64::INFINITY, &touched);
}
