//! A vetted program: every line was read, by the one interpreter, before the first is sent.
//!
//! A bad line in the middle of a job costs the part: the controller drops it whole and runs the next ones with the old modes. So
//! nothing is sent until all of it is known to be taken, and what must not travel in a stream at all is refused by name:
//! `$` commands, tool changes, and commands that write the controller's memory (bytes arriving meanwhile are lost).

use crate::gcode::{self, Complaint, Dialect, Event, State};
use crate::units::Seconds;
use crate::wire::LINE_CHARS;

/// Complaints reported in one run.
const MAX_ERRORS: usize = 20;

/// One line as it will be sent.
#[derive(Clone, Debug, PartialEq)]
pub struct JobLine {
    /// Its characters, upper case, without comments, blanks and line end.
    pub text: String,
    /// Line of the program, from 1; 0 for a line of our own.
    pub source: usize,
    /// Seconds the machine stands still at this line while the controller already says Idle (a dwell).
    pub dwell: f64,
}

impl JobLine {
    /// A line the session adds.
    pub(super) fn own(text: &str) -> JobLine {
        JobLine {
            text: text.to_string(),
            source: 0,
            dwell: 0.0,
        }
    }

    /// Bytes it takes in the controller's receive buffer, line end included.
    pub fn bytes(&self) -> usize {
        self.text.len() + 1
    }
}

/// Why a program cannot be streamed, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column} {why}")]
pub struct JobError {
    /// Line of the program, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub why: Refusal,
}

/// What a job must not contain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The interpreter's complaint.
    #[error("{0}")]
    Word(Complaint),
    /// M6.
    #[error("this controller changes no tools: cut the program at M6 and send one part per tool")]
    ToolChange,
    /// G10, G28.1, G30.1.
    #[error(
        "{0} writes the controller's memory, which loses bytes of a running stream: send it by itself before the job"
    )]
    WritesMemory(&'static str),
    /// A `$` line.
    #[error("a $ command does not belong into a job: send it by itself before the job")]
    Dollar,
    /// A line that begins with `/`.
    #[error("GRBL ignores block delete and would run this line: remove the line, or its slash")]
    BlockDelete,
    /// Nothing to send.
    #[error("the program has no line to send")]
    Empty,
}

/// A program proven fit to be streamed.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The lines to send, in order; empty and comment lines are left out.
    pub lines: Vec<JobLine>,
    /// Where the program ends in work coordinates, mm, as far as the text alone can tell: `None` for an axis that is never
    /// moved, or whose place depends on offsets, machine coordinates or probing.
    pub end: [Option<f64>; 3],
    /// Lines of the program's text.
    pub source_lines: usize,
    /// What the program tells the machine.
    pub events: Vec<Event>,
}

impl Job {
    /// Reads a whole program as GRBL will, from the state after a reset.
    ///
    /// # Errors
    /// Every line that cannot be sent, up to 20, in order.
    pub fn vet(text: &str) -> Result<Job, Vec<JobError>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut job = Job {
            lines: Vec::new(),
            end: [None; 3],
            source_lines: 0,
            events: Vec::new(),
        };
        let mut state = State::new(Dialect::Grbl);
        let mut errors = Vec::new();
        for content in gcode::lines(text) {
            job.source_lines += 1;
            let line = job.source_lines;
            if errors.len() >= MAX_ERRORS {
                continue;
            }
            let significant = significant(content);
            if significant.is_empty() || significant == "%" {
                continue;
            }
            if let Some(why) = forbidden(content, &significant) {
                errors.push(JobError {
                    line,
                    column: 1,
                    why,
                });
                continue;
            }
            let first = job.events.len();
            match gcode::interpret_line(&mut state, content, line, &mut job.events) {
                Ok(()) => {
                    let events = job.events.get(first..).unwrap_or_default();
                    let dwell = events.iter().map(dwell).sum();
                    events.iter().for_each(|e| follow(&mut job.end, e, &state));
                    job.lines.push(JobLine {
                        text: significant,
                        source: line,
                        dwell,
                    });
                }
                Err(e) => {
                    let m6 = matches!(&e.complaint, Complaint::UnsupportedCode { code } if code.letter == 'M' && code.number == 6.0);
                    let why = if m6 {
                        Refusal::ToolChange
                    } else {
                        Refusal::Word(e.complaint)
                    };
                    errors.push(JobError {
                        line,
                        column: e.column,
                        why,
                    });
                }
            }
        }
        if errors.is_empty() && job.lines.is_empty() {
            errors.push(JobError {
                line: job.source_lines.max(1),
                column: 1,
                why: Refusal::Empty,
            });
        }
        if errors.is_empty() {
            Ok(job)
        } else {
            Err(errors)
        }
    }

    /// Bytes that will be sent.
    pub fn bytes(&self) -> usize {
        self.lines.iter().map(JobLine::bytes).sum()
    }
}

