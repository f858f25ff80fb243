//! Fanuc and those who read programs as Fanuc does: Haas, Mazak.

use super::Meaning::*;
use super::common::*;
use super::{BlockDelete, Entry, OffsetTwenty, Rules, Semicolon, Unit};
use crate::gcode::codes::{Group, Letters, Path};
use crate::gcode::cycle::CycleRules;

const P: Letters = Letters::of(b"P");
const NO_PRESET: &str = "here it puts the work coordinate system back at named axes (elsewhere it clears G92); use G52 X0 Y0 Z0 or G54";
const POINTLESS: &str = "numbers of X Y Z I J K R Q without a decimal point are refused: by parameter 3401#0 they count whole units or thousandths";

/// G54.1 P1 is the seventh work offset here.
const FURTHER: Entry = (
    5410,
    WorkOffsetBy {
        letter: b'P',
        base: 6,
        most: 300,
    },
);

const OWN: &[Entry] = &[
    FURTHER,
    LOCAL,
    PER_TURN,
    INVERSE_TIME,
    (
        500,
        Nothing(
            Group::Smoothing,
            P,
            "high-speed contour control on or off (P10000, P2, P0)",
        ),
    ),
    (
        510,
        Nothing(
            Group::Smoothing,
            Letters::of(b"QR"),
            "contour control on or off",
        ),
    ),
    (
        520,
        Refused("shape interpolation changes how the path is run; use G5.1"),
    ),
    (
        710,
        Refused("cylindrical interpolation needs a rotary axis"),
    ),
    (800, Nothing(Group::Smoothing, P, "look-ahead on or off")),
    (1210, Refused(POLAR)),
    (1310, Nothing(Group::Polar, NONE, "polar interpolation off")),
    (9210, Refused(NO_PRESET)),
    (
        6110,
        Refused("here it has another meaning than exact stop by block; use G61"),
    ),
    (1100, Nothing(Group::Data, NONE, "end of data input")),
];

const OWN_M: &[Entry] = &[
    (2900, Refused(TAPPING)),
    (9600, Refused("macro interrupts cannot be foreseen")),
];

/// Parameters 5114 (G73) and 5115 (G83) differ from machine to machine.
static FANUC_CYCLES: CycleRules = CycleRules {
    repeats: b"K",
    ..CycleRules::INDUSTRY
};

const LETTERS: Letters = Letters::of(b"FHIJKLNOPQRSTXYZ");
const POINTED: Letters = Letters::of(b"XYZIJKRQ");

