//! How well a path moves: how hard the tool is thrown up and down while it cuts, how sharply its way turns, and how much of the time
//! it does not cut.
//!
//! Crosses the border: legs (mm, mm/min) and [`Settings`] in, a [`MotionQuality`] out; [`program_time`](super::program_time) gathers
//! the same figures from a program's events. Constant memory besides the planner's window. Knows no shapes.
//!
//! How the vertical figures are made, so that anyone can make them again:
//!
//! ```text
//!  stretch      all that is cut without a rapid, a plunge or a commanded standstill in between (links along the surface are in it)
//!  z(t)         height of the tool tip along the planner's speed profile, every 10 ms from the stretch's beginning; ends of lines
//!               as commanded, not rounded to motor steps (a step of 2.5 um would read as 25 mm/s^2)
//!  a_k          (z_k+1 - 2 z_k + z_k-1) / (10 ms)^2, all three in one stretch
//!  v_k          (z_k - z_k-1) / 10 ms, both in one stretch
//!  RMS          root of the mean square over all k of all stretches
//! ```
//!
//! A corner taken at speed changes the speed at once; it shows as that change over 10 ms.

use super::planner::{Block, Planner, Pushed, Speed, Target};
use super::profile::Profile;
use super::settings::Settings;
use crate::gcode::Arc;
use crate::geom::{Point, Vector};
use crate::units::MmPerMin;
use std::collections::VecDeque;

/// Time between two samples of the height, s.
const SAMPLE: f64 = 0.01;
/// Lines shorter than this are taken together with the next one before directions are compared, mm: rounding turns them any way.
const SHORTEST: f64 = 0.005;
/// Turns beyond this are counted, degrees.
const SHARP: f64 = 30.0;

/// What a leg is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// In the air, at rapid speed.
    Air,
    /// At feed, but not cutting the surface: straight down from the air or straight up into it.
    Plunge,
    /// Cutting.
    Cut,
    /// At feed along the surface from one pass to the next. Counts as cutting for the vertical figures and for turns, since a
    /// program's text does not tell the two apart, but its time is told on its own.
    Link,
}

/// A straight move of the tool tip to `to` from wherever the last one ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Where it ends, mm.
    pub to: Point,
    /// What for.
    pub purpose: Purpose,
    /// At what feed; ignored in the air.
    pub feed: MmPerMin,
}

/// The figures of a path. Times in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionQuality {
    /// From first to last motion, standstills included.
    pub time: f64,
    /// Cutting, without plunges and links.
    pub cutting: f64,
    /// Links along the surface at feed; zero for a program's text, where they are in `cutting`.
    pub link: f64,
    /// Straight down from the air or up into it, at feed.
    pub plunge: f64,
    /// Rapid moves (and probing).
    pub air: f64,
    /// Root of the mean square of the tool's vertical acceleration while it cuts, mm/s²; zero when nothing is cut.
    pub vertical_acceleration_rms: f64,
    /// The same of its vertical speed, mm/s.
    pub vertical_speed_rms: f64,
    /// Largest turn between two consecutive cutting moves, degrees: 0 straight on, 180 back. Arcs are compared by their tangents.
    pub largest_turn: f64,
    /// Line of the program (from 1), or number of the leg (from 0), that begins with the largest turn.
    pub largest_turn_at: Option<usize>,
    /// How many turns exceed 30 degrees.
    pub turns_over_30: usize,
    /// Largest of the turns up to 30 degrees.
    pub largest_gentle_turn: f64,
    /// Where that is, as `largest_turn_at`.
    pub largest_gentle_turn_at: Option<usize>,
}

/// A turn of more than 30 degrees between two cutting moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpTurn {
    /// Where the tool tip turns, mm.
    pub at: Point,
    /// Way before it, unit vector.
    pub before: Vector,
    /// Way after it, unit vector.
    pub after: Vector,
    /// Line that begins with it, from 1.
    pub line: usize,
}

/// Sharp turns beyond so many are counted, but not kept: a program is as long as it likes.
pub const SHARP_KEPT: usize = 100_000;

impl MotionQuality {
    /// Time that leaves nothing finished: air, plunges and links, s.
    pub fn non_cutting(&self) -> f64 {
        self.air + self.plunge + self.link
    }

