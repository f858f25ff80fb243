//! The witness believes good programs and catches each kind of lie.
#![allow(clippy::unwrap_used)]

use super::{Deviation, VerifyError, verify};
use crate::cldata::{Coolant, Job};
use crate::gcode::{Event, interpret};
use crate::geom::Point;
use crate::geom::Point2;
use crate::post::{Post, Posted, Units, write};
use crate::toolpath::curve::Curve;
use crate::toolpath::{Move, MoveKind, Section, Toolpath, Turn};
use crate::units::{MmPerMin, Rpm, Seconds};
use proptest::prelude::*;

fn go(kind: MoveKind, x: f64, y: f64, z: f64) -> Move {
    Move::straight(kind, Point::new(x, y, z))
}

fn job() -> Job {
    Job {
        header: vec!["part (x)? 100 % \u{e4}".into(), "MSG, not a message".into()],
        feed: MmPerMin(1500.0),
        plunge: MmPerMin(500.0),
        speed: Rpm(18_000.0),
        tool_number: 3,
        spin_up: Seconds(2.5),
        coolant: Coolant::Flood,
        path_tolerance: None,
    }
}

fn path() -> Toolpath {
    use MoveKind::*;
    Toolpath {
        moves: vec![
            go(Rapid, 1.0, 2.0, 5.0),
            go(Plunge, 1.0, 2.0, -1.0),
            go(Cut, 10.0, 2.0, -1.2504),
            go(Cut, 10.0001, 2.0, -1.2504),
            go(Link, 10.0, 3.5, -1.3),
            go(Retract, 10.0, 3.5, 2.0),
        ],
        sections: vec![Section {
            name: "peak 1".into(),
            first_move: 0,
        }],
        safe_z: 5.0,
    }
}

fn posts() -> Vec<Post> {
    let mut all = Vec::new();
    // Of one kind each; every post has its turn in the integration tests.
    for name in ["grbl", "linuxcnc"] {
        for units in [Units::Mm, Units::Inch] {
            let mut p = Post::load(name).unwrap();
            p.units = units;
            all.push(p);
        }
    }
    all
}

#[test]
fn believes_a_good_program_and_measures_it() {
    let post = Post::load("grbl").unwrap();
    let posted = write(&path(), &job(), &post).unwrap();
    let d = verify(&posted, &path(), &job(), &post).unwrap();
    assert_eq!(
        (d.moves, d.without_line, d.position_line),
        (8, 1, posted.line_of_move[2])
    );
    // 0.4 um in Z by hand; the move without a line adds 0.1 um in X to it, one line and one position later.
    assert!((d.position.0 - 0.000_412_3).abs() < 1e-6, "{d:?}");
    assert_eq!(d.feed, MmPerMin(0.0));
}

/// The program with one piece of text replaced.
fn forged(from: &str, to: &str, name: &str) -> Result<Deviation, VerifyError> {
    let post = Post::load(name).unwrap();
    let mut posted = write(&path(), &job(), &post).unwrap();
    assert!(posted.text.contains(from), "{from}: {}", posted.text);
    posted.text = posted.text.replacen(from, to, 1);
    verify(&posted, &path(), &job(), &post)
}

