//! From features to moves: passes, borders, fills, links, order, fitting.
//!
//! Crosses the border: a [`Toolpath`] of typed moves of the *tool tip* in work coordinates, mm. Knows nothing of dialects.

pub mod moves;

pub use moves::{Move, MoveKind, Section, Toolpath};
