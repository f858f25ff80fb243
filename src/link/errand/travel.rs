//! To work zero without meeting anything: up first, then X and Y, then Z down to a clearance.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task, number};
use super::jog::{ready, room, within_travel};
use crate::wire::State;

/// How far up before moving sideways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Retract {
    /// This work Z, mm.
    Work(f64),
    /// The top of the machine's travel. Only for a homed machine.
    MachineTop,
}

/// Up, across, and down to `clearance`.
#[derive(Clone, Debug)]
pub struct GoToZero {
    /// Height of the way across. Never below where the tool is.
    pub retract: Retract,
    /// Work Z at the end, mm, above zero.
    pub clearance: f64,
    step: u8,
    /// Work position at the end, mm.
    pub position: Option<[f64; 3]>,
}

impl GoToZero {
    /// Up to `retract`, across, down to work Z `clearance`, mm.
    pub fn new(retract: Retract, clearance: f64) -> GoToZero {
        GoToZero {
            retract,
            clearance,
            step: 0,
            position: None,
        }
    }
}

impl Task for GoToZero {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        let known = now.known;
        let wrong = |text: String| Err(ErrandError::NotPossible(text));
        match self.step {
            1 => {
                ready(known, "going to zero", &[State::Idle])?;
                if !(self.clearance.is_finite()
                    && (0.0..=500.0).contains(&self.clearance)
                    && self.clearance > 0.0)
                {
                    return wrong(format!(
                        "the clearance must be above zero and at most 500 mm, not {}: the tool must not touch the part on arrival",
                        self.clearance
                    ));
                }
                Ok(Step::Settle)
            }
            2 => {
                let (Some(at), Some(offset)) = (known.machine_position, known.work_offset) else {
                    return wrong("the controller reports no position and offset: no way can be told from them".to_string());
                };
                let up = match self.retract {
                    Retract::Work(z) if z.is_finite() && z >= self.clearance && z <= 2000.0 => {
                        z + offset[2]
                    }
                    Retract::Work(z) => {
                        return wrong(format!(
                            "the safe height must be at least the clearance ({} mm) and at most 2000 mm, not {z}",
                            self.clearance
                        ));
                    }
                    Retract::MachineTop => match room(known, 2) {
                        Some((_, high)) => high - known.setting(27).unwrap_or(1.0).clamp(0.0, 50.0),
                        None => {
                            return wrong(
                                "the machine's top is known only when it is homed and its soft limits are on ($20=1): name a safe work height"
                                    .to_string(),
                            );
                        }
                    },
                };
                // Up means up.
                let up = up.max(at[2]);
                within_travel(known, at, [at[0], at[1], up])?;
                within_travel(known, [at[0], at[1], up], [offset[0], offset[1], up])?;
                within_travel(known, at, [at[0], at[1], self.clearance + offset[2]])?;
                Ok(Step::send(
                    format!("G21G90G94G0Z{}", number(up - offset[2])),
                    Rule::Motion,
                ))
            }
            // Standstill at the top before anything goes sideways.
            3 | 5 | 7 => Ok(Step::Settle),
            4 => Ok(Step::send("G21G90G94G0X0Y0", Rule::Motion)),
            6 => Ok(Step::send(
                format!("G21G90G94G0Z{}", number(self.clearance)),
                Rule::Motion,
            )),
            8 => {
                let mut line = String::new();
                for word in ["G20", "G91", "G93"] {
                    if known.modes.has(word) {
                        line += word;
                    }
                }
                if line.is_empty() {
                    self.position = known.work_position();
                    return Ok(Step::Done);
                }
                Ok(Step::send(line, Rule::Plain))
            }
            _ => {
                self.position = known.work_position();
                Ok(Step::Done)
            }
        }
    }
}
