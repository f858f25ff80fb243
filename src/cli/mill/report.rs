//! What `mill --json` and `--report` say: the whole job in figures.

use super::args::MillArgs;
use super::settings::Settings;
use crate::cli::show::{self, CriticalJson, FeatureJson, PartJson, StrategyJson};
use crate::part::{Loaded, Placement};
use crate::simulate::DryRun;
use crate::sweep::Rest;
use crate::toolpath::plan::Plan;
use crate::toolpath::{FitReport, Ground};
use crate::verify::Deviation;
use std::collections::BTreeMap;

#[derive(serde::Serialize)]
pub(super) struct MillJson<'a> {
    part: PartJson,
    tool: String,
    scallop_mm: f64,
    strategy: &'static str,
    machine: &'a str,
    post: &'a str,
    grid_step_mm: f64,
    function: &'static str,
    /// Of the function's values and of persistence.
    unit: &'static str,
    persistence: f64,
    /// The same where the unit is mm.
    persistence_mm: Option<f64>,
    spaced_for_um: f64,
    planned_memory_mib: u64,
    critical_points: CriticalJson,
    features: Vec<FeatureJson>,
    strategies: Vec<StrategyJson>,
    saddles: Vec<SaddleJson>,
    fill: FillJson,
    fit: FitJson,
    walls: WallsJson,
    /// Rest material is where more than this stays, along the normal, wherever the ball goes.
    rest_tolerance_mm: f64,
    /// Its area seen from above (what `finish.rest_area_mm2` measures cell by cell, to a percent or so) ...
    rest_plan_mm2: f64,
    /// ... and on the part's surface, upright walls included.
    rest_surface_mm2: f64,
    rest_spots: usize,
    rest: Vec<RestJson>,
    #[serde(flatten)]
    dry_run: &'a DryRun,
    read_back: ReadBackJson,
    seconds: BTreeMap<&'static str, f64>,
}

/// The sharpest turns within three stepovers of a saddle.
#[derive(serde::Serialize)]
struct SaddleJson {
    /// Index into `critical_points.points`.
    point: usize,
    x: f64,
    y: f64,
    /// With straight links.
    largest_turn_before_deg: f64,
    /// As cut.
    largest_turn_deg: f64,
}

#[derive(serde::Serialize)]
struct FillJson {
    rounds: usize,
    passes: usize,
    length_mm: f64,
    cells_left: usize,
}

/// Chord errors of the toolpath against the part, proven over the whole length of every move at feed.
#[derive(serde::Serialize)]
struct FitJson {
    segments: usize,
    arcs: usize,
    length_mm: f64,
    gouge_um_max: f64,
    stock_um_max: f64,
    over_gouge: usize,
    over_stock: usize,
}

impl From<&FitReport> for FitJson {
    fn from(f: &FitReport) -> FitJson {
        FitJson {
            segments: f.segments,
            arcs: f.arcs,
            length_mm: f.length_mm,
            gouge_um_max: 1e3 * f.gouge_max,
            stock_um_max: 1e3 * f.stock_max,
            over_gouge: f.over_gouge,
            over_stock: f.over_stock,
        }
    }
}

#[derive(serde::Serialize)]
struct WallsJson {
    /// Steeper than this, degrees from the horizontal.
    angle_deg: f64,
    /// How deep the flutes cut, mm; three diameters unless told.
    flute_mm: f64,
    flute_told: bool,
    /// Area of upright wall left standing because the flutes are too short, mm2.
    uncut_wall_mm2: f64,
    /// Where: the deepest place of each such wall, and the flutes that it would take.
    too_deep: Vec<TooDeepJson>,
}

#[derive(serde::Serialize)]
struct TooDeepJson {
    x: f64,
    y: f64,
    z: f64,
    needs_mm: f64,
}

