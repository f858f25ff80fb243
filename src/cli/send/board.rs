//! What the operator sees of a job, as values: the news folded into a board, and the board as lines of text.

use super::eta::{TimeTable, clock};
use crate::link::{Known, Progress, Report};
use crate::wire::{State, Status};
use std::collections::VecDeque;
use std::time::Duration;

/// Rows of log shown.
const LOG: usize = 6;
/// Lines of log kept, to be told once the screen has gone: the first and the newest.
const KEPT_FIRST: usize = 50;
const KEPT_LAST: usize = 200;
/// Characters of the bar.
const BAR: usize = 24;
/// A screen narrower than this gets short lines.
const NARROW: usize = 60;

/// The keys, as shown.
pub const KEYS: [&str; 2] = [
    "space/h hold   r resume   x stop   d door   s spindle off/on in hold   f flood   m mist",
    "+ - feed 10 %   . , feed 1 %   0 feed 100 %   1 2 3 rapid 25 50 100 %   ] [ spindle 10 %",
];
/// The keys while the machine is in the operator's hands.
pub const HAND_KEYS: [&str; 2] = [
    "arrows jog X Y   PgUp PgDn jog Z   , . smaller larger step   space stops   r go on   x stop",
    "X Y Z zero that axis here   H home before the start   p measure tool",
];

