//! What must hold, whatever goes wrong; the letters are those of the head of [`super`].

use super::again::{again, would_go_on};
use super::bench::Ran;
use super::case::{Case, Verdict};
use super::faults::Class;
use super::follow::{ALONG, follow, lengths, way_of};
use super::jobs::{Corner, START, way};
use morsemill::geom::Point;
use morsemill::link::journal::{Doubt, History, SYNC_GAP, read};
use morsemill::link::resume::{Refusal, Zones, zones};
use morsemill::link::{Ending, Outcome};

/// A reset puts the axes on whole steps, mm.
const STEP: f64 = 0.005;
/// What a GRBL holds of answered lines: planner blocks and slices, each of another block at worst.
const HELD: usize = 15 + 6;
/// Lines that queue nothing for certain are not counted among the blocks.
const UNCERTAIN: usize = 8;
const RX: usize = 128;
/// Longest stop, s: 50 ms of prepared slices, then braking from the fastest there is (100 mm/s at 700 mm/s2 on each axis); and some for a
/// port that takes a few bytes at a time.
const STOP: f64 = 0.05 + 100.0 / 700.0 + 0.06;

fn law(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}

/// All laws on one case.
pub fn judge(case: &Case, verdict: &mut Verdict) -> Result<(), String> {
    let ran = &case.ran;
    let killed = case.class.kills_the_sender();
    law(killed || ran.outcome.is_some(), || {
        "(e) the session never ended".to_string()
    })?;
    let done = ran
        .outcome
        .as_ref()
        .is_some_and(|o| o.ending == Ending::Done);
    let history = read(&ran.journal[..]).map_err(|e| e.to_string())?;
    let dropped = refused_lines(&history);
    let corners = way_without(case, &dropped);
    let ends = lengths(&corners);
    let total = ends[ends.len() - 1];
    let followed = follow(&corners, &ran.spots);
    if done {
        let whole = matches!(followed, Ok(way) if way >= total - ALONG);
        if !whole && !case.class.is_clean() {
            verdict.astray = true;
            verdict.ending = "done, wrongly".to_string();
            return Ok(());
        }
        law(whole, || {
            format!("(e) done, but the way was another: {followed:?} of {total:.3} mm")
        })?;
    }
    // No false alarm of the path watch either.
    if let Some(outcome) = &ran.outcome {
        law(case.class.may_end(&outcome.ending), || {
            format!("(e) the ending does not name the cause: {}", outcome.ending)
        })?;
    }
    nothing_moves_afterwards(case)?;
    // Doubled bytes are more than the sender counted.
    law(case.class == Class::Noise || ran.bytes_lost == 0, || {
        "(f) the receive ring overflowed".to_string()
    })?;
    let driven = match followed {
        Ok(way) => way,
        Err(_) if !case.class.is_clean() => {
            verdict.astray = true;
            verdict.noticed |= !would_go_on(case, &history);
            return Ok(());
        }
        Err(e) => return Err(format!("(b) {e}")),
    };
    if done {
        return Ok(());
    }
    let first_refused = dropped.iter().min().copied();
    if !the_stop_is_in_its_zone(case, &history, &corners, driven, first_refused, verdict)? {
        return Ok(());
    }
    if matches!(case.class, Class::SoftLimit | Class::Noise | Class::Replug) {
        // The program itself is at fault, or nobody knows what was received.
        return Ok(());
    }
    // Only what comes before a refused line was cut as it should be.
    let cut = first_refused.map_or(driven, |line| driven.min(way_of(&corners, &ends, line - 1)));
    again(case, cut, &history, verdict)
}

fn refused_lines(history: &History) -> Vec<usize> {
    let doubts = history.doubts.iter();
    doubts
        .filter_map(|d| match d {
            Doubt::Refused { line, .. } if *line > 0 => Some(*line),
            _ => None,
        })
        .collect()
}

/// The way without some lines: a refused one is dropped whole, and what was behind it in the ring runs without it until the hold arrives.
fn way_without(case: &Case, dropped: &[usize]) -> Vec<Corner> {
    let kept = |(i, line)| if dropped.contains(&(i + 1)) { "" } else { line };
    let lines: Vec<&str> = case.text.lines().enumerate().map(kept).collect();
    way(&lines.join("\n"), &case.known.start())
}

