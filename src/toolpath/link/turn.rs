//! Smooth turns in plan: the shortest way from one place and heading to another that never bends tighter than a radius.
//!
//! L. E. Dubins, *On curves of minimal length with a constraint on average curvature*, Amer. J. Math. 79 (1957): it is an arc, a straight
//! and an arc, or three arcs. A U-turn between two passes is its simplest case: half a circle, when the radius is half the gap.
//!
//! On a slope an arc in plan is an ellipse on the surface, tight where the way turns downhill: there the turn is drawn on the tangent
//! plane ([`Slant`]) and seen from above.
//!
//! Knows nothing of surfaces but a slope: the caller drops the way onto the part and proves it.

use crate::geom::{Point2, Vector2};
use std::f64::consts::{PI, TAU};

/// A place in plan and the way the tool is heading there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Place, mm.
    pub at: Point2,
    /// Unit vector.
    pub heading: Vector2,
}

impl Pose {
    /// At a place in plan, heading this way; `None` for no way.
    pub fn new(at: Point2, way: Vector2) -> Option<Pose> {
        let heading = way.try_normalize(0.0)?;
        Some(Pose { at, heading })
    }
}

/// Plan and tangent plane of a slope: lengths across it are the same in both, lengths along it are longer on the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slant {
    /// Uphill in plan, a unit vector; zero on the flat.
    up: Vector2,
    /// Length on the plane of one unit uphill in plan.
    longer: f64,
}

/// Ground steeper than this (rise over run) counts as so steep.
const STEEPEST: f64 = 5.0;

impl Slant {
    /// Of a surface with this gradient.
    pub fn of(gradient: &Vector2) -> Slant {
        let g = gradient.norm();
        if !g.is_finite() || g < 1e-9 {
            return Slant::default();
        }
        Slant {
            up: gradient / g,
            longer: 1f64.hypot(g.min(STEEPEST)),
        }
    }

    /// From plan onto the plane.
    fn raise(&self, v: Vector2) -> Vector2 {
        v + self.up * (self.up.dot(&v) * (self.longer - 1.0))
    }

    /// From the plane into plan.
    fn lower(&self, v: Vector2) -> Vector2 {
        v + self.up * (self.up.dot(&v) * (1.0 / self.longer - 1.0))
    }

    /// A pose in plan as it is on the plane.
    pub fn pose(&self, p: &Pose) -> Pose {
        let heading = self.raise(p.heading);
        Pose {
            at: Point2::from(self.raise(p.at.coords)),
            heading: heading / heading.norm().max(1e-300),
        }
    }
}

impl Default for Slant {
    fn default() -> Slant {
        Slant {
            up: Vector2::zeros(),
            longer: 1.0,
        }
    }
}

/// One piece of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    Left(f64),
    Right(f64),
    Straight(f64),
}

use Piece::{Left, Right, Straight};

impl Piece {
    fn length(&self) -> f64 {
        match self {
            Left(v) | Right(v) | Straight(v) => *v,
        }
    }
}

/// A way between two poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// On the plane of `slant`.
    from: Pose,
    radius: f64,
    pieces: [Piece; 3],
    slant: Slant,
    /// Length on the plane it is drawn on, mm.
    pub length: f64,
    /// Length of its arcs alone, mm.
    pub curved: f64,
}

/// The shortest way of bending radius `radius` (above zero) from one pose to another, drawn on the plane of `slant`; poses are in plan.
pub fn turn(slant: &Slant, from: &Pose, to: &Pose, radius: f64) -> Turn {
    let (from, to) = (&slant.pose(from), &slant.pose(to));
    let mut best = [
        Straight((to.at - from.at).norm() / radius),
        Straight(0.0),
        Straight(0.0),
    ];
    let mut least = f64::INFINITY;
    // In units of the radius; ties keep the first.
    words(from, to, radius, |w| {
        let sum = w.iter().map(Piece::length).sum::<f64>();
        if sum < least - 1e-12 {
            (least, best) = (sum, w);
        }
    });
    Turn::of(from, radius, best, slant)
}

