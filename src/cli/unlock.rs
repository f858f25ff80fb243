//! `morsemill unlock`: ends the lock of an alarm.

use super::Failure;
use super::errand::{ConnectArgs, SimBench, finish, tell};
use crate::link::errand::Unlock;
use serde::Serialize;
use std::process::ExitCode;

/// Arguments of `morsemill unlock`.
#[derive(Clone, Debug, clap::Args)]
pub struct UnlockArgs {
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

#[derive(Serialize)]
struct Details {
    /// It was locked, and is not any more.
    unlocked: bool,
}

/// Unlocks. A controller that is mute after a limit alarm is reset first.
pub fn run(args: &UnlockArgs) -> Result<ExitCode, Failure> {
    let done = args
        .connect
        .open(SimBench::Homing)?
        .perform_aloud(Unlock::default());
    if done.result.is_ok() {
        tell(if done.task.unlocked {
            "unlocked"
        } else {
            "not locked"
        })?;
    }
    let unlocked = done.task.unlocked;
    finish(
        "unlock",
        args.connect.json.as_ref(),
        &done,
        Details { unlocked },
    )
}
