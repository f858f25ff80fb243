//! How each feature is cut: from its seed, a rim, a side, or in plane sections, whichever takes least time at equal cusps.
//!
//! Decided once for a layout, on a coarse copy of its features, and applied to the features as they grow again with every share of the
//! cusp and every correction of the metric: a choice is known by the critical point its feature grew from.

use super::Strategy;
use super::estimate::{coarser, feature_time};
use super::lay::PLAN_SHARES;
use super::layout::{Bench, Layout};
use crate::feature::source::{nodes, shared, widest_step};
use crate::feature::{
    Feature, FeatureKind, FieldSource, Metrics, Regions, Window, refield, sources,
};
use crate::field::{Metric, Ruler};
use crate::geom::{Point2, Vector2};
use crate::morse::CriticalKind;
use crate::reach::{NodeKind, ToolCentreGrid};
use rayon::prelude::*;

/// A feature and how it is cut.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::toolpath) struct Chosen {
    /// The critical point it grew from.
    seed: Option<usize>,
    /// A place in it, for one that grew from none.
    place: Point2,
    source: FieldSource,
}

/// Share of the ground that may get a cusp over the wanted one from plane sections, before filling.
const OVER_SHARE: f64 = 0.005;
/// The same of faces: creases run through them, which pencils cut.
const OVER_SHARE_OF_FACES: f64 = 0.02;
/// Directions of plane sections that are tried.
const ANGLES: usize = 12;
/// ... of which so many, the shortest, are looked at closely.
const CLOSELY: usize = 2;
/// Turns weigh so many times what they take: they are what shakes the tool up and down, and where chains break.
const TURNS: f64 = 2.0;
/// Rims beside a feature that are tried, the longest first.
const RIMS: usize = 3;
/// A rim shorter than this share of the feature's width is none to begin at.
const RIM_SHARE: f64 = 0.5;
/// Another field must win by this share of the time: the estimate is no better ...
const WINS_BY: f64 = 0.02;
/// ... and by this where it takes the place of loops about a peak or a pit, which keep the tool level.
const LOOPS_WORTH: f64 = 0.05;
/// A rim that is not cut costs its neighbours a fill along this share of it.
const RIM_UNCUT: f64 = 0.5;

/// How the features of a layout are cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::toolpath) struct Choice {
    /// Only what differs from the seed's own field.
    pub fields: Vec<Chosen>,
    /// About how long all features take, s.
    pub time: f64,
    /// Features grow from critical points of at least this persistence.
    pub persistence: f64,
}

impl Choice {
    /// The one strategy that all of it is, or [`Strategy::Auto`] for a mixture.
    pub fn strategy(&self) -> Strategy {
        let other = |c: &Chosen| matches!(c.source, FieldSource::Planes(_) | FieldSource::PickFeed);
        if self.fields.iter().any(other) {
            Strategy::Auto
        } else {
            Strategy::IsoScallop
        }
    }
}

/// Ways of merging features that are weighed.
const LADDER: usize = 4;
/// A feature costs a way to where it begins: about half as long as it is wide.
const WAY_THERE: f64 = 0.5;

/// Persistences below which critical points may be passed over. One that was asked for stands; a large part is laid once.
fn ladder(bench: &Bench) -> Vec<f64> {
    let saddles: Vec<f64> = (bench.ground.critical.iter())
        .filter(|c| c.kind == CriticalKind::Saddle)
        .map(|c| c.persistence)
        .collect();
    if bench.options.persistence.is_some() || !bench.small() {
        return vec![0.0];
    }
    rungs(saddles)
}

/// None, and steps that each leave fewer of the saddles, down to the last one: a feature that costs more to reach, and to end passes on,
/// than it saves is none.
fn rungs(mut saddles: Vec<f64>) -> Vec<f64> {
    saddles.retain(|p| p.is_finite());
    saddles.sort_by(f64::total_cmp);
    let mut out = vec![0.0];
    // The strongest stays: without it there are no features, and the whole part as one is weighed by itself.
    let Some((strongest, others)) = saddles.split_last() else {
        return out;
    };
    for k in 1..LADDER {
        let gone = others.len() * k / (LADDER - 1);
        let Some(last) = gone.checked_sub(1).and_then(|i| others.get(i)) else {
            continue;
        };
        // Just above it, so that it goes too.
        let above = last.next_up();
        if out.last() != Some(&above) && *strongest >= above {
            out.push(above);
        }
    }
    out
}

