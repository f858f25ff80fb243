//! Time passes: what is sent, what is asked, and who keeps silent.

use super::watching::Look;
use super::{Phase, Session};
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, Stall};
use crate::wire::Realtime;
use std::time::Duration;

/// No byte for this long although a report was asked for: nobody is there.
const SILENCE: Duration = Duration::from_secs(4);
/// The same once a stop is under way: then a blind reset is the lesser evil.
const STOP_SILENCE: Duration = Duration::from_secs(2);
/// It is told to stop, has not moved for this long, and still does not say that it is at rest.
const STOP_STANDS: Duration = Duration::from_secs(10);
/// No machine takes longer to stop: it does not obey.
const STOP_ENOUGH: Duration = Duration::from_secs(120);
/// GRBL is deaf for half a second after an alarm and may swallow a reset sent then.
const ALARM_DEAF: Duration = Duration::from_millis(700);
/// A question that was not answered for this long is asked again.
const ASK_AGAIN: Duration = Duration::from_secs(1);
/// A reset answers with a greeting within this time, or it is sent once more.
const RESET_WAIT: Duration = Duration::from_millis(1500);
/// Patience for the last position report.
const LAST_LOOK: Duration = Duration::from_secs(3);
/// A host that does not look at its port for this long says nothing about the controller.
const HOST_ASLEEP: Duration = Duration::from_secs(1);

impl Session {
    /// Lets time pass: sends what may be sent, asks for reports, and notices who keeps silent.
    pub fn tick(&mut self, now: Duration) {
        let away = now.saturating_sub(self.last_tick);
        self.last_tick = now;
        if away > HOST_ASLEEP && self.phase != Phase::Ended && self.phase != Phase::Introducing {
            // The controller's bytes may lie unread in this computer: silence is counted from here.
            self.last_heard = self.last_heard.max(now);
            self.asked = None;
            self.note(&format!(
                "this computer did not look at the port for {:.1} s",
                away.as_secs_f64()
            ));
        }
        match self.phase {
            Phase::Ended => return,
            Phase::Introducing => {
                self.introduction.tick(now);
                return self.introduced(now);
            }
            Phase::Streaming => {
                self.send_lines(now);
                if self.phase != Phase::Streaming {
                    return;
                }
                if now.saturating_sub(self.last_heard) > SILENCE {
                    self.news.push(Progress::Stall(Some(Stall::LinkDead)));
                    let waiting_for = "a status report";
                    let why = "the controller no longer answers";
                    self.stop(Ending::Silent { waiting_for }, why, now);
                } else {
                    self.adjust(now);
                    self.go_on(now);
                    self.notice_stall(now);
                }
            }
            Phase::Stopping { .. } => {
                let quiet = now.saturating_sub(self.last_heard.max(self.since));
                let stands = now.saturating_sub(self.moved.max(self.since)) > STOP_STANDS;
                let enough = now.saturating_sub(self.since) > STOP_ENOUGH;
                if quiet > STOP_SILENCE + self.known.round_trip * 2 || stands || enough {
                    self.note("no report that the machine is at rest: reset anyway, the position is not certain");
                    self.position_kept = false;
                    return self.reset(now);
                }
            }
            Phase::AlarmPause => {
                if now.saturating_sub(self.since) > ALARM_DEAF {
                    self.reset(now);
                }
                return;
            }
            Phase::Resetting { again } => {
                if now.saturating_sub(self.since) > RESET_WAIT + self.known.round_trip * 2 {
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
                if now.saturating_sub(self.since) > LAST_LOOK + self.known.round_trip * 2 {
                    return self.enter(Phase::Ended, now);
                }
            }
        }
        self.ask_for_a_report(now);
    }

    /// Sends what the introduction wants, and begins once it has ended.
    pub(super) fn introduced(&mut self, now: Duration) {
        let out = self.introduction.output();
        self.urgent.extend(out);
        match self.introduction.result() {
            None => {}
            Some(Ok(known)) => {
                self.known = known.clone();
                self.begin(now);
            }
            Some(Err(why)) => {
                let ending = match why {
                    crate::link::Unknown::Silent {
                        waiting_for,
                        alarm: None,
                    } => Ending::Silent { waiting_for },
                    other => Ending::NotReady(other.to_string()),
                };
                self.end(ending, now);
            }
        }
    }

    fn ask_for_a_report(&mut self, now: Duration) {
        // While the controller writes its memory every byte may cost another.
        if self.stream.writes_memory() || now < self.quiet_until {
            self.last_heard = self.last_heard.max(self.last_answer);
            return;
        }
        // While stopping we want to know soon; 10 Hz is what the firmware takes without harm.
        let pause = match self.phase {
            Phase::Streaming if !matches!(self.look, Look::Now { .. }) => self.options.poll,
            _ => self.options.poll / 2,
        };
        let overdue = self.asked.is_some()
            && now.saturating_sub(self.last_asked) > ASK_AGAIN.max(self.known.round_trip * 2);
        if overdue || (self.asked.is_none() && now.saturating_sub(self.last_asked) >= pause) {
            self.realtime(Realtime::Status);
            self.asked = Some(now);
            self.last_asked = now;
        }
    }
}
