#![allow(clippy::unwrap_used)]
use super::*;
use crate::part::check::check;
use proptest::prelude::*;

/// A wavy sheet of w x h mm, as `place` would meet it, under a motion.
fn sheet(w: f64, h: f64, wave: f64, motion: &Isometry3<f64>) -> Mesh {
    let n = 12;
    let p = |i: usize, j: usize| {
        let (x, y) = (w * i as f64 / n as f64, h * j as f64 / n as f64);
        // Even in x and y about the middle: the mean normal is +Z exactly.
        let z = wave * (2.0 * PI * x / w).cos() * (2.0 * PI * y / h).cos();
        motion * Point::new(x, y, z)
    };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            triangles.push([p(i, j), p(i + 1, j), p(i + 1, j + 1)]);
            triangles.push([p(i, j), p(i + 1, j + 1), p(i, j + 1)]);
        }
    }
    Mesh { triangles }
}

fn auto(mesh: &Mesh) -> Placement {
    place(mesh, &check(mesh), &PlaceOptions::default()).unwrap()
}

fn with_up(mesh: &Mesh, up: &str, origin: Origin) -> Placement {
    let options = PlaceOptions {
        up: up.parse().unwrap(),
        origin,
    };
    place(mesh, &check(mesh), &options).unwrap()
}

fn box_mesh(x: f64, y: f64, z: f64) -> Mesh {
    let p = |i: usize| {
        Point::new(
            (i & 1) as f64 * x,
            (i >> 1 & 1) as f64 * y,
            (i >> 2) as f64 * z,
        )
    };
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Mesh {
        triangles: quads
            .iter()
            .flat_map(|q| [[p(q[0]), p(q[1]), p(q[2])], [p(q[0]), p(q[2]), p(q[3])]])
            .collect(),
    }
}

