//! Steps to a program that has been read back before it takes its place: what `post` and `translate` share.
//!
//! The steps are asked for twice, once to write and once to compare, and the program is read from the file it was written to: nothing grows
//! with its length.

use super::Failure;
use super::output::{WholeFile, to_stdout, write_json};
use crate::cldata::Step;
use crate::gcode::{Interpreter, Reading};
use crate::post::{Adapter, Options, Post, Refusal, Rewrite, Units, Writer};
use crate::units::Mm;
use crate::verify::{Deviation, Spelling, VerifyError, Witness, dialect_of, worst_state};
use serde::Serialize;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What both commands ask of the program to write.
#[derive(Clone, Debug, clap::Args)]
pub struct ProgramArgs {
    /// Where the program goes
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Units of the program, in place of the dialect's own
    #[arg(long, value_name = "mm|inch")]
    pub units: Option<ProgramUnits>,
    /// Name of the program, where the dialect has one
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Number of the program, where the dialect has one
    #[arg(long, value_name = "NUMBER")]
    pub number: Option<u32>,
    /// How far the controller may leave the path when it rounds corners, mm; where the dialect can say it
    #[arg(long, value_name = "MM", value_parser = above_zero)]
    pub path_tolerance: Option<f64>,
    /// Write arcs that the controller cannot take as lines that leave them by no more than this, mm; without it they are refused
    #[arg(long, value_name = "MM", value_parser = above_zero)]
    pub arcs_to_lines: Option<f64>,
    /// Write full circles as two or more arcs where the controller cannot take them whole; without it they are refused
    #[arg(long)]
    pub split_circles: bool,
    /// Write what was done as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Units of a program.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum ProgramUnits {
    /// G21.
    Mm,
    /// G20.
    Inch,
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err("must be a number above zero".into()),
    }
}

/// Steps with the lines they come from, or the message that ends them.
pub type Lines = Box<dyn Iterator<Item = Result<(usize, Step), String>>>;

/// Where steps come from, as often as they are asked for.
pub trait Steps {
    /// All of them, from the start.
    fn steps(&self) -> Result<Lines, Failure>;
}

/// What was done.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// What was read.
    pub source: String,
    /// What was written.
    pub program: String,
    /// Its dialect.
    pub post: String,
    /// Lines of the program.
    pub lines: usize,
    /// Bytes of the program.
    pub bytes: u64,
    /// What reading it back found.
    pub verified: Verified,
    /// Furthest that lines in place of arcs leave them, mm.
    pub rewritten_mm_max: f64,
    /// What was tolerated, taken for something, or left out.
    pub notes: Vec<String>,
}

/// What reading back found.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Verified {
    /// Moves compared.
    pub moves: usize,
    /// Moves that rounded to nothing.
    pub without_line: usize,
    /// Greatest distance of a written end point from the one meant, mm.
    pub position_mm_max: f64,
    /// Greatest difference of a feed, mm/min.
    pub feed_mm_per_min_max: f64,
}

impl From<Deviation> for Verified {
    fn from(d: Deviation) -> Self {
        Verified {
            moves: d.moves,
            without_line: d.without_line,
            position_mm_max: d.position.0,
            feed_mm_per_min_max: d.feed.0,
        }
    }
}

/// The options of a writer that the arguments ask for; `tolerance` is the path tolerance of the source, if it told one.
pub fn options(args: &ProgramArgs, tolerance: Option<Mm>) -> Options {
    Options {
        units: None,
        name: args.name.clone(),
        number: args.number,
        path_tolerance: args.path_tolerance.map(Mm).or(tolerance),
        rewrite: Rewrite {
            lines_within: args.arcs_to_lines.map(Mm),
            halves: args.split_circles,
            ..Rewrite::default()
        },
    }
}

/// The dialect to write in, with the units asked for.
pub fn load_post(name: &str, args: &ProgramArgs) -> Result<Post, Failure> {
    let mut post = super::sources::post(name).map_err(Failure::failed)?;
    match args.units {
        None => {}
        Some(ProgramUnits::Mm) => post.units = Units::Mm,
        Some(ProgramUnits::Inch) => post.units = Units::Inch,
    }
    Ok(post)
}

