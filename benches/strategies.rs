//! What each strategy makes of a part, as a Markdown table: `cargo bench --bench strategies [-- PART.stl ...]`.
//!
//! Runs the built program itself, once for each strategy, with a ball of 6 mm and cusps of 20 um; every row is judged by the dry run of
//! its own program. The last row of a part is the same raster retracting to the safe height after each pass: planned, not posted.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use serde_json::Value;
use std::path::Path;
use std::process::Command;

const STRATEGIES: [&str; 5] = [
    "auto",
    "iso-scallop",
    "iso-pick-feed",
    "isoplanar",
    "raster",
];

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/parts");
    let named: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let parts: Vec<String> = if named.is_empty() {
        ["two-peaks.stl", "peaks-and-pits.stl", "steep-relief.stl"]
            .iter()
            .map(|f| folder.join(f).to_string_lossy().into_owned())
            .collect()
    } else {
        named
    };
    println!(
        "| part | strategy | at feed, mm | passes | retracts | time, s | vertical RMS, mm/s2 | p99, um | max, um |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let scratch = tempfile::tempdir().unwrap();
    for part in &parts {
        let name = Path::new(part).file_stem().unwrap().to_string_lossy();
        for strategy in STRATEGIES {
            let json = scratch.path().join("out.json");
            let program = scratch.path().join("out.nc");
            let run = Command::new(env!("CARGO_BIN_EXE_morsemill"))
                .args(["mill", part, "--up", "+z", "--strategy", strategy])
                .args([
                    "--tool",
                    "ball:6",
                    "--scallop",
                    "0.02",
                    "--feed",
                    "1500",
                    "--plunge",
                    "500",
                ])
                .arg("--json")
                .arg(&json)
                .arg("-o")
                .arg(&program)
                .output()
                .unwrap();
            let Ok(text) = std::fs::read_to_string(&json) else {
                println!(
                    "| {name} | {strategy} | {} |",
                    String::from_utf8_lossy(&run.stderr).trim()
                );
                continue;
            };
            let v: Value = serde_json::from_str(&text).unwrap();
            let _ = std::fs::remove_file(&json);
            let rows = v["strategies"].as_array().cloned().unwrap_or_default();
            let chosen = rows
                .iter()
                .find(|r| r["chosen"] == true)
                .cloned()
                .unwrap_or_default();
            let what = match strategy {
                "auto" => format!("**auto**: {}", chosen["name"].as_str().unwrap_or_default()),
                "raster" => chosen["name"].as_str().unwrap_or_default().to_string(),
                other => other.to_string(),
            };
            let f = &v["finish"]["scallop_um"];
            row(
                &name,
                &what,
                &chosen,
                Some([number(&f["p99"]), number(&f["max"])]),
            );
            if strategy == "raster" {
                for r in rows.iter().filter(|r| {
                    r["name"]
                        .as_str()
                        .is_some_and(|n| n.ends_with("retracting"))
                }) {
                    row(&name, r["name"].as_str().unwrap_or_default(), r, None);
                }
            }
        }
    }
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or(f64::NAN)
}

fn row(part: &str, what: &str, r: &Value, finish: Option<[f64; 2]>) {
    let finish = match finish {
        Some([p99, max]) => format!("{p99:.1} | {max:.1}"),
        None => "- | -".to_string(),
    };
    println!(
        "| {part} | {what} | {:.0} | {} | {} | {:.0} | {:.0} | {finish} |",
        number(&r["cut_mm"]),
        r["passes"],
        r["retracts"],
        number(&r["time_s"]),
        number(&r["vertical_acceleration_rms_mm_s2"]),
    );
}
