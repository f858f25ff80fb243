//! One step after another against what the program says.

use super::spelling::{Spelling, close};
use super::{Deviation, VerifyError};
use crate::cldata::{Bow, Coolant, Place, Step};
use crate::gcode::{Arc, Dialect, Event, Interpreter, Motion, MotionKind, PathMode};
use crate::geom::{Plane, Point};
use crate::units::{Mm, MmPerMin, Rpm, Seconds};
use std::f64::consts::PI;
use std::io::{BufRead, Seek};

/// Compares steps with a program as both come along. Give it every step with [`Witness::step`], then [`Witness::finish`].
pub struct Witness<R> {
    said: Interpreter<R>,
    spelling: Spelling,
    /// The event looked at and not yet taken.
    ahead: Option<Event>,
    /// Where the program has the tool, in units of the last decimal; `None` until told.
    at: [Option<i64>; 3],
    /// Line of the last thing taken.
    line: usize,
    spindle: (i8, f64),
    coolant: Coolant,
    /// The work coordinate system meant, from 1.
    offset: u16,
    ended: bool,
    deviation: Deviation,
}

/// A feed move as meant.
struct Meant<'a> {
    to: &'a Point,
    bow: Option<&'a Bow>,
    feed: MmPerMin,
}

impl<R: BufRead + Seek> Witness<R> {
    /// A witness who has heard nothing yet.
    pub fn new(said: Interpreter<R>, spelling: Spelling) -> Witness<R> {
        Witness {
            said,
            spelling,
            ahead: None,
            at: [None; 3],
            line: 1,
            spindle: (0, 0.0),
            coolant: Coolant::Off,
            offset: 1,
            ended: false,
            deviation: Deviation {
                moves: 0,
                without_line: 0,
                position: Mm(0.0),
                position_line: 0,
                feed: MmPerMin(0.0),
            },
        }
    }

    /// The next step. Returns the line that says it: for one that rounds to nothing, the line before.
    ///
    /// # Errors
    /// The first difference, or a line that does not read back.
    pub fn step(&mut self, step: &Step) -> Result<usize, VerifyError> {
        if self.ended {
            return Err(self.differs(self.line, "steps are left behind the end".into()));
        }
        match step {
            Step::Comment(_) => {}
            Step::Tool { number } => self.tool(*number)?,
            Step::Spindle {
                direction,
                speed,
                spin_up,
            } => self.spin(*direction, *speed, *spin_up)?,
            Step::Coolant(coolant) => self.cool(*coolant)?,
            Step::Dwell(time) => self.dwell(*time)?,
            Step::Pause { optional } => self.pause(*optional)?,
            Step::WorkOffset(n) => (self.offset, self.at) = (*n, [None; 3]),
            Step::Rapid { to } => self.rapid(to, false)?,
            Step::MachineRapid { to } => self.rapid(to, true)?,
            Step::Feed { to, bow, feed } => self.feed(&Meant {
                to,
                bow: bow.as_ref(),
                feed: *feed,
            })?,
            Step::End => self.end()?,
        }
        Ok(self.line)
    }

    /// Behind the last step.
    ///
    /// # Errors
    /// When the program has not ended, or goes on.
    pub fn finish(mut self) -> Result<Deviation, VerifyError> {
        if !self.ended {
            self.end()?;
        }
        Ok(self.deviation)
    }

    /// The way corners are rounded must be the one meant, where the dialect can say it.
    ///
    /// # Errors
    /// When the program has set another.
    pub fn tolerance(&mut self, meant: Option<Mm>) -> Result<(), VerifyError> {
        let state = self.said.state();
        let (Dialect::LinuxCnc, Some(meant)) = (state.dialect, meant) else {
            return Ok(());
        };
        let unit = self.spelling.unit();
        match state.path {
            PathMode::Blend { tolerance: Some(t) } if close(t, meant.0, unit) => Ok(()),
            found => {
                let text = format!("the path mode is {found:?} and G64 P{} was meant", meant.0);
                Err(self.differs(1, text))
            }
        }
    }

    /// A difference at a line.
    pub fn differs(&mut self, line: usize, difference: String) -> VerifyError {
        VerifyError::Difference {
            line,
            text: self.said.text_of(line),
            difference,
        }
    }

