//! Writing APT cutter-location data.
//!
//! Crosses the border: [`Step`]s in; the bytes of a CL file in mm out, each statement on lines of at most 72 columns, carried on by `$`.
//! Numbers are the shortest that read back to the same f64. What comes back from [`super::read::Reader`] are the same steps, with these
//! bounds, which are APT's:
//!
//! - every place is whole: axes that a rapid leaves out are filled in from where the tool is;
//! - the first rise to a safe height, when X and Y are not known yet, is `CLEARP/XYPLAN,z` and `RETRCT`: the words for "straight up to the
//!   clearance plane". A post-processor that has no RETRCT starts at the first whole place, which is at that height;
//! - a spindle's time to reach its speed becomes a `DELAY` behind it;
//! - an arc's centre has the height of its start, and its turn is what its points and the number of turns say;
//! - comments are printable ASCII of at most 65 characters: others are changed and split.
//!
//! Arcs are `MOVARC/x,y,z,i,j,k,r,ANGLE,a` and a `GOTO`: right hand, ISO 4343, as Autodesk's APT output writes it and as NX's CLSF is turned
//! into ISO CL data for Vericut. It alone says how far an arc turns, so that half and whole circles and helices are never guessed.

use super::arc::{OFF_CIRCLE, turn};
use super::cutter::Cutter;
use super::job::Coolant;
use super::step::{Bow, Place, Step};
use crate::geom::Point;
use crate::units::MmPerMin;
use std::f64::consts::TAU;
use std::io::{self, Write};

/// Coordinates (mm), feeds (mm/min), speeds and times beyond this are no machine's.
const MOST: f64 = 1e6;

/// Columns of a line.
const COLUMNS: usize = 72;

/// Characters of a comment's text.
const COMMENT: usize = 65;

/// What stands at the top of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// Text of PARTNO.
    pub part: String,
    /// The cutter, as CUTTER/d,r (and e,f,a,b,h as far as they are told).
    pub cutter: Option<Cutter>,
}

/// Why a step could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ClWriteError {
    /// The file.
    #[error("the CL file cannot be written: {0}")]
    Io(#[from] io::Error),
    /// A number that is none, or no machine's.
    #[error("{what} is {value}: the path is broken there")]
    Number {
        /// Which.
        what: &'static str,
        /// As it is.
        value: f64,
    },
    /// A rapid along some axes while others are not known.
    #[error(
        "a rapid moves X or Y while where the tool is is not known whole: APT has whole places only; move all three axes first"
    )]
    PartialRapid,
    /// A cut from an unknown place.
    #[error(
        "a cut begins where the tool's place is not known whole: put a rapid to a whole place before it"
    )]
    NoPlace,
    /// Machine coordinates.
    #[error(
        "a rapid in machine coordinates cannot be said in APT: give the place in work coordinates"
    )]
    MachineRapid,
    /// Work offsets.
    #[error("work offset {0} cannot be said in APT: choose it in the post")]
    WorkOffset(u16),
    /// An arc whose radii differ.
    #[error("an arc starts {start:.4} mm from its centre and ends {end:.4} mm from it")]
    Arc {
        /// mm.
        start: f64,
        /// mm.
        end: f64,
    },
    /// Something behind the end.
    #[error("a step stands behind the end of the program")]
    AfterEnd,
}

/// Writes steps, one after the other.
#[derive(Debug)]
pub struct Writer<W> {
    to: W,
    at: Place,
    feed: Option<f64>,
    ended: bool,
    /// The statement in hand.
    text: String,
}

impl<W: Write> Writer<W> {
    /// Writes the top of a file.
    ///
    /// # Errors
    /// What the file answers, and a cutter that is no number.
    pub fn new(to: W, options: &WriteOptions) -> Result<Writer<W>, ClWriteError> {
        let mut w = Writer {
            to,
            at: [None; 3],
            feed: None,
            ended: false,
            text: String::new(),
        };
        w.line(&format!("PARTNO/{}", clean(&options.part, COMMENT)))?;
        w.line("UNITS/MM")?;
        if let Some(c) = &options.cutter {
            let all = [Some([c.diameter, c.corner_radius]), c.corner_at, c.angles];
            let numbers: Vec<f64> = all.into_iter().map_while(|p| p).flatten().collect();
            w.numbers("CUTTER", "the cutter", &numbers)?;
        }
        Ok(w)
    }

