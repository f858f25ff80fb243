//! EdingCNC and PlanetCNC.

use super::Meaning::*;
use super::common::*;
use super::{Entry, Rules};
use crate::gcode::codes::{Group, Letters};
use crate::gcode::cycle::CycleRules;

static CYCLE_RULES: CycleRules = CycleRules {
    repeats: b"L",
    ..CycleRules::NIST
};

const MODES: &[Entry] = &[
    INVERSE_TIME,
    PER_TURN,
    (3300, Refused(THREADING)),
    (5000, Nothing(Group::Scaling, NONE, "scaling off")),
    (5100, Refused(SCALING)),
    (6800, Refused(ROTATION)),
    (6900, Nothing(Group::Rotation, NONE, "rotation off")),
    (9600, Refused(SURFACE_SPEED)),
    (
        9700,
        Nothing(
            Group::SpindleMode,
            NONE,
            "spindle speed in turns per minute",
        ),
    ),
];

const NO_PROGRAMS: &str =
    "subprograms are called by GOSUB here, which is not read; write their moves out";

pub(super) static EDING: Rules = Rules {
    title: "EdingCNC",
    source: "EDINGCNC Manual, chapter G-code (interpreter after NIST RS-274)",
    assumed: &[
        "G73 and G83 back off by 0.254 mm",
        "G28 and G30 go to the stored places, machine zero unless set",
    ],
    g: &[
        BASE,
        RADIUS,
        MOTION_OFF,
        PROBES,
        OFFSETS,
        ARC_CENTERS,
        TABLE_LENGTH,
        DYNAMIC_LENGTH,
        PATHS,
        SHIFTS,
        NINE_OFFSETS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        MODES,
        &[
            (
                5200,
                Refused("how it adds to G92 is not documented here; use G54 to G59.3"),
            ),
            (700, Refused("lathe diameters; this is a mill")),
            (800, Refused("lathe radii; this is a mill")),
        ],
    ],
    m: &[
        M_BASE,
        M_TOOLED,
        M_OVERRIDES,
        M_PALLET,
        &[(9800, Refused(NO_PROGRAMS)), (9900, Refused(NO_PROGRAMS))],
    ],
    tool_limit: 99,
    blend_words: Letters::of(b"PQ"),
    offsets: 9,
    cycles: Some(&CYCLE_RULES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};

pub(super) static PLANET: Rules = Rules {
    title: "PlanetCNC TNG",
    source: "PlanetCNC TNG User's Guide and G-code Reference",
    assumed: &[
        "arc centres are incremental until G90.1",
        "G73 and G83 back off by 0.254 mm",
    ],
    g: &[
        BASE,
        RADIUS,
        MOTION_OFF,
        PROBES,
        OFFSETS,
        STORED_HOMES,
        ARC_CENTERS,
        TABLE_LENGTH,
        DYNAMIC_LENGTH,
        PATHS,
        SHIFTS,
        NINE_OFFSETS,
        RETRACTS,
        &[G73, G81, G82, G83, G85, G86, G89],
        OTHER_CYCLES,
        MODES,
        &[
            (
                5200,
                Refused("how it adds to G92 is not documented here; use G54 to G59.3"),
            ),
            (500, Refused(SPLINE)),
            (510, Refused(SPLINE)),
            (
                4320,
                Refused("it adds a second tool length; name one by G43 H"),
            ),
            (1600, Refused(POLAR)),
            (1500, Nothing(Group::Polar, NONE, "polar coordinates off")),
        ],
    ],
    m: &[
        M_BASE,
        M_TOOLED,
        M_OVERRIDES,
        M_PALLET,
        &[
            (6200, Refused(PORTS)),
            (6300, Refused(PORTS)),
            (6400, Refused(PORTS)),
            (6500, Refused(PORTS)),
        ],
    ],
    letters: Letters::of(b"FHIJKLNPQRSTXYZ"),
    blend_words: Letters::of(b"PQ"),
    offsets: 9,
    cycles: Some(&CYCLE_RULES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};
