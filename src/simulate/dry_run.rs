//! One call: text in, verdict out.

use super::judge::judge;
use super::material;
use super::missing::Missing;
use super::moves::{MOST_HELD, Moves};
use super::program::{Open, in_memory};
use super::report::{
    DryRun, Extents, Kind, MotionFigures, Problem, ProgramFigures, TimeFigures, Verdict,
};
use super::shape::{Shape, Told, shape};
use super::timing::{Timing, feeding, timing};
use crate::gcode::Dialect;
use crate::geom::{Box3, Vector};
use crate::machine::Machine;
use crate::part::Mesh;
use crate::reach::DropCutter;
use crate::sweep::ReachTiles;

/// The part as it lies in work coordinates, made ready for one ball.
#[derive(Clone, Copy, Debug)]
pub struct PartContext<'a> {
    /// The triangles.
    pub mesh: &'a Mesh,
    /// The ball over them; its radius is the tool's.
    pub drop: &'a DropCutter,
    /// What it can reach; its lattice is where cusps are judged (see [`judging_step`]).
    pub reachable: &'a ReachTiles<'a>,
}

/// What stands on the table before the first move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stock {
    /// The reachable surface and this much more along its normal, mm: what a roughing job left. Nothing beside the part.
    Allowance(f64),
    /// A block over the part's bounding rectangle.
    Block {
        /// Its top in work coordinates, mm.
        top_z: f64,
    },
}

/// What is demanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryRunOptions {
    /// Cusp height asked for, mm.
    pub scallop_mm: f64,
    /// What is there to cut.
    pub stock: Stock,
    /// Deepest gouge let pass, mm.
    pub gouge_limit_mm: f64,
    /// Share of the area let pass above the cusp height, %.
    pub over_area_limit_percent: f64,
    /// Highest cusp let pass, in cusp heights.
    pub max_cusp_factor: f64,
    /// Uncut area let pass, mm²: below it lie rounding and the lattice.
    pub uncut_limit_mm2: f64,
    /// How deep a rapid may touch standing stock, mm.
    pub collision_limit_mm: f64,
}

impl DryRunOptions {
    /// The bar this project holds: p99 within h, 0.5 % of the area above, none above 1.5 h, gouge 3 um, nothing uncut.
    pub fn new(scallop_mm: f64, stock: Stock) -> DryRunOptions {
        DryRunOptions {
            scallop_mm,
            stock,
            gouge_limit_mm: 0.003,
            over_area_limit_percent: 0.5,
            max_cusp_factor: 1.5,
            uncut_limit_mm2: 0.05,
            collision_limit_mm: 0.01,
        }
    }
}

/// Cells a part is judged on at most: beyond it nobody would wait.
const CELLS: f64 = 1e9;

/// A lattice step fine enough to see the cusps of this height that this ball leaves: a fourteenth of the stepover on the flat. mm.
pub fn judging_step(bounds: &Box3, radius: f64, scallop: f64) -> f64 {
    let h = scallop.clamp(0.0, radius);
    let stepover = 2.0 * (2.0 * h * radius - h * h).max(0.0).sqrt();
    let size = bounds.size();
    let area = (size.x + 2.0 * radius) * (size.y + 2.0 * radius);
    (stepover / 14.0).max((area / CELLS).sqrt()).max(1e-6)
}

/// [`dry_run_of`] a program in memory.
pub fn dry_run(
    text: &str,
    dialect: Dialect,
    machine: &Machine,
    part: Option<&PartContext>,
    options: &DryRunOptions,
) -> DryRun {
    dry_run_of(&in_memory(text), dialect, machine, part, options)
}

