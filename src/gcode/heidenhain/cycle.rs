//! Cycles: datum shift, dwell, tolerance, preset, drilling; their definitions, and what a call of them does.
//!
//! Crosses the border: CYCL DEF and CYCL CALL blocks in; motions out at the call. After the iTNC 530 and TNC 640 cycle manuals.

use super::super::state::PathMode;
use super::super::state::Units;
use super::*;
use crate::units::MmPerMin;

/// A drilling cycle with its Q parameters (numbers and values as written).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cycle {
    number: u32,
    q: [Option<f64>; 8],
}

/// The parameters of a cycle, in the order of [`Cycle::q`].
fn parameters(cycle: u32) -> Option<&'static [u32]> {
    match cycle {
        200 => Some(&[200, 201, 206, 202, 210, 203, 204, 211]),
        201 => Some(&[200, 201, 206, 211, 208, 203, 204]),
        247 => Some(&[339]),
        _ => None,
    }
}

/// More infeeds than this are a mistake.
const MOST_INFEEDS: f64 = 10_000.0;

/// `CYCL DEF ...` or `CYCL CALL`.
pub(super) fn cycle(job: &mut Job, at: u32) -> Result<(), Fault> {
    if job.scan.blanks().take_text("CALL") {
        return call(job, at);
    }
    if !job.scan.take_text("DEF") {
        let (command, what) = ("CYCL", "DEF or CALL");
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    let at = job.scan.blanks().at();
    let number = job.scan.run(|b| b.is_ascii_digit());
    let part = match job.scan.take(b'.') {
        true => Some(job.scan.run(|b| b.is_ascii_digit())),
        false => None,
    };
    let number: u32 = number.parse().unwrap_or(u32::MAX);
    let part: Option<u32> = part.map(|p| p.parse().unwrap_or(u32::MAX));
    match (number, part) {
        // Titles: their words are in the control's language.
        (7 | 9 | 32, Some(0)) => {
            job.scan.finish();
            Ok(())
        }
        (7, Some(1..=3)) => shift(job),
        (9, Some(1)) => dwell(job),
        (32, Some(1)) => tolerance(job),
        // HSC-MODE and the tolerance of rotary axes: nothing that the path shows.
        (32, Some(2)) => {
            job.scan.finish();
            Ok(())
        }
        (200 | 201 | 247, None) => define(job, number),
        (u32::MAX, _) | (_, Some(u32::MAX)) => {
            let (command, what) = ("CYCL DEF", "a cycle's number");
            wrong(at, Wrong::Missing { command, what })
        }
        _ => refuse(
            at,
            &format!("cycle {number}"),
            "this reader carries out cycles 7, 9, 32, 200, 201 and 247; post the motions themselves",
        ),
    }
}

/// `7.1 X+60`: where the datum goes, from the preset; with I, from where it is.
fn shift(job: &mut Job) -> Result<(), Fault> {
    let mut shift = job.modes.shift;
    let mut any = false;
    while !matches!(job.scan.blanks().peek(), None | Some(b';')) {
        let at = job.scan.at();
        if job.scan.peek() == Some(b'#') {
            return refuse(
                at,
                "a datum from the table",
                "the table is not read; write the shift itself (7.1 X.. 7.2 Y.. 7.3 Z..)",
            );
        }
        let incremental = job.scan.take_text("I");
        let Some(axis) = axis(&mut job.scan) else {
            job.scan.back(at);
            return job.not_understood();
        };
        let value = words::value(job, "X Y Z")? * job.mm();
        shift[axis] = value + if incremental { shift[axis] } else { 0.0 };
        any = true;
    }
    if !any {
        let (command, what) = ("CYCL DEF 7", "X, Y or Z with the shift");
        return wrong(job.scan.at(), Wrong::Missing { command, what });
    }
    set_shift(job, shift);
    Ok(())
}

/// X, Y or Z.
fn axis(scan: &mut Scan) -> Option<usize> {
    ["X", "Y", "Z"].iter().position(|a| scan.take_text(a))
}

/// Another shift. The tool stays where it is, and so does nothing that was said in the old one: the pole is gone.
fn set_shift(job: &mut Job, shift: Vector) {
    if shift != job.modes.shift {
        job.modes.shift = shift;
        job.modes.pole = None;
    }
}

/// `TRANS DATUM AXIS X+10 Y+5`, `TRANS DATUM RESET` (TNC 640).
pub(super) fn datum(job: &mut Job, at: u32) -> Result<(), Fault> {
    if job.scan.blanks().take_text("DATUM") {
        if job.scan.blanks().take_text("AXIS") {
            return shift(job);
        }
        if job.scan.take_text("RESET") {
            job.end_of_block()?;
            set_shift(job, Vector::zeros());
            return Ok(());
        }
    }
    refuse(at, "TRANS", "write TRANS DATUM AXIS or CYCL DEF 7")
}

/// `9.1 DWELL 0.5`: seconds. The word before the number is in the control's language.
fn dwell(job: &mut Job) -> Result<(), Fault> {
    job.scan
        .blanks()
        .run(|b| b.is_ascii_alphabetic() || b == b'.');
    let at = job.scan.blanks().at();
    let seconds = words::value(job, "CYCL DEF 9.1")?;
    job.end_of_block()?;
    if !(0.0..=3600.0).contains(&seconds) {
        let (name, range) = (Name::of("CYCL DEF 9.1"), "seconds from 0 to 3600");
        return wrong(at, Wrong::Range { name, range });
    }
    job.desk.dwell(seconds);
    Ok(())
}

/// `32.1 T0.05`: how far the path may be left; without a number, as the machine has it.
fn tolerance(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.blanks().at();
    let mut tolerance = None;
    if job.scan.take_text("T") {
        if !matches!(job.scan.blanks().peek(), None | Some(b';')) {
            let value = words::value(job, "T")?;
            if value < 0.0 {
                let (name, range) = (Name::of("T"), "a tolerance of zero or more");
                return wrong(at, Wrong::Range { name, range });
            }
            tolerance = (value > 0.0).then_some(value * job.mm());
        }
    } else if !matches!(job.scan.peek(), None | Some(b';')) {
        return job.not_understood();
    }
    job.end_of_block()?;
    job.desk.state.path = PathMode::Blend { tolerance };
    Ok(())
}

/// `CYCL DEF 200 DRILLING ~` or all of it in one line.
fn define(job: &mut Job, number: u32) -> Result<(), Fault> {
    let q = [None; 8];
    job.modes.cycle = Some(Cycle { number, q });
    job.modes.modal_call = false;
    // The cycle's name, in the control's language.
    let rest = job.scan.rest();
    let title = rest.find(" Q").or(rest.find(['~', ';']));
    job.scan.skip(title.unwrap_or(rest.len()));
    parameter_lines(job)
}

/// A line of a definition that the line before left open.
pub(super) fn continued(job: &mut Job) -> Result<(), Fault> {
    let at = job.scan.blanks().at();
    if !matches!(job.scan.peek(), Some(b'Q' | b'q')) {
        return wrong(at, Wrong::CycleOpen);
    }
    parameter_lines(job)
}

/// `Q200=+2 ;SET-UP CLEARANCE ~`.
fn parameter_lines(job: &mut Job) -> Result<(), Fault> {
    let Some(mut cycle) = job.modes.cycle else {
        return wrong(job.scan.at(), Wrong::CycleMissing);
    };
    let known = parameters(cycle.number).unwrap_or_default();
    let start = job.scan.at();
    while !matches!(job.scan.blanks().peek(), None | Some(b';' | b'~')) {
        let at = job.scan.at();
        job.scan.take_text("Q");
        let digits = job.scan.run(|b| b.is_ascii_digit());
        let number: u32 = digits.parse().unwrap_or(u32::MAX);
        let place = known.iter().position(|k| *k == number);
        if !job.scan.blanks().take(b'=') {
            job.scan.back(at);
            return job.not_understood();
        }
        let feed = matches!(number, 206 | 208);
        let value = if feed && job.scan.blanks().take_text("FAUTO") {
            // In the program's own unit, as if it were written there.
            job.modes.auto_feed / feed_unit(job)
        } else if number == 208 && job.scan.blanks().take_text("FMAX") {
            99999.0
        } else {
            words::value(job, digits)?
        };
        match place.and_then(|p| cycle.q.get_mut(p)) {
            Some(slot) => {
                if slot.replace(value).is_some() {
                    let name = Name::of(&format!("Q{number}"));
                    return wrong(at, Wrong::Repeated { name });
                }
            }
            // Depth from the tip (0) is what this reader drills.
            None if number == 395 && cycle.number == 200 && value == 0.0 => {}
            None => {
                let why = "this reader does not know it in this cycle; remove it";
                return refuse(at, &format!("Q{digits}"), why);
            }
        }
        job.set.push((number, value));
    }
    job.modes.cycle = Some(cycle);
    job.modes.cycle_open = job.scan.whole().trim_end().ends_with('~');
    if job.modes.cycle_open {
        return Ok(());
    }
    for (parameter, value) in known.iter().zip(cycle.q) {
        if value.is_none() {
            let (cycle, parameter) = (cycle.number, *parameter);
            return wrong(start, Wrong::CycleParameter { cycle, parameter });
        }
    }
    if cycle.number == 247 {
        job.modes.cycle = None;
        return preset(job, cycle.q[0].unwrap_or_default(), start);
    }
    Ok(())
}

/// Cycle 247: the preset from now on, 1 to 99.
fn preset(job: &mut Job, number: f64, at: u32) -> Result<(), Fault> {
    let Some(index) = (0..99u8).find(|i| number == f64::from(*i) + 1.0) else {
        let (name, range) = (Name::of("Q339"), "a preset from 1 to 99");
        return wrong(at, Wrong::Range { name, range });
    };
    job.modes.pole = None;
    job.desk.work_offset(usize::from(index));
    Ok(())
}

/// mm/min in one unit of F.
fn feed_unit(job: &Job) -> f64 {
    match job.desk.state.units {
        Units::Mm => 1.0,
        Units::Inch => 2.54,
    }
}

/// `CYCL CALL`, with M functions.
fn call(job: &mut Job, at: u32) -> Result<(), Fault> {
    job.scan.blanks();
    if job.scan.take_text("POS") || job.scan.take_text("PAT") {
        return refuse(
            at,
            "CYCL CALL POS or PAT",
            "write the position as L and call with M99",
        );
    }
    let words = words::read(job, false)?;
    let functions_only = words
        == words::Words {
            functions: words.functions.clone(),
            ..words::Words::default()
        };
    if !functions_only {
        let name = Name::of("CYCL CALL with coordinates");
        return wrong(at, Wrong::NotUnderstood { name });
    }
    miscellany::before(job, &words.functions);
    run(job, at)?;
    miscellany::after(job, &words.functions, false)
}

/// Carries out the cycle in force at the tool's X and Y.
pub(super) fn run(job: &mut Job, at: u32) -> Result<(), Fault> {
    let Some(cycle) = job.modes.cycle else {
        return wrong(at, Wrong::CycleMissing);
    };
    let value = |parameter: u32| {
        let known = parameters(cycle.number).unwrap_or_default();
        let place = known.iter().position(|k| *k == parameter);
        place.and_then(|p| cycle.q.get(p).copied().flatten())
    };
    let mm = job.mm();
    let length = |parameter: u32| value(parameter).unwrap_or_default() * mm;
    let seconds = |parameter: u32| value(parameter).unwrap_or_default();
    let feed =
        |job: &Job, parameter: u32| MmPerMin(value(parameter).unwrap_or_default() * feed_unit(job));
    let range = |name: &str, range: &'static str| {
        let name = Name::of(name);
        wrong(at, Wrong::Range { name, range })
    };
    let depth = length(201);
    if depth == 0.0 {
        // The cycle is then not carried out.
        return Ok(());
    }
    if depth > 0.0 {
        return range("Q201", "a depth below zero (drilling goes down)");
    }
    if length(200) < 0.0 {
        return range("Q200", "a clearance of zero or more");
    }
    if feed(job, 206).0 <= 0.0 {
        return range("Q206", "a feed above zero");
    }
    if [seconds(210), seconds(211)]
        .iter()
        .any(|s| !(0.0..=3600.0).contains(s))
    {
        return range("Q210 and Q211", "seconds from 0 to 3600");
    }
    let surface = length(203) + job.modes.shift.z;
    let clear = surface + length(200);
    let bottom = surface + depth;
    let plunge = feed(job, 206);
    let at_height = |job: &Job, z: f64| {
        let mut p = job.desk.state.position;
        p.z = z;
        p
    };
    let rapid = |job: &mut Job, z: f64| {
        let to = at_height(job, z);
        job.desk.rapid(to, false);
    };
    rapid(job, clear);
    if cycle.number == 200 {
        let infeed = length(202);
        if infeed <= 0.0 || -depth / infeed > MOST_INFEEDS {
            return range("Q202", "an infeed above zero, and not above 10000 of them");
        }
        let mut z = surface;
        loop {
            // The last infeed takes what is left, be it a rounding error.
            let next = z - infeed;
            z = if next <= bottom + 1e-9 { bottom } else { next };
            let to = at_height(job, z);
            job.desk.cut(to, None, plunge, false);
            if z == bottom {
                break;
            }
            rapid(job, clear);
            job.desk.dwell(seconds(210));
            rapid(job, z + length(200));
        }
        job.desk.dwell(seconds(211));
        rapid(job, clear);
    } else {
        let to = at_height(job, bottom);
        job.desk.cut(to, None, plunge, false);
        job.desk.dwell(seconds(211));
        let back = feed(job, 208);
        let to = at_height(job, clear);
        match value(208) {
            Some(f) if f >= 99999.0 => job.desk.rapid(to, false),
            _ if back.0 < 0.0 => return range("Q208", "a feed of zero or more"),
            _ if back.0 == 0.0 => job.desk.cut(to, None, plunge, false),
            _ => job.desk.cut(to, None, back, false),
        }
    }
    if length(204) > length(200) {
        rapid(job, surface + length(204));
    }
    job.modes.tangent = None;
    Ok(())
}
