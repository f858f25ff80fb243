//! Carrying out a block of words: modes first, then spindle and coolant, then the motion, then stops and ends ("Fundamentals", chapter
//! "M functions": M0, M1, M2, M17 and M30 act behind the motion).

use super::super::event::Plane;
use super::super::state::{Distance, FeedMode, MotionMode, PathMode, Units};
use super::arc::arc;
use super::block::Block;
use super::*;
use crate::geom::Point;
use crate::units::{MmPerMin, Rpm};

/// Checks the block and carries it out.
pub(super) fn carry_out(job: &mut Job, block: &Block) -> Said {
    if let Some((_, at)) = block.code(|c| c == 4) {
        dwell(job, block, at)?;
        return Ok(Flow::Next);
    }
    let moves = block.axes.iter().any(Option::is_some);
    if let Some(at) = block.assigns
        && (moves || !block.codes.is_empty() || !block.functions.is_empty())
    {
        let name = Name::of("an assignment to a variable");
        return wrong(at, Wrong::Alone { name });
    }
    modes(job, block)?;
    tool(job, block)?;
    spindle(job, block)?;
    if block.stop_preprocessing {
        job.desk.sync();
    }
    travel(job, block)?;
    stops(job, block)
}

/// `G4 F2.5`: seconds, in a block of its own; F keeps its value.
fn dwell(job: &mut Job, block: &Block, at: u32) -> Result<(), Fault> {
    let only = Block {
        feed: block.feed,
        speed: block.speed,
        codes: block.codes.iter().copied().filter(|c| c.0 == 4).collect(),
        ..Block::default()
    };
    if *block != only {
        let name = Name::of("G4");
        return wrong(at, Wrong::Alone { name });
    }
    if let Some((_, at)) = block.speed {
        return refuse(at, "G4 S", "write the time in seconds, G4 F");
    }
    let Some((seconds, at)) = block.feed else {
        return missing(at, "G4", "F with the seconds");
    };
    if !(0.0..=999_999.0).contains(&seconds) {
        return range(at, "G4 F", "seconds of zero or more");
    }
    job.desk.dwell(seconds);
    Ok(())
}

/// G codes that last, F, and how corners are taken.
fn modes(job: &mut Job, block: &Block) -> Result<(), Fault> {
    for &(code, _) in &block.codes {
        let state = &mut job.desk.state;
        match code {
            0 => state.motion = MotionMode::Rapid,
            1 => state.motion = MotionMode::Linear,
            2 => state.motion = MotionMode::ArcClockwise,
            3 => state.motion = MotionMode::ArcCounterclockwise,
            17 => state.plane = Plane::Xy,
            18 => state.plane = Plane::Zx,
            19 => state.plane = Plane::Yz,
            70 | 700 => {
                state.units = Units::Inch;
                job.modes.inch_feed = code == 700;
            }
            71 | 710 => {
                state.units = Units::Mm;
                job.modes.inch_feed = false;
            }
            90 => state.distance = Distance::Absolute,
            91 => state.distance = Distance::Incremental,
            93..=95 => {
                let kind = match code {
                    93 => FeedKind::Inverse,
                    94 => FeedKind::PerMinute,
                    _ => FeedKind::PerRevolution,
                };
                if kind != job.modes.feed_kind {
                    (job.modes.feed_kind, job.modes.feed) = (kind, 0.0);
                }
                state.feed_mode = match kind {
                    FeedKind::Inverse => FeedMode::InverseTime,
                    _ => FeedMode::PerMinute,
                };
            }
            60 | 64 | 641..=645 => job.modes.blending.code = code,
            54..=57 | 500 | 505..=599 => frame::settable(job, code),
            _ => {}
        }
    }
    feed_and_corners(job, block)
}

