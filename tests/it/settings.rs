//! Settings from a file: a program timed under them takes as long as the simulated controller takes that has them.
#![allow(clippy::unwrap_used)]

use morsemill::controller::replay::time_program;
use morsemill::controller::{Build, Memory};
use morsemill::gcode::Dialect;
use morsemill::machine::{Machine, SettingsFile};
use morsemill::simulate::{DryRunOptions, Stock, dry_run};
use std::fmt::Write;

/// Short segments, long lines, arcs, a dwell, standstills by spindle and coolant, rapids, G93. Ends with a motion, as the controller's own
/// time does.
fn program() -> String {
    let mut text = String::from("G21 G90 G94\nM3 S8000\nG0 Z2\nG0 X10 Y5\nG1 Z-0.5 F200\nF1500\n");
    for k in 0..600 {
        let a = 0.05 * f64::from(k);
        let r = 5.0 + 0.02 * f64::from(k);
        writeln!(
            text,
            "X{:.3} Y{:.3} Z{:.3}",
            20.0 + r * a.cos(),
            20.0 + r * a.sin(),
            -0.5 + 0.1 * (3.0 * a).sin()
        )
        .unwrap();
    }
    text += "G4 P0.3\nM8\nG0 Z5\nX0 Y0\nS9000\nG1 Z0 F300\nG2 X10 Y0 I5 J0 F900\nG3 X10 Y0 I4 J0\nM9\nG93\nG1 X0 F30\nG94\n";
    for k in 0..40 {
        writeln!(text, "G1 X{} Y{} F2500", k % 7, k % 11).unwrap();
    }
    text + "G0 Z5\nX1\n"
}

#[test]
fn a_program_timed_under_a_file_of_settings_takes_the_controllers_own_time() {
    let text = program();
    let plain = Machine::load("longmill-30x30").unwrap();
    let judged = DryRunOptions::new(0.02, Stock::Allowance(0.0));
    let mut times = vec![];
    for settings in [
        "$110=4000\n",
        "$1=200\n",
        "\u{feff}$1=255 (step idle delay, msec)\r\n$13=1 (report inches, bool)\r\n",
        "$1=0\n$120=50\n$121=400\n$122=20\n",
        "$110=900\n$111=700\n$112=150\n$11=0.002\n",
        "$100=80\n$101=26.667\n$102=400\n$12=0.05\n",
        "$120=3000.000 (x accel, mm/sec^2)\n$121=3000.000\n$122=800.000\n$11=0.200\nok\n",
    ] {
        let file = SettingsFile::read("mill.txt", settings).unwrap();
        let mut machine = plain.clone();
        file.apply(&mut machine);
        let run = dry_run(&text, Dialect::Grbl, &machine, None, &judged);
        // As `controller --settings` has it: the machine's own figures, and those of the file.
        let mut memory = Memory::of_machine(&plain);
        for s in &file.settings {
            memory.set(s.number, s.value);
        }
        let own = time_program(memory, Build::default(), &text).unwrap();
        assert_eq!(own.errors, 0);
        let off = run.time_s.total / own.motion_s - 1.0;
        eprintln!(
            "{settings:?}: {:.4} s, the controller {:.4} s ({:+.4} %)",
            run.time_s.total,
            own.motion_s,
            100.0 * off
        );
        assert!(off.abs() < 1e-3, "{settings:?}: {off}");
        times.push(own.motion_s);
    }
    // They do matter.
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 0.05);
    assert!(times.len() >= 6, "{times:?}");
}
