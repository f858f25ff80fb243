//! One case: a random job, what befalls it, and what became of it.

use super::bench::{Bench, Ran, begin, machine};
use super::faults::{Class, schedule};
use super::follow::lengths;
use super::jobs::{Holds, program, way};
use super::laws::judge;
use crate::chance::Chance;
use morsemill::gcode::interpret_line;
use morsemill::link::vet::{Limits, VetOptions, vet};
use morsemill::link::{Ending, Job, Known, Text};
use std::sync::Arc;

/// What became of one case.
#[derive(Clone, Debug)]
pub struct Verdict {
    pub class: Class,
    pub ending: String,
    /// It was taken up again, and done.
    pub resumed: bool,
    /// The height maps were compared.
    pub compared: bool,
    /// Damaged bytes made another program of it, or the middle zone begins too late.
    pub astray: bool,
    /// The path watch ended it.
    pub noticed: bool,
    /// Machine time, s.
    pub seconds: f64,
    /// What was said, if asked for.
    pub log: Vec<String>,
}

/// A case that has run.
pub struct Case {
    pub class: Class,
    pub text: String,
    pub known: &'static Known,
    /// Of the cable, s.
    pub delay: f64,
    /// Line of the program and bytes of each line of the job.
    pub bytes: Vec<(usize, usize)>,
    pub ran: Ran,
    pub dice: Chance,
    pub trace: bool,
}

impl Case {
    /// This computer's boot when the job is taken up.
    pub fn boot(&self) -> &'static str {
        match self.class {
            Class::PowerCut => "the next boot",
            _ => "boot",
        }
    }
}

/// Vets lines of a program from `first_line` on, behind those of a way in.
pub fn job(
    text: &str,
    known: &Known,
    entry: Vec<String>,
    first_line: usize,
) -> Result<Job, String> {
    let options = VetOptions {
        limits: Limits::None,
        entry,
        first_line,
        ..VetOptions::of(known, None)
    };
    vet(Arc::new(Text(text.into())), options, &mut |_, _| {}).map_err(|e| format!("vetting: {e:?}"))
}

/// A random program that passes vetting.
fn random_program(dice: &mut Chance, class: Class, known: &Known, holds: Holds) -> String {
    let count = 10 + dice.roll(60);
    let mut text = program(dice, count, &known.start(), holds);
    // Vetting refuses a little more than the interpreter.
    while job(&text, known, Vec::new(), 1).is_err() {
        text = program(dice, count, &known.start(), holds);
    }
    if class != Class::SoftLimit {
        return text;
    }
    let at = 6 + dice.roll(text.lines().count() - 6);
    let mut lines: Vec<&str> = text.lines().collect();
    lines.insert(at, "G53 G0 X4");
    // Behind it only what still can be taken; none of it ever runs.
    let mut state = known.start();
    lines.retain(|line| interpret_line(&mut state, line, 0, &mut Vec::new()).is_ok());
    lines.truncate(at + 12);
    lines.join("\n") + "\n"
}

/// Runs the case of a seed: `Err` tells the law that was broken. `trace`: keep what was said.
pub fn case(seed: u64, trace: bool) -> Result<Verdict, String> {
    let mut dice = Chance(seed);
    let class = Class::ALL[dice.roll(Class::ALL.len())];
    drawn(class, dice, Holds::All, trace)
}

/// The case that a seed stood for when there were fewer classes of faults, and jobs had neither tool changes nor stored offsets.
pub fn first_case(seed: u64, trace: bool) -> Result<Verdict, String> {
    let mut dice = Chance(seed);
    let class = Class::ALL[dice.roll(Class::FIRST)];
    drawn(class, dice, Holds::Motions, trace)
}

fn drawn(class: Class, mut dice: Chance, holds: Holds, trace: bool) -> Result<Verdict, String> {
    let (controller, known) = machine(class);
    let text = random_program(&mut dice, class, known, holds);
    let corners = way(&text, &known.start());
    let total = lengths(&corners).last().copied().unwrap_or(0.0);
    let plan = schedule(&mut dice, class, total / 13.0, text.lines().count());
    let vetted = job(&text, known, Vec::new(), 1).map_err(|why| format!("{class:?}: {why}"))?;
    let mut lines = vetted.lines().map_err(|e| e.to_string())?;
    let bytes = std::iter::from_fn(|| lines.next_line().ok().flatten())
        .map(|l| (l.source, l.bytes()))
        .collect();
    let delay = plan.plan.delay;
    let ran = Bench::new(
        controller,
        known,
        vetted,
        begin(&text, known),
        plan,
        dice.clone(),
        trace,
    )
    .run();
    let mut verdict = Verdict {
        class,
        ending: ran
            .outcome
            .as_ref()
            .map_or("killed".to_string(), |o| o.ending.key()),
        resumed: false,
        compared: false,
        astray: false,
        noticed: matches!(
            ran.outcome.as_ref().map(|o| &o.ending),
            Some(Ending::OffPath(_))
        ),
        seconds: ran.ended_at,
        log: Vec::new(),
    };
    if trace {
        let program = text
            .lines()
            .enumerate()
            .map(|(i, line)| format!("{:4} {line}", i + 1));
        verdict.log = program.chain(ran.log.iter().cloned()).collect();
    }
    let case = Case {
        class,
        text,
        known,
        delay,
        bytes,
        ran,
        dice,
        trace,
    };
    match judge(&case, &mut verdict) {
        Ok(()) => Ok(verdict),
        Err(why) => Err(format!(
            "{}\n{class:?}, ended {} at {:.3} s: {why}",
            verdict.log.join("\n"),
            verdict.ending,
            case.ran.ended_at
        )),
    }
}
