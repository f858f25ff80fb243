//! Which places a program really tells: where the tool stands before the first move is not in the text.

use super::program::{Open, READING};
use crate::gcode::{Dialect, Event, Interpreter, Motion, MotionKind, State};

/// Stands for a coordinate that the text has not told yet, mm: no machine reaches it, and moves relative to it stay near it.
pub const UNKNOWN: f64 = -876_543.25;

/// True for a coordinate that the text has told.
pub fn told(v: f64) -> bool {
    v > UNKNOWN / 2.0
}

/// What a program is read from for its shape: [`UNKNOWN`] on every axis that is told before the first cut, zero on the others.
pub struct Start {
    /// The machine before the first line.
    pub state: State,
    /// X, Y, Z is not told before the first cut: zero is assumed.
    pub assumed: [bool; 3],
}

impl Start {
    /// The controller's own zero, where no other start reads: an arc from an untold place and the like.
    pub fn zero(dialect: Dialect) -> Start {
        Start {
            state: State::new(dialect),
            assumed: [true; 3],
        }
    }

    fn unknown(dialect: Dialect, assumed: [bool; 3]) -> Start {
        let mut state = State::new(dialect);
        for (a, assumed) in assumed.iter().enumerate() {
            if !assumed {
                state.position[a] = UNKNOWN;
            }
        }
        Start { state, assumed }
    }
}

/// Reads a program up to its first cut.
pub fn start(open: &Open, dialect: Dialect) -> Start {
    let mut assumed = [false; 3];
    // Twice at most: to see which axes are told, and again with the others at zero.
    for _ in 0..2 {
        let start = Start::unknown(dialect, assumed);
        let Ok(missing) = untold(open, &start.state) else {
            break;
        };
        if missing == [false; 3] {
            return start;
        }
        for (assumed, missing) in assumed.iter_mut().zip(missing) {
            *assumed |= missing;
        }
    }
    Start::zero(dialect)
}

/// The axes whose place is not told where the first cut begins; an error if it does not read so far.
fn untold(open: &Open, state: &State) -> Result<[bool; 3], Unread> {
    let from = open().map_err(|_| Unread)?;
    let events = Interpreter::from_state(from, state.clone(), READING).map_err(|_| Unread)?;
    for event in events {
        match event.map_err(|_| Unread)? {
            Event::Motion(m) if m.kind == MotionKind::Feed => {
                return Ok([0, 1, 2].map(|a| !told(m.from[a])));
            }
            _ => {}
        }
    }
    Ok([false; 3])
}

/// Whoever reads the whole program says why.
struct Unread;

/// A plain motion, and for each axis whether its start and its end are known.
pub struct Followed<'e> {
    pub motion: &'e Motion,
    pub from_known: [bool; 3],
    pub to_known: [bool; 3],
}

/// Follows which axes stand at a told place in work coordinates.
#[derive(Default)]
pub struct Places {
    /// Moved in machine coordinates or by probing since it was last told.
    lost: [bool; 3],
}

impl Places {
    /// The motion of an event that moves by plain motion.
    pub fn follow<'e>(&mut self, event: &'e Event) -> Option<Followed<'e>> {
        let motion = match event {
            Event::Motion(motion) => motion,
            Event::Probe { motion, .. } => {
                for a in 0..3 {
                    self.lost[a] |= motion.to[a] != motion.from[a];
                }
                return None;
            }
            _ => return None,
        };
        let from_known = [0, 1, 2].map(|a| told(motion.from[a]) && !self.lost[a]);
        for a in 0..3 {
            if motion.to[a] != motion.from[a] {
                self.lost[a] = motion.machine_coordinates;
            }
        }
        let to_known = [0, 1, 2].map(|a| told(motion.to[a]) && !self.lost[a]);
        Some(Followed {
            motion,
            from_known,
            to_known,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::program::in_memory;
    use super::*;

    #[test]
    fn tells_told_from_untold() {
        // All told, zero among them.
        let r = read("G0 Z5\nG0 X0 Y0\nG1 Z-1 F100\n");
        assert_eq!(r.0, [false; 3]);
        assert_eq!(r.1[0], ([false; 3], [false, false, true]));
        assert_eq!(r.1[1], ([false, false, true], [true; 3]));
        assert_eq!(r.1[2], ([true; 3], [true; 3]));
        // Y is never told.
        assert_eq!(read("G0 Z5\nG0 X1\nG1 Z-1 F100\n").0, [false, true, false]);
        // An arc from an untold place reads only from zero.
        assert_eq!(read("G2 X5 R2.5 F100\n").0, [true; 3]);
        // After a move in machine coordinates the axis is lost until it is told again.
        let (_, known) = read("G0 Z5\nG0 X1 Y1\nG1 Z-1 F100\nG53 G0 Z-2\nG0 X9\nG0 Z7\n");
        let z: Vec<_> = known[3..].iter().map(|(f, t)| (f[2], t[2])).collect();
        assert_eq!(z, [(true, false), (false, false), (false, true)]);
    }

    /// The axes taken to be at zero, and what is known before and behind each motion.
    #[allow(clippy::type_complexity, reason = "a test's table")]
    fn read(text: &str) -> ([bool; 3], Vec<([bool; 3], [bool; 3])>) {
        let open = in_memory(text);
        let start = start(&open, Dialect::Grbl);
        let events = Interpreter::from_state(open().unwrap(), start.state, READING).unwrap();
        let mut p = Places::default();
        let known =
            events.filter_map(|e| p.follow(&e.unwrap()).map(|f| (f.from_known, f.to_known)));
        let known = known.collect();
        (start.assumed, known)
    }
}
