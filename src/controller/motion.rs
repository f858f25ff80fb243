//! The axes: the look-ahead window of `kinematics`, speed profiles cut into 10 ms slices, and where the tool is at each moment.
//!
//! ```text
//!  push -> [ block block ... block ]  --prepare-->  [ slice slice slice slice slice ] --run--> position
//!            look-ahead, 15 usable                     up to 50 ms ahead of the axes
//! ```
//! A block leaves the window when its last slice is *prepared*, not when it is run: that is when the firmware lets the next line
//! in. A hold therefore begins only behind the slices already prepared. Machine coordinates, mm, mm/s, s.

use crate::geom::Point;
use crate::kinematics::{Overrides, Planner, Profile, Pushed, Settings, Speed, Target};
use std::collections::VecDeque;

/// Longer than anybody waits, s.
const ENDLESS: f64 = 1e12;
/// Fewest steps of a slice that does not end its block.
const LEAST_STEPS: f64 = 1.25;
/// Longest time from one step to the next: eight times what sixteen bits count at 16 MHz, s.
const SLOWEST_STEP: f64 = 8.0 * 65_535.0 / 16e6;
/// Longest slice, s.
const SLICE: f64 = 0.010;
/// Slices the firmware holds, the running one included.
const SLICES: usize = 5;
/// A switch this near in time is reached, s.
const SOON: f64 = 1e-8;
/// Rounding that still counts as a step made.
const STEP_SLACK: f64 = 1e-4;
/// What is left of a block when it counts as done, mm: far below any step.
const NOTHING: f64 = 1e-7;

/// What the spindle is told as a block is prepared: with a laser its power changes from block to block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beam {
    /// Turns per minute of the block, before overrides; zero: dark.
    pub rpm: f64,
    /// The power follows the speed (M4 with a laser).
    pub follows: bool,
}

#[derive(Clone, Copy, Debug)]
struct Slice {
    duration: f64,
    from: Point,
    to: Point,
    rapid: bool,
    /// The whole block, steps.
    block: ([i64; 3], [i64; 3]),
    /// What the spindle is told meanwhile.
    beam: Beam,
}

/// The axes and their queue.
#[derive(Clone, Debug)]
pub struct Motion {
    planner: Planner,
    /// Of the blocks in the planner.
    beams: VecDeque<Beam>,
    /// Of the slice prepared last, since it was last asked for.
    told: Option<f64>,
    /// Of the slice that runs, or ran last.
    shining: Beam,
    slices: VecDeque<Slice>,
    /// Seconds of the first slice already run.
    run: f64,
    /// Speed at the end of what is prepared.
    speed: f64,
    /// Place at the end of what is prepared.
    head: Point,
    /// Where the axes are.
    position: Point,
    /// The block that the axes are in, or were in last, steps.
    block: Option<([i64; 3], [i64; 3])>,
    /// Slices are prepared and run.
    going: bool,
    /// The motors are being held at the end of a motion, and nothing else happens.
    resting: bool,
    /// Slow down to a stand, wherever that is.
    holding: bool,
    /// What was last run was a rapid move.
    ran_rapid: bool,
    /// How long the first slices take to prepare, s.
    start_delay: f64,
}

impl Motion {
    /// Axes at rest at `position`.
    pub fn new(settings: &Settings, position: Point) -> Motion {
        let mut planner = Planner::new(settings);
        planner.set_position(&position);
        Motion {
            planner,
            beams: VecDeque::new(),
            told: None,
            shining: Beam::default(),
            slices: VecDeque::new(),
            run: 0.0,
            speed: 0.0,
            head: position,
            position,
            block: None,
            going: false,
            resting: false,
            holding: false,
            ran_rapid: false,
            start_delay: 0.0,
        }
    }

    /// The same, with a delay before every start from rest, s.
    pub fn starting_after(self, seconds: f64) -> Motion {
        Motion {
            start_delay: seconds,
            ..self
        }
    }

    /// As new, at `position`, but with the same overrides and delay.
    fn anew(&self, settings: &Settings, position: Point) -> Motion {
        let mut fresh = Motion::new(settings, position).starting_after(self.start_delay);
        fresh.planner.set_overrides(self.planner.overrides());
        fresh.shining = self.shining;
        fresh
    }

