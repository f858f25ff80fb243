//! Parts through the public door: files on disk to placed meshes.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use morsemill::part::{PlaceOptions, Units, from_bytes, place};

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