    /// The same as a share of the whole time, %; zero for an empty path.
    pub fn non_cutting_percent(&self) -> f64 {
        if self.time > 0.0 {
            100.0 * self.non_cutting() / self.time
        } else {
            0.0
        }
    }
}

/// The figures of a path that is not posted yet, from a standstill at `from` to a standstill at its end. One pass, well over a
/// million legs a second. Agrees with [`program_time`](super::program_time) on the posted text up to the text's rounding and the
/// firmware's idle delays.
pub fn path_quality(
    from: &Point,
    legs: impl IntoIterator<Item = Leg>,
    settings: &Settings,
) -> MotionQuality {
    let mut run = Run::new(settings);
    run.seat(from);
    let mut at = *from;
    for (line, leg) in legs.into_iter().enumerate() {
        let speed = match leg.purpose {
            Purpose::Air => Speed::Rapid,
            _ => Speed::Feed(leg.feed),
        };
        run.way.straight(leg.purpose, &at, &leg.to, line);
        run.push(
            Target {
                to: leg.to,
                speed,
                line,
            },
            leg.purpose,
            &mut |_, _, _| {},
        );
        at = leg.to;
    }
    run.standstill(&mut |_, _, _| {});
    run.quality()
}

/// A planner that is popped when full, and what is read off the blocks that leave it.
pub(super) struct Run {
    planner: Planner,
    /// Purpose and exact start and end of each block in the window.
    due: VecDeque<(Purpose, f64, f64)>,
    /// Height at which the newest block ends, as commanded.
    z: f64,
    vertical: Vertical,
    /// What the turns are read from.
    pub(super) way: Way,
    times: MotionQuality,
}

/// Called with each block as it leaves the window.
pub(super) type Each<'a> = &'a mut dyn FnMut(&Block, f64, Purpose);

impl Run {
    pub(super) fn new(settings: &Settings) -> Run {
        Run {
            planner: Planner::new(settings),
            due: VecDeque::with_capacity(settings.blocks.max(1)),
            z: 0.0,
            vertical: Vertical::default(),
            way: Way::default(),
            times: MotionQuality::default(),
        }
    }

    /// The machine stands here. Only at a standstill.
    pub(super) fn seat(&mut self, p: &Point) {
        self.planner.set_position(p);
        self.z = p.z;
    }

    pub(super) fn settings(&self) -> &Settings {
        self.planner.settings()
    }

    /// Appends a line, running older blocks as room is needed. True if it moves the machine at all.
    pub(super) fn push(&mut self, target: Target, purpose: Purpose, each: Each) -> bool {
        loop {
            match self.planner.push(target) {
                Pushed::Queued => {
                    self.due.push_back((purpose, self.z, target.to.z));
                    self.z = target.to.z;
                    return true;
                }
                Pushed::Nothing => return false,
                Pushed::Full => {
                    self.run(each);
                }
            }
        }
    }

    /// The oldest block runs.
    fn run(&mut self, each: Each) -> bool {
        let Some((block, profile)) = self.planner.pop() else {
            return false;
        };
        let time = profile.duration();
        let (purpose, from, to) = self.due.pop_front().unwrap_or((Purpose::Air, 0.0, 0.0));
        *match purpose {
            Purpose::Air => &mut self.times.air,
            Purpose::Plunge => &mut self.times.plunge,
            Purpose::Cut => &mut self.times.cutting,
            Purpose::Link => &mut self.times.link,
        } += time;
        self.times.time += time;
        match purpose {
            Purpose::Cut | Purpose::Link => self.vertical.block(&profile, from, to - from),
            Purpose::Air | Purpose::Plunge => self.vertical.lift(),
        }
        each(&block, time, purpose);
        true
    }

    /// Everything runs out.
    pub(super) fn standstill(&mut self, each: Each) {
        while self.run(each) {}
        self.vertical.lift();
    }

    /// Time in which nothing moves, s. After a standstill.
    pub(super) fn wait(&mut self, time: f64) {
        self.times.time += time;
    }

    /// What was seen so far.
    pub(super) fn quality(&self) -> MotionQuality {
        MotionQuality {
            vertical_acceleration_rms: self.vertical.acceleration.rms(),
            vertical_speed_rms: self.vertical.speed.rms(),
            largest_turn: self.way.largest.to_degrees(),
            largest_turn_at: self.way.largest_at,
            turns_over_30: self.way.sharp,
            largest_gentle_turn: self.way.gentle.to_degrees(),
            largest_gentle_turn_at: self.way.gentle_at,
            ..self.times
        }
    }
}

