//! The serial ports of this computer, and what their USB chips tell.

use super::PortError;
use super::boards::{Board, board};
use std::path::Path;

/// What a USB device says about itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usb {
    /// Vendor number.
    pub vendor: u16,
    /// Product number.
    pub product: u16,
    /// Maker's name.
    pub maker: Option<String>,
    /// Product's name.
    pub name: Option<String>,
    /// Serial number: tells two boards of one kind apart.
    pub serial: Option<String>,
}

/// One serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortEntry {
    /// What to give to `--port`.
    pub path: String,
    /// Maker and product if USB tells them, else the kind of port.
    pub title: String,
    /// USB's own words; `None` for any other port.
    pub usb: Option<Usb>,
    /// A name that stays with the device when it is plugged in elsewhere or after others (Linux: `/dev/serial/by-id`). Works for
    /// `--port` as well as the path.
    pub stable: Option<String>,
}

impl PortEntry {
    /// A port behind a USB device.
    pub fn of_usb(path: String, usb: Usb) -> PortEntry {
        let words: Vec<&str> = [&usb.maker, &usb.name]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        let title = if words.is_empty() {
            format!("USB {:04x}:{:04x}", usb.vendor, usb.product)
        } else {
            words.join(" ")
        };
        PortEntry {
            path,
            title,
            usb: Some(usb),
            stable: None,
        }
    }

    /// This is the device a name of any kind leads to.
    pub fn is_at(&self, name: &str) -> bool {
        let real = |p: &str| std::fs::canonicalize(p);
        self.path == name || matches!((real(&self.path), real(name)), (Ok(a), Ok(b)) if a == b)
    }

    /// The board it may be: one that runs GRBL or its kin. `None`: no USB port, or a chip that no such board has.
    pub fn board(&self) -> Option<&'static Board> {
        self.usb.as_ref().and_then(|u| board(u.vendor, u.product))
    }
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
    let mut entries: Vec<PortEntry> = ports.into_iter().map(entry).collect();
    name_by_id(&mut entries, Path::new(BY_ID));
    entries.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(entries)
}

/// Where Linux's udev keeps names that are made of maker, product and serial number.
const BY_ID: &str = "/dev/serial/by-id";

/// Gives the entries their lasting names, as far as `folder` has any.
fn name_by_id(entries: &mut [PortEntry], folder: &Path) {
    let Ok(names) = std::fs::read_dir(folder) else {
        return;
    };
    let mut names: Vec<String> = names
        .filter_map(|name| name.ok()?.path().to_str().map(str::to_string))
        .collect();
    // (A device may have several; always the same one is taken.)
    names.sort();
    for entry in entries {
        entry.stable = names.iter().find(|name| entry.is_at(name)).cloned();
    }
}

fn entry(port: serialport::SerialPortInfo) -> PortEntry {
    let title = match port.port_type {
        serialport::SerialPortType::UsbPort(usb) => {
            let usb = Usb {
                vendor: usb.vid,
                product: usb.pid,
                maker: usb.manufacturer,
                name: usb.product,
                serial: usb.serial_number,
            };
            return PortEntry::of_usb(port.port_name, usb);
        }
        serialport::SerialPortType::BluetoothPort => "Bluetooth",
        serialport::SerialPortType::PciPort => "built in",
        serialport::SerialPortType::Unknown => "serial port",
    };
    PortEntry {
        path: port.port_name,
        title: title.to_string(),
        usb: None,
        stable: None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lasting_names_lead_to_the_same_device() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for device in ["ttyUSB0", "ttyUSB1"] {
            std::fs::write(at(device), "").unwrap();
        }
        std::fs::create_dir(at("by-id")).unwrap();
        let id = at("by-id/usb-1a86_USB_Serial-if00-port0");
        std::os::unix::fs::symlink("../ttyUSB1", &id).unwrap();
        std::os::unix::fs::symlink("../ttyUSB7", at("by-id/gone")).unwrap();
        let mut entries = ["ttyUSB0", "ttyUSB1"]
            .map(|n| PortEntry::of_usb(at(n).display().to_string(), Usb::default()));
        name_by_id(&mut entries, &at("no such folder"));
        assert_eq!(entries[1].stable, None);
        name_by_id(&mut entries, &at("by-id"));
        assert_eq!(entries[0].stable, None);
        assert_eq!(entries[1].stable, Some(id.display().to_string()));
        assert!(entries[1].is_at(&id.display().to_string()));
        assert!(!entries[0].is_at(&id.display().to_string()));
        assert!(!entries[0].is_at("tcp://127.0.0.1:23"));
    }

    #[test]
    fn a_port_says_what_usb_says_and_which_board_it_may_be() {
        let usb = Usb {
            vendor: 0x1A86,
            product: 0x7523,
            ..Usb::default()
        };
        let bare = PortEntry::of_usb("/dev/ttyUSB0".into(), usb.clone());
        assert_eq!(bare.title, "USB 1a86:7523");
        assert_eq!(
            bare.board().map(|b| b.title),
            Some("CH340 (Nano and Uno clones, ESP32)")
        );
        let named = PortEntry::of_usb(
            "/dev/ttyACM0".into(),
            Usb {
                vendor: 0x046D,
                maker: Some("Logitech".into()),
                name: Some("Keyboard".into()),
                ..usb
            },
        );
        assert_eq!(named.title, "Logitech Keyboard");
        assert_eq!(named.board(), None);
    }
}
