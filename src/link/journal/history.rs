//! What a journal tells, added up.

use super::reader::Damage;
use super::record::{Begin, FORMAT, Record, Stamped, ToolChange};
use crate::wire::State;

/// Why the machine may not be where the job left it, or the part not as the program would have it.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// An alarm in which position is or may be lost.
    Alarm(u16),
    /// The controller restarted by itself.
    Reset,
    /// The sender could not tell that the position was kept; how the job ended.
    NotKept(String),
    /// The journal is damaged: what is missing may have been any of these.
    Damaged,
    /// Bytes were damaged on the cable, and lines may have been carried out as others; how the job ended.
    Cable(String),
    /// The controller refused a line and may have run some behind it with the wrong modes.
    Refused {
        /// Line of the program.
        line: usize,
        /// The N of `error:N`.
        code: u16,
    },
}

impl Doubt {
    /// True when homing takes it away: it is about the position and not about the part.
    pub fn ends_with_homing(&self) -> bool {
        !matches!(self, Doubt::Refused { .. } | Doubt::Cable(_))
    }
}

impl std::fmt::Display for Doubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Doubt::Alarm(code) => write!(f, "ALARM:{code} struck, and with it steps may be lost"),
            Doubt::Reset => {
                f.write_str("the controller restarted by itself in the middle of the job")
            }
            Doubt::NotKept(how) => {
                write!(f, "the sender could not be sure of the position ({how})")
            }
            Doubt::Damaged => f.write_str(
                "the journal is damaged, and an alarm or a reset may be missing from it",
            ),
            Doubt::Cable(how) => write!(
                f,
                "bytes were damaged on the cable, so lines may have been cut as others: inspect the part ({how})"
            ),
            Doubt::Refused { line, code } => write!(
                f,
                "the controller refused line {line} with error:{code} and may have run the lines behind it in the wrong mode: inspect the part"
            ),
        }
    }
}

/// Where the machine was seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting {
    /// State as the controller spells it.
    pub state: String,
    /// Machine position, mm.
    pub machine: [f64; 3],
    /// Last line that was answered before.
    pub acknowledged: usize,
}

/// What a journal tells, added up. Lines count from 1, 0: none.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Which job; `None` when not even that was written.
    pub begin: Option<Begin>,
    /// Last line that was answered.
    pub acknowledged: usize,
    /// Last line that is known to have been sent.
    pub sent: usize,
    /// Last line that may have been sent.
    pub allowed: usize,
    /// Where the machine was seen last.
    pub seen: Option<Sighting>,
    /// Tool changes that were finished, in order.
    pub tool_changes: Vec<ToolChange>,
    /// Reasons for distrust.
    pub doubts: Vec<Doubt>,
    /// How the job ended; `None` when the sender itself ended before it could tell.
    pub end: Option<String>,
    /// Every line was carried out.
    pub done: bool,
    /// The sender saw the machine at rest before it ended.
    pub at_rest: bool,
    /// Why the job was being stopped.
    pub stopping: Option<String>,
    /// Time of the last record, s since the job began.
    pub seconds: f64,
    /// Records believed.
    pub records: u64,
    /// What is wrong with the bytes.
    pub damage: Damage,
    /// The version of its format, if that is one that this program does not read.
    pub foreign: Option<u32>,
    /// False when bytes were damaged on the cable: answers may be made up.
    pub cable_sound: bool,
}

impl Default for History {
    fn default() -> History {
        History {
            begin: None,
            acknowledged: 0,
            sent: 0,
            allowed: 0,
            seen: None,
            tool_changes: Vec::new(),
            doubts: Vec::new(),
            end: None,
            done: false,
            at_rest: false,
            stopping: None,
            seconds: 0.0,
            records: 0,
            damage: Damage::None,
            foreign: None,
            cable_sound: true,
        }
    }
}

/// Tool changes and doubts kept of a journal: more mean that it is not one of ours.
const MOST: usize = 10_000;

impl History {
    /// Takes in one record. False when it cannot stand here: a journal begins with [`Record::Begin`], once, and ends with [`Record::End`].
    pub(super) fn take(&mut self, stamped: &Stamped) -> bool {
        let begins = matches!(stamped.record, Record::Begin(_));
        if begins != self.begin.is_none() || self.end.is_some() || !stamped.t.is_finite() {
            return false;
        }
        let last_line = self.begin.as_ref().map_or(0, |b| b.lines);
        let fits = |line: usize| line <= last_line;
        match &stamped.record {
            Record::Begin(begin) => {
                if begin.format != FORMAT || !stamped.record.is_sound() {
                    return false;
                }
                self.begin = Some((**begin).clone());
            }
            Record::Allow { line } | Record::Sent { line } | Record::Acknowledged { line }
                if !fits(*line) =>
            {
                return false;
            }
            Record::Allow { line } => self.allowed = self.allowed.max(*line),
            Record::Sent { line } => self.sent = self.sent.max(*line),
            Record::Acknowledged { line } => self.acknowledged = self.acknowledged.max(*line),
            Record::Report { state, machine, .. } => {
                self.seen = Some(Sighting {
                    state: state.clone(),
                    machine: *machine,
                    acknowledged: self.acknowledged,
                });
            }
            Record::ToolChange(change) => {
                if self.tool_changes.len() >= MOST {
                    return false;
                }
                self.tool_changes.push(*change);
            }
            Record::Alarm { code } => {
                // 2, 4 and 5 stop in order and keep the position; numbers that GRBL does not have keep nothing for certain.
                if !matches!(code, 2 | 4 | 5) {
                    self.doubt(Doubt::Alarm(*code));
                }
            }
            Record::Error { line, code } => self.doubt(Doubt::Refused {
                line: *line,
                code: *code,
            }),
            Record::Reset => self.doubt(Doubt::Reset),
            Record::Stopping { why } => self.stopping = Some(why.clone()),
            Record::End {
                how,
                done,
                position_kept,
                at_rest,
                cable_sound,
            } => {
                self.at_rest = *at_rest;
                self.end = Some(how.clone());
                self.done = *done;
                self.cable_sound = *cable_sound;
                if !position_kept {
                    self.doubt(Doubt::NotKept(how.clone()));
                }
                if !cable_sound {
                    self.doubt(Doubt::Cable(how.clone()));
                }
            }
            Record::Hold { .. } | Record::Resume | Record::Override { .. } => {}
        }
        self.seconds = self.seconds.max(stamped.t);
        self.records += 1;
        true
    }

    fn doubt(&mut self, doubt: Doubt) {
        if self.doubts.len() < MOST && !self.doubts.contains(&doubt) {
            self.doubts.push(doubt);
        }
    }

    /// Where the sender saw the machine come to rest, if it told that and nothing came behind it.
    pub fn rest(&self) -> Option<&Sighting> {
        let at_rest = |s: &&Sighting| State::parse(&s.state).at_rest();
        self.seen.as_ref().filter(at_rest).filter(|_| self.at_rest)
    }

    /// All reasons for distrust, a damaged journal among them.
    pub fn all_doubts(&self) -> Vec<Doubt> {
        let mut all = self.doubts.clone();
        if matches!(self.damage, Damage::Broken { .. }) {
            all.push(Doubt::Damaged);
        }
        all
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
