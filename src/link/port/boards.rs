//! Which USB chips sit on boards that run GRBL and its kin.
//!
//! A chip says what the board's cable ends in, not what firmware runs there: a table hit means "may well be one", never "is one".
//! Numbers from the USB ID Repository (linux-usb.org, usb.ids) and, for Arduino's own, from `boards.txt` of Arduino's AVR core
//! (arduino/ArduinoCore-avr). Which boards have which chip: GRBL's wiki ("Using Grbl"), grblHAL's driver list, FluidNC's wiki
//! ("Hardware").

/// One line of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// Vendor number.
    pub vendor: u16,
    /// Product number; `None`: any product of this vendor.
    pub product: Option<u16>,
    /// What it is.
    pub title: &'static str,
    /// What of GRBL's family runs on such boards.
    pub runs: &'static str,
}

const fn known(vendor: u16, product: u16, title: &'static str, runs: &'static str) -> Board {
    Board {
        vendor,
        product: Some(product),
        title,
        runs,
    }
}

const fn any(vendor: u16, title: &'static str, runs: &'static str) -> Board {
    Board {
        vendor,
        product: None,
        title,
        runs,
    }
}

const GRBL: &str = "GRBL";
const MEGA: &str = "grbl-Mega";
const HAL: &str = "grblHAL";
const MANY: &str = "GRBL, grblHAL or FluidNC";
const ESP: &str = "FluidNC or Grbl_Esp32";

/// All that is known. A product's own line stands before its vendor's.
pub const BOARDS: [Board; 34] = [
    known(0x2341, 0x0043, "Arduino Uno R3", GRBL),
    known(0x2341, 0x0001, "Arduino Uno", GRBL),
    known(0x2341, 0x0243, "Arduino Uno R3", GRBL),
    known(0x2341, 0x006a, "Arduino Uno", GRBL),
    known(0x2A03, 0x0043, "Arduino Uno R3 (arduino.org)", GRBL),
    known(0x2341, 0x0010, "Arduino Mega 2560", MEGA),
    known(0x2341, 0x0042, "Arduino Mega 2560 R3", MEGA),
    known(0x2341, 0x0210, "Arduino Mega 2560", MEGA),
    known(0x2341, 0x0242, "Arduino Mega 2560", MEGA),
    known(0x2A03, 0x0010, "Arduino Mega 2560 (arduino.org)", MEGA),
    known(0x2A03, 0x0042, "Arduino Mega 2560 (arduino.org)", MEGA),
    known(0x2341, 0x003d, "Arduino Due (programming port)", HAL),
    known(0x2341, 0x003e, "Arduino Due (native port)", HAL),
    known(0x2341, 0x804d, "Arduino Zero", HAL),
    any(0x2341, "Arduino", GRBL),
    any(0x2A03, "Arduino (arduino.org)", GRBL),
    known(0x1A86, 0x7523, "CH340 (Nano and Uno clones, ESP32)", MANY),
    known(0x1A86, 0x5523, "CH341", MANY),
    known(0x1A86, 0x7522, "CH340", MANY),
    known(0x1A86, 0x55D3, "CH343", MANY),
    known(0x1A86, 0x55D4, "CH9102 (ESP32)", ESP),
    known(0x0403, 0x6001, "FT232R (Arduino Nano, Duemilanove)", GRBL),
    known(0x0403, 0x6010, "FT2232", MANY),
    known(0x0403, 0x6014, "FT232H", MANY),
    known(0x0403, 0x6015, "FT231X (FT-X series)", MANY),
    known(0x10C4, 0xEA60, "CP210x (ESP32)", MANY),
    known(0x067B, 0x2303, "PL2303", MANY),
    known(0x16C0, 0x0483, "Teensy (USB serial)", HAL),
    known(0x16C0, 0x0487, "Teensy (USB serial and more)", HAL),
    known(0x0483, 0x5740, "STM32 virtual COM port", HAL),
    known(0x0483, 0x374B, "ST-LINK/V2.1 (Nucleo)", HAL),
    known(0x2E8A, 0x000A, "Raspberry Pi Pico", HAL),
    known(0x1D50, 0x6015, "Smoothieboard", HAL),
    any(0x303A, "Espressif (native USB)", ESP),
];

/// The board that a USB device may be; `None` for chips that no such board has.
pub fn board(vendor: u16, product: u16) -> Option<&'static Board> {
    BOARDS
        .iter()
        .find(|b| b.vendor == vendor && b.product.is_none_or(|p| p == product))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_line_can_be_found() {
        for b in &BOARDS {
            let found = board(b.vendor, b.product.unwrap_or(0xFFFF)).unwrap();
            assert_eq!(found, b, "hidden behind another line");
            assert!(!b.title.is_empty() && !b.runs.is_empty());
        }
    }

    #[test]
    fn known_chips_and_strangers() {
        assert_eq!(board(0x2341, 0x0043).unwrap().title, "Arduino Uno R3");
        assert_eq!(board(0x2341, 0x8036).unwrap().title, "Arduino");
        assert_eq!(board(0x1A86, 0x7523).unwrap().runs, MANY);
        assert_eq!(board(0x303A, 0x1001).unwrap().runs, ESP);
        // A keyboard, and a hub of a maker who also makes other things.
        assert_eq!(board(0x046D, 0xC31C), None);
        assert_eq!(board(0x0403, 0x0000), None);
    }
}
