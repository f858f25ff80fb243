//! Spindle, coolant, tools, stops and the end.

use super::super::error::{ClProblem, Fault};
use super::super::job::Coolant;
use super::super::note::NoteKind;
use super::super::step::Step;
use super::State;
use super::args::{Args, Value, upper};
use crate::units::{Rpm, Seconds};

/// No spindle turns faster.
const FASTEST: f64 = 1e6;

impl State {
    pub(super) fn spindle(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "a speed with RPM, CLW or CCLW in any order, or ON or OFF";
        let (mut speed, mut direction, mut off, mut words) = (None, None, false, 0);
        while let Some((at, value)) = args.next()? {
            let w = match value {
                Value::Number(v) if speed.is_none() => {
                    if !(0.0..=FASTEST).contains(&v) {
                        return Err(args.value(at, v, "rev/min must be zero or above, and below a million; the direction is said by CLW or CCLW"));
                    }
                    speed = Some(v);
                    continue;
                }
                Value::Word(w) => w,
                _ => {
                    let (word, found, takes) = ("SPINDL", 2, "one");
                    return Err((at, ClProblem::Count { word, found, takes }));
                }
            };
            words += 1;
            match upper(w).as_str() {
                "RPM" | "ON" => {}
                "CLW" => direction = Some(1),
                "CCLW" => direction = Some(-1),
                "OFF" => off = true,
                "SFM" | "SMM" | "SURF" => {
                    let word = "SPINDL".to_string();
                    let why = "a constant surface speed is of lathes: give the speed by RPM";
                    return Err((at, ClProblem::Refused { word, why }));
                }
                "RANGE" => {
                    args.next()?;
                    self.note(NoteKind::Rest("SPINDL with a gear range"));
                }
                "LOW" | "MEDIUM" | "HIGH" | "AUTO" => {
                    self.note(NoteKind::Rest("SPINDL with a gear range"));
                }
                _ => return Err(args.minor(at, w, TAKES)),
            }
        }
        if speed.is_none() && words == 0 {
            return Err(args.unexpected("a speed, ON or OFF"));
        }
        self.turn_spindle(speed, direction, off).map_err(|p| (0, p))
    }

    fn turn_spindle(
        &mut self,
        speed: Option<f64>,
        direction: Option<i8>,
        off: bool,
    ) -> Result<(), ClProblem> {
        if off || speed == Some(0.0) {
            self.stop_spindle();
            return Ok(());
        }
        let speed = speed.or(self.speed).ok_or(ClProblem::SpeedUnknown)?;
        // Clockwise unless told: ISO 4343, SPINDL. A new speed alone keeps the direction.
        let kept = Some(self.direction).filter(|d| *d != 0);
        let direction = direction.or(kept).unwrap_or(1);
        (self.speed, self.direction, self.stopped) = (Some(speed), direction, None);
        self.push(Step::Spindle {
            direction,
            speed: Rpm(speed),
            spin_up: Seconds(0.0),
        });
        Ok(())
    }

    fn stop_spindle(&mut self) {
        (self.direction, self.stopped) = (0, None);
        self.push(Step::Spindle {
            direction: 0,
            speed: Rpm(0.0),
            spin_up: Seconds(0.0),
        });
    }

    pub(super) fn coolant(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "FLOOD, MIST, ON or OFF";
        let (mut on, mut kind) = (false, None);
        while let Some((at, value)) = args.next()? {
            let Value::Word(w) = value else {
                return Err(args.value(at, 0.0, "is no kind of coolant: write FLOOD, MIST or OFF"));
            };
            let told = match upper(w).as_str() {
                "FLOOD" => Coolant::Flood,
                "MIST" => Coolant::Mist,
                "OFF" => Coolant::Off,
                "ON" => {
                    on = true;
                    continue;
                }
                "THRU" | "TAPKUL" | "AIR" | "HIGH" => {
                    let word = "COOLNT".to_string();
                    let why = "only FLOOD and MIST can be posted: choose one of them, or OFF";
                    return Err((at, ClProblem::Refused { word, why }));
                }
                _ => return Err(args.minor(at, w, TAKES)),
            };
            // Two kinds in one statement are both meant.
            kind = Some(match (kind, told) {
                (Some(Coolant::Flood), Coolant::Mist) | (Some(Coolant::Mist), Coolant::Flood) => {
                    Coolant::Both
                }
                (Some(Coolant::Both), Coolant::Flood | Coolant::Mist) => Coolant::Both,
                (_, told) => told,
            });
        }
        let coolant = match (kind, on) {
            (Some(k), _) => k,
            (None, true) => {
                self.note(NoteKind::CoolantOn);
                Coolant::Flood
            }
            (None, false) => return Err(args.unexpected(TAKES)),
        };
        self.push(Step::Coolant(coolant));
        Ok(())
    }

