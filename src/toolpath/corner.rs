//! Corners of level curves, where fronts met: rounded until a machine can take them at feed. The cusp this leaves is filled later.

use super::turn::bend;
use crate::geom::Point2;

/// Rounds a curve of evenly spaced points until it nowhere bends tighter than `radius` (mm) between two of them, as far as `rounds` of
/// evening out the places that do can get it. Ends stay. Points away from corners are not touched.
pub fn round_corners(curve: &mut [Point2], closed: bool, radius: f64, rounds: usize) {
    let n = curve.len();
    if n < 3 {
        return;
    }
    let gap = curve.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>() / (n - 1) as f64;
    if gap <= 0.0 {
        return;
    }
    let limit = (gap / radius).min(1.0);
    // A corner is spread over the arc that rounds it.
    let spread = ((0.5 * radius / gap).ceil() as usize).clamp(1, 12);
    let inner = |i: usize| closed || (i > 0 && i + 1 < n);
    let mut tight = vec![false; n];
    for _ in 0..rounds {
        tight.fill(false);
        let mut any = false;
        for i in (0..n).filter(|&i| inner(i)) {
            let (p, q, r) = (&curve[(i + n - 1) % n], &curve[i], &curve[(i + 1) % n]);
            if bend(&(q - p), &(r - q)) > limit {
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
            return;
        }
        let old = curve.to_vec();
        for i in (0..n).filter(|&i| tight[i] && inner(i)) {
            let (p, q, r) = (&old[(i + n - 1) % n], &old[i], &old[(i + 1) % n]);
            curve[i] = Point2::from((p.coords + q.coords * 2.0 + r.coords) * 0.25);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_angle_becomes_an_arc_and_the_rest_stays() {
        let mut c: Vec<Point2> = (0..=50).map(|k| Point2::new(k as f64 * 0.1, 0.0)).collect();
        c.extend((1..=50).map(|k| Point2::new(5.0, k as f64 * 0.1)));
        let before = c.clone();
        round_corners(&mut c, false, 0.5, 200);
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
        let mut c: Vec<Point2> = (0..100)
            .map(|k| {
                let a = k as f64 * std::f64::consts::TAU / 100.0;
                Point2::new(2.0 * a.cos(), 2.0 * a.sin())
            })
            .collect();
        let before = c.clone();
        round_corners(&mut c, true, 0.5, 200);
        assert_eq!(c, before);
    }
}
