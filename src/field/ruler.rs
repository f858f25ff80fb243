//! The three rulers: how long a step over the tool-centre surface is, in passes.
//!
//! | ruler | squared length of a step | level curves are |
//! |---|---|---|
//! | isoplanar | (difference of one coordinate)^2 / w^2 | plane sections |
//! | iso-pick-feed | \|dp\|^2 / w^2 | curves of equal geodesic distance on the part |
//! | iso-scallop | dp . dc / (8 h R) | curves of equal cusp distance: one unit = one cusp of height h |
//!
//! with dp, dc the differences of the contacts and of the centres, w = sqrt(8 h R) the stepover that leaves a cusp of h on the flat.
//! The cusp metric (T. Kim, *Constant cusp height tool paths as geodesic parallels*, CAD 39 (2007) 477-489) needs no curvature here:
//! it is read off the contacts, and since no ball enters the part, `2 dp.dc = |c1-p2|^2 + |c2-p1|^2 - 2 R^2 >= 0` on any part.
//!
//! Each node gets one symmetric tensor M over the plan, fitted to the steps across it in four directions. The steps are about one
//! stepover long on purpose: cusps do not feel what happens between two passes, and shorter steps would see facets, not the surface.

use crate::geom::Vector2;
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// How distance is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ruler {
    /// Plane sections across this direction in plan (unit length).
    Isoplanar(Vector2),
    /// Equal distance on the part.
    IsoPickFeed,
    /// Equal cusp.
    IsoScallop,
}

/// A symmetric tensor over the plan: `[xx, xy, yy]`, so that a small step d is `sqrt(d' M d)` passes long.
pub type Tensor = [f64; 3];

/// Squared length of a step.
#[inline]
pub fn length_sq(m: &Tensor, d: &Vector2) -> f64 {
    m[0] * d.x * d.x + 2.0 * m[1] * d.x * d.y + m[2] * d.y * d.y
}

/// A tensor per node of a grid; NaN where the node is neither ground nor next to it.
#[derive(Clone, Debug)]
pub struct Metric {
    /// One tensor per node.
    pub tensor: Vec<Tensor>,
    /// How many rings of nodes beyond the ground carry a tensor.
    pub rings: usize,
}

/// Lower bound of a tensor's eigenvalues relative to flat ground: rolling over a sharp edge costs nothing, but a field needs a slope.
const FLOOR: f64 = 0.02;

impl Metric {
    /// The cusp metric (or the pick-feed one) of a grid for cusps of `scallop` mm. Linear in nodes, all cores.
    pub fn new(grid: &ToolCentreGrid, ruler: Ruler, scallop: f64) -> Metric {
        let unit = 8.0 * scallop * grid.radius;
        // Half a stepover on either side, at least one step.
        let reach = ((0.5 * unit.sqrt() / grid.step).round() as i32).max(1);
        let floor = FLOOR / unit;
        let mut tensor: Vec<Tensor> = (0..grid.len())
            .into_par_iter()
            .map(|i| match (grid.kind[i], ruler) {
                (NodeKind::Ground, Ruler::Isoplanar(d)) => {
                    [d.x * d.x / unit, d.x * d.y / unit, d.y * d.y / unit]
                }
                (NodeKind::Ground, _) => at_least(
                    fitted(grid, i, reach, ruler == Ruler::IsoPickFeed, unit),
                    floor,
                ),
                _ => [f64::NAN; 3],
            })
            .collect();
        // Beyond the border the ball only rolls round the outline: carry the border's tensor out a little, so that level curves
        // reach the border instead of ending a cell short of it.
        let rings = 2;
        for _ in 0..rings {
            let grown: Vec<(usize, Tensor)> = (0..grid.len())
                .into_par_iter()
                .filter(|&i| tensor[i][0].is_nan())
                .filter_map(|i| {
                    let mut sum = [0.0; 3];
                    let mut n = 0.0;
                    for dy in -1..=1 {
                        for dx in -1..=1 {
                            if let Some(j) = grid.neighbour(i, (dx, dy))
                                && !tensor[j][0].is_nan()
                            {
                                n += 1.0;
                                (0..3).for_each(|k| sum[k] += tensor[j][k]);
                            }
                        }
                    }
                    (n > 0.0).then(|| (i, sum.map(|s| s / n)))
                })
                .collect();
            for (i, t) in grown {
                tensor[i] = t;
            }
        }
        Metric { tensor, rings }
    }

