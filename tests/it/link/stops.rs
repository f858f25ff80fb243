//! A stop in each state a job can be in: at rest, position kept, nothing runs afterwards.

use super::bench::{Bench, at_rest_for_good, memory, spiral, told};
use morsemill::controller::{Build, Controller, Pins, Profile, Quirks};
use morsemill::link::{Command, Ending};

/// A program, the state to stop it in, and what brings it there.
struct Stop {
    name: &'static str,
    program: String,
    bring: fn(&mut Bench),
    state: &'static str,
}

fn door_machine() -> Controller {
    let quirks = Quirks {
        door_pin: true,
        ..Quirks::default()
    };
    let build = Build {
        quirks,
        ..Build::of_profile(Profile::Grbl11h)
    };
    Controller::with_build(memory(), build)
}

fn stops() -> Vec<Stop> {
    fn reach(bench: &mut Bench, state: &'static str) {
        bench.until_it(|b| b.state() == state);
    }
    vec![
        Stop {
            name: "a dwell",
            program: "G21G90\nG1X3F900\nG4P30\nG1X9\n".into(),
            bring: |b| b.ticks(6000),
            state: "Idle",
        },
        Stop {
            name: "running",
            program: spiral(300, 0.2),
            bring: |b| reach(b, "Run"),
            state: "Run",
        },
        Stop {
            name: "slowing down",
            program: "G21G90\nG0X100\nX0\n".into(),
            bring: |b| {
                reach(b, "Run");
                b.command(Command::Hold);
                b.ticks(2);
            },
            state: "Run",
        },
        Stop {
            name: "a hold",
            program: spiral(300, 0.2),
            bring: |b| {
                b.ticks(3000);
                b.command(Command::Hold);
                reach(b, "Hold:0");
            },
            state: "Hold:0",
        },
        Stop {
            name: "a hold just left",
            program: spiral(300, 0.2),
            bring: |b| {
                b.ticks(3000);
                b.command(Command::Hold);
                reach(b, "Hold:0");
                b.command(Command::Resume);
            },
            state: "Hold:0",
        },
        Stop {
            name: "the spindle coming up to speed behind a hold",
            program: "G21G90\nM3S900\nG1X60F600\n".into(),
            bring: |b| {
                b.ticks(2500);
                b.command(Command::Hold);
                reach(b, "Hold:0");
                b.command(Command::SpindleStop);
                b.ticks(500);
                b.command(Command::Resume);
                b.ticks(1500);
            },
            state: "Hold:0",
        },
        Stop {
            name: "a door",
            program: spiral(300, 0.2),
            bring: |b| {
                b.ticks(3000);
                b.command(Command::Door);
                reach(b, "Door:0");
            },
            state: "Door:0",
        },
        Stop {
            name: "a door that is open",
            program: spiral(300, 0.2),
            bring: |b| {
                b.ticks(3000);
                b.controller.set_pins(Pins {
                    door: true,
                    ..Pins::default()
                });
                reach(b, "Door:1");
            },
            state: "Door:1",
        },
        Stop {
            name: "a door being left",
            program: spiral(300, 0.2),
            bring: |b| {
                b.ticks(3000);
                b.command(Command::Door);
                reach(b, "Door:0");
                b.command(Command::Resume);
                reach(b, "Door:3");
            },
            state: "Door:3",
        },
        Stop {
            name: "the program's own pause",
            program: "G21G90\nG1X3F900\nM0\nG1X9\n".into(),
            bring: |b| b.until("the program pauses at line 3"),
            state: "Hold:0",
        },
        Stop {
            name: "a tool change",
            program: "G21G90\nG1X3F900\nT1M6\nG1X9\n".into(),
            bring: |b| b.until("change to tool 1"),
            state: "Idle",
        },
        Stop {
            name: "the look behind a tool change",
            program: "G21G90\nG1X3F900\nT1M6\nG1X9\n".into(),
            bring: |b| {
                b.until("change to tool 1");
                b.command(Command::Resume);
                b.ticks(20);
            },
            state: "Idle",
        },
        Stop {
            name: "the last motion, all lines answered",
            program: "G21G90\nG1X9F300\n".into(),
            bring: |b| {
                b.until("Acknowledged(Span { lines: 1..2");
                reach(b, "Run");
            },
            state: "Run",
        },
        Stop {
            name: "a probe",
            program: "G21G90\nG38.3Z-9F100\nG0Z1\n".into(),
            bring: |b| reach(b, "Run"),
            state: "Run",
        },
    ]
}

