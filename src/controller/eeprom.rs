//! The time that writing takes, and what the serial line loses by it.
//!
//! Each changed byte keeps the interrupts of the chip off for some milliseconds; the serial hardware has room for two bytes and one on
//! its way in, the rest of what arrives in that time is gone.

use super::{Controller, SAME_MOMENT};

/// Seconds a byte takes.
const BYTE: f64 = 0.0034;
/// Bytes the serial hardware keeps meanwhile.
const KEPT: u32 = 2;

/// A write under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Write {
    begun: f64,
    until: f64,
    /// Byte being written, and what has come in meanwhile.
    window: (u32, u32),
}

impl Controller {
    /// So many bytes change.
    pub(super) fn write_eeprom(&mut self, bytes: usize) {
        if bytes == 0 || !self.cable.is_timed() {
            return;
        }
        self.think(bytes as f64 * BYTE);
        self.writing = Some(Write {
            begun: self.now,
            until: self.busy_until,
            window: (0, 0),
        });
    }

    /// True for a byte that comes in while too many others wait.
    pub(super) fn loses(&mut self) -> bool {
        let (now, lossy) = (self.now, self.build.quirks.eeprom_byte_loss);
        let Some(write) = self.writing.as_mut().filter(|_| lossy) else {
            return false;
        };
        if now >= write.until - SAME_MOMENT {
            self.writing = None;
            return false;
        }
        let window = ((now - write.begun) / BYTE) as u32;
        let count = if window == write.window.0 {
            write.window.1 + 1
        } else {
            1
        };
        write.window = (window, count);
        count > KEPT
    }
}

/// Bytes that differ between two stored numbers.
pub(super) fn changed(before: f64, after: f64) -> usize {
    let (a, b) = ((before as f32).to_le_bytes(), (after as f32).to_le_bytes());
    a.iter().zip(&b).filter(|(a, b)| a != b).count()
}
