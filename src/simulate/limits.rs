//! Does the program fit the machine: travels, rates, spindle.

use super::report::{Extents, Kind, Problem};
use super::start::Followed;
use crate::gcode::{Event, Motion, MotionKind};
use crate::geom::{Box3, Point};
use crate::kinematics::chords;
use crate::machine::Machine;
use crate::units::Mm;

/// Rounding in the text, mm: a program as long as the travel to within this still fits.
const FIT: f64 = 1e-3;
const AXES: [char; 3] = ['X', 'Y', 'Z'];

/// What the limits say.
pub struct Limits {
    pub problems: Vec<Problem>,
    pub warnings: Vec<Problem>,
    pub extents: Extents,
    /// There are moves named in machine coordinates.
    pub machine_moves: bool,
}

/// Compares a program with a machine, event by event. Where work zero lies on the table is not in the text, so it is the program's *length*
/// that is compared with each axis' travel.
pub struct LimitWatch<'a> {
    machine: &'a Machine,
    travels: Travels,
    machine_moves: bool,
    beyond: Listed,
    speeds: Listed,
    rates: Rates,
    cutting: Option<(usize, f64, usize)>,
    spindle: Spindle,
}

impl<'a> LimitWatch<'a> {
    /// Before the first event.
    pub fn new(machine: &'a Machine) -> LimitWatch<'a> {
        LimitWatch {
            machine,
            travels: Travels::new(),
            machine_moves: false,
            beyond: Listed::default(),
            speeds: Listed::default(),
            rates: Rates::default(),
            cutting: None,
            spindle: Spindle::default(),
        }
    }

    /// The next event, and what [`Places`](super::start::Places) says of it.
    pub fn hear(&mut self, event: &Event, followed: Option<&Followed>) {
        if let Some(f) = followed {
            self.place(f);
        }
        match event {
            Event::Motion(m) if m.kind == MotionKind::Feed => {
                self.rates.motion(m, self.machine);
                self.spindle.cut(m.line);
                if let Some(most) = self.machine.max_feed
                    && !m.inverse_time
                    && m.feed.0 > most.0 * (1.0 + 1e-6)
                {
                    let first = self.cutting.unwrap_or((m.line, m.feed.0, 0));
                    self.cutting = Some((first.0, first.1, first.2 + 1));
                }
            }
            Event::Spindle {
                direction,
                speed,
                line,
            } => {
                self.spindle.turn(*direction, speed.0);
                let [low, high] = self.machine.spindle;
                let speed = speed.0;
                if *direction != 0 && speed > 0.0 && !(low.0..=high.0).contains(&speed) {
                    let name = &self.machine.name;
                    self.speeds.add(|| Problem {
                        kind: Kind::Spindle,
                        line: Some(*line),
                        text: format!(
                            "{speed:.0} rpm is outside what {name} turns, {:.0} to {:.0} rpm: change the S word",
                            low.0, high.0
                        ),
                    });
                }
            }
            _ => {}
        }
    }

    fn place(&mut self, f: &Followed) {
        let m = f.motion;
        if m.machine_coordinates {
            self.machine_moves = true;
            // Machine zero is at one end of each axis, on either side by the maker's taste.
            for (a, axis) in AXES.iter().enumerate() {
                let travel = self.machine.travel[a].0;
                let beyond = m.to[a].abs() - travel;
                if m.to[a] != m.from[a] && beyond > FIT {
                    let name = &self.machine.name;
                    self.beyond.add(|| Problem {
                        kind: Kind::Limit,
                        line: Some(m.line),
                        text: format!(
                            "axis {axis}: machine position {:.3} mm is {beyond:.3} mm beyond the travel of {travel:.1} mm of {name}",
                            m.to[a]
                        ),
                    });
                }
            }
            return;
        }
        // NaN grows no box.
        let mut p = m.to;
        for a in 0..3 {
            if !f.to_known[a] {
                p[a] = f64::NAN;
            }
        }
        self.travels.grow(&p, m.line);
        if let Some(arc) = &m.arc
            && f.to_known == [true; 3]
        {
            for c in chords(&m.from, &m.to, arc, Mm(0.001)) {
                self.travels.grow(&c, m.line);
            }
        }
    }

    /// What they say.
    pub fn finish(self) -> Limits {
        let mut problems = self.beyond.finish();
        self.travels.problems(self.machine, &mut problems);
        problems.extend(self.speeds.finish());
        problems.extend(self.spindle.problem());
        let cutting = self.cutting.map(|(line, feed, count)| {
            let most = self.machine.max_feed.map_or(0.0, |f| f.0);
            Problem {
                kind: Kind::Feed,
                line: Some(line),
                text: format!(
                    "{count} moves ask for more feed than {} cuts at, the first for {feed:.0} mm/min (it does {most:.0}): its control slows them or stops with an alarm",
                    self.machine.name
                ),
            }
        });
        let rates = self.rates.warning(self.machine);
        Limits {
            problems,
            warnings: rates.into_iter().chain(cutting).collect(),
            extents: self.travels.extents(),
            machine_moves: self.machine_moves,
        }
    }
}

/// Problems of one sort, the first of them one by one.
#[derive(Default)]
struct Listed {
    problems: Vec<Problem>,
    more: usize,
}

/// So many of one sort are listed: a program may have millions.
const LISTED: usize = 1000;

impl Listed {
    fn add(&mut self, problem: impl FnOnce() -> Problem) {
        match self.problems.len() < LISTED {
            true => self.problems.push(problem()),
            false => self.more += 1,
        }
    }

