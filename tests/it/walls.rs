//! Walls of a closed solid through the binary: cut as deep as the flutes are long, and what stays standing is told.
#![allow(clippy::unwrap_used)]

use super::story::{morsemill, text};
use std::path::Path;

/// A closed box as an OBJ.
fn block(x: f64, y: f64, z: f64) -> String {
    let mut out = String::new();
    for i in 0..8 {
        let at = |bit: usize, size: f64| if i >> bit & 1 == 1 { size } else { 0.0 };
        out += &format!("v {} {} {}\n", at(0, x), at(1, y), at(2, z));
    }
    for f in [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "2 4 8 6", "4 3 7 8", "3 1 5 7",
    ] {
        out += &format!("f {f}\n");
    }
    out
}

/// Mills the box in `dir`: exit code, what it said, and the report.
fn mill(dir: &Path, tool: &str, more: &[&str]) -> (Option<i32>, String, serde_json::Value) {
    let mut args = vec![
        "mill", "box.obj", "-o", "out.nc", "--tool", tool, "--json", "out.json", "--origin", "part",
    ];
    args.extend(more);
    let o = morsemill(dir, &args);
    let json = serde_json::from_slice(&std::fs::read(dir.join("out.json")).unwrap()).unwrap();
    (o.status.code(), text(&o.stdout), json)
}

#[test]
fn walls_deeper_than_the_flutes_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    std::fs::write(dir.join("box.obj"), block(14.0, 10.0, 30.0)).unwrap();
    let uncut = |j: &serde_json::Value| j["walls"]["uncut_wall_mm2"].as_f64().unwrap();
    // Flutes of 18 mm of 30: all round, the lowest 12 mm stay. Nobody named a floor.
    let (code, said, json) = mill(dir, "ball:6", &[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(json["verdict"], "pass");
    assert!((uncut(&json) / (48.0 * 12.0) - 1.0).abs() < 0.03, "{json}");
    assert!(said.contains("of upright wall are not cut"), "{said}");
    assert!(json["program"]["retracts"].as_u64().unwrap() <= 2, "{json}");
    // Where the user did name it, it is a failure; the program is there all the same.
    std::fs::remove_file(dir.join("out.nc")).unwrap();
    let (code, said, json) = mill(dir, "ball:6", &["--floor", "0"]);
    assert_eq!(code, Some(1), "{said}");
    assert_eq!(json["verdict"], "fail");
    assert!(dir.join("out.nc").exists());
    // A floor within reach, and flutes that are long enough.
    for (tool, floor) in [("ball:6", "13"), ("ball:6,flute:32", "0")] {
        let (code, said, json) = mill(dir, tool, &["--floor", floor]);
        assert_eq!((code, uncut(&json)), (Some(0), 0.0), "{said}");
        assert!(!said.contains("of upright wall are not cut"), "{said}");
    }
}
