//! The path watch in a running job: what is not done as it was sent stops it, and nothing else does.

use super::bench::{Bench, at_rest_for_good, line_of, memory, spiral};
use morsemill::controller::{Controller, Memory, Pins, Switches};
use morsemill::link::{Command, Ending};

/// A machine that remembers offsets and places, and reports in all the ways there are.
fn machines() -> Vec<(&'static str, Memory)> {
    let mut plain = memory();
    plain.places[0] = [-100.0, -90.0, -60.0];
    plain.places[1] = [-110.5, -95.25, -62.125];
    plain.places[6] = [-95.0, -80.0, -20.0];
    plain.places[7] = [-90.0, -85.0, -22.0];
    let with = |settings: &[(u16, f64)]| {
        let mut m = plain.clone();
        settings.iter().for_each(|(n, v)| {
            m.set(*n, *v);
        });
        m
    };
    vec![
        ("plain", plain.clone()),
        ("inches", with(&[(13, 1.0)])),
        ("work positions", with(&[(10, 0.0)])),
        (
            "work positions in inches, buffers",
            with(&[(10, 2.0), (13, 1.0)]),
        ),
        ("coarse steps", with(&[(100, 5.0), (101, 5.0), (102, 20.0)])),
        ("coarse arcs", with(&[(12, 0.2)])),
    ]
}

const EVERYTHING: &str = "G21 G90 G17 G94 G54\nM3 S900\nG0 X5 Y5 Z5\nG1 Z-1 F600\nG2 X5 Y5 I4 J0 F1500\nG3 X12 Y9 R9\nG2 X5 Y5 Z1 I-3.5 J-2\n\
    G18\nG2 X9 Z1 I2 K0\nG19\nG3 Y9 Z1 X11 J2 K0\nG17\nG55\nG1 X12 Y8 Z2\nG92 X0 Y0\nG1 X3 Y1\nG92.1\nG91\nX1 Y1\nX-0.5\nG90\nG20\nG1 X0.6 F40\n\
    G21\nG93\nG1 X12 F30\nG94\nG1 F300\nX13 Z2\nG53 G0 Z-55\nG28 X9 Y9\nG43.1 Z0.5\nG0 Z3\nG49\nG4 P0.3\nG30\nG54\nG1 X5 F2000\nM5\nM30\n";

#[test]
fn a_job_of_everything_keeps_to_its_way_however_it_is_reported() {
    for (name, memory) in machines() {
        for delay in [1, 40] {
            let mut bench = Bench::on(Controller::new(memory.clone()), EVERYTHING, delay);
            let outcome = bench.finish();
            assert_eq!(
                outcome.ending,
                Ending::Done,
                "{name}, {delay} ms: {:?}",
                bench.log
            );
        }
    }
}

#[test]
fn holds_overrides_and_doors_do_not_leave_the_way() {
    let program = spiral(150, 0.3);
    let mut bench = Bench::on(Controller::new(machines()[0].1.clone()), &program, 15);
    bench.ticks(2500);
    for turn in 0..6 {
        for command in [
            Command::Feed(morsemill::link::Step::Minus10),
            Command::Hold,
            Command::Resume,
            Command::Rapid(morsemill::link::RapidStep::Quarter),
            Command::Door,
        ] {
            bench.command(command);
            bench.ticks(70 + 40 * turn);
        }
        bench.command(Command::Resume);
        bench.ticks(800);
    }
    for _ in 0..20 {
        if bench.session.outcome().is_none() {
            bench.command(Command::Resume);
            bench.ticks(1000);
        }
    }
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
}

#[test]
fn a_crawl_of_a_millimetre_a_minute_is_on_its_way() {
    let mut bench = Bench::plain("G21G90\nG1 X0.4 Y0.1 F1\nX0.42\nG1 X2 F300\n");
    assert_eq!(bench.finish().ending, Ending::Done);
}

