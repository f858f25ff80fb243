//! The path watch in the session: where the lines under way lead, which reports are held against it, and when the session has to look
//! where the machine stands before it reads on.
//!
//! Where the machine stands is the text's business, from the place it introduced itself at, but for three kinds of lines: behind a
//! probe, a tool change and a changed `$` setting only the machine knows. Nothing of the program is read behind such a line until it
//! was answered and a report has told.

use super::{Phase, Session};
use crate::gcode::Event;
use crate::geom::{Point, Vector};
use crate::kinematics::chords;
use crate::link::job::{JobLine, JobLines, Unreadable};
use crate::link::outcome::Ending;
use crate::link::progress::PromptKind;
use crate::link::vet::Preparer;
use crate::link::watch::{Watch, WatchOptions};
use crate::units::Mm;
use crate::wire::{Realtime, State, Status};
use std::time::Duration;

/// So many reports in a row must lie off the way: one may itself have been damaged.
const OFF_REPORTS: u32 = 2;
/// Reports waited for that name the work offset: GRBL does in every tenth of an idle machine.
const OFFSET_REPORTS: u32 = 12;
/// A place that differs by more, mm, is told.
const MOVED: f64 = 0.02;
/// GRBL's `$12`, where the controller does not tell one that can be, mm.
const ARC_TOLERANCE: f64 = 0.002;

/// A line that waits to be sent, and where it leads.
#[derive(Debug)]
pub(super) struct Upcoming {
    pub line: JobLine,
    /// Machine coordinates, mm.
    pub way: Vec<Point>,
    /// Only the machine knows where it stands behind it.
    pub ends_anywhere: bool,
}

impl From<JobLine> for Upcoming {
    /// A line that moves nothing.
    fn from(line: JobLine) -> Upcoming {
        Upcoming {
            line,
            way: Vec::new(),
            ends_anywhere: false,
        }
    }
}

/// Whether the session has to look where the machine stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// The text tells.
    No,
    /// A line is under way behind which it has to.
    Due,
    /// Now.
    Now {
        /// The work zero may have changed too.
        zero: bool,
        /// Reports heard.
        reports: u32,
    },
}

impl Session {
    /// The program is read, and the watch begins, from where the controller says it stands.
    pub(super) fn stand(&mut self) {
        let known = &self.known;
        let (Some(place), Some(zero)) = (known.machine_position, known.work_offset) else {
            return self.unwatched("the controller does not tell where it stands");
        };
        let (place, zero) = (Point::from(place), Vector::from(zero));
        let told = known.start();
        let active = known.modes.work_offset();
        let start = &mut self.job.options.start;
        (start.g5x, start.g92, start.tlo) = (told.g5x, told.g92, told.tlo);
        (start.g28, start.g30) = (told.g28, told.g30);
        // The report has the last word over the list of offsets.
        let mut as_told = told;
        as_told.work_offset = active.unwrap_or(usize::MAX);
        let differs = zero - as_told.offset();
        let explained = active.is_some() && differs.norm() < MOVED;
        if !explained {
            if active != Some(start.work_offset) {
                return self.unwatched("its work offsets do not add up");
            }
            if let Some(origin) = start.g5x.get_mut(start.work_offset) {
                *origin += differs;
            }
        }
        start.set_machine_position(&place);
        let steps = std::array::from_fn(|i| known.setting(100 + i as u16));
        let options = WatchOptions::of(steps, known.blocks);
        self.watch = Some(Watch::new(place, options));
    }

    fn unwatched(&mut self, why: &str) {
        self.watch = None;
        self.note(&format!(
            "{why}: whether the machine keeps to the program's way is not watched"
        ));
    }

    /// The lines before the program's, with their ways.
    pub(super) fn entry(&mut self) -> Result<(), Unreadable> {
        let mut preparer = Preparer::new(&self.job.options);
        for text in &self.job.options.entry {
            let line = preparer
                .prepare(text, 0, &mut |_| {})
                .map_err(|e| Unreadable::Impossible(Box::new(e)))?;
            if let Some(line) = line {
                let place = preparer.state().machine_position();
                self.own.push_back(Upcoming {
                    line,
                    way: way(preparer.events(), &place, self.arc_tolerance()),
                    ends_anywhere: false,
                });
            }
        }
        Ok(())
    }

    /// The program's next line. Nothing is read while the machine stands nobody knows where.
    pub(super) fn read_on(&mut self) -> Result<Option<Upcoming>, Unreadable> {
        let tolerance = self.arc_tolerance();
        let Some(lines) = &mut self.lines else {
            return Ok(None);
        };
        Ok(lines.next_line()?.map(|line| Upcoming {
            way: way(lines.events(), &lines.state().machine_position(), tolerance),
            ends_anywhere: ends_anywhere(&line, lines),
            line,
        }))
    }

    fn arc_tolerance(&self) -> Mm {
        let told = self.known.setting(12);
        Mm(told
            .filter(|t| (5e-4..0.5).contains(t))
            .unwrap_or(ARC_TOLERANCE))
    }

