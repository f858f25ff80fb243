//! Text to what the machine is told: words and blocks (nom), modal state, interpreter, events.
//!
//! Crosses the border: program text in; [`Event`]s in work coordinates, mm and mm/min, out. No I/O, no machine limits, and
//! never any knowledge of `post`: the two are each other's witness.

pub mod event;

pub use event::{Arc, Event, Motion, MotionKind, Plane};
