//! Turns the crank of a session that keeps a journal.

use super::file::JournalFile;
use super::keeper::Keeper;
use crate::link::command::Command;
use crate::link::outcome::Outcome;
use crate::link::port::Port;
use crate::link::progress::Progress;
use crate::link::session::Session;
use std::io;
use std::time::Duration;

/// Where a journal's bytes go.
pub trait Keep {
    /// They are the operating system's when this returns.
    ///
    /// # Errors
    /// They are not: the job stops.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;
    /// The disk is too far behind to allow more lines.
    fn is_behind(&mut self) -> bool;
}

impl Keep for JournalFile {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        JournalFile::append(self, bytes)
    }

    fn is_behind(&mut self) -> bool {
        JournalFile::is_behind(self)
    }
}

impl Keep for Vec<u8> {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.extend_from_slice(bytes);
        Ok(())
    }

    fn is_behind(&mut self) -> bool {
        false
    }
}

/// [`crate::link::drive()`] with a journal: no line goes out before the journal allows it. When the journal cannot be written the job is
/// stopped in order, and `progress` hears why. Returns the last bytes too: append them and close.
pub fn drive_kept(
    session: &mut Session,
    keeper: &mut Keeper,
    file: &mut dyn Keep,
    port: &mut dyn Port,
    clock: &mut dyn FnMut() -> Duration,
    command: &mut dyn FnMut(&Session, &mut Keeper) -> Option<Command>,
    progress: &mut dyn FnMut(&Progress),
) -> (Outcome, Vec<u8>) {
    let mut buffer = [0u8; 512];
    let mut lost = false;
    session.allow_up_to(0);
    loop {
        let now = clock();
        while let Some(wish) = command(session, keeper) {
            session.command(wish, now);
        }
        let behind = file.is_behind();
        let kept = keeper
            .turn(now, behind)
            .map_err(|e| e.to_string())
            .and_then(|turn| {
                file.append(&turn.bytes).map_err(|e| e.to_string())?;
                Ok(turn.allowed)
            });
        match kept {
            Ok(allowed) => session.allow_up_to(allowed),
            Err(why) if !lost => {
                lost = true;
                session.allow_up_to(0);
                progress(&Progress::Note(format!(
                    "the journal cannot be kept ({why}): stopping, as a job without one could not be taken up again"
                )));
                session.command(Command::Stop, now);
            }
            Err(_) => {}
        }
        session.tick(now);
        let out = session.output();
        if !out.is_empty() {
            // On an error nobody knows how much went out: all of it may have.
            let sent = port.write(&out);
            session.written(out.len());
            if let Err(e) = sent {
                session.broken(e.to_string(), now);
            }
        }
        for news in session.news() {
            keeper.hear(&news, now);
            progress(&news);
        }
        if let Some(outcome) = session.outcome() {
            let last = keeper.end(&outcome, now);
            return (outcome, last);
        }
        match port.read(&mut buffer) {
            Ok(n) => session.receive(buffer.get(..n).unwrap_or_default(), clock()),
            Err(e) => session.broken(e.to_string(), clock()),
        }
    }
}
