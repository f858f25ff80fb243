//! How high a cusp stands between the centres of cells.
//!
//! ```text
//!     /\            a crest is as sharp as its two flanks meet: cells a fourteenth of a stepover apart miss the top of it by up to
//!    /  \_          half a diagonal times sqrt(2 h / R), a seventh of h. The flanks are known, though: from each two cells the
//!   .  .  .  .      height at which they meet says where a closer look is worth it.
//! ```
//! Knows cells and heights, nothing of who asks.

use crate::geom::{Point, Point2};
use crate::reach::DropCutter;
use crate::sweep::Reachable;
use crate::sweep::nearest::{Curtain, Paths};
use crate::sweep::reachable::NONE;

/// Places looked at along a side of a cell.
const SIDE: usize = 4;
/// Places looked at in a cell.
pub const PLACES: usize = SIDE * SIDE;

/// From the centre of a cell to one of its places, in steps.
pub fn place(k: usize) -> (f64, f64) {
    let at = |k: usize| (k as f64 + 0.5) / SIDE as f64 - 0.5;
    (at(k % SIDE), at(k / SIDE))
}

/// The directions in which a crest may cross a cell, in cells.
const ACROSS: [(i64, i64); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// About how high a crest through a cell stands at most within half a step of it: where parabolas through the neighbours on either
/// side meet, or the cell's own height. `height` tells that of a cell this far away, not finite where there is none; `bend` is what a
/// flank bends within a step, step^2 / (2 R).
pub fn crest(height: impl Fn(i64, i64) -> f64, bend: f64) -> f64 {
    let own = height(0, 0);
    ACROSS.iter().fold(own, |best, &(x, y)| {
        let [a2, a1, b1, b2] = [-2, -1, 1, 2].map(|k| height(k * x, k * y));
        let bend = bend * (x * x + y * y) as f64;
        // The top lies past this cell, or before it.
        best.max(meeting(a1, own, b1, b2, bend))
            .max(meeting(b1, own, a1, a2, bend))
    })
}

/// The height at which a flank that rises through (-1, a) and (0, b) meets the one that falls through (1, c) and (2, d), if that is
/// between 0 and 1; -inf otherwise. Both bend upwards.
fn meeting(a: f64, b: f64, c: f64, d: f64, bend: f64) -> f64 {
    let (up, down) = (b - a, c - d);
    let t = (c - b + down + 2.0 * bend) / (up + down + 4.0 * bend);
    let z = b + up * t + bend * t * (t + 1.0);
    // What is not a number fails.
    if (0.0..=1.0).contains(&t) && z.is_finite() {
        z
    } else {
        f64::NEG_INFINITY
    }
}

/// A share of the height asked for that [`crest`] may be wrong by.
pub const SLACK: f64 = 0.05;

/// True where the ball reaches the part itself, but for this much (mm, along the normal), in a cell of a window and all around it:
/// there any place of the cell can be judged.
pub fn reached(r: &Reachable, i: usize, but: f64) -> bool {
    let (nx, ny) = (r.lattice.nx, r.lattice.ny);
    let (x, y) = r.lattice.cell(i);
    if x == 0 || y == 0 || x + 1 >= nx || y + 1 >= ny {
        return false;
    }
    // Off the part there is nothing to reach.
    let fine = |i: usize| r.part_z[i].is_nan() || r.rest(i) <= but;
    (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| fine(r.lattice.index(x, y))))
}

/// The distances of the ball from places of the part in a cell: how far it has been from each at least, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Heights of the part, from that of the cell's centre; +inf off the part.
    z: [f32; PLACES],
    /// 0 where there is no part. The last is the cell's own centre.
    distance: [f32; PLACES + 1],
}

/// A cell that is looked at more closely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Its centre, on the surface that is judged.
    pub center: Point,
    /// Distance between cells, mm.
    pub step: f64,
    /// Where in plan the ball's centre should have been.
    pub expected: Point2,
    /// Nothing further away is looked for, mm.
    pub limit: f64,
}

impl Look {
    /// A cell of a window, judged on the part.
    pub fn at(r: &Reachable, i: usize, z: f64) -> Look {
        let q = r.lattice.center_at(i);
        Look {
            center: Point::new(q.x, q.y, z),
            step: r.lattice.step,
            expected: r.center_over(i),
            limit: r.radius + r.lattice.step,
        }
    }

    fn point(&self, k: usize, z: f64) -> Point {
        let (u, v) = place(k);
        Point::new(
            self.center.x + u * self.step,
            self.center.y + v * self.step,
            self.center.z + z,
        )
    }
}

/// The lowest distance from a point, mm, to some curtains; +inf for none.
fn nearest(curtains: &[Curtain], p: &Point) -> f64 {
    curtains
        .iter()
        .map(|c| c.distance_sq(p))
        .fold(f64::INFINITY, f64::min)
        .sqrt()
}

impl Places {
    /// The centre alone.
    pub fn center(look: &Look) -> Places {
        let mut distance = [0.0; PLACES + 1];
        distance[PLACES] = look.limit as f32;
        Places {
            z: [f32::INFINITY; PLACES],
            distance,
        }
    }

