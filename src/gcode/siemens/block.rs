//! A block of words: what stands in it, each word once, in no order.
//!
//! Crosses the border: the rest of a line in; a [`Block`] in the program's own units out, for `path` to check and carry out.

use super::codes::{code, function};
use super::keyword::Keyword;
use super::*;

/// A coordinate as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinate {
    pub value: f64,
    /// `AC(..)` (false) or `IC(..)` (true); `None`: as G90 and G91 have it.
    pub incremental: Option<bool>,
    pub at: u32,
}

/// A word's value and place.
pub(super) type Word = Option<(f64, u32)>;

/// A block's words.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    /// X, Y, Z.
    pub axes: [Option<Coordinate>; 3],
    /// I, J, K.
    pub center: [Option<Coordinate>; 3],
    pub feed: Word,
    pub speed: Word,
    pub tool: Option<(u32, u32)>,
    pub edge: Option<(u32, u32)>,
    /// CR, AR, TURN.
    pub radius: Word,
    pub angle: Word,
    pub turns: Word,
    pub adis: Word,
    pub tolerance: Word,
    /// G codes with their places, one of each group.
    pub codes: Vec<(u32, u32)>,
    /// M functions with their places.
    pub functions: Vec<(u32, u32)>,
    /// SUPA.
    pub suppress: bool,
    pub compressor: Option<bool>,
    pub stop_preprocessing: bool,
    /// A variable is assigned.
    pub assigns: Option<u32>,
}

impl Block {
    /// The code of one of these, with its place.
    pub fn code(&self, of: impl Fn(u32) -> bool) -> Option<(u32, u32)> {
        self.codes.iter().copied().find(|c| of(c.0))
    }
}

/// A number right behind a word (`X-1.5`), or an expression behind `=` (`X=R1+2`).
pub(super) fn plain(job: &mut Job, name: &str) -> Result<f64, Fault> {
    if job.scan.blanks().take(b'=') {
        return expression::number(job, name);
    }
    let minus = job.scan.take(b'-');
    if !minus {
        job.scan.take(b'+');
    }
    let at = job.scan.at();
    match job.scan.number(false) {
        Some(v) => Ok(if minus { -v } else { v }),
        None => {
            let name = Name::of(name);
            wrong(at, Wrong::NumberMissing { name })
        }
    }
}

/// A whole number of zero or more.
pub(super) fn whole(job: &mut Job, name: &str, most: u32, at: u32) -> Result<u32, Fault> {
    let v = plain(job, name)?;
    if v.fract() != 0.0 || !(0.0..=f64::from(most)).contains(&v) {
        return range(at, name, "a whole number of zero or more");
    }
    Ok(v as u32)
}

/// X, I and their like, with `AC(..)` and `IC(..)`.
fn coordinate(job: &mut Job, name: &str, at: u32) -> Result<Coordinate, Fault> {
    let mut ahead = job.scan.clone();
    if ahead.blanks().take(b'=') {
        let kind = ahead.blanks().run(|b| b.is_ascii_alphabetic());
        let kind = kind.to_ascii_uppercase();
        if ahead.blanks().peek() == Some(b'(') {
            let incremental = match kind.as_str() {
                "AC" => Some(false),
                "IC" => Some(true),
                "DC" | "ACP" | "ACN" | "CAC" | "CIC" => {
                    return refuse(at, &kind, "it is for rotary axes; write AC or IC");
                }
                _ => None,
            };
            if incremental.is_some() {
                job.scan = ahead;
                // The parenthesis is read as part of the expression, which ends with it.
                job.scan.take(b'(');
                let value = expression::number(job, name)?;
                if !job.scan.blanks().take(b')') {
                    let what = "a closing parenthesis";
                    return wrong(job.scan.at(), Wrong::Expected { what });
                }
                return Ok(Coordinate {
                    value,
                    incremental,
                    at,
                });
            }
        }
    }
    Ok(Coordinate {
        value: plain(job, name)?,
        incremental: None,
        at,
    })
}

