//! The law of the field: one unit of it is one cusp of the height asked for.
//!
//! On surfaces of known curvature (planes, spheres, cylinders, the inside of a ring: a saddle) the ball's centre surface is known in
//! closed form. A field is marched from a point over a fine mesh of the surface; two passes are laid one unit apart, and what the
//! two swept tubes leave between them is measured along the normal of the *analytic* surface, with no help from the code judged.
#![allow(clippy::unwrap_used)]

use super::common::{PARTS, sheet};
use super::morse::options;
use morsemill::field::march::Access;
use morsemill::field::{Front, MarchOptions, Metric, Ruler, level_curves, march};
use morsemill::geom::{Point, Point2, Vector, Vector2};
use morsemill::reach::{DropCutter, GridOptions, GridPlan, NodeKind, ToolCentreGrid};
use morsemill::toolpath::PLAN_SHARES;
use morsemill::toolpath::plan::{Strategy, features, survey};
use rayon::prelude::*;

const R: f64 = 3.0;
const H: f64 = 0.02;
/// Half the side of the patches, mm.
const HALF: f64 = 7.0;

/// A surface over the plan whose offset is known.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// Normal of a plane through the origin.
    Plane(Vector),
    /// Sphere with its top (radius > 0) or its bottom (radius < 0) at the origin.
    Sphere(f64),
    /// Cylinder with its axis level, turned by an angle from X: convex (radius > 0) or a trough.
    Cylinder(f64, f64),
    /// Inside of a ring standing upright: radius of the ring, radius of its tube, and its turn about Z.
    Ring(f64, f64, f64),
}

impl Shape {
    fn axes(angle: f64, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = angle.sin_cos();
        (c * x + s * y, c * y - s * x)
    }

    /// Height of the surface `out` mm outside of it (0: the part, R: the ball's centres).
    fn height(&self, out: f64, x: f64, y: f64) -> f64 {
        match *self {
            Shape::Plane(n) => (out - n.x * x - n.y * y) / n.z,
            Shape::Sphere(r) => {
                let s = r.signum();
                s * (((r + out).powi(2) - x * x - y * y).sqrt()) - r
            }
            Shape::Cylinder(r, angle) => {
                let (_, v) = Shape::axes(angle, x, y);
                r.signum() * ((r + out).powi(2) - v * v).sqrt() - r
            }
            Shape::Ring(ring, tube, angle) => {
                let (u, v) = Shape::axes(angle, x, y);
                let inner = ring - ((tube + out).powi(2) - v * v).sqrt();
                (ring - tube) - (inner * inner - u * u).sqrt()
            }
        }
    }

    /// Unit normal at the foot of a ball's centre, by differences of the centre surface (whose normal is the same).
    fn normal(&self, x: f64, y: f64) -> Vector {
        let e = 1e-5;
        let z = |x, y| self.height(R, x, y);
        Vector::new(
            -(z(x + e, y) - z(x - e, y)) / (2.0 * e),
            -(z(x, y + e) - z(x, y - e)) / (2.0 * e),
            1.0,
        )
        .normalize()
    }

    fn center(&self, q: &Point2) -> Point {
        Point::new(q.x, q.y, self.height(R, q.x, q.y))
    }
}

fn grid_of(shape: &Shape, facet: f64) -> ToolCentreGrid {
    // The part reaches beyond the patch by a ball, so that the patch is all ground.
    let half = HALF
        + if matches!(shape, Shape::Sphere(_) | Shape::Cylinder(..)) {
            1.0
        } else {
            0.8
        };
    let n = (2.0 * half / facet) as usize;
    // Facets askew to the grid of centres, so that nothing is in step.
    let mesh = sheet(
        [-half, -half * 1.01],
        [half * 1.013, half],
        [n, n + 7],
        |x, y| shape.height(0.0, x, y),
    );
    let cutter = DropCutter::new(&mesh, R);
    let how = GridOptions {
        step: (8.0 * H * R).sqrt() / 5.0,
        memory_limit_bytes: 1 << 30,
    };
    ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap()
}

