//! One line and its answer: by which rule it is sent, and what was heard until it was answered.

use super::error::ErrandError;
use crate::link::introduction::Known;
use crate::wire::{Reply, Status};
use std::time::Duration;

/// How a line is sent and waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Answered at once; nothing moves. No reports are asked for meanwhile: a quiet line is easier to read in a log.
    Plain,
    /// Writes the controller's EEPROM, which loses bytes that arrive meanwhile: everything answered and 50 ms of quiet before,
    /// no question until the answer, 50 ms of quiet after (GRBL, issue 165 of gnea/grbl: seen even with one line at a time).
    Writer,
    /// One blocking call, during which the firmware answers nothing, not even `?` (homing). Only a reset interrupts it.
    Silent(Duration),
    /// Moves the machine or waits for it: reports are asked for; the answer may take as long as they come.
    Motion,
    /// A jog: as [`Rule::Motion`], but stopped by the jog-cancel byte instead of hold and reset.
    Jog,
}

/// A line to send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// Its characters without line end.
    pub text: String,
    /// How.
    pub rule: Rule,
}

/// What was heard from the sending of a line to its answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heard {
    /// The line sent.
    pub text: String,
    /// Lines as received, without status reports and without the answer itself.
    pub lines: Vec<String>,
    /// The same, read.
    pub replies: Vec<Reply>,
    /// The N of `error:N`, if it was refused.
    pub refused: Option<u16>,
}

/// Lines kept of one answer: no firmware says as much, and a stream of noise must not eat the memory.
pub(super) const MOST_LINES: usize = 4000;

impl Heard {
    /// What belongs to the answer of `text`.
    pub(super) fn of(text: &str) -> Heard {
        Heard {
            text: text.to_string(),
            ..Heard::default()
        }
    }

    pub(super) fn take(&mut self, line: &str, reply: &Reply) {
        if self.lines.len() < MOST_LINES {
            self.lines.push(line.to_string());
            self.replies.push(reply.clone());
        }
    }
}

/// What a task sees when it is asked what to do next.
#[derive(Debug)]
pub struct Situation<'a> {
    /// The controller: state and position as last reported.
    pub known: &'a Known,
    /// The last report, if any came since the introduction and since the last line that moves was sent.
    pub status: Option<&'a Status>,
    /// The last answer.
    pub heard: &'a Heard,
    /// Notes for the operator may be added here.
    pub notes: &'a mut Vec<String>,
}

/// What to do next.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Send a line and wait for its answer.
    Send(Exchange),
    /// Wait until the machine is Idle in two reports, with its position.
    Settle,
    /// Nothing for now: ask again when something arrived.
    Listen,
    /// A real-time byte of the operator's wish (a console, a held key).
    Byte(u8),
    /// The task is done.
    Done,
}

impl Step {
    /// A line by a rule.
    pub fn send(text: impl Into<String>, rule: Rule) -> Step {
        Step::Send(Exchange {
            text: text.into(),
            rule,
        })
    }
}

/// What an errand is for: a list of steps that depends on the answers.
pub trait Task: std::fmt::Debug {
    /// What to do next. Asked when nothing is under way: first after the introduction, then after each step.
    ///
    /// # Errors
    /// The task cannot go on; motion under way is stopped first.
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError>;

    /// True for a task that goes on after a refused line, an alarm or a reset (a console): they are told, not ended by.
    fn carries_on(&self) -> bool {
        false
    }

    /// What an alarm with this number means here, beyond the table's words.
    fn alarm_advice(&self, _code: u16) -> &'static str {
        ""
    }

    /// True for a task whose controller may not answer at first, being in ALARM:1 or 2: one reset may wake it.
    fn may_reset_the_mute(&self) -> bool {
        false
    }
}

/// What the operator hears.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// The controller has introduced itself.
    Connected(Box<Known>),
    /// Something worth knowing.
    Note(String),
    /// A line was sent.
    Sent(String),
    /// A line came back: as received, and read. A status report is told by [`News::Report`], too.
    Said(String, Box<Reply>),
    /// A report came in.
    Report(Box<Status>, Box<Known>),
    /// A stop has begun, and why.
    Stopping(String),
}

/// A number as a controller reads it: at most four decimals, no exponent, no negative zero.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" | "" => "0".to_string(),
        _ => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_what_a_controller_reads() {
        for (value, text) in [
            (1.0, "1"),
            (-0.00001, "0"),
            (0.125, "0.125"),
            (-12.5, "-12.5"),
            (1e6, "1000000"),
            (10.0, "10"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
