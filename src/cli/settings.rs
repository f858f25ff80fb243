//! `morsemill settings`: a controller's `$` settings to a file, compared with one, and back from one.

use super::Failure;
use super::errand::{ConnectArgs, SimBench, failure, finish, place, tell};
use super::output::{say, write_whole};
use crate::link::Known;
use crate::link::errand::{
    Difference, MovedOffset, Restore, Save, Saved, differences, moved_offsets, other_startup,
};
use crate::machine::settings_file;
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
    Diff(DiffArgs),
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

/// Arguments of `morsemill settings diff`.
#[derive(Clone, Debug, clap::Args)]
pub struct DiffArgs {
    /// What with what
    #[command(flatten)]
    pub file: FileArgs,
    /// Compare the work offsets (G54 to G59, G28, G30), too
    #[arg(long)]
    pub offsets: bool,
}

/// Arguments of `morsemill settings restore`.
#[derive(Clone, Debug, clap::Args)]
pub struct RestoreArgs {
    /// From where, to where
    #[command(flatten)]
    pub file: FileArgs,
    /// Write the work offsets G54 to G59, too: right only on a machine that is homed as it was when they were saved
    #[arg(long)]
    pub offsets: bool,
    /// Write the start-up lines $N0 and $N1, too
    #[arg(long)]
    pub startup_lines: bool,
    /// Write without asking
    #[arg(long)]
    pub yes: bool,
}

#[derive(Serialize)]
struct DifferenceRow {
    setting: u16,
    /// In words; null for a setting that this table does not know.
    name: Option<&'static str>,
    unit: Option<&'static str>,
    file: Option<String>,
    controller: Option<String>,
}

#[derive(Serialize)]
struct OffsetRow {
    name: String,
    file_mm: [f64; 3],
    controller_mm: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct StartupRow {
    line: usize,
    file: String,
    controller: String,
}

#[derive(Serialize, Default)]
struct Differences {
    differences: Vec<DifferenceRow>,
    offsets: Vec<OffsetRow>,
    startup_lines: Vec<StartupRow>,
}

#[derive(Serialize)]
struct Written {
    /// Settings written, in order: number and value as sent.
    written: Vec<(u16, String)>,
    /// Offsets and start-up lines written, as sent.
    besides: Vec<String>,
}

fn rows(
    settings: &[Difference],
    offsets: &[MovedOffset],
    startup: &[(usize, String, String)],
) -> Differences {
    let row = |d: &Difference| {
        let known = settings_file::meaning(d.number);
        DifferenceRow {
            setting: d.number,
            name: known.map(|k| k.0),
            unit: known.and_then(|k| k.1),
            file: d.file.clone(),
            controller: d.controller.clone(),
        }
    };
    Differences {
        differences: settings.iter().map(row).collect(),
        offsets: offsets
            .iter()
            .map(|o| OffsetRow {
                name: o.name.clone(),
                file_mm: o.file,
                controller_mm: o.controller,
            })
            .collect(),
        startup_lines: startup
            .iter()
            .map(|(line, file, controller)| StartupRow {
                line: *line,
                file: file.clone(),
                controller: controller.clone(),
            })
            .collect(),
    }
}

/// `$110 (highest rate of X): 3333 mm/min in the file, 4000.000 mm/min in the controller`.
fn in_words(d: &Difference) -> String {
    let known = settings_file::meaning(d.number);
    let value = |v: &Option<String>| match v {
        None => "not".to_string(),
        Some(v) if settings_file::is_switch(d.number) => match v.trim().parse::<f64>() {
            Ok(0.0) => "off (0)".to_string(),
            Ok(1.0) => "on (1)".to_string(),
            _ => v.clone(),
        },
        Some(v) => match known.and_then(|k| k.1) {
            Some(unit) => format!("{v} {unit}"),
            None => v.clone(),
        },
    };
    let name = known.map_or(String::new(), |k| format!(" ({})", k.0));
    format!(
        "${}{name}: {} in the file, {} in the controller",
        d.number,
        value(&d.file),
        value(&d.controller)
    )
}

fn offset_in_words(o: &MovedOffset) -> String {
    let controller = o.controller.map_or("not told".to_string(), place);
    format!(
        "{}: {} in the file, {controller} in the controller (machine coordinates, mm)",
        o.name,
        place(o.file)
    )
}

fn startup_in_words((n, file, controller): &(usize, String, String)) -> String {
    let text = |t: &str| {
        if t.is_empty() {
            "nothing".to_string()
        } else {
            format!("`{t}`")
        }
    };
    format!(
        "$N{n} (start-up line): {} in the file, {} in the controller",
        text(file),
        text(controller)
    )
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
        Differences::default(),
    )
}