    fn peek(&mut self) -> Result<Option<&Event>, VerifyError> {
        if self.ahead.is_none() {
            self.ahead = match self.said.next() {
                None => None,
                Some(Ok(e)) => Some(e),
                Some(Err(e)) => {
                    return Err(VerifyError::Unreadable {
                        complaint: e.to_string(),
                        text: self.said.text_of(e.line),
                    });
                }
            };
        }
        Ok(self.ahead.as_ref())
    }

    /// The event looked at is used up.
    fn take(&mut self) {
        if let Some(e) = self.ahead.take() {
            self.line = e.line();
        }
    }

    /// Passes over what sets modes and moves nothing.
    fn settle(&mut self) -> Result<(), VerifyError> {
        while let Some(Event::Sync { .. }) = self.peek()? {
            self.take();
        }
        Ok(())
    }

    /// Passes over rapids to where the tool is, too: the first half of a return by way of a place.
    fn stand(&mut self) -> Result<(), VerifyError> {
        loop {
            self.settle()?;
            match self.peek()? {
                Some(Event::Motion(m))
                    if m.kind == MotionKind::Rapid && !m.machine_coordinates && m.from == m.to =>
                {
                    self.take()
                }
                _ => return Ok(()),
            }
        }
    }

    fn tool(&mut self, number: u32) -> Result<(), VerifyError> {
        if !self.spelling.tools {
            return Ok(());
        }
        self.settle()?;
        match self.peek()? {
            Some(&Event::ToolChange { tool, .. }) if tool == number => self.take(),
            Some(e) => {
                let (line, found) = (e.line(), name(e));
                let text = format!("{found}, where a change to tool {number} was meant");
                return Err(self.differs(line, text));
            }
            None => return Err(self.over(&format!("a change to tool {number}"))),
        }
        self.spindle = (0, 0.0);
        self.at = [None; 3];
        self.settle()
    }

    fn spin(&mut self, direction: i8, speed: Rpm, spin_up: Seconds) -> Result<(), VerifyError> {
        self.settle()?;
        if direction == 0 {
            let turns = self.spindle.0 != 0;
            self.spindle = (0, 0.0);
            return match self.peek()? {
                Some(Event::Spindle { direction: 0, .. }) => {
                    self.take();
                    Ok(())
                }
                Some(e) if turns => {
                    let (line, found) = (e.line(), name(e));
                    let text = format!("{found}, where the spindle was to stop");
                    Err(self.differs(line, text))
                }
                None if turns => Err(self.over("the spindle's stop")),
                _ => Ok(()),
            };
        }
        let unit = self.spelling.speed;
        let now = self.spindle.0;
        if now != direction
            && let Some(&Event::Spindle {
                direction: d,
                speed: s,
                ..
            }) = self.peek()?
            && d == now
            && close(s.0, speed.0, unit)
        {
            // Where speed and way round are two lines, the one comes before the other.
            self.take();
        }
        let turns = self.spindle.0 == direction && close(self.spindle.1, speed.0, unit);
        match self.peek()? {
            _ if turns => {}
            Some(&Event::Spindle {
                direction: d,
                speed: s,
                line,
            }) => {
                if d != direction || !close(s.0, speed.0, unit) {
                    let text = format!(
                        "the spindle turns {} at {} rpm, and {} at {} were meant",
                        way(d),
                        s.0,
                        way(direction),
                        speed.0
                    );
                    return Err(self.differs(line, text));
                }
                self.take();
            }
            e => {
                let (line, found) = e.map_or((0, "the end".to_string()), |e| (e.line(), name(e)));
                let text = format!(
                    "{found}, where the spindle was to turn {} at {} rpm",
                    way(direction),
                    speed.0
                );
                return Err(self.differs(line.max(1), text));
            }
        }
        self.spindle = (direction, speed.0);
        if spin_up.0 > 0.0 {
            self.wait(spin_up, "to reach its speed")?;
        }
        Ok(())
    }

