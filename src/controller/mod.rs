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
//! What it keeps to: line intake, flow control, error numbers, states, resets, report cadence, switches, homing, probing, planner and
//! slice latency of the firmware as shipped (Uno, no line numbers, no M7), and on a timed line the time that bytes and thinking take.
//! What it leaves out: of grblHAL and FluidNC all that a sender need not notice.
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

mod cable;
mod complaint;
mod dollar;
mod eeprom;
mod execute;
pub mod fault;
pub mod fault_plan;
pub mod front;
mod homing;
pub mod intake;
mod memory_text;
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
mod switches;
pub mod tcp;

pub use fault::{Faults, Side, Tally};
pub use fault_plan::{Deed, FaultError, FaultPlan, Noise, When};
pub use front::{Front, News, Pace, Readout};
pub use pins::{Pins, Switches};
pub use profile::{Options, Profile, Quirks};
pub use pty::{Pty, PtyError};
pub use rehearsal::{Drive, Driven};
pub use rig::{Rig, RigOptions};
pub use script::Script;
pub use settings::Memory;
pub use tcp::{Guests, Tcp, TcpError};

use crate::gcode::State as Parser;
use crate::geom::{Point, Vector};
use crate::kinematics::Overrides;
use crate::machine::Machine;
use cable::Cable;
use execute::Step;
use homing::Homing;
use intake::{Intake, Line};
use motion::{Beam, Motion};
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
    /// What its maker chose.
    pub options: Options,
    /// Bits a second of the serial line and with it the time the firmware takes to think; `None`: neither takes any time.
    pub baud: Option<u32>,
}

