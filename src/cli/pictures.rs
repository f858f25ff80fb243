//! Pictures of a report: the planner's and the dry run's data turned into what `picture` draws.

use super::Failure;
use super::output::write_whole;
use crate::feature::Regions;
use crate::geom::{Point, Vector};
use crate::morse::{CriticalKind, CriticalPoint, MorseFunction, Surface};
use crate::part::Placement;
use crate::picture::{
    Gouge, HeatMap, Line, LineKind, Marker, MarkerKind, PictureError, Raster, Scene, SurfaceScene,
    View, heat_map, passes, shaded, surface_map,
};
use crate::reach::{NodeKind, ToolCentreGrid};
use crate::simulate::DryRun;
use crate::sweep::{CuspMap, Lattice};
use crate::toolpath::plan::Plan;
use crate::toolpath::{Ground, MoveKind, PassKind};
use std::path::Path;

/// Width of pictures when none is asked for, pixels.
pub const WIDTH: u32 = 1500;

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The part's file, for the title.
    pub part: &'a Path,
    /// Height of a closed part's underside, mm.
    pub floor: Option<f64>,
    /// Width of the pictures, pixels.
    pub width_px: u32,
}

impl<'a> Subject<'a> {
    /// A placed part.
    pub fn new(part: &'a Path, placement: &Placement, width_px: u32) -> Subject<'a> {
        Subject {
            width_px,
            part,
            floor: placement.closed.then(|| placement.mesh.bounds().min.z),
        }
    }

    pub(super) fn name(&self) -> String {
        self.part
            .file_name()
            .map(|n| n.to_string_lossy().into_owned())
            .unwrap_or_default()
    }
}

/// Draws `features.png`, `passes.png` and `cusps.png` into a folder.
pub fn draw_all(
    dir: &Path,
    of: &Subject,
    ground: &Ground,
    plan: &Plan,
    verdict: &DryRun,
    scallop: f64,
) -> Result<(), Failure> {
    let heights = match &verdict.map {
        Some(map) => raster_of_lattice(&map.lattice, map.part_mm.clone()),
        None => grid_heights(ground),
    };
    write_whole(
        &dir.join("features.png"),
        &feature_picture(of, ground, &plan.regions, &heights, 1)?,
    )?;
    write_whole(
        &dir.join("passes.png"),
        &pass_picture(of, ground, plan, &heights, verdict)?,
    )?;
    if let Some(map) = &verdict.map {
        write_whole(
            &dir.join("cusps.png"),
            &cusp_picture(of, map, &heights, verdict, scallop)?,
        )?;
    }
    Ok(())
}

/// The picture of critical points and features, as PNG bytes; values of the function with so many decimals.
pub fn features(
    of: &Subject,
    ground: &Ground,
    regions: &Regions,
    decimals: usize,
) -> Result<Vec<u8>, Failure> {
    feature_picture(of, ground, regions, &grid_heights(ground), decimals)
}

fn grid_heights(ground: &Ground) -> Raster<f32> {
    let g = &ground.grid;
    let heights = (0..g.len())
        .map(|i| {
            let q = g.xy(i);
            ground
                .cutter
                .surface_z(q.x, q.y)
                .map_or(f32::NAN, |z| z as f32)
        })
        .collect();
    raster_of_grid(g, heights)
}

/// The picture of a function on a raw mesh and its critical points, as PNG bytes; values with so many decimals.
pub fn function_on_mesh(
    of: &Subject,
    surface: &Surface,
    value: &[f64],
    function: MorseFunction,
    critical: &[CriticalPoint],
    decimals: usize,
) -> Result<Vec<u8>, Failure> {
    let [a, b, c] = super::show::counts(critical);
    surface_map(&SurfaceScene {
        title: &format!("{}: {}", of.name(), function.name()),
        subtitle: &format!("{a} maxima, {b} minima, {c} saddles on the mesh"),
        points: &surface.points,
        triangles: &surface.triangles,
        value,
        quantity: function.name(),
        unit: function.unit(),
        markers: &markers(critical, decimals),
        view: View::default(),
        width_px: of.width_px,
    })
    .map_err(failed)
}

pub(super) fn failed(e: PictureError) -> Failure {
    Failure::failed(e)
}

fn raster_of_grid<T>(g: &ToolCentreGrid, values: Vec<T>) -> Raster<T> {
    Raster {
        origin: g.origin,
        step: g.step,
        nx: g.nx,
        ny: g.ny,
        values,
    }
}

pub(super) fn raster_of_lattice<T>(l: &Lattice, values: Vec<T>) -> Raster<T> {
    Raster {
        origin: l.origin,
        step: l.step,
        nx: l.nx,
        ny: l.ny,
        values,
    }
}

fn markers(critical: &[CriticalPoint], decimals: usize) -> Vec<Marker> {
    critical
        .iter()
        .map(|c| Marker {
            kind: match c.kind {
                CriticalKind::Maximum => MarkerKind::Max,
                CriticalKind::Minimum => MarkerKind::Min,
                CriticalKind::Saddle => MarkerKind::Saddle,
            },
            at: c.contact,
            label: format!("{:.decimals$}", c.value),
        })
        .collect()
}

/// Feature labels where the *contacts* are: the part's surface is coloured, not the plane of the centres.
fn labels(g: &ToolCentreGrid, regions: &Regions) -> Raster<u16> {
    let mut values = vec![0u16; g.len()];
    for i in 0..g.len() {
        if g.kind[i] != NodeKind::Ground {
            continue;
        }
        if let Some(n) = g.nearest(g.point[i].x, g.point[i].y) {
            values[n] = regions.label[i];
        }
    }
    // Contacts spread out on hollow ground and leave gaps: fill them from beside, a few rings.
    for _ in 0..6 {
        let old = values.clone();
        for (i, v) in values.iter_mut().enumerate() {
            if *v == 0 {
                *v = [(1, 0), (0, 1), (-1, 0), (0, -1)]
                    .iter()
                    .filter_map(|d| g.neighbour(i, *d).map(|j| old[j]))
                    .find(|l| *l > 0)
                    .unwrap_or(0);
            }
        }
    }
    raster_of_grid(g, values)
}

fn feature_words(regions: &Regions) -> Vec<(u16, String)> {
    regions
        .features
        .iter()
        .enumerate()
        .map(|(k, f)| {
            (
                (k + 1) as u16,
                format!("{} {}  {:.0} mm2", k + 1, f.kind.name(), f.area_mm2),
            )
        })
        .collect()
}

fn feature_picture(
    of: &Subject,
    ground: &Ground,
    regions: &Regions,
    heights: &Raster<f32>,
    decimals: usize,
) -> Result<Vec<u8>, Failure> {
    let labels = labels(&ground.grid, regions);
    let [a, b, c] = super::show::counts(&ground.critical);
    shaded(&Scene {
        title: &format!("{}: features", of.name()),
        subtitle: &format!(
            "{a} maxima, {b} minima, {c} saddles; {} features",
            regions.features.len()
        ),
        heights,
        labels: Some(&labels),
        features: &feature_words(regions),
        markers: &markers(&ground.critical, decimals),
        floor: of.floor,
        view: View::default(),
        width_px: of.width_px,
    })
    .map_err(failed)
}

fn pass_picture(
    of: &Subject,
    ground: &Ground,
    plan: &Plan,
    heights: &Raster<f32>,
    verdict: &DryRun,
) -> Result<Vec<u8>, Failure> {
    // Drawn where the part is touched, so that lines and colours agree.
    let touched = |c: &Point| ground.cutter.drop(c.x, c.y).map_or(*c, |t| t.point);
    let up = Vector::new(0.0, 0.0, ground.grid.radius);
    let mut lines: Vec<Line> = plan
        .passes
        .iter()
        .map(|p| Line {
            kind: if p.kind == PassKind::Fill {
                LineKind::Fill
            } else {
                LineKind::Cut
            },
            feature: p
                .feature
                .map_or(0, |f| (f + 1).min(u16::MAX as usize) as u16),
            points: p.run().iter().map(touched).collect(),
        })
        .collect();
    let moves = &plan.toolpath.moves;
    for w in moves.windows(2) {
        let kind = match w[1].kind {
            MoveKind::Cut => continue,
            MoveKind::Link => LineKind::Link,
            MoveKind::Plunge => LineKind::Plunge,
            MoveKind::Rapid | MoveKind::Retract => LineKind::Rapid,
        };
        let at = |tip: Point| {
            if kind == LineKind::Link {
                touched(&(tip + up))
            } else {
                tip
            }
        };
        lines.push(Line {
            kind,
            feature: 0,
            points: vec![at(w[0].to), at(w[1].to)],
        });
    }
    let labels = labels(&ground.grid, &plan.regions);
    passes(
        &Scene {
            title: &format!("{}: passes", of.name()),
            subtitle: &format!(
                "{} passes, {:.0} mm at feed, {} retracts, {}",
                plan.passes.len(),
                verdict.program.cut_mm,
                verdict.program.retracts,
                super::show::clock(verdict.time_s.total)
            ),
            heights,
            labels: Some(&labels),
            features: &feature_words(&plan.regions),
            markers: &[],
            floor: of.floor,
            view: View::default(),
            width_px: of.width_px,
        },
        &lines,
    )
    .map_err(failed)
}

fn cusp_picture(
    of: &Subject,
    map: &CuspMap,
    heights: &Raster<f32>,
    verdict: &DryRun,
    scallop: f64,
) -> Result<Vec<u8>, Failure> {
    let um = |v: &[f32]| v.iter().map(|c| c * 1e3).collect::<Vec<f32>>();
    let field = raster_of_lattice(&map.lattice, um(&map.cusp_mm));
    let depth = raster_of_lattice(&map.lattice, um(&map.gouge_mm));
    let mut facts = Vec::new();
    if let Some(f) = &verdict.finish {
        let s = &f.scallop_um;
        facts.extend([
            format!("p50   {:.1} um", s.p50),
            format!("p95   {:.1} um", s.p95),
            format!("p99   {:.1} um", s.p99),
            format!("p99.9 {:.1} um", s.p999),
            format!("max   {:.1} um", s.max),
            format!("over  {:.3} %", f.over_scallop_area_percent),
            format!("gouge {:.1} um", f.gouge_um_max),
            format!("uncut {:.2} mm2", f.uncut_area_mm2),
            format!("rest  {:.1} mm2", f.rest_area_mm2),
        ]);
    }
    heat_map(&HeatMap {
        title: &format!("{}: cusps after the dry run", of.name()),
        subtitle: &format!(
            "asked for {:.1} um; verdict: {}",
            scallop * 1e3,
            verdict.verdict
        ),
        field: &field,
        quantity: "cusp height",
        unit: "um",
        limit: scallop * 1e3,
        gouge: Some(Gouge {
            depth: &depth,
            limit: 3.0,
        }),
        heights: Some(heights),
        facts: &facts,
        width_px: of.width_px,
    })
    .map_err(failed)
}
