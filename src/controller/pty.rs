//! A front for the simulated controller: a real pseudo-terminal that programs open like any serial device.
//!
//! Raw, without echo; any baud rate is taken and means nothing. Opening it restarts the controller, as opening the port of an Arduino
//! does (DTR), unless it is opened again within the few milliseconds in which the closing is not seen; closing it leaves the controller to what it was doing. The kernel lets one program at a time have it if that program asks
//! for it (`TIOCEXCL`, as most senders do).

use super::front::{Front, Heard, News, Pace, Pipe, Readout};
use super::{Controller, Rig};
use serialport::{SerialPort as _, TTYPort};
use std::io::{ErrorKind, Read as _, Write as _};
use std::sync::mpsc::Sender;
use std::time::Duration;

/// Why there is no pseudo-terminal.
#[derive(Debug, thiserror::Error)]
pub enum PtyError {
    /// The system gave none.
    #[error(
        "no pseudo-terminal for the simulated controller: {0}. Use a system that has them (Linux, macOS)"
    )]
    Unavailable(String),
    /// No thread could be started.
    #[error("the simulated controller's thread did not start: {0}")]
    Thread(std::io::Error),
}

/// A controller behind a pseudo-terminal. Dropping it switches the controller off.
pub struct Pty {
    path: String,
    front: Front,
}

impl Pty {
    /// Switches a controller on behind a new pseudo-terminal.
    ///
    /// # Errors
    /// No pseudo-terminal, or no thread.
    pub fn start(controller: Controller, pace: Pace) -> Result<Pty, PtyError> {
        Pty::serve(Rig::from(controller), pace, None)
    }

    /// Serves a rig on a new pseudo-terminal; `news` is told what happens.
    ///
    /// # Errors
    /// No pseudo-terminal, or no thread.
    pub fn serve(rig: Rig, pace: Pace, news: Option<Sender<News>>) -> Result<Pty, PtyError> {
        let unavailable = |e: serialport::Error| PtyError::Unavailable(e.to_string());
        let (near, far) = TTYPort::pair().map_err(unavailable)?;
        let path = far
            .name()
            .ok_or_else(|| PtyError::Unavailable("it has no name".to_string()))?;
        // The far side must be closed here, or the program that opens it by its path would not be its only user.
        drop(far);
        let front = Front::start(rig, Near(near), pace, news).map_err(PtyError::Thread)?;
        Ok(Pty { path, front })
    }

    /// What to open, e.g. `/dev/pts/5`.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The controller's own figures now.
    pub fn readout(&self) -> Readout {
        self.front.readout()
    }

    /// Switches the controller off and gives it back, if its thread still answers.
    pub fn stop(self) -> Option<Rig> {
        self.front.stop()
    }
}

/// The near end.
struct Near(TTYPort);

impl Pipe for Near {
    fn hear(&mut self, into: &mut [u8], patience: Duration) -> Heard {
        // Only a field of the port; it cannot fail.
        let _ = self.0.set_timeout(patience);
        match self.0.read(into) {
            Ok(0) => Heard::Nobody,
            Ok(n) => Heard::Bytes(n),
            Err(e)
                if matches!(
                    e.kind(),
                    ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
                ) =>
            {
                Heard::Nothing
            }
            Err(_) => Heard::Nobody,
        }
    }

    fn tell(&mut self, bytes: &[u8]) -> usize {
        let _ = self.0.set_timeout(Duration::from_millis(1));
        self.0.write(bytes).unwrap_or(0)
    }

    fn opening_restarts(&self) -> bool {
        true
    }
}