    /// Writes a step.
    ///
    /// # Errors
    /// What the file answers, and what cannot be said in APT; then the file is not whole.
    pub fn write(&mut self, step: &Step) -> Result<(), ClWriteError> {
        if self.ended {
            return Err(ClWriteError::AfterEnd);
        }
        match step {
            Step::Comment(text) => self.comment(text),
            Step::Tool { number } => self.line(&format!("LOADTL/{number}")),
            Step::Spindle {
                direction: 0,
                spin_up: _,
                speed: _,
            } => self.line("SPINDL/OFF"),
            Step::Spindle {
                direction,
                speed,
                spin_up,
            } => {
                let speed = above_zero("the spindle's speed", speed.0)?;
                let way = if *direction > 0 { "CLW" } else { "CCLW" };
                self.line(&format!("SPINDL/RPM,{speed},{way}"))?;
                match spin_up.0 > 0.0 {
                    true => self.numbers("DELAY", "a dwell", &[spin_up.0]),
                    false => Ok(()),
                }
            }
            Step::Coolant(c) => self.line(match c {
                Coolant::Off => "COOLNT/OFF",
                Coolant::Flood => "COOLNT/FLOOD",
                Coolant::Mist => "COOLNT/MIST",
                Coolant::Both => "COOLNT/FLOOD,MIST",
            }),
            Step::Dwell(s) if s.0 < 0.0 => Err(ClWriteError::Number {
                what: "a dwell",
                value: s.0,
            }),
            Step::Dwell(s) => self.numbers("DELAY", "a dwell", &[s.0]),
            Step::Pause { optional } => self.line(if *optional { "OPSTOP" } else { "STOP" }),
            Step::WorkOffset(n) => Err(ClWriteError::WorkOffset(*n)),
            Step::Rapid { to } => self.rapid(to),
            Step::MachineRapid { .. } => Err(ClWriteError::MachineRapid),
            Step::Feed { to, bow, feed } => self.cut(to, bow.as_ref(), *feed),
            Step::End => {
                self.ended = true;
                self.line("END")
            }
        }
    }

    /// Writes the end of the file, and gives it back.
    ///
    /// # Errors
    /// What the file answers.
    pub fn finish(mut self) -> Result<W, ClWriteError> {
        self.line("FINI")?;
        self.to.flush()?;
        Ok(self.to)
    }

    fn rapid(&mut self, to: &Place) -> Result<(), ClWriteError> {
        let mut place = self.at;
        for (here, there) in place.iter_mut().zip(to) {
            *here = there.or(*here);
        }
        match (place, to) {
            ([Some(x), Some(y), Some(z)], _) => {
                self.line("RAPID")?;
                self.goto(&Point::new(x, y, z))
            }
            (_, [None, None, Some(z)]) => {
                self.numbers("CLEARP/XYPLAN", "Z", &[*z])?;
                self.at[2] = Some(*z);
                self.line("RETRCT")
            }
            _ => Err(ClWriteError::PartialRapid),
        }
    }

    fn cut(&mut self, to: &Point, bow: Option<&Bow>, feed: MmPerMin) -> Result<(), ClWriteError> {
        let [Some(x), Some(y), Some(z)] = self.at else {
            return Err(ClWriteError::NoPlace);
        };
        if self.feed != Some(feed.0) {
            let f = above_zero("a feed", feed.0)?;
            self.line(&format!("FEDRAT/MMPM,{f}"))?;
            self.feed = Some(feed.0);
        }
        if let Some(b) = bow {
            self.arc(&Point::new(x, y, z), to, b)?;
        }
        self.goto(to)
    }

