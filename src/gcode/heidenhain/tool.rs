//! TOOL CALL and TOOL DEF.

use super::super::state::Units;
use super::*;
use crate::units::{MmPerMin, Rpm};

/// `TOOL CALL 3 Z S5000 F300`, `TOOL CALL "MILL" Z`, `TOOL CALL S8000` (speed only), `TOOL DEF 4`.
pub(super) fn tool(job: &mut Job, at: u32) -> Result<(), Fault> {
    if job.scan.blanks().take_text("DEF") {
        return define(job);
    }
    if !job.scan.take_text("CALL") {
        let (command, what) = ("TOOL", "CALL or DEF");
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    let number = number(job)?;
    let mut speed = None;
    let mut feed = None;
    let mut axis = false;
    loop {
        let at = job.scan.blanks().at();
        if matches!(job.scan.peek(), None | Some(b';')) {
            break;
        }
        let word = job
            .scan
            .run(|b| b.is_ascii_alphabetic() && !matches!(b, b'Q' | b'q'));
        let again = match word {
            "Z" => std::mem::replace(&mut axis, true),
            "X" | "Y" => return refuse(at, "TOOL CALL", "the tool axis must be Z"),
            "S" => speed.replace((words::value(job, "S")?, at)).is_some(),
            "F" => feed.replace((words::value(job, "F")?, at)).is_some(),
            "DL" | "DR" => {
                if words::value(job, word)? != 0.0 {
                    return refuse(
                        at,
                        word,
                        "it changes the tool by an amount that moves the path; write it into the program's path",
                    );
                }
                false
            }
            _ => {
                job.scan.back(at);
                return job.not_understood();
            }
        };
        if again {
            let name = Name::of(word);
            return wrong(at, Wrong::Repeated { name });
        }
    }
    for (word, value) in [("S", speed), ("F", feed)] {
        if let Some((value, at)) = value
            && value < 0.0
        {
            let (name, range) = (Name::of(word), "a number of zero or more");
            return wrong(at, Wrong::Range { name, range });
        }
    }
    if number.is_none() && speed.is_none() && feed.is_none() {
        let (command, what) = ("TOOL CALL", "a tool number, or S");
        return wrong(at, Wrong::Missing { command, what });
    }
    if let Some(number) = number {
        job.desk.tool(number);
        job.modes.auto_feed = 0.0;
    }
    if let Some((speed, _)) = speed {
        let direction = job.desk.state.spindle;
        job.desk.spindle(direction, Rpm(speed));
    }
    if let Some((feed, _)) = feed {
        // In INCH programs F is in tenths of an inch per minute.
        let mm = match job.desk.state.units {
            Units::Mm => feed,
            Units::Inch => feed * 2.54,
        };
        job.modes.auto_feed = mm;
        job.desk.state.feed = MmPerMin(mm);
    }
    Ok(())
}

/// The tool, by number or name.
fn number(job: &mut Job) -> Result<Option<u32>, Fault> {
    let at = job.scan.blanks().at();
    let number = match job.scan.peek() {
        Some(b'0'..=b'9' | b'+' | b'Q' | b'q') => {
            words::whole(job, "TOOL CALL", 32767, "a tool number from 0 to 32767")?
        }
        Some(b'"') => {
            let Some(text) = job.scan.quoted() else {
                let (command, what) = ("TOOL CALL", "a closing quotation mark behind the name");
                return wrong(at, Wrong::Missing { command, what });
            };
            match text.parse::<u32>() {
                Ok(number) if number <= 32767 => number,
                _ => return named(job, text, at).map(Some),
            }
        }
        _ => return Ok(None),
    };
    if number > 0 && (!job.tools.is_empty() || job.tool.is_some()) {
        return wrong(at, Wrong::ToolsMixed);
    }
    job.modes.numbered |= number > 0;
    Ok(Some(number))
}

/// The number of a named tool: names are counted as they come.
fn named(job: &mut Job, text: &str, at: u32) -> Result<u32, Fault> {
    if job.modes.numbered {
        return wrong(at, Wrong::ToolsMixed);
    }
    let name = Name::of(text);
    if text.trim().is_empty() || name.text() != text {
        let (name, range) = (Name::of("TOOL CALL"), "names of 1 to 31 characters");
        return wrong(at, Wrong::Range { name, range });
    }
    let known = job.tools.iter().position(|t| *t == name);
    let index = known.unwrap_or_else(|| {
        job.tool = Some(name);
        job.tools.len()
    });
    Ok(u32::try_from(index + 1).unwrap_or(u32::MAX))
}

/// `TOOL DEF 4` makes the next tool ready, `TOOL DEF 4 L+0 R+5` describes it. Nothing moves.
fn define(job: &mut Job) -> Result<(), Fault> {
    job.scan.blanks();
    if job.scan.quoted().is_none() {
        words::whole(job, "TOOL DEF", 32767, "a tool number from 0 to 32767")?;
    }
    while !matches!(job.scan.blanks().peek(), None | Some(b';')) {
        let at = job.scan.at();
        let word = job.scan.run(|b| b.is_ascii_alphabetic());
        if !matches!(word, "L" | "R") {
            job.scan.back(at);
            return job.not_understood();
        }
        words::value(job, word)?;
    }
    Ok(())
}
