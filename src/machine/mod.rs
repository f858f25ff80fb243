//! A machine as data: `machines/*.toml` read once into a checked [`Machine`].
//!
//! Crosses the border: the text of a machine file in; travels in mm, rates in mm/min, accelerations in mm/s², all checked, out.
//! Never knows parts, paths or dialects (a machine names its dialect, it does not open it).

pub mod data;
pub mod search;

pub use data::{DataError, Place};

use crate::units::{Mm, MmPerMin, MmPerSec2, Rpm};
use data::{Bounds, Reader};
use serde::Deserialize;
use toml::Spanned;

/// A 3-axis machine. Every figure is finite and above zero unless said otherwise. Arrays are X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// File name without `.toml`.
    pub name: String,
    /// What people call it.
    pub title: String,
    /// Controller family: `grbl`, `grblhal`, `fluidnc`, `linuxcnc`.
    pub controller: String,
    /// Default dialect: the name of a file in `posts/`.
    pub post: String,
    /// Travel of each axis.
    pub travel: [Mm; 3],
    /// Highest speed of each axis ($110..).
    pub max_rate: [MmPerMin; 3],
    /// Acceleration of each axis ($120..).
    pub acceleration: [MmPerSec2; 3],
    /// Steps per mm of each axis ($100..).
    pub steps_per_mm: [f64; 3],
    /// GRBL's cornering measure ($11).
    pub junction_deviation: Mm,
    /// GRBL's arc tolerance ($12).
    pub arc_tolerance: Mm,
    /// Blocks of look-ahead the planner can hold (GRBL: 15 usable).
    pub planner_blocks: usize,
    /// Bytes of receive buffer (GRBL: 128).
    pub rx_buffer: usize,
    /// Lowest and highest spindle speed; zero lowest is allowed.
    pub spindle: [Rpm; 2],
    /// Serial speed, baud; zero for a controller that is not fed over a serial line (LinuxCNC).
    pub baud: u32,
}

/// The machine used when none is named: a mid-size router whose maker publishes every figure.
pub const DEFAULT_MACHINE: &str = "longmill-30x30";

/// Controller families.
pub const CONTROLLERS: [&str; 4] = ["grbl", "grblhal", "fluidnc", "linuxcnc"];

/// The machines that come with the program: name and text of each file in `machines/`, by rising name.
pub const BUILT_IN: [(&str, &str); 8] = [
    (
        "altmill-4x4",
        include_str!("../../machines/altmill-4x4.toml"),
    ),
    ("grbl-3018", include_str!("../../machines/grbl-3018.toml")),
    (
        "longmill-30x30",
        include_str!("../../machines/longmill-30x30.toml"),
    ),
    (
        "shapeoko-3-xxl",
        include_str!("../../machines/shapeoko-3-xxl.toml"),
    ),
    (
        "sherline-5400",
        include_str!("../../machines/sherline-5400.toml"),
    ),
    (
        "tormach-pcnc440",
        include_str!("../../machines/tormach-pcnc440.toml"),
    ),
    (
        "workbee-1010",
        include_str!("../../machines/workbee-1010.toml"),
    ),
    (
        "x-carve-1000",
        include_str!("../../machines/x-carve-1000.toml"),
    ),
];

/// The file as written, units in the names.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: Spanned<String>,
    controller: Spanned<String>,
    post: Spanned<String>,
    travel_mm: [Spanned<f64>; 3],
    max_rate_mm_per_min: [Spanned<f64>; 3],
    acceleration_mm_per_s2: [Spanned<f64>; 3],
    steps_per_mm: [Spanned<f64>; 3],
    junction_deviation_mm: Spanned<f64>,
    arc_tolerance_mm: Spanned<f64>,
    planner_blocks: Spanned<f64>,
    rx_buffer_bytes: Spanned<f64>,
    spindle_rpm: [Spanned<f64>; 2],
    baud: Spanned<f64>,
}

