//! One line of the program to the line that is sent, or to a refusal. The same for vetting and for sending.

use super::dwell;
use super::modes::ModesSet;
use super::options::{BlockDelete, MemoryWriters, OptionalStops, ToolChanges, VetOptions};
use super::refusal::{Caution, JobError, Refusal, Warning};
use super::travel::Reach;
use super::words::{Significant, column_of, is, significant, words};
use crate::gcode::source::LONGEST;
use crate::gcode::{self, Event, MotionKind, MotionMode, State};
use crate::geom::{Point, Vector};
use crate::link::job::{JobLine, Standstill, Weight};
use crate::link::progress::{Prompt, PromptKind};

/// A feed move that goes up or down by more than this, mm, counts as a plunge or retract; so does any straight up or down. The
/// short segments of a finishing pass do not: if one is lost, the next starts at most one segment away.
pub const PLUNGE: f64 = 0.5;

/// Kept free of the receive buffer: costs nothing and forgives a firmware that counts one byte differently.
pub(in crate::link) const RX_MARGIN: usize = 1;

/// A `$` setting whose change would make the session misread every report behind it.
const REPORT_SETTINGS: [&str; 2] = ["10", "13"];

/// Reads one line after the other.
pub(in crate::link) struct Preparer {
    options: VetOptions,
    state: State,
    reach: Reach,
    set: ModesSet,
    events: Vec<Event>,
    /// The comment of a line of nothing else, for a stop on the next line.
    comment: Option<String>,
    ended: bool,
    /// Line of a tool change since which the spindle has been off.
    changed: bool,
    /// What the operator should know.
    pub warnings: Vec<Warning>,
}

/// Modes whose change changes what later lines mean.
#[derive(PartialEq)]
struct Frame {
    plane: gcode::Plane,
    distance: gcode::Distance,
    feed_mode: gcode::FeedMode,
    units: gcode::Units,
    work_offset: usize,
    g92: [f64; 3],
    tlo: f64,
}

impl Frame {
    fn of(s: &State) -> Frame {
        Frame {
            plane: s.plane,
            distance: s.distance,
            feed_mode: s.feed_mode,
            units: s.units,
            work_offset: s.work_offset,
            g92: s.g92.into(),
            tlo: s.tlo,
        }
    }
}

impl Preparer {
    pub fn new(options: &VetOptions) -> Preparer {
        Preparer {
            state: options.start.clone(),
            reach: Reach::new(options.limits),
            set: ModesSet::default(),
            events: Vec::new(),
            comment: None,
            ended: false,
            changed: false,
            warnings: Vec::new(),
            options: options.clone(),
        }
    }

    /// What the controller remembers behind the last line.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What the line read last tells the machine.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// The machine stands elsewhere than the text can tell, and the active work zero may be another.
    pub fn stands_at(&mut self, machine: &Point, work_zero: Option<Vector>) {
        if let Some(zero) = work_zero {
            let moved = zero - self.state.offset();
            if let Some(origin) = self.state.g5x.get_mut(self.state.work_offset) {
                *origin += moved;
            }
        }
        self.state.set_machine_position(machine);
    }

    /// The line to send, `None` if there is nothing to send in it.
    pub fn prepare(
        &mut self,
        text: &str,
        line: usize,
        hear: &mut dyn FnMut(&Event),
    ) -> Result<Option<JobLine>, JobError> {
        let error = |column, why| Err(JobError { line, column, why });
        if text.len() >= LONGEST {
            return error(1, Refusal::Endless);
        }
        let mut s = significant(text);
        if s.text.is_empty() || s.text == "%" {
            if s.comment.is_some() {
                self.comment = s.comment;
            }
            return Ok(None);
        }
        let comment = s.comment.take().or(self.comment.take());
        let mut written = text;
        if s.text.starts_with('/') {
            match self.options.block_delete {
                BlockDelete::Refuse => return error(s.column, Refusal::BlockDelete),
                BlockDelete::Skip => {
                    self.warn_once(line, s.column, Caution::Skipped);
                    return Ok(None);
                }
                BlockDelete::Keep => {
                    // Only blanks and comments can stand before it.
                    written = text.split_once('/').map_or(text, |(_, rest)| rest);
                    s.text.remove(0);
                    if s.text.is_empty() {
                        return Ok(None);
                    }
                }
            }
        }
        if let Some((column, c)) = s.realtime {
            return error(column, Refusal::Realtime(c));
        }
        if s.text.contains('/') {
            return error(s.slash.unwrap_or(1), Refusal::Slash);
        }
        let mut prepared = if s.text.starts_with('$') {
            self.dollar(&s, line)?
        } else {
            self.g_code(&mut s, text, written, line, comment, hear)?
        };
        prepared.text = s.text;
        let room = self.options.rx_bytes.saturating_sub(RX_MARGIN);
        if prepared.bytes() > room {
            let bytes = prepared.bytes();
            return error(1, Refusal::LongerThanBuffer { bytes, room });
        }
        if self.ended {
            self.warn_once(line, s.column, Caution::BehindTheEnd);
        }
        self.ended |= self.events.iter().any(|e| matches!(e, Event::End { .. }));
        prepared.source = line;
        Ok(Some(prepared))
    }

