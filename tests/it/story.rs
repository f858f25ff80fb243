//! The whole story through the built binary: mill, look, check, send; and the small commands beside.
#![allow(clippy::unwrap_used)]

use super::common::{PARTS, Shipped};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The program under test, started in a folder of its own.
pub fn morsemill(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_morsemill"))
        .current_dir(folder)
        .args(args)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn good(folder: &Path, args: &[&str]) -> String {
    let o = morsemill(folder, args);
    assert!(
        o.status.success(),
        "{args:?} ended with {:?}\n{}{}",
        o.status.code(),
        text(&o.stdout),
        text(&o.stderr)
    );
    text(&o.stdout)
}

fn json(file: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap()
}

fn number(v: &Value, pointer: &str) -> f64 {
    v.pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{pointer} is no number: {:?}", v.pointer(pointer)))
}

/// A whole PNG: its signature, then chunks whose lengths lead exactly to IEND and the file's end. Returns width and height.
fn whole_png(bytes: &[u8]) -> [u32; 2] {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let u32_at = |i: usize| u32::from_be_bytes(bytes[i..i + 4].try_into().unwrap());
    assert_eq!(&bytes[12..16], b"IHDR");
    let mut at = 8;
    loop {
        let length = u32_at(at) as usize;
        let kind = &bytes[at + 4..at + 8];
        at += 12 + length;
        assert!(at <= bytes.len(), "the picture is cut short");
        if kind == b"IEND" {
            assert_eq!(at, bytes.len());
            return [u32_at(16), u32_at(20)];
        }
    }
}

const SETUP: [&str; 4] = ["--origin", "part", "--up", "+z"];

/// Every key that DESIGN.md section 5 promises for `mill`.
const NUMBERS: [&str; 28] = [
    "/part/triangles",
    "/part/size_mm/0",
    "/part/size_mm/2",
    "/critical_points/maxima",
    "/critical_points/minima",
    "/critical_points/saddles",
    "/features/0/id",
    "/features/0/area_mm2",
    "/features/0/passes",
    "/features/0/cut_mm",
    "/features/0/time_s",
    "/strategies/0/cut_mm",
    "/strategies/0/time_s",
    "/strategies/0/retracts",
    "/program/lines",
    "/program/bytes",
    "/program/cut_mm",
    "/program/rapid_mm",
    "/program/retracts",
    "/time_s/total",
    "/time_s/cutting",
    "/time_s/air",
    "/finish/scallop_um/p50",
    "/finish/scallop_um/p95",
    "/finish/scallop_um/p99",
    "/finish/scallop_um/p999",
    "/finish/scallop_um/max",
    "/seconds/import",
];

#[test]
fn from_part_to_chips() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let part = PARTS[0].path().display().to_string();

    // Mill.
    let mut args = vec![
        "mill", &part, "-o", "out.nc", "--json", "out.json", "--report", "report",
    ];
    args.extend(SETUP);
    args.extend(["--feed", "1500", "--plunge", "500"]);
    let said = good(dir, &args);
    for word in [
        "critical   2 maxima, 4 minima, 1 saddles",
        "verdict    pass",
        "area, mm2",
        "cusps",
        "out.nc:",
    ] {
        assert!(said.contains(word), "{word:?} is not in:\n{said}");
    }
    let told = json(&dir.join("out.json"));
    for key in NUMBERS {
        number(&told, key);
    }
    for key in [
        "/finish/over_scallop_area_percent",
        "/finish/gouge_um_max",
        "/finish/uncut_area_mm2",
        "/finish/rest_area_mm2",
        "/seconds/reach",
    ] {
        number(&told, key);
    }
    assert!(told["features"][0]["kind"].is_string() && told["strategies"][0]["name"].is_string());
    assert_eq!(told["verdict"], "pass");
    assert_eq!(told["part"]["triangles"], 19044);
    let counts =
        ["maxima", "minima", "saddles"].map(|k| told["critical_points"][k].as_u64().unwrap());
    assert_eq!(counts, [2, 4, 1]);
    assert_eq!(json(&dir.join("report/report.json")), told);
    // The parts of the whole are the whole.
    let program = std::fs::read_to_string(dir.join("out.nc")).unwrap();
    assert!(program.ends_with("M30\n"));
    assert_eq!(
        number(&told, "/program/lines") as usize,
        program.lines().count()
    );
    assert_eq!(number(&told, "/program/bytes") as usize, program.len());
    let features = told["features"].as_array().unwrap();
    let sum = |key: &str| {
        features
            .iter()
            .map(|f| f[key].as_f64().unwrap())
            .sum::<f64>()
    };
    let total = number(&told, "/time_s/total");
    assert!(
        (sum("time_s") - total).abs() < 0.05 * total,
        "{} {total}",
        sum("time_s")
    );
    assert!(sum("cut_mm") <= number(&told, "/program/cut_mm") + 1e-6);
    // Pictures.
    let mut pictures = 0;
    for f in std::fs::read_dir(dir.join("report")).unwrap() {
        let path = f.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(!name.contains(".tmp"), "{name}");
        if name.ends_with(".png") {
            let [w, h] = whole_png(&std::fs::read(&path).unwrap());
            assert!(w >= 400 && h >= 300, "{name}: {w} x {h}");
            pictures += 1;
        }
    }
    assert!(
        pictures >= 3,
        "features, passes and cusps: {pictures} pictures"
    );

    // Check: the same text, the same figures.
    let mut args = vec![
        "check",
        "out.nc",
        "--machine",
        "longmill-30x30",
        "--part",
        &part,
        "--json",
        "check.json",
    ];
    args.extend(SETUP);
    good(dir, &args);
    let checked = json(&dir.join("check.json"));
    for block in [
        "program", "time_s", "motion", "extents", "verdict", "problems",
    ] {
        assert_eq!(checked[block], told[block], "{block}");
    }
    for key in [
        "/finish/scallop_um/p50",
        "/finish/scallop_um/p99",
        "/finish/scallop_um/max",
        "/finish/gouge_um_max",
    ] {
        let (a, b) = (number(&checked, key), number(&told, key));
        assert!((a - b).abs() < 0.5, "{key}: mill {b}, check {a}");
    }

    // Send it to the simulated controller over a pseudo-terminal.
    let said = good(
        dir,
        &[
            "send",
            "out.nc",
            "--machine",
            "longmill-30x30",
            "--port",
            "sim",
            "--json",
            "send.json",
        ],
    );
    assert!(said.contains("result"), "{said}");
    let sent = json(&dir.join("send.json"));
    assert_eq!(sent["result"], "done");
    assert_eq!(sent["lines"], sent["acknowledged"]);
    assert_eq!(sent["lines"], sent["lines_total"]);
    assert_eq!(sent["position_kept"], true);
    let end = super::plans::motions(&program).last().unwrap().2;
    for k in 0..3 {
        let at = number(&sent, &format!("/final_position_mm/{k}"));
        // The controller counts whole steps of its motors.
        assert!(
            (at - end[k]).abs() < 0.006,
            "axis {k}: {at}, the program ends at {}",
            end[k]
        );
    }
    let machine = number(&sent, "/machine_time_s");
    assert_eq!(sent["machine_time_source"], "controller");
    assert!(
        (machine - total).abs() < 0.03 * total,
        "controller {machine} s, told {total} s"
    );

    // Nothing half-written is left.
    for f in std::fs::read_dir(dir).unwrap() {
        let name = f.unwrap().file_name().to_string_lossy().into_owned();
        assert!(!name.contains(".tmp") && !name.ends_with(".part"), "{name}");
    }
}