/// What GRBL keeps of a line: no blanks, no comments, upper case. Slashes stay, to be refused.
fn significant(line: &str) -> String {
    let mut out = String::with_capacity(line.len().min(LINE_CHARS));
    let mut parenthesis = false;
    for c in line.chars() {
        match c {
            ')' if parenthesis => parenthesis = false,
            _ if parenthesis => {}
            '(' => parenthesis = true,
            ';' => break,
            c if c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    out
}

fn forbidden(content: &str, significant: &str) -> Option<Refusal> {
    if significant.starts_with('$') {
        return Some(Refusal::Dollar);
    }
    if content.trim_start().starts_with('/') || significant.contains('/') {
        return Some(Refusal::BlockDelete);
    }
    let mut rest = significant;
    while let Some(at) = rest.find('G') {
        rest = rest.get(at + 1..).unwrap_or_default();
        let digits = rest
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(rest.len());
        let Some(code) = rest.get(..digits).and_then(|d| d.parse::<f64>().ok()) else {
            continue;
        };
        for (number, name) in [(10.0, "G10"), (28.1, "G28.1"), (30.1, "G30.1")] {
            if (code - number).abs() < 5e-3 {
                return Some(Refusal::WritesMemory(name));
            }
        }
    }
    None
}

fn dwell(event: &Event) -> f64 {
    match event {
        Event::Dwell {
            time: Seconds(t), ..
        } => *t,
        _ => 0.0,
    }
}

/// Keeps track of which end coordinates the text alone decides.
fn follow(end: &mut [Option<f64>; 3], event: &Event, state: &State) {
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
        Event::Probe { .. } | Event::Sync { .. } => *end = [None; 3],
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn refused(text: &str) -> String {
        Job::vet(text)
            .unwrap_err()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("\n")
    }

    #[test]
    fn strips_what_the_controller_would_and_keeps_the_line_numbers() {
        let job =
            Job::vet("%\n(part ?! \u{e9})\ng21 g90 ; mm\n\nG1 X1.5 Y2 (cut~) F300\nG4 P2\n%\n")
                .unwrap();
        let lines: Vec<(usize, &str)> = job
            .lines
            .iter()
            .map(|l| (l.source, l.text.as_str()))
            .collect();
        assert_eq!(lines, [(3, "G21G90"), (5, "G1X1.5Y2F300"), (6, "G4P2")]);
        assert_eq!(job.lines[2].dwell, 2.0);
        assert_eq!(job.end, [Some(1.5), Some(2.0), None]);
        assert_eq!(job.bytes(), 7 + 13 + 5);
    }

    #[test]
    fn refuses_what_must_not_be_streamed() {
        assert!(refused("G0X1\nT1 M6\n").starts_with("2:4 this controller changes no tools"));
        assert!(refused("G10 L2 P1 X0\n").contains("G10 writes the controller's memory"));
        assert!(refused("G28.1\n").contains("G28.1 writes"));
        assert!(refused("G30.10\n").contains("G30.1 writes"));
        assert!(refused("$H\n").contains("a $ command"));
        assert!(refused("/G0X1\n").contains("block delete"));
        assert!(refused("G0X1!\n").starts_with("1:5 "));
        assert!(refused("G0X1\u{e9}\n").starts_with("1:5 "));
        assert!(refused("G1X1\n").contains("no feed rate"));
        assert!(refused("").contains("no line to send"));
        assert!(refused("(nothing)\n").contains("no line to send"));
        assert!(refused(&format!("G0 X{}\n", "0".repeat(90))).contains("at most 79"));
    }

    #[test]
    fn the_end_is_known_only_where_the_text_decides_it() {
        assert_eq!(Job::vet("G0 X1 Y1 Z1\nG53 G0 Z0\n").unwrap().end, [None; 3]);
        assert_eq!(
            Job::vet("G0 X1 Y1 Z1\nG91\nG0 X1\n").unwrap().end,
            [Some(2.0), Some(1.0), Some(1.0)]
        );
        assert_eq!(Job::vet("G91\nG0 X1\n").unwrap().end, [None; 3]);
        assert_eq!(
            Job::vet("G0 X1\nG92 X0\nG0 X5 Z2\nM30\n").unwrap().end,
            [Some(5.0), None, Some(2.0)]
        );
    }

    proptest! {
        /// Whatever the text: a vetted line never holds a byte the controller would take for itself.
        #[test]
        fn no_real_time_byte_ever_travels_in_a_line(text in "[GXYZF0-9 .!?~;()\\n\u{e9}\u{91}$/%-]{0,60}") {
            if let Ok(job) = Job::vet(&text) {
                for line in &job.lines {
                    prop_assert!(line.text.bytes().all(|b| b > b' ' && b < 0x7E && !b"!?~$%/;()".contains(&b)), "{}", line.text);
                    prop_assert!(line.text.len() <= LINE_CHARS);
                }
            }
        }
    }
}
