//! Controllers on the network: a plain TCP stream of the same bytes (grblHAL and FluidNC over telnet, serial servers such as ser2net).

use super::{Port, PortError, TCP, read_some, write_all};
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::Duration;

/// How long one address of a host may take to answer.
const CONNECT: Duration = Duration::from_secs(5);
/// How long one write may take before it is tried again.
const WRITE: Duration = Duration::from_millis(100);

/// A TCP connection to a controller. Small packets go out at once (no Nagle): a real-time byte must not wait for company.
pub struct TcpPort {
    stream: TcpStream,
    name: String,
}

impl TcpPort {
    /// Connects to `tcp://HOST:PORT`. `timeout` is how long one look waits.
    ///
    /// # Errors
    /// No such host, nobody listening, no answer within 5 s, or a name without a port.
    pub fn open(name: &str, timeout: Duration) -> Result<TcpPort, PortError> {
        let fail = |why: String, advice: &'static str| PortError::Open {
            path: name.to_string(),
            why,
            advice,
        };
        let place = name.get(TCP.len()..).unwrap_or_default();
        let place = place.strip_suffix('/').unwrap_or(place);
        let port = place.rsplit_once(':').map(|(host, port)| {
            let bare = host.contains(':') && !(host.starts_with('[') && host.ends_with(']'));
            (host, port.parse::<u16>().ok().filter(|_| !bare))
        });
        if !matches!(port, Some((host, Some(p))) if !host.is_empty() && p > 0) {
            return Err(fail(
                "it names no port".to_string(),
                "Write tcp://HOST:PORT, e.g. tcp://192.168.1.20:23 (grblHAL and FluidNC listen on 23).",
            ));
        }
        let addresses: Vec<SocketAddr> = place
            .to_socket_addrs()
            .map_err(|e| {
                fail(
                    e.to_string(),
                    "Is the host's name right? Its number does as well: tcp://192.168.1.20:23.",
                )
            })?
            .collect();
        let mut last = std::io::Error::from(ErrorKind::AddrNotAvailable);
        for address in addresses {
            match TcpStream::connect_timeout(&address, CONNECT) {
                Ok(stream) => return TcpPort::with(stream, name, timeout),
                Err(e) => last = e,
            }
        }
        Err(fail(last.to_string(), advice(last.kind())))
    }

    fn with(stream: TcpStream, name: &str, timeout: Duration) -> Result<TcpPort, PortError> {
        // Zero would mean "for ever".
        let timeout = timeout.max(Duration::from_millis(1));
        stream
            .set_nodelay(true)
            .and_then(|()| stream.set_read_timeout(Some(timeout)))
            .and_then(|()| stream.set_write_timeout(Some(WRITE)))
            .map_err(|e| PortError::Failed {
                path: name.to_string(),
                doing: "setting the connection up",
                why: e.to_string(),
            })?;
        Ok(TcpPort {
            stream,
            name: name.to_string(),
        })
    }
}

fn advice(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::ConnectionRefused => {
            "Nothing listens on that port: is telnet switched on in the controller, and the number right?"
        }
        ErrorKind::TimedOut | ErrorKind::WouldBlock => {
            "Nobody answered: is the controller on, and in the same network?"
        }
        ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable => {
            "There is no way to it: is this computer in the controller's network?"
        }
        _ => "Is the address right?",
    }
}

impl Port for TcpPort {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, PortError> {
        read_some(&mut self.stream, &self.name, into)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        write_all(&mut self.stream, &self.name, bytes)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::open;
    use super::*;
    use std::io::{Read as _, Write as _};
    use std::net::TcpListener;

    fn refused(spec: &str) -> String {
        open(spec, 115_200).err().unwrap().to_string()
    }

    #[test]
    fn names_without_a_port_and_ports_nobody_listens_on() {
        for spec in [
            "tcp://",
            "tcp://mill",
            "tcp://mill:",
            "tcp://:23",
            "tcp://mill:0",
            "tcp://mill:99999",
            "tcp://::1:23",
            "TCP://mill:x",
        ] {
            assert_eq!(
                refused(spec),
                format!(
                    "{spec}: cannot open the port: it names no port. Write tcp://HOST:PORT, e.g. tcp://192.168.1.20:23 (grblHAL and FluidNC listen on 23)."
                )
            );
        }
        let free = TcpListener::bind("127.0.0.1:0")
            .unwrap()
            .local_addr()
            .unwrap();
        let text = refused(&format!("tcp://{free}"));
        assert!(text.contains("Nothing listens on that port"), "{text}");
    }

    #[test]
    fn bytes_go_both_ways_and_a_closed_connection_is_gone() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let at = listener.local_addr().unwrap();
        let far = std::thread::spawn(move || {
            let (mut s, _) = listener.accept().unwrap();
            let mut got = [0; 3];
            s.read_exact(&mut got).unwrap();
            s.write_all(&got).unwrap();
        });
        let mut port = open(&format!("tcp://{at}/"), 115_200).unwrap();
        let mut buffer = [0; 16];
        assert_eq!(port.read(&mut buffer).unwrap(), 0, "nothing said yet");
        port.write(b"$$\n").unwrap();
        let mut got = Vec::new();
        let end = loop {
            match port.read(&mut buffer) {
                Ok(n) => got.extend_from_slice(&buffer[..n]),
                Err(e) => break e,
            }
        };
        assert_eq!(got, b"$$\n");
        assert_eq!(
            end.to_string(),
            format!("tcp://{at}/: the port is gone: check the cable and the controller's power")
        );
        far.join().unwrap();
    }
}
