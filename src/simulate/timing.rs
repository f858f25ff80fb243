//! The pass that asks when: the program as the controller takes it when switched on, through the planner's clock and the link.

use super::program::{Open, READING, unreadable};
use super::report::{DryRun, Kind, Problem};
use crate::gcode::source::{Source, TextReader};
use crate::gcode::{Dialect, InterpretError, Interpreter, State};
use crate::kinematics::{Clock, Demand, Feed, LinkDemand, Settings, Times};
use crate::machine::Machine;
use std::io;

/// What the pass found.
pub struct Timing {
    /// Why the program cannot be read; empty if it can.
    pub errors: Vec<InterpretError>,
    /// How long it takes.
    pub times: Times,
    /// What it needs of the link; `None` for a machine that is not fed over one, and for a program whose lines are run out of their order:
    /// that is not fed line by line.
    pub demand: Option<LinkDemand>,
    /// What the machine remembers behind it.
    pub end: State,
    /// Lines of the text.
    pub lines: usize,
    /// Bytes of the text.
    pub bytes: u64,
}

/// Times a program. Memory does not grow with its length.
pub fn timing(open: &Open, dialect: Dialect, machine: &Machine) -> Timing {
    let mut out = Timing {
        errors: Vec::new(),
        times: Times::default(),
        demand: None,
        end: State::new(dialect),
        lines: 0,
        bytes: 0,
    };
    if let Err(e) = read(open, machine, &mut out) {
        out.errors.push(unreadable(&e));
    }
    out
}

fn read(open: &Open, machine: &Machine, out: &mut Timing) -> io::Result<()> {
    let mut program = Interpreter::from_state(open()?, out.end.clone(), READING)?;
    let mut clock = Clock::new(&Settings::from(machine));
    let mut lines = Lines::new(open()?, machine)?;
    out.errors = program.tell_all(&mut |event| {
        clock.hear(event, &mut |line, time| lines.spent(line, time));
    });
    out.times = clock.finish(&mut |line, time| lines.spent(line, time));
    out.end = program.state().clone();
    (out.lines, out.bytes, out.demand) = lines.finish()?;
    Ok(())
}

/// The text again, some lines behind, for the length of each line.
struct Lines<'a> {
    text: Source<Box<dyn TextReader + 'a>>,
    demand: Option<Demand>,
    /// The line that time goes to, and how much so far.
    line: usize,
    seconds: f64,
    failed: Option<io::Error>,
}

impl<'a> Lines<'a> {
    fn new(text: Box<dyn TextReader + 'a>, machine: &Machine) -> io::Result<Lines<'a>> {
        let feed = Feed {
            // Eight bits, a start and a stop.
            bytes_per_s: f64::from(machine.baud) / 10.0,
            rx_bytes: machine.rx_buffer,
            blocks: machine.planner_blocks,
        };
        Ok(Lines {
            text: Source::new(text)?,
            demand: (machine.baud > 0).then(|| Demand::new(&feed)),
            line: 0,
            seconds: 0.0,
            failed: None,
        })
    }

    fn spent(&mut self, line: usize, time: f64) {
        if line > self.line {
            self.done();
            (self.line, self.seconds) = (line, 0.0);
        }
        if line < self.line {
            self.demand = None;
        }
        self.seconds += time;
    }

    /// No more time goes to the line.
    fn done(&mut self) {
        let Some(demand) = &mut self.demand else {
            return;
        };
        while self.text.place().line <= self.line {
            match self.text.read() {
                Ok(Some((number, text))) => {
                    let seconds = if number == self.line {
                        self.seconds
                    } else {
                        0.0
                    };
                    demand.line(text.len() + 1, seconds);
                }
                Ok(None) => return,
                Err(e) => {
                    self.failed = Some(e);
                    return;
                }
            }
        }
    }

    /// Lines, bytes, and what is needed of the link.
    fn finish(mut self) -> io::Result<(usize, u64, Option<LinkDemand>)> {
        self.done();
        if let Some(e) = self.failed {
            return Err(e);
        }
        while self.text.read()?.is_some() {}
        let end = self.text.place();
        Ok((end.line - 1, end.offset, self.demand.map(Demand::finish)))
    }
}

/// Share of the time a machine may wait for lines before it is worth a word: such a stand leaves a mark on the surface.
const STARVED: f64 = 0.01;
/// Lines per second that an 8-bit GRBL board reads, at least.
const SLOW_BOARD_LINES: f64 = 200.0;
/// Receive buffers up to this belong to such boards, bytes.
const SLOW_BOARD_RX: usize = 256;

/// Compares what the program needs of the link with what the link gives.
pub fn feeding(demand: LinkDemand, machine: &Machine, report: &mut DryRun) {
    let mut say = |text: String| {
        report.warnings.push(Problem {
            kind: Kind::Link,
            line: None,
            text,
        });
    };
    if demand.starved_share > STARVED {
        say(format!(
            "the link of {} baud starves the planner for {:.1} s ({:.1} % of the time): up to {:.0} bytes/s are needed and {:.0} come. \
             Ask for a larger scallop (its tolerances grow with it), a lower feed, or set a higher baud rate",
            machine.baud,
            demand.starved_s,
            100.0 * demand.starved_share,
            demand.bytes_per_s_needed,
            demand.bytes_per_s_link
        ));
    } else if demand.lines_per_s_p99 > SLOW_BOARD_LINES && machine.rx_buffer <= SLOW_BOARD_RX {
        say(format!(
            "up to {:.0} lines/s are needed, and 8-bit boards read 200 to 400: it may stutter. Ask for a larger scallop or a lower feed",
            demand.lines_per_s_max
        ));
    }
    report.link_demand = Some(demand);
}
