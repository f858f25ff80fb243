//! Events to steps.

use super::error::TranslateError;
use crate::cldata::{Bow, Coolant, Place, Step};
use crate::gcode::{Dialect, Distance, Event, Interpreter, Motion, MotionKind, PathMode, State};
use crate::geom::{Point, Vector};
use crate::units::{Mm, MmPerMin, Seconds};
use std::collections::VecDeque;
use std::io::{BufRead, Seek};

/// Something that was left out or taken for something, for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Line of the program, from 1.
    pub line: usize,
    /// What.
    pub text: &'static str,
}

/// So many notes are kept.
const MOST_NOTES: usize = 100;

/// Origins that no program names: a coordinate made with one is known by it. mm.
const NOWHERE: f64 = 1_048_576.0;
/// ... and a stored place.
const STORED: f64 = 3_145_728.0;

/// A machine of which nothing is known: it stands nowhere, and its offsets and stored places are none that a program could mean.
pub fn unknown_state(dialect: Dialect) -> State {
    let mut s = State::new(dialect);
    for (i, g5x) in s.g5x.iter_mut().enumerate() {
        // Distinct, and thirds of nothing that decimals write.
        let d = NOWHERE + i as f64 / 3.0 + 1.0 / 7.0;
        *g5x = Vector::new(d, d, d);
    }
    s.g28 = Point::new(STORED, STORED, STORED);
    s.g30 = s.g28;
    s.position = Point::new(f64::NAN, f64::NAN, f64::NAN);
    s
}

/// The steps of a program that is read from [`unknown_state`]: an iterator of steps with their lines. Ends at the first error.
pub struct Steps<R> {
    said: Interpreter<R>,
    waiting: VecDeque<(usize, Step)>,
    /// Axes whose work coordinate the program has told.
    known: [bool; 3],
    offset: usize,
    origins: Vec<Vector>,
    tool: u32,
    over: bool,
    ended: bool,
    last_line: usize,
    /// What was left out or taken for something; the first ones of many.
    pub notes: Vec<Note>,
    /// The path tolerance that the program asks for, as soon as it has: the smallest.
    pub path_tolerance: Option<Mm>,
}

type Line = Result<(), TranslateError>;

impl<R: BufRead + Seek> Steps<R> {
    /// Of a program being read from [`unknown_state`].
    pub fn new(said: Interpreter<R>) -> Steps<R> {
        let state = said.state();
        Steps {
            offset: state.work_offset,
            origins: state.g5x.to_vec(),
            said,
            waiting: VecDeque::new(),
            known: [false; 3],
            tool: 0,
            over: false,
            ended: false,
            last_line: 1,
            notes: Vec::new(),
            path_tolerance: None,
        }
    }

    fn note(&mut self, line: usize, text: &'static str) {
        if self.notes.len() < MOST_NOTES && !self.notes.iter().any(|n| n.text == text) {
            self.notes.push(Note { line, text });
        }
    }

    fn push(&mut self, line: usize, step: Step) {
        self.waiting.push_back((line, step));
    }

    /// Reads one event, and makes steps of it; false at the end.
    fn read(&mut self) -> Result<bool, TranslateError> {
        let event = match self.said.next() {
            None => {
                if !self.ended {
                    self.note(
                        self.last_line,
                        "the program has no M2 or M30: an end was added",
                    );
                    self.push(self.last_line, Step::End);
                    self.ended = true;
                }
                return Ok(false);
            }
            Some(Ok(e)) => e,
            Some(Err(e)) => {
                let text = self.said.text_of(e.line);
                let complaint = e.to_string();
                return Err(TranslateError::Unreadable { complaint, text });
            }
        };
        let line = event.line();
        self.last_line = line;
        for c in self.said.take_comments() {
            self.push(c.line, Step::Comment(c.text));
        }
        if let Event::ToolChange { tool, .. } = event {
            self.tool = tool;
        }
        // The end puts modes back that no step hangs on any more.
        if !matches!(event, Event::End { .. }) {
            self.modes(line)?;
        }
        match event {
            Event::Motion(m) => self.motion(&m)?,
            Event::Dwell { time, .. } => self.push(line, Step::Dwell(time)),
            Event::Spindle {
                direction, speed, ..
            } => self.push(
                line,
                Step::Spindle {
                    direction,
                    speed,
                    spin_up: Seconds(0.0),
                },
            ),
            Event::Coolant { flood, mist, .. } => {
                let coolant = match (flood, mist) {
                    (false, false) => Coolant::Off,
                    (true, false) => Coolant::Flood,
                    (false, true) => Coolant::Mist,
                    (true, true) => Coolant::Both,
                };
                self.push(line, Step::Coolant(coolant));
            }
            Event::ToolChange { tool, .. } => {
                // The machine goes to its own place for that.
                self.forget([true; 3]);
                self.push(line, Step::Tool { number: tool });
            }
            Event::Pause { optional, .. } => self.push(line, Step::Pause { optional }),
            Event::Probe { .. } => {
                return Err(TranslateError::Unsayable {
                    line,
                    what: "a probing move",
                    advice: "probe by hand, or keep this part of the job in its own dialect",
                });
            }
            Event::Sync { .. } => {}
            Event::End { .. } => {
                self.push(line, Step::End);
                self.ended = true;
            }
        }
        Ok(true)
    }