    /// `LOADTL/n` and NX's `LOAD/TOOL,n`.
    pub(super) fn load(&mut self, mut args: Args) -> Result<(), Fault> {
        self.close_arc().map_err(|p| (0, p))?;
        let number = match args.next()? {
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"TOOL") => args.next()?,
            other => other,
        };
        let (at, v) = match number {
            Some((at, Value::Number(v))) => (at, v),
            Some((at, Value::Word(w))) => return Err(args.minor(at, w, "a tool number")),
            _ => return Err(args.unexpected("a tool number")),
        };
        if v.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&v) {
            return Err(args.value(at, v, "is no tool number: write a whole number"));
        }
        while let Some((at, value)) = args.next()? {
            if let Value::Word(w) = value
                && ![
                    "ADJUST", "LENGTH", "OSETNO", "IN", "OUT", "MANUAL", "AUTO", "ZOFF", "HOLDER",
                    "NOW",
                ]
                .iter()
                .any(|k| w.eq_ignore_ascii_case(k.as_bytes()))
            {
                return Err(args.minor(
                    at,
                    w,
                    "a tool number, ADJUST, OSETNO, LENGTH, MANUAL or AUTO",
                ));
            }
            self.note(NoteKind::Rest("LOADTL"));
        }
        if self.direction != 0 {
            self.stopped = Some(self.line);
        }
        self.direction = 0;
        self.changed = Some(self.line);
        (self.tool, self.named_tool) = (Some(v as u32), None);
        self.push(Step::Tool { number: v as u32 });
        Ok(())
    }

    /// `TOOLNO/n,...`: describes a tool, as CATIA writes it in front of LOADTL. Some processors change the tool by it, so a motion behind it
    /// with another tool in the spindle is refused.
    pub(super) fn name_tool(&mut self, mut args: Args) -> Result<(), Fault> {
        let (at, v) = match args.next()? {
            Some((at, Value::Number(v))) => (at, v),
            Some((at, Value::Word(w))) => return Err(args.minor(at, w, "a tool number")),
            _ => return Err(args.unexpected("a tool number")),
        };
        if v.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&v) {
            return Err(args.value(at, v, "is no tool number: write a whole number"));
        }
        while args.next()?.is_some() {}
        self.note(NoteKind::Harmless("TOOLNO"));
        let number = v as u32;
        self.named_tool = (self.tool != Some(number)).then_some((number, self.line));
        Ok(())
    }

    pub(super) fn delay(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "seconds, or REV and a number of revolutions";
        let (mut turns, mut number) = (false, None);
        while let Some((at, value)) = args.next()? {
            match value {
                Value::Number(v) if number.is_none() => number = Some((at, v)),
                Value::Word(w) => match upper(w).as_str() {
                    "REV" => turns = true,
                    "DWELL" | "SEC" => {}
                    _ => return Err(args.minor(at, w, TAKES)),
                },
                _ => {
                    let (word, found, takes) = ("DELAY", 2, "one");
                    return Err((at, ClProblem::Count { word, found, takes }));
                }
            }
        }
        let Some((at, v)) = number else {
            return Err(args.unexpected("a number of seconds"));
        };
        if !(0.0..=1e6).contains(&v) {
            return Err(args.value(at, v, "must be zero or above, and below a million"));
        }
        let seconds = match (turns, self.speed) {
            (false, _) => v,
            (true, Some(s)) if self.direction != 0 => {
                self.note(NoteKind::DwellTurns);
                v * 60.0 / s
            }
            (true, _) => return Err((at, ClProblem::SpeedUnknown)),
        };
        self.push(Step::Dwell(Seconds(seconds)));
        Ok(())
    }

    pub(super) fn pause(&mut self, args: Args, optional: bool) -> Result<(), Fault> {
        args.end()?;
        self.push(Step::Pause { optional });
        Ok(())
    }

    /// `AUXFUN/m`: the M codes that every controller has.
    pub(super) fn auxfun(&mut self, mut args: Args) -> Result<(), Fault> {
        let at = args.at();
        let m = args.number("1 (the M code)")?;
        match (m.fract() == 0.0 && (0.0..100.0).contains(&m)).then_some(m as u8) {
            Some(0) => self.push(Step::Pause { optional: false }),
            Some(1) => self.push(Step::Pause { optional: true }),
            Some(2 | 30) => return self.end("END", args),
            Some(3) => return (self.turn_spindle(None, Some(1), false)).map_err(|p| (at, p)),
            Some(4) => return (self.turn_spindle(None, Some(-1), false)).map_err(|p| (at, p)),
            Some(5) => self.stop_spindle(),
            Some(7) => self.push(Step::Coolant(Coolant::Mist)),
            Some(8) => self.push(Step::Coolant(Coolant::Flood)),
            Some(9) => self.push(Step::Coolant(Coolant::Off)),
            _ => return Err(args.value(at, m, "is an M code of one controller: only 0 to 5, 7 to 9 and 30 mean the same everywhere; say it in APT words")),
        }
        Ok(())
    }

    /// `END`, `FINI` and M30.
    pub(super) fn end(&mut self, word: &'static str, args: Args) -> Result<(), Fault> {
        args.end()?;
        self.close_arc().map_err(|p| (0, p))?;
        if self.end.is_none() {
            if word == "FINI" {
                self.note(NoteKind::EndMissing);
            }
            self.push(Step::End);
        }
        self.end = Some((word, self.line));
        Ok(())
    }
}
