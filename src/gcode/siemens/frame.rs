//! Frames: the programmable ones (TRANS and its like) and the settable ones (G54 ...).

use super::*;

/// `TRANS X10`, `ATRANS Z-5`, `TRANS`; and the empty forms of ROT, SCALE, MIRROR, which cancel all programmable frames as TRANS does.
pub(super) fn programmable(job: &mut Job, word: &str, at: u32) -> Result<(), Fault> {
    let before = job.modes.shift;
    read(job, word, at)?;
    for axis in 0..3 {
        job.modes.moved_frame[axis] |= job.modes.shift[axis] != before[axis];
    }
    Ok(())
}

/// Sets the programmable frame.
fn read(job: &mut Job, word: &str, at: u32) -> Result<(), Fault> {
    let mut shift = match word {
        "ATRANS" => job.modes.shift,
        _ => Vector::zeros(),
    };
    if matches!(job.scan.blanks().peek(), None | Some(b';')) {
        return match word {
            "AROT" | "ASCALE" | "AMIRROR" | "ATRANS" => missing(at, word, "an axis"),
            _ => {
                job.modes.shift = Vector::zeros();
                Ok(())
            }
        };
    }
    if !matches!(word, "TRANS" | "ATRANS") {
        return refuse(
            at,
            word,
            "it turns, scales or mirrors the path; post the path as it shall be",
        );
    }
    let mut seen = [false; 3];
    while !matches!(job.scan.blanks().peek(), None | Some(b';')) {
        let at = job.scan.at();
        let Some(axis) = ["X", "Y", "Z"].iter().position(|a| job.scan.take_text(a)) else {
            return job.not_understood();
        };
        let name = ["X", "Y", "Z"][axis];
        if std::mem::replace(&mut seen[axis], true) {
            let name = Name::of(name);
            return wrong(at, Wrong::Repeated { name });
        }
        shift[axis] += block::plain(job, name)? * job.mm();
    }
    job.modes.shift = shift;
    Ok(())
}

/// G500, G54 to G57, G505 to G599.
pub(super) fn settable(job: &mut Job, code: u32) {
    let index = match code {
        500 => {
            if !std::mem::replace(&mut job.modes.no_offset, true) {
                job.modes.moved_frame = [true; 3];
                job.desk.sync();
            }
            return;
        }
        54..=57 => code - 54,
        // The fifth settable frame and those behind it.
        _ => code.saturating_sub(501),
    };
    let index = index as usize;
    let back = std::mem::replace(&mut job.modes.no_offset, false);
    if back || index != job.desk.state.work_offset {
        job.modes.moved_frame = [true; 3];
    }
    if back && index == job.desk.state.work_offset {
        job.desk.sync();
    }
    job.desk.work_offset(index);
}
