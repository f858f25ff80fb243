//! Taking up broken jobs: random programs are broken at random moments in every way there is, against the simulated controller on a clock
//! turned by hand. The sender here is a few lines that count characters and keep the journal; what is judged is journal and resume.
#![allow(clippy::unwrap_used)]

use morsemill::controller::{Controller, Memory};
use morsemill::gcode::{self, Dialect, Event, FeedMode, MotionMode, State, interpret_line};
use morsemill::geom::{Point, Vector};
use morsemill::kinematics::chords;
use morsemill::link::journal::{
    Allowance, Begin, FORMAT, History, Offsets, Record, Start, Writer, fingerprint, read,
};
use morsemill::link::resume::{
    Evidence, Now, Overlap, Refusal, ResumeOptions, Trust, from_line, resume, zones,
};
use morsemill::units::Mm;
use proptest::prelude::*;
use std::collections::VecDeque;
use std::time::Duration;

const RX: usize = 128;
const STEPS: f64 = 250.0;
/// Planner blocks and prepared slices: what a GRBL holds of answered lines.
const HELD: usize = 15 + 6;

/// Small numbers that repeat from a seed.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, below: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % below
    }

    fn place(&mut self) -> f64 {
        self.roll(8000) as f64 / 100.0 - 40.0
    }
}

const G54: [f64; 3] = [-100.0, -90.0, -60.0];
const G55: [f64; 3] = [-110.5, -95.25, -62.125];

fn offsets() -> Offsets {
    let mut o = Offsets::default();
    (o.g5x[0], o.g5x[1]) = (G54, G55);
    o
}

fn vectors(o: &Offsets) -> [Vector; 6] {
    o.g5x.map(Vector::from)
}

/// A machine just reset, with the offsets of these tests, at machine `place`.
fn reset_state(place: [f64; 3]) -> State {
    let mut s = State::new(Dialect::Grbl);
    s.g5x = vectors(&offsets());
    s.set_machine_position(&Point::from(place));
    s
}

const START: [f64; 3] = [-95.0, -85.0, -20.0];

/// A program of random lines, of which the interpreter takes every one.
fn program(seed: u64, lines: usize) -> String {
    let mut dice = Dice(seed ^ 0x9e37_79b9_7f4a_7c15);
    dice.roll(9);
    let mut state = reset_state(START);
    let mut text = String::new();
    let head = [
        "(a job)",
        "G21 G90 G17 G94",
        "M3 S8000",
        "G0 Z10",
        "G0 X0 Y0",
        "G1 Z1 F400",
    ];
    let mut wanted: Vec<String> = head.iter().rev().map(|s| s.to_string()).collect();
    let mut count = 0;
    while count < lines + head.len() {
        // Every other program is of many short moves, as passes over freeform parts are.
        let short = seed % 2 == 1 && dice.roll(25) > 0;
        let line = wanted.pop().unwrap_or_else(|| match short {
            true => short_move(&mut dice, &state),
            false => random_line(&mut dice, &state),
        });
        let mut trial = state.clone();
        let mut events = Vec::new();
        if interpret_line(&mut trial, &line, count + 1, &mut events).is_err() {
            continue;
        }
        let near = |p: &Point| p.iter().all(|c| c.abs() < 160.0);
        let machine = trial.machine_position();
        if !near(&machine) || !near(&trial.position) || machine.z < -80.0 || machine.z > -5.0 {
            continue;
        }
        state = trial;
        text.push_str(&line);
        text.push('\n');
        count += 1;
    }
    text
}

fn short_move(dice: &mut Dice, state: &State) -> String {
    let unit = state.units.mm();
    let base = match state.distance {
        gcode::Distance::Incremental => Point::origin(),
        gcode::Distance::Absolute => state.position,
    };
    let mut by = || dice.roll(200) as f64 / 1000.0 - 0.1;
    let (x, y) = ((base.x + 0.2 + by()) / unit, (base.y + by()) / unit);
    let f = if state.feed_mode == FeedMode::InverseTime {
        "F900"
    } else {
        ""
    };
    format!("G1X{x:.4}Y{y:.4}{f}")
}

