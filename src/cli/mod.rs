//! The command line: the only place that prints, asks or names files. One file a subcommand.
//!
//! Exit codes, a contract: 0 clean; 1 the program or the job is not acceptable (gouge, over-scallop, limit, alarm, refused line);
//! 2 the command could not be carried out (unreadable file, bad flag, no port). Results go to stdout, progress and complaints to stderr.

pub mod args;
pub mod check;
pub mod console;
pub mod controller;
pub mod dialects;
pub mod errand;
pub mod features;
pub mod home;
pub mod jog;
pub mod machines;
pub mod mill;
pub mod output;
mod pictures;
pub mod ports;
pub mod post;
pub mod posts;
pub mod probe;
mod program_file;
mod progress;
mod proven;
mod replay;
mod rest_picture;
pub mod send;
pub mod settings;
mod show;
pub mod sources;
pub mod translate;
pub mod unlock;
pub mod zero;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// From a freeform part to chips on a 3-axis mill: Morse features, constant-cusp ball-end passes, proven G-code.
#[derive(Debug, Parser)]
#[command(name = "morsemill", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Threads to use; 0 = all cores. The result does not depend on it
    #[arg(long, global = true, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// From a part to a proven program: features, passes, G-code, dry run, verdict
    Mill(Box<mill::MillArgs>),
    /// The part's critical points and machining features, without a program
    Features(Box<features::FeaturesArgs>),
    /// Proves a program: limits, time and, with a part, cusps, gouges and rapids into stock
    Check(Box<check::CheckArgs>),
    /// An APT cutter-location file of any CAM system as a program, proven by reading it back
    Post(Box<post::PostArgs>),
    /// A program of one dialect in another, proven by reading it back
    Translate(Box<translate::TranslateArgs>),
    /// Streams a program to a GRBL controller, or to the simulated one
    Send(Box<send::SendArgs>),
    /// Homes the machine
    Home(Box<home::HomeArgs>),
    /// Ends the lock of an alarm
    Unlock(Box<unlock::UnlockArgs>),
    /// Moves the tool by a distance or to a place
    Jog(Box<jog::JogArgs>),
    /// Sets work zero where the tool stands, or goes there
    Zero(Box<zero::ZeroArgs>),
    /// Touches a plate below the tool and sets work Z by it
    Probe(Box<probe::ProbeArgs>),
    /// A controller's $ settings: save, compare, restore
    Settings(Box<settings::SettingsArgs>),
    /// Lines typed by hand to a controller
    Console(Box<console::ConsoleArgs>),
    /// Serves a simulated GRBL controller on a pseudo-terminal or a TCP socket, or replays recordings of a real one
    Controller(Box<controller::ControllerArgs>),
    /// The serial ports of this computer, and which look like a GRBL board
    Ports(ports::PortsArgs),
    /// What the reader understands of each controller's G-code, and what it refuses
    Dialects(dialects::DialectsArgs),
    /// The G-code dialects: list, show, check and begin your own
    Posts(posts::PostsArgs),
    /// Machines: listed, shown, checked, begun anew
    Machines(machines::MachinesArgs),
}

/// Why a command ended badly.
#[derive(Debug)]
pub enum Failure {
    /// The program or job is not acceptable: exit 1.
    Rejected(String),
    /// The command could not be carried out: exit 2.
    Failed(String),
}

impl Failure {
    /// A command that could not be carried out, with its reason.
    pub fn failed(e: impl std::fmt::Display) -> Failure {
        Failure::Failed(e.to_string())
    }
}

/// Runs the program.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    if cli.threads > 0
        && let Err(e) = rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(cli.threads))
            .build_global()
    {
        output::say(&format!(
            "morsemill: {} threads cannot be started: {e}",
            cli.threads
        ));
        return ExitCode::from(2);
    }
    sources::hand_in();
    let outcome = match cli.command {
        Command::Mill(a) => mill::run(&a),
        Command::Features(a) => features::run(&a),
        Command::Check(a) => check::run(&a),
        Command::Post(a) => post::run(&a),
        Command::Translate(a) => translate::run(&a),
        Command::Send(a) => Ok(ExitCode::from(send::run(&a, &mut std::io::stdout()))),
        Command::Home(a) => home::run(&a),
        Command::Unlock(a) => unlock::run(&a),
        Command::Jog(a) => jog::run(&a),
        Command::Zero(a) => zero::run(&a),
        Command::Probe(a) => probe::run(&a),
        Command::Settings(a) => settings::run(&a),
        Command::Console(a) => console::run(&a),
        Command::Controller(a) => Ok(ExitCode::from(controller::run(&a, &mut std::io::stdout()))),
        Command::Ports(a) => Ok(ExitCode::from(ports::run(&a, &mut std::io::stdout()))),
        Command::Dialects(a) => dialects::run(&a),
        Command::Posts(a) => posts::run(&a),
        Command::Machines(a) => machines::run(&a),
    };
    match outcome {
        Ok(code) => code,
        Err(Failure::Rejected(text)) => {
            output::say(&format!("morsemill: {text}"));
            ExitCode::from(1)
        }
        Err(Failure::Failed(text)) => {
            output::say(&format!("morsemill: {text}"));
            ExitCode::from(2)
        }
    }
}
