//! Lays a layout, from features to moves, at the widest spacing that pays.
//!
//! ```text
//! regions -> passes -> (measured, metric evened out, regions and passes again) -> chains -> fill -> order -> link
//! ```
//!
//! Crosses the border: a layout and a surveyed part in, a [`Plan`] with everything seen on the way out.

use super::choose::{Chosen, apply};
use super::even::{Above, EvenOptions, correction};
use super::layout::{Bench, Layout, flat_stepover};
use super::{Candidate, Ground, Plan, Stage, Strategy};
use crate::feature::Regions;
use crate::field::{Metric, Ruler};
use crate::geom::{Point, Point2};
use crate::morse::CriticalKind;
use crate::reach::{DropCutter, NodeKind, ToolCentreGrid};
use crate::toolpath::ease::{EaseOptions, GENTLE, OVER, SHARP, ease_chains, ease_passes};
use crate::toolpath::fill::{FillOptions, FillReport, cusps_at_nodes, fill, segments};
use crate::toolpath::fit::FitOptions;
use crate::toolpath::link::chain::{Chain, ChainOptions, chains};
use crate::toolpath::link::errand::{ErrandOptions, errands};
use crate::toolpath::link::link;
use crate::toolpath::link::order::order;
use crate::toolpath::pass::pencil::needed;
use crate::toolpath::pass::ridge::ridges;
use crate::toolpath::pass::{Fitted, Pass, PassKind, PassOptions, passes};
use crate::toolpath::sharp::sharp_turns;
use crate::toolpath::wall::Walls;

/// Cusps are planned at one of these shares of what is wanted; the rest is for what the field, the fit and the rounding take. Rough
/// ground gets closer passes by itself ([`super::even`]); where filling still costs more than closer passes everywhere would, the next
/// share is tried.
pub const PLAN_SHARES: [f64; 6] = [0.97, 0.935, 0.90, 0.84, 0.77, 0.70];
/// The first share leaves so much of the height that chords may leave standing.
const CHORDS: f64 = 0.6;
/// Passes are spaced for so many standard deviations of the cusps over their mean ...
const DEVIATIONS: f32 = 2.5;
/// ... told within so many stepovers: roughness is much the same so far, curvature still is.
const ROUGHNESS: f64 = 2.5;
/// Fills no longer than this share of the passes are not worth a second plan.
const FILL_SHARE: f64 = 0.005;
/// Fill where a cusp is higher than this share of what is wanted. All of it: fill measures as exactly as the dry run does, and a little more
/// of it costs about one per cent of the time at most (measured on the test parts against 1.015, which left 20.6 um for 20).
pub const FILL_START: f64 = 1.0;
/// Corners are rounded to at most this share of the stepover: wider arcs leave a cusp that costs more to fill.
const CORNER: f64 = 0.6;
/// Ends of passes further apart than this many stepovers are not joined into a chain.
const REACH: f64 = 6.0;
/// Chains shorter than this many stepovers are cut on the way past them.
const ERRAND: f64 = 12.0;
/// ... by passes that come by within so many.
const AWAY: f64 = 8.0;
/// What is known of a plan before it is laid.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::toolpath) struct Known {
    /// Index into [`PLAN_SHARES`] of the share to begin with.
    pub share: usize,
    /// Features grow from critical points of at least this persistence.
    pub persistence: f64,
    /// Its like has been laid with other shares already: this one is the best.
    pub settled: bool,
    /// What is slower than this by more than [`HOPELESS`] is not tried again with other shares, s.
    pub to_beat: Option<f64>,
}

/// A plan that is slower than another by more than this share of its time will not win with another share of the cusp.
pub const HOPELESS: f64 = 0.10;

/// Index of the widest share of the cusp that chords leave room for.
fn first_share(bench: &Bench) -> usize {
    let scallop = bench.options.scallop;
    let fitting = FitOptions::for_scallop(scallop, bench.ground.cutter.radius());
    let most = 1.0 - CHORDS * fitting.stock / scallop;
    PLAN_SHARES
        .iter()
        .position(|s| *s <= most)
        .unwrap_or(PLAN_SHARES.len() - 1)
}

