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
        }
    }
}

/// A scalar on a rectangle of the grid's nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// First column and row.
    pub first: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Values, row-major; +inf where there is none.
    pub value: Vec<f64>,
}

impl Window {
    /// Copies the values at `nodes` out of a whole-grid array; everything else is +inf.
    pub fn around(grid: &ToolCentreGrid, nodes: &[u32], of: &[f64]) -> Window {
        let (mut lo, mut hi) = ([usize::MAX; 2], [0usize; 2]);
        for &n in nodes {
            let at = [n as usize % grid.nx, n as usize / grid.nx];
            for k in 0..2 {
                lo[k] = lo[k].min(at[k]);
                hi[k] = hi[k].max(at[k]);
            }
        }
        if nodes.is_empty() {
            return Window {
                first: [0, 0],
                size: [0, 0],
                value: Vec::new(),
            };
        }
        let size = [hi[0] - lo[0] + 1, hi[1] - lo[1] + 1];
        let mut value = vec![f64::INFINITY; size[0] * size[1]];
        for &n in nodes {
            let (x, y) = (n as usize % grid.nx, n as usize / grid.nx);
            value[(y - lo[1]) * size[0] + x - lo[0]] = of[n as usize];
        }
        Window {
            first: lo,
            size,
            value,
        }
    }

    /// The value at a node of the whole grid; +inf outside the window.
    #[inline]
    pub fn at(&self, grid: &ToolCentreGrid, node: usize) -> f64 {
        let (x, y) = (node % grid.nx, node / grid.nx);
        if x < self.first[0]
            || y < self.first[1]
            || x >= self.first[0] + self.size[0]
            || y >= self.first[1] + self.size[1]
        {
            return f64::INFINITY;
        }
        self.value[(y - self.first[1]) * self.size[0] + x - self.first[0]]
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
