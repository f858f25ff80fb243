//! Random programs broken at random moments in every way there is, and taken up again.

use super::sender::{Break, Sender};
use super::{HELD, RX, START, begin, controller, here, program, reset_state, taken};
use crate::campaign::follow::{lengths, way_of};
use crate::campaign::jobs::way;
use crate::chance::Chance;
use morsemill::controller::Controller;
use morsemill::gcode::State;
use morsemill::link::journal::{fingerprint, read};
use morsemill::link::resume::{Evidence, Now, Refusal, ResumeOptions, Trust, resume, zones};
use proptest::prelude::*;

/// As a report tells it.
fn now(c: &Controller) -> Now {
    let p = c.position();
    here([p.x, p.y, p.z].map(|v| (v * 1e3).round() / 1e3))
}

/// Way of the axes up to the end of each line (index 0: before the first), mm, and blocks of each line.
fn ways(text: &str, start: State) -> (Vec<f64>, Vec<usize>) {
    let corners = way(text, &start);
    let ends = lengths(&corners);
    let lines = 0..=text.lines().count();
    let blocks = lines
        .clone()
        .map(|l| corners.iter().filter(|c| c.line == l && l > 0).count());
    (
        lines.clone().map(|l| way_of(&corners, &ends, l)).collect(),
        blocks.collect(),
    )
}

