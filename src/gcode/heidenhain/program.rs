//! Which block a line is, and the blocks that frame a program: BEGIN PGM, END PGM, BLK FORM, comments, STOP.

use super::super::state::Units;
use super::*;

/// Why functions are refused that move the tool beside the programmed path.
const COMPENSATION: &str =
    "it moves the path sideways by the tool's radius; post the centre's path with R0";
/// Why five-axis functions are refused.
const FIVE_AXES: &str = "it tilts or turns the tool, and this machine has three axes; remove it";

/// Carries out one block.
pub(super) fn block(job: &mut Job) -> Said {
    if job.modes.cycle_open {
        cycle::continued(job)?;
        return Ok(Flow::Next);
    }
    front(&mut job.scan);
    let at = job.scan.at();
    if matches!(job.scan.peek(), None | Some(b';' | b'*')) {
        return Ok(Flow::Next);
    }
    if job.scan.peek() == Some(b'/') {
        return refuse(
            at,
            "/",
            "whether the operator skips such blocks is not known; write the block without / or remove it",
        );
    }
    let word = job.scan.run(|b| b.is_ascii_alphabetic());
    let word = word.to_ascii_uppercase();
    if word == "BEGIN" {
        begin(job, at)?;
        return Ok(Flow::Next);
    }
    if job.modes.program.is_none() {
        return wrong(at, Wrong::BeginMissing);
    }
    match word.as_str() {
        "END" => return end(job),
        "BLK" => blank_form(job)?,
        "TOOL" => tool::tool(job, at)?,
        "L" => path::line(job)?,
        "CC" => path::pole(job)?,
        "C" => path::circle(job)?,
        "CR" => path::circle_of_radius(job)?,
        "CT" => path::tangent(job)?,
        "LP" => path::polar_line(job)?,
        "CP" => path::polar_circle(job)?,
        "M" => {
            // A block of nothing but M functions.
            job.scan.back(at);
            path::line(job)?;
        }
        "STOP" => stop(job)?,
        "LBL" => return jump::label(job, at),
        "CALL" => return jump::call(job, at),
        "FN" => return parameter::function(job, at),
        "IF" => return refuse(at, "IF", "write FN 9 to FN 12 with GOTO LBL"),
        "Q" => parameter::formula(job, at)?,
        "CYCL" => cycle::cycle(job, at)?,
        "TRANS" => cycle::datum(job, at)?,
        "PLANE" => plane(job, at)?,
        "RND" => return refuse(at, "RND", "post the rounding as an arc (CR)"),
        "CHF" => return refuse(at, "CHF", "post the chamfer as a line (L)"),
        "CTP" => return refuse(at, "CTP", "write CR or CP instead"),
        "APPR" | "DEP" => return refuse(at, &word, COMPENSATION),
        "FL" | "FLT" | "FC" | "FCT" | "FPOL" | "FSELECT" => {
            return refuse(
                at,
                &word,
                "free contours are computed by the control; post them as L and CR",
            );
        }
        "SEL" | "PATTERN" | "TCH" | "OPEN" | "CLOSE" | "FPOS" => {
            return refuse(
                at,
                &word,
                "tables, patterns and touch probes are the control's; post the motions themselves",
            );
        }
        "SPL" => return refuse(at, "SPL", "post the spline as short lines (L)"),
        "FUNCTION" => return refuse(at, "FUNCTION", FIVE_AXES),
        "LN" => return refuse(at, "LN", FIVE_AXES),
        "QL" | "QR" | "QS" => {
            return refuse(at, &word, "only Q parameters with a number are read");
        }
        _ => {
            job.scan.back(at);
            return job.not_understood();
        }
    }
    Ok(if job.modes.over {
        Flow::End
    } else {
        Flow::Next
    })
}

