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

mod bend;
mod run;

use self::bend::{Proof, beside, over, round};
pub(super) use self::bend::{cubic, smooth};
use self::run::{Corner, Place, Run, angle, windows};
use super::link::chain::Chain;
use super::moves::{Move, MoveKind, Toolpath};
use super::pass::{Pass, PassKind};
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
/// What comes this near to the ball is touched, mm.
const TOUCH: f64 = 0.006;
/// Ways that go back on themselves by more than this may be spikes, rad.
pub(super) const BACK: f64 = 2.6;

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use crate::toolpath::sharp::sharp_turns;

    const R: f64 = 3.0;

    /// A floor at height 0 that is 40 mm square, with a wall `high` mm high from x = 10 on.
    fn walled(high: f64) -> DropCutter {
        let quad = |a: Point, b: Point, c: Point, d: Point| [[a, b, c], [a, c, d]];
        let p = Point::new;
        let mut triangles = Vec::new();
        triangles.extend(quad(
            p(-20.0, -20.0, 0.0),
            p(10.0, -20.0, 0.0),
            p(10.0, 20.0, 0.0),
            p(-20.0, 20.0, 0.0),
        ));
        triangles.extend(quad(
            p(10.0, -20.0, 0.0),
            p(10.0, -20.0, high),
            p(10.0, 20.0, high),
            p(10.0, 20.0, 0.0),
        ));
        triangles.extend(quad(
            p(10.0, -20.0, high),
            p(20.0, -20.0, high),
            p(20.0, 20.0, high),
            p(10.0, 20.0, high),
        ));
        DropCutter::new(&Mesh { triangles }, R)
    }

    const HOW: EaseOptions = EaseOptions {
        pass: 0.1,
        crease: 0.03,
        climb: 0.5,
        link: 5.0,
        over: OVER,
        gouge: 0.0015,
        decimal: 0.001,
        stepover: 0.7,
        saddles: &[],
        near_saddle: GENTLE,
    };

    fn path(moves: &[(MoveKind, [f64; 3])]) -> Toolpath {
        Toolpath {
            moves: moves
                .iter()
                .map(|(kind, [x, y, z])| Move::straight(*kind, Point::new(*x, *y, *z)))
                .collect(),
            ..Toolpath::default()
        }
    }

    /// Eased: nothing sharp is left, the ball is nowhere in the part, and both ends are where they were.
    fn eased(cutter: &DropCutter, before: &Toolpath) -> Toolpath {
        let mut after = before.clone();
        ease_path(cutter, &mut after, &HOW);
        assert_eq!(sharp_turns(cutter, &after).sharp, 0, "{:?}", after.moves);
        assert_eq!(before.moves.first(), after.moves.first());
        assert_eq!(before.moves.last(), after.moves.last());
        let up = Vector::new(0.0, 0.0, R);
        for w in after.moves.windows(2) {
            for k in 0..=20 {
                let q = w[0].to + (w[1].to - w[0].to) * (f64::from(k) / 20.0) + up;
                assert!(cutter.is_clear(&q, 0.002, &mut Hint::default()), "{q}");
            }
        }
        after
    }

    use MoveKind::{Cut, Link, Rapid};

    #[test]
    fn a_corner_of_links_becomes_a_bend_and_a_pass_is_hardly_cut_short() {
        let cutter = walled(6.0);
        let links = path(&[
            (Rapid, [-9.0, 0.0, 0.0]),
            (Link, [-5.0, 0.0, 0.0]),
            (Link, [-5.0, 4.0, 0.0]),
        ]);
        assert_eq!(sharp_turns(&cutter, &links).sharp, 1);
        let bent = eased(&cutter, &links);
        assert!(bent.moves.len() > 6);
        let mut passes = links.clone();
        passes.moves.iter_mut().skip(1).for_each(|m| m.kind = Cut);
        let corner = Point::new(-5.0, 0.0, 0.0);
        let near = eased(&cutter, &passes)
            .moves
            .iter()
            .map(|m| (m.to - corner).norm())
            .fold(f64::INFINITY, f64::min);
        // An arc tangent 0.1 mm from a right angle passes it at 0.1 (sqrt 2 - 1).
        assert!(near < 0.1 * 0.42 + 0.002, "{near}");
    }

    /// A pass that ends before a wall, and a link back the way it came: over it goes, and the pass is cut to its end or nearly.
    #[test]
    fn back_from_a_wall_goes_over_itself() {
        let cutter = walled(6.0);
        let back = path(&[
            (Rapid, [0.0, 0.0, 0.0]),
            (Cut, [6.5, 0.0, 0.0]),
            (Link, [0.0, 0.0, 0.0]),
            (Link, [-4.0, 0.0, 0.0]),
        ]);
        assert_eq!(sharp_turns(&cutter, &back).largest_deg, 180.0);
        let over = eased(&cutter, &back);
        let reached = over
            .moves
            .iter()
            .filter(|m| m.kind == Cut && m.to.z < 1e-6)
            .map(|m| m.to.x)
            .fold(f64::NEG_INFINITY, f64::max);
        assert!(reached > 6.4 - 1e-9, "{reached}");
    }

    /// Up a wall and down again for nothing: not gone at all.
    #[test]
    fn a_spike_is_left_out() {
        let cutter = walled(6.0);
        let spike = path(&[
            (Rapid, [7.0, -9.0, 0.0]),
            (Link, [7.0, 0.0, 0.0]),
            (Link, [7.0, 0.0, 6.0]),
            (Link, [7.0, 0.03, 0.0]),
            (Link, [7.0, 9.0, 0.0]),
        ]);
        let flat = eased(&cutter, &spike);
        assert!(flat.moves.iter().all(|m| m.to.z < 0.1), "{:?}", flat.moves);
    }

    /// Straight into the wall's foot and straight up the wall is the part's own corner: not touched.
    #[test]
    fn the_parts_corners_stay() {
        let cutter = walled(6.0);
        let up = path(&[
            (Rapid, [0.0, 0.0, 0.0]),
            (Cut, [7.0, 0.0, 0.0]),
            (Cut, [7.0, 0.0, 3.0]),
        ]);
        let mut after = up.clone();
        ease_path(&cutter, &mut after, &HOW);
        assert_eq!(after.moves, up.moves);
        assert_eq!(sharp_turns(&cutter, &up).part_corners, 1);
    }

    #[test]
    fn sections_begin_with_the_same_moves() {
        let cutter = walled(6.0);
        let mut p = path(&[
            (Rapid, [-9.0, 0.0, 0.0]),
            (Link, [-5.0, 0.0, 0.0]),
            (Link, [-5.0, 4.0, 0.0]),
            (Rapid, [0.0, 0.0, 5.0]),
            (Link, [2.0, 0.0, 5.0]),
        ]);
        let begins = |first_move: usize| crate::toolpath::Section {
            name: String::new(),
            first_move,
        };
        p.sections = vec![begins(0), begins(3)];
        let third = p.moves[3];
        ease_path(&cutter, &mut p, &HOW);
        assert_eq!(p.sections[0].first_move, 0);
        assert_eq!(p.moves[p.sections[1].first_move], third);
    }

    /// Chains stay chains: each pass begins where the one before it ends.
    #[test]
    fn eased_chains_hang_together() {
        let cutter = walled(6.0);
        let pass = |kind: PassKind, points: &[[f64; 2]]| Pass {
            kind,
            feature: Some(0),
            points: points.iter().map(|[x, y]| Point::new(*x, *y, R)).collect(),
            closed: false,
        };
        let mut chains = vec![vec![
            pass(PassKind::Level, &[[-9.0, 0.0], [-5.0, 0.0]]),
            pass(PassKind::Turn, &[[-5.0, 0.0], [-5.0, 3.0]]),
            pass(PassKind::Fill, &[[-5.0, 3.0], [-9.0, 3.0]]),
        ]];
        ease_chains(&cutter, &mut chains, &HOW);
        let chain = &chains[0];
        let kinds: Vec<PassKind> = chain.iter().map(|p| p.kind).collect();
        assert_eq!(kinds, [PassKind::Level, PassKind::Turn, PassKind::Fill]);
        assert!(chain[1].points.len() > 6);
        for w in chain.windows(2) {
            assert_eq!(w[0].points.last(), w[1].points.first());
        }
    }
}
