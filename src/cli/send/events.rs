//! `--events`: one JSON object a line, one line an event. Stable: keys are added, never renamed; units are in the names.
//!
//! ```text
//! {"t_s":0.812,"event":"connected","version":"1.1h.20190830:","rx_bytes":128,"planner_blocks":15}
//! {"t_s":0.813,"event":"started","lines_total":5000,"planned_s":1234.5}
//! {"t_s":1.020,"event":"report","state":"Run","line":12,...}
//! {"t_s":9.100,"event":"ended","result":"done","message":"done",...}
//! ```
//! With `--events` and without a terminal, lines on standard input are commands: `resume` answers a prompt (M0, a tool change) and a
//! `confirm`; `hold`, `stop`, `door`, `feed+10` and so on as the keys. `t_s` counts from the opening of the port. The last line is always `ended`.

use crate::link::{Outcome, Progress, PromptKind, Stall};
use serde::Serialize;

/// One line of the stream.
#[derive(Debug, Serialize)]
pub struct Line {
    /// Seconds since the port was opened.
    pub t_s: f64,
    /// What.
    #[serde(flatten)]
    pub event: Event,
}

/// What happened. Lines are lines of the program, from 1; counts are lines sent to the controller.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum Event {
    Connected {
        version: String,
        firmware: &'static str,
        rx_bytes: usize,
        planner_blocks: Option<usize>,
    },
    Note {
        text: String,
    },
    Started {
        lines_total: usize,
        planned_s: f64,
    },
    Sent {
        lines_sent: usize,
        line: usize,
    },
    Acknowledged {
        lines_acknowledged: usize,
        line: usize,
    },
    Refused {
        line: usize,
        text: String,
        code: u16,
    },
    Report {
        state: String,
        line: usize,
        lines_sent: usize,
        lines_acknowledged: usize,
        work_position_mm: Option<[f64; 3]>,
        machine_position_mm: Option<[f64; 3]>,
        feed_mm_per_min: Option<f64>,
        spindle_rpm: Option<f64>,
        feed_override_percent: Option<u16>,
        rapid_override_percent: Option<u16>,
        spindle_override_percent: Option<u16>,
        accessories: String,
        pins: String,
        planner_blocks_free: Option<usize>,
        in_flight_bytes: usize,
        left_s: f64,
    },
    Adjusted {
        what: String,
        confirmed: bool,
    },
    Prompt {
        kind: &'static str,
        line: usize,
        tool: Option<u32>,
        text: Option<String>,
    },
    /// A measured tool: `resume` goes on with it.
    Confirm {
        text: String,
    },
    Paused {
        text: String,
    },
    Resumed,
    Stall {
        /// Null once lines are answered again.
        kind: Option<&'static str>,
        text: String,
    },
    Alarm {
        code: u16,
    },
    Stopping {
        why: String,
    },
    ClockJump {
        by_s: f64,
    },
    Unplugged {
        first_line: Option<usize>,
        last_line: Option<usize>,
    },
    Ended {
        result: String,
        message: String,
        lines_sent: usize,
        lines_acknowledged: usize,
        work_position_mm: Option<[f64; 3]>,
        position_kept: bool,
    },
}

/// The event of a piece of news; `left_s` and `planned_s` are the planner's.
pub fn of(news: &Progress, planned_s: f64, left_s: f64) -> Event {
    match news {
        Progress::Connected(known) => Event::Connected {
            version: known.version.clone(),
            firmware: known.firmware.title(),
            rx_bytes: known.rx_bytes,
            planner_blocks: known.blocks,
        },
        Progress::Note(text) => Event::Note { text: text.clone() },
        Progress::Started { total } => Event::Started {
            lines_total: *total,
            planned_s: round(planned_s),
        },
        Progress::Sent(span) => Event::Sent {
            lines_sent: span.lines.end,
            line: span.source,
        },
        Progress::Acknowledged(span) => Event::Acknowledged {
            lines_acknowledged: span.lines.end,
            line: span.source,
        },
        Progress::Refused {
            source, text, code, ..
        } => Event::Refused {
            line: *source,
            text: text.clone(),
            code: *code,
        },
        Progress::Report(r) => Event::Report {
            state: r.state.text().to_string(),
            line: r.source,
            lines_sent: r.sent,
            lines_acknowledged: r.acknowledged,
            work_position_mm: r.position,
            machine_position_mm: r.machine_position,
            feed_mm_per_min: r.feed,
            spindle_rpm: r.speed,
            feed_override_percent: r.overrides.map(|o| o.feed),
            rapid_override_percent: r.overrides.map(|o| o.rapid),
            spindle_override_percent: r.overrides.map(|o| o.spindle),
            accessories: r.accessories.clone(),
            pins: r.pins.clone(),
            planner_blocks_free: r.buffer.map(|b| b.blocks),
            in_flight_bytes: r.in_flight,
            left_s: round(left_s),
        },
        Progress::Adjusted { what, confirmed } => Event::Adjusted {
            what: snake(&format!("{what:?}")),
            confirmed: *confirmed,
        },
        Progress::Prompt(prompt) => Event::Prompt {
            kind: match prompt.kind {
                PromptKind::Pause => "pause",
                PromptKind::ToolChange { .. } => "tool_change",
            },
            line: prompt.source,
            tool: match prompt.kind {
                PromptKind::ToolChange { tool } => Some(tool),
                PromptKind::Pause => None,
            },
            text: prompt.text.clone(),
        },
        Progress::Paused(text) => Event::Paused { text: text.clone() },
        Progress::Resumed => Event::Resumed,
        Progress::Stall(stall) => Event::Stall {
            kind: stall.as_ref().map(kind),
            text: stall.as_ref().map_or_else(String::new, ToString::to_string),
        },
        Progress::Alarm { code } => Event::Alarm { code: *code },
        Progress::Stopping(why) => Event::Stopping { why: why.clone() },
        Progress::ClockJump { by_s } => Event::ClockJump { by_s: round(*by_s) },
        Progress::Unplugged { source } => Event::Unplugged {
            first_line: source.map(|s| s.0),
            last_line: source.map(|s| s.1),
        },
    }
}

