//! What a program tells, and what it only seems to tell.
#![allow(clippy::unwrap_used)]

use super::{Steps, TranslateError, unknown_state};
use crate::cldata::{Coolant, Step};
use crate::gcode::{Dialect, Interpreter, Reading};
use crate::geom::Point;
use crate::units::{Mm, MmPerMin, Seconds};
use std::io::Cursor;

fn program(text: &str, dialect: Dialect) -> Steps<Cursor<&[u8]>> {
    let from = Cursor::new(text.as_bytes());
    Steps::new(Interpreter::from_state(from, unknown_state(dialect), Reading::default()).unwrap())
}

fn read(text: &str, dialect: Dialect) -> Result<Vec<Step>, TranslateError> {
    program(text, dialect)
        .map(|s| s.map(|(_, step)| step))
        .collect()
}

fn refusal(text: &str, dialect: Dialect) -> String {
    read(text, dialect).unwrap_err().to_string()
}

fn rapid(x: Option<f64>, y: Option<f64>, z: Option<f64>) -> Step {
    Step::Rapid { to: [x, y, z] }
}

fn feed(x: f64, y: f64, z: f64, feed: f64) -> Step {
    Step::Feed {
        to: Point::new(x, y, z),
        bow: None,
        feed: MmPerMin(feed),
    }
}

#[test]
fn axes_are_told_only_once_the_program_has_named_them() {
    let steps = read(
        "G21 G90\nG0 Z5\nX0\nY0\nG1 Z-1 F100\nX10\nM30\n",
        Dialect::Grbl,
    )
    .unwrap();
    assert_eq!(
        steps,
        [
            rapid(None, None, Some(5.0)),
            rapid(Some(0.0), None, Some(5.0)),
            rapid(Some(0.0), Some(0.0), Some(5.0)),
            feed(0.0, 0.0, -1.0, 100.0),
            feed(10.0, 0.0, -1.0, 100.0),
            Step::End,
        ]
    );
}

#[test]
fn what_hangs_on_an_unknown_place_is_refused() {
    for (text, what) in [
        (
            "G21\nG0 Z5\nG1 X5 F100\nM2",
            "3:1 this move hangs on where the tool stands before, and the program has not said that for X, Y",
        ),
        ("G21 G91\nG0 Z5\nM2", "2:1 this move hangs on"),
        ("G21\nG0 X0 Y0\nG91 G0 Z5\nM2", "3:1 this move hangs on"),
        (
            "G0 X0 Y0 Z5\nG53 G0 Z0\nG1 X5 F100\nM2",
            "3:1 this move hangs on where the tool stands before, and the program has not said that for Z",
        ),
        ("G0 X0 Y0 Z5\nG55\nG1 X5 F100\nM2", "for Y, Z"),
        (
            "G0 X0 Y0 Z5\nG28\nM2",
            "2:1 this line goes to a place stored in the machine",
        ),
        ("G0 X0 Y0 Z5\nG30 Z6\nM2", "stored in the machine"),
        (
            "G0 X0 Y0 Z5\nG92 X1\nG0 X5\nM2",
            "2:1 this line sets a shift of the coordinates",
        ),
        (
            "G0 X0 Y0 Z5\nG10 L2 P1 X0\nM2",
            "2:1 this line sets a work offset",
        ),
        (
            "G0 X0 Y0 Z5\nG43.1 Z2\nG0 X1\nM2",
            "2:1 this line sets a tool length",
        ),
        (
            "G0 X0 Y0 Z5\nG38.2 Z-5 F50\nM2",
            "a probing move cannot be translated",
        ),
        (
            "G0 X0 Y0 Z5\nG53 G1 X0 F100\nM2",
            "a feed move in machine coordinates",
        ),
        ("G0 X0 Q\n", "1:7 Q has no number"),
    ] {
        let found = refusal(text, Dialect::Grbl);
        assert!(found.contains(what), "{text:?}: {found}");
    }
    let found = refusal("G0 X0 Y0 Z5\nT2 M6\nG43 H3\nG0 X1\nM2", Dialect::LinuxCnc);
    assert!(
        found.contains("length of tool 3 is used with tool 2"),
        "{found}"
    );
}

