#![allow(clippy::unwrap_used)]
use super::*;
use crate::geom::Vector2;
use crate::part::Mesh;
use crate::reach::{GridOptions, GridPlan};

/// A closed box of this size, its top at zero.
fn block(x: f64, y: f64, z: f64) -> Mesh {
    let p = |i: usize| Point::new([0.0, x][i & 1], [0.0, y][(i >> 1) & 1], [-z, 0.0][i >> 2]);
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [1, 3, 7, 5],
        [3, 2, 6, 7],
        [2, 0, 4, 6],
    ];
    Mesh {
        triangles: faces
            .iter()
            .flat_map(|f| [[p(f[0]), p(f[1]), p(f[2])], [p(f[0]), p(f[2]), p(f[3])]])
            .collect(),
    }
}

fn cut(mesh: &Mesh, flute: f64, deepest: f64) -> Walls {
    let cutter = DropCutter::new(mesh, 2.0);
    let how = GridOptions {
        step: 0.13,
        memory_limit_bytes: 1 << 30,
    };
    let grid = ToolCentreGrid::new(&cutter, &GridPlan::new(&cutter, &how).unwrap()).unwrap();
    let uprights = Uprights::new(mesh, 2.0);
    let options = WallOptions {
        angle: 75f64.to_radians(),
        stepover: 0.6,
        floor: cutter.bounds().min.z,
        flute,
        deepest,
        off_wall: 0.0024,
    };
    let steep = steep(&grid, &uprights, &options);
    let fitting = FitOptions::for_scallop(0.02, 2.0);
    walls(&grid, &cutter, &uprights, &steep, &[], &fitting)
}

fn largest_turn(points: &[Point]) -> f64 {
    points
        .windows(3)
        .map(|w| (w[1] - w[0]).angle(&(w[2] - w[1])).to_degrees())
        .fold(0.0, f64::max)
}

/// One pass goes round and down: from the top edge to the floor, a stepover at a time, one radius off.
#[test]
fn a_block_is_gone_round_down_to_the_floor() {
    let Walls {
        passes, too_deep, ..
    } = cut(&block(12.0, 9.0, 7.0), 18.0, 0.6);
    assert_eq!((passes.len(), too_deep.len()), (1, 0));
    let mut heights: Vec<f64> = Vec::new();
    for p in &passes[0].points {
        let beside = Vector2::new(
            (-p.x).max(p.x - 12.0).max(0.0),
            (-p.y).max(p.y - 9.0).max(0.0),
        );
        assert!((beside.norm() - 2.0024).abs() < 0.0025, "{p}");
        heights.push(p.z);
    }
    heights.sort_by(f64::total_cmp);
    assert!(
        (heights[0] + 5.0).abs() < 1e-9,
        "the tip stands on the floor"
    );
    assert!(
        heights[heights.len() - 1] > -0.03,
        "and it begins at the top edge"
    );
    assert!(heights.windows(2).all(|w| w[1] - w[0] < 0.6 + 1e-9));
    let round = 2.0 * (12.0 + 9.0) + 2.0 * std::f64::consts::PI * 2.0;
    // Along the top, down a helix, and once more along the floor.
    let levels = (5.0f64 / 0.6).floor() + 1.0 + 2.0;
    assert!((passes[0].length() / (round * levels) - 1.0).abs() < 0.02);
}

/// Flutes of 4 mm cut 4 mm deep; what stays is named, with what it would take.
#[test]
fn short_flutes_stop_and_say_so() {
    let Walls {
        passes,
        too_deep,
        uncut,
    } = cut(&block(12.0, 9.0, 7.0), 4.0, 0.6);
    let lowest = passes
        .iter()
        .flat_map(|p| &p.points)
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    assert!((-2.0 - 1e-9..-1.3).contains(&lowest), "{lowest}");
    let most = too_deep.iter().map(|t| t.needs).fold(0.0, f64::max);
    assert!((most - 7.0).abs() < 0.02, "{too_deep:?}");
    // All round, from the lowest pass down to where one along the floor would be.
    assert!(
        (uncut / (42.0 * (lowest + 5.0)) - 1.0).abs() < 0.03,
        "{uncut}"
    );
}

#[test]
fn an_open_sheet_has_no_walls() {
    let p = Point::new;
    let sheet = Mesh {
        triangles: vec![
            [p(0.0, 0.0, 0.0), p(9.0, 0.0, 2.0), p(9.0, 9.0, 2.0)],
            [p(0.0, 0.0, 0.0), p(9.0, 9.0, 2.0), p(0.0, 9.0, 0.0)],
        ],
    };
    assert_eq!(cut(&sheet, 18.0, 0.6), Walls::default());
}

/// Flutes that do not reach the floor cut as deep as they are long, in one round with no corner in it.
#[test]
fn one_round_as_deep_as_the_flutes() {
    let found = cut(&block(12.0, 9.0, 40.0), 18.0, f64::INFINITY);
    assert_eq!(found.passes.len(), 1);
    let points = &found.passes[0].points;
    assert!(
        points.iter().all(|p| (p.z + 16.0).abs() < 1e-3),
        "{points:?}"
    );
    assert!(largest_turn(points) < 10.0);
    assert!(
        (found.uncut / (42.0 * 22.0) - 1.0).abs() < 0.03,
        "{}",
        found.uncut
    );
}

/// Down a frustum of 80 degrees the way is one pass without a corner.
#[test]
fn ramps_lead_down_a_sloping_wall() {
    let ring = |r: f64, z: f64| -> Vec<Point> {
        (0..96)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::TAU / 96.0).sin_cos();
                Point::new(r * c, r * s, z)
            })
            .collect()
    };
    let rise = 5.0;
    let (top, foot) = (
        ring(5.0, rise),
        ring(5.0 + rise / 80f64.to_radians().tan(), 0.0),
    );
    let far = ring(14.0, 0.0);
    let mut triangles = Vec::new();
    for k in 0..96 {
        let l = (k + 1) % 96;
        triangles.push([Point::new(0.0, 0.0, rise), top[k], top[l]]);
        for (a, b) in [(&top, &foot), (&foot, &far)] {
            triangles.push([a[k], b[k], b[l]]);
            triangles.push([a[k], b[l], a[l]]);
        }
    }
    let found = cut(&Mesh { triangles }, 18.0, f64::INFINITY);
    assert_eq!(found.passes.len(), 1, "{:?}", found.passes);
    assert!(largest_turn(&found.passes[0].points) < 30.0);
    assert_eq!(found.uncut, 0.0);
}
