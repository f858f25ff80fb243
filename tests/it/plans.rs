//! Whole plans of the shipped parts, made once and looked at by several tests.
#![allow(dead_code, clippy::unwrap_used)]

use super::common::{PARTS, Shelf, Shipped};
use super::morse::options;
use morsemill::cldata::{Coolant, Job};
use morsemill::gcode::{Event, MotionKind, interpret};
use morsemill::geom::Point;
use morsemill::kinematics::Settings;
use morsemill::machine::Machine;
use morsemill::part::Mesh;
use morsemill::post::{Post, Posted, write};
use morsemill::reach::DropCutter;
use morsemill::simulate::{DryRun, DryRunOptions, PartContext, Stock, dry_run};
use morsemill::toolpath::plan::{Plan, Strategy, plan, survey};
use morsemill::toolpath::{Ground, LinkOptions, RETRACT_WORTH, Toolpath};
use morsemill::units::{MmPerMin, Rpm, Seconds};
use morsemill::verify::dialect_of;
use morsemill::weigh::weigh;
use std::sync::{Arc, OnceLock};

pub const R: f64 = 3.0;
pub const ALLOWANCE: f64 = 0.5;

/// A part, its plan, its program for GRBL, and the dry run of that text.
pub struct Planned {
    pub part: Shipped,
    pub mesh: Mesh,
    pub ground: Ground,
    pub plan: Plan,
    pub job: Job,
    pub posted: Posted,
    pub verdict: DryRun,
}

static SHELF: Shelf<Planned> = Shelf::new();

/// The plan of a part at a cusp height, made by whoever asks first.
pub fn planned(part: Shipped, scallop: f64, strategy: Strategy) -> Arc<OnceLock<Planned>> {
    let cell = SHELF.get(&format!("{} {scallop} {strategy:?}", part.file));
    cell.get_or_init(|| make(part, scallop, strategy));
    cell
}

/// The cusp height a part is planned at here, mm: the 20 um for three of them, twice that for the others, for time.
pub fn scallop(part: &Shipped) -> f64 {
    match part.file {
        "two-peaks.stl" | "peaks-and-pits.stl" | "steep-relief.stl" => 0.02,
        _ => 0.04,
    }
}

/// Every shipped part with equal cusps.
pub fn all() -> impl Iterator<Item = Arc<OnceLock<Planned>>> {
    PARTS
        .into_iter()
        .map(|p| planned(p, scallop(&p), Strategy::IsoScallop))
}

pub fn links(top: f64) -> LinkOptions {
    let m = machine();
    LinkOptions {
        feed: 25.0,
        plunge: 500.0 / 60.0,
        rapid_xy: m.max_rate[0].mm_per_s().min(m.max_rate[1].mm_per_s()),
        rapid_z: m.max_rate[2].mm_per_s(),
        acceleration: m
            .acceleration
            .iter()
            .map(|a| a.0)
            .fold(f64::INFINITY, f64::min),
        allowance: ALLOWANCE,
        clearance: 0.5,
        block_center_z: f64::NEG_INFINITY,
        safe_center_z: top + ALLOWANCE + 5.0 + R,
        retract_center_z: f64::NEG_INFINITY,
        retract_worth: RETRACT_WORTH,
        vertical: m.acceleration[2].0,
    }
}

pub fn machine() -> Machine {
    Machine::load("longmill-30x30").unwrap()
}

fn make(part: Shipped, scallop: f64, strategy: Strategy) -> Planned {
    let mesh = part.mesh();
    let mut how = options(scallop);
    how.strategy = strategy;
    let cutter = DropCutter::new(&mesh, R);
    let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
    let top = mesh.bounds().max.z;
    let settings = Settings::from(&machine());
    let clock = |path: &Toolpath| weigh(path, &settings, MmPerMin(1500.0), MmPerMin(500.0));
    let (plan, reachable) = plan(&mesh, &ground, &how, &links(top), &clock, &mut |_| {});
    let job = Job {
        header: vec![format!("{} {scallop}", part.file)],
        feed: MmPerMin(1500.0),
        plunge: MmPerMin(500.0),
        speed: Rpm(18000.0),
        tool_number: 1,
        spin_up: Seconds(4.0),
        coolant: Coolant::Off,
        path_tolerance: None,
    };
    let post = Post::load("grbl").unwrap();
    let posted = write(&plan.toolpath, &job, &post).unwrap();
    let context = PartContext {
        mesh: &mesh,
        drop: &ground.cutter,
        reachable: &reachable,
    };
    let judge = DryRunOptions::new(scallop, Stock::Allowance(ALLOWANCE));
    let mut verdict = dry_run(
        &posted.text,
        dialect_of(&post).unwrap(),
        &machine(),
        Some(&context),
        &judge,
    );
    verdict.map = None; // large, and of no use here
    Planned {
        part,
        mesh,
        ground,
        plan,
        job,
        posted,
        verdict,
    }
}

/// The straight moves of a program's text once all axes have been told: rapid or not, from, to, line. Places of the tool tip.
pub fn motions(text: &str) -> Vec<(bool, Point, Point, usize)> {
    let program = interpret(text, morsemill::gcode::Dialect::Grbl).unwrap();
    let mut out = Vec::new();
    let mut cutting = false;
    for e in &program.events {
        if let Event::Motion(m) = e {
            assert!(m.arc.is_none(), "the tests know straight moves only");
            cutting |= m.kind == MotionKind::Feed;
            if cutting {
                out.push((m.kind == MotionKind::Rapid, m.from, m.to, m.line));
            }
        }
    }
    out
}
