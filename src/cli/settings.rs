//! `morsemill settings`: a controller's `$` settings to a file, compared with one, and back from one.

use super::Failure;
use super::errand::{ConnectArgs, SimBench, failure, finish, tell};
use super::output::{say, write_whole};
use crate::link::Known;
use crate::link::errand::{Difference, Restore, Save, Saved, differences};
use serde::Serialize;
use std::io::{BufRead as _, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `morsemill settings`.
#[derive(Clone, Debug, clap::Args)]
pub struct SettingsArgs {
    /// What to do
    #[command(subcommand)]
    pub what: What,
}

/// What to do with settings.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum What {
    /// The controller's settings, offsets and start-up lines to a file
    Save(FileArgs),
    /// A file's settings into the controller: only those that differ, checked before and read back after
    Restore(RestoreArgs),
    /// What differs between a file and the controller; exit 1 if anything does
    Diff(FileArgs),
}

/// A settings file and a controller.
#[derive(Clone, Debug, clap::Args)]
pub struct FileArgs {
    /// Text file with lines `$n=value`
    pub file: PathBuf,
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

/// Arguments of `morsemill settings restore`.
#[derive(Clone, Debug, clap::Args)]
pub struct RestoreArgs {
    /// From where, to where
    #[command(flatten)]
    pub file: FileArgs,
    /// Write without asking
    #[arg(long)]
    pub yes: bool,
}

#[derive(Serialize)]
struct DifferenceRow {
    setting: u16,
    file: Option<String>,
    controller: Option<String>,
}

#[derive(Serialize)]
struct Differences {
    differences: Vec<DifferenceRow>,
}

#[derive(Serialize)]
struct Written {
    /// Settings written, in order: number and value as sent.
    written: Vec<(u16, String)>,
}

fn rows(found: &[Difference]) -> Differences {
    let row = |d: &Difference| DifferenceRow {
        setting: d.number,
        file: d.file.clone(),
        controller: d.controller.clone(),
    };
    Differences {
        differences: found.iter().map(row).collect(),
    }
}

/// Saves, restores or compares.
pub fn run(args: &SettingsArgs) -> Result<ExitCode, Failure> {
    match &args.what {
        What::Save(a) => save(a),
        What::Diff(a) => diff(a),
        What::Restore(a) => restore(a),
    }
}

fn save(args: &FileArgs) -> Result<ExitCode, Failure> {
    let done = args
        .connect
        .open(SimBench::Plain)?
        .perform_aloud(Save::default());
    if done.result.is_ok() {
        write_whole(&args.file, done.task.saved.text().as_bytes())?;
        tell(&format!(
            "{} settings in {}",
            done.task.saved.settings.len(),
            args.file.display()
        ))?;
    }
    finish(
        "settings save",
        args.connect.json.as_ref(),
        &done,
        Differences {
            differences: Vec::new(),
        },
    )
}

fn read(path: &Path) -> Result<Saved, Failure> {
    let fail = |text: String| Failure::Failed(format!("{}{text}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| fail(format!(": cannot be read: {e}")))?;
    Saved::read(&text).map_err(|(line, why)| fail(format!(":{line}: {why}")))
}

fn diff(args: &FileArgs) -> Result<ExitCode, Failure> {
    let file = read(&args.file)?;
    let done = args
        .connect
        .open(SimBench::Plain)?
        .perform_aloud(Save::default());
    let found = match done.result {
        Ok(()) => differences(&file, &done.task.saved),
        Err(_) => Vec::new(),
    };
    for d in &found {
        let value = |v: &Option<String>| v.clone().unwrap_or_else(|| "-".to_string());
        tell(&format!(
            "${:<4} file {:>12}   controller {:>12}",
            d.number,
            value(&d.file),
            value(&d.controller)
        ))?;
    }
    finish(
        "settings diff",
        args.connect.json.as_ref(),
        &done,
        rows(&found),
    )?;
    if found.is_empty() {
        tell("no difference")?;
    }
    Ok(if found.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn restore(args: &RestoreArgs) -> Result<ExitCode, Failure> {
    let file = read(&args.file.file)?;
    let connect = &args.file.connect;
    let mut connection = connect.open(SimBench::Plain)?;
    let before = connection.perform_aloud(Save::default());
    if let Err(e) = &before.result {
        return Err(failure(e));
    }
    let plan = plan(&file, &before.known, &before.task.saved)?;
    if plan.is_empty() {
        tell("nothing to write: the controller has these settings")?;
        return finish(
            "settings restore",
            connect.json.as_ref(),
            &before,
            Written {
                written: Vec::new(),
            },
        );
    }
    for (number, value) in &plan {
        let has = before.task.saved.get(*number).unwrap_or("-");
        tell(&format!("${number:<4} {has:>12} -> {value}"))?;
    }
    if !args.yes && !confirmed()? {
        return Err(Failure::Rejected("nothing was written".to_string()));
    }
    let done = connection.perform_aloud(Restore::new(file.settings));
    if done.result.is_ok() {
        tell(&format!(
            "{} settings written and read back",
            done.task.written.len()
        ))?;
    } else if !done.task.written.is_empty() {
        say(&format!(
            "written before that: {}",
            done.task
                .written
                .iter()
                .map(|(n, v)| format!("${n}={v}"))
                .collect::<Vec<_>>()
                .join(" ")
        ));
    }
    let written = done.task.written.clone();
    finish(
        "settings restore",
        connect.json.as_ref(),
        &done,
        Written { written },
    )
}

fn plan(file: &Saved, known: &Known, now: &Saved) -> Result<Vec<(u16, String)>, Failure> {
    let plan = Restore::plan(&file.settings, known).map_err(|e| failure(&e))?;
    // Values that are no numbers are compared as the texts they are.
    let differs = |n: u16| differences(file, now).iter().any(|d| d.number == n);
    Ok(plan.into_iter().filter(|(n, _)| differs(*n)).collect())
}

/// Asks on the terminal; without one there is nobody to ask.
fn confirmed() -> Result<bool, Failure> {
    if !std::io::stdin().is_terminal() {
        return Err(Failure::Failed(
            "writing settings needs a yes, and there is no terminal to ask on: add --yes"
                .to_string(),
        ));
    }
    say("write these? Type yes and Enter; anything else leaves all as it is");
    let mut answer = String::new();
    let read = std::io::stdin().lock().read_line(&mut answer);
    Ok(read.is_ok() && answer.trim() == "yes")
}
