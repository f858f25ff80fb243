//! What a job came to: for people on standard output, as JSON, and as exit code.

use super::{Failure, SendArgs, cannot};
use crate::cli::output::write_json;
use crate::controller::Pty;
use crate::link::{Ending, Outcome};
use serde::Serialize;
use std::io::Write;

/// The stable content of `--json`. Lengths mm, times s.
#[derive(Debug, Serialize)]
struct Report {
    /// Lines sent.
    lines: usize,
    /// Lines the controller answered.
    acknowledged: usize,
    /// Lines of the program that there are to send.
    lines_total: usize,
    /// Work position as the controller reports it, null if it never did.
    final_position_mm: Option<[f64; 3]>,
    /// False when steps may have been lost.
    position_kept: bool,
    /// From the first motion to the last standstill.
    machine_time_s: f64,
    /// Whose clock that was: `controller` or `host`.
    machine_time_source: &'static str,
    /// `done`, `stopped` or `error ...`.
    result: String,
    /// The same for people.
    message: String,
}

/// Tells the result everywhere; the exit code.
pub(super) fn tell(
    args: &SendArgs,
    out: &mut dyn Write,
    outcome: &Outcome,
    pty: Option<&Pty>,
) -> Result<u8, Failure> {
    let (machine_time_s, machine_time_source) = match pty {
        Some(pty) => (pty.readout().elapsed_s, "controller"),
        None => (outcome.running_s, "host"),
    };
    let report = Report {
        lines: outcome.sent,
        acknowledged: outcome.acknowledged,
        lines_total: outcome.total,
        final_position_mm: outcome.position,
        position_kept: outcome.position_kept,
        machine_time_s,
        machine_time_source,
        result: outcome.ending.key(),
        message: outcome.ending.to_string(),
    };
    // The job has ended whatever happens here: one lost copy of the result must not cost the other.
    let kept = args
        .json
        .as_ref()
        .map_or(Ok(()), |file| write_json(file, &report));
    let told = match summary(args, &report, out).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(format!("standard output: {e}"))
        }
        _ => Ok(()),
    };
    let lost = match (kept, told) {
        (Err(crate::cli::Failure::Rejected(text) | crate::cli::Failure::Failed(text)), _)
        | (_, Err(text)) => text,
        _ => return Ok(exit_code(outcome)),
    };
    Err(cannot(format!(
        "{lost} (the job itself: {})",
        report.message
    )))
}

fn exit_code(outcome: &Outcome) -> u8 {
    match outcome.ending {
        Ending::Done => 0,
        Ending::Silent { .. } | Ending::Broken(_) if outcome.sent == 0 => 2,
        _ => 1,
    }
}

fn summary(args: &SendArgs, report: &Report, out: &mut dyn Write) -> std::io::Result<()> {
    if args.events.as_ref().is_some_and(|e| e.as_os_str() == "-") {
        // Standard output belongs to the events, whose last one says it all.
        return Ok(());
    }
    writeln!(
        out,
        "lines sent           {} of {}",
        report.lines, report.lines_total
    )?;
    writeln!(out, "lines acknowledged   {}", report.acknowledged)?;
    match report.final_position_mm {
        Some([x, y, z]) => {
            // Adding zero turns a negative zero into a plain one.
            let (x, y, z) = (x + 0.0, y + 0.0, z + 0.0);
            let doubt = if report.position_kept {
                ""
            } else {
                "  (not certain: steps may be lost)"
            };
            writeln!(
                out,
                "final position       X{x:.3} Y{y:.3} Z{z:.3} mm, work{doubt}"
            )?;
        }
        None => writeln!(out, "final position       not reported")?,
    }
    writeln!(
        out,
        "machine time         {:.2} s ({} clock)",
        report.machine_time_s, report.machine_time_source
    )?;
    writeln!(out, "result               {}", report.message)
}