/// A line that arrives as another, as legal as itself.
#[test]
fn a_legal_wrong_line_is_noticed_by_where_it_leads() {
    let program = spiral(700, 0.2);
    let mut bench = Bench::plain(&program);
    let line = line_of(&program, 300);
    let y = line.find('Y').unwrap();
    let damaged = format!("{}Y1{}", &line[..y], &line[y + 1..].replace('-', ""));
    bench.noise = Some((line.clone().leak(), damaged.leak()));
    let outcome = bench.finish();
    let Ending::OffPath(off) = &outcome.ending else {
        panic!("{outcome:?}");
    };
    assert!(
        off.distance > 0.05 && off.lines.0 <= 300 && off.lines.1 >= 300,
        "{off:?}"
    );
    assert!(off.lines.1 - off.lines.0 < 60, "{off:?}");
    assert!(bench.heard("the machine is not where the lines it was sent lead"));
    let text = outcome.ending.to_string();
    assert!(
        text.contains("so it is not doing what it was sent: bytes were damaged on the cable, an answer was lost or doubled, or somebody else moves it"),
        "{text}"
    );
    assert_eq!(outcome.ending.key(), "error off path");
    assert!(outcome.position_kept);
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn one_damaged_report_is_asked_for_again_and_stops_nothing() {
    let mut bench = Bench::plain("G21G90G54G17G94\nG1 X20 F600\n");
    bench.ticks(1500);
    bench
        .back
        .send(bench.now, b"<Run|MPos:7.000,99.000,0.000|FS:600,0>\r\n");
    assert_eq!(bench.finish().ending, Ending::Done);
    let mut bench = Bench::plain("G21G90G54G17G94\nG1 X20 F600\n");
    bench.ticks(1500);
    for _ in 0..2 {
        bench
            .back
            .send(bench.now, b"<Run|MPos:7.000,99.000,0.000|FS:600,0>\r\n");
    }
    let ending = bench.finish().ending;
    assert!(matches!(ending, Ending::OffPath(_)), "{ending:?}");
}

/// Somebody else sends a move of his own.
#[test]
fn another_sender_on_the_cable_ends_the_job() {
    let mut bench = Bench::plain("G21G90G54G17G94\nG1 X20 F600\nX21\nX22\nX23\n");
    bench.ticks(1500);
    bench.controller.feed(b"G0 Y9\n");
    let outcome = bench.finish();
    assert!(
        matches!(outcome.ending, Ending::OffPath(_) | Ending::Damaged { .. }),
        "{outcome:?}"
    );
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn behind_a_probe_the_way_goes_on_from_where_it_touched() {
    let mut controller = Controller::new(machines()[0].1.clone());
    controller.set_switches(Switches {
        probe_z: Some(-900),
        ..Switches::default()
    });
    let program = "G21 G90 G17 G94 G54\nG38.2 Z40 F200\nG92 Z1\nG1 Z3 F600\nX2\nG91\nX1 Z1\nG90\nG92.1\nG0 Z58\nM30\n";
    let mut bench = Bench::on(controller, program, 5);
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Done,
        "{} {:?}",
        outcome.ending,
        bench.log
    );
    // Nothing was read behind the probe before its place was known.
    let probed = bench
        .log
        .iter()
        .position(|l| l.1.starts_with("G38.2"))
        .unwrap();
    let next = bench.log[probed + 1..]
        .iter()
        .find(|l| l.1.starts_with('G'))
        .unwrap();
    let answered = bench.log[probed..].iter().find(|l| l.1 == "<ok").unwrap();
    assert!(next.0 > answered.0);
}

#[test]
fn a_probe_that_misses_without_alarm_goes_on_too() {
    let program = "G21 G90 G17 G94 G54\nG38.3 Z-2 F600\nG0 Z1\nG1 X3 F900\nM30\n";
    let mut bench = Bench::on(Controller::new(memory()), program, 5);
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
}

/// The operator jogs, touches off, and leaves other modes behind; the program goes on in its own, from where the machine stands.
#[test]
fn behind_a_tool_change_the_way_goes_on_from_where_the_operator_left_it() {
    let program = "G21 G90 G54 G94 G17\nM3 S1000\nG1 X5 F600\nT2 M6\nX7\nY3\nM3 S900\nZ2\nM30\n";
    let mut bench = Bench::on(Controller::new(memory()), program, 5);
    bench.until("change to tool 2");
    for line in ["G91\n", "G0 Z9\n", "G0 X-1\n", "G10 L20 P1 Z4\n", "G20\n"] {
        bench.controller.feed(line.as_bytes());
        bench.ticks(900);
    }
    bench.command(Command::Resume);
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Done,
        "{} {:?}",
        outcome.ending,
        bench.log
    );
    assert!(
        bench.heard("mm from where the tool was changed"),
        "{:?}",
        bench.news
    );
    assert_eq!(outcome.position, Some([7.0, 3.0, 2.0]));
    // The bare `X7` is a cut, not the rapid that the operator left behind.
    let modes = bench
        .log
        .iter()
        .find(|l| l.1.contains("G54G17G21G90G94"))
        .unwrap();
    assert!(
        modes.1.starts_with("G1") && modes.1.contains("F600"),
        "{modes:?}"
    );
}

