//! Answers that are none, or too many, or too few: each ends the job or changes nothing, and none is guessed at.

use super::bench::{Bench, SQUARE, at_rest_for_good, spiral, told};
use morsemill::link::Ending;

#[test]
fn a_doubled_answer_never_ends_in_done_at_another_place() {
    for at in [1200, 1700, 2500, 4000] {
        let mut bench = Bench::plain(&spiral(200, 0.3));
        bench.ticks(at);
        bench.back.send(bench.now, b"ok\r\n");
        let outcome = bench.finish();
        assert!(
            matches!(outcome.ending, Ending::Damaged { .. } | Ending::OffPath(_)),
            "{at}: {outcome:?}"
        );
        assert!(outcome.position_kept);
        at_rest_for_good(&mut bench, &outcome);
    }
    let text = Ending::Damaged {
        text: "an answer no line was waiting for".into(),
    }
    .to_string();
    assert!(
        text.contains("so nobody can tell what it received"),
        "{text}"
    );
}

#[test]
fn answers_before_the_greeting_are_nobodys() {
    let mut bench = Bench::plain(SQUARE);
    let said = bench.controller.output();
    bench.back.send(0, b"ok\r\nok\r\nerror:9\r\n");
    bench.back.send(0, &said);
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
}

#[test]
fn reports_for_somebody_else_and_news_of_forks_change_nothing() {
    let mut bench = Bench::plain(SQUARE);
    bench.until("Started");
    for i in 0..60 {
        bench.ticks(37);
        if bench.session.outcome().is_some() {
            break;
        }
        if i % 3 == 0 {
            bench.controller.feed(b"??");
        }
        let said = bench.controller.output();
        bench.back.send(bench.now, &said);
        for line in [
            "[echo: G0X1]\r\n",
            "[MSG:INFO: something]\r\n",
            "\r\n",
            "[JSON:{}]\r\n",
            "$10=1\r\n",
        ] {
            bench.back.send(bench.now, line.as_bytes());
        }
    }
    assert_eq!(bench.finish().ending, Ending::Done, "{:?}", bench.log);
    assert!(bench.heard("controller: INFO: something"));
}

#[test]
fn half_lines_and_garbage_end_the_job_with_what_came() {
    for garbage in [
        &b"o\r\n"[..],
        b"k\r\n",
        b"\xff\x00\xfe\r\n",
        b"err\r\n",
        b"<Run|MP\r\n",
        b"eRror:2\r\n",
    ] {
        let mut bench = Bench::plain(&spiral(200, 0.3));
        bench.ticks(2500);
        bench.back.send(bench.now, garbage);
        let outcome = bench.finish();
        let Ending::Damaged { text } = &outcome.ending else {
            panic!("{garbage:?}: {outcome:?}");
        };
        assert!(!text.is_empty());
        let (first, last) = outcome.maybe.unwrap();
        assert!(first > 1 && last >= first);
        at_rest_for_good(&mut bench, &outcome);
    }
}

#[test]
fn reports_without_fields_do_no_harm() {
    for says in [
        "<Run>\r\n",
        "<Run|FS:0,0>\r\n",
        "<Run|MPos:0.000,0.000|FS:>\r\n",
        "<Run|WPos:|Bf:|Ov:1|WCO:1>\r\n",
        "<Dance|MPos:0.000,0.000,0.000>\r\n",
    ] {
        let (session, news) = told(says, 12);
        assert_eq!(session.outcome(), None, "{says}: {news:?}");
    }
}

/// A greeting in the middle, with the startup lines of a controller that thinks all is well.
#[test]
fn a_greeting_in_the_middle_is_a_reset_whatever_follows() {
    let (session, news) = told(
        "Grbl 1.1h ['$' for help]\r\n>G20G54:ok\r\n<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
        8,
    );
    let outcome = session.outcome().unwrap();
    assert_eq!(outcome.ending, Ending::ControllerReset, "{news:?}");
    assert_eq!(outcome.maybe, Some((1, 6)));
    assert!(!outcome.position_kept);
    let text = outcome.ending.to_string();
    assert!(
        text.contains("power dip, interference or its reset button"),
        "{text}"
    );
}

#[test]
fn a_line_that_grew_or_shrank_on_its_way_is_found_by_its_answers() {
    // A line end lost: two lines become one, one answer is missing, and the fused line is refused.
    let mut bench = Bench::plain("G21G90\nG1X1F900\nX2\nX3\nX4\n");
    bench.noise = Some(("X2\nX3", "X2X3"));
    let outcome = bench.finish();
    assert!(
        matches!(
            outcome.ending,
            Ending::Refused {
                line: 3,
                code: 25,
                ..
            }
        ),
        "{outcome:?}"
    );
    // A line end made up: one answer too many.
    let mut bench = Bench::plain("G21G90\nG1X1F900\nX2\nX3\nX4\n");
    bench.noise = Some(("X2\nX3", "X2\n\nX3"));
    let outcome = bench.finish();
    assert!(
        matches!(outcome.ending, Ending::Damaged { .. }),
        "{outcome:?}"
    );
}
