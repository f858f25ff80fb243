//! Ways that meet nothing: up, or up, across and down again.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task, number};
use super::jog::{ready, room, within_travel};
use crate::link::introduction::Known;
use crate::wire::State;

/// How far up before moving sideways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Retract {
    /// This work Z, mm.
    Work(f64),
    /// The top of the machine's travel. Only for a homed machine.
    MachineTop,
    /// The top of the travel where the machine is known to be homed, else this work Z, mm.
    TopOr(f64),
}

impl Retract {
    /// Machine Z of it, mm, never below `here`: up means up.
    fn height(self, known: &Known, here: f64, offset: f64) -> Result<f64, ErrandError> {
        let wrong = |text: String| Err(ErrandError::NotPossible(text));
        let retract = match (self, room(known, 2)) {
            (Retract::TopOr(z), None) => Retract::Work(z),
            (Retract::TopOr(_), Some(_)) => Retract::MachineTop,
            (other, _) => other,
        };
        let up = match retract {
            Retract::Work(z) if z.is_finite() && z.abs() <= 2000.0 => z + offset,
            Retract::Work(z) => {
                return wrong(format!(
                    "the safe height must be at most 2000 mm from zero, not {z}"
                ));
            }
            Retract::MachineTop | Retract::TopOr(_) => match room(known, 2) {
                Some((_, high)) => high - known.setting(27).unwrap_or(1.0).clamp(0.0, 50.0),
                None => {
                    return wrong(
                        "the machine's top is known only when it is homed and its soft limits are on ($20=1): name a safe work height"
                            .to_string(),
                    );
                }
            },
        };
        Ok(up.max(here))
    }
}

/// Where the machine stands and its work offset, both mm.
fn place(known: &Known) -> Result<([f64; 3], [f64; 3]), ErrandError> {
    match (known.machine_position, known.work_offset) {
        (Some(at), Some(offset)) => Ok((at, offset)),
        _ => Err(ErrandError::NotPossible(
            "the controller reports no position and offset: no way can be told from them"
                .to_string(),
        )),
    }
}

/// The modes that were active before, if the way changed any.
fn modes_again(known: &Known) -> Option<Step> {
    let line: String = ["G20", "G91", "G93"]
        .into_iter()
        .filter(|w| known.modes.has(w))
        .collect();
    (!line.is_empty()).then(|| Step::send(line, Rule::Plain))
}

/// Straight up.
#[derive(Clone, Debug)]
pub struct Rise {
    to: Retract,
    step: u8,
    /// How far it went, mm.
    pub by: f64,
    /// Work position before it, mm.
    pub from: Option<[f64; 3]>,
}

impl Rise {
    /// To that height; stays where it is when it is there already.
    pub fn new(to: Retract) -> Rise {
        Rise {
            to,
            step: 0,
            by: 0.0,
            from: None,
        }
    }
}

impl Task for Rise {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        let known = now.known;
        match self.step {
            1 => {
                ready(known, "lifting the tool", &[State::Idle])?;
                Ok(Step::Settle)
            }
            2 => {
                let (at, offset) = place(known)?;
                self.from = known.work_position();
                let up = self.to.height(known, at[2], offset[2])?;
                within_travel(known, at, [at[0], at[1], up])?;
                self.by = up - at[2];
                if self.by < 0.0005 {
                    self.by = 0.0;
                    return Ok(Step::Done);
                }
                Ok(Step::send(
                    format!("G21G90G94G0Z{}", number(up - offset[2])),
                    Rule::Motion,
                ))
            }
            3 => Ok(Step::Settle),
            4 => Ok(modes_again(known).unwrap_or(Step::Done)),
            _ => Ok(Step::Done),
        }
    }
}

/// How the tool comes down at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Down {
    /// As fast as the machine goes.
    Rapid,
    /// mm/min.
    Feed(f64),
    /// Not at all: it stays at the height of the way across.
    Stay,
}