/// What is left above the analytic surface at the foot of the centre over `q`, along the normal, by tubes of radius R about some runs.
fn left_over(shape: &Shape, q: &Point2, runs: &[Vec<Point>]) -> f64 {
    let n = shape.normal(q.x, q.y);
    let foot = shape.center(q) - n * R;
    let distance = |p: &Point| {
        runs.iter()
            .flat_map(|r| r.windows(2))
            .map(|w| {
                let e = w[1] - w[0];
                let s = ((p - w[0]).dot(&e) / e.norm_squared()).clamp(0.0, 1.0);
                (p - (w[0] + e * s)).norm()
            })
            .fold(f64::INFINITY, f64::min)
    };
    // The tubes touch the surface from above: bisect for the lowest place inside one of them.
    let (mut lo, mut hi) = (0.0, 4.0 * H);
    if distance(&(foot + n * hi)) > R {
        return f64::INFINITY;
    }
    for _ in 0..30 {
        let t = 0.5 * (lo + hi);
        if distance(&(foot + n * t)) <= R {
            hi = t
        } else {
            lo = t
        }
    }
    hi
}

/// Cusps between neighbouring passes of a field about `seed`, relative to H, sorted; a few hundred of them.
fn cusps(shape: &Shape, ruler: Ruler, seed: Point2, facet: f64) -> Vec<f64> {
    let grid = grid_of(shape, facet);
    let metric = Metric::new(&grid, ruler, H);
    let from = grid.nearest(seed.x, seed.y).unwrap();
    assert_eq!(grid.kind[from], NodeKind::Ground);
    let mut value = vec![f64::INFINITY; grid.len()];
    let how = MarchOptions {
        front: Front::Round,
        near_steps: 3,
    };
    let open = |_: usize| Access::Open;
    march(
        &grid,
        &metric,
        &[(from, 0.0)],
        &open,
        &how,
        &mut value,
        &mut |_, _| true,
    );
    let levels: Vec<f64> = (0..16).map(|k| k as f64 + 0.5).collect();
    let curves = level_curves(&grid, &|n| value[n], &levels);
    // The field where the plan is well inside the ground (the border's own metric is a one-sided guess).
    let inside = |q: &Point2, margin: f64| {
        grid.nearest(q.x, q.y).is_some_and(|n| {
            let m = (margin / grid.step).ceil() as i32;
            [(m, 0), (-m, 0), (0, m), (0, -m)].iter().all(|d| {
                grid.neighbour(n, *d)
                    .is_some_and(|j| grid.kind[j] == NodeKind::Ground)
            })
        })
    };
    let field = |q: &Point2| -> Option<f64> {
        let (fx, fy) = (
            (q.x - grid.origin.x) / grid.step,
            (q.y - grid.origin.y) / grid.step,
        );
        let (i, j) = (fx.floor() as usize, fy.floor() as usize);
        let (u, v) = (fx - fx.floor(), fy - fy.floor());
        let at = |i: usize, j: usize| value[j * grid.nx + i];
        let z = at(i, j) * (1.0 - u) * (1.0 - v)
            + at(i + 1, j) * u * (1.0 - v)
            + at(i, j + 1) * (1.0 - u) * v
            + at(i + 1, j + 1) * u * v;
        z.is_finite().then_some(z)
    };
    let runs: Vec<(usize, Vec<Point>)> = curves
        .iter()
        .map(|c| {
            let mut run: Vec<Point> = c.at.iter().map(|e| shape.center(&e.xy(&grid))).collect();
            if c.closed {
                run.push(run[0]);
            }
            (c.level, run)
        })
        .collect();
    let starts: Vec<(usize, Point2)> = curves
        .iter()
        // The first pass is a loop about the seed, where the unit is no distance between two passes yet.
        .filter(|c| c.level >= 1 && c.level + 1 < levels.len())
        .flat_map(|c| c.at.iter().step_by(41).map(|e| (c.level, e.xy(&grid))))
        .collect();
    let mut out: Vec<f64> = starts
        .par_iter()
        .filter_map(|&(level, start)| {
            // Only the two passes, and only near.
            let near: Vec<Vec<Point>> = runs
                .iter()
                .filter(|r| r.0 == level || r.0 == level + 1)
                .flat_map(|r| {
                    r.1.split(|p| (p.xy() - start).norm() > 3.0)
                        .filter(|s| s.len() > 1)
                        .map(<[Point]>::to_vec)
                        .collect::<Vec<_>>()
                })
                .collect();
            let mut q = start;
            let mut top: f64 = 0.0;
            for _ in 0..400 {
                if !inside(&q, 1.5) {
                    return None;
                }
                let e = grid.step;
                let g = Vector2::new(
                    field(&Point2::new(q.x + e, q.y))? - field(&Point2::new(q.x - e, q.y))?,
                    field(&Point2::new(q.x, q.y + e))? - field(&Point2::new(q.x, q.y - e))?,
                ) / (2.0 * e);
                if field(&q)? >= levels[level + 1] {
                    return Some(top / H);
                }
                top = top.max(left_over(shape, &q, &near));
                q += g.normalize() * 0.012;
            }
            None
        })
        .collect();
    out.sort_by(f64::total_cmp);
    assert!(
        out.len() > 40,
        "{shape:?}: only {} cusps measured",
        out.len()
    );
    out
}

