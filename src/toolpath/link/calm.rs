//! Calm: a lower feed where the way would throw the tool up and down harder than the machine should.
//!
//! A turn between two passes that run level on a slope lies across the slope: taken at full feed it is the hardest throw of the whole
//! job, in a place that is finished already; a pass that rolls over a ridge comes next. The throw goes with the square of the speed, the
//! time lost only with its first power and over a millimetre or two.
//!
//! Crosses the border: moves of the tool tip in, the same moves out, [`Move::feed`] set on some cuts and links. Knows nothing of the part.

use super::LinkOptions;
use crate::toolpath::moves::{Move, MoveKind};
use crate::units::MmPerMin;

/// A cut is thrown up and down by no more than this share of `vertical`, a link by all of it: cuts are what is looked at afterwards.
const CUTS: f64 = 0.5;
/// The vertical acceleration is told over three heights this far apart in time, s: shorter throws are the chords' and the motors'.
const SAMPLE: f64 = 0.01;
/// Feeds are this many parts of the job's; one for each part less is tried.
const PARTS: usize = 20;
/// No slower than this many of those parts: a way that is steep all along is not made better by crawling.
const FEWEST: usize = 6;
/// In a link a feed holds for this far along the way at least, mm: changes every few tenths of a millimetre would be throws again.
const HOLDS: f64 = 1.0;

/// Gives cuts and links a lower feed where the vertical acceleration would exceed `options.vertical` (half of it in cuts). Some ten looks at each place where it
/// does, one elsewhere.
pub fn calm(moves: &mut [Move], options: &LinkOptions) {
    if !(options.vertical.is_finite() && options.vertical > 0.0) {
        return;
    }
    let on_surface = |m: &Move| matches!(m.kind, MoveKind::Cut | MoveKind::Link);
    let mut end = 1;
    while end < moves.len() {
        let first = end;
        end += 1;
        if !on_surface(&moves[first]) {
            continue;
        }
        while end < moves.len() && on_surface(&moves[end]) {
            end += 1;
        }
        let way = Way::of(&moves[first - 1..end]);
        let link: Vec<bool> = moves[first..end]
            .iter()
            .map(|m| m.kind == MoveKind::Link)
            .collect();
        for (m, parts) in moves[first..end]
            .iter_mut()
            .zip(parts(&way, &link, options))
        {
            if parts < PARTS {
                let feed = options.feed * 60.0 * parts as f64 / PARTS as f64;
                // Whole numbers where they are numbers at all: a program is read by people too.
                m.feed = Some(MmPerMin(if feed >= 10.0 { feed.floor() } else { feed }));
            }
        }
    }
}

/// Parts of the job's feed for each move of a way, of which some are links. Where a link meets a cut it is the link that goes slower, and
/// all of it; a cut is slowed only where itself is thrown.
fn parts(way: &Way, link: &[bool], options: &LinkOptions) -> Vec<usize> {
    let mut parts = vec![PARTS; way.moves()];
    let mut places: Vec<f64> = way.places().collect();
    let over = |linked: bool| options.vertical * if linked { 1.0 } else { CUTS } * SAMPLE * SAMPLE;
    for k in (FEWEST + 1..=PARTS).rev() {
        let step = options.feed * k as f64 / PARTS as f64 * SAMPLE;
        // What is calm at one speed is calm at any lower one.
        places.retain(|&s| {
            let linked = link[way.between(s - step, s + step)].contains(&true);
            (way.height(s - step) - 2.0 * way.height(s) + way.height(s + step)).abs() > over(linked)
        });
        for s in &places {
            let near = way.between(s - step, s + step);
            let linked = link[near.clone()].contains(&true);
            for i in near.filter(|&i| link[i] == linked) {
                parts[i] = parts[i].min(k - 1);
            }
        }
    }
    (0..parts.len())
        .map(|i| {
            if !link[i] {
                return parts[i];
            }
            let (from, to) = way.span(i);
            way.between(from - HOLDS, to + HOLDS)
                .filter(|&j| link[j])
                .map(|j| parts[j])
                .min()
                .unwrap_or(PARTS)
        })
        .collect()
}

/// Heights along a run of moves on the surface.
struct Way {
    /// Distance along the way and height of each end of a move, mm; never none.
    knots: Vec<(f64, f64)>,
}

impl Way {
    /// Of moves that follow one another; the first one is only where the second begins.
    fn of(moves: &[Move]) -> Way {
        let mut s = 0.0;
        let mut knots: Vec<(f64, f64)> = moves.first().map(|m| (0.0, m.to.z)).into_iter().collect();
        knots.extend(moves.windows(2).map(|w| {
            s += w[1].length(&w[0].to);
            (s, w[1].to.z)
        }));
        Way { knots }
    }

    fn moves(&self) -> usize {
        self.knots.len() - 1
    }

    /// Where the `i`th move begins and ends.
    fn span(&self, i: usize) -> (f64, f64) {
        (self.knots[i].0, self.knots[i + 1].0)
    }

    /// The moves that reach into an open stretch of the way.
    fn between(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let first = self.knots[1..].partition_point(|k| k.0 <= from);
        let end = self.knots[..self.moves()].partition_point(|k| k.0 < to);
        first..end.max(first)
    }

    /// Height at a place; before the first and behind the last knot it goes on straight.
    fn height(&self, s: f64) -> f64 {
        let j = self
            .knots
            .partition_point(|k| k.0 < s)
            .clamp(1, self.moves());
        let ((a, za), (b, zb)) = (self.knots[j - 1], self.knots[j]);
        if b > a {
            za + (zb - za) * (s - a) / (b - a)
        } else {
            zb
        }
    }

    /// Where the throw is told: at the knots and halfway between them.
    fn places(&self) -> impl Iterator<Item = f64> + '_ {
        let halves = self.knots.windows(2).map(|w| 0.5 * (w[0].0 + w[1].0));
        self.knots
            .iter()
            .map(|k| k.0)
            .zip(halves.chain([f64::NAN]))
            .flat_map(|(a, b)| [a, b])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geom::Point;
    use crate::toolpath::link::tests::SOME;

    fn options(vertical: f64) -> LinkOptions {
        LinkOptions { vertical, ..SOME }
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
