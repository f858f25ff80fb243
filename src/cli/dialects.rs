//! `morsemill dialects [NAME]`: what the reader understands of each controller, printed from the rules it reads by.

use super::{Failure, output};
use crate::gcode::Dialect;
use crate::gcode::rules::{Row, table};
use clap::Args;
use std::io::{self, Write};
use std::process::ExitCode;

/// What to list.
#[derive(Debug, Args)]
pub struct DialectsArgs {
    /// A dialect: its codes, words and assumptions. Without one: all dialects, one a line
    name: Option<String>,
}

/// Lists all dialects, or all about one. An unknown name could not be carried out.
///
/// # Errors
/// An unknown name, with the nearest known ones.
pub fn run(args: &DialectsArgs) -> Result<ExitCode, Failure> {
    let Some(name) = &args.name else {
        return output::to_stdout(list);
    };
    let Some(dialect) = Dialect::from_name(name) else {
        let known: Vec<&str> = Dialect::ALL.iter().map(|d| d.name()).collect();
        let known = known.join(", ");
        return Err(Failure::failed(format!(
            "there is no dialect {name:?}: name one of {known}"
        )));
    };
    output::to_stdout(|out| describe(dialect, out))
}

/// All dialects: name, what is understood and refused, title.
fn list(out: &mut dyn Write) -> io::Result<()> {
    let width = Dialect::ALL
        .iter()
        .map(|d| d.name().len())
        .max()
        .unwrap_or(0);
    writeln!(
        out,
        "  {:width$}  {:>5}  {:>7}  what it is",
        "dialect", "codes", "refused"
    )?;
    for dialect in Dialect::ALL {
        let t = table(dialect);
        let refused = t.codes.iter().filter(|c| !c.understood).count();
        let understood = t.codes.len() - refused;
        let name = dialect.name();
        writeln!(
            out,
            "  {name:width$}  {understood:>5}  {refused:>7}  {}",
            t.title
        )?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "refused: known, and refused by name. Any other code is refused as unknown. All about one: morsemill dialects NAME"
    )
}

/// All about one dialect.
fn describe(dialect: Dialect, out: &mut dyn Write) -> io::Result<()> {
    let t = table(dialect);
    writeln!(out, "{}: {}", dialect.name(), t.title)?;
    if !t.source.is_empty() {
        writeln!(out, "from: {}", t.source)?;
    }
    block(out, "understood", t.codes.iter().filter(|c| c.understood))?;
    let refused = t.codes.iter().filter(|c| !c.understood);
    block(out, "refused by name", refused.chain(&t.refused_letters))?;
    if !t.letters.is_empty() {
        writeln!(out, "\nwords: {}", t.letters)?;
    }
    for line in &t.lines {
        writeln!(out, "  {line}")?;
    }
    if !t.assumed.is_empty() {
        writeln!(out, "\nassumed, where the control goes by a setting")?;
    }
    for line in t.assumed {
        writeln!(out, "  {line}")?;
    }
    Ok(())
}

fn block<'a>(
    out: &mut dyn Write,
    title: &str,
    rows: impl Iterator<Item = &'a Row>,
) -> io::Result<()> {
    let rows: Vec<&Row> = rows.collect();
    if rows.is_empty() {
        return Ok(());
    }
    let width = rows.iter().map(|r| r.code.len()).max().unwrap_or(0);
    writeln!(out, "\n{title}")?;
    for row in rows {
        writeln!(out, "  {:width$}  {}", row.code, row.text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lists_every_dialect_once() {
        let mut out = Vec::new();
        list(&mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        for d in Dialect::ALL {
            let front = format!("  {} ", d.name());
            assert_eq!(
                text.lines().filter(|l| l.starts_with(&front)).count(),
                1,
                "{text}"
            );
        }
    }

    #[test]
    fn tells_what_is_understood_and_what_is_refused() {
        let mut out = Vec::new();
        describe(Dialect::Okuma, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let (understood, refused) = text.split_once("refused by name").unwrap();
        assert!(understood.contains("  G15 H1..200"), "{text}");
        assert!(refused.contains("  G43 "), "{text}");
        assert!(!understood.contains("  G43 "), "{text}");
    }

    #[test]
    fn an_unknown_name_gets_the_known_ones() {
        let name = Some("gerbl".into());
        let Err(Failure::Failed(text)) = run(&DialectsArgs { name }) else {
            panic!()
        };
        assert!(
            text.contains("\"gerbl\"") && text.contains("grbl, grblhal"),
            "{text}"
        );
    }
}
