//! The way in leaves the state of the straight run, wherever it enters.

use super::{START, broken_at, here, operator, program, reset_state, states};
use morsemill::gcode::{FeedMode, MotionMode, State};
use morsemill::link::journal::fingerprint;
use morsemill::link::resume::{Overlap, Refusal, ResumeOptions, from_line, resume};
use proptest::prelude::*;

/// Everything that the machine remembers is as in the straight run, but T, which GRBL forgets with each line, and a motion mode that only an
/// arc could set.
fn same_modes(a: &State, b: &State) -> Result<(), String> {
    let mut b = b.clone();
    let near = |x: f64, y: f64| (x - y).abs() < 3e-5 + 1e-9 * x.abs();
    let all_near = (0..3).all(|i| near(a.position[i], b.position[i]) && near(a.g92[i], b.g92[i]))
        && near(a.tlo, b.tlo)
        && (near(a.feed.0, b.feed.0) || a.feed_mode == FeedMode::InverseTime);
    (b.position, b.g92, b.g92_kept, b.tlo, b.tool, b.feed) =
        (a.position, a.g92, a.g92_kept, a.tlo, a.tool, a.feed);
    b.rapid_feed = a.rapid_feed;
    if matches!(
        a.motion,
        MotionMode::ArcClockwise | MotionMode::ArcCounterclockwise | MotionMode::None
    ) {
        b.motion = a.motion;
    }
    match all_near && *a == b {
        true => Ok(()),
        false => Err(format!("straight {a:?}\nresumed {b:?}")),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 200, ..ProptestConfig::default() })]

    /// Wherever a job breaks: the way in leaves the state of the straight run, and each later line does the same.
    #[test]
    fn the_state_at_the_entry_is_that_of_the_straight_run(seed: u64, at in 0.0..1.0f64, ahead in 0usize..8, overlap in 0usize..4) {
        let text = program(seed, 60);
        let lines = text.lines().count();
        let acknowledged = 7 + ((lines - 7) as f64 * at) as usize;
        let history = broken_at(&text, acknowledged, (acknowledged + ahead).min(lines));
        let options = ResumeOptions { overlap: [Overlap::Mm(0.0), Overlap::Mm(5.0), Overlap::Lines(3), Overlap::Mm(1e9)][overlap], ..operator() };
        let place = [-50.0, -70.0, -30.0];
        let plan = match resume(&text, &fingerprint(text.as_bytes()), &history, &here(place), &options) {
            Ok(plan) => plan,
            Err(e) => return Err(TestCaseError::fail(e.to_string())),
        };
        let straight = states(&text, reset_state(START));
        let rest = plan.program(&text);
        let resumed = states(&rest, reset_state(place));
        let map = plan.map();
        prop_assert_eq!(rest.lines().count(), map.head + lines - map.entry + 1);
        prop_assert!(plan.entry.line <= plan.zones.unwrap().first);
        let same = same_modes(&straight[map.entry - 1], &resumed[map.head]);
        prop_assert!(same.is_ok(), "{}", same.unwrap_err());
        for line in map.entry..=lines {
            let same = same_modes(&straight[line], &resumed[map.head + line - map.entry + 1]);
            prop_assert!(same.is_ok(), "line {line}: {}", same.unwrap_err());
        }
        // The way in: up first, over at a safe height, down at feed and last.
        let highest = straight[4..].iter().map(|s| s.machine_position().z).fold(f64::MIN, f64::max);
        let mut lifted = false;
        for (before, after) in resumed.iter().zip(&resumed[1..=map.head]) {
            let (a, b) = (before.machine_position(), after.machine_position());
            let over = (a.xy() - b.xy()).norm() > 1e-9;
            prop_assert!(!over || lifted && a.z >= highest - 1e-9 && a.z == b.z, "{a} {b}");
            lifted |= before.motion == MotionMode::Rapid && b.z >= highest.max(place[2]) - 1e-9;
        }
        prop_assert!((plan.way.safe_z - resumed[..=map.head].iter().map(|s| s.machine_position().z).fold(f64::MIN, f64::max)).abs() < 1e-9);
    }

    /// Without a journal: where the program alone tells the place, any line can be begun at, from wherever the machine stands.
    #[test]
    fn any_line_can_be_begun_at(seed: u64, at in 0.0..1.0f64) {
        let text = program(seed, 60);
        let lines = text.lines().count();
        let line = 7 + ((lines - 7) as f64 * at) as usize;
        let place = [-50.0, -70.0, -30.0];
        let options = ResumeOptions { overlap: Overlap::Nothing, ..ResumeOptions::default() };
        let plan = match from_line(&text, line, false, &here(place), &options) {
            Ok(plan) => plan,
            Err(Refusal::NoEntry { .. } | Refusal::StartUnknown { .. }) => return Ok(()),
            Err(e) => return Err(TestCaseError::fail(e.to_string())),
        };
        prop_assert!(plan.entry.line >= line && plan.zones.is_none());
        let straight = states(&text, reset_state(place));
        let resumed = states(&plan.program(&text), reset_state(place));
        let same = same_modes(&straight[plan.entry.line - 1], &resumed[plan.head.len()]);
        prop_assert!(same.is_ok(), "{}", same.unwrap_err());
    }
}
