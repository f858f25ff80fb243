//! Arcs as a part program drives them: along a circle, on to a line. CATIA's and Creo's APT output has them.

use super::super::arc::{Circle, OFF_CIRCLE, crossing};
use super::super::error::{ClProblem, Fault};
use super::super::step::Step;
use super::super::token::Token;
use super::State;
use super::arcs::{ONE_PLACE, plane_distance};
use super::args::{Args, Value, point, upper, vector};
use super::motion::within;
use crate::geom::{Point, Vector};
use std::f64::consts::TAU;

impl State {
    /// `INDIRV/i,j,k` and `INDIRP/x,y,z`.
    pub(super) fn along(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "3";
        self.close_arc().map_err(|p| (0, p))?;
        let at = args.at();
        let (v, found) = args.numbers::<3>(TAKES)?;
        args.end()?;
        let word = args.word;
        if found != 3 {
            return Err((
                at,
                ClProblem::Count {
                    word,
                    found,
                    takes: TAKES,
                },
            ));
        }
        self.along = Some(match (word, self.at) {
            ("INDIRV", _) => vector(&v),
            (_, Some(here)) => point(&v, self.scale()) - here,
            (_, None) => return Err((0, ClProblem::NoPlace { word })),
        });
        Ok(())
    }

    /// `TLON,GOFWD/(CIRCLE/..),ON,[n,INTOF,](LINE/..)`.
    pub(super) fn tlon(&mut self, mut args: Args) -> Result<(), Fault> {
        self.close_arc().map_err(|p| (0, p))?;
        let at = args.at();
        let numbers = bracket(&mut args, "CIRCLE")?;
        let (center, axis, radius) = match numbers {
            ([x, y, z, r, ..], 4) => ([x, y, z], Vector::z(), r),
            ([x, y, z, i, j, k, r], 7) => ([x, y, z], vector(&[i, j, k]), r),
            (_, found) => {
                let (word, takes) = ("CIRCLE", "4 (centre, radius) or 7 with the axis here");
                return Err((at, ClProblem::Count { word, found, takes }));
            }
        };
        args.must(Token::Comma, "a comma and ON")?;
        match args.next()? {
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"ON") => {}
            Some((at, Value::Word(w))) => return Err(args.minor(at, w, "ON")),
            _ => return Err(args.unexpected("ON")),
        }
        let mut nth = 1;
        let place = args.at();
        let mut ahead = args.clone();
        if let Ok(Some((_, Value::Number(n)))) = ahead.next() {
            match ahead.next()? {
                Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"INTOF") => {}
                _ => return Err(ahead.unexpected("INTOF")),
            }
            if n != 1.0 && n != 2.0 {
                return Err(args.value(
                    place,
                    n,
                    "INTOF is neither 1 nor 2: an arc crosses a line twice at most",
                ));
            }
            nth = n as u32;
            args = ahead;
        }
        let at_line = args.at();
        let (l, found) = bracket(&mut args, "LINE")?;
        if found != 6 {
            let (word, takes) = ("LINE", "6 (two points) here");
            return Err((at_line, ClProblem::Count { word, found, takes }));
        }
        args.end()?;
        let scale = self.scale();
        let circle = Circle::new(point(&center, scale), axis, radius * scale);
        let circle = circle.map_err(|p| (at, p))?;
        within(at, circle.center)?;
        let [x1, y1, z1, x2, y2, z2, _] = l;
        let line = [point(&[x1, y1, z1], scale), point(&[x2, y2, z2], scale)];
        for p in &line {
            within(at_line, *p)?;
        }
        (self.drive(circle, &line, nth)).map_err(|problem| (at, problem))
    }

    /// Along a circle up to a line.
    fn drive(&mut self, mut circle: Circle, line: &[Point; 2], nth: u32) -> Result<(), ClProblem> {
        let from = self.may_turn(&circle)?;
        let along = self.along.take().ok_or(ClProblem::ArcDirection)?;
        let [i, j, n] = circle.plane.axes();
        // Which way round the direction says.
        let (rx, ry) = (from[i] - circle.center[i], from[j] - circle.center[j]);
        let tangent = along[j] * rx - along[i] * ry;
        let full = along.norm() * rx.hypot(ry);
        if !(0.5..2.0).contains(&(tangent / full).abs()) {
            return Err(ClProblem::ArcTangent);
        }
        circle.clockwise = tangent < 0.0;
        if line
            .iter()
            .any(|p| !(-OFF_CIRCLE..=OFF_CIRCLE).contains(&(p[n] - from[n])))
        {
            return Err(ClProblem::ArcHeight);
        }
        let end = crossing(&circle, &from, [&line[0], &line[1]], nth)?;
        // CATIA's line runs from the centre to the end: then both must say the same.
        let [first, second] = line;
        let told =
            plane_distance(&circle, first, &circle.center) <= ONE_PLACE && circle.holds(second);
        if told && plane_distance(&circle, second, &end) > OFF_CIRCLE {
            let (x, y) = (end.x, end.y);
            return Err(ClProblem::ArcCrossing { x, y });
        }
        let once = circle.turn(&from, &end);
        let back = plane_distance(&circle, &from, &end) <= OFF_CIRCLE;
        let sweep = match back && once.abs() < 1.0 {
            true => once + TAU.copysign(once),
            false => once,
        };
        let feed = self.feed_now()?;
        self.push(Step::Feed {
            to: end,
            bow: Some(circle.bow(&from, sweep)),
            feed,
        });
        self.arrive(end);
        Ok(())
    }
}

/// `(WORD/numbers)`, with CANON before them where it stands.
fn bracket(args: &mut Args, word: &'static str) -> Result<([f64; 7], usize), Fault> {
    let wanted = match word {
        "CIRCLE" => "a bracket with CIRCLE/",
        _ => "a bracket with LINE/",
    };
    args.must(Token::Open, wanted)?;
    let at = args.at();
    match args.word_before_slash() {
        Some(w) if w.eq_ignore_ascii_case(word.as_bytes()) => {}
        Some(w) => return Err(args.minor(at, w, word)),
        None => return Err(args.unexpected(wanted)),
    }
    if let Ok(Some((_, Value::Word(w)))) = args.clone().next()
        && upper(w) == "CANON"
    {
        args.next()?;
    }
    let v = args.numbers::<7>("numbers up to its bracket")?;
    args.must(Token::Close, "a closing bracket")?;
    Ok(v)
}
