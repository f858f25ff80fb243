//! `$H`: Z first, then X and Y together; seek, pull off, locate, pull off.
//!
//! While it looks for its switches the firmware counts each leg from zero; only at the end are the axes told where they stand.
//! Lengths mm, machine coordinates.

use super::execute::Step;
use super::{Controller, DEAF, Deaf, Mode, SAME_MOMENT};
use crate::geom::{Point, Vector};
use crate::kinematics::Speed;
use crate::units::MmPerMin;

/// Seeking goes on for so many times the longest travel.
const SEEK: f64 = 1.5;
/// Locating goes on for so many times the pull-off.
const LOCATE: f64 = 5.0;
/// How far apart the switches of an axis with two motors may be met: a share of the travel, at least and at most so many mm
/// (GRBL's config.h, dual axis).
const ASKEW: f64 = 0.05;
const LEAST_ASKEW: f64 = 2.5;
const MOST_ASKEW: f64 = 25.0;
/// The axes of each cycle, one cycle after the other.
const CYCLES: [[bool; 3]; 2] = [[false, false, true], [true, true, false]];
/// Legs of a cycle: to the switch, off it, to it slowly, off it.
const LEGS: u8 = 4;

/// A homing cycle under way.
#[derive(Clone, Debug)]
pub(super) struct Homing {
    cycle: usize,
    leg: u8,
    /// Axes that have met their switch stand here while others go on.
    stopped: [Option<f64>; 3],
    /// Switches may bounce until then.
    until: Option<f64>,
}

impl Homing {
    /// Where the axes are when the motion would have them there.
    pub fn position(&self, of_motion: &Point) -> Point {
        let mut place = *of_motion;
        for (axis, stopped) in self.stopped.iter().enumerate() {
            if let Some(at) = stopped {
                place[axis] = *at;
            }
        }
        place
    }

    /// When it goes on by itself.
    pub fn wakes(&self) -> Option<f64> {
        self.until
    }

    fn axes(&self) -> [bool; 3] {
        CYCLES.get(self.cycle).copied().unwrap_or_default()
    }

    /// This leg ends at the switches.
    fn approaches(&self) -> bool {
        self.leg.is_multiple_of(2)
    }
}

impl Controller {
    /// Starts looking for the switches. The line's answer waits behind [`Step::Homed`].
    pub(super) fn begin_homing(&mut self) {
        self.mode = Mode::Home;
        self.homing = Some(Homing {
            cycle: 0,
            leg: 0,
            stopped: [None; 3],
            until: None,
        });
        self.steps.push_back(Step::Homed);
        self.begin_leg();
    }

    fn begin_leg(&mut self) {
        let Some(homing) = &mut self.homing else {
            return;
        };
        homing.stopped = [None; 3];
        let (axes, leg, approach) = (homing.axes(), homing.leg, homing.approaches());
        let travel = self.memory.axes(130);
        let longest = (0..3)
            .filter(|&i| axes[i])
            .map(|i| travel[i])
            .fold(0.0, f64::max);
        let pull_off = self.memory.get(27);
        let way = match leg {
            0 => SEEK * longest,
            2 => LOCATE * pull_off,
            _ => pull_off,
        };
        let rate = self.memory.get(if leg == 2 { 24 } else { 25 });
        let count = axes.iter().filter(|a| **a).count() as f64;
        let negative = self.memory.get(23) as u32;
        let mut zero = self.motion.position();
        let mut to = zero;
        for axis in (0..3).filter(|&i| axes[i]) {
            let toward = if negative >> axis & 1 == 1 { -1.0 } else { 1.0 };
            zero[axis] = 0.0;
            to[axis] = if approach {
                toward * way
            } else {
                -toward * way
            };
        }
        self.declare(zero);
        self.motion
            .push(to, Speed::Fixed(MmPerMin(rate * count.sqrt())));
        self.motion.start();
    }

    /// Goes on with homing as far as can be at this moment.
    pub(super) fn go_on_homing(&mut self) {
        loop {
            let limits = self.limits_active();
            let place = self.motion.position();
            let (now, bounce) = (self.now, self.memory.get(26) / 1000.0);
            let second = self.build.options.second_y_switch_um;
            let second = second.map(|um| f64::from(um) / 1000.0);
            let allowed = (ASKEW * self.memory.get(131)).clamp(LEAST_ASKEW, MOST_ASKEW);
            let Some(homing) = &mut self.homing else {
                return;
            };
            if let Some(until) = homing.until {
                if now < until - SAME_MOMENT {
                    return;
                }
                homing.until = None;
                homing.leg += 1;
                if homing.leg == LEGS {
                    self.end_cycle();
                } else {
                    self.begin_leg();
                }
                continue;
            }
            let axes = homing.axes();
            let done = if homing.approaches() {
                for axis in (0..3).filter(|&i| axes[i] && limits[i]) {
                    homing.stopped[axis].get_or_insert(place[axis]);
                }
                if homing.leg == 0
                    && axes[1]
                    && limits[1]
                    && second.is_some_and(|gap| gap > allowed)
                {
                    // One side has arrived and the other is still under way: the gantry stands askew.
                    return self.homing_failed(10);
                }
                let all = (0..3).all(|i| !axes[i] || homing.stopped[i].is_some());
                if !all && !self.motion.moving() && self.motion.is_empty_but_rest() {
                    return self.homing_failed(9);
                }
                all
            } else {
                let over = !self.motion.moving() && self.motion.is_empty_but_rest();
                if over && (0..3).any(|i| axes[i] && limits[i]) {
                    return self.homing_failed(8);
                }
                over
            };
            if !done {
                return;
            }
            let real = homing.position(&place);
            homing.until = Some(now + bounce);
            self.motion.abort();
            self.motion.set_position(real);
        }
    }

    /// The axes of this cycle stand at their home.
    fn end_cycle(&mut self) {
        let Some(homing) = &mut self.homing else {
            return;
        };
        let axes = homing.axes();
        homing.stopped = [None; 3];
        homing.cycle += 1;
        homing.leg = 0;
        let over = homing.cycle >= CYCLES.len();
        let home = self.homed_position();
        let mut place = self.motion.position();
        for axis in (0..3).filter(|&i| axes[i]) {
            place[axis] = home[axis];
        }
        self.declare(place);
        match over {
            true => self.homing = None,
            false => self.begin_leg(),
        }
    }

    /// Where the axes stand after homing.
    fn homed_position(&self) -> Point {
        let (mask, off, travel) = (
            self.memory.get(23) as u32,
            self.memory.get(27),
            self.memory.axes(130),
        );
        Point::from([0, 1, 2].map(|i| {
            if mask >> i & 1 == 1 {
                off - travel[i]
            } else {
                -off
            }
        }))
    }

    /// ALARM:6 to 9: the firmware resets itself.
    pub(super) fn homing_failed(&mut self, alarm: u16) {
        self.end_homing();
        self.say(&format!("ALARM:{alarm}"));
        self.mode = Mode::Alarm;
        self.deaf = Deaf::ThenRestart(self.now + DEAF);
    }

    /// Stops where the axes are.
    pub(super) fn end_homing(&mut self) {
        if let Some(homing) = self.homing.take() {
            let counted = self.motion.position_in_steps();
            let real = homing.position(&counted);
            self.motion.abort();
            self.motion.set_position(real);
            // Steps of an axis that was held back are counted all the same.
            self.declare(counted);
        }
    }

    /// From now on the place where the axes stand has these machine coordinates.
    fn declare(&mut self, place: Point) {
        let shift: Vector = self.motion.position() - place;
        self.bench += shift;
        self.motion.set_position(place);
    }
}
