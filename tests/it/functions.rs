//! Laws of the Morse functions, on raw meshes and on the grid: Euler's number on every surface, what turning leaves alone, what is known
//! exactly of balls, tori, ellipsoids and sheets, and meshes nobody would wish for.
#![allow(clippy::unwrap_used)]

use super::common::{Chance, sheet, soup};
use morsemill::geom::{Point, Vector};
use morsemill::morse::mesh::values;
use morsemill::morse::{
    AverageOptions, CriticalKind, CriticalPoint, FieldOptions, GridField, GridMorse, MeshMorse,
    MeshOptions, MorseFunction, Plane, Surface, average_distance,
};
use morsemill::part::{Mesh, check};
use morsemill::reach::{DropCutter, GridOptions, GridPlan, NodeKind, ToolCentreGrid};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const HOW: MeshOptions = MeshOptions {
    radius: 0.8,
    average: AverageOptions {
        samples: 64,
        seeds: 4000,
    },
};

fn surface(mesh: &Mesh) -> Surface {
    Surface::of_mesh(mesh, &check(mesh))
}

/// A closed or open surface over a rectangle of parameters; `round` says which of them come back to their start.
fn tube(n: [usize; 2], round: [bool; 2], at: impl Fn(f64, f64) -> Point) -> Mesh {
    let place = |i: usize, j: usize| {
        let (i, j) = (
            if round[0] { i % n[0] } else { i },
            if round[1] { j % n[1] } else { j },
        );
        at(i as f64 / n[0] as f64, j as f64 / n[1] as f64)
    };
    let mut mesh = Mesh::default();
    for j in 0..n[1] {
        for i in 0..n[0] {
            let [a, b, c, d] = [
                place(i, j),
                place(i + 1, j),
                place(i + 1, j + 1),
                place(i, j + 1),
            ];
            for t in [[a, b, c], [a, c, d]] {
                if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                    mesh.triangles.push(t);
                }
            }
        }
    }
    mesh
}