    fn dollar(&mut self, s: &Significant, line: usize) -> Result<JobLine, JobError> {
        self.events.clear();
        let number = s
            .text
            .strip_prefix('$')
            .and_then(|t| t.split_once('='))
            .map(|(n, _)| n)
            .filter(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
        let allowed = self.options.memory_writers == MemoryWriters::Barrier
            && number.is_some_and(|n| !REPORT_SETTINGS.contains(&n));
        if !allowed {
            let (column, why) = (s.column, Refusal::Dollar);
            return Err(JobError { line, column, why });
        }
        Ok(JobLine {
            writes_memory: true,
            ..JobLine::own("")
        })
    }

    fn g_code(
        &mut self,
        s: &mut Significant,
        text: &str,
        written: &str,
        line: usize,
        comment: Option<String>,
        hear: &mut dyn FnMut(&Event),
    ) -> Result<JobLine, JobError> {
        let error = |column, why| Err(JobError { line, column, why });
        let mut out = JobLine::default();
        let mut axes = false;
        let (mut pause, mut optional, mut change, mut tool) = (false, false, false, None);
        let mut alone = true;
        for word in words(&s.text) {
            for (number, name) in [(10.0, "G10"), (28.1, "G28.1"), (30.1, "G30.1")] {
                if is(word, 'G', number) {
                    if self.options.memory_writers == MemoryWriters::Refuse {
                        return error(column_of(text, 'G', number), Refusal::WritesMemory(name));
                    }
                    out.writes_memory = true;
                }
            }
            match word {
                ('G', n) if n < 4.0 || (38.0..39.0).contains(&n) || n == 80.0 => {
                    out.weight.restates_motion = true;
                }
                ('X' | 'Y' | 'Z', _) => axes = true,
                ('T', n) => tool = Some(n),
                _ => {}
            }
            change |= is(word, 'M', 6.0);
            pause |= is(word, 'M', 0.0);
            optional |= is(word, 'M', 1.0);
            alone &= is(word, 'M', 6.0) || matches!(word.0, 'T' | 'N');
        }
        out.weight.restates_motion |= !axes;
        if change {
            return self.tool_change(s, text, line, comment, tool, alone, hear);
        }
        let before = Frame::of(&self.state);
        let motion = self.state.motion;
        self.set.read(words(&s.text));
        self.events.clear();
        let mut events = std::mem::take(&mut self.events);
        let read = gcode::interpret_line(&mut self.state, written, line, &mut events);
        self.events = events;
        // What stands before the slash of a kept line moves the column.
        let shift = text.chars().count() - written.chars().count();
        read.map_err(|e| JobError {
            line,
            column: e.column + shift,
            why: Refusal::Word { why: e.complaint },
        })?;
        for event in &self.events {
            if let Event::Motion(m) = event
                && matches!(
                    self.state.motion,
                    MotionMode::ArcClockwise | MotionMode::ArcCounterclockwise
                )
                && words(&s.text).any(|w| w.0 == 'R')
            {
                let [a, b, _] = self.state.plane.axes();
                if (m.to[a] - m.from[a]).hypot(m.to[b] - m.from[b]) < 1e-6 {
                    return error(s.column, Refusal::ArcUpright);
                }
            }
            self.reach
                .event(event, &self.state)
                .map_err(|why| JobError {
                    line,
                    column: s.column,
                    why,
                })?;
        }
        out.weight.changes_frame = Frame::of(&self.state) != before;
        out.weight.changes_motion = self.state.motion != motion;
        out.weight.dangerous = self.events.iter().any(dangerous);
        if self.events.iter().any(waits) {
            let dwell = self.events.iter().map(dwell).sum();
            out.standstill = Standstill::Yes { dwell };
        }
        if optional && self.options.optional_stops == OptionalStops::Stop {
            s.text = as_m0(&s.text);
            pause = true;
        }
        if pause {
            out.prompt = Some(Prompt {
                source: line,
                kind: PromptKind::Pause,
                text: comment,
            });
            out.standstill = Standstill::Yes { dwell: 0.0 };
        }
        self.caution(s, line);
        self.events.iter().for_each(hear);
        Ok(out)
    }

    /// M6 on a line of its own becomes: spindle and coolant off, then a prompt.
    #[allow(clippy::too_many_arguments, reason = "all that a line is made of")]
    fn tool_change(
        &mut self,
        s: &mut Significant,
        text: &str,
        line: usize,
        comment: Option<String>,
        tool: Option<f64>,
        alone: bool,
        hear: &mut dyn FnMut(&Event),
    ) -> Result<JobLine, JobError> {
        let column = column_of(text, 'M', 6.0);
        let refuse = |why| Err(JobError { line, column, why });
        if self.options.tool_changes == ToolChanges::Refuse {
            return refuse(Refusal::ToolChange);
        }
        if !alone {
            return refuse(Refusal::ToolChangeNotAlone);
        }
        // GRBL forgets T on the next line; the other dialects do not.
        let tool = tool.map_or(self.state.tool, |t| {
            t.clamp(0.0, f64::from(u32::MAX)) as u32
        });
        self.state.tool = tool;
        self.state.spindle = 0;
        self.changed = true;
        s.text = "M5M9".to_string();
        self.events.clear();
        self.events.push(Event::ToolChange { tool, line });
        self.events.iter().for_each(hear);
        Ok(JobLine {
            standstill: Standstill::Yes { dwell: 0.0 },
            weight: Weight {
                dangerous: true,
                restates_motion: true,
                ..Weight::default()
            },
            prompt: Some(Prompt {
                source: line,
                kind: PromptKind::ToolChange { tool },
                text: comment,
            }),
            ..JobLine::default()
        })
    }

    fn caution(&mut self, s: &Significant, line: usize) {
        for what in self.set.forgotten(&self.events) {
            // A resumed program has set its modes before the line it goes on with.
            if self.options.first_line == 1 {
                self.warnings.push(Warning {
                    line,
                    column: s.column,
                    what,
                });
            }
        }
        if self.state.spindle != 0 {
            self.changed = false;
        }
        let cuts = |e: &Event| matches!(e, Event::Motion(m) if m.kind == MotionKind::Feed);
        if self.changed && self.events.iter().any(cuts) {
            self.changed = false;
            self.warn_once(line, s.column, Caution::SpindleOffAfterChange);
        }
    }

    fn warn_once(&mut self, line: usize, column: usize, what: Caution) {
        if self.warnings.len() < super::MAX_WARNINGS && self.warnings.iter().all(|w| w.what != what)
        {
            self.warnings.push(Warning { line, column, what });
        }
    }
}

/// M1 as M0.
fn as_m0(text: &str) -> String {
    for (from, to) in [("M01", "M0"), ("M1", "M0")] {
        let at = text.match_indices(from).map(|(at, _)| at).find(|at| {
            let next = text.as_bytes().get(at + from.len());
            !next.is_some_and(|b| b.is_ascii_digit() || *b == b'.')
        });
        if let Some(at) = at {
            let mut text = text.to_string();
            text.replace_range(at..at + from.len(), to);
            return text;
        }
    }
    text.to_string()
}

/// A rapid, a plunge or retract, a probe, a change of spindle or coolant.
fn dangerous(event: &Event) -> bool {
    match event {
        Event::Motion(m) => {
            let up = (m.to.z - m.from.z).abs();
            let along = (m.to.x - m.from.x).hypot(m.to.y - m.from.y);
            let upright = m.arc.is_none() && along < 1e-9 && up > 1e-9;
            m.kind == MotionKind::Rapid || m.machine_coordinates || upright || up > PLUNGE
        }
        Event::Probe { .. }
        | Event::Spindle { .. }
        | Event::Coolant { .. }
        | Event::ToolChange { .. } => true,
        Event::Dwell { .. } | Event::Pause { .. } | Event::Sync { .. } | Event::End { .. } => false,
    }
}

/// Answered only when the motion before has ended.
fn waits(event: &Event) -> bool {
    match event {
        Event::Motion(_) => false,
        Event::Pause { optional, .. } => !optional,
        _ => true,
    }
}
