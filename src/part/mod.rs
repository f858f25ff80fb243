//! The part: files in, a triangle soup in millimetres out, with a report on its soundness and a placement on the table.
//!
//! Crosses the border: [`Mesh`] (work coordinates once placed, mm, +Z towards the spindle). Knows nothing of tools.

pub mod mesh;

pub use mesh::Mesh;
