//! The loop around a stream: greeting, questions, sending, hold, resume, stop, and the end, whatever it is.
//!
//! [`Session`] is a value: bytes, commands and time go in, bytes and news come out, so a test plays hours in milliseconds.
//! [`drive`] turns its crank with a real port and clock.
//!
//! ```text
//! greeting -> asking -> questions -> streaming -> (complete)  done
//!                                       |  `!`       ^X         `?`
//!                                       +-> stopping -> resetting -> last look -> stopped, refused, alarm ...
//! ```
//! A stop is always: feed hold, wait until the report says the machine is at rest, then reset. The reset empties the controller, so
//! nothing that was queued runs, and at rest it costs no position.

mod replies;

use super::job::{Job, JobLine};
use super::command::Command;
use super::outcome::{Ending, Outcome};
use super::progress::Progress;
use super::port::Port;
use super::stream::Stream;
use crate::wire::{BuildOptions, Lines, Realtime, Reply, State};
use std::time::Duration;

/// What a session needs to know beyond the job.
#[derive(Clone, Debug)]
pub struct SessionOptions {
    /// Receive buffer to assume if the controller does not tell its own, bytes.
    pub rx_bytes: usize,
    /// `$` settings the machine file promises: number and value. A difference is noted, nothing more.
    pub settings: Vec<(u16, f64)>,
    /// How far the end position may differ from the program's, mm.
    pub end_tolerance: f64,
    /// Time between status questions (5 Hz at most in normal running).
    pub poll: Duration,
}

impl Default for SessionOptions {
    fn default() -> Self {
        SessionOptions {
            rx_bytes: crate::wire::RX_BYTES,
            settings: Vec::new(),
            end_tolerance: 0.02,
            poll: Duration::from_millis(200),
        }
    }
}

/// How long the greeting may take after opening (a bootloader runs first).
const WELCOME_WAIT: Duration = Duration::from_millis(2500);
/// No byte for this long although a report was asked for: nobody is there.
const SILENCE: Duration = Duration::from_secs(4);
/// The same once a stop is under way: then a blind reset is the lesser evil.
const STOP_SILENCE: Duration = Duration::from_secs(2);
/// Idle with unanswered lines for this long (plus their dwells): a reply was lost.
const LOST_REPLY: Duration = Duration::from_secs(5);
/// GRBL is deaf for half a second after an alarm and may swallow a reset sent then.
const ALARM_DEAF: Duration = Duration::from_millis(700);
/// A reset answers with a greeting within this time, or it is sent once more.
const RESET_WAIT: Duration = Duration::from_millis(1500);
/// Patience for the last position report.
const LAST_LOOK: Duration = Duration::from_secs(3);
/// Questions asked before a job, one at a time.
const QUESTIONS: [&str; 4] = ["$I", "$$", "$#", "$G"];
/// Modes a vetted job takes for granted (what GRBL has after a reset).
const MODES: [&str; 5] = ["G0", "G17", "G21", "G90", "G94"];

#[derive(Clone, Debug, PartialEq)]
enum Phase {
    Greeting,
    Asking,
    Questions(usize),
    Streaming,
    Stopping { quiet_reports: u32 },
    AlarmPause,
    Resetting { again: bool },
    LastLook,
    Ended,
}

/// One job with one controller.
#[derive(Debug)]
pub struct Session {
    options: SessionOptions,
    job: Vec<JobLine>,
    end: [Option<f64>; 3],
    stream: Option<Stream>,
    phase: Phase,
    since: Duration,
    incoming: Lines,
    out: Vec<u8>,
    news: Vec<Progress>,
    ending: Ending,
    total: usize,
    swallow: u32,
    build: BuildOptions,
    version: String,
    settings: Vec<(u16, f64)>,
    modes: String,
    inches: bool,
    state: Option<State>,
    work_offset: Option<[f64; 3]>,
    position: Option<[f64; 3]>,
    position_kept: bool,
    asked: Option<Duration>,
    last_asked: Duration,
    last_heard: Duration,
    last_answer: Duration,
    idle_since: Option<Duration>,
    first_motion: Option<Duration>,
    ended_at: Duration,
    hold_asked: bool,
    pause_told: bool,
    resume_wanted: bool,
    last_hold_sent: Duration,
}

