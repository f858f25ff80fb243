//! Both ends of the cable together: the session against the simulated controller, first on a clock turned by hand over a pipe that
//! delays and cuts as it likes, then over a real pseudo-terminal.
#![allow(clippy::unwrap_used)]

use morsemill::cli::send::{self, SendArgs};
use morsemill::controller::{Controller, Memory, Pace};
use morsemill::geom::Point;
use morsemill::kinematics::{Settings, program_time};
use morsemill::link::{Command, Ending, Job, Outcome, Progress, Session, SessionOptions};
use morsemill::wire::Firmware;
use morsemill::machine::Machine;
use proptest::prelude::*;
use std::collections::VecDeque;
use std::time::Duration;

fn memory() -> Memory {
    let mut m = Memory::default();
    for axis in 0..3 {
        m.set(110 + axis, 3000.0);
        m.set(120 + axis, 500.0);
    }
    m
}

/// A cable with a delay for each piece of bytes, in milliseconds, repeated; pieces are cut to the sizes given, repeated.
#[derive(Clone, Debug)]
struct Cable {
    delays: Vec<u64>,
    cuts: Vec<usize>,
    turn: usize,
    pieces: VecDeque<(u64, Vec<u8>)>,
}

impl Cable {
    fn new(delays: Vec<u64>, cuts: Vec<usize>) -> Cable {
        Cable {
            delays,
            cuts,
            turn: 0,
            pieces: VecDeque::new(),
        }
    }

    fn send(&mut self, now: u64, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            self.turn += 1;
            let cut = self.cuts[self.turn % self.cuts.len()].clamp(1, rest.len());
            let at = now + self.delays[self.turn % self.delays.len()];
            // Bytes never overtake each other.
            let at = self.pieces.back().map_or(at, |p| p.0.max(at));
            self.pieces.push_back((at, rest[..cut].to_vec()));
            rest = &rest[cut..];
        }
    }

    fn arrive(&mut self, now: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        while self.pieces.front().is_some_and(|p| p.0 <= now) {
            bytes.extend(self.pieces.pop_front().unwrap().1);
        }
        bytes
    }
}

/// Both ends, a millisecond at a time.
struct Bench {
    session: Session,
    controller: Controller,
    there: Cable,
    back: Cable,
    now: u64,
    most_in_flight: usize,
    news: Vec<Progress>,
    /// Most bytes the port takes at once, in turn.
    takes: Vec<usize>,
    /// Bytes that noise turns into others on their way out, once.
    noise: Option<(&'static str, &'static str)>,
    /// Lines the controller was sent, with the number of unanswered ones then.
    heard: Vec<u8>,
}

impl Bench {
    fn new(job: Job, controller: Controller, there: Cable, back: Cable) -> Bench {
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
            heard: Vec::new(),
        }
    }

    fn plain(program: &str) -> Bench {
        let cable = Cable::new(vec![1], vec![1000]);
        Bench::new(
            Job::vet(program).unwrap(),
            Controller::new(memory()),
            cable.clone(),
            cable,
        )
    }

    fn tick(&mut self) {
        self.now += 1;
        let now = Duration::from_millis(self.now);
        self.controller.advance(0.001);
        let said = self.controller.output();
        self.back.send(self.now, &said);
        self.session.receive(&self.back.arrive(self.now), now);
        self.session.tick(now);
        let mut out = self.session.output();
        out.truncate(self.takes[self.now as usize % self.takes.len()]);
        self.session.written(out.len());
        if let Some((from, to)) = self.noise {
            let text: String = out.iter().map(|b| char::from(*b)).collect();
            if text.contains(from) {
                out = text.replacen(from, to, 1).chars().map(|c| c as u32 as u8).collect();
                self.noise = None;
            }
        }
        self.there.send(self.now, &out);
        let heard = self.there.arrive(self.now);
        self.heard.extend(&heard);
        self.controller.feed(&heard);
        self.most_in_flight = self.most_in_flight.max(self.session.in_flight());
        self.news.extend(self.session.news());
    }

    fn ticks(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.tick();
        }
    }

    fn command(&mut self, command: Command) {
        self.session
            .command(command, Duration::from_millis(self.now));
    }

    fn finish(&mut self) -> Outcome {
        for _ in 0..600_000 {
            if let Some(outcome) = self.session.outcome() {
                return outcome;
            }
            self.tick();
        }
        panic!("no end after ten minutes: {:?}", self.session);
    }

    fn heard(&self, word: &str) -> bool {
        self.news.iter().any(|n| match n {
            Progress::Prompt(prompt) => prompt.to_string().contains(word),
            Progress::Report(_) => false,
            other => format!("{other:?}").contains(word),
        })
    }
}