#[test]
fn machine_places_keep_their_coordinates_and_hide_the_work_ones() {
    let steps = read(
        "G21 G54\nG53 G0 Z0\nG0 X1 Y2\nG53 G0 X-5 Y-10.5\nG0 X1 Y2 Z5\nM30",
        Dialect::Grbl,
    )
    .unwrap();
    assert_eq!(
        steps,
        [
            Step::MachineRapid {
                to: [None, None, Some(0.0)]
            },
            rapid(Some(1.0), Some(2.0), None),
            Step::MachineRapid {
                to: [Some(-5.0), Some(-10.5), None]
            },
            rapid(Some(1.0), Some(2.0), Some(5.0)),
            Step::End,
        ]
    );
    // The same number in both systems is not the same place.
    let steps = read("G0 Z0\nG53 G0 Z0\nM30", Dialect::Grbl).unwrap();
    assert_eq!(
        steps[1],
        Step::MachineRapid {
            to: [None, None, Some(0.0)]
        }
    );
    // And the same number in two work systems is not either.
    let steps = read("G0 X5\nG55 G0 X5\nM30", Dialect::Grbl).unwrap();
    assert_eq!(
        steps[1..3],
        [Step::WorkOffset(2), rapid(Some(5.0), None, None)]
    );
}

#[test]
fn modes_are_gone() {
    let text = "G20 G90 T3 M6\nG43 H3\nG64 P0.0001\nM3 S1000\nM8\nG0 X1 Y1 Z1\nG91 G93\nG1 X1 F2\nG2 X1 I0.5 F4\nM9\nG4 P1.5\nM0\nM2\n";
    let mut all = program(text, Dialect::LinuxCnc);
    let steps: Vec<Step> = all.by_ref().map(|s| s.unwrap().1).collect();
    let tolerance = all.path_tolerance.unwrap();
    assert!((tolerance.0 - Mm(0.00254).0).abs() < 1e-12);
    assert_eq!(steps[0], Step::Tool { number: 3 });
    assert!(matches!(steps[1], Step::Spindle { direction: 1, .. }));
    assert_eq!(steps[2], Step::Coolant(Coolant::Flood));
    assert_eq!(steps[3], rapid(Some(25.4), Some(25.4), Some(25.4)));
    // Half a minute for an inch.
    let Step::Feed { to, feed, .. } = &steps[4] else {
        panic!("{:?}", steps[4])
    };
    assert!((to.x - 50.8).abs() < 1e-9 && (feed.0 - 50.8).abs() < 1e-9);
    let Step::Feed {
        bow: Some(bow),
        feed,
        ..
    } = &steps[5]
    else {
        panic!("{:?}", steps[5])
    };
    assert!((bow.sweep + std::f64::consts::PI).abs() < 1e-9);
    assert!((feed.0 - 4.0 * 12.7 * std::f64::consts::PI).abs() < 1e-6);
    assert_eq!(
        steps[6..],
        [
            Step::Coolant(Coolant::Off),
            Step::Dwell(Seconds(1.5)),
            Step::Pause { optional: false },
            Step::End
        ]
    );
}

#[test]
fn a_program_without_an_end_gets_one_and_a_note() {
    let mut all = program("G0 Z5\n", Dialect::Grbl);
    let steps: Vec<Step> = all.by_ref().map(|s| s.unwrap().1).collect();
    assert_eq!(steps.last(), Some(&Step::End));
    assert_eq!(
        all.notes[0].text,
        "the program has no M2 or M30: an end was added"
    );
}

#[test]
fn flood_and_mist_together_are_kept() {
    let steps = read("G21 G90\nM7\nM8\nG0 X1\nM9\nM2\n", Dialect::LinuxCnc).unwrap();
    assert_eq!(
        steps,
        [
            Step::Coolant(Coolant::Mist),
            Step::Coolant(Coolant::Both),
            rapid(Some(1.0), None, None),
            Step::Coolant(Coolant::Off),
            Step::End,
        ]
    );
}
