//! All of it together: checks, zones, entry, way in, proof.

use super::check::{self, Evidence, Now, Trust};
use super::entry::{Entry, Overlap, entry};
use super::head::{HeadOptions, head, round_up};
use super::prove::{Proof, prove};
use super::refusal::Refusal;
use super::survey::highest;
use super::text::{Joined, ProgramText};
use super::walk::{Program, lines};
use super::zones::{Zones, zones};
use crate::gcode::source::TextReader;
use crate::gcode::{Dialect, State};
use crate::geom::Vector;
use crate::link::journal::{Begin, History, Resumed, Start};
use std::io::{self, Read as _};

/// How to resume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResumeOptions {
    /// How far back over what is cut.
    pub overlap: Overlap,
    /// Where to travel, machine coordinates, mm; `None`: the highest place of the program.
    pub safe_z: Option<f64>,
    /// Feed of the plunge, mm/min; `None`: the slowest of the program.
    pub plunge: Option<f64>,
    /// Time for the spindle to come to speed, s.
    pub spin_up_s: f64,
    /// Whose word the position has.
    pub trust: Trust,
}

impl Default for ResumeOptions {
    fn default() -> Self {
        ResumeOptions {
            overlap: Overlap::Mm(5.0),
            safe_z: None,
            plunge: None,
            spin_up_s: 5.0,
            trust: Trust::Shown,
        }
    }
}

/// A plunge feed where the program has none to go by, mm/min.
const CAREFUL: f64 = 60.0;

/// Which line of the program a line of the resumed text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineMap {
    /// Lines of the way in, before the program's.
    pub head: usize,
    /// Line of the program that follows them.
    pub entry: usize,
}

impl LineMap {
    /// The line of the program, from 1; 0 for a line of the way in.
    pub fn original(&self, line: usize) -> usize {
        match line > self.head {
            true => (line - self.head - 1).saturating_add(self.entry),
            false => 0,
        }
    }
}

/// A job taken up: to be shown, simulated, then sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Where the job broke; `None` for a start by line number.
    pub zones: Option<Zones>,
    /// Where it is entered.
    pub entry: Entry,
    /// The lines of the way in.
    pub head: Vec<String>,
    /// How the way in is gone.
    pub way: HeadOptions,
    /// Machine position over the entry, at its depth, mm.
    pub place: [f64; 3],
    /// Why the position is trusted.
    pub evidence: Option<Evidence>,
    /// Doubts that the operator answers for, and other things to know before saying yes.
    pub notes: Vec<String>,
    /// The straight run's start, as the new journal is to tell it.
    pub start: Start,
    /// What was compared.
    pub proof: Proof,
}

impl Plan {
    /// The resumed program of a text in memory: the way in, and the program from the entry on.
    pub fn program(&self, text: &str) -> String {
        let mut out = String::new();
        // Memory does not fail.
        let _ = self
            .reader(&text)
            .and_then(|mut from| from.read_to_string(&mut out));
        out
    }

    /// The resumed program, to be read line by line.
    ///
    /// # Errors
    /// The text cannot be read.
    pub fn reader<'a>(&self, text: &'a dyn ProgramText) -> io::Result<Box<dyn TextReader + 'a>> {
        Ok(Box::new(Joined::new(&self.head, text, self.entry.line)?))
    }

    /// Which line of the program a line of [`Plan::program`] is.
    pub fn map(&self) -> LineMap {
        LineMap {
            head: self.head.len(),
            entry: self.entry.line,
        }
    }

    /// What the new journal says of the old one.
    pub fn resumed(&self) -> Resumed {
        Resumed {
            entry: self.entry.line,
            maybe_to: self.zones.map_or(0, |z| z.last),
        }
    }
}

