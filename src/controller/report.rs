//! What the controller says about itself: status reports and the answers to `$$`, `$#`, `$G`, `$I`, `$N`.

use super::execute::RESUMING;
use super::{Build, Controller, Mode, Suspend};
use crate::gcode::{Distance, FeedMode, MotionMode, Plane, Units};
use crate::wire::{Buffer, DoorPhase, Overrides, Position, State, Status};

/// A figure as the firmware prints it: it counts in single precision and rounds halves up. Negative zero becomes a plain one.
pub(super) fn as_printed(value: f64, decimals: u32) -> f64 {
    let scale = 10f32.powi(decimals as i32);
    // Two decimals at a time.
    let mut whole = value.abs() as f32;
    for _ in 0..decimals / 2 {
        whole *= 100.0;
    }
    if decimals % 2 == 1 {
        whole *= 10.0;
    }
    let whole = (whole + 0.5).floor();
    // What does not fit the firmware's integer becomes the largest there is.
    let whole = match whole < 2_147_483_648.0 {
        true => whole,
        false => return 2_147_483_648.0 / f64::from(scale),
    };
    let printed = f64::from(whole) / f64::from(scale);
    if value < 0.0 && printed > 0.0 {
        -printed
    } else {
        printed
    }
}

impl Controller {
    pub(super) fn inches(&self) -> bool {
        self.memory.is_on(13)
    }

    /// A length or speed in the unit of reports.
    fn shown(&self, mm: f64) -> f64 {
        match self.inches() {
            // Single precision, and with seven digits.
            true => f64::from(mm as f32 * 0.039_370_1),
            false => mm,
        }
    }

    fn triple(&self, v: [f64; 3]) -> String {
        // Adding zero turns a negative zero into a plain one.
        let decimals = if self.inches() { 4 } else { 3 };
        let v = v.map(|c| as_printed(self.shown(c), decimals));
        if self.inches() {
            format!("{:.4},{:.4},{:.4}", v[0], v[1], v[2])
        } else {
            format!("{:.3},{:.3},{:.3}", v[0], v[1], v[2])
        }
    }

    pub(super) fn state(&self) -> State {
        let moving = self.motion.going();
        match (self.mode, self.suspend) {
            (Mode::Sleep, _) => State::Sleep,
            (Mode::Alarm, _) => State::Alarm,
            (Mode::Check, _) => State::Check,
            (Mode::Home, _) => State::Home,
            (Mode::Jog, Suspend::Door) if moving => State::Jog,
            (_, Suspend::Door) => State::Door(match (moving, self.door_ajar()) {
                (true, _) => DoorPhase::Stopping,
                (_, true) => DoorPhase::Ajar,
                _ => DoorPhase::Closed,
            }),
            (_, Suspend::DoorResuming { .. }) => State::Door(DoorPhase::Resuming),
            (_, Suspend::Hold) => State::Hold { at_rest: !moving },
            (Mode::Jog, _) => State::Jog,
            (Mode::Normal, _) if moving => State::Run,
            (Mode::Normal, _) => State::Idle,
        }
    }

    /// The offset shown in reports follows the parser.
    pub(super) fn refresh_offset(&mut self) {
        let offset = self.parser.offset();
        let offset = [offset.x, offset.y, offset.z];
        if offset != self.offset {
            self.offset = offset;
            self.wco_in = 0;
        }
    }

    pub(super) fn report_status(&mut self) {
        let mut status = Status::new(self.state());
        // The offset of the line read last, whether or not the axes have come that far.
        let offset = self.parser.offset();
        let offset = [offset.x, offset.y, offset.z];
        let decimals = if self.inches() { 4 } else { 3 };
        let written = |mm: f64| as_printed(self.shown(mm), decimals);
        let place = self.position_in_steps();
        let steps_per_mm = self.memory.axes(100);
        // Without steps per mm a place is no number.
        let place: [f64; 3] = std::array::from_fn(|i| match steps_per_mm[i] > 0.0 {
            true => place[i],
            false => f64::NAN,
        });
        let mask = self.memory.get(10) as u32;
        status.position = Some(if mask & 1 == 1 {
            Position::Machine(place.map(written))
        } else {
            Position::Work(std::array::from_fn(|i| written(place[i] - offset[i])))
        });
        if mask & 2 == 2 {
            status.buffer = Some(Buffer {
                blocks: self.motion.free(),
                bytes: self.intake.free(),
            });
        }
        let decimals = if self.inches() { 1 } else { 0 };
        status.feed = Some(as_printed(self.shown(self.motion.speed() * 60.0), decimals));
        let rpm = self.turning_rpm();
        let turning = self.is_lit();
        status.speed = (self.build.options.variable_spindle).then(|| as_printed(rpm, 0));

        self.report_pins(&mut status);
        let busy = matches!(
            status.state,
            State::Run | State::Hold { .. } | State::Jog | State::Home | State::Door(_)
        );
        if self.wco_in > 0 {
            self.wco_in -= 1;
        } else {
            self.wco_in = if busy { 29 } else { 9 };
            // Overrides never ride in the same report as the offset: it would grow too long.
            self.overrides_in = self.overrides_in.max(1);
            let decimals = if self.inches() { 4 } else { 3 };
            status.work_offset = Some(offset.map(|c| as_printed(self.shown(c), decimals)));
        }
        if self.overrides_in > 0 {
            self.overrides_in -= 1;
        } else {
            self.overrides_in = if busy { 19 } else { 9 };
            let p = self.percent;
            status.overrides = Some(Overrides {
                feed: p.feed,
                rapid: p.rapid,
                spindle: p.spindle,
            });
            if turning {
                status
                    .accessories
                    .push(if self.spindle > 0 { 'S' } else { 'C' });
            }
            let resuming = matches!(self.suspend, Suspend::DoorResuming { coolant, .. } if coolant == RESUMING.1);
            if self.flood && !self.behind_door() && !resuming {
                status.accessories.push('F');
            }
        }
        let line = status.write(self.inches());
        self.say(&line);
    }

