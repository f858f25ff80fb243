//! Serial devices through the `serialport` crate: 8N1, no flow control.

use super::{Port, PortError, read_some, write_all};
use std::io::ErrorKind;
use std::time::Duration;

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
            "Your user may need to belong to the group that owns the device (often `dialout`: sudo usermod -aG dialout $USER), and to log in anew then."
        }
        _ => "Is it a serial device? Run `morsemill ports`.",
    }
}

impl Port for SerialPort {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, PortError> {
        read_some(&mut self.tty, &self.path, into)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        write_all(&mut self.tty, &self.path, bytes)
    }
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
