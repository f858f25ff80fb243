//! (d) A broken job taken up again: the whole way is driven, each piece as it should be, and the part is the same.

use super::bench::{Bench, Spot, begin, introduce, standing_at};
use super::case::{Case, Verdict, job};
use super::faults::{Class, Schedule};
use super::follow::{ALONG, follow, lengths, way_of};
use super::jobs::{Corner, START, way};
use super::material::{cuts_of, cuts_of_way, same_part};
use crate::chance::Chance;
use morsemill::controller::Controller;
use morsemill::geom::Point;
use morsemill::link::journal::{History, fingerprint};
use morsemill::link::resume::{Now, Plan, Refusal, ResumeOptions, Trust, resume};
use morsemill::link::{Ending, Known};

/// One in so many resumed cases has its part compared.
const SAMPLE: usize = 3;

/// Takes the job up by its journal and runs the rest; `cut` mm of its way were cut as they should be.
pub fn again(
    case: &Case,
    cut: f64,
    history: &History,
    verdict: &mut Verdict,
) -> Result<(), String> {
    let controller = made_ready(case);
    let known = introduce(&controller);
    let Some(plan) = plan(case, history, &known)? else {
        return Ok(());
    };
    let corners = way(&case.text, &case.known.start());
    let rest = way(&plan.program(&case.text), &known.start());
    the_rest_is_what_is_left(&plan, &corners, &rest, cut)?;
    let rest_job = job(&case.text, &known, plan.head.clone(), plan.entry.line)
        .map_err(|e| format!("(d) {e}"))?;
    let mut first_record = begin(&case.text, &known);
    (first_record.start, first_record.resumed) = (plan.start.clone(), Some(plan.resumed()));
    let dice = case.dice.clone();
    let second = Bench::new(
        &controller,
        &known,
        rest_job,
        first_record,
        Schedule::quiet(),
        dice,
        case.trace,
    )
    .run();
    verdict.log.extend(second.log.iter().cloned());
    let ending = second.outcome.as_ref().map(|o| &o.ending);
    if ending != Some(&Ending::Done) {
        return Err(format!("(d) the resumed job ended {ending:?}"));
    }
    let whole = lengths(&rest).last().copied().unwrap_or(0.0);
    let driven = follow(&rest, &second.spots).map_err(|e| format!("(d) resumed: {e}"))?;
    if driven < whole - ALONG {
        return Err(format!("(d) resumed: {driven:.3} of {whole:.3} mm"));
    }
    verdict.resumed = true;
    // Lines behind a refused one cut where they should not: that part is the operator's to judge.
    if case.class != Class::Refused && Chance(case.dice.0 ^ 1).roll(SAMPLE) == 0 {
        let start = |c: &[Corner]| c.first().map_or(Point::from(START), |c| c.to);
        let mut pieced = cuts_of(start(&corners), &case.ran.spots);
        pieced.extend(cuts_of(start(&rest), &second.spots));
        same_part(
            &cuts_of_way(&corners, false),
            &cuts_of_way(&corners, true),
            &pieced,
        )?;
        verdict.compared = true;
    }
    Ok(())
}

/// True when the job would be taken up without the operator's word for anything.
pub fn would_go_on(case: &Case, history: &History) -> bool {
    let known = introduce(&made_ready(case));
    let now = Now::of(&known, "test", Some(case.boot().into()));
    let sha256 = fingerprint(case.text.as_bytes());
    resume(
        &case.text,
        &sha256,
        history,
        &now,
        &ResumeOptions::default(),
    )
    .is_ok()
}

/// The machine once the operator has seen to it: Idle, standing where the tool is.
fn made_ready(case: &Case) -> Controller {
    let ran = &case.ran;
    if case.class.forgets() && ran.restarted {
        // The tool is where it was; the operator homes, and drives it there.
        let place = ran.spots.last().map_or(START, |s| [s.at.x, s.at.y, s.at.z]);
        let off = &ran.controller;
        return standing_at(Controller::with_build(off.memory(), off.build()), place);
    }
    let mut c = ran.controller.clone();
    c.set_pins(Default::default());
    // The half second of deafness behind an alarm swallows the first reset.
    for bytes in [&b"\x18"[..], b"\x18", b"$X\n"] {
        c.feed(bytes);
        c.advance(2.0);
    }
    c.output();
    c
}

/// The plan, or `None` where there is nothing left to cut.
fn plan(case: &Case, history: &History, known: &Known) -> Result<Option<Plan>, String> {
    let outcome = case.ran.outcome.as_ref();
    // An alarm or a reset in motion costs steps on a real machine; this one keeps them, and the operator has looked.
    let kept = outcome.is_none_or(|o| o.position_kept)
        && !case.class.forgets()
        && !matches!(case.class, Class::Unplug | Class::Refused);
    let now = Now::of(known, "test", Some(case.boot().into()));
    let sha256 = fingerprint(case.text.as_bytes());
    let take_up = |trust: Trust| {
        let options = ResumeOptions {
            trust,
            spin_up_s: 0.1,
            ..ResumeOptions::default()
        };
        resume(&case.text, &sha256, history, &now, &options)
    };
    let mut planned = take_up(if kept { Trust::Shown } else { Trust::Operator });
    let elsewhere = matches!(planned, Err(Refusal::Elsewhere { .. }));
    let unheard = case.class.kills_the_sender() || case.class == Class::Gone;
    if unheard && elsewhere && case.ran.held_at_end {
        // Stopped between two lines by a hold of which the journal had no time to tell: refused until the operator has looked.
        planned = take_up(Trust::Operator);
    }
    match planned {
        Ok(plan) => Ok(Some(plan)),
        // Nobody can tell whether a stored offset was written.
        Err(Refusal::NoEntry { .. } | Refusal::OffsetWritten { .. }) => Ok(None),
        Err(e) => Err(format!("(d) not to be resumed: {e}")),
    }
}

/// From the entry on the resumed program goes the program's own way, and the first run had come to the entry.
fn the_rest_is_what_is_left(
    plan: &Plan,
    corners: &[Corner],
    rest: &[Corner],
    cut: f64,
) -> Result<(), String> {
    let ends = lengths(corners);
    let upto = |line: usize| way_of(corners, &ends, line);
    let entry = plan.entry.line;
    let ahead = |c: &Corner| c.line < entry && !c.rapid && upto(c.line) > cut + ALONG;
    if upto(entry - 1) > cut + ALONG && corners.iter().any(ahead) {
        let by = upto(entry - 1) - cut;
        return Err(format!(
            "(d) the entry, line {entry}, lies {by:.3} mm ahead of what was cut"
        ));
    }
    let head = plan.map().head;
    let split = rest.iter().rposition(|c| c.line <= head).unwrap_or(0);
    let own = corners.iter().rposition(|c| c.line < entry).unwrap_or(0);
    let spot = |c: &Corner| Spot {
        t: 0.0,
        at: c.to,
        rapid: c.rapid,
    };
    let spots: Vec<Spot> = rest[split..].iter().map(spot).collect();
    let came =
        follow(&corners[own..], &spots).map_err(|e| format!("(d) the rest is another way: {e}"))?;
    let left = ends[ends.len() - 1] - ends[own];
    if came < left - ALONG {
        return Err(format!(
            "(d) {came:.3} of {left:.3} mm are left in the rest"
        ));
    }
    Ok(())
}
