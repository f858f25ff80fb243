//! A short run of the fuzzer on every format, always the same cases: see `examples/fuzz.rs` for long ones.

#[path = "../../examples/fuzzing/mod.rs"]
#[allow(dead_code)]
mod fuzzing;

use fuzzing::targets::{TARGETS, Target};
use fuzzing::{Outcome, input, try_input};
use std::time::{Duration, Instant};

const SEED: u64 = 4;

/// Two seconds, but no fewer than 500 cases however slow the machine.
fn smoke(target: &Target) {
    let seeds = (target.seeds)();
    for seed in &seeds {
        assert!(
            !matches!(try_input(target, seed), Outcome::Finding(_)),
            "{}",
            target.name
        );
    }
    let start = Instant::now();
    let (mut accepted, mut refused) = (0, 0);
    for case in 0.. {
        if case >= 500 && start.elapsed() > Duration::from_secs(2) {
            break;
        }
        match try_input(target, &input(target, &seeds, SEED, case)) {
            Outcome::Accepted => accepted += 1,
            Outcome::Refused => refused += 1,
            // On a busy machine without optimisation anything can be slow; long runs watch the clock.
            Outcome::Finding(what) if what.starts_with("slow") => {}
            Outcome::Finding(what) => panic!("{} --seed {SEED} --case {case}: {what}", target.name),
        }
    }
    assert!(
        accepted > 0 && refused > 0,
        "{}: {accepted} accepted, {refused} refused",
        target.name
    );
}

#[test]
fn every_reader_survives_two_seconds() {
    std::thread::scope(|s| {
        for target in &TARGETS {
            s.spawn(|| smoke(target));
        }
    });
}

#[test]
fn a_case_is_always_the_same_and_cases_differ() {
    for target in &TARGETS {
        let seeds = (target.seeds)();
        let made = |case| input(target, &seeds, SEED, case);
        assert_eq!(made(17), made(17));
        let all: std::collections::BTreeSet<Vec<u8>> = (0..100).map(made).collect();
        assert!(
            all.len() > 60,
            "{}: {} different of 100",
            target.name,
            all.len()
        );
    }
}

#[test]
fn a_panic_and_a_wrong_acceptance_are_findings() {
    let broken = |read| Target {
        name: "broken",
        seeds: Vec::new,
        words: &[],
        read,
    };
    let told = |outcome| match outcome {
        Outcome::Finding(what) => what,
        _ => String::new(),
    };
    let panicked = told(try_input(&broken(|_| panic!("ouch")), b"x"));
    assert!(
        panicked.starts_with("panic: ") && panicked.contains("ouch"),
        "{panicked}"
    );
    assert_eq!(
        told(try_input(&broken(|_| Err("not that".into())), b"x")),
        "not that"
    );
    assert!(matches!(
        try_input(&broken(|_| Ok(false)), b"x"),
        Outcome::Refused
    ));
}
