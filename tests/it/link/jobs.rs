//! Jobs in which nothing goes wrong, over cables of all kinds.

use super::bench::{Bench, SQUARE, at_rest_for_good, memory, spiral};
use super::cable::Cable;
use morsemill::controller::Controller;
use morsemill::geom::Point;
use morsemill::link::vet::MemoryWriters;
use morsemill::link::{Command, Ending, Job, VetOptions};
use proptest::prelude::*;

#[test]
fn a_job_runs_to_its_end() {
    let mut bench = Bench::plain(SQUARE);
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Done);
    assert_eq!(
        (outcome.sent, outcome.acknowledged, outcome.total),
        (11, 11, 11)
    );
    assert_eq!(outcome.position, Some([1.0, 2.0, 5.0]));
    assert!(outcome.position_kept);
    assert!(bench.controller.elapsed() > 1.0);
    assert!((bench.controller.position() - Point::new(1.0, 2.0, 5.0)).norm() < 1e-9);
}

#[test]
fn a_controller_that_was_not_reset_by_opening_is_asked() {
    let mut bench = Bench::plain(SQUARE);
    bench.controller.output();
    bench.controller.feed(b"G91 G20\n");
    bench.controller.output();
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Done, "{:?}", bench.news);
    assert!(bench.heard("the controller's modes were G0 G54 G17 G20 G91"));
    assert_eq!(outcome.position, Some([1.0, 2.0, 5.0]));
}

#[test]
fn a_locked_controller_is_left_alone() {
    let mut m = memory();
    m.set(22, 1.0);
    let cable = Cable::new(vec![1], vec![1000]);
    let mut bench = Bench::new(
        Job::vet(SQUARE).unwrap(),
        Controller::new(m),
        cable.clone(),
        cable,
    );
    let outcome = bench.finish();
    assert!(outcome.ending.to_string().contains("home it with $H"));
    assert_eq!(outcome.sent, 0);
}

#[test]
fn a_port_that_takes_few_bytes_at_once_changes_nothing() {
    let mut bench = Bench::plain(&spiral(60, 0.2));
    bench.takes = vec![0, 3, 1, 7];
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Done);
    assert_eq!(bench.controller.bytes_lost(), 0);
    // A stop goes out before what the port has not taken, and what it has not taken never goes out.
    let mut bench = Bench::plain(&spiral(600, 0.2));
    bench.takes = vec![1];
    bench.ticks(4000);
    bench.command(Command::Stop);
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Stopped);
    let stop = bench.times("!")[0];
    let after = bench
        .log
        .iter()
        .filter(|l| l.0 > stop + 1 && l.1.len() > 1 && l.1 != "<ok");
    assert_eq!(after.count(), 0, "{:?}", bench.log);
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn a_line_that_writes_memory_goes_alone_and_in_silence() {
    let options = VetOptions {
        memory_writers: MemoryWriters::Barrier,
        ..VetOptions::default()
    };
    let program = "G21 G90\nG1 X2 F300\nX4\nX6\nG10 L2 P2 X5\nG1 X8\nX1\n";
    let mut bench = Bench::with(program, options);
    assert_eq!(bench.finish().ending, Ending::Done);
    let at = bench.log.iter().position(|l| l.1 == "G10L2P2X5").unwrap();
    let before: Vec<&str> = bench.log[..at].iter().map(|l| l.1.as_str()).collect();
    let lines = before
        .iter()
        .filter(|l| l.len() > 1 && **l != "<ok")
        .count();
    assert_eq!(
        lines,
        before.iter().filter(|l| **l == "<ok").count(),
        "{before:?}"
    );
    assert_eq!(bench.log[at + 1].1, "<ok");
    assert!(
        bench.log[at + 2].0 >= bench.log[at + 1].0 + 50,
        "{:?}",
        &bench.log[at..]
    );
}

#[test]
fn one_dangerous_line_at_a_time() {
    let mut program = String::from("G21 G90 G94 G54 G17\nG0 Z5\n");
    for i in 0..40 {
        program.push_str(&format!(
            "G0 X{i}\nG1 Z-1 F600\nG1 X{i}.5\nG1 X{i}.6\nG1 X{i}.7\nG0 Z5\n"
        ));
    }
    let mut bench = Bench::plain(&program);
    let there = Cable::new(vec![8], vec![1000]);
    (bench.there, bench.back) = (there.clone(), there);
    assert_eq!(bench.finish().ending, Ending::Done);
    assert_eq!(bench.most_dangerous, 1);
    assert!(bench.most_in_flight > 20, "{}", bench.most_in_flight);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the cable's delays and cuts: no byte overflows the ring, every line is answered, the end is the program's.
    #[test]
    fn any_cable_carries_a_job_whole(
        delays in proptest::collection::vec(0u64..30, 1..20), cuts in proptest::collection::vec(1usize..40, 1..20), lines in 20usize..150,
    ) {
        let there = Cable::new(delays.clone(), cuts.clone());
        let back = Cable::new(delays, cuts);
        let job = Job::vet(&spiral(lines, 0.2)).unwrap();
        let mut bench = Bench::new(job, Controller::new(memory()), there, back);
        let outcome = bench.finish();
        prop_assert_eq!(&outcome.ending, &Ending::Done);
        prop_assert_eq!(outcome.acknowledged, outcome.total);
        prop_assert_eq!(bench.controller.bytes_lost(), 0);
        prop_assert!(bench.most_in_flight <= 128);
        prop_assert!((bench.controller.position() - Point::new(0.0, 0.0, 5.0)).norm() < 1e-9);
    }
}