fn plane(degrees: f64, towards: f64) -> Shape {
    let (s, c) = degrees.to_radians().sin_cos();
    let (u, v) = towards.to_radians().sin_cos();
    Shape::Plane(Vector::new(s * v, s * u, c))
}

/// Facets of a twelfth of a millimetre: a few micrometres of chord are then below a tenth of one.
const FACET: f64 = 0.08;

fn one_unit_is_one_cusp(shapes: &[Shape]) {
    let mut wrong = Vec::new();
    for (k, shape) in shapes.iter().enumerate() {
        // From the middle, where the surface is symmetric, and from elsewhere, in turn.
        {
            let seed = [Point2::new(0.0, 0.0), Point2::new(-1.3, 0.9)][k % 2];
            let c = cusps(shape, Ruler::IsoScallop, seed, FACET);
            let (lo, hi) = (c[0], c[c.len() - 1]);
            eprintln!(
                "{shape:?} from {seed}: {} cusps, {lo:.3} to {hi:.3} of h, median {:.3}",
                c.len(),
                c[c.len() / 2]
            );
            // Where the ground is steeper than 60 degrees the metric is so uneven that the march errs to the safe side: passes up to 5 %
            // too near each other, 10 % in the cusp. Never the other way.
            let least = match shape {
                Shape::Plane(n) if n.z < 0.5 => 0.9,
                _ => 0.95,
            };
            if lo < least || hi > 1.05 {
                wrong.push(format!("{shape:?} from {seed}: {lo:.3} to {hi:.3} of h"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn one_unit_is_one_cusp_on_planes() {
    one_unit_is_one_cusp(&[
        plane(0.0, 0.0),
        plane(10.0, 0.0),
        plane(30.0, 65.0),
        plane(50.0, 200.0),
        plane(70.0, 110.0),
        plane(70.0, 45.0),
    ]);
}

#[test]
fn one_unit_is_one_cusp_on_spheres_and_cylinders() {
    one_unit_is_one_cusp(&[
        Shape::Sphere(15.0),
        Shape::Sphere(40.0),
        Shape::Sphere(-20.0),
        Shape::Sphere(-14.0),
        Shape::Cylinder(12.0, 0.0),
        Shape::Cylinder(15.0, 0.6),
        Shape::Cylinder(-14.0, 1.1),
    ]);
}

#[test]
fn one_unit_is_one_cusp_on_saddles() {
    one_unit_is_one_cusp(&[
        Shape::Ring(30.0, 12.0, 0.0),
        Shape::Ring(28.0, 11.0, 0.5),
        Shape::Ring(40.0, 14.0, 2.0),
    ]);
}

/// Equal steps on the part are equal cusps on planes only: elsewhere the law must fail, or it tests nothing.
#[test]
fn pick_feed_is_equal_cusps_on_planes_alone() {
    let flat = cusps(
        &plane(40.0, 30.0),
        Ruler::IsoPickFeed,
        Point2::new(0.0, 0.0),
        FACET,
    );
    assert!(flat[0] > 0.95 && flat[flat.len() - 1] < 1.05);
    // On a sphere of radius r a step w leaves a cusp of w^2 / 8 (1/R + 1/r): by 1 + R / r more.
    for r in [15.0, -20.0] {
        let round = cusps(
            &Shape::Sphere(r),
            Ruler::IsoPickFeed,
            Point2::new(0.0, 0.0),
            FACET,
        );
        let want = 1.0 + R / r;
        let median = round[round.len() / 2];
        assert!(
            (median - want).abs() < 0.03 * want,
            "{median}, must be {want}"
        );
    }
}

/// Before any filling, whatever the ruler: the cusp a feature's field promises, h / |grad|^2 in the cusp metric, is above the wanted one
/// on a small share of its ground only.
#[test]
fn the_promised_cusp_is_rarely_above_the_wanted_one() {
    let mut wrong = Vec::new();
    for part in [PARTS[0], PARTS[1], PARTS[2]] {
        let cutter = DropCutter::new(&part.mesh(), R);
        let mut how = options(0.05);
        let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
        let g = &ground.grid;
        let cusp = Metric::new(g, Ruler::IsoScallop, 0.05);
        for strategy in [
            Strategy::IsoScallop,
            Strategy::IsoPickFeed,
            Strategy::Isoplanar(0.0),
            Strategy::Isoplanar(30.0),
        ] {
            how.strategy = strategy;
            let regions = features(&ground, how.strategy, PLAN_SHARES[0] * how.scallop);
            let (mut all, mut over, mut most) = (0u32, 0u32, 0.0f64);
            for i in 0..g.len() {
                let Some(k) = usize::from(regions.label[i]).checked_sub(1) else {
                    continue;
                };
                let f = &regions.features[k].field;
                // Across the seed the field has a kink, and no gradient.
                if f.at(g, i) < 0.3 {
                    continue;
                }
                let v = |d| {
                    let j = g.neighbour(i, d)?;
                    let same = regions.label[j] == regions.label[i];
                    Some(f.at(g, j)).filter(|v| same && v.is_finite())
                };
                let (Some(e), Some(w), Some(n), Some(s)) =
                    (v((1, 0)), v((-1, 0)), v((0, 1)), v((0, -1)))
                else {
                    continue;
                };
                let (gx, gy) = ((e - w) / (2.0 * g.step), (n - s) / (2.0 * g.step));
                let m = &cusp.tensor[i];
                let det = m[0] * m[2] - m[1] * m[1];
                let dual = (m[2] * gx * gx - 2.0 * m[1] * gx * gy + m[0] * gy * gy) / det;
                all += 1;
                // The plan aims lower than h on purpose; this is against h itself.
                let c = 1.0 / dual;
                if c > 1.0 {
                    over += 1;
                }
                // At the seed and on the cut locus the gradient is none: the passes meet there, and the fill looks after it.
                if dual > 0.2 {
                    most = most.max(c);
                }
            }
            let share = 100.0 * f64::from(over) / f64::from(all);
            eprintln!(
                "{} {strategy:?}: {share:.3} % of {all} nodes above h, most {most:.2} h",
                part.file
            );
            if share > STATED {
                wrong.push(format!("{} {strategy:?}: {share:.3} %", part.file));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Share of the ground, %, that may be promised a higher cusp before filling.
const STATED: f64 = 0.5;
