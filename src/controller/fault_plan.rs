//! Which faults there are to be, read from text: `drop:0.001`, `lose-ok:0.01`, `reset-at-line:120`, `unplug-at:12.5s` ...

use crate::machine::data::nearest;

/// Chances of each byte of one direction, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// It is lost.
    pub drop: f64,
    /// It arrives twice.
    pub duplicate: f64,
    /// One of its bits is turned round.
    pub flip: f64,
}

/// Something done once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// The reset button, or a dip of the supply: the firmware starts anew at once. It has forgotten where it stands.
    Reset,
    /// Off, and on again a second later.
    PowerCycle,
    /// The plug of the cable is pulled: bytes vanish both ways, the controller goes on.
    Unplug,
    /// The plug is in again.
    Plug,
}

/// When.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// So many seconds after the start.
    At(f64),
    /// As soon as the n-th line end has reached the controller, from 1.
    Line(usize),
}

impl When {
    /// For sorting: lines come at once.
    pub(super) fn time(self) -> f64 {
        match self {
            When::At(t) => t,
            When::Line(_) => 0.0,
        }
    }
}

/// All that is to go wrong. The default is nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultPlan {
    /// Noise on the way to the controller.
    pub to_controller: Noise,
    /// Noise on the way to the host.
    pub to_host: Noise,
    /// Chance of each `ok` to be lost.
    pub lose_ok: f64,
    /// How long each byte is under way, s.
    pub delay: f64,
    /// What is done when.
    pub deeds: Vec<(When, Deed)>,
    /// Bytes that arrive while the controller writes its EEPROM are lost. Only a serial line with a speed ([`super::Build::baud`]) has
    /// bytes that arrive meanwhile.
    pub eeprom_loss: bool,
    /// The receive buffer is really so large, whatever the controller says of it. Bytes.
    pub rx_bytes: Option<usize>,
    /// Which bytes are hit. `None`: the caller chooses, and says which.
    pub seed: Option<u64>,
    /// As written, to be said at the start.
    written: Vec<String>,
}

/// A fault that there is not, or a figure that it cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FaultError {
    /// Unknown name.
    #[error("there is no fault \"{name}\"{}; there are {}", .nearest.as_ref().map_or(String::new(), |n| format!(" (did you mean \"{n}\"?)")), known())]
    Unknown {
        /// As written.
        name: String,
        /// The closest known one.
        nearest: Option<String>,
    },
    /// Wrong value.
    #[error("fault {name}:{value}: {problem}")]
    Value {
        /// Its name.
        name: String,
        /// As written.
        value: String,
        /// What it must be.
        problem: &'static str,
    },
}

/// What a fault's value is.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Rate(fn(&mut FaultPlan, f64)),
    Time(fn(&mut FaultPlan, f64)),
    At(Deed),
    AtLine(Deed),
    Switch(fn(&mut FaultPlan, bool)),
    Bytes,
    Seed,
}

const KNOWN: [(&str, Kind); 15] = [
    (
        "drop",
        Kind::Rate(|p, v| (p.to_controller.drop, p.to_host.drop) = (v, v)),
    ),
    (
        "duplicate",
        Kind::Rate(|p, v| (p.to_controller.duplicate, p.to_host.duplicate) = (v, v)),
    ),
    (
        "flip",
        Kind::Rate(|p, v| (p.to_controller.flip, p.to_host.flip) = (v, v)),
    ),
    ("lose-ok", Kind::Rate(|p, v| p.lose_ok = v)),
    ("delay", Kind::Time(|p, v| p.delay = v)),
    ("reset-at", Kind::At(Deed::Reset)),
    ("reset-at-line", Kind::AtLine(Deed::Reset)),
    ("power-cycle-at", Kind::At(Deed::PowerCycle)),
    ("power-cycle-at-line", Kind::AtLine(Deed::PowerCycle)),
    ("unplug-at", Kind::At(Deed::Unplug)),
    ("unplug-at-line", Kind::AtLine(Deed::Unplug)),
    ("plug-at", Kind::At(Deed::Plug)),
    ("eeprom-loss", Kind::Switch(|p, v| p.eeprom_loss = v)),
    ("rx-bytes", Kind::Bytes),
    ("seed", Kind::Seed),
];

fn known() -> String {
    KNOWN.map(|k| k.0).join(", ")
}

/// A year: longer than any rehearsal.
const LONGEST: f64 = 366.0 * 86_400.0;

