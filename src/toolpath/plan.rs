//! The whole shape half in one call: a placed part in, a proven toolpath out, with everything seen on the way.

use super::fill::{FillOptions, FillReport, fill, segments};
use super::fit::FitOptions;
use super::link::{Air, LinkOptions, link};
use super::moves::Toolpath;
use super::order::order;
use super::pass::{Pass, passes};
use super::pencil::{PencilOptions, needed, pencil};
use super::wall::{Steep, TooDeep, Uprights, WallOptions, steep, walls};
use crate::feature::{GrowOptions, Regions, grow};
use crate::field::{Metric, Ruler};
use crate::geom::{Point, Vector2};
use crate::morse::{CriticalPoint, HeightField, MorseOptions, critical_points};
use crate::part::Mesh;
use crate::reach::{Crease, DropCutter, GridError, GridOptions, GridPlan, ToolCentreGrid, creases};
use crate::sweep::{Reachable, reachable, reachable_bytes};

/// How passes are spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// Equal cusps everywhere.
    IsoScallop,
    /// Equal distance on the part.
    IsoPickFeed,
    /// Plane sections; the angle of the passes from X, degrees.
    Isoplanar(f64),
}

impl Strategy {
    /// The word used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::IsoScallop => "iso-scallop",
            Strategy::IsoPickFeed => "iso-pick-feed",
            Strategy::Isoplanar(_) => "isoplanar",
        }
    }

    fn ruler(self) -> Ruler {
        match self {
            Strategy::IsoScallop => Ruler::IsoScallop,
            Strategy::IsoPickFeed => Ruler::IsoPickFeed,
            Strategy::Isoplanar(degrees) => {
                // Distance is measured across the passes.
                let (s, c) = degrees.to_radians().sin_cos();
                Ruler::Isoplanar(Vector2::new(-s, c))
            }
        }
    }
}

/// What to plan. Every figure must be finite; `scallop` above zero and below the radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanOptions {
    /// Cusp height that may be left, mm.
    pub scallop: f64,
    /// How passes are spaced.
    pub strategy: Strategy,
    /// Step of the tool-centre grid, mm; `None` = a fifth of the flat stepover.
    pub grid_step: Option<f64>,
    /// Critical points that differ less than this are noise, mm; `None` = [`default_persistence`].
    pub persistence: Option<f64>,
    /// Most memory that grids may take.
    pub memory_limit_bytes: u64,
    /// Ground steeper than this gets passes at constant height, degrees from the horizontal.
    pub wall_angle: f64,
    /// The tool's tip goes no lower than this beside a closed solid, work coordinates, mm; `None` = the part's lowest point.
    pub floor: Option<f64>,
    /// Length of the flutes, mm.
    pub flute: f64,
}

/// Stages of planning, in order; for progress and timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Sorting triangles, dropping the ball on the grid.
    Reach,
    /// Critical points.
    Morse,
    /// Metric, fields, features.
    Features,
    /// Passes dropped and fitted.
    Passes,
    /// The surface the ball can reach, for judging.
    Reachable,
    /// Sweeping and filling.
    Fill,
    /// Order and links.
    Link,
}

/// Cusps are planned at one of these shares of what is wanted; the rest is for what the field, the fit and the rounding take, and for
/// facets and noise: ground that is rough by a few micrometres leaves higher cusps than its metric says. Where filling costs more than
/// closer passes would, the next share is tried (with 5 um of noise, 0.7 h is a fifth shorter than 0.92 h and its 2,000 fills).
pub const PLAN_SHARES: [f64; 4] = [0.92, 0.85, 0.78, 0.70];
/// Fills no longer than this share of the passes are not worth a second plan.
const FILL_SHARE: f64 = 0.005;
/// Fill where a cusp is higher than this share of what is wanted: below it lie what a lattice and a facet do to a measurement, and
/// hundreds of bits whose links cost more than they mend.
pub const FILL_START: f64 = 1.03;
/// Ground steeper than this is a wall, degrees from the horizontal.
pub const DEFAULT_WALL_ANGLE: f64 = 75.0;
/// A crease gets a pencil pass where more than this share of the cusp wanted stands in it.
const PENCIL_START: f64 = 0.75;
/// Cells of the sweep map in a flat stepover: a cusp between two cells is then seen within a few percent.
pub const CELLS_PER_STEPOVER: f64 = 14.0;

/// The shape a plan is made of, independent of the strategy.
#[derive(Debug)]
pub struct Ground {
    /// The part, ready for this ball.
    pub cutter: DropCutter,
    /// The tool-centre surface.
    pub grid: ToolCentreGrid,
    /// Critical points of it.
    pub critical: Vec<CriticalPoint>,
    /// Persistence below which they were cancelled, mm.
    pub persistence: f64,
}

