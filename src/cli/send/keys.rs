//! What a key means: to a running job, or to a machine in the operator's hands; and what a typed line means.

use crate::link::{Command, RapidStep, Step};
use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// A key pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    /// A wish.
    Wish(Command),
    /// Ctrl-C.
    Interrupt,
}

/// True for Ctrl-C.
pub fn interrupts(key: &KeyEvent) -> bool {
    key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c')
}

/// The wish of a key while a job runs; `None` for one without a meaning, and for its release.
pub fn pressed(key: &KeyEvent) -> Option<Pressed> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    if interrupts(key) {
        return Some(Pressed::Interrupt);
    }
    match key.code {
        KeyCode::Esc => Some(Pressed::Wish(Command::Hold)),
        KeyCode::Char(c) if !key.modifiers.contains(KeyModifiers::CONTROL) => {
            wish(c).map(Pressed::Wish)
        }
        _ => None,
    }
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

/// Words that a script may write for them.
const WORDS: [(&str, char); 17] = [
    ("hold", 'h'),
    ("resume", 'r'),
    ("stop", 'x'),
    ("door", 'd'),
    ("feed+10", '+'),
    ("feed-10", '-'),
    ("feed+1", '.'),
    ("feed-1", ','),
    ("feed=100", '0'),
    ("rapid=25", '1'),
    ("rapid=50", '2'),
    ("rapid=100", '3'),
    ("spindle+10", ']'),
    ("spindle-10", '['),
    ("spindle-stop", 's'),
    ("flood", 'f'),
    ("mist", 'm'),
];

/// What a line typed without a screen means; `Err` names what it may be.
pub fn wish_of_line(line: &str) -> Result<Option<Command>, String> {
    let line = line.trim_end_matches(['\r', '\n']);
    if line == " " {
        return Ok(wish(' '));
    }
    let text = line.trim().to_ascii_lowercase();
    let mut chars = text.chars();
    match (chars.next(), chars.next()) {
        (None, _) => return Ok(None),
        (Some(c), None) if wish(c).is_some() => return Ok(wish(c)),
        _ => {}
    }
    match WORDS.iter().find(|(word, _)| *word == text) {
        Some((_, c)) => Ok(wish(*c)),
        None => {
            let shown: String = text.chars().take(40).collect();
            let words: Vec<&str> = WORDS.iter().map(|(word, _)| *word).collect();
            Err(format!(
                "`{shown}` is no command: write {}",
                words.join(", ")
            ))
        }
    }
}

/// What a key means while the machine is in the operator's hands: before the start, and at a tool change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// Jog along an axis, up or down.
    Jog {
        /// 0 to 2.
        axis: usize,
        /// Towards plus.
        plus: bool,
    },
    /// A smaller jog step.
    Finer,
    /// A larger one.
    Coarser,
    /// Work zero of an axis here.
    Zero(usize),
    /// Home.
    Home,
    /// Measure the tool.
    Measure,
    /// Yes.
    Yes,
    /// Begin, or go on.
    GoOn,
    /// End the job.
    Stop,
    /// Stop what moves.
    Halt,
    /// Ctrl-C.
    Interrupt,
    /// No meaning: says no to a question, and stops a jog.
    Other,
}

/// The meaning of a key; `None` for its release.
pub fn hand(key: &KeyEvent) -> Option<Hand> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    if interrupts(key) {
        return Some(Hand::Interrupt);
    }
    let jog = |axis, plus| Hand::Jog { axis, plus };
    Some(match key.code {
        KeyCode::Left => jog(0, false),
        KeyCode::Right => jog(0, true),
        KeyCode::Down => jog(1, false),
        KeyCode::Up => jog(1, true),
        KeyCode::PageDown => jog(2, false),
        KeyCode::PageUp => jog(2, true),
        KeyCode::Esc | KeyCode::Char(' ') => Hand::Halt,
        KeyCode::Char(c) if !key.modifiers.contains(KeyModifiers::CONTROL) => match c {
            ',' | '<' => Hand::Finer,
            '.' | '>' => Hand::Coarser,
            'X' => Hand::Zero(0),
            'Y' => Hand::Zero(1),
            'Z' => Hand::Zero(2),
            'H' => Hand::Home,
            'p' => Hand::Measure,
            'y' => Hand::Yes,
            'r' => Hand::GoOn,
            'x' => Hand::Stop,
            _ => Hand::Other,
        },
        _ => Hand::Other,
    })
}

/// Sizes of a jog step, mm.
pub const STEPS: [f64; 5] = [0.01, 0.1, 1.0, 10.0, 50.0];
/// The largest along Z, mm.
pub const LARGEST_Z: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::super::board::{HAND_KEYS, KEYS};
    use super::*;

    #[test]
    fn keys_mean_what_the_help_says() {
        let key = |c| pressed(&KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE));
        assert_eq!(key(' '), Some(Pressed::Wish(Command::Hold)));
        assert_eq!(key('x'), Some(Pressed::Wish(Command::Stop)));
        assert_eq!(key('q'), None);
        let ctrl_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(pressed(&ctrl_c), Some(Pressed::Interrupt));
        assert_eq!(hand(&ctrl_c), Some(Hand::Interrupt));
        let ctrl_x = KeyEvent::new(KeyCode::Char('x'), KeyModifiers::CONTROL);
        assert_eq!(pressed(&ctrl_x), None);
        assert_eq!(hand(&ctrl_x), Some(Hand::Other));
        let release = KeyEvent::new_with_kind(
            KeyCode::Char('r'),
            KeyModifiers::NONE,
            KeyEventKind::Release,
        );
        assert_eq!(pressed(&release), None);
        assert_eq!(hand(&release), None);
        // Every key of the help line does something.
        let single = |lines: &[&str]| -> Vec<char> {
            let text = lines.join(" ");
            let words = text.split_whitespace().filter(|w| *w != "%");
            words
                .filter(|w| w.chars().count() == 1)
                .filter_map(|w| w.chars().next())
                .collect()
        };
        for c in single(&KEYS) {
            assert!(wish(c).is_some(), "{c}");
        }
        for c in single(&HAND_KEYS) {
            let key = KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE);
            assert_ne!(hand(&key), Some(Hand::Other), "{c}");
        }
    }

    #[test]
    fn lines_typed_without_a_screen() {
        assert_eq!(wish_of_line(" "), Ok(Some(Command::Hold)));
        assert_eq!(wish_of_line("h"), Ok(Some(Command::Hold)));
        assert_eq!(wish_of_line("~\r"), Ok(Some(Command::Resume)));
        assert_eq!(wish_of_line("x"), Ok(Some(Command::Stop)));
        assert_eq!(wish_of_line("Resume\n"), Ok(Some(Command::Resume)));
        assert_eq!(
            wish_of_line("feed+10"),
            Ok(Some(Command::Feed(Step::Plus10)))
        );
        assert_eq!(wish_of_line(""), Ok(None));
        assert_eq!(
            wish_of_line("xx"),
            Err("`xx` is no command: write hold, resume, stop, door, feed+10, feed-10, feed+1, feed-1, feed=100, rapid=25, rapid=50, rapid=100, spindle+10, spindle-10, spindle-stop, flood, mist".to_string())
        );
    }
}
