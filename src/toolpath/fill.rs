//! The closed loop: sweep the passes, find where the cusp stands over, add passes along its crests, again until clean.
//!
//! Cusps are judged against what this ball *can* reach ([`crate::sweep::Reachable`]), not against the ideal surface: facets, noise and tight
//! corners are the part's, not ours.

use super::fit::{FitOptions, resample, smooth};
use super::pass::{Pass, PassKind, laid};
use super::settle::settled;
use super::skeleton::middle_lines;
use super::stroke::strokes;
use crate::feature::Regions;
use crate::geom::{Point, Point2, Vector2};
use crate::reach::ToolCentreGrid;
use crate::sweep::reachable::{NONE, Offset};
use crate::sweep::tiles::touched;
use crate::sweep::{Lattice, ReachTiles, Reachable, Segment, Swept, Tile};
use rayon::prelude::*;

/// When and how far to fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillOptions {
    /// Height wanted, mm.
    pub scallop: f64,
    /// Fill where a cusp is over this share of it ...
    pub start: f64,
    /// ... along its crest for as long as it is over this share.
    pub keep: f64,
    /// Give up after this many rounds.
    pub rounds: usize,
}

/// What filling did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FillReport {
    /// Rounds gone through.
    pub rounds: usize,
    /// Passes added.
    pub added: usize,
    /// Their length, mm.
    pub length_mm: f64,
    /// Cells that still stand over when the last round was done.
    pub cells_left: usize,
}

/// Normals flatter than this (upright walls) are not judged in plan.
const UPRIGHT: f32 = 0.02;

/// Rounds in which rows of spots are looked for.
const STROKE_ROUNDS: usize = 2;

/// Adds fill passes to `passes` until no cusp stands over, or the rounds are used up. All tiles are swept and looked at once; what stands
/// over, and the crest near it, is all that a later round can change, so only those cells are kept (40 bytes each) and swept again.
pub fn fill(
    grid: &ToolCentreGrid,
    regions: &Regions,
    reach: &ReachTiles,
    passes: &mut Vec<Pass>,
    options: &FillOptions,
    fitting: &FitOptions,
) -> FillReport {
    let cutter = reach.drop_cutter();
    let mut report = FillReport::default();
    let mut crests = Crests::new(reach, &segments(passes), options);
    let step = reach.lattice().step;
    loop {
        let (cells, over) = crests.standing(options);
        report.cells_left = over.len();
        if over.is_empty() || report.rounds == options.rounds {
            return report;
        }
        report.rounds += 1;
        // Rows of spots first; what they leave is looked at again. Specks that happen to lie in a row must not keep the rest waiting
        // until the rounds are used up.
        let rows = if report.rounds <= STROKE_ROUNDS {
            strokes(&over, crests.stepover / step)
        } else {
            Vec::new()
        };
        let curves: Vec<Vec<Point2>> = if rows.is_empty() {
            // Branches shorter than half a stepover are cut by the line they leave.
            middle_lines(&cells, ((0.5 * crests.stepover / step) as usize).max(3))
                .iter()
                .map(|line| {
                    let curve: Vec<Point2> = line
                        .iter()
                        .filter_map(|&(x, y)| crests.center_over(x, y))
                        .collect();
                    let mut even = resample(&curve, false, 2.0 * step);
                    smooth(&mut even, false, 6);
                    drawn_out(even, 0.3 * crests.stepover)
                })
                .collect()
        } else {
            rows.iter().map(|row| crests.along(row)).collect()
        };
        let new: Vec<Vec<Pass>> = curves
            .par_iter()
            .map(|even| {
                settled(cutter, even, step)
                    .iter()
                    .flat_map(|piece| laid(cutter, piece, false, fitting))
                    .filter(|(points, _)| points.len() > 1)
                    .map(|(points, closed)| {
                        let feature = regions.feature_at(grid, &points[0].xy());
                        Pass {
                            kind: PassKind::Fill,
                            feature,
                            points,
                            closed,
                        }
                    })
                    .collect()
            })
            .collect();
        // Where a fill has been already, another does no more.
        let new: Vec<Pass> = new
            .into_iter()
            .flatten()
            .filter(|p| !passes.iter().any(|q| again(p, q)))
            .collect();
        if new.is_empty() {
            if rows.is_empty() {
                return report;
            }
            // Nothing more from rows: next come the spots themselves.
            report.rounds = report.rounds.max(STROKE_ROUNDS);
            continue;
        }
        crests.cut(&segments(&new), cutter.radius());
        report.added += new.len();
        report.length_mm += new.iter().map(Pass::length).sum::<f64>();
        passes.extend(new);
    }
}

