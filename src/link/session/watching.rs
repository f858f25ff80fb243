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
use crate::link::job::{JobLine, Unreadable};
use crate::link::outcome::Ending;
use crate::link::progress::PromptKind;
use crate::link::stream::Flight;
use crate::link::vet::Preparer;
use crate::link::watch::{Watch, WatchOptions};
use crate::units::Mm;
use crate::wire::{Position, Realtime, State, Status};
use std::time::Duration;

/// So many reports in a row must lie off the way: one may itself have been damaged.
const OFF_REPORTS: u32 = 2;
/// Reports waited for that name the work offset: GRBL does in every tenth of an idle machine.
const OFFSET_REPORTS: u32 = 12;
/// A place that differs by more, mm, is told.
const MOVED: f64 = 0.02;
/// Reports are rounded by this, mm (four decimals of an inch).
const REPORTED: f64 = 0.0015;
/// GRBL's `$12`, where the controller does not tell one that can be, mm.
const ARC_TOLERANCE: f64 = 0.002;

/// A line that waits to be sent, and where it leads.
#[derive(Debug)]
pub(super) struct Upcoming {
    pub line: JobLine,
    /// Machine coordinates, mm.
    pub way: Vec<Point>,
    /// Only the machine knows where it stands behind it, or by which zero it moves.
    pub ends_anywhere: Option<Why>,
    /// The machine was brought to rest for it.
    pub settled: bool,
}

impl From<JobLine> for Upcoming {
    /// A line that moves nothing.
    fn from(line: JobLine) -> Upcoming {
        Upcoming {
            line,
            way: Vec::new(),
            ends_anywhere: None,
            settled: false,
        }
    }
}

/// What a look has to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Why {
    /// Where the machine stands.
    Place,
    /// That, and where the active work zero lies: a system was chosen whose zero may have been set anew at a tool change.
    Zero,
    /// The same behind a tool change.
    Change,
}

/// Whether the session has to look where the machine stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// The text tells.
    No,
    /// A line is under way behind which it has to.
    Due(Why),
    /// Now.
    Now {
        /// What for.
        why: Why,
        /// Since then.
        since: Duration,
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
                    ends_anywhere: None,
                    settled: false,
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
        let Some(line) = lines.next_line()? else {
            return Ok(None);
        };
        let state = lines.state();
        let chosen = 1u16.checked_shl(state.work_offset as u32).unwrap_or(0);
        let ends_anywhere = if self.zeros_known & chosen == 0 {
            Some(Why::Zero)
        } else {
            ends_anywhere(&line, lines.events())
        };
        let way = way(lines.events(), &state.machine_position(), tolerance);
        Ok(Some(Upcoming {
            // By a zero that nobody knows, nobody knows the way.
            way: if ends_anywhere == Some(Why::Zero) {
                Vec::new()
            } else {
                way
            },
            ends_anywhere,
            settled: false,
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
        if let Some(why) = upcoming.ends_anywhere {
            self.look = Look::Due(why);
        }
    }

    /// This line of the program was answered.
    pub(super) fn is_past(&mut self, line: &JobLine, now: Duration) {
        if let Some(watch) = &mut self.watch {
            watch.answered(line.source);
        }
        // At a tool change the operator's resume comes first.
        if let Look::Due(why) = self.look
            && why != Why::Change
            && self.stream.is_empty()
        {
            self.look_now(why, now);
        }
    }

    /// Where does the machine stand?
    pub(super) fn look_now(&mut self, why: Why, now: Duration) {
        let (since, reports) = (now, 0);
        self.look = Look::Now {
            why,
            since,
            reports,
        };
        self.off_reports = 0;
    }

    /// A report came: the answer to a look, or a place to hold against the way.
    pub(super) fn place_told(&mut self, status: &Status, now: Duration) {
        if self.phase != Phase::Streaming {
            return;
        }
        let told = status.position.is_some() && self.places(status);
        match self.look {
            Look::Now {
                why,
                since,
                reports,
            } => {
                // What was answered is behind us in every report that follows; what an operator did is not.
                let stale = why == Why::Change && !self.reports_know_of(since, now);
                if status.state != State::Idle || stale {
                    return;
                }
                let reports = reports + 1;
                let all = told && (why == Why::Place || status.work_offset.is_some());
                if all || reports >= OFFSET_REPORTS {
                    self.looked(why);
                } else {
                    self.look = Look::Now {
                        why,
                        since,
                        reports,
                    };
                }
            }
            _ if !told || self.prompt_told || self.look == Look::Due(Why::Zero) => {}
            // A door may park the tool elsewhere; other states are none of the program's.
            _ if matches!(status.state, State::Run | State::Idle | State::Hold { .. }) => {
                self.compare_place(now);
            }
            _ => {}
        }
    }

    /// This report's position can be placed. GRBL takes on a new work offset before the motion ahead of it has ended, and reports work
    /// positions ($10=0) by it, but names it only behind the line's answer.
    pub(super) fn places(&self, status: &Status) -> bool {
        let by_work = matches!(status.position, Some(Position::Work(_)));
        let changes = |f: &Flight| f.line.weight.changes_frame;
        !(by_work && status.work_offset.is_none() && self.stream.unanswered().any(changes))
    }

    fn looked(&mut self, why: Why) {
        self.look = Look::No;
        let change = why == Why::Change;
        let Some(place) = self.known.machine_position.map(Point::from) else {
            self.unwatched("the controller does not tell where it stands");
            return self.behind_a_change(change);
        };
        let work_zero = self
            .known
            .work_offset
            .map(Vector::from)
            .filter(|_| why != Why::Place && self.watch.is_some());
        let step = |i: usize| {
            let steps = self.known.setting(100 + i as u16);
            steps.filter(|s| *s > 0.0).map_or(0.0, f64::recip)
        };
        let steps: [f64; 3] = std::array::from_fn(step);
        if let Some(lines) = &mut self.lines {
            let left = lines.state().machine_position();
            let by = (place - left).norm();
            // A report tells whole steps. A machine that was not moved goes on from where its line really ended, to the last digit: the
            // arc that begins there may be a whole turn, or none.
            let moved = (0..3).any(|i| (place[i] - left[i]).abs() > 0.5 * steps[i] + REPORTED);
            lines.stands_at(if moved { &place } else { &left }, work_zero);
            let active = 1u16
                .checked_shl(lines.state().work_offset as u32)
                .unwrap_or(0);
            match why {
                Why::Place => {}
                Why::Zero => self.zeros_known |= active,
                // The others may have been set anew with it.
                Why::Change => self.zeros_known = active,
            }
            if change && by > MOVED && self.watch.is_some() {
                self.note(&format!(
                    "the machine stands {by:.2} mm from where the tool was changed, at machine X{:.3} Y{:.3} Z{:.3}: the program goes on from here",
                    place.x, place.y, place.z
                ));
            }
        }
        if let Some(watch) = &mut self.watch {
            watch.stands_at(place);
        }
        self.behind_a_change(change);
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
    let Some(last) = motions().next_back() else {
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

fn ends_anywhere(line: &JobLine, events: &[Event]) -> Option<Why> {
    let changes_tool = line
        .prompt
        .as_ref()
        .is_some_and(|p| matches!(p.kind, PromptKind::ToolChange { .. }));
    let probes = events.iter().any(|e| matches!(e, Event::Probe { .. }));
    match () {
        () if changes_tool => Some(Why::Change),
        () if probes || line.text.starts_with('$') => Some(Why::Place),
        () => None,
    }
}
