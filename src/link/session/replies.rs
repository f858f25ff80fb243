//! What each reply means to a session in each of its phases.

use super::{MODES, Phase, QUESTIONS, Session};
use crate::link::job::JobLine;
use crate::link::outcome::Ending;
use crate::link::progress::{Progress, Report};
use crate::link::stream::{Receipt, Stream};
use crate::wire::{DoorPhase, Position, Realtime, Reply, State, Status};
use std::time::Duration;

impl Session {
    pub(super) fn reply(&mut self, reply: &Reply, now: Duration) {
        if let Reply::Status(status) = reply {
            self.report(status, now);
        }
        if let Reply::Message(text) = reply {
            self.note(&format!("controller: {text}"));
        }
        if reply.answers_a_line() && self.swallow > 0 {
            self.swallow -= 1;
            return;
        }
        match self.phase.clone() {
            Phase::Greeting => {
                if let Reply::Welcome { firmware, version, .. } = reply {
                    self.version = format!("{firmware} {version}");
                    self.enter(Phase::Asking, now);
                }
            }
            Phase::Asking => match reply {
                Reply::Status(status) => self.first_look(&status.state, now),
                Reply::Welcome { firmware, version, .. } => {
                    self.version = format!("{firmware} {version}")
                }
                _ => {}
            },
            Phase::Questions(index) => self.hear_answer(index, reply, now),
            Phase::Streaming => self.while_streaming(reply, now),
            Phase::Stopping { quiet_reports } => match reply {
                Reply::Status(status) => self.coming_to_rest(&status.state, quiet_reports, now),
                Reply::Alarm(code) => self.alarm(*code, now),
                Reply::Welcome { .. } => self.last_look(now),
                _ => {
                    // Answers still count: the report says how many lines the controller took.
                    if let Some(stream) = &mut self.stream {
                        stream.receive(reply);
                    }
                }
            },
            // From the reset to the greeting no answer counts: the controller may still let go of one stray `ok`.
            Phase::AlarmPause | Phase::Resetting { .. } => match reply {
                Reply::Alarm(_) => self.moved_under_reset(),
                Reply::Welcome { .. } => self.last_look(now),
                _ => {}
            },
            Phase::LastLook => {
                if let Reply::Status(_) = reply
                    && self.position.is_some()
                {
                    self.enter(Phase::Ended, now);
                }
            }
            Phase::Ended => {}
        }
    }

    fn report(&mut self, status: &Status, now: Duration) {
        self.asked = None;
        if status.work_offset.is_some() {
            self.work_offset = status.work_offset;
        }
        let unit = if self.inches { 25.4 } else { 1.0 };
        self.position = match (status.position, self.work_offset) {
            (Some(Position::Work(p)), _) => Some(p.map(|c| c * unit)),
            (Some(Position::Machine(p)), Some(o)) => {
                Some([p[0] - o[0], p[1] - o[1], p[2] - o[2]].map(|c| c * unit))
            }
            _ => None,
        };
        if status.state == State::Idle {
            self.idle_since.get_or_insert(now);
        } else {
            self.idle_since = None;
        }
        if status.state == State::Run && self.phase == Phase::Streaming {
            self.first_motion.get_or_insert(now);
        }
        self.state = Some(status.state.clone());
        if let (Some(stream), Phase::Streaming | Phase::Stopping { .. }) =
            (&self.stream, &self.phase)
        {
            self.news.push(Progress::Report(Box::new(Report {
                sent: stream.sent(),
                acknowledged: stream.acknowledged(),
                total: stream.total(),
                source: stream.unanswered().first().map_or(0, |l| l.source),
                state: status.state.clone(),
                position: self.position,
                machine_position: None,
                feed: status.feed.map(|f| f * unit),
                speed: status.speed,
                overrides: status.overrides,
                accessories: status.accessories.clone(),
                pins: status.pins.clone(),
                buffer: status.buffer,
                in_flight: stream.in_flight(),
            })));
        }
    }

