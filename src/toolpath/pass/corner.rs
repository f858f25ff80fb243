//! Corners of level curves, where fronts met: rounded until a machine can take them at feed. The cusp this leaves is filled later.
//!
//! Bends are measured on the surface, not in plan: on a slope a wide bend in plan is a tight one where the way turns downhill.

use crate::geom::{Point2, Vector, Vector2};
use crate::toolpath::fit::resample;
use crate::toolpath::link::turn::bend;

/// How far corners are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// Nowhere shall the way bend tighter than this on the surface, mm.
    pub radius: f64,
    /// Rounds of evening out that a corner may take.
    pub rounds: usize,
    /// Points are spread evenly again in between, so that the tip of a finger too narrow to turn in is eaten until it is wide enough;
    /// else such a tip only becomes as round as its own points allow.
    pub eats_tips: bool,
}

/// Rounds after which tight places are looked for anew where tips are eaten.
const BOUT: usize = 12;

/// Rounds a curve of evenly spaced points until it nowhere bends tighter than asked, as far as the rounds can get it. `slope` is the
/// gradient of the surface at a place in plan. Ends stay. Points away from corners are not touched, but for an even spacing where tips are
/// eaten.
pub fn round_corners(
    curve: Vec<Point2>,
    closed: bool,
    how: &Rounding,
    slope: &mut dyn FnMut(&Point2) -> Vector2,
) -> Vec<Point2> {
    let mut curve = curve;
    let gap = mean_gap(&curve);
    if curve.len() < 3 || gap <= 0.0 || how.radius <= 0.0 {
        return curve;
    }
    let bout = if how.eats_tips { BOUT } else { how.rounds };
    let mut left = how.rounds;
    while left > 0 {
        if !even_out(&mut curve, closed, gap, how.radius, bout.min(left), slope) {
            break;
        }
        left = left.saturating_sub(bout);
        if how.eats_tips {
            curve = resample(&curve, closed, gap);
            if curve.len() < 3 {
                break;
            }
        }
    }
    curve
}

fn mean_gap(curve: &[Point2]) -> f64 {
    let n = curve.len();
    if n < 2 {
        return 0.0;
    }
    curve.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>() / (n - 1) as f64
}

/// On slopes up to this (rise over run) a bend in plan is measured as it is on the surface; steeper ground counts as so steep.
const STEEPEST: f64 = 5.0;
/// A bend in plan below this share of what is allowed is not looked at on the surface.
const PLAIN: f64 = 0.1;

/// Evens out tight places for some rounds; true if there were any.
fn even_out(
    curve: &mut [Point2],
    closed: bool,
    gap: f64,
    radius: f64,
    rounds: usize,
    slope: &mut dyn FnMut(&Point2) -> Vector2,
) -> bool {
    let n = curve.len();
    // A corner is spread over the arc that rounds it.
    let spread = ((0.5 * radius / gap).ceil() as usize).clamp(1, 12);
    let inner = |i: usize| closed || (i > 0 && i + 1 < n);
    // Gradients as they are asked for: a place moves by less than the surface turns.
    let mut slopes: Vec<Option<Vector2>> = vec![None; n];
    let mut tight = vec![false; n];
    let mut ever = false;
    // Places whose bend may have changed.
    let mut look: Vec<usize> = (0..n).filter(|&i| inner(i)).collect();
    for _ in 0..rounds {
        tight.fill(false);
        let mut any = false;
        for &i in &look {
            let (p, q, r) = (&curve[(i + n - 1) % n], &curve[i], &curve[(i + 1) % n]);
            let (u, v) = (q - p, r - q);
            if bend(&u, &v) < PLAIN * (gap / radius).min(1.0) {
                continue;
            }
            let g = *slopes[i].get_or_insert_with(|| slope(q).cap_magnitude(STEEPEST));
            let lift = |d: &Vector2| Vector::new(d.x, d.y, g.dot(d));
            let (u, v) = (lift(&u), lift(&v));
            let way = (0.5 * (u.norm() + v.norm())).max(gap);
            if u.angle(&v) > (way / radius).min(1.0) {
                any = true;
                for k in 0..=2 * spread {
                    let j = i as i64 + k as i64 - spread as i64;
                    if closed {
                        tight[j.rem_euclid(n as i64) as usize] = true;
                    } else if j > 0 && (j as usize) + 1 < n {
                        tight[j as usize] = true;
                    }
                }
            }
        }
        if !any {
            return ever;
        }
        ever = true;
        let old = curve.to_vec();
        for i in (0..n).filter(|&i| tight[i] && inner(i)) {
            let (p, q, r) = (&old[(i + n - 1) % n], &old[i], &old[(i + 1) % n]);
            curve[i] = Point2::from((p.coords + q.coords * 2.0 + r.coords) * 0.25);
        }
        let moved = |i: usize| tight[(i + n - 1) % n] || tight[i] || tight[(i + 1) % n];
        look = (0..n).filter(|&i| inner(i) && moved(i)).collect();
    }
    ever
}

