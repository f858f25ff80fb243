//! The conversation before anything else: greeting, `?`, `$I`, `$$`, `$#`, `$G`, one at a time, and a last `?`.
//!
//! Crosses the border: replies in [`crate::wire`]'s words and time in; bytes to send and, at the end, what is [`Known`] of the
//! controller out, in mm and machine coordinates. A value without I/O or clock. It never resets a controller unasked (that would
//! kill a job somebody else runs) and never asks for settings in a state where nobody would answer.

mod known;

pub use known::{Known, Offsets};

use crate::wire::{Firmware, RX_BYTES, Realtime, Reply, State, alarm_meaning};
use std::time::Duration;

/// How long the greeting may take after opening (a bootloader runs first).
const WELCOME_WAIT: Duration = Duration::from_millis(2500);
/// No byte for this long although something was asked: nobody is there.
const SILENCE: Duration = Duration::from_secs(4);
/// Time between two `?` while waiting for a report.
const ASK_AGAIN: Duration = Duration::from_millis(250);
/// Reports waited for that name a position.
const LAST_REPORTS: u32 = 8;
/// Questions, in order, one at a time.
const QUESTIONS: [&str; 4] = ["$I", "$$", "$#", "$G"];
/// A receive buffer smaller than a line, or larger than any firmware has, is a damaged figure.
const RX_SANE: std::ops::RangeInclusive<usize> = 80..=65_536;
/// Settings kept: no firmware has as many.
const MOST_SETTINGS: usize = 2000;

/// What to do when nobody answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhenSilent {
    /// End with [`Unknown::Silent`].
    GiveUp,
    /// Send one reset and listen again: a controller in ALARM:1 or 2 answers to nothing else. Only when the operator wants it.
    ResetOnce,
}

/// What an introduction needs to know.
#[derive(Clone, Copy, Debug)]
pub struct IntroductionOptions {
    /// Receive buffer to assume if the controller does not tell its own, bytes.
    pub rx_bytes: usize,
    /// What to do when nobody answers.
    pub when_silent: WhenSilent,
}

impl Default for IntroductionOptions {
    fn default() -> Self {
        IntroductionOptions {
            rx_bytes: RX_BYTES,
            when_silent: WhenSilent::GiveUp,
        }
    }
}

/// Why the controller is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unknown {
    /// No answer.
    #[error("{}", silent(waiting_for, *alarm))]
    Silent {
        /// What was waited for.
        waiting_for: &'static str,
        /// The last thing it said was this alarm (GRBL 1.1's number: nobody could ask which firmware it is).
        alarm: Option<u16>,
    },
    /// It is in a state in which questions are not answered.
    #[error("{}", busy(.0))]
    Busy(State),
}

fn silent(waiting_for: &str, alarm: Option<u16>) -> String {
    match alarm {
        Some(code) => format!(
            "the controller says ALARM:{code} and then nothing: {}. It listens to nothing but a reset now",
            alarm_meaning(code).map_or("look the number up in the firmware's documentation", |m| m
                .what)
        ),
        None => format!(
            "no answer from the controller while waiting for {waiting_for}: check cable, power, port and serial speed"
        ),
    }
}

