//! What each reply means to a session in each of its phases.

use super::{Closing, Phase, Session};
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, PromptKind, Report, Span};
use crate::link::stream::{Flight, Receipt};
use crate::wire::{Reply, State, Status};
use std::time::Duration;

/// After a line that writes the controller's memory has been answered, so long nothing is sent (gnea/grbl#165).
const MEMORY_PAUSE: Duration = Duration::from_millis(50);

impl Session {
    pub(super) fn reply(&mut self, reply: &Reply, now: Duration) {
        if let Reply::Message(text) = reply {
            self.note(&format!("controller: {text}"));
        }
        if self.phase == Phase::Introducing {
            self.introduction.receive(reply, now);
            return self.introduced(now);
        }
        if let Reply::Status(status) = reply {
            self.report(status, now);
        }
        if let Reply::Status(status) = reply {
            let streaming = self.phase == Phase::Streaming;
            self.place_told(status, now);
            if streaming && self.phase != Phase::Streaming {
                // It began the stop, and so is older than the hold.
                return;
            }
        }
        match self.phase.clone() {
            Phase::Streaming => self.while_streaming(reply, now),
            Phase::Stopping { quiet_reports } => match reply {
                Reply::Status(status) => self.coming_to_rest(&status.state, quiet_reports, now),
                Reply::Alarm(code) => self.alarm(*code, now),
                Reply::Welcome { .. } => {
                    // It restarted by itself, perhaps in motion.
                    self.position_kept = false;
                    self.last_look(now);
                }
                // Answers still count: the journal says how many lines the controller took. grblHAL answers every line behind an
                // error with that error; only the first ended the job.
                _ => match self.stream.receive(reply) {
                    Receipt::Accepted(flight) => self.accepted(&flight, now),
                    Receipt::Refused { flight, code } => self.refused(&flight, code),
                    Receipt::Unasked | Receipt::Push => {}
                },
            },
            // From the reset to the greeting no answer counts: the controller may still let go of one stray `ok`.
            Phase::AlarmPause | Phase::Resetting { .. } => match reply {
                Reply::Alarm(_) => self.moved_under_reset(),
                Reply::Welcome { .. } => self.last_look(now),
                _ => {}
            },
            Phase::LastLook => {
                if let Reply::Status(_) = reply
                    && self.known.work_position().is_some()
                {
                    self.enter(Phase::Ended, now);
                }
            }
            Phase::Introducing | Phase::Ended => {}
        }
    }

    fn report(&mut self, status: &Status, now: Duration) {
        (self.asked, self.last_report) = (None, now);
        let before = self.known.machine_position;
        self.known.hear(status);
        if !self.places(status) {
            self.known.machine_position = before;
        }
        let moved = match (before, self.known.machine_position) {
            (Some(a), Some(b)) => (0..3).any(|i| (a[i] - b[i]).abs() > 1e-6),
            _ => true,
        };
        if moved {
            self.moved = now;
        }
        if status.overrides.is_some() {
            self.overrides = status.overrides;
            self.accessories.clone_from(&status.accessories);
        }
        if status.state == State::Idle {
            self.idle_since.get_or_insert(now);
        } else {
            self.idle_since = None;
        }
        if status.state == State::Run && self.phase == Phase::Streaming {
            self.first_motion.get_or_insert(now);
        }
        // The last look tells a journal where the machine stands, if that is still where the job left it.
        let last = self.phase == Phase::LastLook && self.position_kept;
        if last || matches!(self.phase, Phase::Streaming | Phase::Stopping { .. }) {
            let unit = if self.known.inches { 25.4 } else { 1.0 };
            let source = self
                .stream
                .unanswered()
                .map(|f| f.line.source)
                .find(|s| *s > 0);
            self.news.push(Progress::Report(Box::new(Report {
                sent: self.sent,
                acknowledged: self.acknowledged,
                total: self.job.total,
                source: source.unwrap_or(self.last_source),
                state: status.state.clone(),
                position: self.known.work_position(),
                machine_position: self.known.machine_position,
                feed: status.feed.map(|f| f * unit),
                speed: status.speed,
                overrides: self.overrides,
                accessories: self.accessories.clone(),
                pins: status.pins.clone(),
                buffer: status.buffer,
                in_flight: self.stream.in_flight(),
            })));
        }
    }

