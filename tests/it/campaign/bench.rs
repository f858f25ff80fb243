//! Both ends of the cable with a journal between them, from event to event in virtual time.

use super::faults::{Class, Schedule};
use super::jobs::{ORIGINS, START, STEPS};
use crate::chance::Chance;
use morsemill::controller::{Build, Controller, Faults, Memory, Quirks, Rig, RigOptions, Script};
use morsemill::geom::Point;
use morsemill::link::journal::{Begin, FORMAT, Keeper, Offsets, SYNC_GAP, Start, fingerprint};
use morsemill::link::{
    Command, Introduction, IntroductionOptions, Job, Known, Outcome, Progress, Session,
    SessionOptions,
};
use morsemill::wire::{Lines, Reply};
use std::collections::VecDeque;
use std::sync::OnceLock;
use std::time::Duration;

/// A session that is not over by then never is, s.
const FOREVER: f64 = 3000.0;
/// How often the host looks at its port when nothing arrives, s.
const LOOK: f64 = 0.01;

/// The machines of the campaign, at [`START`] with [`ORIGINS`]: plain, with limit switches, with soft limits, with a door pin.
pub fn machine(class: Class) -> &'static (Controller, Known) {
    static MACHINES: OnceLock<[(Controller, Known); 4]> = OnceLock::new();
    let which = match class {
        Class::Limit => 1,
        Class::SoftLimit => 2,
        Class::DoorPin => 3,
        _ => 0,
    };
    &MACHINES.get_or_init(|| std::array::from_fn(prepare))[which]
}

fn prepare(which: usize) -> (Controller, Known) {
    let mut m = Memory::default();
    for axis in 0..3 {
        m.set(100 + axis, STEPS);
        m.set(110 + axis, 6000.0);
        m.set(120 + axis, 700.0);
    }
    m.set(21, f64::from(u8::from(which == 1)));
    m.set(20, f64::from(u8::from(which == 2)));
    m.places[..6].copy_from_slice(&ORIGINS);
    let quirks = Quirks {
        door_pin: which == 3,
        ..Quirks::default()
    };
    let c = Controller::with_build(
        m,
        Build {
            quirks,
            ..Build::default()
        },
    );
    let c = standing_at(c, START);
    let known = introduce(&c);
    (c, known)
}

/// The operator homes it and drives it there; then it is reset.
pub fn standing_at(mut c: Controller, place: [f64; 3]) -> Controller {
    c.feed(
        format!(
            "G53 G0 X{:.4} Y{:.4} Z{:.4}\n",
            place[0], place[1], place[2]
        )
        .as_bytes(),
    );
    c.advance(60.0);
    c.feed(b"\x18");
    c.advance(2.0);
    c.output();
    assert!(
        (c.position() - Point::from(place)).norm() < 0.004,
        "{:?}",
        c.position()
    );
    c
}

/// What the controller says of itself.
pub fn introduce(controller: &Controller) -> Known {
    let mut c = controller.clone();
    let (mut i, mut lines) = (
        Introduction::new(IntroductionOptions::default(), Duration::ZERO),
        Lines::default(),
    );
    for ms in (0..20_000).step_by(5) {
        let now = Duration::from_millis(ms);
        i.tick(now);
        c.feed(&i.output());
        c.advance(0.005);
        for line in lines.feed(&c.output()) {
            i.receive(&Reply::parse(&line), now);
        }
        if let Some(result) = i.result() {
            return result.unwrap().clone();
        }
    }
    panic!("no introduction");
}

pub fn begin(text: &str, known: &Known) -> Begin {
    Begin {
        format: FORMAT,
        program: "random.nc".into(),
        sha256: fingerprint(text.as_bytes()),
        lines: text.lines().count(),
        machine: "test".into(),
        firmware: known.version.clone(),
        dialect: known.dialect().name().to_string(),
        settings: known.settings.clone(),
        start: Start {
            position: known.machine_position.unwrap_or_default(),
            offsets: Offsets::of(&known.offsets),
            modes: known.modes.to_string(),
        },
        rx_bytes: known.rx_bytes,
        planner_blocks: 15,
        bytes_per_s: 11_520.0,
        boot: Some("boot".into()),
        skips_slashed: false,
        resumed: None,
    }
}

/// Where the axes were when.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub t: f64,
    pub at: Point,
    pub rapid: bool,
}

