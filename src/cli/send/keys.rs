//! What a key means to a running job.

use crate::link::{Command, RapidStep, Step};
use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// A key pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    /// A wish.
    Wish(Command),
    /// Ctrl-C: the first stops in order, the second resets at once.
    Interrupt,
}

/// The wish of a key; `None` for one without a meaning, and for its release.
pub fn pressed(key: &KeyEvent) -> Option<Pressed> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    let KeyCode::Char(c) = key.code else {
        return (key.code == KeyCode::Esc).then_some(Pressed::Wish(Command::Hold));
    };
    if control {
        return (c == 'c').then_some(Pressed::Interrupt);
    }
    wish(c).map(Pressed::Wish)
}

/// The wish of a character.
pub fn wish(c: char) -> Option<Command> {
    Some(match c {
        // The biggest key is the most urgent wish.
        ' ' | 'h' | '!' => Command::Hold,
        'r' | '~' => Command::Resume,
        'x' => Command::Stop,
        'd' => Command::Door,
        '+' | '=' => Command::Feed(Step::Plus10),
        '-' => Command::Feed(Step::Minus10),
        '.' => Command::Feed(Step::Plus1),
        ',' => Command::Feed(Step::Minus1),
        '0' => Command::Feed(Step::Normal),
        '1' => Command::Rapid(RapidStep::Quarter),
        '2' => Command::Rapid(RapidStep::Half),
        '3' => Command::Rapid(RapidStep::Full),
        ']' => Command::Spindle(Step::Plus10),
        '[' => Command::Spindle(Step::Minus10),
        's' => Command::SpindleStop,
        'f' => Command::Flood,
        'm' => Command::Mist,
        _ => return None,
    })
}

/// What a line typed without a screen means.
pub fn wish_of_line(line: &str) -> Option<Command> {
    let line = line.trim_end_matches(['\r', '\n']);
    let mut chars = if line == " " {
        line.chars()
    } else {
        line.trim().chars()
    };
    match (chars.next(), chars.next()) {
        (Some(c), None) => wish(c),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_mean_what_the_help_says() {
        let key = |c| pressed(&KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE));
        assert_eq!(key(' '), Some(Pressed::Wish(Command::Hold)));
        assert_eq!(key('x'), Some(Pressed::Wish(Command::Stop)));
        assert_eq!(key('q'), None);
        let ctrl_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(pressed(&ctrl_c), Some(Pressed::Interrupt));
        let ctrl_x = KeyEvent::new(KeyCode::Char('x'), KeyModifiers::CONTROL);
        assert_eq!(pressed(&ctrl_x), None);
        assert_eq!(
            pressed(&KeyEvent::new_with_kind(
                KeyCode::Char('r'),
                KeyModifiers::NONE,
                KeyEventKind::Release
            )),
            None
        );
        // Every key of the help line does something.
        for word in super::super::board::KEYS
            .join(" ")
            .split_whitespace()
            .filter(|w| w.len() == 1 && *w != "%")
        {
            assert!(word.chars().all(|c| wish(c).is_some()), "{word}");
        }
    }

    #[test]
    fn lines_typed_without_a_screen() {
        assert_eq!(wish_of_line(" "), Some(Command::Hold));
        assert_eq!(wish_of_line("h"), Some(Command::Hold));
        assert_eq!(wish_of_line("~\r"), Some(Command::Resume));
        assert_eq!(wish_of_line("x"), Some(Command::Stop));
        assert_eq!(wish_of_line(""), None);
        assert_eq!(wish_of_line("xx"), None);
    }
}
