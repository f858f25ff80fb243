//! Layouts: what becomes a feature, and what a layout is laid with.

use super::detail::Detail;
use super::{Ground, PlanOptions, Strategy, Weigh};
use crate::feature::{GrowOptions, Regions, Source, farthest, grow, whole};
use crate::field::{Front, Metric, Ruler};
use crate::part::Mesh;
use crate::reach::{DropCutter, ToolCentreGrid};
use crate::sweep::ReachTiles;
use crate::toolpath::link::{Air, LinkOptions};
use std::sync::OnceLock;

/// What becomes a feature.
#[derive(Clone, Debug, PartialEq)]
pub enum Layout {
    /// Features grown from critical points, in one of the feature-wise strategies.
    Features(Strategy),
    /// The whole part from one source, equal cusps.
    Whole(Source),
    /// The whole part in plane sections at this angle from X, degrees.
    Raster(f64),
    /// Ground parted by walls and sharp edges, each face of it as it is quickest.
    Faces,
}

impl Layout {
    /// A name for tables.
    pub fn name(&self) -> String {
        match self {
            Layout::Features(Strategy::Auto) => "each feature its quickest".to_string(),
            Layout::Features(s) => s.name().to_string(),
            Layout::Whole(s) => format!("whole from {}", s.name),
            Layout::Raster(angle) => format!("raster at {angle:.0} deg"),
            Layout::Faces => "each face its quickest".to_string(),
        }
    }
}

/// Everything a layout is laid with.
pub(in crate::toolpath) struct Bench<'a> {
    pub ground: &'a Ground,
    pub detail: &'a Detail,
    pub reach: &'a ReachTiles<'a>,
    pub part: &'a Mesh,
    /// Laid over the part when the first link is: on a large part it need not be there before.
    pub air: &'a OnceLock<Air>,
    pub options: &'a PlanOptions,
    pub links: &'a LinkOptions,
    pub weigh: Weigh<'a>,
    /// What stands over is filled; a raster to compare with needs none.
    pub closed_loop: bool,
}

/// Grids with more nodes than this are laid once: what to lay is decided from estimates, and nothing is laid only to compare with.
pub(in crate::toolpath) const LAID_TWICE: usize = 3_000_000;
/// Cells of the sweep map in a flat stepover: a cusp between two cells is then seen within a few percent.
pub const CELLS_PER_STEPOVER: f64 = 14.0;

/// Stepover that leaves a cusp of `scallop` on the flat, mm.
pub fn flat_stepover(scallop: f64, radius: f64) -> f64 {
    (8.0 * scallop * radius - 4.0 * scallop * scallop)
        .max(0.0)
        .sqrt()
}

/// Cells that are judged at most: beyond it nobody would wait.
const CELLS: f64 = 1e9;

/// Step of the sweep map over a part that resolves such a cusp, mm.
pub fn sweep_step(cutter: &DropCutter, scallop: f64) -> f64 {
    let (size, r) = (cutter.bounds().size(), cutter.radius());
    let area = (size.x + 2.0 * r) * (size.y + 2.0 * r);
    (flat_stepover(scallop, r) / CELLS_PER_STEPOVER).max((area / CELLS).sqrt())
}

impl Bench<'_> {
    /// Where the air begins.
    pub fn air(&self) -> &Air {
        self.air
            .get_or_init(|| Air::new(self.part, &self.ground.cutter, self.links))
    }

    /// The cusp metric that a layout's fields are made with, and its cusps judged by: that of faces sees nothing across what parts them.
    pub fn metric(&self, layout: &Layout, spaced_for: f64) -> Metric {
        let grid = &self.ground.grid;
        match (layout, &self.detail.faces) {
            (Layout::Faces, Some(f)) => Metric::new(&f.parted(grid), Ruler::IsoScallop, spaced_for),
            _ => Metric::new(grid, Ruler::IsoScallop, spaced_for),
        }
    }

    /// Features of a layout, in that metric, grown from critical points of at least this persistence; those of faces are without fields
    /// yet.
    pub fn regions(
        &self,
        layout: &Layout,
        spaced_for: f64,
        cusp: &Metric,
        persistence: f64,
    ) -> Regions {
        match (layout, &self.detail.faces) {
            (Layout::Faces, Some(f)) => f.regions(&self.ground.grid),
            _ => regions_of(self.ground, layout, spaced_for, cusp, persistence),
        }
    }

    /// Whether the part is small enough to be laid several times over.
    pub fn small(&self) -> bool {
        self.ground.grid.len() <= LAID_TWICE
    }
}

/// Features of a layout, in a cusp metric whose unit is a cusp of `spaced_for` mm, grown from the critical points of at least some
/// persistence.
pub(in crate::toolpath) fn regions_of(
    ground: &Ground,
    layout: &Layout,
    spaced_for: f64,
    cusp: &Metric,
    persistence: f64,
) -> Regions {
    let grid = &ground.grid;
    let mut how = GrowOptions {
        ruler: Ruler::IsoScallop,
        passes_min: 2.0,
        margin: 5.0,
        over_share: 0.005,
        persistence,
    };
    match layout {
        Layout::Features(strategy) => {
            how.ruler = strategy.ruler();
            let own =
                (how.ruler != Ruler::IsoScallop).then(|| Metric::new(grid, how.ruler, spaced_for));
            grow(
                grid,
                cusp,
                own.as_ref().unwrap_or(cusp),
                &ground.critical,
                &how,
            )
        }
        Layout::Whole(source) => whole(grid, cusp, cusp, source, &how),
        // Found once for a part: see `Bench::regions`.
        Layout::Faces => Regions {
            features: Vec::new(),
            label: vec![0; grid.len()],
        },
        Layout::Raster(angle) => {
            how.ruler = Strategy::Raster(Some(*angle)).ruler();
            how.over_share = 0.0;
            let own = Metric::new(grid, how.ruler, spaced_for);
            let source = raster_source(grid, how.ruler);
            whole(grid, cusp, &own, &source, &how)
        }
    }
}

/// Plane sections begin at the ground farthest back across them.
fn raster_source(grid: &ToolCentreGrid, ruler: Ruler) -> Source {
    let nodes = match ruler {
        Ruler::Isoplanar(across) => farthest(grid, &-across).into_iter().collect(),
        _ => Vec::new(),
    };
    Source {
        name: "raster".to_string(),
        nodes,
        front: Front::Straight,
    }
}
