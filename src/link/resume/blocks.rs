//! How many planner blocks a line fills for certain.

use crate::gcode::Motion;
use crate::kinematics::chords;
use crate::link::journal::Begin;
use crate::units::Mm;

/// Motions of at least so many steps surely make a block, whatever rounding does.
const SURE_STEPS: f64 = 1.5;
/// The same where the steps per mm are not known, mm: no axis is as coarse.
const SURE_MM: f64 = 0.2;

/// What must be known of a machine to count blocks.
#[derive(Clone, Copy, Debug)]
pub struct Counter {
    /// Way along one axis that surely makes a block, mm.
    sure: [f64; 3],
    /// `$12`, mm.
    arc_tolerance: Option<f64>,
}

impl Counter {
    /// By the settings in a journal.
    pub fn new(begin: &Begin) -> Counter {
        let setting = |n: u16| begin.settings.iter().find(|s| s.0 == n).map(|s| s.1);
        Counter {
            sure: [100, 101, 102].map(|n| match setting(n) {
                Some(steps) if steps > 0.0 => SURE_STEPS / steps,
                _ => SURE_MM,
            }),
            arc_tolerance: setting(12).filter(|t| *t > 0.0),
        }
    }

    /// Blocks that this motion surely fills: never more than it does.
    pub fn blocks(&self, motion: &Motion) -> usize {
        let d = motion.to - motion.from;
        let moved = usize::from((0..3).any(|a| d[a].abs() >= self.sure[a]));
        let (Some(arc), Some(tolerance)) = (&motion.arc, self.arc_tolerance) else {
            return moved;
        };
        let chords = chords(&motion.from, &motion.to, arc, Mm(tolerance)).chord_count();
        let [a, b, _] = arc.plane.axes();
        let radius = (motion.from[a] - arc.center[a]).hypot(motion.from[b] - arc.center[b]);
        let length = radius * arc.sweep.abs() / f64::from(chords.max(1));
        // A chord goes along one of the two axes by 0.7 of its length at least.
        if length * 0.7 < self.sure[a].max(self.sure[b]) {
            return moved;
        }
        // The firmware counts in single precision and may find one less.
        (chords as usize).saturating_sub(1).max(moved)
    }
}
