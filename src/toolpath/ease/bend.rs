//! Bends: curves from one place and heading to another, off the part, and their proof.
//!
//! Crosses the border: places on a run in, proven places of the ball's centre out; work coordinates, mm.

use super::EaseOptions;
use super::run::{Place, angle};
use crate::geom::{Point, Vector};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::link::bridge::{End, bridge};
use crate::toolpath::link::turn::{Pose, Slant, turn};
use crate::toolpath::sharp::SHORTEST;

/// Pieces of a bend are no longer, mm.
const PIECE: f64 = 0.1;
/// Chords are proven at places this far apart, mm.
const PROBE: f64 = 0.025;
/// The move that a bend cuts short may end up so much deeper than a chord may be, as a share of that: by the program's rounding.
const ROUNDED: f64 = 1.25;
/// How far a bend is pushed out of the part at most, mm.
const PUSH: f64 = 0.25;

/// What stands in the way of a bend, and how it is proven.
pub(super) struct Proof<'a> {
    pub(super) cutter: &'a DropCutter,
    pub(super) how: &'a EaseOptions<'a>,
    pub(super) hint: Hint,
}

impl Proof<'_> {
    pub(super) fn clear(&mut self, q: &Point, share: f64) -> bool {
        (self.cutter).is_clear(q, share * self.how.gouge, &mut self.hint)
    }

    pub(super) fn chord(&mut self, a: &Point, b: &Point, share: f64) -> bool {
        let n = ((b - a).norm() / PROBE).ceil().max(1.0) as usize;
        (0..=n).all(|k| self.clear(&(a + (b - a) * (k as f64 / n as f64)), share))
    }

    pub(super) fn snapped(&self, p: Point) -> Point {
        let d = self.how.decimal;
        if d <= 0.0 {
            return p;
        }
        let r = self.cutter.radius();
        let on = |v: f64| (v / d).round() * d;
        Point::new(on(p.x), on(p.y), ((p.z - r) / d - 0.1).ceil() * d + r)
    }

    /// The bend as it may be gone: pushed out of the part, on the program's decimals, nowhere sharp.
    pub(super) fn proven(
        &mut self,
        a: &Place,
        b: &Place,
        mut bend: Vec<Point>,
        most: f64,
    ) -> Option<Vec<Point>> {
        let n = bend.len();
        if n < 2 || !smooth(&a.heading, &bend, &b.heading, most) {
            return None;
        }
        for (k, q) in bend.iter_mut().enumerate() {
            if k > 0 && k + 1 < n && !self.clear(q, 1.0) {
                *q = self.cutter.pushed_out(q, PUSH)?;
            }
        }
        for q in bend.iter_mut() {
            *q = self.snapped(*q);
        }
        bend.dedup_by(|q, p| (*q - *p).norm() < 1e-6);
        if bend.len() < 2 || !smooth(&a.heading, &bend, &b.heading, most) {
            return None;
        }
        let clear = bend.windows(2).all(|w| self.chord(&w[0], &w[1], 1.0))
            // What leads to it and on is proven; its ends were moved by less than a decimal.
            && self.chord(&a.from, &bend[0], ROUNDED)
            && self.chord(&bend[bend.len() - 1], &b.to, ROUNDED);
        clear.then_some(bend)
    }
}

/// Does a way turn by no more than `most` rad from chord to chord, and from the way before it and to that after it?
pub(in crate::toolpath) fn smooth(
    before: &Vector,
    bend: &[Point],
    after: &Vector,
    most: f64,
) -> bool {
    let mut way = *before;
    let mut at = bend[0];
    for q in &bend[1..] {
        let d = q - at;
        let l = d.norm();
        if l < SHORTEST {
            continue;
        }
        let d = d / l;
        if angle(&way, &d) > most {
            return false;
        }
        (way, at) = (d, *q);
    }
    angle(&way, after) <= most
}

/// A cubic from one place and heading to another: an arc where they lie so. Appended without its first point.
pub(in crate::toolpath) fn cubic(
    from: &Point,
    u: &Vector,
    to: &Point,
    v: &Vector,
    piece: f64,
    out: &mut Vec<Point>,
) {
    let d = to - from;
    let chord = d.norm();
    let turn = angle(u, v);
    let pull = if turn < 1e-3 {
        chord
    } else {
        2.0 * chord * (0.25 * turn).tan() / (0.5 * turn).sin()
    };
    // What the way turns in all, there and back.
    let all = if chord > 1e-9 {
        (angle(u, &d) + angle(&d, v)).max(turn)
    } else {
        turn
    };
    let n = (all / piece)
        .max(1.2 * chord / PIECE)
        .ceil()
        .clamp(2.0, 200.0) as usize;
    for k in 1..=n {
        let t = k as f64 / n as f64;
        let (t2, t3) = (t * t, t * t * t);
        let p = from.coords * (2.0 * t3 - 3.0 * t2 + 1.0)
            + u * (pull * (t3 - 2.0 * t2 + t))
            + to.coords * (3.0 * t2 - 2.0 * t3)
            + v * (pull * (t3 - t2));
        out.push(Point::from(p));
    }
}

/// Straight from place to place, round.
pub(super) fn beside(a: &Place, b: &Place, piece: f64) -> Vec<Point> {
    let mut out = vec![a.at];
    cubic(&a.at, &a.heading, &b.at, &b.heading, piece, &mut out);
    out
}

/// Up, back over, and down.
pub(super) fn over(a: &Place, b: &Place, radius: f64, piece: f64) -> Option<Vec<Point>> {
    let across = b.at - a.at;
    let flat = Vector::new(across.x, across.y, 0.0);
    let level = |v: &Vector| Vector::new(v.x, v.y, 0.0).try_normalize(0.05);
    let way = if flat.norm() > 0.05 {
        flat.try_normalize(1e-9)
    } else {
        level(&b.heading).or_else(|| level(&a.heading).map(|u| -u))
    }?;
    let top = nalgebra::center(&a.at, &b.at).coords;
    let top = Point::new(top.x, top.y, a.at.z.max(b.at.z) + 2.0 * radius);
    let mut out = vec![a.at];
    cubic(&a.at, &a.heading, &top, &way, piece, &mut out);
    cubic(&top, &way, &b.at, &b.heading, piece, &mut out);
    Some(out)
}

/// Round in plan, over what is in the way.
pub(super) fn round(cutter: &DropCutter, a: &Place, b: &Place, radius: f64) -> Option<Vec<Point>> {
    let pose = |p: &Place| {
        let flat = p.heading.xy();
        Some(Pose {
            at: p.at.xy(),
            heading: flat.try_normalize(0.3)?,
        })
    };
    let way = turn(&Slant::default(), &pose(a)?, &pose(b)?, radius);
    let end = |p: &Place| End {
        at: p.at,
        heading: p.heading,
    };
    bridge(cutter, &way.points(0.1), &end(a), &end(b))
}
