//! Distances over triangles from given vertices, by their edge lengths alone.
//!
//! Each vertex x is updated from the triangles (a, b, x) whose a and b have a value:
//!
//! ```text
//!        x            a *virtual source* s is laid below a-b at the distances d(a) and d(b);
//!       / \           if the straight line s-x crosses a-b, d(x) = |s x| (exact on a flat sheet), else the
//!      a---b          distance comes along an edge.
//!       \ /           (M. Novotni, R. Klein, *Computing geodesic distances on triangular meshes*, 2002)
//!        s
//! ```
//!
//! Vertices are corrected whenever a shorter way turns up, so obtuse triangles need no order. Evenly spaced vertices
//! (see [`super::resample`]) keep the error below about one percent; edges that no triangle has are ways too.

use crate::geom::Point;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Places and ways between them.
#[derive(Clone, Debug, Default)]
pub struct Net {
    /// Vertices, mm.
    pub points: Vec<Point>,
    /// Triangle corners.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles of vertex i: `of[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    of: Vec<u32>,
    /// Neighbours of vertex i: `to[start[i]..start[i + 1]]`.
    start: Vec<u32>,
    to: Vec<u32>,
}

/// Lists by key, for rising keys below `n`.
fn grouped(n: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; n + 1];
    for (k, _) in pairs.clone() {
        start[k as usize + 1] += 1;
    }
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let mut fill = start.clone();
    let mut list = vec![0u32; start[n] as usize];
    for (k, v) in pairs {
        let f = &mut fill[k as usize];
        list[*f as usize] = v;
        *f += 1;
    }
    (start, list)
}

impl Net {
    /// Joins vertices by edges (each once) and triangles.
    pub fn new(points: Vec<Point>, edges: &[[u32; 2]], triangles: Vec<[u32; 3]>) -> Net {
        let n = points.len();
        let (first, of) = grouped(
            n,
            triangles
                .iter()
                .enumerate()
                .flat_map(|(t, c)| c.iter().map(move |&v| (v, t as u32))),
        );
        let (start, to) = grouped(n, edges.iter().flat_map(|e| [(e[0], e[1]), (e[1], e[0])]));
        Net {
            points,
            triangles,
            first,
            of,
            start,
            to,
        }
    }

