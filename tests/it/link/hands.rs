//! Hands on the machine: its own buttons, its door, its power; and an operator who presses everything twice.

use super::bench::{Bench, SQUARE, at_rest_for_good, memory, spiral};
use morsemill::controller::{Build, Controller, Pins, Profile, Quirks};
use morsemill::link::{Command, Ending, RapidStep, Step};

fn with_door() -> Controller {
    let quirks = Quirks {
        door_pin: true,
        ..Quirks::default()
    };
    Controller::with_build(
        memory(),
        Build {
            quirks,
            ..Build::of_profile(Profile::Grbl11h)
        },
    )
}

fn press(bench: &mut Bench, pins: Pins) {
    bench.controller.set_pins(pins);
    bench.ticks(100);
    bench.controller.set_pins(Pins::default());
}

#[test]
fn the_machines_own_hold_and_start_buttons_are_followed() {
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1500);
    let hold = Pins {
        hold: true,
        ..Pins::default()
    };
    press(&mut bench, hold);
    bench.until("the machine is on hold, but not by us (a button, or noise): resume or stop");
    bench.ticks(3000);
    press(
        &mut bench,
        Pins {
            cycle_start: true,
            ..Pins::default()
        },
    );
    bench.until("Resumed");
    // Held by the button, resumed from here.
    press(&mut bench, hold);
    bench.until_it(|b| b.state() == "Hold:0");
    bench.command(Command::Resume);
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
}

#[test]
fn a_door_opened_by_hand_waits_until_it_is_closed() {
    let mut bench = Bench::on(with_door(), SQUARE, 2);
    bench.ticks(1500);
    bench.controller.set_pins(Pins {
        door: true,
        ..Pins::default()
    });
    bench.until("safety door: close it, then resume");
    bench.command(Command::Resume);
    bench.until("the safety door is open: close it, then resume");
    bench.ticks(500);
    assert!(bench.times("~").is_empty());
    bench.controller.set_pins(Pins::default());
    bench.ticks(3000);
    assert_eq!(bench.state(), "Door:0");
    bench.command(Command::Resume);
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
}

#[test]
fn the_reset_button_ends_the_job_and_says_what_it_cost() {
    let mut bench = Bench::plain(&spiral(300, 0.2));
    bench.ticks(3000);
    press(
        &mut bench,
        Pins {
            reset: true,
            ..Pins::default()
        },
    );
    let outcome = bench.finish();
    assert!(
        matches!(
            outcome.ending,
            Ending::ControllerReset | Ending::Alarm { code: 3, .. }
        ),
        "{outcome:?}"
    );
    assert!(!outcome.position_kept && outcome.maybe.is_some());
    at_rest_for_good(&mut bench, &outcome);
}

/// The controller's power goes, its USB stays; some seconds later it comes back.
#[test]
fn power_lost_behind_a_living_usb_is_told() {
    for back_after in [1500, 20_000] {
        let mut bench = Bench::plain(&spiral(300, 0.2));
        bench.ticks(3000);
        bench.controller.power_cycle();
        let greeting = bench.controller.output();
        let off = bench.now;
        while bench.now < off + back_after && bench.session.outcome().is_none() {
            bench.tick();
            // Nothing comes from a board without power, and it hears nothing.
            bench.back.pieces.clear();
        }
        bench.back.send(bench.now, &greeting);
        let outcome = bench.finish();
        let expected = if back_after < 4000 {
            Ending::ControllerReset
        } else {
            Ending::Silent {
                waiting_for: "a status report",
            }
        };
        assert_eq!(outcome.ending, expected, "{:?}", bench.log);
        assert!(!outcome.position_kept && outcome.maybe.is_some());
    }
}

#[test]
fn a_hard_limit_is_an_alarm_with_its_line_and_the_controller_is_reset() {
    let mut m = memory();
    m.set(21, 1.0);
    let mut bench = Bench::on(Controller::new(m), &spiral(300, 0.2), 2);
    bench.ticks(3000);
    bench.controller.set_pins(Pins {
        limit: [true, false, false],
        ..Pins::default()
    });
    bench.ticks(50);
    bench.controller.set_pins(Pins::default());
    let outcome = bench.finish();
    let text = outcome.ending.to_string();
    assert!(text.starts_with("ALARM:1 while line "), "{text}");
    assert!(text.contains("home"), "{text}");
    assert!(!outcome.position_kept);
    // Unlocking is the operator's; the session leaves it locked.
    assert!(bench.times("$X").is_empty() && bench.times("\u{18}").len() == 1);
    bench.controller.feed(b"$X\nG1X0F100\n");
    assert!(String::from_utf8_lossy(&bench.controller.output()).contains("Unlocked"));
}

#[test]
fn holds_and_resumes_in_bursts_lose_nothing() {
    for gap in [1, 3, 40, 130, 260] {
        let mut bench = Bench::plain(SQUARE);
        bench.until("Started");
        bench.ticks(300);
        for _ in 0..15 {
            bench.command(Command::Hold);
            bench.ticks(gap);
            bench.command(Command::Resume);
            bench.ticks(gap / 2 + 1);
        }
        // Whatever the last press made of it: resuming until it is not held any more.
        for _ in 0..40 {
            bench.ticks(1000);
            if bench.session.outcome().is_some() {
                break;
            }
            bench.command(Command::Resume);
        }
        let outcome = bench.finish();
        assert_eq!(outcome.ending, Ending::Done, "{gap}: {:?}", bench.log);
        assert_eq!(outcome.position, Some([1.0, 2.0, 5.0]));
    }
}

#[test]
fn a_burst_of_raw_bytes_from_elsewhere_ends_held_or_done_and_never_lost() {
    let mut bench = Bench::plain(SQUARE);
    bench.until("Started");
    bench.ticks(400);
    bench.controller.feed(b"!~!~!~!~!!~~!");
    bench.ticks(700);
    bench.controller.feed(b"~!~~");
    for _ in 0..40 {
        bench.ticks(1000);
        bench.command(Command::Resume);
    }
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
}

#[test]
fn overrides_in_a_hurry_all_count_and_too_many_are_told() {
    let mut bench = Bench::plain("G21 G90\nG1 X100 F600\n");
    bench.ticks(1500);
    for _ in 0..4 {
        bench.command(Command::Feed(Step::Minus10));
        bench.command(Command::Feed(Step::Plus1));
        bench.command(Command::Rapid(RapidStep::Half));
        bench.command(Command::Spindle(Step::Plus10));
    }
    bench.ticks(3000);
    let overrides = bench.news.iter().rev().find_map(|n| match n {
        morsemill::link::Progress::Report(r) => r.overrides,
        _ => None,
    });
    let o = overrides.unwrap();
    assert_eq!((o.feed, o.rapid, o.spindle), (64, 50, 140));
    for _ in 0..200 {
        bench.command(Command::Feed(Step::Plus1));
    }
    bench.ticks(100);
    assert!(bench.heard("too many override steps at once"));
    bench.command(Command::Stop);
    assert_eq!(bench.finish().ending, Ending::Stopped);
}
