//! What is smaller or steeper than the ball likes: creases and walls, found once for a part, cut in every layout of it.

use super::layout::flat_stepover;
use super::{Ground, PlanOptions};
use crate::feature::{FaceOptions, Faces, FeatureKind, Regions, faces};
use crate::geom::Point;
use crate::part::Mesh;
use crate::reach::creases;
use crate::toolpath::fill::segments;
use crate::toolpath::fit::FitOptions;
use crate::toolpath::pass::Pass;
use crate::toolpath::pass::pencil::{PencilOptions, needed, pencil};
use crate::toolpath::wall::{Steep, Uprights, WallOptions, Walls, steep, walls};

/// Ground steeper than this is a wall, degrees from the horizontal.
pub const DEFAULT_WALL_ANGLE: f64 = 75.0;
/// Walls are spaced for this share of the cusp wanted: the rest is for chords.
const WALL_SHARE: f64 = 0.94;
/// A crease gets a pencil pass where more than this share of the cusp wanted stands in it.
const PENCIL_START: f64 = 0.75;

/// What is smaller or steeper than the ball likes, and the passes for it: the same for every plan of a part.
pub(in crate::toolpath) struct Detail {
    /// Along all creases, of no feature.
    pencils: Vec<Pass>,
    walls: Walls,
    pub steep: Steep,
    /// The ground divided by walls and sharp edges; none where nothing does, or where it would not be laid.
    pub faces: Option<Faces>,
}

impl Detail {
    pub fn find(part: &Mesh, ground: &Ground, options: &PlanOptions, parted: bool) -> Detail {
        let (grid, cutter) = (&ground.grid, &ground.cutter);
        let fitting = FitOptions::for_scallop(options.scallop, cutter.radius());
        let stepover = flat_stepover(options.scallop, cutter.radius());
        let pencils = PencilOptions::for_stepover(stepover, &fitting);
        let uprights = Uprights::new(part, cutter.radius());
        let steep = steep(
            grid,
            &uprights,
            &WallOptions {
                angle: options.wall_angle.to_radians(),
                // Passes keep off the wall, and cusps stand that much higher on it.
                stepover: flat_stepover(
                    (WALL_SHARE * options.scallop - pencils.off_wall).max(0.5 * options.scallop),
                    cutter.radius(),
                ),
                floor: options.floor.unwrap_or(cutter.bounds().min.z),
                flute: options.flute,
                deepest: options.deepest,
                off_wall: pencils.off_wall,
            },
        );
        let creases = creases(grid, cutter, &pencils.crease);
        Detail {
            walls: walls(grid, cutter, &uprights, &steep, &creases, &fitting),
            pencils: pencil(cutter, &creases, &pencils, &fitting),
            steep,
            faces: parted
                .then(|| {
                    let how = FaceOptions {
                        wall_angle: options.wall_angle.to_radians(),
                        stepover,
                    };
                    faces(grid, &how)
                })
                .flatten(),
        }
    }

    /// The pencil passes that cut what the others leave.
    pub fn pencils(
        &self,
        ground: &Ground,
        regions: &Regions,
        others: &[Pass],
        scallop: f64,
    ) -> Vec<Pass> {
        let cutter = &ground.cutter;
        let all = of_features(&self.pencils, ground, regions);
        let stepover = flat_stepover(scallop, cutter.radius());
        needed(
            all,
            cutter,
            &segments(others),
            PENCIL_START * scallop,
            stepover,
        )
    }

    /// The passes down the walls, and what of them is left standing.
    pub fn walls(&self, ground: &Ground, regions: &Regions) -> Walls {
        Walls {
            passes: of_features(&self.walls.passes, ground, regions),
            too_deep: self.walls.too_deep.clone(),
            uncut: self.walls.uncut,
        }
    }
}

/// The feature at a place; for one on a wall or an edge between faces the lowest of those beside it.
fn beside(q: &Point, ground: &Ground, regions: &Regions) -> Option<usize> {
    let grid = &ground.grid;
    let here = regions.feature_at(grid, &q.xy());
    let faces = regions
        .features
        .first()
        .is_some_and(|f| f.kind == FeatureKind::Face);
    if here.is_some() || !faces {
        return here;
    }
    let n = grid.nearest(q.x, q.y)?;
    (-BESIDE..=BESIDE)
        .flat_map(|dy| (-BESIDE..=BESIDE).map(move |dx| (dx, dy)))
        .filter_map(|d| grid.neighbour(n, d))
        .filter(|&j| regions.label[j] > 0)
        .min_by(|&a, &b| grid.center_z[a].total_cmp(&grid.center_z[b]))
        .map(|j| regions.label[j] as usize - 1)
}

/// Nodes to either side in which a face counts as beside a place.
const BESIDE: i32 = 2;

/// Passes given to the features they begin in.
fn of_features(passes: &[Pass], ground: &Ground, regions: &Regions) -> Vec<Pass> {
    passes
        .iter()
        .map(|p| Pass {
            feature: p.points.first().and_then(|q| beside(q, ground, regions)),
            ..p.clone()
        })
        .collect()
}