const fn above_zero(max: f64) -> Bounds {
    Bounds {
        min: 0.0,
        max,
        above_min: true,
    }
}

impl Machine {
    /// Reads and checks a machine file called `name`. Unknown keys, missing keys and figures no machine has are refused, each with
    /// its line and column; every wrong figure is reported, not only the first.
    pub fn from_toml(name: &str, text: &str) -> Result<Machine, DataError> {
        Machine::read(name, &format!("machines/{name}.toml"), text)
    }

    /// A built-in machine by name, or a machine file by path (anything with a `/`, or ending in `.toml`).
    pub fn load(name_or_path: &str) -> Result<Machine, DataError> {
        let (name, file, text) = data::find("machine", "machines", &BUILT_IN, name_or_path)?;
        Machine::read(&name, &file, &text)
    }

    fn read(name: &str, file: &str, text: &str) -> Result<Machine, DataError> {
        let mut r = Reader::new(file, text, "machines");
        let f: File = r.parse()?;
        let title = f.title.get_ref().trim().to_string();
        if title.is_empty() {
            r.complain(
                "title",
                &f.title,
                "\"\"".into(),
                "must say what people call the machine",
            );
        }
        let controller = r.word("controller", &f.controller, &CONTROLLERS);
        let post = f.post.get_ref().trim().to_string();
        if post.is_empty() {
            r.complain(
                "post",
                &f.post,
                "\"\"".into(),
                "must name a dialect, e.g. \"grbl\"",
            );
        }
        let travel = f.travel_mm.each_ref().map(|v| {
            let advice = "write how far this axis can go ($130, $131, $132)";
            Mm(r.figure("travel_mm", v, above_zero(20_000.0), "mm", advice))
        });
        let max_rate = f.max_rate_mm_per_min.each_ref().map(|v| {
            let advice = "write the axis's fastest speed per minute ($110, $111, $112)";
            MmPerMin(r.figure(
                "max_rate_mm_per_min",
                v,
                above_zero(200_000.0),
                "mm/min",
                advice,
            ))
        });
        let acceleration = f.acceleration_mm_per_s2.each_ref().map(|v| {
            let advice = "write the axis's acceleration ($120, $121, $122)";
            MmPerSec2(r.figure(
                "acceleration_mm_per_s2",
                v,
                above_zero(100_000.0),
                "mm/s2",
                advice,
            ))
        });
        let steps_per_mm = f.steps_per_mm.each_ref().map(|v| {
            let advice = "write the steps of one mm ($100, $101, $102)";
            r.figure("steps_per_mm", v, above_zero(1_000_000.0), "", advice)
        });
        let small = above_zero(1.0);
        let junction_deviation = Mm(r.figure(
            "junction_deviation_mm",
            &f.junction_deviation_mm,
            small,
            "mm",
            "0.01 is usual ($11)",
        ));
        let arc_tolerance = Mm(r.figure(
            "arc_tolerance_mm",
            &f.arc_tolerance_mm,
            small,
            "mm",
            "0.002 is usual ($12)",
        ));
        let planner_blocks = whole(
            &mut r,
            "planner_blocks",
            &f.planner_blocks,
            [1.0, 100_000.0],
            "GRBL holds 15, grblHAL 100",
        );
        let rx_buffer = whole(
            &mut r,
            "rx_buffer_bytes",
            &f.rx_buffer_bytes,
            [16.0, 16_777_216.0],
            "GRBL has 128, grblHAL 1024",
        );
        let spindle = f.spindle_rpm.each_ref().map(|v| {
            let b = Bounds {
                min: 0.0,
                max: 500_000.0,
                above_min: false,
            };
            Rpm(r.figure(
                "spindle_rpm",
                v,
                b,
                "rpm",
                "write the lowest and the highest speed ($31, $30)",
            ))
        });
        if spindle[1] <= spindle[0] {
            let shown = format!("[{}, {}]", spindle[0].0, spindle[1].0);
            let problem =
                "the second speed must be above the first: write the lowest, then the highest";
            r.complain("spindle_rpm", &f.spindle_rpm[1], shown, problem);
        }
        let baud = whole(
            &mut r,
            "baud",
            &f.baud,
            [0.0, 20_000_000.0],
            "GRBL talks at 115200",
        );
        if baud < 300 && (baud != 0 || controller != "linuxcnc") {
            let problem = "is no serial speed: GRBL talks at 115200 (0 is for LinuxCNC only, which has no serial line)";
            r.complain("baud", &f.baud, baud.to_string(), problem);
        }
        r.finish(Machine {
            name: name.to_string(),
            title,
            controller,
            post,
            travel,
            max_rate,
            acceleration,
            steps_per_mm,
            junction_deviation,
            arc_tolerance,
            planner_blocks,
            rx_buffer,
            spindle,
            // Within the bounds above, so the conversion keeps the value; otherwise there is a complaint and no machine.
            baud: u32::try_from(baud).unwrap_or(0),
        })
    }
}

