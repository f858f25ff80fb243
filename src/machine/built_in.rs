//! The machines that come with the program.

/// The machines that come with the program: name and text of each file in `machines/`, by rising name.
pub const BUILT_IN: [(&str, &str); 8] = [
    (
        "altmill-4x4",
        include_str!("../../machines/altmill-4x4.toml"),
    ),
    ("grbl-3018", include_str!("../../machines/grbl-3018.toml")),
    (
        "longmill-30x30",
        include_str!("../../machines/longmill-30x30.toml"),
    ),
    (
        "shapeoko-3-xxl",
        include_str!("../../machines/shapeoko-3-xxl.toml"),
    ),
    (
        "sherline-5400",
        include_str!("../../machines/sherline-5400.toml"),
    ),
    (
        "tormach-pcnc440",
        include_str!("../../machines/tormach-pcnc440.toml"),
    ),
    (
        "workbee-1010",
        include_str!("../../machines/workbee-1010.toml"),
    ),
    (
        "x-carve-1000",
        include_str!("../../machines/x-carve-1000.toml"),
    ),
];