    fn first_look(&mut self, state: &State, now: Duration) {
        let why = match state {
            State::Idle => {
                self.enter(Phase::Questions(0), now);
                return self.question(0);
            }
            State::Alarm => {
                "the controller is locked by an alarm: home it with $H, or unlock it with $X if you know where it is, then send again"
                    .to_string()
            }
            State::Check => "the controller is in check mode, where nothing moves: send $C to leave it".to_string(),
            State::Sleep => "the controller is asleep: reset it".to_string(),
            other => format!("the controller is not idle but says {}: wait until it is, or reset it", other.text()),
        };
        self.ending = Ending::NotReady(why);
        self.enter(Phase::Ended, now);
    }

    fn question(&mut self, index: usize) {
        if let Some(text) = QUESTIONS.get(index) {
            self.out.extend_from_slice(text.as_bytes());
            self.out.push(b'\n');
        }
    }

    fn hear_answer(&mut self, index: usize, reply: &Reply, now: Duration) {
        match reply {
            Reply::Options(build) => self.build = build.clone(),
            Reply::Version(version) => self.version = version.clone(),
            Reply::Modes(modes) => self.modes = modes.to_string(),
            Reply::Setting { number, value } => {
                if let Ok(value) = value.trim().parse::<f64>() {
                    self.settings.push((*number, value));
                    self.inches |= *number == 13 && value != 0.0;
                }
            }
            Reply::Alarm(code) => self.alarm(*code, now),
            // A late greeting: the controller was reset by opening the port after all. Its answers so far are void.
            Reply::Welcome { .. } => {
                self.settings.clear();
                self.enter(Phase::Asking, now);
            }
            Reply::Ok | Reply::Error(_) => {
                if index + 1 < QUESTIONS.len() {
                    self.enter(Phase::Questions(index + 1), now);
                    self.question(index + 1);
                } else {
                    self.start(now);
                }
            }
            _ => {}
        }
    }

    fn start(&mut self, now: Duration) {
        let rx_bytes = self.build.rx.unwrap_or(self.options.rx_bytes);
        let mut known = crate::link::Introduction::new(crate::link::IntroductionOptions::default(), now).known().clone();
        known.version.clone_from(&self.version);
        known.rx_bytes = rx_bytes;
        self.news.push(Progress::Connected(Box::new(known)));
        for (number, promised) in self.options.settings.clone() {
            match self.settings.iter().find(|s| s.0 == number) {
                Some((_, actual)) if (actual - promised).abs() > 1e-3 + promised.abs() * 1e-3 => self.note(&format!(
                    "${number} is {actual} on the controller, {promised} in the machine file: time and limits will differ"
                )),
                _ => {}
            }
        }
        if self.settings.contains(&(32, 1.0)) {
            self.note("laser mode is on ($32=1): spindle speed changes behave differently");
        }
        let mut lines = std::mem::take(&mut self.job);
        let active: Vec<&str> = self.modes.split_whitespace().collect();
        if MODES.iter().any(|m| !active.contains(m)) {
            self.note(&format!(
                "the controller's modes were {}; the job starts from {}",
                self.modes,
                MODES.join(" ")
            ));
            lines.insert(0, JobLine::own(&MODES.concat()));
            self.total += 1;
        }
        match Stream::new(lines, rx_bytes) {
            Ok(stream) => {
                self.news.push(Progress::Started {
                    total: stream.total(),
                });
                self.stream = Some(stream);
                self.last_answer = now;
                self.enter(Phase::Streaming, now);
            }
            Err(e) => {
                self.ending = Ending::Unstreamable(e);
                self.enter(Phase::Ended, now);
            }
        }
    }

