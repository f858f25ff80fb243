//! A controller's memory as text, to keep and to compare: `$I`, `$$`, `$#`, `$N`.
//!
//! The text is what the controller said, line by line, between comments. `crate::machine::settings_file` reads it too.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task};
use super::jog::ready;
use crate::wire::{Reply, State};
use std::fmt::Write as _;

/// Questions and the comments above their answers.
const QUESTIONS: [(&str, &str); 4] = [
    ("$I", "the controller"),
    ("$$", "settings"),
    (
        "$#",
        "offsets and stored places, in the unit of $13 (not restored: set zero anew)",
    ),
    (
        "$N",
        "start-up lines (not restored: the controller would run them at once)",
    ),
];

/// What a controller's memory holds, as it said it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Saved {
    /// `$n=value`: number and value as text, in the controller's order.
    pub settings: Vec<(u16, String)>,
    /// Answers by question, whole.
    answers: Vec<(usize, Vec<String>)>,
}

impl Saved {
    /// The file's text.
    pub fn text(&self) -> String {
        let mut out = String::from("; settings of a GRBL controller, saved by morsemill\n");
        for (question, lines) in &self.answers {
            if let Some((text, title)) = QUESTIONS.get(*question) {
                _ = writeln!(out, "; {text}: {title}");
            }
            for line in lines {
                // A start-up line looks like a setting and is none.
                let comment = if line.starts_with("$N") { "; " } else { "" };
                _ = writeln!(out, "{comment}{line}");
            }
        }
        out
    }

    /// Reads the `$n=value` lines of a text; comments, and what a terminal catches besides, are skipped.
    ///
    /// # Errors
    /// A line that is none of these, or a number twice: its line from 1, and why.
    pub fn read(text: &str) -> Result<Saved, (usize, String)> {
        let mut saved = Saved::default();
        for (index, whole) in text.lines().enumerate() {
            let wrong = |why: String| Err((index + 1, why));
            let end = whole
                .find([';', '#', '('])
                .filter(|_| !whole.trim_start().starts_with('$') || !whole.contains('='));
            let line = whole
                .get(..end.unwrap_or(whole.len()))
                .unwrap_or_default()
                .trim();
            if line.is_empty() || line == "%" {
                continue;
            }
            match Reply::parse(line) {
                Reply::Setting { number, value } => {
                    let value = value
                        .split([';', '('])
                        .next()
                        .unwrap_or_default()
                        .trim()
                        .to_string();
                    if saved.settings.iter().any(|s| s.0 == number) {
                        return wrong(format!(
                            "${number} stands here a second time: keep one of them"
                        ));
                    }
                    if value.is_empty() {
                        return wrong(format!("${number} has no value"));
                    }
                    saved.settings.push((number, value));
                }
                Reply::Other(text) if text.starts_with("$N") || text.starts_with('[') => {}
                Reply::Other(text) => {
                    let shown: String = text.chars().take(60).collect();
                    return wrong(format!(
                        "`{shown}` is not a setting: write lines like $110=4000"
                    ));
                }
                _ => {}
            }
        }
        match saved.settings.is_empty() {
            true => Err((1, "no setting in it: write lines like $110=4000, or save one with `morsemill settings save`".to_string())),
            false => Ok(saved),
        }
    }

    /// The value of `$number` as text.
    pub fn get(&self, number: u16) -> Option<&str> {
        self.settings
            .iter()
            .find(|s| s.0 == number)
            .map(|s| s.1.as_str())
    }
}

/// A setting that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The n of `$n`.
    pub number: u16,
    /// Value in the file; `None`: the file leaves it out.
    pub file: Option<String>,
    /// Value in the controller; `None`: it has no such setting.
    pub controller: Option<String>,
}

