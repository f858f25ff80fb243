//! `morsemill send`: vet a program, then stream it to a controller, real or simulated.
//!
//! ```text
//! vet -> open the port -> introduction -> vet with the machine's own offsets and travel -> (resume: plan, simulate, ask) -> drive
//! ```

mod awake;
mod board;
mod change;
mod crank;
mod eta;
mod events;
mod hands;
mod keys;
mod listener;
mod result;
pub mod resume;
mod screen;

use super::output::say;
use super::program_file::ProgramFile;
use crate::controller::{Controller, Pace, Pty};
use crate::kinematics::Settings;
use crate::link::errand::{ErrandOptions, Watch};
use crate::link::journal::{JournalFile, Keeper};
use crate::link::vet::{VetOptions, vet};
use crate::link::{
    Introduction, IntroductionOptions, Job, JobError, Known, NotIntroduced, Session,
    SessionOptions, introduce, port,
};
use crate::machine::Machine;
use board::Board;
use change::{Changer, Gauge, Range};
use crank::{Crank, Journal};
use eta::Timer;
use hands::{Hands, Leave, Offer};
use listener::Listener;
use resume::{ResumeArgs, Subject};
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
    /// On the screen, before the first line: jog, home and set zero by keys; `r` begins
    #[arg(long, conflicts_with_all = ["plain", "dry_run"])]
    pub setup: bool,
    /// At a tool change (M6): probe a plate of this thickness that lies on work Z zero, right below the tool. Without it the
    /// operator touches the new tool off by keys. The difference is shown, confirmed, and written to every work offset
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub tool_plate: Option<f64>,
    /// At a tool change (M6): measure the old tool and the new one on a fixed sensor at this place, machine coordinates in mm (homed
    /// machine with soft limits). No flag sets it: a whole change on a sensor has not been rehearsed.
    #[arg(skip)]
    pub tool_setter: Option<[f64; 2]>,
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
    let mut range = Range::default();
    let rough = vet(source.clone(), VetOptions::default(), &mut |_, event| {
        timer.hear(event);
        range.hear(event);
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
    let known = match args.setup {
        false => known,
        true => {
            let mut hands = Hands {
                port: &mut port,
                start,
                options: ErrandOptions {
                    rx_bytes: machine.rx_buffer,
                    ..ErrandOptions::default()
                },
                step: hands::FIRST_STEP,
            };
            let title = format!("{name} on {}", machine.title);
            match set_up(title, &mut hands, known)? {
                Some(known) => known,
                None => {
                    say("nothing was sent");
                    return Ok(1);
                }
            }
        }
    };
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
            changer: Changer {
                gauge: match (args.tool_plate, args.tool_setter) {
                    (Some(plate), _) => Gauge::Plate(plate),
                    (None, Some(at)) => Gauge::Sensor(at),
                    (None, None) => Gauge::Hand,
                },
                range: range.0,
                yes: args.take_up.yes,
                ..Changer::default()
            },
            rx_bytes: machine.rx_buffer,
        }
        .turn(&mut listener)
    };
    result::tell(args, out, &outcome, pty.as_ref())
}

/// The machine in the operator's hands before the first line. What is known of it then; `None` when there is to be no job.
fn set_up(title: String, hands: &mut Hands<'_>, known: Known) -> Result<Option<Known>, Failure> {
    let board = Board {
        title,
        version: known.version.clone(),
        attention: Some("before the start: jog, home, set zero; r begins, x leaves".to_string()),
        ..Board::default()
    };
    let mut listener = Listener::new(board, None, false).map_err(cannot)?;
    if !listener.has_keys() {
        return Err(cannot(
            "--setup needs a terminal for its keys: leave it out, and use `morsemill jog`, `zero` and `home`",
        ));
    }
    match hands.by_hand(known, &mut listener, Offer::Start) {
        // Whatever was set meanwhile, the job is vetted with the offsets that hold now.
        Leave::GoOn | Leave::Measure => {
            let now = hands.afresh(Watch { quit: true }, &mut listener);
            now.result.map_err(cannot)?;
            Ok(Some(now.known))
        }
        Leave::Stop => Ok(None),
        Leave::Lost(e) => Err(cannot(e)),
    }
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
            setup: false,
            tool_plate: None,
            tool_setter: None,
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
