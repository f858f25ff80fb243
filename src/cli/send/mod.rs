//! `morsemill send`: vet a program, then stream it to a controller, real or simulated.

pub mod resume;

use super::check::read_program;
use super::output::{say, write_json};
use crate::controller::{Controller, Pace, Pty};
use crate::kinematics::{Settings, program_time};
use crate::link::{
    Command, Ending, Job, Outcome, Progress, SerialPort, Session, SessionOptions, drive,
};
use crate::machine::Machine;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{BufRead as _, IsTerminal as _, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// How long one look at the port waits. Short, so that commands and polls are prompt; bytes end it at once anyway.
const PORT_TIMEOUT: Duration = Duration::from_millis(10);

/// Arguments of `morsemill send`.
#[derive(Clone, Debug, clap::Args)]
pub struct SendArgs {
    /// G-code program to send
    pub program: PathBuf,
    /// Machine: a built-in name or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = crate::machine::DEFAULT_MACHINE)]
    pub machine: String,
    /// Serial device, or `sim` for the built-in simulated controller
    #[arg(long, value_name = "PORT|sim")]
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

fn cannot(message: impl ToString) -> Failure {
    Failure {
        code: 2,
        message: message.to_string(),
    }
}

fn send(args: &SendArgs, out: &mut dyn Write) -> Result<u8, Failure> {
    let machine = super::sources::machine(&args.machine).map_err(cannot)?;
    if args.port.starts_with("tcp://") {
        return Err(cannot(
            "--port tcp://... is not supported yet: use a serial device, or `sim`",
        ));
    }
    if !args.dry_run && !machine.speaks_grbl() {
        let family = machine.family().map_or("another controller", |f| f.title);
        return Err(cannot(format!(
            "machine {} runs {family}, which is not fed in GRBL's protocol: `send` speaks nothing else; load the program as a file",
            machine.name
        )));
    }
    let name = args.program.display();
    let text = read_program(&args.program).map_err(cannot)?;
    let job = Job::vet(&text).map_err(|errors| {
        let list: Vec<String> = errors.iter().map(|e| format!("{name}:{e}")).collect();
        Failure {
            code: 1,
            message: format!("the program cannot be sent:\n{}", list.join("\n")),
        }
    })?;
    if args.dry_run {
        let time = program_time(&job.events().unwrap_or_default(), &Settings::from(&machine)).total.0;
        writeln!(
            out,
            "{name}: {} lines to send, {} bytes, about {time:.1} s on {}",
            job.total,
            job.bytes,
            machine.title
        )
        .map_err(cannot)?;
        return Ok(0);
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
    let mut port = SerialPort::open(&path, machine.baud, PORT_TIMEOUT).map_err(cannot)?;
    let options = SessionOptions {
        rx_bytes: machine.rx_buffer,
        settings: promised(&machine),
        ..SessionOptions::default()
    };
    let mut session = Session::new(job, options);
    let outcome = {
        let commands = commands();
        let mut bar = Bar::new();
        let start = Instant::now();
        drive(
            &mut session,
            &mut port,
            &mut || start.elapsed(),
            &mut || commands.try_recv().ok(),
            &mut |news| bar.show(news),
        )
    };
    let (machine_time_s, machine_time_source) = match &pty {
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
    let told = match summary(&report, out).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(format!("standard output: {e}"))
        }
        _ => Ok(()),
    };
    let lost = match (kept, told) {
        (Err(super::Failure::Rejected(text) | super::Failure::Failed(text)), _)
        | (_, Err(text)) => text,
        _ => return Ok(exit_code(&outcome)),
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

fn summary(report: &Report, out: &mut dyn Write) -> std::io::Result<()> {
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

/// The operator's wishes: Ctrl-C, and lines on a terminal's stdin.
fn commands() -> mpsc::Receiver<Command> {
    let (sender, receiver) = mpsc::channel();
    let presses = Arc::new(AtomicU32::new(0));
    let on_interrupt = sender.clone();
    let set = ctrlc::set_handler(move || {
        // The first stops the job in order; the second means it.
        let command = if presses.fetch_add(1, Ordering::Relaxed) == 0 {
            say(
                "\nstopping: feed hold, standstill, reset. Ctrl-C once more resets at once and loses the position",
            );
            Command::Stop
        } else {
            Command::ResetNow
        };
        // Nobody listens any more: the job has ended.
        let _ = on_interrupt.send(command);
    });
    if set.is_err() {
        say(
            "warning: Ctrl-C cannot be caught here and would leave the machine running what it has received",
        );
    }
    if std::io::stdin().is_terminal() {
        say("h hold, r resume, x stop, each with Enter; Ctrl-C stops too");
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines() {
                let Ok(line) = line else { return };
                let Some(command) = wish(&line) else { continue };
                if sender.send(command).is_err() {
                    return;
                }
            }
        });
    }
    receiver
}

/// What a line typed by the operator means.
fn wish(line: &str) -> Option<Command> {
    // A lone blank (the biggest key) is a hold, so the line is not trimmed before that test.
    match line.trim_end_matches(['\r', '\n']) {
        " " => Some(Command::Hold),
        other => match other.trim() {
            "h" | "!" => Some(Command::Hold),
            "r" | "~" => Some(Command::Resume),
            "x" => Some(Command::Stop),
            _ => None,
        },
    }
}

/// Progress on a terminal; elsewhere only what matters.
struct Bar(ProgressBar);

impl Bar {
    fn new() -> Bar {
        Bar(ProgressBar::hidden())
    }

    fn tell(&self, text: &str) {
        if self.0.is_hidden() {
            say(text);
        } else {
            self.0.println(text);
        }
    }

    fn show(&mut self, news: &Progress) {
        match news {
            Progress::Connected(known) => self.tell(&format!(
                "connected: {}, {} bytes of buffer",
                known.version, known.rx_bytes
            )),
            Progress::Note(text) => self.tell(&format!("note: {text}")),
            Progress::Started { total } => {
                self.0 = ProgressBar::new(*total as u64);
                if let Ok(style) =
                    ProgressStyle::with_template("{bar:30} {pos}/{len} lines  {msg}  {eta} left")
                {
                    self.0.set_style(style);
                }
            }
            Progress::Report(report) => {
                self.0.set_position(report.acknowledged as u64);
                let place = report.position.map_or(String::new(), |[x, y, z]| {
                    format!("  X{x:.2} Y{y:.2} Z{z:.2}")
                });
                let feed = report.feed.map_or(String::new(), |f| format!("  F{f:.0}"));
                self.0
                    .set_message(format!("{}{place}{feed}", report.state.text()));
            }
            Progress::Prompt(prompt) => self.tell(&prompt.to_string()),
            Progress::Stall(Some(stall)) => self.tell(&stall.to_string()),
            Progress::Paused(text) => self.tell(text),
            Progress::Stopping(why) => {
                self.tell(&format!("{why}: feed hold, then standstill, then reset"))
            }
            _ => {}
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
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
    fn keys_and_speeds() {
        assert_eq!(wish(" "), Some(Command::Hold));
        assert_eq!(wish("h"), Some(Command::Hold));
        assert_eq!(wish("~\r"), Some(Command::Resume));
        assert_eq!(wish("x"), Some(Command::Stop));
        assert_eq!(wish(""), None);
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
