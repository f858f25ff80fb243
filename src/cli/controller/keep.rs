//! `--eeprom FILE`: what the controller keeps when it is switched off.

use super::text_of;
use crate::cli::Failure;
use crate::cli::output::write_whole;
use crate::controller::Memory;
use std::path::Path;

/// What an earlier run has kept; `None` when there is no such file yet.
pub(super) fn read(file: &Path) -> Result<Option<Memory>, String> {
    if !file.exists() {
        return Ok(None);
    }
    let text = text_of(file, "a controller's memory")?;
    Memory::from_text(&file.display().to_string(), &text)
        .map(Some)
        .map_err(|e| e.to_string())
}

/// Keeps it, whole or not at all.
pub(super) fn write(file: &Path, memory: &Memory) -> Result<(), String> {
    write_whole(file, memory.to_text().as_bytes()).map_err(|e| match e {
        Failure::Rejected(text) | Failure::Failed(text) => text,
    })
}
