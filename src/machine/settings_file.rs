//! A controller's `$n=value` settings from a text file, checked.
//!
//! Crosses the border: text in; numbers of GRBL 1.1's settings with values in their own units (mm, mm/min, mm/s², rpm, ms, µs) out, and
//! a [`Machine`] with those figures. What a terminal catches besides, when `$$` is asked of a real controller, may stand in the file: the
//! greeting, `ok`, reports, messages. Never knows a controller, real or simulated.
//!
//! ```text
//! ; the router as it was on Monday          a comment: `;`, `#` or in parentheses, to the end of the line
//! $110=4000.000
//! $22=1 (homing cycle, bool)                GRBL 0.9 explained its settings like this
//! ```
//! Numbers, kinds and meanings: GRBL 1.1's documentation, "Grbl v1.1 Configuration". Stricter than the firmware, which stores a 300
//! into eight bits as a 44 without a word.

use super::Machine;
use super::data::{DataError, Place, Reader};
use crate::units::{Mm, MmPerMin, MmPerSec2, Rpm, Seconds};

/// What a setting's value may be.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A whole number of eight bits, from the least allowed.
    Byte(u8),
    /// 0 or 1.
    Switch,
    /// At least zero, up to.
    FromZero(f64),
    /// Above zero, up to.
    AboveZero(f64),
}

/// One setting of GRBL 1.1.
struct Known {
    number: u16,
    kind: Kind,
    title: &'static str,
}

const fn known(number: u16, kind: Kind, title: &'static str) -> Known {
    Known {
        number,
        kind,
        title,
    }
}

/// Largest rate, mm/min, as in machine files.
const RATE: f64 = 200_000.0;

const KNOWN: [Known; 34] = [
    known(0, Kind::Byte(3), "step pulse, us"),
    known(1, Kind::Byte(0), "step idle delay, ms"),
    known(2, Kind::Byte(0), "step port invert mask"),
    known(3, Kind::Byte(0), "direction invert mask"),
    known(4, Kind::Switch, "step enable invert"),
    known(5, Kind::Switch, "limit pins invert"),
    known(6, Kind::Switch, "probe pin invert"),
    known(10, Kind::Byte(0), "status report mask"),
    known(11, Kind::AboveZero(10.0), "junction deviation, mm"),
    known(12, Kind::AboveZero(10.0), "arc tolerance, mm"),
    known(13, Kind::Switch, "report in inches"),
    known(20, Kind::Switch, "soft limits"),
    known(21, Kind::Switch, "hard limits"),
    known(22, Kind::Switch, "homing cycle"),
    known(23, Kind::Byte(0), "homing direction invert mask"),
    known(24, Kind::AboveZero(RATE), "homing locate feed, mm/min"),
    known(25, Kind::AboveZero(RATE), "homing seek feed, mm/min"),
    known(26, Kind::Byte(0), "homing debounce, ms"),
    known(27, Kind::AboveZero(1000.0), "homing pull-off, mm"),
    known(30, Kind::AboveZero(500_000.0), "highest spindle speed, rpm"),
    known(31, Kind::FromZero(500_000.0), "lowest spindle speed, rpm"),
    known(32, Kind::Switch, "laser mode"),
    known(100, Kind::AboveZero(1_000_000.0), "steps per mm of X"),
    known(101, Kind::AboveZero(1_000_000.0), "steps per mm of Y"),
    known(102, Kind::AboveZero(1_000_000.0), "steps per mm of Z"),
    known(110, Kind::AboveZero(RATE), "highest rate of X, mm/min"),
    known(111, Kind::AboveZero(RATE), "highest rate of Y, mm/min"),
    known(112, Kind::AboveZero(RATE), "highest rate of Z, mm/min"),
    known(120, Kind::AboveZero(100_000.0), "acceleration of X, mm/s2"),
    known(121, Kind::AboveZero(100_000.0), "acceleration of Y, mm/s2"),
    known(122, Kind::AboveZero(100_000.0), "acceleration of Z, mm/s2"),
    known(130, Kind::AboveZero(20_000.0), "travel of X, mm"),
    known(131, Kind::AboveZero(20_000.0), "travel of Y, mm"),
    known(132, Kind::AboveZero(20_000.0), "travel of Z, mm"),
];

/// What `$number` is, in words, and the unit of its value where it has one.
pub fn meaning(number: u16) -> Option<(&'static str, Option<&'static str>)> {
    let known = KNOWN.iter().find(|k| k.number == number)?;
    Some(match known.title.split_once(", ") {
        Some((title, unit)) => (title, Some(unit)),
        None => (known.title, None),
    })
}

