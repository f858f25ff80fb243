//! Laws of the way the tool goes: on smooth parts it nowhere turns sharply, hardly at all near saddles, and where it must turn the part
//! says so.
#![allow(clippy::unwrap_used)]

use super::common::{PARTS, sheet};
use super::morse::options;
use super::plans::{R, links, machine, motions, planned, scallop};
use morsemill::geom::{Point, Vector};
use morsemill::kinematics::Settings;
use morsemill::part::Mesh;
use morsemill::reach::DropCutter;
use morsemill::toolpath::plan::{Plan, Strategy, plan, survey};
use morsemill::toolpath::sharp::each_turn;
use morsemill::toolpath::{Ground, Toolpath};
use morsemill::units::MmPerMin;
use morsemill::weigh::weigh;

/// Largest turn from one feed move to the next in a program's text (moves below 5 um taken with the next), degrees, and where. Plunges
/// and withdrawals straight up and down lead into the cut and are in it.
fn largest_turn(text: &str) -> (f64, Point) {
    let mut largest = (0.0, Point::origin());
    let mut from: Option<Point> = None;
    let mut way: Option<Vector> = None;
    for (rapid, a, b, _) in motions(text) {
        if rapid {
            (from, way) = (None, None);
            continue;
        }
        let start = *from.get_or_insert(a);
        let d = b - start;
        if d.norm() < 0.005 {
            continue;
        }
        if let Some(w) = way {
            let turn = w.angle(&d).to_degrees();
            if turn > largest.0 {
                largest = (turn, start);
            }
        }
        (from, way) = (Some(b), Some(d));
    }
    largest
}

/// Read off the text, whatever anyone claims: the shipped smooth parts, one of them steep (68 degrees), feature-wise.
#[test]
fn no_smooth_part_is_cut_with_a_corner() {
    let mut joined = 0;
    for file in ["two-peaks.stl", "peaks-and-pits.stl", "steep-relief.stl"] {
        let part = PARTS.into_iter().find(|p| p.file == file).unwrap();
        let cell = planned(part, scallop(&part), Strategy::IsoScallop);
        let p = cell.get().unwrap();
        let (turn, at) = largest_turn(&p.posted.text);
        assert!(turn <= 30.0, "{file}: {turn:.1} degrees at {at:?}");
        // The dry run and the plan say the same.
        let m = &p.verdict.motion;
        assert_eq!((m.turns_over_30, m.part_corners), (0, 0), "{file}");
        let own = p.plan.figures.largest_turn_deg;
        assert!(own <= 30.0 && m.largest_turn_deg <= 30.0, "{file}: {own}");
        assert_eq!(p.plan.figures.part_corners, 0);
        for s in &p.plan.saddles {
            assert!(s.after <= 15.0, "{file}: {s:?}");
            joined += usize::from(s.before > 30.0);
        }
    }
    // There was something to blend (spirals and passes that run through leave nothing at some saddles).
    assert!(joined > 0);
}

fn laid(mesh: &Mesh, scallop: f64, strategy: Strategy) -> (Ground, Plan) {
    let mut how = options(scallop);
    how.strategy = strategy;
    let cutter = DropCutter::new(mesh, R);
    let ground = survey(cutter, &how, &mut |_, _| {}, &mut |_| {}).unwrap();
    let settings = Settings::from(&machine());
    let clock = |path: &Toolpath| weigh(path, &settings, MmPerMin(1500.0), MmPerMin(500.0));
    let top = mesh.bounds().max.z;
    let plan = plan(mesh, &ground, &how, &links(top), &clock, &mut |_| {}).0;
    (ground, plan)
}

/// What the turns of a plan over a sheet amount to, this far inside its outline: the largest that is no corner of the part, degrees, and
/// how many of over 30 degrees are at one. Beside the sheet stand its upright edges; walls have laws of their own.
fn turns_inside(ground: &Ground, plan: &Plan, max: [f64; 2], inside: f64) -> (f64, usize) {
    let up = Vector::new(0.0, 0.0, R);
    let (mut largest, mut corners) = (0.0f64, 0);
    each_turn(&plan.toolpath, |t| {
        let within = |v: f64, most: f64| v >= inside && v <= most - inside;
        if !within(t.at.x, max[0]) || !within(t.at.y, max[1]) {
            return;
        }
        let own = ground.cutter.own_turn(&(t.at + up), &t.before, &t.after);
        if t.degrees() > 30.0 && own.to_degrees() <= 30.0 {
            corners += 1;
        } else {
            largest = largest.max(t.degrees());
        }
    });
    (largest, corners)
}

