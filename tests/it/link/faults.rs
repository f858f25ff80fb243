//! What goes wrong on the cable and at its ends, and how the job ends then.

use super::bench::{Bench, SQUARE, at_rest_for_good, line_of, memory, spiral, told};
use super::cable::Cable;
use morsemill::controller::Controller;
use morsemill::link::{Ending, Job, JobReader, Progress, Session, SessionOptions, VetOptions, vet};
use morsemill::wire::Firmware;
use proptest::prelude::*;
use std::sync::{Arc, Mutex};
use std::time::Duration;

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
fn states_nobody_asked_for_end_the_job() {
    let (session, _) = told(
        "<Alarm|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\r\n",
        8,
    );
    let text = session.outcome().unwrap().ending.to_string();
    assert!(
        text.starts_with("the controller says Alarm, which the job did not bring about"),
        "{text}"
    );
}

#[test]
fn a_wall_of_errors_ends_with_the_first() {
    let (session, news) = told(
        "error:22\r\nerror:20\r\nerror:20\r\n<Hold:0|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
        8,
    );
    let ending = session.outcome().unwrap().ending;
    assert!(
        matches!(
            ending,
            Ending::Refused {
                line: 1,
                code: 22,
                ..
            }
        ),
        "{ending:?}"
    );
    let refused = news
        .iter()
        .filter(|n| matches!(n, Progress::Refused { .. }))
        .count();
    // As many as a stop still hears.
    assert!(refused > 1, "{refused}");
}

#[test]
fn damaged_replies_end_the_job_and_news_of_forks_do_not() {
    for (says, damaged) in [
        (
            "[MSG:INFO: hello]\r\n[AXS:3:XYZ]\r\n>G20:ok\r\n<Run|MPos:0,0,0|FS:0,0>\r\n",
            false,
        ),
        ("ALRM:1\r\n<Hold:0|MPos:0,0,0>\r\n", true),
        ("<Idle|MPos:0\r\n<Hold:0|MPos:0,0,0>\r\n", true),
        (
            "ok\r\nok\r\nok\r\nok\r\nok\r\nok\r\nok\r\nok\r\nok\r\n<Hold:0|MPos:0,0,0>\r\n",
            true,
        ),
    ] {
        let (session, news) = told(says, 8);
        let ending = session.outcome().map(|o| o.ending);
        assert_eq!(
            matches!(ending, Some(Ending::Damaged { .. })),
            damaged,
            "{says}: {ending:?} {news:?}"
        );
    }
}

#[test]
fn a_broken_port_names_the_lines_that_may_still_run() {
    let mut bench = Bench::plain(&spiral(400, 0.2));
    bench.ticks(3000);
    bench
        .session
        .broken("the port is gone".into(), Duration::from_millis(3000));
    let outcome = bench.session.outcome().unwrap();
    assert_eq!(outcome.ending, Ending::Broken("the port is gone".into()));
    let (first, last) = outcome.maybe.unwrap();
    assert!(
        first > 10 && last >= first && last - first < 10,
        "{outcome:?}"
    );
    let news = bench.session.news();
    assert!(
        news.contains(&Progress::Unplugged {
            source: Some((first, last))
        }),
        "{news:?}"
    );
    assert!(!outcome.position_kept);
}

#[test]
fn a_program_that_changes_while_it_is_sent_stops_the_job() {
    let text = Arc::new(Mutex::new(spiral(2000, 0.2)));
    let shared = text.clone();
    let source = move || {
        let bytes = shared.lock().unwrap().clone().into_bytes();
        Ok(Box::new(std::io::Cursor::new(bytes)) as Box<dyn JobReader>)
    };
    let job = vet(Arc::new(source), VetOptions::default(), &mut |_, _| {}).unwrap();
    let changed = text.lock().unwrap().replacen("M5", "M3", 1);
    *text.lock().unwrap() = changed;
    let cable = Cable::new(vec![1], vec![1000]);
    let mut bench = Bench::new(job, Controller::new(memory()), cable.clone(), cable);
    let outcome = bench.finish();
    assert!(
        outcome
            .ending
            .to_string()
            .starts_with("the program changed after it was checked"),
        "{outcome:?}"
    );
    assert!(bench.times("M3").is_empty());
    at_rest_for_good(&mut bench, &outcome);
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
