//! The part: files in, a triangle soup in millimetres out, with a report on its soundness and a placement on the table.
//!
//! Crosses the border: [`Mesh`] (file axes as loaded, work coordinates once placed; mm, +Z towards the spindle),
//! [`Soundness`], [`Placement`]. Knows nothing of tools.

pub mod check;
pub mod error;
pub mod frame;
pub mod hull;
pub mod load;
pub mod mesh;
pub mod obj;
pub mod stl;
pub mod weld;

pub use check::{Soundness, check};
pub use error::PartError;
pub use frame::{Frame, Origin, PlaceError, PlaceOptions, Placement, Up, place};
pub use load::{Format, Loaded, Units, from_bytes, load};
pub use mesh::Mesh;
pub use weld::{Welded, weld};