    fn while_streaming(&mut self, reply: &Reply, now: Duration) {
        match reply {
            Reply::Alarm(code) => return self.alarm(*code, now),
            Reply::Welcome { .. } => return self.controller_reset(now),
            Reply::Other(text) if reply.is_damage() => {
                let text = text.clone();
                return self.stop(Ending::Damaged { text }, "damaged bytes came back", now);
            }
            _ => {}
        }
        match self.stream.receive(reply) {
            Receipt::Accepted(flight) => {
                self.last_answer = now;
                self.accepted(&flight, now);
                if flight.line.writes_memory {
                    self.quiet_until = now + MEMORY_PAUSE;
                }
                if let Some(prompt) = flight.line.prompt.clone()
                    && matches!(prompt.kind, PromptKind::ToolChange { .. })
                {
                    (self.waiting, self.prompt_told) = (Some(prompt), false);
                }
            }
            Receipt::Refused { flight, code } => {
                self.refused(&flight, code);
                let ending = Ending::Refused {
                    line: flight.line.source,
                    text: flight.line.text,
                    code,
                    firmware: self.known.firmware,
                };
                self.stop(ending, "the controller refused a line", now);
            }
            // At a tool change others may talk on the same port; their answers are theirs.
            Receipt::Unasked if self.waiting.is_some() => {}
            Receipt::Unasked => {
                let text = "an answer no line was waiting for".to_string();
                self.stop(Ending::Damaged { text }, "the answers do not add up", now);
            }
            Receipt::Push => {
                if self.closing == Closing::Sent && self.stream.is_settled() {
                    self.finish(now);
                } else if let Reply::Status(status) = reply {
                    self.holding(&status.state, now);
                    self.prompt_when_still();
                    if matches!(status.state, State::Alarm | State::Sleep | State::Check) {
                        // Nothing we asked for: an alarm line was lost on the way, or somebody else is on the cable.
                        let state = status.state.text().to_string();
                        self.stop(
                            Ending::StateLost { state },
                            "the controller left the job",
                            now,
                        );
                    }
                }
            }
        }
    }

    fn accepted(&mut self, flight: &Flight, now: Duration) {
        self.is_past(&flight.line, now);
        if let Some(index) = flight.index {
            self.acknowledged = index + 1;
            self.last_source = flight.line.source;
            self.news.push(Progress::Acknowledged(Span {
                lines: index..index + 1,
                source: flight.line.source,
            }));
        }
    }

    fn refused(&mut self, flight: &Flight, code: u16) {
        if let Some(index) = flight.index {
            self.acknowledged = index + 1;
        }
        self.news.push(Progress::Refused {
            index: flight.index,
            source: flight.line.source,
            text: flight.line.text.clone(),
            code,
        });
    }

    fn finish(&mut self, now: Duration) {
        if let Some(reported) = self.known.work_position() {
            let by_text = self.job.end;
            let expected: [f64; 3] = self
                .end_of_way()
                .unwrap_or_else(|| std::array::from_fn(|i| by_text[i].unwrap_or(reported[i])));
            let beside = |i: usize| {
                // The machine stands on a whole step.
                let steps = self.known.setting(100 + i as u16).filter(|s| *s > 0.0);
                let half = steps.map_or(0.0, |s| 0.5 / s);
                (expected[i] - reported[i]).abs() > self.options.end_tolerance + half
            };
            if (0..3).any(beside) {
                self.ending = Ending::Elsewhere { expected, reported };
            }
            self.enter(Phase::Ended, now);
        }
        // Without a position yet (the offset comes only every so many reports) the next report decides.
    }
}
