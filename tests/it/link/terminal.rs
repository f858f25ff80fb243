//! The whole of `send` over a real pseudo-terminal.

use super::bench::spiral;
use morsemill::cli::send::{self, SendArgs};
use morsemill::controller::Pace;
use morsemill::kinematics::{Settings, program_time};
use morsemill::link::Job;
use morsemill::machine::Machine;

fn send_args(program: &std::path::Path, json: &std::path::Path, speed: Pace) -> SendArgs {
    SendArgs {
        program: program.to_path_buf(),
        machine: "longmill-30x30".to_string(),
        port: "sim".to_string(),
        dry_run: false,
        speed,
        json: Some(json.to_path_buf()),
        events: None,
        plain: true,
        tool_plate: None,
        take_up: Default::default(),
    }
}

/// Sends over a real pseudo-terminal; the report, and the planner's own time for the program.
fn over_a_pseudo_terminal(program: &str, speed: Pace) -> (u8, serde_json::Value, f64) {
    let dir = tempfile::tempdir().unwrap();
    let (file, json) = (dir.path().join("job.nc"), dir.path().join("out.json"));
    std::fs::write(&file, program).unwrap();
    let mut out = Vec::new();
    let code = send::run(&send_args(&file, &json, speed), &mut out);
    let report = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let machine = Machine::load("longmill-30x30").unwrap();
    let planned = program_time(
        &Job::vet(program).unwrap().events().unwrap(),
        &Settings::from(&machine),
    )
    .total
    .0;
    (code, report, planned)
}

#[test]
fn a_long_job_over_a_pseudo_terminal_takes_the_machine_time_that_was_planned() {
    for (lines, step) in [(8_000, 0.2), (3_000, 0.1), (300, 5.0)] {
        let start = std::time::Instant::now();
        let (code, report, planned) = over_a_pseudo_terminal(&spiral(lines, step), Pace::Unbound);
        eprintln!(
            "{lines} lines of {step} mm: {report} planned {planned:.2} s, real {:?}",
            start.elapsed()
        );
        assert_eq!(code, 0);
        assert_eq!(report["result"], "done");
        assert_eq!(report["lines"], report["acknowledged"]);
        assert_eq!(
            report["final_position_mm"],
            serde_json::json!([0.0, 0.0, 5.0])
        );
        let measured = report["machine_time_s"].as_f64().unwrap();
        assert!(
            (measured / planned - 1.0).abs() < 0.03,
            "{measured} s measured, {planned} s planned"
        );
    }
}

#[test]
fn the_same_in_step_with_a_clock() {
    let (code, report, planned) = over_a_pseudo_terminal(&spiral(400, 0.5), Pace::Times(10.0));
    assert_eq!((code, &report["result"]), (0, &serde_json::json!("done")));
    let measured = report["machine_time_s"].as_f64().unwrap();
    // A busy computer may starve the planner here, as a slow host would; it never makes the job shorter.
    assert!(
        measured > 0.97 * planned,
        "{measured} s measured, {planned} s planned"
    );
}
