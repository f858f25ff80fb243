//! Calm links: a feed of their own for links that would throw the tool up and down.
//!
//! A turn between two passes that run level on a slope lies across the slope: taken at full feed it is the hardest throw of the whole
//! job, in a place that is finished already. The throw goes with the square of the speed, the time lost only with its first power and
//! over a millimetre or two. Passes keep the job's feed.
//!
//! Crosses the border: moves of the tool tip in, the same moves out, [`Move::feed`] set on some links. Knows nothing of the part.

use super::link::LinkOptions;
use super::moves::{Move, MoveKind};
use crate::units::MmPerMin;

/// A good share of the Z axis' acceleration for [`LinkOptions::vertical`].
pub const CALM: f64 = 0.5;
/// The vertical acceleration is told over three heights this far apart in time, s: shorter throws are the chords' and the motors'.
const SAMPLE: f64 = 0.01;
/// Feeds are this many parts of the job's; one for each part less is tried.
const PARTS: usize = 20;
/// No slower than this many of those parts: a link that is steep all along is not made better by crawling.
const FEWEST: usize = 6;
/// A feed holds for this far along the way at least, mm: changes every few tenths of a millimetre would be throws again.
const HOLDS: f64 = 1.0;

/// Gives links a lower feed where the vertical acceleration would exceed `options.vertical`. Linear in the moves.
pub fn calm(moves: &mut [Move], options: &LinkOptions) {
    if !(options.vertical.is_finite() && options.vertical > 0.0) {
        return;
    }
    let mut end = 1;
    while end < moves.len() {
        let first = end;
        end += 1;
        if moves[first].kind != MoveKind::Link {
            continue;
        }
        while end < moves.len() && moves[end].kind == MoveKind::Link {
            end += 1;
        }
        let parts = parts(moves, first, end, options);
        for (m, parts) in moves[first..end].iter_mut().zip(parts) {
            if parts < PARTS {
                let feed = options.feed * 60.0 * parts as f64 / PARTS as f64;
                // Whole numbers where they are numbers at all: a program is read by people too.
                m.feed = Some(MmPerMin(if feed >= 10.0 { feed.floor() } else { feed }));
            }
        }
    }
}

/// Parts of the job's feed for each of the links `first..end`.
fn parts(moves: &[Move], first: usize, end: usize, options: &LinkOptions) -> Vec<usize> {
    // The way with a little of the cuts on both sides: most throws begin where a pass ends.
    let widest = 2.0 * SAMPLE * options.feed;
    let way = Way::around(moves, first, end, widest);
    let mut parts = vec![PARTS; end - first];
    for k in (FEWEST + 1..=PARTS).rev() {
        let v = options.feed * k as f64 / PARTS as f64;
        let step = v * SAMPLE;
        let over = options.vertical * SAMPLE * SAMPLE;
        for s in way.places() {
            if (way.height(s - step) - 2.0 * way.height(s) + way.height(s + step)).abs() <= over {
                continue;
            }
            for (i, p) in parts.iter_mut().enumerate() {
                let (from, to) = way.span(i);
                if *p == k && from < s + step && to > s - step {
                    *p = k - 1;
                }
            }
        }
    }
    (0..parts.len())
        .map(|i| {
            let (from, to) = way.span(i);
            (0..parts.len())
                .filter(|&j| {
                    let (f, t) = way.span(j);
                    f < to + HOLDS && t > from - HOLDS
                })
                .map(|j| parts[j])
                .min()
                .unwrap_or(PARTS)
        })
        .collect()
}

/// Heights along a run of links and a little of what is before and behind it.
struct Way {
    /// Distance along the way and height of each end of a move, mm.
    knots: Vec<(f64, f64)>,
    /// Index of the knot where the first link begins.
    begin: usize,
    /// Links.
    count: usize,
}

impl Way {
    fn around(moves: &[Move], first: usize, end: usize, beyond: f64) -> Way {
        let cut = |m: &Move| matches!(m.kind, MoveKind::Cut | MoveKind::Link);
        let length = |i: usize| moves[i].length(&moves[i - 1].to);
        let (mut low, mut high) = (first - 1, end);
        let mut room = 0.0;
        while low > 0 && room < beyond && cut(&moves[low]) {
            room += length(low);
            low -= 1;
        }
        room = 0.0;
        while high < moves.len() && room < beyond && cut(&moves[high]) {
            room += length(high);
            high += 1;
        }
        let mut s = 0.0;
        let knots = (low..high)
            .map(|i| {
                if i > low {
                    s += length(i);
                }
                (s, moves[i].to.z)
            })
            .collect();
        Way {
            knots,
            begin: first - 1 - low,
            count: end - first,
        }
    }

