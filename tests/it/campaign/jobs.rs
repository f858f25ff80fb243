//! Random programs of everything a job may hold, each taken by the interpreter line by line, and the way their axes should go.

use crate::chance::Chance;
use morsemill::gcode::{self, Event, FeedMode, MotionKind, State, interpret_line};
use morsemill::geom::Point;
use morsemill::kinematics::chords;
use morsemill::units::Mm;

/// Steps a millimetre of the machine of these jobs.
pub const STEPS: f64 = 250.0;
/// Where the machine stands before each job, machine coordinates.
pub const START: [f64; 3] = [-95.0, -85.0, -20.0];
/// Origins of G54 to G59.
pub const ORIGINS: [[f64; 3]; 6] = [
    [-100.0, -90.0, -60.0],
    [-110.5, -95.25, -62.125],
    [-99.5, -80.0, -58.0],
    [-90.0, -101.75, -61.5],
    [-104.0, -88.004, -59.0],
    [-96.125, -84.0, -60.5],
];

/// What a program may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Motions, modes, offsets that a reset forgets, pauses.
    Motions,
    /// Also tool changes, and offsets that are stored for good.
    All,
}

/// A program of about so many lines. `start`: what the controller remembers before it.
pub fn program(dice: &mut Chance, lines: usize, start: &State, holds: Holds) -> String {
    let mut state = start.clone();
    let mut text = String::new();
    let head = [
        "(a job)",
        "G21 G90 G17 G94",
        "M3 S8000",
        "G0 Z10",
        "G0 X0 Y0",
        "G1 Z1 F400",
    ];
    let mut wanted: Vec<String> = head.iter().rev().map(|s| s.to_string()).collect();
    let mut count = 0;
    while count < lines + head.len() {
        if wanted.is_empty() {
            wanted = random_lines(dice, &state, holds);
        }
        let Some(line) = wanted.pop() else { continue };
        let mut trial = state.clone();
        let mut events = Vec::new();
        if interpret_line(&mut trial, &sent(&line), count + 1, &mut events).is_err() {
            continue;
        }
        let near = |p: &Point| p.iter().all(|c| c.abs() < 160.0);
        let machine = trial.machine_position();
        if !near(&machine) || !near(&trial.position) || machine.z < -80.0 || machine.z > -5.0 {
            continue;
        }
        // What bulges out of its ends must stay on the machine too.
        let bulge = events.iter().any(|e| matches!(e, Event::Motion(m) if m.arc.is_some_and(|a| (m.to - a.center).norm() > 8.0)));
        if bulge || machine.x > -10.0 || machine.y > -10.0 {
            continue;
        }
        state = trial;
        text.push_str(&line);
        text.push('\n');
        count += 1;
    }
    if dice.roll(2) == 0 {
        text.push_str(["M30\n", "M2\n", "M5\nM9\nG53 G0 Z-6\nM30\n", "%\n"][dice.roll(4)]);
    }
    text
}

/// One line, or a run of short ones (last first).
fn random_lines(dice: &mut Chance, state: &State, holds: Holds) -> Vec<String> {
    if holds == Holds::All && dice.roll(25) == 0 {
        return rare_lines(dice, state);
    }
    let plain =
        state.distance == gcode::Distance::Absolute && state.feed_mode == FeedMode::PerMinute;
    if plain && dice.roll(12) == 0 {
        // Short segments, as passes of a freeform part are.
        let unit = state.units.mm();
        let (mut angle, step) = (dice.part() * 6.3, 0.05 + 0.3 * dice.part());
        let mut p = state.position;
        let mut run = Vec::new();
        for _ in 0..5 + dice.roll(25) {
            angle += dice.part() - 0.5;
            p.x += step * angle.cos();
            p.y += step * angle.sin();
            p.z += 0.02 * (dice.part() - 0.5);
            run.push(format!(
                "G1X{:.4}Y{:.4}Z{:.4}F1500",
                p.x / unit,
                p.y / unit,
                p.z / unit
            ));
        }
        run.reverse();
        return run;
    }
    vec![random_line(dice, state)]
}