/// Puts a word into its place.
fn once<T>(slot: &mut Option<T>, value: T, name: &str, at: u32) -> Result<(), Fault> {
    if slot.replace(value).is_some() {
        let name = Name::of(name);
        return wrong(at, Wrong::Repeated { name });
    }
    Ok(())
}

/// Reads and carries out a block of words.
pub(super) fn block(job: &mut Job) -> Said {
    let mut block = Block::default();
    loop {
        let at = job.scan.blanks().at();
        if matches!(job.scan.peek(), None | Some(b';')) {
            return path::carry_out(job, &block);
        }
        let letters = job
            .scan
            .clone()
            .run(|b| b.is_ascii_alphabetic() || b == b'_');
        match letters.len() {
            0 if job.scan.peek() == Some(b'$') => {
                return refuse(
                    at,
                    "$",
                    "system variables are the control's, and not known here",
                );
            }
            0 => return job.not_understood(),
            1 => {
                job.scan.skip(1);
                let letter = letters.as_bytes().first().copied().unwrap_or_default();
                address(job, &mut block, letter.to_ascii_uppercase(), at)?;
            }
            _ => name(job, &mut block, at)?,
        }
    }
}

/// A word of one letter.
fn address(job: &mut Job, block: &mut Block, letter: u8, at: u32) -> Result<(), Fault> {
    let text = [letter];
    let text = std::str::from_utf8(&text).unwrap_or_default();
    // `S1=1000`: a letter with a number of its own.
    let mut ahead = job.scan.clone();
    let extension = ahead.run(|b| b.is_ascii_digit());
    let extended = !extension.is_empty()
        && ahead.blanks().peek() == Some(b'=')
        && ahead.ahead(1) != Some(b'=');
    if letter == b'R' && (extended || job.scan.blanks().peek() == Some(b'[')) {
        let number = assign::r_number(job, 0)?;
        if !job.scan.blanks().take(b'=') {
            let what = "=";
            return wrong(job.scan.at(), Wrong::Expected { what });
        }
        block.assigns.get_or_insert(at);
        return assign::set_r(job, number);
    }
    if extended {
        let name = format!("{text}{extension}");
        match (letter, extension) {
            (b'S' | b'M', "1") => job.scan.skip(1),
            (b'S' | b'M', _) => {
                return refuse(at, &name, "this machine has one spindle; write S and M3");
            }
            (b'I' | b'J' | b'K', "1") => {
                return refuse(at, &name, "write the arc as G2 or G3 with I J K or CR");
            }
            _ => {
                let name = Name::of(&name);
                return wrong(at, Wrong::NotUnderstood { name });
            }
        }
    }
    match letter {
        b'X'..=b'Z' => {
            let c = coordinate(job, text, at)?;
            once(&mut block.axes[usize::from(letter - b'X')], c, text, at)
        }
        b'I'..=b'K' => {
            let c = coordinate(job, text, at)?;
            once(&mut block.center[usize::from(letter - b'I')], c, text, at)
        }
        b'G' => code(job, block, at),
        b'M' => function(job, block, at),
        b'F' => {
            let v = (plain(job, text)?, at);
            once(&mut block.feed, v, text, at)
        }
        b'S' => {
            let v = (plain(job, text)?, at);
            once(&mut block.speed, v, text, at)
        }
        b'D' => {
            let v = (whole(job, text, 31999, at)?, at);
            once(&mut block.edge, v, text, at)
        }
        b'T' => {
            let v = (tool(job, at)?, at);
            once(&mut block.tool, v, text, at)
        }
        b'A' | b'B' | b'C' | b'U' | b'V' | b'W' => refuse(
            at,
            text,
            "this machine has X, Y and Z only; post the program for three axes",
        ),
        _ => {
            job.scan.back(at);
            job.not_understood()
        }
    }
}

