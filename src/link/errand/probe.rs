//! Probing Z onto a plate and setting zero by it: a quick touch, a slow one, the zero from where the probe was triggered.
//!
//! The trigger point is `[PRB:...]`, in machine coordinates; the tool stops later than that by its deceleration, so the position after
//! probing is no measure (GRBL 1.1 interface, `[PRB:]`, and observed). All moves are G90 G21 in the active work system.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task, number};
use super::jog::{ready, within_travel};
use super::zero::{compare, origin_of, shift};
use crate::link::introduction::Known;
use crate::wire::{Modes, Reply, State};

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeOptions {
    /// How far down to look, mm.
    pub distance: f64,
    /// Feed of the first touch, mm/min.
    pub feed: f64,
    /// Feed of the second, slow touch, mm/min.
    pub slow_feed: f64,
    /// Way up between the touches, mm; the second looks twice as far down, but never below the distance.
    pub lift: f64,
    /// Thickness of the plate, mm: the work Z that the trigger point gets.
    pub plate: f64,
    /// Way up from the trigger point at the end, mm.
    pub retract: f64,
    /// Largest difference between the touches, mm: beyond it nothing is set.
    pub agreement: f64,
    /// Whether zero is set, or the touch only reported.
    pub set_zero: bool,
}

impl Default for ProbeOptions {
    fn default() -> Self {
        ProbeOptions {
            distance: 20.0,
            feed: 100.0,
            slow_feed: 25.0,
            lift: 2.0,
            plate: 0.0,
            retract: 10.0,
            agreement: 0.1,
            set_zero: true,
        }
    }
}

/// Where the probe was triggered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Machine Z of the first, quick touch, mm.
    pub first: f64,
    /// Machine Z of the second, slow one, mm: this one counts.
    pub second: f64,
}

/// The errand.
#[derive(Clone, Debug, Default)]
pub struct Probe {
    /// How.
    pub options: ProbeOptions,
    step: u8,
    modes: Modes,
    start: f64,
    first: f64,
    /// What it found.
    pub touch: Option<Touch>,
    /// Machine Z of the work zero as read back, if it was set, mm.
    pub origin: Option<f64>,
    /// Work position at the end, mm.
    pub position: Option<[f64; 3]>,
}

impl Probe {
    /// With these options.
    pub fn new(options: ProbeOptions) -> Probe {
        Probe {
            options,
            ..Probe::default()
        }
    }

    /// A line down to machine Z `to`.
    fn down(known: &Known, to: f64, feed: f64) -> Result<Step, ErrandError> {
        let z = number(to - offset(known)?);
        Ok(Step::send(
            format!("G21G90G94G38.2Z{z}F{}", number(feed)),
            Rule::Motion,
        ))
    }

    /// A line up to machine Z `to`, but never beyond the room and never down.
    fn up(known: &Known, to: f64) -> Result<Step, ErrandError> {
        let top = super::jog::room(known, 2).map_or(to, |(_, high)| to.min(high));
        let here = known.machine_position.map_or(top, |p| p[2]);
        let z = number(top.max(here) - offset(known)?);
        Ok(Step::send(format!("G21G90G94G0Z{z}"), Rule::Motion))
    }
}

fn offset(known: &Known) -> Result<f64, ErrandError> {
    known.work_offset.map(|o| o[2]).ok_or_else(|| {
        ErrandError::NotPossible("the controller does not report its work offset (WCO): without it no target can be told".to_string())
    })
}