    fn finish(mut self) -> Vec<Problem> {
        if let (Some(last), true) = (self.problems.last(), self.more > 0) {
            self.problems.push(Problem {
                kind: last.kind,
                line: None,
                text: format!("and {} more like these", self.more),
            });
        }
        self.problems
    }
}

/// Where the tool tip goes, and on which lines it goes farthest.
struct Travels {
    work: Box3,
    lines: [[usize; 2]; 3],
}

impl Travels {
    fn new() -> Travels {
        Travels {
            work: Box3::empty(),
            lines: [[0; 2]; 3],
        }
    }

    fn grow(&mut self, p: &Point, line: usize) {
        for a in 0..3 {
            if p[a] < self.work.min[a] {
                (self.work.min[a], self.lines[a][0]) = (p[a], line);
            }
            if p[a] > self.work.max[a] {
                (self.work.max[a], self.lines[a][1]) = (p[a], line);
            }
        }
    }

    fn extents(&self) -> Extents {
        let known = |v: [f64; 3]| v.iter().all(|c| c.is_finite()).then_some(v);
        Extents {
            min: known(self.work.min.into()),
            max: known(self.work.max.into()),
        }
    }

    fn problems(&self, machine: &Machine, out: &mut Vec<Problem>) {
        let (work, lines) = (&self.work, &self.lines);
        for a in 0..3 {
            let length = work.max[a] - work.min[a];
            let travel = machine.travel[a].0;
            if length > travel + FIT {
                out.push(Problem {
                    kind: Kind::Limit,
                    line: Some(lines[a][1].max(lines[a][0])),
                    text: format!(
                        "axis {}: the program reaches from {:.3} (line {}) to {:.3} mm (line {}), {:.3} mm in all; {} travels {:.1} mm: {:.3} mm too long",
                        AXES[a], work.min[a], lines[a][0], work.max[a], lines[a][1], length, machine.name, travel, length - travel
                    ),
                });
            }
        }
    }
}

/// Feeds that an axis cannot go.
#[derive(Default)]
struct Rates {
    count: usize,
    /// Line, axis, its rate in mm/min.
    first: Option<(usize, usize, f64)>,
}

impl Rates {
    fn motion(&mut self, m: &Motion, machine: &Machine) {
        if m.inverse_time || m.arc.is_some() {
            return;
        }
        let d = m.to - m.from;
        let length = d.norm();
        if length <= 0.0 {
            return;
        }
        for a in 0..3 {
            let rate = m.feed.0 * d[a].abs() / length;
            if rate > machine.max_rate[a].0 * (1.0 + 1e-6) {
                self.count += 1;
                self.first.get_or_insert((m.line, a, rate));
                break;
            }
        }
    }

    fn warning(&self, machine: &Machine) -> Option<Problem> {
        let (line, a, rate) = self.first?;
        Some(Problem {
            kind: Kind::Feed,
            line: Some(line),
            text: format!(
                "{} moves ask for more than {} goes, the first for {:.0} mm/min of axis {} (it does {:.0}): they run slower, and the time counts them so",
                self.count, machine.name, rate, AXES[a], machine.max_rate[a].0
            ),
        })
    }
}

/// Cuts with the spindle standing.
#[derive(Default)]
struct Spindle {
    direction: i8,
    speed: f64,
    count: usize,
    /// Line of the first, and whether the spindle was switched on there, without a speed.
    first: Option<(usize, bool)>,
}

impl Spindle {
    fn turn(&mut self, direction: i8, speed: f64) {
        (self.direction, self.speed) = (direction, speed);
    }

    fn cut(&mut self, line: usize) {
        if self.direction == 0 || self.speed <= 0.0 {
            self.count += 1;
            self.first.get_or_insert((line, self.direction != 0));
        }
    }

    fn problem(&self) -> Option<Problem> {
        let (line, on) = self.first?;
        let why = match on {
            true => " (M3 or M4 without a speed)",
            false => "",
        };
        Some(Problem {
            kind: Kind::Spindle,
            line: Some(line),
            text: format!(
                "{} moves at feed with the spindle stopped{why}, the first here: put M3 and S before the first cut",
                self.count
            ),
        })
    }
}
