//! What is taken up and what is refused, in words.

use super::{ON_PATH, SQUARE, broken_at, here, history_of, operator};
use morsemill::link::journal::{History, Record, Writer, fingerprint, read};
use morsemill::link::resume::{Evidence, Now, Overlap, ResumeOptions, from_line, resume};
use std::time::Duration;

fn refusal(text: &str, history: &History, now: &Now, options: &ResumeOptions) -> String {
    match resume(text, &fingerprint(text.as_bytes()), history, now, options) {
        Ok(plan) => panic!("not refused:\n{plan}"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn a_plan_is_shown_in_words() {
    let history = broken_at(SQUARE, 7, 8);
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &history,
        &here(ON_PATH),
        &ResumeOptions::default(),
    )
    .unwrap();
    // The job began at work X5 Y5 Z40, the highest it ever stood is its Z10; no feed was set by then.
    assert_eq!(
        plan.head.join(" "),
        "G17G21G90G94 M5 M9 G49 G92.1 G54 G53G0Z-20 G0X5Y5 S8000 M3 G4P5 G1Z40F60 G93 G94 G0"
    );
    let words = plan.to_string();
    for part in [
        "surely cut       1 to 2",
        "maybe cut        3 to 8",
        "not sent         9 to 12",
        "the machine stands on the path of these lines",
        "entry:             line 3 `G0 Z10`",
        "lift to          Z-20.000",
        "spindle          M3 8000 rpm, 5 s to come to speed",
        "coolant          off",
    ] {
        assert!(words.contains(part), "{part}:\n{words}");
    }
}

#[test]
fn what_is_not_trustworthy_is_refused_and_says_what_to_do() {
    let shown = ResumeOptions::default();
    let history = broken_at(SQUARE, 9, 10);
    let now = here(ON_PATH);
    assert!(
        resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &history,
            &now,
            &shown
        )
        .is_ok()
    );

    // The program.
    let other = SQUARE.replace("X20", "X21");
    let e = refusal(&other, &history, &now, &shown);
    assert!(
        e.contains("not the one that was sent (as many lines, but other bytes)")
            && e.contains("--discard-journal"),
        "{e}"
    );
    let e = refusal(&format!("{SQUARE}G0\n"), &history, &now, &operator());
    assert!(e.contains("13 lines now, 12 then"), "{e}");

    // The job.
    let done = [
        Record::Sent { line: 12 },
        Record::End {
            how: "done".into(),
            done: true,
            position_kept: true,
            at_rest: true,
            cable_sound: true,
        },
    ];
    assert!(
        refusal(SQUARE, &history_of(SQUARE, &done), &now, &shown).contains("nothing to resume")
    );
    assert!(
        refusal(
            SQUARE,
            &history_of(
                SQUARE,
                &[Record::End {
                    how: "silent".into(),
                    done: false,
                    position_kept: true,
                    at_rest: true,
                    cable_sound: true
                }]
            ),
            &now,
            &shown
        )
        .contains("nothing of the program was sent")
    );
    assert!(refusal(SQUARE, &History::default(), &now, &shown).contains("does not even tell"));

    // The machine.
    let with = |change: &dyn Fn(&mut Now)| {
        let mut n = now.clone();
        change(&mut n);
        n
    };
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| n.machine = "other".into()),
        &operator(),
    );
    assert!(e.contains("of machine `test`, and this is `other`"), "{e}");
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| n.state = "Alarm".into()),
        &operator(),
    );
    assert!(e.contains("state Alarm: home it (`morsemill home`)"), "{e}");
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| n.state = "Hold:0".into()),
        &operator(),
    );
    assert!(e.contains("state Hold:0: end its hold"), "{e}");
    let e = refusal(SQUARE, &history, &with(&|n| n.position = None), &operator());
    assert!(e.contains("does not tell where"), "{e}");
    let e = refusal(
        SQUARE,
        &history,
        &with(&|n| {
            n.settings.iter_mut().for_each(|s| {
                if s.0 == 100 {
                    s.1 = 80.0
                }
            })
        }),
        &operator(),
    );
    assert!(
        e.contains("$100 was 250 when the job began and is 80 now")
            && e.contains("set $100=250 again"),
        "{e}"
    );

    // The position: switched off and on, it believes to stand at zero.
    let e = refusal(SQUARE, &history, &here([0.0; 3]), &shown);
    assert!(
        e.contains("mm from any place where this job can have stopped")
            && e.contains("morsemill home"),
        "{e}"
    );
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &history,
        &here([0.0, 0.0, -3.0]),
        &operator(),
    )
    .unwrap();
    assert_eq!(plan.evidence, Some(Evidence::Operator));
    // Never lower than it stands.
    assert_eq!(plan.way.safe_z, -3.0);

    // Offsets.
    let moved = with(&|n| n.offsets.g5x[0][2] += 1.5);
    let e = refusal(SQUARE, &history, &moved, &shown);
    assert!(e.starts_with("G54 was X-100.000 Y-90.000 Z-60.000 when the job broke and is X-100.000 Y-90.000 Z-58.500 now"), "{e}");
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &history,
        &moved,
        &operator(),
    )
    .unwrap();
    assert!(
        plan.to_string()
            .contains("you answer for it: the zero of G54 was moved by X0.000 Y0.000 Z1.500"),
        "{plan}"
    );
    assert_eq!(plan.way.safe_z, -20.0 + 1.5);

    // Alarms, resets, refused lines, damage.
    let end = Record::End {
        how: "alarm".into(),
        done: false,
        position_kept: true,
        at_rest: true,
        cable_sound: true,
    };
    let after = |record: Record| {
        history_of(
            SQUARE,
            &[
                Record::Sent { line: 10 },
                Record::Acknowledged { line: 9 },
                record,
                end.clone(),
            ],
        )
    };
    for (record, said) in [
        (Record::Alarm { code: 1 }, "ALARM:1 struck"),
        (Record::Alarm { code: 3 }, "ALARM:3 struck"),
        (Record::Alarm { code: 8 }, "ALARM:8 struck"),
        (Record::Reset, "the controller restarted by itself"),
        (
            Record::Error { line: 7, code: 33 },
            "refused line 7 with error:33",
        ),
    ] {
        let history = after(record.clone());
        let e = refusal(SQUARE, &history, &now, &shown);
        assert!(e.starts_with(said) || e.contains(said), "{e}");
        assert!(e.contains("--trust-position"), "{e}");
        let plan = resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &history,
            &now,
            &operator(),
        )
        .unwrap();
        assert!(plan.notes[0].starts_with("you answer for it: "), "{plan}");
        // Homed, on a machine that homes: good again, but for a part cut wrong.
        let mut homed = here([-1.0, -1.0, -1.0]);
        for setting in homed.settings.iter_mut().filter(|s| s.0 == 22) {
            setting.1 = 1.0;
        }
        let again = resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &history,
            &homed,
            &shown,
        );
        match record {
            Record::Error { .. } => assert!(again.is_err()),
            _ => assert_eq!(again.unwrap().evidence, Some(Evidence::Homed)),
        }
        let mut away = homed.clone();
        away.position = Some(ON_PATH);
        if !matches!(record, Record::Error { .. }) {
            assert!(
                refusal(SQUARE, &history, &away, &shown)
                    .contains("Home the machine (`morsemill home`), leave it there")
            );
        }
    }
    // Alarms that stop in order are none.
    assert!(
        resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &after(Record::Alarm { code: 2 }),
            &now,
            &shown
        )
        .is_ok()
    );

    // Heights.
    let low = ResumeOptions {
        safe_z: Some(-51.0),
        ..shown
    };
    assert!(
        refusal(SQUARE, &history, &now, &low)
            .contains("--safe-z -51.000 is below the highest place")
    );
    let high = ResumeOptions {
        safe_z: Some(2.0),
        ..shown
    };
    let soft = with(&|n| {
        n.settings.iter_mut().for_each(|s| {
            if s.0 == 20 {
                s.1 = 1.0
            }
        })
    });
    assert!(refusal(SQUARE, &history, &soft, &high).starts_with(
        "Z 2.000 mm (machine coordinates) lies outside of the travel from -200.000 to 0.000"
    ));
}

