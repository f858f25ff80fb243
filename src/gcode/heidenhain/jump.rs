//! LBL, CALL LBL, CALL PGM, and the label behind GOTO.

use super::*;

/// The label behind LBL: `LBL5`, `LBL"NAME"`; `None` when there is none.
pub(super) fn name(scan: &mut Scan) -> Option<Label> {
    scan.blanks();
    if scan.peek() == Some(b'"') {
        let name = scan.quoted()?.trim();
        let plain = !name.is_empty();
        return plain.then(|| format!("LBL\"{}\"", name.to_uppercase()).into());
    }
    let digits = scan.run(|b| b.is_ascii_digit());
    let number: u32 = digits.parse().ok().filter(|n| *n <= 65535)?;
    Some(format!("LBL{number}").into())
}

/// The same, where there must be one that can be jumped to.
pub(super) fn target(job: &mut Job, command: &'static str) -> Result<Label, Fault> {
    let at = job.scan.blanks().at();
    match name(&mut job.scan) {
        Some(label) if *label != *"LBL0" => Ok(label),
        _ => {
            let what = "a label: a number from 1 to 65535, or a name in quotation marks";
            wrong(at, Wrong::Missing { command, what })
        }
    }
}

/// `LBL 5` is passed; `LBL 0` ends the subprogram, and is passed where none was called.
pub(super) fn label(job: &mut Job, at: u32) -> Said {
    let Some(label) = name(&mut job.scan) else {
        let (command, what) = (
            "LBL",
            "a number from 0 to 65535, or a name in quotation marks",
        );
        return wrong(at, Wrong::Missing { command, what });
    };
    job.end_of_block()?;
    if *label == *"LBL0" && job.modes.depth > 0 {
        job.modes.depth -= 1;
        return Ok(Flow::Return);
    }
    Ok(Flow::Next)
}

/// `CALL LBL 5` calls a subprogram; `CALL LBL 5 REP 3` runs from the label to here three times more.
pub(super) fn call(job: &mut Job, at: u32) -> Said {
    if job.scan.blanks().take_text("PGM") {
        return refuse(
            at,
            "CALL PGM",
            "another file is not read; write its blocks into this one, as a subprogram",
        );
    }
    if job.scan.take_text("SELECTED") {
        return refuse(
            at,
            "CALL SELECTED",
            "another file is not read; write its blocks into this one, as a subprogram",
        );
    }
    if !job.scan.take_text("LBL") {
        let (command, what) = ("CALL", "LBL");
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    let label = target(job, "CALL LBL")?;
    let at = job.scan.blanks().at();
    if !job.scan.take_text("REP") {
        job.end_of_block()?;
        job.modes.depth = job.modes.depth.saturating_add(1);
        return Ok(Flow::Call { label, times: 1 });
    }
    let times = words::whole(job, "REP", 65534, "a whole number from 0 to 65534")?;
    if job.scan.take(b'/') {
        // Older controls write how many are left behind the number: all of them, before the program runs.
        let left = words::whole(job, "REP", 65534, "a whole number from 0 to 65534")?;
        if left != times {
            let (name, range) = (
                Name::of("REP"),
                "the same number before and behind the slash",
            );
            return wrong(at, Wrong::Range { name, range });
        }
    }
    job.end_of_block()?;
    Ok(match times {
        0 => Flow::Next,
        _ => Flow::Repeat { label, times },
    })
}
