//! Cutter-location data: what the tool is to do, before any dialect. The one language that every writer of programs here takes.
//!
//! ```text
//! toolpath + job ----+                         +--> post     a controller's text
//! APT CL file -------+--> steps ( [Step] ) ----+
//! another dialect ---+                         +--> APT CL file
//! ```
//!
//! Crosses the border: [`Step`]s of the *tool tip* in work coordinates, mm and mm/min. Knows nothing of machines or dialects.

pub mod job;
pub mod step;
pub mod toolpath;

pub use job::{Coolant, Job};
pub use step::{Bow, Place, Step};
pub use toolpath::steps;
