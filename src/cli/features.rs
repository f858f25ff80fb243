//! `morsemill features`: critical points and machining features, without a program; on the tool-centre grid or on the raw mesh.

use super::args::{PartArgs, ToolArgs};
use super::mill::StrategyName;
use super::output::{to_stdout, write_json, write_whole};
use super::progress::Progress;
use super::show::{self, PartJson};
use super::{Failure, pictures};
use crate::morse::cancel::Pair;
use crate::morse::table::thresholds;
use crate::morse::{
    AverageOptions, CriticalKind, CriticalPoint, Euler, FieldOptions, GridField, GridMorse,
    MeshMorse, MeshOptions, MorseFunction, Surface, mesh,
};
use crate::part::{Loaded, Placement};
use crate::reach::DropCutter;
use crate::toolpath::{DEFAULT_WALL_ANGLE, PLAN_SHARES, PlanOptions, Stage, flat_stepover, plan};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `features`.
#[derive(Clone, Debug, clap::Args)]
pub struct FeaturesArgs {
    /// The part: STL or OBJ
    pub part: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub placing: PartArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub tool: ToolArgs,
    /// The Morse function whose critical points are sought
    #[arg(long, value_enum, default_value_t = FunctionName::Height)]
    pub function: FunctionName,
    /// Where it is looked at: what the ball can touch, or every vertex of the file
    #[arg(long, value_enum, default_value_t = Where::Grid)]
    pub on: Where,
    /// How distance is measured when features grow (on the grid)
    #[arg(long, value_enum, default_value_t = StrategyName::IsoScallop)]
    pub strategy: StrategyName,
    /// Critical points whose values differ less than this are noise: mm, or 1/mm for mean-curvature; 0 keeps them all. The
    /// printed table tells what each threshold leaves
    #[arg(long, allow_negative_numbers = true, value_name = "MM")]
    pub persistence: Option<f64>,
    /// Write critical points and features as JSON to this file
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Draw them into this PNG
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
}

/// Morse functions by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum FunctionName {
    /// Height of the point the ball touches, or of the vertex
    Height,
    /// Mean curvature over about a stepover, positive where the part bulges
    MeanCurvature,
    /// Average geodesic distance to the whole of the surface
    Geodesic,
    /// Distance to the plane that fits best
    #[value(alias = "plane")]
    Projection,
}

impl FunctionName {
    /// As `morse` knows it.
    pub fn function(self) -> MorseFunction {
        match self {
            FunctionName::Height => MorseFunction::Height,
            FunctionName::MeanCurvature => MorseFunction::MeanCurvature,
            FunctionName::Geodesic => MorseFunction::Geodesic,
            FunctionName::Projection => MorseFunction::Projection,
        }
    }
}

/// Where a function is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Where {
    /// The tool-centre grid: only what this ball can feel, seen from above
    Grid,
    /// The raw mesh, open or closed, from all sides; no tool matters
    Mesh,
}

#[derive(serde::Serialize)]
struct FeaturesJson {
    part: PartJson,
    #[serde(skip_serializing_if = "Option::is_none")]
    tool: Option<String>,
    function: &'static str,
    /// Of the function's values and of persistence.
    unit: &'static str,
    on: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid_step_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<MeshJson>,
    persistence: f64,
    /// The same, where the unit is mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    persistence_mm: Option<f64>,
    critical_points: CriticalJson,
    euler: EulerJson,
    persistence_table: Vec<Row>,
    persistence_pairs: Vec<PairJson>,
    persistence_pairs_left_out: usize,
    features: Vec<RegionJson>,
}

#[derive(serde::Serialize)]
struct MeshJson {
    vertices: usize,
    edges: usize,
    triangles: usize,
    pieces: usize,
    border_vertices: usize,
    /// Edges of more than two triangles.
    crowded_edges: usize,
}

#[derive(serde::Serialize)]
struct CriticalJson {
    maxima: usize,
    minima: usize,
    saddles: usize,
    points: Vec<PointJson>,
}

#[derive(serde::Serialize)]
struct PointJson {
    kind: &'static str,
    #[serde(rename = "where")]
    place: &'static str,
    contact_mm: [f64; 3],
    center_mm: [f64; 3],
    value: f64,
    /// `null` for the last of its kind.
    persistence: Option<f64>,
    /// The same, where the unit is mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    persistence_mm: Option<Option<f64>>,
}

/// Before anything is cancelled: 2 * inside + border = 2 * characteristic.
#[derive(serde::Serialize)]
struct EulerJson {
    characteristic: i64,
    inside: i64,
    border: i64,
    holds: bool,
}

/// What a threshold leaves.
#[derive(Clone, serde::Serialize)]
struct Row {
    threshold: f64,
    maxima: usize,
    saddles: usize,
    minima: usize,
    /// `null` where there are too many to grow.
    features: Option<usize>,
}

