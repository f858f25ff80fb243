//! The dialects that come with the program.

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        /// Name and text of each file in `posts/`, by rising name.
        pub const BUILT_IN: [(&str, &str); [$($name),*].len()] =
            [$(($name, include_str!(concat!("../../posts/", $name, ".toml")))),*];
    };
}

built_in![
    "carbide",
    "centroid",
    "edingcnc",
    "fanuc",
    "fluidnc",
    "grbl",
    "grblhal",
    "haas",
    "heidenhain",
    "linuxcnc",
    "mach3",
    "mach4",
    "marlin",
    "masso",
    "mazak",
    "okuma",
    "pathpilot",
    "planetcnc",
    "reprap",
    "siemens",
    "smoothie",
    "tinyg",
    "uccnc",
];

/// Interpreters a dialect can name as the one that reads its programs: the names of `gcode::Dialect`.
pub const READERS: [&str; 22] = [
    "grbl",
    "grblhal",
    "fluidnc",
    "linuxcnc",
    "mach3",
    "mach4",
    "uccnc",
    "edingcnc",
    "planetcnc",
    "fanuc",
    "haas",
    "siemens",
    "heidenhain",
    "mazak",
    "okuma",
    "centroid",
    "marlin",
    "smoothie",
    "reprap",
    "tinyg",
    "masso",
    "carbide",
];
