//! Bad input through the binary: each ends with its code, says what and where, and leaves no file behind.
#![allow(clippy::unwrap_used)]

use super::common::PARTS;
use super::story::{morsemill, text};
use std::path::Path;

/// Runs `mill` in a folder that holds only `inputs`; it must end with `code`, say `words`, and leave nothing else.
fn refused(inputs: &[(&str, Vec<u8>)], part: &str, more: &[&str], code: i32, words: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    for (name, bytes) in inputs {
        std::fs::write(dir.join(name), bytes).unwrap();
    }
    let mut args = vec![
        "mill", part, "-o", "out.nc", "--json", "out.json", "--report", "report",
    ];
    args.extend(more);
    let o = morsemill(dir, &args);
    let said = text(&o.stderr);
    assert_eq!(
        o.status.code(),
        Some(code),
        "{part} {more:?}: {said}{}",
        text(&o.stdout)
    );
    for w in words {
        assert!(
            said.contains(w),
            "{part} {more:?}: {w:?} is not in {said:?}"
        );
    }
    assert!(!said.contains("panicked"), "{said}");
    let mut left: Vec<String> = std::fs::read_dir(dir)
        .unwrap()
        .map(|f| f.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    left.retain(|n| inputs.iter().all(|i| i.0 != n));
    assert!(left.is_empty(), "{part} {more:?} left {left:?}");
}

fn stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0u8; 12]);
        t.iter().flatten().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend([0u8; 2]);
    }
    out
}

fn plate(x: f32, y: f32, z: f32) -> Vec<u8> {
    stl(&[
        [[0.0, 0.0, 0.0], [x, 0.0, z], [x, y, z]],
        [[0.0, 0.0, 0.0], [x, y, z], [0.0, y, 0.0]],
    ])
}

#[test]
fn files_that_are_no_parts() {
    let file = |name: &str, bytes: Vec<u8>, words: &[&str]| {
        let words: Vec<&str> = words.iter().copied().chain([name]).collect();
        refused(&[(name, bytes)], name, &[], 2, &words);
    };
    file(
        "e.stl",
        Vec::new(),
        &["morsemill: e.stl: the file is empty: export the part again\n"],
    );
    file(
        "e.obj",
        Vec::new(),
        &["morsemill: e.obj: the file is empty: export the part again\n"],
    );
    let mut short = plate(40.0, 30.0, 0.0);
    short.truncate(150);
    file(
        "short.stl",
        short,
        &[
            "truncated STL: the header promises 2 triangles (184 bytes) but the file has 150 bytes, room for 1: copy or export it again",
        ],
    );
    let mut huge = plate(40.0, 30.0, 0.0);
    huge[80..84].copy_from_slice(&4_000_000_000u32.to_le_bytes());
    file(
        "huge.stl",
        huge,
        &[
            "the header promises 4000000000 triangles (200000000084 bytes) but the file has 184 bytes, room for 2",
        ],
    );
    let mut none = plate(40.0, 30.0, 0.0);
    none[80..84].copy_from_slice(&0u32.to_le_bytes());
    file(
        "zero.stl",
        none,
        &["the STL header promises 0 triangles but 100 bytes follow it"],
    );
    for (bad, word) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "infinite"),
        (f32::NEG_INFINITY, "infinite"),
    ] {
        let bytes = stl(&[
            [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 9.0, 0.0]],
            [[0.0, 0.0, 0.0], [9.0, bad, 0.0], [9.0, 9.0, 0.0]],
        ]);
        file(
            "odd.stl",
            bytes,
            &["triangle 2 (the first is 1) has a coordinate that is", word],
        );
    }
    file(
        "far.stl",
        plate(40.0, 3e9, 0.0),
        &["has a coordinate that is"],
    );
    let slivers = stl(&[[[0.0; 3], [9.0, 0.0, 0.0], [4.0, 0.0, 0.0]]]);
    file(
        "slivers.stl",
        slivers,
        &["none of the 1 triangles has any area"],
    );
    let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 zero\n";
    file(
        "word.stl",
        text.into(),
        &["word.stl:5:12: \"zero\" is not a number"],
    );
    let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
    file("ends.stl", text.into(), &["truncated STL: the text ends"]);
    // OBJ.
    let corners = "v 0 0 0\nv 9 0 0\nv 9 9 0\n";
    file(
        "i.obj",
        format!("{corners}f 1 2 4\n").into(),
        &["i.obj:4:1: the face uses vertex 4, but the file has 3 vertices (the first is 1)"],
    );
    file(
        "i.obj",
        format!("{corners}f 1 2 0\n").into(),
        &["i.obj:4:1: the face uses vertex 0"],
    );
    file(
        "i.obj",
        format!("{corners}f 1 2 -9\n").into(),
        &["i.obj:4:1: the face uses vertex -9"],
    );
    file(
        "i.obj",
        format!("{corners}f 1 2 99999999999999999999\n").into(),
        &["i.obj:4:1: "],
    );
    file(
        "i.obj",
        format!("{corners}f 1 2 x\n").into(),
        &["\"x\" is not a vertex index"],
    );
    file(
        "i.obj",
        format!("{corners}f 1 2\n").into(),
        &["a face with 2 corners: at least 3 are needed"],
    );
    file(
        "i.obj",
        "v 0 0 nan\nf 1 1 1\n".into(),
        &["i.obj:1:1: ", "is not a vertex"],
    );
    file("i.obj", corners.into(), &["3 vertices but no faces"]);
    // Something else.
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend([0u8; 300]);
    file(
        "picture.stl",
        png,
        &["this is a PNG", "not a part: name an STL or OBJ file"],
    );
    file(
        "noise.stl",
        (0..500u32).map(|k| (k * 7919 % 251) as u8).collect(),
        &["noise.stl"],
    );
    file(
        "text.txt",
        b"hello\n".to_vec(),
        &["neither the name nor the content is one of a part file"],
    );
}

