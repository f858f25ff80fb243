//! Programs of every shape: what stands in the middle, at the end, or not at all.

use super::bench::{Bench, at_rest_for_good, memory};
use morsemill::controller::{Controller, Switches};
use morsemill::link::vet::OptionalStops;
use morsemill::link::{Command, Ending, Job, VetOptions};

fn done(bench: &mut Bench) -> morsemill::link::Outcome {
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Done,
        "{} {:?}",
        outcome.ending,
        bench.log
    );
    assert_eq!(outcome.acknowledged, outcome.total);
    outcome
}

#[test]
fn programs_end_as_they_like() {
    for (program, end) in [
        ("G21G90\nG1X4F900\n", [4.0, 0.0, 0.0]),
        ("%\nO1000\nG21G90\nG1X4F900\nM30\n%\n", [4.0, 0.0, 0.0]),
        ("G21G90\nG1X4F900\nM2\nG21G90\nG1X5F900\n", [5.0, 0.0, 0.0]),
        ("G21G90\nG1X4F900\nM30\nX5\n%\nY2\nM30\n", [5.0, 2.0, 0.0]),
        ("G21G90\nG1X4F900\nM1\nX6", [6.0, 0.0, 0.0]),
        ("(a)\n\n;b\nM5\n", [0.0, 0.0, 0.0]),
        ("G21G90\nG1X4F900 M30", [4.0, 0.0, 0.0]),
        ("G4P0.5\n", [0.0, 0.0, 0.0]),
    ] {
        let program = program.replace("O1000\n", "");
        let mut bench = Bench::plain(&program);
        assert_eq!(done(&mut bench).position, Some(end), "{program:?}");
        // Done is told only behind the last answer, at rest.
        assert!(!bench.controller.is_moving());
    }
}

#[test]
fn nothing_to_send_is_refused_and_so_are_dollar_lines() {
    for (program, says) in [
        ("", "the program has no line to send"),
        (
            "(only)\n; comments\n\n%\n",
            "the program has no line to send",
        ),
        ("G0X1\n$H\n", "2:1"),
        ("G0X1\n$J=X4F100\n", "2:1"),
        ("G0X1\n$10=3\n", "2:1"),
        ("G0X1\n$X\n", "2:1"),
        ("G0X1\n$\n", "2:1"),
    ] {
        let errors = Job::vet(program).unwrap_err();
        let text = errors[0].to_string();
        assert!(text.contains(says), "{program:?}: {text}");
    }
}

#[test]
fn stops_in_the_program_wait_for_the_operator_each_by_itself() {
    let mut bench = Bench::with(
        "G21G90\nG1X2F900\nM0 (one)\nM0 (two)\nX3\nM1 (three)\nX4\n",
        VetOptions {
            optional_stops: OptionalStops::Stop,
            ..VetOptions::default()
        },
    );
    for (prompt, place) in [("(one)", 2.0), ("(two)", 2.0), ("(three)", 3.0)] {
        bench.until(prompt);
        bench.ticks(1200);
        assert_eq!(bench.controller.position().x, place);
        bench.command(Command::Resume);
    }
    done(&mut bench);
    assert_eq!(bench.times("~").len(), 3, "{:?}", bench.log);
}

/// A slow board shows the hold that was left for long; the program's own stop behind it is not run over.
#[test]
fn a_resume_is_never_repeated_into_the_programs_own_stop() {
    for delay in [1, 150, 400] {
        let program = "G21G90\nG1X6F600\nM0 (look)\nX9\n";
        let mut bench = Bench::on(Controller::new(memory()), program, delay);
        // At 10 mm/s, a millimetre before the stop once the hold has arrived.
        bench.until_it(|b| b.controller.position().x > 4.5 - 0.01 * delay as f64);
        bench.command(Command::Hold);
        bench.until("on hold, at rest");
        bench.ticks(1000);
        assert!(bench.controller.position().x < 6.0);
        bench.command(Command::Resume);
        bench.ticks(20_000);
        assert!(bench.heard("(look)"), "{delay}: {:?}", bench.news);
        assert_eq!(
            bench.controller.position().x,
            6.0,
            "{delay}: {:?}",
            bench.log
        );
        bench.command(Command::Resume);
        done(&mut bench);
    }
}