fn random_line(dice: &mut Dice, state: &State) -> String {
    let unit = state.units.mm();
    let incremental = state.distance == gcode::Distance::Incremental;
    let axis = |dice: &mut Dice, letter: char, now: f64| {
        // A few millimetres from here, in whatever the words mean now.
        let by = dice.roll(800) as f64 / 100.0 - 4.0;
        let to = if incremental {
            by
        } else {
            (now * 100.0).round() / 100.0 + by
        };
        format!("{letter}{:.4}", to / unit)
    };
    let p = state.position;
    let f = match state.feed_mode {
        FeedMode::InverseTime => format!("F{}", 20 + dice.roll(200)),
        _ if dice.roll(3) == 0 => format!("F{:.2}", (300 + dice.roll(1500)) as f64 / unit),
        _ => String::new(),
    };
    match dice.roll(40) {
        0..=9 => format!("G1 {} {} {f}", axis(dice, 'X', p.x), axis(dice, 'Y', p.y)),
        10..=14 => format!("{} {} {f}", axis(dice, 'X', p.x), axis(dice, 'Y', p.y)),
        15..=16 => format!(
            "g1{}{}{}{f}",
            axis(dice, 'X', p.x),
            axis(dice, 'Y', p.y),
            axis(dice, 'Z', p.z)
        ),
        17 => format!("G0 {} {}", axis(dice, 'X', p.x), axis(dice, 'Z', p.z)),
        18..=21 => {
            // An arc by its centre in the plane in force; often without its G word.
            let [a, b, _] = state.plane.axes();
            let (i, j) = (
                dice.roll(600) as f64 / 100.0 - 3.0,
                dice.roll(600) as f64 / 100.0 - 3.0,
            );
            let turn = dice.roll(628) as f64 / 100.0;
            let (sin, cos) = turn.sin_cos();
            // The start about the centre, turned.
            let (u, v) = (-i * cos + j * sin, -i * sin - j * cos);
            let end = [i + u, j + v];
            let base = if incremental {
                [0.0, 0.0]
            } else {
                [p[a], p[b]]
            };
            let names = ['X', 'Y', 'Z'];
            let centers = ['I', 'J', 'K'];
            let g = ["G2 ", "G3 ", "", ""][dice.roll(4)];
            format!(
                "{g}{}{:.5} {}{:.5} {}{:.5} {}{:.5} {f}",
                names[a],
                (base[0] + end[0]) / unit,
                names[b],
                (base[1] + end[1]) / unit,
                centers[a],
                i / unit,
                centers[b],
                j / unit
            )
        }
        22 => {
            let r = 3.0 + dice.roll(500) as f64 / 100.0;
            format!(
                "G{} {} {} R{:.4} {f}",
                2 + dice.roll(2),
                axis(dice, 'X', p.x),
                axis(dice, 'Y', p.y),
                r / unit
            )
        }
        23 => ["G20", "G21"][dice.roll(2)].to_string(),
        24 => ["G90", "G91"][dice.roll(2)].to_string(),
        25 => ["G93", "G94 F500"][dice.roll(2)].to_string(),
        26 => ["G17", "G18", "G19"][dice.roll(3)].to_string(),
        27 => ["G54", "G55"][dice.roll(2)].to_string(),
        28 => format!(
            "G92 X{:.3} Z{:.3}",
            dice.place() / unit / 4.0,
            (p.z + 2.0 - dice.roll(4) as f64) / unit
        ),
        29 => ["G92.1", "G49", "G43.1 Z0.5"][dice.roll(3)].to_string(),
        30 => ["M3 S9000", "M4 S12000", "M5", "S7000"][dice.roll(4)].to_string(),
        31 => ["M8", "M9"][dice.roll(2)].to_string(),
        32 => format!("G4 P0.{}", dice.roll(9)),
        33 => ["(note)", "", "; nothing ?", "%"][dice.roll(3)].to_string(),
        34 => format!("G53 G0 Z{:.3}", (-10.0 - dice.roll(10) as f64) / unit),
        35 => format!("T{} G1 {} {f}", dice.roll(5), axis(dice, 'X', p.x)),
        36 => format!("N{} G1 {} {f} (x)", dice.roll(999), axis(dice, 'Y', p.y)),
        37 => format!(
            "M{} S{} G1 {} {f}",
            3 + dice.roll(2),
            5000 + dice.roll(9) * 100,
            axis(dice, 'X', p.x)
        ),
        _ => format!("{} {f}", axis(dice, 'Z', p.z)),
    }
}

fn memory() -> Memory {
    let mut m = Memory::default();
    for axis in 0..3 {
        m.set(110 + axis, 6000.0);
        m.set(120 + axis, 700.0);
    }
    m
}

fn settings() -> Vec<(u16, f64)> {
    let m = memory();
    [3, 11, 12, 20, 22, 23, 27, 32, 100, 101, 102, 130, 131, 132]
        .map(|n| (n, m.get(n)))
        .to_vec()
}

/// A controller standing at [`START`] with the offsets of these tests.
fn controller() -> Controller {
    let mut c = Controller::new(memory());
    for (p, o) in [(1, G54), (2, G55)] {
        c.feed(format!("G10 L2 P{p} X{} Y{} Z{}\n", o[0], o[1], o[2]).as_bytes());
        c.advance(1.0);
    }
    let s = START;
    c.feed(format!("G53 G0 X{} Y{} Z{}\n", s[0], s[1], s[2]).as_bytes());
    c.advance(60.0);
    c.feed(b"\x18");
    c.advance(1.0);
    c.output();
    assert!((c.position() - Point::from(START)).norm() < 1e-9);
    c
}

fn begin(text: &str) -> Begin {
    Begin {
        format: FORMAT,
        program: "random.nc".into(),
        sha256: fingerprint(text.as_bytes()),
        lines: text.lines().count(),
        machine: "test".into(),
        firmware: "1.1h".into(),
        dialect: "grbl".into(),
        settings: settings(),
        start: Start {
            position: START,
            offsets: offsets(),
            modes: String::new(),
        },
        rx_bytes: RX,
        planner_blocks: 15,
        bytes_per_s: 11_520.0,
        boot: Some("boot".into()),
        skips_slashed: false,
        resumed: None,
    }
}

fn now(c: &Controller) -> Now {
    let p = c.position();
    // As a report tells it.
    let round = |v: f64| (v * 1e3).round() / 1e3;
    Now {
        machine: "test".into(),
        state: "Idle".into(),
        position: Some([round(p.x), round(p.y), round(p.z)]),
        offsets: offsets(),
        settings: settings(),
        homed: None,
        dialect: "grbl".into(),
        boot: Some("boot".into()),
    }
}