#[test]
fn places_that_are_no_files() {
    refused(&[], "none.stl", &[], 2, &["none.stl: cannot be read: "]);
    refused(
        &[],
        ".",
        &[],
        2,
        &[".: this is a directory: name the STL or OBJ file inside it"],
    );
    refused(&[], "/dev/null", &[], 2, &["this is not a regular file"]);
}

#[test]
fn figures_that_make_no_sense() {
    let part = PARTS[0].path().display().to_string();
    let no = |more: &[&str], words: &[&str]| refused(&[], &part, more, 2, words);
    for flag in ["--scallop", "--feed", "--plunge", "--grid", "--persistence"] {
        for value in ["0", "-1", "NaN", "inf"] {
            no(&[flag, value], &[flag, "above zero"]);
        }
        no(&[flag, "abc"], &[flag, "abc"]);
    }
    no(
        &["--scallop", "2"],
        &["--scallop 2: a ball:6 leaves sensible cusps up to 0.75 mm only"],
    );
    no(
        &["--scallop", "0.00001"],
        &["no mill cuts finer than 0.0001 mm"],
    );
    no(
        &["--grid", "4"],
        &["--grid 4: must be below the ball's radius of 3 mm"],
    );
    no(&["--grid", "0.0001"], &["MiB allowed"]);
    no(&["--speed", "-5"], &["--speed -5"]);
    no(
        &["--angle", "NaN"],
        &["--angle NaN: must be a number of degrees"],
    );
    for tool in ["ball:0", "ball:-6", "ball:NaN", "ball:inf"] {
        no(
            &["--tool", tool],
            &[tool, "the diameter must be a finite number of mm"],
        );
    }
    no(
        &["--tool", "flat:6"],
        &["tool \"flat:6\" is not understood: write ball:DIAMETER in mm, e.g. ball:6"],
    );
    no(
        &["--tool", "ball:80"],
        &["the tool (ball:80, 80 mm across) is larger than the part (60."],
    );
    no(&["--stock", "lots"], &["stock \"lots\" is not understood"]);
    no(
        &["--units", "furlong"],
        &["unit \"furlong\" is not known: write mm or inch"],
    );
    no(&["--up", "sideways"], &["sideways"]);
    no(&["--origin", "nowhere"], &["nowhere"]);
    no(&["--strategy", "spiral"], &["spiral", "iso-scallop"]);
}

