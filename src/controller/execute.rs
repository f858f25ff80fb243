//! The main loop: lines to steps, and steps carried out one after the other, each waiting for what it must wait for.

use super::complaint::error_number;
use super::eeprom::changed;
use super::intake::Line;
use super::motion::Beam;
use super::{Controller, Deaf, Mode, SAME_MOMENT, Suspend};
use crate::gcode::{Event, Motion, MotionKind, MotionMode, interpret_line};
use crate::geom::{Point, Vector};
use crate::kinematics::{Speed, chords};
use crate::units::Mm;

/// The largest part of a second the firmware can dwell by: it rounds up to whole ones, and looks at its flags between them.
pub(super) const DWELL_STEP: f64 = 0.05;
/// Computing and planning a chord of an arc takes so long, s. Fitted to recordings.
const CHORD: f64 = 0.00115;
/// What a step's interrupt takes, s. Measured on GRBL 1.1h.
const INTERRUPT: f64 = 0.00002;
/// What a look at the flags adds to it, s, on a machine that takes time to think.
const LOOK: f64 = 0.00003;
/// Looks at the flags while the spindle and the coolant come back behind a closed door: 4 s and 1 s.
pub(super) const RESUMING: (u32, u32) = (80, 20);

/// One thing to do before the line is answered.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Queue a straight block; waits while the window is full. Machine coordinates, mm.
    Block { to: Point, speed: Speed, beam: Beam },
    /// The firmware computes for so long, s, on a machine that takes time to think.
    Think(f64),
    /// What is queued may start.
    Start,
    /// Wait until all motion has ended.
    Sync,
    /// Dwell for so many looks at the flags, in Idle.
    Wait(u32),
    /// The spindle as commanded.
    Spindle { direction: i8, rpm: f64 },
    /// The coolant as commanded.
    Coolant(bool),
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
    /// The probe's pin is taken the right way round again.
    ProbeRight,
    /// Offsets are written: so many bytes.
    Write(usize),
    /// Print a line.
    Say(&'static str),
    /// Axes stand on their switches.
    Homed,
    /// The reset that leaving check mode is.
    LeaveCheck,
    /// The motors are let go, and no answer follows.
    Asleep,
    /// Answer the line.
    Ok,
}

/// How long the firmware reads a line and plans what it says, s, from its last byte to its answer. Measured on GRBL 1.1h, an Uno at
/// rest: lines of each kind, to 0.05 ms.
fn reading_time(line: &Line) -> f64 {
    let Line::Text(text) = line else {
        return 0.0001;
    };
    let count = |wanted: fn(&u8) -> bool| text.bytes().filter(wanted).count() as f64;
    let digits = count(u8::is_ascii_digit);
    let dots = count(|b| *b == b'.');
    let axes = count(|b| matches!(b, b'X'..=b'Z'));
    let codes = count(|b| matches!(b, b'G' | b'M'));
    let words = count(u8::is_ascii_uppercase);
    match text.as_bytes() {
        [] => 0.00005,
        [b'$', b'H', ..] => 0.00072,
        [b'$', b'J', ..] => 0.0005 + 0.00022 * axes + 0.0000125 * digits + 0.00003 * dots,
        [b'$', b'S', ..] => 0.00005,
        [b'$', ..] => 0.00011,
        _ if axes > 0.0 => {
            let others = words - axes - codes;
            0.00045
                + 0.000217 * axes
                + 0.00005 * codes
                + 0.00011 * others
                + 0.0000125 * digits
                + 0.00003 * dots
        }
        _ => {
            let speed = if text.contains('S') { 0.00008 } else { 0.0 };
            0.0001 + 0.00009 * words + 0.000006 * digits + speed
        }
    }
}

/// The line has axis words, so that something must be planned.
fn moves(line: &Line) -> bool {
    matches!(line, Line::Text(text) if text.contains(['X', 'Y', 'Z']))
}

