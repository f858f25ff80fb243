//! `morsemill check PROGRAM.nc`: the dry run of any program, ours or not. Reads the program's text and, for judging shapes, the
//! part; prints a table; exit 0 pass, 1 fail, 2 could not be judged.

use super::Failure;
use super::args::{PartArgs, ToolArgs, parse};
use super::mill::StockArg;
use super::output::{to_stdout, write_json, write_whole};
use super::program_file::ProgramFile;
use super::progress::Progress;
use super::show::{clock, motion};
use crate::picture::{Gouge, HeatMap, Raster, heat_map};
use crate::reach::DropCutter;
use crate::simulate::{DryRun, DryRunOptions, PartContext, Stock, dry_run_of, judging_step};
use crate::sweep::{Lattice, ReachTiles};
use crate::verify::dialect_of;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `check`.
#[derive(Clone, Debug, clap::Args)]
pub struct CheckArgs {
    /// The program
    pub program: PathBuf,
    /// Machine: a built-in name (see `morsemill machines`) or a file
    #[arg(long, value_name = "NAME|FILE")]
    pub machine: String,
    /// Settings of its firmware in place of the machine's figures: `$n=value` lines, or what a controller answers to $$
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Dialect the program is written in: a built-in name (see `morsemill posts`) or a file; by default the machine's own
    #[arg(long, alias = "dialect", value_name = "NAME|FILE")]
    pub post: Option<String>,
    /// The part (STL or OBJ): with it cusps, gouges, uncut ground and rapids into stock are judged
    #[arg(long, value_name = "FILE")]
    pub part: Option<PathBuf>,
    #[allow(
        missing_docs,
        reason = "a doc comment here would become the command's help"
    )]
    #[command(flatten)]
    pub placement: PartArgs,
    #[allow(
        missing_docs,
        reason = "a doc comment here would become the command's help"
    )]
    #[command(flatten)]
    pub tool: ToolArgs,
    /// What stands before the first move: allowance:MM over the finished surface, or block (up to the part's top)
    #[arg(long, default_value = "allowance:0.5", value_parser = parse::<StockArg>, value_name = "STOCK")]
    pub stock: StockArg,
    /// Write the whole result as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write report.json and the heat map cusp.png into this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// The result with what it was measured on.
#[derive(Serialize)]
struct Report<'a> {
    file: String,
    machine: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<PartFigures>,
    #[serde(flatten)]
    run: &'a DryRun,
    seconds: std::collections::BTreeMap<&'static str, f64>,
}

#[derive(Serialize)]
struct PartFigures {
    file: String,
    triangles: usize,
    size_mm: [f64; 3],
    tool: String,
    scallop_mm: f64,
    /// Distance of the cells the cusps were judged at.
    cell_mm: f64,
}