/// `BEGIN PGM NAME MM`.
fn begin(job: &mut Job, at: u32) -> Result<(), Fault> {
    if job.modes.program.is_some() {
        return wrong(at, Wrong::BeginTwice);
    }
    let (name, units) = title(job, "BEGIN PGM")?;
    job.modes.program = Some(name);
    job.desk.state.units = units;
    job.end_of_block()
}

/// `END PGM NAME MM`: ends the program as M2 does.
fn end(job: &mut Job) -> Said {
    let at = job.scan.at().saturating_sub(3);
    let (name, units) = title(job, "END PGM")?;
    job.end_of_block()?;
    if let Some(begun) = job.modes.program
        && (name != begun || units != job.desk.state.units)
    {
        return wrong(at, Wrong::EndDiffers { name: begun });
    }
    if job.modes.depth > 0 {
        return wrong(at, Wrong::LabelOpen);
    }
    job.desk.end();
    job.modes.over = true;
    Ok(Flow::End)
}

/// What stands behind BEGIN and END.
fn title(job: &mut Job, command: &'static str) -> Result<(Name, Units), Fault> {
    if !job.scan.blanks().take_text("PGM") {
        let what = "PGM";
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    let name = job.scan.blanks().rest();
    let end = name.find([' ', '\t', ';']).unwrap_or(name.len());
    let name = Name::of(name.get(..end).unwrap_or_default());
    job.scan.skip(end);
    let at = job.scan.blanks().at();
    let units = if job.scan.take_text("MM") {
        Units::Mm
    } else if job.scan.take_text("INCH") {
        Units::Inch
    } else if name.text().is_empty() {
        let what = "a name and MM or INCH";
        return wrong(at, Wrong::Missing { command, what });
    } else {
        let what = "MM or INCH behind the name";
        return wrong(at, Wrong::Missing { command, what });
    };
    Ok((name, units))
}

/// `BLK FORM ...`: the blank for the graphics. Nothing moves.
fn blank_form(job: &mut Job) -> Result<(), Fault> {
    if !job.scan.blanks().take_text("FORM") {
        let (command, what) = ("BLK", "FORM");
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    let at = job.scan.blanks().at();
    if job.scan.take_text("0.1") {
        if !job.scan.blanks().take(b'Z') && matches!(job.scan.peek(), Some(b'X' | b'Y')) {
            // `BLK FORM 0.1 X X+0 ...` names another tool axis; `0.1 X+0` names none.
            if matches!(job.scan.ahead(1), Some(b' ')) {
                return refuse(job.scan.at(), "BLK FORM", "the tool axis must be Z");
            }
        }
    } else if !job.scan.take_text("0.2") {
        let kind = job.scan.run(|b| b.is_ascii_alphabetic());
        if !matches!(kind, "CYLINDER" | "ROTATION" | "FILE") {
            let name = Name::of(kind);
            return wrong(at, Wrong::NotUnderstood { name });
        }
        // Shapes for the graphics alone.
        job.scan.finish();
        return Ok(());
    }
    while !matches!(job.scan.blanks().peek(), None | Some(b';')) {
        let at = job.scan.at();
        let word = job.scan.run(|b| b.is_ascii_alphabetic());
        if !matches!(word, "X" | "Y" | "Z" | "IX" | "IY" | "IZ") {
            let name = Name::of(word);
            return wrong(at, Wrong::NotUnderstood { name });
        }
        words::value(job, word)?;
    }
    Ok(())
}

/// `STOP`, with M functions if need be.
fn stop(job: &mut Job) -> Result<(), Fault> {
    path::line(job)?;
    if !job.modes.over {
        job.desk.pause(false);
    }
    Ok(())
}

/// `PLANE RESET STAY`, with which many programs open, leaves everything as it is.
fn plane(job: &mut Job, at: u32) -> Result<(), Fault> {
    if job.scan.blanks().take_text("RESET") && job.scan.blanks().take_text("STAY") {
        return job.end_of_block();
    }
    refuse(at, "PLANE", FIVE_AXES)
}
