//! `kill -9` of the real program at random moments, over a socket to a controller that goes on: what it left opens, tells the truth, and
//! is taken up until the job is done. The part is then the one of a job that nobody killed.

use super::super::campaign::jobs::{Corner, way};
use super::super::campaign::material::{Cuts, cuts_of_way, same_part};
use crate::chance::Chance;
use morsemill::controller::{Controller, Guests, News, Pace, Rig, RigOptions, Tcp};
use morsemill::geom::{Point, Vector};
use morsemill::link::journal::{Damage, History, Resumed, read};
use morsemill::link::resume::{Refusal, zones};
use morsemill::machine::Machine;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Patience with other processes on a busy computer; nothing is measured by it.
const PATIENCE: Duration = Duration::from_secs(120);
/// Where the part's zero is, machine coordinates, mm.
const ZERO: [f64; 3] = [-200.0, -120.0, -20.0];
const MACHINE: &str = "grbl-3018";
/// Times real time.
const SPEED: f64 = 10.0;

/// The mill, driven away from where it was switched on.
fn mill() -> Controller {
    let mut controller = Controller::of_machine(&Machine::load(MACHINE).unwrap());
    controller.set_work_zero(&Point::from(ZERO));
    super::super::campaign::bench::standing_at(controller, [-150.0, -100.0, -5.0])
}

/// Passes of short moves, with arcs, a retract between them and a stop of the spindle; no place is come to twice.
fn passes(dice: &mut Chance) -> String {
    let mut text = String::from("G21 G90 G17 G94\nM3 S8000\nG0 Z5\n");
    for pass in 0..4 {
        let y = f64::from(pass) * 4.0;
        text.push_str(&format!(
            "G0 X{:.3} Y{y:.3}\nG1 Z-0.{} F300\n",
            -f64::from(pass) * 0.37,
            pass + 2
        ));
        let (mut x, mut at) = (-f64::from(pass) * 0.37, y);
        for _ in 0..60 {
            if dice.roll(12) == 0 {
                x += 2.0;
                text.push_str(&format!("G2 X{x:.3} Y{at:.3} I1 J0 F1200\nG1\n"));
            } else {
                x += 0.2 + 0.6 * dice.part();
                at = y + 0.5 * dice.part();
                text.push_str(&format!("G1 X{x:.3} Y{at:.3} F1400\n"));
            }
        }
        text.push_str(&format!(
            "G0 Z{:.2}\n{}",
            4.0 + 0.1 * f64::from(pass),
            ["", "M8\n", "M9\n", "G4 P0.2\n"][pass as usize]
        ));
    }
    text.push_str("G0 Z5\nM5\nM30\n");
    text
}

/// The controller, the program and its journal.
pub struct Table {
    tcp: Tcp,
    news: Receiver<News>,
    dir: tempfile::TempDir,
    text: String,
}

impl Table {
    pub fn lay(dice: &mut Chance) -> Table {
        let controller = mill();
        let rig = Rig::new(
            controller,
            RigOptions {
                record: true,
                ..RigOptions::default()
            },
        );
        let (sender, news) = channel();
        let tcp = Tcp::serve(
            rig,
            "127.0.0.1:0",
            Guests::Local,
            Pace::Times(SPEED),
            Some(sender),
        )
        .unwrap();
        let dir = tempfile::tempdir().unwrap();
        let text = passes(dice);
        std::fs::write(dir.path().join("part.nc"), &text).unwrap();
        Table {
            tcp,
            news,
            dir,
            text,
        }
    }

    pub fn program(&self) -> PathBuf {
        self.dir.path().join("part.nc")
    }

    pub fn journal(&self) -> PathBuf {
        self.dir.path().join("part.nc.journal")
    }

    pub fn arguments(&self) -> Vec<String> {
        let port = format!("tcp://{}", self.tcp.address());
        let program = self.program().display().to_string();
        ["send", &program, "--machine", MACHINE, "--port", &port]
            .map(String::from)
            .to_vec()
    }

    pub fn send(&self, more: &[&str]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_morsemill"))
            .args(self.arguments())
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// Waits until the axes have stood for a while; where.
    pub fn rest(&self) -> Point {
        let began = Instant::now();
        let mut quiet = Instant::now();
        while quiet.elapsed() < Duration::from_millis(500) {
            if self.tcp.readout().moving {
                quiet = Instant::now();
            }
            assert!(began.elapsed() < PATIENCE, "it never stands");
            std::thread::sleep(Duration::from_millis(2));
        }
        Point::from(self.tcp.readout().position)
    }
}

fn history(path: &Path) -> Option<History> {
    let bytes = std::fs::read(path).ok()?;
    Some(read(&bytes[..]).unwrap())
}

pub fn told(out: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&out.stdout),
        String::from_utf8_lossy(&out.stderr)
    )
}

/// How the next sender takes it up: by what the killed one left.
enum Left {
    Nothing,
    ToDiscard,
    ToResume,
    Done,
}

