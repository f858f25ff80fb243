//! How long a program takes on a machine that is never kept waiting for the next line.
//!
//! Crosses the border: events in, seconds out. Modelled: the look-ahead window, corners, accelerations, arcs as chords, whole steps,
//! standstills with the motors' idle delay, dwells. *Not* modelled: the link's and the parser's speed, overrides, operator stops,
//! homing, and where a probe really touches (the whole way is counted).

use super::chord::chords;
use super::planner::{Planner, Pushed, Speed, Target};
use super::settings::Settings;
use crate::gcode::{Event, Motion, MotionKind};
use crate::units::Seconds;

/// GRBL dwells in steps of so many seconds, rounded up.
const DWELL_STEP: f64 = 0.05;

/// Where the time goes. `total` is the sum of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Times {
    /// Everything.
    pub total: Seconds,
    /// G1, G2, G3.
    pub cutting: Seconds,
    /// G0, and probing.
    pub air: Seconds,
    /// G4, as the firmware rounds it.
    pub dwell: Seconds,
    /// Idle delays after standstills.
    pub idle: Seconds,
    /// Seconds by line of the program: line n is element n - 1. As long as the last line that does anything.
    pub per_line: Vec<f64>,
}

/// The time of a program. One pass; a few hundred nanoseconds a line.
pub fn program_time(events: &[Event], settings: &Settings) -> Times {
    let mut clock = Clock {
        planner: Planner::new(settings),
        times: Times {
            total: Seconds(0.0),
            cutting: Seconds(0.0),
            air: Seconds(0.0),
            dwell: Seconds(0.0),
            idle: Seconds(0.0),
            per_line: vec![0.0; events.iter().map(Event::line).max().unwrap_or(0)],
        },
        settled: true,
        reseat: true,
    };
    for event in events {
        match event {
            Event::Motion(motion) => clock.travel(motion, None),
            Event::Probe { motion, .. } => {
                clock.stop(motion.line);
                clock.travel(motion, Some(Speed::Fixed(motion.feed)));
                clock.stop(motion.line);
            }
            &Event::Dwell { time, line } => {
                clock.stop(line);
                let steps = (time.0 / DWELL_STEP).ceil().max(0.0);
                let time = Seconds(steps * DWELL_STEP);
                clock.times.dwell += time;
                clock.spend(time, line);
            }
            Event::Pause { optional: true, .. } => {}
            Event::Pause { line, .. }
            | Event::Spindle { line, .. }
            | Event::Coolant { line, .. }
            | Event::ToolChange { line, .. }
            | Event::Sync { line }
            | Event::End { line } => clock.stop(*line),
        }
    }
    clock.drain();
    clock.times
}

struct Clock {
    planner: Planner,
    times: Times,
    /// Nothing has moved since the last standstill.
    settled: bool,
    /// The work coordinates may have changed: take the next motion's start for the position.
    reseat: bool,
}

impl Clock {
    fn spend(&mut self, time: Seconds, line: usize) {
        self.times.total += time;
        if let Some(t) = line
            .checked_sub(1)
            .and_then(|i| self.times.per_line.get_mut(i))
        {
            *t += time.0;
        }
    }

    /// The oldest block runs.
    fn run(&mut self) -> bool {
        let Some((block, profile)) = self.planner.pop() else {
            return false;
        };
        let time = Seconds(profile.duration());
        match block.speed {
            Speed::Rapid | Speed::Fixed(_) => self.times.air += time,
            Speed::Feed(_) | Speed::InverseTime(_) => self.times.cutting += time,
        }
        self.spend(time, block.line);
        true
    }

    fn drain(&mut self) {
        while self.run() {}
    }

    /// Standstill: everything runs out, and the motors are held for a moment if anything moved.
    fn stop(&mut self, line: usize) {
        self.drain();
        if !self.settled {
            let idle = self.planner.settings().idle_delay;
            self.times.idle += idle;
            self.spend(idle, line);
        }
        self.settled = true;
        self.reseat = true;
    }

    fn travel(&mut self, motion: &Motion, speed: Option<Speed>) {
        if self.reseat {
            self.planner.set_position(&motion.from);
            self.reseat = false;
        }
        let speed = speed.unwrap_or(match motion.kind {
            MotionKind::Rapid => Speed::Rapid,
            MotionKind::Feed if motion.inverse_time => Speed::InverseTime(motion.feed.0),
            MotionKind::Feed => Speed::Feed(motion.feed),
        });
        let line = motion.line;
        match &motion.arc {
            None => {
                let to = motion.to;
                self.push(Target { to, speed, line });
            }
            Some(arc) => {
                let tolerance = self.planner.settings().arc_tolerance;
                let chords = chords(&motion.from, &motion.to, arc, tolerance);
                let speed = match speed {
                    // Each chord has its share of the arc's time.
                    Speed::InverseTime(f) => {
                        Speed::InverseTime(f * f64::from(chords.chord_count()))
                    }
                    other => other,
                };
                for to in chords {
                    self.push(Target { to, speed, line });
                }
            }
        }
    }

    fn push(&mut self, target: Target) {
        loop {
            match self.planner.push(target) {
                Pushed::Queued => {
                    self.settled = false;
                    return;
                }
                Pushed::Nothing => return,
                Pushed::Full => {
                    self.run();
                }
            }
        }
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
                let lines: f64 = times.per_line.iter().sum();
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
        assert_eq!(t.per_line.len(), 4);
        assert!((t.per_line[1] - 0.175).abs() < 1e-9);
        // Standing still already: nothing to hold.
        assert_eq!(time("M3S1\nM5\nG4P0\n", &s).total, Seconds(0.0));
        assert_eq!(time("", &s).per_line.len(), 0);
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
