//! Short dialogues with a controller: home, unlock, jog, set zero, probe, go to zero, settings, and lines typed by hand.
//!
//! Crosses the border: bytes and time in; bytes, [`News`] and one result out. Positions mm: machine coordinates in [`Known`] and in
//! what a probe finds, work coordinates where a name says so. Values without I/O or clock: a test plays minutes of homing in
//! milliseconds. It must never know the simulated controller, files, or who asks.
//!
//! ```text
//! introduction -> [ task: next step ] -> send one line by its rule -> answer -> next step -> ... -> done
//!                        ^                                             |
//!                        +---------------------------------------------+     cancel: jog cancel, or hold, standstill, reset
//! ```
//! One line is under way at a time, so what a step finds is known before the next is sent. A [`Task`] says what to send and what
//! it makes of the answers; [`Errand`] knows how: who is asked for reports meanwhile, how long to wait, and how to stop.

mod console;
mod error;
mod exchange;
mod hearing;
mod home;
mod jog;
mod patience;
mod probe;
mod restore;
mod run;
mod saved;
mod stop;
mod tool;
mod travel;
mod unlock;
mod zero;

pub use console::{Console, Verdict, judge, key};
pub use error::ErrandError;
pub use exchange::{Exchange, Heard, News, Rule, Situation, Step, Task};
pub use home::Home;
pub use jog::{Jog, JogMove, JogUnits, Reach, room_of_z};
pub use probe::{Probe, ProbeOptions, Touch};
pub use restore::Restore;
pub use run::{Errand, ErrandOptions};
pub use saved::{Difference, MovedOffset, Save, Saved, differences, moved_offsets, other_startup};
pub use tool::{NO_DIFFERENCE, ToolLength, Watch};
pub use travel::{Down, GoTo, Retract, Rise};
pub use unlock::Unlock;
pub use zero::Zero;
