//! Fewest points, evenly spread: which places of a densely dropped curve become vertices.
//!
//! ```text
//! dense rests --cut at cliffs--> --cut at corners--> smooth pieces
//!   a piece:  reach(i)  the farthest rest that a chord from rest i holds to
//!             hop by hop along the reach: the fewest segments
//!             1 / reach as a density, graded so that it changes slowly: equal shares of it are the vertices
//! ```
//!
//! Equal shares of a smooth density make neighbouring segments about as long as each other: the controller's planner is fed evenly, and
//! no short leg between two long ones bends the path.

use super::ease::ease;
use super::prove::Vertex;
use super::{CLIFF_RUN, FitOptions, Rest};
use crate::geom::{Point, Vector, nearest_on_segment};

/// How fast the length of segments may change along the path: at 0.5 a neighbour is at most some 1.7 times as long.
const GRADE: f64 = 0.5;
/// Directions are measured over this much of the path on either side of a place, mm: bends tighter than that are corners.
const LEVER: f64 = 0.05;
/// A chord that fails may be followed by one that holds (facets): so many more are tried.
const PATIENCE: usize = 2;
/// Rounds of denser spacing where a segment fails.
const ROUNDS: usize = 20;

/// Chooses the vertices of one run of rests, which has at least one.
///
/// A chord over convex ground is low in its middle, and right at its ends: lifting both ends by about half of that uses both budgets, so
/// chords may miss by their sum. Each vertex is lifted (or lowered) by what its two segments ask for.
pub(super) fn spread(rests: &[Rest], options: &FitOptions) -> Vec<Vertex> {
    let n = rests.len();
    let cliff = |i: usize| {
        let (a, b) = (rests[i].center, rests[i + 1].center);
        (b.xy() - a.xy()).norm() <= CLIFF_RUN && (b.z - a.z).abs() > CLIFF_RUN
    };
    let closed = is_closed(rests.iter().map(|r| &r.center));
    let mut places: Vec<(Place, bool)> = Vec::new();
    let mut first = 0;
    let mut after_cliff = false;
    for i in 0..n {
        let ends = i + 1 == n;
        if !ends && !cliff(i) {
            continue;
        }
        let from = places.len();
        let fixed = [first > 0 || !closed, !ends || !closed];
        piece(&rests[first..=i], first, fixed, options, &mut places);
        if after_cliff && let Some(v) = places.get_mut(from) {
            v.1 = true;
        }
        if !ends && let Some(v) = places.last_mut() {
            v.1 = true;
        }
        (first, after_cliff) = (i + 1, true);
    }
    lifted(rests, &ease(rests, places, options), options)
}

/// A run that ends where it began.
fn is_closed<'a>(mut points: impl ExactSizeIterator<Item = &'a Point>) -> bool {
    points.len() > 2
        && points
            .next()
            .zip(points.last())
            .is_some_and(|(a, b)| (a - b).norm() < 1e-9)
}

/// The vertices at these places, with their lifts.
fn lifted(rests: &[Rest], places: &[(Place, bool)], options: &FitOptions) -> Vec<Vertex> {
    let (g, s) = (options.gouge, options.stock);
    let wanted: Vec<f64> = places
        .windows(2)
        .map(|w| {
            let ((a, from_cliff), (b, to_cliff)) = (&w[0], &w[1]);
            if *from_cliff && *to_cliff {
                return 0.0;
            }
            let m = miss(rests, a, b);
            // So that what is too low and what is too high have the same share of their budgets.
            (m.low * s - m.high * g) / (g + s)
        })
        .collect();
    let n = places.len();
    let closed = is_closed(places.iter().map(|p| &p.0.at));
    (0..n)
        .map(|i| {
            let before = if i > 0 {
                Some(i - 1)
            } else {
                closed.then(|| n - 2)
            };
            let after = if i + 1 < n {
                Some(i)
            } else {
                closed.then_some(0)
            };
            let of = |k: Option<usize>| k.and_then(|k| wanted.get(k)).copied();
            let lift = match (of(before), of(after)) {
                (Some(a), Some(b)) => 0.5 * (a + b),
                // The ends of an open run are where others begin: they rest on the part.
                _ => 0.0,
            };
            // A vertex keeps its budgets itself, after rounding.
            let room = |budget: f64| (budget - 0.5 * options.decimal).max(0.0);
            let lift = lift.clamp(-room(g), room(s));
            Vertex {
                at: places[i].0.at,
                cliff: places[i].1,
                lift,
            }
        })
        .collect()
}

