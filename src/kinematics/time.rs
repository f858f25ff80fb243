//! How long a program takes on a machine that is never kept waiting for the next line.
//!
//! Crosses the border: events in, one by one, seconds out, by line and in sum. Memory does not grow with the program. Modelled: the
//! look-ahead window, corners, accelerations, arcs as chords, whole steps, standstills with the motors' idle delay, dwells. *Not*
//! modelled: the link's and the parser's speed, overrides, operator stops, homing, and where a probe really touches (the whole way is
//! counted).

use super::chord::chords;
use super::planner::{Block, Speed, Target};
use super::quality::{MotionQuality, Purpose, Run, SharpTurn};
use super::settings::Settings;
use crate::gcode::{Event, Motion, MotionKind};
use crate::units::Seconds;

/// GRBL dwells in steps of so many seconds, rounded up.
const DWELL_STEP: f64 = 0.05;

/// Where the time goes. `total` is the sum of cutting, air, dwell and idle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    /// Everything.
    pub total: Seconds,
    /// G1, G2, G3, plunges among them.
    pub cutting: Seconds,
    /// G0, and probing.
    pub air: Seconds,
    /// G4, as the firmware rounds it.
    pub dwell: Seconds,
    /// Idle delays after standstills.
    pub idle: Seconds,
    /// How well it moves. Here feed moves without X and Y next to a rapid are plunges, and links count as cutting.
    pub motion: MotionQuality,
    /// Its turns of more than 30 degrees, the first [`SHARP_KEPT`](super::quality::SHARP_KEPT) of them.
    pub sharp_turns: Vec<SharpTurn>,
}

/// The time of a program that is in memory, and how well it moves: a fold over [`Clock`].
pub fn program_time(events: &[Event], settings: &Settings) -> Times {
    let mut clock = Clock::new(settings);
    for event in events {
        clock.hear(event, &mut |_, _| {});
    }
    clock.finish(&mut |_, _| {})
}

/// Seconds by line of the program: line n is element n - 1. As long as the last line that does anything.
pub fn line_times(events: &[Event], settings: &Settings) -> Vec<f64> {
    let mut lines = vec![0.0; events.iter().map(Event::line).max().unwrap_or(0)];
    let mut add = |line: usize, time: f64| {
        if let Some(t) = line.checked_sub(1).and_then(|i| lines.get_mut(i)) {
            *t += time;
        }
    };
    let mut clock = Clock::new(settings);
    for event in events {
        clock.hear(event, &mut add);
    }
    clock.finish(&mut add);
    lines
}

/// Is told a line of the program and seconds that go to it. A line may be told several times, in parts; lines come in the order in which
/// they are run, some blocks behind the events.
pub type Spent<'a> = &'a mut dyn FnMut(usize, f64);

/// Times a program that comes event by event. Memory: the planner's window, and what [`MOST_HELD`] says; whatever the program's length.
pub struct Clock {
    upright: Upright,
    stroke: Stroke,
}

impl Clock {
    /// A machine with these settings that stands still.
    pub fn new(settings: &Settings) -> Clock {
        Clock {
            upright: Upright::default(),
            stroke: Stroke {
                run: Run::new(settings),
                times: Times::default(),
                settled: true,
                reseat: true,
            },
        }
    }

    /// The next event. `spent` is told what becomes certain by it.
    pub fn hear(&mut self, event: &Event, spent: Spent) {
        let stroke = &mut self.stroke;
        self.upright.hear(event, &mut |event, purpose| {
            stroke.event(event, purpose, spent)
        });
    }

    /// Seconds of the program that are certain: those of what has left the planner's window.
    pub fn so_far(&self) -> Seconds {
        self.stroke.times.total
    }

    /// No more events: everything runs out.
    pub fn finish(mut self, spent: Spent) -> Times {
        let stroke = &mut self.stroke;
        self.upright
            .finish(&mut |event, purpose| stroke.event(event, purpose, spent));
        let Stroke { run, times, .. } = &mut self.stroke;
        run.standstill(&mut |b, t, p| times.ran(b, t, p, spent));
        let mut times = self.stroke.times;
        times.motion = self.stroke.run.quality();
        times.sharp_turns = std::mem::take(&mut self.stroke.run.way.kept);
        times
    }
}

/// Events held back at most until it is known what a run of upright feed moves is for; a longer run behind a cut is a cut.
pub const MOST_HELD: usize = 4096;

/// Tells plunges and withdrawals from cuts: runs of upright feed moves that begin or end in the air. Whether a run that begins at a cut
/// ends in the air is known only behind it: so long its events are held back.
#[derive(Default)]
struct Upright {
    /// The last motion was at feed.
    after_feed: bool,
    /// What the present run is for, once it is known.
    run: Option<Purpose>,
    /// The run's events so far while it is not known, its first motion first.
    held: Vec<Event>,
}

/// Is told an event, and what it is for if it is a motion.
type Told<'a> = &'a mut dyn FnMut(&Event, Purpose);

