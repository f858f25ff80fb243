#![allow(clippy::unwrap_used)]
use super::super::dialect::Dialect;
use super::super::state::PathMode;
use super::super::tongue::driver;
use super::*;
use proptest::prelude::*;

fn told(body: &str) -> Vec<String> {
    let text = format!("BEGIN PGM P MM\n{body}\nEND PGM P MM\n");
    driver::told(&text, Dialect::Heidenhain)
}

fn end_state(body: &str) -> State {
    let text = format!("BEGIN PGM P MM\n{body}\nEND PGM P MM\n");
    driver::run(&text, Dialect::Heidenhain).unwrap().1
}

#[test]
fn labels_are_found_with_and_without_block_numbers() {
    let label = |text| label(text).map(String::from);
    assert_eq!(label("12 LBL 5"), Some("LBL5".into()));
    assert_eq!(label("lbl 05 ; here"), Some("LBL5".into()));
    assert_eq!(label("  LBL \"Side\""), Some("LBL\"SIDE\"".into()));
    assert_eq!(label("LBL 0"), None);
    assert_eq!(label("CALL LBL 5"), None);
    assert_eq!(label("; LBL 5"), None);
}

#[test]
fn the_tolerance_cycle_sets_the_path_mode() {
    let path = |body: &str| end_state(body).path;
    let blend = |tolerance| PathMode::Blend { tolerance };
    let on = "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05";
    assert_eq!(path(on), blend(Some(0.05)));
    assert_eq!(path(&format!("{on}\nCYCL DEF 32.1 T")), blend(None));
    assert_eq!(path(&format!("{on}\nCYCL DEF 32.1 T0")), blend(None));
}

#[test]
fn feed_and_speed_of_a_tool_call_stay_until_the_next() {
    assert_eq!(
        told(
            "TOOL CALL 1 Z S1000 F300\nL X+1\nL X+2 F50\nL X+3 FAUTO\nTOOL CALL 2 Z\nL X+4\nL X+5 FMAX\nL X+6"
        ),
        [
            "tool 1",
            "feed X1 Y0 Z0 F300",
            "feed X2 Y0 Z0 F50",
            "feed X3 Y0 Z0 F300",
            "tool 2",
            "feed X4 Y0 Z0 F300",
            "rapid X5 Y0 Z0",
            "feed X6 Y0 Z0 F300",
            "end"
        ]
    );
}

#[test]
fn the_pole_is_gone_with_another_datum() {
    let body = "CC X+0 Y+0\nCYCL DEF 7.1 X+5\nLP PR+5 PA+0 F100";
    assert_eq!(
        told(body),
        ["error 4:3 LP turns about the pole, and none is set: put a CC block before it"]
    );
}

#[test]
fn a_refused_line_changes_nothing() {
    let mut state = State::new(Dialect::Heidenhain);
    let (mut memory, mut events) = (Memory::default(), vec![]);
    line(&mut state, &mut memory, "BEGIN PGM P MM", 1, &mut events).unwrap();
    let before = (state.clone(), memory.clone());
    // The feed and the spindle are sound, the cycle call is not.
    let text = "L X+1 F100 M3 M99";
    assert!(line(&mut state, &mut memory, text, 2, &mut events).is_err());
    assert_eq!((state, memory), before);
    assert!(events.is_empty());
}