    /// True where the field may live.
    #[inline]
    pub fn is_set(&self, node: usize) -> bool {
        !self.tensor[node][0].is_nan()
    }
}

/// Least-squares tensor of the steps across a node in four directions.
fn fitted(grid: &ToolCentreGrid, node: usize, reach: i32, pick_feed: bool, unit: f64) -> Tensor {
    let ground = |d: (i32, i32)| {
        grid.neighbour(node, d)
            .filter(|&j| grid.kind[j] == NodeKind::Ground)
    };
    // Squared length per squared mm of plan, along x, y and the two diagonals; NaN where there is no ground to measure on.
    let along = |dx: i32, dy: i32| -> f64 {
        for k in (1..=reach).rev() {
            // Diagonal steps are sqrt(2) longer: shorten them to about the same reach.
            let k = if dx * dy == 0 {
                k
            } else {
                ((k as f64 * 0.75).round() as i32).max(1)
            };
            let (a, b) = (ground((-k * dx, -k * dy)), ground((k * dx, k * dy)));
            let (a, b) = match (a, b) {
                (Some(a), Some(b)) => (a, b),
                (Some(a), None) => (a, node),
                (None, Some(b)) => (node, b),
                (None, None) => continue,
            };
            let dp = grid.point[b] - grid.point[a];
            let dc = grid.center(b) - grid.center(a);
            let plan = dc.x * dc.x + dc.y * dc.y;
            let q = if pick_feed { dp.dot(&dp) } else { dp.dot(&dc) };
            return q.max(0.0) / (unit * plan);
        }
        f64::NAN
    };
    let (qx, qy, qd, qe) = (along(1, 0), along(0, 1), along(1, 1), along(1, -1));
    let (diagonals, axes) = (!(qd.is_nan() || qe.is_nan()), !(qx.is_nan() || qy.is_nan()));
    match (axes, diagonals) {
        (true, true) => {
            // Normal equations of xx = qx, yy = qy, (xx + yy)/2 +- xy = qd, qe.
            let (s, t, sum) = (qx, qy, qd + qe);
            // Minimise (a-s)^2 + (b-t)^2 + 2 ((a+b)/2 - sum/2)^2 over a, b.
            let excess = (sum - (s + t)) / 4.0;
            [s + excess, (qd - qe) / 2.0, t + excess]
        }
        (true, false) => [qx, 0.0, qy],
        (false, true) => [(qd + qe) / 2.0, (qd - qe) / 2.0, (qd + qe) / 2.0],
        (false, false) => [1.0 / unit, 0.0, 1.0 / unit],
    }
}

/// The same tensor with its eigenvalues raised to a floor.
fn at_least(m: Tensor, floor: f64) -> Tensor {
    let mean = 0.5 * (m[0] + m[2]);
    let half = 0.5 * (m[0] - m[2]);
    let e = half.hypot(m[1]);
    if mean - e >= floor {
        return m;
    }
    let (lo, hi) = ((mean - e).max(floor), (mean + e).max(floor));
    if e <= 1e-300 {
        return [hi, 0.0, hi];
    }
    let (c, s) = (half / e, m[1] / e); // cos, sin of twice the angle of the large axis
    let (mean, e) = (0.5 * (hi + lo), 0.5 * (hi - lo));
    [mean + e * c, e * s, mean - e * c]
}
