//! Real-time commands: flags, not counters, looked at between steps.

use super::execute::RESUMING;
use super::{Controller, Deaf, Mode, NO_OVERRIDES, Suspend};
use crate::kinematics::Overrides;
use crate::wire::Realtime;

/// So long it takes to write a report, s.
const REPORT: f64 = 0.0005;
/// So long after it has noticed the door the firmware takes to be ready for what comes next, s.
const DOOR: f64 = 0.0002;

/// What has arrived since the last look. Repeats within one look are merged, as in the firmware.
#[derive(Clone, Debug, Default)]
pub(super) struct Flags(Vec<Realtime>);

impl Flags {
    pub fn set(&mut self, command: Realtime) {
        if command != Realtime::Nothing && !self.0.contains(&command) {
            self.0.push(command);
        }
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many bytes arrive at 115200 baud while these are served (measured on the real firmware; a report takes its printing).
    pub fn bytes_to_serve(&self) -> f64 {
        if self.0.contains(&Realtime::Status) {
            57.0
        } else {
            2.8
        }
    }
}

impl Flags {
    /// How long the main loop is busy with these on a timed line, s.
    fn seconds_to_serve(&self) -> f64 {
        let longest = self.0.iter().map(|flag| match flag {
            Realtime::Status => 0.0015,
            Realtime::FeedNormal
            | Realtime::FeedPlus10
            | Realtime::FeedMinus10
            | Realtime::FeedPlus1
            | Realtime::FeedMinus1
            | Realtime::RapidFull
            | Realtime::RapidHalf
            | Realtime::RapidQuarter => 0.000252,
            _ => 0.00005,
        });
        longest.fold(0.0, f64::max)
    }
}

impl Controller {
    /// Serves what has arrived, unless the firmware is deaf.
    pub(super) fn serve_flags(&mut self) {
        if self.deaf != Deaf::No || self.dead || self.flags.0.is_empty() {
            return;
        }
        if self.homing.is_some() {
            // Nothing but the door is looked at now; the rest waits.
            if self.flags.0.contains(&Realtime::Door) {
                self.flags.0.retain(|f| *f != Realtime::Door);
                self.homing_failed(7);
            }
            return;
        }
        self.think(self.flags.seconds_to_serve());
        let flags = std::mem::take(&mut self.flags.0);
        if flags.contains(&Realtime::Status) {
            self.report_status();
            self.reporting_until = if self.cable.is_timed() {
                self.now + REPORT
            } else {
                0.0
            };
        }
        for flag in &flags {
            match flag {
                Realtime::Hold => self.hold(),
                Realtime::Door => self.door(),
                // Hold and resume in one look: the hold wins.
                Realtime::Resume
                    if !flags.contains(&Realtime::Hold) && !flags.contains(&Realtime::Door) =>
                {
                    self.resume()
                }
                Realtime::JogCancel if self.mode == Mode::Jog => self.cancel_jog(),
                Realtime::SpindleStop if self.suspend == Suspend::Hold && self.spindle != 0 => {
                    if self.spindle_stopped {
                        self.say("[MSG:Restoring spindle]");
                    }
                    self.spindle_stopped = !self.spindle_stopped;
                    self.overrides_in = 0;
                }
                Realtime::Flood
                    if matches!(self.mode, Mode::Normal | Mode::Jog)
                        && matches!(self.suspend, Suspend::None | Suspend::Hold) =>
                {
                    self.flood = !self.flood;
                    self.parser.flood = self.flood;
                    self.overrides_in = 0;
                }
                _ => {}
            }
        }
        self.serve_overrides(&flags);
    }

