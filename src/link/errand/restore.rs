//! Settings from a file into the controller: only what differs, each checked before the first is written, written one at a time, all
//! read back.
//!
//! GRBL stores a 300 into eight bits as a 44 without a word, so values are checked here and not left to the firmware.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task};
use super::jog::ready;
use super::saved::same;
use crate::link::introduction::Known;
use crate::machine::settings_file::SettingsFile;
use crate::wire::{Firmware, LINE_CHARS, Reply, State};

/// Settings after which a position means another place.
const MOVES_THE_ORIGIN: [u16; 7] = [3, 22, 23, 27, 100, 101, 102];

/// The errand.
#[derive(Clone, Debug, Default)]
pub struct Restore {
    /// What the controller shall have: number and value as text.
    pub wanted: Vec<(u16, String)>,
    plan: Option<Vec<(u16, String)>>,
    asked: bool,
    /// Settings that were written, in order.
    pub written: Vec<(u16, String)>,
}

impl Restore {
    /// The controller shall have these.
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
            if !has.is_some_and(|has| same(&has, value)) {
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
}

impl Task for Restore {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        let plan = match &self.plan {
            Some(plan) => plan,
            None => {
                if now.known.state != State::Alarm {
                    ready(now.known, "writing settings", &[State::Idle])?;
                }
                self.plan.insert(Self::plan(&self.wanted, now.known)?)
            }
        };
        if let Some((number, value)) = plan.get(self.written.len()) {
            let line = format!("${number}={value}");
            self.written.push((*number, value.clone()));
            return Ok(Step::send(line, Rule::Writer));
        }
        if self.written.is_empty() {
            return Ok(Step::Done);
        }
        if !self.asked {
            self.asked = true;
            return Ok(Step::send("$$", Rule::Plain));
        }
        for (number, wanted) in &self.written {
            let found = now.heard.replies.iter().find_map(|r| match r {
                Reply::Setting { number: n, value } if n == number => Some(value.trim()),
                _ => None,
            });
            if !found.is_some_and(|found| same(found, wanted)) {
                return Err(ErrandError::ReadBack {
                    what: format!("${number}"),
                    wanted: wanted.clone(),
                    found: found.unwrap_or("nothing").to_string(),
                });
            }
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
