//! Onward: from the end of one run to the start of another, through the air beside a wall.
//!
//! ```text
//!   ------.                       a curve in space that leaves the first as it runs and comes onto the second as that runs, bowed out
//!    run   '-.___.-------         from the wall as far as it must be and no further; beside a leap, and round a solid, there is no
//!                   run           surface to follow. Where the second lies behind, arcs up and down the wall turn the way round
//! ```
//!
//! Crosses the border: two runs of ball centres in, the places between out, proven free; work coordinates, mm.

use super::bridge::{End, is_free};
use super::turn::{Pose, Turn, turns};
use crate::geom::{Point, Point2, Vector, Vector2};
use crate::reach::{DropCutter, Hint};
use crate::toolpath::ease::{cubic, smooth};
use crate::toolpath::fit::FitOptions;

/// Runs further apart than this are not joined so: mm, or ball radii where that is more.
const FARTHEST: (f64, f64) = (15.0, 5.0);
/// How far the way is bowed out at most, in shares of the gap: tried from the first on, to one side and to the other.
const BOWS: [f64; 5] = [0.0, 0.03, 0.08, 0.16, 0.3];
/// ... and by no more than this, mm: next to the part stands what was roughed.
const WIDEST: f64 = 2.0;
/// It goes no further below the lower end than this, mm.
const DIP: f64 = 0.02;
/// The way turns by about so much from chord to chord, rad, and by no more than the second.
const TURN: (f64, f64) = (0.15, 0.4);
/// A curve that bends more tightly than this, mm, is a corner; ways with arcs are made of these.
const TIGHTEST: f64 = 0.15;
const RADII: [f64; 3] = [1.0, 0.5, 0.25];
/// Pieces of those are no longer, mm.
const PIECE: f64 = 0.1;

/// Places from the end of `before` to the start of `onto`, both among them; `None` where the ball is not free on such a way, or it would
/// have to turn sharply.
pub(in crate::toolpath) fn onward(
    cutter: &DropCutter,
    before: &[Point],
    onto: &[Point],
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    let (from, to) = (End::after(before)?, End::before(onto)?);
    let gap = to.at - from.at;
    let far = gap.norm();
    if !(1e-3..=FARTHEST.0.max(FARTHEST.1 * cutter.radius())).contains(&far) {
        return None;
    }
    // The wall's own plane: upright, along the way; on the way straight up a wall, along the runs.
    let along = if gap.xy().norm() > 0.3 * far {
        gap.xy()
    } else {
        from.heading.xy()
    };
    let along = along.try_normalize(1e-9)?;
    let side = Vector::new(-along.y, along.x, 0.0);
    let mut ways = vec![vec![from.at]];
    cubic(
        &from.at,
        &from.heading,
        &to.at,
        &to.heading,
        TURN.0,
        &mut ways[0],
    );
    ways.retain(|w| !tight(w));
    ways.extend(RADII.iter().flat_map(|r| arcs(&from, &to, &along, *r)));
    // Below the lower of the two there may be a floor.
    let lowest = from.at.z.min(to.at.z) - DIP;
    ways.retain(|w| w.len() > 1 && w.iter().all(|q| q.z >= lowest));
    let mut hint = Hint::default();
    let bowed = BOWS.iter().flat_map(|b| [*b, -*b]);
    bowed
        .map(|bow| bow * far)
        .filter(|bow| bow.abs() <= WIDEST)
        .flat_map(|bow| ways.iter().map(move |w| (bow, w)))
        .find_map(|(bow, way)| {
            let out = aside(way, |t| side * (16.0 * bow * (t * (1.0 - t)).powi(2)));
            let free = smooth(&from.heading, &out, &to.heading, TURN.1)
                && (out.windows(2))
                    .all(|w| is_free(cutter, &w[0], &w[1], 0.5 * fitting.probe, &mut hint));
            free.then_some(out)
        })
}

/// A way moved by so much at each share of it.
fn aside(way: &[Point], by: impl Fn(f64) -> Vector) -> Vec<Point> {
    let last = (way.len() - 1) as f64;
    way.iter()
        .enumerate()
        .map(|(k, q)| q + by(k as f64 / last))
        .collect()
}

