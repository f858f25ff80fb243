//! Jogs: `$J=` lines, each with axis words and its own feed, at most one of them unanswered.

use super::error::ErrandError;
use super::exchange::{Rule, Situation, Step, Task, number};
use crate::link::introduction::Known;
use crate::wire::State;

/// Where a jog's numbers count from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// From where the tool is (G91).
    #[default]
    Relative,
    /// Work zero (G90).
    Work,
    /// Machine zero (G53).
    Machine,
}

/// Unit of distances and feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JogUnits {
    /// mm and mm/min.
    #[default]
    Mm,
    /// Inch and inch/min.
    Inch,
}

impl JogUnits {
    fn mm(self) -> f64 {
        match self {
            JogUnits::Mm => 1.0,
            JogUnits::Inch => 25.4,
        }
    }
}

/// One jog.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JogMove {
    /// Distances or targets of X, Y, Z, in `units`; `None` leaves the axis alone.
    pub axes: [Option<f64>; 3],
    /// In `units` per minute.
    pub feed: f64,
    /// Unit.
    pub units: JogUnits,
    /// What the numbers count from.
    pub reach: Reach,
}

/// Farthest target that makes sense, mm.
const FARTHEST: f64 = 20_000.0;
/// Fastest feed that makes sense, mm/min.
const FASTEST: f64 = 200_000.0;

impl JogMove {
    /// The line. Without axis words there is none: GRBL 1.1 takes `$J=F600` for a move to machine zero.
    ///
    /// # Errors
    /// No axis, or a number that cannot be meant.
    pub fn line(&self) -> Result<String, ErrandError> {
        let wrong = |text: String| Err(ErrandError::NotPossible(text));
        let far = FARTHEST / self.units.mm();
        if !(self.feed.is_finite() && self.feed > 0.0 && self.feed * self.units.mm() <= FASTEST) {
            return wrong(format!(
                "a jog needs a feed above zero and at most {FASTEST} mm/min, not {}",
                self.feed
            ));
        }
        let mut line = String::from("$J=");
        line += match self.units {
            JogUnits::Mm => "G21",
            JogUnits::Inch => "G20",
        };
        line += match self.reach {
            Reach::Relative => "G91",
            Reach::Work => "G90",
            Reach::Machine => "G53",
        };
        let mut words = 0;
        for (letter, value) in ['X', 'Y', 'Z'].into_iter().zip(self.axes) {
            let Some(value) = value else { continue };
            if !(value.is_finite() && value.abs() <= far) {
                return wrong(format!(
                    "{letter}{value} is farther than any machine goes ({FARTHEST} mm)"
                ));
            }
            line.push(letter);
            line += &number(value);
            words += 1;
        }
        if words == 0 {
            return wrong(
                "say which axis to jog: a jog without X, Y or Z would drive to machine zero"
                    .to_string(),
            );
        }
        line.push('F');
        // More decimals than a feed has must not make it zero.
        line += &number(self.feed.max(0.0001));
        Ok(line)
    }

    /// Where it ends in machine coordinates, mm, from `at`.
    fn target(&self, at: [f64; 3], offset: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| match self.axes.get(i).copied().flatten() {
            None => at[i],
            Some(v) => {
                let v = v * self.units.mm();
                match self.reach {
                    Reach::Relative => at[i] + v,
                    Reach::Work => offset[i] + v,
                    Reach::Machine => v,
                }
            }
        })
    }
}

/// Jogs one after the other, then standstill.
#[derive(Clone, Debug, Default)]
pub struct Jog {
    /// What to do.
    pub moves: Vec<JogMove>,
    next: usize,
    place: Option<[f64; 3]>,
    settled: bool,
    told: bool,
    /// Where it ended: machine and work position, mm.
    pub ended: Option<([f64; 3], Option<[f64; 3]>)>,
}

impl Jog {
    /// These, in order.
    pub fn new(moves: Vec<JogMove>) -> Jog {
        Jog {
            moves,
            ..Jog::default()
        }
    }

    /// Without notes about what cannot be checked: for one key after the other.
    #[must_use]
    pub fn quietly(self) -> Jog {
        Jog { told: true, ..self }
    }

    /// What the operator should know before it moves.
    fn caution(&mut self, jog: &JogMove, known: &Known, notes: &mut Vec<String>) {
        if std::mem::replace(&mut self.told, true) {
            return;
        }
        let axes = || (0..3usize).filter(|i| jog.axes[*i].is_some());
        if axes().any(|i| room(known, i).is_none()) {
            notes.push(
                "the machine is not known to be homed: nothing checks whether it can go as far"
                    .to_string(),
            );
        }
        let rate = |i: usize| known.setting(110 + i as u16).filter(|r| *r > 0.0);
        let fastest = axes().filter_map(rate).fold(0.0, f64::max);
        let feed = jog.feed * jog.units.mm();
        if fastest > 0.0 && feed > fastest * 1.001 {
            notes.push(format!(
                "{} mm/min is more than the axes do ($110 to $112): it goes at {} mm/min at most",
                number(feed),
                number(fastest)
            ));
        }
    }

    /// One more behind the others, as a held key wants it; false, and nothing done, while another waits to be sent.
    pub fn push(&mut self, jog: JogMove) -> bool {
        let free = self.next >= self.moves.len() && self.moves.len() < MOST_MOVES;
        if free {
            self.moves.push(jog);
            self.settled = false;
        }
        free
    }