/// F and corners.
fn feed_and_corners(job: &mut Job, block: &Block) -> Result<(), Fault> {
    if let Some((feed, at)) = block.feed {
        if feed < 0.0 || !feed.is_finite() {
            return range(at, "F", "a feed of zero or more");
        }
        let unit = match (job.modes.inch_feed, job.modes.feed_kind) {
            (true, FeedKind::PerMinute | FeedKind::PerRevolution) => 25.4,
            _ => 1.0,
        };
        job.modes.feed = feed * unit;
    }
    let mm = job.mm();
    let blending = &mut job.modes.blending;
    let before = *blending;
    if let Some((adis, at)) = block.adis {
        if adis < 0.0 {
            return range(at, "ADIS", "a length of zero or more");
        }
        blending.adis = adis * mm;
    }
    if let Some((tolerance, _)) = block.tolerance {
        // A negative value gives the machine's own back.
        blending.tolerance = (tolerance >= 0.0).then_some(tolerance * mm);
    }
    if let Some(on) = block.compressor {
        blending.compressor = on;
    }
    if before != *blending || block.code(|c| matches!(c, 60 | 64 | 641..=645)).is_some() {
        job.desk.state.path = path_mode(&job.modes.blending);
    }
    Ok(())
}

/// What the settings of corners come to.
pub(super) fn path_mode(b: &Blending) -> PathMode {
    let tolerance = match b.code {
        60 => return PathMode::ExactStop,
        641 if !b.compressor => Some(b.adis),
        642..=645 => b.tolerance,
        _ if b.compressor => b.tolerance,
        _ => None,
    };
    PathMode::Blend { tolerance }
}

/// T, M6, D.
fn tool(job: &mut Job, block: &Block) -> Result<(), Fault> {
    if let Some((tool, _)) = block.tool {
        job.modes.chosen = Some(tool);
    }
    if let Some(&(_, at)) = block.functions.iter().find(|f| f.0 == 6) {
        let Some(tool) = job.modes.chosen else {
            return missing(at, "M6", "a T before it, in this block or an earlier one");
        };
        job.desk.tool(tool);
        // A new tool comes with its first cutting edge.
        job.modes.length_off = false;
        job.modes.moved_frame[2] = true;
        job.desk.state.tool_length = Some(1);
    }
    if let Some((edge, _)) = block.edge {
        let now = (edge > 0).then_some(edge);
        job.modes.moved_frame[2] |= now != job.desk.state.tool_length;
        job.modes.length_off = edge == 0;
        job.desk.state.tool_length = now;
    }
    Ok(())
}

/// S, M3 to M5, M7 to M9.
fn spindle(job: &mut Job, block: &Block) -> Result<(), Fault> {
    let has = |m: u32| block.functions.iter().any(|f| f.0 == m);
    let mut speed = job.desk.state.speed;
    if let Some((s, at)) = block.speed {
        if s < 0.0 || !s.is_finite() {
            return range(at, "S", "a speed of zero or more");
        }
        speed = Rpm(s);
    }
    let direction = if has(3) {
        1
    } else if has(4) {
        -1
    } else if has(5) {
        0
    } else {
        job.desk.state.spindle
    };
    job.desk.spindle(direction, speed);
    let (mut flood, mut mist) = (job.desk.state.flood, job.desk.state.mist);
    (flood, mist) = (flood || has(8), mist || has(7));
    if has(9) {
        (flood, mist) = (false, false);
    }
    job.desk.coolant(flood, mist);
    Ok(())
}

/// Behind the motion.
fn stops(job: &mut Job, block: &Block) -> Said {
    for &(m, at) in &block.functions {
        match m {
            0 | 1 => job.desk.pause(m == 1),
            2 | 30 => {
                if job.modes.depth > 0 {
                    let name = format!("M{m}");
                    return refuse(at, &name, "end a subprogram with M17 or RET");
                }
                job.desk.end();
                job.modes.over = true;
                return Ok(Flow::End);
            }
            17 => return Ok(program::returned(job)),
            _ => {}
        }
    }
    Ok(Flow::Next)
}

