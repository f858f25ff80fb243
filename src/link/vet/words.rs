//! A line as the firmware keeps it: no blanks, no comments, upper case; and its words, for the few questions that the interpreter
//! does not answer.

/// What is left of a line, and what must not be sent of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Significant {
    /// Upper case, without blanks and comments.
    pub text: String,
    /// First character that would act as a real-time command, with its column from 1.
    pub realtime: Option<(usize, char)>,
    /// Column of the first slash.
    pub slash: Option<usize>,
    /// Column of the first character kept.
    pub column: usize,
    /// The comments, joined.
    pub comment: Option<String>,
}

/// What GRBL keeps of a line. Comments do not nest; one that is not closed reaches to the end.
pub(super) fn significant(line: &str) -> Significant {
    let mut out = Significant::default();
    let mut comment = String::new();
    // Between parentheses, or behind a semicolon.
    let (mut inside, mut behind) = (false, false);
    for (column, c) in (1..).zip(line.chars()) {
        match c {
            _ if behind => comment.push(c),
            ')' if inside => {
                inside = false;
                comment.push(' ');
            }
            _ if inside => comment.push(c),
            '(' => inside = true,
            ';' => behind = true,
            c if c <= ' ' => {}
            c => {
                if out.text.is_empty() {
                    out.column = column;
                }
                if matches!(c, '?' | '!' | '~') || !c.is_ascii() {
                    out.realtime.get_or_insert((column, c));
                }
                if c == '/' {
                    out.slash.get_or_insert(column);
                }
                out.text.push(c.to_ascii_uppercase());
            }
        }
    }
    out.column = out.column.max(1);
    let comment: Vec<&str> = comment.split_whitespace().collect();
    if !comment.is_empty() {
        let mut text = comment.join(" ");
        text.retain(|c| !c.is_control());
        if let Some((end, _)) = text.char_indices().nth(MOST_COMMENT) {
            text.truncate(end);
        }
        out.comment = Some(text);
    }
    out
}

/// Characters of a comment kept for a prompt.
const MOST_COMMENT: usize = 200;

/// The words of a significant text that read as such.
pub(super) fn words(text: &str) -> impl Iterator<Item = (char, f64)> + '_ {
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            let letter = rest.chars().next()?;
            rest = rest.get(letter.len_utf8()..)?;
            if !letter.is_ascii_alphabetic() {
                continue;
            }
            let end = rest
                .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+')))
                .unwrap_or(rest.len());
            let (number, after) = rest.split_at(end);
            rest = after;
            if let Ok(value) = number.parse() {
                return Some((letter, value));
            }
        }
    })
}

/// True for the code `letter` `number`, compared as the firmware does: to a hundredth.
pub(super) fn is(word: (char, f64), letter: char, number: f64) -> bool {
    word.0 == letter && (word.1 - number).abs() < 5e-3
}

/// Column of the word `letter` `number` in the line as written; 1 if it is not found (inside of blanks or comments).
pub(super) fn column_of(line: &str, letter: char, number: f64) -> usize {
    let (mut inside, mut column) = (false, 0);
    let mut chars = line.chars();
    while let Some(c) = chars.next() {
        column += 1;
        match c {
            ')' => inside = false,
            _ if inside => {}
            '(' => inside = true,
            ';' => break,
            c if c.eq_ignore_ascii_case(&letter) => {
                let digits: String = chars
                    .as_str()
                    .chars()
                    .filter(|c| *c > ' ')
                    .take_while(|c| c.is_ascii_digit() || *c == '.')
                    .collect();
                if digits
                    .parse::<f64>()
                    .is_ok_and(|v| (v - number).abs() < 5e-3)
                {
                    return column;
                }
            }
            _ => {}
        }
    }
    1
}
