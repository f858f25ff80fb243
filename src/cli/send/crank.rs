//! Turns a session with a real port and clock: keys, journal, events, screen, and the errand at a tool change.

use super::board::Board;
use super::events::{self, Event, Line};
use super::keys::{Pressed, wish_of_line};
use super::screen::Screen;
use crate::cli::errand::interrupts;
use crate::cli::output::say;
use crate::link::errand::{Errand, ErrandOptions, News, Probe, ProbeOptions};
use crate::link::journal::{JournalFile, Keeper, Offsets};
use crate::link::port::Port;
use crate::link::{Command, Outcome, Progress, Session};
use std::fs::File;
use std::io::{BufRead as _, IsTerminal as _, Write};
use std::path::Path;
use std::sync::mpsc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time between two drawings of the screen.
const DRAW: Duration = Duration::from_millis(100);
/// Time between two plain lines of progress.
const PLAIN: Duration = Duration::from_secs(10);
/// Time between two looks at the computer's clock.
const WALL: Duration = Duration::from_secs(1);

/// A job's journal while it runs.
pub struct Journal {
    /// What is written and allowed.
    pub keeper: Keeper,
    /// Where.
    pub file: JournalFile,
}

/// Everyone who hears of the job, and says what is wanted.
pub struct Listener {
    board: Board,
    events: Option<Box<dyn Write>>,
    screen: Option<Screen>,
    typed: Option<mpsc::Receiver<Command>>,
    presses: u32,
    heeded: u32,
    drawn: Duration,
    told: Duration,
    last: String,
}

impl Listener {
    /// With a screen where there is a terminal, unless `plain`.
    ///
    /// # Errors
    /// The file for events cannot be made.
    pub fn new(board: Board, events: Option<&Path>, plain: bool) -> Result<Listener, String> {
        let events: Option<Box<dyn Write>> = match events {
            None => None,
            Some(path) if path.as_os_str() == "-" => Some(Box::new(std::io::stdout())),
            Some(path) => {
                let file = File::create(path)
                    .map_err(|e| format!("{}: cannot be written: {e}", path.display()))?;
                Some(Box::new(file))
            }
        };
        let screen = if plain { None } else { Screen::open() };
        let typed = match screen {
            None if std::io::stdin().is_terminal() => Some(typed()),
            _ => None,
        };
        Ok(Listener {
            board,
            events,
            screen,
            typed,
            presses: 0,
            heeded: 0,
            drawn: Duration::ZERO,
            told: Duration::ZERO,
            last: String::new(),
        })
    }

    /// Something to tell.
    pub fn note(&mut self, text: &str) {
        self.hear(&Progress::Note(text.to_string()), Duration::ZERO);
    }

    fn hear(&mut self, news: &Progress, now: Duration) {
        let line = self.board.hear(news, now);
        let event = events::of(news, self.board.times.total, self.board.left_s());
        self.write(event, now);
        if let Some(line) = line
            && self.screen.is_none()
        {
            say(&line);
        }
    }

    fn write(&mut self, event: Event, now: Duration) {
        let line = Line {
            t_s: events::round(now.as_secs_f64()),
            event,
        };
        let Some(out) = &mut self.events else { return };
        let written = serde_json::to_string(&line)
            .map_err(std::io::Error::from)
            .and_then(|text| writeln!(out, "{text}"))
            .and_then(|()| out.flush());
        if let Err(e) = written {
            // Nobody listens any more: the job goes on without.
            self.events = None;
            if e.kind() != std::io::ErrorKind::BrokenPipe {
                say(&format!("events: {e}"));
            }
        }
    }

    /// The operator's next wish.
    fn wish(&mut self) -> Option<Command> {
        let interrupts = interrupts() + self.presses;
        if interrupts > self.heeded {
            self.heeded += 1;
            return Some(interrupted(self.heeded));
        }
        if let Some(screen) = &mut self.screen {
            return match screen.key()? {
                Pressed::Wish(command) => Some(command),
                Pressed::Interrupt => {
                    self.presses += 1;
                    self.heeded += 1;
                    Some(interrupted(self.heeded))
                }
            };
        }
        self.typed.as_ref()?.try_recv().ok()
    }

