//! `morsemill jog`: one jog, to its end or to Ctrl-C.

use super::Failure;
use super::errand::{ConnectArgs, NoDetails, SimBench, axis_words, finish, place, tell};
use crate::link::errand::{Jog, JogMove, JogUnits, Reach};
use std::process::ExitCode;

/// What a jog's numbers count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum From {
    /// Where the tool is
    Here,
    /// Work zero
    Work,
    /// Machine zero
    Machine,
}

/// Arguments of `morsemill jog`.
#[derive(Clone, Debug, clap::Args)]
pub struct JogArgs {
    /// Axes with distances or targets, such as X10 Z-2.5
    #[arg(required = true, value_name = "AXIS")]
    pub axes: Vec<String>,
    /// mm/min, or inch/min with --inch
    #[arg(long, value_name = "FEED", allow_negative_numbers = true)]
    pub feed: f64,
    /// What the numbers count from
    #[arg(long, value_enum, default_value = "here")]
    pub from: From,
    /// Numbers and feed are in inch
    #[arg(long)]
    pub inch: bool,
    /// Which controller
    #[command(flatten)]
    pub connect: ConnectArgs,
}

/// Jogs. Refused before it starts when it would leave the travel of a machine known to be homed.
pub fn run(args: &JogArgs) -> Result<ExitCode, Failure> {
    let jog = JogMove {
        axes: axis_words(&args.axes, None)?,
        feed: args.feed,
        units: if args.inch {
            JogUnits::Inch
        } else {
            JogUnits::Mm
        },
        reach: match args.from {
            From::Here => Reach::Relative,
            From::Work => Reach::Work,
            From::Machine => Reach::Machine,
        },
    };
    // Wrong numbers are known without a machine.
    jog.line().map_err(Failure::failed)?;
    let done = args
        .connect
        .open(SimBench::Plain)?
        .perform_aloud(Jog::new(vec![jog]));
    if let Some((machine, work)) = done.task.ended {
        let work = work.map_or(String::new(), |w| format!(", work {}", place(w)));
        tell(&format!("at machine {}{work}", place(machine)))?;
    }
    finish("jog", args.connect.json.as_ref(), &done, NoDetails {})
}
