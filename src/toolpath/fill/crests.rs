//! The crests that stand over, cell by cell, and where they would be cut.
//!
//! A cell is judged by the exact distance of the ball from its centre and, where the crest of a cusp may pass beside that, from more
//! places in it ([`crate::sweep::peak`]): on the part itself where the ball reaches it but for a little that facets hold back, on the
//! surface that the ball can reach elsewhere. So what is called clean here is clean for whoever measures to the triangles.

use super::{FillOptions, cusp, far};
use crate::geom::{Point, Point2, Vector2};
use crate::reach::DropCutter;
use crate::sweep::peak::{Look, Places, SLACK, crest, expected, reached};
use crate::sweep::reachable::Offset;
use crate::sweep::tiles::{area, touched};
use crate::sweep::{Lattice, Paths, ReachTiles, Reachable, Segment, Swept, Tile};
use crate::toolpath::fit::{resample, smooth};
use rayon::prelude::*;

/// Where the ball leaves no more than this share of the cusp height wanted on the part, the part is what counts: facets of a smooth part
/// keep a ball off by that much, noise by more.
const REST_SHARE: f64 = 0.3;
/// Where a ball leaves more than a twentieth of a cusp on more than this share of some tiles' cells, the part is rough all over, and
/// what stays in its roughness is not mended with more passes. (Measured: meshes of 2 mm facets 0.014, 5 um of noise 0.063.)
const ROUGH_SHARE: f64 = 0.03;
/// Tiles that are asked about it.
const ASKED: usize = 8;
/// Cusps higher than this many times what is wanted are over wherever in the cell one looks.
const FAR_OVER: f64 = 3.0;

/// Columns and rows of cells, by row.
type Cells = Vec<(i64, i64)>;

/// A cell of a crest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crest {
    /// Column and row in the whole lattice.
    x: u32,
    y: u32,
    /// Lowest the ball has been over it, and the surface it is judged on.
    swept: f64,
    base: f64,
    normal_z: f32,
    by: Offset,
}

impl Crest {
    fn cusp(&self) -> f64 {
        (self.swept - self.base) * f64::from(self.normal_z)
    }
}

/// A cell looked at more closely.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Looked {
    x: u32,
    y: u32,
    /// Height of its centre on the surface it is judged on.
    z: f64,
    /// How much of what stands there the ball cannot take, mm.
    rest: f32,
    by: Offset,
    places: Places,
}

impl Looked {
    fn look(&self, lattice: &Lattice, radius: f64) -> Look {
        let (x, y) = (lattice.x(self.x as usize), lattice.y(self.y as usize));
        Look {
            center: Point::new(x, y, self.z),
            step: lattice.step,
            expected: expected(&Point2::new(x, y), lattice.step, self.by),
            limit: radius + lattice.step,
        }
    }
}

/// The cells that stand over, and those of their crests nearby: by row, then by column.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::toolpath) struct Crests {
    lattice: Lattice,
    pub stepover: f64,
    radius: f64,
    cells: Vec<Crest>,
    /// Those of them that may stand over.
    looked: Vec<Looked>,
    /// Where each row begins in `cells`; one more entry than rows.
    rows: Vec<u32>,
}

/// Cells on a side of the windows in which crests are swept again.
const WINDOW: usize = 64;

impl Crests {
    /// Sweeps the passes over every tile and keeps what may matter.
    pub fn new(reach: &ReachTiles, segments: &[Segment], options: &FillOptions) -> Crests {
        let lattice = *reach.lattice();
        let radius = reach.drop_cutter().radius();
        let stepover = (8.0 * options.scallop * radius).sqrt();
        let far = far(stepover, lattice.step);
        let rough = rough(reach, options.scallop);
        let touched = reach.touched(segments.iter());
        let found: Vec<(Vec<Crest>, Vec<Looked>)> = (0..reach.len())
            .into_par_iter()
            .map(|k| {
                let r = reach.reach(k);
                let mine: Vec<Segment> = touched[k].iter().map(|&i| segments[i as usize]).collect();
                let mut swept = Swept::new(r.lattice);
                swept.cut_alone(&mine, radius);
                let at = Seen {
                    reach: &r,
                    swept: &swept,
                    segments: &mine,
                    part: reach.drop_cutter(),
                    core: reach.tile(k),
                    wide: reach.wide(k),
                    but: REST_SHARE * options.scallop,
                    rough,
                };
                crests_of(&at, far, options)
            })
            .collect();
        let (mut cells, mut looked) = (Vec::new(), Vec::new());
        for (c, l) in found {
            cells.extend(c);
            looked.extend(l);
        }
        cells.par_sort_unstable_by_key(|c: &Crest| (c.y, c.x));
        looked.par_sort_unstable_by_key(|c: &Looked| (c.y, c.x));
        let mut rows = vec![0u32; lattice.ny + 1];
        for c in &cells {
            rows[c.y as usize + 1] += 1;
        }
        for y in 1..rows.len() {
            rows[y] += rows[y - 1];
        }
        Crests {
            lattice,
            stepover,
            radius,
            cells,
            looked,
            rows,
        }
    }

