//! What is known of a controller, and what it remembers, in the interpreter's terms.

use crate::gcode::{Dialect, Distance, FeedMode, MotionMode, Plane, State as Parser, Units};
use crate::geom::{Point, Vector};
use crate::units::{MmPerMin, Rpm};
use crate::wire::{Firmware, Modes, Position, State, Status};
use std::time::Duration;

/// Offsets as `$#` tells them, mm. Machine coordinates but for `g92`, which is a difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offsets {
    /// Origins of G54 to G59.
    pub g5x: [Option<[f64; 3]>; 6],
    /// Stored by G28.1.
    pub g28: Option<[f64; 3]>,
    /// Stored by G30.1.
    pub g30: Option<[f64; 3]>,
    /// G92.
    pub g92: Option<[f64; 3]>,
    /// Tool length along Z.
    pub tlo: Option<f64>,
    /// Last probing: where, and whether it touched.
    pub probe: Option<([f64; 3], bool)>,
}

/// What is known of a controller. Lengths mm, positions in machine coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// `[VER:...]`, or the greeting when `$I` does not say.
    pub version: String,
    /// Whose rules hold.
    pub firmware: Firmware,
    /// Bytes of receive buffer to count with.
    pub rx_bytes: usize,
    /// Planner blocks, if told.
    pub blocks: Option<usize>,
    /// Build letters of `[OPT:...]`.
    pub letters: String,
    /// `$n=value`, ascending as sent; values that are no number are left out. Never in inch.
    pub settings: Vec<(u16, f64)>,
    /// `$#`.
    pub offsets: Offsets,
    /// `$G`.
    pub modes: Modes,
    /// `$13=1`: reports, `$#` and F of `$G` come in inch (everything here was converted).
    pub inches: bool,
    /// State in the last report.
    pub state: State,
    /// The N of an `ALARM:N` heard meanwhile.
    pub alarm: Option<u16>,
    /// Where the machine stands.
    pub machine_position: Option<[f64; 3]>,
    /// Machine zero to work zero, as reported, else as `$#` and `$G` make it.
    pub work_offset: Option<[f64; 3]>,
    /// `H:1` or `H:0` of a grblHAL report; GRBL does not tell. `Some(false)` too for a machine that homes ($22=1) and is locked.
    pub homed: Option<bool>,
    /// Questions that were refused, with the N of `error:N`.
    pub refused: Vec<(&'static str, u16)>,
    /// The longest time from one of the questions to the first line of its answer: how old news from the controller may be.
    pub round_trip: Duration,
}

impl Known {
    pub(super) fn new(rx_bytes: usize) -> Known {
        Known {
            version: String::new(),
            firmware: Firmware::Unknown,
            rx_bytes,
            blocks: None,
            letters: String::new(),
            settings: Vec::new(),
            offsets: Offsets::default(),
            modes: Modes::default(),
            inches: false,
            state: State::Other("unknown".to_string()),
            alarm: None,
            machine_position: None,
            work_offset: None,
            homed: None,
            refused: Vec::new(),
            round_trip: Duration::ZERO,
        }
    }

    /// The value of `$number`.
    pub fn setting(&self, number: u16) -> Option<f64> {
        self.settings.iter().find(|s| s.0 == number).map(|s| s.1)
    }

    /// Where the tool is in the active work system, mm.
    pub fn work_position(&self) -> Option<[f64; 3]> {
        let (p, o) = (self.machine_position?, self.work_offset?);
        Some([p[0] - o[0], p[1] - o[1], p[2] - o[2]])
    }

    /// The dialect this firmware reads.
    pub fn dialect(&self) -> Dialect {
        match self.firmware {
            Firmware::GrblHal => Dialect::GrblHal,
            Firmware::FluidNc => Dialect::FluidNc,
            Firmware::Grbl11 | Firmware::Unknown => Dialect::Grbl,
        }
    }

    /// What the controller remembers at the start of a job that sets its modes: start-up modes and G54, no feed, but its offsets
    /// and its position.
    pub fn start(&self) -> Parser {
        let mut parser = Parser::new(self.dialect());
        let vector = |v: Option<[f64; 3]>| v.map(Vector::from).unwrap_or_default();
        parser.g5x = self.offsets.g5x.map(vector);
        parser.g92 = vector(self.offsets.g92);
        parser.tlo = self.offsets.tlo.unwrap_or(0.0);
        parser.g28 = Point::from(vector(self.offsets.g28));
        parser.g30 = Point::from(vector(self.offsets.g30));
        parser.set_machine_position(&Point::from(self.machine_position.unwrap_or_default()));
        parser
    }

    /// What the controller remembers now: [`Known::start`] with the modes that `$G` told.
    pub fn parser(&self) -> Parser {
        let mut parser = self.start();
        let has = |word: &str| self.modes.has(word);
        for (word, motion) in [
            ("G1", MotionMode::Linear),
            ("G2", MotionMode::ArcClockwise),
            ("G3", MotionMode::ArcCounterclockwise),
            ("G80", MotionMode::None),
        ] {
            if has(word) {
                parser.motion = motion;
            }
        }
        for (word, plane) in [("G18", Plane::Zx), ("G19", Plane::Yz)] {
            if has(word) {
                parser.plane = plane;
            }
        }
        if has("G20") {
            parser.units = Units::Inch;
        }
        if has("G91") {
            parser.distance = Distance::Incremental;
        }
        if has("G93") {
            parser.feed_mode = FeedMode::InverseTime;
        }
        parser.spindle = i8::from(has("M3")) - i8::from(has("M4"));
        (parser.flood, parser.mist) = (has("M8"), has("M7"));
        let unit = if self.inches { 25.4 } else { 1.0 };
        parser.feed = MmPerMin(self.modes.value('F').unwrap_or(0.0) * unit);
        parser.speed = Rpm(self.modes.value('S').unwrap_or(0.0));
        parser.work_offset = self.modes.work_offset().unwrap_or(0);
        parser.set_machine_position(&Point::from(self.machine_position.unwrap_or_default()));
        parser
    }

    /// Takes in a report: state, position, offset.
    pub fn hear(&mut self, status: &Status) {
        let unit = if self.inches { 25.4 } else { 1.0 };
        self.state = status.state.clone();
        if let Some(offset) = status.work_offset {
            self.work_offset = Some(offset.map(|c| c * unit));
        }
        match (status.position, self.work_offset) {
            (Some(Position::Machine(p)), _) => self.machine_position = Some(p.map(|c| c * unit)),
            (Some(Position::Work(p)), Some(o)) => {
                self.machine_position = Some(std::array::from_fn(|i| p[i] * unit + o[i]));
            }
            _ => {}
        }
        if status.homed.is_some() {
            self.homed = status.homed;
        }
    }
}
