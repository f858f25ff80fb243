//! `morsemill probe`: touches a plate below the tool and sets work Z by it.

use super::Failure;
use super::errand::{ConnectArgs, SimBench, finish, tell};
use crate::link::errand::{Probe, ProbeOptions};
use serde::Serialize;
use std::process::ExitCode;

/// Arguments of `morsemill probe`.
#[derive(Clone, Debug, clap::Args)]
pub struct ProbeArgs {
    /// Thickness of the plate, mm: the place of the touch gets this work Z
    #[arg(
        long,
        value_name = "MM",
        allow_negative_numbers = true,
        required_unless_present = "measure"
    )]
    pub plate: Option<f64>,
    /// How far down to look, mm
    #[arg(long, value_name = "MM", default_value_t = ProbeOptions::default().distance, allow_negative_numbers = true)]
    pub distance: f64,
    /// Feed of the first touch, mm/min
    #[arg(long, value_name = "FEED", default_value_t = ProbeOptions::default().feed, allow_negative_numbers = true)]
    pub feed: f64,
    /// Feed of the second touch, the one that counts, mm/min
    #[arg(long, value_name = "FEED", default_value_t = ProbeOptions::default().slow_feed, allow_negative_numbers = true)]
    pub slow_feed: f64,
    /// Way up between the touches, mm
    #[arg(long, value_name = "MM", default_value_t = ProbeOptions::default().lift, allow_negative_numbers = true)]
    pub lift: f64,
    /// Way up from the touch at the end, mm
    #[arg(long, value_name = "MM", default_value_t = ProbeOptions::default().retract, allow_negative_numbers = true)]
    pub retract: f64,
    /// Only measure: set nothing
    #[arg(long)]
    pub measure: bool,
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

#[derive(Serialize)]
struct Details {
    /// Machine Z where the slow touch was triggered.
    touch_machine_z_mm: Option<f64>,
    /// The quick touch less the slow one.
    touches_differ_mm: Option<f64>,
    /// Machine Z of work zero as read back; null when none was set.
    work_origin_z_mm: Option<f64>,
}

/// Probes.
pub fn run(args: &ProbeArgs) -> Result<ExitCode, Failure> {
    let options = ProbeOptions {
        distance: args.distance,
        feed: args.feed,
        slow_feed: args.slow_feed,
        lift: args.lift,
        plate: args.plate.unwrap_or(0.0),
        retract: args.retract,
        set_zero: !args.measure,
        ..ProbeOptions::default()
    };
    let done = args
        .connect
        .open(SimBench::Plate)?
        .perform_aloud(Probe::new(options));
    if let (Ok(()), Some(touch)) = (&done.result, done.task.touch) {
        let apart = touch.first - touch.second;
        tell(&format!(
            "touched at machine Z{:.3} (the touches differ by {apart:.3} mm)",
            touch.second + 0.0
        ))?;
        if let (Some(origin), Some(here)) = (done.task.origin, done.task.position) {
            tell(&format!(
                "work Z zero at machine Z{:.3}; the tool is at work Z{:.3}",
                origin + 0.0,
                here[2] + 0.0
            ))?;
        }
    }
    let details = Details {
        touch_machine_z_mm: done.task.touch.map(|t| t.second),
        touches_differ_mm: done.task.touch.map(|t| t.first - t.second),
        work_origin_z_mm: done.task.origin,
    };
    finish("probe", args.connect.json.as_ref(), &done, details)
}
