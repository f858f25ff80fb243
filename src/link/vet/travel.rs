//! Does the program stay where the machine can go?

use super::options::{Limits, ToldBy};
use super::refusal::Refusal;
use crate::gcode::{Arc, Event, Motion, State};
use crate::geom::Point;

/// The firmware tests targets exactly; this forgives only the rounding of our own sums, mm.
const ROUNDING: f64 = 1e-6;

/// Follows the motions and holds them against the limits.
pub(super) struct Reach {
    limits: Limits,
    /// Lowest and highest work place plus offset so far.
    extent: [Option<(f64, f64)>; 3],
}

impl Reach {
    pub fn new(limits: Limits) -> Reach {
        Reach {
            limits,
            extent: [None; 3],
        }
    }

    /// Checks one event; `state` is what the controller remembers behind its line.
    pub fn event(&mut self, event: &Event, state: &State) -> Result<(), Refusal> {
        let motion = match event {
            Event::Motion(m) => m,
            Event::Probe { motion, .. } => motion,
            _ => return Ok(()),
        };
        match self.limits {
            Limits::None => Ok(()),
            Limits::Box { low, high, soft } => {
                for place in places(motion) {
                    let machine = state.machine_of_work(&place);
                    for (i, axis) in ('X'..='Z').enumerate() {
                        let at = machine[i];
                        if at < low[i] - ROUNDING || at > high[i] + ROUNDING || !at.is_finite() {
                            let (low, high) = (low[i], high[i]);
                            return Err(Refusal::Outside {
                                axis,
                                at,
                                low,
                                high,
                                soft,
                            });
                        }
                    }
                }
                Ok(())
            }
            Limits::Size { size, told_by } => {
                // Machine coordinates say nothing while the machine's own place is not known.
                if motion.machine_coordinates {
                    return Ok(());
                }
                for place in places(motion) {
                    let machine = state.machine_of_work(&place);
                    for (i, axis) in ('X'..='Z').enumerate() {
                        let at = machine[i];
                        // An axis counts from its first move on: where it stood before, nobody knows.
                        if self.extent[i].is_none() && motion.to[i] == motion.from[i] {
                            continue;
                        }
                        let (low, high) = self.extent[i].unwrap_or((at, at));
                        let (low, high) = (low.min(at), high.max(at));
                        self.extent[i] = Some((low, high));
                        let reach = high - low;
                        if reach > size[i] + ROUNDING || !reach.is_finite() {
                            return Err(Refusal::TooLarge {
                                axis,
                                reach,
                                travel: size[i],
                                machine_file: told_by == ToldBy::MachineFile,
                            });
                        }
                    }
                }
                Ok(())
            }
        }
    }
}

/// The end of a motion, and where its arc turns round along an axis.
fn places(motion: &Motion) -> impl Iterator<Item = Point> {
    let turns = motion.arc.map(|arc| turning_points(motion, &arc));
    std::iter::once(motion.to).chain(turns.into_iter().flatten())
}

fn turning_points(motion: &Motion, arc: &Arc) -> Vec<Point> {
    use std::f64::consts::{FRAC_PI_2, TAU};
    let [a, b, _] = arc.plane.axes();
    let (u, v) = (
        motion.from[a] - arc.center[a],
        motion.from[b] - arc.center[b],
    );
    let (radius, start) = (u.hypot(v), v.atan2(u));
    let mut out = Vec::new();
    if !(start.is_finite() && arc.sweep.is_finite()) {
        return out;
    }
    for quarter in 0..4 {
        let angle = f64::from(quarter) * FRAC_PI_2;
        // How far to turn, in the arc's sense, until this direction is met.
        let turn = match arc.clockwise {
            true => (start - angle).rem_euclid(TAU),
            false => (angle - start).rem_euclid(TAU),
        };
        if turn < arc.sweep.abs() {
            let mut place = motion.to;
            place[a] = arc.center[a] + radius * angle.cos();
            place[b] = arc.center[b] + radius * angle.sin();
            out.push(place);
        }
    }
    out
}