    /// This line goes out.
    pub(super) fn goes_out(&mut self, upcoming: &Upcoming) {
        if let Some(watch) = &mut self.watch
            && !upcoming.way.is_empty()
        {
            watch.sent(upcoming.line.source, upcoming.way.iter().copied());
        }
        if upcoming.ends_anywhere {
            self.look = Look::Due;
        }
    }

    /// This line of the program was answered.
    pub(super) fn is_past(&mut self, line: &JobLine) {
        if let Some(watch) = &mut self.watch {
            watch.answered(line.source);
        }
        // At a tool change the operator's resume comes first.
        if self.look == Look::Due && self.stream.is_empty() && line.prompt.is_none() {
            self.look_now(false);
        }
    }

    /// Where does the machine stand?
    pub(super) fn look_now(&mut self, zero: bool) {
        self.look = Look::Now { zero, reports: 0 };
        self.off_reports = 0;
    }

    /// A report came: the answer to a look, or a place to hold against the way.
    pub(super) fn place_told(&mut self, status: &Status, now: Duration) {
        if self.phase != Phase::Streaming {
            return;
        }
        let told = status.position.is_some();
        match self.look {
            Look::Now { zero, reports } => {
                if status.state != State::Idle {
                    return;
                }
                let reports = reports + 1;
                let all = told && (!zero || status.work_offset.is_some());
                if all || reports >= OFFSET_REPORTS {
                    self.looked(zero);
                } else {
                    self.look = Look::Now { zero, reports };
                }
            }
            _ if !told || self.prompt_told => {}
            // A door may park the tool elsewhere; other states are none of the program's.
            _ if matches!(status.state, State::Run | State::Idle | State::Hold { .. }) => {
                self.compare_place(now);
            }
            _ => {}
        }
    }

    fn looked(&mut self, zero: bool) {
        self.look = Look::No;
        let Some(place) = self.known.machine_position.map(Point::from) else {
            self.unwatched("the controller does not tell where it stands");
            return self.behind_a_change(zero);
        };
        let work_zero = self
            .known
            .work_offset
            .map(Vector::from)
            .filter(|_| zero && self.watch.is_some());
        if let Some(lines) = &mut self.lines {
            let left = lines.state().machine_position();
            lines.stands_at(&place, work_zero);
            let by = (place - left).norm();
            if zero && by > MOVED && self.watch.is_some() {
                self.note(&format!(
                    "the machine stands {by:.2} mm from where the tool was changed, at machine X{:.3} Y{:.3} Z{:.3}: the program goes on from here",
                    place.x, place.y, place.z
                ));
            }
        }
        if let Some(watch) = &mut self.watch {
            watch.stands_at(place);
        }
        self.behind_a_change(zero);
    }

    /// Behind a tool change the program's modes have to hold again.
    fn behind_a_change(&mut self, tool: bool) {
        if tool {
            self.restore_modes();
        }
    }

    fn compare_place(&mut self, now: Duration) {
        let (Some(watch), Some(place)) = (&self.watch, self.known.machine_position) else {
            return;
        };
        let Err(off) = watch.report(Point::from(place)) else {
            self.off_reports = 0;
            return;
        };
        self.off_reports += 1;
        if self.off_reports >= OFF_REPORTS {
            let why = "the machine is not where the lines it was sent lead";
            return self.stop(Ending::OffPath(off), why, now);
        }
        // Soon again: it may have been the report that was damaged.
        if !self.stream.writes_memory() && now >= self.quiet_until {
            self.realtime(Realtime::Status);
            (self.asked, self.last_asked) = (Some(now), now);
        }
    }

    /// Where the program ends by all that was sent, work coordinates as they are now, mm.
    pub(super) fn end_of_way(&self) -> Option<[f64; 3]> {
        let (end, zero) = (self.watch.as_ref()?.end(), self.known.work_offset?);
        Some(std::array::from_fn(|i| end[i] - zero[i]))
    }
}

/// Where a line's motions lead, machine coordinates; `stands`: where the machine stands behind it. A change of work offset comes
/// before the motions of its line, and the end of a program's, which goes back to G54, behind them: what they have in common is the place
/// at the end.
fn way(events: &[Event], stands: &Point, arc_tolerance: Mm) -> Vec<Point> {
    let motions = || {
        events.iter().filter_map(|event| match event {
            Event::Motion(m) => Some(m),
            Event::Probe { motion, .. } => Some(motion),
            _ => None,
        })
    };
    let Some(last) = motions().last() else {
        return Vec::new();
    };
    let shift = stands - last.to;
    let mut places = Vec::new();
    for m in motions() {
        match &m.arc {
            None => places.push(m.to + shift),
            Some(arc) => {
                places.extend(chords(&m.from, &m.to, arc, arc_tolerance).map(|p| p + shift));
            }
        }
    }
    places
}

fn ends_anywhere(line: &JobLine, lines: &JobLines) -> bool {
    let changes_tool = line
        .prompt
        .as_ref()
        .is_some_and(|p| matches!(p.kind, PromptKind::ToolChange { .. }));
    let probes = lines
        .events()
        .iter()
        .any(|e| matches!(e, Event::Probe { .. }));
    changes_tool || probes || line.text.starts_with('$')
}
