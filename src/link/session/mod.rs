//! The loop around a stream: introduction, sending, hold, resume, overrides, stop, and the end, whatever it is.
//!
//! [`Session`] is a value: bytes, commands and time go in, bytes and news come out, so a test plays hours in milliseconds.
//! [`super::drive()`] turns its crank with a real port and clock.
//!
//! ```text
//! introducing -> streaming -> (all answered, Idle twice)  done
//!                    |   `!`         ^X         `?`
//!                    +-> stopping -> resetting -> last look -> stopped, refused, alarm ...
//! ```
//! A stop is always: feed hold, wait until the report says the machine is at rest, then reset. The reset empties the controller, so
//! nothing that was queued runs, and at rest it costs no position. Once it has stopped a session never sends a line again.

mod operator;
mod replies;
mod sending;
mod stall;
mod stopping;
mod ticking;
mod watching;

use super::introduction::{Introduction, IntroductionOptions, Known};
use super::job::{Job, JobLines};
use super::outcome::{Ending, Outcome};
use super::progress::{Progress, Prompt, Stall};
use super::stream::Stream;
use super::watch::Watch;
use crate::wire::{Lines, Overrides, Realtime, Reply, State};
use operator::{Adjusting, Resume};
use std::collections::VecDeque;
use std::time::Duration;
use watching::{Look, Upcoming};

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
    /// How long the spindle gets to come up to speed when a resume starts it again.
    pub spin_up: Duration,
}

