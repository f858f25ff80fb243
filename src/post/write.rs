//! Moves to text, in one pass.
//!
//! ```text
//! start lines           modes, path tolerance, tool
//! G0 Z(safe)            straight up before anything else moves or turns
//! spindle, coolant
//! G0 X Y, then moves    section names as comments between them
//! G0 Z(safe)            unless the last move ended there or above
//! end lines             everything off
//! ```

use super::definition::Post;
use super::number;
use super::template::{Piece, Slot, Template};
use crate::cldata::{Coolant, Job};
use crate::geom::{Point, Point2};
use crate::toolpath::{MoveKind, Toolpath, Turn};
use crate::units::MmPerMin;

/// A program.
#[derive(Clone, Debug, PartialEq)]
pub struct Posted {
    /// The whole text, last line ended.
    pub text: String,
    /// For each move of the toolpath the line it caused, from 1: the last one if it caused several; the line before it if it
    /// rounds to nothing.
    pub line_of_move: Vec<usize>,
}

/// Why a program could not be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PostError {
    /// Nothing to write.
    #[error("the toolpath has no moves: there is nothing to cut")]
    Empty,
    /// A toolpath that starts in the material.
    #[error("move 0 is a {0:?}: a program must begin with a Rapid to the safe height")]
    FirstMove(MoveKind),
    /// A coordinate that is no number.
    #[error("move {index}: {axis} is {value}: the path is broken there, so no program was written")]
    NotFinite {
        /// Index into [`Toolpath::moves`].
        index: usize,
        /// X, Y or Z.
        axis: char,
        /// NaN or an infinity.
        value: f64,
    },
    /// A coordinate with more digits than controllers read.
    #[error(
        "move {index}: {axis} = {value} mm has more than {} digits as this dialect writes it: controllers read no more",
        number::MOST_DIGITS
    )]
    TooLarge {
        /// Index into [`Toolpath::moves`].
        index: usize,
        /// X, Y or Z.
        axis: char,
        /// The coordinate, mm.
        value: f64,
    },
    /// A safe height that is no height.
    #[error("the safe height is {0} mm, which cannot be written: set a height above the part")]
    SafeHeight(f64),
    /// A figure of the job that makes no sense, or that this dialect would write as zero.
    #[error(
        "{what} is {value}: it must be {must}, and large enough for the decimals of post {post}"
    )]
    Figure {
        /// The figure.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The rule.
        must: &'static str,
        /// Name of the dialect.
        post: String,
    },
    /// A feed of a move that is no feed, or that this dialect would write as zero.
    #[error(
        "move {index}: its feed is {value} mm/min: it must be above zero, and large enough for the decimals of post {post}"
    )]
    MoveFeed {
        /// Index into [`Toolpath::moves`].
        index: usize,
        /// The feed, mm/min.
        value: f64,
        /// Name of the dialect.
        post: String,
    },
    /// A coolant the dialect has no words for.
    #[error("post {post} has no {coolant:?} coolant: choose another, or none")]
    NoCoolant {
        /// What was asked for.
        coolant: Coolant,
        /// Name of the dialect.
        post: String,
    },
    /// An arc where the dialect has none.
    #[error(
        "move {index} is an arc and post {post} has none (arcs = false): make the path of straight lines only"
    )]
    NoArcs {
        /// Index into [`Toolpath::moves`].
        index: usize,
        /// Name of the dialect.
        post: String,
    },
    /// An arc that is no cut.
    #[error("move {index} is a {kind:?} along an arc: only a Cut or a Link may turn")]
    ArcKind {
        /// Index into [`Toolpath::moves`].
        index: usize,
        /// Its kind.
        kind: MoveKind,
    },
    /// An arc that is not one any more when its ends and centre are written with so few decimals.
    #[error(
        "move {index}: the arc about X{} Y{} cannot be written with {decimals} decimals: {problem}", center[0], center[1]
    )]
    ArcRounding {
        /// Index into [`Toolpath::moves`].
        index: usize,
        /// Its centre, mm.
        center: [f64; 2],
        /// Decimals of a coordinate.
        decimals: u8,
        /// What goes wrong.
        problem: &'static str,
    },
    /// A line longer than the dialect allows.
    #[error("line {line} has {length} characters and post {post} allows {longest}: {text}")]
    LineTooLong {
        /// Line of the program, from 1.
        line: usize,
        /// Its length.
        length: usize,
        /// Name of the dialect.
        post: String,
        /// What is allowed.
        longest: usize,
        /// The line.
        text: String,
    },
}