/// Reads a program's text as the machine will, cuts it, and judges. Without a part only syntax, limits, spindle and time are
/// judged, and the report says so. Never fails: a text that cannot be read is a report with its mistakes as problems. Same result
/// for any number of threads. The program is opened a few times and never held: without a part memory does not grow with its length.
pub fn dry_run_of(
    program: &Open,
    dialect: Dialect,
    machine: &Machine,
    part: Option<&PartContext>,
    options: &DryRunOptions,
) -> DryRun {
    let radius = part.map_or(0.0, |p| p.drop.radius());
    let mut moves = Vec::new();
    // Of a program with too many for the memory none are kept: they are read again, as few at once as will do.
    let keep = &mut |told: Told| match told {
        Told::Move(m) if part.is_some() && moves.len() <= MOST_HELD => moves.push(m),
        Told::Move(_) => {}
        Told::Afresh => moves.clear(),
    };
    // Each pass has an interpreter of its own: two threads read at the same time.
    let (timing, shape) = rayon::join(
        || timing(program, dialect, machine),
        || shape(program, dialect, machine, radius, keep),
    );
    let mut report = blank(ProgramFigures {
        bytes: usize::try_from(timing.bytes).unwrap_or(usize::MAX),
        lines: timing.lines,
        ..ProgramFigures::default()
    });
    if timing.errors.is_empty() {
        if let Some(demand) = timing.demand {
            feeding(demand, machine, &mut report);
        }
        let again = |hear: &mut dyn FnMut(&material::Move)| shape.again(program, radius, hear);
        let moves = match moves.len() <= MOST_HELD {
            true => Moves::Held(&moves),
            false => {
                drop(std::mem::take(&mut moves));
                Moves::Read(&again)
            }
        };
        run(&timing, &shape, &moves, part, options, &mut report);
    } else {
        report
            .problems
            .extend(timing.errors.iter().map(|e| Problem {
                kind: Kind::Syntax,
                line: Some(e.line),
                text: format!("column {}: {}", e.column, e.complaint),
            }));
        report.not_modelled.push(
            "nothing but the syntax was judged: the machine would stop at the first refused line"
                .into(),
        );
    }
    if !report.problems.is_empty() {
        report.verdict = Verdict::Fail;
    }
    report
}

/// A report in which nothing is judged yet.
pub(super) fn blank(program: ProgramFigures) -> DryRun {
    DryRun {
        program,
        time_s: TimeFigures::default(),
        motion: MotionFigures::default(),
        link_demand: None,
        extents: Extents::default(),
        finish: None,
        verdict: Verdict::Pass,
        problems: Vec::new(),
        warnings: Vec::new(),
        not_modelled: Vec::new(),
        map: None,
    }
}

fn run(
    timing: &Timing,
    shape: &Shape,
    moves: &Moves,
    part: Option<&PartContext>,
    options: &DryRunOptions,
    report: &mut DryRun,
) {
    let limits = &shape.limits;
    report.extents = limits.extents;
    report.problems.extend_from_slice(&limits.problems);
    report.warnings.extend_from_slice(&limits.warnings);

    let times = &timing.times;
    report.time_s = TimeFigures {
        total: times.total.0,
        cutting: times.cutting.0,
        air: times.air.0,
        dwell: times.dwell.0,
        idle: times.idle.0,
    };
    report.motion = MotionFigures::from(&times.motion);
    report.program = ProgramFigures {
        lines: report.program.lines,
        bytes: report.program.bytes,
        ..shape.figures
    };
    if !shape.seen.anything {
        report.problems.push(Problem {
            kind: Kind::Nothing,
            line: None,
            text: "nothing in this text makes the machine do anything: is it the right file?"
                .into(),
        });
    } else if shape.moves == 0 {
        report.warnings.push(Problem {
            kind: Kind::Nothing,
            line: None,
            text: "nothing in this program moves the tool to a known place".into(),
        });
    }
    if let Some(part) = part {
        let up = Vector::new(0.0, 0.0, part.drop.radius());
        report.motion = report
            .motion
            .judged(&times.motion, &times.sharp_turns, |t| {
                part.drop.own_turn(&(t.at + up), &t.before, &t.after)
            });
        judge(moves, part, options, report);
    }
    let missing = Missing {
        part: part.is_some(),
        machine_moves: limits.machine_moves,
        assumed: shape.start.assumed,
        seen: shape.seen,
        end: &timing.end,
    };
    missing.say(&mut report.not_modelled);
}
