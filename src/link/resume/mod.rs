//! Taking up a broken job: what is cut, where to enter again, and the lines that do it.
//!
//! Crosses the border: a journal's [`History`], the program's text, and what the controller says [`Now`] in; a [`Plan`] or a
//! [`Refusal`] out. Lines count from 1 in the program's text; lengths mm. The same interpreter as everywhere reads the program, so the
//! state at the entry is that of the straight run, and [`prove`] reads the resumed program again and compares. No I/O, no clock; it
//! never sends anything.
//!
//! # Three zones
//!
//! ```text
//!   1 ...................................... A ......... S ....... W ............. lines
//!   |     surely cut      |      maybe cut                         |   not sent  |
//!   |                     |<- planner ->|<- receive buffer ->|<-gap->|
//!                      first            A                    S      last
//!
//!   A  last line answered, by the journal. Answered means read and queued, so what was queued last may not have been cut: walk back from
//!      A over as many planner blocks as the controller can hold and has not run (look-ahead and the slices prepared for the axes), but
//!      never beyond a command that was answered only after all motion had ended.
//!   S  last line sent, when the sender ended in order: the upper bound.
//!   W  last line allowed, when it did not: a line goes out only after the journal has said so (write-ahead). After a power cut of the
//!      computer, which the journal can tell from a crash by the computer's boot, also what the link carries while the disk is behind.
//! ```
//! Lines that queue nothing for certain (modes, moves below a step) take no room in the planner, so they are never counted; arcs count as
//! their chords. The line in which the tool stood still lies in the middle zone, always.
//!
//! # The way in
//!
//! ```text
//!      safe Z  ------------>.            1 lift straight up       4 plunge at feed to the depth of the entry
//!         ^       XY        | plunge     2 over the entry point   5 all modes of the program
//!         |                 v            3 spindle, wait, coolant 6 the program, from the line that starts here
//!  ~~~~~~~T~~~~~~~~~~~~~~~~~E~~~~~~~     E: the start of a motion, `overlap` of cut path before the middle zone
//! ```

mod blocks;
mod check;
mod entry;
mod head;
mod plan;
mod prove;
mod refusal;
mod survey;
mod text;
mod walk;
mod words;
mod zones;

pub use check::{Evidence, Now, Trust};
pub use entry::{Entry, Overlap};
pub use head::HeadOptions;
pub use plan::{LineMap, Plan, ResumeOptions, from_line, resume};
pub use prove::{Proof, prove};
pub use refusal::Refusal;
pub use text::ProgramText;
pub use walk::{Program, Walk};
pub use zones::{Zones, may_lack_the_last, zones};
