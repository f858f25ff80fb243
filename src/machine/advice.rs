//! What is allowed in a machine file and yet looks like a slip: units taken for others, figures that do not go together.
//!
//! Crosses the border: a checked machine and its text in; warnings with their places out. Never refuses anything.

use super::Machine;
use super::data::Reader;
use super::family::Kind;

/// Steps per second that an 8-bit GRBL board makes (GRBL 1.1: 30 kHz and a little).
const GRBL_STEPS_PER_S: f64 = 40_000.0;
/// No axis of any mill accelerates faster, mm/s2 (3 g).
const MOST_ACCELERATION: f64 = 30_000.0;
/// Spindles faster than this drive no mills, rpm.
const FASTEST_SPINDLE: f64 = 100_000.0;
/// No axis of any mill is shorter, mm.
const SHORTEST_TRAVEL: f64 = 15.0;
const AXES: [char; 3] = ['X', 'Y', 'Z'];

/// A warning about a key, with its place in `text`, which complaints call `file`.
pub fn at(file: &str, text: &str, key: &str, problem: &str) -> String {
    let mut byte = 0;
    for line in text.split_inclusive('\n') {
        let rest = line.trim_start();
        let after = rest.strip_prefix(key).map(str::trim_start);
        if after.is_some_and(|a| a.starts_with('=')) {
            byte += line.len() - rest.len();
            break;
        }
        byte += line.len();
    }
    if byte >= text.len() {
        return format!("{file}: warning: {key}: {problem}");
    }
    let place = Reader::new(file, text, "machines").place(byte);
    format!("{place}: warning: {key}: {problem}")
}

/// Everything that looks like a slip, in the order of the axes.
pub fn of(m: &Machine, file: &str, text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut warn = |key: &str, problem: String| out.push(at(file, text, key, &problem));
    for (i, axis) in AXES.iter().enumerate() {
        let (speed, a) = (m.max_rate[i].mm_per_s(), m.acceleration[i].0);
        let needed = speed * speed / a;
        if m.travel[i].0 < SHORTEST_TRAVEL {
            warn(
                "travel_mm",
                format!(
                    "axis {axis} goes {} mm: is it in mm, and not in inches or metres?",
                    m.travel[i].0
                ),
            );
        } else if needed > m.travel[i].0 {
            warn(
                "acceleration_mm_per_s2",
                format!(
                    "axis {axis} would need {needed:.0} mm to reach {} mm/min and stop again, and it goes {} mm: is the one in mm/s2 and the other in mm/min?",
                    m.max_rate[i].0, m.travel[i].0
                ),
            );
        }
        if a > MOST_ACCELERATION {
            warn(
                "acceleration_mm_per_s2",
                format!("axis {axis}: {a} mm/s2 is more than 3 g: is it in mm/s2?"),
            );
        }
        let steps = speed * m.steps_per_mm[i];
        if m.controller == "grbl" && steps > GRBL_STEPS_PER_S {
            warn(
                "steps_per_mm",
                format!(
                    "axis {axis} at its fastest asks for {steps:.0} steps/s, and an 8-bit GRBL board makes about 30000: look at $10{i} and $11{i}"
                ),
            );
        }
    }
    if m.spindle[1].0 > FASTEST_SPINDLE {
        let fastest = m.spindle[1].0;
        warn(
            "spindle_rpm",
            format!("{fastest} rpm is more than any mill turns: is it in rpm?"),
        );
    }
    let family = m.family();
    if let (Some(own), Some(of_post)) = (family, super::Family::of(&m.post))
        && own.name != of_post.name
        && !(own.kind == Kind::Grbl && of_post.kind == Kind::Grbl)
        && !matches!(
            (own.name, of_post.name),
            ("pathpilot", "linuxcnc") | ("linuxcnc", "pathpilot") | ("carbide", "grbl")
        )
    {
        let (control, dialect) = (own.title, of_post.title);
        warn(
            "post",
            format!(
                "the controller is {control}, and the post writes for {dialect}: they seldom understand each other"
            ),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn no_machine_that_comes_with_the_program_looks_like_a_slip() {
        for (name, text) in super::super::BUILT_IN {
            let m = Machine::from_toml(name, text).unwrap();
            assert_eq!(of(&m, name, text), Vec::<String>::new());
        }
    }

    #[test]
    fn slips_are_told_with_their_places() {
        let good = include_str!("../../machines/grbl-3018.toml");
        let told = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            let text = good.replace(from, to);
            of(&Machine::from_toml("m", &text).unwrap(), "m.toml", &text)
        };
        let w = told("[30, 30, 30]", "[30, 30, 3]");
        assert_eq!(
            w,
            [
                "m.toml:10:1: warning: acceleration_mm_per_s2: axis Z would need 237 mm to reach 1600 mm/min and stop again, and it goes 40 mm: is the one in mm/s2 and the other in mm/min?"
            ]
        );
        let w = told("[30, 30, 30]", "[30, 30, 54000]");
        assert!(
            w.len() == 1 && w[0].contains("axis Z: 54000 mm/s2 is more than 3 g"),
            "{w:?}"
        );
        let w = told("[800, 800, 800]", "[800, 8000, 800]");
        assert!(
            w.len() == 1
                && w[0].contains(
                    ":11:1: warning: steps_per_mm: axis Y at its fastest asks for 213333 steps/s"
                )
                && w[0].ends_with("look at $101 and $111"),
            "{w:?}"
        );
        let w = told("[0, 10000]", "[0, 240000]");
        assert!(
            w.len() == 1 && w[0].contains("240000 rpm is more than any mill turns"),
            "{w:?}"
        );
        let w = told("[284, 180, 40]", "[11.2, 180, 40]");
        assert_eq!(
            w,
            [
                "m.toml:8:1: warning: travel_mm: axis X goes 11.2 mm: is it in mm, and not in inches or metres?"
            ]
        );
        let w = told("post = \"grbl\"", "post = \"fanuc\"");
        assert_eq!(
            w,
            [
                "m.toml:7:1: warning: post: the controller is GRBL 1.1, and the post writes for Fanuc: they seldom understand each other"
            ]
        );
        assert_eq!(
            told("post = \"grbl\"", "post = \"fluidnc\""),
            Vec::<String>::new()
        );
    }

    #[test]
    fn a_key_that_cannot_be_found_has_no_place() {
        assert_eq!(
            at("m.toml", "\"post\" = \"x\"\n", "post", "is odd"),
            "m.toml: warning: post: is odd"
        );
        assert_eq!(
            at("m.toml", "a = 1\n  post= 2\n", "post", "is odd"),
            "m.toml:2:3: warning: post: is odd"
        );
    }
}