/// Writes a program. Deterministic: the same input gives the same bytes. Linear in the number of moves, one string.
pub fn write(toolpath: &Toolpath, job: &Job, post: &Post) -> Result<Posted, PostError> {
    let first = toolpath.moves.first().ok_or(PostError::Empty)?;
    if first.kind != MoveKind::Rapid {
        return Err(PostError::FirstMove(first.kind));
    }
    let mut pen = Pen::new(toolpath, job, post)?;
    let safe_z = pen
        .height(toolpath.safe_z)
        .ok_or(PostError::SafeHeight(toolpath.safe_z))?;

    for template in &post.start {
        pen.template(template, job)?;
    }
    // Up before anything else. A first target above the safe height is reached at once, so that Z moves only upwards in the open.
    let start = pen.target(0, toolpath)?;
    let up = safe_z.max(start[2]);
    pen.motion(Word::Rapid, [None, None, Some(up)])?;
    if job.speed.0 > 0.0 {
        for template in &post.spindle {
            pen.template(template, job)?;
        }
    }
    let coolant: &[Template] = match job.coolant {
        Coolant::Off => &[],
        Coolant::Flood => &post.flood,
        Coolant::Mist => &post.mist,
    };
    if coolant.is_empty() && job.coolant != Coolant::Off {
        return Err(PostError::NoCoolant {
            coolant: job.coolant,
            post: post.name.clone(),
        });
    }
    for template in coolant {
        pen.template(template, job)?;
    }

    let mut line_of_move = Vec::with_capacity(toolpath.moves.len());
    let mut sections = toolpath.sections.iter().peekable();
    for (i, m) in toolpath.moves.iter().enumerate() {
        while let Some(section) = sections.next_if(|s| s.first_move <= i) {
            pen.comment(&section.name)?;
        }
        let to = pen.target(i, toolpath)?;
        if i == 0 {
            pen.motion(Word::Rapid, [Some(to[0]), Some(to[1]), None])?;
        }
        let word = match m.kind {
            MoveKind::Rapid | MoveKind::Retract => Word::Rapid,
            MoveKind::Plunge => Word::Feed(pen.plunge_feed),
            MoveKind::Cut | MoveKind::Link => Word::Feed(pen.feed_of(i, m.feed)?),
        };
        let bow = match (&m.turn, m.kind) {
            (None, _) => None,
            (Some(turn), MoveKind::Cut | MoveKind::Link) if i > 0 => {
                pen.bow(i, turn, to, toolpath)?
            }
            (Some(_), kind) => return Err(PostError::ArcKind { index: i, kind }),
        };
        match (bow, word) {
            (Some(bow), Word::Feed(feed)) => pen.arc(&bow, to, feed)?,
            _ => pen.motion(word, to.map(Some))?,
        }
        line_of_move.push(pen.last_motion_line);
    }
    if pen.at[2].is_none_or(|z| z < safe_z) {
        pen.motion(Word::Rapid, [None, None, Some(safe_z)])?;
    }
    for template in &post.end {
        pen.template(template, job)?;
    }
    Ok(Posted {
        text: pen.out,
        line_of_move,
    })
}

/// How a motion is spelled.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Word {
    /// G0.
    Rapid,
    /// G1 or an arc, at this feed in units of its last decimal.
    Feed(i64),
}

/// An arc as it is written.
struct Bow {
    clockwise: bool,
    /// I and J: from the start to the centre, in units of the last decimal.
    offset: [i64; 2],
}

/// Radii of start and end that differ by more than this, mm, are not written: LinuxCNC takes 1.27 um or 0.1 %, GRBL 5 um.
const RADII_DIFFER: f64 = 0.0012;

