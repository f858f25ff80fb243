//! The serving loop of every front: a byte pipe on one side, a rig on the other, and a clock between them.
//!
//! One thread turns the rig's clock, in one of two ways ([`Pace`]): in step with real time, or as fast as the host keeps up. In the
//! second, machine time passes only while the host cannot do anything about it: a line waits for the axes, so the host waits for its
//! answer. When the controller could read a line and none is there, the host gets its turn first, and machine time goes on only once the
//! cable has been quiet for a while (the host is then waiting for standstill, not computing the next line). So a slow host does not
//! starve the planner, and the machine time measured is that of the job, not of this computer.
//!
//! Host gone, the controller goes on as the real one does: with what it has, at its pace, its answers unheard.

use super::rehearsal::Drive;
use super::{Memory, Rig};
use crate::wire::Realtime;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
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

/// What one look at a pipe brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// So many bytes.
    Bytes(usize),
    /// Somebody is there, and says nothing.
    Nothing,
    /// Nobody is there.
    Nobody,
}

/// The near end of a byte pipe that hosts come to and leave.
pub trait Pipe: Send {
    /// Looks for bytes for `patience` at most.
    fn hear(&mut self, into: &mut [u8], patience: Duration) -> Heard;

    /// Writes what fits now; how many bytes that were.
    fn tell(&mut self, bytes: &[u8]) -> usize;

    /// Opening the far end restarts the controller (DTR of a serial port does).
    fn opening_restarts(&self) -> bool;
}

/// What a front tells while it runs.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// A host has come.
    Came,
    /// The host has left; with the way driven since the last program's end, if one was recorded.
    Left(Drive),
    /// A program has ended (M2, M30), with the way driven for it.
    ProgramEnded(Drive),
    /// What survives a power cycle has changed.
    Stored(Box<Memory>),
}

/// Quiet on the cable that counts as "the host waits for the machine". Long, because a host on a busy computer may pause in the
/// middle of a job, and time that passes then would starve the planner; a sender that streams never gets here.
const QUIET: Duration = Duration::from_millis(400);
/// Machine time that passes per look at the cable while it is quiet, s: a hundred times real time at one look a millisecond.
const QUIET_SLICE: f64 = 0.1;
/// Machine time between looks at the cable while a line waits, s.
const BUSY_SLICE: f64 = 0.05;
/// Largest piece read or written at once: a pseudo-terminal without a reader takes a few KiB, then a write would hang.
pub(super) const PIECE: usize = 256;
/// Bytes kept for a reader that does not read; older ones are dropped, as on a cable nobody listens to.
const BACKLOG: usize = 64 * 1024;
/// How long one look waits for bytes.
const LOOK: Duration = Duration::from_millis(1);

/// A running front. Dropping it switches the controller off.
pub struct Front {
    stop: Arc<AtomicBool>,
    readout: Arc<Mutex<Readout>>,
    thread: Option<JoinHandle<Rig>>,
}

