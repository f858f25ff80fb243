//! The session with each firmware that is simulated: introduction, tables, whole jobs, tool change, overrides, door, errors, alarms.

use super::bench::{Bench, SQUARE, at_rest_for_good, introduced, line_of, memory, spiral, told_by};
use morsemill::controller::{Build, Controller, Memory, Profile};
use morsemill::link::{Command, Ending, Progress, Step};
use morsemill::wire::Firmware;

fn controller(profile: Profile, memory: Memory) -> Controller {
    Controller::with_build(memory, Build::of_profile(profile))
}

fn firmware(profile: Profile) -> Firmware {
    match profile {
        Profile::Grbl11h | Profile::Grbl11f => Firmware::Grbl11,
        Profile::GrblHal => Firmware::GrblHal,
        Profile::FluidNc => Firmware::FluidNc,
    }
}

#[test]
fn each_says_who_it_is_and_what_it_holds() {
    for profile in Profile::ALL {
        let known = introduced(controller(profile, memory()));
        assert_eq!(known.firmware, firmware(profile), "{}", profile.name());
        // FluidNC names no numbers: GRBL's are assumed.
        assert_eq!(known.rx_bytes, profile.rx_bytes(), "{}", profile.name());
        assert_eq!(known.blocks.is_some(), profile != Profile::FluidNc);
        assert!(
            known.refused.is_empty(),
            "{}: {:?}",
            profile.name(),
            known.refused
        );
        assert!(known.setting(110).is_some() && known.work_offset.is_some());
    }
}

#[test]
fn whole_jobs_run_on_each() {
    for profile in Profile::ALL {
        for program in [SQUARE.to_string(), spiral(120, 0.3)] {
            for delay in [1, 30] {
                let mut bench = Bench::on(controller(profile, memory()), &program, delay);
                let outcome = bench.finish();
                let name = profile.name();
                assert_eq!(outcome.ending, Ending::Done, "{name}: {:?}", bench.log);
                assert_eq!(outcome.acknowledged, outcome.total, "{name}");
                assert_eq!(bench.controller.bytes_lost(), 0, "{name}");
                assert!(bench.most_in_flight <= profile.rx_bytes(), "{name}");
            }
        }
    }
}

#[test]
fn a_large_receive_buffer_is_used() {
    let program = spiral(400, 0.2);
    let mut bench = Bench::on(controller(Profile::GrblHal, memory()), &program, 20);
    assert_eq!(bench.finish().ending, Ending::Done);
    assert!(bench.most_in_flight > 300, "{}", bench.most_in_flight);
}

#[test]
fn operators_wishes_on_each() {
    for profile in Profile::ALL {
        let name = profile.name();
        let program = "G21 G90 G54 G94 G17\nM3 S1000\nG1 X8 F600\nT2 M6 (next)\nM3 S900\nX9\nM0 (look)\nG0 X0\nM30\n";
        let mut bench = Bench::on(controller(profile, memory()), program, 5);
        bench.until_it(|b| b.controller.position().x > 1.0);
        bench.command(Command::Hold);
        bench.until("on hold, at rest");
        bench.command(Command::Resume);
        bench.until("Resumed");
        bench.command(Command::Feed(Step::Plus10));
        bench.until("Adjusted { what: FeedPlus10, confirmed: true }");
        bench.command(Command::Door);
        bench.until("safety door: close it, then resume");
        bench.command(Command::Resume);
        bench.until("change to tool 2 (next)");
        bench.ticks(500);
        bench.command(Command::Resume);
        bench.until("the program pauses at line 7 (look)");
        bench.command(Command::Resume);
        let outcome = bench.finish();
        assert_eq!(outcome.ending, Ending::Done, "{name}: {:?}", bench.log);
    }
}

