//! How an errand ends early: jog cancel, or hold, standstill and reset; and what follows an alarm.
//!
//! A jog is cancelled by 0x85, and again on every report that still says Jog: the byte flushes the planner, but neither the line that
//! waits for room in it nor the bytes behind that (GRBL 1.1, `doc/markdown/jogging.md`, and observed). It has ended once the last
//! jog line was answered and two reports in a row say Idle.

use super::error::ErrandError;
use super::exchange::{News, Rule, Task};
use super::run::{Errand, IDLE_REPORTS, Moving, Phase};
use crate::wire::{Realtime, Reply, State};
use std::time::Duration;

/// No report for this long while stopping: a blind reset is the lesser evil.
const STOP_SILENCE: Duration = Duration::from_secs(2);
/// A hold is sent again this often while reports still say Run.
const HOLD_AGAIN: Duration = Duration::from_millis(500);
/// GRBL is deaf for half a second after an alarm and may swallow a reset sent then.
const ALARM_DEAF: Duration = Duration::from_millis(700);
/// A reset answers with a greeting within this time, or it is sent once more.
const RESET_WAIT: Duration = Duration::from_millis(1500);
/// Idle after a jog cancel, and the jog line is still not answered: it never will be.
const STUCK_JOG: Duration = Duration::from_secs(1);
/// Reports that still say Jog at the same place, after as many cancels: the controller hangs, and only a reset frees it.
const STANDING_JOG: u32 = 20;
/// Patience for the last position report.
const LAST_LOOK: Duration = Duration::from_secs(2);

impl<T: Task> Errand<T> {
    /// The operator wants it to end: whatever moves is stopped in order first. Homing knows no order: only a reset stops it.
    pub fn cancel(&mut self, now: Duration) {
        match self.phase {
            Phase::Ended
            | Phase::JogStop { .. }
            | Phase::Stopping { .. }
            | Phase::AlarmPause { .. }
            | Phase::Resetting { .. }
            | Phase::LastLook => {}
            _ => self.fail(
                ErrandError::Cancelled {
                    position_kept: true,
                },
                now,
            ),
        }
    }

    /// Reset at once, even in motion: the position is lost then.
    pub fn reset_now(&mut self, now: Duration) {
        if matches!(self.phase, Phase::Ended) {
            return;
        }
        if matches!(self.phase, Phase::Meeting(_)) {
            return self.end(
                Some(ErrandError::Cancelled {
                    position_kept: true,
                }),
                now,
            );
        }
        let position_kept = self.moving == Moving::Nothing || self.known.state.at_rest();
        self.ending = Some(ErrandError::Cancelled { position_kept });
        self.reset(now);
    }

    /// The port broke: it ends here.
    pub fn broken(&mut self, why: String, now: Duration) {
        if !matches!(self.phase, Phase::Ended) {
            let moving = self.may_be_moving();
            self.end(Some(ErrandError::Broken { why, moving }), now);
        }
    }

    /// Ends with `error`, once nothing moves any more.
    pub(super) fn fail(&mut self, error: ErrandError, now: Duration) {
        // A question under way may have been answered before the stop: ask afresh.
        self.asked = None;
        self.last_asked = now;
        match self.moving {
            Moving::Nothing => match &self.phase {
                // Never into a write: it ends with its answer, then nothing more is sent.
                Phase::Waiting(e)
                    if e.rule == Rule::Writer
                        && !matches!(
                            error,
                            ErrandError::Silent { .. } | ErrandError::Refused { .. }
                        ) =>
                {
                    self.ending = Some(error);
                }
                _ => self.end(Some(error), now),
            },
            Moving::Jog => {
                self.news.push(News::Stopping("jog cancelled".to_string()));
                self.ending = Some(error);
                self.realtime(Realtime::JogCancel);
                (self.standing, self.stood_at) = (0, None);
                self.enter(Phase::JogStop { idle: 0 }, now);
            }
            Moving::Program => {
                self.news.push(News::Stopping(
                    "feed hold, then standstill, then reset".to_string(),
                ));
                self.ending = Some(error);
                self.realtime(Realtime::Hold);
                self.last_hold = now;
                self.enter(Phase::Stopping { quiet: 0 }, now);
            }
            Moving::Homing => {
                self.news.push(News::Stopping(
                    "only a reset stops homing: the position is lost".to_string(),
                ));
                self.ending = Some(match error {
                    ErrandError::Cancelled { .. } => ErrandError::Cancelled {
                        position_kept: false,
                    },
                    other => other,
                });
                self.reset(now);
            }
        }
    }

    pub(super) fn alarm(&mut self, code: u16, now: Duration) {
        self.known.alarm = Some(code);
        if self.task.carries_on() {
            // Told by the news; a line that waits will not be answered any more, or by an `ok` that nobody misses.
            self.moving = Moving::Nothing;
            self.unanswered = false;
            return self.enter(Phase::Listening, now);
        }
        let doing = match &self.phase {
            Phase::Waiting(e) => format!("`{}`", e.text),
            _ => "the motion".to_string(),
        };
        self.ending = Some(ErrandError::Alarm {
            code,
            doing,
            more: self.task.alarm_advice(code),
        });
        self.moving = Moving::Nothing;
        self.enter(Phase::AlarmPause { code }, now);
    }

