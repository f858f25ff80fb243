//! Laws of features: all ground is theirs, no two overlap, saddles stand on rims, and growing repeats itself.
#![allow(clippy::unwrap_used)]

use super::common::PARTS;
use super::morse::options;
use super::plans;
use morsemill::feature::{FeatureKind, FieldSource, Metrics, Regions, refield};
use morsemill::field::{Metric, Ruler};
use morsemill::reach::{DropCutter, NodeKind};
use morsemill::toolpath::Ground;
use morsemill::toolpath::PLAN_SHARES;
use morsemill::toolpath::plan::{Strategy, features, survey};

fn judge(name: &str, ground: &Ground, regions: &Regions) {
    let g = &ground.grid;
    for i in 0..g.len() {
        let label = usize::from(regions.label[i]);
        if g.kind[i] != NodeKind::Ground {
            assert_eq!(label, 0, "{name}: a node off the ground has a feature");
            continue;
        }
        assert!(
            label >= 1 && label <= regions.features.len(),
            "{name}: ground node {i} at {} has no feature",
            g.xy(i)
        );
    }
    let mut taken = vec![0u16; g.len()];
    let mut doubled = 0;
    for (k, f) in regions.features.iter().enumerate() {
        // What a feature grew over: within its rim, and not taken before. (Nodes on a rim, the saddle among them, are on both.)
        if f.kind != FeatureKind::Strip {
            for (i, t) in taken.iter_mut().enumerate() {
                if g.kind[i] == NodeKind::Ground
                    && f.field.at(g, i) <= f.rim
                    && f.free.at(g, i) > 0.0
                {
                    doubled += u32::from(*t != 0);
                    *t = k as u16 + 1;
                }
            }
        }
        let l = &f.levels;
        assert!(
            l.windows(2)
                .all(|w| w[1] > w[0] && w[1] - w[0] <= 1.0 + 1e-9),
            "{name}, feature {}: levels {l:?}",
            k + 1
        );
        if f.kind != FeatureKind::Strip {
            // From a rim that is cut already, the first pass is a whole step away.
            let first = match f.source {
                FieldSource::Rim(_) => 1.0,
                _ => 0.5,
            };
            assert!(l.first().is_none_or(|l| *l <= first + 1e-9));
        }
        // Beyond the last level there is at most one step to the rim (a neighbour's pass, or the border's loop).
        let last = l.last().copied().unwrap_or(0.0);
        assert!(
            f.rim - last <= 1.0 + 1e-9,
            "{name}: rim {} last {last}",
            f.rim
        );
        if let Some(s) = f.saddle.filter(|_| f.rim_is_cut()) {
            let v = f.field.at(g, ground.critical[s].node);
            assert!(
                (v - f.rim).abs() <= 1e-9 * f.rim,
                "{name}, feature {}: the saddle is at {v}, the rim at {}",
                k + 1,
                f.rim
            );
            assert!(
                (last - f.rim).abs() < 1e-9,
                "{name}: no pass through the saddle"
            );
        }
    }
    assert_eq!(doubled, 0, "{name}: nodes inside two rims");
    let area: f64 = regions.features.iter().map(|f| f.area_mm2).sum();
    let ground_area: f64 = (0..g.len())
        .filter(|i| g.kind[*i] == NodeKind::Ground)
        .map(|i| {
            let n = (g.center(i) - g.point[i]) / g.radius;
            g.step * g.step / n.z.clamp(0.05, 1.0)
        })
        .sum();
    assert!(
        (area - ground_area).abs() < 1e-6 * ground_area,
        "{name}: features {area} mm2, ground {ground_area} mm2"
    );
}

#[test]
fn all_ground_belongs_to_one_feature_and_saddles_stand_on_rims() {
    for p in plans::all() {
        let p = p.get().unwrap();
        judge(p.part.file, &p.ground, &p.plan.regions);
    }
    let cutter = DropCutter::new(&PARTS[1].mesh(), 3.0);
    let mut how = options(0.05);
    let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
    for strategy in [
        Strategy::IsoPickFeed,
        Strategy::Isoplanar(0.0),
        Strategy::Isoplanar(25.0),
    ] {
        how.strategy = strategy;
        judge(
            &format!("{strategy:?}"),
            &ground,
            &features(&ground, how.strategy, PLAN_SHARES[0] * how.scallop),
        );
    }
}

#[test]
fn growing_repeats_itself_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let cutter = DropCutter::new(&PARTS[1].mesh(), 3.0);
            let how = options(0.05);
            let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
            let r = features(&ground, how.strategy, PLAN_SHARES[0] * how.scallop);
            let bits: Vec<Vec<u64>> = r
                .features
                .iter()
                .map(|f| {
                    let own = [f.rim, f.area_mm2];
                    own.iter()
                        .chain(&f.levels)
                        .chain(&f.field.value)
                        .map(|v| v.to_bits())
                        .collect()
                })
                .collect();
            (r.label, bits)
        })
    };
    let first = run(1);
    assert!(first == run(3) && first == run(1));
}

/// Whatever its field begins at, a feature keeps its ground: no pass is kept further than a rounding outside of what it grew over, and
/// its fields leave no more than a small share of it to a fill.
#[test]
fn another_field_cuts_the_same_ground() {
    let cutter = DropCutter::new(&PARTS[1].mesh(), 3.0);
    let how = options(0.05);
    let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
    let g = &ground.grid;
    let spaced_for = PLAN_SHARES[0] * how.scallop;
    let grown = features(&ground, Strategy::IsoScallop, spaced_for);
    let cusp = Metric::new(g, Ruler::IsoScallop, spaced_for);
    let pick_feed = Metric::new(g, Ruler::IsoPickFeed, spaced_for);
    let metrics = Metrics {
        cusp: &cusp,
        pick_feed: Some(&pick_feed),
        over_share: 0.005,
    };
    let mut tried = 0;
    for (k, f) in grown.features.iter().enumerate() {
        if f.kind == FeatureKind::Strip {
            continue;
        }
        let mut sources = vec![
            FieldSource::Planes(0.0),
            FieldSource::Planes(70.0),
            FieldSource::PickFeed,
            FieldSource::Side("side -x".to_string()),
            FieldSource::Side("corner +x+y".to_string()),
        ];
        let seeds = grown.features[..k].iter().filter(|f| f.saddle.is_some());
        sources.extend(seeds.filter_map(|f| f.seed.map(FieldSource::Rim)));
        for source in sources {
            let Some(new) = refield(g, &metrics, &grown, k, &source, true) else {
                continue;
            };
            tried += 1;
            assert_eq!((new.area_mm2, new.kind), (f.area_mm2, f.kind));
            assert!(
                new.levels
                    .windows(2)
                    .all(|w| (w[1] - w[0] - 1.0).abs() < 1e-9)
            );
            assert!(new.rim - new.levels.last().copied().unwrap_or(0.0) <= 1.0 + 1e-9);
            let (mut mine, mut unreached) = (0, 0);
            for i in (0..g.len()).filter(|&i| g.kind[i] == NodeKind::Ground) {
                let inside = f.field.at(g, i) <= f.rim && f.free.at(g, i) >= 0.0;
                let free = new.free.at(g, i);
                assert!(
                    inside || !free.is_finite() || free <= 0.0,
                    "{source:?} at {}",
                    g.xy(i)
                );
                mine += usize::from(inside);
                unreached += usize::from(inside && !new.field.at(g, i).is_finite());
            }
            assert!(unreached * 200 <= mine, "{source:?}: {unreached} of {mine}");
        }
    }
    assert!(tried > 5, "{tried}");
}
