//! The proof: how deep the ball goes, and how high it stays, anywhere along a path: not only where it was looked at.
//!
//! Between two looks a distance `w` apart nothing worse can hide than this. The clearance of a ball's centre `q` is its distance to
//! the part less the radius `R`: the least of `|q - p| - R` over the points `p` of the part, and along a line each `|q(t) - p|` bends
//! upwards by at most `1 / R`. So
//!
//! ```text
//! clearance - t^2 / (2R) is concave:  between looks it lies above the line through them, less t (w - t) / (2R)    (gouge)
//! clearance <= |q - p1| - R, |q - p2| - R with the contacts p1, p2 of the looks at both ends                      (stock)
//! ```
//!
//! Looks are added where these bounds exceed a budget, and nowhere else. Along an arc of radius `r` the path itself bends: `1/R` becomes
//! `1/R + 1/r`.
//!
//! Crosses the border: centres of the ball in work coordinates, mm, and a part made ready for it in; signed errors out, along the
//! contact normal.

use super::{FitOptions, Rest, rest};
use crate::geom::{Point, Vector};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::curve::Curve;
use crate::toolpath::{MoveKind, Toolpath};
use rayon::prelude::*;

/// The worst errors of some path against the part, proven over its whole length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitReport {
    /// Straight segments and arcs looked at.
    pub segments: usize,
    /// Arcs among them.
    pub arcs: usize,
    /// Their length, mm.
    pub length_mm: f64,
    /// Nowhere does the ball enter the part deeper than this, along the normal, mm: a bound, at most a little over what is there.
    pub gouge_max: f64,
    /// The deepest that was seen, mm.
    pub gouge_seen: f64,
    /// Nowhere on a slope does it stay higher than this above where it would rest, along the normal, mm. Hops over cliffs are left out.
    pub stock_max: f64,
    /// Segments that break the gouge budget.
    pub over_gouge: usize,
    /// Segments that break the stock budget.
    pub over_stock: usize,
    /// Looks it took.
    pub looks: usize,
}

impl FitReport {
    /// Both together.
    pub fn and(mut self, o: &FitReport) -> FitReport {
        self.segments += o.segments;
        self.arcs += o.arcs;
        self.length_mm += o.length_mm;
        self.gouge_max = self.gouge_max.max(o.gouge_max);
        self.gouge_seen = self.gouge_seen.max(o.gouge_seen);
        self.stock_max = self.stock_max.max(o.stock_max);
        self.over_gouge += o.over_gouge;
        self.over_stock += o.over_stock;
        self.looks += o.looks;
        self
    }
}

/// Looks are not taken closer together than this, mm. Over a crease of 2 degrees, where the ball changes its contact, it hides 0.02 um.
const FINEST: f64 = 0.002;
/// A budget is kept when it is exceeded by no more than this, mm: the last bit of a bound is not worth a segment.
const GRACE: f64 = 2e-5;

/// One look at a place on a path.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Distance along the path, mm.
    t: f64,
    /// Place of the ball's centre.
    at: Point,
    /// At most this deep, mm; zero when free.
    depth: f64,
    /// About this deep, mm.
    seen: f64,
    /// This high at most, mm; zero when it touches.
    stock: f64,
    /// Where it would touch from above; `None` over empty air.
    contact: Option<Point>,
    /// Where it would rest.
    resting: Option<Rest>,
}

/// What is known of one piece of path.
#[derive(Clone, Copy, Debug)]
pub struct Proven {
    /// At most this deep, mm.
    pub gouge: f64,
    /// The deepest look, mm.
    pub gouge_seen: f64,
    /// At most this high, mm.
    pub stock: f64,
    /// Looks taken.
    pub looks: usize,
    /// The worst look that breaks a budget: its place and where the ball rests there.
    pub worst: Option<(Point, Rest)>,
    /// Budgets are kept.
    pub gouge_kept: bool,
    /// Budgets are kept.
    pub stock_kept: bool,
}

