//! The middle lines of a blob of cells: thinned, then walked as few long paths.
//!
//! Thinning after Z. Guo and R. W. Hall, *Parallel thinning with two-subiteration algorithms*, CACM 32 (1989): its first, which leaves a
//! line of every blob. (The older one of Zhang and Suen wipes out squares of even width and leaning bands, and what is wiped out here is
//! a cusp that nobody cuts.)

use crate::geom::RING;

/// No neighbour, not reached.
const NONE: u32 = u32::MAX;

/// A set of cells, each with its neighbours by number. Memory: 40 bytes a cell, however far apart they lie.
struct Blobs {
    /// By row, then by column.
    cells: Vec<(i64, i64)>,
    beside: Vec<[u32; 8]>,
    /// Still in the set.
    on: Vec<bool>,
    /// Scratch: where a search came from; `NONE` between searches.
    from: Vec<u32>,
}

impl Blobs {
    fn new(cells: &[(i64, i64)]) -> Blobs {
        let mut cells = cells.to_vec();
        cells.sort_unstable_by_key(|c| (c.1, c.0));
        let find = |x: i64, y: i64| match cells.binary_search_by_key(&(y, x), |c| (c.1, c.0)) {
            Ok(i) => i as u32,
            Err(_) => NONE,
        };
        let beside = cells
            .iter()
            .map(|&(x, y)| RING.map(|(u, v)| find(x + i64::from(u), y + i64::from(v))))
            .collect();
        Blobs {
            on: vec![true; cells.len()],
            from: vec![NONE; cells.len()],
            beside,
            cells,
        }
    }

    /// The neighbours of a cell that are still in the set.
    fn around(&self, i: u32) -> impl Iterator<Item = u32> + '_ {
        self.beside[i as usize]
            .into_iter()
            .filter(|&j| j != NONE && self.on[j as usize])
    }

    /// All cells that hang together with one, by their distance from it in steps; `from` tells the way back until it is wiped.
    fn spread(&mut self, start: u32) -> Vec<u32> {
        let mut queue = vec![start];
        self.from[start as usize] = start;
        let mut k = 0;
        while k < queue.len() {
            let c = queue[k];
            k += 1;
            for j in self.beside[c as usize] {
                if j != NONE && self.on[j as usize] && self.from[j as usize] == NONE {
                    self.from[j as usize] = c;
                    queue.push(j);
                }
            }
        }
        queue
    }

    fn wipe(&mut self, blob: &[u32]) {
        for &i in blob {
            self.from[i as usize] = NONE;
        }
    }

    /// The path from a cell to the one farthest from it in its blob.
    fn path_from(&mut self, start: u32) -> Vec<u32> {
        let blob = self.spread(start);
        let mut path = Vec::new();
        let mut at = blob[blob.len() - 1];
        loop {
            path.push(at);
            let next = self.from[at as usize];
            if next == at {
                break;
            }
            at = next;
        }
        self.wipe(&blob);
        path
    }

    /// Which neighbours are still in the set, in the order of [`RING`].
    fn ring(&self, i: u32) -> [bool; 8] {
        self.beside[i as usize].map(|j| j != NONE && self.on[j as usize])
    }

    fn thin(&mut self) {
        let mut left: Vec<u32> = (0..self.cells.len() as u32).collect();
        loop {
            let mut changed = false;
            for phase in 0..2 {
                let gone: Vec<u32> = left
                    .iter()
                    .copied()
                    .filter(|&i| goes(self.ring(i), phase))
                    .collect();
                if gone.is_empty() {
                    continue;
                }
                changed = true;
                for &i in &gone {
                    self.on[i as usize] = false;
                }
                left.retain(|&i| self.on[i as usize]);
            }
            if !changed {
                return;
            }
        }
    }
}