/// A tool change, or an offset that outlives the job (last line first).
fn rare_lines(dice: &mut Chance, state: &State) -> Vec<String> {
    let unit = state.units.mm();
    let system = 1 + dice.roll(6);
    let near = |dice: &mut Chance, of: f64| (of + dice.part() * 4.0 - 2.0) / unit;
    let zero = state.g5x.get(system - 1).copied().unwrap_or_default();
    match dice.roll(4) {
        // The session cannot set an arc's mode anew behind it: a line that relied on one would be refused.
        0 | 1 => vec![
            format!("G1 F{:.1}", 400.0 / unit),
            format!("{}M6 (tool)", ["", "T2 ", "T7"][dice.roll(3)]),
        ],
        2 => vec![format!(
            "G10 L2 P{system} X{:.3} Y{:.3} Z{:.3}",
            near(dice, zero.x),
            near(dice, zero.y),
            near(dice, zero.z)
        )],
        _ => vec![format!(
            "G10 L20 P{system} Z{:.3}",
            near(dice, state.position.z)
        )],
    }
}

fn random_line(dice: &mut Chance, state: &State) -> String {
    let unit = state.units.mm();
    let incremental = state.distance == gcode::Distance::Incremental;
    let axis = |dice: &mut Chance, letter: char, now: f64| {
        // A few millimetres from here, in whatever the words mean now.
        let by = dice.roll(800) as f64 / 100.0 - 4.0;
        let to = if incremental {
            by
        } else {
            (now * 100.0).round() / 100.0 + by
        };
        format!("{letter}{:.4}", to / unit)
    };
    let p = state.position;
    let f = match state.feed_mode {
        FeedMode::InverseTime => format!("F{}", 40 + dice.roll(200)),
        _ if dice.roll(3) == 0 => format!("F{:.2}", (300 + dice.roll(1500)) as f64 / unit),
        _ => String::new(),
    };
    match dice.roll(42) {
        0..=9 => format!("G1 {} {} {f}", axis(dice, 'X', p.x), axis(dice, 'Y', p.y)),
        10..=14 => format!("{} {} {f}", axis(dice, 'X', p.x), axis(dice, 'Y', p.y)),
        15..=16 => format!(
            "g1{}{}{}{f}",
            axis(dice, 'X', p.x),
            axis(dice, 'Y', p.y),
            axis(dice, 'Z', p.z)
        ),
        17 => format!("G0 {} {}", axis(dice, 'X', p.x), axis(dice, 'Z', p.z)),
        18..=21 => {
            // An arc by its centre in the plane in force, often without its G word, now and then a helix.
            let [a, b, c] = state.plane.axes();
            let (i, j) = (
                dice.roll(600) as f64 / 100.0 - 3.0,
                dice.roll(600) as f64 / 100.0 - 3.0,
            );
            // Up to nearly a whole turn.
            let (sin, cos) = (dice.part() * (628.0 / 100.0)).sin_cos();
            let (u, v) = (-i * cos + j * sin, -i * sin - j * cos);
            let base = if incremental {
                [0.0, 0.0]
            } else {
                [p[a], p[b]]
            };
            let names = ['X', 'Y', 'Z'];
            let centers = ['I', 'J', 'K'];
            let g = ["G2 ", "G3 ", "", ""][dice.roll(4)];
            let climb = if dice.roll(3) == 0 {
                axis(dice, names[c], p[c])
            } else {
                String::new()
            };
            format!(
                "{g}{}{:.5} {}{:.5} {climb} {}{:.5} {}{:.5} {f}",
                names[a],
                (base[0] + i + u) / unit,
                names[b],
                (base[1] + j + v) / unit,
                centers[a],
                i / unit,
                centers[b],
                j / unit
            )
        }
        22 => {
            let r = 3.0 + dice.roll(400) as f64 / 100.0;
            format!(
                "G{} {} {} R{:.4} {f}",
                2 + dice.roll(2),
                axis(dice, 'X', p.x),
                axis(dice, 'Y', p.y),
                r / unit
            )
        }
        23 => ["G20", "G21"][dice.roll(2)].to_string(),
        24 => ["G90", "G91", "G90"][dice.roll(3)].to_string(),
        25 => ["G93", "G94 F500", "G94 F900"][dice.roll(3)].to_string(),
        26 => ["G17", "G18", "G19", "G17"][dice.roll(4)].to_string(),
        27 => format!("G{}", 54 + dice.roll(6)),
        28 => format!(
            "G92 X{:.3} Z{:.3}",
            (dice.part() * 20.0 - 10.0) / unit,
            (p.z + 2.0 - dice.roll(4) as f64) / unit
        ),
        29 => ["G92.1", "G49", "G43.1 Z0.5"][dice.roll(3)].to_string(),
        30 => ["M3 S9000", "M4 S12000", "M5", "S7000"][dice.roll(4)].to_string(),
        31 => ["M8", "M9"][dice.roll(2)].to_string(),
        32 => format!("G4 P0.{}", dice.roll(9)),
        33 => ["(note)", "", "; nothing ?", "%"][dice.roll(4)].to_string(),
        34 => format!("G53 G0 Z{:.3}", (-10.0 - dice.roll(10) as f64) / unit),
        35 => format!("T{} G1 {} {f}", dice.roll(5), axis(dice, 'X', p.x)),
        36 => format!("N{} G1 {} {f} (x)", dice.roll(999), axis(dice, 'Y', p.y)),
        37 => format!(
            "M{} S{} G1 {} {f}",
            3 + dice.roll(2),
            5000 + dice.roll(9) * 100,
            axis(dice, 'X', p.x)
        ),
        38 if dice.roll(3) == 0 => "M0 (look)".to_string(),
        39 if !incremental => {
            // As long as a line may be.
            let to = |now: f64, by: f64| (now + by) / unit;
            format!(
                "N{:05}G1X{:.9}Y{:.9}Z{:.9}F{:.8}",
                dice.roll(99_999),
                to(p.x, dice.part()),
                to(p.y, -dice.part()),
                to(p.z, dice.part() - 0.5),
                (400.0 + dice.part() * 900.0) / unit
            )
        }
        _ => format!("{} {f}", axis(dice, 'Z', p.z)),
    }
}