/// How a chord misses the rests behind its start up to the one at or before its end.
#[derive(Clone, Copy, Debug, Default)]
struct Miss {
    /// Deepest below, along the normal, mm; not negative.
    low: f64,
    /// Highest above, along the normal, mm; not negative.
    high: f64,
    /// Farthest sideways, squared, mm^2.
    aside_sq: f64,
}

fn miss(rests: &[Rest], a: &Place, b: &Place) -> Miss {
    let mut m = Miss::default();
    for r in rests.get(a.index + 1..=b.index).unwrap_or_default() {
        let d = nearest_on_segment(&r.center, &a.at, &b.at) - r.center;
        let up = d.dot(&r.normal);
        m.low = m.low.max(-up);
        m.high = m.high.max(up);
        m.aside_sq = m.aside_sq.max(d.norm_squared() - up * up);
    }
    m
}

/// Places of the vertices of a piece without cliffs, both ends included; `base` is the index of its first rest, `fixed` says which of its
/// ends will not be lifted.
fn piece(
    rests: &[Rest],
    base: usize,
    fixed: [bool; 2],
    options: &FitOptions,
    out: &mut Vec<(Place, bool)>,
) {
    let mut push = |p: Place| {
        let index = p.index + base;
        out.push((Place { index, ..p }, false));
    };
    push(Place {
        index: 0,
        at: rests[0].center,
    });
    if rests.len() < 2 {
        return;
    }
    let along = distances(rests);
    let mut first = 0;
    for last in corners(rests, &along, options.turn)
        .into_iter()
        .chain([rests.len() - 1])
    {
        let fixed = [fixed[0] && first == 0, fixed[1] && last + 1 == rests.len()];
        let smooth = Smooth::new(&rests[first..=last], &along[first..=last], fixed, options);
        for p in smooth.vertices() {
            let index = p.index + first;
            push(Place { index, ..p });
        }
        first = last;
    }
}

/// Distance along the rests, mm, from the first.
fn distances(rests: &[Rest]) -> Vec<f64> {
    let mut along = Vec::with_capacity(rests.len());
    let mut s = 0.0;
    for (i, r) in rests.iter().enumerate() {
        if i > 0 {
            s += (r.center - rests[i - 1].center).norm();
        }
        along.push(s);
    }
    along
}

/// Directions of the path before and after each place, measured over [`LEVER`]; zero vectors where there is nothing.
fn directions(rests: &[Rest], along: &[f64]) -> Vec<(Vector, Vector)> {
    let n = rests.len();
    let mut before = vec![Vector::zeros(); n];
    let (mut lo, mut hi) = (0, 0);
    let unit = |v: Vector| v.try_normalize(1e-12).unwrap_or_else(Vector::zeros);
    for i in 1..n {
        while lo + 1 < i && along[i] - along[lo + 1] >= LEVER {
            lo += 1;
        }
        before[i] = unit(rests[i].center - rests[lo].center);
    }
    let mut both = Vec::with_capacity(n);
    for i in 0..n {
        hi = hi.max((i + 1).min(n - 1));
        while hi + 1 < n && along[hi] - along[i] < LEVER {
            hi += 1;
        }
        both.push((before[i], unit(rests[hi].center - rests[i].center)));
    }
    both
}