/// Judges a program. Exit 0: nothing speaks against it; 1: problems; errors are for what could not be judged.
pub fn run(args: &CheckArgs) -> Result<ExitCode, Failure> {
    args.tool.check()?;
    let mut machine = super::sources::machine(&args.machine).map_err(Failure::failed)?;
    super::controller::apply_settings(args.settings.as_deref(), &mut machine)?;
    let post = super::sources::post(args.post.as_deref().unwrap_or(&machine.post))
        .map_err(Failure::failed)?;
    let dialect = dialect_of(&post).map_err(Failure::failed)?;
    let program = ProgramFile::open(&args.program).map_err(Failure::Failed)?;
    let text = || Ok(program.read());
    let mut progress = Progress::new();
    let radius = args.tool.tool.radius;
    let mut figures = None;
    let result = match &args.part {
        None => {
            progress.stage("check", "reading and timing the program");
            // Without a part the stock has nothing to stand on.
            let options = DryRunOptions::new(args.tool.scallop, Stock::Allowance(0.0));
            dry_run_of(&text, dialect, &machine, None, &options)
        }
        Some(path) => {
            progress.stage("import", "reading the part");
            let (loaded, placement) = args.placement.load(path)?;
            args.tool.check_against(&placement)?;
            let mesh = &placement.mesh;
            let bounds = mesh.bounds();
            progress.stage("reach", "what the ball can reach");
            let drop = DropCutter::new(mesh, radius);
            let step = judging_step(&bounds, radius, args.tool.scallop);
            let reach = ReachTiles::new(&drop, step, 1);
            progress.stage("check", "cutting the program");
            let part = PartContext {
                mesh,
                drop: &drop,
                reachable: &reach,
            };
            let options = DryRunOptions::new(args.tool.scallop, args.stock.stock(bounds.max.z));
            figures = Some(PartFigures {
                file: path.display().to_string(),
                triangles: loaded.mesh.triangles.len(),
                size_mm: bounds.size().into(),
                tool: args.tool.tool.to_string(),
                scallop_mm: args.tool.scallop,
                cell_mm: reach.lattice().step,
            });
            dry_run_of(&text, dialect, &machine, Some(&part), &options)
        }
    };
    progress.finish();
    program.unchanged().map_err(Failure::Failed)?;
    let report = Report {
        file: args.program.display().to_string(),
        machine: &machine.name,
        part: figures,
        run: &result,
        seconds: progress.seconds.iter().copied().collect(),
    };
    if let Some(path) = &args.json {
        write_json(path, &report)?;
    }
    if let Some(dir) = &args.report {
        write_report(dir, &report)?;
    }
    to_stdout(|out| print(out, &report, args))?;
    Ok(if result.passed() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn write_report(dir: &Path, report: &Report) -> Result<(), Failure> {
    std::fs::create_dir_all(dir)
        .map_err(|e| Failure::Failed(format!("{}: cannot be made: {e}", dir.display())))?;
    write_json(&dir.join("report.json"), report)?;
    let (Some(map), Some(f), Some(part)) = (&report.run.map, &report.run.finish, &report.part)
    else {
        return Ok(());
    };
    let um = |v: &[f32]| raster(&map.lattice, v.iter().map(|c| c * 1e3).collect());
    let s = &f.scallop_um;
    let png = heat_map(&HeatMap {
        title: &format!("{}: cusps after the dry run", report.file),
        subtitle: &format!(
            "asked for {} um; verdict: {}",
            1e3 * part.scallop_mm,
            report.run.verdict
        ),
        field: &um(&map.cusp_mm),
        quantity: "cusp height",
        unit: "um",
        limit: 1e3 * part.scallop_mm,
        gouge: Some(Gouge {
            depth: &um(&map.gouge_mm),
            limit: 3.0,
        }),
        heights: Some(&raster(&map.lattice, map.part_mm.clone())),
        facts: &[
            format!("p50   {:.1} um", s.p50),
            format!("p99   {:.1} um", s.p99),
            format!("max   {:.1} um", s.max),
            format!("gouge {:.1} um", f.gouge_um_max),
            format!("uncut {:.2} mm2", f.uncut_area_mm2),
        ],
        width_px: 1500,
    })
    .map_err(Failure::failed)?;
    write_whole(&dir.join("cusp.png"), &png)
}

fn raster(lattice: &Lattice, values: Vec<f32>) -> Raster<f32> {
    Raster {
        origin: lattice.origin,
        step: lattice.step,
        nx: lattice.nx,
        ny: lattice.ny,
        values,
    }
}

fn print(out: &mut dyn Write, report: &Report, args: &CheckArgs) -> std::io::Result<()> {
    let r = report.run;
    let p = &r.program;
    writeln!(
        out,
        "program   {} ({} lines, {} bytes)",
        report.file, p.lines, p.bytes
    )?;
    writeln!(out, "machine   {}", report.machine)?;
    if let Some(part) = &report.part {
        let [x, y, z] = part.size_mm;
        writeln!(
            out,
            "part      {} ({} triangles, {x:.2} x {y:.2} x {z:.2} mm), {}, cusp {} um",
            part.file,
            part.triangles,
            part.tool,
            1e3 * part.scallop_mm
        )?;
    }
    writeln!(
        out,
        "way       {:.1} mm at feed, {:.1} mm rapid, {} retracts",
        p.cut_mm, p.rapid_mm, p.retracts
    )?;
    let t = &r.time_s;
    writeln!(
        out,
        "time      {} ({:.1} s cutting, {:.1} s in the air)",
        clock(t.total),
        t.cutting,
        t.air
    )?;
    writeln!(out, "motion    {}", motion(&r.motion))?;
    super::show::link_line(out, "link     ", r)?;
    if let (Some(a), Some(b)) = (r.extents.min, r.extents.max) {
        writeln!(
            out,
            "extents   X {:.3} to {:.3}, Y {:.3} to {:.3}, Z {:.3} to {:.3} mm (tool tip)",
            a[0], b[0], a[1], b[1], a[2], b[2]
        )?;
    }
    if let Some(f) = &r.finish {
        let s = &f.scallop_um;
        writeln!(
            out,
            "cusp      p50 {:.2}  p95 {:.2}  p99 {:.2}  p99.9 {:.2}  max {:.2} um; {:.3} % of the area above {} um",
            s.p50,
            s.p95,
            s.p99,
            s.p999,
            s.max,
            f.over_scallop_area_percent,
            1e3 * args.tool.scallop
        )?;
        writeln!(
            out,
            "surface   gouge {:.2} um, uncut {:.3} mm2, rest {:.2} mm2 in plan; {:.1} mm2 judged",
            f.gouge_um_max, f.uncut_area_mm2, f.rest_area_mm2, f.judged_area_mm2
        )?;
    }
    for w in &r.warnings {
        writeln!(out, "warning   {w}")?;
    }
    for text in &r.not_modelled {
        writeln!(out, "not judged: {text}")?;
    }
    for p in &r.problems {
        writeln!(out, "problem   {p}")?;
    }
    writeln!(out, "verdict   {}", r.verdict)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        check: CheckArgs,
    }

    fn check(args: &[&str]) -> Result<bool, Failure> {
        let words = [&["check"], args].concat();
        run(&Cli::try_parse_from(words).unwrap().check).map(|code| code == ExitCode::SUCCESS)
    }

    const PLATE: &str = "solid p
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 12 0 0\nvertex 12 9 0\nendloop\nendfacet
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 12 9 0\nvertex 0 9 0\nendloop\nendfacet
endsolid p\n";

    #[test]
    fn codes_and_files() {
        let dir = tempfile::tempdir().unwrap();
        let at = |n: &str| dir.path().join(n).display().to_string();
        std::fs::write(at("p.stl"), PLATE).unwrap();
        let mut text = String::from("G21 G90\nM3 S12000\nG0 Z20\nG0 X-1 Y0\nG0 Z2\nG1 Z0 F500\n");
        for k in 0..=15 {
            let y = 0.6 * f64::from(k);
            let (a, b) = if k % 2 == 0 { (-1, 13) } else { (13, -1) };
            text += &format!("G1 X{a} Y{y:.3} F1500\nX{b}\n");
        }
        std::fs::write(at("good.nc"), text.clone() + "G0 Z20\nM5\nM30\n").unwrap();
        std::fs::write(at("bad.nc"), text + "G1 X6 Z-0.1\nG0 Z20\nM5\nM30\n").unwrap();
        let with_part = |program: &str, origin: &str, more: &[&str]| {
            let (program, part) = (at(program), at("p.stl"));
            let mut words = vec![
                program.as_str(),
                "--machine",
                "longmill-30x30",
                "--part",
                &part,
            ];
            words.extend(["--origin", origin, "--up", "+z"]);
            words.extend(more);
            check(&words)
        };
        let (json, report) = (at("r.json"), at("report"));
        assert!(with_part("good.nc", "part", &["--json", &json, "--report", &report]).unwrap());
        let v: serde_json::Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        assert_eq!(v["verdict"], "pass");
        assert_eq!(v["part"]["triangles"], 2);
        assert_eq!(v["program"]["retracts"], 1);
        assert!(
            std::fs::read(dir.path().join("report/cusp.png"))
                .unwrap()
                .starts_with(b"\x89PNG")
        );
        assert!(dir.path().join("report/report.json").exists());
        // Gouged, but its limits are kept.
        assert!(!with_part("bad.nc", "part", &[]).unwrap());
        assert!(check(&[&at("bad.nc"), "--machine", "longmill-30x30"]).unwrap());
        // Another zero: the same program misses the part.
        assert!(!with_part("good.nc", "top-center", &[]).unwrap());
    }

    #[test]
    fn what_cannot_be_carried_out_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let empty = dir.path().join("e.nc").display().to_string();
        std::fs::write(&empty, "").unwrap();
        let folder = dir.path().display().to_string();
        let failed = |args: &[&str]| match check(args) {
            Err(Failure::Failed(text)) => text,
            other => format!("{other:?}"),
        };
        assert!(
            failed(&[&empty, "--machine", "longmill-30x30"])
                .ends_with("the file is empty: there is no program in it")
        );
        std::fs::write(&empty, b"\xff\xfeG\0").unwrap();
        assert!(
            failed(&[&empty, "--machine", "longmill-30x30"])
                .ends_with("this is text in UTF-16: save it as plain ASCII or UTF-8")
        );
        assert!(failed(&[&folder, "--machine", "longmill-30x30"]).contains("this is a directory"));
        assert!(
            failed(&["none.nc", "--machine", "longmill-30x30"])
                .starts_with("none.nc: cannot be read")
        );
        assert!(failed(&[&empty, "--machine", "no-such-mill"]).contains("no-such-mill"));
    }
}