#[test]
fn a_stop_is_clean_in_every_state() {
    for delay in [1, 60] {
        for stop in stops() {
            let mut bench = Bench::on(door_machine(), &stop.program, delay);
            (stop.bring)(&mut bench);
            let name = format!("{}, {delay} ms", stop.name);
            assert_eq!(bench.state(), stop.state, "{name}: {:?}", bench.log);
            bench.command(Command::Stop);
            let outcome = bench.finish();
            assert_eq!(outcome.ending, Ending::Stopped, "{name}: {:?}", bench.log);
            assert!(outcome.position_kept, "{name}: {:?}", bench.log);
            assert!(!bench.heard("Alarm"), "{name}: {:?}", bench.news);
            let resets = bench.times("\u{18}").len();
            assert_eq!(resets, 1, "{name}: {:?}", bench.log);
            at_rest_for_good(&mut bench, &outcome);
        }
    }
}

/// The host's reports are two seconds old: what they say of the time before the stop is not believed.
#[test]
fn over_a_cable_of_a_second_each_way_a_stop_is_as_clean() {
    for (at, before) in [(3500, None), (9000, Some(Command::Hold)), (12_500, None)] {
        let program = format!("G21G90G54G17G94\nG4P4\n{}", spiral(2000, 0.2));
        let mut bench = Bench::on(Controller::new(memory()), &program, 1000);
        bench.until("Started");
        bench.ticks(at);
        if let Some(command) = before {
            bench.command(command);
            bench.until_it(|b| b.state() == "Hold:0");
            bench.command(Command::Resume);
            bench.ticks(30);
        }
        bench.command(Command::Stop);
        let outcome = bench.finish();
        assert_eq!(
            outcome.ending,
            Ending::Stopped,
            "{at} {before:?}: {:?}",
            bench.log
        );
        assert!(outcome.position_kept, "{at} {before:?}: {:?}", bench.log);
        at_rest_for_good(&mut bench, &outcome);
    }
}

/// A board that answers one question in two seconds.
#[test]
fn a_slow_board_runs_a_job_and_stops_as_cleanly() {
    let slow = |bench: &mut Bench, last: &mut u64| {
        bench.tick();
        let now = bench.now;
        for piece in &mut bench.back.pieces {
            if piece.0 == now + 1 && piece.1.starts_with(b"<") && bench.session.next_index() > 0 {
                if now - *last < 2000 {
                    piece.1.clear();
                } else {
                    *last = now;
                }
            }
        }
    };
    for stop in [None, Some(6000)] {
        let mut bench = Bench::on(Controller::new(memory()), &spiral(120, 0.3), 1);
        let mut last = 0;
        while bench.session.outcome().is_none() && bench.now < 200_000 {
            slow(&mut bench, &mut last);
            if Some(bench.now) == stop {
                bench.command(Command::Stop);
            }
        }
        let outcome = bench.session.outcome().unwrap();
        let ending = stop.map_or(Ending::Done, |_| Ending::Stopped);
        assert_eq!(outcome.ending, ending, "{:?}", bench.log);
        assert!(outcome.position_kept, "{:?}", bench.log);
    }
}

#[test]
fn a_second_stop_and_a_resume_behind_a_stop_change_nothing() {
    let mut bench = Bench::plain(&spiral(300, 0.2));
    bench.ticks(3000);
    for command in [
        Command::Stop,
        Command::Stop,
        Command::Resume,
        Command::Hold,
        Command::Resume,
        Command::Feed(morsemill::link::Step::Plus10),
    ] {
        bench.command(command);
    }
    let outcome = bench.finish();
    assert_eq!(outcome.ending, Ending::Stopped);
    assert!(bench.times("~").is_empty() && outcome.position_kept);
    at_rest_for_good(&mut bench, &outcome);
}

/// A machine that never says that it is at rest is reset all the same, and its position is not vouched for.
#[test]
fn a_stop_ends_whatever_the_machine_says() {
    for (says, seconds) in [
        (
            "error:22\r\n<Hold:1|MPos:1.000,0.000,0.000|FS:872,0>\r\n",
            20,
        ),
        ("error:22\r\n<Run|MPos:1.000,0.000,0.000|FS:872,0>\r\n", 20),
        ("error:22\r\n<Dance|MPos:1.000,0.000,0.000>\r\n", 20),
        ("error:22\r\n<Run>\r\n", 140),
    ] {
        let (session, news) = told(says, seconds);
        let outcome = session.outcome().unwrap();
        assert!(matches!(outcome.ending, Ending::Refused { .. }), "{says}");
        assert!(!outcome.position_kept, "{says}: {news:?}");
    }
}