impl FaultPlan {
    /// Adds one fault, `NAME:VALUE`: a rate from 0 to 1; a time such as `12.5s`, `20ms`, `3min`; a line from 1; on or off; bytes; a
    /// number.
    ///
    /// # Errors
    /// An unknown name, or a value that it cannot have.
    pub fn add(&mut self, text: &str) -> Result<(), FaultError> {
        let (name, value) = text.split_once(':').unwrap_or((text, ""));
        let (name, value) = (name.trim(), value.trim());
        let Some((_, kind)) = KNOWN.iter().find(|k| k.0 == name) else {
            return Err(FaultError::Unknown {
                name: name.chars().take(60).collect(),
                nearest: nearest(name, KNOWN.iter().map(|k| k.0)),
            });
        };
        let refuse = |problem: &'static str| FaultError::Value {
            name: name.to_string(),
            value: value.chars().take(60).collect(),
            problem,
        };
        match kind {
            Kind::Rate(set) => {
                let rate: Option<f64> = value.parse().ok();
                let rate = rate.filter(|v| (0.0..=1.0).contains(v));
                set(
                    self,
                    rate.ok_or_else(|| {
                        refuse("write a chance from 0 to 1, e.g. 0.001 for one in a thousand")
                    })?,
                );
            }
            Kind::Time(set) => set(self, seconds(value).ok_or_else(|| refuse(A_TIME))?),
            Kind::At(deed) => {
                let at = seconds(value).ok_or_else(|| refuse(A_TIME))?;
                self.deeds.push((When::At(at), *deed));
            }
            Kind::AtLine(deed) => {
                let line: Option<usize> = value.parse().ok().filter(|n| *n > 0);
                let line =
                    line.ok_or_else(|| refuse("write a line's number: the first to arrive is 1"))?;
                self.deeds.push((When::Line(line), *deed));
            }
            Kind::Switch(set) => match value {
                "" | "on" => set(self, true),
                "off" => set(self, false),
                _ => return Err(refuse("write on or off")),
            },
            Kind::Bytes => {
                let bytes: Option<usize> = value.parse().ok();
                let bytes = bytes.filter(|n| (1..=1_000_000).contains(n));
                self.rx_bytes =
                    Some(bytes.ok_or_else(|| refuse("write a number of bytes, 1 to 1000000"))?);
            }
            Kind::Seed => {
                let seed = value.parse().ok();
                self.seed = Some(seed.ok_or_else(|| refuse("write a whole number"))?);
            }
        }
        if name != "seed" {
            self.written.push(text.trim().to_string());
        }
        Ok(())
    }

    /// Nothing is to go wrong.
    pub fn is_empty(&self) -> bool {
        self.written.is_empty()
    }
}

impl std::fmt::Display for FaultPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.written.join(", "))
    }
}

const A_TIME: &str = "write a time, e.g. 12.5s, 20ms or 3min";

/// A time of text, s: a number with `s`, `ms`, `min` or `h`; without, seconds.
pub(super) fn seconds(text: &str) -> Option<f64> {
    let text = text.trim();
    // `ms` before `s`, which it ends with.
    let (figure, unit) = [("ms", 1e-3), ("min", 60.0), ("h", 3600.0), ("s", 1.0)]
        .iter()
        .find_map(|(unit, s)| text.strip_suffix(unit).map(|f| (f, *s)))
        .unwrap_or((text, 1.0));
    let v: f64 = figure.trim_end().parse().ok()?;
    Some(v * unit).filter(|t| (0.0..=LONGEST).contains(t))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_fault_is_read() {
        let mut p = FaultPlan::default();
        for text in [
            "drop:0.001",
            "duplicate:0.5",
            "flip:1e-5",
            "lose-ok:0.01",
            "delay:20ms",
            "reset-at:1min",
            "reset-at-line:120",
            "power-cycle-at:2h",
            "power-cycle-at-line:1",
            "unplug-at:12.5s",
            "unplug-at-line:7",
            "plug-at:20",
            "eeprom-loss",
            "rx-bytes:64",
            "seed:42",
        ] {
            p.add(text).unwrap();
        }
        let noise = Noise {
            drop: 0.001,
            duplicate: 0.5,
            flip: 1e-5,
        };
        assert_eq!((p.to_controller, p.to_host), (noise, noise));
        assert_eq!((p.lose_ok, p.delay), (0.01, 0.02));
        assert_eq!(
            p.deeds,
            [
                (When::At(60.0), Deed::Reset),
                (When::Line(120), Deed::Reset),
                (When::At(7200.0), Deed::PowerCycle),
                (When::Line(1), Deed::PowerCycle),
                (When::At(12.5), Deed::Unplug),
                (When::Line(7), Deed::Unplug),
                (When::At(20.0), Deed::Plug),
            ]
        );
        assert_eq!(
            (p.eeprom_loss, p.rx_bytes, p.seed),
            (true, Some(64), Some(42))
        );
        assert!(p.to_string().starts_with("drop:0.001, duplicate:0.5, "));
        assert!(!p.to_string().contains("seed"));
    }

    #[test]
    fn what_is_refused_says_what_there_is() {
        let refused = |text: &str| FaultPlan::default().add(text).unwrap_err().to_string();
        assert_eq!(
            refused("loose-ok:0.1"),
            "there is no fault \"loose-ok\" (did you mean \"lose-ok\"?); there are drop, duplicate, flip, lose-ok, delay, reset-at, reset-at-line, power-cycle-at, power-cycle-at-line, unplug-at, unplug-at-line, plug-at, eeprom-loss, rx-bytes, seed"
        );
        for (text, problem) in [
            (
                "drop:2",
                "write a chance from 0 to 1, e.g. 0.001 for one in a thousand",
            ),
            (
                "flip:nan",
                "write a chance from 0 to 1, e.g. 0.001 for one in a thousand",
            ),
            ("delay:-1s", A_TIME),
            ("reset-at:1e400", A_TIME),
            (
                "reset-at-line:0",
                "write a line's number: the first to arrive is 1",
            ),
            ("eeprom-loss:yes", "write on or off"),
            ("rx-bytes:0", "write a number of bytes, 1 to 1000000"),
            ("seed:x", "write a whole number"),
        ] {
            assert_eq!(refused(text), format!("fault {text}: {problem}"));
        }
        assert!(refused("").starts_with("there is no fault \"\""));
    }
}
