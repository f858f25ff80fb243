//! Nothing is answered: why?

use super::{Phase, Session};
use crate::link::job::Standstill;
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, Stall};
use crate::wire::State;
use std::time::Duration;

/// No answer for this long is told, with its cause.
const QUIET: Duration = Duration::from_secs(2);
/// Idle with unanswered lines for this long (plus their dwells): a reply was lost.
const LOST_REPLY: Duration = Duration::from_secs(5);
/// Run without any motion for this long.
const STUCK: Duration = Duration::from_secs(10);

impl Session {
    /// Tells a stall when it begins, changes and ends; a lost reply stops the job.
    pub(super) fn notice_stall(&mut self, now: Duration) {
        let stall = self.cause(now);
        if stall != self.stall {
            self.stall = stall;
            self.news.push(Progress::Stall(stall));
        }
        if let Some(Stall::LostAcknowledgement { line }) = stall {
            self.stop(Ending::LostReply { line }, "a reply was lost", now);
        }
    }

    fn cause(&self, now: Duration) -> Option<Stall> {
        debug_assert_eq!(self.phase, Phase::Streaming);
        if self.waiting.is_some() && self.prompt_told {
            return Some(Stall::Prompt);
        }
        match self.state() {
            State::Hold { .. } if self.prompt_under_way().is_some() => return Some(Stall::Prompt),
            State::Hold { .. } => return Some(Stall::Hold),
            State::Door(_) => return Some(Stall::Door),
            _ => {}
        }
        let quiet = now.saturating_sub(self.last_answer);
        let Some(oldest) = self.stream.unanswered().next() else {
            let forbidden = self.next.is_some() && self.index >= self.allowed;
            return (forbidden && quiet > QUIET).then_some(Stall::Permission);
        };
        let line = oldest.line.source;
        if let Some(idle) = self.idle_since {
            let dwell: f64 = self
                .stream
                .unanswered()
                .map(|f| match f.line.standstill {
                    Standstill::Yes { dwell } => dwell,
                    Standstill::No => 0.0,
                })
                .sum();
            let patience =
                LOST_REPLY + Duration::try_from_secs_f64(dwell).unwrap_or(Duration::MAX / 4);
            if now.saturating_sub(idle.max(self.last_answer)) > patience {
                return Some(Stall::LostAcknowledgement { line });
            }
        }
        if quiet <= QUIET {
            return None;
        }
        if oldest.line.standstill != Standstill::No {
            return Some(Stall::Waiting { line });
        }
        match self.state() {
            State::Run if now.saturating_sub(self.moved) > STUCK => Some(Stall::Stuck { line }),
            State::Run => Some(Stall::PlannerFull { line }),
            _ => None,
        }
    }
}
