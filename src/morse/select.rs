//! Which extremes and saddles are left when pairs of small persistence are cancelled. The same for grids and meshes.

use super::cancel::Pair;
use super::critical::CriticalKind;

/// A saddle before cancelling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Saddle {
    /// Its node.
    pub node: usize,
    /// Its multiplicity: 2 for a monkey saddle.
    pub arms: u32,
}

/// A critical node that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// What it is.
    pub kind: CriticalKind,
    /// Its node.
    pub node: usize,
    /// Persistence of its pair; for a saddle of the smallest one that is left there.
    pub persistence: f64,
}

/// Cancels every pair below `limit`: its extreme, and one arm of the saddle where it ends. `saddles` by rising node. A saddle with
/// several arms left comes once for each.
pub fn select(peaks: &[Pair], pits: &[Pair], saddles: &[Saddle], limit: f64) -> Vec<Chosen> {
    let mut cancelled = vec![0u32; saddles.len()];
    let mut smallest = vec![f64::INFINITY; saddles.len()];
    let find = |node: usize| saddles.binary_search_by_key(&node, |s| s.node).ok();
    let mut out = Vec::new();
    for (kind, pairs) in [
        (CriticalKind::Maximum, peaks),
        (CriticalKind::Minimum, pits),
    ] {
        for p in pairs {
            let saddle = p.merge.and_then(find);
            if p.persistence < limit {
                if let Some(k) = saddle {
                    cancelled[k] += 1;
                }
                continue;
            }
            if let Some(k) = saddle {
                smallest[k] = smallest[k].min(p.persistence);
            }
            out.push(Chosen {
                kind,
                node: p.extreme,
                persistence: p.persistence,
            });
        }
    }
    for (k, s) in saddles.iter().enumerate() {
        for _ in cancelled[k].min(s.arms)..s.arms {
            out.push(Chosen {
                kind: CriticalKind::Saddle,
                node: s.node,
                persistence: smallest[k],
            });
        }
    }
    out
}