#[test]
fn features_tells_them_without_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let part = Shipped::path(&PARTS[5]).display().to_string();
    let said = good(
        folder.path(),
        &[
            "features",
            &part,
            "--up",
            "+z",
            "--origin",
            "part",
            "--json",
            "f.json",
            "--picture",
            "f.png",
        ],
    );
    assert!(said.contains("5 maxima, 8 minima, 4 saddles"), "{said}");
    let told = json(&folder.path().join("f.json"));
    assert_eq!(
        told["critical_points"]["points"].as_array().unwrap().len(),
        17
    );
    assert!(told["features"].as_array().unwrap().len() > 3);
    whole_png(&std::fs::read(folder.path().join("f.png")).unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn the_small_commands_answer() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let machines = good(dir, &["machines"]);
    assert!(machines.contains("longmill-30x30") && machines.contains("travel X Y Z, mm"));
    let posts = good(dir, &["posts"]);
    assert!(posts.contains("grbl") && posts.contains("linuxcnc"));
    good(dir, &["ports"]);
    let help = good(dir, &["--help"]);
    for command in [
        "mill",
        "features",
        "check",
        "send",
        "controller",
        "ports",
        "machines",
        "posts",
    ] {
        assert!(help.contains(command), "{help}");
    }
    assert!(good(dir, &["--version"]).starts_with("morsemill "));
    assert_eq!(std::fs::read_dir(dir).unwrap().count(), 0);
}

#[test]
fn the_controller_serves_a_path_until_it_is_ended() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_morsemill"))
        .args(["controller", "--pty", "--speed", "max"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut path = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut path)
        .unwrap();
    let path = path.trim().to_string();
    assert!(
        path.starts_with("/dev/") && Path::new(&path).exists(),
        "{path:?}"
    );
    // Another process sends to that path as to any serial device.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("p.nc"),
        "G21 G90\nM3 S1000\nG0 Z5\nG0 X3 Y4\nG1 Z1 F300\nG0 Z5\nM5\nM30\n",
    )
    .unwrap();
    let sent = morsemill(
        folder.path(),
        &["send", "p.nc", "--port", &path, "--json", "s.json"],
    );
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(
        sent.status.success(),
        "{}{}",
        text(&sent.stdout),
        text(&sent.stderr)
    );
    let told = json(&folder.path().join("s.json"));
    assert_eq!(
        (&told["acknowledged"], &told["result"]),
        (&Value::from(8), &Value::from("done"))
    );
    for (k, want) in [3.0, 4.0, 5.0].into_iter().enumerate() {
        assert!((number(&told, &format!("/final_position_mm/{k}")) - want).abs() < 0.006);
    }
}
