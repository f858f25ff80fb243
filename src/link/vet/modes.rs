//! Modes that a program relies on and never sets: what they are then is up to whoever used the machine before.

use super::refusal::Caution;
use super::words::is;
use crate::gcode::{Event, MotionKind};

/// (the choice, codes that make it, what is set when nobody does)
const GROUPS: [(&str, &[f64], &str); 5] = [
    ("G20 or G21 (units)", &[20.0, 21.0], "G21, mm"),
    ("G90 or G91 (distances)", &[90.0, 91.0], "G90, absolute"),
    (
        "G93 or G94 (feed mode)",
        &[93.0, 94.0, 95.0],
        "G94, per minute",
    ),
    (
        "G54 to G59 (work offset)",
        &[54.0, 55.0, 56.0, 57.0, 58.0, 59.0, 59.1, 59.2, 59.3],
        "G54",
    ),
    (
        "G17, G18 or G19 (plane of arcs)",
        &[17.0, 18.0, 19.0],
        "G17, XY",
    ),
];
const UNITS: usize = 0;
const DISTANCE: usize = 1;
const FEED: usize = 2;
const OFFSET: usize = 3;
const PLANE: usize = 4;

/// Which groups were set, or complained about, so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ModesSet([bool; 5]);

impl ModesSet {
    /// Takes in a line's words.
    pub fn read(&mut self, words: impl Iterator<Item = (char, f64)>) {
        for word in words.filter(|w| w.0 == 'G') {
            for (set, (_, codes, _)) in self.0.iter_mut().zip(GROUPS) {
                *set |= codes.iter().any(|c| is(word, 'G', *c));
            }
        }
    }

    /// The groups that these events rely on and nobody has set; each is told once.
    pub fn forgotten(&mut self, events: &[Event]) -> Vec<Caution> {
        let mut needed = [false; 5];
        for event in events {
            let motion = match event {
                Event::Motion(m) => m,
                Event::Probe { motion, .. } => motion,
                _ => continue,
            };
            (needed[UNITS], needed[DISTANCE]) = (true, true);
            needed[OFFSET] |= !motion.machine_coordinates;
            needed[FEED] |= motion.kind == MotionKind::Feed;
            needed[PLANE] |= motion.arc.is_some();
        }
        let mut out = Vec::new();
        for ((set, needed), (words, _, default)) in self.0.iter_mut().zip(needed).zip(GROUPS) {
            if needed && !*set {
                *set = true;
                out.push(Caution::ModeNotSet { words, default });
            }
        }
        out
    }
}
