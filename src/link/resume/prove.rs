//! The proof: the resumed program, read again from its first line as the controller will read it, has the state of the straight run at its
//! entry and does the same from there to the end.

use super::entry::{Entry, length};
use super::refusal::Refusal;
use super::walk::{Program, fresh, measured};
use crate::gcode::{Event, FeedMode, Motion, MotionKind, MotionMode, State, interpret_line};
use crate::link::journal::Offsets;

/// Rounding of the words of the way in, mm: they have five decimals.
const ROUNDING: f64 = 3e-5;

/// What was compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Proof {
    /// Lines of the program, from the entry to the end.
    pub lines: usize,
    /// Cut path of the straight run from the entry to the end, mm; the resumed program's is the same.
    pub cut_mm: f64,
    /// Farthest that a place of the resumed program lies from the straight run's, mm.
    pub deviation_mm: f64,
}

/// Compares the program that begins with `head` and goes on with `entry` against the straight run. The controller has these stored
/// `offsets` and stands at `machine`.
///
/// # Errors
/// The first difference.
pub fn prove(
    program: &Program,
    entry: &Entry,
    head: &[String],
    offsets: &Offsets,
    machine: &[f64; 3],
) -> Result<Proof, Refusal> {
    let changes = program.changes;
    let unproven = |line: usize, what: &str| Refusal::Unproven {
        line,
        what: what.to_string(),
    };
    // The session resets: G92 and tool length are gone.
    let reset = Offsets {
        g92: [0.0; 3],
        tlo: 0.0,
        ..*offsets
    };
    let mut resumed = fresh(program.start.dialect, &reset, machine);
    let mut events = Vec::new();
    for line in head {
        if let Err(e) = interpret_line(&mut resumed, line, 0, &mut events) {
            return Err(unproven(0, &format!("`{line}`: {e}")));
        }
    }
    same_state(&entry.state, &resumed).map_err(|what| unproven(entry.line, what))?;
    if matches!(entry.state.motion, MotionMode::Rapid | MotionMode::Linear)
        && resumed.motion != entry.state.motion
    {
        return Err(unproven(entry.line, "motion mode"));
    }

    let mut straight = program.walk();
    let mut proof = Proof::default();
    while let Some(step) = straight.step() {
        let line = step.map_err(Refusal::Unreadable)?;
        if line < entry.line {
            continue;
        }
        events.clear();
        if !straight.content().is_empty()
            && let Err(e) = interpret_line(&mut resumed, straight.content(), line, &mut events)
        {
            return Err(unproven(line, &e.to_string()));
        }
        if straight.changed_tool() {
            resumed.spindle = 0;
        }
        let change = changes.iter().rev().find(|c| c.line == line);
        if let Some(offsets) = change.and_then(|c| c.offsets) {
            measured(&mut resumed, &offsets);
        }
        if events.len() != straight.events().len() {
            return Err(unproven(line, "it does more or less"));
        }
        for (a, b) in straight.events().iter().zip(&events) {
            let deviation = same_event(a, b).map_err(|what| unproven(line, what))?;
            proof.deviation_mm = proof.deviation_mm.max(deviation);
            if let Event::Motion(m) = a
                && m.kind == MotionKind::Feed
            {
                proof.cut_mm += length(m);
            }
        }
        proof.lines += 1;
    }
    if proof.lines == 0 {
        return Err(unproven(entry.line, "the line is not there"));
    }
    Ok(proof)
}

/// The states before the entry agree in all but the motion mode and T, which GRBL forgets with each line.
fn same_state(a: &State, b: &State) -> Result<(), &'static str> {
    let near = |a: f64, b: f64| (a - b).abs() <= ROUNDING + 1e-9 * a.abs();
    let rules = [
        (a.plane == b.plane, "plane"),
        (a.distance == b.distance, "G90 or G91"),
        (a.arc_distance == b.arc_distance, "arc centres"),
        (a.feed_mode == b.feed_mode, "feed mode"),
        (a.units == b.units, "units"),
        (a.work_offset == b.work_offset, "work offset"),
        (a.spindle == b.spindle, "spindle"),
        (near(a.speed.0, b.speed.0), "spindle speed"),
        ((a.flood, a.mist) == (b.flood, b.mist), "coolant"),
        (near(a.tlo, b.tlo), "tool length"),
        ((0..3).all(|i| near(a.g92[i], b.g92[i])), "G92"),
        ((0..3).all(|i| near(a.position[i], b.position[i])), "place"),
        // In G93 every block has its own F.
        (
            a.feed_mode == FeedMode::InverseTime || same_feed(a.feed.0, b.feed.0),
            "feed",
        ),
    ];
    match rules.iter().find(|r| !r.0) {
        Some((_, what)) => Err(what),
        None => Ok(()),
    }
}

/// How far two events' places differ, mm.
fn same_event(a: &Event, b: &Event) -> Result<f64, &'static str> {
    let (a, b) = match (a, b) {
        (Event::Motion(a), Event::Motion(b)) => (a, b),
        (Event::Probe { motion: a, .. }, Event::Probe { motion: b, .. }) => (a, b),
        (Event::Spindle { .. }, Event::Spindle { .. }) if a == b => return Ok(0.0),
        _ if a == b => return Ok(0.0),
        _ => return Err("it does something else"),
    };
    same_motion(a, b)
}

/// Feeds agree as far as the eight digits that GRBL reads of a number can tell: one in inch written anew in mm has more.
fn same_feed(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING + 1e-7 * a.abs()
}

fn same_motion(a: &Motion, b: &Motion) -> Result<f64, &'static str> {
    let mut deviation = (a.from - b.from).norm().max((a.to - b.to).norm());
    if a.kind != b.kind
        || a.inverse_time != b.inverse_time
        || a.machine_coordinates != b.machine_coordinates
        || !same_feed(a.feed.0, b.feed.0)
    {
        return Err("another feed or kind of motion");
    }
    match (&a.arc, &b.arc) {
        (None, None) => {}
        (Some(p), Some(q)) if p.plane == q.plane && p.clockwise == q.clockwise => {
            deviation = deviation.max((p.center - q.center).norm());
            // A whole circle must not become none.
            if (p.sweep - q.sweep).abs() > 1.0 {
                return Err("an arc of another turn");
            }
        }
        _ => return Err("an arc of another kind"),
    }
    // The centre of an arc by radius answers to a shift of its ends with a multiple of it.
    let limit = match a.arc {
        Some(_) => 100.0 * ROUNDING,
        None => 2.0 * ROUNDING,
    };
    match deviation <= limit {
        true => Ok(deviation),
        false => Err("another place"),
    }
}
