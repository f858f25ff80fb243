//! Does the program fit the machine: travels, rates, spindle.

use super::report::{Extents, Kind, Problem};
use super::start::Places;
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

/// Compares a program with a machine. Where work zero lies on the table is not in the text, so it is the program's *length* that
/// is compared with each axis' travel.
pub fn limits(events: &[Event], machine: &Machine) -> Limits {
    let mut out = Limits {
        problems: Vec::new(),
        warnings: Vec::new(),
        extents: Extents::default(),
        machine_moves: false,
    };
    travels(events, machine, &mut out);
    rates(events, machine, &mut out);
    cutting(events, machine, &mut out);
    spindle(events, machine, &mut out);
    out
}

fn travels(events: &[Event], machine: &Machine, out: &mut Limits) {
    let mut work = Box3::empty();
    let mut lines: [[usize; 2]; 3] = [[0; 2]; 3];
    let mut grow = |p: &Point, line: usize| {
        for a in 0..3 {
            if p[a] < work.min[a] {
                (work.min[a], lines[a][0]) = (p[a], line);
            }
            if p[a] > work.max[a] {
                (work.max[a], lines[a][1]) = (p[a], line);
            }
        }
    };
    let mut places = Places::default();
    for event in events {
        let Some((m, _, known)) = places.follow(event) else {
            continue;
        };
        if m.machine_coordinates {
            out.machine_moves = true;
            // Machine zero is at one end of each axis, on either side by the maker's taste.
            for (a, axis) in AXES.iter().enumerate() {
                let beyond = m.to[a].abs() - machine.travel[a].0;
                if m.to[a] != m.from[a] && beyond > FIT {
                    out.problems.push(Problem {
                        kind: Kind::Limit,
                        line: Some(m.line),
                        text: format!(
                            "axis {axis}: machine position {:.3} mm is {:.3} mm beyond the travel of {:.1} mm of {}",
                            m.to[a], beyond, machine.travel[a].0, machine.name
                        ),
                    });
                }
            }
            continue;
        }
        // NaN grows no box.
        let mut p = m.to;
        for a in 0..3 {
            if !known[a] {
                p[a] = f64::NAN;
            }
        }
        grow(&p, m.line);
        if let Some(arc) = &m.arc
            && known == [true; 3]
        {
            for c in chords(&m.from, &m.to, arc, Mm(0.001)) {
                grow(&c, m.line);
            }
        }
    }
    let known = |v: [f64; 3]| v.iter().all(|c| c.is_finite()).then_some(v);
    out.extents = Extents {
        min: known(work.min.into()),
        max: known(work.max.into()),
    };
    for a in 0..3 {
        let length = work.max[a] - work.min[a];
        let travel = machine.travel[a].0;
        if length > travel + FIT {
            out.problems.push(Problem {
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

fn rates(events: &[Event], machine: &Machine, out: &mut Limits) {
    let mut over: Option<(usize, usize, f64, usize)> = None;
    for event in events {
        let Event::Motion(m) = event else { continue };
        if m.kind != MotionKind::Feed || m.inverse_time || m.arc.is_some() {
            continue;
        }
        let d = m.to - m.from;
        let length = d.norm();
        for a in 0..3 {
            let rate = if length > 0.0 {
                m.feed.0 * d[a].abs() / length
            } else {
                0.0
            };
            if rate > machine.max_rate[a].0 * (1.0 + 1e-6) {
                let (_, _, _, count) = over.unwrap_or((0, 0, 0.0, 0));
                over = Some(over.map_or((m.line, a, rate, 1), |o| (o.0, o.1, o.2, count + 1)));
                break;
            }
        }
    }
    if let Some((line, a, rate, count)) = over {
        out.warnings.push(Problem {
            kind: Kind::Feed,
            line: Some(line),
            text: format!(
                "{count} moves ask for more than {} goes, the first for {:.0} mm/min of axis {} (it does {:.0}): they run slower, and the time counts them so",
                machine.name, rate, AXES[a], machine.max_rate[a].0
            ),
        });
    }
}

/// Feeds above what the maker allows while cutting.
fn cutting(events: &[Event], machine: &Machine, out: &mut Limits) {
    let Some(most) = machine.max_feed else { return };
    let mut over: Option<(usize, f64, usize)> = None;
    for event in events {
        if let Event::Motion(m) = event
            && m.kind == MotionKind::Feed
            && !m.inverse_time
            && m.feed.0 > most.0 * (1.0 + 1e-6)
        {
            over = Some(over.map_or((m.line, m.feed.0, 1), |o| (o.0, o.1, o.2 + 1)));
        }
    }
    if let Some((line, feed, count)) = over {
        out.warnings.push(Problem {
            kind: Kind::Feed,
            line: Some(line),
            text: format!(
                "{count} moves ask for more feed than {} cuts at, the first for {feed:.0} mm/min (it does {:.0}): its control slows them or stops with an alarm",
                machine.name, most.0
            ),
        });
    }
}

fn spindle(events: &[Event], machine: &Machine, out: &mut Limits) {
    let (mut direction, mut speed) = (0i8, 0.0f64);
    let mut still: Option<(usize, usize)> = None;
    let [low, high] = machine.spindle;
    for event in events {
        match event {
            Event::Spindle {
                direction: d,
                speed: s,
                line,
            } => {
                (direction, speed) = (*d, s.0);
                if direction != 0 && speed > 0.0 && !(low.0..=high.0).contains(&speed) {
                    out.problems.push(Problem {
                        kind: Kind::Spindle,
                        line: Some(*line),
                        text: format!(
                            "{speed:.0} rpm is outside what {} turns, {:.0} to {:.0} rpm: change the S word",
                            machine.name, low.0, high.0
                        ),
                    });
                }
            }
            Event::Motion(Motion {
                kind: MotionKind::Feed,
                line,
                ..
            }) if direction == 0 || speed <= 0.0 => {
                still = Some(still.map_or((*line, 1), |(l, n)| (l, n + 1)));
            }
            _ => {}
        }
    }
    if let Some((line, count)) = still {
        let why = if direction == 0 {
            ""
        } else {
            " (M3 or M4 without a speed)"
        };
        out.problems.push(Problem {
            kind: Kind::Spindle,
            line: Some(line),
            text: format!(
                "{count} moves at feed with the spindle stopped{why}, the first here: put M3 and S before the first cut"
            ),
        });
    }
}
