//! Unlocking after an alarm: `$X`, and the modes that an abandoned probing left behind.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task};
use crate::link::introduction::Known;
use crate::wire::{Reply, State};

/// `$X`.
#[derive(Clone, Debug, Default)]
pub struct Unlock {
    step: u8,
    probing: bool,
    /// It was locked, and is not any more.
    pub unlocked: bool,
}

impl Task for Unlock {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        match self.step {
            1 => {
                self.probing = now.known.modes.words.iter().any(|w| w.starts_with("G38"));
                match now.known.state {
                    State::Alarm => Ok(Step::send("$X", Rule::Plain)),
                    State::Idle => {
                        now.notes.push("the controller is not locked".to_string());
                        Ok(Step::Done)
                    }
                    ref state => Err(ErrandError::NotIdle {
                        doing: "unlocking",
                        state: state.clone(),
                    }),
                }
            }
            2 => {
                let said =
                    |r: &Reply| matches!(r, Reply::Message(text) if text.contains("Unlocked"));
                self.unlocked = now.heard.replies.iter().any(said);
                Ok(Step::Settle)
            }
            3 => {
                self.unlocked = true;
                now.notes.push(trust(now.known));
                // A modal G38 would make the next bare axis word a probing move.
                match self.probing {
                    true => Ok(Step::send("G0", Rule::Plain)),
                    false => Ok(Step::Done),
                }
            }
            _ => Ok(Step::Done),
        }
    }

    fn may_reset_the_mute(&self) -> bool {
        true
    }
}

/// What may be trusted after the lock, and what may not.
fn trust(known: &Known) -> String {
    let meaning = known
        .alarm
        .and_then(|code| Some((code, known.firmware.alarm(code)?)));
    let mut text = match meaning {
        Some((code, m)) if m.position_kept => format!(
            "unlocked. ALARM:{code} came without a loss of steps: position and work zeros are what they were."
        ),
        _ => "unlocked. The position is what it was before the alarm, and not to be trusted if a step may have been lost: with it every work \
              zero, G28, G30 and the soft limits. Home again, or check it."
            .to_string(),
    };
    text += " Modes, spindle, coolant, G92 and tool length may have been cleared by a reset";
    text
}