/// A ball by subdividing an icosahedron, outward.
fn ball(radius: f64, times: usize) -> Mesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut corner = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-g, g] {
            corner.extend([
                Point::new(0.0, a, b),
                Point::new(a, b, 0.0),
                Point::new(b, 0.0, a),
            ]);
        }
    }
    let mut mesh = Mesh::default();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [corner[i], corner[j], corner[k]];
                let near = |p: &Point, q: &Point| ((p - q).norm() - 2.0).abs() < 1e-9;
                if near(&a, &b) && near(&b, &c) && near(&c, &a) {
                    let out = (b - a).cross(&(c - a)).dot(&a.coords) > 0.0;
                    mesh.triangles.push(if out { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    let mid = |a: &Point, b: &Point| {
        // The same bits from either side.
        let (a, b) = if (a.x, a.y, a.z) < (b.x, b.y, b.z) {
            (a, b)
        } else {
            (b, a)
        };
        nalgebra::center(a, b)
    };
    for _ in 0..times {
        mesh.triangles = mesh
            .triangles
            .iter()
            .flat_map(|t| {
                let [p, q, r] = [mid(&t[0], &t[1]), mid(&t[1], &t[2]), mid(&t[2], &t[0])];
                [[t[0], p, r], [p, t[1], q], [r, q, t[2]], [p, q, r]]
            })
            .collect();
    }
    for p in mesh.triangles.iter_mut().flatten() {
        *p = Point::from(p.coords.normalize() * radius);
    }
    mesh
}

/// A torus standing upright (its axis along X), or lying when `up` is false; a little off the symmetric position.
fn torus(big: f64, small: f64, n: [usize; 2], up: bool) -> Mesh {
    tube(n, [true, true], |u, v| {
        let (su, cu) = (TAU * u + 0.013).sin_cos();
        let (sv, cv) = (TAU * v + 0.007).sin_cos();
        let r = big + small * cv;
        if up {
            Point::new(small * sv, r * cu, r * su)
        } else {
            Point::new(r * cu, r * su, small * sv)
        }
    })
}

fn rotated(mesh: &Mesh, axis: Vector, degrees: f64) -> Mesh {
    let turn = nalgebra::Rotation3::from_axis_angle(
        &nalgebra::Unit::new_normalize(axis),
        degrees.to_radians(),
    );
    Mesh {
        triangles: mesh.triangles.iter().map(|t| t.map(|p| turn * p)).collect(),
    }
}

fn count(points: &[CriticalPoint], kind: CriticalKind) -> usize {
    points.iter().filter(|c| c.kind == kind).count()
}

fn counts(points: &[CriticalPoint]) -> [usize; 3] {
    [
        CriticalKind::Maximum,
        CriticalKind::Saddle,
        CriticalKind::Minimum,
    ]
    .map(|k| count(points, k))
}

fn bumps(x: f64, y: f64) -> f64 {
    let hill = |cx: f64, cy: f64, h: f64, s: f64| {
        h * (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * s * s)).exp()
    };
    hill(10.0, 12.0, 6.0, 4.0) + hill(28.0, 20.0, 4.0, 5.0) - hill(20.0, 30.0, 3.0, 3.5) + 0.03 * x
        - 0.05 * y
}

#[test]
fn a_ball_has_the_same_mean_distance_everywhere_and_it_is_a_quarter_turn() {
    let r = 10.0;
    let s = surface(&ball(r, 5));
    let mu = average_distance(&s, &AverageOptions::default());
    let want = r * FRAC_PI_2;
    for m in &mu {
        assert!((m / want - 1.0).abs() < 0.012, "{m}, must be {want}");
    }
}

#[test]
fn mean_distance_on_a_square_is_the_integral() {
    // Coarse and fine, even and with long skinny triangles: the same function.
    let side = 40.0;
    let flat = |n: [usize; 2]| surface(&sheet([0.0; 2], [side; 2], n, |_, _| 1.0));
    let exact = |x: f64, y: f64| {
        let n = 200;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let at = |k: usize| (k as f64 + 0.5) / n as f64 * side;
                sum += (at(i) - x).hypot(at(j) - y);
            }
        }
        sum / (n * n) as f64
    };
    for n in [[4, 4], [40, 40], [300, 2], [150, 150]] {
        let s = flat(n);
        let mu = average_distance(&s, &AverageOptions::default());
        for (k, p) in s.points.iter().enumerate().step_by(s.len() / 15) {
            let want = exact(p.x, p.y);
            assert!(
                (mu[k] / want - 1.0).abs() < 0.012,
                "{n:?} at {p}: {}, must be {want}",
                mu[k]
            );
        }
    }
}

#[test]
fn mean_distance_on_a_cylinder_is_that_of_the_unrolled_sheet() {
    // Long skinny triangles all round, as CAD writes them.
    let (r, h) = (5.0, 30.0);
    let mesh = tube([60, 1], [true, false], |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        Point::new(r * c, r * s, h * v)
    });
    let s = surface(&mesh);
    let mu = average_distance(&s, &AverageOptions::default());
    let want = {
        let (nu, nv) = (400, 400);
        let mut sum = 0.0;
        for i in 0..nu {
            for j in 0..nv {
                let u = ((i as f64 + 0.5) / nu as f64 - 0.5) * TAU * r;
                sum += u.hypot((j as f64 + 0.5) / nv as f64 * h);
            }
        }
        sum / (nu * nv) as f64
    };
    for m in &mu {
        assert!((m / want - 1.0).abs() < 0.015, "{m}, must be {want}");
    }
}

