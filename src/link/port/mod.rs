//! Byte pipes to a controller: serial devices and TCP, both behind [`Port`]; which ports this computer has, and what answers there.
//!
//! Crosses the border: bytes, and the words of the system when a pipe breaks. No line, no state and no meaning of a byte is known here
//! ([`inquiry`] alone asks one gentle question, as a value without I/O). It must never know the simulated controller.
//!
//! ```text
//! /dev/ttyUSB0      -> serial     8N1, no flow control; opening it restarts most Arduino-class boards
//! tcp://HOST:PORT   -> tcp        grblHAL, FluidNC, ser2net, `morsemill controller --tcp`
//! boards, list      which USB chips sit on such boards, and which of this computer's ports have one
//! ```
//! A write to a device nobody reads can hang in the kernel for ever, so nothing here writes more than a caller counted as
//! fitting; the session never has more than one receive buffer plus a few real-time bytes under way.

pub mod boards;
pub mod inquiry;
pub mod list;
pub mod serial;
pub mod tcp;

pub use boards::{Board, board};
pub use list::{PortEntry, list};
pub use serial::SerialPort;
pub use tcp::TcpPort;

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

/// Most bytes one write may have: more than any session sends at once, far less than any kernel buffer holds.
const WRITE_LIMIT: usize = 1024;
/// Times a write that takes nothing is tried again.
const PATIENCE: u32 = 50;
/// How long one look at a port opened by [`open`] waits. Short, so that commands and polls are prompt; bytes end it at once anyway.
pub const LOOK: Duration = Duration::from_millis(10);
/// What a TCP port's name begins with.
pub const TCP: &str = "tcp://";

/// Why a port failed.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// It could not be opened.
    #[error("{path}: cannot open the port: {why}. {advice}")]
    Open {
        /// Device path, or `tcp://HOST:PORT`.
        path: String,
        /// The system's words.
        why: String,
        /// What to do next.
        advice: &'static str,
    },
    /// The far side is gone.
    #[error("{path}: the port is gone: check the cable and the controller's power")]
    Gone {
        /// Device path.
        path: String,
    },
    /// A read or write failed for another reason.
    #[error("{path}: {doing} failed: {why}")]
    Failed {
        /// Device path.
        path: String,
        /// `reading` or `writing`.
        doing: &'static str,
        /// The system's words.
        why: String,
    },
    /// The device accepts no bytes although they should fit.
    #[error("{path}: the device takes no bytes: unplug and replug the controller")]
    Stuck {
        /// Device path.
        path: String,
    },
}

/// A byte pipe to a controller.
pub trait Port {
    /// Reads what has arrived; 0 when nothing did within the port's own short timeout.
    ///
    /// # Errors
    /// The pipe broke.
    fn read(&mut self, into: &mut [u8]) -> Result<usize, PortError>;

    /// Writes all of a few bytes.
    ///
    /// # Errors
    /// The pipe broke or takes nothing more.
    fn write(&mut self, bytes: &[u8]) -> Result<(), PortError>;
}

impl Port for Box<dyn Port> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, PortError> {
        (**self).read(into)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        (**self).write(bytes)
    }
}

/// Opens what `--port` names: `tcp://HOST:PORT`, or the path of a serial device at `baud`. One look at it waits [`LOOK`].
///
/// # Errors
/// Missing, busy, refused, not permitted, or no such name.
pub fn open(spec: &str, baud: u32) -> Result<Box<dyn Port>, PortError> {
    // `TCP://` is meant the same; a device is never called so.
    let is_tcp = spec
        .get(..TCP.len())
        .is_some_and(|s| s.eq_ignore_ascii_case(TCP));
    Ok(if is_tcp {
        Box::new(TcpPort::open(spec, LOOK)?)
    } else {
        Box::new(SerialPort::open(spec, baud, LOOK)?)
    })
}

/// True for what a read or write says when it merely has to be tried again.
fn is_pause(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
    )
}

/// A failed read or write in our words.
fn broken(path: &str, doing: &'static str, e: &std::io::Error) -> PortError {
    let path = path.to_string();
    match e.kind() {
        ErrorKind::BrokenPipe
        | ErrorKind::NotConnected
        | ErrorKind::ConnectionReset
        | ErrorKind::ConnectionAborted
        | ErrorKind::UnexpectedEof => PortError::Gone { path },
        _ => PortError::Failed {
            path,
            doing,
            why: e.to_string(),
        },
    }
}

/// One look at a pipe whose reads time out by themselves.
fn read_some(pipe: &mut impl Read, path: &str, into: &mut [u8]) -> Result<usize, PortError> {
    if into.is_empty() {
        return Ok(0);
    }
    match pipe.read(into) {
        Ok(0) => Err(PortError::Gone {
            path: path.to_string(),
        }),
        Ok(n) => Ok(n),
        Err(e) if is_pause(e.kind()) => Ok(0),
        Err(e) => Err(broken(path, "reading", &e)),
    }
}

/// Writes all to a pipe whose writes time out by themselves, in small pieces.
fn write_all(pipe: &mut impl Write, path: &str, bytes: &[u8]) -> Result<(), PortError> {
    let mut rest = bytes;
    let mut patience = PATIENCE;
    while !rest.is_empty() {
        let chunk = rest.get(..WRITE_LIMIT).unwrap_or(rest);
        match pipe.write(chunk) {
            Ok(n) => rest = rest.get(n..).unwrap_or_default(),
            Err(e) if is_pause(e.kind()) && patience > 0 => patience -= 1,
            Err(e) if is_pause(e.kind()) => {
                return Err(PortError::Stuck {
                    path: path.to_string(),
                });
            }
            Err(e) => return Err(broken(path, "writing", &e)),
        }
    }
    Ok(())
}
