//! The cable is busy, or the planner is never empty.

use super::bench::{Bench, memory, spiral};
use super::cable::Cable;
use morsemill::controller::Controller;
use morsemill::kinematics::program_time;
use morsemill::link::{Ending, Job};

/// 115,200 baud, 8N1: 11.52 bytes a millisecond each way, and so many milliseconds more each way in a USB bridge.
fn over_a_real_cable(program: &str, fast: bool, delay: u64) -> (f64, f64, f64) {
    let mut cable = Cable::new(vec![delay], vec![1]);
    cable.rate = Some(11.52);
    let mut m = memory();
    if fast {
        for axis in 0..3 {
            m.set(110 + axis, 12_000.0);
            m.set(120 + axis, 3000.0);
        }
    }
    let job = Job::vet(program).unwrap();
    let settings = m.planner_settings(15);
    let planned = program_time(&job.events().unwrap(), &settings).total.0;
    let mut bench = Bench::new(job, Controller::new(m), cable.clone(), cable);
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Done);
    assert_eq!(bench.controller.bytes_lost(), 0);
    // The cutting alone: while the tool plunges before it the planner is full and the cable has nothing to do.
    let cuts: Vec<&(u64, String)> = bench
        .log
        .iter()
        .filter(|l| l.1.starts_with("G1X") || l.1.starts_with("G1Z"))
        .collect();
    let cuts = &cuts[100..cuts.len() - 20];
    let bytes: usize = cuts.iter().map(|l| l.1.len() + 1).sum();
    let busy = bytes as f64 / 11.52 / (cuts[cuts.len() - 1].0 - cuts[0].0) as f64;
    (busy, bench.controller.elapsed(), planned)
}

/// The law of throughput: on a finishing pass of 0.2 mm segments the cable is 95 % busy, or the planner is never empty (the job
/// takes no longer than the planner alone would).
#[test]
fn short_segments_keep_the_cable_or_the_planner_busy() {
    let mut links = String::from("G21 G90 G54 G94 G17\nM3 S1000\nG0 Z5\n");
    for i in 0..60 {
        let y = f64::from(i) * 0.3;
        links.push_str(&format!("G0 X0 Y{y:.3}\nG1 Z-1 F300\nF1500\n"));
        for k in 1..=20 {
            links.push_str(&format!(
                "G1 X{:.3} Z{:.3}\n",
                f64::from(k) * 0.2,
                -1.0 + 0.05 * f64::from(k % 3)
            ));
        }
        links.push_str("G0 Z5\n");
    }
    links.push_str("M30\n");
    // What the rule of dangerous lines costs where it costs most: fast, short plunges, rapids and retracts, each a dangerous line.
    let mut dots = String::from("G21 G90 G54 G94 G17\nM3 S1000\nG0 Z0.2\n");
    for i in 0..400 {
        dots.push_str(&format!(
            "G0 X{:.1}\nG1 Z-0.1 F6000\nG0 Z0.2\n",
            f64::from(i) * 0.3
        ));
    }
    dots.push_str("M30\n");
    let quick = spiral(3000, 0.2).replace("F1500", "F9000");
    for (name, program, fast) in [
        ("spiral at 1500 mm/min", spiral(1500, 0.2), false),
        ("spiral at 9000 mm/min", quick, true),
        ("60 passes with links", links, false),
        ("400 dots, nothing but dangerous lines", dots, true),
    ] {
        for delay in [0, 1, 2, 4] {
            let (busy, took, planned) = over_a_real_cable(&program, fast, delay);
            eprintln!(
                "{name}, {delay} ms of bridge: cable busy {:.1} %, took {took:.2} s, planner alone {planned:.2} s ({:+.2} %)",
                busy * 100.0,
                (took / planned - 1.0) * 100.0
            );
            assert!(
                delay > 2 || busy >= 0.95 || took <= planned * 1.005,
                "{name}"
            );
        }
    }
}
