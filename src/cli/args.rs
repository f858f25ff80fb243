//! Arguments that several subcommands share: one struct per concern, checked once.

use super::Failure;
use crate::part::{Loaded, Origin, PlaceOptions, Placement, Units, Up, load, place};
use crate::tool::Tool;
use std::path::Path;

/// The part and how it lies on the table.
#[derive(Clone, Debug, clap::Args)]
pub struct PartArgs {
    /// Units of the part file
    #[arg(long, default_value = "mm", value_parser = parse::<Units>)]
    pub units: Units,
    /// What points to the spindle: +x, -x, +y, -y, +z, -z, or auto (the mean normal of an open surface; +z for a closed solid)
    #[arg(long, default_value = "auto", value_parser = parse::<Up>, allow_hyphen_values = true, value_name = "AXIS|auto")]
    pub up: Up,
    /// Where the program's zero is: part (the file's own origin), top-left or top-center of the stock
    #[arg(long, default_value = "top-left", value_parser = parse::<Origin>)]
    pub origin: Origin,
}

/// The cutter and the finish.
#[derive(Clone, Debug, clap::Args)]
pub struct ToolArgs {
    /// Cutter: ball:DIAMETER in mm
    #[arg(long, default_value = "ball:6", value_parser = parse::<Tool>)]
    pub tool: Tool,
    /// Highest cusp that may be left, mm
    #[arg(
        long,
        default_value_t = 0.02,
        allow_negative_numbers = true,
        value_name = "MM"
    )]
    pub scallop: f64,
}

/// A clap value parser for anything that says in plain words why it refuses.
pub fn parse<T: std::str::FromStr>(text: &str) -> Result<T, String>
where
    T::Err: std::fmt::Display,
{
    text.parse().map_err(|e: T::Err| e.to_string())
}

/// Refuses a number that is not above zero.
pub fn above_zero(flag: &str, value: f64, unit: &str) -> Result<f64, Failure> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Failure::Failed(format!(
            "{flag} {value}: must be a number of {unit} above zero"
        )))
    }
}

impl ToolArgs {
    /// Checks what clap cannot.
    pub fn check(&self) -> Result<(), Failure> {
        above_zero("--scallop", self.scallop, "mm")?;
        let most = self.tool.radius / 4.0;
        if self.scallop > most {
            return Err(Failure::Failed(format!(
                "--scallop {}: a {} leaves sensible cusps up to {most} mm only: ask for less",
                self.scallop, self.tool
            )));
        }
        if self.scallop < 1e-4 {
            return Err(Failure::Failed(format!(
                "--scallop {}: no mill cuts finer than 0.0001 mm: did you mean micrometres? The unit is mm",
                self.scallop
            )));
        }
        Ok(())
    }

    /// Refuses a ball that dwarfs the part.
    pub fn check_against(&self, placement: &Placement) -> Result<(), Failure> {
        let size = placement.mesh.bounds().size();
        let d = 2.0 * self.tool.radius;
        if d > size.x.max(size.y) {
            return Err(Failure::Failed(format!(
                "the tool ({}, {d} mm across) is larger than the part ({:.3} x {:.3} mm): take a smaller ball, or check --units",
                self.tool, size.x, size.y
            )));
        }
        Ok(())
    }
}

impl PartArgs {
    /// Reads the part and lays it on the table.
    pub fn load(&self, path: &Path) -> Result<(Loaded, Placement), Failure> {
        let loaded = load(path, self.units).map_err(Failure::failed)?;
        let options = PlaceOptions {
            up: self.up,
            origin: self.origin,
        };
        let placement = place(&loaded.mesh, &loaded.soundness, &options)
            .map_err(|e| Failure::Failed(format!("{}: {e}", path.display())))?;
        Ok((loaded, placement))
    }
}