/// What became of a job.
pub struct Ran {
    pub controller: Controller,
    /// Every place the axes passed, at the end of each slice of motion, as long as the controller knows where it is.
    pub spots: Vec<Spot>,
    /// Spots up to the end of the session.
    pub spots_at_end: usize,
    pub outcome: Option<Outcome>,
    pub journal: Vec<u8>,
    pub bytes_lost: usize,
    /// Seconds from the restart of a controller that had forgotten where it was to the last motion behind it.
    pub moved_after_restart: f64,
    /// The stop began then: hold sent (all bytes under way a little later).
    pub hold_at: Option<f64>,
    /// The session ended then.
    pub ended_at: f64,
    pub restarted: bool,
    /// The machine stands in a hold or at a door.
    pub held_at_end: bool,
    pub log: Vec<String>,
}

pub struct Bench {
    rig: Rig,
    session: Session,
    keeper: Keeper,
    journal: Vec<u8>,
    wishes: VecDeque<(f64, Command)>,
    schedule: Schedule,
    spots: Vec<Spot>,
    last: Point,
    restarts: usize,
    moved_after_restart: f64,
    restarted_at: f64,
    hold_at: Option<f64>,
    /// How long the journal was when.
    flushed: Vec<(f64, usize)>,
    dice: Chance,
    pieces: usize,
    log: Option<Vec<String>>,
}

