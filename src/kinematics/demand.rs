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

use crate::units::Seconds;
use serde::Serialize;

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

/// Windows are laid this far apart, s, and at most so many of them.
const WINDOW_STEP: f64 = 0.1;
const MOST_WINDOWS: f64 = 1e6;

/// A line that moves something, with the bytes of the lines before it that do not.
#[derive(Clone, Copy)]
struct Line {
    bytes: usize,
    time: f64,
}

/// Feeds the lines of a program (bytes with their ends) that take `seconds` (by line, as in [`super::Times::per_line`]) through a link.
/// Linear in the number of lines.
pub fn link_demand(bytes: impl Iterator<Item = usize>, seconds: &[f64], feed: &Feed) -> LinkDemand {
    let mut lines: Vec<Line> = Vec::new();
    let mut pending = 0;
    for (i, b) in bytes.enumerate() {
        pending += b;
        let time = seconds.get(i).copied().unwrap_or(0.0);
        if time > 0.0 {
            lines.push(Line {
                bytes: pending,
                time,
            });
            pending = 0;
        }
    }
    let (p99, max) = lines_per_second(&lines);
    let Seconds(starved) = starved(&lines, feed);
    let total: f64 = lines.iter().map(|l| l.time).sum();
    LinkDemand {
        lines_per_s_p99: p99,
        lines_per_s_max: max,
        bytes_per_s_needed: busiest_bytes(&lines, feed),
        bytes_per_s_link: feed.bytes_per_s,
        starved_s: starved,
        starved_share: if total > 0.0 { starved / total } else { 0.0 },
    }
}

/// Lines begun per second, by windows of 1 s: the 99th percentile and the highest.
fn lines_per_second(lines: &[Line]) -> (f64, f64) {
    let mut begins = Vec::with_capacity(lines.len());
    let mut total = 0.0;
    for l in lines {
        begins.push(total);
        total += l.time;
    }
    // The busiest window begins with a line.
    let mut max = 0;
    let mut end = 0;
    for (i, b) in begins.iter().enumerate() {
        while begins.get(end).is_some_and(|t| *t < b + 1.0) {
            end += 1;
        }
        max = max.max(end - i);
    }
    let step = WINDOW_STEP.max(total / MOST_WINDOWS);
    let (mut from, mut to, mut k) = (0, 0, 0.0);
    let mut counts: Vec<usize> = Vec::new();
    while k * step + 1.0 <= total {
        let start = k * step;
        while begins.get(from).is_some_and(|t| *t < start) {
            from += 1;
        }
        while begins.get(to).is_some_and(|t| *t < start + 1.0) {
            to += 1;
        }
        counts.push(to - from);
        k += 1.0;
    }
    counts.sort_unstable();
    let p99 = counts.get(counts.len() * 99 / 100).copied().unwrap_or(max);
    (p99 as f64, max as f64)
}

/// Bytes per second over stretches just longer than what is buffered.
fn busiest_bytes(lines: &[Line], feed: &Feed) -> f64 {
    let mut most: f64 = 0.0;
    let (mut end, mut bytes, mut time) = (0, 0usize, 0.0);
    for (i, first) in lines.iter().enumerate() {
        // The planner's blocks, and behind them more than the receive buffer holds.
        let planned: usize = lines
            .iter()
            .skip(i)
            .take(feed.blocks.max(1))
            .map(|l| l.bytes)
            .sum();
        while end < lines.len()
            && (end < i + feed.blocks.max(1) || bytes <= planned + feed.rx_bytes)
        {
            bytes += lines[end].bytes;
            time += lines[end].time;
            end += 1;
        }
        if end < lines.len() || i == 0 {
            most = most.max(bytes as f64 / f64::max(time, 1e-9));
        }
        bytes -= first.bytes;
        time -= first.time;
    }
    most
}

