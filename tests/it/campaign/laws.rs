//! What must hold, whatever goes wrong.

use super::bench::{Bench, Ran, Spot, begin, introduce, machine, standing_at};
use super::faults::{Class, Schedule, schedule};
use super::jobs::{Corner, Dice, START, program, way};
use super::material::{cuts_of, cuts_of_way, same_part};
use morsemill::controller::FaultPlan;
use morsemill::gcode::{State, interpret_line};
use morsemill::geom::Point;
use morsemill::link::journal::{Doubt, fingerprint, read};
use morsemill::link::resume::{Now, Refusal, ResumeOptions, Trust, resume, zones};
use morsemill::link::vet::{Limits, VetOptions, vet};
use morsemill::link::{Ending, Job, Known, Text};
use std::sync::Arc;

/// How near the axes keep to the way, mm: two steps and rounding.
const NEAR: f64 = 0.01;
/// Slack of places along the way, mm.
const ALONG: f64 = 0.025;
/// A reset puts the axes on whole steps, mm.
const STEP: f64 = 0.005;
/// What a GRBL holds of answered lines: planner blocks and slices, each of another block at worst.
const HELD: usize = 15 + 6;
const RX: usize = 128;
/// One in so many resumed cases has its part compared.
const SAMPLE: usize = 10;

/// What became of one case.
#[derive(Clone, Debug)]
pub struct Verdict {
    pub class: Class,
    pub ending: String,
    pub resumed: bool,
    /// The height maps were compared.
    pub compared: bool,
    /// Why it was not taken up again.
    pub refused: String,
    /// Damaged bytes made another program of it.
    pub astray: bool,
    pub virtual_s: f64,
    pub log: Vec<String>,
}

/// A way being followed.
struct Follower<'a> {
    corners: &'a [Corner],
    /// The piece that ends at this corner is under way...
    next: usize,
    /// ... and so much of it is driven, mm.
    part: f64,
}

impl Follower<'_> {
    /// Goes on to a place; it must lie ahead, on the way.
    fn go(&mut self, spot: &Spot) -> Result<(), String> {
        loop {
            let [Some(a), Some(b)] = [self.corners.get(self.next - 1), self.corners.get(self.next)]
            else {
                let end = self.corners[self.corners.len() - 1].to;
                if (spot.at - end).norm() <= NEAR {
                    return Ok(());
                }
                return Err(format!(
                    "{:?} at {:.4} s lies beyond the end of the way",
                    spot.at, spot.t
                ));
            };
            let (along, length) = (b.to - a.to, (b.to - a.to).norm());
            let t = ((spot.at - a.to).dot(&along) / length).clamp(self.part, length);
            let off = (a.to + along * (t / length) - spot.at).norm();
            if off <= NEAR {
                self.part = t;
                if spot.rapid != b.rapid && t > 2.0 * NEAR && length - t > 2.0 * NEAR {
                    return Err(format!(
                        "line {} was driven {}",
                        b.line,
                        if spot.rapid { "rapidly" } else { "at feed" }
                    ));
                }
                return Ok(());
            }
            if length - self.part > ALONG {
                return Err(format!(
                    "{:?} at {:.4} s is {off:.4} mm off line {}",
                    spot.at, spot.t, b.line
                ));
            }
            (self.next, self.part) = (self.next + 1, 0.0);
        }
    }

    fn way(&self, ends: &[f64]) -> f64 {
        ends[(self.next - 1).min(ends.len() - 1)] + self.part
    }
}

/// Way up to each corner, mm.
fn lengths(corners: &[Corner]) -> Vec<f64> {
    let mut sum = 0.0;
    let pieces = corners.windows(2).map(|w| (w[1].to - w[0].to).norm());
    std::iter::once(0.0)
        .chain(pieces.map(|l| {
            sum += l;
            sum
        }))
        .collect()
}

