//! Errands against the simulated controller, on a clock turned by hand: a millisecond at a time, bytes over the cable with a delay.
#![allow(clippy::unwrap_used)]

use morsemill::controller::{Controller, Memory, Pins, Switches};
use morsemill::link::errand::{
    Console, Down, Errand, ErrandError, ErrandOptions, GoTo, Home, Jog, JogMove, News, Probe,
    ProbeOptions, Reach, Restore, Retract, Rise, Save, Task, ToolLength, Unlock, Verdict, Zero,
    differences, judge,
};
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

/// A machine with switches: homes at the top, high end of X and Y.
fn homing_memory() -> Memory {
    let mut m = memory();
    m.set(22, 1.0);
    m.set(24, 100.0);
    m.set(25, 2000.0);
    m
}

struct Bench<T> {
    errand: Errand<T>,
    mill: Controller,
    now: u64,
    there: VecDeque<(u64, Vec<u8>)>,
    back: VecDeque<(u64, Vec<u8>)>,
    delay: u64,
    sent: Vec<u8>,
    news: Vec<News>,
}

impl<T: Task> Bench<T> {
    fn new(task: T, mill: Controller) -> Bench<T> {
        Bench {
            errand: Errand::again(task, ErrandOptions::default(), Duration::ZERO),
            mill,
            now: 0,
            there: VecDeque::new(),
            back: VecDeque::new(),
            delay: 2,
            sent: Vec::new(),
            news: Vec::new(),
        }
    }

    fn tick(&mut self) {
        self.now += 1;
        let now = Duration::from_millis(self.now);
        self.mill.advance(0.001);
        let said = self.mill.output();
        if !said.is_empty() {
            self.back.push_back((self.now + self.delay, said));
        }
        while self.back.front().is_some_and(|p| p.0 <= self.now) {
            let (_, bytes) = self.back.pop_front().unwrap();
            self.errand.receive(&bytes, now);
        }
        self.errand.tick(now);
        let out = self.errand.output();
        if !out.is_empty() {
            self.sent.extend_from_slice(&out);
            self.there.push_back((self.now + self.delay, out));
        }
        while self.there.front().is_some_and(|p| p.0 <= self.now) {
            let (_, bytes) = self.there.pop_front().unwrap();
            self.mill.feed(&bytes);
        }
        self.news.extend(self.errand.news());
    }

    /// Until it ends, at most `seconds`.
    fn run(&mut self, seconds: u64) -> Result<(), ErrandError> {
        for _ in 0..seconds * 1000 {
            self.tick();
            if let Some(result) = self.errand.result() {
                return result;
            }
        }
        panic!("not ended: {:?}\n{:?}", self.errand, self.said());
    }

    fn said(&self) -> String {
        String::from_utf8_lossy(&self.sent).into_owned()
    }

    fn notes(&self) -> String {
        let notes = self.news.iter().filter_map(|n| match n {
            News::Note(text) | News::Stopping(text) => Some(text.as_str()),
            _ => None,
        });
        notes.collect::<Vec<_>>().join("\n")
    }
}

/// The controller after power-up, greeting taken.
fn mill(memory: Memory) -> Controller {
    let mut mill = Controller::new(memory);
    mill.output();
    mill
}

fn jog(axes: [Option<f64>; 3], feed: f64) -> JogMove {
    JogMove {
        axes,
        feed,
        ..JogMove::default()
    }
}

#[test]
fn homing_is_silent_and_ends_at_the_pull_off() {
    let mut controller = mill(homing_memory());
    controller.set_switches(Switches {
        limits: [None, Some(5_000), None, Some(5_000), None, Some(5_000)],
        probe_z: None,
    });
    let mut b = Bench::new(Home::default(), controller);
    b.run(300).unwrap();
    let p = b.errand.task.position.unwrap();
    for c in p {
        assert!((c + 1.0).abs() < 0.01, "{p:?}");
    }
    // Not one `?` between the line and its answer: the firmware would answer none of them.
    let after = b.said().split_once("$H\n").unwrap().1.to_string();
    let asked = after.matches('?').count();
    assert!(asked <= 4, "{after}");
}

#[test]
fn homing_that_is_switched_off_is_not_tried() {
    let mut b = Bench::new(Home::default(), mill(memory()));
    let e = b.run(20).unwrap_err();
    assert!(
        e.to_string()
            .starts_with("homing is switched off in the controller ($22=0): set $22=1"),
        "{e}"
    );
    assert!(!b.said().contains("$H"));
}

