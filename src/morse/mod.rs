//! Morse functions on the tool-centre surface and their critical points.
//!
//! Crosses the border: a scalar per node of a [`crate::reach::ToolCentreGrid`] in, critical points with their persistence out.
//! Knows nothing of fields, features or passes.

pub mod cancel;
pub mod critical;
pub mod height;
mod refine;

pub use critical::{CriticalKind, CriticalPoint};
pub use height::{HeightField, MorseOptions, critical_points};
