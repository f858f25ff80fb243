//! The main loop: lines to steps, and steps carried out one after the other, each waiting for what it must wait for.

use super::complaint::error_number;
use super::eeprom::changed;
use super::intake::Line;
use super::{Controller, Deaf, Mode, SAME_MOMENT, Suspend};
use crate::gcode::{Event, Motion, MotionKind, interpret_line};
use crate::geom::{Point, Vector};
use crate::kinematics::{Speed, chords};
use crate::units::Mm;

/// The largest part of a second the firmware can dwell by: it rounds up to whole ones.
const DWELL_STEP: f64 = 0.05;

/// One thing to do before the line is answered.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Queue a straight block; waits while the window is full. Machine coordinates, mm.
    Block { to: Point, speed: Speed },
    /// Wait until all motion has ended.
    Sync,
    /// Wait so many seconds, in Idle.
    Wait(f64),
    /// The spindle as commanded.
    Spindle { direction: i8, rpm: f64 },
    /// Reports show the new work offset.
    Offset,
    /// M0.
    Pause,
    /// M2, M30.
    End,
    /// The probe is looked at before it moves.
    ProbeBegin { away: bool },
    /// A probe's way has ended, with contact or without.
    ProbeEnd { strict: bool },
    /// The place of the last contact is shown.
    ProbeShow,
    /// Offsets are written: so many bytes.
    Write(usize),
    /// Print a line.
    Say(&'static str),
    /// Axes stand on their switches.
    Homed,
    /// The reset that leaving check mode is.
    LeaveCheck,
    /// Swallows the `ok` that follows.
    NoMoreOk,
    /// Answer the line.
    Ok,
}

/// How long the firmware reads a line and plans what it says, s. Fitted to recordings of the real one.
fn reading_time(line: &Line) -> f64 {
    match line {
        Line::Text(text) if !text.is_empty() => 0.0013 + 0.0001 * text.len() as f64,
        _ => 0.0002,
    }
}

impl Controller {
    /// Does all that can be done at this moment.
    pub(super) fn work(&mut self) {
        loop {
            match self.deaf {
                Deaf::Until(t) if self.now >= t - SAME_MOMENT => {
                    self.deaf = Deaf::No;
                    if self.dead {
                        self.say("[MSG:Reset to continue]");
                    }
                }
                Deaf::ThenRestart(t) if self.now >= t - SAME_MOMENT => self.finish_reset(),
                Deaf::No => {}
                _ => return,
            }
            if self.dead {
                return;
            }
            self.look_at_pins();
            if self.deaf != Deaf::No || self.dead {
                continue;
            }
            if self.cable.is_timed() {
                self.busy_until = self.cable.blocked_until(self.now).max(self.busy_until);
                if self.now < self.busy_until - SAME_MOMENT {
                    return;
                }
            }
            self.serve_flags();
            if self.homing.is_some() {
                self.go_on_homing();
            }
            if let Suspend::DoorResuming(t) = self.suspend
                && self.now >= t - SAME_MOMENT
            {
                self.suspend = Suspend::None;
                self.motion.release();
            }
            self.end_of_jog();
            if self.suspend != Suspend::None || self.mode == Mode::Sleep && self.steps.is_empty() {
                return;
            }
            if self.soft_limit {
                if self.motion.going() {
                    return;
                }
                self.soft_limit = false;
                self.motion.abort();
                return self.alarm(2);
            }
            if !self.steps.is_empty() {
                if !self.step() {
                    return;
                }
                continue;
            }
            if let Some(line) = self.reading.take() {
                self.dispatch(&line);
                continue;
            }
            match self.intake.line() {
                Some(line) => {
                    self.think(reading_time(&line));
                    self.reading = Some(line);
                }
                None => {
                    // The ring has run dry: what is queued may start.
                    self.motion.start();
                    return;
                }
            }
        }
    }

