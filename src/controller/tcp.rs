//! A front for the simulated controller: a TCP socket, as boards with a network have (grblHAL, FluidNC) and serial servers (ser2net).
//!
//! It listens on loopback only, unless the caller says that strangers may come. One host at a time: a second one is told so in a
//! `[MSG:...]` line and shown out, and neither hears nor says anything else. Connecting does not restart the controller, and leaving does
//! not stop it: whoever comes next finds it as it is. The first host hears the greeting of its start.

use super::Rig;
use super::front::{Front, Heard, News, Pace, Pipe, Readout};
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::mpsc::Sender;
use std::time::Duration;

/// Why it does not listen.
#[derive(Debug, thiserror::Error)]
pub enum TcpError {
    /// Not an address.
    #[error(
        "--tcp {0}: write ADDRESS:PORT, e.g. 127.0.0.1:2323, or 127.0.0.1:0 for any free port ({1})"
    )]
    Address(String, String),
    /// Others could reach it.
    #[error(
        "--tcp {0}: anybody in the network could drive this controller there: listen on 127.0.0.1, or add --allow-remote if that is what you want"
    )]
    Remote(String),
    /// The system refused.
    #[error(
        "--tcp {0}: cannot listen: {1}. Is another program using that port? Port 0 takes any free one"
    )]
    Listen(String, std::io::Error),
    /// No thread could be started.
    #[error("the simulated controller's thread did not start: {0}")]
    Thread(std::io::Error),
}

/// A controller behind a socket. Dropping it switches the controller off.
pub struct Tcp {
    address: SocketAddr,
    front: Front,
}

/// Who may come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Guests {
    /// Programs of this computer.
    #[default]
    Local,
    /// Anybody who finds the address.
    Remote,
}

impl Tcp {
    /// Serves a rig on `address` (`ADDRESS:PORT`; port 0 is any free one); `news` is told what happens.
    ///
    /// # Errors
    /// Not an address, one that others could reach, in use, or no thread.
    pub fn serve(
        rig: Rig,
        address: &str,
        guests: Guests,
        pace: Pace,
        news: Option<Sender<News>>,
    ) -> Result<Tcp, TcpError> {
        let no_address = |why: String| TcpError::Address(address.to_string(), why);
        let places: Vec<SocketAddr> = address
            .to_socket_addrs()
            .map_err(|e| no_address(e.to_string()))?
            .collect();
        let place = *places
            .first()
            .ok_or_else(|| no_address("there is no such place".to_string()))?;
        if guests == Guests::Local && !places.iter().all(|p| p.ip().is_loopback()) {
            return Err(TcpError::Remote(address.to_string()));
        }
        let listen = |e| TcpError::Listen(address.to_string(), e);
        let listener = TcpListener::bind(place).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let pipe = Door {
            listener,
            guest: None,
        };
        let front = Front::start(rig, pipe, pace, news).map_err(TcpError::Thread)?;
        Ok(Tcp { address, front })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
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

/// How long a write may hold the loop up.
const WRITE: Duration = Duration::from_millis(1);

struct Guest {
    stream: TcpStream,
    from: SocketAddr,
}

/// The socket and the one host that is in.
struct Door {
    listener: TcpListener,
    guest: Option<Guest>,
}

impl Door {
    /// Lets the first in and shows all others out. A handful at a time: a crowd at the door must not stop the clock.
    fn answer(&mut self) {
        for _ in 0..4 {
            let Ok((stream, from)) = self.listener.accept() else {
                return;
            };
            match &self.guest {
                None => {
                    // Some systems hand the listener's own non-blocking mode on.
                    let ready = stream
                        .set_nonblocking(false)
                        .and_then(|()| stream.set_nodelay(true))
                        .and_then(|()| stream.set_write_timeout(Some(WRITE)));
                    self.guest = ready.is_ok().then_some(Guest { stream, from });
                }
                Some(first) => {
                    let line = format!(
                        "[MSG:Busy: {} is connected, and one program at a time may be. Close it first]\r\n",
                        first.from
                    );
                    // A few bytes into an empty buffer; whoever does not take them is shown out all the same.
                    let _ = stream.set_nonblocking(true);
                    let _ = (&stream).write(line.as_bytes());
                    let _ = stream.shutdown(std::net::Shutdown::Write);
                }
            }
        }
    }
}

/// Nothing is wrong, there is just nothing to be had now.
fn is_pause(e: &std::io::Error) -> bool {
    matches!(
        e.kind(),
        ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
    )
}

impl Pipe for Door {
    fn hear(&mut self, into: &mut [u8], patience: Duration) -> Heard {
        self.answer();
        let Some(guest) = &mut self.guest else {
            return Heard::Nobody;
        };
        // A timeout of zero would mean "for ever", so no waiting at all is another mode.
        let wait = !patience.is_zero();
        let set = guest.stream.set_nonblocking(!wait).and_then(|()| {
            if wait {
                guest.stream.set_read_timeout(Some(patience))
            } else {
                Ok(())
            }
        });
        let heard = match set.and_then(|()| guest.stream.read(into)) {
            Ok(n) if n > 0 => Heard::Bytes(n),
            Err(e) if is_pause(&e) => Heard::Nothing,
            // The end of the stream, or a broken one.
            Ok(_) | Err(_) => Heard::Nobody,
        };
        if heard == Heard::Nobody {
            self.guest = None;
        }
        heard
    }

    fn tell(&mut self, bytes: &[u8]) -> usize {
        let Some(guest) = &mut self.guest else {
            return 0;
        };
        match guest.stream.write(bytes) {
            Ok(n) => n,
            Err(e) if is_pause(&e) => 0,
            Err(_) => {
                self.guest = None;
                0
            }
        }
    }

    fn opening_restarts(&self) -> bool {
        false
    }
}