impl Controller {
    /// Does all that can be done at this moment.
    pub(super) fn work(&mut self) {
        loop {
            let thinking = self.now < self.busy_until - SAME_MOMENT;
            match self.deaf {
                Deaf::ThenRestart(_) if thinking => return,
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
            self.busy_until = self.cable.blocked_until(self.now).max(self.busy_until);
            if self.now < self.busy_until - SAME_MOMENT {
                return;
            }
            // A line that is read is finished before anything else is looked at, but a motion looks first.
            if self.reading.as_ref().is_some_and(|line| !moves(line))
                && let Some(line) = self.reading.take()
            {
                self.dispatch(&line);
            }
            self.serve_flags();
            if self.suspend == Suspend::None
                && let Some(line) = self.reading.take()
            {
                self.dispatch(&line);
            }
            self.go_on_homing();
            if self.deaf != Deaf::No {
                continue;
            }
            if self.now < self.busy_until - SAME_MOMENT {
                return;
            }
            if self.suspend == Suspend::Door && !self.door_done && !self.motion.going() {
                // Spindle and coolant go off at rest.
                self.door_done = true;
                self.overrides_in = 0;
            }
            if let Suspend::DoorResuming { spindle, coolant } = self.suspend {
                self.go_on_resuming(spindle, coolant);
                continue;
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
            match self.intake.line() {
                Some(line) => {
                    self.think(reading_time(&line) * self.slowed());
                    self.reading = Some(line);
                }
                None => {
                    // The ring has run dry: what is queued may start.
                    if self.mode != Mode::Home {
                        self.motion.start();
                    }
                    return;
                }
            }
        }
    }

    /// So many times longer than at rest everything takes: each step interrupts the main loop, slow ones several times.
    fn slowed(&self) -> f64 {
        let steps_per_mm = self.memory.axes(100).into_iter().fold(0.0, f64::max);
        let steps = self.motion.speed() * steps_per_mm;
        let each = match steps {
            s if s < 2000.0 => 8.0,
            s if s < 4000.0 => 4.0,
            s if s < 8000.0 => 2.0,
            _ => 1.0,
        };
        1.0 / (1.0 - (steps * each * INTERRUPT).min(0.6))
    }

    /// A jog that has come to its end, or to rest after being cancelled, leaves Idle behind.
    fn end_of_jog(&mut self) {
        if self.mode == Mode::Jog && !self.motion.going() {
            if self.steps.iter().any(|s| matches!(s, Step::Block { .. })) {
                // A jog that waited for room survives the cancelling of those before it, and is the next one.
                if self.motion.is_holding() {
                    self.motion.abort();
                }
                return;
            }
            if !self.motion.is_empty() && !self.motion.is_holding() {
                return;
            }
            self.motion.abort();
            let here = self.motion.position();
            self.parser.set_machine_position(&here);
            self.mode = Mode::Normal;
        }
    }

    pub(super) fn dispatch(&mut self, line: &Line) {
        let text = match line {
            Line::TooLong => return self.error(11),
            Line::Text(text) => text,
        };
        if text.is_empty() {
            self.wall = None;
            return self.ok();
        }
        if text.starts_with('$') {
            self.wall = None;
            return self.dollar(text);
        }
        if matches!(self.mode, Mode::Alarm | Mode::Jog) {
            return self.error(9);
        }
        if let Some(number) = self.wall {
            return self.error(number);
        }
        match self.carry_out(text) {
            Err(number) => self.error(number),
            Ok(()) => self.steps.push_back(Step::Ok),
        }
    }

    /// Reads a line of G-code and queues what it means.
    pub(super) fn carry_out(&mut self, text: &str) -> Result<(), u16> {
        let before = Controller::stored(&self.parser);
        let tool = self.parser.tool;
        let (cut, work_offset) = (self.cuts(), self.parser.work_offset);
        self.parser_spindle = self.parser.spindle;
        let mut events = Vec::new();
        interpret_line(&mut self.parser, text, 0, &mut events)
            .map_err(|e| error_number(&e.complaint))?;
        // A laser of constant power goes dark where cutting motions end, and comes back where they begin.
        let moves = |e: &Event| matches!(e, Event::Motion(_) | Event::Probe { .. });
        let switched = self.memory.is_on(32)
            && self.parser_spindle == 1
            && cut != self.cuts()
            && self.mode != Mode::Check
            && !events.iter().any(moves);
        if switched {
            self.steps.push_back(Step::Sync);
            self.steps.push_back(self.spindle_step());
        }
        if work_offset != self.parser.work_offset {
            self.wco_in = 0;
        }
        if !self.build.quirks.tool_falls && !text.contains('T') {
            self.parser.tool = tool;
        }
        if self.mode == Mode::Check && !self.build.quirks.check_writes {
            let mut kept = self.memory.clone();
            kept.places = before;
            kept.recall(&mut self.parser);
        }
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
            self.check_limits(events);
            self.steps.push_back(Step::Offset);
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
                        beam: self.beam(),
                    });
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::ProbeEnd { strict: *strict });
                }
                Event::Dwell { time, .. } => {
                    self.steps.push_back(Step::Sync);
                    self.steps
                        .push_back(Step::Wait((time.0 / DWELL_STEP).ceil().min(65_535.0) as u32));
                }
                Event::Spindle { direction, .. } => {
                    let moves = |e: &Event| matches!(e, Event::Motion(_) | Event::Probe { .. });
                    // A laser's power changes with the motion, not between motions.
                    let with_motion = self.memory.is_on(32)
                        && *direction == self.parser_spindle
                        && events.iter().any(moves);
                    if !with_motion {
                        self.steps.push_back(Step::Sync);
                        self.steps.push_back(self.spindle_step());
                    }
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
                Event::Coolant { flood, .. } => {
                    self.steps.push_back(Step::Sync);
                    self.steps.push_back(Step::Coolant(*flood));
                }
                Event::Sync { .. } | Event::ToolChange { .. } => self.steps.push_back(Step::Sync),
            }
        }
        self.steps.push_back(Step::Offset);
    }

    /// The spindle as the line read last leaves it, for a change at a standstill. A laser stays dark unless its power does not depend
    /// on the speed and cutting motions are in force.
    fn spindle_step(&self) -> Step {
        let dark = self.memory.is_on(32) && (self.parser.spindle < 0 || !self.cuts());
        Step::Spindle {
            direction: self.parser.spindle,
            rpm: if dark { 0.0 } else { self.parser.speed.0 },
        }
    }

    /// G1, G2 or G3 is in force.
    fn cuts(&self) -> bool {
        matches!(
            self.parser.motion,
            MotionMode::Linear | MotionMode::ArcClockwise | MotionMode::ArcCounterclockwise
        )
    }

    /// What the spindle is told by the blocks of the line read last.
    fn beam(&self) -> Beam {
        let laser = self.memory.is_on(32);
        let on = self.parser.spindle != 0 && (!laser || self.cuts());
        Beam {
            rpm: if on { self.parser.speed.0 } else { 0.0 },
            follows: laser && self.parser.spindle < 0,
        }
    }

    /// The same for a jog, which leaves a laser as it is.
    pub(super) fn jog_beam(&self) -> Beam {
        let on = self.parser.spindle != 0;
        Beam {
            rpm: if on { self.parser.speed.0 } else { 0.0 },
            follows: self.memory.is_on(32) && self.parser.spindle < 0,
        }
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
        let beam = self.beam();
        match pieces {
            None => self.steps.push_back(Step::Block {
                to: motion.to + shift,
                speed,
                beam,
            }),
            Some(pieces) => {
                for p in pieces {
                    self.steps.push_back(Step::Think(CHORD));
                    self.steps.push_back(Step::Block {
                        to: p + shift,
                        speed,
                        beam,
                    });
                }
            }
        }
    }

    /// Stops at once where a target lies outside the travel, as if it were moved to.
    fn check_limits(&mut self, events: &[Event]) {
        let shift = self.parser.machine_position() - self.parser.position;
        let outside = |e: &Event| match e {
            Event::Motion(m) => self.outside(&(m.to + shift)),
            _ => false,
        };
        self.soft_limit |= self.memory.is_on(20) && events.iter().any(outside);
    }

    /// A part of a dwell.
    fn dwell_step(&mut self) {
        self.pause(DWELL_STEP);
        self.think(LOOK);
    }

    /// Behind a closed door: first the spindle, then the coolant, then the axes.
    fn go_on_resuming(&mut self, spindle: u32, coolant: u32) {
        let (all_spindle, all_coolant) = RESUMING;
        self.suspend = if spindle > 0 {
            if spindle == all_spindle {
                self.overrides_in = 0;
            }
            self.dwell_step();
            Suspend::DoorResuming {
                spindle: spindle - 1,
                coolant,
            }
        } else if coolant > 0 {
            if coolant == all_coolant {
                self.overrides_in = 0;
            }
            self.dwell_step();
            Suspend::DoorResuming {
                spindle: 0,
                coolant: coolant - 1,
            }
        } else {
            self.motion.release();
            Suspend::None
        };
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
            Step::Block { to, speed, beam } => {
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
                self.motion.push_with(to, speed, beam);
            }
            Step::Think(seconds) => {
                self.steps.pop_front();
                self.think(seconds);
                // Back to the main loop: it may have to wait.
                return true;
            }
            Step::Start => self.motion.start(),
            Step::Sync => {
                if self.probe_hit && self.motion.is_holding() && !self.motion.going() {
                    // Contact has ended the way; what is left of it is forgotten.
                    self.motion.abort();
                }
                self.motion.start();
                if self.motion.going() || !self.motion.is_empty() {
                    return false;
                }
            }
            Step::Wait(time) => match self.wait {
                None if time > 0 => {
                    self.wait = Some(time - 1);
                    self.dwell_step();
                    return true;
                }
                Some(left) if left > 0 => {
                    self.wait = Some(left - 1);
                    self.dwell_step();
                    return true;
                }
                _ => self.wait = None,
            },
            Step::Spindle { direction, rpm } => {
                (self.spindle, self.rpm) = (direction, rpm);
                self.motion.shine(Beam {
                    rpm,
                    follows: false,
                });
                self.overrides_in = 0;
            }
            Step::Coolant(flood) => {
                self.flood = flood;
                self.overrides_in = 0;
            }
            Step::Offset => self.refresh_offset(),
            Step::Pause => {
                self.steps.pop_front();
                self.suspend = Suspend::Hold;
                return true;
            }
            Step::End => {
                (self.spindle, self.flood) = (0, false);
                self.clear_overrides();
                self.wco_in = 0;
                self.say("[MSG:Pgm End]");
            }
            Step::ProbeBegin { away } => {
                self.probe_hit = false;
                self.probe_away = away;
                if self.probe_active() {
                    let here = self.motion.position();
                    self.parser.set_machine_position(&here);
                    self.steps.retain(|s| *s == Step::Ok);
                    self.steps.push_front(Step::ProbeRight);
                    self.alarm(4);
                    return true;
                }
                self.probing = Some(true);
            }
            Step::ProbeEnd { strict } => {
                self.probe_away = false;
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
            Step::ProbeRight => self.probe_away = false,
            Step::Write(bytes) => self.write_eeprom(bytes),
            Step::Say(text) => self.say(text),
            Step::Homed => {
                if self.homing.is_some() {
                    return false;
                }
                let home = self.motion.position();
                self.parser.set_machine_position(&home);
                // What was asked meanwhile is answered before the state changes.
                self.serve_flags();
                self.mode = Mode::Normal;
                self.queue_startup_lines();
            }
            Step::LeaveCheck => {
                self.steps.clear();
                if self.mode != Mode::Alarm {
                    self.mode = Mode::Normal;
                }
                self.finish_reset();
                return true;
            }
            Step::Asleep => {
                self.steps.clear();
                let idle = self.motion.idle_delay();
                self.think(idle);
                return true;
            }
            Step::Ok => self.ok(),
        }
        self.steps.pop_front();
        true
    }
}
