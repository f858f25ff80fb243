//! The picture of rest material: where on a part this ball cannot go, from above.

use super::Failure;
use super::output::write_whole;
use super::pictures::{Subject, failed, raster_of_lattice};
use crate::picture::{HeatMap, heat_map};
use crate::sweep::{CuspMap, FinishStats, Rest};
use std::path::Path;

/// Places told in words at most.
const TOLD: usize = 8;

/// Draws `rest.png` into a folder, if there is rest material; nothing otherwise.
pub fn draw(
    dir: &Path,
    of: &Subject,
    map: Option<&CuspMap>,
    finish: Option<&FinishStats>,
    rest: &Rest,
    tolerance: f64,
) -> Result<(), Failure> {
    let Some(map) = map.filter(|_| rest.count > 0) else {
        return Ok(());
    };
    let field = raster_of_lattice(
        &map.lattice,
        map.rest_mm.iter().map(|d| 1e3 * d.max(0.0)).collect(),
    );
    let heights = raster_of_lattice(&map.lattice, map.part_mm.clone());
    let mut facts = Vec::new();
    if let Some(f) = finish {
        facts.push(format!("in plan    {:.1} mm2", f.rest_area_mm2));
    }
    facts.push(format!("on surface {:.1} mm2", rest.area));
    facts.push(format!("places     {}", rest.count));
    facts.extend(rest.spots.iter().take(TOLD).map(|s| {
        let ball = s.largest_ball.map_or_else(
            || "no ball".to_string(),
            |r| format!("ball {:.2}", (200.0 * r).floor() / 100.0),
        );
        format!(
            "X{:.1} Y{:.1}: {:.2} mm, {ball}",
            s.place.x, s.place.y, s.depth
        )
    }));
    let drawn = heat_map(&HeatMap {
        title: &format!("{}: rest material", of.name()),
        subtitle: &format!(
            "what this ball leaves wherever it goes: {:.1} mm2 over {:.1} um, upright walls included",
            rest.area,
            1e3 * tolerance
        ),
        field: &field,
        quantity: "left, along the normal",
        unit: "um",
        limit: 1e3 * tolerance,
        gouge: None,
        heights: Some(&heights),
        facts: &facts,
        width_px: of.width_px,
    })
    .map_err(failed)?;
    write_whole(&dir.join("rest.png"), &drawn)
}
