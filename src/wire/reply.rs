//! Everything a controller may say in a line.

use super::modes::Modes;
use super::status::{Status, number, triple};

/// `[OPT:letters,blocks,rx]`. Some firmwares give no numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// Option letters as sent.
    pub letters: String,
    /// Planner blocks.
    pub blocks: Option<usize>,
    /// Bytes of receive buffer.
    pub rx: Option<usize>,
}

/// One line from the controller. Only [`Reply::Ok`] and [`Reply::Error`] answer a line that was sent; all else is push traffic
/// and must never be counted.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// `ok`: read and queued (not: executed).
    Ok,
    /// `error:N`: the whole line was dropped; the next ones go on.
    Error(u16),
    /// `ALARM:N`: motion has ended, the machine is locked. Answers no line.
    Alarm(u16),
    /// The greeting after power-up and reset, e.g. firmware `Grbl`, version `1.1h`.
    Welcome {
        /// First word.
        firmware: String,
        /// Second word.
        version: String,
        /// The rest of the line, where forks say who they are.
        text: String,
    },
    /// A status report.
    Status(Status),
    /// `[MSG:text]`.
    Message(String),
    /// `[OPT:...]`.
    Options(BuildOptions),
    /// `[VER:version:user text]`, everything behind the first colon.
    Version(String),
    /// `[FIRMWARE:...]`, said by grblHAL.
    FirmwareName(String),
    /// `[GC:...]`, the active modes.
    Modes(Modes),
    /// `[G54:x,y,z]` ... `[G92:..]`, in report units.
    Offset {
        /// `G54` to `G59`, `G28`, `G30`, `G92`.
        name: String,
        /// Values.
        values: [f64; 3],
    },
    /// `[TLO:z]`, tool length offset in report units.
    ToolLength(f64),
    /// `[PRB:x,y,z:1]`: where the probe was triggered, machine coordinates in report units; also pushed after each probing.
    Probed {
        /// The trigger point; where the motion ended when nothing was touched.
        at: [f64; 3],
        /// It touched.
        touched: bool,
    },
    /// `>line:ok` or `>line:error:N`: a startup line was run. Answers no line of ours.
    Startup(String),
    /// `$n=value`.
    Setting {
        /// n.
        number: u16,
        /// The value as sent.
        value: String,
    },
    /// Any other line: shown to people, otherwise without meaning.
    Other(String),
}

impl Reply {
    /// Reads one line without its line end. Never fails: what is not understood is `Other`.
    pub fn parse(line: &str) -> Reply {
        let line = line.trim();
        let other = || Reply::Other(line.to_string());
        if line == "ok" {
            return Reply::Ok;
        }
        if let Some(n) = line.strip_prefix("error:") {
            return n.trim().parse().map_or_else(|_| other(), Reply::Error);
        }
        if let Some(n) = line.strip_prefix("ALARM:") {
            return n.trim().parse().map_or_else(|_| other(), Reply::Alarm);
        }
        if line.starts_with('<') {
            return Status::parse(line).map_or_else(other, Reply::Status);
        }
        if let Some(text) = line.strip_prefix('>') {
            return Reply::Startup(text.to_string());
        }
        if let Some(body) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            return bracket(body).unwrap_or_else(other);
        }
        if let Some((number, value)) = line.strip_prefix('$').and_then(|l| l.split_once('=')) {
            // `$N0=` is a startup line, not a setting.
            return match number.parse() {
                Ok(number) => Reply::Setting {
                    number,
                    value: value.to_string(),
                },
                Err(_) => other(),
            };
        }
        let mut words = line.split_whitespace();
        match (words.next(), words.next()) {
            (Some(firmware), Some(version))
                if firmware.to_ascii_lowercase().starts_with("grbl")
                    && version.starts_with(|c: char| c.is_ascii_digit()) =>
            {
                Reply::Welcome {
                    firmware: firmware.to_string(),
                    version: version.to_string(),
                    text: words.collect::<Vec<_>>().join(" "),
                }
            }
            _ => other(),
        }
    }

    /// True for the two that answer a line.
    pub fn answers_a_line(&self) -> bool {
        matches!(self, Reply::Ok | Reply::Error(_))
    }

    /// True for a line that no firmware of the family is known to say: bytes were damaged on the way. Unknown `[...]` lines and
    /// lines that begin with `$` are some firmware's news (grblHAL and FluidNC have many) and no damage.
    pub fn is_damage(&self) -> bool {
        match self {
            Reply::Other(line) => {
                let bracketed = line.starts_with('[') && line.ends_with(']');
                let intact = line.bytes().all(|b| (b' '..0x7F).contains(&b));
                !(intact && (bracketed || line.starts_with('$')))
            }
            _ => false,
        }
    }
}