    /// The cells of a row between two columns (the second not among them), as a range of `cells`.
    fn span(&self, y: i64, from: i64, to: i64) -> std::ops::Range<usize> {
        if y < 0 || y >= self.lattice.ny as i64 {
            return 0..0;
        }
        let (a, b) = (
            self.rows[y as usize] as usize,
            self.rows[y as usize + 1] as usize,
        );
        let row = &self.cells[a..b];
        a + row.partition_point(|c| i64::from(c.x) < from)
            ..a + row.partition_point(|c| i64::from(c.x) < to)
    }

    /// Where in plan the ball that reaches a cell best has its centre; `None` for no cell of a crest.
    pub fn center_over(&self, x: i64, y: i64) -> Option<Point2> {
        let c = self.cells.get(self.span(y, x, x + 1).next()?)?;
        Some(Point2::new(
            self.lattice.x(c.x as usize) + self.lattice.step * f64::from(c.by[0]),
            self.lattice.y(c.y as usize) + self.lattice.step * f64::from(c.by[1]),
        ))
    }

    /// The centre of the ball that reaches a cell best, and the way off the part there in plan (unit length), where the part is steeper
    /// than a normal of this height; `None` elsewhere.
    pub fn on_wall(&self, x: i64, y: i64, steepest: f64) -> Option<(Point, Vector2)> {
        let c = self.cells.get(self.span(y, x, x + 1).next()?)?;
        if f64::from(c.normal_z) >= steepest {
            return None;
        }
        let out = Vector2::new(f64::from(c.by[0]), f64::from(c.by[1])).try_normalize(0.5)?;
        // By the normal: where the centre is in plan is known to a cell only, and on a wall that is no height.
        let up = f64::from(c.normal_z).clamp(0.0, 1.0);
        let q = Point2::new(self.lattice.x(c.x as usize), self.lattice.y(c.y as usize))
            + out * (self.radius * (1.0 - up * up).sqrt());
        Some((Point::new(q.x, q.y, c.base + self.radius * up), out))
    }

    /// A row of places (in cells; the first and the last lie beyond the cells they were led from) as a curve of ball centres in plan.
    pub fn along(&self, row: &[Point2]) -> Vec<Point2> {
        let n = row.len();
        let mut curve: Vec<Point2> = row[1..n - 1].iter().filter_map(|p| self.near(p)).collect();
        if let (Some(&first), Some(&last)) = (curve.first(), curve.last()) {
            // The ends run on in plan as far as they do on the surface.
            curve.insert(0, first + (row[0] - row[1]) * self.lattice.step);
            curve.push(last + (row[n - 1] - row[n - 2]) * self.lattice.step);
        }
        let mut even = resample(&curve, false, 0.2 * self.stepover);
        smooth(&mut even, false, 12);
        even
    }

    /// As [`Crests::center_over`] for the cell at a place, or one beside it.
    fn near(&self, p: &Point2) -> Option<Point2> {
        let (x, y) = (p.x.round() as i64, p.y.round() as i64);
        (0..4).find_map(|r: i64| {
            (-r..=r).find_map(|v| {
                (-r..=r)
                    .filter(|u| u.abs() == r || v.abs() == r)
                    .find_map(|u| self.center_over(x + u, y + v))
            })
        })
    }