    pub(super) fn reset(&mut self, now: Duration) {
        self.realtime(Realtime::Reset);
        self.enter(Phase::Resetting { again: false }, now);
    }

    pub(super) fn stopping_reply(&mut self, reply: &Reply, now: Duration) {
        if reply.answers_a_line() {
            self.unanswered = false;
        }
        match (&mut self.phase, reply) {
            (Phase::JogStop { .. } | Phase::Stopping { .. }, Reply::Alarm(code)) => {
                let code = *code;
                self.alarm(code, now);
            }
            (Phase::JogStop { .. } | Phase::Stopping { .. }, Reply::Welcome { .. }) => {
                self.moving = Moving::Nothing;
                self.last_look(now);
            }
            (Phase::JogStop { idle }, Reply::Status(status)) => {
                let quiet = status.state == State::Idle && !self.unanswered;
                *idle = if quiet { *idle + 1 } else { 0 };
                let ended = *idle >= IDLE_REPORTS;
                match status.state {
                    _ if ended => {
                        self.moving = Moving::Nothing;
                        let error = self.ending.take();
                        self.end(error, now);
                    }
                    State::Jog => {
                        let here = self.known.machine_position;
                        self.standing = if here == self.stood_at {
                            self.standing + 1
                        } else {
                            0
                        };
                        self.stood_at = here;
                        if self.standing > STANDING_JOG {
                            self.note("the controller says Jog but stands still, and takes no cancel: it is reset");
                            self.reset(now);
                        } else {
                            self.realtime(Realtime::JogCancel);
                        }
                    }
                    // A door or a hold button came in between: at rest, and a reset empties what waits.
                    State::Hold { at_rest: true } | State::Door(_) if status.state.at_rest() => {
                        self.reset(now)
                    }
                    // It runs a program: not ours to cancel by this byte.
                    State::Run => {
                        self.realtime(Realtime::Hold);
                        self.last_hold = now;
                        self.enter(Phase::Stopping { quiet: 0 }, now);
                    }
                    _ => {}
                }
            }
            (Phase::Stopping { quiet }, Reply::Status(status)) => {
                // One Idle may be older than our hold; two in a row are not. `Hold:0` says it all.
                *quiet = if status.state.at_rest() {
                    *quiet + 1
                } else {
                    0
                };
                let certain = matches!(status.state, State::Hold { at_rest: true });
                let moving = matches!(status.state, State::Run | State::Jog);
                if certain || *quiet >= IDLE_REPORTS {
                    self.reset(now);
                } else if moving && now.saturating_sub(self.last_hold) > HOLD_AGAIN {
                    self.realtime(Realtime::Hold);
                    self.last_hold = now;
                }
            }
            (Phase::Resetting { .. }, Reply::Alarm(_)) => {
                // The reset met motion.
                if let Some(ErrandError::Cancelled { position_kept }) = &mut self.ending {
                    *position_kept = false;
                }
            }
            (Phase::Resetting { .. }, Reply::Welcome { .. }) => {
                self.moving = Moving::Nothing;
                self.last_look(now);
            }
            (Phase::LastLook, Reply::Status(_)) => {
                let error = self.ending.take();
                self.end(error, now);
            }
            _ => {}
        }
    }

    pub(super) fn stopping_tick(&mut self, now: Duration) {
        let here = now.saturating_sub(self.since);
        match self.phase {
            Phase::JogStop { .. } | Phase::Stopping { .. } => {
                let quiet = now.saturating_sub(self.last_heard.max(self.since));
                let stuck = matches!(self.phase, Phase::JogStop { .. })
                    && self.unanswered
                    && self
                        .idle_since
                        .is_some_and(|t| now.saturating_sub(t.max(self.since)) > STUCK_JOG);
                if quiet > STOP_SILENCE {
                    self.note("no report that the machine is at rest: reset anyway, the position is not certain");
                    if let Some(ErrandError::Cancelled { position_kept }) = &mut self.ending {
                        *position_kept = false;
                    }
                    self.reset(now);
                } else if stuck {
                    // Idle, so the reset costs nothing, and the line that waits dies with it.
                    self.reset(now);
                }
            }
            Phase::AlarmPause { code } if here > ALARM_DEAF => {
                // After a limit alarm the firmware listens to nothing but a reset.
                if matches!(code, 1 | 2) {
                    self.reset(now);
                } else {
                    let error = self.ending.take();
                    self.end(error, now);
                }
            }
            Phase::Resetting { again } if here > RESET_WAIT => {
                if again {
                    self.note("no greeting after the reset: switch the controller off before touching the machine");
                    let error = self.ending.take();
                    self.end(error, now);
                } else {
                    self.realtime(Realtime::Reset);
                    self.enter(Phase::Resetting { again: true }, now);
                }
            }
            Phase::LastLook if here > LAST_LOOK => {
                let error = self.ending.take();
                self.end(error, now);
            }
            _ => {}
        }
    }

    fn last_look(&mut self, now: Duration) {
        self.asked = None;
        self.enter(Phase::LastLook, now);
    }

    fn note(&mut self, text: &str) {
        self.news.push(News::Note(text.to_string()));
    }
}
