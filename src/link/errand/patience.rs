//! How long an errand waits, and when it asks for a report.

use super::error::ErrandError;
use super::exchange::{Exchange, Rule, Task};
use super::run::{Errand, Phase};
use crate::wire::Realtime;
use std::time::Duration;

/// No byte for this long although something was asked: nobody is there.
const SILENCE: Duration = Duration::from_secs(4);
/// Idle, and the answer to a line that moves has not come for this long: it was lost.
const LOST_REPLY: Duration = Duration::from_secs(5);
/// A report asked for and not given is asked for again after this.
const ASK_AGAIN: Duration = Duration::from_secs(1);

impl<T: Task> Errand<T> {
    pub(super) fn watch_the_answer(&mut self, exchange: &Exchange, now: Duration) {
        let silent = || ErrandError::Silent {
            text: exchange.text.clone(),
            moving: !matches!(exchange.rule, Rule::Plain | Rule::Writer),
        };
        match exchange.rule {
            Rule::Plain | Rule::Writer => {
                if now.saturating_sub(self.last_heard.max(self.since)) > SILENCE {
                    self.fail(silent(), now);
                }
            }
            Rule::Silent(patience) => {
                if now.saturating_sub(self.since) > patience {
                    self.fail(silent(), now);
                }
            }
            Rule::Motion | Rule::Jog => {
                let dwells = exchange.text.contains("G4") || exchange.text.contains("G04");
                if now.saturating_sub(self.last_heard.max(self.since)) > SILENCE {
                    self.fail(silent(), now);
                } else if let Some(idle) = self.idle_since
                    && !dwells
                    && now.saturating_sub(idle.max(self.since)) > LOST_REPLY
                {
                    self.fail(ErrandError::LostReply(exchange.text.clone()), now);
                }
            }
        }
    }

    pub(super) fn watch_the_link(&mut self, now: Duration) {
        if now.saturating_sub(self.last_heard.max(self.since)) > SILENCE {
            let error = ErrandError::Silent {
                text: "?".to_string(),
                moving: self.may_be_moving(),
            };
            self.fail(error, now);
        }
    }

    pub(super) fn ask_for_a_report(&mut self, now: Duration) {
        let pause = match &self.phase {
            Phase::Listening | Phase::Deciding => self.options.poll,
            Phase::Waiting(e) if matches!(e.rule, Rule::Motion | Rule::Jog) => self.options.poll,
            // Soon, but no more than the 10 Hz that the firmware takes without harm.
            Phase::Settling { .. }
            | Phase::JogStop { .. }
            | Phase::Stopping { .. }
            | Phase::LastLook => self.options.poll / 2,
            _ => return,
        };
        let overdue = self
            .asked
            .is_some_and(|t| now.saturating_sub(t) > ASK_AGAIN);
        if overdue || (self.asked.is_none() && now.saturating_sub(self.last_asked) >= pause) {
            self.realtime(Realtime::Status);
            self.asked = Some(now);
            self.last_asked = now;
        }
    }
}
