#![allow(clippy::unwrap_used)]
use super::*;
use crate::gcode::interpret;
use proptest::prelude::*;
use std::io::{BufReader, Cursor, Read, SeekFrom};

fn reading(lines_again: u64) -> Reading {
    Reading {
        lines_again,
        comments: false,
    }
}

fn over(text: &str, dialect: Dialect, lines_again: u64) -> Interpreter<Cursor<&[u8]>> {
    let from = Cursor::new(text.as_bytes());
    Interpreter::from_state(from, State::new(dialect), reading(lines_again)).unwrap()
}

/// Events and complaints in order, as texts.
fn told(text: &str, dialect: Dialect) -> Vec<String> {
    over(text, dialect, 1000)
        .map(|e| match e {
            Ok(e) => format!("{e:?}"),
            Err(e) => e.to_string(),
        })
        .collect()
}

#[test]
fn events_and_mistakes_come_in_the_order_of_the_lines() {
    let text = "G0 X1\nG5\nX2\nM3 S100 M8 G4 P1\n";
    let all = told(text, Dialect::Grbl);
    assert_eq!(all.len(), 6);
    assert!(all[1].starts_with("2:1 G5 is not"));
    let mut program = over(text, Dialect::Grbl, 0);
    assert!(matches!(program.next(), Some(Ok(Event::Motion(_)))));
    assert_eq!((program.lines(), program.state().position.x), (1, 1.0));
    assert!(program.next().unwrap().is_err());
    assert_eq!(program.errors().len(), 1);
    assert_eq!(program.by_ref().count(), 4);
    assert_eq!(program.lines(), 4);
    assert!(program.next().is_none());
}

#[test]
fn the_lines_behind_the_end_are_counted_but_not_read() {
    let text = "M98 P1\nM30\nO1\nM99\nrubbish\n\n";
    let mut program = over(text, Dialect::Fanuc, 10);
    assert_eq!(program.read_all(&mut vec![]), []);
    assert_eq!(program.lines(), 4);
    assert_eq!(program.count_lines().unwrap(), 6);
    assert_eq!(interpret(text, Dialect::Fanuc).unwrap().lines, 6);
}

#[test]
fn comments_are_kept_when_asked_for() {
    let text = "(a) G0 X1 (b ; c) ; d (e)\n\n; \u{e4}\nX2 (open";
    let wanted = Reading {
        comments: true,
        ..reading(0)
    };
    let from = Cursor::new(text.as_bytes());
    let mut program = Interpreter::from_state(from, State::new(Dialect::Grbl), wanted).unwrap();
    program.next();
    let texts = |c: Vec<Comment>| c.into_iter().map(|c| (c.line, c.text)).collect::<Vec<_>>();
    let own = |line: usize, text: &str| (line, text.to_string());
    assert_eq!(
        texts(program.take_comments()),
        [own(1, "a"), own(1, "b ; c"), own(1, "d (e)")]
    );
    program.next();
    assert_eq!(
        texts(program.take_comments()),
        [own(3, "\u{e4}"), own(4, "open")]
    );
    let mut silent = over(text, Dialect::Grbl, 0);
    silent.next();
    assert_eq!(silent.take_comments(), []);
}

#[test]
fn an_endless_program_is_seen_as_such_or_stopped_by_the_limit() {
    for (text, dialect) in [
        ("N1 G0 X1.\nX2.\nGOTO 1", Dialect::Fanuc),
        ("G0 X1. F100.\nM99", Dialect::Haas),
        ("G0 X1\nM99", Dialect::LinuxCnc),
        ("DO1\nDO2\nEND2\nEND1", Dialect::Fanuc),
        (
            "o1 sub\no1 endsub\no2 while [1]\no1 call\no2 endwhile",
            Dialect::LinuxCnc,
        ),
        ("#1=1\nN5 #1=1-#1\nGOTO 5", Dialect::Mach4),
    ] {
        let mut program = over(text, dialect, u64::MAX);
        let errors = program.read_all(&mut vec![]);
        let endless = Complaint::Flow(FlowComplaint::Endless);
        assert_eq!(errors.len(), 1, "{text}: {errors:?}");
        assert_eq!(errors[0].complaint, endless);
    }
    let counting = "#1=0\nN5 #1=#1+1\nGOTO 5";
    let errors = over(counting, Dialect::Fanuc, 100).read_all(&mut vec![]);
    let lines = 100;
    assert_eq!(
        errors[0].complaint,
        Complaint::Flow(FlowComplaint::TooLong { lines })
    );
    // A long straight program is not one that goes on and on.
    let long = "G0 X1.\n".repeat(1000);
    assert_eq!(over(&long, Dialect::Fanuc, 0).read_all(&mut vec![]), []);
}

#[test]
fn a_long_loop_that_ends_is_carried_out() {
    let text = "#1=0\nWHILE [#1 LT 5000] DO1\n#1=#1+1\nEND1\nG0 X#1\nM30";
    let program = interpret(text, Dialect::Fanuc).unwrap();
    assert_eq!(program.end_state.position.x, 5000.0);
    let text = "G91\nM98 P9 L5000\nM30\nO9\nG0 X1.\nM99";
    assert_eq!(interpret(text, Dialect::Haas).unwrap().events.len(), 5001);
}

