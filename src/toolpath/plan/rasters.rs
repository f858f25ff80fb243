//! The rasters that a plan is compared with: laid and weighed as it is, never run.

use super::lay::{Known, easing, home, lay, saddles};
use super::layout::{Bench, Layout, flat_stepover};
use super::{Candidate, Plan, Stage};
use crate::toolpath::link::chain::Chain;
use crate::toolpath::link::order::order;
use crate::toolpath::link::{LinkOptions, link};
use crate::toolpath::pass::PassKind;
use crate::toolpath::sharp::sharp_turns;

/// The two rasters that a plan is compared with: linked staying down, and retracting to the safe height after each pass, at the job's
/// feed throughout, as rasters are: no link is slowed to keep the tool calm. A plan that is the first of them already needs only the
/// other.
pub(in crate::toolpath) fn rasters(
    bench: &Bench,
    raster: Option<Layout>,
    chosen: &Plan,
    stage: &mut dyn FnMut(Stage),
) -> Vec<Candidate> {
    let mut out = Vec::new();
    let steady = LinkOptions {
        vertical: f64::INFINITY,
        ..*bench.links
    };
    let own;
    let raster = match &raster {
        Some(layout) => {
            let open = Bench {
                closed_loop: false,
                links: &steady,
                ..*bench
            };
            own = lay(&open, layout, &[], &Known::default(), stage);
            out.extend(own.candidates.iter().cloned());
            &own
        }
        None => chosen,
    };
    // The same passes, each a chain of its own, and no link worth staying down for.
    let apart: Vec<Chain> = raster
        .passes
        .iter()
        .filter(|p| p.kind != PassKind::Turn)
        .map(|p| vec![p.clone()])
        .collect();
    let links = LinkOptions {
        retract_worth: f64::NEG_INFINITY,
        retract_center_z: bench.links.safe_center_z,
        ..steady
    };
    let (cutter, count) = (&bench.ground.cutter, apart.len());
    let ordered = order(apart, home(cutter));
    let (path, _) = link(
        cutter,
        bench.air(),
        &ordered,
        &raster.regions,
        &links,
        &raster.fitting,
        &easing(
            &raster.fitting,
            flat_stepover(bench.options.scallop, cutter.radius()),
            &saddles(bench.ground),
        ),
    );
    let figures = (bench.weigh)(&path).with_turns(&sharp_turns(cutter, &path));
    let name = format!("{} retracting", raster.layout.name());
    out.push(Candidate::of(name, &path, count, figures));
    out
}
