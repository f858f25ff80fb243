//! Turns a session with a real port and clock: wishes, journal, news, and the tool change.

use super::change::{Changed, Changer};
use super::hands::{FIRST_STEP, Hands};
use super::listener::Listener;
use crate::link::errand::ErrandOptions;
use crate::link::journal::{JournalFile, Keeper};
use crate::link::port::Port;
use crate::link::{Command, Outcome, Progress, Prompt, PromptKind, Session};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time between two looks at the computer's clock.
const WALL: Duration = Duration::from_secs(1);

/// A job's journal while it runs.
pub struct Journal {
    /// What is written and allowed.
    pub keeper: Keeper,
    /// Where.
    pub file: JournalFile,
}

/// A session with all that belongs to it.
pub struct Crank<'a> {
    /// The job with its controller.
    pub session: Session,
    /// The way there.
    pub port: &'a mut dyn Port,
    /// Its journal.
    pub journal: Option<Journal>,
    /// When the port was opened.
    pub start: Instant,
    /// What happens at a tool change.
    pub changer: Changer,
    /// Receive buffer to assume, bytes.
    pub rx_bytes: usize,
}

impl Crank<'_> {
    /// Runs the session to its end.
    pub fn turn(mut self, listener: &mut Listener) -> Outcome {
        let mut buffer = [0u8; 512];
        let mut wall = Duration::ZERO;
        let mut journal_lost = false;
        if self.journal.is_some() {
            self.session.allow_up_to(0);
        }
        loop {
            let now = self.start.elapsed();
            if wall.is_zero() || now.saturating_sub(wall) >= WALL {
                wall = now;
                let time = SystemTime::now()
                    .duration_since(UNIX_EPOCH)
                    .unwrap_or_default();
                self.session.wall_clock(time, now);
            }
            while let Some(wish) = listener.wish() {
                self.session.command(wish, self.start.elapsed());
            }
            if let Err(why) = self.allow(now)
                && !journal_lost
            {
                journal_lost = true;
                self.session.allow_up_to(0);
                listener.note(&format!(
                    "the journal cannot be kept ({why}): stopping, as a job without one could not be taken up again"
                ));
                self.session.command(Command::Stop, now);
            }
            self.session.tick(now);
            let out = self.session.output();
            if !out.is_empty() {
                // On an error nobody knows how much went out: all of it may have.
                let sent = self.port.write(&out);
                self.session.written(out.len());
                if let Err(e) = sent {
                    self.session.broken(e.to_string(), now);
                }
            }
            let mut change = None;
            for news in self.session.news() {
                if let Some(journal) = &mut self.journal {
                    journal.keeper.hear(&news, now);
                }
                match news {
                    // Told once the tool is up.
                    Progress::Prompt(prompt)
                        if matches!(prompt.kind, PromptKind::ToolChange { .. }) =>
                    {
                        change = Some(prompt);
                    }
                    news => listener.hear(&news, now),
                }
            }
            if let Some(prompt) = change {
                self.change(&prompt, listener);
            }
            listener.show(now);
            if let Some(outcome) = self.session.outcome() {
                if let Some(Journal { mut keeper, file }) = self.journal.take()
                    && let Err(e) = file.close(&keeper.end(&outcome, now))
                {
                    listener.note(&format!("the journal's end could not be written: {e}"));
                }
                listener.close(&outcome, now);
                return outcome;
            }
            match self.port.read(&mut buffer) {
                Ok(n) => self
                    .session
                    .receive(buffer.get(..n).unwrap_or_default(), self.start.elapsed()),
                Err(e) => self.session.broken(e.to_string(), self.start.elapsed()),
            }
        }
    }

    /// Write-ahead: lines may go out once the journal that allows them is the operating system's.
    fn allow(&mut self, now: Duration) -> Result<(), String> {
        let Some(Journal { keeper, file }) = &mut self.journal else {
            return Ok(());
        };
        let behind = file.is_behind();
        let turn = keeper.turn(now, behind).map_err(|e| e.to_string())?;
        file.append(&turn.bytes).map_err(|e| e.to_string())?;
        self.session.allow_up_to(turn.allowed);
        Ok(())
    }

    /// The session rests: everything it sent was answered and the controller is Idle, so the port is lent to errands meanwhile.
    fn change(&mut self, prompt: &Prompt, listener: &mut Listener) {
        let mut hands = Hands {
            port: self.port,
            start: self.start,
            options: ErrandOptions {
                rx_bytes: self.rx_bytes,
                ..ErrandOptions::default()
            },
            step: FIRST_STEP,
        };
        let changed = self.changer.change(prompt, &mut hands, listener);
        let now = self.start.elapsed();
        self.session.port_is_back(now);
        match changed {
            Changed::GoOn(offsets) => {
                if let Some(journal) = &mut self.journal {
                    journal.keeper.tool_changed(offsets.map(|o| *o), now);
                }
                self.session.command(Command::Resume, now);
            }
            Changed::Stop => self.session.command(Command::Stop, now),
            Changed::Lost(why) => self.session.give_up(why, now),
        }
    }
}
