//! Telling the machine: what a line does to the state, with the events that come of it.
//!
//! Crosses the border: mm, mm/min, work coordinates. Events of spindle and coolant are made on a change only, as everywhere in `gcode`.

use super::super::event::{Arc, Event, Motion, MotionKind};
use super::super::state::{FeedMode, State};
use crate::geom::Point;
use crate::units::{MmPerMin, Rpm, Seconds};

/// A line at work. The state is a copy: it is put back by the language when the whole line was sound.
#[derive(Debug)]
pub(in crate::gcode) struct Desk<'a> {
    /// What the machine remembers, as this line changes it.
    pub state: State,
    /// Where events go.
    pub events: &'a mut Vec<Event>,
    /// The line's number.
    pub line: usize,
}

impl Desk<'_> {
    /// Spindle direction and speed.
    pub fn spindle(&mut self, direction: i8, speed: Rpm) {
        let state = &mut self.state;
        let new = direction != state.spindle || (direction != 0 && speed != state.speed);
        (state.spindle, state.speed) = (direction, speed);
        if new {
            let line = self.line;
            self.events.push(Event::Spindle {
                direction,
                speed,
                line,
            });
        }
    }

    /// Coolant.
    pub fn coolant(&mut self, flood: bool, mist: bool) {
        let state = &mut self.state;
        if (flood, mist) != (state.flood, state.mist) {
            (state.flood, state.mist) = (flood, mist);
            let line = self.line;
            self.events.push(Event::Coolant { flood, mist, line });
        }
    }

    /// Another tool. The spindle stops for it.
    pub fn tool(&mut self, tool: u32) {
        self.state.tool = tool;
        self.state.spindle = 0;
        let line = self.line;
        self.events.push(Event::ToolChange { tool, line });
    }

    /// Stand still; nothing for no time.
    pub fn dwell(&mut self, seconds: f64) {
        if seconds > 0.0 {
            let (time, line) = (Seconds(seconds), self.line);
            self.events.push(Event::Dwell { time, line });
        }
    }

    /// Wait for the operator.
    pub fn pause(&mut self, optional: bool) {
        let line = self.line;
        self.events.push(Event::Pause { optional, line });
    }

    /// Wait for standstill.
    pub fn sync(&mut self) {
        let line = self.line;
        self.events.push(Event::Sync { line });
    }

    /// The program's end: spindle and coolant stop with it.
    pub fn end(&mut self) {
        let line = self.line;
        self.events.push(Event::End { line });
        let state = &mut self.state;
        (state.spindle, state.flood, state.mist) = (0, false, false);
    }

    /// Another work offset: the machine stays, the work position changes. Index as in [`State::work_offset`].
    pub fn work_offset(&mut self, index: usize) {
        if index != self.state.work_offset {
            let machine = self.state.machine_position();
            self.state.work_offset = index;
            self.state.set_machine_position(&machine);
            self.sync();
        }
    }

    /// Rapid in a straight line to a place in work coordinates; `machine`: it was named in machine coordinates.
    pub fn rapid(&mut self, to: Point, machine: bool) {
        let feed = self.state.feed;
        self.motion(MotionKind::Rapid, to, None, feed, machine);
    }

    /// A cut to a place in work coordinates.
    pub fn cut(&mut self, to: Point, arc: Option<Arc>, feed: MmPerMin, machine: bool) {
        self.motion(MotionKind::Feed, to, arc, feed, machine);
    }

    fn motion(
        &mut self,
        kind: MotionKind,
        to: Point,
        arc: Option<Arc>,
        feed: MmPerMin,
        machine_coordinates: bool,
    ) {
        let from = std::mem::replace(&mut self.state.position, to);
        self.events.push(Event::Motion(Motion {
            kind,
            from,
            to,
            arc,
            feed,
            inverse_time: self.state.feed_mode == FeedMode::InverseTime,
            machine_coordinates,
            line: self.line,
        }));
    }
}
