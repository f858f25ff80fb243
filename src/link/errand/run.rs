//! The errand itself: introduction, the task's steps one at a time, and the watch kept meanwhile.

use super::error::ErrandError;
use super::exchange::{Exchange, Heard, News, Rule, Situation, Step, Task};
use crate::link::introduction::{Introduction, IntroductionOptions, Known, Unknown, WhenSilent};
use crate::wire::{Lines, RX_BYTES, Realtime, Reply, Status};
use std::time::Duration;

/// Quiet before and after a line that writes the EEPROM.
const WRITER_QUIET: Duration = Duration::from_millis(50);
/// Reports in a row that must say Idle.
pub(super) const IDLE_REPORTS: u32 = 2;

/// What an errand needs to know beyond its task.
#[derive(Clone, Copy, Debug)]
pub struct ErrandOptions {
    /// Receive buffer to assume if the controller does not tell its own, bytes.
    pub rx_bytes: usize,
    /// Time between status questions.
    pub poll: Duration,
}

impl Default for ErrandOptions {
    fn default() -> Self {
        ErrandOptions {
            rx_bytes: RX_BYTES,
            poll: Duration::from_millis(200),
        }
    }
}

/// What the lines sent so far may have set in motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moving {
    Nothing,
    Jog,
    Program,
    Homing,
}

#[derive(Debug)]
pub(super) enum Phase {
    Meeting(Box<Introduction>),
    /// The task is asked at the next opportunity.
    Deciding,
    /// Nothing to do: the task is asked whenever something arrived.
    Listening,
    /// Quiet before a line that writes.
    Before(Exchange),
    Waiting(Exchange),
    /// Quiet after it.
    After,
    Settling {
        idle: u32,
    },
    JogStop {
        idle: u32,
    },
    Stopping {
        quiet: u32,
    },
    AlarmPause {
        code: u16,
    },
    Resetting {
        again: bool,
    },
    LastLook,
    Ended,
}

/// A task with one controller. Feed it bytes and time, send its output, until [`Errand::result`].
#[derive(Debug)]
pub struct Errand<T> {
    /// The task, with what it found.
    pub task: T,
    pub(super) options: ErrandOptions,
    pub(super) phase: Phase,
    pub(super) since: Duration,
    pub(super) known: Known,
    pub(super) status: Option<Status>,
    pub(super) heard: Heard,
    /// The line sent last has not been answered.
    pub(super) unanswered: bool,
    pub(super) moving: Moving,
    pub(super) ending: Option<ErrandError>,
    pub(super) out: Vec<u8>,
    pub(super) news: Vec<News>,
    pub(super) asked: Option<Duration>,
    pub(super) last_asked: Duration,
    pub(super) last_heard: Duration,
    pub(super) idle_since: Option<Duration>,
    pub(super) last_hold: Duration,
    /// Reports that said Jog at the same place, while a jog is cancelled.
    pub(super) standing: u32,
    pub(super) stood_at: Option<[f64; 3]>,
    incoming: Lines,
    pub(super) hold_told: bool,
}

impl<T: Task> Errand<T> {
    /// On a freshly opened port at time `now`.
    pub fn new(task: T, options: ErrandOptions, now: Duration) -> Errand<T> {
        let introduction = Introduction::new(Self::questions(&task, options), now);
        Errand::with(task, options, introduction, now)
    }

    /// On a port that is open already, whose controller need not greet.
    pub fn again(task: T, options: ErrandOptions, now: Duration) -> Errand<T> {
        let introduction = Introduction::again(Self::questions(&task, options), now);
        Errand::with(task, options, introduction, now)
    }

    /// With a controller that is known already, on its open port: no question is asked first. For errands one after the other.
    pub fn knowing(task: T, options: ErrandOptions, known: Known, now: Duration) -> Errand<T> {
        let introduction = Introduction::again(Self::questions(&task, options), now);
        let mut errand = Errand::with(task, options, introduction, now);
        (errand.known, errand.phase) = (known, Phase::Deciding);
        errand
    }

    fn questions(task: &T, options: ErrandOptions) -> IntroductionOptions {
        IntroductionOptions {
            rx_bytes: options.rx_bytes,
            when_silent: if task.may_reset_the_mute() {
                WhenSilent::ResetOnce
            } else {
                WhenSilent::GiveUp
            },
        }
    }

    fn with(
        task: T,
        options: ErrandOptions,
        introduction: Introduction,
        now: Duration,
    ) -> Errand<T> {
        Errand {
            task,
            options,
            known: introduction.known().clone(),
            phase: Phase::Meeting(Box::new(introduction)),
            since: now,
            status: None,
            heard: Heard::default(),
            unanswered: false,
            moving: Moving::Nothing,
            ending: None,
            out: Vec::new(),
            news: Vec::new(),
            asked: None,
            last_asked: now,
            last_heard: now,
            idle_since: None,
            last_hold: now,
            standing: 0,
            stood_at: None,
            incoming: Lines::default(),
            hold_told: false,
        }
    }

    /// Bytes to send now.
    pub fn output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// News since the last call.
    pub fn news(&mut self) -> Vec<News> {
        std::mem::take(&mut self.news)
    }

    /// The result once it has ended; what was found is in the task.
    pub fn result(&self) -> Option<Result<(), ErrandError>> {
        match self.phase {
            Phase::Ended => Some(self.ending.clone().map_or(Ok(()), Err)),
            _ => None,
        }
    }

    /// The controller as last reported.
    pub fn known(&self) -> &Known {
        &self.known
    }