impl Bench {
    pub fn new(
        controller: &Controller,
        known: &Known,
        job: Job,
        begin: Begin,
        schedule: Schedule,
        dice: Chance,
        trace: bool,
    ) -> Bench {
        let mut dice = dice;
        let rig = Rig::new(
            controller.clone(),
            RigOptions {
                faults: Faults::new(dice.next(), schedule.plan.clone()),
                script: Script::read("pins", &schedule.script).unwrap(),
                record: false,
            },
        );
        let (keeper, journal) = Keeper::new(begin, &job).unwrap();
        let mut session = Session::known(
            job,
            known.clone(),
            SessionOptions::default(),
            Duration::ZERO,
        );
        session.allow_up_to(0);
        Bench {
            last: rig.controller().position(),
            rig,
            session,
            keeper,
            journal,
            wishes: schedule.wishes.iter().copied().collect(),
            schedule,
            spots: Vec::new(),
            restarts: 0,
            moved_after_restart: 0.0,
            restarted_at: 0.0,
            hold_at: None,
            flushed: Vec::new(),
            dice,
            pieces: 0,
            log: trace.then(Vec::new),
        }
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.rig.now())
    }

    fn say(&mut self, text: impl FnOnce() -> String) {
        let now = self.rig.now();
        if let Some(log) = &mut self.log {
            log.push(format!("{now:9.4} {}", text()));
        }
    }

    /// Lets time pass until then, or until something arrives.
    fn turn(&mut self, until: f64) {
        while self.rig.now() < until - 1e-9 && !self.rig.has_output() {
            let next = self
                .rig
                .next_change()
                .unwrap_or(until)
                .clamp(self.rig.now(), until);
            self.rig.advance((next - self.rig.now()).max(1e-9));
            let restarts = self.rig.faults().tally().restarts;
            let at = self.rig.controller().position();
            if restarts != self.restarts {
                self.restarts = restarts;
                self.restarted_at = self.rig.now();
                self.last = at;
            } else if at != self.last {
                self.last = at;
                if restarts > 0
                    && !(self.schedule.class == Class::PowerCycle && at.coords.norm() == 0.0)
                {
                    self.moved_after_restart = self.rig.now() - self.restarted_at;
                } else if restarts == 0 {
                    let rapid = self.rig.controller().ran_rapid();
                    self.spots.push(Spot {
                        t: self.rig.now(),
                        at,
                        rapid,
                    });
                }
            }
        }
    }

    fn operator(&mut self) {
        let now = self.rig.now();
        while self.wishes.front().is_some_and(|w| w.0 <= now) {
            if let Some((_, wish)) = self.wishes.pop_front() {
                self.say(|| format!("wish {wish:?}"));
                let at = self.now();
                self.session.command(wish, at);
            }
        }
    }

    fn host(&mut self) {
        let heard = self.rig.output();
        let now = self.now();
        if !heard.is_empty() {
            self.say(|| format!("<- {:?}", String::from_utf8_lossy(&heard)));
            self.session.receive(&heard, now);
        }
        self.operator();
        let turn = self.keeper.turn(now, false).unwrap();
        if !turn.bytes.is_empty() {
            self.flushed.push((self.rig.now(), self.journal.len()));
        }
        self.journal.extend(turn.bytes);
        self.session.allow_up_to(turn.allowed);
        self.session.tick(now);
        let mut out = self.session.output();
        out.truncate(self.schedule.takes);
        self.session.written(out.len());
        let gone = self.schedule.gone.is_some_and(|t| self.rig.now() >= t);
        if gone {
            // Nobody knows how much of it went out.
            out.truncate(self.dice.roll(out.len() + 1));
            self.session.broken("the port is gone".to_string(), now);
        }
        if !out.is_empty() {
            self.pieces += usize::from(out.contains(&b'X'));
            if self.schedule.refuse.is_some_and(|n| self.pieces >= n)
                && let Some(i) = out.iter().position(|b| *b == b'X')
            {
                // A word without its number.
                out.insert(i, b'X');
                self.schedule.refuse = None;
            }
            self.say(|| format!("-> {:?}", String::from_utf8_lossy(&out)));
            self.rig.feed(&out);
        }
        for news in self.session.news() {
            self.keeper.hear(&news, now);
            match &news {
                Progress::Report(_) => {}
                other => self.say(|| format!("   {other:?}")),
            }
            // Behind a door that was opened at a tool change, the tool change waits still.
            let waits = news == Progress::Resumed && self.session.tool_change().is_some();
            match news {
                Progress::Note(text) if text.contains("close it, then resume") => {
                    self.wishes
                        .push_back((self.rig.now() + 1.0, Command::Resume));
                }
                _ if waits || matches!(news, Progress::Prompt(_) | Progress::Paused(_)) => {
                    let at = self.rig.now() + 0.3 + self.dice.part();
                    let place = self
                        .wishes
                        .iter()
                        .position(|w| w.0 > at)
                        .unwrap_or(self.wishes.len());
                    self.wishes.insert(place, (at, Command::Resume));
                }
                Progress::Stopping(_) => self.hold_at = Some(self.rig.now()),
                _ => {}
            }
        }
    }

    /// What the disk has of the journal is some time old; the rest is missing, torn or zeros.
    fn cut_power(&mut self) {
        let first = self.journal.iter().position(|b| *b == b'\n').unwrap_or(0) + 1;
        let since = self.rig.now() - SYNC_GAP * self.dice.part();
        let kept = self.flushed.iter().find(|f| f.0 >= since);
        let kept = kept.map_or(self.journal.len(), |f| f.1).max(first);
        let more = self.dice.roll(self.journal.len() - kept + 1);
        match self.dice.roll(3) {
            0 => self.journal.truncate(kept),
            1 => self.journal.truncate(kept + more),
            _ => self.journal.iter_mut().skip(kept).for_each(|b| *b = 0),
        }
    }

    /// Runs the job until its session ends, or its sender is killed, and lets the machine do what it does then. `None`: it never ended.
    pub fn run(mut self) -> Ran {
        let outcome = loop {
            self.host();
            if let Some(outcome) = self.session.outcome() {
                break Some(outcome);
            }
            let now = self.rig.now();
            if now > FOREVER || self.schedule.kill.is_some_and(|t| now >= t) {
                break None;
            }
            self.turn(now + LOOK);
        };
        let ended_at = self.rig.now();
        let at = self.now();
        self.say(|| format!("ended: {outcome:?}"));
        match &outcome {
            Some(outcome) => {
                let last = self.keeper.end(outcome, at);
                self.journal.extend(last);
            }
            None if self.schedule.class == Class::PowerCut => self.cut_power(),
            None if self.schedule.kill.is_some() => {
                // What was not flushed is lost, or torn.
                let late = self
                    .keeper
                    .turn(at + Duration::from_secs(1), true)
                    .map(|t| t.bytes)
                    .unwrap_or_default();
                let cut = self.dice.roll(late.len() + 1);
                self.journal.extend(late.iter().take(cut));
            }
            None => {}
        }
        let spots_at_end = self.spots.len();
        let mut quiet = 0.0;
        while quiet < 30.0 {
            let before = self.spots.len();
            let now = self.rig.now();
            self.turn(now + 1.0);
            self.rig.output();
            quiet = if self.spots.len() == before && !self.rig.is_moving() {
                quiet + 1.0
            } else {
                0.0
            };
            if now > 2.0 * FOREVER {
                break;
            }
        }
        self.rig.feed(b"?");
        let now = self.rig.now();
        self.turn(now + 0.5);
        self.turn(now + 0.5);
        let said = String::from_utf8_lossy(&self.rig.output()).into_owned();
        let held_at_end = said.contains("<Hold") || said.contains("<Door");
        Ran {
            controller: self.rig.controller().clone(),
            spots: self.spots,
            spots_at_end,
            outcome,
            journal: self.journal,
            bytes_lost: self.rig.controller().bytes_lost(),
            moved_after_restart: self.moved_after_restart,
            hold_at: self.hold_at,
            ended_at,
            restarted: self.restarts > 0,
            held_at_end,
            log: self.log.unwrap_or_default(),
        }
    }
}
