//! What orders blocks: IF, ELSE, ENDIF, the GOTO family, REPEAT, and calls of subprograms by name.
//!
//! A branch that is not taken is read past, line by line; loops (WHILE, FOR, LOOP, REPEAT with UNTIL) would need a way back that the
//! order of lines does not have here, and are refused.

use super::*;

/// Control structures inside each other (the control's limit).
const DEEPEST: u32 = 16;

/// The IFs that are open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Ifs {
    /// How many are open and entered.
    open: u32,
    /// Bit n: the n-th has had its ELSE.
    else_seen: u32,
    /// Zero: blocks are carried out. Else the depth inside the branch that is read past.
    skip: u32,
    /// The branch is one that may still have an ELSE.
    else_may_follow: bool,
    /// A jump or return was taken: which IFs are open is not known any more.
    jumped: bool,
    /// The line of the IF or ELSE whose branch is read past.
    since: usize,
}

impl Ifs {
    /// Blocks are read past.
    pub fn skips(&self) -> bool {
        self.skip > 0
    }

    /// The line from which on.
    pub fn since(&self) -> usize {
        self.since
    }

    /// A jump was taken.
    pub fn jump(&mut self) {
        (self.open, self.else_seen, self.jumped) = (0, 0, true);
    }
}

/// A line inside a branch that is not taken: only the IFs in it count.
pub(super) fn passed(job: &mut Job, word: &str) {
    let structured = word == "IF" && !jumps(job.scan.rest());
    let ifs = &mut job.modes.ifs;
    match word {
        "IF" if structured => ifs.skip = ifs.skip.saturating_add(1),
        "ELSE" if ifs.skip == 1 && ifs.else_may_follow => {
            ifs.skip = 0;
            ifs.else_seen |= 1 << ifs.open.min(31);
        }
        "ENDIF" if ifs.skip == 1 => {
            ifs.skip = 0;
            ifs.close();
        }
        "ENDIF" => ifs.skip -= 1,
        _ => {}
    }
}

impl Ifs {
    fn close(&mut self) {
        self.else_seen &= !(1 << self.open.min(31));
        self.open = self.open.saturating_sub(1);
    }
}

/// The condition is followed by a jump: an IF that has no ENDIF.
fn jumps(rest: &str) -> bool {
    let code = rest.split(';').next().unwrap_or_default();
    let words = code.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    words.into_iter().any(|w| {
        matches!(
            w.to_ascii_uppercase().as_str(),
            "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" | "GOTOS"
        )
    })
}

/// `IF cond GOTOF LABEL`, or `IF cond` alone.
pub(super) fn if_(job: &mut Job, at: u32) -> Said {
    let holds = expression::condition(job)?;
    job.scan.blanks();
    let word = job.scan.run(|b| b.is_ascii_alphabetic());
    if !word.is_empty() {
        let flow = goto(job, &word.to_ascii_uppercase(), at)?;
        if !holds {
            return Ok(Flow::Next);
        }
        job.modes.ifs.jump();
        return Ok(flow);
    }
    job.end_of_block()?;
    let line = job.desk.line;
    let ifs = &mut job.modes.ifs;
    if ifs.open >= DEEPEST {
        return refuse(
            at,
            "more than 16 IFs inside each other",
            "split the program",
        );
    }
    ifs.open += 1;
    ifs.else_seen &= !(1 << ifs.open.min(31));
    if !holds {
        (ifs.skip, ifs.else_may_follow, ifs.since) = (1, true, line);
    }
    Ok(Flow::Next)
}

/// ELSE behind a branch that was taken: what follows is read past.
pub(super) fn else_(job: &mut Job, at: u32) -> Said {
    job.end_of_block()?;
    let line = job.desk.line;
    let ifs = &mut job.modes.ifs;
    let seen = ifs.else_seen & (1 << ifs.open.min(31)) != 0;
    if (ifs.open == 0 && !ifs.jumped) || (ifs.open > 0 && seen) {
        let name = Name::of("ELSE");
        return wrong(at, Wrong::IfMissing { name });
    }
    (ifs.skip, ifs.else_may_follow, ifs.since) = (1, false, line);
    Ok(Flow::Next)
}

