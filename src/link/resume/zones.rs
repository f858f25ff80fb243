//! The three zones: surely cut, maybe cut, not sent. The drawing stands in the head of [`super`].

use super::blocks::Counter;
use super::check::{NEAR, near_way};
use super::refusal::Refusal;
use super::text::ProgramText;
use super::walk::{Program, sent, unreadable};
use crate::gcode::Event;
use crate::gcode::source::Source;
use crate::geom::Point;
use crate::link::journal::{Begin, Damage, Doubt, History, SYNC_GAP};
use std::collections::VecDeque;

/// Slices of motion that a firmware prepares beyond its planner, each of another block at worst: GRBL 1.1 has 5 usable and one that runs.
const SLICES_GRBL: usize = 6;
/// The same for the others, whose builds differ (grblHAL 10, FluidNC up to 12).
const SLICES_OTHER: usize = 16;

/// Lines by what became of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Zones {
    /// First line that may not have been cut: all before it surely are.
    pub first: usize,
    /// Last line that may have been cut: all behind it surely are not.
    pub last: usize,
    /// Lines of the program.
    pub lines: usize,
}

impl Zones {
    /// True for a line that may have been cut, in part or whole, or may not.
    pub fn is_maybe(&self, line: usize) -> bool {
        (self.first..=self.last).contains(&line)
    }
}

/// Blocks that a controller can hold answered and not yet run.
pub(super) fn held(begin: &Begin) -> usize {
    begin.planner_blocks
        + match is_grbl(begin) {
            true => SLICES_GRBL,
            false => SLICES_OTHER,
        }
}

fn is_grbl(begin: &Begin) -> bool {
    begin.dialect == "grbl"
}

/// Where a job was broken. `boot` is this computer's boot now, as in [`Begin::boot`].
///
/// # Errors
/// The program cannot be read (then it is not the one that was sent), or nothing was sent.
pub fn zones<T: ProgramText + ?Sized>(
    text: &T,
    begin: &Begin,
    history: &History,
    boot: Option<&str>,
) -> Result<Zones, Refusal> {
    let text: &dyn ProgramText = &text;
    let entry = begin.resumed.map_or(1, |r| r.entry);
    let sent = history.sent.max(history.acknowledged);
    let mut last = match (&history.end, &history.damage) {
        (_, Damage::Broken { .. }) => begin.lines,
        (Some(_), _) => sent,
        (None, _) => sent.max(history.allowed),
    };
    if may_lack_the_last(begin, history, boot) {
        last = behind_the_gap(text, begin, last)?;
    }
    if last == 0 && begin.resumed.is_none() {
        return Err(Refusal::NothingSent);
    }
    let counted = surely_cut(text, begin, history, history.acknowledged)?;
    let last = last
        .max(begin.resumed.map_or(0, |r| r.maybe_to))
        .min(begin.lines);
    let first = seen_on(text, begin, history, counted, last)?
        .min(history.acknowledged)
        .max(entry)
        .max(1);
    Ok(Zones {
        first,
        last: last.max(first),
        lines: begin.lines,
    })
}

/// True when the computer may have lost its power before its disk had the journal's last records. `boot` is its boot now.
pub fn may_lack_the_last(begin: &Begin, history: &History, boot: Option<&str>) -> bool {
    let same_boot = boot.is_some() && begin.boot.as_deref() == boot;
    history.end.is_none() && (!same_boot || matches!(history.damage, Damage::Zeros { .. }))
}

/// The first line that was refused: it was dropped whole, whatever was answered behind it.
fn refused(history: &History) -> usize {
    let lines = history.doubts.iter().filter_map(|d| match d {
        Doubt::Refused { line, .. } if *line > 0 => Some(*line),
        _ => None,
    });
    lines.min().unwrap_or(usize::MAX)
}

/// The last line that may have been sent while the disk was behind.
fn behind_the_gap(text: &dyn ProgramText, begin: &Begin, last: usize) -> Result<usize, Refusal> {
    let mut bytes = begin.bytes_per_s.max(0.0) * SYNC_GAP + 2.0 * begin.rx_bytes as f64;
    let mut end = last;
    let unread = |e: std::io::Error| Refusal::Unreadable(unreadable(last, e.kind()));
    let mut lines = text.open_text().and_then(Source::new).map_err(unread)?;
    while let Some((line, text)) = lines.read().map_err(unread)? {
        if line <= last {
            continue;
        }
        let significant = sent(text, begin.skips_slashed).content.len();
        if significant > 0 {
            bytes -= significant as f64 + 1.0;
        }
        end = line;
        if bytes < 0.0 {
            break;
        }
    }
    Ok(end)
}