/// The text so far and what the machine will remember of it.
struct Pen<'a> {
    post: &'a Post,
    out: String,
    /// Lines ended so far.
    lines: usize,
    /// Line of the last motion, from 1.
    last_motion_line: usize,
    /// N word of the next line.
    number: u32,
    /// Where each axis is, in units of the last decimal; `None` until told.
    at: [Option<i64>; 3],
    /// 0 to 3 after a motion.
    motion: Option<u8>,
    /// The last F, in units of its last decimal.
    feed: Option<i64>,
    plunge_feed: i64,
    cut_feed: i64,
    speed: i64,
    spin_up: i64,
    tolerance: Option<i64>,
    per_unit: f64,
    decimals: u8,
}

impl<'a> Pen<'a> {
    fn new(toolpath: &Toolpath, job: &Job, post: &'a Post) -> Result<Self, PostError> {
        let figure = |what, value: f64, decimals, zero_too: bool| {
            let count =
                number::round(value, decimals).filter(|c| *c > 0 || (zero_too && value == 0.0));
            count.ok_or_else(|| PostError::Figure {
                what,
                value,
                must: if zero_too {
                    "zero or above"
                } else {
                    "above zero"
                },
                post: post.name.clone(),
            })
        };
        let per_unit = post.units.mm();
        let feed_decimals = post.feed_decimals();
        let tolerance = match job.path_tolerance.or(post.path_tolerance) {
            Some(t) => Some(figure(
                "the path tolerance in mm",
                t.0 / per_unit,
                post.coordinate_decimals(),
                false,
            )?),
            None => None,
        };
        Ok(Pen {
            post,
            out: String::with_capacity(1024 + 26 * toolpath.moves.len()),
            lines: 0,
            last_motion_line: 0,
            number: post.number_step,
            at: [None; 3],
            motion: None,
            feed: None,
            plunge_feed: figure(
                "the plunge feed in mm/min",
                job.plunge.0 / per_unit,
                feed_decimals,
                false,
            )?,
            cut_feed: figure(
                "the feed in mm/min",
                job.feed.0 / per_unit,
                feed_decimals,
                false,
            )?,
            speed: figure(
                "the spindle speed in rpm",
                job.speed.0,
                post.decimals.speed,
                true,
            )?,
            spin_up: figure(
                "the spin-up time in s",
                job.spin_up.0,
                post.decimals.seconds,
                true,
            )?,
            tolerance,
            per_unit,
            decimals: post.coordinate_decimals(),
        })
    }

    /// The feed of a cut or link: the job's, or the move's own where that is lower.
    fn feed_of(&self, index: usize, own: Option<MmPerMin>) -> Result<i64, PostError> {
        let Some(own) = own else {
            return Ok(self.cut_feed);
        };
        number::round(own.0 / self.per_unit, self.post.feed_decimals())
            .filter(|count| *count > 0)
            .map(|count| count.min(self.cut_feed))
            .ok_or_else(|| PostError::MoveFeed {
                index,
                value: own.0,
                post: self.post.name.clone(),
            })
    }

    /// A height as written, or `None` when it cannot be.
    fn height(&self, mm: f64) -> Option<i64> {
        number::round(mm / self.per_unit, self.decimals)
    }

    /// Where a move goes, as written.
    fn target(&self, index: usize, toolpath: &Toolpath) -> Result<[i64; 3], PostError> {
        let to = toolpath.moves.get(index).ok_or(PostError::Empty)?.to;
        let mut counts = [0; 3];
        for ((count, value), axis) in counts
            .iter_mut()
            .zip([to.x, to.y, to.z])
            .zip(['X', 'Y', 'Z'])
        {
            *count = match number::round(value / self.per_unit, self.decimals) {
                Some(c) => c,
                None if value.is_finite() => {
                    return Err(PostError::TooLarge { index, axis, value });
                }
                None => return Err(PostError::NotFinite { index, axis, value }),
            };
        }
        Ok(counts)
    }