    /// All places of the part in the cell.
    pub fn all(look: &Look, part: &DropCutter) -> Places {
        let mut all = Places::center(look);
        for k in 0..PLACES {
            let p = look.point(k, 0.0);
            if let Some(z) = part.surface_z(p.x, p.y) {
                all.z[k] = (z - look.center.z) as f32;
                all.distance[k] = look.limit as f32;
            }
        }
        all
    }

    /// How far the furthest corner of the cell is from its centre at most, mm.
    fn spread(&self, look: &Look) -> f64 {
        // Corners lie a third further out than the outermost places.
        let there = self.z.iter().filter(|z| z.is_finite());
        let rise = there.fold(0.0, |b: f32, z| b.max(z.abs()));
        (0.71 * look.step).hypot(1.5 * f64::from(rise))
    }

    /// Some more moves of the ball. `near` is left with those that can be nearest anywhere in the cell; it is empty where none of
    /// them changes anything.
    pub fn cut(&mut self, look: &Look, paths: &Paths, near: &mut Vec<Curtain>) {
        // No place is further from any move than the centre is, and the way to it.
        let spread = 2.0 * self.spread(look);
        let before = f64::from(self.distance[PLACES]);
        near.clear();
        let own = paths.distance(&look.center, before + spread, &look.expected);
        if own == f64::INFINITY {
            return;
        }
        let own = own.min(before);
        self.distance[PLACES] = own as f32;
        if self.z.iter().all(|z| !z.is_finite()) {
            return;
        }
        paths.around(&look.center, own + spread, near);
        for k in 0..PLACES {
            if self.z[k].is_finite() {
                let d = nearest(near, &look.point(k, f64::from(self.z[k]))) as f32;
                self.distance[k] = self.distance[k].min(d);
            }
        }
    }

    /// The furthest the ball has stayed away from any of the places, and which; the last number is the centre.
    pub fn furthest(&self) -> (usize, f64) {
        // Of equals the first.
        let start = (PLACES, f64::from(self.distance[PLACES]));
        (0..PLACES).fold(start, |b, k| {
            let d = f64::from(self.distance[k]);
            if d > b.1 { (k, d) } else { b }
        })
    }
}

/// Halvings of the distance between places in [`highest`].
const HALVINGS: usize = 3;

/// The furthest that the ball stays away from the part anywhere in a cell, mm: the furthest of its places, from there uphill in ever
/// smaller steps, a 32nd of a cell at last. Not followed further up where that is less than `enough`.
pub fn highest(look: &Look, part: &DropCutter, paths: &Paths, enough: f64) -> f64 {
    let mut all = Places::all(look, part);
    let mut near = Vec::new();
    all.cut(look, paths, &mut near);
    let (k, mut best) = all.furthest();
    if best < enough || near.is_empty() {
        return best;
    }
    let (mut u, mut v) = if k < PLACES { place(k) } else { (0.0, 0.0) };
    let mut by = 0.5 / SIDE as f64;
    for _ in 0..HALVINGS {
        let (u0, v0) = (u, v);
        for du in [-by, 0.0, by] {
            for dv in [-by, 0.0, by] {
                let (s, t) = (u0 + du, v0 + dv);
                if (du == 0.0 && dv == 0.0) || s.abs() > 0.5 || t.abs() > 0.5 {
                    continue;
                }
                let (x, y) = (look.center.x + s * look.step, look.center.y + t * look.step);
                let Some(z) = part.surface_z(x, y) else {
                    continue;
                };
                let d = nearest(&near, &Point::new(x, y, z)).min(look.limit);
                if d > best {
                    (u, v, best) = (s, t, d);
                }
            }
        }
        by *= 0.5;
    }
    best
}

