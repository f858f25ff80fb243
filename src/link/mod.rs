//! The host side of the cable: an introduction, a vetted job, the byte-counting streamer, the session around it, and the port.
//!
//! Crosses the border: program text in ([`job`], [`mod@vet`]), bytes to and from the controller in [`crate::wire`]'s words,
//! [`Command`]s in, [`Progress`] and one [`Outcome`] out. Positions are mm in the active work system unless said otherwise. All but
//! [`port`] and [`mod@drive`] are values fed with bytes and time: no I/O, no clock, no printing; [`port`] is the only place that
//! touches a device. It must never know the simulated controller: simulated and real hardware differ by nothing but the port.
//!
//! ```text
//! introduction -> Known -> vet -> Job -> session -> Outcome
//!   `?` `$I` `$$` `$#` `$G`   limits,      stream (counting, dangerous lines)
//!                             offsets      progress -> people, scripts, journal
//! ```

pub mod command;
pub mod drive;
pub mod errand;
pub mod introduction;
pub mod job;
pub mod journal;
pub mod outcome;
pub mod port;
pub mod progress;
pub mod resume;
pub mod session;
pub mod stream;
pub mod vet;
pub mod watch;

pub use command::{Command, RapidStep, Step};
pub use drive::{NotIntroduced, drive, introduce};
pub use introduction::{Introduction, IntroductionOptions, Known, Offsets, Unknown, WhenSilent};
pub use job::{Job, JobLine, JobLines, JobReader, JobSource, Standstill, Text, Unreadable, Weight};
pub use outcome::{Ending, Outcome};
pub use port::{Port, PortError, SerialPort};
pub use progress::{Progress, Prompt, PromptKind, Report, Span, Stall};
pub use session::{Session, SessionOptions};
pub use stream::{Flight, Receipt, Stream, StreamError, Waits};
pub use vet::{Caution, JobError, Limits, Refusal, VetOptions, Warning, vet};
