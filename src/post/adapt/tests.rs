//! Steps rewritten, against the curves that were meant.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::geom::Plane;
use crate::post::definition::Arcs;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn post(name: &str) -> Post {
    Post::load(name).unwrap()
}

fn adapted(post: &Post, rewrite: Rewrite, steps: &[Step]) -> (Vec<Step>, f64) {
    let mut a = Adapter::new(post, rewrite);
    let mut out = Vec::new();
    for s in steps {
        a.step(s, &mut |s: &Step| -> Result<(), Refusal> {
            out.push(s.clone());
            Ok(())
        })
        .unwrap();
    }
    (out, a.deviation().0)
}

fn rapid(x: f64, y: f64, z: f64) -> Step {
    Step::Rapid {
        to: [Some(x), Some(y), Some(z)],
    }
}

fn spindle(direction: i8) -> Step {
    Step::Spindle {
        direction,
        speed: Rpm(if direction == 0 { 0.0 } else { 9000.0 }),
        spin_up: Seconds(0.0),
    }
}

fn up() -> Step {
    Step::MachineRapid {
        to: [None, None, Some(0.0)],
    }
}

#[test]
fn offs_before_the_end_are_the_ends_business() {
    let off = Step::Coolant(Coolant::Off);
    let steps = [
        rapid(0.0, 0.0, 5.0),
        spindle(1),
        spindle(0),
        off.clone(),
        Step::End,
    ];
    let (out, _) = adapted(&post("grbl"), Rewrite::default(), &steps);
    assert_eq!(out, [rapid(0.0, 0.0, 5.0), spindle(1), Step::End]);
    let (out, _) = adapted(&post("haas"), Rewrite::default(), &steps);
    assert_eq!(out, [rapid(0.0, 0.0, 5.0), spindle(1), up(), Step::End]);
    let steps = [
        spindle(0),
        off.clone(),
        rapid(0.0, 0.0, 5.0),
        off.clone(),
        Step::Comment("x".into()),
        Step::End,
    ];
    let (out, _) = adapted(&post("grbl"), Rewrite::default(), &steps);
    assert_eq!(out, steps, "only the last ones before the end");
}

#[test]
fn a_tool_change_stops_everything_and_goes_up() {
    let flood = Step::Coolant(Coolant::Flood);
    let tool = |number| Step::Tool { number };
    let steps = [
        tool(1),
        spindle(1),
        flood.clone(),
        rapid(0.0, 0.0, 5.0),
        tool(2),
        spindle(1),
        rapid(0.0, 0.0, 5.0),
        Step::End,
    ];
    let (out, _) = adapted(&post("fanuc"), Rewrite::default(), &steps);
    let off = Step::Coolant(Coolant::Off);
    let want = [
        up(),
        tool(1),
        spindle(1),
        flood.clone(),
        rapid(0.0, 0.0, 5.0),
        spindle(0),
        off.clone(),
        up(),
        tool(2),
        spindle(1),
        flood.clone(),
        rapid(0.0, 0.0, 5.0),
        up(),
        Step::End,
    ];
    assert_eq!(out, want);
    // Where there is no change, the first tool is only a word.
    let (out, _) = adapted(
        &post("grbl"),
        Rewrite::default(),
        &[tool(1), spindle(1), tool(1)],
    );
    assert_eq!(out, [tool(1), spindle(1), tool(1)]);
}

#[test]
fn a_pause_that_stops_the_spindle_gives_it_back() {
    let flood = Step::Coolant(Coolant::Flood);
    let pause = Step::Pause { optional: false };
    let steps = [
        spindle(1),
        flood.clone(),
        pause.clone(),
        rapid(0.0, 0.0, 5.0),
    ];
    let (out, _) = adapted(&post("grbl"), Rewrite::default(), &steps);
    assert_eq!(out, steps, "GRBL keeps both running");
    let (out, _) = adapted(&post("heidenhain"), Rewrite::default(), &steps);
    let off = Step::Coolant(Coolant::Off);
    let want = [
        spindle(1),
        flood.clone(),
        spindle(0),
        off,
        pause,
        spindle(1),
        flood,
        rapid(0.0, 0.0, 5.0),
    ];
    assert_eq!(out, want);
}