/// The node that reaches a cell best, as a place in plan.
pub fn expected(center: &Point2, step: f64, by: [i16; 2]) -> Point2 {
    if by[0] == NONE {
        return *center;
    }
    Point2::new(
        center.x + step * f64::from(by[0]),
        center.y + step * f64::from(by[1]),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::part::Mesh;
    use crate::sweep::tiles::area;
    use crate::sweep::{Segment, Swept, reachable};

    const R: f64 = 3.0;
    const STEP: f64 = 0.05;

    /// A plane that rises in y, and passes across the slope, `w` apart on it, that come nowhere near the lattice's own directions.
    fn sloping(slope: f64, w: f64) -> (Mesh, Vec<Segment>) {
        let p = |x: f64, y: f64| Point::new(x, y, slope * y);
        let mesh = Mesh {
            triangles: vec![
                [p(0.0, 0.0), p(8.0, 0.0), p(8.0, 8.0)],
                [p(0.0, 0.0), p(8.0, 8.0), p(0.0, 8.0)],
            ],
        };
        let c = 1.0 / (1.0 + slope * slope).sqrt();
        // Along the slope and level.
        let (up, flat) = ([0.0, c, slope * c], [1.0, 0.0, 0.0]);
        let (s, t) = 0.4f64.sin_cos();
        let along: Vec<f64> = (0..3).map(|k| t * flat[k] + s * up[k]).collect();
        let across: Vec<f64> = (0..3).map(|k| t * up[k] - s * flat[k]).collect();
        let segments = (-20..40)
            .map(|k| {
                let at = |u: f64| {
                    let d = |i: usize| along[i] * u + across[i] * w * f64::from(k);
                    Point::new(4.0 + d(0), d(1) - R * slope * c, d(2) + R * c)
                };
                Segment {
                    from: at(-20.0),
                    to: at(20.0),
                }
            })
            .collect();
        (mesh, segments)
    }

    /// Two flanks of equal passes, seen at cells that miss the crest by anything: where they meet is known to a micrometre or so.
    #[test]
    fn flanks_tell_the_crest() {
        let w = 0.7;
        let top = 1e3 * (R - (R * R - w * w / 4.0).sqrt());
        for miss in [0.0, 0.1, 0.25, 0.4, 0.5] {
            let height = |x: i64, _: i64| {
                let from_crest = (x as f64 - miss) * STEP;
                let s = 0.5 * w - from_crest.abs();
                1e3 * (R - (R * R - s * s).sqrt())
            };
            // In micrometres throughout.
            let seen = crest(height, 1e3 * STEP * STEP / (2.0 * R));
            // Along the crest nothing bends, and is taken to: a little too high.
            assert!(
                seen > top - 0.05 && seen < top + 0.5,
                "{miss}: {seen} {top}"
            );
            assert!(height(0, 0) <= seen);
        }
    }

    /// Nowhere to meet, nothing made up: a flank is no higher than it is half a step on, and what is not there counts for nothing.
    #[test]
    fn a_flank_is_no_crest() {
        assert!(crest(|x, _| 3.0 * x as f64, 0.01) < 1.5 + 0.02);
        assert_eq!(
            crest(
                |x, y| if (x, y) == (0, 0) {
                    7.0
                } else {
                    f64::NEG_INFINITY
                },
                0.01
            ),
            7.0
        );
    }

    /// On a plane the highest place between two passes is R - sqrt(R^2 - w^2 / 4) above it, whatever the slope; no cell's centre sees as
    /// much, the look between them does.
    #[test]
    fn the_highest_place_of_a_crest_is_found() {
        let w = 0.68;
        let top = R - (R * R - w * w / 4.0).sqrt();
        for slope in [0.0, 0.5, 1.5] {
            let (mesh, segments) = sloping(slope, w);
            let drop = DropCutter::new(&mesh, R);
            let r = reachable(&drop, STEP);
            let paths = Paths::new(&segments, 0.25 * R, area(&r.lattice));
            let mut swept = Swept::new(r.lattice);
            swept.cut(&segments, R);
            let mut best: f64 = 0.0;
            for i in 0..r.lattice.len() {
                let q = r.lattice.center_at(i);
                if !(3.0..4.0).contains(&q.x) || !(3.0..4.0).contains(&q.y) {
                    continue;
                }
                assert!(reached(&r, i, 1e-4));
                let look = Look::at(&r, i, r.part_z[i]);
                let d = highest(&look, &drop, &paths, 0.0) - R;
                assert!(
                    d <= 1.001 * top
                        && d >= (swept.z[i] - r.part_z[i]) / (1.0 + slope * slope).sqrt() - 1e-3
                );
                best = best.max(d);
            }
            // Distances from the surface, cusps above it: they differ in the second order, h^2 / R.
            assert!((best - top).abs() < 3e-4, "{slope}: {best} {top}");
        }
    }

    /// However the moves are dealt out, each place keeps its distance from the nearest of them.
    #[test]
    fn places_keep_their_distance_from_all_moves() {
        let (mesh, segments) = sloping(0.7, 0.5);
        let drop = DropCutter::new(&mesh, R);
        let r = reachable(&drop, STEP);
        let all = Paths::new(&segments, 0.25 * R, area(&r.lattice));
        let dealt: Vec<Paths> = (0..3)
            .map(|k| {
                let some: Vec<Segment> = segments.iter().skip(k).step_by(3).copied().collect();
                Paths::new(&some, 0.25 * R, area(&r.lattice))
            })
            .collect();
        for (x, y) in [(3.3, 3.1), (4.0, 5.0), (2.7, 6.6), (0.02, 4.0)] {
            let (ix, iy) = r.lattice.nearest(x, y).unwrap();
            let i = r.lattice.index(ix, iy);
            let look = Look::at(&r, i, r.part_z[i]);
            let mut places = Places::all(&look, &drop);
            let mut near = Vec::new();
            for p in &dealt {
                places.cut(&look, p, &mut near);
            }
            for k in (0..PLACES).filter(|&k| places.z[k].is_finite()) {
                let p = look.point(k, f64::from(places.z[k]));
                let want = all.distance(&p, look.limit, &p.xy()).min(look.limit);
                assert!((f64::from(places.distance[k]) - want).abs() < 1e-6, "{k}");
            }
        }
    }
}
