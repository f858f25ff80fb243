//! `morsemill post IN.cl -o OUT.nc --post NAME`: an APT cutter-location file of any CAM system as a program, proven by reading it back.

use super::Failure;
use super::proven::{Lines, ProgramArgs, ProgramUnits, Steps, load_post, options, prove, tell};
use crate::cldata::read::{Lengths, ReadOptions, Reader};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `post`.
#[derive(Clone, Debug, clap::Args)]
pub struct PostArgs {
    /// The cutter-location file (APT words, points of the tool tip)
    pub cl: PathBuf,
    /// Dialect to write: a name from `morsemill posts`, or a file
    #[arg(long, value_name = "NAME|FILE")]
    pub post: String,
    /// Units of a file that has no UNITS statement
    #[arg(long, value_name = "mm|inch", default_value = "mm")]
    pub cl_units: ProgramUnits,
    #[allow(
        missing_docs,
        reason = "a doc comment here would become the command's help"
    )]
    #[command(flatten)]
    pub out: ProgramArgs,
}

/// A CL file on disk, read anew each time.
struct ClFile<'a> {
    path: &'a Path,
    options: ReadOptions,
}

impl ClFile<'_> {
    fn read(&self) -> Result<Reader<BufReader<File>>, Failure> {
        let fail = |e: std::io::Error| Failure::Failed(format!("{}: {e}", self.path.display()));
        let file = File::open(self.path).map_err(fail)?;
        if !file.metadata().map_err(fail)?.is_file() {
            let what = "is not a file: name a CL file on disk, it is read more than once";
            return Err(Failure::Failed(format!("{}: {what}", self.path.display())));
        }
        let from = BufReader::with_capacity(1 << 16, file);
        Ok(Reader::new(from, self.options))
    }
}

impl Steps for ClFile<'_> {
    fn steps(&self) -> Result<Lines, Failure> {
        Ok(Box::new(self.read()?.map(|s| s.map_err(|e| e.to_string()))))
    }
}

/// Posts. Exit 0 when the program says what the CL file does; 1 when it cannot; errors are for what could not be read or written.
pub fn run(args: &PostArgs) -> Result<ExitCode, Failure> {
    let post = load_post(&args.post, &args.out)?;
    let file = ClFile {
        path: &args.cl,
        options: ReadOptions {
            unsaid: match args.cl_units {
                ProgramUnits::Mm => Lengths::Mm,
                ProgramUnits::Inch => Lengths::Inch,
            },
        },
    };
    // Once through, before a line is written: what is wrong with it, what there is to note.
    let mut first = file.read()?;
    for step in first.by_ref() {
        step.map_err(|e| Failure::Rejected(format!("{}:{e}", args.cl.display())))?;
    }
    let notes = first.notes().iter().map(ToString::to_string).collect();
    let mut outcome = prove(
        &args.cl,
        &file,
        &post,
        &options(&args.out, None),
        &args.out.output,
    )?;
    outcome.notes = notes;
    tell(&outcome, args.out.json.as_deref())
}