/// `T5`, `T="MILL_10"`.
fn tool(job: &mut Job, at: u32) -> Result<u32, Fault> {
    let mut ahead = job.scan.clone();
    if !(ahead.blanks().take(b'=') && ahead.blanks().peek() == Some(b'"')) {
        let number = whole(job, "T", 99_999_999, at)?;
        return numbered(job, number, at);
    }
    job.scan = ahead;
    let Some(text) = job.scan.quoted() else {
        return missing(job.scan.at(), "T", "a closing quotation mark");
    };
    if let Ok(number) = text.parse::<u32>() {
        return numbered(job, number, at);
    }
    if job.modes.numbered {
        return wrong(at, Wrong::ToolsMixed);
    }
    let name = Name::of(text);
    if text.trim().is_empty() || name.text() != text {
        return range(at, "T", "names of 1 to 31 characters");
    }
    let known = job.tools.iter().position(|t| *t == name);
    let index = known.unwrap_or_else(|| {
        job.tool = Some(name);
        job.tools.len()
    });
    Ok(u32::try_from(index + 1).unwrap_or(u32::MAX))
}

/// A tool by its number; 0 is none.
fn numbered(job: &mut Job, number: u32, at: u32) -> Result<u32, Fault> {
    if number > 0 && (!job.tools.is_empty() || job.tool.is_some()) {
        return wrong(at, Wrong::ToolsMixed);
    }
    job.modes.numbered |= number > 0;
    Ok(number)
}

/// A word of several letters.
fn name(job: &mut Job, block: &mut Block, at: u32) -> Result<(), Fault> {
    let run = job.scan.run(|b| b.is_ascii_alphanumeric() || b == b'_');
    let upper = run.to_ascii_uppercase();
    let equals = job.scan.clone().blanks().peek() == Some(b'=');
    if equals {
        let slot = match upper.as_str() {
            "CR" => Some(&mut block.radius),
            "AR" => Some(&mut block.angle),
            "TURN" => Some(&mut block.turns),
            "ADIS" => Some(&mut block.adis),
            "CTOL" => Some(&mut block.tolerance),
            // Rounding of rapids, tolerance of rotary axes: nothing that cuts.
            "ADISPOS" | "OTOL" => {
                plain(job, &upper)?;
                return Ok(());
            }
            _ => None,
        };
        if let Some(slot) = slot {
            let v = (plain(job, &upper)?, at);
            return once(slot, v, &upper, at);
        }
        if let Some(why) = keyword::refused(&upper) {
            return refuse(at, &upper, why);
        }
        job.scan.blanks().take(b'=');
        block.assigns.get_or_insert(at);
        return assign::set(job, &upper, at);
    }
    match keyword::known(&upper) {
        Some(Keyword::Nothing) => return Ok(()),
        Some(Keyword::Suppress) => {
            block.suppress = true;
            return Ok(());
        }
        Some(Keyword::Compressor(on)) => return once(&mut block.compressor, on, &upper, at),
        Some(Keyword::StopPreprocessing) => {
            block.stop_preprocessing = true;
            return Ok(());
        }
        None => {}
    }
    if let Some(why) = keyword::refused(&upper) {
        return refuse(at, &upper, why);
    }
    if upper == "MSG" {
        return program::message(job, at);
    }
    if job.scan.blanks().peek() == Some(b'(') {
        return refuse(
            at,
            &upper,
            "a cycle or subprogram with arguments is not read; post the motions themselves",
        );
    }
    let own = [
        "IF",
        "ELSE",
        "ENDIF",
        "GOTO",
        "GOTOF",
        "GOTOB",
        "REPEAT",
        "DEF",
        "PROC",
        "RET",
        "MSG",
        "TRANS",
        "ATRANS",
        "ROT",
        "AROT",
        "SCALE",
        "ASCALE",
        "MIRROR",
        "AMIRROR",
        "MCALL",
        "WORKPIECE",
    ];
    let name = Name::of(&upper);
    if own.contains(&upper.as_str()) {
        return wrong(at, Wrong::Alone { name });
    }
    wrong(at, Wrong::Undefined { name })
}
