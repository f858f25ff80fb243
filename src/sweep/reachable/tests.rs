#![allow(clippy::unwrap_used)]
use super::underside::Underside;
use super::*;
use crate::geom::Point;
use crate::part::Mesh;
use proptest::prelude::*;

fn grid_mesh(n: usize, size: f64, z: impl Fn(f64, f64) -> f64) -> Mesh {
    let at = |i: usize, j: usize| {
        let (x, y) = (size * i as f64 / n as f64, size * j as f64 / n as f64);
        Point::new(x, y, z(x, y))
    };
    let mut mesh = Mesh::default();
    for j in 0..n {
        for i in 0..n {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([a, c, d]);
        }
    }
    mesh
}

/// Against brute force over all nodes, along the normal: how much too high at worst (must be nothing but what the
/// proof leaves open), and how many cells have any such excess over 0.01 um.
fn excess(mesh: &Mesh, radius: f64, step: f64) -> (f64, usize, usize) {
    let drop = DropCutter::new(mesh, radius);
    let r = reachable(&drop, step);
    let balls = drop.drop_all(&r.lattice);
    let f = Underside::new(&r.lattice, &balls.z, radius);
    let k = (radius / step).ceil() as i16;
    let over: Vec<f64> = (0..r.lattice.len())
        .into_par_iter()
        .filter(|&i| !r.part_z[i].is_nan())
        .map(|i| {
            let (ix, iy) = r.lattice.cell(i);
            let mut best = f64::INFINITY;
            for dy in -k..=k {
                for dx in -k..=k {
                    best = best.min(f.at(ix, iy, [dx, dy]));
                }
            }
            assert!(r.reach_z[i] >= r.part_z[i] - 0.02, "never into the part");
            (r.reach_z[i] - best) * f64::from(r.normal_z[i])
        })
        .collect();
    (
        over.iter().copied().fold(0.0, f64::max),
        over.iter().filter(|v| **v > 1e-5).count(),
        over.len(),
    )
}

