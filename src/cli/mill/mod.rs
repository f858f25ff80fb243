//! `morsemill mill`: from a part to a proven program.

mod args;
mod cl;
mod report;
mod settings;

pub use args::{MillArgs, StockArg, StrategyName};

use super::output::{say, to_stdout, write_json, write_whole};
use super::progress::Progress;
use super::{Failure, pictures, rest_picture, show};
use crate::machine::Machine;
use crate::post::write;
use crate::reach::DropCutter;
use crate::simulate::{DryRun, DryRunOptions, Kind, PartContext, Problem, Verdict, dry_run};
use crate::sweep::{RestOptions, rest};
use crate::toolpath::plan::{self, Plan};
use crate::toolpath::{ArcOptions, Figures, Stage, Toolpath, arcs, proof};
use crate::units::MmPerMin;
use crate::verify::{dialect_of, verify};
use report::Done;
use settings::{fits, job, link_options, settle};
use std::collections::BTreeMap;
use std::process::ExitCode;

/// Runs `mill`.
pub fn run(a: &MillArgs) -> Result<ExitCode, Failure> {
    let s = settle(a)?;
    if a.output.is_dir() {
        return Err(Failure::Failed(format!(
            "{}: is a folder, not a file to write",
            a.output.display()
        )));
    }
    cl::check_name(a)?;
    let radius = a.tool.tool.radius;
    let mut progress = Progress::new();
    if a.arcs && !s.post.arcs.has(crate::geom::Plane::Xy) {
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
    let job = job(a, &s, &placement, &ground, &planned);
    if a.arcs && s.post.arcs.has(crate::geom::Plane::Xy) {
        let how = ArcOptions::new(planned.fitting, s.machine.arc_tolerance.0);
        let bent = arcs(&planned.toolpath, &ground.cutter, &how);
        match write(&bent, &job, &s.post) {
            // Few decimals, of lengths or of angles, and one of the arcs cannot be said: then none is, and the path is as good.
            Err(e) if e.refusal.is_of_arcs() => {
                say(&format!("morsemill: straight lines instead of arcs: {e}"));
            }
            _ => planned.toolpath = bent,
        }
    }
    let fit = proof(
        &ground.cutter,
        &planned.toolpath,
        s.machine.arc_tolerance.0,
        &planned.fitting,
    );

    progress.stage("post", "writing the program");
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
            crate::kinematics::line_times(&p.events, &crate::kinematics::Settings::from(&s.machine))
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

    let json = report::report(&Done {
        args: a,
        settings: &s,
        loaded: &loaded,
        placement: &placement,
        ground: &ground,
        planned: &planned,
        verdict: &verdict,
        deviation: &deviation,
        fit: &fit,
        features: &features,
        left: &left,
        planned_bytes,
        seconds,
    });
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
        // Both or neither: a CL file that cannot be said stops the program too.
        let cl = cl::text(a, &planned.toolpath, &job)?;
        write_whole(&a.output, posted.text.as_bytes())?;
        if let Some((file, bytes)) = &cl {
            write_whole(file, bytes)?;
        }
    }
    to_stdout(|w| {
        show::part(w, &a.part, &loaded, &placement)?;
        show::critical(w, &ground.critical)?;
        show::feature_table(w, &features)?;
        show::strategy_table(w, &planned)?;
        show::verdict(w, &verdict, a.tool.scallop)?;
        let um = deviation.position.0 * 1e3;
        writeln!(
            w,
            "read back  {} moves, furthest off {um:.3} um; feeds, spindle, tool and order as meant",
            deviation.moves
        )?;
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
