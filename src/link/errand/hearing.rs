//! What each reply means to an errand in each of its phases.

use super::error::ErrandError;
use super::exchange::{News, Rule, Task};
use super::run::{Errand, IDLE_REPORTS, Moving, Phase};
use crate::wire::{Reply, State, Status};
use std::time::Duration;

impl<T: Task> Errand<T> {
    pub(super) fn reply(&mut self, line: &str, reply: &Reply, now: Duration) {
        if let Phase::Meeting(introduction) = &mut self.phase {
            introduction.receive(reply, now);
            self.out.extend(introduction.output());
            if matches!(reply, Reply::Message(_) | Reply::Alarm(_)) {
                self.news
                    .push(News::Said(line.to_string(), Box::new(reply.clone())));
            }
            return self.met(now);
        }
        self.news
            .push(News::Said(line.to_string(), Box::new(reply.clone())));
        if let Reply::Status(status) = reply {
            self.report(status, now);
        }
        if matches!(
            self.phase,
            Phase::JogStop { .. }
                | Phase::Stopping { .. }
                | Phase::AlarmPause { .. }
                | Phase::Resetting { .. }
                | Phase::LastLook
                | Phase::Ended
        ) {
            return self.stopping_reply(reply, now);
        }
        match reply {
            Reply::Alarm(code) => self.alarm(*code, now),
            Reply::Welcome { .. } => self.restarted(now),
            Reply::Ok | Reply::Error(_) => self.answer(reply, now),
            Reply::Status(status) => {
                if let Phase::Settling { idle } = &mut self.phase {
                    *idle = if status.state == State::Idle {
                        *idle + 1
                    } else {
                        0
                    };
                    if *idle >= IDLE_REPORTS && self.known.machine_position.is_some() {
                        self.moving = Moving::Nothing;
                        self.enter(Phase::Deciding, now);
                    } else if matches!(status.state, State::Alarm) {
                        let error = ErrandError::Locked;
                        self.fail(error, now);
                    }
                }
            }
            other => self.heard.take(line, other),
        }
    }

    fn report(&mut self, status: &Status, now: Duration) {
        self.asked = None;
        self.known.hear(status);
        self.status = Some(status.clone());
        self.news.push(News::Report(
            Box::new(status.clone()),
            Box::new(self.known.clone()),
        ));
        if status.state == State::Idle {
            let since = *self.idle_since.get_or_insert(now);
            // A console's moves are not settled one by one.
            let quiet = now.saturating_sub(since) > self.options.poll;
            if quiet && matches!(self.phase, Phase::Listening) && !self.unanswered {
                self.moving = Moving::Nothing;
            }
        } else {
            self.idle_since = None;
        }
        let held = matches!(status.state, State::Hold { .. } | State::Door(_));
        if held && !self.hold_told && !self.stopping() {
            self.news.push(News::Note(format!(
                "the machine says {}: resume at the machine, or stop with Ctrl-C",
                status.state.text()
            )));
        }
        self.hold_told = held;
    }

    fn stopping(&self) -> bool {
        matches!(self.phase, Phase::JogStop { .. } | Phase::Stopping { .. })
    }

    fn answer(&mut self, reply: &Reply, now: Duration) {
        let Phase::Waiting(exchange) = &self.phase else {
            // A stray `ok`, such as GRBL lets go of after an abort.
            return;
        };
        let exchange = exchange.clone();
        self.unanswered = false;
        if matches!(exchange.rule, Rule::Silent(_)) {
            self.moving = Moving::Nothing;
        }
        if let Reply::Error(code) = reply {
            self.heard.refused = Some(*code);
            if !self.task.carries_on() {
                let error = ErrandError::Refused {
                    text: exchange.text,
                    code: *code,
                };
                return self.fail(error, now);
            }
        }
        match exchange.rule {
            Rule::Writer => self.enter(Phase::After, now),
            _ => {
                self.enter(Phase::Deciding, now);
                self.decide(now);
            }
        }
    }

    fn restarted(&mut self, now: Duration) {
        self.moving = Moving::Nothing;
        self.unanswered = false;
        if self.task.carries_on() {
            self.enter(Phase::Listening, now);
        } else {
            self.end(Some(ErrandError::ControllerReset), now);
        }
    }
}
