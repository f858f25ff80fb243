//! The dry run's laws, on programs whose result can be computed by hand.
#![allow(clippy::unwrap_used)]

use morsemill::gcode::Dialect;
use morsemill::geom::Point;
use morsemill::machine::Machine;
use morsemill::part::Mesh;
use morsemill::reach::DropCutter;
use morsemill::simulate::{DryRun, DryRunOptions, Kind, PartContext, Stock, dry_run};
use morsemill::sweep::ReachTiles;
use std::fmt::Write;

const R: f64 = 3.0;
const HEAD: &str = "G21 G90 G17 G94\nM3 S12000\nG0 Z20\n";

fn machine() -> Machine {
    Machine::load("longmill-30x30").unwrap()
}

fn grid(nx: usize, ny: usize, size: [f64; 2], z: impl Fn(f64, f64) -> f64) -> Mesh {
    let at = |i: usize, j: usize| {
        let (x, y) = (
            size[0] * i as f64 / nx as f64,
            size[1] * j as f64 / ny as f64,
        );
        Point::new(x, y, z(x, y))
    };
    let mut mesh = Mesh::default();
    for j in 0..ny {
        for i in 0..nx {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([a, c, d]);
        }
    }
    mesh
}

fn judge(mesh: &Mesh, text: &str, step: f64, options: &DryRunOptions) -> DryRun {
    let drop = DropCutter::new(mesh, R);
    let reach = ReachTiles::new(&drop, step, 1);
    let part = PartContext {
        mesh,
        drop: &drop,
        reachable: &reach,
    };
    dry_run(text, Dialect::Grbl, &machine(), Some(&part), options)
}

fn options() -> DryRunOptions {
    DryRunOptions::new(0.02, Stock::Allowance(0.5))
}

fn has(r: &DryRun, kind: Kind) -> bool {
    r.problems.iter().any(|p| p.kind == kind)
}

/// Zig-zag over a plate of 20 x 15 at z = 0 with the tip at `z`, links at feed.
fn raster(w: f64, z: f64) -> String {
    let mut t = HEAD.to_string();
    writeln!(t, "G0 X-0.5 Y0\nG0 Z2\nG1 Z{z:.3} F500").unwrap();
    let n = (15.0 / w).round() as i32;
    for k in 0..=n {
        let y = 15.0 * f64::from(k) / f64::from(n);
        let (a, b) = if k % 2 == 0 {
            (-0.5, 20.5)
        } else {
            (20.5, -0.5)
        };
        writeln!(t, "G1 X{a} Y{y:.4} F1500\nX{b}").unwrap();
    }
    t.push_str("G0 Z20\nM5\nM30\n");
    t
}

fn plate() -> Mesh {
    grid(1, 1, [20.0, 15.0], |_, _| 0.0)
}

#[test]
fn a_raster_over_a_plate_leaves_the_computed_cusp_and_passes() {
    let w: f64 = 0.6;
    let r = judge(&plate(), &raster(w, 0.0), 0.05, &options());
    let cusp = 1e3 * (R - (R * R - w * w / 4.0).sqrt());
    let f = r.finish.unwrap();
    assert!(r.passed(), "{:?}", r.problems);
    // The crest may lie half a cell from the nearest centre.
    assert!(
        f.scallop_um.max <= cusp + 0.1 && f.scallop_um.max > cusp - 2.6,
        "{f:?}"
    );
    // Lines a whole number of cells apart put every cell at one of few distances: half a cell more or less from the median one.
    assert!((f.scallop_um.p50 - cusp / 4.0).abs() < 1.3, "{f:?}");
    assert_eq!(f.uncut_area_mm2, 0.0);
    assert!(f.gouge_um_max < 0.01 && f.rest_area_mm2 < 0.01);
    assert!((f.judged_area_mm2 - 300.0).abs() < 3.0);
    // The figures of the text.
    assert_eq!(r.program.retracts, 1);
    let cut = 26.0 * 21.0 + 15.0 + 2.0;
    assert!((r.program.cut_mm - cut).abs() < 0.01, "{:?}", r.program);
    assert!(
        (r.time_s.total - r.time_s.cutting - r.time_s.air - r.time_s.dwell - r.time_s.idle).abs()
            < 1e-9
    );
    // 561 mm at 1500 mm/min are 22.4 s, and corners cost something.
    assert!((22.4..45.0).contains(&r.time_s.cutting), "{:?}", r.time_s);
    assert_eq!(r.extents.min.unwrap(), [-0.5, 0.0, 0.0]);
    assert_eq!(r.extents.max.unwrap(), [20.5, 15.0, 20.0]);
}

