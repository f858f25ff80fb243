//! The axes: a look-ahead window of straight blocks, speed profiles cut into 10 ms slices, and where the tool is at each moment.
//!
//! ```text
//!  push -> [ block block ... block ]  --prepare-->  [ slice slice slice slice slice ] --run--> position
//!            look-ahead, 15 usable                     up to 50 ms ahead of the axes
//! ```
//! A block leaves the window when its last slice is *prepared*, not when it is run: that is when the firmware lets the next line
//! in. A hold therefore begins only behind the slices already prepared. Machine coordinates, mm, mm/s, s.

use super::settings::Memory;
use std::collections::VecDeque;

/// Longest slice, s.
const SLICE: f64 = 0.010;
/// Slices the firmware holds, the running one included.
const SLICES: usize = 5;
/// The slowest the firmware will programme a block, mm/s (1 mm/min).
const SLOWEST: f64 = 1.0 / 60.0;

/// How fast a block may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// G0: all the machine can, times the rapid override.
    Rapid,
    /// Feed in mm/s, times the feed override.
    Feed(f64),
    /// Feed in mm/s whatever the overrides (jogs, probing).
    Fixed(f64),
}

#[derive(Clone, Debug)]
struct Block {
    unit: [f64; 3],
    end: [f64; 3],
    remaining: f64,
    acceleration: f64,
    rapid: f64,
    speed: Speed,
    nominal: f64,
    /// Square of the speed the corner to the block before allows.
    junction_sq: f64,
    entry_sq: f64,
}

#[derive(Clone, Copy, Debug)]
struct Slice {
    duration: f64,
    from: [f64; 3],
    to: [f64; 3],
}

/// Overrides, as factors of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// On feeds.
    pub feed: f64,
    /// On rapids.
    pub rapid: f64,
}

/// The axes and their queue.
#[derive(Clone, Debug)]
pub struct Motion {
    window: usize,
    blocks: VecDeque<Block>,
    slices: VecDeque<Slice>,
    /// Seconds of the first slice already run.
    run: f64,
    /// Speed at the end of what is prepared.
    speed: f64,
    /// Place at the end of what is prepared.
    head: [f64; 3],
    /// Where the axes are.
    position: [f64; 3],
    /// End of the last block pushed, and its direction.
    planned: [f64; 3],
    last_unit: [f64; 3],
    last_nominal: f64,
    factors: Factors,
    /// Slices are prepared and run.
    going: bool,
    /// Slow down to a stand, wherever that is.
    holding: bool,
}

impl Motion {
    /// Axes at rest at `position`, with a window of `window` blocks.
    pub fn new(window: usize, position: [f64; 3]) -> Motion {
        Motion {
            window: window.max(1),
            blocks: VecDeque::new(),
            slices: VecDeque::new(),
            run: 0.0,
            speed: 0.0,
            head: position,
            position,
            planned: position,
            last_unit: [0.0; 3],
            last_nominal: 0.0,
            factors: Factors { feed: 1.0, rapid: 1.0 },
            going: false,
            holding: false,
        }
    }

    /// Where the axes are now.
    pub fn position(&self) -> [f64; 3] {
        self.position
    }

    /// Path speed at the end of what is prepared, mm/s: what the firmware reports as speed.
    pub fn speed(&self) -> f64 {
        if self.going { self.speed } else { 0.0 }
    }

    /// Blocks that can still be pushed.
    pub fn free(&self) -> usize {
        self.window.saturating_sub(self.blocks.len())
    }