impl Upright {
    fn hear(&mut self, event: &Event, tell: Told) {
        let purpose = match event {
            Event::Motion(m) if m.kind == MotionKind::Feed => {
                let after_feed = std::mem::replace(&mut self.after_feed, true);
                if !upright(m) {
                    self.end(Purpose::Cut, tell);
                    Purpose::Cut
                } else if let Some(purpose) = self.run {
                    purpose
                } else if self.held.is_empty() && !after_feed {
                    *self.run.insert(Purpose::Plunge)
                } else {
                    return self.hold(event, tell);
                }
            }
            Event::Motion(_) | Event::Probe { .. } => {
                self.after_feed = false;
                self.end(Purpose::Plunge, tell);
                Purpose::Air
            }
            _ if !self.held.is_empty() => return self.hold(event, tell),
            _ => Purpose::Air,
        };
        tell(event, purpose);
    }

    fn hold(&mut self, event: &Event, tell: Told) {
        self.held.push(event.clone());
        if self.held.len() >= MOST_HELD {
            self.end(Purpose::Cut, tell);
            self.run = Some(Purpose::Cut);
        }
    }

    /// The run is over, and was for this if that was not known.
    fn end(&mut self, purpose: Purpose, tell: Told) {
        self.run = None;
        for event in self.held.drain(..) {
            tell(&event, purpose);
        }
    }

    fn finish(&mut self, tell: Told) {
        self.end(Purpose::Plunge, tell);
    }
}

fn upright(m: &Motion) -> bool {
    m.arc.is_none() && m.from.x == m.to.x && m.from.y == m.to.y
}

impl Times {
    fn spend(&mut self, time: Seconds, line: usize, spent: Spent) {
        self.total += time;
        spent(line, time.0);
    }

    fn ran(&mut self, block: &Block, time: f64, purpose: Purpose, spent: Spent) {
        let time = Seconds(time);
        match purpose {
            Purpose::Air => self.air += time,
            Purpose::Plunge | Purpose::Cut | Purpose::Link => self.cutting += time,
        }
        self.spend(time, block.line, spent);
    }
}

/// The planner with what stops it.
struct Stroke {
    run: Run,
    times: Times,
    /// Nothing has moved since the last standstill.
    settled: bool,
    /// The work coordinates may have changed: take the next motion's start for the position.
    reseat: bool,
}

impl Stroke {
    fn event(&mut self, event: &Event, purpose: Purpose, spent: Spent) {
        match event {
            Event::Motion(motion) => self.travel(motion, None, purpose, spent),
            Event::Probe { motion, .. } => {
                self.stop(motion.line, spent);
                self.travel(motion, Some(Speed::Fixed(motion.feed)), Purpose::Air, spent);
                self.stop(motion.line, spent);
            }
            &Event::Dwell { time, line } => {
                self.stop(line, spent);
                let steps = (time.0 / DWELL_STEP).ceil().max(0.0);
                let time = Seconds(steps * DWELL_STEP);
                self.times.dwell += time;
                self.run.wait(time.0);
                self.times.spend(time, line, spent);
            }
            Event::Pause { optional: true, .. } => {}
            Event::Pause { line, .. }
            | Event::Spindle { line, .. }
            | Event::Coolant { line, .. }
            | Event::ToolChange { line, .. }
            | Event::Sync { line }
            | Event::End { line } => self.stop(*line, spent),
        }
    }

    /// Standstill: everything runs out, and the motors are held for a moment if anything moved.
    fn stop(&mut self, line: usize, spent: Spent) {
        let times = &mut self.times;
        self.run
            .standstill(&mut |b, t, p| times.ran(b, t, p, spent));
        if !self.settled {
            let idle = self.run.settings().idle_delay;
            self.times.idle += idle;
            self.run.wait(idle.0);
            self.times.spend(idle, line, spent);
        }
        self.settled = true;
        self.reseat = true;
    }

    fn travel(&mut self, motion: &Motion, speed: Option<Speed>, purpose: Purpose, spent: Spent) {
        if self.reseat {
            self.run.seat(&motion.from);
            self.reseat = false;
        }
        let speed = speed.unwrap_or(match motion.kind {
            MotionKind::Rapid => Speed::Rapid,
            MotionKind::Feed if motion.inverse_time => Speed::InverseTime(motion.feed.0),
            MotionKind::Feed => Speed::Feed(motion.feed),
        });
        let (from, to, line) = (&motion.from, motion.to, motion.line);
        match &motion.arc {
            None => {
                self.run.way.straight(purpose, from, &to, line);
                self.push(Target { to, speed, line }, purpose, spent);
            }
            Some(arc) => {
                self.run.way.arc(purpose, from, &to, arc, line);
                let chords = chords(from, &to, arc, self.run.settings().arc_tolerance);
                let speed = match speed {
                    // Each chord has its share of the arc's time.
                    Speed::InverseTime(f) => {
                        Speed::InverseTime(f * f64::from(chords.chord_count()))
                    }
                    other => other,
                };
                for to in chords {
                    self.push(Target { to, speed, line }, purpose, spent);
                }
            }
        }
    }

