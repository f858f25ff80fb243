//! What a feature is: a window of the grid with its own field, the levels to cut in it, and what was taken before it.

use super::source::FieldSource;
use crate::geom::Point2;
use crate::reach::ToolCentreGrid;

/// Where a feature grew from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureKind {
    /// A peak inside the part.
    Peak,
    /// A pit inside the part.
    Pit,
    /// A peak on the part's border.
    BorderPeak,
    /// A pit on the part's border.
    BorderPit,
    /// Wide ground that no critical point claimed, from one tip of it.
    Remainder,
    /// A strip between the rims of other features; its passes run along them.
    Strip,
    /// The whole part, from one side or corner of it.
    Whole,
    /// Ground that walls and sharp edges part from the rest; see [`faces`](super::faces::faces).
    Face,
}

impl FeatureKind {
    /// The word used in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            FeatureKind::Peak => "peak",
            FeatureKind::Pit => "pit",
            FeatureKind::BorderPeak => "border-peak",
            FeatureKind::BorderPit => "border-pit",
            FeatureKind::Remainder => "remainder",
            FeatureKind::Strip => "strip",
            FeatureKind::Whole => "whole-part",
            FeatureKind::Face => "face",
        }
    }
}

/// A scalar on some of the grid's nodes, row by row: of each row the nodes from the first to the last that have a value. Features are
/// long and bent; a rectangle round each would be several times as large as the part.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Number of the first row in the grid.
    pub first_row: usize,
    /// For each row its first column, and where its values begin in `value`; they end where those of the next row begin.
    pub rows: Vec<(u32, u32)>,
    /// Values, row by row; +inf where there is none.
    pub value: Vec<f64>,
}

impl Window {
    /// Copies the values at `nodes` out of a whole-grid array; everything else is +inf.
    pub fn around(grid: &ToolCentreGrid, nodes: &[u32], of: &[f64]) -> Window {
        let place = |n: u32| (n as usize % grid.nx, n as usize / grid.nx);
        // What is +inf need not be kept.
        let kept = || {
            nodes
                .iter()
                .copied()
                .filter(|&n| of[n as usize] < f64::INFINITY)
        };
        let lo = kept().map(|n| place(n).1).min().unwrap_or(0);
        let hi = kept().map(|n| place(n).1 + 1).max().unwrap_or(0);
        // First column, and the one past the last.
        let mut spans = vec![(usize::MAX, 0); hi - lo];
        for (x, y) in kept().map(place) {
            let s = &mut spans[y - lo];
            *s = (s.0.min(x), s.1.max(x + 1));
        }
        let mut rows = Vec::with_capacity(spans.len());
        let mut len = 0;
        for (from, to) in spans {
            rows.push((from.min(to) as u32, len as u32));
            len += to.saturating_sub(from);
        }
        let mut value = vec![f64::INFINITY; len];
        for n in kept() {
            let (x, y) = place(n);
            let (from, at) = rows[y - lo];
            value[at as usize + x - from as usize] = of[n as usize];
        }
        Window {
            first_row: lo,
            rows,
            value,
        }
    }

    /// Rows of the grid, each with its columns that have a place here.
    pub fn spans(&self) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + '_ {
        self.rows.iter().enumerate().map(|(k, &(from, at))| {
            let end = self
                .rows
                .get(k + 1)
                .map_or(self.value.len(), |next| next.1 as usize);
            let from = from as usize;
            (self.first_row + k, from..from + (end - at as usize))
        })
    }

    /// The value at a node of the whole grid; +inf outside the window.
    #[inline]
    pub fn at(&self, grid: &ToolCentreGrid, node: usize) -> f64 {
        let (x, y) = (node % grid.nx, node / grid.nx);
        let row = y.wrapping_sub(self.first_row);
        let Some(&(from, at)) = self.rows.get(row) else {
            return f64::INFINITY;
        };
        let end = self
            .rows
            .get(row + 1)
            .map_or(self.value.len(), |next| next.1 as usize);
        // Before the first column wraps round to far past the last.
        let k = (at as usize).saturating_add(x.wrapping_sub(from as usize));
        if k < end && k >= at as usize {
            self.value[k]
        } else {
            f64::INFINITY
        }
    }
}

/// One feature.
#[derive(Clone, Debug)]
pub struct Feature {
    /// Where it grew from.
    pub kind: FeatureKind,
    /// Index of the critical point it grew from.
    pub seed: Option<usize>,
    /// Index of the saddle on its rim.
    pub saddle: Option<usize>,
    /// Where its field begins.
    pub source: FieldSource,
    /// Distance from where it begins, in passes. From the seed, the feature is where it is at most `rim`.
    pub field: Window,
    /// Value of the field on the rim; of one that does not begin at the seed, its highest.
    pub rim: f64,
    /// Values of the field to cut, rising; the last is the rim when a saddle set it, so that the neighbours end on a pass.
    pub levels: Vec<f64>,
    /// Passes away from ground taken by earlier features (negative inside it), and from the rim where the field does not tell: where
    /// passes are cut off.
    pub free: Window,
    /// Area of the surface, mm².
    pub area_mm2: f64,
}

impl Feature {
    /// Whether its last pass runs on the rim that it shares with its neighbours.
    pub fn rim_is_cut(&self) -> bool {
        self.saddle.is_some() && self.source == FieldSource::Seed
    }
}

/// All features of a part.
#[derive(Clone, Debug, Default)]
pub struct Regions {
    /// In the order they grew: an earlier one's rim stands, later ones end on it.
    pub features: Vec<Feature>,
    /// Feature of each node, from 1; 0 = none.
    pub label: Vec<u16>,
}

impl Regions {
    /// The feature (index) that holds the ground nearest a place in plan; none off the grid or on ground that no feature holds.
    pub fn feature_at(&self, grid: &ToolCentreGrid, at: &Point2) -> Option<usize> {
        let label = self.label[grid.nearest(at.x, at.y)?];
        (label as usize).checked_sub(1)
    }
}
