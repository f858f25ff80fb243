//! Limit switches, probe and buttons: what the pins read, when an axis will change that, and what the firmware does about it.

use super::{Controller, Deaf, Mode, Suspend};
use crate::gcode::State as Parser;
use crate::geom::Point;
use crate::wire::Realtime;

/// Steps are whole; this is the rounding that comparing them allows.
const ON_IT: f64 = 0.5;

impl Controller {
    /// Limit pins as wired, before `$5`.
    pub(super) fn limit_pins(&self) -> [bool; 3] {
        let place = self.counted_position();
        let steps_per_mm = self.memory.axes(100);
        let [xl, xh, yl, yh, zl, zh] = self.switches.limits;
        let ends = [(xl, xh), (yl, yh), (zl, zh)];
        std::array::from_fn(|axis| {
            let (low, high) = ends[axis];
            let steps = (place[axis] + self.bench[axis]) * steps_per_mm[axis];
            self.pins.limit[axis]
                || low.is_some_and(|at| steps <= at as f64 + ON_IT)
                || high.is_some_and(|at| steps >= at as f64 - ON_IT)
        })
    }

    /// Limit switches as the firmware understands them.
    pub(super) fn limits_active(&self) -> [bool; 3] {
        let inverted = self.memory.is_on(5);
        self.limit_pins().map(|closed| closed != inverted)
    }

    /// The probe as the firmware understands it.
    pub(super) fn probe_active(&self) -> bool {
        let steps = (self.counted_position().z + self.bench.z) * self.memory.get(102);
        let touches = self
            .switches
            .probe_z
            .is_some_and(|at| steps <= at as f64 + ON_IT);
        // While it looks for the end of a contact the firmware takes the pin the other way round, reports too.
        (self.pins.probe || touches) != (self.memory.is_on(6) != self.probe_away)
    }

    /// The safety door stands open, and the build has a pin for it.
    pub(super) fn door_ajar(&self) -> bool {
        self.build.quirks.door_pin && self.pins.door
    }

    /// Hold, reset, cycle start, door.
    pub(super) fn buttons(&self) -> [bool; 4] {
        [
            self.pins.hold,
            self.pins.reset,
            self.pins.cycle_start,
            self.door_ajar(),
        ]
    }

    /// Seconds until the axes open or close a switch.
    pub(super) fn next_switch(&self) -> Option<f64> {
        let steps_per_mm = self.memory.axes(100);
        let limits = self.switches.limits.iter().enumerate();
        let probe = (4, &self.switches.probe_z);
        limits
            .chain([probe])
            .filter_map(|(end, at)| {
                let (axis, at) = (end / 2, (*at)? as f64);
                // Closed on that very step, open on the next one.
                let open = if end % 2 == 0 { at + 1.0 } else { at - 1.0 };
                [at, open]
                    .into_iter()
                    .filter_map(|steps| {
                        let place = steps / steps_per_mm[axis] - self.bench[axis];
                        self.motion.reach(axis, place)
                    })
                    .reduce(f64::min)
            })
            .reduce(f64::min)
    }

    /// Where the axes are in whole steps.
    fn counted_position(&self) -> Point {
        let counted = self.motion.position_in_steps();
        match &self.homing {
            Some(homing) => homing.position(&counted),
            None => counted,
        }
    }

    /// Notices what has changed on the pins since the last look.
    pub(super) fn look_at_pins(&mut self) {
        let limits = self.limit_pins();
        if limits != self.limits_seen {
            self.limits_seen = limits;
            // Any change of a pin counts, opening too.
            if self.memory.is_on(21) && !matches!(self.mode, Mode::Alarm | Mode::Home) {
                self.hard_limit();
            }
        }
        let buttons = self.buttons();
        let before = std::mem::replace(&mut self.buttons_seen, buttons);
        for (index, (was, is)) in before.iter().zip(buttons).enumerate() {
            if is && !was {
                match index {
                    0 => self.flags.set(Realtime::Hold),
                    1 => _ = self.reset(),
                    2 => self.flags.set(Realtime::Resume),
                    _ => self.flags.set(Realtime::Door),
                }
            }
        }
        if let Some(wanted) = self.probing
            && self.probe_active() == wanted
        {
            self.probing = None;
            self.probe = self.motion.steps_at(&self.position());
            self.probe_hit = true;
            self.motion.hold();
        }
    }

    /// ALARM:1: the axes are cut off at once.
    fn hard_limit(&mut self) {
        if self.deaf != Deaf::No || self.dead {
            return;
        }
        self.motion.abort();
        self.probing = None;
        self.suspend = Suspend::None;
        (self.spindle, self.flood) = (0, false);
        self.alarm(1);
    }

    /// What G10, G28.1 and G30.1 keep, as stored: to see what a line has written.
    pub(super) fn stored(parser: &Parser) -> [[f64; 3]; 8] {
        let mut all = [[0.0; 3]; 8];
        for (place, offset) in all.iter_mut().zip(&parser.g5x) {
            *place = [offset.x, offset.y, offset.z];
        }
        all[6] = [parser.g28.x, parser.g28.y, parser.g28.z];
        all[7] = [parser.g30.x, parser.g30.y, parser.g30.z];
        all
    }
}
