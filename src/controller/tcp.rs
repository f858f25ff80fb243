//! A front for the simulated controller: a TCP socket, as boards with a network have (grblHAL, FluidNC) and serial servers (ser2net).
//!
//! It listens on loopback only, unless the caller says that strangers may come. One host at a time: a second one is told so in a
//! `[MSG:...]` line and shown out, and neither hears nor says anything else. Connecting does not restart the controller, and leaving does
//! not stop it: whoever comes next finds it as it is. The first host hears the greeting of its start. What a telnet program says for
//! itself is taken out ([`super::telnet`]).

use super::Rig;
use super::front::{Front, Heard, News, Opening, Pace, Pipe, Readout, is_pause};
use super::telnet::Telnet;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt;
use std::io::{Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

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
            leaving: Vec::new(),
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

/// The one host that is in.
struct Guest {
    stream: TcpStream,
    from: SocketAddr,
    telnet: Telnet,
    /// Said to telnet's offers, not yet written.
    answer: Vec<u8>,
}

/// Bytes of answers to telnet's offers kept for a host that does not read: more are not given.
const ANSWERS: usize = 1024;
/// How long somebody who was shown out is left to read why. Closing at once would throw away what he has not read yet if he said
/// something meanwhile.
const FAREWELL: Duration = Duration::from_secs(1);
/// Most that are shown out at a time; whoever comes on top of them is not told why.
const CROWD: usize = 16;
/// Silence after which a host is asked whether it is still there, and how often that is asked again before it counts as gone: else one
/// whose computer went down would keep all others out for ever.
const SILENCE: Duration = Duration::from_secs(10);
const ASKED: u32 = 3;

/// The socket, the one host that is in, and those who are being shown out.
struct Door {
    listener: TcpListener,
    guest: Option<Guest>,
    leaving: Vec<(TcpStream, Instant)>,
}

impl Door {
    /// Waits until somebody says something or comes.
    fn wait(&self, patience: Duration) {
        let timeout = Timespec {
            // More than a thousand seconds is never asked for.
            tv_sec: patience.as_secs().min(1000).cast_signed(),
            tv_nsec: patience.subsec_nanos().into(),
        };
        let door = PollFd::new(&self.listener, PollFlags::IN);
        // A signal may end it early: the next look follows at once.
        let _ = match &self.guest {
            Some(guest) => {
                let guest = PollFd::new(&guest.stream, PollFlags::IN);
                poll(&mut [door, guest], Some(&timeout))
            }
            None => poll(&mut [door], Some(&timeout)),
        };
    }

    /// Lets the first in and shows all others out. A handful at a time: a crowd at the door must not stop the clock.
    fn answer(&mut self) {
        for _ in 0..4 {
            let Ok((stream, from)) = self.listener.accept() else {
                break;
            };
            // Whoever cannot be set up is not let in.
            if stream.set_nonblocking(true).is_err() {
                continue;
            }
            match &self.guest {
                None => {
                    // (Better without these than not at all.)
                    let _ = stream.set_nodelay(true);
                    let _ = keep_asking(&stream);
                    self.guest = Some(Guest {
                        stream,
                        from,
                        telnet: Telnet::default(),
                        answer: Vec::new(),
                    });
                }
                Some(first) => {
                    let line = format!(
                        "[MSG:Busy: {} is connected, and one program at a time may be. Close it first]\r\n",
                        first.from
                    );
                    // A few bytes into an empty buffer; whoever does not take them is shown out all the same.
                    let _ = (&stream).write(line.as_bytes());
                    let _ = stream.shutdown(Shutdown::Write);
                    if self.leaving.len() < CROWD {
                        self.leaving.push((stream, Instant::now()));
                    }
                }
            }
        }
        let mut ignored = [0; 1024];
        self.leaving.retain(|(stream, since)| {
            let mut stream = stream;
            let ended = match stream.read(&mut ignored) {
                Ok(n) => n == 0,
                Err(e) => !is_pause(&e),
            };
            !ended && since.elapsed() < FAREWELL
        });
    }
}

/// Lets the system find out by itself whether a silent host is still there.
fn keep_asking(stream: &TcpStream) -> rustix::io::Result<()> {
    sockopt::set_socket_keepalive(stream, true)?;
    sockopt::set_tcp_keepidle(stream, SILENCE)?;
    sockopt::set_tcp_keepintvl(stream, SILENCE)?;
    sockopt::set_tcp_keepcnt(stream, ASKED)
}

impl Guest {
    /// Says what telnet's offers are answered; what does not fit waits. False when the stream is broken.
    fn decline(&mut self) -> bool {
        self.answer.truncate(ANSWERS);
        if self.answer.is_empty() {
            return true;
        }
        match self.stream.write(&self.answer) {
            Ok(n) => {
                self.answer.drain(..n.min(self.answer.len()));
                true
            }
            Err(e) => is_pause(&e),
        }
    }
}

impl Pipe for Door {
    fn hear(&mut self, into: &mut [u8], patience: Duration) -> Heard {
        if !patience.is_zero() {
            self.wait(patience);
        }
        self.answer();
        let Some(guest) = &mut self.guest else {
            return Heard::Nobody;
        };
        let heard = match guest.stream.read(into) {
            _ if into.is_empty() => Heard::Nothing,
            Ok(n) if n > 0 => {
                let said = into.get_mut(..n).unwrap_or_default();
                match guest.telnet.strip(said, &mut guest.answer) {
                    0 => Heard::Nothing,
                    n => Heard::Bytes(n),
                }
            }
            Err(e) if is_pause(&e) => Heard::Nothing,
            // The end of the stream, or a broken one.
            Ok(_) | Err(_) => Heard::Nobody,
        };
        if heard == Heard::Nobody || !guest.decline() {
            self.guest = None;
            return Heard::Nobody;
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

    /// Nothing: the stream took its bytes with it.
    fn forget(&mut self) {}

    fn opening(&self) -> Opening {
        Opening::Nothing
    }
}
