//! Where to enter: the start of a motion, some way before the zone that may have been cut.

use super::refusal::Refusal;
use super::walk::{Program, Walk};
use crate::gcode::{Event, Motion, MotionKind, MotionMode, State, interpret_line};
use std::collections::VecDeque;

/// How far back to go over ground that is cut already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Overlap {
    /// So much of the cut path, mm.
    Mm(f64),
    /// So many lines that move.
    Lines(usize),
    /// Not at all: the first line that moves, from the one asked for on.
    Nothing,
}

/// The most lines that move an overlap goes back over: it must fit the memory.
const MOST_BACK: usize = 100_000;

/// Where a program is entered.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// First line of the program that is sent again.
    pub line: usize,
    /// That line.
    pub text: String,
    /// What the machine remembers before it, in the straight run.
    pub state: State,
    /// Cut path from here to the first line asked for, mm: what is gone over twice for certain.
    pub overlap_mm: f64,
    /// The tool last named before it.
    pub tool: Option<u32>,
    /// The slowest feed (G94) of the program up to here, mm/min.
    pub slowest: Option<f64>,
}

struct Candidate {
    entry: Entry,
    /// Cut path up to its start, mm.
    path: f64,
    /// Lines that move up to it.
    moves: usize,
}

/// The entry for a job whose first line that may not be cut is `first`.
///
/// The overlap ends at a tool change (what was cut with another tool is not to be cut again with this one) and at the beginning of the
/// program.
///
/// # Errors
/// The program does not read; it probes before the entry; nothing moves from there on.
pub fn entry(program: &Program, first: usize, overlap: Overlap) -> Result<Entry, Refusal> {
    let mut walk = program.walk();
    let mut back: VecDeque<Candidate> = VecDeque::new();
    let (mut path, mut moves, mut slowest) = (0.0, 0, None::<f64>);
    let far_enough = |c: &Candidate, path: f64, moves: usize| match overlap {
        Overlap::Mm(mm) => path - c.path >= mm,
        Overlap::Lines(n) => moves - c.moves >= n,
        Overlap::Nothing => true,
    };
    loop {
        let before = walk.state().clone();
        let Some(step) = walk.step() else { break };
        let line = step.map_err(Refusal::Unreadable)?;
        if overlap == Overlap::Nothing {
            back.retain(|c| c.entry.line >= first);
        }
        if line >= first && !back.is_empty() && (line > first || !moves_at_all(&walk)) {
            break;
        }
        if walk.changed_tool() {
            back.clear();
        }
        if walk
            .events()
            .iter()
            .any(|e| matches!(e, Event::Probe { .. }))
        {
            return Err(Refusal::Probes { line });
        }
        if !moves_at_all(&walk) {
            continue;
        }
        if can_enter(&before, &walk) {
            back.push_back(Candidate {
                entry: Entry {
                    line,
                    text: walk.text().trim().to_string(),
                    state: before,
                    overlap_mm: 0.0,
                    tool: walk.tool(),
                    slowest,
                },
                path,
                moves,
            });
        }
        // The nearest that is far enough behind this line's start.
        while back.len() > 1
            && (back.get(1).is_some_and(|c| far_enough(c, path, moves)) || back.len() > MOST_BACK)
        {
            back.pop_front();
        }
        if line >= first && !back.is_empty() && overlap != Overlap::Nothing {
            break;
        }
        for m in motions(walk.events()) {
            if m.kind == MotionKind::Feed {
                path += length(m);
                if !m.inverse_time && m.feed.0 > 0.0 {
                    slowest = Some(slowest.map_or(m.feed.0, |s| s.min(m.feed.0)));
                }
            }
        }
        moves += 1;
    }
    let found = back.pop_front().ok_or(Refusal::NoEntry { line: first })?;
    let overlap_mm = match found.entry.line < first {
        true => path - found.path,
        false => 0.0,
    };
    Ok(Entry {
        overlap_mm,
        ..found.entry
    })
}

fn motions(events: &[Event]) -> impl Iterator<Item = &Motion> {
    events.iter().filter_map(|e| match e {
        Event::Motion(m) => Some(m),
        _ => None,
    })
}

fn moves_at_all(walk: &Walk) -> bool {
    motions(walk.events()).next().is_some()
}

/// Length of a motion's path, mm.
pub(super) fn length(m: &Motion) -> f64 {
    let Some(arc) = &m.arc else {
        return (m.to - m.from).norm();
    };
    let [a, b, n] = arc.plane.axes();
    let radius = (m.from[a] - arc.center[a]).hypot(m.from[b] - arc.center[b]);
    (radius * arc.sweep).hypot(m.to[n] - m.from[n])
}

/// True for a line that can be the first: it makes the same motion from the same place behind the way in, which leaves the modes of `before`
/// but for arcs. G2 and G3 cannot be set without cutting one, so a line that relies on them is none.
fn can_enter(before: &State, walk: &Walk) -> bool {
    // To go where the machine's own coordinates or a stored place lead is no way into a cut.
    if motions(walk.events()).any(|m| m.machine_coordinates) {
        return false;
    }
    // A change of tool belongs before the way in; a line that also changes offsets does not begin where the state before it says.
    if walk.changed_tool()
        || walk
            .events()
            .iter()
            .any(|e| matches!(e, Event::Sync { .. }))
    {
        return false;
    }
    if matches!(before.motion, MotionMode::Rapid | MotionMode::Linear) {
        return true;
    }
    let mut state = State {
        motion: MotionMode::None,
        ..before.clone()
    };
    let mut events = Vec::new();
    let line = walk.events().first().map_or(0, Event::line);
    interpret_line(&mut state, walk.content(), line, &mut events).is_ok()
        && events == walk.events()
        && state == *walk.state()
}
