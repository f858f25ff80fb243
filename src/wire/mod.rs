//! GRBL's conversation as data: what either side may say, and what it means in plain words.
//!
//! Crosses the border: one line of text (or one real-time byte) in, one value out, and back. Positions are in the unit the
//! controller reports in (mm, or inch with `$13=1`): only the caller has seen `$13`. No I/O, no clock, no kinematics, and no knowledge
//! of G-code but for the number of a complaint ([`complaint`]). Source of every fact: GRBL 1.1h's interface as documented and observed; other firmwares may say more,
//! so unknown lines and fields are kept or skipped and an unknown state means "not ready".

pub mod complaint;
pub mod firmware;
mod forks;
pub mod lines;
pub mod meaning;
pub mod modes;
pub mod realtime;
pub mod reply;
pub mod status;

pub use complaint::error_number;
pub use firmware::Firmware;
pub use lines::Lines;
pub use meaning::{Meaning, alarm_meaning, error_meaning};
pub use modes::Modes;
pub use realtime::Realtime;
pub use reply::{BuildOptions, Reply};
pub use status::{Buffer, DoorPhase, Overrides, Position, State, Status};

/// Bytes of receive buffer of a stock GRBL 1.1: the figure to assume when `[OPT:...]` names none.
pub const RX_BYTES: usize = 128;

/// Most significant characters one line may have (GRBL answers error 11 to the eightieth).
pub const LINE_CHARS: usize = 79;