/// A coordinate as a control or a person may write it.
fn written(value: i32, style: u8) -> String {
    let v = f64::from(value) / 1000.0;
    let sign = if value < 0 {
        "-"
    } else {
        ["+", ""][usize::from(style & 1)]
    };
    let text = format!("{sign}{:.3}", v.abs());
    match style & 6 {
        2 => text.replace('.', ","),
        4 => text.trim_end_matches('0').to_string(),
        _ => text,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// However numbers are written, absolute or incremental: the tool goes where they say.
    #[test]
    fn straight_blocks_lead_where_they_say(
        moves in proptest::collection::vec((0usize..3, -500_000i32..500_000, any::<u8>(), any::<bool>()), 1..30),
    ) {
        let mut body = String::new();
        let mut at = [0.0f64; 3];
        let mut want = vec![];
        for (axis, value, style, incremental) in moves {
            let name = ["X", "Y", "Z"][axis];
            let i = if incremental { "I" } else { "" };
            body.push_str(&format!("L {i}{name}{} F100\n", written(value, style)));
            let v = f64::from(value) / 1000.0;
            at[axis] = if incremental { at[axis] + v } else { v };
            want.push(at);
        }
        let text = format!("BEGIN PGM P MM\n{body}END PGM P MM");
        let (events, _) = driver::run(&text, Dialect::Heidenhain).unwrap();
        let got: Vec<_> = events.iter().filter_map(|e| match e {
            Event::Motion(m) => Some(m.to),
            _ => None,
        }).collect();
        prop_assert_eq!(got.len(), want.len());
        for (g, w) in got.iter().zip(want) {
            prop_assert!((0..3).all(|i| (g[i] - w[i]).abs() < 1e-6));
        }
    }

    /// The same arc by its centre, by its radius, as a polar block and by its tangent.
    #[test]
    fn four_ways_to_say_an_arc(r in 1.0..50.0f64, from in -180.0..180.0f64, turn in 5.0..175.0f64, left: bool) {
        let sweep = if left { turn } else { -turn };
        let place = |angle: f64| (r * angle.to_radians().cos(), r * angle.to_radians().sin());
        let ((x, y), (u, v)) = (place(from), place(from + sweep));
        let dr = if left { "DR+" } else { "DR-" };
        // A run-up along the tangent.
        let way = if left { 1.0 } else { -1.0 };
        let (p, q) = (x + way * y, y - way * x);
        let start = format!("L X{p:.6} Y{q:.6} F100\nL X{x:.6} Y{y:.6}\nCC X0 Y0\n");
        for block in [
            format!("C X{u:.6} Y{v:.6} {dr}"),
            format!("CR X{u:.6} Y{v:.6} R+{r:.6} {dr}"),
            format!("CP IPA{sweep:+.6} {dr}"),
            format!("CT X{u:.6} Y{v:.6}"),
        ] {
            let text = format!("BEGIN PGM P MM\n{start}{block}\nEND PGM P MM");
            let (events, _) = driver::run(&text, Dialect::Heidenhain).unwrap();
            let Some(Event::Motion(m)) = events.get(2) else { panic!("{block}") };
            let arc = m.arc.unwrap();
            prop_assert!((arc.sweep.to_degrees() - sweep).abs() < 0.05, "{} {:?}", block, arc);
            prop_assert!(arc.center.x.hypot(arc.center.y) < 0.05, "{} {:?}", block, arc);
            prop_assert!((m.to.x - u).hypot(m.to.y - v) < 1e-4);
        }
    }

    /// No bytes make it panic, and what is refused changes nothing.
    #[test]
    fn no_text_makes_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..120)) {
        let text: String = bytes.iter().map(|b| char::from(*b)).collect();
        let mut state = State::new(Dialect::Heidenhain);
        let (mut memory, mut events) = (Memory::default(), vec![]);
        line(&mut state, &mut memory, "BEGIN PGM P MM", 1, &mut events).unwrap();
        for text in text.split('\n') {
            let before = (state.clone(), memory.clone(), events.len());
            if line(&mut state, &mut memory, text, 2, &mut events).is_err() {
                prop_assert_eq!((&state, &memory, events.len()), (&before.0, &before.1, before.2));
            }
            label(text);
        }
    }

    /// Nor do words put together at random.
    #[test]
    fn no_words_make_it_panic(words in proptest::collection::vec((0usize..WORDS.len(), any::<bool>()), 1..24)) {
        let text: String = words.iter().map(|(w, blank)| format!("{}{}", WORDS[*w], if *blank { " " } else { "" })).collect();
        driver::told(&format!("BEGIN PGM P MM\nQ1 = 3\n{text}\nEND PGM P MM"), Dialect::Heidenhain);
    }
}

/// Pieces of blocks.
const WORDS: [&str; 44] = [
    "L",
    "C",
    "CC",
    "CR",
    "CT",
    "LP",
    "CP",
    "X+10",
    "IY-5",
    "Z",
    "R+5",
    "R0",
    "DR+",
    "DR-",
    "FMAX",
    "F100",
    "FQ1",
    "M3",
    "M99",
    "M91",
    "PR+5",
    "PA+30",
    "IPA-720",
    "Q1",
    "=",
    "+",
    "(",
    ")",
    "SIN",
    "^",
    "/0",
    "TOOL CALL",
    "\"A\"",
    "LBL",
    "CALL LBL 1",
    "REP 2",
    "CYCL DEF 7.1",
    "CYCL DEF 200",
    "~",
    "\n",
    "FN 4: Q1 =",
    "DIV",
    "9,5",
    "\u{e4}",
];