#[test]
fn a_start_by_line_number_needs_a_program_that_tells_the_place() {
    let options = ResumeOptions {
        overlap: Overlap::Nothing,
        ..ResumeOptions::default()
    };
    let from = |text: &str, line| from_line(text, line, false, &here(ON_PATH), &options);
    assert_eq!(from(SQUARE, 8).unwrap().entry.line, 8);
    assert_eq!(
        from(SQUARE, 0).unwrap_err().to_string(),
        "there is no line 0 in this program of 12 lines"
    );
    assert!(from(SQUARE, 13).is_err());
    // The lines before never say where Y is.
    let text = "G21 G90\nG0 Z10\nG1 X5 F100\nX10\nX20\n";
    assert!(
        from(text, 4)
            .unwrap_err()
            .to_string()
            .contains("depends on where the machine stood")
    );
    assert!(
        from("G0 X0 Y0 Z0\nG38.2 Z-5 F50\nG0 Z5\nX5\n", 4)
            .unwrap_err()
            .to_string()
            .starts_with("line 2 probes")
    );
    assert!(
        from("G0 X0 Y0 Z5\nM5\nM30\n", 2)
            .unwrap_err()
            .to_string()
            .contains("what is left needs no cutting")
    );
}

#[test]
fn a_laser_comes_on_last() {
    let text =
        "G21 G90 G94\nM4 S500\nG0 X0 Y0 Z0\nG1 X20 F800\nY20\nX0\nG20 G93\nX1 F40\nX0 F40\nM5\n";
    let mut now = here([-85.0, -90.0, -60.0]);
    now.settings
        .iter_mut()
        .filter(|s| s.0 == 32)
        .for_each(|s| s.1 = 1.0);
    let head = |line| {
        from_line(
            text,
            line,
            false,
            &now,
            &ResumeOptions {
                overlap: Overlap::Nothing,
                ..operator()
            },
        )
        .unwrap()
        .head
        .join(" ")
    };
    assert!(
        head(5).ends_with("G53G0Z-60 G0X20Y0 S500 G0Z0 G1F800 F800 M4"),
        "{}",
        head(5)
    );
    assert!(
        head(9).ends_with("S500 G0Z0 G1F800 G20G93 M4"),
        "{}",
        head(9)
    );
    let shown = from_line(text, 5, false, &now, &operator())
        .unwrap()
        .to_string();
    assert!(
        shown.contains("laser            M4 S500, last of all")
            && shown.contains("down to          Z-60.000"),
        "{shown}"
    );
}

