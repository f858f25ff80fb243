//! `morsemill translate IN.nc --from NAME --to NAME -o OUT.nc`: a program of one dialect in another, proven by reading it back.

use super::Failure;
use super::proven::{Lines, ProgramArgs, Steps, load_post, options, prove, tell};
use crate::gcode::{Dialect, Interpreter, Reading};
use crate::translate::{self, unknown_state};
use crate::units::Mm;
use crate::verify::dialect_of;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `translate`.
#[derive(Clone, Debug, clap::Args)]
pub struct TranslateArgs {
    /// The program to read
    pub program: PathBuf,
    /// Dialect it is written in: a name from `morsemill posts`, a post file, or the name of a reader
    #[arg(long, value_name = "NAME|FILE")]
    pub from: String,
    /// Dialect to write: a name from `morsemill posts`, or a file
    #[arg(long, value_name = "NAME|FILE")]
    pub to: String,
    #[allow(
        missing_docs,
        reason = "a doc comment here would become the command's help"
    )]
    #[command(flatten)]
    pub out: ProgramArgs,
}

/// A program on disk, read anew each time.
struct Program<'a> {
    path: &'a Path,
    dialect: Dialect,
}

impl Program<'_> {
    fn read(&self) -> Result<translate::Steps<BufReader<File>>, Failure> {
        let fail = |e: std::io::Error| Failure::Failed(format!("{}: {e}", self.path.display()));
        let file = File::open(self.path).map_err(fail)?;
        if !file.metadata().map_err(fail)?.is_file() {
            let what = "is not a file: name a program on disk, it is read more than once";
            return Err(Failure::Failed(format!("{}: {what}", self.path.display())));
        }
        let reading = Reading {
            comments: true,
            ..Reading::default()
        };
        let said = Interpreter::from_state(
            BufReader::with_capacity(1 << 16, file),
            unknown_state(self.dialect),
            reading,
        )
        .map_err(fail)?;
        Ok(translate::Steps::new(said))
    }
}

impl Steps for Program<'_> {
    fn steps(&self) -> Result<Lines, Failure> {
        let steps = self.read()?;
        Ok(Box::new(steps.map(|s| s.map_err(|e| e.to_string()))))
    }
}

/// Translates. Exit 0 when the new program says what the old one does; 1 when it cannot; errors are for what could not be read or written.
pub fn run(args: &TranslateArgs) -> Result<ExitCode, Failure> {
    let dialect = match Dialect::from_name(&args.from) {
        Some(d) => d,
        None => {
            let from = super::sources::post(&args.from).map_err(Failure::failed)?;
            dialect_of(&from).map_err(Failure::failed)?
        }
    };
    let post = load_post(&args.to, &args.out)?;
    let program = Program {
        path: &args.program,
        dialect,
    };
    // Once through, before a line is written: what the program asks of corners, what there is to note.
    let mut first = program.read()?;
    for step in first.by_ref() {
        step.map_err(|e| Failure::Rejected(format!("{}:{e}", args.program.display())))?;
    }
    let notes = first
        .notes
        .iter()
        .map(|n| format!("line {}: {}", n.line, n.text));
    let notes: Vec<String> = notes.collect();
    let tolerance: Option<Mm> = first.path_tolerance;
    let options = options(&args.out, tolerance);
    let mut outcome = prove(&args.program, &program, &post, &options, &args.out.output)?;
    outcome.notes = notes;
    tell(&outcome, args.out.json.as_deref())
}