#[test]
fn cancelled_homing_is_reset_and_says_that_the_position_is_lost() {
    let mut b = Bench::new(Home::default(), mill(homing_memory()));
    while !b.said().contains("$H") {
        b.tick();
    }
    for _ in 0..700 {
        b.tick();
    }
    b.errand.cancel(Duration::from_millis(b.now));
    let e = b.run(20).unwrap_err();
    assert_eq!(
        e,
        ErrandError::Cancelled {
            position_kept: false
        }
    );
    assert_eq!(
        e.to_string(),
        "stopped by the operator: the position is lost, home it before going on"
    );
    assert!(!b.mill.is_moving());
}

#[test]
fn unlock_leaves_alarm_and_says_what_the_position_is_worth() {
    let mut b = Bench::new(Unlock::default(), mill(homing_memory()));
    b.run(20).unwrap();
    assert!(b.errand.task.unlocked);
    assert!(
        b.notes()
            .contains("The position is what it was before the alarm")
    );
    assert!(b.said().contains("$X\n"));
    let mut b = Bench::new(Unlock::default(), mill(memory()));
    b.run(20).unwrap();
    assert!(!b.said().contains("$X"));
}

#[test]
fn a_jog_ends_where_it_should_and_in_the_right_unit() {
    let mut b = Bench::new(
        Jog::new(vec![jog([Some(10.0), None, Some(-2.0)], 1200.0)]),
        mill(memory()),
    );
    b.run(30).unwrap();
    let (machine, work) = b.errand.task.ended.unwrap();
    assert_eq!(machine, [10.0, 0.0, -2.0]);
    assert_eq!(work, Some(machine));
    let inch = JogMove {
        units: morsemill::link::errand::JogUnits::Inch,
        reach: Reach::Work,
        ..jog([Some(1.0), None, None], 100.0)
    };
    let mut b = Bench::new(Jog::new(vec![inch]), b.mill);
    b.run(30).unwrap();
    assert!((b.errand.task.ended.unwrap().0[0] - 25.4).abs() < 0.002);
}

#[test]
fn a_locked_controller_jogs_nowhere() {
    let mut b = Bench::new(
        Jog::new(vec![jog([Some(1.0), None, None], 100.0)]),
        mill(homing_memory()),
    );
    assert_eq!(b.run(20).unwrap_err(), ErrandError::Locked);
    assert!(!b.said().contains("$J"));
}

#[test]
fn jogs_beyond_the_travel_are_refused_before_they_start() {
    let mut m = homing_memory();
    m.set(20, 1.0);
    let mut b = Bench::new(Unlock::default(), mill(m));
    b.run(20).unwrap();
    let mut b = Bench::new(Jog::new(vec![jog([Some(5.0), None, None], 100.0)]), b.mill);
    let e = b.run(20).unwrap_err();
    assert_eq!(
        e.to_string(),
        "X would go to 5 mm in machine coordinates, and its travel is from -200 to 0: 5 mm too far"
    );
    assert!(!b.said().contains("$J"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, .. ProptestConfig::default() })]
    /// Whatever is queued and whenever it is cancelled: at the end the machine stands, has kept its position, and stays where it is.
    #[test]
    fn nothing_moves_after_a_cancelled_jog(
        moves in proptest::collection::vec((-20i32..20, -20i32..20, 100u32..3000), 1..25),
        at in 0u64..4000, delay in 0u64..60,
    ) {
        let moves = moves.into_iter().map(|(x, y, f)| jog([Some(f64::from(x) + 0.5), Some(f64::from(y)), None], f64::from(f))).collect();
        let mut b = Bench::new(Jog::new(moves), mill(memory()));
        b.delay = delay;
        let mut ended = None;
        while ended.is_none() && !b.said().contains("$J") {
            b.tick();
            ended = b.errand.result();
        }
        for _ in 0..at {
            if ended.is_none() {
                b.tick();
                ended = b.errand.result();
            }
        }
        b.errand.cancel(Duration::from_millis(b.now));
        let lines = b.said().matches("$J").count();
        let result = ended.unwrap_or_else(|| b.run(60));
        if let Err(e) = result {
            prop_assert!(!b.notes().contains("takes no cancel"));
            prop_assert_eq!(e, ErrandError::Cancelled { position_kept: true });
        }
        prop_assert_eq!(b.said().matches("$J").count(), lines, "no line after the cancel");
        prop_assert!(!b.mill.is_moving());
        let p = b.mill.position();
        for _ in 0..2000 {
            b.tick();
        }
        prop_assert_eq!(p, b.mill.position());
        let known = b.errand.known().machine_position.unwrap();
        prop_assert!((known[0] - p.x).abs() < 0.002 && (known[1] - p.y).abs() < 0.002, "{:?} {:?}", known, p);
    }

    /// Restore: whatever a file holds, no value goes out that GRBL would change or refuse.
    #[test]
    fn restore_never_writes_an_invalid_value(
        wanted in proptest::collection::vec((proptest::sample::select(vec![0u16, 1, 2, 3, 4, 10, 11, 13, 20, 22, 23, 26, 30, 31, 100, 110, 120, 130, 131, 7, 999]),
            "(-?[0-9]{1,4}(\\.[0-9]{1,3})?|nan|1e3|inf|[!?~$;A-Z ]{0,5})"), 1..6),
    ) {
        let mut b = Bench::new(Restore::new(wanted), mill(memory()));
        let result = b.run(60);
        let written = b.errand.task.written.clone();
        if let Err(e) = &result {
            prop_assert!(matches!(e, ErrandError::NotPossible(_)), "{e}");
            prop_assert!(written.is_empty());
        }
        b.mill.feed(b"$$\n");
        let held = String::from_utf8(b.mill.output()).unwrap();
        let held: Vec<&str> = held.lines().collect();
        for (number, value) in &written {
            let value: f64 = value.parse().unwrap();
            let held = held.iter().find_map(|l| l.strip_prefix(&format!("${number}="))?.parse::<f64>().ok()).unwrap();
            prop_assert!((held - value).abs() <= 1e-3 + value.abs() * 1e-6, "${number}: {held} {value}");
        }
    }
}

