//! `send --resume` and `--from-line` through the binary: shown first, refused when it is not to be trusted, told when the disk is full.

use super::process::{Table, told};
use crate::chance::Chance;
use std::process::{Command, Output};

/// Ends in order, whatever the outcome.
fn send(table: &Table, more: &[&str]) -> (Option<i32>, String) {
    let out: Output = table.send(more).wait_with_output().unwrap();
    (out.status.code(), told(&out))
}

#[cfg(unix)]
#[test]
fn a_broken_job_is_shown_before_it_is_sent_and_refused_when_anything_changed() {
    let table = Table::lay(&mut Chance(5));
    // Files of two blocks of 1024 bytes (or 512): as good as a full disk. The shell ignores the signal, and so does what it starts.
    let full = Command::new("sh")
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 6; exec \"$0\" \"$@\"",
            env!("CARGO_BIN_EXE_morsemill"),
        ])
        .args(table.arguments())
        .output()
        .unwrap();
    let said = told(&full);
    assert_eq!(full.status.code(), Some(1), "{said}");
    assert!(
        said.contains("the journal cannot be kept (")
            && said.contains("stopping, as a job without one could not be taken up again"),
        "{said}"
    );
    assert!(
        said.contains("the journal's end could not be written"),
        "{said}"
    );
    table.rest();

    let (code, said) = send(&table, &[]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("take it up with --resume, or begin afresh with --discard-journal"),
        "{said}"
    );
    // It stopped in the middle of a line, and the journal has no word of it.
    let (code, said) = send(&table, &["--resume", "--yes"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("from any place where this job can have stopped"),
        "{said}"
    );
    // Shown and simulated; without a yes nothing is sent.
    let before = std::fs::read(table.journal()).unwrap();
    let (code, said) = send(&table, &["--resume", "--trust-position"]);
    assert_eq!(code, Some(1), "{said}");
    for part in [
        "maybe cut        ",
        "position trusted:  on your word",
        "way in (machine coordinates):",
        "proof:  ",
        "note: simulated: about",
        "nothing was sent: look at the plan above",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert_eq!(std::fs::read(table.journal()).unwrap(), before);
    // Another program.
    let whole = std::fs::read_to_string(table.program()).unwrap();
    std::fs::write(table.program(), whole.replace("F300", "F301")).unwrap();
    let (code, said) = send(&table, &["--resume", "--trust-position", "--yes"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("not the one that was sent (as many lines, but other bytes)"),
        "{said}"
    );
    std::fs::write(table.program(), &whole).unwrap();
    // A bit of it turned.
    let mut spoilt = before.clone();
    spoilt[before.len() / 3] ^= 1;
    std::fs::write(table.journal(), &spoilt).unwrap();
    let (code, said) = send(&table, &["--resume", "--yes"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("damaged") || said.contains("does not even tell which job"),
        "{said}"
    );
    std::fs::write(table.journal(), &before).unwrap();
    // No place for a journal.
    let (code, said) = send(&table, &["--journal", "/nowhere/at/all.journal"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("/nowhere/at/all.journal: the journal cannot be written: ")
            && said.contains("--journal names another place"),
        "{said}"
    );
    // By a line's number, shown too.
    let (code, said) = send(&table, &["--from-line", "90"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("entry:             line 9") && said.contains("say --yes to carry it out"),
        "{said}"
    );
    let (code, said) = send(
        &table,
        &["--resume", "--trust-position", "--yes", "--spin-up", "0"],
    );
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = send(&table, &["--resume", "--yes"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("there is nothing to resume"), "{said}");
}
