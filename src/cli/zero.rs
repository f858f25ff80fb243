//! `morsemill zero`: sets work zero where the tool stands, or goes there.

use super::Failure;
use super::errand::{ConnectArgs, NoDetails, SimBench, axis_words, finish, place, tell};
use crate::link::errand::{GoTo, Retract, Zero};
use serde::Serialize;
use std::process::ExitCode;

/// Arguments of `morsemill zero`.
#[derive(Clone, Debug, clap::Args)]
pub struct ZeroArgs {
    /// Axes to set to zero here, such as X Y; with a number, this place gets that coordinate: Z1.5
    #[arg(
        value_name = "AXIS",
        required_unless_present = "go",
        conflicts_with = "go"
    )]
    pub axes: Vec<String>,
    /// Set nothing, go there: up to the safe height, across to X0 Y0, down to the clearance
    #[arg(long)]
    pub go: bool,
    /// With --go: height of the way across, mm above work zero [default: the top of the machine's travel if it is known to be homed,
    /// else 10]
    #[arg(
        long,
        value_name = "MM",
        requires = "go",
        allow_negative_numbers = true
    )]
    pub safe_z: Option<f64>,
    /// With --go: cross at the top of the machine's travel or not at all (homed machine with soft limits)
    #[arg(long, requires = "go", conflicts_with = "safe_z")]
    pub machine_top: bool,
    /// With --go: where to stop above work zero, mm
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 5.0,
        allow_negative_numbers = true
    )]
    pub clearance: f64,
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

#[derive(Serialize)]
struct Details {
    /// Machine coordinates of the active work system's origin, as read back.
    work_origin_mm: Option<[f64; 3]>,
}

/// Sets zero (written and read back), or goes to it.
pub fn run(args: &ZeroArgs) -> Result<ExitCode, Failure> {
    if args.go {
        let retract = match args.machine_top {
            true => Retract::MachineTop,
            false => args
                .safe_z
                .map_or(Retract::TopOr(10.0_f64.max(args.clearance)), Retract::Work),
        };
        let task = GoTo::zero(retract, args.clearance);
        let done = args.connect.open(SimBench::Plain)?.perform_aloud(task);
        if let Some(p) = done.task.position {
            tell(&format!("at work {}", place(p)))?;
        }
        return finish("zero", args.connect.json.as_ref(), &done, NoDetails {});
    }
    let axes = axis_words(&args.axes, Some(0.0))?;
    let done = args
        .connect
        .open(SimBench::Plain)?
        .perform_aloud(Zero::new(axes));
    if let (Ok(()), Some(origin), Some(here)) = (&done.result, done.task.origin, done.task.position)
    {
        tell(&format!(
            "work zero at machine {}; the tool is at work {}",
            place(origin),
            place(here)
        ))?;
    }
    let work_origin_mm = done.task.origin;
    finish(
        "zero",
        args.connect.json.as_ref(),
        &done,
        Details { work_origin_mm },
    )
}