/// Bends sharper than this get points in between, rad.
const BENT: f64 = 0.04;

/// A curve of evenly spaced points with more of them where it bends, on a smooth curve through those that are there (four-point scheme
/// of N. Dyn, D. Levin, J. A. Gregory, CAGD 4 (1987)): twice halved.
pub fn refined(curve: &[Point2], closed: bool) -> Vec<Point2> {
    let once = halved(curve, closed);
    halved(&once, closed)
}

fn halved(curve: &[Point2], closed: bool) -> Vec<Point2> {
    let n = curve.len();
    if n < 3 {
        return curve.to_vec();
    }
    let at = |i: i64| -> Point2 {
        if closed {
            curve[i.rem_euclid(n as i64) as usize]
        } else if i < 0 {
            // Beyond its ends an open curve goes straight on.
            curve[0] + (curve[0] - curve[1])
        } else if i as usize >= n {
            curve[n - 1] + (curve[n - 1] - curve[n - 2])
        } else {
            curve[i as usize]
        }
    };
    let bent = |i: i64| bend(&(at(i) - at(i - 1)), &(at(i + 1) - at(i))) > BENT;
    let edges = if closed { n } else { n - 1 };
    let mut out = Vec::with_capacity(2 * n);
    for (i, point) in curve.iter().enumerate() {
        out.push(*point);
        if i >= edges {
            continue;
        }
        let k = i as i64;
        let (p, q, r, s) = (at(k - 1), at(k), at(k + 1), at(k + 2));
        let l = (r - q).norm();
        if l <= 0.0 || !(bent(k) || bent(k + 1)) {
            continue;
        }
        // Where neighbours are not about as long as each other the scheme would overshoot.
        let even = [(q - p).norm(), (s - r).norm()]
            .iter()
            .all(|e| *e < 2.5 * l && *e > 0.4 * l);
        out.push(if even {
            Point2::from(((q.coords + r.coords) * 9.0 - p.coords - s.coords) / 16.0)
        } else {
            nalgebra::center(&q, &r)
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(curve: &[Point2], closed: bool, radius: f64, g: Vector2) -> Vec<Point2> {
        let how = Rounding {
            radius,
            rounds: 200,
            eats_tips: false,
        };
        round_corners(curve.to_vec(), closed, &how, &mut |_| g)
    }

    fn right_angle() -> Vec<Point2> {
        let mut c: Vec<Point2> = (0..=50).map(|k| Point2::new(k as f64 * 0.1, 0.0)).collect();
        c.extend((1..=50).map(|k| Point2::new(5.0, k as f64 * 0.1)));
        c
    }

    #[test]
    fn a_right_angle_becomes_an_arc_and_the_rest_stays() {
        let before = right_angle();
        let c = rounded(&before, false, 0.5, Vector2::zeros());
        for w in c.windows(3) {
            assert!(bend(&(w[1] - w[0]), &(w[2] - w[1])) < 0.1 / 0.5 + 0.02);
        }
        // The corner is cut by no more than an arc of a little over that radius would.
        let near = c
            .iter()
            .map(|p| (p - Point2::new(5.0, 0.0)).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(near > 0.15 && near < 0.6, "{near}");
        assert_eq!(c[..20], before[..20]);
        assert_eq!(c[80..], before[80..]);
    }

    #[test]
    fn a_wide_circle_is_left_alone() {
        let before: Vec<Point2> = (0..100)
            .map(|k| {
                let a = k as f64 * std::f64::consts::TAU / 100.0;
                Point2::new(2.0 * a.cos(), 2.0 * a.sin())
            })
            .collect();
        assert_eq!(rounded(&before, true, 0.5, Vector2::zeros()), before);
    }

    #[test]
    fn on_a_slope_the_bend_on_the_surface_counts() {
        // Half a circle of radius 0.6 in plan, from uphill to downhill on a slope of 2: there its top is an ellipse's end,
        // 0.6 (1 + 4) times as tight: radius 0.27.
        let half: Vec<Point2> = (0..=19)
            .map(|k| {
                let a = k as f64 * std::f64::consts::PI / 19.0;
                Point2::new(0.6 * a.cos(), 0.6 * a.sin())
            })
            .collect();
        let mut c: Vec<Point2> = (0..30)
            .map(|k| Point2::new(0.6, (k as f64 - 30.0) * 0.1))
            .collect();
        c.extend(half);
        c.extend((1..=30).map(|k| Point2::new(-0.6, k as f64 * -0.1)));
        assert_eq!(rounded(&c, false, 0.5, Vector2::zeros()), c);
        let g = Vector2::new(0.0, 2.0);
        let on = rounded(&c, false, 0.5, g);
        let lift = |d: Vector2| Vector::new(d.x, d.y, g.dot(&d));
        let tightest = |c: &[Point2]| {
            c.windows(3)
                .map(|w| {
                    let (u, v) = (lift(w[1] - w[0]), lift(w[2] - w[1]));
                    0.5 * (u.norm() + v.norm()) / u.angle(&v).max(1e-12)
                })
                .fold(f64::INFINITY, f64::min)
        };
        // As far as its points, which draw together there, allow.
        assert!(tightest(&c) < 0.3, "{}", tightest(&c));
        assert!(tightest(&on) > 0.35, "{}", tightest(&on));
    }

    #[test]
    fn the_tip_of_a_narrow_finger_is_eaten_until_it_is_wide_enough() {
        // Two walls 0.02 mm apart at the tip and 2 mm at the other end, 5 mm on: the way up one and down the other.
        let side = |t: f64, s: f64| Point2::new(5.0 * t, s * (1.0 - 0.99 * t));
        let mut c: Vec<Point2> = (0..=50).map(|k| side(k as f64 / 50.0, 1.0)).collect();
        c.extend((0..=50).rev().map(|k| side(k as f64 / 50.0, -1.0)));
        let how = Rounding {
            radius: 0.2,
            rounds: 240,
            eats_tips: true,
        };
        let c = round_corners(c, false, &how, &mut |_| Vector2::zeros());
        for w in c.windows(3) {
            let (u, v) = (w[1] - w[0], w[2] - w[1]);
            assert!(bend(&u, &v) < 0.62, "{w:?}");
            assert!(u.norm() > 0.04, "{w:?}");
        }
    }

    #[test]
    fn refining_keeps_the_points_and_halves_the_bends() {
        let circle: Vec<Point2> = (0..24)
            .map(|k| {
                let a = k as f64 * std::f64::consts::TAU / 24.0;
                Point2::new(a.cos(), a.sin())
            })
            .collect();
        let fine = refined(&circle, true);
        assert_eq!(fine.len(), 96);
        assert!(fine.iter().step_by(4).eq(circle.iter()));
        assert!(fine.iter().all(|p| (p.coords.norm() - 1.0).abs() < 1e-3));
        let straight: Vec<Point2> = (0..9).map(|k| Point2::new(k as f64, 0.0)).collect();
        assert_eq!(refined(&straight, false), straight);
    }
}