/// What of a line is sent: as any sender does it.
fn significant(line: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for c in line.chars() {
        match c {
            '(' => inside = true,
            ')' => inside = false,
            ';' => break,
            c if inside || c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    if out == "%" { String::new() } else { out }
}

/// Way of the axes up to the end of each line (index 0: before the first), mm, and blocks of each line, as the controller makes them.
fn ways(text: &str, start: State) -> (Vec<f64>, Vec<usize>) {
    let (mut ways, mut blocks) = (vec![0.0], vec![0]);
    let steps = |p: Point| p.map(|c| (c * STEPS).round() / STEPS);
    let mut state = start;
    let mut at = steps(state.machine_position());
    for (i, line) in text.lines().enumerate() {
        let mut events = Vec::new();
        interpret_line(&mut state, &significant(line), i + 1, &mut events).unwrap();
        let (mut way, mut count) = (*ways.last().unwrap(), 0);
        let mut go = |to: Point| {
            let to = steps(to);
            if to != at {
                way += (to - at).norm();
                count += 1;
                at = to;
            }
        };
        for e in &events {
            if let Event::Motion(m) = e {
                let shift = state.machine_position() - m.to;
                match &m.arc {
                    None => go(m.to + shift),
                    Some(arc) => chords(&m.from, &m.to, arc, Mm(0.002)).for_each(|p| go(p + shift)),
                }
            }
        }
        ways.push(way);
        blocks.push(count);
    }
    (ways, blocks)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Break {
    /// Feed hold, standstill, reset: what the session does.
    Stop,
    /// The controller is reset, whatever it is doing.
    Reset,
    /// The cable is pulled, perhaps in the middle of a line; the controller runs dry.
    Cable,
    /// The sender is killed; the controller runs dry, and the journal ends where it was flushed, or in the middle of a later record.
    Kill,
}

/// A sender that counts characters and keeps a journal, and the controller it feeds.
struct Bench {
    controller: Controller,
    text: Vec<String>,
    /// Lines whose text is not of the program (the way in), first.
    own: usize,
    first_line: usize,
    sent: usize,
    acknowledged: usize,
    sent_bytes: usize,
    acknowledged_bytes: usize,
    there: VecDeque<(u64, u8)>,
    back: VecDeque<(u64, Vec<u8>)>,
    heard: Vec<u8>,
    delay: u64,
    ms: u64,
    writer: Writer,
    allowance: Allowance,
    journal: Vec<u8>,
    /// Way of the axes, mm.
    way: f64,
    refused: bool,
}

impl Bench {
    /// `own` lines of the text come before line `first_line` of the program.
    fn new(
        controller: Controller,
        text: &str,
        own: usize,
        first_line: usize,
        begin: Begin,
        delay: u64,
    ) -> Bench {
        let mut writer = Writer::new();
        writer.note(Record::Begin(Box::new(begin)), Duration::ZERO);
        let journal = writer.take();
        Bench {
            controller,
            text: text.lines().map(significant).collect(),
            own,
            first_line,
            sent: 0,
            acknowledged: 0,
            sent_bytes: 0,
            acknowledged_bytes: 0,
            there: VecDeque::new(),
            back: VecDeque::new(),
            heard: Vec::new(),
            delay,
            ms: 0,
            writer,
            allowance: Allowance::new(RX),
            journal,
            way: 0.0,
            refused: false,
        }
    }

    /// The line of the program, 0 for one of the way in.
    fn original(&self, line: usize) -> usize {
        if line > self.own {
            line - self.own - 1 + self.first_line
        } else {
            0
        }
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.ms)
    }

    fn bytes(line: &str) -> usize {
        if line.is_empty() { 0 } else { line.len() + 1 }
    }

    /// Lets the axes go on, and measures their way.
    fn turn(&mut self, seconds: f64) {
        let end = self.controller.now() + seconds;
        while self.controller.now() < end - 1e-12 {
            let until = self
                .controller
                .next_change()
                .unwrap_or(end)
                .clamp(self.controller.now(), end);
            let before = self.controller.position();
            let dt = (until - self.controller.now()).max(1e-9);
            self.controller.advance(dt);
            self.way += (self.controller.position() - before).norm();
        }
    }

    fn host(&mut self) {
        while self.back.front().is_some_and(|b| b.0 <= self.ms) {
            self.heard.extend(self.back.pop_front().unwrap().1);
        }
        while let Some(end) = self.heard.iter().position(|b| *b == b'\n') {
            let line: Vec<u8> = self.heard.drain(..=end).collect();
            let line = String::from_utf8(line).unwrap();
            self.refused |= line.starts_with("error") || line.starts_with("ALARM");
            if line.trim() == "ok" {
                // Empty lines are not sent: the next that was.
                while self.text[self.acknowledged].is_empty() {
                    self.acknowledged += 1;
                }
                self.acknowledged_bytes += Bench::bytes(&self.text[self.acknowledged]);
                self.acknowledged += 1;
                let line = self.original(self.acknowledged);
                self.writer.note(Record::Acknowledged { line }, self.now());
            }
        }
        if self.writer.due(self.now()) {
            let bytes = self.writer.take();
            self.journal.extend(bytes);
        }
        let text = &self.text;
        let more = self
            .allowance
            .extend(self.sent_bytes, self.acknowledged_bytes, |n| {
                text.get(n - 1).map(|l| Bench::bytes(l))
            });
        if let Some(line) = more {
            let bytes = self.writer.allow(self.original(line), self.now());
            self.journal.extend(bytes);
        }
        while self.sent < self.text.len().min(self.allowance.allowed()) {
            let line = self.text[self.sent].clone();
            let bytes = Bench::bytes(&line);
            if self.sent_bytes + bytes - self.acknowledged_bytes > RX - 1 {
                break;
            }
            self.sent += 1;
            self.sent_bytes += bytes;
            if bytes > 0 {
                self.there.extend(
                    line.bytes()
                        .chain([b'\n'])
                        .map(|b| (self.ms + self.delay, b)),
                );
            }
            let line = self.original(self.sent);
            self.writer.note(Record::Sent { line }, self.now());
        }
    }

    fn cable(&mut self) {
        let mut bytes = Vec::new();
        while self.there.front().is_some_and(|b| b.0 <= self.ms) {
            bytes.push(self.there.pop_front().unwrap().1);
        }
        self.controller.feed(&bytes);
        let said = self.controller.output();
        if !said.is_empty() {
            self.back.push_back((self.ms + self.delay, said));
        }
    }

    fn tick(&mut self) {
        self.ms += 1;
        self.turn(0.001);
        self.cable();
        self.host();
    }

    fn done(&self) -> bool {
        self.acknowledged_bytes == self.sent_bytes
            && self.sent == self.text.len()
            && !self.controller.is_moving()
    }

    /// Runs to the end.
    fn finish(&mut self) {
        for _ in 0..2_000_000 {
            if self.done() {
                return;
            }
            self.tick();
        }
        panic!(
            "no end: {} of {} answered",
            self.acknowledged,
            self.text.len()
        );
    }

    /// The controller goes on alone until it stands.
    fn run_dry(&mut self) {
        for _ in 0..2_000_000 {
            self.turn(0.005);
            self.controller.output();
            if !self.controller.is_busy() && !self.controller.is_moving() {
                return;
            }
        }
        panic!("it never stands");
    }

    fn end(&mut self, kept: bool, at_rest: bool) {
        let end = Record::End {
            how: "broken".into(),
            done: false,
            position_kept: kept,
            at_rest,
        };
        self.writer.note(end, self.now());
        let bytes = self.writer.take();
        self.journal.extend(bytes);
    }

    /// Breaks the job; what is left of the journal.
    fn break_off(&mut self, how: Break, dice: &mut Dice) -> Vec<u8> {
        match how {
            Break::Stop => {
                self.controller.feed(b"!");
                while self.controller.is_moving() {
                    self.turn(0.001);
                }
                self.turn(0.01);
                // Answers that were under way arrive, or do not.
                if dice.roll(2) == 0 {
                    self.ms += 2 * self.delay;
                    let sent = self.sent;
                    self.allowance = Allowance::new(1);
                    self.host();
                    assert_eq!(sent, self.sent);
                }
                self.controller.feed(b"\x18");
                self.turn(1.0);
                self.end(true, true);
                self.journal.clone()
            }
            Break::Reset => {
                self.controller.feed(b"\x18");
                self.turn(1.0);
                self.writer.note(Record::Reset, self.now());
                self.end(false, true);
                self.journal.clone()
            }
            Break::Cable => {
                let whole: Vec<u8> = self.there.drain(..).map(|b| b.1).collect();
                let arrived = dice.roll(whole.len() + 1);
                self.controller.feed(&whole[..arrived]);
                self.run_dry();
                self.end(true, false);
                self.journal.clone()
            }
            Break::Kill => {
                let flushed = self.journal.len();
                self.writer.note(Record::Resume, self.now());
                let pending = self.writer.take();
                self.journal.extend(&pending);
                let cut = flushed + dice.roll(pending.len() + 1);
                let whole: Vec<u8> = self.there.drain(..).map(|b| b.1).collect();
                self.controller.feed(&whole);
                self.run_dry();
                // The next opening resets it at rest.
                self.controller.feed(b"\x18");
                self.turn(1.0);
                self.journal[..cut].to_vec()
            }
        }
    }
}

fn taken(history: &History) -> &Begin {
    history.begin.as_ref().unwrap()
}

/// The laws of the zones, and what the resumed program makes of the rest.
fn break_and_resume(seed: u64, how: Break, fullest: &mut usize) -> Result<bool, TestCaseError> {
    let mut dice = Dice(seed);
    let text = program(seed, 30 + dice.roll(80));
    let (ways, blocks) = ways(&text, reset_state(START));
    let total = *ways.last().unwrap();
    let mut bench = Bench::new(
        controller(),
        &text,
        0,
        1,
        begin(&text),
        1 + dice.roll(30) as u64,
    );
    // Break it when the axes have gone so far.
    let stop_at = total * dice.roll(1000) as f64 / 1000.0;
    while bench.way < stop_at && !bench.done() {
        bench.tick();
    }
    for _ in 0..dice.roll(200) {
        bench.tick();
    }
    prop_assert!(!bench.refused);
    let journal = bench.break_off(how, &mut dice);
    let history = read(&journal[..]).unwrap();
    let z = match zones(&text, taken(&history), &history, Some("boot")) {
        Ok(z) => z,
        Err(Refusal::NothingSent) => {
            prop_assert!(bench.way < 1e-6, "moved {} mm", bench.way);
            return Ok(false);
        }
        Err(e) => return Err(TestCaseError::fail(e.to_string())),
    };

    // The true place lies in the zone.
    let way = bench.way;
    let where_it_is = format!(
        "{z:?} of {way:.4} mm, {how:?}, answered {} sent {} allowed {}",
        history.acknowledged, history.sent, history.allowed
    );
    prop_assert!(
        ways[z.first - 1] <= way + 1e-5,
        "a line before the zone was not carried out: {where_it_is}"
    );
    prop_assert!(
        way <= ways[z.last] + 1e-5,
        "a line behind the zone was begun: {where_it_is}"
    );
    // How much the controller really held: the bound must be needed.
    let line = (1..ways.len())
        .find(|l| ways[*l] > way + 1e-5)
        .unwrap_or(ways.len());
    if line < history.acknowledged {
        *fullest = (*fullest).max(blocks[line + 1..=history.acknowledged].iter().sum());
    }
    // The zone is no larger than what the controller holds.
    let queued: usize = blocks[(z.first + 1).min(history.acknowledged + 1)..=history.acknowledged]
        .iter()
        .sum();
    prop_assert!(queued < HELD + 8, "{queued} blocks: {where_it_is}");
    let unanswered: usize = bench.text[history.acknowledged.min(z.last)..z.last]
        .iter()
        .map(|l| Bench::bytes(l))
        .sum();
    let room = if how == Break::Kill { 2 * RX + 80 } else { RX };
    prop_assert!(unanswered <= room, "{unanswered} bytes: {where_it_is}");

    // Taken up again.
    let trust = if how == Break::Reset {
        Trust::Operator
    } else {
        Trust::Shown
    };
    let options = ResumeOptions {
        trust,
        spin_up_s: 0.1,
        ..ResumeOptions::default()
    };
    let plan = match resume(
        &text,
        &fingerprint(text.as_bytes()),
        &history,
        &now(&bench.controller),
        &options,
    ) {
        Ok(plan) => plan,
        Err(Refusal::NoEntry { .. }) => return Ok(false),
        Err(e) => return Err(TestCaseError::fail(format!("{e}: {where_it_is}"))),
    };
    let evidence = if how == Break::Reset {
        Evidence::Operator
    } else {
        Evidence::OnPath
    };
    prop_assert_eq!(plan.evidence, Some(evidence));
    // All that was not cut is cut by the rest: the first run came at least to the entry.
    prop_assert!(
        ways[plan.entry.line - 1] <= way + 1e-5 || plan.entry.line <= 7,
        "entry {}: {where_it_is}",
        plan.entry.line
    );
    let rest = plan.program(&text);
    bench.controller.feed(b"\x18");
    bench.turn(if how == Break::Reset { 2.0 } else { 0.5 });
    if how == Break::Reset {
        bench.controller.feed(b"$X\n");
        bench.turn(0.5);
    }
    bench.controller.output();
    let map = plan.map();
    let mut second = Bench::new(
        bench.controller.clone(),
        &rest,
        map.head,
        map.entry,
        begin(&text),
        2,
    );
    while second.acknowledged < map.head {
        second.tick();
    }
    second.finish();
    prop_assert!(!second.refused, "{rest}");
    // The same end as the straight run, by the axes.
    let mut straight = Bench::new(controller(), &text, 0, 1, begin(&text), 2);
    straight.finish();
    let apart = (second.controller.position() - straight.controller.position()).norm();
    prop_assert!(apart < 0.009, "ends {apart} mm apart");
    prop_assert!(
        (straight.way - total).abs() < 1e-3,
        "{} {total}",
        straight.way
    );
    // And the way from the entry on is the straight run's: the rest of it, whole.
    let (rest_ways, _) = self::ways(&rest, reset_state(now(&bench.controller).position.unwrap()));
    let after_entry = rest_ways.last().unwrap() - rest_ways[map.head];
    prop_assert!(
        (after_entry - (total - ways[map.entry - 1])).abs() < 0.02 + 1e-4 * total,
        "{after_entry} {}",
        total - ways[map.entry - 1]
    );
    Ok(true)
}

fn campaign(how: Break, seeds: std::ops::Range<u64>) {
    let count = seeds.end - seeds.start;
    let (mut resumed, mut fullest) = (0, 0);
    for seed in seeds {
        match break_and_resume(seed, how, &mut fullest) {
            Ok(done) => resumed += u64::from(done),
            Err(e) => panic!("seed {seed}, {how:?}: {e}"),
        }
    }
    assert!(
        resumed * 10 >= count * 8,
        "only {resumed} of {count} were resumed"
    );
    // Jobs that run dry have nothing queued.
    if matches!(how, Break::Stop | Break::Reset) {
        assert!(fullest >= 8, "the planner never held much: {fullest}");
    }
}

#[test]
fn a_stopped_job_goes_on_where_it_was() {
    campaign(Break::Stop, 0..12);
}

#[test]
fn a_job_whose_controller_was_reset_goes_on_on_the_operators_word() {
    campaign(Break::Reset, 1000..1012);
}

#[test]
fn a_job_whose_cable_was_pulled_goes_on() {
    campaign(Break::Cable, 2000..2012);
}

#[test]
fn a_job_whose_sender_was_killed_goes_on() {
    campaign(Break::Kill, 3000..3012);
}

/// A history of a job of which so much was answered and sent, ended in order.
fn broken_at(text: &str, acknowledged: usize, sent: usize) -> History {
    history_of(
        text,
        &[
            Record::Allow { line: sent },
            Record::Sent { line: sent },
            Record::Acknowledged { line: acknowledged },
            Record::End {
                how: "stopped".into(),
                done: false,
                position_kept: true,
                at_rest: true,
            },
        ],
    )
}

fn history_of(text: &str, records: &[Record]) -> History {
    let mut w = Writer::new();
    w.note(Record::Begin(Box::new(begin(text))), Duration::ZERO);
    for r in records {
        w.note(r.clone(), Duration::ZERO);
    }
    read(&w.take()[..]).unwrap()
}

fn here(place: [f64; 3]) -> Now {
    Now {
        machine: "test".into(),
        state: "Idle".into(),
        position: Some(place),
        offsets: offsets(),
        settings: settings(),
        homed: None,
        dialect: "grbl".into(),
        boot: Some("boot".into()),
    }
}

fn operator() -> ResumeOptions {
    ResumeOptions {
        trust: Trust::Operator,
        ..ResumeOptions::default()
    }
}

/// Runs text from a state, and gives the state before each line.
fn states(text: &str, start: State) -> Vec<State> {
    let mut state = start;
    let mut all = vec![state.clone()];
    for (i, line) in text.lines().enumerate() {
        let mut events = Vec::new();
        interpret_line(&mut state, &significant(line), i + 1, &mut events).unwrap();
        all.push(state.clone());
    }
    all
}

/// Everything that the machine remembers is as in the straight run, but T, which GRBL forgets with each line, and a motion mode that only an
/// arc could set.
fn same_modes(a: &State, b: &State) -> Result<(), String> {
    let mut b = b.clone();
    let near = |x: f64, y: f64| (x - y).abs() < 3e-5 + 1e-9 * x.abs();
    let all_near = (0..3).all(|i| near(a.position[i], b.position[i]) && near(a.g92[i], b.g92[i]))
        && near(a.tlo, b.tlo)
        && (near(a.feed.0, b.feed.0) || a.feed_mode == FeedMode::InverseTime);
    (b.position, b.g92, b.g92_kept, b.tlo, b.tool, b.feed) =
        (a.position, a.g92, a.g92_kept, a.tlo, a.tool, a.feed);
    b.rapid_feed = a.rapid_feed;
    if matches!(
        a.motion,
        MotionMode::ArcClockwise | MotionMode::ArcCounterclockwise | MotionMode::None
    ) {
        b.motion = a.motion;
    }
    match all_near && *a == b {
        true => Ok(()),
        false => Err(format!("straight {a:?}\nresumed {b:?}")),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 200, ..ProptestConfig::default() })]

    /// Wherever a job breaks: the way in leaves the state of the straight run, and each later line does the same.
    #[test]
    fn the_state_at_the_entry_is_that_of_the_straight_run(seed: u64, at in 0.0..1.0f64, ahead in 0usize..8, overlap in 0usize..4) {
        let text = program(seed, 60);
        let lines = text.lines().count();
        let acknowledged = 7 + ((lines - 7) as f64 * at) as usize;
        let history = broken_at(&text, acknowledged, (acknowledged + ahead).min(lines));
        let options = ResumeOptions { overlap: [Overlap::Mm(0.0), Overlap::Mm(5.0), Overlap::Lines(3), Overlap::Mm(1e9)][overlap], ..operator() };
        let place = [-50.0, -70.0, -30.0];
        let plan = match resume(&text, &fingerprint(text.as_bytes()), &history, &here(place), &options) {
            Ok(plan) => plan,
            Err(e) => return Err(TestCaseError::fail(e.to_string())),
        };
        let straight = states(&text, reset_state(START));
        let rest = plan.program(&text);
        let resumed = states(&rest, reset_state(place));
        let map = plan.map();
        prop_assert_eq!(rest.lines().count(), map.head + lines - map.entry + 1);
        prop_assert!(plan.entry.line <= plan.zones.unwrap().first);
        let same = same_modes(&straight[map.entry - 1], &resumed[map.head]);
        prop_assert!(same.is_ok(), "{}", same.unwrap_err());
        for line in map.entry..=lines {
            let same = same_modes(&straight[line], &resumed[map.head + line - map.entry + 1]);
            prop_assert!(same.is_ok(), "line {line}: {}", same.unwrap_err());
        }
        // The way in: up first, over at a safe height, down at feed and last.
        let highest = straight[4..].iter().map(|s| s.machine_position().z).fold(f64::MIN, f64::max);
        let mut lifted = false;
        for (before, after) in resumed.iter().zip(&resumed[1..=map.head]) {
            let (a, b) = (before.machine_position(), after.machine_position());
            let over = (a.xy() - b.xy()).norm() > 1e-9;
            prop_assert!(!over || lifted && a.z >= highest - 1e-9 && a.z == b.z, "{a} {b}");
            lifted |= before.motion == MotionMode::Rapid && b.z >= highest.max(place[2]) - 1e-9;
        }
        prop_assert!((plan.way.safe_z - resumed[..=map.head].iter().map(|s| s.machine_position().z).fold(f64::MIN, f64::max)).abs() < 1e-9);
    }

    /// Without a journal: where the program alone tells the place, any line can be begun at, from wherever the machine stands.
    #[test]
    fn any_line_can_be_begun_at(seed: u64, at in 0.0..1.0f64) {
        let text = program(seed, 60);
        let lines = text.lines().count();
        let line = 7 + ((lines - 7) as f64 * at) as usize;
        let place = [-50.0, -70.0, -30.0];
        let options = ResumeOptions { overlap: Overlap::Nothing, ..ResumeOptions::default() };
        let plan = match from_line(&text, line, false, &here(place), &options) {
            Ok(plan) => plan,
            Err(Refusal::NoEntry { .. } | Refusal::StartUnknown { .. }) => return Ok(()),
            Err(e) => return Err(TestCaseError::fail(e.to_string())),
        };
        prop_assert!(plan.entry.line >= line && plan.zones.is_none());
        let straight = states(&text, reset_state(place));
        let resumed = states(&plan.program(&text), reset_state(place));
        let same = same_modes(&straight[plan.entry.line - 1], &resumed[plan.head.len()]);
        prop_assert!(same.is_ok(), "{}", same.unwrap_err());
    }
}

