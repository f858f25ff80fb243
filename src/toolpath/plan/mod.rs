//! The whole shape half in one call: a placed part in, a proven toolpath out, with everything seen on the way.

mod choose;
pub mod detail;
mod estimate;
mod even;
pub mod lay;
pub mod layout;
mod rasters;

use super::fill::{FillReport, far};
use super::fit::FitOptions;
use super::link::LinkOptions;
use super::moves::{MoveKind, Toolpath};
use super::pass::Pass;
use super::saddle::{SaddleTurns, saddle_turns};
use super::sharp::SharpTurns;
use super::wall::TooDeep;
use crate::feature::Regions;
use crate::field::{Metric, Ruler};
use crate::geom::{Point, Vector2};
use crate::morse::{
    AverageOptions, CriticalPoint, FieldOptions, GridField, MorseFunction, MorseOptions,
    critical_points,
};
use crate::part::Mesh;
use crate::reach::{DropCutter, GridError, GridOptions, GridPlan, ToolCentreGrid};
use crate::sweep::{ReachTiles, reachable_bytes};
use choose::{Choice, choose};
use detail::Detail;
use estimate::{best_raster_angle, best_sources};
use lay::{Known, PLAN_SHARES, lay};
use layout::{Bench, LAID_TWICE, Layout, flat_stepover, regions_of, sweep_step};
use std::sync::OnceLock;

/// What becomes a feature, and how passes are spaced in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// The quickest of the others.
    Auto,
    /// Features grown from critical points, equal cusps everywhere.
    IsoScallop,
    /// Features grown from critical points, equal distance on the part.
    IsoPickFeed,
    /// Features grown from critical points, plane sections; the angle of the passes from X, degrees.
    Isoplanar(f64),
    /// The whole part as one feature from its best side or corner, equal cusps everywhere.
    Whole,
    /// The whole part in plane sections at the widest step that leaves no cusp over the wanted one anywhere; the angle of the passes
    /// from X, degrees, or the quickest one.
    Raster(Option<f64>),
}

impl Strategy {
    /// The word used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Auto => "auto",
            Strategy::IsoScallop => "iso-scallop",
            Strategy::IsoPickFeed => "iso-pick-feed",
            Strategy::Isoplanar(_) => "isoplanar",
            Strategy::Whole => "whole",
            Strategy::Raster(_) => "raster",
        }
    }

    /// How distance is measured.
    pub fn ruler(self) -> Ruler {
        let across = |degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            Ruler::Isoplanar(Vector2::new(-s, c))
        };
        match self {
            Strategy::Auto | Strategy::IsoScallop | Strategy::Whole => Ruler::IsoScallop,
            Strategy::IsoPickFeed => Ruler::IsoPickFeed,
            Strategy::Isoplanar(degrees) => across(degrees),
            Strategy::Raster(degrees) => across(degrees.unwrap_or(0.0)),
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
    /// Whose critical points features grow from.
    pub function: MorseFunction,
    /// Critical points that differ less than this are noise, in the function's own unit; `None` = [`default_persistence`] for heights,
    /// [`GridField::noise`] for others.
    pub persistence: Option<f64>,
    /// Most memory that grids may take.
    pub memory_limit_bytes: u64,
    /// Ground steeper than this gets passes at constant height, degrees from the horizontal.
    pub wall_angle: f64,
    /// The tool's tip goes no lower than this beside a closed solid, work coordinates, mm; `None` = the part's lowest point.
    pub floor: Option<f64>,
    /// Length of the flutes, mm.
    pub flute: f64,
    /// Upright walls are cut this deep at once at most, mm.
    pub deepest: f64,
}

/// Stages of planning, in order; for progress and timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Sorting triangles, dropping the ball on the grid.
    Reach,
    /// Critical points.
    Morse,
    /// Estimates of what to lay.
    Choose,
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

/// The shape a plan is made of, independent of the strategy.
#[derive(Debug)]
pub struct Ground {
    /// The part, ready for this ball.
    pub cutter: DropCutter,
    /// The tool-centre surface.
    pub grid: ToolCentreGrid,
    /// Critical points of it.
    pub critical: Vec<CriticalPoint>,
    /// Persistence below which they were cancelled, in the function's own unit.
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
    /// Area of upright wall left standing so, mm2.
    pub uncut_wall: f64,
    /// How smoothly passes turn into one another near saddles.
    pub saddles: Vec<SaddleTurns>,
    /// What was laid.
    pub layout: Layout,
    /// Figures of its toolpath.
    pub figures: Figures,
    /// Everything that was laid and weighed, this plan among them, with the two rasters to compare with.
    pub candidates: Vec<Candidate>,
}