/// (a)
fn nothing_moves_afterwards(case: &Case) -> Result<(), String> {
    let ran = &case.ran;
    // Bytes on their way when it restarts are run until the host has heard of it and its reset has arrived.
    law(ran.moved_after_restart <= 2.0 * case.delay + 0.05, || {
        format!(
            "(a) the axes moved {:.3} s after a restart of the controller",
            ran.moved_after_restart
        )
    })?;
    // A controller that nobody reaches runs dry; all others stand.
    let reached = |o: &Outcome| !matches!(o.ending, Ending::Silent { .. } | Ending::Broken(_));
    if !ran.outcome.as_ref().is_some_and(reached) {
        return Ok(());
    }
    let place = place_after(ran, ran.spots_at_end);
    let later = ran.spots.iter().skip(ran.spots_at_end);
    // A reset in motion leaves each axis on a whole step behind it.
    law(
        later
            .into_iter()
            .all(|s| (s.at - place).norm() <= 2.0 * STEP),
        || "(a) the axes moved after the end of the session".to_string(),
    )?;
    let place = place_after(ran, ran.spots.len());
    let last = ran.spots.iter().rfind(|s| (s.at - place).norm() > STEP);
    if let (Some(hold), true, Some(last)) = (ran.hold_at, case.class.is_clean(), last) {
        law(last.t <= hold + case.delay + STOP, || {
            format!(
                "(a) still moving {:.3} s after the stop began",
                last.t - hold
            )
        })?;
    }
    Ok(())
}

/// Where the axes stood after so many spots.
fn place_after(ran: &Ran, spots: usize) -> Point {
    let last = spots.checked_sub(1).and_then(|i| ran.spots.get(i));
    last.map_or(Point::from(START), |s| s.at)
}

/// (c) False when there is nothing to take up: nothing was sent, or the answers were made up.
fn the_stop_is_in_its_zone(
    case: &Case,
    history: &History,
    corners: &[Corner],
    driven: f64,
    refused: Option<usize>,
    verdict: &mut Verdict,
) -> Result<bool, String> {
    let Some(begin) = &history.begin else {
        return Err("(c) the journal does not begin".to_string());
    };
    let z: Zones = match zones(&case.text, begin, history, Some(case.boot())) {
        Ok(z) => z,
        Err(Refusal::NothingSent) => {
            law(driven < ALONG, || {
                "(c) nothing was sent, it says, but it moved".to_string()
            })?;
            return Ok(false);
        }
        Err(e) => return Err(format!("(c) {e}")),
    };
    let ends = lengths(corners);
    let upto = |line: usize| way_of(corners, &ends, line);
    let facts = format!(
        "{z:?}, {driven:.3} mm, answered {} sent {} allowed {}",
        history.acknowledged, history.sent, history.allowed
    );
    if !case.class.is_clean() && upto(z.first - 1) > driven + ALONG {
        // Answers were made up, and it was seen where the way crosses a later line.
        verdict.astray = true;
        verdict.noticed |= !would_go_on(case, history);
        return Ok(false);
    }
    law(upto(z.first - 1) <= driven + ALONG, || {
        format!("(c) a line before the zone was not carried out: {facts}")
    })?;
    law(driven <= upto(z.last) + ALONG, || {
        format!("(c) a line behind the zone was begun: {facts}")
    })?;
    let answered = history.acknowledged.min(refused.unwrap_or(usize::MAX));
    let queued = corners
        .iter()
        .filter(|c| c.line > z.first && c.line <= answered)
        .count();
    law(queued < HELD + UNCERTAIN, || {
        format!("(c) {queued} blocks in the zone: {facts}")
    })?;
    let waiting = case
        .bytes
        .iter()
        .filter(|b| b.0 > history.acknowledged && b.0 <= z.last);
    let unanswered: usize = waiting.map(|b| b.1).sum();
    // Behind a killed sender, what was allowed ahead and a line more; behind a crash of the host, what the cable carries in the gap.
    let room = match (case.class, &history.end) {
        (Class::PowerCut, _) => 4 * RX + 160 + (SYNC_GAP * 11_520.0) as usize,
        (_, None) => 2 * RX + 80,
        _ => RX,
    };
    law(unanswered <= room, || {
        format!("(c) {unanswered} bytes in the zone: {facts}")
    })?;
    Ok(true)
}
