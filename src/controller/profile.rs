//! Which firmware is played, and which of its oddities.

use super::intake::Cutting;
use crate::gcode::Dialect;
use crate::wire::Realtime;

/// The firmware played.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// GRBL 1.1h (20190830), default build on an Uno.
    #[default]
    Grbl11h,
    /// GRBL 1.1f (20170801), default build on an Uno.
    Grbl11f,
    /// grblHAL: what a sender must notice of it.
    GrblHal,
    /// FluidNC: what a sender must notice of it.
    FluidNc,
}

impl Profile {
    /// Every profile there is.
    pub const ALL: [Profile; 4] = [
        Profile::Grbl11h,
        Profile::Grbl11f,
        Profile::GrblHal,
        Profile::FluidNc,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Grbl11h => "grbl-1.1h",
            Profile::Grbl11f => "grbl-1.1f",
            Profile::GrblHal => "grblhal",
            Profile::FluidNc => "fluidnc",
        }
    }

    /// Whose G-code it reads.
    pub(super) fn dialect(self) -> Dialect {
        match self {
            Profile::Grbl11h | Profile::Grbl11f => Dialect::Grbl,
            Profile::GrblHal => Dialect::GrblHal,
            Profile::FluidNc => Dialect::FluidNc,
        }
    }

    /// How it cuts lines.
    pub(super) fn cutting(self, quirks: &Quirks, options: &Options) -> Cutting {
        let stock = Cutting {
            most: options.line_chars,
            crlf_twice: quirks.crlf_twice,
            slash_passes: quirks.slash_passes,
            ..Cutting::default()
        };
        match self {
            Profile::Grbl11h | Profile::Grbl11f => stock,
            Profile::GrblHal => Cutting {
                crlf_twice: false,
                most: 255,
                ..stock
            },
            Profile::FluidNc => Cutting {
                crlf_twice: false,
                most: 254,
                truncates: true,
                ..stock
            },
        }
    }

    /// What `$I` says around the user's text: in front of it, behind it with the numbers of blocks and bytes filled in.
    pub(super) fn build_info(
        self,
        text: &str,
        blocks: usize,
        rx: usize,
        options: &Options,
    ) -> Vec<String> {
        let letters = options.letters();
        match self {
            Profile::Grbl11h => vec![
                format!("[VER:1.1h.20190830:{text}]"),
                format!("[OPT:{letters},{blocks},{rx}]"),
            ],
            Profile::Grbl11f => vec![
                format!("[VER:1.1f.20170801:{text}]"),
                format!("[OPT:{letters},{blocks},{rx}]"),
            ],
            Profile::GrblHal => vec![
                format!("[VER:1.1f.20260817:{text}]"),
                format!("[OPT:VNMSL,{blocks},{rx},3,0]"),
                "[AXS:3:XYZ]".to_string(),
                "[NEWOPT:ENUMS,RT+,HOME]".to_string(),
                "[FIRMWARE:grblHAL]".to_string(),
                "[SIGNALS:HSEP]".to_string(),
            ],
            Profile::FluidNc => vec![
                format!("[VER:3.9 FluidNC v3.9.1:{text}]"),
                "[OPT:PHS]".to_string(),
            ],
        }
    }

    /// After an error it refuses all further G-code until it is spoken to otherwise.
    pub(super) fn walls(self) -> bool {
        self == Profile::GrblHal
    }

    /// What it makes of a byte on arrival; `None`: it belongs to a line.
    pub(super) fn realtime(self, byte: u8) -> Option<Realtime> {
        match (self, byte) {
            (Profile::GrblHal, 0x80 | 0x87) => Some(Realtime::Status),
            (Profile::GrblHal, 0x81) => Some(Realtime::Resume),
            (Profile::GrblHal, 0x82) => Some(Realtime::Hold),
            (Profile::GrblHal, 0x19) => Some(Realtime::Reset),
            _ => Realtime::from_byte(byte),
        }
    }

    /// The line it greets with.
    pub(super) fn welcome(self) -> &'static str {
        match self {
            Profile::Grbl11h => "Grbl 1.1h ['$' for help]",
            Profile::Grbl11f => "Grbl 1.1f ['$' for help]",
            Profile::GrblHal => "GrblHAL 1.1f ['$' or '$HELP' for help]",
            Profile::FluidNc => "Grbl 3.9 [FluidNC v3.9.1 (wifi) '$' for help]",
        }
    }

    /// Bytes of its receive buffer.
    pub fn rx_bytes(self) -> usize {
        match self {
            Profile::GrblHal => 1024,
            Profile::Grbl11h | Profile::Grbl11f | Profile::FluidNc => crate::wire::RX_BYTES,
        }
    }
}