#[test]
fn names_that_are_not_known_name_their_nearest() {
    let part = PARTS[0].path().display().to_string();
    let no = |more: &[&str], words: &[&str]| refused(&[], &part, more, 2, words);
    no(
        &["--machine", "longmill-30x31"],
        &["machine \"longmill-30x31\" is not known (did you mean \"longmill-30x30\"?); there are "],
    );
    no(
        &["--post", "gbrl"],
        &["post \"gbrl\" is not known (did you mean \"grbl\"?)"],
    );
    no(
        &["--machine", "./none.toml"],
        &["./none.toml: cannot be read as a machine"],
    );
    no(&["--scalop", "0.02"], &["--scalop", "--scallop"]);
    no(&["--output", "x.nc", "extra"], &[]);
    let o = morsemill(Path::new("."), &["mil"]);
    assert_eq!(o.status.code(), Some(2));
    assert!(text(&o.stderr).contains("mill"));
}

#[test]
fn a_part_larger_than_the_machine_names_the_axis() {
    // The LongMill travels 792 x 845 x 114 mm.
    for (size, axis) in [
        ((900.0, 100.0, 0.0), "X"),
        ((100.0, 900.0, 0.0), "Y"),
        ((100.0, 100.0, 200.0), "Z"),
    ] {
        let bytes = plate(size.0, size.1, size.2);
        let need = match axis {
            "X" => size.0,
            "Y" => size.1,
            _ => size.2,
        };
        refused(
            &[("big.stl", bytes)],
            "big.stl",
            &[
                "--machine",
                "longmill-30x30",
                "--up",
                "+z",
                "--origin",
                "part",
            ],
            1,
            &[&format!(
                "the part is {need:.1} mm along {axis}, the machine longmill-30x30 travels"
            )],
        );
    }
}

#[test]
fn a_feed_beyond_the_machine_is_said_and_a_speed_refused() {
    let part = PARTS[0].path().display().to_string();
    refused(
        &[],
        &part,
        &["--feed", "99999", "--tool", "ball:100"],
        2,
        &[
            "note: --feed 99999: axis X of longmill-30x30 moves at most",
            "larger than the part",
        ],
    );
    refused(
        &[],
        &part,
        &["--plunge", "99999", "--tool", "ball:100"],
        2,
        &[
            "note: --plunge 99999: axis Z of longmill-30x30 moves at most",
            "larger than the part",
        ],
    );
    refused(
        &[],
        &part,
        &["--speed", "999999"],
        1,
        &["--speed 999999: the spindle of longmill-30x30 turns"],
    );
}

/// An output that cannot be written leaves nothing, and what was there before stays whole.
#[test]
fn an_output_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let part = PARTS[0].path().display().to_string();
    std::fs::create_dir(dir.join("taken")).unwrap();
    let o = morsemill(dir, &["mill", &part, "-o", "taken"]);
    assert_eq!(o.status.code(), Some(2));
    assert!(text(&o.stderr).contains("taken: is a folder, not a file to write"));
    assert_eq!(std::fs::read_dir(dir).unwrap().count(), 1);
    std::fs::write(dir.join("old.nc"), "G0 Z5\n").unwrap();
    let o = morsemill(dir, &["mill", "none.stl", "-o", "old.nc"]);
    assert_eq!(o.status.code(), Some(2));
    assert_eq!(
        std::fs::read_to_string(dir.join("old.nc")).unwrap(),
        "G0 Z5\n"
    );
}
