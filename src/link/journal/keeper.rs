//! Keeps the journal of a running session: hears its news, says what to flush and how far the session may send.
//!
//! ```text
//!   session --news--> Keeper --bytes--> disk
//!      ^                 |
//!      +-- allow_up_to --+   only behind the flush
//! ```

use super::allowance::Allowance;
use super::record::{Begin, Offsets, Record, ToolChange};
use super::writer::Writer;
use crate::link::job::{Job, JobLines, Unreadable};
use crate::link::outcome::{Ending, Outcome};
use crate::link::progress::{Progress, PromptKind};
use std::collections::VecDeque;
use std::time::Duration;

/// What to do now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Turn {
    /// Append these to the journal, first.
    pub bytes: Vec<u8>,
    /// Then let the session send lines of the job below this index ([`crate::link::Session::allow_up_to`]).
    pub allowed: usize,
}

/// The journal of one session.
pub struct Keeper {
    writer: Writer,
    allowance: Allowance,
    /// The job read once more, ahead of the session.
    ahead: JobLines,
    next: Option<(usize, usize)>,
    /// Bytes up to and with each line from `answered` on, as far as they were read ahead.
    ends: VecDeque<usize>,
    total_bytes: usize,
    /// Line of the program of the last line allowed.
    source: usize,
    sent: usize,
    sent_bytes: usize,
    answered: usize,
    answered_bytes: usize,
    change: Option<(usize, u32)>,
    overrides: Option<crate::wire::Overrides>,
}

impl Keeper {
    /// The journal of a session that runs `job`, and its first bytes: they must be on disk before the session starts. Call
    /// [`crate::link::Session::allow_up_to`] with 0 before its first tick.
    ///
    /// # Errors
    /// The program cannot be read any more.
    pub fn new(begin: Begin, job: &Job) -> Result<(Keeper, Vec<u8>), Unreadable> {
        let mut writer = Writer::new();
        let allowance = Allowance::new(begin.rx_bytes);
        writer.note(Record::Begin(Box::new(begin)), Duration::ZERO);
        let first = writer.take();
        let keeper = Keeper {
            writer,
            allowance,
            ahead: job.lines()?,
            next: None,
            ends: VecDeque::new(),
            total_bytes: 0,
            source: 0,
            sent: 0,
            sent_bytes: 0,
            answered: 0,
            answered_bytes: 0,
            change: None,
            overrides: None,
        };
        Ok((keeper, first))
    }

    /// Takes note of what the session tells.
    pub fn hear(&mut self, news: &Progress, now: Duration) {
        let record = match news {
            Progress::Sent(span) => {
                self.sent = self.sent.max(span.lines.end);
                self.sent_bytes = self.end_of(self.sent).unwrap_or(self.sent_bytes);
                Record::Sent { line: span.source }
            }
            Progress::Acknowledged(span) => {
                while self.answered < span.lines.end
                    && let Some(end) = self.ends.pop_front()
                {
                    self.answered += 1;
                    self.answered_bytes = end;
                }
                Record::Acknowledged { line: span.source }
            }
            Progress::Refused { source, code, .. } => Record::Error {
                line: *source,
                code: *code,
            },
            Progress::Report(report) => {
                if let Some(o) = report.overrides
                    && self.overrides != Some(o)
                {
                    self.overrides = Some(o);
                    let (feed, rapid, spindle) = (o.feed, o.rapid, o.spindle);
                    self.writer.note(
                        Record::Override {
                            feed,
                            rapid,
                            spindle,
                        },
                        now,
                    );
                }
                let Some(machine) = report.machine_position else {
                    return;
                };
                Record::Report {
                    state: report.state.text().to_string(),
                    machine,
                    work_offset: report
                        .position
                        .map(|p| std::array::from_fn(|i| machine[i] - p[i])),
                }
            }
            Progress::Prompt(prompt) => {
                if let PromptKind::ToolChange { tool } = prompt.kind {
                    self.change = Some((prompt.source, tool));
                }
                Record::Hold {
                    why: prompt.to_string(),
                }
            }
            Progress::Paused(why) => Record::Hold { why: why.clone() },
            Progress::Resumed => {
                self.tool_changed(None, now);
                Record::Resume
            }
            Progress::Alarm { code } => Record::Alarm { code: *code },
            Progress::Stopping(why) => Record::Stopping { why: why.clone() },
            _ => return,
        };
        self.writer.note(record, now);
    }

    /// The tool change that the session waits at is over, with these offsets if the new tool was measured. Without this call the session's
    /// going on says so, with offsets as they were.
    pub fn tool_changed(&mut self, offsets: Option<Offsets>, now: Duration) {
        if let Some((line, tool)) = self.change.take() {
            let tool = (tool != 0).then_some(tool);
            let change = ToolChange {
                line,
                tool,
                offsets,
            };
            self.writer.note(Record::ToolChange(change), now);
        }
    }

    /// What to flush, and how far the session may send then. Call it before each tick of the session. `behind`: the disk is too far
    /// behind to allow more.
    ///
    /// # Errors
    /// The program cannot be read on.
    pub fn turn(&mut self, now: Duration, behind: bool) -> Result<Turn, Unreadable> {
        let mut bytes = Vec::new();
        if self.writer.due(now) {
            bytes = self.writer.take();
        }
        if !behind {
            let mut failed = None;
            let (ahead, next, ends) = (&mut self.ahead, &mut self.next, &mut self.ends);
            let (total, source) = (&mut self.total_bytes, &mut self.source);
            let more = self
                .allowance
                .extend(self.sent_bytes, self.answered_bytes, |_| {
                    if next.is_none() {
                        match ahead.next_line() {
                            Ok(line) => *next = line.map(|l| (l.bytes(), l.source)),
                            Err(e) => failed = Some(e),
                        }
                    }
                    let (length, line) = next.take()?;
                    *total += length;
                    *source = line;
                    ends.push_back(*total);
                    Some(length)
                });
            if let Some(e) = failed {
                return Err(e);
            }
            if more.is_some() {
                bytes.extend(self.writer.allow(self.source, now));
            }
        }
        Ok(Turn {
            bytes,
            allowed: self.allowance.allowed(),
        })
    }

    /// The session is over: the last bytes.
    pub fn end(&mut self, outcome: &Outcome, now: Duration) -> Vec<u8> {
        if outcome.ending == Ending::ControllerReset {
            self.writer.note(Record::Reset, now);
        }
        self.writer.note(
            Record::End {
                how: outcome.ending.to_string(),
                done: outcome.ending == Ending::Done,
                position_kept: outcome.position_kept || cable_only(outcome),
                at_rest: !cable_only(outcome),
                cable_sound: !matches!(
                    outcome.ending,
                    Ending::Damaged { .. } | Ending::OffPath(_) | Ending::Elsewhere { .. }
                ),
            },
            now,
        );
        self.writer.take()
    }

    fn end_of(&self, lines: usize) -> Option<usize> {
        let at = lines.checked_sub(self.answered + 1)?;
        self.ends.get(at).copied()
    }
}

/// A pulled cable loses no steps: the machine does all it has received, and stands. Whether that is so is seen when it is asked again, by
/// where it says it stands.
fn cable_only(outcome: &Outcome) -> bool {
    matches!(outcome.ending, Ending::Broken(_))
}
