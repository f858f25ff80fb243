#![allow(clippy::unwrap_used)]
use super::*;
use proptest::prelude::*;

fn value(text: &str, dialect: Dialect) -> Result<f64, String> {
    let (parameters, state) = (Parameters::new(dialect), State::new(dialect));
    let mut e = Evaluator::new(text, &parameters, &state);
    let value = e.value().and_then(Value::number);
    value.map_err(|f| format!("{} {}", f.offset, f.complaint))
}

#[test]
fn the_two_families_compute_differently() {
    for (text, ngc, fanuc) in [
        ("[2 + 3 * 4]", 14.0, 14.0),
        ("[10 - 4 - 3]", 3.0, 3.0),
        ("FIX[-2.8]", -3.0, -2.0),
        ("FUP[-2.8]", -2.0, -3.0),
        ("FUP[2.1]", 3.0, 3.0),
        ("[-7 MOD 4]", 1.0, -3.0),
        // Logic, or bits: 6 AND 3 is true, or 2. The bits bind as * or +, logic binds last.
        ("[6 AND 3]", 1.0, 2.0),
        ("[1 + 2 AND 2]", 1.0, 3.0),
        ("[1 OR 2 EQ 3]", 1.0, 1.0),
        ("[4 OR 2 EQ 4]", 1.0, 0.0),
        ("[1 EQ 1.0000005]", 1.0, 0.0),
        ("[1 LT 2]", 1.0, 1.0),
        ("[2 GE 2]", 1.0, 1.0),
        ("-[1 - 3]", 2.0, 2.0),
    ] {
        assert_eq!(value(text, Dialect::LinuxCnc), Ok(ngc), "{text}");
        assert_eq!(value(text, Dialect::Fanuc), Ok(fanuc), "{text}");
    }
    assert_eq!(value("[2 ** 3]", Dialect::LinuxCnc), Ok(8.0));
    assert_eq!(value("ATAN[1]", Dialect::Haas), Ok(45.0));
    assert_eq!(value("ATAN[-1]/[0]", Dialect::LinuxCnc), Ok(-90.0));
    assert!(
        value("EXISTS[#<x>]", Dialect::Fanuc)
            .unwrap_err()
            .starts_with("0 EXISTS is no function")
    );
}

#[test]
fn nothing_without_a_value_becomes_a_number() {
    for (text, dialect, complaint) in [
        ("#1", Dialect::Fanuc, "0 #1 has no value"),
        ("[#1 EQ 0]", Dialect::Fanuc, "1 #1 has no value"),
        ("[#0 + 1]", Dialect::Fanuc, "1 #0 has no value"),
        ("#31", Dialect::Mach3, "0 #31 has no value"),
        ("#<a>", Dialect::LinuxCnc, "0 #<a> has no value"),
        (
            "#5401",
            Dialect::LinuxCnc,
            "0 #5401 is known to the machine only",
        ),
        ("[1 / 0]", Dialect::LinuxCnc, "3 division by zero"),
        ("[0 / 0]", Dialect::LinuxCnc, "3 division by zero"),
        (
            "[10 ** 400]",
            Dialect::LinuxCnc,
            "4 the result is no number",
        ),
        (
            "[-8 ** 0.5]",
            Dialect::LinuxCnc,
            "4 the result is no number",
        ),
        ("", Dialect::LinuxCnc, "0 the line ends"),
        (".", Dialect::LinuxCnc, "0 found '.'"),
        ("1e3", Dialect::LinuxCnc, ""),
    ] {
        match value(text, dialect) {
            Err(e) => assert!(
                e.starts_with(complaint) && !complaint.is_empty(),
                "{text}: {e}"
            ),
            // The number ends where a letter begins, as in a word.
            Ok(v) => assert_eq!((v, complaint), (1.0, ""), "{text}"),
        }
    }
    // Whether a variable is vacant can be asked; LinuxCNC's plain numbers are zero (G-Code Overview, Parameters).
    assert_eq!(value("[#1 EQ #0]", Dialect::Fanuc), Ok(1.0));
    assert_eq!(value("[#1 NE #0]", Dialect::Fanuc), Ok(0.0));
    assert_eq!(value("[5 EQ #0]", Dialect::Fanuc), Ok(0.0));
    assert_eq!(value("[#1 + #31]", Dialect::LinuxCnc), Ok(0.0));
}

