//! The order of passes: feature by feature, always on to the nearest end.

use super::pass::Pass;
use crate::geom::Point;

/// Puts passes in an order that keeps moves between them short: a feature is finished before the next is begun, and each next pass is
/// the one that can be entered nearest to where the tool is (an open one from either end, a closed one anywhere; ties by place in the
/// list). Passes are turned round or rotated to begin there. O(n^2) in the passes of a feature.
pub fn order(passes: Vec<Pass>, start: Point) -> Vec<Pass> {
    let mut groups: Vec<(Option<usize>, Vec<Pass>)> = Vec::new();
    for p in passes {
        match groups.iter_mut().find(|g| g.0 == p.feature) {
            Some(g) => g.1.push(p),
            None => groups.push((p.feature, vec![p])),
        }
    }
    let mut out = Vec::new();
    let mut at = start;
    while !groups.is_empty() {
        let nearest = (0..groups.len())
            .map(|k| {
                (
                    groups[k]
                        .1
                        .iter()
                        .map(|p| entry(p, &at).0)
                        .fold(f64::INFINITY, f64::min),
                    k,
                )
            })
            .reduce(|a, b| if b.0 < a.0 { b } else { a });
        let Some((_, k)) = nearest else { break };
        let mut left = groups.remove(k).1;
        while !left.is_empty() {
            let best = (0..left.len())
                .map(|i| (entry(&left[i], &at), i))
                .reduce(|a, b| if b.0.0 < a.0.0 { b } else { a });
            let Some(((_, from), i)) = best else { break };
            let mut p = left.remove(i);
            if p.closed {
                p.points.rotate_left(from);
                at = p.points[0];
            } else {
                if from > 0 {
                    p.points.reverse();
                }
                at = p.points[p.points.len() - 1];
            }
            out.push(p);
        }
    }
    out
}

/// Distance (mm) to the nearest point at which a pass can be entered, and its index.
fn entry(p: &Pass, at: &Point) -> (f64, usize) {
    let n = p.points.len();
    let candidates: &mut dyn Iterator<Item = usize> = if p.closed {
        &mut (0..n)
    } else {
        &mut [0, n - 1].into_iter()
    };
    candidates
        .map(|i| ((p.points[i] - at).norm(), i))
        .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
}
