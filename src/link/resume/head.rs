//! The way in as lines of a program: lift, go over, spindle, coolant, plunge, modes. The drawing stands in the head of [`super`].

use super::entry::Entry;
use crate::gcode::{Distance, FeedMode, MotionMode, Plane, State, Units};
use crate::geom::Vector;

/// How the way in is gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadOptions {
    /// Where to travel, machine coordinates, mm.
    pub safe_z: f64,
    /// Feed of the plunge, mm/min.
    pub plunge: f64,
    /// Time for the spindle to come to speed, s.
    pub spin_up_s: f64,
    /// The spindle is a laser (`$32`): it needs no time, meets nothing on the way down, and would burn a hole where it stands.
    pub laser: bool,
}

/// The lines that bring a machine that was just reset to the state of `entry`: all modes but G2 and G3,
/// which the entry's line says itself.
///
/// Each step's reason:
/// - all modes are set before anything moves, so startup lines and leftovers of the controller do not matter;
/// - the lift is in machine coordinates, which no offset can bend, and comes before any other motion;
/// - G92 and tool length are gone after a reset; they are set again over the entry, where the place was commanded and is known exactly;
/// - the plunge is at feed: nobody can tell what stands below;
/// - a laser comes on last, when the program goes on at once: with G1 in force M3 makes it burn where it stands (GRBL v1.1 Laser Mode).
pub fn head(entry: &Entry, options: &HeadOptions) -> Vec<String> {
    let s = &entry.state;
    let system = s.work_offset.min(5);
    let origin = s.g5x.get(system).copied().unwrap_or_default();
    let mut lines = vec![
        "G17G21G90G94".to_string(),
        "M5".to_string(),
        "M9".to_string(),
        "G49".to_string(),
        "G92.1".to_string(),
        format!("G{}", 54 + system),
        format!("G53G0{}", word('Z', options.safe_z)),
    ];
    // Without G92, which is set only there.
    let (x, y) = (s.position.x + s.g92.x, s.position.y + s.g92.y);
    lines.push(format!("G0{}{}", word('X', x), word('Y', y)));
    if s.tlo != 0.0 {
        lines.push(format!("G43.1{}", word('Z', s.tlo)));
    }
    if s.g92 != Vector::zeros() {
        // The place where the tool now is, as the program would call it.
        let z = options.safe_z - origin.z - s.tlo - s.g92.z;
        lines.push(format!(
            "G92{}{}{}",
            word('X', s.position.x),
            word('Y', s.position.y),
            word('Z', z)
        ));
    }
    lines.push(word('S', s.speed.0));
    let on = (s.spindle != 0).then(|| if s.spindle > 0 { "M3" } else { "M4" }.to_string());
    if !options.laser {
        lines.extend(on.clone());
        if on.is_some() && options.spin_up_s > 0.0 {
            lines.push(format!("G4{}", word('P', options.spin_up_s)));
        }
    }
    if s.mist {
        lines.push("M7".to_string());
    }
    if s.flood {
        lines.push("M8".to_string());
    }
    let (depth, feed) = (word('Z', s.position.z), word('F', options.plunge));
    match options.laser {
        true => lines.extend([format!("G0{depth}"), format!("G1{feed}")]),
        false => lines.push(format!("G1{depth}{feed}")),
    }
    lines.extend(modes(s));
    if options.laser {
        lines.extend(on);
    }
    lines
}

/// The modes of the program where they differ from G17 G21 G90 G94.
fn modes(s: &State) -> Vec<String> {
    let mut lines = Vec::new();
    match s.feed_mode {
        // A feed of the plunge must not serve a line that has none of its own.
        FeedMode::PerMinute if s.feed.0 <= 0.0 => {
            lines.extend(["G93".to_string(), "G94".to_string()]);
        }
        FeedMode::PerMinute => lines.push(word('F', s.feed.0)),
        _ => {}
    }
    let mut last = String::new();
    match s.plane {
        Plane::Xy => {}
        Plane::Zx => last.push_str("G18"),
        Plane::Yz => last.push_str("G19"),
    }
    if s.units == Units::Inch {
        last.push_str("G20");
    }
    if s.distance == Distance::Incremental {
        last.push_str("G91");
    }
    if s.feed_mode == FeedMode::InverseTime {
        last.push_str("G93");
    }
    if !last.is_empty() {
        lines.push(last);
    }
    if s.motion == MotionMode::Rapid {
        lines.push("G0".to_string());
    }
    lines
}

/// A word with five decimals at most: GRBL reads eight digits of a number, and a hundred-thousandth is far below any step.
fn word(letter: char, value: f64) -> String {
    let mut number = format!("{value:.5}");
    while number.ends_with('0') {
        number.pop();
    }
    if number.ends_with('.') {
        number.pop();
    }
    if number == "-0" {
        number = "0".to_string();
    }
    format!("{letter}{number}")
}

/// A height to travel at, not below the one given, as [`head`] writes it.
pub fn round_up(z: f64) -> f64 {
    (z * 1e3 - 1e-6).ceil() / 1e3
}
