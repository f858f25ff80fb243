//! `morsemill mill`: from a part to a proven program.

use super::args::{PartArgs, ToolArgs, above_zero, parse};
use super::features::FunctionName;
use super::output::{say, to_stdout, write_json, write_whole};
use super::progress::Progress;
use super::show::{self, CriticalJson, FeatureJson, PartJson, StrategyJson};
use super::{Failure, pictures, rest_picture};
use crate::machine::{DEFAULT_MACHINE, Machine};
use crate::part::{Loaded, Placement};
use crate::post::{Coolant, Job, Post, write};
use crate::reach::DropCutter;
use crate::simulate::{DryRun, DryRunOptions, Kind, PartContext, Problem, Stock, Verdict, dry_run};
use crate::sweep::{Rest, RestOptions, rest};
use crate::toolpath::plan::{self, Plan};
use crate::toolpath::{
    ArcOptions, DEFAULT_WALL_ANGLE, FILL_START, Figures, FitReport, Ground, LinkOptions,
    PlanOptions, RETRACT_WORTH, Stage, Strategy, Toolpath, arcs, proof,
};
use crate::units::{MmPerMin, Rpm, Seconds};
use crate::verify::{Deviation, dialect_of, verify};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `mill`.
#[derive(Clone, Debug, clap::Args)]
pub struct MillArgs {
    /// The part: STL or OBJ
    pub part: PathBuf,
    /// The program to write
    #[arg(short, long, value_name = "OUT.nc")]
    pub output: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub placing: PartArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub tool: ToolArgs,
    /// How passes are spaced
    #[arg(long, value_enum, default_value_t = StrategyName::Auto)]
    pub strategy: StrategyName,
    /// Direction of plane sections, degrees from X; a raster finds its own when left out, isoplanar features take 0
    #[arg(long, allow_negative_numbers = true, value_name = "DEGREES")]
    pub angle: Option<f64>,
    /// Machine: a name from `morsemill machines`, or a file
    #[arg(long, default_value = DEFAULT_MACHINE, value_name = "NAME|FILE")]
    pub machine: String,
    /// Dialect: a name from `morsemill posts`, or a file; the machine's own if left out
    #[arg(long, value_name = "NAME|FILE")]
    pub post: Option<String>,
    /// Cutting feed, mm/min
    #[arg(
        long,
        default_value_t = 1500.0,
        allow_negative_numbers = true,
        value_name = "MM_PER_MIN"
    )]
    pub feed: f64,
    /// Plunge feed, mm/min
    #[arg(
        long,
        default_value_t = 500.0,
        allow_negative_numbers = true,
        value_name = "MM_PER_MIN"
    )]
    pub plunge: f64,
    /// Spindle speed; the machine's fastest, or 18000 if that is less, when left out. 0 leaves the spindle to you
    #[arg(long, allow_negative_numbers = true, value_name = "RPM")]
    pub speed: Option<f64>,
    /// What stands before the first cut: allowance:MM over the finished surface, or block
    #[arg(long, default_value = "allowance:0.5", value_parser = parse::<StockArg>)]
    pub stock: StockArg,
    /// Step of the tool-centre grid, mm; a fifth of the stepover if left out
    #[arg(long, allow_negative_numbers = true, value_name = "MM")]
    pub grid: Option<f64>,
    /// Morse function whose critical points features grow from
    #[arg(long, value_enum, default_value_t = FunctionName::Height)]
    pub function: FunctionName,
    /// Critical points whose values differ less than this are noise, mm (mean-curvature: 1/mm)
    #[arg(long, allow_negative_numbers = true, value_name = "MM")]
    pub persistence: Option<f64>,
    /// Ground steeper than this gets passes at constant height, degrees from the horizontal
    #[arg(long, default_value_t = DEFAULT_WALL_ANGLE, allow_negative_numbers = true, value_name = "DEGREES")]
    pub wall_angle: f64,
    /// The tip goes no lower than this beside a closed solid, mm; the part's lowest point if left out. Walls that the flutes do not
    /// reach down to it are a warning, and with this flag a failure
    #[arg(long, allow_negative_numbers = true, value_name = "Z")]
    pub floor: Option<f64>,
    /// Most memory that planning may take, MiB
    #[arg(long, default_value_t = 4096, value_name = "MIB")]
    pub memory: u64,
    /// Say runs of segments as arcs (G2, G3) where the dialect has them and the arc is proven as true as they were
    #[arg(long)]
    pub arcs: bool,
    /// Write report.json and pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Width of the pictures, pixels
    #[arg(long, default_value_t = pictures::WIDTH, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(400..=4000))]
    pub picture_width: u32,
    /// Write the report as JSON to this file
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// The strategies by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum StrategyName {
    /// The quickest of the others
    Auto,
    /// Equal cusps everywhere
    IsoScallop,
    /// Equal distance on the part
    IsoPickFeed,
    /// Plane sections
    Isoplanar,
    /// The whole part as one feature, equal cusps everywhere
    Whole,
    /// The whole part in plane sections
    Raster,
}

