//! Settings, and if wanted work offsets and start-up lines, from a file into the controller: only what differs, each checked before the
//! first is written, written one at a time, all read back. G28 and G30 cannot be written: the firmware stores them only where it stands.
//!
//! GRBL stores a 300 into eight bits as a 44 without a word, so values are checked here and not left to the firmware.

use super::error::ErrandError;
use super::exchange::{Exchange, Rule, Situation, Step, Task, number};
use super::jog::ready;
use super::saved::{plain, same};
use super::zero::READ_BACK;
use crate::link::introduction::Known;
use crate::machine::settings_file::SettingsFile;
use crate::wire::{Firmware, LINE_CHARS, Reply, State};

/// Settings after which a position means another place.
const MOVES_THE_ORIGIN: [u16; 7] = [3, 22, 23, 27, 100, 101, 102];

/// Farther than any machine goes, mm.
const FARTHEST: f64 = 20_000.0;

/// The errand.
#[derive(Clone, Debug, Default)]
pub struct Restore {
    /// What the controller shall have: number and value as text.
    pub wanted: Vec<(u16, String)>,
    /// Work offsets it shall have: from 0 for G54, machine coordinates, mm.
    pub offsets: Vec<(usize, [f64; 3])>,
    /// Start-up lines it shall have: 0 or 1, and the line.
    pub startup: Vec<(usize, String)>,
    plan: Option<Vec<Exchange>>,
    settings: Vec<(u16, String)>,
    lines: usize,
    step: usize,
    /// Settings that were written, in order.
    pub written: Vec<(u16, String)>,
    /// Lines that were written besides: offsets, start-up lines.
    pub besides: Vec<String>,
}

impl Restore {
    /// The controller shall have these settings.
    pub fn new(wanted: Vec<(u16, String)>) -> Restore {
        Restore {
            wanted,
            ..Restore::default()
        }
    }

    /// What would be written to this controller, in the order in which it takes them.
    ///
    /// # Errors
    /// A value that this controller must not be given.
    pub fn plan(
        wanted: &[(u16, String)],
        known: &Known,
    ) -> Result<Vec<(u16, String)>, ErrandError> {
        let mut plan = Vec::new();
        for (number, value) in wanted {
            check(*number, value, known).map_err(ErrandError::NotPossible)?;
            let has = known.setting(*number).map(|v| v.to_string());
            if !has.is_some_and(|has| same(*number, &has, value)) {
                plan.push((*number, value.clone()));
            }
        }
        together(&plan, known).map_err(ErrandError::NotPossible)?;
        // Soft limits need homing ($20 after $22), and switching homing off clears them by itself.
        plan.sort_by_key(|(n, _)| match n {
            22 => (0, *n),
            _ => (1, *n),
        });
        Ok(plan)
    }

    /// A start-up line that may be written.
    ///
    /// # Errors
    /// It moves the machine, or has characters that cannot travel.
    pub fn startup_line(number: usize, text: &str) -> Result<String, ErrandError> {
        let wrong = |why: &str| {
            Err(ErrandError::NotPossible(format!(
                "start-up line $N{number}: {why}"
            )))
        };
        let line = format!("$N{number}={}", plain(text));
        if !line
            .bytes()
            .all(|b| b > b' ' && b < 0x7F && !b"?~!;()%/".contains(&b))
            || number > 1
            || line.len() > LINE_CHARS
        {
            return wrong("it has characters that cannot travel in a $ line, or is too long");
        }
        let moves = plain(text).contains(['X', 'Y', 'Z', 'A', 'B', 'C'])
            || ["G28", "G30"].iter().any(|g| plain(text).contains(g));
        match moves {
            true => wrong(
                "it moves the machine, and the controller runs it at once and at every start: if you mean it, type it in `morsemill console`",
            ),
            false => Ok(line),
        }
    }

    /// Everything to send before it is read back.
    fn lines(&mut self, known: &Known) -> Result<Vec<Exchange>, ErrandError> {
        let mut lines = Vec::new();
        for (system, o) in &self.offsets {
            if *system > 5 || !o.iter().all(|c| c.is_finite() && c.abs() <= FARTHEST) {
                return Err(ErrandError::NotPossible(format!(
                    "G{}: the offset is farther than any machine goes ({FARTHEST} mm)",
                    54 + system
                )));
            }
            let [x, y, z] = o.map(number);
            lines.push(format!("G21G10L2P{}X{x}Y{y}Z{z}", system + 1));
        }
        for (n, text) in &self.startup {
            lines.push(Restore::startup_line(*n, text)?);
        }
        let settings = Self::plan(&self.wanted, known)?;
        if !lines.is_empty() {
            ready(known, "writing offsets and start-up lines", &[State::Idle])?;
        } else if known.state != State::Alarm {
            ready(known, "writing settings", &[State::Idle])?;
        }
        let (any_settings, any_lines) = (!settings.is_empty(), lines.len());
        self.settings.clone_from(&settings);
        self.lines = any_lines;
        let settings = settings.iter().map(|(n, v)| format!("${n}={v}"));
        let writers = settings.chain(lines).map(|text| Exchange {
            text,
            rule: Rule::Writer,
        });
        let mut plan: Vec<Exchange> = writers.collect();
        let ask = |text: &str| Exchange {
            text: text.to_string(),
            rule: Rule::Plain,
        };
        if any_settings {
            plan.push(ask("$$"));
        }
        if !self.offsets.is_empty() {
            plan.push(ask("$#"));
        }
        if !self.startup.is_empty() {
            plan.push(ask("$N"));
        }
        if !self.offsets.is_empty() && known.modes.has("G20") {
            plan.push(ask("G20"));
        }
        Ok(plan)
    }