#[test]
fn zero_is_written_in_quiet_and_read_back() {
    let mut b = Bench::new(
        Jog::new(vec![jog([Some(12.0), Some(7.5), Some(-3.0)], 2000.0)]),
        mill(memory()),
    );
    b.run(30).unwrap();
    let mut b = Bench::new(Zero::new([Some(0.0), Some(1.5), None]), b.mill);
    b.run(30).unwrap();
    assert_eq!(b.errand.task.origin, Some([12.0, 6.0, 0.0]));
    assert_eq!(b.errand.task.position, Some([0.0, 1.5, -3.0]));
    let said = b.said();
    let (_, after) = said.split_once("G10L20P0X0Y1.5\n").unwrap();
    assert!(
        after.starts_with("$#\n"),
        "no question before the EEPROM has rested: {after}"
    );
    let none = Bench::new(Zero::new([None; 3]), b.mill)
        .run(20)
        .unwrap_err();
    assert_eq!(none.to_string(), "say which axis to set to zero: X, Y or Z");
}

/// A lying controller: `$#` answers with another offset than was written.
#[test]
fn zero_that_does_not_read_back_is_an_error() {
    let mut errand = Errand::again(
        Zero::new([Some(0.0), None, None]),
        ErrandOptions::default(),
        Duration::ZERO,
    );
    let mut result = None;
    for ms in 0..20_000u64 {
        let now = Duration::from_millis(ms);
        errand.tick(now);
        let out = String::from_utf8_lossy(&errand.output()).into_owned();
        let mut answer = String::new();
        for _ in out.matches('?') {
            answer += "<Idle|MPos:10.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\r\n";
        }
        for line in out.replace('?', "").lines() {
            if line == "$#" {
                answer += "[G54:99.000,0.000,0.000]\r\n[G92:0.000,0.000,0.000]\r\n[TLO:0.000]\r\n[PRB:0.000,0.000,0.000:0]\r\n";
            }
            if line == "$G" {
                answer += "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]\r\n";
            }
            answer += "ok\r\n";
        }
        errand.receive(answer.as_bytes(), now);
        result = errand.result();
        if result.is_some() {
            break;
        }
    }
    let e = result.unwrap().unwrap_err();
    assert!(
        e.to_string()
            .starts_with("work zero of X reads back as 99 instead of 10: bytes were damaged"),
        "{e}"
    );
}

/// A plate 5 mm below, at 250 steps/mm.
fn plate() -> Controller {
    let mut controller = mill(memory());
    controller.set_switches(Switches {
        limits: [None; 6],
        probe_z: Some(-1250),
    });
    controller
}

