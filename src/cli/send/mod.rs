//! `morsemill send`: vet a program, then stream it to a controller, real or simulated.
//!
//! ```text
//! vet -> open the port -> introduction -> vet with the machine's own offsets and travel -> (resume: plan, simulate, ask) -> drive
//! ```

mod awake;
mod board;
mod crank;
mod eta;
mod events;
mod keys;
pub mod resume;
mod screen;

use super::output::{say, write_json};
use super::program_file::ProgramFile;
use crate::controller::{Controller, Pace, Pty};
use crate::kinematics::Settings;
use crate::link::journal::{JournalFile, Keeper};
use crate::link::vet::{VetOptions, vet};
use crate::link::{
    Ending, Introduction, IntroductionOptions, Job, JobError, Known, NotIntroduced, Outcome,
    Session, SessionOptions, introduce, port,
};
use crate::machine::Machine;
use board::Board;
use crank::{Crank, Journal, Listener};
use eta::Timer;
use resume::{ResumeArgs, Subject};
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Arguments of `morsemill send`.
#[derive(Clone, Debug, clap::Args)]
pub struct SendArgs {
    /// G-code program to send
    pub program: PathBuf,
    /// Machine: a built-in name or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = crate::machine::DEFAULT_MACHINE)]
    pub machine: String,
    /// Serial device, network address, or `sim` for the built-in simulated controller
    #[arg(long, value_name = "PORT|tcp://HOST:PORT|sim")]
    pub port: String,
    /// Read and check every line, tell what would be sent, and send nothing
    #[arg(long)]
    pub dry_run: bool,
    /// With `--port sim`: times real time, or `max` for as fast as possible
    #[arg(long, value_name = "N|max", default_value = "max", value_parser = pace)]
    pub speed: Pace,
    /// Write the result as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write what happens as it happens, one JSON object a line; `-` is standard output
    #[arg(long, value_name = "FILE|-")]
    pub events: Option<PathBuf>,
    /// Plain lines of progress even on a terminal
    #[arg(long)]
    pub plain: bool,
    /// At a tool change (M6), on resume: probe Z onto a plate of this thickness right below the tool, and set work Z by it. Without it
    /// the operator sees to the new tool's length before resuming
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub tool_plate: Option<f64>,
    /// Where to begin, and the journal
    #[command(flatten)]
    pub take_up: ResumeArgs,
}

/// Times real time, at most: a second is half a month then.
const FASTEST: f64 = 1e6;

/// Reads `--speed`.
///
/// # Errors
/// Neither `max` nor a number of zero (the same as `max`) or more.
pub fn pace(text: &str) -> Result<Pace, String> {
    match text.trim().parse::<f64>() {
        _ if text == "max" => Ok(Pace::Unbound),
        Ok(0.0) => Ok(Pace::Unbound),
        Ok(n) if n > 0.0 && n <= FASTEST => Ok(Pace::Times(n)),
        _ => Err(format!(
            "write a number above zero (1 is real time) up to {FASTEST}, or `max`"
        )),
    }
}

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

/// Sends a program; results go to `out`, everything else to stderr. Returns the exit code: 0 done, 1 refused, alarm or stopped,
/// 2 could not be carried out.
pub fn run(args: &SendArgs, out: &mut dyn Write) -> u8 {
    match send(args, out) {
        Ok(code) => code,
        Err(Failure { code, message }) => {
            say(&format!("error: {message}"));
            code
        }
    }
}

struct Failure {
    code: u8,
    message: String,
}

impl From<super::Failure> for Failure {
    fn from(f: super::Failure) -> Failure {
        match f {
            super::Failure::Rejected(message) => Failure { code: 1, message },
            super::Failure::Failed(message) => Failure { code: 2, message },
        }
    }
}

fn cannot(message: impl ToString) -> Failure {
    Failure {
        code: 2,
        message: message.to_string(),
    }
}

