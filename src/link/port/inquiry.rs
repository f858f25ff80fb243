//! One gentle question: is there a controller of GRBL's family at the other end, and which?
//!
//! A value without I/O or clock: bytes and seconds since the port was opened go in, bytes to write come out. It listens for the greeting
//! first, because opening most boards restarts them and a boot loader would swallow what is said meanwhile; then it spoils a line that
//! may stand half-written and asks for a report; a machine at rest is asked for its version. It never resets (0x18) and never resumes:
//! whatever runs there goes on running.

use crate::wire::{Lines, Realtime, Reply, State};

/// How long the greeting may take, s: a boot loader runs first.
pub const WELCOME_WAIT: f64 = 2.5;
/// How long an answer may take, s.
const ANSWER_WAIT: f64 = 1.0;

/// What has been found out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Its greeting, e.g. `Grbl 1.1h`.
    pub greeting: Option<String>,
    /// `[VER:...]`, if it was asked.
    pub version: Option<String>,
    /// State of the machine, if it reported one.
    pub state: Option<State>,
    /// Something came, whatever it was.
    pub spoke: bool,
}

impl Found {
    /// It speaks GRBL's language.
    pub fn is_grbl(&self) -> bool {
        self.greeting.is_some() || self.version.is_some() || self.state.is_some()
    }
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut words: Vec<String> = Vec::new();
        words.extend(self.greeting.clone());
        words.extend(self.version.as_ref().map(|v| format!("version {v}")));
        words.extend(self.state.as_ref().map(|s| s.text().to_string()));
        match (words.is_empty(), self.spoke) {
            (false, _) => f.write_str(&words.join(", ")),
            (true, true) => f.write_str(
                "something answers, but not in GRBL's language: another device, or another baud rate",
            ),
            (true, false) => f.write_str("no answer"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Greeting,
    /// Asked for a report; `again` when only the version is missing.
    Report,
    Version,
    Done,
}

/// The question being asked.
#[derive(Clone, Debug)]
pub struct Inquiry {
    phase: Phase,
    until: f64,
    lines: Lines,
    found: Found,
    out: Vec<u8>,
}

impl Default for Inquiry {
    fn default() -> Self {
        Inquiry {
            phase: Phase::Greeting,
            until: WELCOME_WAIT,
            lines: Lines::default(),
            found: Found::default(),
            out: Vec::new(),
        }
    }
}

impl Inquiry {
    /// Bytes that came, `now` seconds after opening.
    pub fn receive(&mut self, bytes: &[u8], now: f64) {
        self.found.spoke |= !bytes.is_empty();
        for line in self.lines.feed(bytes) {
            match Reply::parse(&line) {
                Reply::Welcome {
                    firmware, version, ..
                } => {
                    self.found.greeting = Some(format!("{firmware} {version}"));
                    if self.phase == Phase::Greeting {
                        self.ask_report(now);
                    }
                }
                Reply::Status(status) => {
                    let at_rest = matches!(status.state, State::Idle | State::Alarm);
                    self.found.state = Some(status.state);
                    if self.phase == Phase::Report {
                        // Only a machine at rest is asked for more.
                        if at_rest {
                            self.out.extend_from_slice(b"$I\n");
                            (self.phase, self.until) = (Phase::Version, now + ANSWER_WAIT);
                        } else {
                            self.phase = Phase::Done;
                        }
                    }
                }
                Reply::Version(version) => {
                    self.found.version = Some(version.trim_end_matches(':').to_string());
                }
                // The answer to the lone `$` came before; this is the one to `$I`.
                Reply::Ok | Reply::Error(_)
                    if self.phase == Phase::Version && self.found.version.is_some() =>
                {
                    self.phase = Phase::Done;
                }
                _ => {}
            }
        }
    }

    /// Lets time pass: `now` seconds after opening.
    pub fn tick(&mut self, now: f64) {
        if now < self.until {
            return;
        }
        match self.phase {
            Phase::Greeting => {
                // Whatever stands half-written in its line buffer becomes a line that is refused; alone it asks for help.
                self.out.extend_from_slice(b"$\n");
                self.ask_report(now);
            }
            Phase::Report | Phase::Version => self.phase = Phase::Done,
            Phase::Done => {}
        }
    }

    fn ask_report(&mut self, now: f64) {
        self.out.push(Realtime::Status.byte());
        (self.phase, self.until) = (Phase::Report, now + ANSWER_WAIT);
    }

    /// Bytes to write now.
    pub fn output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// What was found out, once nothing more is to be waited for.
    pub fn finished(&self) -> Option<&Found> {
        (self.phase == Phase::Done).then_some(&self.found)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    /// Asks until it is done; `answer` is the far side. Returns what was found, the seconds it took, and all bytes written.
    fn ask(mut answer: impl FnMut(&[u8], f64) -> Vec<u8>) -> (Found, f64, Vec<u8>) {
        let (mut inquiry, mut now, mut written) = (Inquiry::default(), 0.0, Vec::new());
        loop {
            let out = inquiry.output();
            written.extend_from_slice(&out);
            inquiry.receive(&answer(&out, now), now);
            inquiry.tick(now);
            if let Some(found) = inquiry.finished() {
                return (found.clone(), now, written);
            }
            now += 0.01;
            assert!(now < 10.0, "it never ends");
        }
    }

    #[test]
    fn a_board_that_greets_is_asked_at_once() {
        let (found, time, written) = ask(|asked, now| match asked {
            _ if (now - 1.5).abs() < 0.005 => b"\r\nGrbl 1.1h ['$' for help]\r\n".to_vec(),
            b"?" => b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n".to_vec(),
            b"$I\n" => b"[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\nok\r\n".to_vec(),
            _ => Vec::new(),
        });
        assert_eq!(found.to_string(), "Grbl 1.1h, version 1.1h.20190830, Idle");
        assert!(time < 2.0, "{time}");
        assert_eq!(written, b"?$I\n");
    }

    #[test]
    fn one_that_runs_a_job_is_left_alone() {
        let (found, time, written) = ask(|asked, _| match asked {
            b"$\n?" => b"ok\r\n<Run|MPos:1.000,0.000,0.000|FS:600,0>\r\n".to_vec(),
            _ => Vec::new(),
        });
        assert_eq!(found.to_string(), "Run");
        assert!(found.is_grbl());
        assert!((2.4..2.6).contains(&time), "{time}");
        assert_eq!(written, b"$\n?");
    }

    #[test]
    fn silence_and_strangers() {
        let (found, time, _) = ask(|_, _| Vec::new());
        assert_eq!(
            (found.to_string().as_str(), found.is_grbl()),
            ("no answer", false)
        );
        assert!((3.4..3.6).contains(&time), "{time}");
        let (found, _, _) = ask(|asked, _| asked.iter().map(|_| 0xFE).collect());
        assert!(!found.is_grbl());
        assert!(
            found.to_string().starts_with("something answers"),
            "{found}"
        );
    }

    proptest! {
        /// Whatever comes, it ends in time, and never resets, resumes or holds.
        #[test]
        fn hostile_answers(noise in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..40), 1..60)) {
            let mut turn = 0;
            let (_, time, written) = ask(|_, _| {
                turn += 1;
                noise[turn % noise.len()].clone()
            });
            prop_assert!(time <= WELCOME_WAIT + 2.0 * ANSWER_WAIT + 0.1);
            prop_assert!(written.iter().all(|b| matches!(b, b'\n' | b'?' | b'$' | b'I')));
        }
    }
}
