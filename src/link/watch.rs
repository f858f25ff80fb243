//! Path watch: is the machine where the lines it was sent lead?
//!
//! Noise on a cable can make one legal line of another (`X1.5` of `X7.5`), which is answered by `ok` like any other. No acknowledgement
//! betrays it, but the place does: every status report must lie on the way between the oldest line that may still be under way and the
//! newest one sent.
//!
//! ```text
//!   answered lines .............. newest sent
//!        [ planner blocks, slices |  receive buffer ]      the way that is kept: some tens of pieces
//!              x report: within the tolerance of it, or else something was damaged
//! ```
//! Replies come in order, so a report is never older than the answers heard before it, and what they allow to be over is over.
//! What it cannot see: a wrong line that is over between two reports, and one that differs by less than the tolerance.
//!
//! Crosses the border: places in machine coordinates, mm, as the interpreter makes them of each line (arcs cut into chords, no finer than
//! the controller cuts them); lines of the program, from 1. No clock, no I/O; it never sends anything.

use crate::geom::{Point, nearest_on_segment};
use std::collections::VecDeque;

/// How it watches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchOptions {
    /// How far beside the way a report may lie, mm: rounding to steps and of reports, and arcs cut into chords.
    pub tolerance: f64,
    /// Blocks that a controller holds of answered lines: look-ahead and prepared slices.
    pub held: usize,
    /// Moves shorter than this may vanish in the controller, mm (a step and a half): they are joined, and make a block together.
    pub block: f64,
}

impl Default for WatchOptions {
    /// GRBL 1.1 with 30 steps/mm or more: 15 usable blocks, 5 slices and one that runs.
    fn default() -> Self {
        WatchOptions {
            tolerance: 0.05,
            held: 15 + 6,
            block: 0.05,
        }
    }
}

impl WatchOptions {
    /// For a machine with so many steps per mm, and a controller with so many blocks (generous guesses where it does not tell).
    pub fn of(steps_per_mm: [Option<f64>; 3], blocks: Option<usize>) -> WatchOptions {
        let step = |s: &Option<f64>| s.filter(|s| *s > 0.0).map_or(COARSE, f64::recip);
        let steps: Vec<f64> = steps_per_mm.iter().map(step).collect();
        let half = 0.5 * steps.iter().map(|s| s * s).sum::<f64>().sqrt();
        let plain = WatchOptions::default();
        WatchOptions {
            tolerance: plain.tolerance + half,
            // grblHAL and FluidNC prepare more slices than GRBL.
            held: blocks.unwrap_or(128).min(4096) + 12,
            block: steps.iter().fold(plain.block, |b, s| b.max(1.5 * s)),
        }
    }
}

/// A step of a machine that does not tell, mm.
const COARSE: f64 = 0.05;

/// A straight piece of the way, a block of the controller or what it may make of one.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: Point,
    to: Point,
    /// First and last line that it belongs to.
    lines: (usize, usize),
    /// Moves shorter than a block were joined in it, and may have been so far beside it.
    slack: f64,
}

/// A report off the way: the controller does something else than it was sent.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the machine is at X{:.3} Y{:.3} Z{:.3} (machine coordinates), {distance:.3} mm beside the way of lines {} to {}, so it is not doing \
     what it was sent: bytes were damaged on the cable, an answer was lost or doubled, or somebody else moves it. Look at the part and at \
     where the tool stands, check cable and shielding, then go on from a line before these",
    .place[0], .place[1], .place[2], .lines.0, .lines.1
)]
pub struct OffPath {
    /// What was reported, mm.
    pub place: [f64; 3],
    /// How far from the way, mm.
    pub distance: f64,
    /// First and last line of the program that the machine can be in.
    pub lines: (usize, usize),
}

/// The way under watch. Constant memory: what the controller cannot be in any more is forgotten, and moves too short to be blocks
/// are joined.
#[derive(Clone, Debug)]
pub struct Watch {
    options: WatchOptions,
    pieces: VecDeque<Piece>,
    /// The last piece is shorter than a block: what follows is joined to it.
    open: bool,
    /// Where the pieces begin.
    start: Point,
    /// Where the newest line sent leads.
    end: Point,
    line: usize,
}

impl Watch {
    /// A machine at rest at `start`.
    pub fn new(start: Point, options: WatchOptions) -> Watch {
        Watch {
            options,
            pieces: VecDeque::new(),
            open: false,
            start,
            end: start,
            line: 0,
        }
    }

    /// A line goes out: the places its axes go to one after the other, in straight lines; none for a line that moves nothing.
    pub fn sent(&mut self, line: usize, places: impl IntoIterator<Item = Point>) {
        self.line = line;
        for to in places {
            let open = self.pieces.back_mut().filter(|_| self.open);
            let length = match open {
                Some(piece) => {
                    piece.slack = piece.slack.max((piece.to - piece.from).norm());
                    (piece.to, piece.lines.1) = (to, line);
                    (to - piece.from).norm()
                }
                None => {
                    self.pieces.push_back(Piece {
                        from: self.end,
                        to,
                        lines: (line, line),
                        slack: 0.0,
                    });
                    (to - self.end).norm()
                }
            };
            self.open = length < self.options.block;
            self.end = to;
        }
    }

    /// Lines up to this one were answered: those that no block of the controller can hold any more are over.
    pub fn answered(&mut self, line: usize) {
        let behind = self.pieces.iter().take_while(|p| p.lines.1 <= line).count();
        let over = behind.saturating_sub(self.options.held + 1);
        for piece in self.pieces.drain(..over) {
            self.start = piece.to;
        }
        self.open &= !self.pieces.is_empty();
    }

