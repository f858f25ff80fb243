//! `morsemill features`: critical points and machining features, without a program.

use super::args::{PartArgs, ToolArgs, above_zero};
use super::mill::StrategyName;
use super::output::{to_stdout, write_json, write_whole};
use super::progress::Progress;
use super::show::{self, CriticalJson, PartJson};
use super::{Failure, pictures};
use crate::reach::DropCutter;
use crate::toolpath::plan::DEFAULT_WALL_ANGLE;
use crate::toolpath::{PlanOptions, Stage, plan};
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
    /// How distance is measured when features grow
    #[arg(long, value_enum, default_value_t = StrategyName::IsoScallop)]
    pub strategy: StrategyName,
    /// Critical points whose heights differ less than this are noise, mm
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
    /// Height of the point the ball touches
    Height,
}

#[derive(serde::Serialize)]
struct FeaturesJson {
    part: PartJson,
    tool: String,
    function: &'static str,
    grid_step_mm: f64,
    persistence_mm: f64,
    critical_points: CriticalJson,
    features: Vec<RegionJson>,
}

#[derive(serde::Serialize)]
struct RegionJson {
    id: usize,
    kind: &'static str,
    area_mm2: f64,
    rim_passes: f64,
    /// Index into `critical_points.points`.
    seed: Option<usize>,
    /// Index into `critical_points.points`.
    saddle: Option<usize>,
}

/// Runs `features`.
pub fn run(a: &FeaturesArgs) -> Result<ExitCode, Failure> {
    a.tool.check()?;
    if let Some(p) = a.persistence {
        above_zero("--persistence", p, "mm")?;
    }
    let mut progress = Progress::new();
    progress.stage("import", "reading the part");
    let (loaded, placement) = a.placing.load(&a.part)?;
    a.tool.check_against(&placement)?;
    show::warn(&loaded, &placement);
    let options = PlanOptions {
        scallop: a.tool.scallop,
        strategy: a.strategy.with_angle(0.0),
        grid_step: None,
        persistence: a.persistence,
        memory_limit_bytes: 4 << 30,
        wall_angle: DEFAULT_WALL_ANGLE,
        floor: None,
        flute: a.tool.tool.flute_length(),
    };
    let mut stage = |at: Stage| {
        let (name, words) = show::stage_words(at);
        progress.stage(name, words);
    };
    let cutter = DropCutter::new(&placement.mesh, a.tool.tool.radius);
    let ground =
        plan::survey(cutter, &options, &mut |_, _| {}, &mut stage).map_err(Failure::failed)?;
    stage(Stage::Features);
    let regions = plan::features(
        &ground,
        options.strategy,
        plan::PLAN_SHARES[0] * a.tool.scallop,
    );
    progress.finish();
    if let Some(file) = &a.picture {
        write_whole(
            file,
            &pictures::features(
                &pictures::Subject::new(&a.part, &placement, pictures::WIDTH),
                &ground,
                &regions,
            )?,
        )?;
    }
    let rows: Vec<RegionJson> = regions
        .features
        .iter()
        .enumerate()
        .map(|(k, f)| RegionJson {
            id: k + 1,
            kind: f.kind.name(),
            area_mm2: f.area_mm2,
            rim_passes: f.rim,
            seed: f.seed,
            saddle: f.saddle,
        })
        .collect();
    to_stdout(|w| {
        show::part(w, &a.part, &loaded, &placement)?;
        show::critical(w, &ground.critical)?;
        writeln!(
            w,
            "\n{:>4}  {:<12} {:>11} {:>16}",
            "id", "feature", "area, mm2", "passes to rim"
        )?;
        for r in &rows {
            writeln!(
                w,
                "{:>4}  {:<12} {:>11.1} {:>16.1}",
                r.id, r.kind, r.area_mm2, r.rim_passes
            )?;
        }
        Ok(())
    })?;
    if let Some(file) = &a.json {
        let json = FeaturesJson {
            part: show::part_json(&a.part, &loaded, &placement),
            tool: a.tool.tool.to_string(),
            function: "height",
            grid_step_mm: ground.grid.step,
            persistence_mm: ground.persistence,
            critical_points: show::critical_json(&ground.critical),
            features: rows,
        };
        write_json(file, &json)?;
    }
    Ok(ExitCode::SUCCESS)
}
