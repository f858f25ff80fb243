//! Steps to text: `posts/*.toml` checked once, and the one writer that all dialects share.
//!
//! ```text
//! posts/NAME.toml -> Post --+
//!                           v
//! cldata::Step -> Adapter -> Writer -> text          what a controller cannot take is rewritten, if told, or refused
//! ```
//!
//! Crosses the border: [`crate::cldata::Step`]s of the tool tip in work coordinates, mm, in; program text out, with the line of each
//! step. Must never know `gcode`: the two are each other's witness, and only `crate::verify` introduces them. Rounding happens in
//! [`number`] and nowhere else.

pub mod adapt;
pub mod built_in;
pub mod comment;
pub mod definition;
pub mod error;
pub mod number;
pub mod options;
#[cfg(test)]
mod schema_tests;
pub mod specimen;
pub mod template;
pub mod write;
pub mod writer;

pub use adapt::Adapter;
pub use built_in::{BUILT_IN, READERS};
pub use definition::{Post, Units};
pub use error::{PostError, Refusal, Spot};
pub use options::{Options, Rewrite};
pub use specimen::specimen_text;
pub use write::{Posted, write};
pub use writer::Writer;
