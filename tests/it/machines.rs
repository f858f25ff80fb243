//! The machine files as a whole: their sanity, their posts, and the JSON schema that editors use.
#![allow(clippy::unwrap_used)]

use morsemill::gcode::Dialect;
use morsemill::machine::data::DataError;
use morsemill::machine::family::{FAMILIES, Kind};
use morsemill::machine::{BUILT_IN, CONTROLLERS, Machine};
use morsemill::simulate::{DryRunOptions, Kind as FaultKind, Stock, dry_run};
use serde_json::Value;

fn machines() -> Vec<Machine> {
    BUILT_IN
        .iter()
        .map(|(name, text)| Machine::from_toml(name, text).unwrap())
        .collect()
}

#[test]
fn there_are_enough_of_them_across_the_controllers() {
    let machines = machines();
    assert!(machines.len() >= 24, "{}", machines.len());
    let without: Vec<&str> = CONTROLLERS
        .into_iter()
        .filter(|c| !machines.iter().any(|m| m.controller == *c))
        .collect();
    assert_eq!(without, Vec::<&str>::new(), "every family has a machine");
    let titles: std::collections::BTreeSet<&str> =
        machines.iter().map(|m| m.title.as_str()).collect();
    assert_eq!(
        titles.len(),
        machines.len(),
        "two machines are called the same"
    );
}

#[test]
fn every_machine_names_the_post_of_a_family_that_suits_it() {
    for m in machines() {
        // A family's name is its post's.
        assert!(
            CONTROLLERS.contains(&m.post.as_str()),
            "{}: post {}",
            m.name,
            m.post
        );
        let grbl = |name: &str| {
            FAMILIES
                .iter()
                .any(|f| f.name == name && f.kind == Kind::Grbl)
        };
        assert!(
            m.post == m.controller || (grbl(&m.post) && grbl(&m.controller)),
            "{}: post {}",
            m.name,
            m.post
        );
    }
}

/// What is true of every mill and router ever built for sale, by the class of its control.
#[test]
fn figures_are_those_of_real_machines() {
    for m in machines() {
        let name = &m.name;
        let kind = m.family().unwrap().kind;
        let cabinet = kind == Kind::Cabinet;
        let (slowest, fastest) = if cabinet {
            (5_000.0, 120_000.0)
        } else {
            (100.0, 30_000.0)
        };
        let (gentlest, sharpest) = if cabinet {
            (500.0, 20_000.0)
        } else {
            (10.0, 5_000.0)
        };
        for i in 0..3 {
            assert!(
                (40.0..=3000.0).contains(&m.travel[i].0),
                "{name}: travel {:?}",
                m.travel[i]
            );
            assert!(
                (slowest..=fastest).contains(&m.max_rate[i].0),
                "{name}: rate {:?}",
                m.max_rate[i]
            );
            assert!(
                (gentlest..=sharpest).contains(&m.acceleration[i].0),
                "{name}: acceleration {:?}",
                m.acceleration[i]
            );
            assert!(
                (10.0..=5_000.0).contains(&m.steps_per_mm[i]),
                "{name}: steps {}",
                m.steps_per_mm[i]
            );
        }
        assert!(
            m.max_rate[2].0 <= m.max_rate[0].0.max(m.max_rate[1].0),
            "{name}: Z is faster than X and Y"
        );
        assert!(
            m.acceleration[2].0 <= m.acceleration[0].0.max(m.acceleration[1].0),
            "{name}: Z is livelier than X and Y"
        );
        if let Some(feed) = m.max_feed {
            assert!(
                m.max_rate.iter().any(|r| r.0 >= feed.0),
                "{name}: cuts faster than it goes"
            );
        }
        assert!(
            (1_000.0..=60_000.0).contains(&m.spindle[1].0),
            "{name}: spindle {:?}",
            m.spindle
        );
        assert!(m.spindle[0].0 < m.spindle[1].0, "{name}");
        assert!((0.005..=0.1).contains(&m.junction_deviation.0), "{name}");
        assert!((0.001..=0.01).contains(&m.arc_tolerance.0), "{name}");
        assert!((10..=200).contains(&m.planner_blocks), "{name}");
        match kind {
            Kind::Grbl => assert!(m.baud >= 115_200, "{name}"),
            Kind::Firmware => assert!(m.baud == 0 || m.baud >= 115_200, "{name}"),
            Kind::Computer | Kind::Cabinet => assert_eq!(m.baud, 0, "{name}"),
        }
    }
}

