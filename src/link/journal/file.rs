//! The journal on disk: the only file code.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// The disk is asked to keep what it was given this often.
const SYNC_EVERY: Duration = Duration::from_secs(1);
/// Bytes sent in this time before a power cut of the host may be missing from the journal, s: [`SYNC_EVERY`] and as much again for the disk
/// to obey. While the disk is farther behind, [`JournalFile::is_behind`] and no further lines may be allowed.
pub const SYNC_GAP: f64 = 2.0;

/// An append-only file, locked for as long as it is written: whoever else would take the job up finds out with [`JournalFile::in_use`].
///
/// [`JournalFile::append`] hands bytes to the operating system at once: what it took survives the end of this process, `kill -9` included.
/// About once a second a helper thread asks the disk to keep them (`fdatasync`), since that can take long; so a power cut of the host
/// loses [`SYNC_GAP`] seconds at most. The first and the last record are kept before [`JournalFile::create`] and [`JournalFile::close`] return.
/// What cannot be written waits: the file never has a gap, so a disk that was full for a while spoils nothing.
#[derive(Debug)]
pub struct JournalFile {
    file: File,
    wish: mpsc::SyncSender<()>,
    kept: mpsc::Receiver<io::Result<()>>,
    /// Bytes that the operating system has not taken.
    waiting: Vec<u8>,
    /// Since when bytes wait for the disk.
    unkept: Option<Instant>,
    /// When the sync under way was asked for.
    asked: Option<Instant>,
}

impl JournalFile {
    /// A new journal that begins with these bytes, on disk when this returns. It takes the place of one that is there in a single step, so
    /// that there is a journal at every moment; to keep the old one is the caller's affair.
    ///
    /// # Errors
    /// The file cannot be written, or a living process writes it ([`io::ErrorKind::WouldBlock`]).
    pub fn create(path: &Path, first: &[u8]) -> io::Result<JournalFile> {
        if JournalFile::in_use(path)? {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        let mut name = path.as_os_str().to_owned();
        name.push(".new");
        let new = PathBuf::from(name);
        // One that a killed process left is taken over.
        let mut file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&new)?;
        lock(&file)?;
        let written = file.set_len(0).and_then(|()| file.write_all(first));
        let there = written
            .and_then(|()| file.sync_all())
            .and_then(|()| std::fs::rename(&new, path));
        if let Err(e) = there {
            // The name is ours while the lock is.
            let _ = std::fs::remove_file(&new);
            return Err(e);
        }
        keep_name(path);
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
            waiting: Vec::new(),
            unkept: None,
            asked: None,
        })
    }

    /// A living process writes the journal there.
    ///
    /// # Errors
    /// It is there and cannot be opened.
    pub fn in_use(path: &Path) -> io::Result<bool> {
        match File::open(path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(e) => Err(e),
            Ok(file) => Ok(matches!(
                file.try_lock_shared(),
                Err(TryLockError::WouldBlock)
            )),
        }
    }

    /// Appends bytes; they are the operating system's when this returns. What it did not take goes out before the bytes of the next call.
    ///
    /// # Errors
    /// The disk is full or broken: the job must not go on, as it could not be taken up again.
    pub fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.waiting.extend_from_slice(bytes);
        self.hand_over()?;
        self.keep()
    }

    fn hand_over(&mut self) -> io::Result<()> {
        while !self.waiting.is_empty() {
            match self.file.write(&self.waiting) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(n) => {
                    self.waiting.drain(..n);
                    self.unkept.get_or_insert_with(Instant::now);
                }
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
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
        self.waiting.extend_from_slice(last);
        self.hand_over()?;
        self.file.sync_all()
    }
}

/// Locks a file, where the file system knows of locks.
fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(io::ErrorKind::WouldBlock.into()),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// A new name is on disk only with its directory, where a directory can be kept at all.
fn keep_name(path: &Path) {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    if let Ok(directory) = File::open(parent.unwrap_or(Path::new("."))) {
        let _ = directory.sync_all();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_was_appended_is_there_at_once_and_a_living_writer_is_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nc.journal");
        let mut file = JournalFile::create(&path, b"one\n").unwrap();
        file.append(b"two\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one\ntwo\n");
        assert!(!file.is_behind());
        assert!(JournalFile::in_use(&path).unwrap());
        assert_eq!(
            JournalFile::create(&path, b"x").unwrap_err().kind(),
            io::ErrorKind::WouldBlock
        );
        file.close(b"three\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one\ntwo\nthree\n");
        // The helper thread's copy of the file ends with its channel, soon.
        while JournalFile::in_use(&path).unwrap() {
            std::thread::yield_now();
        }
        // Half a beginning that a killed process left is in nobody's way.
        std::fs::write(dir.path().join("a.nc.journal.new"), b"0 1234").unwrap();
        JournalFile::create(&path, b"four\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"four\n");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(!JournalFile::in_use(&dir.path().join("none")).unwrap());
    }

    /// A device that is always full.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_full_disk_does_not_take_waits_in_order() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nc.journal");
        let mut journal = JournalFile::create(&path, b"one\n").unwrap();
        let disk = std::mem::replace(
            &mut journal.file,
            OpenOptions::new().write(true).open("/dev/full").unwrap(),
        );
        for bytes in [b"two\n", b"six\n"] {
            assert_eq!(
                journal.append(bytes).unwrap_err().kind(),
                io::ErrorKind::StorageFull
            );
        }
        journal.file = disk;
        journal.close(b"end\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one\ntwo\nsix\nend\n");
    }
}
