//! Vetting before the first byte: the whole program, line by line, through the one interpreter with the firmware's own rules.
//!
//! A bad line in the middle of a job costs the part: the controller drops it whole and runs the next ones with the old modes. So
//! nothing is sent until all of it is known to be taken, and what must not travel in a stream at all is refused by name, with
//! line and column: commands that write the controller's memory, `$` commands, characters that act at once, moves out of the
//! machine's travel. Constant memory: no line is kept.
//!
//! Crosses the border: a [`JobSource`] and [`VetOptions`] in (offsets and travel from the controller's introduction); a [`Job`]
//! or every refusal out. Work coordinates, mm. It knows nothing of the session and of ports.

mod modes;
mod options;
mod prepare;
mod refusal;
mod travel;
mod words;

#[cfg(test)]
mod tests;

pub use options::{
    BlockDelete, Limits, MemoryWriters, OptionalStops, ToldBy, ToolChanges, VetOptions,
};
pub use prepare::PLUNGE;
pub(super) use prepare::{Preparer, RX_MARGIN};
pub use refusal::{Caution, JobError, Refusal, Warning};

use super::job::{Chunks, Job, JobLine, JobSource};
use crate::gcode::{self, Complaint, Event, State};
use crate::units::Seconds;
use sha2::{Digest as _, Sha256};
use std::sync::Arc;

/// Refusals reported in one run.
pub const MAX_ERRORS: usize = 20;

/// Warnings kept.
const MAX_WARNINGS: usize = 20;

/// Reads a whole program as the controller will, from `options.start`. `hear` is told every event with the line that makes it,
/// in order, for whoever adds up times or looks for a line.
///
/// # Errors
/// Every line that cannot be sent, up to [`MAX_ERRORS`], in order. A refused line changes nothing, so one mistake can cause others;
/// of a run of missing feeds only the first is told.
pub fn vet(
    source: Arc<dyn JobSource>,
    options: VetOptions,
    hear: &mut dyn FnMut(&JobLine, &Event),
) -> Result<Job, Vec<JobError>> {
    let mut vetting = Vetting {
        preparer: Preparer::new(&options),
        end: [None; 3],
        total: 0,
        bytes: 0,
        errors: Vec::new(),
        feed_missing: false,
    };
    let mut entry = Vec::new();
    for text in &options.entry {
        entry.extend(vetting.line(text, 0, hear));
    }
    (vetting.total, vetting.bytes) = (0, 0);
    let unreadable = |line: usize, e: std::io::Error| {
        let why = Refusal::Unreadable(e.to_string());
        vec![JobError {
            line,
            column: 1,
            why,
        }]
    };
    let from = source.open().map_err(|e| unreadable(1, e))?;
    let mut chunks = Chunks::new(from, options.first_line).map_err(|e| unreadable(1, e))?;
    let mut parts = Vec::new();
    let mut whole = Sha256::new();
    loop {
        let digest = chunks.next().map_err(|e| unreadable(chunks.read + 1, e))?;
        let Some(digest) = digest else { break };
        whole.update(digest);
        parts.push(digest);
        while let Some((number, text)) = chunks.lines.pop_front() {
            if vetting.errors.len() >= MAX_ERRORS {
                break;
            }
            vetting.line(&text, number, hear);
        }
    }
    let source_lines = chunks.read;
    let mut errors = vetting.errors;
    if errors.is_empty() && vetting.total == 0 {
        errors.push(JobError {
            line: source_lines.max(1),
            column: 1,
            why: Refusal::Empty,
        });
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut digest = [0; 32];
    for (to, from) in digest.iter_mut().zip(whole.finalize()) {
        *to = from;
    }
    let end_state = vetting.preparer.state().clone();
    let mut warnings = vetting.preparer.warnings;
    warnings.truncate(MAX_WARNINGS);
    Ok(Job {
        source,
        options,
        entry,
        total: vetting.total,
        bytes: vetting.bytes,
        source_lines,
        end: vetting.end,
        end_state,
        warnings,
        digest,
        parts: parts.into(),
    })
}

struct Vetting {
    preparer: Preparer,
    end: [Option<f64>; 3],
    total: usize,
    bytes: u64,
    errors: Vec<JobError>,
    feed_missing: bool,
}

impl Vetting {
    fn line(
        &mut self,
        text: &str,
        number: usize,
        hear: &mut dyn FnMut(&JobLine, &Event),
    ) -> Option<JobLine> {
        let mut events = Vec::new();
        let work_offset = self.preparer.state().work_offset;
        let prepared = self
            .preparer
            .prepare(text, number, &mut |event| events.push(event.clone()));
        match prepared {
            Ok(line) => {
                let line = line?;
                self.feed_missing = false;
                for event in &events {
                    follow(&mut self.end, event, self.preparer.state(), work_offset);
                    hear(&line, event);
                }
                self.total += 1;
                self.bytes += line.bytes() as u64;
                Some(line)
            }
            Err(e) => {
                let why = Complaint::FeedMissing;
                let feed = e.why == Refusal::Word { why };
                if !(feed && self.feed_missing) {
                    self.errors.push(e);
                }
                self.feed_missing = feed;
                None
            }
        }
    }
}

/// Seconds of standing still that an event adds to its line.
fn dwell(event: &Event) -> f64 {
    match event {
        Event::Dwell {
            time: Seconds(t), ..
        } => *t,
        _ => 0.0,
    }
}

/// Keeps track of which end coordinates the text alone decides.
/// `work_offset`: the work system (0: G54) before the line.
fn follow(end: &mut [Option<f64>; 3], event: &Event, state: &State, work_offset: usize) {
    match event {
        Event::Motion(m) => {
            for (i, known) in end.iter_mut().enumerate() {
                let moved = m.to[i] != m.from[i];
                if m.machine_coordinates {
                    // Even a move that looks like none here may be one on the machine.
                    *known = None;
                } else if state.distance == gcode::Distance::Absolute && (moved || known.is_some())
                {
                    *known = Some(m.to[i]);
                } else if let Some(place) = known {
                    *place += m.to[i] - m.from[i];
                }
            }
        }
        // The end of a program goes back to G54: the same place has other coordinates, by offsets that the text does not tell.
        Event::Probe { .. } | Event::Sync { .. } => *end = [None; 3],
        Event::End { .. } if work_offset != state.work_offset => *end = [None; 3],
        _ => {}
    }
}
