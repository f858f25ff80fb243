//! Real-time bytes: picked out of the stream on arrival, no line end, no reply of their own, no room in the receive buffer.

/// A real-time command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// 0x18: soft reset. While moving it costs the position.
    Reset,
    /// `?`: ask for a status report.
    Status,
    /// `~`: cycle start or resume. Ignored until a hold has come to rest.
    Resume,
    /// `!`: feed hold.
    Hold,
    /// 0x84: safety door.
    Door,
    /// 0x85: cancel a jog.
    JogCancel,
    /// 0x90: feed override back to 100 %.
    FeedNormal,
    /// 0x91: feed override +10 %.
    FeedPlus10,
    /// 0x92: feed override -10 %.
    FeedMinus10,
    /// 0x93: feed override +1 %.
    FeedPlus1,
    /// 0x94: feed override -1 %.
    FeedMinus1,
    /// 0x95: rapid override 100 %.
    RapidFull,
    /// 0x96: rapid override 50 %.
    RapidHalf,
    /// 0x97: rapid override 25 %.
    RapidQuarter,
    /// 0x99: spindle override back to 100 %.
    SpindleNormal,
    /// 0x9A: spindle override +10 %.
    SpindlePlus10,
    /// 0x9B: spindle override -10 %.
    SpindleMinus10,
    /// 0x9C: spindle override +1 %.
    SpindlePlus1,
    /// 0x9D: spindle override -1 %.
    SpindleMinus1,
    /// 0x9E: stop or restart the spindle, in a hold only.
    SpindleStop,
    /// 0xA0: toggle flood coolant.
    Flood,
    /// 0xA1: toggle mist coolant.
    Mist,
    /// Any other byte from 0x80 up: taken out of the stream and dropped.
    Nothing,
}

const BYTES: [(u8, Realtime); 22] = [
    (0x18, Realtime::Reset),
    (b'?', Realtime::Status),
    (b'~', Realtime::Resume),
    (b'!', Realtime::Hold),
    (0x84, Realtime::Door),
    (0x85, Realtime::JogCancel),
    (0x90, Realtime::FeedNormal),
    (0x91, Realtime::FeedPlus10),
    (0x92, Realtime::FeedMinus10),
    (0x93, Realtime::FeedPlus1),
    (0x94, Realtime::FeedMinus1),
    (0x95, Realtime::RapidFull),
    (0x96, Realtime::RapidHalf),
    (0x97, Realtime::RapidQuarter),
    (0x99, Realtime::SpindleNormal),
    (0x9A, Realtime::SpindlePlus10),
    (0x9B, Realtime::SpindleMinus10),
    (0x9C, Realtime::SpindlePlus1),
    (0x9D, Realtime::SpindleMinus1),
    (0x9E, Realtime::SpindleStop),
    (0xA0, Realtime::Flood),
    (0xA1, Realtime::Mist),
];

impl Realtime {
    /// What the firmware makes of a byte on arrival: `None` for one that belongs to a line.
    pub fn from_byte(byte: u8) -> Option<Realtime> {
        match BYTES.iter().find(|(b, _)| *b == byte) {
            Some((_, command)) => Some(*command),
            None if byte >= 0x80 => Some(Realtime::Nothing),
            None => None,
        }
    }

    /// The byte to send. `Nothing` has none of its own; the result is then a harmless 0xFF.
    pub fn byte(self) -> u8 {
        BYTES
            .iter()
            .find(|(_, c)| *c == self)
            .map_or(0xFF, |(b, _)| *b)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_byte_from_0x80_is_taken_out_and_printable_g_code_never_is() {
        for byte in 0x80..=0xFFu8 {
            assert!(Realtime::from_byte(byte).is_some());
        }
        for byte in b"ABCXYZGMFS0123456789.+-()$=;%/ \r\n\t" {
            assert_eq!(Realtime::from_byte(*byte), None);
        }
        for (byte, command) in BYTES {
            assert_eq!(command.byte(), byte);
            assert_eq!(Realtime::from_byte(byte), Some(command));
        }
    }
}