/// Lays a layout, beginning at a known share, at the first of the shares whose fills cost no more than closer passes would. `fields` tells
/// how features are cut.
pub(in crate::toolpath) fn lay(
    bench: &Bench,
    layout: &Layout,
    fields: &[Chosen],
    known: &Known,
    stage: &mut dyn FnMut(Stage),
) -> Plan {
    let least = first_share(bench);
    let persistence = known.persistence;
    if !bench.small() {
        return lay_at(
            bench,
            layout,
            fields,
            (PLAN_SHARES[least], persistence),
            stage,
        );
    }
    let first = known.share.clamp(least, PLAN_SHARES.len() - 1);
    let mut best = lay_at(
        bench,
        layout,
        fields,
        (PLAN_SHARES[first], persistence),
        stage,
    );
    if matches!(layout, Layout::Raster(_)) || known.settled {
        return best;
    }
    let clean =
        |p: &Plan| p.fill.length_mm <= FILL_SHARE * p.passes.iter().map(Pass::length).sum::<f64>();
    for &share in &PLAN_SHARES[first + 1..] {
        let hopeless = known
            .to_beat
            .is_some_and(|t| best.figures.time_s > (1.0 + HOPELESS) * t);
        if hopeless || clean(&best) {
            break;
        }
        let next = lay_at(bench, layout, fields, (share, persistence), stage);
        if next.figures.cost() >= best.figures.cost() {
            break;
        }
        best = next;
    }
    best
}

/// Corners of passes are cut short by at most this share of a stepover on either side.
const EASED: f64 = 0.45;
/// And by this share where no fill comes behind: a cusp grows by less than a tenth from it.
const SHORT: f64 = 0.15;
/// In a crease, in the same measure.
const HARDLY: f64 = 0.04;