/// The end of a straight piece of the way, in whole steps.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub to: Point,
    /// Line of the program.
    pub line: usize,
    pub rapid: bool,
}

/// The way of a program's axes from `start` in machine coordinates, mm, as the controller cuts it into blocks; the first corner is where it
/// begins (line 0).
pub fn way(text: &str, start: &State) -> Vec<Corner> {
    let steps = |p: Point| p.map(|c| (c * STEPS).round() / STEPS);
    let mut state = start.clone();
    let mut at = steps(state.machine_position());
    let mut corners = vec![Corner {
        to: at,
        line: 0,
        rapid: true,
    }];
    for (index, line) in text.lines().enumerate() {
        let mut events = Vec::new();
        if interpret_line(&mut state, &sent(line), index + 1, &mut events).is_err() {
            continue;
        }
        for event in &events {
            let Event::Motion(m) = event else { continue };
            let shift = state.machine_position() - m.to;
            let mut go = |to: Point| {
                let to = steps(to);
                if to != at {
                    corners.push(Corner {
                        to,
                        line: index + 1,
                        rapid: m.kind == MotionKind::Rapid,
                    });
                    at = to;
                }
            };
            match &m.arc {
                None => go(m.to + shift),
                Some(arc) => chords(&m.from, &m.to, arc, Mm(0.002)).for_each(|p| go(p + shift)),
            }
        }
    }
    corners
}

/// What of a line is sent: as any sender does it.
fn sent(line: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for c in line.chars() {
        match c {
            '(' => inside = true,
            ')' => inside = false,
            ';' => break,
            c if inside || c <= ' ' => {}
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    // The session keeps tool changes for itself.
    let out = out.replacen("M6", "", 1);
    if out == "%" { String::new() } else { out }
}
