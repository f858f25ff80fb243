//! The machines that come with the program.

/// Name and text of each file in `machines/`, by rising name.
pub const BUILT_IN: [(&str, &str); 26] = [
    (
        "altmill-4x4",
        include_str!("../../machines/altmill-4x4.toml"),
    ),
    (
        "avid-pro4848-mach4",
        include_str!("../../machines/avid-pro4848-mach4.toml"),
    ),
    ("carvera", include_str!("../../machines/carvera.toml")),
    (
        "dmg-dmc635v-siemens",
        include_str!("../../machines/dmg-dmc635v-siemens.toml"),
    ),
    (
        "dmg-dmu50-heidenhain",
        include_str!("../../machines/dmg-dmu50-heidenhain.toml"),
    ),
    ("grbl-3018", include_str!("../../machines/grbl-3018.toml")),
    (
        "haas-mini-mill",
        include_str!("../../machines/haas-mini-mill.toml"),
    ),
    ("haas-vf-2", include_str!("../../machines/haas-vf-2.toml")),
    (
        "longmill-30x30",
        include_str!("../../machines/longmill-30x30.toml"),
    ),
    ("lowrider-3", include_str!("../../machines/lowrider-3.toml")),
    (
        "mazak-vcn-530c",
        include_str!("../../machines/mazak-vcn-530c.toml"),
    ),
    (
        "mpcnc-duet3",
        include_str!("../../machines/mpcnc-duet3.toml"),
    ),
    (
        "mpcnc-marlin",
        include_str!("../../machines/mpcnc-marlin.toml"),
    ),
    ("nomad-3", include_str!("../../machines/nomad-3.toml")),
    (
        "okuma-genos-m460-ve",
        include_str!("../../machines/okuma-genos-m460-ve.toml"),
    ),
    (
        "onefinity-elite-masso",
        include_str!("../../machines/onefinity-elite-masso.toml"),
    ),
    (
        "othermill-v2",
        include_str!("../../machines/othermill-v2.toml"),
    ),
    (
        "robodrill-d21mib5",
        include_str!("../../machines/robodrill-d21mib5.toml"),
    ),
    (
        "shapeoko-2-tinyg",
        include_str!("../../machines/shapeoko-2-tinyg.toml"),
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
        "stepcraft-d840-uccnc",
        include_str!("../../machines/stepcraft-d840-uccnc.toml"),
    ),
    (
        "tormach-pcnc1100-mach3",
        include_str!("../../machines/tormach-pcnc1100-mach3.toml"),
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
