//! `features` through the binary: every function on grid and mesh, the table of thresholds, and what is refused.
#![allow(clippy::unwrap_used)]

use super::common::PARTS;
use std::path::Path;
use std::process::{Command, Output};

fn run(dir: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_morsemill"))
        .current_dir(dir)
        .args(args)
        .output()
        .unwrap()
}

fn told(dir: &Path, args: &[&str]) -> (String, serde_json::Value) {
    let mut all = vec!["features"];
    all.extend(args);
    all.extend(["--json", "o.json"]);
    let out = run(dir, &all);
    assert_eq!(
        out.status.code(),
        Some(0),
        "{args:?}: {}",
        String::from_utf8_lossy(&out.stderr)
    );
    let json = serde_json::from_slice(&std::fs::read(dir.join("o.json")).unwrap()).unwrap();
    (String::from_utf8(out.stdout).unwrap(), json)
}

/// An upright torus as ASCII STL.
fn torus(dir: &Path) {
    let n = [90usize, 40];
    let at = |i: usize, j: usize| {
        let (su, cu) = ((i % n[0]) as f64 / n[0] as f64 * std::f64::consts::TAU + 0.013).sin_cos();
        let (sv, cv) = ((j % n[1]) as f64 / n[1] as f64 * std::f64::consts::TAU + 0.007).sin_cos();
        let r = 12.0 + 4.0 * cv;
        [4.0 * sv, r * cu, r * su]
    };
    let mut text = String::from("solid torus\n");
    for j in 0..n[1] {
        for i in 0..n[0] {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for t in [[a, b, c], [a, c, d]] {
                text += "facet normal 0 0 0\nouter loop\n";
                for p in t {
                    text += &format!("vertex {} {} {}\n", p[0], p[1], p[2]);
                }
                text += "endloop\nendfacet\n";
            }
        }
    }
    text += "endsolid torus\n";
    std::fs::write(dir.join("torus.stl"), text).unwrap();
}

const FUNCTIONS: [&str; 4] = ["height", "mean-curvature", "geodesic", "projection"];

#[test]
fn every_function_answers_on_grid_and_mesh_and_its_table_tells_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let part = PARTS[5].path().display().to_string();
    for function in FUNCTIONS {
        for on in ["grid", "mesh"] {
            let base = [
                part.as_str(),
                "--up",
                "+z",
                "--scallop",
                "0.05",
                "--function",
                function,
                "--on",
                on,
            ];
            let (said, json) = told(dir, &base);
            assert!(said.contains(&format!("function   {function}")), "{said}");
            assert_eq!(json["function"], function);
            assert_eq!(json["on"], on);
            assert_eq!(json["euler"]["holds"], true, "{function} {on}");
            assert_eq!(json["euler"]["characteristic"], 1, "{function} {on}");
            assert_eq!(
                json["persistence_mm"].is_number(),
                function != "mean-curvature"
            );
            let table = json["persistence_table"].as_array().unwrap();
            assert!(!table.is_empty() && table.len() <= 12);
            assert_eq!(table[0]["threshold"], 0.0);
            // Fewer and fewer, and each row is what its threshold gives.
            for w in table.windows(2) {
                let count = |r: &serde_json::Value, k: &str| r[k].as_u64().unwrap();
                for k in ["maxima", "minima"] {
                    assert!(count(&w[0], k) >= count(&w[1], k), "{function} {on}");
                }
            }
            let row = &table[table.len() / 2];
            let threshold = row["threshold"].to_string();
            let mut with = base.to_vec();
            with.extend(["--persistence", &threshold]);
            let (_, again) = told(dir, &with);
            for k in ["maxima", "minima", "saddles"] {
                assert_eq!(
                    again["critical_points"][k], row[k],
                    "{function} {on} {threshold}"
                );
            }
            if !row["features"].is_null() {
                assert_eq!(
                    again["features"].as_array().unwrap().len() as u64,
                    row["features"].as_u64().unwrap(),
                    "{function} {on} {threshold}"
                );
            }
            // Pairs: born and dead at values that differ by their persistence.
            for p in json["persistence_pairs"].as_array().unwrap() {
                if let (Some(b), Some(d)) = (p["birth"].as_f64(), p["death"].as_f64()) {
                    let persistence = p["persistence"].as_f64().unwrap();
                    assert!(((b - d).abs() - persistence).abs() < 1e-9);
                }
            }
        }
    }
}

