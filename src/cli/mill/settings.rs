//! The settings of a job, checked: the machine, the post, what to plan, how to link, what the program's head says.

use super::args::{MillArgs, StockArg};
use crate::cldata::{Coolant, Job};
use crate::cli::Failure;
use crate::cli::args::above_zero;
use crate::cli::output::say;
use crate::machine::Machine;
use crate::part::Placement;
use crate::post::Post;
use crate::toolpath::plan::Plan;
use crate::toolpath::{FILL_START, Ground, LinkOptions, PlanOptions, RETRACT_WORTH};
use crate::units::{MmPerMin, Rpm, Seconds};

/// Air between ball and stock in rapid moves, mm.
const CLEARANCE: f64 = 0.5;
/// Height of XY rapids above the top of the stock, mm.
const SAFE_ABOVE: f64 = 5.0;

/// The checked settings of a job.
pub(super) struct Settings {
    pub machine: Machine,
    pub post: Post,
    pub plan: PlanOptions,
    pub speed: Rpm,
}

/// Checks the arguments that no single flag can check, loads machine and post.
pub(super) fn settle(a: &MillArgs) -> Result<Settings, Failure> {
    a.tool.check()?;
    above_zero("--feed", a.feed, "mm/min")?;
    above_zero("--plunge", a.plunge, "mm/min")?;
    if let Some(g) = a.grid {
        above_zero("--grid", g, "mm")?;
        if g > a.tool.tool.radius {
            return Err(Failure::Failed(format!(
                "--grid {g}: must be below the ball's radius of {} mm",
                a.tool.tool.radius
            )));
        }
    }
    if let Some(p) = a.persistence {
        above_zero("--persistence", p, a.function.function().unit())?;
    }
    if let Some(angle) = a.angle
        && !angle.is_finite()
    {
        return Err(Failure::Failed(format!(
            "--angle {angle}: must be a number of degrees"
        )));
    }
    if !(30.0..=90.0).contains(&a.wall_angle) {
        return Err(Failure::Failed(format!(
            "--wall-angle {}: must be between 30 and 90 degrees from the horizontal",
            a.wall_angle
        )));
    }
    if let Some(z) = a.floor.filter(|z| !z.is_finite()) {
        return Err(Failure::Failed(format!(
            "--floor {z}: must be a height in mm"
        )));
    }
    let mut machine = crate::cli::sources::machine(&a.machine).map_err(Failure::failed)?;
    crate::cli::controller::apply_settings(a.settings.as_deref(), &mut machine)?;
    let post = crate::cli::sources::post(a.post.as_deref().unwrap_or(&machine.post))
        .map_err(Failure::failed)?;
    let [lowest, highest] = machine.spindle;
    let speed = a.speed.unwrap_or(highest.0.min(18000.0));
    if !(speed.is_finite() && speed >= 0.0) {
        return Err(Failure::Failed(format!(
            "--speed {speed}: must be a number of revolutions per minute, or 0"
        )));
    }
    if speed > 0.0 && (speed > highest.0 || speed < lowest.0) {
        return Err(Failure::Rejected(format!(
            "--speed {speed}: the spindle of {} turns {} to {} rpm",
            machine.name, lowest.0, highest.0
        )));
    }
    for (k, (axis, rate)) in ["X", "Y", "Z"].iter().zip(machine.max_rate).enumerate() {
        let (flag, v) = if k < 2 {
            ("--feed", a.feed)
        } else {
            ("--plunge", a.plunge)
        };
        if v > rate.0 {
            say(&format!(
                "note: {flag} {v}: axis {axis} of {} moves at most {} mm/min and will hold the tool back there",
                machine.name, rate.0
            ));
        }
    }
    let plan = PlanOptions {
        scallop: a.tool.scallop,
        strategy: a.strategy.with_angle(a.angle),
        grid_step: a.grid,
        function: a.function.function(),
        persistence: a.persistence,
        memory_limit_bytes: a.memory.saturating_mul(1 << 20),
        wall_angle: a.wall_angle,
        floor: a.floor,
        flute: a.tool.tool.flute_length(),
        deepest: match a.stock {
            StockArg::Allowance(_) => f64::INFINITY,
            // Into the full block: no deeper than the tool is thick.
            StockArg::Block => 2.0 * a.tool.tool.radius,
        },
    };
    Ok(Settings {
        machine,
        post,
        plan,
        speed: Rpm(speed),
    })
}