#[test]
fn a_controller_that_waits_needs_no_time() {
    let step = Step::Spindle {
        direction: 1,
        speed: Rpm(100.0),
        spin_up: Seconds(3.0),
    };
    let time =
        |name| match &adapted(&post(name), Rewrite::default(), std::slice::from_ref(&step)).0[0] {
            Step::Spindle { spin_up, .. } => spin_up.0,
            _ => f64::NAN,
        };
    assert_eq!((time("haas"), time("grbl")), (0.0, 3.0));
}

fn arc(from: Point, center: Point, plane: Plane, sweep: f64, climb: f64) -> (Step, Step) {
    let [u, v, w] = plane.axes();
    let (a, b) = (from[u] - center[u], from[v] - center[v]);
    let (sin, cos) = sweep.sin_cos();
    let mut to = from;
    to[u] = center[u] + a * cos - b * sin;
    to[v] = center[v] + a * sin + b * cos;
    to[w] += climb;
    let start = rapid(from.x, from.y, from.z);
    let bow = Some(Bow {
        plane,
        center,
        sweep,
    });
    let feed = MmPerMin(100.0);
    (start, Step::Feed { to, bow, feed })
}

#[test]
fn a_full_circle_becomes_halves() {
    let mut p = post("grbl");
    p.arcs.full_circles = false;
    let (start, circle) = arc(
        Point::new(10.0, 0.0, 1.0),
        Point::new(4.0, 0.0, 1.0),
        Plane::Xy,
        -TAU,
        0.0,
    );
    let steps = [start, circle];
    assert_eq!(
        adapted(&p, Rewrite::default(), &steps).0,
        steps,
        "not told to"
    );
    let told = Rewrite {
        halves: true,
        ..Rewrite::default()
    };
    let (out, deviation) = adapted(&p, told, &steps);
    assert_eq!((out.len(), deviation), (3, 0.0));
    let Step::Feed {
        to, bow: Some(bow), ..
    } = &out[1]
    else {
        panic!("{out:?}")
    };
    assert!(
        (to - Point::new(-2.0, 0.0, 1.0)).norm() < 1e-12 && bow.sweep == -PI,
        "{out:?}"
    );
    // Two turns and a half of a helix where one turn at once is allowed: three arcs, exactly on it.
    let (start, helix) = arc(
        Point::new(10.0, 0.0, 1.0),
        Point::new(4.0, 0.0, 1.0),
        Plane::Xy,
        2.5 * TAU,
        5.0,
    );
    let (out, _) = adapted(&post("grbl"), told, &[start, helix]);
    assert_eq!(out.len(), 4);
    let Step::Feed { to, .. } = &out[1] else {
        panic!()
    };
    assert!((to.z - (1.0 + 5.0 / 3.0)).abs() < 1e-12);
}

#[test]
fn what_makes_too_many_lines_is_refused() {
    let mut p = post("grbl");
    p.arcs = Arcs::NONE;
    for (within, text) in [
        (1e-12, "would become"),
        (0.0, "must be above zero"),
        (f64::NAN, "must be above zero"),
    ] {
        let told = Rewrite {
            lines_within: Some(Mm(within)),
            ..Rewrite::default()
        };
        let (start, circle) = arc(
            Point::new(1e4, 0.0, 0.0),
            Point::origin(),
            Plane::Xy,
            TAU,
            0.0,
        );
        let mut a = Adapter::new(&p, told);
        let mut all = |_: &Step| -> Result<(), Refusal> { Ok(()) };
        a.step(&start, &mut all).unwrap();
        let e = a.step(&circle, &mut all).unwrap_err().to_string();
        assert!(e.contains(text), "{e}");
    }
}

