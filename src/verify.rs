//! The witness: does the text say what we meant?
//!
//! Crosses the border: the moves we wanted and the program made of them in; a [`Deviation`], or the first difference, out. `post`
//! wrote the text and `gcode` reads it; they never meet but here, so a mistake in one cannot be excused by the other.
//!
//! The program is read from a machine left in the worst modes (G91, G93, the other units, another plane and work offset, G1 at a
//! crawl, standing somewhere else), so what it does not set itself shows as a difference.

use crate::cldata::{Coolant, Job};
use crate::gcode::{
    Arc, Dialect, Distance, Event, FeedMode, Motion, MotionKind, MotionMode, PathMode, Plane,
    State, interpret_from,
};
use crate::geom::Point;
use crate::post::{Post, Posted};
use crate::toolpath::{MoveKind, Toolpath, Turn};
use crate::units::{Mm, MmPerMin, Rpm, Seconds};
use std::f64::consts::PI;

/// How well the text agrees with the moves. All differences are within half a unit of the last decimal, or there is an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Moves of the toolpath.
    pub moves: usize,
    /// Moves that rounded to nothing and have no line of their own.
    pub without_line: usize,
    /// Greatest distance of a written end point from the one meant.
    pub position: Mm,
    /// Line where it occurs; zero when all are exact.
    pub position_line: usize,
    /// Greatest difference of a feed from the one meant.
    pub feed: MmPerMin,
}

/// Why a program is not what was meant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The interpreter refuses a line.
    #[error("the program does not read back: line {complaint} (in \"{text}\")")]
    Unreadable {
        /// Line, column and reason.
        complaint: String,
        /// The line.
        text: String,
    },
    /// The machine would be told something else.
    #[error("line {line} (\"{text}\"): {difference}")]
    Difference {
        /// Line of the program, from 1.
        line: usize,
        /// The line.
        text: String,
        /// What it says and what was meant.
        difference: String,
    },
    /// A post whose reader no interpreter is known for.
    #[error("post {post}: no interpreter is called \"{reader}\"")]
    NoReader {
        /// The post.
        post: String,
        /// Its reader.
        reader: String,
    },
}

/// The interpreter for programs of a post, or an error when it names none that we have.
pub fn dialect_of(post: &Post) -> Result<Dialect, VerifyError> {
    match post.reader.as_str() {
        "grbl" => Ok(Dialect::Grbl),
        "linuxcnc" => Ok(Dialect::LinuxCnc),
        reader => Err(VerifyError::NoReader {
            post: post.name.clone(),
            reader: reader.to_string(),
        }),
    }
}

/// Reads `posted` back and compares it, move by move, with what was meant: end points, arcs (centre and way round), rapid or feed, feeds, spindle, dwell,
/// coolant, path tolerance, order, the way up before and after, the program's end, and `posted.line_of_move`. Linear in the length of the program.
pub fn verify(
    posted: &Posted,
    toolpath: &Toolpath,
    job: &Job,
    post: &Post,
) -> Result<Deviation, VerifyError> {
    let program =
        interpret_from(worst_state(dialect_of(post)?, post), &posted.text).map_err(|errors| {
            let line = errors.first().map_or(0, |e| e.line);
            VerifyError::Unreadable {
                complaint: errors.first().map(|e| e.to_string()).unwrap_or_default(),
                text: line_text(&posted.text, line),
            }
        })?;
    let witness = Witness {
        posted,
        toolpath,
        job,
        events: &program.events,
        next: 0,
        position_tolerance: post.rounding().0,
        feed_tolerance: half_unit(post.feed_decimals()) * post.units.mm(),
        speed_tolerance: half_unit(post.decimals.speed),
        time_tolerance: half_unit(post.decimals.seconds),
        deviation: Deviation {
            moves: toolpath.moves.len(),
            without_line: 0,
            position: Mm(0.0),
            position_line: 0,
            feed: MmPerMin(0.0),
        },
    };
    if let (Dialect::LinuxCnc, Some(meant)) = (
        program.end_state.dialect,
        job.path_tolerance.or(post.path_tolerance),
    ) {
        let ok = matches!(program.end_state.path, PathMode::Blend { tolerance: Some(t) } if close(t, meant.0, post.rounding().0));
        if !ok {
            let found = format!(
                "the path mode is {:?} and G64 P{} was meant",
                program.end_state.path, meant.0
            );
            return Err(witness.differs(1, found));
        }
    }
    witness.run()
}

