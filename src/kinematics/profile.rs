//! The speed of one block over its length: at most one ramp, one steady stretch, one ramp.
//!
//! ```text
//!  speed                cruise
//!    |        ____________________
//!    |       /                    \        each slope: the block's acceleration
//!    |      /                      \
//!    | entry                        exit
//!    +------|----|------------------|----> time      short blocks: no steady stretch
//!       ramp 1       steady          ramp 2
//! ```
//!
//! Units: mm, s, mm/s, mm/s². Cost of everything here is constant.

/// What a block's profile is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Distance to go, mm, zero or more.
    pub length: f64,
    /// Speed at its start, mm/s.
    pub entry: f64,
    /// Speed wanted, mm/s, above zero. May lie below `entry` (an override was turned down).
    pub nominal: f64,
    /// Speed wanted at its end, mm/s, at most `nominal`.
    pub exit: f64,
    /// Change of speed allowed, mm/s², above zero.
    pub acceleration: f64,
}

/// A part of a profile: steady acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// How long, s; zero or more.
    pub duration: f64,
    /// Distance covered before it, mm.
    pub start: f64,
    /// Speed at its start, mm/s.
    pub speed: f64,
    /// Change of speed, mm/s²; negative if it brakes.
    pub slope: f64,
}

/// Speed over one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Distance, mm.
    pub length: f64,
    /// Speed at the start, mm/s.
    pub entry: f64,
    /// Speed of the steady stretch, mm/s.
    pub cruise: f64,
    /// Speed at the end, mm/s: as wanted, or as near to it as the length allows.
    pub exit: f64,
    /// Slope of the first ramp, mm/s²: negative if it brakes.
    slope: f64,
    acceleration: f64,
    /// Lengths of the first ramp and of the steady stretch, mm.
    lengths: [f64; 2],
    /// Durations of ramp, steady stretch, ramp, s.
    times: [f64; 3],
}

impl Profile {
    /// The quickest way along the block within its limits.
    pub fn new(ramp: Ramp) -> Profile {
        let Ramp {
            length,
            entry,
            nominal,
            exit,
            acceleration: a,
        } = ramp;
        let (length, exit) = (length.max(0.0), exit.min(nominal));
        let (entry_sq, exit_sq) = (entry * entry, exit * exit);
        // v² = v0² + 2 a d along a ramp. Two ramps that just meet have their peak at:
        let peak_sq = a * length + (entry_sq + exit_sq) / 2.0;
        let (cruise, exit) = if entry_sq >= exit_sq + 2.0 * a * length {
            // Braking all the way, and perhaps not enough.
            // Planned to just succeed, it must not fail by rounding: a root makes 1e-6 mm/s of 1e-12.
            let just = entry_sq <= (exit_sq + 2.0 * a * length) * (1.0 + 1e-12);
            let missed = (entry_sq - 2.0 * a * length).max(0.0).sqrt();
            (entry, if just { exit } else { missed })
        } else if entry > nominal {
            (nominal, exit)
        } else if exit_sq >= entry_sq + 2.0 * a * length {
            let top = (entry_sq + 2.0 * a * length).sqrt();
            (top, top)
        } else {
            (nominal.min(peak_sq.max(0.0).sqrt()), exit)
        };
        let slope = if entry > cruise { -a } else { a };
        let first = ((cruise * cruise - entry_sq) / (2.0 * slope)).clamp(0.0, length);
        let last = ((cruise * cruise - exit * exit) / (2.0 * a)).clamp(0.0, length - first);
        let steady = length - first - last;
        Profile {
            length,
            entry,
            cruise,
            exit,
            slope,
            acceleration: a,
            lengths: [first, steady],
            times: [
                (cruise - entry) / slope,
                if steady > 0.0 && cruise > 0.0 {
                    steady / cruise
                } else {
                    0.0
                },
                (cruise - exit) / a,
            ],
        }
    }

    /// Braking from `entry` as hard as allowed over at most `length`: a feed hold. [`Profile::length`] of the result is where it
    /// stands still, or `length` if it is still moving there.
    pub fn brake(length: f64, entry: f64, acceleration: f64) -> Profile {
        let stop = entry * entry / (2.0 * acceleration);
        Profile::new(Ramp {
            length: length.min(stop),
            entry,
            nominal: entry,
            exit: 0.0,
            acceleration,
        })
    }

    /// How long the block takes, s.
    pub fn duration(&self) -> f64 {
        self.times[0] + self.times[1] + self.times[2]
    }

    /// Ramp, steady stretch, ramp; any of them may be empty.
    pub fn phases(&self) -> [Phase; 3] {
        let [t1, t2, t3] = self.times;
        let [d1, d2] = self.lengths;
        let phase = |duration, start, speed, slope| Phase {
            duration,
            start,
            speed,
            slope,
        };
        [
            phase(t1, 0.0, self.entry, self.slope),
            phase(t2, d1, self.cruise, 0.0),
            phase(t3, d1 + d2, self.cruise, -self.acceleration),
        ]
    }

    /// Distance covered after `t` seconds, mm; 0 before the start and [`Profile::length`] behind the end.
    pub fn distance_at(&self, t: f64) -> f64 {
        let [t1, t2, t3] = self.times;
        let [d1, d2] = self.lengths;
        if t <= 0.0 {
            0.0
        } else if t < t1 {
            self.entry * t + self.slope * t * t / 2.0
        } else if t < t1 + t2 {
            d1 + self.cruise * (t - t1)
        } else if t < t1 + t2 + t3 {
            let s = t - t1 - t2;
            d1 + d2 + self.cruise * s - self.acceleration * s * s / 2.0
        } else {
            self.length
        }
        .clamp(0.0, self.length)
    }

