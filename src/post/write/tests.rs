//! Programs written, and judged by eye, by rule and against a hand-made record.
#![allow(clippy::unwrap_used)]

use super::super::{Post, Refusal, Spot, Units, write};
use super::Coolant;
use crate::cldata::Job;
use crate::geom::Point;
use crate::geom::Point2;
use crate::toolpath::{Move, MoveKind, Section, Toolpath, Turn};
use crate::units::{Mm, MmPerMin, Rpm, Seconds};

fn go(kind: MoveKind, x: f64, y: f64, z: f64) -> Move {
    Move::straight(kind, Point::new(x, y, z))
}

fn job() -> Job {
    Job {
        header: vec![
            "part: two-peaks.stl (65 x 65 x 20 mm)".into(),
            "tool: ball:6, tip at program Z".into(),
            "error budget: facets 2 \u{b5}m, chord 1 \u{b5}m, rounding 0.5 \u{b5}m, cusp 20 \u{b5}m, everything together 23.5 \u{b5}m".into(),
        ],
        feed: MmPerMin(1500.0),
        plunge: MmPerMin(500.0),
        speed: Rpm(18_000.0),
        tool_number: 1,
        spin_up: Seconds(3.0),
        coolant: Coolant::Off,
        path_tolerance: None,
    }
}

/// Two features, every kind of move, one move that rounds to nothing (index 4).
fn path() -> Toolpath {
    use MoveKind::*;
    Toolpath {
        moves: vec![
            go(Rapid, 1.0, 2.0, 5.0),
            go(Rapid, 1.0, 2.0, 0.5),
            go(Plunge, 1.0, 2.0, -1.0),
            go(Cut, 10.0, 2.0, -1.25),
            go(Cut, 10.0001, 2.0, -1.25),
            go(Cut, 10.0, 3.0, -1.25),
            go(Link, 10.0, 3.5, -1.3),
            go(Cut, 1.0, 3.5, -1.0625),
            go(Retract, 1.0, 3.5, 5.0),
            go(Rapid, -20.0, 3.5, 5.0),
            go(Plunge, -20.0, 3.5, -2.0),
            go(Cut, -20.0, 8.0, -2.0),
            go(Retract, -20.0, 8.0, 1.0),
        ],
        sections: vec![
            Section {
                name: "peak 1".into(),
                first_move: 0,
            },
            Section {
                name: "pit 2".into(),
                first_move: 9,
            },
        ],
        safe_z: 5.0,
    }
}

/// A line without its comment and number.
fn words(line: &str) -> &str {
    line.split('(').next().unwrap().trim()
}

#[test]
fn golden_programs() {
    for (name, _) in crate::post::BUILT_IN {
        let post = Post::load(name).unwrap();
        let text = write(&path(), &job(), &post).unwrap().text;
        golden(&format!("{name}.nc"), &text);
        golden(
            &format!("{name}.specimen.nc"),
            &crate::post::specimen_text(&post).unwrap(),
        );
    }
}

fn golden(name: &str, text: &str) {
    {
        let file = format!("{}/tests/golden/{name}", env!("CARGO_MANIFEST_DIR"));
        if std::env::var("UPDATE").is_ok_and(|v| v == "1") {
            std::fs::write(&file, text).unwrap();
        }
        let golden = std::fs::read_to_string(&file).unwrap();
        assert_eq!(
            text, golden,
            "{file} differs; UPDATE=1 refreshes it when the change is meant"
        );
    }
}

#[test]
fn lines_of_moves_point_at_what_they_caused() {
    let post = Post::load("grbl").unwrap();
    let posted = write(&path(), &job(), &post).unwrap();
    let lines: Vec<&str> = posted.text.lines().collect();
    let at = |i: usize| words(lines[posted.line_of_move[i] - 1]);
    assert_eq!(posted.line_of_move.len(), path().moves.len());
    assert_eq!(at(0), "G0 X1 Y2");
    assert_eq!(at(1), "Z0.5");
    assert_eq!(at(2), "G1 Z-1 F500");
    assert_eq!(at(3), "X10 Z-1.25 F1500");
    assert_eq!(
        posted.line_of_move[4], posted.line_of_move[3],
        "a move that rounds to nothing"
    );
    assert_eq!(at(5), "Y3");
    assert_eq!(at(6), "Y3.5 Z-1.3");
    assert_eq!(at(7), "X1 Z-1.063", "a true half goes away from zero");
    assert_eq!(at(8), "G0 Z5");
    assert_eq!(at(9), "X-20");
    assert!(posted.line_of_move.is_sorted());
}

