//! The middle lines of a blob of cells: thinned, then walked as few long paths.
//!
//! Thinning after T. Y. Zhang and C. Y. Suen, *A fast parallel algorithm for thinning digital patterns*, CACM 27 (1984).

use std::collections::VecDeque;

/// Cells around one, counter-clockwise from +x.
const RING: [(i64, i64); 8] = [
    (1, 0),
    (1, 1),
    (0, 1),
    (-1, 1),
    (-1, 0),
    (-1, -1),
    (0, -1),
    (1, -1),
];

/// A small mask with one empty cell of margin all round.
struct Mask {
    first: [i64; 2],
    size: [i64; 2],
    on: Vec<bool>,
}

impl Mask {
    fn new(cells: &[(i64, i64)]) -> Mask {
        let (mut lo, mut hi) = ([i64::MAX; 2], [i64::MIN; 2]);
        for &(x, y) in cells {
            lo = [lo[0].min(x), lo[1].min(y)];
            hi = [hi[0].max(x), hi[1].max(y)];
        }
        let size = [hi[0] - lo[0] + 3, hi[1] - lo[1] + 3];
        let mut m = Mask {
            first: [lo[0] - 1, lo[1] - 1],
            size,
            on: vec![false; (size[0] * size[1]) as usize],
        };
        for &(x, y) in cells {
            let i = m.index(x, y);
            m.on[i] = true;
        }
        m
    }

    fn index(&self, x: i64, y: i64) -> usize {
        ((y - self.first[1]) * self.size[0] + x - self.first[0]) as usize
    }

    fn has(&self, x: i64, y: i64) -> bool {
        self.on[self.index(x, y)]
    }
}

/// Middle lines of a set of distinct cells (each connected blob on its own), as runs of neighbouring cells, longest first within a
/// blob; side branches shorter than `shortest` cells are dropped, but every blob keeps one run. Deterministic.
pub fn middle_lines(cells: &[(i64, i64)], shortest: usize) -> Vec<Vec<(i64, i64)>> {
    if cells.is_empty() {
        return Vec::new();
    }
    let mut mask = Mask::new(cells);
    let mut left: Vec<(i64, i64)> = cells.to_vec();
    left.sort_unstable_by_key(|c| (c.1, c.0));
    thin(&mut mask, &mut left);
    let mut lines = Vec::new();
    let mut main = true;
    // Longest paths first; what they pass is struck out, and the rest is looked at again.
    while !left.is_empty() {
        let mut next: Vec<(i64, i64)> = Vec::new();
        let mut seen = Mask::new(&left);
        seen.on.iter_mut().for_each(|s| *s = false);
        for &c in &left {
            if seen.has(c.0, c.1) || !mask.has(c.0, c.1) {
                continue;
            }
            let (far, blob) = farthest(&mask, c, &mut seen);
            let path = path_from(&mask, far);
            if path.len() < shortest && !main {
                blob.iter().for_each(|b| {
                    let i = mask.index(b.0, b.1);
                    mask.on[i] = false;
                });
                continue;
            }
            for p in &path {
                for d in std::iter::once((0, 0)).chain(RING) {
                    let i = mask.index(p.0 + d.0, p.1 + d.1);
                    mask.on[i] = false;
                }
            }
            lines.push(path);
            next.extend(blob.iter().filter(|b| mask.has(b.0, b.1)));
        }
        main = false;
        next.sort_unstable_by_key(|c| (c.1, c.0));
        left = next;
    }
    lines
}