    /// A jog that has come to its end, or to rest after being cancelled, leaves Idle behind.
    fn end_of_jog(&mut self) {
        if self.mode == Mode::Jog
            && !self.motion.going()
            && !self.steps.iter().any(|s| matches!(s, Step::Block { .. }))
        {
            if !self.motion.is_empty() && !self.motion.is_holding() {
                return;
            }
            self.motion.abort();
            let here = self.motion.position();
            self.parser.set_machine_position(&here);
            self.mode = Mode::Normal;
        }
    }

    fn dispatch(&mut self, line: &Line) {
        let text = match line {
            Line::TooLong => return self.error(11),
            Line::Text(text) => text,
        };
        if text.is_empty() {
            return self.ok();
        }
        if text.starts_with('$') {
            return self.dollar(text);
        }
        if matches!(self.mode, Mode::Alarm | Mode::Jog) {
            return self.error(9);
        }
        match self.carry_out(text) {
            Err(number) => self.error(number),
            Ok(()) => self.steps.push_back(Step::Ok),
        }
    }

    /// Reads a line of G-code and queues what it means.
    pub(super) fn carry_out(&mut self, text: &str) -> Result<(), u16> {
        let before = Controller::stored(&self.parser);
        let mut events = Vec::new();
        interpret_line(&mut self.parser, text, 0, &mut events)
            .map_err(|e| error_number(&e.complaint))?;
        self.queue_events(&events);
        let after = Controller::stored(&self.parser);
        let pairs = before.iter().flatten().zip(after.iter().flatten());
        let bytes: usize = pairs.map(|(b, a)| changed(*b, *a)).sum();
        if bytes > 0 {
            // One more for the checksum.
            self.steps.push_back(Step::Write(bytes + 1));
        }
        Ok(())
    }