    /// Speed after `t` seconds, mm/s.
    pub fn speed_at(&self, t: f64) -> f64 {
        let [t1, t2, t3] = self.times;
        if t <= 0.0 {
            self.entry
        } else if t < t1 {
            self.entry + self.slope * t
        } else if t < t1 + t2 {
            self.cruise
        } else if t < t1 + t2 + t3 {
            self.cruise - self.acceleration * (t - t1 - t2)
        } else {
            self.exit
        }
    }

    /// Seconds until `distance` mm are covered; 0 before the start and the whole duration behind the end.
    pub fn time_at(&self, distance: f64) -> f64 {
        let [t1, t2, _] = self.times;
        let [d1, d2] = self.lengths;
        // A ramp: t = (v - v0) / slope with v² = v0² + 2 slope d.
        let along = |v0: f64, slope: f64, d: f64| {
            ((v0 * v0 + 2.0 * slope * d).max(0.0).sqrt() - v0) / slope
        };
        if distance <= 0.0 {
            0.0
        } else if distance < d1 {
            along(self.entry, self.slope, distance)
        } else if distance < d1 + d2 {
            t1 + (distance - d1) / self.cruise
        } else if distance < self.length {
            t1 + t2 + along(self.cruise, -self.acceleration, distance - d1 - d2)
        } else {
            self.duration()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ramp(length: f64, entry: f64, nominal: f64, exit: f64, acceleration: f64) -> Ramp {
        Ramp {
            length,
            entry,
            nominal,
            exit,
            acceleration,
        }
    }

    /// A block entered at the highest speed from which it can be braked ends at rest, not at the root of a rounding error.
    #[test]
    fn braking_that_just_succeeds_ends_at_rest() {
        for k in 1..2000 {
            let (length, acceleration) = (0.000_7 * f64::from(k), 639.2 + 0.37 * f64::from(k));
            let p = Profile::new(Ramp {
                length,
                entry: (2.0 * acceleration * length).sqrt(),
                nominal: 1e3,
                exit: 0.0,
                acceleration,
            });
            assert_eq!(p.exit, 0.0, "{length}");
        }
    }

    #[test]
    fn the_three_shapes_by_hand() {
        // 100 mm at 10 mm/s, 10 mm/s²: 1 s and 5 mm for each ramp, 90 mm at full speed.
        let p = Profile::new(ramp(100.0, 0.0, 10.0, 0.0, 10.0));
        assert!((p.duration() - 11.0).abs() < 1e-12);
        // Too short for full speed: 2.5 mm up and 2.5 mm down, v² = 50.
        let p = Profile::new(ramp(5.0, 0.0, 10.0, 0.0, 10.0));
        assert!((p.duration() - 2.0 * 50f64.sqrt() / 10.0).abs() < 1e-12);
        // Too fast at the start for the feed: brakes first.
        let p = Profile::new(ramp(100.0, 20.0, 10.0, 10.0, 10.0));
        assert!((p.duration() - (1.0 + 85.0 / 10.0)).abs() < 1e-12);
    }

    #[test]
    fn holds_stop_in_v_squared_over_2a() {
        // The recorded firmware: 600 mm/min, 500 mm/s² stops in 0.1 mm.
        let p = Profile::brake(20.0, 10.0, 500.0);
        assert!((p.length - 0.1).abs() < 1e-12 && p.exit == 0.0);
        let p = Profile::brake(0.05, 10.0, 500.0);
        assert!(p.length == 0.05 && (p.exit - 50f64.sqrt()).abs() < 1e-12);
        assert_eq!(Profile::brake(1.0, 0.0, 500.0).duration(), 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        /// Time and distance are each other's inverse, neither runs backwards, the speed is the slope of the distance and never
        /// changes faster than allowed.
        #[test]
        fn a_profile_is_a_motion(
            length in 0.001..200.0f64, entry in 0.0..80.0f64, nominal in 0.02..80.0f64, exit in 0.0..80.0f64,
            a in 5.0..2000.0f64, k in 0.0..1.0f64,
        ) {
            let p = Profile::new(ramp(length, entry, nominal, exit, a));
            let all = p.duration();
            prop_assert!(all.is_finite() && all > 0.0);
            prop_assert!((p.distance_at(all) - length).abs() < 1e-9 * length.max(1.0));
            let t = k * all;
            prop_assert!((p.time_at(p.distance_at(t)) - t).abs() < 1e-6 * all.max(1.0));
            let dt = all * 1e-6;
            let (d, e) = (p.distance_at(t), p.distance_at(t + dt));
            prop_assert!(e >= d);
            let v = (e - d) / dt;
            prop_assert!((v - p.speed_at(t)).abs() <= a * dt + 1e-4 * v.max(1.0), "{} {}", v, p.speed_at(t));
            prop_assert!((p.speed_at(t + dt) - p.speed_at(t)).abs() <= a * dt * 1.001 + 1e-9);
            prop_assert!(p.speed_at(t) <= nominal.max(entry) + 1e-9);
            let mut begin = 0.0;
            for phase in p.phases() {
                let u = t - begin;
                if u >= 0.0 && u <= phase.duration {
                    let d = phase.start + u * (phase.speed + 0.5 * phase.slope * u);
                    prop_assert!((p.distance_at(t) - d).abs() < 1e-9 * length.max(1.0));
                }
                begin += phase.duration;
            }
            prop_assert!((begin - all).abs() < 1e-12 * all);
        }
    }
}
