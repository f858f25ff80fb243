//! `morsemill controller --replay`: recordings of a real controller against the simulated one.

use super::output::say;
use crate::controller::replay::{compare, parse, replay};
use std::io::Write;
use std::path::Path;

/// Replays a file of recordings, one a line: prints each again with what the simulated controller answers, or with `differences` only
/// what differs. Returns the exit code: 0; 1 if `differences` and there are any; 2 for a file that is not understood.
pub fn run(file: &Path, differences: bool, out: &mut dyn Write) -> u8 {
    match all(file, differences, out) {
        Ok(found) => u8::from(found > 0),
        Err(message) => {
            say(&format!("error: {}: {message}", file.display()));
            2
        }
    }
}

fn all(file: &Path, differences: bool, out: &mut dyn Write) -> Result<usize, String> {
    let text = std::fs::read_to_string(file).map_err(|e| e.to_string())?;
    let (mut records, mut differing, mut found) = (0, 0, 0);
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() {
            continue;
        }
        let at = |e: &dyn std::fmt::Display| format!("line {}: {e}", index + 1);
        let recorded = parse(line).map_err(|e| at(&e))?;
        let answered = replay(&recorded).map_err(|e| at(&e))?;
        records += 1;
        if !differences {
            let json = serde_json::to_string(&answered).map_err(|e| at(&e))?;
            writeln!(out, "{json}").map_err(|e| format!("standard output: {e}"))?;
            continue;
        }
        let here = compare(&recorded, &answered).map_err(|e| at(&e))?;
        differing += usize::from(!here.is_empty());
        found += here.len();
        for difference in here {
            let name = recorded.get("name").or_else(|| recorded.get("id"));
            let name = name.map_or(Ok(String::new()), serde_json::to_string);
            let name = name.map_err(|e| at(&e))?;
            writeln!(out, "line {} {name}: {difference}", index + 1)
                .map_err(|e| format!("standard output: {e}"))?;
        }
    }
    if differences {
        writeln!(out, "{differing} of {records} recordings differ")
            .map_err(|e| format!("standard output: {e}"))?;
    }
    Ok(found)
}
