#![allow(clippy::unwrap_used)]
//! What is written is read, and what is spoilt is told.

use super::super::{Begin, Damage, FORMAT, Offsets, Record, Start, ToolChange, Writer, read};
use super::{Doubt, History};
use proptest::prelude::*;
use std::time::Duration;

fn begin() -> Record {
    Record::Begin(Box::new(Begin {
        format: FORMAT,
        program: "a b \"c\" \u{e4}.nc".into(),
        lines: 1000,
        settings: vec![(0, 10.0), (100, 250.0), (110, 0.1 + 0.2)],
        start: Start {
            offsets: Offsets {
                tlo: -12.345,
                ..Offsets::default()
            },
            ..Start::default()
        },
        ..Begin::default()
    }))
}

fn history(bytes: &[u8]) -> History {
    read(bytes).unwrap()
}

fn some_record() -> impl Strategy<Value = Record> {
    let line = 1usize..1000;
    prop_oneof![
        line.clone().prop_map(|line| Record::Allow { line }),
        line.clone().prop_map(|line| Record::Sent { line }),
        line.clone().prop_map(|line| Record::Acknowledged { line }),
        (
            "\\PC{0,12}",
            proptest::array::uniform3(-1e3..1e3f64),
            any::<bool>()
        )
            .prop_map(|(state, machine, wco)| Record::Report {
                state,
                machine,
                work_offset: wco.then_some([1.5, -2.25, 0.001]),
            }),
        "\\PC{0,12}".prop_map(|why| Record::Hold { why }),
        Just(Record::Resume),
        (10u16..200, 10u16..200).prop_map(|(feed, spindle)| Record::Override {
            feed,
            rapid: 50,
            spindle
        }),
        (line, proptest::option::of(-9.0..9.0f64)).prop_map(|(line, tlo)| {
            Record::ToolChange(ToolChange {
                line,
                tool: Some(2),
                offsets: tlo.map(|tlo| Offsets {
                    tlo,
                    ..Offsets::default()
                }),
            })
        }),
        (0u16..30).prop_map(|code| Record::Alarm { code }),
        "\\PC{0,40}".prop_map(|why| Record::Stopping { why }),
    ]
}

/// A journal of these records, each flushed by itself, and what a reader should make of it after each flush.
fn written(records: &[Record]) -> (Vec<u8>, Vec<(usize, History)>) {
    let mut w = Writer::new();
    let (mut bytes, mut marks) = (Vec::new(), Vec::new());
    w.note(begin(), Duration::ZERO);
    bytes.extend(w.take());
    marks.push((bytes.len(), history(&bytes)));
    for (i, r) in records.iter().enumerate() {
        w.note(r.clone(), Duration::from_secs(i as u64));
        bytes.extend(w.take());
        marks.push((bytes.len(), history(&bytes)));
    }
    (bytes, marks)
}