    /// What is queued in the controller is no longer than this move: a key let go must not leave seconds of motion behind.
    fn near(&self, jog: &JogMove, known: &Known) -> bool {
        let (Some(place), Some(at)) = (self.place, known.machine_position) else {
            return true;
        };
        let step = jog.axes.iter().flatten().map(|v| v.abs() * jog.units.mm());
        let step = step.fold(0.0, f64::max);
        (0..3).all(|i| (place[i] - at[i]).abs() <= step + 0.01)
    }
}

/// Moves of one errand: more is a stuck key.
const MOST_MOVES: usize = 10_000;

impl Task for Jog {
    fn next(&mut self, now: &mut Situation<'_>) -> Result<Step, ErrandError> {
        if let Some(jog) = self.moves.get(self.next).cloned() {
            ready(now.known, "a jog", &[State::Idle, State::Jog])?;
            if jog.reach == Reach::Relative && !self.near(&jog, now.known) {
                return Ok(Step::Listen);
            }
            let line = jog.line()?;
            let at = self.place.or(now.known.machine_position);
            if let Some(at) = at {
                let target = jog.target(at, now.known.work_offset.unwrap_or_default());
                within_travel(now.known, at, target)?;
                self.place = Some(target);
            }
            self.caution(&jog, now.known, now.notes);
            self.next += 1;
            return Ok(Step::send(line, Rule::Jog));
        }
        if !self.settled {
            self.settled = true;
            return Ok(Step::Settle);
        }
        let known = now.known;
        self.ended = known.machine_position.map(|p| (p, known.work_position()));
        Ok(Step::Done)
    }
}

/// Refuses what a locked or busy controller would.
pub(super) fn ready(
    known: &Known,
    doing: &'static str,
    states: &[State],
) -> Result<(), ErrandError> {
    match &known.state {
        State::Alarm => Err(ErrandError::Locked),
        state if states.contains(state) => Ok(()),
        state => Err(ErrandError::NotIdle {
            doing,
            state: state.clone(),
        }),
    }
}

/// The room of an axis in machine coordinates, mm; `None` unless the machine is known to be homed, by its word (grblHAL) or because
/// soft limits are on. All of it is negative (GRBL 1.1 configuration, homing), except in builds that set the origin (letter Z).
pub(super) fn room(known: &Known, axis: usize) -> Option<(f64, f64)> {
    let soft = known.setting(20) == Some(1.0);
    if !(known.homed == Some(true) || soft) {
        return None;
    }
    let number = u16::try_from(axis).ok()?.checked_add(130)?;
    let travel = known.setting(number).filter(|t| *t > 0.0)?;
    let towards_low = ((known.setting(23).unwrap_or(0.0) as u32) >> axis) & 1 == 1;
    match known.letters.contains('Z') && towards_low {
        true => Some((0.0, travel)),
        false => Some((-travel, 0.0)),
    }
}

/// Lowest and highest machine Z, mm, of a machine known to be homed.
pub fn room_of_z(known: &Known) -> Option<(f64, f64)> {
    room(known, 2)
}

/// Refuses a target outside the room. A move that comes back from outside is allowed.
pub(super) fn within_travel(
    known: &Known,
    from: [f64; 3],
    to: [f64; 3],
) -> Result<(), ErrandError> {
    for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
        let Some((low, high)) = room(known, axis) else {
            continue;
        };
        let outside = |v: f64| (low - v).max(v - high).max(0.0);
        let (before, after) = (outside(from[axis]), outside(to[axis]));
        if after > 0.0005 && after > before - 1e-9 {
            return Err(ErrandError::NotPossible(format!(
                "{letter} would go to {} mm in machine coordinates, and its travel is from {} to {}: {} mm too far",
                number(to[axis]),
                number(low),
                number(high),
                number(after)
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lines_are_whole_or_refused() {
        let jog = JogMove {
            axes: [Some(10.0), None, Some(-0.5)],
            feed: 500.0,
            ..JogMove::default()
        };
        assert_eq!(jog.line().unwrap(), "$J=G21G91X10Z-0.5F500");
        let jog = JogMove {
            axes: [None, Some(1.0), None],
            feed: 10.0,
            units: JogUnits::Inch,
            reach: Reach::Machine,
        };
        assert_eq!(jog.line().unwrap(), "$J=G20G53Y1F10");
        let none = JogMove {
            feed: 600.0,
            ..JogMove::default()
        };
        assert_eq!(
            none.line().unwrap_err().to_string(),
            "say which axis to jog: a jog without X, Y or Z would drive to machine zero"
        );
        let still = JogMove {
            axes: [Some(1.0); 3],
            feed: 0.0,
            ..JogMove::default()
        };
        assert!(
            still
                .line()
                .unwrap_err()
                .to_string()
                .starts_with("a jog needs a feed above zero")
        );
        let far = JogMove {
            axes: [Some(1e9), None, None],
            feed: 1.0,
            ..JogMove::default()
        };
        assert_eq!(
            far.line().unwrap_err().to_string(),
            "X1000000000 is farther than any machine goes (20000 mm)"
        );
    }

    proptest! {
        /// Whatever is asked: a line that goes out names an axis and a feed, has no exponent, and fits the controller's line.
        #[test]
        fn no_line_without_axis_and_feed(axes in proptest::array::uniform3(proptest::option::of(proptest::num::f64::ANY)), feed in proptest::num::f64::ANY) {
            if let Ok(line) = (JogMove { axes, feed, ..JogMove::default() }).line() {
                let words = line.strip_prefix("$J=G21G91").unwrap();
                prop_assert!(words.contains(['X', 'Y', 'Z']) && words.contains('F') && !words.ends_with("F0"), "{line}");
                prop_assert!(line.len() < 79 && words.bytes().all(|b| b"XYZF0123456789.-".contains(&b)), "{line}");
            }
        }
    }
}
