//! CL files as CAD systems write them: `tests/cl/ok/NAME.cl` with what they mean in `NAME.steps`, and `tests/cl/err/NAME.cl`, each with the one
//! error that it is refused with in a `$$ LINE:COL text` line at its top, or in `NAME.err` beside it where its form has no room for that.
//!
//! `NAME.steps` has a line for each step: the line that caused it, `:`, and the step in mm, mm/min and degrees with at most 4 decimals; then
//! the notes. `UPDATE=1` refreshes it when the change is meant.
#![allow(clippy::unwrap_used)]

use super::story::{morsemill, text};
use morsemill::cldata::{Coolant, ReadOptions, Reader, Step, WriteOptions, Writer, steps};
use morsemill::geom::Plane;
use morsemill::toolpath::{ArcOptions, arcs};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/cl")
        .join(folder);
    let mut all: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|f| f.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "cl"))
        .collect();
    all.sort();
    all
}

/// At most 4 decimals, no trailing zeros, no minus before zero.
fn number(v: f64) -> String {
    let t = format!("{v:.4}");
    let t = t.trim_end_matches('0').trim_end_matches('.');
    if t == "-0" { "0".into() } else { t.into() }
}

fn axes(values: impl IntoIterator<Item = Option<f64>>) -> String {
    "XYZ"
        .chars()
        .zip(values)
        .filter_map(|(c, v)| v.map(|v| format!(" {c}{}", number(v))))
        .collect()
}

fn told(step: &Step) -> String {
    match step {
        Step::Comment(t) => format!("comment {t}").trim_end().into(),
        Step::Tool { number } => format!("tool {number}"),
        Step::Spindle { direction: 0, .. } => "spindle off".into(),
        Step::Spindle {
            direction, speed, ..
        } => {
            let way = if *direction > 0 { "cw" } else { "ccw" };
            format!("spindle {way} {}", number(speed.0))
        }
        Step::Coolant(Coolant::Off) => "coolant off".into(),
        Step::Coolant(Coolant::Flood) => "coolant flood".into(),
        Step::Coolant(Coolant::Mist) => "coolant mist".into(),
        Step::Coolant(Coolant::Both) => "coolant both".into(),
        Step::Dwell(s) => format!("dwell {}", number(s.0)),
        Step::Pause { optional: false } => "pause".into(),
        Step::Pause { optional: true } => "optional pause".into(),
        Step::WorkOffset(n) => format!("work offset {n}"),
        Step::Rapid { to } => format!("rapid{}", axes(*to)),
        Step::MachineRapid { to } => format!("machine rapid{}", axes(*to)),
        Step::Feed {
            to,
            bow: None,
            feed,
        } => format!(
            "feed{} F{}",
            axes(to.iter().map(|c| Some(*c))),
            number(feed.0)
        ),
        Step::Feed {
            to,
            bow: Some(b),
            feed,
        } => {
            let (plane, ij) = match b.plane {
                Plane::Xy => ("XY", [0, 1]),
                Plane::Zx => ("ZX", [2, 0]),
                Plane::Yz => ("YZ", [1, 2]),
            };
            let center = ij.map(|k| format!("{}{}", ["X", "Y", "Z"][k], number(b.center[k])));
            format!(
                "arc {plane} {}{} about {} turn {} F{}",
                if b.sweep > 0.0 { "ccw" } else { "cw" },
                axes(to.iter().map(|c| Some(*c))),
                center.join(" "),
                number(b.sweep.to_degrees()),
                number(feed.0)
            )
        }
        Step::End => "end".into(),
    }
}

