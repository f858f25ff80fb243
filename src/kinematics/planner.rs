//! The look-ahead: how fast each block may begin so that every later corner, feed and stop can still be met.
//!
//! Crosses the border: targets in machine coordinates, mm, with a speed; [`Block`]s with entry speeds out, oldest first. The window is
//! as long as the machine's own: unlimited look-ahead would flatter paths of short segments.
//!
//! A corner is passed as if it were rounded by a circle that misses it by the junction deviation d:
//!
//! ```text
//!        \  |  /            s = sin(angle / 2), angle between the two legs (180 deg = straight on)
//!         \ | /             from corner to centre: r + d = r / s,  so  r = d s / (1 - s)
//!          \|/ <- d         v² = a r, where a is what the axes allow along the line to the centre
//!           '
//! ```
//!
//! Units: mm, s, mm/s, mm/s².

use super::profile::{Profile, Ramp};
use super::settings::Settings;
use crate::geom::{Point, Vector};
use crate::units::MmPerMin;
use std::collections::VecDeque;

/// How fast a line is meant to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// As fast as the axes allow (G0).
    Rapid,
    /// At a feed (G94).
    Feed(MmPerMin),
    /// In the reciprocal of so many minutes (G93), 1/min.
    InverseTime(f64),
    /// At a feed that no override touches (jogging, probing, homing).
    Fixed(MmPerMin),
}

/// A straight line to be planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// End, machine coordinates, mm.
    pub to: Point,
    /// How fast.
    pub speed: Speed,
    /// Line of the program, from 1; handed through.
    pub line: usize,
}

/// What became of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pushed {
    /// It is in the window.
    Queued,
    /// It is shorter than one step on every axis: nothing to do.
    Nothing,
    /// The window is full: pop first, then push it again.
    Full,
}

/// Factors on programmed speeds; 1 is as programmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overrides {
    /// On feeds, above zero.
    pub feed: f64,
    /// On rapids, above zero.
    pub rapid: f64,
}

/// A line in the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Line of the program, from 1.
    pub line: usize,
    /// How fast it was meant to go.
    pub speed: Speed,
    /// Start and end in steps, machine coordinates.
    pub from_steps: [i64; 3],
    /// End in steps, machine coordinates.
    pub to_steps: [i64; 3],
    /// Direction, unit length.
    pub direction: Vector,
    /// Whole length, mm.
    pub length: f64,
    /// Length still to go, mm; less than `length` once [`Planner::advance`] was called.
    pub remaining: f64,
    /// What the axes allow along `direction`, mm/s².
    pub acceleration: f64,
    /// What the axes allow along `direction`, mm/s.
    pub rapid: f64,
    /// Speed wanted, overrides and axes considered, mm/s.
    pub nominal: f64,
    /// Corner limit at its start, squared; infinite straight on.
    junction_sq: f64,
    /// Highest entry speed, squared: corner, own and previous nominal speed.
    max_entry_sq: f64,
    /// Planned entry speed, squared.
    entry_sq: f64,
}

impl Block {
    /// Speed at its start as planned now, mm/s.
    pub fn entry(&self) -> f64 {
        self.entry_sq.sqrt()
    }
}

/// The window.
#[derive(Clone, Debug)]
pub struct Planner {
    settings: Settings,
    overrides: Overrides,
    blocks: VecDeque<Block>,
    position: [i64; 3],
    /// Direction and nominal speed of the newest block, kept when it has left the window.
    previous: Option<(Vector, f64)>,
}

/// No machine is that large; it keeps step counts far from overflow.
const MOST_STEPS: f64 = 1e15;
/// Slowest motion, mm/s (1 mm/min).
const SLOWEST: f64 = 1.0 / 60.0;
/// Cosines beyond which two lines count as straight on or as a reversal.
const STRAIGHT: f64 = 0.999_999;

impl Planner {
    /// An empty window at machine zero.
    pub fn new(settings: &Settings) -> Planner {
        Planner {
            overrides: Overrides {
                feed: 1.0,
                rapid: 1.0,
            },
            blocks: VecDeque::with_capacity(settings.blocks.max(1)),
            position: [0; 3],
            previous: None,
            settings: settings.clone(),
        }
    }