#[test]
fn a_move_may_be_slower_than_the_job_and_never_faster() {
    let post = Post::load("grbl").unwrap();
    let mut path = path();
    path.moves[6].feed = Some(MmPerMin(600.0));
    path.moves[7].feed = Some(MmPerMin(9000.0));
    let posted = write(&path, &job(), &post).unwrap();
    let lines: Vec<&str> = posted.text.lines().collect();
    let at = |i: usize| words(lines[posted.line_of_move[i] - 1]);
    assert_eq!(at(6), "Y3.5 Z-1.3 F600");
    assert_eq!(at(7), "X1 Z-1.063 F1500");
    for wrong in [0.0, -1.0, 1e-9, f64::NAN] {
        path.moves[6].feed = Some(MmPerMin(wrong));
        let error = write(&path, &job(), &post).unwrap_err();
        assert_eq!(error.spot, Spot::Move(6));
        let text = error.to_string();
        assert!(
            text.starts_with("post grbl: move 6: its feed in mm/min is"),
            "{text}"
        );
    }
}

#[test]
fn z_rises_before_anything_else_and_after_everything() {
    for name in ["grbl", "linuxcnc"] {
        let text = write(&path(), &job(), &Post::load(name).unwrap())
            .unwrap()
            .text;
        let lines: Vec<&str> = text.lines().map(words).collect();
        let find = |what: &str| lines.iter().position(|l| l.starts_with(what)).unwrap();
        let first_motion = lines
            .iter()
            .position(|l| l.contains(['X', 'Y', 'Z']))
            .unwrap();
        assert_eq!(lines[first_motion], "G0 Z5");
        assert!(first_motion < find("M3 S18000") && find("M3 S18000") < find("G4 P3"));
        assert!(find("G4 P3") < find("G0 X1 Y2"));
        let last_motion = lines
            .iter()
            .rposition(|l| l.contains(['X', 'Y', 'Z']))
            .unwrap();
        assert_eq!(lines[last_motion], "Z5", "the last retract stopped at 1");
        assert!(last_motion < find("M5"));
    }
    // A first target above the safe height: up to it at once, no way down in between.
    let mut p = path();
    p.moves[0].to.z = 9.0;
    let text = write(&p, &job(), &Post::load("grbl").unwrap())
        .unwrap()
        .text;
    assert!(text.contains("G0 Z9\n") && !text.contains("G0 Z5\nM3"));
    // And below it: over the place first, then down.
    p.moves[0].to.z = 2.0;
    let text = write(&p, &job(), &Post::load("grbl").unwrap())
        .unwrap()
        .text;
    assert!(
        text.contains("G0 Z5\nM3 S18000\nG4 P3\n(peak 1)\nG0 X1 Y2\nZ2\n"),
        "{text}"
    );
}

#[test]
fn grbl_gets_nothing_it_chokes_on() {
    let text = write(&path(), &job(), &Post::load("grbl").unwrap())
        .unwrap()
        .text;
    assert!(text.is_ascii() && !text.contains(['?', '~', '!', '%', '\r']));
    assert!(!text.contains("M6") && !text.contains("G43") && !text.contains("G64"));
    assert!(text.lines().all(|l| l.len() <= 70));
    assert!(text.ends_with("M30\n"));
}

#[test]
fn linuxcnc_bounds_its_blending_and_sets_its_tool() {
    let post = Post::load("linuxcnc").unwrap();
    let mut j = job();
    j.tool_number = 7;
    let text = write(&path(), &j, &post).unwrap().text;
    for line in ["G64 P0.002\n", "T7 M6\nG43 H7\n", "\nM2\n"] {
        assert!(text.contains(line), "{text}");
    }
    j.path_tolerance = Some(Mm(0.01));
    assert!(
        write(&path(), &j, &post)
            .unwrap()
            .text
            .contains("G64 P0.01\n")
    );
}

#[test]
fn options_of_the_job_and_the_dialect() {
    let mut post = Post::load("grbl").unwrap();
    let mut j = job();
    j.spin_up = Seconds(0.0);
    j.coolant = Coolant::Flood;
    let text = write(&path(), &j, &post).unwrap().text;
    assert!(text.contains("M3 S18000\nM8\n") && !text.contains("G4 "));
    j.speed = Rpm(0.0);
    let text = write(&path(), &j, &post).unwrap().text;
    assert!(!text.contains("M3 ") && text.contains("M5"));
    post.number_step = 10;
    post.line_end = "\r\n";
    let text = write(&path(), &j, &post).unwrap().text;
    assert!(
        text.contains("\r\nN10 G21 G17 G90 G94 G54\r\nN20 G0 Z5\r\n"),
        "{text}"
    );
    post.number_step = 0;
    post.modal = super::super::definition::Modal {
        motion: false,
        axes: false,
        feed: false,
    };
    let text = write(&path(), &j, &post).unwrap().text;
    assert!(text.contains("\r\nG1 X10 Y3 Z-1.25 F1500\r\n"), "{text}");
}