#[test]
fn a_refused_call_changes_nothing() {
    for text in ["G0 X5. M98 P7", "G0 X5. M99 P7", "G0 X5. M98 P1 L0"] {
        let mut program = over(text, Dialect::Fanuc, 10);
        assert_eq!(program.read_all(&mut vec![]).len(), 1, "{text}");
        assert_eq!(program.state(), &State::new(Dialect::Fanuc), "{text}");
    }
    let mut program = over("#1=5 #5220=1 G0 X5\nX#1", Dialect::LinuxCnc, 10);
    assert_eq!(program.read_all(&mut vec![]).len(), 1);
    assert_eq!(program.state().position.x, 0.0);
}

#[test]
fn the_words_beside_a_call_come_before_it() {
    let text = "G0 X5. M98 P1\nX7.\nM30\nO1\nY1. M99";
    let all = interpret(text, Dialect::Fanuc).unwrap().events;
    let ends = all.iter().filter_map(|e| match e {
        Event::Motion(m) => Some((m.to.x, m.to.y)),
        _ => None,
    });
    assert_eq!(
        ends.collect::<Vec<_>>(),
        [(5.0, 0.0), (5.0, 1.0), (7.0, 1.0)]
    );
}

#[test]
fn skipped_lines_are_skipped_with_their_calls() {
    let text = "/M98 P7\n/2 GOTO 5\n/ #1=#2\nG0 X1.";
    let mut state = State::new(Dialect::Fanuc);
    state.block_delete = true;
    let from = Cursor::new(text.as_bytes());
    let mut program = Interpreter::from_state(from, state, reading(10)).unwrap();
    assert_eq!(program.read_all(&mut vec![]), []);
    assert_eq!(
        over(text, Dialect::Fanuc, 10).read_all(&mut vec![]).len(),
        3
    );
}

#[test]
fn a_line_without_end_is_refused_and_the_next_one_read() {
    for dialect in [
        Dialect::Grbl,
        Dialect::LinuxCnc,
        Dialect::Fanuc,
        Dialect::Marlin,
    ] {
        let mut text = "G0 X1. ".repeat(2_000_000);
        text.push_str("\nG0 X2.\n");
        assert!(text.len() > 10_000_000);
        let from = BufReader::new(Cursor::new(text.as_bytes()));
        let mut program = Interpreter::from_state(from, State::new(dialect), reading(0)).unwrap();
        let errors = program.read_all(&mut vec![]);
        let limit = LONGEST;
        let refused = Complaint::Flow(FlowComplaint::LineLonger { limit });
        assert_eq!(
            errors.iter().map(|e| &e.complaint).collect::<Vec<_>>(),
            [&refused]
        );
        assert_eq!((program.lines(), program.state().position.x), (2, 2.0));
    }
}

/// A file that breaks off with an error.
struct Broken(Cursor<Vec<u8>>);

impl Read for Broken {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.0.read(into)? {
            0 => Err(io::Error::other("unplugged")),
            n => Ok(n),
        }
    }
}

