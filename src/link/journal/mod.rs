//! The job journal: what was sent, answered and seen, so that a broken job can be taken up again ([`super::resume`]).
//!
//! Crosses the border: [`Record`]s and the time since the job began in, bytes of the journal out ([`Writer`]); such bytes in, what
//! they tell out ([`History`]). Lines are lines of the program's text, from 1 (0: none), and ranges are told by their last line.
//! Places are machine coordinates, mm. No clock: time is given. Only [`JournalFile`] touches the disk.
//!
//! One record is one line, readable by eye, and each line proves itself:
//!
//! ```text
//! 17 5f3a0c9e {"t":12.304,"event":"sent","line":412}
//!  |     |     `-- what, and seconds since the job began
//!  |     `-------- CRC-32 of number and JSON
//!  `-------------- its number, from 0, without gaps
//! ```
//!
//! # What survives what
//!
//! ```text
//!  record made -> [Writer, at most 100 ms] -> operating system -> [disk, about 1 s] -> platters
//!                  dies with the process       dies with the host
//! ```
//! *Allow* records are written ahead: a line's bytes go out only after the record that allows it has gone to the operating system. So
//! after `kill -9` no line can have been sent that the journal does not allow. The disk is asked to keep what it has about once a
//! second ([`JournalFile`]); after a power cut of the host, lines of that gap may have been sent and yet be missing, and the zones
//! of a resume grow by it.

mod allowance;
mod file;
mod history;
mod keeper;
mod line;
mod reader;
mod record;
mod writer;

pub use allowance::Allowance;
pub use file::{JournalFile, SYNC_GAP};
pub use history::{Doubt, History, Sighting};
pub use keeper::{Keeper, Turn};
pub use reader::{Damage, read};
pub use record::{
    Begin, FORMAT, Offsets, Record, Resumed, Stamped, Start, ToolChange, fingerprint,
};
pub use writer::{FLUSH_WITHIN, Writer};
