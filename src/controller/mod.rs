//! A simulated GRBL 1.1h: bytes in, bytes out, on a clock you turn by hand.
//!
//! Crosses the border: bytes in [`crate::wire`]'s words, seconds of machine time, and a machine's figures. Inside, the one interpreter
//! (`gcode`) reads the lines; positions are machine coordinates in mm. It must never know `link`: the two meet on a byte pipe.
//! No real clock, no I/O (only [`pty`], its front, has both), no chance: the same bytes at the same times give the same answers.
//!
//! ```text
//!         arrive              lines              steps                 blocks, slices
//! bytes --------> intake ring -----> dispatch --------> waiting steps ---------------> motion
//!            \--> real-time flags          \--> $ commands
//! ```
//! What it keeps to: line intake, flow control, error numbers, states, resets, report cadence, planner and slice latency of the
//! firmware as shipped (Uno, no door pin, no line numbers, no M7). What it leaves out: limit and probe switches (a probe touches
//! nothing, homing always succeeds), lost bytes while settings are written, laser mode, the time the serial line takes.
//!
//! ```
//! use morsemill::controller::{Controller, Memory};
//!
//! let mut mill = Controller::new(Memory::default());
//! mill.feed(b"G1 X1 F60\n");
//! mill.advance(2.0);
//! mill.feed(b"?");
//! let said = String::from_utf8(mill.output()).unwrap();
//! assert!(said.ends_with("ok\r\n<Idle|MPos:1.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\r\n"));
//! ```

mod complaint;
mod dollar;
mod execute;
pub mod fault;
pub mod fault_plan;
pub mod front;
pub mod intake;
pub mod motion;
pub mod pins;
pub mod profile;
pub mod pty;
mod realtime;
pub mod rehearsal;
pub mod replay;
mod report;
pub mod rig;
pub mod script;
pub mod settings;
pub mod tcp;

pub use fault::{Faults, Side, Tally};
pub use fault_plan::{Deed, FaultError, FaultPlan, Noise, When};
pub use front::{Front, News, Pace, Readout};
pub use pins::{Pins, Switches};
pub use profile::{Profile, Quirks};
pub use pty::{Pty, PtyError};
pub use rehearsal::{Drive, Driven};
pub use rig::{Rig, RigOptions};
pub use script::Script;
pub use settings::Memory;
pub use tcp::{Guests, Tcp, TcpError};

use crate::gcode::{Dialect, State as Parser};
use crate::geom::Point;
use crate::kinematics::Overrides;
use crate::machine::Machine;
use execute::Step;
use intake::Intake;
use motion::Motion;
use std::collections::VecDeque;

/// What a build of the firmware has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Build {
    /// Usable blocks of look-ahead.
    pub blocks: usize,
    /// Bytes of receive buffer.
    pub rx_bytes: usize,
    /// Whose firmware.
    pub profile: Profile,
    /// Its oddities.
    pub quirks: Quirks,
}

impl Build {
    /// A firmware as shipped.
    pub fn of_profile(profile: Profile) -> Build {
        Build {
            blocks: 15,
            rx_bytes: profile.rx_bytes(),
            profile,
            quirks: Quirks::default(),
        }
    }
}

impl Default for Build {
    /// GRBL 1.1h on an Uno as shipped.
    fn default() -> Self {
        Build::of_profile(Profile::default())
    }
}

/// Moments closer than this are the same, s: far below anything the firmware can tell apart, far above f64 noise in hours of time.
const SAME_MOMENT: f64 = 1e-9;
/// Seconds the firmware is deaf after an alarm.
const DEAF: f64 = 0.5;

/// What the machine is in, beside what its axes do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Idle or Run.
    Normal,
    Jog,
    Home,
    Alarm,
    Check,
    Sleep,
}

/// Hold and door.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Suspend {
    None,
    Hold,
    Door,
    /// Door closed, spindle and coolant coming back until this time.
    DoorResuming(f64),
}

