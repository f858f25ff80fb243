//! Files that appear whole or not at all, and standard output that may be closed early.

use super::Failure;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A file being written beside its place, so that nobody ever sees half of it: it takes its place with [`WholeFile::finish`], and is gone
/// without. Where a pipe or a device stands in its place, it is written into that, at the end: renaming over it would replace it.
pub struct WholeFile<'a> {
    path: &'a Path,
    beside: PathBuf,
    device: bool,
    file: Option<std::fs::File>,
}

impl<'a> WholeFile<'a> {
    /// Begins the file that will be `path`.
    pub fn create(path: &'a Path) -> Result<WholeFile<'a>, Failure> {
        let device = std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        let name = path.file_name().ok_or_else(|| {
            Failure::Failed(format!("{}: is not the name of a file", path.display()))
        })?;
        let mut beside = name.to_os_string();
        beside.push(format!(".{}.tmp", std::process::id()));
        let beside = if device {
            std::env::temp_dir().join(beside)
        } else {
            path.with_file_name(beside)
        };
        let file = std::fs::File::create(&beside)
            .map_err(|e| Failure::Failed(format!("{}: cannot be written: {e}", path.display())))?;
        Ok(WholeFile {
            path,
            beside,
            device,
            file: Some(file),
        })
    }

    /// Where what is written so far can be read.
    pub fn so_far(&self) -> &Path {
        &self.beside
    }

    /// Puts the file in its place.
    pub fn finish(mut self) -> Result<(), Failure> {
        let fail = |what: &str, e: std::io::Error| {
            Failure::Failed(format!("{}: {what}: {e}", self.path.display()))
        };
        if let Some(file) = &self.file {
            file.sync_all().map_err(|e| fail("cannot be written", e))?;
        }
        if self.device {
            let copy = || {
                let mut from = std::fs::File::open(&self.beside)?;
                let mut to = std::fs::OpenOptions::new().write(true).open(self.path)?;
                std::io::copy(&mut from, &mut to).map(|_| ())
            };
            return copy().map_err(|e| fail("cannot be written", e));
        }
        std::fs::rename(&self.beside, self.path).map_err(|e| fail("cannot be put in place", e))?;
        self.file = None;
        Ok(())
    }
}

impl Write for WholeFile<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file
            .as_mut()
            .map_or(Ok(bytes.len()), |f| f.write(bytes))
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.as_mut().map_or(Ok(()), std::fs::File::flush)
    }
}

impl Drop for WholeFile<'_> {
    fn drop(&mut self) {
        if self.file.is_some() {
            let _ = std::fs::remove_file(&self.beside);
        }
    }
}

/// Writes a file that appears whole or not at all.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)
        .map_err(|e| Failure::Failed(format!("{}: cannot be written: {e}", path.display())))?;
    file.finish()
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
