//! What the operator sees of a job, as values: the news folded into a board, and the board as lines of text.

use super::eta::{TimeTable, clock};
use crate::link::{Progress, Report};
use crate::wire::State;
use std::collections::VecDeque;
use std::time::Duration;

/// Lines of log kept.
const LOG: usize = 6;
/// Characters of the bar.
const BAR: usize = 24;

/// The keys, as shown.
pub const KEYS: [&str; 2] = [
    "space/h hold   r resume   x stop   d door   s spindle off/on in hold   f flood   m mist",
    "+ - feed 10 %   . , feed 1 %   0 feed 100 %   1 2 3 rapid 25 50 100 %   ] [ spindle 10 %",
];

/// Everything on the screen.
#[derive(Clone, Debug, Default)]
pub struct Board {
    /// Program and machine.
    pub title: String,
    /// What the controller says it is.
    pub version: String,
    /// Bytes of receive buffer.
    pub rx_bytes: usize,
    /// Planner blocks, if told.
    pub blocks: Option<usize>,
    /// Planned times.
    pub times: TimeTable,
    /// Planned seconds before the first line sent (a resume).
    pub from_s: f64,
    /// The last report.
    pub report: Option<Report>,
    /// What waits for the operator, or hinders.
    pub attention: Option<String>,
    /// A stall told.
    pub stall: Option<String>,
    /// The last news.
    pub log: VecDeque<String>,
    /// Seconds of motion, pauses left out.
    pub running_s: f64,
    /// When the last report came.
    pub last: Option<Duration>,
}

impl Board {
    /// Takes in news at `now`. Returns a line worth keeping, for those without a screen.
    pub fn hear(&mut self, news: &Progress, now: Duration) -> Option<String> {
        let text = match news {
            Progress::Connected(known) => {
                self.version.clone_from(&known.version);
                (self.rx_bytes, self.blocks) = (known.rx_bytes, known.blocks);
                format!(
                    "connected: {}, {} bytes of buffer",
                    known.version, known.rx_bytes
                )
            }
            Progress::Note(text) => format!("note: {text}"),
            Progress::Refused {
                source, text, code, ..
            } => format!("line {source} (`{text}`): error:{code}"),
            Progress::Report(report) => {
                let moving = matches!(report.state, State::Run | State::Idle);
                if let Some(last) = self.last
                    && moving
                {
                    self.running_s += now.saturating_sub(last).as_secs_f64();
                }
                self.last = Some(now);
                self.report = Some((**report).clone());
                return None;
            }
            Progress::Adjusted {
                confirmed: true, ..
            } => return None,
            Progress::Adjusted { what, .. } => {
                format!("note: {what:?} was sent, but the reports do not show it")
            }
            Progress::Prompt(prompt) => {
                self.attention = Some(prompt.to_string());
                prompt.to_string()
            }
            Progress::Paused(text) => {
                self.attention = Some(text.clone());
                text.clone()
            }
            Progress::Resumed => {
                self.attention = None;
                "resumed".to_string()
            }
            Progress::Stall(stall) => {
                self.stall = stall.as_ref().map(ToString::to_string);
                return None;
            }
            Progress::Alarm { code } => format!("ALARM:{code}"),
            Progress::Stopping(why) => {
                self.attention = Some("stopping: feed hold, standstill, reset".to_string());
                format!("{why}: feed hold, then standstill, then reset")
            }
            Progress::ClockJump { by_s } => {
                format!(
                    "note: the computer slept or its clock was set: {by_s:+.1} s. Look at the machine"
                )
            }
            Progress::Unplugged {
                source: Some((a, b)),
            } => {
                format!("the port broke: the controller may still carry out lines {a} to {b}")
            }
            Progress::Unplugged { source: None } => "the port broke".to_string(),
            Progress::Started { .. } | Progress::Sent(_) | Progress::Acknowledged(_) => {
                return None;
            }
        };
        self.log.push_back(text.clone());
        if self.log.len() > LOG {
            self.log.pop_front();
        }
        Some(text)
    }