/// Angle between two directions, rad; zero when one of them is nothing.
pub(super) fn angle(a: &Vector, b: &Vector) -> f64 {
    if *a == Vector::zeros() || *b == Vector::zeros() {
        return 0.0;
    }
    a.cross(b).norm().atan2(a.dot(b))
}

/// Inner places where the path turns by more than `turn` within two levers: the sharpest of each neighbourhood, in order.
fn corners(rests: &[Rest], along: &[f64], turn: f64) -> Vec<usize> {
    let n = rests.len();
    let turns: Vec<f64> = directions(rests, along)
        .iter()
        .map(|(a, b)| angle(a, b))
        .collect();
    let mut out: Vec<usize> = Vec::new();
    for i in 1..n.saturating_sub(1) {
        if turns[i] <= turn {
            continue;
        }
        let sharpest = |j: &usize| turns[*j] < turns[i] || (turns[*j] == turns[i] && *j >= i);
        let left = (0..i).rev().take_while(|&j| along[i] - along[j] < LEVER);
        let right = (i + 1..n).take_while(|&j| along[j] - along[i] < LEVER);
        if left.chain(right).all(|j| sharpest(&j)) {
            out.push(i);
        }
    }
    out
}

/// A piece of path without corners.
struct Smooth<'a> {
    rests: &'a [Rest],
    along: &'a [f64],
    /// Direction at each rest.
    heading: Vec<Vector>,
    /// Ends that will not be lifted.
    fixed: [bool; 2],
    options: &'a FitOptions,
}

/// A place on a path of rests: index of the rest at it or before it, and the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub index: usize,
    pub at: Point,
}