    fn push(&mut self, target: Target, purpose: Purpose, spent: Spent) {
        let times = &mut self.times;
        let moves = self.run.push(target, purpose, &mut |b, t, p| {
            times.ran(b, t, p, spent);
        });
        self.settled &= !moves;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gcode::{Dialect, interpret};
    use crate::units::{Mm, MmPerMin, MmPerSec2};

    fn settings(steps: [f64; 3], rate: [f64; 3], acceleration: [f64; 3], d: f64) -> Settings {
        Settings {
            steps_per_mm: steps,
            max_rate: rate.map(MmPerMin),
            acceleration: acceleration.map(MmPerSec2),
            junction_deviation: Mm(d),
            arc_tolerance: Mm(0.002),
            blocks: 15,
            idle_delay: Seconds(0.025),
        }
    }

    /// The set-ups of the recordings, by their letters.
    fn recorded() -> [Settings; 3] {
        [
            settings([250.0; 3], [500.0; 3], [10.0; 3], 0.01),
            settings(
                [80.0, 80.0, 400.0],
                [5000.0, 5000.0, 1000.0],
                [400.0, 400.0, 100.0],
                0.01,
            ),
            settings(
                [160.0, 160.0, 320.0],
                [3000.0, 3000.0, 800.0],
                [150.0, 150.0, 50.0],
                0.02,
            ),
        ]
    }

    /// First to last step pulse of the unmodified firmware, s, for the three set-ups. Seen: -0.08 to 0 % where nothing stops the
    /// machine; -0.08 to -0.45 % with 15 standstills, each some 3 to 5 ms longer there (reading on, starting again).
    #[test]
    fn agrees_with_the_firmware() {
        for (name, text, measured) in [
            (
                "spiral",
                include_str!("../../tests/gcode/ok/t03_spiral_02mm.nc"),
                [60.411565, 18.979593, 19.08257],
            ),
            (
                "zigzag",
                include_str!("../../tests/gcode/ok/t05_zigzag.nc"),
                [182.126513, 32.337574, 46.480829],
            ),
            (
                "raster",
                include_str!("../../tests/gcode/ok/t08_raster_pocket.nc"),
                [93.30887, 19.660105, 22.875313],
            ),
            (
                "G93, dwell, spindle",
                include_str!("../../tests/gcode/ok/t12_g93_dwell_spindle.nc"),
                [48.154972, 16.204956, 18.46483],
            ),
        ] {
            let program = interpret(text, Dialect::Grbl).unwrap();
            for (settings, measured) in recorded().iter().zip(measured) {
                let times = program_time(&program.events, settings);
                let total = times.total.0;
                let off = total / measured - 1.0;
                assert!(
                    off.abs() < 0.005,
                    "{name}: {total:.3} s, measured {measured:.3} s"
                );
                let lines: f64 = line_times(&program.events, settings).iter().sum();
                assert!((lines - total).abs() < 1e-6);
            }
        }
    }

    fn time(text: &str, settings: &Settings) -> Times {
        program_time(&interpret(text, Dialect::Grbl).unwrap().events, settings)
    }

    #[test]
    fn each_kind_of_time_by_hand() {
        let s = settings([1000.0; 3], [6000.0; 3], [100.0; 3], 0.01);
        // 10 mm at 10 mm/s with ramps of 0.1 s: 1.1 s. Dwell 0.11 s is 0.15 s. The stop before it is held for 25 ms.
        let t = time("G1X10F600\nG4P0.11\nG0X110\nM30\n", &s);
        assert!((t.cutting.0 - 1.1).abs() < 1e-9);
        assert!((t.dwell.0 - 0.15).abs() < 1e-9);
        // 100 mm at 100 mm/s: ramps of 1 s, which is just enough for full speed.
        assert!((t.air.0 - 2.0).abs() < 1e-9);
        assert!((t.idle.0 - 0.05).abs() < 1e-9);
        assert!((t.total.0 - 3.3).abs() < 1e-9);
        let lines = line_times(
            &interpret("G1X10F600\nG4P0.11\nG0X110\nM30\n", Dialect::Grbl)
                .unwrap()
                .events,
            &s,
        );
        assert_eq!(lines.len(), 4);
        assert!((lines[1] - 0.175).abs() < 1e-9);
        // Standing still already: nothing to hold.
        assert_eq!(time("M3S1\nM5\nG4P0\n", &s).total, Seconds(0.0));
        assert_eq!(line_times(&[], &s).len(), 0);
    }

    #[test]
    fn inverse_time_arcs_take_their_time() {
        let s = settings([1000.0; 3], [6000.0; 3], [5000.0; 3], 0.01);
        let t = time("G93G2X10Y0I5F6\n", &s);
        assert!((t.total.0 - 10.0).abs() < 0.05, "{}", t.total.0);
    }

    #[test]
    fn changing_coordinates_moves_nothing() {
        let s = settings([1000.0; 3], [6000.0; 3], [100.0; 3], 0.01);
        let plain = time("G1X10F600\nG4P0\nX20\n", &s);
        let shifted = time("G1X10F600\nG92X500\nX510\n", &s);
        assert!((plain.total.0 - shifted.total.0).abs() < 1e-9);
    }
}