    /// Where the axes are now.
    pub fn position(&self) -> Point {
        self.position
    }

    /// A place in whole steps, as the firmware counts and reports it, mm.
    pub fn steps_at(&self, place: &Point) -> Point {
        self.planner
            .point_of_steps(&self.planner.steps_of_point(place))
    }

    /// Where the axes are now, in the whole steps made so far, mm: the axis with the most steps has made those whose place it has
    /// come to, the others follow it.
    pub fn position_in_steps(&self) -> Point {
        let Some((from, to)) = self.block else {
            return self.steps_at(&self.position);
        };
        let way: [i64; 3] = std::array::from_fn(|i| to[i].saturating_sub(from[i]));
        let lead = (0..3).max_by_key(|&i| way[i].abs()).unwrap_or_default();
        let all = way[lead].abs();
        if all == 0 {
            return self.steps_at(&self.position);
        }
        let at = self.position[lead] * self.planner.settings().steps_per_mm[lead];
        let made = (at - from[lead] as f64).abs();
        let made = (made + STEP_SLACK).floor().clamp(0.0, all as f64);
        let steps = std::array::from_fn(|i| {
            let share = way[i] as f64 * made / all as f64;
            from[i].saturating_add(share.round() as i64)
        });
        self.planner.point_of_steps(&steps)
    }

    /// How long the motors are held at a standstill, s.
    pub fn idle_delay(&self) -> f64 {
        self.planner.settings().idle_delay.0
    }

    /// Seconds until a coordinate comes to `at` within the slice that runs now; `None` if it does not, or stands there already.
    pub fn reach(&self, axis: usize, at: f64) -> Option<f64> {
        let slice = self.slices.front().filter(|_| self.going)?;
        let (from, to, now) = (slice.from[axis], slice.to[axis], self.position[axis]);
        let ahead = (at - now) * (to - from) > 0.0 && (at - to) * (at - now) <= 0.0;
        let after = slice.duration * (at - from) / (to - from) - self.run;
        (ahead && after > SOON).then_some(after)
    }

    /// Path speed at the end of what is prepared, mm/s: what the firmware reports as speed.
    pub fn speed(&self) -> f64 {
        if self.going { self.speed } else { 0.0 }
    }

    /// Blocks that can still be pushed.
    pub fn free(&self) -> usize {
        self.planner
            .settings()
            .blocks
            .max(1)
            .saturating_sub(self.planner.len())
    }

    /// Nothing is queued and nothing moves.
    pub fn is_empty(&self) -> bool {
        self.planner.is_empty() && self.slices.is_empty()
    }

    /// No block is queued, and at most the motors are being held at the end of a motion.
    pub fn is_empty_but_rest(&self) -> bool {
        self.planner.is_empty() && (self.slices.is_empty() || self.resting)
    }

    /// A cycle is in progress: axes move, are about to, or have just stopped.
    pub fn going(&self) -> bool {
        self.going
    }

    /// The axes move now.
    pub fn moving(&self) -> bool {
        self.going && self.slices.front().is_some_and(|s| s.from != s.to)
    }

    /// What the axes did last was a rapid move.
    pub fn ran_rapid(&self) -> bool {
        self.ran_rapid
    }

    /// A hold is in force.
    pub fn is_holding(&self) -> bool {
        self.holding
    }

    /// Adds a straight block to `to`, machine coordinates. A block without steps to make vanishes.
    pub fn push(&mut self, to: Point, speed: Speed) -> Pushed {
        self.push_with(to, speed, Beam::default())
    }

    /// The same, with what the spindle is told.
    pub fn push_with(&mut self, to: Point, speed: Speed, beam: Beam) -> Pushed {
        // What is under way is planned with the speed it has now.
        if let Some((block, _)) = self.planner.front() {
            let remaining = block.remaining;
            self.planner.advance(remaining, self.speed);
        }
        let pushed = self.planner.push(Target { to, speed, line: 0 });
        if pushed == Pushed::Queued {
            self.beams.push_back(beam);
        }
        pushed
    }