    /// Nothing is queued and nothing moves.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty() && self.slices.is_empty()
    }

    /// A cycle is in progress: axes move, or are about to.
    pub fn going(&self) -> bool {
        self.going
    }

    /// Adds a straight block to `target`. Returns false when it has no steps to make and vanishes. The caller has seen
    /// [`Motion::free`]; a block too many is refused with false as well.
    pub fn push(&mut self, target: [f64; 3], speed: Speed, memory: &Memory) -> bool {
        let steps = memory.axes(100);
        // The firmware counts whole steps; so do block lengths and directions.
        let end: [f64; 3] = std::array::from_fn(|i| (target[i] * steps[i]).round() / steps[i]);
        let delta: [f64; 3] = std::array::from_fn(|i| end[i] - self.planned[i]);
        let length = delta.iter().map(|d| d * d).sum::<f64>().sqrt();
        if length < 1e-9 || !length.is_finite() || self.free() == 0 {
            return false;
        }
        let unit = delta.map(|d| d / length);
        let acceleration = along(&memory.axes(120), &unit);
        let rapid = along(&memory.axes(110), &unit) / 60.0;
        let mut block = Block {
            unit,
            end,
            remaining: length,
            acceleration,
            rapid,
            speed,
            nominal: 0.0,
            junction_sq: 0.0,
            entry_sq: 0.0,
        };
        block.nominal = nominal(&block, self.factors);
        if !self.blocks.is_empty() {
            block.junction_sq = junction_sq(&self.last_unit, &unit, &memory.axes(120), memory.get(11));
        }
        self.planned = end;
        self.last_unit = unit;
        self.last_nominal = block.nominal;
        self.blocks.push_back(block);
        self.plan();
        true
    }

    /// Starts (or goes on with) what is queued.
    pub fn start(&mut self) {
        if !self.blocks.is_empty() || !self.slices.is_empty() {
            self.going = true;
            self.prepare();
        }
    }

    /// Slows down to a stand as soon as the prepared slices have run.
    pub fn hold(&mut self) {
        self.holding = true;
    }

    /// A hold is in force.
    pub fn is_holding(&self) -> bool {
        self.holding
    }

    /// Ends a hold that has come to rest; the rest of the queue goes on from standstill.
    pub fn release(&mut self) {
        self.holding = false;
        self.speed = 0.0;
        self.plan();
        self.start();
    }

    /// Throws the queue away where the axes are. At rest this costs nothing; in motion the real machine loses steps.
    pub fn abort(&mut self) {
        *self = Motion { factors: self.factors, ..Motion::new(self.window, self.position) };
    }

    /// Takes new overrides into the plan at once.
    pub fn set_factors(&mut self, factors: Factors) {
        self.factors = factors;
        for block in &mut self.blocks {
            block.nominal = nominal(block, factors);
        }
        self.plan();
    }

    /// Says where the axes are (homing). Only while empty.
    pub fn set_position(&mut self, position: [f64; 3]) {
        if self.is_empty() {
            (self.position, self.head, self.planned) = (position, position, position);
        }
    }

    /// Seconds until a slice ends, and with it something may change. `None` at rest.
    pub fn next_change(&self) -> Option<f64> {
        if !self.going {
            return None;
        }
        self.slices.front().map(|s| (s.duration - self.run).max(0.0))
    }

    /// Lets the axes run for `dt`, which must not exceed [`Motion::next_change`].
    pub fn advance(&mut self, dt: f64) {
        let Some(slice) = self.slices.front().filter(|_| self.going) else { return };
        self.run += dt;
        let share = if slice.duration > 0.0 { (self.run / slice.duration).min(1.0) } else { 1.0 };
        self.position = std::array::from_fn(|i| slice.from[i] + share * (slice.to[i] - slice.from[i]));
        if self.run >= slice.duration - 1e-12 {
            self.position = slice.to;
            self.slices.pop_front();
            self.run = 0.0;
            self.prepare();
        }
    }

    fn prepare(&mut self) {
        if !self.going {
            return;
        }
        while self.slices.len() < SLICES && self.prepare_slice() {}
        if self.slices.is_empty() {
            self.going = false;
            self.speed = 0.0;
        }
    }

    /// Cuts the next slice off the first block. False when there is none, or a hold has come to rest.
    fn prepare_slice(&mut self) -> bool {
        if self.holding && self.speed <= 0.0 {
            return false;
        }
        let exit = self.blocks.get(1).map_or(0.0, |b| b.entry_sq.sqrt());
        let Some(block) = self.blocks.front_mut() else { return false };
        let from = self.head;
        let (time, distance);
        if self.holding {
            let a = block.acceleration;
            // Time to the end of the block or to a stand, whichever comes first.
            let stop = self.speed / a;
            let reach = self.speed * self.speed / (2.0 * a);
            let to_end = if reach > block.remaining {
                let v_end = (self.speed * self.speed - 2.0 * a * block.remaining).max(0.0).sqrt();
                2.0 * block.remaining / (self.speed + v_end)
            } else {
                stop
            };
            time = to_end.min(SLICE);
            let slower = if time >= stop { 0.0 } else { self.speed - a * time };
            distance = 0.5 * (self.speed + slower) * time;
            self.speed = slower;
        } else {
            let cut = Profile { speed: self.speed, nominal: block.nominal, exit, acceleration: block.acceleration };
            let (t, d, v) = cut.run(block.remaining, SLICE);
            (time, distance) = (t, d);
            self.speed = v;
        }
        block.remaining -= distance;
        // A tenth of a nanometre is no step.
        let done = block.remaining <= 1e-7;
        if done {
            self.head = block.end;
            self.blocks.pop_front();
            if self.blocks.is_empty() {
                self.speed = 0.0;
            }
        } else {
            let (end, unit, rest) = (block.end, block.unit, block.remaining);
            self.head = std::array::from_fn(|i| end[i] - unit[i] * rest);
            block.entry_sq = self.speed * self.speed;
        }
        self.slices.push_back(Slice { duration: time, from, to: self.head });
        true
    }

    /// Entry speeds of all blocks: from the last (which must end at a stand) back as fast as braking allows, then forward as
    /// fast as accelerating allows. The first block goes at the speed it has.
    fn plan(&mut self) {
        let mut next_entry_sq = 0.0;
        for i in (1..self.blocks.len()).rev() {
            let before = self.blocks.get(i - 1).map_or(0.0, |b| b.nominal);
            let Some(block) = self.blocks.get_mut(i) else { continue };
            let most = block.junction_sq.min(block.nominal.powi(2)).min(before.powi(2));
            block.entry_sq = most.min(next_entry_sq + 2.0 * block.acceleration * block.remaining);
            next_entry_sq = block.entry_sq;
        }
        let mut reachable_sq = self.speed * self.speed;
        for (i, block) in self.blocks.iter_mut().enumerate() {
            block.entry_sq = if i == 0 { reachable_sq } else { block.entry_sq.min(reachable_sq) };
            reachable_sq = block.entry_sq + 2.0 * block.acceleration * block.remaining;
        }
    }
}

