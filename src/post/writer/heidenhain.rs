//! Motions in Heidenhain's conversational language: `L X+10 Y+20 R0 FMAX`, `CC` and `C`, helices as `CP`.

use super::circle::Circle;
use super::page::Kind;
use super::scribe::Scribe;
use crate::geom::Plane;
use crate::post::definition::Numbers;
use crate::post::error::Refusal;
use crate::post::number;
use std::io::Write;

impl<W: Write> Scribe<'_, W> {
    /// A straight move, a rapid without a feed. FMAX acts in its block only: the last F holds again after it.
    pub(super) fn line_block(
        &mut self,
        to: [Option<i64>; 3],
        feed: Option<i64>,
    ) -> Result<(), Refusal> {
        let moves = |axis: usize| to[axis].is_some() && to[axis] != self.at[axis];
        if !(moves(0) || moves(1) || moves(2)) {
            return Ok(());
        }
        self.page.begin(Kind::Words);
        self.page.word("L");
        self.axes(to, self.post.modal.axes && self.adrift.is_none());
        if to[0].is_some() && to[1].is_some() {
            self.adrift = None;
        }
        match feed {
            None => {
                self.page.word("R0");
                self.page.word("FMAX");
            }
            Some(feed) => self.feed_word(feed),
        }
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }

    /// A circle's centre, where it is not the last one, and the arc; with a change of height as a polar helix. Circles lie in the
    /// XY plane: the post allows no other.
    pub(super) fn arc_blocks(
        &mut self,
        circle: &Circle,
        to: [Option<i64>; 3],
        feed: i64,
    ) -> Result<(), Refusal> {
        let manner = self.post.numbers;
        let way = if circle.sweep < 0.0 { "DR-" } else { "DR+" };
        let climb = self.at[2].zip(to[2]).map_or(0, |(from, to)| to - from);
        let start = match (self.adrift, self.at) {
            (Some(start), _) => Some(start),
            // Counts of eight digits: exact.
            (_, [Some(x), Some(y), _]) => Some([x as f64, y as f64]),
            _ => None,
        };
        // With so large a radius a rounding of the angle is far; a line leaves a short piece of it by less than the last decimal tells.
        if let (Some([x, y]), true) = (start, climb != 0) {
            let [u, v] = circle.center.map(|c| c as f64);
            let bulge = (x - u).hypot(y - v) * (1.0 - (0.5 * circle.sweep).cos());
            if circle.sweep.abs() < std::f64::consts::PI && bulge < END {
                return self.line_block(to, Some(feed));
            }
        }
        let (pole, sweep) = match (start, to) {
            (Some(start), [Some(u), Some(v), _]) if climb != 0 => {
                polar(circle, start, [u as f64, v as f64])
            }
            _ => (circle.center.map(|c| 10 * c), circle.sweep),
        };
        if self.pole != Some(pole) {
            self.page.begin(Kind::Words);
            self.page.word("CC");
            // A place of the tool has one decimal less than the controller reads (0.1 um).
            self.page.figure("X", pole[0], self.decimals + 1, manner);
            self.page.figure("Y", pole[1], self.decimals + 1, manner);
            self.page.end()?;
            self.pole = Some(pole);
        }
        self.page.begin(Kind::Words);
        if climb == 0 {
            self.page.word("C");
            self.axes([to[0], to[1], None], false);
            self.adrift = None;
        } else {
            let turn = number::round(sweep.to_degrees(), self.post.decimals.angle);
            let turn = turn.ok_or(Refusal::Cannot {
                what: "helix of so many turns",
                remedy: "let it be split into arcs (--split-circles)",
            })?;
            let signed = Numbers {
                plus: true,
                ..manner
            };
            // Where the angle as written leads.
            let told =
                (turn as f64 * 0.1_f64.powi(i32::from(self.post.decimals.angle))).to_radians();
            let end = start.map(|[x, y]| {
                let [u, v] = pole.map(|c| 0.1 * c as f64);
                let (a, b) = (x - u, y - v);
                let (sin, cos) = told.sin_cos();
                [u + a * cos - b * sin, v + a * sin + b * cos]
            });
            let off = |k: usize| match (end, to[k]) {
                (Some(end), Some(count)) => (end[k] - count as f64).abs(),
                _ => 0.0,
            };
            if off(0).max(off(1)) > END {
                let unit = self.post.units.mm() * 0.1_f64.powi(i32::from(self.decimals));
                return Err(Refusal::ArcRounding {
                    plane: Plane::Xy,
                    center: circle.center.map(|c| c as f64 * unit),
                    decimals: self.decimals,
                    problem: "a helix said by its angle would end beside its end",
                });
            }
            self.page.word("CP");
            self.page
                .figure("IPA", turn, self.post.decimals.angle, signed);
            self.page.figure("IZ", climb, self.decimals, manner);
            self.at = to;
            self.adrift = end;
        }
        self.page.word(way);
        self.feed_word(feed);
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }
}

/// So much may start and end differ in their distances from a pole, in units of the last decimal.
const LEFT: f64 = 0.25;
/// ... and so far may the way be off halfway for that.
const HALFWAY: f64 = 2.0;
/// ... and so far may the end be off the place it is meant to be.
const END: f64 = 0.5;

/// The pole of a helix, in tenths of a count, and its angle. Its end is where the angle leads from the start, at the start's distance from
/// the pole: so the pole is moved off the rounded centre until it is about as far from start as from end, and the angle is the one seen
/// from there.
fn polar(circle: &Circle, start: [f64; 2], end: [f64; 2]) -> ([i64; 2], f64) {
    let [x, y] = circle.center.map(|c| c as f64);
    let (dx, dy) = (end[0] - start[0], end[1] - start[1]);
    let chord = dx.hypot(dy);
    let mut pole = [x, y];
    // Back to the start, every centre will do.
    if chord > 1.0 {
        let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
        let off = ((x - middle[0]) * dx + (y - middle[1]) * dy) / chord;
        let miss = (start[0] - x).hypot(start[1] - y) - (end[0] - x).hypot(end[1] - y);
        // No further than it must be: what it gains at the end it loses halfway.
        let by = off * (1.0 - LEFT / miss.abs()).max(0.0);
        // Halfway round it takes the path along, by this much for each unit.
        let along = 2.0 * (0.25 * circle.sweep.abs().min(std::f64::consts::TAU)).sin();
        let by = by.clamp(-HALFWAY / along, HALFWAY / along);
        pole = [x - by * dx / chord, y - by * dy / chord];
    }
    let pole = pole.map(|c| (10.0 * c).round() as i64);
    let [u, v] = pole.map(|c| 0.1 * c as f64);
    let (a, b, c, d) = (start[0] - u, start[1] - v, end[0] - u, end[1] - v);
    let turn = (a * d - b * c).atan2(a * c + b * d);
    let turns = ((circle.sweep - turn) / std::f64::consts::TAU).round();
    (pole, turn + turns * std::f64::consts::TAU)
}
