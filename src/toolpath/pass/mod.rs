//! Passes: level curves of a feature, trimmed to the ground that is its own.

mod border;
pub(in crate::toolpath) mod corner;
pub mod pencil;
pub(in crate::toolpath) mod ridge;
mod spiral;

use super::fit::{FitOptions, fit, resample, rest, smooth};
use super::wall::Steep;
use crate::feature::{Feature, Regions};
use crate::field::level_curves;
use crate::geom::{Point, Point2, Vector2};
use crate::reach::{Contact, DropCutter, Hint, NodeKind, ToolCentreGrid};
use border::border;
use corner::{Rounding, refined, round_corners};
use rayon::prelude::*;
use spiral::{Leveled, SpiralOptions, spirals};

/// Why a pass is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PassKind {
    /// Along the part's border, the contact on the border itself.
    Border,
    /// A level curve of a feature.
    Level,
    /// At constant height along a steep wall.
    Wall,
    /// Along a crease, where the ball touches two walls at once.
    Pencil,
    /// Where the others left too high a cusp.
    Fill,
    /// From one pass to the next, on the surface.
    Turn,
}

/// One continuous run of cutting.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Why it is there.
    pub kind: PassKind,
    /// The feature it belongs to: an index into [`Regions::features`]; `None` for a border that no feature holds.
    pub feature: Option<usize>,
    /// Places of the ball's centre, work coordinates, mm.
    pub points: Vec<Point>,
    /// It returns to its first point (which is not repeated).
    pub closed: bool,
}

impl Pass {
    /// Length, mm.
    pub fn length(&self) -> f64 {
        let close = if self.closed {
            self.points
                .first()
                .zip(self.points.last())
                .map_or(0.0, |(a, b)| (a - b).norm())
        } else {
            0.0
        };
        close
            + self
                .points
                .windows(2)
                .map(|w| (w[1] - w[0]).norm())
                .sum::<f64>()
    }

    /// As an open run: a closed pass ends where it began.
    pub fn run(&self) -> Vec<Point> {
        let mut p = self.points.clone();
        if self.closed
            && let Some(first) = self.points.first()
        {
            p.push(*first);
        }
        p
    }
}

/// Rounds of evening out that a corner may take.
pub const CORNER_ROUNDS: usize = 120;
/// Passes run on this far (in passes) into ground already taken, so that they end on its rim for certain.
const OVERLAP: f64 = 0.1;

/// How exactly passes are laid on the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitted {
    /// Only to be measured: dropped at every step of the grid, the chords between not proven.
    Draft,
    /// To be cut.
    Proven,
}

/// Shape of passes, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassOptions {
    /// How exactly they are laid.
    pub detail: Fitted,
    /// Flat stepover of the job.
    pub stepover: f64,
    /// Radius that corners of level curves are rounded to.
    pub corner: f64,
}

/// Level passes of all features but for the walls, by rising level, and then the stretches of the border that they leave. All cores; the order does not depend on them.
pub fn passes(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    how: &PassOptions,
    steep: &Steep,
    fitting: &FitOptions,
) -> Vec<Pass> {
    // All features at once: the passes of one may be a single long spiral.
    let wound: Vec<(usize, Leveled)> = regions
        .features
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, _)| {
            shaped(grid, cutter, regions, index, how, steep)
                .into_iter()
                .map(move |c| (index, c))
        })
        .collect();
    let fitted: Vec<Vec<Pass>> = wound
        .par_iter()
        .with_max_len(1)
        .map(|(index, c)| {
            let fitted = match how.detail {
                Fitted::Proven => laid(cutter, &c.points, c.closed, fitting),
                Fitted::Draft => vec![(dropped(cutter, &c.points, 0.3 * fitting.gouge), c.closed)],
            };
            fitted
                .into_iter()
                // What touches the ground in one place is no pass, but a plunge for nothing.
                .filter(|(points, _)| points.len() > 1)
                .map(|(points, closed)| Pass {
                    kind: PassKind::Level,
                    feature: Some(*index),
                    points,
                    closed,
                })
                .collect()
        })
        .collect();
    let mut out: Vec<Pass> = fitted.into_iter().flatten().collect();
    out.extend(border(grid, cutter, regions, steep, fitting));
    out
}

