//! Hands on the machine's pins, from a small text: at a time, or once an axis gets somewhere.
//!
//! Crosses the border: text in, checked; seconds since the start and machine positions (mm) in, the state of the pins out.
//!
//! ```text
//! ; one thing a line: when, which pin, on or off
//! 12.5s     limit x on
//! 12.7s     limit x off
//! at Z<-5   probe on         ; once, as soon as the Z axis stands below -5 mm in machine coordinates
//! at X>100  door on
//! ```
//! Pins: `limit x`, `limit y`, `limit z`, `probe`, `door`, `hold`, `reset`, `start`. A line with `at` counts once.

use super::Pins;
use super::fault_plan::seconds;
use crate::geom::Point;
use crate::machine::data::{DataError, Place, nearest};

/// When a line counts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    /// s after the start.
    At(f64),
    /// Axis beyond a place, mm.
    Below(usize, f64),
    Above(usize, f64),
}

/// An input pin.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pin {
    Limit(usize),
    Probe,
    Door,
    Hold,
    Reset,
    Start,
}

impl Pin {
    fn set(self, pins: &mut Pins, on: bool) {
        match self {
            Pin::Limit(axis) => {
                if let Some(p) = pins.limit.get_mut(axis) {
                    *p = on;
                }
            }
            Pin::Probe => pins.probe = on,
            Pin::Door => pins.door = on,
            Pin::Hold => pins.hold = on,
            Pin::Reset => pins.reset = on,
            Pin::Start => pins.cycle_start = on,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    when: When,
    pin: Pin,
    on: bool,
}

/// What is still to be done with the pins.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    lines: Vec<Line>,
}

const PINS: [&str; 6] = ["limit", "probe", "door", "hold", "reset", "start"];
const AXES: [&str; 3] = ["x", "y", "z"];
/// Lines of a script at most.
const MOST_LINES: usize = 100_000;

impl Script {
    /// Reads a text that complaints call `file`.
    ///
    /// # Errors
    /// Every line that cannot be read, with its place.
    pub fn read(file: &str, text: &str) -> Result<Script, DataError> {
        let mut lines = Vec::new();
        let mut complaints = Vec::new();
        for (index, whole) in text.lines().enumerate() {
            let end = whole.find([';', '#']).unwrap_or(whole.len());
            let words = words(whole.get(..end).unwrap_or_default());
            if words.is_empty() {
                continue;
            }
            let result = if lines.len() < MOST_LINES {
                line(&words)
            } else {
                Err((
                    0,
                    format!("more than {MOST_LINES} lines: no rehearsal needs as many"),
                ))
            };
            match result {
                Ok(l) => lines.push(l),
                Err((byte, message)) => complaints.push(DataError::Syntax {
                    at: Place {
                        file: file.to_string(),
                        line: index + 1,
                        column: whole.get(..byte).map_or(1, |s| s.chars().count() + 1),
                    },
                    message,
                }),
            }
            if complaints.len() >= 20 {
                break;
            }
        }
        match complaints.len() {
            0 => Ok(Script { lines }),
            1 => Err(complaints.remove(0)),
            _ => Err(DataError::Several(complaints)),
        }
    }

    /// Nothing is left to do.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// It opens or closes the safety door, which only some builds have a pin for.
    pub fn moves_the_door(&self) -> bool {
        self.lines.iter().any(|l| l.pin == Pin::Door)
    }

    /// When the clock alone makes a line count next, s.
    pub fn next(&self) -> Option<f64> {
        let times = self.lines.iter().filter_map(|l| match l.when {
            When::At(t) => Some(t),
            _ => None,
        });
        times.reduce(f64::min)
    }