/// A sum of squares.
#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    count: f64,
    sum: f64,
}

impl Squares {
    fn add(&mut self, v: f64) {
        self.count += 1.0;
        self.sum += v * v;
    }

    /// `n` values from `first` on, each `more` above the one before.
    fn add_rising(&mut self, first: f64, more: f64, n: f64) {
        self.count += n;
        self.sum += n * first * first
            + first * more * n * (n - 1.0)
            + more * more * (n - 1.0) * n * (2.0 * n - 1.0) / 6.0;
    }

    fn rms(&self) -> f64 {
        if self.count > 0.0 {
            (self.sum / self.count).max(0.0).sqrt()
        } else {
            0.0
        }
    }
}

/// Samples the height of one stretch after the other.
#[derive(Clone, Copy, Debug, Default)]
struct Vertical {
    /// Time until the next sample, s.
    wait: f64,
    /// Samples of this stretch so far, at most 2.
    seen: u8,
    /// The last two of them, newest last, mm.
    last: [f64; 2],
    acceleration: Squares,
    speed: Squares,
}

impl Vertical {
    /// A stretch ends.
    fn lift(&mut self) {
        self.wait = 0.0;
        self.seen = 0;
    }

    /// One more block of the stretch, from the height `z` and up by `rise`.
    fn block(&mut self, profile: &Profile, z: f64, rise: f64) {
        // Height gained per mm of way.
        let slope = rise / profile.length;
        if !slope.is_finite() {
            return;
        }
        for p in profile.phases() {
            self.phase(
                p.duration,
                z + slope * p.start,
                slope * p.speed,
                slope * p.slope,
            );
        }
    }

    /// A time of steady acceleration `a`, beginning at the height `z` with the vertical speed `v`. Constant cost: a feed of a
    /// millimetre in an hour must not take an hour to judge.
    fn phase(&mut self, duration: f64, z: f64, v: f64, a: f64) {
        if self.wait >= duration {
            self.wait -= duration;
            return;
        }
        let n = ((duration - self.wait) / SAMPLE).floor() + 1.0;
        let time = |k: f64| self.wait + k * SAMPLE;
        let height = |k: f64| z + time(k) * (v + 0.5 * a * time(k));
        let (mut seen, mut last) = (self.seen, self.last);
        let mut k = 0.0;
        while k < n.min(2.0) {
            let now = height(k);
            if seen > 0 {
                self.speed.add((now - last[1]) / SAMPLE);
            }
            if seen > 1 {
                self.acceleration
                    .add((now - 2.0 * last[1] + last[0]) / (SAMPLE * SAMPLE));
            }
            last = [last[1], now];
            seen = (seen + 1).min(2);
            k += 1.0;
        }
        if n > 2.0 {
            // The others have their two forerunners in this very phase.
            self.acceleration.add_rising(a, 0.0, n - 2.0);
            self.speed
                .add_rising(v + a * (time(2.0) - 0.5 * SAMPLE), a * SAMPLE, n - 2.0);
            last = [height(n - 2.0), height(n - 1.0)];
        }
        // Never below zero but by rounding.
        self.wait = (time(n) - duration).max(0.0);
        (self.seen, self.last) = (seen, last);
    }
}

/// Follows the way of the tool and finds its turns.
#[derive(Clone, Debug, Default)]
pub(super) struct Way {
    /// Where the last direction was told, and the direction; `None` when nothing was cut since the tool was in the air.
    anchor: Option<Point>,
    direction: Option<Vector>,
    /// rad.
    largest: f64,
    largest_at: Option<usize>,
    sharp: usize,
    /// Largest of those that are not sharp, rad.
    gentle: f64,
    gentle_at: Option<usize>,
    /// The first [`SHARP_KEPT`] sharp ones.
    pub(super) kept: Vec<SharpTurn>,
}

impl Way {
    fn begin(&mut self, purpose: Purpose, from: &Point) -> Option<Point> {
        match purpose {
            Purpose::Cut | Purpose::Link => Some(*self.anchor.get_or_insert(*from)),
            Purpose::Air | Purpose::Plunge => {
                self.anchor = None;
                self.direction = None;
                None
            }
        }
    }