/// An expression and its value by the rules of RS274/NGC, fully bracketed: precedence plays no part in it.
fn bracketed() -> impl Strategy<Value = (String, f64)> {
    let leaf = (-100i32..100).prop_map(|n| {
        let v = f64::from(n) / 4.0;
        (format!("{v}"), v)
    });
    leaf.prop_recursive(6, 40, 2, |inner| {
        (inner.clone(), inner, 0usize..9).prop_map(|((a, x), (b, y), which)| {
            let truth = |yes: bool| f64::from(u8::from(yes));
            let (name, v) = match which {
                0 => ("+", x + y),
                1 => ("-", x - y),
                2 => ("*", x * y),
                3 => ("GT", truth(x > y)),
                4 => ("LE", truth(x <= y)),
                5 => ("AND", truth(x != 0.0 && y != 0.0)),
                6 => ("XOR", truth((x != 0.0) != (y != 0.0))),
                7 => ("OR", truth(x != 0.0 || y != 0.0)),
                _ => ("NE", truth((x - y).abs() >= EQUAL_WITHIN)),
            };
            (format!("[{a} {name} {b}]"), v)
        })
    })
}

/// A chain of operators without brackets, and its value by the table of precedence, worked off level by level.
fn chain() -> impl Strategy<Value = (String, f64)> {
    let rest = proptest::collection::vec((0usize..7, 1i32..9), 0..8);
    (1i32..9, rest).prop_map(|(first, rest)| {
        let names = ["*", "MOD", "+", "-", "LT", "AND", "OR"];
        let levels = [0, 0, 1, 1, 2, 3, 3];
        let mut text = format!("[{first}");
        let mut values = vec![f64::from(first)];
        let mut operators = vec![];
        for (o, n) in rest {
            text += &format!(" {} {n}", names[o]);
            operators.push(o);
            values.push(f64::from(n));
        }
        for level in 0..4 {
            let mut i = 0;
            while i < operators.len() {
                if levels[operators[i]] != level {
                    i += 1;
                    continue;
                }
                let (x, y) = (values[i], values.remove(i + 1));
                let truth = |yes: bool| f64::from(u8::from(yes));
                values[i] = match operators.remove(i) {
                    0 => x * y,
                    1 if y == 0.0 => f64::NAN,
                    1 => x.rem_euclid(y),
                    2 => x + y,
                    3 => x - y,
                    4 => truth(x < y),
                    5 => truth(x != 0.0 && y != 0.0),
                    _ => truth(x != 0.0 || y != 0.0),
                };
            }
        }
        (text + "]", values[0])
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn brackets_compute_what_they_say((text, want) in bracketed()) {
        prop_assert_eq!(value(&text, Dialect::LinuxCnc), Ok(want));
    }

    #[test]
    fn operators_bind_as_the_table_says((text, want) in chain()) {
        let got = value(&text, Dialect::LinuxCnc);
        if want.is_finite() {
            prop_assert_eq!(got, Ok(want), "{}", text);
        } else {
            prop_assert!(got.is_err());
        }
    }

    #[test]
    fn any_text_is_a_number_or_an_error(text in "[-+*/#<>a-zA-Z0-9.\\[\\] ]{0,60}", which in 0usize..4) {
        let dialect = [Dialect::LinuxCnc, Dialect::Fanuc, Dialect::Mach3, Dialect::Haas][which];
        if let Ok(v) = value(&text, dialect) {
            prop_assert!(v.is_finite());
        }
    }
}
