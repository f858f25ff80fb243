//! Cutter-location data: what the tool is to do, before any dialect. The one language that every writer of programs here takes.
//!
//! ```text
//! toolpath + job ----+                         +--> post     a controller's text
//! APT CL file -------+--> steps ( [Step] ) ----+
//! another dialect ---+                         +--> APT CL file
//! ```
//!
//! Crosses the border: [`Step`]s of the *tool tip* in work coordinates, mm and mm/min. Knows nothing of machines or dialects.

mod arc;
pub mod cutter;
pub mod error;
pub mod job;
mod lines;
pub mod note;
pub mod read;
mod statement;
pub mod step;
mod token;
pub mod toolpath;
pub mod write;

pub use cutter::Cutter;
pub use error::{ClError, ClProblem};
pub use job::{Coolant, Job};
pub use note::{Note, NoteKind};
pub use read::{About, Lengths, ReadOptions, Reader};
pub use step::{Bow, Place, Step};
pub use toolpath::steps;
pub use write::{ClWriteError, WriteOptions, Writer};