#[test]
fn a_hold_at_the_programs_own_stop_tells_of_both() {
    let mut bench = Bench::plain("G21G90\nG1X6F600\nM0 (look)\nX9\n");
    bench.until_it(|b| b.controller.position().x == 6.0);
    bench.ticks(60);
    bench.command(Command::Hold);
    bench.until("on hold, at rest; the program pauses at line 3 (look): resume when ready");
    bench.command(Command::Resume);
    done(&mut bench);
}

#[test]
fn long_dwells_and_probes_and_crawls_are_no_stalls_that_stop() {
    let mut bench = Bench::plain("G21G90\nG1X1F900\nG4P60\nX2\n");
    done(&mut bench);
    assert!(bench.heard("Waiting { line: 3 }"));
    let mut controller = Controller::new(memory());
    controller.set_switches(Switches {
        probe_z: Some(-2500),
        ..Switches::default()
    });
    let mut bench = Bench::on(controller, "G21G90\nG38.2Z-20F20\nG0Z1\n", 3);
    done(&mut bench);
    assert!(bench.heard("Waiting { line: 2 }"), "{:?}", bench.news);
    let mut bench = Bench::plain("G21G90\nG1X1F2\nG2X1I1F30\n");
    done(&mut bench);
}

#[test]
fn a_probe_that_misses_is_an_alarm_that_says_so() {
    let mut bench = Bench::plain("G21G90\nG38.2Z-2F600\nG0Z1\n");
    let outcome = bench.finish();
    let text = outcome.ending.to_string();
    assert!(
        text.starts_with("ALARM:5 while line 2 was waiting: "),
        "{text}"
    );
    assert!(outcome.position_kept && bench.times("G0Z1").is_empty());
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn memory_writers_in_a_row_each_go_alone() {
    let program = "G21G90G54\nG1X2F600\nG10L2P2X5\nG10L2P3X6\nG28.1\n$110=2900\n$111=2900\nG55\nG1X1\nG54\nX3\n";
    let mut bench = Bench::on(Controller::new(memory()), program, 4);
    done(&mut bench);
    assert_eq!(bench.controller.memory().get(110), 2900.0);
    assert_eq!(bench.controller.memory().places[1][0], 5.0);
    for writer in ["G10L2P2X5", "G10L2P3X6", "G28.1", "$110=2900", "$111=2900"] {
        let at = bench.log.iter().position(|l| l.1 == writer).unwrap();
        assert_eq!(bench.log[at + 1].1, "<ok", "{writer}: {:?}", bench.log);
        assert!(bench.log[at + 2].0 >= bench.log[at + 1].0 + 50, "{writer}");
    }
}

#[test]
fn an_error_in_the_very_last_line_is_named() {
    let mut bench = Bench::plain("G21G90\nG1X4F900\nX5\nG1Y7\n");
    bench.noise = Some(("G1Y7", "G1YY"));
    let outcome = bench.finish();
    let text = outcome.ending.to_string();
    assert!(
        text.starts_with("line 4 (`G1Y7`): the controller refused it with error:2"),
        "{text}"
    );
    assert!(outcome.position_kept);
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn offsets_of_all_systems_and_a_shift_end_where_they_should() {
    let program = "G21G90G54\nG1X2F900\nG55\nX2\nG92X0Y0\nX1\nG92.1\nG54\nX3\nM30\n";
    let mut m = memory();
    m.places[1] = [5.0, 1.0, 0.0];
    let mut bench = Bench::on(Controller::new(m), program, 10);
    assert_eq!(done(&mut bench).position.map(|p| p[0]), Some(3.0));
}
