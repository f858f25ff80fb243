//! The order of chains: feature by feature, always on to what can be entered soonest; then the whole tour is improved by turning parts of
//! it round and by moving short stretches elsewhere, across features where that is shorter.

use super::chain::Chain;
use crate::geom::Point;
use crate::toolpath::pass::Pass;

/// Puts chains in an order that keeps moves between them short. Chains are turned round, and single loops rotated, to begin where they
/// are entered. O(n^2) in the chains of a feature, and a round of improvement O(n^2) in all of them.
pub fn order(chains: Vec<Chain>, start: Point) -> Vec<Chain> {
    let mut groups: Vec<(Option<usize>, Vec<Chain>)> = Vec::new();
    for c in chains {
        let Some(feature) = c.first().map(|p| p.feature) else {
            continue;
        };
        match groups.iter_mut().find(|g| g.0 == feature) {
            Some(g) => g.1.push(c),
            None => groups.push((feature, vec![c])),
        }
    }
    let mut out: Vec<Chain> = Vec::new();
    let mut at = start;
    while !groups.is_empty() {
        let nearest = (0..groups.len())
            .map(|k| {
                (
                    groups[k]
                        .1
                        .iter()
                        .map(|c| entry(c, &at).0)
                        .fold(f64::INFINITY, f64::min),
                    k,
                )
            })
            .reduce(|a, b| if b.0 < a.0 { b } else { a });
        let Some((_, k)) = nearest else { break };
        let tour = greedy(groups.remove(k).1, at);
        if let Some(end) = tour.last().and_then(end_of) {
            at = end;
        }
        out.extend(tour);
    }
    shorter(out, &start)
}

/// Always the nearest next (ties by place in the list).
fn greedy(mut left: Vec<Chain>, start: Point) -> Vec<Chain> {
    let mut out = Vec::with_capacity(left.len());
    let mut at = start;
    while !left.is_empty() {
        let best = (0..left.len())
            .map(|i| (entry(&left[i], &at), i))
            .reduce(|a, b| if b.0.0 < a.0.0 { b } else { a });
        let Some(((_, from), i)) = best else { break };
        let mut c = left.remove(i);
        if let [one] = c.as_mut_slice()
            && one.closed
        {
            one.points.rotate_left(from);
        } else if from > 0 {
            c = reversed(c);
        }
        if let Some(end) = end_of(&c) {
            at = end;
        }
        out.push(c);
    }
    out
}

/// Tours longer than this are left as the nearest-neighbour rule made them.
const IMPROVED: usize = 1500;

/// Rounds of improvement at most.
const ROUNDS: usize = 30;
/// Stretches of so many chains are moved elsewhere.
const MOVED: usize = 3;

