//! `morsemill controller --replay`: recordings of a real controller against the simulated one.

use super::output::say;
use std::io::Write;
use std::path::Path;

/// Replays a file. Returns the exit code.
pub fn run(file: &Path, compare: bool, out: &mut dyn Write) -> u8 {
    let _ = (compare, out);
    say(&format!(
        "error: {}: cannot be replayed yet",
        file.display()
    ));
    2
}