    /// What the spindle has been told by blocks since this was last asked, turns per minute before overrides.
    pub fn take_told(&mut self) -> Option<f64> {
        self.told.take()
    }

    /// What the spindle is told by the slice that runs, or was told last.
    pub fn shining(&self) -> Beam {
        self.shining
    }

    /// The spindle is told so at a standstill.
    pub fn shine(&mut self, beam: Beam) {
        (self.shining, self.told) = (beam, None);
    }

    /// Starts (or goes on with) what is queued.
    pub fn start(&mut self) {
        if !self.is_empty() {
            if !self.going && self.start_delay > 0.0 && !self.planner.is_empty() {
                let steps = self.planner.steps_of_point(&self.position);
                self.slices.push_back(Slice {
                    rapid: false,
                    duration: self.start_delay,
                    from: self.position,
                    to: self.position,
                    block: self.block.unwrap_or((steps, steps)),
                    beam: self.shining,
                });
            }
            self.going = true;
            self.prepare();
        }
    }

    /// Slows down to a stand as soon as the prepared slices have run.
    pub fn hold(&mut self) {
        self.holding = true;
    }

    /// Ends a hold that has come to rest; the rest of the queue goes on from standstill.
    pub fn release(&mut self) {
        self.holding = false;
        self.speed = 0.0;
        if let Some((block, _)) = self.planner.front() {
            let remaining = block.remaining;
            self.planner.advance(remaining, 0.0);
        }
        self.start();
    }

    /// Throws the queue away where the axes are. At rest this costs nothing; in motion the real machine loses steps.
    pub fn abort(&mut self) {
        // The axes stand on whole steps.
        let place = self.position_in_steps();
        let ran_rapid = self.ran_rapid;
        *self = self.anew(&self.planner.settings().clone(), place);
        self.ran_rapid = ran_rapid;
    }

    /// New machine figures. Only while empty; otherwise they are ignored.
    pub fn set_settings(&mut self, settings: &Settings) {
        if self.is_empty() {
            // The firmware counts steps: other steps per mm are another place.
            let old = self.planner.settings().steps_per_mm;
            let steps = self.planner.steps_of_point(&self.position);
            let mut place = self.position;
            for axis in 0..3 {
                if settings.steps_per_mm[axis] != old[axis] {
                    place[axis] = steps[axis] as f64 / settings.steps_per_mm[axis];
                }
            }
            *self = self.anew(settings, place);
        }
    }

    /// Takes new overrides into the plan at once.
    pub fn set_overrides(&mut self, overrides: Overrides) {
        self.planner.set_overrides(overrides);
        if let Some((block, _)) = self.planner.front() {
            let remaining = block.remaining;
            self.planner.advance(remaining, self.speed);
        }
    }

    /// Says where the axes are (homing). Only while empty.
    pub fn set_position(&mut self, position: Point) {
        if self.is_empty() {
            (self.position, self.head, self.block) = (position, position, None);
            self.planner.set_position(&position);
        }
    }

    /// Seconds until a slice ends, and with it something may change. `None` at rest.
    pub fn next_change(&self) -> Option<f64> {
        if !self.going {
            return None;
        }
        self.slices
            .front()
            .filter(|s| s.duration < ENDLESS)
            .map(|s| (s.duration - self.run).max(0.0))
    }

    /// Lets the axes run for `dt`, which must not exceed [`Motion::next_change`].
    pub fn advance(&mut self, dt: f64) {
        let Some(slice) = self.slices.front().copied().filter(|_| self.going) else {
            return;
        };
        self.run += dt;
        let before = self.position;
        self.block = Some(slice.block);
        if slice.from != slice.to || self.resting {
            self.shining = slice.beam;
        }
        if self.run >= slice.duration - super::SAME_MOMENT {
            self.position = slice.to;
            self.slices.pop_front();
            self.run = 0.0;
            self.prepare();
        } else {
            self.position = slice.from + (slice.to - slice.from) * (self.run / slice.duration);
        }
        if self.position != before {
            self.ran_rapid = slice.rapid;
        }
    }