/// Behind the half second of deafness.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Deaf {
    No,
    /// Then go on.
    Until(f64),
    /// Then finish the reset that caused it.
    ThenRestart(f64),
}

/// Overrides in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Percent {
    feed: u16,
    rapid: u16,
    spindle: u16,
}

const NO_OVERRIDES: Percent = Percent {
    feed: 100,
    rapid: 100,
    spindle: 100,
};

/// The simulated controller. See the module for what it does and leaves out.
#[derive(Clone, Debug)]
pub struct Controller {
    build: Build,
    memory: Memory,
    parser: Parser,
    intake: Intake,
    flags: realtime::Flags,
    motion: Motion,
    steps: VecDeque<Step>,
    mode: Mode,
    suspend: Suspend,
    deaf: Deaf,
    /// ALARM:1 or 2: nothing but a reset helps.
    dead: bool,
    /// End of the wait that the current step is in (dwell, drain, homing).
    wait: Option<f64>,
    now: f64,
    out: Vec<u8>,
    percent: Percent,
    spindle: i8,
    rpm: f64,
    spindle_stopped: bool,
    /// WCO as reports show it: it lags behind the parser until the motion before has ended.
    offset: [f64; 3],
    probe: Point,
    probe_hit: bool,
    wco_in: u32,
    overrides_in: u32,
    first_motion: Option<f64>,
    last_motion: f64,
    soft_limit: bool,
    pins: Pins,
    switches: Switches,
}

impl Controller {
    /// A controller just switched on, at machine zero, with these settings, built as shipped.
    pub fn new(memory: Memory) -> Controller {
        Controller::with_build(memory, Build::default())
    }

    /// The controller of a machine, with its figures as settings.
    pub fn of_machine(machine: &Machine) -> Controller {
        let build = Build {
            blocks: machine.planner_blocks,
            rx_bytes: machine.rx_buffer,
            ..Build::default()
        };
        Controller::with_build(Memory::of_machine(machine), build)
    }

    /// A controller just switched on, at machine zero.
    pub fn with_build(memory: Memory, build: Build) -> Controller {
        let mut controller = Controller {
            motion: Motion::new(&memory.planner_settings(build.blocks), Point::origin()),
            build,
            memory,
            parser: Parser::new(Dialect::Grbl),
            intake: Intake::new(build.rx_bytes),
            flags: realtime::Flags::default(),
            steps: VecDeque::new(),
            mode: Mode::Normal,
            suspend: Suspend::None,
            deaf: Deaf::No,
            dead: false,
            wait: None,
            now: 0.0,
            out: Vec::new(),
            percent: NO_OVERRIDES,
            spindle: 0,
            rpm: 0.0,
            spindle_stopped: false,
            offset: [0.0; 3],
            probe: Point::origin(),
            probe_hit: false,
            wco_in: 0,
            overrides_in: 0,
            first_motion: None,
            last_motion: 0.0,
            soft_limit: false,
            pins: Pins::default(),
            switches: Switches::default(),
        };
        if controller.memory.is_on(22) {
            controller.mode = Mode::Alarm;
        }
        controller.restart();
        controller.work();
        controller
    }

    /// Off and on again: settings, stored offsets and places stay, all else is as new, at machine zero.
    pub fn power_cycle(&mut self) {
        let mut fresh = Controller::with_build(self.memory.clone(), self.build);
        (fresh.parser.g5x, fresh.parser.g28, fresh.parser.g30) =
            (self.parser.g5x, self.parser.g28, self.parser.g30);
        // Startup lines may name stored offsets, so they run once more with them.
        fresh.out.clear();
        fresh.steps.clear();
        fresh.parser.reset();
        fresh.restart();
        fresh.work();
        *self = fresh;
    }