#[test]
fn inches_are_converted_everywhere() {
    let mut post = Post::load("grbl").unwrap();
    post.units = Units::Inch;
    let text = write(&path(), &job(), &post).unwrap().text;
    assert!(text.contains("G20 G17 G90") && !text.contains("G21"));
    // 5 mm, 10 mm, 1500 mm/min and 500 mm/min by hand.
    for word in ["Z0.19685", "X0.3937", "F59.06", "F19.69"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn what_cannot_be_written_is_refused_by_name() {
    let post = Post::load("grbl").unwrap();
    let refusal = |p: &Toolpath, j: &Job| write(p, j, &post).unwrap_err().to_string();
    assert_eq!(
        refusal(&Toolpath::default(), &job()),
        "post grbl: the toolpath has no moves: there is nothing to cut"
    );
    let mut p = path();
    p.moves[7].to.y = f64::NAN;
    assert_eq!(
        refusal(&p, &job()),
        "post grbl: move 7: Y is NaN: the path is broken there, so no program was written"
    );
    p.moves[7].to.y = 1e6;
    assert_eq!(
        refusal(&p, &job()),
        "post grbl: move 7: Y = 1000000 mm has more than 8 digits as this dialect writes it: controllers read no more"
    );
    let mut p = path();
    p.moves[0].kind = MoveKind::Cut;
    assert!(
        refusal(&p, &job())
            .starts_with("post grbl: move 0: is a Cut: a program must begin with a Rapid")
    );
    let mut p = path();
    p.safe_z = f64::INFINITY;
    assert!(refusal(&p, &job()).starts_with("post grbl: the safe height is inf mm"));
    for bad in [0.0, -1.0, f64::NAN, 0.01, 1e12] {
        let e = refusal(
            &path(),
            &Job {
                feed: MmPerMin(bad),
                ..job()
            },
        );
        assert!(
            e.starts_with("post grbl: the feed in mm/min is") && e.contains("must be above zero"),
            "{e}"
        );
        let e = refusal(
            &path(),
            &Job {
                plunge: MmPerMin(bad),
                ..job()
            },
        );
        assert!(e.starts_with("post grbl: the plunge feed"), "{e}");
    }
    for bad in [-1.0, f64::NAN, 0.3] {
        let e = refusal(
            &path(),
            &Job {
                speed: Rpm(bad),
                ..job()
            },
        );
        assert!(e.contains("must be zero or above"), "{e}");
    }
    let mist = Job {
        coolant: Coolant::Mist,
        ..job()
    };
    assert_eq!(
        refusal(&path(), &mist),
        "post grbl: this controller has no words for mist: choose another coolant, or none; where yours has them, write them into [coolant]"
    );
    let mut tight = post.clone();
    tight.longest = 15;
    let e = write(
        &path(),
        &Job {
            header: vec![],
            ..job()
        },
        &tight,
    )
    .unwrap_err();
    assert!(
        matches!(
            e.refusal,
            Refusal::LineTooLong {
                line: 1,
                length: 19,
                ..
            }
        ),
        "{e}"
    );
}

#[test]
fn sections_out_of_order_or_beyond_the_end_do_no_harm() {
    let mut p = path();
    p.sections.push(Section {
        name: "late".into(),
        first_move: 3,
    });
    p.sections.push(Section {
        name: "never".into(),
        first_move: 999,
    });
    let text = write(&p, &job(), &Post::load("grbl").unwrap())
        .unwrap()
        .text;
    assert!(text.contains("(late)") && !text.contains("never"));
}

#[test]
fn a_million_moves() {
    let mut p = Toolpath {
        moves: vec![go(MoveKind::Rapid, 0.0, 0.0, 5.0)],
        sections: vec![],
        safe_z: 5.0,
    };
    for i in 0..1_000_000 {
        let t = f64::from(i) * 1e-3;
        p.moves.push(go(
            MoveKind::Cut,
            30.0 * t.cos(),
            30.0 * t.sin(),
            -t.fract(),
        ));
    }
    let posted = write(&p, &job(), &Post::load("grbl").unwrap()).unwrap();
    assert_eq!(posted.line_of_move.len(), 1_000_001);
    let last = posted.line_of_move.last().copied().unwrap_or_default();
    assert!(
        posted.text.lines().count() > last && last > 999_000,
        "{last}"
    );
}

/// From (10, 0) a quarter round the origin to (0, 10) and half a millimetre up, then on to (-10, 0), and back the long way.
fn arcs() -> Toolpath {
    let turn = |x: f64, y: f64, z: f64, clockwise| Move {
        kind: MoveKind::Cut,
        to: Point::new(x, y, z),
        turn: Some(Turn {
            center: Point2::origin(),
            clockwise,
        }),
        feed: None,
    };
    Toolpath {
        moves: vec![
            go(MoveKind::Rapid, 10.0, 0.0, 5.0),
            go(MoveKind::Plunge, 10.0, 0.0, -1.0),
            turn(0.0, 10.0, -0.5, false),
            turn(-10.0, 0.0, -0.5, false),
            turn(0.0, 10.0, -0.5, false),
            turn(10.0, 0.0, -0.5, true),
            go(MoveKind::Cut, 12.0, 0.0, -0.5),
            go(MoveKind::Retract, 12.0, 0.0, 5.0),
        ],
        sections: vec![],
        safe_z: 5.0,
    }
}

#[test]
fn arcs_by_hand() {
    let text = write(&arcs(), &job(), &Post::load("grbl").unwrap())
        .unwrap()
        .text;
    // Centre from the start; X and Y always; the motion word only when it changes.
    let want = "G1 Z-1 F500\nG3 X0 Y10 Z-0.5 I-10 F1500\nX-10 Y0 J-10\nX0 Y10 I10\nG2 X10 Y0 J-10\nG1 X12\n";
    assert!(text.contains(want), "{text}");
    let mut post = Post::load("grbl").unwrap();
    post.units = Units::Inch;
    let text = write(&arcs(), &job(), &post).unwrap().text;
    assert!(
        text.contains("G3 X0 Y0.3937 Z-0.01969 I-0.3937 F59.06\n"),
        "{text}"
    );
}

#[test]
fn arcs_that_cannot_be_written_are_refused_or_straight() {
    let mut post = Post::load("grbl").unwrap();
    let refusal = |p: &Toolpath, post: &Post| write(p, &job(), post).unwrap_err().to_string();
    let all = std::mem::replace(&mut post.arcs, crate::post::definition::Arcs::NONE);
    assert_eq!(
        refusal(&arcs(), &post),
        "post grbl: move 2: it is a helix of 90.0 degrees with radius 10.0000 mm in plane XY, and this controller takes none: let it be written as lines within a tolerance (--arcs-to-lines 0.005)"
    );
    post.arcs = all;
    let mut p = arcs();
    p.moves[7].turn = p.moves[2].turn;
    assert_eq!(
        refusal(&p, &post),
        "post grbl: move 7: is a Retract along an arc: only a Cut or a Link may turn"
    );
    let mut p = arcs();
    p.moves[2].to.x = 0.1;
    p.moves[2].to.y = 10.2;
    assert_eq!(
        refusal(&p, &post),
        "post grbl: move 2: the arc about X0 Y0 cannot be written with 3 decimals: the radii at its start and end differ"
    );
    // A whole turn that is none when written: from (10, 0) clockwise to a hair above it.
    let mut p = arcs();
    p.moves[2].to = Point::new(10.0, 0.0002, -1.0);
    p.moves[2].turn = Some(Turn {
        center: Point2::origin(),
        clockwise: true,
    });
    assert!(write(&p, &job(), &post).is_ok(), "a whole turn stays one");
    // A sliver of an arc is a straight line: no axis word at all here.
    p.moves[2].turn = Some(Turn {
        center: Point2::origin(),
        clockwise: false,
    });
    p.moves.truncate(3);
    p.moves.push(go(MoveKind::Retract, 10.0, 0.0, 5.0));
    let posted = write(&p, &job(), &post).unwrap();
    assert!(!posted.text.contains("G3"), "{}", posted.text);
    assert_eq!(posted.line_of_move[2], posted.line_of_move[1]);
    let mut p = arcs();
    p.moves[2].turn = Some(Turn {
        center: Point2::new(f64::NAN, 0.0),
        clockwise: true,
    });
    assert!(refusal(&p, &post).starts_with("post grbl: move 2: X is NaN"));
    p.moves[2].turn = Some(Turn {
        center: Point2::new(10.0, 0.0),
        clockwise: true,
    });
    assert!(refusal(&p, &post).ends_with("its radius becomes zero"));
}
