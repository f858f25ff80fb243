//! Events and time in, bytes of the journal out.

use super::line::encode;
use super::record::{Record, Stamped};
use crate::wire::State;
use std::time::Duration;

/// A record is in the operating system's hands at most this long after it was made, if [`Writer::due`] is heeded.
pub const FLUSH_WITHIN: Duration = Duration::from_millis(100);
/// Status reports kept: at most one in this time while the state stays the same (and, at rest, the place: it is where a resume looks for
/// the machine).
const REPORT_EVERY: Duration = Duration::from_millis(500);

/// Turns what happens into a journal. Of lines sent and answered between two flushes only the last ones are written, as ranges are told by
/// their end; an eight-hour job stays under a few dozen megabytes.
#[derive(Clone, Debug, Default)]
pub struct Writer {
    next: u64,
    bytes: Vec<u8>,
    oldest: Option<Duration>,
    sent: Option<(Duration, usize)>,
    acknowledged: Option<(Duration, usize)>,
    last_report: Option<(Duration, String, [f64; 3])>,
    ended: bool,
}

impl Writer {
    /// An empty journal.
    pub fn new() -> Writer {
        Writer::default()
    }

    /// Takes note of what happened at `now` (since the job began). Lines of 0 (the sender's own) are nothing to note, figures that are
    /// no numbers cannot be written, and nothing follows [`Record::End`]: such records are dropped.
    pub fn note(&mut self, record: Record, now: Duration) {
        if self.ended || !record.is_sound() {
            return;
        }
        match record {
            Record::Sent { line: 0 } | Record::Acknowledged { line: 0 } => {}
            Record::Sent { line } => {
                let first = self.sent.map_or(now, |s| s.0);
                self.sent = Some((first, line));
                self.oldest.get_or_insert(now);
            }
            Record::Acknowledged { line } => {
                let first = self.acknowledged.map_or(now, |s| s.0);
                self.acknowledged = Some((first, line));
                self.oldest.get_or_insert(now);
            }
            Record::Report {
                ref state, machine, ..
            } => {
                let same = self
                    .last_report
                    .as_ref()
                    .is_some_and(|(at, before, place)| {
                        before == state
                            && now.saturating_sub(*at) < REPORT_EVERY
                            && (machine == *place || !State::parse(state).at_rest())
                    });
                if !same {
                    self.last_report = Some((now, state.clone(), machine));
                    self.write(record, now);
                }
            }
            Record::End { .. } => {
                self.write(record, now);
                self.ended = true;
            }
            _ => self.write(record, now),
        }
    }

    /// Allows the lines up to this one: flush what this returns before the first of their bytes goes out.
    #[must_use = "the lines are allowed only once these bytes are flushed"]
    pub fn allow(&mut self, line: usize, now: Duration) -> Vec<u8> {
        self.note(Record::Allow { line }, now);
        self.take()
    }

    /// True when a record has waited long enough: time to [`Writer::take`] and flush. Ask at least every few milliseconds.
    pub fn due(&self, now: Duration) -> bool {
        // Half of the promise, so that a caller who looks rarely still keeps it.
        self.ended && self.oldest.is_some()
            || self
                .oldest
                .is_some_and(|t| now.saturating_sub(t) >= FLUSH_WITHIN / 2)
    }

    /// The bytes to append to the journal; empty when nothing is new.
    pub fn take(&mut self) -> Vec<u8> {
        self.settle();
        self.oldest = None;
        std::mem::take(&mut self.bytes)
    }

    /// Ranges that were held back go out in the order of things: sent, then answered.
    fn settle(&mut self) {
        if let Some((at, line)) = self.sent.take() {
            self.encode(Record::Sent { line }, at);
        }
        if let Some((at, line)) = self.acknowledged.take() {
            self.encode(Record::Acknowledged { line }, at);
        }
    }

    fn write(&mut self, record: Record, now: Duration) {
        self.settle();
        self.encode(record, now);
        self.oldest.get_or_insert(now);
    }

    fn encode(&mut self, record: Record, at: Duration) {
        // Milliseconds are enough, and readable.
        let t = (at.as_secs_f64() * 1e3).round() / 1e3;
        encode(self.next, &Stamped { t, record }, &mut self.bytes);
        self.next += 1;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn ms(n: u64) -> Duration {
        Duration::from_millis(n)
    }

    fn text(w: &mut Writer) -> String {
        String::from_utf8(w.take()).unwrap()
    }

    #[test]
    fn ranges_are_told_by_their_end_and_times_by_their_beginning() {
        let mut w = Writer::new();
        for line in 1..=9 {
            w.note(Record::Sent { line }, ms(line as u64));
        }
        w.note(Record::Acknowledged { line: 3 }, ms(7));
        w.note(Record::Acknowledged { line: 0 }, ms(8));
        assert!(!w.due(ms(40)) && w.due(ms(51)));
        let said = text(&mut w);
        let mut lines = said.lines();
        assert!(
            lines
                .next()
                .unwrap()
                .ends_with(r#" {"t":0.001,"event":"sent","line":9}"#),
            "{said}"
        );
        assert!(
            lines
                .next()
                .unwrap()
                .ends_with(r#" {"t":0.007,"event":"acknowledged","line":3}"#),
            "{said}"
        );
        assert_eq!(lines.next(), None);
        assert!(!w.due(ms(1000)) && w.take().is_empty());
    }

    #[test]
    fn what_came_before_a_record_stands_before_it() {
        let mut w = Writer::new();
        w.note(Record::Sent { line: 5 }, ms(1));
        w.note(Record::Alarm { code: 1 }, ms(2));
        w.note(Record::Sent { line: 6 }, ms(3));
        let said = String::from_utf8(w.allow(12, ms(4))).unwrap();
        let order: Vec<&str> = said.lines().map(|l| l.split('"').nth(5).unwrap()).collect();
        assert_eq!(order, ["sent", "alarm", "sent", "allow"]);
    }

    #[test]
    fn reports_are_few_and_nothing_follows_the_end() {
        let mut w = Writer::new();
        let report = |state: &str| Record::Report {
            state: state.into(),
            machine: [0.0; 3],
            work_offset: None,
        };
        for i in 0..100 {
            w.note(report("Run"), ms(20 * i));
        }
        w.note(report("Idle"), ms(1990));
        assert_eq!(text(&mut w).lines().count(), 4 + 1);
        // At rest, another place is news however soon.
        for x in [0.0, 0.0, 1.0, 1.0] {
            let machine = [x, 0.0, 0.0];
            let (state, work_offset) = ("Idle".into(), None);
            let place = Record::Report {
                state,
                machine,
                work_offset,
            };
            w.note(place, ms(2000));
        }
        assert_eq!(text(&mut w).lines().count(), 1);
        let bad = [f64::NAN, 0.0, 0.0];
        w.note(
            Record::Report {
                state: "Alarm".into(),
                machine: bad,
                work_offset: None,
            },
            ms(5000),
        );
        assert!(w.take().is_empty());
        w.note(
            Record::End {
                how: "done".into(),
                done: true,
                position_kept: true,
                at_rest: true,
                cable_sound: true,
            },
            ms(6000),
        );
        assert!(w.due(ms(6000)));
        w.note(Record::Sent { line: 1 }, ms(6001));
        w.note(Record::Resume, ms(6001));
        assert_eq!(text(&mut w).lines().count(), 1);
    }
}
