//! All that is wrong with a data file, not only the first: for people who check a file of their own.
//!
//! Crosses the border: the file's text, a reader of such files and good files of the same kind in; complaints with their places in the
//! user's own text out. A reader stops at the first key that is unknown or missing; here it goes on: an unknown key is taken for the
//! nearest known one, or its line is left out; a missing one is lent by a good file. What then comes up of our own doing is not told.
//! Never writes a file, and never says that a file is good: only the reader does.

use super::data::{DataError, Place};

/// So many repairs are made: no file has more keys.
const MOST_REPAIRS: usize = 120;

/// The text while it is being repaired.
struct Draft {
    lines: Vec<String>,
    /// Indices of lines that are ours, rising.
    lent: Vec<usize>,
    /// Indices of lines that were changed or left out.
    touched: Vec<usize>,
}

/// Every complaint about `text`, in the order in which they come up; empty when `read` takes it. `good` are the texts of good files.
pub fn complaints(
    text: &str,
    good: &[&str],
    read: impl Fn(&str) -> Result<(), DataError>,
) -> Vec<DataError> {
    let mut draft = Draft {
        lines: text.split('\n').map(str::to_string).collect(),
        lent: Vec::new(),
        touched: Vec::new(),
    };
    let mut found = Vec::new();
    for _ in 0..MOST_REPAIRS {
        let Err(e) = read(&draft.lines.join("\n")) else {
            break;
        };
        let repaired = match &e {
            DataError::UnknownKey {
                at, key, nearest, ..
            } => draft.rename(at, key, nearest.as_deref()),
            DataError::Missing { at, key, .. } => draft.lend(at, key, good),
            _ => false,
        };
        let each = match e {
            DataError::Several(all) => all,
            one => vec![astray(one, good)],
        };
        found.extend(each.into_iter().filter_map(|e| draft.told(e)));
        if !repaired {
            break;
        }
    }
    found
}

impl Draft {
    /// The unknown key becomes the nearest known one. Without one, or where that one stands there already, its line goes; the header of
    /// an unknown table goes with all that it heads.
    fn rename(&mut self, at: &Place, key: &str, nearest: Option<&str>) -> bool {
        let Some(index) = at.line.checked_sub(1) else {
            return false;
        };
        let again = self.touched.contains(&index);
        let Some(line) = self.lines.get(index).filter(|l| !l.is_empty()) else {
            return false;
        };
        self.touched.push(index);
        if let Some(n) = nearest.filter(|_| !again && line.contains(key)) {
            let renamed = line.replacen(key, n, 1);
            let was = self
                .lines
                .get_mut(index)
                .map(|l| std::mem::replace(l, renamed));
            if self.lines.join("\n").parse::<toml::Table>().is_ok() {
                return true;
            }
            // It stands there already.
            if let (Some(was), Some(line)) = (was, self.lines.get_mut(index)) {
                *line = was;
            }
        }
        let heads = |l: &String| l.trim_start().starts_with('[');
        let table = self.lines.get(index).is_some_and(heads);
        let rest = self.lines.iter_mut().skip(index);
        for (i, line) in rest.enumerate() {
            if i > 0 && (!table || heads(line)) {
                break;
            }
            line.clear();
        }
        true
    }

    /// The missing key comes from a good file, on a line of its own behind the header of its table.
    fn lend(&mut self, at: &Place, key: &str, good: &[&str]) -> bool {
        let Some(index) = at.line.checked_sub(1) else {
            return false;
        };
        let header = self.lines.get(index).map(|l| l.trim()).unwrap_or_default();
        let table = header
            .strip_prefix('[')
            .and_then(|h| h.split(']').next())
            .map(str::trim);
        let Some(value) = good.iter().find_map(|text| value_of(text, table, key)) else {
            return false;
        };
        // Without a header it is missing from the file itself, whose keys come before any table.
        let place = match table {
            Some(_) => index + 1,
            None => 0,
        };
        for ours in self.lent.iter_mut().chain(&mut self.touched) {
            *ours += usize::from(*ours >= place);
        }
        self.lines.insert(place, format!("{key} = {value}"));
        self.lent.push(place);
        self.lent.sort_unstable();
        true
    }