    fn prepare(&mut self) {
        if !self.going {
            return;
        }
        while self.slices.len() < SLICES && self.prepare_slice() {
            self.resting = false;
        }
        if self.slices.is_empty() {
            self.speed = 0.0;
            let delay = self.planner.settings().idle_delay.0;
            if !self.resting && delay > 0.0 {
                self.resting = true;
                let steps = self.planner.steps_of_point(&self.position);
                self.slices.push_back(Slice {
                    duration: delay,
                    from: self.position,
                    to: self.position,
                    rapid: false,
                    block: self.block.unwrap_or((steps, steps)),
                    // What follows the speed is dark at a standstill.
                    beam: match self.shining.follows {
                        true => Beam::default(),
                        false => self.shining,
                    },
                });
            } else {
                self.resting = false;
                self.going = false;
            }
        }
    }

    /// Cuts the next slice off the first block. False when there is none, or a hold has come to rest.
    fn prepare_slice(&mut self) -> bool {
        if self.holding && self.speed <= 0.0 {
            return false;
        }
        let Some((block, planned)) = self.planner.front() else {
            return false;
        };
        let profile = if self.holding {
            Profile::brake(block.remaining, self.speed, block.acceleration)
        } else {
            planned
        };
        let from = self.head;
        let steps = (block.from_steps, block.to_steps);
        // A slice has more than one step of the axis that has most, however long that takes.
        let whole = profile.duration();
        let steps_per_mm = (0..3)
            .map(|i| block.to_steps[i].abs_diff(block.from_steps[i]) as f64)
            .fold(0.0, f64::max)
            / block.length;
        let mut time = whole.min(SLICE);
        while time < whole && profile.distance_at(time) * steps_per_mm < LEAST_STEPS {
            time = (time + SLICE).min(whole);
        }
        let at_end = time >= whole;
        let remaining = block.remaining
            - if at_end {
                profile.length
            } else {
                profile.distance_at(time)
            };
        self.speed = if at_end {
            profile.exit
        } else {
            profile.speed_at(time)
        };
        let end = self.planner.point_of_steps(&block.to_steps);
        let rapid = block.speed == Speed::Rapid;
        let wanted = match block.speed {
            Speed::Feed(f) | Speed::Fixed(f) => f.mm_per_s(),
            Speed::InverseTime(f) => f / 60.0 * block.length,
            Speed::Rapid => block.rapid,
        };
        let mut beam = self.beams.front().copied().unwrap_or_default();
        if beam.follows && wanted > 0.0 {
            beam.rpm *= self.speed / wanted;
        }
        self.told = Some(beam.rpm);
        // More steps than the firmware can count: it never makes the first of them.
        let most = i64::from(i32::MAX);
        let endless = (0..3).any(|i| block.to_steps[i].abs() > most);
        // The timer counts no longer than this from one step to the next: slower is not slower.
        let made = (block.remaining - remaining) * steps_per_mm;
        let time = match endless {
            true => ENDLESS,
            false => time.min((made * SLOWEST_STEP).max(f64::MIN_POSITIVE)),
        };
        if remaining <= NOTHING {
            self.head = end;
            self.planner.pop();
            self.beams.pop_front();
            match self.planner.front() {
                Some((next, _)) => {
                    let length = next.remaining;
                    self.planner.advance(length, self.speed);
                }
                None => self.speed = 0.0,
            }
        } else {
            self.head = end - block.direction * remaining;
            self.planner.advance(remaining, self.speed);
        }
        self.slices.push_back(Slice {
            duration: time,
            from,
            to: self.head,
            rapid,
            block: steps,
            beam,
        });
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::units::{Mm, MmPerMin, MmPerSec2, Seconds};
    use proptest::prelude::*;

    fn axes(rate: f64, acceleration: f64) -> Motion {
        let settings = Settings {
            steps_per_mm: [250.0; 3],
            max_rate: [MmPerMin(rate); 3],
            acceleration: [MmPerSec2(acceleration); 3],
            junction_deviation: Mm(0.01),
            arc_tolerance: Mm(0.002),
            blocks: 15,
            idle_delay: Seconds(0.0),
        };
        Motion::new(&settings, Point::origin())
    }

    fn feed(mm_per_s: f64) -> Speed {
        Speed::Feed(MmPerMin(mm_per_s * 60.0))
    }

    fn run(motion: &mut Motion, time: f64) {
        let mut left = time;
        while left > 0.0
            && let Some(dt) = motion.next_change()
        {
            let dt = dt.min(left);
            motion.advance(dt);
            left -= dt;
        }
    }

    fn finish(motion: &mut Motion) -> f64 {
        let mut time = 0.0;
        while let Some(dt) = motion.next_change() {
            motion.advance(dt);
            time += dt;
        }
        time
    }

    #[test]
    fn one_block_takes_the_time_of_its_trapezoid() {
        // 20 mm at 10 mm/s, 500 mm/s²: 20/10 + 10/500.
        let mut m = axes(3000.0, 500.0);
        m.push(Point::new(20.0, 0.0, 0.0), feed(10.0));
        m.start();
        assert!((finish(&mut m) - 2.02).abs() < 1e-9);
        assert_eq!(m.position(), Point::new(20.0, 0.0, 0.0));
    }

    #[test]
    fn a_triangle_never_reaches_its_speed() {
        // 1 mm at 500 mm/s²: 2 sqrt(d / a).
        let mut m = axes(60_000.0, 500.0);
        m.push(Point::new(1.0, 0.0, 0.0), Speed::Rapid);
        m.start();
        assert!((finish(&mut m) - 2.0 * (1.0f64 / 500.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_hold_begins_behind_the_prepared_slices_and_loses_nothing() {
        // At 10 mm/s the fifth slice ahead of 316.8 ms ends at 360 ms: 3.5 mm, and braking takes 0.1 mm more.
        let mut m = axes(3000.0, 500.0);
        m.push(Point::new(20.0, 0.0, 0.0), feed(10.0));
        m.start();
        run(&mut m, 0.3168);
        m.hold();
        finish(&mut m);
        assert!((m.position()[0] - 3.6).abs() < 1e-6, "{:?}", m.position());
        assert!(!m.going());
        m.release();
        finish(&mut m);
        assert_eq!(m.position(), Point::new(20.0, 0.0, 0.0));
    }

    #[test]
    fn a_lowered_override_slows_the_running_block() {
        let mut m = axes(3000.0, 500.0);
        m.push(Point::new(20.0, 0.0, 0.0), feed(10.0));
        m.start();
        run(&mut m, 0.5);
        m.set_overrides(Overrides {
            feed: 0.5,
            rapid: 1.0,
        });
        run(&mut m, 0.2);
        assert!((m.speed() - 5.0).abs() < 1e-9);
        finish(&mut m);
        assert_eq!(m.position(), Point::new(20.0, 0.0, 0.0));
    }

    proptest! {
        /// Whatever is queued, held and released: every axis keeps its speed limit, and the end is reached.
        #[test]
        fn no_axis_exceeds_its_rate(
            points in proptest::collection::vec(proptest::array::uniform3(-400i32..400), 1..40), speed in 1.0f64..120.0,
            hold_at in 0.0f64..3.0,
        ) {
            let mut m = axes(3000.0, 400.0);
            let mut queue: Vec<Point> = points.iter().map(|p| Point::from(p.map(|c| f64::from(c) / 50.0))).collect();
            queue.reverse();
            let (mut time, mut held, mut end) = (0.0, false, Point::origin());
            loop {
                while m.free() > 0
                    && let Some(p) = queue.pop()
                {
                    end = p;
                    m.push(p, feed(speed));
                }
                if !held {
                    m.start();
                }
                let Some(dt) = m.next_change() else {
                    if held {
                        held = false;
                        m.release();
                        continue;
                    }
                    break;
                };
                let before = m.position();
                m.advance(dt);
                for (a, b) in m.position().iter().zip(before.iter()) {
                    prop_assert!((a - b).abs() <= 50.0 * dt + 1e-6, "{} mm in {} s", (a - b).abs(), dt);
                }
                if time <= hold_at && time + dt > hold_at {
                    m.hold();
                    held = true;
                }
                time += dt;
                prop_assert!(time < 2000.0);
            }
            prop_assert!((m.position() - end).norm() < 0.004, "{:?} {:?}", m.position(), end);
        }
    }
}
