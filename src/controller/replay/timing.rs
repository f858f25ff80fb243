//! Programs against the clock: streamed by character counting, without any delay on the host's side.

use crate::controller::{Build, Controller, Memory};
use std::collections::VecDeque;

/// What a program did.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// From the first motion to the last, s.
    pub motion_s: f64,
    /// Lines that were refused.
    pub errors: usize,
    /// Machine position at the end, as reports write it.
    pub end_mpos: String,
}

/// Why a program could not be timed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TimingError {
    /// The controller stopped answering.
    #[error(
        "line {line}: no answer after {seconds} s of machine time: the program holds (M0), or an alarm ended it"
    )]
    Silent {
        /// Line of the program, from 1.
        line: usize,
        /// How long was waited.
        seconds: u32,
    },
    /// A line longer than the receive buffer.
    #[error("line {line}: longer than the controller's receive buffer: it cannot be sent")]
    TooLong {
        /// Line of the program, from 1.
        line: usize,
    },
}

/// How long one line may take, machine time, s.
const PATIENCE: f64 = 3600.0;

/// Streams a program through a controller with these settings.
///
/// # Errors
/// A program that does not run to its end.
pub fn time_program(memory: Memory, build: Build, program: &str) -> Result<Timed, TimingError> {
    let mut c = Controller::with_build(memory, build);
    c.advance(0.1);
    c.output();
    let mut host = Host::default();
    for (index, line) in program.lines().enumerate() {
        let (line, bytes) = (index + 1, format!("{}\n", line.trim_end()));
        if bytes.len() > build.rx_bytes {
            return Err(TimingError::TooLong { line });
        }
        while host.waiting.iter().sum::<usize>() + bytes.len() > build.rx_bytes {
            host.wait(&mut c, line)?;
        }
        c.feed(bytes.as_bytes());
        host.waiting.push_back(bytes.len());
        host.listen(&mut c);
    }
    while !host.waiting.is_empty() {
        host.wait(&mut c, program.lines().count())?;
    }
    while let Some(at) = c.next_change() {
        c.advance((at - c.now()).max(1e-4));
    }
    let p = c.position_in_steps();
    Ok(Timed {
        motion_s: c.elapsed(),
        errors: host.errors,
        end_mpos: format!("{:.3},{:.3},{:.3}", p.x + 0.0, p.y + 0.0, p.z + 0.0),
    })
}

#[derive(Default)]
struct Host {
    waiting: VecDeque<usize>,
    heard: Vec<u8>,
    errors: usize,
}

impl Host {
    /// Until something is said.
    fn wait(&mut self, c: &mut Controller, line: usize) -> Result<(), TimingError> {
        let (before, begun) = (self.waiting.len(), c.now());
        while self.waiting.len() == before {
            let at = c.next_change().filter(|at| *at < begun + PATIENCE);
            let at = at.ok_or(TimingError::Silent {
                line,
                seconds: PATIENCE as u32,
            })?;
            c.advance((at - c.now()).max(1e-6));
            self.listen(c);
        }
        Ok(())
    }

    fn listen(&mut self, c: &mut Controller) {
        self.heard.extend(c.output());
        while let Some(end) = self.heard.iter().position(|b| *b == b'\n') {
            let line: Vec<u8> = self.heard.drain(..=end).collect();
            let error = line.starts_with(b"error:");
            if error || line == b"ok\r\n" {
                self.errors += usize::from(error);
                self.waiting.pop_front();
            }
        }
    }
}