/// Is a fill as good as the same as another pass?
fn again(p: &Pass, q: &Pass) -> bool {
    const SAME: f64 = 1e-3;
    let near =
        |a: Option<&Point>, b: Option<&Point>| a.zip(b).is_some_and(|(a, b)| (a - b).norm() < SAME);
    q.kind == PassKind::Fill
        && near(p.points.first(), q.points.first())
        && near(p.points.last(), q.points.last())
        && (p.length() - q.length()).abs() < SAME
}

/// A dab becomes a stroke of at least this length, mm, the way it lies: a tool that only touches leaves a mark, and a pass of one point
/// cannot be entered along its way.
fn drawn_out(curve: Vec<Point2>, shortest: f64) -> Vec<Point2> {
    let (Some(&a), Some(&b)) = (curve.first(), curve.last()) else {
        return curve;
    };
    let length: f64 = curve.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    if length >= shortest {
        return curve;
    }
    let way = (b - a).try_normalize(1e-9).unwrap_or_else(Vector2::x);
    let middle = nalgebra::center(&a, &b);
    vec![
        middle - way * (0.5 * shortest),
        middle,
        middle + way * (0.5 * shortest),
    ]
}

/// Every straight piece of some passes; a pass of one point is a piece without length.
pub(super) fn segments(passes: &[Pass]) -> Vec<Segment> {
    let mut out = Vec::new();
    for p in passes {
        let run = p.run();
        match run.as_slice() {
            [one] => out.push(Segment {
                from: *one,
                to: *one,
            }),
            many => out.extend(many.windows(2).map(|w| Segment {
                from: w[0],
                to: w[1],
            })),
        }
    }
    out
}

/// The highest cusp (mm) that some passes leave at each node of the grid, by the place of the ball that could reach it; 0 where none was
/// judged. One sweep of every tile.
pub fn cusps_at_nodes(grid: &ToolCentreGrid, reach: &ReachTiles, passes: &[Pass]) -> Vec<f32> {
    let radius = reach.drop_cutter().radius();
    let segments = segments(passes);
    let touched = reach.touched(segments.iter());
    let found: Vec<Vec<(u32, f32)>> = (0..reach.len())
        .into_par_iter()
        .map(|k| {
            let r = reach.reach(k);
            let mine: Vec<Segment> = touched[k].iter().map(|&i| segments[i as usize]).collect();
            let mut swept = Swept::new(r.lattice);
            swept.cut_alone(&mine, radius);
            let mut out: Vec<(u32, f32)> = (0..r.lattice.len())
                .filter_map(|i| {
                    let cusp = cusp(&r, &swept, i);
                    let c = r.center_over(i);
                    (cusp > 0.0).then_some(())?;
                    Some((grid.nearest(c.x, c.y)? as u32, cusp as f32))
                })
                .collect();
            out.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
            out.dedup_by_key(|e| e.0);
            out
        })
        .collect();
    let mut out = vec![0.0f32; grid.len()];
    for (n, cusp) in found.into_iter().flatten() {
        let v = &mut out[n as usize];
        *v = v.max(cusp);
    }
    out
}

/// What stands over the reachable surface at a cell, mm; -inf where it is not judged.
fn cusp(r: &Reachable, swept: &Swept, i: usize) -> f64 {
    if r.part_z[i].is_finite() && r.by[i][0] != NONE && r.normal_z[i] > UPRIGHT {
        (swept.z[i] - r.reach_z[i]) * f64::from(r.normal_z[i])
    } else {
        f64::NEG_INFINITY
    }
}

/// Columns and rows of cells, by row.
type Cells = Vec<(i64, i64)>;

/// A cell of a crest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crest {
    /// Column and row in the whole lattice.
    x: u32,
    y: u32,
    /// Lowest the ball has been over it, and can be.
    swept: f64,
    reach: f64,
    normal_z: f32,
    by: Offset,
}

impl Crest {
    fn cusp(&self) -> f64 {
        (self.swept - self.reach) * f64::from(self.normal_z)
    }
}

/// The cells that stand over, and those of their crests nearby: by row, then by column.
#[derive(Clone, Debug, PartialEq)]
struct Crests {
    lattice: Lattice,
    stepover: f64,
    cells: Vec<Crest>,
    /// Where each row begins in `cells`; one more entry than rows.
    rows: Vec<u32>,
}