    /// Bytes from the cable. They arrive at this moment of machine time, but one after the other: the main loop looks at real-time
    /// flags between them as often as it would at 115200 baud, so repeats are merged the way they are on the cable.
    pub fn feed(&mut self, bytes: &[u8]) {
        let mut busy_until = 0.0;
        for (index, &byte) in bytes.iter().enumerate() {
            let at = index as f64 + 1.0;
            if !self.flags.is_empty() && at > busy_until {
                busy_until = f64::max(busy_until, at - 1.0) + self.flags.bytes_to_serve();
                self.work();
            }
            if self.intake.free() == 0 {
                // The main loop empties the ring as it fills, unless a line holds it up.
                self.work();
            }
            match self.intake.arrive(byte) {
                Some(crate::wire::Realtime::Reset) => {
                    // What came before the reset was read before it; what comes with it is thrown away by it.
                    self.work();
                    if self.reset() {
                        for &late in bytes.get(index + 1..).unwrap_or_default() {
                            if let Some(command) = self.intake.arrive(late) {
                                self.flags.set(command);
                            }
                        }
                        self.intake.clear();
                        break;
                    }
                }
                Some(command) => {
                    let first = self.flags.is_empty();
                    self.flags.set(command);
                    if first && at > busy_until {
                        busy_until = at + self.flags.bytes_to_serve();
                        self.work();
                    }
                }
                None => {}
            }
        }
        self.work();
    }

    /// Holds the input pins so from now on.
    pub fn set_pins(&mut self, pins: Pins) {
        self.pins = pins;
        self.work();
    }

    /// The input pins as they were last set.
    pub fn pins(&self) -> Pins {
        self.pins
    }

    /// Mounts switches that the axes close by themselves.
    pub fn set_switches(&mut self, switches: Switches) {
        self.switches = switches;
        self.work();
    }

    /// What the build has.
    pub fn build(&self) -> Build {
        self.build
    }

    /// Lets machine time pass.
    pub fn advance(&mut self, seconds: f64) {
        let end = self.now + seconds.max(0.0);
        self.work();
        // Every change uses up a slice or a wait, so the clock cannot stand still for long; if it ever did, time would win.
        let mut standing = 0;
        while let Some(at) = self.next_change()
            && at <= end
            && standing < 1000
        {
            standing = if at > self.now { 0 } else { standing + 1 };
            self.pass(at - self.now);
            self.now = at;
            self.work();
        }
        self.pass(end - self.now);
        self.now = end;
        self.work();
    }

    /// What it said since the last call.
    pub fn output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// It has said something that was not taken yet.
    pub fn has_output(&self) -> bool {
        !self.out.is_empty()
    }

    /// Machine time since it was made, s.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Machine time of the next moment at which something changes by itself; `None` when everything rests.
    pub fn next_change(&self) -> Option<f64> {
        let axes = self.motion.next_change().map(|dt| self.now + dt);
        let deaf = match self.deaf {
            Deaf::No => None,
            Deaf::Until(t) | Deaf::ThenRestart(t) => Some(t),
        };
        // The deaf and the dead do not look at these.
        let awake = self.deaf == Deaf::No && !self.dead;
        let door = match self.suspend {
            Suspend::DoorResuming(t) if awake => Some(t),
            _ => None,
        };
        let wait = self.wait.filter(|_| awake && self.suspend == Suspend::None);
        [axes, deaf, door, wait]
            .into_iter()
            .flatten()
            .map(|t| t.max(self.now))
            .reduce(f64::min)
    }

    /// True while a line is being carried out and waits for the axes, a dwell or a reply pause: the host can do nothing about it but
    /// wait. False when it would read the next line if there were one, and in a hold, which only the host can end.
    pub fn is_busy(&self) -> bool {
        let stopping = self.suspend != Suspend::None && self.motion.going();
        let working = self.suspend == Suspend::None && !self.steps.is_empty();
        !self.dead && (stopping || working)
            || self.deaf != Deaf::No
            || matches!(self.suspend, Suspend::DoorResuming(_))
    }

    /// True while axes move or a queue waits to.
    pub fn is_moving(&self) -> bool {
        self.motion.going()
    }