impl Session {
    /// A session that will run `job` on a freshly opened port. Times given to it start at zero here.
    pub fn new(job: Job, options: SessionOptions) -> Session {
        Session {
            total: job.lines.len(),
            end: job.end,
            job: job.lines,
            options,
            stream: None,
            phase: Phase::Greeting,
            since: Duration::ZERO,
            incoming: Lines::default(),
            out: Vec::new(),
            news: Vec::new(),
            ending: Ending::Done,
            swallow: 0,
            build: BuildOptions::default(),
            version: String::new(),
            settings: Vec::new(),
            modes: String::new(),
            inches: false,
            state: None,
            work_offset: None,
            position: None,
            position_kept: true,
            asked: None,
            last_asked: Duration::ZERO,
            last_heard: Duration::ZERO,
            last_answer: Duration::ZERO,
            idle_since: None,
            first_motion: None,
            ended_at: Duration::ZERO,
            hold_asked: false,
            pause_told: false,
            resume_wanted: false,
            last_hold_sent: Duration::ZERO,
        }
    }

    /// Bytes to write now. They always fit what the controller and any kernel buffer can take.
    pub fn output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// News since the last call.
    pub fn news(&mut self) -> Vec<Progress> {
        std::mem::take(&mut self.news)
    }

    /// The result, once there is one.
    pub fn outcome(&self) -> Option<Outcome> {
        (self.phase == Phase::Ended).then(|| Outcome {
            ending: self.ending.clone(),
            sent: self.stream.as_ref().map_or(0, Stream::sent),
            acknowledged: self.stream.as_ref().map_or(0, Stream::acknowledged),
            total: self.total,
            position: self.position,
            position_kept: self.position_kept,
            running_s: self
                .first_motion
                .map_or(0.0, |t| self.ended_at.saturating_sub(t).as_secs_f64()),
        })
    }

    /// Bytes in unanswered lines: never more than the controller's receive buffer.
    pub fn in_flight(&self) -> usize {
        self.stream.as_ref().map_or(0, Stream::in_flight)
    }