/// Cells on a side of the windows in which crests are swept again.
const WINDOW: usize = 64;

impl Crests {
    /// Sweeps the passes over every tile and keeps what may matter.
    fn new(reach: &ReachTiles, segments: &[Segment], options: &FillOptions) -> Crests {
        let lattice = *reach.lattice();
        let radius = reach.drop_cutter().radius();
        let stepover = (8.0 * options.scallop * radius).sqrt();
        let far = far(stepover, lattice.step);
        let touched = reach.touched(segments.iter());
        let found: Vec<Vec<Crest>> = (0..reach.len())
            .into_par_iter()
            .map(|k| {
                let r = reach.reach(k);
                let mine: Vec<Segment> = touched[k].iter().map(|&i| segments[i as usize]).collect();
                let mut swept = Swept::new(r.lattice);
                swept.cut_alone(&mine, radius);
                crests_of(&r, &swept, reach.tile(k), reach.wide(k), far, options)
            })
            .collect();
        let mut cells: Vec<Crest> = found.into_iter().flatten().collect();
        cells.par_sort_unstable_by_key(|c| (c.y, c.x));
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
            cells,
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
    fn center_over(&self, x: i64, y: i64) -> Option<Point2> {
        let c = self.cells.get(self.span(y, x, x + 1).next()?)?;
        Some(Point2::new(
            self.lattice.x(c.x as usize) + self.lattice.step * f64::from(c.by[0]),
            self.lattice.y(c.y as usize) + self.lattice.step * f64::from(c.by[1]),
        ))
    }

    /// A row of places (in cells; the first and the last lie beyond the cells they were led from) as a curve of ball centres in plan.
    fn along(&self, row: &[Point2]) -> Vec<Point2> {
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
    fn standing(&self, options: &FillOptions) -> (Cells, Cells) {
        let (start, keep) = (
            options.start * options.scallop,
            options.keep * options.scallop,
        );
        let seeds: Vec<usize> = (0..self.cells.len())
            .filter(|&i| self.cells[i].cusp() > start)
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
    fn cut(&mut self, segments: &[Segment], radius: f64) {
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
    }
}

/// Cells that a crest is followed past the place that stands over: about a stepover.
pub fn far(stepover: f64, step: f64) -> i64 {
    (0.75 * stepover / step).ceil() as i64
}

/// Half the width of a disc at a height.
fn half_width(far: i64, v: i64) -> i64 {
    ((far * far - v * v).max(0) as f64).sqrt() as i64
}

/// The cells of a tile that stand over `keep`, near one that stands over `start`.
fn crests_of(
    r: &Reachable,
    swept: &Swept,
    core: Tile,
    wide: Tile,
    far: i64,
    options: &FillOptions,
) -> Vec<Crest> {
    let l = &r.lattice;
    let cusp = |i: usize| cusp(r, swept, i);
    let (start, keep) = (
        options.start * options.scallop,
        options.keep * options.scallop,
    );
    let mut near = Vec::new();
    for i in 0..l.len() {
        if cusp(i) <= start {
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
    let mut out = Vec::new();
    if near.is_empty() {
        return out;
    }
    for y in core.rows {
        for x in core.columns.clone() {
            let i = l.index(x - wide.columns.start, y - wide.rows.start);
            if near[i] && cusp(i) > keep {
                out.push(Crest {
                    x: x as u32,
                    y: y as u32,
                    swept: swept.z[i],
                    reach: r.reach_z[i],
                    normal_z: r.normal_z[i],
                    by: r.by[i],
                });
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point;
    use crate::part::Mesh;
    use crate::reach::DropCutter;
    use crate::sweep::tiles::area;
    use crate::sweep::{Finish, FinishOptions, Paths, finish_tiles};

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
                crests.cut(&segments[..200], 1.5);
                crests.cut(
                    &[Segment {
                        from: Point::new(3.0, 3.0, 2.0),
                        to: Point::new(20.0, 15.0, 2.0),
                    }],
                    1.5,
                );
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
            assert_eq!(whole.0, tiled.0);
            assert_eq!(whole.1, tiled.1);
            assert_eq!(whole.2.stats, tiled.2.stats);
            let bits = |v: &[f32]| v.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&whole.2.map.cusp_mm), bits(&tiled.2.map.cusp_mm));
            assert_eq!(bits(&whole.2.map.gouge_mm), bits(&tiled.2.map.gouge_mm));
        }
    }
}
