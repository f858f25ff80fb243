//! Controller families: which figures a machine file must, may and must not give, and what stands in for those it leaves out.
//!
//! Crosses the border: a family's name in; its rules out. Never knows dialects or single machines.

/// What sort of controller it is; that decides which figures there are to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// GRBL and its kin: every figure is a `$` setting, and the program comes over a serial line in GRBL's protocol.
    Grbl,
    /// Another open firmware on a board of its own: steps per mm are in its configuration, other planner figures may be.
    Firmware,
    /// Control software on a computer: programs are files, motors are set up in the software.
    Computer,
    /// A machine tool's own control: programs are files, and neither steps nor corner rules are the user's to see.
    Cabinet,
}

/// A controller family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Family {
    /// The name that machine files use. It is also the name of the family's dialect.
    pub name: &'static str,
    /// What people call it.
    pub title: &'static str,
    /// Its sort.
    pub kind: Kind,
}

const fn family(name: &'static str, title: &'static str, kind: Kind) -> Family {
    Family { name, title, kind }
}

/// All families: those the user most likely has come first.
pub const FAMILIES: [Family; 23] = [
    family("grbl", "GRBL 1.1", Kind::Grbl),
    family("grblhal", "grblHAL", Kind::Grbl),
    family("fluidnc", "FluidNC", Kind::Grbl),
    family("linuxcnc", "LinuxCNC", Kind::Computer),
    family("pathpilot", "PathPilot", Kind::Computer),
    family("mach3", "Mach3", Kind::Computer),
    family("mach4", "Mach4", Kind::Computer),
    family("uccnc", "UCCNC", Kind::Computer),
    family("edingcnc", "EdingCNC", Kind::Computer),
    family("planetcnc", "PlanetCNC TNG", Kind::Computer),
    family("fanuc", "Fanuc", Kind::Cabinet),
    family("haas", "Haas", Kind::Cabinet),
    family("siemens", "Sinumerik", Kind::Cabinet),
    family("heidenhain", "Heidenhain TNC", Kind::Cabinet),
    family("mazak", "Mazatrol (EIA/ISO)", Kind::Cabinet),
    family("okuma", "Okuma OSP", Kind::Cabinet),
    family("centroid", "Centroid CNC12", Kind::Computer),
    family("marlin", "Marlin", Kind::Firmware),
    family("smoothie", "Smoothieware", Kind::Firmware),
    family("reprap", "RepRapFirmware", Kind::Firmware),
    family("tinyg", "TinyG and g2core", Kind::Firmware),
    family("masso", "Masso", Kind::Computer),
    family("carbide", "Carbide Motion", Kind::Computer),
];

/// The names of all families.
pub const CONTROLLERS: [&str; FAMILIES.len()] = {
    let mut names = [""; FAMILIES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = FAMILIES[i].name;
        i += 1;
    }
    names
};

impl Family {
    /// The family of a name.
    pub fn of(name: &str) -> Option<&'static Family> {
        FAMILIES.iter().find(|f| f.name == name)
    }

    /// True when it understands GRBL's conversation over a serial line, so that `send` may talk to it.
    pub fn speaks_grbl(&self) -> bool {
        self.kind == Kind::Grbl
    }
}

/// Whether a key of a machine file has to be there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// It must be there.
    Must,
    /// It may be left out; then [`STAND_IN`] counts.
    May,
    /// There is no such figure on this sort of controller.
    Never,
}

/// Whether a file of this sort of controller has `key`, one of [`OPTIONAL_KEYS`].
pub fn need(kind: Kind, key: &str) -> Need {
    match (kind, key) {
        (Kind::Grbl, _) => Need::Must,
        (Kind::Firmware, "steps_per_mm") => Need::Must,
        (Kind::Cabinet, "planner_blocks") => Need::May,
        (Kind::Cabinet, _) => Need::Never,
        (Kind::Firmware | Kind::Computer, _) => Need::May,
    }
}

/// The keys that not every sort of controller has.
pub const OPTIONAL_KEYS: [&str; 6] = [
    "steps_per_mm",
    "junction_deviation_mm",
    "arc_tolerance_mm",
    "planner_blocks",
    "rx_buffer_bytes",
    "baud",
];

/// Figures of the planner model for controllers that do not tell theirs: full acceleration along the path, speed at a corner limited by
/// how far off it the path would be rounded, and look-ahead over so many blocks. They serve time estimates, never safety.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandIn {
    /// The least input increment of ISO controls in metric, 0.001 mm (Fanuc's IS-B), taken as the step.
    pub steps_per_mm: f64,
    /// mm. GRBL's usual one: servo machines corner faster, so that times come out rather long.
    pub junction_deviation: f64,
    /// mm. They cut true arcs; the chords of the model differ from one by so much.
    pub arc_tolerance: f64,
    /// Fewer than any of these controls is sold with (LinuxCNC has 50, Haas 80).
    pub planner_blocks: usize,
    /// Bytes. Programs are files; a line may be so long in LinuxCNC.
    pub rx_buffer: usize,
    /// No serial line.
    pub baud: u32,
}

/// See [`StandIn`].
pub const STAND_IN: StandIn = StandIn {
    steps_per_mm: 1000.0,
    junction_deviation: 0.01,
    arc_tolerance: 0.002,
    planner_blocks: 20,
    rx_buffer: 255,
    baud: 0,
};