fn busy(state: &State) -> String {
    match state {
        State::Check => {
            "the controller is in check mode, where nothing moves: send $C to leave it".to_string()
        }
        State::Sleep => "the controller is asleep: reset it".to_string(),
        State::Hold { .. } | State::Door(_) => format!(
            "the controller is not idle but says {}: let it go on with ~, or end what it was doing with reset, both in `morsemill console`",
            state.text()
        ),
        // grblHAL's own tool change: lines are taken, jogs and probes too, until it is acknowledged.
        State::Other(text) if text == "Tool" => {
            "the controller is not idle but says Tool, a tool change of its own: finish it and go on with ~ in `morsemill console`, or reset it. \
             `send` makes tool changes itself and never sends M6"
                .to_string()
        }
        other => format!(
            "the controller is not idle but says {}: wait until it is, or reset it",
            other.text()
        ),
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Phase {
    Greeting,
    Asking,
    Questions(usize),
    LastReport { heard: u32 },
    Ended(Result<(), Unknown>),
}

/// The conversation. Feed it replies and time, send its output, until [`Introduction::result`].
#[derive(Clone, Debug)]
pub struct Introduction {
    options: IntroductionOptions,
    known: Known,
    phase: Phase,
    since: Duration,
    last_heard: Duration,
    asked: Option<Duration>,
    swallow: u32,
    out: Vec<u8>,
}

impl Introduction {
    /// On a freshly opened port at time `now`.
    pub fn new(options: IntroductionOptions, now: Duration) -> Introduction {
        Introduction {
            known: Known::new(options.rx_bytes),
            options,
            phase: Phase::Greeting,
            since: now,
            last_heard: now,
            asked: None,
            swallow: 0,
            out: Vec::new(),
        }
    }

    /// On a port that is open already, whose controller need not greet: begins with `?`.
    pub fn again(options: IntroductionOptions, now: Duration) -> Introduction {
        Introduction {
            phase: Phase::Asking,
            ..Introduction::new(options, now)
        }
    }

    /// Bytes to send now.
    pub fn output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// What is known, or why not, once it has ended.
    pub fn result(&self) -> Option<Result<&Known, &Unknown>> {
        match &self.phase {
            Phase::Ended(Ok(())) => Some(Ok(&self.known)),
            Phase::Ended(Err(why)) => Some(Err(why)),
            _ => None,
        }
    }

    /// What is known so far.
    pub fn known(&self) -> &Known {
        &self.known
    }

    /// Lets time pass.
    pub fn tick(&mut self, now: Duration) {
        match self.phase {
            Phase::Ended(_) => return,
            Phase::Greeting => {
                if now.saturating_sub(self.since) > WELCOME_WAIT {
                    // No greeting: the controller may not have been reset by opening, and half a line of a sender that was killed
                    // may be in its buffer. A line end alone would have it run, cut short (`X1` of `X12.5`). With a `$` no half
                    // line is legal; alone it asks for help, and its `ok` is not an answer to us.
                    self.out.extend_from_slice(b"$\n");
                    self.swallow = 1;
                    self.enter(Phase::Asking, now);
                }
                return;
            }
            _ => {}
        }
        if now.saturating_sub(self.last_heard.max(self.since)) > SILENCE {
            return self.silence(now);
        }
        if matches!(self.phase, Phase::Asking | Phase::LastReport { .. }) {
            let due = self
                .asked
                .is_none_or(|t| now.saturating_sub(t) >= ASK_AGAIN);
            if due {
                self.out.push(Realtime::Status.byte());
                self.asked = Some(now);
            }
        }
    }

    /// Takes in a reply at time `now`.
    pub fn receive(&mut self, reply: &Reply, now: Duration) {
        self.last_heard = now;
        if matches!(self.phase, Phase::Questions(_))
            && !matches!(reply, Reply::Status(_))
            && let Some(asked) = self.asked.take()
        {
            let took = now.saturating_sub(asked);
            self.known.round_trip = self.known.round_trip.max(took);
        }
        if matches!(self.phase, Phase::Ended(_)) {
            return;
        }
        if let Some(firmware) = Firmware::told_by(reply) {
            // grblHAL may greet as plain GRBL and say more in `$I`; never the other way.
            let refined = matches!(self.known.firmware, Firmware::GrblHal | Firmware::FluidNc);
            let vague = matches!(firmware, Firmware::Grbl11 | Firmware::Unknown);
            if !(refined && vague) {
                self.known.firmware = firmware;
            }
        }
        if let Reply::Alarm(code) = reply {
            self.known.alarm = Some(*code);
        }
        if let Reply::Status(status) = reply {
            self.known.hear(status);
        }
        if reply.answers_a_line() && self.swallow > 0 {
            self.swallow -= 1;
            return;
        }
        if let Reply::Welcome {
            firmware, version, ..
        } = reply
        {
            // Also a late one: the controller was reset by opening the port after all, and its answers so far are void.
            let (alarm, kind) = (self.known.alarm, self.known.firmware);
            self.known = Known::new(self.options.rx_bytes);
            (self.known.alarm, self.known.firmware) = (alarm, kind);
            self.known.version = format!("{firmware} {version}");
            self.swallow = 0;
            return self.enter(Phase::Asking, now);
        }
        match self.phase.clone() {
            Phase::Asking => {
                if let Reply::Status(status) = reply {
                    match status.state {
                        State::Idle | State::Alarm => self.question(0, now),
                        ref other => {
                            let busy = Unknown::Busy(other.clone());
                            self.enter(Phase::Ended(Err(busy)), now);
                        }
                    }
                }
            }
            Phase::Questions(index) => self.hear_answer(index, reply, now),
            Phase::LastReport { heard } => {
                if let Reply::Status(_) = reply {
                    self.complete(heard + 1, now);
                }
            }
            Phase::Greeting | Phase::Ended(_) => {}
        }
    }

    fn hear_answer(&mut self, index: usize, reply: &Reply, now: Duration) {
        let unit = if self.known.inches { 25.4 } else { 1.0 };
        let mm = |v: &[f64; 3]| v.map(|c| c * unit);
        let known = &mut self.known;
        match reply {
            Reply::Options(build) => {
                known.letters.clone_from(&build.letters);
                known.blocks = build.blocks;
                if let Some(rx) = build.rx.filter(|rx| RX_SANE.contains(rx)) {
                    known.rx_bytes = rx;
                }
            }
            Reply::Version(version) => known.version.clone_from(version),
            Reply::Modes(modes) => known.modes = modes.clone(),
            Reply::Setting { number, value } => {
                if let Ok(value) = value.trim().parse::<f64>()
                    && value.is_finite()
                    && known.settings.len() < MOST_SETTINGS
                {
                    known.settings.push((*number, value));
                    known.inches |= *number == 13 && value != 0.0;
                }
            }
            Reply::Offset { name, values } => {
                let place = Some(mm(values));
                match name.as_str() {
                    "G28" => known.offsets.g28 = place,
                    "G30" => known.offsets.g30 = place,
                    "G92" => known.offsets.g92 = place,
                    other => {
                        let number: Option<usize> =
                            other.strip_prefix('G').and_then(|n| n.parse().ok());
                        let index = number.and_then(|n| n.checked_sub(54));
                        if let Some(slot) = index.and_then(|i| known.offsets.g5x.get_mut(i)) {
                            *slot = place;
                        }
                    }
                }
            }
            Reply::ToolLength(z) => known.offsets.tlo = Some(z * unit),
            Reply::Probed { at, touched } => known.offsets.probe = Some((mm(at), *touched)),
            Reply::Ok => self.question(index + 1, now),
            Reply::Error(code) => {
                if let Some(question) = QUESTIONS.get(index) {
                    known.refused.push((question, *code));
                }
                self.question(index + 1, now);
            }
            _ => {}
        }
    }

    fn question(&mut self, index: usize, now: Duration) {
        match QUESTIONS.get(index) {
            Some(text) => {
                self.out.extend_from_slice(text.as_bytes());
                self.out.push(b'\n');
                self.enter(Phase::Questions(index), now);
                self.asked = Some(now);
            }
            None => {
                // The reports so far were read before `$13` was known: begin afresh.
                (self.known.machine_position, self.known.work_offset) =
                    (None, self.offset_by_answers());
                self.enter(Phase::LastReport { heard: 0 }, now);
            }
        }
    }

    /// Work offset as `$#` and `$G` make it: reports name it only now and then.
    fn offset_by_answers(&self) -> Option<[f64; 3]> {
        let o = &self.known.offsets;
        let active = o
            .g5x
            .get(self.known.modes.work_offset()?)
            .copied()
            .flatten()?;
        let (g92, tlo) = (o.g92?, o.tlo?);
        Some([
            active[0] + g92[0],
            active[1] + g92[1],
            active[2] + g92[2] + tlo,
        ])
    }

    fn complete(&mut self, heard: u32, now: Duration) {
        let placed = self.known.machine_position.is_some() && self.known.work_offset.is_some();
        if placed || heard >= LAST_REPORTS {
            let locked = self.known.state == State::Alarm
                && self.known.setting(22).is_some_and(|v| v != 0.0);
            if self.known.homed.is_none() && locked {
                self.known.homed = Some(false);
            }
            self.enter(Phase::Ended(Ok(())), now);
        } else {
            self.phase = Phase::LastReport { heard };
        }
    }

    fn silence(&mut self, now: Duration) {
        let alarm = self.known.alarm;
        if self.options.when_silent == WhenSilent::ResetOnce {
            self.options.when_silent = WhenSilent::GiveUp;
            self.out.push(Realtime::Reset.byte());
            self.known.alarm = None;
            return self.enter(Phase::Greeting, now);
        }
        let waiting_for = match self.phase {
            Phase::Questions(_) => "its settings",
            _ => "its status",
        };
        self.enter(
            Phase::Ended(Err(Unknown::Silent { waiting_for, alarm })),
            now,
        );
    }

    fn enter(&mut self, phase: Phase, now: Duration) {
        self.phase = phase;
        self.since = now;
        self.asked = None;
    }
}

#[cfg(test)]
mod tests;
