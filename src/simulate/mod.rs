//! The dry run: what the machine will do with this text, and whether that is good.
//!
//! Crosses the border: a program's *text*, a machine, a ball, and (for judging shapes) the part as it lies in work coordinates;
//! out comes a [`DryRun`] with figures and a verdict, all units in the names. Never knows how the paths were made: nothing of
//! features, passes or posts; the text is read by `gcode` as the machine will read it.
//!
//! ```text
//! text -> shape    the events from unknown places  -> limits     does it fit the machine
//!                                                  -> way        moves of the ball's centre
//!                                                  -> material   cut, in program order: cusps, uncut ground, rapids into stock
//!                                                  -> gouge      every centre against the part itself
//!      -> timing   the events from the controller's zero          minutes, by the planner; bytes, by the link
//!      => verdict
//! ```
//!
//! Both passes read the program event by event and hold none of it; only with a part its moves are kept.

mod depth;
pub mod driven;
pub mod dry_run;
mod gouge;
mod judge;
mod limits;
mod material;
mod missing;
mod moves;
mod program;
pub mod report;
mod shape;
mod start;
mod timing;
mod way;

pub use driven::{DrivenMove, Rehearsal, judge_driven};
pub use dry_run::{DryRunOptions, PartContext, Stock, dry_run, dry_run_of, judging_step};
pub use program::Open;
pub use report::{
    DryRun, Extents, Kind, MotionFigures, Problem, ProgramFigures, TimeFigures, Verdict,
};
