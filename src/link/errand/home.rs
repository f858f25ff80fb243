//! Homing: one `$H`, silent until it has ended.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task};
use crate::link::introduction::Known;
use crate::wire::State;
use std::time::Duration;

/// Travels longer than any machine's stand for a damaged setting.
const LONGEST_TRAVEL: f64 = 20_000.0;

/// `$H`.
#[derive(Clone, Debug, Default)]
pub struct Home {
    step: u8,
    /// Machine position after it, mm.
    pub position: Option<[f64; 3]>,
}

impl Task for Home {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        match self.step {
            1 => {
                if now.known.setting(22) == Some(0.0) {
                    return Err(ErrandError::NotPossible(
                        "homing is switched off in the controller ($22=0): set $22=1 if the machine has limit switches, or jog to a known \
                         place and set zero there"
                            .to_string(),
                    ));
                }
                if !matches!(now.known.state, State::Idle | State::Alarm) {
                    return Err(ErrandError::NotIdle {
                        doing: "homing",
                        state: now.known.state.clone(),
                    });
                }
                let patience = patience(now.known);
                now.notes.push(format!(
                    "homing: the controller answers nothing meanwhile; at most {:.0} s are waited for. Ctrl-C resets it",
                    patience.as_secs_f64()
                ));
                Ok(Step::send("$H", Rule::Silent(patience)))
            }
            2 => Ok(Step::Settle),
            _ => {
                self.position = now.known.machine_position;
                Ok(Step::Done)
            }
        }
    }

    fn alarm_advice(&self, code: u16) -> &'static str {
        match code {
            6 | 7 => "Home again.",
            8 => "Look whether a switch stays pressed; a larger pull-off ($27) may help.",
            9 => {
                "Look whether the switches work and the axes move towards them ($23); the travel ($130 to $132) may be set too short."
            }
            _ => "",
        }
    }

    fn may_reset_the_mute(&self) -> bool {
        true
    }
}

/// Twice what the whole way takes at the settings, and half a minute: each axis seeks 1.5 travels at $25 and locates over 5
/// pull-offs ($27) at $24 (GRBL 1.1 configuration, homing), Z first, then X and Y.
fn patience(known: &Known) -> Duration {
    let figure = |n: u16, instead: f64| known.setting(n).filter(|v| *v > 0.0).unwrap_or(instead);
    let (locate, seek, pull_off) = (figure(24, 25.0), figure(25, 500.0), figure(27, 1.0));
    let cycle = |axes: &[u16]| {
        let travel = axes
            .iter()
            .map(|n| figure(*n, 500.0).min(LONGEST_TRAVEL))
            .fold(0.0, f64::max);
        (1.5 * travel + pull_off) / seek + 5.0 * pull_off / locate + pull_off / seek
    };
    let minutes = cycle(&[132]) + cycle(&[130, 131]);
    Duration::from_secs_f64((2.0 * 60.0 * minutes + 30.0).clamp(60.0, 3600.0))
}