    /// Does what is due at `now` with the axes at `at`, in the order of the text; true when a line counted.
    pub fn play(&mut self, now: f64, at: &Point, pins: &mut Pins) -> bool {
        let before = self.lines.len();
        self.lines.retain(|l| {
            let due = match l.when {
                When::At(t) => t <= now,
                When::Below(axis, v) => at[axis] < v,
                When::Above(axis, v) => at[axis] > v,
            };
            if due {
                l.pin.set(pins, l.on);
            }
            !due
        });
        self.lines.len() < before
    }
}

/// The words of a line and the bytes they begin at.
fn words(text: &str) -> Vec<(usize, &str)> {
    let mut out = Vec::new();
    let mut start = None;
    for (i, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (c.is_whitespace(), start) {
            (false, None) => start = Some(i),
            (true, Some(s)) => {
                out.extend(text.get(s..i).map(|w| (s, w)));
                start = None;
            }
            _ => {}
        }
    }
    out
}

type Complaint = (usize, String);

fn line(words: &[(usize, &str)]) -> Result<Line, Complaint> {
    let (when, rest) = match words {
        [(_, w), rest @ ..] if w.eq_ignore_ascii_case("at") => match rest {
            [(at, place), rest @ ..] => (
                place_of(place).ok_or_else(|| {
                    (*at, format!("\"{place}\" is no place: write e.g. Z<-5 or X>100 (machine coordinates, mm)"))
                })?,
                rest,
            ),
            [] => return Err((words.first().map_or(0, |w| w.0), "after \"at\" comes a place, e.g. at Z<-5 probe on".to_string())),
        },
        [(at, w), rest @ ..] => (
            When::At(seconds(w).ok_or_else(|| {
                (*at, format!("\"{w}\" is no time: write e.g. 12.5s, 200ms, or at Z<-5"))
            })?),
            rest,
        ),
        [] => return Err((0, "nothing on this line".to_string())),
    };
    let end = words.last().map_or(0, |(at, w)| at + w.len());
    let [(at, name), rest @ ..] = rest else {
        return Err((end, format!("which pin? One of {}", PINS.join(", "))));
    };
    let (pin, rest) = match (name.to_ascii_lowercase().as_str(), rest) {
        ("limit", [(at, axis), rest @ ..]) => {
            let axis = AXES
                .iter()
                .position(|a| a.eq_ignore_ascii_case(axis))
                .ok_or_else(|| {
                    (
                        *at,
                        format!("\"{axis}\" is no axis: write limit x, limit y or limit z"),
                    )
                })?;
            (Pin::Limit(axis), rest)
        }
        ("limit", []) => {
            return Err((
                end,
                "which axis? Write limit x, limit y or limit z".to_string(),
            ));
        }
        ("probe", rest) => (Pin::Probe, rest),
        ("door", rest) => (Pin::Door, rest),
        ("hold", rest) => (Pin::Hold, rest),
        ("reset", rest) => (Pin::Reset, rest),
        ("start", rest) => (Pin::Start, rest),
        (other, _) => {
            let near =
                nearest(other, PINS).map_or(String::new(), |n| format!(" (did you mean {n}?)"));
            return Err((
                *at,
                format!(
                    "\"{name}\" is no pin{near}: write one of {}",
                    PINS.join(", ")
                ),
            ));
        }
    };
    match rest {
        [(_, state)] if state.eq_ignore_ascii_case("on") => Ok(Line {
            when,
            pin,
            on: true,
        }),
        [(_, state)] if state.eq_ignore_ascii_case("off") => Ok(Line {
            when,
            pin,
            on: false,
        }),
        [(at, state), ..] => Err((
            *at,
            format!("\"{state}\" is no state: the line ends with on or off"),
        )),
        [] => Err((end, "on or off? The line ends with one of them".to_string())),
    }
}

/// `Z<-5`, `X>100`.
fn place_of(text: &str) -> Option<When> {
    let at = text.find(['<', '>'])?;
    let axis = AXES
        .iter()
        .position(|a| text.get(..at).is_some_and(|t| t.eq_ignore_ascii_case(a)))?;
    let v: f64 = text.get(at + 1..)?.parse().ok()?;
    let below = text.as_bytes().get(at) == Some(&b'<');
    v.is_finite().then_some(if below {
        When::Below(axis, v)
    } else {
        When::Above(axis, v)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn times_and_places() {
        let text = "; a crash and a touch\n 200ms limit X on\n\n0.5s limit x off # again\nat z<-5 PROBE on\nat X>1e2 start on\n";
        let mut s = Script::read("pins.txt", text).unwrap();
        let (mut pins, home) = (Pins::default(), Point::origin());
        assert_eq!(s.next(), Some(0.2));
        assert!(!s.play(0.1, &home, &mut pins));
        assert!(s.play(0.2, &home, &mut pins));
        assert_eq!(pins.limit, [true, false, false]);
        assert!(s.play(0.6, &Point::new(0.0, 0.0, -5.1), &mut pins));
        assert_eq!((pins.limit[0], pins.probe), (false, true));
        assert_eq!(s.next(), None);
        assert!(!s.is_empty());
        assert!(s.play(0.7, &Point::new(100.5, 0.0, 0.0), &mut pins));
        assert!(pins.cycle_start && s.is_empty());
    }

    #[test]
    fn what_cannot_be_read_is_said_with_its_place() {
        for (text, said) in [
            (
                "soon probe on",
                "p:1:1: \"soon\" is no time: write e.g. 12.5s, 200ms, or at Z<-5",
            ),
            (
                "at Z=5 probe on",
                "p:1:4: \"Z=5\" is no place: write e.g. Z<-5 or X>100 (machine coordinates, mm)",
            ),
            (
                "at",
                "p:1:1: after \"at\" comes a place, e.g. at Z<-5 probe on",
            ),
            (
                "\n  1s",
                "p:2:5: which pin? One of limit, probe, door, hold, reset, start",
            ),
            (
                "1s limit",
                "p:1:9: which axis? Write limit x, limit y or limit z",
            ),
            (
                "1s limit a on",
                "p:1:10: \"a\" is no axis: write limit x, limit y or limit z",
            ),
            (
                "1s prob on",
                "p:1:4: \"prob\" is no pin (did you mean probe?): write one of limit, probe, door, hold, reset, start",
            ),
            (
                "1s probe",
                "p:1:9: on or off? The line ends with one of them",
            ),
            (
                "1s probe closed",
                "p:1:10: \"closed\" is no state: the line ends with on or off",
            ),
            (
                "1s probe on now",
                "p:1:10: \"on\" is no state: the line ends with on or off",
            ),
            (
                "-1s probe on\n1s probe on\nx",
                "p:1:1: \"-1s\" is no time: write e.g. 12.5s, 200ms, or at Z<-5\np:3:1: \"x\" is no time: write e.g. 12.5s, 200ms, or at Z<-5",
            ),
        ] {
            assert_eq!(
                Script::read("p", text).unwrap_err().to_string(),
                said,
                "{text:?}"
            );
        }
    }

    proptest! {
        #[test]
        fn never_panics(text in "(at )?[a-zXYZ0-9<>.é; \n-]{0,60}") {
            let _ = Script::read("p", &text);
        }
    }
}
