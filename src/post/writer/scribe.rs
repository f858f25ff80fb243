//! Adapted steps to lines, and what the machine will remember of them.

use super::page::{Kind, Page};
use crate::cldata::{Bow, Coolant, Place, Step};
use crate::geom::{Plane, Point};
use crate::post::definition::{Post, Spelling, Units};
use crate::post::error::Refusal;
use crate::post::number;
use crate::post::options::Options;
use crate::post::template::{Piece, Slot, Template};
use crate::units::{Rpm, Seconds};
use std::io::Write;

/// How much of the program's head is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Head {
    Nothing,
    /// Up to the place where comments go.
    Comments,
    All,
    /// The end is written, too.
    Over,
}

/// Writes steps.
pub(super) struct Scribe<'a, W> {
    pub post: &'a Post,
    pub page: Page<'a, W>,
    /// Line of the last motion, from 1.
    pub last_motion: usize,
    /// Where each axis is, in units of the last decimal; `None` until told.
    pub at: [Option<i64>; 3],
    /// The same before rounding, mm.
    pub exact: Place,
    /// 0 to 3 after a motion.
    pub motion: Option<u8>,
    /// The last F, in units of its last decimal.
    pub feed: Option<i64>,
    pub plane: Option<Plane>,
    /// Heidenhain's circle centre.
    pub pole: Option<[i64; 2]>,
    /// Heidenhain: where in the plane a helix by its angle has left the tool, in units of the last decimal, until a line says the place.
    pub adrift: Option<[f64; 2]>,
    /// Length compensation waits for a rapid that names Z.
    pub length_waits: bool,
    pub decimals: u8,
    pub feed_decimals: u8,
    pub rapid_feed: Option<i64>,
    pub units: Units,
    head: Head,
    pub tool: Option<u32>,
    pub tolerance: Option<i64>,
    pub name: String,
    pub number: u32,
    split_comments: bool,
}

impl<'a, W: Write> Scribe<'a, W> {
    pub fn new(post: &'a Post, options: &Options, out: W) -> Result<Self, Refusal> {
        let units = options.units.unwrap_or(post.units);
        if post.unit_word(units).is_none() {
            return Err(Refusal::NoUnits(match units {
                Units::Mm => "millimetres",
                Units::Inch => "inches",
            }));
        }
        let name = options.name.clone().unwrap_or_else(|| "MORSEMILL".into());
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if !(1..=24).contains(&name.len()) || !name.chars().all(plain) {
            return Err(Refusal::Name(name));
        }
        let [least, most] = post.program.number;
        let number = options.number.unwrap_or(1001.clamp(least, most.max(least)));
        if !(least..=most).contains(&number) {
            return Err(Refusal::Number {
                number,
                least,
                most,
            });
        }
        let decimals = post.decimals.coordinate(units);
        let feed_decimals = post.decimals.feed(units);
        let tolerance = options.path_tolerance.or(post.path_tolerance);
        let tolerance = tolerance
            .map(|t| figure("the path tolerance in mm", t.0, t.0 / units.mm(), decimals))
            .transpose()?;
        let rapid_feed = post
            .rapid_feed
            .map(|f| {
                figure(
                    "the feed of rapids in mm/min",
                    f.0,
                    f.0 / units.mm(),
                    feed_decimals,
                )
            })
            .transpose()?;
        let says = |g| {
            let words = post.program.start.iter().flat_map(Template::words);
            words
                .into_iter()
                .any(|(l, n)| l == 'G' && n.parse() == Ok(g))
        };
        Ok(Scribe {
            post,
            page: Page::new(post, out),
            last_motion: 0,
            at: [None; 3],
            exact: [None; 3],
            motion: None,
            feed: None,
            // Where there is but one plane no word chooses it.
            plane: (says(17.0) || post.arcs.planes == [true, false, false]).then_some(Plane::Xy),
            pole: None,
            adrift: None,
            length_waits: false,
            decimals,
            feed_decimals,
            rapid_feed,
            units,
            head: Head::Nothing,
            tool: None,
            tolerance,
            name,
            number,
            split_comments: options.rewrite.comments,
        })
    }

