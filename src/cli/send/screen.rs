//! The terminal while a job runs: an alternate screen with [`super::board`]'s lines, single keys, and all of it given back at the end.
//!
//! Drawn on stderr, so that results on stdout can go to a file. Given back on every way out: when the screen is dropped, and by a
//! panic hook before the panic's own words.

use crossterm::{cursor, event, execute, queue, style, terminal};
use std::io::{IsTerminal as _, Write};
use std::sync::Once;
use std::time::Duration;

/// An open screen.
pub struct Screen {
    shown: Vec<String>,
}

/// Gives the terminal back. Safe to call more than once.
fn give_back() {
    let _ = execute!(
        std::io::stderr(),
        cursor::Show,
        terminal::LeaveAlternateScreen
    );
    let _ = terminal::disable_raw_mode();
}

impl Screen {
    /// Takes the terminal, if there is one to read keys from and to draw on.
    pub fn open() -> Option<Screen> {
        if !(std::io::stdin().is_terminal() && std::io::stderr().is_terminal()) {
            return None;
        }
        static HOOK: Once = Once::new();
        HOOK.call_once(|| {
            let before = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |info| {
                give_back();
                before(info);
            }));
        });
        terminal::enable_raw_mode().ok()?;
        if execute!(
            std::io::stderr(),
            terminal::EnterAlternateScreen,
            cursor::Hide
        )
        .is_err()
        {
            give_back();
            return None;
        }
        Some(Screen { shown: Vec::new() })
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        terminal::size().map_or((80, 24), |(columns, rows)| {
            (usize::from(columns).max(1), usize::from(rows).max(1))
        })
    }

    /// Shows these lines; only those that changed are written. A terminal that takes nothing does not hinder the job.
    pub fn show(&mut self, lines: Vec<String>) {
        let mut out = std::io::stderr().lock();
        let rows = lines.len().max(self.shown.len());
        for row in 0..rows {
            let line = lines.get(row);
            if self.shown.get(row) == line {
                continue;
            }
            let Ok(at) = u16::try_from(row) else { break };
            let _ = queue!(
                out,
                cursor::MoveTo(0, at),
                terminal::Clear(terminal::ClearType::CurrentLine),
                style::Print(line.map_or("", String::as_str))
            );
        }
        let _ = out.flush();
        self.shown = lines;
    }

    /// The next key, without waiting.
    pub fn key(&mut self) -> Option<event::KeyEvent> {
        while event::poll(Duration::ZERO).unwrap_or(false) {
            match event::read() {
                Ok(event::Event::Key(key)) => return Some(key),
                // Draw all of it again.
                Ok(event::Event::Resize(..)) => {
                    self.shown.clear();
                    let _ = execute!(std::io::stderr(), terminal::Clear(terminal::ClearType::All));
                }
                Ok(_) => {}
                Err(_) => return None,
            }
        }
        None
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}
