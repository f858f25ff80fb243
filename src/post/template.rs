//! Lines of a dialect with `{name}` places in them, taken apart and checked once.

use crate::machine::data::nearest;

/// What can stand in braces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The job's comment lines; must stand alone on its line.
    Comments,
    /// The word that chooses the program's units.
    Units,
    /// Program name.
    Name,
    /// Program number.
    Number,
    /// Tool number.
    Tool,
    /// Spindle speed, rpm.
    Speed,
    /// Path tolerance, in the program's units.
    Tolerance,
    /// A duration, s.
    Seconds,
    /// A duration, ms, a whole number.
    Milliseconds,
    /// A work offset beyond those with a word of their own: the first of these is 1.
    Offset,
    /// The axis words of a move.
    Axes,
}

const SLOTS: [(&str, Slot); 11] = [
    ("comments", Slot::Comments),
    ("units", Slot::Units),
    ("name", Slot::Name),
    ("number", Slot::Number),
    ("tool", Slot::Tool),
    ("speed", Slot::Speed),
    ("tolerance", Slot::Tolerance),
    ("seconds", Slot::Seconds),
    ("milliseconds", Slot::Milliseconds),
    ("offset", Slot::Offset),
    ("axes", Slot::Axes),
];

/// A part of a template.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Written as it stands.
    Text(String),
    /// Filled in by the writer.
    Slot(Slot),
}

/// What a template is for: it decides which slots it may hold and what it may say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use {
    /// Slots that can be filled there.
    pub slots: &'static [Slot],
    /// The line is a move of the writer's own: it may say G0 and G53.
    pub moves: bool,
    /// ISO words; otherwise Heidenhain's conversational language.
    pub iso: bool,
}

/// One line of a dialect. A line with `{tolerance}` is left out of the program when there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// The line's parts, in order.
    pub pieces: Vec<Piece>,
}

impl Template {
    /// Takes a line apart. The error says what is wrong and what to do.
    pub fn parse(line: &str, place: Use) -> Result<Template, String> {
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
        while let Some((before, after)) = rest.split_once('{') {
            if !before.is_empty() {
                pieces.push(Piece::Text(before.to_string()));
            }
            let Some((name, after)) = after.split_once('}') else {
                return Err("has a { without its }".to_string());
            };
            pieces.push(Piece::Slot(slot(name, place.slots)?));
            rest = after;
        }
        if rest.contains('}')
            || pieces
                .iter()
                .any(|p| matches!(p, Piece::Text(t) if t.contains('}')))
        {
            return Err("has a } without its {".to_string());
        }
        if !rest.is_empty() {
            pieces.push(Piece::Text(rest.to_string()));
        }
        if pieces.contains(&Piece::Slot(Slot::Comments)) && pieces.len() > 1 {
            return Err("{comments} must stand on a line of its own".to_string());
        }
        let template = Template { pieces };
        match place.iso {
            true => template.refuse_motion(place.moves)?,
            false => template.refuse_path(place.moves)?,
        }
        Ok(template)
    }

    /// Characters of the line without what fills its slots.
    pub fn least_length(&self) -> usize {
        let own = |p: &Piece| match p {
            Piece::Text(t) => t.chars().count(),
            Piece::Slot(_) => 0,
        };
        self.pieces.iter().map(own).sum()
    }

    /// True when the slot occurs.
    pub fn has(&self, slot: Slot) -> bool {
        self.pieces.contains(&Piece::Slot(slot))
    }

    /// The line's own text, slots shown as `0` or, where they are no number, left out.
    fn flat(&self) -> String {
        let shown = |p: &Piece| match p {
            Piece::Text(t) => t.clone(),
            Piece::Slot(Slot::Units | Slot::Comments | Slot::Axes | Slot::Name) => " ".into(),
            Piece::Slot(_) => "0".into(),
        };
        self.pieces.iter().map(shown).collect()
    }

    /// The words of the line as (letter, number text), comments left out. Names of two letters and more (`SUPA`, `CTOL=0.1`) are
    /// no words.
    pub fn words(&self) -> Vec<(char, String)> {
        let mut words: Vec<(char, String)> = Vec::new();
        let mut depth = 0_usize;
        let mut letters = 0_usize;
        for c in self.flat().chars() {
            match c {
                '(' => depth += 1,
                ')' => depth = depth.saturating_sub(1),
                ';' if depth == 0 => break,
                _ if depth > 0 => {}
                c if c.is_ascii_alphabetic() => {
                    letters += 1;
                    match letters {
                        1 => words.push((c.to_ascii_uppercase(), String::new())),
                        2 => drop(words.pop()),
                        _ => {}
                    }
                }
                ' ' => letters = 0,
                c => {
                    if let (true, Some((_, number))) = (letters <= 1, words.last_mut()) {
                        number.push(c);
                        letters = 0;
                    }
                }
            }
        }
        words
    }