    /// The machine's figures.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Blocks in the window.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// True if no block is in the window.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// True if the next push would be refused.
    pub fn is_full(&self) -> bool {
        self.blocks.len() >= self.settings.blocks.max(1)
    }

    /// Where the newest block ends, in steps.
    pub fn position_steps(&self) -> [i64; 3] {
        self.position
    }

    /// Where the newest block ends, machine coordinates, mm.
    pub fn position(&self) -> Point {
        self.point_of_steps(&self.position)
    }

    /// Steps to mm.
    pub fn point_of_steps(&self, steps: &[i64; 3]) -> Point {
        let mm = |i: usize| steps[i] as f64 / self.settings.steps_per_mm[i];
        Point::new(mm(0), mm(1), mm(2))
    }

    /// The nearest whole steps.
    pub fn steps_of_point(&self, p: &Point) -> [i64; 3] {
        // In single precision, as the firmware counts: it decides where halves go.
        let steps = |i: usize| {
            f64::from(p[i] as f32 * self.settings.steps_per_mm[i] as f32)
                .round()
                .clamp(-MOST_STEPS, MOST_STEPS) as i64
        };
        [steps(0), steps(1), steps(2)]
    }

    /// Takes note of where the machine stands, machine coordinates. For an empty window (start, homing, a reset).
    pub fn set_position(&mut self, p: &Point) {
        self.position = self.steps_of_point(p);
        self.previous = None;
    }

    /// Empties the window; the machine is taken to stand at `p`.
    pub fn clear(&mut self, p: &Point) {
        self.blocks.clear();
        self.set_position(p);
    }

    /// Appends a line and plans the window anew. One pass over the window.
    pub fn push(&mut self, target: Target) -> Pushed {
        if self.is_full() {
            return Pushed::Full;
        }
        let to_steps = self.steps_of_point(&target.to);
        if to_steps == self.position {
            return Pushed::Nothing;
        }
        let s = &self.settings;
        let way = Vector::from_fn(|i, _| {
            to_steps[i].saturating_sub(self.position[i]) as f64 / s.steps_per_mm[i]
        });
        let length = way.norm();
        let direction = way / length;
        let acceleration = limit(&direction, |i| s.acceleration[i].0);
        let rapid = limit(&direction, |i| s.max_rate[i].mm_per_s());
        let mut block = Block {
            line: target.line,
            speed: target.speed,
            from_steps: self.position,
            to_steps,
            direction,
            length,
            remaining: length,
            acceleration,
            rapid,
            nominal: 0.0,
            junction_sq: 0.0,
            max_entry_sq: 0.0,
            entry_sq: 0.0,
        };
        block.nominal = self.nominal(&block);
        // A block that meets an empty window starts from rest.
        if let (Some((before, speed)), false) = (&self.previous, self.blocks.is_empty()) {
            block.junction_sq = self.junction_sq(before, &direction);
            let slower = block.nominal.min(*speed);
            block.max_entry_sq = block.junction_sq.min(slower * slower);
        }
        self.previous = Some((direction, block.nominal));
        self.position = to_steps;
        self.blocks.push_back(block);
        self.plan();
        Pushed::Queued
    }

    /// The oldest block and its speed as planned now. It may still get a faster end while later blocks arrive.
    pub fn front(&self) -> Option<(&Block, Profile)> {
        let block = self.blocks.front()?;
        let exit = self.blocks.get(1).map_or(0.0, Block::entry);
        Some((block, profile(block, exit)))
    }

    /// Takes out the oldest block; its speed is final.
    pub fn pop(&mut self) -> Option<(Block, Profile)> {
        let (_, profile) = self.front()?;
        let block = self.blocks.pop_front()?;
        Some((block, profile))
    }

