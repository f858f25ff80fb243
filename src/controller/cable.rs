//! The serial line: when bytes arrive, and when what was said has left.
//!
//! Without a speed both happen at once. With one, each byte takes its ten bits; what is said waits in the firmware's transmit ring, and
//! the main loop waits when that is full.

use std::collections::VecDeque;

/// Bits of a byte on the line, start and stop among them.
const BITS: f64 = 10.0;
/// Bytes under way to the controller, put there by a host faster than the line, at which a driver would make it wait.
const CHOKED: usize = 4096;
/// Bytes the transmit ring holds.
const RING: usize = 104;

/// Bytes of a short message and its answer.
const MESSAGE: usize = 20;

/// The line in both directions. Times are machine time, s.
#[derive(Clone, Debug)]
pub(super) struct Cable {
    byte: f64,
    incoming: VecDeque<(f64, u8)>,
    /// Said and gone.
    sent: Vec<u8>,
    /// Said, not yet gone, with the moment at which the last bit leaves.
    leaving: VecDeque<(f64, u8)>,
}

impl Cable {
    /// A line of so many bits a second; `None`: bytes take no time.
    pub fn new(baud: Option<u32>) -> Cable {
        Cable {
            byte: baud.map_or(0.0, |b| BITS / f64::from(b.max(1))),
            incoming: VecDeque::new(),
            sent: Vec::new(),
            leaving: VecDeque::new(),
        }
    }

    /// Bytes take time.
    pub fn is_timed(&self) -> bool {
        self.byte > 0.0
    }

    /// Bytes put on a timed line now; they arrive one by one behind those already on it.
    pub fn put(&mut self, bytes: &[u8], now: f64) {
        let mut at = self.incoming.back().map_or(now, |(t, _)| t.max(now));
        for &byte in bytes {
            at += self.byte;
            self.incoming.push_back((at, byte));
        }
    }

    /// So many bytes are under way to the controller that the host should wait before it puts more.
    pub fn is_choked(&self) -> bool {
        self.incoming.len() >= CHOKED
    }

    /// The next byte that has arrived by now.
    pub fn arrived(&mut self, now: f64) -> Option<u8> {
        let (at, byte) = *self.incoming.front()?;
        if at > now + super::SAME_MOMENT {
            return None;
        }
        self.incoming.pop_front();
        Some(byte)
    }

    /// When the next byte arrives.
    pub fn next_arrival(&self) -> Option<f64> {
        self.incoming.front().map(|(t, _)| *t)
    }

    /// The controller says something.
    pub fn say(&mut self, bytes: &[u8], now: f64) {
        if !self.is_timed() {
            self.sent.extend_from_slice(bytes);
            return;
        }
        let mut at = self.leaving.back().map_or(now, |(t, _)| t.max(now));
        for &byte in bytes {
            at += self.byte;
            self.leaving.push_back((at, byte));
        }
    }

    /// The transmit ring has room for a message.
    pub fn has_room(&self) -> bool {
        self.leaving.len() + MESSAGE < RING
    }

    /// When the transmit ring has room again, if what was said overfills it.
    pub fn blocked_until(&self, now: f64) -> f64 {
        let excess = self.leaving.len().saturating_sub(RING);
        match excess.checked_sub(1).and_then(|i| self.leaving.get(i)) {
            Some((t, _)) => t.max(now),
            None => now,
        }
    }

    /// Time has come to `now`: what has left by then counts as sent.
    pub fn pass(&mut self, now: f64) {
        while let Some((_, byte)) = self
            .leaving
            .front()
            .copied()
            .filter(|(t, _)| *t <= now + super::SAME_MOMENT)
        {
            self.sent.push(byte);
            self.leaving.pop_front();
        }
    }

    /// What has been sent since the last call.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.sent)
    }

    /// Something has been sent.
    pub fn has_output(&self) -> bool {
        !self.sent.is_empty()
    }

    /// When all that was said will have left; `None` if it has.
    pub fn quiet_at(&self) -> Option<f64> {
        self.leaving.back().map(|(t, _)| *t)
    }
}