    /// Takes in what arrived at time `now`.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for line in self.incoming.feed(bytes) {
            self.last_heard = now;
            self.reply(&Reply::parse(&line), now);
        }
    }

    /// The operator's wish at time `now`.
    pub fn command(&mut self, command: Command, now: Duration) {
        match (command, &self.phase) {
            (Command::ResetNow, Phase::Ended) => {}
            (Command::ResetNow, _) => {
                self.note("reset at once: if the machine was moving, its position is lost");
                if let Some(stream) = &mut self.stream {
                    stream.interrupt();
                }
                if self.ending == Ending::Done {
                    self.ending = Ending::Stopped;
                }
                if !self.state.as_ref().is_some_and(State::at_rest) {
                    self.moved_under_reset();
                }
                self.reset(now);
            }
            (Command::Stop, Phase::Streaming) => self.stop(Ending::Stopped, "stop wanted", now),
            (Command::Stop, Phase::Greeting | Phase::Asking | Phase::Questions(_)) => {
                self.ending = Ending::Stopped;
                self.enter(Phase::Ended, now);
            }
            (Command::Hold, Phase::Streaming) => {
                self.hold_asked = true;
                self.resume_wanted = false;
                self.realtime(Realtime::Hold);
            }
            (Command::Resume, Phase::Streaming) => {
                self.resume_wanted = true;
                self.resume_if_at_rest();
            }
            _ => {}
        }
    }

    /// The port broke: the session ends here, whatever it was doing.
    pub fn broken(&mut self, why: String, now: Duration) {
        if self.phase != Phase::Ended {
            if self.ending == Ending::Done {
                self.ending = Ending::Broken(why);
            } else {
                self.note(&why);
            }
            self.position_kept = false;
            self.enter(Phase::Ended, now);
        }
    }

    /// Lets time pass: sends what may be sent, asks for reports, and notices who keeps silent.
    pub fn tick(&mut self, now: Duration) {
        match self.phase {
            Phase::Ended => return,
            Phase::Greeting => {
                if now - self.since > WELCOME_WAIT {
                    // No greeting: the controller may not have been reset by opening. An empty line ends whatever half line is
                    // in its buffer; its `ok` is not an answer to us.
                    self.out.push(b'\n');
                    self.swallow = 1;
                    self.enter(Phase::Asking, now);
                }
                return;
            }
            Phase::Asking | Phase::Questions(_) => {
                if now - self.last_heard.max(self.since) > SILENCE {
                    let waiting_for = if self.phase == Phase::Asking {
                        "its status"
                    } else {
                        "its settings"
                    };
                    self.ending = Ending::Silent { waiting_for };
                    return self.enter(Phase::Ended, now);
                }
                // Reports and the answers to questions do not disturb each other, but a quiet line is easier to read in a log.
                if self.phase != Phase::Asking {
                    return;
                }
            }
            Phase::Streaming => {
                self.send_lines();
                if now - self.last_heard > SILENCE {
                    self.stop(
                        Ending::Silent {
                            waiting_for: "a status report",
                        },
                        "the controller no longer answers",
                        now,
                    );
                } else {
                    self.notice_a_lost_reply(now);
                }
            }
            Phase::Stopping { .. } => {
                if now - self.last_heard.max(self.since) > STOP_SILENCE {
                    self.note("no report that the machine is at rest: reset anyway, the position is not certain");
                    self.position_kept = false;
                    return self.reset(now);
                }
            }
            Phase::AlarmPause => {
                if now - self.since > ALARM_DEAF {
                    self.reset(now);
                }
                return;
            }
            Phase::Resetting { again } => {
                if now - self.since > RESET_WAIT {
                    if again {
                        self.note("no greeting after the reset: switch the controller off before touching the machine");
                        self.position_kept = false;
                        self.enter(Phase::Ended, now);
                    } else {
                        self.realtime(Realtime::Reset);
                        self.enter(Phase::Resetting { again: true }, now);
                    }
                }
                return;
            }
            Phase::LastLook => {
                if now - self.since > LAST_LOOK {
                    return self.enter(Phase::Ended, now);
                }
            }
        }
        self.ask_for_a_report(now);
    }

    fn ask_for_a_report(&mut self, now: Duration) {
        // While stopping we want to know soon; 10 Hz is what the firmware takes without harm.
        let pause = match self.phase {
            Phase::Streaming => self.options.poll,
            _ => self.options.poll / 2,
        };
        let overdue = self.asked.is_some_and(|t| now - t > Duration::from_secs(1));
        if overdue || (self.asked.is_none() && now.saturating_sub(self.last_asked) >= pause) {
            self.realtime(Realtime::Status);
            self.asked = Some(now);
            self.last_asked = now;
        }
    }

    fn notice_a_lost_reply(&mut self, now: Duration) {
        let (Some(idle), Some(stream)) = (self.idle_since, &self.stream) else {
            return;
        };
        let Some(oldest) = stream.unanswered().first() else {
            return;
        };
        let dwell: f64 = stream.unanswered().iter().map(|l| l.dwell).sum();
        let patience = LOST_REPLY + Duration::try_from_secs_f64(dwell).unwrap_or(Duration::MAX / 4);
        if now - idle.max(self.last_answer) > patience {
            let line = oldest.source;
            self.stop(Ending::LostReply { line }, "a reply was lost", now);
        }
    }

    fn send_lines(&mut self) {
        if let Some(stream) = &mut self.stream {
            while let Some(line) = stream.sendable() {
                self.out.extend_from_slice(line);
            }
        }
    }

    fn stop(&mut self, ending: Ending, why: &str, now: Duration) {
        if let Some(stream) = &mut self.stream {
            stream.interrupt();
        }
        self.ending = ending;
        self.news.push(Progress::Stopping(why.to_string()));
        self.realtime(Realtime::Hold);
        self.last_hold_sent = now;
        // A question under way may have been answered before the hold; ask afresh.
        self.asked = None;
        self.last_asked = now;
        self.enter(Phase::Stopping { quiet_reports: 0 }, now);
    }

    fn reset(&mut self, now: Duration) {
        self.realtime(Realtime::Reset);
        self.enter(Phase::Resetting { again: false }, now);
    }

    fn last_look(&mut self, now: Duration) {
        self.position = None;
        self.asked = None;
        self.enter(Phase::LastLook, now);
    }

    /// The reset met the machine in motion: whoever wanted it, the position is lost.
    fn moved_under_reset(&mut self) {
        self.position_kept = false;
        if self.ending == Ending::Stopped {
            self.ending = Ending::Aborted;
        }
    }

    fn realtime(&mut self, command: Realtime) {
        self.out.push(command.byte());
    }

    fn note(&mut self, text: &str) {
        self.news.push(Progress::Note(text.to_string()));
    }

    fn enter(&mut self, phase: Phase, now: Duration) {
        if phase == Phase::Ended {
            self.ended_at = now;
        }
        self.phase = phase;
        self.since = now;
    }
}

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
        if !out.is_empty()
            && let Err(e) = port.write(&out)
        {
            session.broken(e.to_string(), now);
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