    /// The cells to fill along (standing over `keep`, near one standing over `start`, and hanging together with it), and those that
    /// stand over `start`; columns and rows, by row.
    pub fn standing(&self, options: &FillOptions) -> (Cells, Cells) {
        let (start, keep) = (
            options.start * options.scallop,
            options.keep * options.scallop,
        );
        let seeds: Vec<usize> = self
            .looked
            .iter()
            .filter(|l| l.places.furthest().1 - self.radius - f64::from(l.rest) > start)
            .filter_map(|l| {
                self.span(i64::from(l.y), i64::from(l.x), i64::from(l.x) + 1)
                    .next()
            })
            .collect();
        let far = far(self.stepover, self.lattice.step);
        let mut mask = vec![false; self.cells.len()];
        for &i in &seeds {
            let (x, y) = (i64::from(self.cells[i].x), i64::from(self.cells[i].y));
            for v in -far..=far {
                let half = half_width(far, v);
                mask[self.span(y + v, x - half, x + half + 1)].fill(true);
            }
        }
        mask.iter_mut()
            .zip(&self.cells)
            .for_each(|(m, c)| *m &= c.cusp() > keep);
        // Only what hangs together with a place that stands over.
        let mut queue = seeds.clone();
        queue.iter().for_each(|&i| mask[i] = false);
        let mut k = 0;
        while k < queue.len() {
            let (x, y) = (
                i64::from(self.cells[queue[k]].x),
                i64::from(self.cells[queue[k]].y),
            );
            k += 1;
            for v in -1..=1 {
                for j in self.span(y + v, x - 1, x + 2) {
                    if std::mem::take(&mut mask[j]) {
                        queue.push(j);
                    }
                }
            }
        }
        queue.sort_unstable();
        let cells = queue
            .into_iter()
            .map(|i| (i64::from(self.cells[i].x), i64::from(self.cells[i].y)))
            .collect();
        let over = seeds
            .into_iter()
            .map(|i| (i64::from(self.cells[i].x), i64::from(self.cells[i].y)))
            .collect();
        (cells, over)
    }

    /// Sweeps some more segments over the cells kept.
    pub fn cut(&mut self, segments: &[Segment]) {
        let radius = self.radius;
        let across = self.lattice.nx.div_ceil(WINDOW).max(1);
        let window = |c: &Crest| c.y as usize / WINDOW * across + c.x as usize / WINDOW;
        let mut by_window: Vec<(u32, u32)> = self
            .cells
            .iter()
            .zip(0u32..)
            .map(|(c, i)| (window(c) as u32, i))
            .collect();
        by_window.par_sort_unstable();
        let groups: Vec<&[(u32, u32)]> = by_window.chunk_by(|a, b| a.0 == b.0).collect();
        let touched = touched(&self.lattice, WINDOW, radius, segments.iter());
        let lowered: Vec<Vec<(u32, f64)>> = groups
            .par_iter()
            .map(|group| {
                let w = group[0].0 as usize;
                let which = &touched[w];
                if which.is_empty() {
                    return Vec::new();
                }
                let (x, y) = (w % across * WINDOW, w / across * WINDOW);
                let mut swept = Swept::new(self.lattice.window(x..x + WINDOW, y..y + WINDOW));
                let mine: Vec<Segment> = which.iter().map(|&i| segments[i as usize]).collect();
                swept.cut_alone(&mine, radius);
                group
                    .iter()
                    .map(|&(_, i)| {
                        let c = &self.cells[i as usize];
                        let at = swept.lattice.index(c.x as usize - x, c.y as usize - y);
                        (i, swept.z[at])
                    })
                    .collect()
            })
            .collect();
        for (i, z) in lowered.into_iter().flatten() {
            let c = &mut self.cells[i as usize];
            c.swept = c.swept.min(z);
        }
        let paths = Paths::new(segments, 0.25 * radius, area(&self.lattice));
        let lattice = &self.lattice;
        self.looked
            .par_iter_mut()
            .for_each_init(Vec::new, |near, l| {
                l.places.cut(&l.look(lattice, radius), &paths, near);
            });
    }
}

/// Half the width of a disc at a height.
fn half_width(far: i64, v: i64) -> i64 {
    ((far * far - v * v).max(0) as f64).sqrt() as i64
}