/// Time the machine waits for lines after the first one.
fn starved(lines: &[Line], feed: &Feed) -> Seconds {
    let blocks = feed.blocks.max(1);
    let n = lines.len();
    // When a line has left the receive buffer, and when its motion ends.
    let mut planned = vec![0.0; n];
    let mut ended = vec![0.0; n];
    let mut sent = 0.0_f64;
    // Lines from `oldest` on may still be in the receive buffer.
    let (mut oldest, mut waiting) = (0, 0usize);
    let mut starved = 0.0;
    for (i, l) in lines.iter().enumerate() {
        // Senders hold a line back until it fits behind those that have not been taken out.
        let mut free_at = 0.0_f64;
        while oldest < i && waiting + l.bytes > feed.rx_bytes {
            free_at = planned[oldest];
            waiting -= lines[oldest].bytes;
            oldest += 1;
        }
        waiting += l.bytes;
        sent = sent.max(free_at) + l.bytes as f64 / feed.bytes_per_s.max(1e-9);
        let before = i.checked_sub(1);
        let room_at = i.checked_sub(blocks).map_or(0.0, |k| ended[k]);
        let behind = before.map_or(0.0, |k| planned[k]);
        planned[i] = sent.max(room_at).max(behind);
        let last_end = before.map_or(planned[i], |k| ended[k]);
        starved += (planned[i] - last_end).max(0.0);
        ended[i] = planned[i].max(last_end) + l.time;
    }
    Seconds(starved)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn feed(bytes_per_s: f64) -> Feed {
        Feed {
            bytes_per_s,
            rx_bytes: 128,
            blocks: 15,
        }
    }

    #[test]
    fn even_lines_by_hand() {
        // 1000 lines of 20 bytes, 10 ms each: 100 lines/s, 2000 bytes/s.
        let times = vec![0.01; 1000];
        let d = link_demand((0..1000).map(|_| 20), &times, &feed(11_520.0));
        assert!((d.lines_per_s_max - 100.0).abs() <= 1.0, "{d:?}");
        assert!((d.lines_per_s_p99 - 100.0).abs() <= 1.0, "{d:?}");
        assert!((d.bytes_per_s_needed - 2000.0).abs() < 1.0, "{d:?}");
        assert_eq!(d.starved_s, 0.0);
        // Half of what is needed: the machine waits as long as it moves, less what is in the buffers at the end.
        let d = link_demand((0..1000).map(|_| 20), &times, &feed(1000.0));
        assert!((d.starved_s - 10.0).abs() < 0.1, "{d:?}");
        assert!((d.starved_share - 1.0).abs() < 0.01);
    }

    #[test]
    fn buffers_carry_a_short_burst_and_no_long_one() {
        // Slow lines, then a burst of fast ones, then slow again. 11.52 kB/s carries 576 lines of 20 bytes a second.
        let program = |burst: usize| -> Vec<f64> {
            let mut t = vec![0.1; 40];
            t.extend(vec![0.001; burst]);
            t.extend(vec![0.1; 40]);
            t
        };
        let run = |burst: usize| {
            let t = program(burst);
            link_demand(t.iter().map(|_| 20), &t, &feed(11_520.0))
        };
        assert_eq!(run(15).starved_s, 0.0);
        let d = run(400);
        assert!(
            d.starved_s > 0.2 && d.bytes_per_s_needed > 11_520.0,
            "{d:?}"
        );
    }

    #[test]
    fn nothing_needs_nothing() {
        let d = link_demand(std::iter::empty(), &[], &feed(11_520.0));
        assert_eq!(
            (d.lines_per_s_max, d.bytes_per_s_needed, d.starved_s),
            (0.0, 0.0, 0.0)
        );
        // Comments take the way of the line behind them.
        let d = link_demand([60, 20].into_iter(), &[0.0, 2.0], &feed(11_520.0));
        assert_eq!((d.lines_per_s_max, d.bytes_per_s_needed), (1.0, 40.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
        /// A faster link never makes the machine wait longer, and one fast enough for every line by itself never at all.
        #[test]
        fn faster_is_never_worse(t in proptest::collection::vec((0.0005..0.05f64, 5usize..60), 1..300), speed in 500.0..20_000.0f64) {
            let times: Vec<f64> = t.iter().map(|x| x.0).collect();
            let bytes = || t.iter().map(|x| x.1);
            let slow = link_demand(bytes(), &times, &feed(speed));
            let fast = link_demand(bytes(), &times, &feed(1.5 * speed));
            prop_assert!(fast.starved_s <= slow.starved_s + 1e-9);
            prop_assert_eq!(fast.lines_per_s_max, slow.lines_per_s_max);
            let enough = t.iter().map(|x| x.1 as f64 / x.0).fold(0.0, f64::max);
            // The first line behind a stand must not come late either: as long as the link is never slower than the machine.
            prop_assert!(link_demand(bytes(), &times, &feed(60.0 / 0.0005 + enough)).starved_s < 1e-9);
        }
    }
}