/// A planned job.
#[derive(Debug)]
pub struct Plan {
    /// Features.
    pub regions: Regions,
    /// Passes in cutting order.
    pub passes: Vec<Pass>,
    /// What the closed loop did.
    pub fill: FillReport,
    /// Moves of the tool tip.
    pub toolpath: Toolpath,
    /// The feature of each section of the toolpath.
    pub section_features: Vec<Option<usize>>,
    /// Tolerances the passes were fitted with.
    pub fitting: FitOptions,
    /// Cusp height the passes were spaced for, mm.
    pub spaced_for: f64,
    /// Walls left standing because the flutes are too short for them.
    pub too_deep: Vec<TooDeep>,
}

/// Stepover that leaves a cusp of `scallop` on the flat, mm.
pub fn flat_stepover(scallop: f64, radius: f64) -> f64 {
    (8.0 * scallop * radius - 4.0 * scallop * scallop)
        .max(0.0)
        .sqrt()
}

/// Cells of a sweep map at most, so that a large part is judged more coarsely rather than not at all.
const CELLS: f64 = 24e6;

/// Step of the sweep map over a part that resolves such a cusp, mm.
pub fn sweep_step(cutter: &DropCutter, scallop: f64) -> f64 {
    let (size, r) = (cutter.bounds().size(), cutter.radius());
    let area = (size.x + 2.0 * r) * (size.y + 2.0 * r);
    (flat_stepover(scallop, r) / CELLS_PER_STEPOVER).max((area / CELLS).sqrt())
}

/// Height differences that mean nothing: the largest of one and a half cusps, twice the height a grid step hides on gentle
/// ground, and thirty times the roughness of the part's border. (Contacts hop sideways from bump to bump, so on slopes noise counts several times over: on a relief with 5 um of
/// noise the border's roughness measured 2.4 um and false pits were up to 67 um deep.)
pub fn default_persistence(scallop: f64, grid_step: f64, radius: f64, roughness: f64) -> f64 {
    (1.5 * scallop)
        .max(grid_step * grid_step / radius)
        .max(30.0 * roughness)
}

/// Step of the tool-centre grid these options lead to, mm.
pub fn grid_step(options: &PlanOptions, radius: f64) -> f64 {
    options
        .grid_step
        .unwrap_or_else(|| flat_stepover(options.scallop, radius) / 5.0)
}

/// Memory that planning will take at its peak beyond the part itself, so that it can be announced or refused first.
pub fn planned_bytes(grid: &GridPlan, cutter: &DropCutter, scallop: f64) -> u64 {
    grid.bytes
        + reachable_bytes(
            &cutter.bounds(),
            cutter.radius(),
            sweep_step(cutter, scallop),
        )
}

/// Lays the tool-centre grid over a part and finds its critical points. `announce` hears the planned grid and the bytes that
/// planning will take, before they are taken.
pub fn survey(
    cutter: DropCutter,
    options: &PlanOptions,
    announce: &mut dyn FnMut(&GridPlan, u64),
    stage: &mut dyn FnMut(Stage),
) -> Result<Ground, GridError> {
    stage(Stage::Reach);
    let step = grid_step(options, cutter.radius());
    let how = GridOptions {
        step,
        memory_limit_bytes: options.memory_limit_bytes,
    };
    let plan = GridPlan::new(&cutter, &how)?;
    let bytes = planned_bytes(&plan, &cutter, options.scallop);
    if bytes > options.memory_limit_bytes {
        return Err(GridError::TooLarge {
            nx: plan.size[0] as u64,
            ny: plan.size[1] as u64,
            step,
            need_mib: bytes >> 20,
            limit_mib: options.memory_limit_bytes >> 20,
        });
    }
    announce(&plan, bytes);
    let grid = ToolCentreGrid::new(&cutter, &plan)?;
    stage(Stage::Morse);
    let field = HeightField::new(&grid);
    let persistence = options.persistence.unwrap_or_else(|| {
        default_persistence(options.scallop, step, cutter.radius(), field.roughness)
    });
    let how = MorseOptions {
        persistence_mm: persistence,
    };
    let critical = critical_points(&grid, &field, &how);
    Ok(Ground {
        cutter,
        grid,
        critical,
        persistence,
    })
}

/// Grows the features of a surveyed part, with a field whose unit is a cusp of `spaced_for` mm.
pub fn features(ground: &Ground, strategy: Strategy, spaced_for: f64) -> Regions {
    let ruler = strategy.ruler();
    let cusp = Metric::new(&ground.grid, Ruler::IsoScallop, spaced_for);
    let own = (ruler != Ruler::IsoScallop).then(|| Metric::new(&ground.grid, ruler, spaced_for));
    let how = GrowOptions {
        ruler,
        passes_min: 2.0,
        margin: 5.0,
        over_share: 0.005,
    };
    grow(
        &ground.grid,
        &cusp,
        own.as_ref().unwrap_or(&cusp),
        &ground.critical,
        &how,
    )
}

