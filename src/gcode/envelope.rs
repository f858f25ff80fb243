//! What stands around the words of a line: how long it may be, comments where a dialect takes them otherwise than the words' reader does,
//! checksums.
//!
//! Crosses the border: one line of text in; the part of it that holds words and plain comments out, from the same first character.

use super::error::{Complaint, Fault};
use super::rules::{LineLength, Parentheses, RuleComplaint, Rules, Semicolon};
use super::word::{MAX_COLUMN, check_comments, significant};

/// The line without its checksum, proven short enough and commented as the dialect has it.
#[inline]
pub(super) fn open<'a>(text: &'a str, rules: &Rules) -> Result<&'a str, Fault> {
    length(text, rules.length)?;
    let bytes = text.as_bytes();
    match (rules.parentheses, rules.semicolon) {
        (Parentheses::Loose, _) => {}
        (Parentheses::Strict, Semicolon::Comment) => {
            if bytes.contains(&b'(') {
                check_comments(text)?;
            }
        }
        _ => {
            if bytes.iter().any(|b| matches!(b, b'(' | b';')) {
                comments(text, rules)?;
            }
        }
    }
    match rules.checksum {
        true => checksum(text),
        false => Ok(text),
    }
}

#[inline]
fn length(text: &str, rule: LineLength) -> Result<(), Fault> {
    let (length, limit) = match rule {
        LineLength::Significant(most) if text.len() > most => (significant(text), most),
        LineLength::All(most) if text.len() > most => (text.trim_end().chars().count(), most),
        LineLength::BeforeComment(most) if text.len() > most => {
            let front = text.split(';').next().unwrap_or_default();
            (front.trim_end().len(), most)
        }
        _ => return Ok(()),
    };
    if length > limit {
        return Err(Fault::at(0, Complaint::LineTooLong { length, limit }));
    }
    Ok(())
}

fn place(offset: usize) -> u32 {
    offset.min(MAX_COLUMN) as u32
}

#[cold]
fn comments(text: &str, rules: &Rules) -> Result<(), Fault> {
    let fault = |offset, complaint: RuleComplaint| Err(Fault::at(place(offset), complaint.into()));
    let end = text.find(';').unwrap_or(text.len());
    if rules.semicolon == Semicolon::EndOfBlock {
        check_comments(text)?;
        // A `;` inside of parentheses is part of the comment.
        let (mut inside, mut over) = (false, false);
        for (i, b) in text.bytes().enumerate() {
            match b {
                _ if over && b > b' ' => return fault(i, RuleComplaint::BehindEndOfBlock),
                b'(' => inside = true,
                b')' => inside = false,
                b';' if !inside => over = true,
                _ => {}
            }
        }
        return Ok(());
    }
    let Some(open) = text.find('(').filter(|&o| o < end) else {
        return Ok(());
    };
    match rules.parentheses {
        Parentheses::No => fault(open, RuleComplaint::NoParentheses),
        Parentheses::Last => {
            let Some(close) = text.get(open..).and_then(|t| t.find(')')) else {
                return Ok(());
            };
            let behind = open + close + 1;
            let rest = text.as_bytes().get(behind..).unwrap_or_default();
            match rest.iter().position(|&b| b > b' ') {
                Some(i) if rest.get(i) != Some(&b';') => {
                    fault(behind + i, RuleComplaint::BehindComment)
                }
                _ => Ok(()),
            }
        }
        Parentheses::Strict | Parentheses::Loose => check_comments(text),
    }
}

/// `*nn` at the end of the words: all bytes before it, combined by exclusive or (RepRap wiki, G-code, Checking).
fn checksum(text: &str) -> Result<&str, Fault> {
    let front = text.split(';').next().unwrap_or_default();
    let Some(star) = front.rfind('*') else {
        return Ok(text);
    };
    let (words, sum) = front.split_at(star);
    let digits = sum.get(1..).unwrap_or_default().trim();
    let due = words.bytes().fold(0, |sum, b| sum ^ b);
    let plain =
        !digits.is_empty() && digits.len() <= 3 && digits.bytes().all(|b| b.is_ascii_digit());
    let found = if plain {
        digits.parse().unwrap_or(-1.0)
    } else {
        -1.0
    };
    if found < 0.0 {
        let letter = '*';
        return Err(Fault::at(place(star), Complaint::BadNumber { letter }));
    }
    if found != f64::from(due) {
        let complaint = RuleComplaint::Checksum { found, due };
        return Err(Fault::at(place(star), complaint.into()));
    }
    Ok(words)
}