/// The block's motion.
fn travel(job: &mut Job, block: &Block) -> Result<(), Fault> {
    let motion = job.desk.state.motion;
    let circular = matches!(
        motion,
        MotionMode::ArcClockwise | MotionMode::ArcCounterclockwise
    );
    let moves = block.axes.iter().any(Option::is_some);
    let centered = block.center.iter().any(Option::is_some);
    if !(circular && (moves || centered)) {
        unused(block)?;
    }
    let goes = moves || (circular && centered);
    if !goes {
        return Ok(());
    }
    let at = block
        .axes
        .iter()
        .chain(&block.center)
        .flatten()
        .map(|c| c.at)
        .min()
        .unwrap_or_default();
    let suppressed = block.suppress || block.code(|c| matches!(c, 53 | 153)).is_some();
    let machine = suppressed || job.modes.no_offset;
    if machine && circular {
        return Err(Fault::at(at, Complaint::MachineNeedsStraight));
    }
    if let (Some(z), true, false) = (block.axes[2], job.modes.length_off, machine) {
        return wrong(z.at, Wrong::LengthOff);
    }
    let to = place(job, block, machine, suppressed)?;
    if motion == MotionMode::Rapid {
        job.desk.rapid(to, machine);
    } else {
        let arc = if circular {
            Some(arc(job, block, to, at)?)
        } else {
            None
        };
        let (to, arc) = arc.map_or((to, None), |(to, arc)| (to, Some(arc)));
        let feed = feed(job, block, at)?;
        job.desk.cut(to, arc, feed, machine);
    }
    if let Some(drilling) = job.modes.modal {
        cycle::run(job, &drilling, at)?;
    }
    Ok(())
}

/// The feed of a cut.
pub(super) fn feed(job: &mut Job, block: &Block, at: u32) -> Result<MmPerMin, Fault> {
    let kind = job.modes.feed_kind;
    let set = job.modes.feed > 0.0 && (kind != FeedKind::Inverse || block.feed.is_some());
    if !set {
        return Err(Fault::at(at, Complaint::FeedMissing));
    }
    let feed = match kind {
        FeedKind::PerRevolution => {
            let state = &job.desk.state;
            if state.spindle == 0 || state.speed.0 <= 0.0 {
                return missing(at, "G95", "a turning spindle (S and M3) before it cuts");
            }
            job.modes.feed * state.speed.0
        }
        _ => job.modes.feed,
    };
    job.desk.state.feed = MmPerMin(feed);
    Ok(MmPerMin(feed))
}

/// Words of arcs in a block without one.
fn unused(block: &Block) -> Result<(), Fault> {
    let center = block.center.iter().zip(["I", "J", "K"]);
    let center = center.filter_map(|(c, name)| c.map(|c| (name, c.at)));
    let others = [
        ("CR", block.radius),
        ("AR", block.angle),
        ("TURN", block.turns),
    ];
    let others = others.into_iter().filter_map(|(n, w)| w.map(|w| (n, w.1)));
    match center.chain(others).next() {
        Some((name, at)) => {
            let name = Name::of(name);
            wrong(at, Wrong::Unused { name })
        }
        None => Ok(()),
    }
}

/// Where the axis words lead, work coordinates.
fn place(job: &mut Job, block: &Block, machine: bool, suppressed: bool) -> Result<Point, Fault> {
    let mm = job.mm();
    let state = &job.desk.state;
    let mut to = match machine {
        true => state.machine_position(),
        false => state.position,
    };
    let modal = state.distance == Distance::Incremental;
    for (axis, c) in block.axes.iter().enumerate() {
        if let Some(c) = c {
            let value = c.value * mm;
            let incremental = c.incremental.unwrap_or(modal);
            if incremental && job.modes.moved_frame[axis] {
                let name = Name::of(["X", "Y", "Z"][axis]);
                return wrong(c.at, Wrong::FrameMoved { name });
            }
            if incremental && suppressed {
                return refuse(
                    c.at,
                    "G53 or SUPA with G91 or IC",
                    "write them absolute, with G90 or AC()",
                );
            }
            job.modes.moved_frame[axis] = suppressed;
            to[axis] = match (incremental, suppressed) {
                (true, _) => to[axis] + value,
                (_, true) => value,
                (_, false) => job.modes.shift[axis] + value,
            };
        }
    }
    if machine {
        let work = state.work_of_machine(&to);
        for (axis, c) in block.axes.iter().enumerate() {
            // To the last bit: what is not named stays.
            to[axis] = match c {
                Some(_) => work[axis],
                None => state.position[axis],
            };
        }
    }
    Ok(to)
}
