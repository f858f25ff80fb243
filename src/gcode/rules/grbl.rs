//! GRBL 1.1, grblHAL, FluidNC, Carbide Motion.

use super::Meaning::*;
use super::common::*;
use super::{ArcMiss, BlockDelete, Entry, LineLength, Parentheses, Rules};
use crate::gcode::codes::{Group, Letters, Path};
use crate::gcode::cycle::{CycleRules, Pecking};
use crate::gcode::state::Distance;

const FIRMWARE: &[Entry] = &[
    INVERSE_TIME,
    CLEAR_SHIFT,
    (9110, ArcDistance(Distance::Incremental)),
    (6100, Path(Path::Exact)),
];

/// Checked against the firmware itself; `tests/gcode/grbl-answers.tsv` and the recordings hold its answers.
pub(super) static GRBL: Rules = Rules {
    title: "GRBL 1.1",
    source: "GRBL v1.1 wiki (Commands, Interface) and the answers of GRBL 1.1h",
    g: &[
        BASE,
        MOTION_OFF,
        PROBES,
        OFFSETS,
        STORED_HOMES,
        DYNAMIC_LENGTH,
        FIRMWARE,
    ],
    m: &[M_BASE],
    letters: Letters::of(b"FIJKLNPRSTXYZ"),
    refused: &[],
    positive: Letters::of(b"FNPST"),
    tool_limit: 255,
    length: LineLength::Significant(79),
    digits: 8,
    parentheses: Parentheses::Loose,
    block_delete: BlockDelete::Ignored,
    firmware: true,
    arc_miss: ArcMiss::Grbl,
    whole_circle: false,
    ..PLAIN
};

const HAL_REFUSED: &[Entry] = &[
    (500, Refused(SPLINE)),
    (510, Refused(SPLINE)),
    (3300, Refused(THREADING)),
    (3310, Refused(TAPPING)),
    (
        4320,
        Refused("it adds a second tool length; name one by G43 H"),
    ),
    (5000, Nothing(Group::Scaling, NONE, "scaling off")),
    (5100, Refused(SCALING)),
    (700, Refused("lathe diameters; this is a mill")),
    (800, Refused("lathe radii; this is a mill")),
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

const HAL_M: &[Entry] = &[
    (6100, Refused(SET_TOOL)),
    (6200, Refused(PORTS)),
    (6300, Refused(PORTS)),
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

/// grblHAL's peck retract is setting $28, 0.1 mm as shipped; it waits a quarter of a second at the end of every peck.
static HAL_CYCLES: CycleRules = CycleRules {
    pecking: Pecking::GrblHal { wait: 0.25 },
    back: 0.1,
    repeats: b"L",
    ..CycleRules::NIST
};

pub(super) static GRBLHAL: Rules = Rules {
    title: "grblHAL",
    source: "grblHAL core: wiki (Supported G-codes), gcode.c, motion_control.c",
    assumed: &["peck retract $28 is 0.1 mm, as shipped"],
    g: &[
        BASE,
        RADIUS,
        MOTION_OFF,
        PROBES,
        OFFSETS,
        STORED_HOMES,
        DYNAMIC_LENGTH,
        FIRMWARE,
        NINE_OFFSETS,
        TABLE_LENGTH,
        SHIFTS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        HAL_REFUSED,
        &[PER_TURN],
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, HAL_M],
    letters: Letters::of(b"FHIJKLNPQRSTXYZ"),
    length: LineLength::Significant(255),
    parentheses: Parentheses::Loose,
    block_delete: BlockDelete::Switch,
    arc_miss: ArcMiss::Grbl,
    whole_circle: false,
    turns: true,
    offsets: 9,
    cycles: Some(&HAL_CYCLES),
    ..PLAIN
};

const NO_CYCLES: &str = "drilling cycles are not built in here; write the moves out";

const NO_CYCLE_CODES: &[Entry] = &[
    (7300, Refused(NO_CYCLES)),
    (8100, Refused(NO_CYCLES)),
    (8200, Refused(NO_CYCLES)),
    (8300, Refused(NO_CYCLES)),
    (8400, Refused(NO_CYCLES)),
    (8500, Refused(NO_CYCLES)),
    (8600, Refused(NO_CYCLES)),
    (8900, Refused(NO_CYCLES)),
    (9800, Refused(NO_CYCLES)),
    (9900, Refused(NO_CYCLES)),
];

pub(super) static FLUIDNC: Rules = Rules {
    title: "FluidNC 3",
    source: "FluidNC wiki (Supported G-codes), GCode.cpp",
    g: &[
        BASE,
        RADIUS,
        MOTION_OFF,
        PROBES,
        OFFSETS,
        STORED_HOMES,
        DYNAMIC_LENGTH,
        FIRMWARE,
        NO_CYCLE_CODES,
    ],
    m: &[
        M_BASE,
        M_TOOLED,
        &[
            (6100, Refused(SET_TOOL)),
            (6200, Refused(PORTS)),
            (6300, Refused(PORTS)),
            (6400, Refused(PORTS)),
            (6500, Refused(PORTS)),
            (6600, Refused(PORTS)),
            (6700, Refused(PORTS)),
            (6800, Refused(PORTS)),
        ],
    ],
    letters: Letters::of(b"FIJKLNPQRSTXYZ"),
    length: LineLength::Significant(255),
    parentheses: Parentheses::Loose,
    block_delete: BlockDelete::No,
    arc_miss: ArcMiss::Grbl,
    whole_circle: false,
    ..PLAIN
};

pub(super) static CARBIDE: Rules = Rules {
    title: "Carbide Motion",
    source: "Carbide 3D documentation (Carbide Motion, Supported G-codes)",
    assumed: &["G10 and G92 are refused: the work zero is the operator's in Carbide Motion"],
    g: &[
        &[
            (5400, Nothing(Group::WorkOffset, NONE, "the one work zero")),
            (5500, Refused(ONE_ZERO)),
            (5600, Refused(ONE_ZERO)),
            (5700, Refused(ONE_ZERO)),
            (5800, Refused(ONE_ZERO)),
            (5900, Refused(ONE_ZERO)),
            (
                1000,
                Refused("the work zero is set in Carbide Motion, not by the program"),
            ),
            (
                9200,
                Refused("the work zero is set in Carbide Motion, not by the program"),
            ),
            (
                2800,
                Refused("where it goes is not documented here; use G53 G0 Z"),
            ),
            (
                3000,
                Refused("where it goes is not documented here; use G53 G0 Z"),
            ),
        ],
        BASE,
        RADIUS,
        MOTION_OFF,
        FIRMWARE_PATH,
        NO_CYCLE_CODES,
    ],
    m: &[M_BASE, M_TOOLED],
    letters: Letters::of(b"FIJKNPRSTXYZ"),
    refused: &[
        (b'D', NO_D),
        (
            b'H',
            "tool lengths are measured by Carbide Motion at M6; remove it",
        ),
    ],
    parentheses: Parentheses::Loose,
    block_delete: BlockDelete::No,
    arc_miss: ArcMiss::Grbl,
    whole_circle: false,
    ..PLAIN
};

/// Accepted and ignored, says the maker: the job would run at the zero that holds, not at the one that was meant.
const ONE_ZERO: &str = "there is one work zero here, and this would be passed over; remove it";

const FIRMWARE_PATH: &[Entry] = &[
    (9110, ArcDistance(Distance::Incremental)),
    (6100, Path(Path::Exact)),
    (4900, Nothing(Group::ToolLength, NONE, "tool length off")),
];