    /// True once the end is written.
    pub fn over(&self) -> bool {
        self.head == Head::Over
    }

    /// Writes one step.
    pub fn step(&mut self, step: &Step) -> Result<(), Refusal> {
        if self.over() {
            return Err(Refusal::AfterEnd);
        }
        self.open(matches!(step, Step::Comment(_)))?;
        match step {
            Step::Comment(text) => self.comment(text),
            Step::Tool { number } => self.change(*number),
            Step::Spindle {
                direction,
                speed,
                spin_up,
            } => self.spindle(*direction, *speed, *spin_up),
            Step::Coolant(kind) => self.coolant(*kind),
            Step::Dwell(time) => self.dwell("the dwell in s", *time),
            Step::Pause { optional } => self.pause(*optional),
            Step::WorkOffset(number) => self.work_offset(*number),
            Step::Rapid { to } => self.rapid(to),
            Step::MachineRapid { to } => self.machine_rapid(to),
            Step::Feed { to, bow, feed } => self.cut(to, bow.as_ref(), feed.0),
            Step::End => self.end(),
        }
    }

    /// The head as far as it goes: comments have their place in it.
    fn open(&mut self, comment: bool) -> Result<(), Refusal> {
        if self.head == Head::All {
            return Ok(());
        }
        let post = self.post;
        let start = &post.program.start;
        let place = start.iter().position(|t| t.has(Slot::Comments));
        if self.head == Head::Nothing {
            self.each(&post.program.first, Kind::Bare)?;
            self.each(
                start.get(..place.unwrap_or(0)).unwrap_or_default(),
                Kind::Words,
            )?;
            self.head = Head::Comments;
        }
        // Without a place of their own they come after the head.
        if self.head == Head::Comments && !(comment && place.is_some()) {
            let rest = place.map_or(0, |p| p + 1);
            self.each(start.get(rest..).unwrap_or_default(), Kind::Words)?;
            self.head = Head::All;
        }
        Ok(())
    }

    fn comment(&mut self, text: &str) -> Result<(), Refusal> {
        let longest = self.post.longest_comment;
        // Room for a line number.
        let longest = match self.post.number_step {
            0 => longest,
            _ => longest.min(self.post.longest.saturating_sub(10)),
        };
        let lines = self.post.comments.lines(text, longest);
        if lines.len() > text.lines().count().max(1) && !self.split_comments {
            return Err(Refusal::LongComment {
                length: text.chars().count(),
                longest,
            });
        }
        for line in lines {
            self.page.begin(Kind::Comment);
            self.page.text(&line);
            self.page.end()?;
        }
        Ok(())
    }

    fn change(&mut self, number: u32) -> Result<(), Refusal> {
        let post = self.post;
        if number > post.tool.most {
            return Err(Refusal::NoTool {
                number,
                most: post.tool.most,
            });
        }
        let before = self.tool.replace(number);
        if post.tool.change.is_empty() {
            return match before.filter(|inside| *inside != number) {
                None => Ok(()),
                Some(inside) => Err(Refusal::NoToolChange {
                    inside,
                    wanted: number,
                }),
            };
        }
        self.flat()?;
        let mut kind = Kind::Tool;
        for line in &post.tool.change {
            self.template(line, kind, 0)?;
            kind = Kind::Words;
        }
        (self.at, self.exact) = ([None; 3], [None; 3]);
        self.feed = None;
        self.length_waits = false;
        match &post.tool.length {
            Some(t) if t.has(Slot::Axes) => self.length_waits = true,
            Some(t) => self.template(t, Kind::Words, 0)?,
            None => {}
        }
        Ok(())
    }