#[test]
fn probing_sets_zero_by_the_trigger_point_and_leaves_no_probing_mode() {
    let options = ProbeOptions {
        plate: 1.6,
        ..ProbeOptions::default()
    };
    let mut b = Bench::new(Probe::new(options), plate());
    b.run(120).unwrap();
    let touch = b.errand.task.touch.unwrap();
    assert!((touch.second + 5.0).abs() < 0.01, "{touch:?}");
    assert!((b.errand.task.origin.unwrap() - (touch.second - 1.6)).abs() < 0.002);
    // 10 mm up from the trigger, which is 1.6 mm above zero.
    assert!((b.errand.task.position.unwrap()[2] - 11.6).abs() < 0.01);
    b.mill.feed(b"$G\n");
    let modes = String::from_utf8(b.mill.output()).unwrap();
    assert!(modes.contains("[GC:G0 G54 G17 G21 G90 G94"), "{modes}");
}

#[test]
fn probing_that_misses_or_touches_already_is_explained_and_sets_nothing() {
    let mut b = Bench::new(
        Probe::new(ProbeOptions {
            distance: 3.0,
            ..ProbeOptions::default()
        }),
        plate(),
    );
    let e = b.run(120).unwrap_err().to_string();
    assert!(
        e.starts_with("ALARM:5 during `G21G90G94G38.2Z-3F100`")
            && e.contains("Nothing was touched on the whole way"),
        "{e}"
    );
    assert!(!b.said().contains("G10"));

    let mut controller = plate();
    controller.set_pins(Pins {
        probe: true,
        ..Pins::default()
    });
    let mut b = Bench::new(Probe::new(ProbeOptions::default()), controller);
    let e = b.run(20).unwrap_err().to_string();
    assert!(e.starts_with("the probe is already touching"), "{e}");
    assert!(!b.said().contains("G38"));

    let wrong = ProbeOptions {
        feed: f64::NAN,
        ..ProbeOptions::default()
    };
    let e = Bench::new(Probe::new(wrong), plate()).run(20).unwrap_err();
    assert_eq!(
        e.to_string(),
        "the feed must be above zero and at most 2000, not NaN"
    );
}

#[test]
fn probing_is_stopped_by_hold_standstill_and_reset() {
    let mut b = Bench::new(Probe::new(ProbeOptions::default()), plate());
    while !b.said().contains("G38") {
        b.tick();
    }
    for _ in 0..500 {
        b.tick();
    }
    b.errand.cancel(Duration::from_millis(b.now));
    assert_eq!(
        b.run(20).unwrap_err(),
        ErrandError::Cancelled {
            position_kept: true
        }
    );
    let p = b.mill.position();
    for _ in 0..1000 {
        b.tick();
    }
    assert_eq!(p, b.mill.position());
    assert!(p.z < -0.1 && p.z > -4.9);
}

#[test]
fn the_way_to_zero_goes_up_first_and_down_last() {
    let away = vec![jog([Some(30.0), Some(20.0), Some(-4.0)], 3000.0)];
    let mut b = Bench::new(Jog::new(away), mill(memory()));
    b.run(30).unwrap();
    let mut b = Bench::new(GoTo::zero(Retract::Work(15.0), 3.0), b.mill);
    let mut low_and_sideways = false;
    loop {
        let before = b.mill.position();
        b.tick();
        let after = b.mill.position();
        let sideways = before.x != after.x || before.y != after.y;
        low_and_sideways |= sideways && (after.z - 15.0).abs() > 1e-9;
        if let Some(result) = b.errand.result() {
            result.unwrap();
            break;
        }
        assert!(b.now < 60_000);
    }
    assert!(!low_and_sideways);
    assert_eq!(b.errand.task.position, Some([0.0, 0.0, 3.0]));
    let e = Bench::new(GoTo::zero(Retract::MachineTop, 3.0), b.mill)
        .run(20)
        .unwrap_err();
    assert!(e.to_string().contains("known only when it is homed"), "{e}");
}