/// Fields, passes and their cusps once or twice over, then everything else.
fn lay_at(
    bench: &Bench,
    layout: &Layout,
    fields: &[Chosen],
    (share, persistence): (f64, f64),
    stage: &mut dyn FnMut(Stage),
) -> Plan {
    let (ground, links) = (bench.ground, bench.links);
    let scallop = bench.options.scallop;
    let (grid, cutter) = (&ground.grid, &ground.cutter);
    stage(Stage::Features);
    let spaced_for = match layout {
        Layout::Raster(_) => scallop,
        _ => share * scallop,
    };
    let fitting = FitOptions::for_scallop(scallop, cutter.radius());
    let stepover = flat_stepover(scallop, cutter.radius());
    let shape = PassOptions {
        stepover,
        detail: Fitted::Proven,
        corner: (links.feed * links.feed / (2.5 * links.acceleration)).min(CORNER * stepover),
    };
    let mut metric = bench.metric(layout, spaced_for);
    let mut regions = bench.regions(layout, spaced_for, &metric, persistence);
    apply(grid, &metric, spaced_for, fields, &mut regions);
    stage(Stage::Passes);
    let draft = |regions: &Regions| {
        let shape = PassOptions {
            detail: Fitted::Draft,
            ..shape
        };
        let laid = passes(grid, cutter, regions, &shape, &bench.detail.steep, &fitting);
        cusps_at_nodes(grid, bench.reach, &laid)
    };
    if matches!(layout, Layout::Raster(_)) {
        // Its one step is measured, not reckoned: as wide as its worst place allows.
        let worst = highest_inside(grid, &draft(&regions));
        widen(&mut regions, (scallop / worst).sqrt().clamp(0.5, 2.0));
    } else if layout_ruler(layout) == Ruler::IsoScallop {
        for how in evenings(bench, spaced_for, stepover) {
            let factor = correction(grid, &metric, &regions, draft(&regions), &how);
            // On a large part two sets of fields are more than there is room for.
            drop(std::mem::take(&mut regions));
            for (t, f) in metric.tensor.iter_mut().zip(&factor) {
                t.iter_mut().for_each(|v| *v *= f64::from(*f));
            }
            regions = bench.regions(layout, spaced_for, &metric, persistence);
            apply(grid, &metric, spaced_for, fields, &mut regions);
        }
    }
    let (laid, walls) = all_passes(bench, layout, &regions, metric, &shape, &fitting);
    let saddles = saddles(ground);
    let to_ease = easing(&fitting, stepover, &saddles);
    let how = ChainOptions {
        stepover,
        reach: REACH,
    };
    let mut joined = chains(cutter, eased(cutter, laid, &to_ease), &how, links, &fitting);
    ease_chains(
        cutter,
        &mut joined,
        &EaseOptions {
            climb: 0.0,
            ..to_ease
        },
    );
    stage(Stage::Fill);
    let (fill, mut fills) = filled(bench, &regions, &joined, &fitting);
    stage(Stage::Link);
    ease_passes(
        cutter,
        &mut fills,
        &EaseOptions {
            over: &[],
            near_saddle: SHARP,
            ..to_ease
        },
    );
    joined.extend(chains(cutter, fills, &how, links, &fitting));
    let how = ErrandOptions {
        longest: ERRAND * stepover,
        reach: AWAY * stepover,
    };
    let joined = errands(cutter, joined, &how, links, &fitting);
    let ordered = order(joined, home(cutter));
    let air = bench.air();
    let (toolpath, section_features) =
        link(cutter, air, &ordered, &regions, links, &fitting, &to_ease);
    let passes: Vec<Pass> = ordered.into_iter().flatten().collect();
    let figures = (bench.weigh)(&toolpath).with_turns(&sharp_turns(cutter, &toolpath));
    let cutting = passes.iter().filter(|p| p.kind != PassKind::Turn).count();
    Plan {
        candidates: vec![Candidate::of(layout.name(), &toolpath, cutting, figures)],
        regions,
        passes,
        fill,
        toolpath,
        section_features,
        fitting,
        spaced_for,
        too_deep: walls.too_deep,
        uncut_wall: walls.uncut,
        saddles: Vec::new(),
        layout: layout.clone(),
        figures,
    }
}

/// How a metric is evened out, round after round. On a large part once is all there is time for: what hardly any cusp exceeds, right away.
fn evenings(bench: &Bench, spaced_for: f64, stepover: f64) -> Vec<EvenOptions> {
    let nodes = |stepovers: f64| (stepovers * stepover / bench.ground.grid.step).ceil() as usize;
    let above = Above {
        deviations: DEVIATIONS,
        within: nodes(ROUGHNESS),
    };
    [None, Some(above)][usize::from(!bench.small())..]
        .iter()
        .map(|round| EvenOptions {
            spaced_for,
            reach: nodes(0.55),
            bounds: [0.9, 1.25],
            above: *round,
        })
        .collect()
}

/// Every pass that is laid before the fill, and what was found on the walls.
fn all_passes(
    bench: &Bench,
    layout: &Layout,
    regions: &Regions,
    metric: Metric,
    shape: &PassOptions,
    fitting: &FitOptions,
) -> (Vec<Pass>, Walls) {
    let (ground, detail, stepover) = (bench.ground, bench.detail, shape.stepover);
    let (grid, cutter) = (&ground.grid, &ground.cutter);
    let mut laid = passes(grid, cutter, regions, shape, &detail.steep, fitting);
    // What is shorter than its distance to the next is no pass: the fill finds what it would be missed for.
    laid.retain(|p| p.kind != PassKind::Level || p.closed || p.length() >= stepover);
    let mut walls = detail.walls(ground, regions);
    if *layout == Layout::Faces {
        let ridges = ridges(grid, cutter, regions, &metric, stepover, fitting);
        let scallop = bench.options.scallop;
        laid.extend(needed(ridges, cutter, &segments(&laid), scallop, stepover));
    }
    laid.append(&mut walls.passes);
    let pencils = detail.pencils(ground, regions, &laid, bench.options.scallop);
    laid.extend(pencils);
    (laid, walls)
}

