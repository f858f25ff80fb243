#![allow(clippy::unwrap_used)]
use super::super::dialect::Dialect;
use super::super::state::PathMode;
use super::super::tongue::driver;
use super::*;
use proptest::prelude::*;

fn told(text: &str) -> Vec<String> {
    driver::told(text, Dialect::Siemens)
}

#[test]
fn labels_headers_and_block_numbers_are_found() {
    let label = |text| label(text).map(String::from);
    assert_eq!(label("N10 AGAIN: X5"), Some("AGAIN".into()));
    assert_eq!(label("_again2 : X5"), Some("_AGAIN2".into()));
    assert_eq!(label("/1 n10 G0"), Some("N10".into()));
    assert_eq!(label(":20 G0"), Some(":20".into()));
    assert_eq!(label("%_N_hole_SPF ; sub"), Some("%_N_HOLE_SPF".into()));
    assert_eq!(label("G0 X5"), None);
    assert_eq!(label("; AGAIN:"), None);
    assert_eq!(label("A1: X5"), None);
}

#[test]
fn corners_come_to_path_modes() {
    let path = |text: &str| driver::run(text, Dialect::Siemens).unwrap().1.path;
    let blend = |tolerance| PathMode::Blend { tolerance };
    assert_eq!(path("G60"), PathMode::ExactStop);
    assert_eq!(path("G64"), blend(None));
    assert_eq!(path("G641 ADIS=0.5"), blend(Some(0.5)));
    assert_eq!(path("G641 ADIS=0.5\nG642 CTOL=0.02"), blend(Some(0.02)));
    assert_eq!(path("COMPCAD CTOL=0.01 G64"), blend(Some(0.01)));
    assert_eq!(path("COMPCAD CTOL=0.01 G64\nCOMPOF"), blend(None));
    assert_eq!(path("G70\nCYCLE832(0.001,_FINISH,1)"), blend(Some(0.0254)));
    assert_eq!(path("CYCLE832(0.1,112103)\nCYCLE832(0,0)"), blend(None));
    assert_eq!(
        path("CYCLE832(0.1,_ROUGH,1)\nCYCLE832(0,_OFF,1)"),
        blend(None)
    );
}

#[test]
fn variables_of_a_subprogram_are_its_own() {
    let sub = "M30\n%_N_SUB__SPF\nDEF REAL DEPTH=-9\nG0 Z=DEPTH\nM17";
    assert_eq!(
        told(&format!("DEF REAL DEPTH=-1\nSUB_\nG0 Z=DEPTH\n{sub}")),
        ["rapid X0 Y0 Z-9", "rapid X0 Y0 Z-1", "end"]
    );
}

#[test]
fn skipped_blocks_are_skipped_when_the_switch_is_on() {
    let mut state = State::new(Dialect::Siemens);
    state.block_delete = true;
    let (mut memory, mut events) = (Memory::default(), vec![]);
    line(&mut state, &mut memory, "/ G0 X?", 1, &mut events).unwrap();
    line(&mut state, &mut memory, "/3 G0 X1", 2, &mut events).unwrap();
    assert!(events.is_empty());
    line(&mut state, &mut memory, "G0 X1", 3, &mut events).unwrap();
    assert_eq!(events.len(), 1);
}

#[test]
fn a_refused_line_changes_nothing() {
    let mut state = State::new(Dialect::Siemens);
    let (mut memory, mut events) = (Memory::default(), vec![]);
    for text in [
        "T5 M6 S100 M3 G1 X5",
        "R1=5 R2=R3",
        "G55 G2 X5 F10",
        "DEF REAL AB=1, CD=EF",
    ] {
        let before = (state.clone(), memory.clone());
        assert!(line(&mut state, &mut memory, text, 1, &mut events).is_err());
        assert_eq!((&state, &memory), (&before.0, &before.1), "{text}");
        assert!(events.is_empty());
    }
}

#[test]
fn expressions_by_hand() {
    for (text, want) in [
        ("2+3*4", "14"),
        ("-2*3", "-6"),
        ("7-2-1", "4"),
        ("8/2/2", "2"),
        ("-POT(2)", "-4"),
        ("3*-2", "-6"),
        ("-7 DIV 2", "-3"),
        ("-7 MOD 2", "-1"),
        ("ATAN2(1,1)", "45"),
        ("ROUND(-2.5)", "-3"),
        ("ROUNDUP(2.1)", "3"),
        ("1.5EX-1", "0.15"),
        ("ABS(-3)+MINVAL(2,1)", "4"),
    ] {
        assert_eq!(
            told(&format!("G0 X={text}")),
            [format!("rapid X{want} Y0 Z0")],
            "{text}"
        );
    }
}