/// Plans the toolpath of a surveyed part (`part` is the mesh its cutter was made from). Also hands back the reachable surface it was
/// judged against.
pub fn plan(
    part: &Mesh,
    ground: &Ground,
    options: &PlanOptions,
    links: &LinkOptions,
    stage: &mut dyn FnMut(Stage),
) -> (Plan, Reachable) {
    stage(Stage::Reachable);
    let reach = reachable(&ground.cutter, sweep_step(&ground.cutter, options.scallop));
    let air = Air::new(part, &ground.cutter, links);
    let detail = Detail::find(part, ground, options);
    let mut best = plan_at(
        ground,
        &reach,
        &air,
        &detail,
        options,
        PLAN_SHARES[0],
        links,
        stage,
    );
    for &share in &PLAN_SHARES[1..] {
        let passes: f64 = best.passes.iter().map(Pass::length).sum();
        if best.fill.length_mm <= FILL_SHARE * passes {
            break;
        }
        let next = plan_at(ground, &reach, &air, &detail, options, share, links, stage);
        if next.toolpath.rough_time(links) >= best.toolpath.rough_time(links) {
            break;
        }
        best = next;
    }
    (best, reach)
}

#[allow(clippy::too_many_arguments)]
fn plan_at(
    ground: &Ground,
    reach: &Reachable,
    air: &Air,
    detail: &Detail,
    options: &PlanOptions,
    share: f64,
    links: &LinkOptions,
    stage: &mut dyn FnMut(Stage),
) -> Plan {
    let (grid, cutter) = (&ground.grid, &ground.cutter);
    stage(Stage::Features);
    let spaced_for = share * options.scallop;
    let regions = features(ground, options.strategy, spaced_for);
    stage(Stage::Passes);
    let fitting = FitOptions::for_scallop(options.scallop, cutter.radius());
    let mut all = passes(grid, cutter, &regions, &detail.steep, &fitting);
    let (down, too_deep) = detail.walls(ground, &regions, &fitting);
    all.extend(down);
    let pencils = detail.pencils(ground, &regions, &all, options.scallop, &fitting);
    all.extend(pencils);
    stage(Stage::Fill);
    let how = FillOptions {
        scallop: options.scallop,
        start: FILL_START,
        keep: 0.75,
        rounds: 6,
    };
    let fill = fill(grid, cutter, &regions, reach, &mut all, &how, &fitting);
    stage(Stage::Link);
    // Begin at the corner of the part nearest the operator's zero: lowest x and y, from above.
    let b = cutter.bounds();
    let start = Point::new(b.min.x, b.min.y, b.max.z + cutter.radius());
    let ordered = order(all, start);
    let (toolpath, section_features) = link(cutter, air, &ordered, &regions, links, &fitting);
    Plan {
        regions,
        passes: ordered,
        fill,
        toolpath,
        section_features,
        fitting,
        spaced_for,
        too_deep,
    }
}

/// What is smaller or steeper than the ball likes: the same for every plan of a part.
struct Detail<'a> {
    creases: Vec<Crease>,
    pencil: PencilOptions,
    uprights: Uprights<'a>,
    steep: Steep,
}

impl<'a> Detail<'a> {
    fn find(part: &'a Mesh, ground: &Ground, options: &PlanOptions) -> Detail<'a> {
        let (grid, cutter) = (&ground.grid, &ground.cutter);
        let fitting = FitOptions::for_scallop(options.scallop, cutter.radius());
        let stepover = flat_stepover(options.scallop, cutter.radius());
        let pencil = PencilOptions::for_stepover(stepover, &fitting);
        let uprights = Uprights::new(part, cutter.radius());
        let steep = steep(
            grid,
            &uprights,
            &WallOptions {
                angle: options.wall_angle.to_radians(),
                stepover: flat_stepover(PLAN_SHARES[0] * options.scallop, cutter.radius()),
                floor: options.floor.unwrap_or(cutter.bounds().min.z),
                flute: options.flute,
                off_wall: pencil.off_wall,
            },
        );
        Detail {
            creases: creases(grid, cutter, &pencil.crease),
            pencil,
            uprights,
            steep,
        }
    }

    /// The pencil passes that cut what the others leave.
    fn pencils(
        &self,
        ground: &Ground,
        regions: &Regions,
        others: &[Pass],
        scallop: f64,
        fitting: &FitOptions,
    ) -> Vec<Pass> {
        let (grid, cutter) = (&ground.grid, &ground.cutter);
        let all = pencil(grid, cutter, regions, &self.creases, &self.pencil, fitting);
        let stepover = flat_stepover(scallop, cutter.radius());
        needed(
            all,
            cutter,
            &segments(others),
            PENCIL_START * scallop,
            stepover,
        )
    }

    fn walls(
        &self,
        ground: &Ground,
        regions: &Regions,
        fitting: &FitOptions,
    ) -> (Vec<Pass>, Vec<TooDeep>) {
        walls(
            &ground.grid,
            &ground.cutter,
            regions,
            &self.uprights,
            &self.steep,
            &self.creases,
            fitting,
        )
    }
}
