//! Everyone who hears of a job: screen, plain lines, events; and everyone who says what is wanted: keys, typed lines, a script's lines,
//! signals.
//!
//! Ctrl-C, where somebody can resume: the first holds, the second stops in order (hold, standstill, reset), the third resets at once.
//! A signal (`kill -TERM`, a closed terminal) where nobody can: the first stops in order, the second changes nothing, the third resets.

use super::board::Board;
use super::events::{self, Event, Line};
use super::keys::{Hand, Pressed, hand, pressed, wish_of_line};
use super::screen::{Keyboard, Screen};
use crate::cli::errand::interrupts;
use crate::cli::output::say;
use crate::link::{Command, Known, Outcome, Progress};
use crate::wire::{State, Status};
use std::fs::File;
use std::io::{BufRead as _, IsTerminal as _, Write};
use std::path::Path;
use std::sync::mpsc::{self, TryRecvError};
use std::time::Duration;

/// Time between two drawings of the screen.
const DRAW: Duration = Duration::from_millis(100);
/// Time between two plain lines of progress.
const PLAIN: Duration = Duration::from_secs(10);

/// What somebody wants while the machine is in the operator's hands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Press {
    /// A key.
    Hand(Hand),
    /// A typed or written line.
    Wish(Command),
}

/// How far Ctrl-C has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Pressure {
    #[default]
    None,
    /// A hold was sent for it.
    Held,
    /// A stop was sent; a signal more changes nothing yet.
    Stopping,
    /// The next one resets.
    Last,
}

/// Everyone who hears of the job, and says what is wanted.
pub struct Listener {
    /// What the operator sees.
    pub board: Board,
    events: Option<Box<dyn Write>>,
    screen: Option<Screen>,
    typed: Option<mpsc::Receiver<Result<Command, String>>>,
    signals: u32,
    pressure: Pressure,
    now: Duration,
    drawn: Duration,
    told: Duration,
    last: String,
}

impl Listener {
    /// With a screen where there is a terminal, unless `plain`. Without one, lines typed at a terminal are commands; with `events`, so are
    /// those that a script writes to standard input.
    ///
    /// # Errors
    /// The file for events cannot be made.
    pub fn new(board: Board, events: Option<&Path>, plain: bool) -> Result<Listener, String> {
        let scripted = events.is_some();
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
        let terminal = std::io::stdin().is_terminal();
        if screen.is_none() && terminal {
            say("h hold, r resume, x stop, each with Enter; Ctrl-C holds, twice stops");
        }
        let typed = (screen.is_none() && (terminal || scripted)).then(typed);
        Ok(Listener {
            board,
            events,
            screen,
            typed,
            signals: 0,
            pressure: Pressure::None,
            now: Duration::ZERO,
            drawn: Duration::ZERO,
            told: Duration::ZERO,
            last: String::new(),
        })
    }

    /// Somebody can say `resume` here.
    pub fn can_answer(&self) -> bool {
        self.screen.is_some() || self.typed.is_some()
    }

    /// There are keys, one press each.
    pub fn has_keys(&self) -> bool {
        self.screen.is_some()
    }

    /// Something to tell.
    pub fn note(&mut self, text: &str) {
        self.hear(&Progress::Note(text.to_string()), self.now);
    }

    /// Something that waits for the operator's `resume`.
    pub fn confirm(&mut self, text: &str) {
        let line = format!("confirm: {text}");
        self.board.attention = Some(text.to_string());
        self.board.keep(line.clone());
        self.write(
            Event::Confirm {
                text: text.to_string(),
            },
            self.now,
        );
        if self.screen.is_none() {
            say(&line);
        }
    }

    /// News of the job at `now`.
    pub fn hear(&mut self, news: &Progress, now: Duration) {
        self.now = now;
        if matches!(news, Progress::Resumed) && self.pressure == Pressure::Held {
            self.pressure = Pressure::None;
        }
        let line = self.board.hear(news, now);
        let event = events::of(news, self.board.times.total, self.board.left_s());
        self.write(event, now);
        if let Some(line) = line
            && self.screen.is_none()
        {
            say(&line);
        }
        if matches!(news, Progress::Prompt(_)) && !self.can_answer() {
            self.note(
                "nobody can answer here: resume at the machine's own button, or stop the job with a signal (kill -INT)",
            );
        }
    }