    /// A straight line.
    pub(super) fn straight(&mut self, purpose: Purpose, from: &Point, to: &Point, line: usize) {
        let Some(anchor) = self.begin(purpose, from) else {
            return;
        };
        let way = to - anchor;
        let length = way.norm();
        if length >= SHORTEST {
            let d = way / length;
            self.turn(&d, line);
            self.direction = Some(d);
            self.anchor = Some(*to);
        }
    }

    /// An arc or helix.
    pub(super) fn arc(
        &mut self,
        purpose: Purpose,
        from: &Point,
        to: &Point,
        arc: &Arc,
        line: usize,
    ) {
        let [first, last] = tangents(from, to, arc);
        if first.norm() < SHORTEST {
            return self.straight(purpose, from, to, line);
        }
        if self.begin(purpose, from).is_some() {
            self.turn(&first.normalize(), line);
            self.direction = Some(last.normalize());
            self.anchor = Some(*to);
        }
    }

    fn turn(&mut self, next: &Vector, line: usize) {
        let Some(before) = &self.direction else {
            return;
        };
        let turn = before.cross(next).norm().atan2(before.dot(next));
        if turn.to_degrees() > SHARP + 1e-6 {
            self.sharp += 1;
            if let Some(at) = self.anchor.filter(|_| self.kept.len() < SHARP_KEPT) {
                self.kept.push(SharpTurn {
                    at,
                    before: *before,
                    after: *next,
                    line,
                });
            }
        } else if turn > self.gentle || self.gentle_at.is_none() {
            (self.gentle, self.gentle_at) = (turn, Some(line));
        }
        if turn > self.largest || self.largest_at.is_none() {
            self.largest = turn;
            self.largest_at = Some(line);
        }
    }
}