/// Chooses how each feature of a layout is cut, for several ways of merging features; never none.
pub(in crate::toolpath) fn choose(bench: &Bench, layout: &Layout) -> Vec<Choice> {
    match layout {
        // Faces grow from no critical point.
        Layout::Faces => vec![choose_from(bench, layout, 0.0)],
        Layout::Features(Strategy::Auto | Strategy::IsoScallop) => ladder(bench)
            .into_iter()
            .map(|persistence| choose_from(bench, layout, persistence))
            .collect(),
        _ => vec![Choice::default()],
    }
}

fn choose_from(bench: &Bench, layout: &Layout, persistence: f64) -> Choice {
    let mixed = matches!(layout, Layout::Features(Strategy::Auto) | Layout::Faces);
    let fine = &bench.ground.grid;
    let spaced_for = PLAN_SHARES[0] * bench.options.scallop;
    let regions = {
        let cusp = bench.metric(layout, spaced_for);
        bench.regions(layout, spaced_for, &cusp, persistence)
    };
    let (grid, every) = coarser(fine);
    let regions = thinned(fine, &grid, every, &regions);
    let parted = match (layout, &bench.detail.faces) {
        (Layout::Faces, Some(f)) => Some(coarser(&f.parted(fine)).0),
        _ => None,
    };
    let cusp = Metric::new(
        parted.as_ref().unwrap_or(&grid),
        Ruler::IsoScallop,
        spaced_for,
    );
    let pick_feed =
        (mixed && parted.is_none()).then(|| Metric::new(&grid, Ruler::IsoPickFeed, spaced_for));
    let metrics = Metrics {
        cusp: &cusp,
        pick_feed: pick_feed.as_ref(),
        over_share: over_share(&regions),
    };
    let mut cut_rims: Vec<bool> = Vec::new();
    let mut out = Vec::new();
    let mut time = 0.0;
    for (k, f) in regions.features.iter().enumerate() {
        let best = best(bench, &grid, &metrics, &regions, k, &cut_rims, mixed);
        cut_rims.push(f.saddle.is_some() && best.is_none());
        let refielded = best.as_ref().and_then(|s| {
            let cut = match s {
                FieldSource::Rim(seed) => regions.features[..k]
                    .iter()
                    .position(|f| f.seed == Some(*seed))
                    .is_some_and(|j| cut_rims[j]),
                _ => false,
            };
            refield(&grid, &metrics, &regions, k, s, cut)
        });
        time += feature_time(1.0, bench, &grid, &cusp, refielded.as_ref().unwrap_or(f));
        time += WAY_THERE * f.area_mm2.max(0.0).sqrt() / bench.links.feed;
        if let Some(source) = best {
            out.push(Chosen {
                seed: f.seed,
                place: middle(&grid, &regions, k),
                source,
            });
        }
    }
    Choice {
        fields: out,
        time,
        persistence,
    }
}

