//! Paths to text: `posts/*.toml` checked once, and the one writer that all dialects share.
//!
//! Crosses the border: a [`crate::toolpath::Toolpath`] of tool-tip moves in work coordinates, mm, and a [`Job`] in; program text
//! out, with the line of each move. Must never know `gcode`: the two are each other's witness, and only `crate::verify` introduces
//! them. Rounding happens in [`number`] and nowhere else.

pub mod comment;
pub mod definition;
pub mod number;
pub mod template;
pub mod write;

pub use definition::{BUILT_IN, Post, Units};
pub use write::{PostError, Posted, write};