impl StrategyName {
    /// With the angle of plane sections filled in.
    pub fn with_angle(self, angle: Option<f64>) -> Strategy {
        match self {
            StrategyName::Auto => Strategy::Auto,
            StrategyName::Whole => Strategy::Whole,
            StrategyName::Raster => Strategy::Raster(angle),
            StrategyName::IsoScallop => Strategy::IsoScallop,
            StrategyName::IsoPickFeed => Strategy::IsoPickFeed,
            StrategyName::Isoplanar => Strategy::Isoplanar(angle.unwrap_or(0.0)),
        }
    }
}

/// `allowance:MM` or `block`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StockArg {
    /// This much over the finished surface, mm.
    Allowance(f64),
    /// A block up to the part's top.
    Block,
}

impl std::str::FromStr for StockArg {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "block" {
            return Ok(StockArg::Block);
        }
        let mm = text
            .strip_prefix("allowance:")
            .and_then(|v| v.parse::<f64>().ok());
        match mm.filter(|v| v.is_finite() && (0.0..=1000.0).contains(v)) {
            Some(v) => Ok(StockArg::Allowance(v)),
            None => Err(format!(
                "stock \"{text}\" is not understood: write allowance:0.5 (mm over the finished surface) or block"
            )),
        }
    }
}

impl StockArg {
    /// As the dry run wants it, for a part with this top.
    pub fn stock(self, top_z: f64) -> Stock {
        match self {
            StockArg::Allowance(mm) => Stock::Allowance(mm),
            StockArg::Block => Stock::Block { top_z },
        }
    }
}

/// Air between ball and stock in rapid moves, mm.
const CLEARANCE: f64 = 0.5;
/// Height of XY rapids above the top of the stock, mm.
const SAFE_ABOVE: f64 = 5.0;

#[derive(serde::Serialize)]
struct MillJson<'a> {
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

/// The checked settings of a job.
struct Settings {
    machine: Machine,
    post: Post,
    plan: PlanOptions,
    speed: Rpm,
}

fn settle(a: &MillArgs) -> Result<Settings, Failure> {
    a.tool.check()?;
    above_zero("--feed", a.feed, "mm/min")?;
    above_zero("--plunge", a.plunge, "mm/min")?;
    if let Some(g) = a.grid {
        above_zero("--grid", g, "mm")?;
        if g > a.tool.tool.radius {
            return Err(Failure::Failed(format!(
                "--grid {g}: must be below the ball's radius of {} mm",
                a.tool.tool.radius
            )));
        }
    }
    if let Some(p) = a.persistence {
        above_zero("--persistence", p, a.function.function().unit())?;
    }
    if let Some(angle) = a.angle
        && !angle.is_finite()
    {
        return Err(Failure::Failed(format!(
            "--angle {angle}: must be a number of degrees"
        )));
    }
    if !(30.0..=90.0).contains(&a.wall_angle) {
        return Err(Failure::Failed(format!(
            "--wall-angle {}: must be between 30 and 90 degrees from the horizontal",
            a.wall_angle
        )));
    }
    if let Some(z) = a.floor.filter(|z| !z.is_finite()) {
        return Err(Failure::Failed(format!(
            "--floor {z}: must be a height in mm"
        )));
    }
    let machine = Machine::load(&a.machine).map_err(Failure::failed)?;
    let post = Post::load(a.post.as_deref().unwrap_or(&machine.post)).map_err(Failure::failed)?;
    let [lowest, highest] = machine.spindle;
    let speed = a.speed.unwrap_or(highest.0.min(18000.0));
    if !(speed.is_finite() && speed >= 0.0) {
        return Err(Failure::Failed(format!(
            "--speed {speed}: must be a number of revolutions per minute, or 0"
        )));
    }
    if speed > 0.0 && (speed > highest.0 || speed < lowest.0) {
        return Err(Failure::Rejected(format!(
            "--speed {speed}: the spindle of {} turns {} to {} rpm",
            machine.name, lowest.0, highest.0
        )));
    }
    for (k, (axis, rate)) in ["X", "Y", "Z"].iter().zip(machine.max_rate).enumerate() {
        let (flag, v) = if k < 2 {
            ("--feed", a.feed)
        } else {
            ("--plunge", a.plunge)
        };
        if v > rate.0 {
            say(&format!(
                "note: {flag} {v}: axis {axis} of {} moves at most {} mm/min and will hold the tool back there",
                machine.name, rate.0
            ));
        }
    }
    let plan = PlanOptions {
        scallop: a.tool.scallop,
        strategy: a.strategy.with_angle(a.angle),
        grid_step: a.grid,
        function: a.function.function(),
        persistence: a.persistence,
        memory_limit_bytes: a.memory.saturating_mul(1 << 20),
        wall_angle: a.wall_angle,
        floor: a.floor,
        flute: a.tool.tool.flute_length(),
        deepest: match a.stock {
            StockArg::Allowance(_) => f64::INFINITY,
            // Into the full block: no deeper than the tool is thick.
            StockArg::Block => 2.0 * a.tool.tool.radius,
        },
    };
    Ok(Settings {
        machine,
        post,
        plan,
        speed: Rpm(speed),
    })
}

