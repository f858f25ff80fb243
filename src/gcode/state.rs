//! What the machine remembers from line to line: modes, offsets, where it stands.
//!
//! Frames: *work* coordinates are what the program writes, *machine* coordinates what the axes count:
//!
//! ```text
//! machine = work + G5x (active) + G92 + (0, 0, TLO)
//! ```
//!
//! All in mm. Changing an offset moves nothing: the machine position stays and the work position changes.

use super::cycle::{Cycle, Series};
use super::dialect::Dialect;
use super::event::Plane;
use crate::geom::{Point, Vector};
use crate::units::{MmPerMin, Rpm};

/// What a line of axis words does (modal group 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionMode {
    /// G0.
    Rapid,
    /// G1.
    Linear,
    /// G2.
    ArcClockwise,
    /// G3.
    ArcCounterclockwise,
    /// G38.2 to G38.5.
    Probe(Probe),
    /// G73, G81 to G89.
    Cycle(Cycle),
    /// G80.
    None,
}

/// Which way a probe move looks, and what a miss means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    /// G38.4, G38.5: move until contact is lost, rather than until it is made.
    pub away: bool,
    /// G38.2, G38.4: a miss is an alarm.
    pub strict: bool,
}

/// G90 or G91.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// G90.
    Absolute,
    /// G91.
    Incremental,
}

/// G98 or G99: where a drilling cycle leaves the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Retract {
    /// G98: on the level that the series of cycles started from.
    Initial,
    /// G99: on the R level.
    R,
}

/// G93, G94 or G95.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedMode {
    /// G94: F is a speed.
    PerMinute,
    /// G93: F is the reciprocal of the minutes that the block takes, and must stand in every cutting block.
    InverseTime,
    /// G95: F is a way per turn of the spindle.
    PerTurn,
}

/// G20 or G21.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// G21.
    Mm,
    /// G20.
    Inch,
}

impl Units {
    /// Millimetres in one unit.
    pub fn mm(self) -> f64 {
        match self {
            Units::Mm => 1.0,
            Units::Inch => 25.4,
        }
    }
}

/// How corners are taken (LinuxCNC; GRBL knows G61 only and does the same whatever is said).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMode {
    /// G61.
    ExactPath,
    /// G61.1.
    ExactStop,
    /// G64, with the tolerance of its P word in mm.
    Blend {
        /// How far the path may be left, mm; `None`: as the machine likes.
        tolerance: Option<f64>,
    },
}

/// Modes, offsets, position. Arrays are X, Y, Z; lengths mm.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Whose rules hold.
    pub dialect: Dialect,
    /// G0 to G3, G38.x, G80.
    pub motion: MotionMode,
    /// G17, G18, G19.
    pub plane: Plane,
    /// G90, G91.
    pub distance: Distance,
    /// G90.1 (absolute arc centres, LinuxCNC) or G91.1.
    pub arc_distance: Distance,
    /// G93, G94.
    pub feed_mode: FeedMode,
    /// G20, G21.
    pub units: Units,
    /// G61, G64.
    pub path: PathMode,
    /// Active work offset: 0 is G54, 5 is G59, from 6 on the dialect's further ones (G59.1, G54.1 P1, G110).
    pub work_offset: usize,
    /// 1 clockwise (M3), -1 counter-clockwise (M4), 0 stopped (M5).
    pub spindle: i8,
    /// M8.
    pub flood: bool,
    /// M7.
    pub mist: bool,
    /// GRBL: the T word of the last block, 0 when it had none. LinuxCNC: the tool chosen for the next M6.
    pub tool: u32,
    /// F: mm/min in G94, 1/min in G93; zero means not set.
    pub feed: MmPerMin,
    /// S.
    pub speed: Rpm,
    /// Where the program has the tool, work coordinates of the active system.
    pub position: Point,
    /// Origins of G54 to G59 in machine coordinates.
    pub g5x: [Vector; 6],
    /// The G92 offset.
    pub g92: Vector,
    /// Tool length offset along Z (G43.1).
    pub tlo: f64,
    /// LinuxCNC: G43 H is active with this tool-table entry. The table's length is not known here: the program's Z is taken for
    /// the tool tip and `tlo` stays as it is.
    pub tool_length: Option<u32>,
    /// The place stored by G28.1, machine coordinates.
    pub g28: Point,
    /// The place stored by G30.1, machine coordinates.
    pub g30: Point,
    /// LinuxCNC: the operator's block-delete switch is on, and lines that begin with `/` are skipped. GRBL has none.
    pub block_delete: bool,
    /// Origins of the work offsets from 6 on; those not there are zero.
    pub further: Vec<Vector>,
    /// G98, G99.
    pub retract: Retract,
    /// The series of drilling cycles in force.
    pub series: Option<Series>,
    /// Speed of rapids where a dialect has F for them (Smoothieware); zero: as fast as the machine goes.
    pub rapid_feed: MmPerMin,
    /// `g92` was set by G52.
    pub local: bool,
    /// What G92.3 brings back.
    pub g92_kept: Vector,
    /// Numbers are taken in GRBL's single precision, digit by digit: the simulated controller counts steps to the last one.
    pub single: bool,
}

