//! The terminal while a job runs: an alternate screen with [`super::board`]'s lines, single keys, and all of it given back at the end.
//!
//! Drawn on stderr, so that results on stdout can go to a file. Given back on every way out: when the screen is dropped, and by a
//! panic hook before the panic's own words.

use crossterm::{cursor, event, execute, queue, style, terminal};
use std::io::{IsTerminal as _, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Mutex, Once, OnceLock};
use std::time::Duration;

/// An open screen.
pub struct Screen {
    shown: Vec<String>,
}

/// What came from the keyboard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keyboard {
    /// A key.
    Key(event::KeyEvent),
    /// Nobody sits there any more: the terminal was closed.
    Gone,
}

/// Keys are read by a thread of their own: a terminal that was closed can keep its reader from ever coming back, and nobody but
/// that thread may wait for it. It reads only while a screen is open.
static KEYS: OnceLock<Mutex<Receiver<event::Event>>> = OnceLock::new();
/// A screen is open.
static OPEN: AtomicBool = AtomicBool::new(false);

fn read_keys(to: &Sender<event::Event>) {
    loop {
        if !OPEN.load(Ordering::SeqCst) {
            std::thread::sleep(Duration::from_millis(20));
            continue;
        }
        let read = match event::poll(Duration::from_millis(50)) {
            Ok(false) => continue,
            Ok(true) => event::read(),
            Err(e) => Err(e),
        };
        // The receiver hears of the end by the sender's.
        match read {
            Ok(event) if to.send(event).is_ok() => {}
            _ => return,
        }
    }
}

/// Gives the terminal back. Safe to call more than once.
fn give_back() {
    OPEN.store(false, Ordering::SeqCst);
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
        KEYS.get_or_init(|| {
            let (to, from) = channel();
            std::thread::spawn(move || read_keys(&to));
            Mutex::new(from)
        });
        OPEN.store(true, Ordering::SeqCst);
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
    pub fn key(&mut self) -> Option<Keyboard> {
        let keys = KEYS.get()?.lock().ok()?;
        loop {
            match keys.try_recv() {
                Ok(event::Event::Key(key)) => return Some(Keyboard::Key(key)),
                // Draw all of it again.
                Ok(event::Event::Resize(..)) => {
                    self.shown.clear();
                    let _ = execute!(std::io::stderr(), terminal::Clear(terminal::ClearType::All));
                }
                Ok(_) => {}
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => return Some(Keyboard::Gone),
            }
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}