/// A flat spiral of short segments, as the passes of a freeform part are.
fn spiral(lines: usize, step: f64) -> String {
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

const SQUARE: &str = "G21 G90\nG0 X5 Y5\nG1 Z-1 F300\nG1 X15 F1500\nY15\nX5\nG2 X5 Y5 I0 J-5\nG4 P0.5\nG0 Z5\nG0 X1 Y2\nM30\n";

#[test]
fn a_job_runs_to_its_end() {
    let mut bench = Bench::plain(SQUARE);
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Done);
    assert_eq!(
        (outcome.sent, outcome.acknowledged, outcome.total),
        (11, 11, 11)
    );
    assert_eq!(outcome.position, Some([1.0, 2.0, 5.0]));
    assert!(outcome.position_kept);
    assert!(bench.controller.elapsed() > 1.0);
    assert!((bench.controller.position() - Point::new(1.0, 2.0, 5.0)).norm() < 1e-9);
}

#[test]
fn a_controller_that_was_not_reset_by_opening_is_asked() {
    let mut bench = Bench::plain(SQUARE);
    bench.controller.output();
    bench.controller.feed(b"G91 G20\n");
    bench.controller.output();
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Done, "{:?}", bench.news);
    assert!(bench.heard("the controller's modes were G0 G54 G17 G20 G91"));
    assert_eq!(outcome.position, Some([1.0, 2.0, 5.0]));
}

#[test]
fn a_locked_controller_is_left_alone() {
    let mut m = memory();
    m.set(22, 1.0);
    let cable = Cable::new(vec![1], vec![1000]);
    let mut bench = Bench::new(
        Job::vet(SQUARE).unwrap(),
        Controller::new(m),
        cable.clone(),
        cable,
    );
    let outcome = bench.finish();
    assert!(outcome.ending.to_string().contains("home it with $H"));
    assert_eq!(outcome.sent, 0);
}

#[test]
fn hold_and_resume_lose_nothing() {
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(900);
    bench.command(Command::Hold);
    bench.command(Command::Resume); // too early: kept until the hold is at rest
    bench.ticks(600);
    bench.command(Command::Hold);
    bench.ticks(5000);
    let place = bench.controller.position();
    bench.ticks(1000);
    assert_eq!(bench.controller.position(), place);
    assert!(bench.heard("on hold, at rest"));
    bench.command(Command::Resume);
    let outcome = bench.finish();
    assert_eq!(
        (outcome.ending, outcome.position),
        (Ending::Done, Some([1.0, 2.0, 5.0]))
    );
}

#[test]
fn the_program_may_pause_and_the_operator_resumes() {
    let mut bench = Bench::plain("G0X1\nM0\nG0X2\n");
    bench.ticks(6000);
    assert!(
        bench.heard("the program pauses at line 2"),
        "{:?}",
        bench.news
    );
    assert!(bench.session.outcome().is_none());
    bench.command(Command::Resume);
    assert_eq!(bench.finish().ending, Ending::Done);
}

/// The text of line `n` of a program, as it travels.
fn line_of(program: &str, n: usize) -> String {
    program.lines().nth(n - 1).unwrap().replace(' ', "")
}

#[test]
fn a_refused_line_stops_all_that_follows() {
    let program = spiral(500, 0.2);
    let mut bench = Bench::plain(&program);
    let line = line_of(&program, 100);
    let x = line.find('X').unwrap();
    // A damaged byte leaves a word without its number.
    let damaged = format!("{}XX{}", &line[..x], &line[x + 2..]);
    bench.noise = Some((line.clone().leak(), damaged.clone().leak()));
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Refused {
            line: 100,
            text: line,
            code: 2,
            firmware: Firmware::Grbl11,
        }
    );
    assert!(outcome.position_kept);
    assert!(outcome.acknowledged < 130, "{outcome:?}");
    assert!(outcome.ending.to_string().contains("a number is missing"));
    let (first, last) = outcome.maybe.unwrap();
    assert!(first == 101 && last < 115, "{outcome:?}");
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn a_soft_limit_alarm_is_named_and_the_position_survives() {
    let mut m = memory();
    m.set(20, 1.0);
    let cable = Cable::new(vec![1], vec![1000]);
    let mut bench = Bench::new(
        Job::vet("G1 X-5 F600\nG4 P0\nX5\nX6\n").unwrap(),
        Controller::new(m),
        cable.clone(),
        cable,
    );
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Alarm {
            code: 2,
            line: Some(3),
            firmware: Firmware::Grbl11,
        }
    );
    assert!(outcome.position_kept);
    assert_eq!(outcome.position, Some([-5.0, 0.0, 0.0]));
}

