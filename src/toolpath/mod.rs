//! From features to moves: layouts, passes, chains, fills, order, links.
//!
//! ```text
//! plan: which layouts (estimate), each laid and weighed, the quickest kept
//!   layout: regions -> level curves in plan, corners rounded, trimmed to free ground (pass, border, corner)
//!           -> measured as a draft, the metric evened out, laid again (even)
//!           -> walls at constant height, pencils along creases (detail, wall, pencil), ridges of faces where fronts meet (ridge)
//!           -> dropped onto the part and fitted (fit) -> joined end to end by smooth turns (chain, turn, onward)
//!           -> swept, and filled where a cusp stands over (fill, stroke, skeleton, settle)
//!           -> put in order (order) -> linked along the surface or just over it (bridge), with arcs off and onto it (link, lead) -> moves, arcs
//! ```
//!
//! Crosses the border: a [`Toolpath`] of typed moves of the *tool tip* in work coordinates, mm. Inside, passes are places of the
//! ball's *centre*. Knows nothing of dialects; of the machine only the few speeds in [`LinkOptions`] that decide between two links.

pub mod arcs;
mod border;
mod bridge;
mod calm;
pub mod chain;
mod choose;
mod corner;
mod crests;
pub mod curve;
mod detail;
pub mod ease;
mod errand;
mod estimate;
mod even;
pub mod fill;
pub mod fit;
mod layout;
mod lead;
pub mod link;
pub mod moves;
mod onward;
pub mod order;
pub mod pass;
pub mod pencil;
pub mod plan;
mod ridge;
pub mod saddle;
mod settle;
pub mod sharp;
mod skeleton;
mod spiral;
mod stroke;
mod turn;
pub mod wall;

pub use arcs::{ArcOptions, arcs};
pub use detail::DEFAULT_WALL_ANGLE;
pub use fit::{FitOptions, FitReport, proof};
pub use layout::{FILL_START, Layout, PLAN_SHARES, flat_stepover};
pub use link::{LinkOptions, RETRACT_WORTH};
pub use moves::{Move, MoveKind, Section, Toolpath, Turn};
pub use pass::{Pass, PassKind, PassOptions};
pub use plan::{Candidate, Figures, Ground, Plan, PlanOptions, Stage, Strategy};
