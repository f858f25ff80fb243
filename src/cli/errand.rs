//! What the operator's subcommands share: opening the port, running an errand over it, Ctrl-C, the result for people and as JSON.
//!
//! Ctrl-C once stops whatever moves in order (jog cancel, or hold, standstill and reset; homing knows only the reset); twice resets at
//! once, which costs the position when the machine was moving.

use super::Failure;
use super::output::{say, write_json};
use crate::controller::{Controller, Memory, Pace, Pty, Switches};
use crate::link::errand::{Errand, ErrandError, ErrandOptions, News, Task};
use crate::link::port::{self, Port};
use crate::link::{Known, Unknown};
use crate::machine::Machine;
use crate::wire::Reply;
use serde::Serialize;
use std::io::{IsTerminal as _, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::Instant;

/// Which controller, and where the result goes.
#[derive(Clone, Debug, clap::Args)]
pub struct ConnectArgs {
    /// Machine: a built-in name or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = crate::machine::DEFAULT_MACHINE)]
    pub machine: String,
    /// Serial device, network address, or `sim` for the built-in simulated controller
    #[arg(long, value_name = "PORT|tcp://HOST:PORT|sim")]
    pub port: String,
    /// With `--port sim`: times real time
    #[arg(long, value_name = "N", default_value = "10", value_parser = super::send::pace)]
    pub speed: Pace,
    /// Write the result as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// What the built-in simulated controller stands on, so that every errand can be tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SimBench {
    /// As the machine file says.
    Plain,
    /// With limit switches and homing: locked at first.
    Homing,
    /// With a plate 5 mm below the tool.
    Plate,
}

/// An open port with a controller behind it.
pub struct Connection {
    port: Box<dyn Port>,
    machine: Machine,
    start: Instant,
    met: bool,
    // Switched off when this is dropped.
    _simulated: Option<Pty>,
}

/// How often Ctrl-C was pressed.
static PRESSES: AtomicU32 = AtomicU32::new(0);
/// The handler is set once a process.
static CAUGHT: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C is counted instead of ending the process.
pub fn catch_interrupts() {
    if CAUGHT.swap(true, Ordering::SeqCst) {
        return;
    }
    let set = ctrlc::set_handler(|| {
        PRESSES.fetch_add(1, Ordering::SeqCst);
    });
    if set.is_err() {
        say(
            "warning: Ctrl-C cannot be caught here and would leave the machine doing what it was told last",
        );
    }
}

/// How often Ctrl-C was pressed so far.
pub fn interrupts() -> u32 {
    PRESSES.load(Ordering::SeqCst)
}

/// A simulated controller for this machine on its bench.
fn simulated(machine: &Machine, bench: SimBench) -> Controller {
    if bench == SimBench::Plain {
        return Controller::of_machine(machine);
    }
    let mut memory = Memory::of_machine(machine);
    if bench == SimBench::Homing {
        memory.set(22, 1.0);
        memory.set(24, 100.0);
        memory.set(25, 2000.0);
    }
    let mut controller = Controller::new(memory);
    let steps = |axis: usize, mm: f64| (machine.steps_per_mm[axis] * mm) as i64;
    controller.set_switches(match bench {
        SimBench::Plate => Switches {
            probe_z: Some(steps(2, -5.0)),
            ..Switches::default()
        },
        _ => Switches {
            limits: [
                None,
                Some(steps(0, 30.0)),
                None,
                Some(steps(1, 30.0)),
                None,
                Some(steps(2, 10.0)),
            ],
            ..Switches::default()
        },
    });
    controller
}

impl ConnectArgs {
    /// Opens the port. Opening a serial port restarts most boards.
    pub fn open(&self, bench: SimBench) -> Result<Connection, Failure> {
        let machine = super::sources::machine(&self.machine).map_err(Failure::failed)?;
        if !machine.speaks_grbl() {
            let family = machine.family().map_or("another controller", |f| f.title);
            return Err(Failure::Failed(format!(
                "machine {} runs {family}, which does not speak GRBL's protocol",
                machine.name
            )));
        }
        let (mut pty, mut path) = (None, self.port.clone());
        if self.port == "sim" {
            // Time must pass by itself here, so `max` is a large factor.
            let pace = match self.speed {
                Pace::Unbound => Pace::Times(100.0),
                times => times,
            };
            let started = Pty::start(simulated(&machine, bench), pace).map_err(Failure::failed)?;
            path = started.path().to_string();
            pty = Some(started);
        }
        let port = port::open(&path, machine.baud).map_err(Failure::failed)?;
        catch_interrupts();
        Ok(Connection {
            port,
            machine,
            start: Instant::now(),
            met: false,
            _simulated: pty,
        })
    }
}

/// What an errand came to.
pub struct Performed<T> {
    /// The task with what it found.
    pub task: T,
    /// How it ended.
    pub result: Result<(), ErrandError>,
    /// The controller at the end.
    pub known: Known,
}

impl Connection {
    /// Runs a task to its end. `each` is called every few milliseconds, with the news since.
    pub fn perform<T: Task>(
        &mut self,
        task: T,
        each: &mut dyn FnMut(&mut Errand<T>, &[News]),
    ) -> Performed<T> {
        let options = ErrandOptions {
            rx_bytes: self.machine.rx_buffer,
            ..ErrandOptions::default()
        };
        let mut errand = match self.met {
            false => Errand::new(task, options, self.start.elapsed()),
            true => Errand::again(task, options, self.start.elapsed()),
        };
        self.met = true;
        let mut heeded = 0;
        let mut buffer = [0u8; 512];
        let result = loop {
            let now = self.start.elapsed();
            let presses = interrupts();
            if presses > heeded {
                heeded = presses;
                match presses {
                    1 => {
                        say(
                            "\nstopping in order. Ctrl-C once more resets at once and may lose the position",
                        );
                        errand.cancel(now);
                    }
                    _ => errand.reset_now(now),
                }
            }
            errand.tick(now);
            let news = errand.news();
            each(&mut errand, &news);
            let out = errand.output();
            if !out.is_empty()
                && let Err(e) = self.port.write(&out)
            {
                errand.broken(e.to_string(), now);
            }
            if let Some(result) = errand.result() {
                break result;
            }
            match self.port.read(&mut buffer) {
                Ok(n) => errand.receive(buffer.get(..n).unwrap_or_default(), self.start.elapsed()),
                Err(e) => errand.broken(e.to_string(), self.start.elapsed()),
            }
        };
        let known = errand.known().clone();
        each(&mut errand, &[]);
        Performed {
            task: errand.task,
            result,
            known,
        }
    }

    /// The same, telling notes and, on a terminal, the position.
    pub fn perform_aloud<T: Task>(&mut self, task: T) -> Performed<T> {
        let mut line = PositionLine::new();
        let done = self.perform(task, &mut |_, news| news.iter().for_each(|n| line.hear(n)));
        line.clear();
        done
    }
}

/// The position in one line that is written over, on a terminal only; notes above it.
struct PositionLine {
    terminal: bool,
    shown: bool,
}

impl PositionLine {
    fn new() -> PositionLine {
        PositionLine {
            terminal: std::io::stderr().is_terminal(),
            shown: false,
        }
    }

    fn hear(&mut self, news: &News) {
        match news {
            News::Connected(known) => self.tell(&format!("connected: {}", known.version)),
            News::Note(text) => self.tell(&format!("note: {text}")),
            News::Stopping(text) => self.tell(text),
            News::Said(_, reply) => {
                if let Reply::Message(text) = &**reply {
                    self.tell(&format!("controller: {text}"));
                }
            }
            News::Report(status, known) if self.terminal => {
                let place = known.machine_position.map(place).unwrap_or_default();
                let _ = write!(
                    std::io::stderr(),
                    "\r\x1b[K{}  machine {place}",
                    status.state.text()
                );
                self.shown = true;
            }
            _ => {}
        }
    }

    fn tell(&mut self, text: &str) {
        self.clear();
        say(text);
    }

    fn clear(&mut self) {
        if std::mem::take(&mut self.shown) {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}

/// `X1.000 Y2.000 Z3.000`.
pub fn place(p: [f64; 3]) -> String {
    // Adding zero turns a negative zero into a plain one.
    format!("X{:.3} Y{:.3} Z{:.3}", p[0] + 0.0, p[1] + 0.0, p[2] + 0.0)
}

/// The stable content of `--json`: this, and the subcommand's own keys beside it.
#[derive(Debug, Serialize)]
struct Report<'a, D: Serialize> {
    /// The subcommand.
    command: &'a str,
    /// `done`, or `error`.
    result: &'a str,
    /// For people; empty when done.
    message: String,
    /// What the controller says it is.
    firmware: &'a str,
    /// State at the end, as GRBL spells it.
    state: &'a str,
    /// Machine position, null if it was never reported.
    machine_position_mm: Option<[f64; 3]>,
    /// Position in the active work system.
    work_position_mm: Option<[f64; 3]>,
    #[serde(flatten)]
    details: D,
}

/// Nothing of a subcommand's own.
#[derive(Debug, Serialize)]
pub struct NoDetails {}

/// Ends a subcommand: JSON, the complaint, the exit code.
pub fn finish<T, D: Serialize>(
    command: &str,
    json: Option<&PathBuf>,
    done: &Performed<T>,
    details: D,
) -> Result<std::process::ExitCode, Failure> {
    if let Some(file) = json {
        let report = Report {
            command,
            result: if done.result.is_ok() { "done" } else { "error" },
            message: done
                .result
                .as_ref()
                .map_or_else(ToString::to_string, |()| String::new()),
            firmware: &done.known.version,
            state: done.known.state.text(),
            machine_position_mm: done.known.machine_position,
            work_position_mm: done.known.work_position(),
            details,
        };
        write_json(file, &report)?;
    }
    match &done.result {
        Ok(()) => Ok(std::process::ExitCode::SUCCESS),
        Err(e) => Err(failure(e)),
    }
}

/// Exit 2 when the controller was never reached, 1 when it or the machine would not.
pub fn failure(e: &ErrandError) -> Failure {
    match e {
        ErrandError::Unknown(Unknown::Silent { .. })
        | ErrandError::Broken { moving: false, .. } => Failure::Failed(e.to_string()),
        _ => Failure::Rejected(e.to_string()),
    }
}

/// A result line on stdout; a closed pipe is no error.
pub fn tell(text: &str) -> Result<(), Failure> {
    super::output::to_stdout(|out| writeln!(out, "{text}")).map(|_| ())
}

/// Axis words such as `X10`, `y-2.5`; a letter alone means `alone`.
pub fn axis_words(words: &[String], alone: Option<f64>) -> Result<[Option<f64>; 3], Failure> {
    let mut axes = [None; 3];
    for word in words {
        let wrong = |why: &str| Failure::Failed(format!("`{word}`: {why}"));
        let mut rest = word.chars();
        let axis = match rest.next().map(|c| c.to_ascii_uppercase()) {
            Some('X') => 0,
            Some('Y') => 1,
            Some('Z') => 2,
            _ => return Err(wrong("write an axis and a number, such as X10 or Z-2.5")),
        };
        let text = rest.as_str();
        let value = match (text.is_empty(), alone) {
            (true, Some(v)) => v,
            (true, None) => {
                return Err(wrong(
                    "how far? Write a number behind the letter, such as X10",
                ));
            }
            _ => match text.parse::<f64>() {
                Ok(v) if v.is_finite() => v,
                _ => return Err(wrong("the number cannot be read")),
            },
        };
        if axes[axis].replace(value).is_some() {
            return Err(wrong("this axis is named twice"));
        }
    }
    Ok(axes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn words(text: &str, alone: Option<f64>) -> Result<[Option<f64>; 3], String> {
        let words: Vec<String> = text.split_whitespace().map(str::to_string).collect();
        axis_words(&words, alone).map_err(|e| match e {
            Failure::Failed(text) | Failure::Rejected(text) => text,
        })
    }

    #[test]
    fn axis_words_are_read_or_named() {
        assert_eq!(words("X10 z-2.5", None), Ok([Some(10.0), None, Some(-2.5)]));
        assert_eq!(words("x Z1", Some(0.0)), Ok([Some(0.0), None, Some(1.0)]));
        assert_eq!(
            words("X", None),
            Err("`X`: how far? Write a number behind the letter, such as X10".to_string())
        );
        assert_eq!(
            words("X1 X2", None),
            Err("`X2`: this axis is named twice".to_string())
        );
        assert_eq!(
            words("A1", None),
            Err("`A1`: write an axis and a number, such as X10 or Z-2.5".to_string())
        );
        assert!(
            words("Xnan", None).is_err()
                && words("X1e999", None).is_err()
                && words("", None).unwrap() == [None; 3]
        );
    }
}
