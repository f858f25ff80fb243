//! The three zones after a crash of the host, and of a job that was taken up itself.

use super::{HELD, ON_PATH, SQUARE, begin, broken_at, here, history_of, operator, taken};
use morsemill::link::journal::{Begin, Record, Writer, fingerprint, read};
use morsemill::link::resume::{ResumeOptions, resume, zones};
use std::time::Duration;

#[test]
fn a_crash_of_the_host_widens_the_zone_by_what_the_disk_may_have_missed() {
    let mut text = String::from("G21 G90\nG0 X0 Y0 Z1\nG1 Z0 F500\n");
    for i in 1..20000 {
        text.push_str(&format!("X{}\n", i % 50));
    }
    let crashed = history_of(
        &text,
        &[
            Record::Allow { line: 130 },
            Record::Sent { line: 110 },
            Record::Acknowledged { line: 100 },
        ],
    );
    let same = zones(&text, taken(&crashed), &crashed, Some("boot")).unwrap();
    assert_eq!((same.first, same.last), (101 - HELD, 130));
    let rebooted = zones(&text, taken(&crashed), &crashed, Some("another boot")).unwrap();
    assert_eq!(rebooted.first, 101 - HELD);
    // Two seconds at 11,520 bytes a second and two buffers, in lines of 4 bytes or less.
    let bytes: usize = text
        .lines()
        .take(rebooted.last)
        .skip(130)
        .map(|l| l.len() + 1)
        .sum();
    assert!((23_040 + 256..23_040 + 256 + 5).contains(&bytes), "{bytes}");
    assert_eq!(
        zones(&text, taken(&crashed), &crashed, None).unwrap(),
        rebooted
    );
    // Ended in order: what was sent.
    let ended = broken_at(&text, 100, 110);
    assert_eq!(zones(&text, taken(&ended), &ended, None).unwrap().last, 110);
}

#[test]
fn a_job_can_break_again_while_it_is_resumed() {
    let text = SQUARE;
    let sha = fingerprint(text.as_bytes());
    let plan = resume(
        text,
        &sha,
        &broken_at(text, 9, 10),
        &here(ON_PATH),
        &ResumeOptions::default(),
    )
    .unwrap();
    let again = Begin {
        start: plan.start.clone(),
        resumed: Some(plan.resumed()),
        ..begin(text)
    };
    let mut w = Writer::new();
    w.note(Record::Begin(Box::new(again)), Duration::ZERO);
    // Killed on the way in: nothing of the program was sent yet, and all that was in doubt is in doubt still.
    let killed = read(&w.take()[..]).unwrap();
    let z = zones(text, taken(&killed), &killed, Some("boot")).unwrap();
    assert_eq!((z.first, z.last), (plan.entry.line, 10));
    let second = resume(text, &sha, &killed, &here(ON_PATH), &operator()).unwrap();
    assert!(second.entry.line <= plan.entry.line);
}

#[test]
fn an_answer_too_many_is_seen_by_the_place() {
    let mut text = String::from("G21 G90\nG0 X0 Y0 Z1\nG1 Z0 F500\n");
    for i in 1..200 {
        text.push_str(&format!("X{i}\n"));
    }
    // Line n leads to X(n - 3); the middle zone begins 21 lines before the last answer.
    let seen = |x: f64, behind: Option<usize>, cable_sound: bool| {
        let mut records = vec![
            Record::Sent { line: 110 },
            Record::Acknowledged { line: 100 },
            Record::Report {
                state: "Run".into(),
                machine: [-100.0 + x, -90.0, -60.0],
                work_offset: None,
            },
        ];
        records.extend(behind.map(|line| Record::Acknowledged { line }));
        records.push(Record::End {
            how: "stopped".into(),
            done: false,
            position_kept: true,
            at_rest: true,
            cable_sound,
        });
        let h = history_of(&text, &records);
        zones(&text, taken(&h), &h, None).unwrap()
    };
    let counted = 101 - HELD;
    assert_eq!(seen(90.5, None, true).first, counted);
    assert_eq!(seen(counted as f64 - 3.5, None, true).first, counted);
    assert_eq!(seen(counted as f64 - 4.5, None, true).first, counted - 1);
    assert_eq!(seen(50.5, None, true).first, 54);
    // Seen before more was answered, it may have gone on since.
    assert_eq!(
        seen(counted as f64 - 3.5, Some(105), true).first,
        counted + 5
    );
    assert_eq!(
        seen(counted as f64 - 4.5, Some(105), true).first,
        counted - 1
    );
    // Beside the way it says nothing of lines.
    assert_eq!(seen(-20.0, None, true).first, counted);
    assert_eq!(seen(90.5, None, false).first, counted);
}

#[test]
fn half_a_line_of_a_killed_sender_does_not_run() {
    for half in ["G0X-9", "G1X-1F500", "$H", "$X", "$1", "", "G0(no"] {
        let mut c = super::controller();
        c.feed(half.as_bytes());
        let before = c.position();
        let known = crate::campaign::bench::introduce(&c);
        assert_eq!(
            known.machine_position.map(Into::into),
            Some(before),
            "{half}"
        );
    }
}
