//! What the operator wants: hold, resume, overrides one step at a time, stop.

use super::watching::Why;
use super::{Phase, Session};
use crate::link::command::Command;
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, PromptKind};
use crate::wire::{DoorPhase, Overrides, Realtime, State};
use std::time::Duration;

/// A step of an override may be followed by the next after this time even if no report has shown it: repeats are merged by the
/// firmware only until its main loop has looked.
const STEP: Duration = Duration::from_millis(50);
/// A hold or a resume that shows no effect is sent again after this time, or what the cable needs.
const AGAIN: Duration = Duration::from_millis(500);
/// Override steps kept waiting: more is a stuck key.
const MOST_STEPS: usize = 64;

/// How far a resume is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Resume {
    /// For the machine to come to rest: `~` is ignored until then.
    Waits,
    /// The spindle was started again and comes up to speed.
    SpinsUp(Duration),
    /// `~` was sent.
    Sent(Duration),
}

/// An override step under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Adjusting {
    what: Realtime,
    since: Duration,
    overrides: Overrides,
    accessories: String,
}

/// What a controller begins with, until a report has said otherwise.
const NO_OVERRIDES: Overrides = Overrides {
    feed: 100,
    rapid: 100,
    spindle: 100,
};

impl Session {
    /// The operator's wish at time `now`.
    pub fn command(&mut self, command: Command, now: Duration) {
        match (command, &self.phase) {
            (_, Phase::Ended) => {}
            (Command::ResetNow, _) => self.reset_now(now),
            (Command::Stop, Phase::Streaming) => self.stop(Ending::Stopped, "stop wanted", now),
            (Command::Stop, Phase::Introducing) => self.end(Ending::Stopped, now),
            (_, phase) if *phase != Phase::Streaming => {
                // A stop is under way, or nothing has begun: there is nothing to adjust.
            }
            (Command::Hold, _) => {
                self.hold_asked = true;
                self.last_hold_sent = now;
                (self.resume, self.pause_told) = (None, false);
                self.realtime(Realtime::Hold);
            }
            (Command::Door, _) => {
                self.hold_asked = true;
                self.last_hold_sent = now;
                (self.resume, self.pause_told) = (None, false);
                self.realtime(Realtime::Door);
            }
            (Command::Resume, _) => self.resume_wanted(now),
            (Command::SpindleStop, _) => {
                if matches!(self.state(), State::Hold { .. }) {
                    self.spindle_stopped = !self.spindle_stopped;
                    self.step(Realtime::SpindleStop);
                } else {
                    self.note("the spindle can be stopped by itself only in a hold");
                }
            }
            (command, _) => {
                if let Some(byte) = command.adjustment() {
                    self.step(byte);
                }
            }
        }
    }

    /// Something outside of the session went wrong after which the job must not go on, such as an errand at a tool change: stops in
    /// order, for this reason. The position counts as lost.
    pub fn give_up(&mut self, why: String, now: Duration) {
        if matches!(self.phase, Phase::Introducing | Phase::Streaming) {
            self.position_kept = false;
            let told = why.clone();
            self.stop(Ending::NotReady(why), &told, now);
        }
    }

    fn reset_now(&mut self, now: Duration) {
        self.note("reset at once: if the machine was moving, its position is lost");
        let streaming = self.phase != Phase::Introducing;
        self.cut_off();
        if self.ending == Ending::Done {
            self.ending = Ending::Stopped;
        }
        if streaming && !self.state().at_rest() {
            self.moved_under_reset();
        }
        self.reset(now);
    }

    fn step(&mut self, byte: Realtime) {
        if self.adjustments.len() < MOST_STEPS {
            self.adjustments.push_back(byte);
        } else {
            self.note("too many override steps at once: some were left out");
        }
    }

    /// One step at a time: the firmware keeps flags, not counters, and merges repeats.
    pub(super) fn adjust(&mut self, now: Duration) {
        if let Some(a) = &self.adjusting {
            let confirmed = self.overrides.is_some_and(|now| now != a.overrides)
                || self.accessories != a.accessories;
            if !confirmed && now.saturating_sub(a.since) < STEP {
                return;
            }
            let what = a.what;
            self.adjusting = None;
            self.news.push(Progress::Adjusted { what, confirmed });
        }
        if let Some(what) = self.adjustments.pop_front() {
            self.realtime(what);
            self.adjusting = Some(Adjusting {
                what,
                since: now,
                overrides: self.overrides.unwrap_or(NO_OVERRIDES),
                accessories: self.accessories.clone(),
            });
            // The next report shows it; asked for at once so that the step is confirmed in time.
            if !self.stream.writes_memory() && now >= self.quiet_until {
                self.realtime(Realtime::Status);
                (self.asked, self.last_asked) = (Some(now), now);
            }
        }
    }