    /// A report of an errand at `now`.
    pub fn look(&mut self, status: &Status, known: &Known, now: Duration) {
        self.now = now;
        self.board.look(status, known);
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
                self.note(&format!("events cannot be written any more: {e}"));
            }
        }
    }

    /// The operator's next wish while the job runs.
    pub fn wish(&mut self) -> Option<Command> {
        loop {
            if self.signalled() {
                // At a terminal without a screen Ctrl-C comes as a signal.
                let by_hand = self.screen.is_none() && self.typed.is_some();
                match self.pressed(by_hand) {
                    Some(command) => return Some(command),
                    None => continue,
                }
            }
            if let Some(screen) = &mut self.screen {
                match screen.key()? {
                    Keyboard::Key(key) => match pressed(&key) {
                        Some(Pressed::Wish(command)) => return Some(command),
                        Some(Pressed::Interrupt) => return self.pressed(true),
                        None => continue,
                    },
                    Keyboard::Gone => {
                        // Nobody is left who could resume.
                        self.screen = None;
                        return Some(Command::Stop);
                    }
                }
            }
            match self.typed.as_ref()?.try_recv() {
                Ok(Ok(command)) => return Some(command),
                Ok(Err(text)) => self.note(&text),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {
                    self.typed = None;
                    if self.pressure == Pressure::Held {
                        // Nobody is left who could resume.
                        return self.pressed(false);
                    }
                }
            }
        }
    }

    /// The next key or line while the machine is in the operator's hands.
    pub fn press(&mut self) -> Option<Press> {
        if self.signalled() {
            return Some(Press::Hand(Hand::Interrupt));
        }
        if let Some(screen) = &mut self.screen {
            return loop {
                match screen.key()? {
                    Keyboard::Key(key) => {
                        if let Some(hand) = hand(&key) {
                            break Some(Press::Hand(hand));
                        }
                    }
                    Keyboard::Gone => {
                        self.screen = None;
                        break Some(Press::Hand(Hand::Stop));
                    }
                }
            };
        }
        loop {
            match self.typed.as_ref()?.try_recv() {
                Ok(Ok(command)) => return Some(Press::Wish(command)),
                Ok(Err(text)) => self.note(&text),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => self.typed = None,
            }
        }
    }

    fn signalled(&mut self) -> bool {
        let more = interrupts() > self.signals;
        self.signals += u32::from(more);
        more
    }

    /// What one Ctrl-C more means.
    fn pressed(&mut self, by_hand: bool) -> Option<Command> {
        let held = self
            .board
            .report
            .as_ref()
            .is_some_and(|r| matches!(r.state, State::Hold { .. } | State::Door(_)));
        let (next, command) = match (self.pressure, by_hand) {
            (Pressure::None, true) if !held => (Pressure::Held, Some(Command::Hold)),
            (Pressure::None, false) => (Pressure::Stopping, Some(Command::Stop)),
            (Pressure::None | Pressure::Held, _) => (Pressure::Last, Some(Command::Stop)),
            (Pressure::Stopping, _) => (Pressure::Last, None),
            (Pressure::Last, _) => (Pressure::Last, Some(Command::ResetNow)),
        };
        self.pressure = next;
        match (next, command) {
            (Pressure::Held, _) => self.note("hold: r resumes, Ctrl-C once more stops the job"),
            (Pressure::Last, Some(Command::Stop) | None) => self.note(
                "stopping in order; Ctrl-C once more resets at once and may lose the position",
            ),
            _ => {}
        }
        command
    }

    /// Draws, or tells a plain line of progress, when it is time to.
    pub fn show(&mut self, now: Duration) {
        self.now = now;
        if let Some(screen) = &mut self.screen {
            if now.saturating_sub(self.drawn) >= DRAW {
                self.drawn = now;
                let (width, rows) = screen.size();
                screen.show(self.board.draw(width, rows));
            }
        } else if std::io::stderr().is_terminal() && now.saturating_sub(self.told) >= PLAIN {
            self.told = now;
            if let Some(line) = self.board.progress().filter(|l| *l != self.last) {
                say(&line);
                self.last = line;
            }
        }
    }

    /// The screen goes, what it told stays.
    pub fn close(&mut self, outcome: &Outcome, now: Duration) {
        self.leave();
        self.write(events::ended(outcome), now);
    }

    /// Gives the terminal back and tells the log.
    pub fn leave(&mut self) {
        if self.screen.take().is_some() {
            for line in self.board.whole_log() {
                say(&line);
            }
        }
    }
}

/// Wishes written as lines to standard input.
fn typed() -> mpsc::Receiver<Result<Command, String>> {
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { return };
            let Some(wish) = wish_of_line(&line).transpose() else {
                continue;
            };
            if sender.send(wish).is_err() {
                return;
            }
        }
    });
    receiver
}
