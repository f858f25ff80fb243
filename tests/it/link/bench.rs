//! Both ends on a clock turned by hand, and the programs they are given.

use super::cable::Cable;
use morsemill::controller::{Controller, Memory};
use morsemill::geom::Point;
use morsemill::link::{
    Command, Job, Known, Outcome, Progress, Session, SessionOptions, Text, VetOptions, vet,
};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

pub fn memory() -> Memory {
    let mut m = Memory::default();
    for axis in 0..3 {
        m.set(110 + axis, 3000.0);
        m.set(120 + axis, 500.0);
    }
    m
}

/// Both ends, a millisecond at a time.
pub struct Bench {
    pub session: Session,
    pub controller: Controller,
    pub there: Cable,
    pub back: Cable,
    pub now: u64,
    pub most_in_flight: usize,
    pub news: Vec<Progress>,
    /// Most bytes the port takes at once, in turn.
    pub takes: Vec<usize>,
    /// Bytes that noise turns into others on their way out, once.
    pub noise: Option<(&'static str, &'static str)>,
    /// What went out, by line or real-time byte, and what was answered (`<ok`), with the time in ms.
    pub log: Vec<(u64, String)>,
    /// Lines under way, and the end of the log that is no whole line yet.
    pub under_way: VecDeque<String>,
    pub partial: String,
    /// Most dangerous lines under way at once: rapids, and Z alone.
    pub most_dangerous: usize,
}

pub fn is_dangerous(line: &str) -> bool {
    line.starts_with("G0") && line.contains(['X', 'Y', 'Z']) || line.starts_with("G1Z")
}

impl Bench {
    pub fn new(job: Job, controller: Controller, there: Cable, back: Cable) -> Bench {
        let session = Session::new(job, SessionOptions::default());
        Bench {
            session,
            controller,
            there,
            back,
            now: 0,
            most_in_flight: 0,
            news: Vec::new(),
            takes: vec![usize::MAX],
            noise: None,
            log: Vec::new(),
            under_way: VecDeque::new(),
            partial: String::new(),
            most_dangerous: 0,
        }
    }

    pub fn plain(program: &str) -> Bench {
        Bench::with(program, VetOptions::default())
    }

    pub fn with(program: &str, options: VetOptions) -> Bench {
        let cable = Cable::new(vec![1], vec![1000]);
        let job = vet(Arc::new(Text(program.into())), options, &mut |_, _| {}).unwrap();
        Bench::new(job, Controller::new(memory()), cable.clone(), cable)
    }

    pub fn tick(&mut self) {
        self.now += 1;
        let now = Duration::from_millis(self.now);
        self.controller.advance(0.001);
        let said = self.controller.output();
        self.back.send(self.now, &said);
        let arrived = self.back.arrive(self.now);
        for _ in arrived.windows(4).filter(|w| w == b"ok\r\n") {
            self.under_way.pop_front();
            self.log.push((self.now, "<ok".to_string()));
        }
        self.session.receive(&arrived, now);
        self.session.tick(now);
        let mut out = self.session.output();
        out.truncate(self.takes[self.now as usize % self.takes.len()]);
        self.session.written(out.len());
        if let Some((from, to)) = self.noise {
            let text: String = out.iter().map(|b| char::from(*b)).collect();
            if text.contains(from) {
                out = text
                    .replacen(from, to, 1)
                    .chars()
                    .map(|c| c as u32 as u8)
                    .collect();
                self.noise = None;
            }
        }
        self.record(&out);
        self.there.send(self.now, &out);
        let heard = self.there.arrive(self.now);
        self.controller.feed(&heard);
        self.most_in_flight = self.most_in_flight.max(self.session.in_flight());
        self.news.extend(self.session.news());
    }

    pub fn record(&mut self, out: &[u8]) {
        for byte in out {
            match byte {
                b'\n' => {
                    let line = std::mem::take(&mut self.partial);
                    self.log.push((self.now, line.clone()));
                    self.under_way.push_back(line);
                    let dangerous = self.under_way.iter().filter(|l| is_dangerous(l)).count();
                    self.most_dangerous = self.most_dangerous.max(dangerous);
                }
                b'?' | b'!' | b'~' | 0x18 | 0x80.. => {
                    self.log.push((self.now, char::from(*byte).to_string()));
                }
                _ => self.partial.push(char::from(*byte)),
            }
        }
    }