    /// An arc as it is written; `None` where it rounds to less than a unit of the last decimal and a straight line says the same.
    fn bow(
        &self,
        index: usize,
        turn: &Turn,
        to: [i64; 3],
        toolpath: &Toolpath,
    ) -> Result<Option<Bow>, PostError> {
        if !self.post.arcs {
            let post = self.post.name.clone();
            return Err(PostError::NoArcs { index, post });
        }
        let refuse = |problem| PostError::ArcRounding {
            index,
            center: [turn.center.x, turn.center.y],
            decimals: self.decimals,
            problem,
        };
        let mut center = [0; 2];
        for ((count, value), axis) in center
            .iter_mut()
            .zip([turn.center.x, turn.center.y])
            .zip(['X', 'Y'])
        {
            *count = match number::round(value / self.per_unit, self.decimals) {
                Some(c) => c,
                None if value.is_finite() => {
                    return Err(PostError::TooLarge { index, axis, value });
                }
                None => return Err(PostError::NotFinite { index, axis, value }),
            };
        }
        let (Some(x), Some(y), Some(before)) = (
            self.at[0],
            self.at[1],
            index.checked_sub(1).and_then(|k| toolpath.moves.get(k)),
        ) else {
            return Err(refuse("it has no start"));
        };
        let meant = match toolpath.moves.get(index) {
            Some(m) => turn.sweep(&before.to, &m.to),
            None => 0.0,
        };
        if [x, y] == [to[0], to[1]] && meant.abs() < std::f64::consts::PI {
            return Ok(None);
        }
        let offset = [center[0] - x, center[1] - y];
        let unit = self.per_unit * 0.1_f64.powi(i32::from(self.decimals));
        let spoke = |x: i64, y: i64| {
            let (u, v) = (x - center[0], y - center[1]);
            Point2::new(u as f64 * unit, v as f64 * unit)
        };
        let (start, end) = (spoke(x, y), spoke(to[0], to[1]));
        let (rs, re) = (start.coords.norm(), end.coords.norm());
        if rs == 0.0 || re == 0.0 {
            return Err(refuse("its radius becomes zero"));
        }
        if (rs - re).abs() > RADII_DIFFER.max(0.001 * rs.min(re)) {
            return Err(refuse("the radii at its start and end differ"));
        }
        let written = Turn {
            center: Point2::origin(),
            clockwise: turn.clockwise,
        };
        let flat = |p: Point2| Point::new(p.x, p.y, 0.0);
        if (written.sweep(&flat(start), &flat(end)) - meant).abs() > std::f64::consts::PI {
            return Err(refuse(
                "a sliver of it becomes a whole turn, or the other way round",
            ));
        }
        Ok(Some(Bow {
            clockwise: turn.clockwise,
            offset,
        }))
    }

    /// A cut along an arc. X and Y are always said: a controller takes an arc without them for a mistake.
    fn arc(&mut self, bow: &Bow, to: [i64; 3], feed: i64) -> Result<(), PostError> {
        let start = self.begin_line();
        let g = if bow.clockwise { 2 } else { 3 };
        if !self.post.modal.motion || self.motion != Some(g) {
            self.out.push_str(if g == 2 { "G2" } else { "G3" });
            self.motion = Some(g);
        }
        let still = self.post.modal.axes && self.at[2] == Some(to[2]);
        let words = [
            ('X', Some(to[0])),
            ('Y', Some(to[1])),
            ('Z', (!still).then_some(to[2])),
            ('I', Some(bow.offset[0]).filter(|c| *c != 0)),
            ('J', Some(bow.offset[1]).filter(|c| *c != 0)),
        ];
        for (letter, count) in words {
            let Some(count) = count else { continue };
            self.gap(start);
            self.out.push(letter);
            number::push(&mut self.out, count, self.decimals);
        }
        self.at = to.map(Some);
        self.feed_word(Some(feed), start);
        self.end_line(start)?;
        self.last_motion_line = self.lines;
        Ok(())
    }

    /// The F word, if it is not what it was.
    fn feed_word(&mut self, feed: Option<i64>, start: usize) {
        if let Some(feed) = feed.filter(|f| !self.post.modal.feed || self.feed != Some(*f)) {
            self.gap(start);
            self.out.push('F');
            number::push(&mut self.out, feed, self.post.feed_decimals());
            self.feed = Some(feed);
        }
    }

