//! What survives a power cycle as text, for a file.
//!
//! ```text
//! $0=10                     every setting
//! $N0=G20                   startup lines
//! $I=router                 the user's text
//! G54=-100,-80.5,-20        origins of the work systems, places of G28 and G30: machine coordinates, mm
//! ```
//! Whatever the firmware stores can be read back, sensible or not; all else is refused with its place.

use super::Memory;
use crate::machine::data::{DataError, Place, nearest};
use std::fmt::Write as _;

/// In the order of [`Memory::places`].
const PLACES: [&str; 8] = ["G54", "G55", "G56", "G57", "G58", "G59", "G28", "G30"];

impl Memory {
    /// All of it, a line each.
    pub fn to_text(&self) -> String {
        let mut out =
            String::from("; what the simulated controller keeps when it is switched off\n");
        // Writing into a String cannot fail.
        for number in self.numbers() {
            _ = writeln!(out, "${number}={}", self.get(number));
        }
        for (i, line) in self.startup.iter().enumerate() {
            _ = writeln!(out, "$N{i}={line}");
        }
        _ = writeln!(out, "$I={}", self.build_text);
        for (name, [x, y, z]) in PLACES.iter().zip(&self.places) {
            _ = writeln!(out, "{name}={x},{y},{z}");
        }
        out
    }

    /// Reads a text that complaints call `file`. What it leaves out is as in a new controller.
    ///
    /// # Errors
    /// The first line that is none of these, with its place.
    pub fn from_text(file: &str, text: &str) -> Result<Memory, DataError> {
        let mut memory = Memory::default();
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with(';') {
                continue;
            }
            memory.take(line).map_err(|message| DataError::Syntax {
                at: Place {
                    file: file.to_string(),
                    line: index + 1,
                    column: 1,
                },
                message,
            })?;
        }
        Ok(memory)
    }

    fn take(&mut self, line: &str) -> Result<(), String> {
        let shown: String = line.chars().take(60).collect();
        let (key, value) = line
            .split_once('=')
            .ok_or_else(|| format!("\"{shown}\" is nothing that a controller keeps"))?;
        let number = |text: &str| {
            let v: f64 = text.trim().parse().ok()?;
            v.is_finite().then_some(v)
        };
        if let Some(place) = PLACES.iter().position(|p| *p == key) {
            let figures: Vec<f64> = value.split(',').filter_map(number).collect();
            let [x, y, z] = figures[..] else {
                return Err(format!("\"{shown}\": write three numbers, X,Y,Z"));
            };
            if let Some(p) = self.places.get_mut(place) {
                *p = [x, y, z];
            }
            return Ok(());
        }
        // The firmware's own lines are plain ASCII in upper case and no longer than it can keep.
        let kept = || {
            value
                .chars()
                .filter(char::is_ascii_graphic)
                .take(crate::wire::LINE_CHARS)
                .collect()
        };
        match key {
            "$N0" => self.startup[0] = kept(),
            "$N1" => self.startup[1] = kept(),
            "$I" => self.build_text = kept(),
            _ => {
                let known = self.numbers();
                let n = key
                    .strip_prefix('$')
                    .and_then(|n| n.parse().ok())
                    .filter(|n| known.contains(n));
                let n: u16 = n.ok_or_else(|| {
                    let names: Vec<String> = known
                        .iter()
                        .map(|n| format!("${n}"))
                        .chain(PLACES.map(String::from))
                        .collect();
                    let near = nearest(key, names.iter().map(String::as_str))
                        .map_or(String::new(), |n| format!(" (did you mean {n}?)"));
                    format!("\"{shown}\" is nothing that a controller keeps{near}")
                })?;
                let v = number(value)
                    .filter(|v| *v >= 0.0)
                    .ok_or_else(|| format!("\"{shown}\": write a number, zero or more"))?;
                self.set(n, v);
            }
        }
        Ok(())
    }

    /// The numbers of all settings there are.
    fn numbers(&self) -> Vec<u16> {
        self.lines()
            .iter()
            .filter_map(|l| l.strip_prefix('$')?.split_once('=')?.0.parse().ok())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_cannot_be_kept_is_said() {
        let refused = |t: &str| Memory::from_text("e.txt", t).unwrap_err().to_string();
        assert_eq!(
            refused("\nG54=1,2\n"),
            "e.txt:2:1: \"G54=1,2\": write three numbers, X,Y,Z"
        );
        assert_eq!(
            refused("$9=1"),
            "e.txt:1:1: \"$9=1\" is nothing that a controller keeps (did you mean $0?)"
        );
        assert_eq!(
            refused("$110=-1"),
            "e.txt:1:1: \"$110=-1\": write a number, zero or more"
        );
        assert_eq!(
            refused("hello"),
            "e.txt:1:1: \"hello\" is nothing that a controller keeps"
        );
        assert!(Memory::from_text("e", "").unwrap() == Memory::default());
    }

    proptest! {
        #[test]
        fn reads_back_what_it_writes(
            values in proptest::collection::vec((0usize..34, 0.0f64..1e6), 0..10), places in proptest::collection::vec(proptest::array::uniform3(-1e3f64..1e3), 8),
            line in "[A-Z0-9.-]{0,30}",
        ) {
            let mut m = Memory::default();
            let numbers = m.numbers();
            for (k, v) in values {
                m.set(numbers[k], v);
            }
            m.places = std::array::from_fn(|i| places[i]);
            (m.startup[1], m.build_text) = (line.clone(), line);
            prop_assert_eq!(Memory::from_text("e", &m.to_text()).unwrap(), m);
        }

        #[test]
        fn never_panics(text in "[$A-Z0-9=.,;é \n-]{0,60}") {
            let _ = Memory::from_text("e", &text);
        }
    }
}
