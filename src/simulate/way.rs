//! The way of the ball's centre: what a program's motions are to the stock, and how long they are.

use super::material::Move;
use super::report::ProgramFigures;
use super::start::Followed;
use crate::gcode::MotionKind;
use crate::geom::{Point, Vector};
use crate::kinematics::chords;
use crate::sweep::Segment;
use crate::units::Mm;

/// Arcs become chords within this, mm.
const FLATTEN: f64 = 5e-4;

/// Takes motions one by one and tells the moves whose place is known: until all three axes have been told, only the ends of motions are.
/// The same holds after motions in machine coordinates and after probing.
pub struct Way {
    up: Vector,
    /// A feed motion came last, and no rapid has risen since.
    in_work: bool,
    /// Moves told so far.
    pub moves: usize,
    /// Lengths and retracts so far.
    pub figures: ProgramFigures,
}

impl Way {
    /// For a ball of this radius, mm.
    pub fn new(radius: f64) -> Way {
        Way {
            up: Vector::new(0.0, 0.0, radius),
            in_work: false,
            moves: 0,
            figures: ProgramFigures::default(),
        }
    }

    /// The next motion.
    pub fn motion(&mut self, followed: &Followed, tell: &mut dyn FnMut(Move)) {
        let m = followed.motion;
        if m.machine_coordinates {
            self.in_work = false;
            return;
        }
        let rapid = m.kind == MotionKind::Rapid;
        let (up, moves) = (self.up, &mut self.moves);
        let mut push = |from: Point, to: Point| {
            *moves += 1;
            tell(Move {
                segment: Segment {
                    from: from + up,
                    to: to + up,
                },
                rapid,
                line: m.line,
            });
            (to - from).norm()
        };
        let mut length = 0.0;
        if followed.from_known == [true; 3] {
            match &m.arc {
                Some(arc) => {
                    let mut from = m.from;
                    for to in chords(&m.from, &m.to, arc, Mm(FLATTEN)) {
                        length += push(from, to);
                        from = to;
                    }
                }
                None => length += push(m.from, m.to),
            }
        } else if followed.to_known == [true; 3] {
            push(m.to, m.to);
        }
        let f = &mut self.figures;
        if rapid {
            f.rapid_mm += length;
            if self.in_work && m.to.z > m.from.z {
                f.retracts += 1;
                self.in_work = false;
            }
        } else {
            f.cut_mm += length;
            self.in_work = true;
        }
    }
}