    /// What a line changed without moving.
    fn modes(&mut self, line: usize) -> Line {
        let state = self.said.state();
        if let PathMode::Blend { tolerance: Some(t) } = state.path
            && self.path_tolerance.is_none_or(|p| t < p.0)
        {
            self.path_tolerance = Some(Mm(t));
        }
        let what = if state.g92 != Vector::zeros() {
            Some("a shift of the coordinates (G92, G52)")
        } else if state.g5x[..] != self.origins[..] {
            Some("a work offset (G10)")
        } else if state.tlo != 0.0 {
            Some("a tool length by its value (G43.1)")
        } else {
            None
        };
        if let Some(what) = what {
            return Err(TranslateError::Offset { line, what });
        }
        // Sinumerik's D counts the edges of a tool: the first is the tool's own length.
        let own = match state.dialect {
            Dialect::Siemens => 1,
            _ => self.tool,
        };
        if let Some(length) = state.tool_length
            && length != own
            && length != 0
        {
            let tool = self.tool;
            return Err(TranslateError::ToolLength { line, length, tool });
        }
        let offset = state.work_offset;
        if offset != self.offset {
            self.offset = offset;
            self.known = [false; 3];
            let number = u16::try_from(offset + 1).unwrap_or(u16::MAX);
            self.push(line, Step::WorkOffset(number));
        }
        Ok(())
    }

    /// Axes of which nobody can tell any more where they stand in work coordinates.
    fn forget(&mut self, axes: [bool; 3]) {
        for (k, _) in axes.iter().enumerate().filter(|(_, gone)| **gone) {
            self.known[k] = false;
            self.said.state_mut().position[k] = f64::NAN;
        }
    }

    fn motion(&mut self, m: &Motion) -> Line {
        let line = m.line;
        if m.machine_coordinates {
            return self.machine(m);
        }
        let incremental = self.said.state().distance == Distance::Incremental;
        // An axis has been named where it changes: from nowhere to somewhere is a change.
        let named: [bool; 3] = std::array::from_fn(|k| m.to[k].is_finite() && m.to[k] != m.from[k]);
        match m.kind {
            MotionKind::Rapid => {
                for (known, named) in self.known.iter_mut().zip(named) {
                    *known |= named;
                }
                if incremental && !self.known.iter().all(|k| *k) {
                    return self.unknown(line);
                }
                let to: Place = std::array::from_fn(|k| self.known[k].then_some(m.to[k]));
                if to.iter().any(Option::is_some) {
                    self.push(line, Step::Rapid { to });
                }
                Ok(())
            }
            MotionKind::Feed => {
                for (k, named) in named.into_iter().enumerate() {
                    self.known[k] |= named && m.from[k].is_finite();
                }
                let told =
                    (0..3).all(|k| self.known[k] && m.from[k].is_finite() && m.to[k].is_finite());
                if !told {
                    return self.unknown(line);
                }
                let bow = m.arc.map(|a| Bow {
                    plane: a.plane,
                    center: a.center,
                    sweep: a.sweep,
                });
                let feed = if m.inverse_time {
                    MmPerMin(m.feed.0 * length(m))
                } else {
                    m.feed
                };
                if feed.0 > 0.0 {
                    self.push(
                        line,
                        Step::Feed {
                            to: m.to,
                            bow,
                            feed,
                        },
                    );
                } else {
                    self.note(line, "moves of no length in inverse time are left out");
                }
                Ok(())
            }
        }
    }

    /// G53, G28, G30 and their like.
    fn machine(&mut self, m: &Motion) -> Line {
        let line = m.line;
        if m.kind != MotionKind::Rapid {
            return Err(TranslateError::Unsayable {
                line,
                what: "a feed move in machine coordinates",
                advice: "write it in work coordinates, or as a rapid",
            });
        }
        let there = self.said.state().machine_of_work(&m.to);
        let mut to: Place = [None; 3];
        for k in 0..3 {
            if !m.to[k].is_finite() || m.to[k] == m.from[k] {
                continue;
            }
            // To the nanometre: what is more came by way of the offsets.
            let told = (there[k] * 1e6).round() / 1e6;
            if (told - STORED).abs() < 1e5 {
                return Err(TranslateError::StoredPlace { line });
            }
            to[k] = Some(told);
        }
        self.forget(to.map(|v| v.is_some()));
        if to.iter().any(Option::is_some) {
            self.push(line, Step::MachineRapid { to });
        }
        Ok(())
    }

    fn unknown(&self, line: usize) -> Line {
        let letters = ["X", "Y", "Z"];
        let axes: Vec<&str> = (0..3)
            .filter(|&k| !self.known[k])
            .map(|k| letters[k])
            .collect();
        let axes = if axes.is_empty() {
            "the axes it names".to_string()
        } else {
            axes.join(", ")
        };
        Err(TranslateError::UnknownPlace { line, axes })
    }
}

impl<R: BufRead + Seek> Iterator for Steps<R> {
    type Item = Result<(usize, Step), TranslateError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(step) = self.waiting.pop_front() {
                return Some(Ok(step));
            }
            if self.over {
                return None;
            }
            match self.read() {
                Ok(more) => self.over = !more,
                Err(e) => {
                    self.over = true;
                    return Some(Err(e));
                }
            }
        }
    }
}

/// Length of a motion, mm.
fn length(m: &Motion) -> f64 {
    match &m.arc {
        None => (m.to - m.from).norm(),
        Some(a) => {
            let [i, j, n] = a.plane.axes();
            let radius = (m.from[i] - a.center[i]).hypot(m.from[j] - a.center[j]);
            (radius * a.sweep).hypot(m.to[n] - m.from[n])
        }
    }
}
