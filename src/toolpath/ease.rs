//! Ease: where a path turns sharply and the part does not ask for it, it goes round instead.
//!
//! ```text
//!      |            |                     .--.
//!      |    ->     /         ====>  ->   |    '      a bend between two places beside the corner, a loop off the surface where the
//!  ----'      ---'           <====  =====-----'      way goes back on itself, and a spike (out and back on one line) not gone at all
//! ```
//!
//! The bends are cubics, tangent to the path at both ends, pushed out of the part where they enter it, and proven like everything else:
//! the ball enters the part nowhere along their chords. Of a pass no more is left out than a cusp can bear; links are free to go.
//!
//! Crosses the border: runs of the ball's centre (work coordinates, mm) or moves of the tool tip in, the same out.

use super::bridge::{End, bridge};
use super::moves::{Move, MoveKind, Toolpath};
use super::pass::Pass;
use super::sharp::SHORTEST;
use super::turn::{Pose, Slant, turn};
use crate::geom::{Point, Vector};
use crate::reach::{DropCutter, Hint};
use rayon::prelude::*;

/// What may be done to a sharp turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EaseOptions {
    /// The longest stretch of a pass that may be left out on either side of it, mm.
    pub pass: f64,
    /// The same of a link, mm.
    pub link: f64,
    /// Radii of ways over it, off the surface, mm; none for bends beside it only.
    pub over: &'static [f64],
    /// How deep a chord may cut, along the normal, mm.
    pub gouge: f64,
    /// The last decimal of the program, mm; zero for any place.
    pub decimal: f64,
}

/// Radii of loops off the surface.
pub const OVER: &[f64] = &[0.25, 0.4, 0.7, 1.2];
/// Turns beyond this are eased, rad: a little under what counts as sharp, which is judged again behind the program's decimals.
const EASED: f64 = 0.47;
/// A bend turns no more than this from one chord to the next, rad.
const MOST: f64 = 0.40;
/// Pieces of a bend: so much turn each, rad, and so long at most, mm.
const PIECE: (f64, f64) = (0.2, 0.1);
/// Chords are proven at places this far apart, mm.
const PROBE: f64 = 0.025;
/// How far a bend is pushed out of the part at most, mm.
const PUSH: f64 = 0.25;
/// How far from the corner a bend may begin and end, mm.
const OFFSETS: [f64; 13] = [
    0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0, 1.5, 2.2, 3.2, 4.5,
];
/// The offset that is liked best on links, mm.
const LIKED: f64 = 0.3;
/// Ways that go back on themselves by more than this may be spikes, rad.
const BACK: f64 = 2.6;
/// The two sides of a spike are no further apart, mm.
const SPIKE: f64 = 0.06;
/// No spike is longer, mm.
const LONGEST_SPIKE: f64 = 20.0;
/// Moves steeper than this (rise over length) climb a wall: no cusp hangs on them.
const CLIMB: f64 = 0.98;

/// A way along the surface: places of the ball's centre and what each move between them is.
#[derive(Clone, Debug, Default)]
struct Run {
    points: Vec<Point>,
    /// Of the move that ends at the point; that of the first point means nothing.
    kinds: Vec<MoveKind>,
    /// Where each point came from.
    origin: Vec<usize>,
    /// Way to each point, mm.
    along: Vec<f64>,
    /// The part of it that is cut on the level, mm.
    cut: Vec<f64>,
}

/// A place on a run.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Point,
    heading: Vector,
    /// The point behind which it lies (or at which).
    after: usize,
    /// Way and cut way up to it, mm.
    along: f64,
    cut: f64,
}

