//! Definitions read, refused, and compared with the files.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::post::BUILT_IN;

fn refusal(from: &str, to: &str) -> String {
    let good = BUILT_IN.iter().find(|(n, _)| *n == "grbl").unwrap().1;
    assert!(good.contains(from), "{from}");
    Post::from_toml("test", &good.replacen(from, to, 1))
        .unwrap_err()
        .to_string()
}

#[test]
fn every_shipped_post_is_built_in_and_loads() {
    let dir = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("posts");
    let mut files: Vec<String> = std::fs::read_dir(&dir)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    files.sort();
    let built_in: Vec<String> = BUILT_IN.iter().map(|(n, _)| format!("{n}.toml")).collect();
    assert_eq!(files, built_in, "posts/ and BUILT_IN differ");
    for (name, text) in BUILT_IN {
        let p = Post::load(name).unwrap();
        assert_eq!(p, Post::from_toml(name, text).unwrap());
        assert_eq!(
            p,
            Post::load(dir.join(format!("{name}.toml")).to_str().unwrap()).unwrap()
        );
        assert_eq!(p.name, name);
    }
}

#[test]
fn every_machine_names_a_post_that_exists() {
    for (name, _) in crate::machine::BUILT_IN {
        let machine = crate::machine::Machine::load(name).unwrap();
        Post::load(&machine.post).unwrap();
    }
}

#[test]
fn rounding_is_half_the_last_decimal() {
    let mut p = Post::load("grbl").unwrap();
    assert!((p.rounding().0 - 0.0005).abs() < 1e-12);
    p.units = Units::Inch;
    assert!((p.rounding().0 - 0.000_127).abs() < 1e-12);
}

#[test]
fn what_is_not_understood_is_refused_with_its_place() {
    let e = refusal("longest", "longset");
    assert!(e.starts_with("posts/test.toml:"), "{e}");
    assert!(e.contains("unknown key \"longset\" (did you mean \"longest\"?); the keys here are end, longest, separator, number_step"), "{e}");
    let e = refusal("S{speed}", "S{spede}");
    assert!(
        e.contains("{spede} is not known here (did you mean {speed}?)"),
        "{e}"
    );
    let e = refusal("units = \"mm\"", "units = \"cm\"");
    assert!(
        e.starts_with("posts/test.toml:4:9: units = \"cm\": must be one of mm, inch"),
        "{e}"
    );
    let e = refusal("mm = 3", "mm = 9");
    assert!(
        e.contains("mm = 9: must be at least 2 and at most 6: positions in mm need 3 decimals"),
        "{e}"
    );
    let e = refusal("mm = 3", "mm = 2.5");
    assert!(e.contains("must be a whole number"), "{e}");
    let e = refusal("longest = 70", "longest = 7");
    assert!(e.contains("must be at least 40"), "{e}");
    let e = refusal("helices = true", "helices = 1");
    assert!(e.starts_with("posts/test.toml:12:11: "), "{e}");
    let e = refusal("forbidden = \"?!~\"", "forbidden = \"_\"");
    assert!(e.contains("may not hold _"), "{e}");
    let e = refusal("[modal]", "[mode]");
    assert!(
        e.contains("unknown key \"mode\" (did you mean \"modal\"?)"),
        "{e}"
    );
}

#[test]
fn a_dialect_that_would_harm_is_refused() {
    for (from, to, what) in [
        ("{units} G17", "G17", "must have {units} once"),
        ("G17 G90", "G17", "must have G90"),
        ("G17 G90", "G17 G91", "programs are written with G90"),
        ("M3 S{speed}", "M3", "must start the spindle clockwise"),
        ("\"M30\"]", "\"M9\"]", "must have M30, to end the program"),
        ("\"M5\", ", "", "must have M5, to switch the spindle off"),
        ("\"M9\", ", "", "must have M9, to switch the coolant off"),
        ("off = [\"M5\"]", "off = []", "must stop the spindle, M5"),
        ("off = [\"M9\"]", "off = []", "usually M9"),
        ("M4 S{speed}", "M3 S{speed}", "counter-clockwise"),
        (
            "P{seconds}",
            "P1",
            "must have {seconds} or {milliseconds} once",
        ),
        ("G53 G0 {axes}", "G53 G0", "G53 would move the machine"),
        ("G53 G0 {axes}", "M7", "must have {axes} once"),
        (
            "planes = [\"xy\", \"zx\", \"yz\"]",
            "planes = []",
            "must name a plane",
        ),
        ("\"yz\"]", "\"xz\"]", "must be one of xy, zx, yz"),
        (
            "[work_offsets]",
            "[tool]\nchange = [\"M6\"]\nmost = 9\n[work_offsets]",
            "must have {tool} once",
        ),
        (
            "\"G59\"]",
            "\"G59\"]\nfurther = \"G54.1 P1\"",
            "must have {offset}",
        ),
        (
            "units = \"mm\"",
            "units = \"mm\"\nunit_words = { inch = \"G20\" }",
            "must have its word in unit_words",
        ),
        ("[\"M8\"]", "[\"M30\"]", "before it cuts"),
        ("[\"M8\"]", "[\"G0 Z0\"]", "would move the machine"),
        (
            "[\"M8\"]",
            "[\"M8 (wet?)\"]",
            "has one of ?!~, which this dialect forbids",
        ),
    ] {
        let e = refusal(from, to);
        assert!(e.contains(what), "{from} -> {to}: {e}");
    }
}

#[test]
fn an_unknown_name_lists_the_known_ones() {
    let e = Post::load("gbrl").unwrap_err().to_string();
    assert!(
        e.starts_with("post \"gbrl\" is not known (did you mean \"grbl\"?); there are "),
        "{e}"
    );
}

proptest::proptest! {
    // A file with a piece torn out or doubled is refused or read, never a panic; and so is any text at all.
    #[test]
    fn no_text_is_too_broken(at in 0..2_000_usize, length in 0..60_usize, double: bool, any_text: String) {
        use crate::machine::{self, Machine};
        let cut = |text: &str| {
            let chars: Vec<char> = text.chars().collect();
            let (start, end) = (at.min(chars.len()), (at + length).min(chars.len()));
            let keep = if double { start } else { end };
            chars[..end - (end - start) * usize::from(!double)].iter().chain(&chars[keep..]).collect::<String>()
        };
        for (name, text) in BUILT_IN {
            let _ = Post::from_toml(name, &cut(text)).map_err(|e| e.to_string());
        }
        for (name, text) in machine::BUILT_IN {
            let _ = Machine::from_toml(name, &cut(text)).map_err(|e| e.to_string());
        }
        proptest::prop_assert!(Post::from_toml("x", &any_text).is_err());
        proptest::prop_assert!(Machine::from_toml("x", &any_text).is_err());
    }
}