fn look(cutter: &DropCutter, at: Point, t: f64, budget: f64, hint: &mut Hint) -> Look {
    let free = Look {
        t,
        at,
        depth: 0.0,
        seen: 0.0,
        stock: 0.0,
        contact: None,
        resting: None,
    };
    let Some(r) = rest(cutter, at.x, at.y, hint) else {
        return free;
    };
    let low = r.center.z - at.z;
    let guess = low * r.normal.z;
    let own = Look {
        contact: Some(r.center - r.normal * cutter.radius()),
        resting: Some(r),
        ..free
    };
    if low <= 0.0 {
        return Look {
            stock: -guess,
            ..own
        };
    }
    // Moving up by `low` frees the ball, so it is no deeper than that; on a slope a shorter way out may be found along the normal.
    let depth = if low <= budget {
        low
    } else {
        cutter.way_out(&at, &r.normal, low, budget, hint)
    };
    Look {
        depth,
        seen: guess.min(depth),
        ..own
    }
}

/// Deepest a ball can be between two looks, where clearance bends by at most `bend`, 1/mm.
fn deepest_between(a: f64, b: f64, w: f64, bend: f64) -> f64 {
    // a + (b - a) t / w + bend t (w - t) / 2 is highest at:
    let t = (0.5 * w + (b - a) / (bend * w).max(1e-300)).clamp(0.0, w);
    a + (b - a) * t / w + 0.5 * bend * t * (w - t)
}

/// Highest a ball can stand between two looks: no higher than over either contact.
fn highest_between(a: &Look, b: &Look, radius: f64) -> f64 {
    let over = |q: &Point, p: &Point| (q - p).norm() - radius;
    let highest = match (a.contact, b.contact) {
        (None, None) => 0.0,
        (Some(p), None) | (None, Some(p)) => over(&a.at, &p).max(over(&b.at, &p)),
        (Some(p), Some(s)) => {
            // |q - p| = |q - s| on a plane; the line from a to b crosses it at u.
            let d = b.at - a.at;
            let ps = s - p;
            let along = d.dot(&ps);
            let mid = nalgebra::center(&p, &s);
            let u = if along.abs() > 1e-300 {
                ((mid - a.at).dot(&ps) / along).clamp(0.0, 1.0)
            } else {
                0.5
            };
            let q = a.at + d * u;
            over(&q, &p).min(over(&q, &s))
        }
    };
    highest.max(a.stock).max(b.stock)
}

/// Proves a piece of path, or finds where it is worst. Stock is judged only `with_stock`. `thorough`: goes on after a broken budget,
/// so that the figures hold for all of it.
pub fn examine(
    cutter: &DropCutter,
    curve: &Curve,
    options: &FitOptions,
    with_stock: bool,
    thorough: bool,
    hint: &mut Hint,
) -> Proven {
    let radius = cutter.radius();
    let length = curve.length();
    let bend = 1.0 / radius + curve.bend();
    let (gouge_budget, stock_budget) = (options.gouge + GRACE, options.stock + GRACE);
    let mut looks = 0;
    let mut take = |t: f64, hint: &mut Hint| {
        looks += 1;
        let at = curve.at(t);
        let mut l = look(cutter, at, t, options.gouge, hint);
        // A controller cuts chords instead of an arc: inwards by up to so much.
        if let (Some(inward), Some(r)) = (curve.slack(&at), l.resting) {
            let out = inward.dot(&r.normal);
            if out < 0.0 {
                l.depth -= out;
            } else {
                l.stock += out;
            }
        }
        l
    };
    let mut proven = Proven {
        gouge: 0.0,
        gouge_seen: 0.0,
        stock: 0.0,
        looks: 0,
        worst: None,
        gouge_kept: true,
        stock_kept: true,
    };
    let mut worst_off = 1.0;
    let first = take(0.0, hint);
    let last = take(length, hint);
    let mut stack = vec![(first, last)];
    for l in [first, last] {
        proven.gouge = proven.gouge.max(l.depth);
        proven.gouge_seen = proven.gouge_seen.max(l.seen);
    }
    while let Some((a, b)) = stack.pop() {
        let w = b.t - a.t;
        let gouge = if w > 0.0 {
            deepest_between(a.depth, b.depth, w, bend)
        } else {
            a.depth.max(b.depth)
        };
        let stock = if with_stock {
            // The chord between two looks along an arc leaves it by a hair.
            highest_between(&a, &b, radius) + 0.125 * curve.bend() * w * w
        } else {
            0.0
        };
        if (gouge > gouge_budget || stock > stock_budget) && w > FINEST {
            let m = take(0.5 * (a.t + b.t), hint);
            proven.gouge_seen = proven.gouge_seen.max(m.seen);
            let off = (m.depth / gouge_budget).max(if with_stock {
                m.stock / stock_budget
            } else {
                0.0
            });
            if off > worst_off
                && let Some(r) = m.resting
            {
                worst_off = off;
                proven.worst = Some((m.at, r));
                if !thorough {
                    // One look beside the worst is enough to split there; the parts are proven on their own.
                    proven.gouge_kept &= m.depth <= gouge_budget;
                    proven.stock_kept &= !with_stock || m.stock <= stock_budget;
                    if off > 1.5 {
                        break;
                    }
                }
            }
            stack.push((m, b));
            stack.push((a, m));
            continue;
        }
        proven.gouge = proven.gouge.max(gouge);
        proven.stock = proven.stock.max(stock);
        // A look within the budget and a bound a hair over it is as good as it gets.
        let kept = (gouge <= gouge_budget + GRACE, stock <= stock_budget + GRACE);
        proven.gouge_kept &= kept.0;
        proven.stock_kept &= kept.1;
        if kept != (true, true) && proven.worst.is_none() {
            // Over a crease between two looks that are within: beside it is the place.
            let inside = |l: &&Look| l.t > 0.0 && l.t < length;
            proven.worst = [a, b]
                .iter()
                .filter(inside)
                .max_by(|l, m| l.stock.total_cmp(&m.stock))
                .and_then(|l| Some((l.at, l.resting?)));
        }
    }
    proven.looks = looks;
    proven
}