    /// A complaint with its place in the user's own text; `None` for what is our doing.
    fn told(&self, mut e: DataError) -> Option<DataError> {
        let at = match &mut e {
            DataError::Syntax { at, .. }
            | DataError::UnknownKey { at, .. }
            | DataError::Missing { at, .. }
            | DataError::Value { at, .. } => at,
            _ => return Some(e),
        };
        let index = at.line.checked_sub(1)?;
        let ours = self.lent.contains(&index);
        at.line -= self.lent.iter().filter(|l| **l < index).count();
        if matches!(e, DataError::Missing { .. }) {
            // From the top of the file, where the lent ones stand.
            return Some(e);
        }
        let syntax = matches!(&e, DataError::Syntax { message, .. } if !message.contains("stands in the wrong place"));
        let spoilt = syntax && !(self.lent.is_empty() && self.touched.is_empty());
        (!ours && !spoilt).then_some(e)
    }
}

/// An unknown key that is one of another table: said so.
fn astray(e: DataError, good: &[&str]) -> DataError {
    let DataError::UnknownKey { at, key, .. } = &e else {
        return e;
    };
    let has = |text: &&str| {
        let file: toml::Table = text.parse().ok()?;
        let mut tables = file.iter().filter_map(|(n, v)| Some((n, v.as_table()?)));
        match file.contains_key(key) {
            true => Some("the top of the file, before the first header".to_string()),
            false => tables
                .find(|(_, t)| t.contains_key(key))
                .map(|(name, _)| format!("[{name}]")),
        }
    };
    match good.iter().find_map(has) {
        Some(table) => DataError::Syntax {
            at: at.clone(),
            message: format!("\"{key}\" stands in the wrong place: it belongs to {table}"),
        },
        None => e,
    }
}

/// A key's value as a good file has it, in one line.
fn value_of(text: &str, table: Option<&str>, key: &str) -> Option<String> {
    let file: toml::Table = text.parse().ok()?;
    let keys = match table {
        None => &file,
        Some(name) => file.get(name)?.as_table()?,
    };
    Some(inline(keys.get(key)?))
}

