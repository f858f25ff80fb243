//! Fuzzes everything that reads what people hand it. No network, no nightly:
//!
//! ```text
//! cargo run --release --example fuzz -- gcode --minutes 10 --seed 1 --findings findings.txt
//! cargo run --release --example fuzz -- gcode --seed 1 --case 12345          one case again
//! cargo run --release --example fuzz -- gcode --seed 1 --case 12345 --write bad.nc   ... and its input as a file
//! cargo run --release --example fuzz -- gcode --file bad.nc                   a file instead
//! ```
//!
//! A finding is a panic, a refusal without a reason, something accepted that must not be, more than 2 s for one input, or more than
//! 2 GiB of memory. Without `--release` arithmetic overflow is a panic too. Should the process die (a stack that overflows), the case it
//! was at stands in `FINDINGS.running`.
#![allow(missing_docs)]

#[path = "fuzzing/mod.rs"]
mod fuzzing;

use clap::Parser;
use fuzzing::targets::{TARGETS, Target, target};
use fuzzing::{Outcome, input, try_input};
use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

#[derive(Parser)]
struct Args {
    /// What to fuzz: stl, obj, gcode, cl, toml, controller, replies
    target: String,
    /// How long
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Where the random numbers begin
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The first case (to go on where a run was ended)
    #[arg(long, default_value_t = 0)]
    from: u64,
    /// Only this case
    #[arg(long)]
    case: Option<u64>,
    /// With --case: write its input here
    #[arg(long, requires = "case")]
    write: Option<PathBuf>,
    /// Only this file
    #[arg(long, conflicts_with = "case")]
    file: Option<PathBuf>,
    /// Findings are added to this file
    #[arg(long, default_value = "fuzz-findings.txt")]
    findings: PathBuf,
}

/// A case that takes longer than this will not come back: the run ends there.
const STUCK: Duration = Duration::from_secs(30);
/// More memory than this is a finding, and the run ends there.
const MOST_MIB: u64 = 2048;

fn main() -> io::Result<ExitCode> {
    let args = Args::parse();
    let Some(target) = target(&args.target) else {
        let known: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
        say(&format!(
            "there is no target \"{}\": name one of {}",
            args.target,
            known.join(", ")
        ));
        return Ok(ExitCode::from(2));
    };
    if let Some(file) = &args.file {
        return Ok(once(target, &std::fs::read(file)?));
    }
    if let Some(case) = args.case {
        let bytes = input(target, &(target.seeds)(), args.seed, case);
        if let Some(path) = &args.write {
            std::fs::write(path, &bytes)?;
        }
        return Ok(once(target, &bytes));
    }
    run(target, &args)
}

fn once(target: &Target, bytes: &[u8]) -> ExitCode {
    match try_input(target, bytes) {
        Outcome::Accepted => say("accepted"),
        Outcome::Refused => say("refused, as it should be or not: no finding"),
        Outcome::Finding(what) => {
            say(&format!("FINDING: {what}"));
            return ExitCode::from(1);
        }
    }
    ExitCode::SUCCESS
}

fn run(target: &'static Target, args: &Args) -> io::Result<ExitCode> {
    let seeds = (target.seeds)();
    let until = Duration::from_secs_f64((args.minutes * 60.0).clamp(0.0, 1e7));
    let start = Instant::now();
    let now = Arc::new(AtomicU64::new(args.from));
    watch(target, args, Arc::clone(&now));
    let mark = args.findings.with_extension("running");
    let mut running = File::create(&mark)?;
    let (mut accepted, mut refused, mut found) = (0u64, 0u64, 0u64);
    let mut case = args.from;
    let mut told = Instant::now();
    while start.elapsed() < until {
        now.store(case, Ordering::Relaxed);
        running.rewind()?;
        writeln!(
            running,
            "{} --seed {} --case {case:020}",
            target.name, args.seed
        )?;
        let bytes = input(target, &seeds, args.seed, case);
        match try_input(target, &bytes) {
            Outcome::Accepted => accepted += 1,
            Outcome::Refused => refused += 1,
            Outcome::Finding(what) => {
                found += 1;
                note(target, args, case, &what)?;
                if found >= 100 {
                    say("100 findings: mend some first");
                    break;
                }
            }
        }
        case += 1;
        if told.elapsed() > Duration::from_secs(60) {
            told = Instant::now();
            say(&format!(
                "{}: {} cases, {found} findings",
                target.name,
                accepted + refused + found
            ));
        }
    }
    drop(running);
    std::fs::remove_file(&mark)?;
    say(&format!(
        "{}: seed {}, cases {} to {}, {:.0} s: {accepted} accepted, {refused} refused, {found} findings, {} MiB at most",
        target.name,
        args.seed,
        args.from,
        case.saturating_sub(1),
        start.elapsed().as_secs_f64(),
        peak_mib().unwrap_or(0)
    ));
    Ok(ExitCode::from(u8::from(found > 0)))
}

/// Ends the run when one case hangs or eats all memory: nothing else could.
fn watch(target: &'static Target, args: &Args, now: Arc<AtomicU64>) {
    let (findings, seed) = (args.findings.clone(), args.seed);
    std::thread::spawn(move || {
        let (mut case, mut since) = (u64::MAX, Instant::now());
        loop {
            std::thread::sleep(Duration::from_millis(50));
            let current = now.load(Ordering::Relaxed);
            if current != case {
                (case, since) = (current, Instant::now());
            }
            let what = if since.elapsed() > STUCK {
                "hangs: the run ends here"
            } else if peak_mib().is_some_and(|m| m > MOST_MIB) {
                "eats memory, this case or one just before it: the run ends here"
            } else {
                continue;
            };
            let _ = add(&findings, target, seed, case, what);
            std::process::exit(1);
        }
    });
}

fn note(target: &Target, args: &Args, case: u64, what: &str) -> io::Result<()> {
    add(&args.findings, target, args.seed, case, what)
}

fn add(path: &Path, target: &Target, seed: u64, case: u64, what: &str) -> io::Result<()> {
    let line = format!(
        "{} --seed {seed} --case {case}: {}",
        target.name,
        what.replace('\n', " | ")
    );
    say(&format!("FINDING: {line}"));
    let mut file = File::options().create(true).append(true).open(path)?;
    writeln!(file, "{line}")
}

/// The most memory this process has had so far, MiB; only Linux says.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024)
}

fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}
