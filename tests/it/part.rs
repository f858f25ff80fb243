//! Parts through the public door: files on disk to placed meshes.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use morsemill::part::{Format, Origin, PlaceOptions, Units, from_bytes, load, place};

fn binary_stl(triangles: impl ExactSizeIterator<Item = [[f32; 3]; 3]>) -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0u8; 12]);
        t.iter().flatten().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend([0u8; 2]);
    }
    out
}

/// A million triangles: read, welded, checked and placed in the time a person notices nothing.
#[test]
fn a_million_triangles() {
    let n = 708u32;
    let z = |i: u32, j: u32| {
        [
            i as f32 * 0.1,
            j as f32 * 0.1,
            (i as f32 * 0.05).sin() * (j as f32 * 0.04).cos() * 4.0,
        ]
    };
    let cells = n * n;
    let bytes = binary_stl((0..2 * cells as usize).map(|k| {
        let (c, half) = (k as u32 / 2, k % 2);
        let (i, j) = (c % n, c / n);
        if half == 0 {
            [z(i, j), z(i + 1, j), z(i + 1, j + 1)]
        } else {
            [z(i, j), z(i + 1, j + 1), z(i, j + 1)]
        }
    }));
    let t0 = Instant::now();
    let stl = morsemill::part::stl::read(&bytes).unwrap();
    let t1 = Instant::now();
    assert_eq!(stl.triangles.len(), 1_002_528);
    let t2 = Instant::now();
    let loaded = from_bytes("sheet.stl", &bytes, Units::Mm).unwrap();
    let t3 = Instant::now();
    let placed = place(&loaded.mesh, &loaded.soundness, &PlaceOptions::default()).unwrap();
    let t4 = Instant::now();
    eprintln!(
        "read {:?}, load and check {:?}, place {:?}",
        t1 - t0,
        t3 - t2,
        t4 - t3
    );
    assert_eq!(loaded.soundness.open_edges, 4 * n as usize);
    assert_eq!(
        (loaded.soundness.shells, loaded.soundness.flipped_facets),
        (1, 0)
    );
    assert!(!placed.closed);
    // Generous: a busy machine must not fail the suite. Measured figures are in the log line above.
    assert!(t4 - t0 < std::time::Duration::from_secs(30));
}

#[path = "../../examples/parts/catalogue.rs"]
mod catalogue;

/// The committed parts are what the generator makes, byte for byte, and each is under a megabyte.
#[test]
fn shipped_parts_are_as_generated() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/parts");
    for file in catalogue::files() {
        let there = std::fs::read(folder.join(&file.name)).unwrap();
        assert!(there.len() < 1_000_000, "{}", file.name);
        assert!(
            there == file.bytes,
            "{} differs: run cargo run --release --example make_parts",
            file.name
        );
    }
}

/// What the shipped parts' JSON promises is what the readers find.
#[test]
fn shipped_parts_are_as_described() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/parts");
    for (name, format) in [
        ("two-peaks.stl", Format::StlBinary),
        ("peaks-and-pits.stl", Format::StlBinary),
        ("steep-relief.stl", Format::StlBinary),
        ("walled-boss.stl", Format::StlBinary),
        ("noisy-soup.stl", Format::StlBinary),
        ("wave.obj", Format::Obj),
    ] {
        let path = folder.join(name);
        let told: serde_json::Value =
            serde_json::from_slice(&std::fs::read(path.with_extension("json")).unwrap()).unwrap();
        let got = load(&path, Units::Mm).unwrap();
        let s = &got.soundness;
        assert_eq!(got.format, format, "{name}");
        assert!(got.warnings.is_empty());
        assert_eq!(
            s.triangles as u64,
            told["triangles"].as_u64().unwrap(),
            "{name}"
        );
        assert_eq!(s.closed, told["closed"].as_bool().unwrap(), "{name}");
        let size = got.mesh.bounds().size();
        assert!(
            (size.x - told["width"].as_f64().unwrap()).abs() < 1e-9,
            "{name}"
        );
        assert!(
            (size.y - told["height"].as_f64().unwrap()).abs() < 1e-9,
            "{name}"
        );
        let top = got.mesh.bounds().max.z - told["z_max"].as_f64().unwrap();
        assert!(top.abs() < 0.02, "{name}: {top}");
        if name == "noisy-soup.stl" {
            let soup = &told["soup"];
            let count = |key: &str| soup[key].as_u64().unwrap() as usize;
            assert_eq!(s.duplicate_triangles, count("duplicates"));
            assert_eq!(s.degenerate_triangles, count("degenerate"));
            // A facet flipped beside a hole may hang on by nothing that could tell.
            assert!(
                s.flipped_facets.abs_diff(count("flipped")) <= 10,
                "{}",
                s.flipped_facets
            );
            assert!(!s.is_clean() && s.shells < 40);
        } else {
            assert!(s.is_clean(), "{name}: {s:?}");
            assert_eq!(s.shells, 1, "{name}");
        }
        // Placed as drawn, nothing moves.
        let options = PlaceOptions {
            up: "+z".parse().unwrap(),
            origin: Origin::Part,
        };
        assert_eq!(
            place(&got.mesh, s, &options).unwrap().mesh,
            got.mesh,
            "{name}"
        );
    }
}

/// The generator's own algebra: derivatives against differences, exp and sine against the standard library's.
#[test]
fn generator_algebra_holds() {
    use catalogue::surface::{Surface, Term, exp, sin_cos};
    for k in 0..2000 {
        let x = -0.02 * f64::from(k);
        assert!((exp(x) - x.exp()).abs() <= 1e-13 * x.exp(), "{x}");
        let (s, c) = sin_cos(0.37 * x);
        assert!(
            (s - (0.37 * x).sin()).abs() < 1e-14 && (c - (0.37 * x).cos()).abs() < 1e-14,
            "{x}"
        );
    }
    let s = Surface {
        width: 10.0,
        depth: 8.0,
        terms: vec![
            Term::Level(1.0),
            Term::Tilt(0.1, 0.2),
            Term::Dome(0.01),
            Term::Bell(2.0, [4.0, 3.0], [2.0, 1.5], 30.0),
            Term::Mesa(1.0, [6.0, 5.0], [2.0, 3.0], -20.0),
            Term::Ripple(0.5, [7.0, 5.0]),
        ],
    };
    let e = 1e-5;
    for k in 0..50 {
        let (x, y) = (0.2 * f64::from(k), 8.0 - 0.15 * f64::from(k));
        let j = s.jet(x, y);
        let [px, mx, py, my] = [
            s.jet(x + e, y),
            s.jet(x - e, y),
            s.jet(x, y + e),
            s.jet(x, y - e),
        ];
        for (exact, difference) in [
            (j.x, (px.z - mx.z) / (2.0 * e)),
            (j.y, (py.z - my.z) / (2.0 * e)),
            (j.xx, (px.x - mx.x) / (2.0 * e)),
            (j.xy, (px.y - mx.y) / (2.0 * e)),
            (j.yy, (py.y - my.y) / (2.0 * e)),
        ] {
            assert!((exact - difference).abs() < 1e-8, "{exact} {difference}");
        }
    }
}
