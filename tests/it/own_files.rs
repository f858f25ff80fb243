//! The user's own machines and dialects, found through the environment: the program itself is run.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program with only the environment given.
fn run(arguments: &[&str], environment: &[(&str, &Path)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_morsemill"));
    command.args(arguments).env_clear();
    for (name, value) in environment {
        command.env(name, value);
    }
    command.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn directories_come_before_what_is_built_in_and_it_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let listed = dir.path().join("listed");
    let configured = dir.path().join("config/morsemill/machines");
    std::fs::create_dir_all(&listed).unwrap();
    std::fs::create_dir_all(&configured).unwrap();
    let mine = include_str!("../../machines/grbl-3018.toml");
    std::fs::write(
        listed.join("grbl-3018.toml"),
        mine.replace("title = \"", "title = \"listed "),
    )
    .unwrap();
    std::fs::write(
        configured.join("grbl-3018.toml"),
        mine.replace("title = \"", "title = \"configured "),
    )
    .unwrap();
    std::fs::write(
        configured.join("bench.toml"),
        mine.replace("title = \"", "title = \"bench "),
    )
    .unwrap();
    let config = dir.path().join("config");
    let both: [(&str, &Path); 2] = [
        ("MORSEMILL_MACHINES", &listed),
        ("XDG_CONFIG_HOME", &config),
    ];

    let out = run(&["machines", "show", "grbl-3018"], &both);
    assert!(out.status.success());
    let shown = text(&out.stdout);
    assert!(
        shown.contains("title                 listed 3018-class"),
        "{shown}"
    );
    assert!(
        shown.contains("(stands before the built-in one of that name)"),
        "{shown}"
    );
    let shown = text(&run(&["machines", "show", "grbl-3018"], &both[1..]).stdout);
    assert!(
        shown.contains("title                 configured 3018-class"),
        "{shown}"
    );
    let shown = text(&run(&["machines", "show", "grbl-3018"], &[]).stdout);
    assert!(
        shown.contains("title                 3018-class") && shown.contains("built in"),
        "{shown}"
    );
    let out = run(&["machines", "show", "bensh"], &both);
    assert_eq!(out.status.code(), Some(2));
    assert!(
        text(&out.stderr).contains("(did you mean \"bench\"?)"),
        "{}",
        text(&out.stderr)
    );

    // A command that uses the machine says on standard error which one it took.
    let program = dir.path().join("p.nc");
    std::fs::write(&program, "G21 G90\nG0 X1 Y1 Z5\nM30\n").unwrap();
    let program = program.to_str().unwrap();
    let out = run(&["check", program, "--machine", "grbl-3018"], &both);
    let said = text(&out.stderr);
    let expected = format!(
        "machine grbl-3018: {}, which stands before the built-in one of that name",
        listed.join("grbl-3018.toml").display()
    );
    assert!(said.contains(&expected), "{said}");
    let said = text(&run(&["check", program, "--machine", "grbl-3018"], &[]).stderr);
    assert!(!said.contains("machine grbl-3018:"), "{said}");
}

#[test]
fn a_named_directory_that_is_not_there_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let missing = dir.path().join("missing");
    let out = run(&["machines"], &[("MORSEMILL_MACHINES", &missing)]);
    assert!(out.status.success());
    let said = text(&out.stderr);
    assert!(
        said.contains("warning: MORSEMILL_MACHINES names")
            && said.contains("which is no directory"),
        "{said}"
    );
}

#[test]
fn check_ends_with_the_contract_exit_codes() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("mine.toml");
    let name = file.to_str().unwrap();
    assert_eq!(
        run(&["machines", "check", name], &[]).status.code(),
        Some(2),
        "no such file"
    );
    let out = run(&["machines", "new", "--from", "grbl-3018", name], &[]);
    assert_eq!(out.status.code(), Some(0));
    let out = run(&["machines", "check", name], &[]);
    assert_eq!(
        (out.status.code(), text(&out.stdout)),
        (
            Some(0),
            format!("{name}: good: 3018-class router (Genmitsu 3018-PROVer)\n")
        )
    );
    assert_eq!(
        run(&["machines", "new", "--from", "grbl-3018", name], &[])
            .status
            .code(),
        Some(2),
        "exists"
    );
    let broken = std::fs::read_to_string(&file)
        .unwrap()
        .replace("baud", "bawd");
    std::fs::write(&file, broken).unwrap();
    let out = run(&["machines", "check", name], &[]);
    assert_eq!(out.status.code(), Some(1));
    assert!(
        text(&out.stderr).contains("mine.toml:17:1: unknown key \"bawd\" (did you mean \"baud\"?)"),
        "{}",
        text(&out.stderr)
    );
}
