//! The program a command was given: opened once, read as often as needed, never held whole.
//!
//! All readings are of the one file that was opened, by place: another file put in its place under the same name (as editors and CAM
//! systems save) is not seen. What cannot be wound back (a pipe) is taken into memory, up to [`MOST_PIPED`].

use crate::gcode::source::TextReader;
use crate::link::resume::ProgramText;
use crate::link::{JobReader, JobSource};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

/// Bytes of a program that comes through a pipe, at most: it is held in memory.
pub const MOST_PIPED: u64 = 1 << 29;

/// Bytes read at once.
const BUFFER: usize = 1 << 16;

/// A program.
#[derive(Clone, Debug)]
pub struct ProgramFile {
    name: String,
    content: Content,
    size: u64,
    /// When it was changed last before it was opened.
    changed: Option<SystemTime>,
}

#[derive(Clone, Debug)]
enum Content {
    Disk(Arc<File>),
    Memory(Arc<[u8]>),
}

impl ProgramFile {
    /// Opens a program.
    ///
    /// # Errors
    /// It cannot be read, or cannot be one: a directory, nothing at all, UTF-16. The text names the file.
    pub fn open(path: &Path) -> Result<ProgramFile, String> {
        let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let cannot = |e: io::Error| fail(&format!("cannot be read: {e}"));
        if path.is_dir() {
            return Err(fail(&"this is a directory: name the program inside it"));
        }
        let file = File::open(path).map_err(cannot)?;
        let about = file.metadata().map_err(cannot)?;
        let (content, size) = match about.is_file() {
            true => (Content::Disk(Arc::new(file)), about.len()),
            false => {
                let mut bytes = Vec::new();
                let mut from = file.take(MOST_PIPED + 1);
                from.read_to_end(&mut bytes).map_err(cannot)?;
                let size = bytes.len() as u64;
                if size > MOST_PIPED {
                    return Err(fail(
                        &"more than 512 MB through a pipe: save it to a file, which may be as long as it likes",
                    ));
                }
                (Content::Memory(bytes.into()), size)
            }
        };
        let program = ProgramFile {
            name: path.display().to_string(),
            content,
            size,
            changed: about.modified().ok(),
        };
        if size == 0 {
            return Err(fail(&"the file is empty: there is no program in it"));
        }
        let mut front = Vec::new();
        let mut first = program.read().take(2);
        first.read_to_end(&mut front).map_err(cannot)?;
        if matches!(front[..], [0xff, 0xfe] | [0xfe, 0xff]) {
            return Err(fail(
                &"this is text in UTF-16: save it as plain ASCII or UTF-8",
            ));
        }
        Ok(program)
    }

    /// As it was named.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// From its beginning.
    pub fn read(&self) -> Box<dyn TextReader> {
        match &self.content {
            Content::Disk(file) => Box::new(BufReader::with_capacity(
                BUFFER,
                Placed {
                    file: file.clone(),
                    at: 0,
                    size: self.size,
                },
            )),
            Content::Memory(bytes) => Box::new(Cursor::new(bytes.clone())),
        }
    }

    /// SHA-256 of its bytes, in hexadecimal.
    ///
    /// # Errors
    /// It cannot be read on.
    pub fn fingerprint(&self) -> Result<String, String> {
        let mut hash = Sha256::new();
        let mut from = self.read();
        loop {
            let bytes = from
                .fill_buf()
                .map_err(|e| format!("{}: cannot be read: {e}", self.name))?;
            if bytes.is_empty() {
                break;
            }
            hash.update(bytes);
            let used = bytes.len();
            from.consume(used);
        }
        Ok(hash.finalize().iter().map(|b| format!("{b:02x}")).collect())
    }

    /// What was read was one program, not two halves of different ones.
    ///
    /// # Errors
    /// The file was written to since it was opened.
    pub fn unchanged(&self) -> Result<(), String> {
        let Content::Disk(file) = &self.content else {
            return Ok(());
        };
        let about = file.metadata().ok();
        let now = about.map(|a| (a.len(), a.modified().ok()));
        match now == Some((self.size, self.changed)) {
            true => Ok(()),
            false => Err(format!(
                "{}: was written to while it was read: wait until it is whole, and begin again",
                self.name
            )),
        }
    }
}

impl JobSource for ProgramFile {
    fn open(&self) -> io::Result<Box<dyn JobReader>> {
        Ok(self.read())
    }
}

impl ProgramText for ProgramFile {
    fn open_text(&self) -> io::Result<Box<dyn TextReader + '_>> {
        Ok(self.read())
    }
}

/// A reader with a place of its own in a shared file.
struct Placed {
    file: Arc<File>,
    at: u64,
    /// Where the end was when it was opened.
    size: u64,
}

impl Read for Placed {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n = read_at(&self.file, bytes, self.at)?;
        self.at += n as u64;
        Ok(n)
    }
}

#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, bytes, at)
}

#[cfg(windows)]
fn read_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, bytes, at)
}

impl Seek for Placed {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (base, by) = match to {
            SeekFrom::Start(at) => (at, 0),
            SeekFrom::Current(by) => (self.at, by),
            SeekFrom::End(by) => (self.size, by),
        };
        self.at = base.checked_add_signed(by).ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidInput, "a place before the beginning")
        })?;
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gcode::source::Source;

    #[test]
    fn readings_are_independent_and_of_the_file_that_was_opened() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nc");
        std::fs::write(&path, "G0 X1\nG0 X2\n").unwrap();
        let program = ProgramFile::open(&path).unwrap();
        let mut one = Source::new(program.read()).unwrap();
        let mut two = Source::new(program.read()).unwrap();
        assert_eq!(one.read().unwrap(), Some((1, "G0 X1")));
        assert_eq!(one.read().unwrap(), Some((2, "G0 X2")));
        // Saved anew under the same name, as editors do.
        let other = dir.path().join("b.nc");
        std::fs::write(&other, "G0 X9\n").unwrap();
        std::fs::rename(&other, &path).unwrap();
        assert_eq!(two.read().unwrap(), Some((1, "G0 X1")));
        assert_eq!(two.read().unwrap(), Some((2, "G0 X2")));
        assert_eq!(two.read().unwrap(), None);
        let mut end = program.read();
        assert_eq!(end.seek(SeekFrom::End(-6)).unwrap(), 6);
        assert!(end.seek(SeekFrom::Current(-7)).is_err());
        program.unchanged().unwrap();
        assert_eq!(
            program.fingerprint().unwrap(),
            crate::link::journal::fingerprint(b"G0 X1\nG0 X2\n")
        );
    }

    #[test]
    fn a_file_written_to_is_told() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nc");
        std::fs::write(&path, "G0 X1\n").unwrap();
        let program = ProgramFile::open(&path).unwrap();
        std::fs::write(&path, "G0 X1\nG0 X2\n").unwrap();
        assert!(program.unchanged().unwrap_err().ends_with(
            "a.nc: was written to while it was read: wait until it is whole, and begin again"
        ));
    }
}