impl<'a> Smooth<'a> {
    fn new(
        rests: &'a [Rest],
        along: &'a [f64],
        fixed: [bool; 2],
        options: &'a FitOptions,
    ) -> Smooth<'a> {
        let heading = directions(rests, along)
            .iter()
            .map(|(a, b)| (a + b).try_normalize(1e-12).unwrap_or_else(Vector::zeros))
            .collect();
        Smooth {
            rests,
            along,
            heading,
            fixed,
            options,
        }
    }

    /// The rest itself as a place.
    fn rest(&self, index: usize) -> Place {
        Place {
            index,
            at: self.rests[index].center,
        }
    }

    /// All vertices but the first.
    fn vertices(&self) -> Vec<Place> {
        let (reach, hops) = self.reach();
        let greedy = || hops.iter().map(|&i| self.rest(i)).collect();
        if hops.len() == 1 {
            return greedy();
        }
        self.balanced(&reach, hops.len()).unwrap_or_else(greedy)
    }

    /// How far a chord from each rest holds, and the rests at which the longest chords one after the other end.
    fn reach(&self) -> (Vec<usize>, Vec<usize>) {
        let n = self.rests.len();
        let mut reach = vec![n - 1; n];
        let mut hops = Vec::new();
        let mut next_hop = 0;
        let mut far = 1;
        for (i, farthest) in reach.iter_mut().enumerate().take(n - 1) {
            far = far.max(i + 1);
            while far > i + 1 && !self.holds(&self.rest(i), &self.rest(far)) {
                far -= 1;
            }
            let mut tried = far;
            while tried + 1 < n && tried - far < PATIENCE {
                tried += 1;
                if self.holds(&self.rest(i), &self.rest(tried)) {
                    far = tried;
                }
            }
            *farthest = far;
            if i == next_hop {
                next_hop = far;
                hops.push(far);
            }
        }
        (reach, hops)
    }

    /// True when the straight way between two places keeps to the path.
    fn holds(&self, a: &Place, b: &Place) -> bool {
        let o = self.options;
        let e = b.at - a.at;
        let l2 = e.norm_squared();
        if l2 > o.longest * o.longest {
            return false;
        }
        if b.index > a.index + 1 && angle(&self.heading[a.index], &self.heading[b.index]) > o.turn {
            return false;
        }
        let m = miss(self.rests, a, b);
        // Both budgets, where both ends are lifted; hardly more than one, where one is not.
        let at_end =
            (self.fixed[0] && a.index == 0) || (self.fixed[1] && b.index + 1 == self.rests.len());
        let band = if at_end {
            1.3 * o.gouge.min(o.stock)
        } else {
            o.gouge + o.stock
        };
        // Rounding takes its share.
        m.low + m.high <= band - 0.6 * o.decimal && m.aside_sq <= o.sideways * o.sideways
    }

    /// The place at a distance along the path.
    fn place(&self, s: f64) -> Place {
        let n = self.rests.len();
        let after = self.along.partition_point(|x| *x <= s).clamp(1, n - 1);
        let (a, b) = (self.along[after - 1], self.along[after]);
        let f = if b > a {
            ((s - a) / (b - a)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (p, q) = (self.rests[after - 1].center, self.rests[after].center);
        Place {
            index: after - 1,
            at: p + (q - p) * f,
        }
    }

    /// Distances along the path of vertices (without the first) that split it into `count` segments of slowly changing length, or a few
    /// more if so many do not hold; `None` when that needs a quarter more.
    fn balanced(&self, reach: &[usize], count: usize) -> Option<Vec<Place>> {
        let n = self.rests.len();
        let mut room: Vec<f64> = Vec::with_capacity(n);
        for (i, &farthest) in reach.iter().enumerate() {
            let own = self.along[farthest] - self.along[i];
            // Near the end the path stops, not the chord.
            let cut_short = farthest == n - 1;
            let last = room.last().copied().unwrap_or(0.0);
            room.push(if cut_short { own.max(last) } else { own }.max(1e-6));
        }
        let mut count = count;
        let most = count + (count / 4).max(2);
        let mut best: Option<(usize, Vec<Place>)> = None;
        for _ in 0..ROUNDS {
            self.grade(&mut room);
            // Density and its integral.
            let mut shares = Vec::with_capacity(n);
            let mut sum = 0.0;
            for i in 0..n {
                if i > 0 {
                    let step = self.along[i] - self.along[i - 1];
                    sum += 0.5 * step * (1.0 / room[i] + 1.0 / room[i - 1]);
                }
                shares.push(sum);
            }
            count = count.max((0.93 * sum).ceil() as usize);
            if count > most || sum <= 0.0 {
                break;
            }
            let mut places = Vec::with_capacity(count);
            let mut k = 1;
            for j in 1..count {
                let want = sum * j as f64 / count as f64;
                while k + 1 < n && shares[k] < want {
                    k += 1;
                }
                let f = (want - shares[k - 1]) / (shares[k] - shares[k - 1]).max(1e-300);
                let (a, b) = (self.along[k - 1], self.along[k]);
                places.push(self.place(a + (b - a) * f.clamp(0.0, 1.0)));
            }
            places.push(self.rest(n - 1));
            let mut before = self.rest(0);
            let mut failed = 0;
            for here in &places {
                if !self.holds(&before, here) {
                    failed += 1;
                    for r in &mut room[before.index..=here.index] {
                        *r *= 0.88;
                    }
                }
                before = *here;
            }
            if best.as_ref().is_none_or(|b| failed < b.0) {
                best = Some((failed, places));
            }
            if failed == 0 {
                break;
            }
        }
        // What fails here is split by the proof.
        best.filter(|b| 20 * b.0 <= count).map(|b| b.1)
    }

    /// Lets lengths change slowly: no more than [`GRADE`] per length of path.
    fn grade(&self, room: &mut [f64]) {
        for i in 1..room.len() {
            room[i] = room[i].min(room[i - 1] + GRADE * (self.along[i] - self.along[i - 1]));
        }
        for i in (1..room.len()).rev() {
            room[i - 1] = room[i - 1].min(room[i] + GRADE * (self.along[i] - self.along[i - 1]));
        }
    }
}