/// Passes with their corners eased as far as the fill behind them can bear.
fn eased(cutter: &DropCutter, mut laid: Vec<Pass>, how: &EaseOptions) -> Vec<Pass> {
    ease_passes(
        cutter,
        &mut laid,
        &EaseOptions {
            pass: EASED * how.stepover,
            crease: SHORT * how.stepover,
            climb: 0.0,
            over: &[],
            near_saddle: SHARP,
            ..*how
        },
    );
    laid
}

/// What it takes to leave no cusp over.
fn filled(
    bench: &Bench,
    regions: &Regions,
    joined: &[Chain],
    fitting: &FitOptions,
) -> (FillReport, Vec<Pass>) {
    if !bench.closed_loop {
        return (FillReport::default(), Vec::new());
    }
    let mut all: Vec<Pass> = joined.iter().flatten().cloned().collect();
    let before = all.len();
    let how = FillOptions {
        scallop: bench.options.scallop,
        start: FILL_START,
        keep: 0.75,
        rounds: 8,
    };
    let grid = &bench.ground.grid;
    let walls = &bench.detail.steep.options;
    let report = fill(grid, regions, bench.reach, &mut all, &how, walls, fitting);
    (report, all.split_off(before))
}

/// How corners of a finished path are eased: there is no fill behind it any more, so passes are hardly cut short.
pub(super) fn easing<'a>(
    fitting: &FitOptions,
    stepover: f64,
    saddles: &'a [Point2],
) -> EaseOptions<'a> {
    EaseOptions {
        pass: SHORT * stepover,
        crease: HARDLY * stepover,
        climb: 0.5,
        link: 7.0 * stepover,
        over: OVER,
        gouge: fitting.gouge,
        decimal: fitting.decimal,
        saddles,
        near_saddle: GENTLE,
        stepover,
    }
}

/// The saddles of a surveyed part in plan.
pub(super) fn saddles(ground: &Ground) -> Vec<Point2> {
    ground
        .critical
        .iter()
        .filter(|c| c.kind == CriticalKind::Saddle)
        .map(|c| c.center.xy())
        .collect()
}

/// Where the tool comes from: the corner of the part nearest the operator's zero, lowest x and y, from above.
pub(super) fn home(cutter: &DropCutter) -> Point {
    let b = cutter.bounds();
    Point::new(b.min.x, b.min.y, b.max.z + cutter.radius())
}

fn layout_ruler(layout: &Layout) -> Ruler {
    match layout {
        Layout::Features(s) => s.ruler(),
        Layout::Whole(_) | Layout::Faces => Ruler::IsoScallop,
        Layout::Raster(a) => Strategy::Raster(Some(*a)).ruler(),
    }
}

/// The highest cusp further than half a millimetre inside the border, mm; never zero.
fn highest_inside(grid: &ToolCentreGrid, cusps: &[f32]) -> f64 {
    let n = (0.5 / grid.step).ceil() as i32;
    let ground = |i: usize, d: (i32, i32)| {
        grid.neighbour(i, d)
            .is_some_and(|j| grid.kind[j] == NodeKind::Ground)
    };
    (0..grid.len())
        .filter(|&i| {
            [(n, 0), (-n, 0), (0, n), (0, -n)]
                .iter()
                .all(|d| ground(i, *d))
        })
        .map(|i| f64::from(cusps[i]))
        .fold(1e-6, f64::max)
}

/// Sets the levels of every feature to a step of `by` units.
fn widen(regions: &mut Regions, by: f64) {
    for f in &mut regions.features {
        let gap = match f.levels.as_slice() {
            [a, b, ..] => (b - a) * by,
            _ => continue,
        };
        f.levels = (0..)
            .map(|k| (k as f64 + 0.5) * gap)
            .take_while(|l| *l < f.rim)
            .collect();
    }
}
