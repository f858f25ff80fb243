//! `morsemill machines`: the machines that come with the program.

use crate::machine::{BUILT_IN, DEFAULT_MACHINE, DataError, Machine};
use std::io::{self, Write};

/// Lists the built-in machines as text, one a line: name, travels in mm, controller, title; the default is marked. Fails only when
/// `out` does, or when a built-in file is broken (which a test excludes).
pub fn run(out: &mut dyn Write) -> io::Result<()> {
    let machines = BUILT_IN
        .iter()
        .map(|(name, text)| Machine::from_toml(name, text))
        .collect::<Result<Vec<_>, DataError>>()
        .map_err(io::Error::other)?;
    let width = machines.iter().map(|m| m.name.len()).max().unwrap_or(0);
    writeln!(
        out,
        "  {:width$}  {:>18}  {:10}  what it is",
        "machine", "travel X Y Z, mm", "controller"
    )?;
    for m in &machines {
        let mark = if m.name == DEFAULT_MACHINE { '*' } else { ' ' };
        let [x, y, z] = m.travel;
        let travel = format!("{} x {} x {}", x.0, y.0, z.0);
        writeln!(
            out,
            "{mark} {:width$}  {travel:>18}  {:10}  {}",
            m.name, m.controller, m.title
        )?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "* is used when no --machine is given. A file of your own works as well: --machine ./mine.toml"
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lists_each_machine_once_and_marks_the_default() {
        let mut out = Vec::new();
        run(&mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        for (name, _) in BUILT_IN {
            assert_eq!(
                text.lines()
                    .filter(|l| l
                        .get(2..)
                        .is_some_and(|l| l.starts_with(&format!("{name} "))))
                    .count(),
                1,
                "{text}"
            );
        }
        assert!(
            text.contains(
                "* longmill-30x30      792 x 845 x 114  grbl        Sienci LongMill MK2 30x30"
            ),
            "{text}"
        );
        assert_eq!(text.matches('*').count(), 2, "one mark and its legend");
    }
}