fn rough(seed: u64) -> Mesh {
    let h = |i: u64, j: u64| {
        let mut v = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (i * 7919 + j * 104_729);
        v ^= v >> 31;
        v = v.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        v ^= v >> 29;
        (v % 1000) as f64 / 1000.0
    };
    match seed % 3 {
        0 => grid_mesh(24, 12.0, |x, y| {
            (4.0 * h((x / 2.5) as u64, (y / 2.5) as u64)).floor()
        }),
        1 => grid_mesh(16, 10.0, |x, y| {
            if h((x * 8.0) as u64, (y * 8.0) as u64) > 0.93 {
                4.0
            } else {
                0.0
            }
        }),
        _ => grid_mesh(20, 12.0, |x, y| {
            (x * 0.9 + h(0, 0)).sin() * (y * 0.8).cos() * 3.0 * h(1, 1)
        }),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn search_equals_brute_force_on_rough_ground(seed in 0u64..1_000_000) {
        // Steps, spikes and bumps by turns.
        let (worst, _, _) = excess(&rough(seed), 2.0, 0.1);
        prop_assert!(worst < 2.1e-4, "{worst}");
    }

    #[test]
    fn search_equals_brute_force_on_soups(corners in prop::collection::vec((0.0..8.0f64, 0.0..8.0f64, 0.0..4.0f64, -2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64), 1..30)) {
        let mut mesh = Mesh::default();
        for (x, y, z, a, b, c, d) in corners {
            mesh.triangles.push([Point::new(x, y, z), Point::new(x + a, y + b, z + c), Point::new(x + c, y + d, z + a)]);
        }
        let (worst, _, _) = excess(&mesh, 1.5, 0.1);
        prop_assert!(worst < 2.1e-4, "{worst}");
    }
}

/// Where the ball fits, the reachable surface is the part, to a fraction of a micrometre, flat or sloping.
#[test]
fn slopes_are_reached() {
    for slope in [0.0, 0.3, 1.0, 2.0] {
        let mesh = grid_mesh(1, 12.0, |x, y| slope * (0.8 * x + 0.6 * y));
        let r = reachable(&DropCutter::new(&mesh, 3.0), 0.05);
        let n = 1.0 / (1.0f64 + slope * slope).sqrt();
        let mut judged = 0;
        for i in 0..r.lattice.len() {
            if r.part_z[i].is_nan() {
                continue;
            }
            judged += 1;
            let rest = r.rest(i);
            assert!((-2e-4..1e-4).contains(&rest), "slope {slope}: {rest}");
            let c = r.lattice.center_at(i);
            if c.x.min(c.y) > 0.3 && c.x.max(c.y) < 11.7 {
                assert!((f64::from(r.normal_z[i]) - n).abs() < 2e-3);
            }
        }
        assert!(judged > 200 * 200);
    }
}

/// A bowl of radius 5 is reached by a ball of 3; one of radius 2 is not: there the ball rests on the rim.
#[test]
fn bowls() {
    let bowl = |b: f64| {
        grid_mesh(300, 12.0, move |x, y| {
            let d = (x - 6.0).powi(2) + (y - 6.0).powi(2);
            if d < b * b * 0.75 {
                b * 0.5 - (b * b - d).sqrt()
            } else {
                0.0
            }
        })
    };
    let r = reachable(&DropCutter::new(&bowl(4.5), 3.0), 0.05);
    let (ix, iy) = r.lattice.nearest(6.0, 6.0).unwrap();
    assert!(r.rest(r.lattice.index(ix, iy)).abs() < 2e-3);
    let r = reachable(&DropCutter::new(&bowl(2.0), 3.0), 0.05);
    // Rim radius sqrt(3), ball 3: the ball hangs 3 - sqrt(9 - 3) below the plane.
    let depth = 3.0 - 6.0f64.sqrt();
    let z = r.reach_z[r.lattice.index(ix, iy)];
    assert!((z + depth).abs() < 0.02, "{z}");
    assert!((r.part_z[r.lattice.index(ix, iy)] + 1.0).abs() < 1e-3);
}

/// In a right-angled valley the ball stands R sqrt(2) above the line; over the line it leaves R (sqrt(2) - 1), at any place
/// and direction of the lattice: the crease is found between the nodes.
#[test]
fn valley_is_exact_between_the_nodes() {
    let (r, step) = (3.0, 0.1);
    for turn in [0.0f64, 0.4, 0.79, 1.3] {
        for shift in [0.0, 0.013, 0.049] {
            let (c, s) = (turn.cos(), turn.sin());
            let p = |along: f64, across: f64| {
                Point::new(
                    c * along - s * across + shift,
                    s * along + c * across,
                    across.abs(),
                )
            };
            let (a, b, d, e) = (p(-9.0, 0.0), p(9.0, 0.0), p(9.0, 8.0), p(-9.0, 8.0));
            let (f, g) = (p(9.0, -8.0), p(-9.0, -8.0));
            let mesh = Mesh {
                triangles: vec![[a, b, d], [a, d, e], [a, g, f], [a, f, b]],
            };
            let m = reachable(&DropCutter::new(&mesh, r), step);
            for i in 0..m.lattice.len() {
                let q = m.lattice.center_at(i);
                let (x, y) = (q.x - shift, q.y);
                let (along, across) = (c * x + s * y, c * y - s * x);
                if along.abs() > 4.0 || across.abs() > 4.0 {
                    continue;
                }
                let want = if across.abs() < r / 2f64.sqrt() {
                    r * 2f64.sqrt() - (r * r - across * across).sqrt()
                } else {
                    across.abs()
                };
                let error = (m.reach_z[i] - want) * f64::from(m.normal_z[i]);
                assert!(
                    (-1e-4..1.2e-3).contains(&error),
                    "{turn} {shift} {q:?}: {error}"
                );
            }
        }
    }
}

#[test]
fn same_bits_for_any_number_of_threads_and_empty_parts() {
    let mesh = grid_mesh(40, 15.0, |x, y| (x * 0.8).sin() * 2.0 + (x - y).abs() * 0.3);
    let drop = DropCutter::new(&mesh, 2.0);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let r = pool.install(|| reachable(&drop, 0.1));
        (
            r.reach_z.iter().map(|z| z.to_bits()).collect::<Vec<_>>(),
            r.by,
            r.normal_z,
        )
    };
    assert_eq!(run(1), run(3));
    let none = reachable(&DropCutter::new(&Mesh::default(), 2.0), 0.1);
    assert!(none.lattice.is_empty() && none.reach_z.is_empty());
}

fn same(a: &Reachable, b: &Reachable) -> bool {
    let bits = |v: &[f64]| v.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
    a.lattice == b.lattice
        && bits(&a.part_z) == bits(&b.part_z)
        && bits(&a.reach_z) == bits(&b.reach_z)
        && a.by == b.by
        && a.normal_z == b.normal_z
}

/// A window gives the bits of the whole, wherever it lies: each cell depends on what is near it and nothing else.
#[test]
fn windows_are_parts_of_the_whole() {
    for seed in 0..6 {
        let mesh = rough(seed);
        let drop = DropCutter::new(&mesh, 2.0);
        let whole = lattice_for(&drop.bounds(), 2.0, 0.05);
        let all = window(&drop, &whole, 0..whole.nx, 0..whole.ny);
        for (columns, rows) in [
            (64..200, 128..256),
            (0..64, 64..70),
            (192..whole.nx, 0..whole.ny),
        ] {
            let part = window(&drop, &whole, columns.clone(), rows.clone());
            let mut cut = Reachable::nothing(part.lattice, 2.0);
            for i in 0..part.lattice.len() {
                let (x, y) = part.lattice.cell(i);
                let j = whole.index(x + columns.start, y + rows.start);
                cut.part_z[i] = all.part_z[j];
                cut.reach_z[i] = all.reach_z[j];
                cut.by[i] = all.by[j];
                cut.normal_z[i] = all.normal_z[j];
            }
            assert!(same(&cut, &part), "seed {seed}, {columns:?} {rows:?}");
        }
    }
}