/// Every such way of two arcs and a straight between them, or of three arcs, on the flat; shortest first.
pub fn turns(from: &Pose, to: &Pose, radius: f64) -> Vec<Turn> {
    let mut out = Vec::new();
    words(from, to, radius, |w| {
        out.push(Turn::of(from, radius, w, &Slant::default()));
    });
    out.sort_by(|a, b| a.length.total_cmp(&b.length));
    out
}

/// The pieces of every way from one pose to another, in units of the radius.
fn words(from: &Pose, to: &Pose, radius: f64, mut offer: impl FnMut([Piece; 3])) {
    let d = (to.at - from.at) / radius;
    let along = angle(&d);
    let dist = d.norm();
    let a = wrap(angle(&from.heading) - along);
    let b = wrap(angle(&to.heading) - along);
    let (sa, ca, sb, cb) = (a.sin(), a.cos(), b.sin(), b.cos());
    let cab = (a - b).cos();
    let p2 = 2.0 + dist * dist - 2.0 * cab + 2.0 * dist * (sa - sb);
    if p2 >= 0.0 {
        let g = (cb - ca).atan2(dist + sa - sb);
        let (t, p, q) = (wrap(g - a), p2.sqrt(), wrap(b - g));
        offer([Left(t), Straight(p), Left(q)]);
    }
    let p2 = 2.0 + dist * dist - 2.0 * cab + 2.0 * dist * (sb - sa);
    if p2 >= 0.0 {
        let g = (ca - cb).atan2(dist - sa + sb);
        let (t, p, q) = (wrap(a - g), p2.sqrt(), wrap(g - b));
        offer([Right(t), Straight(p), Right(q)]);
    }
    let p2 = -2.0 + dist * dist + 2.0 * cab + 2.0 * dist * (sa + sb);
    if p2 >= 0.0 {
        let p = p2.sqrt();
        let g = (-ca - cb).atan2(dist + sa + sb) - (-2.0f64).atan2(p);
        let (t, q) = (wrap(g - a), wrap(g - b));
        offer([Left(t), Straight(p), Right(q)]);
    }
    let p2 = -2.0 + dist * dist + 2.0 * cab - 2.0 * dist * (sa + sb);
    if p2 >= 0.0 {
        let p = p2.sqrt();
        let g = (ca + cb).atan2(dist - sa - sb) - 2.0f64.atan2(p);
        let (t, q) = (wrap(a - g), wrap(b - g));
        offer([Right(t), Straight(p), Left(q)]);
    }
    let c = (6.0 - dist * dist + 2.0 * cab + 2.0 * dist * (sa - sb)) / 8.0;
    if c.abs() <= 1.0 {
        let p = wrap(TAU - c.acos());
        let t = wrap(a - (ca - cb).atan2(dist - sa + sb) + p / 2.0);
        let q = wrap(a - b - t + p);
        offer([Right(t), Left(p), Right(q)]);
    }
    let c = (6.0 - dist * dist + 2.0 * cab + 2.0 * dist * (sb - sa)) / 8.0;
    if c.abs() <= 1.0 {
        let p = wrap(TAU - c.acos());
        let t = wrap(-a + (cb - ca).atan2(dist + sa - sb) + p / 2.0);
        let q = wrap(b - a - t + p);
        offer([Left(t), Right(p), Left(q)]);
    }
}

impl Turn {
    fn of(from: &Pose, radius: f64, pieces: [Piece; 3], slant: &Slant) -> Turn {
        let (mut length, mut curved) = (0.0, 0.0);
        for p in pieces {
            length += p.length() * radius;
            if !matches!(p, Straight(_)) {
                curved += p.length() * radius;
            }
        }
        Turn {
            from: *from,
            radius,
            pieces,
            slant: *slant,
            length,
            curved,
        }
    }

