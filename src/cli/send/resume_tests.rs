#![allow(clippy::unwrap_used)]
//! Journals beside programs, and what becomes of old ones.

use super::*;
use crate::link::journal::{Record, Writer};
use std::time::Duration;

fn journal(end: Option<bool>) -> Vec<u8> {
    let mut w = Writer::new();
    let begin = Begin {
        format: FORMAT,
        lines: 9,
        ..Begin::default()
    };
    w.note(Record::Begin(Box::new(begin)), Duration::ZERO);
    w.note(Record::Allow { line: 7 }, Duration::ZERO);
    w.note(Record::Acknowledged { line: 4 }, Duration::ZERO);
    if let Some(done) = end {
        let how = "ALARM:1".to_string();
        let end = Record::End {
            how,
            done,
            position_kept: true,
            at_rest: true,
            cable_sound: true,
        };
        w.note(end, Duration::ZERO);
    }
    w.take()
}

fn text_of(e: Failure) -> String {
    match e {
        Failure::Rejected(text) | Failure::Failed(text) => text,
    }
}

#[test]
fn a_journal_lies_beside_its_program() {
    let path = journal_path(Path::new("/a/part.nc"), None);
    assert_eq!(path, Path::new("/a/part.nc.journal"));
    let given = journal_path(Path::new("/a/part.nc"), Some(Path::new("j")));
    assert_eq!(given, Path::new("j"));
}

#[test]
fn a_finished_journal_is_set_aside_and_an_unfinished_one_is_not_buried() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("part.nc.journal");
    assert!(matches!(look(&path).unwrap(), Found::Nothing));
    make_room(&path, false).unwrap();
    for n in 0..12 {
        std::fs::write(&path, journal(Some(true))).unwrap();
        assert!(matches!(look(&path).unwrap(), Found::Finished));
        std::fs::OpenOptions::new()
            .append(true)
            .open(&path)
            .and_then(|mut f| io::Write::write_all(&mut f, format!("{n}").as_bytes()))
            .unwrap();
        make_room(&path, false).unwrap();
        // Until the next takes its place, in one step.
        assert!(path.exists());
        std::fs::remove_file(&path).unwrap();
    }
    let kept = std::fs::read_dir(dir.path()).unwrap().count();
    assert_eq!(kept, 9);
    let newest = std::fs::read(dir.path().join("part.nc.journal.1")).unwrap();
    assert!(newest.ends_with(b"11"));

    std::fs::write(&path, journal(None)).unwrap();
    let e = text_of(make_room(&path, false).unwrap_err());
    assert!(
        e.contains("broken after line 4 of 9 was answered (the sender ended without a word)"),
        "{e}"
    );
    assert!(
        e.contains("--resume") && e.contains("--discard-journal"),
        "{e}"
    );
    std::fs::write(&path, journal(Some(false))).unwrap();
    assert!(text_of(make_room(&path, false).unwrap_err()).contains("(ALARM:1)"));
    assert!(path.exists());
    make_room(&path, true).unwrap();
    let set_aside = std::fs::read(dir.path().join("part.nc.journal.1")).unwrap();
    assert_eq!(set_aside, journal(Some(false)));

    // One that was spoilt from its first line on tells nothing, which is not to say that nothing was sent.
    std::fs::write(&path, b"0 00000000 {}\n").unwrap();
    let e = text_of(make_room(&path, false).unwrap_err());
    assert!(e.contains("--discard-journal"), "{e}");
    let mut other = Writer::new();
    let begin = Begin {
        format: FORMAT + 7,
        ..Begin::default()
    };
    other.note(Record::Begin(Box::new(begin)), Duration::ZERO);
    std::fs::write(&path, other.take()).unwrap();
    let e = text_of(make_room(&path, false).unwrap_err());
    assert!(
        e.contains("written in format 8, and this program reads format 1"),
        "{e}"
    );

    // One that is being written is left alone.
    let _writing = JournalFile::create(&path, &journal(None)).unwrap();
    let e = text_of(make_room(&path, true).unwrap_err());
    assert!(e.contains("another morsemill is sending this job"), "{e}");
}

#[test]
fn damage_is_told_in_words() {
    let mut bytes = journal(None);
    bytes.extend_from_slice(b"4 0000");
    let torn = read(&bytes[..]).unwrap();
    assert!(damage(&torn).unwrap().contains("6 bytes left out"));
    bytes.extend_from_slice(b"0000 {}\n");
    let broken = read(&bytes[..]).unwrap();
    assert!(damage(&broken).unwrap().contains("damaged at its line 4"));
    assert_eq!(damage(&History::default()), None);
}

#[test]
fn options_are_read_as_people_mean_them() {
    use clap::Parser;
    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        args: ResumeArgs,
    }
    let read = |text: &str| Line::try_parse_from(text.split(' ')).map(|l| l.args);
    let resumed = read("send --resume").unwrap();
    assert!(resumed.wanted() && resumed.options() == ResumeOptions::default());
    assert_eq!(
        read("send --from-line 9").unwrap().options().overlap,
        Overlap::Nothing
    );
    let own = read("send --resume --overlap 0 --safe-z -3.5 --trust-position")
        .unwrap()
        .options();
    assert_eq!(
        (own.overlap, own.safe_z, own.trust),
        (Overlap::Mm(0.0), Some(-3.5), Trust::Operator)
    );
    assert!(!read("send").unwrap().wanted());
    assert!(read("send --resume --from-line 9").is_err());
    assert!(read("send --resume --discard-journal").is_err());
    assert!(
        read("send --resume --overlap -1").is_err() && read("send --resume --safe-z nan").is_err()
    );
}