#[test]
fn curvature_of_balls_cylinders_and_saddles_is_known() {
    // A ball: 1/r. A cylinder: 1/2r, whatever its triangles. A saddle z = xy: 0 in the middle.
    for times in [3, 5] {
        let s = surface(&ball(4.0, times));
        for h in values(&s, MorseFunction::MeanCurvature, &HOW) {
            assert!((h * 4.0 - 1.0).abs() < 0.03, "{h}");
        }
    }
    for n in [[90, 40], [40, 200], [300, 12]] {
        let s = surface(&tube(n, [true, false], |u, v| {
            let (s, c) = (TAU * u).sin_cos();
            Point::new(5.0 * c, 5.0 * s, 20.0 * v)
        }));
        for (p, h) in s
            .points
            .iter()
            .zip(values(&s, MorseFunction::MeanCurvature, &HOW))
        {
            if p.z > 2.0 && p.z < 18.0 {
                assert!((h.abs() * 10.0 - 1.0).abs() < 0.03, "{n:?}: {h}");
            }
        }
    }
    let s = surface(&sheet([-5.0; 2], [5.0; 2], [60; 2], |x, y| 0.2 * x * y));
    for (p, h) in s
        .points
        .iter()
        .zip(values(&s, MorseFunction::MeanCurvature, &HOW))
    {
        if p.x.abs() < 0.01 && p.y.abs() < 0.01 {
            assert!(h.abs() < 1e-3, "{h}");
        }
    }
    // Hollow is negative: a bowl seen from above, whichever way its triangles are wound.
    let mut bowl = sheet([-5.0; 2], [5.0; 2], [60; 2], |x, y| 0.05 * (x * x + y * y));
    for _ in 0..2 {
        let s = surface(&bowl);
        for (p, h) in s
            .points
            .iter()
            .zip(values(&s, MorseFunction::MeanCurvature, &HOW))
        {
            if p.x.hypot(p.y) < 0.1 {
                assert!((h + 0.1).abs() < 0.004, "{h}");
            }
        }
        bowl.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
}

#[test]
fn eulers_number_holds_for_every_function_on_every_surface() {
    let disc = tube([60, 12], [true, false], |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        let (x, y) = (16.0 * v * c, 16.0 * v * s);
        Point::new(20.0 + x, 20.0 + y, bumps(20.0 + x, 20.0 + y))
    });
    let ring = tube([60, 12], [true, false], |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        let (x, y) = ((6.0 + 10.0 * v) * c, (6.0 + 10.0 * v) * s);
        Point::new(20.0 + x, 20.0 + y, bumps(20.0 + x, 20.0 + y))
    });
    let two = Mesh {
        triangles: ball(3.0, 3)
            .triangles
            .into_iter()
            .chain(torus(20.0, 4.0, [60, 24], true).triangles)
            .collect(),
    };
    for (name, mesh, chi) in [
        ("ball", ball(7.0, 4), 2),
        ("torus", torus(12.0, 4.0, [80, 36], true), 0),
        ("disc", disc, 1),
        ("ring", ring, 0),
        ("sheet", sheet([0.0; 2], [40.0; 2], [50; 2], bumps), 1),
        ("ball and torus", two, 2),
    ] {
        let s = surface(&mesh);
        assert_eq!(s.euler(), chi, "{name}");
        let closed = !s.border.contains(&true);
        for f in MorseFunction::ALL {
            let v = values(&s, f, &HOW);
            let m = MeshMorse::new(&s, &v);
            assert_eq!(m.euler.characteristic, chi);
            assert!(m.euler.holds(), "{name}, {}: {:?}", f.name(), m.euler);
            for limit in [0.0, 0.001, 0.1, 1.0] {
                let points = m.critical_points(limit);
                if closed {
                    let [a, b, c] = counts(&points).map(|n| n as i64);
                    assert_eq!(a - b + c, chi, "{name}, {}, {limit}", f.name());
                }
                // Hills make up the whole, and so do basins; no cell without its extreme.
                let cells = m.cells(&points, limit);
                for kind in [CriticalKind::Maximum, CriticalKind::Minimum] {
                    let own = || cells.iter().filter(|c| points[c.extreme].kind == kind);
                    let area: f64 = own().map(|c| c.area_mm2).sum();
                    let whole: f64 = s.area.iter().sum();
                    assert!((area / whole - 1.0).abs() < 1e-9, "{name}, {}", f.name());
                    assert_eq!(own().map(|c| c.triangles).sum::<usize>(), s.triangles.len());
                }
            }
        }
    }
}

