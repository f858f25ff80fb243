//! The journal on disk: the only file code.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// The disk is asked to keep what it was given this often.
const SYNC_EVERY: Duration = Duration::from_secs(1);
/// Bytes sent in this time before a power cut of the host may be missing from the journal, s: [`SYNC_EVERY`] and as much again for the disk
/// to obey. While the disk is farther behind, [`JournalFile::is_behind`] and no further lines may be allowed.
pub const SYNC_GAP: f64 = 2.0;

/// An append-only file.
///
/// [`JournalFile::append`] hands bytes to the operating system at once: what it took survives the end of this process, `kill -9` included.
/// About once a second a helper thread asks the disk to keep them (`fdatasync`), since that can take long; so a power cut of the host
/// loses [`SYNC_GAP`] seconds at most. The first and the last record are kept before [`JournalFile::create`] and [`JournalFile::close`] return.
#[derive(Debug)]
pub struct JournalFile {
    file: File,
    wish: mpsc::SyncSender<()>,
    kept: mpsc::Receiver<io::Result<()>>,
    /// Since when bytes wait for the disk.
    unkept: Option<Instant>,
    /// When the sync under way was asked for.
    asked: Option<Instant>,
}

impl JournalFile {
    /// A new journal that begins with these bytes, on disk when this returns.
    ///
    /// # Errors
    /// The file is there already, or cannot be written.
    pub fn create(path: &Path, first: &[u8]) -> io::Result<JournalFile> {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        file.write_all(first)?;
        file.sync_all()?;
        let other = file.try_clone()?;
        let (wish, wishes) = mpsc::sync_channel(1);
        let (done, kept) = mpsc::channel();
        std::thread::Builder::new()
            .name("journal".into())
            .spawn(move || {
                while wishes.recv().is_ok() {
                    if done.send(other.sync_data()).is_err() {
                        return;
                    }
                }
            })?;
        Ok(JournalFile {
            file,
            wish,
            kept,
            unkept: None,
            asked: None,
        })
    }

    /// Appends bytes; they are the operating system's when this returns.
    ///
    /// # Errors
    /// The disk is full or broken: the job must not go on, as it could not be taken up again.
    pub fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        if !bytes.is_empty() {
            // One call: the file has no buffer of its own.
            self.file.write_all(bytes)?;
            self.unkept.get_or_insert_with(Instant::now);
        }
        self.keep()
    }

    /// Asks the disk when it is time.
    fn keep(&mut self) -> io::Result<()> {
        while let Ok(result) = self.kept.try_recv() {
            result?;
            self.asked = None;
        }
        if self.asked.is_none()
            && self.unkept.is_some_and(|t| t.elapsed() >= SYNC_EVERY)
            && self.wish.try_send(()).is_ok()
        {
            (self.asked, self.unkept) = (self.unkept, None);
        }
        Ok(())
    }

    /// True while the disk is more than [`SYNC_GAP`] behind: allow no further lines until it has caught up.
    pub fn is_behind(&mut self) -> bool {
        // A failed sync leaves it behind for good.
        if let Ok(Ok(())) = self.kept.try_recv() {
            self.asked = None;
        }
        if self.unkept.is_some() {
            // Bytes wait although nothing new came: ask for them too.
            if self.keep().is_err() {
                return true;
            }
        }
        self.asked
            .or(self.unkept)
            .is_some_and(|t| t.elapsed().as_secs_f64() > SYNC_GAP)
    }

    /// Appends the last bytes and waits until all are on disk.
    ///
    /// # Errors
    /// As [`JournalFile::append`].
    pub fn close(mut self, last: &[u8]) -> io::Result<()> {
        self.file.write_all(last)?;
        self.file.sync_all()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_was_appended_is_there_at_once_and_nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nc.journal");
        let mut file = JournalFile::create(&path, b"one\n").unwrap();
        file.append(b"two\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one\ntwo\n");
        assert!(!file.is_behind());
        assert_eq!(
            JournalFile::create(&path, b"x").unwrap_err().kind(),
            io::ErrorKind::AlreadyExists
        );
        file.close(b"three\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one\ntwo\nthree\n");
    }
}
