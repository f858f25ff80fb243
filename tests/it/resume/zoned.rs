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