    fn resume_wanted(&mut self, now: Duration) {
        if *self.state() == State::Door(DoorPhase::Ajar) {
            // Kept until later, it would start the machine at the moment the door closes.
            return self.note("the safety door is open: close it, then resume");
        }
        let held = matches!(self.state(), State::Hold { .. } | State::Door(_));
        if held || self.hold_asked || self.prompt_under_way().is_some() {
            self.resume = Some(Resume::Waits);
            self.go_on(now);
        } else if self.tool_change().is_some() {
            (self.waiting, self.prompt_told) = (None, false);
            // The modes are brought back once a report has told where the operator left the machine.
            self.look_now(Why::Change, now);
            self.news.push(Progress::Resumed);
        } else {
            self.note("nothing is on hold: there is nothing to resume");
        }
    }

    /// Carries a wanted resume on: rest, spindle, `~` until the machine goes on.
    pub(super) fn go_on(&mut self, now: Duration) {
        let at_rest = matches!(
            self.state(),
            State::Hold { at_rest: true } | State::Door(DoorPhase::Closed)
        );
        match self.resume {
            Some(Resume::Waits) if at_rest => {
                if self.spindle_stopped {
                    // GRBL would start the spindle with the motion and cut before it is up to speed (gnea/grbl#605).
                    self.spindle_stopped = false;
                    self.realtime(Realtime::SpindleStop);
                    self.note("the spindle starts again");
                    self.resume = Some(Resume::SpinsUp(now));
                } else {
                    self.realtime(Realtime::Resume);
                    self.resume = Some(Resume::Sent(now));
                }
            }
            Some(Resume::SpinsUp(since)) if now.saturating_sub(since) >= self.options.spin_up => {
                self.realtime(Realtime::Resume);
                self.resume = Some(Resume::Sent(now));
            }
            // Only a report that knows of it tells that it was lost.
            Some(Resume::Sent(since)) if at_rest && self.shows(since, self.last_report) => {
                if self.prompt_under_way().is_some() {
                    // The machine may have gone on, and rests at the program's own stop by now: that one is the operator's.
                    (self.resume, self.hold_asked, self.pause_told) = (None, false, false);
                } else {
                    self.realtime(Realtime::Resume);
                    self.resume = Some(Resume::Sent(now));
                }
            }
            _ => {}
        }
    }

    /// What was sent `then` had its time to show in a report that came at `seen`.
    fn shows(&self, then: Duration, seen: Duration) -> bool {
        seen.saturating_sub(then) >= AGAIN && self.reports_know_of(then, seen)
    }

    /// What a report's state says about holds: one we did not ask for is told once, a resume ends when the machine goes on.
    pub(super) fn holding(&mut self, state: &State, now: Duration) {
        let held = matches!(state, State::Hold { .. } | State::Door(_));
        if !held {
            let sent = matches!(self.resume, Some(Resume::Sent(_)));
            // Once a hold was told, a report without one means that somebody else resumed; before that, it is merely older than the
            // hold, unless it has had its time: then the hold was lost, or was left by a resume wished for twice.
            let overdue = self.shows(self.last_hold_sent, now);
            if sent || self.pause_told || (overdue && self.resume.is_some()) {
                (self.hold_asked, self.pause_told, self.resume) = (false, false, None);
                self.spindle_stopped = false;
                self.news.push(Progress::Resumed);
            } else if self.hold_asked && matches!(state, State::Run | State::Idle) && overdue {
                // Still running: the hold was lost on the way.
                self.realtime(Realtime::Hold);
                self.last_hold_sent = now;
            }
            return;
        }
        let at_rest = matches!(
            state,
            State::Hold { at_rest: true } | State::Door(DoorPhase::Closed | DoorPhase::Ajar)
        );
        if at_rest && self.resume.is_none() && !self.pause_told {
            self.pause_told = true;
            let news = match (state, self.prompt_under_way()) {
                (State::Door(_), _) => {
                    Progress::Paused("safety door: close it, then resume".to_string())
                }
                (_, Some(prompt)) if !self.hold_asked => Progress::Prompt(prompt),
                (_, Some(prompt)) => Progress::Paused(format!("on hold, at rest; {prompt}")),
                _ if self.hold_asked => {
                    Progress::Paused("on hold, at rest: resume or stop".to_string())
                }
                _ => Progress::Paused(
                    "the machine is on hold, but not by us (a button, or noise): resume or stop"
                        .to_string(),
                ),
            };
            self.news.push(news);
        }
        self.go_on(now);
    }

    /// A tool change is told once everything before it is done and the machine stands.
    pub(super) fn prompt_when_still(&mut self) {
        if let Some(prompt) = &self.waiting
            && !self.prompt_told
            && self.stream.is_settled()
        {
            debug_assert!(prompt.kind != PromptKind::Pause);
            let prompt = prompt.clone();
            self.prompt_told = true;
            self.news.push(Progress::Prompt(prompt));
        }
    }
}
