//! More points where a path turns too much between two segments: at a place where the way is smooth, a sharp turn is only a want of
//! points. Where the way itself has a corner, none would help, and none is added.

use super::spread::{Place, angle};
use super::{FitOptions, Rest};

/// A new point is of use when it lies this far off the chord it replaces, in last decimals.
const OFF: f64 = 0.8;
/// Chords shorter than this many last decimals are not split: rounding would bend their halves as much as they are eased.
const SHORTEST: f64 = 36.0;
/// Rounds of splitting.
const ROUNDS: usize = 3;

/// Adds vertices (places on a run of rests, each with whether it stands at a cliff) beside those at which the path turns too sharply.
pub(super) fn ease(
    rests: &[Rest],
    places: Vec<(Place, bool)>,
    options: &FitOptions,
) -> Vec<(Place, bool)> {
    let mut places = places;
    for _ in 0..ROUNDS {
        let n = places.len();
        let mut split = vec![false; n];
        for i in 1..n.saturating_sub(1) {
            let (a, b, c) = (&places[i - 1], &places[i], &places[i + 1]);
            if b.1 {
                continue;
            }
            if angle(&(b.0.at - a.0.at), &(c.0.at - b.0.at)) > options.turn {
                split[i - 1] = true;
                split[i] = true;
            }
        }
        let mut out = Vec::with_capacity(n + 8);
        let mut any = false;
        for (i, place) in places.iter().enumerate() {
            out.push(*place);
            if split[i]
                && let Some(next) = places.get(i + 1)
                && let Some(m) = between(rests, &place.0, &next.0, options.decimal)
            {
                out.push((m, false));
                any = true;
            }
        }
        places = out;
        if !any {
            break;
        }
    }
    places
}

/// The rest nearest the middle of a chord's way, if it lies off the chord.
fn between(rests: &[Rest], a: &Place, b: &Place, decimal: f64) -> Option<Place> {
    let e = b.at - a.at;
    let length = e.norm();
    if length < SHORTEST * decimal {
        return None;
    }
    let along = |index: usize| (rests[index].center - a.at).dot(&e) / (length * length);
    let index = (a.index + 1..=b.index.min(rests.len().saturating_sub(1)))
        .filter(|&i| along(i) > 0.2 && along(i) < 0.8)
        .min_by(|&i, &j| {
            (along(i) - 0.5)
                .abs()
                .total_cmp(&(along(j) - 0.5).abs())
                .then(i.cmp(&j))
        })?;
    let at = rests[index].center;
    let off = (at - a.at - e * along(index)).norm();
    (off > OFF * decimal).then_some(Place { index, at })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Point, Vector};

    fn rests(points: impl Iterator<Item = Point>) -> Vec<Rest> {
        points
            .map(|center| Rest {
                center,
                normal: Vector::z(),
            })
            .collect()
    }

    fn eased(rests: &[Rest], vertices: &[usize]) -> Vec<Point> {
        let options = FitOptions::for_scallop(0.02, 3.0);
        let places = vertices
            .iter()
            .map(|&index| {
                let at = rests[index].center;
                (Place { index, at }, false)
            })
            .collect();
        ease(rests, places, &options)
            .iter()
            .map(|p| p.0.at)
            .collect()
    }

    #[test]
    fn an_arc_gets_points_and_a_corner_none() {
        let arc = rests((0..=60).map(|k| {
            let a = f64::from(k) * 0.05;
            Point::new(0.2 * a.cos(), 0.2 * a.sin(), 0.0)
        }));
        let after = eased(&arc, &[0, 15, 30, 45, 60]);
        assert!(after.len() > 9, "{}", after.len());
        let limit = 0.25;
        assert!(
            after
                .windows(3)
                .all(|w| angle(&(w[1] - w[0]), &(w[2] - w[1])) < limit)
        );
        let corner = rests((0..=40).map(|k| {
            let t = f64::from(k) * 0.01;
            Point::new(t.min(0.2), (t - 0.2).max(0.0), 0.0)
        }));
        assert_eq!(eased(&corner, &[0, 20, 40]).len(), 3);
    }
}