/// Derivatives of the place along an arc by its share, at its beginning and its end; as long as the arc.
fn tangents(from: &Point, to: &Point, arc: &Arc) -> [Vector; 2] {
    let [a, b, n] = arc.plane.axes();
    let r = [from[a] - arc.center[a], from[b] - arc.center[b]];
    let (sin, cos) = arc.sweep.sin_cos();
    [r, [r[0] * cos - r[1] * sin, r[0] * sin + r[1] * cos]].map(|r| {
        let mut t = Vector::zeros();
        t[a] = -r[1] * arc.sweep;
        t[b] = r[0] * arc.sweep;
        t[n] = to[n] - from[n];
        t
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::program_time;
    use super::*;
    use crate::gcode::{Dialect, interpret};
    use crate::units::{Mm, MmPerSec2, Seconds};
    use proptest::prelude::*;
    use std::fmt::Write as _;

    fn settings(acceleration: f64, junction: f64) -> Settings {
        Settings {
            steps_per_mm: [1000.0; 3],
            max_rate: [MmPerMin(6000.0); 3],
            acceleration: [MmPerSec2(acceleration); 3],
            junction_deviation: Mm(junction),
            arc_tolerance: Mm(0.002),
            blocks: 15,
            idle_delay: Seconds(0.025),
        }
    }

    fn of(text: &str, s: &Settings) -> MotionQuality {
        program_time(&interpret(text, Dialect::Grbl).unwrap().events, s).motion
    }

    fn cut(points: &[[f64; 3]]) -> Vec<Leg> {
        points
            .iter()
            .map(|p| Leg {
                to: Point::from(*p),
                purpose: Purpose::Cut,
                feed: MmPerMin(1200.0),
            })
            .collect()
    }

    /// Every sample by itself, from whole profiles: what the sums in closed form must equal.
    fn by_hand(from: [f64; 3], legs: &[Leg], s: &Settings) -> (f64, f64) {
        let mut planner = Planner::new(s);
        planner.set_position(&Point::from(from));
        let mut run: Vec<(f64, f64, Profile)> = vec![];
        let mut due: VecDeque<(f64, f64)> = VecDeque::new();
        let mut z = from[2];
        for leg in legs {
            let target = Target {
                to: leg.to,
                speed: Speed::Feed(leg.feed),
                line: 0,
            };
            loop {
                match planner.push(target) {
                    Pushed::Full => {
                        let (from, to) = due.pop_front().unwrap();
                        run.push((from, to, planner.pop().unwrap().1));
                    }
                    Pushed::Nothing => break,
                    Pushed::Queued => {
                        due.push_back((z, leg.to.z));
                        z = leg.to.z;
                        break;
                    }
                }
            }
        }
        while let Some((_, p)) = planner.pop() {
            let (from, to) = due.pop_front().unwrap();
            run.push((from, to, p));
        }
        let mut zs = vec![];
        let mut begin = 0.0;
        for (from, to, p) in &run {
            let end = begin + p.duration();
            loop {
                let t = zs.len() as f64 * SAMPLE;
                if t >= end {
                    break;
                }
                zs.push(from + (to - from) * p.distance_at(t - begin) / p.length);
            }
            begin = end;
        }
        let rms =
            |v: Vec<f64>| (v.iter().map(|x| x * x).sum::<f64>() / (v.len() as f64).max(1.0)).sqrt();
        (
            rms(zs
                .windows(3)
                .map(|w| (w[2] - 2.0 * w[1] + w[0]) / SAMPLE.powi(2))
                .collect()),
            rms(zs.windows(2).map(|w| (w[1] - w[0]) / SAMPLE).collect()),
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn sums_equal_samples(
            points in proptest::collection::vec(proptest::array::uniform3(-3.0..3.0f64), 1..40), a in 20.0..2000.0f64,
        ) {
            let s = settings(a, 0.01);
            let legs = cut(&points);
            let q = path_quality(&Point::origin(), legs.iter().copied(), &s);
            let (acceleration, speed) = by_hand([0.0; 3], &legs, &s);
            // A sample may fall to either side of a corner by rounding of the time.
            prop_assert!((q.vertical_acceleration_rms - acceleration).abs() < 1e-3 * acceleration.max(1.0), "{} {acceleration}", q.vertical_acceleration_rms);
            prop_assert!((q.vertical_speed_rms - speed).abs() < 1e-3 * speed.max(0.1), "{} {speed}", q.vertical_speed_rms);
        }

        /// The text says the same as the path it was made from.
        #[test]
        fn text_and_path_agree(steps in proptest::collection::vec((0..4usize, -2000..2000i32, -2000..2000i32, -300..300i32), 1..60)) {
            let s = settings(400.0, 0.01);
            let mut text = String::from("G90 G21 G94\n");
            let mut legs = vec![];
            let mut last = (-1, -1);
            for &(kind, x, y, z) in &steps {
                let (kind, x, y) = match kind {
                    0 => ("G0", x, y),
                    // Vertical only next to a rapid, as the text takes it.
                    1 if last != (-1, -1) => ("G0", last.0, last.1),
                    _ => ("G1", x, y),
                };
                last = (x, y);
                let to = Point::new(f64::from(x), f64::from(y), f64::from(z)) / 1000.0;
                legs.push(Leg {
                    to,
                    purpose: if kind == "G0" { Purpose::Air } else { Purpose::Cut },
                    feed: MmPerMin(1500.0),
                });
                writeln!(text, "{kind} X{} Y{} Z{}{}", to.x, to.y, to.z, if kind == "G0" { "" } else { " F1500" }).unwrap();
            }
            let (a, b) = (path_quality(&Point::origin(), legs, &s), of(&text, &s));
            prop_assert!((a.time - b.time).abs() < 1e-9);
            prop_assert!((a.vertical_acceleration_rms - b.vertical_acceleration_rms).abs() < 1e-9);
            prop_assert!((a.largest_turn - b.largest_turn).abs() < 1e-9);
            prop_assert_eq!(a.turns_over_30, b.turns_over_30);
        }
    }

    #[test]
    fn level_paths_have_no_vertical_motion() {
        let q = path_quality(
            &Point::origin(),
            cut(&[[10.0, 0.0, 0.0], [10.0, 10.0, 0.0], [0.0, 0.0, 0.0]]),
            &settings(500.0, 0.01),
        );
        assert_eq!(q.vertical_acceleration_rms, 0.0);
        assert_eq!(q.vertical_speed_rms, 0.0);
        assert!((q.largest_turn - 135.0).abs() < 1e-9);
        assert_eq!((q.largest_turn_at, q.turns_over_30), (Some(2), 2));
        let none = path_quality(&Point::origin(), [], &settings(500.0, 0.01));
        assert_eq!(none, MotionQuality::default());
        assert_eq!(none.non_cutting_percent(), 0.0);
    }

    /// A wave z = A sin(k x) taken at speed v has the vertical acceleration A (k v)^2 / sqrt 2.
    #[test]
    fn a_wave_by_hand() {
        let (height, k) = (0.5, 2.0 * std::f64::consts::PI / 20.0);
        let points: Vec<[f64; 3]> = (1..=20_000)
            .map(|i| 0.02 * f64::from(i))
            .map(|x| [x, 0.0, height * (k * x).sin()])
            .collect();
        let mut s = settings(1e5, 0.01);
        s.steps_per_mm = [1e6; 3];
        // The window is long enough to reach full speed.
        s.blocks = 60;
        let q = path_quality(&Point::origin(), cut(&points), &s);
        let want = height * (k * 20.0f64).powi(2) / 2f64.sqrt();
        // The speed along the slope is 20 mm/s, the one along x a little less.
        assert!(
            (q.vertical_acceleration_rms / want - 1.0).abs() < 0.03,
            "{} {want}",
            q.vertical_acceleration_rms
        );
        let want = height * k * 20.0 / 2f64.sqrt();
        assert!((q.vertical_speed_rms / want - 1.0).abs() < 0.03);
        assert!(q.largest_turn < 0.1);
    }

    #[test]
    fn plunges_and_withdrawals_are_not_cutting() {
        let s = settings(500.0, 0.01);
        let q = of(
            "G0 Z5\nG0 X10\nG1 Z1 F300\nM8\nG1 Z0\nG1 X20 F600\nG1 Z-1\nG1 X30\nG1 Z2\nG0 Z5\n",
            &s,
        );
        // Down from 5 to 0 in two goes and up by 2: not cutting. Down by 1 between two passes: cutting, 2 sharp turns.
        assert_eq!((q.turns_over_30, q.largest_turn_at), (2, Some(7)));
        assert!((q.largest_turn - 90.0).abs() < 1e-9);
        assert!(q.plunge > 5.0 / 5.0 && q.cutting > 2.1 && q.cutting < 2.5);
        // One standstill, for the coolant.
        let idle = s.idle_delay.0;
        assert!((q.time - q.cutting - q.plunge - q.air - idle).abs() < 1e-9);
        assert!((q.non_cutting_percent() - 100.0 * (q.plunge + q.air) / q.time).abs() < 1e-9);
        // Drilling cuts no surface.
        let q = of("G0 X1\nG1 Z-1 F100\nG1 Z1\nG0 X2\nG1 Z-1\nG1 Z1\n", &s);
        assert_eq!(
            (q.cutting, q.vertical_acceleration_rms, q.largest_turn_at),
            (0.0, 0.0, None)
        );
    }

    #[test]
    fn arcs_are_smooth_and_shreds_are_no_corners() {
        let s = settings(500.0, 0.01);
        // Tangent in, tangent out; by chords it would turn by many degrees.
        let q = of("G1 X1 F600\nG3 X1 Y0.2 J0.1\nG1 X0\n", &s);
        assert!(q.largest_turn < 1e-6, "{}", q.largest_turn);
        // A quarter helix back into the line it came from.
        let q = of("G1 X1 F600\nG2 X2 Y-1 Z1 J-1\nG1 Y-2\n", &s);
        let rise = (1.0f64).atan2(std::f64::consts::FRAC_PI_2).to_degrees();
        assert!((q.largest_turn - rise).abs() < 1e-6);
        // 2 um sideways and back is rounding; 20 um is a corner.
        assert!(of("G1 X1 F600\nG1 Y0.002\nG1 X2 Y0\n", &s).largest_turn < 0.2);
        assert!((of("G1 X1 F600\nG1 Y0.02\nG1 X2 Y0\n", &s).largest_turn - 91.1).abs() < 0.1);
        // Back the way it came.
        let q = of("G1 X1 F600\nG1 X0\n", &s);
        assert!((q.largest_turn - 180.0).abs() < 1e-9 && q.largest_turn_at == Some(2));
    }

    #[test]
    fn an_endless_move_is_judged_at_once() {
        let s = settings(500.0, 0.01);
        let q = of("G1 X1000000 Z1000000 F1\n", &s);
        assert!((q.time - 6e7 * 2f64.sqrt()).abs() < 1.0);
        assert!((q.vertical_speed_rms - 1.0 / 60.0 / 2f64.sqrt()).abs() < 1e-9);
    }
}