/// Distance from a place to a helix, by brute force.
fn away(p: &Point, from: &Point, bow: &Bow, climb: f64) -> f64 {
    let [u, v, w] = bow.plane.axes();
    let (a, b) = (from[u] - bow.center[u], from[v] - bow.center[v]);
    let at = |t: f64| {
        let (sin, cos) = (bow.sweep * t).sin_cos();
        let mut q = *from;
        q[u] = bow.center[u] + a * cos - b * sin;
        q[v] = bow.center[v] + a * sin + b * cos;
        q[w] += climb * t;
        (p - q).norm()
    };
    let n = 2000;
    let best = (0..=n)
        .map(|i| f64::from(i) / f64::from(n))
        .min_by(|s, t| at(*s).total_cmp(&at(*t)))
        .unwrap();
    let (mut lo, mut hi) = (best - 1.0 / f64::from(n), best + 1.0 / f64::from(n));
    for _ in 0..60 {
        let third = (hi - lo) / 3.0;
        if at(lo + third) < at(hi - third) {
            hi -= third
        } else {
            lo += third
        }
    }
    at(lo.clamp(0.0, 1.0))
}

fn planes() -> impl Strategy<Value = Plane> {
    prop_oneof![Just(Plane::Xy), Just(Plane::Zx), Just(Plane::Yz)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn lines_stay_within_their_tolerance(
        plane in planes(), radius in 0.1..80.0_f64, start in 0.0..TAU, sweep in 0.05..7.0_f64, way: bool, climb in -5.0..5.0_f64,
        within in 0.001..0.1_f64,
    ) {
        let mut p = post("grbl");
        p.arcs = Arcs::NONE;
        let [u, v, _] = plane.axes();
        let center = Point::new(3.0, -2.0, 1.0);
        let mut from = center;
        from[u] += radius * start.cos();
        from[v] += radius * start.sin();
        let (first, curve) = arc(from, center, plane, if way { sweep } else { -sweep }, climb);
        let Step::Feed { to: end, bow: Some(bow), .. } = &curve else { panic!() };
        let told = Rewrite { lines_within: Some(Mm(within)), ..Rewrite::default() };
        let (out, deviation) = adapted(&p, told, &[first, curve.clone()]);
        prop_assert!(deviation <= within * (1.0 + 1e-9));
        let mut at = from;
        let mut worst = 0.0_f64;
        let stride = out.len() / 8 + 1;
        for (i, s) in out[1..].iter().enumerate() {
            let Step::Feed { to, bow: None, .. } = s else { panic!("{s:?}") };
            if i % stride == 0 {
                for t in [0.25, 0.5, 1.0] {
                    worst = worst.max(away(&(at + (to - at) * t), &from, bow, climb));
                }
            }
            at = *to;
        }
        prop_assert_eq!(&at, end);
        prop_assert!(worst <= deviation + 1e-6, "{} {}", worst, deviation);
    }

    #[test]
    fn adapting_twice_changes_nothing(steps in proptest::collection::vec(crate::post::writer::any_step(), 0..30), halves: bool, lines: bool) {
        let rewrite = Rewrite { halves, lines_within: lines.then_some(Mm(0.05)), comments: true };
        for p in crate::post::writer::posts() {
            let mut once = Vec::new();
            let mut a = Adapter::new(p, rewrite);
            for s in steps.iter().chain([&Step::End]) {
                let refused = a.step(s, &mut |s: &Step| -> Result<(), Refusal> { once.push(s.clone()); Ok(()) });
                if refused.is_err() {
                    return Ok(());
                }
            }
            let (twice, deviation) = adapted(p, rewrite, &once);
            prop_assert_eq!(deviation, 0.0);
            prop_assert_eq!(format!("{once:?}"), format!("{twice:?}"));
        }
    }
}