/// Whether a part is rough all over, for this ball.
fn rough(reach: &ReachTiles, scallop: f64) -> bool {
    let by = reach.len().div_ceil(ASKED).max(1);
    let counted: Vec<(usize, usize)> = (0..reach.len())
        .into_par_iter()
        .step_by(by)
        .map(|k| {
            let r = reach.reach(k);
            let rests = (0..r.lattice.len()).map(|i| r.rest(i));
            rests.filter(|v| !v.is_nan()).fold((0, 0), |(n, over), v| {
                (n + 1, over + usize::from(v > 0.05 * scallop))
            })
        })
        .collect();
    let n: usize = counted.iter().map(|c| c.0).sum();
    let over: usize = counted.iter().map(|c| c.1).sum();
    over as f64 > ROUGH_SHARE * n as f64
}

/// A tile and what the ball left of it.
struct Seen<'a> {
    reach: &'a Reachable,
    swept: &'a Swept,
    segments: &'a [Segment],
    part: &'a DropCutter,
    core: Tile,
    wide: Tile,
    /// Cells that the ball leaves no more on than this, mm, are judged on the part.
    but: f64,
    /// What it leaves there is no cusp.
    rough: bool,
}

impl Seen<'_> {
    /// What stands at a cell, to first order, and the height that it is measured from.
    fn cusp(&self, i: usize) -> (f64, f64) {
        let r = self.reach;
        if !self.rough && r.rest(i) <= self.but {
            (cusp(r, self.swept, i, r.part_z[i]), r.part_z[i])
        } else {
            (cusp(r, self.swept, i, r.reach_z[i]), r.reach_z[i])
        }
    }
}

