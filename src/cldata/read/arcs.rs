//! Arcs: a statement that tells the circle, and the points or the line that end it.

use super::super::arc::{Circle, OFF_CIRCLE, turn_of_angle};
use super::super::error::{ClProblem, Fault};
use super::super::note::NoteKind;
use super::super::step::Step;
use super::args::{Args, Value, point, vector};
use super::motion::within;
use super::{Manner, State};
use crate::geom::{Point, Vector};
use crate::units::MmPerMin;
use std::f64::consts::TAU;

/// Start and end closer than this are one, mm, though their digits may differ.
pub(super) const ONE_PLACE: f64 = 2e-3;

/// Creo divides an arc evenly: a step may be longer than the longest before it by so much and still belong to it ...
const EVEN: f64 = 1.05;

/// ... and one longer by so much is a straight line. In between nobody knows.
const UNEVEN: f64 = 3.0;

/// A first step above this says nothing of how far apart the following points are, rad: Creo divides a circle by three at least.
const LARGE: f64 = 121.0 * std::f64::consts::PI / 180.0;

/// A circle that waits for points.
#[derive(Clone, Debug)]
pub(super) struct Open {
    circle: Circle,
    /// Its line.
    line: usize,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// The next GOTO ends it.
    One(Turns),
    /// All following points that lie on it belong to it.
    Series(Series),
}

/// How far a single arc turns.
#[derive(Clone, Copy, Debug)]
enum Turns {
    /// Up to the end, once round at most.
    Once,
    /// By this angle, degrees.
    Angle(f64),
    /// So many times round.
    Times(f64),
}

/// Creo's points on an arc.
#[derive(Clone, Debug, Default)]
struct Series {
    /// Points so far.
    points: u32,
    /// Longest step, rad.
    longest: f64,
    /// The arc so far that is not given out yet.
    run: Option<Run>,
}

#[derive(Clone, Copy, Debug)]
struct Run {
    from: Point,
    to: Point,
    /// Unsigned, rad.
    turn: f64,
    /// Rise along the circle's normal by its first step, mm/rad.
    slope: f64,
    feed: MmPerMin,
    line: usize,
}

impl State {
    /// `CIRCLE/x,y,z,i,j,k,r` and NX's with four numbers more.
    pub(super) fn circle(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "7 (centre, axis, radius), or 11 as NX writes it";
        self.close_arc().map_err(|p| (0, p))?;
        let at = args.at();
        let (v, found) = args.numbers::<11>(TAKES)?;
        let [x, y, z, i, j, k, r, ..] = v;
        let (axis, kind, note) = match found {
            7 => (
                vector(&[i, j, k]),
                Kind::Series(Series::default()),
                NoteKind::CircleOfSeven,
            ),
            11 => {
                let turns = self.times(&mut args)?;
                // Seen against the axis NX turns clockwise.
                (
                    -vector(&[i, j, k]),
                    Kind::One(turns),
                    NoteKind::CircleOfEleven,
                )
            }
            found => {
                let (word, takes) = ("CIRCLE", TAKES);
                return Err((at, ClProblem::Count { word, found, takes }));
            }
        };
        args.end()?;
        self.note(note);
        self.open_arc(at, [x, y, z], axis, r, kind)
    }