    fn cool(&mut self, coolant: Coolant) -> Result<(), VerifyError> {
        self.settle()?;
        let meant = match coolant {
            Coolant::Off => (false, false),
            Coolant::Flood => (true, false),
            Coolant::Mist => (false, true),
            Coolant::Both => (true, true),
        };
        if coolant == self.coolant {
            // Said again, it changes nothing, and the machine is told nothing.
            return Ok(());
        }
        if coolant == Coolant::Both
            && let Some(&Event::Coolant { flood, mist, .. }) = self.peek()?
            && flood != mist
        {
            // One word after the other switches them on.
            self.take();
        }
        if let Some(&Event::Coolant { flood, mist, line }) = self.peek()? {
            if (flood, mist) != meant {
                let text = format!(
                    "flood and mist are {:?}, and {meant:?} was meant",
                    (flood, mist)
                );
                return Err(self.differs(line, text));
            }
            self.take();
        } else {
            let line = self.peek()?.map_or(1, Event::line);
            let text = format!("flood and mist stay as they are, and {meant:?} was meant");
            return Err(self.differs(line, text));
        }
        self.coolant = coolant;
        Ok(())
    }

    fn dwell(&mut self, time: Seconds) -> Result<(), VerifyError> {
        self.settle()?;
        // Less than the last decimal tells is no wait.
        let nothing = time.0 <= 0.5 * self.spelling.time;
        if nothing && !matches!(self.peek()?, Some(Event::Dwell { .. })) {
            return Ok(());
        }
        self.wait(time, "to stand still")
    }

    fn wait(&mut self, meant: Seconds, what: &str) -> Result<(), VerifyError> {
        let unit = self.spelling.time;
        let (found, line) = match self.peek()? {
            Some(&Event::Dwell { time, line }) => (Some(time.0), line),
            e => (None, e.map_or(1, Event::line)),
        };
        match found {
            Some(t) if close(t, meant.0, unit) => {
                self.take();
                Ok(())
            }
            None if meant.0 <= 0.5 * unit => Ok(()),
            _ => {
                let found = found.map_or("no time".to_string(), |t| format!("{t} s"));
                let text = format!("it is given {found} {what}, and {} s were meant", meant.0);
                Err(self.differs(line, text))
            }
        }
    }

    fn pause(&mut self, optional: bool) -> Result<(), VerifyError> {
        self.settle()?;
        match self.peek()? {
            Some(&Event::Pause { optional: o, .. }) if o == optional => {
                self.take();
                Ok(())
            }
            Some(e) => {
                let (line, found) = (e.line(), name(e));
                Err(self.differs(line, format!("{found}, where a pause was meant")))
            }
            None => Err(self.over("a pause")),
        }
    }

    fn rapid(&mut self, to: &Place, machine: bool) -> Result<(), VerifyError> {
        self.deviation.moves += 1;
        if machine {
            self.stand()?;
        } else {
            self.settle()?;
        }
        let counts = to.map(|v| v.map(|v| self.spelling.count(v)));
        let vanishes = !machine && (0..3).all(|k| counts[k].is_none() || counts[k] == self.at[k]);
        let frame = if machine {
            " in machine coordinates"
        } else {
            ""
        };
        let wanted = || format!("a Rapid to {}{frame}", place(to));
        let Some(m) = self.motion(&wanted, vanishes)? else {
            self.deviation.without_line += 1;
            return Ok(());
        };
        let told = if machine {
            self.said.state().machine_of_work(&m.to)
        } else {
            m.to
        };
        let there = (0..3).all(|k| match to[k] {
            Some(v) => close(told[k], v, self.spelling.unit()),
            None => m.to[k] == m.from[k],
        });
        let alike =
            m.kind == MotionKind::Rapid && m.arc.is_none() && m.machine_coordinates == machine;
        if !alike || !there {
            return Err(self.differs(m.line, format!("{} where {} was meant", say(&m), wanted())));
        }
        self.frame(m.line)?;
        for k in 0..3 {
            if to[k].is_some() {
                self.at[k] = if machine { None } else { counts[k] };
            }
        }
        if !machine {
            let meant = Point::from(std::array::from_fn::<f64, 3, _>(|k| {
                to[k].unwrap_or(m.to[k])
            }));
            self.note(&m.to, &meant, m.line);
        }
        self.take();
        Ok(())
    }

