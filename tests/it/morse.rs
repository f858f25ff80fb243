//! Laws of critical points: Euler's number, persistence, and the shipped parts' analytic truth from any side and under noise.
#![allow(clippy::unwrap_used)]

use super::common::{Chance, PARTS, Shipped, noisy, sheet, turn, turned};
use morsemill::geom::{Point, Point2};
use morsemill::morse::cancel::{peaks, pits};
use morsemill::morse::critical::{Link, Scalar, classify};
use morsemill::morse::{CriticalKind, CriticalPoint, HeightField, MorseOptions, critical_points};
use morsemill::part::Mesh;
use morsemill::reach::{DropCutter, NodeKind, ToolCentreGrid};
use morsemill::toolpath::Ground;
use morsemill::toolpath::plan::{PlanOptions, Strategy, survey};

const KINDS: [CriticalKind; 3] = [
    CriticalKind::Maximum,
    CriticalKind::Minimum,
    CriticalKind::Saddle,
];

/// An island by chance: random hills `n` by `n` nodes wide in a sea that falls away all round, so that its border holds no critical
/// point but one pit.
fn island(seed: u64, n: usize) -> (ToolCentreGrid, HeightField) {
    let mut chance = Chance(seed);
    let hills: Vec<[f64; 4]> = (0..12)
        .map(|_| {
            [
                chance.between(0.0, n as f64),
                chance.between(0.0, n as f64),
                chance.between(2.0, n as f64 / 4.0),
                chance.between(-1.0, 2.0),
            ]
        })
        .collect();
    let mut value = vec![0.0; n * n];
    for y in 0..n {
        for x in 0..n {
            let edge = x.min(y).min(n - 1 - x).min(n - 1 - y);
            let hill: f64 = hills
                .iter()
                .map(|h| {
                    let (u, v) = ((x as f64 - h[0]) / h[2], (y as f64 - h[1]) / h[2]);
                    h[3] * (-u * u - v * v).exp()
                })
                .sum();
            // Half of the islands are rounded to steps, so that ties abound.
            let hill = if seed.is_multiple_of(2) {
                hill
            } else {
                (hill * 8.0).round() / 8.0
            };
            value[y * n + x] = match edge {
                0 => -50.0,
                1 => -40.0,
                _ => 10.0 + hill + chance.between(0.0, 0.02) * (seed % 3) as f64,
            };
        }
    }
    let grid = ToolCentreGrid {
        origin: Point2::new(0.0, 0.0),
        step: 1.0,
        nx: n,
        ny: n,
        radius: 3.0,
        center_z: value.iter().map(|z| z + 3.0).collect(),
        point: (0..n * n)
            .map(|i| Point::new((i % n) as f64, (i / n) as f64, value[i]))
            .collect(),
        kind: vec![NodeKind::Ground; n * n],
        crossings: Vec::new(),
    };
    let field = HeightField {
        function: morsemill::morse::MorseFunction::Height,
        value,
        active: vec![true; n * n],
        roughness: 0.0,
    };
    (grid, field)
}

#[test]
fn peaks_less_saddles_plus_pits_is_eulers_number_at_any_threshold() {
    for seed in 0..40 {
        let (grid, field) = island(seed, 60);
        for persistence_mm in [0.0, 0.01, 0.05, 0.3, 2.0, 100.0] {
            let found = critical_points(&grid, &field, &MorseOptions { persistence_mm });
            let count = |k| found.iter().filter(|c| c.kind == k && !c.boundary).count() as i64;
            let [a, b, c] = KINDS.map(count);
            assert_eq!(
                a - c + b,
                1,
                "seed {seed}, threshold {persistence_mm}: {a} peaks, {b} pits, {c} saddles"
            );
            if persistence_mm > 50.0 {
                assert_eq!([a, b, c], [1, 0, 0], "seed {seed}");
            }
            // What stays is at least as persistent as asked.
            assert!(found.iter().all(|p| p.persistence >= persistence_mm));
        }
    }
}

#[test]
fn each_extreme_dies_at_a_saddle_of_its_own_as_high_as_its_persistence() {
    for seed in 100..130 {
        let (_, field) = island(seed, 40);
        let s = Scalar {
            nx: 40,
            value: &field.value,
            active: &field.active,
        };
        let mut arms_left = vec![0i64; field.value.len()];
        let (mut maxima, mut minima) = (0, 0);
        for (i, left) in arms_left.iter_mut().enumerate() {
            match classify(&s, i).0 {
                Link::Maximum => maxima += 1,
                Link::Minimum => minima += 1,
                Link::Saddle(arms) => *left = i64::from(arms),
                Link::Regular => {}
            }
        }
        let (tops, bottoms) = (peaks(&s), pits(&s));
        assert_eq!((tops.len(), bottoms.len()), (maxima, minima), "seed {seed}");
        for (pairs, sign) in [(&tops, 1.0), (&bottoms, -1.0)] {
            assert_eq!(pairs.iter().filter(|p| p.merge.is_none()).count(), 1);
            for p in pairs {
                let Some(m) = p.merge else { continue };
                let fall = sign * (field.value[p.extreme] - field.value[m]);
                assert!(fall >= 0.0 && (fall - p.persistence).abs() < 1e-12);
                arms_left[m] -= 1;
            }
        }
        // On an island every arm of every saddle ends one peak or one pit, and none is used twice.
        assert!(arms_left.iter().all(|a| *a == 0), "seed {seed}");
    }
}