    fn spindle(&mut self, direction: i8, speed: Rpm, spin_up: Seconds) -> Result<(), Refusal> {
        let post = self.post;
        let (lines, name) = match direction {
            0 => return self.each(&post.spindle.off, Kind::Words),
            1 => (&post.spindle.cw, "clockwise"),
            -1 => (&post.spindle.ccw, "counter-clockwise"),
            other => return Err(Refusal::Direction(other)),
        };
        if lines.is_empty() {
            return Err(Refusal::NoSpindle(name));
        }
        let speed = figure(
            "the spindle speed in rpm",
            speed.0,
            speed.0,
            post.decimals.speed,
        )?;
        for line in lines {
            self.template(line, Kind::Words, speed)?;
        }
        match spin_up.0 == 0.0 {
            true => Ok(()),
            false => self.dwell("the spin-up time in s", spin_up),
        }
    }

    fn coolant(&mut self, kind: Coolant) -> Result<(), Refusal> {
        let lines = &self.post.coolant;
        let lines = match kind {
            // Where there is none, it is off.
            Coolant::Off => return self.each(&lines.off, Kind::Words),
            Coolant::Flood => &lines.flood,
            Coolant::Mist => &lines.mist,
            Coolant::Both => &lines.both,
        };
        match lines.is_empty() {
            true => Err(Refusal::NoCoolant(kind)),
            false => self.each(lines, Kind::Words),
        }
    }

    fn dwell(&mut self, what: &'static str, time: Seconds) -> Result<(), Refusal> {
        let lines = &self.post.dwell;
        if time.0 == 0.0 {
            return Ok(());
        }
        if lines.is_empty() {
            return Err(Refusal::Cannot {
                what: "dwell",
                remedy: "set its time to zero, or write its line into dwell if yours has one",
            });
        }
        let ms = lines.iter().any(|t| t.has(Slot::Milliseconds));
        let (value, decimals) = match ms {
            true => (time.0 * 1000.0, 0),
            false => (time.0, self.post.decimals.seconds),
        };
        let count = figure(what, time.0, value, decimals)?;
        lines
            .iter()
            .try_for_each(|line| self.template(line, Kind::Words, count))
    }

    fn pause(&mut self, optional: bool) -> Result<(), Refusal> {
        let (lines, what) = match optional {
            false => (&self.post.pause, "pause"),
            true => (&self.post.optional_pause, "optional pause"),
        };
        match lines.is_empty() {
            true => Err(Refusal::Cannot {
                what,
                remedy: "take it out, or write its line into the post if yours has one",
            }),
            false => self.each(lines, Kind::Words),
        }
    }

    fn work_offset(&mut self, number: u16) -> Result<(), Refusal> {
        let post = self.post;
        let offsets = &post.work_offsets;
        let none = || Refusal::NoWorkOffset {
            number,
            most: offsets.most,
        };
        let index = usize::from(number).checked_sub(1).ok_or_else(none)?;
        match offsets.words.get(index) {
            Some(line) => self.template(line, Kind::Words, 0)?,
            None if number > offsets.most => return Err(none()),
            None => {
                let line = offsets.further.as_ref().ok_or_else(none)?;
                let further = index - offsets.words.len() + 1;
                self.template(line, Kind::Words, further as i64)?;
            }
        }
        (self.at, self.exact) = ([None; 3], [None; 3]);
        Ok(())
    }

    fn rapid(&mut self, to: &Place) -> Result<(), Refusal> {
        let counts = self.place(to)?;
        match self.post.spelling {
            Spelling::Words => self.rapid_words(counts)?,
            Spelling::Heidenhain => self.line_block(counts, None)?,
        }
        for (exact, told) in self.exact.iter_mut().zip(to) {
            *exact = told.or(*exact);
        }
        Ok(())
    }