impl Task for Probe {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        self.step += 1;
        let (known, o) = (now.known, self.options);
        match self.step {
            1 => {
                ready(known, "probing", &[State::Idle])?;
                self.check()?;
                self.modes = known.modes.clone();
                Ok(Step::Settle)
            }
            2 => {
                ready(known, "probing", &[State::Idle])?;
                if now.status.is_some_and(|s| s.pins.contains('P')) {
                    return Err(ErrandError::NotPossible(
                        "the probe is already touching, or its wire is broken or inverted ($6): lift the tool and check the probe with a \
                         hand before anything moves"
                            .to_string(),
                    ));
                }
                let at = known.machine_position.unwrap_or_default();
                self.start = at[2];
                let to = at[2] - o.distance;
                within_travel(known, at, [at[0], at[1], to])?;
                Self::down(known, to, o.feed)
            }
            3 => {
                self.first = touched(now)?;
                Self::up(known, self.first + o.lift)
            }
            // Never farther down than was told.
            4 => {
                let to = (self.first - o.lift).max(self.start - o.distance);
                Self::down(known, to, o.slow_feed)
            }
            5 => {
                let second = touched(now)?;
                let touch = Touch {
                    first: self.first,
                    second,
                };
                self.touch = Some(touch);
                Self::up(known, second + o.retract)
            }
            6 => Ok(Step::Settle),
            7 => {
                let touch = self.touch.unwrap_or(Touch {
                    first: 0.0,
                    second: f64::NAN,
                });
                let apart = (touch.first - touch.second).abs();
                if apart.is_nan() || apart > o.agreement {
                    return Err(ErrandError::NotPossible(format!(
                        "the two touches differ by {} mm, more than {}: zero was not set. Clean plate and tool, check that both are firm, and probe again",
                        number(apart),
                        o.agreement
                    )));
                }
                if !o.set_zero {
                    self.step = 9;
                    return self.restore(now);
                }
                // L2 is absolute in machine coordinates, so the trigger point is what counts, not where the tool stands.
                let origin = touch.second - o.plate - shift(known, 2);
                Ok(Step::send(
                    format!("G21G10L2P0Z{}", number(origin)),
                    Rule::Writer,
                ))
            }
            8 => Ok(Step::send("$#", Rule::Plain)),
            9 => {
                let origin = origin_of(now.heard, known)?[2];
                let wanted = self.touch.map_or(f64::NAN, |t| t.second) - o.plate - shift(known, 2);
                compare("work zero of Z", wanted, origin)?;
                self.origin = Some(origin);
                self.restore(now)
            }
            10 => Ok(Step::Settle),
            _ => {
                self.position = known.work_position();
                Ok(Step::Done)
            }
        }
    }

    fn alarm_advice(&self, code: u16) -> &'static str {
        match code {
            4 => {
                "The probe touched before it moved: lift the tool, check the wire. Nothing was set. Then `morsemill unlock`; until then the \
                 probing mode G38.2 stays active"
            }
            5 => {
                "Nothing was touched on the whole way: start nearer, look farther, check the wire. Nothing was set; the tool stands where the \
                 way ended. Then `morsemill unlock`; until then the probing mode G38.2 stays active"
            }
            _ => "Nothing was set.",
        }
    }
}

impl Probe {
    fn check(&self) -> Result<(), ErrandError> {
        let o = &self.options;
        let above_zero = [
            ("the distance", o.distance, 500.0),
            ("the feed", o.feed, 2000.0),
            ("the slow feed", o.slow_feed, 2000.0),
            ("the lift", o.lift, 50.0),
            ("the retract", o.retract, 500.0),
            ("the agreement", o.agreement, 5.0),
        ];
        for (name, value, most) in above_zero {
            if !(value.is_finite() && value > 0.0 && value <= most) {
                return Err(ErrandError::NotPossible(format!(
                    "{name} must be above zero and at most {most}, not {value}"
                )));
            }
        }
        if !(o.plate.is_finite() && (0.0..=200.0).contains(&o.plate)) {
            return Err(ErrandError::NotPossible(format!(
                "the plate must be from 0 to 200 mm thick, not {}",
                o.plate
            )));
        }
        if o.slow_feed > o.feed {
            return Err(ErrandError::NotPossible(format!(
                "the slow feed ({}) is faster than the first ({})",
                o.slow_feed, o.feed
            )));
        }
        Ok(())
    }

    /// The modes that were active before: a modal G38 would make the next bare axis word a probing move.
    fn restore(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        let mut line = String::from("G0");
        for word in ["G20", "G91", "G93"] {
            if self.modes.has(word) {
                line += word;
            }
        }
        if let Some(feed) = self.modes.value('F').filter(|f| *f > 0.0) {
            now.notes.push(format!(
                "the modal feed was F{} and is the probing feed now",
                number(feed)
            ));
        }
        Ok(Step::send(line, Rule::Plain))
    }
}

/// Machine Z of the touch that the last answer tells, mm.
fn touched(now: &Situation<'_>) -> Result<f64, ErrandError> {
    let unit = if now.known.inches { 25.4 } else { 1.0 };
    let found = now.heard.replies.iter().rev().find_map(|r| match r {
        Reply::Probed { at, touched } => Some((at[2] * unit, *touched)),
        _ => None,
    });
    match found {
        Some((z, true)) => Ok(z),
        Some((_, false)) => Err(ErrandError::NotPossible(
            "the probe touched nothing on the whole way: start nearer or look farther. Nothing was set".to_string(),
        )),
        None => Err(ErrandError::NotPossible(
            "the controller did not say where the probe touched ([PRB:...] is missing): nothing was set".to_string(),
        )),
    }
}
