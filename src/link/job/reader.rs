//! The program read by parts, each with its digest; and, for sending, each proven unchanged before its first line is let out.

use super::{Job, JobLine, JobReader};
use crate::gcode::source::Source;
use crate::gcode::{Event, State};
use crate::geom::{Point, Vector};
use crate::link::vet::{JobError, Preparer};
use sha2::{Digest as _, Sha256};
use std::collections::VecDeque;
use std::sync::Arc;

/// A part ends after so many lines...
const PART_LINES: usize = 256;
/// ... or so many bytes. A single line is at most 1 MiB (see [`crate::gcode::source`]), so a part is bounded too.
const PART_BYTES: usize = 1 << 16;

/// Half of a part's SHA-256: 16 bytes for some 10 kB of program.
pub(in crate::link) type Digest = [u8; 16];

/// The program by parts.
pub(in crate::link) struct Chunks {
    source: Source<Box<dyn JobReader>>,
    /// Lines of the part read last, with their numbers from 1.
    pub lines: VecDeque<(usize, String)>,
    /// Lines of the text read so far.
    pub read: usize,
}

impl Chunks {
    /// Begins with line `first` of the text (from 1).
    pub fn new(from: Box<dyn JobReader>, first: usize) -> std::io::Result<Chunks> {
        let mut source = Source::new(from)?;
        let mut read = 0;
        while read + 1 < first && source.read()?.is_some() {
            read += 1;
        }
        Ok(Chunks {
            source,
            lines: VecDeque::new(),
            read,
        })
    }

    /// Reads the next part into `lines`; its digest, or `None` behind the last.
    pub fn next(&mut self) -> std::io::Result<Option<Digest>> {
        self.lines.clear();
        let (mut hash, mut bytes) = (Sha256::new(), 0);
        while self.lines.len() < PART_LINES && bytes < PART_BYTES {
            let Some((number, text)) = self.source.read()? else {
                break;
            };
            hash.update(text.as_bytes());
            hash.update(b"\n");
            bytes += text.len() + 1;
            self.lines.push_back((number, text.to_string()));
            self.read = number;
        }
        if self.lines.is_empty() {
            return Ok(None);
        }
        let mut digest = Digest::default();
        for (to, from) in digest.iter_mut().zip(hash.finalize()) {
            *to = from;
        }
        Ok(Some(digest))
    }
}

/// Why the program cannot be read on while it is sent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unreadable {
    /// It is not what was vetted.
    #[error(
        "the program changed after it was checked, at or behind line {line}: nothing of the change was sent. Check it again and start over"
    )]
    Changed {
        /// First line of the part that differs.
        line: usize,
    },
    /// Reading failed.
    #[error("the program cannot be read on: {0}")]
    Failed(String),
    /// Behind a probe or a tool change the machine stands elsewhere than the check could know, and from there the line cannot be run.
    #[error("as the machine stands now, line {0}")]
    Impossible(Box<JobError>),
}

/// The lines of a vetted job, one after the other.
pub struct JobLines {
    chunks: Chunks,
    preparer: Preparer,
    parts: Arc<[Digest]>,
    part: usize,
}

impl std::fmt::Debug for JobLines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("JobLines")
            .field("part", &self.part)
            .finish_non_exhaustive()
    }
}

impl JobLines {
    pub(super) fn new(job: &Job) -> Result<JobLines, Unreadable> {
        let failed = |e: std::io::Error| Unreadable::Failed(e.to_string());
        let from = job.source.open().map_err(failed)?;
        let mut preparer = Preparer::new(&job.options);
        // The entry was vetted; carried out again it brings the preparer to where the program begins.
        for text in &job.options.entry {
            let line = preparer.prepare(text, 0, &mut |_| {});
            line.map_err(|e| Unreadable::Impossible(Box::new(e)))?;
        }
        Ok(JobLines {
            chunks: Chunks::new(from, job.options.first_line).map_err(failed)?,
            preparer,
            parts: job.parts.clone(),
            part: 0,
        })
    }

    /// The next line, `None` behind the last.
    ///
    /// # Errors
    /// The program changed, or cannot be read.
    pub fn next_line(&mut self) -> Result<Option<JobLine>, Unreadable> {
        loop {
            while let Some((number, text)) = self.chunks.lines.pop_front() {
                match self.preparer.prepare(&text, number, &mut |_| {}) {
                    Ok(Some(line)) => return Ok(Some(line)),
                    Ok(None) => {}
                    // The text is the one that was vetted; what differs is where the machine stands.
                    Err(e) => return Err(Unreadable::Impossible(Box::new(e))),
                }
            }
            let line = self.chunks.read + 1;
            let digest = self
                .chunks
                .next()
                .map_err(|e| Unreadable::Failed(e.to_string()))?;
            match (digest, self.parts.get(self.part)) {
                (None, None) => return Ok(None),
                (Some(now), Some(vetted)) if now == *vetted => self.part += 1,
                _ => {
                    self.chunks.lines.clear();
                    return Err(Unreadable::Changed { line });
                }
            }
        }
    }

    /// What the controller remembers once it has carried out the line handed out last.
    pub fn state(&self) -> &State {
        self.preparer.state()
    }

    /// What the line handed out last tells the machine.
    pub fn events(&self) -> &[Event] {
        self.preparer.events()
    }

    /// Behind a probe or a tool change: the machine stands at `machine`, and the active work zero lies at `work_zero`, machine
    /// coordinates, mm. The lines that follow are read from there.
    pub fn stands_at(&mut self, machine: &Point, work_zero: Option<Vector>) {
        self.preparer.stands_at(machine, work_zero);
    }
}
