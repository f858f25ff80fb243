//! When the machine is where: GRBL's junction-deviation planner with the machine's own window, block profiles, arcs as chords, time,
//! and how well it moves.
//!
//! Crosses the border: motions (mm, mm/min) and [`Settings`] in; blocks with speeds in mm/s and times in s out. Knows no shapes, no
//! stock and no protocol. One planner serves two clocks: the time estimate ([`Clock`]) pops a block whenever the window is
//! full, the simulated controller pops one when its own time comes.

pub mod chord;
pub mod demand;
pub mod planner;
pub mod profile;
pub mod quality;
pub mod settings;
pub mod time;

pub use chord::{Chords, chords};
pub use demand::{Demand, Feed, LinkDemand, link_demand};
pub use planner::{Block, Overrides, Planner, Pushed, Speed, Target};
pub use profile::{Phase, Profile, Ramp};
pub use quality::{Leg, MotionQuality, Purpose, SharpTurn, path_quality};
pub use settings::Settings;
pub use time::{Clock, Times, line_times, program_time};