    /// Takes note that the oldest block is under way: `remaining` mm are left, and it moves at `speed` mm/s now. Plans anew: call it
    /// before pushing (or changing overrides) while a block is being executed, and with speed 0 after a feed hold.
    pub fn advance(&mut self, remaining: f64, speed: f64) {
        if let Some(block) = self.blocks.front_mut() {
            block.remaining = remaining.clamp(0.0, block.length);
            block.entry_sq = speed * speed;
        }
        self.plan();
    }

    /// Overrides now.
    pub fn overrides(&self) -> Overrides {
        self.overrides
    }

    /// Changes overrides and plans anew.
    pub fn set_overrides(&mut self, overrides: Overrides) {
        self.overrides = overrides;
        let mut before: Option<f64> = None;
        for i in 0..self.blocks.len() {
            let Some(block) = self.blocks.get(i) else {
                break;
            };
            let nominal = self.nominal(block);
            if let Some(block) = self.blocks.get_mut(i) {
                block.nominal = nominal;
                let slower = nominal.min(before.unwrap_or(nominal));
                block.max_entry_sq = block.junction_sq.min(slower * slower);
            }
            before = Some(nominal);
        }
        if let (Some((_, speed)), Some(nominal)) = (&mut self.previous, before) {
            *speed = nominal;
        }
        self.plan();
    }

    /// The speed wanted for a block under the present overrides.
    fn nominal(&self, block: &Block) -> f64 {
        let wanted = match block.speed {
            Speed::Rapid => block.rapid * self.overrides.rapid,
            Speed::Feed(f) => (f.mm_per_s() * self.overrides.feed).min(block.rapid),
            Speed::InverseTime(f) => {
                (f / 60.0 * block.length * self.overrides.feed).min(block.rapid)
            }
            Speed::Fixed(f) => f.mm_per_s().min(block.rapid),
        };
        wanted.max(SLOWEST)
    }

    /// Highest speed around the corner between two directions, squared.
    fn junction_sq(&self, before: &Vector, after: &Vector) -> f64 {
        let cos = -before.dot(after);
        if cos > STRAIGHT {
            return 0.0;
        }
        if cos < -STRAIGHT {
            return f64::INFINITY;
        }
        let s = ((1.0 - cos) / 2.0).sqrt();
        let inward = (after - before).normalize();
        let a = limit(&inward, |i| self.settings.acceleration[i].0);
        a * self.settings.junction_deviation.0 * s / (1.0 - s)
    }

    /// Entry speeds of the whole window. Backwards: no block may begin faster than it can brake to the next one's beginning, and the
    /// last one ends at rest. Forwards: none faster than the one before can get to. The oldest block has begun already.
    fn plan(&mut self) {
        let mut next_sq = 0.0;
        for block in self.blocks.iter_mut().skip(1).rev() {
            let reach = next_sq + 2.0 * block.acceleration * block.remaining;
            block.entry_sq = block.max_entry_sq.min(reach);
            next_sq = block.entry_sq;
        }
        let mut reach = f64::INFINITY;
        for (i, block) in self.blocks.iter_mut().enumerate() {
            if i > 0 && block.entry_sq > reach {
                block.entry_sq = reach;
            }
            reach = block.entry_sq + 2.0 * block.acceleration * block.remaining;
        }
    }
}

/// The least of the axes' limits over their share in a direction.
fn limit(direction: &Vector, of_axis: impl Fn(usize) -> f64) -> f64 {
    (0..3)
        .filter(|&i| direction[i] != 0.0)
        .map(|i| of_axis(i) / direction[i].abs())
        .fold(f64::INFINITY, f64::min)
}

