//! `morsemill controller`: the simulated controller behind a pseudo-terminal, for any sender to open.

use super::output::say;
use super::send::pace;
use crate::controller::{Controller, Pace, Pty};
use std::io::Write;
use std::sync::mpsc;

/// Arguments of `morsemill controller`.
#[derive(Clone, Debug, clap::Args)]
pub struct ControllerArgs {
    /// Machine: a built-in name or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = crate::machine::DEFAULT_MACHINE)]
    pub machine: String,
    /// Serve on a pseudo-terminal (the only way so far)
    #[arg(long)]
    pub pty: bool,
    /// Times real time, or `max` for as fast as the sender keeps up
    #[arg(long, value_name = "N|max", default_value = "1", value_parser = pace)]
    pub speed: Pace,
    /// Replay recordings of a real controller (JSON lines) and print each with what the simulated one answers
    #[arg(long, value_name = "FILE.jsonl")]
    pub replay: Option<std::path::PathBuf>,
    /// With --replay: print only what differs; exit 1 if anything does
    #[arg(long, requires = "replay")]
    pub compare: bool,
}

/// Serves until Ctrl-C; the path to open is the only line on `out`. Returns the exit code.
pub fn run(args: &ControllerArgs, out: &mut dyn Write) -> u8 {
    if let Some(file) = &args.replay {
        return super::replay::run(file, args.compare, out);
    }
    match serve(args, out) {
        Ok(()) => 0,
        Err(message) => {
            say(&format!("error: {message}"));
            2
        }
    }
}

fn serve(args: &ControllerArgs, out: &mut dyn Write) -> Result<(), String> {
    if !args.pty {
        return Err("say how to reach it: --pty".to_string());
    }
    let machine = super::sources::machine(&args.machine).map_err(|e| e.to_string())?;
    if !machine.speaks_grbl() {
        let family = machine.family().map_or("another controller", |f| f.title);
        return Err(format!(
            "machine {} runs {family}, and only GRBL is simulated: name a machine with a GRBL family controller",
            machine.name
        ));
    }
    let (sender, receiver) = mpsc::channel();
    ctrlc::set_handler(move || _ = sender.send(()))
        .map_err(|e| format!("Ctrl-C cannot be caught: {e}"))?;
    let pty =
        Pty::start(Controller::of_machine(&machine), args.speed).map_err(|e| e.to_string())?;
    writeln!(out, "{}", pty.path())
        .and_then(|()| out.flush())
        .map_err(|e| format!("standard output: {e}"))?;
    say(&format!(
        "GRBL 1.1h, {}: open that path as a serial device; Ctrl-C ends",
        machine.title
    ));
    // The handler's sender lives as long as the process, so this returns only on Ctrl-C.
    let _ = receiver.recv();
    Ok(())
}