/// Is a cell with these neighbours on the rim of its blob (of the right and upper side in one phase, of the others in the next), no end of
/// a line, and do its neighbours hang together without it?
fn goes(ring: [bool; 8], phase: usize) -> bool {
    let [e, ne, n, nw, w, sw, s, se] = ring;
    let count = |pairs: [bool; 4]| pairs.iter().filter(|p| **p).count();
    let stretches = count([
        !n && (ne || e),
        !e && (se || s),
        !s && (sw || w),
        !w && (nw || n),
    ]);
    let width = count([nw || n, ne || e, se || s, sw || w]).min(count([
        n || ne,
        e || se,
        s || sw,
        w || nw,
    ]));
    let stays = if phase == 0 {
        (n || ne || !se) && e
    } else {
        (s || sw || !nw) && w
    };
    stretches == 1 && (2..=3).contains(&width) && !stays
}

/// Middle lines of a set of distinct cells (each connected blob on its own), as runs of neighbouring cells, longest first within a
/// blob; side branches shorter than `shortest` cells are dropped, but every blob keeps one run. Deterministic.
pub fn middle_lines(cells: &[(i64, i64)], shortest: usize) -> Vec<Vec<(i64, i64)>> {
    let mut blobs = Blobs::new(cells);
    blobs.thin();
    let mut left: Vec<u32> = (0..blobs.cells.len() as u32)
        .filter(|&i| blobs.on[i as usize])
        .collect();
    let mut lines = Vec::new();
    let mut main = true;
    let mut seen = vec![0u32; blobs.cells.len()];
    let mut round = 0;
    // Longest paths first; what they pass is struck out, and the rest is looked at again.
    while !left.is_empty() {
        round += 1;
        let mut next: Vec<u32> = Vec::new();
        for &c in &left {
            if seen[c as usize] == round || !blobs.on[c as usize] {
                continue;
            }
            let blob = blobs.spread(c);
            blobs.wipe(&blob);
            blob.iter().for_each(|&i| seen[i as usize] = round);
            let path = blobs.path_from(blob[blob.len() - 1]);
            if path.len() < shortest && !main {
                blob.iter().for_each(|&i| blobs.on[i as usize] = false);
                continue;
            }
            for &p in &path {
                let around: Vec<u32> = blobs.around(p).collect();
                for i in around.into_iter().chain([p]) {
                    blobs.on[i as usize] = false;
                }
            }
            lines.push(path.iter().map(|&i| blobs.cells[i as usize]).collect());
            next.extend(blob.iter().filter(|&&i| blobs.on[i as usize]));
        }
        main = false;
        next.sort_unstable();
        left = next;
    }
    lines
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

    /// Whatever their shape and size: blobs of even width leave a line as those of odd width do.
    #[test]
    fn no_blob_is_left_without_a_line() {
        for (w, h) in (1..12).flat_map(|w| (1..12).map(move |h| (w, h))) {
            let bar: Vec<(i64, i64)> = (0..w).flat_map(|x| (0..h).map(move |y| (x, y))).collect();
            // Leaning by 45 degrees, as the crests between passes often do.
            let band: Vec<(i64, i64)> = (0..h)
                .flat_map(|k| (0..w).map(move |x| (x + k, k)))
                .collect();
            let disc: Vec<(i64, i64)> = (0..2 * w)
                .flat_map(|x| (0..2 * w).map(move |y| (x, y)))
                .filter(|(x, y)| (2 * x + 1 - 2 * w).pow(2) + (2 * y + 1 - 2 * w).pow(2) <= h * h)
                .collect();
            for blob in [bar, band, disc] {
                let lines = middle_lines(&blob, 4);
                assert!(blob.is_empty() || !lines.is_empty(), "{w} by {h}");
                // What is left hangs together: nothing of the blob is far from it, beyond its own width.
                let near = |c: &(i64, i64)| {
                    lines.concat().iter().any(|l| {
                        (l.0 - c.0).abs().max((l.1 - c.1).abs()) <= w.min(h).max(w.min(12)) + 1
                    })
                };
                assert!(blob.iter().all(near), "{w} by {h}: {lines:?}");
            }
        }
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
