//! A controller's memory as text, to keep and to compare: `$I`, `$$`, `$#`, `$N`.
//!
//! The text is what the controller said, line by line, between comments. `crate::machine::settings_file` reads it too.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task};
use super::jog::ready;
use super::zero::READ_BACK;
use crate::wire::{Firmware, Reply, State};
use std::fmt::Write as _;

/// Questions and the comments above their answers.
const QUESTIONS: [(&str, &str); 4] = [
    ("$I", "the controller"),
    ("$$", "settings"),
    (
        "$#",
        "offsets and stored places, in the unit of $13 (restored only with --offsets)",
    ),
    (
        "$N",
        "start-up lines (restored only with --startup-lines: the controller runs them at once)",
    ),
];

/// What a controller's memory holds, as it said it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Saved {
    /// `$n=value`: number and value as text, in the controller's order.
    pub settings: Vec<(u16, String)>,
    /// `[G54:...]` to `[G59:...]`, `[G28:...]`, `[G30:...]`, machine coordinates, mm.
    pub offsets: Vec<(String, [f64; 3])>,
    /// `$N0` and `$N1`.
    pub startup: [Option<String>; 2],
    /// Whose memory it is, as far as it says.
    pub firmware: Option<Firmware>,
    /// How many axes it has, as far as it says.
    pub axes: Option<usize>,
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
            // As it is written here: a start-up line behind a comment sign, so that nobody takes it for a setting.
            if let Some(startup) = whole.trim().strip_prefix("; $N") {
                saved.hear(&format!("$N{startup}"));
                continue;
            }
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
                Reply::Other(text) if text.starts_with("$N") || text.starts_with('[') => {
                    saved.hear(line);
                }
                Reply::Other(text) => {
                    let shown: String = text.chars().take(60).collect();
                    return wrong(format!(
                        "`{shown}` is not a setting: write lines like $110=4000"
                    ));
                }
                _ => saved.hear(line),
            }
        }
        saved.convert_offsets();
        match saved.settings.is_empty() {
            true => Err((1, "no setting in it: write lines like $110=4000, or save one with `morsemill settings save`".to_string())),
            false => Ok(saved),
        }
    }

    /// Takes in a line that is no setting: who it is, offsets, start-up lines.
    fn hear(&mut self, line: &str) {
        if let Some((n, text)) = line.strip_prefix("$N").and_then(|t| t.split_once('=')) {
            if let Some(slot) = n
                .parse::<usize>()
                .ok()
                .and_then(|n| self.startup.get_mut(n))
            {
                *slot = Some(text.trim().to_string());
            }
            return;
        }
        let reply = Reply::parse(line);
        if let Some(firmware) = Firmware::told_by(&reply) {
            // grblHAL may greet as GRBL and say more later; never the other way.
            let vague = matches!(firmware, Firmware::Grbl11 | Firmware::Unknown);
            if !(vague && self.firmware.is_some()) {
                self.firmware = Some(firmware);
            }
        }
        if let Some(axes) = line.strip_prefix("[AXS:") {
            self.axes = axes.split(':').next().and_then(|n| n.parse().ok());
        }
        if let Some(values) = line.strip_prefix("[G54:") {
            self.axes.get_or_insert(values.split(',').count());
        }
        if let Reply::Offset { name, values } = reply
            && name != "G92"
            && self.offsets.iter().all(|(n, _)| *n != name)
        {
            self.offsets.push((name, values));
        }
    }

    /// `$#` comes in the unit of `$13`.
    fn convert_offsets(&mut self) {
        if self.get(13).and_then(|v| v.parse::<f64>().ok()) == Some(1.0) {
            for (_, values) in &mut self.offsets {
                *values = values.map(|v| v * 25.4);
            }
        }
    }

    /// Why this file must not be written to that controller, if it must not: settings of another firmware or of a machine with other axes
    /// mean other things by the same numbers.
    pub fn foreign(&self, controller: &Saved) -> Option<String> {
        if let (Some(a), Some(b)) = (self.firmware, controller.firmware)
            && a != b
            && ![a, b].contains(&Firmware::Unknown)
        {
            return Some(format!(
                "the file was saved from {}, and the controller is {}: the same numbers may mean other things. Take over by hand what is the same",
                a.title(),
                b.title()
            ));
        }
        match (self.axes, controller.axes) {
            (Some(a), Some(b)) if a != b => Some(format!(
                "the file was saved from a controller with {a} axes, and this one has {b}: it is another machine's"
            )),
            _ => None,
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

/// An offset or stored place that differs, machine coordinates in mm; `None` where one side has it not.
#[derive(Clone, Debug, PartialEq)]
pub struct MovedOffset {
    /// `G54` to `G59`, `G28`, `G30`.
    pub name: String,
    /// In the file.
    pub file: [f64; 3],
    /// In the controller.
    pub controller: Option<[f64; 3]>,
}

/// Offsets of the file that the controller has otherwise.
pub fn moved_offsets(file: &Saved, controller: &Saved) -> Vec<MovedOffset> {
    let found = file.offsets.iter().filter_map(|(name, values)| {
        let has = controller
            .offsets
            .iter()
            .find(|o| o.0 == *name)
            .map(|o| o.1);
        let same = has.is_some_and(|h| (0..3).all(|i| (h[i] - values[i]).abs() <= READ_BACK));
        (!same).then(|| MovedOffset {
            name: name.clone(),
            file: *values,
            controller: has,
        })
    });
    found.collect()
}

/// Start-up lines of the file that the controller has otherwise: which, the file's, the controller's.
pub fn other_startup(file: &Saved, controller: &Saved) -> Vec<(usize, String, String)> {
    let text = |s: &Option<String>| s.clone().unwrap_or_default();
    let pairs = file.startup.iter().zip(&controller.startup).enumerate();
    pairs
        .filter(|(_, (f, _))| f.is_some())
        .filter(|(_, (f, c))| plain(&text(f)) != plain(&text(c)))
        .map(|(n, (f, c))| (n, text(f), text(c)))
        .collect()
}

/// As the controller keeps it: upper case, without blanks.
pub(super) fn plain(line: &str) -> String {
    let kept = line.chars().filter(|c| !c.is_whitespace());
    kept.map(|c| c.to_ascii_uppercase()).collect()
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
        let same = matches!((a, b), (Some(a), Some(b)) if same(number, a, b));
        (!same).then(|| Difference {
            number,
            file: a.map(str::to_string),
            controller: b.map(str::to_string),
        })
    });
    found.collect()
}