/// True for a setting that is on or off.
pub fn is_switch(number: u16) -> bool {
    KNOWN
        .iter()
        .any(|k| k.number == number && k.kind == Kind::Switch)
}

/// One line of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The n of `$n`.
    pub number: u16,
    /// In the setting's own unit.
    pub value: f64,
    /// Line of the file, from 1.
    pub line: usize,
}

/// A checked settings file. Settings it leaves out are left as they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SettingsFile {
    /// In the order of the file; no number twice.
    pub settings: Vec<Setting>,
}

impl SettingsFile {
    /// Reads a text that complaints call `file`.
    ///
    /// # Errors
    /// Every line that is no setting, names an unknown one, or has a value that cannot be right, each with line and column.
    pub fn read(file: &str, text: &str) -> Result<SettingsFile, DataError> {
        let mut r = Reader::new(file, text, "");
        let mut settings: Vec<Setting> = Vec::new();
        // Editors put a byte order mark in front, terminals end lines in each of three ways.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        for (index, whole) in text.lines().enumerate() {
            if r.complaints.len() >= MOST_COMPLAINTS {
                break;
            }
            match line(whole, index + 1, &settings) {
                Ok(None) => {}
                Ok(Some(setting)) => settings.push(setting),
                Err(wrong) => {
                    let at = Place {
                        file: file.to_string(),
                        line: index + 1,
                        column: whole.get(..wrong.byte).map_or(1, |s| s.chars().count() + 1),
                    };
                    r.complaints.push(match wrong.value {
                        Some((key, value)) => DataError::Value {
                            at,
                            key,
                            value,
                            problem: wrong.problem,
                        },
                        None => DataError::Syntax {
                            at,
                            message: wrong.problem,
                        },
                    });
                }
            }
        }
        let found = SettingsFile { settings };
        if r.complaints.is_empty() {
            found.together(file, &mut r.complaints);
        }
        if r.complaints.is_empty() && found.settings.is_empty() {
            r.complaints.push(DataError::Syntax {
                at: r.place(0),
                message: "no setting in it: write lines like $110=4000, or what a controller answers to $$"
                    .to_string(),
            });
        }
        r.finish(found)
    }

    /// The value of `$number`, if the file has it.
    pub fn get(&self, number: u16) -> Option<f64> {
        self.settings
            .iter()
            .find(|s| s.number == number)
            .map(|s| s.value)
    }

    /// Puts the figures that a machine has into it: steps, rates, accelerations, travel, junction deviation, arc tolerance, idle delay, spindle. One
    /// limit of the spindle alone that contradicts the machine's other one moves that one, too.
    pub fn apply(&self, machine: &mut Machine) {
        for axis in 0..3usize {
            let of = |first: u16| self.get(first + axis as u16);
            if let Some(v) = of(100) {
                machine.steps_per_mm[axis] = v;
            }
            if let Some(v) = of(110) {
                machine.max_rate[axis] = MmPerMin(v);
            }
            if let Some(v) = of(120) {
                machine.acceleration[axis] = MmPerSec2(v);
            }
            if let Some(v) = of(130) {
                machine.travel[axis] = Mm(v);
            }
        }
        if let Some(v) = self.get(11) {
            machine.junction_deviation = Mm(v);
        }
        if let Some(v) = self.get(12) {
            machine.arc_tolerance = Mm(v);
        }
        if let Some(v) = self.get(1) {
            // 255 holds the motors for ever, without waiting for it.
            machine.idle_delay = Seconds(if v >= 255.0 { 0.0 } else { v / 1000.0 });
        }
        let [low, high] = &mut machine.spindle;
        if let Some(v) = self.get(31) {
            *low = Rpm(v);
            high.0 = high.0.max(v);
        }
        if let Some(v) = self.get(30) {
            *high = Rpm(v);
            low.0 = low.0.min(v);
        }
        // What the machine's maker allows while cutting cannot be faster than any axis goes.
        let fastest = machine.max_rate.iter().fold(0.0, |m: f64, r| m.max(r.0));
        machine.max_feed = machine.max_feed.filter(|f| f.0 <= fastest);
    }

    /// What no single line can be blamed for.
    fn together(&self, file: &str, complaints: &mut Vec<DataError>) {
        let mut refuse = |number: u16, problem: &str| {
            let Some(s) = self.settings.iter().find(|s| s.number == number) else {
                return;
            };
            complaints.push(DataError::Value {
                at: Place {
                    file: file.to_string(),
                    line: s.line,
                    column: 1,
                },
                key: format!("${number}"),
                value: s.value.to_string(),
                problem: problem.to_string(),
            });
        };
        if self.get(20) == Some(1.0) && self.get(22) == Some(0.0) {
            refuse(20, "soft limits need homing: set $22=1 as well");
        }
        if let (Some(low), Some(high)) = (self.get(31), self.get(30))
            && low > high
        {
            refuse(31, "the lowest spindle speed is above the highest, $30");
        }
    }
}

