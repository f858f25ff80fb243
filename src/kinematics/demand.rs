//! Whether the link can feed the planner: lines and bytes per second that a program needs against what the cable gives.
//!
//! ```text
//! sender =bytes=> receive buffer (bytes) => planner (blocks) => motion
//! ```
//!
//! A line is sent when it fits into the receive buffer, moves on when the planner has a block free, and is waited for when the machine
//! has finished the one before. Crosses the border: lengths of lines in bytes and their times in s in; rates and waiting out. *Not*
//! modelled: the firmware's time to parse a line (a few ms on 8-bit boards), and that a planner with few blocks in it already slows
//! down before it runs dry.

use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};

/// The cable and the buffers at its far end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feed {
    /// Bytes per second: a tenth of the baud rate.
    pub bytes_per_s: f64,
    /// Receive buffer, bytes.
    pub rx_bytes: usize,
    /// Blocks the planner holds; at least 1.
    pub blocks: usize,
}

/// What a program needs of the link, and whether it gets it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LinkDemand {
    /// Lines per second that 99 of 100 seconds need at most, by windows of 1 s.
    pub lines_per_s_p99: f64,
    /// Lines per second in the busiest second.
    pub lines_per_s_max: f64,
    /// Bytes per second needed by the busiest stretch that is longer than what planner and receive buffer hold.
    pub bytes_per_s_needed: f64,
    /// Bytes per second that the link carries.
    pub bytes_per_s_link: f64,
    /// How long the machine stands waiting for lines, s: at least this, as it slows down before it stands.
    pub starved_s: f64,
    /// The same as a share of the time without waiting.
    pub starved_share: f64,
}

/// A line that moves something, with the bytes of the lines before it that do not.
#[derive(Clone, Copy)]
struct Line {
    bytes: usize,
    time: f64,
}

/// Feeds the lines of a program (bytes with their ends) that take `seconds` (by line, as in [`super::line_times`]) through a link: a fold
/// over [`Demand`].
pub fn link_demand(bytes: impl Iterator<Item = usize>, seconds: &[f64], feed: &Feed) -> LinkDemand {
    let mut demand = Demand::new(feed);
    for (i, bytes) in bytes.enumerate() {
        demand.line(bytes, seconds.get(i).copied().unwrap_or(0.0));
    }
    demand.finish()
}

/// A program's lines, one by one, through a link. Memory: the lines of one second, and those that planner and receive buffer hold.
pub struct Demand {
    bytes_per_s: f64,
    /// Bytes of lines that move nothing: they take the way of the line behind them.
    pending: usize,
    /// Seconds so far.
    total: f64,
    rate: Rate,
    busiest: Busiest,
    waiting: Waiting,
}

impl Demand {
    /// A link that has carried nothing yet.
    pub fn new(feed: &Feed) -> Demand {
        Demand {
            bytes_per_s: feed.bytes_per_s,
            pending: 0,
            total: 0.0,
            rate: Rate::default(),
            busiest: Busiest::new(feed),
            waiting: Waiting::new(feed),
        }
    }

    /// The next line of the program: its bytes, with its end, and the seconds it takes.
    pub fn line(&mut self, bytes: usize, seconds: f64) {
        self.pending += bytes;
        // A pause without end is nothing that a link could be late for.
        if seconds > 0.0 && seconds.is_finite() {
            let line = Line {
                bytes: std::mem::take(&mut self.pending),
                time: seconds,
            };
            let begin = self.total;
            self.total += seconds;
            self.rate.line(begin, self.total);
            self.busiest.line(line);
            self.waiting.line(line);
        }
    }

    /// What they needed, and whether they got it.
    pub fn finish(self) -> LinkDemand {
        let (p99, max) = self.rate.finish();
        let starved = self.waiting.starved;
        LinkDemand {
            lines_per_s_p99: p99,
            lines_per_s_max: max,
            bytes_per_s_needed: self.busiest.finish(),
            bytes_per_s_link: self.bytes_per_s,
            starved_s: starved,
            starved_share: match self.total > 0.0 {
                true => starved / self.total,
                false => 0.0,
            },
        }
    }
}

/// Windows of one second are laid this far apart, s.
const WINDOW_STEP: f64 = 0.1;
/// Windows looked at; no machine runs that long, and whole numbers run out some way behind.
const MOST_WINDOWS: f64 = 1e15;

/// Lines begun per second, by windows of 1 s.
#[derive(Default)]
struct Rate {
    /// Lines so far.
    lines: usize,
    /// Beginnings in the last second, with the number of the first of them: each opens a window that is not over yet.
    open: VecDeque<f64>,
    /// Most lines in a window that is over.
    max: usize,
    /// Beginnings that windows of the raster may still hold.
    begins: VecDeque<f64>,
    /// The next window of the raster.
    window: f64,
    /// Windows of the raster by how many lines begin in them.
    counts: BTreeMap<usize, u64>,
}

impl Rate {
    /// A line from `begin` to `end`, s.
    fn line(&mut self, begin: f64, end: f64) {
        // The busiest window begins with a line.
        while self.open.front().is_some_and(|first| begin >= first + 1.0) {
            self.max = self.max.max(self.open.len());
            self.open.pop_front();
        }
        self.open.push_back(begin);
        self.begins.push_back(begin);
        self.lines += 1;
        // No line to come begins in a window that ends before this line does.
        while self.window < MOST_WINDOWS && self.window * WINDOW_STEP + 1.0 <= end {
            let start = self.window * WINDOW_STEP;
            while self.begins.front().is_some_and(|t| *t < start) {
                self.begins.pop_front();
            }
            if self.begins.is_empty() {
                return self.quiet(end);
            }
            *self.counts.entry(self.begins.len()).or_default() += 1;
            self.window += 1.0;
        }
        if self.window >= MOST_WINDOWS {
            self.begins.clear();
        }
    }