/// Level passes of one feature in plan: trimmed, rounded, ending on the border, families of loops wound into spirals.
fn shaped(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    regions: &Regions,
    index: usize,
    how: &PassOptions,
    steep: &Steep,
) -> Vec<Leveled> {
    let cut: Vec<&Feature> = regions.features[..index]
        .iter()
        .filter(|f| f.rim_is_cut())
        .collect();
    let curves = trimmed_levels(grid, &regions.features[index], &cut, steep, how.stepover);
    let shaped: Vec<Vec<Leveled>> = curves
        .par_iter()
        .map(|c| {
            // Grid noise is shorter than two steps: even it out before it becomes jerk.
            let mut even = resample(&c.points, c.closed, 0.7 * grid.step);
            smooth(&mut even, c.closed, 2);
            let corner = if c.closed {
                // A loop cannot be rounder than a circle: asked to be, it would shrink to a point.
                how.corner
                    .min(ROUNDEST * around(&even) / std::f64::consts::TAU)
            } else {
                how.corner
            };
            let rounding = Rounding {
                radius: corner,
                rounds: CORNER_ROUNDS,
                eats_tips: false,
            };
            let even = round_corners(even, c.closed, &rounding, &mut slopes(cutter));
            on_ground(grid, cutter, &even, c.closed, how.stepover)
                .into_iter()
                .map(|(points, closed)| Leveled {
                    level: c.level,
                    points,
                    closed,
                })
                .collect()
        })
        .collect();
    spirals(
        shaped.into_iter().flatten().collect(),
        &SpiralOptions {
            stepover: how.stepover,
            gap: 0.7 * grid.step,
        },
    )
}

/// Corners of a loop are rounded to at most this share of the radius of a circle as long as it.
const ROUNDEST: f64 = 0.6;

/// Length of a loop, mm.
fn around(l: &[Point2]) -> f64 {
    let n = l.len();
    (0..n).map(|i| (l[(i + 1) % n] - l[i]).norm()).sum()
}

/// The ball at the points of a curve in plan where it rests, but for those that lie within `slack` of a straight line between others.
fn dropped(cutter: &DropCutter, curve: &[Point2], slack: f64) -> Vec<Point> {
    let mut hint = Hint::default();
    let all: Vec<Point> = curve
        .iter()
        .filter_map(|q| cutter.drop_near(q.x, q.y, &mut hint).map(|c| c.center))
        .collect();
    let straight = |i: usize, j: usize| {
        let e = all[j] - all[i];
        let l2 = e.norm_squared();
        all[i + 1..j].iter().all(|p| {
            let d = p - all[i];
            let along = if l2 > 0.0 { d.dot(&e) / l2 } else { 0.0 };
            (d - e * along).norm_squared() <= slack * slack
        })
    };
    let mut out: Vec<Point> = all.first().copied().into_iter().collect();
    let mut i = 0;
    while i + 1 < all.len() {
        let mut j = i + 1;
        while j + 1 < all.len() && j + 1 - i <= LONGEST_DRAFT && straight(i, j + 1) {
            j += 1;
        }
        out.push(all[j]);
        i = j;
    }
    out
}

/// Points that one segment of a draft may stand for.
const LONGEST_DRAFT: usize = 24;

/// The gradient of the tool-centre surface at places in plan; zero over empty air.
pub fn slopes(cutter: &DropCutter) -> impl FnMut(&Point2) -> Vector2 + '_ {
    let mut hint = Hint::default();
    move |q| {
        rest(cutter, q.x, q.y, &mut hint)
            .map_or(Vector2::zeros(), |r| -r.normal.xy() / r.normal.z.max(0.05))
    }
}

/// A curve in plan as smooth as [`FitOptions::bend`] asks, with points enough where it bends; a loop too narrow to go round in is one
/// stroke along its middle, or a small circle.
fn eased(
    cutter: &DropCutter,
    curve: &[Point2],
    closed: bool,
    fitting: &FitOptions,
) -> (Vec<Point2>, bool) {
    if fitting.bend <= 0.0 || curve.len() < 3 {
        return (curve.to_vec(), closed);
    }
    let length: f64 = curve.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let gap = length / (curve.len() - 1) as f64;
    let gap = gap.max(0.4 * fitting.bend).min(fitting.probe);
    let stroke = closed.then(|| middle(curve, fitting.bend)).flatten();
    if let Some(line) = &stroke
        && line.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>() < DAB * fitting.bend
    {
        return (dab(line, fitting.bend), true);
    }
    let closed = closed && stroke.is_none();
    let even = resample(stroke.as_deref().unwrap_or(curve), closed, gap);
    let rounding = Rounding {
        radius: fitting.bend,
        rounds: CORNER_ROUNDS,
        eats_tips: true,
    };
    let even = round_corners(even, closed, &rounding, &mut slopes(cutter));
    (refined(&even, closed), closed)
}