const SQUARE: &str =
    "G21 G90\nM3 S8000\nG0 Z10\nG0 X0 Y0\nG1 Z-1 F200\nG1 X20 F800\nY20\nX0\nY0\nG0 Z10\nM5\nM30\n";

fn refusal(text: &str, history: &History, now: &Now, options: &ResumeOptions) -> String {
    match resume(text, &fingerprint(text.as_bytes()), history, now, options) {
        Ok(plan) => panic!("not refused:\n{plan}"),
        Err(e) => e.to_string(),
    }
}

/// On the path of SQUARE: machine coordinates of work X10 Y0 Z-1.
const ON_PATH: [f64; 3] = [-90.0, -90.0, -61.0];

#[test]
fn a_plan_is_shown_in_words() {
    let history = broken_at(SQUARE, 7, 8);
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &history,
        &here(ON_PATH),
        &ResumeOptions::default(),
    )
    .unwrap();
    // The job began at work X5 Y5 Z40, the highest it ever stood is its Z10; no feed was set by then.
    assert_eq!(
        plan.head.join(" "),
        "G17G21G90G94 M5 M9 G49 G92.1 G54 G53G0Z-20 G0X5Y5 S8000 M3 G4P5 G1Z40F60 G93 G94 G0"
    );
    let words = plan.to_string();
    for part in [
        "surely cut       1 to 2",
        "maybe cut        3 to 8",
        "not sent         9 to 12",
        "the machine stands on the path of these lines",
        "entry:             line 3 `G0 Z10`",
        "lift to          Z-20.000",
        "spindle          M3 8000 rpm, 5 s to come to speed",
        "coolant          off",
    ] {
        assert!(words.contains(part), "{part}:\n{words}");
    }
}