/// Takes up the job of a journal. `sha256` is the fingerprint of the program's bytes.
///
/// # Errors
/// Whatever makes it unsafe.
pub fn resume<T: ProgramText + ?Sized>(
    text: &T,
    sha256: &str,
    history: &History,
    now: &Now,
    options: &ResumeOptions,
) -> Result<Plan, Refusal> {
    let text: &dyn ProgramText = &text;
    let begin = match (&history.begin, history.foreign) {
        (Some(begin), _) => begin,
        (None, Some(format)) => return Err(Refusal::OtherFormat(format)),
        (None, None) => return Err(Refusal::Empty),
    };
    if history.done {
        return Err(Refusal::Finished);
    }
    check::program(text, sha256, begin)?;
    let place = check::machine(begin, now)?;
    let zones = zones(text, begin, history, now.boot.as_deref())?;
    let evidence = check::position(text, begin, history, &zones, now, options.trust)?;
    let moved = check::offsets(text, begin, history, &zones, now, options.trust)?;
    let mut notes: Vec<String> = match evidence {
        Evidence::Operator => history
            .all_doubts()
            .iter()
            .map(|d| format!("you answer for it: {d}"))
            .collect(),
        _ => Vec::new(),
    };
    for (i, by) in moved.iter().enumerate() {
        if by.norm() > 0.0 {
            notes.push(format!(
                "you answer for it: the zero of G{} was moved by X{:.3} Y{:.3} Z{:.3} since the job broke",
                54 + i,
                by.x,
                by.y,
                by.z
            ));
        }
    }
    if let Some(changed) = different(begin, now) {
        notes.push(changed);
    }
    let start = anew(&begin.start, now, &moved);
    let program = Program {
        start: start.state(dialect(now)),
        ..Program::of(text, history, begin)
    };
    let plan = plan(&program, zones.first, now, &place, options)?;
    Ok(Plan {
        zones: Some(zones),
        evidence: Some(evidence),
        notes: [notes, plan.notes].concat(),
        start,
        ..plan
    })
}

/// Begins a program at a line, without a journal: all that the lines before it set is set, none of their motions is made.
///
/// # Errors
/// Whatever makes it unsafe.
pub fn from_line<T: ProgramText + ?Sized>(
    text: &T,
    line: usize,
    skips_slashed: bool,
    now: &Now,
    options: &ResumeOptions,
) -> Result<Plan, Refusal> {
    let text: &dyn ProgramText = &text;
    let program = Program {
        text,
        start: State::new(dialect(now)),
        changes: &[],
        skips_slashed,
    };
    let lines = lines(text)?;
    if line == 0 || line > lines {
        return Err(Refusal::NoSuchLine { line, lines });
    }
    let place = check::ready(now)?;
    let start = Start {
        position: place,
        offsets: crate::link::journal::Offsets {
            g92: [0.0; 3],
            tlo: 0.0,
            ..now.offsets
        },
        modes: String::new(),
    };
    let from = |start: &Start| Program {
        start: start.state(dialect(now)),
        ..program.clone()
    };
    let plan = plan(&from(&start), line, now, &place, options)?;
    // The same from another place: if the entry moves, the program alone does not tell it.
    let elsewhere = Start {
        position: place.map(|c| c - 61.25),
        ..start.clone()
    };
    let other = entry(&from(&elsewhere), line, options.overlap)?;
    let moved = (other.state.position - plan.entry.state.position)
        .norm()
        .max((other.state.g92 - plan.entry.state.g92).norm());
    // Nothing else can hang on the start: it is the same but for its place.
    if moved > 1e-9 || other.line != plan.entry.line {
        return Err(Refusal::StartUnknown {
            line: plan.entry.line,
        });
    }
    Ok(Plan { start, ..plan })
}

/// The start of the straight run in the machine's coordinates of today.
fn anew(start: &Start, now: &Now, moved: &[Vector; 6]) -> Start {
    let mut out = start.clone();
    for (zero, by) in out.offsets.g5x.iter_mut().zip(moved) {
        for a in 0..3 {
            zero[a] += by[a];
        }
    }
    (out.offsets.g28, out.offsets.g30) = (now.offsets.g28, now.offsets.g30);
    let [first, ..] = moved;
    for a in 0..3 {
        // A job begins in G54.
        out.position[a] += first[a];
    }
    out
}

