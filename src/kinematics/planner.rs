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
use crate::geom::{Point, Vector};
use crate::machine::Machine;
use crate::units::{Mm, MmPerMin, MmPerSec2, Seconds};
use std::collections::VecDeque;

/// What the planner must know of a machine. Arrays are X, Y, Z; every figure is above zero unless said otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Steps per mm ($100..): targets are rounded to whole steps.
    pub steps_per_mm: [f64; 3],
    /// Highest speed of each axis ($110..).
    pub max_rate: [MmPerMin; 3],
    /// Acceleration of each axis ($120..).
    pub acceleration: [MmPerSec2; 3],
    /// Junction deviation ($11); zero is a stop at each corner.
    pub junction_deviation: Mm,
    /// Arc tolerance ($12).
    pub arc_tolerance: Mm,
    /// Blocks the window holds (15 in GRBL); at least 1.
    pub blocks: usize,
    /// How long the motors are held after each standstill before anything else happens ($1); zero is allowed.
    pub idle_delay: Seconds,
}

/// GRBL's `$1` as shipped.
const IDLE_DELAY: Seconds = Seconds(0.025);

impl From<&Machine> for Settings {
    fn from(m: &Machine) -> Settings {
        Settings {
            steps_per_mm: m.steps_per_mm,
            max_rate: m.max_rate,
            acceleration: m.acceleration,
            junction_deviation: m.junction_deviation,
            arc_tolerance: m.arc_tolerance,
            blocks: m.planner_blocks,
            idle_delay: IDLE_DELAY,
        }
    }
}

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
        let steps = |i: usize| {
            (p[i] * self.settings.steps_per_mm[i])
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
