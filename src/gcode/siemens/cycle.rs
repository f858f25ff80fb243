//! Cycles: CYCLE81 (drilling, centring), CYCLE82 (with a dwell at depth), MCALL, CYCLE832 (tolerance of the path).
//!
//! Crosses the border: calls with their arguments in; motions out. After "Job planning" and the manual "Cycles".

use super::super::event::Plane;
use super::*;
use crate::geom::Point;

/// A drilling cycle's arguments, mm and s, in the program's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drilling {
    /// RTP: where it retracts to.
    retract: f64,
    /// RFP + SDIS: from here on it feeds.
    clear: f64,
    /// DP, or RFP - DPR.
    bottom: f64,
    /// DTB, s.
    dwell: f64,
}

/// An argument: empty, or a number.
fn arguments(job: &mut Job, name: &str, at: u32, most: usize) -> Result<Vec<Option<f64>>, Fault> {
    if !job.scan.blanks().take(b'(') {
        return missing(at, name, "its arguments in parentheses");
    }
    let mut all = Vec::new();
    loop {
        let place = job.scan.blanks().at();
        match job.scan.peek() {
            Some(b',' | b')') => all.push(None),
            _ => all.push(Some(expression::number(job, name)?)),
        }
        if all.len() > most && all.last() != Some(&None) {
            return refuse(
                place,
                &format!("{name} with more arguments"),
                "this reader knows RTP, RFP, SDIS, DP, DPR and DTB, and what stands behind them changes what these mean; post the motions themselves",
            );
        }
        if job.scan.blanks().take(b')') {
            return Ok(all);
        }
        if !job.scan.take(b',') || all.len() > 30 {
            let what = "a comma or a closing parenthesis";
            return wrong(job.scan.at(), Wrong::Expected { what });
        }
    }
}

/// `CYCLE81(RTP, RFP, SDIS, DP, DPR)`, `CYCLE82(..., DTB)`, behind the name.
pub(super) fn read(job: &mut Job, name: &str, at: u32) -> Result<Drilling, Fault> {
    // Newer software has DTB in CYCLE81, too.
    let most = 6;
    let all = arguments(job, name, at, most)?;
    let mm = job.mm();
    let get = |i: usize| all.get(i).copied().flatten();
    let length = |i: usize| get(i).map(|v| v * mm);
    let (Some(retract), Some(reference)) = (length(0), length(1)) else {
        return missing(at, name, "RTP and RFP, its first two arguments");
    };
    let distance = length(2).unwrap_or_default();
    let bottom = match (length(3), length(4)) {
        (Some(depth), None) => depth,
        (None, Some(depth)) if depth >= 0.0 => reference - depth,
        (None, Some(_)) => return range(at, "DPR", "a depth without sign"),
        (Some(_), Some(_)) => {
            return refuse(at, "DP together with DPR", "give one of them");
        }
        (None, None) => return missing(at, name, "a depth (DP or DPR)"),
    };
    let dwell = get(5).unwrap_or_default();
    if dwell < 0.0 {
        return refuse(at, "DTB in revolutions", "give seconds, above zero");
    }
    if distance < 0.0 {
        return range(at, "SDIS", "a distance without sign");
    }
    if retract < reference || bottom >= reference {
        return range(
            at,
            name,
            "RTP not below RFP, and a depth below RFP (alarm 61101)",
        );
    }
    let clear = reference + distance;
    Ok(Drilling {
        retract,
        clear,
        bottom,
        dwell,
    })
}

/// Drills at the tool's X and Y.
pub(super) fn run(job: &mut Job, drilling: &Drilling, at: u32) -> Result<(), Fault> {
    if job.desk.state.plane != Plane::Xy {
        return refuse(at, "drilling in G18 or G19", "write G17 before the cycle");
    }
    if job.modes.length_off {
        return wrong(at, Wrong::LengthOff);
    }
    if job.modes.no_offset {
        return refuse(at, "a cycle under G500", "write G54 before the cycle");
    }
    if job.modes.feed_kind == FeedKind::Inverse {
        return refuse(at, "a cycle under G93", "write G94 before the cycle");
    }
    let feed = path::feed(job, &block::Block::default(), at)?;
    let height = |job: &Job, z: f64| {
        let p = job.desk.state.position;
        Point::new(p.x, p.y, z + job.modes.shift.z)
    };
    let to = height(job, drilling.clear);
    job.desk.rapid(to, false);
    let to = height(job, drilling.bottom);
    job.desk.cut(to, None, feed, false);
    job.desk.dwell(drilling.dwell);
    let to = height(job, drilling.retract);
    job.desk.rapid(to, false);
    Ok(())
}

/// `MCALL CYCLE81(...)`: behind each block that moves, until `MCALL` alone.
pub(super) fn modal(job: &mut Job, at: u32) -> Result<(), Fault> {
    let place = job.scan.blanks().at();
    let name = job.scan.run(|b| b.is_ascii_alphanumeric() || b == b'_');
    let name = name.to_ascii_uppercase();
    job.modes.modal = match name.as_str() {
        "" => None,
        "CYCLE81" | "CYCLE82" => Some(read(job, &name, place)?),
        _ => {
            return refuse(
                at,
                &format!("MCALL {name}"),
                "this reader carries out CYCLE81 and CYCLE82; post the motions themselves",
            );
        }
    };
    job.end_of_block()
}

/// `CYCLE832(0.05, _FINISH, 1)`: a tolerance for the path; `CYCLE832()` and `_OFF` end it.
pub(super) fn high_speed(job: &mut Job, at: u32) -> Result<(), Fault> {
    let name = "CYCLE832";
    if !job.scan.blanks().take(b'(') {
        return missing(at, name, "its arguments in parentheses");
    }
    let mut tolerance = 0.0;
    let mut off = false;
    let mut count = 0;
    while !job.scan.blanks().take(b')') {
        let place = job.scan.at();
        let word = job
            .scan
            .clone()
            .run(|b| b.is_ascii_alphanumeric() || b == b'_');
        match word.to_ascii_uppercase().as_str() {
            "" if job.scan.peek() == Some(b',') => {}
            mode @ ("_OFF" | "_ROUGH" | "_SEMIFIN" | "_FINISH") if count == 1 => {
                off = mode == "_OFF";
                job.scan.skip(word.len());
            }
            _ if word.starts_with('_') => {
                return refuse(
                    place,
                    &word.to_ascii_uppercase(),
                    "it is for machines of five axes; give _FINISH, _SEMIFIN, _ROUGH or _OFF",
                );
            }
            _ => {
                let value = expression::number(job, name)?;
                match count {
                    0 => tolerance = value * job.mm(),
                    // Kind of machining: 0 switches it off.
                    1 => off = value == 0.0,
                    _ => {}
                }
            }
        }
        count += 1;
        if !job.scan.blanks().take(b',') && job.scan.peek() != Some(b')') || count > 9 {
            let what = "a comma or a closing parenthesis";
            return wrong(job.scan.at(), Wrong::Expected { what });
        }
    }
    if tolerance < 0.0 {
        return range(at, name, "a tolerance of zero or more");
    }
    let on = !off && tolerance > 0.0;
    let blending = &mut job.modes.blending;
    blending.tolerance = on.then_some(tolerance);
    blending.compressor = on;
    blending.code = if on { 642 } else { 64 };
    job.desk.state.path = path::path_mode(&job.modes.blending);
    Ok(())
}