    /// The writer keeps track of position, motion mode and units, so a template may touch none of them.
    fn refuse_motion(&self, own_move: bool) -> Result<(), String> {
        for (letter, number) in self.words() {
            let value: f64 = number.parse().unwrap_or(-1.0);
            let word = format!("{letter}{number}");
            if matches!(letter, 'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W') {
                return Err(format!(
                    "{word} would move the machine: only the program's own moves may"
                ));
            }
            if letter != 'G' || (own_move && [0.0, 53.0].contains(&value)) {
                continue;
            }
            if [20.0, 21.0, 70.0, 71.0, 700.0, 710.0].contains(&value) {
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

    /// The same for conversational language.
    fn refuse_path(&self, own_move: bool) -> Result<(), String> {
        let flat = self.flat();
        let first = flat.split_whitespace().next().unwrap_or_default();
        let path = [
            "L", "C", "CC", "CP", "CR", "CT", "CHF", "RND", "LP", "CTP", "APPR", "DEP",
        ];
        if !own_move && path.contains(&first) {
            return Err(format!(
                "{first} would move the machine: only the program's own moves may"
            ));
        }
        Ok(())
    }
}

/// The slot of a name, if it can be filled there.
fn slot(name: &str, allowed: &[Slot]) -> Result<Slot, String> {
    let here = || SLOTS.iter().filter(|(_, s)| allowed.contains(s));
    if let Some((_, slot)) = here().find(|(n, _)| *n == name) {
        return Ok(*slot);
    }
    let near = nearest(name, here().map(|(n, _)| *n))
        .map(|n| format!(" (did you mean {{{n}}}?)"))
        .unwrap_or_default();
    let known: Vec<String> = here().map(|(n, _)| format!("{{{n}}}")).collect();
    Err(match known.is_empty() {
        true => format!("{{{name}}}: nothing can be filled in here: leave it out"),
        false => format!(
            "{{{name}}} is not known here{near}; there are {}",
            known.join(" ")
        ),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const ANY: Use = Use {
        slots: &[
            Slot::Comments,
            Slot::Units,
            Slot::Tool,
            Slot::Speed,
            Slot::Tolerance,
            Slot::Axes,
        ],
        moves: false,
        iso: true,
    };

    fn parse(line: &str) -> Result<Template, String> {
        Template::parse(line, ANY)
    }

    #[test]
    fn takes_lines_apart() {
        let t = parse("M3 S{speed} (go)").unwrap();
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
                "{sped} is not known here (did you mean {speed}?); there are {comments} {units} {tool} {speed} {tolerance} {axes}",
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
            let e = parse(line).unwrap_err();
            assert!(e.contains(what), "{line}: {e}");
        }
        for good in [
            "G17 G90 G94 G54",
            "(X Y Z)",
            "M5 ; go to X0",
            "G40 G49 G80",
            "G64 P{tolerance}",
            "G43 H{tool}",
            "CYCLE832({tolerance},_FINISH,1)",
            "CTOL={tolerance}",
            "G0{axes}X",
        ] {
            let own = Use {
                moves: good.contains("{axes}"),
                ..ANY
            };
            match good.ends_with('X') {
                true => assert!(
                    Template::parse(good, own)
                        .unwrap_err()
                        .contains("X would move")
                ),
                false => drop(Template::parse(good, own).unwrap()),
            }
        }
        let own = Use { moves: true, ..ANY };
        assert!(Template::parse("G0 SUPA {axes} D0", own).is_ok());
        let tnc = Use { iso: false, ..ANY };
        assert!(Template::parse("TOOL CALL {tool} Z", tnc).is_ok());
        let e = Template::parse("L Z+100 R0 FMAX", tnc).unwrap_err();
        assert!(e.starts_with("L would move the machine"), "{e}");
        let e = Template::parse("M6 {x}", Use { slots: &[], ..ANY }).unwrap_err();
        assert_eq!(e, "{x}: nothing can be filled in here: leave it out");
    }
}
