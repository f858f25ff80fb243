//! Laws of the finish.

#![allow(clippy::unwrap_used)]
use super::*;
use crate::geom::Point;
use crate::part::Mesh;
use crate::reach::DropCutter;
use crate::sweep::Lattice;
use crate::sweep::reachable;

fn plane(size: f64, slope: f64) -> Mesh {
    let p = |x: f64, y: f64| Point::new(x, y, slope * y);
    Mesh {
        triangles: vec![
            [p(0.0, 0.0), p(size, 0.0), p(size, size)],
            [p(0.0, 0.0), p(size, size), p(0.0, size)],
        ],
    }
}

/// Passes along X at spacing w on the slope, `lift` above the exact height.
fn passes(slope: f64, r: f64, w: f64, size: f64, lift: f64) -> Vec<Segment> {
    let c = 1.0 / (1.0f64 + slope * slope).sqrt();
    let count = (size / c / w).round() as i32;
    let w = size / c / f64::from(count);
    (0..=count)
        .map(|k| {
            // Contact at (y, slope y); the centre one radius along the normal.
            let y = (f64::from(k) * w * c).min(size);
            let (cy, cz) = (y - r * slope * c, slope * y + r * c + lift);
            Segment {
                from: Point::new(-1.0, cy, cz),
                to: Point::new(size + 1.0, cy, cz),
            }
        })
        .collect()
}

fn judge(mesh: &Mesh, segments: &[Segment], r: f64, step: f64, h: f64) -> Finish {
    let reach = reachable(&DropCutter::new(mesh, r), step);
    let mut swept = Swept::new(reach.lattice);
    swept.cut(segments, r);
    finish(&reach, &swept, segments, &FinishOptions::for_scallop(h)).unwrap()
}

/// Passes at w leave R - sqrt(R^2 - w^2/4), on the flat and on a slope alike; all is cut and nothing gouged.
#[test]
fn cusp_of_parallel_passes_on_flat_and_slope() {
    let (r, w) = (3.0, 0.6);
    for slope in [0.0f64, 0.5, 1.0, 2.0] {
        // The width across the slope, divided evenly.
        let across = 12.0 * (1.0 + slope * slope).sqrt();
        let w = across / (across / w).round();
        let cusp = 1e3 * (r - f64::sqrt(r * r - w * w / 4.0));
        let f = judge(
            &plane(12.0, slope),
            &passes(slope, r, w, 12.0, 0.0),
            r,
            // No share of the stepover, so that cells lie at all distances from a pass.
            0.0317,
            0.02,
        );
        let s = f.stats;
        // The nearest centre to the crest misses it by half a step at most.
        let miss = 1e3 * 0.016 * (w / 2.0 / r);
        assert!(s.scallop_um.max <= cusp + 0.15, "{slope}: {s:?}");
        assert!(s.scallop_um.max >= cusp - miss - 0.2, "{slope}: {s:?}");
        // Height goes as the square of the distance from the pass: median at a quarter of the cusp.
        assert!(
            (s.scallop_um.p50 - cusp / 4.0).abs() < 0.3,
            "{slope}: {s:?}"
        );
        assert_eq!(s.uncut_area_mm2, 0.0, "{slope}: {s:?}");
        assert!(s.gouge_um_max < 0.1 && s.over_scallop_area_percent == 0.0);
        assert!(s.rest_area_mm2 < 1e-9);
        let area = 144.0 * (1.0f64 + slope * slope).sqrt();
        assert!(
            (s.judged_area_mm2 / area - 1.0).abs() < 0.01,
            "{slope}: {s:?}"
        );
    }
}

/// Lowering all passes by 50 um gouges by 50 um on the flat and 50 um times the cosine on a slope.
#[test]
fn known_gouge() {
    for slope in [0.0, 1.0] {
        let f = judge(
            &plane(10.0, slope),
            &passes(slope, 3.0, 0.5, 10.0, -0.05),
            3.0,
            0.1,
            0.02,
        );
        let want = 50.0 / (1.0f64 + slope * slope).sqrt();
        assert!(
            (f.stats.gouge_um_max - want).abs() < 1.0,
            "{slope}: {:?}",
            f.stats
        );
    }
}

/// One pass left out in the middle: ground higher than the limit is uncut and no cusp; nothing cut at all is all uncut.
#[test]
fn uncut_is_not_a_cusp() {
    let mesh = plane(12.0, 0.0);
    let reach = reachable(&DropCutter::new(&mesh, 3.0), 0.1);
    let none = Swept::new(reach.lattice);
    let options = FinishOptions::for_scallop(0.02);
    let s = finish(&reach, &none, &[], &options).unwrap().stats;
    assert!((s.uncut_area_mm2 - s.judged_area_mm2).abs() < 1e-6);
    assert_eq!(s.over_scallop_area_percent, 100.0);
    assert_eq!(s.scallop_um.max, 0.0);
    // Passes at y = 0..4 and 8..12: between them a hill whose top is 3 - sqrt(9 - 4) = 0.76 mm.
    let all = passes(0.0, 3.0, 0.5, 12.0, 0.0);
    let some: Vec<Segment> = all
        .into_iter()
        .filter(|s| s.from.y <= 4.0 || s.from.y >= 8.0)
        .collect();
    let s = judge(&mesh, &some, 3.0, 0.1, 0.02).stats;
    // Above 0.2 mm: distance from the pass over sqrt(9 - 2.8^2) = 1.077 mm in plan by the vertical measure.
    let want = 12.0 * (4.0 - 2.0 * (3.2f64 * 3.2 - 9.0).sqrt());
    assert!((s.uncut_area_mm2 - want).abs() < 4.0, "{s:?} {want}");
    assert!(s.scallop_um.max <= 200.0 + 1e-3);
}

