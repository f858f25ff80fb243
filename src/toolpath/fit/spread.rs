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

use super::prove::Vertex;
use super::{CLIFF_RUN, FitOptions, Rest};
use crate::geom::{Point, Vector};

/// How fast the length of segments may change along the path: at 0.5 a neighbour is at most some 1.7 times as long.
const GRADE: f64 = 0.5;
/// Directions are measured over this much of the path on either side of a place, mm: bends tighter than that are corners.
const LEVER: f64 = 0.05;
/// A chord that fails may be followed by one that holds (facets): so many more are tried.
const PATIENCE: usize = 2;
/// Rounds of denser spacing where a segment fails.
const ROUNDS: usize = 8;

/// Chooses the vertices of one run of rests, which has at least one.
pub(super) fn spread(rests: &[Rest], options: &FitOptions) -> Vec<Vertex> {
    let n = rests.len();
    let cliff = |i: usize| {
        let (a, b) = (rests[i].center, rests[i + 1].center);
        (b.xy() - a.xy()).norm() <= CLIFF_RUN && (b.z - a.z).abs() > CLIFF_RUN
    };
    let mut out = Vec::new();
    let mut first = 0;
    let mut after_cliff = false;
    for i in 0..n {
        let ends = i + 1 == n;
        if !ends && !cliff(i) {
            continue;
        }
        let from = out.len();
        piece(&rests[first..=i], options, &mut out);
        if after_cliff && let Some(v) = out.get_mut(from) {
            v.cliff = true;
        }
        if !ends && let Some(v) = out.last_mut() {
            v.cliff = true;
        }
        (first, after_cliff) = (i + 1, true);
    }
    out
}

/// Vertices of a piece without cliffs, both ends included.
fn piece(rests: &[Rest], options: &FitOptions, out: &mut Vec<Vertex>) {
    let push = |out: &mut Vec<Vertex>, at: Point| out.push(Vertex { at, cliff: false });
    push(out, rests[0].center);
    if rests.len() < 2 {
        return;
    }
    let along = distances(rests);
    let mut first = 0;
    for last in corners(rests, &along, options.turn)
        .into_iter()
        .chain([rests.len() - 1])
    {
        let smooth = Smooth::new(&rests[first..=last], &along[first..=last], options);
        smooth.vertices().for_each(|p| push(out, p));
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
fn angle(a: &Vector, b: &Vector) -> f64 {
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
    options: &'a FitOptions,
}

/// A place between two rests: index of the one before, and the point.
#[derive(Clone, Copy)]
struct Place {
    index: usize,
    at: Point,
}

impl<'a> Smooth<'a> {
    fn new(rests: &'a [Rest], along: &'a [f64], options: &'a FitOptions) -> Smooth<'a> {
        let heading = directions(rests, along)
            .iter()
            .map(|(a, b)| (a + b).try_normalize(1e-12).unwrap_or_else(Vector::zeros))
            .collect();
        Smooth {
            rests,
            along,
            heading,
            options,
        }
    }

    /// All vertices but the first.
    fn vertices(&self) -> impl Iterator<Item = Point> {
        let last = self.rests.len() - 1;
        let (reach, hops) = self.reach();
        let places = if hops.len() == 1 {
            vec![self.along[last]]
        } else {
            self.balanced(&reach, hops.len())
                .unwrap_or_else(|| hops.iter().map(|&i| self.along[i]).collect())
        };
        let mut points: Vec<Point> = places.iter().map(|&s| self.place(s).at).collect();
        if let Some(p) = points.last_mut() {
            *p = self.rests[last].center;
        }
        points.into_iter()
    }

    /// How far a chord from each rest holds, and the rests at which the longest chords one after the other end.
    fn reach(&self) -> (Vec<usize>, Vec<usize>) {
        let n = self.rests.len();
        let start = |i: usize| Place {
            index: i,
            at: self.rests[i].center,
        };
        let mut reach = vec![n - 1; n];
        let mut hops = Vec::new();
        let mut next_hop = 0;
        let mut far = 1;
        for i in 0..n - 1 {
            far = far.max(i + 1);
            while far > i + 1 && !self.holds(&start(i), &start(far)) {
                far -= 1;
            }
            let mut tried = far;
            while tried + 1 < n && tried - far < PATIENCE {
                tried += 1;
                if self.holds(&start(i), &start(tried)) {
                    far = tried;
                }
            }
            reach[i] = far;
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
        // Rests behind `a` up to the one at or before `b`.
        let (from, to) = (a.index + 1, b.index + 1);
        if to > from + 1 && angle(&self.heading[a.index], &self.heading[b.index]) > o.turn {
            return false;
        }
        self.rests[from.min(to)..to].iter().all(|r| {
            let s = if l2 > 0.0 {
                ((r.center - a.at).dot(&e) / l2).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let d = a.at + e * s - r.center;
            let up = d.dot(&r.normal);
            up >= -o.gouge
                && up <= o.stock
                && d.norm_squared() - up * up <= o.sideways * o.sideways
        })
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
    /// more if so many do not hold; `None` when that needs a fifth more.
    fn balanced(&self, reach: &[usize], count: usize) -> Option<Vec<f64>> {
        let n = self.rests.len();
        let total = self.along[n - 1];
        let mut room: Vec<f64> = Vec::with_capacity(n);
        for i in 0..n {
            let own = self.along[reach[i]] - self.along[i];
            // Near the end the path stops, not the chord.
            let cut_short = reach[i] == n - 1;
            let last = room.last().copied().unwrap_or(0.0);
            room.push(if cut_short { own.max(last) } else { own }.max(1e-6));
        }
        let mut count = count;
        let most = count + (count / 5).max(1);
        for round in 0.. {
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
            if sum <= 0.0 {
                return None;
            }
            count = count.max((0.97 * sum).ceil() as usize);
            if count > most || round >= ROUNDS {
                return None;
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
                places.push(a + (b - a) * f.clamp(0.0, 1.0));
            }
            places.push(total);
            let mut before = self.place(0.0);
            let mut good = true;
            for &s in &places {
                let here = if s >= total {
                    Place {
                        index: n - 1,
                        at: self.rests[n - 1].center,
                    }
                } else {
                    self.place(s)
                };
                if !self.holds(&before, &here) {
                    good = false;
                    for r in &mut room[before.index..=here.index] {
                        *r *= 0.9;
                    }
                }
                before = here;
            }
            if good {
                return Some(places);
            }
        }
        None
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