/// A cutting feed above the maker's is told, the rapid traverse above it is not.
#[test]
fn feeds_above_the_makers_cutting_feed_are_told() {
    let m = Machine::load("haas-vf-2").unwrap();
    let told = |feed: f64| -> Vec<String> {
        let text = format!("M3 S1000\nG0 Z5\nG0 X1 Y1\nG1 X50 F{feed}\nG1 X60 Y10\n");
        let options = DryRunOptions::new(0.02, Stock::Allowance(0.5));
        let report = dry_run(&text, Dialect::Grbl, &m, None, &options);
        let feeds = report
            .warnings
            .into_iter()
            .filter(|w| w.kind == FaultKind::Feed);
        feeds.map(|w| w.text).collect()
    };
    assert_eq!(told(16_500.0), Vec::<String>::new());
    assert_eq!(
        told(20_000.0),
        [
            "2 moves ask for more feed than haas-vf-2 cuts at, the first for 20000 mm/min (it does 16500): its control slows them or stops with an alarm"
        ]
    );
}

/// Where a machine file's figures come from stands in it.
#[test]
fn every_file_names_its_sources_and_says_what_it_assumes() {
    for (name, text) in BUILT_IN {
        assert!(text.contains("# Sources: "), "{name}");
        for line in text
            .lines()
            .filter(|l| l.contains("_mm") || l.starts_with("spindle"))
            .filter(|l| !l.starts_with('#'))
        {
            let (_, source) = line
                .split_once('#')
                .unwrap_or_else(|| panic!("{name}: no source: {line}"));
            assert!(source.trim().len() >= 4, "{name}: no source: {line}");
        }
        if text.contains("# assumed") || text.contains("; lowest assumed") {
            assert!(
                text.contains("chosen low") || text.contains("lowest assumed"),
                "{name}: why that figure?"
            );
        }
    }
}

fn schema() -> Value {
    serde_json::from_str(include_str!("../../machines/schema.json")).unwrap()
}

fn strings(v: &Value) -> Vec<&str> {
    v.as_array()
        .unwrap()
        .iter()
        .map(|s| s.as_str().unwrap())
        .collect()
}

/// A file of `controller` with every key in `extra`.
fn file(controller: &str, extra: &[(&str, &str)]) -> String {
    let base = format!(
        "title = \"T\"\ncontroller = \"{controller}\"\npost = \"grbl\"\ntravel_mm = [300, 300, 100]\nmax_rate_mm_per_min = [200000, 5, 5]\nacceleration_mm_per_s2 = [5, 5, 5]\nspindle_rpm = [0, 1000]\n"
    );
    extra.iter().fold(base, |text, (key, value)| {
        let kept: String = text
            .lines()
            .filter(|l| !l.starts_with(&format!("{key} =")))
            .map(|l| format!("{l}\n"))
            .collect();
        format!("{kept}{key} = {value}\n")
    })
}

const GOOD: [(&str, &str); 6] = [
    ("steps_per_mm", "[80, 80, 80]"),
    ("junction_deviation_mm", "0.01"),
    ("arc_tolerance_mm", "0.01"),
    ("planner_blocks", "15"),
    ("rx_buffer_bytes", "128"),
    ("baud", "115200"),
];