/// How far along the way the axes came, all in order, mm.
fn follow(corners: &[Corner], spots: &[Spot]) -> Result<f64, String> {
    let mut f = Follower {
        corners,
        next: 1,
        part: 0.0,
    };
    for spot in spots {
        f.go(spot)?;
    }
    Ok(f.way(&lengths(corners)))
}

fn job(text: &str, known: &Known, entry: Vec<String>, first_line: usize) -> Result<Job, String> {
    let options = VetOptions {
        limits: Limits::None,
        entry,
        first_line,
        ..VetOptions::of(known, None)
    };
    vet(Arc::new(Text(text.into())), options, &mut |_, _| {}).map_err(|e| format!("vetting: {e:?}"))
}

/// One case: `Err` tells the law that was broken.
pub fn case(seed: u64, trace: bool) -> Result<Verdict, String> {
    let mut dice = Dice(seed);
    let class = Class::ALL[dice.roll(Class::ALL.len())];
    let (controller, known) = machine(class);
    let count = 10 + dice.roll(60);
    let mut text = program(&mut dice, count, &known.start());
    // Vetting refuses a little more than the interpreter.
    while job(&text, known, Vec::new(), 1).is_err() {
        text = program(&mut dice, count, &known.start());
    }
    if class == Class::SoftLimit {
        let at = 6 + dice.roll(text.lines().count() - 6);
        let mut lines: Vec<&str> = text.lines().collect();
        lines.insert(at, "G53 G0 X4");
        // Behind it only what still can be taken; none of it ever runs.
        let mut state = known.start();
        lines.retain(|line| interpret_line(&mut state, line, 0, &mut Vec::new()).is_ok());
        lines.truncate(at + 12);
        text = lines.join("\n") + "\n";
    }
    let corners = way(&text, &known.start());
    let ends = lengths(&corners);
    let total = ends[ends.len() - 1];
    let plan = schedule(&mut dice, class, total / 13.0, text.lines().count());
    let tell = |what: String| format!("{class:?}: {what}");
    let runs = job(&text, known, Vec::new(), 1).map_err(tell)?;
    let bytes: Vec<(usize, usize)> = {
        let mut lines = runs.lines().map_err(|e| e.to_string())?;
        std::iter::from_fn(|| lines.next_line().ok().flatten())
            .map(|l| (l.source, l.bytes()))
            .collect()
    };
    let delay = plan.plan.delay;
    let ran = Bench::new(
        controller,
        known,
        runs,
        begin(&text, known),
        plan,
        dice.clone(),
        trace,
    )
    .run();
    let mut verdict = Verdict {
        class,
        ending: ran
            .outcome
            .as_ref()
            .map_or("killed".to_string(), |o| o.ending.key()),
        resumed: false,
        compared: false,
        refused: String::new(),
        astray: false,
        virtual_s: ran.ended_at,
        log: match trace {
            true => text
                .lines()
                .enumerate()
                .map(|(i, line)| format!("{:4} {line}", i + 1))
                .chain(ran.log.iter().cloned())
                .collect(),
            false => Vec::new(),
        },
    };
    let judged = judge(
        &text,
        &known.start(),
        &corners,
        &bytes,
        &ran,
        class,
        delay,
        &mut verdict,
        &mut dice,
        trace,
    );
    match judged {
        Ok(()) => Ok(verdict),
        Err(why) => Err(format!(
            "{}\n{class:?}, ended {} at {:.3} s: {why}",
            verdict.log.join("\n"),
            verdict.ending,
            ran.ended_at
        )),
    }
}