    fn serve_overrides(&mut self, flags: &[Realtime]) {
        let before = self.percent;
        let mut touched = false;
        for flag in flags {
            let p = &mut self.percent;
            let shift = |value: u16, by: i16| value.saturating_add_signed(by).clamp(10, 200);
            match flag {
                Realtime::FeedNormal => p.feed = 100,
                Realtime::FeedPlus10 => p.feed = shift(p.feed, 10),
                Realtime::FeedMinus10 => p.feed = shift(p.feed, -10),
                Realtime::FeedPlus1 => p.feed = shift(p.feed, 1),
                Realtime::FeedMinus1 => p.feed = shift(p.feed, -1),
                Realtime::RapidFull => p.rapid = 100,
                Realtime::RapidHalf => p.rapid = 50,
                Realtime::RapidQuarter => p.rapid = 25,
                Realtime::SpindleNormal => p.spindle = 100,
                Realtime::SpindlePlus10 => p.spindle = shift(p.spindle, 10),
                Realtime::SpindleMinus10 => p.spindle = shift(p.spindle, -10),
                Realtime::SpindlePlus1 => p.spindle = shift(p.spindle, 1),
                Realtime::SpindleMinus1 => p.spindle = shift(p.spindle, -1),
                _ => continue,
            }
            touched = true;
        }
        if touched && before != self.percent {
            self.apply_overrides();
        }
    }

    /// Brings the axes in line with the override percentages.
    pub(super) fn apply_overrides(&mut self) {
        self.overrides_in = 0;
        self.motion.set_overrides(Overrides {
            feed: f64::from(self.percent.feed) / 100.0,
            rapid: f64::from(self.percent.rapid) / 100.0,
        });
    }

    /// All overrides back to 100 % (after M2, M30).
    pub(super) fn clear_overrides(&mut self) {
        if self.percent != NO_OVERRIDES {
            self.percent = NO_OVERRIDES;
            self.apply_overrides();
        }
    }

    fn hold(&mut self) {
        match self.mode {
            Mode::Jog => self.cancel_jog(),
            Mode::Normal if self.suspend == Suspend::None => {
                self.suspend = Suspend::Hold;
                if self.memory.is_on(32) && self.spindle != 0 {
                    // A standing beam would burn.
                    self.spindle_stopped = true;
                    self.overrides_in = 0;
                }
                self.motion.hold();
            }
            _ => {}
        }
    }

    fn door(&mut self) {
        if matches!(self.mode, Mode::Alarm | Mode::Check | Mode::Home) {
            return;
        }
        self.say("[MSG:Check Door]");
        self.door_until = if self.cable.is_timed() {
            self.now + DOOR
        } else {
            0.0
        };
        if self.mode == Mode::Sleep {
            return;
        }
        self.spindle_stopped = false;
        self.door_done = false;
        if self.mode == Mode::Jog {
            self.cancel_jog();
        }
        self.suspend = Suspend::Door;
        self.motion.hold();
    }

    fn resume(&mut self) {
        // Ignored until the axes stand still; the sender has to send it again.
        if self.motion.going() {
            if !self.build.quirks.resume_lost && self.suspend == Suspend::Hold {
                self.flags.set(Realtime::Resume);
            }
            return;
        }
        match self.suspend {
            Suspend::Hold => {
                self.suspend = Suspend::None;
                if std::mem::take(&mut self.spindle_stopped) {
                    self.say("[MSG:Restoring spindle]");
                    self.overrides_in = 0;
                }
                self.motion.release();
            }
            Suspend::Door => {
                if self.door_ajar() || self.now < self.door_until {
                    return;
                }
                let (spindle, coolant) = RESUMING;
                self.suspend = Suspend::DoorResuming {
                    // A laser needs no time to come up to speed.
                    spindle: spindle * u32::from(self.spindle != 0 && !self.memory.is_on(32)),
                    coolant: coolant * u32::from(self.flood),
                };
            }
            _ => {}
        }
    }

    /// Slows down and forgets the queued jogs. Lines still in the ring are not forgotten: they start new jogs.
    fn cancel_jog(&mut self) {
        self.motion.hold();
    }
}