#[test]
fn a_record_is_a_line_that_people_can_read() {
    let mut w = Writer::new();
    w.note(begin(), Duration::ZERO);
    w.note(Record::Alarm { code: 1 }, Duration::from_millis(1500));
    let text = String::from_utf8(w.take()).unwrap();
    let mut lines = text.lines();
    let first = lines.next().unwrap();
    assert!(
        first.starts_with("0 ")
            && first.contains(r#""event":"begin","format":1,"program":"a b \"c\" ä.nc""#),
        "{first}"
    );
    let second = lines.next().unwrap();
    assert_eq!(second, r#"1 e542e753 {"t":1.5,"event":"alarm","code":1}"#);
    assert_eq!(lines.next(), None);
    assert_eq!(
        history(text.as_bytes()).begin,
        match begin() {
            Record::Begin(b) => Some(*b),
            _ => None,
        }
    );
}

#[test]
fn a_journal_adds_up() {
    let records = [
        Record::Allow { line: 20 },
        Record::Sent { line: 9 },
        Record::Acknowledged { line: 4 },
        Record::Alarm { code: 2 },
        Record::Alarm { code: 1 },
        Record::Error { line: 5, code: 33 },
        Record::Reset,
        Record::Stopping {
            why: "alarm".into(),
        },
        Record::End {
            how: "ALARM:1".into(),
            done: false,
            position_kept: false,
            at_rest: true,
            cable_sound: true,
        },
    ];
    let (bytes, _) = written(&records);
    let h = history(&bytes);
    assert_eq!((h.allowed, h.sent, h.acknowledged), (20, 9, 4));
    assert_eq!(h.damage, Damage::None);
    assert_eq!(h.records, 10);
    assert_eq!(
        h.doubts,
        [
            Doubt::Alarm(1),
            Doubt::Refused { line: 5, code: 33 },
            Doubt::Reset,
            Doubt::NotKept("ALARM:1".into())
        ]
    );
    assert!(!h.done && h.end.is_some());
}

#[test]
fn what_cannot_stand_there_is_not_believed() {
    let damaged = |records: &[Record]| {
        let mut w = Writer::new();
        for r in records {
            w.note(r.clone(), Duration::ZERO);
        }
        history(&w.take()).damage
    };
    let broken = |line| Damage::Broken { line, behind: 0 };
    assert_eq!(damaged(&[Record::Resume]), broken(1));
    assert_eq!(damaged(&[begin(), begin()]), broken(2));
    assert_eq!(damaged(&[begin(), Record::Allow { line: 1001 }]), broken(2));
    let newer = Record::Begin(Box::new(Begin {
        format: FORMAT + 1,
        ..Begin::default()
    }));
    assert_eq!(damaged(&[newer]), broken(1));
    assert_eq!(history(b""), History::default());
    assert_eq!(history(b"not a journal").damage, Damage::Torn { bytes: 13 });
    assert_eq!(history(b"not a journal\n").damage, broken(1));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    /// Cut anywhere, a journal tells what it told at the last whole record, and that it was torn.
    #[test]
    fn a_torn_tail_is_cut(records in proptest::collection::vec(some_record(), 1..12), cut in 0.0..1.0f64) {
        let (bytes, marks) = written(&records);
        let cut = marks[0].0 + ((bytes.len() - marks[0].0) as f64 * cut) as usize;
        let h = history(&bytes[..cut]);
        let (at, _) = marks.iter().rfind(|m| m.0 <= cut).unwrap();
        let damage = if *at == cut { Damage::None } else { Damage::Torn { bytes: (cut - at) as u64 } };
        // A record that lacks nothing but its line end counts.
        let (_, expected) = marks.iter().rfind(|m| m.0 <= cut + 1).unwrap();
        prop_assert_eq!(&h, &History { damage, ..expected.clone() });
        let mut zeros = bytes[..*at].to_vec();
        zeros.extend([0; 100]);
        prop_assert_eq!(history(&zeros).damage, Damage::Zeros { bytes: 100 });
    }

    /// A spoilt byte anywhere: nothing from its record on is believed, and it is told.
    #[test]
    fn damage_in_the_middle_is_told(records in proptest::collection::vec(some_record(), 2..12), at in 0.0..1.0f64, flip in 1u8..=255) {
        let (mut bytes, marks) = written(&records);
        let at = (bytes.len() as f64 * at) as usize;
        bytes[at] ^= flip;
        let h = history(&bytes);
        // The last line end, and nothing else, may be anything.
        let last = at + 1 == marks.last().unwrap().0;
        let sound = marks.iter().rfind(|m| m.0 <= at + usize::from(last));
        let expected = sound.map(|m| m.1.clone()).unwrap_or_default();
        prop_assert!(h.damage != Damage::None);
        prop_assert_eq!(&h, &History { damage: h.damage, ..expected });
        if at + 1 < marks.last().unwrap().0 {
            let broken = matches!(h.damage, Damage::Broken { .. });
            prop_assert!(broken, "{:?}", h.damage);
            prop_assert!(h.all_doubts().contains(&Doubt::Damaged));
        }
    }

    #[test]
    fn a_gap_in_the_numbers_is_damage(records in proptest::collection::vec(some_record(), 3..12), which in 1usize..3) {
        let (bytes, _) = written(&records);
        let text = String::from_utf8(bytes).unwrap();
        let kept: String = text.split_inclusive('\n').enumerate().filter(|(i, _)| *i != which).map(|(_, l)| l).collect();
        let told = match history(kept.as_bytes()).damage {
            Damage::Broken { line, .. } => line,
            _ => 0,
        };
        prop_assert_eq!(told, which as u64 + 1);
    }
}