impl Build {
    /// A firmware as shipped.
    pub fn of_profile(profile: Profile) -> Build {
        Build {
            blocks: 15,
            rx_bytes: profile.rx_bytes(),
            profile,
            quirks: Quirks::default(),
            options: Options::default(),
            baud: None,
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
/// Seconds from the decision to start to the first step, on a machine that takes time to think. Fitted to recordings.
const START: f64 = 0.0014;
/// Seconds from a reset to the greeting, on such a machine: what is stored is read first.
const GREETING: f64 = 0.0105;
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
    /// Door closed, spindle and coolant coming back one after the other: so many looks at the flags are left of each wait.
    DoorResuming {
        spindle: u32,
        coolant: u32,
    },
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
    /// What is left of the dwell that is under way, looks at the flags.
    wait: Option<u32>,
    now: f64,
    /// grblHAL: the error that all further G-code gets.
    wall: Option<u16>,
    cable: Cable,
    /// The main loop thinks until then, and does nothing else.
    busy_until: f64,
    /// The line it thinks about.
    reading: Option<Line>,
    percent: Percent,
    spindle: i8,
    rpm: f64,
    spindle_stopped: bool,
    /// The spindle's direction before the line read last.
    parser_spindle: i8,
    /// A probe looks for the end of a contact.
    probe_away: bool,
    /// A report is being written until then: whoever asks meanwhile gets that one.
    reporting_until: f64,
    /// The door has not been dealt with before.
    door_until: f64,
    /// Behind an open door spindle and coolant have been turned off.
    door_done: bool,
    /// The coolant runs, unless a door stops it.
    flood: bool,
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
    /// Where the machine's zero was at power-up, machine coordinates, mm, with the sign turned: switches do not move.
    bench: Vector,
    /// Limit pins when last looked at.
    limits_seen: [bool; 3],
    /// Buttons when last looked at: hold, reset, cycle start, door.
    buttons_seen: [bool; 4],
    homing: Option<Homing>,
    /// What is said now is said when the restart is done.
    greeting: bool,
    writing: Option<eeprom::Write>,
    /// A probe is on its way and waits for this state of its pin.
    probing: Option<bool>,
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
        let mut controller = Controller::off(memory, build);
        controller.switch_on();
        controller
    }

    fn off(memory: Memory, build: Build) -> Controller {
        let mut parser = Parser::new(build.profile.dialect());
        // The firmwares of this family all count in single precision.
        parser.single = true;
        memory.recall(&mut parser);
        Controller {
            motion: Motion::new(&memory.planner_settings(build.blocks), Point::origin())
                .starting_after(if build.baud.is_some() { START } else { 0.0 }),
            build,
            memory,
            parser,
            intake: Intake::new(build.rx_bytes)
                .cutting(build.profile.cutting(&build.quirks, &build.options)),
            wall: None,
            flags: realtime::Flags::default(),
            steps: VecDeque::new(),
            mode: Mode::Normal,
            suspend: Suspend::None,
            deaf: Deaf::No,
            dead: false,
            wait: None,
            now: 0.0,
            cable: Cable::new(build.baud),
            busy_until: 0.0,
            reading: None,
            percent: NO_OVERRIDES,
            spindle: 0,
            rpm: 0.0,
            spindle_stopped: false,
            parser_spindle: 0,
            probe_away: false,
            reporting_until: 0.0,
            door_until: 0.0,
            door_done: false,
            flood: false,
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
            bench: Vector::zeros(),
            limits_seen: [false; 3],
            buttons_seen: [false; 4],
            homing: None,
            greeting: false,
            writing: None,
            probing: None,
        }
    }

    fn switch_on(&mut self) {
        self.limits_seen = self.limit_pins();
        self.buttons_seen = self.buttons();
        if self.memory.damaged {
            self.recover_memory();
        }
        if self.memory.is_on(22) {
            self.mode = Mode::Alarm;
        }
        self.restart();
        self.work();
    }

    /// The settings, with the offsets and places stored by now.
    pub fn memory(&self) -> Memory {
        let mut memory = self.memory.clone();
        memory.remember(&self.parser);
        memory
    }

    /// Off and on again: settings, stored offsets and places stay, all else is as new, at machine zero.
    pub fn power_cycle(&mut self) {
        let mut fresh = Controller::off(self.memory(), self.build);
        (fresh.pins, fresh.switches, fresh.now) = (self.pins, self.switches, self.now);
        fresh.switch_on();
        *self = fresh;
    }

    /// Bytes from the cable. They arrive at this moment of machine time, but one after the other: the main loop looks at real-time
    /// flags between them as often as it would at 115200 baud, so repeats are merged the way they are on the cable.
    pub fn feed(&mut self, bytes: &[u8]) {
        if self.cable.is_timed() {
            return self.cable.put(bytes, self.now);
        }
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
            match self
                .intake
                .arrive_as(byte, self.build.profile.realtime(byte))
            {
                Some(crate::wire::Realtime::Reset) => {
                    // What came before the reset was read before it; what comes with it is thrown away by it.
                    self.work();
                    if self.reset() {
                        for &late in bytes.get(index + 1..).unwrap_or_default() {
                            if let Some(command) = self
                                .intake
                                .arrive_as(late, self.build.profile.realtime(late))
                            {
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
            self.arrive();
            self.work();
        }
        self.pass(end - self.now);
        self.now = end;
        self.arrive();
        self.work();
        self.cable.pass(end);
    }

    /// Bytes that have come along a timed line by now.
    fn arrive(&mut self) {
        self.cable.pass(self.now);
        while let Some(byte) = self.cable.arrived(self.now) {
            if self.loses() {
                continue;
            }
            match self
                .intake
                .arrive_as(byte, self.build.profile.realtime(byte))
            {
                Some(crate::wire::Realtime::Reset) => _ = self.reset(),
                Some(crate::wire::Realtime::Status) if self.now < self.reporting_until => {}
                Some(command) => self.flags.set(command),
                None => {}
            }
        }
    }

    /// The main loop is busy for so long, s; on an untimed line thinking takes no time.
    fn think(&mut self, seconds: f64) {
        if self.cable.is_timed() {
            self.pause(seconds);
        }
    }

    /// The main loop does nothing else for so long, s.
    fn pause(&mut self, seconds: f64) {
        self.busy_until = self.busy_until.max(self.now) + seconds;
    }

    /// What it said since the last call.
    pub fn output(&mut self) -> Vec<u8> {
        self.cable.take()
    }

    /// It has said something that was not taken yet.
    pub fn has_output(&self) -> bool {
        self.cable.has_output()
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
        let busy = Some(self.busy_until).filter(|t| awake && *t > self.now + SAME_MOMENT);
        let switch = self.next_switch().map(|dt| self.now + dt);
        let homing = self.homing.as_ref().and_then(Homing::wakes);
        let (arrival, left) = (self.cable.next_arrival(), self.cable.quiet_at());
        [axes, deaf, busy, switch, homing, arrival, left]
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
            || matches!(self.suspend, Suspend::DoorResuming { .. })
    }

    /// True while axes move or a queue waits to.
    pub fn is_moving(&self) -> bool {
        self.motion.going()
    }

    /// What the axes did last was a rapid move.
    pub fn ran_rapid(&self) -> bool {
        self.motion.ran_rapid()
    }

    /// Machine position, mm.
    pub fn position(&self) -> Point {
        match &self.homing {
            Some(homing) => homing.position(&self.motion.position()),
            None => self.motion.position(),
        }
    }

    /// Machine position in whole steps, as the firmware counts it, mm.
    pub fn position_in_steps(&self) -> Point {
        match self.homing {
            Some(_) => self.motion.steps_at(&self.position()),
            None => self.motion.position_in_steps(),
        }
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
        if self.motion.moving() {
            self.first_motion.get_or_insert(self.now);
            self.last_motion = self.now + dt;
        }
        // Also for no time at all: a slice may be that short.
        self.motion.advance(dt);
        self.follow_beam();
    }

    /// With a laser, what the blocks tell the spindle holds.
    fn follow_beam(&mut self) {
        if let Some(rpm) = self.motion.take_told()
            && self.memory.is_on(32)
            && self.spindle != 0
        {
            self.rpm = rpm;
        }
    }

    fn say(&mut self, line: &str) {
        // A byte of the line is a character up to U+00FF here.
        let mut bytes: Vec<u8> = line.chars().map(|c| c as u32 as u8).collect();
        bytes.extend_from_slice(b"\r\n");
        let at = if self.greeting {
            self.busy_until
        } else {
            self.now
        };
        self.cable.say(&bytes, at.max(self.now));
    }

    fn ok(&mut self) {
        self.say("ok");
    }

    fn error(&mut self, number: u16) {
        self.wall = self.build.profile.walls().then_some(number);
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
        self.end_homing();
        self.probing = None;
        self.motion.abort();
        if moving {
            self.mode = Mode::Alarm;
            self.suspend = Suspend::None;
            self.say(if homing { "ALARM:6" } else { "ALARM:3" });
            self.deaf = Deaf::ThenRestart(self.now + DEAF);
        } else if self.now < self.busy_until - SAME_MOMENT {
            self.deaf = Deaf::ThenRestart(self.busy_until);
        } else {
            self.finish_reset();
        }
        true
    }

    /// The part of a reset behind any alarm: greeting, startup lines.
    fn finish_reset(&mut self) {
        self.deaf = Deaf::No;
        // The line that was being carried out lets go of its answer.
        if let Some(line) = self.reading.take() {
            match self.dead {
                true => self.ok(),
                false => self.dispatch(&line),
            }
            if self.leaves_travel() {
                // The alarm takes the reset's place.
                self.motion.abort();
                self.steps.retain(|s| *s == Step::Ok);
                return self.alarm(2);
            }
        }
        if self.build.quirks.stray_ok && self.steps.contains(&Step::Ok) {
            self.ok();
        }
        if self.dead || self.mode == Mode::Sleep {
            self.mode = Mode::Alarm;
        }
        if self.mode != Mode::Alarm {
            self.mode = Mode::Normal;
        }
        self.motion.abort();
        let here = self.motion.position();
        self.motion.set_overrides(Overrides {
            feed: 1.0,
            rapid: 1.0,
        });
        self.parser.reset();
        self.parser.set_machine_position(&here);
        self.intake.clear();
        self.wall = None;
        self.reading = None;
        self.busy_until = self.now;
        self.flags = realtime::Flags::default();
        self.steps.clear();
        self.suspend = Suspend::None;
        self.wait = None;
        self.dead = false;
        self.soft_limit = false;
        self.percent = NO_OVERRIDES;
        (self.spindle, self.rpm, self.spindle_stopped) = (0, 0.0, false);
        self.motion.shine(Beam::default());
        self.probe_away = false;
        self.flood = false;
        (self.probe, self.probe_hit) = (Point::origin(), false);
        self.restart();
    }

    /// The next thing to do is a motion out of the travel.
    fn leaves_travel(&self) -> bool {
        let first = self.steps.iter().find_map(|s| match s {
            Step::Block { to, .. } => Some(*to),
            _ => None,
        });
        self.memory.is_on(20) && first.is_some_and(|to| self.outside(&to))
    }

    fn restart(&mut self) {
        (self.wco_in, self.overrides_in) = (0, 0);
        self.refresh_offset();
        self.think(GREETING);
        self.greeting = true;
        self.say("");
        self.say(self.build.profile.welcome());
        if self.memory.is_on(21) && self.limit_pins().contains(&true) {
            self.mode = Mode::Alarm;
            self.say("[MSG:Check Limits]");
        }
        if self.mode == Mode::Alarm {
            self.say("[MSG:'$H'|'$X' to unlock]");
        } else {
            self.queue_startup_lines();
        }
        self.greeting = false;
    }

    /// ALARM:n: whatever ran is over.
    fn alarm(&mut self, number: u16) {
        self.say(&format!("ALARM:{number}"));
        self.mode = Mode::Alarm;
        self.deaf = Deaf::Until(self.now + DEAF);
        self.dead = number <= 2;
    }
}
