//! G codes and M functions of a block: which are known, and which of them are against each other.

use super::block::{Block, whole};
use super::*;

/// What a G code sets; `None`: unknown.
fn group(code: u32) -> Option<&'static str> {
    Some(match code {
        0..=3 => "motion",
        4 => "dwell",
        9 => "exact stop in this block",
        17..=19 => "plane",
        40 => "radius compensation",
        53 | 153 => "frames in this block",
        54..=57 | 500 | 505..=599 => "work offset",
        60 | 64 | 641..=645 => "corners",
        70 | 71 | 700 | 710 => "units",
        90 | 91 => "absolute or incremental",
        93..=95 => "kind of feed",
        290 => "language",
        450 | 451 => "corners of radius compensation",
        601..=603 => "exact stop window",
        _ => return None,
    })
}

/// Why a G code is refused.
fn refused(code: u32) -> Option<&'static str> {
    Some(match code {
        41 | 42 => {
            "it moves the path sideways by the tool's radius; post the centre's path with G40"
        }
        58 | 59 => "write TRANS or ATRANS",
        74 | 75 => {
            "where the reference or fixed point lies is not known; write SUPA with the place"
        }
        110..=112 | 147 | 148 | 247 | 248 | 340 | 341 | 347 | 348 => "post the points as X Y Z",
        5 | 7 | 33..=35 | 63 | 331 | 332 => "post the motions as G0, G1, G2 and G3",
        25 | 26 => "limits are the machine's; remove it",
        96 | 97 | 961 | 962 | 971 | 972 => "write the speed with S and the feed with G94 or G95",
        291 => "ISO programs are another dialect; read this one as that",
        _ => return None,
    })
}

/// A G code: known, and alone in its group.
pub(super) fn code(job: &mut Job, block: &mut Block, at: u32) -> Result<(), Fault> {
    let code = whole(job, "G", 999, at)?;
    let name = format!("G{code}");
    let Some(of) = group(code) else {
        if let Some(why) = refused(code) {
            return refuse(at, &name, why);
        }
        return Err(Fault::at(
            at,
            Complaint::UnsupportedCode {
                code: super::super::error::Code {
                    letter: 'G',
                    number: f64::from(code),
                },
            },
        ));
    };
    if let Some((first, _)) = block.code(|c| group(c) == Some(of)) {
        return wrong(
            at,
            Wrong::SameGroup {
                first: Name::of(&format!("G{first}")),
                second: Name::of(&name),
                group: of,
            },
        );
    }
    block.codes.push((code, at));
    Ok(())
}

/// An M function: known, and not against another.
pub(super) fn function(job: &mut Job, block: &mut Block, at: u32) -> Result<(), Fault> {
    let m = whole(job, "M", 9999, at)?;
    let group = |m: u32| match m {
        3..=5 => "spindle",
        0 | 1 | 2 | 17 | 30 => "stop and end",
        7..=9 => "coolant",
        _ => "",
    };
    let name = format!("M{m}");
    match m {
        0..=9 | 17 | 30 | 40..=45 => {}
        19 | 70 => {
            return refuse(at, &name, "the spindle is only switched here; remove it");
        }
        _ => {
            return refuse(
                at,
                &name,
                "it is the machine builder's, and what it does is not known; remove it",
            );
        }
    }
    for &(other, _) in &block.functions {
        let together = matches!((other, m), (7, 8) | (8, 7));
        let same = !group(m).is_empty() && group(m) == group(other) && !together;
        if same || other == m {
            return wrong(
                at,
                Wrong::SameGroup {
                    first: Name::of(&format!("M{other}")),
                    second: Name::of(&name),
                    group: if same { group(m) } else { "one function" },
                },
            );
        }
    }
    block.functions.push((m, at));
    Ok(())
}