    /// Points along it in plan, no further than `gap` mm apart and turning no more than a tenth of a radian from one to the next (on the
    /// plane it is drawn on); both ends among them.
    pub fn points(&self, gap: f64) -> Vec<Point2> {
        self.drawn(gap)
            .iter()
            .map(|p| Point2::from(self.slant.lower(p.coords)))
            .collect()
    }

    fn drawn(&self, gap: f64) -> Vec<Point2> {
        let mut out = vec![self.from.at];
        let (mut at, mut heading) = (self.from.at, angle(&self.from.heading));
        let r = self.radius;
        for piece in self.pieces {
            match piece {
                Straight(v) => {
                    let l = v * r;
                    let n = (l / gap).ceil() as usize;
                    let u = Vector2::new(heading.cos(), heading.sin());
                    out.extend((1..=n).map(|k| at + u * (l * k as f64 / n as f64)));
                    at += u * l;
                }
                Left(v) | Right(v) => {
                    let side = if matches!(piece, Left(_)) { 1.0 } else { -1.0 };
                    let n = ((v * r / gap).max(v / 0.1)).ceil() as usize;
                    let center = at + Vector2::new(-heading.sin(), heading.cos()) * (side * r);
                    let place = |h: f64| center + Vector2::new(h.sin(), -h.cos()) * (side * r);
                    out.extend((1..=n).map(|k| place(heading + side * v * k as f64 / n as f64)));
                    heading += side * v;
                    at = place(heading);
                }
            }
        }
        out
    }

    /// Where it begins and ends, in plan.
    pub fn ends(&self) -> (Pose, Pose) {
        let back = self.reversed().from;
        let plan = |p: &Pose, way: f64| {
            let heading = self.slant.lower(p.heading) * way;
            Pose {
                at: Point2::from(self.slant.lower(p.at.coords)),
                heading: heading / heading.norm().max(1e-300),
            }
        };
        (plan(&self.from, 1.0), plan(&back, -1.0))
    }

    /// The same way gone backwards.
    pub fn reversed(&self) -> Turn {
        let mut heading = angle(&self.from.heading);
        let mut at = self.from.at;
        for piece in self.pieces {
            (at, heading) = self.after(piece, at, heading);
        }
        let back = |p: Piece| match p {
            Left(v) => Right(v),
            Right(v) => Left(v),
            Straight(v) => Straight(v),
        };
        Turn {
            from: Pose {
                at,
                heading: -Vector2::new(heading.cos(), heading.sin()),
            },
            pieces: [
                back(self.pieces[2]),
                back(self.pieces[1]),
                back(self.pieces[0]),
            ],
            ..self.clone()
        }
    }

    fn after(&self, piece: Piece, at: Point2, heading: f64) -> (Point2, f64) {
        let r = self.radius;
        let (v, side) = match piece {
            Straight(v) => {
                return (
                    at + Vector2::new(heading.cos(), heading.sin()) * (v * r),
                    heading,
                );
            }
            Left(v) => (v, 1.0),
            Right(v) => (v, -1.0),
        };
        let center = at + Vector2::new(-heading.sin(), heading.cos()) * (side * r);
        let h = heading + side * v;
        (center + Vector2::new(h.sin(), -h.cos()) * (side * r), h)
    }

    /// Radius it was drawn with, mm.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Tightest radius on it, mm; infinite for a straight way.
    pub fn tightest(&self) -> f64 {
        if self.curved > 1e-9 {
            self.radius
        } else {
            f64::INFINITY
        }
    }
}

fn angle(v: &Vector2) -> f64 {
    v.y.atan2(v.x)
}

/// Into 0 .. 2 pi; what is a rounding error short of a full turn is none.
fn wrap(a: f64) -> f64 {
    let w = a.rem_euclid(TAU);
    if TAU - w < 1e-9 { 0.0 } else { w }
}