#[test]
fn heights_of_tori_ellipsoids_bumps_and_monkeys_have_their_critical_points() {
    let of = |mesh: &Mesh, limit: f64| {
        let s = surface(mesh);
        let v = values(&s, MorseFunction::Height, &HOW);
        let points = MeshMorse::new(&s, &v).critical_points(limit);
        (counts(&points), points)
    };
    // Upright torus: 1 peak, 2 saddles, 1 pit, at R + r, R - r, r - R, -R - r.
    let (n, points) = of(&torus(12.0, 4.0, [90, 40], true), 0.0);
    assert_eq!(n, [1, 2, 1]);
    for (c, z) in points.iter().zip([16.0, -16.0, 8.0, -8.0]) {
        assert!((c.value - z).abs() < 0.06, "{c:?}");
    }
    let ellipsoid = |a: f64, b: f64, c: f64| {
        let mut m = ball(1.0, 4);
        for p in m.triangles.iter_mut().flatten() {
            *p = Point::new(a * p.x, b * p.y, c * p.z);
        }
        rotated(&m, Vector::new(1.0, 2.0, 0.5), 33.0)
    };
    assert_eq!(of(&ellipsoid(3.0, 5.0, 9.0), 0.0).0, [1, 0, 1]);
    // Two bumps and a hollow, all inside, the border falling away evenly: a disc cut at a level below.
    let (n, points) = of(&sheet([0.0; 2], [40.0; 2], [120; 2], bumps), 0.05);
    let inner = |k| points.iter().filter(|c| c.kind == k && !c.boundary).count();
    assert_eq!(
        (inner(CriticalKind::Maximum), inner(CriticalKind::Minimum)),
        (2, 2),
        "{n:?}"
    );
    // A monkey saddle: z = x^3 - 3 x y^2 counts twice.
    let monkey = tube([60, 20], [true, false], |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        let (x, y) = (v * c, v * s);
        Point::new(x, y, x * x * x - 3.0 * x * y * y)
    });
    let (n, points) = of(&monkey, 0.0);
    assert_eq!(n[1], 2, "{points:?}");
    let saddles: Vec<_> = points
        .iter()
        .filter(|c| c.kind == CriticalKind::Saddle)
        .collect();
    assert_eq!(saddles[0].node, saddles[1].node);
    assert_eq!(
        (n[0], n[2]),
        (3, 3),
        "three hills and three valleys end on the border"
    );
}

#[test]
fn turning_a_part_leaves_its_own_functions_alone() {
    let part = sheet([0.0; 2], [40.0; 2], [80; 2], bumps);
    let torus = torus(12.0, 4.0, [80, 36], true);
    for mesh in [part, torus] {
        let s = surface(&mesh);
        for f in [MorseFunction::MeanCurvature, MorseFunction::Geodesic] {
            let v = values(&s, f, &HOW);
            let range = v.iter().fold(f64::MIN, |a, b| a.max(*b))
                - v.iter().fold(f64::MAX, |a, b| a.min(*b));
            for degrees in [90.0, 37.0] {
                let t = surface(&rotated(&mesh, Vector::new(0.3, -1.0, 0.4), degrees));
                let w = values(&t, f, &HOW);
                // An open sheet turned over shows its other side, hollow for bulging.
                let close = match f {
                    MorseFunction::MeanCurvature => 1e-9 * range,
                    // Vertices at equal distances are chosen by rounding.
                    _ => 0.01 * v[0],
                };
                let sign = if v.iter().zip(&w).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                for (a, b) in v.iter().zip(&w) {
                    assert!((a - sign * b).abs() < close, "{}: {a} {b}", f.name());
                }
            }
        }
    }
}