/// ENDIF behind a branch that was taken.
pub(super) fn endif(job: &mut Job, at: u32) -> Said {
    job.end_of_block()?;
    let ifs = &mut job.modes.ifs;
    if ifs.open == 0 && !ifs.jumped {
        let name = Name::of("ENDIF");
        return wrong(at, Wrong::IfMissing { name });
    }
    ifs.close();
    Ok(Flow::Next)
}

/// What stands behind GOTO, GOTOF, GOTOB.
pub(super) fn goto(job: &mut Job, word: &str, at: u32) -> Said {
    let forward = match word {
        "GOTO" => None,
        "GOTOF" => Some(true),
        "GOTOB" => Some(false),
        "GOTOC" | "GOTOS" => {
            return refuse(at, word, "write GOTOF or GOTOB with a label");
        }
        _ => {
            let what = "GOTOF or GOTOB with a label, or the end of the block";
            return wrong(at, Wrong::Expected { what });
        }
    };
    let label = target(job, word)?;
    job.end_of_block()?;
    Ok(Flow::Goto { label, forward })
}

/// A label where one must stand.
fn target(job: &mut Job, command: &str) -> Result<Label, Fault> {
    let at = job.scan.blanks().at();
    let colon = job.scan.take(b':');
    let name = job.scan.run(|b| b.is_ascii_alphanumeric() || b == b'_');
    if name.is_empty() || (colon && !name.bytes().all(|b| b.is_ascii_digit())) {
        return missing(at, command, "a label or a block number");
    }
    let colon = if colon { ":" } else { "" };
    Ok(format!("{colon}{}", name.to_ascii_uppercase()).into())
}

/// `P=3` or `P3`: how often; 1 when there is none.
fn times(job: &mut Job) -> Result<u32, Fault> {
    let at = job.scan.blanks().at();
    if !job.scan.take_text("P") {
        return Ok(1);
    }
    let n = match job.scan.blanks().take(b'=') {
        true => expression::number(job, "P")?,
        false => match job.scan.number(false) {
            Some(n) => n,
            None => return missing(at, "P", "a whole number from 1 to 9999"),
        },
    };
    if n.fract() != 0.0 || !(1.0..=9999.0).contains(&n) {
        return range(at, "P", "a whole number from 1 to 9999");
    }
    Ok(n as u32)
}

/// `REPEAT LABEL P=3`: from the label to here, three times more.
pub(super) fn repeat(job: &mut Job, at: u32) -> Said {
    if matches!(job.scan.blanks().peek(), None | Some(b';')) {
        return refuse(at, "REPEAT with UNTIL", LOOPS);
    }
    let label = target(job, "REPEAT")?;
    let place = job.scan.blanks().at();
    let times = times(job)?;
    if job
        .scan
        .blanks()
        .peek()
        .is_some_and(|b| b.is_ascii_alphabetic())
    {
        return refuse(
            place,
            "REPEAT with two labels",
            "write the section as a subprogram",
        );
    }
    job.end_of_block()?;
    Ok(Flow::Repeat { label, times })
}

/// Why loops are refused.
pub(super) const LOOPS: &str = "loops of this kind are not read; write a label with IF and GOTOB";

/// `NAME`, `NAME P3`, `L10`: a subprogram of the same archive.
pub(super) fn call(job: &mut Job, name: &str) -> Said {
    let times = times(job)?;
    job.end_of_block()?;
    // The blocks of a subprogram have IFs of their own.
    job.modes.ifs.jump();
    // Each of its runs ends with a return.
    job.modes.depth = job.modes.depth.saturating_add(times);
    let label = format!("%_N_{name}_SPF").into();
    Ok(Flow::Call { label, times })
}
