//! What a moving ball leaves standing, on a lattice of vertical lines: a word shared by `toolpath` (where to fill) and
//! `simulate` (is it good).
//!
//! Crosses the border: [`Segment`]s of ball *centres* and a ball radius in, heights over a [`Lattice`] out; work coordinates,
//! mm, +Z towards the spindle. Must never know how the segments were made: not passes, features, programs or machines.

pub(crate) mod buckets;
pub mod finish;
pub mod lattice;
pub mod nearest;
pub(crate) mod peak;
pub mod reachable;
pub mod rest;
pub mod swept;
pub mod tiles;

pub use finish::{
    CuspMap, Finish, FinishError, FinishOptions, FinishStats, Judging, Percentiles, finish,
    finish_tiles,
};
pub use lattice::Lattice;
pub use nearest::Paths;
pub use reachable::{Reachable, reachable, reachable_bytes};
pub use rest::{Rest, RestOptions, RestSpot, rest};
pub use swept::{Encounter, Segment, Swept};
pub use tiles::{ReachTiles, Tile};