/// The cells of a tile that stand over `keep` near one that stands over `start`, and those of them that were looked at closely.
fn crests_of(at: &Seen, far: i64, options: &FillOptions) -> (Vec<Crest>, Vec<Looked>) {
    let (r, h) = (at.reach, options.scallop);
    let l = &r.lattice;
    let (start, keep) = (options.start * h, options.keep * h);
    // The steepest flank, from a cell's centre to its corner.
    let missed = (2.0 * h / r.radius).sqrt() * 0.71 * l.step;
    let bend = l.step * l.step / (2.0 * r.radius);
    let height = |i: usize| at.cusp(i).0;
    let may_stand = |i: usize, own: f64| {
        let beside = |dx: i64, dy: i64| l.beside(i, dx, dy).map_or(f64::NEG_INFINITY, height);
        own > start - missed - SLACK * h && crest(beside, bend) > start - SLACK * h
    };
    let (mut paths, mut curtains) = (None, Vec::new());
    let mut looked: Vec<(usize, f64, f32, Places)> = Vec::new();
    let mut near = Vec::new();
    for i in 0..l.len() {
        let (own, z) = at.cusp(i);
        if own <= start && !may_stand(i, own) {
            continue;
        }
        let (mut look, mut rest) = (Look::at(r, i, z), 0.0);
        let mut places = if own < FAR_OVER * h && reached(r, i, at.but) {
            if at.rough {
                look.center.z = r.part_z[i];
                rest = r.rest(i).max(0.0);
            }
            Places::all(&look, at.part)
        } else {
            Places::center(&look)
        };
        let paths = paths.get_or_insert_with(|| Paths::new(at.segments, 0.25 * r.radius, area(l)));
        places.cut(&look, paths, &mut curtains);
        looked.push((i, look.center.z, rest as f32, places));
        if places.furthest().1 - r.radius - rest <= start {
            continue;
        }
        near.resize(l.len(), false);
        let (x, y) = l.cell(i);
        for v in (-far).max(-(y as i64))..=far.min((l.ny - 1 - y) as i64) {
            let half = half_width(far, v);
            let row = (y as i64 + v) as usize * l.nx;
            let lo = (x as i64 - half).max(0) as usize;
            let hi = ((x as i64 + half) as usize).min(l.nx - 1);
            near[row + lo..=row + hi].fill(true);
        }
    }
    let (mut out, mut close) = (Vec::new(), Vec::new());
    if near.is_empty() {
        return (out, close);
    }
    let mut next = looked.into_iter().peekable();
    for y in at.core.rows.clone() {
        for x in at.core.columns.clone() {
            let i = l.index(x - at.wide.columns.start, y - at.wide.rows.start);
            if !near[i] {
                continue;
            }
            while next.next_if(|n| n.0 < i).is_some() {}
            let closely = next.next_if(|n| n.0 == i);
            let (own, base) = at.cusp(i);
            if own > keep || closely.is_some() {
                out.push(Crest {
                    x: x as u32,
                    y: y as u32,
                    swept: at.swept.z[i],
                    base,
                    normal_z: r.normal_z[i],
                    by: r.by[i],
                });
            }
            close.extend(closely.map(|(_, z, rest, places)| Looked {
                x: x as u32,
                y: y as u32,
                z,
                rest,
                by: r.by[i],
                places,
            }));
        }
    }
    (out, close)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Mesh;
    use crate::sweep::{Finish, FinishOptions, finish_tiles};

    /// A wavy plate with a step, 24 x 20 mm.
    fn part() -> Mesh {
        let at = |i: usize, j: usize| {
            let (x, y) = (0.3 * i as f64, 0.3 * j as f64);
            let step = if x > 15.0 { 0.8 } else { 0.0 };
            Point::new(x, y, 1.5 * (0.5 * x).sin() * (0.4 * y).cos() + step)
        };
        let mut mesh = Mesh::default();
        for j in 0..66 {
            for i in 0..80 {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    /// A raster, some of its lines too far apart.
    fn raster(drop: &DropCutter) -> Vec<Segment> {
        let mut out = Vec::new();
        for k in 0..48 {
            let y = 0.42 * f64::from(k) + if k % 7 == 0 { 0.15 } else { 0.0 };
            let line: Vec<Point> = (0..120)
                .filter_map(|i| drop.drop(0.2 * f64::from(i), y))
                .map(|c| c.center)
                .collect();
            out.extend(line.windows(2).map(|w| Segment {
                from: w[0],
                to: w[1],
            }));
        }
        out
    }

    const HOW: FillOptions = FillOptions {
        scallop: 0.015,
        start: 1.03,
        keep: 0.75,
        rounds: 6,
    };

    fn judged(tiles: &ReachTiles, segments: &[Segment]) -> Finish {
        let radius = tiles.drop_cutter().radius();
        let paths = Paths::new(segments, 0.25 * radius, area(tiles.lattice()));
        let touched = tiles.touched(segments.iter());
        let options = FinishOptions::for_scallop(HOW.scallop);
        let (finish, order) = finish_tiles(tiles, &paths, &options, |k, reach| {
            let mut swept = Swept::new(reach.lattice);
            let mine: Vec<Segment> = touched[k].iter().map(|&i| segments[i as usize]).collect();
            swept.cut_alone(&mine, radius);
            (swept, k)
        });
        assert!(order.iter().enumerate().all(|(i, k)| i == *k));
        finish.unwrap_or_else(|e| panic!("{e}"))
    }

    /// In tiles of any size, on any number of threads: the same cells to fill along, the same figures, the same map.
    #[test]
    fn neither_tiles_nor_threads_show() {
        let drop = DropCutter::new(&part(), 1.5);
        let segments = raster(&drop);
        let run = |side: usize, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap_or_else(|e| panic!("{e}"));
            pool.install(|| {
                let tiles = ReachTiles::new(&drop, 0.03, 16).with_side(side);
                let mut crests = Crests::new(&tiles, &segments, &HOW);
                let first = crests.standing(&HOW);
                crests.cut(&segments[..200]);
                crests.cut(&[Segment {
                    from: Point::new(3.0, 3.0, 2.0),
                    to: Point::new(20.0, 15.0, 2.0),
                }]);
                (first, crests, judged(&tiles, &segments))
            })
        };
        let whole = run(1 << 12, 1);
        assert!(
            whole.0.1.len() > 100 && whole.1.cells.len() > 1000,
            "{}",
            whole.0.1.len()
        );
        for (side, threads) in [(128, 1), (192, 2), (320, 3)] {
            let tiled = run(side, threads);
            assert!(whole.0 == tiled.0);
            assert!(whole.1 == tiled.1);
            assert_eq!(whole.2.stats, tiled.2.stats);
            let bits = |v: &[f32]| v.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&whole.2.map.cusp_mm), bits(&tiled.2.map.cusp_mm));
            assert_eq!(bits(&whole.2.map.gouge_mm), bits(&tiled.2.map.gouge_mm));
        }
    }
}