/// Writes the steps as a program, reads it back, and puts it in its place only when it says what was meant.
pub fn prove(
    source: &Path,
    steps: &dyn Steps,
    post: &Post,
    options: &Options,
    output: &Path,
) -> Result<Outcome, Failure> {
    let rejected = |line: usize, e: &dyn std::fmt::Display| {
        Failure::Rejected(format!("{}:{line}: {e}", source.display()))
    };
    let unread = |e: String| Failure::Rejected(format!("{}:{e}", source.display()));
    let mut whole = WholeFile::create(output)?;
    let unwritable = |e: &dyn std::fmt::Display| {
        Failure::Failed(format!("{}: cannot be written: {e}", output.display()))
    };
    let mut lines = 0;
    let rewritten;
    {
        let buffer = BufWriter::with_capacity(1 << 16, &mut whole);
        let mut writer = Writer::new(post, options.clone(), buffer).map_err(Failure::failed)?;
        for step in steps.steps()? {
            let (line, step) = step.map_err(unread)?;
            lines = writer.step(&step).map_err(|e| rejected(line, &e))?;
        }
        rewritten = writer.deviation().0;
        let mut buffer = writer
            .finish()
            .map_err(|e| Failure::Rejected(format!("{}: {e}", source.display())))?;
        buffer.flush().map_err(|e| unwritable(&e))?;
    }
    let file = File::open(whole.so_far()).map_err(|e| unwritable(&e))?;
    let bytes = file.metadata().map_err(|e| unwritable(&e))?.len();
    let dialect = dialect_of(post).map_err(Failure::failed)?;
    let state = worst_state(dialect, post);
    let said = Interpreter::from_state(
        BufReader::with_capacity(1 << 16, file),
        state,
        Reading::default(),
    )
    .map_err(|e| unwritable(&e))?;
    // What differs is our own mistake, and the program must not be run.
    let differs = |e: VerifyError| {
        Failure::Rejected(format!(
            "the program written for post {} does not say what {} means, so it was thrown away: {e}",
            post.name,
            source.display()
        ))
    };
    let mut witness = Witness::new(said, Spelling::of(post));
    let mut adapter = Adapter::new(post, options.rewrite);
    let tolerance = options.path_tolerance.or(post.path_tolerance);
    for step in steps.steps()? {
        let (_, step) = step.map_err(unread)?;
        adapter
            .step(&step, &mut |s: &Step| {
                witness.step(s).map_err(Trouble::Differs)?;
                if matches!(s, Step::Feed { .. }) {
                    witness.tolerance(tolerance).map_err(Trouble::Differs)?;
                }
                Ok(())
            })
            .map_err(|e| match e {
                Trouble::Differs(e) => differs(e),
                Trouble::Refused(e) => Failure::Rejected(e.to_string()),
            })?;
    }
    let deviation = witness.finish().map_err(differs)?;
    whole.finish()?;
    Ok(Outcome {
        source: source.display().to_string(),
        program: output.display().to_string(),
        post: post.name.clone(),
        lines,
        bytes,
        verified: deviation.into(),
        rewritten_mm_max: rewritten,
        notes: Vec::new(),
    })
}

/// What can go wrong when adapted steps are compared.
enum Trouble {
    Differs(VerifyError),
    Refused(Refusal),
}

impl From<Refusal> for Trouble {
    fn from(e: Refusal) -> Self {
        Trouble::Refused(e)
    }
}

/// Says what was done, and writes it where asked.
pub fn tell(outcome: &Outcome, json: Option<&Path>) -> Result<ExitCode, Failure> {
    if let Some(file) = json {
        write_json(file, outcome)?;
    }
    to_stdout(|w| {
        for note in &outcome.notes {
            writeln!(w, "note       {note}")?;
        }
        let v = &outcome.verified;
        writeln!(
            w,
            "read back  {} moves, {} too small for a line; furthest off {:.3} um; feeds within {:.3} mm/min; spindle, tools and order as meant",
            v.moves,
            v.without_line,
            v.position_mm_max * 1e3,
            v.feed_mm_per_min_max
        )?;
        if outcome.rewritten_mm_max > 0.0 {
            let um = outcome.rewritten_mm_max * 1e3;
            writeln!(w, "rewritten  arcs as lines, at most {um:.3} um off")?;
        }
        writeln!(
            w,
            "{}: {} lines, {} bytes ({})",
            outcome.program, outcome.lines, outcome.bytes, outcome.post
        )
    })
}
