//! The same bytes on any number of threads and on every run.
#![allow(clippy::unwrap_used)]

use super::common::PARTS;
use super::story::{morsemill, text};
use std::collections::BTreeMap;
use std::path::Path;

/// All files of a run, the clock's figures taken out of the JSON.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    for dir in [folder.to_path_buf(), folder.join("report")] {
        for f in std::fs::read_dir(dir).unwrap() {
            let path = f.unwrap().path();
            if path.is_dir() {
                continue;
            }
            let mut bytes = std::fs::read(&path).unwrap();
            if path.extension().is_some_and(|e| e == "json") {
                let mut v: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
                assert!(v.as_object_mut().unwrap().remove("seconds").is_some());
                bytes = v.to_string().into_bytes();
            }
            out.insert(
                path.strip_prefix(folder).unwrap().display().to_string(),
                bytes,
            );
        }
    }
    out
}

/// At 50 um, for time; the noisy soup is the part whose ties and duplicates would show any dependence on order.
#[test]
fn program_report_and_pictures_are_the_same_bytes() {
    for part in [PARTS[4]] {
        let path = part.path().display().to_string();
        let run = |threads: &str| {
            let folder = tempfile::tempdir().unwrap();
            let o = morsemill(
                folder.path(),
                &[
                    "--threads",
                    threads,
                    "mill",
                    &path,
                    "-o",
                    "out.nc",
                    "--scallop",
                    "0.05",
                    "--json",
                    "out.json",
                    "--report",
                    "report",
                ],
            );
            assert!(o.status.success(), "{}{}", text(&o.stdout), text(&o.stderr));
            (files(folder.path()), o.stdout)
        };
        let first = run("1");
        assert!(first.0.len() >= 6, "{:?}", first.0.keys());
        for threads in ["2", "2"] {
            let other = run(threads);
            assert!(first.1 == other.1, "{}: standard output differs", part.file);
            for (name, bytes) in &first.0 {
                assert!(
                    other.0.get(name) == Some(bytes),
                    "{}: {name} differs with {threads} threads",
                    part.file
                );
            }
        }
    }
}
