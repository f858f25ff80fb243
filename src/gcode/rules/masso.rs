//! Masso G3, mill and router.

use super::Meaning::*;
use super::common::*;
use super::{Entry, OffsetTwenty, Rules, Unit};
use crate::gcode::codes::{Group, Letters};
use crate::gcode::cycle::CycleRules;

const OWN: &[Entry] = &[
    INVERSE_TIME,
    PER_TURN,
    (
        5200,
        Refused("how it adds to G92 is not documented here; use G54 to G59"),
    ),
    (2810, Refused(REFERENCE)),
    (3800, Refused(SKIP)),
    (
        3820,
        Refused("probing is set up at the control; what it does there is not known here"),
    ),
    (3100, Refused(SKIP)),
    (
        6400,
        Nothing(Group::Path, Letters::of(b"P"), "cutting mode"),
    ),
    (6100, Path(crate::gcode::codes::Path::Stop)),
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

static CYCLE_RULES: CycleRules = CycleRules {
    repeats: b"",
    dwell: Unit::Milliseconds,
    ..CycleRules::NIST
};

pub(super) static MASSO: Rules = Rules {
    title: "Masso G3",
    source: "MASSO documentation, Supported G-codes (G02, G03, G53, N) and M-codes (M98); dwell as Autodesk's MASSO post has it",
    assumed: &[
        "G4 P is in milliseconds (general settings)",
        "R tells an arc whatever its length (the maker promises no more than 90 degrees)",
        "G73 and G83 back off by 0.254 mm",
        "G28 and G30 go to machine zero",
    ],
    g: &[
        OWN,
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        ARC_CENTERS,
        TABLE_LENGTH,
        &[CLEAR_SHIFT],
        RETRACTS,
        &[G73, G81, G82, G83],
        OTHER_CYCLES,
    ],
    m: &[
        M_BASE,
        M_TOOLED,
        M_OVERRIDES,
        &[
            (
                1000,
                Refused("here it clamps or fires something; what is not known here"),
            ),
            (
                1100,
                Refused("here it clamps or fires something; what is not known here"),
            ),
            (6200, Refused(PORTS)),
            (6300, Refused(PORTS)),
            (6400, Refused(PORTS)),
            (6500, Refused(PORTS)),
            (6600, Refused(PORTS)),
        ],
    ],
    letters: Letters::of(b"FHIJKLNOPQRSTXYZ"),
    tool_limit: 104,
    dwell: &[(b'P', Unit::Milliseconds)],
    dwell_words: "P (milliseconds)",
    twenty: OffsetTwenty::No,
    cycles: Some(&CYCLE_RULES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};
