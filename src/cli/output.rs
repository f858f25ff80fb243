//! Files that appear whole or not at all, and standard output that may be closed early.

use super::Failure;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// Writes a file beside its place and renames it, so that nobody ever sees half of it.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let fail =
        |what: &str, e: std::io::Error| Failure::Failed(format!("{}: {what}: {e}", path.display()));
    // A pipe or a device is written into: renaming over it would replace it.
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return std::fs::OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut f| f.write_all(bytes))
            .map_err(|e| fail("cannot be written", e));
    }
    let name = path
        .file_name()
        .ok_or_else(|| Failure::Failed(format!("{}: is not the name of a file", path.display())))?;
    let mut beside = name.to_os_string();
    beside.push(format!(".{}.tmp", std::process::id()));
    let beside = path.with_file_name(beside);
    let written = std::fs::File::create(&beside)
        .and_then(|mut f| f.write_all(bytes).and_then(|()| f.sync_all()))
        .map_err(|e| fail("cannot be written", e));
    let done = written.and_then(|()| {
        std::fs::rename(&beside, path).map_err(|e| fail("cannot be put in place", e))
    });
    if done.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    done
}

/// Writes a value as indented JSON.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
    text.push('\n');
    write_whole(path, text.as_bytes())
}

/// Runs something that prints to standard output; a closed pipe is no error.
pub fn to_stdout(
    print: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<ExitCode, Failure> {
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    match print(&mut out).and_then(|()| out.flush()) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(ExitCode::SUCCESS),
        Err(e) => Err(Failure::Failed(format!("standard output: {e}"))),
    }
}

/// A line on standard error. A closed or full one must not end a job under way, as `eprintln!` would: it panics.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