/// A sharp turn of a run.
#[derive(Clone, Copy, Debug)]
struct Corner {
    point: usize,
    before: Vector,
    after: Vector,
    turn: f64,
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl Run {
    fn measure(&mut self) {
        self.along.clear();
        self.cut.clear();
        let (mut s, mut c) = (0.0, 0.0);
        for k in 0..self.points.len() {
            if k > 0 {
                let d = self.points[k] - self.points[k - 1];
                let l = d.norm();
                s += l;
                if self.kinds[k] == MoveKind::Cut && d.z.abs() < CLIMB * l {
                    c += l;
                }
            }
            self.along.push(s);
            self.cut.push(c);
        }
    }

    /// The next turn over the limit that is not the part's, of those behind the point `from`.
    fn corner(&self, cutter: &DropCutter, from: usize) -> Option<Corner> {
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
                if turn > EASED && cutter.own_turn(&start, &before, &after) > EASED {
                    return Some(Corner {
                        point: at,
                        before,
                        after,
                        turn,
                    });
                }
            }
            (at, start, way) = (k, *p, Some(after));
        }
        None
    }

    /// The place this far along, heading onwards.
    fn place(&self, s: f64) -> Option<Place> {
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
            along: s,
            cut: self.cut[k] + (self.cut[k + 1] - self.cut[k]) * t,
        })
    }

    /// The first and last kinds of moves between two places.
    fn kinds_between(&self, a: &Place, b: &Place) -> (MoveKind, MoveKind) {
        let last = self.points.len() - 1;
        (
            self.kinds[(a.after + 1).min(last)],
            self.kinds[(b.after + 1).min(last)],
        )
    }

    /// Puts a bend in place of what is between two places. Returns the point before it.
    fn splice(&mut self, a: &Place, b: &Place, bend: &[Point], kind: MoveKind) -> usize {
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
        self.measure();
        from.saturating_sub(1)
    }
}

/// What stands in the way of a bend, and how it is proven.
struct Proof<'a> {
    cutter: &'a DropCutter,
    how: &'a EaseOptions,
    hint: Hint,
}

impl Proof<'_> {
    fn clear(&mut self, q: &Point) -> bool {
        let Some(c) = self.cutter.drop_near(q.x, q.y, &mut self.hint) else {
            return true;
        };
        let below = c.center.z - q.z;
        let deep = below * c.normal_z();
        if below <= 0.0 || deep <= self.how.gouge {
            return true;
        }
        if c.normal_z() > 0.3 && deep > PUSH {
            return false;
        }
        // Beside a wall the ball would have to rise far for a hair: what counts is how deep it is in.
        self.cutter.depth(q) <= self.how.gouge
    }

    fn chord(&mut self, a: &Point, b: &Point) -> bool {
        let n = ((b - a).norm() / PROBE).ceil().max(1.0) as usize;
        (0..=n).all(|k| self.clear(&(a + (b - a) * (k as f64 / n as f64))))
    }

    fn snapped(&self, p: Point) -> Point {
        let d = self.how.decimal;
        if d <= 0.0 {
            return p;
        }
        let r = self.cutter.radius();
        let on = |v: f64| (v / d).round() * d;
        Point::new(on(p.x), on(p.y), ((p.z - r) / d - 0.1).ceil() * d + r)
    }

    /// The bend as it may be gone: pushed out of the part, on the program's decimals, nowhere sharp.
    fn proven(&mut self, a: &Place, b: &Place, mut bend: Vec<Point>) -> Option<Vec<Point>> {
        let n = bend.len();
        if n < 2 || !smooth(&a.heading, &bend, &b.heading) {
            return None;
        }
        for (k, q) in bend.iter_mut().enumerate() {
            if k > 0 && k + 1 < n && !self.clear(q) {
                *q = self.cutter.pushed_out(q, PUSH)?;
            }
        }
        for q in bend.iter_mut() {
            *q = self.snapped(*q);
        }
        bend.dedup_by(|q, p| (*q - *p).norm() < 1e-6);
        if bend.len() < 2 || !smooth(&a.heading, &bend, &b.heading) {
            return None;
        }
        bend.windows(2)
            .all(|w| self.chord(&w[0], &w[1]))
            .then_some(bend)
    }
}