impl Default for SessionOptions {
    fn default() -> Self {
        SessionOptions {
            rx_bytes: crate::wire::RX_BYTES,
            settings: Vec::new(),
            end_tolerance: 0.02,
            poll: Duration::from_millis(200),
            spin_up: Duration::from_secs(4),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Phase {
    Introducing,
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
    job: Job,
    phase: Phase,
    since: Duration,
    introduction: Introduction,
    known: Known,

    // Sending.
    stream: Stream,
    lines: Option<JobLines>,
    /// Lines of our own that go before the job's next.
    own: VecDeque<Upcoming>,
    /// The job's next line.
    next: Option<Upcoming>,
    /// Index of the job's next line.
    index: usize,
    /// The job's lines, and then the closing one, are all under way.
    closing: Closing,
    allowed: usize,
    sent: usize,
    acknowledged: usize,
    /// Line of the program answered last.
    last_source: usize,
    /// Nothing may be sent before then: the controller is writing its memory.
    quiet_until: Duration,
    /// The tool change whose line was answered: nothing is sent until the operator resumes.
    waiting: Option<Prompt>,
    prompt_told: bool,

    // The cable.
    incoming: Lines,
    urgent: VecDeque<u8>,
    news: Vec<Progress>,
    asked: Option<Duration>,
    last_asked: Duration,
    last_report: Duration,
    last_heard: Duration,
    last_tick: Duration,
    last_answer: Duration,
    wall: Option<(Duration, Duration)>,

    // The machine.
    /// The way of the lines under way; `None` where nobody can tell.
    watch: Option<Watch>,
    /// Reports in a row that lie off the way.
    off_reports: u32,
    look: Look,
    /// Work systems (bit 0: G54) whose zeros are as the program is read.
    zeros_known: u16,
    idle_since: Option<Duration>,
    moved: Duration,
    first_motion: Option<Duration>,
    overrides: Option<Overrides>,
    accessories: String,
    stall: Option<Stall>,

    // The operator.
    hold_asked: bool,
    pause_told: bool,
    resume: Option<Resume>,
    spindle_stopped: bool,
    adjustments: VecDeque<Realtime>,
    adjusting: Option<Adjusting>,

    // The end.
    ending: Ending,
    position_kept: bool,
    last_hold_sent: Duration,
    ended_at: Duration,
    /// Oldest and newest line of the program that may have been carried out without an answer.
    maybe: Option<(usize, usize)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Closing {
    NotYet,
    Due,
    Sent,
}

impl Session {
    /// A session that will run `job` on a freshly opened port. Times given to it start at zero here.
    pub fn new(job: Job, options: SessionOptions) -> Session {
        let introduction = Introduction::new(
            IntroductionOptions {
                rx_bytes: options.rx_bytes,
                ..IntroductionOptions::default()
            },
            Duration::ZERO,
        );
        Session::fresh(job, introduction, options, Duration::ZERO)
    }

    /// A session with a controller that has just introduced itself on this port, as [`super::introduce`] gives it.
    pub fn known(job: Job, known: Known, options: SessionOptions, now: Duration) -> Session {
        let introduction = Introduction::new(IntroductionOptions::default(), now);
        let mut session = Session::fresh(job, introduction, options, now);
        session.known = known;
        session.begin(now);
        session
    }

    fn fresh(
        job: Job,
        introduction: Introduction,
        options: SessionOptions,
        now: Duration,
    ) -> Session {
        Session {
            known: introduction.known().clone(),
            introduction,
            phase: Phase::Introducing,
            since: now,
            stream: Stream::new(options.rx_bytes),
            lines: None,
            own: VecDeque::new(),
            next: None,
            index: 0,
            closing: Closing::NotYet,
            allowed: usize::MAX,
            sent: 0,
            acknowledged: 0,
            last_source: 0,
            quiet_until: Duration::ZERO,
            waiting: None,
            prompt_told: false,
            incoming: Lines::default(),
            urgent: VecDeque::new(),
            news: Vec::new(),
            asked: None,
            last_asked: now,
            last_report: now,
            last_heard: now,
            last_tick: now,
            last_answer: now,
            wall: None,
            watch: None,
            off_reports: 0,
            look: Look::No,
            zeros_known: u16::MAX,
            idle_since: None,
            moved: now,
            first_motion: None,
            overrides: None,
            accessories: String::new(),
            stall: None,
            hold_asked: false,
            pause_told: false,
            resume: None,
            spindle_stopped: false,
            adjustments: VecDeque::new(),
            adjusting: None,
            ending: Ending::Done,
            position_kept: true,
            last_hold_sent: now,
            ended_at: now,
            maybe: None,
            job,
            options,
        }
    }

    /// Bytes to write now, real-time bytes first. They always fit what the controller and any kernel buffer can take. They stay until
    /// [`Session::written`] says how many really went out; nothing else may be called in between.
    pub fn output(&self) -> Vec<u8> {
        self.urgent
            .iter()
            .copied()
            .chain(self.stream.output())
            .collect()
    }

    /// The first `count` bytes of [`Session::output`] were written.
    pub fn written(&mut self, count: usize) {
        let urgent = count.min(self.urgent.len());
        self.urgent.drain(..urgent);
        self.begun(count - urgent);
    }

    /// News since the last call.
    pub fn news(&mut self) -> Vec<Progress> {
        std::mem::take(&mut self.news)
    }

    /// Lines of the job with an index below `lines` may be sent from here on: a journal first writes on disk that they may be. Without
    /// a call, all may.
    pub fn allow_up_to(&mut self, lines: usize) {
        self.allowed = lines;
    }

    /// Index of the job's next line to be sent: what a journal has to allow next.
    pub fn next_index(&self) -> usize {
        self.index
    }

    /// The tool change at which the session waits: the controller is Idle and everything is answered, so that the operator may jog,
    /// probe and set zeros on the same port until [`super::Command::Resume`].
    pub fn tool_change(&self) -> Option<&Prompt> {
        self.waiting.as_ref().filter(|_| self.prompt_told)
    }

    /// The port, lent to an errand at a tool change, is the session's again at time `now`: silence is counted from here.
    pub fn port_is_back(&mut self, now: Duration) {
        (self.last_tick, self.last_heard, self.last_answer) = (now, now, now);
        self.asked = None;
    }

    /// What is known of the controller, kept up to date by its reports.
    pub fn controller(&self) -> &Known {
        &self.known
    }

    /// The result, once there is one.
    pub fn outcome(&self) -> Option<Outcome> {
        (self.phase == Phase::Ended).then(|| Outcome {
            ending: self.ending.clone(),
            sent: self.sent,
            acknowledged: self.acknowledged,
            total: self.job.total,
            position: self.known.work_position(),
            position_kept: self.position_kept,
            maybe: self.maybe,
            running_s: self
                .first_motion
                .map_or(0.0, |t| self.ended_at.saturating_sub(t).as_secs_f64()),
        })
    }

    /// Bytes in unanswered lines: never more than the controller's receive buffer.
    pub fn in_flight(&self) -> usize {
        self.stream.in_flight()
    }

    /// Takes in what arrived at time `now`.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for line in self.incoming.feed(bytes) {
            self.last_heard = now;
            self.reply(&Reply::parse(&line), now);
        }
    }

    /// The computer's clock says `wall` at time `now` (both since whenever; only their changes count). A jump of the one against the other
    /// is told: the computer slept, or its clock was set.
    pub fn wall_clock(&mut self, wall: Duration, now: Duration) {
        let by = self.wall.map_or(0.0, |(then_wall, then)| {
            (wall.as_secs_f64() - then_wall.as_secs_f64())
                - (now.as_secs_f64() - then.as_secs_f64())
        });
        if by.abs() > CLOCK_JUMP {
            self.news.push(Progress::ClockJump { by_s: by });
        }
        self.wall = Some((wall, now));
    }

    /// The port broke: the session ends here, whatever it was doing. The controller goes on with what it has.
    pub fn broken(&mut self, why: String, now: Duration) {
        if self.phase == Phase::Ended {
            return;
        }
        self.note_maybe();
        self.news.push(Progress::Unplugged { source: self.maybe });
        if self.ending == Ending::Done {
            self.ending = Ending::Broken(why);
        } else {
            self.note(&why);
        }
        self.position_kept = false;
        self.enter(Phase::Ended, now);
    }

    fn realtime(&mut self, command: Realtime) {
        self.urgent.push_back(command.byte());
    }

    fn note(&mut self, text: &str) {
        self.news.push(Progress::Note(text.to_string()));
    }

    fn end(&mut self, ending: Ending, now: Duration) {
        self.ending = ending;
        self.enter(Phase::Ended, now);
    }

    fn enter(&mut self, phase: Phase, now: Duration) {
        if phase == Phase::Ended {
            self.ended_at = now;
        }
        self.phase = phase;
        self.since = now;
    }

    /// Reports that come now were made behind what was sent `then`.
    fn reports_know_of(&self, then: Duration, now: Duration) -> bool {
        now.saturating_sub(then) >= self.known.round_trip * 5 / 4
    }

    fn state(&self) -> &State {
        &self.known.state
    }
}

/// Seconds by which two clocks may drift apart between two looks.
const CLOCK_JUMP: f64 = 2.0;