#[test]
fn a_stepover_too_wide_fails_with_its_cusp() {
    let w: f64 = 1.0;
    let r = judge(&plate(), &raster(w, 0.0), 0.05, &options());
    let cusp = 1e3 * (R - (R * R - w * w / 4.0).sqrt());
    let f = r.finish.unwrap();
    assert!(!r.passed() && has(&r, Kind::Scallop) && !has(&r, Kind::Gouge));
    assert!((f.scallop_um.max - cusp).abs() < 4.7, "{f:?} {cusp}");
    // Above 20 um beyond y = sqrt(R^2 - (R - 0.02)^2) from each pass.
    let y = (R * R - (R - 0.02f64).powi(2)).sqrt();
    let share = 100.0 * (1.0 - 2.0 * y / w);
    assert!(
        (f.over_scallop_area_percent - share).abs() < 5.0,
        "{f:?} {share}"
    );
}

#[test]
fn a_known_gouge_fails_with_that_figure_and_its_line() {
    let mut text = raster(0.6, 0.0);
    text = text.replace("M5\n", "G0 X10 Y7\nG0 Z1\nG1 Z-0.05 F200\nG0 Z20\nM5\n");
    let r = judge(&plate(), &text, 0.05, &options());
    let f = r.finish.unwrap();
    assert!((f.gouge_um_max - 50.0).abs() < 0.001, "{f:?}");
    let p = r.problems.iter().find(|p| p.kind == Kind::Gouge).unwrap();
    let line = 1 + text
        .lines()
        .position(|l| l.starts_with("G1 Z-0.05"))
        .unwrap();
    assert_eq!(p.line, Some(line));
    assert!(
        p.text
            .starts_with("the ball cuts 50.0 um into the part at X10.000 Y7.000 Z-0.050"),
        "{}",
        p.text
    );
    // Two micrometres are within the limit.
    let r = judge(&plate(), &raster(0.6, -0.002), 0.05, &options());
    assert!(!has(&r, Kind::Gouge), "{:?}", r.problems);
    assert!((r.finish.unwrap().gouge_um_max - 2.0).abs() < 0.001);
}

#[test]
fn a_gouge_on_a_slope_is_measured_along_the_normal() {
    let mesh = grid(1, 1, [20.0, 15.0], |_, y| y);
    // Contact at y = 7.5; centre one radius along (0, -1, 1) / sqrt 2; 30 um too low.
    let s = R / 2f64.sqrt();
    let (y, z) = (7.5 - s, 7.5 + s - R - 0.03);
    let text = format!("{HEAD}G0 X2 Y{y:.6}\nG1 Z{z:.6} F300\nX18\nG0 Z20\n");
    let r = judge(&mesh, &text, 0.1, &options());
    let want = 30.0 / 2f64.sqrt();
    assert!((r.finish.unwrap().gouge_um_max - want).abs() < 0.01);
}

/// A chord over a crest gouges between its ends only: both ends are exact.
#[test]
fn gouge_between_the_ends_of_a_chord_is_found() {
    let mesh = grid(40, 1, [20.0, 10.0], |x, _| -((x - 10.0) / 10.0).powi(2));
    let drop = DropCutter::new(&mesh, R);
    let tip = |x: f64| drop.drop(x, 5.0).unwrap().center.z - R;
    let (a, b) = (tip(6.0), tip(14.0));
    let text = format!("{HEAD}G0 X6 Y5\nG1 Z{a:.6} F300\nX14 Z{b:.6}\nG0 Z20\n");
    let r = judge(&mesh, &text, 0.1, &options());
    // At x = 10 the tip belongs at 0.
    let f = r.finish.unwrap();
    assert!((f.gouge_um_max + 1e3 * a).abs() < 2.0, "{f:?} {a}");
}

#[test]
fn beside_an_upright_wall_the_gouge_is_the_overlap() {
    let mut mesh = grid(1, 1, [20.0, 10.0], |_, _| 0.0);
    let p = Point::new;
    let wall = [
        p(0.0, 10.0, 0.0),
        p(20.0, 10.0, 0.0),
        p(20.0, 10.0, 8.0),
        p(0.0, 10.0, 8.0),
    ];
    mesh.triangles.push([wall[0], wall[1], wall[2]]);
    mesh.triangles.push([wall[0], wall[2], wall[3]]);
    // 20 um into a wall 8 mm high.
    let text = format!("{HEAD}G0 X2 Y5\nG1 Z0 F300\nY7.02\nX18\nY5\nG0 Z20\n");
    let r = judge(&mesh, &text, 0.1, &options());
    assert!(
        (r.finish.unwrap().gouge_um_max - 20.0).abs() < 0.01,
        "{:?}",
        r.finish
    );
}