#[test]
fn projection_is_height_over_a_level_plane_whatever_the_tilt() {
    let level = sheet([-20.0; 2], [20.0; 2], [60; 2], |x, y| {
        (0.4 * x).sin() * (0.3 * y).cos()
    });
    let s = surface(&level);
    let plane = Plane::fitted(&s);
    assert!((plane.normal - Vector::z()).norm() < 0.05);
    let before = values(&s, MorseFunction::Projection, &HOW);
    let tilted = surface(&rotated(&level, Vector::new(1.0, 1.0, 0.0), 30.0));
    for (a, b) in before
        .iter()
        .zip(values(&tilted, MorseFunction::Projection, &HOW))
    {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn each_piece_has_its_own_extremes() {
    let mut mesh = Mesh::default();
    for k in 0..5 {
        let shift = Vector::new(30.0 * k as f64, 0.0, k as f64);
        mesh.triangles
            .extend(ball(3.0, 3).triangles.iter().map(|t| t.map(|p| p + shift)));
    }
    let s = surface(&mesh);
    assert_eq!(s.pieces().1, 5);
    for f in MorseFunction::ALL {
        let v = values(&s, f, &HOW);
        let m = MeshMorse::new(&s, &v);
        assert_eq!(
            counts(&m.critical_points(f64::MAX)),
            [5, 0, 5],
            "{}",
            f.name()
        );
    }
    // Each ball's mean distance is its own: a quarter turn of a radius of 3.
    for m in average_distance(&s, &HOW.average) {
        assert!((m / (3.0 * FRAC_PI_2) - 1.0).abs() < 0.02, "{m}");
    }
}

#[test]
fn hostile_meshes_end_in_numbers() {
    let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
    let one = Mesh {
        triangles: vec![[p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.5)]],
    };
    let sliver = Mesh {
        triangles: vec![
            [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.5, 0.0, 0.0)],
            [p(0.0, 0.0, 0.0), p(1e5, 0.0, 0.0), p(5e4, 1e-9, 0.0)],
            [p(0.0, 0.0, 0.0), p(0.0, 0.0, 0.0), p(1.0, 1.0, 1.0)],
        ],
    };
    // A book of five leaves on one spine, a bow tie, and the same triangle thrice, once the other way round.
    let mut book = Mesh::default();
    for k in 0..5 {
        let (s, c) = (k as f64).sin_cos();
        book.triangles
            .push([p(0.0, 0.0, 0.0), p(0.0, 0.0, 4.0), p(3.0 * c, 3.0 * s, 2.0)]);
    }
    let tie = Mesh {
        triangles: vec![
            [p(0.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, -1.0, 0.0)],
            [p(0.0, 0.0, 0.0), p(-1.0, 1.0, 1.0), p(-1.0, -1.0, 0.0)],
            [p(0.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, -1.0, 0.0)],
            [p(1.0, 1.0, 0.0), p(0.0, 0.0, 0.0), p(1.0, -1.0, 0.0)],
        ],
    };
    // A ball with one spike a kilometre high, and one with its triangles in the file twice.
    let mut spike = ball(2.0, 3);
    let top = spike.triangles[17][0];
    for q in spike.triangles.iter_mut().flatten() {
        if *q == top {
            *q = Point::from(top.coords * 5e5);
        }
    }
    let mut twice = ball(2.0, 2);
    twice.triangles.extend(twice.triangles.clone());
    let flat = sheet([0.0; 2], [9.0; 2], [20; 2], |_, _| 0.0);
    for (name, mesh) in [
        ("one triangle", one),
        ("slivers", sliver),
        ("book", book),
        ("bow tie", tie),
        ("spike", spike),
        ("twice", twice),
        ("flat", flat),
        ("soup", soup(3, 900)),
    ] {
        let s = surface(&mesh);
        for f in MorseFunction::ALL {
            let v = values(&s, f, &HOW);
            assert!(v.iter().all(|x| x.is_finite()), "{name}, {}", f.name());
            let m = MeshMorse::new(&s, &v);
            let points = m.critical_points(0.0);
            let cells = m.cells(&points, 0.0);
            let (_, pieces) = s.pieces();
            let [a, _, c] = counts(&points);
            assert!(a >= pieces && c >= pieces && cells.len() == a + c, "{name}");
        }
    }
    let s = surface(&Mesh::default());
    for f in MorseFunction::ALL {
        let v = values(&s, f, &HOW);
        assert!(MeshMorse::new(&s, &v).critical_points(0.0).is_empty());
    }
}

fn grid_of(mesh: &Mesh, step: f64) -> ToolCentreGrid {
    let cutter = DropCutter::new(mesh, 3.0);
    let how = GridOptions {
        step,
        memory_limit_bytes: 1 << 30,
    };
    ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap()
}

const FIELD: FieldOptions = FieldOptions {
    radius: 1.0,
    average: AverageOptions {
        samples: 64,
        seeds: 4000,
    },
};

#[test]
fn eulers_number_holds_for_every_function_on_the_grid() {
    let hole = |x: f64, y: f64| (x - 20.0).hypot(y - 20.0) > 9.0;
    let whole = sheet([0.0; 2], [40.0; 2], [80; 2], bumps);
    let mut ring = whole.clone();
    ring.triangles.retain(|t| t.iter().all(|p| hole(p.x, p.y)));
    for (name, mesh, chi) in [("sheet", whole, 1), ("ring", ring, 0)] {
        let grid = grid_of(&mesh, 0.3);
        for f in MorseFunction::ALL {
            let field = GridField::of(&grid, f, &FIELD);
            let m = GridMorse::new(&grid, &field);
            assert!(m.euler.holds(), "{name}, {}: {:?}", f.name(), m.euler);
            assert_eq!(m.euler.characteristic, chi, "{name}");
        }
    }
}

