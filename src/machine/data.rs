//! Reading data files (machines, dialects) with complaints a machinist can act on.
//!
//! Crosses the border: TOML text in, a checked value or a [`DataError`] with file, line and column out. Knows nothing of what
//! the figures mean; whoever owns a format passes the bounds.

use serde::de::DeserializeOwned;
use toml::Spanned;

/// A place in a data file; line and column count from 1, the column in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it, or `machines/NAME.toml` and the like for a built-in one.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Why a data file was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DataError {
    /// Not TOML, or a value of the wrong kind.
    #[error("{at}: {message}")]
    Syntax {
        /// Where.
        at: Place,
        /// What is wrong, in the reader's words.
        message: String,
    },
    /// A key this format does not have.
    #[error("{at}: unknown key \"{key}\"{}; the keys here are {}", did_you_mean(.nearest), .known.join(", "))]
    UnknownKey {
        /// Where.
        at: Place,
        /// The key as written.
        key: String,
        /// The closest known key, when one is close.
        nearest: Option<String>,
        /// All keys of this table.
        known: Vec<String>,
    },
    /// A key that must be there is not.
    #[error("{at}: \"{key}\" is missing: add it (the files in {folder}/ show how)")]
    Missing {
        /// The table it is missing from.
        at: Place,
        /// The key.
        key: String,
        /// Folder with examples.
        folder: String,
    },
    /// A value that cannot be right.
    #[error("{at}: {key} = {value}: {problem}")]
    Value {
        /// Where.
        at: Place,
        /// The key.
        key: String,
        /// The value as read.
        value: String,
        /// What is wrong and what to do.
        problem: String,
    },
    /// Neither the name of a built-in file nor a path.
    #[error("{kind} \"{name}\" is not known{}; there are {}; a file of your own is named by its path, e.g. ./{name}.toml",
            did_you_mean(.nearest), .known.join(", "))]
    UnknownName {
        /// "machine" or "post".
        kind: String,
        /// The name as given.
        name: String,
        /// The closest known name, when one is close.
        nearest: Option<String>,
        /// All built-in names.
        known: Vec<String>,
    },
    /// A file that could not be read.
    #[error("{path}: cannot be read as a {kind}: {problem}")]
    Unreadable {
        /// "machine" or "post".
        kind: String,
        /// The path as given.
        path: String,
        /// Why, and what to do.
        problem: String,
    },
    /// More than one complaint about the same file, in reading order.
    #[error("{}", .0.iter().map(|e| e.to_string()).collect::<Vec<_>>().join("\n"))]
    Several(Vec<DataError>),
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|n| format!(" (did you mean \"{n}\"?)"))
        .unwrap_or_default()
}

/// A data file being read: its name for complaints, its text, and the complaints so far.
pub struct Reader<'a> {
    /// File name for complaints.
    pub file: String,
    /// The whole text.
    pub text: &'a str,
    /// Folder with good examples, for complaints.
    pub folder: &'static str,
    /// Complaints so far, in the order they were made.
    pub complaints: Vec<DataError>,
}

/// The numbers a figure may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
    /// True when `min` itself is refused (a rate of zero).
    pub above_min: bool,
}

impl<'a> Reader<'a> {
    /// A reader of `text`, which complaints will call `file`; `folder` is where good examples lie.
    pub fn new(file: impl Into<String>, text: &'a str, folder: &'static str) -> Self {
        Reader {
            file: file.into(),
            text,
            folder,
            complaints: Vec::new(),
        }
    }

    /// The place of a byte offset of the text; an offset past the end is the end.
    pub fn place(&self, byte: usize) -> Place {
        let mut end = byte.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &self.text[..end];
        let start_of_line = before.rfind('\n').map_or(0, |i| i + 1);
        Place {
            file: self.file.clone(),
            line: before.matches('\n').count() + 1,
            column: before[start_of_line..].chars().count() + 1,
        }
    }