    /// Turns what a line means into steps.
    pub(super) fn queue_events(&mut self, events: &[Event]) {
        if self.mode == Mode::Check {
            if events.iter().any(|e| matches!(e, Event::End { .. })) {
                self.steps.push_back(Step::Say("[MSG:Pgm End]"));
            }
            return;
        }
        // The parser already stands at the end of the line. No motion of a line sees an offset change, so one difference between
        // machine and work coordinates serves them all.
        let machine = self.parser.machine_position();
        let last = events.iter().rev().find_map(|e| match e {
            Event::Motion(m) | Event::Probe { motion: m, .. } => Some(m.to),
            _ => None,
        });
        let shift = last.map_or_else(Default::default, |to| machine - to);
        for event in events {
            match event {
                Event::Motion(m) => self.queue_motion(m, &shift),
                Event::Probe {
                    motion,
                    strict,
                    away,
                } => {
                    let to = motion.to + shift;
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::ProbeBegin { away: *away });
                    self.steps.push_back(Step::Block {
                        to,
                        speed: Speed::Fixed(motion.feed),
                    });
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::ProbeEnd { strict: *strict });
                }
                Event::Dwell { time, .. } => {
                    self.steps.push_back(Step::Sync);
                    self.steps
                        .push_back(Step::Wait((time.0 / DWELL_STEP).ceil() * DWELL_STEP));
                }
                Event::Spindle {
                    direction, speed, ..
                } => {
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::Spindle {
                        direction: *direction,
                        rpm: speed.0,
                    });
                }
                Event::Pause { optional: true, .. } => {}
                Event::Pause { .. } => {
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::Pause);
                }
                Event::End { .. } => {
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::End);
                }
                Event::Coolant { .. } | Event::Sync { .. } | Event::ToolChange { .. } => {
                    self.steps.push_back(Step::Sync)
                }
            }
        }
        self.steps.push_back(Step::Offset);
    }

    fn queue_motion(&mut self, motion: &Motion, shift: &Vector) {
        let pieces = match &motion.arc {
            None => None,
            Some(arc) => Some(chords(
                &motion.from,
                &motion.to,
                arc,
                Mm(self.memory.get(12)),
            )),
        };
        let speed = match (motion.kind, motion.inverse_time) {
            (MotionKind::Rapid, _) => Speed::Rapid,
            // The block's time is shared by its pieces.
            (_, true) => Speed::InverseTime(
                motion.feed.0 * pieces.as_ref().map_or(1.0, |p| f64::from(p.chord_count())),
            ),
            (_, false) => Speed::Feed(motion.feed),
        };
        match pieces {
            None => self.steps.push_back(Step::Block {
                to: motion.to + shift,
                speed,
            }),
            Some(pieces) => {
                self.steps.extend(pieces.map(|p| Step::Block {
                    to: p + shift,
                    speed,
                }));
            }
        }
    }

    /// True when a machine position is outside the travel, which lies on the negative side of zero.
    pub(super) fn outside(&self, p: &Point) -> bool {
        let travel = self.memory.axes(130);
        (0..3).any(|i| p[i] > 0.0 || p[i] < -travel[i])
    }

    /// Carries out the first step. False when it has to wait.
    fn step(&mut self) -> bool {
        let Some(step) = self.steps.front().cloned() else {
            return false;
        };
        match step {
            Step::Block { to, speed } => {
                if self.memory.is_on(20) && self.outside(&to) {
                    self.motion.hold();
                    self.soft_limit = true;
                    // The line's answer survives until the reset.
                    self.steps.retain(|s| *s == Step::Ok);
                    return true;
                }
                if self.motion.free() == 0 {
                    self.motion.start();
                    return false;
                }
                self.motion.push(to, speed);
            }
            Step::Sync => {
                self.motion.start();
                if self.motion.going() || !self.motion.is_empty() {
                    return false;
                }
            }
            Step::Wait(time) => match self.wait {
                None => {
                    self.wait = Some(self.now + time);
                    return time <= 0.0;
                }
                Some(t) if self.now < t - SAME_MOMENT => return false,
                Some(_) => self.wait = None,
            },
            Step::Spindle { direction, rpm } => {
                self.spindle = direction;
                let (least, most) = (self.memory.get(31), self.memory.get(30));
                self.rpm = if rpm > 0.0 {
                    rpm.max(least).min(most.max(least))
                } else {
                    0.0
                };
                self.overrides_in = 0;
            }
            Step::Offset => self.refresh_offset(),
            Step::Pause => {
                self.steps.pop_front();
                self.suspend = Suspend::Hold;
                return true;
            }
            Step::End => {
                self.spindle = 0;
                self.clear_overrides();
                self.say("[MSG:Pgm End]");
            }
            Step::ProbeBegin { away } => {
                self.probe_hit = false;
                if self.probe_active() != away {
                    let here = self.motion.position();
                    self.parser.set_machine_position(&here);
                    self.steps.retain(|s| *s == Step::Ok);
                    self.alarm(4);
                    return true;
                }
                self.probing = Some(!away);
            }
            Step::ProbeEnd { strict } => {
                let missed = self.probing.take().is_some();
                let here = self.motion.position();
                self.motion.abort();
                self.parser.set_machine_position(&here);
                self.steps.pop_front();
                self.steps.push_front(Step::ProbeShow);
                if missed && strict {
                    // The place of the last contact stays as it was, and is shown behind the alarm.
                    self.alarm(5);
                } else if missed {
                    self.probe = self.motion.steps_at(&here);
                }
                return true;
            }
            Step::ProbeShow => self.report_probe(),
            Step::Write(bytes) => self.write_eeprom(bytes),
            Step::Say(text) => self.say(text),
            Step::Homed => {
                if self.homing.is_some() {
                    return false;
                }
                let home = self.motion.position();
                self.parser.set_machine_position(&home);
                self.mode = Mode::Normal;
                self.queue_startup_lines();
            }
            Step::LeaveCheck => {
                self.steps.clear();
                self.mode = Mode::Normal;
                self.finish_reset();
                return true;
            }
            Step::NoMoreOk => {
                self.steps.clear();
                return true;
            }
            Step::Ok => self.ok(),
        }
        self.steps.pop_front();
        true
    }
}
