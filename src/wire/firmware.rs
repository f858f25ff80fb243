//! Which firmware of GRBL's family is at the other end, and what that changes for a sender.

use super::Reply;

/// A firmware that speaks GRBL 1.1's protocol.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Firmware {
    /// GRBL 1.1 as published (gnea/grbl), and builds that say the same.
    Grbl11,
    /// grblHAL.
    GrblHal,
    /// FluidNC (and Grbl_Esp32, whose child it is).
    FluidNc,
    /// It greeted like one of the family but is none of these: GRBL 1.1's rules are assumed, and no number is explained as certain.
    #[default]
    Unknown,
}

impl Firmware {
    /// What one line gives away, if anything. Greetings: `Grbl 1.1h ['$' for help]`, `GrblHAL 1.1f [...]` (or `Grbl` by its
    /// compatibility level), `Grbl 3.7 [FluidNC v3.7.8 ...]`. Answers to `$I`: `[VER:...]` and grblHAL's `[FIRMWARE:grblHAL]`.
    pub fn told_by(reply: &Reply) -> Option<Firmware> {
        let text = match reply {
            Reply::Welcome {
                firmware,
                version,
                text,
            } => {
                return Some(
                    named(firmware)
                        .or_else(|| named(text))
                        .unwrap_or_else(|| by_version(version)),
                );
            }
            Reply::Version(text) => {
                return Some(named(text).unwrap_or_else(|| by_version(text)));
            }
            Reply::FirmwareName(text) => text,
            _ => return None,
        };
        named(text)
    }

    /// What people call it.
    pub fn title(self) -> &'static str {
        match self {
            Firmware::Grbl11 => "GRBL 1.1",
            Firmware::GrblHal => "grblHAL",
            Firmware::FluidNc => "FluidNC",
            Firmware::Unknown => "an unknown relative of GRBL",
        }
    }

    /// The meaning of its `error:code`, if its tables have one.
    pub fn error(self, code: u16) -> Option<super::Meaning> {
        super::forks::error(self, code)
    }

    /// The meaning of its `ALARM:code`, if its tables have one.
    pub fn alarm(self, code: u16) -> Option<super::Meaning> {
        super::forks::alarm(self, code)
    }

    /// Most characters of a line that count (blanks and comments do not). GRBL 1.1 and grblHAL answer error 11 to more; FluidNC cuts
    /// the line without a word.
    pub fn line_chars(self) -> usize {
        match self {
            Firmware::Grbl11 | Firmware::Unknown => super::LINE_CHARS,
            Firmware::GrblHal => 255,
            Firmware::FluidNc => 254,
        }
    }
}

fn named(text: &str) -> Option<Firmware> {
    let text = text.to_ascii_lowercase();
    if text.contains("grblhal") {
        Some(Firmware::GrblHal)
    } else if text.contains("fluidnc") || text.contains("esp32") {
        Some(Firmware::FluidNc)
    } else {
        None
    }
}

fn by_version(version: &str) -> Firmware {
    match version.starts_with("1.1") {
        true => Firmware::Grbl11,
        false => Firmware::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greetings_and_build_lines_name_the_firmware() {
        for (line, firmware) in [
            ("Grbl 1.1h ['$' for help]", Some(Firmware::Grbl11)),
            (
                "GrblHAL 1.1f ['$' or '$HELP' for help]",
                Some(Firmware::GrblHal),
            ),
            (
                "Grbl 1.1f ['$' or '$HELP' for help]",
                Some(Firmware::Grbl11),
            ),
            ("[FIRMWARE:grblHAL]", Some(Firmware::GrblHal)),
            (
                "Grbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]",
                Some(Firmware::FluidNc),
            ),
            ("[VER:3.7 FluidNC v3.7.8:]", Some(Firmware::FluidNc)),
            ("[VER:1.3a.20210424: Grbl_ESP32]", Some(Firmware::FluidNc)),
            ("[VER:1.1h.20190830:]", Some(Firmware::Grbl11)),
            ("Grbl 0.9j ['$' for help]", Some(Firmware::Unknown)),
            ("ok", None),
            ("[MSG:grblHAL]", None),
        ] {
            assert_eq!(Firmware::told_by(&Reply::parse(line)), firmware, "{line}");
        }
    }
}
