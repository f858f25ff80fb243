//! Growing features from extreme points to their closest saddles (Wang, Wang, Zhu, Ji 2010, section 3.3).
//!
//! ```text
//!   march from the highest extreme not yet taken, over ground not yet taken;
//!   the first saddle reached sets the rim: feature = { field <= field(saddle) }, its border a level curve *through* the saddle;
//!   critical points it swallowed are gone, the saddle stays on the rim for its neighbours; repeat.
//! ```
//!
//! Maxima come by falling height, then minima by rising height.

use super::ground::{Ground, GrowOptions};
use super::leftover::leftovers;
use super::region::{FeatureKind, Regions};
use crate::field::Metric;
use crate::morse::{CriticalKind, CriticalPoint};
use crate::reach::ToolCentreGrid;

/// Grows all features of a part; every ground node ends up in one. `cusp` is the cusp metric of the wanted scallop, `metric` that of
/// the ruler in `options`. Cost: a march or two over every node.
pub fn grow(
    grid: &ToolCentreGrid,
    cusp: &Metric,
    metric: &Metric,
    critical: &[CriticalPoint],
    options: &GrowOptions,
) -> Regions {
    let mut g = Ground::new(grid, cusp, metric, options);
    let mut saddle_at: Vec<(usize, usize)> = critical
        .iter()
        .enumerate()
        .filter(|(_, c)| c.kind == CriticalKind::Saddle && c.persistence >= options.persistence)
        .map(|(i, c)| (c.node, i))
        .collect();
    saddle_at.sort_unstable();
    for (index, seed) in critical.iter().enumerate() {
        if seed.kind == CriticalKind::Saddle
            || seed.persistence < options.persistence
            || g.free[seed.node] < 0.0
        {
            continue;
        }
        let mut saddle: Option<usize> = None;
        let mut rim = f64::INFINITY;
        let mut reached = 0.0f64;
        let mut settle = |node: usize, v: f64| {
            reached = reached.max(v);
            if saddle.is_none()
                && let Ok(k) = saddle_at.binary_search_by_key(&node, |s| s.0)
            {
                saddle = Some(saddle_at[k].1);
                rim = reached;
            }
            v <= rim + options.margin
        };
        let touched = g.march_from(seed.node, &mut settle);
        if saddle.is_some() && rim < options.passes_min {
            g.forget(&touched);
            continue;
        }
        let kind = match (seed.kind, seed.boundary) {
            (CriticalKind::Maximum, false) => FeatureKind::Peak,
            (CriticalKind::Maximum, true) => FeatureKind::BorderPeak,
            (_, false) => FeatureKind::Pit,
            (_, true) => FeatureKind::BorderPit,
        };
        g.take(kind, Some(index), saddle, rim, &touched);
        if let Some(s) = saddle {
            // The saddle stands on the rim, to the last bit, so that the neighbours can find it.
            g.free[critical[s].node] = 0.0;
        }
    }
    leftovers(&mut g);
    g.regions
}