/// A loop whose middle line is shorter than this many of the tightest bends is gone round in a circle.
const DAB: f64 = 4.0;

/// The smallest circle that a pass may be, in the middle of a line.
fn dab(line: &[Point2], radius: f64) -> Vec<Point2> {
    let n = line.len().max(1) as f64;
    let sum = line.iter().fold(Vector2::zeros(), |s, p| s + p.coords);
    let middle = Point2::from(sum / n);
    (0..48)
        .map(|k| {
            let (s, c) = (f64::from(k) * std::f64::consts::TAU / 48.0).sin_cos();
            middle + Vector2::new(c, s) * radius
        })
        .collect()
}

/// The middle line of a closed curve that is on the whole no wider than `widest`, mm; `None` for a wider one.
fn middle(curve: &[Point2], widest: f64) -> Option<Vec<Point2>> {
    let n = curve.len();
    let (mut twice_area, mut round) = (0.0, 0.0);
    let first = curve.first()?;
    for i in 0..n {
        let (a, b) = (curve[i] - first, curve[(i + 1) % n] - first);
        twice_area += a.x * b.y - a.y * b.x;
        round += (b - a).norm();
    }
    // A strip of width w and length l: area w l, way round it 2 l.
    if round <= 0.0 || twice_area.abs() / round > widest {
        return None;
    }
    let farthest = |p: &Point2| {
        (0..n).max_by(|&i, &j| (curve[i] - p).norm().total_cmp(&(curve[j] - p).norm()))
    };
    let i = farthest(first)?;
    let j = farthest(&curve[i])?;
    let half = |from: usize, to: usize| -> Vec<Point2> {
        let steps = (to + n - from) % n;
        (0..=steps).map(|k| curve[(from + k) % n]).collect()
    };
    let (there, mut back) = (half(i, j), half(j, i));
    back.reverse();
    let count = there.len().max(back.len()).max(3);
    let spread = |half: &[Point2]| -> Vec<Point2> {
        let l: f64 = half.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        resample(half, false, (l / (count - 1) as f64) * (1.0 + 1e-9))
    };
    let (there, back) = (spread(&there), spread(&back));
    let line: Vec<Point2> = there
        .iter()
        .zip(&back)
        .map(|(a, b)| nalgebra::center(a, b))
        .collect();
    (line.len() > 1).then_some(line)
}

/// Drops and fits one curve in plan; a closed curve that stays whole comes back closed. Bends tighter than [`FitOptions::bend`] are
/// rounded first.
pub fn laid(
    cutter: &DropCutter,
    curve: &[Point2],
    closed: bool,
    fitting: &FitOptions,
) -> Vec<(Vec<Point>, bool)> {
    let (mut open, closed) = eased(cutter, curve, closed, fitting);
    if closed && let Some(first) = open.first().copied() {
        open.push(first);
    }
    let mut runs = fit(cutter, &open, fitting);
    if closed && runs.len() == 1 && runs[0].len() > 3 {
        runs[0].pop();
        return vec![(runs.swap_remove(0), true)];
    }
    runs.into_iter().map(|r| (r, false)).collect()
}