/// A vertex of a fitted run before it is placed on the program's last decimal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where, mm.
    pub at: Point,
    /// It stands at the top or the foot of a cliff: its height is meant, not found by dropping.
    pub cliff: bool,
    /// How far above the part it is wanted, along the normal, mm; below where negative.
    pub lift: f64,
}

/// Puts a vertex on the program's last decimal, resting on the part there; so only its height is rounded.
fn place(cutter: &DropCutter, v: &Vertex, decimal: f64, hint: &mut Hint) -> Point {
    // On a wall a lift along the normal is a long way up.
    let lifted = |r: &Rest| r.center.z + v.lift / r.normal.z.max(0.2);
    if decimal <= 0.0 {
        return match (v.cliff, rest(cutter, v.at.x, v.at.y, hint)) {
            (false, Some(r)) => Point::new(v.at.x, v.at.y, lifted(&r)),
            _ => v.at,
        };
    }
    let snap = |x: f64| (x / decimal).round() * decimal;
    let (x, y) = (snap(v.at.x), snap(v.at.y));
    // Heights are whole decimals of the tool tip.
    let r = cutter.radius();
    let height = |z: f64| snap(z - r) + r;
    let above = |z: f64| ((z - r) / decimal - 1e-6).ceil() * decimal + r;
    match rest(cutter, x, y, hint) {
        Some(found) if !v.cliff => Point::new(x, y, height(lifted(&found))),
        _ => Point::new(x, y, above(v.at.z)),
    }
}

/// Ends given from outside are taken if a run's own lie this near, mm.
const SAME_PLACE: f64 = 0.01;

/// Places vertices and splits the segments between them until each keeps its budgets. `ends`: begin and end at these places
/// exactly, where they are the run's own but for a rounding.
pub(super) fn place_and_prove(
    cutter: &DropCutter,
    vertices: &[Vertex],
    ends: Option<&(Point, Point)>,
    options: &FitOptions,
) -> Vec<Point> {
    let mut hint = Hint::default();
    let mut out: Vec<Point> = Vec::with_capacity(vertices.len());
    let mut last: Option<&Vertex> = None;
    for (i, v) in vertices.iter().enumerate() {
        let mut to = place(cutter, v, options.decimal, &mut hint);
        for (at, end) in ends
            .iter()
            .flat_map(|e| [(0, e.0), (vertices.len() - 1, e.1)])
        {
            if at == i && (to - end).norm() < SAME_PLACE {
                to = end;
            }
        }
        match out.last().copied() {
            None => out.push(to),
            Some(from) if from != to => {
                let with_stock = !(v.cliff && last.is_some_and(|l| l.cliff));
                let lift = 0.5 * (v.lift + last.map_or(v.lift, |l| l.lift));
                let mut splitter = Splitter {
                    cutter,
                    options,
                    with_stock,
                    lift,
                    hint: &mut hint,
                    out: &mut out,
                };
                splitter.split(from, to, 0);
            }
            Some(_) => {}
        }
        last = Some(v);
    }
    out
}

