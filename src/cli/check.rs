//! `morsemill check PROGRAM.nc`: the dry run of any program, ours or not. Reads the program's text and, for judging shapes, the
//! part; prints a table; exit 0 pass, 1 fail, 2 could not be judged.

use super::Failure;
use super::args::{PartArgs, ToolArgs};
use super::output::{to_stdout, write_json};
use super::progress::Progress;
use crate::gcode::Dialect;
use crate::geom::Box3;
use crate::machine::Machine;
use crate::reach::DropCutter;

use crate::simulate::{DryRun, DryRunOptions, PartContext, Stock, dry_run, judging_step};
use crate::sweep::reachable;
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
    /// How the program is read: grbl or linuxcnc; by default as the machine's controller does
    #[arg(long, alias = "post", value_parser = parse_dialect, value_name = "NAME")]
    pub dialect: Option<Dialect>,
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
    /// What stands before the first move: allowance:MM above the finished surface, block (up to the part's top) or block:MM above it
    #[arg(long, default_value = "allowance:0.5", value_parser = super::args::parse::<StockArg>, value_name = "STOCK")]
    pub stock: StockArg,
    /// Write the whole result as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write report.json and the heat map cusp.png into this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// The stock as people name it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StockArg {
    /// This much on the finished surface, mm.
    Allowance(f64),
    /// A block this much higher than the part, mm.
    Block(f64),
}

impl std::str::FromStr for StockArg {
    type Err = String;

    /// Reads `allowance:0.5`, `block` and `block:2`.
    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || {
            format!(
                "stock \"{text}\" is not understood: write allowance:MM, block or block:MM, e.g. allowance:0.5"
            )
        };
        let (kind, size) = match text.trim().split_once(':') {
            Some((kind, size)) => (kind, size.trim().parse::<f64>().map_err(|_| bad())?),
            None => (text.trim(), 0.0),
        };
        if !(size.is_finite() && (0.0..=1000.0).contains(&size)) {
            return Err(format!("stock \"{text}\": the size must be 0 to 1000 mm"));
        }
        match kind.to_ascii_lowercase().as_str() {
            "allowance" if text.contains(':') => Ok(StockArg::Allowance(size)),
            "block" => Ok(StockArg::Block(size)),
            _ => Err(bad()),
        }
    }
}

impl StockArg {
    /// Over a part with these bounds.
    pub fn over(self, part: &Box3) -> Stock {
        match self {
            StockArg::Allowance(mm) => Stock::Allowance(mm),
            StockArg::Block(above) => Stock::Block {
                top_z: part.max.z + above,
            },
        }
    }
}

fn parse_dialect(text: &str) -> Result<Dialect, String> {
    dialect_named(text)
        .ok_or_else(|| format!("dialect \"{text}\" is not known: write grbl or linuxcnc"))
}

fn dialect_named(name: &str) -> Option<Dialect> {
    match name.to_ascii_lowercase().as_str() {
        "grbl" | "grblhal" | "fluidnc" => Some(Dialect::Grbl),
        "linuxcnc" => Some(Dialect::LinuxCnc),
        _ => None,
    }
}

/// How this machine reads programs.
pub fn dialect_of(machine: &Machine) -> Dialect {
    dialect_named(&machine.controller).unwrap_or(Dialect::Grbl)
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
    let machine = Machine::load(&args.machine).map_err(Failure::failed)?;
    let dialect = args.dialect.unwrap_or_else(|| dialect_of(&machine));
    let text = read_program(&args.program)?;
    let mut progress = Progress::new();
    let radius = args.tool.tool.radius;
    let mut figures = None;
    let result = match &args.part {
        None => {
            progress.stage("check", "reading and timing the program");
            // Without a part the stock has nothing to stand on.
            let options = DryRunOptions::new(args.tool.scallop, Stock::Allowance(0.0));
            dry_run(&text, dialect, &machine, None, &options)
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
            let reach = reachable(&drop, step);
            progress.stage("check", "cutting the program");
            let part = PartContext {
                mesh,
                drop: &drop,
                reachable: &reach,
            };
            let options = DryRunOptions::new(args.tool.scallop, args.stock.over(&bounds));
            figures = Some(PartFigures {
                file: path.display().to_string(),
                triangles: loaded.mesh.triangles.len(),
                size_mm: bounds.size().into(),
                tool: args.tool.tool.to_string(),
                scallop_mm: args.tool.scallop,
                cell_mm: reach.lattice.step,
            });
            dry_run(&text, dialect, &machine, Some(&part), &options)
        }
    };
    progress.finish();
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

fn read_program(path: &Path) -> Result<String, Failure> {
    let fail = |e: &dyn std::fmt::Display| Failure::Failed(format!("{}: {e}", path.display()));
    if path.is_dir() {
        return Err(fail(&"this is a directory: name the program inside it"));
    }
    let bytes = std::fs::read(path).map_err(|e| fail(&format!("cannot be read: {e}")))?;
    if bytes.is_empty() {
        return Err(fail(&"the file is empty: there is no program to check"));
    }
    // Comments may hold bytes of any code page; a letter that is none shows up as a refused word on its line.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn write_report(dir: &Path, report: &Report) -> Result<(), Failure> {
    std::fs::create_dir_all(dir)
        .map_err(|e| Failure::Failed(format!("{}: cannot be made: {e}", dir.display())))?;
    write_json(&dir.join("report.json"), report)?;
    Ok(())
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
            "surface   gouge {:.2} um, uncut {:.3} mm2, rest {:.2} mm2 of {:.1} mm2 judged",
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

fn clock(seconds: f64) -> String {
    let s = seconds.max(0.0).round() as u64;
    if s >= 3600 {
        format!("{} h {:02} min {:02} s", s / 3600, s / 60 % 60, s % 60)
    } else {
        format!("{} min {:02} s", s / 60, s % 60)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn stock_is_read_or_refused_in_words() {
        assert_eq!("allowance:0.5".parse(), Ok(StockArg::Allowance(0.5)));
        assert_eq!("block".parse(), Ok(StockArg::Block(0.0)));
        assert_eq!("Block:2".parse(), Ok(StockArg::Block(2.0)));
        for bad in [
            "",
            "allowance",
            "allowance:x",
            "slab:3",
            "block:-1",
            "block:NaN",
            "allowance:1e9",
        ] {
            let e = bad.parse::<StockArg>().unwrap_err();
            assert!(e.starts_with("stock \""), "{e}");
        }
    }

    #[test]
    fn clocks_read_well() {
        assert_eq!(clock(59.6), "1 min 00 s");
        assert_eq!(clock(3725.0), "1 h 02 min 05 s");
    }
}