    fn feed(&mut self, meant: &Meant) -> Result<(), VerifyError> {
        self.deviation.moves += 1;
        self.settle()?;
        let counts = std::array::from_fn::<i64, 3, _>(|k| self.spelling.count(meant.to[k]));
        let small = meant.bow.is_none_or(|b| b.sweep.abs() < PI);
        let here = counts.map(Some) == self.at;
        let wanted = || meant.text();
        let Some(m) = self.motion(&wanted, here && small)? else {
            self.deviation.without_line += 1;
            let unit = self.spelling.unit();
            let at = Point::from(counts.map(|c| c as f64 * unit));
            self.note(&at, meant.to, self.line);
            return Ok(());
        };
        let unit = self.spelling.unit();
        let polar = self.spelling.polar && meant.bow.is_some();
        let shape_ok = match (&m.arc, meant.bow) {
            (None, None) => true,
            // A pole may stand beside the centre: what counts is the way between the ends. Of a helix nearly once round, the ends
            // being rounded moves the far side by twice as much as the pole.
            (Some(arc), Some(bow)) if polar => {
                let off = halfway(&m.from, &arc.center, arc.sweep, bow.plane)
                    - halfway(&m.from, &bow.center, bow.sweep, bow.plane);
                arc.plane == bow.plane
                    && arc.clockwise == (bow.sweep < 0.0)
                    && (arc.sweep - bow.sweep).abs() < PI
                    && off.norm() < 4.0 * unit
            }
            (Some(arc), Some(bow)) => same_arc(arc, bow, unit),
            // An arc shorter, or flatter, than the last decimal tells is a straight line.
            (None, Some(bow)) => {
                let [a, b, _] = bow.plane.axes();
                let still = [a, b]
                    .into_iter()
                    .all(|k| close(m.from[k], meant.to[k], unit));
                let radius = (meant.to[a] - bow.center[a]).hypot(meant.to[b] - bow.center[b]);
                let flat = radius * (1.0 - (0.5 * bow.sweep).cos()) < 0.51 * unit;
                small && (still || flat)
            }
            (Some(_), None) => false,
        };
        let off = if polar { 2.0 * unit } else { unit };
        let there = (0..3).all(|k| close(m.to[k], meant.to[k], off));
        let alike = m.kind == MotionKind::Feed && !m.inverse_time && !m.machine_coordinates;
        if !alike || !shape_ok || !there || !close(m.feed.0, meant.feed.0, self.spelling.feed) {
            return Err(self.differs(m.line, format!("{} where {} was meant", say(&m), wanted())));
        }
        self.frame(m.line)?;
        self.at = counts.map(Some);
        self.note(&m.to, meant.to, m.line);
        let d = (m.feed.0 - meant.feed.0).abs();
        self.deviation.feed = MmPerMin(self.deviation.feed.0.max(d));
        self.take();
        Ok(())
    }

    /// The next event, which must be a motion; `None` where nothing need be said and nothing is.
    fn motion(
        &mut self,
        wanted: &dyn Fn() -> String,
        may_vanish: bool,
    ) -> Result<Option<Motion>, VerifyError> {
        match self.peek()? {
            Some(Event::Motion(m)) if may_vanish && m.from != m.to => Ok(None),
            Some(Event::Motion(m)) => Ok(Some(*m)),
            _ if may_vanish => Ok(None),
            Some(e) => {
                let line = e.line();
                Err(self.differs(line, format!("no motion, where {} was meant", wanted())))
            }
            None => Err(self.over(&wanted())),
        }
    }

    /// The work coordinate system in force must be the one meant.
    fn frame(&mut self, line: usize) -> Result<(), VerifyError> {
        let found = self.said.state().work_offset + 1;
        if found == usize::from(self.offset) {
            return Ok(());
        }
        let text = format!(
            "work coordinate system {found} holds, and {} was meant",
            self.offset
        );
        Err(self.differs(line, text))
    }

    /// Everything off, then the end, then nothing.
    fn end(&mut self) -> Result<(), VerifyError> {
        let mut turns = self.spindle.0 != 0;
        let ends = self.spelling.ends;
        loop {
            self.settle()?;
            match self.peek()? {
                None if ends => return Err(self.over("its end (M2 or M30)")),
                None if turns => return Err(self.over("the spindle's stop")),
                None => {
                    self.ended = true;
                    return Ok(());
                }
                Some(Event::Spindle { direction: 0, .. }) => turns = false,
                Some(Event::Coolant {
                    flood: false,
                    mist: false,
                    ..
                }) => {}
                Some(&Event::End { line }) => {
                    if turns {
                        let text = "the program ends with the spindle turning".to_string();
                        return Err(self.differs(line, text));
                    }
                    self.take();
                    self.ended = true;
                    return match self.peek()? {
                        None => Ok(()),
                        Some(e) => {
                            let line = e.line();
                            let text = "something follows the end of the program".to_string();
                            Err(self.differs(line, text))
                        }
                    };
                }
                Some(e) => {
                    let line = e.line();
                    let text = "something is left over behind the last move".to_string();
                    return Err(self.differs(line, text));
                }
            }
            self.take();
        }
    }

