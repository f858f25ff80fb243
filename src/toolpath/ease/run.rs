//! Runs along the surface, their sharp corners, and the places beside one between which it may be gone round.
//!
//! Crosses the border: places of the ball's centre in, places between them out; work coordinates, mm. Knows nothing of bends.

use super::{BACK, EaseOptions, Limits};
use crate::geom::{Point, Vector};
use crate::reach::DropCutter;
use crate::toolpath::ease::GENTLE;
use crate::toolpath::moves::MoveKind;
use crate::toolpath::sharp::SHORTEST;

/// How far from the corner a bend may begin and end, in stepovers.
const OFFSETS: [f64; 14] = [
    0.0, 0.04, 0.07, 0.15, 0.22, 0.3, 0.45, 0.65, 1.0, 1.5, 2.2, 3.2, 4.6, 6.5,
];
/// The offset that is liked best on links, in stepovers.
const LIKED: f64 = 0.45;
/// The two sides of a spike are no further apart, in stepovers.
const SPIKE: f64 = 0.09;
/// How wide its tip may be, in stepovers.
const TIPS: [f64; 4] = [0.0, 0.04, 0.1, 0.17];
/// No spike is longer, mm.
const LONGEST_SPIKE: f64 = 20.0;
/// Moves steeper than this (rise over length) climb a wall.
const CLIMB: f64 = 0.98;

/// A way along the surface: places of the ball's centre and what each move between them is.
#[derive(Clone, Debug, Default)]
pub(super) struct Run {
    pub(super) points: Vec<Point>,
    /// Of the move that ends at the point; that of the first point means nothing.
    pub(super) kinds: Vec<MoveKind>,
    /// Where each point came from.
    pub(super) origin: Vec<usize>,
    /// Way to each point, mm.
    pub(super) along: Vec<f64>,
    /// The part of it that is cut, climbs counted as far as they count, mm.
    pub(super) cut: Vec<f64>,
}

/// A place on a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: Point,
    pub(super) heading: Vector,
    /// The point behind which it lies (or at which).
    pub(super) after: usize,
    /// Where the move that it lies on begins and ends.
    pub(super) from: Point,
    /// The other end.
    pub(super) to: Point,
    /// Way and cut way up to it, mm.
    pub(super) along: f64,
    pub(super) cut: f64,
}

/// A sharp turn of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) point: usize,
    pub(super) before: Vector,
    pub(super) after: Vector,
    pub(super) limits: Limits,
}

pub(super) fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl Run {
    pub(super) fn measure(&mut self, climb: f64) {
        self.along.clear();
        self.cut.clear();
        let (mut s, mut c) = (0.0, 0.0);
        for k in 0..self.points.len() {
            if k > 0 {
                let d = self.points[k] - self.points[k - 1];
                let l = d.norm();
                s += l;
                if self.kinds[k] == MoveKind::Cut {
                    c += if d.z.abs() < CLIMB * l { l } else { climb * l };
                }
            }
            self.along.push(s);
            self.cut.push(c);
        }
    }

    /// The next turn over the limit that is not the part's, of those behind the point `from`.
    pub(super) fn corner(
        &self,
        cutter: &DropCutter,
        from: usize,
        how: &EaseOptions,
    ) -> Option<Corner> {
        let first = self.points.get(from)?;
        let (mut at, mut start, mut way) = (from, *first, None::<Vector>);
        for (k, p) in self.points.iter().enumerate().skip(from + 1) {
            let d = p - start;
            let l = d.norm();
            if l < SHORTEST {
                continue;
            }
            let after = d / l;
            if let Some(before) = way {
                let turn = angle(&before, &after);
                // The gentlest limit first: most turns are below it.
                if turn > GENTLE
                    && let limits = how.limits(&start)
                    && turn > limits.eased
                    && cutter.own_turn(&start, &before, &after) > limits.eased
                {
                    return Some(Corner {
                        point: at,
                        before,
                        after,
                        limits,
                    });
                }
            }
            (at, start, way) = (k, *p, Some(after));
        }
        None
    }

    /// The place this far along, heading onwards.
    pub(super) fn place(&self, s: f64) -> Option<Place> {
        let n = self.points.len();
        if n < 2 || s <= 0.0 || s >= self.along[n - 1] {
            return None;
        }
        let k = self
            .along
            .partition_point(|a| *a <= s)
            .saturating_sub(1)
            .min(n - 2);
        let (a, b) = (self.points[k], self.points[k + 1]);
        let l = self.along[k + 1] - self.along[k];
        let t = (s - self.along[k]) / l.max(1e-12);
        Some(Place {
            at: a + (b - a) * t,
            heading: (b - a).try_normalize(1e-9)?,
            after: k,
            from: a,
            to: b,
            along: s,
            cut: self.cut[k] + (self.cut[k + 1] - self.cut[k]) * t,
        })
    }

    /// The first and last kinds of moves between two places.
    pub(super) fn kinds_between(&self, a: &Place, b: &Place) -> (MoveKind, MoveKind) {
        let last = self.points.len() - 1;
        (
            self.kinds[(a.after + 1).min(last)],
            self.kinds[(b.after + 1).min(last)],
        )
    }

    /// Puts a bend in place of what is between two places. Returns the point before it.
    pub(super) fn splice(
        &mut self,
        a: &Place,
        b: &Place,
        bend: &[Point],
        kind: MoveKind,
        climb: f64,
    ) -> usize {
        let origin = self.origin[(a.after + 1).min(self.origin.len() - 1)];
        let behind = b.after + 1;
        let first_kind = self.kinds[(a.after + 1).min(self.kinds.len() - 1)];
        // A place on a point is that point.
        let head = if (self.points[a.after] - bend[0]).norm() < 1e-9 {
            a.after
        } else {
            a.after + 1
        };
        let skip = usize::from(
            (self.points[behind.min(self.points.len() - 1)] - bend[bend.len() - 1]).norm() < 1e-9,
        );
        let from = head.min(a.after + 1);
        let mut kinds = vec![kind; bend.len()];
        if head == a.after {
            kinds[0] = self.kinds[a.after];
        } else {
            kinds[0] = first_kind;
        }
        let to = behind + skip;
        self.points.splice(from..to, bend.iter().copied());
        self.kinds.splice(from..to, kinds);
        self.origin.splice(from..to, vec![origin; bend.len()]);
        if head == a.after {
            // What led to the point came from elsewhere.
            self.origin[from] = origin.min(self.origin[from]);
        }
        self.measure(climb);
        from.saturating_sub(1)
    }
}