#[test]
fn what_is_not_trustworthy_is_refused_and_says_what_to_do() {
    let shown = ResumeOptions::default();
    let history = broken_at(SQUARE, 9, 10);
    let now = here(ON_PATH);
    assert!(
        resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &history,
            &now,
            &shown
        )
        .is_ok()
    );

    // The program.
    let other = SQUARE.replace("X20", "X21");
    let e = refusal(&other, &history, &now, &shown);
    assert!(
        e.contains("not the one that was sent (as many lines, but other bytes)")
            && e.contains("--discard-journal"),
        "{e}"
    );
    let e = refusal(&format!("{SQUARE}G0\n"), &history, &now, &operator());
    assert!(e.contains("13 lines now, 12 then"), "{e}");

    // The job.
    let done = [
        Record::Sent { line: 12 },
        Record::End {
            how: "done".into(),
            done: true,
            position_kept: true,
            at_rest: true,
        },
    ];
    assert!(
        refusal(SQUARE, &history_of(SQUARE, &done), &now, &shown).contains("nothing to resume")
    );
    assert!(
        refusal(
            SQUARE,
            &history_of(
                SQUARE,
                &[Record::End {
                    how: "silent".into(),
                    done: false,
                    position_kept: true,
                    at_rest: true
                }]
            ),
            &now,
            &shown
        )
        .contains("nothing of the program was sent")
    );
    assert!(refusal(SQUARE, &History::default(), &now, &shown).contains("does not even tell"));

    // The machine.
    let with = |change: &dyn Fn(&mut Now)| {
        let mut n = now.clone();
        change(&mut n);
        n
    };
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| n.machine = "other".into()),
        &operator(),
    );
    assert!(e.contains("of machine `test`, and this is `other`"), "{e}");
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| n.state = "Alarm".into()),
        &operator(),
    );
    assert!(e.contains("state Alarm: home it (`morsemill home`)"), "{e}");
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| n.state = "Hold:0".into()),
        &operator(),
    );
    assert!(e.contains("state Hold:0: end its hold"), "{e}");
    let e = refusal(SQUARE, &history, &with(&|n| n.position = None), &operator());
    assert!(e.contains("does not tell where"), "{e}");
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| {
            n.settings.iter_mut().for_each(|s| {
                if s.0 == 100 {
                    s.1 = 80.0
                }
            })
        }),
        &operator(),
    );
    assert!(
        e.contains("$100 was 250 when the job began and is 80 now")
            && e.contains("set $100=250 again"),
        "{e}"
    );

    // The position: switched off and on, it believes to stand at zero.
    let e = refusal(SQUARE, &history, &here([0.0; 3]), &shown);
    assert!(
        e.contains("mm from any place where this job can have stopped")
            && e.contains("morsemill home"),
        "{e}"
    );
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &history,
        &here([0.0, 0.0, -3.0]),
        &operator(),
    )
    .unwrap();
    assert_eq!(plan.evidence, Some(Evidence::Operator));
    // Never lower than it stands.
    assert_eq!(plan.way.safe_z, -3.0);

    // Offsets.
    let moved = with(&|n| n.offsets.g5x[0][2] += 1.5);
    let e = refusal(SQUARE, &history, &moved, &shown);
    assert!(e.starts_with("G54 was X-100.000 Y-90.000 Z-60.000 when the job broke and is X-100.000 Y-90.000 Z-58.500 now"), "{e}");
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &history,
        &moved,
        &operator(),
    )
    .unwrap();
    assert!(
        plan.to_string()
            .contains("you answer for it: the zero of G54 was moved by X0.000 Y0.000 Z1.500"),
        "{plan}"
    );
    assert_eq!(plan.way.safe_z, -20.0 + 1.5);

    // Alarms, resets, refused lines, damage.
    let end = Record::End {
        how: "alarm".into(),
        done: false,
        position_kept: true,
        at_rest: true,
    };
    let after = |record: Record| {
        history_of(
            SQUARE,
            &[
                Record::Sent { line: 10 },
                Record::Acknowledged { line: 9 },
                record,
                end.clone(),
            ],
        )
    };
    for (record, said) in [
        (Record::Alarm { code: 1 }, "ALARM:1 struck"),
        (Record::Alarm { code: 3 }, "ALARM:3 struck"),
        (Record::Alarm { code: 8 }, "ALARM:8 struck"),
        (Record::Reset, "the controller restarted by itself"),
        (
            Record::Error { line: 7, code: 33 },
            "refused line 7 with error:33",
        ),
    ] {
        let history = after(record.clone());
        let e = refusal(SQUARE, &history, &now, &shown);
        assert!(e.starts_with(said) || e.contains(said), "{e}");
        assert!(e.contains("--trust-position"), "{e}");
        let plan = resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &history,
            &now,
            &operator(),
        )
        .unwrap();
        assert!(plan.notes[0].starts_with("you answer for it: "), "{plan}");
        // Homed, on a machine that homes: good again, but for a part cut wrong.
        let mut homed = here([-1.0, -1.0, -1.0]);
        for setting in homed.settings.iter_mut().filter(|s| s.0 == 22) {
            setting.1 = 1.0;
        }
        let again = resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &history,
            &homed,
            &shown,
        );
        match record {
            Record::Error { .. } => assert!(again.is_err()),
            _ => assert_eq!(again.unwrap().evidence, Some(Evidence::Homed)),
        }
        let mut away = homed.clone();
        away.position = Some(ON_PATH);
        if !matches!(record, Record::Error { .. }) {
            assert!(
                refusal(SQUARE, &history, &away, &shown)
                    .contains("Home the machine (`morsemill home`), leave it there")
            );
        }
    }
    // Alarms that stop in order are none.
    assert!(
        resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &after(Record::Alarm { code: 2 }),
            &now,
            &shown
        )
        .is_ok()
    );

    // Heights.
    let low = ResumeOptions {
        safe_z: Some(-51.0),
        ..shown
    };
    assert!(
        refusal(SQUARE, &history, &now, &low)
            .contains("--safe-z -51.000 is below the highest place")
    );
    let high = ResumeOptions {
        safe_z: Some(2.0),
        ..shown
    };
    let soft = with(&|n| {
        n.settings.iter_mut().for_each(|s| {
            if s.0 == 20 {
                s.1 = 1.0
            }
        })
    });
    assert!(refusal(SQUARE, &history, &soft, &high).starts_with(
        "Z 2.000 mm (machine coordinates) lies outside of the travel from -200.000 to 0.000"
    ));
}

