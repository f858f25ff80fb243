//! Comments a machine will swallow: free text made harmless for a dialect, and split into lines short enough for it.

/// How a dialect writes comments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommentStyle {
    /// `(text)`
    Parentheses,
    /// `; text`
    Semicolon,
    /// Not at all: comments are left out.
    None,
}

/// The rules of a dialect's comments.
#[derive(Clone, Debug, PartialEq)]
pub struct Comments {
    /// How they are written.
    pub style: CommentStyle,
    /// Capitals only.
    pub upper_case: bool,
    /// Characters that must not occur even inside a comment; they become `_`.
    pub forbidden: String,
    /// Words that would make a comment act (LinuxCNC's `(MSG, ...)`) when they begin it.
    pub active: Vec<String>,
}

impl Comments {
    /// `text` as comment lines of at most `longest` characters, marks included; none for the style [`CommentStyle::None`]. Other
    /// letters become their ASCII neighbours, parentheses become brackets, and what has no neighbour becomes `_`.
    pub fn lines(&self, text: &str, longest: usize) -> Vec<String> {
        let (before, after) = match self.style {
            CommentStyle::Parentheses => ("(", ")"),
            CommentStyle::Semicolon => ("; ", ""),
            CommentStyle::None => return Vec::new(),
        };
        // Room for two characters of guard before a word that would act.
        let room = longest
            .saturating_sub(before.len() + after.len() + 2)
            .max(1);
        let mut lines = Vec::new();
        for source in text.lines() {
            let clean = self.clean(source);
            for line in wrap(clean.trim(), room) {
                let guard = if self.acts(&line) { "- " } else { "" };
                lines.push(format!("{before}{guard}{line}{after}"));
            }
        }
        lines
    }

    /// The same text, harmless.
    fn clean(&self, text: &str) -> String {
        let mut out = String::with_capacity(text.len());
        for c in text.chars() {
            let start = out.len();
            push_ascii(&mut out, c);
            if out[start..].contains(|c| self.forbidden.contains(c)) {
                out.truncate(start);
                out.push('_');
            }
        }
        if self.upper_case {
            out.to_ascii_uppercase()
        } else {
            out
        }
    }

    /// True when the comment would be taken for a command: one of the active words, then a comma or the end.
    fn acts(&self, line: &str) -> bool {
        let first = line.split(',').next().unwrap_or_default().trim();
        self.active.iter().any(|w| w.eq_ignore_ascii_case(first))
    }
}

/// The nearest ASCII text to a character.
fn push_ascii(out: &mut String, c: char) {
    let text = match c {
        '(' | '{' => "[",
        ')' | '}' => "]",
        ' '..='~' => return out.push(c),
        '\u{b5}' | '\u{3bc}' => "u",
        '\u{b0}' => "deg",
        '\u{d7}' => "x",
        '\u{b1}' => "+/-",
        '\u{b2}' => "2",
        '\u{b3}' => "3",
        '\u{2264}' => "<=",
        '\u{2265}' => ">=",
        '\u{2010}'..='\u{2015}' | '\u{2212}' => "-",
        '\u{2018}' | '\u{2019}' => "'",
        '\u{201c}' | '\u{201d}' => "\"",
        '\u{2026}' => "...",
        '\u{c4}' => "Ae",
        '\u{d6}' | '\u{d8}' => "Oe",
        '\u{dc}' => "Ue",
        '\u{e4}' | '\u{e6}' => "ae",
        '\u{f6}' | '\u{f8}' => "oe",
        '\u{fc}' => "ue",
        '\u{df}' => "ss",
        '\u{c0}'..='\u{c3}' | '\u{c5}' => "A",
        '\u{e0}'..='\u{e3}' | '\u{e5}' => "a",
        '\u{c7}' => "C",
        '\u{e7}' => "c",
        '\u{c8}'..='\u{cb}' => "E",
        '\u{e8}'..='\u{eb}' => "e",
        '\u{cc}'..='\u{cf}' => "I",
        '\u{ec}'..='\u{ef}' => "i",
        '\u{d1}' => "N",
        '\u{f1}' => "n",
        '\u{d2}'..='\u{d5}' => "O",
        '\u{f2}'..='\u{f5}' => "o",
        '\u{d9}'..='\u{db}' => "U",
        '\u{f9}'..='\u{fb}' => "u",
        c if c.is_whitespace() || c.is_control() => " ",
        _ => "_",
    };
    out.push_str(text);
}

/// ASCII text in lines of at most `room` characters, broken at spaces where there are any.
fn wrap(text: &str, room: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut rest = text;
    while rest.len() > room {
        let cut = match rest.as_bytes()[..=room].iter().rposition(|b| *b == b' ') {
            Some(space) if space > 0 => space,
            _ => room,
        };
        lines.push(rest[..cut].trim_end().to_string());
        rest = rest[cut..].trim_start();
    }
    if !rest.is_empty() {
        lines.push(rest.to_string());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grbl() -> Comments {
        Comments {
            style: CommentStyle::Parentheses,
            upper_case: false,
            forbidden: "?!~".into(),
            active: vec!["MSG".into()],
        }
    }

    #[test]
    fn makes_text_harmless() {
        for (text, line) in [
            ("part (left) {a}", "(part [left] [a])"),
            (
                "cusp \u{2264} 20 \u{b5}m \u{b1}1\u{b0}",
                "(cusp <= 20 um +/-1deg)",
            ),
            ("why? now! ~5", "(why_ now_ _5)"),
            ("G\u{fc}te \u{4e2d}", "(Guete _)"),
            ("a\tb\u{7f}", "(a b)"),
            ("MSG, hello", "(- MSG, hello)"),
            ("msg", "(- msg)"),
            ("MSGX, hello", "(MSGX, hello)"),
        ] {
            assert_eq!(grbl().lines(text, 70), [line]);
        }
        assert!(grbl().lines(" \n ", 70).is_empty());
        let c = Comments {
            style: CommentStyle::Semicolon,
            upper_case: true,
            ..grbl()
        };
        assert_eq!(c.lines("two\nlines", 70), ["; TWO", "; LINES"]);
        let c = Comments {
            style: CommentStyle::None,
            ..grbl()
        };
        assert!(c.lines("two\nlines", 70).is_empty());
    }

    #[test]
    fn long_text_breaks_at_spaces() {
        assert_eq!(
            grbl().lines("one two three four", 14),
            ["(one two)", "(three four)"]
        );
        assert_eq!(
            grbl().lines("abcdefghijkl", 9),
            ["(abcde)", "(fghij)", "(kl)"]
        );
    }

    proptest! {
        #[test]
        fn any_text_is_safe(text in any::<String>(), longest in 8_usize..90) {
            for line in grbl().lines(&text, longest) {
                prop_assert!(line.len() <= longest);
                prop_assert!(line.starts_with('(') && line.ends_with(')'));
                let inner = &line[1..line.len() - 1];
                prop_assert!(inner.chars().all(|c| (' '..='~').contains(&c) && !"()?!~".contains(c)), "{}", line);
            }
        }
    }
}