/// What a killed sender left is a journal that tells the truth.
fn left(table: &Table, corners: &[Corner]) -> Left {
    let place = table.rest();
    let Some(history) = history(&table.journal()) else {
        return Left::Nothing;
    };
    assert!(
        !matches!(history.damage, Damage::Broken { .. } | Damage::Zeros { .. }),
        "{:?}",
        history.damage
    );
    if history.done {
        return Left::Done;
    }
    assert!(history.end.is_none(), "{:?}", history.end);
    assert!(
        history.allowed.max(
            history
                .begin
                .as_ref()
                .map_or(0, |b| b.resumed.map_or(0, |r| r.maybe_to))
        ) >= history.sent
    );
    let begin = history.begin.as_ref().unwrap();
    let z = match zones(&table.text, begin, &history, begin.boot.as_deref()) {
        Ok(z) => z,
        Err(Refusal::NothingSent) => return Left::ToDiscard,
        Err(e) => panic!("{e}"),
    };
    // It ran dry, so it stands where a line ends, unless it was on its way in; lines that do not move end there too.
    let came = |r: Resumed| history.acknowledged >= r.entry;
    if begin.resumed.is_none_or(came) {
        let stop = corners.iter().rposition(|c| (c.to - place).norm() < 0.01);
        let stop = stop.unwrap_or_else(|| panic!("{place:?} is no line's end, {history:?}"));
        let until = corners.get(stop + 1).map_or(z.lines, |c| c.line - 1);
        assert!(
            corners[stop].line <= z.last && z.first - 1 <= until,
            "stands at the end of line {} to {until}, but {z:?}",
            corners[stop].line
        );
    }
    Left::ToResume
}

/// Kills a job so many times, and lets it be done then. How often it was taken up.
fn kill_and_resume(seed: u64, kills: usize) -> usize {
    let mut dice = Chance(seed);
    let table = Table::lay(&mut dice);
    let corners = way(
        &table.text,
        &super::super::campaign::bench::introduce(&mill()).start(),
    );
    let (mut resumed, mut next) = (0, Left::Nothing);
    for kill in 0..=kills {
        let how: &[&str] = match next {
            Left::Nothing => &[],
            Left::ToDiscard => &["--discard-journal"],
            Left::ToResume => &["--resume", "--yes", "--spin-up", "0"],
            Left::Done => break,
        };
        resumed += usize::from(matches!(next, Left::ToResume));
        let before = history(&table.journal());
        let mut child = table.send(how);
        if kill == kills {
            let out = child.wait_with_output().unwrap();
            assert_eq!(out.status.code(), Some(0), "seed {seed}: {}", told(&out));
            break;
        }
        // Until its own journal is there, or now and then not even so long; the moment within is the dice's and the system's.
        let began = Instant::now();
        let begins = dice.roll(8) > 0;
        while begins && history(&table.journal()) == before && child.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < PATIENCE);
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_micros(dice.roll(400_000) as u64));
        let ended = child.try_wait().unwrap();
        child.kill().unwrap();
        let out = child.wait_with_output().unwrap();
        if let Some(status) = ended {
            assert_eq!(status.code(), Some(0), "seed {seed}: {}", told(&out));
        }
        next = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| left(&table, &corners)))
            .unwrap_or_else(|_| panic!("seed {seed}, {how:?}: {}", told(&out)));
    }
    let last = history(&table.journal()).unwrap();
    assert!(last.done, "seed {seed}: {last:?}");
    let Table { tcp, news, .. } = table;
    let mut rig = tcp.stop().unwrap();
    let mut pieces = Vec::new();
    for news in news.try_iter() {
        if let News::Left(drive) | News::ProgramEnded(drive) = news {
            pieces.extend(drive.pieces);
        }
    }
    pieces.extend(rig.take_drive().pieces);
    // The way driven is told from the part's zero.
    let zero = Vector::from(ZERO);
    let cuts: Cuts = pieces
        .iter()
        .filter(|p| !p.rapid)
        .map(|p| (p.from + zero, p.to + zero))
        .collect();
    same_part(
        &cuts_of_way(&corners, false),
        &cuts_of_way(&corners, true),
        &cuts,
    )
    .unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    resumed
}

/// A dozen kills; `KILLS=120 cargo test --test it resume::process` for more.
#[cfg(unix)]
#[test]
fn a_killed_process_leaves_a_journal_that_is_taken_up_to_the_same_part() {
    let kills: usize = std::env::var("KILLS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(12);
    // Four tables at once: most of the time each waits for a greeting that a socket does not give.
    let resumed: usize = std::thread::scope(|s| {
        let tables: Vec<_> = (0..4)
            .map(|seed| {
                s.spawn(move || {
                    (0..kills.div_ceil(12))
                        .map(|n| kill_and_resume(100 * n as u64 + seed, 3))
                        .sum::<usize>()
                })
            })
            .collect();
        tables.into_iter().map(|t| t.join().unwrap()).sum()
    });
    assert!(3 * resumed >= kills, "{resumed} of {kills} were resumed");
}