#[test]
fn the_way_to_zero_crosses_at_the_top_of_a_homed_machine() {
    let mut m = homing_memory();
    m.set(20, 1.0);
    let mut b = Bench::new(Unlock::default(), mill(m));
    b.run(20).unwrap();
    let down = vec![jog([Some(-30.0), None, Some(-40.0)], 3000.0)];
    let mut b = Bench::new(Jog::new(down), b.mill);
    b.run(30).unwrap();
    let mut b = Bench::new(Rise::new(Retract::TopOr(-100.0)), b.mill);
    b.run(30).unwrap();
    // One pull-off below the switch.
    assert_eq!(b.mill.position().z, -1.0);
    assert!((b.errand.task.by - 39.0).abs() < 0.002);
    let mut b = Bench::new(Rise::new(Retract::MachineTop), b.mill);
    b.run(30).unwrap();
    assert_eq!(b.errand.task.by, 0.0);
    assert!(!b.said().contains("G0Z"), "it is there already");
    let place = GoTo::place(
        Retract::MachineTop,
        [-50.0, -10.0, -20.0],
        Down::Feed(900.0),
    );
    let mut b = Bench::new(place, b.mill);
    b.run(60).unwrap();
    assert!(b.said().contains("G1Z-20F900\n"), "{}", b.said());
    assert_eq!(b.errand.task.position, Some([-50.0, -10.0, -20.0]));
    let e = Bench::new(GoTo::above(Retract::MachineTop, [5.0, 0.0]), b.mill)
        .run(20)
        .unwrap_err();
    assert!(
        e.to_string()
            .starts_with("X would go to 5 mm in machine coordinates"),
        "{e}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, .. ProptestConfig::default() })]
    /// Whatever offsets there are and whichever is active: each that was set moves by the difference, in Z alone, but for the one that is
    /// right already; one that was never set stays.
    #[test]
    fn a_tools_length_moves_every_work_offset(
        z in proptest::collection::vec(proptest::option::of(-60.0f64..60.0), 6), active in 0usize..6, but in proptest::option::of(0usize..6), by in -40.0f64..40.0,
    ) {
        let mut controller = mill(memory());
        for (i, z) in z.iter().enumerate() {
            if let Some(z) = z {
                controller.feed(format!("G10L2P{}X1Z{z:.3}\n", i + 1).as_bytes());
            }
        }
        controller.feed(format!("G{}\n", 54 + active).as_bytes());
        controller.advance(1.0);
        controller.output();
        let by = (by * 1e3).round() / 1e3;
        let mut b = Bench::new(ToolLength::new(by, but), controller);
        b.run(60).unwrap();
        b.mill.feed(b"$#\n");
        b.mill.advance(0.1);
        let told = String::from_utf8(b.mill.output()).unwrap();
        for (i, was) in z.iter().enumerate() {
            let head = format!("[G{}:", 54 + i);
            let line = told.lines().find_map(|l| l.strip_prefix(&head)).unwrap();
            let now: Vec<f64> = line.trim_end_matches(']').split(',').map(|v| v.parse().unwrap()).collect();
            let old = was.map_or(0.0, |z| (z * 1e3).round() / 1e3);
            let moved = by.abs() >= 0.0005 && but != Some(i) && (was.is_some() || i == active);
            let wanted = if moved { old + by } else { old };
            prop_assert!((now[2] - wanted).abs() < 0.002, "G{}: {} {}\n{}", 54 + i, now[2], wanted, told);
            prop_assert_eq!(now[0], if was.is_some() { 1.0 } else { 0.0 });
            prop_assert_eq!(b.errand.task.moved.iter().any(|m| m.0 == i), moved);
        }
    }

    /// A held key: whatever is pressed how often, no more is queued than one step ahead, and a cancel leaves nothing behind.
    #[test]
    fn a_held_jog_key_is_never_more_than_two_steps_ahead(step in 0.1f64..10.0, feed in 200u32..3000, presses in 1usize..30) {
        let one = || jog([Some(step), None, None], f64::from(feed));
        let mut b = Bench::new(Jog::new(vec![one()]), mill(memory()));
        for _ in 0..presses {
            b.errand.task.push(one());
            let lines = b.said().matches("$J").count() as f64;
            let ahead = lines * step - b.mill.position().x;
            prop_assert!(ahead <= 2.0 * step + 0.02, "{} {}", ahead, step);
            for _ in 0..90 {
                b.tick();
            }
        }
        if b.errand.result().is_none() {
            b.errand.cancel(Duration::from_millis(b.now));
            b.run(30).ok();
        }
        let p = b.mill.position();
        for _ in 0..1500 {
            b.tick();
        }
        prop_assert_eq!(p, b.mill.position());
    }
}

#[test]
fn a_second_touch_never_goes_below_the_distance_told() {
    // The plate lies a tenth above the end of the way, and the second touch would look 2 mm below it.
    let mut b = Bench::new(
        Probe::new(ProbeOptions {
            distance: 5.1,
            ..ProbeOptions::default()
        }),
        plate(),
    );
    b.run(120).unwrap();
    let down: Vec<f64> = b
        .said()
        .lines()
        .filter_map(|l| l.split_once("G38.2Z")?.1.split('F').next()?.parse().ok())
        .collect();
    assert_eq!(down, [-5.1, -5.1]);
}

#[test]
fn a_jog_says_what_nobody_checks() {
    let mut b = Bench::new(
        Jog::new(vec![jog([Some(1.0), None, None], 9000.0)]),
        mill(memory()),
    );
    b.run(20).unwrap();
    assert_eq!(
        b.notes(),
        "the machine is not known to be homed: nothing checks whether it can go as far\n9000 mm/min is more than the axes do ($110 to $112): it goes at 3000 mm/min at most"
    );
}

#[test]
fn offsets_and_start_up_lines_are_restored_and_read_back() {
    let mut task = Restore::new(vec![(110, "2500".into())]);
    task.offsets = vec![(0, [1.5, -2.25, -30.0]), (5, [0.0, 0.0, 4.125])];
    task.startup = vec![(1, "g21 g54".into())];
    let mut b = Bench::new(task, mill(memory()));
    b.run(30).unwrap();
    assert_eq!(
        b.errand.task.besides,
        [
            "G21G10L2P1X1.5Y-2.25Z-30",
            "G21G10L2P6X0Y0Z4.125",
            "$N1=G21G54"
        ]
    );
    let mut b = Bench::new(Save::default(), b.mill);
    b.run(20).unwrap();
    let saved = &b.errand.task.saved;
    assert_eq!(saved.offsets[0], ("G54".to_string(), [1.5, -2.25, -30.0]));
    assert_eq!(saved.startup[1].as_deref(), Some("G21G54"));
    let mut task = Restore::new(Vec::new());
    task.startup = vec![(0, "G0X10".into())];
    let mut b = Bench::new(task, b.mill);
    let e = b.run(20).unwrap_err();
    assert!(
        e.to_string().starts_with(
            "start-up line $N0: it moves the machine, and the controller runs it at once"
        ),
        "{e}"
    );
    assert!(!b.said().contains("$N0="));
}

#[test]
fn settings_go_out_and_come_back() {
    let mut b = Bench::new(Save::default(), mill(memory()));
    b.run(20).unwrap();
    let saved = b.errand.task.saved.clone();
    assert!(
        saved.text().contains("$110=3000.000") && saved.text().contains("[VER:"),
        "{}",
        saved.text()
    );

    // Another controller, with other settings: restored from that text.
    let file = morsemill::link::errand::Saved::read(&saved.text()).unwrap();
    let mut b = Bench::new(Restore::new(file.settings.clone()), mill(Memory::default()));
    b.run(60).unwrap();
    let numbers: Vec<u16> = b.errand.task.written.iter().map(|w| w.0).collect();
    assert_eq!(numbers, [110, 111, 112, 120, 121, 122], "only what differs");
    let mut b = Bench::new(Save::default(), b.mill);
    b.run(20).unwrap();
    assert!(differences(&file, &b.errand.task.saved).is_empty());
}

#[test]
fn an_invalid_setting_is_named_and_nothing_is_written() {
    let wanted = vec![(110, "500".to_string()), (2, "300".to_string())];
    let mut b = Bench::new(Restore::new(wanted), mill(memory()));
    let e = b.run(20).unwrap_err().to_string();
    assert!(e.contains("$2") && e.contains("255"), "{e}");
    assert!(!b.said().contains("$110="));
    let e = Bench::new(Restore::new(vec![(20, "1".into())]), b.mill)
        .run(20)
        .unwrap_err();
    assert_eq!(
        e.to_string(),
        "$20=1 (soft limits) needs homing: set $22=1 as well"
    );
}

#[test]
fn a_console_carries_on_after_errors_and_alarms() {
    let mut b = Bench::new(Console::default(), mill(homing_memory()));
    for typed in ["G0X1", "$X", "G1X2", "G0X3"] {
        let Verdict::Send(line) = judge(typed, b.errand.known()) else {
            panic!("{typed}")
        };
        b.errand.task.push(line);
    }
    for _ in 0..6000 {
        b.tick();
    }
    let said: Vec<String> = b
        .news
        .iter()
        .filter_map(|n| match n {
            News::Said(line, _) if !line.starts_with('<') => Some(line.clone()),
            _ => None,
        })
        .collect();
    assert!(
        said.join("|")
            .contains("error:9|[MSG:Caution: Unlocked]|ok|error:22|ok"),
        "{said:?}"
    );
    assert_eq!(b.mill.position().x, 3.0);
    b.errand.task.quit();
    b.run(10).unwrap();
}

#[test]
fn nobody_there_is_told() {
    let mut errand = Errand::new(
        Zero::new([Some(0.0); 3]),
        ErrandOptions::default(),
        Duration::ZERO,
    );
    for ms in 0..20_000 {
        errand.tick(Duration::from_millis(ms));
        errand.output();
    }
    let e = errand.result().unwrap().unwrap_err();
    assert!(
        e.to_string()
            .starts_with("no answer from the controller while waiting for its status"),
        "{e}"
    );
}

proptest! {
    /// Whatever a controller says: no panic, and it ends or waits.
    #[test]
    fn noise_does_no_harm(chunks in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..40), 0..60), words in proptest::collection::vec(
        proptest::sample::select(vec!["ok\n", "error:9\n", "ALARM:1\n", "<Idle|MPos:0,0,0|WCO:0,0,0>\n", "Grbl 1.1h [x]\n", "[PRB:0,0,nan:1]\n", "<Jog|MPos:0,0,0>\n", "$22=1\n"]), 0..60)) {
        let mut errand = Errand::again(Probe::new(ProbeOptions::default()), ErrandOptions::default(), Duration::ZERO);
        let mut now = Duration::ZERO;
        for (i, chunk) in chunks.iter().enumerate() {
            now += Duration::from_millis(137);
            errand.receive(chunk, now);
            if let Some(word) = words.get(i) {
                errand.receive(word.as_bytes(), now);
            }
            errand.tick(now);
            if i == 40 {
                errand.cancel(now);
            }
            prop_assert!(errand.output().len() < 400);
        }
    }
}