/// The last event.
pub fn ended(outcome: &Outcome) -> Event {
    Event::Ended {
        result: outcome.ending.key(),
        message: outcome.ending.to_string(),
        lines_sent: outcome.sent,
        lines_acknowledged: outcome.acknowledged,
        work_position_mm: outcome.position,
        position_kept: outcome.position_kept,
    }
}

fn kind(stall: &Stall) -> &'static str {
    match stall {
        Stall::Hold => "hold",
        Stall::Door => "door",
        Stall::Prompt => "prompt",
        Stall::PlannerFull { .. } => "planner_full",
        Stall::Waiting { .. } => "waiting",
        Stall::Permission => "journal",
        Stall::Stuck { .. } => "stuck",
        Stall::LostAcknowledgement { .. } => "lost_acknowledgement",
        Stall::ControllerReset => "controller_reset",
        Stall::LinkDead => "link_dead",
    }
}

/// Milliseconds are enough.
pub fn round(seconds: f64) -> f64 {
    (seconds * 1e3).round() / 1e3
}

/// `FeedPlus10` as `feed_plus10`.
fn snake(name: &str) -> String {
    let mut out = String::new();
    for (i, c) in name.char_indices() {
        if c.is_ascii_uppercase() && i > 0 {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::{Prompt, Report, Span};
    use crate::wire::{Buffer, Overrides, Realtime, State};

    fn json(news: &Progress) -> String {
        serde_json::to_string(&Line {
            t_s: 1.5,
            event: of(news, 100.0, 42.1234),
        })
        .unwrap()
    }

    #[test]
    fn the_schema() {
        let report = Report {
            sent: 12,
            acknowledged: 10,
            total: 50,
            source: 17,
            state: State::Run,
            position: Some([1.0, 2.0, -0.5]),
            machine_position: None,
            feed: Some(800.0),
            speed: None,
            overrides: Some(Overrides {
                feed: 110,
                rapid: 100,
                spindle: 100,
            }),
            accessories: "SF".into(),
            pins: String::new(),
            buffer: Some(Buffer {
                blocks: 3,
                bytes: 12,
            }),
            in_flight: 99,
        };
        assert_eq!(
            json(&Progress::Report(Box::new(report))),
            r#"{"t_s":1.5,"event":"report","state":"Run","line":17,"lines_sent":12,"lines_acknowledged":10,"work_position_mm":[1.0,2.0,-0.5],"machine_position_mm":null,"feed_mm_per_min":800.0,"spindle_rpm":null,"feed_override_percent":110,"rapid_override_percent":100,"spindle_override_percent":100,"accessories":"SF","pins":"","planner_blocks_free":3,"in_flight_bytes":99,"left_s":42.123}"#
        );
        assert_eq!(
            json(&Progress::Sent(Span {
                lines: 3..5,
                source: 9
            })),
            r#"{"t_s":1.5,"event":"sent","lines_sent":5,"line":9}"#
        );
        let prompt = Prompt {
            source: 4,
            kind: PromptKind::ToolChange { tool: 2 },
            text: Some("ball 6".into()),
        };
        assert_eq!(
            json(&Progress::Prompt(prompt)),
            r#"{"t_s":1.5,"event":"prompt","kind":"tool_change","line":4,"tool":2,"text":"ball 6"}"#
        );
        assert_eq!(
            json(&Progress::Stall(Some(Stall::PlannerFull { line: 3 }))),
            r#"{"t_s":1.5,"event":"stall","kind":"planner_full","text":"line 3 waits for the motion before it: the planner is full"}"#
        );
        assert_eq!(
            json(&Progress::Stall(None)),
            r#"{"t_s":1.5,"event":"stall","kind":null,"text":""}"#
        );
        assert_eq!(
            json(&Progress::Adjusted {
                what: Realtime::FeedPlus10,
                confirmed: true
            }),
            r#"{"t_s":1.5,"event":"adjusted","what":"feed_plus10","confirmed":true}"#
        );
        assert_eq!(json(&Progress::Resumed), r#"{"t_s":1.5,"event":"resumed"}"#);
        assert_eq!(
            json(&Progress::Started { total: 7 }),
            r#"{"t_s":1.5,"event":"started","lines_total":7,"planned_s":100.0}"#
        );
        assert_eq!(
            json(&Progress::Unplugged {
                source: Some((3, 8))
            }),
            r#"{"t_s":1.5,"event":"unplugged","first_line":3,"last_line":8}"#
        );
    }
}