/// How far the way goes back on itself from a place on (mm before it, behind it): on its own line, or the width of a spike's tip beside.
pub(super) fn spike(run: &Run, s: f64, stepover: f64) -> Option<(f64, f64)> {
    let step = 0.07 * stepover;
    TIPS.iter()
        .map(|tip| tip * stepover)
        .flat_map(|tip| [(tip, 0.0), (0.0, tip)])
        .filter_map(|(p, q)| {
            let mut e = 0.0;
            while e < LONGEST_SPIKE
                && let (Some(a), Some(b)) =
                    (run.place(s - p - e - step), run.place(s + q + e + step))
                && (a.at - b.at).norm() < SPIKE * stepover
                && angle(&a.heading, &b.heading) > BACK
            {
                e += step;
            }
            (e > 2.0 * step).then_some((p + e, q + e))
        })
        .max_by(|a, b| a.0.min(a.1).total_cmp(&b.0.min(b.1)))
}

/// Windows about a corner, the best liked first: two places with what is left out between them within what may be.
pub(super) fn windows(
    run: &Run,
    c: &Corner,
    most: f64,
    how: &EaseOptions,
) -> Vec<(f64, Place, Place)> {
    let (s, cut) = (run.along[c.point], run.cut[c.point]);
    let mut bases = vec![(0.0, 0.0)];
    bases.splice(0..0, spike(run, s, how.stepover));
    let own = |heading: &Vector| Place {
        at: run.points[c.point],
        heading: *heading,
        after: c.point,
        from: run.points[c.point],
        to: run.points[(c.point + 1).min(run.points.len() - 1)],
        along: s,
        cut,
    };
    // A place and how it is liked.
    let side = |base: f64, back: bool| -> Vec<(f64, Place)> {
        OFFSETS
            .iter()
            .filter_map(|o| {
                let o = o * how.stepover;
                let off = base + o;
                let place = if off == 0.0 {
                    own(if back { &c.before } else { &c.after })
                } else {
                    run.place(if back { s - off } else { s + off })?
                };
                let cut = (place.cut - cut).abs();
                if cut > most || o - cut > how.link {
                    return None;
                }
                let into_pass = match run.kinds.get(c.point + usize::from(!back)) {
                    Some(MoveKind::Cut) => true,
                    _ => cut > 0.5 * o,
                };
                // Nothing left out of a pass is best, and of a link what is neither tight nor far.
                let cost = match (into_pass, o > 0.0) {
                    (true, false) => 0.0,
                    (true, true) => 0.15 * how.stepover + 2.0 * o,
                    (false, false) => 0.5 * how.stepover,
                    (false, true) => (o - LIKED * how.stepover).abs(),
                };
                Some((cost, place))
            })
            .collect()
    };
    let mut out = Vec::new();
    for (p, q) in bases {
        let (before, after) = (side(p, true), side(q, false));
        // A spike that may be left out is.
        let likes = if p > 0.0 { 0.0 } else { 10.0 };
        for (ca, a) in &before {
            for (cb, b) in &after {
                out.push((ca + cb + likes, *a, *b));
            }
        }
    }
    out.sort_by(|x, y| x.0.total_cmp(&y.0));
    out
}