pub fn options(scallop: f64) -> PlanOptions {
    PlanOptions {
        function: morsemill::morse::MorseFunction::Height,
        scallop,
        strategy: Strategy::IsoScallop,
        grid_step: None,
        persistence: None,
        memory_limit_bytes: 1 << 30,
        wall_angle: 75.0,
        floor: None,
        flute: 20.0,
        deepest: f64::INFINITY,
    }
}

fn surveyed(mesh: &Mesh, scallop: f64) -> Ground {
    let cutter = DropCutter::new(mesh, 3.0);
    survey(cutter, &options(scallop), &mut |_, _| {}, &mut |_| {}).unwrap()
}

/// What speaks against some critical points being those of the part, turned by `degrees`.
fn complaints(part: &Shipped, found: &[CriticalPoint], degrees: f64, within: f64) -> Vec<String> {
    let truth = part.truth();
    let mut out = Vec::new();
    for (kind, name) in KINDS.iter().zip(["max", "min", "saddle"]) {
        let want = truth["counts"][name].as_u64().unwrap() as usize;
        let got = found.iter().filter(|c| c.kind == *kind).count();
        if want != got {
            out.push(format!("{name}: {got}, must be {want}"));
        }
    }
    for told in truth["critical_points"].as_array().unwrap() {
        let kind = match told["type"].as_str().unwrap() {
            "max" => CriticalKind::Maximum,
            "min" => CriticalKind::Minimum,
            _ => CriticalKind::Saddle,
        };
        let at = |k: &str| told[k].as_f64().unwrap();
        let place = turn(&Point::new(at("x"), at("y"), at("z")), degrees);
        let miss = found
            .iter()
            .filter(|c| c.kind == kind)
            .map(|c| (c.contact.xy() - place.xy()).norm())
            .fold(f64::INFINITY, f64::min);
        if miss > within {
            out.push(format!(
                "{} ({}) at {place:.3}: the nearest is {miss:.3} mm away",
                told["type"], told["where"]
            ));
        }
    }
    out
}

const ANGLES: [f64; 6] = [0.0, 10.0, 37.0, 45.0, 90.0, 133.0];

/// Each part as it is and from one of the other sides in turn, for time; the whole table is the ignored test below.
#[test]
fn shipped_parts_have_their_analytic_critical_points_from_any_side() {
    from_sides(|k| vec![ANGLES[0], ANGLES[1 + k % 5]]);
}

#[test]
#[ignore = "36 surveys, half a minute: run with --ignored"]
fn shipped_parts_have_their_analytic_critical_points_from_all_sides() {
    from_sides(|_| ANGLES.to_vec());
}

fn from_sides(angles: impl Fn(usize) -> Vec<f64>) {
    let mut wrong = Vec::new();
    for (k, part) in PARTS.iter().enumerate() {
        let mesh = part.mesh();
        for degrees in angles(k) {
            let ground = surveyed(&turned(&mesh, degrees), 0.02);
            // A scan with holes and 5 um of noise has no place to a grid step: its bumps move a flat top by more.
            let within = if part.smooth {
                ground.grid.step
            } else {
                5.0 * ground.grid.step
            };
            for c in complaints(part, &ground.critical, degrees, within) {
                wrong.push(format!("{} turned by {degrees}: {c}", part.file));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn two_micrometres_of_noise_change_no_count() {
    let mut wrong = Vec::new();
    for part in PARTS.iter().filter(|p| p.smooth) {
        for seed in [2u64] {
            let mesh = noisy(&part.mesh(), 0.002, seed);
            let degrees = 20.0 * seed as f64 - 20.0;
            let ground = surveyed(&turned(&mesh, degrees), 0.02);
            for c in complaints(part, &ground.critical, degrees, 5.0 * ground.grid.step) {
                wrong.push(format!("{} with noise {seed}: {c}", part.file));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_flat_top_is_one_peak_and_a_flat_floor_one_pit() {
    // A mesa and a basin, both flat over many nodes, with flanks as smooth as a cosine, in a flat plain.
    let flank = |r: f64, from: f64, to: f64| {
        let t = ((r - from) / (to - from)).clamp(0.0, 1.0);
        0.5 + 0.5 * (t * std::f64::consts::PI).cos()
    };
    let f = |x: f64, y: f64| {
        let mesa = 4.0 * flank((x - 14.0).hypot(y - 14.0), 5.0, 14.0);
        mesa - 3.0 * flank((x - 36.0).hypot(y - 32.0), 4.0, 12.0)
    };
    let mesh = sheet([0.0, 0.0], [50.0, 46.0], [200, 184], f);
    let ground = surveyed(&mesh, 0.02);
    let inner = |k| {
        ground
            .critical
            .iter()
            .filter(|c| c.kind == k && !c.boundary)
            .count()
    };
    assert_eq!(
        (inner(CriticalKind::Maximum), inner(CriticalKind::Minimum)),
        (1, 1),
        "{:?}",
        ground.critical
    );
}