/// Everything a program must not rely on, set against it.
fn worst_state(dialect: Dialect, post: &Post) -> State {
    let mut s = State::new(dialect);
    s.motion = MotionMode::Linear;
    s.plane = Plane::Yz;
    s.distance = Distance::Incremental;
    s.feed_mode = FeedMode::InverseTime;
    s.units = match post.units {
        crate::post::Units::Mm => crate::gcode::Units::Inch,
        crate::post::Units::Inch => crate::gcode::Units::Mm,
    };
    s.work_offset = 1;
    s.feed = MmPerMin(1.0);
    s.speed = Rpm(1.0);
    s.position = Point::new(-1234.5, 2345.6, -3456.7);
    s
}

fn half_unit(decimals: u8) -> f64 {
    0.5 * 0.1_f64.powi(i32::from(decimals))
}

/// Equal to within a tolerance, and a hair for the arithmetic of reading.
fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * (1.0 + 1e-9) + 1e-12 + 4.0 * f64::EPSILON * b.abs()
}

fn line_text(text: &str, line: usize) -> String {
    text.lines()
        .nth(line.saturating_sub(1))
        .unwrap_or_default()
        .to_string()
}

/// What a move should look like in the text.
#[derive(Clone, Copy)]
struct Meant {
    kind: MotionKind,
    to: Point,
    feed: MmPerMin,
    /// The arc, and the signed angle it sweeps, rad.
    turn: Option<(Turn, f64)>,
}

struct Witness<'a> {
    posted: &'a Posted,
    toolpath: &'a Toolpath,
    job: &'a Job,
    events: &'a [Event],
    /// Index of the next event.
    next: usize,
    position_tolerance: f64,
    feed_tolerance: f64,
    speed_tolerance: f64,
    time_tolerance: f64,
    deviation: Deviation,
}