/// The first line that may not have been cut by `counted` answers, corrected by where the machine was seen last: bytes that a cable makes
/// up (a line end that arrives twice is a line more, and answered) let the answers run ahead of the lines. A place that is on the way of no
/// line from `counted` on, but on that of an earlier one, belongs to the last such line; where the cable is known to be bad, to the first of
/// those that are not long ago, for the way may cross itself. A place beside the way says nothing: [`super::check`] sees to it.
fn seen_on(
    text: &dyn ProgramText,
    begin: &Begin,
    history: &History,
    counted: usize,
    last: usize,
) -> Result<usize, Refusal> {
    let Some(seen) = &history.seen else {
        return Ok(counted);
    };
    // Lines that were answered since it was seen were not under way then.
    let then = match seen.acknowledged < history.acknowledged {
        true => surely_cut(text, begin, history, seen.acknowledged)?,
        false => counted,
    };
    let place = Point::from(seen.machine);
    let entry = begin.resumed.map_or(1, |r| r.entry);
    let back = match history.cable_sound {
        true => 0,
        false => held(begin) + begin.rx_bytes / SHORT_LINE,
    };
    let mut walk = Program::of(text, history, begin).walk();
    let (mut before, mut recent, mut inside) = (None, None, false);
    while let Some(step) = walk.step() {
        let line = step.map_err(Refusal::Unreadable)?;
        if line > last || (inside && line >= then) {
            break;
        }
        if walk.changed_tool() {
            if line == history.acknowledged {
                // It waits there, and the operator may drive it anywhere.
                return Ok(counted);
            }
            // Whatever was answered by then, all was over when the operator went on.
            (before, recent) = (None, None);
        }
        if line < entry || near_way(&walk, &place) > NEAR {
            continue;
        }
        match line < then {
            true => {
                before = Some(line);
                if line + back >= then {
                    recent = recent.or(Some(line));
                }
            }
            false => inside = true,
        }
    }
    Ok(match (inside, recent, before) {
        (_, Some(line), _) if !history.cable_sound => line.min(counted),
        (false, _, Some(line)) => line.min(counted),
        _ => counted,
    })
}

/// Bytes of a short line: where answers are made up, so many more lines than the receive buffer could hold may be a line off.
const SHORT_LINE: usize = 4;

/// The first line, up to the last one answered, of which something may be queued still; the line behind it when nothing can be.
fn surely_cut(
    text: &dyn ProgramText,
    begin: &Begin,
    history: &History,
    acknowledged: usize,
) -> Result<usize, Refusal> {
    let counter = Counter::new(begin);
    let held = held(begin);
    let entry = begin.resumed.map_or(1, |r| r.entry);
    let laser = begin.settings.iter().any(|s| s.0 == 32 && s.1 != 0.0);
    // Lines of which blocks may be queued, oldest first, with their blocks.
    let mut queue: VecDeque<(usize, usize)> = VecDeque::new();
    let mut blocks = 0;
    // What stands in a refused line made nobody wait, and what was answered behind it may have been something else.
    let known = acknowledged.min(refused(history) - 1);
    let mut walk = Program::of(text, history, begin).walk();
    while let Some(step) = walk.step() {
        let line = step.map_err(Refusal::Unreadable)?;
        if line > known {
            break;
        }
        if line < entry {
            continue;
        }
        for event in walk.events() {
            let waits = match event {
                Event::Motion(m) => {
                    let more = counter.blocks(m);
                    match queue.back_mut() {
                        Some(last) if last.0 == line => last.1 += more,
                        _ => queue.push_back((line, more)),
                    }
                    blocks += more;
                    false
                }
                Event::Dwell { .. }
                | Event::Probe { .. }
                | Event::End { .. }
                | Event::ToolChange { .. } => true,
                Event::Pause { optional, .. } => !optional,
                // Laser mode changes the beam in passing, and other firmwares have their own ideas of what waits.
                Event::Spindle { .. } => is_grbl(begin) && !laser,
                // Coolant that is on already makes GRBL wait for nothing, and the operator may have switched it by a real-time byte.
                Event::Coolant { .. } => false,
                Event::Sync { .. } => is_grbl(begin),
            };
            if waits {
                queue.clear();
                blocks = 0;
            }
        }
        if walk.changed_tool() && history.tool_changes.iter().any(|c| c.line == line) {
            queue.clear();
            blocks = 0;
        }
        while let Some((_, front)) = queue.front().copied()
            && blocks - front >= held
        {
            blocks -= front;
            queue.pop_front();
        }
    }
    Ok(queue.front().map_or(known + 1, |q| q.0))
}
