//! When the next line may be sent: character counting, as a value without I/O or clock.
//!
//! The controller stores what it has received and not yet read in a ring of `window` bytes and drops the rest *silently*, so the sum
//! of the bytes of all unanswered lines (line ends included) must never exceed it. Every line is answered exactly once, in order,
//! by `ok` or `error:N`; either frees that line's bytes. `ok` means read and queued, not done: so the job ends with a `G4 P0`,
//! answered only when all motion has ended, and is complete once two reports after that say Idle.

use super::job::JobLine;
use crate::wire::{Reply, State};

/// Kept free of the receive buffer: costs nothing and forgives a firmware that counts one byte differently.
const MARGIN: usize = 1;
/// Reports in a row that must say Idle at the end.
const IDLE_REPORTS: u32 = 2;

/// Why a job cannot be streamed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StreamError {
    /// A line alone is larger than the receive buffer.
    #[error(
        "line {line} has {bytes} bytes, but the controller's receive buffer takes {window}: shorten the line"
    )]
    LineTooLong {
        /// Line of the program, from 1.
        line: usize,
        /// Its bytes with the line end.
        bytes: usize,
        /// Bytes that fit.
        window: usize,
    },
}

/// What a reply meant to the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Receipt {
    /// The line with this index was taken.
    Accepted(usize),
    /// The line with this index was refused; the stream sends nothing more from here on.
    Refused {
        /// Index into the lines.
        index: usize,
        /// The N of `error:N`.
        code: u16,
    },
    /// An answer although no line is waiting for one: a stray `ok`, or noise made one up.
    Unasked,
    /// Not an answer to a line.
    Push,
}

/// The streamer. Lines go out by [`Stream::sendable`], replies come in by [`Stream::receive`].
#[derive(Clone, Debug)]
pub struct Stream {
    lines: Vec<JobLine>,
    window: usize,
    sent: usize,
    acknowledged: usize,
    in_flight: usize,
    interrupted: bool,
    idle_reports: u32,
    outgoing: Vec<u8>,
}

impl Stream {
    /// A stream of these lines (without line ends), followed by a `G4 P0`, into a receive buffer of `rx_bytes`.
    ///
    /// # Errors
    /// A line that could never fit.
    pub fn new(mut lines: Vec<JobLine>, rx_bytes: usize) -> Result<Stream, StreamError> {
        lines.push(JobLine::own("G4P0"));
        let window = rx_bytes.saturating_sub(MARGIN);
        if let Some(line) = lines.iter().find(|l| l.bytes() > window) {
            return Err(StreamError::LineTooLong {
                line: line.source,
                bytes: line.bytes(),
                window,
            });
        }
        Ok(Stream {
            lines,
            window,
            sent: 0,
            acknowledged: 0,
            in_flight: 0,
            interrupted: false,
            idle_reports: 0,
            outgoing: Vec::new(),
        })
    }

    /// The next line with its line end, if it fits now and the stream is not interrupted. It counts as sent from here on.
    pub fn sendable(&mut self) -> Option<&[u8]> {
        if self.interrupted {
            return None;
        }
        let line = self.lines.get(self.sent)?;
        if self.in_flight + line.bytes() > self.window {
            return None;
        }
        self.in_flight += line.bytes();
        self.sent += 1;
        self.outgoing.clear();
        self.outgoing.extend_from_slice(line.text.as_bytes());
        // A line feed alone: GRBL takes CR LF for two lines and answers twice.
        self.outgoing.push(b'\n');
        Some(&self.outgoing)
    }

    /// Takes in one reply. A refused line interrupts the stream for good.
    pub fn receive(&mut self, reply: &Reply) -> Receipt {
        let code = match reply {
            Reply::Ok => None,
            Reply::Error(code) => Some(*code),
            Reply::Status(status) => {
                let quiet = status.state == State::Idle && self.all_acknowledged();
                self.idle_reports = if quiet { self.idle_reports + 1 } else { 0 };
                return Receipt::Push;
            }
            _ => return Receipt::Push,
        };
        if self.acknowledged >= self.sent {
            return Receipt::Unasked;
        }
        let index = self.acknowledged;
        self.in_flight -= self.lines.get(index).map_or(0, JobLine::bytes);
        self.acknowledged += 1;
        match code {
            None => Receipt::Accepted(index),
            Some(code) => {
                self.interrupted = true;
                Receipt::Refused { index, code }
            }
        }
    }

    /// Sends nothing more, whatever arrives.
    pub fn interrupt(&mut self) {
        self.interrupted = true;
    }

    /// The line with this index.
    pub fn line(&self, index: usize) -> Option<&JobLine> {
        self.lines.get(index)
    }

    /// Lines of the job that were sent (the closing `G4 P0` does not count).
    pub fn sent(&self) -> usize {
        self.sent.min(self.total())
    }