/// The new tool's length goes into every work offset; those that were not active are looked at when they are chosen.
#[test]
fn offsets_set_anew_at_a_tool_change_are_found_out_when_they_are_chosen() {
    let program = "G21 G90 G54 G94 G17\nM3 S1000\nG1 X5 F600\nT2 M6\nG1 Z2\nG55 G1 X7 F900\nY3\nG54\nX2\nG55\nX1\nG0 X3\nM30\n";
    let mut m = memory();
    m.places[1] = [10.0, 5.0, 0.0];
    let mut bench = Bench::on(Controller::new(m), program, 5);
    bench.until("change to tool 2");
    for line in ["G10 L2 P1 Z-4\n", "G10 L2 P2 X10 Y5 Z-4\n"] {
        bench.controller.feed(line.as_bytes());
        bench.ticks(900);
    }
    bench.command(Command::Resume);
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Done,
        "{} {:?}",
        outcome.ending,
        bench.log
    );
    let place = bench.controller.position();
    assert_eq!([place.x, place.y, place.z], [13.0, 8.0, -2.0]);
}

/// A whole turn that begins and ends between two steps is one behind a tool change too.
#[test]
fn a_whole_turn_behind_a_tool_change_stays_one() {
    let program = "G21 G90 G54 G94 G17\nM3 S1000\nG1 X5.0016 Y1.0013 F600\nT2 M6\nG2 X5.0016 Y1.0013 I2 J1 F900\nM30\n";
    let mut bench = Bench::on(Controller::new(memory()), program, 5);
    bench.until("change to tool 2");
    bench.command(Command::Resume);
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Done,
        "{} {:?}",
        outcome.ending,
        bench.log
    );
    assert!(bench.controller.elapsed() > 1.0);
}

#[test]
fn behind_a_tool_change_nothing_relies_on_an_arc() {
    let program = "G21 G90 G54 G94 G17\nG2 X5 I2.5 F600\nT2 M6\nX9 I2\nM30\n";
    let mut bench = Bench::on(Controller::new(memory()), program, 5);
    bench.until("change to tool 2");
    bench.command(Command::Resume);
    let ending = bench.finish().ending;
    assert!(
        matches!(
            ending,
            Ending::Refused {
                line: 4,
                code: 31,
                ..
            }
        ),
        "{ending:?}"
    );
}

#[test]
fn a_setting_that_changes_what_a_step_is_worth_is_looked_at() {
    let program = "G21 G90 G54 G94 G17\nG1 X5 F600\n$100=300\nG1 X4\nX6\nM30\n";
    let mut bench = Bench::on(Controller::new(memory()), program, 5);
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Done,
        "{} {:?}",
        outcome.ending,
        bench.log
    );
}

#[test]
fn a_machine_that_was_moved_since_it_was_asked_is_found_out() {
    let mut bench = Bench::plain("G21 G90 G54 G94 G17\nG1 X9 F300\nX12\n");
    bench.until("Started");
    // A pendant's doing, in the same instant.
    bench.controller.feed(b"$J=G91Y5F3000\n");
    let outcome = bench.finish();
    assert_ne!(outcome.ending, Ending::Done);
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn pins_nobody_uses_do_not_disturb() {
    let mut bench = Bench::plain(&spiral(100, 0.3));
    bench.ticks(1500);
    bench.controller.set_pins(Pins {
        probe: true,
        limit: [true, false, false],
        ..Pins::default()
    });
    assert_eq!(bench.finish().ending, Ending::Done);
}