/// Arcs and a straight in the upright plane along the way, and from one end's heading across it to the other's. None for ends that head
/// across it.
fn arcs(from: &End, to: &End, along: &Vector2, radius: f64) -> Vec<Vec<Point>> {
    let across = Vector2::new(-along.y, along.x);
    // Along the plane, up it, and off it.
    let split = |v: &Vector| (Vector2::new(v.xy().dot(along), v.z), v.xy().dot(&across));
    let gap = split(&(to.at - from.at));
    let pose = |at: Vector2, heading: &Vector| {
        let (on, off) = split(heading);
        let steep = off / on.norm();
        (on.norm() > 0.5).then_some((Pose::new(Point2::from(at), on)?, steep))
    };
    let (Some((start, leaves)), Some((end, comes))) = (
        pose(Vector2::zeros(), &from.heading),
        pose(gap.0, &to.heading),
    ) else {
        return Vec::new();
    };
    let lifted = |way: Turn| {
        let flat: Vec<Point> = way
            .points(PIECE)
            .iter()
            .map(|q| from.at + Vector::new(along.x * q.x, along.y * q.x, q.y))
            .collect();
        let mut out = aside(&flat, |t| {
            let s = 1.0 - t;
            let off =
                way.length * t * s * (leaves * s - comes * t) + gap.1 * t * t * (3.0 - 2.0 * t);
            Vector::new(across.x, across.y, 0.0) * off
        });
        if let Some(last) = out.last_mut() {
            *last = to.at;
        }
        out
    };
    turns(&start, &end, radius)
        .into_iter()
        .map(lifted)
        .collect()
}

/// Does a way bend as a corner does?
fn tight(way: &[Point]) -> bool {
    way.windows(3).any(|w| {
        let (u, v) = (w[1] - w[0], w[2] - w[1]);
        u.norm().min(v.norm()) < TIGHTEST * u.angle(&v)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;

    const R: f64 = 3.0;

    /// A round post of radius 8 about the origin, from 0 to 10, upright all round.
    fn post() -> DropCutter {
        let n = 720;
        let rim = |k: usize, z: f64| {
            let (s, c) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            Point::new(8.0 * c, 8.0 * s, z)
        };
        let triangles = (0..n)
            .map(|k| [Point::new(0.0, 0.0, 10.0), rim(k, 10.0), rim(k + 1, 10.0)])
            .collect();
        DropCutter::new(&Mesh { triangles }, R)
    }

    /// A run round the post at a height, from one angle to another, a hair off it.
    fn round(from: f64, to: f64, z: f64) -> Vec<Point> {
        (0..=40)
            .map(|k| {
                let (s, c) = (from + (to - from) * f64::from(k) / 40.0).sin_cos();
                Point::new((8.0 + R + 0.003) * c, (8.0 + R + 0.003) * s, z)
            })
            .collect()
    }

    /// What holds for every way: the ball keeps off the post, it does not turn sharply, and it dips no lower than its ends.
    fn judge(cutter: &DropCutter, a: &[Point], way: &[Point], b: &[Point]) {
        for w in way.windows(2) {
            for k in 0..=20 {
                let q = w[0] + (w[1] - w[0]) * (f64::from(k) / 20.0);
                assert!(cutter.is_clear(&q, 0.002, &mut Hint::default()), "{q}");
                assert!(q.z > way[0].z.min(way[way.len() - 1].z) - 0.03, "{q}");
            }
        }
        let all: Vec<Point> = a.iter().chain(&way[1..]).chain(&b[1..]).copied().collect();
        for w in all.windows(3) {
            let turn = (w[1] - w[0]).angle(&(w[2] - w[1])).to_degrees();
            assert!(turn < 26.0, "{turn} at {}", w[1]);
        }
    }

    /// From one run round a post on to the next, a little lower: a straight way would go through the post.
    #[test]
    fn on_round_a_post() {
        let cutter = post();
        let fitting = FitOptions::for_scallop(0.02, R);
        let (a, b) = (round(0.0, 0.5, 8.0), round(0.65, 1.0, 7.6));
        let way = onward(&cutter, &a, &b, &fitting).unwrap();
        assert_eq!((way[0], way[way.len() - 1]), (a[40], b[0]));
        let length: f64 = way.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        assert!(length < 1.1 * (b[0] - a[40]).norm(), "{length}");
        judge(&cutter, &a, &way, &b);
    }

    /// Back to the start of the run before, above or below, and to one that runs the other way.
    #[test]
    fn to_what_lies_behind_it_turns_up_the_wall() {
        let cutter = post();
        let fitting = FitOptions::for_scallop(0.02, R);
        for z in [8.7, 8.0, 7.3] {
            for (from, to) in [(0.1, 0.5), (0.55, 0.1), (0.9, 0.6), (0.6, 0.9)] {
                let (a, b) = (round(0.0, 0.5, 8.0), round(from, to, z));
                let way = onward(&cutter, &a, &b, &fitting)
                    .unwrap_or_else(|| panic!("no way to {from}..{to} at {z}"));
                judge(&cutter, &a, &way, &b);
            }
        }
    }
}