    fn show(&mut self, now: Duration) {
        if let Some(screen) = &mut self.screen {
            if now.saturating_sub(self.drawn) >= DRAW {
                self.drawn = now;
                let lines = self.board.draw(screen.width());
                screen.show(lines);
            }
        } else if std::io::stderr().is_terminal() && now.saturating_sub(self.told) >= PLAIN {
            self.told = now;
            if let Some(line) = self.board.progress().filter(|l| *l != self.last) {
                say(&line);
                self.last = line;
            }
        }
    }

    /// The screen goes, what it told last stays.
    fn close(&mut self, outcome: &Outcome, now: Duration) {
        if self.screen.take().is_some() {
            for line in &self.board.log {
                say(line);
            }
        }
        self.write(events::ended(outcome), now);
    }
}

/// The first Ctrl-C stops in order, the second means it.
fn interrupted(times: u32) -> Command {
    match times {
        0 | 1 => Command::Stop,
        _ => Command::ResetNow,
    }
}

/// Wishes typed as lines, where there is a terminal but no screen.
fn typed() -> mpsc::Receiver<Command> {
    say("h hold, r resume, x stop, each with Enter; Ctrl-C stops too");
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { return };
            let Some(command) = wish_of_line(&line) else {
                continue;
            };
            if sender.send(command).is_err() {
                return;
            }
        }
    });
    receiver
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
    /// Thickness of the plate that a new tool is probed on, mm.
    pub tool_plate: Option<f64>,
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
                self.command(wish, listener);
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
            for news in self.session.news() {
                if let Some(journal) = &mut self.journal {
                    journal.keeper.hear(&news, now);
                }
                listener.hear(&news, now);
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

    fn command(&mut self, wish: Command, listener: &mut Listener) {
        if wish == Command::Resume
            && self.session.tool_change().is_some()
            && let Some(plate) = self.tool_plate
            && !self.measure(plate, listener)
        {
            // Told already; the session goes on waiting.
            return;
        }
        self.session.command(wish, self.start.elapsed());
    }

    /// Probes the new tool and sets work Z. The session rests meanwhile: everything it sent was answered and the controller is Idle, so the
    /// errand has the port to itself.
    fn measure(&mut self, plate: f64, listener: &mut Listener) -> bool {
        let task = Probe::new(ProbeOptions {
            plate,
            ..ProbeOptions::default()
        });
        let options = ErrandOptions {
            rx_bytes: self.rx_bytes,
            ..ErrandOptions::default()
        };
        let mut errand = Errand::again(task, options, self.start.elapsed());
        let mut buffer = [0u8; 512];
        listener.note("measuring the new tool: any wish but resume stops the probe");
        let result = loop {
            let now = self.start.elapsed();
            match listener.wish() {
                Some(Command::ResetNow) => errand.reset_now(now),
                Some(Command::Resume) | None => {}
                Some(_) => errand.cancel(now),
            }
            errand.tick(now);
            for news in errand.news() {
                if let News::Note(text) | News::Stopping(text) = news {
                    listener.note(&text);
                }
            }
            listener.show(now);
            let out = errand.output();
            if !out.is_empty()
                && let Err(e) = self.port.write(&out)
            {
                errand.broken(e.to_string(), now);
            }
            if let Some(result) = errand.result() {
                break result;
            }
            match self.port.read(&mut buffer) {
                Ok(n) => errand.receive(buffer.get(..n).unwrap_or_default(), self.start.elapsed()),
                Err(e) => errand.broken(e.to_string(), self.start.elapsed()),
            }
        };
        match (result, errand.task.origin) {
            (Ok(()), Some(origin)) => {
                let mut offsets = Offsets::of(&errand.known().offsets);
                let active = errand.known().modes.work_offset().unwrap_or(0);
                if let Some(system) = offsets.g5x.get_mut(active) {
                    system[2] = origin;
                }
                if let Some(journal) = &mut self.journal {
                    journal
                        .keeper
                        .tool_changed(Some(offsets), self.start.elapsed());
                }
                listener.note(&format!(
                    "the new tool is measured: work Z zero at machine Z{:.3}",
                    origin + 0.0
                ));
                true
            }
            (Err(e), _) => {
                listener.note(&format!(
                    "the tool was not measured: {e}. Resume tries again; x stops the job"
                ));
                false
            }
            (Ok(()), None) => false,
        }
    }
}