    /// Neighbours of a vertex.
    #[inline]
    pub fn neighbours(&self, v: u32) -> &[u32] {
        &self.to[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }

    fn triangles_of(&self, v: u32) -> &[u32] {
        &self.of[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        (self.points[a as usize] - self.points[b as usize]).norm()
    }

    /// Distance of each vertex from the nearest source, and which one that is; +inf and `u32::MAX` beyond `limit` and where no way
    /// leads. Sources are points: fronts are round. Cost: n log n, about a microsecond a vertex.
    pub fn distances(&self, sources: &[u32], limit: f64) -> (Vec<f64>, Vec<u32>) {
        let mut value = vec![f64::INFINITY; self.points.len()];
        let mut source = vec![u32::MAX; self.points.len()];
        let mut heap = BinaryHeap::new();
        for (k, &s) in sources.iter().enumerate() {
            if value[s as usize] > 0.0 {
                value[s as usize] = 0.0;
                source[s as usize] = k as u32;
                heap.push(Item(0.0, s));
            }
        }
        while let Some(Item(v, node)) = heap.pop() {
            if v > value[node as usize] {
                continue; // superseded
            }
            let label = source[node as usize];
            let mut offer = |value: &mut [f64], x: u32, d: f64| {
                // Improvements below rounding would only go round in circles.
                if d < value[x as usize] * (1.0 - 1e-10) && d <= limit {
                    value[x as usize] = d;
                    heap.push(Item(d, x));
                    return true;
                }
                false
            };
            for &x in self.neighbours(node) {
                if offer(&mut value, x, v + self.length(node, x)) {
                    source[x as usize] = label;
                }
            }
            for &t in self.triangles_of(node) {
                let [a, b] = others(&self.triangles[t as usize], node);
                for (x, y) in [(a, b), (b, a)] {
                    let w = value[y as usize];
                    if source[y as usize] != label || w == f64::INFINITY {
                        continue;
                    }
                    let (l, lx, ly) = (
                        self.length(node, y),
                        self.length(node, x),
                        self.length(y, x),
                    );
                    if let Some(d) = update(v, w, lx, ly, l)
                        && offer(&mut value, x, d)
                    {
                        source[x as usize] = label;
                    }
                }
            }
        }
        (value, source)
    }
}

fn others(t: &[u32; 3], v: u32) -> [u32; 2] {
    if t[0] == v {
        [t[1], t[2]]
    } else if t[1] == v {
        [t[2], t[0]]
    } else {
        [t[0], t[1]]
    }
}

/// Distance of a triangle's corner from the source of a front that reached the other two (`va`, `vb`, an edge of length `l` apart; the
/// corner is `la` and `lb` from them); `None` when the straight way does not come between them.
fn update(va: f64, vb: f64, la: f64, lb: f64, l: f64) -> Option<f64> {
    if l <= 0.0 {
        return None;
    }
    // Laid flat: a at 0, b at l on the axis, the corner above, the source below.
    let ux = (la * la - lb * lb + l * l) / (2.0 * l);
    let uy = (la * la - ux * ux).max(0.0).sqrt();
    let sx = (va * va - vb * vb + l * l) / (2.0 * l);
    let sy2 = va * va - sx * sx;
    // Sources on the edge's own line are cut off by rounding otherwise.
    if sy2 < -1e-12 * l * l {
        return None;
    }
    let sy = sy2.max(0.0).sqrt();
    if sy + uy <= 0.0 {
        return None;
    }
    let cross = sx + (ux - sx) * sy / (sy + uy);
    (cross >= 0.0 && cross <= l).then(|| (ux - sx).hypot(uy + sy))
}

#[derive(PartialEq)]
pub(super) struct Item(pub f64, pub u32);

impl Eq for Item {}

impl Ord for Item {
    fn cmp(&self, o: &Self) -> Ordering {
        // A heap pops its greatest: turn it round; ties by number.
        o.0.total_cmp(&self.0).then(o.1.cmp(&self.1))
    }
}

impl PartialOrd for Item {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_sheet_of_even_triangles_is_measured_to_a_percent() {
        // A triangular lattice of 60 x 60.
        let n = 60u32;
        let points: Vec<Point> = (0..n * n)
            .map(|k| {
                let (i, j) = (f64::from(k % n), f64::from(k / n));
                Point::new(i + 0.5 * j, 0.75f64.sqrt() * j, 0.0)
            })
            .collect();
        let mut triangles = Vec::new();
        for j in 0..n - 1 {
            for i in 0..n - 1 {
                let a = j * n + i;
                triangles.push([a, a + 1, a + n]);
                triangles.push([a + 1, a + n + 1, a + n]);
            }
        }
        let edges: Vec<[u32; 2]> = super::super::surface::edge_runs(&triangles)
            .into_iter()
            .map(|r| r.0)
            .collect();
        let net = Net::new(points, &edges, triangles);
        let from = 30 * n + 30;
        let (d, s) = net.distances(&[from], f64::INFINITY);
        for (k, v) in d.iter().enumerate() {
            let want = (net.points[k] - net.points[from as usize]).norm();
            assert!((v - want).abs() <= 0.01 * want, "{k}: {v}, must be {want}");
            assert_eq!(s[k], 0);
        }
        // Two sources: each its half; a limit: nothing beyond it.
        let (d, s) = net.distances(&[0, n * n - 1], 20.0);
        assert_eq!((s[0], s[(n * n - 1) as usize]), (0, 1));
        assert!(d.iter().all(|v| *v <= 20.0 || *v == f64::INFINITY));
        assert_eq!(s[from as usize], u32::MAX);
    }
}
