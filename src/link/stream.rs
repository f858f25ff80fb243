//! When the next line may be sent: character counting and the rule of dangerous lines, as a value without I/O or clock.
//!
//! **Counting.** The controller stores what it has received and not yet read in a ring of `window` bytes and drops the rest
//! *silently*, so the sum of the bytes of all unanswered lines (line ends included) must never exceed it. Every line is answered
//! exactly once, in order, by `ok` or `error:N`; either frees that line's bytes. `ok` means read and queued, not done.
//!
//! **Danger.** When a line is refused the controller drops it whole and runs on with what it has received already, at the old place and
//! in the old modes, until the host has heard of it and stops the machine. What must not happen then is a rapid or a
//! plunge that starts from where the refused line should have led. So:
//!
//! 1. at most one *dangerous* line is unanswered at a time: the next waits for the answer. Answers come in order, so everything
//!    before the unanswered one was taken: a rapid never follows a retract that was refused, a plunge never follows a rapid that was.
//!    Dangerous are rapids, probes, straight plunges and retracts, feed moves that go up or down by more than
//!    [`crate::link::vet::PLUNGE`], and changes of spindle or coolant. The short segments of a finishing pass, though each goes
//!    up or down a little, are not: if one is refused, the next starts at most a segment away, and their flow is what
//!    keeps the planner full;
//! 2. behind a line that changes what coordinates mean (plane, distance, units, feed mode, offsets) nothing is sent until it is
//!    answered; behind one that changes the modal motion, nothing that relies on it;
//! 3. a line that writes the controller's memory is sent alone: all else is answered before, nothing is sent behind;
//! 4. behind a line at which the operator is asked for, nothing is sent.

use super::job::JobLine;
use super::vet::RX_MARGIN;
use crate::wire::{Reply, State};
use std::collections::VecDeque;

/// Reports in a row that must say Idle at the end.
const IDLE_REPORTS: u32 = 2;

/// Why a line cannot be streamed.
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
#[derive(Clone, Debug, PartialEq)]
pub enum Receipt {
    /// This line was taken.
    Accepted(Flight),
    /// This line was refused; the stream sends nothing more from here on.
    Refused {
        /// The line.
        flight: Flight,
        /// The N of `error:N`.
        code: u16,
    },
    /// An answer although no line is waiting for one: a stray `ok`, or noise made one up.
    Unasked,
    /// Not an answer to a line.
    Push,
}

/// Why a line has to wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waits {
    /// For room in the receive buffer.
    Room,
    /// For the answer to a dangerous line, as it is dangerous itself.
    Danger,
    /// For the answer to a line that changes modes it relies on.
    Modes,
    /// For silence around a line that writes the controller's memory.
    Memory,
    /// For the answer to a line at which the operator is asked for.
    Prompt,
    /// For ever: the stream was interrupted.
    Interrupted,
}

/// A line under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// The line.
    pub line: JobLine,
    /// Its index among the job's lines, `None` for the session's own.
    pub index: Option<usize>,
    /// Its bytes that were written to the port.
    pub written: usize,
}

/// The streamer. Lines go in by [`Stream::push`] when [`Stream::verdict`] allows, their bytes go out by [`Stream::output`] and
/// [`Stream::written`], replies come in by [`Stream::receive`].
#[derive(Clone, Debug)]
pub struct Stream {
    window: usize,
    flights: VecDeque<Flight>,
    in_flight: usize,
    outgoing: VecDeque<u8>,
    interrupted: bool,
    idle_reports: u32,
}

impl Stream {
    /// A stream into a receive buffer of `rx_bytes`.
    pub fn new(rx_bytes: usize) -> Stream {
        Stream {
            window: rx_bytes.saturating_sub(RX_MARGIN),
            flights: VecDeque::new(),
            in_flight: 0,
            outgoing: VecDeque::new(),
            interrupted: false,
            idle_reports: 0,
        }
    }

    /// Whether this line may go out now.
    ///
    /// # Errors
    /// What it waits for.
    pub fn verdict(&self, line: &JobLine) -> Result<(), Waits> {
        if self.interrupted {
            return Err(Waits::Interrupted);
        }
        for flight in &self.flights {
            let (before, now) = (flight.line.weight, line.weight);
            if flight.line.writes_memory {
                return Err(Waits::Memory);
            }
            if flight.line.prompt.is_some() {
                return Err(Waits::Prompt);
            }
            if before.dangerous && now.dangerous {
                return Err(Waits::Danger);
            }
            if before.changes_frame || (before.changes_motion && !now.restates_motion) {
                return Err(Waits::Modes);
            }
        }
        if line.writes_memory && !self.flights.is_empty() {
            return Err(Waits::Memory);
        }
        if self.in_flight + line.bytes() > self.window {
            return Err(Waits::Room);
        }
        Ok(())
    }

