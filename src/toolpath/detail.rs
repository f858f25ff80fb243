//! What is smaller or steeper than the ball likes: creases and walls, found once for a part, cut in every layout of it.

use super::fill::segments;
use super::fit::FitOptions;
use super::layout::{PLAN_SHARES, flat_stepover};
use super::pass::Pass;
use super::pencil::{PencilOptions, needed, pencil};
use super::plan::{Ground, PlanOptions};
use super::wall::{Steep, TooDeep, Uprights, WallOptions, steep, walls};
use crate::feature::Regions;
use crate::part::Mesh;
use crate::reach::{Crease, creases};

/// Ground steeper than this is a wall, degrees from the horizontal.
pub const DEFAULT_WALL_ANGLE: f64 = 75.0;
/// A crease gets a pencil pass where more than this share of the cusp wanted stands in it.
const PENCIL_START: f64 = 0.75;

/// What is smaller or steeper than the ball likes: the same for every plan of a part.
pub(super) struct Detail<'a> {
    creases: Vec<Crease>,
    pencil: PencilOptions,
    uprights: Uprights<'a>,
    pub steep: Steep,
}

impl<'a> Detail<'a> {
    pub fn find(part: &'a Mesh, ground: &Ground, options: &PlanOptions) -> Detail<'a> {
        let (grid, cutter) = (&ground.grid, &ground.cutter);
        let fitting = FitOptions::for_scallop(options.scallop, cutter.radius());
        let stepover = flat_stepover(options.scallop, cutter.radius());
        let pencil = PencilOptions::for_stepover(stepover, &fitting);
        let uprights = Uprights::new(part, cutter.radius());
        let steep = steep(
            grid,
            &uprights,
            &WallOptions {
                angle: options.wall_angle.to_radians(),
                stepover: flat_stepover(PLAN_SHARES[0] * options.scallop, cutter.radius()),
                floor: options.floor.unwrap_or(cutter.bounds().min.z),
                flute: options.flute,
                off_wall: pencil.off_wall,
            },
        );
        Detail {
            creases: creases(grid, cutter, &pencil.crease),
            pencil,
            uprights,
            steep,
        }
    }

    /// The pencil passes that cut what the others leave.
    pub fn pencils(
        &self,
        ground: &Ground,
        regions: &Regions,
        others: &[Pass],
        scallop: f64,
        fitting: &FitOptions,
    ) -> Vec<Pass> {
        let (grid, cutter) = (&ground.grid, &ground.cutter);
        let all = pencil(grid, cutter, regions, &self.creases, &self.pencil, fitting);
        let stepover = flat_stepover(scallop, cutter.radius());
        needed(
            all,
            cutter,
            &segments(others),
            PENCIL_START * scallop,
            stepover,
        )
    }

    pub fn walls(
        &self,
        ground: &Ground,
        regions: &Regions,
        fitting: &FitOptions,
    ) -> (Vec<Pass>, Vec<TooDeep>) {
        walls(
            &ground.grid,
            &ground.cutter,
            regions,
            &self.uprights,
            &self.steep,
            &self.creases,
            fitting,
        )
    }
}