/// Refuses a part that the axes cannot span, before any work is done.
fn fits(placement: &Placement, radius: f64, machine: &Machine) -> Result<(), Failure> {
    let size = placement.mesh.bounds().size();
    // The tip goes at most a radius beyond the outline on either side, but need not on a flat part: only what is sure is refused
    // here, the dry run knows the rest.
    for (k, axis) in ["X", "Y", "Z"].iter().enumerate() {
        let (need, have) = (size[k], machine.travel[k].0);
        if need > have {
            return Err(Failure::Rejected(format!(
                "the part is {need:.1} mm along {axis}, the machine {} travels {have} mm there (and a ball of radius {radius} mm needs room \
                 beside it): turn the part with --up, check --units, or take a larger machine",
                machine.name
            )));
        }
    }
    Ok(())
}

/// Runs `mill`.
pub fn run(a: &MillArgs) -> Result<ExitCode, Failure> {
    let s = settle(a)?;
    if a.output.is_dir() {
        return Err(Failure::Failed(format!(
            "{}: is a folder, not a file to write",
            a.output.display()
        )));
    }
    let radius = a.tool.tool.radius;
    let mut progress = Progress::new();
    if a.arcs && !s.post.arcs {
        say(&format!(
            "note: --arcs: post {} has no arcs; the program will be of straight lines",
            s.post.name
        ));
    }
    progress.stage("import", "reading the part");
    let (loaded, placement) = a.placing.load(&a.part)?;
    a.tool.check_against(&placement)?;
    fits(&placement, radius, &s.machine)?;
    show::warn(&loaded, &placement);

    progress.stage("reach", "sorting the part");
    let cutter = DropCutter::new(&placement.mesh, radius);
    let progress = std::cell::RefCell::new(progress);
    let mut stage = |at: Stage| {
        let (name, words) = show::stage_words(at);
        progress.borrow_mut().stage(name, words);
    };
    let mut planned_bytes = 0;
    let mut announce = |g: &crate::reach::GridPlan, bytes: u64| {
        planned_bytes = bytes;
        progress.borrow().note(format!(
            "tool-centre grid {} x {} nodes of {:.3} mm, planning takes about {} MiB",
            g.size[0],
            g.size[1],
            g.step,
            bytes >> 20
        ));
    };
    let ground =
        plan::survey(cutter, &s.plan, &mut announce, &mut stage).map_err(Failure::failed)?;
    let links = link_options(a, &s, &placement);
    let (mut planned, reachable) = plan::plan(
        &placement.mesh,
        &ground,
        &s.plan,
        &links,
        &weigh_on(&s.machine, a.feed, a.plunge),
        &mut stage,
    );
    let mut progress = progress.into_inner();

    progress.stage("proof", "proving every segment");
    if a.arcs && s.post.arcs {
        let how = ArcOptions::new(planned.fitting, s.machine.arc_tolerance.0);
        planned.toolpath = arcs(&planned.toolpath, &ground.cutter, &how);
    }
    let fit = proof(
        &ground.cutter,
        &planned.toolpath,
        s.machine.arc_tolerance.0,
        &planned.fitting,
    );

    progress.stage("post", "writing the program");
    let job = job(a, &s, &placement, &ground, &planned);
    let posted = write(&planned.toolpath, &job, &s.post).map_err(Failure::failed)?;
    progress.stage("verify", "reading the program back");
    let deviation = verify(&posted, &planned.toolpath, &job, &s.post).map_err(Failure::failed)?;
    progress.stage("dry_run", "cutting the program in simulation");
    let context = PartContext {
        mesh: &placement.mesh,
        drop: &ground.cutter,
        reachable: &reachable,
    };
    let top = placement.mesh.bounds().max.z;
    let options = DryRunOptions::new(a.tool.scallop, a.stock.stock(top));
    let dialect = dialect_of(&s.post).map_err(Failure::failed)?;
    let mut verdict = dry_run(&posted.text, dialect, &s.machine, Some(&context), &options);
    standing(a, &planned, &mut verdict);
    let times = crate::gcode::interpret(&posted.text, dialect)
        .map(|p| {
            crate::kinematics::program_time(
                &p.events,
                &crate::kinematics::Settings::from(&s.machine),
            )
            .per_line
        })
        .unwrap_or_default();
    let features = show::features(&planned, &posted, &times);
    progress.stage("rest", "looking for what the ball leaves");
    let left = rest(
        &placement.mesh,
        &ground.cutter,
        &RestOptions::for_scallop(a.tool.scallop),
    );

    if let Some(dir) = &a.report {
        progress.stage("pictures", "drawing");
        std::fs::create_dir_all(dir)
            .map_err(|e| Failure::Failed(format!("{}: {e}", dir.display())))?;
        pictures::draw_all(
            dir,
            &pictures::Subject::new(&a.part, &placement, a.picture_width),
            &ground,
            &planned,
            &verdict,
            a.tool.scallop,
        )?;
        rest_picture::draw(
            dir,
            &pictures::Subject::new(&a.part, &placement, a.picture_width),
            verdict.map.as_ref(),
            verdict.finish.as_ref(),
            &left,
            a.tool.scallop,
        )?;
    }
    let total = progress.finish();
    let mut seconds: BTreeMap<&'static str, f64> = BTreeMap::new();
    for (name, t) in &progress.seconds {
        *seconds.entry(name).or_default() += t;
    }
    seconds.insert("total", total);

    let json = mill_json(
        a,
        &s,
        &loaded,
        &placement,
        &ground,
        &planned,
        &verdict,
        &deviation,
        &fit,
        features.clone(),
        &left,
        planned_bytes,
        seconds,
    );
    if let Some(file) = &a.json {
        write_json(file, &json)?;
    }
    if let Some(dir) = &a.report {
        write_json(&dir.join("report.json"), &json)?;
    }
    // A program that would break something is not left lying about; one with a poor finish is, with the verdict saying so.
    let dangerous = verdict
        .problems
        .iter()
        .any(|p| !matches!(p.kind, Kind::Scallop | Kind::Uncut));
    if !dangerous {
        write_whole(&a.output, posted.text.as_bytes())?;
    }
    to_stdout(|w| {
        show::part(w, &a.part, &loaded, &placement)?;
        show::critical(w, &ground.critical)?;
        show::feature_table(w, &features)?;
        show::verdict(w, &verdict, a.tool.scallop)?;
        show::rest(w, &left, a.tool.scallop)?;
        if dangerous {
            writeln!(w, "no program was written: it would not be safe to run")
        } else {
            writeln!(
                w,
                "{}: {} lines for {} ({})",
                a.output.display(),
                verdict.program.lines,
                s.machine.name,
                s.post.name
            )
        }
    })?;
    Ok(if verdict.passed() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

/// Walls left standing: a warning; where the user named the floor they were to be cut down to, a reason to fail.
fn standing(a: &MillArgs, planned: &Plan, verdict: &mut DryRun) {
    let Some(text) = show::standing(planned.uncut_wall, &planned.too_deep, &a.tool.tool) else {
        return;
    };
    let problem = Problem {
        kind: Kind::Uncut,
        line: None,
        text,
    };
    if a.floor.is_some() {
        verdict.problems.push(problem);
        verdict.verdict = Verdict::Fail;
    } else {
        verdict.warnings.push(problem);
    }
}

/// The machine's own planner as a judge of toolpaths.
fn weigh_on(machine: &Machine, feed: f64, plunge: f64) -> impl Fn(&Toolpath) -> Figures + Sync {
    let settings = crate::kinematics::Settings::from(machine);
    move |path| crate::weigh::weigh(path, &settings, MmPerMin(feed), MmPerMin(plunge))
}

fn link_options(a: &MillArgs, s: &Settings, placement: &Placement) -> LinkOptions {
    let m = &s.machine;
    let top = placement.mesh.bounds().max.z;
    let (allowance, block) = match a.stock {
        StockArg::Allowance(mm) => (mm, f64::NEG_INFINITY),
        StockArg::Block => (0.0, top + a.tool.tool.radius),
    };
    LinkOptions {
        feed: a.feed / 60.0,
        plunge: a.plunge / 60.0,
        rapid_xy: m.max_rate[0].mm_per_s().min(m.max_rate[1].mm_per_s()),
        rapid_z: m.max_rate[2].mm_per_s(),
        acceleration: m
            .acceleration
            .iter()
            .map(|v| v.0)
            .fold(f64::INFINITY, f64::min),
        allowance,
        clearance: CLEARANCE,
        block_center_z: block,
        safe_center_z: top + allowance + SAFE_ABOVE + a.tool.tool.radius,
        retract_center_z: f64::NEG_INFINITY,
        retract_worth: RETRACT_WORTH,
        vertical: m.acceleration[2].0,
    }
}

fn job(a: &MillArgs, s: &Settings, placement: &Placement, ground: &Ground, planned: &Plan) -> Job {
    let b = placement.mesh.bounds();
    let name = a
        .part
        .file_name()
        .map(|n| n.to_string_lossy().into_owned())
        .unwrap_or_default();
    let f = &planned.fitting;
    let um = 1e3;
    let header = vec![
        format!("morsemill {} part {name}", env!("CARGO_PKG_VERSION")),
        format!(
            "part X {:.3} to {:.3} Y {:.3} to {:.3} Z {:.3} to {:.3} mm",
            b.min.x, b.max.x, b.min.y, b.max.y, b.min.z, b.max.z
        ),
        format!(
            "tool ball end mill {} mm, Z is its tip",
            2.0 * a.tool.tool.radius
        ),
        match a.stock {
            StockArg::Allowance(mm) => {
                format!("stock assumed at most {mm} mm over the finished surface")
            }
            StockArg::Block => format!("stock assumed a block up to Z {:.3}", b.max.z),
        },
        format!(
            "strategy {} scallop {} mm",
            planned.layout.name(),
            a.tool.scallop
        ),
        format!("machine {} post {}", s.machine.name, s.post.name),
        format!(
            "error budget um: chord gouge {:.1} chord stock {:.1} sideways {:.1} rounding {:.2} facets are the file's",
            f.gouge * um,
            f.stock * um,
            f.sideways * um,
            s.post.rounding().0 * um
        ),
        format!(
            "cusps planned at {:.1} um, grid step {:.3} mm, filled where over {:.1} um",
            planned.spaced_for * um,
            ground.grid.step,
            FILL_START * a.tool.scallop * um
        ),
    ];
    Job {
        header,
        feed: MmPerMin(a.feed),
        plunge: MmPerMin(a.plunge),
        speed: s.speed,
        tool_number: 1,
        spin_up: Seconds(if s.speed.0 > 0.0 { 4.0 } else { 0.0 }),
        coolant: Coolant::Off,
        path_tolerance: None,
    }
}

#[allow(clippy::too_many_arguments)]
fn mill_json<'a>(
    a: &MillArgs,
    s: &'a Settings,
    loaded: &Loaded,
    placement: &Placement,
    ground: &Ground,
    planned: &Plan,
    verdict: &'a DryRun,
    deviation: &Deviation,
    fit: &FitReport,
    features: Vec<FeatureJson>,
    left: &Rest,
    planned_bytes: u64,
    seconds: BTreeMap<&'static str, f64>,
) -> MillJson<'a> {
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
        features,
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
        seconds,
    }
}
