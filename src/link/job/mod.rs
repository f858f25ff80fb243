//! A vetted program: what is known of it as a whole, and how to read it again while it is sent.
//!
//! Crosses the border: a [`JobSource`] in; one [`JobLine`] after the other out ([`JobLines`]). Constant memory, whatever the program's
//! length: the lines are not kept but read twice, once to vet and once to send, and a digest per few hundred lines proves before
//! any of them is sent that they are still what was vetted. Coordinates are work coordinates, mm. It names no files and
//! never touches a port.

mod line;
mod reader;

pub use line::{JobLine, Standstill, Weight};
pub(super) use reader::{Chunks, Digest};
pub use reader::{JobLines, Unreadable};

use super::vet::{self, JobError, VetOptions, Warning};
pub use crate::gcode::source::TextReader as JobReader;
use crate::gcode::{Event, State};
use std::io::{self, Cursor};
use std::sync::Arc;

/// A program that can be opened again and again: a text in memory, or a closure that opens a file.
///
/// ```
/// use morsemill::link::{JobReader, JobSource};
/// let file = || std::fs::File::open("part.nc").map(|f| Box::new(std::io::BufReader::new(f)) as Box<dyn JobReader>);
/// let _: &dyn JobSource = &file;
/// ```
pub trait JobSource: Send + Sync {
    /// The program from its beginning.
    ///
    /// # Errors
    /// What opening it answers.
    fn open(&self) -> io::Result<Box<dyn JobReader>>;
}

impl<F: Fn() -> io::Result<Box<dyn JobReader>> + Send + Sync> JobSource for F {
    fn open(&self) -> io::Result<Box<dyn JobReader>> {
        self()
    }
}

/// A program in memory.
#[derive(Clone, Debug)]
pub struct Text(pub Arc<str>);

impl JobSource for Text {
    fn open(&self) -> io::Result<Box<dyn JobReader>> {
        Ok(Box::new(Cursor::new(TextBytes(self.0.clone()))))
    }
}

/// The bytes of a shared text.
struct TextBytes(Arc<str>);

impl AsRef<[u8]> for TextBytes {
    fn as_ref(&self) -> &[u8] {
        self.0.as_bytes()
    }
}

/// A program proven fit to be streamed, without its lines.
#[derive(Clone)]
pub struct Job {
    /// Where its lines are read from.
    pub source: Arc<dyn JobSource>,
    /// How it was vetted: the lines are read the same way when they are sent.
    pub options: VetOptions,
    /// Lines sent before the program's own (see [`VetOptions::entry`]).
    pub entry: Vec<JobLine>,
    /// Lines to send of the program; empty and comment lines are left out, and so is the entry.
    pub total: usize,
    /// Bytes of these lines, line ends included.
    pub bytes: u64,
    /// Lines of the program's text.
    pub source_lines: usize,
    /// Where the program ends in work coordinates, mm, as far as the text alone can tell: `None` for an axis that is never
    /// moved, or whose place depends on offsets, machine coordinates or probing.
    pub end: [Option<f64>; 3],
    /// What the controller remembers at the end.
    pub end_state: State,
    /// What the operator should know before the first byte.
    pub warnings: Vec<Warning>,
    /// SHA-256 over the digests of its parts: the same text, vetted from the same line, has the same.
    pub digest: [u8; 32],
    pub(super) parts: Arc<[Digest]>,
}

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Job")
            .field("total", &self.total)
            .field("source_lines", &self.source_lines)
            .field("end", &self.end)
            .finish_non_exhaustive()
    }
}

impl Job {
    /// Vets a program in memory for stock GRBL 1.1 whose offsets and travel are not known.
    ///
    /// # Errors
    /// Every line that cannot be sent, up to [`vet::MAX_ERRORS`], in order.
    pub fn vet(text: &str) -> Result<Job, Vec<JobError>> {
        let source = Arc::new(Text(text.into()));
        vet::vet(source, VetOptions::default(), &mut |_, _| {})
    }

    /// What the program tells the machine, all of it in memory: for times of programs that fit there.
    ///
    /// # Errors
    /// As [`vet::vet`].
    pub fn events(&self) -> Result<Vec<Event>, Vec<JobError>> {
        let mut events = Vec::new();
        vet::vet(
            self.source.clone(),
            self.options.clone(),
            &mut |_, event| {
                events.push(event.clone());
            },
        )?;
        Ok(events)
    }

    /// Its lines again, from the first.
    ///
    /// # Errors
    /// It cannot be opened any more.
    pub fn lines(&self) -> Result<JobLines, Unreadable> {
        JobLines::new(self)
    }
}