#[test]
fn a_refused_line_ends_the_job_on_each_by_its_own_tables() {
    for profile in Profile::ALL {
        let program = spiral(300, 0.2);
        let mut bench = Bench::on(controller(profile, memory()), &program, 15);
        let line = line_of(&program, 100);
        let x = line.find('X').unwrap();
        let damaged = format!("{}XX{}", &line[..x], &line[x + 2..]);
        bench.noise = Some((line.clone().leak(), damaged.leak()));
        let outcome = bench.finish();
        let name = profile.name();
        let Ending::Refused {
            line: 100,
            firmware: by,
            ..
        } = &outcome.ending
        else {
            panic!("{name}: {outcome:?}");
        };
        assert_eq!(*by, firmware(profile));
        let text = outcome.ending.to_string();
        assert!(text.starts_with("line 100 (`G1X"), "{name}: {text}");
        assert!(!text.contains("does not know"), "{name}: {text}");
        assert!(outcome.position_kept, "{name}");
        // grblHAL refuses all that follows with the same error: only the first is the cause.
        let walls = bench
            .news
            .iter()
            .filter(|n| matches!(n, Progress::Refused { .. }))
            .count();
        assert_eq!(walls > 1, profile == Profile::GrblHal, "{name}: {walls}");
        at_rest_for_good(&mut bench, &outcome);
    }
}

#[test]
fn soft_limits_alarm_on_each() {
    for profile in Profile::ALL {
        let mut m = memory();
        m.set(20, 1.0);
        let mut bench = Bench::on(
            controller(profile, m),
            "G21G90\nG1 X-5 F600\nG4 P0\nX5\nX6\n",
            3,
        );
        let outcome = bench.finish();
        let name = profile.name();
        let Ending::Alarm {
            code: 2,
            firmware: by,
            ..
        } = &outcome.ending
        else {
            panic!("{name}: {outcome:?}");
        };
        assert_eq!(*by, firmware(profile), "{name}");
        assert!(outcome.position_kept, "{name}");
        assert!(!outcome.ending.to_string().contains("does not know"));
    }
}

#[test]
fn a_stop_and_a_reset_on_each() {
    for profile in Profile::ALL {
        for at in [2500, 3300] {
            let mut bench = Bench::on(controller(profile, memory()), &spiral(300, 0.2), 10);
            bench.ticks(at);
            bench.command(Command::Stop);
            let outcome = bench.finish();
            assert_eq!(outcome.ending, Ending::Stopped, "{}", profile.name());
            assert!(outcome.position_kept);
            at_rest_for_good(&mut bench, &outcome);
        }
        let mut bench = Bench::on(controller(profile, memory()), &spiral(300, 0.2), 10);
        bench.ticks(2500);
        bench.controller.power_cycle();
        assert_eq!(
            bench.finish().ending,
            Ending::ControllerReset,
            "{}",
            profile.name()
        );
    }
}

/// States and fields of the forks that GRBL does not have.
#[test]
fn states_and_fields_of_forks_are_understood_or_waited_for() {
    let grblhal = || introduced(controller(Profile::GrblHal, memory()));
    for (says, ends) in [
        (
            "<Run:2|MPos:0.000,0.000,0.000,0.000|Bf:100,1023|FS:600,0,0|SP1:0|WCS:G54|DTG:1,2,3|In:0>\r\n",
            None,
        ),
        ("<Tool|MPos:0.000,0.000,0.000|FS:0,0|T:2|TLR:1>\r\n", None),
        ("<Door:4|MPos:0.000,0.000,0.000|FS:0,0>\r\n", None),
        ("<Starting|MPos:0.000,0.000,0.000>\r\n", None),
        ("<Hold:2|MPos:0.000,0.000,0.000|FS:0,0>\r\n", None),
        (
            "<Sleep|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
            Some("the controller says Sleep, which the job did not bring about"),
        ),
        (
            "<Alarm:10|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
            Some("the controller says Alarm, which"),
        ),
        (
            "<Check|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
            Some("the controller says Check, which"),
        ),
        ("ALARM:10\r\n", Some("ALARM:10 while line 1 was waiting: ")),
        (
            "error:39\r\n<Hold:0|MPos:0.000,0.000,0.000>\r\n",
            Some("line 1 (`G1X1F100`): the controller refused it with error:39: "),
        ),
    ] {
        let (session, news) = told_by(grblhal(), says, 12);
        let ending = session.outcome().map(|o| o.ending.to_string());
        match ends {
            None => assert_eq!(ending, None, "{says}: {news:?}"),
            Some(text) => {
                let ending = ending.unwrap_or_default();
                assert!(
                    ending.starts_with(text) && !ending.contains("does not know"),
                    "{says}: {ending}"
                );
            }
        }
    }
}
