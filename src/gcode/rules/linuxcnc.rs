//! LinuxCNC, and PathPilot, which is built on it.

use super::Meaning::*;
use super::common::*;
use super::{Entry, LineLength, Rules};
use crate::gcode::codes::{Group, Letters};
use crate::gcode::cycle::CycleRules;

const SYNC: &str =
    "it switches an output in time with the motion; what that does is not known here";

const OWN: &[Entry] = &[
    INVERSE_TIME,
    PER_TURN,
    LOCAL,
    (500, Refused(SPLINE)),
    (510, Refused(SPLINE)),
    (520, Refused(SPLINE)),
    (530, Refused(SPLINE)),
    (700, Refused("lathe diameters; this is a mill")),
    (800, Refused("lathe radii; this is a mill")),
    (3300, Refused(THREADING)),
    (3310, Refused(TAPPING)),
    (4110, Refused(COMPENSATION)),
    (4210, Refused(COMPENSATION)),
    (
        4320,
        Refused("it adds a second tool length; name one by G43 H"),
    ),
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

const OWN_M: &[Entry] = &[
    (
        5000,
        Nothing(Group::Override, Letters::of(b"P"), "feed override"),
    ),
    (
        5100,
        Nothing(Group::Override, Letters::of(b"P"), "spindle override"),
    ),
    (
        5200,
        Refused("adaptive feed follows a signal that is not known here"),
    ),
    (
        5300,
        Nothing(Group::Override, Letters::of(b"P"), "feed stop"),
    ),
    (6100, Refused(SET_TOOL)),
    (6200, Refused(SYNC)),
    (6300, Refused(SYNC)),
    (6400, Refused(PORTS)),
    (6500, Refused(PORTS)),
    (6600, Refused(PORTS)),
    (6700, Refused(PORTS)),
    (6800, Refused(PORTS)),
    (7000, Refused(STATE_STACK)),
    (7100, Refused(STATE_STACK)),
    (7200, Refused(STATE_STACK)),
    (7300, Refused(STATE_STACK)),
];

static CYCLE_RULES: CycleRules = CycleRules {
    from_series: true,
    // G73_PECK_CLEARANCE and G83_PECK_CLEARANCE of a metric machine, where its INI file says nothing (INI Configuration).
    back: 1.0,
    repeats: b"L",
    ..CycleRules::NIST
};

pub(super) static LINUXCNC: Rules = Rules {
    title: "LinuxCNC 2.8 and later; PathPilot",
    source: "LinuxCNC manual (G-Code Reference, M-Code Reference, G-Code Overview)",
    assumed: &[
        "G73 and G83 back off by 1 mm (G73_PECK_CLEARANCE, G83_PECK_CLEARANCE of a metric machine in G21; in G20 it may be another length)",
    ],
    g: &[
        BASE,
        RADIUS,
        MOTION_OFF,
        PROBES,
        OFFSETS,
        STORED_HOMES,
        ARC_CENTERS,
        DYNAMIC_LENGTH,
        TABLE_LENGTH,
        PATHS,
        SHIFTS,
        NINE_OFFSETS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        OWN,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, M_ORIENT, M_PALLET, OWN_M],
    length: LineLength::All(255),
    blend_words: Letters::of(b"PQ"),
    turns: true,
    offsets: 9,
    cycles: Some(&CYCLE_RULES),
    ..PLAIN
};