#[derive(serde::Serialize)]
struct RestJson {
    x: f64,
    y: f64,
    z: f64,
    area_mm2: f64,
    depth_mm: f64,
    /// Diameter; null for a corner too sharp for any ball.
    largest_ball_mm: Option<f64>,
}

#[derive(serde::Serialize)]
struct ReadBackJson {
    moves: usize,
    position_mm_max: f64,
    feed_mm_per_min_max: f64,
}

/// A job that was planned, written, read back and cut in simulation.
pub(super) struct Done<'a> {
    pub args: &'a MillArgs,
    pub settings: &'a Settings,
    pub loaded: &'a Loaded,
    pub placement: &'a Placement,
    pub ground: &'a Ground,
    pub planned: &'a Plan,
    pub verdict: &'a DryRun,
    /// The program read back against the path that was planned.
    pub deviation: &'a Deviation,
    pub fit: &'a FitReport,
    pub features: &'a [FeatureJson],
    /// Where this ball cannot go.
    pub left: &'a Rest,
    /// What planning was announced to take.
    pub planned_bytes: u64,
    /// Wall clock by stage; the one thing in the report that differs from run to run.
    pub seconds: BTreeMap<&'static str, f64>,
}

/// All of it in figures.
pub(super) fn report<'a>(done: &Done<'a>) -> MillJson<'a> {
    let Done {
        args: a,
        settings: s,
        loaded,
        placement,
        ground,
        planned,
        verdict,
        deviation,
        fit,
        features,
        left,
        planned_bytes,
        ..
    } = *done;
    let function = s.plan.function;
    MillJson {
        part: show::part_json(&a.part, loaded, placement),
        tool: a.tool.tool.to_string(),
        scallop_mm: a.tool.scallop,
        strategy: s.plan.strategy.name(),
        machine: &s.machine.name,
        post: &s.post.name,
        grid_step_mm: ground.grid.step,
        function: function.name(),
        unit: function.unit(),
        persistence: ground.persistence,
        persistence_mm: (function.unit() == "mm").then_some(ground.persistence),
        spaced_for_um: planned.spaced_for * 1e3,
        planned_memory_mib: planned_bytes >> 20,
        critical_points: show::critical_json(&ground.critical),
        features: features.to_vec(),
        strategies: show::strategies(planned),
        saddles: planned
            .saddles
            .iter()
            .map(|t| SaddleJson {
                point: t.critical,
                x: t.center.x,
                y: t.center.y,
                largest_turn_before_deg: t.before,
                largest_turn_deg: t.after,
            })
            .collect(),
        fill: FillJson {
            rounds: planned.fill.rounds,
            passes: planned.fill.added,
            length_mm: planned.fill.length_mm,
            cells_left: planned.fill.cells_left,
        },
        fit: fit.into(),
        walls: WallsJson {
            angle_deg: a.wall_angle,
            flute_mm: a.tool.tool.flute_length(),
            flute_told: a.tool.tool.flute.is_some(),
            uncut_wall_mm2: planned.uncut_wall,
            too_deep: planned
                .too_deep
                .iter()
                .map(|t| TooDeepJson {
                    x: t.place.x,
                    y: t.place.y,
                    z: t.place.z,
                    needs_mm: t.needs,
                })
                .collect(),
        },
        rest_tolerance_mm: a.tool.scallop,
        rest_plan_mm2: left.plan,
        rest_surface_mm2: left.area,
        rest_spots: left.count,
        rest: left
            .spots
            .iter()
            .map(|s| RestJson {
                x: s.place.x,
                y: s.place.y,
                z: s.place.z,
                area_mm2: s.area,
                depth_mm: s.depth,
                largest_ball_mm: s.largest_ball.map(|r| (200.0 * r).floor() / 100.0),
            })
            .collect(),
        dry_run: verdict,
        read_back: ReadBackJson {
            moves: deviation.moves,
            position_mm_max: deviation.position.0,
            feed_mm_per_min_max: deviation.feed.0,
        },
        seconds: done.seconds.clone(),
    }
}