    /// Lines of the job that were answered.
    pub fn acknowledged(&self) -> usize {
        self.acknowledged.min(self.total())
    }

    /// Lines of the job.
    pub fn total(&self) -> usize {
        self.lines.len().saturating_sub(1)
    }

    /// Bytes the controller may be holding.
    pub fn in_flight(&self) -> usize {
        self.in_flight
    }

    /// The lines that were sent and not answered yet, oldest first.
    pub fn unanswered(&self) -> &[JobLine] {
        self.lines
            .get(self.acknowledged..self.sent)
            .unwrap_or_default()
    }

    /// Every line, the closing `G4 P0` included, was answered.
    pub fn all_acknowledged(&self) -> bool {
        self.acknowledged == self.lines.len()
    }

    /// All was answered, and the machine has been Idle in two reports since: the job is done.
    pub fn is_complete(&self) -> bool {
        !self.interrupted && self.all_acknowledged() && self.idle_reports >= IDLE_REPORTS
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::wire::Status;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    fn lines(lengths: &[usize]) -> Vec<JobLine> {
        lengths
            .iter()
            .enumerate()
            .map(|(i, n)| JobLine {
                text: "X".repeat(*n),
                source: i + 1,
                dwell: 0.0,
            })
            .collect()
    }

    #[test]
    fn a_refused_line_ends_the_sending() {
        let mut s = Stream::new(lines(&[10, 10, 10, 60, 60, 60]), 128).unwrap();
        while s.sendable().is_some() {}
        assert_eq!(s.sent(), 4);
        assert_eq!(s.receive(&Reply::Ok), Receipt::Accepted(0));
        assert_eq!(
            s.receive(&Reply::Error(20)),
            Receipt::Refused { index: 1, code: 20 }
        );
        assert!(s.sendable().is_none());
        // Lines already in the controller are still answered.
        assert_eq!(s.receive(&Reply::Ok), Receipt::Accepted(2));
        assert_eq!(s.receive(&Reply::Ok), Receipt::Accepted(3));
        assert_eq!(s.receive(&Reply::Ok), Receipt::Unasked);
        assert!(!s.is_complete());
    }

    #[test]
    fn done_means_answered_and_idle_twice() {
        let mut s = Stream::new(lines(&[5]), 128).unwrap();
        let idle = Reply::Status(Status::new(State::Idle));
        while s.sendable().is_some() {}
        s.receive(&Reply::Ok);
        for _ in 0..5 {
            s.receive(&idle); // a dwell is Idle too
        }
        assert!(!s.is_complete());
        s.receive(&Reply::Ok);
        s.receive(&idle);
        s.receive(&Reply::Status(Status::new(State::Run)));
        s.receive(&idle);
        assert!(!s.is_complete());
        s.receive(&idle);
        assert!(s.is_complete());
    }

    #[test]
    fn a_line_that_can_never_fit_is_named() {
        let e = Stream::new(lines(&[5, 127]), 128).unwrap_err();
        assert_eq!(
            e.to_string(),
            "line 2 has 128 bytes, but the controller's receive buffer takes 127: shorten the line"
        );
    }

    proptest! {
        /// Whatever the delays: the ring never overflows, nothing is lost, order is kept, and the job ends.
        #[test]
        fn counted_bytes_never_overflow_the_ring(
            lengths in proptest::collection::vec(1usize..80, 1..80),
            steps in proptest::collection::vec((0usize..4, 0usize..4), 1..400),
        ) {
            let mut stream = Stream::new(lines(&lengths), 128).unwrap();
            // The far side, reduced to its ring: lines wait, the oldest is answered when the dice say so.
            let mut ring: VecDeque<Vec<u8>> = VecDeque::new();
            let mut seen = Vec::new();
            for (send, answer) in steps.into_iter().chain(std::iter::repeat_n((4, 4), 200)) {
                for _ in 0..send {
                    if let Some(line) = stream.sendable() {
                        ring.push_back(line.to_vec());
                    }
                }
                prop_assert!(ring.iter().map(Vec::len).sum::<usize>() <= 128);
                prop_assert_eq!(ring.iter().map(Vec::len).sum::<usize>(), stream.in_flight());
                for _ in 0..answer {
                    if let Some(line) = ring.pop_front() {
                        seen.push(line);
                        prop_assert!(matches!(stream.receive(&Reply::Ok), Receipt::Accepted(_)));
                    }
                }
            }
            prop_assert!(stream.all_acknowledged());
            prop_assert_eq!(stream.acknowledged(), lengths.len());
            prop_assert_eq!(seen.len(), lengths.len() + 1);
            for (line, n) in seen.iter().zip(&lengths) {
                prop_assert_eq!(line.len(), n + 1);
            }
        }
    }
}