#[test]
fn the_schema_has_the_keys_and_families_of_the_program() {
    let schema = schema();
    let e = Machine::from_toml("x", "nonsense = 1\n").unwrap_err();
    let DataError::UnknownKey { mut known, .. } = e else {
        panic!("{e}")
    };
    let mut keys: Vec<String> = schema["properties"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    known.sort();
    keys.sort();
    assert_eq!(keys, known);
    assert_eq!(
        strings(&schema["properties"]["controller"]["enum"]),
        CONTROLLERS
    );
    let families: Vec<&str> = schema["allOf"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|rule| strings(&rule["if"]["properties"]["controller"]["enum"]))
        .collect();
    assert_eq!(
        families.len(),
        CONTROLLERS.len(),
        "each family stands under one rule"
    );
    for rule in schema["allOf"].as_array().unwrap() {
        let then = &rule["then"];
        let must = then.get("required").map(strings).unwrap_or_default();
        let never: Vec<&String> = then
            .get("properties")
            .and_then(Value::as_object)
            .into_iter()
            .flatten()
            .filter(|(_, v)| **v == Value::Bool(false))
            .map(|(k, _)| k)
            .collect();
        for controller in strings(&rule["if"]["properties"]["controller"]["enum"]) {
            let good: Vec<(&str, &str)> =
                GOOD.into_iter().filter(|(k, _)| must.contains(k)).collect();
            let read = Machine::from_toml("x", &file(controller, &good));
            assert!(read.is_ok(), "{controller}: {read:?}");
            for key in &must {
                let less: Vec<(&str, &str)> =
                    good.iter().copied().filter(|(k, _)| k != key).collect();
                assert!(
                    Machine::from_toml("x", &file(controller, &less)).is_err(),
                    "{controller} without {key}"
                );
            }
            for (key, value) in GOOD
                .into_iter()
                .filter(|(k, _)| *k != "baud" && !must.contains(k))
            {
                let read = Machine::from_toml(
                    "x",
                    &file(controller, &[good.clone(), vec![(key, value)]].concat()),
                );
                assert_eq!(
                    read.is_err(),
                    never.contains(&&key.to_string()),
                    "{controller} with {key}"
                );
            }
        }
    }
    for key in strings(&schema["required"]) {
        let kept: String = file("haas", &[])
            .lines()
            .filter(|l| !l.starts_with(&format!("{key} =")))
            .map(|l| format!("{l}\n"))
            .collect();
        assert!(Machine::from_toml("x", &kept).is_err(), "without {key}");
    }
}

/// Every shipped machine as an editor would judge it: keys, kinds, bounds, and the rule of its family.
#[test]
fn every_machine_conforms_to_the_schema() {
    let schema = schema();
    let judge = |text: &str| -> Result<(), String> {
        let table: toml::Table = text.parse().map_err(|e| format!("{e}"))?;
        let file = serde_json::to_value(&table).map_err(|e| format!("{e}"))?;
        let object = file.as_object().ok_or("no table")?;
        let rule = schema["allOf"]
            .as_array()
            .unwrap()
            .iter()
            .find(|r| {
                strings(&r["if"]["properties"]["controller"]["enum"])
                    .contains(&file["controller"].as_str().unwrap_or_default())
            })
            .ok_or("no family")?;
        let musts = [&schema["required"], &rule["then"]["required"]];
        for key in musts.into_iter().filter(|m| m.is_array()).flat_map(strings) {
            if !object.contains_key(key) {
                return Err(format!("{key} is missing"));
            }
        }
        for (key, value) in object {
            fits(&schema["properties"][key], value).map_err(|e| format!("{key}: {e}"))?;
            match &rule["then"]["properties"][key] {
                Value::Bool(false) => return Err(format!("{key} is none of this family's")),
                Value::Object(_) => fits(&rule["then"]["properties"][key], value)?,
                _ => {}
            }
        }
        Ok(())
    };
    for (name, text) in BUILT_IN {
        assert_eq!(judge(text), Ok(()), "{name}");
    }
    let good = BUILT_IN.iter().find(|(n, _)| *n == "grbl-3018").unwrap().1;
    for (from, to) in [
        ("baud = 115200", "baud = 0"),
        ("baud = 115200", "baudd = 115200"),
        ("[284, 180, 40]", "[284, 180]"),
        ("[284, 180, 40]", "[284, 180, 0]"),
        ("[0, 10000]", "\"fast\""),
        ("controller = \"grbl\"", "controller = \"haas\""),
    ] {
        assert!(good.contains(from), "{from}");
        assert!(judge(&good.replace(from, to)).is_err(), "{to}");
    }
}

/// As much of JSON Schema as ours uses.
fn fits(schema: &Value, value: &Value) -> Result<(), String> {
    if schema.is_null() {
        return Err("is no key of the schema".into());
    }
    let bad = |what: &str| Err(format!("{value} {what}"));
    match schema["type"].as_str() {
        Some("string") if !value.is_string() => return bad("is no string"),
        Some("array") => {
            let Some(items) = value.as_array() else {
                return bad("is no list");
            };
            let length = items.len() as u64;
            if schema["minItems"].as_u64().is_some_and(|n| length < n)
                || schema["maxItems"].as_u64().is_some_and(|n| length > n)
            {
                return bad("has another length");
            }
            for item in items {
                fits(&schema["items"], item)?;
            }
        }
        Some(kind @ ("number" | "integer")) => match value.as_f64() {
            None => return bad("is no number"),
            Some(v) if kind == "integer" && v.fract() != 0.0 => return bad("is no whole number"),
            _ => {}
        },
        _ => {}
    }
    if let Some(v) = value.as_f64() {
        let low = schema["minimum"].as_f64().is_some_and(|m| v < m);
        let none = schema["exclusiveMinimum"].as_f64().is_some_and(|m| v <= m);
        if low || none || schema["maximum"].as_f64().is_some_and(|m| v > m) {
            return bad("is out of bounds");
        }
    }
    match (&schema["enum"], &schema["const"]) {
        (Value::Array(all), _) if !all.contains(value) => bad("is none of those it may be"),
        (_, only) if !only.is_null() && only.as_f64() != value.as_f64() => bad("is not the one"),
        _ => Ok(()),
    }
}

#[test]
fn the_schema_has_the_bounds_of_the_program() {
    let schema = schema();
    let mut checked = 0;
    for (key, rule) in schema["properties"].as_object().unwrap() {
        let item = if rule["type"] == "array" {
            &rule["items"]
        } else {
            rule
        };
        let Some(most) = item["maximum"].as_f64() else {
            continue;
        };
        let accepted = |v: f64| {
            let value = match rule["minItems"].as_u64() {
                Some(2) if v > 0.0 => format!("[0, {v}]"),
                Some(2) => format!("[{v}, 1000]"),
                Some(_) => format!("[{v}, {v}, {v}]"),
                None => format!("{v}"),
            };
            // The firmware family may have every key.
            let mut extra = vec![GOOD[0]];
            extra.push((key.as_str(), value.as_str()));
            Machine::from_toml("x", &file("marlin", &extra)).is_ok()
        };
        assert!(accepted(most), "{key} = {most}");
        assert!(!accepted(most * 1.5), "{key} above {most}");
        match (item["exclusiveMinimum"].as_f64(), item["minimum"].as_f64()) {
            (Some(least), None) => assert!(
                !accepted(least) && accepted(1e-3_f64.max(least)),
                "{key} = {least}"
            ),
            (None, Some(least)) => {
                assert!(accepted(least) && !accepted(least - 1.0), "{key} = {least}")
            }
            _ => panic!("{key}: one least value"),
        }
        checked += 1;
    }
    assert_eq!(checked, 11, "keys with bounds");
}