fn bracket(body: &str) -> Option<Reply> {
    let (name, value) = body.split_once(':')?;
    match name {
        "MSG" => Some(Reply::Message(value.to_string())),
        "VER" => Some(Reply::Version(value.to_string())),
        "FIRMWARE" => Some(Reply::FirmwareName(value.to_string())),
        "GC" => Some(Reply::Modes(Modes::parse(value))),
        // More axes than three may follow; Z is the third, and alone it is the only one.
        "TLO" => match value.split(',').count() {
            0..=2 => number(value).map(Reply::ToolLength),
            _ => triple(value).map(|v| Reply::ToolLength(v[2])),
        },
        "PRB" => {
            let (place, touched) = value.rsplit_once(':')?;
            triple(place).map(|at| Reply::Probed {
                at,
                touched: touched == "1",
            })
        }
        "OPT" => {
            let mut parts = value.split(',');
            let letters = parts.next().unwrap_or_default().to_string();
            let mut figure = || parts.next().and_then(|p| p.trim().parse().ok());
            let (blocks, rx) = (figure(), figure());
            Some(Reply::Options(BuildOptions {
                letters,
                blocks,
                rx,
            }))
        }
        "G54" | "G55" | "G56" | "G57" | "G58" | "G59" | "G28" | "G30" | "G92" => {
            triple(value).map(|values| Reply::Offset {
                name: name.to_string(),
                values,
            })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn only_whole_lines_answer() {
        assert!(Reply::parse("ok").answers_a_line());
        assert!(Reply::parse("error:20").answers_a_line());
        for push in [
            ">G20G54:ok",
            "[MSG:ok]",
            "[MSG:not ok here]",
            "ALARM:1",
            "okay",
            "error:",
            "error:x",
            "Grbl 1.1h ['$' for help]",
        ] {
            assert!(!Reply::parse(push).answers_a_line(), "{push}");
        }
    }

    #[test]
    fn reads_each_kind() {
        assert_eq!(Reply::parse("ALARM:3"), Reply::Alarm(3));
        assert_eq!(
            Reply::parse("Grbl 1.1h ['$' for help]"),
            Reply::Welcome {
                firmware: "Grbl".into(),
                version: "1.1h".into(),
                text: "['$' for help]".into(),
            }
        );
        assert!(matches!(
            Reply::parse("GrblHAL 1.1f ['$' or '$HELP' for help]"),
            Reply::Welcome { .. }
        ));
        assert_eq!(
            Reply::parse("[OPT:V,15,128]"),
            Reply::Options(BuildOptions {
                letters: "V".into(),
                blocks: Some(15),
                rx: Some(128)
            })
        );
        assert_eq!(
            Reply::parse("[OPT:PHS]"),
            Reply::Options(BuildOptions {
                letters: "PHS".into(),
                blocks: None,
                rx: None
            })
        );
        assert_eq!(
            Reply::parse("$110=500.000"),
            Reply::Setting {
                number: 110,
                value: "500.000".into()
            }
        );
        assert_eq!(Reply::parse("$N0=G20"), Reply::Other("$N0=G20".into()));
        assert_eq!(
            Reply::parse("[G54:1.000,0.000,-5.000]"),
            Reply::Offset {
                name: "G54".into(),
                values: [1.0, 0.0, -5.0]
            }
        );
        assert_eq!(
            Reply::parse("[MSG:Pgm End]"),
            Reply::Message("Pgm End".into())
        );
        assert_eq!(
            Reply::parse("[VER:1.1h.20190830:mill]"),
            Reply::Version("1.1h.20190830:mill".into())
        );
    }

    #[test]
    fn reads_the_offsets_that_only_some_answers_have() {
        assert_eq!(Reply::parse("[TLO:1.500]"), Reply::ToolLength(1.5));
        assert_eq!(
            Reply::parse("[TLO:0.000,0.000,2.500]"),
            Reply::ToolLength(2.5)
        );
        let probed = |touched| Reply::Probed {
            at: [1.0, 2.0, -3.5],
            touched,
        };
        assert_eq!(Reply::parse("[PRB:1.000,2.000,-3.500:1]"), probed(true));
        assert_eq!(Reply::parse("[PRB:1.000,2.000,-3.500:0]"), probed(false));
    }

    #[test]
    fn damage_is_told_from_news() {
        for news in [
            "[AXS:3:XYZ]",
            "[NEWOPT:ENUMS]",
            "$N0=G20",
            ">G20G54:error:3",
            "ok",
            "[MSG:INFO: hello]",
        ] {
            assert!(!Reply::parse(news).is_damage(), "{news}");
        }
        for damage in [
            "o",
            "okok",
            "errr:2",
            "error:",
            "<Idle|MPos:0,0",
            "[MSG:Pgm E",
            "ALRM:1",
            "\u{fffd}k",
            "[A\u{fffd}S:x]",
        ] {
            assert!(Reply::parse(damage).is_damage(), "{damage}");
        }
    }

    proptest! {
        #[test]
        fn never_panics(text in "\\PC{0,80}") {
            let _ = Reply::parse(&text);
        }
    }
}