#[test]
fn catches_every_lie() {
    let mut wrong = vec![];
    for (from, to, what) in [
        (
            "X10 Z-1.25 ",
            "X10.001 Z-1.25 ",
            "line 11 (\"X10.001 Z-1.25 F1500\"): a Feed to X10.001 Y2 Z-1.25 at 1500 mm/min where a Feed to X10 Y2 Z-1.2504 at 1500 mm/min was meant",
        ),
        (
            "F1500",
            "F1501",
            "at 1501 mm/min where a Feed to X10 Y2 Z-1.2504 at 1500",
        ),
        ("F500", "F1500", "where a Feed to X1 Y2 Z-1 at 500"),
        ("G1 Z-1", "G0 Z-1", "a Rapid to X1 Y2 Z-1"),
        (
            "X10 Z-1.25 F1500\n",
            "G2 X10 Z-1.25 I4.5 J0 F1500\nG1\n",
            "by an arc",
        ),
        ("Y3.5 Z-1.3\n", "\n", "where a Feed to X10 Y3.5 Z-1.3"),
        ("Y3.5 Z-1.3\n", "Y3.5 Z-1.3\nX99\n", "a Feed to X99"),
        (
            "S18000",
            "S1800",
            "the spindle turns clockwise at 1800 rpm, and clockwise at 18000 were meant",
        ),
        (
            "M3 S18000",
            "S18000",
            "a dwell of 2.5 s, where the spindle was to turn clockwise at 18000 rpm",
        ),
        ("M3", "M4", "the spindle turns counter-clockwise"),
        (
            "G4 P2.5\n",
            "\n",
            "is given no time to reach its speed, and 2.5 s were meant",
        ),
        ("M8\n", "\n", "flood and mist stay as they are"),
        ("G0 Z5\n", "\n", "no motion, where a Rapid to Z5 was meant"),
        ("G0 Z5\n", "G0 Z4\n", "where a Rapid to Z5 was meant"),
        ("G0 Z5\n", "G0 X0 Y0 Z5\n", "where a Rapid to Z5 was meant"),
        ("Z5\nM5", "M5", "no motion, where a Rapid to Z5 was meant"),
        (
            "M30\n",
            "\n",
            "the program is over, where its end (M2 or M30) was meant",
        ),
        (
            "M30\n",
            "M30\nX0\n",
            "something follows the end of the program",
        ),
        (
            "M5\n",
            "G0 X0\nM5\n",
            "something is left over behind the last move",
        ),
        (" G90", "", "where a Rapid to Z5 was meant"),
        ("G21 ", "", "where a Rapid to Z5 was meant"),
        (
            " G94",
            "",
            "a Feed to X1 Y2 Z-1 in 1/500 min where a Feed to X1 Y2 Z-1 at 500 mm/min was meant",
        ),
        (
            "X1 Y2",
            "X1 Y2 $",
            "the program does not read back: line 9:10 found",
        ),
    ] {
        let e = forged(from, to, "grbl").expect_err(from).to_string();
        if !e.contains(what) {
            wrong.push(format!("{from} -> {to}: {e}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let e = forged("G64 P0.002", "G64 P0.02", "linuxcnc")
        .unwrap_err()
        .to_string();
    assert!(e.contains("G64 P0.002 was meant"), "{e}");
}

#[test]
fn catches_a_link_at_another_feed() {
    let post = Post::load("grbl").unwrap();
    let mut path = path();
    let link = path
        .moves
        .iter()
        .position(|m| m.kind == MoveKind::Link)
        .unwrap();
    path.moves[link].feed = Some(MmPerMin(600.0));
    let good = write(&path, &job(), &post).unwrap();
    assert!(verify(&good, &path, &job(), &post).is_ok());
    let wrong = Posted {
        text: good.text.replace("F600", "F900"),
        ..good
    };
    let error = verify(&wrong, &path, &job(), &post)
        .unwrap_err()
        .to_string();
    assert!(error.contains("at 600 mm/min was meant"), "{error}");
}

#[test]
fn the_record_of_lines_is_checked_too() {
    let post = Post::load("grbl").unwrap();
    let good = write(&path(), &job(), &post).unwrap();
    for i in 0..good.line_of_move.len() {
        let mut posted = good.clone();
        posted.line_of_move[i] += 1;
        assert!(verify(&posted, &path(), &job(), &post).is_err(), "{i}");
    }
    let short = Posted {
        line_of_move: vec![],
        ..good
    };
    assert!(verify(&short, &path(), &job(), &post).is_err());
}

#[test]
fn a_long_program_is_believed() {
    let mut p = path();
    for i in 0..300_000 {
        let t = f64::from(i) * 1e-3;
        p.moves.push(go(
            MoveKind::Cut,
            30.0 * t.cos(),
            30.0 * t.sin(),
            -t.fract(),
        ));
    }
    let post = Post::load("grbl").unwrap();
    let posted = write(&p, &job(), &post).unwrap();
    let d = verify(&posted, &p, &job(), &post).unwrap();
    // What rounds to where the tool is has no line.
    assert!(d.moves > 300_000 && d.without_line < 100, "{d:?}");
}

#[test]
fn every_line_reads_back_by_itself() {
    use crate::gcode::{State, interpret_line};
    for post in posts() {
        let text = write(&path(), &job(), &post).unwrap().text;
        let mut state = State::new(super::dialect_of(&post).unwrap());
        for (i, line) in text.lines().enumerate() {
            interpret_line(&mut state, line, i + 1, &mut Vec::new()).unwrap();
        }
    }
}

/// Any path a planner might make, and some it should not: tiny steps, repeats, ties, far places.
fn any_path() -> impl Strategy<Value = Toolpath> {
    let coordinate = prop_oneof![
        4 => -200.0..200.0_f64,
        2 => (-40_i32..40).prop_map(|i| f64::from(i) / 16.0),
        2 => (-5_i32..5).prop_map(|i| f64::from(i) * 0.0005),
        1 => Just(0.0),
        1 => -9_000.0..9_000.0_f64,
    ];
    let kind = prop_oneof![
        Just(MoveKind::Rapid),
        Just(MoveKind::Plunge),
        Just(MoveKind::Cut),
        Just(MoveKind::Link),
        Just(MoveKind::Retract),
    ];
    let point = (coordinate.clone(), coordinate.clone(), coordinate.clone());
    // A small step from the last place as often as a new place.
    let step = (kind, point, any::<bool>(), -2e-3..2e-3_f64, 0..3_usize);
    (
        proptest::collection::vec(step, 0..60),
        coordinate,
        proptest::collection::vec((0..60_usize, any::<String>()), 0..4),
    )
        .prop_map(|(steps, safe_z, mut names)| {
            let mut moves: Vec<Move> = Vec::new();
            for (kind, (x, y, z), small, by, axis) in steps {
                let kind = if moves.is_empty() {
                    MoveKind::Rapid
                } else {
                    kind
                };
                let mut to = Point::new(x, y, z);
                if let (true, Some(last)) = (small, moves.last()) {
                    to = last.to;
                    to[axis] += by;
                }
                let feed = (axis == 1 && matches!(kind, MoveKind::Cut | MoveKind::Link))
                    .then_some(MmPerMin(3.0 + x.abs()));
                moves.push(Move {
                    feed,
                    ..Move::straight(kind, to)
                });
            }
            if moves.is_empty() {
                moves.push(go(MoveKind::Rapid, 0.0, 0.0, safe_z));
            }
            names.sort();
            let sections = names
                .into_iter()
                .map(|(first_move, name)| Section { name, first_move })
                .collect();
            Toolpath {
                moves,
                sections,
                safe_z,
            }
        })
}

fn any_job() -> impl Strategy<Value = Job> {
    let speed = prop_oneof![Just(0.0), 1.0..30_000.0_f64];
    let coolant = prop_oneof![Just(Coolant::Off), Just(Coolant::Flood)];
    let header = proptest::collection::vec(any::<String>(), 0..4);
    (
        header,
        3.0..9_000.0_f64,
        3.0..2_000.0_f64,
        speed,
        0..255_u32,
        0.0..9.0_f64,
        coolant,
    )
        .prop_map(
            |(header, feed, plunge, speed, tool_number, spin_up, coolant)| Job {
                header,
                feed: MmPerMin(feed),
                plunge: MmPerMin(plunge),
                speed: Rpm(speed),
                tool_number,
                // Nothing, or enough to be written.
                spin_up: Seconds(if spin_up < 1.0 { 0.0 } else { spin_up }),
                coolant,
                path_tolerance: None,
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn what_is_written_reads_back_as_meant(path in any_path(), job in any_job(), numbers in 0..2_u32, modal in any::<[bool; 3]>()) {
        for mut post in posts() {
            post.number_step = numbers * 10;
            (post.modal.motion, post.modal.axes, post.modal.feed) = (modal[0], modal[1], modal[2]);
            let posted = write(&path, &job, &post).unwrap();
            let d = verify(&posted, &path, &job, &post).map_err(|e| TestCaseError::fail(format!("{e}\n{}", posted.text)))?;
            prop_assert!(d.position.0 <= post.rounding().0 * 3.0_f64.sqrt() * (1.0 + 1e-6));
            prop_assert!(posted.text.lines().all(|l| l.len() <= post.longest));
            prop_assert_eq!(posted.clone(), write(&path, &job, &post).unwrap());
        }
    }
}

/// A chain of arcs and lines at a constant height or along helices: centres anywhere, radii of 3 to 60 mm.
fn any_arcs() -> impl Strategy<Value = Toolpath> {
    proptest::collection::vec(
        (
            3.0..60.0_f64,
            0.0..6.2_f64,
            0.02..6.2_f64,
            any::<bool>(),
            -1.0..1.0_f64,
            any::<bool>(),
        ),
        1..30,
    )
    .prop_map(|steps| {
        let mut at = Point::new(1.0, 2.0, 5.0);
        let mut moves = vec![
            go(MoveKind::Rapid, 1.0, 2.0, 5.0),
            go(MoveKind::Plunge, 1.0, 2.0, -1.0),
        ];
        at.z = -1.0;
        for (r, spoke, sweep, clockwise, rise, straight) in steps {
            let center = Point2::new(at.x - r * spoke.cos(), at.y - r * spoke.sin());
            let end = if clockwise {
                spoke - sweep
            } else {
                spoke + sweep
            };
            let to = Point::new(
                center.x + r * end.cos(),
                center.y + r * end.sin(),
                at.z + rise,
            );
            let turn = (!straight).then_some(Turn { center, clockwise });
            moves.push(Move {
                kind: MoveKind::Cut,
                to,
                turn,
                feed: None,
            });
            at = to;
        }
        Toolpath {
            moves,
            sections: vec![],
            safe_z: 5.0,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Through the text and back: every arc is the one meant, all along, to within its last decimal.
    #[test]
    fn arcs_read_back_as_meant(path in any_arcs(), modal in any::<[bool; 3]>()) {
        for mut post in posts() {
            (post.modal.motion, post.modal.axes, post.modal.feed) = (modal[0], modal[1], modal[2]);
            let posted = write(&path, &job(), &post).unwrap();
            verify(&posted, &path, &job(), &post).map_err(|e| TestCaseError::fail(format!("{e}\n{}", posted.text)))?;
            let program = interpret(&posted.text, super::dialect_of(&post).unwrap()).unwrap();
            let motion = |line: usize| program.events.iter().rev().find_map(|e| match e {
                Event::Motion(m) if m.line == line => Some(*m),
                _ => None,
            });
            let unit = 2.0 * post.rounding().0;
            for (i, m) in path.moves.iter().enumerate().skip(2) {
                let Some(turn) = m.turn else { continue };
                let read = motion(posted.line_of_move[i]).unwrap();
                let arc = read.arc.unwrap();
                let meant = Curve::arc(path.moves[i - 1].to, m.to, &turn, 0.0);
                let told = Turn { center: Point2::new(arc.center.x, arc.center.y), clockwise: arc.clockwise };
                let written = Curve::arc(read.from, read.to, &told, 0.0);
                for k in 0..=20 {
                    let s = f64::from(k) / 20.0;
                    let off = meant.at(s * meant.length()) - written.at(s * written.length());
                    // Half a unit from each of start, centre and end, in plan and in height.
                    prop_assert!(off.norm() < 3.0 * unit, "move {}: {} mm at {}", i, off.norm(), s);
                }
            }
        }
    }
}

#[test]
fn catches_every_lie_about_an_arc() {
    let post = Post::load("grbl").unwrap();
    let turn = |clockwise| Turn {
        center: Point2::new(10.0, 7.0),
        clockwise,
    };
    let mut path = path();
    path.moves[4] = Move {
        kind: MoveKind::Cut,
        to: Point::new(15.0, 7.0, -1.3),
        turn: Some(turn(false)),
        feed: None,
    };
    path.moves[3] = go(MoveKind::Cut, 10.0, 2.0, -1.2504);
    path.moves[5] = go(MoveKind::Retract, 15.0, 7.0, 2.0);
    let posted = write(&path, &job(), &post).unwrap();
    assert!(
        posted.text.contains("G3 X15 Y7 Z-1.3 J5\n"),
        "{}",
        posted.text
    );
    verify(&posted, &path, &job(), &post).unwrap();
    for (to, what) in [
        ("G2 X15 Y7 Z-1.3 J5\n", "by an arc, clockwise about X10 Y7"),
        (
            "G1 X15 Y7 Z-1.3\n",
            "a Feed to X15 Y7 Z-1.3 counter-clockwise about X10 Y7",
        ),
        ("G3 X15 Y7 Z-1.3 I5 J0\n", "about X15 Y2"),
        ("G3 X15 Y7.002 Z-1.3 J5\n", "where a Feed to X15 Y7 Z-1.3"),
        ("G3 X15 Y7 Z-1.302 J5\n", "where a Feed to X15 Y7 Z-1.3"),
        (
            "G18 G3 X15 Z-1.3 I2.5 K0\nG17\n",
            "where a Feed to X15 Y7 Z-1.3",
        ),
    ] {
        let mut forged = posted.clone();
        forged.text = posted.text.replacen("G3 X15 Y7 Z-1.3 J5\n", to, 1);
        let e = match verify(&forged, &path, &job(), &post) {
            Err(e) => e.to_string(),
            Ok(d) => panic!("{to}: believed, {d:?}"),
        };
        assert!(
            e.contains(what) || e.contains("does not read back"),
            "{to}: {e}"
        );
    }
}