#[test]
fn the_grids_functions_are_those_of_the_part() {
    // Curvature of a gentle wave, and mean distance of a square, both on their grids.
    let (a, k) = (1.2, 0.25);
    let mesh = sheet([0.0; 2], [40.0; 2], [120; 2], |x, y| {
        a * (k * x).sin() * (k * y).cos()
    });
    let grid = grid_of(&mesh, 0.14);
    let field = GridField::of(&grid, MorseFunction::MeanCurvature, &FIELD);
    let exact = |x: f64, y: f64| {
        let (sx, cx) = (k * x).sin_cos();
        let (sy, cy) = (k * y).sin_cos();
        let (p, q) = (a * k * cx * cy, -a * k * sx * sy);
        let (r, s, t) = (
            -a * k * k * sx * cy,
            -a * k * k * cx * sy,
            -a * k * k * sx * cy,
        );
        let w = 1.0 + p * p + q * q;
        -((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * w.powf(1.5))
    };
    let top = a * k * k;
    let mut worst = 0.0f64;
    for i in 0..grid.len() {
        let p = grid.point[i];
        let inner = p.x > 2.0 && p.x < 38.0 && p.y > 2.0 && p.y < 38.0;
        if grid.kind[i] == NodeKind::Ground && inner {
            worst = worst.max((field.value[i] - exact(p.x, p.y)).abs());
        }
    }
    assert!(worst < 0.1 * top, "{worst} of {top}");

    let flat = grid_of(&sheet([0.0; 2], [40.0; 2], [2; 2], |_, _| 1.0), 0.4);
    let field = GridField::of(&flat, MorseFunction::Geodesic, &FIELD);
    // The middle of a square of side 1: (sqrt 2 + asinh 1) / 6; a corner: (sqrt 2 + asinh 1) / 3.
    let unit = (2f64.sqrt() + 1f64.asinh()) / 6.0;
    let at = |x: f64, y: f64| field.value[flat.nearest(x, y).unwrap()];
    assert!(
        (at(20.0, 20.0) / (40.0 * unit) - 1.0).abs() < 0.01,
        "{}",
        at(20.0, 20.0)
    );
    assert!(
        (at(0.2, 0.2) / (80.0 * unit) - 1.0).abs() < 0.02,
        "{}",
        at(0.2, 0.2)
    );
    let points = GridMorse::new(&flat, &field).critical_points(field.noise());
    assert_eq!(counts(&points)[2], 1, "one middle: {points:?}");
    assert_eq!(counts(&points)[0], 4, "four corners: {points:?}");
    let middle = points
        .iter()
        .find(|c| c.kind == CriticalKind::Minimum)
        .unwrap();
    assert!((middle.contact.xy() - nalgebra::Point2::new(20.0, 20.0)).norm() < 1.0);
}

#[test]
fn noise_by_chance_keeps_the_laws() {
    let mut chance = Chance(7);
    for _ in 0..6 {
        let n = 30 + (chance.next() % 20) as usize;
        let mut mesh = ball(5.0, 3);
        let s0 = surface(&mesh);
        let jitter: Vec<f64> = (0..s0.len()).map(|_| chance.between(-0.3, 0.3)).collect();
        let moved: Vec<Point> = s0
            .points
            .iter()
            .zip(&jitter)
            .map(|(p, j)| p + p.coords.normalize() * *j)
            .collect();
        mesh.triangles = s0
            .triangles
            .iter()
            .map(|t| t.map(|v| moved[v as usize]))
            .collect();
        let s = surface(&mesh);
        for f in MorseFunction::ALL {
            let v = values(&s, f, &HOW);
            let m = MeshMorse::new(&s, &v);
            for limit in [0.0, 0.01, 0.1, PI] {
                let [a, b, c] = counts(&m.critical_points(limit)).map(|k| k as i64);
                assert_eq!(a - b + c, 2, "{}, {limit}, {n}", f.name());
            }
        }
    }
}