    /// When this went out, ms.
    pub fn times(&self, what: &str) -> Vec<u64> {
        self.log
            .iter()
            .filter(|l| l.1 == what)
            .map(|l| l.0)
            .collect()
    }

    pub fn until(&mut self, word: &str) {
        for _ in 0..120_000 {
            if self.heard(word) {
                return;
            }
            self.tick();
        }
        panic!("never heard of {word}: {:?}", self.news);
    }

    pub fn ticks(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.tick();
        }
    }

    pub fn command(&mut self, command: Command) {
        self.session
            .command(command, Duration::from_millis(self.now));
    }

    pub fn finish(&mut self) -> Outcome {
        for _ in 0..600_000 {
            if let Some(outcome) = self.session.outcome() {
                return outcome;
            }
            self.tick();
        }
        panic!("no end after ten minutes: {:?}", self.session);
    }

    pub fn heard(&self, word: &str) -> bool {
        self.news.iter().any(|n| match n {
            Progress::Prompt(prompt) => prompt.to_string().contains(word),
            Progress::Report(_) => false,
            other => format!("{other:?}").contains(word),
        })
    }
}

/// A flat spiral of short segments, as the passes of a freeform part are.
pub fn spiral(lines: usize, step: f64) -> String {
    let mut text =
        String::from("G21 G90 G17 G94\nM3 S1000\nG0 Z5\nG0 X0.5 Y0\nG1 Z-1 F500\nF1500\n");
    let mut angle: f64 = 0.0;
    for i in 0..lines {
        let radius = 0.5 + 0.08 * angle;
        angle += step / radius;
        let (x, y) = (radius * angle.cos(), radius * angle.sin());
        let z = -1.0 + 0.3 * (i as f64 * 0.01).sin();
        text.push_str(&format!("G1 X{x:.3} Y{y:.3} Z{z:.3}\n"));
    }
    text.push_str("G0 Z5\nM5\nG0 X0 Y0\nM30\n");
    text
}

pub const SQUARE: &str = "G21 G90\nG0 X5 Y5\nG1 Z-1 F300\nG1 X15 F1500\nY15\nX5\nG2 X5 Y5 I0 J-5\nG4 P0.5\nG0 Z5\nG0 X1 Y2\nM30\n";

/// The text of line `n` of a program, as it travels.
pub fn line_of(program: &str, n: usize) -> String {
    program.lines().nth(n - 1).unwrap().replace(' ', "")
}

/// What a stock controller says of itself, for sessions whose far side is played by hand.
pub fn stock() -> Known {
    let mut bench = Bench::plain("G0X1\n");
    bench.until("Started");
    bench.session.controller().clone()
}

/// A session with lines under way and a far side that says what it is told to, once per 100 ms.
pub fn told(says: &str, seconds: u64) -> (Session, Vec<Progress>) {
    let job = Job::vet("G1X1F100\nG1X2\nG1X3\nG1X4\nG1X5\nG1X6\n").unwrap();
    let mut session = Session::known(job, stock(), SessionOptions::default(), Duration::ZERO);
    let mut news = Vec::new();
    for ms in (0..seconds * 1000).step_by(100) {
        let now = Duration::from_millis(ms);
        session.tick(now);
        session.written(session.output().len());
        session.receive(says.as_bytes(), now);
        news.extend(session.news());
    }
    (session, news)
}

/// After the end: nothing moves any more, whatever the controller had received.
pub fn at_rest_for_good(bench: &mut Bench, outcome: &Outcome) {
    let place = bench.controller.position();
    if let Some(p) = outcome.position {
        // A report is rounded to three decimals from whole steps of 1/250 mm.
        let off = (place - Point::from(p)).abs();
        assert!(off.max() < 0.5 / 250.0 + 0.0006, "{place:?} {p:?}");
    }
    let rest = bench.there.arrive(u64::MAX);
    bench.controller.feed(&rest);
    bench.controller.advance(120.0);
    assert_eq!(bench.controller.position(), place);
}
