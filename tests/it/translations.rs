//! Programs from dialect to dialect and CL files to programs, through the binary.
#![allow(clippy::unwrap_used)]

use super::story::{morsemill, text};
use morsemill::gcode::{Dialect, Event, Interpreter, Motion, Reading};
use morsemill::post::{BUILT_IN, Post, READERS};
use morsemill::translate::unknown_state;
use std::io::Cursor;
use std::path::Path;

/// As a person writes it: inches, arcs, increments, a feed in inverse time, a second work offset would go too far for most.
const BY_HAND: &str = "(bracket, op 10)
G20 G90 G17
G0 Z0.5
X1 Y1
M3 S5000
G4 P2
G1 Z-0.1 F10
G2 X2 Y0 I0 J-1 (corner)
G3 X0 Y0 I-1 J0
G91
G1 X0.1 Y-0.2
G93 G1 X1 F2
G94 G90
G1 X0 F12.5
G0 Z0.5
M5
M30
";

/// Where every motion of a program ends, with its feed; rapids have none.
fn ends(program: &[u8], dialect: Dialect) -> Vec<([f64; 3], Option<f64>)> {
    let from = Cursor::new(program);
    let read = Interpreter::from_state(from, unknown_state(dialect), Reading::default()).unwrap();
    let motion = |e: Event| match e {
        Event::Motion(m) if !m.machine_coordinates => Some(m),
        _ => None,
    };
    let end = |m: Motion| {
        let feed =
            matches!(m.kind, morsemill::gcode::MotionKind::Feed).then(|| match m.inverse_time {
                true => m.feed.0 * (m.to - m.from).norm(),
                false => m.feed.0,
            });
        ([m.to.x, m.to.y, m.to.z], feed)
    };
    read.map(|e| e.unwrap())
        .filter_map(motion)
        .map(end)
        .collect()
}

fn alike(a: &[([f64; 3], Option<f64>)], b: &[([f64; 3], Option<f64>)], within: f64) -> bool {
    // An axis that is not known yet is no number.
    let near = |x: f64, y: f64, e: f64| (x - y).abs() <= e || (x.is_nan() && y.is_nan());
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| {
            (0..3).all(|k| near(a.0[k], b.0[k], within))
                && a.1.is_some() == b.1.is_some()
                && near(a.1.unwrap_or(0.0), b.1.unwrap_or(0.0), 0.51)
        })
}

/// Into every dialect and back again: the same motions, to the last decimals of both.
#[test]
fn there_and_back_through_every_dialect() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    std::fs::write(dir.join("in.nc"), BY_HAND).unwrap();
    let meant = ends(BY_HAND.as_bytes(), Dialect::Grbl);
    assert_eq!(meant.len(), 9);
    for (name, _) in BUILT_IN {
        let there = [
            "translate",
            "in.nc",
            "--from",
            "grbl",
            "--to",
            name,
            "-o",
            "there",
        ];
        let o = morsemill(dir, &there);
        assert!(o.status.success(), "{name}: {}", text(&o.stderr));
        assert!(
            text(&o.stdout).contains("order as meant"),
            "{}",
            text(&o.stdout)
        );
        let post = Post::load(name).unwrap();
        let written = std::fs::read(dir.join("there")).unwrap();
        let found = ends(&written, Dialect::from_name(&post.reader).unwrap());
        // What a dialect has no words for yet is told axis by axis.
        assert!(
            alike(&meant, &found, 0.0011),
            "{name}: {meant:?}\n{found:?}"
        );
        let back = [
            "translate",
            "there",
            "--from",
            name,
            "--to",
            "grbl",
            "-o",
            "back.nc",
        ];
        let o = morsemill(dir, &back);
        // GRBL has machine coordinates, so the others' retracts come back too.
        assert!(o.status.success(), "{name}: {}", text(&o.stderr));
        let found = ends(&std::fs::read(dir.join("back.nc")).unwrap(), Dialect::Grbl);
        assert!(
            alike(&meant, &found, 0.0021),
            "{name}: {meant:?}\n{found:?}"
        );
    }
}

#[test]
fn every_post_names_a_reader_and_every_reader_has_a_name() {
    let names: Vec<&str> = Dialect::ALL.iter().map(|d| d.name()).collect();
    let mut known = READERS.to_vec();
    let mut all = names.clone();
    known.sort_unstable();
    all.sort_unstable();
    assert_eq!(known, all);
}

/// Ends with `code`, says `words`, and leaves no file but `in`.
fn refused(dir: &Path, args: &[&str], code: i32, words: &str) {
    let o = morsemill(dir, args);
    let said = text(&o.stderr);
    assert_eq!(o.status.code(), Some(code), "{args:?}: {said}");
    assert!(
        said.contains(words),
        "{args:?}: {words:?} is not in {said:?}"
    );
    let left: Vec<_> = std::fs::read_dir(dir)
        .unwrap()
        .map(|f| f.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|n| n != "in.nc" && n != "in.cl")
        .collect();
    assert!(left.is_empty(), "{args:?} left {left:?}");
}

