//! The TOML reader's complaints in a machinist's words.
//!
//! Crosses the border: its message and the line that it is about in; what is wrong and what to do out. Messages that are not known here
//! are passed on as they are.

/// A message about `line` (of the file, without its end), beginning at character `column` of it, from 1.
pub(super) fn plain(message: &str, line: &str, column: usize) -> String {
    let key = match line.split_once('=') {
        Some((key, _)) => format!("{}: ", key.trim()),
        None => String::new(),
    };
    let here: String = line.chars().skip(column.saturating_sub(1)).collect();
    let before = line.chars().nth(column.wrapping_sub(2));
    if let Some(told) = message.strip_prefix("invalid type: ") {
        return kind(&key, told);
    }
    if here.starts_with(',') && before.is_some_and(|c| c.is_ascii_digit()) {
        return format!("{key}a number has a decimal point, no comma: write 2.5, not 2,5");
    }
    let what = match message {
        m if m.starts_with("needs ") => m,
        m if m.starts_with("duplicate key") => "stands here a second time: leave one of them out",
        m if m.starts_with("key with no value") => {
            "has no value: write KEY = VALUE, with an equals sign"
        }
        m if m.starts_with("string values must be quoted") => {
            "text stands between plain double quotes: \"...\""
        }
        m if m.starts_with("invalid boolean") => "write true or false, in small letters",
        m if m.starts_with("missing comma between array elements") => {
            "a comma between the entries of a list is missing, or a quote is left open here or on the line before"
        }
        m if m.starts_with("invalid basic string") => {
            "a quote is left open: text stands between double quotes, \"...\""
        }
        m if m.starts_with("unclosed array") => "a list is left open: its ] is missing",
        _ => return format!("{key}{}", words(message)),
    };
    match key.is_empty() {
        true => what.to_string(),
        false => format!("{key}{what}"),
    }
}

/// `string "70", expected a number` and its like.
fn kind(key: &str, told: &str) -> String {
    let (found, wanted) = told.split_once(", expected ").unwrap_or((told, ""));
    let wanted = words(wanted);
    let found = found.replace('`', "");
    let text = found
        .strip_prefix("string \"")
        .and_then(|t| t.strip_suffix('"'));
    let (wanted, advice) = match (wanted.as_str(), text) {
        (w, Some(t)) if w.contains("number") && t.trim().parse::<f64>().is_ok() => {
            ("a number", format!("leave the quotes away: {}", t.trim()))
        }
        (w, _) if w.contains("number") => ("a number", "write it without quotes".into()),
        (w, _) if w.contains("bool") => {
            ("true or false", "write one of them, without quotes".into())
        }
        (w, Some(t)) if w.contains("list") => {
            ("a list", format!("put it between brackets: [\"{t}\"]"))
        }
        (w, _) if w.contains("list") => ("a list", "put it between brackets: [ ... ]".into()),
        (w, _) if w.contains("string") => ("text", "put it between double quotes: \"...\"".into()),
        (w, _) if w.contains("struct") || w.contains("map") => (
            "a table",
            "its keys stand below it, under a header in brackets".into(),
        ),
        (w, _) => return format!("{key}{found} stands here, and {w} is wanted"),
    };
    let found = found
        .replacen("string ", "", 1)
        .replace("integer ", "")
        .replace("floating point ", "")
        .replace("boolean ", "")
        .replace("sequence", "a list")
        .replace("map", "a table");
    format!("{key}{found} is not {wanted}: {advice}")
}

/// serde's names for kinds of values.
fn words(message: &str) -> String {
    message
        .replace("expected f64", "expected a number")
        .replace("floating point", "number")
        .replace("f64", "a number")
        .replace("an array of length", "a list of length")
        .replace("a sequence", "a list")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::machine::Machine;
    use crate::post::{BUILT_IN, Post};

    fn of_post(from: &str, to: &str) -> String {
        let text = BUILT_IN.iter().find(|(n, _)| *n == "grbl").unwrap().1;
        assert!(text.contains(from), "{from}");
        let wrong = text.replacen(from, to, 1);
        let told = Post::named("p", "p.toml", &wrong).unwrap_err().to_string();
        told.split_once(": ").unwrap().1.to_string()
    }

    #[test]
    fn what_is_wrong_and_what_to_do() {
        for (from, to, told) in [
            (
                "longest = 70",
                "longest = \"70\"",
                "longest: \"70\" is not a number: leave the quotes away: 70",
            ),
            (
                "pause = [\"M0\"]",
                "pause = \"M0\"",
                "pause: \"M0\" is not a list: put it between brackets: [\"M0\"]",
            ),
            (
                "full_circles = true",
                "full_circles = \"yes\"",
                "full_circles: \"yes\" is not true or false: write one of them, without quotes",
            ),
            (
                "units = \"mm\"",
                "units = 1",
                "units: 1 is not text: put it between double quotes: \"...\"",
            ),
            (
                "seconds = 2",
                "seconds = 2,5",
                "seconds: a number has a decimal point, no comma: write 2.5, not 2,5",
            ),
            (
                "waits = false",
                "waits = false\nwaits = true",
                "waits: stands here a second time: leave one of them out",
            ),
            (
                "waits = false",
                "waits: false",
                "has no value: write KEY = VALUE, with an equals sign",
            ),
            (
                "waits = false",
                "waits = False",
                "waits: write true or false, in small letters",
            ),
            (
                "reader = \"grbl\"",
                "reader = \u{201c}grbl\u{201d}",
                "reader: text stands between plain double quotes: \"...\"",
            ),
            (
                "off = [\"M9\"]",
                "off = [\"M9]",
                "a comma between the entries of a list is missing, or a quote is left open here or on the line before",
            ),
        ] {
            assert_eq!(of_post(from, to), told, "{to}");
        }
    }

    #[test]
    fn lists_have_their_length() {
        let text = include_str!("../../machines/grbl-3018.toml");
        for (to, told) in [
            (
                "[284, 180]",
                "travel_mm: needs 3 numbers, X, Y and Z, and has 2",
            ),
            (
                "[284, 180, 40, 360]",
                "travel_mm: needs 3 numbers, X, Y and Z, and has 4",
            ),
            (
                "284",
                "travel_mm: 284 is not a list: put it between brackets: [ ... ]",
            ),
            (
                "[284, \"180\", 40]",
                "travel_mm: \"180\" is not a number: leave the quotes away: 180",
            ),
        ] {
            let e = Machine::from_toml("m", &text.replace("[284, 180, 40]", to)).unwrap_err();
            assert!(e.to_string().ends_with(told), "{to}: {e}");
        }
        let e = Machine::from_toml("m", &text.replace("[0, 10000]", "[0, 1, 2]")).unwrap_err();
        let told = "spindle_rpm: needs 2 numbers, the lowest and the highest, and has 3";
        assert!(e.to_string().ends_with(told), "{e}");
    }
}
