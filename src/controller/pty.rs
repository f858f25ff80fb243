//! A front for the simulated controller: a real pseudo-terminal that programs open like any serial device.
//!
//! Raw, without echo; any baud rate is taken and means nothing. What opening it does is up to [`Opening`]; as on a serial device it is
//! the first opening that counts, and closing it leaves the controller to what it was doing. The kernel lets one program at a time have
//! it if that program asks for it (`TIOCEXCL` or `flock`, as most senders do).
//!
//! What a pseudo-terminal does not have: modem lines. A program that moves DTR or RTS of an open port is told by the kernel that there
//! are none (`ENOTTY`), whoever is at the other end.

use super::front::{Front, Heard, News, Opening, Pace, Pipe, Readout};
use super::{Controller, Rig};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::OpenptFlags;
use rustix::termios::{OptionalActions, QueueSelector};
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::OwnedFd;
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
    /// Switches a controller on behind a new pseudo-terminal; opening it restarts the controller, which greets at once.
    ///
    /// # Errors
    /// No pseudo-terminal, or no thread.
    pub fn start(controller: Controller, pace: Pace) -> Result<Pty, PtyError> {
        let opening = Opening::Restarts(Duration::ZERO);
        Pty::serve(Rig::from(controller), opening, pace, None)
    }

    /// Serves a rig on a new pseudo-terminal; `news` is told what happens.
    ///
    /// # Errors
    /// No pseudo-terminal, or no thread.
    pub fn serve(
        rig: Rig,
        opening: Opening,
        pace: Pace,
        news: Option<Sender<News>>,
    ) -> Result<Pty, PtyError> {
        let (near, path) = Near::open(opening).map_err(|e| PtyError::Unavailable(e.to_string()))?;
        let front = Front::start(rig, near, pace, news).map_err(PtyError::Thread)?;
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

/// How long one look at a far end without a host is where openings are not told.
const UNTOLD: Duration = Duration::from_millis(2);

/// The near end. Never blocks: a device nobody reads takes some KiB, and no more.
struct Near {
    device: File,
    doorman: Option<doorman::Doorman>,
    opening: Opening,
    /// Nobody had the far end open at the last look.
    gone: bool,
}

impl Near {
    /// A new pseudo-terminal: its near end, and the path of the far one.
    fn open(opening: Opening) -> rustix::io::Result<(Near, String)> {
        let near = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        rustix::pty::grantpt(&near)?;
        rustix::pty::unlockpt(&near)?;
        let path = rustix::pty::ptsname(&near, Vec::new())?;
        let path = path.to_string_lossy().into_owned();
        // The far side is set up and closed again before anybody looks for openings.
        let far: OwnedFd = rustix::fs::open(
            path.as_str(),
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC,
            Mode::empty(),
        )?;
        let mut modes = rustix::termios::tcgetattr(&far)?;
        modes.make_raw();
        rustix::termios::tcsetattr(&far, OptionalActions::Now, &modes)?;
        drop(far);
        rustix::io::fcntl_setfd(&near, rustix::io::FdFlags::CLOEXEC)?;
        let flags = rustix::fs::fcntl_getfl(&near)?;
        rustix::fs::fcntl_setfl(&near, flags | OFlags::NONBLOCK)?;
        let near = Near {
            device: File::from(near),
            doorman: doorman::Doorman::at(&path),
            opening,
            gone: true,
        };
        Ok((near, path))
    }

    /// Waits until there is something to hear, or somebody comes or goes.
    fn wait(&self, patience: Duration) {
        // More than a thousand seconds is never asked for.
        let timeout = Timespec {
            tv_sec: patience.as_secs().min(1000).cast_signed(),
            tv_nsec: patience.subsec_nanos().into(),
        };
        let device = PollFd::new(&self.device, PollFlags::IN);
        // A signal may end it early: the next look follows at once.
        let _ = match &self.doorman {
            // Without a host the device would say so again and again instead of waiting.
            Some(d) if self.gone => poll(&mut [d.told()], Some(&timeout)),
            Some(d) => poll(&mut [device, d.told()], Some(&timeout)),
            None if self.gone => return std::thread::sleep(patience.min(UNTOLD)),
            None => poll(&mut [device], Some(&timeout)),
        };
    }
}

impl Pipe for Near {
    fn hear(&mut self, into: &mut [u8], patience: Duration) -> Heard {
        if !patience.is_zero() {
            self.wait(patience);
        }
        let heard = match self.device.read(into) {
            _ if into.is_empty() => Some(0),
            Ok(0) => None,
            Ok(n) => Some(n),
            Err(e) if super::front::is_pause(&e) => Some(0),
            // The far end is closed (EIO), and all that was said there has been read.
            Err(_) => None,
        };
        // Bytes are read before the openings are looked at: those of a host that has just come are then never taken for its forerunner's.
        let opened = self
            .doorman
            .as_mut()
            .is_some_and(|d| d.look(heard.is_none()));
        self.gone = heard.is_none() && !opened;
        match heard {
            _ if opened => Heard::Opened(heard.unwrap_or(0)),
            None => Heard::Nobody,
            Some(0) => Heard::Nothing,
            Some(n) => Heard::Bytes(n),
        }
    }

    fn tell(&mut self, bytes: &[u8]) -> usize {
        self.device.write(bytes).unwrap_or(0)
    }

    fn forget(&mut self) {
        // What the host that left has not read is not for the next one.
        let _ = rustix::termios::tcflush(&self.device, QueueSelector::OFlush);
    }

    fn opening(&self) -> Opening {
        self.opening
    }
}

/// Who tells of openings, so that none is missed however soon after a closing it comes.
#[cfg(target_os = "linux")]
mod doorman {
    use rustix::event::{PollFd, PollFlags};
    use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};
    use std::mem::MaybeUninit;
    use std::os::fd::OwnedFd;

    pub(super) struct Doorman {
        events: OwnedFd,
        /// Openings of the far end less closings. The system merges equal events in a row, so this may be off; the device's own word
        /// that nobody is there sets it right.
        inside: usize,
    }

    impl Doorman {
        /// `None` where the system does not tell: the far end is then looked at every few milliseconds.
        pub fn at(path: &str) -> Option<Doorman> {
            let events = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).ok()?;
            let what = WatchFlags::OPEN | WatchFlags::CLOSE_WRITE | WatchFlags::CLOSE_NOWRITE;
            inotify::add_watch(&events, path, what).ok()?;
            Some(Doorman { events, inside: 0 })
        }

        /// What wakes when somebody comes or goes.
        pub fn told(&self) -> PollFd<'_> {
            PollFd::new(&self.events, PollFlags::IN)
        }

        /// Takes notice of all who came and went; true when somebody came while nobody was there. `nobody`: the device said so just
        /// before.
        pub fn look(&mut self, nobody: bool) -> bool {
            let (mut opened, mut quiet) = (false, true);
            let mut room = [MaybeUninit::uninit(); 1024];
            let mut reader = inotify::Reader::new(&self.events, &mut room);
            while let Ok(event) = reader.next() {
                quiet = false;
                if event.events().contains(ReadFlags::OPEN) {
                    opened |= self.inside == 0;
                    self.inside += 1;
                } else {
                    self.inside = self.inside.saturating_sub(1);
                }
            }
            if quiet {
                self.inside = if nobody { 0 } else { self.inside.max(1) };
            }
            opened
        }
    }
}

/// Other systems do not tell of openings; they are seen by looking.
#[cfg(not(target_os = "linux"))]
mod doorman {
    use rustix::event::PollFd;

    /// Never there.
    pub(super) enum Doorman {}

    impl Doorman {
        pub fn at(_: &str) -> Option<Doorman> {
            None
        }

        pub fn told(&self) -> PollFd<'_> {
            match *self {}
        }

        pub fn look(&mut self, _: bool) -> bool {
            match *self {}
        }
    }
}
