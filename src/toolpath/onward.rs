//! Onward: from the end of one run to the start of another further along the same wall.
//!
//! ```text
//!   ------.                       a curve that leaves the first as it runs and comes onto the second as that runs, bowed out from the
//!    run   '-.___.-------         wall as far as it must be and no further; beside a leap there is no surface to follow
//!                   run
//! ```
//!
//! Crosses the border: two runs of ball centres in, the places between out, proven free; work coordinates, mm.

use super::bridge::{End, is_free};
use super::fit::FitOptions;
use crate::geom::{Point, Vector2};
use crate::reach::{DropCutter, Hint};

/// Runs further apart than this are not joined so, mm.
const FARTHEST: f64 = 5.0;
/// Steepest way up or down, as a slope on the whole.
const STEEPEST: f64 = 0.9;
/// How far the way is bowed out at most, in shares of its length: tried from the first on, to one side and to the other.
const BOWS: [f64; 5] = [0.0, 0.03, 0.08, 0.16, 0.3];
/// Places along the way.
const PLACES: usize = 24;

/// Places from the end of `before` to the start of `onto`, both among them; `None` where the second does not lie ahead, or the ball is
/// not free on the way.
pub(super) fn onward(
    cutter: &DropCutter,
    before: &[Point],
    onto: &[Point],
    fitting: &FitOptions,
) -> Option<Vec<Point>> {
    let (from, to) = (End::after(before)?, End::before(onto)?);
    let gap = to.at - from.at;
    let flat = gap.xy().norm();
    let (u, v) = (
        from.heading.xy().try_normalize(1e-6)?,
        to.heading.xy().try_normalize(1e-6)?,
    );
    let ahead = u.dot(&gap.xy()) > 0.3 * flat && v.dot(&gap.xy()) > 0.3 * flat && u.dot(&v) > 0.0;
    if !ahead || gap.norm() > FARTHEST || gap.z.abs() > STEEPEST * flat {
        return None;
    }
    let side = Vector2::new(-gap.y, gap.x);
    let mut hint = Hint::default();
    BOWS.iter().flat_map(|b| [*b, -*b]).find_map(|bow| {
        let mut out = vec![from.at];
        for k in 1..=PLACES {
            let t = k as f64 / PLACES as f64;
            let s = 1.0 - t;
            // Hermite's cubic, and a bow that begins and ends along it.
            let rise = t * t * (3.0 - 2.0 * t);
            let q = from.at.xy()
                + gap.xy() * rise
                + (u * (t * s * s) - v * (t * t * s)) * flat
                + side * (16.0 * bow * t * t * s * s);
            let next = if k == PLACES {
                to.at
            } else {
                Point::new(q.x, q.y, from.at.z + gap.z * rise)
            };
            let last = out.last().copied()?;
            if !is_free(cutter, &last, &next, 0.5 * fitting.probe, &mut hint) {
                return None;
            }
            out.push(next);
        }
        Some(out)
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

    /// From one run round a post on to the next, a little lower: a straight way would go through the post.
    #[test]
    fn on_round_a_post() {
        let cutter = post();
        let fitting = FitOptions::for_scallop(0.02, R);
        let (a, b) = (round(0.0, 0.5, 8.0), round(0.65, 1.0, 7.6));
        let way = onward(&cutter, &a, &b, &fitting).unwrap();
        assert_eq!((way[0], way[PLACES]), (a[40], b[0]));
        let length: f64 = way.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        assert!(length < 1.1 * (b[0] - a[40]).norm(), "{length}");
        for w in way.windows(2) {
            // The ball's side keeps off the post.
            for k in 0..=20 {
                let q = w[0] + (w[1] - w[0]) * (f64::from(k) / 20.0);
                assert!(q.xy().coords.norm() > 8.0 + R - 0.001, "{q}");
            }
        }
        let all: Vec<Point> = a.iter().chain(&way[1..]).chain(&b[1..]).copied().collect();
        for w in all.windows(3) {
            let turn = (w[1] - w[0]).angle(&(w[2] - w[1])).to_degrees();
            assert!(turn < 15.0, "{turn} at {}", w[1]);
        }
        // What lies behind is not reached so.
        assert_eq!(onward(&cutter, &b, &a, &fitting), None);
    }
}
