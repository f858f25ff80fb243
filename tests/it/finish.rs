//! The bar: the program's own text, cut in simulation, leaves what was asked for.
#![allow(clippy::unwrap_used)]

use super::common::{PARTS, Shipped};
use super::plans::planned;
use morsemill::toolpath::Strategy;

fn holds(part: Shipped, scallop: f64, strategy: Strategy) -> Result<(), String> {
    let cell = planned(part, scallop, strategy);
    let p = cell.get().unwrap();
    let f = p.verdict.finish.as_ref().unwrap();
    let s = &f.scallop_um;
    let h = 1e3 * scallop;
    let what = format!(
        "{} {} {h} um: p99 {:.1}, max {:.1}, {:.3} % over, gouge {:.2}, uncut {:.3} mm2",
        part.file,
        strategy.name(),
        s.p99,
        s.max,
        f.over_scallop_area_percent,
        f.gouge_um_max,
        f.uncut_area_mm2
    );
    eprintln!("{what}");
    let good = s.p99 <= h
        && s.max <= 1.5 * h
        && f.over_scallop_area_percent <= 0.5
        && f.gouge_um_max <= 3.0
        && f.uncut_area_mm2 == 0.0
        && p.verdict.passed();
    if good {
        Ok(())
    } else {
        Err(format!("{what}; {:?}", p.verdict.problems))
    }
}

fn all_hold(cases: impl IntoIterator<Item = (Shipped, f64, Strategy)>) {
    let wrong: Vec<String> = cases
        .into_iter()
        .filter_map(|(p, h, s)| holds(p, h, s).err())
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every part, the scan as well: three at the 20 um the issue asks for, three at 40 um, for time.
#[test]
fn iso_scallop_finishes_every_part() {
    let cases: Vec<_> = PARTS
        .iter()
        .map(|p| (*p, super::plans::scallop(p), Strategy::IsoScallop))
        .collect();
    all_hold(cases);
}

/// At 50 um: the same law for a fifth of the time.
#[test]
fn the_other_strategies_finish_two_parts_each() {
    all_hold([
        (PARTS[0], 0.05, Strategy::IsoPickFeed),
        (PARTS[0], 0.05, Strategy::Isoplanar(0.0)),
        (PARTS[2], 0.05, Strategy::IsoPickFeed),
        (PARTS[1], 0.05, Strategy::Isoplanar(30.0)),
    ]);
}

#[test]
#[ignore = "three more plans at 20 um: run with --ignored"]
fn iso_scallop_finishes_every_part_at_20_um() {
    all_hold(PARTS.map(|p| (p, 0.02, Strategy::IsoScallop)));
}
