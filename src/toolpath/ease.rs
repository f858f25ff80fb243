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
use super::chain::Chain;
use super::moves::{Move, MoveKind, Toolpath};
use super::pass::{Pass, PassKind};
use super::sharp::SHORTEST;
use super::turn::{Pose, Slant, turn};
use crate::geom::{Point, Point2, Vector};
use crate::reach::{DropCutter, Hint};
use rayon::prelude::*;

/// What may be done to a sharp turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EaseOptions<'a> {
    /// The longest stretch of a pass that may be left out on either side of it, mm.
    pub pass: f64,
    /// The same where the ball touches the part in more than one place, mm: short of a crease it leaves more.
    pub crease: f64,
    /// How much of a climb up or down a wall counts as such a stretch: no cusp hangs on it, but its ends are at one.
    pub climb: f64,
    /// The same of a link, mm.
    pub link: f64,
    /// Radii of ways over it, off the surface, in stepovers; none for bends beside it only.
    pub over: &'static [f64],
    /// How deep a chord may cut, along the normal, mm.
    pub gouge: f64,
    /// The last decimal of the program, mm; zero for any place.
    pub decimal: f64,
    /// Flat stepover of the job, mm: the measure of bends.
    pub stepover: f64,
    /// Saddles in plan: near them bends turn even less from chord to chord.
    pub saddles: &'a [Point2],
    /// Turns beyond this are eased there, rad.
    pub near_saddle: f64,
}

/// How much the way may turn at a place, rad.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Turns beyond this are eased: a little under what counts as sharp, which is judged again behind the program's decimals.
    eased: f64,
    /// A bend turns no more than this from one chord to the next.
    most: f64,
    /// Turn of each piece of a bend.
    piece: f64,
}

/// Sharp near saddles, rad, and anywhere.
pub const GENTLE: f64 = 0.25;
/// Anywhere.
pub const SHARP: f64 = 0.47;
const ANYWHERE: Limits = Limits {
    eased: SHARP,
    most: 0.40,
    piece: 0.2,
};
const NEAR_SADDLE: Limits = Limits {
    eased: GENTLE,
    most: 0.235,
    piece: 0.12,
};

impl EaseOptions<'_> {
    fn limits(&self, at: &Point) -> Limits {
        let near = |s: &Point2| (at.xy() - s).norm() <= NEAR * self.stepover;
        if self.saddles.iter().any(near) {
            Limits {
                eased: self.near_saddle,
                ..NEAR_SADDLE
            }
        } else {
            ANYWHERE
        }
    }
}