    /// No line begins in the windows of the raster from the next one on to `end`.
    fn quiet(&mut self, end: f64) {
        let over = |k: f64| k * WINDOW_STEP + 1.0 <= end;
        let guess = ((end - 1.0) / WINDOW_STEP).floor();
        let mut next = guess.max(self.window).min(MOST_WINDOWS);
        while next < MOST_WINDOWS && over(next) {
            next += 1.0;
        }
        while next > self.window && !over(next - 1.0) {
            next -= 1.0;
        }
        let n = self.counts.entry(0).or_default();
        // Saturates.
        *n = n.saturating_add((next - self.window) as u64);
        self.window = next;
    }

    /// The 99th percentile and the highest.
    fn finish(self) -> (f64, f64) {
        let max = self.max.max(self.open.len());
        let all: u128 = self.counts.values().map(|n| u128::from(*n)).sum();
        let mut below = all * 99 / 100;
        let mut p99 = max;
        for (lines, n) in self.counts {
            if below < u128::from(n) {
                p99 = lines;
                break;
            }
            below -= u128::from(n);
        }
        (p99 as f64, max as f64)
    }
}

/// Bytes per second over stretches just longer than what is buffered.
struct Busiest {
    blocks: usize,
    rx_bytes: usize,
    /// Lines from the beginning of the present stretch on.
    lines: VecDeque<Line>,
    /// The first stretch is not over.
    first: bool,
    /// How many of them the stretch holds so far, and their bytes and seconds.
    taken: usize,
    bytes: usize,
    time: f64,
    /// Bytes of the lines that the planner holds at its beginning.
    planned: usize,
    most: f64,
}

impl Busiest {
    fn new(feed: &Feed) -> Busiest {
        Busiest {
            blocks: feed.blocks.max(1),
            rx_bytes: feed.rx_bytes,
            lines: VecDeque::new(),
            first: true,
            taken: 0,
            bytes: 0,
            time: 0.0,
            planned: 0,
            most: 0.0,
        }
    }

    fn line(&mut self, line: Line) {
        if self.lines.len() < self.blocks {
            self.planned += line.bytes;
        }
        self.lines.push_back(line);
        // The planner's blocks, and behind them more than the receive buffer holds.
        while let Some(next) = self.lines.get(self.taken) {
            if self.taken < self.blocks || self.bytes <= self.planned.saturating_add(self.rx_bytes)
            {
                self.taken += 1;
                self.bytes += next.bytes;
                self.time += next.time;
            } else {
                self.over();
            }
        }
    }

    /// The stretch is over, and the next begins one line later.
    fn over(&mut self) {
        self.rank();
        let Some(gone) = self.lines.pop_front() else {
            return;
        };
        self.first = false;
        self.taken -= 1;
        self.bytes -= gone.bytes;
        self.time -= gone.time;
        self.planned -= gone.bytes;
        self.planned += self.lines.get(self.blocks - 1).map_or(0, |l| l.bytes);
    }

    fn rank(&mut self) {
        let rate = self.bytes as f64 / f64::max(self.time, 1e-9);
        self.most = self.most.max(rate);
    }

    fn finish(mut self) -> f64 {
        // A program that fits into the buffers is one stretch.
        if self.first && self.taken > 0 {
            self.rank();
        }
        self.most
    }
}

/// Time the machine waits for lines after the first one.
struct Waiting {
    feed: Feed,
    /// Lines that may still be in the receive buffer: when each has left it, and its bytes.
    received: VecDeque<(f64, usize)>,
    /// Their bytes.
    bytes: usize,
    /// When the motions of the last lines end, as many as there are blocks.
    ended: VecDeque<f64>,
    /// When the last line was sent, and when the planner took it, s.
    sent: f64,
    planned: f64,
    starved: f64,
}

impl Waiting {
    fn new(feed: &Feed) -> Waiting {
        Waiting {
            feed: *feed,
            received: VecDeque::new(),
            bytes: 0,
            ended: VecDeque::new(),
            sent: 0.0,
            planned: 0.0,
            starved: 0.0,
        }
    }

    fn line(&mut self, l: Line) {
        // Senders hold a line back until it fits behind those that have not been taken out.
        let mut free_at = 0.0_f64;
        while self.bytes + l.bytes > self.feed.rx_bytes
            && let Some((left, bytes)) = self.received.pop_front()
        {
            free_at = left;
            self.bytes -= bytes;
        }
        self.bytes += l.bytes;
        self.sent = self.sent.max(free_at) + l.bytes as f64 / self.feed.bytes_per_s.max(1e-9);
        let last_end = self.ended.back().copied();
        let room_at = match self.ended.len() >= self.feed.blocks.max(1) {
            true => self.ended.pop_front().unwrap_or(0.0),
            false => 0.0,
        };
        self.planned = self.sent.max(room_at).max(self.planned);
        let last_end = last_end.unwrap_or(self.planned);
        self.starved += (self.planned - last_end).max(0.0);
        self.ended.push_back(self.planned.max(last_end) + l.time);
        self.received.push_back((self.planned, l.bytes));
    }
}

#[cfg(test)]
#[path = "demand_tests.rs"]
mod tests;