fn read(path: &Path) -> Result<Saved, Failure> {
    let fail = |text: String| Failure::Failed(format!("{}{text}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| fail(format!(": cannot be read: {e}")))?;
    Saved::read(&text).map_err(|(line, why)| fail(format!(":{line}: {why}")))
}

fn diff(args: &DiffArgs) -> Result<ExitCode, Failure> {
    let connect = &args.file.connect;
    let file = read(&args.file.file)?;
    let done = connect
        .open(SimBench::Plain)?
        .perform_aloud(Save::default());
    let (mut settings, mut offsets, mut startup) = (Vec::new(), Vec::new(), Vec::new());
    if done.result.is_ok() {
        let now = &done.task.saved;
        if let Some(why) = file.foreign(now) {
            say(&format!("note: {why}"));
        }
        settings = differences(&file, now);
        startup = other_startup(&file, now);
        if args.offsets {
            offsets = moved_offsets(&file, now);
        }
    }
    for line in settings.iter().map(in_words) {
        tell(&line)?;
    }
    for line in offsets.iter().map(offset_in_words) {
        tell(&line)?;
    }
    for line in startup.iter().map(startup_in_words) {
        tell(&line)?;
    }
    let none = settings.is_empty() && offsets.is_empty() && startup.is_empty();
    finish(
        "settings diff",
        connect.json.as_ref(),
        &done,
        rows(&settings, &offsets, &startup),
    )?;
    if none {
        tell("no difference")?;
    }
    Ok(if none {
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
    let now = &before.task.saved;
    if let Some(why) = file.foreign(now) {
        return Err(Failure::Rejected(format!(
            "{}: {why}. Nothing was written",
            args.file.file.display()
        )));
    }
    let settings = plan(&file, &before.known, now)?;
    let mut task = Restore::new(file.settings.clone());
    let moved = moved_offsets(&file, now);
    let (stored, moved): (Vec<_>, Vec<_>) = moved
        .into_iter()
        .partition(|o| matches!(o.name.as_str(), "G28" | "G30"));
    if args.offsets {
        for o in &stored {
            say(&format!(
                "note: {} is not written, as the firmware stores it only where the machine stands: drive to {} and send {}.1 (`morsemill console`)",
                o.name,
                place(o.file),
                o.name
            ));
        }
        task.offsets = moved
            .iter()
            .filter_map(|o| Some((system(&o.name)?, o.file)))
            .collect();
    }
    let startup = other_startup(&file, now);
    if args.startup_lines {
        for (n, text, _) in &startup {
            Restore::startup_line(*n, text).map_err(|e| failure(&e))?;
        }
        task.startup = startup
            .iter()
            .map(|(n, text, _)| (*n, text.clone()))
            .collect();
    }
    if settings.is_empty() && task.offsets.is_empty() && task.startup.is_empty() {
        tell("nothing to write: the controller has these settings")?;
        return finish(
            "settings restore",
            connect.json.as_ref(),
            &before,
            Written {
                written: Vec::new(),
                besides: Vec::new(),
            },
        );
    }
    for (number, value) in &settings {
        let d = Difference {
            number: *number,
            file: Some(value.clone()),
            controller: now.get(*number).map(str::to_string),
        };
        tell(&in_words(&d))?;
    }
    if args.offsets {
        for line in moved.iter().map(offset_in_words) {
            tell(&line)?;
        }
    }
    if args.startup_lines {
        for line in startup.iter().map(startup_in_words) {
            tell(&line)?;
        }
    }
    if !args.yes && !confirmed()? {
        return Err(Failure::Rejected("nothing was written".to_string()));
    }
    let done = connection.perform_aloud(task);
    if done.result.is_ok() {
        let mut text = format!("{} settings written and read back", done.task.written.len());
        if !done.task.besides.is_empty() {
            text += &format!(", {} offsets and start-up lines", done.task.besides.len());
        }
        tell(&text)?;
    } else {
        let settings = done.task.written.iter().map(|(n, v)| format!("${n}={v}"));
        let all: Vec<String> = settings.chain(done.task.besides.iter().cloned()).collect();
        say(&match all.is_empty() {
            true => "nothing was written".to_string(),
            false => format!(
                "sent before that: {}. Compare with `morsemill settings diff`",
                all.join(" ")
            ),
        });
    }
    let details = Written {
        written: done.task.written.clone(),
        besides: done.task.besides.clone(),
    };
    finish("settings restore", connect.json.as_ref(), &done, details)
}

/// G54 to G59 as 0 to 5.
fn system(name: &str) -> Option<usize> {
    let number: usize = name.strip_prefix('G')?.parse().ok()?;
    number.checked_sub(54).filter(|n| *n < 6)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_told_in_words_with_units() {
        let d = |number, file: Option<&str>, controller: Option<&str>| {
            in_words(&Difference {
                number,
                file: file.map(str::to_string),
                controller: controller.map(str::to_string),
            })
        };
        assert_eq!(
            d(110, Some("3333"), Some("4000.000")),
            "$110 (highest rate of X): 3333 mm/min in the file, 4000.000 mm/min in the controller"
        );
        assert_eq!(
            d(22, Some("1"), Some("0")),
            "$22 (homing cycle): on (1) in the file, off (0) in the controller"
        );
        assert_eq!(
            d(340, None, Some("5")),
            "$340: not in the file, 5 in the controller"
        );
        assert_eq!(
            startup_in_words(&(1, "G20".into(), String::new())),
            "$N1 (start-up line): `G20` in the file, nothing in the controller"
        );
        assert_eq!(
            offset_in_words(&MovedOffset {
                name: "G54".into(),
                file: [1.0, -0.0, 2.5],
                controller: Some([0.0; 3])
            }),
            "G54: X1.000 Y0.000 Z2.500 in the file, X0.000 Y0.000 Z0.000 in the controller (machine coordinates, mm)"
        );
        assert_eq!(
            (system("G54"), system("G59"), system("G28")),
            (Some(0), Some(5), None)
        );
    }
}
