//! A front for the simulated controller: a real pseudo-terminal that programs open like any serial device.
//!
//! Opening it resets the controller, as opening the port of an Arduino does. One thread turns the controller's clock, in one of two
//! ways ([`Pace`]): in step with real time, or as fast as the host keeps up. In the second, machine time passes only while the
//! host cannot do anything about it: a line waits for the axes, so the host waits for its answer. When the controller could read a
//! line and none is there, the host gets its turn first, and machine time goes on only once the cable has been quiet for a while
//! (the host is then waiting for standstill, not computing the next line). So a slow host does not starve the planner, and the machine
//! time measured is that of the job, not of this computer.

use super::Controller;
use serialport::{SerialPort as _, TTYPort};
use std::io::{ErrorKind, Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How machine time passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// So many times real time, above zero; 1 is the real thing.
    Times(f64),
    /// As fast as the host keeps up.
    Unbound,
}

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

/// What the controller's own clock says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readout {
    /// Machine time from the first motion to the last standstill, s.
    pub elapsed_s: f64,
    /// Machine position, mm.
    pub position: [f64; 3],
    /// The axes move.
    pub moving: bool,
    /// Bytes lost because the host sent more than the receive buffer holds. Zero with a sound sender.
    pub bytes_lost: usize,
}

/// A running front. Dropping it switches the controller off.
pub struct Pty {
    path: String,
    stop: Arc<AtomicBool>,
    readout: Arc<Mutex<Readout>>,
    thread: Option<JoinHandle<()>>,
}

/// Quiet on the cable that counts as "the host waits for the machine". Long, because a host on a busy computer may pause in the
/// middle of a job, and time that passes then would starve the planner; a sender that streams never gets here.
const QUIET: Duration = Duration::from_millis(400);
/// Machine time that passes per look at the cable while it is quiet, s: a hundred times real time at one look a millisecond.
const QUIET_SLICE: f64 = 0.1;
/// Machine time between looks at the cable while a line waits, s.
const BUSY_SLICE: f64 = 0.05;
/// Largest piece written at once: a pseudo-terminal without a reader takes a few KiB, then a write would hang.
const PIECE: usize = 256;
/// Bytes kept for a reader that does not read; older ones are dropped, as on a cable nobody listens to.
const BACKLOG: usize = 64 * 1024;

impl Pty {
    /// Switches a controller on behind a new pseudo-terminal.
    ///
    /// # Errors
    /// No pseudo-terminal, or no thread.
    pub fn start(controller: Controller, pace: Pace) -> Result<Pty, PtyError> {
        let unavailable = |e: serialport::Error| PtyError::Unavailable(e.to_string());
        let (mut near, far) = TTYPort::pair().map_err(unavailable)?;
        let path = far
            .name()
            .ok_or_else(|| PtyError::Unavailable("it has no name".to_string()))?;
        near.set_timeout(Duration::from_millis(1))
            .map_err(unavailable)?;
        // The far side must be closed here, or the program that opens it by its path would not be its only user.
        drop(far);
        let stop = Arc::new(AtomicBool::new(false));
        let readout = Arc::new(Mutex::new(Readout::default()));
        let mut front = Front {
            near,
            controller,
            pace,
            stop: stop.clone(),
            readout: readout.clone(),
            out: Vec::new(),
            open: false,
        };
        let thread = std::thread::Builder::new()
            .name("controller".to_string())
            .spawn(move || front.run())
            .map_err(PtyError::Thread)?;
        Ok(Pty {
            path,
            stop,
            readout,
            thread: Some(thread),
        })
    }