/// Complaints listed about one file at most: a wrong file would have thousands.
const MOST_COMPLAINTS: usize = 20;
/// Characters of a line that a complaint repeats.
const LONGEST_SHOWN: usize = 60;

/// What is wrong with a line.
struct Wrong {
    /// Byte of the line.
    byte: usize,
    /// Key and value, when it is the value.
    value: Option<(String, String)>,
    problem: String,
}

/// Reads one line; `None` when there is nothing on it for us.
fn line(whole: &str, number: usize, before: &[Setting]) -> Result<Option<Setting>, Wrong> {
    let end = whole.find([';', '#', '(']).unwrap_or(whole.len());
    let text = whole.get(..end).unwrap_or_default();
    let start = text.len() - text.trim_start().len();
    let text = text.trim();
    if text.is_empty() || is_chatter(text) {
        return Ok(None);
    }
    let wrong = |byte: usize, problem: String| Wrong {
        byte,
        value: None,
        problem,
    };
    let Some((key, value)) = text.strip_prefix('$').and_then(|t| t.split_once('=')) else {
        let shown: String = text.chars().take(LONGEST_SHOWN).collect();
        return Err(wrong(
            start,
            format!("\"{shown}\" is no setting: write $number=value, e.g. $110=4000"),
        ));
    };
    let key = key.trim();
    let entry = key
        .parse::<u16>()
        .ok()
        .filter(|_| key.bytes().all(|b| b.is_ascii_digit()))
        .and_then(|n| KNOWN.iter().find(|k| k.number == n));
    let Some(entry) = entry else {
        let shown: String = key.chars().take(LONGEST_SHOWN).collect();
        let near = nearest(key).map_or_else(String::new, |k| {
            format!(" (did you mean ${}, {}?)", k.number, k.title)
        });
        return Err(wrong(
            start,
            format!("GRBL 1.1 has no setting ${shown}{near}: take the line out"),
        ));
    };
    if let Some(earlier) = before.iter().find(|s| s.number == entry.number) {
        return Err(wrong(
            start,
            format!(
                "${key} stands in line {} already: keep one of them",
                earlier.line
            ),
        ));
    }
    // Where the value begins: behind the `=` and its blanks.
    let at = start + text.len() - value.trim_start().len();
    let value = value.trim();
    match check(value, entry) {
        Ok(v) => Ok(Some(Setting {
            number: entry.number,
            value: v,
            line: number,
        })),
        Err(problem) => Err(Wrong {
            byte: at,
            value: Some((
                format!("${} ({})", entry.number, entry.title),
                value.chars().take(LONGEST_SHOWN).collect(),
            )),
            problem,
        }),
    }
}

/// The value, if the setting may have it.
fn check(text: &str, entry: &Known) -> Result<f64, String> {
    let plain = !text.is_empty()
        && text
            .bytes()
            .all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+'));
    let Some(v) = text.parse::<f64>().ok().filter(|v| plain && v.is_finite()) else {
        return Err("is not a number: write digits with a point, e.g. 4000 or 0.010".to_string());
    };
    let (fits, must) = match entry.kind {
        Kind::Byte(least) => (
            v.fract() == 0.0 && (f64::from(least)..=255.0).contains(&v),
            format!("must be a whole number from {least} to 255"),
        ),
        Kind::Switch => (v == 0.0 || v == 1.0, "must be 0 or 1".to_string()),
        Kind::FromZero(most) => (
            (0.0..=most).contains(&v),
            format!("must be at least 0 and at most {most}"),
        ),
        Kind::AboveZero(most) => (
            v > 0.0 && v <= most,
            format!("must be above 0 and at most {most}"),
        ),
    };
    if fits { Ok(v + 0.0) } else { Err(must) }
}

/// The known number most like a mistyped one: one digit too many, too few, or wrong.
fn nearest(key: &str) -> Option<&'static Known> {
    let names: Vec<String> = KNOWN.iter().map(|k| k.number.to_string()).collect();
    let name = super::data::nearest(key, names.iter().map(String::as_str))?;
    KNOWN.iter().find(|k| k.number.to_string() == name)
}