    /// Motion may be under way because of a line of this errand.
    pub fn may_be_moving(&self) -> bool {
        self.moving != Moving::Nothing
    }

    /// A real-time byte of the operator's own, sent at once, also while a line waits for its answer.
    pub fn key(&mut self, byte: u8) {
        let listens = matches!(
            self.phase,
            Phase::Deciding | Phase::Listening | Phase::Waiting(_) | Phase::Settling { .. }
        );
        // Never into a write: the byte would be lost, or worse.
        let writes = matches!(&self.phase, Phase::Waiting(e) if e.rule == Rule::Writer);
        if listens && !writes {
            self.out.push(byte);
        }
    }

    /// Takes in what arrived at time `now`.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for line in self.incoming.feed(bytes) {
            self.last_heard = now;
            let reply = Reply::parse(&line);
            self.reply(&line, &reply, now);
        }
    }

    /// Lets time pass.
    pub fn tick(&mut self, now: Duration) {
        match &mut self.phase {
            Phase::Ended => return,
            Phase::Meeting(introduction) => {
                introduction.tick(now);
                self.out.extend(introduction.output());
                return self.met(now);
            }
            Phase::Deciding | Phase::Listening => {
                if !self.task.carries_on() {
                    self.watch_the_link(now);
                }
                self.decide(now);
            }
            Phase::Before(exchange) => {
                if now.saturating_sub(self.since) >= WRITER_QUIET {
                    let exchange = exchange.clone();
                    self.send(exchange, now);
                }
            }
            Phase::After => {
                if now.saturating_sub(self.since) >= WRITER_QUIET {
                    self.enter(Phase::Deciding, now);
                    self.decide(now);
                }
            }
            Phase::Waiting(exchange) => {
                let exchange = exchange.clone();
                self.watch_the_answer(&exchange, now);
            }
            Phase::Settling { .. } => self.watch_the_link(now),
            Phase::JogStop { .. }
            | Phase::Stopping { .. }
            | Phase::AlarmPause { .. }
            | Phase::Resetting { .. }
            | Phase::LastLook => self.stopping_tick(now),
        }
        self.ask_for_a_report(now);
    }

    pub(super) fn met(&mut self, now: Duration) {
        let Phase::Meeting(introduction) = &self.phase else {
            return;
        };
        match introduction.result() {
            None => {}
            Some(Err(why)) => {
                let reachable = matches!(
                    why,
                    Unknown::Busy(_) | Unknown::Silent { alarm: Some(_), .. }
                );
                let (known, why) = (introduction.known().clone(), why.clone());
                if self.task.carries_on() && reachable {
                    self.known = known;
                    self.news.push(News::Note(why.to_string()));
                    self.enter(Phase::Listening, now);
                } else {
                    self.end(Some(ErrandError::Unknown(why)), now);
                }
            }
            Some(Ok(known)) => {
                self.known = known.clone();
                self.news
                    .push(News::Connected(Box::new(self.known.clone())));
                self.enter(Phase::Deciding, now);
            }
        }
    }

    /// Asks the task until there is something to wait for.
    pub(super) fn decide(&mut self, now: Duration) {
        if !matches!(self.phase, Phase::Deciding | Phase::Listening) {
            return;
        }
        if let Some(error) = self.ending.take() {
            return self.end(Some(error), now);
        }
        let mut notes = Vec::new();
        let step = self.task.next(&mut Situation {
            known: &self.known,
            status: self.status.as_ref(),
            heard: &self.heard,
            notes: &mut notes,
        });
        self.news.extend(notes.into_iter().map(News::Note));
        match step {
            Err(error) => self.fail(error, now),
            Ok(Step::Done) => self.end(None, now),
            Ok(Step::Listen) => {
                if !matches!(self.phase, Phase::Listening) {
                    self.enter(Phase::Listening, now);
                }
            }
            Ok(Step::Byte(byte)) => {
                self.out.push(byte);
                self.enter(Phase::Deciding, now);
            }
            Ok(Step::Settle) => {
                self.asked = None;
                self.enter(Phase::Settling { idle: 0 }, now);
            }
            Ok(Step::Send(exchange)) if exchange.rule == Rule::Writer => {
                self.enter(Phase::Before(exchange), now);
            }
            Ok(Step::Send(exchange)) => self.send(exchange, now),
        }
    }

    fn send(&mut self, exchange: Exchange, now: Duration) {
        self.moving = match (exchange.rule, self.moving) {
            (Rule::Motion, _) => Moving::Program,
            (Rule::Jog, Moving::Nothing) => Moving::Jog,
            (Rule::Silent(_), _) => Moving::Homing,
            (_, other) => other,
        };
        if matches!(exchange.rule, Rule::Motion | Rule::Jog) {
            // What it said before is no word about this motion.
            self.status = None;
        }
        self.heard = Heard::of(&exchange.text);
        self.unanswered = true;
        self.idle_since = None;
        self.out.extend_from_slice(exchange.text.as_bytes());
        self.out.push(b'\n');
        self.news.push(News::Sent(exchange.text.clone()));
        self.enter(Phase::Waiting(exchange), now);
    }

    pub(super) fn end(&mut self, error: Option<ErrandError>, now: Duration) {
        self.ending = error;
        self.enter(Phase::Ended, now);
    }

    pub(super) fn enter(&mut self, phase: Phase, now: Duration) {
        self.phase = phase;
        self.since = now;
    }

    pub(super) fn realtime(&mut self, command: Realtime) {
        self.out.push(command.byte());
    }
}