    /// Seconds left, by the planner and the pace so far.
    pub fn left_s(&self) -> f64 {
        let line = self.report.as_ref().map_or(0, |r| r.source);
        self.times.left(line, self.from_s, self.running_s)
    }

    /// One line of progress, for those without a screen.
    pub fn progress(&self) -> Option<String> {
        let r = self.report.as_ref()?;
        let place = r.position.map_or(String::new(), |p| {
            format!("  X{:.2} Y{:.2} Z{:.2}", p[0] + 0.0, p[1] + 0.0, p[2] + 0.0)
        });
        Some(format!(
            "{}  {} of {} lines{place}  {} left",
            r.state.text(),
            r.acknowledged,
            r.total,
            clock(self.left_s())
        ))
    }

    /// The screen, line by line, none wider than `width`.
    pub fn draw(&self, width: usize) -> Vec<String> {
        let mut lines = vec![format!("{}   {}", self.title, self.version), String::new()];
        match &self.report {
            None => lines.push("waiting for the controller".to_string()),
            Some(r) => {
                let share = match r.total {
                    0 => 0.0,
                    n => (r.acknowledged as f64 / n as f64).clamp(0.0, 1.0),
                };
                let full = (share * BAR as f64) as usize;
                lines.push(format!(
                    "{:<8} line {} of the program   [{}{}] {:.0} %   {} left",
                    r.state.text(),
                    r.source,
                    "#".repeat(full),
                    "-".repeat(BAR - full),
                    share * 100.0,
                    clock(self.left_s()),
                ));
                lines.push(String::new());
                lines.push(format!("work     {}", place(r.position)));
                lines.push(format!("machine  {}", place(r.machine_position)));
                let percent = |f: fn(crate::wire::Overrides) -> u16| {
                    r.overrides.map_or("-".to_string(), |o| f(o).to_string())
                };
                lines.push(format!(
                    "feed {:>7.0} mm/min ({} %)   rapid {} %   spindle {:>6.0} rpm ({} %)   on: {}",
                    r.feed.unwrap_or(0.0),
                    percent(|o| o.feed),
                    percent(|o| o.rapid),
                    r.speed.unwrap_or(0.0),
                    percent(|o| o.spindle),
                    accessories(&r.accessories),
                ));
                let planner = match (r.buffer, self.blocks) {
                    (Some(b), Some(all)) => format!("   planner {} of {all} blocks free", b.blocks),
                    (Some(b), None) => format!("   planner {} blocks free", b.blocks),
                    _ => String::new(),
                };
                let pins = if r.pins.is_empty() {
                    String::new()
                } else {
                    format!("   pins {}", r.pins)
                };
                lines.push(format!(
                    "buffer   {} of {} bytes under way{planner}{pins}",
                    r.in_flight, self.rx_bytes
                ));
            }
        }
        lines.push(String::new());
        let attention = self.attention.as_ref().or(self.stall.as_ref());
        lines.push(attention.map_or(String::new(), |text| format!(">>> {text}")));
        lines.push(String::new());
        let empty = LOG - self.log.len().min(LOG);
        lines.extend(self.log.iter().cloned());
        lines.extend(std::iter::repeat_n(String::new(), empty));
        lines.extend(KEYS.map(str::to_string));
        lines.into_iter().map(|l| cut(&l, width)).collect()
    }
}

fn place(p: Option<[f64; 3]>) -> String {
    match p {
        // Adding zero turns a negative zero into a plain one.
        Some([x, y, z]) => format!(
            "X{:>10.3} Y{:>10.3} Z{:>10.3} mm",
            x + 0.0,
            y + 0.0,
            z + 0.0
        ),
        None => "not reported yet".to_string(),
    }
}

