//! Strokes: where passes turn a sharp corner one beside the other, each corner leaves a small spot that stands over, and the spots lie
//! in a row. One stroke along the row cuts them all; a bit for each would cost a link each.

use crate::geom::{Point2, Vector2};

/// Spots wider than this share of a stepover are not for strokes: they lie along a pass.
const WIDEST: f64 = 0.9;
/// The next spot of a row is no further than this many stepovers.
const NEXT: f64 = 2.0;
/// A row bends by no more than this from spot to spot (cosine).
const STRAIGHT: f64 = 0.5;
/// Rows shorter than this many spots are left to bits.
const FEWEST: usize = 3;

struct Spot {
    at: Point2,
    cells: usize,
}

/// Rows among the cells (lattice columns and rows, sorted and distinct) that stand over; `stepover` in cells. Each row is a curve in
/// cell coordinates through the middles of its spots, and a little beyond them. Deterministic; about n log n.
pub fn strokes(cells: &[(i64, i64)], stepover: f64) -> Vec<Vec<Point2>> {
    let spots = spots(cells, WIDEST * stepover);
    let mut order: Vec<usize> = (0..spots.len()).collect();
    order.sort_by(|&a, &b| {
        spots[b]
            .cells
            .cmp(&spots[a].cells)
            .then(spots[a].at.x.total_cmp(&spots[b].at.x))
            .then(spots[a].at.y.total_cmp(&spots[b].at.y))
    });
    let buckets = Buckets::new(&spots, NEXT * stepover);
    let mut used = vec![false; spots.len()];
    let mut out = Vec::new();
    for first in order {
        if used[first] {
            continue;
        }
        used[first] = true;
        let mut row = vec![first];
        for end in 0..2 {
            if end == 1 {
                row.reverse();
            }
            while let Some(next) = follow(&spots, &buckets, &used, &row, stepover) {
                used[next] = true;
                row.push(next);
            }
        }
        if row.len() < FEWEST {
            // The spots may still belong to another row.
            row[1..].iter().for_each(|&i| used[i] = false);
            continue;
        }
        let mut curve: Vec<Point2> = row.iter().map(|&i| spots[i].at).collect();
        let n = curve.len();
        let reach = |a: &Point2, b: &Point2| a + (a - b).normalize() * (0.3 * stepover);
        let (head, tail) = (
            reach(&curve[0], &curve[1]),
            reach(&curve[n - 1], &curve[n - 2]),
        );
        curve.insert(0, head);
        curve.push(tail);
        out.push(curve);
    }
    out
}

/// The spot that goes on a row best: near, and straight on.
fn follow(
    spots: &[Spot],
    buckets: &Buckets,
    used: &[bool],
    row: &[usize],
    stepover: f64,
) -> Option<usize> {
    let n = row.len();
    let at = spots[row[n - 1]].at;
    let heading: Option<Vector2> = (n > 1).then(|| {
        let back = row[n.saturating_sub(4)];
        (at - spots[back].at).normalize()
    });
    let mut best: Option<(f64, usize)> = None;
    for i in buckets.near(&at) {
        let d = spots[i].at - at;
        let l = d.norm();
        if used[i] || l < 0.3 * stepover || l > NEXT * stepover {
            continue;
        }
        let straight = heading.map_or(1.0, |h| h.dot(&d) / l);
        if straight < STRAIGHT {
            continue;
        }
        let cost = l * (2.0 - straight);
        if best.is_none_or(|b| cost < b.0) {
            best = Some((cost, i));
        }
    }
    best.map(|b| b.1)
}

/// Connected groups of cells no wider than `widest` cells, in the order of their first cells.
fn spots(cells: &[(i64, i64)], widest: f64) -> Vec<Spot> {
    let mut seen = vec![false; cells.len()];
    let mut out = Vec::new();
    let key = |c: &(i64, i64)| (c.1, c.0);
    for i in 0..cells.len() {
        if seen[i] {
            continue;
        }
        seen[i] = true;
        let mut group = vec![i];
        let mut k = 0;
        while k < group.len() {
            let (x, y) = cells[group[k]];
            k += 1;
            for v in -1..=1 {
                for u in -1..=1 {
                    let c = (x + u, y + v);
                    if let Ok(j) = cells.binary_search_by_key(&key(&c), key)
                        && !seen[j]
                    {
                        seen[j] = true;
                        group.push(j);
                    }
                }
            }
        }
        let (mut lo, mut hi, mut sum) = ([i64::MAX; 2], [i64::MIN; 2], [0i64; 2]);
        for &j in &group {
            let c = [cells[j].0, cells[j].1];
            for a in 0..2 {
                lo[a] = lo[a].min(c[a]);
                hi[a] = hi[a].max(c[a]);
                sum[a] += c[a];
            }
        }
        let wide = ((hi[0] - lo[0] + 1) as f64).hypot((hi[1] - lo[1] + 1) as f64);
        if wide <= widest {
            let n = group.len() as f64;
            out.push(Spot {
                at: Point2::new(sum[0] as f64 / n, sum[1] as f64 / n),
                cells: group.len(),
            });
        }
    }
    out
}

/// Spots by square, to look only at near ones.
struct Buckets {
    size: f64,
    sorted: Vec<((i64, i64), usize)>,
}

impl Buckets {
    fn new(spots: &[Spot], size: f64) -> Buckets {
        let mut b = Buckets {
            size: size.max(1.0),
            sorted: Vec::new(),
        };
        b.sorted = spots
            .iter()
            .enumerate()
            .map(|(i, s)| (b.square(&s.at), i))
            .collect();
        b.sorted.sort_unstable();
        b
    }

    fn square(&self, p: &Point2) -> (i64, i64) {
        (
            (p.x / self.size).floor() as i64,
            (p.y / self.size).floor() as i64,
        )
    }

    fn near(&self, p: &Point2) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = self.square(p);
        (-1..=1)
            .flat_map(move |u| (-1..=1).map(move |v| (x + u, y + v)))
            .flat_map(move |q| {
                let from = self.sorted.partition_point(|s| s.0 < q);
                self.sorted[from..]
                    .iter()
                    .take_while(move |s| s.0 == q)
                    .map(|s| s.1)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blob(out: &mut Vec<(i64, i64)>, x: i64, y: i64) {
        for v in -1..=1 {
            for u in -1..=1 {
                out.push((x + u, y + v));
            }
        }
    }

    #[test]
    fn a_row_of_spots_is_one_stroke_and_lone_or_long_ones_are_none() {
        let mut cells = Vec::new();
        for k in 0..10 {
            blob(&mut cells, 10 + 12 * k, 20 + 7 * k);
        }
        blob(&mut cells, 20, 200);
        cells.extend((0..60).map(|x| (100 + x, 300)));
        cells.sort_unstable_by_key(|c| (c.1, c.0));
        let s = strokes(&cells, 14.0);
        assert_eq!(s.len(), 1, "{s:?}");
        assert_eq!(s[0].len(), 12);
        let ends = (s[0][11] - s[0][0]).norm();
        assert!(ends > 9.0 * 12f64.hypot(7.0), "{ends}");
    }
}