    fn machine_rapid(&mut self, to: &Place) -> Result<(), Refusal> {
        let post = self.post;
        if post.machine_rapid.is_empty() {
            return Err(Refusal::Cannot {
                what: "rapid in machine coordinates",
                remedy: "go to a safe height in work coordinates instead",
            });
        }
        let counts = self.place(to)?;
        for line in &post.machine_rapid {
            self.page.begin(Kind::Words);
            for piece in &line.pieces {
                match piece {
                    Piece::Text(text) => self.page.text(text),
                    Piece::Slot(_) => self.axes(counts, false),
                }
            }
            self.page.end()?;
            if line.has(Slot::Axes) {
                self.last_motion = self.page.lines;
            }
        }
        self.motion = None;
        let known = self.at.iter_mut().zip(&mut self.exact);
        for ((at, exact), _) in known.zip(counts).filter(|(_, told)| told.is_some()) {
            (*at, *exact) = (None, None);
        }
        // Fanuc's G53 cancels length compensation: with the next Z it is said again, and until then nothing is known.
        if self.tool.is_some() && post.tool.length.as_ref().is_some_and(|t| t.has(Slot::Axes)) {
            self.length_waits = true;
            (self.at[2], self.exact[2]) = (None, None);
        }
        Ok(())
    }

    fn cut(&mut self, to: &Point, bow: Option<&Bow>, feed: f64) -> Result<(), Refusal> {
        for (axis, name) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if self.at[axis].is_none() {
                return Err(Refusal::Unknown(name));
            }
        }
        let counts = self.place(&[Some(to.x), Some(to.y), Some(to.z)])?;
        let count = figure(
            "its feed in mm/min",
            feed,
            feed / self.units.mm(),
            self.feed_decimals,
        )?;
        let circle = bow
            .map(|b| self.circle(b, to, counts))
            .transpose()?
            .flatten();
        match (circle, self.post.spelling) {
            (None, Spelling::Words) => self.feed_words(counts, count)?,
            (None, Spelling::Heidenhain) => self.line_block(counts, Some(count))?,
            (Some(c), Spelling::Words) => self.arc_words(&c, counts, count)?,
            (Some(c), Spelling::Heidenhain) => self.arc_blocks(&c, counts, count)?,
        }
        self.exact = [Some(to.x), Some(to.y), Some(to.z)];
        Ok(())
    }

    fn end(&mut self) -> Result<(), Refusal> {
        let post = self.post;
        self.flat()?;
        self.each(&post.program.end, Kind::Words)?;
        self.each(&post.program.last, Kind::Bare)?;
        self.head = Head::Over;
        Ok(())
    }

    /// Back to the table's plane: length compensation acts along the plane's normal.
    pub fn flat(&mut self) -> Result<(), Refusal> {
        match self.post.spelling == Spelling::Words && self.plane.is_some() {
            true => self.plane_line(Plane::Xy),
            false => Ok(()),
        }
    }

    /// A plane, if it is another: in a line of its own, since some firmwares read one command a line.
    pub fn plane_line(&mut self, plane: Plane) -> Result<(), Refusal> {
        if self.plane == Some(plane) {
            return Ok(());
        }
        self.page.begin(Kind::Words);
        self.page.word(match plane {
            Plane::Xy => "G17",
            Plane::Zx => "G18",
            Plane::Yz => "G19",
        });
        self.plane = Some(plane);
        self.page.end()
    }

    /// A place as written.
    fn place(&self, to: &Place) -> Result<[Option<i64>; 3], Refusal> {
        let mut counts = [None; 3];
        for ((count, value), axis) in counts.iter_mut().zip(to).zip(['X', 'Y', 'Z']) {
            *count = value.map(|v| self.length(axis, v)).transpose()?;
        }
        match counts {
            [None, None, None] => Err(Refusal::NoAxis),
            counts => Ok(counts),
        }
    }

    /// A coordinate as written.
    pub fn length(&self, axis: char, value: f64) -> Result<i64, Refusal> {
        number::round(value / self.units.mm(), self.decimals).ok_or(match value.is_finite() {
            true => Refusal::TooLarge { axis, value },
            false => Refusal::NotFinite { axis, value },
        })
    }
}

/// A figure above zero in units of its last decimal.
pub(super) fn figure(
    what: &'static str,
    told: f64,
    value: f64,
    decimals: u8,
) -> Result<i64, Refusal> {
    number::round(value, decimals)
        .filter(|count| *count > 0)
        .ok_or(Refusal::Figure {
            what,
            value: told,
            must: "above zero",
        })
}
