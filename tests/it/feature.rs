//! Laws of features: all ground is theirs, no two overlap, saddles stand on rims, and growing repeats itself.
#![allow(clippy::unwrap_used)]

use super::common::PARTS;
use super::morse::options;
use super::plans;
use morsemill::feature::{FeatureKind, Regions};
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
            assert!(l.first().is_none_or(|l| *l <= 0.5 + 1e-9));
        }
        // Beyond the last level there is at most one step to the rim (a neighbour's pass, or the border's loop).
        let last = l.last().copied().unwrap_or(0.0);
        assert!(
            f.rim - last <= 1.0 + 1e-9,
            "{name}: rim {} last {last}",
            f.rim
        );
        if let Some(s) = f.saddle {
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
