//! Okuma OSP: names of programs, and the statements of its user tasks, which are refused by name.
//!
//! Crosses the border: a line behind block delete and line number in; whether it is a program's name, or a fault at its byte, out. After
//! lists of OSP commands and open posts for Okuma (the maker's manual was not to be had in full): User Task 1 has GOTO, IF and variables,
//! User Task 2 CALL, MODIN, MODOUT, RTS and functions.

use crate::gcode::error::Fault;
use crate::gcode::rules::RuleComplaint;
use crate::gcode::word::MAX_COLUMN;

/// A program's name alone in its line: O and up to four letters or digits, the first a letter (`OTEST`); numbers are read elsewhere.
pub(super) fn is_name(rest: &str) -> bool {
    let name = rest.split(['(', ';']).next().unwrap_or_default().trim_end();
    let Some(name) = name.strip_prefix(['O', 'o']) else {
        return false;
    };
    (1..=4).contains(&name.len())
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.bytes().all(|b| b.is_ascii_alphanumeric())
}

/// Statements that no word-address block holds.
const STATEMENTS: [&str; 9] = [
    "CALL", "RTS", "MODIN", "MODOUT", "GOTO", "IF", "PUT", "WRITE", "READ",
];

/// Refuses user tasks by name: `at` is where `rest` begins in its line.
pub(super) fn check(rest: &str, at: usize) -> Result<(), Fault> {
    let fault = |offset: usize, name: &str| {
        let name = name.to_ascii_uppercase().into();
        let complaint = RuleComplaint::UserTask { name };
        Err(Fault::at(offset.min(MAX_COLUMN) as u32, complaint.into()))
    };
    let run = |text: &str| {
        let end = text.find(|c: char| !c.is_ascii_alphanumeric());
        text.get(..end.unwrap_or(text.len()))
            .unwrap_or_default()
            .to_string()
    };
    let word = run(rest);
    let letters: String = word.chars().take_while(char::is_ascii_alphabetic).collect();
    if STATEMENTS.iter().any(|s| s.eq_ignore_ascii_case(&letters)) {
        return fault(at, &letters);
    }
    // A line named by letters: N, then a letter. As a block number it would have digits only.
    if let Some(name) = word.strip_prefix(['N', 'n'])
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
    {
        return fault(at, &word);
    }
    let words = rest.split(['(', ';']).next().unwrap_or_default();
    if let Some(equals) = words.find('=') {
        let before = words.get(..equals).unwrap_or_default();
        let start = before
            .trim_end()
            .rfind(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '[' | ']')))
            .map_or(0, |i| i + 1);
        let name = before.get(start..).unwrap_or_default().trim_end();
        return fault(at + start, &format!("{name}="));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gcode::error::Complaint;

    #[test]
    fn names_are_names_and_user_tasks_are_called_by_theirs() {
        for name in ["OTEST", "OA1 (COMMENT)", "oab"] {
            assert!(is_name(name), "{name}");
        }
        for other in ["O1000", "O", "OTOOLONG", "G0", "OA B", "O-A"] {
            assert!(!is_name(other), "{other}");
        }
        for (text, at, name) in [
            ("CALL O100", 3, "CALL is"),
            ("NAT01", 3, "NAT01 is"),
            ("VC1=5", 3, "VC1= is"),
            ("G0 X=VC1", 6, "X= is"),
            ("VZOFZ[1]=0", 3, "VZOFZ[1]= is"),
            ("IF[V1 EQ 2]N10", 3, "IF is"),
        ] {
            let f = check(text, 3).unwrap_err();
            assert_eq!(f.offset, at, "{text}");
            let Complaint::Rule(rule) = f.complaint else {
                panic!("{text}");
            };
            assert!(rule.to_string().starts_with(name), "{text}: {rule}");
        }
        for sound in ["G0 X1. (A=B)", "M2", "N10 G1 X1. F100.", "", "G15 H1 ; A=1"] {
            assert!(check(sound, 0).is_ok(), "{sound}");
        }
    }
}