fn smooth(before: &Vector, bend: &[Point], after: &Vector) -> bool {
    let mut way = *before;
    let mut at = bend[0];
    for q in &bend[1..] {
        let d = q - at;
        let l = d.norm();
        if l < SHORTEST {
            continue;
        }
        let d = d / l;
        if angle(&way, &d) > MOST {
            return false;
        }
        (way, at) = (d, *q);
    }
    angle(&way, after) <= MOST
}

/// A cubic from one place and heading to another: an arc where they lie so. Appended without its first point.
fn cubic(from: &Point, u: &Vector, to: &Point, v: &Vector, out: &mut Vec<Point>) {
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
    let n = (all / PIECE.0)
        .max(1.2 * chord / PIECE.1)
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
fn beside(a: &Place, b: &Place) -> Vec<Point> {
    let mut out = vec![a.at];
    cubic(&a.at, &a.heading, &b.at, &b.heading, &mut out);
    out
}

/// Up, back over, and down.
fn over(a: &Place, b: &Place, radius: f64) -> Option<Vec<Point>> {
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
    cubic(&a.at, &a.heading, &top, &way, &mut out);
    cubic(&top, &way, &b.at, &b.heading, &mut out);
    Some(out)
}

/// Windows about a corner, the best liked first: two places with what is left out between them within what may be.
fn windows(run: &Run, c: &Corner, how: &EaseOptions) -> Vec<(f64, Place, Place)> {
    let (s, cut) = (run.along[c.point], run.cut[c.point]);
    let mut bases = vec![(0.0, 0.0)];
    if c.turn > BACK {
        let mut e = 0.0;
        while e < LONGEST_SPIKE
            && let (Some(a), Some(b)) = (run.place(s - e - 0.05), run.place(s + e + 0.05))
            && (a.at - b.at).norm() < SPIKE
        {
            e += 0.05;
        }
        if e > 0.1 {
            bases.insert(0, (e, e));
        }
    }
    let own = |heading: &Vector| Place {
        at: run.points[c.point],
        heading: *heading,
        after: c.point,
        along: s,
        cut,
    };
    // A place and how it is liked.
    let side = |base: f64, back: bool| -> Vec<(f64, Place)> {
        OFFSETS
            .iter()
            .filter_map(|o| {
                let off = base + o;
                let place = if off == 0.0 {
                    own(if back { &c.before } else { &c.after })
                } else {
                    run.place(if back { s - off } else { s + off })?
                };
                let cut = (place.cut - cut).abs();
                if cut > how.pass || o - cut > how.link {
                    return None;
                }
                let cost = if cut > 0.5 * o {
                    2.0 * o
                } else if *o == 0.0 {
                    0.35
                } else {
                    (o - LIKED).abs()
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

/// Most windows that are tried with each kind of way over.
const TRIES: usize = 40;

/// Goes round one corner; where to look on.
fn mend(proof: &mut Proof, run: &mut Run, c: &Corner) -> Option<usize> {
    let how = proof.how;
    let windows = windows(run, c, how);
    let kind_of = |run: &Run, a: &Place, b: &Place| match run.kinds_between(a, b) {
        (MoveKind::Cut, MoveKind::Cut) => MoveKind::Cut,
        _ => MoveKind::Link,
    };
    for (_, a, b) in &windows {
        if b.along - a.along < 0.02 || angle(&a.heading, &b.heading) > BACK {
            continue;
        }
        if let Some(bend) = proof.proven(a, b, beside(a, b)) {
            let kind = kind_of(run, a, b);
            return Some(run.splice(a, b, &bend, kind));
        }
    }
    for radius in how.over {
        for (_, a, b) in windows.iter().take(TRIES) {
            let way = over(a, b, *radius);
            if let Some(bend) = way.and_then(|w| proof.proven(a, b, w)) {
                return Some(run.splice(a, b, &bend, MoveKind::Link));
            }
        }
    }
    for radius in how.over {
        for (_, a, b) in windows.iter().take(TRIES / 4) {
            let loops = round(proof.cutter, a, b, *radius);
            if let Some(bend) = loops.and_then(|w| proof.proven(a, b, w)) {
                return Some(run.splice(a, b, &bend, MoveKind::Link));
            }
        }
    }
    None
}

/// Round in plan, over what is in the way.
fn round(cutter: &DropCutter, a: &Place, b: &Place, radius: f64) -> Option<Vec<Point>> {
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

/// Eases a run; how many corners are left.
fn ease(cutter: &DropCutter, run: &mut Run, how: &EaseOptions) -> usize {
    let mut proof = Proof {
        cutter,
        how,
        hint: Hint::default(),
    };
    let (mut from, mut left) = (0, 0);
    run.measure();
    // Every corner is looked at a few times at most, as its neighbours are mended.
    let mut most = 4 * run.points.len();
    while most > 0
        && let Some(c) = run.corner(cutter, from)
    {
        most -= 1;
        match mend(&mut proof, run, &c) {
            Some(on) => from = on,
            None => {
                left += 1;
                from = c.point;
            }
        }
    }
    left
}

/// Eases the corners of passes before they are joined: what is left out of them is found by the fill.
pub fn ease_passes(cutter: &DropCutter, passes: &mut [Pass], how: &EaseOptions) {
    passes.par_iter_mut().for_each(|p| {
        let points = p.run();
        let n = points.len();
        let mut run = Run {
            points,
            kinds: vec![MoveKind::Cut; n],
            origin: vec![0; n],
            ..Run::default()
        };
        ease(cutter, &mut run, how);
        if p.closed && run.points.len() > 2 {
            run.points.pop();
        }
        p.points = run.points;
    });
}

/// Eases the corners of a linked path.
pub fn ease_path(cutter: &DropCutter, path: &mut Toolpath, how: &EaseOptions) {
    let up = Vector::new(0.0, 0.0, cutter.radius());
    let moves = &path.moves;
    let surface = |m: &Move| matches!(m.kind, MoveKind::Cut | MoveKind::Link) && m.turn.is_none();
    // Stretches along the surface: without the way up at the end of one, which is in the air.
    let mut stretches: Vec<std::ops::Range<usize>> = Vec::new();
    let mut k = 1;
    while k < moves.len() {
        let first = k;
        while k < moves.len() && surface(&moves[k]) {
            k += 1;
        }
        let mut end = k;
        if end > first + 1
            && moves.get(end).is_some_and(|m| m.kind == MoveKind::Retract)
            && (moves[end - 1].to.xy() - moves[end - 2].to.xy()).norm() < 1e-6
        {
            end -= 1;
        }
        if end > first + 1 {
            stretches.push(first..end);
        }
        k = k.max(first + 1);
    }
    let eased: Vec<Run> = stretches
        .par_iter()
        .map(|s| {
            let own = s.start - 1..s.end;
            let mut run = Run {
                points: moves[own.clone()].iter().map(|m| m.to + up).collect(),
                kinds: moves[own.clone()].iter().map(|m| m.kind).collect(),
                origin: own.collect(),
                ..Run::default()
            };
            ease(cutter, &mut run, how);
            run
        })
        .collect();
    let mut out: Vec<Move> = Vec::with_capacity(moves.len());
    let mut origin: Vec<usize> = Vec::with_capacity(moves.len());
    let mut next = 0;
    for (s, run) in stretches.iter().zip(eased) {
        out.extend(&moves[next..s.start]);
        origin.extend(next..s.start);
        for k in 1..run.points.len() {
            out.push(Move::straight(run.kinds[k], run.points[k] - up));
            origin.push(run.origin[k]);
        }
        next = s.end;
    }
    out.extend(&moves[next..]);
    origin.extend(next..moves.len());
    for section in &mut path.sections {
        section.first_move = origin
            .iter()
            .position(|o| *o >= section.first_move)
            .unwrap_or(out.len());
    }
    path.moves = out;
}