    fn while_streaming(&mut self, reply: &Reply, now: Duration) {
        match reply {
            Reply::Alarm(code) => return self.alarm(*code, now),
            Reply::Welcome { .. } => {
                self.ending = Ending::ControllerReset;
                self.position_kept = false;
                if let Some(stream) = &mut self.stream {
                    stream.interrupt();
                }
                return self.last_look(now);
            }
            _ => {}
        }
        let Some(stream) = &mut self.stream else {
            return;
        };
        match stream.receive(reply) {
            Receipt::Accepted(_) => self.last_answer = now,
            Receipt::Refused { index, code } => {
                let (line, text) = stream
                    .line(index)
                    .map_or((0, String::new()), |l| (l.source, l.text.clone()));
                self.stop(
                    Ending::Refused { line, text, code },
                    "the controller refused a line",
                    now,
                );
            }
            Receipt::Unasked => self.note("an answer no line was waiting for: noise on the cable?"),
            Receipt::Push => {
                if stream.is_complete() {
                    self.finish(now);
                } else if let Reply::Status(status) = reply {
                    self.holding(&status.state);
                }
            }
        }
    }

    /// A hold we did not ask for is told once; a resume that came too early is made good.
    fn holding(&mut self, state: &State) {
        let held = matches!(
            state,
            State::Hold { at_rest: true } | State::Door(DoorPhase::Closed | DoorPhase::Ajar)
        );
        if !held {
            // Once it was told, a report without a hold means that somebody else resumed; before that, it is merely older than the hold.
            if std::mem::take(&mut self.pause_told) {
                self.hold_asked = false;
            }
            return;
        }
        if self.resume_wanted {
            self.resume_if_at_rest();
        } else if !self.pause_told {
            self.pause_told = true;
            let m0 = self
                .stream
                .as_ref()
                .and_then(|s| s.unanswered().iter().find(|l| is_pause(&l.text)));
            let why = match (state, m0, self.hold_asked) {
                (State::Door(_), ..) => "safety door: close it, then resume".to_string(),
                (_, Some(line), false) => format!(
                    "the program pauses at line {} ({}): resume when ready",
                    line.source, line.text
                ),
                (_, _, true) => "on hold, at rest: resume or stop".to_string(),
                _ => "the machine is on hold, but not by us (a button, or noise): resume or stop"
                    .to_string(),
            };
            self.news.push(Progress::Paused(why));
        }
    }

    pub(super) fn resume_if_at_rest(&mut self) {
        // `~` is ignored while the hold is still slowing down, so it waits for the report that it has come to rest.
        if matches!(
            self.state,
            Some(State::Hold { at_rest: true } | State::Door(DoorPhase::Closed))
        ) {
            self.resume_wanted = false;
            self.hold_asked = false;
            self.pause_told = false;
            self.realtime(Realtime::Resume);
        }
    }

    fn finish(&mut self, now: Duration) {
        if let Some(reported) = self.position {
            let expected: [f64; 3] = std::array::from_fn(|i| self.end[i].unwrap_or(reported[i]));
            if (0..3).any(|i| (expected[i] - reported[i]).abs() > self.options.end_tolerance) {
                self.ending = Ending::Elsewhere { expected, reported };
            }
            self.enter(Phase::Ended, now);
        }
        // Without a position yet (the offset comes only every so many reports) the next report decides.
    }

    fn coming_to_rest(&mut self, state: &State, quiet_reports: u32, now: Duration) {
        // One Idle may be older than our hold; two in a row are not. `Hold:0` says it all.
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
        if matches!(state, State::Run | State::Jog)
            && now - self.last_hold_sent > Duration::from_millis(500)
        {
            self.realtime(Realtime::Hold);
            self.last_hold_sent = now;
        }
    }

    pub(super) fn alarm(&mut self, code: u16, now: Duration) {
        let line = self
            .stream
            .as_ref()
            .and_then(|s| s.unanswered().first())
            .map(|l| l.source);
        if let Some(stream) = &mut self.stream {
            stream.interrupt();
        }
        self.position_kept &= crate::wire::alarm_meaning(code).is_some_and(|m| m.position_kept);
        if self.ending == Ending::Done || self.ending == Ending::Stopped {
            self.ending = Ending::Alarm { code, line };
        }
        self.news.push(Progress::Stopping(format!("ALARM:{code}")));
        self.enter(Phase::AlarmPause, now);
    }
}

fn is_pause(text: &str) -> bool {
    text.ends_with("M0") || text.ends_with("M00")
}