/// Good radii of loops off the surface, in stepovers.
pub const OVER: &[f64] = &[0.35, 0.6, 1.0, 1.7];
/// What is near a saddle, in stepovers.
const NEAR: f64 = 3.0;
/// Pieces of a bend are no longer, mm.
const PIECE: f64 = 0.1;
/// Chords are proven at places this far apart, mm.
const PROBE: f64 = 0.025;
/// What comes this near to the ball is touched, mm.
const TOUCH: f64 = 0.006;
/// How far a bend is pushed out of the part at most, mm.
const PUSH: f64 = 0.25;
/// How far from the corner a bend may begin and end, in stepovers.
const OFFSETS: [f64; 14] = [
    0.0, 0.04, 0.07, 0.15, 0.22, 0.3, 0.45, 0.65, 1.0, 1.5, 2.2, 3.2, 4.6, 6.5,
];
/// The offset that is liked best on links, in stepovers.
const LIKED: f64 = 0.45;
/// Ways that go back on themselves by more than this may be spikes, rad.
const BACK: f64 = 2.6;
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
struct Run {
    points: Vec<Point>,
    /// Of the move that ends at the point; that of the first point means nothing.
    kinds: Vec<MoveKind>,
    /// Where each point came from.
    origin: Vec<usize>,
    /// Way to each point, mm.
    along: Vec<f64>,
    /// The part of it that is cut, climbs counted as far as they count, mm.
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
    limits: Limits,
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl Run {
    fn measure(&mut self, climb: f64) {
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
    fn corner(&self, cutter: &DropCutter, from: usize, how: &EaseOptions) -> Option<Corner> {
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
    fn splice(&mut self, a: &Place, b: &Place, bend: &[Point], kind: MoveKind, climb: f64) -> usize {
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

/// What stands in the way of a bend, and how it is proven.
struct Proof<'a> {
    cutter: &'a DropCutter,
    how: &'a EaseOptions<'a>,
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
    fn proven(
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
            if k > 0 && k + 1 < n && !self.clear(q) {
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
        bend.windows(2)
            .all(|w| self.chord(&w[0], &w[1]))
            .then_some(bend)
    }
}

fn smooth(before: &Vector, bend: &[Point], after: &Vector, most: f64) -> bool {
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
fn cubic(from: &Point, u: &Vector, to: &Point, v: &Vector, piece: f64, out: &mut Vec<Point>) {
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
fn beside(a: &Place, b: &Place, piece: f64) -> Vec<Point> {
    let mut out = vec![a.at];
    cubic(&a.at, &a.heading, &b.at, &b.heading, piece, &mut out);
    out
}

/// Up, back over, and down.
fn over(a: &Place, b: &Place, radius: f64, piece: f64) -> Option<Vec<Point>> {
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

/// How far the way goes back on itself from a place on (mm before it, behind it): on its own line, or the width of a spike's tip beside.
fn spike(run: &Run, s: f64, stepover: f64) -> Option<(f64, f64)> {
    let step = 0.07 * stepover;
    TIPS.iter()
        .map(|tip| tip * stepover)
        .flat_map(|tip| [(tip, 0.0), (0.0, tip)])
        .filter_map(|(p, q)| {
            let mut e = 0.0;
            while e < LONGEST_SPIKE
                && let (Some(a), Some(b)) = (run.place(s - p - e - step), run.place(s + q + e + step))
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
fn windows(run: &Run, c: &Corner, most: f64, how: &EaseOptions) -> Vec<(f64, Place, Place)> {
    let (s, cut) = (run.along[c.point], run.cut[c.point]);
    let mut bases = vec![(0.0, 0.0)];
    bases.splice(0..0, spike(run, s, how.stepover));
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

/// Most windows that are tried with each kind of way over.
const TRIES: usize = 40;

/// Goes round one corner, leaving out at most so much of a pass; where to look on.
fn mend(proof: &mut Proof, run: &mut Run, c: &Corner, left_out: f64) -> Option<usize> {
    let how = proof.how;
    let windows = windows(run, c, left_out, how);
    let Limits { most, piece, .. } = c.limits;
    let kind_of = |run: &Run, a: &Place, b: &Place| match run.kinds_between(a, b) {
        (MoveKind::Cut, MoveKind::Cut) => MoveKind::Cut,
        // Links are what leads from one to the other, also out of a plunge.
        _ => MoveKind::Link,
    };
    for (_, a, b) in &windows {
        if b.along - a.along < 0.03 * how.stepover || angle(&a.heading, &b.heading) > BACK {
            continue;
        }
        if let Some(bend) = proof.proven(a, b, beside(a, b, piece), most) {
            let kind = kind_of(run, a, b);
            if std::env::var("MM_EASE").is_ok() {
                eprintln!("beside at {:.3} {:.3} {:.3} from {:.3} {:.3} {:.3} to {:.3} {:.3} {:.3} cut {:.3} {:.3} kind {:?} pass {} climb {}", run.points[c.point].x, run.points[c.point].y, run.points[c.point].z, a.at.x,a.at.y,a.at.z,b.at.x,b.at.y,b.at.z, a.cut-run.cut[c.point], b.cut-run.cut[c.point], kind, how.pass, how.climb);
            }
            return Some(run.splice(a, b, &bend, kind, how.climb));
        }
    }
    for radius in how.over {
        for (_, a, b) in windows.iter().take(TRIES) {
            let way = over(a, b, radius * how.stepover, piece);
            if let Some(bend) = way.and_then(|w| proof.proven(a, b, w, most)) {
                return Some(run.splice(a, b, &bend, MoveKind::Link, how.climb));
            }
        }
    }
    for radius in how.over {
        for (_, a, b) in windows.iter().take(TRIES / 4) {
            let loops = round(proof.cutter, a, b, radius * how.stepover);
            if let Some(bend) = loops.and_then(|w| proof.proven(a, b, w, most)) {
                return Some(run.splice(a, b, &bend, MoveKind::Link, how.climb));
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

/// What came of the corners of a run.
#[derive(Clone, Copy, Debug, Default)]
struct Eased {
    mended: usize,
    left: usize,
}

/// Eases a run.
fn ease(cutter: &DropCutter, run: &mut Run, how: &EaseOptions) -> Eased {
    let mut proof = Proof {
        cutter,
        how,
        hint: Hint::default(),
    };
    if let Ok(m) = std::env::var("MM_SKIP") {
        let phase = if how.over.is_empty() && how.climb == 0.0 { "p" } else if how.over.is_empty() { "f" } else if how.climb == 0.0 { "c" } else { "l" };
        if m.contains(phase) { return Eased::default(); }
    }
    let (mut from, mut out) = (0, Eased::default());
    run.measure(how.climb);
    // Every corner is looked at a few times at most, as its neighbours are mended.
    let mut most = 4 * run.points.len();
    while most > 0
        && let Some(c) = run.corner(cutter, from, how)
    {
        most -= 1;
        let mut ways = vec![(c.limits, how.pass)];
        if how.crease < how.pass && cutter.touched(&run.points[c.point], TOUCH).len() > 1 {
            ways.insert(0, (c.limits, how.crease));
        }
        // Rather less gentle than sharp.
        if angle(&c.before, &c.after) > SHARP && c.limits.most < ANYWHERE.most {
            ways.push((ANYWHERE, how.pass));
        }
        let mended = ways.into_iter().find_map(|(limits, left_out)| {
            mend(&mut proof, run, &Corner { limits, ..c }, left_out)
        });
        match mended {
            Some(on) => {
                out.mended += 1;
                from = on;
            }
            None => {
                out.left += 1;
                from = c.point;
            }
        }
    }
    out
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

/// Eases the corners of chains, those of their links among them.
pub fn ease_chains(cutter: &DropCutter, chains: &mut [Chain], how: &EaseOptions) {
    chains.par_iter_mut().for_each(|chain| {
        if chain.iter().any(|p| p.closed || p.points.len() < 2) {
            return;
        }
        let mut run = Run::default();
        for (k, p) in chain.iter().enumerate() {
            let kind = match p.kind {
                PassKind::Turn => MoveKind::Link,
                _ => MoveKind::Cut,
            };
            // A pass begins where the one before it ends.
            let points = &p.points[usize::from(k > 0)..];
            run.points.extend(points);
            run.kinds.extend(points.iter().map(|_| kind));
            run.origin.extend(points.iter().map(|_| k));
        }
        let before = run.points.len();
        if ease(cutter, &mut run, how).mended == 0 || before < 2 {
            return;
        }
        let mut out: Chain = Vec::new();
        for (k, w) in run.points.windows(2).enumerate() {
            let from = &chain[run.origin[k + 1].min(chain.len() - 1)];
            let kind = match run.kinds[k + 1] {
                MoveKind::Link => PassKind::Turn,
                // A bend of a pass, or what a link was to a pass behind it.
                _ if from.kind == PassKind::Turn => PassKind::Level,
                _ => from.kind,
            };
            match out.last_mut() {
                Some(last) if last.kind == kind && last.feature == from.feature => {
                    last.points.push(w[1]);
                }
                _ => out.push(Pass {
                    kind,
                    feature: from.feature,
                    points: w.to_vec(),
                    closed: false,
                }),
            }
        }
        *chain = out;
    });
}

/// Eases the corners of a linked path.
pub fn ease_path(cutter: &DropCutter, path: &mut Toolpath, how: &EaseOptions) {
    let up = Vector::new(0.0, 0.0, cutter.radius());
    let moves = &path.moves;
    let surface = |m: &Move| matches!(m.kind, MoveKind::Cut | MoveKind::Link) && m.turn.is_none();
    // Stretches along the surface, with the plunge that leads onto one.
    let mut stretches: Vec<std::ops::Range<usize>> = Vec::new();
    let mut k = 1;
    while k < moves.len() {
        let first = k;
        if moves[k].kind == MoveKind::Plunge {
            k += 1;
        }
        while k < moves.len() && surface(&moves[k]) {
            k += 1;
        }
        if k > first + 1 {
            stretches.push(first..k);
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
