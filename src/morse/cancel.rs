//! Persistence: which critical points are noise.
//!
//! Flood the surface from below: each pit starts a lake, and where two lakes meet the shallower one ends. The depth at which it
//! ends is its persistence, and the meeting place its partner. Peaks likewise, from above. Pairs of small persistence are
//! cancelled. (H. Edelsbrunner, D. Letscher, A. Zomorodian, *Topological persistence and simplification*, 2002.)

use rayon::prelude::*;

/// A scalar on the nodes of a graph: the ground of a grid, or the vertices of a mesh.
pub trait Graph: Sync {
    /// Number of nodes, active or not.
    fn len(&self) -> usize;
    /// Whether a node takes part.
    fn is_active(&self, node: usize) -> bool;
    /// Its value; a number, for an active node.
    fn value(&self, node: usize) -> f64;
    /// Shows each active neighbour of a node.
    fn each_neighbour(&self, node: usize, see: &mut dyn FnMut(usize));
    /// True without nodes.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// An extreme node and the node where it would be merged away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The peak or pit.
    pub extreme: usize,
    /// Where it meets an older one; `None` for the last one of its connected piece.
    pub merge: Option<usize>,
    /// The older one it meets there.
    pub into: Option<usize>,
    /// Difference of the values, in the function's unit; infinite without a partner.
    pub persistence: f64,
}

/// All pits with their partners, by rising node number. O(n log n).
pub fn pits(s: &impl Graph) -> Vec<Pair> {
    pairs(s, false)
}

/// All peaks with their partners, by rising node number. O(n log n).
pub fn peaks(s: &impl Graph) -> Vec<Pair> {
    pairs(s, true)
}

const NOBODY: u32 = u32::MAX;

fn pairs(s: &impl Graph, from_above: bool) -> Vec<Pair> {
    let n = s.len();
    let mut order: Vec<u32> = (0..n as u32).filter(|&i| s.is_active(i as usize)).collect();
    order.par_sort_unstable_by(|&a, &b| {
        let o = s
            .value(a as usize)
            .total_cmp(&s.value(b as usize))
            .then(a.cmp(&b));
        if from_above { o.reverse() } else { o }
    });
    let mut rank = vec![NOBODY; n];
    for (k, &i) in order.iter().enumerate() {
        rank[i as usize] = k as u32;
    }
    // Union-find; the root of a lake is the node it started from.
    let mut parent = vec![NOBODY; n];
    let find = |parent: &mut Vec<u32>, mut i: u32| {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    };
    let mut out = Vec::new();
    for &i in &order {
        let node = i as usize;
        let mut oldest = NOBODY;
        parent[node] = i;
        s.each_neighbour(node, &mut |j| {
            if parent[j] == NOBODY {
                return; // not flooded yet
            }
            let root = find(&mut parent, j as u32);
            if root == i || root == oldest {
                return;
            }
            if oldest == NOBODY {
                oldest = root;
                return;
            }
            let (old, young) = if rank[oldest as usize] < rank[root as usize] {
                (oldest, root)
            } else {
                (root, oldest)
            };
            out.push(Pair {
                extreme: young as usize,
                merge: Some(node),
                into: Some(old as usize),
                persistence: (s.value(node) - s.value(young as usize)).abs(),
            });
            parent[young as usize] = old;
            oldest = old;
        });
        if oldest != NOBODY {
            parent[node] = oldest;
        }
    }
    for &i in &order {
        if parent[i as usize] == i {
            out.push(Pair {
                extreme: i as usize,
                merge: None,
                into: None,
                persistence: f64::INFINITY,
            });
        }
    }
    out.sort_by_key(|p| p.extreme);
    out
}

#[cfg(test)]
mod tests {
    use super::super::critical::Scalar;
    use super::*;

    #[test]
    fn two_lakes_meet_at_the_pass() {
        // Heights along a row: pit 0 at the left, pit 1 in the middle, a pass of 3 between them.
        let value = [0.0, 3.0, 1.0, 5.0];
        let s = Scalar {
            nx: 4,
            value: &value,
            active: &[true; 4],
        };
        assert_eq!(
            pits(&s),
            vec![
                Pair {
                    extreme: 0,
                    merge: None,
                    into: None,
                    persistence: f64::INFINITY
                },
                Pair {
                    extreme: 2,
                    merge: Some(1),
                    into: Some(0),
                    persistence: 2.0
                }
            ]
        );
        assert_eq!(
            peaks(&s),
            vec![
                Pair {
                    extreme: 1,
                    merge: Some(2),
                    into: Some(3),
                    persistence: 2.0
                },
                Pair {
                    extreme: 3,
                    merge: None,
                    into: None,
                    persistence: f64::INFINITY
                }
            ]
        );
    }
}