#[test]
fn a_reset_of_the_controller_ends_the_job() {
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1500);
    bench.controller.power_cycle();
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::ControllerReset);
    assert!(!outcome.position_kept);
}

#[test]
fn a_lost_reply_is_noticed_and_not_guessed_away() {
    let mut bench = Bench::plain("G0X1\nG4P8\nG0X2\nG0X3\n");
    let mut lost = false;
    for _ in 0..60_000 {
        bench.tick();
        // The first `ok` after the job has begun vanishes on its way back.
        if !lost
            && bench.session.in_flight() > 0
            && let Some(piece) = bench
                .back
                .pieces
                .iter_mut()
                .find(|p| p.1.starts_with(b"ok"))
        {
            piece.1.drain(..4);
            lost = true;
        }
        if bench.session.outcome().is_some() {
            break;
        }
    }
    let outcome = bench.finish();
    assert!(
        matches!(outcome.ending, Ending::LostReply { .. }),
        "{outcome:?}"
    );
    at_rest_for_good(&mut bench, &outcome);
}

#[test]
fn a_pulled_cable_is_noticed() {
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1000);
    bench.back.delays = vec![100_000_000];
    let outcome = bench.finish();
    assert_eq!(
        outcome.ending,
        Ending::Silent {
            waiting_for: "a status report"
        }
    );
    assert!(!outcome.position_kept);
}

#[test]
fn nobody_there_is_told_within_seconds() {
    let mut session = Session::new(Job::vet(SQUARE).unwrap(), SessionOptions::default());
    for ms in 0..10_000 {
        session.tick(Duration::from_millis(ms));
        // It never asks so often that a dead device's buffer fills.
        let out = session.output().len();
        assert!(out < 8);
        session.written(out);
    }
    let outcome = session.outcome().unwrap();
    assert_eq!(
        outcome.ending,
        Ending::Silent {
            waiting_for: "its status"
        }
    );
}

#[test]
fn the_second_ctrl_c_resets_in_motion_and_says_what_it_costs() {
    let mut bench = Bench::plain("G1 X100 F600\n");
    bench.ticks(1500);
    bench.command(Command::ResetNow);
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Aborted);
    assert!(!outcome.position_kept);
    at_rest_for_good(&mut bench, &outcome);
}