fn send(args: &SendArgs, out: &mut dyn Write) -> Result<u8, Failure> {
    let machine = super::sources::machine(&args.machine).map_err(cannot)?;
    if !args.dry_run && !machine.speaks_grbl() {
        let family = machine.family().map_or("another controller", |f| f.title);
        return Err(cannot(format!(
            "machine {} runs {family}, which is not fed in GRBL's protocol: `send` speaks nothing else; load the program as a file",
            machine.name
        )));
    }
    let name = args.program.display();
    let program = ProgramFile::open(&args.program).map_err(cannot)?;
    let settings = Settings::from(&machine);
    let refused = |errors: Vec<JobError>| {
        let list: Vec<String> = errors.iter().map(|e| format!("{name}:{e}")).collect();
        Failure {
            code: 1,
            message: format!("the program cannot be sent:\n{}", list.join("\n")),
        }
    };
    let source = Arc::new(program.clone());
    let mut timer = Timer::new(&settings);
    // What is wrong with it whatever the machine is told before a port is opened: opening restarts most boards.
    let rough = vet(source.clone(), VetOptions::default(), &mut |_, event| {
        timer.hear(event)
    })
    .map_err(refused)?;
    let times = timer.finish();
    if args.dry_run {
        writeln!(
            out,
            "{name}: {} lines to send, {} bytes, about {:.1} s on {}",
            rough.total, rough.bytes, times.total, machine.title
        )
        .map_err(cannot)?;
        return Ok(0);
    }
    if let Some(plate) = args.tool_plate
        && !(0.0..=200.0).contains(&plate)
    {
        return Err(cannot(format!(
            "--tool-plate {plate}: must be from 0 to 200 mm"
        )));
    }
    let simulated = args.port == "sim";
    let pty = match simulated {
        true => Some(Pty::start(Controller::of_machine(&machine), args.speed).map_err(cannot)?),
        false => None,
    };
    let path = pty
        .as_ref()
        .map_or(args.port.as_str(), Pty::path)
        .to_string();
    if simulated {
        say(&format!("simulated controller on {path}"));
    }
    let mut port = port::open(&path, machine.baud).map_err(cannot)?;
    super::errand::catch_interrupts();
    let start = Instant::now();
    let introduction = Introduction::new(
        IntroductionOptions {
            rx_bytes: machine.rx_buffer,
            ..IntroductionOptions::default()
        },
        Duration::ZERO,
    );
    let known =
        introduce(introduction, &mut port, &mut || start.elapsed()).map_err(|e| match &e {
            NotIntroduced::Controller(crate::link::Unknown::Busy(_)) => Failure {
                code: 1,
                message: e.to_string(),
            },
            _ => cannot(e),
        })?;
    let plan = Plan::make(args, &machine, &program, rough.source_lines, &known)?;
    let job = match plan.job {
        Some(job) => job,
        None => vet(
            source,
            VetOptions::of(&known, Some(machine.travel.map(|t| t.0))),
            &mut |_, _| {},
        )
        .map_err(refused)?,
    };
    let journal = match plan.begin {
        Some(begin) => Some(open_journal(args, *begin, &job)?),
        None => None,
    };
    let outcome = {
        let board = Board {
            title: format!("{name} on {}", machine.title),
            from_s: times.at(plan.first_line.saturating_sub(1)),
            times,
            ..Board::default()
        };
        let mut listener =
            Listener::new(board, args.events.as_deref(), args.plain).map_err(cannot)?;
        let _awake = match simulated {
            true => None,
            false => awake::Awake::hold().map_err(|why| listener.note(&why)).ok(),
        };
        let options = SessionOptions {
            rx_bytes: machine.rx_buffer,
            settings: promised(&machine),
            ..SessionOptions::default()
        };
        let session = Session::known(job, known, options, start.elapsed());
        Crank {
            session,
            port: &mut port,
            journal,
            start,
            tool_plate: args.tool_plate,
            rx_bytes: machine.rx_buffer,
        }
        .turn(&mut listener)
    };
    tell(args, out, &outcome, pty.as_ref())
}

/// Where the job begins, and its journal.
struct Plan {
    /// The resumed job, if it is one.
    job: Option<Job>,
    first_line: usize,
    begin: Option<Box<crate::link::journal::Begin>>,
}

