//! A new tool's length in every work offset: they all move by the difference, written with `G10 L2`, read back and compared.
//!
//! Why `G10` and neither `G43.1` nor `G92`: the firmware forgets those two at every reset, and each stop of a job ends with a reset. The
//! tool would then stand in the spindle with the length of the one before.

use super::error::ErrandError;
use super::exchange::{Heard, Rule, Situation, Step, Task, number};
use super::jog::ready;
use super::zero::compare;
use crate::link::introduction::Known;
use crate::wire::{Reply, State};

/// Differences smaller than this are none, mm.
pub const NO_DIFFERENCE: f64 = 0.0005;
/// No two tools differ by more, mm.
const FARTHEST: f64 = 500.0;

/// Moves the Z of work offsets. Ask the controller for its offsets (an introduction) right before.
#[derive(Clone, Debug, Default)]
pub struct ToolLength {
    /// Above zero: the new tool is longer, mm.
    pub by: f64,
    /// This work offset, from 0 for G54, is right already.
    pub but: Option<usize>,
    plan: Vec<(usize, f64)>,
    step: usize,
    /// Work offsets moved, from 0 for G54, and their new Z in machine coordinates as read back, mm.
    pub moved: Vec<(usize, f64)>,
}

impl ToolLength {
    /// By so many mm, all but one perhaps.
    pub fn new(by: f64, but: Option<usize>) -> ToolLength {
        ToolLength {
            by,
            but,
            ..ToolLength::default()
        }
    }

    /// The work offsets to move and their new Z. One that was never set (all zero) is left alone, unless it is the active one.
    fn plan(&self, known: &Known) -> Vec<(usize, f64)> {
        let active = known.modes.work_offset().unwrap_or(0);
        let set = |(i, o): (usize, &Option<[f64; 3]>)| {
            let o = (*o)?;
            let wanted = self.but != Some(i) && (i == active || o != [0.0; 3]);
            wanted.then_some((i, o[2] + self.by))
        };
        let all = known.offsets.g5x.iter().enumerate();
        all.filter_map(set).collect()
    }
}

impl Task for ToolLength {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        if self.step == 0 {
            ready(now.known, "writing the tool's length", &[State::Idle])?;
            if !(self.by.is_finite() && self.by.abs() <= FARTHEST) {
                return Err(ErrandError::NotPossible(format!(
                    "the tools would differ by {} mm: no two tools do. Nothing was written",
                    self.by
                )));
            }
            self.plan = match self.by.abs() < NO_DIFFERENCE {
                true => Vec::new(),
                false => self.plan(now.known),
            };
        }
        self.step += 1;
        if let Some((system, z)) = self.plan.get(self.step - 1) {
            let line = format!("G21G10L2P{}Z{}", system + 1, number(*z));
            return Ok(Step::send(line, Rule::Writer));
        }
        if self.plan.is_empty() {
            return Ok(Step::Done);
        }
        if self.step == self.plan.len() + 1 {
            return Ok(Step::send("$#", Rule::Plain));
        }
        if self.step == self.plan.len() + 2 {
            for (system, wanted) in &self.plan {
                let found = read_back(now.heard, now.known, *system).unwrap_or(f64::NAN);
                compare(&format!("Z of G{}", 54 + system), *wanted, found)?;
                self.moved.push((*system, found));
            }
            // G21 was set for the writing.
            if now.known.modes.has("G20") {
                return Ok(Step::send("G20", Rule::Plain));
            }
        }
        Ok(Step::Done)
    }
}

fn read_back(heard: &Heard, known: &Known, system: usize) -> Option<f64> {
    let name = format!("G{}", 54 + system);
    let unit = if known.inches { 25.4 } else { 1.0 };
    heard.replies.iter().find_map(|r| match r {
        Reply::Offset { name: n, values } if *n == name => Some(values[2] * unit),
        _ => None,
    })
}

/// Watches: asks for reports until told to quit.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    /// Ends at the next opportunity.
    pub quit: bool,
}

impl Task for Watch {
    fn next(&mut self, _: &mut Situation<'_>) -> Result<Step, ErrandError> {
        Ok(match self.quit {
            true => Step::Done,
            false => Step::Listen,
        })
    }
}
