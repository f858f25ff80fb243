//! Machine files: what is read, what is refused, and with which words.
#![allow(clippy::unwrap_used)]
use super::*;
use crate::machine::data::DataError;

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
        .filter(|f| f != "schema.json")
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
        e.starts_with("machines/test.toml:4:19: ")
            && e.ends_with("travel_mm: \"wide\" is not a number: write it without quotes"),
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
    assert!(
        e.contains(
            "controller = \"gbrl\": must be one of grbl, grblhal, fluidnc, linuxcnc, pathpilot, "
        ) && e.ends_with("carbide (did you mean \"grbl\"?)"),
        "{e}"
    );
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
    assert!(e.starts_with("machine \"longmil\" is not known (did you mean \"longmill-30x30\"?); there are acroloc-s10-centroid, altmill-4x4, "), "{e}");
    assert!(
        e.ends_with("a file of your own is named by its path, e.g. ./longmil.toml"),
        "{e}"
    );
}

/// A machine tool's own control: what only GRBL knows is left out.
const CABINET: &str = r#"title = "Test"
controller = "haas"
post = "haas"
travel_mm = [762, 406, 508]
max_rate_mm_per_min = [25400, 25400, 25400]
max_feed_mm_per_min = 16500
acceleration_mm_per_s2 = [2000, 2000, 2000]
spindle_rpm = [60, 8100]
"#;

fn complaint(text: &str) -> String {
    Machine::from_toml("test", text).unwrap_err().to_string()
}

#[test]
fn a_cabinet_leaves_out_what_it_does_not_tell_and_may_not_give_it() {
    let m = Machine::from_toml("test", CABINET).unwrap();
    assert_eq!(m.stand_ins, family::OPTIONAL_KEYS);
    assert_eq!(m.max_feed, Some(MmPerMin(16_500.0)));
    assert_eq!(
        (m.baud, m.planner_blocks),
        (0, family::STAND_IN.planner_blocks)
    );
    assert!(!m.speaks_grbl());
    let m = Machine::from_toml("test", &format!("{CABINET}planner_blocks = 80\n")).unwrap();
    assert_eq!(m.planner_blocks, 80);
    assert!(!m.stand_ins.contains(&"planner_blocks"));
    for line in [
        "steps_per_mm = [1, 1, 1]",
        "junction_deviation_mm = 0.01",
        "baud = 0",
        "rx_buffer_bytes = 100",
    ] {
        let e = complaint(&format!("{CABINET}{line}\n"));
        assert!(
            e.starts_with("machines/test.toml:9:")
                && e.contains("Haas does not tell such a figure: leave the line out"),
            "{e}"
        );
    }
    let e = complaint(&CABINET.replace("16500", "30000"));
    assert!(
        e.contains(
            "6:23: max_feed_mm_per_min = 30000: is faster than any axis goes (25400 mm/min)"
        ),
        "{e}"
    );
}

#[test]
fn each_family_asks_for_its_own_figures() {
    let of = |name: &str| CABINET.replace("\"haas\"", &format!("\"{name}\""));
    for f in &family::FAMILIES {
        let result = Machine::from_toml("test", &of(f.name));
        match f.kind {
            family::Kind::Grbl => {
                let e = result.unwrap_err().to_string();
                assert_eq!(e.lines().count(), family::OPTIONAL_KEYS.len(), "{e}");
                for key in family::OPTIONAL_KEYS {
                    assert!(e.contains(&format!("\"{key}\" is missing: add it")), "{e}");
                }
            }
            family::Kind::Firmware => {
                let e = result.unwrap_err().to_string();
                assert_eq!(
                    e,
                    "machines/test.toml:1:1: \"steps_per_mm\" is missing: add it (the files in machines/ show how)"
                );
                let text = format!(
                    "{}steps_per_mm = [100, 100, 400]\nbaud = 115200\n",
                    of(f.name)
                );
                assert_eq!(Machine::from_toml("test", &text).unwrap().baud, 115_200);
                let e = complaint(&text.replace("115200", "9"));
                assert!(
                    e.contains("is no serial speed: 115200 is usual, 0 when programs are files"),
                    "{e}"
                );
            }
            family::Kind::Computer => {
                assert_eq!(
                    result.unwrap().steps_per_mm,
                    [family::STAND_IN.steps_per_mm; 3]
                );
                let e = complaint(&format!("{}baud = 115200\n", of(f.name)));
                assert!(
                    e.contains("this controller reads files: write 0, or leave the line out"),
                    "{e}"
                );
            }
            family::Kind::Cabinet => assert!(result.is_ok()),
        }
    }
}