#[test]
fn good_files_mean_what_is_beside_them() {
    let files = files("ok");
    assert!(files.len() >= 30, "{} files", files.len());
    let mut wrong = vec![];
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        // A buffer so small that statements fall across it.
        let source = std::io::BufReader::with_capacity(7, bytes.as_slice());
        let mut reader = Reader::new(source, ReadOptions::default());
        let mut got = String::new();
        let mut steps = vec![];
        for s in &mut reader {
            match s {
                Ok((line, step)) => {
                    writeln!(got, "{line}: {}", told(&step)).unwrap();
                    steps.push(step);
                }
                Err(e) => writeln!(got, "{e}").unwrap(),
            }
        }
        for n in reader.notes() {
            writeln!(got, "note {n}").unwrap();
        }
        let beside = file.with_extension("steps");
        if std::env::var("UPDATE").is_ok_and(|v| v == "1") {
            std::fs::write(&beside, &got).unwrap();
        }
        if std::fs::read_to_string(&beside).unwrap_or_default() != got {
            wrong.push(format!("{} gives\n{got}", file.display()));
        }
        assert_eq!(steps.last(), Some(&Step::End), "{}", file.display());
        // What was understood can be said again, and means the same (in places that are whole).
        let mut w = Writer::new(Vec::new(), &WriteOptions::default()).unwrap();
        for s in &steps {
            w.write(s).unwrap();
        }
        let again = w.finish().unwrap();
        let back: Vec<String> = Reader::new(again.as_slice(), ReadOptions::default())
            .map(|s| told(&s.unwrap().1))
            .collect();
        let first: Vec<String> = whole(&steps).iter().map(told).collect();
        assert_eq!(back, first, "{}", file.display());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Steps with the axes of rapids filled in from where the tool is, and times to reach a speed as dwells, as a CL file has them.
fn whole(steps: &[Step]) -> Vec<Step> {
    let mut at = [None; 3];
    let mut out = vec![];
    for s in steps {
        let mut s = s.clone();
        match &mut s {
            Step::Rapid { to } => {
                for (a, t) in at.iter_mut().zip(to.iter()) {
                    *a = t.or(*a);
                }
                if at.iter().all(Option::is_some) {
                    *to = at;
                }
            }
            // Files are written in ASCII.
            Step::Comment(t) => *t = t.replace(|c: char| !c.is_ascii(), "?"),
            Step::Feed { to, .. } => at = [Some(to.x), Some(to.y), Some(to.z)],
            Step::Spindle { spin_up, .. } if spin_up.0 > 0.0 => {
                let wait = std::mem::take(spin_up);
                out.extend([s, Step::Dwell(wait)]);
                continue;
            }
            _ => {}
        }
        out.push(s);
    }
    out
}

/// Whole paths of the shipped parts, with their arcs, come back bit by bit.
#[test]
fn shipped_paths_come_back() {
    let tolerance = super::plans::machine().arc_tolerance.0;
    for cell in super::plans::all() {
        let p = cell.get().unwrap();
        let how = ArcOptions::new(p.plan.fitting, tolerance);
        let path = arcs(&p.plan.toolpath, &p.ground.cutter, &how);
        let all: Vec<Step> = steps(&path, &p.job).map(|s| s.1).collect();
        let mut w = Writer::new(Vec::new(), &WriteOptions::default()).unwrap();
        for s in &all {
            w.write(s).unwrap();
        }
        let bytes = w.finish().unwrap();
        let back: Vec<Step> = Reader::new(bytes.as_slice(), ReadOptions::default())
            .map(|s| s.unwrap().1)
            .collect();
        let want = whole(&all);
        assert_eq!(back.len(), want.len(), "{}", p.part.file);
        let differ = back.iter().zip(&want).find(|(a, b)| a != b);
        assert!(differ.is_none(), "{}: {differ:?}", p.part.file);
        let turns = want
            .iter()
            .filter(|s| matches!(s, Step::Feed { bow: Some(_), .. }));
        eprintln!(
            "{}: {} steps, {} arcs",
            p.part.file,
            want.len(),
            turns.count()
        );
    }
}

#[test]
fn broken_files_are_refused_at_their_line() {
    let files = files("err");
    assert!(files.len() >= 40, "{} files", files.len());
    let mut wrong = vec![];
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        let beside = std::fs::read_to_string(file.with_extension("err"));
        let want = beside.unwrap_or_else(|_| {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let first = text.lines().next().unwrap_or_default().to_string();
            first.strip_prefix("$$ ").unwrap_or_default().to_string()
        });
        let mut reader = Reader::new(bytes.as_slice(), ReadOptions::default());
        let got = reader.find_map(Result::err).map(|e| e.to_string());
        let got = got.unwrap_or_else(|| "no error".into());
        if got != want.trim_end() {
            wrong.push(format!("{}\n  want {want}\n  got  {got}", file.display()));
        }
        assert!(reader.next().is_none(), "fused");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The CL file that `mill --cl` writes is the very path of the program beside it: same places, feeds and order, as an interpreter of the
/// program sees them.
#[test]
fn mill_writes_the_path_that_it_posts() {
    let folder = tempfile::tempdir().unwrap();
    // A small roof: quick to plan.
    let roof = "v 0 0 0\nv 12 0 0\nv 12 5 3\nv 0 5 3\nv 12 10 0\nv 0 10 0\nf 1 2 3\nf 1 3 4\nf 4 3 5\nf 4 5 6\n";
    std::fs::write(folder.path().join("roof.obj"), roof).unwrap();
    let part = "roof.obj".to_string();
    let args = [
        "mill",
        &part,
        "-o",
        "out.nc",
        "--cl",
        "out.cl",
        "--origin",
        "part",
        "--up",
        "+z",
        "--strategy",
        "raster",
        "--scallop",
        "0.1",
    ];
    let o = morsemill(folder.path(), &args);
    assert!(
        folder.path().join("out.nc").exists(),
        "{}{}",
        text(&o.stdout),
        text(&o.stderr)
    );
    let cl = std::fs::read(folder.path().join("out.cl")).unwrap();
    assert!(
        cl.starts_with(b"PARTNO/roof\nUNITS/MM\nCUTTER/6.0,3.0\n") && cl.ends_with(b"END\nFINI\n")
    );
    let rounded = |p: [f64; 3]| p.map(|c| (c * 1e3).round() as i64);
    // Places from the first cut on, without those that round to the one before: the program does not say them.
    let mut told = vec![];
    let mut feeds = 0;
    for s in Reader::new(cl.as_slice(), ReadOptions::default()) {
        match s.unwrap().1 {
            Step::Rapid {
                to: [Some(x), Some(y), Some(z)],
            } if feeds > 0 => told.push(rounded([x, y, z])),
            Step::Feed { to, .. } => {
                feeds += 1;
                told.push(rounded(to.into()));
            }
            _ => {}
        }
    }
    told.dedup();
    let program = std::fs::read_to_string(folder.path().join("out.nc")).unwrap();
    let posted = super::plans::motions(&program);
    let mut posted: Vec<[i64; 3]> = posted.iter().map(|m| rounded(m.2.into())).collect();
    posted.dedup();
    assert_eq!(posted.len(), told.len());
    let near = |a: &[i64; 3], b: &[i64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() <= 1);
    assert!(posted.iter().zip(&told).all(|(a, b)| near(a, b)));
    assert!(feeds > 50, "{feeds}");
    // The same name twice, and a folder, are refused before anything is written.
    let bad = morsemill(
        folder.path(),
        &["mill", &part, "-o", "x.nc", "--cl", "x.nc"],
    );
    assert_eq!(bad.status.code(), Some(2));
    assert!(text(&bad.stderr).contains("is the program's file too"));
    let bad = morsemill(folder.path(), &["mill", &part, "-o", "x.nc", "--cl", "."]);
    assert!(text(&bad.stderr).contains("is a folder"));
    assert!(!folder.path().join("x.nc").exists());
}
