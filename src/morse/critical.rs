//! Critical nodes of a scalar on the triangulated grid, by the link rule.
//!
//! Banchoff's rule on the six neighbours: walk round the link and count how often it changes between lower and higher.
//!
//! ```text
//!   none, all higher: minimum      none, all lower: maximum      2: regular      4: saddle      6: monkey saddle
//! ```
//!
//! On the boundary the paper's rule holds: only nodes strictly above or below *every* neighbour are critical there, and never
//! saddles. Ties are decided by index, so a flat top has one peak. (T. F. Banchoff, *Critical points and curvature for embedded
//! polyhedral surfaces*, 1970; simulation of simplicity after Edelsbrunner and Mücke, 1990.)

use super::cancel::Graph;
use crate::geom::Point;
use crate::reach::LINK;

/// What kind of critical point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CriticalKind {
    /// A peak.
    Maximum,
    /// A pit.
    Minimum,
    /// A pass between two peaks or two pits.
    Saddle,
}

/// A critical point that matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalPoint {
    /// What it is.
    pub kind: CriticalKind,
    /// Node of the grid, or vertex of the mesh.
    pub node: usize,
    /// On the border of the ground.
    pub boundary: bool,
    /// The ball's centre there, refined below the grid's step; on a mesh the vertex itself. Work coordinates, mm.
    pub center: Point,
    /// The part's point touched there.
    pub contact: Point,
    /// Value of the Morse function there, in its unit.
    pub value: f64,
    /// Difference of the values to the critical point it would cancel with; infinite for the last of its kind. For a saddle the
    /// smaller of its pairs.
    pub persistence: f64,
}

/// A scalar on some of the nodes of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Scalar<'a> {
    /// Nodes along X.
    pub nx: usize,
    /// Value per node.
    pub value: &'a [f64],
    /// Which nodes take part.
    pub active: &'a [bool],
}

impl Scalar<'_> {
    /// The active neighbour in direction `d` of the triangulation.
    #[inline]
    pub fn neighbour(&self, node: usize, d: (i32, i32)) -> Option<usize> {
        let x = (node % self.nx) as i64 + d.0 as i64;
        let y = (node / self.nx) as i64 + d.1 as i64;
        if x < 0 || y < 0 || x >= self.nx as i64 {
            return None;
        }
        let j = y as usize * self.nx + x as usize;
        (j < self.value.len() && self.active[j]).then_some(j)
    }

    /// True when `a` is lower than `b`, ties by index.
    #[inline]
    pub fn lower(&self, a: usize, b: usize) -> bool {
        (self.value[a], a) < (self.value[b], b)
    }
}

impl Graph for Scalar<'_> {
    fn len(&self) -> usize {
        self.value.len()
    }

    fn is_active(&self, node: usize) -> bool {
        self.active[node]
    }

    fn value(&self, node: usize) -> f64 {
        self.value[node]
    }

    #[inline]
    fn each_neighbour(&self, node: usize, see: &mut dyn FnMut(usize)) {
        for d in LINK {
            if let Some(j) = self.neighbour(node, d) {
                see(j);
            }
        }
    }
}

/// What the link says of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Nothing happens here.
    Regular,
    /// Lower than every neighbour.
    Minimum,
    /// Higher than every neighbour.
    Maximum,
    /// Inside only: this many saddles at once (2 for a monkey saddle).
    Saddle(u32),
}

/// Classifies a node; also says whether it lies on the boundary of the active set.
pub fn classify(s: &Scalar, node: usize) -> (Link, bool) {
    let mut signs = [0i8; 6];
    let mut boundary = false;
    for (k, d) in LINK.iter().enumerate() {
        match s.neighbour(node, *d) {
            Some(j) => signs[k] = if s.lower(j, node) { -1 } else { 1 },
            None => boundary = true,
        }
    }
    let (low, high) = (signs.contains(&-1), signs.contains(&1));
    let link = match (low, high) {
        (false, false) => Link::Regular, // a lone node is no place to start a feature from
        (false, true) => Link::Minimum,
        (true, false) => Link::Maximum,
        (true, true) if boundary => Link::Regular,
        (true, true) => {
            let changes = (0..6).filter(|&k| signs[k] != signs[(k + 1) % 6]).count() as u32;
            if changes > 2 {
                Link::Saddle(changes / 2 - 1)
            } else {
                Link::Regular
            }
        }
    };
    (link, boundary)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

        /// On a torus (every node inside) peaks - saddles + pits = 0; tested on a disc padded by a falling rim, where the
        /// sum is 1 with the boundary's own pits left out: any values, ties included.
        #[test]
        fn eulers_number_holds_for_any_values(v in proptest::collection::vec(0u8..6, 100)) {
            let n = 14;
            let mut value = vec![0.0; n * n];
            for y in 0..n { for x in 0..n {
                let inner = (2..12).contains(&x) && (2..12).contains(&y);
                // Two falling rings outside: the disc's border has no critical point but pits.
                value[y * n + x] = if inner { 10.0 + v[(y - 2) * 10 + x - 2] as f64 }
                    else if (1..13).contains(&x) && (1..13).contains(&y) { 5.0 } else { 1.0 };
            } }
            let active = vec![true; n * n];
            let s = Scalar { nx: n, value: &value, active: &active };
            let mut sum = 0i64;
            for y in 1..n - 1 { for x in 1..n - 1 {
                sum += match classify(&s, y * n + x).0 {
                    Link::Maximum | Link::Minimum => 1,
                    Link::Saddle(m) => -(m as i64),
                    Link::Regular => 0,
                };
            } }
            // A sphere is this disc plus one pit beyond its border: 2 - 1.
            prop_assert_eq!(sum, 1);
        }
    }

    #[test]
    fn a_flat_top_has_one_peak() {
        let value = vec![1.0; 49];
        let active = vec![true; 49];
        let s = Scalar {
            nx: 7,
            value: &value,
            active: &active,
        };
        let count = |want| (0..49).filter(|&i| classify(&s, i).0 == want).count();
        assert_eq!((count(Link::Maximum), count(Link::Minimum)), (1, 1));
    }
}
