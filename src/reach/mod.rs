//! What a ball can reach: the drop cutter over a triangle soup, and the *tool-centre surface* on a regular grid.
//!
//! ```text
//!         .--.        c  ball centre = p + R n
//!        ( c  )       p  contact point, n  outward normal there
//!         '-p'____    no point of the part is nearer to c than R
//! ```
//!
//! Crosses the border: [`crate::part::Mesh`] in work coordinates (mm, +Z to the spindle) comes in; contacts and a
//! [`ToolCentreGrid`] go out. Knows nothing of Morse functions or passes.

mod bvh;
mod clear;
pub mod contact;
pub mod crease;
pub mod drop;
pub mod grid;
mod near;
mod shell;

pub use contact::touch_height;
pub use crease::{Crease, CreaseOptions, CreasePoint, creases};
pub use drop::{Contact, DropCutter, Hint};
pub use grid::{Crossing, GridError, GridOptions, GridPlan, LINK, NodeKind, ToolCentreGrid};
pub use shell::Heights;