/// A tree of an expression, written with its value.
fn expression() -> impl Strategy<Value = (String, f64)> {
    let leaf = (1i32..40).prop_map(|n| (format!("{}", f64::from(n) / 4.0), f64::from(n) / 4.0));
    leaf.prop_recursive(4, 24, 2, |inner| {
        (inner.clone(), inner, 0usize..4).prop_map(|((a, x), (b, y), operator)| match operator {
            0 => (format!("({a}+{b})"), x + y),
            1 => (format!("({a} - {b})"), x - y),
            2 => (format!("({a})*({b})"), x * y),
            _ => (format!("ABS({a}-{b})"), (x - y).abs()),
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Expressions come to what arithmetic says.
    #[test]
    fn expressions_come_to_their_values((text, value) in expression()) {
        let (events, _) = driver::run(&format!("G0 X={text}"), Dialect::Siemens).unwrap();
        let Some(Event::Motion(m)) = events.first() else { panic!("{text}") };
        prop_assert!((m.to.x - value).abs() <= 1e-9 * value.abs().max(1.0), "{} {} {}", text, m.to.x, value);
    }

    /// G90 with G91, AC and IC mixed: the tool goes where the words say, moved by TRANS where they are absolute.
    #[test]
    fn straight_blocks_lead_where_they_say(
        moves in proptest::collection::vec((0usize..3, -500_000i32..500_000, 0u8..4), 1..30),
        shift in proptest::array::uniform3(-1000i32..1000),
    ) {
        let [a, b, c] = shift;
        let mut text = format!("TRANS X{a} Y{b} Z{c}\nG1 X0 Y0 Z0 F100\n");
        let mut at = shift.map(f64::from);
        let mut want = vec![at];
        for (axis, value, form) in moves {
            let v = f64::from(value) / 1000.0;
            let name = ["X", "Y", "Z"][axis];
            text.push_str(&match form {
                0 => format!("G90 G1 {name}{v}\n"),
                1 => format!("G91 G1 {name}{v}\n"),
                2 => format!("G1 {name}=AC({v})\n"),
                _ => format!("G1 {name}=IC({v})\n"),
            });
            at[axis] = if form % 2 == 1 { at[axis] + v } else { f64::from(shift[axis]) + v };
            want.push(at);
        }
        let (events, _) = driver::run(&text, Dialect::Siemens).unwrap();
        prop_assert_eq!(events.len(), want.len());
        for (e, w) in events.iter().zip(want) {
            let Event::Motion(m) = e else { panic!("{e:?}") };
            prop_assert!((0..3).all(|i| (m.to[i] - w[i]).abs() < 1e-6));
        }
    }

    /// The same arc by its centre in two ways, by its radius, and by its opening angle in two ways.
    #[test]
    fn five_ways_to_say_an_arc(r in 1.0..50.0f64, from in -180.0..180.0f64, turn in 5.0..355.0f64, left: bool, p in 0usize..3) {
        prop_assume!((turn - 180.0).abs() > 2.0);
        let (code, [a, b, i, j]) = [
            ("G17", ["X", "Y", "I", "J"]),
            ("G18", ["Z", "X", "K", "I"]),
            ("G19", ["Y", "Z", "J", "K"]),
        ][p];
        let sweep = if left { turn } else { -turn };
        let place = |angle: f64| (r * angle.to_radians().cos(), r * angle.to_radians().sin());
        let ((x, y), (u, v)) = (place(from), place(from + sweep));
        let g = if left { "G3" } else { "G2" };
        let signed = if turn > 180.0 { -r } else { r };
        for block in [
            format!("{a}{u:.6} {b}{v:.6} {i}{:.6} {j}{:.6}", -x, -y),
            format!("{a}{u:.6} {b}{v:.6} {i}=AC(0) {j}=AC(0)"),
            format!("{a}{u:.6} {b}{v:.6} CR={signed:.6}"),
            format!("{a}{u:.6} {b}{v:.6} AR={turn:.6}"),
            format!("{i}{:.6} {j}{:.6} AR={turn:.6}", -x, -y),
        ] {
            let text = format!("{code} G0 {a}{x:.6} {b}{y:.6}\n{g} {block} F100");
            let (events, _) = driver::run(&text, Dialect::Siemens).unwrap();
            let Some(Event::Motion(m)) = events.get(1) else { panic!("{block}") };
            let arc = m.arc.unwrap();
            prop_assert!((arc.sweep.to_degrees() - sweep).abs() < 0.05, "{} {:?}", block, arc);
            prop_assert!(arc.center.coords.norm() < 0.05, "{} {:?}", block, arc);
        }
    }

    /// No bytes make it panic, and what is refused changes nothing.
    #[test]
    fn no_text_makes_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..120)) {
        let text: String = bytes.iter().map(|b| char::from(*b)).collect();
        let mut state = State::new(Dialect::Siemens);
        let (mut memory, mut events) = (Memory::default(), vec![]);
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
        told(&format!("R1=3 F100\n{text}\nM30"));
    }
}

/// Pieces of blocks.
const WORDS: [&str; 48] = [
    "G0",
    "G1",
    "G2",
    "G91",
    "G70",
    "X10",
    "Y=IC(5)",
    "Z=R1",
    "I5",
    "J=AC(",
    ")",
    "CR=5",
    "TURN=2",
    "AR=90",
    "F100",
    "S1=5",
    "M3",
    "M6",
    "T=\"A\"",
    "D0",
    "SUPA",
    "TRANS",
    "R1=",
    "+",
    "*",
    "(",
    "SIN(",
    "DIV",
    "AND",
    "NOT",
    "==",
    "<",
    "IF ",
    "ELSE",
    "ENDIF",
    "GOTOB ",
    "AGAIN",
    "AGAIN:",
    "REPEAT ",
    "P=2",
    "CYCLE81(5,0,1,-2)",
    "MCALL ",
    "\n",
    "DEF REAL ",
    "AB",
    "=",
    "1EX9",
    "\u{e4}",
];