/// Level curves of a feature in plan, cut off where the ground was taken before, and where they run along a wall. `cut` are the earlier
/// features whose last pass runs on their rim.
fn trimmed_levels(
    grid: &ToolCentreGrid,
    feature: &Feature,
    cut: &[&Feature],
    steep: &Steep,
    stepover: f64,
) -> Vec<Leveled> {
    let value = |n: usize| feature.field.at(grid, n);
    let past_rims = |n: usize| {
        cut.iter()
            .map(|f| f.field.at(grid, n) - f.rim)
            .filter(|v| v.is_finite())
            .fold(FAR, f64::min)
    };
    let mut out = Vec::new();
    for curve in level_curves(grid, &value, &feature.levels) {
        let walls = steep.along(grid, &curve);
        let at: Vec<Trimmed> = curve
            .at
            .iter()
            .zip(walls)
            .map(|(e, wall)| {
                let free = e.value(|n| {
                    let f = feature.free.at(grid, n);
                    if f.is_finite() { f } else { -1.0 }
                });
                Trimmed {
                    at: e.xy(grid),
                    keep: if wall { -1.0 } else { free + OVERLAP },
                    rim: e.value(past_rims),
                    touches: [e.a, e.b]
                        .iter()
                        .any(|&n| grid.kind[n as usize] != NodeKind::Air),
                }
            })
            .collect();
        for (mut run, closed) in kept(&at, curve.closed) {
            // Fields go on a little beyond the outline, so that passes reach it. Where the ball still rolls round it that cuts; what lies
            // in the air altogether is no pass.
            if !run.iter().any(|t| t.touches) {
                continue;
            }
            if !closed {
                shorten(&mut run, stepover);
                run.reverse();
                shorten(&mut run, stepover);
                run.reverse();
            }
            if run.len() > 1 {
                out.push(Leveled {
                    level: curve.level,
                    points: run.into_iter().map(|t| t.at).collect(),
                    closed,
                });
            }
        }
    }
    out
}

/// "No rim near", in passes.
const FAR: f64 = 16.0;

/// A place on a level curve that is being trimmed.
#[derive(Clone, Copy, Debug)]
struct Trimmed {
    at: Point2,
    /// Not negative where it is kept.
    keep: f64,
    /// Passes to the nearest rim that is cut.
    rim: f64,
    /// The ball meets the part beside it.
    touches: bool,
}

/// Takes from the start of a run what the pass on a rim cuts anyway. Passes that meet the rim squarely may end half a pass from it (and
/// their U-turns then lie beside the rim instead of on it); one that meets it at a slant must go further, so that the ground between
/// its neighbour and the rim is nowhere wider than a pass.
fn shorten(run: &mut Vec<Trimmed>, stepover: f64) {
    let Some(first) = run.first().copied().filter(|t| t.rim < 0.5) else {
        return;
    };
    let mut length = 0.0;
    let mut rise = 0.0;
    for w in run.windows(2) {
        length += (w[1].at - w[0].at).norm();
        rise = w[1].rim - first.rim;
        if rise >= 0.6 || length > 2.0 * stepover {
            break;
        }
    }
    if length <= 0.0 {
        return;
    }
    let sin = (rise * stepover / length).clamp(0.0, 1.0);
    let end = (1.0 - (1.0 - sin * sin).sqrt()).min(0.5) - OVERLAP;
    if end <= first.rim {
        return;
    }
    match run.iter().position(|t| t.rim >= end) {
        Some(k) if k > 0 => {
            let (a, b) = (run[k - 1], run[k]);
            let t = (end - a.rim) / (b.rim - a.rim);
            run[k - 1].at = a.at + (b.at - a.at) * t;
            run[k - 1].rim = end;
            run.drain(..k - 1);
        }
        Some(_) => {}
        // All of it lies beside the rim.
        None => run.clear(),
    }
}

/// The runs of a curve along which it is kept, cut where that changes.
fn kept(at: &[Trimmed], closed: bool) -> Vec<(Vec<Trimmed>, bool)> {
    if at.iter().all(|a| a.keep >= 0.0) {
        return vec![(at.to_vec(), closed)];
    }
    let n = at.len();
    // A closed curve is walked from a place that is cut away, so that no run is split at its seam.
    let start = if closed {
        at.iter().position(|a| a.keep < 0.0).unwrap_or(0)
    } else {
        0
    };
    let steps = if closed { n + 1 } else { n };
    let mut out = Vec::new();
    let mut run: Vec<Trimmed> = Vec::new();
    let mut last: Option<Trimmed> = None;
    for k in 0..steps {
        let p = at[(start + k) % n];
        if let Some(q) = last
            && (p.keep >= 0.0) != (q.keep >= 0.0)
        {
            let t = q.keep / (q.keep - p.keep);
            run.push(Trimmed {
                at: q.at + (p.at - q.at) * t,
                keep: 0.0,
                rim: q.rim + (p.rim - q.rim) * t,
                touches: p.touches && q.touches,
            });
            if p.keep < 0.0 {
                out.push((std::mem::take(&mut run), false));
            }
        }
        if p.keep >= 0.0 {
            run.push(p);
        }
        last = Some(p);
    }
    if !run.is_empty() {
        out.push((run, false));
    }
    out.retain(|r| r.0.len() > 1);
    out
}

