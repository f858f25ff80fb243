//! The fault campaign at length, or one case of it with all that was said:
//!
//! ```text
//! cargo run --release --example campaign -- --jobs 10000 --seed 1
//! cargo run --release --example campaign -- --only 1234567890
//! ```
//! The laws and the classes of faults stand in `tests/it/campaign`.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/it/campaign/mod.rs"]
mod campaign;
#[path = "../tests/it/chance.rs"]
mod chance;

use clap::Parser;
use std::io::Write as _;
use std::process::ExitCode;
use std::time::Instant;

#[derive(Parser)]
struct Args {
    /// Cases to run.
    #[arg(long, default_value_t = 10_000)]
    jobs: u64,
    /// Seed of the whole campaign.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Run the one case of this seed (as a failure names it) and show its conversation.
    #[arg(long)]
    only: Option<u64>,
    /// With --only: the seed is one of those that were found with the first fifteen classes of faults.
    #[arg(long)]
    first: bool,
    /// Failures shown.
    #[arg(long, default_value_t = 10)]
    show: usize,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let mut out = std::io::stdout().lock();
    if let Some(seed) = args.only {
        let run = match args.first {
            true => campaign::case::first_case,
            false => campaign::case::case,
        };
        let (text, code) = match run(seed, true) {
            Ok(v) => (
                format!("{}\n{:?}: {}", v.log.join("\n"), v.class, v.ending),
                ExitCode::SUCCESS,
            ),
            Err(why) => (why, ExitCode::from(1)),
        };
        let _ = writeln!(out, "{text}");
        return code;
    }
    let began = Instant::now();
    let (good, bad) = campaign::run(args.seed, args.jobs);
    let _ = writeln!(out, "{}", campaign::table(&good));
    let _ = writeln!(
        out,
        "seed {}: {} cases, {} broke a law; {:.1} s",
        args.seed,
        args.jobs,
        bad.len(),
        began.elapsed().as_secs_f64()
    );
    for (seed, why) in bad.iter().take(args.show) {
        let _ = writeln!(out, "\nseed {seed}: {why}");
    }
    if bad.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    }
}