/// The quickest field of a feature, if it is not the seed's own.
fn best(
    bench: &Bench,
    grid: &ToolCentreGrid,
    metrics: &Metrics,
    regions: &Regions,
    index: usize,
    cut_rims: &[bool],
    mixed: bool,
) -> Option<FieldSource> {
    let f = &regions.features[index];
    let face = f.kind == FeatureKind::Face;
    // Strips run along their rims already.
    if !face && (f.kind == FeatureKind::Strip || f.levels.len() < 3) {
        return None;
    }
    let beside = shared(grid, regions, index);
    let mut rims: Vec<(f64, usize)> = (0..index)
        .filter(|&j| regions.features[j].saddle.is_some())
        .filter(|&j| beside[j] > RIM_SHARE * f.area_mm2.max(0.0).sqrt())
        .filter_map(|j| Some((beside[j], regions.features[j].seed?)))
        .collect();
    rims.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut tried: Vec<FieldSource> = rims
        .iter()
        .take(RIMS)
        .map(|r| FieldSource::Rim(r.1))
        .collect();
    let mut alone = grid.clone();
    for (n, kind) in alone.kind.iter_mut().enumerate() {
        if regions.label[n] as usize != index + 1 {
            *kind = NodeKind::Air;
        }
    }
    tried.extend(
        sources(&alone)
            .into_iter()
            .map(|s| FieldSource::Side(s.name)),
    );
    if face {
        tried.extend([FieldSource::Feet, FieldSource::Around]);
    }
    if mixed {
        if !face {
            tried.push(FieldSource::PickFeed);
        }
        tried.extend(
            angles(bench, grid, metrics, regions, index)
                .into_iter()
                .map(FieldSource::Planes),
        );
    }
    // A face has no field yet.
    let own = if face {
        f64::INFINITY
    } else {
        feature_time(TURNS, bench, grid, metrics.cusp, f)
    };
    let uncut: f64 = if f.saddle.is_some() {
        let later: f64 = beside[index..].iter().sum();
        RIM_UNCUT * later / bench.links.feed
    } else {
        0.0
    };
    let times: Vec<Option<f64>> = tried
        .par_iter()
        .map(|source| {
            let rim_is_cut = match source {
                FieldSource::Rim(seed) => (0..index)
                    .find(|&j| regions.features[j].seed == Some(*seed))
                    .is_some_and(|j| cut_rims[j]),
                _ => false,
            };
            let g = refield(grid, metrics, regions, index, source, rim_is_cut)?;
            Some(uncut + feature_time(TURNS, bench, grid, metrics.cusp, &g))
        })
        .collect();
    let quickest = (0..tried.len())
        .filter_map(|i| times[i].map(|t| (t, i)))
        .reduce(|a, b| if b.0 < a.0 { b } else { a })?;
    let by = if matches!(f.kind, FeatureKind::Peak | FeatureKind::Pit) {
        LOOPS_WORTH
    } else {
        WINS_BY
    };
    (quickest.0 < (1.0 - by) * own).then(|| tried[quickest.1].clone())
}

