//! What the axes really did: the way driven, in straight pieces, where the part lies.
//!
//! Crosses the border: machine positions with their moments in, pieces of way out, mm, in the frame of the part: machine position minus
//! the work offset in force when the part was zeroed. A piece ends where the direction, the sort of motion or the spindle's state
//! changes, so a job of a million blocks is at most about a million pieces, however often it was looked at. Never knows parts or stock;
//! whoever has them judges.
//!
//! A controller that is switched off forgets where it stands, but the tool and the part stay where they are: the way goes on from
//! there, and what the controller drives then, thinking itself at zero, shows as the crash it would be. Homing finds the frame again.

use super::{Controller, Mode};
use crate::geom::{Point, Vector};

/// A straight piece of the way of the tool's tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Start, part frame, mm.
    pub from: Point,
    /// End, part frame, mm.
    pub to: Point,
    /// It was a rapid move.
    pub rapid: bool,
    /// The spindle turned.
    pub turning: bool,
    /// Moment of its start, s since the start.
    pub at: f64,
}

/// The way of a program, or of what there was of one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    /// In the order driven.
    pub pieces: Vec<Driven>,
    /// There was more than fits: what came last is not in it.
    pub cut_short: bool,
}

/// Pieces kept at most (about 800 MB): a longer way is cut short, and says so.
const MOST_PIECES: usize = 10_000_000;
/// A place as near to the straight line as this goes on with it, mm: far below a step.
const STRAIGHT: f64 = 1e-6;

/// Watches a controller and keeps the way.
#[derive(Clone, Debug)]
pub struct Recorder {
    drive: Drive,
    /// Machine position at the last look.
    last: Point,
    /// What the controller forgot when it was last switched off: add it to its position to get the true one.
    shift: Vector,
    /// Work offset at the last look.
    offset: Vector,
    /// Where the part's zero is on the table: the true machine position.
    zero: Vector,
    homing: bool,
    at: f64,
}

impl Recorder {
    /// Begins where the controller stands, with the part's zero at its work zero.
    pub fn new(controller: &Controller) -> Recorder {
        let offset = Vector::from(controller.offset);
        Recorder {
            drive: Drive::default(),
            last: controller.position(),
            shift: Vector::zeros(),
            offset,
            zero: offset,
            homing: false,
            at: 0.0,
        }
    }

    /// Looks at the axes, `now` seconds after the start. Between two looks they must have gone straight.
    pub fn look(&mut self, controller: &Controller, now: f64) {
        let place = controller.position();
        let began = std::mem::replace(&mut self.at, now);
        let homing = controller.mode == Mode::Home;
        if self.homing && !homing {
            // It has found its frame again; how it got there is not judged.
            self.shift = Vector::zeros();
        } else if place != self.last && !homing && !self.homing {
            self.push(Driven {
                from: self.last + self.shift - self.zero,
                to: place + self.shift - self.zero,
                rapid: controller.motion.ran_rapid(),
                turning: controller.spindle != 0
                    && controller.rpm > 0.0
                    && !controller.spindle_stopped,
                at: began,
            });
        }
        (self.last, self.homing) = (place, homing);
        // The operator zeroed: the part is where he says.
        let offset = Vector::from(controller.offset);
        if offset != self.offset {
            self.offset = offset;
            self.zero = offset + self.shift;
        }
    }

    /// The controller was restarted: `before` is where it thought it stood.
    pub fn restarted(&mut self, controller: &Controller, before: Point) {
        self.last = controller.position();
        self.shift += before - self.last;
        self.homing = false;
        // A restart drops G92 and tool lengths, but moves no part.
        self.offset = Vector::from(controller.offset);
    }

    /// The way so far; the next one begins here.
    pub fn take(&mut self) -> Drive {
        std::mem::take(&mut self.drive)
    }

    /// Nothing was driven since the way was last taken.
    pub fn is_empty(&self) -> bool {
        self.drive.pieces.is_empty()
    }

    fn push(&mut self, new: Driven) {
        if let Some(last) = self.drive.pieces.last_mut()
            && (last.rapid, last.turning) == (new.rapid, new.turning)
            && (last.to - new.from).norm() <= STRAIGHT
            && goes_on(&(last.to - last.from), &(new.to - last.from))
        {
            last.to = new.to;
        } else if self.drive.pieces.len() < MOST_PIECES {
            self.drive.pieces.push(new);
        } else {
            self.drive.cut_short = true;
        }
    }
}

impl Controller {
    /// Puts the zero of the work system G54 at a place of the machine, mm, as an operator does who touches the part off.
    pub fn set_work_zero(&mut self, machine: &Point) {
        // Nothing moves: the machine stands where it stood, and its work position is another.
        let here = self.parser.machine_position();
        if let Some(g54) = self.parser.g5x.first_mut() {
            *g54 = machine.coords;
        }
        self.parser.set_machine_position(&here);
        self.refresh_offset();
    }
}

/// True when the way to `whole` passes `part` and goes on straight.
fn goes_on(part: &Vector, whole: &Vector) -> bool {
    let length = whole.norm();
    length > 0.0
        && part.dot(whole) > 0.0
        && part.norm() <= length
        && part.cross(whole).norm() <= STRAIGHT * length
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{Memory, Rig, RigOptions};
    use super::*;

    fn rig() -> Rig {
        let mut memory = Memory::default();
        for axis in 0..3 {
            memory.set(110 + axis, 3000.0);
            memory.set(120 + axis, 500.0);
        }
        Rig::new(
            Controller::new(memory),
            RigOptions {
                record: true,
                ..RigOptions::default()
            },
        )
    }

    fn ends(drive: &Drive) -> Vec<(String, bool, bool)> {
        let show = |p: &Point| format!("{:.3} {:.3} {:.3}", p.x + 0.0, p.y + 0.0, p.z + 0.0);
        drive
            .pieces
            .iter()
            .map(|d| (show(&d.to), d.rapid, d.turning))
            .collect()
    }

    #[test]
    fn one_piece_a_block_however_often_it_is_looked_at() {
        let mut r = rig();
        r.feed(b"G0X10\nM3S500\nG1Y5F600\nG1Y10\n");
        for _ in 0..8000 {
            r.advance(0.001);
        }
        let drive = r.take_drive();
        assert_eq!(
            ends(&drive),
            [
                ("10.000 0.000 0.000".to_string(), true, false),
                ("10.000 10.000 0.000".to_string(), false, true)
            ]
        );
        assert!(drive.pieces[1].at > 0.0);
        assert!(r.take_drive().pieces.is_empty());
    }

    #[test]
    fn places_are_those_of_the_part() {
        let mut r = rig();
        r.feed(b"G10L2P1X-50Y-40Z-10\n");
        r.advance(0.1);
        r.feed(b"G0X1Y2\n");
        r.advance(20.0);
        let drive = r.take_drive();
        assert_eq!(drive.pieces[0].from, Point::new(50.0, 40.0, 10.0));
        assert_eq!(ends(&drive)[0].0, "1.000 2.000 10.000");
    }

    #[test]
    fn a_controller_that_forgot_its_place_drives_on_from_where_the_tool_is() {
        let mut r = rig();
        r.feed(b"G0X20\n");
        r.advance(5.0);
        r.power_cycle();
        // It thinks it stands at zero: this goes to 30.
        r.feed(b"G0X10\n");
        r.advance(5.0);
        assert_eq!(
            ends(&r.take_drive()).last().unwrap().0,
            "30.000 0.000 0.000"
        );
    }
}
