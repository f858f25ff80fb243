//! Euler's number against the critical points: peaks - saddles + pits.
//!
//! ```text
//!   over a closed surface the sum is the Euler number (ball 2, torus 0); on a border each critical point counts half:
//!   2 * inside + border = 2 * (vertices - edges + triangles)
//! ```
//!
//! The half is that of the doubled surface: glue the sheet to its mirror image along its border, and what is inside comes twice. A
//! border vertex whose half link changes sides more than once is a half saddle; it never starts or ends a feature.

use super::critical::{Link, Scalar, classify};
use super::surface::Surface;
use crate::reach::LINK;

/// The sum and what it must be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Euler {
    /// Vertices - edges + triangles: 2 for a ball, 0 for a torus or a ring, 1 for a disc; summed over pieces.
    pub characteristic: i64,
    /// Peaks - saddles (with multiplicity) + pits off the border.
    pub inside: i64,
    /// The same on the border, half saddles with multiplicity.
    pub border: i64,
}

impl Euler {
    /// True where the sums agree, as they must on any surface that branches nowhere.
    pub fn holds(&self) -> bool {
        2 * self.inside + self.border == 2 * self.characteristic
    }

    /// Counts over the triangles whose three nodes are active.
    pub(super) fn of_grid(s: &Scalar) -> Euler {
        let mut e = Euler::default();
        for i in (0..s.value.len()).filter(|&i| s.active[i]) {
            let there = |k: usize| s.neighbour(i, LINK[k % 6]);
            e.characteristic += 1;
            // Edges and triangles at the node that is lowest in the plan: see LINK.
            for k in 0..3 {
                e.characteristic -= i64::from(there(k).is_some());
            }
            for k in 0..2 {
                e.characteristic += i64::from(there(k).is_some() && there(k + 1).is_some());
            }
            let (link, border) = classify(s, i);
            if !border {
                e.inside += match link {
                    Link::Maximum | Link::Minimum => 1,
                    Link::Saddle(arms) => -i64::from(arms),
                    Link::Regular => 0,
                };
                continue;
            }
            // Runs of lower and of higher neighbours along the pieces of the link.
            let side = |k: usize| there(k).map(|j| s.lower(j, i));
            let runs = (0..6)
                .filter(|&k| side(k).is_some() && side(k) != side(k + 5))
                .count() as i64;
            e.border += 2 - runs;
        }
        e
    }

    /// Counts over a surface with a value at each vertex; ties by number.
    pub fn of_surface(surface: &Surface, value: &[f64]) -> Euler {
        let (low, high) = indices(surface, value);
        let mut e = Euler {
            characteristic: surface.euler(),
            ..Euler::default()
        };
        for v in 0..surface.len() {
            if surface.border[v] {
                e.border += i64::from(low[v]) + i64::from(high[v]);
            } else {
                e.inside += i64::from(low[v]);
            }
        }
        e
    }
}

/// For each vertex 1 - Euler number of the lower part of its link, and the same of the upper part: 1 for a pit (a peak), 0 where
/// nothing happens, -1 for a saddle, -2 for a monkey saddle. On closed surfaces both are equal, and a peak and a pit both 1.
pub(super) fn indices(surface: &Surface, value: &[f64]) -> (Vec<i32>, Vec<i32>) {
    let lower = |a: u32, b: u32| (value[a as usize], a) < (value[b as usize], b);
    let mut low = vec![1i32; surface.len()];
    let mut high = low.clone();
    for e in &surface.edges {
        let (a, b) = if lower(e[0], e[1]) {
            (e[0], e[1])
        } else {
            (e[1], e[0])
        };
        low[b as usize] -= 1;
        high[a as usize] -= 1;
    }
    for t in &surface.triangles {
        let top = t
            .iter()
            .copied()
            .reduce(|a, b| if lower(a, b) { b } else { a });
        let bottom = t
            .iter()
            .copied()
            .reduce(|a, b| if lower(a, b) { a } else { b });
        if let (Some(top), Some(bottom)) = (top, bottom) {
            low[top as usize] += 1;
            high[bottom as usize] += 1;
        }
    }
    (low, high)
}
