//! `morsemill posts`: the dialects that come with the program.

use crate::machine::DataError;
use crate::post::{BUILT_IN, Post};
use std::io::{self, Write};

/// Lists the built-in dialects as text, one a line: name, title. Fails only when `out` does, or when a built-in file is broken
/// (which a test excludes).
pub fn run(out: &mut dyn Write) -> io::Result<()> {
    let posts = BUILT_IN
        .iter()
        .map(|(name, text)| Post::from_toml(name, text))
        .collect::<Result<Vec<_>, DataError>>()
        .map_err(io::Error::other)?;
    let width = posts.iter().map(|p| p.name.len()).max().unwrap_or(0);
    writeln!(out, "  {:width$}  what it is", "post")?;
    for p in &posts {
        writeln!(out, "  {:width$}  {}", p.name, p.title)?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "A machine names its own post; --post overrides it. A file of your own works as well: --post ./mine.toml"
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lists_each_post_once() {
        let mut out = Vec::new();
        run(&mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        for (name, _) in BUILT_IN {
            assert_eq!(
                text.lines()
                    .filter(|l| l.starts_with(&format!("  {name} ")))
                    .count(),
                1,
                "{text}"
            );
        }
        assert!(text.contains("  grbl      GRBL 1.1"), "{text}");
    }
}