/// A whole number within bounds. Read as a float so that `15.5`, `-1` and `1e30` all get the same plain complaint.
fn whole(
    r: &mut Reader<'_>,
    key: &str,
    value: &Spanned<f64>,
    [min, max]: [f64; 2],
    advice: &str,
) -> usize {
    let b = Bounds {
        min,
        max,
        above_min: false,
    };
    let before = r.complaints.len();
    let v = r.figure(key, value, b, "", advice);
    if r.complaints.len() > before {
        return 0;
    }
    if v.fract() != 0.0 {
        r.complain(
            key,
            value,
            format!("{v}"),
            format!("must be a whole number: {advice}"),
        );
    }
    v as usize
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const GOOD: &str = r#"title = "Test"
controller = "grbl"
post = "grbl"
travel_mm = [300, 180.5, 45]
max_rate_mm_per_min = [2000, 2000, 1000]
acceleration_mm_per_s2 = [100, 100, 50]
steps_per_mm = [800, 800, 800]
junction_deviation_mm = 0.01
arc_tolerance_mm = 0.002
planner_blocks = 15
rx_buffer_bytes = 128
spindle_rpm = [0, 10000]
baud = 115200
"#;

    fn refusal(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from), "{from}");
        Machine::from_toml("test", &GOOD.replace(from, to))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn reads_a_machine() {
        let m = Machine::from_toml("test", GOOD).unwrap();
        assert_eq!(m.name, "test");
        assert_eq!(m.travel, [Mm(300.0), Mm(180.5), Mm(45.0)]);
        assert_eq!(m.max_rate[2], MmPerMin(1000.0));
        assert_eq!(m.acceleration[2], MmPerSec2(50.0));
        assert_eq!((m.planner_blocks, m.rx_buffer, m.baud), (15, 128, 115_200));
        assert_eq!(m.spindle, [Rpm(0.0), Rpm(10_000.0)]);
    }

    #[test]
    fn every_shipped_machine_is_built_in_and_loads() {
        let dir = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
        let mut files: Vec<String> = std::fs::read_dir(&dir)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        let built_in: Vec<String> = BUILT_IN.iter().map(|(n, _)| format!("{n}.toml")).collect();
        assert_eq!(files, built_in, "machines/ and BUILT_IN differ");
        for (name, text) in BUILT_IN {
            let m = Machine::load(name).unwrap();
            assert_eq!(m, Machine::from_toml(name, text).unwrap());
            let path = dir.join(format!("{name}.toml"));
            assert_eq!(m, Machine::load(path.to_str().unwrap()).unwrap());
            assert_eq!(m.name, name);
            // A source stands beside each figure.
            for line in text
                .lines()
                .filter(|l| l.contains(" = ") && !l.starts_with(['#', 't', 'c', 'p']))
            {
                assert!(line.contains('#'), "{name}: no source: {line}");
            }
        }
    }

    #[test]
    fn the_default_machine_holds_a_common_part() {
        let m = Machine::load(DEFAULT_MACHINE).unwrap();
        for (travel, part) in m.travel.iter().zip([65.0, 65.0, 40.0]) {
            assert!(travel.0 > part + 60.0);
        }
    }

    #[test]
    fn unknown_keys_are_refused_with_place_and_neighbour() {
        let e = refusal("baud = 115200", "bawd = 115200");
        assert!(e.starts_with("machines/test.toml:13:1: unknown key \"bawd\" (did you mean \"baud\"?); the keys here are title, "), "{e}");
        let e = refusal("travel_mm", "travel");
        assert!(
            e.contains(":4:1: unknown key \"travel\" (did you mean \"travel_mm\"?)"),
            "{e}"
        );
    }

    #[test]
    fn missing_keys_and_wrong_kinds_are_refused() {
        let e = refusal("baud = 115200\n", "");
        assert!(e.contains("\"baud\" is missing: add it"), "{e}");
        let e = refusal("[300, 180.5, 45]", "[300, 180.5]");
        assert!(e.starts_with("machines/test.toml:4:"), "{e}");
        let e = refusal("[300, 180.5, 45]", "[300, \"wide\", 45]");
        assert!(
            e.starts_with("machines/test.toml:4:19: ") && e.contains("expected a number"),
            "{e}"
        );
        let e = refusal("post = \"grbl\"", "post = ");
        assert!(e.starts_with("machines/test.toml:3:"), "{e}");
    }

    #[test]
    fn every_figure_is_checked() {
        for bad in ["0", "-1", "nan", "inf", "-inf", "1e300"] {
            for key in [
                "[300, ",
                "[2000, 2000, 1000",
                "[100, ",
                "[800, 800, ",
                "0.01",
                "0.002",
            ] {
                let digits = key
                    .trim_start_matches('[')
                    .split(',')
                    .next()
                    .unwrap()
                    .to_string();
                let e = refusal(key, &key.replacen(&digits, bad, 1));
                assert!(
                    e.contains("must be above 0 and at most"),
                    "{key} {bad}: {e}"
                );
            }
        }
        for bad in ["0", "-3", "15.5", "nan", "1e30"] {
            let e = refusal("planner_blocks = 15", &format!("planner_blocks = {bad}"));
            assert!(
                e.starts_with("machines/test.toml:10:18: planner_blocks = "),
                "{e}"
            );
        }
        let e = refusal("[300, 180.5, 45]", "[300, 0, 45]");
        assert_eq!(
            e,
            "machines/test.toml:4:19: travel_mm = 0: must be above 0 and at most 20000 mm: write how far this axis can go ($130, $131, $132)"
        );
        let e = refusal("[0, 10000]", "[10000, 0]");
        assert!(
            e.contains("the second speed must be above the first"),
            "{e}"
        );
        let e = refusal("baud = 115200", "baud = 0");
        assert!(e.contains("is no serial speed"), "{e}");
        let e = refusal("controller = \"grbl\"", "controller = \"gbrl\"");
        assert!(e.contains("controller = \"gbrl\": must be one of grbl, grblhal, fluidnc, linuxcnc (did you mean \"grbl\"?)"), "{e}");
    }

    #[test]
    fn all_complaints_come_at_once() {
        let text = GOOD.replace("[300, ", "[0, ").replace("0.002", "-1");
        let e = Machine::from_toml("test", &text).unwrap_err();
        assert!(matches!(&e, DataError::Several(v) if v.len() == 2), "{e}");
        assert_eq!(e.to_string().lines().count(), 2);
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let e = Machine::load("longmil").unwrap_err().to_string();
        assert!(e.starts_with("machine \"longmil\" is not known (did you mean \"longmill-30x30\"?); there are altmill-4x4, grbl-3018, "), "{e}");
        assert!(
            e.ends_with("a file of your own is named by its path, e.g. ./longmil.toml"),
            "{e}"
        );
    }
}