/// A slot narrower than the ball is rest, not uncut.
#[test]
fn slot_is_rest() {
    // 2 mm wide, 3 mm deep, upright walls, along X in the middle of a 12 mm plate.
    let z = |a: [f64; 2], b: [f64; 2], h: f64| {
        let p = |x: f64, y: f64| Point::new(x, y, h);
        vec![
            [p(a[0], a[1]), p(b[0], a[1]), p(b[0], b[1])],
            [p(a[0], a[1]), p(b[0], b[1]), p(a[0], b[1])],
        ]
    };
    let mut mesh = Mesh::default();
    // The plates go on beyond the slot, so that no ball enters it by its ends.
    mesh.triangles.extend(z([-4.0, 0.0], [16.0, 5.0], 0.0));
    mesh.triangles.extend(z([0.0, 5.0], [12.0, 7.0], -3.0));
    mesh.triangles.extend(z([-4.0, 7.0], [16.0, 12.0], 0.0));
    let drop = DropCutter::new(&mesh, 3.0);
    let reach = reachable(&drop, 0.05);
    // Follow the resting ball over every other node.
    let l = reach.lattice;
    let balls = drop.drop_all(&l);
    let mut segments = Vec::new();
    for iy in 0..l.ny {
        for ix in (2..l.nx).filter(|&ix| l.x(ix - 2) > -4.5 && l.x(ix) < 16.5) {
            let at = |ix: usize| {
                let c = l.center(ix, iy);
                Point::new(c.x, c.y, balls.z[l.index(ix, iy)])
            };
            segments.push(Segment {
                from: at(ix - 2),
                to: at(ix),
            });
        }
    }
    let mut swept = Swept::new(l);
    swept.cut(&segments, 3.0);
    let s = finish(&reach, &swept, &segments, &FinishOptions::for_scallop(0.02))
        .unwrap()
        .stats;
    assert!((s.rest_area_mm2 - 24.0).abs() < 1.5, "{s:?}");
    assert_eq!(s.uncut_area_mm2, 0.0, "{s:?}");
    assert!(s.gouge_um_max < 1.0, "{s:?}");
}

/// A ball that runs 5 um beside an upright wall leaves 5 um there, not the wall's height.
#[test]
fn beside_a_wall_the_normal_counts() {
    let (r, off) = (3.0, 0.005);
    let q = |x: f64, y: f64, z: f64| Point::new(x, y, z);
    let mut mesh = Mesh::default();
    let mut quad = |a, b, c, d| {
        mesh.triangles.push([a, b, c]);
        mesh.triangles.push([a, c, d]);
    };
    // Floor for y < 6.0005, plateau 8 mm above from there on.
    let w = 6.0005;
    quad(
        q(0.0, 0.0, 0.0),
        q(12.0, 0.0, 0.0),
        q(12.0, w, 0.0),
        q(0.0, w, 0.0),
    );
    // The wall goes on beyond the floor, so that no ball comes to its foot round the end.
    quad(
        q(-8.0, w, 0.0),
        q(20.0, w, 0.0),
        q(20.0, w, 8.0),
        q(-8.0, w, 8.0),
    );
    quad(
        q(-8.0, w, 8.0),
        q(20.0, w, 8.0),
        q(20.0, 12.0, 8.0),
        q(-8.0, 12.0, 8.0),
    );
    let mut segments = Vec::new();
    let mut y = -1.0;
    while y < w - r - off {
        segments.push((y, r));
        y += 0.4;
    }
    segments.push((w - r - off, r));
    let mut y = w;
    while y < 12.5 {
        segments.push((y, 8.0 + r));
        y += 0.4;
    }
    let segments: Vec<Segment> = segments
        .into_iter()
        .map(|(y, z)| Segment {
            from: q(-9.0, y, z),
            to: q(21.0, y, z),
        })
        .collect();
    let f = judge(&mesh, &segments, r, 0.05, 0.02);
    let s = f.stats;
    assert_eq!(s.uncut_area_mm2, 0.0, "{s:?}");
    // Away from the floor's ends, where a ball from outside sinks a little deeper.
    for (i, cusp) in f.map.cusp_mm.iter().enumerate() {
        let c = f.map.lattice.center_at(i);
        assert!(
            !(3.2..8.8).contains(&c.x) || cusp.is_nan() || *cusp < 8e-3,
            "{c}: {cusp}"
        );
    }
    assert!(s.gouge_um_max < 0.5, "{s:?}");
    assert!(s.rest_area_mm2 > 10.0);
}

#[test]
fn different_lattices_are_refused() {
    let reach = reachable(&DropCutter::new(&plane(5.0, 0.0), 1.0), 0.1);
    let other = Swept::new(Lattice {
        step: 0.2,
        ..reach.lattice
    });
    let e = finish(&reach, &other, &[], &FinishOptions::for_scallop(0.02)).unwrap_err();
    assert_eq!(e, FinishError::Lattice);
    assert!(e.to_string().contains("sweep on the lattice"));
}