/// Up, across, and down to a place in the active work system.
#[derive(Clone, Debug)]
pub struct GoTo {
    /// Height of the way across. Never below where the tool is.
    pub retract: Retract,
    /// Where to, mm. The Z is kept out of [`Down::Stay`].
    pub to: [f64; 3],
    /// The X and Y of `to` are machine coordinates.
    pub machine: bool,
    /// The way down.
    pub down: Down,
    clearance: Option<f64>,
    step: u8,
    /// Work position at the end, mm.
    pub position: Option<[f64; 3]>,
}

impl GoTo {
    /// Up to `retract`, over work zero, down to work Z `clearance`, mm, which must lie above zero.
    pub fn zero(retract: Retract, clearance: f64) -> GoTo {
        GoTo {
            clearance: Some(clearance),
            ..GoTo::place(retract, [0.0, 0.0, clearance], Down::Rapid)
        }
    }

    /// Up to `retract`, over `to`, and down to it. Work coordinates, mm.
    pub fn place(retract: Retract, to: [f64; 3], down: Down) -> GoTo {
        GoTo {
            retract,
            to,
            machine: false,
            down,
            clearance: None,
            step: 0,
            position: None,
        }
    }

    /// Up to `retract` and over this place in machine coordinates, mm.
    pub fn above(retract: Retract, machine: [f64; 2]) -> GoTo {
        GoTo {
            machine: true,
            ..GoTo::place(retract, [machine[0], machine[1], 0.0], Down::Stay)
        }
    }

    fn checked(&self) -> Result<(), ErrandError> {
        let wrong = |text: String| Err(ErrandError::NotPossible(text));
        if let Some(clearance) = self.clearance {
            if !(clearance.is_finite() && clearance > 0.0 && clearance <= 500.0) {
                return wrong(format!(
                    "the clearance must be above zero and at most 500 mm, not {clearance}: the tool must not touch the part on arrival"
                ));
            }
            if let Retract::Work(z) | Retract::TopOr(z) = self.retract
                && !(z.is_finite() && z >= clearance && z <= 2000.0)
            {
                return wrong(format!(
                    "the safe height must be at least the clearance ({clearance} mm) and at most 2000 mm, not {z}"
                ));
            }
        }
        match self.to.iter().all(|c| c.is_finite() && c.abs() <= 20_000.0) {
            true => Ok(()),
            false => wrong("the place is farther than any machine goes (20000 mm)".to_string()),
        }
    }
}

impl Task for GoTo {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        let known = now.known;
        match self.step {
            1 => {
                ready(known, "going there", &[State::Idle])?;
                self.checked()?;
                Ok(Step::Settle)
            }
            2 => {
                let (at, offset) = place(known)?;
                let up = self.retract.height(known, at[2], offset[2])?;
                let (x, y) = match self.machine {
                    true => (self.to[0], self.to[1]),
                    false => (self.to[0] + offset[0], self.to[1] + offset[1]),
                };
                within_travel(known, at, [at[0], at[1], up])?;
                within_travel(known, [at[0], at[1], up], [x, y, up])?;
                if self.down != Down::Stay {
                    within_travel(known, at, [at[0], at[1], self.to[2] + offset[2]])?;
                }
                Ok(Step::send(
                    format!("G21G90G94G0Z{}", number(up - offset[2])),
                    Rule::Motion,
                ))
            }
            // Standstill at the top before anything goes sideways.
            3 | 5 | 7 => Ok(Step::Settle),
            4 => {
                let frame = if self.machine { "G53" } else { "" };
                Ok(Step::send(
                    format!(
                        "G21G90G94{frame}G0X{}Y{}",
                        number(self.to[0]),
                        number(self.to[1])
                    ),
                    Rule::Motion,
                ))
            }
            6 => {
                let z = number(self.to[2]);
                match self.down {
                    Down::Rapid => Ok(Step::send(format!("G21G90G94G0Z{z}"), Rule::Motion)),
                    Down::Feed(f) => Ok(Step::send(
                        format!("G21G90G94G1Z{z}F{}", number(f)),
                        Rule::Motion,
                    )),
                    Down::Stay => {
                        self.step = 7;
                        Ok(Step::Settle)
                    }
                }
            }
            8 => {
                self.position = known.work_position();
                Ok(modes_again(known).unwrap_or(Step::Done))
            }
            _ => {
                self.position = known.work_position();
                Ok(Step::Done)
            }
        }
    }
}
