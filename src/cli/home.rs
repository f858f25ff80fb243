//! `morsemill home`: the homing cycle.

use super::Failure;
use super::errand::{ConnectArgs, NoDetails, SimBench, finish, place, tell};
use crate::link::errand::Home;
use std::process::ExitCode;

/// Arguments of `morsemill home`.
#[derive(Clone, Debug, clap::Args)]
pub struct HomeArgs {
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

/// Homes. A controller that is mute after a limit alarm is reset first.
pub fn run(args: &HomeArgs) -> Result<ExitCode, Failure> {
    let done = args
        .connect
        .open(SimBench::Homing)?
        .perform_aloud(Home::default());
    if let Some(p) = done.task.position {
        tell(&format!("homed: machine {}", place(p)))?;
    }
    finish("home", args.connect.json.as_ref(), &done, NoDetails {})
}