/// After the end: nothing moves any more, whatever the controller had received.
fn at_rest_for_good(bench: &mut Bench, outcome: &Outcome) {
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

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the cable's delays and cuts: no byte overflows the ring, every line is answered, the end is the program's.
    #[test]
    fn any_cable_carries_a_job_whole(
        delays in proptest::collection::vec(0u64..30, 1..20), cuts in proptest::collection::vec(1usize..40, 1..20), lines in 20usize..150,
    ) {
        let there = Cable::new(delays.clone(), cuts.clone());
        let back = Cable::new(delays, cuts);
        let job = Job::vet(&spiral(lines, 0.2)).unwrap();
        let mut bench = Bench::new(job, Controller::new(memory()), there, back);
        let outcome = bench.finish();
        prop_assert_eq!(&outcome.ending, &Ending::Done);
        prop_assert_eq!(outcome.acknowledged, outcome.total);
        prop_assert_eq!(bench.controller.bytes_lost(), 0);
        prop_assert!(bench.most_in_flight <= 128);
        prop_assert!((bench.controller.position() - Point::new(0.0, 0.0, 5.0)).norm() < 1e-9);
    }

    /// A stop at any moment: hold, standstill, reset; the position is kept, and nothing queued ever runs.
    #[test]
    fn a_stop_at_any_moment_is_a_clean_one(at in 1u64..8000, delays in proptest::collection::vec(0u64..30, 1..10)) {
        let cable = Cable::new(delays, vec![1000]);
        let job = Job::vet(&format!("{}{}", SQUARE.replace("M30\n", ""), spiral(2000, 0.2))).unwrap();
        let mut bench = Bench::new(job, Controller::new(memory()), cable.clone(), cable);
        bench.ticks(at);
        bench.command(Command::Stop);
        let outcome = bench.finish();
        prop_assert_eq!(&outcome.ending, &Ending::Stopped);
        prop_assert!(outcome.position_kept);
        prop_assert!(!bench.heard("ALARM"));
        at_rest_for_good(&mut bench, &outcome);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever arrives, neither end panics, and a hand-turned clock never runs for ever.
    #[test]
    fn noise_breaks_neither_end(
        words in proptest::collection::vec(proptest::sample::select(vec![
            "G0X1\n", "G1X-3F600\n", "G2X5I2.5F500\n", "$J=X1F100\n", "$H\n", "$X\n", "$C\n", "$SLP\n", "$$\n", "$100=0\n", "$120=0\n",
            "$12=0\n", "$1=255\n", "$22=1\n", "$20=1\n", "$RST=*\n", "$N0=G1\n", "$N1=M0\n", "$N9=X\n", "M0\n", "M30\n", "G4P0.2\n", "G38.2Z-1F50\n",
            "!", "~", "?", "\u{18}", "\u{84}", "\u{85}", "\u{9e}", "\u{91}", "\u{97}", "(", "\r\n", "$J=F60\n", "G92X1\n", "G93G1X2F30\n", "$", "=", "G10L2P1X1\n",
        ]), 0..40),
        noise in proptest::collection::vec(any::<u8>(), 0..60), pause in 0.0f64..0.4,
    ) {
        let mut c = Controller::new(memory());
        for word in &words {
            let bytes: Vec<u8> = word.chars().map(|ch| ch as u32 as u8).collect();
            c.feed(&bytes);
            c.advance(pause);
        }
        c.feed(&noise);
        c.advance(100.0);
        prop_assert!(c.position().iter().all(|p| p.is_finite()));
        let said = c.output();
        let mut session = Session::new(Job::vet(SQUARE).unwrap(), SessionOptions::default());
        for (i, piece) in said.chunks(7).chain(noise.chunks(3)).enumerate() {
            let now = Duration::from_millis(i as u64 * 50);
            session.receive(piece, now);
            session.tick(now);
            session.written(session.output().len());
            prop_assert!(session.in_flight() <= 128);
        }
    }
}

fn send_args(program: &std::path::Path, json: &std::path::Path, speed: Pace) -> SendArgs {
    SendArgs {
        program: program.to_path_buf(),
        machine: "longmill-30x30".to_string(),
        port: "sim".to_string(),
        dry_run: false,
        speed,
        json: Some(json.to_path_buf()),
    }
}

/// Sends over a real pseudo-terminal; the report, and the planner's own time for the program.
fn over_a_pseudo_terminal(program: &str, speed: Pace) -> (u8, serde_json::Value, f64) {
    let dir = tempfile::tempdir().unwrap();
    let (file, json) = (dir.path().join("job.nc"), dir.path().join("out.json"));
    std::fs::write(&file, program).unwrap();
    let mut out = Vec::new();
    let code = send::run(&send_args(&file, &json, speed), &mut out);
    let report = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let machine = Machine::load("longmill-30x30").unwrap();
    let planned = program_time(
        &Job::vet(program).unwrap().events().unwrap(),
        &Settings::from(&machine),
    )
    .total
    .0;
    (code, report, planned)
}

#[test]
fn a_long_job_over_a_pseudo_terminal_takes_the_machine_time_that_was_planned() {
    for (lines, step) in [(8_000, 0.2), (3_000, 0.1), (300, 5.0)] {
        let start = std::time::Instant::now();
        let (code, report, planned) = over_a_pseudo_terminal(&spiral(lines, step), Pace::Unbound);
        eprintln!(
            "{lines} lines of {step} mm: {report} planned {planned:.2} s, real {:?}",
            start.elapsed()
        );
        assert_eq!(code, 0);
        assert_eq!(report["result"], "done");
        assert_eq!(report["lines"], report["acknowledged"]);
        assert_eq!(
            report["final_position_mm"],
            serde_json::json!([0.0, 0.0, 5.0])
        );
        let measured = report["machine_time_s"].as_f64().unwrap();
        assert!(
            (measured / planned - 1.0).abs() < 0.03,
            "{measured} s measured, {planned} s planned"
        );
    }
}

#[test]
fn the_same_in_step_with_a_clock() {
    let (code, report, planned) = over_a_pseudo_terminal(&spiral(400, 0.5), Pace::Times(10.0));
    assert_eq!((code, &report["result"]), (0, &serde_json::json!("done")));
    let measured = report["machine_time_s"].as_f64().unwrap();
    // A busy computer may starve the planner here, as a slow host would; it never makes the job shorter.
    assert!(
        measured > 0.97 * planned,
        "{measured} s measured, {planned} s planned"
    );
}
