//! Progress on a terminal's stderr, silence anywhere else; and the seconds each stage took.

use std::time::Instant;

/// Names the stage under way and times it.
pub struct Progress {
    bar: indicatif::ProgressBar,
    started: Instant,
    current: Option<(&'static str, Instant)>,
    /// Seconds by stage, in order.
    pub seconds: Vec<(&'static str, f64)>,
}

impl Progress {
    /// Nothing under way yet.
    pub fn new() -> Progress {
        // indicatif draws on stderr, and only on a terminal.
        let bar = indicatif::ProgressBar::new_spinner();
        bar.enable_steady_tick(std::time::Duration::from_millis(120));
        Progress {
            bar,
            started: Instant::now(),
            current: None,
            seconds: Vec::new(),
        }
    }

    /// The last stage is over, this one begins.
    pub fn stage(&mut self, name: &'static str, words: &'static str) {
        self.close();
        self.bar.set_message(words);
        self.current = Some((name, Instant::now()));
    }

    /// A line above the progress, on a terminal only.
    pub fn note(&self, line: String) {
        self.bar.println(line);
    }

    /// All stages are over.
    pub fn finish(&mut self) -> f64 {
        self.close();
        self.bar.finish_and_clear();
        self.started.elapsed().as_secs_f64()
    }

    fn close(&mut self) {
        if let Some((name, since)) = self.current.take() {
            self.seconds.push((name, since.elapsed().as_secs_f64()));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
