//! `posts/schema.json`, which editors read, against what the program reads.
#![allow(clippy::unwrap_used)]

use super::{BUILT_IN, Post, READERS};
use crate::machine::DataError;
use serde_json::Value;
use std::collections::BTreeSet;

fn schema() -> Value {
    serde_json::from_str(include_str!("../../posts/schema.json")).unwrap()
}

fn grbl() -> &'static str {
    BUILT_IN.iter().find(|(n, _)| *n == "grbl").unwrap().1
}

/// The keys that the program knows in a table, by its own complaint of one that it does not.
fn known(table: &str) -> BTreeSet<String> {
    let text = match table {
        "" => format!("zzz = 1\n{}", grbl()),
        _ => {
            let tables: toml::Table = grbl().parse().unwrap();
            // The table alone, with a key that no table has; the complaint comes before anything that is missing.
            match tables.contains_key(table) {
                true => grbl().replacen(&format!("[{table}]"), &format!("[{table}]\nzzz = 1"), 1),
                false => format!("{}\n[{table}]\nzzz = 1\n", grbl()),
            }
        }
    };
    match Post::from_toml("test", &text) {
        Err(DataError::UnknownKey { known, .. }) => known.into_iter().collect(),
        other => panic!("{table}: {other:?}"),
    }
}

fn keys(table: &Value) -> BTreeSet<String> {
    let properties = table["properties"].as_object().unwrap();
    properties.keys().cloned().collect()
}

#[test]
fn the_schema_has_the_programs_keys_and_no_others() {
    let s = schema();
    assert_eq!(keys(&s), known(""));
    let mut tables = 0;
    for (name, value) in s["properties"].as_object().unwrap() {
        if value["type"] == "object" {
            assert_eq!(keys(value), known(name), "{name}");
            tables += 1;
        }
    }
    assert_eq!(tables, 13);
}

#[test]
fn what_the_schema_requires_the_program_requires() {
    let s = schema();
    let full: toml::Table = BUILT_IN
        .iter()
        .find(|(n, _)| *n == "fanuc")
        .unwrap()
        .1
        .parse()
        .unwrap();
    let missing = |table: &toml::Table| match Post::from_toml("t", &toml::to_string(table).unwrap())
    {
        Err(DataError::Missing { key, .. }) => Some(key),
        _ => None,
    };
    let required = |value: &Value| -> BTreeSet<String> {
        let list = value["required"].as_array().unwrap();
        list.iter()
            .map(|k| k.as_str().unwrap().to_string())
            .collect()
    };
    assert_eq!(missing(&full), None);
    for key in keys(&s) {
        let mut without = full.clone();
        if without.remove(&key).is_some() {
            assert_eq!(
                missing(&without).is_some(),
                required(&s).contains(&key),
                "{key}"
            );
        }
    }
    for (name, value) in s["properties"].as_object().unwrap() {
        let Some(table) = full.get(name).and_then(toml::Value::as_table) else {
            continue;
        };
        for key in table.keys() {
            let mut without = full.clone();
            without[name].as_table_mut().unwrap().remove(key);
            assert_eq!(
                missing(&without).is_some(),
                required(value).contains(key),
                "{name}.{key}"
            );
        }
    }
}

#[test]
fn every_key_says_what_it_means_and_every_post_conforms() {
    let s = schema();
    let readers: Vec<&str> = s["properties"]["reader"]["enum"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_str().unwrap())
        .collect();
    assert_eq!(readers, READERS);
    described(&s, "");
    for (name, text) in BUILT_IN {
        let table: toml::Table = text.parse().unwrap();
        let value = serde_json::to_value(&table).unwrap();
        conforms(&s, &value, name);
    }
    let mut wrong = serde_json::to_value(grbl().parse::<toml::Table>().unwrap()).unwrap();
    wrong["units"] = "cm".into();
    assert!(std::panic::catch_unwind(|| conforms(&schema(), &wrong, "wrong")).is_err());
}

fn described(schema: &Value, at: &str) {
    for (key, value) in schema["properties"].as_object().unwrap() {
        assert!(
            value["description"].as_str().is_some_and(|d| d.len() >= 2),
            "{at}.{key}"
        );
        if value["type"] == "object" {
            assert_eq!(value["additionalProperties"], false, "{at}.{key}");
            described(value, key);
        }
    }
}

/// As much of JSON Schema as ours uses.
fn conforms(schema: &Value, value: &Value, at: &str) {
    match schema["type"].as_str().unwrap() {
        "object" => {
            let object = value.as_object().unwrap_or_else(|| panic!("{at}"));
            for key in schema["required"].as_array().unwrap() {
                assert!(
                    object.contains_key(key.as_str().unwrap()),
                    "{at}: {key} is missing"
                );
            }
            for (key, value) in object {
                let schema = &schema["properties"][key];
                assert!(!schema.is_null(), "{at}: {key} is not in the schema");
                conforms(schema, value, &format!("{at}.{key}"));
            }
        }
        "array" => {
            for v in value.as_array().unwrap_or_else(|| panic!("{at}")) {
                conforms(&schema["items"], v, at);
            }
        }
        "string" => assert!(value.is_string(), "{at}"),
        "boolean" => assert!(value.is_boolean(), "{at}"),
        kind => {
            let number = value.as_f64().unwrap_or_else(|| panic!("{at}"));
            assert!(kind == "number" || number.fract() == 0.0, "{at}");
            assert!(
                schema["minimum"].as_f64().is_none_or(|m| number >= m),
                "{at}"
            );
            assert!(
                schema["exclusiveMinimum"]
                    .as_f64()
                    .is_none_or(|m| number > m),
                "{at}"
            );
            assert!(
                schema["maximum"].as_f64().is_none_or(|m| number <= m),
                "{at}"
            );
        }
    }
    if let Some(words) = schema["enum"].as_array() {
        assert!(words.contains(value), "{at}: {value}");
    }
}
