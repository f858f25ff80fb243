//! The machine file: its keys, units in their names, and the bounds of every figure.

use super::data::{Bounds, DataError, Reader};
use super::family::{CONTROLLERS, Family, Kind, Need, OPTIONAL_KEYS, STAND_IN, need};
use super::row::Row;
use super::{IDLE_DELAY, Machine};
use crate::units::{Mm, MmPerMin, MmPerSec2, Rpm};
use serde::Deserialize;
use toml::Spanned;

/// The file as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: Spanned<String>,
    controller: Spanned<String>,
    post: Spanned<String>,
    travel_mm: Row<3>,
    max_rate_mm_per_min: Row<3>,
    max_feed_mm_per_min: Option<Spanned<f64>>,
    acceleration_mm_per_s2: Row<3>,
    steps_per_mm: Option<Spanned<Row<3>>>,
    junction_deviation_mm: Option<Spanned<f64>>,
    arc_tolerance_mm: Option<Spanned<f64>>,
    planner_blocks: Option<Spanned<f64>>,
    rx_buffer_bytes: Option<Spanned<f64>>,
    spindle_rpm: Row<2>,
    baud: Option<Spanned<f64>>,
}

const fn above_zero(max: f64) -> Bounds {
    Bounds {
        min: 0.0,
        max,
        above_min: true,
    }
}

const fn from(min: f64, max: f64) -> Bounds {
    Bounds {
        min,
        max,
        above_min: false,
    }
}

/// Reads a machine called `name`; complaints call the text `file`.
pub(super) fn read(name: &str, file: &str, text: &str) -> Result<Machine, DataError> {
    let mut r = Reader::new(file, text, "machines");
    let f: File = r.parse()?;
    let title = filled(
        &mut r,
        "title",
        &f.title,
        "must say what people call the machine",
    );
    let controller = r.word("controller", &f.controller, &CONTROLLERS);
    let family = Family::of(&controller);
    let post = filled(
        &mut r,
        "post",
        &f.post,
        "must name a dialect, e.g. \"grbl\"",
    );
    let stand_ins = whats_there(&mut r, &f, family);
    let travel = f.travel_mm.0.each_ref().map(|v| {
        let advice = "write how far this axis can go ($130, $131, $132)";
        Mm(r.figure("travel_mm", v, above_zero(20_000.0), "mm", advice))
    });
    let rate = above_zero(200_000.0);
    let max_rate = f.max_rate_mm_per_min.0.each_ref().map(|v| {
        let advice = "write the axis's fastest speed per minute ($110, $111, $112)";
        MmPerMin(r.figure("max_rate_mm_per_min", v, rate, "mm/min", advice))
    });
    let max_feed = f.max_feed_mm_per_min.as_ref().map(|v| {
        let advice = "write the fastest cutting feed, or leave the line out";
        let feed = r.figure("max_feed_mm_per_min", v, rate, "mm/min", advice);
        let fastest = max_rate.iter().fold(0.0, |m: f64, r| m.max(r.0));
        if feed > fastest {
            let problem = format!(
                "is faster than any axis goes ({fastest} mm/min): a cutting feed is at most the rapid traverse"
            );
            r.complain("max_feed_mm_per_min", v, feed.to_string(), problem);
        }
        MmPerMin(feed)
    });
    let acceleration = f.acceleration_mm_per_s2.0.each_ref().map(|v| {
        let advice = "write the axis's acceleration ($120, $121, $122)";
        let bounds = above_zero(100_000.0);
        MmPerSec2(r.figure("acceleration_mm_per_s2", v, bounds, "mm/s2", advice))
    });
    let steps_per_mm = match &f.steps_per_mm {
        None => [STAND_IN.steps_per_mm; 3],
        Some(steps) => steps.get_ref().0.each_ref().map(|v| {
            let advice = "write the steps of one mm ($100, $101, $102)";
            r.figure("steps_per_mm", v, above_zero(1_000_000.0), "", advice)
        }),
    };
    let mut small = |key, value: &Option<Spanned<f64>>, stand_in, advice| {
        Mm(value.as_ref().map_or(stand_in, |v| {
            r.figure(key, v, above_zero(1.0), "mm", advice)
        }))
    };
    let junction_deviation = small(
        "junction_deviation_mm",
        &f.junction_deviation_mm,
        STAND_IN.junction_deviation,
        "0.01 is usual ($11)",
    );
    let arc_tolerance = small(
        "arc_tolerance_mm",
        &f.arc_tolerance_mm,
        STAND_IN.arc_tolerance,
        "0.002 is usual ($12)",
    );
    let planner_blocks = f
        .planner_blocks
        .as_ref()
        .map_or(STAND_IN.planner_blocks, |v| {
            let advice = "GRBL holds 15, grblHAL 100";
            whole(&mut r, "planner_blocks", v, from(1.0, 100_000.0), advice)
        });
    let rx_buffer = f.rx_buffer_bytes.as_ref().map_or(STAND_IN.rx_buffer, |v| {
        let advice = "GRBL has 128, grblHAL 1024";
        whole(
            &mut r,
            "rx_buffer_bytes",
            v,
            from(16.0, 16_777_216.0),
            advice,
        )
    });
    let spindle = spindle(&mut r, &f.spindle_rpm.0);
    let baud = baud(&mut r, f.baud.as_ref(), family);
    r.finish(Machine {
        name: name.to_string(),
        title,
        controller,
        post,
        travel,
        max_rate,
        max_feed,
        acceleration,
        steps_per_mm,
        junction_deviation,
        arc_tolerance,
        planner_blocks,
        idle_delay: IDLE_DELAY,
        rx_buffer,
        spindle,
        baud,
        stand_ins,
    })
}