    fn arc(&mut self, from: &Point, to: &Point, bow: &Bow) -> Result<(), ClWriteError> {
        let [i, j, n] = bow.plane.axes();
        let radius = |p: &Point| (p[i] - bow.center[i]).hypot(p[j] - bow.center[j]);
        let (start, end) = (radius(from), radius(to));
        if !(-OFF_CIRCLE..=OFF_CIRCLE).contains(&(start - end)) {
            return Err(ClWriteError::Arc { start, end });
        }
        let mut center = bow.center;
        center[n] = from[n];
        let mut axis = [0.0; 3];
        axis[n] = 1f64.copysign(bow.sweep);
        // Digits that are the same for the same arc: the turn of its points and the number of turns.
        let once = turn(bow.plane, &center, from, to, bow.sweep < 0.0).abs();
        let more = ((bow.sweep.abs() - once) / TAU).round();
        let angle = (once + more * TAU).to_degrees();
        let numbers = [
            center.x, center.y, center.z, axis[0], axis[1], axis[2], start,
        ];
        self.text.clear();
        self.text.push_str("MOVARC/");
        for v in numbers {
            self.text.push_str(&number("an arc's centre", v)?);
            self.text.push(',');
        }
        self.text.push_str("ANGLE,");
        self.text.push_str(&number("an arc's angle", angle)?);
        self.statement()
    }

    fn goto(&mut self, to: &Point) -> Result<(), ClWriteError> {
        self.at = [Some(to.x), Some(to.y), Some(to.z)];
        self.numbers("GOTO", "a coordinate", &[to.x, to.y, to.z])
    }

    /// A statement of numbers.
    fn numbers(
        &mut self,
        word: &str,
        what: &'static str,
        values: &[f64],
    ) -> Result<(), ClWriteError> {
        self.text.clear();
        self.text.push_str(word);
        let mut mark = if word.contains('/') { ',' } else { '/' };
        for v in values {
            self.text.push(mark);
            self.text.push_str(&number(what, *v)?);
            mark = ',';
        }
        self.statement()
    }

    /// The statement in hand, on as many lines as it needs.
    fn statement(&mut self) -> Result<(), ClWriteError> {
        let mut rest = self.text.as_str();
        while rest.len() > COLUMNS {
            // Behind the last comma that leaves room for the $.
            let front = rest.get(..COLUMNS - 1).unwrap_or(rest);
            let Some(cut) = front.rfind(',') else {
                break;
            };
            let (head, tail) = rest.split_at(cut + 1);
            writeln!(self.to, "{head}$")?;
            rest = tail;
        }
        writeln!(self.to, "{rest}")?;
        Ok(())
    }

    fn line(&mut self, text: &str) -> Result<(), ClWriteError> {
        writeln!(self.to, "{text}")?;
        Ok(())
    }

    /// PPRINT, on as many statements as it needs.
    fn comment(&mut self, text: &str) -> Result<(), ClWriteError> {
        let text = clean(text, usize::MAX);
        // Apostrophes around all of it are taken off when it is read.
        let quoted = text.len() > 1 && text.starts_with('\'') && text.ends_with('\'');
        let text = match quoted {
            true => format!("'{text}'"),
            false => text,
        };
        let mut rest = text.as_str();
        while rest.len() > COMMENT {
            let front = rest.get(..=COMMENT).unwrap_or(rest);
            let cut = front.rfind(' ').filter(|c| *c > 0).unwrap_or(COMMENT);
            let (head, tail) = rest.split_at(cut);
            self.line(&format!("PPRINT/{}", head.trim_end()))?;
            rest = tail.trim_start();
        }
        self.line(&format!("PPRINT/{rest}"))
    }
}

/// Printable ASCII without blanks at its ends, at most so many characters.
fn clean(text: &str, most: usize) -> String {
    let plain = |c: char| match c {
        ' '..='~' => c,
        c if c.is_control() => ' ',
        _ => '?',
    };
    let text: String = text.trim().chars().map(plain).take(most).collect();
    text.trim().to_string()
}

fn above_zero(what: &'static str, value: f64) -> Result<String, ClWriteError> {
    if value <= 0.0 {
        return Err(ClWriteError::Number { what, value });
    }
    number(what, value)
}

/// The shortest text that reads back to the same number: with a dot, so that no reader takes it for a whole one, and in powers of ten
/// where it would be long.
fn number(what: &'static str, value: f64) -> Result<String, ClWriteError> {
    // What no machine does is not read back either.
    if !(-MOST..=MOST).contains(&value) {
        return Err(ClWriteError::Number { what, value });
    }
    // "1.5", "10.0", "1e-7", "-0.0".
    let text = format!("{value:?}");
    Ok(match text.split_once('e') {
        None => text,
        Some((m, e)) if m.contains('.') => format!("{m}E{e}"),
        Some((m, e)) => format!("{m}.0E{e}"),
    })
}