impl State {
    /// A machine just switched on, at machine zero with all offsets zero: G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0.
    pub fn new(dialect: Dialect) -> State {
        State {
            dialect,
            motion: MotionMode::Rapid,
            plane: Plane::Xy,
            distance: Distance::Absolute,
            arc_distance: Distance::Incremental,
            feed_mode: FeedMode::PerMinute,
            units: Units::Mm,
            path: match dialect {
                Dialect::Grbl | Dialect::GrblHal | Dialect::FluidNc | Dialect::Carbide => {
                    PathMode::ExactPath
                }
                _ => PathMode::Blend { tolerance: None },
            },
            work_offset: 0,
            spindle: 0,
            flood: false,
            mist: false,
            tool: 0,
            feed: MmPerMin(0.0),
            speed: Rpm(0.0),
            position: Point::origin(),
            g5x: [Vector::zeros(); 6],
            g92: Vector::zeros(),
            tlo: 0.0,
            tool_length: None,
            g28: Point::origin(),
            g30: Point::origin(),
            block_delete: false,
            further: Vec::new(),
            retract: Retract::Initial,
            series: None,
            rapid_feed: MmPerMin(0.0),
            local: false,
            g92_kept: Vector::zeros(),
            single: false,
        }
    }

    /// What a soft reset leaves: start-up modes, no G92 and no tool length; machine position, G54 to G59, G28 and G30 stay.
    pub fn reset(&mut self) {
        let machine = self.machine_position();
        let mut fresh = State::new(self.dialect);
        (fresh.g5x, fresh.g28, fresh.g30) = (self.g5x, self.g28, self.g30);
        fresh.block_delete = self.block_delete;
        fresh.single = self.single;
        fresh.further = std::mem::take(&mut self.further);
        *self = fresh;
        self.set_machine_position(&machine);
    }

    /// Machine zero to work zero: G5x + G92 + TLO (GRBL's WCO).
    pub fn offset(&self) -> Vector {
        self.offset_of(self.work_offset, self.tlo)
    }

    /// The same with another work offset and tool length.
    pub(super) fn offset_of(&self, work_offset: usize, tlo: f64) -> Vector {
        self.origin_of(work_offset) + self.g92 + Vector::new(0.0, 0.0, tlo)
    }

    /// Origin of a work offset, machine coordinates less G92 and tool length.
    pub(super) fn origin_of(&self, work_offset: usize) -> Vector {
        let further = || self.further.get(work_offset.wrapping_sub(6));
        let origin = self.g5x.get(work_offset).or_else(further);
        origin.copied().unwrap_or_default()
    }

    /// Sets the origin of a work offset.
    pub(super) fn set_origin(&mut self, work_offset: usize, origin: Vector) {
        if let Some(g5x) = self.g5x.get_mut(work_offset) {
            *g5x = origin;
            return;
        }
        let at = work_offset - self.g5x.len();
        if self.further.len() <= at {
            self.further.resize(at + 1, Vector::zeros());
        }
        if let Some(further) = self.further.get_mut(at) {
            *further = origin;
        }
    }

    /// A work position in machine coordinates.
    pub fn machine_of_work(&self, work: &Point) -> Point {
        work + self.offset()
    }

    /// A machine position in work coordinates of the active system.
    pub fn work_of_machine(&self, machine: &Point) -> Point {
        machine - self.offset()
    }

    /// Where the tool is, machine coordinates.
    pub fn machine_position(&self) -> Point {
        self.machine_of_work(&self.position)
    }

    /// Takes note that the machine stands elsewhere (after homing, probing, a cancelled jog, a reset).
    pub fn set_machine_position(&mut self, machine: &Point) {
        self.position = self.work_of_machine(machine);
    }
}