    /// What to open, e.g. `/dev/pts/5`.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The controller's own figures now.
    pub fn readout(&self) -> Readout {
        *self.readout.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let Some(thread) = self.thread.take() else {
            return;
        };
        // A write to a pseudo-terminal nobody reads can hang in the kernel; such a thread is left behind rather than waited for.
        for _ in 0..100 {
            if thread.is_finished() {
                // A panic in there was printed by the thread itself; there is nothing left to do about it here.
                let _ = thread.join();
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

struct Front {
    near: TTYPort,
    controller: Controller,
    pace: Pace,
    stop: Arc<AtomicBool>,
    readout: Arc<Mutex<Readout>>,
    out: Vec<u8>,
    open: bool,
}

enum Heard {
    Bytes(usize),
    Nothing,
    /// Nobody has the far side open.
    Nobody,
}

impl Front {
    fn run(&mut self) {
        let mut buffer = [0u8; PIECE];
        let mut last = Instant::now();
        let mut quiet_since = last;
        while !self.stop.load(Ordering::Relaxed) {
            let heard = self.hear(&mut buffer);
            let now = Instant::now();
            let real = now.duration_since(last).as_secs_f64();
            last = now;
            match heard {
                Heard::Bytes(n) => {
                    quiet_since = now;
                    self.opened();
                    self.controller.feed(buffer.get(..n).unwrap_or_default());
                }
                Heard::Nothing => self.opened(),
                Heard::Nobody => {
                    self.open = false;
                    std::thread::sleep(Duration::from_millis(2));
                }
            }
            match self.pace {
                Pace::Times(factor) => self.controller.advance(real * factor),
                Pace::Unbound => self.hurry(now.duration_since(quiet_since), real),
            }
            self.tell();
            self.speak();
        }
    }

    fn hear(&mut self, buffer: &mut [u8]) -> Heard {
        // While a line waits for the axes, nothing the host may say is needed before time goes on.
        let no_need = self.pace == Pace::Unbound && self.controller.is_busy();
        let patience = Duration::from_millis(if no_need { 0 } else { 1 });
        // Only a field of the port; it cannot fail.
        let _ = self.near.set_timeout(patience);
        match self.near.read(buffer) {
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

    /// Somebody has opened the far side: the controller restarts, as hardware does on DTR.
    fn opened(&mut self) {
        if !self.open {
            self.open = true;
            self.controller.power_cycle();
            self.out.clear();
        }
    }

    /// Lets machine time pass as far as the host has no say in it.
    fn hurry(&mut self, quiet: Duration, real: f64) {
        if self.controller.is_busy() {
            // Step by step until an answer comes out: with it the host has its turn.
            let end = self.controller.now() + BUSY_SLICE;
            // (A slice of machine time holds a few hundred changes at most; the bound only keeps the cable looked at.)
            for _ in 0..1000 {
                match self.controller.next_change() {
                    Some(at)
                        if at <= end
                            && self.controller.is_busy()
                            && !self.controller.has_output() =>
                    {
                        self.controller.advance(at - self.controller.now());
                    }
                    _ => break,
                }
            }
            if !self.controller.has_output() && self.controller.is_busy() {
                self.controller
                    .advance((end - self.controller.now()).max(0.0));
            }
        } else if self.controller.is_moving() || self.controller.next_change().is_some() {
            if quiet > QUIET {
                self.controller.advance(QUIET_SLICE);
            }
        } else {
            self.controller.advance(real);
        }
    }

    fn tell(&mut self) {
        let p = self.controller.position();
        let readout = Readout {
            elapsed_s: self.controller.elapsed(),
            position: [p.x, p.y, p.z],
            moving: self.controller.is_moving(),
            bytes_lost: self.controller.bytes_lost(),
        };
        *self.readout.lock().unwrap_or_else(PoisonError::into_inner) = readout;
    }

    fn speak(&mut self) {
        self.out.extend(self.controller.output());
        if !self.open {
            self.out.clear();
        }
        if self.out.len() > BACKLOG {
            self.out.drain(..self.out.len() - BACKLOG);
        }
        while !self.out.is_empty() {
            let piece = self.out.get(..PIECE).unwrap_or(&self.out);
            match self.near.write(piece) {
                Ok(n) => _ = self.out.drain(..n.min(self.out.len())),
                Err(_) => return,
            }
        }
    }
}