pub(super) static FANUC: Rules = Rules {
    title: "Fanuc 0i-F and 30i, machining centre",
    source: "FANUC Series 0i-F Operator's Manual, Common and Machining Center (B-64604EN, -2EN)",
    assumed: &[
        POINTLESS,
        "G73 and G83 back off by 1 mm (parameters 5114, 5115)",
        "G30 goes to machine zero (parameter 1241)",
        "T of the same line is the tool that M6 puts in",
        "programs begin in G21, G90, G94, G98",
    ],
    g: &[
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        TABLE_LENGTH,
        PLAIN_PATHS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        OWN,
        INDUSTRY,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, M_ORIENT, M_PALLET, OWN_M],
    letters: Letters::of(b"FHIJKLNOPQRSTUXYZ"),
    pointed: Letters::of(b"XYZIJKRQU"),
    pointless: Letters::of(b"GHLNOPT"),
    tool_limit: 99_999_999,
    semicolon: Semicolon::EndOfBlock,
    block_delete: BlockDelete::Levels,
    dwell: &[
        (b'P', Unit::Milliseconds),
        (b'X', Unit::Pointed),
        (b'U', Unit::Pointed),
    ],
    dwell_words: "P (milliseconds), X or U (seconds, with a point)",
    machine_rapid: true,
    home_beside_motion: true,
    home_needs_axes: true,
    length_needs_h: true,
    twenty: OffsetTwenty::Further(300),
    offsets_add: true,
    offset_p: Some((0, 6, 300)),
    cycles: Some(&FANUC_CYCLES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};

const NO_POCKET: &str =
    "this pocket or pattern cycle makes many moves by the control's own rules; write them out";

const GEARS: &str = "it forces a gear; the control chooses by S, so remove it";
const AIR: &str = "it blows air at the tool, and no post here carries that over; remove it";
const THROUGH_SPINDLE: &str =
    "it is coolant through the spindle, and no post here carries that over; use M8 and M9";

const HAAS_OWN: &[Entry] = &[
    (
        15400,
        WorkOffsetBy {
            letter: b'P',
            base: 6,
            most: 99,
        },
    ),
    (
        5410,
        Refused("here the further work offsets are G154 P1 to P99; write that"),
    ),
    LOCAL,
    PER_TURN,
    INVERSE_TIME,
    (11000, WorkOffset(6)),
    (11100, WorkOffset(7)),
    (11200, WorkOffset(8)),
    (11300, WorkOffset(9)),
    (11400, WorkOffset(10)),
    (11500, WorkOffset(11)),
    (11600, WorkOffset(12)),
    (11700, WorkOffset(13)),
    (11800, WorkOffset(14)),
    (11900, WorkOffset(15)),
    (12000, WorkOffset(16)),
    (12100, WorkOffset(17)),
    (12200, WorkOffset(18)),
    (12300, WorkOffset(19)),
    (12400, WorkOffset(20)),
    (12500, WorkOffset(21)),
    (12600, WorkOffset(22)),
    (12700, WorkOffset(23)),
    (12800, WorkOffset(24)),
    (12900, WorkOffset(25)),
    (
        18700,
        Nothing(
            Group::Smoothing,
            Letters::of(b"PE"),
            "smoothness of corners",
        ),
    ),
    (
        510,
        Refused("high-speed contour control is G187 here; write that"),
    ),
    (800, Refused("look-ahead is always on here; remove it")),
    (1200, Refused(NO_POCKET)),
    (1300, Refused(NO_POCKET)),
    (3500, Refused("it measures a tool; do that at the control")),
    (7000, Refused(NO_POCKET)),
    (7100, Refused(NO_POCKET)),
    (7200, Refused(NO_POCKET)),
    (7700, Refused(BACK_BORING)),
    (10000, Refused(MIRROR)),
    (10100, Refused(MIRROR)),
    (10300, Refused("it limits look-ahead; use M0 or a dwell")),
    (14100, Refused(COMPENSATION)),
    (14300, Refused("tool length for five axes; use G43 H")),
    (15000, Refused(NO_POCKET)),
    (17400, Refused(TAPPING)),
    (18400, Refused(TAPPING)),
    (23400, Refused(TOOL_POINT)),
    (25400, Refused("dynamic work offsets need rotary axes")),
    (
        25500,
        Nothing(Group::Rotation, NONE, "dynamic work offset off"),
    ),
    (9210, Refused(NO_PRESET)),
];

const HAAS_M: &[Entry] = &[
    (
        3400,
        Nothing(Group::Chips, NONE, "coolant nozzle down a step"),
    ),
    (
        3500,
        Nothing(Group::Chips, NONE, "coolant nozzle up a step"),
    ),
    (4100, Refused(GEARS)),
    (4200, Refused(GEARS)),
    (8300, Refused(AIR)),
    (8400, Refused(AIR)),
    (8800, Refused(THROUGH_SPINDLE)),
    (8900, Refused(THROUGH_SPINDLE)),
    (
        9700,
        Refused("a local call takes P and stands by itself: M97 P and the line number"),
    ),
    (2900, Refused(TAPPING)),
    (3100, Nothing(Group::Chips, NONE, "chip conveyor on")),
    (3300, Nothing(Group::Chips, NONE, "chip conveyor off")),
    (5900, Refused(PORTS)),
    (6900, Refused(PORTS)),
    (
        9600,
        Refused("it jumps by a signal, which cannot be foreseen"),
    ),
];

/// Setting 22 (G73, G83) differs from machine to machine; setting 52 (G83 above R) is zero as shipped.
static HAAS_CYCLES: CycleRules = CycleRules {
    back: 1.27,
    repeats: b"L",
    dwell: Unit::ByPoint,
    ..CycleRules::INDUSTRY
};

pub(super) static HAAS: Rules = Rules {
    title: "Haas mill, NGC",
    source: "Haas Mill Operator's Manual, Next Generation Control (G-codes, M-codes, Settings)",
    assumed: &[
        "numbers of X Y Z I J K R Q F without a decimal point are refused: by settings 162 and 77 they count whole units or ten-thousandths",
        "G73 and G83 back off by 1.27 mm (setting 22), G83 returns to R itself (setting 52)",
        "G52 and G92 as with setting 33 on FANUC",
        "G30 goes to machine zero",
    ],
    g: &[
        HAAS_OWN,
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        TABLE_LENGTH,
        PLAIN_PATHS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        INDUSTRY,
    ],
    m: &[M_BASE, &[M_CHANGE], M_OVERRIDES, M_ORIENT, HAAS_M],
    letters: Letters::of(b"EFHIJKLNOPQRSTXYZ"),
    pointed: Letters::of(b"XYZIJKRQFE"),
    tool_limit: 200,
    semicolon: Semicolon::EndOfBlock,
    block_delete: BlockDelete::Levels,
    dwell: &[(b'P', Unit::ByPoint)],
    dwell_words: "P (seconds with a point, milliseconds without)",
    home_beside_motion: true,
    length_needs_h: true,
    twenty: OffsetTwenty::Further(99),
    offsets_add: true,
    cycles: Some(&HAAS_CYCLES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};

const MAZAK_CYCLE: &str =
    "Mazak's form of this cycle has words of its own (D, I, J, E); write the moves out";

const MAZAK_OWN: &[Entry] = &[
    (8200, Refused(MAZAK_CYCLE)),
    (8500, Refused(MAZAK_CYCLE)),
    (8600, Refused(MAZAK_CYCLE)),
    (8900, Refused(MAZAK_CYCLE)),
    (7100, Refused(MAZAK_CYCLE)),
    (7200, Refused(MAZAK_CYCLE)),
    (7500, Refused(MAZAK_CYCLE)),
    (7700, Refused(MAZAK_CYCLE)),
    (7800, Refused(MAZAK_CYCLE)),
    (7900, Refused(MAZAK_CYCLE)),
    (
        500,
        Nothing(Group::Smoothing, P, "high-speed machining mode"),
    ),
    (6110, Nothing(Group::Path, NONE, "geometry compensation on")),
    (6100, Path(Path::Stop)),
];

pub(super) static MAZAK: Rules = Rules {
    title: "Mazak, EIA/ISO",
    source: "Mazak Programming Manual, EIA/ISO (MAZATROL Matrix and SmoothX, milling)",
    assumed: &[
        "numbers of X Y Z I J K R Q without a decimal point are refused: by parameter F91 they count whole units or thousandths",
        "G73 and G83 back off by 1 mm (parameters F12, F13)",
        "G30 goes to machine zero (second reference point)",
    ],
    g: &[
        MAZAK_OWN,
        BASE,
        RADIUS,
        CYCLE_OFF,
        OFFSETS,
        TABLE_LENGTH,
        PLAIN_PATHS,
        RETRACTS,
        CYCLES,
        OTHER_CYCLES,
        OWN,
        INDUSTRY,
    ],
    m: &[M_BASE, M_TOOLED, M_OVERRIDES, M_ORIENT, OWN_M],
    letters: LETTERS,
    pointed: POINTED,
    pointless: Letters::of(b"GHLNOT"),
    semicolon: Semicolon::EndOfBlock,
    block_delete: BlockDelete::Levels,
    dwell: &[(b'P', Unit::Milliseconds), (b'X', Unit::Pointed)],
    dwell_words: "P (milliseconds) or X (seconds, with a point)",
    machine_rapid: true,
    home_beside_motion: true,
    home_needs_axes: true,
    length_needs_h: true,
    twenty: OffsetTwenty::Further(300),
    offsets_add: true,
    cycles: Some(&FANUC_CYCLES),
    other_m: BUILDERS_M,
    tool_named: true,
    ..PLAIN
};