/// A job should spend no more than this share of its time not cutting.
const NOT_CUTTING: f64 = 0.05;
/// A plan that keeps to it may take this much longer than one that does not.
const KEPT: f64 = 0.015;

/// What a toolpath takes on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// From first to last motion, s.
    pub time_s: f64,
    /// Links along the surface, s.
    pub link_s: f64,
    /// Through the air and straight up and down, s.
    pub air_s: f64,
    /// Root of the mean square of the tool's vertical acceleration while it cuts, mm/s2.
    pub vertical_acceleration_rms: f64,
    /// Largest turn between consecutive cutting moves, degrees; once the part was looked at, but for the part's own corners.
    pub largest_turn_deg: f64,
    /// Where that is (tool tip, mm), once the part was looked at.
    pub largest_turn_at: Option<Point>,
    /// Turns over 30 degrees that are no corners of the part, and those that are; see [`super::sharp`].
    pub sharp_turns: usize,
    /// At corners of the part.
    pub part_corners: usize,
    /// The largest turn at a corner of the part, degrees.
    pub largest_part_corner_deg: f64,
}

impl Figures {
    /// What plans are compared by, s: the time, and once more what of it goes into links and air beyond a twentieth of it. Each link is a
    /// place where the finish may show it.
    pub fn cost(&self) -> f64 {
        self.time_s + (self.not_cutting() - NOT_CUTTING * self.time_s).max(0.0)
    }

    fn not_cutting(&self) -> f64 {
        self.link_s + self.air_s
    }

    /// With its turns judged by the part.
    pub fn with_turns(self, t: &SharpTurns) -> Figures {
        Figures {
            largest_turn_deg: t.largest_deg,
            largest_turn_at: t.largest_at,
            sharp_turns: t.sharp,
            part_corners: t.part_corners,
            largest_part_corner_deg: t.largest_part_corner_deg,
            ..self
        }
    }
}

/// Weighs a toolpath with the machine's own planner.
pub type Weigh<'a> = &'a (dyn Fn(&Toolpath) -> Figures + Sync);

/// One way of cutting the part, laid whole and weighed.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// What it is: a strategy, and where it begins or runs.
    pub name: String,
    /// Length of its moves at cutting feed, links among them, mm.
    pub cut_mm: f64,
    /// Cutting passes.
    pub passes: usize,
    /// Times it leaves the surface between passes and at the end.
    pub retracts: usize,
    /// What it takes.
    pub figures: Figures,
    /// The plan is this one.
    pub chosen: bool,
}

impl Candidate {
    pub(super) fn of(name: String, path: &Toolpath, passes: usize, figures: Figures) -> Candidate {
        let at_feed = |k: MoveKind| matches!(k, MoveKind::Cut | MoveKind::Link);
        Candidate {
            name,
            cut_mm: path
                .moves
                .windows(2)
                .filter(|w| at_feed(w[1].kind))
                .map(|w| (w[1].to - w[0].to).norm())
                .sum(),
            passes,
            retracts: path
                .moves
                .iter()
                .filter(|m| m.kind == MoveKind::Retract)
                .count(),
            figures,
            chosen: false,
        }
    }
}

/// Height differences that mean nothing: the largest of one and a half cusps, twice the height a grid step hides on gentle
/// ground, and thirty times the roughness of the part's border. (Contacts hop sideways from bump to bump, so on slopes noise counts several times over: on a relief with 5 um of
/// noise the border's roughness measured 2.4 um and false pits were up to 67 um deep.)
pub fn default_persistence(scallop: f64, grid_step: f64, radius: f64, roughness: f64) -> f64 {
    (1.5 * scallop)
        .max(grid_step * grid_step / radius)
        .max(30.0 * roughness)
}

