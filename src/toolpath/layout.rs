//! One way of cutting the whole part, laid from features to moves.
//!
//! ```text
//! regions -> passes -> (measured, metric evened out, regions and passes again) -> chains -> fill -> order -> link
//! ```

use super::chain::{Chain, ChainOptions, chains};
use super::choose::{Chosen, apply};
use super::detail::Detail;
use super::ease::{EaseOptions, GENTLE, OVER, SHARP, ease_chains, ease_passes};
use super::errand::{ErrandOptions, errands};
use super::even::{Above, EvenOptions, correction};
use super::fill::{FillOptions, FillReport, cusps_at_nodes, fill, segments};
use super::fit::FitOptions;
use super::link::{Air, LinkOptions, link};
use super::order::order;
use super::pass::{Fitted, Pass, PassKind, PassOptions, passes};
use super::pencil::needed;
use super::plan::{Candidate, Ground, Plan, PlanOptions, Stage, Strategy, Weigh};
use super::ridge::ridges;
use super::sharp::sharp_turns;
use crate::feature::{GrowOptions, Regions, Source, farthest, grow, whole};
use crate::field::{Front, Metric, Ruler};
use crate::geom::{Point, Point2};
use crate::morse::CriticalKind;
use crate::part::Mesh;
use crate::reach::{DropCutter, NodeKind, ToolCentreGrid};
use crate::sweep::ReachTiles;
use std::sync::OnceLock;

/// What becomes a feature.
#[derive(Clone, Debug, PartialEq)]
pub enum Layout {
    /// Features grown from critical points, in one of the feature-wise strategies.
    Features(Strategy),
    /// The whole part from one source, equal cusps.
    Whole(Source),
    /// The whole part in plane sections at this angle from X, degrees.
    Raster(f64),
    /// Ground parted by walls and sharp edges, each face of it as it is quickest.
    Faces,
}

impl Layout {
    /// A name for tables.
    pub fn name(&self) -> String {
        match self {
            Layout::Features(Strategy::Auto) => "each feature its quickest".to_string(),
            Layout::Features(s) => s.name().to_string(),
            Layout::Whole(s) => format!("whole from {}", s.name),
            Layout::Raster(angle) => format!("raster at {angle:.0} deg"),
            Layout::Faces => "each face its quickest".to_string(),
        }
    }
}

/// Everything a layout is laid with.
pub(super) struct Bench<'a> {
    pub ground: &'a Ground,
    pub detail: &'a Detail,
    pub reach: &'a ReachTiles<'a>,
    pub part: &'a Mesh,
    /// Laid over the part when the first link is: on a large part it need not be there before.
    pub air: &'a OnceLock<Air>,
    pub options: &'a PlanOptions,
    pub links: &'a LinkOptions,
    pub weigh: Weigh<'a>,
    /// What stands over is filled; a raster to compare with needs none.
    pub closed_loop: bool,
}

/// Cusps are planned at one of these shares of what is wanted; the rest is for what the field, the fit and the rounding take. Rough
/// ground gets closer passes by itself ([`super::even`]); where filling still costs more than closer passes everywhere would, the next
/// share is tried.
pub const PLAN_SHARES: [f64; 6] = [0.97, 0.935, 0.90, 0.84, 0.77, 0.70];
/// The first share leaves so much of the height that chords may leave standing.
const CHORDS: f64 = 0.6;
/// Grids with more nodes than this are laid once: what to lay is decided from estimates, and nothing is laid only to compare with.
pub(super) const LAID_TWICE: usize = 3_000_000;
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
/// Cells of the sweep map in a flat stepover: a cusp between two cells is then seen within a few percent.
pub const CELLS_PER_STEPOVER: f64 = 14.0;

/// Stepover that leaves a cusp of `scallop` on the flat, mm.
pub fn flat_stepover(scallop: f64, radius: f64) -> f64 {
    (8.0 * scallop * radius - 4.0 * scallop * scallop)
        .max(0.0)
        .sqrt()
}

/// Cells that are judged at most: beyond it nobody would wait.
const CELLS: f64 = 1e9;

