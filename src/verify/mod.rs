//! The witness: does the text say what we meant?
//!
//! ```text
//! steps  --- post --->  text  --- gcode --->  events
//!    |                                          |
//!    +---------------- Witness -----------------+
//! ```
//!
//! Crosses the border: the steps we wanted and the program made of them in; a [`Deviation`], or the first difference, out. `post`
//! wrote the text and `gcode` reads it; they never meet but here, so a mistake in one cannot be excused by the other.
//!
//! The program is read from a machine left in the worst modes (G91, G93, the other units, another plane and work offset, G1 at a
//! crawl, standing somewhere else), so what it does not set itself shows as a difference. Steps and text are streamed: nothing grows with
//! the program.

mod spelling;
mod witness;

pub use spelling::Spelling;
pub use witness::Witness;

use crate::cldata::{Job, Step, steps};
use crate::gcode::{Dialect, Interpreter, MotionMode, Reading, State};
use crate::geom::{Point, Vector};
use crate::post::{Adapter, Post, Posted, Refusal, Rewrite};
use crate::toolpath::Toolpath;
use crate::units::{Mm, MmPerMin, Rpm};
use std::io::Cursor;

/// How well the text agrees with the steps. All differences are within half a unit of the last decimal, or there is an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Steps that move.
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
    /// There is nothing to compare: the post cannot say a step at all, or the text cannot be read.
    #[error("{0}")]
    Refused(String),
    /// A post whose reader no interpreter is known for.
    #[error("post {post}: no interpreter is called \"{reader}\"")]
    NoReader {
        /// The post.
        post: String,
        /// Its reader.
        reader: String,
    },
}

impl From<Refusal> for VerifyError {
    fn from(refusal: Refusal) -> Self {
        VerifyError::Refused(refusal.to_string())
    }
}

/// The interpreter for programs of a post, or an error when it names none that we have.
pub fn dialect_of(post: &Post) -> Result<Dialect, VerifyError> {
    Dialect::from_name(&post.reader).ok_or_else(|| VerifyError::NoReader {
        post: post.name.clone(),
        reader: post.reader.clone(),
    })
}

/// Reads `posted` back and compares it, step by step, with what was meant: end points, arcs (centre and way round), rapid or feed, feeds, spindle, dwell,
/// coolant, path tolerance, order, the way up before and after, the program's end, and `posted.line_of_move`. Linear in the length of the program.
pub fn verify(
    posted: &Posted,
    toolpath: &Toolpath,
    job: &Job,
    post: &Post,
) -> Result<Deviation, VerifyError> {
    let text = Cursor::new(posted.text.as_bytes());
    let state = worst_state(dialect_of(post)?, post);
    let said = Interpreter::from_state(text, state, Reading::default())
        .map_err(|e| VerifyError::Refused(format!("the program cannot be read back: {e}")))?;
    let mut witness = Witness::new(said, Spelling::of(post));
    if toolpath.moves.is_empty() {
        return Err(witness.differs(
            1,
            "there are no moves, so there should be no program".into(),
        ));
    }
    if posted.line_of_move.len() != toolpath.moves.len() {
        let (m, l) = (toolpath.moves.len(), posted.line_of_move.len());
        let found = format!("the record of lines does not fit the moves: {m} moves and {l} lines");
        return Err(witness.differs(1, found));
    }
    let mut adapter = Adapter::new(post, Rewrite::default());
    for (index, step) in steps(toolpath, job) {
        let mut told = 0;
        adapter.step(&step, &mut |adapted| {
            told = witness.step(adapted)?;
            Ok::<(), VerifyError>(())
        })?;
        let recorded = index.and_then(|i| posted.line_of_move.get(i));
        if let (Some(i), Some(&recorded)) = (index, recorded)
            && recorded != told
        {
            let found = format!("move {i} is written here, and line {recorded} is recorded for it");
            return Err(witness.differs(told, found));
        }
        if matches!(step, Step::Feed { .. }) {
            witness.tolerance(job.path_tolerance.or(post.path_tolerance))?;
        }
    }
    witness.finish()
}

/// Everything a program must not rely on, set against it: each mode that the dialect has words for, by those words.
pub fn worst_state(dialect: Dialect, post: &Post) -> State {
    let units = match post.units {
        crate::post::Units::Mm => ["G20", "G70"],
        crate::post::Units::Inch => ["G21", "G71"],
    };
    let mut s = State::new(dialect);
    // What a dialect does not know, nobody can have left it in.
    for word in units.iter().chain(&["G19", "G55", "G91", "G93"]) {
        let text = Cursor::new(word.as_bytes());
        let Ok(mut said) = Interpreter::from_state(text, s.clone(), Reading::default()) else {
            continue;
        };
        if said.read_all(&mut Vec::new()).is_empty() {
            s = said.state().clone();
        }
    }
    s.motion = MotionMode::Linear;
    s.feed = MmPerMin(1.0);
    s.speed = Rpm(1.0);
    // So that no place in the work's coordinates is that place in the machine's.
    for (i, g5x) in s.g5x.iter_mut().enumerate() {
        let far = 1000.0 * (i as f64 + 1.0);
        *g5x = Vector::new(far + 0.25, far + 0.5, -far - 0.125);
    }
    s.position = Point::new(-1234.5, 2345.6, -3456.7);
    s
}

#[cfg(test)]
mod tests;