/// Curvature is averaged over this radius in plan, mm: what is smaller than a stepover no pass could follow.
pub fn curvature_radius(scallop: f64, radius: f64) -> f64 {
    1.5 * flat_stepover(scallop, radius)
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
    let field = GridField::of(
        &grid,
        options.function,
        &FieldOptions {
            radius: curvature_radius(options.scallop, cutter.radius()),
            average: AverageOptions::default(),
        },
    );
    let persistence = options
        .persistence
        .unwrap_or_else(|| match options.function {
            MorseFunction::Height | MorseFunction::Projection => {
                default_persistence(options.scallop, step, cutter.radius(), field.roughness)
            }
            _ => field.noise(),
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
    let cusp = Metric::new(&ground.grid, Ruler::IsoScallop, spaced_for);
    regions_of(ground, &Layout::Features(strategy), spaced_for, &cusp, 0.0)
}

/// Turns are told within so many stepovers of a saddle.
const NEAR_SADDLE: f64 = 3.0;

/// What the estimate says takes this much longer than the whole part as one feature is not laid.
const NOT_LAID: f64 = 1.15;
/// Where faces take less than this share of the time of the whole part as one feature, features that grow over walls are not laid.
const PARTED: f64 = 0.95;

/// Sources of the whole part that are laid ...
const SOURCES: usize = 3;
/// ... where the estimate says that they take no more than this share longer than the best.
const ALIKE: f64 = 0.02;

/// Ways of merging features that are laid where features are all that is asked for.
const MERGED: usize = 2;

/// The plan to run: of least cost; where it spends too much of its time not cutting, the quickest of those that do not, if that takes
/// hardly longer. Ties go to the first.
fn best(plans: &[Figures]) -> usize {
    let least = |of: &mut dyn Iterator<Item = usize>, cost: &dyn Fn(usize) -> f64| {
        of.reduce(|a, b| if cost(b) < cost(a) { b } else { a })
    };
    let kept = |k: usize| plans[k].not_cutting() <= NOT_CUTTING * plans[k].time_s;
    let best = least(&mut (0..plans.len()), &|k| plans[k].cost()).unwrap_or(0);
    let mut others = (0..plans.len())
        .filter(|&k| kept(k) && plans[k].time_s <= (1.0 + KEPT) * plans[best].time_s);
    least(&mut others, &|k| plans[k].time_s)
        .filter(|_| !kept(best))
        .unwrap_or(best)
}

/// The choice of least time, the first on a tie.
fn quickest(choices: Vec<Choice>) -> Choice {
    choices
        .into_iter()
        .reduce(|a, b| if b.time < a.time { b } else { a })
        .unwrap_or_default()
}

/// What plans laid so far tell of the next.
fn known(plans: &[Plan], scallop: f64) -> Known {
    Known {
        share: plans.first().map_or(0, |p| share_of(p, scallop)),
        settled: false,
        persistence: 0.0,
        to_beat: plans.iter().map(|p| p.figures.time_s).reduce(f64::min),
    }
}

/// The share of the cusp that a plan was laid for, as an index into [`PLAN_SHARES`].
fn share_of(plan: &Plan, scallop: f64) -> usize {
    (0..PLAN_SHARES.len())
        .find(|&k| plan.spaced_for >= (PLAN_SHARES[k] - 1e-6) * scallop)
        .unwrap_or(PLAN_SHARES.len() - 1)
}

/// Plans the toolpath of a surveyed part (`part` is the mesh its cutter was made from). Also hands back the reachable surface it was
/// judged against, in tiles.
pub fn plan<'g>(
    part: &Mesh,
    ground: &'g Ground,
    options: &PlanOptions,
    links: &LinkOptions,
    weigh: Weigh,
    stage: &mut dyn FnMut(Stage),
) -> (Plan, ReachTiles<'g>) {
    stage(Stage::Reachable);
    let step = sweep_step(&ground.cutter, options.scallop);
    let stepover = flat_stepover(options.scallop, ground.cutter.radius());
    let reach = ReachTiles::new(&ground.cutter, step, far(stepover, step) as usize + 2);
    let air = OnceLock::new();
    let parted = options.strategy == Strategy::Auto && ground.grid.len() <= LAID_TWICE;
    let detail = Detail::find(part, ground, options, parted);
    let bench = Bench {
        ground,
        detail: &detail,
        reach: &reach,
        part,
        air: &air,
        options,
        links,
        weigh,
        closed_loop: true,
    };
    stage(Stage::Choose);
    let small = bench.small();
    let raster =
        |angle: Option<f64>| Layout::Raster(angle.unwrap_or_else(|| best_raster_angle(&bench)));
    let mut plans: Vec<Plan> = Vec::new();
    match options.strategy {
        Strategy::Auto | Strategy::Whole => {
            let tried = best_sources(&bench);
            let whole_time = tried.first().map_or(f64::INFINITY, |s| s.1);
            let tries = if small { SOURCES } else { 1 };
            for (source, time) in tried.into_iter().take(tries) {
                // The estimate is no better than this.
                if time > (1.0 + ALIKE) * whole_time {
                    break;
                }
                let known = Known {
                    settled: !plans.is_empty(),
                    ..known(&plans, options.scallop)
                };
                plans.push(lay(&bench, &Layout::Whole(source), &[], &known, stage));
            }
            if options.strategy == Strategy::Auto && small {
                stage(Stage::Choose);
                let mut faces = None;
                if detail.faces.is_some() {
                    let choice = quickest(choose(&bench, &Layout::Faces));
                    let known = known(&plans, options.scallop);
                    let plan = lay(&bench, &Layout::Faces, &choice.fields, &known, stage);
                    faces = Some(plan.figures.time_s);
                    plans.push(plan);
                }
                // Passes that run over walls have no chance where passes between them do much better.
                let parted = faces.is_some_and(|faces| {
                    known(&plans[..plans.len() - 1], options.scallop)
                        .to_beat
                        .is_some_and(|whole| faces < PARTED * whole)
                });
                if !parted {
                    stage(Stage::Choose);
                    let choice = quickest(choose(&bench, &Layout::Features(Strategy::Auto)));
                    if choice.time < NOT_LAID * whole_time {
                        let known = Known {
                            persistence: choice.persistence,
                            ..known(&plans, options.scallop)
                        };
                        let layout = Layout::Features(choice.strategy());
                        plans.push(lay(&bench, &layout, &choice.fields, &known, stage));
                    }
                }
            }
        }
        Strategy::Raster(angle) => {
            plans.push(lay(&bench, &raster(angle), &[], &Known::default(), stage));
        }
        other => {
            let mut choices = choose(&bench, &Layout::Features(other));
            choices.sort_by(|a, b| a.time.total_cmp(&b.time));
            choices.truncate(if small { MERGED } else { 1 });
            for choice in &choices {
                let known = Known {
                    persistence: choice.persistence,
                    ..known(&plans, options.scallop)
                };
                let layout = Layout::Features(other);
                plans.push(lay(&bench, &layout, &choice.fields, &known, stage));
            }
        }
    }
    let mut candidates: Vec<Candidate> = plans.iter().flat_map(|p| p.candidates.clone()).collect();
    let figures: Vec<Figures> = plans.iter().map(|p| p.figures).collect();
    let best = best(&figures);
    for (k, c) in candidates.iter_mut().enumerate() {
        c.chosen = k == best;
    }
    let mut chosen = plans.swap_remove(best);
    drop(plans);
    if small {
        candidates.extend(rasters::rasters(
            &bench,
            (!matches!(options.strategy, Strategy::Raster(_))).then(|| raster(None)),
            &chosen,
            stage,
        ));
    }
    chosen.candidates = candidates;
    chosen.saddles = saddle_turns(
        &ground.critical,
        &ground.cutter,
        &chosen.passes,
        &chosen.toolpath,
        NEAR_SADDLE * stepover,
    );
    (chosen, reach)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_that_hardly_stops_cutting_is_worth_a_little_time() {
        let plan = |time_s: f64, share: f64| Figures {
            time_s,
            link_s: share * time_s,
            ..Figures::default()
        };
        // Seconds beyond a twentieth count twice.
        assert_eq!(best(&[plan(100.0, 0.12), plan(106.0, 0.02)]), 1);
        assert_eq!(best(&[plan(100.0, 0.12), plan(108.0, 0.02)]), 0);
        // A hair beyond it, and one that keeps to it takes 1 % longer, or 2 %.
        assert_eq!(best(&[plan(100.0, 0.051), plan(101.0, 0.049)]), 1);
        assert_eq!(best(&[plan(100.0, 0.051), plan(102.0, 0.049)]), 0);
        assert_eq!(best(&[plan(100.0, 0.05), plan(101.0, 0.0)]), 0);
        assert_eq!(best(&[plan(100.0, 0.3), plan(100.0, 0.3)]), 0);
        assert_eq!(best(&[]), 0);
    }
}