/// A part nobody ships: waves of slopes to 63 degrees whose hollows the ball just fits, cut in each way.
#[test]
fn steep_waves_are_cut_without_a_corner() {
    let wave = |x: f64, y: f64| 14.0 * (0.14 * x).sin() * (0.12 * y + 0.3).cos();
    let mesh = sheet([0.0, 0.0], [36.0, 30.0], [144, 120], wave);
    for strategy in [
        Strategy::IsoScallop,
        Strategy::Whole,
        Strategy::Raster(None),
    ] {
        let (ground, plan) = laid(&mesh, 0.04, strategy);
        let (largest, corners) = turns_inside(&ground, &plan, [36.0, 30.0], 0.0);
        assert!(largest <= 30.0, "{strategy:?}: {largest}");
        assert_eq!(corners, 0, "{strategy:?}");
        assert!(
            plan.saddles.iter().all(|s| s.after <= 15.0),
            "{:?}",
            plan.saddles
        );
    }
}

/// Across a groove every pass must turn by its angle, and that is told as the part's doing.
#[test]
fn across_a_groove_the_part_turns_the_way() {
    let slope = 40f64.to_radians().tan();
    let mesh = sheet([0.0, 0.0], [24.0, 20.0], [24, 20], |x, _| {
        slope * (x - 12.0).abs()
    });
    let (ground, plan) = laid(&mesh, 0.04, Strategy::Raster(Some(0.0)));
    // The way onto the rim, where the ball rolls off a slope, is left out.
    let (largest, corners) = turns_inside(&ground, &plan, [24.0, 20.0], 1.0);
    assert!(corners > 10, "{corners}");
    assert!(largest <= 30.0, "{largest}");
    let f = &plan.figures;
    assert!((f.largest_part_corner_deg - 80.0).abs() < 3.0, "{f:?}");
}

/// An upright boss of this outline on a plate, mm.
fn boss(outline: &[[f64; 2]], plate: [f64; 2], high: f64) -> Mesh {
    let mut triangles: Vec<[Point; 3]> = Vec::new();
    let n = outline.len();
    let middle = outline.iter().fold([0.0, 0.0], |m, p| {
        [m[0] + p[0] / n as f64, m[1] + p[1] / n as f64]
    });
    let at = |p: [f64; 2], z: f64| Point::new(p[0], p[1], z);
    // The plate runs on under the boss.
    let corners = [[0.0, 0.0], [plate[0], 0.0], plate, [0.0, plate[1]]];
    triangles.push([
        at(corners[0], 0.0),
        at(corners[1], 0.0),
        at(corners[2], 0.0),
    ]);
    triangles.push([
        at(corners[0], 0.0),
        at(corners[2], 0.0),
        at(corners[3], 0.0),
    ]);
    for k in 0..n {
        let (a, b) = (outline[k], outline[(k + 1) % n]);
        triangles.push([at(a, 0.0), at(b, 0.0), at(b, high)]);
        triangles.push([at(a, 0.0), at(b, high), at(a, high)]);
        triangles.push([at(a, high), at(b, high), at(middle, high)]);
    }
    Mesh { triangles }
}

/// An upright boss with six corners on a plate, turned by an odd angle: walls, a crease around their foot, edges on top.
#[test]
fn walled_parts_are_cut_without_a_corner_of_the_paths_own() {
    let outline: Vec<[f64; 2]> = (0..6)
        .map(|k| {
            let (s, c) = (f64::from(k) * std::f64::consts::FRAC_PI_3 + 0.3).sin_cos();
            [12.0 + 4.0 * c, 10.0 + 4.0 * s]
        })
        .collect();
    let mesh = boss(&outline, [24.0, 20.0], 4.0);
    for strategy in [Strategy::IsoScallop, Strategy::Whole] {
        let (_, plan) = laid(&mesh, 0.04, strategy);
        let f = &plan.figures;
        assert_eq!(f.sharp_turns, 0, "{strategy:?}: {f:?}");
        assert!(f.largest_turn_deg <= 30.0, "{strategy:?}: {f:?}");
    }
}

/// Waves with 5 um of noise on them, as a scan has.
#[test]
fn noisy_parts_are_cut_without_a_corner_of_the_paths_own() {
    let noise = |x: f64, y: f64| {
        let bits = (x * 1e4).round() as i64 * 7_919 + (y * 1e4).round() as i64 * 104_729;
        let mixed = (bits as u64)
            .wrapping_mul(0x9E37_79B9_7F4A_7C15)
            .rotate_left(29)
            .wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    let wave = |x: f64, y: f64| 3.0 * (0.3 * x).sin() * (0.25 * y).cos() + 0.01 * noise(x, y);
    let mesh = sheet([0.0, 0.0], [20.0, 16.0], [80, 64], wave);
    for strategy in [Strategy::IsoScallop, Strategy::Whole] {
        let (_, plan) = laid(&mesh, 0.04, strategy);
        let f = &plan.figures;
        assert_eq!(f.sharp_turns, 0, "{strategy:?}: {f:?}");
        assert!(f.largest_turn_deg <= 30.0, "{strategy:?}: {f:?}");
    }
}