impl Plan {
    fn make(
        args: &SendArgs,
        machine: &Machine,
        program: &ProgramFile,
        lines: usize,
        known: &Known,
    ) -> Result<Plan, Failure> {
        let subject = Subject {
            path: &args.program,
            program,
            sha256: &program.fingerprint().map_err(cannot)?,
            lines,
            machine,
            known,
            skips_slashed: false,
        };
        let take_up = &args.take_up;
        // A rehearsal on the simulated controller leaves no journal, unless one is named.
        let kept = args.port != "sim" || take_up.journal.is_some() || take_up.resume;
        let serial = args.port != "sim" && !args.port.starts_with("tcp:");
        if !take_up.wanted() {
            if kept {
                let path = resume::journal_path(&args.program, take_up.journal.as_deref());
                resume::make_room(&path, take_up.discard_journal)?;
            }
            return Ok(Plan {
                job: None,
                first_line: 1,
                begin: kept.then(|| Box::new(subject.begin(None, serial))),
            });
        }
        let mut notes = Vec::new();
        let plan = subject.plan(take_up, &mut notes)?;
        let job = subject.simulate(&plan, &mut notes)?;
        notes.iter().for_each(|n| say(&format!("note: {n}")));
        say(&plan.to_string());
        resume::ask(take_up.yes)?;
        if kept {
            resume::set_aside(&resume::journal_path(
                &args.program,
                take_up.journal.as_deref(),
            ))?;
        }
        Ok(Plan {
            job: Some(job),
            first_line: plan.entry.line,
            begin: kept.then(|| Box::new(subject.begin(Some(&plan), serial))),
        })
    }
}

fn open_journal(
    args: &SendArgs,
    begin: crate::link::journal::Begin,
    job: &Job,
) -> Result<Journal, Failure> {
    let path = resume::journal_path(&args.program, args.take_up.journal.as_deref());
    let (keeper, first) = Keeper::new(begin, job).map_err(cannot)?;
    let file = JournalFile::create(&path, &first).map_err(|e| {
        cannot(format!(
            "{}: the journal cannot be written: {e}. Without one a broken job could not be taken up again; --journal names another place",
            path.display()
        ))
    })?;
    Ok(Journal { keeper, file })
}

fn tell(
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
        (Err(super::Failure::Rejected(text) | super::Failure::Failed(text)), _)
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

/// `$` settings that the machine file promises, so that a difference can be told.
fn promised(machine: &Machine) -> Vec<(u16, f64)> {
    let mut settings = vec![
        (11, machine.junction_deviation.0),
        (12, machine.arc_tolerance.0),
    ];
    for (axis, offset) in (0..3).zip(0u16..) {
        settings.push((100 + offset, machine.steps_per_mm[axis]));
        settings.push((110 + offset, machine.max_rate[axis].0));
        settings.push((120 + offset, machine.acceleration[axis].0));
        settings.push((130 + offset, machine.travel[axis].0));
    }
    settings
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::path::Path;

    fn args(program: &Path, port: &str) -> SendArgs {
        SendArgs {
            program: program.to_path_buf(),
            machine: crate::machine::DEFAULT_MACHINE.to_string(),
            port: port.to_string(),
            dry_run: false,
            speed: Pace::Unbound,
            json: None,
            events: None,
            plain: false,
            tool_plate: None,
            take_up: ResumeArgs::default(),
        }
    }

    #[test]
    fn what_cannot_be_carried_out_is_two_and_what_is_refused_is_one() {
        let dir = tempfile::tempdir().unwrap();
        let good = dir.path().join("good.nc");
        std::fs::write(&good, "G0X1\n").unwrap();
        let bad = dir.path().join("bad.nc");
        std::fs::write(&bad, "G1X1\n").unwrap();
        let mut out = Vec::new();
        assert_eq!(run(&args(&dir.path().join("none.nc"), "sim"), &mut out), 2);
        assert_eq!(run(&args(dir.path(), "sim"), &mut out), 2);
        assert_eq!(run(&args(&good, "tcp://localhost:1"), &mut out), 2);
        assert_eq!(run(&args(&good, "/dev/no-such-port"), &mut out), 2);
        assert_eq!(run(&args(&bad, "/dev/no-such-port"), &mut out), 1);
        assert_eq!(
            run(
                &SendArgs {
                    machine: "no-such".into(),
                    ..args(&good, "sim")
                },
                &mut out
            ),
            2
        );
        assert!(out.is_empty());
        assert_eq!(
            run(
                &SendArgs {
                    dry_run: true,
                    ..args(&good, "sim")
                },
                &mut out
            ),
            0
        );
        assert!(
            String::from_utf8(out)
                .unwrap()
                .contains("1 lines to send, 5 bytes")
        );
    }

    #[test]
    fn speeds() {
        assert_eq!(pace("max"), Ok(Pace::Unbound));
        assert_eq!(pace("0"), Ok(Pace::Unbound));
        assert_eq!(pace("10"), Ok(Pace::Times(10.0)));
        assert_eq!(
            pace("1e300"),
            Err("write a number above zero (1 is real time) up to 1000000, or `max`".to_string())
        );
        assert!(pace("-1").is_err() && pace("nan").is_err() && pace("fast").is_err());
    }
}
