//! Where the lines are that a program jumps to: found by reading on (or from the top), and remembered.
//!
//! Crosses the border: a [`Source`] in, put back where it stood; places of lines out. What is remembered is bounded: programs by number, and the
//! last few thousand jumps.

use crate::gcode::source::{LineStart, Source};
use std::collections::HashMap;
use std::io::{self, BufRead, Seek};

/// So many places are remembered at once.
const REMEMBERED: usize = 10_000;
/// Most programs of one file.
const PROGRAMS: usize = 100_000;

/// A line found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// Where it begins.
    pub line: LineStart,
    /// Where the next one begins.
    pub behind: LineStart,
    /// Which of the things looked for it is.
    pub kind: u8,
}

/// A program's or subroutine's first line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Start {
    /// The line.
    pub found: Found,
    /// The line of a second one of the same name.
    pub second: Option<usize>,
}

/// What was found before.
#[derive(Debug, Default)]
pub(super) struct Labels {
    /// By name; `None`: not yet looked.
    programs: Option<HashMap<Box<str>, Start>>,
    /// By the line that looked and for what.
    jumps: HashMap<(usize, Box<str>), Option<Found>>,
}

impl Labels {
    /// The first line of a program or subroutine, by name. `name` tells what a line begins.
    pub fn program<R: BufRead + Seek>(
        &mut self,
        source: &mut Source<R>,
        label: &str,
        mut name: impl FnMut(&str) -> Option<Box<str>>,
    ) -> io::Result<Option<Start>> {
        if self.programs.is_none() {
            let mut all: HashMap<Box<str>, Start> = HashMap::new();
            let mut visit = |found: Found, text: &str| {
                if let Some(name) = name(text)
                    && all.len() < PROGRAMS
                {
                    let again = found.line.line;
                    let entry = all.entry(name);
                    entry
                        .and_modify(|s| s.second = s.second.or(Some(again)))
                        .or_insert(Start {
                            found,
                            second: None,
                        });
                }
                true
            };
            let back = source.place();
            source.rewind()?;
            walk(source, usize::MAX, &mut visit)?;
            source.go(back)?;
            self.programs = Some(all);
        }
        Ok(self.programs.as_ref().and_then(|p| p.get(label)).copied())
    }

    /// The first line that is one of those looked for, from where the source stands, up to the line `end` (exclusive); a line of kind `STOP`
    /// ends the search. `from` and `what` name the search.
    pub fn ahead<R: BufRead + Seek>(
        &mut self,
        source: &mut Source<R>,
        (from, what): (usize, &str),
        end: usize,
        mut kind: impl FnMut(&str) -> Option<u8>,
    ) -> io::Result<Option<Found>> {
        let key = (from, Box::from(what));
        if let Some(known) = self.jumps.get(&key) {
            return Ok(*known);
        }
        let back = source.place();
        let mut hit = None;
        walk(source, end, &mut |found, text| match kind(text) {
            Some(STOP) => false,
            Some(kind) => {
                hit = Some(Found { kind, ..found });
                false
            }
            None => true,
        })?;
        source.go(back)?;
        if self.jumps.len() >= REMEMBERED {
            self.jumps.clear();
        }
        self.jumps.insert(key, hit);
        Ok(hit)
    }
}

/// A line behind which nothing is looked for.
pub(super) const STOP: u8 = u8::MAX;

/// Reads lines until `visit` has enough, or the text or the line `end` is reached.
fn walk<R: BufRead + Seek>(
    source: &mut Source<R>,
    end: usize,
    visit: &mut impl FnMut(Found, &str) -> bool,
) -> io::Result<()> {
    loop {
        let line = source.place();
        if line.line >= end {
            return Ok(());
        }
        if source.read()?.is_none() {
            return Ok(());
        }
        let (behind, kind) = (source.place(), 0);
        if !visit(Found { line, behind, kind }, source.last()) {
            return Ok(());
        }
    }
}