fn accessories(letters: &str) -> String {
    let words: Vec<&str> = letters
        .chars()
        .filter_map(|c| match c {
            'S' => Some("spindle"),
            'C' => Some("spindle reversed"),
            'F' => Some("flood"),
            'M' => Some("mist"),
            _ => None,
        })
        .collect();
    if words.is_empty() {
        "-".to_string()
    } else {
        words.join(" ")
    }
}

/// At most `width` characters, without anything that a terminal would act on.
fn cut(line: &str, width: usize) -> String {
    let plain = line.chars().map(|c| if c.is_control() { ' ' } else { c });
    plain.take(width).collect::<String>().trim_end().to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::{Prompt, PromptKind};
    use crate::wire::{Buffer, Overrides};

    fn board() -> Board {
        let mut b = Board {
            title: "part.nc on LongMill".into(),
            version: "1.1h".into(),
            rx_bytes: 128,
            blocks: Some(15),
            ..Board::default()
        };
        let report = Report {
            sent: 30,
            acknowledged: 25,
            total: 100,
            source: 31,
            state: State::Run,
            position: Some([12.5, -3.25, -0.0]),
            machine_position: Some([-100.0, -50.0, -20.125]),
            feed: Some(800.0),
            speed: Some(12000.0),
            overrides: Some(Overrides {
                feed: 110,
                rapid: 50,
                spindle: 100,
            }),
            accessories: "SF".into(),
            pins: "P".into(),
            buffer: Some(Buffer {
                blocks: 3,
                bytes: 12,
            }),
            in_flight: 118,
        };
        b.hear(&Progress::Report(Box::new(report)), Duration::from_secs(1));
        b.hear(
            &Progress::Note("laser mode is off\u{1b}[2J".into()),
            Duration::from_secs(1),
        );
        b
    }

    #[test]
    fn the_screen() {
        let shown = board().draw(100).join("\n");
        let golden = "\
part.nc on LongMill   1.1h

Run      line 31 of the program   [######------------------] 25 %   0:00 left

work     X    12.500 Y    -3.250 Z     0.000 mm
machine  X  -100.000 Y   -50.000 Z   -20.125 mm
feed     800 mm/min (110 %)   rapid 50 %   spindle  12000 rpm (100 %)   on: spindle flood
buffer   118 of 128 bytes under way   planner 3 of 15 blocks free   pins P



note: laser mode is off [2J





space/h hold   r resume   x stop   d door   s spindle off/on in hold   f flood   m mist
+ - feed 10 %   . , feed 1 %   0 feed 100 %   1 2 3 rapid 25 50 100 %   ] [ spindle 10 %";
        assert_eq!(shown, golden);
    }

    #[test]
    fn what_waits_for_the_operator_stands_out_and_no_line_is_too_wide() {
        let mut b = board();
        let prompt = Prompt {
            source: 40,
            kind: PromptKind::ToolChange { tool: 3 },
            text: Some("ball 6".into()),
        };
        let told = b
            .hear(&Progress::Prompt(prompt), Duration::from_secs(2))
            .unwrap();
        assert_eq!(
            told,
            "line 40: change to tool 3 (ball 6): resume when ready"
        );
        assert!(b.draw(200).contains(&format!(">>> {told}")));
        for width in [0, 1, 20, 79] {
            assert!(b.draw(width).iter().all(|l| l.chars().count() <= width));
        }
        b.hear(&Progress::Resumed, Duration::from_secs(3));
        assert!(!b.draw(200).iter().any(|l| l.starts_with(">>>")));
    }

    #[test]
    fn progress_in_a_line() {
        assert_eq!(
            board().progress().unwrap(),
            "Run  25 of 100 lines  X12.50 Y-3.25 Z0.00  0:00 left"
        );
        assert_eq!(Board::default().progress(), None);
        assert_eq!(Board::default().draw(80)[2], "waiting for the controller");
    }
}
