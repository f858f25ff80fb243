//! Mach3, Mach4, UCCNC: controls on a PC that began with NIST's interpreter.

use super::Meaning::*;
use super::common::*;
use super::{Entry, OffsetTwenty, Rules, Unit};
use crate::gcode::codes::{Group, Letters};
use crate::gcode::cycle::CycleRules;

const POCKET: &str = "the circular pocket moves by the control's own rules; write the moves out";
const NO_HANDLE: &str = "it is a macro that only this machine knows; write out what it does";

const OWN: &[Entry] = &[
    INVERSE_TIME,
    PER_TURN,
    (1200, Refused(POCKET)),
    (1300, Refused(POCKET)),
    (1500, Nothing(Group::Polar, NONE, "polar coordinates off")),
    (1600, Refused(POLAR)),
    (2810, Refused(REFERENCE)),
    (3100, Refused(SKIP)),
    (5000, Nothing(Group::Scaling, NONE, "scaling off")),
    (5100, Refused(SCALING)),
    (6800, Refused(ROTATION)),
    (6900, Nothing(Group::Rotation, NONE, "rotation off")),
    (7000, Refused("here it may mean inches; write G20")),
    (7100, Refused("here it may mean millimetres; write G21")),
    (9600, Refused(SURFACE_SPEED)),
    (
        9700,
        Nothing(
            Group::SpindleMode,
            NONE,
            "spindle speed in turns per minute",
        ),
    ),
    (4400, Refused(MINUS_LENGTH)),
];

const AGAIN: &[Entry] = &[(
    4700,
    Refused("it runs the program again and again; write M30, and start it again by hand"),
)];

const MACH3_OWN: &[Entry] = &[(
    5200,
    Refused("Mach3 keeps it together with G92 in ways that differ by version; use G54 to G59"),
)];

static CYCLE_RULES: CycleRules = CycleRules {
    repeats: b"L",
    ..CycleRules::NIST
};

pub(super) static MACH3: Rules = Rules {
    title: "Mach3 Mill",
    source: "Using Mach3Mill (Artsoft), chapter 10: Mach3 G- and M-code language reference",
    assumed: &[
        "G4 P is in seconds (General Config: G04 Dwell in ms is off)",
        "arc centres are incremental until G90.1 (General Config: IJ mode)",
        "G73 and G83 back off by 0.254 mm",
        "G28 and G30 go to machine zero",
    ],
    g: &[
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        ARC_CENTERS,
        TABLE_LENGTH,
        PATHS,
        SHIFTS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        OWN,
        MACH3_OWN,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, AGAIN],
    letters: Letters::of(b"FHIJKLNOPQRSTXYZ"),
    tool_limit: 255,
    twenty: OffsetTwenty::No,
    offsets: 254,
    offset_p: Some((5, 0, 254)),
    cycles: Some(&CYCLE_RULES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};

static UCCNC_CYCLES: CycleRules = CycleRules {
    repeats: b"L",
    dwell: Unit::Milliseconds,
    ..CycleRules::NIST
};

static MACH4_CYCLES: CycleRules = CycleRules {
    repeats: b"K",
    ..CycleRules::INDUSTRY
};

pub(super) static MACH4: Rules = Rules {
    title: "Mach4 Mill",
    source: "Mach4 CNC Controller Mill G-Code Reference Manual (Newfangled Solutions)",
    assumed: &[
        "G4 P is in seconds (General tab: G04 dwell), P of drilling cycles in milliseconds",
        "arc centres are incremental until G90.1",
        "G73 and G83 back off by 1 mm",
        "G28 and G30 go to machine zero",
    ],
    g: &[
        &[
            (
                5410,
                WorkOffsetBy {
                    letter: b'P',
                    base: 6,
                    most: 248,
                },
            ),
            LOCAL,
        ],
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        ARC_CENTERS,
        TABLE_LENGTH,
        PLAIN_PATHS,
        SHIFTS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        OWN,
        INDUSTRY,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, M_ORIENT, AGAIN],
    letters: Letters::of(b"FHIJKLNOPQRSTXYZ"),
    twenty: OffsetTwenty::Further(248),
    home_beside_motion: true,
    cycles: Some(&MACH4_CYCLES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};

pub(super) static UCCNC: Rules = Rules {
    title: "UCCNC",
    source: "not verified against the maker's manual; Autodesk's and FreeCAD's open posts for UCCNC, and NIST's rules",
    assumed: &[
        "G4 P is in milliseconds (General settings)",
        "G20 and G21 do what they say (some versions pass over them and take the units of the profile)",
        "arc centres are incremental until G90.1",
        "G73 and G83 back off by 0.254 mm",
        "G28 and G30 go to machine zero",
    ],
    g: &[
        &[(
            5200,
            Refused("how it adds to G92 is not documented here; use G54 to G59"),
        )],
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        ARC_CENTERS,
        TABLE_LENGTH,
        PATHS,
        &[CLEAR_SHIFT],
        RETRACTS,
        &[G73, G81, G82, G83],
        OTHER_CYCLES,
        OWN,
    ],
    m: &[
        M_BASE,
        M_TOOLED,
        M_OVERRIDES,
        AGAIN,
        &[(3100, Refused(NO_HANDLE))],
    ],
    letters: Letters::of(b"FHIJKLNOPQRSTXYZ"),
    tool_limit: 96,
    dwell: &[(b'P', Unit::Milliseconds)],
    dwell_words: "P (milliseconds)",
    cycles: Some(&UCCNC_CYCLES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};
