//! From features to moves: layouts, passes, chains, fills, order, links.
//!
//! ```text
//! plan     which layouts (estimate, choose), each laid and weighed, the quickest kept; a layout is laid so (plan::lay):
//!   pass     regions -> level curves in plan, corners rounded, trimmed to free ground; borders, pencils along creases, ridges of faces
//!   wall     walls at constant height
//!            -> measured as a draft, the metric evened out, laid again (plan::even)
//!   fit      -> dropped onto the part, fewest points within tolerance, every segment proven
//!   ease     -> sharp turns made bends
//!   fill     -> swept, and filled where a cusp stands over
//!   link     -> joined end to end by smooth turns (chain), put in order, linked along the surface, beside it or over it
//! arcs     -> moves, with arcs where the dialect takes them
//! ```
//!
//! Crosses the border: a [`Toolpath`] of typed moves of the *tool tip* in work coordinates, mm. Inside, passes are places of the
//! ball's *centre*. Knows nothing of dialects; of the machine only the few speeds in [`LinkOptions`] that decide between two links.

pub mod arcs;
pub mod curve;
pub mod ease;
pub mod fill;
pub mod fit;
pub mod link;
pub mod moves;
pub mod pass;
pub mod plan;
pub mod saddle;
pub mod sharp;
pub mod wall;

pub use arcs::{ArcOptions, arcs};
pub use fit::{FitOptions, FitReport, proof};
pub use link::{LinkOptions, RETRACT_WORTH};
pub use moves::{Move, MoveKind, Section, Toolpath, Turn};
pub use pass::{Pass, PassKind, PassOptions};
pub use plan::detail::DEFAULT_WALL_ANGLE;
pub use plan::lay::{FILL_START, PLAN_SHARES};
pub use plan::layout::{Layout, flat_stepover};
pub use plan::{Candidate, Figures, Ground, Plan, PlanOptions, Stage, Strategy};