/// The laws of the zones, and what the resumed program makes of the rest.
fn break_and_resume(seed: u64, how: Break, fullest: &mut usize) -> Result<bool, TestCaseError> {
    let mut dice = Chance(seed);
    let text = program(seed, 30 + dice.roll(80));
    let (ways, blocks) = ways(&text, reset_state(START));
    let total = *ways.last().unwrap();
    let mut bench = Sender::new(
        controller(),
        &text,
        0,
        1,
        begin(&text),
        1 + dice.roll(30) as u64,
    );
    // Break it when the axes have gone so far.
    let stop_at = total * dice.roll(1000) as f64 / 1000.0;
    while bench.way < stop_at && !bench.done() {
        bench.tick();
    }
    for _ in 0..dice.roll(200) {
        bench.tick();
    }
    prop_assert!(!bench.refused);
    let journal = bench.break_off(how, &mut dice);
    let history = read(&journal[..]).unwrap();
    let z = match zones(&text, taken(&history), &history, Some("boot")) {
        Ok(z) => z,
        Err(Refusal::NothingSent) => {
            prop_assert!(bench.way < 1e-6, "moved {} mm", bench.way);
            return Ok(false);
        }
        Err(e) => return Err(TestCaseError::fail(e.to_string())),
    };

    // The true place lies in the zone. The axes go from whole step to whole step, so their way is not the text's to the last digit.
    let way = bench.way;
    let steps = 1e-3 + 1e-4 * total;
    let where_it_is = format!(
        "{z:?} of {way:.4} mm, {how:?}, answered {} sent {} allowed {}",
        history.acknowledged, history.sent, history.allowed
    );
    prop_assert!(
        ways[z.first - 1] <= way + steps,
        "a line before the zone was not carried out: {where_it_is}"
    );
    prop_assert!(
        way <= ways[z.last] + steps,
        "a line behind the zone was begun: {where_it_is}"
    );
    // How much the controller really held: the bound must be needed.
    let line = (1..ways.len())
        .find(|l| ways[*l] > way + steps)
        .unwrap_or(ways.len());
    if line < history.acknowledged {
        *fullest = (*fullest).max(blocks[line + 1..=history.acknowledged].iter().sum());
    }
    // The zone is no larger than what the controller holds.
    let queued: usize = blocks[(z.first + 1).min(history.acknowledged + 1)..=history.acknowledged]
        .iter()
        .sum();
    prop_assert!(queued < HELD + 8, "{queued} blocks: {where_it_is}");
    let unanswered: usize = bench.text[history.acknowledged.min(z.last)..z.last]
        .iter()
        .map(|l| Sender::bytes(l))
        .sum();
    let room = if how == Break::Kill { 2 * RX + 80 } else { RX };
    prop_assert!(unanswered <= room, "{unanswered} bytes: {where_it_is}");

    // Taken up again.
    let trust = if how == Break::Reset {
        Trust::Operator
    } else {
        Trust::Shown
    };
    let options = ResumeOptions {
        trust,
        spin_up_s: 0.1,
        ..ResumeOptions::default()
    };
    let plan = match resume(
        &text,
        &fingerprint(text.as_bytes()),
        &history,
        &now(&bench.controller),
        &options,
    ) {
        Ok(plan) => plan,
        Err(Refusal::NoEntry { .. }) => return Ok(false),
        Err(e) => return Err(TestCaseError::fail(format!("{e}: {where_it_is}"))),
    };
    let evidence = if how == Break::Reset {
        Evidence::Operator
    } else {
        Evidence::OnPath
    };
    prop_assert_eq!(plan.evidence, Some(evidence));
    // All that was not cut is cut by the rest: the first run came at least to the entry.
    prop_assert!(
        ways[plan.entry.line - 1] <= way + steps || plan.entry.line <= 7,
        "entry {}: {where_it_is}",
        plan.entry.line
    );
    let rest = plan.program(&text);
    bench.controller.feed(b"\x18");
    bench.turn(if how == Break::Reset { 2.0 } else { 0.5 });
    if how == Break::Reset {
        bench.controller.feed(b"$X\n");
        bench.turn(0.5);
    }
    bench.controller.output();
    let map = plan.map();
    let mut second = Sender::new(
        bench.controller.clone(),
        &rest,
        map.head,
        map.entry,
        begin(&text),
        2,
    );
    while second.acknowledged < map.head {
        second.tick();
    }
    second.finish();
    prop_assert!(!second.refused, "{rest}");
    // The same end as the straight run, by the axes.
    let mut straight = Sender::new(controller(), &text, 0, 1, begin(&text), 2);
    straight.finish();
    let apart = (second.controller.position() - straight.controller.position()).norm();
    prop_assert!(apart < 0.009, "ends {apart} mm apart");
    prop_assert!(
        (straight.way - total).abs() < steps,
        "{} {total}",
        straight.way
    );
    // And the way from the entry on is the straight run's: the rest of it, whole.
    let (rest_ways, _) = self::ways(&rest, reset_state(now(&bench.controller).position.unwrap()));
    let after_entry = rest_ways.last().unwrap() - rest_ways[map.head];
    prop_assert!(
        (after_entry - (total - ways[map.entry - 1])).abs() < 0.02 + 1e-4 * total,
        "{after_entry} {}",
        total - ways[map.entry - 1]
    );
    Ok(true)
}

fn campaign(how: Break, seeds: std::ops::Range<u64>) {
    let count = seeds.end - seeds.start;
    let (mut resumed, mut fullest) = (0, 0);
    for seed in seeds {
        match break_and_resume(seed, how, &mut fullest) {
            Ok(done) => resumed += u64::from(done),
            Err(e) => panic!("seed {seed}, {how:?}: {e}"),
        }
    }
    assert!(
        resumed * 10 >= count * 8,
        "only {resumed} of {count} were resumed"
    );
    // Jobs that run dry have nothing queued.
    if matches!(how, Break::Stop | Break::Reset) {
        assert!(fullest >= 8, "the planner never held much: {fullest}");
    }
}

#[test]
fn a_stopped_job_goes_on_where_it_was() {
    campaign(Break::Stop, 0..12);
}

#[test]
fn a_job_whose_controller_was_reset_goes_on_on_the_operators_word() {
    campaign(Break::Reset, 1000..1012);
}

#[test]
fn a_job_whose_cable_was_pulled_goes_on() {
    campaign(Break::Cable, 2000..2012);
}

#[test]
fn a_job_whose_sender_was_killed_goes_on() {
    campaign(Break::Kill, 3000..3012);
}