    /// Where the `i`th link begins and ends.
    fn span(&self, i: usize) -> (f64, f64) {
        (
            self.knots[self.begin + i].0,
            self.knots[self.begin + i + 1].0,
        )
    }

    /// Height at a place; before the first and behind the last knot it goes on straight.
    fn height(&self, s: f64) -> f64 {
        let n = self.knots.len();
        let j = self.knots.partition_point(|k| k.0 < s).clamp(1, n - 1);
        let ((a, za), (b, zb)) = (self.knots[j - 1], self.knots[j]);
        if b > a {
            za + (zb - za) * (s - a) / (b - a)
        } else {
            zb
        }
    }

    /// Where the throw is told: at the knots of the links and halfway between them.
    fn places(&self) -> impl Iterator<Item = f64> + '_ {
        (self.begin..=self.begin + self.count).flat_map(|j| {
            let s = self.knots[j].0;
            let half = self.knots.get(j + 1).map(|k| 0.5 * (s + k.0));
            std::iter::once(s).chain(half)
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point;

    fn options(vertical: f64) -> LinkOptions {
        LinkOptions {
            feed: 25.0,
            plunge: 8.0,
            rapid_xy: 60.0,
            rapid_z: 40.0,
            acceleration: 500.0,
            allowance: 0.5,
            clearance: 0.5,
            block_center_z: f64::NEG_INFINITY,
            safe_center_z: 10.0,
            retract_center_z: f64::NEG_INFINITY,
            retract_worth: 2.0,
            vertical,
        }
    }

    /// A level pass, half a circle of radius 0.5 mm across a slope (height = slope * y), and a level pass back.
    fn turn(slope: f64) -> Vec<Move> {
        let at = |x: f64, y: f64| Point::new(x, y, slope * y);
        let mut moves = vec![
            Move::straight(MoveKind::Rapid, at(-5.0, 0.0)),
            Move::straight(MoveKind::Cut, at(0.0, 0.0)),
        ];
        moves.extend((1..=30).map(|k| {
            let a = std::f64::consts::PI * f64::from(k) / 30.0;
            Move::straight(MoveKind::Link, at(0.5 * a.sin(), 0.5 - 0.5 * a.cos()))
        }));
        moves.push(Move::straight(MoveKind::Cut, at(-5.0, 1.0)));
        moves
    }

    #[test]
    fn level_turns_keep_the_jobs_feed() {
        let mut moves = turn(0.0);
        calm(&mut moves, &options(150.0));
        assert!(moves.iter().all(|m| m.feed.is_none()));
    }

    /// On a slope the throw is v^2 / r times the sine of the slope: half the speed for a quarter of it.
    #[test]
    fn a_turn_on_a_slope_is_taken_at_the_speed_that_keeps_the_limit() {
        for (slope, limit) in [(0.1, 60.0), (0.5, 150.0), (1.0, 150.0)] {
            let mut moves = turn(slope);
            calm(&mut moves, &options(limit));
            assert!(moves[1].feed.is_none() && moves[32].feed.is_none(), "cuts");
            let feed = moves[10].feed.unwrap().0;
            // The path turns in the slope's own plane: flat radius 0.5 mm, rise per flat mm `slope`.
            let v = (limit * 0.5 / slope).sqrt().min(25.0);
            assert!(
                (feed / 60.0 - v).abs() < 0.2 * v + 0.1,
                "{slope}: {feed} {v}"
            );
            assert!(moves[2..32].iter().all(|m| m.feed == moves[10].feed));
        }
    }

    #[test]
    fn a_limit_that_is_none_and_paths_that_are_nothing_are_left_alone() {
        let mut moves = turn(1.0);
        calm(&mut moves, &options(f64::INFINITY));
        assert!(moves.iter().all(|m| m.feed.is_none()));
        calm(&mut [], &options(150.0));
        calm(&mut moves[..1], &options(150.0));
        let mut same = vec![moves[1]; 4];
        same.iter_mut().for_each(|m| m.kind = MoveKind::Link);
        calm(&mut same, &options(150.0));
    }
}