/// Refuses a part that the axes cannot span, before any work is done.
pub(super) fn fits(placement: &Placement, radius: f64, machine: &Machine) -> Result<(), Failure> {
    let size = placement.mesh.bounds().size();
    // The tip goes at most a radius beyond the outline on either side, but need not on a flat part: only what is sure is refused
    // here, the dry run knows the rest.
    for (k, axis) in ["X", "Y", "Z"].iter().enumerate() {
        let (need, have) = (size[k], machine.travel[k].0);
        if need > have {
            return Err(Failure::Rejected(format!(
                "the part is {need:.1} mm along {axis}, the machine {} travels {have} mm there (and a ball of radius {radius} mm needs room \
                 beside it): turn the part with --up, check --units, or take a larger machine",
                machine.name
            )));
        }
    }
    Ok(())
}

/// What this machine, over this stock, makes of links.
pub(super) fn link_options(a: &MillArgs, s: &Settings, placement: &Placement) -> LinkOptions {
    let m = &s.machine;
    let top = placement.mesh.bounds().max.z;
    let (allowance, block) = match a.stock {
        StockArg::Allowance(mm) => (mm, f64::NEG_INFINITY),
        StockArg::Block => (0.0, top + a.tool.tool.radius),
    };
    LinkOptions {
        feed: a.feed / 60.0,
        plunge: a.plunge / 60.0,
        rapid_xy: m.max_rate[0].mm_per_s().min(m.max_rate[1].mm_per_s()),
        rapid_z: m.max_rate[2].mm_per_s(),
        acceleration: m
            .acceleration
            .iter()
            .map(|v| v.0)
            .fold(f64::INFINITY, f64::min),
        allowance,
        clearance: CLEARANCE,
        block_center_z: block,
        safe_center_z: top + allowance + SAFE_ABOVE + a.tool.tool.radius,
        retract_center_z: f64::NEG_INFINITY,
        retract_worth: RETRACT_WORTH,
        vertical: m.acceleration[2].0,
    }
}

/// What stands in the program beside its moves: head, feeds, spindle.
pub(super) fn job(
    a: &MillArgs,
    s: &Settings,
    placement: &Placement,
    ground: &Ground,
    planned: &Plan,
) -> Job {
    let b = placement.mesh.bounds();
    let name = a
        .part
        .file_name()
        .map(|n| n.to_string_lossy().into_owned())
        .unwrap_or_default();
    let f = &planned.fitting;
    let um = 1e3;
    let header = vec![
        format!("morsemill {} part {name}", env!("CARGO_PKG_VERSION")),
        format!(
            "part X {:.3} to {:.3} Y {:.3} to {:.3} Z {:.3} to {:.3} mm",
            b.min.x, b.max.x, b.min.y, b.max.y, b.min.z, b.max.z
        ),
        format!(
            "tool ball end mill {} mm, Z is its tip",
            2.0 * a.tool.tool.radius
        ),
        match a.stock {
            StockArg::Allowance(mm) => {
                format!("stock assumed at most {mm} mm over the finished surface")
            }
            StockArg::Block => format!("stock assumed a block up to Z {:.3}", b.max.z),
        },
        format!(
            "strategy {} scallop {} mm",
            planned.layout.name(),
            a.tool.scallop
        ),
        format!("machine {} post {}", s.machine.name, s.post.name),
        format!(
            "error budget um: chord gouge {:.1} chord stock {:.1} sideways {:.1} rounding {:.2} facets are the file's",
            f.gouge * um,
            f.stock * um,
            f.sideways * um,
            s.post.rounding().0 * um
        ),
        format!(
            "cusps planned at {:.1} um, grid step {:.3} mm, filled where over {:.1} um",
            planned.spaced_for * um,
            ground.grid.step,
            FILL_START * a.tool.scallop * um
        ),
    ];
    Job {
        header,
        feed: MmPerMin(a.feed),
        plunge: MmPerMin(a.plunge),
        speed: s.speed,
        tool_number: 1,
        spin_up: Seconds(if s.speed.0 > 0.0 { 4.0 } else { 0.0 }),
        coolant: Coolant::Off,
        path_tolerance: None,
    }
}