#[test]
fn a_rapid_through_stock_is_named_with_its_line() {
    let mut text = raster(0.6, 0.0);
    // Back over ground already cut: nothing there any more.
    text = text.replace("G0 Z20\nM5", "G0 Z0.1\nG0 X3 Y3\nG0 Z20\nM5");
    let r = judge(&plate(), &text, 0.1, &options());
    assert!(!has(&r, Kind::Collision), "{:?}", r.problems);
    // The same before it is cut: 0.5 mm stand there.
    let text = raster(0.6, 0.0).replace("G0 Z2\n", "G0 Z0.2\nG0 X3 Y3\nG0 X-0.5 Y0\n");
    let r = judge(&plate(), &text, 0.1, &options());
    let lines: Vec<usize> = r
        .problems
        .iter()
        .filter(|p| p.kind == Kind::Collision)
        .filter_map(|p| p.line)
        .collect();
    // Down into the stock (line 5), through it (6), and back through the same slot it has not cut (7).
    assert_eq!(lines, [5, 6, 7]);
    let p = r.problems.iter().find(|p| p.line == Some(6)).unwrap();
    assert!(
        p.text
            .starts_with("rapid move through 0.300 mm of standing stock"),
        "{}",
        p.text
    );
    // In a block of 10 mm the plunge at rapid speed to Z2 already fails.
    let block = DryRunOptions::new(0.02, Stock::Block { top_z: 10.0 });
    let r = judge(&plate(), &raster(0.6, 0.0), 0.1, &block);
    let p = r
        .problems
        .iter()
        .find(|p| p.kind == Kind::Collision)
        .unwrap();
    assert_eq!(p.line, Some(5));
    assert!(p.text.starts_with("rapid move through 7.9"), "{}", p.text);
}

#[test]
fn a_fold_deeper_than_the_ball_is_rest_not_uncut() {
    // A valley of half-angle 30 degrees: the ball stops R (1 / sin 30 - 1) = R above its line.
    let mesh = grid(2, 1, [20.0, 12.0], |x, _| (x - 10.0).abs() * 3f64.sqrt());
    let drop = DropCutter::new(&mesh, R);
    let mut text = HEAD.to_string();
    text.push_str("G0 X-3 Y-0.5\n");
    let mut xs: Vec<f64> = (0..=1300).map(|k| -3.0 + 0.02 * f64::from(k)).collect();
    xs.retain(|x| drop.drop(*x, 6.0).is_some());
    for (k, x) in xs.iter().enumerate() {
        let z = drop.drop(*x, 6.0).unwrap().center.z - R;
        let (a, b) = if k % 2 == 0 {
            (-0.5, 12.5)
        } else {
            (12.5, -0.5)
        };
        writeln!(text, "G1 X{x:.4} Z{z:.6} F1500\nY{a}\nY{b}").unwrap();
    }
    text.push_str("G0 Z40\n");
    let r = judge(&mesh, &text, 0.1, &options());
    assert!(!has(&r, Kind::Gouge));
    // Away from the valley's open ends, where a ball from outside sinks deeper.
    let map = r.map.unwrap();
    let mut judged = 0;
    for (i, cusp) in map.cusp_mm.iter().enumerate() {
        let c = map.lattice.center_at(i);
        if !cusp.is_nan() && (3.0..9.0).contains(&c.y) {
            judged += 1;
            // Steps of 0.02 in x are 0.04 along the slope: 0.07 um.
            assert!(*cusp < 5e-4, "{c} {cusp}");
        }
    }
    assert!(judged > 200 * 59);
    // Between the two contacts, R cos 30 to either side in plan, less what is within a cusp's height of the ball: s along the flank,
    // R^2 + s^2 = (R + h)^2. A little less at the open ends.
    let h = options().scallop_mm;
    let s = ((R + h).powi(2) - R * R).sqrt();
    let want = 2.0 * (R * 30f64.to_radians().cos() - 0.5 * s) * 12.0;
    let f = r.finish.unwrap();
    assert!((f.rest_area_mm2 - want).abs() < 0.03 * want, "{f:?} {want}");
}

#[test]
fn uncut_ground_fails() {
    let text: String = raster(0.6, 0.0)
        .lines()
        .take(40)
        .fold(String::new(), |t, l| t + l + "\n");
    let r = judge(&plate(), &text, 0.1, &options());
    assert!(has(&r, Kind::Uncut) && !r.passed());
    assert!(r.finish.unwrap().uncut_area_mm2 > 50.0);
}