#[expect(clippy::too_many_arguments, reason = "all of a case")]
fn judge(
    text: &str,
    start: &State,
    corners: &[Corner],
    bytes: &[(usize, usize)],
    ran: &Ran,
    class: Class,
    delay: f64,
    verdict: &mut Verdict,
    dice: &mut Dice,
    trace: bool,
) -> Result<(), String> {
    let law = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_string()) };
    // (e) It ends.
    let killed = class == Class::Killed;
    let Some(done) = ran
        .outcome
        .as_ref()
        .map(|o| o.ending == Ending::Done)
        .or(killed.then_some(false))
    else {
        return Err("(e) the session never ended".to_string());
    };
    // (b) The way driven is the beginning of the program's.
    // A refused line is dropped whole, and what was behind it in the ring runs without it until the hold arrives.
    let history = read(&ran.journal[..]).map_err(|e| e.to_string())?;
    let dropped: Vec<usize> = history
        .doubts
        .iter()
        .filter_map(|d| match d {
            Doubt::Refused { line, .. } if *line > 0 => Some(*line),
            _ => None,
        })
        .collect();
    let refused = dropped.iter().min().copied();
    let without = refused.map(|_| {
        let lines: Vec<&str> = text
            .lines()
            .enumerate()
            .map(|(i, l)| if dropped.contains(&(i + 1)) { "" } else { l })
            .collect();
        way(&lines.join("\n"), start)
    });
    let corners = without.as_deref().unwrap_or(corners);
    let ends = &lengths(corners)[..];
    let followed = follow(corners, &ran.spots);
    let total = ends[ends.len() - 1];
    if done {
        let whole = matches!(followed, Ok(way) if way >= total - ALONG);
        if !whole && !class.is_clean() {
            verdict.astray = true;
            verdict.ending = "done, wrongly".to_string();
            return Ok(());
        }
        law(
            whole,
            &format!("(e) done, but the way was another: {followed:?} of {total:.3} mm"),
        )?;
    }
    if let Some(outcome) = &ran.outcome {
        law(
            class.may_end(&outcome.ending),
            &format!("(e) the ending does not name the cause: {}", outcome.ending),
        )?;
    }
    // (a) Nothing moves afterwards.
    // Bytes on their way when it restarts are run until the host has heard of it and its reset has arrived.
    law(
        ran.moved_after_restart <= 2.0 * delay + 0.05,
        &format!(
            "(a) the axes moved {:.3} s after a restart of the controller",
            ran.moved_after_restart
        ),
    )?;
    let over = ran
        .outcome
        .as_ref()
        .filter(|o| !matches!(o.ending, Ending::Silent { .. } | Ending::Broken(_)));
    if over.is_some() {
        let place = ran
            .spots_at_end
            .checked_sub(1)
            .and_then(|i| ran.spots.get(i))
            .map_or(Point::from(START), |s| s.at);
        let moved = ran
            .spots
            .iter()
            .skip(ran.spots_at_end)
            // A reset in motion leaves each axis on a whole step behind it.
            .any(|s| (s.at - place).norm() > 2.0 * STEP);
        law(!moved, "(a) the axes moved after the end of the session")?;
    }
    let place = ran.spots.last().map_or(Point::from(START), |s| s.at);
    let last = ran.spots.iter().rfind(|s| (s.at - place).norm() > STEP);
    if let (Some(hold), true, Some(last)) = (ran.hold_at, over.is_some() && class.is_clean(), last)
    {
        // 50 ms of slices, then braking from the fastest there is: 100 mm/s at 700 mm/s² on each axis; the port may take a byte at a time.
        law(
            last.t <= hold + delay + 0.05 + 100.0 / 700.0 + 0.06,
            &format!(
                "(a) still moving {:.3} s after the stop began",
                last.t - hold
            ),
        )?;
    }
    // (f) The ring.
    if class != Class::Noise {
        law(ran.bytes_lost == 0, "(f) the receive ring overflowed")?;
    }
    let driven = match followed {
        Ok(way) => way,
        Err(_) if !class.is_clean() => {
            verdict.astray = true;
            return Ok(());
        }
        Err(e) => return Err(format!("(b) {e}")),
    };
    if done {
        return Ok(());
    }
    // (c) The zones.
    let Some(first_record) = &history.begin else {
        return Err("(c) the journal does not begin".to_string());
    };
    let z = match zones(text, first_record, &history, Some("boot")) {
        Ok(z) => z,
        Err(Refusal::NothingSent) => {
            return law(
                driven < ALONG,
                "(c) nothing was sent, it says, but it moved",
            );
        }
        Err(e) => return Err(format!("(c) {e}")),
    };
    let upto = |line: usize| {
        corners
            .iter()
            .rposition(|c| c.line <= line)
            .map_or(0.0, |i| ends[i])
    };
    let facts = format!(
        "{z:?}, {driven:.3} of {total:.3} mm, answered {} sent {} allowed {}",
        history.acknowledged, history.sent, history.allowed
    );
    if !class.is_clean() && upto(z.first - 1) > driven + ALONG {
        // A doubled `ok` answers a line that was not read yet: nobody can tell it from a true one.
        verdict.astray = true;
        return Ok(());
    }
    law(
        upto(z.first - 1) <= driven + ALONG,
        &format!("(c) a line before the zone was not carried out: {facts}"),
    )?;
    law(
        driven <= upto(z.last) + ALONG,
        &format!("(c) a line behind the zone was begun: {facts}"),
    )?;
    let queued = corners
        .iter()
        .filter(|c| {
            c.line > z.first && c.line <= history.acknowledged.min(refused.unwrap_or(usize::MAX))
        })
        .count();
    law(
        queued < HELD + 8,
        &format!("(c) {queued} blocks in the zone: {facts}"),
    )?;
    let unanswered: usize = bytes
        .iter()
        .filter(|b| b.0 > history.acknowledged && b.0 <= z.last)
        .map(|b| b.1)
        .sum();
    let room = if history.end.is_none() {
        2 * RX + 80
    } else {
        RX
    };
    law(
        unanswered <= room,
        &format!("(c) {unanswered} bytes in the zone: {facts}"),
    )?;
    if class == Class::SoftLimit || class == Class::Noise || class == Class::Replug {
        return Ok(());
    }
    // Only what comes before a refused line was cut as it should be.
    let cut = refused.map_or(driven, |line| driven.min(upto(line - 1)));
    again(
        text,
        &way(text, start),
        ran,
        class,
        cut,
        &history,
        verdict,
        dice,
        trace,
    )
}