#[test]
fn what_cannot_be_said_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let to = |to: &'static str| {
        [
            "translate",
            "in.nc",
            "--from",
            "grbl",
            "--to",
            to,
            "-o",
            "out.nc",
        ]
    };
    for (program, post, words) in [
        (
            "G0 X0 Y0 Z5\nG91 G1 Z-1\n",
            "fanuc",
            "in.nc:2:5 this move has no feed rate",
        ),
        (
            "G91 G0 Z5\nM2\n",
            "fanuc",
            "in.nc:1:1 this move hangs on where the tool stands",
        ),
        (
            "G0 X0 Y0 Z5\nM8\nM2\n",
            "marlin",
            "in.nc:2: post marlin: step 2: this controller has no words for flood",
        ),
        (
            "G0 X0 Y0 Z5\nG92 X5\nM2\n",
            "haas",
            "in.nc:2:1 this line sets a shift",
        ),
        (
            "G0 X0 Y0 Z5\nG18 G2 X5 Z5 R9 F100\nM2\n",
            "heidenhain",
            "let it be written as lines",
        ),
    ] {
        std::fs::write(dir.join("in.nc"), program).unwrap();
        refused(dir, &to(post), 1, words);
    }
    refused(dir, &to("nosuch"), 2, "post \"nosuch\" is not known");
    let missing = [
        "translate",
        "none.nc",
        "--from",
        "grbl",
        "--to",
        "haas",
        "-o",
        "out.nc",
    ];
    refused(dir, &missing, 2, "none.nc: No such file");
    std::fs::write(dir.join("in.cl"), "PARTNO/A\nUNITS/MM\nGOTOO/1,2,3\nFINI\n").unwrap();
    let post = ["post", "in.cl", "--post", "grbl", "-o", "out.nc"];
    refused(dir, &post, 1, "in.cl:3:1");
    refused(dir, &post, 1, "GOTO");
}

#[test]
fn arcs_become_lines_when_told() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    std::fs::write(dir.join("in.nc"), "G0 X0 Y0 Z5\nG18 G2 X5 Z5 R9 F100\nM2\n").unwrap();
    let o = morsemill(
        dir,
        &[
            "translate",
            "in.nc",
            "--from",
            "grbl",
            "--to",
            "heidenhain",
            "-o",
            "out.h",
            "--arcs-to-lines",
            "0.001",
        ],
    );
    assert!(o.status.success(), "{}", text(&o.stderr));
    assert!(
        text(&o.stdout).contains("rewritten  arcs as lines, at most 0."),
        "{}",
        text(&o.stdout)
    );
}

#[test]
fn a_cl_file_becomes_a_program_and_the_notes_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let cl = "PARTNO/A\nLOADTL/1\nSPINDL/RPM,8000,CLW\nRAPID\nGOTO/0,0,10\nFEDRAT/MMPM,500\nGOTO/0,0,-1\nGOTO/10,0,-1\nRAPID\nGOTO/10,0,10\nFINI\n";
    std::fs::write(dir.join("in.cl"), cl).unwrap();
    let o = morsemill(
        dir,
        &[
            "post", "in.cl", "--post", "fanuc", "-o", "out.nc", "--json", "out.json",
        ],
    );
    assert!(o.status.success(), "{}", text(&o.stderr));
    let said = text(&o.stdout);
    assert!(
        said.contains(
            "note       line 5: no UNITS before this line: lengths are taken as millimetres"
        ),
        "{said}"
    );
    assert!(said.contains("read back"), "{said}");
    let program = std::fs::read_to_string(dir.join("out.nc")).unwrap();
    assert!(program.contains("X10."), "{program}");
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(dir.join("out.json")).unwrap()).unwrap();
    assert_eq!(json["post"], "fanuc");
    assert!(json["verified"]["moves"].as_u64().unwrap() >= 4);
    // In inches the same numbers lie 25.4 times as far.
    let o = morsemill(
        dir,
        &[
            "post",
            "in.cl",
            "--post",
            "grbl",
            "-o",
            "inch.nc",
            "--cl-units",
            "inch",
        ],
    );
    assert!(o.status.success(), "{}", text(&o.stderr));
    assert!(
        std::fs::read_to_string(dir.join("inch.nc"))
            .unwrap()
            .contains("X254")
    );
}

/// M7 and M8 together, from one control to others that have words for it, and to one that has not.
#[test]
fn flood_and_mist_go_together_or_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let program = "G21 G90 G17\nT1 M6\nG0 Z5\nX0 Y0\nM3 S5000\nM7\nM8\nG1 Z-1 F100\nM9\nM8\nX5\nM7\nX0\nM9\nG0 Z5\nM5\nM2\n";
    std::fs::write(dir.join("in.ngc"), program).unwrap();
    let to = |post: &str| {
        morsemill(
            dir,
            &[
                "translate",
                "in.ngc",
                "--from",
                "linuxcnc",
                "--to",
                post,
                "-o",
                "out.nc",
            ],
        )
    };
    for post in ["linuxcnc", "mach3", "masso", "edingcnc"] {
        let o = to(post);
        assert!(o.status.success(), "{post}: {}", text(&o.stderr));
        let written = std::fs::read_to_string(dir.join("out.nc")).unwrap();
        assert_eq!(written.matches("M7").count(), 3, "{post}: {written}");
    }
    let o = to("centroid");
    assert!(!o.status.success());
    let said = text(&o.stderr);
    assert!(
        said.contains("no words for flood and mist together: choose another coolant, or none"),
        "{said}"
    );
}