/// An extreme and the saddle it ends at, as values; `death` is `null` for the last of a piece.
#[derive(serde::Serialize)]
struct PairJson {
    kind: &'static str,
    birth: f64,
    death: Option<f64>,
    persistence: Option<f64>,
}

#[derive(serde::Serialize)]
struct RegionJson {
    id: usize,
    kind: &'static str,
    area_mm2: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    rim_passes: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangles: Option<usize>,
    /// Index into `critical_points.points`.
    seed: Option<usize>,
    /// Index into `critical_points.points`.
    saddle: Option<usize>,
}

/// What both ways of looking find.
struct Found {
    critical: Vec<CriticalPoint>,
    persistence: f64,
    euler: Euler,
    table: Vec<Row>,
    pairs: Vec<PairJson>,
    left_out: usize,
    features: Vec<RegionJson>,
    grid_step: Option<f64>,
    mesh: Option<MeshJson>,
}

/// Runs `features`.
pub fn run(a: &FeaturesArgs) -> Result<ExitCode, Failure> {
    a.tool.check()?;
    if let Some(p) = a.persistence
        && !(p.is_finite() && p >= 0.0)
    {
        let unit = a.function.function().unit();
        return Err(Failure::Failed(format!(
            "--persistence {p}: must be a number of {unit}, zero or more"
        )));
    }
    let mut progress = Progress::new();
    progress.stage("import", "reading the part");
    let (loaded, placement) = a.placing.load(&a.part)?;
    let found = match a.on {
        Where::Grid => {
            a.tool.check_against(&placement)?;
            show::warn(&loaded, &placement);
            on_grid(a, &placement, &mut progress)?
        }
        Where::Mesh => {
            show::warn(&loaded, &placement);
            on_mesh(a, &loaded, &placement, &mut progress)?
        }
    };
    progress.finish();
    to_stdout(|w| {
        show::part(w, &a.part, &loaded, &placement)?;
        tell(w, a, &found)
    })?;
    if let Some(file) = &a.json {
        let f = a.function.function();
        let mm = f.unit() == "mm";
        write_json(
            file,
            &FeaturesJson {
                part: show::part_json(&a.part, &loaded, &placement),
                tool: (a.on == Where::Grid).then(|| a.tool.tool.to_string()),
                function: f.name(),
                unit: f.unit(),
                on: match a.on {
                    Where::Grid => "grid",
                    Where::Mesh => "mesh",
                },
                grid_step_mm: found.grid_step,
                mesh: found.mesh,
                persistence: found.persistence,
                persistence_mm: mm.then_some(found.persistence),
                critical_points: critical_json(&found.critical, mm),
                euler: EulerJson {
                    characteristic: found.euler.characteristic,
                    inside: found.euler.inside,
                    border: found.euler.border,
                    holds: found.euler.holds(),
                },
                persistence_table: found.table,
                persistence_pairs: found.pairs,
                persistence_pairs_left_out: found.left_out,
                features: found.features,
            },
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Radius that curvature is averaged over: one and a half stepovers.
fn curvature_radius(a: &FeaturesArgs) -> f64 {
    1.5 * flat_stepover(a.tool.scallop, a.tool.tool.radius)
}

fn on_grid(
    a: &FeaturesArgs,
    placement: &Placement,
    progress: &mut Progress,
) -> Result<Found, Failure> {
    let options = PlanOptions {
        scallop: a.tool.scallop,
        strategy: a.strategy.with_angle(None),
        grid_step: None,
        // The function is asked for itself, below, at every threshold.
        function: MorseFunction::Height,
        persistence: a.persistence,
        memory_limit_bytes: 4 << 30,
        wall_angle: DEFAULT_WALL_ANGLE,
        floor: None,
        flute: a.tool.tool.flute_length(),
        deepest: f64::INFINITY,
    };
    let mut stage = |at: Stage| {
        let (name, words) = show::stage_words(at);
        progress.stage(name, words);
    };
    let cutter = DropCutter::new(&placement.mesh, a.tool.tool.radius);
    let mut ground =
        plan::survey(cutter, &options, &mut |_, _| {}, &mut stage).map_err(Failure::failed)?;
    let function = a.function.function();
    let field = GridField::of(
        &ground.grid,
        function,
        &FieldOptions {
            radius: curvature_radius(a),
            average: AverageOptions::default(),
        },
    );
    // Heights have the planner's own yardstick: cusps, steps of the grid, roughness of the border.
    let of_heights = matches!(function, MorseFunction::Height | MorseFunction::Projection);
    if !of_heights && a.persistence.is_none() {
        ground.persistence = field.noise();
    }
    stage(Stage::Features);
    let spaced_for = PLAN_SHARES[0] * a.tool.scallop;
    let (rows, critical, euler, pairs, left_out) = {
        let morse = GridMorse::new(&ground.grid, &field);
        let rows: Vec<(f64, Vec<CriticalPoint>)> =
            thresholds(morse.pairs().map(|(_, p)| p.persistence))
                .into_iter()
                .map(|t| (t, morse.critical_nodes(t)))
                .collect();
        let (pairs, left_out) = diagram(morse.pairs(), &field.value);
        let critical = morse.critical_points(ground.persistence);
        (rows, critical, morse.euler, pairs, left_out)
    };
    let mut table: Vec<Row> = Vec::new();
    for (threshold, points) in rows {
        let [maxima, minima, saddles] = show::counts(&points);
        let few = maxima + minima <= MOST_GROWN;
        ground.critical = points;
        let features = few.then(|| {
            plan::features(&ground, options.strategy, spaced_for)
                .features
                .len()
        });
        table.push(Row {
            threshold,
            maxima,
            saddles,
            minima,
            features,
        });
    }
    ground.critical = critical;
    let regions = plan::features(&ground, options.strategy, spaced_for);
    if let Some(file) = &a.picture {
        let of = pictures::Subject::new(&a.part, placement, pictures::WIDTH);
        write_whole(
            file,
            &pictures::features(&of, &ground, &regions, decimals(function))?,
        )?;
    }
    let features = regions
        .features
        .iter()
        .enumerate()
        .map(|(k, f)| RegionJson {
            id: k + 1,
            kind: f.kind.name(),
            area_mm2: f.area_mm2,
            rim_passes: Some(f.rim),
            triangles: None,
            seed: f.seed,
            saddle: f.saddle,
        })
        .collect();
    Ok(Found {
        persistence: ground.persistence,
        euler,
        table,
        pairs,
        left_out,
        features,
        grid_step: Some(ground.grid.step),
        mesh: None,
        critical: ground.critical,
    })
}

/// Extremes that features are grown from for the table, at most.
const MOST_GROWN: usize = 300;

fn on_mesh(
    a: &FeaturesArgs,
    loaded: &Loaded,
    placement: &Placement,
    progress: &mut Progress,
) -> Result<Found, Failure> {
    progress.stage("morse", "finding critical points");
    let function = a.function.function();
    let surface = Surface::of_mesh(&placement.mesh, &loaded.soundness);
    let how = MeshOptions {
        // A facet says nothing of curvature by itself.
        radius: curvature_radius(a).max(2.0 * surface.mean_edge()),
        average: AverageOptions::default(),
    };
    let value = mesh::values(&surface, function, &how);
    let morse = MeshMorse::new(&surface, &value);
    let persistence = a.persistence.unwrap_or_else(|| {
        let noise = mesh::noise_of(&surface, function, &value, &how);
        match function {
            // As on the grid: a cusp and a half; and what noise of the mesh digs.
            MorseFunction::Height | MorseFunction::Projection => noise.max(1.5 * a.tool.scallop),
            _ => noise,
        }
    });
    let critical = morse.critical_points(persistence);
    let table = thresholds(morse.pairs().map(|(_, p)| p.persistence))
        .into_iter()
        .map(|threshold| {
            let [maxima, minima, saddles] = show::counts(&morse.critical_points(threshold));
            Row {
                threshold,
                maxima,
                saddles,
                minima,
                features: Some(maxima + minima),
            }
        })
        .collect();
    let (pairs, left_out) = diagram(morse.pairs(), &value);
    if let Some(file) = &a.picture {
        progress.stage("picture", "drawing");
        let of = pictures::Subject::new(&a.part, placement, pictures::WIDTH);
        let png = pictures::function_on_mesh(
            &of,
            &surface,
            &value,
            function,
            &critical,
            decimals(function),
        )?;
        write_whole(file, &png)?;
    }
    let features = morse
        .cells(&critical, persistence)
        .iter()
        .enumerate()
        .map(|(k, c)| {
            let seed = &critical[c.extreme];
            RegionJson {
                id: k + 1,
                kind: match (seed.kind, seed.boundary) {
                    (CriticalKind::Maximum, false) => "peak",
                    (CriticalKind::Maximum, true) => "border-peak",
                    (_, false) => "pit",
                    (_, true) => "border-pit",
                },
                area_mm2: c.area_mm2,
                rim_passes: None,
                triangles: Some(c.triangles),
                seed: Some(c.extreme),
                saddle: None,
            }
        })
        .collect();
    Ok(Found {
        persistence,
        euler: morse.euler,
        table,
        pairs,
        left_out,
        features,
        grid_step: None,
        mesh: Some(MeshJson {
            vertices: surface.len(),
            edges: surface.edges.len(),
            triangles: surface.triangles.len(),
            pieces: surface.pieces().1,
            border_vertices: surface.border.iter().filter(|b| **b).count(),
            crowded_edges: surface.crowded_edges,
        }),
        critical,
    })
}

fn decimals(function: MorseFunction) -> usize {
    match function {
        MorseFunction::MeanCurvature => 3,
        _ => 1,
    }
}

/// Pairs in a report, at most; the most persistent ones.
const MOST_PAIRS: usize = 2000;

fn diagram<'a>(
    pairs: impl Iterator<Item = (CriticalKind, &'a Pair)>,
    value: &[f64],
) -> (Vec<PairJson>, usize) {
    let mut all: Vec<(CriticalKind, &Pair)> = pairs.collect();
    all.sort_by(|a, b| {
        b.1.persistence
            .total_cmp(&a.1.persistence)
            .then(a.0.cmp(&b.0))
            .then(a.1.extreme.cmp(&b.1.extreme))
    });
    let left_out = all.len().saturating_sub(MOST_PAIRS);
    let rows = all
        .iter()
        .take(MOST_PAIRS)
        .map(|(kind, p)| PairJson {
            kind: kind_name(*kind),
            birth: value[p.extreme],
            death: p.merge.map(|m| value[m]),
            persistence: p.persistence.is_finite().then_some(p.persistence),
        })
        .collect();
    (rows, left_out)
}

fn kind_name(kind: CriticalKind) -> &'static str {
    match kind {
        CriticalKind::Maximum => "max",
        CriticalKind::Minimum => "min",
        CriticalKind::Saddle => "saddle",
    }
}

fn critical_json(points: &[CriticalPoint], mm: bool) -> CriticalJson {
    let [maxima, minima, saddles] = show::counts(points);
    let points = points
        .iter()
        .map(|p| {
            let persistence = p.persistence.is_finite().then_some(p.persistence);
            PointJson {
                kind: kind_name(p.kind),
                place: if p.boundary { "border" } else { "interior" },
                contact_mm: p.contact.coords.into(),
                center_mm: p.center.coords.into(),
                value: p.value,
                persistence,
                persistence_mm: mm.then_some(persistence),
            }
        })
        .collect();
    CriticalJson {
        maxima,
        minima,
        saddles,
        points,
    }
}

/// A number with about four figures.
fn short(v: f64) -> String {
    if v == 0.0 {
        return "0".to_string();
    }
    let digits = (3 - v.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

fn tell(w: &mut dyn Write, a: &FeaturesArgs, found: &Found) -> io::Result<()> {
    let f = a.function.function();
    if let Some(m) = &found.mesh {
        writeln!(
            w,
            "mesh       {} vertices, {} triangles in {} piece{}, {} border vertices{}",
            m.vertices,
            m.triangles,
            m.pieces,
            if m.pieces == 1 { "" } else { "s" },
            m.border_vertices,
            if m.crowded_edges > 0 {
                format!(
                    "; {} edges have more than two triangles: cells branch there",
                    m.crowded_edges
                )
            } else {
                String::new()
            }
        )?;
    }
    writeln!(
        w,
        "function   {}, pairs below {} {} cancelled",
        f.name(),
        short(found.persistence),
        f.unit()
    )?;
    show::critical(w, &found.critical)?;
    let e = &found.euler;
    writeln!(
        w,
        "euler      {} (peaks - saddles + pits before cancelling: {} inside, {} on the border, those half){}",
        e.characteristic,
        e.inside,
        e.border,
        if e.holds() {
            ""
        } else {
            "; they do not agree: the surface branches"
        }
    )?;
    let last = if a.on == Where::Grid {
        "passes to rim"
    } else {
        "triangles"
    };
    writeln!(
        w,
        "\n{:>4}  {:<12} {:>11} {:>16}",
        "id", "feature", "area, mm2", last
    )?;
    const MOST: usize = 60;
    for r in found.features.iter().take(MOST) {
        let last = match (r.rim_passes, r.triangles) {
            (Some(p), _) => format!("{p:.1}"),
            (_, Some(t)) => t.to_string(),
            _ => String::new(),
        };
        writeln!(
            w,
            "{:>4}  {:<12} {:>11.1} {last:>16}",
            r.id, r.kind, r.area_mm2
        )?;
    }
    if found.features.len() > MOST {
        writeln!(
            w,
            "      and {} more (all in --json)",
            found.features.len() - MOST
        )?;
    }
    writeln!(
        w,
        "\n{:>14} {:>8} {:>8} {:>8} {:>9}",
        "--persistence", "maxima", "saddles", "minima", "features"
    )?;
    for r in &found.table {
        writeln!(
            w,
            "{:>14} {:>8} {:>8} {:>8} {:>9}",
            format!("{}", r.threshold),
            r.maxima,
            r.saddles,
            r.minima,
            r.features.map_or("many".to_string(), |n| n.to_string())
        )?;
    }
    Ok(())
}