/// Directions (degrees) in which plane sections of a feature are shortest, the best first.
fn angles(
    bench: &Bench,
    grid: &ToolCentreGrid,
    metrics: &Metrics,
    regions: &Regions,
    index: usize,
) -> Vec<f64> {
    let f = &regions.features[index];
    let mine: Vec<usize> = nodes(grid, f)
        .filter(|&n| grid.kind[n] == NodeKind::Ground && regions.label[n] as usize == index + 1)
        .collect();
    let turn = bench.links.feed / bench.links.acceleration + 2.0 * grid.step / bench.links.feed;
    let mut all: Vec<(f64, f64)> = (0..ANGLES)
        .filter_map(|k| {
            let angle = 180.0 * k as f64 / ANGLES as f64;
            let (s, c) = angle.to_radians().sin_cos();
            let across = Vector2::new(-s, c);
            let step = widest_step(
                metrics.cusp,
                mine.iter().copied(),
                &across,
                metrics.over_share,
            )?;
            let (lo, hi) = mine
                .iter()
                .map(|&n| grid.xy(n).coords.dot(&across))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |r, v| {
                    (r.0.min(v), r.1.max(v))
                });
            let time = f.area_mm2 / (step * bench.links.feed) + (hi - lo) / step * turn;
            Some((time, angle))
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    all.into_iter().take(CLOSELY).map(|a| a.1).collect()
}

/// Gives features the fields that were chosen for them.
pub(in crate::toolpath) fn apply(
    grid: &ToolCentreGrid,
    cusp: &Metric,
    spaced_for: f64,
    chosen: &[Chosen],
    regions: &mut Regions,
) {
    if chosen.is_empty() {
        return;
    }
    let pick_feed = chosen
        .iter()
        .any(|c| c.source == FieldSource::PickFeed)
        .then(|| Metric::new(grid, Ruler::IsoPickFeed, spaced_for));
    let metrics = Metrics {
        cusp,
        pick_feed: pick_feed.as_ref(),
        over_share: over_share(regions),
    };
    let source_of = |k: usize, f: &Feature| -> Option<&Chosen> {
        chosen.iter().find(|c| match (c.seed, f.seed) {
            (Some(a), Some(b)) => a == b,
            (None, None) => regions.feature_at(grid, &c.place) == Some(k),
            _ => false,
        })
    };
    let wanted: Vec<Option<&Chosen>> = regions
        .features
        .iter()
        .enumerate()
        .map(|(k, f)| source_of(k, f))
        .collect();
    let new: Vec<Option<Feature>> = (0..wanted.len())
        .into_par_iter()
        .map(|k| {
            let Some(c) = wanted[k] else {
                // A face must have some field.
                return (regions.features[k].kind == FeatureKind::Face)
                    .then(|| refield(grid, &metrics, regions, k, &FieldSource::Planes(0.0), false))
                    .flatten();
            };
            let rim_is_cut = match c.source {
                FieldSource::Rim(seed) => regions
                    .features
                    .iter()
                    .position(|f| f.seed == Some(seed))
                    .is_some_and(|j| wanted[j].is_none()),
                _ => false,
            };
            refield(grid, &metrics, regions, k, &c.source, rim_is_cut).or_else(|| {
                (regions.features[k].kind == FeatureKind::Face)
                    .then(|| refield(grid, &metrics, regions, k, &FieldSource::Planes(0.0), false))
                    .flatten()
            })
        })
        .collect();
    for (f, new) in regions.features.iter_mut().zip(new) {
        if let Some(new) = new {
            *f = new;
        }
    }
}

/// Share of the ground of such features that may get a cusp over the wanted one from plane sections.
fn over_share(regions: &Regions) -> f64 {
    let faces = regions.features.iter().any(|f| f.kind == FeatureKind::Face);
    if faces {
        OVER_SHARE_OF_FACES
    } else {
        OVER_SHARE
    }
}

/// A place well inside a feature: the node of its ground that is nearest to their middle.
fn middle(grid: &ToolCentreGrid, regions: &Regions, index: usize) -> Point2 {
    let Some(f) = regions.features.get(index) else {
        return Point2::origin();
    };
    let mine: Vec<Point2> = nodes(grid, f)
        .filter(|&n| regions.label[n] as usize == index + 1)
        .map(|n| grid.xy(n))
        .collect();
    let sum: Vector2 = mine.iter().map(|p| p.coords).sum();
    let mean = Point2::from(sum / (mine.len().max(1)) as f64);
    mine.into_iter()
        .map(|p| ((p - mean).norm(), p))
        .reduce(|a, b| if b.0 < a.0 { b } else { a })
        .map_or(mean, |a| a.1)
}

/// Regions on every k-th node.
fn thinned(fine: &ToolCentreGrid, coarse: &ToolCentreGrid, every: usize, of: &Regions) -> Regions {
    let same = |i: usize| (i / coarse.nx) * every * fine.nx + (i % coarse.nx) * every;
    let mut scratch = vec![f64::INFINITY; coarse.len()];
    let mut window = |w: &Window| {
        let mut there: Vec<u32> = Vec::new();
        for (row, columns) in w.spans() {
            let y = row / every;
            if row % every != 0 || y >= coarse.ny {
                continue;
            }
            for x in columns.start.div_ceil(every)..columns.end.div_ceil(every).min(coarse.nx) {
                let i = y * coarse.nx + x;
                scratch[i] = w.at(fine, same(i));
                there.push(i as u32);
            }
        }
        let out = Window::around(coarse, &there, &scratch);
        there
            .iter()
            .for_each(|&i| scratch[i as usize] = f64::INFINITY);
        out
    };
    Regions {
        features: of
            .features
            .iter()
            .map(|f| Feature {
                field: window(&f.field),
                free: window(&f.free),
                ..f.clone()
            })
            .collect(),
        label: (0..coarse.len()).map(|i| of.label[same(i)]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each rung leaves fewer saddles than the one below it, the strongest always, and no more rungs than are weighed.
    #[test]
    fn each_rung_leaves_fewer_saddles_and_the_strongest_stays() {
        assert_eq!(rungs(Vec::new()), [0.0]);
        assert_eq!(rungs(vec![0.7]), [0.0]);
        assert_eq!(rungs(vec![0.2, 0.2, 0.2]), [0.0]);
        assert_eq!(rungs(vec![f64::INFINITY, 0.3, f64::NAN]), [0.0]);
        for n in 2..30 {
            let saddles: Vec<f64> = (1..=n).rev().map(|k| 0.1 * f64::from(k)).collect();
            let left = |rung: &f64| saddles.iter().filter(|s| *s >= rung).count();
            let out = rungs(saddles.clone());
            assert!((2..=LADDER).contains(&out.len()), "{out:?}");
            assert!(out.windows(2).all(|w| left(&w[1]) < left(&w[0])), "{out:?}");
            assert_eq!(out.last().map(left), Some(1), "{out:?}");
        }
    }
}