    /// A motion to where it is told; axes that are `None` stay. Writes nothing when nothing would move.
    fn motion(&mut self, word: Word, to: [Option<i64>; 3]) -> Result<(), PostError> {
        let moves = |axis: usize| to[axis].is_some() && to[axis] != self.at[axis];
        if !(moves(0) || moves(1) || moves(2)) {
            return Ok(());
        }
        let start = self.begin_line();
        let (g, feed) = match word {
            Word::Rapid => (0, None),
            Word::Feed(feed) => (1, Some(feed)),
        };
        if !self.post.modal.motion || self.motion != Some(g) {
            self.out.push_str(if g == 0 { "G0" } else { "G1" });
            self.motion = Some(g);
        }
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            let Some(count) = to[axis] else { continue };
            if self.post.modal.axes && self.at[axis] == Some(count) {
                continue;
            }
            self.gap(start);
            self.out.push(letter);
            number::push(&mut self.out, count, self.decimals);
            self.at[axis] = Some(count);
        }
        self.feed_word(feed, start);
        self.end_line(start)?;
        self.last_motion_line = self.lines;
        Ok(())
    }

    /// A template line, left out when one of its slots has nothing to say.
    fn template(&mut self, template: &Template, job: &Job) -> Result<(), PostError> {
        if template.has(Slot::Comments) {
            return job.header.iter().try_for_each(|line| self.comment(line));
        }
        if template.has(Slot::SpinUp) && self.spin_up == 0
            || template.has(Slot::Tolerance) && self.tolerance.is_none()
        {
            return Ok(());
        }
        let start = self.begin_line();
        for piece in &template.pieces {
            match piece {
                Piece::Text(text) => self.out.push_str(text),
                Piece::Slot(Slot::Comments) => {}
                Piece::Slot(Slot::Units) => self.out.push_str(self.post.units.word()),
                Piece::Slot(Slot::Tool) => {
                    number::push(&mut self.out, i64::from(job.tool_number), 0)
                }
                Piece::Slot(Slot::Speed) => {
                    number::push(&mut self.out, self.speed, self.post.decimals.speed)
                }
                Piece::Slot(Slot::SpinUp) => {
                    number::push(&mut self.out, self.spin_up, self.post.decimals.seconds)
                }
                Piece::Slot(Slot::Tolerance) => {
                    number::push(&mut self.out, self.tolerance.unwrap_or(0), self.decimals)
                }
            }
        }
        // Whatever a template does to the motion mode (G80), the next motion says its own.
        self.motion = None;
        self.end_line(start)
    }

    /// Free text as comment lines.
    fn comment(&mut self, text: &str) -> Result<(), PostError> {
        for line in self.post.comments.lines(text, self.post.longest) {
            let start = self.out.len();
            self.out.push_str(&line);
            self.end_line(start)?;
        }
        Ok(())
    }

    /// Starts a line with its number, if the dialect has them. Returns where the words begin.
    fn begin_line(&mut self) -> usize {
        if self.post.number_step > 0 {
            self.out.push('N');
            number::push(&mut self.out, i64::from(self.number), 0);
            self.out.push(' ');
            self.number += self.post.number_step;
            // GRBL refuses numbers above ten million; starting over is legal everywhere.
            if self.number > 9_999_999 {
                self.number = self.post.number_step;
            }
        }
        self.out.len()
    }

    fn gap(&mut self, start: usize) {
        if self.out.len() > start {
            self.out.push(' ');
        }
    }

    /// Ends the line whose words began at `start`.
    fn end_line(&mut self, start: usize) -> Result<(), PostError> {
        self.lines += 1;
        let begin = self.out[..start].rfind('\n').map_or(0, |i| i + 1);
        let length = self.out.len() - begin;
        if length > self.post.longest {
            return Err(PostError::LineTooLong {
                line: self.lines,
                length,
                post: self.post.name.clone(),
                longest: self.post.longest,
                text: self.out[begin..].to_string(),
            });
        }
        self.out.push_str(self.post.line_end);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