/// 2-opt and Or-opt: a stretch of the tour is gone the other way round, or moved elsewhere, where that shortens it, until nothing does.
fn shorter(tour: Vec<Chain>, start: &Point) -> Vec<Chain> {
    let n = tour.len();
    if !(2..=IMPROVED).contains(&n) {
        return tour;
    }
    let ends: Vec<[Point; 2]> = tour
        .iter()
        .filter_map(|c| Some([start_of(c)?, end_of(c)?]))
        .collect();
    if ends.len() != n {
        return tour;
    }
    // (chain, backwards)
    let mut at: Vec<(usize, bool)> = (0..n).map(|i| (i, false)).collect();
    let entry = |p: (usize, bool)| ends[p.0][usize::from(p.1)];
    let exit = |p: (usize, bool)| ends[p.0][usize::from(!p.1)];
    for _ in 0..ROUNDS {
        let mut better = false;
        for i in 0..n {
            let before = if i == 0 { *start } else { exit(at[i - 1]) };
            for j in i..n {
                // Reverse at[i..=j].
                let behind = (j + 1 < n).then(|| entry(at[j + 1]));
                let old = (entry(at[i]) - before).norm()
                    + behind.map_or(0.0, |b| (b - exit(at[j])).norm());
                let new = (exit(at[j]) - before).norm()
                    + behind.map_or(0.0, |b| (b - entry(at[i])).norm());
                if new < old - 1e-9 {
                    at[i..=j].reverse();
                    at[i..=j].iter_mut().for_each(|p| p.1 = !p.1);
                    better = true;
                }
            }
        }
        for i in 0..n {
            for length in 1..=MOVED.min(n - i) {
                let j = i + length;
                let before = if i == 0 { *start } else { exit(at[i - 1]) };
                let behind = (j < n).then(|| entry(at[j]));
                let (first, last) = (entry(at[i]), exit(at[j - 1]));
                let saved = (first - before).norm()
                    + behind.map_or(0.0, |b| (b - last).norm() - (b - before).norm());
                // Between at[k - 1] and at[k], outside the stretch.
                let best = (0..=n)
                    .filter(|k| *k < i || *k > j)
                    .flat_map(|k| {
                        let a = if k == 0 { *start } else { exit(at[k - 1]) };
                        let b = (k < n).then(|| entry(at[k]));
                        [(first, last), (last, first)].map(|(x, y)| {
                            let cost =
                                (x - a).norm() + b.map_or(0.0, |b| (b - y).norm() - (b - a).norm());
                            (cost, k, x != first)
                        })
                    })
                    .reduce(|a, b| if b.0 < a.0 { b } else { a });
                if let Some((cost, k, turned)) = best
                    && cost < saved - 1e-9
                {
                    let mut stretch: Vec<(usize, bool)> = at.drain(i..j).collect();
                    if turned {
                        stretch.reverse();
                        stretch.iter_mut().for_each(|p| p.1 = !p.1);
                    }
                    let k = if k > j { k - length } else { k };
                    at.splice(k..k, stretch);
                    better = true;
                }
            }
        }
        if !better {
            break;
        }
    }
    let mut tour: Vec<Option<Chain>> = tour.into_iter().map(Some).collect();
    at.into_iter()
        .filter_map(|(k, back)| {
            let c = tour[k].take()?;
            Some(if back { reversed(c) } else { c })
        })
        .collect()
}

fn reversed(mut c: Chain) -> Chain {
    c.reverse();
    for p in &mut c {
        if p.closed {
            p.points[1..].reverse();
        } else {
            p.points.reverse();
        }
    }
    c
}

fn start_of(c: &Chain) -> Option<Point> {
    c.first()?.points.first().copied()
}

fn end_of(c: &Chain) -> Option<Point> {
    let last: &Pass = c.last()?;
    if last.closed {
        last.points.first().copied()
    } else {
        last.points.last().copied()
    }
}

/// Distance (mm) to the nearest place at which a chain can be entered: 0 for its start, 1 for its end; any point of a single loop.
fn entry(c: &Chain, at: &Point) -> (f64, usize) {
    if let [one] = c.as_slice()
        && one.closed
    {
        return one
            .points
            .iter()
            .enumerate()
            .map(|(i, p)| ((p - at).norm(), i))
            .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
    }
    [start_of(c), end_of(c)]
        .into_iter()
        .enumerate()
        .filter_map(|(i, p)| Some(((p? - at).norm(), i)))
        .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::toolpath::pass::PassKind;

    fn chain(feature: usize, x: f64) -> Chain {
        vec![Pass {
            kind: PassKind::Level,
            feature: Some(feature),
            points: vec![Point::new(x, 0.0, 0.0), Point::new(x + 1.0, 0.0, 0.0)],
            closed: false,
        }]
    }

    /// Two features that lie in one another's gaps are cut in one go past both; nothing is lost.
    #[test]
    fn the_tour_crosses_features_where_that_is_shorter() {
        let chains: Vec<Chain> = [(0, 6.0), (1, 3.0), (0, 0.0), (1, 9.0), (0, 12.0)]
            .map(|(f, x)| chain(f, x))
            .to_vec();
        let out = order(chains, Point::new(-1.0, 0.0, 0.0));
        let begins: Vec<f64> = out.iter().map(|c| c[0].points[0].x).collect();
        assert_eq!(begins, [0.0, 3.0, 6.0, 9.0, 12.0]);
        assert!(out.iter().all(|c| c[0].points[1].x > c[0].points[0].x));
    }
}