struct Splitter<'a> {
    cutter: &'a DropCutter,
    options: &'a FitOptions,
    with_stock: bool,
    /// Of new vertices.
    lift: f64,
    hint: &'a mut Hint,
    out: &'a mut Vec<Point>,
}

impl Splitter<'_> {
    /// Appends what it takes to get from `a` to `b`.
    fn split(&mut self, a: Point, b: Point, depth: usize) {
        let (cutter, options) = (self.cutter, self.options);
        let curve = Curve::line(a, b);
        let shortest = (2.0 * FINEST).max(4.0 * options.decimal);
        if curve.length() > shortest && depth < 10 {
            let p = examine(cutter, &curve, options, self.with_stock, false, self.hint);
            if let Some((at, r)) = p.worst {
                let v = Vertex {
                    at: Point::new(at.x, at.y, r.center.z),
                    cliff: false,
                    lift: self.lift,
                };
                let m = place(cutter, &v, options.decimal, self.hint);
                if m != a && m != b {
                    self.split(a, m, depth + 1);
                    self.split(m, b, depth + 1);
                    return;
                }
            }
        }
        self.out.push(b);
    }
}

/// Proves a run of ball centres as it is. Stock is judged on every segment that is not upright.
pub fn prove_run(cutter: &DropCutter, run: &[Point], options: &FitOptions) -> FitReport {
    let mut hint = Hint::default();
    run.windows(2).fold(FitReport::default(), |sum, w| {
        let curve = Curve::line(w[0], w[1]);
        sum.and(&report_of(cutter, &curve, options, true, &mut hint))
    })
}

fn report_of(
    cutter: &DropCutter,
    curve: &Curve,
    options: &FitOptions,
    with_stock: bool,
    hint: &mut Hint,
) -> FitReport {
    let with_stock = with_stock && !curve.is_upright();
    let p = examine(cutter, curve, options, with_stock, true, hint);
    FitReport {
        segments: 1,
        arcs: usize::from(curve.bend() > 0.0),
        length_mm: curve.length(),
        gouge_max: p.gouge,
        gouge_seen: p.gouge_seen,
        stock_max: p.stock,
        over_gouge: usize::from(!p.gouge_kept),
        over_stock: usize::from(!p.stock_kept),
        looks: p.looks,
    }
}

/// Moves proven by one worker at a time.
const CHUNK: usize = 256;

/// Proves every cutting move and link of a toolpath; stock is judged on cutting moves only. About ten drops a move, on all cores; the
/// result does not depend on them.
pub fn proof(
    cutter: &DropCutter,
    toolpath: &Toolpath,
    chord_tolerance: f64,
    options: &FitOptions,
) -> FitReport {
    let up = Vector::new(0.0, 0.0, cutter.radius());
    let pairs: Vec<usize> = (1..toolpath.moves.len()).collect();
    let sums: Vec<FitReport> = pairs
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut hint = Hint::default();
            let mut sum = FitReport::default();
            for &i in chunk {
                let (from, m) = (&toolpath.moves[i - 1], &toolpath.moves[i]);
                let with_stock = match m.kind {
                    MoveKind::Cut => true,
                    MoveKind::Link => false,
                    MoveKind::Rapid | MoveKind::Plunge | MoveKind::Retract => continue,
                };
                let curve = Curve::of_move(from.to + up, m, up, chord_tolerance);
                let r = report_of(cutter, &curve, options, with_stock, &mut hint);
                sum = sum.and(&r);
            }
            sum
        })
        .collect();
    sums.iter().fold(FitReport::default(), |a, b| a.and(b))
}