/// Turn from one heading to another, radians, 0 .. pi.
pub fn bend(a: &Vector2, b: &Vector2) -> f64 {
    let (na, nb) = (a.norm(), b.norm());
    if na > 0.0 && nb > 0.0 {
        (a.dot(b) / (na * nb)).clamp(-1.0, 1.0).acos()
    } else {
        0.0
    }
    .min(PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pose(x: f64, y: f64, a: f64) -> Pose {
        Pose {
            at: Point2::new(x, y),
            heading: Vector2::new(a.cos(), a.sin()),
        }
    }

    #[test]
    fn a_u_turn_is_half_a_circle_and_a_straight_way_is_straight() {
        let flat = Slant::default();
        let t = turn(&flat, &pose(0.0, 0.0, 0.0), &pose(0.0, 0.7, PI), 0.35);
        assert!((t.length - 0.35 * PI).abs() < 1e-9, "{t:?}");
        let t = turn(
            &flat,
            &pose(0.0, 0.0, 0.3),
            &pose(3.0 * 0.3f64.cos(), 3.0 * 0.3f64.sin(), 0.3),
            0.35,
        );
        assert!((t.length - 3.0).abs() < 1e-9 && t.curved < 1e-6, "{t:?}");
    }

    #[test]
    fn on_a_slope_a_turn_is_round_on_the_surface() {
        let g = Vector2::new(0.6, -2.0);
        let slant = Slant::of(&g);
        let (from, to) = (pose(1.0, 2.0, 0.4), pose(1.5, 2.6, 3.9));
        let p = turn(&slant, &from, &to, 0.3).points(0.05);
        assert!((p[0] - from.at).norm() < 1e-9 && (p[p.len() - 1] - to.at).norm() < 1e-6);
        let lift = |d: Vector2| crate::geom::Vector::new(d.x, d.y, g.dot(&d));
        for w in p.windows(3) {
            let (u, v) = (lift(w[1] - w[0]), lift(w[2] - w[1]));
            assert!(
                u.norm() < 1e-6 || v.norm() < 1e-6 || u.angle(&v) < 0.11,
                "{w:?}"
            );
        }
        assert!(bend(&(p[1] - p[0]), &from.heading) < 0.2);
    }

    proptest! {
        /// It begins and ends where and as it should, bends no tighter than asked, and is no longer than going round.
        #[test]
        fn turns_join_poses(x in -3.0..3.0f64, y in -3.0..3.0f64, a in 0.0..TAU, b in 0.0..TAU, r in 0.1..1.5f64) {
            let (from, to) = (pose(0.0, 0.0, a), pose(x, y, b));
            let t = turn(&Slant::default(), &from, &to, r);
            let p = t.points(0.05);
            prop_assert!((p[0] - from.at).norm() < 1e-12);
            prop_assert!((p[p.len() - 1] - to.at).norm() < 1e-6, "{:?} {:?}", p[p.len() - 1], t);
            let length: f64 = p.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
            prop_assert!(length <= t.length + 1e-9 && length > 0.99 * t.length);
            prop_assert!(t.length <= to.at.coords.norm() + 2.0 * TAU * r + 1e-9);
            for w in p.windows(3) {
                let (u, v) = (w[1] - w[0], w[2] - w[1]);
                if u.norm() > 1e-6 && v.norm() > 1e-6 {
                    prop_assert!(bend(&u, &v) < 0.11);
                }
            }
            let back = t.reversed().points(0.05);
            prop_assert!((back[0] - to.at).norm() < 1e-6 && (back[back.len() - 1] - from.at).norm() < 1e-6);
            let n = p.len();
            if n > 1 {
                let first = p[1] - p[0];
                let last = p[n - 1] - p[n - 2];
                if first.norm() > 1e-6 { prop_assert!(bend(&first, &from.heading) < 0.06); }
                if last.norm() > 1e-6 { prop_assert!(bend(&last, &to.heading) < 0.06); }
            }
        }
    }
}
