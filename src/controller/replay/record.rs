//! What a recording says: parsed once into checked types.

use super::json::Json;

/// A recording of a real controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// One line, or a few bytes, and what came of it.
    Probe(Probe),
    /// Several steps in exact time.
    Sequence(Sequence),
}

/// Power-up, lines to prepare, bytes, answers, questions afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Lines sent first, each until all is quiet; `<power cycle>` is off and on again.
    pub setup: Vec<String>,
    /// The bytes.
    pub send: Vec<u8>,
    /// What came back, without empty lines.
    pub recv: Vec<String>,
    /// Questions asked afterwards, in order, and their answers. Primes at the end of a question only tell it from an earlier one.
    pub after: Vec<(String, Vec<String>)>,
}

/// Power-up, lines to prepare, steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Lines sent first.
    pub setup: Vec<String>,
    /// Then switched off and on again.
    pub power_cycled: bool,
    /// What was said at that.
    pub boot: Option<Vec<String>>,
    /// `[x-, x+, y-, y+, z-, z+]`, machine steps.
    pub limits: [Option<i64>; 6],
    /// The probe touches at or below so many Z steps.
    pub probe_z: Option<i64>,
    /// What happened.
    pub steps: Vec<Step>,
}

/// Bytes or pins, then time, then what was said.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Pins moved.
    pub pins: Vec<(Pin, bool)>,
    /// Bytes sent.
    pub send: Option<Vec<u8>>,
    /// Machine time that passes then, s.
    pub run: f64,
    /// What was said.
    pub recv: Vec<String>,
}

/// An input pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pin {
    /// X, Y or Z.
    Limit(usize),
    /// The probe.
    Probe,
    /// The safety door.
    Door,
    /// The feed-hold button.
    Hold,
    /// The reset button.
    Reset,
    /// The cycle-start button.
    CycleStart,
}

const PINS: [(&str, Pin); 10] = [
    ("X_LIMIT", Pin::Limit(0)),
    ("Y_LIMIT", Pin::Limit(1)),
    ("Z_LIMIT", Pin::Limit(2)),
    ("PROBE", Pin::Probe),
    ("RESET", Pin::Reset),
    ("FEED_HOLD", Pin::Hold),
    ("HOLD", Pin::Hold),
    ("CYCLE_START", Pin::CycleStart),
    ("SAFETY_DOOR", Pin::Door),
    ("DOOR", Pin::Door),
];

/// Why a recording is not understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// Not JSON, or not an object.
    #[error("this is not a JSON object ({0}): recordings have one a line")]
    NotJson(String),
    /// A key that no recording has.
    #[error("no recording has the key {key:?}: did you mean {near:?}?")]
    UnknownKey {
        /// The key.
        key: String,
        /// The nearest known one.
        near: &'static str,
    },
    /// A key that must be there.
    #[error("the key {0:?} is missing")]
    Missing(&'static str),
    /// A value of the wrong kind.
    #[error("{key:?} must be {want}")]
    Kind {
        /// Where.
        key: String,
        /// What it should be.
        want: &'static str,
    },
    /// No such pin.
    #[error(
        "there is no pin {0:?}: name X_LIMIT, Y_LIMIT, Z_LIMIT, PROBE, RESET, FEED_HOLD, CYCLE_START or SAFETY_DOOR"
    )]
    Pin(String),
}

type Read<T> = Result<T, RecordError>;

/// The longest time one step may take, s: a day.
const LONGEST: f64 = 86_400.0;

fn kind<T>(key: &str, want: &'static str) -> Read<T> {
    Err(RecordError::Kind {
        key: key.to_string(),
        want,
    })
}

/// Refuses keys that are not known.
fn known(json: &Json, keys: &[&'static str]) -> Read<()> {
    let Json::Object(pairs) = json else {
        return Err(RecordError::NotJson("another value".to_string()));
    };
    for (key, _) in pairs {
        if !keys.contains(&key.as_str()) {
            let near = keys.iter().min_by_key(|k| distance(k, key));
            return Err(RecordError::UnknownKey {
                key: key.clone(),
                near: near.copied().unwrap_or("recv"),
            });
        }
    }
    Ok(())
}

/// Letters to change to make one word of the other.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        let mut next = vec![left];
        for (y, up) in b.iter().zip(row.iter().skip(1)) {
            let here = (diagonal + usize::from(x != *y)).min(left + 1).min(up + 1);
            diagonal = *up;
            left = here;
            next.push(here);
        }
        row = next;
    }
    row.last().copied().unwrap_or_default()
}

fn text<'a>(json: &'a Json, key: &str) -> Read<&'a str> {
    match json {
        Json::Text(t) => Ok(t),
        _ => kind(key, "a text"),
    }
}

fn texts(json: &Json, key: &str) -> Read<Vec<String>> {
    match json {
        Json::List(list) => list
            .iter()
            .map(|t| text(t, key).map(String::from))
            .collect(),
        _ => kind(key, "a list of texts"),
    }
}

fn flag(json: &Json, key: &str) -> Read<bool> {
    match json {
        Json::Bool(b) => Ok(*b),
        _ => kind(key, "true or false"),
    }
}