impl Seek for Broken {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

#[test]
fn a_file_that_cannot_be_read_on_is_an_error_not_an_end() {
    let from = BufReader::new(Broken(Cursor::new(b"G0 X1\nX2\n".to_vec())));
    let mut program = Interpreter::new(from, Dialect::Grbl).unwrap();
    let errors = program.read_all(&mut vec![]);
    assert_eq!(
        errors[0].to_string(),
        "3:1 the program cannot be read from here on (other error): check the file and its disk"
    );
    assert_eq!(errors.len(), 1);
}

/// Lines of programs, broken and whole, with all that says something of order.
fn line() -> impl Strategy<Value = String> {
    let fixed = [
        "%",
        "O1",
        "O2",
        "M99",
        "M30",
        "M98 P1",
        "M98 P2 L3",
        "M97 P1",
        "G65 P1 A1.",
        "GOTO 1",
        "GOTO #1",
        "N1",
        "N2 X2",
        "IF [#1 LT 3] GOTO 1",
        "IF [#1 GE 3] THEN #1=0",
        "WHILE [#1 LT 5] DO1",
        "END1",
        "DO2",
        "END2",
        "#1=#1+1",
        "#1=0",
        "#1=[#1+1]",
        "#2=[#1*2]",
        "G91 G0 X#1",
        "X[#1+#2]",
        "o1 sub",
        "o1 endsub",
        "o1 call",
        "o2 call [#1]",
        "o2 sub",
        "o2 endsub [#1]",
        "o3 while [#1 lt 4]",
        "o3 endwhile",
        "o3 break",
        "o3 continue",
        "o4 do",
        "o4 while [#1 lt 3]",
        "o5 if [#1 eq 2]",
        "o5 else",
        "o5 elseif [#1]",
        "o5 endif",
        "o6 repeat [3]",
        "o6 endrepeat",
        "o1 return",
        "/M99",
        "#<a>=[#1]",
        "X#<a>",
        "G1 X1 F100",
        "Y-1",
        "",
    ];
    (0..fixed.len()).prop_map(move |i| fixed[i].to_string())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    /// Whatever the lines: reading ends, within the limit, with at most so many mistakes, the same in memory and line by line.
    #[test]
    fn every_program_comes_to_an_end(lines in proptest::collection::vec(line(), 1..30), which in 0usize..6) {
        let dialect = [
            Dialect::LinuxCnc, Dialect::Fanuc, Dialect::Haas, Dialect::Mach3, Dialect::Planet, Dialect::Grbl,
        ][which];
        let text = lines.join("\n");
        let mut program = over(&text, dialect, 2000);
        let mut events = vec![];
        let errors = program.read_all(&mut events);
        prop_assert!(errors.len() <= MAX_ERRORS);
        prop_assert!(program.again <= 2001);
        prop_assert_eq!(program.frames.len().max(11), 11);
        let mut one_by_one = over(&text, dialect, 2000);
        let (mut told, mut refused) = (vec![], vec![]);
        for item in one_by_one.by_ref() {
            match item {
                Ok(event) => told.push(event),
                Err(e) => refused.push(e),
            }
        }
        prop_assert_eq!(told, events);
        prop_assert_eq!(refused, errors);
        prop_assert_eq!(one_by_one.state(), program.state());
    }

    /// Loops of a known number of rounds make that many moves, in either language.
    #[test]
    fn loops_go_round_as_often_as_they_say(rounds in proptest::collection::vec(0u32..5, 1..4)) {
        let (mut fanuc, mut ngc) = (String::from("G21 G91 G0\n"), String::from("G21 G91 G0\n"));
        for (i, n) in rounds.iter().enumerate() {
            let (v, level) = (100 + i, i + 1);
            fanuc += &format!("#{v}=0\nWHILE [#{v} LT {n}] DO{level}\n#{v}=#{v}+1\n");
            ngc += &format!("o{level} repeat [{n}]\n");
        }
        fanuc += "X1.\n";
        ngc += "X1.\n";
        for level in (1..=rounds.len()).rev() {
            fanuc += &format!("END{level}\n");
            ngc += &format!("o{level} endrepeat\n");
        }
        let want: u32 = rounds.iter().product();
        for (text, dialect) in [(fanuc, Dialect::Fanuc), (ngc, Dialect::LinuxCnc)] {
            let program = interpret(&text, dialect).unwrap();
            prop_assert_eq!(program.events.len() as u32, want, "{}", text);
            prop_assert_eq!(program.end_state.position.x, f64::from(want));
        }
    }

    /// Bytes of any kind, in any dialect of words: an end, no panic.
    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), which in 0usize..22) {
        let dialect = Dialect::ALL[which];
        let mut program = Interpreter::from_state(Cursor::new(&bytes), State::new(dialect), reading(100)).unwrap();
        let errors = program.read_all(&mut vec![]);
        prop_assert!(errors.len() <= MAX_ERRORS);
    }

    /// The lines of a text in memory are the lines of its bytes.
    #[test]
    fn lines_are_the_same_from_memory_and_from_bytes(text in "[ab\r\n\u{e4}\u{feff}]{0,60}", size in 1usize..6) {
        let text = text.trim_start_matches('\u{feff}');
        let from = BufReader::with_capacity(size, Cursor::new(text.as_bytes()));
        let mut source = Source::new(from).unwrap();
        let mut read = vec![];
        while let Some((n, line)) = source.read().unwrap() {
            read.push(line.to_string());
            prop_assert_eq!(n, read.len());
        }
        let want: Vec<&str> = crate::gcode::lines(text).collect();
        prop_assert_eq!(read, want);
    }
}

#[test]
fn a_name_as_long_as_a_book_is_not_repeated_whole() {
    let text = format!("o1 {}\nM2\n", "x".repeat(100_000));
    let errors = interpret(&text, Dialect::LinuxCnc).unwrap_err();
    let said = errors[0].to_string();
    assert!(
        said.starts_with("1:1 xxx") && said.ends_with("continue"),
        "{said}"
    );
    assert!(
        said.contains("x ... x") && said.len() < 1100,
        "{}",
        said.len()
    );
}

#[test]
fn long_lines_use_up_a_loops_patience_sooner() {
    let lap =
        |line: &str| format!("#1=0\no1 while [#1 LT 100]\n#1=[#1+1]\n{line}\no1 endwhile\nM2\n");
    let text = lap("G0 X1");
    let mut short = over(&text, Dialect::LinuxCnc, 1000);
    assert_eq!(short.read_all(&mut Vec::new()), []);
    let text = lap(&format!("G0 X1 ({})", "x".repeat(10 * LINE_BYTES)));
    let mut long = over(&text, Dialect::LinuxCnc, 1000);
    let errors = long.read_all(&mut Vec::new());
    let last = errors.last().unwrap().to_string();
    assert!(last.contains("1000 lines were read again"), "{last}");
}