impl Witness<'_> {
    fn run(mut self) -> Result<Deviation, VerifyError> {
        let (Some(first), Some(last)) = (self.toolpath.moves.first(), self.toolpath.moves.last())
        else {
            return Err(self.differs(
                1,
                "there are no moves, so there should be no program".into(),
            ));
        };
        if self.posted.line_of_move.len() != self.toolpath.moves.len() {
            let found = format!(
                "{} moves and {} lines",
                self.toolpath.moves.len(),
                self.posted.line_of_move.len()
            );
            return Err(self.differs(
                1,
                format!("the record of lines does not fit the moves: {found}"),
            ));
        }
        let up = self.toolpath.safe_z.max(first.to.z);
        self.preparations()?;
        self.rise(up)?;
        self.spin()?;
        let mut at = Point::new(f64::NAN, f64::NAN, up);
        for i in 0..self.toolpath.moves.len() {
            at = self.one_move(i, at, up)?;
        }
        // Up again, unless the path ends up there already. Within the rounding both are right.
        let safe_z = self.toolpath.safe_z;
        let is_up = at.z >= safe_z || close(at.z, safe_z, self.position_tolerance);
        let rises = matches!(self.events.get(self.next), Some(Event::Motion(_)));
        if !is_up || (rises && last.to.z <= safe_z) {
            self.rise(safe_z)?;
        }
        self.ending()?;
        Ok(self.deviation)
    }

    /// Before the first motion: tool, offsets, but nothing that turns or waits.
    fn preparations(&mut self) -> Result<(), VerifyError> {
        while let Some(Event::ToolChange { .. } | Event::Sync { .. }) = self.events.get(self.next) {
            self.next += 1;
        }
        Ok(())
    }

    /// Straight up, as a rapid.
    fn rise(&mut self, z: f64) -> Result<(), VerifyError> {
        let m = self.motion("a rapid straight to the safe height")?;
        let vertical = m.from.x == m.to.x && m.from.y == m.to.y;
        if m.kind != MotionKind::Rapid
            || !vertical
            || !plain(&m)
            || !close(m.to.z, z, self.position_tolerance)
        {
            return Err(self.differs(
                m.line,
                format!("{} where a rapid straight to Z{z} was meant", say(&m)),
            ));
        }
        Ok(())
    }

    /// Spindle, its time to speed up, coolant: exactly what the job asks for.
    fn spin(&mut self) -> Result<(), VerifyError> {
        let (mut speed, mut waited, mut coolant) = (None, None, (false, false));
        let mut line = 1;
        while let Some(event) = self.events.get(self.next) {
            match *event {
                Event::Spindle {
                    direction: 1,
                    speed: s,
                    ..
                } if speed.is_none() => speed = Some(s),
                Event::Dwell { time, .. } if speed.is_some() && waited.is_none() => {
                    waited = Some(time)
                }
                Event::Coolant { flood, mist, .. } => coolant = (flood, mist),
                Event::Motion(m) => {
                    line = m.line;
                    break;
                }
                _ => {
                    return Err(self.differs(
                        event.line(),
                        "something else than spindle, dwell and coolant before the first move"
                            .into(),
                    ));
                }
            }
            self.next += 1;
        }
        let turns = self.job.speed.0 > 0.0;
        let speed_ok = match speed {
            None => !turns,
            Some(Rpm(s)) => turns && close(s, self.job.speed.0, self.speed_tolerance),
        };
        if !speed_ok {
            let found = format!(
                "the spindle's speed is {speed:?} when the first move begins, and {:?} was meant",
                self.job.speed
            );
            return Err(self.differs(line, found));
        }
        let wait = if turns { self.job.spin_up.0 } else { 0.0 };
        if !close(
            waited.map_or(0.0, |t: Seconds| t.0),
            wait,
            self.time_tolerance,
        ) {
            let found = format!(
                "the spindle is given {waited:?} to reach its speed, and {wait} s were meant"
            );
            return Err(self.differs(line, found));
        }
        let meant = match self.job.coolant {
            Coolant::Off => (false, false),
            Coolant::Flood => (true, false),
            Coolant::Mist => (false, true),
        };
        if coolant != meant {
            let found = format!(
                "flood and mist are {coolant:?} when the first move begins, and {meant:?} was meant"
            );
            return Err(self.differs(line, found));
        }
        Ok(())
    }

    /// The motions of one move; returns where the text has the tool then.
    fn one_move(&mut self, i: usize, at: Point, up: f64) -> Result<Point, VerifyError> {
        let (Some(mv), Some(&line)) = (self.toolpath.moves.get(i), self.posted.line_of_move.get(i))
        else {
            return Ok(at);
        };
        let before = i.checked_sub(1).and_then(|k| self.toolpath.moves.get(k));
        let turn = mv
            .turn
            .zip(before)
            .map(|(t, b)| (t, t.sweep(&b.to, &mv.to)));
        let meant = Meant {
            turn,
            kind: match mv.kind {
                MoveKind::Rapid | MoveKind::Retract => MotionKind::Rapid,
                MoveKind::Plunge | MoveKind::Cut | MoveKind::Link => MotionKind::Feed,
            },
            to: mv.to,
            feed: match (mv.kind, mv.feed) {
                (MoveKind::Plunge, _) => self.job.plunge,
                (_, Some(own)) if own.0 < self.job.feed.0 => own,
                _ => self.job.feed,
            },
        };
        if i == 0 {
            // Over the place first, at the height of the rise; then down, if the target is lower.
            let over = Meant {
                to: Point::new(mv.to.x, mv.to.y, up),
                ..meant
            };
            let m = self.compare(i, over)?;
            if m.line == line {
                return Ok(m.to);
            }
        } else if self.posted.line_of_move.get(i - 1) == Some(&line) {
            if !self.near(&at, &mv.to) || !vanishes(&turn) {
                let found = format!(
                    "move {i} has no line of its own, yet goes from {} to {}",
                    show(&at),
                    show(&mv.to)
                );
                return Err(self.differs(line, found));
            }
            self.deviation.without_line += 1;
            self.note(&at, &mv.to, line);
            return Ok(at);
        }
        let m = self.compare(i, meant)?;
        if m.line != line {
            return Err(self.differs(
                m.line,
                format!("move {i} is written here, and line {line} is recorded for it"),
            ));
        }
        Ok(m.to)
    }

    /// Takes the next motion and compares it with what was meant.
    fn compare(&mut self, i: usize, meant: Meant) -> Result<Motion, VerifyError> {
        let m = self.motion("a move")?;
        let feed_ok =
            meant.kind == MotionKind::Rapid || close(m.feed.0, meant.feed.0, self.feed_tolerance);
        let shape_ok = match (&m.arc, &meant.turn) {
            (None, None) => true,
            (Some(arc), Some(turn)) => self.same_arc(arc, turn),
            // An arc shorter than the last decimal tells is a straight line.
            (None, turn) => vanishes(turn) && self.near_flat(&m.from, &meant.to),
            (Some(_), None) => false,
        };
        let in_work = !m.inverse_time && !m.machine_coordinates;
        if m.kind != meant.kind || !in_work || !shape_ok || !self.near(&m.to, &meant.to) || !feed_ok
        {
            let feed = match meant.kind {
                MotionKind::Rapid => String::new(),
                MotionKind::Feed => format!(" at {} mm/min", meant.feed.0),
            };
            let arc = meant.turn.map_or_else(String::new, |(t, _)| {
                let way = if t.clockwise {
                    "clockwise"
                } else {
                    "counter-clockwise"
                };
                format!(" {way} about X{} Y{}", t.center.x, t.center.y)
            });
            let wanted = format!("{:?} to {}{arc}{feed}", meant.kind, show(&meant.to));
            return Err(self.differs(
                m.line,
                format!("{} where move {i}, a {wanted}, was meant", say(&m)),
            ));
        }
        self.note(&m.to, &meant.to, m.line);
        if meant.kind == MotionKind::Feed {
            let d = (m.feed.0 - meant.feed.0).abs();
            self.deviation.feed = MmPerMin(self.deviation.feed.0.max(d));
        }
        Ok(m)
    }

    /// Everything off, then the end, then nothing.
    fn ending(&mut self) -> Result<(), VerifyError> {
        let mut stopped = self.job.speed.0 <= 0.0;
        while let Some(event) = self.events.get(self.next) {
            match *event {
                Event::Spindle { direction: 0, .. } => stopped = true,
                Event::Coolant {
                    flood: false,
                    mist: false,
                    ..
                } => {}
                Event::End { line } => {
                    if !stopped {
                        return Err(
                            self.differs(line, "the program ends with the spindle turning".into())
                        );
                    }
                    return match self.events.get(self.next + 1) {
                        None => Ok(()),
                        Some(e) => Err(self
                            .differs(e.line(), "something follows the end of the program".into())),
                    };
                }
                _ => {
                    return Err(self.differs(
                        event.line(),
                        "something is left over behind the last move".into(),
                    ));
                }
            }
            self.next += 1;
        }
        let line = self.events.last().map_or(1, Event::line);
        Err(self.differs(line, "the program does not end (M2 or M30)".into()))
    }

    /// The next event, which must be a motion.
    fn motion(&mut self, wanted: &str) -> Result<Motion, VerifyError> {
        match self.events.get(self.next) {
            Some(Event::Motion(m)) => {
                self.next += 1;
                Ok(*m)
            }
            Some(e) => Err(self.differs(e.line(), format!("no motion, where {wanted} was meant"))),
            None => {
                let line = self.events.last().map_or(1, Event::line);
                Err(self.differs(
                    line,
                    format!("the program is over, where {wanted} was meant"),
                ))
            }
        }
    }

    fn near(&self, a: &Point, b: &Point) -> bool {
        a.iter()
            .zip(b.iter())
            .all(|(a, b)| close(*a, *b, self.position_tolerance))
    }

    /// Equal in plan, where no line of its own would be seen.
    fn near_flat(&self, a: &Point, b: &Point) -> bool {
        (0..2).all(|k| close(a[k], b[k], self.position_tolerance))
    }

    /// The same way round about the same centre, and about as far: ends are compared elsewhere.
    fn same_arc(&self, arc: &Arc, (turn, sweep): &(Turn, f64)) -> bool {
        arc.plane == Plane::Xy
            && arc.clockwise == turn.clockwise
            && close(arc.center.x, turn.center.x, self.position_tolerance)
            && close(arc.center.y, turn.center.y, self.position_tolerance)
            && (arc.sweep - sweep).abs() < PI
    }

    fn note(&mut self, written: &Point, meant: &Point, line: usize) {
        let d = (written - meant).norm();
        if d > self.deviation.position.0 {
            self.deviation.position = Mm(d);
            self.deviation.position_line = line;
        }
    }

    fn differs(&self, line: usize, difference: String) -> VerifyError {
        VerifyError::Difference {
            line,
            text: line_text(&self.posted.text, line),
            difference,
        }
    }
}

/// No arc, or one that may be too short to be told from a point.
fn vanishes(turn: &Option<(Turn, f64)>) -> bool {
    turn.is_none_or(|(_, sweep)| sweep.abs() < PI)
}

/// A straight move in work coordinates at so many mm per minute.
fn plain(m: &Motion) -> bool {
    m.arc.is_none() && !m.inverse_time && !m.machine_coordinates
}

fn show(p: &Point) -> String {
    format!("X{} Y{} Z{}", p.x, p.y, p.z)
}

fn say(m: &Motion) -> String {
    let feed = match m.kind {
        MotionKind::Rapid => String::new(),
        MotionKind::Feed if m.inverse_time => format!(" in 1/{} min", m.feed.0),
        MotionKind::Feed => format!(" at {} mm/min", m.feed.0),
    };
    let arc = m.arc.map_or_else(String::new, |a| {
        let way = if a.clockwise {
            "clockwise"
        } else {
            "counter-clockwise"
        };
        format!(" by an arc, {way} about X{} Y{}", a.center.x, a.center.y)
    });
    format!("a {:?} to {}{feed}{arc}", m.kind, show(&m.to))
}

#[cfg(test)]
mod tests;
