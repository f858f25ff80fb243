//! Setting work zero where the tool stands: `G10 L20 P0`, written as the EEPROM wants it, read back and compared.

use super::error::ErrandError;
use super::exchange::{Heard, Rule, Situation, Step, Task, number};
use super::jog::ready;
use crate::link::introduction::Known;
use crate::wire::{Reply, State};

/// How far a value may come back changed, mm: the firmware keeps single precision and prints three decimals.
pub(super) const READ_BACK: f64 = 0.0015;
/// Farther than any machine goes, mm.
const FARTHEST: f64 = 20_000.0;

/// Makes the place where the tool stands have these work coordinates.
#[derive(Clone, Debug, Default)]
pub struct Zero {
    /// Work coordinates, mm, that this place shall have; `None` leaves the axis alone.
    pub axes: [Option<f64>; 3],
    step: u8,
    expected: [f64; 3],
    /// Machine coordinates of the work zero as read back, mm.
    pub origin: Option<[f64; 3]>,
    /// Work position after it, mm.
    pub position: Option<[f64; 3]>,
}

impl Zero {
    /// This place shall have these work coordinates, mm.
    pub fn new(axes: [Option<f64>; 3]) -> Zero {
        Zero {
            axes,
            ..Zero::default()
        }
    }
}

impl Task for Zero {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        match self.step {
            1 => {
                ready(now.known, "setting zero", &[State::Idle])?;
                Ok(Step::Settle)
            }
            2 => {
                ready(now.known, "setting zero", &[State::Idle])?;
                let line = self.line(now.known)?;
                Ok(Step::send(line, Rule::Writer))
            }
            3 => Ok(Step::send("$#", Rule::Plain)),
            4 => {
                let origin = origin_of(now.heard, now.known)?;
                for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
                    if self.axes[i].is_some() {
                        compare(
                            &format!("work zero of {letter}"),
                            self.expected[i],
                            origin[i],
                        )?;
                    }
                }
                self.origin = Some(origin);
                Ok(Step::Settle)
            }
            _ => {
                self.position = now.known.work_position();
                Ok(Step::Done)
            }
        }
    }
}

impl Zero {
    fn line(&mut self, known: &Known) -> Result<String, ErrandError> {
        let at = known.machine_position.ok_or_else(|| {
            ErrandError::NotPossible(
                "the controller reports no position: nothing can be set from it".to_string(),
            )
        })?;
        // L20 words are in the unit that is active; it stays as it is.
        let inch = known.modes.has("G20");
        let unit = if inch { 25.4 } else { 1.0 };
        let mut line = String::from("G10L20P0");
        let mut words = 0;
        for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            let Some(value) = self.axes[i] else { continue };
            if !(value.is_finite() && value.abs() <= FARTHEST) {
                return Err(ErrandError::NotPossible(format!(
                    "{letter}{value} is farther than any machine goes ({FARTHEST} mm)"
                )));
            }
            line.push(letter);
            line += &number(value / unit);
            self.expected[i] = at[i] - value - shift(known, i);
            words += 1;
        }
        if words == 0 {
            return Err(ErrandError::NotPossible(
                "say which axis to set to zero: X, Y or Z".to_string(),
            ));
        }
        Ok(line)
    }
}

/// What G92 and the tool length add to the active work system along an axis, mm.
pub(super) fn shift(known: &Known, axis: usize) -> f64 {
    let g92 = known.offsets.g92.map_or(0.0, |o| o[axis]);
    let tool = if axis == 2 {
        known.offsets.tlo.unwrap_or(0.0)
    } else {
        0.0
    };
    g92 + tool
}

/// Machine coordinates of the active work system's origin, mm, from an answer to `$#`.
pub(super) fn origin_of(heard: &Heard, known: &Known) -> Result<[f64; 3], ErrandError> {
    let active = format!("G{}", 54 + known.modes.work_offset().unwrap_or(0));
    let unit = if known.inches { 25.4 } else { 1.0 };
    let found = heard.replies.iter().find_map(|r| match r {
        Reply::Offset { name, values } if *name == active => Some(values.map(|v| v * unit)),
        _ => None,
    });
    found.ok_or_else(|| {
        ErrandError::NotPossible(format!(
            "the controller does not tell {active} in its answer to $#: what was written cannot be checked. Look at $# before cutting"
        ))
    })
}

/// Refuses a figure that came back changed.
pub(super) fn compare(what: &str, wanted: f64, found: f64) -> Result<(), ErrandError> {
    // Single precision, and reports of three decimals on both sides.
    if (wanted - found).abs() <= READ_BACK + wanted.abs() * 1e-6 {
        return Ok(());
    }
    Err(ErrandError::ReadBack {
        what: what.to_string(),
        wanted: number(wanted),
        found: number(found),
    })
}
