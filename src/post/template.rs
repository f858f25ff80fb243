//! Lines of a dialect with `{name}` places in them, taken apart and checked once.

use crate::machine::data::nearest;

/// What can stand in braces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The job's comment lines; must stand alone on its line.
    Comments,
    /// G21 or G20.
    Units,
    /// Tool number.
    Tool,
    /// Spindle speed, rpm.
    Speed,
    /// Seconds to wait for the spindle.
    SpinUp,
    /// Path tolerance, in the program's units.
    Tolerance,
}

const SLOTS: [(&str, Slot); 6] = [
    ("comments", Slot::Comments),
    ("units", Slot::Units),
    ("tool", Slot::Tool),
    ("speed", Slot::Speed),
    ("spin_up", Slot::SpinUp),
    ("tolerance", Slot::Tolerance),
];

/// A part of a template.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Written as it stands.
    Text(String),
    /// Filled in per job.
    Slot(Slot),
}

/// One line of a dialect. A line is left out of the program when one of its slots has nothing to say (no spin-up time, no path
/// tolerance).
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// The line's parts, in order.
    pub pieces: Vec<Piece>,
}

impl Template {
    /// Takes a line apart. The error says what is wrong and what to do.
    pub fn parse(line: &str) -> Result<Template, String> {
        if let Some(c) = line.chars().find(|c| !(' '..='~').contains(c)) {
            return Err(format!(
                "{c:?} is not a printable ASCII character, and machines read no other: leave it out"
            ));
        }
        if line.trim().is_empty() {
            return Err("is an empty line: leave it out".to_string());
        }
        let mut pieces = Vec::new();
        let mut rest = line;
        while let Some(open) = rest.find('{') {
            if open > 0 {
                pieces.push(Piece::Text(rest[..open].to_string()));
            }
            let Some(close) = rest[open..].find('}') else {
                return Err("has a { without its }".to_string());
            };
            let name = &rest[open + 1..open + close];
            let Some((_, slot)) = SLOTS.iter().find(|(n, _)| *n == name) else {
                let near = nearest(name, SLOTS.iter().map(|(n, _)| *n))
                    .map(|n| format!(" (did you mean {{{n}}}?)"))
                    .unwrap_or_default();
                let known: Vec<String> = SLOTS.iter().map(|(n, _)| format!("{{{n}}}")).collect();
                return Err(format!(
                    "{{{name}}} is not known{near}; there are {}",
                    known.join(" ")
                ));
            };
            pieces.push(Piece::Slot(*slot));
            rest = &rest[open + close + 1..];
        }
        if rest.contains('}') {
            return Err("has a } without its {".to_string());
        }
        if !rest.is_empty() {
            pieces.push(Piece::Text(rest.to_string()));
        }
        if pieces.contains(&Piece::Slot(Slot::Comments)) && pieces.len() > 1 {
            return Err("{comments} must stand on a line of its own".to_string());
        }
        let template = Template { pieces };
        template.refuse_motion()?;
        Ok(template)
    }

    /// True when the slot occurs.
    pub fn has(&self, slot: Slot) -> bool {
        self.pieces.contains(&Piece::Slot(slot))
    }

    /// The words of the line as (letter, number text), slots shown as `0`, comments left out.
    pub fn words(&self) -> Vec<(char, String)> {
        let mut words: Vec<(char, String)> = Vec::new();
        let mut in_comment = false;
        let flat: String = self
            .pieces
            .iter()
            .map(|p| match p {
                Piece::Text(t) => t.as_str(),
                Piece::Slot(Slot::Units | Slot::Comments) => " ",
                Piece::Slot(_) => "0",
            })
            .collect();
        for c in flat.chars() {
            match c {
                '(' => in_comment = true,
                ')' => in_comment = false,
                ';' if !in_comment => break,
                _ if in_comment || c == ' ' => {}
                c if c.is_ascii_alphabetic() => words.push((c.to_ascii_uppercase(), String::new())),
                c => {
                    if let Some((_, number)) = words.last_mut() {
                        number.push(c);
                    }
                }
            }
        }
        words
    }

    /// The writer keeps track of position, motion mode and units, so a template may touch none of them.
    fn refuse_motion(&self) -> Result<(), String> {
        for (letter, number) in self.words() {
            let value: f64 = number.parse().unwrap_or(-1.0);
            let word = format!("{letter}{number}");
            if matches!(letter, 'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W') {
                return Err(format!(
                    "{word} would move the machine: only the program's own moves may"
                ));
            }
            if letter != 'G' {
                continue;
            }
            if value == 20.0 || value == 21.0 {
                return Err(format!(
                    "{word}: write {{units}} instead, so that it always agrees with the numbers"
                ));
            }
            if value == 91.0 || value == 93.0 || value == 95.0 {
                return Err(format!("{word}: programs are written with G90 and G94"));
            }
            let moves = [0.0, 1.0, 2.0, 3.0, 28.0, 30.0, 33.0, 53.0, 73.0, 74.0, 76.0];
            if moves.contains(&value)
                || (38.0..39.0).contains(&value)
                || (81.0..90.0).contains(&value)
                || value == 92.0
            {
                return Err(format!(
                    "{word} would move the machine or its zero: only the program's own moves may"
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn takes_lines_apart() {
        let t = Template::parse("M3 S{speed} (go)").unwrap();
        assert_eq!(
            t.pieces,
            [
                Piece::Text("M3 S".into()),
                Piece::Slot(Slot::Speed),
                Piece::Text(" (go)".into())
            ]
        );
        assert!(t.has(Slot::Speed) && !t.has(Slot::Tool));
        assert_eq!(t.words(), [('M', "3".into()), ('S', "0".into())]);
    }

    #[test]
    fn refuses_what_it_cannot_answer_for() {
        for (line, what) in [
            (
                "M3 S{sped}",
                "{sped} is not known (did you mean {speed}?); there are {comments} {units} ",
            ),
            ("M3 S{speed", "has a { without its }"),
            ("M3 S}", "has a } without its {"),
            ("  ", "is an empty line"),
            ("; {comments}", "{comments} must stand on a line of its own"),
            ("G0 Z5", "G0 would move the machine"),
            ("g53 G90", "G53 would move the machine"),
            ("X{speed}", "X0 would move the machine"),
            ("G21", "write {units} instead"),
            ("G91", "programs are written with G90 and G94"),
            ("M3 \u{b5}", "is not a printable ASCII character"),
            ("G28", "would move the machine"),
            ("G92.1 Z0", "Z0 would move the machine"),
        ] {
            let e = Template::parse(line).unwrap_err();
            assert!(e.contains(what), "{line}: {e}");
        }
        for good in [
            "G17 G90 G94 G54",
            "(X Y Z)",
            "M5 ; go to X0",
            "G40 G49 G80",
            "G64 P{tolerance}",
            "G43 H{tool}",
        ] {
            Template::parse(good).unwrap();
        }
    }
}