    /// `TIMES,n` behind an arc's numbers, if it stands there.
    fn times(&mut self, args: &mut Args) -> Result<Turns, Fault> {
        match args.next()? {
            None => Ok(Turns::Once),
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"TIMES") => {
                let at = args.at();
                let n = args.number("1 (how often round)")?;
                if n < 1.0 || n.fract() != 0.0 || n > 1e4 {
                    return Err(args.value(at, n, "must be a whole number of turns"));
                }
                Ok(Turns::Times(n))
            }
            Some((at, Value::Word(w))) => Err(args.minor(at, w, "TIMES and a number")),
            Some(_) => Err(args.unexpected("TIMES or the statement's end")),
        }
    }

    /// `MOVARC/x,y,z,i,j,k,r,ANGLE,a`, or with CENTER, AXIS and RADIUS before its numbers.
    pub(super) fn movarc(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "7 (centre, axis, radius), with ANGLE and a number, or CENTER, AXIS, RADIUS before them";
        self.close_arc().map_err(|p| (0, p))?;
        let at = args.at();
        let word_is = |value: &Option<(usize, Value)>, name: &str| matches!(value, Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(name.as_bytes()));
        let count = |at, found| {
            let (word, takes) = ("MOVARC", TAKES);
            (at, ClProblem::Count { word, found, takes })
        };
        let mut turns = Turns::Once;
        let numbers: [f64; 7];
        if word_is(&args.clone().next()?, "CENTER") {
            args.next()?;
            let part = |args: &mut Args, n: usize, next: &str| {
                let at = args.at();
                let (v, found) = args.numbers::<3>(TAKES)?;
                if found != n {
                    return Err(count(at, found));
                }
                if !next.is_empty() && !word_is(&args.next()?, next) {
                    return Err((
                        at,
                        ClProblem::Ends {
                            wanted: "AXIS and RADIUS",
                        },
                    ));
                }
                Ok(v)
            };
            let [x, y, z] = part(&mut args, 3, "AXIS")?;
            let [i, j, k] = part(&mut args, 3, "RADIUS")?;
            let [r, ..] = part(&mut args, 1, "")?;
            numbers = [x, y, z, i, j, k, r];
        } else {
            let (v, found) = args.numbers::<8>(TAKES)?;
            let [x, y, z, i, j, k, r, angle] = v;
            match found {
                7 => {}
                8 => turns = Turns::Angle(angle),
                found => return Err(count(at, found)),
            }
            numbers = [x, y, z, i, j, k, r];
        }
        if word_is(&args.clone().next()?, "ANGLE") && matches!(turns, Turns::Once) {
            args.next()?;
            turns = Turns::Angle(args.number("1 (degrees)")?);
        } else if !args.is_empty() {
            turns = self.times(&mut args)?;
        }
        let [x, y, z, i, j, k, r] = numbers;
        let axis = vector(&[i, j, k]);
        self.open_arc(at, [x, y, z], axis, r, Kind::One(turns))
    }

    /// Checks a circle against where the tool is, and waits for its points.
    fn open_arc(
        &mut self,
        at: usize,
        center: [f64; 3],
        axis: Vector,
        radius: f64,
        kind: Kind,
    ) -> Result<(), Fault> {
        let scale = self.scale();
        let circle = Circle::new(point(&center, scale), axis, radius * scale);
        let circle = circle.map_err(|p| (at, p))?;
        within(at, circle.center)?;
        self.may_turn(&circle).map_err(|p| (at, p))?;
        self.arc = Some(Open {
            circle,
            line: self.line,
            kind,
        });
        Ok(())
    }

    /// Where an arc about this circle begins.
    pub(super) fn may_turn(&self, circle: &Circle) -> Result<Point, ClProblem> {
        if self.manner == Manner::Rapid {
            return Err(ClProblem::ArcRapid);
        }
        if let Some(line) = self.changed {
            return Err(ClProblem::ArcAfterTool { line });
        }
        let from = self.at.ok_or(ClProblem::NoPlace { word: "an arc" })?;
        circle.check("start", &from)?;
        Ok(from)
    }

    /// A GOTO while a circle is open.
    pub(super) fn go_arc(&mut self, to: Point) -> Result<(), ClProblem> {
        let (Some(open), Some(from)) = (self.arc.take(), self.at) else {
            return self.go(to);
        };
        let (circle, line) = (open.circle, open.line);
        match open.kind {
            Kind::One(turns) => {
                circle.check("end", &to)?;
                let sweep = sweep(&circle, &from, &to, turns)?;
                let feed = self.feed_now()?;
                if sweep.is_none() {
                    self.note(NoteKind::ArcVanished);
                }
                self.push(Step::Feed {
                    to,
                    bow: sweep.map(|s| circle.bow(&from, s)),
                    feed,
                });
                self.arrive(to);
                Ok(())
            }
            Kind::Series(mut series) => {
                if !self.on_series(&circle, line, &mut series, from, to)? {
                    self.give(&circle, &mut series);
                    return self.go(to);
                }
                let kind = Kind::Series(series);
                self.arc = Some(Open { circle, line, kind });
                self.arrive(to);
                Ok(())
            }
        }
    }

    /// Adds a point to a series; false when it is the end of a straight line behind the arc.
    fn on_series(
        &mut self,
        circle: &Circle,
        line: usize,
        series: &mut Series,
        from: Point,
        to: Point,
    ) -> Result<bool, ClProblem> {
        if series.points == 0 {
            circle.check("end", &to)?;
        } else if !circle.holds(&to) {
            return Ok(false);
        }
        let apart = plane_distance(circle, &from, &to);
        let turn = circle.turn(&from, &to).abs();
        if series.points == 0 {
            sweep(circle, &from, &to, Turns::Once)?;
        } else {
            let uneven = turn > EVEN * series.longest;
            // A chord that nobody could tell from its arc is no question.
            let chord =
                circle.radius * (1.0 - (0.5 * turn).cos()) > OFF_CIRCLE || apart < ONE_PLACE;
            let unsure = match series.points {
                1 => series.longest > LARGE || uneven,
                _ => uneven && turn < UNEVEN * series.longest,
            };
            if unsure && chord {
                let turn = turn.to_degrees();
                return Err(ClProblem::ArcOrLine { line, turn });
            }
            if uneven {
                return Ok(false);
            }
        }
        let feed = self.feed_now()?;
        let [_, _, n] = circle.plane.axes();
        // One helix rises evenly; where it does not another begins.
        let even = |run: &Run| {
            let rise = run.from[n] + run.slope * (run.turn + turn) - to[n];
            rise.abs() <= OFF_CIRCLE
        };
        let run = match series.run {
            Some(run) if run.turn + turn > TAU + 1e-6 || !even(&run) => {
                self.give(circle, series);
                None
            }
            run => run,
        };
        let run = run.unwrap_or(Run {
            from,
            to,
            turn: 0.0,
            slope: (to[n] - from[n]) / turn,
            feed,
            line: self.line,
        });
        series.run = Some(Run {
            to,
            turn: run.turn + turn,
            line: self.line,
            ..run
        });
        series.points = series.points.saturating_add(1);
        series.longest = series.longest.max(turn);
        Ok(true)
    }

    /// Gives a series' arc out as far as it goes.
    fn give(&mut self, circle: &Circle, series: &mut Series) {
        let Some(run) = series.run.take() else {
            return;
        };
        // Once round, where the steps make it so and the digits do not quite.
        let once = circle.turn(&run.from, &run.to);
        let more = run.turn > TAU - 1e-2 && once.abs() < 1e-2;
        let sweep = match more {
            true => once + TAU.copysign(once),
            false => once,
        };
        let step = Step::Feed {
            to: run.to,
            bow: Some(circle.bow(&run.from, sweep)),
            feed: run.feed,
        };
        self.queue.push_back((run.line, step));
    }

    /// Gives out what a series has so far; further points may follow.
    pub(super) fn flush_arc(&mut self) {
        if let Some(mut open) = self.arc.take() {
            if let Kind::Series(series) = &mut open.kind {
                self.give(&open.circle, series);
            }
            self.arc = Some(open);
        }
    }

    /// Something follows that can be no point of an arc.
    pub(super) fn close_arc(&mut self) -> Result<(), ClProblem> {
        self.flush_arc();
        match self.arc.take() {
            Some(Open {
                kind: Kind::Series(s),
                ..
            }) if s.points > 0 => Ok(()),
            Some(open) => Err(ClProblem::ArcEnd { line: open.line }),
            None => Ok(()),
        }
    }
}

/// Distance of two places as the circle's plane shows it, mm.
pub(super) fn plane_distance(circle: &Circle, a: &Point, b: &Point) -> f64 {
    let [i, j, _] = circle.plane.axes();
    (a[i] - b[i]).hypot(a[j] - b[j])
}

/// How far a single arc turns, rad; `None` for nothing.
fn sweep(
    circle: &Circle,
    from: &Point,
    to: &Point,
    turns: Turns,
) -> Result<Option<f64>, ClProblem> {
    let apart = plane_distance(circle, from, to);
    let once = circle.turn(from, to);
    let small = apart < ONE_PLACE && !(1e-2..=TAU - 1e-2).contains(&once.abs());
    match turns {
        Turns::Angle(degrees) => turn_of_angle(circle, from, to, degrees),
        _ if small && apart > 1e-9 => Err(ClProblem::ArcNothing { apart }),
        Turns::Once => Ok(Some(once)),
        Turns::Times(n) if n == 1.0 || apart <= 1e-9 => {
            Ok(Some(once + (n - 1.0) * TAU.copysign(once)))
        }
        Turns::Times(times) => Err(ClProblem::ArcTimes { times }),
    }
}