/// Step of the sweep map over a part that resolves such a cusp, mm.
pub fn sweep_step(cutter: &DropCutter, scallop: f64) -> f64 {
    let (size, r) = (cutter.bounds().size(), cutter.radius());
    let area = (size.x + 2.0 * r) * (size.y + 2.0 * r);
    (flat_stepover(scallop, r) / CELLS_PER_STEPOVER).max((area / CELLS).sqrt())
}

impl Bench<'_> {
    /// Where the air begins.
    fn air(&self) -> &Air {
        self.air
            .get_or_init(|| Air::new(self.part, &self.ground.cutter, self.links))
    }

    /// The cusp metric that a layout's fields are made with, and its cusps judged by: that of faces sees nothing across what parts them.
    pub fn metric(&self, layout: &Layout, spaced_for: f64) -> Metric {
        let grid = &self.ground.grid;
        match (layout, &self.detail.faces) {
            (Layout::Faces, Some(f)) => Metric::new(&f.parted(grid), Ruler::IsoScallop, spaced_for),
            _ => Metric::new(grid, Ruler::IsoScallop, spaced_for),
        }
    }

    /// Features of a layout, in that metric, grown from critical points of at least this persistence; those of faces are without fields
    /// yet.
    pub fn regions(
        &self,
        layout: &Layout,
        spaced_for: f64,
        cusp: &Metric,
        persistence: f64,
    ) -> Regions {
        match (layout, &self.detail.faces) {
            (Layout::Faces, Some(f)) => f.regions(&self.ground.grid),
            _ => regions_of(self.ground, layout, spaced_for, cusp, persistence),
        }
    }

    /// Index of the widest share of the cusp that chords leave room for.
    fn first_share(&self) -> usize {
        let fitting = FitOptions::for_scallop(self.options.scallop, self.ground.cutter.radius());
        let most = 1.0 - CHORDS * fitting.stock / self.options.scallop;
        PLAN_SHARES
            .iter()
            .position(|s| *s <= most)
            .unwrap_or(PLAN_SHARES.len() - 1)
    }

    /// Whether the part is small enough to be laid several times over.
    pub fn small(&self) -> bool {
        self.ground.grid.len() <= LAID_TWICE
    }
}

/// Features of a layout, in a cusp metric whose unit is a cusp of `spaced_for` mm, grown from the critical points of at least some
/// persistence.
pub(super) fn regions_of(
    ground: &Ground,
    layout: &Layout,
    spaced_for: f64,
    cusp: &Metric,
    persistence: f64,
) -> Regions {
    let grid = &ground.grid;
    let mut how = GrowOptions {
        ruler: Ruler::IsoScallop,
        passes_min: 2.0,
        margin: 5.0,
        over_share: 0.005,
        persistence,
    };
    match layout {
        Layout::Features(strategy) => {
            how.ruler = strategy.ruler();
            let own =
                (how.ruler != Ruler::IsoScallop).then(|| Metric::new(grid, how.ruler, spaced_for));
            grow(
                grid,
                cusp,
                own.as_ref().unwrap_or(cusp),
                &ground.critical,
                &how,
            )
        }
        Layout::Whole(source) => whole(grid, cusp, cusp, source, &how),
        // Found once for a part: see `Bench::regions`.
        Layout::Faces => Regions {
            features: Vec::new(),
            label: vec![0; grid.len()],
        },
        Layout::Raster(angle) => {
            how.ruler = Strategy::Raster(Some(*angle)).ruler();
            how.over_share = 0.0;
            let own = Metric::new(grid, how.ruler, spaced_for);
            let source = raster_source(grid, how.ruler);
            whole(grid, cusp, &own, &source, &how)
        }
    }
}

/// Plane sections begin at the ground farthest back across them.
fn raster_source(grid: &ToolCentreGrid, ruler: Ruler) -> Source {
    let nodes = match ruler {
        Ruler::Isoplanar(across) => farthest(grid, &-across).into_iter().collect(),
        _ => Vec::new(),
    };
    Source {
        name: "raster".to_string(),
        nodes,
        front: Front::Straight,
    }
}