    fn over(&mut self, wanted: &str) -> VerifyError {
        let text = format!("the program is over, where {wanted} was meant");
        self.differs(self.line, text)
    }

    fn note(&mut self, written: &Point, meant: &Point, line: usize) {
        let d = (written - meant).norm();
        if d > self.deviation.position.0 {
            self.deviation.position = Mm(d);
            self.deviation.position_line = line;
        }
    }
}

impl Meant<'_> {
    fn text(&self) -> String {
        let arc = self.bow.map_or_else(String::new, |b| {
            format!(" {}", about(b.plane, &b.center, b.sweep < 0.0))
        });
        let to = place(&std::array::from_fn(|k| Some(self.to[k])));
        format!("a Feed to {to}{arc} at {} mm/min", self.feed.0)
    }
}

/// Half the way round from a place about a centre, in the plane.
fn halfway(from: &Point, center: &Point, sweep: f64, plane: Plane) -> Point {
    let [a, b, _] = plane.axes();
    let (u, v) = (from[a] - center[a], from[b] - center[b]);
    let (sin, cos) = (0.5 * sweep).sin_cos();
    let mut to = *from;
    to[a] = center[a] + u * cos - v * sin;
    to[b] = center[b] + u * sin + v * cos;
    to
}

/// The same way round about the same centre, and about as far: ends are compared elsewhere.
fn same_arc(arc: &Arc, bow: &Bow, unit: f64) -> bool {
    let [a, b, _] = bow.plane.axes();
    arc.plane == bow.plane
        && arc.clockwise == (bow.sweep < 0.0)
        && [a, b]
            .into_iter()
            .all(|k| close(arc.center[k], bow.center[k], unit))
        && (arc.sweep - bow.sweep).abs() < PI
}

fn way(direction: i8) -> &'static str {
    match direction {
        1 => "clockwise",
        -1 => "counter-clockwise",
        _ => "not at all",
    }
}

fn place(to: &Place) -> String {
    let told = ["X", "Y", "Z"].iter().zip(to);
    let words = told.filter_map(|(l, v)| v.map(|v| format!("{l}{v}")));
    words.collect::<Vec<_>>().join(" ")
}

fn about(plane: Plane, center: &Point, clockwise: bool) -> String {
    let way = if clockwise {
        "clockwise"
    } else {
        "counter-clockwise"
    };
    let [a, b, _] = plane.axes();
    let mut at = [None; 3];
    (at[a], at[b]) = (Some(center[a]), Some(center[b]));
    format!("{way} about {}", place(&at))
}

fn say(m: &Motion) -> String {
    let feed = match m.kind {
        MotionKind::Rapid => String::new(),
        MotionKind::Feed if m.inverse_time => format!(" in 1/{} min", m.feed.0),
        MotionKind::Feed => format!(" at {} mm/min", m.feed.0),
    };
    let arc = m.arc.map_or_else(String::new, |a| {
        format!(" by an arc, {}", about(a.plane, &a.center, a.clockwise))
    });
    let to = place(&std::array::from_fn(|k| Some(m.to[k])));
    let frame = if m.machine_coordinates {
        " of the machine's own coordinates"
    } else {
        ""
    };
    format!("a {:?} to {to}{frame}{feed}{arc}", m.kind)
}

/// An event for messages.
fn name(e: &Event) -> String {
    match e {
        Event::Motion(m) => say(m),
        Event::Probe { .. } => "a probing move".into(),
        Event::Dwell { time, .. } => format!("a dwell of {} s", time.0),
        Event::Spindle { direction: 0, .. } => "the spindle's stop".into(),
        Event::Spindle {
            direction, speed, ..
        } => {
            format!("the spindle turning {} at {} rpm", way(*direction), speed.0)
        }
        Event::Coolant { .. } => "coolant".into(),
        Event::ToolChange { tool, .. } => format!("a change to tool {tool}"),
        Event::Pause { .. } => "a pause".into(),
        Event::Sync { .. } => "a change of offsets".into(),
        Event::End { .. } => "the end of the program".into(),
    }
}
