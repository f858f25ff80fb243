//! A cable in virtual time.

use std::collections::VecDeque;

/// A cable with a delay for each piece of bytes, in milliseconds, repeated; pieces are cut to the sizes given, repeated.
#[derive(Clone, Debug)]
pub struct Cable {
    /// Bytes a millisecond; `None`: as many as come.
    pub rate: Option<f64>,
    /// When the last byte has gone through, ms.
    pub free_at: f64,
    /// Milliseconds in which bytes went through.
    pub busy: f64,
    pub delays: Vec<u64>,
    pub cuts: Vec<usize>,
    pub turn: usize,
    pub pieces: VecDeque<(u64, Vec<u8>)>,
}

impl Cable {
    pub fn new(delays: Vec<u64>, cuts: Vec<usize>) -> Cable {
        Cable {
            rate: None,
            free_at: 0.0,
            busy: 0.0,
            delays,
            cuts,
            turn: 0,
            pieces: VecDeque::new(),
        }
    }

    pub fn send(&mut self, now: u64, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            self.turn += 1;
            let cut = self.cuts[self.turn % self.cuts.len()].clamp(1, rest.len());
            let mut at = now + self.delays[self.turn % self.delays.len()];
            if let Some(rate) = self.rate {
                let time = cut as f64 / rate;
                self.free_at = self.free_at.max(now as f64) + time;
                self.busy += time;
                at += (self.free_at - now as f64).ceil() as u64;
            }
            // Bytes never overtake each other.
            let at = self.pieces.back().map_or(at, |p| p.0.max(at));
            self.pieces.push_back((at, rest[..cut].to_vec()));
            rest = &rest[cut..];
        }
    }

    pub fn arrive(&mut self, now: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        while self.pieces.front().is_some_and(|p| p.0 <= now) {
            bytes.extend(self.pieces.pop_front().unwrap().1);
        }
        bytes
    }
}