fn profile(block: &Block, exit: f64) -> Profile {
    Profile::new(Ramp {
        length: block.remaining,
        entry: block.entry(),
        nominal: block.nominal,
        exit,
        acceleration: block.acceleration,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::units::{Mm, MmPerSec2, Seconds};
    use proptest::prelude::*;

    fn settings(acceleration: f64, blocks: usize) -> Settings {
        Settings {
            steps_per_mm: [1000.0; 3],
            max_rate: [MmPerMin(6000.0); 3],
            acceleration: [MmPerSec2(acceleration); 3],
            junction_deviation: Mm(0.01),
            arc_tolerance: Mm(0.002),
            blocks,
            idle_delay: Seconds(0.0),
        }
    }

    fn feed(x: f64, y: f64, f: f64) -> Target {
        Target {
            to: Point::new(x, y, 0.0),
            speed: Speed::Feed(MmPerMin(f)),
            line: 1,
        }
    }

    /// Pops when full, then empties.
    fn run(planner: &mut Planner, targets: &[Target]) -> Vec<(Block, Profile)> {
        let mut out = vec![];
        for &t in targets {
            while planner.push(t) == Pushed::Full {
                out.extend(planner.pop());
            }
        }
        out.extend(std::iter::from_fn(|| planner.pop()));
        out
    }

    #[test]
    fn corners_by_hand() {
        // Square corner: s = sin 45 deg; along the diagonal the axes allow 500 / sin 45 deg.
        let mut p = Planner::new(&settings(500.0, 15));
        let done = run(&mut p, &[feed(50.0, 0.0, 3000.0), feed(50.0, 50.0, 3000.0)]);
        let s = 0.5f64.sqrt();
        let v_sq = 500.0 / s * 0.01 * s / (1.0 - s);
        assert!((done[0].1.exit.powi(2) - v_sq).abs() < 1e-9);
        assert_eq!(done[0].1.exit, done[1].1.entry);
        // Back the way it came: a full stop. Straight on: none.
        for (x, stops) in [(0.0, true), (99.0, false)] {
            let mut p = Planner::new(&settings(500.0, 15));
            let done = run(&mut p, &[feed(50.0, 0.0, 3000.0), feed(x, 0.0, 3000.0)]);
            assert_eq!(done[0].1.exit, if stops { 0.0 } else { 50.0 });
        }
    }

    #[test]
    fn diagonals_use_what_both_axes_have() {
        let mut p = Planner::new(&settings(500.0, 15));
        let rapid = Target {
            speed: Speed::Rapid,
            ..feed(30.0, 30.0, 0.0)
        };
        let done = run(&mut p, &[rapid]);
        assert!((done[0].0.nominal - 100.0 * 2f64.sqrt()).abs() < 1e-9);
        assert!((done[0].0.acceleration - 500.0 * 2f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn short_segments_are_held_back_by_the_window() {
        // v² <= 2 a N L: 15 blocks of 0.05 mm at 200 mm/s² cannot pass 17.3 mm/s, whatever the feed.
        let mut p = Planner::new(&settings(200.0, 15));
        let targets: Vec<Target> = (1..2000)
            .map(|i| feed(f64::from(i) * 0.05, 0.0, 6000.0))
            .collect();
        let done = run(&mut p, &targets);
        let top = done.iter().map(|(_, p)| p.cruise).fold(0.0, f64::max);
        let bound = (2.0f64 * 200.0 * 15.0 * 0.05).sqrt();
        assert!(top <= bound + 1e-9 && top > 0.95 * bound, "{top}");
    }

    #[test]
    fn what_is_less_than_a_step_is_nothing() {
        let mut p = Planner::new(&settings(200.0, 2));
        assert_eq!(p.push(feed(0.0004, 0.0, 100.0)), Pushed::Nothing);
        assert_eq!(p.push(feed(0.0006, 0.0, 100.0)), Pushed::Queued);
        assert_eq!(p.position_steps(), [1, 0, 0]);
        assert_eq!(p.push(feed(1.0, 0.0, 100.0)), Pushed::Queued);
        assert_eq!(p.push(feed(2.0, 0.0, 100.0)), Pushed::Full);
    }

    #[test]
    fn overrides_change_what_is_under_way() {
        let mut p = Planner::new(&settings(500.0, 15));
        p.push(feed(100.0, 0.0, 1200.0));
        let (_, full) = p.front().unwrap();
        assert_eq!(full.cruise, 20.0);
        let t = 2.0;
        p.advance(100.0 - full.distance_at(t), full.speed_at(t));
        p.set_overrides(Overrides {
            feed: 0.5,
            rapid: 1.0,
        });
        let (block, half) = p.front().unwrap();
        assert_eq!((half.entry, half.cruise, half.exit), (20.0, 10.0, 0.0));
        assert!((block.remaining - (100.0 - full.distance_at(t))).abs() < 1e-12);
    }

    #[test]
    fn a_hold_costs_one_ramp_down_and_one_up() {
        let mut p = Planner::new(&settings(500.0, 15));
        p.push(feed(20.0, 0.0, 600.0));
        let (block, whole) = p.front().map(|(b, p)| (*b, p)).unwrap();
        let (d, v) = (whole.distance_at(0.3), whole.speed_at(0.3));
        let brake = Profile::brake(20.0 - d, v, block.acceleration);
        p.advance(20.0 - d - brake.length, 0.0);
        let rest = p.front().unwrap().1;
        let all = 0.3 + brake.duration() + rest.duration();
        // Each ramp takes v / a instead of half of that.
        assert!((all - whole.duration() - 10.0 / 500.0).abs() < 1e-9);
    }

    fn walk() -> impl Strategy<Value = Vec<Target>> {
        proptest::collection::vec((-9.0..9.0f64, -9.0..9.0f64, 60.0..6000.0f64, 0..4u8), 1..60)
            .prop_map(|steps| {
                let (mut x, mut y) = (0.0, 0.0);
                steps
                    .into_iter()
                    .map(|(dx, dy, f, kind)| {
                        let k = if kind == 0 { 0.02 } else { 1.0 };
                        (x, y) = (x + k * dx, y + k * dy);
                        let speed = match kind {
                            1 => Speed::Rapid,
                            _ => Speed::Feed(MmPerMin(f)),
                        };
                        Target {
                            speed,
                            ..feed(x, y, f)
                        }
                    })
                    .collect()
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        /// Speed is continuous from block to block, never above what was asked, obeys every corner, starts and ends at rest, and
        /// can be braked from within each block.
        #[test]
        fn plans_can_be_driven(targets in walk(), blocks in 1usize..20, a in 20.0..2000.0f64) {
            let mut p = Planner::new(&settings(a, blocks));
            let done = run(&mut p, &targets);
            let mut speed = 0.0;
            for (block, profile) in &done {
                prop_assert!((profile.entry - speed).abs() < 1e-6, "{} {}", profile.entry, speed);
                prop_assert!(profile.entry.powi(2) <= block.junction_sq + 1e-6);
                prop_assert!(profile.cruise.max(profile.entry).max(profile.exit) <= block.nominal + 1e-9);
                let reach = 2.0 * block.acceleration * block.length + 1e-6;
                prop_assert!((profile.exit.powi(2) - profile.entry.powi(2)).abs() <= reach);
                speed = profile.exit;
            }
            prop_assert!(speed < 1e-6);
        }

        /// Looking at a block under way does not change its course: told where it is, the planner plans the same rest.
        #[test]
        fn the_clock_may_look_at_any_time(targets in walk(), k in 0.05..0.95f64) {
            let settings = settings(300.0, 100);
            let mut p = Planner::new(&settings);
            for &t in &targets {
                p.push(t);
            }
            let plain: f64 = run(&mut p.clone(), &[]).iter().map(|(_, p)| p.duration()).sum();
            let mut looked = 0.0;
            while let Some((block, profile)) = p.front().map(|(b, p)| (*b, p)) {
                let t = k * profile.duration();
                p.advance(block.length - profile.distance_at(t), profile.speed_at(t));
                looked += t + p.pop().unwrap().1.duration();
            }
            prop_assert!((plain - looked).abs() < 1e-6 * plain.max(1.0), "{} {}", plain, looked);
        }

        /// A longer window is never slower.
        #[test]
        fn looking_further_ahead_saves_time(targets in walk()) {
            let time = |n| -> f64 {
                run(&mut Planner::new(&settings(300.0, n)), &targets).iter().map(|(_, p)| p.duration()).sum()
            };
            let (short, long, all) = (time(2), time(15), time(100));
            prop_assert!(long <= short + 1e-6 && all <= long + 1e-6);
        }
    }
}