fn whole(json: &Json, key: &str) -> Read<Option<i64>> {
    match json {
        Json::Null => Ok(None),
        Json::Number(n) => match n.as_i64() {
            Some(n) => Ok(Some(n)),
            None => kind(key, "a whole number or null"),
        },
        _ => kind(key, "a whole number or null"),
    }
}

/// The recordings hold bytes as Latin-1 characters.
fn bytes(json: &Json, key: &str) -> Read<Vec<u8>> {
    text(json, key)?
        .chars()
        .map(|c| u8::try_from(u32::from(c)))
        .collect::<Result<_, _>>()
        .or_else(|_| kind(key, "bytes, written as the characters up to U+00FF"))
}

impl Record {
    /// Reads a recording of either kind.
    ///
    /// # Errors
    /// Unknown or missing keys, values of the wrong kind.
    pub fn read(json: &Json) -> Read<Record> {
        match json.get("steps") {
            Some(_) => Sequence::read(json).map(Record::Sequence),
            None => Probe::read(json).map(Record::Probe),
        }
    }
}

impl Probe {
    fn read(json: &Json) -> Read<Probe> {
        known(json, &["id", "group", "setup", "send", "recv", "after"])?;
        let send = json.get("send").ok_or(RecordError::Missing("send"))?;
        let after = match json.get("after") {
            None => Vec::new(),
            Some(Json::Object(pairs)) => pairs
                .iter()
                .map(|(question, answer)| Ok((question.clone(), texts(answer, question)?)))
                .collect::<Read<_>>()?,
            Some(_) => return kind("after", "an object of questions and answers"),
        };
        Ok(Probe {
            setup: optional_texts(json, "setup")?,
            send: bytes(send, "send")?,
            recv: optional_texts(json, "recv")?,
            after,
        })
    }
}

fn optional_texts(json: &Json, key: &str) -> Read<Vec<String>> {
    json.get(key).map_or(Ok(Vec::new()), |v| texts(v, key))
}

impl Sequence {
    fn read(json: &Json) -> Read<Sequence> {
        known(
            json,
            &[
                "id",
                "name",
                "group",
                "settings_or_setup",
                "setup",
                "settings",
                "power_cycled",
                "boot",
                "limit_switch_steps",
                "probe_contact_z_steps",
                "steps",
            ],
        )?;
        let mut setup = optional_texts(json, "settings_or_setup")?;
        setup.extend(optional_texts(json, "settings")?);
        setup.extend(optional_texts(json, "setup")?);
        let steps = match json.get("steps") {
            Some(Json::List(list)) => list.iter().map(Step::read).collect::<Read<_>>()?,
            _ => return kind("steps", "a list of steps"),
        };
        let key = "limit_switch_steps";
        let mut limits = [None; 6];
        match json.get(key) {
            None | Some(Json::Null) => {}
            Some(Json::List(list)) if list.len() == 6 => {
                for (limit, value) in limits.iter_mut().zip(list) {
                    *limit = whole(value, key)?;
                }
            }
            Some(_) => return kind(key, "six whole numbers, x-, x+, y-, y+, z-, z+"),
        }
        Ok(Sequence {
            setup,
            power_cycled: match json.get("power_cycled") {
                Some(v) => flag(v, "power_cycled")?,
                None => false,
            },
            boot: match json.get("boot") {
                Some(v) => Some(texts(v, "boot")?),
                None => None,
            },
            limits,
            probe_z: match json.get("probe_contact_z_steps") {
                Some(v) => whole(v, "probe_contact_z_steps")?,
                None => None,
            },
            steps,
        })
    }
}

impl Step {
    fn read(json: &Json) -> Read<Step> {
        known(
            json,
            &["send", "pin", "active", "pins", "then_run_ms", "recv"],
        )?;
        let pin = |name: &str| {
            PINS.iter()
                .find(|(n, _)| *n == name)
                .map(|(_, p)| *p)
                .ok_or_else(|| RecordError::Pin(name.to_string()))
        };
        let mut pins = Vec::new();
        if let Some(name) = json.get("pin") {
            let active = json.get("active").ok_or(RecordError::Missing("active"))?;
            pins.push((pin(text(name, "pin")?)?, flag(active, "active")?));
        }
        match json.get("pins") {
            None => {}
            Some(Json::Object(pairs)) => {
                for (name, active) in pairs {
                    pins.push((pin(name)?, flag(active, name)?));
                }
            }
            Some(_) => return kind("pins", "an object of pins, each true or false"),
        }
        let run = match json.get("then_run_ms") {
            None => 0.0,
            Some(Json::Number(n)) => n.as_f64().unwrap_or(f64::NAN) / 1000.0,
            Some(_) => f64::NAN,
        };
        if !(0.0..=LONGEST).contains(&run) {
            return kind("then_run_ms", "milliseconds, at most a day");
        }
        Ok(Step {
            pins,
            send: match json.get("send") {
                Some(v) => Some(bytes(v, "send")?),
                None => None,
            },
            run,
            recv: optional_texts(json, "recv")?,
        })
    }
}