/// (d) Taken up again, the whole way is driven, each piece as it should be.
#[expect(clippy::too_many_arguments, reason = "all of a case")]
fn again(
    text: &str,
    corners: &[Corner],
    ran: &Ran,
    class: Class,
    cut: f64,
    history: &morsemill::link::journal::History,
    verdict: &mut Verdict,
    dice: &mut Dice,
    trace: bool,
) -> Result<(), String> {
    let ends = &lengths(corners)[..];
    let mut c = if class.forgets() && ran.restarted {
        // The tool is where it was; the operator homes, and drives it there.
        let place = ran.spots.last().map_or(START, |s| [s.at.x, s.at.y, s.at.z]);
        standing_at(machine(class).0.clone(), place)
    } else {
        let mut c = ran.controller.clone();
        c.set_pins(Default::default());
        c.feed(b"\x18");
        c.advance(2.0);
        c.feed(b"\x18");
        c.advance(2.0);
        c.feed(b"$X\n");
        c.advance(1.0);
        c
    };
    c.output();
    let now_known = introduce(&c);
    // An alarm or a reset in motion costs steps on a real machine; this one keeps them, and the operator has looked.
    let kept = ran.outcome.as_ref().is_none_or(|o| o.position_kept)
        && !class.forgets()
        && class != Class::Unplug
        && class != Class::Refused;
    let trust = if kept { Trust::Shown } else { Trust::Operator };
    let options = ResumeOptions {
        trust,
        spin_up_s: 0.1,
        ..ResumeOptions::default()
    };
    let now = Now::of(&now_known, "test", Some("boot".into()));
    let take_up = |options: &ResumeOptions| {
        resume(text, &fingerprint(text.as_bytes()), history, &now, options)
    };
    let mut planned = take_up(&options);
    if class == Class::Killed
        && matches!(planned, Err(Refusal::Elsewhere { .. }))
        && ran.held_at_end
    {
        // Stopped between two lines by a hold of which the journal had no time to tell: refused until the operator has looked.
        planned = take_up(&ResumeOptions {
            trust: Trust::Operator,
            ..options
        });
    }
    let plan = match planned {
        Ok(plan) => plan,
        Err(e @ (Refusal::NoEntry { .. } | Refusal::OutsideTravel { .. })) => {
            verdict.refused = e.to_string();
            return Ok(());
        }
        Err(e) => return Err(format!("(d) not to be resumed: {e}")),
    };
    // The first run came to the entry: nothing is left out between.
    let upto = |line: usize| {
        corners
            .iter()
            .rposition(|c| c.line <= line)
            .map_or(0.0, |i| ends[i])
    };
    if upto(plan.entry.line - 1) > cut + ALONG
        && corners
            .iter()
            .any(|c| c.line < plan.entry.line && !c.rapid && upto(c.line) > cut + ALONG)
    {
        return Err(format!(
            "(d) the entry, line {}, lies {:.3} mm ahead of what was cut",
            plan.entry.line,
            upto(plan.entry.line - 1) - cut
        ));
    }
    let rest = plan.program(text);
    let rest_way = way(&rest, &now_known.start());
    // From the entry on it is the program's own way.
    let head = plan.map().head;
    let split = rest_way.iter().rposition(|c| c.line <= head).unwrap_or(0);
    let own = corners
        .iter()
        .rposition(|c| c.line < plan.entry.line)
        .unwrap_or(0);
    let spots: Vec<Spot> = rest_way[split..]
        .iter()
        .map(|c| Spot {
            t: 0.0,
            at: c.to,
            rapid: c.rapid,
        })
        .collect();
    let came =
        follow(&corners[own..], &spots).map_err(|e| format!("(d) the rest is another way: {e}"))?;
    let left = ends[ends.len() - 1] - ends[own];
    if came < left - ALONG {
        return Err(format!(
            "(d) {came:.3} of {left:.3} mm are left in the rest"
        ));
    }
    let entry_job = job(text, &now_known, plan.head.clone(), plan.entry.line)
        .map_err(|e| format!("(d) {e}"))?;
    let mut start = begin(text, &now_known);
    (start.start, start.resumed) = (plan.start.clone(), Some(plan.resumed()));
    let mut quiet = schedule(&mut dice.clone(), Class::Sound, 1.0, 10);
    quiet.wishes.clear();
    quiet.plan = FaultPlan::default();
    let second = Bench::new(
        &c,
        &now_known,
        entry_job,
        start,
        Schedule { ..quiet },
        dice.clone(),
        trace,
    )
    .run();
    verdict.log.extend(second.log.iter().cloned());
    let outcome = second.outcome.as_ref().map(|o| o.ending.clone());
    if outcome != Some(Ending::Done) {
        return Err(format!("(d) the resumed job ended {outcome:?}"));
    }
    let whole: f64 = lengths(&rest_way).last().copied().unwrap_or(0.0);
    let driven = follow(&rest_way, &second.spots).map_err(|e| format!("(d) resumed: {e}"))?;
    if driven < whole - ALONG {
        return Err(format!("(d) resumed: {driven:.3} of {whole:.3} mm"));
    }
    verdict.resumed = true;
    // Lines behind a refused one cut where they should not: that part is the operator's to judge.
    if class != Class::Refused && dice.roll(SAMPLE) == 0 {
        let start = |c: &[Corner]| c.first().map_or(Point::from(START), |c| c.to);
        let mut pieced = cuts_of(start(corners), &ran.spots);
        pieced.extend(cuts_of(start(&rest_way), &second.spots));
        same_part(
            &cuts_of_way(corners, false),
            &cuts_of_way(corners, true),
            &pieced,
        )?;
        verdict.compared = true;
    }
    Ok(())
}