/// Settings that changed and may change how the job runs, but not where it leads.
fn different(begin: &Begin, now: &Now) -> Option<String> {
    let changed: Vec<String> = begin
        .settings
        .iter()
        .filter_map(|(n, then)| {
            let value = now.setting(*n)?;
            ((value - then).abs() > 1e-6 * then.abs() + 1e-9)
                .then(|| format!("${n}={then} is {value} now"))
        })
        .collect();
    (!changed.is_empty()).then(|| format!("settings changed since: {}", changed.join(", ")))
}

fn dialect(now: &Now) -> Dialect {
    Dialect::from_name(&now.dialect).unwrap_or(Dialect::Grbl)
}

/// Entry, way in and proof; `machine` is where the machine stands.
fn plan(
    program: &Program,
    first: usize,
    now: &Now,
    machine: &[f64; 3],
    options: &ResumeOptions,
) -> Result<Plan, Refusal> {
    let mut entry = entry(program, first, options.overlap)?;
    // Differences within the rounding of reports: the controller's own figure is the better one.
    entry.state.g5x = now.offsets.g5x.map(Vector::from);
    let over = entry.state.machine_position();
    let needed = highest(program)?.unwrap_or(over.z);
    let needed = round_up(needed.max(over.z));
    let safe = options.safe_z.unwrap_or(needed);
    if safe.is_nan() || safe < needed - 1e-9 {
        return Err(Refusal::SafeTooLow {
            given: safe,
            needed,
        });
    }
    // Never down where the tool stands: what is there is not known.
    let safe_z = round_up(safe.max(machine[2]));
    within_travel(now, machine, &[over.x, over.y, safe_z])?;
    let mut notes = Vec::new();
    let plunge = options.plunge.filter(|p| *p > 0.0).or(entry.slowest);
    let way = HeadOptions {
        safe_z,
        plunge: plunge.unwrap_or(CAREFUL),
        spin_up_s: options.spin_up_s.clamp(0.0, 600.0),
        laser: now.setting(32).is_some_and(|on| on != 0.0),
    };
    if entry.state.spindle == 0 {
        notes.push("the spindle is off at the entry, as the program has it there".to_string());
    }
    if let Some(tool) = entry.tool {
        notes.push(format!(
            "the program has tool {tool} in the spindle at the entry: check that it is"
        ));
    }
    let head = head(&entry, &way);
    let proof = prove(program, &entry, &head, &now.offsets, machine)?;
    Ok(Plan {
        zones: None,
        place: [over.x, over.y, over.z],
        entry,
        head,
        way,
        evidence: None,
        notes,
        start: Start::default(),
        proof,
    })
}

/// With soft limits on, the way in must not raise an alarm.
fn within_travel(now: &Now, machine: &[f64; 3], point: &[f64; 3]) -> Result<(), Refusal> {
    if now.setting(20).unwrap_or(0.0) == 0.0 {
        return Ok(());
    }
    let travel = [130, 131, 132].map(|n| now.setting(n).unwrap_or(f64::INFINITY));
    let outside = |p: f64, travel: f64, by: f64| p > by || p < -travel - by;
    // Travel lies below machine zero, but for builds that keep zero where homing found it: the session's vetting knows those.
    if machine
        .iter()
        .zip(travel)
        .any(|(p, t)| outside(*p, t, 1e-3))
    {
        return Ok(());
    }
    for ((axis, value), travel) in ['X', 'Y', 'Z'].into_iter().zip(*point).zip(travel) {
        if outside(value, travel, 1e-6) {
            return Err(Refusal::OutsideTravel {
                axis,
                value,
                low: -travel,
                high: 0.0,
            });
        }
    }
    Ok(())
}
