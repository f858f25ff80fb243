//! A vetted program: every line was read before the first is sent.

/// One line as it will be sent.
#[derive(Clone, Debug, PartialEq)]
pub struct JobLine {
    /// Its characters, without comments, blanks and line end.
    pub text: String,
    /// Line of the program, from 1; 0 for a line of our own.
    pub source: usize,
    /// Seconds the machine stands still at this line while the controller already says Idle (a dwell).
    pub dwell: f64,
}

impl JobLine {
    /// A line the session adds.
    pub(super) fn own(text: &str) -> JobLine {
        JobLine { text: text.to_string(), source: 0, dwell: 0.0 }
    }

    /// Bytes it takes in the controller's receive buffer, line end included.
    pub fn bytes(&self) -> usize {
        self.text.len() + 1
    }
}

/// Temporary.
pub struct Job {
    /// l
    pub lines: Vec<JobLine>,
    /// e
    pub end: Option<crate::geom::Point>,
}
