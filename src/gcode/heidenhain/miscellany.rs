//! M functions: which are carried out, and whether they act at the block's beginning or end (TNC 640 manual, "M functions", table).

use super::*;
use crate::units::Rpm;

/// Refuses what is not carried out.
pub(super) fn check(m: u32, at: u32) -> Result<(), Fault> {
    let why = match m {
        0..=6 | 8 | 9 | 13 | 14 | 30 | 89 | 91 | 99 => return Ok(()),
        // Cancel what this reader never lets in, or concern rotary axes, of which there are none.
        126 | 127 | 129 => return Ok(()),
        92 => {
            "where the additional machine datum lies is not known; write M91, or the place in the part's system"
        }
        97 | 98 | 101 | 102 => "it changes the path of radius compensation or the tool; remove it",
        103 | 109 | 110 | 111 | 136 | 137 => "it changes the feed; write the feed with F",
        118 | 120 => "it changes the path while it is cut; remove it",
        140 | 148 => "where it retracts to is not known; write the height, as in L Z+100 R0 FMAX",
        107 | 108 | 112 | 113 | 114 | 115 | 116 | 117 | 124 | 128 | 130 | 134 | 135 | 138 | 141
        | 143 | 144 | 145 => "this reader does not carry it out; remove it",
        _ => "it is the machine builder's, and what it does is not known; remove it",
    };
    refuse(at, &format!("M{m}"), why)
}

/// What acts before the block moves.
pub(super) fn before(job: &mut Job, functions: &[(u32, u32)]) {
    let desk = &mut job.desk;
    for &(m, _) in functions {
        let speed = desk.state.speed;
        match m {
            3 | 13 => desk.spindle(1, speed),
            4 | 14 => desk.spindle(-1, speed),
            _ => {}
        }
        if matches!(m, 8 | 13 | 14) {
            let mist = desk.state.mist;
            desk.coolant(true, mist);
        }
    }
}

/// What acts behind it.
pub(super) fn after(job: &mut Job, functions: &[(u32, u32)], moved: bool) -> Result<(), Fault> {
    let has = |m: u32| functions.iter().find(|f| f.0 == m).map(|f| f.1);
    if let Some(at) = has(89) {
        if job.modes.cycle.is_none() {
            return wrong(at, Wrong::CycleMissing);
        }
        job.modes.modal_call = true;
    }
    if let Some(at) = has(99) {
        cycle::run(job, at)?;
        job.modes.modal_call = false;
    } else if job.modes.modal_call && moved {
        cycle::run(job, 0)?;
    }
    let desk = &mut job.desk;
    let stopped = |desk: &mut Desk| {
        let speed: Rpm = desk.state.speed;
        desk.spindle(0, speed);
    };
    for &(m, _) in functions {
        match m {
            5 => stopped(desk),
            9 => desk.coolant(false, false),
            // A tool change by hand: TOOL CALL has told of the tool.
            6 => {
                stopped(desk);
                desk.sync();
            }
            // M0 stops spindle and coolant with the program; of M1 the operator decides.
            0 => {
                stopped(desk);
                desk.coolant(false, false);
                desk.pause(false);
            }
            1 => desk.pause(true),
            2 | 30 => {
                desk.end();
                job.modes.over = true;
            }
            _ => {}
        }
    }
    Ok(())
}