#[test]
fn a_start_by_line_number_needs_a_program_that_tells_the_place() {
    let options = ResumeOptions {
        overlap: Overlap::Nothing,
        ..ResumeOptions::default()
    };
    let from = |text: &str, line| from_line(text, line, false, &here(ON_PATH), &options);
    assert_eq!(from(SQUARE, 8).unwrap().entry.line, 8);
    assert_eq!(
        from(SQUARE, 0).unwrap_err().to_string(),
        "there is no line 0 in this program of 12 lines"
    );
    assert!(from(SQUARE, 13).is_err());
    // The lines before never say where Y is.
    let text = "G21 G90\nG0 Z10\nG1 X5 F100\nX10\nX20\n";
    assert!(
        from(text, 4)
            .unwrap_err()
            .to_string()
            .contains("depends on where the machine stood")
    );
    assert!(
        from("G0 X0 Y0 Z0\nG38.2 Z-5 F50\nG0 Z5\nX5\n", 4)
            .unwrap_err()
            .to_string()
            .starts_with("line 2 probes")
    );
    assert!(
        from("G0 X0 Y0 Z5\nM5\nM30\n", 2)
            .unwrap_err()
            .to_string()
            .contains("what is left needs no cutting")
    );
}

#[test]
fn a_crash_of_the_host_widens_the_zone_by_what_the_disk_may_have_missed() {
    let mut text = String::from("G21 G90\nG0 X0 Y0 Z1\nG1 Z0 F500\n");
    for i in 1..20000 {
        text.push_str(&format!("X{}\n", i % 50));
    }
    let crashed = history_of(
        &text,
        &[
            Record::Allow { line: 130 },
            Record::Sent { line: 110 },
            Record::Acknowledged { line: 100 },
        ],
    );
    let same = zones(&text, taken(&crashed), &crashed, Some("boot")).unwrap();
    assert_eq!((same.first, same.last), (101 - HELD, 130));
    let rebooted = zones(&text, taken(&crashed), &crashed, Some("another boot")).unwrap();
    assert_eq!(rebooted.first, 101 - HELD);
    // Two seconds at 11,520 bytes a second and two buffers, in lines of 4 bytes or less.
    let bytes: usize = text
        .lines()
        .take(rebooted.last)
        .skip(130)
        .map(|l| l.len() + 1)
        .sum();
    assert!((23_040 + 256..23_040 + 256 + 5).contains(&bytes), "{bytes}");
    assert_eq!(
        zones(&text, taken(&crashed), &crashed, None).unwrap(),
        rebooted
    );
    // Ended in order: what was sent.
    let ended = broken_at(&text, 100, 110);
    assert_eq!(zones(&text, taken(&ended), &ended, None).unwrap().last, 110);
}

#[test]
fn a_job_can_break_again_while_it_is_resumed() {
    let text = SQUARE;
    let sha = fingerprint(text.as_bytes());
    let plan = resume(
        text,
        &sha,
        &broken_at(text, 9, 10),
        &here(ON_PATH),
        &ResumeOptions::default(),
    )
    .unwrap();
    let again = Begin {
        start: plan.start.clone(),
        resumed: Some(plan.resumed()),
        ..begin(text)
    };
    let mut w = Writer::new();
    w.note(Record::Begin(Box::new(again)), Duration::ZERO);
    // Killed on the way in: nothing of the program was sent yet, and all that was in doubt is in doubt still.
    let killed = read(&w.take()[..]).unwrap();
    let z = zones(text, taken(&killed), &killed, Some("boot")).unwrap();
    assert_eq!((z.first, z.last), (plan.entry.line, 10));
    let second = resume(text, &sha, &killed, &here(ON_PATH), &operator()).unwrap();
    assert!(second.entry.line <= plan.entry.line);
}
