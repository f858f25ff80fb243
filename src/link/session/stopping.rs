//! The end of a job that is not the program's: hold, standstill, reset, a last look.

use super::{Phase, Session};
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, Stall};
use crate::wire::{DoorPhase, Realtime, State};
use std::time::Duration;

impl Session {
    /// Hold at once; [`Session::coming_to_rest`] goes on.
    pub(super) fn stop(&mut self, ending: Ending, why: &str, now: Duration) {
        self.ending = ending;
        self.cut_off();
        self.news.push(Progress::Stopping(why.to_string()));
        self.hold_again(now);
        // A question under way may have been answered before the hold; ask afresh.
        self.asked = None;
        self.last_asked = now;
        self.enter(Phase::Stopping { quiet_reports: 0 }, now);
    }

    /// No line goes out any more; remembers which may still be carried out.
    pub(super) fn cut_off(&mut self) {
        self.note_maybe();
        self.stream.interrupt();
        (self.resume, self.waiting, self.adjusting) = (None, None, None);
        self.adjustments.clear();
        self.own.clear();
        self.next = None;
    }

    pub(super) fn coming_to_rest(&mut self, state: &State, quiet_reports: u32, now: Duration) {
        // A report older than our hold says nothing. One Idle may be; two in a row are not. `Hold:0` says it all.
        if !self.reports_know_of(self.since, now) {
            return;
        }
        let quiet_reports = if state.at_rest() {
            quiet_reports + 1
        } else {
            0
        };
        let certain = matches!(state, State::Hold { at_rest: true });
        if certain || quiet_reports >= 2 {
            return self.reset(now);
        }
        self.phase = Phase::Stopping { quiet_reports };
        let resuming = matches!(state, State::Door(DoorPhase::Resuming));
        if (resuming || matches!(state, State::Run | State::Jog))
            && now.saturating_sub(self.last_hold_sent) > Duration::from_millis(500)
        {
            self.hold_again(now);
        }
    }

    /// A hold; behind a door that is being left a feed hold is ignored, and only the door command keeps the machine from going on.
    fn hold_again(&mut self, now: Duration) {
        let resuming = matches!(self.state(), State::Door(DoorPhase::Resuming));
        self.realtime(if resuming {
            Realtime::Door
        } else {
            Realtime::Hold
        });
        self.last_hold_sent = now;
    }

    pub(super) fn reset(&mut self, now: Duration) {
        self.realtime(Realtime::Reset);
        self.enter(Phase::Resetting { again: false }, now);
    }

    /// The reset met the machine in motion: whoever wanted it, the position is lost.
    pub(super) fn moved_under_reset(&mut self) {
        self.position_kept = false;
        if self.ending == Ending::Stopped {
            self.ending = Ending::Aborted;
        }
    }

    pub(super) fn last_look(&mut self, now: Duration) {
        (self.known.machine_position, self.known.work_offset) = (None, None);
        self.asked = None;
        self.enter(Phase::LastLook, now);
    }

    pub(super) fn alarm(&mut self, code: u16, now: Duration) {
        let line = self.stream.unanswered().next().map(|f| f.line.source);
        self.cut_off();
        self.position_kept &= self
            .known
            .firmware
            .alarm(code)
            .is_some_and(|m| m.position_kept);
        if self.ending == Ending::Done || self.ending == Ending::Stopped {
            self.ending = Ending::Alarm {
                code,
                line,
                firmware: self.known.firmware,
            };
        }
        self.news.push(Progress::Alarm { code });
        self.news.push(Progress::Stopping(format!("ALARM:{code}")));
        self.enter(Phase::AlarmPause, now);
    }

    /// A greeting nobody asked for.
    pub(super) fn controller_reset(&mut self, now: Duration) {
        self.news
            .push(Progress::Stall(Some(Stall::ControllerReset)));
        self.ending = Ending::ControllerReset;
        self.position_kept = false;
        self.cut_off();
        self.news
            .push(Progress::Stopping("the controller restarted".to_string()));
        // Lines that were still on their way would run now, from a zero that is none.
        self.reset(now);
    }
}
