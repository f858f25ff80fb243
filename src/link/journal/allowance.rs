//! How far ahead lines are allowed: far enough that sending never waits for a record, and no farther.
//!
//! After a crash of the sender, everything allowed may have been cut. So a line is allowed when it could be sent soon: while less than one
//! receive buffer of allowed bytes is left, lines are allowed up to two receive buffers beyond the last answer.
//!
//! ```text
//!        answered        sent            allowed
//! ----------|--------------|----------------|------------------>  lines
//!           |<- at most rx ->|              |
//!           |<-------- at most 2 rx + 1 line ->|
//! ```

/// Decides when to allow further lines. Lines count from 1 as the caller counts them; bytes include line ends.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    rx_bytes: usize,
    allowed: usize,
    /// Bytes of lines up to `allowed`.
    allowed_bytes: usize,
}

impl Allowance {
    /// Nothing allowed yet.
    pub fn new(rx_bytes: usize) -> Allowance {
        Allowance {
            rx_bytes: rx_bytes.max(1),
            allowed: 0,
            allowed_bytes: 0,
        }
    }

    /// The last line allowed so far.
    pub fn allowed(&self) -> usize {
        self.allowed
    }

    /// Where to allow up to now, if more is needed: `sent_bytes` and `acknowledged_bytes` are the bytes of all lines sent and answered so far,
    /// `bytes_of` the bytes of a line, `None` behind the last.
    pub fn extend(
        &mut self,
        sent_bytes: usize,
        acknowledged_bytes: usize,
        mut bytes_of: impl FnMut(usize) -> Option<usize>,
    ) -> Option<usize> {
        if self.allowed_bytes.saturating_sub(sent_bytes) >= self.rx_bytes {
            return None;
        }
        let before = self.allowed;
        // The next line always: a line longer than the buffer is somebody else's complaint.
        while self.allowed == before
            || self.allowed_bytes < acknowledged_bytes.saturating_add(2 * self.rx_bytes)
        {
            let Some(bytes) = bytes_of(self.allowed + 1) else {
                break;
            };
            self.allowed += 1;
            self.allowed_bytes = self.allowed_bytes.saturating_add(bytes);
        }
        (self.allowed > before).then_some(self.allowed)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        /// The next line that fits the receive buffer is always allowed in time, and never more than two buffers and a line.
        #[test]
        fn enough_and_no_more(lengths in proptest::collection::vec(1usize..81, 1..200), rx in 81usize..300) {
            let mut a = Allowance::new(rx);
            let bytes_of = |line: usize| lengths.get(line - 1).copied();
            let upto = |line: usize| lengths[..line].iter().sum::<usize>();
            let (mut sent, mut acknowledged) = (0, 0);
            while acknowledged < lengths.len() {
                a.extend(upto(sent), upto(acknowledged), bytes_of);
                prop_assert!(upto(a.allowed()) - upto(acknowledged) <= 2 * rx + 80);
                while sent < lengths.len() && upto(sent + 1) - upto(acknowledged) <= rx {
                    prop_assert!(a.allowed() > sent);
                    sent += 1;
                }
                acknowledged += 1;
            }
            prop_assert_eq!(a.allowed(), lengths.len());
        }
    }
}
