//! Byte pipes: serial devices through the `serialport` crate.
//!
//! A write to a device nobody reads can hang in the kernel for ever, so nothing here writes more than a caller counted as
//! fitting; the session never has more than one receive buffer plus a few real-time bytes under way.

use std::io::{ErrorKind, Read as _, Write as _};
use std::time::Duration;

/// Most bytes one write may have: more than any session sends at once, far less than any kernel buffer holds.
const WRITE_LIMIT: usize = 1024;

/// Why a port failed.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// It could not be opened.
    #[error("{path}: cannot open the port: {why}. {advice}")]
    Open {
        /// Device path.
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

/// A serial device.
pub struct SerialPort {
    tty: serialport::TTYPort,
    path: String,
}

impl SerialPort {
    /// Opens a device such as `/dev/ttyUSB0` at 8N1 without flow control. Opening resets most Arduino-class controllers.
    ///
    /// # Errors
    /// The device is missing, busy, not a serial port, or not permitted.
    pub fn open(path: &str, baud: u32, timeout: Duration) -> Result<SerialPort, PortError> {
        let tty = serialport::new(path, baud)
            .timeout(timeout)
            .open_native()
            .map_err(|e| PortError::Open {
                path: path.to_string(),
                advice: advice(&e),
                why: e.to_string(),
            })?;
        Ok(SerialPort {
            tty,
            path: path.to_string(),
        })
    }
}

fn advice(error: &serialport::Error) -> &'static str {
    match error.kind() {
        serialport::ErrorKind::NoDevice => {
            "Another program may be using it: close it and try again."
        }
        serialport::ErrorKind::Io(ErrorKind::NotFound) => {
            "Run `morsemill ports` to see which ports there are."
        }
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "Your user may need to belong to the group that owns the device (often `dialout`)."
        }
        _ => "Is it a serial device? Run `morsemill ports`.",
    }
}

impl Port for SerialPort {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, PortError> {
        match self.tty.read(into) {
            Ok(0) => Err(PortError::Gone {
                path: self.path.clone(),
            }),
            Ok(n) => Ok(n),
            Err(e) => match e.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
                ErrorKind::BrokenPipe | ErrorKind::NotConnected => Err(PortError::Gone {
                    path: self.path.clone(),
                }),
                _ => Err(PortError::Failed {
                    path: self.path.clone(),
                    doing: "reading",
                    why: e.to_string(),
                }),
            },
        }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        let mut rest = bytes;
        let mut patience = 50;
        while !rest.is_empty() {
            let chunk = rest.get(..WRITE_LIMIT).unwrap_or(rest);
            match self.tty.write(chunk) {
                Ok(n) => rest = rest.get(n..).unwrap_or_default(),
                Err(e) => match e.kind() {
                    ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
                        if patience > 0 =>
                    {
                        patience -= 1
                    }
                    ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => {
                        return Err(PortError::Stuck {
                            path: self.path.clone(),
                        });
                    }
                    ErrorKind::BrokenPipe | ErrorKind::NotConnected => {
                        return Err(PortError::Gone {
                            path: self.path.clone(),
                        });
                    }
                    _ => {
                        return Err(PortError::Failed {
                            path: self.path.clone(),
                            doing: "writing",
                            why: e.to_string(),
                        });
                    }
                },
            }
        }
        Ok(())
    }
}

/// One serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortEntry {
    /// What to give to `--port`.
    pub path: String,
    /// Maker and product if USB tells them, else the kind of port.
    pub title: String,
}

/// The serial ports of this computer, sorted by path. An empty list is a normal answer.
///
/// # Errors
/// The system would not list them.
pub fn list() -> Result<Vec<PortEntry>, PortError> {
    let ports = serialport::available_ports().map_err(|e| PortError::Failed {
        path: "serial ports".to_string(),
        doing: "listing",
        why: e.to_string(),
    })?;
    let mut entries: Vec<PortEntry> = ports
        .into_iter()
        .map(|p| {
            let title = match p.port_type {
                serialport::SerialPortType::UsbPort(usb) => {
                    let words: Vec<String> = [usb.manufacturer, usb.product]
                        .into_iter()
                        .flatten()
                        .collect();
                    if words.is_empty() {
                        format!("USB {:04x}:{:04x}", usb.vid, usb.pid)
                    } else {
                        words.join(" ")
                    }
                }
                serialport::SerialPortType::BluetoothPort => "Bluetooth".to_string(),
                serialport::SerialPortType::PciPort => "built in".to_string(),
                serialport::SerialPortType::Unknown => "serial port".to_string(),
            };
            PortEntry {
                path: p.port_name,
                title,
            }
        })
        .collect();
    entries.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(entries)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_missing_device_says_what_to_do() {
        let e = SerialPort::open("/dev/no-such-port", 115_200, Duration::from_millis(5))
            .err()
            .unwrap();
        let text = e.to_string();
        assert!(
            text.starts_with("/dev/no-such-port: cannot open the port:"),
            "{text}"
        );
        assert!(text.contains("morsemill ports"), "{text}");
    }

    #[test]
    fn a_file_is_not_a_port() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(
            SerialPort::open(
                file.path().to_str().unwrap(),
                115_200,
                Duration::from_millis(5)
            )
            .is_err()
        );
    }
}