/// The largest value along `unit` that keeps every axis within its own limit.
fn along(limits: &[f64; 3], unit: &[f64; 3]) -> f64 {
    (0..3)
        .filter(|&i| unit[i].abs() > 1e-12)
        .map(|i| limits[i] / unit[i].abs())
        .fold(f64::INFINITY, f64::min)
}

fn nominal(block: &Block, factors: Factors) -> f64 {
    let wanted = match block.speed {
        Speed::Rapid => block.rapid * factors.rapid,
        Speed::Feed(f) => (f * factors.feed).min(block.rapid),
        Speed::Fixed(f) => f.min(block.rapid),
    };
    wanted.max(SLOWEST)
}

/// Round the corner by a circle that misses it by `deviation`: radius = deviation s / (1 - s) with s the sine of half the angle
/// between the legs, v² = a radius. Straight on: no limit. Reversal: stop.
fn junction_sq(before: &[f64; 3], after: &[f64; 3], acceleration: &[f64; 3], deviation: f64) -> f64 {
    let cos = -(0..3).map(|i| before[i] * after[i]).sum::<f64>();
    if cos > 0.999_999 {
        return 0.0;
    }
    if cos < -0.999_999 {
        return f64::INFINITY;
    }
    let turn: [f64; 3] = std::array::from_fn(|i| after[i] - before[i]);
    let size = turn.iter().map(|c| c * c).sum::<f64>().sqrt();
    let a = along(acceleration, &turn.map(|c| c / size));
    let s = (0.5 * (1.0 - cos)).sqrt();
    a * deviation * s / (1.0 - s)
}

/// From a speed, over the rest of a block, to its exit speed.
struct Profile {
    speed: f64,
    nominal: f64,
    exit: f64,
    acceleration: f64,
}