/// The whole command over a pseudo-terminal: events, one JSON object a line, from `connected` to `ended`; the journal beside the program.
#[test]
fn send_tells_events_and_keeps_a_journal() {
    use morsemill::cli::send::{self, SendArgs};
    use morsemill::controller::{Pace, Pty};
    use morsemill::machine::Machine;
    let dir = tempfile::tempdir().unwrap();
    let program = dir.path().join("part.nc");
    std::fs::write(&program, "G21G90\nG1X5F600\nX0\nM30\n").unwrap();
    let machine = Machine::load("longmill-30x30").unwrap();
    let pty = Pty::start(Controller::of_machine(&machine), Pace::Unbound).unwrap();
    let events = dir.path().join("events.jsonl");
    let args = SendArgs {
        program: program.clone(),
        machine: "longmill-30x30".to_string(),
        port: pty.path().to_string(),
        dry_run: false,
        speed: Pace::Unbound,
        json: None,
        events: Some(events.clone()),
        plain: true,
        setup: false,
        tool_plate: None,
        tool_setter: None,
        take_up: Default::default(),
    };
    let mut out = Vec::new();
    assert_eq!(
        send::run(&args, &mut out),
        0,
        "{}",
        String::from_utf8_lossy(&out)
    );
    let text = std::fs::read_to_string(&events).unwrap();
    let lines: Vec<serde_json::Value> = text
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let kinds: Vec<&str> = lines.iter().map(|l| l["event"].as_str().unwrap()).collect();
    assert!(
        kinds.contains(&"started") && kinds.contains(&"report"),
        "{kinds:?}"
    );
    assert_eq!(lines.last().unwrap()["event"], "ended");
    assert_eq!(lines.last().unwrap()["result"], "done");
    assert_eq!(lines.last().unwrap()["lines_acknowledged"], 4);
    let times: Vec<f64> = lines.iter().map(|l| l["t_s"].as_f64().unwrap()).collect();
    assert!(times.windows(2).all(|w| w[0] <= w[1]), "{times:?}");
    let journal = std::fs::read_to_string(dir.path().join("part.nc.journal")).unwrap();
    assert!(
        journal.contains(r#""event":"allow""#) && journal.contains(r#""event":"end""#),
        "{journal}"
    );
}