#[test]
fn limits_name_the_axis_and_the_excess() {
    let m = machine();
    let long = m.travel[0].0 + 12.5;
    let text = format!("{HEAD}G0 X1 Y1\nG1 Z1 F1000\nX{}\n", long + 1.0);
    let r = dry_run(&text, Dialect::Grbl, &m, None, &options());
    let p = r.problems.iter().find(|p| p.kind == Kind::Limit).unwrap();
    assert!(
        p.text
            .starts_with("axis X: the program reaches from 1.000 (line 4)"),
        "{}",
        p.text
    );
    assert!(p.text.ends_with("12.500 mm too long"), "{}", p.text);
    assert_eq!(p.line, Some(6));
    assert!(r.finish.is_none());
    assert!(r.not_modelled.iter().any(|t| t.contains("no part given")));
    // Within the travels it passes.
    let text = format!("{HEAD}G0 X1 Y1\nG1 Z1 F1000\nX100\n");
    let r = dry_run(&text, Dialect::Grbl, &m, None, &options());
    assert!(r.passed(), "{:?}", r.problems);
}

#[test]
fn an_arc_reaches_beyond_its_ends() {
    let m = machine();
    let d = m.travel[1].0 + 4.0;
    // A half circle over X swings half its width out in Y.
    let text = format!(
        "{HEAD}G0 X1 Y1\nG1 Z1 F1000\nG2 X{} Y1 I{} J0\nG1 X1\nG3 X{} I{}\n",
        1.0 + d,
        d / 2.0,
        1.0 + d,
        d / 2.0
    );
    let r = dry_run(&text, Dialect::Grbl, &m, None, &options());
    assert!(
        r.problems.iter().any(|p| p.text.starts_with("axis Y")),
        "{:?}",
        r.problems
    );
}

#[test]
fn spindle_and_syntax_and_feeds() {
    let m = machine();
    let run = |t: &str| dry_run(t, Dialect::Grbl, &m, None, &options());
    let r = run("G0 Z5\nG0 X3 Y3\nG1 Z0 F100\nX9\nM3 S12000\nX3\n");
    let p = r.problems.iter().find(|p| p.kind == Kind::Spindle).unwrap();
    assert_eq!(p.line, Some(3));
    assert!(
        p.text
            .starts_with("2 moves at feed with the spindle stopped"),
        "{}",
        p.text
    );
    let r = run(&format!("M3 S{}\nG0 Z5\n", m.spindle[1].0 + 1000.0));
    assert!(has(&r, Kind::Spindle));
    let r = run("G0 Z5\nG1 X10\n");
    let p = r.problems.iter().find(|p| p.kind == Kind::Syntax).unwrap();
    assert_eq!((p.line, r.passed()), (Some(2), false));
    let r = run(&format!(
        "M3 S12000\nG0 Z5\nG0 X1 Y1\nG1 X50 F{}\n",
        m.max_rate[0].0 * 2.0
    ));
    assert!(r.passed() && r.warnings.iter().any(|w| w.kind == Kind::Feed));
}

#[test]
fn same_report_for_any_number_of_threads() {
    let mesh = grid(30, 30, [20.0, 15.0], |x, y| {
        (x * 0.5).sin() + (y * 0.4).cos()
    });
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| judge(&mesh, &raster(0.9, -1.0), 0.1, &options()))
    };
    // The map holds NaN beside the part: compare what is written.
    let (a, b) = (run(1), run(3));
    assert_eq!(
        serde_json::to_string(&a).unwrap(),
        serde_json::to_string(&b).unwrap()
    );
    assert!(
        a.map
            .unwrap()
            .cusp_mm
            .iter()
            .zip(&b.map.unwrap().cusp_mm)
            .all(|(p, q)| p.to_bits() == q.to_bits())
    );
}

#[test]
fn json_has_the_promised_names() {
    let r = judge(&plate(), &raster(0.6, 0.0), 0.1, &options());
    let v = serde_json::to_value(&r).unwrap();
    for path in [
        "/program/lines",
        "/program/bytes",
        "/program/cut_mm",
        "/program/rapid_mm",
        "/program/retracts",
        "/time_s/total",
        "/time_s/cutting",
        "/time_s/air",
        "/motion/vertical_acceleration_rms_mm_s2",
        "/motion/vertical_speed_rms_mm_s",
        "/motion/largest_turn_deg",
        "/motion/largest_turn_line",
        "/motion/turns_over_30",
        "/motion/part_corners",
        "/motion/largest_part_corner_deg",
        "/motion/non_cutting_s",
        "/motion/non_cutting_percent",
        "/finish/scallop_um/p50",
        "/finish/scallop_um/p95",
        "/finish/scallop_um/p99",
        "/finish/scallop_um/p999",
        "/finish/scallop_um/max",
        "/finish/over_scallop_area_percent",
        "/finish/gouge_um_max",
        "/finish/uncut_area_mm2",
        "/finish/rest_area_mm2",
    ] {
        assert!(
            v.pointer(path).is_some_and(serde_json::Value::is_number),
            "{path}"
        );
    }
    assert_eq!(v["verdict"], "pass");
    assert!(v["problems"].is_array());
}