    /// The text as `T`. The error of an unknown key names the closest known one.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, DataError> {
        if self.text.len() > MOST_BYTES {
            return Err(DataError::Syntax {
                at: self.place(0),
                message: format!(
                    "it has {} bytes, and such a file is a page of text: is this the right file?",
                    self.text.len()
                ),
            });
        }
        toml::from_str(self.text).map_err(|e| self.explain(&e))
    }

    /// serde's words turned into ours. They are matched by their back-quotes; words we do not know are passed on as they are.
    fn explain(&self, e: &toml::de::Error) -> DataError {
        let at = self.place(e.span().map_or(0, |s| s.start));
        let message = e.message();
        let quoted: Vec<String> = message
            .split('`')
            .skip(1)
            .step_by(2)
            .map(str::to_string)
            .collect();
        match quoted.split_first() {
            Some((key, known)) if message.starts_with("unknown field") => DataError::UnknownKey {
                at,
                key: shortened(key, LONGEST_SHOWN),
                nearest: nearest(key, known.iter().map(String::as_str)),
                known: known.to_vec(),
            },
            Some((key, _)) if message.starts_with("missing field") => DataError::Missing {
                at,
                key: key.clone(),
                folder: self.folder.to_string(),
            },
            _ => {
                let line = self.text.lines().nth(at.line.saturating_sub(1));
                let line = shortened(line.unwrap_or_default(), 20 * LONGEST_SHOWN);
                let message = super::plain::plain(message, &line, at.column);
                DataError::Syntax {
                    at,
                    message: shortened(&message, 10 * LONGEST_SHOWN),
                }
            }
        }
    }

    /// Notes a complaint about a value.
    pub fn complain<T>(
        &mut self,
        key: &str,
        value: &Spanned<T>,
        shown: String,
        problem: impl Into<String>,
    ) {
        let e = DataError::Value {
            at: self.place(value.span().start),
            key: key.to_string(),
            value: shortened(&shown, LONGEST_SHOWN),
            problem: problem.into(),
        };
        self.complaints.push(e);
    }

    /// Notes a complaint when a figure lies outside its bounds; `advice` says what to do. Returns the figure either way.
    pub fn figure(
        &mut self,
        key: &str,
        value: &Spanned<f64>,
        bounds: Bounds,
        unit: &str,
        advice: &str,
    ) -> f64 {
        let v = *value.get_ref();
        let low = v < bounds.min || (bounds.above_min && v == bounds.min);
        if !v.is_finite() || low || v > bounds.max {
            let relation = if bounds.above_min {
                "above"
            } else {
                "at least"
            };
            let unit = if unit.is_empty() {
                String::new()
            } else {
                format!(" {unit}")
            };
            let problem = format!(
                "must be {relation} {} and at most {}{unit}: {advice}",
                bounds.min, bounds.max
            );
            self.complain(key, value, format!("{v}"), problem);
        }
        v
    }

    /// Notes a complaint when a word is not one of `known`. Returns the word either way.
    pub fn word(&mut self, key: &str, value: &Spanned<String>, known: &[&str]) -> String {
        let v = value.get_ref();
        if !known.contains(&v.as_str()) {
            let near = did_you_mean(&nearest(v, known.iter().copied()));
            let problem = format!("must be one of {}{near}", known.join(", "));
            self.complain(key, value, format!("\"{v}\""), problem);
        }
        v.clone()
    }

    /// The value, unless there were complaints.
    pub fn finish<T>(mut self, value: T) -> Result<T, DataError> {
        match self.complaints.len() {
            0 => Ok(value),
            1 => Err(self.complaints.remove(0)),
            _ => Err(DataError::Several(self.complaints)),
        }
    }
}

/// Bytes of a data file: no machine and no dialect needs more; a wrong file (a part, a program) often has.
pub const MOST_BYTES: usize = 1 << 16;

/// Characters of a key or a value that a complaint repeats.
const LONGEST_SHOWN: usize = 80;

/// The front of a text that is too long to repeat.
fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or_default()),
        None => text.to_string(),
    }
}

/// The text and name behind `name_or_path`: a file when it contains a `/` or ends in `.toml`; else `NAME.toml` in the user's own
/// directories ([`super::search`]), else one of `built_in` (name, text). Returns the short name, the name for complaints, and the text.
pub fn find(
    kind: &str,
    folder: &str,
    built_in: &[(&str, &str)],
    name_or_path: &str,
) -> Result<(String, String, String), DataError> {
    super::search::find_in(
        super::search::directories(folder),
        kind,
        folder,
        built_in,
        name_or_path,
    )
}

