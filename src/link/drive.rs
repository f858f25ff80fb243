//! Turns the crank of a session, or of an introduction, with a real port and clock.

use super::command::Command;
use super::introduction::{Introduction, Known, Unknown};
use super::outcome::Outcome;
use super::port::{Port, PortError};
use super::progress::Progress;
use super::session::Session;
use crate::wire::{Lines, Reply};
use std::time::Duration;

/// Runs a session over a port until it ends. `clock` gives the time since the port was opened, `command` the operator's next wish,
/// `progress` hears the news.
pub fn drive(
    session: &mut Session,
    port: &mut dyn Port,
    clock: &mut dyn FnMut() -> Duration,
    command: &mut dyn FnMut() -> Option<Command>,
    progress: &mut dyn FnMut(&Progress),
) -> Outcome {
    let mut buffer = [0u8; 512];
    loop {
        let now = clock();
        while let Some(wish) = command() {
            session.command(wish, now);
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
            progress(&news);
        }
        if let Some(outcome) = session.outcome() {
            return outcome;
        }
        match port.read(&mut buffer) {
            Ok(n) => session.receive(buffer.get(..n).unwrap_or_default(), clock()),
            Err(e) => session.broken(e.to_string(), clock()),
        }
    }
}

/// Why a controller did not introduce itself.
#[derive(Debug, thiserror::Error)]
pub enum NotIntroduced {
    /// The controller's doing.
    #[error(transparent)]
    Controller(#[from] Unknown),
    /// The port's doing.
    #[error(transparent)]
    Port(#[from] PortError),
}

/// Runs an introduction over a port until it ends.
///
/// # Errors
/// Nobody answered, the controller is busy, or the port broke.
pub fn introduce(
    mut introduction: Introduction,
    port: &mut dyn Port,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<Known, NotIntroduced> {
    let (mut buffer, mut lines) = ([0u8; 512], Lines::default());
    loop {
        introduction.tick(clock());
        let out = introduction.output();
        if !out.is_empty() {
            port.write(&out)?;
        }
        match introduction.result() {
            Some(Ok(known)) => return Ok(known.clone()),
            Some(Err(why)) => return Err(why.clone().into()),
            None => {}
        }
        let n = port.read(&mut buffer)?;
        for line in lines.feed(buffer.get(..n).unwrap_or_default()) {
            introduction.receive(&Reply::parse(&line), clock());
        }
    }
}