#[test]
fn a_closed_torus_has_one_peak_two_saddles_and_one_pit_on_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    torus(dir);
    let (said, json) = told(
        dir,
        &[
            "torus.stl",
            "--on",
            "mesh",
            "--picture",
            "t.png",
            "--origin",
            "part",
        ],
    );
    assert!(said.contains("1 maxima, 1 minima, 2 saddles"), "{said}");
    assert!(said.contains("euler      0"), "{said}");
    assert_eq!(json["euler"]["inside"], 0);
    assert_eq!(json["mesh"]["pieces"], 1);
    assert_eq!(json["mesh"]["border_vertices"], 0);
    assert!(
        std::fs::read(dir.join("t.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    let area = json["part"]["soundness"]["area_mm2"].as_f64().unwrap();
    for f in json["features"].as_array().unwrap() {
        assert!((f["area_mm2"].as_f64().unwrap() / area - 1.0).abs() < 1e-6);
        assert_eq!(f["triangles"], 7200);
    }
    // The other functions have the torus's number too.
    for function in &FUNCTIONS[1..] {
        let (_, json) = told(dir, &["torus.stl", "--on", "mesh", "--function", function]);
        assert_eq!(json["euler"]["holds"], true);
        let n = |k: &str| json["critical_points"][k].as_i64().unwrap();
        assert_eq!(n("maxima") - n("saddles") + n("minima"), 0, "{function}");
    }
}

#[test]
fn the_mesh_itself_has_the_shipped_parts_critical_points() {
    let folder = tempfile::tempdir().unwrap();
    for part in PARTS.iter().filter(|p| p.smooth) {
        let path = part.path().display().to_string();
        let (_, json) = told(
            folder.path(),
            &[&path, "--up", "+z", "--origin", "part", "--on", "mesh"],
        );
        if json["part"]["soundness"]["closed"] == true {
            // A solid's border is on the table: its mesh has walls and an underside instead.
            let n = |k: &str| json["critical_points"][k].as_i64().unwrap();
            assert_eq!(n("maxima") - n("saddles") + n("minima"), 2, "{}", part.file);
            continue;
        }
        let truth = part.truth();
        for (k, name) in [("maxima", "max"), ("minima", "min"), ("saddles", "saddle")] {
            assert_eq!(
                json["critical_points"][k], truth["counts"][name],
                "{}: {name}",
                part.file
            );
        }
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let part = PARTS[5].path().display().to_string();
    for (function, on) in [
        ("geodesic", "grid"),
        ("mean-curvature", "mesh"),
        ("geodesic", "mesh"),
    ] {
        let once = |threads: &str| {
            told(
                dir,
                &[
                    &part,
                    "--function",
                    function,
                    "--on",
                    on,
                    "--scallop",
                    "0.05",
                    "--threads",
                    threads,
                ],
            )
        };
        assert!(once("1") == once("3"), "{function} {on}");
    }
}

#[test]
fn nonsense_is_refused_with_the_functions_unit() {
    let folder = tempfile::tempdir().unwrap();
    let part = PARTS[0].path().display().to_string();
    for (more, words) in [
        (
            vec!["--persistence", "-1"],
            "--persistence -1: must be a number of mm, zero or more",
        ),
        (
            vec!["--persistence", "NaN", "--function", "mean-curvature"],
            "--persistence NaN: must be a number of 1/mm, zero or more",
        ),
        (vec!["--function", "depth"], "mean-curvature"),
        (vec!["--on", "sea"], "mesh"),
    ] {
        let mut args = vec!["features", part.as_str()];
        args.extend(more);
        let out = run(folder.path(), &args);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(said.contains(words), "{said}");
    }
    std::fs::write(
        folder.path().join("nan.stl"),
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\nvertex 2 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    )
    .unwrap();
    let out = run(folder.path(), &["features", "nan.stl", "--on", "mesh"]);
    assert_eq!(out.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&out.stderr).contains("not a number (NaN)"));
    // One triangle is a part, too: one peak, one pit.
    std::fs::write(
        folder.path().join("one.stl"),
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0.5\nvertex 2 0 0\nvertex 0 1 1\nendloop\nendfacet\nendsolid\n",
    )
    .unwrap();
    for function in FUNCTIONS {
        let (_, json) = told(
            folder.path(),
            &[
                "one.stl",
                "--on",
                "mesh",
                "--function",
                function,
                "--up",
                "+z",
                "--persistence",
                "0",
            ],
        );
        assert_eq!(json["critical_points"]["minima"], 1, "{function}");
        assert_eq!(json["critical_points"]["saddles"], 0, "{function}");
        assert_eq!(json["euler"]["holds"], true);
    }
}
