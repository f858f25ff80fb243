//! Which places a program really tells: where the tool stands before the first move is not in the text.

use crate::gcode::{
    Dialect, Event, InterpretError, Motion, MotionKind, Program, State, interpret_from,
};

/// Stands for a coordinate that the text has not told yet, mm: no machine reaches it, and moves relative to it stay near it.
pub const UNKNOWN: f64 = -876_543.25;

/// True for a coordinate that the text has told.
pub fn told(v: f64) -> bool {
    v > UNKNOWN / 2.0
}

/// A program read twice.
pub struct Read {
    /// From machine zero, as the controller takes it when switched on: for the clock.
    pub at_zero: Program,
    /// From a start at [`UNKNOWN`] on every axis that is told before the first cut, at zero on the others: for shapes.
    pub events: Vec<Event>,
    /// X, Y, Z was never told before the first cut: zero is assumed.
    pub assumed: [bool; 3],
}

/// Reads a text both ways.
pub fn read(text: &str, dialect: Dialect) -> Result<Read, Vec<InterpretError>> {
    let at_zero = interpret_from(State::new(dialect), text)?;
    let mut assumed = [false; 3];
    // Twice at most: to see which axes are told, and again with the others at zero.
    for _ in 0..2 {
        let mut state = State::new(dialect);
        for (a, assumed) in assumed.iter().enumerate() {
            if !assumed {
                state.position[a] = UNKNOWN;
            }
        }
        let Ok(program) = interpret_from(state, text) else {
            break;
        };
        let first = program.events.iter().find_map(|e| match e {
            Event::Motion(m) if m.kind == MotionKind::Feed => Some(*m),
            _ => None,
        });
        let missing = first.map_or([false; 3], |m| [0, 1, 2].map(|a| !told(m.from[a])));
        if missing == [false; 3] {
            return Ok(Read {
                at_zero,
                events: program.events,
                assumed,
            });
        }
        for (assumed, missing) in assumed.iter_mut().zip(missing) {
            *assumed |= missing;
        }
    }
    // An arc from an untold place and the like: take the controller's own zero.
    Ok(Read {
        events: at_zero.events.clone(),
        at_zero,
        assumed: [true; 3],
    })
}

/// Follows which axes stand at a told place in work coordinates.
#[derive(Default)]
pub struct Places {
    /// Moved in machine coordinates or by probing since it was last told.
    lost: [bool; 3],
}

impl Places {
    /// The motion of an event that moves by plain motion, and for each axis whether its start and its end are known.
    pub fn follow<'e>(&mut self, event: &'e Event) -> Option<(&'e Motion, [bool; 3], [bool; 3])> {
        let m = match event {
            Event::Motion(m) => m,
            Event::Probe { motion, .. } => {
                for a in 0..3 {
                    self.lost[a] |= motion.to[a] != motion.from[a];
                }
                return None;
            }
            _ => return None,
        };
        let from = [0, 1, 2].map(|a| told(m.from[a]) && !self.lost[a]);
        for a in 0..3 {
            if m.to[a] != m.from[a] {
                self.lost[a] = m.machine_coordinates;
            }
        }
        let to = [0, 1, 2].map(|a| told(m.to[a]) && !self.lost[a]);
        Some((m, from, to))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn tells_told_from_untold() {
        // All told, zero among them.
        let r = read("G0 Z5\nG0 X0 Y0\nG1 Z-1 F100\n", Dialect::Grbl).unwrap();
        assert_eq!(r.assumed, [false; 3]);
        let mut p = Places::default();
        let known: Vec<_> = r
            .events
            .iter()
            .filter_map(|e| p.follow(e))
            .map(|(_, f, t)| (f, t))
            .collect();
        assert_eq!(known[0], ([false; 3], [false, false, true]));
        assert_eq!(known[1], ([false, false, true], [true; 3]));
        assert_eq!(known[2], ([true; 3], [true; 3]));
        // Y is never told.
        let r = read("G0 Z5\nG0 X1\nG1 Z-1 F100\n", Dialect::Grbl).unwrap();
        assert_eq!(r.assumed, [false, true, false]);
        // After a move in machine coordinates the axis is lost until it is told again.
        let r = read(
            "G0 Z5\nG0 X1 Y1\nG1 Z-1 F100\nG53 G0 Z-2\nG0 X9\nG0 Z7\n",
            Dialect::Grbl,
        )
        .unwrap();
        let mut p = Places::default();
        let known: Vec<_> = r
            .events
            .iter()
            .filter_map(|e| p.follow(e))
            .map(|(_, f, t)| (f[2], t[2]))
            .collect();
        assert_eq!(known[3..], [(true, false), (false, false), (false, true)]);
    }
}