    /// What the spindle turns with now, overridden and clamped; in laser mode, the beam.
    fn turning_rpm(&self) -> f64 {
        let off = self.spindle == 0 || self.spindle_stopped_now() || self.behind_door();
        let rpm = self.rpm * f64::from(self.percent.spindle) / 100.0;
        let (least, most) = (self.memory.get(31), self.memory.get(30));
        match off {
            true => 0.0,
            false if least >= most || rpm >= most => most,
            false if rpm <= 0.0 => 0.0,
            false => rpm.max(least),
        }
    }

    /// The spindle is told to turn, be it at a speed of nothing.
    fn is_lit(&self) -> bool {
        let off = self.spindle == 0 || self.spindle_stopped_now() || self.behind_door();
        let (least, most) = (self.memory.get(31), self.memory.get(30));
        let told = match self.memory.is_on(32) {
            true => self.motion.shining().rpm,
            false => self.rpm,
        };
        !off && (told > 0.0 || least >= most)
    }

    /// The axes rest behind an open door.
    fn behind_door(&self) -> bool {
        self.suspend == Suspend::Door && !self.motion.going()
    }

    fn spindle_stopped_now(&self) -> bool {
        self.spindle_stopped && !self.motion.going()
    }

    fn report_pins(&self, status: &mut Status) {
        let [x, y, z] = self.limits_active();
        let pins = [
            (self.probe_active(), 'P'),
            (x, 'X'),
            (y, 'Y'),
            (z, 'Z'),
            (self.door_ajar(), 'D'),
            (self.pins.hold, 'H'),
            (self.pins.reset, 'R'),
            (self.pins.cycle_start, 'S'),
        ];
        status.pins.extend(pins.iter().filter(|p| p.0).map(|p| p.1));
    }

    pub(super) fn report_modes(&mut self) {
        let p = &self.parser;
        let motion = match p.motion {
            MotionMode::Rapid => "G0",
            MotionMode::Linear => "G1",
            MotionMode::ArcClockwise => "G2",
            MotionMode::ArcCounterclockwise => "G3",
            MotionMode::None | MotionMode::Cycle(_) => "G80",
            MotionMode::Probe(probe) => match (probe.away, probe.strict) {
                (false, true) => "G38.2",
                (false, false) => "G38.3",
                (true, true) => "G38.4",
                (true, false) => "G38.5",
            },
        };
        let plane = match p.plane {
            Plane::Xy => "G17",
            Plane::Zx => "G18",
            Plane::Yz => "G19",
        };
        let units = if p.units == Units::Inch { "G20" } else { "G21" };
        let distance = if p.distance == Distance::Absolute {
            "G90"
        } else {
            "G91"
        };
        let feed_mode = if p.feed_mode == FeedMode::PerMinute {
            "G94"
        } else {
            "G93"
        };
        let spindle = match p.spindle {
            0 => "M5",
            1 => "M3",
            _ => "M4",
        };
        let coolant = if p.flood { "M8" } else { "M9" };
        let feed = if self.inches() {
            format!("{:.1}", as_printed(self.shown(p.feed.0), 1))
        } else {
            format!("{:.0}", as_printed(p.feed.0, 0))
        };
        let line = format!(
            "[GC:{motion} G{} {plane} {units} {distance} {feed_mode} {spindle} {coolant} T{} F{feed} S{:.0}]",
            54 + p.work_offset,
            p.tool,
            as_printed(p.speed.0, 0)
        );
        self.say(&line);
    }

    pub(super) fn report_offsets(&mut self) {
        for i in 0..6 {
            let o = self.parser.g5x.get(i).copied().unwrap_or_default();
            let line = format!("[G{}:{}]", 54 + i, self.triple([o.x, o.y, o.z]));
            self.say(&line);
        }
        let (a, b, s) = (self.parser.g28, self.parser.g30, self.parser.g92);
        for (name, v) in [
            ("G28", [a.x, a.y, a.z]),
            ("G30", [b.x, b.y, b.z]),
            ("G92", [s.x, s.y, s.z]),
        ] {
            let line = format!("[{name}:{}]", self.triple(v));
            self.say(&line);
        }
        let tlo = self.shown(self.parser.tlo);
        let line = if self.inches() {
            format!("[TLO:{tlo:.4}]")
        } else {
            format!("[TLO:{tlo:.3}]")
        };
        self.say(&line);
        self.report_probe();
    }

    pub(super) fn report_probe(&mut self) {
        let line = format!(
            "[PRB:{}:{}]",
            self.triple([self.probe.x, self.probe.y, self.probe.z]),
            u8::from(self.probe_hit)
        );
        self.say(&line);
    }

    pub(super) fn report_build(&mut self) {
        let Build {
            blocks,
            rx_bytes,
            profile,
            options,
            ..
        } = self.build;
        for line in profile.build_info(&self.memory.build_text, blocks, rx_bytes, &options) {
            self.say(&line);
        }
    }
}