    /// Compares an answer with what was written.
    fn compare(&self, now: &Situation<'_>) -> Result<(), ErrandError> {
        let heard = now.heard;
        let wrong = |what: String, wanted: String, found: Option<String>| {
            Err(ErrandError::ReadBack {
                what,
                wanted,
                found: found.unwrap_or("nothing".to_string()),
            })
        };
        match heard.text.as_str() {
            "$$" => {
                for (number, wanted) in &self.written {
                    let found = heard.replies.iter().find_map(|r| match r {
                        Reply::Setting { number: n, value } if n == number => Some(value.trim()),
                        _ => None,
                    });
                    if !found.is_some_and(|found| same(*number, found, wanted)) {
                        return wrong(
                            format!("${number}"),
                            wanted.clone(),
                            found.map(str::to_string),
                        );
                    }
                }
            }
            "$#" => {
                // $13 may just have been written.
                let inch = self.written.iter().find(|w| w.0 == 13).map(|w| w.1 == "1");
                let unit = if inch.unwrap_or(now.known.inches) {
                    25.4
                } else {
                    1.0
                };
                for (system, wanted) in &self.offsets {
                    let name = format!("G{}", 54 + system);
                    let found = heard.replies.iter().find_map(|r| match r {
                        Reply::Offset { name: n, values } if *n == name => {
                            Some(values.map(|v| v * unit))
                        }
                        _ => None,
                    });
                    let close = |f: [f64; 3]| {
                        (0..3)
                            .all(|i| (f[i] - wanted[i]).abs() <= READ_BACK + wanted[i].abs() * 1e-6)
                    };
                    if !found.is_some_and(close) {
                        let words = |p: [f64; 3]| p.map(number).join(" ");
                        return wrong(name, words(*wanted), found.map(words));
                    }
                }
            }
            "$N" => {
                for (n, wanted) in &self.startup {
                    let head = format!("$N{n}=");
                    let found = heard.lines.iter().find_map(|l| l.strip_prefix(&head));
                    if found.is_none_or(|f| plain(f) != plain(wanted)) {
                        return wrong(format!("$N{n}"), plain(wanted), found.map(str::to_string));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }
}

impl Task for Restore {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        if self.plan.is_none() {
            self.plan = Some(self.lines(now.known)?);
        }
        let plan = self.plan.as_deref().unwrap_or_default();
        if self.step > 0 {
            self.compare(now)?;
        }
        if let Some(exchange) = plan.get(self.step) {
            let exchange = exchange.clone();
            if let Some(setting) = self.settings.get(self.step) {
                self.written.push(setting.clone());
            } else if self.step < self.settings.len() + self.lines {
                self.besides.push(exchange.text.clone());
            }
            self.step += 1;
            return Ok(Step::Send(exchange));
        }
        if self
            .written
            .iter()
            .any(|(n, _)| MOVES_THE_ORIGIN.contains(n))
        {
            now.notes.push(
                "the position means another place now: home again and set zero anew".to_string(),
            );
        }
        if self.written.iter().any(|(n, _)| matches!(n, 4 | 5)) {
            now.notes.push(
                "$4 and $5 are safe only after a reset: switch the controller off and on"
                    .to_string(),
            );
        }
        Ok(Step::Done)
    }
}

/// A value that may be written to this controller.
pub(super) fn check(number: u16, value: &str, known: &Known) -> Result<(), String> {
    let line = format!("${number}={value}");
    let plain = value
        .bytes()
        .all(|b| b > b' ' && b < 0x7F && !b"?~!;()$%/".contains(&b));
    if !plain || value.is_empty() || line.len() > LINE_CHARS {
        return Err(format!(
            "${number}: the value has characters that cannot travel in a $ line"
        ));
    }
    if !known.settings.is_empty() && known.setting(number).is_none() {
        return Err(format!(
            "${number}: this controller has no such setting: take the line out of the file"
        ));
    }
    match known.firmware {
        Firmware::Grbl11 | Firmware::Unknown => {
            SettingsFile::read("setting", &line).map_err(|e| {
                match e.to_string().split_once(' ') {
                    // Its place is a file of one line that nobody has.
                    Some((place, words)) if place.starts_with("setting") => words.to_string(),
                    _ => e.to_string(),
                }
            })?;
            Ok(())
        }
        // Their ranges differ by build, and they check what they are given. A number must still be one.
        Firmware::GrblHal | Firmware::FluidNc => match value.parse::<f64>() {
            Ok(v) if !v.is_finite() || v < 0.0 => {
                Err(format!("${number}={value}: must not be negative"))
            }
            _ => Ok(()),
        },
    }
}

/// What no single value can be blamed for, with what the controller has already.
fn together(plan: &[(u16, String)], known: &Known) -> Result<(), String> {
    let after = |n: u16| {
        let planned = plan
            .iter()
            .find(|p| p.0 == n)
            .and_then(|p| p.1.parse::<f64>().ok());
        planned.or(known.setting(n))
    };
    if after(20) == Some(1.0) && after(22) == Some(0.0) {
        return Err("$20=1 (soft limits) needs homing: set $22=1 as well".to_string());
    }
    match (after(31), after(30)) {
        (Some(low), Some(high)) if low > high => Err(format!(
            "the lowest spindle speed ($31={low}) would be above the highest ($30={high})"
        )),
        _ => Ok(()),
    }
}