    /// Machine position, mm.
    pub fn position(&self) -> Point {
        self.motion.position()
    }

    /// Machine time from the first motion since power-up to the last standstill (or to now, while moving), s.
    pub fn elapsed(&self) -> f64 {
        self.first_motion.map_or(0.0, |t| self.last_motion - t)
    }

    /// Bytes lost because more was sent than the receive ring holds. A sound sender keeps this at zero.
    pub fn bytes_lost(&self) -> usize {
        self.intake.lost()
    }

    /// Time without decisions.
    fn pass(&mut self, dt: f64) {
        if self.suspend != Suspend::None
            && let Some(t) = &mut self.wait
        {
            // A hold stops a dwell's clock.
            *t += dt;
        }
        if self.motion.moving() {
            self.first_motion.get_or_insert(self.now);
            self.last_motion = self.now + dt;
        }
        // Also for no time at all: a slice may be that short.
        self.motion.advance(dt);
    }

    fn say(&mut self, line: &str) {
        self.out.extend_from_slice(line.as_bytes());
        self.out.extend_from_slice(b"\r\n");
    }

    fn ok(&mut self) {
        self.say("ok");
    }

    fn error(&mut self, number: u16) {
        self.say(&format!("error:{number}"));
    }

    /// The soft reset. Returns false when it was swallowed.
    fn reset(&mut self) -> bool {
        match self.deaf {
            Deaf::No => {}
            Deaf::Until(_) if self.dead => return false,
            Deaf::Until(t) | Deaf::ThenRestart(t) => {
                self.deaf = Deaf::ThenRestart(t);
                return true;
            }
        }
        let homing = self.mode == Mode::Home;
        let moving = self.motion.going() || homing;
        self.motion.abort();
        if moving {
            self.mode = Mode::Alarm;
            self.suspend = Suspend::None;
            self.say(if homing { "ALARM:6" } else { "ALARM:3" });
            self.deaf = Deaf::ThenRestart(self.now + DEAF);
        } else {
            self.finish_reset();
        }
        true
    }

    /// The part of a reset behind any alarm: greeting, startup lines.
    fn finish_reset(&mut self) {
        self.deaf = Deaf::No;
        // The line that was being carried out lets go of its answer.
        if self.steps.iter().any(|s| matches!(s, Step::Ok))
            && (self.mode == Mode::Alarm || self.dead)
        {
            self.ok();
        }
        if self.dead || self.mode == Mode::Sleep {
            self.mode = Mode::Alarm;
        }
        if self.mode != Mode::Alarm {
            self.mode = Mode::Normal;
        }
        let here = self.motion.position();
        self.motion.abort();
        self.motion.set_overrides(Overrides {
            feed: 1.0,
            rapid: 1.0,
        });
        self.parser.reset();
        self.parser.set_machine_position(&here);
        self.intake.clear();
        self.flags = realtime::Flags::default();
        self.steps.clear();
        self.suspend = Suspend::None;
        self.wait = None;
        self.dead = false;
        self.soft_limit = false;
        self.percent = NO_OVERRIDES;
        (self.spindle, self.rpm, self.spindle_stopped) = (0, 0.0, false);
        (self.probe, self.probe_hit) = (Point::origin(), false);
        self.restart();
    }

    fn restart(&mut self) {
        (self.wco_in, self.overrides_in) = (0, 0);
        self.refresh_offset();
        self.out.extend_from_slice(b"\r\n");
        self.say("Grbl 1.1h ['$' for help]");
        if self.mode == Mode::Alarm {
            self.say("[MSG:'$H'|'$X' to unlock]");
        } else {
            self.queue_startup_lines();
        }
    }

    /// ALARM:n: whatever ran is over.
    fn alarm(&mut self, number: u16) {
        self.say(&format!("ALARM:{number}"));
        self.mode = Mode::Alarm;
        self.deaf = Deaf::Until(self.now + DEAF);
        self.dead = number <= 2;
    }
}
