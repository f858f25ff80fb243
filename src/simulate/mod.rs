//! The dry run: what the machine will do with this text, and whether that is good.
//!
//! Crosses the border: a program's *text*, a machine, a ball, and (for judging shapes) the part as it lies in work coordinates;
//! out comes a [`DryRun`] with figures and a verdict, all units in the names. Never knows how the paths were made: nothing of
//! features, passes or posts; the text is read by `gcode` as the machine will read it.
//!
//! ```text
//! text -> events -> limits     does it fit the machine
//!               -> material    cut, in program order: cusps, uncut ground, rapids into stock
//!               -> gouge       every centre against the part itself
//!               -> clock       minutes, by the planner
//!               => verdict
//! ```

mod depth;
pub mod driven;
pub mod dry_run;
mod gouge;
mod limits;
mod material;
pub mod report;
mod start;

pub use driven::{DrivenMove, Rehearsal, judge_driven};
pub use dry_run::{DryRunOptions, PartContext, Stock, dry_run, judging_step};
pub use report::{
    DryRun, Extents, Kind, MotionFigures, Problem, ProgramFigures, TimeFigures, Verdict,
};