    /// The machine stands at `place`, all lines are over: behind a tool change, a jog, a homing.
    pub fn stands_at(&mut self, place: Point) {
        self.pieces.clear();
        self.open = false;
        (self.start, self.end) = (place, place);
    }

    /// Where the newest line sent leads.
    pub fn end(&self) -> Point {
        self.end
    }

    /// A report of the machine's place.
    ///
    /// # Errors
    /// It is on none of the pieces that the machine can be in.
    pub fn report(&self, place: Point) -> Result<(), OffPath> {
        let beside = |p: &Piece| {
            let near = nearest_on_segment(&place, &p.from, &p.to);
            (near - place).norm() - p.slack
        };
        let start = (self.start - place).norm();
        let distance = self
            .pieces
            .iter()
            .map(beside)
            .chain([start])
            .fold(f64::INFINITY, f64::min);
        if distance <= self.options.tolerance {
            return Ok(());
        }
        Err(OffPath {
            place: [place.x, place.y, place.z],
            distance,
            lines: (
                self.pieces.front().map_or(self.line, |p| p.lines.0),
                self.line,
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn at(x: f64) -> Point {
        Point::new(x, 0.0, 0.0)
    }

    #[test]
    fn a_place_beside_the_way_is_told_with_its_lines() {
        let mut w = Watch::new(at(0.0), WatchOptions::default());
        w.sent(7, [at(10.0)]);
        w.sent(8, [Point::new(10.0, 5.0, 0.0)]);
        assert_eq!(w.report(at(3.3)), Ok(()));
        assert_eq!(w.report(Point::new(10.02, 4.0, 0.0)), Ok(()));
        let e = w.report(Point::new(4.0, 1.25, 0.0)).unwrap_err();
        assert_eq!((e.distance, e.lines), (1.25, (7, 8)), "{e}");
        assert!(e.to_string().starts_with("the machine is at X4.000 Y1.250 Z0.000 (machine coordinates), 1.250 mm beside the way of lines 7 to 8, so it is not doing what it was sent: bytes were damaged"));
        assert!(w.report(Point::new(f64::NAN, 0.0, 0.0)).is_err());
    }

    #[test]
    fn what_is_over_is_forgotten_and_what_is_not_is_kept() {
        let mut w = Watch::new(at(0.0), WatchOptions::default());
        for line in 1..=100 {
            w.sent(line, [at(line as f64)]);
        }
        assert_eq!(w.report(at(0.5)), Ok(()));
        w.answered(50);
        // 21 blocks may be held, and one is cut.
        assert_eq!(w.report(at(28.5)), Ok(()));
        assert!(w.report(at(27.5)).is_err());
        assert_eq!(w.report(at(99.5)), Ok(()));
        w.stands_at(at(-3.0));
        assert!(w.report(at(50.0)).is_err());
        assert_eq!(w.report(at(-3.0)), Ok(()));
        w.sent(101, [at(-4.0)]);
        assert_eq!(w.report(at(-3.5)), Ok(()));
    }

    #[test]
    fn moves_shorter_than_a_block_are_joined_and_cost_no_memory() {
        let mut w = Watch::new(at(0.0), WatchOptions::default());
        for line in 1..=100_000 {
            // To and fro in place, then on by 20 micrometres a line.
            let x = if line < 50_000 {
                0.01 * (line % 2) as f64
            } else {
                0.02 * (line - 50_000) as f64
            };
            w.sent(line, [at(x)]);
            w.answered(line);
            assert!(w.pieces.len() <= 24, "{}", w.pieces.len());
        }
        // 22 blocks of three lines each are not over.
        assert_eq!(w.report(at(1000.0 - 21.0 * 0.06)), Ok(()));
        assert!(w.report(at(1000.0 - 24.0 * 0.06)).is_err());
    }

    #[test]
    fn coarse_steps_widen_the_tolerance_and_the_blocks() {
        let o = WatchOptions::of([Some(5.0), Some(5.0), Some(100.0)], Some(15));
        assert!((o.tolerance - (0.05 + 0.5 * (0.04f64 + 0.04 + 0.0001).sqrt())).abs() < 1e-12);
        assert!((o.block - 0.3).abs() < 1e-12);
        assert_eq!(o.held, 27);
        let o = WatchOptions::of([None; 3], None);
        assert!(o.held == 140 && o.tolerance > 0.09, "{o:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// A machine that does what it was sent is never told off, however far it lags behind the answers, and memory is bounded.
        #[test]
        fn no_false_alarm(
            points in proptest::collection::vec(proptest::array::uniform3(-50.0f64..50.0), 1..200), scale in proptest::sample::select(vec![1.0, 0.001]),
            lag in 0usize..=21, part in 0.0f64..1.0, ahead in 0usize..12,
        ) {
            let mut w = Watch::new(Point::origin(), WatchOptions::default());
            let places: Vec<Point> = points.iter().map(|p| Point::from(*p) * scale).collect();
            for (i, place) in places.iter().enumerate() {
                w.sent(i + 1, [*place]);
                let Some(answered) = i.checked_sub(ahead) else { continue };
                w.answered(answered);
                prop_assert!(w.pieces.len() <= 22 + ahead + 1);
                // It is somewhere in the piece that ends `lag` lines behind the last one answered.
                let Some(now) = answered.checked_sub(lag + 1) else { continue };
                let from = now.checked_sub(1).map_or(Point::origin(), |i| places[i]);
                let here = from + (places[now] - from) * part;
                prop_assert_eq!(w.report(here), Ok(()));
            }
        }
    }
}
