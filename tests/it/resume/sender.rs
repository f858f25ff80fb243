//! A sender of a few lines, that counts characters and keeps a journal, and the controller it feeds on a clock turned by hand: a witness
//! beside the session, which the campaign tries.

use super::{RX, significant};
use crate::chance::Chance;
use morsemill::controller::Controller;
use morsemill::link::journal::{Allowance, Begin, Record, Writer};
use std::collections::VecDeque;
use std::time::Duration;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Break {
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
pub struct Sender {
    pub controller: Controller,
    pub text: Vec<String>,
    /// Lines whose text is not of the program (the way in), first.
    own: usize,
    first_line: usize,
    sent: usize,
    pub acknowledged: usize,
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
    pub way: f64,
    pub refused: bool,
}

impl Sender {
    /// `own` lines of the text come before line `first_line` of the program.
    pub fn new(
        controller: Controller,
        text: &str,
        own: usize,
        first_line: usize,
        begin: Begin,
        delay: u64,
    ) -> Sender {
        let mut writer = Writer::new();
        writer.note(Record::Begin(Box::new(begin)), Duration::ZERO);
        let journal = writer.take();
        Sender {
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
    pub fn original(&self, line: usize) -> usize {
        if line > self.own {
            line - self.own - 1 + self.first_line
        } else {
            0
        }
    }

    pub fn now(&self) -> Duration {
        Duration::from_millis(self.ms)
    }

    pub fn bytes(line: &str) -> usize {
        if line.is_empty() { 0 } else { line.len() + 1 }
    }

    /// Lets the axes go on, and measures their way.
    pub fn turn(&mut self, seconds: f64) {
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

    pub fn host(&mut self) {
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
                self.acknowledged_bytes += Sender::bytes(&self.text[self.acknowledged]);
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
                text.get(n - 1).map(|l| Sender::bytes(l))
            });
        if let Some(line) = more {
            let bytes = self.writer.allow(self.original(line), self.now());
            self.journal.extend(bytes);
        }
        while self.sent < self.text.len().min(self.allowance.allowed()) {
            let line = self.text[self.sent].clone();
            let bytes = Sender::bytes(&line);
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

    pub fn cable(&mut self) {
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

    pub fn tick(&mut self) {
        self.ms += 1;
        if self.ms.is_multiple_of(200) && !self.controller.is_moving() {
            // The operator goes on behind an M0; in a dwell it does nothing.
            self.controller.feed(b"~");
        }
        self.turn(0.001);
        self.cable();
        self.host();
    }

    pub fn done(&self) -> bool {
        self.acknowledged_bytes == self.sent_bytes
            && self.sent == self.text.len()
            && !self.controller.is_moving()
    }

    /// Runs to the end.
    pub fn finish(&mut self) {
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

    /// The controller goes on alone until it stands: at the end of all it has, or at an M0, where nobody tells it to go on.
    pub fn run_dry(&mut self) {
        let mut quiet = 0.0;
        for _ in 0..1_000_000 {
            self.turn(0.005);
            self.controller.output();
            quiet = if self.controller.is_moving() {
                0.0
            } else {
                quiet + 0.005
            };
            // Longer than any dwell of these programs.
            if quiet > 3.0 {
                return;
            }
        }
        panic!("it never stands");
    }

    pub fn end(&mut self, kept: bool, at_rest: bool) {
        let end = Record::End {
            how: "broken".into(),
            done: false,
            position_kept: kept,
            at_rest,
            cable_sound: true,
        };
        self.writer.note(end, self.now());
        let bytes = self.writer.take();
        self.journal.extend(bytes);
    }

    /// Breaks the job; what is left of the journal.
    pub fn break_off(&mut self, how: Break, dice: &mut Chance) -> Vec<u8> {
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