#[test]
fn a_place_that_proves_nothing_is_refused() {
    let shown = ResumeOptions::default();
    let stopped = |place: [f64; 3], cable_sound: bool| {
        history_of(
            SQUARE,
            &[
                Record::Sent { line: 10 },
                Record::Acknowledged { line: 9 },
                Record::Report {
                    state: "Hold:0".into(),
                    machine: place,
                    work_offset: None,
                },
                Record::End {
                    how: "stopped".into(),
                    done: false,
                    position_kept: true,
                    at_rest: true,
                    cable_sound,
                },
            ],
        )
    };
    // On the way of the lines, but not where it was seen to stop.
    let e = refusal(
        SQUARE,
        &stopped([-95.0, -90.0, -61.0], true),
        &here(ON_PATH),
        &shown,
    );
    assert!(
        e.contains("5.000 mm from any place where this job can have stopped"),
        "{e}"
    );
    let plan = resume(
        SQUARE,
        &fingerprint(SQUARE.as_bytes()),
        &stopped(ON_PATH, true),
        &here(ON_PATH),
        &shown,
    )
    .unwrap();
    assert_eq!(plan.evidence, Some(Evidence::OnPath));
    // Answers that a bad cable may have made up: the part is the operator's to judge.
    let e = refusal(SQUARE, &stopped(ON_PATH, false), &here(ON_PATH), &shown);
    assert!(e.starts_with("bytes were damaged on the cable, so lines may have been cut as others: inspect the part (stopped). If the part is sound, say --trust-position"), "{e}");
    assert!(
        resume(
            SQUARE,
            &fingerprint(SQUARE.as_bytes()),
            &stopped(ON_PATH, false),
            &here(ON_PATH),
            &operator()
        )
        .is_ok()
    );
    // A controller that was switched on anew says machine zero, and this job happens to go there.
    let mut zero = here([0.0; 3]);
    zero.offsets.g5x = [[0.0; 3]; 6];
    let text = "G21 G90\nG0 Z5\nG0 X0 Y0\nG1 Z0 F200\nX9\nX0\nX5\nM30\n";
    let mut begin = super::begin(text);
    begin.start.offsets = zero.offsets;
    let mut w = Writer::new();
    w.note(Record::Begin(Box::new(begin)), Duration::ZERO);
    w.note(Record::Sent { line: 6 }, Duration::ZERO);
    w.note(Record::Acknowledged { line: 5 }, Duration::ZERO);
    let killed = read(&w.take()[..]).unwrap();
    let e = refusal(text, &killed, &zero, &shown);
    assert!(e.starts_with("the machine says it stands at machine zero. The job can have stopped there, but a controller that was switched off"), "{e}");
    assert!(
        resume(
            text,
            &fingerprint(text.as_bytes()),
            &killed,
            &zero,
            &operator()
        )
        .is_ok()
    );
}