/// What differs, ascending by number. Numbers are compared as such (the controller keeps single precision and prints three
/// decimals), everything else as text.
pub fn differences(file: &Saved, controller: &Saved) -> Vec<Difference> {
    let mut numbers: Vec<u16> = file
        .settings
        .iter()
        .chain(&controller.settings)
        .map(|s| s.0)
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    let found = numbers.into_iter().filter_map(|number| {
        let (a, b) = (file.get(number), controller.get(number));
        let same = matches!((a, b), (Some(a), Some(b)) if same(a, b));
        (!same).then(|| Difference {
            number,
            file: a.map(str::to_string),
            controller: b.map(str::to_string),
        })
    });
    found.collect()
}

/// The same value.
pub(super) fn same(a: &str, b: &str) -> bool {
    match (a.trim().parse::<f64>(), b.trim().parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 0.00051 + a.abs().max(b.abs()) * 1e-6,
        _ => a.trim() == b.trim(),
    }
}

/// Asks for all of it.
#[derive(Clone, Debug, Default)]
pub struct Save {
    step: usize,
    /// What was said.
    pub saved: Saved,
}

impl Task for Save {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        if self.step == 0 && now.known.state != State::Alarm {
            ready(now.known, "reading the settings", &[State::Idle])?;
        }
        if let Some(last) = self.step.checked_sub(1) {
            for reply in &now.heard.replies {
                if let Reply::Setting { number, value } = reply {
                    self.saved
                        .settings
                        .push((*number, value.trim().to_string()));
                }
            }
            let own = now
                .heard
                .lines
                .iter()
                .filter(|l| !l.starts_with("[MSG") && !l.is_empty());
            self.saved.answers.push((last, own.cloned().collect()));
        }
        let Some((question, _)) = QUESTIONS.get(self.step) else {
            return match self.saved.settings.is_empty() {
                true => Err(ErrandError::NotPossible(
                    "the controller told no settings in its answer to $$".to_string(),
                )),
                false => Ok(Step::Done),
            };
        };
        self.step += 1;
        Ok(Step::send(*question, Rule::Plain))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn reads_what_it_writes_and_what_a_terminal_caught() {
        let text = "Grbl 1.1h ['$' for help]\n; note\n$0=10\n$110=500.000 ; fast\n[G54:0.000,0.000,0.000]\n$N0=G20\nok\n";
        let saved = Saved::read(text).unwrap();
        assert_eq!(
            saved.settings,
            [(0, "10".to_string()), (110, "500.000".to_string())]
        );
        let whole = Saved {
            answers: vec![
                (1, vec!["$0=10".into(), "$110=500.000".into()]),
                (3, vec!["$N0=G20".into()]),
            ],
            ..saved.clone()
        };
        assert!(whole.text().contains("\n; $N0=G20\n"));
        assert_eq!(Saved::read(&whole.text()).unwrap().settings, saved.settings);
        let files = crate::machine::settings_file::SettingsFile::read("x", &whole.text()).unwrap();
        assert_eq!(files.get(110), Some(500.0));
    }

    #[test]
    fn rubbish_is_named_by_its_line() {
        assert_eq!(Saved::read("$0=10\nG0 X1\n").unwrap_err().0, 2);
        assert!(
            Saved::read("$0=10\n$0=11\n")
                .unwrap_err()
                .1
                .contains("second time")
        );
        assert!(
            Saved::read("; nothing\n")
                .unwrap_err()
                .1
                .contains("no setting")
        );
        assert_eq!(
            Saved::read("$5=\n").unwrap_err(),
            (1, "$5 has no value".to_string())
        );
    }

    #[test]
    fn differences_are_by_value() {
        let read = |t: &str| Saved::read(t).unwrap();
        let d = differences(
            &read("$0=10\n$110=500\n$120=3"),
            &read("$0=10\n$110=500.000\n$120=4.000\n$130=200.000"),
        );
        assert_eq!(d.len(), 2);
        assert_eq!(
            (
                d[0].number,
                d[0].file.as_deref(),
                d[0].controller.as_deref()
            ),
            (120, Some("3"), Some("4.000"))
        );
        assert_eq!((d[1].number, d[1].file.as_deref()), (130, None));
    }
}