impl Profile {
    /// Runs for at most `dt` or to the end of `distance`: time used, distance covered, speed then.
    fn run(&self, distance: f64, dt: f64) -> (f64, f64, f64) {
        let a = self.acceleration;
        let exit = self.exit.min(self.nominal);
        let (mut v, mut left, mut time) = (self.speed, distance, 0.0);
        // At most: slow to a lowered nominal speed, rise, cruise, brake.
        for _ in 0..4 {
            let room = dt - time;
            if room <= 0.0 || left <= 1e-7 {
                break;
            }
            let braking = (v * v - exit * exit) / (2.0 * a);
            let (goal, phase) = if braking >= left * (1.0 - 1e-9) {
                // Brake to the exit: by mean speed, so that the end is met exactly.
                (exit, 2.0 * left / (v + exit).max(1e-9))
            } else if v > self.nominal + 1e-9 {
                (self.nominal, (v - self.nominal) / a)
            } else {
                let peak = (0.5 * (2.0 * a * left + v * v + exit * exit)).sqrt().min(self.nominal);
                if peak > v + 1e-9 {
                    (peak, (peak - v) / a)
                } else {
                    (v, (left - braking.max(0.0)) / v.max(1e-9))
                }
            };
            let used = phase.min(room);
            let after = if phase > room { v + (goal - v) * (room / phase) } else { goal };
            left -= 0.5 * (v + after) * used;
            time += used;
            v = after;
        }
        (time, distance - left.max(0.0), v)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn memory(rate: f64, acceleration: f64) -> Memory {
        let mut m = Memory::default();
        for i in 0..3 {
            m.set(110 + i, rate);
            m.set(120 + i, acceleration);
        }
        m
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
        let mut m = Motion::new(15, [0.0; 3]);
        m.push([20.0, 0.0, 0.0], Speed::Feed(10.0), &memory(3000.0, 500.0));
        m.start();
        assert!((finish(&mut m) - 2.02).abs() < 1e-9);
        assert_eq!(m.position(), [20.0, 0.0, 0.0]);
    }

    #[test]
    fn a_triangle_never_reaches_its_speed() {
        // 1 mm at 500 mm/s²: 2 sqrt(d / a).
        let mut m = Motion::new(15, [0.0; 3]);
        m.push([1.0, 0.0, 0.0], Speed::Rapid, &memory(60_000.0, 500.0));
        m.start();
        assert!((finish(&mut m) - 2.0 * (1.0f64 / 500.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_hold_begins_behind_the_prepared_slices_and_loses_nothing() {
        // At 10 mm/s the fifth slice ahead of 316.8 ms ends at 360 ms: 3.5 mm, and braking takes 0.1 mm more.
        let mut m = Motion::new(15, [0.0; 3]);
        m.push([20.0, 0.0, 0.0], Speed::Feed(10.0), &memory(3000.0, 500.0));
        m.start();
        run(&mut m, 0.3168);
        m.hold();
        finish(&mut m);
        assert!((m.position()[0] - 3.6).abs() < 1e-6, "{:?}", m.position());
        assert!(!m.going());
        m.release();
        finish(&mut m);
        assert_eq!(m.position(), [20.0, 0.0, 0.0]);
    }

    #[test]
    fn a_lowered_override_slows_the_running_block() {
        let mut m = Motion::new(15, [0.0; 3]);
        m.push([20.0, 0.0, 0.0], Speed::Feed(10.0), &memory(3000.0, 500.0));
        m.start();
        run(&mut m, 0.5);
        m.set_factors(Factors { feed: 0.5, rapid: 1.0 });
        run(&mut m, 0.2);
        assert!((m.speed() - 5.0).abs() < 1e-9);
        finish(&mut m);
        assert_eq!(m.position(), [20.0, 0.0, 0.0]);
    }

    proptest! {
        /// Whatever is queued, held and released: every axis keeps its speed limit, and the end is reached.
        #[test]
        fn no_axis_exceeds_its_rate(
            points in proptest::collection::vec(proptest::array::uniform3(-400i32..400), 1..40), feed in 1.0f64..120.0,
            hold_at in 0.0f64..3.0,
        ) {
            let memory = memory(3000.0, 400.0);
            let mut m = Motion::new(15, [0.0; 3]);
            let mut queue: Vec<[f64; 3]> = points.iter().map(|p| p.map(|c| f64::from(c) / 50.0)).collect();
            queue.reverse();
            let (mut time, mut held, mut end) = (0.0, false, [0.0; 3]);
            loop {
                while m.free() > 0
                    && let Some(p) = queue.pop()
                {
                    end = p;
                    m.push(p, Speed::Feed(feed), &memory);
                }
                if !held || m.going() { if !held { m.start(); } }
                let Some(dt) = m.next_change() else {
                    if held { m.release(); held = false; if m.next_change().is_none() && queue.is_empty() { break; } continue; }
                    if queue.is_empty() { break; }
                    continue;
                };
                let before = m.position();
                m.advance(dt);
                time += dt;
                for (a, b) in m.position().iter().zip(before) {
                    prop_assert!((a - b).abs() <= 50.0 * dt + 1e-6, "{} mm in {} s", (a - b).abs(), dt);
                }
                if !held && time > hold_at && time - dt <= hold_at { m.hold(); held = true; }
                prop_assert!(time < 1000.0);
            }
            for (a, b) in m.position().iter().zip(end) {
                prop_assert!((a - b).abs() < 0.003, "{:?} {:?}", m.position(), end);
            }
        }
    }
}