/// The word of `known` closest to `word`, when it is close enough to be a slip of the pen; the first of equals.
pub fn nearest<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<String> {
    // What is that long is no slip, and would take its time.
    if word.len() > 200 {
        return None;
    }
    let word = word.to_lowercase();
    let mut best: Option<(usize, &str)> = None;
    for k in known {
        let lower = k.to_lowercase();
        // Letters that changed places ("xz" for "zx") are the likeliest slip.
        let d = 2 * edits(&word, &lower) - usize::from(swapped(&word, &lower));
        // A forgotten suffix ("travel" for "travel_mm") counts as a slip too.
        let close = d / 2 <= 1 + word.chars().count().max(k.chars().count()) / 3
            || (!word.is_empty() && lower.starts_with(&word));
        if close && best.is_none_or(|(b, _)| d < b) {
            best = Some((d, k));
        }
    }
    best.map(|(_, k)| k.to_string())
}

/// True for two words of the same letters in another order.
fn swapped(a: &str, b: &str) -> bool {
    let sorted = |t: &str| {
        let mut letters: Vec<char> = t.chars().collect();
        letters.sort_unstable();
        letters
    };
    a != b && a.len() == b.len() && sorted(a) == sorted(b)
}

/// Levenshtein distance: insertions, deletions and replacements of one character from `a` to `b`.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replace = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn enormous_texts_are_not_repeated() {
        #[derive(serde::Deserialize, Debug)]
        #[serde(deny_unknown_fields)]
        struct Empty {}
        let text = format!("{} = 1\n", "ab".repeat(10_000));
        let e = Reader::new("f", &text, "machines")
            .parse::<Empty>()
            .unwrap_err()
            .to_string();
        assert!(e.starts_with("f:1:1: ") && e.len() < 1_500, "{e}");
        let text = "# ".repeat(MOST_BYTES);
        let e = Reader::new("f", &text, "machines")
            .parse::<Empty>()
            .unwrap_err()
            .to_string();
        assert_eq!(
            e,
            "f:1:1: it has 131072 bytes, and such a file is a page of text: is this the right file?"
        );
    }

    #[test]
    fn counts_edits() {
        for (a, b, d) in [
            ("", "", 0),
            ("abc", "abc", 0),
            ("", "abc", 3),
            ("kitten", "sitting", 3),
            ("a", "b", 1),
        ] {
            assert_eq!(edits(a, b), d);
            assert_eq!(edits(b, a), d);
        }
    }

    #[test]
    fn nearest_is_close_or_nothing() {
        assert_eq!(nearest("bawd", ["baud", "post"]), Some("baud".to_string()));
        assert_eq!(
            nearest("travel", ["title", "travel_mm"]),
            Some("travel_mm".to_string())
        );
        assert_eq!(
            nearest("longmil", ["nomad-3", "longmill-30x30"]),
            Some("longmill-30x30".to_string()),
            "one that is nearer and yet no slip is passed over"
        );
        assert_eq!(nearest("zzzzzzzz", ["baud", "post"]), None);
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn places_count_from_one_in_characters() {
        let r = Reader::new("f", "a\n\u{b5}b = 1\n", "machines");
        assert_eq!(
            r.place(0),
            Place {
                file: "f".into(),
                line: 1,
                column: 1
            }
        );
        assert_eq!(
            r.place(2),
            Place {
                file: "f".into(),
                line: 2,
                column: 1
            }
        );
        assert_eq!(r.place(3).column, 1, "inside a character is at its start");
        assert_eq!(
            r.place(4),
            Place {
                file: "f".into(),
                line: 2,
                column: 2
            }
        );
        assert_eq!(r.place(999).line, 3);
    }

    #[test]
    fn a_path_that_is_no_good_says_why() {
        let e = find("machine", "machines", &[], "no/such/file.toml")
            .unwrap_err()
            .to_string();
        assert!(
            e.starts_with("no/such/file.toml: cannot be read as a machine: "),
            "{e}"
        );
        let dir = tempfile::tempdir().unwrap();
        let e = find("machine", "machines", &[], dir.path().to_str().unwrap()).unwrap_err();
        assert!(e.to_string().contains("it is not a file"), "{e}");
        let png = dir.path().join("x.toml");
        std::fs::write(&png, [0x89, 0x50, 0xff, 0xfe]).unwrap();
        let e = find("machine", "machines", &[], png.to_str().unwrap()).unwrap_err();
        assert!(e.to_string().contains("it is not text"), "{e}");
    }
}