/// The runs of a curve on which the ball rests on the part rather than rolls round its outline. They end on the border, or as far
/// beyond it as the ground half a `stepover` beside them goes on: a pass that meets the border at a slant would otherwise leave a
/// corner of its strip.
fn on_ground(
    grid: &ToolCentreGrid,
    cutter: &DropCutter,
    curve: &[Point2],
    closed: bool,
    stepover: f64,
) -> Vec<(Vec<Point2>, bool)> {
    let mut hint = Hint::default();
    let reach = grid.outline_reach();
    let mut ask = |q: &Point2| -> bool {
        // Deep inside there is nothing to ask.
        let near = grid.nearest(q.x, q.y);
        let inner = near.is_some_and(|n| {
            (-1..=1).all(|dy| {
                (-1..=1).all(|dx| {
                    grid.neighbour(n, (dx, dy))
                        .is_some_and(|j| grid.kind[j] == NodeKind::Ground)
                })
            })
        });
        inner
            || cutter
                .drop_near(q.x, q.y, &mut hint)
                .is_some_and(|c: Contact| !cutter.on_outline(&c, reach))
    };
    let good: Vec<bool> = curve.iter().map(&mut ask).collect();
    if good.iter().all(|g| *g) {
        return vec![(curve.to_vec(), closed)];
    }
    let n = curve.len();
    let start = if closed {
        good.iter().position(|g| !g).unwrap_or(0)
    } else {
        0
    };
    let steps = if closed { n + 1 } else { n };
    let mut out: Vec<(Vec<Point2>, bool)> = Vec::new();
    let mut run: Vec<Point2> = Vec::new();
    // Whether the run began on the border.
    let mut entered = false;
    let mut last: Option<usize> = None;
    let mut ended =
        |mut run: Vec<Point2>, first: bool, last: bool, ask: &mut dyn FnMut(&Point2) -> bool| {
            if last {
                overrun(&mut run, stepover, ask);
            }
            if first {
                run.reverse();
                overrun(&mut run, stepover, ask);
                run.reverse();
            }
            out.push((run, false));
        };
    for k in 0..steps {
        let i = (start + k) % n;
        if let Some(j) = last
            && good[i] != good[j]
        {
            let (mut inside, mut outside) = if good[i] {
                (curve[i], curve[j])
            } else {
                (curve[j], curve[i])
            };
            while (outside - inside).norm() > 5e-4 {
                let m = nalgebra::center(&inside, &outside);
                if ask(&m) { inside = m } else { outside = m }
            }
            run.push(inside);
            if good[i] {
                entered = true;
            } else {
                ended(std::mem::take(&mut run), entered, true, &mut ask);
                entered = false;
            }
        }
        if good[i] {
            run.push(curve[i]);
        }
        last = Some(i);
    }
    if !run.is_empty() {
        ended(run, entered, false, &mut ask);
    }
    out
}

/// Lengthens a run straight on beyond its last point, which lies on the border, while there is ground half a stepover to either side of
/// it.
fn overrun(run: &mut Vec<Point2>, stepover: f64, ask: &mut dyn FnMut(&Point2) -> bool) {
    let n = run.len();
    // The heading over a third of a stepover: the last points are close together.
    let end = run[n - 1];
    let Some(back) = run
        .iter()
        .rev()
        .find(|q| (end - *q).norm() > 0.3 * stepover)
    else {
        return;
    };
    let along = (end - back).normalize();
    let aside = Vector2::new(-along.y, along.x) * (0.5 * stepover);
    let steps = 6;
    let gap = stepover / steps as f64;
    let far = (1..=steps)
        .take_while(|&k| {
            let q = end + along * (gap * k as f64);
            ask(&(q + aside)) || ask(&(q - aside))
        })
        .last();
    if let Some(k) = far {
        run.extend((1..=k).map(|i| end + along * (gap * i as f64)));
    }
}
