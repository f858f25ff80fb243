//! Which controller reads the program.

/// A controller family whose rules a program is read by: which codes exist and how strictly they are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Dialect {
    /// GRBL 1.1 as shipped (no M7, no line-number reports).
    Grbl,
    /// grblHAL.
    GrblHal,
    /// FluidNC 3.
    FluidNc,
    /// LinuxCNC 2.8 and later; PathPilot.
    LinuxCnc,
    /// Mach3 Mill.
    Mach3,
    /// Mach4 Mill.
    Mach4,
    /// UCCNC.
    UccNc,
    /// EdingCNC.
    Eding,
    /// PlanetCNC TNG.
    Planet,
    /// Fanuc 0i-F and 30i, machining centre.
    Fanuc,
    /// Haas mill, NGC.
    Haas,
    /// Sinumerik 840D sl, its own language.
    Siemens,
    /// Heidenhain TNC, conversational.
    Heidenhain,
    /// Mazak, EIA/ISO.
    Mazak,
    /// Okuma OSP, machining centre.
    Okuma,
    /// Centroid CNC12 Mill.
    Centroid,
    /// Marlin 2.
    Marlin,
    /// Smoothieware, CNC build.
    Smoothie,
    /// RepRapFirmware 3, CNC mode.
    RepRap,
    /// TinyG and g2core.
    TinyG,
    /// Masso G3.
    Masso,
    /// Carbide Motion.
    Carbide,
}

impl Dialect {
    /// All of them, in the order of the type.
    pub const ALL: [Dialect; 22] = [
        Dialect::Grbl,
        Dialect::GrblHal,
        Dialect::FluidNc,
        Dialect::LinuxCnc,
        Dialect::Mach3,
        Dialect::Mach4,
        Dialect::UccNc,
        Dialect::Eding,
        Dialect::Planet,
        Dialect::Fanuc,
        Dialect::Haas,
        Dialect::Siemens,
        Dialect::Heidenhain,
        Dialect::Mazak,
        Dialect::Okuma,
        Dialect::Centroid,
        Dialect::Marlin,
        Dialect::Smoothie,
        Dialect::RepRap,
        Dialect::TinyG,
        Dialect::Masso,
        Dialect::Carbide,
    ];

    /// The name that posts, machines and the command line use.
    pub fn name(self) -> &'static str {
        match self {
            Dialect::Grbl => "grbl",
            Dialect::GrblHal => "grblhal",
            Dialect::FluidNc => "fluidnc",
            Dialect::LinuxCnc => "linuxcnc",
            Dialect::Mach3 => "mach3",
            Dialect::Mach4 => "mach4",
            Dialect::UccNc => "uccnc",
            Dialect::Eding => "edingcnc",
            Dialect::Planet => "planetcnc",
            Dialect::Fanuc => "fanuc",
            Dialect::Haas => "haas",
            Dialect::Siemens => "siemens",
            Dialect::Heidenhain => "heidenhain",
            Dialect::Mazak => "mazak",
            Dialect::Okuma => "okuma",
            Dialect::Centroid => "centroid",
            Dialect::Marlin => "marlin",
            Dialect::Smoothie => "smoothie",
            Dialect::RepRap => "reprap",
            Dialect::TinyG => "tinyg",
            Dialect::Masso => "masso",
            Dialect::Carbide => "carbide",
        }
    }

    /// The dialect of a name, as [`Dialect::name`] writes it.
    pub fn from_name(name: &str) -> Option<Dialect> {
        Dialect::ALL.into_iter().find(|d| d.name() == name)
    }
}