#[test]
fn plus_z_at_the_parts_origin_changes_no_bit() {
    let mut m = sheet(60.1, 40.3, 3.0, &Isometry3::translation(-0.1, 7.7, 1e-9));
    m.triangles[0][0].x = -0.0;
    let p = with_up(&m, "+z", Origin::Part);
    let bits = |m: &Mesh| -> Vec<u64> {
        m.triangles
            .iter()
            .flatten()
            .flat_map(|p| p.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
            .collect()
    };
    assert_eq!(bits(&p.mesh), bits(&m));
    assert_eq!(p.work_from_part, Isometry3::identity());
}

#[test]
fn every_axis_goes_up_exactly_and_keeps_handedness() {
    let m = box_mesh(1.0, 2.0, 4.0);
    for (up, point, there) in [
        ("+x", [1.0, 2.0, 4.0], [-4.0, 2.0, 1.0]),
        ("-x", [1.0, 2.0, 4.0], [4.0, 2.0, -1.0]),
        ("+y", [1.0, 2.0, 4.0], [1.0, -4.0, 2.0]),
        ("-y", [1.0, 2.0, 4.0], [1.0, 4.0, -2.0]),
        ("z", [1.0, 2.0, 4.0], [1.0, 2.0, 4.0]),
        ("-Z", [1.0, 2.0, 4.0], [1.0, -2.0, -4.0]),
    ] {
        let p = with_up(&m, up, Origin::Part);
        let i = m
            .triangles
            .iter()
            .flatten()
            .position(|q| *q == Point::from(point))
            .unwrap();
        let q = *p.mesh.triangles.iter().flatten().nth(i).unwrap();
        assert_eq!(q, Point::from(there), "{up}");
        assert!((p.work_from_part * Point::from(point) - q).norm() < 1e-12);
        assert!((check(&p.mesh).volume_mm3.unwrap() - 8.0).abs() < 1e-12);
        assert!(!check(&p.mesh).inside_out);
    }
    assert_eq!(
        "up".parse::<Up>().unwrap_err(),
        "up axis \"up\" is not known: write auto, +x, -x, +y, -y, +z or -z"
    );
    assert_eq!(
        "here".parse::<Origin>().unwrap_err(),
        "origin \"here\" is not known: write part, top-left or top-center"
    );
}

#[test]
fn origins() {
    let m = sheet(60.0, 40.0, 3.0, &Isometry3::translation(5.0, 6.0, 7.0));
    let b = with_up(&m, "+z", Origin::TopLeft).mesh.bounds();
    assert_eq!((b.min.x, b.min.y, b.max.z), (0.0, 0.0, 0.0));
    assert!((b.max.x - 60.0).abs() < 1e-12 && (b.min.z + 6.0).abs() < 1e-12);
    let b = with_up(&m, "+z", Origin::TopCenter).mesh.bounds();
    assert!((b.min.x + 30.0).abs() < 1e-12 && (b.max.y - 20.0).abs() < 1e-12 && b.max.z == 0.0);
}

#[test]
fn an_upright_sheet_is_not_turned_by_rounding() {
    for tilt in [0.0, 3e-7, -8e-7] {
        let m = sheet(
            60.0,
            40.0,
            3.0,
            &Isometry3::rotation(Vector::new(tilt, 0.0, 0.0)),
        );
        let p = auto(&m);
        assert_eq!(p.work_from_part, Isometry3::identity(), "{tilt}");
        assert_eq!(p.mesh, m);
        assert!(
            (p.frame.rectangle[0] - 60.0).abs() < 1e-4
                && (p.frame.rectangle[1] - 40.0).abs() < 1e-4
        );
    }
    // Long side along Y: a quarter turn, exact.
    let p = auto(&sheet(40.0, 60.0, 3.0, &Isometry3::identity()));
    let b = p.mesh.bounds();
    assert_eq!(
        (b.min.x, b.max.x, b.min.y, b.max.y),
        (-60.0, 0.0, 0.0, 40.0)
    );
    // Equal sides: nothing to turn.
    let m = sheet(50.0, 50.0, 3.0, &Isometry3::identity());
    assert_eq!(auto(&m).mesh, m);
}

#[test]
fn a_closed_solid_keeps_its_z_and_hears_of_the_best_axis() {
    // A gable roof lying on its side: the roof faces +y.
    let mut m = box_mesh(40.0, 10.0, 40.0);
    let p = auto(&m);
    assert!(p.closed);
    assert_eq!(p.work_from_part, Isometry3::identity());
    // From any axis one face of a box faces away. Bottom 400 of 4800.
    assert!((p.reachable_share[4].1 - (1.0 - 400.0 / 4800.0)).abs() < 1e-12);
    assert_eq!(
        p.notes,
        [
            "a closed solid has no mean normal: the file's +z stays up; 91.7 % of the area faces it or stands upright"
        ]
    );
    // Draft on the bottom: pull the z = 0 face's corners in, and +z loses nothing but -z sees the walls.
    for q in m.triangles.iter_mut().flatten() {
        if q.z > 0.0 {
            q.x = if q.x == 0.0 { -5.0 } else { 45.0 };
        }
    }
    let note = &auto(&m).notes[0];
    assert!(
        note.contains("+z stays up; ") && note.contains("; most faces "),
        "{note}"
    );
    assert!(
        note.ends_with("): set the up axis to that to mill from there"),
        "{note}"
    );
}

#[test]
fn flipped_facets_do_not_turn_the_part_over_and_are_told() {
    let mut m = sheet(60.0, 40.0, 3.0, &Isometry3::identity());
    for t in m.triangles.iter_mut().step_by(3) {
        t.swap(0, 1);
    }
    let p = auto(&m);
    assert_eq!(p.mesh, m);
    let part = "96 of 288 facets (33.";
    assert!(p.notes[0].starts_with(part), "{:?}", p.notes);
    assert!(p.notes[0].ends_with("of the area) are wound against their neighbours: the majority decides which side is outside"));

    // Nothing welds: no neighbour can tell, but the share that faces away does.
    let mut m = sheet(60.0, 40.0, 3.0, &Isometry3::identity());
    for (i, t) in m.triangles.iter_mut().enumerate() {
        t.iter_mut().for_each(|p| p.z += 1e-5 * (i % 7) as f64);
        if i % 10 == 0 {
            t.swap(0, 1);
        }
    }
    let p = auto(&m);
    assert!((p.work_from_part * Vector::z()).z > 0.99);
    assert!(
        p.notes[0].ends_with(
            "of the area faces away from the tool: overhangs, or facets wound the wrong way"
        ),
        "{:?}",
        p.notes
    );

    // All of it upside down.
    let mut m = sheet(60.0, 40.0, 3.0, &Isometry3::identity());
    m.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_eq!(
        with_up(&m, "+z", Origin::Part).notes,
        [
            "by its winding the surface faces away from the tool (100.0 % of the area): it is milled as it lies; if this is the \
          wrong side, turn the up axis round"
        ]
    );
}

#[test]
fn nothing_is_refused() {
    let flat = Mesh {
        triangles: vec![[Point::origin(); 3]],
    };
    for m in [Mesh::default(), flat] {
        let e = place(&m, &check(&m), &PlaceOptions::default()).unwrap_err();
        assert_eq!(
            e.to_string(),
            "the part has no area: nothing can be placed or milled"
        );
    }
}

proptest! {
    /// Whatever the motion, the sheet comes back level with its long side along X, and the isometry is the motion made.
    #[test]
    fn any_pose_is_put_right(axis in proptest::array::uniform3(-3.0f64..3.0), shift in proptest::array::uniform3(-90.0f64..90.0)) {
        let pose = Isometry3::new(shift.into(), axis.into());
        let m = sheet(60.0, 40.0, 3.0, &pose);
        let p = auto(&m);
        let size = p.mesh.bounds().size();
        prop_assert!((size - Vector::new(60.0, 40.0, 6.0)).norm() < 1e-6, "{size}");
        for (a, b) in m.triangles.iter().flatten().zip(p.mesh.triangles.iter().flatten()) {
            prop_assert!((p.work_from_part * a - b).norm() < 1e-9);
        }
        // The wave's side that faced the normal is still up: mean normal of the placed mesh is +Z.
        let n: Vector = p.mesh.triangles.iter().map(Mesh::doubled_area_vector).sum();
        prop_assert!(n.normalize().z > 1.0 - 1e-9);
        prop_assert!(p.notes.is_empty());
    }
}