impl Front {
    /// Serves a rig on a pipe until it is stopped. `news` is told what happens, as long as anybody listens there.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(
        rig: Rig,
        pipe: impl Pipe + 'static,
        pace: Pace,
        news: Option<Sender<News>>,
    ) -> std::io::Result<Front> {
        let stop = Arc::new(AtomicBool::new(false));
        let readout = Arc::new(Mutex::new(Readout::default()));
        let server = Server {
            programs: rig.programs_ended(),
            stored: rig.memory(),
            rig,
            pipe,
            pace,
            stop: stop.clone(),
            readout: readout.clone(),
            out: Vec::new(),
            open: false,
            ever_open: false,
            news,
        };
        let thread = std::thread::Builder::new()
            .name("controller".to_string())
            .spawn(move || server.run())?;
        Ok(Front {
            stop,
            readout,
            thread: Some(thread),
        })
    }

    /// The controller's own figures now.
    pub fn readout(&self) -> Readout {
        *self.readout.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Switches the controller off and gives it back; `None` when its thread hangs in the kernel or died.
    pub fn stop(mut self) -> Option<Rig> {
        self.end()
    }

    fn end(&mut self) -> Option<Rig> {
        self.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take()?;
        // A write to a pseudo-terminal nobody reads can hang in the kernel; such a thread is left behind rather than waited for.
        for _ in 0..100 {
            if thread.is_finished() {
                // A panic in there was printed by the thread itself; there is nothing left to do about it here.
                return thread.join().ok();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        None
    }
}

impl Drop for Front {
    fn drop(&mut self) {
        self.end();
    }
}

/// The thread's side.
struct Server<P> {
    rig: Rig,
    pipe: P,
    pace: Pace,
    stop: Arc<AtomicBool>,
    readout: Arc<Mutex<Readout>>,
    out: Vec<u8>,
    open: bool,
    ever_open: bool,
    news: Option<Sender<News>>,
    programs: usize,
    stored: Memory,
}

impl<P: Pipe> Server<P> {
    fn run(mut self) -> Rig {
        let mut buffer = [0u8; PIECE];
        let mut last = Instant::now();
        let mut quiet_since = last;
        while !self.stop.load(Ordering::Relaxed) {
            // While a line waits for the axes, nothing the host may say is needed before time goes on.
            let no_need = self.pace == Pace::Unbound && self.rig.is_busy();
            let patience = if no_need { Duration::ZERO } else { LOOK };
            let heard = self.pipe.hear(&mut buffer, patience);
            let now = Instant::now();
            let real = now.duration_since(last).as_secs_f64();
            last = now;
            match heard {
                Heard::Bytes(n) => {
                    let bytes = buffer.get(..n).unwrap_or_default();
                    // A host that only asks how far it is has nothing to compute either: it waits.
                    if bytes.iter().any(|&b| Realtime::from_byte(b).is_none()) {
                        quiet_since = now;
                    }
                    self.came();
                    self.rig.feed(bytes);
                }
                Heard::Nothing => self.came(),
                Heard::Nobody => {
                    self.left();
                    std::thread::sleep(2 * LOOK);
                }
            }
            match self.pace {
                Pace::Times(factor) => self.rig.advance(real * factor),
                Pace::Unbound => self.hurry(now.duration_since(quiet_since), real),
            }
            self.report();
            self.speak();
        }
        self.rig
    }

    /// Somebody has opened the far end.
    fn came(&mut self) {
        if self.open {
            return;
        }
        self.open = true;
        if self.pipe.opening_restarts() {
            // What it said before is not heard; what it says now is.
            self.rig.output();
            self.out.clear();
            self.rig.power_cycle();
        }
        self.ever_open = true;
        self.announce(News::Came);
    }

    fn left(&mut self) {
        if !self.open {
            return;
        }
        self.open = false;
        let drive = self.rig.take_drive();
        self.announce(News::Left(drive));
    }

    /// Lets machine time pass as far as the host has no say in it.
    fn hurry(&mut self, quiet: Duration, real: f64) {
        let rig = &mut self.rig;
        if rig.is_busy() {
            // Step by step until an answer comes out: with it the host has its turn.
            let end = rig.now() + BUSY_SLICE;
            // (A slice of machine time holds a few hundred changes at most; the bound only keeps the cable looked at.)
            for _ in 0..1000 {
                match rig.next_change() {
                    Some(at) if at <= end && rig.is_busy() && !rig.has_output() => {
                        rig.advance(at - rig.now());
                    }
                    _ => break,
                }
            }
            if !rig.has_output() && rig.is_busy() {
                rig.advance((end - rig.now()).max(0.0));
            }
        } else if rig.is_moving() || rig.next_change().is_some() {
            if quiet > QUIET {
                rig.advance(QUIET_SLICE);
            }
        } else {
            rig.advance(real);
        }
    }

    fn report(&mut self) {
        let controller = self.rig.controller();
        let p = controller.position();
        let readout = Readout {
            elapsed_s: controller.elapsed(),
            position: [p.x, p.y, p.z],
            moving: controller.is_moving(),
            bytes_lost: controller.bytes_lost(),
        };
        *self.readout.lock().unwrap_or_else(PoisonError::into_inner) = readout;
        if self.rig.programs_ended() != self.programs {
            self.programs = self.rig.programs_ended();
            let drive = self.rig.take_drive();
            self.announce(News::ProgramEnded(drive));
        }
        let memory = self.rig.memory();
        if memory != self.stored {
            self.stored = memory.clone();
            self.announce(News::Stored(Box::new(memory)));
        }
    }

    fn announce(&mut self, news: News) {
        if let Some(sender) = &self.news
            && sender.send(news).is_err()
        {
            self.news = None;
        }
    }

    fn speak(&mut self) {
        self.out.extend(self.rig.output());
        // The first host hears how it was switched on; later ones do not hear what was said to nobody.
        if !self.open && self.ever_open {
            self.out.clear();
        }
        if self.out.len() > BACKLOG {
            self.out.drain(..self.out.len() - BACKLOG);
        }
        while self.open && !self.out.is_empty() {
            let piece = self.out.get(..PIECE).unwrap_or(&self.out);
            match self.pipe.tell(piece) {
                0 => return,
                n => _ = self.out.drain(..n.min(self.out.len())),
            }
        }
    }
}