    /// Takes a line; it counts as under way from here on. The caller has asked [`Stream::verdict`].
    ///
    /// # Errors
    /// A line that could never fit.
    pub fn push(&mut self, line: JobLine, index: Option<usize>) -> Result<(), StreamError> {
        if line.bytes() > self.window {
            return Err(StreamError::LineTooLong {
                line: line.source,
                bytes: line.bytes(),
                window: self.window,
            });
        }
        self.in_flight += line.bytes();
        self.idle_reports = 0;
        self.outgoing.extend(line.text.as_bytes());
        // A line feed alone: GRBL takes CR LF for two lines and answers twice.
        self.outgoing.push_back(b'\n');
        self.flights.push_back(Flight {
            line,
            index,
            written: 0,
        });
        Ok(())
    }

    /// Bytes not written yet, in order.
    pub fn output(&self) -> impl Iterator<Item = u8> + '_ {
        self.outgoing.iter().copied()
    }

    /// The first `count` bytes of the output were written to the port. Returns the lines whose first byte was among them.
    pub fn written(&mut self, count: usize) -> Vec<(Option<usize>, usize)> {
        let mut count = count.min(self.outgoing.len());
        self.outgoing.drain(..count);
        let mut begun = Vec::new();
        for flight in &mut self.flights {
            if count == 0 {
                break;
            }
            let part = count.min(flight.line.bytes() - flight.written);
            if part > 0 && flight.written == 0 {
                begun.push((flight.index, flight.line.source));
            }
            flight.written += part;
            count -= part;
        }
        begun
    }

    /// Takes in one reply. A refused line interrupts the stream for good.
    pub fn receive(&mut self, reply: &Reply) -> Receipt {
        let code = match reply {
            Reply::Ok => None,
            Reply::Error(code) => Some(*code),
            Reply::Status(status) => {
                let quiet = status.state == State::Idle && self.flights.is_empty();
                self.idle_reports = if quiet { self.idle_reports + 1 } else { 0 };
                return Receipt::Push;
            }
            _ => return Receipt::Push,
        };
        // A line that has not gone out whole cannot have been read.
        let whole = |f: &Flight| f.written == f.line.bytes();
        if !self.flights.front().is_some_and(whole) {
            return Receipt::Unasked;
        }
        let Some(flight) = self.flights.pop_front() else {
            return Receipt::Unasked;
        };
        self.in_flight -= flight.line.bytes();
        match code {
            None => Receipt::Accepted(flight),
            Some(code) => {
                self.interrupt();
                Receipt::Refused { flight, code }
            }
        }
    }

    /// Sends nothing more, whatever arrives. Bytes not written yet are dropped; the reset that follows ends a half line.
    pub fn interrupt(&mut self) {
        self.interrupted = true;
        self.outgoing.clear();
        while self.flights.back().is_some_and(|f| f.written == 0) {
            self.in_flight -= self.flights.pop_back().map_or(0, |f| f.line.bytes());
        }
    }

    /// Bytes the controller may be holding.
    pub fn in_flight(&self) -> usize {
        self.in_flight
    }

    /// The lines under way, oldest first.
    pub fn unanswered(&self) -> impl Iterator<Item = &Flight> {
        self.flights.iter()
    }

    /// Nothing is under way.
    pub fn is_empty(&self) -> bool {
        self.flights.is_empty()
    }

    /// A line that writes the controller's memory is under way: not even a `?` may be sent.
    pub fn writes_memory(&self) -> bool {
        self.flights.iter().any(|f| f.line.writes_memory)
    }

    /// All was answered, and the machine has been Idle in two reports since.
    pub fn is_settled(&self) -> bool {
        !self.interrupted && self.flights.is_empty() && self.idle_reports >= IDLE_REPORTS
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::job::Weight;
    use crate::wire::Status;
    use proptest::prelude::*;

    fn line(length: usize) -> JobLine {
        JobLine {
            source: 1,
            ..JobLine::own(&"X".repeat(length))
        }
    }

    fn send(s: &mut Stream, line: JobLine) -> Result<(), Waits> {
        s.verdict(&line)?;
        s.push(line, Some(0)).unwrap();
        s.written(usize::MAX);
        Ok(())
    }

    #[test]
    fn a_refused_line_ends_the_sending() {
        let mut s = Stream::new(128);
        for n in [10, 10, 10, 60] {
            send(&mut s, line(n)).unwrap();
        }
        assert_eq!(send(&mut s, line(60)), Err(Waits::Room));
        assert!(matches!(s.receive(&Reply::Ok), Receipt::Accepted(_)));
        let refused = s.receive(&Reply::Error(20));
        assert!(matches!(refused, Receipt::Refused { code: 20, .. }));
        assert_eq!(send(&mut s, line(1)), Err(Waits::Interrupted));
        // Lines already in the controller are still answered.
        assert!(matches!(s.receive(&Reply::Ok), Receipt::Accepted(_)));
        assert!(matches!(s.receive(&Reply::Ok), Receipt::Accepted(_)));
        assert_eq!(s.receive(&Reply::Ok), Receipt::Unasked);
        assert!(!s.is_settled());
    }

    #[test]
    fn settled_means_answered_and_idle_twice() {
        let mut s = Stream::new(128);
        let idle = Reply::Status(Status::new(State::Idle));
        send(&mut s, line(5)).unwrap();
        for _ in 0..5 {
            s.receive(&idle); // a dwell is Idle too
        }
        assert!(!s.is_settled());
        s.receive(&Reply::Ok);
        s.receive(&idle);
        s.receive(&Reply::Status(Status::new(State::Run)));
        s.receive(&idle);
        assert!(!s.is_settled());
        s.receive(&idle);
        assert!(s.is_settled());
    }

    #[test]
    fn a_line_that_can_never_fit_is_named() {
        let mut long = line(127);
        long.source = 2;
        let e = Stream::new(128).push(long, None).unwrap_err();
        assert_eq!(
            e.to_string(),
            "line 2 has 128 bytes, but the controller's receive buffer takes 127: shorten the line"
        );
    }

    #[test]
    fn one_dangerous_line_at_a_time_and_nothing_behind_a_change_of_modes() {
        let weight = |dangerous, changes_frame, changes_motion, restates_motion| JobLine {
            weight: Weight {
                dangerous,
                changes_frame,
                changes_motion,
                restates_motion,
            },
            ..line(3)
        };
        let cut = weight(false, false, false, false);
        let restated = weight(false, false, false, true);
        let rapid = weight(true, false, false, true);
        let mut s = Stream::new(128);
        send(&mut s, cut.clone()).unwrap();
        send(&mut s, rapid.clone()).unwrap();
        send(&mut s, cut.clone()).unwrap();
        assert_eq!(send(&mut s, rapid.clone()), Err(Waits::Danger));
        s.receive(&Reply::Ok);
        assert_eq!(send(&mut s, rapid.clone()), Err(Waits::Danger));
        s.receive(&Reply::Ok);
        send(&mut s, rapid.clone()).unwrap();
        // A change of the modal motion holds back the lines that rely on it, and only those.
        let mut s = Stream::new(128);
        send(&mut s, weight(false, false, true, true)).unwrap();
        assert_eq!(send(&mut s, cut.clone()), Err(Waits::Modes));
        send(&mut s, restated.clone()).unwrap();
        // A change of frame holds back all.
        let mut s = Stream::new(128);
        send(&mut s, weight(false, true, false, true)).unwrap();
        assert_eq!(send(&mut s, restated.clone()), Err(Waits::Modes));
        s.receive(&Reply::Ok);
        send(&mut s, restated).unwrap();
        // A memory writer goes alone.
        let mut s = Stream::new(128);
        let writer = JobLine {
            writes_memory: true,
            ..line(3)
        };
        send(&mut s, cut.clone()).unwrap();
        assert_eq!(send(&mut s, writer.clone()), Err(Waits::Memory));
        s.receive(&Reply::Ok);
        send(&mut s, writer).unwrap();
        assert!(s.writes_memory());
        assert_eq!(send(&mut s, cut), Err(Waits::Memory));
    }

    #[test]
    fn what_was_not_written_was_not_sent() {
        let mut s = Stream::new(128);
        for _ in 0..3 {
            s.push(line(4), Some(0)).unwrap();
        }
        assert_eq!(s.written(7).len(), 2);
        assert!(matches!(s.receive(&Reply::Ok), Receipt::Accepted(_)));
        // The second is not out whole: nobody can have read it.
        assert_eq!(s.receive(&Reply::Ok), Receipt::Unasked);
        s.interrupt();
        assert_eq!(s.unanswered().count(), 1);
        assert_eq!((s.in_flight(), s.output().count()), (5, 0));
    }

    proptest! {
        /// Whatever the delays and however few bytes a port takes at once: the ring never overflows, nothing is lost, order is
        /// kept, and the job ends.
        #[test]
        fn counted_bytes_never_overflow_the_ring(
            lengths in proptest::collection::vec(1usize..80, 1..80),
            steps in proptest::collection::vec((0usize..90, 0usize..4), 1..400),
        ) {
            let mut stream = Stream::new(128);
            let mut waiting: VecDeque<usize> = lengths.iter().copied().collect();
            // The far side, reduced to its ring: bytes wait, the oldest whole line is answered when the dice say so.
            let mut ring: VecDeque<u8> = VecDeque::new();
            let mut seen = Vec::new();
            for (write, answer) in steps.into_iter().chain(std::iter::repeat_n((90, 4), 300)) {
                while let Some(n) = waiting.front() && stream.verdict(&line(*n)).is_ok() {
                    stream.push(line(*n), Some(0)).unwrap();
                    waiting.pop_front();
                }
                let bytes: Vec<u8> = stream.output().take(write).collect();
                stream.written(bytes.len());
                ring.extend(bytes);
                prop_assert!(ring.len() <= stream.in_flight() && stream.in_flight() <= 127);
                for _ in 0..answer {
                    if let Some(end) = ring.iter().position(|b| *b == b'\n') {
                        seen.push(end);
                        ring.drain(..=end);
                        prop_assert!(matches!(stream.receive(&Reply::Ok), Receipt::Accepted(_)));
                    }
                }
            }
            prop_assert!(stream.is_empty());
            prop_assert_eq!(seen, lengths);
        }
    }
}