fn inline(value: &toml::Value) -> String {
    match value {
        toml::Value::Table(t) => {
            let each: Vec<String> = t
                .iter()
                .map(|(k, v)| format!("{k} = {}", inline(v)))
                .collect();
            format!("{{ {} }}", each.join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::machine;
    use crate::post::{self, Post};

    fn of_post(text: &str) -> Vec<String> {
        let good: Vec<&str> = post::BUILT_IN.iter().map(|(_, t)| *t).collect();
        complaints(text, &good, |t| {
            Post::named("mine", "mine.toml", t).map(drop)
        })
        .iter()
        .map(ToString::to_string)
        .collect()
    }

    fn grbl() -> &'static str {
        post::BUILT_IN.iter().find(|(n, _)| *n == "grbl").unwrap().1
    }

    #[test]
    fn a_good_file_has_none() {
        for (name, text) in post::BUILT_IN {
            assert_eq!(of_post(text), Vec::<String>::new(), "{name}");
        }
    }

    #[test]
    fn every_missing_key_is_told_at_its_own_table() {
        let line =
            |text: &str, start: &str| text.lines().position(|l| l.starts_with(start)).unwrap() + 1;
        let text: String = grbl()
            .lines()
            .filter(|l| {
                ![
                    "units =",
                    "off = [\"M5\"]",
                    "waits",
                    "charset",
                    "end = [\"M5\"",
                ]
                .iter()
                .any(|k| l.starts_with(k))
            })
            .map(|l| format!("{l}\n"))
            .collect();
        let told = of_post(&text);
        assert_eq!(told.len(), 5, "{told:#?}");
        for (key, header) in [
            ("charset", "[comments]"),
            ("off", "[spindle]"),
            ("waits", "[spindle]"),
            ("end", "[program]"),
        ] {
            let at = format!("mine.toml:{}:", line(&text, header));
            assert!(
                told.iter()
                    .any(|t| t.starts_with(&at) && t.contains(&format!("\"{key}\" is missing"))),
                "{key}: {told:#?}"
            );
        }
        assert!(
            told.iter().any(|t| t.contains("\"units\" is missing")),
            "{told:#?}"
        );
    }

    #[test]
    fn a_missing_table_an_unknown_key_and_a_wrong_value_are_all_told_where_they_are() {
        let spindle = grbl().find("[spindle]").unwrap();
        let coolant = grbl().find("[coolant]").unwrap();
        let text = format!("{}{}", &grbl()[..spindle], &grbl()[coolant..])
            .replace("longest = 70", "longset = 70")
            .replace("mm = 3\n", "mm = 9\n");
        let told = of_post(&text);
        let row = |part: &str| text.lines().position(|l| l.contains(part)).unwrap() + 1;
        assert_eq!(told.len(), 3, "{told:#?}");
        let unknown = format!(
            "mine.toml:{}:1: unknown key \"longset\" (did you mean \"longest\"?)",
            row("longset")
        );
        assert!(told.iter().any(|t| t.starts_with(&unknown)), "{told:#?}");
        assert!(
            told.iter().any(|t| t.contains("\"spindle\" is missing")),
            "{told:#?}"
        );
        let value = format!("mine.toml:{}:6: mm = 9: must be", row("mm = 9"));
        assert!(told.iter().any(|t| t.starts_with(&value)), "{told:#?}");
    }

    #[test]
    fn a_key_in_the_wrong_table_is_sent_to_its_own() {
        let told = of_post(&grbl().replace("[lines]\n", "[lines]\nwaits = true\n"));
        assert_eq!(told.len(), 1, "{told:#?}");
        assert!(
            told[0].ends_with(": \"waits\" stands in the wrong place: it belongs to [spindle]"),
            "{told:#?}"
        );
        let told = of_post(&grbl().replace("[lines]\n", "[lines]\npause = [\"M0\"]\n"));
        assert!(
            told[0].ends_with("it belongs to the top of the file, before the first header"),
            "{told:#?}"
        );
    }

    #[test]
    fn an_unknown_table_is_told_once_and_a_key_that_is_there_twice_too() {
        let text = grbl()
            .replace("[modal]", "[xxxxxxxxxx]\nfoo = 1\nbar = \"x\"\n\n[modal]")
            .replace("[rapid]\n", "[rapid]\nmachin = [\"G53 G0 {axes}\"]\n");
        let told = of_post(&text);
        assert_eq!(told.len(), 2, "{told:#?}");
        assert!(
            told[0].contains("unknown key \"xxxxxxxxxx\"")
                || told[1].contains("unknown key \"xxxxxxxxxx\""),
            "{told:#?}"
        );
        assert!(
            told.iter()
                .any(|t| t.contains("unknown key \"machin\" (did you mean \"machine\"?)")),
            "{told:#?}"
        );
    }

    #[test]
    fn machines_too() {
        let good: Vec<&str> = machine::BUILT_IN.iter().map(|(_, t)| *t).collect();
        let text = "titel = \"Mine\"\ncontroller = \"grbl\"\ntravel_mm = [300, 200, 0]\n";
        let told: Vec<String> = complaints(text, &good, |t| {
            machine::Machine::named("mine", "mine.toml", t).map(drop)
        })
        .iter()
        .map(ToString::to_string)
        .collect();
        for what in [
            "mine.toml:1:1: unknown key \"titel\" (did you mean \"title\"?)",
            "\"post\" is missing",
            "\"max_rate_mm_per_min\" is missing",
            "\"acceleration_mm_per_s2\" is missing",
            "\"spindle_rpm\" is missing",
            "mine.toml:3:24: travel_mm = 0: ",
        ] {
            assert!(told.iter().any(|t| t.contains(what)), "{what}: {told:#?}");
        }
    }

    #[test]
    fn text_that_is_no_toml_is_told_once() {
        let told = of_post("title = \"unclosed\nunits = 3\n");
        assert_eq!(told.len(), 1, "{told:#?}");
        assert!(told[0].starts_with("mine.toml:1:"), "{told:#?}");
    }
}
