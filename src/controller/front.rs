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
    /// Somebody came who was not there at the last look. If somebody else was, these bytes are the last ones of that host, else the
    /// newcomer's first.
    Opened(usize),
}

/// What opening the far end does to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// It restarts, as most boards do (DTR), and greets so long after, real time: a program that opens a device clears its buffers next,
    /// and the greeting must not be in them. What is said meanwhile is heard afterwards.
    Restarts(Duration),
    /// It restarts by way of a boot loader that takes so long, real time, and eats what is said meanwhile, as an Arduino Uno does.
    BootLoader(Duration),
    /// Nothing, as with a board whose reset has no wire to DTR. What was said to nobody is not heard.
    Nothing,
}

/// The near end of a byte pipe that hosts come to and leave.
pub trait Pipe: Send {
    /// Looks for bytes for `patience` at most. With no room for any it only looks who is there.
    fn hear(&mut self, into: &mut [u8], patience: Duration) -> Heard;

    /// Writes what fits now; how many bytes that were.
    fn tell(&mut self, bytes: &[u8]) -> usize;

    /// The host has left: what it has not taken is not for the next one.
    fn forget(&mut self);

    /// What opening the far end does.
    fn opening(&self) -> Opening;
}

/// Nothing is wrong with a pipe, there is just nothing to be had now.
pub(super) fn is_pause(e: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(e.kind(), TimedOut | Interrupted | WouldBlock)
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
/// Largest piece read or written at once.
const PIECE: usize = 256;
/// Bytes kept for a reader that does not read; older ones are dropped, as on a cable nobody listens to.
const BACKLOG: usize = 64 * 1024;
/// How long one look waits for bytes when something is about to happen.
const LOOK: Duration = Duration::from_millis(1);
/// How long one look waits when nothing is. Bytes, comers and goers end it at once; only [`Front::stop`] has to wait for it.
const REST: Duration = Duration::from_millis(50);

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
            boot: None,
            quiet_since: Instant::now(),
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
        // A thread that hangs in the kernel is left behind rather than waited for.
        for _ in 0..200 {
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
    boot: Option<Boot>,
    quiet_since: Instant,
}

/// A controller that was restarted by an opening and does not run yet. Machine time stands still.
struct Boot {
    until: Instant,
    /// What is said meanwhile is heard afterwards.
    keeps: bool,
    early: Vec<u8>,
}

impl<P: Pipe> Server<P> {
    fn run(mut self) -> Rig {
        let mut buffer = [0u8; PIECE];
        let mut last = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            let patience = self.patience(last);
            // What the line cannot take waits at the host, as a slow serial line makes it wait.
            let room = if self.rig.is_choked() { 0 } else { PIECE };
            let into = buffer.get_mut(..room).unwrap_or_default();
            let heard = self.pipe.hear(into, patience);
            let now = Instant::now();
            let real = now.duration_since(last).as_secs_f64();
            last = now;
            // What has just arrived, arrived now and not when the clock was last turned.
            if let (Pace::Times(factor), None) = (self.pace, &self.boot) {
                self.rig.advance(real * factor);
            }
            let bytes = |n| buffer.get(..n).unwrap_or_default();
            match heard {
                Heard::Bytes(n) => {
                    self.came(now);
                    self.hear(bytes(n), now);
                }
                Heard::Opened(n) => {
                    // A forerunner's last words, or a newcomer's first ones.
                    let (old, new) = if self.open { (n, 0) } else { (0, n) };
                    self.hear(bytes(old), now);
                    self.left();
                    self.came(now);
                    self.hear(bytes(new), now);
                }
                Heard::Nothing => self.came(now),
                Heard::Nobody => self.left(),
            }
            self.boot_on(now);
            if self.pace == Pace::Unbound && self.boot.is_none() {
                self.hurry(now.duration_since(self.quiet_since), real);
            }
            self.report();
            self.speak();
        }
        self.rig
    }

    /// How long the next look at the pipe may wait.
    fn patience(&self, now: Instant) -> Duration {
        if let Some(boot) = &self.boot {
            return boot.until.saturating_duration_since(now).clamp(LOOK, REST);
        }
        if self.open && !self.out.is_empty() {
            return LOOK;
        }
        let next = self.rig.next_change();
        match self.pace {
            // While a line waits for the axes, nothing the host may say is needed before time goes on.
            Pace::Unbound if self.rig.is_busy() => Duration::ZERO,
            Pace::Unbound if next.is_some() || self.rig.is_moving() => LOOK,
            Pace::Unbound => REST,
            Pace::Times(factor) => next.map_or(REST, |at| {
                let soon =
                    ((at - self.rig.now()) / factor).clamp(LOOK.as_secs_f64(), REST.as_secs_f64());
                // (Not a number only if the factor was none.)
                Duration::try_from_secs_f64(soon).unwrap_or(LOOK)
            }),
        }
    }

    /// Bytes of the host.
    fn hear(&mut self, bytes: &[u8], now: Instant) {
        // A host that only asks how far it is has nothing to compute either: it waits.
        if bytes.iter().any(|&b| Realtime::from_byte(b).is_none()) {
            self.quiet_since = now;
        }
        match &mut self.boot {
            None => self.rig.feed(bytes),
            Some(boot) if boot.keeps && boot.early.len() < BACKLOG => {
                boot.early.extend_from_slice(bytes);
            }
            Some(_) => {}
        }
    }

    /// Somebody has opened the far end.
    fn came(&mut self, now: Instant) {
        if self.open {
            return;
        }
        self.open = true;
        let (keeps, time) = match self.pipe.opening() {
            Opening::Restarts(time) => (true, Some(time)),
            Opening::BootLoader(time) => (false, Some(time)),
            Opening::Nothing => (false, None),
        };
        if let Some(time) = time {
            // What it said before is not heard; what it says now is.
            self.rig.output();
            self.out.clear();
            self.rig.power_cycle();
            self.boot = Some(Boot {
                until: now + time,
                keeps,
                early: Vec::new(),
            });
        }
        self.ever_open = true;
        self.announce(News::Came);
    }

    fn left(&mut self) {
        if !self.open {
            return;
        }
        self.open = false;
        self.pipe.forget();
        let drive = self.rig.take_drive();
        self.announce(News::Left(drive));
    }

    /// Ends the boot when its time has come: now it hears, and is heard.
    fn boot_on(&mut self, now: Instant) {
        if let Some(boot) = self.boot.take_if(|b| b.until <= now) {
            self.rig.feed(&boot.early);
        }
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
        if self.boot.is_some() {
            return;
        }
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
