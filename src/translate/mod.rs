//! From a program in one dialect to steps that any other can be written from.
//!
//! Crosses the border: a program being read in; [`crate::cldata::Step`]s out, work coordinates, mm and mm/min, with the line each comes from. Modes are gone then
//! (units, absolute or incremental, feed mode, planes, cycles, calls): what is left is what the machine was told. Knows nothing of posts.
//!
//! Nothing is guessed: the machine's offsets and stored places are not in the program, so a place is known in work coordinates only once the
//! program has named it there, and what hangs on one that is not (an incremental move from wherever the tool stands, a return to a stored place)
//! is refused with its line.

mod error;
mod steps;

pub use error::TranslateError;
pub use steps::{Note, Steps, unknown_state};

#[cfg(test)]
mod tests;
