//! From features to moves: passes, borders, fills, links, order, fitting.
//!
//! ```text
//! level curves in plan -> trimmed to free ground (pass) -> dropped onto the part and fitted (fit) -> swept, and filled where a
//! cusp stands over (fill) -> put in order (order) -> linked (link) -> moves
//! ```
//!
//! Crosses the border: a [`Toolpath`] of typed moves of the *tool tip* in work coordinates, mm. Inside, passes are places of the
//! ball's *centre*. Knows nothing of dialects; of the machine only the few speeds in [`LinkOptions`] that decide between two links.

pub mod fill;
pub mod fit;
pub mod link;
pub mod moves;
pub mod order;
pub mod pass;
pub mod pencil;
pub mod plan;
mod skeleton;
pub mod wall;

pub use fit::FitOptions;
pub use link::LinkOptions;
pub use moves::{Move, MoveKind, Section, Toolpath};
pub use pass::{Pass, PassKind};
pub use plan::{Ground, Plan, PlanOptions, Stage, Strategy};