/// What a controller says besides, when its answer to `$$` was copied from a terminal.
fn is_chatter(text: &str) -> bool {
    text == "ok"
        || text == "$$"
        // Prompts and echoes of consoles, and the firmware's own of startup lines.
        || text.starts_with('>')
        || text.starts_with("Grbl ")
        || (text.starts_with('<') && text.ends_with('>'))
        || (text.starts_with('[') && text.ends_with(']'))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn refused(text: &str) -> String {
        SettingsFile::read("mill.txt", text)
            .unwrap_err()
            .to_string()
    }

    const DUMP: &str = "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n$$\r\n$0=10\r\n$1=25\r\n$2=0\r\n$3=0\r\n$4=0\r\n$5=0\r\n$6=0\r\n$10=1\r\n\
        $11=0.010\r\n$12=0.002\r\n$13=0\r\n$20=0\r\n$21=0\r\n$22=1\r\n$23=0\r\n$24=25.000\r\n$25=500.000\r\n$26=250\r\n$27=1.000\r\n$30=24000\r\n$31=0\r\n\
        $32=0\r\n$100=250.000\r\n$101=250.000\r\n$102=400.000\r\n$110=4000.000\r\n$111=4000.000\r\n$112=1500.000\r\n$120=300.000\r\n$121=300.000\r\n\
        $122=100.000\r\n$130=800.000\r\n$131=850.000\r\n$132=110.000\r\nok\r\n<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n";

    #[test]
    fn a_whole_dump_is_read_and_reaches_the_machine() {
        let file = SettingsFile::read("dump.txt", DUMP).unwrap();
        assert_eq!(file.settings.len(), KNOWN.len());
        let mut m = Machine::load(crate::machine::DEFAULT_MACHINE).unwrap();
        file.apply(&mut m);
        assert_eq!(m.steps_per_mm, [250.0, 250.0, 400.0]);
        assert_eq!(
            m.max_rate,
            [MmPerMin(4000.0), MmPerMin(4000.0), MmPerMin(1500.0)]
        );
        assert_eq!(
            m.acceleration,
            [MmPerSec2(300.0), MmPerSec2(300.0), MmPerSec2(100.0)]
        );
        assert_eq!(m.travel, [Mm(800.0), Mm(850.0), Mm(110.0)]);
        assert_eq!(
            (m.junction_deviation, m.arc_tolerance),
            (Mm(0.01), Mm(0.002))
        );
        assert_eq!(m.spindle, [Rpm(0.0), Rpm(24000.0)]);
    }

    #[test]
    fn comments_and_what_is_left_out() {
        let text =
            "; my router\n# faster\n\n  $110 = 4200.5 ; belts\n$13=1 (report inches, bool)\n";
        let file = SettingsFile::read("f", text).unwrap();
        assert_eq!(
            file.settings,
            [
                Setting {
                    number: 110,
                    value: 4200.5,
                    line: 4
                },
                Setting {
                    number: 13,
                    value: 1.0,
                    line: 5
                }
            ]
        );
        let mut m = Machine::load(crate::machine::DEFAULT_MACHINE).unwrap();
        let before = m.clone();
        file.apply(&mut m);
        assert_eq!(m.max_rate[0], MmPerMin(4200.5));
        assert_eq!(m.max_rate[1..], before.max_rate[1..]);
        assert_eq!(m.travel, before.travel);
    }

    /// What people's editors, terminals and older firmwares make of a dump.
    #[test]
    fn marks_line_ends_prompts_and_explanations() {
        let plain = SettingsFile::read("f", "$1=200\n$110=4000\n$13=1\n").unwrap();
        for text in [
            "\u{feff}$1=200\r\n$110=4000\r\n$13=1\r\n",
            "$1=200\r$110=4000\r$13=1\r",
            "$1=200 (step idle delay, msec)\n$110=4000.000 (x max rate, mm/min)\n$13=1 (report inches, bool)\nok",
            "\u{feff}$1 = 200 ; holds long\n$110 = 4000 # X\n$13 = 1",
        ] {
            assert_eq!(SettingsFile::read("f", text).unwrap(), plain, "{text:?}");
        }
        let console = ">>> $$\n$1=200\n>G20G54:ok\n[MSG:Check Limits]\nok\n";
        let settings = SettingsFile::read("f", console).unwrap().settings;
        assert_eq!((settings[0].number, settings[0].line), (1, 2));
        // A mark is no column, and a line end of two characters is no line.
        assert_eq!(
            refused("\u{feff}$1=200\r\n$1=25\r\n"),
            "mill.txt:2:1: $1 stands in line 1 already: keep one of them"
        );
    }

    #[test]
    fn the_idle_delay_reaches_the_clock() {
        let mut m = Machine::load(crate::machine::DEFAULT_MACHINE).unwrap();
        assert_eq!(m.idle_delay, Seconds(0.025));
        for (text, delay) in [("$1=200", 0.2), ("$1=0", 0.0), ("$1=255", 0.0)] {
            SettingsFile::read("f", text).unwrap().apply(&mut m);
            assert_eq!(m.idle_delay, Seconds(delay), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, said) in [
            (
                "\n G1 X1\n",
                "mill.txt:2:2: \"G1 X1\" is no setting: write $number=value, e.g. $110=4000",
            ),
            (
                "$1100=4000",
                "mill.txt:1:1: GRBL 1.1 has no setting $1100 (did you mean $100, steps per mm of X?): take the line out",
            ),
            (
                "$N0=G54",
                "mill.txt:1:1: GRBL 1.1 has no setting $N0 (did you mean $0, step pulse, us?): take the line out",
            ),
            (
                "$110= 4,000\n",
                "mill.txt:1:7: $110 (highest rate of X, mm/min) = 4,000: is not a number: write digits with a point, e.g. 4000 or 0.010",
            ),
            (
                "$110=1e3\n",
                "mill.txt:1:6: $110 (highest rate of X, mm/min) = 1e3: is not a number: write digits with a point, e.g. 4000 or 0.010",
            ),
            (
                "$1=300\n",
                "mill.txt:1:4: $1 (step idle delay, ms) = 300: must be a whole number from 0 to 255",
            ),
            (
                "$0=2",
                "mill.txt:1:4: $0 (step pulse, us) = 2: must be a whole number from 3 to 255",
            ),
            (
                "$22=2",
                "mill.txt:1:5: $22 (homing cycle) = 2: must be 0 or 1",
            ),
            (
                "$100=0",
                "mill.txt:1:6: $100 (steps per mm of X) = 0: must be above 0 and at most 1000000",
            ),
            (
                "$120=-5",
                "mill.txt:1:6: $120 (acceleration of X, mm/s2) = -5: must be above 0 and at most 100000",
            ),
            (
                "$11=0.01\n\n$11=0.02",
                "mill.txt:3:1: $11 stands in line 1 already: keep one of them",
            ),
            (
                "$20=1\n$22=0",
                "mill.txt:1:1: $20 = 1: soft limits need homing: set $22=1 as well",
            ),
            (
                "$30=1000\n$31=2000",
                "mill.txt:2:1: $31 = 2000: the lowest spindle speed is above the highest, $30",
            ),
            (
                "ok\n",
                "mill.txt:1:1: no setting in it: write lines like $110=4000, or what a controller answers to $$",
            ),
            (
                "$22=x\n$9=1",
                "mill.txt:1:5: $22 (homing cycle) = x: is not a number: write digits with a point, e.g. 4000 or 0.010\n\
                 mill.txt:2:1: GRBL 1.1 has no setting $9 (did you mean $0, step pulse, us?): take the line out",
            ),
        ] {
            assert_eq!(refused(text), said, "{text:?}");
        }
    }

    #[test]
    fn a_wrong_file_is_not_listed_line_by_line() {
        let text = "G1 X1\n".repeat(10_000);
        assert_eq!(refused(&text).lines().count(), MOST_COMPLAINTS);
    }

    proptest! {
        #[test]
        fn never_panics(text in "[$0-9=.a-zäé;#( \t\n-]{0,80}") {
            let _ = SettingsFile::read("f", &text);
        }

        /// Whatever is accepted makes a machine whose figures are finite and above zero.
        #[test]
        fn what_is_read_is_a_machine(
            lines in proptest::collection::vec((0usize..KNOWN.len(), "-?[0-9]{1,7}(\\.[0-9]{0,3})?"), 1..8)
        ) {
            let text: String = lines.iter().map(|(k, v)| format!("${}={v}\n", KNOWN[*k].number)).collect();
            if let Ok(file) = SettingsFile::read("f", &text) {
                let mut m = Machine::load(crate::machine::DEFAULT_MACHINE).unwrap();
                file.apply(&mut m);
                let figures = m.steps_per_mm.into_iter().chain(m.max_rate.map(|v| v.0)).chain(m.acceleration.map(|v| v.0))
                    .chain(m.travel.map(|v| v.0)).chain([m.junction_deviation.0, m.arc_tolerance.0, m.spindle[1].0]);
                for v in figures {
                    prop_assert!(v.is_finite() && v > 0.0, "{text}");
                }
                prop_assert!(m.spindle[0].0 <= m.spindle[1].0);
            }
        }
    }
}