/// What the maker of a build can choose before compiling it. The default is the firmware as shipped: some errors and alarms can only
/// be raised by other builds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// The spindle's speed is set by a pulse width. Without: reports say `F:` instead of `FS:`, and laser mode is error 17.
    pub variable_spindle: bool,
    /// The highest step rate that settings may ask for, steps a second (error 12); `None`: any.
    pub most_steps_per_second: Option<u32>,
    /// Significant characters that a line may have. Longer ones than a place in memory holds bring error 14.
    pub line_chars: usize,
    /// Y has two motors with a switch each, and the second one's is met so many micrometres behind the first one's. Too far apart, and
    /// homing ends in alarm 10.
    pub second_y_switch_um: Option<u32>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            variable_spindle: true,
            most_steps_per_second: None,
            line_chars: crate::wire::LINE_CHARS,
            second_y_switch_um: None,
        }
    }
}

impl Options {
    /// The letters that `$I` shows for it.
    pub(super) fn letters(&self) -> String {
        let spindle = if self.variable_spindle { "V" } else { "" };
        let dual = if self.second_y_switch_um.is_some() {
            "2"
        } else {
            ""
        };
        format!("{spindle}{dual}")
    }
}

/// A name that is no profile.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no firmware {0:?} is simulated: name one of grbl-1.1h, grbl-1.1f, grblhal, fluidnc")]
pub struct UnknownProfile(pub String);

impl std::str::FromStr for Profile {
    type Err = UnknownProfile;

    fn from_str(text: &str) -> Result<Profile, UnknownProfile> {
        Profile::ALL
            .into_iter()
            .find(|p| p.name() == text)
            .ok_or_else(|| UnknownProfile(text.to_string()))
    }
}

/// Oddities that can be switched off (or on) one by one. The default is the firmware as shipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quirks {
    /// An `ok` for the line that was cut off comes before the welcome of a reset.
    pub stray_ok: bool,
    /// CR LF counts as two line ends and gets two answers.
    pub crlf_twice: bool,
    /// Bytes that arrive on a timed line while settings or offsets are written are lost. Off unless asked for: the recordings were
    /// made on an emulated chip, which keeps them.
    pub eeprom_byte_loss: bool,
    /// G10, G28.1 and G30.1 write in check mode too.
    pub check_writes: bool,
    /// `$J=F100` without axis words drives to machine zero.
    pub jog_to_zero: bool,
    /// `$HX` without single-axis homing leaves the state stuck in Home.
    pub home_axis_wedge: bool,
    /// `~` is lost while a hold is not yet at rest.
    pub resume_lost: bool,
    /// T falls back to 0 with the next line that has none.
    pub tool_falls: bool,
    /// `/` is passed over, so a deleted block runs.
    pub slash_passes: bool,
    /// Byte settings above 255 wrap around.
    pub byte_wrap: bool,
    /// The build has a pin for the safety door.
    pub door_pin: bool,
}

impl Default for Quirks {
    fn default() -> Quirks {
        Quirks {
            stray_ok: true,
            crlf_twice: true,
            eeprom_byte_loss: false,
            check_writes: true,
            jog_to_zero: true,
            home_axis_wedge: true,
            resume_lost: true,
            tool_falls: true,
            slash_passes: true,
            byte_wrap: true,
            door_pin: false,
        }
    }
}