/// What the operator may do by hand now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InHand {
    /// Jog step, mm.
    pub step: f64,
}

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
    /// The news.
    pub log: VecDeque<String>,
    /// Lines of the log left out between the first and the newest.
    pub left_out: usize,
    /// The machine is in the operator's hands.
    pub hand: Option<InHand>,
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
        self.keep(text.clone());
        Some(text)
    }

    /// One more line of the log.
    pub fn keep(&mut self, text: String) {
        self.log.push_back(text);
        if self.log.len() > KEPT_FIRST + KEPT_LAST {
            self.log.remove(KEPT_FIRST);
            self.left_out += 1;
        }
    }

    /// The whole log, for when the screen has gone.
    pub fn whole_log(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.log.iter().cloned().collect();
        if self.left_out > 0 {
            let at = KEPT_FIRST.min(lines.len());
            lines.insert(at, format!("... {} lines left out ...", self.left_out));
        }
        lines
    }

    /// A report of an errand: where the machine stands, whatever the job does.
    pub fn look(&mut self, status: &Status, known: &Known) {
        let unit = if known.inches { 25.4 } else { 1.0 };
        let before = self.report.take();
        let (overrides, accessories) = before.as_ref().map_or((None, String::new()), |r| {
            (r.overrides, r.accessories.clone())
        });
        let told = status.overrides.is_some();
        self.report = Some(Report {
            sent: before.as_ref().map_or(0, |r| r.sent),
            acknowledged: before.as_ref().map_or(0, |r| r.acknowledged),
            total: before.as_ref().map_or(0, |r| r.total),
            source: before.as_ref().map_or(0, |r| r.source),
            state: status.state.clone(),
            position: known.work_position(),
            machine_position: known.machine_position,
            feed: status.feed.map(|f| f * unit),
            speed: status.speed,
            overrides: status.overrides.or(overrides),
            accessories: if told {
                status.accessories.clone()
            } else {
                accessories
            },
            pins: status.pins.clone(),
            buffer: status.buffer,
            in_flight: 0,
        });
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

    /// The screen, line by line: none wider than `width`, not more than `rows`. What matters least is left out first.
    pub fn draw(&self, width: usize, rows: usize) -> Vec<String> {
        // How much each line matters: 0 stays longest.
        let mut lines: Vec<(u8, String)> = vec![
            (6, format!("{}   {}", self.title, self.version)),
            (9, String::new()),
        ];
        match &self.report {
            None => lines.push((0, "waiting for the controller".to_string())),
            Some(r) => self.state(r, width, &mut lines),
        }
        lines.push((9, String::new()));
        let attention = self.attention.as_ref().or(self.stall.as_ref());
        let asked = attention.map_or(String::new(), |text| format!(">>> {text}"));
        let importance = if asked.is_empty() { 9 } else { 1 };
        lines.extend(wrap(&asked, width).into_iter().map(|l| (importance, l)));
        lines.push((9, String::new()));
        let mut log: Vec<String> = Vec::new();
        for line in self.log.iter().rev().take(LOG) {
            log.extend(wrap(line, width).into_iter().rev());
        }
        log.truncate(LOG);
        let empty = LOG - log.len();
        for (age, line) in log.into_iter().enumerate().rev() {
            // The newest is worth more than the keys, the older ones are not.
            lines.push((if age == 0 { 3 } else { 8 }, line));
        }
        lines.extend(std::iter::repeat_n((9, String::new()), empty));
        let keys = if self.hand.is_some() { HAND_KEYS } else { KEYS };
        for line in keys {
            lines.extend(wrap(line, width).into_iter().map(|l| (5, l)));
        }
        fit(lines, rows).iter().map(|l| cut(l, width)).collect()
    }

    fn state(&self, r: &Report, width: usize, lines: &mut Vec<(u8, String)>) {
        let share = match r.total {
            0 => 0.0,
            n => (r.acknowledged as f64 / n as f64).clamp(0.0, 1.0),
        };
        let left = clock(self.left_s());
        if width < NARROW {
            lines.push((
                0,
                format!("{} {:.0}% {left} left", r.state.text(), share * 100.0),
            ));
            let p = r.position.or(r.machine_position).unwrap_or_default();
            lines.push((2, format!("X{:.2} Y{:.2}", p[0] + 0.0, p[1] + 0.0)));
            lines.push((2, format!("Z{:.2}", p[2] + 0.0)));
            lines.push((4, format!("line {}", r.source)));
            if let Some(hand) = self.hand {
                lines.push((3, format!("step {} mm", hand.step)));
            }
            return;
        }
        let full = (share * BAR as f64) as usize;
        lines.push((
            0,
            format!(
                "{:<8} line {} of the program   [{}{}] {:.0} %   {left} left",
                r.state.text(),
                r.source,
                "#".repeat(full),
                "-".repeat(BAR - full),
                share * 100.0,
            ),
        ));
        lines.push((9, String::new()));
        lines.push((2, format!("work     {}", place(r.position))));
        lines.push((4, format!("machine  {}", place(r.machine_position))));
        let percent = |f: fn(crate::wire::Overrides) -> u16| {
            r.overrides.map_or("-".to_string(), |o| f(o).to_string())
        };
        lines.push((
            4,
            format!(
                "feed {:>7.0} mm/min ({} %)   rapid {} %   spindle {:>6.0} rpm ({} %)   on: {}",
                r.feed.unwrap_or(0.0),
                percent(|o| o.feed),
                percent(|o| o.rapid),
                r.speed.unwrap_or(0.0),
                percent(|o| o.spindle),
                accessories(&r.accessories),
            ),
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
        let line = match self.hand {
            Some(hand) => format!("by hand  jog step {} mm{pins}", hand.step),
            None => format!(
                "buffer   {} of {} bytes under way{planner}{pins}",
                r.in_flight, self.rx_bytes
            ),
        };
        lines.push((4, line));
    }
}

/// The lines that fit, in their order: those that matter least go first, of equals the last.
fn fit(mut lines: Vec<(u8, String)>, rows: usize) -> Vec<String> {
    while lines.len() > rows {
        let worst = lines.iter().map(|l| l.0).max().unwrap_or(0);
        let Some(at) = lines.iter().rposition(|l| l.0 == worst) else {
            break;
        };
        lines.remove(at);
    }
    lines.into_iter().map(|l| l.1).collect()
}

/// Rows of at most `width` characters, broken between words where there are any. A row at least.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let width = width.max(1);
    let mut rows = vec![String::new()];
    if text.chars().count() <= width {
        return vec![text.to_string()];
    }
    for word in text.split_inclusive(' ') {
        let room = |row: &String| width.saturating_sub(row.chars().count());
        let bare = word.trim_end().chars().count();
        if rows.last().is_some_and(|r| !r.is_empty() && room(r) < bare) {
            rows.push(String::new());
        }
        for c in word.chars() {
            if rows.last().is_some_and(|r| room(r) == 0) {
                if c == ' ' {
                    continue;
                }
                rows.push(String::new());
            }
            if let Some(row) = rows.last_mut() {
                row.push(c);
            }
        }
    }
    rows
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
        let shown = board().draw(100, 24).join("\n");
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
        assert!(b.draw(200, 24).contains(&format!(">>> {told}")));
        for width in [0, 1, 20, 79] {
            assert!(b.draw(width, 24).iter().all(|l| l.chars().count() <= width));
        }
        b.hear(&Progress::Resumed, Duration::from_secs(3));
        assert!(!b.draw(200, 24).iter().any(|l| l.starts_with(">>>")));
    }

    #[test]
    fn a_small_window_shows_what_matters() {
        let mut b = board();
        assert_eq!(
            b.draw(20, 5).join("\n"),
            "Run 25% 0:00 left\nX12.50 Y-3.25\nZ0.00\nline 31\noff [2J"
        );
        b.attention = Some("on hold, at rest: resume or stop".into());
        let shown = b.draw(20, 5);
        assert_eq!(
            shown,
            [
                "Run 25% 0:00 left",
                "X12.50 Y-3.25",
                "Z0.00",
                ">>> on hold, at",
                "rest: resume or stop"
            ]
        );
        for (width, rows) in [(1, 1), (5, 2), (20, 5), (40, 9), (79, 3), (200, 60)] {
            let shown = b.draw(width, rows);
            assert!(shown.len() <= rows && shown.iter().all(|l| l.chars().count() <= width));
        }
        assert!(b.draw(80, 0).is_empty());
    }

    #[test]
    fn long_lines_of_the_log_go_on_in_the_next_row_and_none_is_lost() {
        assert_eq!(wrap("aa bb cc", 5), ["aa bb", "cc"]);
        assert_eq!(wrap("aaaaaaa b", 3), ["aaa", "aaa", "a b"]);
        assert_eq!(wrap("", 3), [""]);
        let mut b = board();
        for i in 0..400 {
            b.hear(&Progress::Note(format!("n{i}")), Duration::from_secs(1));
        }
        let log = b.whole_log();
        assert_eq!(log.len(), KEPT_FIRST + KEPT_LAST + 1);
        assert!(log[0].contains("laser mode") && log.last().unwrap() == "note: n399");
        assert!(log.contains(&"... 151 lines left out ...".to_string()));
    }

    #[test]
    fn by_hand_the_keys_are_others() {
        let mut b = board();
        b.hand = Some(InHand { step: 0.1 });
        let shown = b.draw(100, 24).join("\n");
        assert!(
            shown.contains("by hand  jog step 0.1 mm   pins P"),
            "{shown}"
        );
        assert!(shown.contains(HAND_KEYS[0]) && !shown.contains(KEYS[0]));
    }

    #[test]
    fn progress_in_a_line() {
        assert_eq!(
            board().progress().unwrap(),
            "Run  25 of 100 lines  X12.50 Y-3.25 Z0.00  0:00 left"
        );
        assert_eq!(Board::default().progress(), None);
        assert_eq!(
            Board::default().draw(80, 24)[2],
            "waiting for the controller"
        );
    }
}