/// The same value.
pub(super) fn same(number: u16, a: &str, b: &str) -> bool {
    // Speeds of the spindle are told in whole turns, all else to a thousandth.
    let told_to = match number {
        30 | 31 => 0.51,
        _ => 0.00051,
    };
    match (a.trim().parse::<f64>(), b.trim().parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= told_to + a.abs().max(b.abs()) * 1e-6,
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
            let own: Vec<String> = own.cloned().collect();
            own.iter().for_each(|line| self.saved.hear(line));
            self.saved.answers.push((last, own));
        }
        let Some((question, _)) = QUESTIONS.get(self.step) else {
            return match self.saved.settings.is_empty() {
                true => Err(ErrandError::NotPossible(
                    "the controller told no settings in its answer to $$".to_string(),
                )),
                false => {
                    self.saved.convert_offsets();
                    Ok(Step::Done)
                }
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
        let again = Saved::read(&whole.text()).unwrap();
        assert_eq!(again.settings, saved.settings);
        assert_eq!(again.startup, [Some("G20".to_string()), None]);
        assert_eq!(saved.offsets, [("G54".to_string(), [0.0; 3])]);
        assert_eq!(
            (saved.firmware, saved.axes),
            (Some(Firmware::Grbl11), Some(3))
        );
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
    fn a_file_of_another_controller_is_known_by_its_firmware_and_axes() {
        let read = |t: &str| Saved::read(t).unwrap();
        let grbl = read("[VER:1.1h.20190830:]\n$0=10\n[G54:0,0,0]\n");
        let hal = read("[VER:1.1f.20240101:]\n[FIRMWARE:grblHAL]\n$0=10\n[G54:0,0,0]\n");
        let four = read("$0=10\n[G54:0,0,0,0]\n");
        assert_eq!(grbl.foreign(&grbl), None);
        assert_eq!(read("$0=10\n").foreign(&hal), None);
        assert_eq!(
            grbl.foreign(&hal).unwrap(),
            "the file was saved from GRBL 1.1, and the controller is grblHAL: the same numbers may mean other things. Take over by hand what is the same"
        );
        assert_eq!(
            grbl.foreign(&four).unwrap(),
            "the file was saved from a controller with 3 axes, and this one has 4: it is another machine's"
        );
    }

    #[test]
    fn offsets_of_a_file_in_inch_are_compared_in_mm() {
        let inch =
            Saved::read("$13=1\n[G54:1.0000,0.0000,0.0000]\n[G92:9,9,9]\n; $N1=G54 G20\n").unwrap();
        let mm = Saved::read("$13=0\n[G54:25.400,0.000,0.000]\n; $N1=g54g21\n").unwrap();
        assert!(moved_offsets(&inch, &mm).is_empty());
        assert_eq!(
            other_startup(&inch, &mm),
            [(1, "G54 G20".to_string(), "g54g21".to_string())]
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