/// What is known of a plan before it is laid.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
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

/// Lays a layout, beginning at a known share, at the first of the shares whose fills cost no more than closer passes would. `fields` tells
/// how features are cut.
pub(super) fn lay(
    bench: &Bench,
    layout: &Layout,
    fields: &[Chosen],
    known: &Known,
    stage: &mut dyn FnMut(Stage),
) -> Plan {
    let least = bench.first_share();
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
        if next.cost() >= best.cost() {
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

fn lay_at(
    bench: &Bench,
    layout: &Layout,
    fields: &[Chosen],
    (share, persistence): (f64, f64),
    stage: &mut dyn FnMut(Stage),
) -> Plan {
    let Bench {
        ground,
        detail,
        reach,
        options,
        links,
        weigh,
        closed_loop,
        ..
    } = *bench;
    let (grid, cutter) = (&ground.grid, &ground.cutter);
    stage(Stage::Features);
    let is_raster = matches!(layout, Layout::Raster(_));
    let spaced_for = if is_raster {
        options.scallop
    } else {
        share * options.scallop
    };
    let fitting = FitOptions::for_scallop(options.scallop, cutter.radius());
    let mut metric = bench.metric(layout, spaced_for);
    let mut regions = bench.regions(layout, spaced_for, &metric, persistence);
    apply(grid, &metric, spaced_for, fields, &mut regions);
    stage(Stage::Passes);
    let stepover = flat_stepover(options.scallop, cutter.radius());
    let shape = PassOptions {
        stepover,
        detail: Fitted::Proven,
        corner: (links.feed * links.feed / (2.5 * links.acceleration)).min(CORNER * stepover),
    };
    let draft = PassOptions {
        detail: Fitted::Draft,
        ..shape
    };
    let first = |regions: &Regions| passes(grid, cutter, regions, &draft, &detail.steep, &fitting);
    if is_raster {
        // Its one step is measured, not reckoned: as wide as its worst place allows.
        let cusps = cusps_at_nodes(grid, reach, &first(&regions));
        let worst = highest_inside(grid, &cusps);
        widen(
            &mut regions,
            (options.scallop / worst).sqrt().clamp(0.5, 2.0),
        );
    } else if layout_ruler(layout) == Ruler::IsoScallop {
        let nodes = |stepovers: f64| (stepovers * stepover / grid.step).ceil() as usize;
        let above = Above {
            deviations: DEVIATIONS,
            within: nodes(ROUGHNESS),
        };
        // On a large part once is all there is time for: what hardly any cusp exceeds, right away.
        let rounds = [None, Some(above)];
        for &round in &rounds[usize::from(!bench.small())..] {
            let cusps = cusps_at_nodes(grid, reach, &first(&regions));
            let how = EvenOptions {
                spaced_for,
                reach: nodes(0.55),
                bounds: [0.9, 1.25],
                above: round,
            };
            let factor = correction(grid, &metric, &regions, cusps, &how);
            // On a large part two sets of fields are more than there is room for.
            drop(std::mem::take(&mut regions));
            for (t, f) in metric.tensor.iter_mut().zip(&factor) {
                t.iter_mut().for_each(|v| *v *= f64::from(*f));
            }
            regions = bench.regions(layout, spaced_for, &metric, persistence);
            apply(grid, &metric, spaced_for, fields, &mut regions);
        }
    }
    let mut laid = passes(grid, cutter, &regions, &shape, &detail.steep, &fitting);
    // What is shorter than its distance to the next is no pass: the fill finds what it would be missed for.
    laid.retain(|p| p.kind != PassKind::Level || p.closed || p.length() >= stepover);
    let walls = detail.walls(ground, &regions);
    if *layout == Layout::Faces {
        let ridges = ridges(grid, cutter, &regions, &metric, stepover, &fitting);
        let ridges = needed(ridges, cutter, &segments(&laid), options.scallop, stepover);
        laid.extend(ridges);
    }
    laid.extend(walls.passes);
    let pencils = detail.pencils(ground, &regions, &laid, options.scallop);
    laid.extend(pencils);
    drop(metric);
    let saddles = saddles(ground);
    let to_ease = easing(&fitting, stepover, &saddles);
    ease_passes(
        cutter,
        &mut laid,
        &EaseOptions {
            pass: EASED * stepover,
            crease: SHORT * stepover,
            climb: 0.0,
            over: &[],
            near_saddle: SHARP,
            ..to_ease
        },
    );
    let how = ChainOptions {
        stepover,
        reach: REACH,
    };
    let mut joined = chains(cutter, laid, &how, links, &fitting);
    ease_chains(
        cutter,
        &mut joined,
        &EaseOptions {
            climb: 0.0,
            ..to_ease
        },
    );
    stage(Stage::Fill);
    let mut all: Vec<Pass> = joined.iter().flatten().cloned().collect();
    let before = all.len();
    let to_fill = FillOptions {
        scallop: options.scallop,
        start: FILL_START,
        keep: 0.75,
        rounds: 8,
    };
    let fill = if closed_loop {
        fill(
            grid,
            &regions,
            reach,
            &mut all,
            &to_fill,
            &detail.steep.options,
            &fitting,
        )
    } else {
        FillReport::default()
    };
    stage(Stage::Link);
    let mut fills = all.split_off(before);
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
    let (toolpath, section_features) = link(
        cutter,
        bench.air(),
        &ordered,
        &regions,
        links,
        &fitting,
        &to_ease,
    );
    let passes: Vec<Pass> = ordered.into_iter().flatten().collect();
    let figures = weigh(&toolpath).with_turns(&sharp_turns(cutter, &toolpath));
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

/// The two rasters that a plan is compared with: linked staying down, and retracting to the safe height after each pass, at the job's
/// feed throughout, as rasters are: no link is slowed to keep the tool calm. A plan that is the first of them already needs only the
/// other.
pub(super) fn rasters(
    bench: &Bench,
    raster: Option<Layout>,
    chosen: &Plan,
    stage: &mut dyn FnMut(Stage),
) -> Vec<Candidate> {
    let mut out = Vec::new();
    let steady = LinkOptions {
        vertical: f64::INFINITY,
        ..*bench.links
    };
    let own;
    let raster = match &raster {
        Some(layout) => {
            let open = Bench {
                closed_loop: false,
                links: &steady,
                ..*bench
            };
            own = lay(&open, layout, &[], &Known::default(), stage);
            out.extend(own.candidates.iter().cloned());
            &own
        }
        None => chosen,
    };
    // The same passes, each a chain of its own, and no link worth staying down for.
    let apart: Vec<Chain> = raster
        .passes
        .iter()
        .filter(|p| p.kind != PassKind::Turn)
        .map(|p| vec![p.clone()])
        .collect();
    let links = LinkOptions {
        retract_worth: f64::NEG_INFINITY,
        retract_center_z: bench.links.safe_center_z,
        ..steady
    };
    let (cutter, count) = (&bench.ground.cutter, apart.len());
    let ordered = order(apart, home(cutter));
    let (path, _) = link(
        cutter,
        bench.air(),
        &ordered,
        &raster.regions,
        &links,
        &raster.fitting,
        &easing(
            &raster.fitting,
            flat_stepover(bench.options.scallop, cutter.radius()),
            &saddles(bench.ground),
        ),
    );
    let figures = (bench.weigh)(&path).with_turns(&sharp_turns(cutter, &path));
    let name = format!("{} retracting", raster.layout.name());
    out.push(Candidate::of(name, &path, count, figures));
    out
}

/// How corners of a finished path are eased: there is no fill behind it any more, so passes are hardly cut short.
fn easing<'a>(fitting: &FitOptions, stepover: f64, saddles: &'a [Point2]) -> EaseOptions<'a> {
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
fn saddles(ground: &Ground) -> Vec<Point2> {
    ground
        .critical
        .iter()
        .filter(|c| c.kind == CriticalKind::Saddle)
        .map(|c| c.center.xy())
        .collect()
}

/// Where the tool comes from: the corner of the part nearest the operator's zero, lowest x and y, from above.
fn home(cutter: &DropCutter) -> Point {
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
