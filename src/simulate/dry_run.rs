//! One call: text in, verdict out.

use super::report::{
    DryRun, Extents, Kind, MotionFigures, Problem, ProgramFigures, TimeFigures, Verdict,
};
use super::start::Read;
use super::{gouge, limits, material, start};
use crate::gcode::{Dialect, Event};
use crate::geom::{Box3, Vector};
use crate::kinematics::{Feed, Settings, Times, link_demand, program_time};
use crate::machine::Machine;
use crate::part::Mesh;
use crate::reach::DropCutter;
use crate::sweep::tiles::area;
use crate::sweep::{CuspMap, FinishOptions, FinishStats, Paths, ReachTiles, Segment, finish_tiles};

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

/// Reads a program's text as the machine will, cuts it, and judges. Without a part only syntax, limits, spindle and time are
/// judged, and the report says so. Never fails: a text that cannot be read is a report with its mistakes as problems. Same result
/// for any number of threads.
pub fn dry_run(
    text: &str,
    dialect: Dialect,
    machine: &Machine,
    part: Option<&PartContext>,
    options: &DryRunOptions,
) -> DryRun {
    let mut report = blank(ProgramFigures {
        bytes: text.len(),
        lines: crate::gcode::lines(text).count(),
        ..ProgramFigures::default()
    });
    match start::read(text, dialect) {
        Ok(program) => {
            let times = program_time(&program.at_zero.events, &Settings::from(machine));
            feeding(text, &times.per_line, machine, &mut report);
            run(&program, &times, machine, part, options, &mut report);
        }
        Err(errors) => {
            report.problems.extend(errors.iter().map(|e| Problem {
                kind: Kind::Syntax,
                line: Some(e.line),
                text: format!("column {}: {}", e.column, e.complaint),
            }));
            report.not_modelled.push(
                "nothing but the syntax was judged: the machine would stop at the first refused line".into(),
            );
        }
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
    program: &Read,
    times: &Times,
    machine: &Machine,
    part: Option<&PartContext>,
    options: &DryRunOptions,
    report: &mut DryRun,
) {
    let limits = limits::limits(&program.events, machine);
    report.extents = limits.extents;
    report.problems.extend(limits.problems);
    report.warnings.extend(limits.warnings);

    report.time_s = TimeFigures {
        total: times.total.0,
        cutting: times.cutting.0,
        air: times.air.0,
        dwell: times.dwell.0,
        idle: times.idle.0,
    };
    report.motion = MotionFigures::from(&times.motion);

    let radius = part.map_or(0.0, |p| p.drop.radius());
    let (moves, figures) = material::moves(&program.events, radius);
    report.program = ProgramFigures {
        lines: report.program.lines,
        bytes: report.program.bytes,
        ..figures
    };
    if program.events.is_empty() {
        report.problems.push(Problem {
            kind: Kind::Nothing,
            line: None,
            text: "nothing in this text makes the machine do anything: is it the right file?"
                .into(),
        });
    } else if moves.is_empty() {
        report.warnings.push(Problem {
            kind: Kind::Nothing,
            line: None,
            text: "nothing in this program moves the tool to a known place".into(),
        });
    }
    if let Some(part) = part {
        let up = Vector::new(0.0, 0.0, radius);
        report.motion = report
            .motion
            .judged(&times.motion, &times.sharp_turns, |t| {
                part.drop.own_turn(&(t.at + up), &t.before, &t.after)
            });
        judge(&moves, part, options, report);
    }
    say_what_is_missing(program, part, limits.machine_moves, report);
}

/// Share of the time a machine may wait for lines before it is worth a word: such a stand leaves a mark on the surface.
const STARVED: f64 = 0.01;
/// Lines per second that an 8-bit GRBL board reads, at least.
const SLOW_BOARD_LINES: f64 = 200.0;
/// Receive buffers up to this belong to such boards, bytes.
const SLOW_BOARD_RX: usize = 256;

/// Compares what the program needs of the link with what the link gives.
fn feeding(text: &str, seconds: &[f64], machine: &Machine, report: &mut DryRun) {
    if machine.baud == 0 {
        return;
    }
    let feed = Feed {
        // Eight bits, a start and a stop.
        bytes_per_s: f64::from(machine.baud) / 10.0,
        rx_bytes: machine.rx_buffer,
        blocks: machine.planner_blocks,
    };
    let demand = link_demand(
        crate::gcode::lines(text).map(|l| l.len() + 1),
        seconds,
        &feed,
    );
    let mut say = |text: String| {
        report.warnings.push(Problem {
            kind: Kind::Link,
            line: None,
            text,
        });
    };
    if demand.starved_share > STARVED {
        say(format!(
            "the link of {} baud starves the planner for {:.1} s ({:.1} % of the time): up to {:.0} bytes/s are needed and {:.0} come. \
             Ask for a larger scallop (its tolerances grow with it), a lower feed, or set a higher baud rate",
            machine.baud,
            demand.starved_s,
            100.0 * demand.starved_share,
            demand.bytes_per_s_needed,
            demand.bytes_per_s_link
        ));
    } else if demand.lines_per_s_p99 > SLOW_BOARD_LINES && machine.rx_buffer <= SLOW_BOARD_RX {
        say(format!(
            "up to {:.0} lines/s are needed, and 8-bit boards read 200 to 400: it may stutter. Ask for a larger scallop or a lower feed",
            demand.lines_per_s_max
        ));
    }
    report.link_demand = Some(demand);
}

/// Problems of one kind that are listed one by one.
const LISTED: usize = 20;

/// Cuts moves into the stock and looks at what is left.
pub(super) fn judge(
    moves: &[material::Move],
    part: &PartContext,
    options: &DryRunOptions,
    report: &mut DryRun,
) {
    let radius = part.drop.radius();
    let tiles = part.reachable;
    let which = tiles.touched(moves.iter().map(|m| &m.segment));
    let feed: Vec<Segment> = moves
        .iter()
        .filter(|m| !m.rapid)
        .map(|m| m.segment)
        .collect();
    let paths = Paths::new(&feed, 0.25 * radius, area(tiles.lattice()));
    drop(feed);
    let (judged, collisions) = finish_tiles(
        tiles,
        &paths,
        &FinishOptions::for_scallop(options.scallop_mm),
        |k, reach| {
            let stock = material::stock(part, reach, &options.stock);
            let which = which.get(k).map_or(&[][..], Vec::as_slice);
            let limit = options.collision_limit_mm;
            material::cut(moves, which, reach.lattice, radius, &stock, limit)
        },
    );
    drop(paths);
    let collisions = material::deepest_per_line(collisions.into_iter().flatten().collect());
    for c in collisions.iter().take(LISTED) {
        let p = c.encounter.place;
        report.problems.push(Problem {
            kind: Kind::Collision,
            line: Some(c.line),
            text: format!(
                "rapid move through {:.3} mm of standing stock at X{:.3} Y{:.3} Z{:.3}: retract higher before it, or feed",
                c.encounter.depth, p.x, p.y, p.z
            ),
        });
    }
    if collisions.len() > LISTED {
        report.problems.push(Problem {
            kind: Kind::Collision,
            line: None,
            text: format!("and {} more lines like these", collisions.len() - LISTED),
        });
    }

    let (map, mut stats): (CuspMap, FinishStats) = match judged {
        Ok(f) => (f.map, f.stats),
        Err(e) => {
            report.problems.push(Problem {
                kind: Kind::Nothing,
                line: None,
                text: e.to_string(),
            });
            return;
        }
    };
    let gouge = gouge::deepest(moves, part);
    let mut line = None;
    if let Some(g) = gouge
        && 1e3 * g.depth >= stats.gouge_um_max - 0.05
    {
        stats.gouge_um_max = 1e3 * g.depth;
        stats.gouge_at = Some([g.center.x, g.center.y, g.center.z - radius]);
        line = Some(g.line);
    }
    verdict(&stats, line, options, &mut report.problems);
    report.finish = Some(stats);
    report.map = Some(map);
}

fn verdict(
    s: &FinishStats,
    gouge_line: Option<usize>,
    options: &DryRunOptions,
    problems: &mut Vec<Problem>,
) {
    let h = 1e3 * options.scallop_mm;
    let place = |at: Option<[f64; 3]>| {
        at.map_or_else(String::new, |[x, y, z]| {
            format!(" at X{x:.3} Y{y:.3} Z{z:.3}")
        })
    };
    let mut add = |kind, line, text| problems.push(Problem { kind, line, text });
    if s.gouge_um_max > 1e3 * options.gouge_limit_mm {
        add(
            Kind::Gouge,
            gouge_line,
            format!(
                "the ball cuts {:.1} um into the part{} (limit {:.1} um)",
                s.gouge_um_max,
                place(s.gouge_at),
                1e3 * options.gouge_limit_mm
            ),
        );
    }
    let limit = h * (1.0 + 1e-6);
    if s.scallop_um.p99 > limit {
        add(
            Kind::Scallop,
            None,
            format!(
                "99 % of the area has cusps up to {:.2} um, asked for were {h:.2} um",
                s.scallop_um.p99
            ),
        );
    }
    if s.over_scallop_area_percent > options.over_area_limit_percent {
        add(
            Kind::Scallop,
            None,
            format!(
                "{:.2} % of the area lies above the cusp height of {h:.2} um (limit {} %)",
                s.over_scallop_area_percent, options.over_area_limit_percent
            ),
        );
    }
    if s.scallop_um.max > limit * options.max_cusp_factor {
        add(
            Kind::Scallop,
            None,
            format!(
                "a cusp of {:.1} um{} (limit {:.1} um)",
                s.scallop_um.max,
                place(s.max_at),
                h * options.max_cusp_factor
            ),
        );
    }
    if s.uncut_area_mm2 > options.uncut_limit_mm2 {
        add(
            Kind::Uncut,
            None,
            format!(
                "{:.2} mm2 of ground that this ball reaches are not cut, for one{}",
                s.uncut_area_mm2,
                place(s.uncut_at)
            ),
        );
    }
}

fn say_what_is_missing(
    program: &Read,
    part: Option<&PartContext>,
    machine_moves: bool,
    report: &mut DryRun,
) {
    let mut say = |text: &str| report.not_modelled.push(text.to_string());
    if part.is_none() {
        say(
            "no part given: gouges, cusps, uncut ground and rapids into stock were not judged (add --part, --tool and --scallop)",
        );
    } else {
        say(
            "the way from where the tool stands at the start to the first commanded place (and after moves in machine coordinates or probing)",
        );
        say(
            "stock beside the part, clamps, the holder, deflection and runout; the shank counts as thick as the ball",
        );
    }
    say("where work zero lies on the table: travels are compared with the program's length only");
    say("feed and spindle overrides, and a controller kept waiting for lines");
    if machine_moves {
        say(
            "moves in machine coordinates (G53, G28, G30): only their ends are compared with the travels",
        );
    }
    for (axis, assumed) in ["X", "Y", "Z"].iter().zip(program.assumed) {
        if assumed {
            say(&format!(
                "{axis} is not told before the first cut: it is taken to start at 0"
            ));
        }
    }
    let s = &program.at_zero.end_state;
    if s.work_offset != 0 || s.offset().norm() != 0.0 {
        say(
            "changes of the work offset (G55 to G59, G10, G92, G43.1): all places are taken as if in one system",
        );
    }
    let any = |f: fn(&Event) -> bool| program.events.iter().any(f);
    if any(|e| matches!(e, Event::ToolChange { .. })) {
        say("tool changes: the same ball is assumed throughout, and M6 takes no time");
    }
    if any(|e| matches!(e, Event::Pause { .. })) {
        say("operator stops (M0, M1): they take no time here");
    }
    if any(|e| matches!(e, Event::Probe { .. })) {
        say("probing: where contact is made is not in the text");
    }
}