fn thin(mask: &mut Mask, left: &mut Vec<(i64, i64)>) {
    loop {
        let mut changed = false;
        for phase in 0..2 {
            let gone: Vec<(i64, i64)> = left
                .iter()
                .copied()
                .filter(|&(x, y)| {
                    let n: [bool; 8] = RING.map(|(u, v)| mask.has(x + u, y + v));
                    let count = n.iter().filter(|b| **b).count();
                    let rises = (0..8).filter(|&k| !n[k] && n[(k + 1) % 8]).count();
                    let [e, _, no, _, w, _, s, _] = n;
                    let open = if phase == 0 {
                        !(e && s && (no || w))
                    } else {
                        !(no && w && (e || s))
                    };
                    (2..=6).contains(&count) && rises == 1 && open
                })
                .collect();
            if gone.is_empty() {
                continue;
            }
            changed = true;
            for &(x, y) in &gone {
                let i = mask.index(x, y);
                mask.on[i] = false;
            }
            left.retain(|&(x, y)| mask.has(x, y));
        }
        if !changed {
            return;
        }
    }
}

/// The cell of a blob farthest from `start` (in steps), and the whole blob; marks it seen.
fn farthest(mask: &Mask, start: (i64, i64), seen: &mut Mask) -> ((i64, i64), Vec<(i64, i64)>) {
    let mut queue = VecDeque::from([start]);
    let mut blob = Vec::new();
    let mut last = start;
    let i = seen.index(start.0, start.1);
    seen.on[i] = true;
    while let Some(c) = queue.pop_front() {
        last = c;
        blob.push(c);
        for (u, v) in RING {
            let d = (c.0 + u, c.1 + v);
            if !mask.has(d.0, d.1) {
                continue;
            }
            let i = seen.index(d.0, d.1);
            if !seen.on[i] {
                seen.on[i] = true;
                queue.push_back(d);
            }
        }
    }
    (last, blob)
}

/// The path from a cell to the one farthest from it in its blob.
fn path_from(mask: &Mask, start: (i64, i64)) -> Vec<(i64, i64)> {
    let none = u32::MAX;
    let mut from = vec![none; mask.on.len()];
    let mut queue = VecDeque::from([start]);
    from[mask.index(start.0, start.1)] = mask.index(start.0, start.1) as u32;
    let mut last = start;
    while let Some(c) = queue.pop_front() {
        last = c;
        for (u, v) in RING {
            let d = (c.0 + u, c.1 + v);
            let i = mask.index(d.0, d.1);
            if mask.on[i] && from[i] == none {
                from[i] = mask.index(c.0, c.1) as u32;
                queue.push_back(d);
            }
        }
    }
    let mut path = Vec::new();
    let mut i = mask.index(last.0, last.1);
    loop {
        let k = i as i64;
        path.push((
            k % mask.size[0] + mask.first[0],
            k / mask.size[0] + mask.first[1],
        ));
        if from[i] as usize == i {
            return path;
        }
        i = from[i] as usize;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_has_one_line_along_its_middle() {
        let cells: Vec<(i64, i64)> = (0..40).flat_map(|x| (0..5).map(move |y| (x, y))).collect();
        let lines = middle_lines(&cells, 4);
        assert_eq!(lines.len(), 1);
        assert!(
            lines[0].len() > 32 && lines[0].iter().all(|c| (1..=3).contains(&c.1)),
            "{lines:?}"
        );
    }

    #[test]
    fn a_single_cell_and_two_blobs_keep_one_run_each() {
        assert_eq!(middle_lines(&[(7, -3)], 4), vec![vec![(7, -3)]]);
        assert_eq!(middle_lines(&[(0, 0), (10, 0), (11, 0)], 4).len(), 2);
    }

    #[test]
    fn a_cross_is_a_long_line_and_two_arms() {
        let mut cells: Vec<(i64, i64)> = (-20..=20)
            .map(|x| (x, 0))
            .chain((1..=20).flat_map(|y| [(0, y), (0, -y)]))
            .collect();
        cells.sort_unstable();
        let lines = middle_lines(&cells, 4);
        assert_eq!(lines.len(), 3);
        let total: usize = lines.iter().map(Vec::len).sum();
        assert!((76..=81).contains(&total), "{total}");
    }
}
