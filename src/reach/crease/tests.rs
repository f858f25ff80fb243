#![allow(clippy::unwrap_used)]
use super::*;
use crate::part::Mesh;
use crate::reach::{GridOptions, GridPlan};

fn surveyed(triangles: Vec<[Point; 3]>, radius: f64) -> (ToolCentreGrid, DropCutter) {
    let cutter = DropCutter::new(&Mesh { triangles }, radius);
    let how = GridOptions {
        step: 0.13,
        memory_limit_bytes: 1 << 30,
    };
    let plan = GridPlan::new(&cutter, &how).unwrap();
    (ToolCentreGrid::new(&cutter, &plan).unwrap(), cutter)
}

fn quad(p: [[f64; 3]; 4]) -> [[Point; 3]; 2] {
    let [a, b, c, d] = p.map(|v| Point::new(v[0], v[1], v[2]));
    [[a, b, c], [a, c, d]]
}

const OPTIONS: CreaseOptions = CreaseOptions {
    angle: 0.14,
    shortest: 0.3,
};

/// A groove at an angle to the grid: one chain, straight above its bottom, R / cos(45 degrees) high, both flanks' normals.
#[test]
fn a_groove_is_one_chain_in_its_place() {
    let (r, turn) = (2.0f64, 0.4f64);
    let at = |u: f64, v: f64, z: f64| {
        [
            u * turn.cos() - v * turn.sin(),
            u * turn.sin() + v * turn.cos(),
            z,
        ]
    };
    let (grid, cutter) = surveyed(
        [
            quad([
                at(0.0, -5.0, 5.0),
                at(15.0, -5.0, 5.0),
                at(15.0, 0.0, 0.0),
                at(0.0, 0.0, 0.0),
            ]),
            quad([
                at(0.0, 0.0, 0.0),
                at(15.0, 0.0, 0.0),
                at(15.0, 5.0, 5.0),
                at(0.0, 5.0, 5.0),
            ]),
        ]
        .concat(),
        r,
    );
    let found = creases(&grid, &cutter, &OPTIONS);
    assert_eq!(found.len(), 1, "{found:?}");
    let inner: Vec<&CreasePoint> = found[0]
        .points
        .iter()
        .filter(|p| {
            let u = p.center.x * turn.cos() + p.center.y * turn.sin();
            u > 0.1 && u < 14.9
        })
        .collect();
    assert!(inner.len() > 90);
    for p in inner {
        let v = p.center.y * turn.cos() - p.center.x * turn.sin();
        assert!(v.abs() < 1e-4, "{p:?}");
        assert!((p.center.z - r * 2f64.sqrt()).abs() < 1e-4);
        assert!(p.normals[0].dot(&p.normals[1]).abs() < 1e-3 && p.rise == 0.0);
    }
    // No stutter: it only goes forward.
    let d = found[0].points.last().unwrap().center - found[0].points[0].center;
    assert!(
        found[0]
            .points
            .windows(2)
            .all(|w| (w[1].center - w[0].center).dot(&d) > 0.0)
    );
}

/// The floor of a square pocket with upright walls: a leap one radius off each wall, corners found to a micrometre.
#[test]
fn the_foot_of_walls_and_its_corners() {
    let (r, h, s) = (2.0f64, 5.0f64, 6.0f64);
    let mut t = quad([[-s, -s, 0.0], [s, -s, 0.0], [s, s, 0.0], [-s, s, 0.0]]).to_vec();
    for k in 0..4 {
        let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_2).sin_cos();
        let at =
            |x: f64, y: f64, z: f64| [(x * cos - y * sin).round(), (x * sin + y * cos).round(), z];
        t.extend(quad([
            at(s, -s, 0.0),
            at(s, s, 0.0),
            at(s, s, h),
            at(s, -s, h),
        ]));
        t.extend(quad([
            at(s, -s, h),
            at(9.0, -9.0, h),
            at(9.0, 9.0, h),
            at(s, s, h),
        ]));
    }
    let (grid, cutter) = surveyed(t, r);
    let found = creases(&grid, &cutter, &OPTIONS);
    let inside = s - r;
    let leaps: Vec<&CreasePoint> = found
        .iter()
        .flat_map(|c| &c.points)
        .filter(|p| p.rise > 0.0)
        .collect();
    assert!(leaps.len() > 100);
    for p in &leaps {
        let off = p.center.x.abs().max(p.center.y.abs());
        assert!((off - inside).abs() < 1e-3, "{p:?}");
        assert!(
            (p.center.z - r).abs() < 1e-6 && (p.rise - (h - r)).abs() < 0.05,
            "{p:?}"
        );
    }
    for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let miss = leaps
            .iter()
            .map(|p| (p.center.xy() - Point2::new(x * inside, y * inside)).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(miss < 3e-3, "corner {x} {y} missed by {miss}");
    }
}

#[test]
fn plains_and_ridges_have_none() {
    let flat = quad([
        [0.0, 0.0, 0.0],
        [9.0, 0.0, 0.0],
        [9.0, 9.0, 0.0],
        [0.0, 9.0, 0.0],
    ]);
    let (grid, cutter) = surveyed(flat.to_vec(), 2.0);
    assert_eq!(creases(&grid, &cutter, &OPTIONS), Vec::new());
    let ridge = [
        quad([
            [0.0, -5.0, -5.0],
            [9.0, -5.0, -5.0],
            [9.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
        ]),
        quad([
            [0.0, 0.0, 0.0],
            [9.0, 0.0, 0.0],
            [9.0, 5.0, -5.0],
            [0.0, 5.0, -5.0],
        ]),
    ]
    .concat();
    let (grid, cutter) = surveyed(ridge, 2.0);
    assert_eq!(creases(&grid, &cutter, &OPTIONS), Vec::new());
}