fn filled(r: &mut Reader<'_>, key: &str, value: &Spanned<String>, problem: &str) -> String {
    let text = value.get_ref().trim().to_string();
    if text.is_empty() {
        r.complain(key, value, "\"\"".into(), problem);
    }
    text
}

/// Complains of keys that this family must have and has not, or has and cannot have. Returns the keys left out.
fn whats_there(r: &mut Reader<'_>, f: &File, family: Option<&Family>) -> Vec<&'static str> {
    let given = [
        f.steps_per_mm.as_ref().map(Spanned::span),
        f.junction_deviation_mm.as_ref().map(Spanned::span),
        f.arc_tolerance_mm.as_ref().map(Spanned::span),
        f.planner_blocks.as_ref().map(Spanned::span),
        f.rx_buffer_bytes.as_ref().map(Spanned::span),
        f.baud.as_ref().map(Spanned::span),
    ];
    let mut left_out = Vec::new();
    for (key, span) in OPTIONAL_KEYS.into_iter().zip(given) {
        // An unknown family has been complained about.
        let needed = family.map_or(Need::May, |f| need(f.kind, key));
        match (needed, span) {
            (Need::Must, None) => r.complaints.push(DataError::Missing {
                at: r.place(0),
                key: key.to_string(),
                folder: r.folder.to_string(),
            }),
            (Need::Never, Some(span)) => {
                let value = r.text.get(span.clone()).unwrap_or_default().to_string();
                let title = family.map_or("", |f| f.title);
                r.complaints.push(DataError::Value {
                    at: r.place(span.start),
                    key: key.to_string(),
                    value,
                    problem: format!(
                        "{title} does not tell such a figure: leave the line out (a stand-in serves for time estimates)"
                    ),
                });
            }
            (_, None) => left_out.push(key),
            _ => {}
        }
    }
    left_out
}

fn spindle(r: &mut Reader<'_>, value: &[Spanned<f64>; 2]) -> [Rpm; 2] {
    let spindle = value.each_ref().map(|v| {
        let advice = "write the lowest and the highest speed ($31, $30)";
        Rpm(r.figure("spindle_rpm", v, from(0.0, 500_000.0), "rpm", advice))
    });
    if spindle[1] <= spindle[0] {
        let shown = format!("[{}, {}]", spindle[0].0, spindle[1].0);
        let problem =
            "the second speed must be above the first: write the lowest, then the highest";
        r.complain("spindle_rpm", &value[1], shown, problem);
    }
    spindle
}

fn baud(r: &mut Reader<'_>, value: Option<&Spanned<f64>>, family: Option<&Family>) -> u32 {
    let Some(value) = value else {
        return STAND_IN.baud;
    };
    let advice = "GRBL talks at 115200";
    let baud = whole(r, "baud", value, from(0.0, 20_000_000.0), advice);
    let problem = match family.map(|f| f.kind) {
        Some(Kind::Computer) if baud != 0 => {
            Some("this controller reads files: write 0, or leave the line out")
        }
        Some(Kind::Grbl) | None if baud < 300 => Some(
            "is no serial speed: GRBL talks at 115200 (0 is for controllers that are not fed over a serial line, LinuxCNC and the like)",
        ),
        Some(Kind::Firmware) if baud != 0 && baud < 300 => {
            Some("is no serial speed: 115200 is usual, 0 when programs are files")
        }
        _ => None,
    };
    if let Some(problem) = problem {
        r.complain("baud", value, baud.to_string(), problem);
    }
    // Within the bounds above, so the conversion keeps the value; otherwise there is a complaint and no machine.
    u32::try_from(baud).unwrap_or(0)
}

/// A whole number within bounds. Read as a float so that `15.5`, `-1` and `1e30` all get the same plain complaint.
fn whole(
    r: &mut Reader<'_>,
    key: &str,
    value: &Spanned<f64>,
    bounds: Bounds,
    advice: &str,
) -> usize {
    let before = r.complaints.len();
    let v = r.figure(key, value, bounds, "", advice);
    if r.complaints.len() > before {
        return 0;
    }
    if v.fract() != 0.0 {
        let problem = format!("must be a whole number: {advice}");
        r.complain(key, value, format!("{v}"), problem);
    }
    v as usize
}
